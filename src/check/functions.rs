//! Functions: their names, calls, and the typing rules of those that take any dimension.
//!
//! In: a call, or a name that is local to a function or a list. Out: [`Typed`]. A function written in the language, and
//! most of stdlib's, has full types; there are no generics, so the few that work on any dimension (`abs`, `min`, `sqrt` …)
//! have their rule here.

use super::load::ModuleId;
use super::similar::nearest;
use super::typed::{Callee, Function, GlobalId, Typed, TypedKind};
use super::types::{FunctionEntry, Type};
use super::{Binding, Checker, Local, Place};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::{Expr, ExprKind, Item, Name, Type as TypeSyntax};
use crate::units::{Dimension, Ratio};

impl<'a> Checker<'a> {
    /// The parameter or variable of that name.
    pub(super) fn local(&self, word: &str, span: Span) -> Option<Typed> {
        let slot = self.locals.iter().rposition(|local| local.name == word)?;
        Some(Typed { span, ty: self.locals[slot].ty.clone(), kind: TypedKind::Local(slot) })
    }

    /// Says so if the name of a parameter or variable means something already: in one file a name means one thing.
    pub(super) fn local_is_free(&mut self, module: ModuleId, name: &Name) {
        let first = self.locals.iter().find(|local| local.name == name.text).map(|local| local.span);
        let first = first.or_else(|| self.scopes[module.0].values.get(&name.text).map(|(_, span)| *span));
        if first.is_none() && !self.is_built_in(module, &name.text, false) {
            return;
        }
        let mut diagnostic =
            Diagnostic::error(codes::E0206, name.span, format!("the name `{}` means something else here", name.text))
                .help("choose another name");
        if let Some(first) = first {
            diagnostic = diagnostic.also(first, "defined here");
        }
        self.say(diagnostic);
    }

    /// Adds a local value for the time that `act` runs.
    pub(super) fn with_local<T>(&mut self, name: &Name, ty: Type, act: impl FnOnce(&mut Self) -> T) -> T {
        self.locals.push(Local { name: name.text.clone(), ty, span: name.span });
        let found = act(self);
        self.locals.pop();
        found
    }

    /// Lists a function for documentation: what stands between its doc comment and its body.
    pub(super) fn list_function(&mut self, module: ModuleId, item: &Item, name: &Name, result: Option<&TypeSyntax>) {
        let end = result.map_or(name.span.end, |result| result.span.end);
        let written = self.sources.slice(Span { end, ..item.span });
        let signature = written.split_whitespace().collect::<Vec<_>>().join(" ");
        let library = self.is_library(module);
        self.vocabulary.functions.push(FunctionEntry {
            name: name.text.clone(),
            doc: item.doc.clone(),
            span: name.span,
            signature: signature.strip_prefix("pub ").unwrap_or(&signature).to_string(),
            library,
        });
    }

    /// A function's name where a value is expected.
    pub(super) fn uncalled(&mut self, word: &str, span: Span) -> Typed {
        self.say(
            Diagnostic::error(codes::E0301, span, format!("`{word}` is a function, not a value"))
                .help(format!("call it: `{word}(…)`")),
        );
        Typed::failed(span)
    }

    pub(super) fn call(&mut self, place: Place, callee: &Expr, arguments: &[Expr], span: Span) -> Typed {
        let Some(id) = self.callee(place, callee, arguments, span) else {
            // What stands in the brackets may be wrong as well.
            for argument in arguments {
                self.expression(place, argument, None);
            }
            return Typed::failed(span);
        };
        let word = self.globals[id.0].name.text.clone();
        let built_in = match self.is_library(self.globals[id.0].module) {
            true => Function::find(&word),
            false => None,
        };
        let body = self.use_global(id, callee.span);
        if body.ty.is_failed() && built_in.is_none() {
            return Typed::failed(span);
        }
        let parameters = self.globals[id.0].parameters.unwrap_or_default();
        let many = matches!(built_in, Some(Function::Min | Function::Max));
        if arguments.len() < parameters.len() || (arguments.len() > parameters.len() && !many) {
            let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name.text.as_str()).collect();
            let more = if many { ", …" } else { "" };
            let message = format!("`{word}` takes {}, found {}", count(parameters.len(), many), arguments.len());
            let help = format!("write `{word}({}{more})`", names.join(", "));
            self.say(Diagnostic::error(codes::E0307, span, message).help(help));
            return Typed::failed(span);
        }
        let mut typed: Vec<Typed> = Vec::with_capacity(arguments.len());
        for (index, argument) in arguments.iter().enumerate() {
            let index = index.min(parameters.len().saturating_sub(1));
            let ty = self.globals[id.0].parameter_types.get(index).cloned().unwrap_or(Type::Failed);
            let name = parameters.get(index).map_or("value", |parameter| parameter.name.text.as_str());
            typed.push(self.wanted(place, argument, ty, format!("the `{name}` of `{word}`")));
        }
        if typed.iter().any(|argument| argument.ty.is_failed()) {
            return Typed::failed(span);
        }
        let callee = built_in.map_or(Callee::Written(id), Callee::BuiltIn);
        let ty = match built_in.map(|function| self.any_dimension(function, &typed, arguments, span)) {
            Some(Some(ty)) => ty,
            Some(None) => return Typed::failed(span),
            None => self.globals[id.0].ty.clone(),
        };
        let ty = if ty.is_failed() { self.globals[id.0].ty.clone() } else { ty };
        Typed { span, ty, kind: TypedKind::Call(callee, typed) }
    }

    /// The function that is called; what is wrong with its name is said.
    fn callee(&mut self, place: Place, callee: &Expr, arguments: &[Expr], whole: Span) -> Option<GlobalId> {
        let (module, name, binding) = match &callee.kind {
            ExprKind::Name(word) => {
                let is_function =
                    |binding: &Binding| matches!(binding, Binding::Global(id) if self.globals[id.0].is_function());
                let core = self.core.values.get(word).map(|(binding, _)| *binding);
                let own = self.binding(place.module, word).filter(|own| is_function(own) || core.is_none());
                (place.module, word.as_str(), own.or(core))
            }
            ExprKind::Member(base, name) => match &base.kind {
                ExprKind::Name(word) => match self.scopes[place.module.0].values.get(word).map(|(b, _)| *b) {
                    Some(Binding::Module(module)) => {
                        let inside = self.scopes[module.0].values.get(&name.text).map(|(binding, _)| *binding);
                        if let Some(Binding::Global(id)) = inside
                            && self.globals[id.0].is_function()
                            && !self.globals[id.0].public
                        {
                            let path = self.modules[module.0].path.clone();
                            let message = format!("`{}` is private to `{path}`", name.text);
                            let defined = self.globals[id.0].name.span;
                            self.say(
                                Diagnostic::error(codes::E0207, name.span, message)
                                    .also(defined, "defined here without `pub`")
                                    .help(format!("write `pub fn {}(…)` there", name.text)),
                            );
                            return None;
                        }
                        (module, name.text.as_str(), inside)
                    }
                    Some(Binding::Failed) => return None,
                    _ => (place.module, "", None),
                },
                _ => (place.module, "", None),
            },
            ExprKind::Missing => return None,
            _ => (place.module, "", None),
        };
        match binding {
            Some(Binding::Global(id)) if self.globals[id.0].is_function() => Some(id),
            Some(Binding::Failed) => None,
            Some(_) => {
                let message = format!("`{name}` is a value, and only a function can be called");
                self.say(Diagnostic::error(codes::E0307, callee.span, message).help("leave out the brackets"));
                None
            }
            None if name.is_empty() => {
                self.say(Diagnostic::error(codes::E0307, callee.span, "only a function can be called"));
                None
            }
            None => {
                // Of `shop.thrice` only the last word is wrong.
                let said = if let ExprKind::Member(_, name) = &callee.kind { name.span } else { callee.span };
                self.say_unknown_function(place, module, name, said, (arguments, whole));
                None
            }
        }
    }

    fn say_unknown_function(
        &mut self,
        place: Place,
        module: ModuleId,
        word: &str,
        span: Span,
        (arguments, whole): (&[Expr], Span),
    ) {
        if self.may_be_broken(module) {
            return;
        }
        let mut diagnostic = Diagnostic::error(codes::E0201, span, format!("there is no function `{word}`"));
        let own = self.scopes[module.0].values.iter().chain(&self.core.values);
        let names = own.filter_map(|(name, (binding, _))| match binding {
            Binding::Global(id) if self.globals[id.0].is_function() => Some(name.as_str()),
            _ => None,
        });
        if let Some(near) = nearest(word, names) {
            diagnostic = diagnostic.help(format!("did you mean `{near}`?")).suggest(span, near);
        } else {
            diagnostic = self.with_schema_called(place.module, word, arguments, whole, diagnostic);
        }
        self.say(diagnostic);
    }

    /// The result's type by the function's own rule; [`Type::Failed`] if it has none, and nothing if it was broken.
    fn any_dimension(&mut self, function: Function, typed: &[Typed], arguments: &[Expr], span: Span) -> Option<Type> {
        match function {
            Function::Sqrt => {
                let dimension = self.quantity_of(function, typed.first()?, span)?;
                let half = Ratio::new(1, 2).and_then(|half| dimension.power(half));
                if half.is_none() {
                    self.say(Diagnostic::error(codes::E0306, span, "the power of this dimension is too large"));
                }
                half.map(Type::Quantity)
            }
            Function::Abs => self.quantity_of(function, typed.first()?, span).map(Type::Quantity),
            Function::Min | Function::Max | Function::Atan2 => {
                let mut dimensions = Vec::new();
                for argument in typed {
                    dimensions.push(self.quantity_of(function, argument, span)?);
                }
                let first = *dimensions.first()?;
                if let Some(other) = dimensions.iter().position(|dimension| *dimension != first) {
                    let verb = if function == Function::Atan2 { "take the angle of" } else { "compare" };
                    self.unequal_sides(verb, span, (&typed[0], &arguments[0]), (&typed[other], &arguments[other]));
                    return None;
                }
                Some(Type::Quantity(if function == Function::Atan2 { Dimension::ANGLE } else { first }))
            }
            Function::Sum => match typed.first()?.ty.required() {
                Type::List(element, _) if element.dimension().is_some() => Some(element.as_ref().clone()),
                Type::List(element, _) if element.is_failed() => {
                    let message = "the sum of an empty list has no dimension";
                    self.say(Diagnostic::error(codes::E0307, typed.first()?.span, message).help("put something in it"));
                    None
                }
                _ => self.not_a_list(function, typed.first()?),
            },
            Function::Count => match typed.first()?.ty.required() {
                Type::List(..) => Some(Type::Integer),
                _ => self.not_a_list(function, typed.first()?),
            },
            _ => Some(Type::Failed),
        }
    }

    fn not_a_list(&mut self, function: Function, argument: &Typed) -> Option<Type> {
        let what = if function == Function::Sum { "a list of numbers" } else { "a list" };
        let found = self.vocabulary.in_words(&argument.ty);
        let message = format!("`{}` needs {what}, found {found}", function.name());
        self.say(Diagnostic::error(codes::E0301, argument.span, message));
        None
    }

    fn quantity_of(&mut self, function: Function, argument: &Typed, span: Span) -> Option<Dimension> {
        let dimension = argument.ty.dimension();
        if dimension.is_none() {
            self.wrong_operand(function.name(), argument, span);
        }
        dimension
    }
}

fn count(number: usize, many: bool) -> String {
    let more = if many { " or more" } else { "" };
    match number {
        0 => "no argument".into(),
        1 => format!("one argument{more}"),
        2 => format!("two arguments{more}"),
        n => format!("{n} arguments{more}"),
    }
}
