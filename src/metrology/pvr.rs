//! PVr: a robust peak to valley.
//!
//! In: a map without piston and tilt, which of its pixels count, a set of Zernike polynomials. Out: [`Pvr`]: the peak to
//! valley of the fit with 36 terms, sampled on the pixels, and three times the RMS of what the fit leaves (Evans, "PVr – a
//! robust amplitude parameter for optical surface specification", Optical Engineering 48, 2009). Single pixels of dirt
//! hardly change it.
//!
//! The two usual sets of 36 differ (7 % on a map of one wave), so the figure is named with its set. Neither centre nor
//! radius of the polynomials matters: both sets span the same surfaces wherever they stand.

use super::{ZernikeFit, zernike_fit};
use crate::height_map::Grid;
use crate::job::ZernikeOrder;

/// Terms of the fit.
const TERMS: usize = 36;

/// PVr and its two parts, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pvr {
    pub pvr: f64,
    /// Of the fit on the pixels that count.
    pub pv_of_fit: f64,
    /// Of what the fit leaves.
    pub rms_of_residual: f64,
}

/// Of the known pixels marked in `counts`. `None` where they do not fix 36 terms.
pub fn pvr(grid: &Grid, counts: &[bool], order: ZernikeOrder) -> Option<Pvr> {
    robust_fit(grid, counts, order).map(|fit| Pvr::of(&fit))
}

/// The fit that PVr is made from, on the circle that the box around the pixels holds.
pub(super) fn robust_fit(grid: &Grid, counts: &[bool], order: ZernikeOrder) -> Option<ZernikeFit> {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for i in (0..grid.values.len()).filter(|i| counts[*i] && !grid.values[*i].is_nan()) {
        let at = grid.position(i / grid.columns, i % grid.columns);
        low = [0, 1].map(|k| low[k].min(at[k]));
        high = [0, 1].map(|k| high[k].max(at[k]));
    }
    let centre = [0, 1].map(|k| (low[k] + high[k]) / 2.0);
    let radius = (high[0] - low[0]).max(high[1] - low[1]) / 2.0;
    zernike_fit(grid, counts, order, TERMS, centre, radius)
}

impl Pvr {
    /// Of a fit with 36 terms.
    pub(super) fn of(fit: &ZernikeFit) -> Pvr {
        let pv_of_fit = fit.range_of_fit[1] - fit.range_of_fit[0];
        let rms_of_residual = fit.rms_of_residual;
        Pvr { pvr: pv_of_fit + 3.0 * rms_of_residual, pv_of_fit, rms_of_residual }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: usize, height: impl Fn(f64, f64) -> f64) -> Grid {
        let mut grid = Grid { columns: n, rows: n, pixel: [1e-3; 2], origin: [0.1, -0.3], values: Vec::new() };
        for i in 0..n * n {
            let [x, y] = grid.position(i / n, i % n);
            grid.values.push(height(x - 0.1, y + 0.3));
        }
        grid
    }

    #[test]
    fn a_surface_of_the_set_leaves_nothing() {
        // Both sets hold all polynomials of fifth degree in x and y.
        // Heights of about a metre, which the rounding of the coefficients to a femtometre does not touch.
        let map = grid(30, |x, y| 1e9 * x * x * y * y * y + x);
        let everywhere = vec![true; 900];
        for order in [ZernikeOrder::fringe, ZernikeOrder::noll] {
            let found = pvr(&map, &everywhere, order).expect("enough pixels");
            let (low, high) =
                map.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
            assert!((found.pv_of_fit - (high - low)).abs() < 1e-12 * (high - low));
            assert!(found.rms_of_residual < 1e-12 * (high - low));
        }
    }

    #[test]
    fn a_speck_adds_three_of_its_rms() {
        // One pixel of 900 stands 1 um out of a plane: the fit takes little of it, the RMS is 1 um / 30.
        let mut map = grid(30, |_, _| 0.0);
        map.values[435] = 1e-6;
        let found = pvr(&map, &[true; 900], ZernikeOrder::fringe).expect("enough pixels");
        assert!((found.rms_of_residual - 1e-6 / 30.0).abs() < 2e-9, "{found:?}");
        assert!(found.pvr < 0.2e-6);
    }

    #[test]
    fn too_few_pixels_have_none() {
        assert_eq!(pvr(&grid(5, |x, _| x), &[true; 25], ZernikeOrder::fringe), None);
        let line: Vec<bool> = (0..900).map(|i| i / 30 == 7).collect();
        assert_eq!(pvr(&grid(30, |x, _| x), &line, ZernikeOrder::fringe), None);
        assert_eq!(pvr(&grid(30, |x, _| x), &[false; 900], ZernikeOrder::fringe), None);
    }
}
