//! Correctable content: the part of the error that a tool can follow, and the part that is finer than it.
//!
//! In: the error in the clear aperture, the footprint. Out: a [`Correctable`].
//!
//! Frequencies at which the tool's [transfer function](super::Transfer) is at least [`SHARE`] belong to the tool. What no sum of
//! such waves can follow inside the clear aperture is finer than the tool: the residual of a least-squares fit. A spectrum
//! of the map alone would not do: cut off at the aperture's edge, the form itself leaks into every frequency.
//!
//! The fit runs from coarse to fine, by conjugate gradients on a filter at each stage: first waves much longer than the spot,
//! with what is left shorter ones, at last all that belong to the tool. In one stage the form would take hundreds of steps to be
//! followed up to the edge.

use super::Transfer;
use crate::dwell::Footprint;
use crate::dwell::field::Field;
use crate::dwell::removal::Window;
use crate::fourier::{Convolution, good_length};
use rayon::prelude::*;

/// The transfer below which a ripple counts as finer than the tool. No dwell is negative, so no dwell can be more rippled than
/// once up and down about its mean: to take off a ripple of height a where the transfer is h, a layer of at least a/h goes
/// beside it. At a tenth, taking off 10 nm costs 100 nm of glass, with errors of a few per cent of that as large as a third
/// of the ripple. (|t(f)| <= t(0) for the spectrum of anything that is nowhere negative.)
pub const SHARE: f64 = 0.1;

/// The transfer below which nobody follows a ripple. Taking off 10 nm there costs 1000 nm of glass, and a rate is known to 1 % at best:
/// the error of that layer is as large as the ripple.
pub const LEAST_SHARE: f64 = 0.01;

/// Bands and powers of the transfer function at the stages. A power of n widens a Gaussian spot by the root of n: from sixteen spots
/// to one; then the plain band. What is left after that is the finer part; the last two stages say how much of it a run that spares no
/// glass might still follow.
const STAGES: [(f64, i32); 6] = [(SHARE, 256), (SHARE, 64), (SHARE, 16), (SHARE, 4), (SHARE, 1), (SHARE, 0)];
const LAST_STAGES: [(f64, i32); 2] = [(LEAST_SHARE, 1), (LEAST_SHARE, 0)];

/// Steps a stage. Eight steps leave of the form less than 3e-4 of its RMS (measured on a strip of 190 mm by 16 mm and on discs of
/// 44 spot widths), below what is asked here.
const STEPS: usize = 8;

/// What a tool can follow of an error, over the clear aperture. Metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Correctable {
    /// Ripples shorter than this are finer than the tool: the transfer, averaged over the directions, is below [`SHARE`].
    pub period: f64,
    /// RMS of the part that the tool can follow.
    pub rms: f64,
    /// RMS of the part that is finer than the tool.
    pub finer_rms: f64,
    /// RMS of the part of it that no run follows, however much glass it takes.
    pub least_rms: f64,
}

impl Correctable {
    pub fn of(field: &Field, footprint: &Footprint) -> Correctable {
        let whole = field.rms();
        let [finer_rms, least_rms] = left_by_bands(field, footprint).map(|left| left.min(whole));
        Correctable {
            period: Transfer::of(footprint).period(SHARE),
            rms: (whole * whole - finer_rms * finer_rms).max(0.0).sqrt(),
            finer_rms,
            least_rms,
        }
    }

    /// RMS of the least residual when the share `fraction` of the error is to be taken off. The parts that a run follows and does not
    /// have no product: the second is the residual of a fit by the first.
    pub fn left(&self, fraction: f64) -> f64 {
        let followed = self.rms * self.rms + self.finer_rms * self.finer_rms - self.least_rms * self.least_rms;
        libm::hypot((1.0 - fraction) * followed.max(0.0).sqrt(), self.least_rms)
    }
}

/// A grid that holds a window with the reach of the spot around it, and lengths that a transform takes.
pub(super) struct Padded {
    pub rows: usize,
    pub columns: usize,
    /// The spot on it, its sum 1, the middle at (0, 0).
    pub kernel: Vec<f64>,
}

impl Padded {
    pub fn of(window: &Window, footprint: &Footprint) -> Padded {
        let reach = [0, 1].map(|axis| (footprint.radius / window.pixel[axis]).ceil() as usize + 1);
        let columns = good_length(window.columns + 2 * reach[0], true);
        let rows = good_length(window.rows + 2 * reach[1], false);
        let mut kernel = vec![0.0; rows * columns];
        for dr in -(reach[1] as i64)..=reach[1] as i64 {
            for dc in -(reach[0] as i64)..=reach[0] as i64 {
                let at = dr.rem_euclid(rows as i64) as usize * columns + dc.rem_euclid(columns as i64) as usize;
                kernel[at] += footprint.rate(dc as f64 * window.pixel[0], dr as f64 * window.pixel[1]);
            }
        }
        let sum: f64 = kernel.iter().sum();
        kernel.iter_mut().for_each(|value| *value /= sum);
        Padded { rows, columns, kernel }
    }

    /// The filter that passes `shape(H)` of each frequency, H being the tool's transfer there.
    pub fn filter(&self, shape: impl Fn(f64) -> f64 + Sync) -> Convolution {
        Convolution::shaped(self.rows, self.columns, &self.kernel, |[re, im]| [shape(libm::hypot(re, im)), 0.0])
    }

    /// `grid`, in the corner of which lies the window `coarse`, on the pixels of `fine`: between pixels by cubic convolution (R. Keys,
    /// "Cubic convolution interpolation for digital image processing", IEEE Trans. ASSP 29 (1981), a = -1/2).
    fn read(&self, grid: &[f64], coarse: &Window, fine: &Window) -> Vec<f64> {
        // The four pixels around each of the fine ones along an axis, with their weights.
        let taps = |axis: usize, count: usize, length: usize| -> Vec<[(usize, f64); 4]> {
            let tap = |k: usize| {
                let at = (fine.origin[axis] + k as f64 * fine.pixel[axis] - coarse.origin[axis]) / coarse.pixel[axis];
                let first = at.floor() as i64 - 1;
                let weights = keys(at - at.floor());
                [0, 1, 2, 3].map(|i| ((first + i as i64).rem_euclid(length as i64) as usize, weights[i]))
            };
            (0..count).map(tap).collect()
        };
        let (across, down) = (taps(0, fine.columns, self.columns), taps(1, fine.rows, self.rows));
        let mut values = vec![0.0; fine.len()];
        values.par_chunks_mut(fine.columns.max(1)).zip(&down).for_each(|(values, down)| {
            let row = |column: usize| down.iter().map(|(row, weight)| weight * grid[row * self.columns + column]).sum();
            let line: Vec<f64> = (0..self.columns).map(row).collect();
            for (value, across) in values.iter_mut().zip(&across) {
                *value = across.iter().map(|(column, weight)| weight * line[*column]).sum();
            }
        });
        values
    }

    /// `values` of the window in the grid's corner, zero elsewhere.
    pub fn pad(&self, values: &[f64], window: &Window) -> Vec<f64> {
        let mut padded = vec![0.0; self.rows * self.columns];
        for (row, values) in values.chunks_exact(window.columns).enumerate() {
            padded[row * self.columns..][..window.columns].copy_from_slice(values);
        }
        padded
    }
}

/// RMS, about the mean, of what the tool's band does not follow, and of what the widest band does not.
fn left_by_bands(field: &Field, footprint: &Footprint) -> [f64; 2] {
    // The band of a Gaussian ends at 2.9 sigma, the widest at 2.1: six and four of these pixels.
    let side = footprint.sigma / 2.0;
    let coarse = field.binned(side);
    let padded = Padded::of(&coarse.window, footprint);
    let weights = padded.pad(&coarse.weights, &coarse.window);
    let mut followed = vec![0.0; padded.kernel.len()];
    // What is left, on the map's own pixels: the mean over a coarse one that lies half outside is not the form in its middle.
    let left = |followed: &[f64]| {
        let mut left = padded.read(followed, &coarse.window, &field.window);
        for (left, value) in left.iter_mut().zip(&field.values) {
            *left = value - *left;
        }
        take_mean(&mut left, &field.weights);
        field.with_values(left)
    };
    let mut follow = |stages: &[(f64, i32)]| {
        for &(share, power) in stages {
            let mut left = padded.pad(&left(&followed).binned(side).values, &coarse.window);
            take_mean(&mut left, &weights);
            let shape = move |h: f64| if h < share { 0.0 } else { libm::pow(h, f64::from(power)) };
            fit(&mut padded.filter(shape), &weights, left, &mut followed);
        }
        left(&followed).rms()
    };
    [follow(&STAGES), follow(&LAST_STAGES)]
}

/// Weights of the pixels before, at, behind and two behind a place, `t` behind the second.
fn keys(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (-t3 + 2.0 * t2 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (-3.0 * t3 + 4.0 * t2 + t), 0.5 * (t3 - t2)]
}

fn take_mean(values: &mut [f64], weights: &[f64]) {
    let weight: f64 = weights.iter().sum();
    let mean = values.iter().zip(weights).map(|(v, w)| v * w).sum::<f64>() / weight;
    for (value, weight) in values.iter_mut().zip(weights) {
        *value = if *weight > 0.0 { *value - mean } else { 0.0 };
    }
}

/// Adds to `followed` what [`STEPS`] steps of conjugate gradients find of `left`: min over x of `Σ w (left - A x)²`, A the
/// filter, which is its own transpose.
fn fit(filter: &mut Convolution, weights: &[f64], mut left: Vec<f64>, followed: &mut [f64]) {
    let weighted = |values: &[f64]| -> Vec<f64> { values.iter().zip(weights).map(|(v, w)| v * w).collect() };
    let mut gradient = weighted(&left);
    filter.convolve(&mut gradient);
    let mut direction = gradient.clone();
    let mut square = dot(&gradient, &gradient, None);
    for _ in 0..STEPS {
        let mut moved = direction.clone();
        filter.convolve(&mut moved);
        let length = square / dot(&moved, &moved, Some(weights));
        // Nothing is left to be followed.
        if !length.is_finite() {
            return;
        }
        for ((left, followed), moved) in left.iter_mut().zip(followed.iter_mut()).zip(&moved) {
            *left -= length * moved;
            *followed += length * moved;
        }
        // The gradient anew, so that rounding does not pile up.
        gradient = weighted(&left);
        filter.convolve(&mut gradient);
        let next = dot(&gradient, &gradient, None);
        for (direction, gradient) in direction.iter_mut().zip(&gradient) {
            *direction = gradient + next / square * *direction;
        }
        square = next;
    }
}

fn dot(a: &[f64], b: &[f64], weights: Option<&[f64]>) -> f64 {
    match weights {
        Some(weights) => a.iter().zip(b).zip(weights).map(|((a, b), w)| w * a * b).sum(),
        None => a.iter().zip(b).map(|(a, b)| a * b).sum(),
    }
}
