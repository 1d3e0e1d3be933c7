//! Values at top level: `let` and `param`, checked when first needed, so that order in the file does not matter.
//!
//! In: the items, and the values of `--set`. Out: typed values in an order in which each follows what it uses.

use super::load::{ModuleId, SetValue};
use super::typed::{GlobalId, Typed, TypedKind};
use super::types::{Limit, Type};
use super::{Binding, CheckedGlobal, Checker, Place};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::{Expr, Item, ItemKind, Name, Restriction, Type as TypeSyntax};

/// How far a global is.
#[derive(Debug)]
enum State {
    New,
    /// Its value is being checked: needing it now means that it is defined by itself.
    Active,
    Done(Typed),
}

#[derive(Debug)]
pub(super) struct Global<'a> {
    module: ModuleId,
    name: &'a Name,
    doc: &'a str,
    pub(super) public: bool,
    is_param: bool,
    declared: Option<&'a TypeSyntax>,
    value: Option<&'a Expr>,
    restriction: Option<&'a Restriction>,
    /// The declared type, resolved when the value was checked.
    ty: Type,
    limit: Option<Limit>,
    state: State,
}

impl Global<'_> {
    /// What `eval` needs of it.
    pub(super) fn checked(&self) -> CheckedGlobal {
        let value = match &self.state {
            State::Done(value) => value.clone(),
            State::New | State::Active => Typed::failed(self.name.span),
        };
        CheckedGlobal {
            name: self.name.text.clone(),
            doc: self.doc.to_string(),
            span: self.name.span,
            is_param: self.is_param,
            ty: self.ty.clone(),
            value,
            restriction: self.limit.clone(),
        }
    }
}

impl<'a> Checker<'a> {
    pub(super) fn declare_global(&mut self, module: ModuleId, item: &'a Item) {
        let (name, declared, value, restriction, is_param) = match &item.kind {
            ItemKind::Let { name, ty, value } => (name, ty.as_ref(), Some(value), None, false),
            ItemKind::Param { name, ty, value, restriction } => {
                (name, Some(ty), value.as_ref(), restriction.as_ref(), true)
            }
            _ => return,
        };
        let id = GlobalId(self.globals.len());
        self.globals.push(Global {
            module,
            name,
            doc: &item.doc,
            public: item.public,
            is_param,
            declared,
            value,
            restriction,
            ty: Type::Failed,
            limit: None,
            state: State::New,
        });
        self.bind_value(module, name, Binding::Global(id));
    }

    /// Checks all values, also those that no job uses: a library of a shop is checked as a whole.
    pub(super) fn check_globals(&mut self) {
        for index in 0..self.globals.len() {
            self.check_global(GlobalId(index));
        }
    }

    /// A value where it is used.
    pub(super) fn use_global(&mut self, id: GlobalId, span: Span) -> Typed {
        if matches!(self.globals[id.0].state, State::Active) {
            self.report_circle(id, span);
            return Typed::failed(span);
        }
        self.active.push((id, span));
        self.check_global(id);
        self.active.pop();
        match &self.globals[id.0].state {
            State::Done(value) if !value.ty.is_failed() => {
                Typed { span, ty: value.ty.clone(), kind: TypedKind::Global(id) }
            }
            _ => Typed::failed(span),
        }
    }

    fn check_global(&mut self, id: GlobalId) {
        let global = &mut self.globals[id.0];
        if !matches!(global.state, State::New) {
            return;
        }
        global.state = State::Active;
        let (module, name, declared) = (global.module, global.name, global.declared);
        let (value, restriction, is_param) = (global.value, global.restriction, global.is_param);
        let entered = self.active.last().is_none_or(|(last, _)| *last != id);
        if entered {
            self.active.push((id, name.span));
        }
        let place = Place::outside_job(module);
        let what = format!("`{}`", name.text);
        let ty = declared.map(|declared| self.resolve_type(module, declared));
        let sets = self.sets;
        // Only the job's own file has parameters that can be set.
        let set = if is_param && module == ModuleId(0) { sets.get(&name.text) } else { None };
        let limit = match (&ty, restriction) {
            (Some(ty), Some(restriction)) => Some(self.limit(place, restriction, ty.element(), &what)),
            _ => None,
        };
        let mut checked = match (set, value, ty.clone()) {
            (Some(SetValue::Bare(text, span)), _, Some(ty)) => self.bare_text(text, *span, &ty),
            (Some(SetValue::Expression(value)), _, Some(ty)) => self.wanted(place, value, ty, what),
            (_, Some(value), Some(ty)) => self.wanted(place, value, ty, what),
            (_, Some(value), None) => self.expression(place, value, None),
            (_, None, ty) => {
                // A value that could not be read, or an optional parameter, may be left out.
                if let Some(Type::Optional(_)) = ty {
                    Typed { span: name.span, ty: Type::None, kind: TypedKind::None }
                } else {
                    let message = format!("the parameter `{}` has no value", name.text);
                    self.say(
                        Diagnostic::error(codes::E0215, name.span, message)
                            .help(format!("give it one: `--set {}=…`", name.text)),
                    );
                    Typed::failed(name.span)
                }
            }
        };
        if entered {
            self.active.pop();
        }
        // A list of a stated kind with nothing in it, and `none`, know their type only from the declaration.
        if let Some(ty) = &ty
            && !checked.ty.is_failed()
            && matches!(checked.ty, Type::None | Type::List(..))
        {
            checked.ty = ty.clone();
        }
        let global = &mut self.globals[id.0];
        global.ty = ty.unwrap_or_else(|| checked.ty.clone());
        global.limit = limit;
        global.state = State::Done(checked);
        self.order.push(id);
    }

    /// The value of a `Text` or `File` parameter as `--set` gives it, without quotes.
    fn bare_text(&mut self, text: &str, span: Span, ty: &Type) -> Typed {
        match ty.required() {
            // An empty `from` means the working directory: what a person types is always allowed.
            Type::File => self.file(text, "", span),
            _ => Typed { span, ty: Type::Text, kind: TypedKind::Text(text.to_string()) },
        }
    }

    /// Says which values make the circle. All of them fail, so it is said once.
    fn report_circle(&mut self, id: GlobalId, span: Span) {
        let start = self.active.iter().position(|(active, _)| *active == id).unwrap_or(0);
        let circle: Vec<(GlobalId, Span)> = self.active[start..].to_vec();
        let name = self.globals[id.0].name.text.clone();
        let names: Vec<String> = circle.iter().map(|(id, _)| format!("`{}`", self.globals[id.0].name.text)).collect();
        let message = match names.as_slice() {
            [_] | [] => format!("`{name}` is defined by itself"),
            [_, rest @ ..] => {
                format!("`{name}` is defined by itself: it uses {}, which uses `{name}`", rest.join(", which uses "))
            }
        };
        let defined = self.globals[id.0].name.span;
        let mut diagnostic = Diagnostic::error(codes::E0208, defined, message);
        for ((_, used), name) in circle.iter().skip(1).zip(&names) {
            diagnostic = diagnostic.also(*used, format!("used by {name}"));
        }
        let last = names.last().cloned().unwrap_or_default();
        self.say(diagnostic.also(span, format!("used by {last}")).help("give one of them a value of its own"));
    }
}
