//! What to say when a value does not fit: both sides, the missing factor, the units that fit.

use super::typed::{Typed, TypedKind};
use super::types::SchemaId;
use super::types::{Type, listed};
use super::{Checker, Want};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::{BinaryOp, Expr, ExprKind, UnaryOp};
use crate::units::format::{units_of, usual_unit};
use crate::units::{Dimension, UnitTable};

/// `` `nm`, `um`, `mm` and `m` ``: the common units of a dimension, if it has any.
pub(super) fn units_that_fit(dimension: Dimension) -> Option<String> {
    let units = units_of(dimension);
    (!units.is_empty()).then(|| listed(units.iter().map(|unit| unit.text)))
}

/// `Speed (Length / Time)`: the name, and what it is made of if the name is not that already.
fn side(units: &UnitTable, dimension: Dimension) -> String {
    match units.name(dimension) {
        Some(name) if name != dimension.factors() => format!("{name} ({})", dimension.factors()),
        _ => dimension.factors(),
    }
}

/// One factor that would mend it: what `found` must be multiplied or divided by to become `wanted`.
fn missing_factor(units: &UnitTable, found: Dimension, wanted: Dimension) -> Option<String> {
    let speed = Dimension::whole(1, 0, -1, 0);
    if wanted == speed && found == Dimension::whole(1, 0, -1, 1) {
        return Some("an angle does not cancel: write `tangential(angular speed, radius)`".into());
    }
    if wanted == Dimension::LENGTH && found == Dimension::whole(1, 0, 0, 1) {
        return Some("an angle does not cancel: write `arc(angle, radius)`".into());
    }
    let factor = wanted.over(found)?;
    let named = |dimension: Dimension| units.name(dimension).filter(|_| !dimension.is_number());
    if Dimension::NUMBER.over(found) == Some(wanted) && !found.is_number() {
        return Some("invert it: `1 / (…)`".into());
    }
    // Of the two ways to say it, the one whose quantity a person has in hand: a length rather than a curvature.
    let inverse = Dimension::NUMBER.over(factor);
    let divide = inverse.and_then(named).map(|name| format!("divide by {} `{name}`", article(name)));
    let multiply = named(factor).map(|name| format!("multiply by {} `{name}`", article(name)));
    if factor.factors().starts_with("1 /") { divide.or(multiply) } else { multiply.or(divide) }
}

fn article(name: &str) -> &'static str {
    if name.starts_with(['A', 'E', 'I', 'O', 'U']) { "an" } else { "a" }
}

/// The text of a plain number as written, `-4` included.
fn literal_number(expr: &Expr) -> bool {
    match &expr.kind {
        ExprKind::Number(_) => true,
        ExprKind::Unary(UnaryOp::Minus, inner) => matches!(inner.kind, ExprKind::Number(_)),
        _ => false,
    }
}

impl Checker<'_> {
    /// The typed expression if it fits what is wanted; else says why not.
    pub(super) fn conform(&mut self, found: Typed, expr: &Expr, want: Option<&Want>) -> Typed {
        let Some(want) = want else { return found };
        if self.vocabulary.fits(&found.ty, &want.ty) {
            return found;
        }
        let diagnostic = match (found.ty.dimension(), want.ty.required().dimension()) {
            (Some(have), Some(need)) => self.wrong_dimension(&found, expr, want, have, need),
            _ => match self.wrong_type(&found, want) {
                diagnostic if diagnostic.help.is_none() => self.with_mend(diagnostic, &found, expr, want),
                diagnostic => diagnostic,
            },
        };
        self.say(diagnostic);
        Typed::failed(found.span)
    }

    fn wrong_dimension(&self, found: &Typed, expr: &Expr, want: &Want, have: Dimension, need: Dimension) -> Diagnostic {
        let units = &self.vocabulary.units;
        let what = &want.what;
        let message = format!("{what} expects {}, found {}", units.in_words(need), units.in_words(have));
        if have.is_number() {
            return self.missing_unit(found.span, expr, message, need, want.unit.as_deref());
        }
        let diagnostic = Diagnostic::error(codes::E0303, found.span, message)
            .note(format!("expected: {}", side(units, need)))
            .note(format!("found:    {}", side(units, have)));
        if matches!(found.kind, TypedKind::Number(..)) {
            return match (units_that_fit(need), need.is_number()) {
                (Some(fitting), _) => diagnostic.help(format!("units that fit: {fitting}")),
                (None, true) => diagnostic.help("leave out the unit"),
                (None, false) => diagnostic.help(format!("a unit that fits: `{}`", need.si_unit())),
            };
        }
        match missing_factor(units, have, need) {
            Some(factor) => match self.without_angle(found, expr, need) {
                Some(mended) => diagnostic.help(factor).suggest(expr.span, mended),
                None => diagnostic.help(factor),
            },
            None => match need.over(have) {
                Some(factor) => diagnostic.note(format!("the factor between them: {}", side(units, factor))),
                None => diagnostic,
            },
        }
    }

    /// `60 rpm * 180 mm` as the function that makes a speed of it.
    fn without_angle(&self, found: &Typed, expr: &Expr, need: Dimension) -> Option<String> {
        let TypedKind::Binary(BinaryOp::Multiply, a, b) = &found.kind else { return None };
        let ExprKind::Binary(_, _, left, right) = &expr.kind else { return None };
        let length = |typed: &Typed| typed.ty.dimension() == Some(Dimension::LENGTH);
        let (angle, radius) = match (length(a), length(b)) {
            (false, true) => (left, right),
            (true, false) => (right, left),
            _ => return None,
        };
        let function = if need == Dimension::LENGTH { "arc" } else { "tangential" };
        Some(format!("{function}({}, {})", self.sources.slice(angle.span), self.sources.slice(radius.span)))
    }

    /// The unit of the first quantity in the field's limits, the usual ones before the hard ones.
    pub(super) fn unit_of_limits(&self, schema: SchemaId, field: &str) -> Option<String> {
        let field = self.vocabulary.schema(schema).field(field)?;
        let limits = field.usual.iter().chain(&field.restriction);
        limits.into_iter().find_map(|limit| {
            let mut words = limit.text.split_whitespace().skip_while(|word| word.parse::<f64>().is_err());
            words.next();
            words.next().filter(|word| word.starts_with(char::is_alphabetic)).map(str::to_string)
        })
    }

    /// A plain number where a quantity is expected.
    fn missing_unit(
        &self,
        span: Span,
        expr: &Expr,
        message: String,
        need: Dimension,
        unit: Option<&str>,
    ) -> Diagnostic {
        let diagnostic = Diagnostic::error(codes::E0302, span, message);
        let unit = unit.or(usual_unit(need)).map_or_else(|| need.si_unit(), str::to_string);
        let diagnostic = match units_that_fit(need) {
            Some(fitting) => diagnostic.note(format!("units that fit: {fitting}")),
            None => diagnostic,
        };
        if literal_number(expr) {
            let mended = format!("{} {unit}", self.sources.slice(expr.span));
            diagnostic.label("a plain number").help(format!("write `{mended}`")).suggest(expr.span, mended)
        } else {
            let units = &self.vocabulary.units;
            let factor = missing_factor(units, Dimension::NUMBER, need);
            diagnostic.help(factor.unwrap_or_else(|| format!("multiply by a `{}`", units.describe(need))))
        }
    }

    fn wrong_type(&self, found: &Typed, want: &Want) -> Diagnostic {
        let vocabulary = &self.vocabulary;
        let wanted = vocabulary.in_words(&want.ty);
        match (&found.ty, want.ty.required()) {
            (Type::Schema(schema), Type::Family(family)) => {
                let schema = vocabulary.schema(*schema);
                let message = format!("{} cannot be a `{}`", want.what, schema.name);
                let mut diagnostic = Diagnostic::error(codes::E0308, found.span, message)
                    .note(format!("expected {}", vocabulary.in_words(&Type::Family(*family))));
                if let Some(own) = schema.family {
                    let own = &vocabulary.family(own).name;
                    diagnostic = diagnostic.note(format!("`{}` is {} `{own}`", schema.name, article(own)));
                }
                diagnostic
            }
            (Type::List(_, Some(have)), Type::List(_, Some(need))) if have != need => {
                let message = format!("{} expects a list of {need} values, found one of {have}", want.what);
                Diagnostic::error(codes::E0310, found.span, message)
            }
            (Type::Optional(_), _) => {
                let message = format!("{} expects {wanted}, and this may be `none`", want.what);
                Diagnostic::error(codes::E0301, found.span, message)
            }
            (Type::Text, Type::Symbols(symbols)) => {
                let text = self.sources.slice(found.span).trim_matches('"').to_string();
                let message = format!("{} expects a bare word, found a text in quotes", want.what);
                let diagnostic = Diagnostic::error(codes::E0301, found.span, message)
                    .note(format!("it is one of {}", listed(symbols.iter().map(|s| s.name.as_str()))));
                match symbols.iter().any(|symbol| symbol.name == text) {
                    true => diagnostic.help(format!("write `{text}`")).suggest(found.span, text),
                    false => diagnostic,
                }
            }
            _ => {
                let found_words = match &found.kind {
                    TypedKind::Symbol(symbol) => format!("`{symbol}`"),
                    _ => vocabulary.in_words(&found.ty),
                };
                let message = format!("{} expects {wanted}, found {found_words}", want.what);
                let diagnostic = Diagnostic::error(codes::E0301, found.span, message);
                match want.ty.required() {
                    Type::List(..) if !matches!(found.ty, Type::List(..)) => {
                        let mended = format!("[{}]", self.sources.slice(found.span));
                        diagnostic.help("write it in `[ ]`").suggest(found.span, mended)
                    }
                    _ => diagnostic,
                }
            }
        }
    }

    /// Two sides of `+`, `-` or a comparison that do not have the same dimension.
    pub(super) fn unequal_sides(&mut self, verb: &str, span: Span, left: (&Typed, &Expr), right: (&Typed, &Expr)) {
        let units = &self.vocabulary.units;
        let (Some(a), Some(b)) = (left.0.ty.dimension(), right.0.ty.dimension()) else { return };
        let message = format!("cannot {verb} {} and {}", units.in_words(a), units.in_words(b));
        let mut diagnostic = Diagnostic::error(codes::E0304, span, message)
            .also(left.0.span, units.describe(a))
            .also(right.0.span, units.describe(b))
            .note(format!("left:  {}", side(units, a)))
            .note(format!("right: {}", side(units, b)));
        let bare = [(a, b, left, right), (b, a, right, left)]
            .into_iter()
            .find(|(have, _, (_, expr), _)| have.is_number() && literal_number(expr));
        if let Some((_, need, (_, expr), (_, other))) = bare {
            // The unit of the other side, if it says one. A height is no millimetre and a removal rate no millimetre a
            // second: where several units are usual, nothing is proposed that a reader might just accept.
            let beside = match &other.kind {
                ExprKind::Quantity { unit, .. } => Some(self.sources.slice(unit.span).to_string()),
                _ => None,
            };
            let several = need == Dimension::LENGTH || need == Dimension::whole(1, 0, -1, 0);
            diagnostic = match (several && beside.is_none(), units_that_fit(need)) {
                (true, Some(fitting)) => diagnostic.help(format!("give the number its unit: {fitting} fit")),
                _ => {
                    let unit =
                        beside.or_else(|| usual_unit(need).map(str::to_string)).unwrap_or_else(|| need.si_unit());
                    let mended = format!("{} {unit}", self.sources.slice(expr.span));
                    diagnostic.help(format!("write `{mended}`")).suggest(expr.span, mended)
                }
            };
        } else {
            if let Some(factor) = a.over(b) {
                diagnostic = diagnostic.note(format!("the factor between them: {}", side(units, factor)));
            }
            let literal = |typed: &Typed| matches!(typed.kind, TypedKind::Number(_, Some(_)));
            if let (true, Some(fitting)) = (literal(right.0), units_that_fit(a)) {
                diagnostic = diagnostic.help(format!("units that fit on the right: {fitting}"));
            } else if let (true, Some(fitting)) = (literal(left.0), units_that_fit(b)) {
                diagnostic = diagnostic.help(format!("units that fit on the left: {fitting}"));
            } else if let Some(factor) = missing_factor(units, b, a) {
                diagnostic = diagnostic.help(format!("on the right, {factor}"));
            }
        }
        self.say(diagnostic);
    }
}
