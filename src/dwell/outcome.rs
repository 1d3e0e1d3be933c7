//! What comes of a run: what it removes, what it leaves, how long it takes.
//!
//! In: a [`TimedPath`] with its rounded speeds, the error map. Out: an [`Outcome`], from the programmed speeds alone.

use super::curved::Relief;
use super::field::Field;
use super::footprint::Footprint;
use super::speed::{self, Limits, Segments};
use super::timed::link_length;
use super::{Ripple, TimedPath, prediction};
use crate::diagnostics::Problem;
use crate::height_map::Grid;
use crate::job::{Aperture, Corrective};
use crate::path::Link;
use crate::workpiece::form::Surface;

/// A solved run.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub timed: TimedPath,
    /// Depth that will be removed, on the map's pixels; NaN outside the clear aperture.
    pub removal: Grid,
    /// Error that will be left, the even layer taken out; NaN outside the clear aperture.
    pub residual: Grid,
    pub figures: Figures,
    /// What the distance of the lines leaves; [`predict`] does not look at it.
    pub ripple: Option<Ripple>,
}

/// What the report says of a solved run. Lengths in metres, times in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Of the error map inside the clear aperture, RMS about the mean.
    pub before_rms: f64,
    pub before_pv: f64,
    /// Of the predicted residual.
    pub rms: f64,
    pub pv: f64,
    /// RMS of what will be missing of the part of the error that this run is to take off, beside the even layer.
    pub missed: f64,
    /// Even layer removed beside the wanted part of the error: the mean of removal - removal_fraction * error.
    pub base: f64,
    pub mean_removal: f64,
    pub greatest_removal: f64,
    /// Depth that the path loses at the greatest feed, V / (v_max * pitch).
    pub floor: f64,
    /// Time on the lines and on the ways between them on the surface; a kinematic estimate.
    pub time: f64,
    /// Programmed speeds of the segments inside the clear aperture, m/s: those that do at least half of their work there.
    pub least_speed: f64,
    pub greatest_speed: f64,
    /// Part of those segments whose time lies at one of its bounds.
    pub at_bounds: f64,
    /// Part of them at the least feed: their longest time.
    pub at_least: f64,
    /// Least distance of a standing tool from the part's edge.
    pub overrun: f64,
    /// How often the tool comes down onto the part or leaves it, how long each of that counts as standing, and the depth that
    /// one removes where the influence function is greatest.
    pub landings: usize,
    pub landing_time: f64,
    pub landing_depth: f64,
    /// Steps of the solver, all rounds together.
    pub iterations: usize,
    /// Solves: one, and one more each time that the arm's acceleration asked for slower speeds.
    pub rounds: usize,
    /// The solver used all its steps while they still gained something.
    pub stopped_early: bool,
    /// What the solver's own operator says of the same times (without rounding): a check of one against the other.
    pub solver_rms: f64,
}

/// Predicts what a timed path removes, from its programmed speeds alone: figures that only the solver knows are zero.
///
/// # Errors
///
/// E0509 (the map does not cover the clear aperture).
pub fn predict(
    timed: TimedPath,
    footprint: &Footprint,
    surface: &dyn Surface,
    error: &Grid,
    clear: &Aperture,
    dwell: &Corrective,
) -> Result<Outcome, Problem> {
    let field = Field::new(error, clear)?;
    let limits = Limits::of(dwell);
    let depths = match Relief::of(surface, &field.window) {
        Some(relief) => relief.removal(&timed, footprint, &limits),
        None => prediction::removal(&timed, footprint, &limits, &field.window),
    };
    let fraction = dwell.removal_fraction;
    let inside: Vec<usize> = (0..depths.len()).filter(|&i| field.weights[i] > 0.0).collect();
    let mean = |value: &dyn Fn(usize) -> f64| inside.iter().map(|&i| value(i)).sum::<f64>() / inside.len() as f64;
    let base = mean(&|i| depths[i] - fraction * field.values[i]);
    let left = |i: usize| field.values[i] - depths[i] + base;
    let spread = |value: &dyn Fn(usize) -> f64| {
        let centre = mean(value);
        let rms = mean(&|i| (value(i) - centre) * (value(i) - centre)).sqrt();
        let (low, high) = inside
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &i| (low.min(value(i)), high.max(value(i))));
        (rms, high - low)
    };
    let (before_rms, before_pv) = spread(&|i| field.values[i]);
    let (rms, pv) = spread(&left);
    let segments = Segments::new(&timed.path, footprint.standoff);
    let speeds: Vec<f64> = segments.point.iter().map(|&p| timed.speed[p]).collect();
    let (missed, _) = spread(&|i| depths[i] - fraction * field.values[i]);
    let figures = Figures {
        before_rms,
        before_pv,
        rms,
        pv,
        missed,
        base,
        mean_removal: mean(&|i| depths[i]),
        greatest_removal: inside.iter().fold(0.0, |most, &i| depths[i].max(most)),
        time: speed::times(&speeds, &segments, &limits).iter().sum::<f64>()
            + link_time(&timed, footprint.standoff, &limits),
        ..Figures::default()
    };
    let mut removal = nowhere(error);
    let mut residual = nowhere(error);
    for &i in &inside {
        let at = field.place_in_map(i);
        removal.values[at] = depths[i];
        residual.values[at] = left(i);
    }
    Ok(Outcome { timed, removal, residual, figures, ripple: None })
}

/// A grid like `like`, unknown everywhere.
fn nowhere(like: &Grid) -> Grid {
    Grid { values: vec![f64::NAN; like.values.len()], ..like.clone() }
}

/// Time of the ways from line to line on the surface, from rest to rest.
fn link_time(timed: &TimedPath, standoff: f64, limits: &Limits) -> f64 {
    let on_surface = timed.path.lines.windows(2).filter(|pair| pair[0].link == Link::OnSurface);
    on_surface
        .map(|pair| {
            let speed = timed.speed[pair[1].points.start];
            link_length(&timed.path, standoff, &pair[0], &pair[1]) / speed + speed / limits.acceleration
        })
        .sum()
}
