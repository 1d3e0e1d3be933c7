//! The plan of a corrective run: checks, solve, speeds, prediction.
//!
//! In: a [`Task`]. Out: an [`Outcome`], or what makes the run impossible, with the number that would mend it.

use super::curved::{self, Relief, cosines, steepest};
use super::feasibility::{check_base, check_resolution, check_solved, check_start, limits};
use super::field::Field;
use super::footprint::{Footprint, floor_depth};
use super::least_squares::Stop;
use super::outcome::{Figures, Outcome, predict};
use super::removal::{Removal, Samples, deposit};
use super::solver::{LATER_ITERATIONS, LIMIT_COST, STOP, Solved, Solver};
use super::speed::{self, Segments};
use super::start::start;
use super::timed::{Standing, TimedPath};
use super::{SpeedSteps, solver};
use crate::diagnostics::Problem;
use crate::height_map::Grid;
use crate::job::{Aperture, Corrective};
use crate::path::{self, ToolPath};
use crate::tool::InfluenceFunction;
use crate::workpiece::form::Surface;

/// Everything that a corrective run is planned from. Lengths in metres, times in seconds.
pub struct Task<'a> {
    pub path: ToolPath,
    /// Where the tool stands on the glass beside its way along the lines, and what that removes whatever the speeds are.
    pub standing: Vec<Standing>,
    /// Distance of neighbouring lines of one pass.
    pub line_pitch: f64,
    /// How often the path goes over its area.
    pub passes: usize,
    /// Form error in the part frame, positive where glass stands too high; no NaN inside `clear`.
    pub error: &'a Grid,
    pub clear: &'a Aperture,
    pub edge: &'a Aperture,
    /// The nominal surface that the path lies on.
    pub surface: &'a dyn Surface,
    pub influence: &'a InfluenceFunction,
    /// Direction of the tool's x axis on the part, radians.
    pub azimuth: f64,
    /// Distance of the tool centre point from the contact along the normal, metres.
    pub standoff: f64,
    pub dwell: &'a Corrective,
    /// Programmed speeds are of these.
    pub speed_steps: SpeedSteps,
}

/// Corrections of the wanted depths on a curved part. Each shrinks what the solver's plane gets wrong to a part of it (a
/// tenth to a third on slopes up to 30 degrees), so that three bring it below the limits' own cost.
const MOST_CORRECTIONS: usize = 5;

/// Solves the dwell of a run. Oddities that leave it usable are said to `warnings`.
///
/// # Errors
///
/// E0644 (a line ends over the part), E0700 (feed, acceleration or fraction unusable), E0701 (the arm cannot reach the
/// least feed in one segment), E0702 (the floor is deeper than what is wanted), E0509 (the map does not cover the clear
/// aperture), E0704 (the path does not reach part of it), E0705 (nothing to remove), E0706 (pixels too coarse).
pub fn solve(task: Task, warnings: &mut Vec<Problem>) -> Result<Outcome, Problem> {
    let dwell = task.dwell;
    let limits = limits(dwell, task.speed_steps)?;
    let mut footprint = Footprint::of(task.influence, task.azimuth);
    footprint.standoff = task.standoff;
    let ends = path::ends::check(&task.path, task.edge, footprint.radius, limits.greatest, limits.acceleration)?;
    let segments = Segments::new(&task.path, task.standoff);
    check_start(&segments, &limits)?;
    let field = Field::new(task.error, task.clear)?;
    curved::check(task.surface, &field, &footprint, warnings)?;
    // On a slope pixels and lines lie farther apart on the glass than across the axis.
    let steepest = steepest(task.surface, &field);
    check_resolution(&field, &footprint, task.line_pitch, steepest, warnings)?;
    let floor = task.passes as f64 * floor_depth(footprint.volume_rate, limits.greatest, task.line_pitch);
    let fraction = dwell.removal_fraction;
    let base = check_base(&dwell.piston, fraction * field.greatest(), floor, &footprint, &limits)?;

    // The solver's grid: pixels as coarse as the spot allows, since the spot smooths away everything finer.
    let coarse = field.binned(footprint.sigma / 4.0);
    let relief = Relief::of(task.surface, &coarse.window);
    let samples = Samples::segments(&task.path, footprint.sigma / 2.0);
    let mut operator = Removal::new(&samples, &footprint, coarse.window);
    if relief.is_some() {
        operator = operator.on_slopes(cosines(task.surface, &coarse.window));
    }
    drop(samples);
    let asked: Vec<f64> = coarse.values.iter().map(|height| fraction * height).collect();
    // What a standing tool removes is fixed: the rest is asked of the segments.
    let landing_time = task.standing.iter().map(|s| s.seconds).fold(0.0, f64::max);
    let (x, y): (Vec<f64>, Vec<f64>) =
        task.standing.iter().map(|s| (task.path.points.x[s.point], task.path.points.y[s.point])).unzip();
    let seconds: Vec<f64> = task.standing.iter().map(|s| s.seconds).collect();
    let fixed = deposit(&Samples::points(&x, &y), &seconds, &footprint, &coarse.window);
    let depths: Vec<f64> = asked.iter().zip(&fixed).map(|(asked, fixed)| asked - fixed).collect();
    // A segment's fastest: full feed, as far as the arm gets there from rest and back.
    let mut fastest = vec![limits.greatest; segments.length.len()];
    speed::limit(&mut fastest, &segments, &limits);
    let lower = speed::times(&fastest, &segments, &limits);
    let slowest = vec![limits.least; segments.length.len()];
    let mut upper = speed::times(&slowest, &segments, &limits);
    solver::raise(&mut upper, &lower);
    let (start, inside) = start(&mut operator, &coarse, &segments, &depths, base)?;

    let stop = Stop { elsewhere: (1.0 - fraction) * coarse.rms(), ..STOP };
    let mut solver = Solver {
        operator: &mut operator,
        segments: &segments,
        limits: &limits,
        weights: &coarse.weights,
        lower: &lower,
        upper: &upper,
        base,
        stop,
        iterations: 0,
        rounds: 0,
    };
    let mut solved = solver.solve(&depths, &start, stop.most_iterations);
    let mut timed = TimedPath::new(task.path, task.standing, &limits, task.speed_steps);
    timed.set_speeds(&segments, &solved.speeds);
    if let Some(relief) = &relief {
        // The solver reckons on a plane. What the surface makes of its times is predicted, and what is then missing asked for
        // beside: the plane's operator only has to point the right way.
        let mut target = depths.clone();
        let mut best: Option<Solved> = None;
        for correction in 0..=MOST_CORRECTIONS {
            timed.set_speeds(&segments, &solved.speeds);
            let removed = relief.removal(&timed, &footprint, &limits);
            let missing = missing(&asked, &removed, &coarse.weights);
            let rms = mean(&missing, &coarse.weights, |d| d * d).sqrt();
            let earlier = best.as_ref().map_or(f64::INFINITY, |best| best.rms);
            let times = speed::times(&solved.speeds, &segments, &limits);
            let plain = libm::hypot(solved.rms, stop.elsewhere);
            if rms < earlier {
                best = Some(Solved { rms, speeds: solved.speeds.clone() });
            }
            // As good as the solver is on its plane, or no better than before.
            let good = libm::hypot(rms, stop.elsewhere) <= (1.0 + LIMIT_COST) * plain || rms <= STOP.rms;
            if good || correction == MOST_CORRECTIONS || rms > (1.0 - LIMIT_COST) * earlier {
                break;
            }
            for (target, missing) in target.iter_mut().zip(&missing) {
                *target += missing;
            }
            solved = solver.solve(&target, &times, LATER_ITERATIONS);
        }
        if let Some(best) = best {
            solved = best;
        }
    }
    let (iterations, rounds) = (solver.iterations, solver.rounds);
    let Solved { rms: solver_rms, mut speeds } = solved;
    speed::round(&mut speeds, &segments, &limits, task.speed_steps);
    let step = |i: usize| task.speed_steps.step(speeds[i]);
    let part =
        |at: &dyn Fn(usize) -> bool| inside.iter().filter(|i| at(**i)).count() as f64 / inside.len().max(1) as f64;
    let at_least = part(&|i| speeds[i] < limits.least + step(i));
    let at_bounds = part(&|i| speeds[i] < limits.least + step(i) || speeds[i] > fastest[i] - step(i));
    timed.set_speeds(&segments, &speeds);
    let mut outcome = predict(timed, &footprint, task.surface, task.error, task.clear, dwell)?;
    let speed_of = |pick: fn(f64, f64) -> f64, from: f64| inside.iter().fold(from, |s, &i| pick(s, speeds[i]));
    outcome.figures = Figures {
        floor,
        least_speed: speed_of(f64::min, limits.greatest),
        greatest_speed: speed_of(f64::max, 0.0),
        at_bounds,
        at_least,
        overrun: ends.least_overrun,
        landings: ends.landings,
        landing_time,
        landing_depth: if ends.landings > 0 { landing_time * footprint.peak() } else { 0.0 },
        iterations,
        rounds,
        solver_rms,
        ..outcome.figures
    };
    check_solved(&outcome.figures, dwell, warnings)?;
    Ok(outcome)
}

/// Weighted mean of `value` over the entries.
fn mean(entries: &[f64], weights: &[f64], value: impl Fn(f64) -> f64) -> f64 {
    let sum: f64 = entries.iter().zip(weights).map(|(entry, weight)| weight * value(*entry)).sum();
    sum / weights.iter().sum::<f64>()
}

/// What is wanted and not removed, beside an even layer; 0 where nothing counts.
fn missing(wanted: &[f64], removed: &[f64], weights: &[f64]) -> Vec<f64> {
    let mut missing: Vec<f64> = wanted.iter().zip(removed).map(|(wanted, removed)| wanted - removed).collect();
    let even = mean(&missing, weights, |d| d);
    for (missing, weight) in missing.iter_mut().zip(weights) {
        *missing = if *weight > 0.0 { *missing - even } else { 0.0 };
    }
    missing
}
