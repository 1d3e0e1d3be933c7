//! Sphere, conic, even and odd asphere: one rotationally symmetric profile.
//!
//! With the vertex curvature c (positive where hollow), the conic constant k and r² = x² + y²:
//!
//! ```text
//! z = c r² / (1 + s) + sum of a_i r^i        s = sqrt(1 - (1 + k) c² r²)
//! ```
//!
//! (ISO 10110-12, with the sign of the coefficients as the form's `sag` says.) It exists while s > 0; at s = 0 the wall is
//! vertical. Derivatives go by f = (dz/dr)/r and g = r df/dr, which stay finite on the axis for every power from the
//! second on: c/s + sum of i a_i r^(i-2), and (1 + k) c³ r² / s³ + sum of i (i - 2) a_i r^(i-2).

use super::{Surface, SurfacePoint, finite, sign_of, vertex_curvature};
use crate::diagnostics::{Problem, codes};
use crate::job::Form;

/// A rotationally symmetric surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Asphere {
    curvature: f64,
    conic: f64,
    /// Powers of r with their coefficients, towards the tool, SI.
    terms: Vec<(u32, f64)>,
}

impl Asphere {
    /// Of a rotationally symmetric form.
    ///
    /// # Errors
    ///
    /// E0602 for a radius that is not positive, a number that is not finite, and a form that is not rotationally
    /// symmetric.
    pub fn new(form: &Form) -> Result<Asphere, Problem> {
        let (side, radius, conic, terms) = match form {
            Form::sphere(f) => (f.side, f.radius, 0.0, Vec::new()),
            Form::conic(f) => (f.side, f.radius, f.conic, Vec::new()),
            Form::even_asphere(f) => {
                let all = [
                    (4, f.a4.map(|a| a.0)),
                    (6, f.a6.map(|a| a.0)),
                    (8, f.a8.map(|a| a.0)),
                    (10, f.a10.map(|a| a.0)),
                    (12, f.a12.map(|a| a.0)),
                    (14, f.a14.map(|a| a.0)),
                    (16, f.a16.map(|a| a.0)),
                    (18, f.a18.map(|a| a.0)),
                    (20, f.a20.map(|a| a.0)),
                ];
                (f.side, f.radius, f.conic, written(&all, sign_of(f.sag))?)
            }
            Form::odd_asphere(f) => {
                let all = [
                    (3, f.a3.map(|a| a.0)),
                    (4, f.a4.map(|a| a.0)),
                    (5, f.a5.map(|a| a.0)),
                    (6, f.a6.map(|a| a.0)),
                    (7, f.a7.map(|a| a.0)),
                    (8, f.a8.map(|a| a.0)),
                    (9, f.a9.map(|a| a.0)),
                    (10, f.a10.map(|a| a.0)),
                    (11, f.a11.map(|a| a.0)),
                    (12, f.a12.map(|a| a.0)),
                    (13, f.a13.map(|a| a.0)),
                    (14, f.a14.map(|a| a.0)),
                    (15, f.a15.map(|a| a.0)),
                    (16, f.a16.map(|a| a.0)),
                    (17, f.a17.map(|a| a.0)),
                    (18, f.a18.map(|a| a.0)),
                    (19, f.a19.map(|a| a.0)),
                    (20, f.a20.map(|a| a.0)),
                ];
                (f.side, f.radius, f.conic, written(&all, sign_of(f.sag))?)
            }
            _ => {
                let message = "the form is not rotationally symmetric";
                return Err(Problem::error(codes::E0602, "", message)
                    .help("take a `sphere`, `conic`, `even_asphere` or `odd_asphere`"));
            }
        };
        Ok(Asphere { curvature: vertex_curvature(side, radius.0)?, conic: finite("conic", conic)?, terms })
    }

    /// From numbers: vertex curvature (positive where hollow), conic constant, and powers of r with their coefficients
    /// towards the tool; SI.
    pub fn of_numbers(curvature: f64, conic: f64, terms: Vec<(u32, f64)>) -> Asphere {
        Asphere { curvature, conic, terms }
    }
}

fn written(all: &[(u32, Option<f64>)], sign: f64) -> Result<Vec<(u32, f64)>, Problem> {
    all.iter()
        .filter_map(|(power, value)| value.map(|value| (*power, value)))
        .map(|(power, value)| Ok((power, sign * finite(format!("a{power}"), value)?)))
        .collect()
}

impl Surface for Asphere {
    fn at(&self, x: f64, y: f64) -> Option<SurfacePoint> {
        let (c, square) = (self.curvature, x * x + y * y);
        let under = 1.0 - (1.0 + self.conic) * c * c * square;
        if !(under > 0.0 && square.is_finite()) {
            return None;
        }
        let s = under.sqrt();
        let r = square.sqrt();
        let mut sag = c * square / (1.0 + s);
        let mut f = c / s;
        let mut g = (1.0 + self.conic) * c * c * c * square / (s * s * s);
        for (power, a) in &self.terms {
            let i = f64::from(*power);
            let lower = a * power_of(r, power - 2);
            sag += lower * square;
            f += i * lower;
            g += i * (i - 2.0) * lower;
        }
        // On the axis g is zero, and no direction is asked for.
        let (ux, uy) = if r > 0.0 { (x / r, y / r) } else { (0.0, 0.0) };
        let second = [f + ux * ux * g, ux * uy * g, f + uy * uy * g];
        Some(SurfacePoint { sag, slope: [x * f, y * f], second })
    }
}

/// `base` to a small whole power, by multiplication: the same on every platform.
pub(super) fn power_of(base: f64, power: u32) -> f64 {
    let (mut result, mut square, mut left) = (1.0, base, power);
    while left > 0 {
        if left & 1 == 1 {
            result *= square;
        }
        square *= square;
        left >>= 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::super::examples::{differences, of};
    use super::*;
    use crate::job::{Conic, EvenAsphere, OddAsphere, Sag, Side, Sphere};
    use crate::units::si::*;
    use proptest::prelude::*;

    fn even(sag: Sag) -> EvenAsphere {
        EvenAsphere {
            side: Side::concave,
            radius: Length(2.0),
            conic: -1.0,
            sag,
            a4: None,
            a6: None,
            a8: None,
            a10: None,
            a12: None,
            a14: None,
            a16: None,
            a18: None,
            a20: None,
        }
    }

    /// The example of the model's page: A4 = 1e-10 /mm³, x = 200 mm, C = 1/2000 mm, k = -1: 10.16 mm with the sign towards
    /// the tool, 9.84 mm with the other.
    #[test]
    fn the_sign_of_the_coefficients_is_the_jobs() {
        for (sag, expected) in [(Sag::positive_towards_tool, 10.16e-3), (Sag::positive_into_glass, 9.84e-3)] {
            let form = EvenAsphere { a4: Some(PerLength3(0.1)), ..even(sag) };
            let found = of(Form::even_asphere(form)).at(0.2, 0.0).expect("a paraboloid has no end").sag;
            assert!((found - expected).abs() < 1e-15, "{found}");
        }
    }

    #[test]
    fn a_sphere_ends_at_its_radius() {
        let sphere = of(Form::sphere(Sphere { side: Side::convex, radius: Length(0.1) }));
        assert!(sphere.at(0.06, 0.0799).is_some());
        assert!(sphere.at(0.06, 0.08).is_none() && sphere.at(f64::NAN, 0.0).is_none());
        let steep = sphere.at(0.06, 0.0).expect("inside");
        // 0.1 - sqrt(0.01 - 0.0036) = 0.02, slope 0.06 / 0.08.
        assert!((steep.sag + 0.02).abs() < 1e-16 && (steep.slope[0] + 0.75).abs() < 1e-15);
    }

    #[test]
    fn numbers_that_describe_nothing_are_refused() {
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let problem = Asphere::new(&Form::sphere(Sphere { side: Side::convex, radius: Length(radius) }));
            assert_eq!(problem.expect_err("a refusal").code, codes::E0602);
        }
        let form = EvenAsphere { a6: Some(PerLength5(f64::NAN)), ..even(Sag::positive_into_glass) };
        let problem = Asphere::new(&Form::even_asphere(form)).expect_err("a refusal");
        assert_eq!(problem.field.as_deref(), Some("a6"));
    }

    proptest! {
        // Central differences over h = 10 um of a surface with third derivatives up to 100 /m² are off by h²/6 of them: 2e-9;
        // second derivatives times h by less.
        #[test]
        fn derivatives_are_those_of_the_sag(
            radius in 0.3f64..3.0, conic in -2.0f64..1.0, x in -0.2f64..0.2, y in -0.2f64..0.2,
            a3 in -0.3f64..0.3, a4 in -1.0f64..1.0, a5 in -1.0f64..1.0, a8 in -5.0f64..5.0,
            concave in any::<bool>(),
        ) {
            let form = OddAsphere {
                side: if concave { Side::concave } else { Side::convex },
                radius: Length(radius), conic, sag: Sag::positive_into_glass,
                a3: Some(PerLength2(a3)), a4: Some(PerLength3(a4)), a5: Some(PerLength4(a5)), a6: None, a7: None,
                a8: Some(PerLength7(a8)), a9: None, a10: None, a11: None, a12: None, a13: None, a14: None, a15: None,
                a16: None, a17: None, a18: None, a19: None, a20: None,
            };
            let surface = of(Form::odd_asphere(form));
            prop_assume!(surface.at(x * 1.2, y * 1.2).is_some() && libm::hypot(x, y) > 1e-3);
            let (slope, second) = differences(&*surface, x, y, 1e-5);
            prop_assert!(slope < 1e-8 && second < 1e-7, "{} {}", slope, second);
        }

        #[test]
        fn a_conic_of_zero_is_a_sphere_and_solves_its_equation(
            radius in 0.3f64..3.0, conic in -2.0f64..1.0, x in -0.2f64..0.2, y in -0.2f64..0.2,
        ) {
            let sphere = of(Form::sphere(Sphere { side: Side::concave, radius: Length(radius) }));
            let same = of(Form::conic(Conic { side: Side::concave, radius: Length(radius), conic: 0.0 }));
            prop_assert_eq!(sphere.at(x, y), same.at(x, y));
            // c (x² + y²) + c (1 + k) z² - 2 z = 0, and its gradient is along the normal.
            let form = of(Form::conic(Conic { side: Side::concave, radius: Length(radius), conic }));
            let Some(point) = form.at(x, y) else { return Ok(()) };
            let (c, z) = (1.0 / radius, point.sag);
            prop_assert!((c * (x * x + y * y) + c * (1.0 + conic) * z * z - 2.0 * z).abs() < 1e-14);
            let gradient = [-2.0 * c * x, -2.0 * c * y, 2.0 - 2.0 * c * (1.0 + conic) * z];
            let length = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
            for (normal, gradient) in point.normal().iter().zip(gradient) {
                prop_assert!((normal - gradient / length).abs() < 1e-13);
            }
        }
    }
}
