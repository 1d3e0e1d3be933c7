//! Values of data: names replaced by the literals they stand for, and literals by their numbers.
//!
//! A literal may be moved into a `CONST`, or into a `VAR` of the routine that uses it. That is sound because every
//! statement is compared with what the job asks for, so that no assignment can hide anywhere; data of other kinds, which
//! other programs can reach, are refused by [`super::declarations`].

use super::syntax::{Data, Expression};

/// Longest chain of names that stand for names.
const MOST_STEPS: usize = 8;

/// Most parts of one value, so that lists of names of lists cannot grow without end; tooldata has 18 numbers.
const MOST_PARTS: usize = 200;

/// Data that can be seen at a place, innermost first.
#[derive(Clone, Copy)]
pub struct Scope<'a> {
    pub levels: &'a [&'a [Data]],
}

impl Scope<'_> {
    /// The declaration of `name`; capitals do not matter.
    pub fn find(&self, name: &str) -> Option<&Data> {
        self.levels.iter().flat_map(|level| level.iter()).find(|data| data.name.eq_ignore_ascii_case(name))
    }

    /// `expression` with the names of data replaced by their values; other names stay.
    pub fn resolve(&self, expression: &Expression) -> Expression {
        self.resolve_parts(expression, MOST_STEPS, &mut { MOST_PARTS })
    }

    fn resolve_parts(&self, expression: &Expression, steps: usize, parts: &mut usize) -> Expression {
        if *parts == 0 {
            return expression.clone();
        }
        *parts -= 1;
        match expression {
            Expression::Name(name) if steps > 0 => match self.find(name).and_then(|data| data.value.as_ref()) {
                Some(value) => self.resolve_parts(value, steps - 1, parts),
                None => expression.clone(),
            },
            Expression::List(items) => {
                Expression::List(items.iter().map(|item| self.resolve_parts(item, steps, parts)).collect())
            }
            Expression::Unary("-", inner) => match self.resolve_parts(inner, steps, parts) {
                Expression::Number(value) => Expression::Number(-value),
                other => Expression::Unary("-", Box::new(other)),
            },
            other => other.clone(),
        }
    }

    /// The numbers of a value of the given [`shape`], or `None` when it has another.
    pub fn numbers(&self, expression: &Expression, wanted: &str) -> Option<Vec<f64>> {
        let mut found = Flat::default();
        found.add(&self.resolve(expression));
        (found.shape == wanted).then_some(found.numbers)
    }

    /// As [`Scope::numbers`], with the texts.
    pub fn numbers_and_texts(&self, expression: &Expression, wanted: &str) -> Option<(Vec<f64>, Vec<String>)> {
        let mut found = Flat::default();
        found.add(&self.resolve(expression));
        (found.shape == wanted).then_some((found.numbers, found.texts))
    }
}

/// Shapes of RAPID's records: `n` a number, `b` a truth value (counted as number 1 or 0), `s` a text.
pub mod shape {
    pub const NUM: &str = "n";
    pub const STRING: &str = "s";
    pub const BOOL: &str = "b";
    pub const POS: &str = "[nnn]";
    pub const POSE: &str = "[[nnn][nnnn]]";
    pub const ROBTARGET: &str = "[[nnn][nnnn][nnnn][nnnnnn]]";
    pub const JOINTTARGET: &str = "[[nnnnnn][nnnnnn]]";
    pub const SPEEDDATA: &str = "[nnnn]";
    pub const ZONEDATA: &str = "[bnnnnnn]";
    pub const TOOLDATA: &str = "[b[[nnn][nnnn]][n[nnn][nnnn]nnn]]";
    pub const WOBJDATA: &str = "[bbs[[nnn][nnnn]][[nnn][nnnn]]]";

    /// The shape that data of a type must have; `None` for types that the programs do not use.
    pub fn of_type(name: &str) -> Option<&'static str> {
        const TYPES: &[(&str, &str)] = &[
            ("num", NUM),
            ("string", STRING),
            ("bool", BOOL),
            ("pos", POS),
            ("pose", POSE),
            ("orient", "[nnnn]"),
            ("confdata", "[nnnn]"),
            ("extjoint", "[nnnnnn]"),
            ("robjoint", "[nnnnnn]"),
            ("robtarget", ROBTARGET),
            ("jointtarget", JOINTTARGET),
            ("speeddata", SPEEDDATA),
            ("zonedata", ZONEDATA),
            ("loaddata", "[n[nnn][nnnn]nnn]"),
            ("tooldata", TOOLDATA),
            ("wobjdata", WOBJDATA),
        ];
        TYPES.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)).map(|(_, shape)| *shape)
    }
}

/// A value taken apart.
#[derive(Default)]
struct Flat {
    shape: String,
    numbers: Vec<f64>,
    texts: Vec<String>,
}

impl Flat {
    fn add(&mut self, expression: &Expression) {
        match expression {
            Expression::Number(value) => {
                self.shape.push('n');
                self.numbers.push(*value);
            }
            Expression::Text(text) => {
                self.shape.push('s');
                self.texts.push(text.clone());
            }
            Expression::Name(name) if name.eq_ignore_ascii_case("TRUE") || name.eq_ignore_ascii_case("FALSE") => {
                self.shape.push('b');
                self.numbers.push(f64::from(u8::from(name.eq_ignore_ascii_case("TRUE"))));
            }
            Expression::List(items) => {
                self.shape.push('[');
                for item in items {
                    self.add(item);
                }
                self.shape.push(']');
            }
            // Nothing that could be known without running the program.
            _ => self.shape.push('?'),
        }
    }
}
