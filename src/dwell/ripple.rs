//! Ripple: what the distance of the lines leaves between them.
//!
//! In: a solved run. Out: [`Ripple`]: the root mean square of the removal at the frequency of the lines, where most is taken off.
//! The error map's pixels are too coarse to show it, so small patches are predicted anew, finer than the lines lie apart,
//! with the rate itself (no table, whose interpolation makes ripples of its own), and looked at through the power spectral
//! density.
//!
//! Over lines `p` apart, driven evenly, the removal is periodic, and the amplitude of its first harmonic against the mean
//! is the transform of the influence function at `1/p` against its volume, twice:
//!
//! ```text
//! a / m = 2 |H(1/p)| / H(0)        for a Gaussian  2 exp(-2 pi² sigma² / p²)
//! ```
//!
//! A Gaussian that is cut off leaves more than that: the step at its rim has all frequencies.

use super::TimedPath;
use super::footprint::Footprint;
use super::outcome::Outcome;
use super::prediction::{Place, each_stamp};
use super::removal::{Window, parts};
use super::speed::Limits;
use crate::height_map::Grid;
use crate::job::{Aperture, Term};
use crate::metrology::{psd, subtract};
use crate::workpiece::form::Surface;

/// What the lines leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ripple {
    /// Of periods within a quarter of the pitch's frequency, in any direction, metres. A Gaussian's is resolved to 1e-8 of
    /// the mean removal.
    pub rms: f64,
    /// Distance of the lines, metres.
    pub period: f64,
    /// Middle of the patch that shows it: where most is removed.
    pub place: [f64; 2],
}

/// Side of a patch in pitches: the spectrum then tells frequencies apart by an eighth of the lines'.
const PITCHES: usize = 8;

/// Pixels a pitch: the lines' frequency is half of the highest that the patch has.
const PIXELS: usize = 4;

/// Parts of a line a pitch, each laid down as two stamps: that keeps the rim of a cut spot from being seen as single stamps.
const PARTS: f64 = 6.0;

/// Where the two stamps of a part lie, in parts from its middle: by the quadrature of Gauss with two points, wrong by the fourth
/// power of the part's length. Segments are cut into different numbers of parts, by rounding alone if they are as long; at
/// the joint of two the midpoint rule, wrong by the square, leaves 1e-4 of the mean in the patch and 7e-6 of it
/// in the band, more than half of what lines 1.3 sigma apart leave.
const STAMPS: [f64; 2] = [-0.288_675_134_594_812_9, 0.288_675_134_594_812_9];

/// Frequencies that count as the lines', against theirs.
const BAND: [f64; 2] = [0.75, 1.25];

/// Places tried along each axis. The one where most is removed is predicted, since the ripple is a share of the removal.
const PLACES: usize = 5;

/// The ripple that a run leaves. `None` where no patch of eight pitches lies inside the clear aperture.
pub fn ripple(
    outcome: &Outcome,
    footprint: &Footprint,
    surface: &dyn Surface,
    clear: &Aperture,
    acceleration: f64,
    line_pitch: f64,
) -> Option<Ripple> {
    let side = PITCHES as f64 * line_pitch;
    let bounds = clear.bounds();
    let along = |axis: usize, k: usize| {
        bounds.min[axis] + (k as f64 + 1.0) / (PLACES as f64 + 1.0) * (bounds.max[axis] - bounds.min[axis])
    };
    let (place, _) = (0..PLACES * PLACES)
        .map(|i| [along(0, i % PLACES), along(1, i / PLACES)])
        .filter(|[x, y]| clear.distance(*x, *y) >= side * std::f64::consts::FRAC_1_SQRT_2)
        .filter_map(|place| Some((place, outcome.removal.interpolate(place[0], place[1])?)))
        // Of equals the first.
        .reduce(|most, one| if one.1 > most.1 { one } else { most })?;
    let limits = Limits::of_arm(acceleration);
    let pixel = line_pitch / PIXELS as f64;
    let count = PITCHES * PIXELS;
    let origin = place.map(|middle| middle - pixel * (count - 1) as f64 / 2.0);
    let window = Window { columns: count, rows: count, pixel: [pixel; 2], origin };
    let depths = patch(&outcome.timed, footprint, surface, &limits, &window, line_pitch / PARTS);
    let mut grid = Grid { columns: count, rows: count, pixel: [pixel; 2], origin, values: depths };
    let counts = vec![true; grid.values.len()];
    // What the run does on a larger scale is no ripple; its low orders would leak through the window.
    subtract(&mut grid, &counts, &[Term::piston, Term::tilt, Term::power])?;
    let spectrum = psd(&grid, &counts)?;
    let [low, high] = BAND.map(|share| share / line_pitch);
    Some(Ripple { rms: spectrum.mean_square_between(low, high).sqrt(), period: line_pitch, place })
}

/// Depth removed on a small window, metres, by the rate itself, with parts of at most `step`.
fn patch(
    timed: &TimedPath,
    footprint: &Footprint,
    surface: &dyn Surface,
    limits: &Limits,
    window: &Window,
    step: f64,
) -> Vec<f64> {
    let points = &timed.path.points;
    let heights: Vec<f64> = (0..window.len())
        .map(|i| {
            let [x, y] = window.position(i);
            surface.at(x, y).map_or(f64::NAN, |point| point.sag)
        })
        .collect();
    let mut depths = vec![0.0; window.len()];
    let mut weights = vec![0.0; footprint.parts()];
    each_stamp(timed, footprint, footprint.radius, limits, window, |Place { from, to, t, share }, time| {
        let (a, b) = (points.position(from), points.position(to));
        let length = libm::hypot(libm::hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2]);
        // The stamp stands for a part of the segment; it is laid down in finer ones.
        let finer = parts(length * share, step);
        let between = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|i| a[i] + t * (b[i] - a[i]));
        let normal = between(points.normal(from), points.normal(to), t);
        let size = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        let Some([u, v]) = footprint.carried_axes(normal.map(|n| n / size)) else { return };
        for k in 0..finer * STAMPS.len() {
            let middle = (k / STAMPS.len()) as f64 + 0.5;
            let t = t + ((middle + STAMPS[k % STAMPS.len()]) / finer as f64 - 0.5) * share;
            let contact = between(a, b, t);
            footprint.weights(contact[0], contact[1], &mut weights);
            for (i, depth) in depths.iter_mut().enumerate() {
                let [x, y] = window.position(i);
                let d = [x - contact[0], y - contact[1], heights[i] - contact[2]];
                let along = |axis: [f64; 3]| axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2];
                let (u, v) = (along(u), along(v));
                let rate: f64 = weights.iter().enumerate().map(|(part, w)| w * footprint.rate_of(part, u, v)).sum();
                *depth += time / (finer * STAMPS.len()) as f64 * rate;
            }
        }
    });
    depths
}

#[cfg(test)]
mod tests {
    use super::super::footprint::examples::gaussian;
    use super::super::outcome::Figures;
    use super::*;
    use crate::job::{Circle, Plane};
    use crate::path::{Line, Link, ToolPath};
    use crate::units::si::Length;
    use std::f64::consts::{PI, TAU};

    const SIGMA: f64 = 2e-3;
    const SPEED: f64 = 0.01;
    const PEAK: f64 = 1e-8;

    /// Parallel lines `pitch` apart over 120 mm, turned by `angle`, driven evenly.
    fn found(pitch: f64, angle: f64, footprint: &Footprint) -> Ripple {
        let (s, c) = libm::sincos(angle);
        let mut path = ToolPath::default();
        let lines = (120e-3 / pitch) as i32;
        for line in -lines / 2..=lines / 2 {
            let start = path.points.len();
            for i in -20..=20 {
                let (u, v) = (f64::from(i) * 3e-3, (f64::from(line) + 0.3) * pitch);
                path.points.push([c * u - s * v, s * u + c * v, 0.0], [0.0, 0.0, 1.0]);
            }
            path.lines.push(Line { points: start..path.points.len(), link: Link::Lifted });
        }
        let speed = vec![SPEED; path.points.len()];
        let clear = Aperture::circle(Circle { diameter: Length(80e-3), centre: None });
        let removal =
            Grid { columns: 41, rows: 41, pixel: [1e-3; 2], origin: [-20e-3; 2], values: vec![1e-9; 41 * 41] };
        let timed = TimedPath { path, speed, standing: Vec::new() };
        let outcome = Outcome { timed, residual: removal.clone(), removal, figures: Figures::default(), ripple: None };
        ripple(&outcome, footprint, &Plane {}, &clear, 1e9, pitch).expect("room for a patch")
    }

    /// Mean removal of even lines: V / (v p).
    fn mean(footprint: &Footprint, pitch: f64) -> f64 {
        footprint.volume_rate / (SPEED * pitch)
    }

    #[test]
    fn a_gaussian_leaves_what_its_transform_says() {
        // Cut at 6 sigma, where the rate is 1.5e-8 of the peak.
        let footprint = gaussian(PEAK, SIGMA, 6.0 * SIGMA);
        for (pitch, angle) in [(2.0 * SIGMA, 0.0), (2.0 * SIGMA, 0.6), (1.6 * SIGMA, PI / 2.0), (1.3 * SIGMA, 1.1)] {
            let found = found(pitch, angle, &footprint);
            let amplitude = 2.0 * libm::exp(-2.0 * PI * PI * SIGMA * SIGMA / (pitch * pitch)) * mean(&footprint, pitch);
            let expected = amplitude / 2f64.sqrt();
            assert!((found.rms - expected).abs() < 0.03 * expected, "{pitch} {angle}: {} {expected}", found.rms);
            assert_eq!(found.period, pitch);
        }
        // At a pitch of one sigma nothing is left that counts: 4e-9 of the mean by the formula. The rim at 6 sigma, the ends of the
        // window's reach and the joints of parts are of the order of the rate there, 1.5e-8 of the peak.
        let fine = found(SIGMA, 0.3, &footprint);
        assert!(fine.rms < 1.5e-8 * mean(&footprint, SIGMA), "{}", fine.rms);
    }

    #[test]
    fn a_cut_gaussian_leaves_more() {
        // The transform of a rate of radius, H(f) = 2 pi times the integral of r g(r) J0(2 pi f r) from 0 to R, by the
        // midpoint rule.
        let radius = 2.5 * SIGMA;
        let footprint = gaussian(PEAK, SIGMA, radius);
        let transform = |f: f64| {
            let n = 20_000;
            let step = radius / f64::from(n);
            let part = |k: i32| {
                let r = (f64::from(k) + 0.5) * step;
                r * PEAK * libm::exp(-r * r / (2.0 * SIGMA * SIGMA)) * libm::j0(TAU * f * r)
            };
            TAU * step * (0..n).map(part).sum::<f64>()
        };
        for pitch in [1.7 * SIGMA, 1.2 * SIGMA, 0.8 * SIGMA] {
            let found = found(pitch, 0.4, &footprint);
            let share = 2.0 * transform(1.0 / pitch).abs() / transform(0.0);
            let expected = share * mean(&footprint, pitch) / 2f64.sqrt();
            // Stamps a twelfth of the pitch apart are not yet a line where the spot is cut.
            assert!((found.rms - expected).abs() < 0.1 * expected, "{pitch}: {} {expected}", found.rms);
        }
    }
}
