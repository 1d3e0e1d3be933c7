//! The plan of a corrective run: checks, solve, speeds, prediction.
//!
//! In: a [`Task`]. Out: an [`Outcome`], or what makes the run impossible, with the number that would mend it; or the
//! table of what is to be had in which time.

use super::SpeedSteps;
use super::curved::{self, Relief, cosines, steepest};
use super::descent::Ended;
use super::feasibility::{check_base, check_corners, check_resolution, check_solved, check_start, limits};
use super::field::Field;
use super::footprint::{Footprint, floor_depth};
use super::objective::{Base, Figures as Residual};
use super::outcome::{Figures, Outcome, predict};
use super::removal::{Removal, Samples};
use super::solver::{Aim, LATER_ITERATIONS, MOST_ITERATIONS, NOTHING, Solved, Solver};
use super::speed::{self, Limits, Segments};
use super::start::{Start, start};
use super::timed::{Standing, TimedPath, standing_depths};
use crate::diagnostics::Problem;
use crate::height_map::Grid;
use crate::job::{self, Aperture, Corrective};
use crate::path::ToolPath;
use crate::path::ends::{self, LineEnds};
use crate::tool::InfluenceField;
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
    pub influence: &'a InfluenceField,
    /// Direction of the tool's x axis on the part, radians.
    pub azimuth: f64,
    /// Distance of the tool centre point from the contact along the normal, metres.
    pub standoff: f64,
    pub dwell: &'a Corrective,
    /// Programmed speeds are of these.
    pub speed_steps: SpeedSteps,
}

/// A run that can be solved: all that stands before the solve.
pub(super) struct Prepared<'a> {
    limits: Limits,
    footprint: Footprint<'a>,
    segments: Segments,
    /// The solver's grid.
    coarse: Field,
    /// The glass on it, where it is not flat.
    relief: Option<Relief>,
    /// Wanted depths on the solver's grid, and of these what is left to the segments.
    asked: Vec<f64>,
    pub depths: Vec<f64>,
    base: Base,
    /// Greatest speeds of the segments, and the times at these and at the least feed.
    fastest: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    pub start: Start,
    /// Depth that the path loses at the greatest feed.
    floor: f64,
    ends: LineEnds,
    /// How long a landing counts as standing.
    landing_time: f64,
}

/// The run, and its operator.
pub(super) fn prepare<'a>(task: &Task<'a>, warnings: &mut Vec<Problem>) -> Result<(Prepared<'a>, Removal), Problem> {
    let dwell = task.dwell;
    let limits = limits(dwell, task.speed_steps)?;
    let mut footprint = Footprint::over(task.influence, task.azimuth);
    footprint.standoff = task.standoff;
    let ends = ends::check(&task.path, task.edge, footprint.radius, limits.greatest, limits.acceleration)?;
    let segments = Segments::new(&task.path, task.standoff);
    check_start(&segments, &limits)?;
    check_corners(&task.path, &segments, &limits, task.speed_steps)?;
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
    let asked: Vec<f64> = coarse.values.iter().map(|height| fraction * height).collect();
    // What a standing tool removes is fixed: the rest is asked of the segments.
    let landing_time = task.standing.iter().map(|s| s.seconds).fold(0.0, f64::max);
    let fixed = standing_depths(&task.path, &task.standing, &footprint, &coarse.window);
    let depths: Vec<f64> = asked.iter().zip(&fixed).map(|(asked, fixed)| asked - fixed).collect();
    // A segment's fastest: full feed, as far as corners allow it and the arm gets there from rest and back.
    let mut fastest: Vec<f64> = (0..segments.length.len()).map(|i| segments.greatest(i, &limits)).collect();
    speed::limit(&mut fastest, &segments, &limits);
    let lower = speed::times(&fastest, &segments, &limits);
    let slowest = vec![limits.least; segments.length.len()];
    let mut upper = speed::times(&slowest, &segments, &limits);
    for (upper, lower) in upper.iter_mut().zip(&lower) {
        *upper = upper.max(*lower);
    }
    let everywhere = task.path.region.is_none();
    let start = start(&mut operator, &coarse, &segments, &depths, base, everywhere)?;
    let run = Prepared {
        limits,
        footprint,
        segments,
        coarse,
        relief,
        asked,
        depths,
        base,
        fastest,
        lower,
        upper,
        start,
        floor,
        ends,
        landing_time,
    };
    Ok((run, operator))
}

impl Prepared<'_> {
    pub(super) fn solver<'b>(&'b self, operator: &'b mut Removal, dwell: &Corrective) -> Solver<'b> {
        Solver {
            operator,
            segments: &self.segments,
            limits: &self.limits,
            weights: &self.coarse.weights,
            lower: &self.lower,
            upper: &self.upper,
            stiffness: &self.start.stiffness,
            base: self.base,
            aim: match &dwell.objective {
                job::Objective::rms(_) => Aim::Rms,
                job::Objective::pv(_) => Aim::Pv,
                job::Objective::time(time) => Aim::Time { rms: time.rms.0 },
            },
            elsewhere: (1.0 - dwell.removal_fraction) * self.coarse.rms(),
            iterations: 0,
            rounds: 0,
            price: 0.0,
        }
    }
}

/// A run of least time is solved again for so much less than would just do.
const SPARE: f64 = 0.005;

/// Times that a run of least time is solved again, since the prediction leaves more than the solver said.
const MOST_TIGHTENINGS: usize = 3;

/// Solves the dwell of a run. Oddities that leave it usable are said to `warnings`.
///
/// # Errors
///
/// E0644 (a line ends over the part), E0700 (feed, acceleration or fraction unusable), E0701 (the arm cannot reach the
/// least feed in one segment), E0710 (nor keep it in the sharpest corner), E0702 (the floor is deeper than what is wanted), E0509
/// (the map does not cover the clear aperture), E0704 (the path does not reach part of it), E0705 (nothing to remove), E0706
/// (pixels too coarse), E0708 (the layer is deeper than allowed), E0711 (the residual cannot be made so small).
pub fn solve(task: Task, warnings: &mut Vec<Problem>) -> Result<Outcome, Problem> {
    // From inside the pool a short piece of parallel work costs a tenth of what it costs from outside, and a step has thirty.
    rayon::scope(|_| solve_inside(task, warnings))
}

fn solve_inside(task: Task, warnings: &mut Vec<Problem>) -> Result<Outcome, Problem> {
    let dwell = task.dwell;
    let (run, mut operator) = prepare(&task, warnings)?;
    let mut solver = run.solver(&mut operator, dwell);
    let mut timed = TimedPath::new(task.path, task.standing, task.standoff, &run.limits, task.speed_steps);
    let mut target = run.depths.clone();
    let mut solved = solver.solve(&target, &run.start.times, MOST_ITERATIONS);
    if let Some(relief) = &run.relief {
        solved = run.corrected(relief, &mut solver, &mut timed, &mut target, solved);
    }
    let mut tightenings = 0;
    loop {
        let solver_rms = solved.figures.rms;
        let mut speeds = solved.speeds;
        speed::round(&mut speeds, &run.segments, &run.limits, task.speed_steps);
        timed.set_speeds(&run.segments, &speeds);
        let mut outcome = predict(timed, &run.footprint, task.surface, task.error, task.clear, dwell)?;
        if let (Aim::Time { rms }, job::Objective::time(asked)) = (&mut solver.aim, &dwell.objective)
            && outcome.figures.missed > asked.rms.0
            && solver_rms <= 1.1 * *rms
            && tightenings < MOST_TIGHTENINGS
        {
            // The prediction leaves more than was asked of the solver: ask it for less.
            *rms *= (1.0 - SPARE) * asked.rms.0 / outcome.figures.missed;
            tightenings += 1;
            solved = solver.solve(&target, &solved.times, LATER_ITERATIONS);
            timed = outcome.timed;
            continue;
        }
        outcome.figures = Figures {
            iterations: solver.iterations,
            rounds: solver.rounds,
            solver_rms,
            stopped_early: solved.ended == Ended::Iterations,
            ..run.figures(&speeds, task.speed_steps, outcome.figures)
        };
        outcome.ripple =
            super::ripple(&outcome, &run.footprint, task.surface, task.clear, dwell.acceleration.0, task.line_pitch);
        check_solved(&outcome.figures, dwell, warnings)?;
        return Ok(outcome);
    }
}

impl Prepared<'_> {
    /// The figures of the prediction with what only the plan knows of it.
    fn figures(&self, speeds: &[f64], steps: SpeedSteps, predicted: Figures) -> Figures {
        let limits = &self.limits;
        let part = |at: &dyn Fn(usize) -> bool| {
            self.start.inside.iter().filter(|i| at(**i)).count() as f64 / self.start.inside.len().max(1) as f64
        };
        let least = |i: usize| speeds[i] < limits.least + steps.step(speeds[i]);
        let speed_of =
            |pick: fn(f64, f64) -> f64, from: f64| self.start.inside.iter().fold(from, |s, &i| pick(s, speeds[i]));
        Figures {
            floor: self.floor,
            least_speed: speed_of(f64::min, limits.greatest),
            greatest_speed: speed_of(f64::max, 0.0),
            at_bounds: part(&|i| least(i) || speeds[i] > self.fastest[i] - steps.step(speeds[i])),
            at_least: part(&least),
            overrun: self.ends.least_overrun,
            landings: self.ends.landings,
            landing_time: self.landing_time,
            landing_depth: if self.ends.landings > 0 { self.landing_time * self.footprint.peak() } else { 0.0 },
            ..predicted
        }
    }

    /// The solver reckons on a plane. What the surface makes of its times is predicted, and what is then missing asked for
    /// beside, in `target`: the plane's operator only has to point the right way.
    fn corrected(
        &self,
        relief: &Relief,
        solver: &mut Solver,
        timed: &mut TimedPath,
        target: &mut [f64],
        mut solved: Solved,
    ) -> Solved {
        let weights = &self.coarse.weights;
        let mut best: Option<(f64, Solved, Vec<f64>)> = None;
        for correction in 0..=MOST_CORRECTIONS {
            timed.set_speeds(&self.segments, &solved.speeds);
            let removed = relief.removal(timed, &self.footprint, &self.limits);
            let missing = missing(&self.asked, &removed, weights, self.base);
            let rms = mean(&missing, weights, |d| d * d).sqrt();
            let earlier = best.as_ref().map_or(f64::INFINITY, |(rms, ..)| *rms);
            let plain = libm::hypot(solved.figures.rms, solver.elsewhere);
            // As good as the solver is on its plane, or no better than before.
            let good = libm::hypot(rms, solver.elsewhere) <= (1.0 + CORRECTED) * plain || rms <= NOTHING;
            let start = solved.times.clone();
            if rms < earlier {
                best = Some((rms, solved.clone(), target.to_vec()));
            }
            if good || correction == MOST_CORRECTIONS || rms > (1.0 - CORRECTED) * earlier {
                break;
            }
            for (target, missing) in target.iter_mut().zip(&missing) {
                *target += missing;
            }
            solved = solver.solve(target, &start, LATER_ITERATIONS);
        }
        match best {
            Some((rms, found, asked)) => {
                target.copy_from_slice(&asked);
                Solved { figures: Residual { rms, ..found.figures }, ..found }
            }
            None => solved,
        }
    }
}

/// Corrections of the wanted depths on a curved part. Each shrinks what the solver's plane gets wrong to a part of it (a
/// tenth to a third on slopes up to 30 degrees), so that three usually bring it below what is worth a correction; two more are kept for steep parts.
const MOST_CORRECTIONS: usize = 5;

/// Part of the residual that a correction must gain, or that is not worth one: a twentieth of the residual is less than what the
/// influence function is known to.
const CORRECTED: f64 = 0.05;

/// Weighted mean of `value` over the entries.
fn mean(entries: &[f64], weights: &[f64], value: impl Fn(f64) -> f64) -> f64 {
    let sum: f64 = entries.iter().zip(weights).map(|(entry, weight)| weight * value(*entry)).sum();
    sum / weights.iter().sum::<f64>()
}

/// What is wanted and not removed, beside the even layer that the job allows; 0 where nothing counts.
fn missing(wanted: &[f64], removed: &[f64], weights: &[f64], base: Base) -> Vec<f64> {
    let mut missing: Vec<f64> = wanted.iter().zip(removed).map(|(wanted, removed)| wanted - removed).collect();
    let even = match base {
        Base::Fixed(layer) => -layer,
        Base::AtMost(most) => mean(&missing, weights, |d| d).max(-most),
    };
    for (missing, weight) in missing.iter_mut().zip(weights) {
        *missing = if *weight > 0.0 { *missing - even } else { 0.0 };
    }
    missing
}
