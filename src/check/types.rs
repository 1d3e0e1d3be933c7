//! Types and the vocabulary: what schemas, families, dimensions and units there are.
//!
//! In: nothing but names and dimensions. Out: [`Type`], which value fits which type, and the words that messages use.

use crate::source::Span;
use crate::syntax::ast::BinaryOp;
use crate::units::{Dimension, UnitTable};
use std::sync::Arc;

use super::typed::Typed;

/// A schema: an index into [`Vocabulary::schemas`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SchemaId(pub usize);

/// A family: an index into [`Vocabulary::families`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FamilyId(pub usize);

/// A member of a symbol set, with its doc comment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    pub name: String,
    pub doc: String,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Type {
    /// A number with a dimension; `Number` is the empty dimension.
    Quantity(Dimension),
    Integer,
    Bool,
    Text,
    File,
    /// A day of the calendar, as text: `"2024-05-16"`.
    Date,
    Symbols(Arc<Vec<Symbol>>),
    Schema(SchemaId),
    Family(FamilyId),
    /// A list, and its length where that is fixed (in a schema) or known (of a list as written).
    List(Box<Type>, Option<usize>),
    Range(Box<Type>),
    Optional(Box<Type>),
    /// The type of `none`.
    None,
    /// Something was wrong and has been said; it fits everything.
    Failed,
}

impl Type {
    /// A plain number.
    pub const NUMBER: Type = Type::Quantity(Dimension::NUMBER);

    /// The type without a `?` around it.
    pub fn required(&self) -> &Type {
        match self {
            Type::Optional(inner) => inner.required(),
            other => other,
        }
    }

    /// What `where` and `usual` speak of: the element of a list, the ends of a range.
    pub fn element(&self) -> &Type {
        match self {
            Type::Optional(inner) | Type::List(inner, _) | Type::Range(inner) => inner.element(),
            other => other,
        }
    }

    /// The dimension of a number, `Integer` included.
    pub fn dimension(&self) -> Option<Dimension> {
        match self {
            Type::Quantity(dimension) => Some(*dimension),
            Type::Integer => Some(Dimension::NUMBER),
            _ => None,
        }
    }

    /// Whether nothing more is to be said about it.
    pub fn is_failed(&self) -> bool {
        *self == Type::Failed
    }
}

/// A kind of thing with several members: `Path`, `Tool`.
#[derive(Clone, Debug)]
pub struct Family {
    pub name: String,
    pub doc: String,
    pub span: Span,
    /// Whether stdlib declares it; then only stdlib adds members, because the compiler must know each.
    pub library: bool,
    pub members: Vec<SchemaId>,
}

/// What a value must keep to: the checked right side of `where` or `usual`, and its text for messages.
#[derive(Clone, Debug)]
pub struct Limit {
    pub text: String,
    /// Whether it was written as a range, `2 mm .. 30 mm`, rather than as comparisons.
    pub is_range: bool,
    /// All of these hold; of a range, its two ends, included.
    pub bounds: Vec<(BinaryOp, Typed)>,
}

/// A field of a schema.
#[derive(Clone, Debug)]
pub struct Field {
    pub name: String,
    pub doc: String,
    pub span: Span,
    pub ty: Type,
    /// The type as the schema writes it.
    pub type_text: String,
    pub default: Option<Typed>,
    /// The default as the schema writes it.
    pub default_text: Option<String>,
    pub restriction: Option<Limit>,
    pub usual: Option<Limit>,
}

impl Field {
    /// Whether a record must give it.
    pub fn is_required(&self) -> bool {
        self.default_text.is_none() && !matches!(self.ty, Type::Optional(_))
    }
}

/// A record's shape.
#[derive(Clone, Debug)]
pub struct Schema {
    pub name: String,
    pub doc: String,
    pub span: Span,
    pub family: Option<FamilyId>,
    pub library: bool,
    pub fields: Vec<Field>,
    pub checks: Vec<Check>,
}

/// A `check` line.
#[derive(Clone, Debug)]
pub struct Check {
    pub condition: Typed,
    /// As written.
    pub text: String,
    pub reason: Option<String>,
}

/// A function, as documentation and completion show it.
#[derive(Clone, Debug)]
pub struct FunctionEntry {
    pub name: String,
    pub doc: String,
    pub span: Span,
    /// `fn sin(angle: Angle) -> Number`.
    pub signature: String,
    pub library: bool,
}

impl Schema {
    /// The field of that name, with its place in the order.
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|field| field.name == name)
    }
}

/// All words that a job can use. `show --defaults`, `doc` and the editor ask it.
#[derive(Clone, Debug, Default)]
pub struct Vocabulary {
    pub units: UnitTable,
    pub families: Vec<Family>,
    pub schemas: Vec<Schema>,
    /// Those of stdlib first.
    pub functions: Vec<FunctionEntry>,
}

impl Vocabulary {
    /// The schema's data.
    pub fn schema(&self, id: SchemaId) -> &Schema {
        &self.schemas[id.0]
    }

    /// The family's data.
    pub fn family(&self, id: FamilyId) -> &Family {
        &self.families[id.0]
    }

    /// The schema of that name in stdlib's core, or else anywhere.
    pub fn find_schema(&self, name: &str) -> Option<SchemaId> {
        let found = |library: bool| self.schemas.iter().position(|s| s.name == name && s.library == library);
        found(true).or_else(|| found(false)).map(SchemaId)
    }

    /// The names of a family's members, in order of declaration.
    pub fn members(&self, id: FamilyId) -> Vec<String> {
        self.family(id).members.iter().map(|member| self.schema(*member).name.clone()).collect()
    }

    /// Whether a value of type `found` may stand where `wanted` is expected. Whole numbers are proved by `eval`.
    pub fn fits(&self, found: &Type, wanted: &Type) -> bool {
        match (found, wanted) {
            (Type::Failed, _) | (_, Type::Failed) => true,
            (Type::None, Type::Optional(_)) => true,
            (Type::Optional(found), Type::Optional(wanted)) => self.fits(found, wanted),
            (found, Type::Optional(wanted)) => self.fits(found, wanted),
            (Type::Schema(schema), Type::Family(family)) => self.schema(*schema).family == Some(*family),
            (Type::Symbols(found), Type::Symbols(wanted)) => {
                found.iter().all(|symbol| wanted.iter().any(|w| w.name == symbol.name))
            }
            (Type::List(found, length), Type::List(wanted, wanted_length)) => {
                self.fits(found, wanted) && (wanted_length.is_none() || length == wanted_length)
            }
            (Type::Range(found), Type::Range(wanted)) => self.fits(found, wanted),
            (Type::Quantity(_) | Type::Integer, Type::Quantity(_) | Type::Integer) => {
                found.dimension() == wanted.dimension()
            }
            (found, wanted) => found == wanted,
        }
    }

    /// The type as a schema writes it, on one line.
    pub fn type_text(&self, ty: &Type) -> String {
        match ty {
            Type::Quantity(dimension) => self.units.describe(*dimension),
            Type::Integer => "Integer".into(),
            Type::Bool => "Bool".into(),
            Type::Text => "Text".into(),
            Type::File => "File".into(),
            Type::Date => "Date".into(),
            Type::Symbols(symbols) => symbols.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(" | "),
            Type::Schema(id) => self.schema(*id).name.clone(),
            Type::Family(id) => self.family(*id).name.clone(),
            Type::List(element, Some(length)) => format!("[{}; {length}]", self.type_text(element)),
            Type::List(element, None) => format!("[{}]", self.type_text(element)),
            Type::Range(end) => format!("{0} .. {0}", self.type_text(end)),
            Type::Optional(inner) => format!("{}?", self.type_text(inner)),
            Type::None => "none".into(),
            Type::Failed => String::new(),
        }
    }

    /// The type in a sentence: `a length`, `a list of angles`, ``one of `high` and `low` ``.
    pub fn in_words(&self, ty: &Type) -> String {
        match ty {
            Type::Quantity(dimension) => self.units.in_words(*dimension),
            Type::Integer => "a whole number".into(),
            Type::Bool => "`true` or `false`".into(),
            Type::Text => "a text in quotes".into(),
            Type::File => "a file name in quotes".into(),
            Type::Date => "a date in quotes, such as `\"2024-05-16\"`".into(),
            Type::Symbols(symbols) => match symbols.as_slice() {
                [one] => format!("`{}`", one.name),
                many => format!("one of {}", listed(many.iter().map(|s| s.name.as_str()))),
            },
            Type::Schema(id) => format!("a record `{}`", self.schema(*id).name),
            Type::Family(id) => format!("a `{}` ({})", self.family(*id).name, listed_or(&self.members(*id))),
            Type::List(element, _) if element.is_failed() => "a list".into(),
            Type::List(element, length) => match length {
                Some(length) => format!("a list of {length} ({} each)", self.in_words(element)),
                None => format!("a list ({} each)", self.in_words(element)),
            },
            Type::Range(element) => format!("a range `a .. b` ({} each)", self.in_words(element)),
            Type::Optional(inner) => self.in_words(inner),
            Type::None => "`none`".into(),
            Type::Failed => "something".into(),
        }
    }
}

/// `` `a`, `b` and `c` ``.
pub fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    joined(names, "and")
}

/// `` `a`, `b` or `c` ``.
pub fn listed_or(names: &[String]) -> String {
    joined(names.iter().map(String::as_str), "or")
}

fn joined<'a>(names: impl IntoIterator<Item = &'a str>, word: &str) -> String {
    let quoted: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    match quoted.as_slice() {
        [] => "nothing".into(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} {word} {last}", first.join(", ")),
    }
}
