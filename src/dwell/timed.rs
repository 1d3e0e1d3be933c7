//! A path with its speeds.

use super::SpeedSteps;
use super::footprint::Footprint;
use super::removal::{Samples, Window, deposit};
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

/// Where a path comes down onto the part and leaves it, and for how long that counts, by the model of
/// [`path::landing`]; the tool moves there at a speed that can be written.
pub fn standing(path: &ToolPath, acceleration: f64, steps: SpeedSteps) -> Vec<Standing> {
    let Some(landing) = &path.landing else { return Vec::new() };
    let seconds = path::landing::standing(landing, written(landing.speed.0, steps), acceleration);
    path.stands().map(|point| Standing { point, seconds }).collect()
}

/// Depth that the standing tools remove on the pixels of a window, metres.
pub(crate) fn standing_depths(
    path: &ToolPath,
    standing: &[Standing],
    footprint: &Footprint,
    window: &Window,
) -> Vec<f64> {
    let points = &path.points;
    let (x, y): (Vec<f64>, Vec<f64>) = standing.iter().map(|s| (points.x[s.point], points.y[s.point])).unzip();
    let seconds: Vec<f64> = standing.iter().map(|s| s.seconds).collect();
    deposit(&Samples::points(&x, &y), &seconds, footprint, window)
}

/// The greatest speed up to `speed` that can be written; slower than anything that can be: the least that can.
pub fn written(speed: f64, steps: SpeedSteps) -> f64 {
    match steps.down(speed) {
        0.0 => steps.step(speed),
        down => down,
    }
}

impl TimedPath {
    /// The path with full speed everywhere, on the ways between lines on the surface what the arm reaches there, and on the
    /// way down to where it lands the landing's.
    /// The tool centre point stands `standoff` metres off the contact.
    pub(super) fn new(
        path: ToolPath,
        standing: Vec<Standing>,
        standoff: f64,
        limits: &Limits,
        steps: SpeedSteps,
    ) -> TimedPath {
        let down = |speed: f64| written(speed, steps);
        let mut speed = vec![down(limits.greatest); path.points.len()];
        for pair in path.lines.windows(2) {
            if pair[0].link == Link::OnSurface {
                // From rest to rest over the distance of two lines: half of it speeding up, half slowing down.
                let reachable = (limits.acceleration * link_length(&path, standoff, &pair[0], &pair[1])).sqrt();
                speed[pair[1].points.start] = down(limits.greatest.min(reachable));
            }
        }
        if let Some(landing) = &path.landing {
            for (i, line) in path.lines.iter().enumerate() {
                if i == 0 || path.lines[i - 1].link == Link::Lifted {
                    speed[line.points.start] = down(landing.speed.0);
                }
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

/// Length of the straight way of the tool centre point, `standoff` metres off the contact, from the end of a line to the start
/// of the next. Like that of a segment it is not the glass's: over a hollow it is shorter, and reaches less speed.
pub(super) fn link_length(path: &ToolPath, standoff: f64, line: &path::Line, next: &path::Line) -> f64 {
    let [a, b] = [line.points.end - 1, next.points.start].map(|p| path.points.off_surface(p, standoff));
    libm::hypot(libm::hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2])
}
