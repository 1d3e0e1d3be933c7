//! Archimedes' spiral.
//!
//! In: the job's `spiral`. Out: one line. With r the distance from the centre, r_0 the radius of the hole (0 without one), R
//! that of the rim and p the pitch:
//!
//! ```text
//! r = r_0 + pθ/2π        θ from 0 to Θ = 2π (R - r_0)/p        the rim is met in the `direction` of the job
//! ```
//!
//! Points lie `point_step` apart along the spiral, counted from the rim; nearer to one another where that would be more than
//! 45 degrees about the centre ([`round::TURN`]). The last step, at the centre or the hole, is what is left.
//!
//! A strip as wide as the pitch covers every place once, the centre included: at constant feed a spiral removes evenly, but for the
//! way outwards that is part of every turn, which shows at the centre: 2 % for a Gaussian of 1.5 pitches. A pass moved by a part of the pitch is a pass turned by that part of a turn.

use super::round::{self, Ring};
use super::{Laid, Line, Link, Setting, Strategy};
use crate::diagnostics::Problem;
use crate::job::{Pass, Spiral, Start};
use std::f64::consts::{PI, TAU};

impl Strategy for Spiral {
    fields_of_lines!();

    /// # Errors
    ///
    /// E0640: a length that is not positive. E0641: too many points. E0691: the area is not round.
    fn lay(&self, pass: Pass, setting: &Setting) -> Result<Laid, Problem> {
        super::positive(&[("point_step", self.point_step.0), ("line_pitch", self.line_pitch.0)])?;
        let (step, pitch) = (self.point_step.0, self.line_pitch.0);
        let shift = TAU * pass.shift.0 / pitch;
        let ring = Ring::new(&self.over, self.hand, self.start, self.direction.0 + shift, pass)?;
        let width = ring.outer - ring.inner;
        // The length is that of all turns; around the centre a few points more.
        let length = PI * (ring.outer * ring.outer - ring.inner * ring.inner) / pitch;
        super::few_enough(length / step + TAU / round::TURN * (width / pitch).min(step / pitch), setting)?;
        let last = TAU * width / pitch;
        // Distance from the centre, and length of the way for a radian.
        let radius = |angle: f64| ring.inner + pitch * angle / TAU;
        let slowness = |angle: f64| libm::hypot(radius(angle), pitch / TAU);
        let mut places = Vec::new();
        let mut angle = last;
        while angle > 0.0 {
            places.push(ring.place(radius(angle), angle - last));
            // At the middle of the step, which ends a step further in.
            let middle = angle - 0.5 * (step / slowness(angle)).min(round::TURN);
            let next = (step / slowness(middle.max(0.0))).min(round::TURN);
            // What is left goes into the last step, up to half a step more.
            angle = if angle > 1.5 * next { angle - next } else { 0.0 };
        }
        places.push(ring.place(radius(0.0), -last));
        if self.start == Start::inside {
            places.reverse();
        }
        let lines = vec![Line { points: 0..places.len(), link: Link::Lifted }];
        Ok(Laid { places, lines, ..Laid::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::super::examples::*;
    use super::*;
    use crate::diagnostics::codes;
    use crate::job::{Annulus, Aperture, Hand, Path, Rectangle};
    use crate::units::si::{Angle, Length};

    fn spiral(over: Aperture, step_mm: f64, pitch_mm: f64, start: Start, hand: Hand) -> Spiral {
        Spiral {
            over,
            point_step: Length(step_mm * 1e-3),
            line_pitch: Length(pitch_mm * 1e-3),
            start,
            hand,
            direction: Angle(0.5),
            chord_error: Length(1e-5),
            holes: None,
            landing: None,
            passes: None,
        }
    }

    fn planned(spiral: &Spiral) -> super::super::ToolPath {
        plan_on_plane(Path::spiral(spiral.clone()), 1_000_000).expect("a path")
    }

    #[test]
    fn every_point_lies_on_the_spiral() {
        // 20 mm radius, pitch 1.5: 13 1/3 turns. Clockwise from outside: seen outwards the angle grows with +x towards +y.
        let path = planned(&spiral(circle(40.0), 1.0, 1.5, Start::outside, Hand::clockwise));
        let n = path.points.len();
        assert_eq!(path.lines.len(), 1);
        let place = |i: usize| [path.points.x[i], path.points.y[i]];
        let [x, y] = place(0);
        assert!((x - 0.02 * libm::cos(0.5)).abs() < 1e-15 && (y - 0.02 * libm::sin(0.5)).abs() < 1e-15);
        assert!(libm::hypot(place(n - 1)[0], place(n - 1)[1]) < 1e-15);
        let mut turned = 0.0;
        for i in 1..n {
            let ([ax, ay], [bx, by]) = (place(i - 1), place(i));
            if i + 1 < n {
                turned += libm::atan2(ax * by - ay * bx, ax * bx + ay * by);
                let r = 0.02 + 1.5e-3 * turned / TAU;
                assert!((libm::hypot(bx, by) - r).abs() < 1e-12, "{i}");
            }
            let chord = libm::hypot(bx - ax, by - ay);
            assert!(chord <= 1.5e-3 && (chord > 0.9e-3 || r_of(ax, ay) < 1.6e-3), "{i}: {chord}");
        }
        // Clockwise seen from the tool: the angle falls.
        assert!(turned < -13.0 * TAU);
    }

    fn r_of(x: f64, y: f64) -> f64 {
        libm::hypot(x, y)
    }

    #[test]
    fn inside_out_is_the_other_hand_backwards() {
        let a = planned(&spiral(circle(30.0), 0.8, 1.0, Start::outside, Hand::clockwise));
        let b = planned(&spiral(circle(30.0), 0.8, 1.0, Start::inside, Hand::counterclockwise));
        let n = a.points.len();
        assert_eq!(b.points.len(), n);
        assert!((0..n).all(|i| a.points.position(i) == b.points.position(n - 1 - i)));
    }

    #[test]
    fn every_place_lies_half_a_pitch_from_the_line_and_the_line_does_not_cross_itself() {
        for (step, pitch) in [(0.5, 1.0), (2.0, 0.7)] {
            let path = planned(&spiral(circle(30.0), step, pitch, Start::outside, Hand::counterclockwise));
            assert!(!crosses(&path));
            // Half a pitch, and what chords cut off: s²/8r, at most r (1 - cos 22.5°) with r < s / 45°.
            let cut = step * 1e-3 * (1.0 - libm::cos(PI / 8.0)) / round::TURN;
            let farthest = farthest(&path, |x, y| libm::hypot(x, y) < 14.5e-3);
            assert!(farthest < 0.5e-3 * pitch + cut, "{farthest}");
        }
    }

    #[test]
    fn even_feed_removes_evenly() {
        let path = planned(&spiral(circle(40.0), 0.5, 1.0, Start::outside, Hand::counterclockwise));
        // The spiral is longer than its turns, by the integral of (√(1 + θ²) - θ) p/2π, weighed by the Gaussian: 0.27 mm at the
        // centre, of the 2πσ²/p = 14.1 mm that all turns come to.
        let spread = unevenness(&path, 1.5e-3, |x, y| libm::hypot(x, y) < 13e-3);
        assert!(spread < 0.022, "{spread}");
        let spread = unevenness(&path, 1.5e-3, |x, y| (6e-3..13e-3).contains(&libm::hypot(x, y)));
        assert!(spread < 0.002, "{spread}");
    }

    #[test]
    fn a_ring_is_left_at_its_hole() {
        let ring =
            Aperture::annulus(Annulus { outer_diameter: Length(0.04), inner_diameter: Length(0.01), centre: None });
        let path = planned(&spiral(ring, 0.5, 1.0, Start::inside, Hand::counterclockwise));
        let [x, y, _] = path.points.position(0);
        assert!((r_of(x, y) - 5e-3).abs() < 1e-15);
        assert!((0..path.points.len()).all(|i| r_of(path.points.x[i], path.points.y[i]) >= 5e-3 - 1e-12));
    }

    #[test]
    fn what_is_no_spiral_is_refused() {
        let code = |spiral: &Spiral, most: u64| plan_on_plane(Path::spiral(spiral.clone()), most).unwrap_err().code;
        let square = Aperture::rectangle(Rectangle { x: Length(0.02), y: Length(0.02), centre: None });
        let good = |over| spiral(over, 0.5, 1.0, Start::outside, Hand::clockwise);
        assert_eq!(code(&good(square), 1000), codes::E0691);
        assert_eq!(code(&good(circle(400.0)), 1000), codes::E0641);
        assert_eq!(code(&Spiral { point_step: Length(0.0), ..good(circle(40.0)) }, 1000), codes::E0640);
        assert_eq!(code(&Spiral { line_pitch: Length(1e-300), ..good(circle(40.0)) }, 1000), codes::E0641);
    }
}
