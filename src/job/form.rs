//! Nominal surfaces.

use super::{Direction, MapCentre, View};
use crate::units::si::*;
use serde::{Deserialize, Serialize};

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Form {
    plane(Plane),
    sphere(Sphere),
    conic(Conic),
    even_asphere(EvenAsphere),
    odd_asphere(OddAsphere),
    off_axis(OffAxis),
    xy_polynomial(XyPolynomial),
    zernike(Zernike),
    height_grid(HeightGrid),
}

impl Form {
    /// The data files that it is made from, the base's last.
    pub fn files(&self) -> Vec<&str> {
        match self {
            Form::height_grid(grid) => {
                let mut files = vec![grid.file.as_str()];
                files.extend(grid.base.files());
                files
            }
            Form::xy_polynomial(polynomial) => polynomial.base.files(),
            Form::zernike(zernike) => zernike.base.files(),
            Form::off_axis(segment) => segment.parent.files(),
            Form::plane(_) | Form::sphere(_) | Form::conic(_) | Form::even_asphere(_) | Form::odd_asphere(_) => {
                Vec::new()
            }
        }
    }
}

/// z = 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plane {}

/// Which way a surface is hollow, seen from the tool.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Side {
    concave,
    convex,
}

/// In which direction the coefficients of a form count.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Sag {
    positive_towards_tool,
    positive_into_glass,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    pub side: Side,
    pub radius: Length,
}

/// A sphere's relative with a conic constant: 0 sphere, -1 paraboloid, below -1 hyperboloid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conic {
    pub side: Side,
    /// At the vertex.
    pub radius: Length,
    pub conic: f64,
}

/// A conic and even powers of the distance from the axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EvenAsphere {
    pub side: Side,
    /// At the vertex.
    pub radius: Length,
    pub conic: f64,
    pub sag: Sag,
    pub a4: Option<PerLength3>,
    pub a6: Option<PerLength5>,
    pub a8: Option<PerLength7>,
    pub a10: Option<PerLength9>,
    pub a12: Option<PerLength11>,
    pub a14: Option<PerLength13>,
    pub a16: Option<PerLength15>,
    pub a18: Option<PerLength17>,
    pub a20: Option<PerLength19>,
}

/// A conic and powers of the distance from the axis, odd ones too.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OddAsphere {
    pub side: Side,
    /// At the vertex.
    pub radius: Length,
    pub conic: f64,
    pub sag: Sag,
    pub a3: Option<PerLength2>,
    pub a4: Option<PerLength3>,
    pub a5: Option<PerLength4>,
    pub a6: Option<PerLength5>,
    pub a7: Option<PerLength6>,
    pub a8: Option<PerLength7>,
    pub a9: Option<PerLength8>,
    pub a10: Option<PerLength9>,
    pub a11: Option<PerLength10>,
    pub a12: Option<PerLength11>,
    pub a13: Option<PerLength12>,
    pub a14: Option<PerLength13>,
    pub a15: Option<PerLength14>,
    pub a16: Option<PerLength15>,
    pub a17: Option<PerLength16>,
    pub a18: Option<PerLength17>,
    pub a19: Option<PerLength18>,
    pub a20: Option<PerLength19>,
}

/// A piece of a rotationally symmetric parent beside its axis.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OffAxis {
    pub parent: Box<Form>,
    /// From the parent's axis to the part's origin, across the axis.
    pub distance: Length,
    /// The direction away from the parent's axis on the part, from +x towards +y.
    pub direction: Angle,
}

/// Products of powers of x and y on a base.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct XyPolynomial {
    pub base: Box<Form>,
    pub sag: Sag,
    /// The length that x and y are divided by.
    pub normalisation: Length,
    pub terms: Vec<XyTerm>,
}

/// coefficient * (x / normalisation)^x_power * (y / normalisation)^y_power.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct XyTerm {
    pub x_power: i64,
    pub y_power: i64,
    pub coefficient: Length,
}

/// Zernike polynomials on a base.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Zernike {
    pub base: Box<Form>,
    pub sag: Sag,
    /// The radius that the polynomials are normalised on.
    pub radius: Length,
    pub order: ZernikeOrder,
    /// From the first polynomial of the order on.
    pub coefficients: Vec<Length>,
}

/// How Zernike polynomials are numbered and scaled.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ZernikeOrder {
    fringe,
    noll,
    ansi,
}

/// Heights in a file on a base.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeightGrid {
    pub base: Box<Form>,
    pub sag: Sag,
    /// Whole path, resolved by `eval`.
    pub file: String,
    pub view: View,
    pub up: Direction,
    pub pixel: Option<Length>,
    pub unit: Option<Length>,
    pub centre: MapCentre,
}
