//! Zernike fit: a map as a sum of Zernike polynomials.
//!
//! In: a grid, which of its pixels count, the numbering, how many polynomials, and the circle that they are normalised on.
//! Out: [`ZernikeFit`]. All polynomials are fitted jointly over the pixels, whatever their outline; over an annulus these
//! are the polynomials of the full disc, fitted on the annulus, not the annular polynomials of Mahajan.

use super::fit::Fit;
use crate::height_map::Grid;
use crate::job::ZernikeOrder;
use crate::workpiece::form::zernike::Basis;
use rayon::prelude::*;

/// Pixels that one thread sums at a time; sums are put together in order.
const CHUNK: usize = 8192;

/// A joint least-squares fit.
#[derive(Clone, Debug, PartialEq)]
pub struct ZernikeFit {
    pub order: ZernikeOrder,
    /// The circle that the polynomials are normalised on, metres.
    pub centre: [f64; 2],
    pub radius: f64,
    /// In the unit of the map, from the first polynomial of the order on, rounded to 1e-15 of it.
    pub coefficients: Vec<f64>,
    /// Lowest and highest value of the fit on the pixels.
    pub range_of_fit: [f64; 2],
    /// Root mean square of what the fit leaves.
    pub rms_of_residual: f64,
}

/// Fits the first `terms` polynomials over the known pixels marked in `counts`. `None` where these do not fix them.
pub fn zernike_fit(
    grid: &Grid,
    counts: &[bool],
    order: ZernikeOrder,
    terms: usize,
    centre: [f64; 2],
    radius: f64,
) -> Option<ZernikeFit> {
    if !(radius > 0.0) {
        return None;
    }
    let basis = Basis::new(order, terms);
    let at = |[x, y]: [f64; 2], out: &mut [f64]| basis.at((x - centre[0]) / radius, (y - centre[1]) / radius, out);
    let fit = Fit::over(grid, counts, terms, at);
    let coefficients = fit.coefficients(|_| true)?;
    let used = |i: &usize| counts[*i] && !grid.values[*i].is_nan();
    let part = |chunk: usize| {
        let (mut low, mut high, mut squares) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        let mut values = vec![0.0; terms];
        for i in (chunk * CHUNK..((chunk + 1) * CHUNK).min(grid.values.len())).filter(used) {
            at(grid.position(i / grid.columns, i % grid.columns), &mut values);
            let sum: f64 = coefficients.iter().zip(&values).map(|(a, z)| a * z).sum();
            low = low.min(sum);
            high = high.max(sum);
            squares += (grid.values[i] - sum) * (grid.values[i] - sum);
        }
        (low, high, squares)
    };
    let parts: Vec<(f64, f64, f64)> = (0..grid.values.len().div_ceil(CHUNK)).into_par_iter().map(part).collect();
    let start = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    let (low, high, squares) = parts.into_iter().fold(start, |a, b| (a.0.min(b.0), a.1.max(b.1), a.2 + b.2));
    let rms_of_residual = (squares / fit.count as f64).sqrt();
    Some(ZernikeFit { order, centre, radius, coefficients, range_of_fit: [low, high], rms_of_residual })
}
