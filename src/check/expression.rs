//! Expressions: the type of each, with what is wanted of it carried downward.
//!
//! In: an expression, where it stands, what is wanted. Out: [`Typed`]. What is wanted decides what a bare word means
//! (`high` where a symbol is expected), which record `{ … }` is, and how a mistake is said.

use super::load::Unusable;
use super::typed::{Typed, TypedKind};
use super::types::Type;
use super::vocabulary::symbol;
use super::{Binding, Checker, DEEPEST, Place, Want};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::{BinaryOp, Expr, ExprKind, Name, UnaryOp, Unit};
use crate::units::Ratio;

impl Checker<'_> {
    /// The expression, typed; if it does not fit what is wanted, that is said and it has failed.
    pub(super) fn expression(&mut self, place: Place, expr: &Expr, want: Option<&Want>) -> Typed {
        if self.depth >= DEEPEST {
            let message = format!("this expression, with the values that it uses, is nested more than {DEEPEST} deep");
            if !self.diagnostics.iter().any(|d| d.code == codes::E0412) {
                self.say(
                    Diagnostic::error(codes::E0412, expr.span, message).help("give the inner parts names with `let`"),
                );
            }
            return Typed::failed(expr.span);
        }
        if let Some(failed) = self.unquoted(place, expr, want) {
            return failed;
        }
        self.depth += 1;
        let found = self.unconformed(place, expr, want.filter(|want| !want.ty.is_failed()));
        self.depth -= 1;
        self.conform(found, expr, want)
    }

    fn unconformed(&mut self, place: Place, expr: &Expr, want: Option<&Want>) -> Typed {
        let span = expr.span;
        match &expr.kind {
            ExprKind::Number(value) => Typed { span, ty: Type::NUMBER, kind: TypedKind::Number(*value, None) },
            ExprKind::Quantity { value, unit } => self.quantity(place, *value, unit, span, want),
            ExprKind::Text(text) => match want.map(|want| want.ty.required()) {
                Some(Type::File) => {
                    let from = self.modules[place.module.0].path.clone();
                    self.file(text, &from, span)
                }
                Some(Type::Date) => self.date(text, span),
                _ => Typed { span, ty: Type::Text, kind: TypedKind::Text(text.clone()) },
            },
            ExprKind::Bool(value) => Typed { span, ty: Type::Bool, kind: TypedKind::Bool(*value) },
            ExprKind::None => Typed { span, ty: Type::None, kind: TypedKind::None },
            ExprKind::Name(word) => {
                // One symbol where a list of symbols is expected: known, so that only its brackets are missed.
                let element = match want.map(|want| (want.ty.required(), want)) {
                    Some((Type::List(element, _), want)) => Some(want.part(element)),
                    _ => None,
                };
                self.name(place, word, span, element.as_ref().or(want))
            }
            ExprKind::Member(base, name) => self.member(place, base, name, span),
            ExprKind::Call(callee, arguments) => self.call(place, callee, arguments, span),
            ExprKind::Record { schema, body } => self.record_expression(place, schema.as_ref(), body, span, want),
            ExprKind::With(base, body) => self.with(place, base, body, span),
            ExprKind::List(elements, unit) => self.list(place, elements, unit.as_ref(), span, want),
            ExprKind::Comprehension { element, variable, over, unit } => {
                self.comprehension(place, (element, unit.as_ref()), (variable, over), span, want)
            }
            ExprKind::If { branches, otherwise } => self.choice(place, branches, otherwise, span, want),
            ExprKind::Range(from, to) => self.range(place, from, to, span, want),
            ExprKind::Unary(UnaryOp::Minus, inner) => {
                let inner = self.expression(place, inner, None);
                match inner.ty.dimension() {
                    Some(dimension) => {
                        Typed { span, ty: Type::Quantity(dimension), kind: TypedKind::Minus(Box::new(inner)) }
                    }
                    None => self.wrong_operand("-", &inner, span),
                }
            }
            ExprKind::Unary(UnaryOp::Not, inner) => {
                let inner = self.wanted(place, inner, Type::Bool, "`not`".into());
                Typed { span, ty: Type::Bool, kind: TypedKind::Not(Box::new(inner)) }
            }
            ExprKind::Binary(operator, at, left, right) => self.binary(place, *operator, *at, (left, right), span),
            ExprKind::Missing => Typed::failed(span),
        }
    }

    fn quantity(&mut self, place: Place, value: f64, unit: &Unit, span: Span, want: Option<&Want>) -> Typed {
        let wanted = want.and_then(|want| want.ty.required().dimension());
        match self.unit(place, unit, wanted) {
            Some((unit, dimension)) => {
                Typed { span, ty: Type::Quantity(dimension), kind: TypedKind::Number(value, Some(unit)) }
            }
            None => Typed::failed(span),
        }
    }

    /// A file named in the text: its whole path. Its content is read by the pass that needs it.
    pub(super) fn file(&mut self, said: &str, from: &str, span: Span) -> Typed {
        match self.files.resolve(from, said).map_err(Unusable::File) {
            Ok(path) => Typed { span, ty: Type::File, kind: TypedKind::File(path) },
            Err(why) => {
                let message = format!("the file `{said}` {}", why.words());
                let diagnostic = Diagnostic::error(why.code(), span, message);
                self.say(match why.code() == codes::E0205 {
                    true => diagnostic
                        .note("a project is the nearest folder upward with a `polish.toml`, else the job's own folder")
                        .help("move the file into the project, or give it by `--set` to a `param` of type `File`"),
                    false => diagnostic,
                });
                Typed::failed(span)
            }
        }
    }

    fn member(&mut self, place: Place, base: &Expr, name: &Name, span: Span) -> Typed {
        if let Some(path) = result_path(base) {
            return self.result(place, path, name, span);
        }
        // A file whose `use` failed is a failed name, which the next lines treat as any other.
        if let ExprKind::Name(word) = &base.kind
            && let Some((Binding::Module(module), _)) = self.scopes[place.module.0].values.get(word)
        {
            let module = *module;
            let found = self.value_of_module(module, name);
            return Typed { span, ..found };
        }
        let base = self.expression(place, base, None);
        let schema = match base.ty.required() {
            Type::Schema(schema) => *schema,
            Type::Failed => return Typed::failed(span),
            other => {
                let message = format!("{} has no field `{}`", self.vocabulary.in_words(other), name.text);
                self.say(Diagnostic::error(codes::E0311, name.span, message).note("only records have fields"));
                return Typed::failed(span);
            }
        };
        match self.vocabulary.schema(schema).field(&name.text).map(|field| field.ty.clone()) {
            Some(ty) => Typed { span, ty, kind: TypedKind::Member(Box::new(base), name.text.clone()) },
            None => {
                self.say_unknown_field(schema, name);
                Typed::failed(span)
            }
        }
    }

    /// `result.motion.time`: followed through the schemas of `stdlib/result.polish`.
    fn result<'n>(&mut self, place: Place, mut path: Vec<&'n Name>, last: &'n Name, span: Span) -> Typed {
        if !place.results {
            return self.misplaced_result(place, span);
        }
        path.push(last);
        let Some(mut schema) = self.core.schemas.get("result").copied() else { return Typed::failed(span) };
        for (index, name) in path.iter().enumerate() {
            let found = self.vocabulary.schema(schema).field(&name.text).map(|field| field.ty.clone());
            match found {
                Some(Type::Schema(inner)) if index + 1 < path.len() => schema = inner,
                Some(ty) if index + 1 == path.len() && ty.dimension().is_some() => {
                    let words: Vec<&str> = path.iter().map(|name| name.text.as_str()).collect();
                    return Typed { span, ty, kind: TypedKind::Result(words.join(".")) };
                }
                Some(ty) => {
                    let known: Vec<String> = match ty {
                        Type::Schema(inner) => {
                            self.vocabulary.schema(inner).fields.iter().map(|f| f.name.clone()).collect()
                        }
                        _ => Vec::new(),
                    };
                    let written = self.sources.slice(span).to_string();
                    let diagnostic = match known.first() {
                        Some(first) => {
                            Diagnostic::error(codes::E0217, span, format!("`{written}` is not one result but several"))
                                .help(format!("write which: `{written}.{first}`"))
                        }
                        None => Diagnostic::error(codes::E0217, span, format!("there is no result `{written}`")),
                    };
                    self.say(diagnostic);
                    return Typed::failed(span);
                }
                None => {
                    let fields = &self.vocabulary.schema(schema).fields;
                    let names: Vec<String> = fields.iter().map(|field| field.name.clone()).collect();
                    let names = || names.iter().map(String::as_str);
                    let written = self.sources.slice(span).to_string();
                    let mut diagnostic =
                        Diagnostic::error(codes::E0217, name.span, format!("there is no result `{written}`"))
                            .note(format!("known here: {}", super::types::listed(names())));
                    if let Some(near) = super::similar::nearest(&name.text, names()) {
                        diagnostic = diagnostic.help(format!("did you mean `{near}`?")).suggest(name.span, near);
                    }
                    self.say(diagnostic);
                    return Typed::failed(span);
                }
            }
        }
        Typed::failed(span)
    }

    fn list(&mut self, place: Place, elements: &[Expr], unit: Option<&Unit>, span: Span, want: Option<&Want>) -> Typed {
        let element_want = match want.map(|want| (want.ty.required(), want)) {
            Some((Type::List(element, _), want)) if !element.is_failed() => Some(want.part(element)),
            _ => None,
        };
        let unit = match self.unit_of_list(place, unit, element_want.as_ref()) {
            Ok(unit) => unit,
            Err(super::units::Unknown) => return Typed::failed(span),
        };
        if let (None, Some(want)) = (&unit, &element_want)
            && let Some(failed) = self.plain_list(elements, want, span)
        {
            return failed;
        }
        let mut typed: Vec<Typed> = Vec::new();
        for element in elements {
            typed.push(self.element(place, element, unit.as_ref(), element_want.as_ref()));
        }
        let mut ty = element_want.as_ref().map_or(Type::Failed, |want| want.ty.clone());
        if element_want.is_none() {
            // Without a wanted type the first element says it; the others must fit.
            if let Some(first) = typed.iter().map(|element| &element.ty).find(|ty| !ty.is_failed()) {
                ty = first.clone();
            }
            for (element, expr) in typed.iter_mut().zip(elements) {
                let want = Want { ty: ty.clone(), what: "this list".into(), unit: None };
                let found = std::mem::replace(element, Typed::failed(span));
                *element = self.conform(found, expr, Some(&want));
            }
        }
        self.say_twice(&typed);
        let length = typed.len();
        if length > 0 && ty.is_failed() {
            return Typed::failed(span);
        }
        match self.list_of(ty, Some(length), span) {
            Some(ty) => Typed { span, ty, kind: TypedKind::List(typed) },
            None => Typed::failed(span),
        }
    }

    /// The type of a list of `element`; none, and that is said, if lists nest too deep.
    pub(super) fn list_of(&mut self, element: Type, length: Option<usize>, span: Span) -> Option<Type> {
        if list_depth(&element) >= DEEPEST_LIST {
            let message = format!("lists are nested more than {DEEPEST_LIST} deep");
            self.say(Diagnostic::error(codes::E0412, span, message).help("write one list"));
            return None;
        }
        Some(Type::List(Box::new(element), length))
    }

    /// A day of the calendar as ISO 8601 writes it.
    pub(super) fn date(&mut self, said: &str, span: Span) -> Typed {
        if is_date(said) {
            return Typed { span, ty: Type::Date, kind: TypedKind::Text(said.to_string()) };
        }
        let message = format!("`{said}` is not a date");
        let help = "write year, month and day of a day that there is: `\"2024-05-16\"`";
        self.say(Diagnostic::error(codes::E0312, span, message).help(help));
        Typed::failed(span)
    }

    /// A list of words is a set: one that stands there twice says nothing, so it was not meant.
    fn say_twice(&mut self, elements: &[Typed]) {
        for (index, element) in elements.iter().enumerate() {
            let TypedKind::Symbol(word) = &element.kind else { continue };
            let Some(first) = elements[..index].iter().find(|other| other.kind == element.kind) else { continue };
            let before = Span { start: elements[index - 1].span.end, end: element.span.end, ..element.span };
            self.say(
                Diagnostic::error(codes::E0416, element.span, format!("`{word}` stands twice in this list"))
                    .also(first.span, "the first one")
                    .help("keep one")
                    .suggest(before, ""),
            );
        }
    }

    fn range(&mut self, place: Place, from: &Expr, to: &Expr, span: Span, want: Option<&Want>) -> Typed {
        let end_want = match want.map(|want| (want.ty.required(), want)) {
            Some((Type::Range(element), want)) => {
                // `0.2 .. 20 mm/s`: the unit that one end lacks is that of the other.
                let unit = [from, to].into_iter().find_map(|end| match &end.kind {
                    ExprKind::Quantity { unit, .. } => Some(self.sources.slice(unit.span).to_string()),
                    _ => None,
                });
                let part = want.part(element);
                Some(Want { unit: unit.or(part.unit.clone()), ..part })
            }
            _ => None,
        };
        let low = self.expression(place, from, end_want.as_ref());
        let high = self.expression(place, to, end_want.as_ref());
        if low.ty.is_failed() || high.ty.is_failed() {
            return Typed::failed(span);
        }
        let (Some(a), Some(b)) = (low.ty.dimension(), high.ty.dimension()) else {
            let wrong = if low.ty.dimension().is_none() { &low } else { &high };
            return self.wrong_operand("..", wrong, span);
        };
        if a != b {
            self.unequal_sides("make a range of", span, (&low, from), (&high, to));
            return Typed::failed(span);
        }
        let ty = Type::Range(Box::new(Type::Quantity(a)));
        Typed { span, ty, kind: TypedKind::Range(Box::new(low), Box::new(high)) }
    }

    pub(super) fn wrong_operand(&mut self, operator: &str, operand: &Typed, span: Span) -> Typed {
        if !operand.ty.is_failed() {
            let message = format!("`{operator}` needs numbers, found {}", self.vocabulary.in_words(&operand.ty));
            self.say(Diagnostic::error(codes::E0305, operand.span, message));
        }
        Typed::failed(span)
    }

    fn binary(&mut self, place: Place, operator: BinaryOp, at: Span, sides: (&Expr, &Expr), span: Span) -> Typed {
        let (left, right) = sides;
        let word = symbol(operator);
        if let BinaryOp::And | BinaryOp::Or = operator {
            let a = self.wanted(place, left, Type::Bool, format!("`{word}`"));
            let b = self.wanted(place, right, Type::Bool, format!("`{word}`"));
            return Typed { span, ty: Type::Bool, kind: TypedKind::Binary(operator, Box::new(a), Box::new(b)) };
        }
        if let Some(failed) = self.spaced_unit(place, operator, left, right) {
            return failed;
        }
        let a = self.expression(place, left, None);
        if operator == BinaryOp::Power {
            return self.power(place, a, right, span);
        }
        // A symbol on the right means what the left side's set says.
        let equality = matches!(operator, BinaryOp::Equal | BinaryOp::NotEqual);
        let right_want = match &a.ty {
            Type::Symbols(_) if equality => Some(Want { ty: a.ty.clone(), what: format!("`{word}`"), unit: None }),
            _ => None,
        };
        let b = self.expression(place, right, right_want.as_ref());
        if a.ty.is_failed() || b.ty.is_failed() {
            return Typed::failed(span);
        }
        if equality && a.ty.dimension().is_none() && matches!(a.ty, Type::Symbols(_) | Type::Bool | Type::Text) {
            let want = Want { ty: a.ty.clone(), what: format!("the right side of `{word}`"), unit: None };
            let b = self.conform(b, right, Some(&want));
            return Typed { span, ty: Type::Bool, kind: TypedKind::Binary(operator, Box::new(a), Box::new(b)) };
        }
        let (Some(x), Some(y)) = (a.ty.dimension(), b.ty.dimension()) else {
            let wrong = if a.ty.dimension().is_none() { &a } else { &b };
            return self.wrong_operand(word, wrong, span);
        };
        let ty = match operator {
            BinaryOp::Multiply | BinaryOp::Divide => {
                let combined = if operator == BinaryOp::Multiply { x.times(y) } else { x.over(y) };
                match combined {
                    Some(dimension) => Type::Quantity(dimension),
                    None => {
                        self.say(Diagnostic::error(codes::E0306, span, "the power of this dimension is too large"));
                        return Typed::failed(span);
                    }
                }
            }
            BinaryOp::Add | BinaryOp::Subtract if x == y => Type::Quantity(x),
            _ if x == y => Type::Bool,
            _ => {
                let verb = match operator {
                    BinaryOp::Add => "add",
                    BinaryOp::Subtract => "subtract",
                    _ => "compare",
                };
                self.unequal_sides(verb, at, (&a, left), (&b, right));
                return Typed::failed(span);
            }
        };
        Typed { span, ty, kind: TypedKind::Binary(operator, Box::new(a), Box::new(b)) }
    }

    fn power(&mut self, place: Place, base: Typed, exponent: &Expr, span: Span) -> Typed {
        let typed = self.wanted(place, exponent, Type::NUMBER, "the exponent of `^`".into());
        if base.ty.is_failed() || typed.ty.is_failed() {
            return Typed::failed(span);
        }
        let Some(dimension) = base.ty.dimension() else { return self.wrong_operand("^", &base, span) };
        let dimension = if dimension.is_number() {
            dimension
        } else {
            // The dimension of the result must be known before any number is.
            let Some(ratio) = constant_ratio(exponent) else {
                let message = "a quantity can be raised only to a power written as a number, such as `2` or `(1/2)`";
                self.say(Diagnostic::error(codes::E0306, exponent.span, message));
                return Typed::failed(span);
            };
            match dimension.power(ratio) {
                Some(dimension) => dimension,
                None => {
                    self.say(Diagnostic::error(codes::E0306, span, "the power of this dimension is too large"));
                    return Typed::failed(span);
                }
            }
        };
        let kind = TypedKind::Binary(BinaryOp::Power, Box::new(base), Box::new(typed));
        Typed { span, ty: Type::Quantity(dimension), kind }
    }
}

/// Deepest nesting of lists. No field has more than two; a list of lists of lists built by a chain of `let` could
/// otherwise grow without bound.
const DEEPEST_LIST: usize = 8;

fn list_depth(ty: &Type) -> usize {
    match ty {
        Type::List(element, _) => 1 + list_depth(element),
        _ => 0,
    }
}

/// Whether the text is a day of the Gregorian calendar, `YYYY-MM-DD`.
fn is_date(text: &str) -> bool {
    let form = text.len() == 10
        && text.bytes().enumerate().all(|(i, byte)| match i {
            4 | 7 => byte == b'-',
            _ => byte.is_ascii_digit(),
        });
    if !form {
        return false;
    }
    let number = |range: std::ops::Range<usize>| text[range].parse::<u32>().unwrap_or(0);
    let (year, month, day) = (number(0..4), number(5..7), number(8..10));
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    let days = match month {
        2 if leap => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => 0,
    };
    (1..=days).contains(&day)
}

/// The words after `result`, if the expression is `result.a.b`.
fn result_path(expr: &Expr) -> Option<Vec<&Name>> {
    let mut path = Vec::new();
    let mut inner = expr;
    loop {
        match &inner.kind {
            ExprKind::Name(word) if word == "result" => {
                path.reverse();
                return Some(path);
            }
            ExprKind::Member(base, name) => {
                path.push(name);
                inner = base;
            }
            _ => return None,
        }
    }
}

/// An exponent that is known from its text: `2`, `-3`, `(1/2)`.
fn constant_ratio(expr: &Expr) -> Option<Ratio> {
    let whole = |value: f64| (value.fract() == 0.0 && value.abs() <= 1e6).then_some(value as i64);
    match &expr.kind {
        ExprKind::Number(value) => match whole(*value) {
            Some(value) => Ratio::new(value, 1),
            None => Ratio::new(whole(*value * 2.0)?, 2),
        },
        ExprKind::Unary(UnaryOp::Minus, inner) => match &inner.kind {
            ExprKind::Number(value) => Ratio::new(-whole(*value)?, 1),
            _ => None,
        },
        ExprKind::Binary(BinaryOp::Divide, _, a, b) => match (&a.kind, &b.kind) {
            (ExprKind::Number(a), ExprKind::Number(b)) => Ratio::new(whole(*a)?, whole(*b)?),
            _ => None,
        },
        _ => None,
    }
}
