//! Dwell: how long the tool stays where, from the measured error and the influence function.
//!
//! In: [`ToolPath`], the error map over the part, the influence function, the job's `dwell`. Out: a [`TimedPath`] with
//! the speed of every move, already rounded to what the target will write, and the predicted result.

use crate::path::ToolPath;

/// A path with its speeds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimedPath {
    pub path: ToolPath,
    /// Programmed speed in m/s of the straight move that ends at each point, a whole multiple of the speed step of the
    /// target. For the first point of a line: the speed of the link move that arrives there (the path's first point:
    /// the approach speed).
    pub speed: Vec<f64>,
}
