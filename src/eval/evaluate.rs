//! Working out: from the typed tree to values.
//!
//! In: [`Checked`]. Out: the values of globals and jobs; `None` where something was wrong and has been said. Dimensions
//! are proved already; what remains is numbers: overflow, division by zero, ranges.

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

/// Most values in one list. A job's lists are typed by people; measured data come in files. Lists of lists built by a
/// chain of `let` could otherwise grow without bound.
const MOST_LISTED: usize = 10_000;

/// What an expression can see beside the globals.
#[derive(Clone, Copy, Default)]
pub(super) struct Surroundings<'a> {
    /// The job's wavelength in metres.
    pub wavelength: Option<f64>,
    /// In a `check` line: the record.
    pub siblings: Option<&'a BTreeMap<String, FieldOfRecord>>,
}

pub(super) struct Evaluator<'a> {
    pub checked: &'a Checked,
    pub sources: &'a Sources,
    pub globals: Vec<Option<Value>>,
    pub depth: usize,
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
    match function {
        Function::Tangential | Function::Arc => first * arguments.get(1).copied().unwrap_or(f64::NAN),
        Function::Sin => libm::sin(first),
        Function::Cos => libm::cos(first),
        Function::Tan => libm::tan(first),
        Function::Sqrt => libm::sqrt(first),
        Function::Abs => first.abs(),
        Function::Min => arguments.iter().copied().fold(first, f64::min),
        Function::Max => arguments.iter().copied().fold(first, f64::max),
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
            let value = self.value(&global.value, Surroundings::default());
            let what = format!("`{}`", global.name);
            let kept = value.filter(|value| self.keeps_to(value, &global.ty, &what, global.restriction.as_ref(), None));
            self.globals[id.0] = kept;
        }
    }

    /// What the expression is worth; `None` if it is worth nothing and that has been said.
    pub(super) fn value(&mut self, typed: &Typed, around: Surroundings<'_>) -> Option<Value> {
        // Expressions are not so deep; only a schema whose default holds a record of itself comes here.
        if self.depth > 2 * DEEPEST {
            if !self.diagnostics.iter().any(|d| d.code == codes::E0412) {
                let message = "the default of a schema holds a record of the same schema, without end";
                self.say(Diagnostic::error(codes::E0412, typed.span, message).help("make the field optional"));
            }
            return None;
        }
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
                let value = self.globals.get(id.0)?.clone()?;
                let kind = match value.kind {
                    ValueKind::Quantity { quantity, .. } => ValueKind::Quantity { quantity, written: false },
                    other => other,
                };
                of(kind)
            }
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
            TypedKind::Call(function, arguments) => {
                let numbers = self.numbers(arguments, around)?;
                self.number(typed, call(*function, &numbers), false)
            }
            TypedKind::List(elements) => {
                let values: Vec<Option<Value>> = elements.iter().map(|element| self.value(element, around)).collect();
                let list = of(ValueKind::List(Arc::new(values.into_iter().collect::<Option<Vec<Value>>>()?)))?;
                if list.count() > MOST_LISTED {
                    let message = format!("this list holds more than {MOST_LISTED} values");
                    self.say(Diagnostic::error(codes::E0413, span, message).help("put measured data into a file"));
                    return None;
                }
                Some(list)
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

    fn numbers(&mut self, arguments: &[Typed], around: Surroundings<'_>) -> Option<Vec<f64>> {
        let values: Vec<Option<Value>> = arguments.iter().map(|argument| self.value(argument, around)).collect();
        values.into_iter().map(|value| Some(value?.as_quantity()?.value)).collect()
    }

    fn binary(
        &mut self,
        typed: &Typed,
        operator: BinaryOp,
        left: &Typed,
        right: &Typed,
        around: Surroundings<'_>,
    ) -> Option<Value> {
        let (a, b) = (self.value(left, around), self.value(right, around));
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

    fn number(&mut self, typed: &Typed, value: f64, written: bool) -> Option<Value> {
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
        for (line, text) in &shape.checks {
            self.check_line(line, text, &shape.name, &fields, span);
        }
        let record = Record { schema, name: shape.name.clone(), fields };
        Some(Value { span, kind: ValueKind::Record(Arc::new(record)) })
    }
}
