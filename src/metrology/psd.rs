//! Power spectral density: how the mean square of a map is shared out over spatial frequencies.
//!
//! In: a grid and which of its pixels count. Out: [`Psd`], the two-dimensional density, from which the densities along
//! profiles and over rings, and the mean square of a band of periods, are sums.
//!
//! ```text
//! S2(fx, fy) = dx dy / (sum of w²) · | sum of w h exp(-2 pi i (fx x + fy y)) |²          m⁴
//! S1(fx)     = 2 · integral of S2 dfy,  fx > 0                                           m³
//! ```
//!
//! Normalised so that the integral over all frequencies is the mean square of the map, weighted with w² (Parseval's
//! theorem; J. M. Elson and J. M. Bennett, "Calculation of the power spectral density from surface profile data",
//! Applied Optics 34, 201, 1995). S1 is one-sided, as a profile instrument reads it: its integral over positive
//! frequencies is the mean square; where a drawing to ISO 10110-8 (S1 = A / f^B) means the two-sided density, halve it.
//!
//! The window w is the square of a sine of the distance from the border of the area, so that it suits any outline: zero
//! at the border, one from a quarter of the largest distance on ([`TAPER`]). Without it the step at the border would leak
//! into all frequencies. Nothing is taken off here: low orders, which no window hides, are the caller's to take off.

use super::distance;
use crate::fourier::{good_length, power_spectrum};
use crate::height_map::Grid;

/// Width of the window's flank, as a part of the largest distance to the border. Over a disc 56 % of the area keeps its full
/// weight, and a bowl of 300 nm leaks 0.34 nm RMS into the periods from a 25th to a 16th of the diameter: low orders are to
/// be taken off first. A flank of half the distance leaks a third of that, and forgets three quarters of the disc.
const TAPER: f64 = 0.25;

/// A two-dimensional power spectral density.
#[derive(Clone, Debug, PartialEq)]
pub struct Psd {
    /// Frequencies along x: the first half from 0 up, then the negative ones, as a transform orders them.
    pub columns: usize,
    /// Frequencies along y: 0 up to `(rows - 1) * step[1]`; the negative ones are mirror images.
    pub rows: usize,
    /// Distance of two frequencies along x and along y, cycles a metre.
    pub step: [f64; 2],
    /// Row-major, metres to the fourth power (the square of the map's unit, times square metres).
    pub density: Vec<f64>,
    /// Whether the last row is the highest frequency of an even length, which is its own mirror image.
    even: bool,
}

/// A density over one frequency, at equal distances from zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Cycles a metre.
    pub frequency: Vec<f64>,
    pub density: Vec<f64>,
}

/// Of the known pixels marked in `counts`; `None` if there are none.
pub fn psd(grid: &Grid, counts: &[bool]) -> Option<Psd> {
    let inside: Vec<bool> = grid.values.iter().zip(counts).map(|(v, counts)| *counts && !v.is_nan()).collect();
    let rows = bounds(inside.chunks_exact(grid.columns).map(|line| line.contains(&true)))?;
    let columns = bounds((0..grid.columns).map(|c| rows.clone().any(|r| inside[r * grid.columns + c])))?;
    let cut: Vec<bool> =
        rows.clone().flat_map(|r| inside[r * grid.columns..][columns.clone()].iter().copied()).collect();
    let distances = distance::to_outside(&cut, columns.len(), grid.pixel);
    let flank = TAPER * distances.iter().fold(0.0, |most: f64, d| most.max(*d));
    let weight = |i: usize| {
        let part = (distances[i] / flank).min(1.0);
        let sine = libm::sin(std::f64::consts::FRAC_PI_2 * part);
        sine * sine
    };
    let (high, wide) = (good_length(rows.len(), false), good_length(columns.len(), true));
    let mut weighted = vec![0.0; high * wide];
    let mut squares = 0.0;
    for (i, _) in cut.iter().enumerate().filter(|(_, inside)| **inside) {
        let (row, column) = (i / columns.len(), i % columns.len());
        let w = weight(i);
        squares += w * w;
        weighted[row * wide + column] = w * grid.at(rows.start + row, columns.start + column);
    }
    let scale = grid.pixel[0] * grid.pixel[1] / squares;
    let mut density = power_spectrum(high, wide, &weighted);
    density.iter_mut().for_each(|value| *value *= scale);
    Some(Psd {
        columns: wide,
        rows: high / 2 + 1,
        step: [1.0 / (wide as f64 * grid.pixel[0]), 1.0 / (high as f64 * grid.pixel[1])],
        density,
        even: high.is_multiple_of(2),
    })
}

/// The range from the first to the last `true`.
fn bounds(marks: impl Iterator<Item = bool>) -> Option<std::ops::Range<usize>> {
    let (mut first, mut last) = (None, 0);
    for (i, _) in marks.enumerate().filter(|(_, mark)| *mark) {
        first.get_or_insert(i);
        last = i;
    }
    first.map(|first| first..last + 1)
}

impl Psd {
    /// How many frequencies a row stands for: itself, and its mirror image if that is another.
    fn times(&self, row: usize) -> f64 {
        if row == 0 || (self.even && row + 1 == self.rows) { 1.0 } else { 2.0 }
    }

    /// Frequency along x of a column, cycles a metre, negative in the second half.
    fn along_x_of(&self, column: usize) -> f64 {
        let signed = if 2 * column > self.columns { column as f64 - self.columns as f64 } else { column as f64 };
        signed * self.step[0]
    }

    /// Calls `see(|f|, density, count)` for every frequency; `count` says for how many it stands.
    fn each(&self, mut see: impl FnMut(f64, f64, f64)) {
        for row in 0..self.rows {
            let fy = row as f64 * self.step[1];
            for column in 0..self.columns {
                let f = libm::hypot(self.along_x_of(column), fy);
                see(f, self.density[row * self.columns + column], self.times(row));
            }
        }
    }

    /// The mean square of the map: the integral over all frequencies.
    pub fn mean_square(&self) -> f64 {
        self.mean_square_between(0.0, f64::INFINITY)
    }

    /// The part of the mean square with frequencies, in any direction, from `low` up to, without, `high`, cycles a metre.
    pub fn mean_square_between(&self, low: f64, high: f64) -> f64 {
        let mut sum = 0.0;
        self.each(|f, density, count| {
            if f >= low && f < high {
                sum += density * count;
            }
        });
        sum * self.step[0] * self.step[1]
    }

    /// Root mean square of what has periods from `shortest` to `longest`, metres, in any direction.
    pub fn band_rms(&self, shortest: f64, longest: f64) -> f64 {
        self.mean_square_between(1.0 / longest, 1.0 / shortest).sqrt()
    }

    /// S1 of profiles along x, averaged over the profiles: one-sided, m³.
    pub fn along_x(&self) -> Profile {
        let mut density = vec![0.0; self.columns / 2 + 1];
        for row in 0..self.rows {
            for column in 0..self.columns {
                // Both signs fall on the one-sided density.
                let k = column.min(self.columns - column);
                density[k] += self.density[row * self.columns + column] * self.times(row) * self.step[1];
            }
        }
        Profile { frequency: (0..density.len()).map(|k| k as f64 * self.step[0]).collect(), density }
    }

    /// S1 of profiles along y, averaged over the profiles: one-sided, m³.
    pub fn along_y(&self) -> Profile {
        let line = |row: usize| self.density[row * self.columns..][..self.columns].iter().sum::<f64>();
        let density: Vec<f64> = (0..self.rows).map(|row| line(row) * self.times(row) * self.step[0]).collect();
        Profile { frequency: (0..density.len()).map(|k| k as f64 * self.step[1]).collect(), density }
    }

    /// The mean of S2 over rings of equal |f|, as wide as the larger step: m⁴. A ring without a frequency repeats the
    /// one inside it.
    pub fn radial(&self) -> Profile {
        let width = self.step[0].max(self.step[1]);
        let (mut sums, mut counts): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        self.each(|f, density, count| {
            let ring = (f / width).round() as usize;
            if ring >= sums.len() {
                sums.resize(ring + 1, 0.0);
                counts.resize(ring + 1, 0.0);
            }
            sums[ring] += density * count;
            counts[ring] += count;
        });
        let mut last = 0.0;
        let density = sums.iter().zip(&counts).map(|(sum, count)| {
            if *count > 0.0 {
                last = sum / count;
            }
            last
        });
        let density: Vec<f64> = density.collect();
        Profile { frequency: (0..density.len()).map(|k| k as f64 * width).collect(), density }
    }
}

impl Profile {
    /// The integral over all its frequencies.
    pub fn integral(&self) -> f64 {
        let step = self.frequency.get(1).copied().unwrap_or(0.0);
        self.density.iter().sum::<f64>() * step
    }
}
