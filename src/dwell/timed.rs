//! A path with its speeds.

use super::SpeedSteps;
use super::speed::{Limits, Segments};
use crate::path::{self, Link, ToolPath};

/// A path with its speeds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimedPath {
    pub path: ToolPath,
    /// Programmed speed in m/s of the straight move that ends at each point, one that the target can write exactly. For
    /// the first point of a line: the speed of the link move that arrives there (the path's first point: the approach speed).
    pub speed: Vec<f64>,
    /// Where the tool stands on the glass beside its way along the lines.
    pub standing: Vec<Standing>,
}

/// The tool stands at a point of the path, the process on: a landing or a lift, told as the time of a standing tool that
/// would remove as much.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    pub point: usize,
    pub seconds: f64,
}

impl TimedPath {
    /// The path with full speed everywhere, and on the ways between lines on the surface what the arm reaches there.
    pub(super) fn new(path: ToolPath, standing: Vec<Standing>, limits: &Limits, steps: SpeedSteps) -> TimedPath {
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
        TimedPath { path, speed, standing }
    }

    /// Puts the speeds of the segments on the points that end them.
    pub(super) fn set_speeds(&mut self, segments: &Segments, speeds: &[f64]) {
        for (&point, &value) in segments.point.iter().zip(speeds) {
            self.speed[point] = value;
        }
    }
}

/// Length of the straight way from the end of a line to the start of the next.
pub(super) fn link_length(path: &ToolPath, line: &path::Line, next: &path::Line) -> f64 {
    let [a, b] = [line.points.end - 1, next.points.start].map(|p| path.points.position(p));
    libm::hypot(libm::hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2])
}
