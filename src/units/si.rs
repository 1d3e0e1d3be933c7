//! SI newtypes: what a job's struct holds of each dimension, so that a length cannot land in a time.
//!
//! The inner `f64` is always in the coherent SI unit named at each type (angles in radians). Arithmetic happens on the
//! inner number; the newtype guards the border between job and physics.

use serde::{Deserialize, Serialize};

macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident)*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
            pub struct $name(pub f64);
        )*
        /// The names of all quantities, as the language and serde know them.
        pub const QUANTITY_NAMES: &[&str] = &[$(stringify!($name)),*];
    };
}

quantities! {
    /// Metres.
    Length
    /// Square metres.
    Area
    /// Radians.
    Angle
    /// Seconds.
    Time
    /// Metres a second.
    Speed
    /// Metres a second squared.
    Acceleration
    /// Radians a second.
    AngularSpeed
    /// Radians a second squared.
    AngularAcceleration
    /// Kilograms.
    Mass
    /// Kilogram square metres.
    Inertia
    /// Newtons.
    Force
    /// Pascals.
    Pressure
    /// One over pascals: Preston's coefficient.
    PerPressure
    /// One over the second power of metres: the coefficient of r^3.
    PerLength2
    /// One over the third power of metres: the coefficient of r^4.
    PerLength3
    /// One over the 4th power of metres: the coefficient of r^5.
    PerLength4
    /// One over the 5th power of metres: the coefficient of r^6.
    PerLength5
    /// One over the 6th power of metres: the coefficient of r^7.
    PerLength6
    /// One over the 7th power of metres: the coefficient of r^8.
    PerLength7
    /// One over the 8th power of metres: the coefficient of r^9.
    PerLength8
    /// One over the 9th power of metres: the coefficient of r^10.
    PerLength9
    /// One over the 10th power of metres: the coefficient of r^11.
    PerLength10
    /// One over the 11th power of metres: the coefficient of r^12.
    PerLength11
    /// One over the 12th power of metres: the coefficient of r^13.
    PerLength12
    /// One over the 13th power of metres: the coefficient of r^14.
    PerLength13
    /// One over the 14th power of metres: the coefficient of r^15.
    PerLength14
    /// One over the 15th power of metres: the coefficient of r^16.
    PerLength15
    /// One over the 16th power of metres: the coefficient of r^17.
    PerLength16
    /// One over the 17th power of metres: the coefficient of r^18.
    PerLength17
    /// One over the 18th power of metres: the coefficient of r^19.
    PerLength18
    /// One over the 19th power of metres: the coefficient of r^20.
    PerLength19
}

/// A closed range `from .. to` of one quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range<T> {
    pub from: T,
    pub to: T,
}
