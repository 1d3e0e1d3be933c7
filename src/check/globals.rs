//! Values at top level: `let`, `param` and `fn`, checked when first needed, so that order in the file does not matter.
//!
//! In: the items, and the values of `--set`. Out: typed values in an order in which each follows what it uses.

use super::load::{ModuleId, SetValue};
use super::typed::{Function, GlobalId, Typed, TypedKind};
use super::types::{Limit, Type};
use super::{Binding, CheckedGlobal, Checker, Local, Place};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::{Expr, Item, ItemKind, Name, Parameter, Restriction, Type as TypeSyntax};

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
    pub(super) module: ModuleId,
    pub(super) name: &'a Name,
    doc: &'a str,
    pub(super) public: bool,
    is_param: bool,
    declared: Option<&'a TypeSyntax>,
    value: Option<&'a Expr>,
    restriction: Option<&'a Restriction>,
    usual: Option<&'a Expr>,
    /// Of a function.
    pub(super) parameters: Option<&'a [Parameter]>,
    /// The declared type, resolved when the value was checked; of a function its result's.
    pub(super) ty: Type,
    /// The types of the parameters, once resolved.
    pub(super) parameter_types: Vec<Type>,
    limit: Option<Limit>,
    usual_limit: Option<Limit>,
    state: State,
}

impl Global<'_> {
    pub(super) fn is_function(&self) -> bool {
        self.parameters.is_some()
    }

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
            usual: self.usual_limit.clone(),
            parameters: self.parameters.map(|parameters| {
                let names = parameters.iter().map(|parameter| parameter.name.text.clone());
                names.zip(self.parameter_types.iter().cloned()).collect()
            }),
        }
    }
}

impl<'a> Checker<'a> {
    pub(super) fn declare_global(&mut self, module: ModuleId, item: &'a Item) {
        let (name, declared, value) = match &item.kind {
            ItemKind::Let { name, ty, value } => (name, ty.as_ref(), Some(value)),
            ItemKind::Param { name, ty, value, .. } => (name, Some(ty), value.as_ref()),
            ItemKind::Function { name, result, body, .. } => (name, Some(result), body.as_ref()),
            _ => return,
        };
        let (restriction, usual, is_param) = match &item.kind {
            ItemKind::Param { restriction, usual, .. } => (restriction.as_ref(), usual.as_ref(), true),
            _ => (None, None, false),
        };
        let parameters = match &item.kind {
            ItemKind::Function { parameters, .. } => Some(parameters.as_slice()),
            _ => None,
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
            usual,
            parameters,
            ty: Type::Failed,
            parameter_types: Vec::new(),
            limit: None,
            usual_limit: None,
            state: State::New,
        });
        self.bind_value(module, name, Binding::Global(id));
        if parameters.is_some() {
            self.list_function(module, item, name, declared);
        }
    }

    /// Checks all values, also those that no job uses: a library of a shop is checked as a whole.
    pub(super) fn check_globals(&mut self) {
        for index in 0..self.globals.len() {
            self.check_global(GlobalId(index));
        }
    }

    /// A value, or the body of a function, where it is used.
    pub(super) fn use_global(&mut self, id: GlobalId, span: Span) -> Typed {
        if matches!(self.globals[id.0].state, State::Active) {
            self.report_circle(id, span);
            return Typed::failed(span);
        }
        self.active.push((id, span));
        // What is local here means nothing there.
        let locals = std::mem::take(&mut self.locals);
        self.check_global(id);
        self.locals = locals;
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
        if self.globals[id.0].is_function() {
            self.bring_parameters(id);
        }
        let sets = self.sets;
        // Only the job's own file has parameters that can be set.
        let set = if is_param && module == ModuleId(0) { sets.get(&name.text) } else { None };
        let limit = match (&ty, restriction) {
            (Some(ty), Some(restriction)) => Some(self.limit(place, restriction, ty.element(), &what)),
            _ => None,
        };
        let usual_limit = match (&ty, self.globals[id.0].usual) {
            (Some(ty), Some(range)) => Some(self.limit(place, &Restriction::Range(range.clone()), ty.element(), &what)),
            _ => None,
        };
        let what = match self.globals[id.0].is_function() {
            true => format!("the result of {what}"),
            false => what,
        };
        let mut checked = match (set, value, ty.clone()) {
            (Some(SetValue::Bare(text, span)), _, Some(ty)) => self.bare_text(text, *span, &ty),
            (Some(SetValue::Expression(value)), _, Some(ty)) => self.wanted(place, value, ty, what),
            (_, Some(value), Some(ty)) => self.wanted(place, value, ty, what),
            (_, Some(value), None) => self.expression(place, value, None),
            (_, None, ty) if self.globals[id.0].is_function() => self.foreign_body(id, ty.unwrap_or(Type::Failed)),
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
        self.locals.clear();
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
        global.usual_limit = usual_limit;
        global.state = State::Done(checked);
        self.order.push(id);
    }

    /// The value of a `Text` or `File` parameter as `--set` gives it, without quotes.
    fn bare_text(&mut self, text: &str, span: Span, ty: &Type) -> Typed {
        match ty.required() {
            // An empty `from` means the working directory: what a person types is always allowed.
            Type::File => self.file(text, "", span),
            Type::Date => self.date(text, span),
            _ => Typed { span, ty: Type::Text, kind: TypedKind::Text(text.to_string()) },
        }
    }

    /// The parameters of a function become local values of its body.
    fn bring_parameters(&mut self, id: GlobalId) {
        let (module, parameters) = (self.globals[id.0].module, self.globals[id.0].parameters.unwrap_or_default());
        self.locals.clear();
        for parameter in parameters {
            let ty = self.resolve_type(module, &parameter.ty);
            self.globals[id.0].parameter_types.push(ty.clone());
            self.local_is_free(module, &parameter.name);
            let name = &parameter.name;
            self.locals.push(Local { name: name.text.clone(), ty, span: name.span });
        }
    }

    /// A function without a body: the compiler has it, and only stdlib may say so.
    fn foreign_body(&mut self, id: GlobalId, ty: Type) -> Typed {
        let (module, name) = (self.globals[id.0].module, self.globals[id.0].name);
        if !self.is_library(module) || Function::find(&name.text).is_none() {
            let message = format!("the function `{}` has no body", name.text);
            self.say(
                Diagnostic::error(codes::E0215, name.span, message)
                    .help(format!("write what it comes to: `fn {}(…) -> … = …`", name.text)),
            );
            return Typed::failed(name.span);
        }
        Typed { span: name.span, ty, kind: TypedKind::None }
    }

    /// Says which values make the circle. All of them fail, so it is said once.
    fn report_circle(&mut self, id: GlobalId, span: Span) {
        let start = self.active.iter().position(|(active, _)| *active == id).unwrap_or(0);
        let circle: Vec<(GlobalId, Span)> = self.active[start..].to_vec();
        let name = self.globals[id.0].name.text.clone();
        let names: Vec<String> = circle.iter().map(|(id, _)| format!("`{}`", self.globals[id.0].name.text)).collect();
        let function = self.globals[id.0].is_function();
        let message = match names.as_slice() {
            [_] | [] if function => format!("the function `{name}` calls itself"),
            [_] | [] => format!("`{name}` is defined by itself"),
            [_, rest @ ..] => {
                let what = if function {
                    format!("the function `{name}` calls itself")
                } else {
                    format!("`{name}` is defined by itself")
                };
                format!("{what}: it uses {}, which uses `{name}`", rest.join(", which uses "))
            }
        };
        let defined = self.globals[id.0].name.span;
        let mut diagnostic = Diagnostic::error(codes::E0208, defined, message);
        for ((_, used), name) in circle.iter().skip(1).zip(&names) {
            diagnostic = diagnostic.also(*used, format!("used by {name}"));
        }
        let last = names.last().cloned().unwrap_or_default();
        self.say(diagnostic.also(span, format!("used by {last}")).help(match function {
            true => {
                "a function may call only others that do not call it; for a row of values write `[… for i in 1 .. 4]`"
            }
            false => "give one of them a value of its own",
        }));
    }
}
