//! The region-adaptive path, as the job describes it.

use super::{Aperture, Empty, Landing};
use crate::units::si::{Angle, Length};
use serde::{Deserialize, Serialize};

/// Polish only where the error is high.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionAdaptive {
    /// Where the tool centre point may go, and what the lift is found from.
    pub over: Aperture,
    pub lift: Lift,
    /// What stands higher than this above the lifted level's zero belongs to the region.
    pub above: Length,
    /// How far the lowest places may stay below the level that the rest is lowered to.
    pub tolerance: Length,
    pub mesh: HexagonalMesh,
    pub merge: Merge,
    /// Width of the smoothing, in nodes.
    pub smoothing: f64,
    pub point_step: Length,
    /// Sharpest turn from node to node.
    pub turn_limit: Angle,
    /// Most that the path may leave a curved surface between two points.
    pub chord_error: Length,
    /// How the tool lands on the glass, where every line starts and ends.
    pub landing: Landing,
}

/// How far the map is lifted before it is cut.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Lift {
    /// `rms3`, but no more than lifts all but the given part of the pixels above zero.
    bounded(Bounded),
    /// Three times the RMS less `tolerance`.
    rms3(Empty),
    /// A stated height.
    fixed(FixedLift),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounded {
    /// Part of the pixels that may stay below zero.
    pub quantile: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedLift {
    pub height: Length,
}

/// The hexagons that the region is divided into.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HexagonalMesh {
    /// From corner to corner.
    pub diagonal: Length,
    /// Parts of the region of at most as many hexagons are dropped.
    pub islands: i64,
    /// Holes in the region of at most as many hexagons are filled.
    pub holes: i64,
}

/// The rule that joins paths.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Merge {
    bridge_or_trim,
    paper,
}
