//! The names of dimensions and units, as stdlib declares them.

use super::Dimension;
use std::collections::BTreeMap;

/// What a unit's name means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnitMeaning {
    /// `1 unit = factor` in the coherent SI unit of `dimension`.
    Fixed { factor: f64, dimension: Dimension },
    /// `1 unit = factor` wavelengths of the job.
    Wavelength { factor: f64 },
}

impl UnitMeaning {
    /// The unit's dimension.
    pub fn dimension(self) -> Dimension {
        match self {
            UnitMeaning::Fixed { dimension, .. } => dimension,
            UnitMeaning::Wavelength { .. } => Dimension::LENGTH,
        }
    }
}

/// Named dimensions and units. The first name declared for a dimension is the one that messages use.
#[derive(Clone, Debug, Default)]
pub struct UnitTable {
    dimensions: Vec<(String, Dimension)>,
    units: BTreeMap<String, UnitMeaning>,
}

impl UnitTable {
    /// Adds a dimension's name.
    pub fn add_dimension(&mut self, name: &str, dimension: Dimension) {
        self.dimensions.push((name.to_string(), dimension));
    }

    /// Adds a unit's name.
    pub fn add_unit(&mut self, name: &str, meaning: UnitMeaning) {
        self.units.insert(name.to_string(), meaning);
    }

    /// The dimension of that name; `Number` is the dimension of plain numbers.
    pub fn dimension(&self, name: &str) -> Option<Dimension> {
        if name == "Number" {
            return Some(Dimension::NUMBER);
        }
        self.dimensions.iter().find(|(n, _)| n == name).map(|(_, d)| *d)
    }

    /// The names of all dimensions, in order of declaration.
    pub fn dimension_names(&self) -> impl Iterator<Item = &str> {
        self.dimensions.iter().map(|(name, _)| name.as_str())
    }

    /// The unit of that name.
    pub fn unit(&self, name: &str) -> Option<UnitMeaning> {
        self.units.get(name).copied()
    }

    /// The names of all units, in order of the alphabet.
    pub fn unit_names(&self) -> impl Iterator<Item = &str> {
        self.units.keys().map(String::as_str)
    }

    /// The name of `dimension`, if it has one.
    pub fn name(&self, dimension: Dimension) -> Option<&str> {
        if dimension.is_number() {
            return Some("Number");
        }
        self.dimensions.iter().find(|(_, d)| *d == dimension).map(|(n, _)| n.as_str())
    }

    /// `Speed`, or `Length^2 / Time` for a dimension without a name.
    pub fn describe(&self, dimension: Dimension) -> String {
        self.name(dimension).map_or_else(|| dimension.factors(), str::to_string)
    }

    /// `a length`, `an angular speed`, `a plain number`, `a quantity of Length^2 / Time`: for use in a sentence.
    pub fn in_words(&self, dimension: Dimension) -> String {
        if dimension.is_number() {
            return "a plain number".into();
        }
        match self.name(dimension) {
            Some(name) => {
                let mut words = String::new();
                for c in name.chars() {
                    if c.is_uppercase() && !words.is_empty() {
                        words.push(' ');
                    }
                    words.extend(c.to_lowercase());
                }
                let article = if words.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
                format!("{article} {words}")
            }
            None => format!("a quantity of `{}`", dimension.factors()),
        }
    }
}
