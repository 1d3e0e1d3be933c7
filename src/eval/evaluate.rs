//! Working out: from the typed tree to values.
//!
//! In: [`Checked`]. Out: the values of globals and jobs; `None` where something was wrong and has been said. Dimensions
//! are proved already; what remains is numbers: overflow, division by zero, ranges.

use super::choice::computed;
use super::value::{FieldOfRecord, Record, Value, ValueKind};
use crate::check::typed::{FieldValue, Function, Typed, TypedKind, UnitUse};
use crate::check::types::{SchemaId, Type};
use crate::check::{Checked, DEEPEST};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::{Sources, Span};
use crate::syntax::ast::BinaryOp;
use crate::units::{Dimension, Quantity};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Most steps of one compilation: a step is an expression worked out. Jobs take some thousands; two million take less
/// than a second. Functions that call functions twice double the steps with every line.
const MOST_STEPS: usize = 2_000_000;

/// What an expression can see beside the globals.
#[derive(Clone, Copy, Default)]
pub(super) struct Surroundings<'a> {
    /// The job's wavelength in metres.
    pub wavelength: Option<f64>,
    /// In a `check` line: the record.
    pub siblings: Option<&'a BTreeMap<String, FieldOfRecord>>,
    /// The arguments of the function, and the numbers of the lists with `for` around.
    pub locals: &'a [Value],
}

pub(super) struct Evaluator<'a> {
    pub checked: &'a Checked,
    pub sources: &'a Sources,
    pub globals: Vec<Option<Value>>,
    pub depth: usize,
    pub steps: usize,
    pub diagnostics: Vec<Diagnostic>,
}

/// The size of a unit in SI; a wavelength that is not there makes it `None`.
pub(super) fn unit_size(unit: &UnitUse, wavelength: Option<f64>) -> Option<f64> {
    if unit.waves == 0 {
        return Some(unit.factor);
    }
    wavelength.map(|wavelength| unit.factor * libm::pow(wavelength, f64::from(unit.waves)))
}

/// Arithmetic on numbers in SI; comparisons are not its business.
pub(super) fn arithmetic(operator: BinaryOp, a: f64, b: f64) -> f64 {
    match operator {
        BinaryOp::Add => a + b,
        BinaryOp::Subtract => a - b,
        BinaryOp::Multiply => a * b,
        BinaryOp::Divide => a / b,
        BinaryOp::Power => libm::pow(a, b),
        _ => f64::NAN,
    }
}

/// Whether the comparison holds. Numbers are compared as they are: a limit that is written is meant exactly.
pub(super) fn compares(operator: BinaryOp, a: f64, b: f64) -> bool {
    match operator {
        BinaryOp::Less => a < b,
        BinaryOp::LessEqual => a <= b,
        BinaryOp::Greater => a > b,
        BinaryOp::GreaterEqual => a >= b,
        BinaryOp::Equal => a == b,
        BinaryOp::NotEqual => a != b,
        _ => false,
    }
}

/// A function's value from numbers in SI.
pub(super) fn call(function: Function, arguments: &[f64]) -> f64 {
    let first = arguments.first().copied().unwrap_or(f64::NAN);
    let second = arguments.get(1).copied().unwrap_or(f64::NAN);
    match function {
        Function::Tangential | Function::Arc => first * second,
        Function::Sin => libm::sin(first),
        Function::Cos => libm::cos(first),
        Function::Tan => libm::tan(first),
        Function::Asin => libm::asin(first),
        Function::Acos => libm::acos(first),
        Function::Atan2 => libm::atan2(first, second),
        Function::Sqrt => libm::sqrt(first),
        Function::Abs => first.abs(),
        Function::Min => arguments.iter().copied().fold(first, f64::min),
        Function::Max => arguments.iter().copied().fold(first, f64::max),
        Function::Sum => arguments.iter().sum(),
        Function::Count => arguments.len() as f64,
        Function::Floor => first.floor(),
        Function::Ceil => first.ceil(),
        Function::Round => first.round(),
    }
}

impl Evaluator<'_> {
    pub(super) fn say(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// All globals, each after those that it uses.
    pub(super) fn globals(&mut self) {
        let checked = self.checked;
        for id in &checked.order {
            let global = &checked.globals[id.0];
            if global.parameters.is_some() {
                continue;
            }
            let value = self.value(&global.value, Surroundings::default());
            let what = format!("`{}`", global.name);
            let (restriction, usual) = (global.restriction.as_ref(), global.usual.as_ref());
            let kept = value.filter(|value| self.keeps_to(value, &global.ty, &what, restriction, usual));
            self.globals[id.0] = kept;
        }
    }

    /// Counts steps; nothing once there were too many, and that is said once.
    pub(super) fn spend(&mut self, typed: &Typed, steps: usize) -> Option<()> {
        self.steps = self.steps.saturating_add(steps);
        if self.steps <= MOST_STEPS {
            return Some(());
        }
        if !self.diagnostics.iter().any(|d| d.code == codes::E0415) {
            let message = format!("working out the values of this file takes more than {MOST_STEPS} steps");
            let help = "give what is worked out twice a name with `let`, and use the name";
            self.say(Diagnostic::error(codes::E0415, typed.span, message).help(help));
        }
        None
    }

    /// What the expression is worth; `None` if it is worth nothing and that has been said.
    pub(super) fn value(&mut self, typed: &Typed, around: Surroundings<'_>) -> Option<Value> {
        // Expressions are not so deep: only a schema whose default holds a record of itself, and hundreds of functions that
        // call each other, come here.
        if self.depth > 2 * DEEPEST {
            if !self.diagnostics.iter().any(|d| d.code == codes::E0412) {
                let message = format!("working this out goes more than {} values deep", 2 * DEEPEST);
                let help =
                    "a schema whose default holds a record of the same schema has no end: make the field optional";
                self.say(Diagnostic::error(codes::E0412, typed.span, message).help(help));
            }
            return None;
        }
        self.spend(typed, 1)?;
        self.depth += 1;
        let value = self.value_within(typed, around);
        self.depth -= 1;
        value
    }

    fn value_within(&mut self, typed: &Typed, around: Surroundings<'_>) -> Option<Value> {
        let span = typed.span;
        let of = |kind| Some(Value { span, kind });
        match &typed.kind {
            TypedKind::Number(number, unit) => {
                let size = match unit {
                    Some(unit) => unit_size(unit, around.wavelength)?,
                    None => 1.0,
                };
                self.number(typed, number * size, true)
            }
            TypedKind::Bool(value) => of(ValueKind::Bool(*value)),
            TypedKind::Text(text) => of(ValueKind::Text(text.clone())),
            TypedKind::File(path) => of(ValueKind::File(path.clone())),
            TypedKind::Symbol(symbol) => of(ValueKind::Symbol(symbol.clone())),
            TypedKind::None => of(ValueKind::None),
            TypedKind::Global(id) => {
                // The place is that of the use; what is inside keeps the places of the definition.
                Some(computed(self.globals.get(id.0)?.clone()?, typed))
            }
            TypedKind::Local(slot) => Some(computed(around.locals.get(*slot)?.clone(), typed)),
            TypedKind::If { branches, otherwise } => self.chosen(branches, otherwise, around),
            TypedKind::Comprehension { element, slot, over } => self.repeated(typed, (element, *slot), over, around),
            // Requirements are not worked out here; nothing else may name a result.
            TypedKind::Result(_) | TypedKind::Failed => None,
            TypedKind::SiblingField(name) => around.siblings?.get(name).map(|field| field.value.clone()),
            TypedKind::Record(schema, given) => self.record(*schema, BTreeMap::new(), given, span, around),
            TypedKind::With(base, given) => {
                let base = self.value(base, around);
                let ValueKind::Record(record) = base?.kind else { return None };
                let (schema, fields) = (record.schema, record.fields.clone());
                self.record(schema, fields, given, span, around)
            }
            TypedKind::Member(base, name) => {
                let base = self.value(base, around)?;
                match base.kind {
                    ValueKind::Record(record) => {
                        let value = record.fields.get(name)?.value.clone();
                        Some(Value { span, ..value })
                    }
                    _ => {
                        let message = format!("there is no `{name}` here: the record before it is `none`");
                        self.say(Diagnostic::error(codes::E0311, span, message));
                        None
                    }
                }
            }
            TypedKind::Call(callee, arguments) => self.called(typed, *callee, arguments, around),
            TypedKind::List(elements) => {
                let values: Vec<Option<Value>> = elements.iter().map(|element| self.value(element, around)).collect();
                self.listed(typed, values.into_iter().collect::<Option<Vec<Value>>>()?)
            }
            TypedKind::Range(from, to) => {
                let (from, to) = (self.value(from, around), self.value(to, around));
                let (from, to) = from.zip(to)?;
                if from.as_quantity()?.value > to.as_quantity()?.value {
                    let (low, high) = (self.shown(&from), self.shown(&to));
                    let message = format!("the range `{low} .. {high}` begins above its end");
                    let mended = format!("{high} .. {low}");
                    let diagnostic = Diagnostic::error(codes::E0409, span, message).help(format!("write `{mended}`"));
                    // Ends that stand elsewhere, under a name, are not written here.
                    let here = |end: &Value| {
                        span.file == end.span.file && span.start <= end.span.start && end.span.end <= span.end
                    };
                    self.say(match here(&from) && here(&to) {
                        true => {
                            let [a, b] = [&to, &from].map(|end| self.sources.slice(end.span));
                            diagnostic.suggest(span, format!("{a} .. {b}"))
                        }
                        false => diagnostic,
                    });
                    return None;
                }
                of(ValueKind::Range(Box::new(from), Box::new(to)))
            }
            TypedKind::Minus(inner) => {
                let written = matches!(inner.kind, TypedKind::Number(..));
                let quantity = self.value(inner, around)?.as_quantity()?;
                self.number(typed, -quantity.value, written)
            }
            TypedKind::Not(inner) => match self.value(inner, around)?.kind {
                ValueKind::Bool(value) => of(ValueKind::Bool(!value)),
                _ => None,
            },
            TypedKind::Binary(operator, left, right) => self.binary(typed, *operator, left, right, around),
        }
    }

    fn binary(
        &mut self,
        typed: &Typed,
        operator: BinaryOp,
        left: &Typed,
        right: &Typed,
        around: Surroundings<'_>,
    ) -> Option<Value> {
        let a = self.value(left, around);
        // `x != 0 and 1 / x < 3`: the second side counts only if the first leaves it open.
        match (operator, a.as_ref().map(|a| &a.kind)) {
            (BinaryOp::And, Some(ValueKind::Bool(false))) | (BinaryOp::Or, Some(ValueKind::Bool(true))) => {
                return Some(Value { span: typed.span, ..a? });
            }
            _ => {}
        }
        let b = self.value(right, around);
        let (a, b) = a.zip(b)?;
        let truth = |value| Some(Value { span: typed.span, kind: ValueKind::Bool(value) });
        match (&a.kind, &b.kind) {
            (ValueKind::Quantity { quantity: a, .. }, ValueKind::Quantity { quantity: b, .. }) => {
                if typed.ty == Type::Bool {
                    return truth(compares(operator, a.value, b.value));
                }
                if operator == BinaryOp::Divide && b.value == 0.0 {
                    let message = format!("{} divides by zero", self.quoted(typed.span));
                    self.say(Diagnostic::error(codes::E0406, typed.span, message).also(right.span, "this is zero"));
                    return None;
                }
                self.number(typed, arithmetic(operator, a.value, b.value), false)
            }
            (ValueKind::Bool(a), ValueKind::Bool(b)) => truth(match operator {
                BinaryOp::And => *a && *b,
                BinaryOp::Or => *a || *b,
                BinaryOp::Equal => a == b,
                _ => a != b,
            }),
            (a, b) => truth((a == b) == (operator == BinaryOp::Equal)),
        }
    }

    /// A short text as it stands, for a sentence; forty letters are still read at a glance.
    fn quoted(&self, span: Span) -> String {
        let text = self.sources.slice(span);
        let short = text.chars().count() <= 40 && !text.contains('\n');
        if short { format!("`{text}`") } else { "this expression".into() }
    }

    pub(super) fn number(&mut self, typed: &Typed, value: f64, written: bool) -> Option<Value> {
        if !value.is_finite() {
            let what = if value.is_nan() { "has no value" } else { "is too large for a number" };
            let message = format!("{} {what}", self.quoted(typed.span));
            self.say(Diagnostic::error(codes::E0406, typed.span, message));
            return None;
        }
        let dimension = typed.ty.dimension().unwrap_or(Dimension::NUMBER);
        // Minus zero would print as `-0`.
        let quantity = Quantity { value: value + 0.0, dimension };
        Some(Value { span: typed.span, kind: ValueKind::Quantity { quantity, written } })
    }

    /// A record: the given fields over those of `base`, then defaults; limits of what is given; the schema's checks.
    fn record(
        &mut self,
        schema: SchemaId,
        base: BTreeMap<String, FieldOfRecord>,
        given: &[FieldValue],
        span: Span,
        around: Surroundings<'_>,
    ) -> Option<Value> {
        let checked = self.checked;
        let shape = checked.vocabulary.schema(schema);
        let mut fields = base;
        let mut complete = true;
        for field in &shape.fields {
            let value = match given.iter().find(|given| given.name == field.name) {
                Some(given) => {
                    let value = self.value(&given.value, around);
                    let what = format!("`{}`", field.name);
                    let (restriction, usual) = (field.restriction.as_ref(), field.usual.as_ref());
                    let kept = value.filter(|value| self.keeps_to(value, &field.ty, &what, restriction, usual));
                    kept.map(|value| FieldOfRecord { value, is_default: false })
                }
                None if fields.contains_key(&field.name) => continue,
                // A default is said by the schema, not by the job: its place is the record that leaves it out.
                None => match &field.default {
                    Some(default) => self
                        .value(default, Surroundings::default())
                        .map(|value| FieldOfRecord { value: Value { span, ..value }, is_default: true }),
                    None if matches!(field.ty, Type::Optional(_)) => {
                        Some(FieldOfRecord { value: Value { span, kind: ValueKind::None }, is_default: true })
                    }
                    None => None,
                },
            };
            match value {
                Some(value) => drop(fields.insert(field.name.clone(), value)),
                None => complete = false,
            }
        }
        if !complete {
            return None;
        }
        for check in &shape.checks {
            self.check_line(check, &shape.name, &fields, span);
        }
        let record = Record { schema, name: shape.name.clone(), fields };
        Some(Value { span, kind: ValueKind::Record(Arc::new(record)) })
    }
}
