//! The manual of the vocabulary: what `polishc doc` shows.
//!
//! In: stdlib, as it stands in its files. Out: [`Manual`], every word with its comment and its facts, module by module; as
//! [`text`] for a terminal and as one [`html`] page. Nothing is written twice: a word that stdlib does not explain has no
//! explanation.

pub mod html;
pub mod text;

use crate::check::library::{self, LibraryFile};
use crate::check::similar::nearest;
use crate::check::types::{Family, FamilyId, Field, Schema, SchemaId, Type, Vocabulary};
use crate::eval;
use crate::source::{FileId, Sources, Span};
use crate::syntax::ast::{Item, ItemKind};
use crate::syntax::parse;
use crate::syntax::tokens::{self, TokenKind};
use crate::units::format::units_of;

/// All modules of stdlib.
#[derive(Clone, Debug)]
pub struct Manual {
    pub modules: Vec<Module>,
}

/// A file of stdlib.
#[derive(Clone, Debug)]
pub struct Module {
    /// As after `std.` in a `use`: `path`, `controllers.irc5`.
    pub name: &'static str,
    /// Whether its words need no `use`.
    pub core: bool,
    /// What its first comment says.
    pub doc: String,
    pub entries: Vec<Entry>,
}

/// A word and what it means.
#[derive(Clone, Debug)]
pub struct Entry {
    pub name: String,
    pub doc: String,
    pub kind: Kind,
}

#[derive(Clone, Debug)]
pub enum Kind {
    /// Its members, and the fields that take one: `job.path`.
    Family {
        members: Vec<String>,
        used: Vec<String>,
    },
    Schema {
        family: Option<String>,
        fields: Vec<FieldPage>,
        checks: Vec<String>,
        used: Vec<String>,
    },
    /// A value to `use`: its schema, its text, and the line that brings it.
    Value {
        schema: String,
        text: String,
        line: String,
    },
    /// `tangential(angular_speed: AngularSpeed, radius: Length) -> Speed`.
    Function {
        signature: String,
    },
    /// What it is worth in another unit (nothing for an SI unit) and the dimension.
    Unit {
        worth: Option<String>,
        dimension: String,
    },
    /// What it is made of (nothing for a base) and its units.
    Dimension {
        product: Option<String>,
        units: Vec<String>,
    },
}

/// A field of a schema.
#[derive(Clone, Debug)]
pub struct FieldPage {
    pub name: String,
    pub ty: String,
    pub doc: String,
    pub required: bool,
    pub default: Option<String>,
    /// What a value must keep to, as the schema writes it after `where`.
    pub limit: Option<String>,
    pub usual: Option<String>,
    /// Units that fit, from the smallest.
    pub units: Vec<&'static str>,
    /// Of a symbol set: each with its comment.
    pub symbols: Vec<(String, String)>,
}

impl Kind {
    /// What it is, in a word.
    pub fn word(&self) -> &'static str {
        match self {
            Kind::Family { .. } => "family",
            Kind::Schema { .. } => "schema",
            Kind::Value { .. } => "value",
            Kind::Function { .. } => "function",
            Kind::Unit { .. } => "unit",
            Kind::Dimension { .. } => "dimension",
        }
    }
}

impl Entry {
    /// The first sentence of its comment.
    pub fn brief(&self) -> &str {
        brief(&self.doc)
    }
}

/// The first sentence of a comment, or its first paragraph if that is shorter.
pub fn brief(doc: &str) -> &str {
    let paragraph = doc.split("\n\n").next().unwrap_or_default();
    let line_end = |at: usize| paragraph[at + 1..].chars().next().is_none_or(char::is_whitespace);
    let end = paragraph.char_indices().find(|&(at, c)| c == '.' && line_end(at)).map(|(at, _)| at);
    end.map_or(paragraph, |end| &paragraph[..end])
}

/// What a name leads to.
pub enum Found<'a> {
    /// One word, or several of the same name.
    Words(Vec<(&'a Module, &'a Entry)>),
    /// Fields of that name, each with its schema.
    Fields(Vec<(&'a Entry, &'a FieldPage)>),
    /// Nothing, but this name is near.
    Near(String),
    Nothing,
}

impl Manual {
    /// Reads stdlib.
    pub fn new() -> Manual {
        let library = eval::library();
        let reader = Reader { sources: &library.sources, vocabulary: &library.vocabulary };
        Manual { modules: library::FILES.iter().map(|file| reader.module(file)).collect() }
    }

    /// All words, in order.
    pub fn entries(&self) -> impl Iterator<Item = (&Module, &Entry)> {
        self.modules.iter().flat_map(|module| module.entries.iter().map(move |entry| (module, entry)))
    }

    /// What `name` means: a word (`raster`), a field (`line_pitch`, `raster.line_pitch`), or the path of a value
    /// (`std.controllers.irc5`).
    pub fn find(&self, name: &str) -> Found<'_> {
        let last = name.strip_prefix("std.").map_or(name, |path| path.rsplit('.').next().unwrap_or(path));
        let words: Vec<_> = self.entries().filter(|(_, entry)| entry.name == last).collect();
        if !words.is_empty() {
            return Found::Words(words);
        }
        let (schema, field) = name.rsplit_once('.').map_or((None, name), |(schema, field)| (Some(schema), field));
        let schemas = self.entries().filter(|(_, entry)| schema.is_none_or(|schema| entry.name == schema));
        let fields: Vec<_> = schemas
            .flat_map(|(_, entry)| entry.fields().iter().map(move |page| (entry, page)))
            .filter(|(_, page)| page.name == field)
            .collect();
        if !fields.is_empty() {
            return Found::Fields(fields);
        }
        let words = self.entries().map(|(_, entry)| entry.name.as_str());
        let fields = self.entries().flat_map(|(_, entry)| entry.fields()).map(|page| page.name.as_str());
        match nearest(name, words.chain(fields)) {
            Some(near) => Found::Near(near.to_string()),
            None => Found::Nothing,
        }
    }
}

impl Default for Manual {
    fn default() -> Manual {
        Manual::new()
    }
}

impl Entry {
    /// The fields of a schema; none for anything else.
    pub fn fields(&self) -> &[FieldPage] {
        match &self.kind {
            Kind::Schema { fields, .. } => fields,
            _ => &[],
        }
    }
}

struct Reader<'a> {
    sources: &'a Sources,
    vocabulary: &'a Vocabulary,
}

impl Reader<'_> {
    fn module(&self, file: &LibraryFile) -> Module {
        let id = self.sources.find(file.path).unwrap_or(FileId(0));
        let (ast, _) = parse(id, file.text);
        let entries = ast.items.iter().filter_map(|item| self.entry(file, item)).collect();
        Module { name: file.module, core: file.core, doc: first_comment(file.text), entries }
    }

    fn entry(&self, file: &LibraryFile, item: &Item) -> Option<Entry> {
        let text = |span: Span| self.sources.slice(span).to_string();
        let (name, kind) = match &item.kind {
            ItemKind::Family { name } => {
                let (id, _) = self.family(name.span)?;
                let members = self.vocabulary.members(id);
                (name, Kind::Family { members, used: self.used(|ty| *ty == Type::Family(id)) })
            }
            ItemKind::Schema(schema) => {
                let (id, found) = self.schema(schema.name.span)?;
                let family = found.family.map(|family| self.vocabulary.family(family).name.clone());
                let kind = Kind::Schema {
                    family,
                    fields: found.fields.iter().map(|field| self.field(field)).collect(),
                    checks: found.checks.iter().map(|check| check.text.clone()).collect(),
                    used: self.used(|ty| *ty == Type::Schema(id)),
                };
                (&schema.name, kind)
            }
            ItemKind::Let { name, value, .. } => {
                let line = format!("use std.{}", file.module);
                let text = text(value.span);
                let schema = text.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default().into();
                (name, Kind::Value { schema, text, line })
            }
            ItemKind::Function { name, .. } => {
                let found = self.vocabulary.functions.iter().find(|function| function.span == name.span)?;
                let signature = found.signature.strip_prefix("fn ").unwrap_or(&found.signature).to_string();
                (name, Kind::Function { signature })
            }
            ItemKind::Unit { name, ty, value } => {
                let meaning = self.vocabulary.units.unit(&name.text)?;
                let dimension = match ty {
                    Some(ty) => text(ty.span),
                    None => self.vocabulary.units.describe(meaning.dimension()),
                };
                (name, Kind::Unit { worth: value.as_ref().map(|value| text(value.span)), dimension })
            }
            ItemKind::Dimension { name, value } => {
                let dimension = self.vocabulary.units.dimension(&name.text)?;
                let units = units_of(dimension).iter().map(|unit| unit.text.to_string()).collect();
                (name, Kind::Dimension { product: value.as_ref().map(|value| text(value.span)), units })
            }
            _ => return None,
        };
        Some(Entry { name: name.text.clone(), doc: item.doc.clone(), kind })
    }

    fn family(&self, place: Span) -> Option<(FamilyId, &Family)> {
        let found = self.vocabulary.families.iter().enumerate().find(|(_, family)| family.span == place);
        found.map(|(at, family)| (FamilyId(at), family))
    }

    fn schema(&self, place: Span) -> Option<(SchemaId, &Schema)> {
        let found = self.vocabulary.schemas.iter().enumerate().find(|(_, schema)| schema.span == place);
        found.map(|(at, schema)| (SchemaId(at), schema))
    }

    /// The fields whose value, or an element of it, has such a type.
    fn used(&self, wanted: impl Fn(&Type) -> bool) -> Vec<String> {
        let mut used = Vec::new();
        for schema in &self.vocabulary.schemas {
            let fields = schema.fields.iter().filter(|field| wanted(field.ty.element()));
            used.extend(fields.map(|field| format!("{}.{}", schema.name, field.name)));
        }
        used
    }

    fn field(&self, field: &Field) -> FieldPage {
        let symbols = match field.ty.element() {
            Type::Symbols(symbols) => symbols.iter().map(|s| (s.name.clone(), s.doc.clone())).collect(),
            _ => Vec::new(),
        };
        let units = match field.ty.element() {
            Type::Quantity(dimension) => units_of(*dimension).iter().map(|unit| unit.text).collect(),
            _ => Vec::new(),
        };
        FieldPage {
            name: field.name.clone(),
            ty: field.type_text.clone(),
            doc: field.doc.clone(),
            required: field.is_required(),
            default: field.default_text.clone(),
            limit: field.restriction.as_ref().map(|limit| limit.text.clone()),
            usual: field.usual.as_ref().map(|limit| limit.text.clone()),
            units,
            symbols,
        }
    }
}

/// The plain comment that a file begins with, after its first line.
fn first_comment(text: &str) -> String {
    let mut lines = Vec::new();
    let mut newlines = 0;
    for token in tokens::tokenize(text) {
        let slice = &text[token.start as usize..token.end as usize];
        match token.kind {
            TokenKind::Newline => newlines += 1,
            TokenKind::Blank => {}
            TokenKind::Comment { .. } if lines.is_empty() || newlines == 1 => {
                lines.push(slice.trim_start_matches('/').trim());
                newlines = 0;
            }
            TokenKind::Word | TokenKind::Number if lines.is_empty() && matches!(slice, "language" | "1") => {}
            _ => break,
        }
    }
    lines.join("\n")
}
