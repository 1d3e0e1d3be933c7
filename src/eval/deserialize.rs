//! From values to the Job's structs, by serde.
//!
//! A record is a struct or, where a family is expected, the variant of its schema's name; a symbol is a variant without
//! content; a quantity is the newtype of its dimension; a range is `Range`. A test of schemas against structs proves
//! that no checked job can fail here, so the errors are for those who call it with something else.

use super::value::{FieldOfRecord, Record, Value, ValueKind};
use crate::units::format::newtype_dimension;
use serde::de::value::{F64Deserializer, StrDeserializer};
use serde::de::{self, DeserializeSeed, IntoDeserializer, Visitor};
use serde::{Deserialize, forward_to_deserialize_any};
use std::fmt;

/// Why a value does not fit a struct.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misfit(pub String);

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Misfit {}

impl de::Error for Misfit {
    fn custom<T: fmt::Display>(message: T) -> Misfit {
        Misfit(message.to_string())
    }
}

/// The struct that the value describes.
pub fn from_value<'a, T: Deserialize<'a>>(value: &'a Value) -> Result<T, Misfit> {
    T::deserialize(Reader(value))
}

#[derive(Clone, Copy)]
struct Reader<'a>(&'a Value);

impl Reader<'_> {
    fn misfit(self, wanted: &str) -> Misfit {
        Misfit(format!("expected {wanted}, found {}", self.describe()))
    }

    fn describe(self) -> String {
        match &self.0.kind {
            ValueKind::Quantity { quantity, .. } => crate::units::show(quantity.value, quantity.dimension),
            ValueKind::Bool(value) => value.to_string(),
            ValueKind::Text(text) | ValueKind::File(text) => format!("the text `{text}`"),
            ValueKind::Symbol(symbol) => format!("`{symbol}`"),
            ValueKind::None => "`none`".into(),
            ValueKind::List(_) => "a list".into(),
            ValueKind::Range(..) => "a range".into(),
            ValueKind::Record(record) => format!("a record `{}`", record.name),
        }
    }

    fn plain_number(self) -> Result<f64, Misfit> {
        match self.0.as_quantity() {
            Some(quantity) if quantity.dimension.is_number() => Ok(quantity.value),
            _ => Err(self.misfit("a plain number")),
        }
    }
}

impl<'de> de::Deserializer<'de> for Reader<'de> {
    type Error = Misfit;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        match &self.0.kind {
            ValueKind::Quantity { .. } => visitor.visit_f64(self.plain_number()?),
            ValueKind::Bool(value) => visitor.visit_bool(*value),
            ValueKind::Text(text) | ValueKind::File(text) | ValueKind::Symbol(text) => visitor.visit_borrowed_str(text),
            ValueKind::None => visitor.visit_none(),
            ValueKind::List(elements) => visitor.visit_seq(Elements(elements.iter())),
            ValueKind::Range(from, to) => visitor.visit_map(Ends { ends: [("from", from), ("to", to)], next: 0 }),
            ValueKind::Record(record) => visitor.visit_map(Fields::of(record)),
        }
    }

    fn deserialize_i64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        let value = self.plain_number()?;
        // Up to 2^53 every whole number is exact.
        if value.fract() == 0.0 && value.abs() <= 9_007_199_254_740_992.0 {
            visitor.visit_i64(value as i64)
        } else {
            Err(self.misfit("a whole number"))
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        match self.0.kind {
            ValueKind::None => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, Misfit> {
        match (self.0.as_quantity(), newtype_dimension(name)) {
            (Some(quantity), Some(dimension)) if quantity.dimension == dimension => {
                let number: F64Deserializer<Misfit> = quantity.value.into_deserializer();
                visitor.visit_newtype_struct(number)
            }
            _ => Err(self.misfit(name)),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        match &self.0.kind {
            ValueKind::Symbol(_) | ValueKind::Record(_) => visitor.visit_enum(self),
            _ => Err(self.misfit(name)),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map struct identifier ignored_any
    }
}

/// A record as a family's member, or a symbol.
impl<'a> de::EnumAccess<'a> for Reader<'a> {
    type Error = Misfit;
    type Variant = Reader<'a>;

    fn variant_seed<S: DeserializeSeed<'a>>(self, seed: S) -> Result<(S::Value, Reader<'a>), Misfit> {
        let name = match &self.0.kind {
            ValueKind::Symbol(symbol) => symbol.as_str(),
            ValueKind::Record(record) => record.name.as_str(),
            _ => return Err(self.misfit("a symbol or a record")),
        };
        let name: StrDeserializer<'_, Misfit> = name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'a> de::VariantAccess<'a> for Reader<'a> {
    type Error = Misfit;

    fn unit_variant(self) -> Result<(), Misfit> {
        match self.0.kind {
            ValueKind::Symbol(_) => Ok(()),
            _ => Err(self.misfit("a symbol")),
        }
    }

    fn newtype_variant_seed<S: DeserializeSeed<'a>>(self, seed: S) -> Result<S::Value, Misfit> {
        match self.0.kind {
            ValueKind::Record(_) => seed.deserialize(self),
            _ => Err(self.misfit("a record")),
        }
    }

    fn tuple_variant<V: Visitor<'a>>(self, _: usize, _: V) -> Result<V::Value, Misfit> {
        Err(self.misfit("a tuple"))
    }

    fn struct_variant<V: Visitor<'a>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, Misfit> {
        de::Deserializer::deserialize_any(self, visitor)
    }
}

struct Elements<'a>(std::slice::Iter<'a, Value>);

impl<'a> de::SeqAccess<'a> for Elements<'a> {
    type Error = Misfit;

    fn next_element_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<Option<S::Value>, Misfit> {
        self.0.next().map(|element| seed.deserialize(Reader(element))).transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// The two ends of a range, as the fields of `Range`.
struct Ends<'a> {
    ends: [(&'static str, &'a Value); 2],
    next: usize,
}

impl<'a> de::MapAccess<'a> for Ends<'a> {
    type Error = Misfit;

    fn next_key_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<Option<S::Value>, Misfit> {
        let Some((name, _)) = self.ends.get(self.next) else { return Ok(None) };
        let name: StrDeserializer<'_, Misfit> = name.into_deserializer();
        seed.deserialize(name).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<S::Value, Misfit> {
        let (_, end) = self.ends.get(self.next).ok_or_else(|| Misfit("no more ends".into()))?;
        self.next += 1;
        seed.deserialize(Reader(end))
    }
}

struct Fields<'a> {
    fields: std::collections::btree_map::Iter<'a, String, FieldOfRecord>,
    value: Option<&'a Value>,
    /// The name of the field whose value comes next, for the message.
    name: &'a str,
}

impl<'a> Fields<'a> {
    fn of(record: &'a Record) -> Fields<'a> {
        Fields { fields: record.fields.iter(), value: None, name: "" }
    }
}

impl<'a> de::MapAccess<'a> for Fields<'a> {
    type Error = Misfit;

    fn next_key_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<Option<S::Value>, Misfit> {
        let Some((name, field)) = self.fields.next() else { return Ok(None) };
        (self.value, self.name) = (Some(&field.value), name);
        let name: StrDeserializer<'_, Misfit> = name.as_str().into_deserializer();
        seed.deserialize(name).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'a>>(&mut self, seed: S) -> Result<S::Value, Misfit> {
        let value = self.value.take().ok_or_else(|| Misfit("a value before its name".into()))?;
        seed.deserialize(Reader(value)).map_err(|why| Misfit(format!("`{}`: {why}", self.name)))
    }
}
