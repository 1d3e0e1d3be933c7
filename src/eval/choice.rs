//! What is worked out once, many times, or not at all: calls, lists with `for`, `if`.

use super::evaluate::{Evaluator, Surroundings, call};
use super::value::{Value, ValueKind};
use crate::check::typed::{Callee, Function, GlobalId, Typed};
use crate::diagnostics::{Diagnostic, codes};
use crate::units::{Dimension, Quantity};
use std::sync::Arc;

/// Most values in one list. A job's lists are typed by people; measured data come in files. Lists of lists built by a
/// chain of `let`, and lists with `for`, could otherwise grow without bound.
pub(super) const MOST_LISTED: usize = 10_000;

impl Evaluator<'_> {
    pub(super) fn called(
        &mut self,
        typed: &Typed,
        callee: Callee,
        arguments: &[Typed],
        around: Surroundings<'_>,
    ) -> Option<Value> {
        let values: Vec<Option<Value>> = arguments.iter().map(|argument| self.value(argument, around)).collect();
        let values: Vec<Value> = values.into_iter().collect::<Option<_>>()?;
        match callee {
            Callee::BuiltIn(function) => self.built_in(typed, function, &values),
            Callee::Written(id) => self.written(typed, id, values),
        }
    }

    fn built_in(&mut self, typed: &Typed, function: Function, arguments: &[Value]) -> Option<Value> {
        let number = match (function, arguments) {
            (Function::Count, [list]) => match &list.kind {
                ValueKind::List(elements) => elements.len() as f64,
                _ => return None,
            },
            (Function::Sum, [list]) => match &list.kind {
                ValueKind::List(elements) => {
                    let numbers: Option<Vec<f64>> = elements.iter().map(|e| Some(e.as_quantity()?.value)).collect();
                    call(function, &numbers?)
                }
                _ => return None,
            },
            _ => {
                let numbers: Option<Vec<f64>> = arguments.iter().map(|a| Some(a.as_quantity()?.value)).collect();
                call(function, &numbers?)
            }
        };
        self.number(typed, number, false)
    }

    fn written(&mut self, typed: &Typed, id: GlobalId, arguments: Vec<Value>) -> Option<Value> {
        let checked = self.checked;
        let function = &checked.globals[id.0];
        for (value, (name, ty)) in arguments.iter().zip(function.parameters.iter().flatten()) {
            if !self.keeps_to(value, ty, &format!("the `{name}` of `{}`", function.name), None, None) {
                return None;
            }
        }
        let around = Surroundings { locals: &arguments, ..Surroundings::default() };
        let value = self.value(&function.value, around)?;
        let what = format!("the result of `{}`", function.name);
        self.keeps_to(&value, &function.ty, &what, None, None).then(|| computed(value, typed))
    }

    pub(super) fn chosen(
        &mut self,
        branches: &[(Typed, Typed)],
        otherwise: &Typed,
        around: Surroundings<'_>,
    ) -> Option<Value> {
        for (condition, value) in branches {
            match self.value(condition, around)?.kind {
                ValueKind::Bool(true) => return self.value(value, around),
                ValueKind::Bool(false) => {}
                _ => return None,
            }
        }
        self.value(otherwise, around)
    }

    pub(super) fn repeated(
        &mut self,
        typed: &Typed,
        (element, slot): (&Typed, usize),
        over: &Typed,
        around: Surroundings<'_>,
    ) -> Option<Value> {
        let ValueKind::Range(from, to) = self.value(over, around)?.kind else { return None };
        let (from, to) = (from.as_quantity()?.value, to.as_quantity()?.value);
        if from.fract() != 0.0 || to.fract() != 0.0 {
            let message = "`for` goes from one whole number to another, and an end of this range is none";
            self.say(Diagnostic::error(codes::E0407, over.span, message));
            return None;
        }
        // Compared as a number: the range may be larger than any list.
        if to - from + 1.0 > MOST_LISTED as f64 {
            self.say_too_long(typed);
            return None;
        }
        let mut locals = around.locals[..slot.min(around.locals.len())].to_vec();
        let mut elements = Vec::new();
        for step in 0..(to - from) as usize + 1 {
            let quantity = Quantity { value: from + step as f64, dimension: Dimension::NUMBER };
            locals.truncate(slot);
            locals.push(Value::quantity(over.span, quantity));
            elements.push(self.value(element, Surroundings { locals: &locals, ..around })?);
        }
        self.listed(typed, elements)
    }

    /// A list, unless it is too long.
    pub(super) fn listed(&mut self, typed: &Typed, elements: Vec<Value>) -> Option<Value> {
        let list = Value { span: typed.span, kind: ValueKind::List(Arc::new(elements)) };
        let count = list.count();
        if count > MOST_LISTED {
            self.say_too_long(typed);
            return None;
        }
        self.spend(typed, count)?;
        Some(list)
    }

    fn say_too_long(&mut self, typed: &Typed) {
        let message = format!("this list holds more than {MOST_LISTED} values");
        self.say(Diagnostic::error(codes::E0413, typed.span, message).help("put measured data into a file"));
    }
}

/// A value as worked out at another place: its digits do not stand there.
pub(super) fn computed(value: Value, at: &Typed) -> Value {
    let kind = match value.kind {
        ValueKind::Quantity { quantity, .. } => ValueKind::Quantity { quantity, written: false },
        other => other,
    };
    Value { span: at.span, kind }
}
