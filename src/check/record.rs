//! Records: which schema, which fields, what is unknown, doubled or missing.

use super::load::ModuleId;
use super::similar::nearest;
use super::typed::{FieldValue, Typed, TypedKind};
use super::types::{Field, SchemaId, Type, listed};
use super::{CheckedJob, Checker, Place, Want, Wave};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;
use crate::syntax::ast::{Block, EntryKind, Expr, ExprKind, Name};

impl Checker<'_> {
    /// A schema's name alone stands for its record with nothing given: `plane` is `plane {}`.
    pub(super) fn bare_record(&mut self, schema: SchemaId, span: Span) -> Typed {
        self.say_missing(schema, &[], span);
        Typed { span, ty: Type::Schema(schema), kind: TypedKind::Record(schema, Vec::new()) }
    }

    pub(super) fn record_expression(
        &mut self,
        place: Place,
        name: Option<&Name>,
        body: &Block,
        span: Span,
        want: Option<&Want>,
    ) -> Typed {
        let wanted = want.map(|want| want.ty.required().clone());
        let schema = match (name, &wanted) {
            (Some(name), Some(Type::Family(family))) => {
                self.member_named(*family, &name.text).or_else(|| self.schema_named(place.module, &name.text))
            }
            (Some(name), _) => self.schema_named(place.module, &name.text),
            (None, Some(Type::Schema(schema))) => Some(*schema),
            (None, Some(Type::Failed)) => return Typed::failed(span),
            (None, wanted) => {
                let start = Span::new(body.span.file, body.span.start as usize, body.span.start as usize + 1);
                let what = want.map_or_else(|| "this record".to_string(), |want| want.what.clone());
                match wanted {
                    Some(Type::Family(family)) => {
                        let members = self.vocabulary.members(*family);
                        let example = members.first().cloned().unwrap_or_default();
                        self.say(
                            Diagnostic::error(codes::E0410, start, format!("{what} does not say which kind it is"))
                                .note(format!("it is one of {}", listed(members.iter().map(String::as_str))))
                                .help(format!("write the kind before the bracket: `{example} {{ … }}`")),
                        );
                    }
                    Some(other) => {
                        let message = format!("{what} expects {}, found a record", self.vocabulary.in_words(other));
                        self.say(Diagnostic::error(codes::E0301, start, message));
                    }
                    None => self.say(
                        Diagnostic::error(codes::E0410, start, "this record does not say which kind it is")
                            .help("write its schema before the bracket: `frame { … }`"),
                    ),
                }
                return Typed::failed(span);
            }
        };
        let Some(schema) = schema else {
            if let Some(name) = name {
                match &wanted {
                    // `tool { … }` where `tool` is the field, and no schema has its name.
                    Some(Type::Family(family)) if want.is_some_and(|want| want.what == format!("`{}`", name.text)) => {
                        let members = self.vocabulary.members(*family);
                        let example = members.first().cloned().unwrap_or_default();
                        let message = format!("`{}` does not say which kind it is", name.text);
                        self.say(
                            Diagnostic::error(codes::E0410, name.span, message)
                                .note(format!("it is one of {}", listed(members.iter().map(String::as_str))))
                                .help(format!("write `{}: {example} {{ … }}`", name.text)),
                        );
                    }
                    _ => self.say_unknown_schema(place, name, want),
                }
            }
            return Typed::failed(span);
        };
        // A record of the wrong kind is one mistake; its fields are not looked at.
        if let Some(wanted) = &wanted
            && !self.vocabulary.fits(&Type::Schema(schema), wanted)
        {
            let span = name.map_or(span, |name| name.span);
            return Typed { span, ty: Type::Schema(schema), kind: TypedKind::Failed };
        }
        self.record(place, schema, body, span, name.map_or(span, |name| name.span))
    }

    /// A record of a known schema. `said` is where a missing field is reported.
    fn record(&mut self, place: Place, schema: SchemaId, body: &Block, span: Span, said: Span) -> Typed {
        let (fields, stray) = self.entries(place, schema, body, |_| false);
        if !stray {
            self.say_missing_in(place.module, schema, &fields, said, body);
        }
        Typed { span, ty: Type::Schema(schema), kind: TypedKind::Record(schema, fields) }
    }

    pub(super) fn with(&mut self, place: Place, base: &Expr, body: &Block, span: Span) -> Typed {
        let base = self.expression(place, base, None);
        match base.ty.required() {
            Type::Schema(schema) => {
                let schema = *schema;
                let (fields, _) = self.entries(place, schema, body, |_| false);
                Typed { span, ty: Type::Schema(schema), kind: TypedKind::With(Box::new(base), fields) }
            }
            Type::Failed => Typed::failed(span),
            other => {
                let message =
                    format!("`with` changes fields of a record, and this is {}", self.vocabulary.in_words(other));
                self.say(Diagnostic::error(codes::E0311, base.span, message));
                Typed::failed(span)
            }
        }
    }

    /// The fields that a block gives, each once and of its type, and whether something stands there without a name:
    /// it may be a field that would be missed. Entries that `skip` takes are left alone.
    fn entries(
        &mut self,
        place: Place,
        schema: SchemaId,
        body: &Block,
        skip: impl Fn(&Name) -> bool,
    ) -> (Vec<FieldValue>, bool) {
        let mut given: Vec<FieldValue> = Vec::new();
        let mut stray = false;
        for entry in &body.entries {
            let (name, value) = match &entry.kind {
                EntryKind::Field { name, .. } if skip(name) => continue,
                EntryKind::Field { name, value } => (name, value),
                EntryKind::Expr(Expr { kind: ExprKind::Missing, .. }) => continue,
                EntryKind::Expr(expr) => {
                    let message =
                        format!("a `{}` has fields, and this is not one", self.vocabulary.schema(schema).name);
                    self.say(Diagnostic::error(codes::E0408, expr.span, message).help("write `name: value`"));
                    stray = true;
                    continue;
                }
            };
            let found = self.vocabulary.schema(schema).field(&name.text).map(|f| (f.name.clone(), f.ty.clone()));
            let (field, ty) = match found {
                Some(found) => found,
                None => match self.say_unknown_field(schema, name) {
                    // What was meant is clear enough to check the value, and to not call the field missing.
                    Some(meant) => (meant.name, meant.ty),
                    None => continue,
                },
            };
            if let Some(first) = given.iter().find(|f| f.name == field) {
                let message = format!("the field `{field}` is given twice");
                let first = first.name_span;
                self.say(
                    Diagnostic::error(codes::E0403, name.span, message).also(first, "the first one").help("keep one"),
                );
                continue;
            }
            let want = Want { ty, what: format!("`{}`", name.text), unit: self.unit_of_limits(schema, &field) };
            // The short form `workpece { … }` has one misspelt word, not two.
            let value = match (&value.kind, &want.ty) {
                (ExprKind::Record { schema: Some(short), body }, Type::Schema(schema))
                    if short.span == name.span && field != name.text =>
                {
                    self.record(place, *schema, body, value.span, short.span)
                }
                _ => {
                    // The wavelength itself cannot be counted in wavelengths.
                    let place = match field == "wavelength" && place.wave == Wave::Stated {
                        true => Place { wave: Wave::NotStated, ..place },
                        false => place,
                    };
                    self.expression(place, value, Some(&want))
                }
            };
            given.push(FieldValue { name: field, name_span: name.span, value });
        }
        (given, stray)
    }

    /// Says that there is no such field; gives the one that was meant, if that is plain.
    pub(super) fn say_unknown_field(&mut self, schema: SchemaId, name: &Name) -> Option<Field> {
        let schema = self.vocabulary.schema(schema);
        // A syntax error in the schema's file may have swallowed the field's declaration.
        if self.modules.iter().any(|module| module.file == schema.span.file && !module.broken.is_empty())
            && !schema.library
        {
            return None;
        }
        let message = format!("`{}` has no field `{}`", schema.name, name.text);
        let mut diagnostic = Diagnostic::error(codes::E0401, name.span, message);
        let names = || schema.fields.iter().map(|field| field.name.as_str());
        let near = nearest(&name.text, names()).and_then(|near| schema.field(near)).cloned();
        if let Some(near) = &near {
            diagnostic =
                diagnostic.help(format!("did you mean `{}`?", near.name)).suggest(name.span, near.name.clone());
        }
        diagnostic = match schema.fields.len() {
            0 => diagnostic.note(format!("`{}` has no fields", schema.name)),
            _ => diagnostic.note(format!("its fields: {}", listed(names()))),
        };
        self.say(diagnostic);
        near
    }

    fn say_missing_in(&mut self, module: ModuleId, schema: SchemaId, given: &[FieldValue], said: Span, body: &Block) {
        // A syntax error inside the brackets may have swallowed the field.
        let inside = |place: &Span| body.span.start <= place.start && place.start <= body.span.end;
        if self.modules[module.0].broken.iter().any(inside) {
            return;
        }
        self.say_missing(schema, given, said);
    }

    fn say_missing(&mut self, schema: SchemaId, given: &[FieldValue], said: Span) {
        let schema = self.vocabulary.schema(schema);
        let missing: Vec<&Field> = schema
            .fields
            .iter()
            .filter(|field| field.is_required() && !given.iter().any(|g| g.name == field.name))
            .collect();
        if missing.is_empty() {
            return;
        }
        let message = format!("`{}` lacks {}", schema.name, listed(missing.iter().map(|field| field.name.as_str())));
        let mut diagnostic = Diagnostic::error(codes::E0402, said, message);
        for field in missing {
            let doc = field.doc.lines().next().unwrap_or_default().trim();
            let doc = if doc.is_empty() { String::new() } else { format!(" ({doc})") };
            diagnostic = diagnostic.note(format!("`{}: {}`{doc}", field.name, field.type_text));
        }
        self.say(diagnostic.help("state it; there is no default that would be safe for every part"));
    }

    pub(super) fn job(&mut self, module: ModuleId, name: &Name, body: &Block) -> CheckedJob {
        // A misspelt `wavelength` is one mistake; that `wave` then lacks a meaning is not another.
        let fields = self.core.schemas.get("job").map(|schema| &self.vocabulary.schema(*schema).fields);
        let meant = |word: &str| nearest(word, fields.into_iter().flatten().map(|field| field.name.as_str()));
        let states_wavelength = body.entries.iter().any(|entry| match &entry.kind {
            EntryKind::Field { name, value } => meant(&name.text) == Some("wavelength") && value.kind != ExprKind::None,
            EntryKind::Expr(_) => false,
        });
        let wave = if states_wavelength { Wave::Stated } else { Wave::NotStated };
        let place = Place { module, wave, results: false, siblings: None };
        let mut requirements = Vec::new();
        let mut first: Option<Span> = None;
        for entry in &body.entries {
            let EntryKind::Field { name, value } = &entry.kind else { continue };
            if name.text != "require" {
                continue;
            }
            if let Some(first) = first {
                let message = "the field `require` is given twice";
                self.say(
                    Diagnostic::error(codes::E0403, name.span, message)
                        .also(first, "the first one")
                        .help("put all lines into one `require`"),
                );
                continue;
            }
            first = Some(name.span);
            requirements.extend(self.require(place, value));
        }
        let record = match self.core.schemas.get("job").copied() {
            Some(schema) => {
                let (fields, stray) = self.entries(place, schema, body, |name| name.text == "require");
                if !stray {
                    self.say_missing_in(module, schema, &fields, name.span, body);
                }
                Typed { span: name.span, ty: Type::Schema(schema), kind: TypedKind::Record(schema, fields) }
            }
            None => Typed::failed(name.span),
        };
        CheckedJob { name: name.text.clone(), name_span: name.span, record, requirements }
    }

    fn require(&mut self, place: Place, value: &Expr) -> Vec<Typed> {
        let place = Place { results: true, ..place };
        let ExprKind::Record { body, .. } = &value.kind else {
            if !matches!(value.kind, ExprKind::Missing) {
                let message = "`require` holds conditions in brackets";
                let help = "write `require { result.motion.time <= 3 h }`";
                self.say(Diagnostic::error(codes::E0408, value.span, message).help(help));
            }
            return Vec::new();
        };
        let mut requirements = Vec::new();
        for entry in &body.entries {
            match &entry.kind {
                EntryKind::Expr(expr) => requirements.push(self.wanted(place, expr, Type::Bool, "`require`".into())),
                EntryKind::Field { name, .. } => {
                    let message = format!("`require` holds conditions, and `{}:` is a field", name.text);
                    let help = "write a comparison: `result.motion.time <= 3 h`";
                    self.say(Diagnostic::error(codes::E0408, name.span, message).help(help));
                }
            }
        }
        requirements
    }
}
