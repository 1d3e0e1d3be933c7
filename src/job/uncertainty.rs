//! How well what a run is planned from is known.

use crate::units::si::*;
use serde::{Deserialize, Serialize};

/// One standard deviation of each error, from run to run. What is not stated counts as nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Uncertainty {
    /// Of the removal rate, the same all over the run, as a part of it.
    pub gain: Option<f64>,
    /// Change of the removal rate from the first to the last second of the run, as a part of it.
    pub drift: Option<f64>,
    /// Of where the removal lands on the map, in x and in y.
    pub registration: Option<Length>,
    /// Of each pixel of the map, independent from pixel to pixel.
    pub map_noise: Option<Length>,
    pub position: Option<PositionError>,
    pub feed: Option<FeedError>,
}

impl Uncertainty {
    /// The fields that the job does not state, as it would spell them.
    pub fn not_stated(&self) -> Vec<&'static str> {
        let stated = [
            ("gain", self.gain.is_some()),
            ("drift", self.drift.is_some()),
            ("registration", self.registration.is_some()),
            ("map_noise", self.map_noise.is_some()),
            ("position", self.position.is_some()),
            ("feed", self.feed.is_some()),
        ];
        stated.into_iter().filter(|(_, stated)| !stated).map(|(name, _)| name).collect()
    }
}

/// The arm leads the tool beside its path, at every place of the part always alike.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PositionError {
    /// In x and in y.
    pub rms: Length,
    /// Distance over which the error changes: its correlation at the distance d is exp(-d² / 2 over²).
    pub over: Length,
}

/// The arm runs at another speed than the programmed one, on each line otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FeedError {
    /// As a part of the programmed speed.
    pub rms: f64,
    /// Distance along the line over which the error changes: its correlation at the distance d is exp(-d / over).
    pub over: Length,
}
