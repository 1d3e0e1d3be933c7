//! Simulate: what a program will remove, or what a run removed, from what the machine is told or what it did.
//!
//! In: the moves of a program's text ([`Trace`]) or a machine's [`Log`](log::Log), and the [`Scene`] that they belong to. Out: an
//! [`Outcome`] by the forward model of [`dwell`](crate::dwell::predict), on the error map's pixels. [`contact`] turns moves into
//! stretches on the surface, [`log`] reads what a machine wrote down, [`follow`] finds the samples along the plan, [`as_run`]
//! says where a run departs from it; [`inspect`] tells what is in a log by itself.

pub mod as_run;
pub mod contact;
pub mod follow;
pub mod inspect;
pub mod log;

use crate::diagnostics::{Problem, codes};
use crate::dwell::{self, Footprint, Outcome, TimedPath};
use crate::height_map::Grid;
use crate::job::{Corrective, Landing, Workpiece};
use crate::tool::InfluenceField;
use crate::units::si::Acceleration;
use crate::verify::Trace;
use crate::workpiece::form::Surface;
use as_run::{AsRun, Plan};
use contact::{Contact, Stand};

/// What a program or a run belongs to. Lengths in metres.
pub struct Scene<'a> {
    pub workpiece: &'a Workpiece,
    pub surface: &'a dyn Surface,
    pub error: &'a Grid,
    pub influence: &'a InfluenceField,
    /// Distance of the tool centre point from the contact along the normal.
    pub standoff: f64,
    pub dwell: &'a Corrective,
    /// Distance of neighbouring lines of the plan.
    pub line_pitch: f64,
    /// How the plan lands on the part and leaves it.
    pub landing: Option<Landing>,
    /// Height that the tool travels at between runs; `None` for a job without a robot.
    pub travel: Option<f64>,
}

/// Height above the contact from which a log's tool is lifted where no robot states a travel height, metres: the least that
/// is usual for one.
const TRAVEL: f64 = 5e-3;

/// Largest difference between two predictions of the removal of one program, as a share of the largest removal: what speeds
/// and places lose when they are written as text is a thousandth of it.
pub const SAME: f64 = 0.01;

impl Scene<'_> {
    fn footprint(&self) -> Footprint<'_> {
        let mut footprint = Footprint::over(self.influence, self.influence.azimuth);
        footprint.standoff = self.standoff;
        footprint
    }

    fn stand(&self, reach: f64) -> Stand<'_> {
        Stand {
            surface: self.surface,
            edge: &self.workpiece.edge,
            standoff: self.standoff,
            // Halfway to the travel height: a move that goes there goes from one to the other.
            lifted: self.travel.unwrap_or(TRAVEL) / 2.0,
            reach,
            landing: self.landing,
        }
    }

    fn predict(&self, timed: TimedPath, footprint: &Footprint, dwell: &Corrective) -> Result<Outcome, Problem> {
        let clear = &self.workpiece.clear;
        let mut outcome = dwell::predict(timed, footprint, self.surface, self.error, clear, dwell)?;
        outcome.ripple = dwell::ripple(&outcome, footprint, self.surface, clear, dwell.acceleration.0, self.line_pitch);
        Ok(outcome)
    }
}

/// What a program removes, by its text.
///
/// # Errors
///
/// E1300 where the tool is neither in contact nor lifted.
pub fn program(trace: &Trace, scene: &Scene) -> Result<(Outcome, Contact), Problem> {
    let footprint = scene.footprint();
    let mut contact = contact::of_trace(trace, &scene.stand(footprint.radius), scene.dwell.acceleration.0)?;
    let timed = std::mem::take(&mut contact.timed);
    Ok((scene.predict(timed, &footprint, scene.dwell)?, contact))
}

/// What a run removed, by its log, and how it departs from `plan`.
///
/// # Errors
///
/// E1306 where the log does not follow the path.
pub fn run(log: &log::Log, plan: &TimedPath, scene: &Scene) -> Result<(Outcome, AsRun), Problem> {
    let mut footprint = scene.footprint();
    let compared = Plan {
        timed: plan,
        line_pitch: scene.line_pitch,
        acceleration: scene.dwell.acceleration.0,
        clear: &scene.workpiece.clear,
        sigma: footprint.sigma,
    };
    let mut run = as_run::as_run(log, &compared, &scene.stand(footprint.radius))?;
    // The log's speeds are those of the contact, between samples constant, and nothing of the arm is left to reckon.
    footprint.standoff = 0.0;
    let driven = Corrective { acceleration: Acceleration(INSTANT), ..scene.dwell.clone() };
    let timed = std::mem::take(&mut run.timed);
    Ok((scene.predict(timed, &footprint, &driven)?, run))
}

/// An acceleration that no time goes into, m/s²: from rest to 1 m/s within a nanosecond.
const INSTANT: f64 = 1e9;

/// How far one removal lies from another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    /// Greatest difference of depths, metres, where, and as a share of the greatest removal.
    pub most: f64,
    pub place: [f64; 2],
    pub share: f64,
    /// Root mean square of the difference, metres, the mean included: a removal that is too deep everywhere differs.
    pub rms: f64,
}

/// The difference of `found` from `plan`, on the pixels that both know.
pub fn difference(plan: &Grid, found: &Grid) -> Difference {
    let (mut most, mut squares, mut count, mut greatest) = ((0.0, 0), 0.0, 0usize, 0.0f64);
    for (i, (plan, found)) in plan.values.iter().zip(&found.values).enumerate() {
        let d = found - plan;
        if d.is_nan() {
            continue;
        }
        greatest = greatest.max(*plan);
        count += 1;
        squares += d * d;
        if d.abs() > f64::abs(most.0) {
            most = (d, i);
        }
    }
    Difference {
        most: most.0,
        place: plan.position(most.1 / plan.columns.max(1), most.1 % plan.columns.max(1)),
        share: if greatest > 0.0 { most.0.abs() / greatest } else { 0.0 },
        rms: if count > 0 { (squares / count as f64).sqrt() } else { 0.0 },
    }
}

/// That a program of ours does not remove what was planned.
pub fn not_as_planned(difference: &Difference) -> Problem {
    let [x, y] = difference.place.map(|v| v * 1e3 + 0.0);
    let message = format!(
        "the program, read back, removes up to {:.3} nm ({:.2} % of the largest removal) other than planned, at x {x:.3} mm, \
         y {y:.3} mm",
        difference.most.abs() * 1e9,
        difference.share * 100.0
    );
    Problem::error(codes::E1301, "target", message)
        .note(format!("text and plan must agree within {:.0} %", SAME * 100.0))
        .help("this is a fault of the compiler: do not run the program, and report it with the job")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn removals_are_compared_pixel_by_pixel() {
        let grid = |values: [f64; 6]| Grid {
            columns: 3,
            rows: 2,
            pixel: [1e-3; 2],
            origin: [-1e-3, 0.0],
            values: values.to_vec(),
        };
        let plan = grid([f64::NAN, 100e-9, 50e-9, 80e-9, 200e-9, 10e-9]);
        let found = grid([f64::NAN, 101e-9, 50e-9, 77e-9, 200e-9, 10e-9]);
        let difference = difference(&plan, &found);
        // 3 nm less on pixel (1, 0), of 200 nm at most; squares 1 + 9 over five pixels.
        assert!((difference.most + 3e-9).abs() < 1e-15 && difference.place == [-1e-3, 1e-3], "{difference:?}");
        assert!((difference.share - 0.015).abs() < 1e-9, "{difference:?}");
        assert!((difference.rms - 2f64.sqrt() * 1e-9).abs() < 1e-15, "{difference:?}");
        let problem = not_as_planned(&difference);
        assert_eq!(problem.code.as_str(), "E1301");
        assert!(problem.message.contains("3.000 nm (1.50 %"), "{}", problem.message);
    }
}
