//! The removal operator: times on the path to depths on a grid, and its transpose.
//!
//! In: where the time of each unknown is spent ([`Samples`]), the [`Footprint`], a grid. Out: depths, and by the
//! transpose the sensitivity of each unknown.
//!
//! Two writings. [`deposit`] and [`gather`] are the definition: every sample against every pixel, exact and slow, what
//! the tests compare with. [`Removal`] spreads each sample bilinearly on the four pixels around it and convolves: exact
//! as a pair of operator and transpose, within a few parts in a thousand of the definition where the pixel is at most a
//! quarter of the spot's sigma (bilinear spreading widens the spot by a sixth of a squared pixel in variance), and the
//! solver's only choice for large problems.

use super::footprint::Footprint;
use super::least_squares::LinearOperator;
use crate::fourier::{Convolution, good_length};
use crate::height_map::Grid;
use crate::path::ToolPath;
use rayon::prelude::*;

/// The pixels that depths are asked on; the geometry of a [`Grid`] without its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    pub columns: usize,
    pub rows: usize,
    /// Metres.
    pub pixel: [f64; 2],
    /// Centre of pixel (0, 0), metres.
    pub origin: [f64; 2],
}

impl Window {
    /// Of a grid.
    pub fn of(grid: &Grid) -> Window {
        Window { columns: grid.columns, rows: grid.rows, pixel: grid.pixel, origin: grid.origin }
    }

    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Whether it has no pixel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Centre of pixel `i`, row-major, metres.
    pub fn position(&self, i: usize) -> [f64; 2] {
        let (row, column) = (i / self.columns, i % self.columns);
        [self.origin[0] + column as f64 * self.pixel[0], self.origin[1] + row as f64 * self.pixel[1]]
    }
}

/// Places where the time of the unknowns is spent, in equal shares of each unknown's samples.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// Samples of unknown `i` are `start[i] .. start[i + 1]`.
    pub start: Vec<usize>,
}

impl Samples {
    /// One sample an unknown.
    pub fn points(x: &[f64], y: &[f64]) -> Samples {
        Samples { x: x.to_vec(), y: y.to_vec(), start: (0..=x.len()).collect() }
    }

    /// The unknowns are the segments of the path, one for each point that is not the first of its line; each segment's
    /// time is spread evenly along it, at the middles of equal parts no longer than `spacing`. For a spot of width sigma
    /// and parts of sigma/2, the error of this midpoint rule is beyond double precision.
    pub fn segments(path: &ToolPath, spacing: f64) -> Samples {
        let mut samples = Samples { start: vec![0], ..Samples::default() };
        for segment in segments(path) {
            let ([ax, ay], [bx, by]) = ends(path, segment);
            let dz = path.points.z[segment] - path.points.z[segment - 1];
            let parts = parts(libm::hypot(libm::hypot(bx - ax, by - ay), dz), spacing);
            for k in 0..parts {
                let t = (k as f64 + 0.5) / parts as f64;
                samples.x.push(ax + t * (bx - ax));
                samples.y.push(ay + t * (by - ay));
            }
            samples.start.push(samples.x.len());
        }
        samples
    }
}

/// Number of equal parts of a segment that are no longer than `spacing`.
pub fn parts(length: f64, spacing: f64) -> usize {
    // A segment is never cut into more than a thousand parts: that would be a spot a thousand times finer than the
    // distance of the points, which the coverage check refuses anyway.
    ((length / spacing).ceil() as usize).clamp(1, 1000)
}

/// The points that end a segment, in order: all but the first of each line.
pub fn segments(path: &ToolPath) -> impl Iterator<Item = usize> + '_ {
    path.lines.iter().flat_map(|line| line.points.clone().skip(1))
}

/// Start and end of the segment that ends at `point`, in the part's xy plane.
pub fn ends(path: &ToolPath, point: usize) -> ([f64; 2], [f64; 2]) {
    let points = &path.points;
    ([points.x[point - 1], points.y[point - 1]], [points.x[point], points.y[point]])
}

/// Depth on every pixel, by definition: `z(x, y) = sum over samples of rate(x - mu, y - eta) * time / samples`.
pub fn deposit(samples: &Samples, times: &[f64], footprint: &Footprint, window: &Window) -> Vec<f64> {
    (0..window.len())
        .into_par_iter()
        .map(|i| {
            let [x, y] = window.position(i);
            let mut depth = 0.0;
            for (j, range) in samples.start.windows(2).enumerate() {
                let share = times[j] / (range[1] - range[0]) as f64;
                for s in range[0]..range[1] {
                    depth += share * footprint.rate(x - samples.x[s], y - samples.y[s]);
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
                    sum += share * depth * footprint.rate(x - samples.x[s], y - samples.y[s]);
                }
            }
            sum
        })
        .collect()
}

/// Bilinear spreading and convolution, on a window padded so that nothing wraps round into it.
pub struct Removal {
    window: Window,
    /// Pixels of padding before the window, columns and rows.
    margin: [usize; 2],
    /// Columns of the padded grid.
    columns: usize,
    convolution: Convolution,
    /// Upper left pixel of each sample that can reach the window, in the padded grid, and the place inside the pixel.
    corner: Vec<u32>,
    fraction_x: Vec<f64>,
    fraction_y: Vec<f64>,
    /// Reaching samples of unknown `i` are `start[i] .. start[i + 1]`.
    start: Vec<usize>,
    /// One over the number of all samples of the unknown.
    share: Vec<f64>,
    /// What the depth on each pixel of the window is multiplied with; empty for 1.
    row_factors: Vec<f64>,
    padded: Vec<f64>,
}

/// Unknowns that one task gathers: enough work to be worth a task, the same for any number of threads.
const GATHER_CHUNK: usize = 4096;

impl Removal {
    pub fn new(samples: &Samples, footprint: &Footprint, window: Window) -> Removal {
        // A sample farther than the margin from the window reaches no pixel of it, even spread bilinearly; what wraps
        // round lands in the padding.
        let reach = [0, 1].map(|axis| (footprint.radius / window.pixel[axis]).ceil() as usize);
        let margin = reach.map(|pixels| pixels + 1);
        let columns = good_length(window.columns + 2 * margin[0], true);
        let rows = good_length(window.rows + 2 * margin[1], false);
        let mut kernel = vec![0.0; rows * columns];
        let range = |pixels: usize| -(pixels as i64)..=pixels as i64;
        for dr in range(reach[1]) {
            for dc in range(reach[0]) {
                let row = dr.rem_euclid(rows as i64) as usize;
                let column = dc.rem_euclid(columns as i64) as usize;
                kernel[row * columns + column] +=
                    footprint.rate(dc as f64 * window.pixel[0], dr as f64 * window.pixel[1]);
            }
        }
        let mut removal = Removal {
            window,
            margin,
            columns,
            convolution: Convolution::new(rows, columns, &kernel),
            corner: Vec::with_capacity(samples.x.len()),
            fraction_x: Vec::with_capacity(samples.x.len()),
            fraction_y: Vec::with_capacity(samples.x.len()),
            start: vec![0],
            share: Vec::with_capacity(samples.start.len()),
            row_factors: Vec::new(),
            padded: kernel,
        };
        for range in samples.start.windows(2) {
            for s in range[0]..range[1] {
                removal.add_sample(samples.x[s], samples.y[s]);
            }
            removal.start.push(removal.corner.len());
            removal.share.push(1.0 / (range[1] - range[0]) as f64);
        }
        removal
    }

    /// The same on a sloping surface, to first order: `cosines` of the slope, one a pixel, or none for a plane. The kernel of
    /// the plane takes its volume from the area across the part's axis, the glass there is larger by one over the cosine.
    pub fn on_slopes(mut self, cosines: Vec<f64>) -> Removal {
        self.row_factors = cosines;
        self
    }

    fn add_sample(&mut self, x: f64, y: f64) {
        let u = (x - self.window.origin[0]) / self.window.pixel[0] + self.margin[0] as f64;
        let v = (y - self.window.origin[1]) / self.window.pixel[1] + self.margin[1] as f64;
        let last_column = (self.window.columns + 2 * self.margin[0] - 1) as f64;
        let last_row = (self.window.rows + 2 * self.margin[1] - 1) as f64;
        if u >= 0.0 && v >= 0.0 && u < last_column && v < last_row {
            let (column, row) = (u.floor(), v.floor());
            self.corner.push((row as usize * self.columns + column as usize) as u32);
            self.fraction_x.push(u - column);
            self.fraction_y.push(v - row);
        }
    }

    fn weights(&self, sample: usize) -> (usize, [f64; 4]) {
        let (fx, fy) = (self.fraction_x[sample], self.fraction_y[sample]);
        let (gx, gy) = (1.0 - fx, 1.0 - fy);
        (self.corner[sample] as usize, [gx * gy, fx * gy, gx * fy, fx * fy])
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
        padded.fill(0.0);
        for (j, time) in times.iter().enumerate() {
            let share = time * self.share[j];
            for s in self.start[j]..self.start[j + 1] {
                let (corner, [a, b, c, d]) = self.weights(s);
                padded[corner] += a * share;
                padded[corner + 1] += b * share;
                padded[corner + self.columns] += c * share;
                padded[corner + self.columns + 1] += d * share;
            }
        }
        self.convolution.convolve(&mut padded);
        for (row, line) in depths.chunks_exact_mut(self.window.columns).enumerate() {
            let from = (row + self.margin[1]) * self.columns + self.margin[0];
            line.copy_from_slice(&padded[from..from + self.window.columns]);
        }
        for (depth, factor) in depths.iter_mut().zip(&self.row_factors) {
            *depth *= factor;
        }
        self.padded = padded;
    }

    fn transpose(&mut self, depths: &[f64], times: &mut [f64]) {
        let mut padded = std::mem::take(&mut self.padded);
        padded.fill(0.0);
        for (row, line) in depths.chunks_exact(self.window.columns).enumerate() {
            let to = (row + self.margin[1]) * self.columns + self.margin[0];
            padded[to..to + self.window.columns].copy_from_slice(line);
            let factors = self.row_factors.get(row * self.window.columns..).unwrap_or_default();
            for (depth, factor) in padded[to..to + self.window.columns].iter_mut().zip(factors) {
                *depth *= factor;
            }
        }
        self.convolution.correlate(&mut padded);
        times.par_chunks_mut(GATHER_CHUNK).enumerate().for_each(|(chunk, times)| {
            for (i, time) in times.iter_mut().enumerate() {
                let j = chunk * GATHER_CHUNK + i;
                let mut sum = 0.0;
                for s in self.start[j]..self.start[j + 1] {
                    let (corner, [a, b, c, d]) = self.weights(s);
                    sum += a * padded[corner]
                        + b * padded[corner + 1]
                        + c * padded[corner + self.columns]
                        + d * padded[corner + self.columns + 1];
                }
                *time = sum * self.share[j];
            }
        });
        self.padded = padded;
    }
}

#[cfg(test)]
mod tests {
    use super::super::footprint::examples::gaussian;
    use super::*;
    use crate::path::{Line, Link};
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
                assert!((a - b).abs() < 1e-12 * 1e-7, "{row} {column}: {a} {b}");
            }
        }
    }

    #[test]
    fn spreading_bilinearly_costs_less_than_a_hundredth() {
        // Spreading widens the spot by at most a sixth of a squared pixel in variance along each axis; at a pixel of 0.24
        // sigma that lowers a single spot's peak by 0.24²/6 = 0.96 %, and a covered area by less.
        let footprint = gaussian(1e-8, SIGMA, 6e-3);
        let places: Vec<(f64, f64)> =
            (0..160).map(|i| ((i % 4) as f64 * 7e-3 - 10.5e-3, (i / 4) as f64 * 0.5e-3 - 9.7e-3)).collect();
        let samples = Samples::segments(&path(&places), SIGMA / 2.0);
        let window = window(41, 41, 0.24 * SIGMA);
        let times: Vec<f64> = (0..120).map(|i| 1.0 + libm::sin(i as f64 * 0.3)).collect();
        let exact = deposit(&samples, &times, &footprint, &window);
        let mut operator = Removal::new(&samples, &footprint, window);
        let mut found = vec![0.0; window.len()];
        operator.forward(&times, &mut found);
        let greatest = exact.iter().fold(0.0f64, |m, d| m.max(*d));
        let worst = exact.iter().zip(&found).fold(0.0f64, |m, (e, f)| m.max((e - f).abs()));
        assert!(worst < 9.6e-3 * greatest, "{}", worst / greatest);
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
