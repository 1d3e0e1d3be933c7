//! `if … then … else …` and `[… for i in 1 .. 4]`: values that depend on other values.

use super::typed::{Typed, TypedKind};
use super::types::Type;
use super::units::ListUnit;
use super::{Checker, Place, Want};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::{Expr, Name, Unit};

impl Checker<'_> {
    /// All values have one type: that which is wanted, else that of the first.
    pub(super) fn choice(
        &mut self,
        place: Place,
        branches: &[(Expr, Expr)],
        otherwise: &Expr,
        span: Span,
        want: Option<&Want>,
    ) -> Typed {
        let mut conditions = Vec::with_capacity(branches.len());
        let mut values = Vec::with_capacity(branches.len() + 1);
        for (condition, value) in branches {
            conditions.push(self.wanted(place, condition, Type::Bool, "the condition of `if`".into()));
            values.push(self.expression(place, value, want));
        }
        values.push(self.expression(place, otherwise, want));
        if conditions.iter().chain(&values).any(|typed| typed.ty.is_failed()) {
            return Typed::failed(span);
        }
        let ty = match want {
            Some(want) => want.ty.clone(),
            None => {
                let ty = self.common_type(&values);
                let want = Want { ty: ty.clone(), what: "the other branch of this `if`".into(), unit: None };
                let written = branches.iter().map(|(_, value)| value).chain([otherwise]);
                let conformed = values.into_iter().zip(written).map(|(value, expr)| {
                    // The first speaks for all; where the others do not fit, each says so.
                    self.conform(value, expr, Some(&want))
                });
                values = conformed.collect();
                if values.iter().any(|typed| typed.ty.is_failed()) {
                    return Typed::failed(span);
                }
                ty
            }
        };
        let Some(last) = values.pop() else { return Typed::failed(span) };
        let branches = conditions.into_iter().zip(values).collect();
        Typed { span, ty, kind: TypedKind::If { branches, otherwise: Box::new(last) } }
    }

    /// The first type that says something, wide enough for `none` and for two members of one family.
    fn common_type(&self, values: &[Typed]) -> Type {
        let first = values.iter().map(|value| &value.ty).find(|ty| **ty != Type::None);
        let mut ty = first.cloned().unwrap_or(Type::None);
        let family = |ty: &Type| match ty {
            Type::Schema(schema) => self.vocabulary.schema(*schema).family,
            _ => None,
        };
        if let Some(common) = family(&ty)
            && values.iter().any(|value| value.ty != ty && family(&value.ty) == Some(common))
        {
            ty = Type::Family(common);
        }
        // Lists of different lengths are lists.
        if let Type::List(element, Some(_)) = &ty
            && values.iter().any(|value| matches!(&value.ty, Type::List(..)) && value.ty != ty)
        {
            ty = Type::List(element.clone(), None);
        }
        let nothing = values.iter().any(|value| value.ty == Type::None);
        if nothing && !matches!(ty, Type::Optional(_) | Type::None) { Type::Optional(Box::new(ty)) } else { ty }
    }

    pub(super) fn comprehension(
        &mut self,
        place: Place,
        (element, unit): (&Expr, Option<&Unit>),
        (variable, over): (&Name, &Expr),
        span: Span,
        want: Option<&Want>,
    ) -> Typed {
        let range = self.expression(place, over, None);
        let counts = match range.ty.required() {
            Type::Range(end) => end.dimension().is_some_and(|dimension| dimension.is_number()),
            Type::Failed => true,
            _ => false,
        };
        if !counts {
            let found = self.vocabulary.in_words(&range.ty);
            self.say(
                Diagnostic::error(
                    codes::E0301,
                    range.span,
                    format!("`for` needs a range of whole numbers, found {found}"),
                )
                .help("write how often: `[… for i in 1 .. 4]`"),
            );
        }
        let element_want = match want.map(|want| (want.ty.required(), want)) {
            Some((Type::List(element, _), want)) if !element.is_failed() => Some(want.part(element)),
            _ => None,
        };
        let unit = match self.unit_of_list(place, unit, element_want.as_ref()) {
            Ok(unit) => unit,
            Err(super::units::Unknown) => return Typed::failed(span),
        };
        self.local_is_free(place.module, variable);
        let slot = self.locals.len();
        let typed = self.with_local(variable, Type::Integer, |checker| {
            checker.element(place, element, unit.as_ref(), element_want.as_ref())
        });
        if typed.ty.is_failed() || !counts || range.ty.is_failed() {
            return Typed::failed(span);
        }
        let length = match &range.kind {
            TypedKind::Range(from, to) => literal_length(from, to),
            _ => None,
        };
        let ty = self.list_of(element_want.map_or_else(|| typed.ty.clone(), |want| want.ty), length, span);
        let kind = TypedKind::Comprehension { element: Box::new(typed), slot, over: Box::new(range) };
        match ty {
            Some(ty) => Typed { span, ty, kind },
            None => Typed::failed(span),
        }
    }

    /// One element of a list, with the list's unit if it has one.
    pub(super) fn element(
        &mut self,
        place: Place,
        element: &Expr,
        unit: Option<&ListUnit>,
        want: Option<&Want>,
    ) -> Typed {
        let Some((unit, dimension)) = unit else { return self.expression(place, element, want) };
        let what = "a list with a unit after it".to_string();
        let number = self.wanted(place, element, Type::NUMBER, what);
        if number.ty.is_failed() {
            return number;
        }
        let span = number.span;
        let ty = Type::Quantity(*dimension);
        let one = Typed { span, ty: ty.clone(), kind: TypedKind::Number(1.0, Some(unit.clone())) };
        let operator = crate::syntax::ast::BinaryOp::Multiply;
        let quantity = Typed { span, ty, kind: TypedKind::Binary(operator, Box::new(number), Box::new(one)) };
        self.conform(quantity, element, want)
    }
}

/// How many whole numbers a range has whose ends are written as numbers.
fn literal_length(from: &Typed, to: &Typed) -> Option<usize> {
    let (TypedKind::Number(from, None), TypedKind::Number(to, None)) = (&from.kind, &to.kind) else { return None };
    let whole = from.fract() == 0.0 && to.fract() == 0.0 && to >= from && to - from < 1e6;
    whole.then_some((to - from) as usize + 1)
}
