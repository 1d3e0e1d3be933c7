//! Paths: the strategies and what they share.

use super::Aperture;
use crate::units::si::*;
use serde::{Deserialize, Serialize};

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Path {
    raster(Raster),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Raster {
    pub over: Aperture,
    pub point_step: Length,
    pub line_pitch: Length,
    /// Direction of the first line, from +x towards +y of the part.
    pub direction: Angle,
    pub lines: Lines,
    /// Most that the path may leave a curved surface between two points.
    pub chord_error: Length,
    /// What happens where the part has a hole. No default: a part with a hole needs it said.
    pub holes: Option<Crossing>,
    /// How the tool lands on the glass, where lines start or end there.
    pub landing: Option<Landing>,
    /// One pass as the fields say it, if absent.
    pub passes: Option<Vec<Pass>>,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Lines {
    serpentine,
    one_way,
}

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Crossing {
    cross(Cross),
}

/// The tool goes on over the hole, on the surface continued.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cross {
    pub process: OnOff,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum OnOff {
    on,
}

/// How the tool comes down onto the glass at the start of a run and leaves it at the end, along the normal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Landing {
    /// Of the way down and up.
    pub speed: Speed,
    /// How far above its working place the tool begins to remove.
    pub reach: Length,
    /// How long the controller stands at the first and at the last point of a run.
    pub stand: Time,
}

/// One of several passes over the same area.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pass {
    /// Turned by so much against the path's own fields, from +x towards +y.
    pub turn: Angle,
    /// Its lines are moved by so much across themselves.
    pub shift: Length,
}
