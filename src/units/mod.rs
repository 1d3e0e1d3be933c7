//! Units: dimensions, the tables of names, quantities, and how a quantity is written for people.
//!
//! In: exponents over the base dimensions and numbers in SI. Out: algebra on dimensions that never rounds, the units
//! that fit a dimension, text such as `4 mm`. Knows nothing of syntax: the language's own names (`Speed`, `rpm`) are put
//! into [`UnitTable`] by `check`, from `stdlib/dimensions.polish` and `stdlib/units.polish`.

pub mod dimension;
pub mod format;
pub mod si;
pub mod table;

pub use dimension::{Dimension, Ratio};
pub use format::show;
pub use table::{UnitMeaning, UnitTable};

/// A number with its dimension. The number is in the coherent SI unit of the dimension (angles in radians).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    pub value: f64,
    pub dimension: Dimension,
}

impl Quantity {
    /// A number without a dimension.
    pub fn number(value: f64) -> Quantity {
        Quantity { value, dimension: Dimension::NUMBER }
    }
}
