//! Requirements: the lines of `require`, kept until their results are known.
//!
//! In: a checked condition, with everything worked out that does not need a result. Out: [`Requirement`], which the last
//! pass gives the results to.

use super::evaluate::{Evaluator, Surroundings, arithmetic, call, compares, unit_size};
use super::value::{Value, ValueKind};
use crate::check::typed::{Callee, Function, Typed, TypedKind};
use crate::check::types::Type;
use crate::diagnostics::{Diagnostic, codes};
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
    /// What it is compared with.
    other: Option<Term>,
    dimension: Dimension,
    unit: Option<Written>,
}

/// How the job writes values of that dimension.
#[derive(Clone, Debug, PartialEq)]
struct Written {
    /// The unit's name and its size in SI.
    unit: String,
    size: f64,
    /// The number before the unit where the other side divides it, as in `1 wave / 100`.
    divided: Option<f64>,
}

impl Written {
    /// `value` so that one sees on which side of `limit` it lies.
    fn show(&self, value: f64, limit: Option<f64>) -> String {
        let unit = &self.unit;
        match self.divided {
            Some(number) if value > 0.0 => {
                let whole = number * self.size;
                let divisor = enough_digits(whole / value, limit.map(|limit| whole / limit));
                format!("{} {unit} / {divisor}", format::significant(number, 4))
            }
            _ => format!("{} {unit}", enough_digits(value / self.size, limit.map(|limit| limit / self.size))),
        }
    }
}

/// A number in SI.
#[derive(Clone, Debug, PartialEq)]
enum Term {
    Known(f64),
    Result(String),
    Minus(Box<Term>),
    Call(Function, Vec<Term>),
    Binary(BinaryOp, Box<Term>, Box<Term>),
    If(Box<Condition>, Box<Term>, Box<Term>),
}

#[derive(Clone, Debug, PartialEq)]
enum Condition {
    Known(bool),
    Compare(BinaryOp, Term, Term),
    Not(Box<Condition>),
    And(Box<Condition>, Box<Condition>),
    Or(Box<Condition>, Box<Condition>),
}

/// A local value of a function: known already, or waiting for results.
#[derive(Clone, Debug)]
enum Local {
    Known(Value),
    Term(Term),
    Condition(Condition),
}

/// What the names around an expression mean.
#[derive(Clone, Copy, Default)]
struct Scope<'s> {
    wavelength: Option<f64>,
    locals: &'s [Local],
    /// The same for an expression that needs no result; something stands in for what waits.
    values: &'s [Value],
}

impl Requirement {
    /// What it comes to with these results: SI numbers by their path without `result.` (`predicted.rms`).
    pub fn evaluate(&self, results: &BTreeMap<String, f64>) -> Outcome {
        let value = self.shown.as_ref().and_then(|shown| {
            let value = shown.term.value(results)?;
            Some(match &shown.unit {
                Some(written) => {
                    let limit = shown.other.as_ref().and_then(|other| other.value(results));
                    written.show(value, limit)
                }
                None => show(value, shown.dimension),
            })
        });
        let met = self.condition.holds(results);
        // A condition without a comparison of its own (a function that gives `true` or `false`) shows that.
        let value = value.or_else(|| met.filter(|_| self.shown.is_none()).map(|met| met.to_string()));
        Outcome { value, met }
    }

    /// The results that it needs, without `result.`
    pub fn results(&self) -> BTreeSet<&str> {
        let mut names = BTreeSet::new();
        self.condition.results(&mut names);
        names
    }
}

/// A result with four digits, which is what a plan is worth; with more where they decide on which side of its limit it lies.
fn enough_digits(value: f64, limit: Option<f64>) -> String {
    let sides = |value: f64| limit.map(|limit| (value < limit, value > limit));
    let shown = |digits: usize| format::significant(value, digits);
    let same = |digits: &usize| shown(*digits).parse::<f64>().is_ok_and(|rounded| sides(rounded) == sides(value));
    shown((4..17).find(same).unwrap_or(17))
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
            Term::If(condition, a, b) => match condition.holds(results)? {
                true => a.value(results)?,
                false => b.value(results)?,
            },
        })
    }

    /// How many pieces it has.
    fn size(&self) -> usize {
        match self {
            Term::Known(_) | Term::Result(_) => 1,
            Term::Minus(inner) => 1 + inner.size(),
            Term::Call(_, arguments) => 1 + arguments.iter().map(Term::size).sum::<usize>(),
            Term::Binary(_, a, b) => 1 + a.size() + b.size(),
            Term::If(condition, a, b) => 1 + condition.size() + a.size() + b.size(),
        }
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
            Term::If(condition, a, b) => {
                condition.results(into);
                a.results(into);
                b.results(into);
            }
        }
    }
}

impl Condition {
    fn size(&self) -> usize {
        match self {
            Condition::Known(_) => 1,
            Condition::Compare(_, a, b) => 1 + a.size() + b.size(),
            Condition::Not(inner) => 1 + inner.size(),
            Condition::And(a, b) | Condition::Or(a, b) => 1 + a.size() + b.size(),
        }
    }

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
        let scope = Scope { wavelength, ..Scope::default() };
        let condition = self.condition(typed, scope)?;
        let shown = self.shown_side(typed, scope);
        // One blank where the job aligns its lines or breaks them.
        let text = self.sources.slice(typed.span).split_whitespace().collect::<Vec<_>>().join(" ");
        Some(Requirement { text, span: typed.span, condition, shown })
    }

    /// What needs no result, worked out.
    fn known(&mut self, typed: &Typed, scope: Scope<'_>) -> Option<Value> {
        let Scope { wavelength, values, .. } = scope;
        self.value(typed, Surroundings { wavelength, siblings: None, locals: values })
    }

    fn condition(&mut self, typed: &Typed, scope: Scope<'_>) -> Option<Condition> {
        if !needs_result(typed, scope.locals) {
            return match self.known(typed, scope)?.kind {
                ValueKind::Bool(value) => Some(Condition::Known(value)),
                _ => None,
            };
        }
        self.spend(typed, 1)?;
        match &typed.kind {
            TypedKind::Not(inner) => Some(Condition::Not(Box::new(self.condition(inner, scope)?))),
            TypedKind::Binary(BinaryOp::And, a, b) => {
                let (a, b) = (self.condition(a, scope), self.condition(b, scope));
                Some(Condition::And(Box::new(a?), Box::new(b?)))
            }
            TypedKind::Binary(BinaryOp::Or, a, b) => {
                let (a, b) = (self.condition(a, scope), self.condition(b, scope));
                Some(Condition::Or(Box::new(a?), Box::new(b?)))
            }
            TypedKind::Binary(operator, a, b) if a.ty.dimension().is_some() => {
                let (a, b) = (self.term(a, scope), self.term(b, scope));
                Some(Condition::Compare(*operator, a?, b?))
            }
            TypedKind::If { branches, otherwise } => {
                let mut whole = self.condition(otherwise, scope)?;
                for (condition, value) in branches.iter().rev() {
                    let (condition, value) = (self.condition(condition, scope)?, self.condition(value, scope)?);
                    self.spend(typed, condition.size())?;
                    let not = Condition::Not(Box::new(condition.clone()));
                    whole = Condition::Or(
                        Box::new(Condition::And(Box::new(condition), Box::new(value))),
                        Box::new(Condition::And(Box::new(not), Box::new(whole))),
                    );
                }
                Some(whole)
            }
            TypedKind::Call(Callee::Written(id), arguments) => {
                let body = &self.checked.globals[id.0].value;
                self.in_function(arguments, scope, |evaluator, scope| evaluator.condition(body, scope))
            }
            TypedKind::Local(slot) => match scope.locals.get(*slot)? {
                Local::Condition(condition) => {
                    self.spend(typed, condition.size())?;
                    Some(condition.clone())
                }
                _ => None,
            },
            _ => self.say_unfit(typed),
        }
    }

    fn term(&mut self, typed: &Typed, scope: Scope<'_>) -> Option<Term> {
        if !needs_result(typed, scope.locals) {
            return Some(Term::Known(self.known(typed, scope)?.as_quantity()?.value));
        }
        self.spend(typed, 1)?;
        match &typed.kind {
            TypedKind::Result(name) => Some(Term::Result(name.clone())),
            TypedKind::Minus(inner) => Some(Term::Minus(Box::new(self.term(inner, scope)?))),
            TypedKind::Call(Callee::BuiltIn(function), arguments) => {
                // The elements of a list are as good as arguments.
                let arguments = match arguments.as_slice() {
                    [Typed { kind: TypedKind::List(elements), .. }] => elements,
                    arguments => arguments,
                };
                let terms: Vec<Option<Term>> = arguments.iter().map(|a| self.term(a, scope)).collect();
                Some(Term::Call(*function, terms.into_iter().collect::<Option<Vec<Term>>>()?))
            }
            TypedKind::Call(Callee::Written(id), arguments) => {
                let body = &self.checked.globals[id.0].value;
                self.in_function(arguments, scope, |evaluator, scope| evaluator.term(body, scope))
            }
            TypedKind::Binary(operator, a, b) => {
                let (a, b) = (self.term(a, scope), self.term(b, scope));
                Some(Term::Binary(*operator, Box::new(a?), Box::new(b?)))
            }
            TypedKind::If { branches, otherwise } => {
                let mut whole = self.term(otherwise, scope)?;
                for (condition, value) in branches.iter().rev() {
                    let (condition, value) = (self.condition(condition, scope)?, self.term(value, scope)?);
                    whole = Term::If(Box::new(condition), Box::new(value), Box::new(whole));
                }
                Some(whole)
            }
            TypedKind::Local(slot) => match scope.locals.get(*slot)? {
                Local::Term(term) => {
                    self.spend(typed, term.size())?;
                    Some(term.clone())
                }
                _ => None,
            },
            _ => self.say_unfit(typed),
        }
    }

    /// The body of a function whose arguments wait for results.
    fn in_function<T>(
        &mut self,
        arguments: &[Typed],
        scope: Scope<'_>,
        body: impl FnOnce(&mut Self, Scope<'_>) -> Option<T>,
    ) -> Option<T> {
        let mut locals = Vec::with_capacity(arguments.len());
        for argument in arguments {
            locals.push(match needs_result(argument, scope.locals) {
                false => Local::Known(self.known(argument, scope)?),
                true if argument.ty == Type::Bool => Local::Condition(self.condition(argument, scope)?),
                true => Local::Term(self.term(argument, scope)?),
            });
        }
        let stand_in = |local: &Local| match local {
            Local::Known(value) => value.clone(),
            _ => Value { span: Span::new(crate::source::FileId(0), 0, 0), kind: ValueKind::None },
        };
        let values: Vec<Value> = locals.iter().map(stand_in).collect();
        body(self, Scope { wavelength: None, locals: &locals, values: &values })
    }

    fn say_unfit<T>(&mut self, typed: &Typed) -> Option<T> {
        let message =
            "a result cannot be used in this way: a condition may compare it, calculate with it and choose by it";
        self.say(Diagnostic::error(codes::E0217, typed.span, message).help("compare the result with a value"));
        None
    }

    /// The first comparison's side that holds a result, in the first unit of its dimension that the other side writes.
    fn shown_side(&mut self, typed: &Typed, scope: Scope<'_>) -> Option<Shown> {
        match &typed.kind {
            TypedKind::Not(inner) => self.shown_side(inner, scope),
            TypedKind::Binary(BinaryOp::And | BinaryOp::Or, a, b) => {
                self.shown_side(a, scope).or_else(|| self.shown_side(b, scope))
            }
            TypedKind::Binary(_, a, b) => {
                let (side, other) = if needs_result(a, scope.locals) { (a, b) } else { (b, a) };
                let dimension = side.ty.dimension()?;
                let wavelength = scope.wavelength;
                let unit = first_unit(other, dimension, wavelength).or_else(|| first_unit(side, dimension, wavelength));
                let unit = unit.map(|(unit, size)| Written { unit, size, divided: divided(other) });
                let limit = self.term(other, scope);
                Some(Shown { term: self.term(side, scope)?, other: limit, dimension, unit })
            }
            _ => None,
        }
    }
}

/// Whether the expression holds a result, directly or in a local value.
fn needs_result(typed: &Typed, locals: &[Local]) -> bool {
    let needs = |typed: &Typed| needs_result(typed, locals);
    match &typed.kind {
        TypedKind::Result(_) => true,
        TypedKind::Local(slot) => matches!(locals.get(*slot), Some(Local::Term(_) | Local::Condition(_))),
        TypedKind::Minus(inner) | TypedKind::Not(inner) | TypedKind::Member(inner, _) => needs(inner),
        TypedKind::Binary(_, a, b) | TypedKind::Range(a, b) => needs(a) || needs(b),
        TypedKind::Call(_, inner) | TypedKind::List(inner) => inner.iter().any(needs),
        TypedKind::If { branches, otherwise } => branches.iter().any(|(a, b)| needs(a) || needs(b)) || needs(otherwise),
        TypedKind::Comprehension { element, over, .. } => needs(element) || needs(over),
        TypedKind::Record(_, given) => given.iter().any(|field| needs(&field.value)),
        TypedKind::With(base, given) => needs(base) || given.iter().any(|field| needs(&field.value)),
        _ => false,
    }
}

/// The number with a unit that the expression divides: 1 in `1 wave / 100`.
fn divided(typed: &Typed) -> Option<f64> {
    match &typed.kind {
        TypedKind::Binary(BinaryOp::Divide, number, by) if by.ty.dimension() == Some(Dimension::NUMBER) => {
            match number.kind {
                TypedKind::Number(number, Some(_)) if number > 0.0 => Some(number),
                _ => None,
            }
        }
        _ => None,
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
