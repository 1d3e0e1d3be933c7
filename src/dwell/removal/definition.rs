//! The removal operator as it is defined: every sample against every pixel.
//!
//! In: samples, times or depths, a footprint, a window. Out: depths, or what the transpose makes of them. Exact and slow: for
//! few samples, and for what everything faster is compared with.

use super::{Samples, Window};
use crate::dwell::footprint::Footprint;
use rayon::prelude::*;

/// Depth on every pixel, by definition: `z(x, y) = sum over samples of rate(x - mu, y - eta) * time / samples`, the rate that of a
/// tool standing at (mu, eta).
pub fn deposit(samples: &Samples, times: &[f64], footprint: &Footprint, window: &Window) -> Vec<f64> {
    (0..window.len())
        .into_par_iter()
        .map(|i| {
            let [x, y] = window.position(i);
            let mut depth = 0.0;
            for (j, range) in samples.start.windows(2).enumerate() {
                let share = times[j] / (range[1] - range[0]) as f64;
                for s in range[0]..range[1] {
                    depth += share * footprint.rate_from([samples.x[s], samples.y[s]], [x, y]);
                }
            }
            depth
        })
        .collect()
}

/// The transpose of [`deposit`].
pub fn gather(samples: &Samples, depths: &[f64], footprint: &Footprint, window: &Window) -> Vec<f64> {
    (0..samples.start.len() - 1)
        .into_par_iter()
        .map(|j| {
            let range = samples.start[j]..samples.start[j + 1];
            let share = 1.0 / range.len() as f64;
            let mut sum = 0.0;
            for s in range {
                for (i, depth) in depths.iter().enumerate() {
                    let [x, y] = window.position(i);
                    sum += share * depth * footprint.rate_from([samples.x[s], samples.y[s]], [x, y]);
                }
            }
            sum
        })
        .collect()
}
