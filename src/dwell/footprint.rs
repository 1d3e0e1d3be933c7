//! The influence function as it lies on the part.
//!
//! In: a removal rate over the place relative to the contact point, in the part's axes. Out: a [`Footprint`]: that rate
//! with its reach, its volume and its width, which is all that the removal operators ask of a tool.

use crate::tool::{Azimuth, InfluenceFunction, part_to_tool};
use rayon::prelude::*;

/// Removal rate around the contact point, in the axes of the part. Positive takes glass away.
pub struct Footprint<'a> {
    rate: Box<dyn Fn(f64, f64) -> f64 + Sync + 'a>,
    /// Nothing is removed farther than this from the contact point, metres.
    pub radius: f64,
    /// Integral of the rate, m³/s.
    pub volume_rate: f64,
    /// The finest detail that grids and sub-samples must resolve, metres: for a Gaussian its sigma.
    pub sigma: f64,
    /// Direction of the tool's x axis on the part, in which the rate is carried onto a surface that is not flat.
    pub azimuth: Azimuth,
    /// Distance of the tool centre point from the contact along the normal, metres: programmed speeds are its speeds.
    pub standoff: f64,
}

impl<'a> Footprint<'a> {
    /// Of any rate in m/s; it must vanish beyond `radius`.
    pub fn new(rate: impl Fn(f64, f64) -> f64 + Sync + 'a, radius: f64, volume_rate: f64, sigma: f64) -> Footprint<'a> {
        Footprint { rate: Box::new(rate), radius, volume_rate, sigma, azimuth: Azimuth::new(0.0), standoff: 0.0 }
    }

    /// Of a tool whose x axis points along `azimuth` on the part (radians, from +x towards +y).
    pub fn of(influence: &'a InfluenceFunction, azimuth: f64) -> Footprint<'a> {
        let rate = move |dx: f64, dy: f64| {
            let [x, y] = part_to_tool(dx, dy, azimuth);
            influence.rate(x, y)
        };
        let flat = Footprint::new(rate, influence.radius(), influence.volume_rate(), influence.sigma_scale());
        Footprint { azimuth: Azimuth::new(azimuth), ..flat }
    }

    /// Removal rate at `(dx, dy)` from the contact point, m/s.
    pub fn rate(&self, dx: f64, dy: f64) -> f64 {
        (self.rate)(dx, dy)
    }

    /// The greatest rate, m/s, on a grid of a sixteenth of a sigma about the contact point.
    pub fn peak(&self) -> f64 {
        let step = self.sigma / 16.0;
        let half = (self.radius / step).ceil() as i64;
        let at = |k: i64| k as f64 * step;
        (-half..=half)
            .into_par_iter()
            .map(|row| (-half..=half).map(|column| self.rate(at(column), at(row))).fold(0.0, f64::max))
            .reduce(|| 0.0, f64::max)
    }

    /// The part's x and y axis as the tool carries them along into the tangent plane over the outward unit normal
    /// `normal`: [`rate`](Self::rate) holds there for distances along them. `None` where the normal runs along the azimuth.
    pub fn carried_axes(&self, normal: [f64; 3]) -> Option<[[f64; 3]; 2]> {
        let [x, y, _] = self.azimuth.axes(normal).ok()?;
        Some(self.azimuth.carried(x, y))
    }
}

/// Depth that a covered area loses even at the greatest feed, metres: `V / (v_max * pitch)`, with the volume rate V in
/// m³/s and the distance `pitch` of the lines. The most important number of feasibility: no map can ask for less.
pub fn floor_depth(volume_rate: f64, feed_greatest: f64, line_pitch: f64) -> f64 {
    volume_rate / (feed_greatest * line_pitch)
}

/// Footprints for the tests of this module's neighbours.
#[cfg(test)]
pub(super) mod examples {
    use super::*;
    use std::f64::consts::PI;

    /// Gaussian cut at `radius`: peak in m/s, lengths in metres.
    pub fn gaussian(peak: f64, sigma: f64, radius: f64) -> Footprint<'static> {
        let rate = move |x: f64, y: f64| {
            let square = x * x + y * y;
            if square <= radius * radius { peak * libm::exp(-square / (2.0 * sigma * sigma)) } else { 0.0 }
        };
        let volume = 2.0 * PI * sigma * sigma * peak * (1.0 - libm::exp(-radius * radius / (2.0 * sigma * sigma)));
        Footprint::new(rate, radius, volume, sigma)
    }
}
