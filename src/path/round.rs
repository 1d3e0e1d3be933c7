//! Round paths: what a spiral and rings share.
//!
//! In: the area of the job, its hand and direction. Out: the radii that it lies between, and places by radius and angle.

use crate::diagnostics::{Problem, codes};
use crate::job::{Aperture, Hand, Pass, Start};
use std::f64::consts::PI;

/// Most that the direction from the centre turns between two points, radians: eight points a turn. The arm then cuts the
/// corners of the innermost turns by less than a thirteenth of their radius, `1 - cos 22.5°`. And the moves do not get too
/// short for a controller: a tool that starts from rest at the centre with 0.5 m/s² on a pitch of 0.5 mm takes 10 ms from
/// point to point at the very least, √(p / 2πa) · 45°, whatever its feed.
pub const TURN: f64 = PI / 4.0;

/// The ring that a round path fills.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    centre: [f64; 2],
    /// Radius of the hole, 0 without one; and of the rim, metres.
    pub inner: f64,
    pub outer: f64,
    /// Positive from +x towards +y.
    sign: f64,
    /// Where the path's mark lies (its outer end, its seam), radians.
    direction: f64,
}

impl Ring {
    /// E0691 for an area that is not round.
    pub fn new(over: &Aperture, hand: Hand, start: Start, direction: f64, pass: Pass) -> Result<Ring, Problem> {
        let (inner, outer) = match over {
            Aperture::circle(circle) => (0.0, circle.diameter.0 / 2.0),
            Aperture::annulus(annulus) => (annulus.inner_diameter.0 / 2.0, annulus.outer_diameter.0 / 2.0),
            outline => {
                let [x, y] = outline.centre();
                let mut diameter = format!("circle {{ diameter: {:.3} mm", outline.outer_radius() * 2e3);
                if x != 0.0 || y != 0.0 {
                    diameter += &format!(", centre: {{ x: {:.3} mm, y: {:.3} mm }}", x * 1e3, y * 1e3);
                }
                let message = "the area of a path that runs round a centre is neither a circle nor an annulus";
                return Err(Problem::error(codes::E0691, "path.over", message)
                    .help(format!("write `over: {diameter} }}`, or take a path that runs over any outline")));
            }
        };
        // Inwards the same way round is travelled backwards.
        let inwards = start == Start::outside;
        let sign = if (hand == Hand::counterclockwise) == inwards { -1.0 } else { 1.0 };
        Ok(Ring { centre: over.centre(), inner, outer, sign, direction: direction + pass.turn.0 })
    }

    /// The place `angle` radians beyond the mark, counted as the path runs outwards.
    pub fn place(&self, radius: f64, angle: f64) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.direction + self.sign * angle);
        [self.centre[0] + radius * cos, self.centre[1] + radius * sin]
    }
}
