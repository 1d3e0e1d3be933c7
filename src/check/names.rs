//! Names: what a word means where it stands, and what to say when it means nothing.

use super::load::ModuleId;
use super::similar::nearest;
use super::typed::{Typed, TypedKind};
use super::types::{FamilyId, SchemaId, Type, listed};
use super::{Binding, Checker, Place, Want};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::Name;

/// Types that are neither dimensions nor schemas.
pub(super) const BUILT_IN_TYPES: [&str; 6] = ["Number", "Integer", "Bool", "Text", "File", "Date"];

impl Checker<'_> {
    /// Whether the language itself gives the word a meaning: `pi`, `result`, and the functions for a function. A value may
    /// be called `count` beside the function `count(…)`: the brackets tell them apart.
    pub(super) fn is_built_in(&self, module: ModuleId, word: &str, function: bool) -> bool {
        word == "pi"
            || word == "result"
            || (function && !self.is_library(module) && self.core.values.contains_key(word))
    }

    /// What the word means among the values of a file and of stdlib's core.
    pub(super) fn binding(&self, module: ModuleId, word: &str) -> Option<Binding> {
        let own = self.scopes[module.0].values.get(word).or_else(|| self.core.values.get(word));
        own.map(|(binding, _)| *binding)
    }

    /// A word that stands for a value: a symbol, a family's member, a value, a schema.
    pub(super) fn name(&mut self, place: Place, word: &str, span: Span, want: Option<&Want>) -> Typed {
        let wanted = want.map(|want| want.ty.required());
        if let Some(Type::Symbols(symbols)) = wanted
            && symbols.iter().any(|symbol| symbol.name == word)
        {
            return Typed { span, ty: wanted.cloned().unwrap_or(Type::Failed), kind: TypedKind::Symbol(word.into()) };
        }
        if let Some(Type::Family(family)) = wanted
            && let Some(member) = self.member_named(*family, word)
        {
            return self.bare_record(member, span);
        }
        if let Some(schema) = place.siblings
            && let Some(field) = self.vocabulary.schema(schema).field(word)
        {
            return Typed { span, ty: field.ty.required().clone(), kind: TypedKind::SiblingField(word.into()) };
        }
        if let Some(local) = self.local(word, span) {
            return local;
        }
        match self.binding(place.module, word) {
            Some(Binding::Global(function)) if self.globals[function.0].is_function() => {
                return self.uncalled(word, span);
            }
            Some(Binding::Global(global)) => return self.use_global(global, span),
            Some(Binding::Failed) => return Typed::failed(span),
            Some(Binding::Module(module)) => {
                let example = self.public_values(module).first().cloned().unwrap_or_else(|| "name".into());
                self.say(
                    Diagnostic::error(codes::E0301, span, format!("`{word}` is a file, not a value"))
                        .help(format!("write which of its values: `{word}.{example}`")),
                );
                return Typed::failed(span);
            }
            None => {}
        }
        match word {
            "pi" => {
                return Typed { span, ty: Type::NUMBER, kind: TypedKind::Number(std::f64::consts::PI, None) };
            }
            "result" => return self.misplaced_result(place, span),
            _ => {}
        }
        if let Some(schema) = self.schema_named(place.module, word) {
            return self.bare_record(schema, span);
        }
        self.say_unknown_value(place, word, span, want);
        Typed::failed(span)
    }

    pub(super) fn misplaced_result(&mut self, place: Place, span: Span) -> Typed {
        let diagnostic = if place.results {
            Diagnostic::error(codes::E0217, span, "`result` alone is not a value")
                .help("write which result: `result.predicted.rms`")
        } else {
            Diagnostic::error(codes::E0216, span, "`result` may be used only in `require`")
                .note("results are known when everything else is done, so nothing else can depend on them")
        };
        self.say(diagnostic);
        Typed::failed(span)
    }

    pub(super) fn schema_named(&self, module: ModuleId, word: &str) -> Option<SchemaId> {
        self.scopes[module.0].schemas.get(word).or_else(|| self.core.schemas.get(word)).copied()
    }

    pub(super) fn member_named(&self, family: FamilyId, word: &str) -> Option<SchemaId> {
        let members = &self.vocabulary.family(family).members;
        members.iter().copied().find(|member| self.vocabulary.schema(*member).name == word)
    }

    /// The public values of a file, in the order of the alphabet.
    pub(super) fn public_values(&self, module: ModuleId) -> Vec<String> {
        let values = &self.scopes[module.0].values;
        let public = |binding: &Binding| match binding {
            Binding::Global(id) => self.globals[id.0].public && !self.globals[id.0].is_function(),
            _ => false,
        };
        values.iter().filter(|(_, (binding, _))| public(binding)).map(|(name, _)| name.clone()).collect()
    }

    /// `cell.mrf`: a value of another file.
    pub(super) fn value_of_module(&mut self, module: ModuleId, name: &Name) -> Typed {
        let path = self.modules[module.0].path.clone();
        match self.scopes[module.0].values.get(&name.text) {
            Some((Binding::Global(id), defined)) => {
                let (id, defined) = (*id, *defined);
                if !self.globals[id.0].public {
                    let message = format!("`{}` is private to `{path}`", name.text);
                    self.say(
                        Diagnostic::error(codes::E0207, name.span, message)
                            .also(defined, "defined here without `pub`")
                            .help(format!("write `pub let {} = …` there", name.text)),
                    );
                    return Typed::failed(name.span);
                }
                if self.globals[id.0].is_function() {
                    return self.uncalled(&name.text, name.span);
                }
                self.use_global(id, name.span)
            }
            Some((Binding::Failed, _)) => Typed::failed(name.span),
            Some((Binding::Module(_), _)) | None => {
                if !self.may_be_broken(module) {
                    let known = self.public_values(module);
                    let mut diagnostic =
                        Diagnostic::error(codes::E0201, name.span, format!("`{path}` has no value `{}`", name.text));
                    if let Some(near) = nearest(&name.text, known.iter().map(String::as_str)) {
                        diagnostic = diagnostic.help(format!("did you mean `{near}`?")).suggest(name.span, near);
                    }
                    self.say(match known.len() {
                        0 => diagnostic.note("it has no public values"),
                        _ => {
                            diagnostic.note(format!("its public values: {}", listed(known.iter().map(String::as_str))))
                        }
                    });
                }
                Typed::failed(name.span)
            }
        }
    }

    /// Whether a syntax error outside all items may have swallowed a definition of this file.
    pub(super) fn may_be_broken(&self, module: ModuleId) -> bool {
        let module = &self.modules[module.0];
        let inside = |place: &Span| {
            module.ast.items.iter().any(|item| item.span.start <= place.start && place.end <= item.span.end)
        };
        module.broken.iter().any(|place| !inside(place))
    }

    /// Whether the word may be what a `use` that failed would have brought: of `use "cel.polish"`, `cell`.
    fn is_near_failed(&self, module: ModuleId, word: &str) -> bool {
        let values = &self.scopes[module.0].values;
        let failed = values.iter().filter(|(_, (binding, _))| matches!(binding, Binding::Failed));
        nearest(word, failed.map(|(name, _)| name.as_str())).is_some()
    }

    fn say_unknown_value(&mut self, place: Place, word: &str, span: Span, want: Option<&Want>) {
        if self.may_be_broken(place.module) || self.is_near_failed(place.module, word) {
            return;
        }
        let scope = &self.scopes[place.module.0];
        let siblings: Vec<String> = place.siblings.map_or_else(Vec::new, |schema| {
            self.vocabulary.schema(schema).fields.iter().map(|field| field.name.clone()).collect()
        });
        let mut diagnostic = match want.map(|want| (want.ty.required(), &want.what)) {
            Some((Type::Symbols(symbols), what)) => {
                let names = || symbols.iter().map(|symbol| symbol.name.as_str());
                let message = format!("{what} cannot be `{word}`");
                let diagnostic =
                    Diagnostic::error(codes::E0309, span, message).note(format!("it is one of {}", listed(names())));
                match nearest(word, names().chain(scope.values.keys().map(String::as_str))) {
                    Some(near) => diagnostic.help(format!("did you mean `{near}`?")).suggest(span, near),
                    None => diagnostic,
                }
            }
            Some((Type::Family(family), _)) => {
                let members = self.vocabulary.members(*family);
                let family = self.vocabulary.family(*family).name.clone();
                let message = format!("there is no value `{word}`, nor is it a `{family}`");
                let diagnostic = Diagnostic::error(codes::E0201, span, message)
                    .note(format!("`{family}` is one of {}", listed(members.iter().map(String::as_str))));
                let names = members.iter().map(String::as_str).chain(scope.values.keys().map(String::as_str));
                match nearest(word, names) {
                    Some(near) => diagnostic.help(format!("did you mean `{near}`?")).suggest(span, near),
                    None => diagnostic,
                }
            }
            _ => {
                let diagnostic = Diagnostic::error(codes::E0201, span, format!("there is no value `{word}`"));
                let names = scope.values.keys().map(String::as_str).chain(siblings.iter().map(String::as_str));
                let names = names.chain(self.locals.iter().map(|local| local.name.as_str()));
                match nearest(word, names.chain(["pi"])) {
                    Some(near) => diagnostic.help(format!("did you mean `{near}`?")).suggest(span, near),
                    None => diagnostic,
                }
            }
        };
        if diagnostic.help.is_none() {
            diagnostic = if self.vocabulary.units.unit(word).is_some() {
                diagnostic
                    .help(format!("`{word}` is a unit: it follows its number, without blanks inside it: `10 mm/s`"))
            } else if let Some(module) = usable_module(word) {
                diagnostic.help(format!("add `use {module}` at the top of the file"))
            } else {
                self.with_meaning(place, word, span, diagnostic)
            };
        }
        self.say(diagnostic);
    }

    pub(super) fn say_unknown_type(&mut self, module: ModuleId, span: Span, word: &str) {
        if self.may_be_broken(module) {
            return;
        }
        let scope = &self.scopes[module.0];
        let names = scope.schemas.keys().chain(scope.families.keys());
        let names = names.chain(self.core.schemas.keys()).chain(self.core.families.keys()).map(String::as_str);
        let names = names.chain(self.vocabulary.units.dimension_names()).chain(BUILT_IN_TYPES);
        let mut diagnostic = Diagnostic::error(codes::E0202, span, format!("there is no type `{word}`"));
        if let Some(near) = nearest(word, names) {
            diagnostic = diagnostic.help(format!("did you mean `{near}`?")).suggest(span, near);
        }
        if let Some((meant, why)) = super::meant::type_meant(&self.vocabulary.units, word) {
            diagnostic.suggestions.clear();
            diagnostic = diagnostic.help(format!("`{word}` {why}: write `{meant}`")).suggest(span, meant);
        }
        self.say(diagnostic);
    }

    pub(super) fn say_unknown_schema(&mut self, place: Place, name: &Name, want: Option<&Want>) {
        if self.may_be_broken(place.module) {
            return;
        }
        let known: Vec<String> = match want.map(|want| want.ty.required()) {
            Some(Type::Family(family)) => self.vocabulary.members(*family),
            Some(Type::Schema(schema)) => vec![self.vocabulary.schema(*schema).name.clone()],
            _ => self.scopes[place.module.0].schemas.keys().chain(self.core.schemas.keys()).cloned().collect(),
        };
        let mut diagnostic = Diagnostic::error(codes::E0202, name.span, format!("there is no schema `{}`", name.text));
        if let Some(near) = nearest(&name.text, known.iter().map(String::as_str)) {
            diagnostic = diagnostic.help(format!("did you mean `{near}`?")).suggest(name.span, near);
        }
        if let Some(want) = want
            && !want.ty.is_failed()
        {
            diagnostic = diagnostic.note(format!("{} expects {}", want.what, self.vocabulary.in_words(&want.ty)));
        }
        self.say(diagnostic);
    }
}

/// The module of stdlib whose `use` would bring `word`.
fn usable_module(word: &str) -> Option<String> {
    let last = |module: &str| module.rsplit('.').next().unwrap_or_default() == word;
    super::library::FILES.iter().find(|file| !file.core && last(file.module)).map(|file| format!("std.{}", file.module))
}
