//! The influence function as it lies on the part.
//!
//! In: a removal rate over the place relative to the contact point, in the part's axes. Out: a [`Footprint`]: that rate
//! with its reach, its volume and its width, which is all that the removal operators ask of a tool.

use crate::tool::{Azimuth, InfluenceField, InfluenceFunction, part_to_tool};
use rayon::prelude::*;

/// Gives each part its weight for a tool that stands at x, y of the part.
type Weights<'a> = Box<dyn Fn(f64, f64, &mut [f64]) + Sync + 'a>;

/// Removal rate around the contact point, in the axes of the part. Positive takes glass away.
///
/// What a tool removes may depend on where it stands: then its rate is a sum of a few parts, each with a weight that belongs to
/// the place of the tool.
pub struct Footprint<'a> {
    rates: Vec<Box<dyn Fn(f64, f64) -> f64 + Sync + 'a>>,
    weights: Option<Weights<'a>>,
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
        let azimuth = Azimuth::new(0.0);
        Footprint { rates: vec![Box::new(rate)], weights: None, radius, volume_rate, sigma, azimuth, standoff: 0.0 }
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

    /// Of a tool that may remove otherwise at other places, whose x axis points along `azimuth` on the part. The volume rate is
    /// that at the part's origin.
    pub fn over(influence: &'a InfluenceField, azimuth: f64) -> Footprint<'a> {
        let mut footprint = Footprint::of(&influence.parts[0], azimuth);
        if influence.is_uniform() {
            return footprint;
        }
        for part in &influence.parts[1..] {
            footprint.rates.extend(Footprint::of(part, azimuth).rates);
        }
        footprint.radius = influence.radius();
        footprint.sigma = influence.sigma_scale();
        let mut weights = vec![0.0; influence.parts.len()];
        influence.weights(0.0, 0.0, &mut weights);
        footprint.volume_rate =
            influence.parts.iter().zip(&weights).map(|(part, weight)| weight * part.volume_rate()).sum();
        footprint.weights = Some(Box::new(move |x: f64, y: f64, weights: &mut [f64]| influence.weights(x, y, weights)));
        footprint
    }

    /// Number of parts.
    pub fn parts(&self) -> usize {
        self.rates.len()
    }

    /// Removal rate of a part at `(dx, dy)` from the contact point, m/s.
    pub fn rate_of(&self, part: usize, dx: f64, dy: f64) -> f64 {
        (self.rates[part])(dx, dy)
    }

    /// The weight of each part for a tool that stands at `(x, y)` of the part; `weights` is as long as there are parts.
    pub fn weights(&self, x: f64, y: f64, weights: &mut [f64]) {
        match &self.weights {
            Some(weigh) => weigh(x, y, weights),
            None => weights.fill(1.0),
        }
    }

    /// Removal rate at `(dx, dy)` from the contact point of a tool that stands at the part's origin, m/s: everywhere, if the
    /// tool is the same everywhere.
    pub fn rate(&self, dx: f64, dy: f64) -> f64 {
        self.rate_from([0.0; 2], [dx, dy])
    }

    /// Removal rate at `to` of a tool that stands at `from`, m/s.
    pub fn rate_from(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        if self.weights.is_none() {
            return self.rate_of(0, dx, dy);
        }
        if dx * dx + dy * dy > self.radius * self.radius {
            return 0.0;
        }
        let mut weights = vec![0.0; self.parts()];
        self.weights(from[0], from[1], &mut weights);
        weights.iter().enumerate().map(|(part, weight)| weight * self.rate_of(part, dx, dy)).sum()
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

    /// A Gaussian of 2 mm sigma, and to the right more and more of one of 3 mm, both cut where they no longer matter.
    pub fn two_parts() -> Footprint<'static> {
        let (narrow, wide) = (gaussian(1e-8, 2e-3, 15e-3), gaussian(1e-8, 3e-3, 15e-3));
        let weigh = |x: f64, _: f64, weights: &mut [f64]| weights.copy_from_slice(&[1.0, 0.5 + 40.0 * x]);
        Footprint {
            rates: narrow.rates.into_iter().chain(wide.rates).collect(),
            weights: Some(Box::new(weigh)),
            ..gaussian(1e-8, 2e-3, 15e-3)
        }
    }
}
