//! Zernike polynomials, in the three numberings that drawings use.
//!
//! In: an order, a radius, coefficients. Out: the surface, or the [`Basis`] of a fit. With rho = r / radius, theta from +x
//! towards +y:
//!
//! ```text
//! R(n, m) = sum over k of (-1)^k (n-k)! / (k! ((n+m)/2 - k)! ((n-m)/2 - k)!) rho^(n-2k)
//! ```
//!
//! times cos(m theta) or sin(m theta). Evaluated in x and y as a polynomial in rho² times the harmonic polynomials
//! Re and Im (x + iy)^m, so that nothing is singular in the middle. The polynomials go on beyond the radius.
//!
//! * `fringe`: the 36 of the University of Arizona, by (n + m)/2, then falling m, cosine before sine; 1 at the rim.
//! * `noll`: by n, then m; even numbers are cosines; RMS 1 over the disc (Noll, J. Opt. Soc. Am. 66, 1976).
//! * `ansi`: number (n (n + 2) ± m)/2 from 0, sines negative; RMS 1 over the disc (ANSI Z80.28).

use super::{Surface, SurfacePoint, finite, positive, sign_of};
use crate::diagnostics::{Problem, codes};
use crate::job::{self, ZernikeOrder};

/// One polynomial: radial order, angular order, whether it is a sine, factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    pub n: u32,
    pub m: u32,
    pub sine: bool,
    pub factor: f64,
}

/// Highest radial order: up to here the terms of the sum, up to about 10^7, leave nine digits of a coefficient.
const HIGHEST_ORDER: u32 = 20;

/// Number of polynomials of the fringe set: further ones are numbered differently by different makers.
const FRINGE_TERMS: usize = 36;

/// Most coefficients: all polynomials up to the highest order.
const MOST_TERMS: usize = ((HIGHEST_ORDER + 1) * (HIGHEST_ORDER + 2) / 2) as usize;

/// Most polynomials that an order has here.
pub fn most_terms(order: ZernikeOrder) -> usize {
    if order == ZernikeOrder::fringe { FRINGE_TERMS } else { MOST_TERMS }
}

/// The polynomial with the number `index`, counted from 0 whatever the order's own first number is.
pub fn term(order: ZernikeOrder, index: usize) -> Term {
    let index = index as u32;
    match order {
        ZernikeOrder::fringe => {
            // Group g holds 2 g + 1 polynomials with (n + m)/2 = g.
            let g = (0..).find(|g| (g + 1) * (g + 1) > index).unwrap_or(0);
            let place = index - g * g;
            let m = g - place / 2;
            Term { n: 2 * g - m, m, sine: place % 2 == 1, factor: 1.0 }
        }
        ZernikeOrder::noll | ZernikeOrder::ansi => {
            let n = (0..).find(|n| (n + 1) * (n + 2) / 2 > index).unwrap_or(0);
            let place = index - n * (n + 1) / 2;
            let (m, sine) = if order == ZernikeOrder::ansi {
                let signed = 2 * i64::from(place) - i64::from(n);
                (signed.unsigned_abs() as u32, signed < 0)
            } else {
                // From the smallest m on, two polynomials each but for m = 0; Noll's number is index + 1.
                let m = if n % 2 == 0 { 2 * place.div_ceil(2) } else { 2 * (place / 2) + 1 };
                (m, m > 0 && (index + 1) % 2 == 1)
            };
            let factor = f64::from(if m == 0 { n + 1 } else { 2 * (n + 1) }).sqrt();
            Term { n, m, sine, factor }
        }
    }
}

/// Polynomials of one angular order, summed: a polynomial in rho² times a harmonic polynomial.
#[derive(Debug)]
struct Harmonic {
    m: u32,
    sine: bool,
    /// Of rho², from the power 0 on.
    radial: Vec<f64>,
}

/// Coefficients of `rho^-m R(n, m)` as a polynomial in rho², from the power 0 on.
fn radial(n: u32, m: u32) -> Vec<f64> {
    let factorial = |k: u32| (1..=k).map(f64::from).product::<f64>();
    let (half_sum, half_difference) = ((n + m) / 2, (n - m) / 2);
    let mut coefficients = vec![0.0; half_difference as usize + 1];
    for k in 0..=half_difference {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        // Factorials up to 20! are exact to rounding, and so is the whole quotient.
        let quotient = factorial(n - k) / (factorial(k) * factorial(half_sum - k) * factorial(half_difference - k));
        coefficients[(half_difference - k) as usize] = sign * quotient;
    }
    coefficients
}

/// A sum of Zernike polynomials.
#[derive(Debug)]
pub struct Sum {
    radius: f64,
    harmonics: Vec<Harmonic>,
}

impl Sum {
    /// Of coefficients in metres, from the first polynomial of the order on.
    pub fn new(order: ZernikeOrder, radius: f64, coefficients: &[f64]) -> Sum {
        let mut harmonics: Vec<Harmonic> = Vec::new();
        for (index, coefficient) in coefficients.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            let Term { n, m, sine, factor } = term(order, index);
            let at = harmonics.iter().position(|h| (h.m, h.sine) == (m, sine)).unwrap_or(harmonics.len());
            if at == harmonics.len() {
                harmonics.push(Harmonic { m, sine, radial: Vec::new() });
            }
            let sum = &mut harmonics[at].radial;
            for (power, a) in radial(n, m).into_iter().enumerate() {
                if sum.len() <= power {
                    sum.push(0.0);
                }
                sum[power] += coefficient * factor * a;
            }
        }
        Sum { radius, harmonics }
    }

    /// Height, slope and second derivatives at a place in metres.
    pub fn at(&self, x: f64, y: f64) -> SurfacePoint {
        let (u, v) = (x / self.radius, y / self.radius);
        let square = u * u + v * v;
        let mut sum = SurfacePoint::default();
        for Harmonic { m, sine, radial } in &self.harmonics {
            // Q(rho²) with its first two derivatives by rho², by Horner.
            let (mut q, mut q1, mut q2) = (0.0, 0.0, 0.0);
            for a in radial.iter().rev() {
                q2 = q2 * square + 2.0 * q1;
                q1 = q1 * square + q;
                q = q * square + a;
            }
            // Re and Im of (u + iv)^m and of the two powers below it.
            let k = f64::from(*m);
            let harmonic = |power: u32| {
                let (mut re, mut im) = (1.0, 0.0);
                for _ in 0..power {
                    (re, im) = (re * u - im * v, re * v + im * u);
                }
                // d/du Re = k Re_below, d/dv Re = -k Im_below; d/du Im = k Im_below, d/dv Im = k Re_below.
                if *sine { [im, re] } else { [re, -im] }
            };
            let h = harmonic(*m)[0];
            let [h_u, h_v] = if *m >= 1 { harmonic(m - 1).map(|d| k * d) } else { [0.0; 2] };
            let [h_uu, h_uv] = if *m >= 2 { harmonic(m - 2).map(|d| k * (k - 1.0) * d) } else { [0.0; 2] };
            let (q_u, q_v) = (2.0 * u * q1, 2.0 * v * q1);
            let (q_uu, q_uv, q_vv) = (2.0 * q1 + 4.0 * u * u * q2, 4.0 * u * v * q2, 2.0 * q1 + 4.0 * v * v * q2);
            let term = SurfacePoint {
                sag: q * h,
                slope: [q_u * h + q * h_u, q_v * h + q * h_v],
                second: [
                    q_uu * h + 2.0 * q_u * h_u + q * h_uu,
                    q_uv * h + q_u * h_v + q_v * h_u + q * h_uv,
                    // A harmonic polynomial has h_vv = -h_uu.
                    q_vv * h + 2.0 * q_v * h_v - q * h_uu,
                ],
            };
            sum = sum.plus(&term, 1.0);
        }
        let (one, two) = (1.0 / self.radius, 1.0 / (self.radius * self.radius));
        SurfacePoint { sag: sum.sag, slope: sum.slope.map(|d| d * one), second: sum.second.map(|d| d * two) }
    }
}

/// The first polynomials of an order, one by one: what a fit asks for.
pub struct Basis(Vec<(Term, Vec<f64>)>);

impl Basis {
    /// The first `count` polynomials.
    pub fn new(order: ZernikeOrder, count: usize) -> Basis {
        let terms = (0..count).map(|index| term(order, index));
        Basis(terms.map(|term| (term, radial(term.n, term.m))).collect())
    }

    /// Their values at `(u, v)`, the place over the radius.
    pub fn at(&self, u: f64, v: f64, values: &mut [f64]) {
        let square = u * u + v * v;
        for (value, (term, radial)) in values.iter_mut().zip(&self.0) {
            let q = radial.iter().rev().fold(0.0, |q, a| q * square + a);
            let (mut re, mut im) = (1.0, 0.0);
            for _ in 0..term.m {
                (re, im) = (re * u - im * v, re * v + im * u);
            }
            *value = term.factor * q * if term.sine { im } else { re };
        }
    }
}

/// A Zernike freeform.
#[derive(Debug)]
pub struct Freeform {
    base: Box<dyn Surface>,
    sum: Sum,
}

impl Freeform {
    pub fn new(job: &job::Zernike, base: Box<dyn Surface>) -> Result<Freeform, Problem> {
        let radius = positive("radius", job.radius.0)?;
        let most = most_terms(job.order);
        if job.coefficients.is_empty() || job.coefficients.len() > most {
            let message = format!("the form has {} coefficients; its order has 1 to {most}", job.coefficients.len());
            return Err(Problem::error(codes::E0602, "coefficients", message)
                .help("the first coefficient belongs to the first polynomial of the order; write 0 mm for those that are not used"));
        }
        let sign = sign_of(job.sag);
        let coefficients: Vec<f64> = job
            .coefficients
            .iter()
            .enumerate()
            .map(|(i, a)| Ok(sign * finite(format!("coefficients.{i}"), a.0)?))
            .collect::<Result<_, Problem>>()?;
        Ok(Freeform { base, sum: Sum::new(job.order, radius, &coefficients) })
    }
}

impl Surface for Freeform {
    fn at(&self, x: f64, y: f64) -> Option<SurfacePoint> {
        let base = self.base.at(x, y)?;
        Some(base.plus(&self.sum.at(x, y), 1.0)).filter(|point| point.sag.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::super::asphere::power_of;
    use super::super::examples::{differences, of};
    use super::*;
    use crate::job::{Form, Plane, Sag};
    use crate::units::si::Length;
    use proptest::prelude::*;

    fn rho(n: u32, r: f64) -> f64 {
        power_of(r, n)
    }

    fn of_coefficients(order: ZernikeOrder, coefficients: &[f64]) -> Box<dyn Surface> {
        of(Form::zernike(job::Zernike {
            base: Box::new(Form::plane(Plane {})),
            sag: Sag::positive_towards_tool,
            radius: Length(0.1),
            order,
            coefficients: coefficients.iter().map(|a| Length(*a)).collect(),
        }))
    }

    /// The polynomials as textbooks print them, at rho = 0.7, theta = 50 degrees.
    #[test]
    fn polynomials_are_those_of_the_books() {
        let (r, t) = (0.7_f64, 50_f64.to_radians());
        let (c, s) = (|m: f64| libm::cos(m * t), |m: f64| libm::sin(m * t));
        // Fringe 1 to 16 (Wyant and Creath, Basic Wavefront Aberration Theory, table III).
        let fringe = [
            1.0,
            r * c(1.0),
            r * s(1.0),
            2.0 * r * r - 1.0,
            r * r * c(2.0),
            r * r * s(2.0),
            (3.0 * r * r - 2.0) * r * c(1.0),
            (3.0 * r * r - 2.0) * r * s(1.0),
            6.0 * rho(4, r) - 6.0 * r * r + 1.0,
            rho(3, r) * c(3.0),
            rho(3, r) * s(3.0),
            (4.0 * r * r - 3.0) * r * r * c(2.0),
            (4.0 * r * r - 3.0) * r * r * s(2.0),
            (10.0 * rho(4, r) - 12.0 * r * r + 3.0) * r * c(1.0),
            (10.0 * rho(4, r) - 12.0 * r * r + 3.0) * r * s(1.0),
            20.0 * rho(6, r) - 30.0 * rho(4, r) + 12.0 * r * r - 1.0,
        ];
        // Noll 1 to 11 (Noll 1976, table I).
        let noll = [
            1.0,
            2.0 * r * c(1.0),
            2.0 * r * s(1.0),
            3_f64.sqrt() * (2.0 * r * r - 1.0),
            6_f64.sqrt() * r * r * s(2.0),
            6_f64.sqrt() * r * r * c(2.0),
            8_f64.sqrt() * (3.0 * rho(3, r) - 2.0 * r) * s(1.0),
            8_f64.sqrt() * (3.0 * rho(3, r) - 2.0 * r) * c(1.0),
            8_f64.sqrt() * rho(3, r) * s(3.0),
            8_f64.sqrt() * rho(3, r) * c(3.0),
            5_f64.sqrt() * (6.0 * rho(4, r) - 6.0 * r * r + 1.0),
        ];
        // ANSI 0 to 9: m = -1, 1; -2, 0, 2; -3, -1, 1, 3, negative m the sines.
        let ansi = [
            1.0,
            2.0 * r * s(1.0),
            2.0 * r * c(1.0),
            6_f64.sqrt() * r * r * s(2.0),
            3_f64.sqrt() * (2.0 * r * r - 1.0),
            6_f64.sqrt() * r * r * c(2.0),
            8_f64.sqrt() * rho(3, r) * s(3.0),
            8_f64.sqrt() * (3.0 * rho(3, r) - 2.0 * r) * s(1.0),
            8_f64.sqrt() * (3.0 * rho(3, r) - 2.0 * r) * c(1.0),
            8_f64.sqrt() * rho(3, r) * c(3.0),
        ];
        let (u, v) = (r * c(1.0), r * s(1.0));
        for (order, expected) in [
            (ZernikeOrder::fringe, fringe.as_slice()),
            (ZernikeOrder::noll, noll.as_slice()),
            (ZernikeOrder::ansi, ansi.as_slice()),
        ] {
            let mut found = vec![0.0; expected.len()];
            Basis::new(order, expected.len()).at(u, v, &mut found);
            for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
                assert!((found - expected).abs() < 1e-14, "{order:?} {i}: {found}, expected {expected}");
                let mut one = vec![0.0; i + 1];
                one[i] = 1e-3;
                let sag = of_coefficients(order, &one).at(0.1 * u, 0.1 * v).expect("everywhere").sag;
                assert!((sag - 1e-3 * expected).abs() < 1e-17, "{order:?} {i}: {sag}");
            }
        }
        // The last of the fringe set is R(10, 0), 1 at the rim.
        assert_eq!(term(ZernikeOrder::fringe, 35), Term { n: 10, m: 0, sine: false, factor: 1.0 });
        // All polynomials up to n = 7 are 36, and the last of them has m = 7.
        assert_eq!((term(ZernikeOrder::noll, 35).n, term(ZernikeOrder::noll, 35).m), (7, 7));
        assert_eq!(term(ZernikeOrder::noll, 36).n, 8);
    }

    #[test]
    fn too_many_coefficients_are_refused() {
        let mut form = job::Zernike {
            base: Box::new(Form::plane(Plane {})),
            sag: Sag::positive_towards_tool,
            radius: Length(0.1),
            order: ZernikeOrder::fringe,
            coefficients: vec![Length(0.0); 37],
        };
        assert_eq!(Freeform::new(&form, Box::new(Plane {})).expect_err("a refusal").code, codes::E0602);
        form.order = ZernikeOrder::noll;
        assert!(Freeform::new(&form, Box::new(Plane {})).is_ok());
        form.coefficients.clear();
        assert!(Freeform::new(&form, Box::new(Plane {})).is_err());
    }

    proptest! {
        #[test]
        fn derivatives_are_those_of_the_sag(
            coefficients in prop::collection::vec(-1e-4f64..1e-4, 1..36), x in -0.08f64..0.08, y in -0.08f64..0.08,
            order in prop::sample::select(vec![ZernikeOrder::fringe, ZernikeOrder::noll, ZernikeOrder::ansi]),
        ) {
            // Third derivatives up to some thousand /m²: h²/6 of it is 1e-8 with h = 5 um.
            let surface = of_coefficients(order, &coefficients);
            let (slope, second) = differences(&*surface, x, y, 5e-6);
            prop_assert!(slope < 1e-7 && second < 1e-7, "{} {}", slope, second);
        }
    }
}
