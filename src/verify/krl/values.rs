//! Values of data: names replaced by the literals they stand for, and literals by their numbers.
//!
//! A literal may be moved into the file's data. That is sound because every statement is compared with what the job asks
//! for, so that no assignment can hide anywhere, and data that other programs can reach are not read.

use super::syntax::{Data, Expression};

/// Longest chain of names that stand for names.
const MOST_STEPS: usize = 8;

/// Most parts of one value; a load has thirteen.
const MOST_PARTS: usize = 100;

/// Data that can be seen at a place.
#[derive(Clone, Copy)]
pub struct Scope<'a> {
    pub data: &'a [Data],
}

/// Components of KRL's records, in the order of their numbers here.
pub mod components {
    pub const AXIS: &[&str] = &["A1", "A2", "A3", "A4", "A5", "A6"];
    pub const FRAME: &[&str] = &["X", "Y", "Z", "A", "B", "C"];
    pub const LOAD: &[&str] = &["M", "CM.X", "CM.Y", "CM.Z", "CM.A", "CM.B", "CM.C", "J.X", "J.Y", "J.Z"];
    pub const PLACE: &[&str] = &super::super::syntax::TARGET;
    /// A number that is no record.
    pub const NUMBER: &[&str] = &[""];

    /// The components of data of a type; `None` for types that the programs do not use.
    pub fn of_type(name: &str) -> Option<&'static [&'static str]> {
        const TYPES: &[(&str, &[&str])] =
            &[("INT", NUMBER), ("REAL", NUMBER), ("AXIS", AXIS), ("FRAME", FRAME), ("POS", PLACE), ("LOAD", LOAD)];
        TYPES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, components)| *components)
    }
}

impl Scope<'_> {
    /// The declaration of `name`; capitals do not matter.
    pub fn find(&self, name: &str) -> Option<&Data> {
        self.data.iter().find(|data| data.name.eq_ignore_ascii_case(name))
    }

    /// `expression` with a name of data replaced by its value; other names stay.
    pub fn resolve(&self, expression: &Expression) -> Expression {
        let mut found = expression.clone();
        for _ in 0..MOST_STEPS {
            let Expression::Name(name) = &found else { break };
            match self.find(name).and_then(|data| data.value.as_ref()) {
                Some(value) => found = value.clone(),
                None => break,
            }
        }
        found
    }

    /// The numbers of a record's components in their order, or `None` when others are there, or one is missing or no
    /// number.
    pub fn numbers(&self, expression: &Expression, components: &[&str]) -> Option<Vec<f64>> {
        let mut parts = Vec::new();
        self.take_apart(expression, String::new(), &mut parts);
        if parts.len() != components.len() {
            return None;
        }
        let find = |component: &&str| parts.iter().find(|(label, _)| label.eq_ignore_ascii_case(component));
        components.iter().map(|component| find(component).and_then(|(_, value)| *value)).collect()
    }

    fn take_apart(&self, expression: &Expression, label: String, parts: &mut Vec<(String, Option<f64>)>) {
        if parts.len() > MOST_PARTS {
            return;
        }
        match self.resolve(expression) {
            Expression::Aggregate(items) if label.len() < 8 => {
                for (component, value) in &items {
                    let inner = if label.is_empty() { component.clone() } else { format!("{label}.{component}") };
                    self.take_apart(value, inner, parts);
                }
            }
            Expression::Number(value) => parts.push((label, Some(value))),
            _ => parts.push((label, None)),
        }
    }
}
