//! Whether a run can be: checks before the solve, and words on its result.
//!
//! In: the job's `dwell`, footprint, field, path; afterwards the figures. Out: refusals with the number that would mend
//! them, and warnings.

use super::field::Field;
use super::footprint::Footprint;
use super::objective::Base;
use super::outcome::Figures;
use super::speed::{self, Limits, Segments};
use super::{SpeedSteps, TimedPath};
use crate::diagnostics::{Problem, codes};
use crate::job::{Corrective, Objective, Piston};
use crate::path::ToolPath;

/// The least time between two moves that a controller takes, and the least that is usual for it, seconds.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentTimes {
    /// What the controller is called.
    pub controller: String,
    pub least: f64,
    pub usual: f64,
}

/// Refuses segments that pass faster than the controller takes new moves (E0707), and warns of those that are quicker
/// than is usual for it (W0705).
pub fn check_segment_times(
    timed: &TimedPath,
    standoff: f64,
    dwell: &Corrective,
    wanted: &SegmentTimes,
    warnings: &mut Vec<Problem>,
) -> Result<(), Problem> {
    let limits = Limits::of(dwell);
    let segments = Segments::new(&timed.path, standoff);
    let speeds: Vec<f64> = segments.point.iter().map(|&p| timed.speed[p]).collect();
    let times = speed::times(&speeds, &segments, &limits);
    let Some(i) = (0..times.len()).min_by(|&a, &b| times[a].total_cmp(&times[b])) else { return Ok(()) };
    let [x, y, _] = timed.path.points.position(segments.point[i]);
    let say = |limit: f64| {
        format!(
            "the move to x {:.3} mm, y {:.3} mm takes {:.2} ms at {:.3} mm/s, less than the {:.2} ms of controller `{}`",
            x * 1e3,
            y * 1e3,
            times[i] * 1e3,
            speeds[i] * 1e3,
            limit * 1e3,
            wanted.controller
        )
    };
    let help = "lower the upper end of `feed`, or make `point_step` longer";
    if times[i] < wanted.least {
        return Err(Problem::error(codes::E0707, "dwell.feed", say(wanted.least)).help(help));
    }
    if times[i] < wanted.usual {
        let usual = wanted.usual;
        let count = times.iter().filter(|time| **time < usual).count();
        warnings.push(
            Problem::warning(codes::W0705, "dwell.feed", say(usual))
                .note(format!("{count} of {} moves are that short", times.len()))
                .help(help),
        );
    }
    Ok(())
}

/// The job's limits, if they can be used.
pub(super) fn limits(dwell: &Corrective, steps: SpeedSteps) -> Result<Limits, Problem> {
    let Limits { least, greatest, acceleration, lateral } = Limits::of(dwell);
    let refuse = |field: &str, message: String| {
        Err(Problem::error(codes::E0700, format!("dwell.{field}"), message).help("correct the number"))
    };
    if !(least > 0.0 && least <= greatest && greatest.is_finite()) {
        let message = format!(
            "the feed from {:.4} mm/s to {:.4} mm/s is not a range of positive speeds",
            least * 1e3,
            greatest * 1e3
        );
        return refuse("feed", message);
    }
    // A speed that can be written between the two ends, the ends included in spite of their rounding.
    if steps.down(greatest) < steps.up(least) {
        let step = steps.step(greatest) * 1e3;
        let message = format!("the feed holds no speed that the controller can be told, in steps of {step:.6} mm/s");
        return Err(Problem::error(codes::E0700, "dwell.feed", message).help("widen the range"));
    }
    for (field, value) in [("acceleration", acceleration), ("lateral_acceleration", lateral)] {
        if !(value > 0.0 && value.is_finite()) {
            return refuse(field, format!("the acceleration is {} mm/s²; it must be positive", value * 1e3));
        }
    }
    let fraction = dwell.removal_fraction;
    if !(fraction > 0.0 && fraction <= 1.0) {
        let message = format!("`removal_fraction` is {} %; it must lie above 0 % and at most at 100 %", fraction * 1e2);
        return refuse("removal_fraction", message);
    }
    Ok(Limits { least, greatest, acceleration, lateral })
}

/// No corner of the path may be too sharp for the least feed.
pub(super) fn check_corners(
    path: &ToolPath,
    segments: &Segments,
    limits: &Limits,
    steps: SpeedSteps,
) -> Result<(), Problem> {
    let sharpest = (0..segments.length.len()).max_by(|&a, &b| segments.curvature[a].total_cmp(&segments.curvature[b]));
    let Some(i) = sharpest else { return Ok(()) };
    let greatest = segments.greatest(i, limits);
    let least = steps.up(limits.least);
    if greatest >= least {
        return Ok(());
    }
    let [x, y, _] = path.points.position(segments.point[i]);
    let message = format!(
        "near x {:.3} mm, y {:.3} mm the path turns with a radius of {:.4} mm, where {:.3} mm/s² across the way allow \
         {:.4} mm/s, less than the least feed of {:.4} mm/s",
        x * 1e3,
        y * 1e3,
        1e3 / segments.curvature[i],
        limits.lateral * 1e3,
        greatest * 1e3,
        least * 1e3
    );
    Err(Problem::error(codes::E0710, "dwell.feed", message)
        .help(format!("lower the least feed to {:.4} mm/s, or let the path turn more gently", greatest * 1e3)))
}

/// The least feed must be reachable from rest within half a segment, where a line ends.
pub(super) fn check_start(segments: &Segments, limits: &Limits) -> Result<(), Problem> {
    let shortest = segments.length.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    let reachable = (limits.acceleration * shortest).sqrt();
    if limits.least <= reachable {
        return Ok(());
    }
    let message = format!(
        "at {:.3} mm/s² the arm gets from rest to {:.4} mm/s and back within a move of {:.3} mm, which is slower than \
         the least feed of {:.4} mm/s",
        limits.acceleration * 1e3,
        reachable * 1e3,
        shortest * 1e3,
        limits.least * 1e3
    );
    Err(Problem::error(codes::E0701, "dwell.feed", message).help("lower the least feed, or make `point_step` longer"))
}

/// Whether map and lines are fine enough for the spot, on slopes down to the cosine `steepest`.
pub(super) fn check_resolution(
    field: &Field,
    footprint: &Footprint,
    line_pitch: f64,
    steepest: f64,
    warnings: &mut Vec<Problem>,
) -> Result<(), Problem> {
    let pixel = field.window.pixel[0].max(field.window.pixel[1]);
    let message = format!(
        "the map's pixels of {:.3} mm are coarse beside the spot, whose effective sigma, cut at its diameter, is {:.3} mm",
        pixel * 1e3,
        footprint.sigma * 1e3
    );
    let sigma = footprint.sigma * steepest;
    if pixel > sigma / 2.0 {
        return Err(Problem::error(codes::E0706, "workpiece.error", message)
            .note("pixels wider than half a sigma cannot carry what the tool removes")
            .help(format!(
                "use a map with pixels of at most {:.3} mm; up to {:.3} mm it works with a warning",
                sigma / 4.0 * 1e3,
                sigma / 2.0 * 1e3
            )));
    }
    if pixel > sigma / 4.0 {
        warnings.push(
            Problem::warning(codes::W0700, "workpiece.error", message)
                .note("the predicted removal is right to a few per cent only")
                .help(format!("use a map with pixels of at most {:.3} mm", sigma / 4.0 * 1e3)),
        );
    }
    // A ripple of a thousandth of the removal lies below what influence functions repeat to.
    const RIPPLE: f64 = 1e-3;
    // Lines at a distance p of Gaussian profile with width sigma leave a ripple of 2 exp(-2 pi² sigma²/p²) of the depth
    // (the first term of the Fourier series): 0.03 % at 1.5 sigma, 1.4 % at 2 sigma.
    let ratio = std::f64::consts::PI * sigma / line_pitch;
    let ripple = 2.0 * libm::exp(-2.0 * ratio * ratio);
    if ripple > RIPPLE {
        // Beyond half of the depth the first term alone says too little, and the strips are plain to see.
        let leave = if ripple < 0.5 {
            format!("a ripple of about {:.2} % of the removal", ripple * 1e2)
        } else {
            "strips between them that lose hardly anything".to_string()
        };
        let message = format!(
            "lines {:.3} mm apart leave {leave}, since the spot's sigma is {:.3} mm",
            line_pitch * 1e3,
            footprint.sigma * 1e3
        );
        warnings.push(
            Problem::warning(codes::W0701, "path.line_pitch", message)
                .help(format!("a `line_pitch` of {:.3} mm leaves less than 0.1 %", 1.6 * sigma * 1e3)),
        );
    }
    Ok(())
}

/// The even layer that the solver may take, after the checks of what the path must take.
pub(super) fn check_base(
    piston: &Piston,
    highest: f64,
    floor: f64,
    footprint: &Footprint,
    limits: &Limits,
) -> Result<Base, Problem> {
    let (base, field, most, what) = match piston {
        Piston::free(free) => {
            let most = free.at_most.map_or(f64::INFINITY, |depth| depth.0);
            (Base::AtMost(most), "dwell.piston.at_most", most, "the even layer of at most")
        }
        Piston::fixed(fixed) => {
            (Base::Fixed(fixed.depth.0), "dwell.piston.depth", fixed.depth.0, "the fixed even layer of")
        }
        // Without an even layer the highest place still must lose more than the path takes everywhere.
        Piston::held(_) => (Base::Fixed(0.0), "dwell.piston", highest, "the highest place, which asks for"),
    };
    let layer = match base {
        Base::Fixed(depth) => depth,
        Base::AtMost(most) => most,
    };
    if layer + highest <= 0.0 {
        let message = "nowhere in the clear aperture is there anything to remove";
        return Err(Problem::error(codes::E0705, "workpiece.error", message)
            .help("check `positive` and `subtract` of the map, or allow an even layer: `piston: free {}`"));
    }
    if floor > most {
        let message = format!(
            "even at its greatest feed the path removes {:.3} nm everywhere, more than {what} {:.3} nm",
            floor * 1e9,
            most * 1e9
        );
        // V / (v pitch) = most, solved for each of its three factors.
        let factor = floor / most.max(0.0);
        let help = if factor.is_finite() {
            format!(
                "raise the feed above {:.3} mm/s, or make `line_pitch` {factor:.2} times as wide, or use a spot that \
                 removes less than {:.4} mm³/min, or allow a deeper layer",
                limits.greatest * factor * 1e3,
                footprint.volume_rate / factor * 60e9
            )
        } else {
            "allow an even layer: `piston: free {}`".to_string()
        };
        return Err(Problem::error(codes::E0702, field, message).help(help));
    }
    Ok(base)
}

/// Whether the even layer is what holds the solver: it may have none, this one only, or all that it is allowed.
fn deeper_helps(figures: &Figures, piston: &Piston) -> bool {
    match piston {
        Piston::free(free) => free.at_most.is_some_and(|most| figures.base > 0.95 * most.0),
        Piston::fixed(_) | Piston::held(_) => true,
    }
}

/// What is wrong (E0708) or odd about a solved run.
pub(super) fn check_solved(figures: &Figures, dwell: &Corrective, warnings: &mut Vec<Problem>) -> Result<(), Problem> {
    // A tenth of the times at a bound is where the reference study saw the residual suffer.
    if figures.at_bounds > 0.1 {
        let message = format!(
            "{:.0} % of the moves over the clear aperture run as fast as they may, and {:.0} % at the least feed",
            (figures.at_bounds - figures.at_least) * 1e2,
            figures.at_least * 1e2
        );
        warnings.push(
            Problem::warning(codes::W0702, "dwell.feed", message)
                .note("the solver would go faster or slower there; the residual suffers")
                .help(if deeper_helps(figures, &dwell.piston) {
                    "widen `feed`, or allow a deeper even layer in `piston`"
                } else {
                    "widen `feed`"
                }),
        );
    }
    if let Piston::free(free) = &dwell.piston
        && let Some(most) = free.at_most
        && figures.base > 1.05 * most.0
    {
        let message = format!(
            "the even layer will be {:.3} nm, more than the {:.3} nm that the piston may have",
            figures.base * 1e9,
            most.0 * 1e9
        );
        return Err(Problem::error(codes::E0708, "dwell.piston.at_most", message)
            .note("valleys deeper than the layer lose glass too, since no feed is fast enough to remove nothing")
            .help("raise `at_most`, or the upper end of `feed`"));
    }
    if let Objective::time(time) = &dwell.objective
        && figures.missed > time.rms.0
    {
        let message = format!(
            "the best that this path, spot and feed leave is {:.4} nm RMS, more than the {:.4} nm asked for",
            figures.missed * 1e9,
            time.rms.0 * 1e9
        );
        // Rounded up to a thousandth of a nanometre, the finest that is printed.
        let good = (figures.missed * 1e12).ceil() * 1e-3 + 0.001;
        return Err(Problem::error(codes::E0711, "dwell.objective.rms", message)
            .help(format!("ask for {good:.3} nm or more; `--emit pareto` shows what is to be had in which time")));
    }
    if figures.stopped_early {
        let message = format!(
            "the solver used its {} steps while they still lowered the residual, now {:.3} nm RMS",
            figures.iterations,
            figures.rms * 1e9
        );
        warnings.push(
            Problem::warning(codes::W0710, "dwell", message)
                .note("the run does what is predicted of it; a better one may exist")
                .help("lay the lines closer, or widen `feed`"),
        );
    }
    if figures.rms > figures.before_rms {
        let message = format!(
            "the run is predicted to leave the part worse: {:.3} nm RMS, from {:.3} nm",
            figures.rms * 1e9,
            figures.before_rms * 1e9
        );
        warnings.push(
            Problem::warning(codes::W0704, "dwell", message)
                .help("do not run it; the error may be finer than the spot"),
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{Empty, FreePiston};
    use crate::units::si::{Acceleration, Range, Speed};

    #[test]
    fn a_solver_that_was_cut_short_is_told_of() {
        let dwell = Corrective {
            objective: Objective::rms(Empty {}),
            removal_fraction: 1.0,
            piston: Piston::free(FreePiston { at_most: None }),
            feed: Range { from: Speed(1e-3), to: Speed(0.1) },
            acceleration: Acceleration(0.5),
            lateral_acceleration: None,
        };
        let figures = Figures { before_rms: 1e-8, rms: 1e-9, iterations: 200, ..Figures::default() };
        let mut warnings = Vec::new();
        check_solved(&figures, &dwell, &mut warnings).expect("a usable run");
        assert!(warnings.is_empty());
        check_solved(&Figures { stopped_early: true, ..figures }, &dwell, &mut warnings).expect("a usable run");
        assert_eq!(warnings.iter().map(|w| w.code.as_str()).collect::<Vec<_>>(), ["W0710"]);
        assert!(warnings[0].message.contains("200 steps") && warnings[0].message.contains("1.000 nm"));
    }
}
