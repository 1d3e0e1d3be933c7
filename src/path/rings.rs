//! Concentric rings in one line.
//!
//! In: the job's `rings`. Out: one line. The rings have the radii `r_0 + (k + 1/2) p`, r_0 that of the hole (0 without one):
//! the strip of a ring is a pitch wide, and the innermost covers the centre. A pass moves all of them by its shift.
//!
//! Points are spread evenly on each ring, in the `direction` of the job the first: as many as keep them `point_step` apart,
//! and no more than 45 degrees about the centre ([`round::TURN`]). As many steps before a ring closes as make up a pitch, the
//! tool goes over to the first point of the next ring, evenly in as many steps, so that it turns by no more than about 45
//! degrees; only the last ring is closed. All rings begin in the same direction: along it the line is up to √2 as dense as elsewhere, over a
//! width of a pitch, and the solved dwell allows for it.

use super::round::{self, Ring};
use super::{Laid, Line, Link, Setting, Strategy};
use crate::diagnostics::{Problem, codes};
use crate::job::{Pass, Rings, Start};
use crate::workpiece::aperture::BOUNDARY;
use std::f64::consts::{PI, TAU};

impl Strategy for Rings {
    fields_of_lines!();

    /// # Errors
    ///
    /// E0640: a length that is not positive, or no ring at all. E0641: too many points. E0691: the area is not round.
    fn lay(&self, pass: Pass, setting: &Setting) -> Result<Laid, Problem> {
        super::positive(&[("point_step", self.point_step.0), ("line_pitch", self.line_pitch.0)])?;
        let (step, pitch) = (self.point_step.0, self.line_pitch.0);
        let ring = Ring::new(&self.over, self.hand, self.start, self.direction.0, pass)?;
        let least = TAU / round::TURN;
        let area = PI * (ring.outer * ring.outer - ring.inner * ring.inner);
        super::few_enough(
            area / pitch / step + least * ((ring.outer - ring.inner) / pitch).min(step / pitch),
            setting,
        )?;
        // The first ring that is no smaller than a quarter of a pitch: a smaller one is a point.
        let shift = pass.shift.0 + pitch / 2.0;
        let shift = shift - (shift / pitch).floor() * pitch;
        let first = if shift < pitch / 4.0 { shift + pitch } else { shift };
        let mut radii = Vec::new();
        while ring.inner + first + radii.len() as f64 * pitch <= ring.outer + BOUNDARY {
            radii.push(ring.inner + first + radii.len() as f64 * pitch);
        }
        if radii.is_empty() {
            let message = "the area of the rings holds none";
            return Err(Problem::error(codes::E0640, "path.line_pitch", message)
                .help("make `line_pitch` smaller than the area `over`"));
        }
        if self.start == Start::outside {
            radii.reverse();
        }
        // A ring is counted as the path runs outwards; inwards the same way round is backwards.
        let way = if self.start == Start::outside { -1.0 } else { 1.0 };
        let mut places = Vec::new();
        for (k, radius) in radii.iter().enumerate() {
            let count = (TAU * radius / step).ceil().max(least) as usize;
            let closed = k + 1 == radii.len();
            let over = (pitch / (TAU * radius / count as f64)).ceil() as usize;
            let over = if closed { 0 } else { over.min(count / 2) };
            places.extend((0..=count - over).map(|i| ring.place(*radius, way * TAU * i as f64 / count as f64)));
            // The last point of the way over is the next ring's first.
            let next = radii.get(k + 1).unwrap_or(radius);
            places.extend((1..over).map(|i| {
                let (t, turn) = (i as f64 / over as f64, (count - over + i) as f64 / count as f64);
                ring.place(radius + t * (next - radius), way * TAU * turn)
            }));
        }
        let lines = vec![Line { points: 0..places.len(), link: Link::Lifted }];
        Ok(Laid { places, lines, ..Laid::default() })
    }
}

#[cfg(test)]
mod tests {
    use super::super::examples::*;
    use super::*;
    use crate::job::{Annulus, Aperture, Hand, Path};
    use crate::units::si::{Angle, Length};

    fn rings(over: Aperture, step_mm: f64, pitch_mm: f64, start: Start) -> Rings {
        Rings {
            over,
            point_step: Length(step_mm * 1e-3),
            line_pitch: Length(pitch_mm * 1e-3),
            start,
            hand: Hand::counterclockwise,
            direction: Angle(0.3),
            chord_error: Length(1e-5),
            holes: None,
            landing: None,
            passes: None,
        }
    }

    fn planned(rings: &Rings) -> super::super::ToolPath {
        plan_on_plane(Path::rings(rings.clone()), 1_000_000).expect("a path")
    }

    /// Radius 5, pitch 2: rings of 1, 3 and 5 mm. Points 1 mm apart at most: 8 (by 45 degrees), 19 and 32 a ring. A pitch is 3,
    /// 3 and 3 steps (2 / 0.785, 2 / 0.992, 2 / 0.982 rounded up): 6, 17 and 33 points, and two on each way over.
    #[test]
    fn rings_are_where_they_belong() {
        let path = planned(&rings(circle(10.0), 1.0, 2.0, Start::inside));
        assert_eq!(path.points.len(), 6 + 2 + 17 + 2 + 33);
        let radius = |i: usize| libm::hypot(path.points.x[i], path.points.y[i]) * 1e3;
        for (range, wanted) in [(0..6, 1.0), (8..25, 3.0), (27..60, 5.0)] {
            assert!(range.clone().all(|i| (radius(i) - wanted).abs() < 1e-12), "{wanted}");
            // Each begins in the direction of the job, and runs from +x towards +y.
            let [x, y, _] = path.points.position(range.start);
            assert!((libm::atan2(y, x) - 0.3).abs() < 1e-12);
            let [nx, ny, _] = path.points.position(range.start + 1);
            assert!(x * ny - y * nx > 0.0);
        }
        // On the way over the radius grows evenly.
        assert!((radius(6) - 5.0 / 3.0).abs() < 1e-12 && (radius(26) - 13.0 / 3.0).abs() < 1e-12);
        // The last one is closed.
        assert!((path.points.x[59] - path.points.x[27]).abs() < 1e-15);
        let inwards = planned(&rings(circle(10.0), 1.0, 2.0, Start::outside));
        let [x, y, _] = inwards.points.position(0);
        let [nx, ny, _] = inwards.points.position(1);
        assert!((libm::hypot(x, y) - 5e-3).abs() < 1e-15 && x * ny - y * nx > 0.0);
    }

    #[test]
    fn a_shift_moves_all_rings() {
        let mut moved = rings(circle(10.0), 1.0, 2.0, Start::inside);
        moved.passes = Some(vec![Pass { turn: Angle(0.0), shift: Length(1.5e-3) }]);
        let path = planned(&moved);
        // 1 + 1.5 = 2.5 is 0.5 a pitch farther in: 0.5, 2.5, 4.5.
        // Points on the ways over have radii of their own.
        let mut radii = std::collections::BTreeMap::new();
        for i in 0..path.points.len() {
            let radius = (libm::hypot(path.points.x[i], path.points.y[i]) * 1e6).round() as i64;
            *radii.entry(radius).or_insert(0) += 1;
        }
        let radii: Vec<i64> = radii.into_iter().filter(|(_, count)| *count > 1).map(|(radius, _)| radius).collect();
        assert_eq!(radii, [500, 2500, 4500]);
    }

    #[test]
    fn every_place_lies_near_a_ring_and_nothing_crosses() {
        for (step, pitch) in [(0.5, 1.0), (2.0, 0.7)] {
            let path = planned(&rings(circle(30.0), step, pitch, Start::outside));
            assert!(!crosses(&path));
            let cut = step * 1e-3 * (1.0 - libm::cos(PI / 8.0)) / round::TURN;
            let farthest = farthest(&path, |x, y| libm::hypot(x, y) < 14e-3);
            assert!(farthest < 0.5e-3 * pitch * 1.42 + cut, "{farthest}");
        }
    }

    /// Away from the direction in which the rings begin. There the line is up to √2 as dense over a pitch.
    #[test]
    fn even_feed_removes_evenly_beside_the_seam() {
        let path = planned(&rings(circle(40.0), 0.5, 1.0, Start::outside));
        let beside = |x: f64, y: f64| {
            let (sin, cos) = libm::sincos(0.3);
            let (along, across) = (cos * x + sin * y, cos * y - sin * x);
            libm::hypot(x, y) < 13e-3 && (across.abs() > 6e-3 || along < -6e-3)
        };
        let spread = unevenness(&path, 1.5e-3, beside);
        assert!(spread < 0.01, "{spread}");
        let spread = unevenness(&path, 1.5e-3, |x, y| libm::hypot(x, y) < 13e-3);
        assert!(spread < 0.15, "{spread}");
    }

    #[test]
    fn the_hole_of_a_ring_is_left_out() {
        let ring =
            Aperture::annulus(Annulus { outer_diameter: Length(0.04), inner_diameter: Length(0.01), centre: None });
        let path = planned(&rings(ring, 0.5, 1.0, Start::inside));
        assert!((0..path.points.len()).all(|i| libm::hypot(path.points.x[i], path.points.y[i]) >= 5.5e-3 - 1e-12));
    }
}
