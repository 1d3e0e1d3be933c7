//! Values: what expressions are worth, each with the place that said it.

use crate::check::types::SchemaId;
use crate::source::Span;
use crate::units::Quantity;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A value and where it was said.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    pub span: Span,
    pub kind: ValueKind,
}

#[derive(Clone, Debug, PartialEq)]
pub enum ValueKind {
    /// `written` when the number stands there as digits, so that a message can quote it.
    Quantity {
        quantity: Quantity,
        written: bool,
    },
    Bool(bool),
    Text(String),
    /// A whole path.
    File(String),
    Symbol(String),
    None,
    /// Shared, because a `let` may be used many times.
    List(Arc<Vec<Value>>),
    Range(Box<Value>, Box<Value>),
    Record(Arc<Record>),
}

/// A record with all fields of its schema, defaults included.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    pub schema: SchemaId,
    /// The schema's name.
    pub name: String,
    pub fields: BTreeMap<String, FieldOfRecord>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct FieldOfRecord {
    pub value: Value,
    /// Whether the schema's default gave it.
    pub is_default: bool,
}

impl Value {
    /// A number that was worked out.
    pub fn quantity(span: Span, quantity: Quantity) -> Value {
        Value { span, kind: ValueKind::Quantity { quantity, written: false } }
    }

    /// The number, if it is one.
    pub fn as_quantity(&self) -> Option<Quantity> {
        match &self.kind {
            ValueKind::Quantity { quantity, .. } => Some(*quantity),
            _ => None,
        }
    }

    /// How many values a list holds, those of inner lists included; one for anything else.
    pub fn count(&self) -> usize {
        match &self.kind {
            ValueKind::List(elements) => {
                elements.iter().fold(0, |count: usize, element| count.saturating_add(element.count()))
            }
            _ => 1,
        }
    }

    /// All numbers that `where` and `usual` speak of: itself, the elements of a list, the ends of a range.
    pub fn numbers(&self) -> Vec<&Value> {
        match &self.kind {
            ValueKind::Quantity { .. } => vec![self],
            ValueKind::List(elements) => elements.iter().flat_map(Value::numbers).collect(),
            ValueKind::Range(from, to) => [from, to].into_iter().flat_map(|end| end.numbers()).collect(),
            _ => Vec::new(),
        }
    }

    /// Writes the place of this value and of all inside it under their paths: `path.line_pitch`, `robot.joints.2`.
    pub fn origins(&self, path: &str, into: &mut BTreeMap<String, Span>) {
        into.insert(path.to_string(), self.span);
        let below = |name: &str| if path.is_empty() { name.to_string() } else { format!("{path}.{name}") };
        match &self.kind {
            ValueKind::Record(record) => {
                // What a record leaves out was said by nobody: the nearest place is the record itself, as it is used.
                for (name, field) in record.fields.iter().filter(|(_, field)| !field.is_default) {
                    field.value.origins(&below(name), into);
                }
            }
            ValueKind::List(elements) => {
                for (index, element) in elements.iter().enumerate() {
                    element.origins(&below(&index.to_string()), into);
                }
            }
            ValueKind::Range(from, to) => {
                from.origins(&below("from"), into);
                to.origins(&below("to"), into);
            }
            _ => {}
        }
    }
}
