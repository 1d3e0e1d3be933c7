//! The vocabulary itself: stdlib is without a mistake, and its schemas and the Job's structs agree in both directions.
//!
//! The structs' side is found by serde: a deserializer that asks for nothing and writes down every struct, enum and
//! field that is asked of it, run until every variant was taken once.

use super::said;
use polishc::check::types::{SchemaId, Type, Vocabulary};
use polishc::eval;
use polishc::job::Job;
use polishc::units::format::{newtype_dimension, units_of};
use polishc::units::{Dimension, UnitMeaning};
use serde::de::value::{Error, StrDeserializer};
use serde::de::{
    self, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess, SeqAccess, VariantAccess, Visitor,
};
use serde::{Deserialize, forward_to_deserialize_any};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// What a Rust type is, in the words of the language.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Shape {
    Number,
    Integer,
    Text,
    Quantity(&'static str),
    Struct(&'static str),
    Enum(&'static str),
    List(Box<Shape>),
    Range(Box<Shape>),
    Optional(Box<Shape>),
}

#[derive(Default)]
struct Seen {
    /// Struct to its fields with their shapes.
    structs: BTreeMap<&'static str, BTreeMap<&'static str, Shape>>,
    /// Enum to its variants; what a variant holds, once it was taken.
    enums: BTreeMap<&'static str, BTreeMap<&'static str, Option<Variant>>>,
    /// How often each enum was asked for: its variants are taken in turn.
    turns: BTreeMap<&'static str, usize>,
    /// The shape of the value that was read last.
    last: Option<Shape>,
}

#[derive(Clone, Debug, PartialEq)]
enum Variant {
    Symbol,
    Holds(Shape),
}

#[derive(Clone, Copy)]
struct Probe<'a>(&'a RefCell<Seen>);

impl Probe<'_> {
    fn leaf(self, shape: Shape) {
        self.0.borrow_mut().last = Some(shape);
    }

    fn last(self) -> Shape {
        self.0.borrow_mut().last.take().expect("a value was read")
    }
}

impl<'de> Deserializer<'de> for Probe<'_> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        panic!("a type that the language does not have")
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.leaf(Shape::Number);
        visitor.visit_f64(0.0)
    }

    fn deserialize_i64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.leaf(Shape::Integer);
        visitor.visit_i64(0)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        self.leaf(Shape::Text);
        visitor.visit_str("")
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, Error> {
        let value = visitor.visit_newtype_struct(self)?;
        self.leaf(Shape::Quantity(name));
        Ok(value)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let value = visitor.visit_some(self)?;
        let inner = self.last();
        self.leaf(Shape::Optional(Box::new(inner)));
        Ok(value)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let value = visitor.visit_seq(One(self, false))?;
        let inner = self.last();
        self.leaf(Shape::List(Box::new(inner)));
        Ok(value)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let mut shapes = BTreeMap::new();
        let value = visitor.visit_map(AllFields { probe: self, fields, next: 0, shapes: &mut shapes })?;
        if name == "Range" {
            let end = shapes.remove("from").expect("a range has two ends");
            self.leaf(Shape::Range(Box::new(end)));
        } else {
            self.0.borrow_mut().structs.insert(name, shapes);
            self.leaf(Shape::Struct(name));
        }
        Ok(value)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let variant = {
            let mut seen = self.0.borrow_mut();
            seen.enums.entry(name).or_insert_with(|| variants.iter().map(|v| (*v, None)).collect());
            let turn = seen.turns.entry(name).or_default();
            *turn += 1;
            variants[(*turn - 1) % variants.len()]
        };
        let value = visitor.visit_enum(Taken { probe: self, name, variant })?;
        self.leaf(Shape::Enum(name));
        Ok(value)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 u8 u16 u32 u64 f32 char str bytes byte_buf unit unit_struct tuple tuple_struct map identifier
        ignored_any
    }
}

struct One<'a>(Probe<'a>, bool);

impl<'de> SeqAccess<'de> for One<'_> {
    type Error = Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        if std::mem::replace(&mut self.1, true) { Ok(None) } else { seed.deserialize(self.0).map(Some) }
    }
}

struct AllFields<'a, 's> {
    probe: Probe<'a>,
    fields: &'static [&'static str],
    next: usize,
    shapes: &'s mut BTreeMap<&'static str, Shape>,
}

impl<'de> MapAccess<'de> for AllFields<'_, '_> {
    type Error = Error;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Error> {
        let Some(name) = self.fields.get(self.next) else { return Ok(None) };
        let name: StrDeserializer<'_, Error> = (*name).into_deserializer();
        seed.deserialize(name).map(Some)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Error> {
        let value = seed.deserialize(self.probe)?;
        self.shapes.insert(self.fields[self.next], self.probe.last());
        self.next += 1;
        Ok(value)
    }
}

struct Taken<'a> {
    probe: Probe<'a>,
    name: &'static str,
    variant: &'static str,
}

impl Taken<'_> {
    fn note(&self, variant: Variant) {
        let mut seen = self.probe.0.borrow_mut();
        seen.enums.get_mut(self.name).expect("a known enum").insert(self.variant, Some(variant));
    }
}

impl<'de> EnumAccess<'de> for Taken<'_> {
    type Error = Error;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), Error> {
        let name: StrDeserializer<'_, Error> = self.variant.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de> VariantAccess<'de> for Taken<'_> {
    type Error = Error;

    fn unit_variant(self) -> Result<(), Error> {
        self.note(Variant::Symbol);
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Error> {
        let value = seed.deserialize(self.probe)?;
        let shape = self.probe.last();
        self.note(Variant::Holds(shape));
        Ok(value)
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, _: V) -> Result<V::Value, Error> {
        Err(de::Error::custom("the language has no tuples"))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], _: V) -> Result<V::Value, Error> {
        Err(de::Error::custom("a variant holds one struct"))
    }
}

fn structs_of_the_job() -> Seen {
    let seen = RefCell::new(Seen::default());
    // Each run takes the next variant of each enum that it meets. An enum inside a variant is met only in that variant's
    // turns, so the runs are many more than the variants of any enum.
    for _ in 0..1000 {
        Job::deserialize(Probe(&seen)).expect("the probe gives every field");
    }
    let seen = seen.into_inner();
    for (name, variants) in &seen.enums {
        assert!(variants.values().all(Option::is_some), "a variant of `{name}` was never taken");
    }
    seen
}

/// `MrfWheel` is the schema `mrf_wheel`.
fn snake(name: &str) -> String {
    let mut snake = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(c.to_lowercase());
    }
    snake
}

struct Comparison<'a> {
    seen: &'a Seen,
    vocabulary: &'a Vocabulary,
    compared: BTreeSet<SchemaId>,
}

impl Comparison<'_> {
    fn schema(&mut self, id: SchemaId, name: &str, fields: &BTreeMap<&'static str, Shape>) {
        if !self.compared.insert(id) {
            return;
        }
        let schema = self.vocabulary.schema(id);
        let in_schema: BTreeSet<&str> = schema.fields.iter().map(|field| field.name.as_str()).collect();
        let in_struct: BTreeSet<&str> = fields.keys().copied().collect();
        assert_eq!(in_schema, in_struct, "fields of the schema `{}` and of the struct `{name}`", schema.name);
        for field in &schema.fields {
            self.ty(&field.ty, &fields[field.name.as_str()], &format!("{}.{}", schema.name, field.name));
        }
    }

    fn ty(&mut self, ty: &Type, shape: &Shape, place: &str) {
        match (ty, shape) {
            (Type::Quantity(dimension), Shape::Number) => assert!(dimension.is_number(), "{place}"),
            (Type::Quantity(dimension), Shape::Quantity(name)) => {
                assert_eq!(Some(*dimension), newtype_dimension(name), "{place}");
            }
            (Type::Integer, Shape::Integer) | (Type::Text | Type::File, Shape::Text) => {}
            (Type::Schema(id), Shape::Struct(name)) => {
                assert_eq!(self.vocabulary.schema(*id).name, snake(name), "{place}");
                let fields = &self.seen.structs[name];
                self.schema(*id, name, fields);
            }
            (Type::Family(id), Shape::Enum(name)) => {
                assert_eq!(self.vocabulary.family(*id).name, *name, "{place}");
                let variants = &self.seen.enums[name];
                let members: BTreeSet<String> = self.vocabulary.members(*id).into_iter().collect();
                assert_eq!(members, variants.keys().map(|v| v.to_string()).collect(), "members of `{name}`");
                for member in self.vocabulary.family(*id).members.clone() {
                    let variant = self.vocabulary.schema(member).name.clone();
                    match variants[variant.as_str()].as_ref().expect("every variant was taken") {
                        Variant::Holds(Shape::Struct(inner)) => {
                            // A member without fields may share the struct `Empty`; a member whose word is too common
                            // for a Rust name carries its family's: `free` is `FreePiston`.
                            let (own, with_family) = (snake(inner), format!("{variant}_{}", snake(name)));
                            let named = *inner == "Empty" || own == variant || own == with_family;
                            assert!(named, "`{variant}` holds `{inner}`");
                            let fields = &self.seen.structs[inner];
                            self.schema(member, inner, fields);
                        }
                        other => panic!("`{name}`.`{variant}` is {other:?}"),
                    }
                }
            }
            (Type::Symbols(symbols), Shape::Enum(name)) => {
                let variants = &self.seen.enums[name];
                assert!(variants.values().all(|v| *v == Some(Variant::Symbol)), "`{name}` is no symbol set");
                let in_schema: BTreeSet<&str> = symbols.iter().map(|symbol| symbol.name.as_str()).collect();
                assert_eq!(in_schema, variants.keys().copied().collect(), "{place}");
            }
            (Type::List(element, _), Shape::List(inner)) => self.ty(element, inner, place),
            (Type::Range(end), Shape::Range(inner)) => self.ty(end, inner, place),
            (Type::Optional(wanted), Shape::Optional(inner)) => self.ty(wanted, inner, place),
            (ty, shape) => panic!("{place}: the schema says {ty:?}, the struct {shape:?}"),
        }
    }
}

#[test]
fn schemas_and_structs_agree_in_both_directions() {
    let library = eval::library();
    let seen = structs_of_the_job();
    let vocabulary = &library.vocabulary;
    let mut comparison = Comparison { seen: &seen, vocabulary, compared: BTreeSet::new() };
    let job = vocabulary.find_schema("job").expect("the schema of jobs");
    comparison.schema(job, "Job", &seen.structs["Job"]);
    // No schema is without a struct, but those of results, which no job states.
    for (index, schema) in vocabulary.schemas.iter().enumerate() {
        let of_results = schema.name == "result" || schema.name.ends_with("_result");
        assert_eq!(comparison.compared.contains(&SchemaId(index)), !of_results, "{}", schema.name);
    }
}

#[test]
fn the_probe_sees_what_is_in_a_struct() {
    // The comparison is worth nothing if the probe sees nothing: a part of what `src/job/mod.rs` says.
    let seen = structs_of_the_job();
    let circle = &seen.structs["Circle"];
    assert_eq!(circle["diameter"], Shape::Quantity("Length"));
    assert_eq!(circle["centre"], Shape::Optional(Box::new(Shape::Struct("Place"))));
    assert_eq!(
        seen.structs["RobotCell"]["safe_poses"],
        Shape::List(Box::new(Shape::List(Box::new(Shape::Quantity("Angle")))))
    );
    assert_eq!(seen.structs["Corrective"]["feed"], Shape::Range(Box::new(Shape::Quantity("Speed"))));
    assert_eq!(seen.enums["Zone"].len(), 4);
    assert_eq!(seen.enums["Tool"]["mrf_wheel"], Some(Variant::Holds(Shape::Struct("MrfWheel"))));
}

#[test]
fn stdlib_is_without_a_mistake_and_documented() {
    let library = eval::library();
    assert_eq!(said(&library), Vec::<String>::new());
    for schema in &library.vocabulary.schemas {
        assert!(!schema.doc.is_empty(), "the schema `{}` has no doc comment", schema.name);
        for field in &schema.fields {
            if let Some(text) = &field.default_text {
                assert!(
                    !field.doc.is_empty(),
                    "`{}.{}` has the default {text} without a reason",
                    schema.name,
                    field.name
                );
            }
        }
    }
    for family in &library.vocabulary.families {
        assert!(!family.doc.is_empty(), "the family `{}` has no doc comment", family.name);
        assert!(!family.members.is_empty(), "the family `{}` has no members", family.name);
    }
}

#[test]
fn what_can_ruin_a_part_has_no_default() {
    let vocabulary = eval::library().vocabulary;
    for (schema, field) in [
        ("height_map", "quantity"),
        ("height_map", "positive"),
        ("height_map", "view"),
        ("height_map", "up"),
        ("height_map", "subtract"),
        ("measured", "positive"),
        ("measured", "view"),
        ("measured", "up"),
        ("measured", "turns_with"),
        ("measured", "taken"),
        ("spot", "origin"),
        ("turn", "positive"),
        ("turn", "seen"),
        ("planetary_pad", "spin_measured"),
        ("planetary_pad", "edge"),
        ("bonnet", "precession"),
        ("bonnet_contact", "exponent"),
        ("mrf_wheel", "rotation"),
        ("mrf_wheel", "azimuth"),
        ("load", "mass"),
        ("load", "centre"),
        ("tcp_numbers", "rotation"),
        ("robot_cell", "base"),
        ("robot_cell", "user"),
        ("robot_cell", "object"),
        ("rapid", "frames"),
        ("landing", "speed"),
        ("landing", "reach"),
        ("landing", "stand"),
    ] {
        let id = vocabulary.find_schema(schema).unwrap_or_else(|| panic!("no schema {schema}"));
        let field = vocabulary.schema(id).field(field).unwrap_or_else(|| panic!("no field {schema}.{field}"));
        assert!(field.is_required(), "{schema}.{}", field.name);
    }
}

#[test]
fn a_schema_can_be_asked_what_a_manual_needs() {
    let vocabulary = eval::library().vocabulary;
    let raster = vocabulary.schema(vocabulary.find_schema("raster").expect("raster"));
    let direction = raster.field("direction").expect("direction");
    assert_eq!((direction.type_text.as_str(), direction.default_text.as_deref()), ("Angle", Some("0 deg")));
    assert!(direction.doc.starts_with("Direction of the first line"));
    assert_eq!(direction.restriction.as_ref().map(|limit| limit.text.as_str()), Some("> -180 deg and <= 180 deg"));
    let lines = raster.field("lines").expect("lines");
    assert_eq!(lines.type_text, "serpentine | one_way");
    let Type::Symbols(symbols) = &lines.ty else { panic!("symbols") };
    assert_eq!(symbols[1].doc, "Lifts and comes back, so that all lines run the same way.");
    let cell = vocabulary.schema(vocabulary.find_schema("robot_cell").expect("robot_cell"));
    assert_eq!(cell.field("safe_poses").map(|f| f.type_text.as_str()), Some("[[Angle; 6]]"));
}

#[test]
fn units_have_their_size() {
    let table = eval::library().vocabulary.units;
    let size = |name: &str| match table.unit(name) {
        Some(UnitMeaning::Fixed { factor, .. }) => factor,
        other => panic!("{name}: {other:?}"),
    };
    let pi = std::f64::consts::PI;
    // BIPM, The International System of Units, 9th edition; 1 inch = 25.4 mm.
    for (name, expected) in [
        ("mm", 1e-3),
        ("um", 1e-6),
        ("µm", 1e-6),
        ("nm", 1e-9),
        ("Å", 1e-10),
        ("inch", 0.0254),
        ("thou", 25.4e-6),
        ("deg", pi / 180.0),
        ("arcmin", pi / 10_800.0),
        ("arcsec", pi / 648_000.0),
        ("rev", 2.0 * pi),
        ("rpm", pi / 30.0),
        ("min", 60.0),
        ("h", 3600.0),
        ("day", 86_400.0),
        ("%", 0.01),
        ("N", 1.0),
        ("bar", 1e5),
        ("g", 1e-3),
        ("mrad", 1e-3),
        ("l", 1e-3),
    ] {
        let found = size(name);
        assert!((found - expected).abs() <= 4e-16 * expected, "{name}: {found}, expected {expected}");
    }
    assert!(matches!(table.unit("λ"), Some(UnitMeaning::Wavelength { factor: 1.0 })));
    assert_eq!(table.dimension("Speed"), Some(Dimension::whole(1, 0, -1, 0)));
    assert_eq!(table.name(Dimension::whole(-1, 1, -2, 0)), Some("Pressure"));
}

#[test]
fn units_that_messages_offer_are_those_of_stdlib() {
    let table = eval::library().vocabulary.units;
    for name in table.dimension_names() {
        let dimension = table.dimension(name).expect("a declared dimension");
        for unit in units_of(dimension) {
            let written = format!(
                "param x: {name} = 1 {}\nparam y: Number = (1 {}) / (1 {})",
                unit.text,
                unit.text,
                dimension.si_unit()
            );
            let compiled = super::compile_text(&written);
            assert_eq!(said(&compiled), Vec::<String>::new(), "{written}");
            // Their sizes: the number that the language makes of it.
            let factors = unit.text.split_once('/').unwrap_or((unit.text, ""));
            let of = |text: &str| match text.split_once('^').unwrap_or((text, "1")) {
                ("", _) => 1.0,
                (word, power) => match table.unit(word) {
                    Some(UnitMeaning::Fixed { factor, .. }) => factor.powi(power.parse().expect("a power")),
                    other => panic!("{word}: {other:?}"),
                },
            };
            let size: f64 = factors.0.split('*').map(of).product::<f64>() / of(factors.1);
            assert!((size - unit.factor).abs() <= 4e-16 * size, "{}: {size} and {}", unit.text, unit.factor);
        }
    }
}
