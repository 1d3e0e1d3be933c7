//! Dwell: how long the tool stays where, from the measured error and the influence function.
//!
//! In: `ToolPath`, the error map over the part, the influence function, the job's `dwell`. Out: a [`TimedPath`] with
//! the speed of every move, already rounded to what the target will write, and the predicted result.
//!
//! The unknowns are the times of the segments. [`removal`] says what they take off; [`descent`] brings that nearest to what
//! is wanted by an [`objective`], with times between [`bounds`] or, where that asks too much of the arm, with speeds that it can
//! [follow](followable). [`speed`] says what it can do; [`prediction`] says from the rounded speeds, by an operator of its own, what
//! will come of it, [`curved`] where the part is not flat.

pub mod bounds;
mod chain;
mod curved;
pub mod descent;
mod feasibility;
pub(crate) mod field;
pub mod followable;
pub mod footprint;
pub mod largest;
pub mod objective;
mod outcome;
mod pareto;
mod plan;
pub mod prediction;
mod price;
mod quasi_newton;
pub mod removal;
mod ripple;
pub mod solver;
pub mod speed;
mod start;
mod steps;
mod timed;
mod vectors;

pub(crate) use curved::cosines;
pub use feasibility::{SegmentTimes, check_segment_times};
pub use footprint::{Footprint, floor_depth};
pub use outcome::{Figures, Outcome, predict};
pub use pareto::{Choice, pareto};
pub use plan::{Task, solve};
pub use ripple::{Ripple, ripple};
pub use steps::{SpeedSteps, decimals_of};
pub(crate) use timed::standing_depths;
pub use timed::{Standing, TimedPath, standing, written};
