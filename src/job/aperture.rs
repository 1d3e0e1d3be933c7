//! Outlines in the part's xy plane.

use crate::units::si::*;
use serde::{Deserialize, Serialize};

/// A place in the part's xy plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    pub x: Length,
    pub y: Length,
}

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Aperture {
    circle(Circle),
    annulus(Annulus),
    rectangle(Rectangle),
    hexagon(Hexagon),
    polygon(Polygon),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Circle {
    pub diameter: Length,
    pub centre: Option<Place>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Annulus {
    pub outer_diameter: Length,
    pub inner_diameter: Length,
    pub centre: Option<Place>,
}

/// Sides `x` and `y` along the part axes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rectangle {
    pub x: Length,
    pub y: Length,
    pub centre: Option<Place>,
}

/// Regular; `direction` is that of the middle of one flat, from +x towards +y.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hexagon {
    pub across_flats: Length,
    pub direction: Angle,
    pub centre: Option<Place>,
}

/// Straight sides from vertex to vertex, the last one back to the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Polygon {
    pub vertices: Vec<Place>,
}
