//! Limits: `where`, `usual`, whole numbers, and the `check` lines of schemas.

use super::evaluate::{Evaluator, Surroundings, compares};
use super::value::{FieldOfRecord, Value, ValueKind};
use crate::check::meant::{units_that_keep, was_percent};
use crate::check::typed::{Typed, TypedKind};
use crate::check::types::{Check, Limit, Type};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::BinaryOp;
use crate::units::show;
use std::collections::{BTreeMap, BTreeSet};

/// The largest whole number up to which every whole number is exact in double precision: 2^53.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

impl Evaluator<'_> {
    /// A value for people: as written if it stands there as a number, else with a unit of sensible size.
    pub(super) fn shown(&self, value: &Value) -> String {
        match &value.kind {
            ValueKind::Quantity { written: true, .. } => self.sources.slice(value.span).to_string(),
            ValueKind::Quantity { quantity, .. } => show(quantity.value, quantity.dimension),
            ValueKind::Bool(value) => value.to_string(),
            ValueKind::Text(text) | ValueKind::File(text) => format!("\"{text}\""),
            ValueKind::Symbol(symbol) => symbol.clone(),
            ValueKind::None => "none".into(),
            ValueKind::List(elements) => {
                format!("[{}]", elements.iter().map(|element| self.shown(element)).collect::<Vec<_>>().join(", "))
            }
            ValueKind::Range(from, to) => format!("{} .. {}", self.shown(from), self.shown(to)),
            ValueKind::Record(record) => record.name.clone(),
        }
    }

    /// Whether the value keeps to its type and limits. What breaks `where` is an error, what is outside `usual` a warning.
    pub(super) fn keeps_to(
        &mut self,
        value: &Value,
        ty: &Type,
        what: &str,
        restriction: Option<&Limit>,
        usual: Option<&Limit>,
    ) -> bool {
        let mut good = true;
        for number in value.numbers() {
            let Some(quantity) = number.as_quantity() else { continue };
            let shown = self.shown(number);
            if *ty.element() == Type::Integer && (quantity.value.fract() != 0.0 || quantity.value.abs() > LARGEST_WHOLE)
            {
                let message = format!("{what} is {shown}, and must be a whole number");
                self.say(Diagnostic::error(codes::E0407, number.span, message));
                good = false;
                continue;
            }
            if let Some(limit) = restriction
                && !self.is_within(quantity.value, limit)
            {
                let must = self.must_be(limit);
                let message = format!("{what} is {shown}, and must be {must}");
                let diagnostic = Diagnostic::error(codes::E0404, number.span, message);
                let diagnostic = self.with_value_that_keeps(diagnostic, number, &[Some(limit), usual], usual.is_some());
                self.say(diagnostic);
                good = false;
                continue;
            }
            if let Some(limit) = usual
                && !self.is_within(quantity.value, limit)
            {
                let message = format!("{what} is {shown}, which is unusual: it is mostly {}", limit.text);
                let diagnostic = Diagnostic::warning(codes::W0401, number.span, message);
                let mut diagnostic = self.with_value_that_keeps(diagnostic, number, &[restriction, Some(limit)], true);
                diagnostic.help.get_or_insert("check the number and its unit".into());
                self.say(diagnostic);
            }
        }
        good
    }

    /// The value that would pass, if the digits are right and only the unit is not.
    fn with_value_that_keeps(
        &mut self,
        diagnostic: Diagnostic,
        number: &Value,
        limits: &[Option<&Limit>],
        is_usual: bool,
    ) -> Diagnostic {
        let checked = self.checked;
        let ValueKind::Quantity { quantity, written: true } = &number.kind else { return diagnostic };
        let text = self.sources.slice(number.span).trim();
        let digits = text.trim_start_matches(['-', ' ']);
        let length = digits.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(digits.len());
        let Ok(value) = digits[..length].parse::<f64>() else { return diagnostic };
        let value = if text.starts_with('-') { -value } else { value };
        let mut keeps = |value: f64| limits.iter().flatten().all(|limit| self.is_within(value, limit));
        if quantity.dimension.is_number() {
            let percent = length == digits.len() && limits.iter().flatten().any(|limit| was_percent(limit));
            return match percent && keeps(value / 100.0) {
                true => diagnostic.help(format!("write `{text} %`")).suggest(number.span, format!("{text} %")),
                false => diagnostic,
            };
        }
        // Without a usual range nearly every unit would do.
        if !is_usual {
            return diagnostic;
        }
        let units =
            units_that_keep(&checked.vocabulary.units, quantity.dimension, (value, digits[length..].trim()), keeps);
        if units.is_empty() {
            return diagnostic;
        }
        let sign = if value < 0.0 { "-" } else { "" };
        let values: Vec<String> = units.iter().map(|unit| format!("`{sign}{} {unit}`", &digits[..length])).collect();
        diagnostic.help(format!("check the unit: {} would be usual", values.join(" or ")))
    }

    fn must_be(&self, limit: &Limit) -> String {
        if limit.is_range { format!("within {}", limit.text) } else { limit.text.clone() }
    }

    fn is_within(&mut self, value: f64, limit: &Limit) -> bool {
        limit.bounds.iter().all(|(operator, bound)| {
            let bound = self.value(bound, Surroundings::default()).and_then(|bound| bound.as_quantity());
            // A bound that could not be worked out has been reported; nothing is held against it.
            bound.is_none_or(|bound| compares(*operator, value, bound.value))
        })
    }

    /// A `check` line of a schema. Where a field it speaks of is `none`, it says nothing.
    pub(super) fn check_line(
        &mut self,
        check: &Check,
        schema: &str,
        fields: &BTreeMap<String, FieldOfRecord>,
        span: Span,
    ) {
        let (line, text) = (&check.condition, &check.text);
        let mut named = BTreeSet::new();
        siblings(line, &mut named);
        let known: Vec<(&String, &Value)> = named
            .iter()
            .filter_map(|name| fields.get_key_value(*name))
            .map(|(name, field)| (name, &field.value))
            .collect();
        if known.iter().any(|(_, value)| value.kind == ValueKind::None) {
            return;
        }
        let around = Surroundings { siblings: Some(fields), ..Surroundings::default() };
        let Some(Value { kind: ValueKind::Bool(false), .. }) = self.value(line, around) else { return };
        let facts: Vec<String> =
            known.iter().map(|(name, value)| format!("`{name}` is {}", self.shown(value))).collect();
        let reason = check.reason.as_ref().map_or_else(String::new, |reason| format!("{reason}: "));
        let message = format!("{reason}`{text}` must hold in `{schema}`, but {}", facts.join(" and "));
        let place = known.first().map_or(span, |(_, value)| value.span);
        // That one of the values is unusual besides is no second mistake.
        let same = |d: &Diagnostic| d.primary.as_ref().is_some_and(|p| known.iter().any(|(_, v)| v.span == p.span));
        self.diagnostics.retain(|d| d.code != codes::W0401 || !same(d));
        let mut diagnostic = Diagnostic::error(codes::E0405, place, message);
        for (name, value) in known.iter().skip(1) {
            diagnostic = diagnostic.also(value.span, format!("`{name}`"));
        }
        self.say(diagnostic);
    }
}

impl Evaluator<'_> {
    /// Every `assert` of every file, with what its sides came to.
    pub(super) fn asserts(&mut self) {
        let checked = self.checked;
        for assert in &checked.asserts {
            let condition = &assert.condition;
            let value = self.value(condition, Surroundings::default());
            let Some(Value { kind: ValueKind::Bool(false), .. }) = value else { continue };
            let mut facts = Vec::new();
            self.facts(condition, &mut facts);
            let text = self.sources.slice(condition.span).split_whitespace().collect::<Vec<_>>().join(" ");
            let message = format!("{}: `{text}` does not hold", assert.reason);
            let mut diagnostic = Diagnostic::error(codes::E0414, condition.span, message);
            if !facts.is_empty() {
                diagnostic = diagnostic.note(facts.join(", "));
            }
            self.say(diagnostic);
        }
    }

    /// What the sides of the comparisons that fail are worth, where they do not say it themselves.
    fn facts(&mut self, condition: &Typed, into: &mut Vec<String>) {
        match &condition.kind {
            TypedKind::Not(inner) => self.facts(inner, into),
            TypedKind::Binary(BinaryOp::And | BinaryOp::Or, a, b) => {
                for side in [a, b] {
                    let value = self.value(side, Surroundings::default());
                    if matches!(value, Some(Value { kind: ValueKind::Bool(false), .. })) {
                        self.facts(side, into);
                    }
                }
            }
            TypedKind::Binary(operator, a, b) => {
                let mut numbers = Vec::new();
                for side in [a, b] {
                    let value = self.value(side, Surroundings::default());
                    numbers.extend(value.and_then(|value| value.as_quantity()).map(|quantity| quantity.value));
                }
                // A millionth of a millionth: some thousand roundings of double precision.
                if let (BinaryOp::Equal, [a, b]) = (operator, numbers.as_slice())
                    && (a - b).abs() <= 1e-12 * a.abs().max(b.abs())
                {
                    into.push("the two differ only by rounding: write `abs(a - b) < …` with a small value".into());
                }
                for side in [a, b] {
                    if matches!(side.kind, TypedKind::Number(..) | TypedKind::Symbol(_) | TypedKind::Text(_)) {
                        continue;
                    }
                    let Some(value) = self.value(side, Surroundings::default()) else { continue };
                    into.push(format!("`{}` is {}", self.sources.slice(side.span), self.shown(&value)));
                }
            }
            _ => {}
        }
    }
}

/// The fields that a `check` line names.
fn siblings<'t>(typed: &'t Typed, into: &mut BTreeSet<&'t String>) {
    match &typed.kind {
        TypedKind::SiblingField(name) => drop(into.insert(name)),
        TypedKind::Member(inner, _) | TypedKind::Minus(inner) | TypedKind::Not(inner) => siblings(inner, into),
        TypedKind::Binary(_, a, b) | TypedKind::Range(a, b) => {
            siblings(a, into);
            siblings(b, into);
        }
        TypedKind::Call(_, arguments) | TypedKind::List(arguments) => {
            arguments.iter().for_each(|argument| siblings(argument, into));
        }
        TypedKind::With(base, given) => {
            siblings(base, into);
            given.iter().for_each(|field| siblings(&field.value, into));
        }
        TypedKind::Record(_, given) => given.iter().for_each(|field| siblings(&field.value, into)),
        TypedKind::If { branches, otherwise } => {
            for (condition, value) in branches {
                siblings(condition, into);
                siblings(value, into);
            }
            siblings(otherwise, into);
        }
        TypedKind::Comprehension { element, over, .. } => {
            siblings(element, into);
            siblings(over, into);
        }
        TypedKind::Number(..)
        | TypedKind::Bool(_)
        | TypedKind::Text(_)
        | TypedKind::File(_)
        | TypedKind::Symbol(_)
        | TypedKind::None
        | TypedKind::Global(_)
        | TypedKind::Local(_)
        | TypedKind::Result(_)
        | TypedKind::Failed => {}
    }
}
