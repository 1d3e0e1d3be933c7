//! The removal operator: times on the path to depths on a grid, and its transpose.
//!
//! In: where the time of each unknown is spent ([`Samples`]), the [`Footprint`], a grid. Out: depths, and by the
//! transpose the sensitivity of each unknown.
//!
//! Two writings. [`deposit`] and [`gather`] are the definition: every sample against every pixel, exact and slow, what
//! the tests compare with. [`Removal`] spreads each sample over the pixels around it and convolves: exact as a pair of operator
//! and transpose, within a few parts in 100,000 of the definition where the pixel is at most a quarter of the spot's sigma, and
//! the solver's only choice for large problems.

mod definition;
mod samples;
mod spread;

pub use definition::{deposit, gather};
pub use samples::{Samples, Window, ends, parts, segments};
pub use spread::Spread;

use super::descent::LinearOperator;
use super::footprint::Footprint;
use super::vectors::each;
use crate::fourier::{Convolution, good_length};
use rayon::prelude::*;

/// Spreading and convolution, on a window padded so that nothing wraps round into it.
pub struct Removal {
    window: Window,
    spread: Spread,
    /// Pixels of padding before the window, columns and rows.
    margin: [usize; 2],
    /// Columns of the padded grid.
    columns: usize,
    /// One a part of the influence.
    convolutions: Vec<Convolution>,
    /// Upper left pixel of those that each sample is spread over, in the padded grid, and the place inside the pixel; of the
    /// samples that can reach the window.
    corner: Vec<u32>,
    fraction_x: Vec<f64>,
    fraction_y: Vec<f64>,
    /// Weights of the parts at each sample; empty where there is one part.
    parts: Vec<f64>,
    /// Reaching samples of unknown `i` are `start[i] .. start[i + 1]`.
    start: Vec<usize>,
    /// The unknown of each sample.
    unknown: Vec<u32>,
    /// The samples by bands of rows, in their order inside; those of band `b` are `band[b] .. band[b + 1]`.
    by_band: Vec<u32>,
    band: Vec<usize>,
    /// One over the number of all samples of the unknown.
    share: Vec<f64>,
    /// What the depth on each pixel of the window is multiplied with; empty for 1.
    row_factors: Vec<f64>,
    padded: Vec<f64>,
}

/// Unknowns that one task gathers: enough work to be worth a task, the same for any number of threads.
const GATHER_CHUNK: usize = 4096;

/// Rows of a band, which one task spreads samples into; at least as many as a sample is spread over.
const BAND: usize = 16;

impl Removal {
    /// With cubic splines: what a solver asks for.
    pub fn new(samples: &Samples, footprint: &Footprint, window: Window) -> Removal {
        Removal::spreading(Spread::Cubic, samples, footprint, window)
    }

    pub fn spreading(spread: Spread, samples: &Samples, footprint: &Footprint, window: Window) -> Removal {
        // A sample farther than the margin from the window reaches no pixel of it, even spread; what wraps round lands in
        // the padding.
        let reach = [0, 1].map(|axis| (footprint.radius / window.pixel[axis]).ceil() as usize);
        let margin = reach.map(|pixels| pixels + spread.width() / 2);
        let columns = good_length(window.columns + 2 * margin[0], true);
        let rows = good_length(window.rows + 2 * margin[1], false);
        let range = |pixels: usize| -(pixels as i64)..=pixels as i64;
        let mut kernel = vec![0.0; rows * columns];
        let convolutions = (0..footprint.parts())
            .map(|part| {
                kernel.fill(0.0);
                for dr in range(reach[1]) {
                    for dc in range(reach[0]) {
                        let row = dr.rem_euclid(rows as i64) as usize;
                        let column = dc.rem_euclid(columns as i64) as usize;
                        kernel[row * columns + column] +=
                            footprint.rate_of(part, dc as f64 * window.pixel[0], dr as f64 * window.pixel[1]);
                    }
                }
                spread.coefficients(&mut kernel, columns);
                for row in kernel.chunks_exact_mut(columns) {
                    spread.coefficients(row, 1);
                }
                Convolution::new(rows, columns, &kernel)
            })
            .collect();
        let mut removal = Removal {
            window,
            spread,
            margin,
            columns,
            convolutions,
            corner: Vec::with_capacity(samples.x.len()),
            fraction_x: Vec::with_capacity(samples.x.len()),
            fraction_y: Vec::with_capacity(samples.x.len()),
            parts: Vec::new(),
            start: vec![0],
            unknown: Vec::with_capacity(samples.x.len()),
            by_band: Vec::new(),
            band: Vec::new(),
            share: Vec::with_capacity(samples.start.len()),
            row_factors: Vec::new(),
            padded: kernel,
        };
        let mut weights = vec![1.0; footprint.parts()];
        for (unknown, range) in samples.start.windows(2).enumerate() {
            for s in range[0]..range[1] {
                if removal.add_sample(samples.x[s], samples.y[s]) {
                    removal.unknown.push(unknown as u32);
                    if weights.len() > 1 {
                        footprint.weights(samples.x[s], samples.y[s], &mut weights);
                        removal.parts.extend(&weights);
                    }
                }
            }
            removal.start.push(removal.corner.len());
            removal.share.push(1.0 / (range[1] - range[0]) as f64);
        }
        removal.sort_into_bands(rows);
        removal
    }

    /// The same on a sloping surface, to first order: `cosines` of the slope, one a pixel, or none for a plane. The kernel of
    /// the plane takes its volume from the area across the part's axis, the glass there is larger by one over the cosine.
    pub fn on_slopes(mut self, cosines: Vec<f64>) -> Removal {
        self.row_factors = cosines;
        self
    }

    /// Whether the sample reaches the window; then it is kept.
    fn add_sample(&mut self, x: f64, y: f64) -> bool {
        let half = self.spread.width() / 2;
        let place = |axis: usize, at: f64| {
            let place = (at - self.window.origin[axis]) / self.window.pixel[axis] + self.margin[axis] as f64;
            let size = [self.window.columns, self.window.rows][axis] + 2 * self.margin[axis];
            let inside = place >= (half - 1) as f64 && place < (size - half) as f64;
            inside.then(|| (place.floor() as usize - (half - 1), place - place.floor()))
        };
        let (Some((column, fraction_x)), Some((row, fraction_y))) = (place(0, x), place(1, y)) else { return false };
        self.corner.push((row * self.columns + column) as u32);
        self.fraction_x.push(fraction_x);
        self.fraction_y.push(fraction_y);
        true
    }

    fn sort_into_bands(&mut self, rows: usize) {
        let band = |corner: u32| corner as usize / (self.columns * BAND);
        let mut next = vec![0; rows.div_ceil(BAND) + 1];
        for corner in &self.corner {
            next[band(*corner) + 1] += 1;
        }
        for b in 1..next.len() {
            next[b] += next[b - 1];
        }
        self.band = next.clone();
        self.by_band = vec![0; self.corner.len()];
        for (sample, corner) in self.corner.iter().enumerate() {
            let place = &mut next[band(*corner)];
            self.by_band[*place] = sample as u32;
            *place += 1;
        }
    }

    /// Spreads the times over the padded grid, with the weights of one part. Bands are filled two by two: a sample of a band
    /// may spread into the next one, which nobody else fills meanwhile.
    fn spread(&self, times: &[f64], part: usize, padded: &mut [f64]) {
        match self.spread {
            Spread::Linear => self.spread_over::<2>(times, part, padded),
            Spread::Cubic => self.spread_over::<4>(times, part, padded),
        }
    }

    /// Over `N` x `N` pixels: known to the compiler, which writes the inner loops out.
    fn spread_over<const N: usize>(&self, times: &[f64], part: usize, padded: &mut [f64]) {
        padded.par_chunks_mut(BAND * self.columns).for_each(|rows| rows.fill(0.0));
        for parity in 0..2 {
            let from = (parity * BAND * self.columns).min(padded.len());
            padded[from..].par_chunks_mut(2 * BAND * self.columns).enumerate().for_each(|(pair, rows)| {
                let band = 2 * pair + parity;
                let first = band * BAND * self.columns;
                for &sample in &self.by_band[self.band[band]..self.band[band + 1]] {
                    let sample = sample as usize;
                    let unknown = self.unknown[sample] as usize;
                    let time = times[unknown] * self.share[unknown] * self.part(sample, part);
                    if time == 0.0 {
                        continue;
                    }
                    let across = self.spread.weights(self.fraction_y[sample]);
                    let along = self.spread.weights(self.fraction_x[sample]);
                    let corner = self.corner[sample] as usize - first;
                    for (k, across) in across[..N].iter().enumerate() {
                        let weight = time * across;
                        let row = &mut rows[corner + k * self.columns..][..N];
                        for i in 0..N {
                            row[i] += weight * along[i];
                        }
                    }
                }
            });
        }
    }

    fn part(&self, sample: usize, part: usize) -> f64 {
        if self.parts.is_empty() { 1.0 } else { self.parts[sample * self.convolutions.len() + part] }
    }

    /// The value of the padded grid at a sample.
    fn read<const N: usize>(&self, sample: usize, padded: &[f64]) -> f64 {
        let across = self.spread.weights(self.fraction_y[sample]);
        let along = self.spread.weights(self.fraction_x[sample]);
        let corner = self.corner[sample] as usize;
        let mut sums = [0.0; N];
        for (k, across) in across[..N].iter().enumerate() {
            let row = &padded[corner + k * self.columns..][..N];
            for i in 0..N {
                sums[i] += across * row[i];
            }
        }
        (0..N).map(|i| sums[i] * along[i]).sum()
    }

    /// Adds to the times what the padded grid is at their samples, with the weights of one part.
    fn gather_from<const N: usize>(&self, padded: &[f64], part: usize, times: &mut [f64]) {
        times.par_chunks_mut(GATHER_CHUNK).enumerate().for_each(|(chunk, times)| {
            for (i, time) in times.iter_mut().enumerate() {
                let unknown = chunk * GATHER_CHUNK + i;
                let samples = self.start[unknown]..self.start[unknown + 1];
                let sum: f64 = samples.map(|s| self.part(s, part) * self.read::<N>(s, padded)).sum();
                *time += sum * self.share[unknown];
            }
        });
    }
}

impl LinearOperator for Removal {
    fn unknowns(&self) -> usize {
        self.share.len()
    }

    fn rows(&self) -> usize {
        self.window.len()
    }

    fn forward(&mut self, times: &[f64], depths: &mut [f64]) {
        let mut padded = std::mem::take(&mut self.padded);
        for part in 0..self.convolutions.len() {
            self.spread(times, part, &mut padded);
            self.convolutions[part].convolve(&mut padded);
            depths.par_chunks_exact_mut(self.window.columns).enumerate().for_each(|(row, line)| {
                let from = (row + self.margin[1]) * self.columns + self.margin[0];
                let removed = &padded[from..from + line.len()];
                if part == 0 {
                    line.copy_from_slice(removed);
                } else {
                    line.iter_mut().zip(removed).for_each(|(depth, removed)| *depth += removed);
                }
            });
        }
        if !self.row_factors.is_empty() {
            each(depths, |i, depth| *depth *= self.row_factors[i]);
        }
        self.padded = padded;
    }

    fn transpose(&mut self, depths: &[f64], times: &mut [f64]) {
        let mut padded = std::mem::take(&mut self.padded);
        times.fill(0.0);
        for part in 0..self.convolutions.len() {
            let (columns, rows) = (self.window.columns, self.window.rows);
            padded.par_chunks_exact_mut(self.columns).enumerate().for_each(|(row, line)| {
                line.fill(0.0);
                let row = row.wrapping_sub(self.margin[1]);
                if row < rows {
                    let here = row * columns..(row + 1) * columns;
                    let line = &mut line[self.margin[0]..][..columns];
                    line.copy_from_slice(&depths[here.clone()]);
                    if let Some(factors) = self.row_factors.get(here) {
                        line.iter_mut().zip(factors).for_each(|(depth, factor)| *depth *= factor);
                    }
                }
            });
            self.convolutions[part].correlate(&mut padded);
            match self.spread {
                Spread::Linear => self.gather_from::<2>(&padded, part, times),
                Spread::Cubic => self.gather_from::<4>(&padded, part, times),
            }
        }
        self.padded = padded;
    }
}

#[cfg(test)]
mod tests {
    use super::super::footprint::examples::{gaussian, two_parts};
    use super::*;
    use crate::path::{Line, Link, ToolPath};
    use proptest::prelude::*;

    const SIGMA: f64 = 2e-3;

    fn window(columns: usize, rows: usize, pixel: f64) -> Window {
        let origin = [columns, rows].map(|n| -0.5 * (n as f64 - 1.0) * pixel);
        Window { columns, rows, pixel: [pixel; 2], origin }
    }

    /// Lines of a few bends, so that segments point everywhere.
    fn path(places: &[(f64, f64)]) -> ToolPath {
        let mut path = ToolPath::default();
        for line in places.chunks(4) {
            let start = path.points.len();
            for (x, y) in line {
                path.points.push([*x, *y, 0.0], [0.0, 0.0, 1.0]);
            }
            path.lines.push(Line { points: start..path.points.len(), link: Link::Lifted });
        }
        path
    }

    fn dot(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    proptest! {
        // The pair must be exact for any path, also for one that leaves the window: the solver's gradient relies on it.
        #[test]
        fn operator_and_transpose_are_a_pair(
            places in prop::collection::vec((-0.03f64..0.03, -0.03f64..0.03), 8..24),
            seed in prop::collection::vec(-1.0f64..1.0, 30 * 24),
            times in prop::collection::vec(0.0f64..2.0, 24),
        ) {
            let footprint = gaussian(1e-8, SIGMA, 6e-3);
            let samples = Samples::segments(&path(&places), SIGMA / 2.0);
            let mut operator = Removal::new(&samples, &footprint, window(30, 24, 0.9e-3));
            let times = &times[..operator.unknowns()];
            let (mut depths, mut back) = (vec![0.0; operator.rows()], vec![0.0; operator.unknowns()]);
            operator.forward(times, &mut depths);
            operator.transpose(&seed, &mut back);
            // The transform rounds relative to the deepest place of the whole padded plane, which may lie outside the window.
            let deepest = 1e-8 * times.iter().sum::<f64>();
            let size = (dot(&depths, &depths).sqrt() + deepest) * dot(&seed, &seed).sqrt();
            prop_assert!((dot(&depths, &seed) - dot(times, &back)).abs() <= 1e-12 * size);
        }

        #[test]
        fn the_definition_is_a_pair_too(
            places in prop::collection::vec((-0.02f64..0.02, -0.02f64..0.02), 8),
            seed in prop::collection::vec(-1.0f64..1.0, 20 * 20),
        ) {
            let footprint = gaussian(1e-8, SIGMA, 6e-3);
            let samples = Samples::segments(&path(&places), SIGMA / 2.0);
            let window = window(20, 20, 1e-3);
            let times = vec![1.0, 0.5, 2.0, 0.25, 1.5, 0.75];
            let depths = deposit(&samples, &times, &footprint, &window);
            let back = gather(&samples, &seed, &footprint, &window);
            let size = dot(&depths, &depths).sqrt() * dot(&seed, &seed).sqrt();
            prop_assert!((dot(&depths, &seed) - dot(&times, &back)).abs() <= 1e-12 * size);
        }
    }

    #[test]
    fn a_window_sees_the_same_as_a_larger_one() {
        // What lies outside must neither wrap round nor be forgotten: the small window is a part of the large one.
        let footprint = gaussian(1e-8, SIGMA, 6e-3);
        let samples =
            Samples::segments(&path(&[(-0.03, -0.02), (0.0, 0.012), (0.03, 0.0), (-0.01, -0.011)]), SIGMA / 2.0);
        let (small, large) = (window(20, 16, 1e-3), window(100, 90, 1e-3));
        let depths = |window: Window| {
            let mut operator = Removal::new(&samples, &footprint, window);
            let mut depths = vec![0.0; window.len()];
            operator.forward(&[1.0, 2.0, 3.0], &mut depths);
            depths
        };
        let (found, all) = (depths(small), depths(large));
        for row in 0..16 {
            for column in 0..20 {
                let (a, b) = (found[row * 20 + column], all[(row + 37) * 100 + column + 40]);
                // Beyond its rim the spline of a spot that is cut at 1.1 % of its peak still rings, by a factor of 0.27 a pixel, which
                // the margin of the small window leaves out.
                assert!((a - b).abs() < 1e-4 * 1e-8, "{row} {column}: {a} {b}");
            }
        }
    }

    #[test]
    fn spreading_costs_what_the_interpolation_costs() {
        // A Gaussian, cut where it no longer matters (4e-6 of the peak), on pixels of h = 0.24 sigma. Between pixels linear
        // interpolation is off by h²/8 of the second derivative, at most 1/sigma² of the peak, cubic by h⁴/384 of the fourth, at
        // most 3/sigma⁴: 0.72 % and 2.6e-5 along each axis. A covered area averages over places of both signs.
        let footprint = gaussian(1e-8, SIGMA, 10e-3);
        let places: Vec<(f64, f64)> =
            (0..160).map(|i| ((i % 4) as f64 * 7e-3 - 10.5e-3, (i / 4) as f64 * 0.5e-3 - 9.7e-3)).collect();
        let samples = Samples::segments(&path(&places), SIGMA / 2.0);
        let window = window(41, 41, 0.24 * SIGMA);
        let times: Vec<f64> = (0..120).map(|i| 1.0 + libm::sin(i as f64 * 0.3)).collect();
        let exact = deposit(&samples, &times, &footprint, &window);
        let greatest = exact.iter().fold(0.0f64, |m, d| m.max(*d));
        for (spread, bound) in [(Spread::Linear, 1.44e-2), (Spread::Cubic, 5.2e-5)] {
            let mut operator = Removal::spreading(spread, &samples, &footprint, window);
            let mut found = vec![0.0; window.len()];
            operator.forward(&times, &mut found);
            let worst = exact.iter().zip(&found).fold(0.0f64, |m, (e, f)| m.max((e - f).abs()));
            assert!(worst < bound * greatest, "{spread:?}: {}", worst / greatest);
        }
    }

    #[test]
    fn on_pixels_it_is_the_definition() {
        // Both splines go through the values on pixels: samples on pixels, the cut of the spot and all.
        let footprint = gaussian(1e-8, SIGMA, 6e-3);
        let window = window(30, 25, 0.7e-3);
        let samples = Samples::points(
            &[window.position(3)[0], window.position(400)[0]],
            &[window.position(3)[1], window.position(400)[1]],
        );
        let exact = deposit(&samples, &[1.0, 2.0], &footprint, &window);
        for spread in [Spread::Linear, Spread::Cubic] {
            let mut found = vec![0.0; window.len()];
            Removal::spreading(spread, &samples, &footprint, window).forward(&[1.0, 2.0], &mut found);
            for (exact, found) in exact.iter().zip(&found) {
                assert!((exact - found).abs() < 1e-12 * 1e-8, "{spread:?}: {exact} {found}");
            }
        }
    }

    #[test]
    fn a_tool_that_changes_over_the_part_is_the_sum_of_its_parts() {
        // Two Gaussians, the weight of the second growing along x. By the definition, and as a pair.
        let footprint = two_parts();
        let places: Vec<(f64, f64)> =
            (0..40).map(|i| ((i % 4) as f64 * 7e-3 - 10.5e-3, (i / 4) as f64 * 2e-3 - 9.7e-3)).collect();
        let samples = Samples::segments(&path(&places), SIGMA / 2.0);
        let window = window(41, 41, 0.24 * SIGMA);
        let times: Vec<f64> = (0..30).map(|i| 1.0 + libm::sin(i as f64 * 0.3)).collect();
        let exact = deposit(&samples, &times, &footprint, &window);
        let mut operator = Removal::new(&samples, &footprint, window);
        let (mut found, mut back) = (vec![0.0; window.len()], vec![0.0; 30]);
        operator.forward(&times, &mut found);
        let greatest = exact.iter().fold(0.0f64, |m, d| m.max(*d));
        let worst = exact.iter().zip(&found).fold(0.0f64, |m, (e, f)| m.max((e - f).abs()));
        assert!(worst < 2e-4 * greatest, "{}", worst / greatest);
        let seed: Vec<f64> = (0..window.len()).map(|i| libm::cos(i as f64)).collect();
        operator.transpose(&seed, &mut back);
        assert!((dot(&found, &seed) - dot(&times, &back)).abs() < 1e-12 * dot(&found, &found).sqrt() * 41.0);
    }

    #[test]
    fn a_segment_spends_its_time_evenly() {
        // 5 mm in parts of at most 2 mm: three, with middles at 5/6, 15/6 and 25/6 mm.
        let samples = Samples::segments(&path(&[(0.0, 0.0), (3e-3, 4e-3)]), 2e-3);
        assert_eq!(samples.start, [0, 3]);
        for (k, along) in [5.0 / 6.0, 15.0 / 6.0, 25.0 / 6.0].into_iter().enumerate() {
            assert!((samples.x[k] - 0.6e-3 * along).abs() < 1e-15 && (samples.y[k] - 0.8e-3 * along).abs() < 1e-15);
        }
    }
}
