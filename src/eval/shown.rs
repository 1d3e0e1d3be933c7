//! The job as it stands, for people: every value with a unit of sensible size, and who said it.
//!
//! In: the evaluated record of a job. Out: [`ShownField`]s, in the order of the schemas. Numbers that were worked out have
//! six digits: this is for reading, not for compiling again.

use super::evaluate::Evaluator;
use super::value::{FieldOfRecord, Value, ValueKind};
use crate::source::Span;

/// A field with its value and who said it.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownField {
    /// In a list of records, the element's number from 0.
    pub name: String,
    pub value: Shown,
    pub said: Said,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Shown {
    /// As the language writes it.
    Value(String),
    Record {
        schema: String,
        fields: Vec<ShownField>,
    },
    /// A list that holds records.
    List(Vec<ShownField>),
}

/// Who said a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    /// The text at this place: the job's, a library's, or that of `--set`.
    Written(Span),
    /// The schema; the field's comment tells why.
    Default { schema: String, doc: String },
    /// Nobody: an optional field that was left out.
    LeftOut,
}

impl Evaluator<'_> {
    /// The fields of a record; nothing if the value is none.
    pub(super) fn shown_fields(&self, value: &Value) -> Vec<ShownField> {
        let ValueKind::Record(record) = &value.kind else { return Vec::new() };
        let schema = self.checked.vocabulary.schema(record.schema);
        let fields = schema.fields.iter().filter_map(|field| {
            let FieldOfRecord { value, is_default } = record.fields.get(&field.name)?;
            let said = match (is_default, &value.kind) {
                (false, _) => Said::Written(value.span),
                (true, ValueKind::None) => Said::LeftOut,
                (true, _) => Said::Default { schema: schema.name.clone(), doc: field.doc.clone() },
            };
            let value = match &field.default_text {
                Some(text) if *is_default => Shown::Value(text.clone()),
                _ => self.shown_value(value),
            };
            Some(ShownField { name: field.name.clone(), value, said })
        });
        fields.collect()
    }

    fn shown_value(&self, value: &Value) -> Shown {
        match &value.kind {
            ValueKind::Record(record) if !record.fields.is_empty() => {
                Shown::Record { schema: record.name.clone(), fields: self.shown_fields(value) }
            }
            ValueKind::List(elements) if elements.iter().any(|e| matches!(e.kind, ValueKind::Record(_))) => {
                let shown = elements.iter().enumerate().map(|(index, element)| ShownField {
                    name: index.to_string(),
                    value: self.shown_value(element),
                    said: Said::Written(element.span),
                });
                Shown::List(shown.collect())
            }
            _ => Shown::Value(self.shown(value)),
        }
    }
}
