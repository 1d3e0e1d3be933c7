//! The expected residual: what will come of a solved run whose rate, map and arm are only as good as the job says.
//!
//! In: the solved [`Outcome`], the job's [`Uncertainty`]. Out: [`Expected`]: the RMS over many such runs, the RMS that 90 % of them
//! stay below, and the share of each error.
//!
//! With the error e, the removal z and its operator H the residual is `r = e - z`, and to first order in each error
//!
//! ```text
//! gain          r = r0 - g z                       g normal, one a run
//! drift         r = r0 - d H(t tau)                tau from 0 at the run's first second to 1 at its last
//! registration  r = r0 + s · grad z                s normal in x and in y
//! map noise     r = r0 - φ P n                     n white; P what the solver follows, to a hundredth of the transfer: nothing else is polished in
//! feed          r = r0 + H(t ε)                    ε along each line, an autoregressive process
//! position      r = r0 + div H(t s(x, y))          s a smooth field over the part
//! ```
//!
//! all without their even layer. The second order of `E[r²]` is the sum of their variances, since errors of different source know
//! nothing of each other, and the mean of the second order of r, which has the shape of removals, has no product with an r0 that
//! is a least-squares residual. So `E[RMS²] = RMS²(r0) + Σ RMS²(source)`. The distribution is that of the quadratic form of all shapes:
//! ten thousand runs of numbered random numbers, each with its g, d and s and one of 32 drawn fields; the same each time.

use super::correctable::{LEAST_SHARE, Padded};
use super::random::Stream;
use crate::diagnostics::{Problem, codes};
use crate::dwell::descent::LinearOperator;
use crate::dwell::field::Field;
use crate::dwell::removal::{Removal, Samples, Window};
use crate::dwell::speed::{self, Limits, Segments};
use crate::dwell::{Footprint, Outcome, TimedPath, cosines, standing_depths};
use crate::job::{Aperture, Corrective, Uncertainty};
use crate::workpiece::form::Surface;

/// Runs of the Monte Carlo: the 90 % point of a distribution of width w is then known to 0.02 w.
const RUNS: u64 = 10_000;

/// Drawn fields of each kind. A field has some hundred independent places, so that its mean square differs little from draw to draw.
const DRAWS: u64 = 32;

/// What will come of a run, over the clear aperture. Metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expected {
    /// Root of the mean of RMS² over many runs.
    pub rms: f64,
    /// 90 % of the runs have an RMS below this.
    pub rms_p90: f64,
    /// What each stated error adds, in squares, to the ideal residual; in the order of the job's record.
    pub shares: Vec<Share>,
}

/// What one error adds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The field of `uncertainty`.
    pub source: &'static str,
    pub rms: f64,
}

/// A solved run and what it was solved for.
pub struct Run<'a> {
    pub outcome: &'a Outcome,
    pub footprint: &'a Footprint<'a>,
    pub surface: &'a dyn Surface,
    pub clear: &'a Aperture,
    pub dwell: &'a Corrective,
}

/// What will come of `run`. `None` where no error is stated: an expectation equal to the ideal would be no honest one.
///
/// # Errors
///
/// E0730: the position error changes within the spot.
pub fn expect(stated: &Uncertainty, run: &Run) -> Result<Option<Expected>, Problem> {
    let Run { outcome, footprint, .. } = run;
    if let Some(position) = &stated.position
        && position.over.0 < footprint.sigma
    {
        let message = format!(
            "the position error changes over {:.3} mm, within the spot, whose sigma is {:.3} mm",
            position.over.0 * 1e3,
            footprint.sigma * 1e3
        );
        return Err(Problem::error(codes::E0730, "uncertainty.position.over", message)
            .note("a shake that fast is averaged in the spot and widens it; it belongs into the measured influence function")
            .help(format!("give the error of the arm's place that changes over {:.3} mm or more", footprint.sigma * 1e3)));
    }
    let Ok(residual) = Field::new(&outcome.residual, run.clear) else { return Ok(None) };
    let mut errors = Errors::new(run, &residual);
    let mut shares = Vec::new();
    if let Some(gain) = stated.gain {
        let shape = errors.removal.iter().map(|depth| -gain * depth).collect();
        shares.push(("gain", errors.shape(shape)));
    }
    if let Some(drift) = stated.drift {
        let late = errors.late();
        let shape = errors.removed(|i| -drift * late[i]);
        shares.push(("drift", errors.shape(shape)));
    }
    if let Some(shift) = stated.registration {
        let square = [0, 1].map(|axis| {
            let shape = slope(&errors.removal, &errors.window, axis).into_iter().map(|slope| shift.0 * slope).collect();
            errors.shape(shape)
        });
        shares.push(("registration", square[0] + square[1]));
    }
    if let Some(noise) = stated.map_noise {
        let pixels = residual.window.pixel[0] * residual.window.pixel[1];
        let averaged = noise.0 * (pixels / (errors.window.pixel[0] * errors.window.pixel[1])).sqrt();
        shares.push(("map_noise", errors.map_noise(averaged * run.dwell.removal_fraction, footprint)));
    }
    if let Some(position) = &stated.position {
        shares.push(("position", errors.position(position.rms.0, position.over.0, &outcome.timed)));
    }
    if let Some(feed) = &stated.feed {
        shares.push(("feed", errors.feed(feed.rms, feed.over.0)));
    }
    if shares.is_empty() {
        return Ok(None);
    }
    let ideal = outcome.figures.rms * outcome.figures.rms;
    let shares: Vec<Share> =
        shares.into_iter().map(|(source, square): (_, f64)| Share { source, rms: square.max(0.0).sqrt() }).collect();
    let rms = (ideal + shares.iter().map(|share| share.rms * share.rms).sum::<f64>()).sqrt();
    Ok(Some(Expected { rms, rms_p90: errors.ninety_percent(ideal), shares }))
}

/// The shapes that the errors have, on the solver's pixels, and their products.
struct Errors {
    window: Window,
    weights: Vec<f64>,
    operator: Removal,
    segments: Segments,
    times: Vec<f64>,
    /// H t, and what the tool removes where it stands. The drift, the feed and the place of a standing tool are left as they are.
    removal: Vec<f64>,
    /// The ideal residual, without its mean.
    ideal: Vec<f64>,
    /// One normal number a run times each of these, without their means.
    shapes: Vec<Vec<f64>>,
    /// The sums of the fields of each draw.
    draws: Vec<Vec<f64>>,
}

impl Errors {
    fn new(run: &Run, residual: &Field) -> Errors {
        let Run { outcome, footprint, surface, dwell, .. } = *run;
        // Twice as coarse as the solver's pixels, on which cubic spreading keeps the spot's width to a tenth of a per cent.
        let coarse = residual.binned(footprint.sigma / 2.0);
        let limits = Limits::of(dwell);
        let segments = Segments::new(&outcome.timed.path, footprint.standoff);
        let speeds: Vec<f64> = segments.point.iter().map(|&point| outcome.timed.speed[point]).collect();
        let samples = Samples::segments(&outcome.timed.path, footprint.sigma / 2.0);
        let mut operator = Removal::new(&samples, footprint, coarse.window);
        if !surface.is_plane() {
            operator = operator.on_slopes(cosines(surface, &coarse.window));
        }
        let mut errors = Errors {
            window: coarse.window,
            weights: coarse.weights,
            times: speed::times(&speeds, &segments, &limits),
            operator,
            segments,
            removal: Vec::new(),
            ideal: Vec::new(),
            shapes: Vec::new(),
            draws: Vec::new(),
        };
        errors.removal = errors.removed(|_| 1.0);
        let standing = standing_depths(&outcome.timed.path, &outcome.timed.standing, footprint, &errors.window);
        errors.removal.iter_mut().zip(standing).for_each(|(depth, more)| *depth += more);
        errors.ideal = errors.centred(coarse.values);
        errors
    }

    /// What the path removes when the time of segment i counts `part(i)` times.
    fn removed(&mut self, part: impl Fn(usize) -> f64) -> Vec<f64> {
        let times: Vec<f64> = self.times.iter().enumerate().map(|(i, time)| part(i) * time).collect();
        let mut depths = vec![0.0; self.window.len()];
        self.operator.forward(&times, &mut depths);
        depths
    }

    /// How late in the run the middle of each segment comes, 0 to 1.
    fn late(&self) -> Vec<f64> {
        let whole: f64 = self.times.iter().sum();
        let mut before = 0.0;
        let middle = |time: &f64| {
            let late = (before + time / 2.0) / whole;
            before += time;
            late
        };
        self.times.iter().map(middle).collect()
    }

    /// Takes the weighted mean out, and what does not count.
    fn centred(&self, mut values: Vec<f64>) -> Vec<f64> {
        let weight: f64 = self.weights.iter().sum();
        let mean = values.iter().zip(&self.weights).map(|(v, w)| v * w).sum::<f64>() / weight;
        for (value, weight) in values.iter_mut().zip(&self.weights) {
            *value = if *weight > 0.0 { *value - mean } else { 0.0 };
        }
        values
    }

    /// Weighted mean of the product.
    fn product(&self, a: &[f64], b: &[f64]) -> f64 {
        let weight: f64 = self.weights.iter().sum();
        a.iter().zip(b).zip(&self.weights).map(|((a, b), w)| w * a * b).sum::<f64>() / weight
    }

    /// Keeps a shape; its mean square.
    fn shape(&mut self, values: Vec<f64>) -> f64 {
        let values = self.centred(values);
        let square = self.product(&values, &values);
        self.shapes.push(values);
        square
    }

    /// Adds a field to draw `draw`; its mean square.
    fn draw(&mut self, draw: u64, values: Vec<f64>) -> f64 {
        let values = self.centred(values);
        let square = self.product(&values, &values);
        match self.draws.get_mut(draw as usize) {
            Some(sum) => sum.iter_mut().zip(&values).for_each(|(sum, value)| *sum += value),
            None => self.draws.push(values),
        }
        square
    }

    /// White noise of `rms` on each pixel, as much of it as the tool follows. The mean square of a draw.
    fn map_noise(&mut self, rms: f64, footprint: &Footprint) -> f64 {
        let padded = Padded::of(&self.window, footprint);
        let mut follow = padded.filter(|h| if h < LEAST_SHARE { 0.0 } else { 1.0 });
        let numbers = Stream::new(1);
        let size = padded.kernel.len();
        let mut squares = 0.0;
        for draw in 0..DRAWS {
            let mut noise: Vec<f64> = (0..size).map(|i| rms * numbers.normal(draw * size as u64 + i as u64)).collect();
            follow.convolve(&mut noise);
            let rows = noise.chunks_exact(padded.columns).take(self.window.rows);
            let values = rows.flat_map(|row| row[..self.window.columns].iter().copied()).collect();
            squares += self.draw(draw, values);
        }
        squares / DRAWS as f64
    }

    /// The tool beside its path by a field of `rms` in x and in y that changes over `over`.
    fn position(&mut self, rms: f64, over: f64, timed: &TimedPath) -> f64 {
        let points = &timed.path.points;
        let middles: Vec<[f64; 2]> = self
            .segments
            .point
            .iter()
            .map(|&point| {
                [0.5 * (points.x[point - 1] + points.x[point]), 0.5 * (points.y[point - 1] + points.y[point])]
            })
            .collect();
        let lattice = Lattice::around(&middles, over);
        let mut squares = 0.0;
        for draw in 0..DRAWS {
            let mut change = vec![0.0; self.window.len()];
            for axis in [0, 1] {
                let field = lattice.draw(2 * draw + axis as u64);
                let moved = self.removed(|i| rms * lattice.at(&field, middles[i]));
                for (change, slope) in change.iter_mut().zip(slope(&moved, &self.window, axis)) {
                    *change += slope;
                }
            }
            squares += self.draw(draw, change);
        }
        squares / DRAWS as f64
    }

    /// Another feed by the part `rms`, an autoregressive process along each line that forgets over `over`.
    fn feed(&mut self, rms: f64, over: f64) -> f64 {
        let numbers = Stream::new(2);
        let count = self.times.len() as u64;
        let mut squares = 0.0;
        for draw in 0..DRAWS {
            let mut parts = vec![0.0; self.times.len()];
            let normal = |i: usize, which: u64| numbers.normal(3 * (draw * count + i as u64) + which);
            for line in self.segments.start.windows(2) {
                let mut here = normal(line[0], 2);
                for (i, part) in parts.iter_mut().enumerate().take(line[1]).skip(line[0]) {
                    let (mean, end) = along_a_segment(here, over / self.segments.length[i], normal(i, 0), normal(i, 1));
                    *part = rms * mean;
                    here = end;
                }
            }
            let change = self.removed(|i| parts[i]);
            squares += self.draw(draw, change);
        }
        squares / DRAWS as f64
    }

    /// The RMS that 90 % of the runs stay below; `ideal` is the mean square of the residual without any error.
    fn ninety_percent(&self, ideal: f64) -> f64 {
        let with_ideal: Vec<f64> = self.shapes.iter().map(|shape| self.product(shape, &self.ideal)).collect();
        let among: Vec<Vec<f64>> =
            self.shapes.iter().map(|a| self.shapes.iter().map(|b| self.product(a, b)).collect()).collect();
        let drawn: Vec<(f64, f64, Vec<f64>)> = self
            .draws
            .iter()
            .map(|field| {
                let with_shapes = self.shapes.iter().map(|shape| self.product(shape, field)).collect();
                (self.product(field, field), self.product(field, &self.ideal), with_shapes)
            })
            .collect();
        let (normal, chosen) = (Stream::new(3), Stream::new(4));
        let count = self.shapes.len();
        let one = |run: u64| {
            let a: Vec<f64> = (0..count).map(|k| normal.normal(run * count as u64 + k as u64)).collect();
            let mut square = ideal;
            for k in 0..count {
                square += 2.0 * a[k] * with_ideal[k];
                square += (0..count).map(|l| a[k] * a[l] * among[k][l]).sum::<f64>();
            }
            if !drawn.is_empty() {
                // A field and its opposite are as likely.
                let bits = chosen.bits(run);
                let sign = if bits & 1 == 0 { 1.0 } else { -1.0 };
                let (own, with_ideal, with_shapes) = &drawn[((bits >> 1) % drawn.len() as u64) as usize];
                let crossed: f64 = a.iter().zip(with_shapes).map(|(a, product)| a * product).sum();
                square += own + 2.0 * sign * (with_ideal + crossed);
            }
            square.max(0.0)
        };
        let mut squares: Vec<f64> = (0..RUNS).map(one).collect();
        squares.sort_by(f64::total_cmp);
        squares[(0.9 * RUNS as f64) as usize - 1].sqrt()
    }
}

/// Derivative along x (axis 0) or y of a window's values: differences over four pixels, which make 96 % of the slope of the
/// shortest ripple that a Gaussian spot follows; over two, or one, at the window's border.
fn slope(values: &[f64], window: &Window, axis: usize) -> Vec<f64> {
    let (columns, rows) = (window.columns, window.rows);
    let (count, stride) = if axis == 0 { (columns, 1) } else { (rows, columns) };
    (0..values.len())
        .map(|i| {
            let place = if axis == 0 { i % columns } else { i / columns };
            let over = |back: usize, ahead: usize| {
                (values[i + ahead * stride] - values[i - back * stride]) / ((back + ahead) as f64 * window.pixel[axis])
            };
            if place >= 2 && place + 2 < count {
                (4.0 * over(1, 1) - over(2, 2)) / 3.0
            } else {
                match (usize::from(place > 0), usize::from(place + 1 < count)) {
                    (0, 0) => 0.0,
                    (back, ahead) => over(back, ahead),
                }
            }
        })
        .collect()
}

/// The mean of a process over a segment, and its value at the end, from that at the start: a normal process of variance 1 whose
/// correlation at the distance d is exp(-d / over), with `ratio` = over / length and two normal numbers. Given the start x,
/// with k = exp(-1 / ratio), the end has the mean k x and the variance 1 - k²; the mean over the segment has the mean
/// ratio (1 - k) x and the variance 2 ratio - ratio² (3 - 4 k + k²); their covariance is ratio (1 - k)².
fn along_a_segment(start: f64, ratio: f64, first: f64, second: f64) -> (f64, f64) {
    let kept = libm::exp(-1.0 / ratio);
    let spread = (1.0 - kept * kept).max(0.0).sqrt();
    let end = kept * start + spread * first;
    // Over a ten-thousandth of its length the process hardly changes, and the differences below would be of rounding.
    if ratio > 1e4 {
        return (start, end);
    }
    let common = ratio * (1.0 - kept) * (1.0 - kept) / spread;
    let variance = 2.0 * ratio - ratio * ratio * (3.0 - 4.0 * kept + kept * kept);
    let own = (variance - common * common).max(0.0).sqrt();
    (ratio * (1.0 - kept) * start + common * first + own * second, end)
}

/// A lattice on which smooth random fields are drawn: white noise under a Gaussian of width over/√2, of which the correlation
/// is a Gaussian of width `over`.
struct Lattice {
    origin: [f64; 2],
    step: f64,
    columns: usize,
    rows: usize,
    /// Half of the symmetric kernel, from its middle on; its squares sum to 1 over the whole.
    kernel: Vec<f64>,
}

/// Lattice points in `over`: a Gaussian of 2.8 points width is read linearly to better than 2 %.
const POINTS_IN_OVER: f64 = 4.0;

impl Lattice {
    fn around(places: &[[f64; 2]], over: f64) -> Lattice {
        let step = over / POINTS_IN_OVER;
        let width = POINTS_IN_OVER / 2.0f64.sqrt();
        // Beyond four widths a Gaussian holds less than 4e-4 of its peak.
        let half = (4.0 * width).ceil() as usize;
        let mut kernel: Vec<f64> = (0..=half).map(|k| libm::exp(-((k * k) as f64) / (2.0 * width * width))).collect();
        let squares = kernel[0] * kernel[0] + 2.0 * kernel[1..].iter().map(|k| k * k).sum::<f64>();
        kernel.iter_mut().for_each(|k| *k /= squares.sqrt());
        let edge = |axis: usize, start: f64, pick: fn(f64, f64) -> f64| {
            places.iter().fold(start, |edge, place| pick(edge, place[axis]))
        };
        let low = [0, 1].map(|axis| edge(axis, f64::INFINITY, f64::min));
        let high = [0, 1].map(|axis| edge(axis, f64::NEG_INFINITY, f64::max));
        let count = [0, 1].map(|axis| ((high[axis] - low[axis]) / step).max(0.0) as usize + 2);
        Lattice { origin: low, step, columns: count[0], rows: count[1], kernel }
    }

    /// A field of variance 1.
    fn draw(&self, number: u64) -> Vec<f64> {
        let half = self.kernel.len() - 1;
        let (wide, high) = (self.columns + 2 * half, self.rows + 2 * half);
        let numbers = Stream::new(1000 + number);
        let white: Vec<f64> = (0..(wide * high) as u64).map(|k| numbers.normal(k)).collect();
        let weigh = |at: &dyn Fn(usize) -> f64| {
            self.kernel[0] * at(half) + (1..=half).map(|k| self.kernel[k] * (at(half - k) + at(half + k))).sum::<f64>()
        };
        let along: Vec<f64> = (0..high * self.columns)
            .map(|i| weigh(&|k| white[i / self.columns * wide + i % self.columns + k]))
            .collect();
        (0..self.rows * self.columns).map(|i| weigh(&|k| along[i + k * self.columns])).collect()
    }

    /// Read linearly between its points.
    fn at(&self, field: &[f64], place: [f64; 2]) -> f64 {
        let [u, v] = [0, 1].map(|axis| ((place[axis] - self.origin[axis]) / self.step).max(0.0));
        let (column, row) = ((u as usize).min(self.columns - 2), (v as usize).min(self.rows - 2));
        let (fu, fv) = (u - column as f64, v - row as f64);
        let corner = row * self.columns + column;
        let along = |i: usize| field[i] + fu * (field[i + 1] - field[i]);
        along(corner) + fv * (along(corner + self.columns) - along(corner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_field_has_the_stated_correlation() {
        // 40 by 40 correlation lengths hold some 500 independent places; over eight draws mean products are known to 2 %.
        let over = 10e-3;
        let places = [[0.0, 0.0], [400e-3, 400e-3]];
        let lattice = Lattice::around(&places, over);
        let fields: Vec<Vec<f64>> = (0..8).map(|number| lattice.draw(number)).collect();
        let mean = |shift: f64| {
            let n = 120;
            let (mut sum, mut count) = (0.0, 0.0);
            for i in 0..n * n {
                let [x, y] = [(i % n) as f64 * 3.2e-3, (i / n) as f64 * 3.2e-3];
                for field in &fields {
                    sum += lattice.at(field, [x, y]) * lattice.at(field, [x + shift, y]);
                    count += 1.0;
                }
            }
            sum / count
        };
        for (shift, expected) in [(0.0, 1.0), (over, libm::exp(-0.5)), (3.0 * over, libm::exp(-4.5))] {
            assert!((mean(shift) - expected).abs() < 0.08, "{shift}: {}", mean(shift));
        }
    }

    /// Of the process x(s) with variance 1 and the correlation exp(-|s|) over lengths in units of `over`, on a segment of the length
    /// L = 1 / ratio, and k = exp(-L). By hand, from the integrals of the correlation:
    ///
    /// ```text
    /// variance of the mean      2/L² · ∫₀ᴸ (L - s) exp(-s) ds = 2 (1/L - (1 - k)/L²)
    /// mean with either end      1/L · ∫₀ᴸ exp(-s) ds          = (1 - k)/L
    /// start with end            k
    /// ```
    #[test]
    fn the_process_along_a_segment_is_the_exponentially_correlated_one() {
        // The start, and both numbers, are independent normal numbers: what comes out is linear in them, so that its covariances are
        // sums of products of what each of them gives alone.
        for length in [1e-3, 0.02, 0.5, 1.0, 3.0, 40.0] {
            let of = |start, first, second| along_a_segment(start, 1.0 / length, first, second);
            let parts = [of(1.0, 0.0, 0.0), of(0.0, 1.0, 0.0), of(0.0, 0.0, 1.0)];
            let sum = |product: fn(&(f64, f64)) -> f64| parts.iter().map(product).sum::<f64>();
            let k = libm::exp(-length);
            let cases = [
                ("mean", sum(|(mean, _)| mean * mean), 2.0 * (1.0 / length - (1.0 - k) / (length * length))),
                ("end", sum(|(_, end)| end * end), 1.0),
                ("mean with end", sum(|(mean, end)| mean * end), (1.0 - k) / length),
                ("mean with start", parts[0].0, (1.0 - k) / length),
                ("end with start", parts[0].1, k),
            ];
            for (what, found, expected) in cases {
                // Over a thousandth of a length these are differences of numbers near a million, each rounded at 1e-10.
                assert!((found - expected).abs() < 1e-9, "{what} over {length}: {found}, not {expected}");
            }
            let (mean, end) = of(0.3, -0.7, 1.1);
            let linear =
                |pick: fn(&(f64, f64)) -> f64| 0.3 * pick(&parts[0]) - 0.7 * pick(&parts[1]) + 1.1 * pick(&parts[2]);
            assert!((mean - linear(|part| part.0)).abs() < 1e-12 && (end - linear(|part| part.1)).abs() < 1e-12);
        }
        // Beyond ten thousand segments in a correlation length the mean is taken for the start: the mean square of their difference is
        // 2 L / 3 to first order, less than a ten-thousandth.
        assert_eq!(along_a_segment(0.4, 2e4, 1.0, 1.0).0, 0.4);
    }

    /// Steps of one length give what steps of half the length give, in mean squares: the process knows nothing of its segments.
    #[test]
    fn the_process_is_the_same_over_halves() {
        // Ends of two halves in a row: the correlation of the first start with the last end is exp(-1) either way.
        let (half, whole) = (along_a_segment(1.0, 2.0, 0.0, 0.0).1, along_a_segment(1.0, 1.0, 0.0, 0.0).1);
        assert!((half * half - whole).abs() < 1e-15);
        // The mean over two halves, by their covariances by hand: a quarter of both variances and twice the product of the first mean
        // with the start of the second, times what the second mean has of it.
        let parts: Vec<(f64, f64)> =
            [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)].map(|(x, a, b)| along_a_segment(x, 2.0, a, b)).to_vec();
        let variance: f64 = parts.iter().map(|part| part.0 * part.0).sum();
        let with_end: f64 = parts.iter().map(|part| part.0 * part.1).sum();
        let two = 0.25 * (2.0 * variance + 2.0 * with_end * parts[0].0);
        let one = 2.0 * (1.0 - (1.0 - libm::exp(-1.0)));
        assert!((two - one).abs() < 1e-12, "{two} {one}");
    }

    #[test]
    fn a_slope_is_exact_for_a_plane() {
        let window = Window { columns: 5, rows: 4, pixel: [1e-3, 2e-3], origin: [0.0; 2] };
        let values: Vec<f64> = (0..20).map(|i| window.position(i)).map(|[x, y]| 3.0 * x - 7.0 * y).collect();
        for (axis, expected) in [(0, 3.0), (1, -7.0)] {
            assert!(slope(&values, &window, axis).iter().all(|slope| (slope - expected).abs() < 1e-12));
        }
    }
}
