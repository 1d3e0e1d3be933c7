//! Joint moves: all joints at once from one pose to another, away from the part.
//!
//! In: two joint poses. Out: the seconds it takes, or the place where the tool comes too near to the part.
//!
//! What is checked: the ball that stands for the tool ([`Ball`]) stays out of the glass, which is taken for solid below its surface over
//! path and part, all the way down, and out of half the travel height above it. Nothing else of tool, arm or cell is known here. The joint ranges need
//! no samples: between two poses inside them every joint stays inside.

use super::arm::Joints;
use super::cell::Station;
use super::frames::{Transform, between};
use crate::path::Points;
use crate::tool::Ball;

/// Between two samples no joint moves more: at the end of a 3 m arm a quarter of a degree is 13 mm, and the way between
/// two samples bows by 0.01 mm.
const SAMPLE: f64 = 0.25 * std::f64::consts::PI / 180.0;

/// The glass reaches this far sideways beyond its cells, metres: what the tool moves between two samples.
const BETWEEN_SAMPLES: f64 = 0.015;

/// The part of the travel height that stays clear. Joint moves start and end lifted by the whole height and bow; half of
/// what the job calls a safe height is let to bow.
const CLEAR_SHARE: f64 = 0.5;

/// Cells along each side of the glass at most: on a part of 400 mm that is a cell of 6 mm, less than the tool moves
/// between two samples.
const MOST_CELLS: usize = 64;

/// Points of the path that a cell must be able to hold on average, so that few cells hold none.
const POINTS_IN_CELL: usize = 8;

/// The glass that joint moves keep away from, in the object frame: upright columns over the cells of a box around path
/// and part, each as high as the path's highest point in it. So the rim of a hollow part stands out, and its middle does
/// not.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Glass {
    lower: [f64; 2],
    cell: [f64; 2],
    cells: [usize; 2],
    /// The highest point of each cell, row by row from the lower left.
    tops: Vec<f64>,
    /// The path's highest point.
    top: f64,
    /// How high over the glass the ball must stay.
    least: f64,
    ball: Ball,
}

/// Where a joint move came too near: the tool centre point in the object frame, the ball's distance from the glass
/// (negative inside it) and the least height over it that is allowed, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TooNear {
    pub point: [f64; 3],
    pub distance: f64,
    pub least: f64,
}

impl Glass {
    /// Under a path and the part (its box, lower left and upper right corner); `height` is the travel height.
    pub fn new(points: &Points, part: [[f64; 2]; 2], ball: Ball, height: f64) -> Glass {
        let least = |values: &[f64]| values.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        let most = |values: &[f64]| values.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        let lower = [least(&points.x).min(part[0][0]), least(&points.y).min(part[0][1])];
        let upper = [most(&points.x).max(part[1][0]), most(&points.y).max(part[1][1])];
        // As many cells as the path fills.
        let count = (((points.len() / POINTS_IN_CELL) as f64).sqrt() as usize).clamp(1, MOST_CELLS);
        let cells = [count; 2];
        let cell = [0, 1].map(|i| (upper[i] - lower[i]) / count as f64);
        let mut tops = vec![f64::NEG_INFINITY; count * count];
        let at = |i: usize, value: f64| {
            let place = if cell[i] > 0.0 { (value - lower[i]) / cell[i] } else { 0.0 };
            (place as usize).min(count - 1)
        };
        for i in 0..points.len() {
            let top = &mut tops[at(1, points.y[i]) * count + at(0, points.x[i])];
            *top = top.max(points.z[i]);
        }
        spread(&mut tops, count);
        Glass { lower, cell, cells, tops, top: most(&points.z), least: CLEAR_SHARE * height, ball }
    }

    fn check(&self, tool: &Transform) -> Result<(), TooNear> {
        let point = tool.translation.vector;
        let Ball { radius, below } = self.ball;
        let centre = point - tool.rotation * nalgebra::Vector3::new(0.0, 0.0, radius - below);
        if !(point.iter().all(|x| x.is_finite()) && centre.iter().all(|x| x.is_finite())) {
            return Err(TooNear { point: [point.x, point.y, point.z], distance: -radius, least: self.least });
        }
        // Above everything, which is nearly always so.
        if centre.z - radius >= self.top + self.least {
            return Ok(());
        }
        let centre = [centre.x, centre.y, centre.z];
        if self.distance(centre, self.least) >= radius {
            return Ok(());
        }
        let distance = self.distance(centre, 0.0) - radius;
        Err(TooNear { point: [point.x, point.y, point.z], distance, least: self.least })
    }

    /// Distance of a point from the nearest column, all of them raised by `raised`, metres; inside of one, the negative
    /// depth below its top.
    fn distance(&self, p: [f64; 3], raised: f64) -> f64 {
        let mut nearest = f64::INFINITY;
        for (i, top) in self.tops.iter().enumerate() {
            let place = [i % self.cells[0], i / self.cells[0]];
            let beside = [0, 1].map(|k| {
                let from = self.lower[k] + place[k] as f64 * self.cell[k] - BETWEEN_SAMPLES;
                let to = from + self.cell[k] + 2.0 * BETWEEN_SAMPLES;
                (from - p[k]).max(p[k] - to).max(0.0)
            });
            let above = p[2] - top - raised;
            let flat = libm::hypot(beside[0], beside[1]);
            let distance = if flat > 0.0 || above >= 0.0 { libm::hypot(flat, above.max(0.0)) } else { above };
            nearest = nearest.min(distance);
        }
        nearest
    }
}

/// Gives a cell that holds no point the highest top around it, from the filled ones outwards.
fn spread(tops: &mut [f64], count: usize) {
    while tops.contains(&f64::NEG_INFINITY) && tops.iter().any(|top| *top > f64::NEG_INFINITY) {
        let before = tops.to_vec();
        for (i, top) in tops.iter_mut().enumerate().filter(|(_, top)| **top == f64::NEG_INFINITY) {
            let (row, column) = (i / count, i % count);
            for r in row.saturating_sub(1)..(row + 2).min(count) {
                for c in column.saturating_sub(1)..(column + 2).min(count) {
                    *top = top.max(before[r * count + c]);
                }
            }
        }
    }
}

/// Seconds of the joint move between two poses at the station's part of the rated joint speeds.
pub(super) fn seconds(station: &Station, from: &Joints, to: &Joints) -> f64 {
    (0..6).map(|i| (to[i] - from[i]).abs() / (station.arm.speeds[i] * station.joint_move_speed)).fold(0.0, f64::max)
}

/// Checks a straight lifted move, sampled every 5 mm.
pub(super) fn check_straight(glass: &Glass, from: &Transform, to: &Transform) -> Result<(), TooNear> {
    let samples = ((to.translation.vector - from.translation.vector).norm() / 5e-3).ceil().max(1.0);
    (0..=samples as usize).try_for_each(|sample| glass.check(&between(from, to, sample as f64 / samples)))
}

/// Checks a joint move.
pub(super) fn check(station: &Station, glass: &Glass, from: &Joints, to: &Joints) -> Result<(), TooNear> {
    let largest = (0..6).map(|i| (to[i] - from[i]).abs()).fold(0.0, f64::max);
    let samples = (largest / SAMPLE).ceil().max(1.0);
    for sample in 0..=samples as usize {
        let share = sample as f64 / samples;
        let mut joints = [0.0; 6];
        for i in 0..6 {
            joints[i] = from[i] + (to[i] - from[i]) * share;
        }
        glass.check(&station.frames.tool(&station.arm.forward(&joints)))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion, Vector3};

    /// A bowl of 100 mm radius, 60 mm from the axis: its rim stands 20 mm high.
    fn bowl() -> Points {
        let mut points = Points::default();
        for row in -60..=60 {
            for column in -60..=60 {
                let (x, y) = (f64::from(column) * 1e-3, f64::from(row) * 1e-3);
                if x * x + y * y <= 3.6e-3 {
                    let z = 0.1 - (0.01 - x * x - y * y).sqrt();
                    points.push([x, y, z], [-x / 0.1, -y / 0.1, (0.1 - z) / 0.1]);
                }
            }
        }
        points
    }

    /// A tool `height` over the contact at (x, 0), turned along the normal there.
    fn stands(x: f64, height: f64) -> Transform {
        let z = 0.1 - (0.01 - x * x).sqrt();
        let normal = Vector3::new(-x / 0.1, 0.0, (0.1 - z) / 0.1);
        let over = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal).expect("not opposite") * over;
        let at = Vector3::new(x, 0.0, z) + height * normal;
        Transform::from_parts(Translation3::new(at.x, at.y, at.z), turn)
    }

    #[test]
    fn the_rim_decides_and_not_the_highest_point() {
        // A ball of 30 mm, 40 mm to travel, 20 mm to keep.
        let glass = Glass::new(&bowl(), [[-0.06; 2], [0.06; 2]], Ball { radius: 0.03, below: 0.0 }, 0.04);
        // Lifted by 40 mm over the rim the ball leans inwards, its lowest point 34 mm over the rim's height, and no nearer
        // to the glass.
        for x in [0.06, 0.05, -0.06] {
            assert!(glass.check(&stands(x, 0.04)).is_ok(), "{x}");
        }
        // 10 mm over the rim, or 5 mm over the middle: too near, and inside.
        for (x, height) in [(0.06, 0.01), (0.0, 0.005), (0.03, -0.01)] {
            let near = glass.check(&stands(x, height)).expect_err("too near");
            assert!(near.distance < near.least && (near.least - 0.02).abs() < 1e-15, "{near:?}");
        }
        // Beside the rim and below it: the wall and what the tool moves between two samples stand 75 mm from the axis.
        let beside = |x: f64| Transform::from_parts(Translation3::new(x, 0.0, -0.1), UnitQuaternion::identity());
        assert!(glass.check(&beside(0.104)).is_err() && glass.check(&beside(0.106)).is_ok());
    }

    #[test]
    fn a_number_that_is_none_is_refused() {
        let glass = Glass::new(&bowl(), [[-0.06; 2], [0.06; 2]], Ball { radius: 0.03, below: 0.0 }, 0.04);
        let nowhere = Transform::from_parts(Translation3::new(0.0, 0.0, f64::NAN), UnitQuaternion::identity());
        assert!(glass.check(&nowhere).is_err());
    }

    #[test]
    fn cells_without_points_take_the_height_of_their_neighbours() {
        let mut tops = vec![f64::NEG_INFINITY; 9];
        tops[0] = 1.0;
        tops[1] = 2.0;
        spread(&mut tops, 3);
        assert_eq!(tops, [1.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0]);
    }
}
