//! Numbers that the closed forms of tools are made of: Gauss-Legendre quadrature and the incomplete elliptic integral.
//!
//! In: a function, a range. Out: its integral. Everything by `libm` and sums in a fixed order.

use std::f64::consts::PI;
use std::sync::OnceLock;

/// Nodes on -1..1 and weights of the Gauss-Legendre rule with this many nodes.
const NODES: usize = 64;

/// The rule, made once for as many integrals as are asked of it.
pub(super) struct Quadrature {
    /// Node and weight.
    rule: &'static [[f64; 2]],
}

/// Made once: a pad near an edge asks for it a hundred thousand times.
static RULE: OnceLock<Vec<[f64; 2]>> = OnceLock::new();

impl Quadrature {
    pub fn new() -> Quadrature {
        let n = NODES as f64;
        let node = |k: usize| {
            // Newton's method on the Legendre polynomial, from the usual first guess.
            let mut x = libm::cos(PI * (k as f64 + 0.75) / (n + 0.5));
            let mut slope = 1.0;
            for _ in 0..8 {
                let (mut before, mut here) = (1.0, x);
                for j in 2..=NODES {
                    let j = j as f64;
                    (before, here) = (here, ((2.0 * j - 1.0) * x * here - (j - 1.0) * before) / j);
                }
                slope = n * (x * here - before) / (x * x - 1.0);
                x -= here / slope;
            }
            [x, 2.0 / ((1.0 - x * x) * slope * slope)]
        };
        Quadrature { rule: RULE.get_or_init(|| (0..NODES).map(node).collect()) }
    }

    /// The integral from `low` to `high` of a function that is smooth inside and may have a kink or a root at the ends: the
    /// places are low + (high - low) sin²(πt/2), which crowd there.
    pub fn integrate(&self, low: f64, high: f64, mut value: impl FnMut(f64) -> f64) -> f64 {
        let width = high - low;
        let mut sum = 0.0;
        for [node, weight] in self.rule {
            let t = 0.5 * (node + 1.0);
            let sine = libm::sin(0.5 * PI * t);
            sum += 0.25 * PI * weight * libm::sin(PI * t) * value(low + width * sine * sine);
        }
        sum * width
    }

    /// The sum of the integrals between neighbours of `breaks`.
    pub fn piecewise(&self, breaks: &[f64], mut value: impl FnMut(f64) -> f64) -> f64 {
        breaks.windows(2).map(|pair| self.integrate(pair[0], pair[1], &mut value)).sum()
    }
}

/// The incomplete elliptic integral of the second kind E(phi | m), 0 <= phi <= π/2, 0 <= m <= 1: by Carlson's symmetric
/// integrals, E = s R_F - m s³ R_D / 3 with s = sin phi (Carlson, Numer. Algorithms 10, 13 (1995), eq. 4.6).
pub(super) fn elliptic_e(phi: f64, m: f64) -> f64 {
    let (s, c) = libm::sincos(phi);
    let (x, y) = ((c * c).max(0.0), (1.0 - m * s * s).max(0.0));
    if y == 0.0 {
        // m = 1 at phi = π/2: the integrand is a cosine.
        return s;
    }
    s * carlson_f(x, y, 1.0) - m * s * s * s * carlson_d(x, y, 1.0) / 3.0
}

/// Rounds of duplication: each shrinks the differences to a quarter, so that after 30 the series needs no more terms.
const DUPLICATIONS: usize = 30;

fn carlson_f(mut x: f64, mut y: f64, mut z: f64) -> f64 {
    for _ in 0..DUPLICATIONS {
        let (a, b, c) = (x.sqrt(), y.sqrt(), z.sqrt());
        let lambda = a * b + b * c + c * a;
        (x, y, z) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
    }
    1.0 / ((x + y + z) / 3.0).sqrt()
}

fn carlson_d(mut x: f64, mut y: f64, mut z: f64) -> f64 {
    let (mut sum, mut factor) = (0.0, 1.0);
    for _ in 0..DUPLICATIONS {
        let (a, b, c) = (x.sqrt(), y.sqrt(), z.sqrt());
        let lambda = a * b + b * c + c * a;
        sum += factor / (c * (z + lambda));
        factor *= 0.25;
        (x, y, z) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
    }
    let mean = (x + y + 3.0 * z) / 5.0;
    3.0 * sum + factor / (mean * mean.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// E(π/4 | 0.5), E(π/2 | 0.5) and E(1 | 0.9): scipy.special.ellipeinc.
    #[test]
    fn elliptic_integrals_agree_with_tables() {
        for (phi, m, expected) in [
            (PI / 4.0, 0.5, 0.748_186_504_177_661_2),
            (PI / 2.0, 0.5, 1.350_643_881_047_675_5),
            (1.0, 0.9, 0.860_191_267_765_539_6),
            (PI / 2.0, 1.0, 1.0),
            (0.0, 0.3, 0.0),
        ] {
            let found = elliptic_e(phi, m);
            assert!((found - expected).abs() < 1e-14, "E({phi} | {m}) = {found}, not {expected}");
        }
    }

    #[test]
    fn a_square_root_at_the_end_is_integrated() {
        // The integral of sqrt(1 - x) from 0 to 1 is 2/3.
        let found = Quadrature::new().integrate(0.0, 1.0, |x| (1.0 - x).sqrt());
        assert!((found - 2.0 / 3.0).abs() < 1e-14, "{found}");
    }
}
