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
}

/// A closed range `from .. to` of one quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range<T> {
    pub from: T,
    pub to: T,
}
