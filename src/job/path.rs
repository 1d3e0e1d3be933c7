//! Paths: the strategies and what they share.

use super::{Aperture, RegionAdaptive};
use crate::units::si::*;
use serde::{Deserialize, Serialize};

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Path {
    raster(Raster),
    spiral(Spiral),
    rings(Rings),
    hilbert(Hilbert),
    pseudo_random(PseudoRandom),
    region_adaptive(RegionAdaptive),
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

/// Archimedes' spiral: the distance from the centre grows by `line_pitch` in a turn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spiral {
    /// A circle or an annulus.
    pub over: Aperture,
    pub point_step: Length,
    pub line_pitch: Length,
    pub start: Start,
    pub hand: Hand,
    /// Where the outer end lies, from the centre of `over`, from +x towards +y of the part.
    pub direction: Angle,
    pub chord_error: Length,
    pub holes: Option<Crossing>,
    pub landing: Option<Landing>,
    pub passes: Option<Vec<Pass>>,
}

/// Circles about one centre, joined to one line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rings {
    /// A circle or an annulus.
    pub over: Aperture,
    pub point_step: Length,
    pub line_pitch: Length,
    pub start: Start,
    pub hand: Hand,
    /// Where the tool goes over from ring to ring, from the centre of `over`, from +x towards +y of the part.
    pub direction: Angle,
    pub chord_error: Length,
    pub holes: Option<Crossing>,
    pub landing: Option<Landing>,
    pub passes: Option<Vec<Pass>>,
}

/// At which end of a round path the tool begins.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Start {
    outside,
    inside,
}

/// Which way round, seen from the tool side.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Hand {
    clockwise,
    counterclockwise,
}

/// Hilbert's curve on squares of side `line_pitch`, as far as it lies in `over`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hilbert {
    pub over: Aperture,
    pub point_step: Length,
    pub line_pitch: Length,
    /// Of the squares' sides, from +x towards +y of the part.
    pub direction: Angle,
    pub chord_error: Length,
    pub holes: Option<Crossing>,
    pub landing: Option<Landing>,
    pub passes: Option<Vec<Pass>>,
}

/// One line around a random tree on squares of side `line_pitch`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PseudoRandom {
    pub over: Aperture,
    pub point_step: Length,
    pub line_pitch: Length,
    /// Which of all trees: the same seed gives the same path.
    pub seed: i64,
    /// Of the squares' sides, from +x towards +y of the part.
    pub direction: Angle,
    pub chord_error: Length,
    pub holes: Option<Crossing>,
    pub landing: Option<Landing>,
    pub passes: Option<Vec<Pass>>,
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
