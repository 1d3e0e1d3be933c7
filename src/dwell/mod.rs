//! Dwell: how long the tool stays where, from the measured error and the influence function.
//!
//! In: [`ToolPath`], the error map over the part, the influence function, the job's `dwell`. Out: a [`TimedPath`] with
//! the speed of every move, already rounded to what the target will write, and the predicted result.
//!
//! The unknowns are the times of the segments. [`removal`] says what they take off, [`least_squares`] finds them,
//! [`speed`] keeps them to what the arm can do, [`prediction`] says from the rounded speeds, by an operator of its own,
//! what will come of it; [`curved`] says it where the part is not flat. Model and notation: region-adaptive and full-aperture dwell with segments as unknowns, bounded
//! least squares by projected Barzilai-Borwein steps, even layer free, fixed or held.

mod curved;
mod feasibility;
pub(crate) mod field;
pub mod footprint;
pub mod least_squares;
mod outcome;
mod plan;
pub mod prediction;
pub mod removal;
mod solver;
pub mod speed;
mod start;
mod steps;
mod timed;

pub use feasibility::{SegmentTimes, check_segment_times};
pub use footprint::{Footprint, floor_depth};
pub use outcome::{Figures, Outcome, predict};
pub use plan::{Task, solve};
pub use steps::{SpeedSteps, decimals_of};
pub use timed::{Standing, TimedPath, standing, written};
