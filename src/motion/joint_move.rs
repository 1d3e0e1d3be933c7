//! Joint moves: all joints at once from one pose to another, away from the part.
//!
//! In: two joint poses. Out: the seconds it takes, or the place where the tool comes too near to the part.
//!
//! What is checked: a ball that stands for the tool (its radius is stated by the caller; it touches the tool centre
//! point and has its centre on the tool's -z axis) does not enter the column over the path, below a clearance above the
//! path's highest point. Nothing else of tool, arm or cell is known here. The joint ranges need no samples: between two
//! poses inside them every joint stays inside.

use super::arm::Joints;
use super::cell::Station;
use super::frames::{Transform, between};
use crate::path::Points;

/// Between two samples no joint moves more: at the end of a 3 m arm a quarter of a degree is 13 mm, and the way between
/// two samples bows by 0.01 mm.
const SAMPLE: f64 = 0.25 * std::f64::consts::PI / 180.0;

/// The column reaches this far beyond the ball around the path's points, metres: what the tool moves between two
/// samples.
const BETWEEN_SAMPLES: f64 = 0.015;

/// The part of the travel height that stays clear of the path's highest point. Joint moves start and end lifted by
/// the whole height and bow; half of what the job calls a safe height is let to bow.
const CLEAR_SHARE: f64 = 0.5;

/// What joint moves keep away from, in the object frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Column {
    lower: [f64; 2],
    upper: [f64; 2],
    /// The least height of the ball's lowest point over the column.
    floor: f64,
    /// The path's highest point.
    top: f64,
    radius: f64,
}

/// Where a joint move came too near: the tool centre point in the object frame, the ball's height above the path's
/// highest point and the least height allowed, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TooNear {
    pub point: [f64; 3],
    pub height: f64,
    pub least: f64,
}

impl Column {
    /// The column over a path and the part (its box, lower left and upper right corner); `radius` is the ball's, `height`
    /// the travel height.
    pub fn new(points: &Points, part: [[f64; 2]; 2], radius: f64, height: f64) -> Column {
        let least = |values: &[f64]| values.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        let most = |values: &[f64]| values.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        let (grow, top) = (radius + BETWEEN_SAMPLES, most(&points.z));
        Column {
            lower: [least(&points.x).min(part[0][0]) - grow, least(&points.y).min(part[0][1]) - grow],
            upper: [most(&points.x).max(part[1][0]) + grow, most(&points.y).max(part[1][1]) + grow],
            floor: top + CLEAR_SHARE * height,
            top,
            radius,
        }
    }

    fn check(&self, tool: &Transform) -> Result<(), TooNear> {
        let point = tool.translation.vector;
        let centre = point - tool.rotation * nalgebra::Vector3::new(0.0, 0.0, self.radius);
        let beside = (0..2).any(|i| centre[i] < self.lower[i] || centre[i] > self.upper[i]);
        let lowest = centre.z - self.radius;
        // Written so that a height that is no number is refused.
        if beside || lowest >= self.floor {
            return Ok(());
        }
        Err(TooNear { point: [point.x, point.y, point.z], height: lowest - self.top, least: self.floor - self.top })
    }
}

/// Seconds of the joint move between two poses at the station's part of the rated joint speeds.
pub(super) fn seconds(station: &Station, from: &Joints, to: &Joints) -> f64 {
    (0..6).map(|i| (to[i] - from[i]).abs() / (station.arm.speeds[i] * station.joint_move_speed)).fold(0.0, f64::max)
}

/// Checks a straight lifted move, sampled every 5 mm.
pub(super) fn check_straight(column: &Column, from: &Transform, to: &Transform) -> Result<(), TooNear> {
    let samples = ((to.translation.vector - from.translation.vector).norm() / 5e-3).ceil().max(1.0);
    (0..=samples as usize).try_for_each(|sample| column.check(&between(from, to, sample as f64 / samples)))
}

/// Checks a joint move.
pub(super) fn check(station: &Station, column: &Column, from: &Joints, to: &Joints) -> Result<(), TooNear> {
    let largest = (0..6).map(|i| (to[i] - from[i]).abs()).fold(0.0, f64::max);
    let samples = (largest / SAMPLE).ceil().max(1.0);
    for sample in 0..=samples as usize {
        let share = sample as f64 / samples;
        let mut joints = [0.0; 6];
        for i in 0..6 {
            joints[i] = from[i] + (to[i] - from[i]) * share;
        }
        column.check(&station.frames.tool(&station.arm.forward(&joints)))?;
    }
    Ok(())
}
