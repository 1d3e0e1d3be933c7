//! XY polynomial: products of powers of x and y on a base.
//!
//! ```text
//! z = z_base + sum of coefficient (x / l)^i (y / l)^j        l = normalisation
//! ```
//!
//! with the sign that the form's `sag` gives the coefficients. Every coefficient is a height, so that one list holds all
//! orders; a drawing that gives them in powers of a millimetre has `normalisation: 1 mm`.

use super::asphere::power_of;
use super::{Surface, SurfacePoint, finite, positive, sign_of};
use crate::diagnostics::{Problem, codes};
use crate::job::XyPolynomial;

#[derive(Debug)]
pub struct Polynomial {
    base: Box<dyn Surface>,
    normalisation: f64,
    /// Powers of x and y, coefficient towards the tool, metres.
    terms: Vec<(u32, u32, f64)>,
}

/// Highest power: far beyond any design, and low enough that no power overflows.
const HIGHEST: i64 = 20;

/// Most terms: those with powers of x and y that sum to no more than twenty.
const MOST_TERMS: usize = 231;

impl Polynomial {
    pub fn new(job: &XyPolynomial, base: Box<dyn Surface>) -> Result<Polynomial, Problem> {
        let normalisation = positive("normalisation", job.normalisation.0)?;
        if job.terms.is_empty() || job.terms.len() > MOST_TERMS {
            let message = format!("the polynomial has {} terms; 1 to {MOST_TERMS} make a surface", job.terms.len());
            return Err(Problem::error(codes::E0602, "terms", message));
        }
        let mut terms: Vec<(u32, u32, f64)> = Vec::with_capacity(job.terms.len());
        for (i, term) in job.terms.iter().enumerate() {
            let power = |name: &str, value: i64| {
                u32::try_from(value).ok().filter(|_| value <= HIGHEST).ok_or_else(|| {
                    let message = format!("the power {value} lies outside 0 to {HIGHEST}");
                    Problem::error(codes::E0602, format!("terms.{i}.{name}"), message)
                })
            };
            let (x, y) = (power("x_power", term.x_power)?, power("y_power", term.y_power)?);
            if terms.iter().any(|(a, b, _)| (*a, *b) == (x, y)) {
                let message = format!("the polynomial says its term x^{x} y^{y} twice");
                return Err(Problem::error(codes::E0602, format!("terms.{i}"), message)
                    .help("take one of the two out, or add their coefficients"));
            }
            let coefficient = finite(format!("terms.{i}.coefficient"), term.coefficient.0)?;
            terms.push((x, y, sign_of(job.sag) * coefficient));
        }
        Ok(Polynomial { base, normalisation, terms })
    }
}

/// `t^power` with its first and second derivative.
fn powers(t: f64, power: u32) -> [f64; 3] {
    let i = f64::from(power);
    [
        power_of(t, power),
        if power >= 1 { i * power_of(t, power - 1) } else { 0.0 },
        if power >= 2 { i * (i - 1.0) * power_of(t, power - 2) } else { 0.0 },
    ]
}

impl Surface for Polynomial {
    fn at(&self, x: f64, y: f64) -> Option<SurfacePoint> {
        let base = self.base.at(x, y)?;
        let l = self.normalisation;
        let mut sum = SurfacePoint::default();
        for (i, j, a) in &self.terms {
            let ([x0, x1, x2], [y0, y1, y2]) = (powers(x / l, *i), powers(y / l, *j));
            let term = SurfacePoint {
                sag: x0 * y0,
                slope: [x1 * y0 / l, x0 * y1 / l],
                second: [x2 * y0 / (l * l), x1 * y1 / (l * l), x0 * y2 / (l * l)],
            };
            sum = sum.plus(&term, *a);
        }
        Some(base.plus(&sum, 1.0)).filter(|point| point.sag.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::super::examples::{differences, of};
    use super::*;
    use crate::job::{Form, Plane, Sag, Side, Sphere, XyTerm};
    use crate::units::si::Length;

    fn job(base: Form, sag: Sag, terms: &[(i64, i64, f64)]) -> XyPolynomial {
        let term = |(x_power, y_power, a): &(i64, i64, f64)| XyTerm {
            x_power: *x_power,
            y_power: *y_power,
            coefficient: Length(*a),
        };
        XyPolynomial { base: Box::new(base), sag, normalisation: Length(0.1), terms: terms.iter().map(term).collect() }
    }

    #[test]
    fn terms_stand_on_the_base() {
        // At (0.05, 0.2): (1/2)² 2 = 0.5 of 1 mm, 2³ = 8 of 0.1 mm, into the glass of a sphere.
        let sphere = Form::sphere(Sphere { side: Side::concave, radius: Length(1.0) });
        let form = job(sphere.clone(), Sag::positive_into_glass, &[(2, 1, 1e-3), (0, 3, 1e-4)]);
        let surface = of(Form::xy_polynomial(form));
        let expected = of(sphere).at(0.05, 0.2).expect("on it").sag - 0.5e-3 - 0.8e-3;
        assert!((surface.at(0.05, 0.2).expect("on it").sag - expected).abs() < 1e-16);
        for (x, y) in [(0.0, 0.0), (0.05, 0.2), (-0.1, 0.03)] {
            // Third derivatives up to 2 /m² and rounding as elsewhere.
            let (slope, second) = differences(&*surface, x, y, 1e-5);
            assert!(slope < 1e-9 && second < 1e-9, "{slope} {second}");
        }
    }

    #[test]
    fn what_is_no_polynomial_is_refused() {
        for (terms, field) in [
            (vec![], "terms"),
            (vec![(1, -1, 1.0)], "terms.0.y_power"),
            (vec![(21, 0, 1.0)], "terms.0.x_power"),
            (vec![(1, 1, 1.0), (1, 1, 2.0)], "terms.1"),
            (vec![(1, 1, f64::NAN)], "terms.0.coefficient"),
        ] {
            let job = job(Form::plane(Plane {}), Sag::positive_towards_tool, &terms);
            let problem = Polynomial::new(&job, Box::new(Plane {})).expect_err("a refusal");
            assert_eq!((problem.code, problem.field.as_deref()), (codes::E0602, Some(field)));
        }
    }
}
