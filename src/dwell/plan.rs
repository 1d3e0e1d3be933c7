//! The plan of a corrective run: checks, solve, speeds, prediction.
//!
//! In: a [`Task`]. Out: an [`Outcome`], or what makes the run impossible, with the number that would mend it.

use super::feasibility::{check_base, check_resolution, check_solved, check_start, limits};
use super::field::Field;
use super::footprint::{Footprint, floor_depth};
use super::least_squares::{self, Base, LinearOperator, Stop, Wanted};
use super::removal::{Removal, Samples};
use super::speed::{self, Limits, Segments};
use super::{SpeedSteps, TimedPath, prediction};
use crate::diagnostics::{Problem, codes};
use crate::job::{Aperture, Corrective};
use crate::metrology::Grid;
use crate::path::{self, Link, ToolPath};
use crate::tool::InfluenceFunction;

/// Everything that a corrective run is planned from. Lengths in metres, times in seconds.
pub struct Task<'a> {
    pub path: ToolPath,
    /// Distance of neighbouring lines.
    pub line_pitch: f64,
    /// Form error in the part frame, positive where glass stands too high; no NaN inside `clear`.
    pub error: &'a Grid,
    pub clear: &'a Aperture,
    pub edge: &'a Aperture,
    pub influence: &'a InfluenceFunction,
    /// Direction of the tool's x axis on the part, radians.
    pub azimuth: f64,
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
    let footprint = Footprint::of(task.influence, task.azimuth);
    let ends = path::ends::check(&task.path, task.edge, footprint.radius, limits.greatest, limits.acceleration)?;
    let segments = Segments::new(&task.path);
    check_start(&segments, &limits)?;
    let field = Field::new(task.error, task.clear)?;
    check_resolution(&field, &footprint, task.line_pitch, warnings)?;
    let floor = floor_depth(footprint.volume_rate, limits.greatest, task.line_pitch);
    let fraction = dwell.removal_fraction;
    let base = check_base(&dwell.piston, fraction * field.greatest(), floor, &footprint, &limits)?;

    // The solver's grid: pixels as coarse as the spot allows, since the spot smooths away everything finer.
    let coarse = field.binned(footprint.sigma / 4.0);
    let samples = Samples::segments(&task.path, footprint.sigma / 2.0);
    let mut operator = Removal::new(&samples, &footprint, coarse.window);
    drop(samples);
    let depths: Vec<f64> = coarse.values.iter().map(|height| fraction * height).collect();
    // A segment's fastest: full feed, as far as the arm gets there from rest and back.
    let mut fastest = vec![limits.greatest; segments.length.len()];
    speed::limit(&mut fastest, &segments, &limits);
    let mut lower = speed::times(&fastest, &segments, &limits);
    let slowest = vec![limits.least; segments.length.len()];
    let mut upper = speed::times(&slowest, &segments, &limits);
    raise(&mut upper, &lower);
    let (start, inside) = start(&mut operator, &coarse, &segments, &depths, base)?;

    let stop = Stop { elsewhere: (1.0 - fraction) * coarse.rms(), ..STOP };
    let mut solved = {
        let wanted = Wanted { depths: &depths, weights: &coarse.weights, lower: &lower, upper: &upper, base };
        least_squares::solve(&mut operator, &wanted, &start, stop)
    };
    let (mut iterations, mut rounds) = (solved.iterations, 1);
    let mut best: Option<(f64, Vec<f64>)> = None;
    let all = |rms: f64| libm::hypot(rms, stop.elsewhere);
    loop {
        let speeds = speed::for_times(&solved.times, &segments, &limits);
        let times = speed::times(&speeds, &segments, &limits);
        let wanted = Wanted { depths: &depths, weights: &coarse.weights, lower: &lower, upper: &upper, base };
        let (rms, _) = least_squares::evaluate(&mut operator, &wanted, &times);
        let earlier = best.as_ref().map_or(f64::INFINITY, |(rms, _)| *rms);
        if rms < earlier {
            best = Some((rms, speeds));
        }
        // Good enough: what the arm's limits cost is small beside the residual, or another round gained nothing.
        let cheap = all(rms) <= (1.0 + LIMIT_COST) * all(solved.rms) || rms <= STOP.rms;
        if cheap || rounds > MOST_ROUNDS || rms > (1.0 - LIMIT_COST) * earlier {
            break;
        }
        for i in 0..times.len() {
            if times[i] > solved.times[i] * (1.0 + 1e-6) {
                lower[i] = lower[i].max(times[i]);
            }
        }
        raise(&mut upper, &lower);
        let wanted = Wanted { depths: &depths, weights: &coarse.weights, lower: &lower, upper: &upper, base };
        let stop = Stop { most_iterations: LATER_ITERATIONS, ..stop };
        solved = least_squares::solve(&mut operator, &wanted, &times, stop);
        iterations += solved.iterations;
        rounds += 1;
    }
    let (solver_rms, mut speeds) = best.unwrap_or_default();
    speed::round(&mut speeds, &segments, &limits, task.speed_steps);
    let step = |i: usize| task.speed_steps.step(speeds[i]);
    let part =
        |at: &dyn Fn(usize) -> bool| inside.iter().filter(|i| at(**i)).count() as f64 / inside.len().max(1) as f64;
    let at_least = part(&|i| speeds[i] < limits.least + step(i));
    let at_bounds = part(&|i| speeds[i] < limits.least + step(i) || speeds[i] > fastest[i] - step(i));
    let timed = timed_path(task.path, &segments, &speeds, &limits, task.speed_steps);
    let mut outcome = predict(timed, &footprint, task.error, task.clear, dwell)?;
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

/// Predicts what a timed path removes, from its programmed speeds alone: figures that only the solver knows are zero.
///
/// # Errors
///
/// E0509 (the map does not cover the clear aperture).
pub fn predict(
    timed: TimedPath,
    footprint: &Footprint,
    error: &Grid,
    clear: &Aperture,
    dwell: &Corrective,
) -> Result<Outcome, Problem> {
    let field = Field::new(error, clear)?;
    let limits = Limits { least: dwell.feed.from.0, greatest: dwell.feed.to.0, acceleration: dwell.acceleration.0 };
    let depths = prediction::removal(&timed, footprint, &limits, &field.window);
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
    let segments = Segments::new(&timed.path);
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
    for (&point, &value) in segments.point.iter().zip(speeds) {
        speed[point] = value;
    }
    for pair in path.lines.windows(2) {
        if pair[0].link == Link::OnSurface {
            // From rest to rest over the distance of two lines: half of it speeding up, half slowing down.
            let reachable = (limits.acceleration * link_length(&path, &pair[0], &pair[1])).sqrt();
            speed[pair[1].points.start] = down(limits.greatest.min(reachable));
        }
    }
    TimedPath { path, speed }
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
