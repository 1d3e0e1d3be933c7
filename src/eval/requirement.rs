//! Requirements: the lines of `require`, kept until their results are known.
//!
//! In: a checked condition, with everything worked out that does not need a result. Out: [`Requirement`], which the last
//! pass gives the results to.

use super::evaluate::{Evaluator, Surroundings, arithmetic, call, compares, unit_size};
use super::value::ValueKind;
use crate::check::typed::{Function, Typed, TypedKind};
use crate::source::Span;
use crate::syntax::ast::BinaryOp;
use crate::units::{Dimension, format, show};
use std::collections::{BTreeMap, BTreeSet};

/// One line of `require`.
#[derive(Clone, Debug, PartialEq)]
pub struct Requirement {
    /// As written.
    pub text: String,
    pub span: Span,
    condition: Condition,
    shown: Option<Shown>,
}

/// What a requirement comes to.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The left side, in the unit that the line uses; `None` while it is pending.
    pub value: Option<String>,
    /// `None` while a result that it needs is not known.
    pub met: Option<bool>,
}

/// The side that is shown, and in what unit.
#[derive(Clone, Debug, PartialEq)]
struct Shown {
    term: Term,
    dimension: Dimension,
    /// The unit's name and its size in SI.
    unit: Option<(String, f64)>,
}

/// A number in SI.
#[derive(Clone, Debug, PartialEq)]
enum Term {
    Known(f64),
    Result(String),
    Minus(Box<Term>),
    Call(Function, Vec<Term>),
    Binary(BinaryOp, Box<Term>, Box<Term>),
}

#[derive(Clone, Debug, PartialEq)]
enum Condition {
    Known(bool),
    Compare(BinaryOp, Term, Term),
    Not(Box<Condition>),
    And(Box<Condition>, Box<Condition>),
    Or(Box<Condition>, Box<Condition>),
}

impl Requirement {
    /// What it comes to with these results: SI numbers by their path without `result.` (`predicted.rms`).
    pub fn evaluate(&self, results: &BTreeMap<String, f64>) -> Outcome {
        let value = self.shown.as_ref().and_then(|shown| {
            let value = shown.term.value(results)?;
            Some(match &shown.unit {
                Some((unit, size)) => format!("{} {unit}", format::number(value / size)),
                None => show(value, shown.dimension),
            })
        });
        Outcome { value, met: self.condition.holds(results) }
    }

    /// The results that it needs, without `result.`
    pub fn results(&self) -> BTreeSet<&str> {
        let mut names = BTreeSet::new();
        self.condition.results(&mut names);
        names
    }
}

impl Term {
    fn value(&self, results: &BTreeMap<String, f64>) -> Option<f64> {
        Some(match self {
            Term::Known(value) => *value,
            Term::Result(name) => *results.get(name)?,
            Term::Minus(inner) => -inner.value(results)?,
            Term::Call(function, arguments) => {
                let arguments: Option<Vec<f64>> = arguments.iter().map(|argument| argument.value(results)).collect();
                call(*function, &arguments?)
            }
            Term::Binary(operator, a, b) => arithmetic(*operator, a.value(results)?, b.value(results)?),
        })
    }

    fn results<'t>(&'t self, into: &mut BTreeSet<&'t str>) {
        match self {
            Term::Known(_) => {}
            Term::Result(name) => drop(into.insert(name)),
            Term::Minus(inner) => inner.results(into),
            Term::Call(_, arguments) => arguments.iter().for_each(|argument| argument.results(into)),
            Term::Binary(_, a, b) => {
                a.results(into);
                b.results(into);
            }
        }
    }
}

impl Condition {
    /// A number that is not one (a result divided by zero) meets nothing.
    fn holds(&self, results: &BTreeMap<String, f64>) -> Option<bool> {
        match self {
            Condition::Known(value) => Some(*value),
            Condition::Compare(operator, a, b) => {
                let (a, b) = (a.value(results)?, b.value(results)?);
                Some(a.is_finite() && b.is_finite() && compares(*operator, a, b))
            }
            Condition::Not(inner) => inner.holds(results).map(|holds| !holds),
            // One side can decide while the other is pending.
            Condition::And(a, b) => match (a.holds(results), b.holds(results)) {
                (Some(false), _) | (_, Some(false)) => Some(false),
                (Some(true), Some(true)) => Some(true),
                _ => None,
            },
            Condition::Or(a, b) => match (a.holds(results), b.holds(results)) {
                (Some(true), _) | (_, Some(true)) => Some(true),
                (Some(false), Some(false)) => Some(false),
                _ => None,
            },
        }
    }

    fn results<'t>(&'t self, into: &mut BTreeSet<&'t str>) {
        match self {
            Condition::Known(_) => {}
            Condition::Compare(_, a, b) => {
                a.results(into);
                b.results(into);
            }
            Condition::Not(inner) => inner.results(into),
            Condition::And(a, b) | Condition::Or(a, b) => {
                a.results(into);
                b.results(into);
            }
        }
    }
}

impl Evaluator<'_> {
    /// The requirement; `None` if something in it was wrong, which has been said.
    pub(super) fn requirement(&mut self, typed: &Typed, wavelength: Option<f64>) -> Option<Requirement> {
        let condition = self.condition(typed, wavelength)?;
        let shown = self.shown_side(typed, wavelength);
        // One blank where the job aligns its lines or breaks them.
        let text = self.sources.slice(typed.span).split_whitespace().collect::<Vec<_>>().join(" ");
        Some(Requirement { text, span: typed.span, condition, shown })
    }

    fn condition(&mut self, typed: &Typed, wavelength: Option<f64>) -> Option<Condition> {
        if !needs_result(typed) {
            let around = Surroundings { wavelength, siblings: None };
            return match self.value(typed, around)?.kind {
                ValueKind::Bool(value) => Some(Condition::Known(value)),
                _ => None,
            };
        }
        match &typed.kind {
            TypedKind::Not(inner) => Some(Condition::Not(Box::new(self.condition(inner, wavelength)?))),
            TypedKind::Binary(BinaryOp::And, a, b) => {
                let (a, b) = (self.condition(a, wavelength), self.condition(b, wavelength));
                Some(Condition::And(Box::new(a?), Box::new(b?)))
            }
            TypedKind::Binary(BinaryOp::Or, a, b) => {
                let (a, b) = (self.condition(a, wavelength), self.condition(b, wavelength));
                Some(Condition::Or(Box::new(a?), Box::new(b?)))
            }
            TypedKind::Binary(operator, a, b) => {
                let (a, b) = (self.term(a, wavelength), self.term(b, wavelength));
                Some(Condition::Compare(*operator, a?, b?))
            }
            _ => None,
        }
    }

    fn term(&mut self, typed: &Typed, wavelength: Option<f64>) -> Option<Term> {
        if !needs_result(typed) {
            let around = Surroundings { wavelength, siblings: None };
            return Some(Term::Known(self.value(typed, around)?.as_quantity()?.value));
        }
        match &typed.kind {
            TypedKind::Result(name) => Some(Term::Result(name.clone())),
            TypedKind::Minus(inner) => Some(Term::Minus(Box::new(self.term(inner, wavelength)?))),
            TypedKind::Call(function, arguments) => {
                let terms: Vec<Option<Term>> = arguments.iter().map(|a| self.term(a, wavelength)).collect();
                Some(Term::Call(*function, terms.into_iter().collect::<Option<Vec<Term>>>()?))
            }
            TypedKind::Binary(operator, a, b) => {
                let (a, b) = (self.term(a, wavelength), self.term(b, wavelength));
                Some(Term::Binary(*operator, Box::new(a?), Box::new(b?)))
            }
            _ => None,
        }
    }

    /// The first comparison's side that holds a result, in the first unit of its dimension that the other side writes.
    fn shown_side(&mut self, typed: &Typed, wavelength: Option<f64>) -> Option<Shown> {
        match &typed.kind {
            TypedKind::Not(inner) => self.shown_side(inner, wavelength),
            TypedKind::Binary(BinaryOp::And | BinaryOp::Or, a, b) => {
                self.shown_side(a, wavelength).or_else(|| self.shown_side(b, wavelength))
            }
            TypedKind::Binary(_, a, b) => {
                let (side, other) = if needs_result(a) { (a, b) } else { (b, a) };
                let dimension = side.ty.dimension()?;
                let unit = first_unit(other, dimension, wavelength).or_else(|| first_unit(side, dimension, wavelength));
                Some(Shown { term: self.term(side, wavelength)?, dimension, unit })
            }
            _ => None,
        }
    }
}

fn needs_result(typed: &Typed) -> bool {
    match &typed.kind {
        TypedKind::Result(_) => true,
        TypedKind::Minus(inner) | TypedKind::Not(inner) => needs_result(inner),
        TypedKind::Binary(_, a, b) => needs_result(a) || needs_result(b),
        TypedKind::Call(_, arguments) => arguments.iter().any(needs_result),
        _ => false,
    }
}

fn first_unit(typed: &Typed, dimension: Dimension, wavelength: Option<f64>) -> Option<(String, f64)> {
    match &typed.kind {
        TypedKind::Number(_, Some(unit)) if typed.ty.dimension() == Some(dimension) => {
            Some((unit.text.clone(), unit_size(unit, wavelength)?))
        }
        TypedKind::Minus(inner) => first_unit(inner, dimension, wavelength),
        TypedKind::Binary(_, a, b) => {
            first_unit(a, dimension, wavelength).or_else(|| first_unit(b, dimension, wavelength))
        }
        TypedKind::Call(_, arguments) => arguments.iter().find_map(|a| first_unit(a, dimension, wavelength)),
        _ => None,
    }
}
