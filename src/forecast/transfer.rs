//! Transfer function of a tool: how much of a ripple of each period its dwell can make.
//!
//! In: a [`Footprint`]. Out: `H(f) = |∫ R exp(-2 pi i f·x) dx dy| / V`, without dimension, 1 for long periods. A dwell that
//! changes as a ripple of frequency f removes a ripple H(f) times as strong. For a round spot it is the Hankel transform
//! `2 pi ∫ R(s) J0(2 pi s / L) s ds / V` at the period L, for a Gaussian `exp(-2 pi² sigma² / L²)`.

use crate::dwell::Footprint;
use std::f64::consts::PI;

/// Samples in a sigma, along each axis. The sum over a square lattice of step h is exact up to what the spot holds at
/// frequencies beyond 1/h: of a Gaussian exp(-2 pi² 36), of a rim that is cut at 1 % of the peak less than a thousandth.
const SAMPLES_IN_SIGMA: f64 = 6.0;

/// Directions of the average. A ripple and its opposite are the same, so they share half a turn; a spot four times as long
/// as wide changes over 20 degrees.
const DIRECTIONS: usize = 16;

/// The spot on a lattice, its sum 1.
pub struct Transfer {
    samples: Vec<[f64; 3]>,
    radius: f64,
    step: f64,
}

impl Transfer {
    pub fn of(footprint: &Footprint) -> Transfer {
        let step = footprint.sigma / SAMPLES_IN_SIGMA;
        let half = (footprint.radius / step).ceil() as i64;
        let mut samples = Vec::new();
        for row in -half..=half {
            for column in -half..=half {
                let (x, y) = (column as f64 * step, row as f64 * step);
                let rate = footprint.rate(x, y);
                if rate != 0.0 {
                    samples.push([x, y, rate]);
                }
            }
        }
        let sum: f64 = samples.iter().map(|[_, _, rate]| rate).sum();
        for sample in &mut samples {
            sample[2] /= sum;
        }
        Transfer { samples, radius: footprint.radius, step }
    }

    /// H at the frequency `(fx, fy)`, one over metres.
    pub fn at(&self, [fx, fy]: [f64; 2]) -> f64 {
        let (mut re, mut im) = (0.0, 0.0);
        for [x, y, weight] in &self.samples {
            let (sine, cosine) = libm::sincos(2.0 * PI * (fx * x + fy * y));
            re += weight * cosine;
            im += weight * sine;
        }
        libm::hypot(re, im)
    }

    /// H of the period, metres, averaged over all directions.
    pub fn average(&self, period: f64) -> f64 {
        let at = |k: usize| {
            let (sine, cosine) = libm::sincos(PI * k as f64 / DIRECTIONS as f64);
            self.at([cosine / period, sine / period])
        };
        (0..DIRECTIONS).map(at).sum::<f64>() / DIRECTIONS as f64
    }

    /// The longest period at which the average falls to `share`, metres, to a thousandth.
    pub fn period(&self, share: f64) -> f64 {
        // At a period of 40 radii every spot passes more than 95 %: its second moment is at most half its radius squared
        // an axis.
        let mut long = 40.0 * self.radius;
        let mut short = long;
        while self.average(short) >= share {
            long = short;
            short /= 1.1;
            // Finer than the samples nothing can be said; no spot reaches here with a share that matters.
            if short < 4.0 * self.step {
                return short;
            }
        }
        while long / short > 1.001 {
            let middle = (long * short).sqrt();
            if self.average(middle) >= share { long = middle } else { short = middle }
        }
        (long * short).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gaussian(sigma: [f64; 2], radius: f64) -> Footprint<'static> {
        let [sx, sy] = sigma;
        let rate = move |x: f64, y: f64| {
            if x * x + y * y > radius * radius {
                return 0.0;
            }
            1e-8 * libm::exp(-x * x / (2.0 * sx * sx) - y * y / (2.0 * sy * sy))
        };
        Footprint::new(rate, radius, 2.0 * PI * sx * sy * 1e-8, sx.min(sy))
    }

    #[test]
    fn a_gaussian_has_its_known_transfer() {
        // exp(-2 pi² sigma² / L²), and 10 % at L = pi sigma sqrt(2 / ln 10).
        let transfer = Transfer::of(&gaussian([2e-3; 2], 12e-3));
        for period in [5e-3, 8e-3, 20e-3] {
            let expected = libm::exp(-2.0 * PI * PI * 4e-6 / (period * period));
            assert!((transfer.average(period) - expected).abs() < 1e-6, "{period}: {}", transfer.average(period));
        }
        let expected = PI * 2e-3 * (2.0 / std::f64::consts::LN_10).sqrt();
        assert!((transfer.period(0.1) / expected - 1.0).abs() < 1e-3, "{}", transfer.period(0.1));
    }

    #[test]
    fn a_disc_has_its_known_transfer() {
        // 2 J1(u)/u with u = 2 pi a / L; the edge of the disc on the lattice is worth 1 % at these periods.
        let a = 5e-3;
        let disc =
            Footprint::new(move |x, y| if x * x + y * y <= a * a { 1e-8 } else { 0.0 }, a, PI * a * a * 1e-8, 1e-3);
        let transfer = Transfer::of(&disc);
        for period in [12e-3, 20e-3, 50e-3] {
            let u = 2.0 * PI * a / period;
            let expected = 2.0 * libm::j1(u) / u;
            assert!((transfer.average(period) - expected.abs()).abs() < 0.01, "{period}: {}", transfer.average(period));
        }
    }

    #[test]
    fn a_long_spot_differs_by_direction() {
        let transfer = Transfer::of(&gaussian([4e-3, 1e-3], 16e-3));
        let along = transfer.at([1.0 / 10e-3, 0.0]);
        let across = transfer.at([0.0, 1.0 / 10e-3]);
        assert!((along - libm::exp(-2.0 * PI * PI * 0.16)).abs() < 1e-3, "{along}");
        assert!((across - libm::exp(-2.0 * PI * PI * 0.01)).abs() < 1e-3, "{across}");
    }
}
