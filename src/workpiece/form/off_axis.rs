//! Off-axis segment: a piece of a rotationally symmetric parent beside its axis.
//!
//! The part's origin lies on the parent at `distance` from its axis, its z axis along the parent's outward normal there.
//! Let a be the tangent in the meridian plane that points away from the parent's axis and b = z cross a; on the part, a
//! points along `direction`. The sag is the root w of `P_z(w) = z_parent(P_x(w), P_y(w))` on the line P(w) along the part's
//! z axis, by Newton's method; its derivatives are those of the implicit function.

use super::asphere::Asphere;
use super::{Surface, SurfacePoint, finite, positive};
use crate::diagnostics::{Problem, codes};
use crate::job::OffAxis;

#[derive(Debug)]
pub struct Segment {
    parent: Asphere,
    /// The part's origin in the parent frame, metres.
    origin: [f64; 3],
    /// The part's axes in the parent frame.
    x: [f64; 3],
    y: [f64; 3],
    z: [f64; 3],
}

/// Newton's method doubles its digits with every step: from a millimetre to rounding takes four. Where it takes many
/// more it does not converge.
const MOST_STEPS: usize = 50;

/// Least cosine between the part's z axis and the parent's normal: beyond 84 degrees no tool looks at the surface along
/// z, and the sag is no longer fixed by its place.
const LEAST_COSINE: f64 = 0.1;

impl Segment {
    pub fn new(job: &OffAxis) -> Result<Segment, Problem> {
        let parent = Asphere::new(&job.parent).map_err(|problem| problem.within("parent"))?;
        let distance = positive("distance", job.distance.0)?;
        let direction = finite("direction", job.direction.0)?;
        let Some(point) = parent.at(distance, 0.0) else {
            let message = format!("the parent does not reach {:.3} mm from its axis", distance * 1e3);
            return Err(Problem::error(codes::E0602, "distance", message)
                .help("check `distance`, and `radius` and `conic` of the parent"));
        };
        // The meridian lies in the parent's xz plane.
        let [nx, _, nz] = point.normal();
        let (away, across) = ([nz, 0.0, -nx], [0.0, 1.0, 0.0]);
        // On the part, `away` points along `direction`: it is cos x + sin y, and `across` is -sin x + cos y.
        let (sin, cos) = libm::sincos(direction);
        let mix = |a: f64, b: f64| [0, 1, 2].map(|i| a * away[i] + b * across[i]);
        Ok(Segment {
            parent,
            origin: [distance, 0.0, point.sag],
            x: mix(cos, -sin),
            y: mix(sin, cos),
            z: [nx, 0.0, nz],
        })
    }
}

impl Surface for Segment {
    fn at(&self, x: f64, y: f64) -> Option<SurfacePoint> {
        let foot = [0, 1, 2].map(|i| self.origin[i] + x * self.x[i] + y * self.y[i]);
        let mut w = 0.0;
        for _ in 0..MOST_STEPS {
            let place = [0, 1, 2].map(|i| foot[i] + w * self.z[i]);
            let parent = self.parent.at(place[0], place[1])?;
            let along = |d: [f64; 3]| d[2] - parent.slope[0] * d[0] - parent.slope[1] * d[1];
            let rate = along(self.z);
            // The rate over the length of the normal is the cosine between z and normal.
            let [_, _, normal_z] = parent.normal();
            if !(rate * normal_z >= LEAST_COSINE) {
                return None;
            }
            let step = (place[2] - parent.sag) / rate;
            w -= step;
            // Twice the spacing of numbers of this size: no further step would change it.
            if step.abs() > 4.0 * f64::EPSILON * (w.abs() + self.origin[2].abs() + 1e-6) {
                continue;
            }
            // F(x, y, w) = P_z - z(P_x, P_y) = 0; each argument moves P along one axis of the part.
            let [xx, xy, yy] = parent.second;
            let bend =
                |a: [f64; 3], b: [f64; 3]| -(xx * a[0] * b[0] + xy * (a[0] * b[1] + a[1] * b[0]) + yy * a[1] * b[1]);
            let slope = [self.x, self.y].map(|axis| -along(axis) / rate);
            let axes = [self.x, self.y];
            let second = |i: usize, j: usize| {
                -(bend(axes[i], axes[j])
                    + bend(axes[i], self.z) * slope[j]
                    + bend(axes[j], self.z) * slope[i]
                    + bend(self.z, self.z) * slope[i] * slope[j])
                    / rate
            };
            return Some(SurfacePoint { sag: w, slope, second: [second(0, 0), second(0, 1), second(1, 1)] });
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::examples::{differences, of};
    use super::*;
    use crate::job::{Conic, Form, Side, Sphere};
    use crate::units::si::{Angle, Length};
    use proptest::prelude::*;

    fn segment(parent: Form, distance: f64, degrees: f64) -> Box<dyn Surface> {
        let direction = Angle(degrees.to_radians());
        of(Form::off_axis(OffAxis { parent: Box::new(parent), distance: Length(distance), direction }))
    }

    fn paraboloid() -> Form {
        Form::conic(Conic { side: Side::concave, radius: Length(2.0), conic: -1.0 })
    }

    #[test]
    fn a_piece_of_a_sphere_is_that_sphere() {
        for side in [Side::concave, Side::convex] {
            let sphere = Form::sphere(Sphere { side, radius: Length(0.5) });
            let (whole, piece) = (of(sphere.clone()), segment(sphere, 0.3, 40.0));
            for (x, y) in [(0.0, 0.0), (0.1, 0.02), (-0.1, 0.1), (0.0, -0.15)] {
                let (w, p) = (whole.at(x, y).expect("on it"), piece.at(x, y).expect("on it"));
                assert!((w.sag - p.sag).abs() < 1e-15);
                assert!((0..2).all(|i| (w.slope[i] - p.slope[i]).abs() < 1e-14));
                assert!((0..3).all(|i| (w.second[i] - p.second[i]).abs() < 1e-12));
            }
        }
    }

    #[test]
    fn direction_turns_the_piece_against_the_clock() {
        // The place that lies 0.1 m away from the axis lies along `direction` on the part.
        let straight = segment(paraboloid(), 0.6, 0.0).at(0.1, 0.02).expect("on it");
        let turned = segment(paraboloid(), 0.6, 90.0).at(-0.02, 0.1).expect("on it");
        assert!((straight.sag - turned.sag).abs() < 1e-15);
        assert!((straight.slope[0] - turned.slope[1]).abs() < 1e-14);
        assert!((straight.slope[1] + turned.slope[0]).abs() < 1e-14);
    }

    #[test]
    fn a_parent_that_ends_before_the_part_is_refused() {
        let sphere = Form::sphere(Sphere { side: Side::concave, radius: Length(0.5) });
        let job = OffAxis { parent: Box::new(sphere), distance: Length(0.5), direction: Angle(0.0) };
        let problem = Segment::new(&job).expect_err("a refusal");
        assert_eq!((problem.code, problem.field.as_deref()), (codes::E0602, Some("distance")));
        let plane = OffAxis { parent: Box::new(Form::plane(crate::job::Plane {})), ..job };
        assert_eq!(Segment::new(&plane).expect_err("a refusal").field.as_deref(), Some("parent"));
    }

    proptest! {
        #[test]
        fn derivatives_are_those_of_the_sag(
            x in -0.2f64..0.2, y in -0.2f64..0.2, distance in 0.1f64..0.8, degrees in -180.0f64..180.0,
        ) {
            let surface = segment(paraboloid(), distance, degrees);
            // Third derivatives stay below 1 /m²: h²/6 is 2e-11; rounding of a sag of 0.1 m over 2e-5 m is 1e-12.
            let (slope, second) = differences(&*surface, x, y, 1e-5);
            prop_assert!(slope < 1e-9 && second < 1e-9, "{} {}", slope, second);
        }
    }
}
