//! Prediction: what a timed path removes.
//!
//! In: a [`TimedPath`] with its rounded speeds, the footprint, the error map. Out: removal and residual on the map's own
//! pixels inside the clear aperture.
//!
//! Up to [`MOST_STAMPED`] products it shares nothing with the solver's operator: no binning, no spreading of time, no Fourier
//! transform. Every
//! part of every segment, with the time that the ramps of [`speed`](super::speed) give it, stamps the influence function on the pixels.
//! The influence function is tabulated at an eighth of a pixel and interpolated linearly between the four nearest
//! sub-pixel phases; where the pixel is at most a quarter of the spot's sigma, that is within 2e-4 of the peak of the
//! true rate (h²/8 of the second derivative in each axis, h = sigma/32).
//!
//! Where that is more than [`MOST_STAMPED`] products (a spot of many thousand pixels on a fine map), the same parts go through
//! [`Removal`] on the map's own pixels instead; a test holds the two together.

use super::TimedPath;
use super::descent::LinearOperator;
use super::footprint::Footprint;
use super::removal::{Removal, Samples, Window, parts};
use super::speed::{Limits, Segments, part_times};
use rayon::prelude::*;

/// Sub-pixel phases of the table along each axis.
const PHASES: usize = 8;

/// Rows of pixels that one task fills: the same for any number of threads, enough of them to share out evenly.
pub(super) const ROWS: usize = 8;

/// Places and times of the stamps.
#[derive(Default)]
struct Stamps {
    x: Vec<f64>,
    y: Vec<f64>,
    time: Vec<f64>,
}

/// Depth removed at every pixel of the window, metres, row-major.
pub fn removal(timed: &TimedPath, footprint: &Footprint, limits: &Limits, window: &Window) -> Vec<f64> {
    let stamps = stamps(timed, footprint, limits, window);
    let half = half(footprint, window.pixel);
    let products = 4.0 * stamps.x.len() as f64 * ((2 * half[0] + 1) * (2 * half[1] + 1)) as f64;
    if products > MOST_STAMPED { spread(&stamps, footprint, window) } else { stamp(stamps, footprint, window, half) }
}

/// Products of a stamp with a time: about a second's worth.
const MOST_STAMPED: f64 = 2e9;

/// The stamps by spreading and convolution.
fn spread(stamps: &Stamps, footprint: &Footprint, window: &Window) -> Vec<f64> {
    let mut depths = vec![0.0; window.len()];
    Removal::new(&Samples::points(&stamps.x, &stamps.y), footprint, *window).forward(&stamps.time, &mut depths);
    depths
}

/// The stamps one by one.
fn stamp(stamps: Stamps, footprint: &Footprint, window: &Window, half: [usize; 2]) -> Vec<f64> {
    let tables: Vec<Table> = (0..footprint.parts()).map(|part| Table::new(footprint, part, window.pixel)).collect();
    let (stamps, start) = by_rows(stamps, window, half[1]);
    // A stamp reaches `half` rows either way, so this many chunks of rows below its own.
    let below = (2 * half[1]).div_ceil(ROWS) + 1;
    let mut depths = vec![0.0; window.len()];
    depths.par_chunks_mut(ROWS * window.columns.max(1)).enumerate().for_each(|(chunk, depths)| {
        let mut weights = vec![1.0; tables.len()];
        for s in start[(chunk + 1).saturating_sub(below)]..start[chunk + 1] {
            let (x, y) = (stamps.x[s], stamps.y[s]);
            footprint.weights(x, y, &mut weights);
            for (table, weight) in tables.iter().zip(&weights) {
                table.stamp((x, y, stamps.time[s] * weight), window, chunk * ROWS, depths);
            }
        }
    });
    depths
}

/// Stamps that reach the window, in travel order.
fn stamps(timed: &TimedPath, footprint: &Footprint, limits: &Limits, window: &Window) -> Stamps {
    let mut stamps = Stamps::default();
    each_stamp(timed, footprint, footprint.radius, limits, window, |place, time| {
        let [x, y] = place.in_plane(timed);
        stamps.x.push(x);
        stamps.y.push(y);
        stamps.time.push(time);
    });
    stamps
}

/// A place on the straight way between two points of the path: the share `t` of it. It is the middle of a part that is
/// `share` of the way.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub from: usize,
    pub to: usize,
    pub t: f64,
    pub share: f64,
}

impl Place {
    fn in_plane(self, timed: &TimedPath) -> [f64; 2] {
        let points = &timed.path.points;
        let between = |values: &[f64]| values[self.from] + self.t * (values[self.to] - values[self.from]);
        [between(&points.x), between(&points.y)]
    }
}

/// Calls `see(place, time)` where time is spent within `reach` of the window: at the middle of every part of a segment, and
/// where the tool stands. Parts h of at most half a sigma: the midpoint rule is then exact to
/// rounding where the speed is constant; where it is not, it is wrong by h²k²/24 of the modulation with wave number k,
/// that is 1 % at the wavelength 2 pi sigma, of which the spot passes little anyway.
pub(super) fn each_stamp(
    timed: &TimedPath,
    footprint: &Footprint,
    reach: f64,
    limits: &Limits,
    window: &Window,
    mut see: impl FnMut(Place, f64),
) {
    let segments = Segments::new(&timed.path, footprint.standoff);
    let low = [0, 1].map(|axis| window.origin[axis] - reach);
    let size = [window.columns, window.rows];
    let high = [0, 1].map(|axis| window.origin[axis] + size[axis] as f64 * window.pixel[axis] + reach);
    let mut look = |place: Place, time: f64| {
        let [x, y] = place.in_plane(timed);
        if x > low[0] && x < high[0] && y > low[1] && y < high[1] {
            see(place, time);
        }
    };
    for line in segments.start.windows(2) {
        let mut before = 0.0;
        for i in line[0]..line[1] {
            let point = segments.point[i];
            let speed = timed.speed[point];
            let stops = i + 1 == line[1];
            let count = parts(segments.length[i], footprint.sigma / 2.0);
            part_times((segments.length[i], count), (before, speed, stops), limits.acceleration, |part, time| {
                let share = 1.0 / count as f64;
                look(Place { from: point - 1, to: point, t: (part as f64 + 0.5) / count as f64, share }, time);
            });
            before = speed;
        }
    }
    for standing in &timed.standing {
        look(Place { from: standing.point, to: standing.point, t: 0.0, share: 0.0 }, standing.seconds);
    }
}

/// The stamps sorted by the chunk of rows that holds their first row (chunk 0 if it lies before the window), travel
/// order kept inside; those of chunk `c` are `start[c] .. start[c + 1]`.
fn by_rows(stamps: Stamps, window: &Window, half: usize) -> (Stamps, Vec<usize>) {
    let chunks = window.rows.div_ceil(ROWS);
    let chunk = |y: f64| {
        let first = ((y - window.origin[1]) / window.pixel[1]).floor() - half as f64;
        (first.max(0.0) as usize / ROWS).min(chunks.saturating_sub(1))
    };
    let mut start = vec![0; chunks + 1];
    for y in &stamps.y {
        start[chunk(*y) + 1] += 1;
    }
    for c in 0..chunks {
        start[c + 1] += start[c];
    }
    let mut next = start.clone();
    let n = stamps.y.len();
    let mut sorted = Stamps { x: vec![0.0; n], y: vec![0.0; n], time: vec![0.0; n] };
    for s in 0..n {
        let place = &mut next[chunk(stamps.y[s])];
        (sorted.x[*place], sorted.y[*place], sorted.time[*place]) = (stamps.x[s], stamps.y[s], stamps.time[s]);
        *place += 1;
    }
    (sorted, start)
}

/// Weight below which a sub-pixel phase is left out: it is a place that lies on a phase but for rounding.
const NO_WEIGHT: f64 = 1e-9;

/// Pixels from the middle of a stamp to its border: one more than the reach, since a phase moves the stamp by up to one.
fn half(footprint: &Footprint, pixel: [f64; 2]) -> [usize; 2] {
    pixel.map(|p| (footprint.radius / p).ceil() as usize + 1)
}

/// A part of the influence function sampled at every sub-pixel phase.
struct Table {
    /// Pixels from the middle of a stamp to its border.
    half: [usize; 2],
    /// One stamp a phase, phases row-major from 0 to `PHASES` inclusive in both axes.
    values: Vec<f64>,
    /// Columns of each stamp row that are not zero in every phase.
    span: Vec<std::ops::Range<usize>>,
}

impl Table {
    fn new(footprint: &Footprint, part: usize, pixel: [f64; 2]) -> Table {
        let half = half(footprint, pixel);
        let (width, height) = (2 * half[0] + 1, 2 * half[1] + 1);
        let count = PHASES + 1;
        let values: Vec<f64> = (0..count * count * width * height)
            .into_par_iter()
            .map(|i| {
                let (phase, cell) = (i / (width * height), i % (width * height));
                let (phase_x, phase_y) = (phase % count, phase / count);
                let offset =
                    |cell: usize, half: usize, phase: usize| cell as f64 - half as f64 - phase as f64 / PHASES as f64;
                footprint.rate_of(
                    part,
                    offset(cell % width, half[0], phase_x) * pixel[0],
                    offset(cell / width, half[1], phase_y) * pixel[1],
                )
            })
            .collect();
        let used = |row: usize, column: usize| {
            (0..count * count).any(|phase| values[(phase * height + row) * width + column] != 0.0)
        };
        let span = (0..height)
            .map(|row| {
                let first = (0..width).find(|&column| used(row, column)).unwrap_or(0);
                let last = (0..width).rev().find(|&column| used(row, column));
                first..last.map_or(first, |last| last + 1)
            })
            .collect();
        Table { half, values, span }
    }

    /// One row of the stamp of a phase.
    fn row(&self, phase: usize, row: usize) -> &[f64] {
        let (width, height) = (2 * self.half[0] + 1, 2 * self.half[1] + 1);
        &self.values[(phase * height + row) * width..][..width]
    }

    /// The phases around a place inside a pixel (0 to 1 in both axes), with their weights: four, or fewer where the
    /// place lies on one.
    fn phases(u: f64, v: f64) -> ([(usize, f64); 4], usize) {
        let split = |place: f64| {
            let phase = place * PHASES as f64;
            let whole = (phase as usize).min(PHASES - 1);
            [(whole, 1.0 - (phase - whole as f64)), (whole + 1, phase - whole as f64)]
        };
        let (mut phases, mut count) = ([(0, 0.0); 4], 0);
        for (y, wy) in split(v) {
            for (x, wx) in split(u) {
                if wx * wy > NO_WEIGHT {
                    phases[count] = (y * (PHASES + 1) + x, wx * wy);
                    count += 1;
                }
            }
        }
        (phases, count)
    }

    /// Adds one stamp `(x, y, time)` to the rows of `depths`, of which the first is `first_row` of the window.
    fn stamp(&self, (x, y, time): (f64, f64, f64), window: &Window, first_row: usize, depths: &mut [f64]) {
        let rows = depths.len() / window.columns;
        let v = (y - window.origin[1]) / window.pixel[1];
        let bottom = v.floor() as i64 - self.half[1] as i64;
        let from_row = bottom.max(first_row as i64);
        let to_row = (bottom + 2 * self.half[1] as i64 + 1).min((first_row + rows) as i64);
        let u = (x - window.origin[0]) / window.pixel[0];
        let left = u.floor() as i64 - self.half[0] as i64;
        let (mut phases, count) = Table::phases(u - u.floor(), v - v.floor());
        for (_, weight) in &mut phases {
            *weight *= time;
        }
        for row in from_row..to_row {
            let table_row = (row - bottom) as usize;
            let span = &self.span[table_row];
            let from = (left + span.start as i64).max(0);
            let to = (left + span.end as i64).min(window.columns as i64);
            if from >= to {
                continue;
            }
            let start = (row as usize - first_row) * window.columns;
            let out = &mut depths[start + from as usize..start + to as usize];
            let cells = (from - left) as usize..(to - left) as usize;
            let part = |i: usize| (&self.row(phases[i].0, table_row)[cells.clone()], phases[i].1);
            match count {
                1 => {
                    let (a, wa) = part(0);
                    for (out, a) in out.iter_mut().zip(a) {
                        *out += wa * a;
                    }
                }
                2 => {
                    let ((a, wa), (b, wb)) = (part(0), part(1));
                    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
                        *out += wa * a + wb * b;
                    }
                }
                // A place with three phases has the fourth at weight zero.
                _ => {
                    let [(a, wa), (b, wb), (c, wc), (d, wd)] = [0, 1, 2, 3].map(part);
                    for ((((out, a), b), c), d) in out.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                        *out += (wa * a + wb * b) + (wc * c + wd * d);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::footprint::examples::gaussian;
    use super::super::footprint::examples::two_parts;
    use super::super::removal::deposit;
    use super::*;
    use crate::path::{Line, Link, ToolPath};

    const SIGMA: f64 = 2e-3;
    const LIMITS: Limits = Limits { least: 1e-4, greatest: 0.1, acceleration: 0.5, lateral: 0.5 };

    /// Three lines of 30 mm, askew, points 2 mm apart.
    fn path() -> ToolPath {
        let mut path = ToolPath::default();
        for line in 0..3 {
            let start = path.points.len();
            for i in 0..16 {
                let (u, v) = (i as f64 * 2e-3 - 15e-3, line as f64 * 1.3e-3 - 1.3e-3);
                path.points.push([0.8 * u - 0.6 * v, 0.6 * u + 0.8 * v, 0.0], [0.0, 0.0, 1.0]);
            }
            path.lines.push(Line { points: start..path.points.len(), link: Link::OnSurface });
        }
        path
    }

    fn timed(speed: impl Fn(usize) -> f64) -> TimedPath {
        let path = path();
        let speed = (0..path.points.len()).map(speed).collect();
        TimedPath { path, speed, standing: Vec::new() }
    }

    fn window(pixel: f64) -> Window {
        let n = (60e-3 / pixel).round() as usize;
        Window { columns: n, rows: n + 3, pixel: [pixel; 2], origin: [-30e-3; 2] }
    }

    #[test]
    fn volume_is_rate_times_time() {
        // Everything lands inside the window; the sum over pixels of sigma/4 integrates the cut Gaussian to 2e-3 (the jump
        // of exp(-4.5) = 1.1 % of the peak at its rim is what the grid resolves worst).
        let footprint = gaussian(1e-8, SIGMA, 6e-3);
        let timed = timed(|i| if i % 16 < 8 { 0.02 } else { 0.025 });
        let window = window(SIGMA / 4.0);
        let volume: f64 =
            removal(&timed, &footprint, &LIMITS, &window).iter().sum::<f64>() * (SIGMA / 4.0) * (SIGMA / 4.0);
        // By hand, a line: 7 segments of 2 mm at 20 mm/s and 8 at 25 mm/s take 0.7 s and 0.64 s; starting adds v/2a =
        // 0.02 s, stopping 0.025 s, the change from 20 to 25 mm/s (5e-3)² / (2 a v) = 0.001 s.
        let time = 3.0 * (0.7 + 0.64 + 0.02 + 0.025 + 0.001);
        let expected = footprint.volume_rate * time;
        assert!((volume - expected).abs() < 2e-3 * expected, "{volume} {expected}");
    }

    #[test]
    fn table_agrees_with_the_definition() {
        // At a constant speed with an acceleration so high that ramps vanish, against the definition.
        let footprint = gaussian(1e-8, SIGMA, 6e-3);
        let limits = Limits { acceleration: 1e6, ..LIMITS };
        let timed = timed(|i| 0.01 + 0.001 * (i % 16) as f64);
        let window = window(SIGMA / 4.0);
        let found = removal(&timed, &footprint, &limits, &window);
        let segments = Segments::new(&timed.path, 0.0);
        let times: Vec<f64> = segments.point.iter().map(|&p| 2e-3 / timed.speed[p]).collect();
        let exact = deposit(&Samples::segments(&timed.path, SIGMA / 2.0), &times, &footprint, &window);
        let greatest = exact.iter().fold(0.0f64, |m, d| m.max(*d));
        let worst = exact.iter().zip(&found).fold(0.0f64, |m, (e, f)| m.max((e - f).abs()));
        // The rim of the cut Gaussian, 1.1 % of the peak, is smeared over an eighth of a pixel.
        assert!(worst < 1.5e-3 * greatest, "{}", worst / greatest);
    }

    #[test]
    fn spreading_agrees_with_stamping() {
        // Of Gaussians cut where it no longer matters: the table is within 2e-4 of the peak of each, the spline within 5e-5.
        let timed = timed(|i| 0.01 + 0.001 * (i % 16) as f64);
        let window = window(SIGMA / 4.0);
        for footprint in [gaussian(1e-8, SIGMA, 10e-3), two_parts()] {
            let stamps = || stamps(&timed, &footprint, &LIMITS, &window);
            let spread = spread(&stamps(), &footprint, &window);
            let stamped = stamp(stamps(), &footprint, &window, half(&footprint, window.pixel));
            let greatest = stamped.iter().fold(0.0f64, |m, d| m.max(*d));
            let worst = stamped.iter().zip(&spread).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(greatest > 0.0 && worst < 5e-4 * greatest, "{}", worst / greatest);
        }
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let footprint = gaussian(1e-8, SIGMA, 6e-3);
        let timed = timed(|i| 0.01 + 0.001 * (i % 16) as f64);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| removal(&timed, &footprint, &LIMITS, &window(SIGMA / 4.0)))
        };
        let one = with(1);
        assert!(one == with(2) && one == with(8));
    }
}
