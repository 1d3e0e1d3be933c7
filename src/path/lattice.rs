//! Paths from square to square: what Hilbert's curve and the pseudo-random path share.
//!
//! In: the job's grid, and the squares of a line in travel order, each beside the one before. Out: the line's points: straight
//! through the middles of the squares, corners rounded.
//!
//! A line enters and leaves a square in the middle of a side. Where it turns inside, it does so on a quarter of a circle of
//! half a pitch in radius, which meets the sides at right angles: so direction never jumps. Two lines through neighbouring
//! squares are a pitch apart where they run straight, and nowhere nearer than p/√2.

use super::Setting;
use crate::diagnostics::{Problem, codes};
use crate::job::{Aperture, Pass};
use std::f64::consts::PI;

/// Most that a line turns in a point, radians. A controller rounds a corner of 45 degrees inside its zone by a tenth of the
/// zone's size; and lateral acceleration is spread over several points of a corner.
const TURN: f64 = PI / 4.0;

/// A square, counted from the middle of the area: its own middle lies at `(column + 1/2, row + 1/2)` pitches.
pub type Square = [i64; 2];

/// The grid of squares on the part.
#[derive(Clone, Copy, Debug)]
pub struct Lattice {
    centre: [f64; 2],
    along: [f64; 2],
    pitch: f64,
    shift: f64,
}

impl Lattice {
    /// About the middle of `over`, turned by the job's direction and the pass's turn, moved by the pass's shift along both
    /// of its axes.
    ///
    /// # Errors
    ///
    /// E0640: a length that is not positive. E0692: points too far apart for the corners.
    pub fn new(over: &Aperture, (step, pitch): (f64, f64), direction: f64, pass: Pass) -> Result<Lattice, Problem> {
        super::positive(&[("point_step", step), ("line_pitch", pitch)])?;
        // A chord of a circle of half a pitch turns by its length over the radius.
        let most = TURN * pitch / 2.0;
        if step > most {
            let message = format!(
                "points {:.3} mm apart turn by more than 45 deg in the corners of a path with a pitch of {:.3} mm",
                step * 1e3,
                pitch * 1e3
            );
            return Err(Problem::error(codes::E0692, "path.point_step", message)
                .help(format!("make `point_step` at most {:.3} mm", (most * 1e6).floor() / 1e3)));
        }
        let (sin, cos) = libm::sincos(direction + pass.turn.0);
        Ok(Lattice { centre: over.centre(), along: [cos, sin], pitch, shift: pass.shift.0 })
    }

    /// A place by its coordinates in pitches.
    pub fn place(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [cos, sin] = self.along;
        let (u, v) = (u * self.pitch + self.shift, v * self.pitch + self.shift);
        [self.centre[0] + cos * u - sin * v, self.centre[1] + sin * u + cos * v]
    }

    /// First and last coordinate, in whole pitches, of the box around `over` along each axis of the grid.
    pub fn range(&self, over: &Aperture) -> [[f64; 2]; 2] {
        let [cos, sin] = self.along;
        [[cos, sin], [-sin, cos]].map(|axis| {
            let [low, high] = over.extent(axis);
            [((low - self.shift) / self.pitch).floor(), ((high - self.shift) / self.pitch).ceil()]
        })
    }

    /// The middle of a square.
    pub fn middle(&self, square: Square) -> [f64; 2] {
        self.place(square.map(|k| k as f64 + 0.5))
    }

    /// The lines of points through lines of squares, no two points farther apart than `step` along the way.
    ///
    /// # Errors
    ///
    /// E0641: more points than there may be.
    pub fn trace(&self, lines: &[Vec<Square>], step: f64, setting: &Setting) -> Result<Vec<Vec<[f64; 2]>>, Problem> {
        let segments = |line: &Vec<Square>| (length(line) * self.pitch / step).ceil().max(1.0);
        super::few_enough(lines.iter().map(|line| segments(line) + 1.0).sum(), setting)?;
        Ok(lines.iter().map(|line| self.points(line, segments(line) as usize)).collect())
    }

    fn points(&self, line: &[Square], segments: usize) -> Vec<[f64; 2]> {
        let whole = length(line);
        let mut points = Vec::with_capacity(segments + 1);
        let (mut piece, mut start) = (0, 0.0);
        for i in 0..=segments {
            let at = whole * i as f64 / segments as f64;
            while piece + 1 < line.len() && at > start + piece_length(line, piece) {
                start += piece_length(line, piece);
                piece += 1;
            }
            points.push(self.place(along(line, piece, at - start)));
        }
        points
    }
}

/// The directions in which a line enters and leaves a square, none at its ends.
fn ways(line: &[Square], piece: usize) -> (Option<Square>, Option<Square>) {
    let way = |a: Square, b: Square| [b[0] - a[0], b[1] - a[1]];
    (
        piece.checked_sub(1).map(|before| way(line[before], line[piece])),
        line.get(piece + 1).map(|next| way(line[piece], *next)),
    )
}

/// Length of the way through a square, in pitches.
fn piece_length(line: &[Square], piece: usize) -> f64 {
    match ways(line, piece) {
        (Some(entered), Some(left)) if entered == left => 1.0,
        (Some(_), Some(_)) => PI / 4.0,
        _ => 0.5,
    }
}

fn length(line: &[Square]) -> f64 {
    (0..line.len()).map(|piece| piece_length(line, piece)).sum()
}

/// The place `at` pitches after the line has entered a square.
fn along(line: &[Square], piece: usize, at: f64) -> [f64; 2] {
    let middle = line[piece].map(|k| k as f64 + 0.5);
    let (entered, left) = ways(line, piece);
    let go = |from: [f64; 2], way: Square, far: f64| [from[0] + way[0] as f64 * far, from[1] + way[1] as f64 * far];
    match (entered, left) {
        (Some(entered), Some(left)) if entered != left => {
            let (sin, cos) = libm::sincos(2.0 * at);
            go(go(middle, entered, 0.5 * sin - 0.5), left, 0.5 - 0.5 * cos)
        }
        (Some(entered), _) => go(middle, entered, at - 0.5),
        (None, Some(left)) => go(middle, left, at),
        (None, None) => middle,
    }
}

#[cfg(test)]
mod tests {
    use super::super::examples::*;
    use super::*;
    use crate::units::si::{Angle, Length};

    #[test]
    fn corners_are_quarter_circles() {
        // Right, right, up: half a pitch, one, a quarter circle, half... the last square is only entered.
        let line = [[0, 0], [1, 0], [2, 0], [2, 1]];
        assert!((length(&line) - (0.5 + 1.0 + PI / 4.0 + 0.5)).abs() < 1e-15);
        assert_eq!(along(&line, 0, 0.25), [0.75, 0.5]);
        assert_eq!(along(&line, 1, 0.0), [1.0, 0.5]);
        // Half way round the corner about (2, 1).
        let [x, y] = along(&line, 2, PI / 8.0);
        let half = 0.5 * libm::sin(PI / 4.0);
        assert!((x - (2.0 + half)).abs() < 1e-15 && (y - (1.0 - half)).abs() < 1e-15, "{x} {y}");
        let [x, y] = along(&line, 3, 0.5);
        assert!((x - 2.5).abs() < 1e-15 && (y - 1.5).abs() < 1e-15);
    }

    #[test]
    fn the_grid_is_turned_and_moved() {
        let pass = Pass { turn: Angle(PI / 4.0), shift: Length(1e-3) };
        let lattice = Lattice::new(&circle(20.0), (0.5e-3, 2e-3), PI / 4.0, pass).expect("a grid");
        // Turned by 90 degrees: u runs along y. The middle of the square (0, 1) lies at u = 1 + 1, v = 3 + 1.
        let [x, y] = lattice.middle([0, 1]);
        assert!((x + 4e-3).abs() < 1e-15 && (y - 2e-3).abs() < 1e-15);
        assert_eq!(lattice.range(&circle(20.0)), [[-6.0, 5.0]; 2]);
        let problem = Lattice::new(&circle(20.0), (0.8e-3, 2e-3), 0.0, pass).expect_err("45 degrees are 0.785 mm");
        assert_eq!((problem.code, problem.help.as_deref()), (codes::E0692, Some("make `point_step` at most 0.785 mm")));
    }
}
