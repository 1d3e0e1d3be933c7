//! The plan of a corrective run: checks, solve, speeds, prediction.
//!
//! In: a [`Task`]. Out: an [`Outcome`], or what makes the run impossible, with the number that would mend it.

use super::curved::{self, Relief};
use super::feasibility::{check_base, check_resolution, check_solved, check_start, limits};
use super::field::Field;
use super::footprint::{Footprint, floor_depth};
use super::least_squares::{self, Base, LinearOperator, Stop, Wanted};
use super::removal::{Removal, Samples, Window};
use super::speed::{self, Limits, Segments};
use super::{SpeedSteps, TimedPath, prediction};
use crate::diagnostics::{Problem, codes};
use crate::height_map::Grid;
use crate::job::{Aperture, Corrective};
use crate::path::{self, Link, ToolPath};
use crate::tool::InfluenceField;
use crate::workpiece::form::Surface;
use rayon::prelude::*;

/// Everything that a corrective run is planned from. Lengths in metres, times in seconds.
pub struct Task<'a> {
    pub path: ToolPath,
    /// Distance of neighbouring lines.
    pub line_pitch: f64,
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

/// A solved run.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub timed: TimedPath,
    /// Depth that will be removed, on the map's pixels; NaN outside the clear aperture.
    pub removal: Grid,
    /// Error that will be left, the even layer taken out; NaN outside the clear aperture.
    pub residual: Grid,
    pub figures: Figures,
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
    /// Steps of the solver, all rounds together.
    pub iterations: usize,
    /// Solves: one, and one more each time that the arm's acceleration asked for slower speeds.
    pub rounds: usize,
    /// What the solver's own operator says of the same times (without rounding): a check of one against the other.
    pub solver_rms: f64,
}

/// Rounds of limiting and solving again. After six the bounds hardly move (measured in the model's study of limits).
const MOST_ROUNDS: usize = 6;

/// Part of the residual that the arm's limits may cost, or another round must gain: a twentieth of the residual is less
/// than what the influence function is known to.
const LIMIT_COST: f64 = 0.05;

/// Corrections of the wanted depths on a curved part. Each shrinks what the solver's plane gets wrong to a part of it (a
/// tenth to a third on slopes up to 30 degrees), so that three bring it below the limits' own cost.
const MOST_CORRECTIONS: usize = 5;

/// Steps of a solve that starts from a solved neighbour.
const LATER_ITERATIONS: usize = 40;

/// When the solver stops. Heights below a hundredth of a nanometre are beneath every interferometer's repeatability;
/// ten steps that together gain less than 1 % of the RMS are not worth their time.
const STOP: Stop =
    Stop { most_iterations: 200, relative_decrease: 0.01, elsewhere: 0.0, rms: 1e-11, relative_step: 1e-9 };

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
    let mut footprint = Footprint::of(&task.influence.parts[0], task.azimuth);
    footprint.standoff = task.standoff;
    let ends = path::ends::check(&task.path, task.edge, footprint.radius, limits.greatest, limits.acceleration)?;
    let segments = Segments::new(&task.path, task.standoff);
    check_start(&segments, &limits)?;
    let field = Field::new(task.error, task.clear)?;
    curved::check(task.surface, &field, &footprint, warnings)?;
    // On a slope pixels and lines lie farther apart on the glass than across the axis.
    let steepest = steepest(task.surface, &field);
    check_resolution(&field, &footprint, task.line_pitch, steepest, warnings)?;
    let floor = floor_depth(footprint.volume_rate, limits.greatest, task.line_pitch);
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
    let depths: Vec<f64> = coarse.values.iter().map(|height| fraction * height).collect();
    // A segment's fastest: full feed, as far as the arm gets there from rest and back.
    let mut fastest = vec![limits.greatest; segments.length.len()];
    speed::limit(&mut fastest, &segments, &limits);
    let lower = speed::times(&fastest, &segments, &limits);
    let slowest = vec![limits.least; segments.length.len()];
    let mut upper = speed::times(&slowest, &segments, &limits);
    raise(&mut upper, &lower);
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
    let mut timed = timed_path(task.path, &segments, &solved.speeds, &limits, task.speed_steps);
    if let Some(relief) = &relief {
        // The solver reckons on a plane. What the surface makes of its times is predicted, and what is then missing asked for
        // beside: the plane's operator only has to point the right way.
        let mut target = depths.clone();
        let mut best: Option<Solved> = None;
        for correction in 0..=MOST_CORRECTIONS {
            set_speeds(&mut timed, &segments, &solved.speeds);
            let removed = relief.removal(&timed, &footprint, &limits);
            let missing = missing(&depths, &removed, &coarse.weights);
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
    set_speeds(&mut timed, &segments, &speeds);
    let mut outcome = predict(timed, &footprint, task.surface, task.error, task.clear, dwell)?;
    let speed_of = |pick: fn(f64, f64) -> f64, from: f64| inside.iter().fold(from, |s, &i| pick(s, speeds[i]));
    outcome.figures = Figures {
        floor,
        least_speed: speed_of(f64::min, limits.greatest),
        greatest_speed: speed_of(f64::max, 0.0),
        at_bounds,
        at_least,
        overrun: ends.least_overrun,
        iterations,
        rounds,
        solver_rms,
        ..outcome.figures
    };
    check_solved(&outcome.figures, dwell, warnings)?;
    Ok(outcome)
}

/// Speeds of one solve, and what its operator says of them.
struct Solved {
    rms: f64,
    speeds: Vec<f64>,
}

/// What all solves of a run share.
struct Solver<'a> {
    operator: &'a mut Removal,
    segments: &'a Segments,
    limits: &'a Limits,
    weights: &'a [f64],
    /// Times of the segments at their fastest and slowest.
    lower: &'a [f64],
    upper: &'a [f64],
    base: Base,
    stop: Stop,
    iterations: usize,
    rounds: usize,
}

impl Solver<'_> {
    /// Times for the wanted depths, and speeds that the arm can follow: solved again, with the times that it needs as
    /// least ones, as long as that gains something.
    fn solve(&mut self, depths: &[f64], start: &[f64], most_iterations: usize) -> Solved {
        let (mut lower, mut upper) = (self.lower.to_vec(), self.upper.to_vec());
        let mut start = start.to_vec();
        let all = |rms: f64| libm::hypot(rms, self.stop.elsewhere);
        let mut best: Option<Solved> = None;
        for round in 0..=MOST_ROUNDS {
            let most_iterations = if round == 0 { most_iterations } else { LATER_ITERATIONS };
            let stop = Stop { most_iterations, ..self.stop };
            let wanted = Wanted { depths, weights: self.weights, lower: &lower, upper: &upper, base: self.base };
            let solved = least_squares::solve(self.operator, &wanted, &start, stop);
            self.iterations += solved.iterations;
            self.rounds += 1;
            let speeds = speed::for_times(&solved.times, self.segments, self.limits);
            let times = speed::times(&speeds, self.segments, self.limits);
            let (rms, _) = least_squares::evaluate(self.operator, &wanted, &times);
            let earlier = best.as_ref().map_or(f64::INFINITY, |best| best.rms);
            if rms < earlier {
                best = Some(Solved { rms, speeds });
            }
            // Good enough: what the arm's limits cost is small beside the residual, or another round gained nothing.
            let cheap = all(rms) <= (1.0 + LIMIT_COST) * all(solved.rms) || rms <= STOP.rms;
            if cheap || rms > (1.0 - LIMIT_COST) * earlier {
                break;
            }
            for i in 0..times.len() {
                if times[i] > solved.times[i] * (1.0 + 1e-6) {
                    lower[i] = lower[i].max(times[i]);
                }
            }
            raise(&mut upper, &lower);
            start = times;
        }
        // Without a finite residual there is nothing to follow: the slowest speeds remove most and hide nothing.
        best.unwrap_or_else(|| Solved {
            rms: f64::INFINITY,
            speeds: vec![self.limits.least; self.segments.length.len()],
        })
    }
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

/// Cosine of the surface's slope at every pixel; 1 where the form does not exist.
fn cosines(surface: &dyn Surface, window: &Window) -> Vec<f64> {
    let cosine = |i: usize| {
        let [x, y] = window.position(i);
        surface.at(x, y).map_or(1.0, |point| point.normal()[2])
    };
    (0..window.len()).into_par_iter().map(cosine).collect()
}

/// Least cosine of the slope where the field counts.
fn steepest(surface: &dyn Surface, field: &Field) -> f64 {
    if surface.is_plane() {
        return 1.0;
    }
    let cosines = cosines(surface, &field.window);
    cosines.iter().zip(&field.weights).filter(|(_, w)| **w > 0.0).fold(1.0, |least, (cosine, _)| cosine.min(least))
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
    let limits = Limits { least: dwell.feed.from.0, greatest: dwell.feed.to.0, acceleration: dwell.acceleration.0 };
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
    let figures = Figures {
        before_rms,
        before_pv,
        rms,
        pv,
        base,
        mean_removal: mean(&|i| depths[i]),
        greatest_removal: inside.iter().fold(0.0, |most, &i| depths[i].max(most)),
        time: speed::times(&speeds, &segments, &limits).iter().sum::<f64>() + link_time(&timed, &limits),
        ..Figures::default()
    };
    let mut removal = nowhere(error);
    let mut residual = nowhere(error);
    for &i in &inside {
        let at = field.place_in_map(i);
        removal.values[at] = depths[i];
        residual.values[at] = left(i);
    }
    Ok(Outcome { timed, removal, residual, figures })
}

/// A grid like `like`, unknown everywhere.
fn nowhere(like: &Grid) -> Grid {
    Grid { values: vec![f64::NAN; like.values.len()], ..like.clone() }
}

fn raise(upper: &mut [f64], lower: &[f64]) {
    for (upper, lower) in upper.iter_mut().zip(lower) {
        *upper = upper.max(*lower);
    }
}

/// Times to start from: as long on each segment as the wanted depth around it asks for, against what a unit of
/// slowness removes there. Beside them, the segments that do at least half of their work inside the clear aperture.
fn start(
    operator: &mut Removal,
    field: &Field,
    segments: &Segments,
    depths: &[f64],
    base: Base,
) -> Result<(Vec<f64>, Vec<usize>), Problem> {
    let inside = |i: usize| field.weights[i] > 0.0;
    let mut unit = vec![0.0; depths.len()];
    operator.forward(&segments.length, &mut unit);
    let count = (0..unit.len()).filter(|&i| inside(i)).count();
    let mean = (0..unit.len()).filter(|&i| inside(i)).map(|i| unit[i]).sum::<f64>() / count as f64;
    // A pixel that the path reaches with less than a hundredth of the usual strength would need a feed a hundred times
    // slower than its neighbours': the path does not cover it.
    if let Some(i) = (0..unit.len()).find(|&i| inside(i) && unit[i] <= 0.01 * mean) {
        let [x, y] = field.window.position(i);
        let message = format!("the path does not reach x {:.3} mm, y {:.3} mm in the clear aperture", x * 1e3, y * 1e3);
        return Err(Problem::error(codes::E0704, "path.over", message)
            .help("let `over` reach beyond the clear aperture, and lay the lines closer than the spot is wide"));
    }
    let lowest = (0..depths.len()).filter(|&i| inside(i)).fold(f64::INFINITY, |low, i| low.min(depths[i]));
    let base = match base {
        Base::Fixed(base) => base,
        Base::AtMost(most) => most.min(-lowest),
    };
    let weigh = |values: &dyn Fn(usize) -> f64| (0..depths.len()).map(|i| field.weights[i] * values(i)).collect();
    let (wanted, have): (Vec<f64>, Vec<f64>) = (weigh(&|i| (depths[i] + base).max(0.0)), weigh(&|i| unit[i]));
    let (mut local_wanted, mut local_have) = (vec![0.0; segments.length.len()], vec![0.0; segments.length.len()]);
    operator.transpose(&wanted, &mut local_wanted);
    operator.transpose(&have, &mut local_have);
    let mut work = vec![0.0; segments.length.len()];
    operator.transpose(&field.weights, &mut work);
    let whole = work.iter().fold(0.0f64, |most, w| most.max(*w));
    let start = (0..segments.length.len())
        .map(|i| {
            // Where a segment does less than a millionth of its work inside the aperture the quotient is rounding noise;
            // its time cannot matter, and it gets the shortest.
            if work[i] > 1e-6 * whole { segments.length[i] * local_wanted[i] / local_have[i] } else { 0.0 }
        })
        .collect();
    Ok((start, (0..work.len()).filter(|&i| work[i] >= 0.5 * whole).collect()))
}

fn timed_path(path: ToolPath, segments: &Segments, speeds: &[f64], limits: &Limits, steps: SpeedSteps) -> TimedPath {
    let down = |speed: f64| match steps.down(speed) {
        // Slower than anything that can be written: the least that can.
        0.0 => steps.step(speed),
        speed => speed,
    };
    let mut speed = vec![down(limits.greatest); path.points.len()];
    for pair in path.lines.windows(2) {
        if pair[0].link == Link::OnSurface {
            // From rest to rest over the distance of two lines: half of it speeding up, half slowing down.
            let reachable = (limits.acceleration * link_length(&path, &pair[0], &pair[1])).sqrt();
            speed[pair[1].points.start] = down(limits.greatest.min(reachable));
        }
    }
    let mut timed = TimedPath { path, speed };
    set_speeds(&mut timed, segments, speeds);
    timed
}

/// Puts the speeds of the segments on the points that end them.
fn set_speeds(timed: &mut TimedPath, segments: &Segments, speeds: &[f64]) {
    for (&point, &value) in segments.point.iter().zip(speeds) {
        timed.speed[point] = value;
    }
}

fn link_length(path: &ToolPath, line: &path::Line, next: &path::Line) -> f64 {
    let [a, b] = [line.points.end - 1, next.points.start].map(|p| path.points.position(p));
    libm::hypot(libm::hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2])
}

/// Time of the ways from line to line on the surface, from rest to rest.
fn link_time(timed: &TimedPath, limits: &Limits) -> f64 {
    let on_surface = timed.path.lines.windows(2).filter(|pair| pair[0].link == Link::OnSurface);
    on_surface
        .map(|pair| {
            let speed = timed.speed[pair[1].points.start];
            link_length(&timed.path, &pair[0], &pair[1]) / speed + speed / limits.acceleration
        })
        .sum()
}
