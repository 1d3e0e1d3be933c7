//! Records: which schema, which fields, what is unknown, doubled or missing.

use super::load::ModuleId;
use super::similar::nearest;
use super::typed::{FieldValue, Typed, TypedKind};
use super::types::{FamilyId, Field, SchemaId, Type, listed};
use super::{CheckedJob, Checker, Place, Want, Wave};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::{FileId, Span};
use crate::syntax::ast::{Block, EntryKind, Expr, ExprKind, Name};

/// What stands for the value of a field that has none.
const MISSING: Expr = Expr { span: Span { file: FileId(0), start: 0, end: 0 }, kind: ExprKind::Missing };

/// The first sentence of a doc comment, on one line.
fn first_sentence(doc: &str) -> String {
    let line = doc.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.find(". ") {
        Some(at) => line[..=at].to_string(),
        None => line,
    }
}

fn listed_fields(fields: &[Field]) -> String {
    match fields {
        [] => "no fields".into(),
        fields => format!("the fields {}", listed(fields.iter().map(|field| field.name.as_str()))),
    }
}

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
        // Of a record without a name only the bracket: what stands in it may be right.
        let said = name.map_or(Span { end: body.span.start + 1, ..body.span }, |name| name.span);
        let schema = match (name, &wanted) {
            (Some(name), Some(Type::Family(family))) => self.meant_kind(*family, schema, name, body),
            _ => schema,
        };
        self.record(place, schema, body, span, said)
    }

    /// The member of the family whose fields are given here: another than the one that is named, if none of the fields is
    /// the named one's and all of them are the other's. That is one mistake, the name, and it is said.
    fn meant_kind(&mut self, family: FamilyId, named: SchemaId, name: &Name, body: &Block) -> SchemaId {
        let given: Vec<&str> = body
            .entries
            .iter()
            .filter_map(|entry| match &entry.kind {
                EntryKind::Field { name, .. } => Some(name.text.as_str()),
                EntryKind::Expr(_) => None,
            })
            .collect();
        let shape = self.vocabulary.schema(named);
        if given.is_empty() || given.iter().any(|field| shape.field(field).is_some()) {
            return named;
        }
        let fits = |member: &&SchemaId| {
            let other = self.vocabulary.schema(**member);
            given.iter().all(|field| other.field(field).is_some())
                && other.fields.iter().all(|field| !field.is_required() || given.contains(&field.name.as_str()))
        };
        let members: Vec<SchemaId> = self.vocabulary.family(family).members.iter().filter(fits).copied().collect();
        let [meant] = members.as_slice() else { return named };
        let (other, shape) = (self.vocabulary.schema(*meant).name.clone(), shape.name.clone());
        self.say(
            Diagnostic::error(codes::E0401, name.span, format!("this `{shape}` is given the fields of `{other}`"))
                .note(format!("`{shape}` has {}", listed_fields(&self.vocabulary.schema(named).fields)))
                .help(format!("did you mean `{other}`?"))
                .suggest(name.span, other),
        );
        *meant
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
        // Where in the diagnostics the fields stand that nobody knows.
        let mut unknown: Vec<usize> = Vec::new();
        let mut rest: Vec<(Option<&Name>, &Expr)> = Vec::new();
        for entry in &body.entries {
            match &entry.kind {
                EntryKind::Field { name, value } if !skip(name) => match self.swallowed_by(schema, name, value) {
                    Some(next) => rest.extend([(Some(name), &MISSING), (Some(next), value)]),
                    None => rest.push((Some(name), value)),
                },
                EntryKind::Field { .. } => {}
                EntryKind::Expr(expr) => rest.push((None, expr)),
            }
        }
        for (name, value) in rest {
            let name = match name {
                Some(name) if skip(name) => continue,
                Some(name) => name,
                None if value.kind == ExprKind::Missing => continue,
                None => {
                    let message =
                        format!("a `{}` has fields, and this is not one", self.vocabulary.schema(schema).name);
                    self.say(Diagnostic::error(codes::E0408, value.span, message).help("write `name: value`"));
                    stray = true;
                    continue;
                }
            };
            let found = self.vocabulary.schema(schema).field(&name.text).map(|f| (f.name.clone(), f.ty.clone()));
            let (field, ty) = match found {
                Some(found) => found,
                None if self.is_nameless_record(place, schema, name, value) => {
                    self.say_nameless_record(place, schema, name, value, &given);
                    stray = true;
                    continue;
                }
                None => match self.say_unknown_field(schema, name) {
                    // What was meant is clear enough to check the value, and to not call the field missing.
                    Some(meant) => (meant.name, meant.ty),
                    None => {
                        unknown.push(self.diagnostics.len().saturating_sub(1));
                        continue;
                    }
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
            let value = match (&value.kind, want.ty.required()) {
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
        // A field that nobody knows and a field that is missing are one mistake, a wrong name.
        if let Some(first) = unknown.first() {
            let shape = self.vocabulary.schema(schema);
            let missing: Vec<&str> = self.missing(schema, &given).iter().map(|field| field.name.as_str()).collect();
            if !missing.is_empty() && !stray {
                let note = format!("`{}` lacks {}", shape.name, listed(missing));
                if let Some(diagnostic) = self.diagnostics.get_mut(*first).filter(|d| d.code == codes::E0401) {
                    diagnostic.notes.push(note);
                }
                stray = true;
            }
        }
        (given, stray)
    }

    /// The field that a field without a value has swallowed: after `wavelength:` a line `workpiece { … }` is read as its
    /// value. Said, if no value of that kind can stand there.
    fn swallowed_by<'e>(&mut self, schema: SchemaId, name: &Name, value: &'e Expr) -> Option<&'e Name> {
        let ExprKind::Record { schema: Some(next), .. } = &value.kind else { return None };
        let shape = self.vocabulary.schema(schema);
        let ty = shape.field(&name.text)?.ty.required().clone();
        let is_field = shape.field(&next.text).is_some() || (shape.name == "job" && next.text == "require");
        let takes = match ty {
            Type::Schema(schema) => self.vocabulary.schema(schema).name == next.text,
            Type::Family(family) => self.member_named(family, &next.text).is_some(),
            _ => false,
        };
        let line = |span: Span| self.sources.line_column(span.file, span.start as usize).0;
        if !is_field || takes || line(next.span) == line(name.span) {
            return None;
        }
        let message = format!("`{}` has no value", name.text);
        self.say(
            Diagnostic::error(codes::E0106, name.span, message).help("write a value after `:`, or delete the field"),
        );
        Some(next)
    }

    /// Whether an entry `frame { … }` is a value whose field's name was forgotten, rather than a field with a wrong name.
    fn is_nameless_record(&self, place: Place, schema: SchemaId, name: &Name, value: &Expr) -> bool {
        let ExprKind::Record { schema: Some(short), .. } = &value.kind else { return false };
        let shape = self.vocabulary.schema(schema);
        // What a field here takes is meant, however much its name looks like that of another field.
        let misspelt = || nearest(&name.text, shape.fields.iter().map(|field| field.name.as_str())).is_some();
        short.span == name.span
            && (!self.fields_for(schema, name).is_empty()
                || (!misspelt() && self.schema_named(place.module, &name.text).is_some()))
    }

    /// The fields of a schema that take a record of this kind.
    fn fields_for(&self, schema: SchemaId, kind: &Name) -> Vec<&Field> {
        let takes = |ty: &Type| match ty.required() {
            Type::Schema(schema) => self.vocabulary.schema(*schema).name == kind.text,
            Type::Family(family) => self.member_named(*family, &kind.text).is_some(),
            _ => false,
        };
        self.vocabulary.schema(schema).fields.iter().filter(|field| takes(&field.ty)).collect()
    }

    fn say_nameless_record(&mut self, place: Place, schema: SchemaId, name: &Name, value: &Expr, given: &[FieldValue]) {
        let open: Vec<&Field> = self
            .fields_for(schema, name)
            .into_iter()
            .filter(|field| given.iter().all(|given| given.name != field.name))
            .collect();
        let message = format!("this `{}` does not say which field it is", name.text);
        let mut diagnostic = Diagnostic::error(codes::E0122, name.span, message);
        let owner = &self.vocabulary.schema(schema).name;
        diagnostic = match open.as_slice() {
            [] => diagnostic.note(format!("no field of `{owner}` takes it")),
            [one] => diagnostic
                .help(format!("write `{}: {} {{ … }}`", one.name, name.text))
                .suggest(Span { end: name.span.start, ..name.span }, format!("{}: ", one.name)),
            several => diagnostic
                .note(format!("fields that take it: {}", listed(several.iter().map(|field| field.name.as_str()))))
                .help(format!("write the field's name before it: `{}: {} {{ … }}`", several[0].name, name.text)),
        };
        let kind = open.first().and_then(|field| match field.ty.required() {
            Type::Family(family) => self.member_named(*family, &name.text),
            _ => None,
        });
        let taken = !open.is_empty();
        self.say(diagnostic);
        // What stands in it is looked at all the same, unless nothing here takes such a record: then all of it is out of
        // place, and its own records would each say so again.
        if let ExprKind::Record { body, .. } = &value.kind
            && taken
            && let Some(kind) = kind.or_else(|| self.schema_named(place.module, &name.text))
        {
            self.record(place, kind, body, value.span, name.span);
        }
    }

    /// The fields that a record must give and does not.
    fn missing(&self, schema: SchemaId, given: &[FieldValue]) -> Vec<&Field> {
        let fields = &self.vocabulary.schema(schema).fields;
        fields.iter().filter(|field| field.is_required() && !given.iter().any(|g| g.name == field.name)).collect()
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
        let missing = self.missing(schema, given);
        let schema = self.vocabulary.schema(schema);
        if missing.is_empty() {
            return;
        }
        let message = format!("`{}` lacks {}", schema.name, listed(missing.iter().map(|field| field.name.as_str())));
        let mut diagnostic = Diagnostic::error(codes::E0402, said, message);
        for field in missing {
            let doc = first_sentence(&field.doc);
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
            // A line without a name may be the wavelength; that it has none is said.
            EntryKind::Expr(expr) => expr.kind != ExprKind::Missing,
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
