//! Resample: a map on other pixels.
//!
//! In: a grid, the pixels that are wanted, and where each of these lies in the grid's frame. Out: a grid of the wanted pixels.
//!
//! Values come by cubic convolution (R. Keys, "Cubic convolution interpolation for digital image processing", IEEE Trans.
//! ASSP 29, 1981), which reproduces parabolas. Halfway between pixels a wave of 16 pixels' period loses 0.06 % of its
//! amplitude, one of 8 pixels 0.9 %, one of 4 pixels 12 %. Where one of its sixteen pixels is unknown, bilinearly from
//! the four around; where one of these is unknown, the value is unknown: an unknown pixel never becomes a height. Nothing
//! is made up beyond the centres of the outermost pixels. A place on the centre of a pixel has the pixel's own value.

use crate::height_map::Grid;
use rayon::prelude::*;

/// A place this near to the centre of a pixel, in pixels, lies on it: the rounding of numbers of a job.
const ON_CENTRE: f64 = 1e-6;

/// Turns, scales and shifts a plane: `scale * R(rotation) * place + shift`, metres and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    pub scale: f64,
    /// From +x towards +y.
    pub rotation: f64,
    pub shift: [f64; 2],
}

impl Similarity {
    /// A turn about the origin.
    pub(super) fn turn(rotation: f64) -> Similarity {
        Similarity { scale: 1.0, rotation, shift: [0.0; 2] }
    }

    /// Where `place` goes.
    pub fn apply(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = libm::sincos(self.rotation);
        let [tx, ty] = self.shift;
        [self.scale * (cosine * x - sine * y) + tx, self.scale * (sine * x + cosine * y) + ty]
    }

    /// The way back.
    pub fn inverse(&self) -> Similarity {
        let turned = Similarity { scale: 1.0 / self.scale, rotation: -self.rotation, shift: [0.0; 2] };
        let [x, y] = turned.apply(self.shift);
        Similarity { shift: [-x, -y], ..turned }
    }
}

/// Pixels without values: the geometry of a [`Grid`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pixels {
    pub columns: usize,
    pub rows: usize,
    pub pixel: [f64; 2],
    pub origin: [f64; 2],
}

impl Pixels {
    /// Those of a grid.
    pub fn of(grid: &Grid) -> Pixels {
        Pixels { columns: grid.columns, rows: grid.rows, pixel: grid.pixel, origin: grid.origin }
    }

    /// Those whose cells cover the box from `low` to `high`; `anchor` is the centre of one of them, or would be.
    pub fn covering(low: [f64; 2], high: [f64; 2], pixel: [f64; 2], anchor: [f64; 2]) -> Pixels {
        // A box that ends on a border of pixels needs no pixel beyond it.
        let first = [0, 1].map(|k| ((low[k] - anchor[k]) / pixel[k] - 0.5 + ON_CENTRE).floor() + 1.0);
        let last = [0, 1].map(|k| ((high[k] - anchor[k]) / pixel[k] + 0.5 - ON_CENTRE).ceil() - 1.0);
        let count = |k: usize| (last[k] - first[k] + 1.0).max(1.0) as usize;
        Pixels { columns: count(0), rows: count(1), pixel, origin: [0, 1].map(|k| anchor[k] + first[k] * pixel[k]) }
    }

    /// How many there are; too many for a whole number of 64 bits count as the most.
    pub fn count(&self) -> u64 {
        (self.columns as u64).saturating_mul(self.rows as u64)
    }

    /// Whether they are, to the rounding of places, the same pixels.
    pub fn same(&self, other: &Pixels) -> bool {
        let near = |k: usize, count: usize| {
            let ends = (self.pixel[k] - other.pixel[k]).abs() * count as f64;
            (self.origin[k] - other.origin[k]).abs().max(ends) <= ON_CENTRE * self.pixel[k]
        };
        (self.columns, self.rows) == (other.columns, other.rows) && near(0, self.columns) && near(1, self.rows)
    }

    /// The least and the greatest place that their cells reach.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let counts = [self.columns as f64, self.rows as f64];
        let low = [0, 1].map(|k| self.origin[k] - 0.5 * self.pixel[k]);
        [low, [0, 1].map(|k| low[k] + counts[k] * self.pixel[k])]
    }
}

/// `grid` on the pixels `wanted`; `place_in` takes a place of theirs into the grid's frame.
pub(super) fn resample(grid: &Grid, wanted: &Pixels, place_in: impl Fn([f64; 2]) -> [f64; 2] + Sync) -> Grid {
    let mut values = vec![f64::NAN; wanted.columns * wanted.rows];
    values.par_chunks_mut(wanted.columns).enumerate().for_each(|(row, line)| {
        for (column, value) in line.iter_mut().enumerate() {
            let x = wanted.origin[0] + column as f64 * wanted.pixel[0];
            let y = wanted.origin[1] + row as f64 * wanted.pixel[1];
            *value = value_at(grid, place_in([x, y]));
        }
    });
    let Pixels { columns, rows, pixel, origin } = *wanted;
    Grid { columns, rows, pixel, origin, values }
}

/// `grid` on the pixels `wanted` of the same frame.
pub(super) fn onto(grid: &Grid, wanted: &Pixels) -> Grid {
    if Pixels::of(grid).same(wanted) { grid.clone() } else { resample(grid, wanted, |place| place) }
}

/// The value at a place of the grid's frame, NaN where it is unknown.
pub(super) fn value_at(grid: &Grid, [x, y]: [f64; 2]) -> f64 {
    let Some((column, u)) = cell((x - grid.origin[0]) / grid.pixel[0], grid.columns) else { return f64::NAN };
    let Some((row, v)) = cell((y - grid.origin[1]) / grid.pixel[1], grid.rows) else { return f64::NAN };
    // NaN where there is no pixel either, and nothing at all of a pixel whose weight is zero.
    let weighted = |across: &[f64; 4], down: &[f64; 4]| {
        let mut sum = 0.0;
        for (r, wr) in down.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            for (c, wc) in across.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                let (row, column) = ((row + r).checked_sub(1), (column + c).checked_sub(1));
                let value = match (row, column) {
                    (Some(row), Some(column)) if row < grid.rows && column < grid.columns => grid.at(row, column),
                    _ => f64::NAN,
                };
                sum += wr * wc * value;
            }
        }
        sum
    };
    let smooth = weighted(&keys(u), &keys(v));
    // A cubic that passes over an unknown pixel is unknown; the four around decide alone then.
    if smooth.is_nan() { weighted(&[0.0, 1.0 - u, u, 0.0], &[0.0, 1.0 - v, v, 0.0]) } else { smooth }
}

/// Index of the pixel at or before `at` (in pixels) and the part of the way to the next; `None` beyond the outermost centres.
fn cell(at: f64, count: usize) -> Option<(usize, f64)> {
    let nearest = at.round();
    let at = if (at - nearest).abs() <= ON_CENTRE { nearest } else { at };
    if !(at >= 0.0 && at <= count as f64 - 1.0) {
        return None;
    }
    Some((at as usize, at - at.floor()))
}

/// Keys' weights of the pixels -1, 0, 1, 2 for a place `t` of the way from 0 to 1.
fn keys(t: f64) -> [f64; 4] {
    if t == 0.0 {
        return [0.0, 1.0, 0.0, 0.0];
    }
    [
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    ]
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn grid(columns: usize, rows: usize, height: impl Fn(f64, f64) -> f64) -> Grid {
        let mut grid = Grid { columns, rows, pixel: [2.0, 3.0], origin: [10.0, -5.0], values: Vec::new() };
        for i in 0..columns * rows {
            let [x, y] = grid.position(i / columns, i % columns);
            grid.values.push(height(x, y));
        }
        grid
    }

    #[test]
    fn parabolas_are_reproduced_and_pixels_keep_their_values() {
        let f = |x: f64, y: f64| 0.3 * x * x - 0.7 * x * y + 0.2 * y * y - x + 4.0;
        let map = grid(9, 8, f);
        for place in [[14.5, 0.0], [17.3, 6.1], [20.0, 4.0], [13.1, 9.9]] {
            assert!((value_at(&map, place) - f(place[0], place[1])).abs() < 1e-12, "{place:?}");
        }
        for i in 0..72 {
            assert_eq!(value_at(&map, map.position(i / 9, i % 9)), map.values[i]);
        }
        // Near the border the four pixels around decide: a plane is kept.
        let plane = grid(9, 8, |x, y| 2.0 * x - y);
        assert!((value_at(&plane, [10.7, -4.0]) - (21.4 + 4.0)).abs() < 1e-12);
        assert!(value_at(&plane, [9.9, 0.0]).is_nan() && value_at(&plane, [12.0, 16.1]).is_nan());
    }

    #[test]
    fn waves_lose_what_the_module_says() {
        // Halfway: (9 cos(pi/p) - cos(3 pi/p)) / 8 of the amplitude.
        for (period, lost) in [(16.0, 0.00055), (8.0, 0.0085), (4.0, 0.116)] {
            let map = grid(65, 5, |x, _| (PI * (x - 10.0) / period).cos());
            let kept = value_at(&map, [10.0 + 2.0 * 32.5, 1.0]) / (PI * 65.0 / period).cos();
            let expected = (9.0 * (PI / period).cos() - (3.0 * PI / period).cos()) / 8.0;
            assert!((kept - expected).abs() < 1e-9 && (1.0 - kept - lost).abs() < 0.05 * lost, "{period}: {kept}");
        }
    }

    #[test]
    fn an_unknown_pixel_never_becomes_a_height() {
        let mut map = grid(9, 8, |_, _| 1.0);
        map.values[4 * 9 + 4] = f64::NAN;
        for (x, y) in [(0.4, 0.0), (-0.7, 0.5), (0.99, 0.99), (0.0, 0.0)] {
            assert!(value_at(&map, [18.0 + 2.0 * x, 7.0 + 3.0 * y]).is_nan(), "{x} {y}");
        }
        for (x, y) in [(1.0, 0.0), (1.3, 0.2), (-1.2, -1.5), (0.3, 1.0)] {
            assert!((value_at(&map, [18.0 + 2.0 * x, 7.0 + 3.0 * y]) - 1.0).abs() < 1e-12, "{x} {y}");
        }
    }

    #[test]
    fn pixels_cover_their_box_and_no_more() {
        let pixels = Pixels::covering([-5.0, -2.0], [5.0, 3.2], [1.0, 2.0], [0.5, 0.0]);
        // Cells from -5 to 5 along x; along y cells -3 .. -1, -1 .. 1, 1 .. 3, 3 .. 5.
        assert_eq!((pixels.columns, pixels.rows, pixels.origin), (10, 4, [-4.5, -2.0]));
        let way = Similarity { scale: 1.2, rotation: 0.7, shift: [3.0, -4.0] };
        let [x, y] = way.inverse().apply(way.apply([5.0, 6.0]));
        assert!((x - 5.0).abs() < 1e-12 && (y - 6.0).abs() < 1e-12);
    }
}
