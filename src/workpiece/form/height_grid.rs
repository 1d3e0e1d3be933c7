//! Height grid: the heights of a file on a base, between the pixels a bicubic spline.
//!
//! In: the form, the bytes of its file. Out: a surface whose first and second derivatives are continuous everywhere. It
//! passes through the middle of every pixel and exists between the outermost ones.
//!
//! The spline is the tensor product of cubic B-splines with not-a-knot ends (de Boor, A Practical Guide to Splines, chapter
//! IV): a polynomial of third degree in x and y is met exactly. In one dimension, with values f and coefficients c,
//! `f_i = (c_(i-1) + 4 c_i + c_(i+1)) / 6`. At the second knot the fourth difference of c vanishes (no knot there), so
//! that the second differences of c and of f agree: `c_1 = f_1 - (f_0 - 2 f_1 + f_2) / 6`, which leaves a tridiagonal
//! system between the second and the last but one.

use super::{Surface, SurfacePoint, sign_of};
use crate::diagnostics::{Problem, codes};
use crate::height_map::{Grid, Picture, lay, read_file};
use crate::job::{HeightGrid, View};
use crate::source::FileProvider;

/// A bicubic spline through the values of a grid.
#[derive(Debug)]
pub struct Spline {
    columns: usize,
    rows: usize,
    pixel: [f64; 2],
    origin: [f64; 2],
    /// Row-major, one more than the pixels on every side.
    coefficients: Vec<f64>,
}

/// Fewest pixels along a side: with fewer the spline is not fixed.
pub const FEWEST_PIXELS: usize = 4;

impl Spline {
    /// Through all values of a grid, which must be known. `None` if it has fewer than four pixels along a side.
    pub fn through(grid: &Grid) -> Option<Spline> {
        let (columns, rows) = (grid.columns, grid.rows);
        if columns < FEWEST_PIXELS || rows < FEWEST_PIXELS {
            return None;
        }
        // Along x, then along y.
        let wide = columns + 2;
        let mut along_x = vec![0.0; wide * rows];
        for (line, values) in along_x.chunks_exact_mut(wide).zip(grid.values.chunks_exact(columns)) {
            coefficients(values, line);
        }
        let mut all = vec![0.0; wide * (rows + 2)];
        let (mut column, mut solved) = (vec![0.0; rows], vec![0.0; rows + 2]);
        for i in 0..wide {
            for (row, value) in column.iter_mut().enumerate() {
                *value = along_x[row * wide + i];
            }
            coefficients(&column, &mut solved);
            for (row, value) in solved.iter().enumerate() {
                all[row * wide + i] = *value;
            }
        }
        Some(Spline { columns, rows, pixel: grid.pixel, origin: grid.origin, coefficients: all })
    }

    /// Height, slope and second derivatives at a place in metres; `None` outside the middles of the outermost pixels.
    pub fn at(&self, x: f64, y: f64) -> Option<SurfacePoint> {
        let (column, bx) = basis((x - self.origin[0]) / self.pixel[0], self.columns)?;
        let (row, by) = basis((y - self.origin[1]) / self.pixel[1], self.rows)?;
        let wide = self.columns + 2;
        // Sums along x of the value and its two derivatives, for each of the four rows.
        let mut sums = [[0.0; 3]; 3];
        for (j, line) in self.coefficients[row * wide..].chunks_exact(wide).take(4).enumerate() {
            let line = &line[column..column + 4];
            let along = |b: &[f64; 4]| line[0] * b[0] + line[1] * b[1] + line[2] * b[2] + line[3] * b[3];
            let x_sums = bx.each_ref().map(along);
            for (sum, weights) in sums.iter_mut().zip(&by) {
                for (sum, x_sum) in sum.iter_mut().zip(x_sums) {
                    *sum += weights[j] * x_sum;
                }
            }
        }
        let [dx, dy] = self.pixel;
        Some(SurfacePoint {
            sag: sums[0][0],
            slope: [sums[0][1] / dx, sums[1][0] / dy],
            second: [sums[0][2] / (dx * dx), sums[1][1] / (dx * dy), sums[2][0] / (dy * dy)],
        })
    }
}

/// The interval of `at` (in pixels), and in it the four B-splines with their first and second derivatives.
fn basis(at: f64, count: usize) -> Option<(usize, [[f64; 4]; 3])> {
    let last = (count - 1) as f64;
    // The rounding of a place in metres to pixels: a place on the border belongs to the surface.
    let tolerance = 1e-9 * count as f64;
    if !(at >= -tolerance && at <= last + tolerance) {
        return None;
    }
    let at = at.max(0.0).min(last);
    let interval = (at as usize).min(count - 2);
    let t = at - interval as f64;
    let s = 1.0 - t;
    let values = [
        s * s * s / 6.0,
        (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
        (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
        t * t * t / 6.0,
    ];
    let first = [-s * s / 2.0, (3.0 * t * t - 4.0 * t) / 2.0, -(3.0 * s * s - 4.0 * s) / 2.0, t * t / 2.0];
    let second = [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t];
    Some((interval, [values, first, second]))
}

/// Coefficients of the not-a-knot cubic B-spline through `f`; `c` has one more at either end.
fn coefficients(f: &[f64], c: &mut [f64]) {
    let n = f.len();
    // c[i + 1] stands under f[i].
    let near_end = |i: usize| f[i] - (f[i - 1] - 2.0 * f[i] + f[i + 1]) / 6.0;
    c[2] = near_end(1);
    c[n - 1] = near_end(n - 2);
    // c_(i-1) + 4 c_i + c_(i+1) = 6 f_i for i = 2 .. n - 3, both neighbours known: Thomas' algorithm, whose pivots of a
    // dominant diagonal need no exchange.
    let inner = 2..n - 2;
    let mut ratio = vec![0.0; n];
    let mut before = 0.0;
    for i in inner.clone() {
        let mut right = 6.0 * f[i];
        if i == 2 {
            right -= c[2];
        }
        if i == n - 3 {
            right -= c[n - 1];
        }
        let earlier = if i == 2 { 0.0 } else { c[i] };
        ratio[i] = 1.0 / (4.0 - before);
        c[i + 1] = (right - earlier) * ratio[i];
        before = ratio[i];
    }
    for i in inner.rev().skip(1) {
        c[i + 1] -= ratio[i] * c[i + 2];
    }
    c[1] = 6.0 * f[1] - 4.0 * c[2] - c[3];
    c[0] = 6.0 * f[0] - 4.0 * c[1] - c[2];
    c[n] = 6.0 * f[n - 2] - 4.0 * c[n - 1] - c[n - 2];
    c[n + 1] = 6.0 * f[n - 1] - 4.0 * c[n] - c[n - 1];
}

/// Heights of a file on a base.
#[derive(Debug)]
pub struct HeightField {
    base: Box<dyn Surface>,
    spline: Spline,
}

impl HeightField {
    pub fn new(job: &HeightGrid, base: Box<dyn Surface>, files: &dyn FileProvider) -> Result<HeightField, Problem> {
        let raw = read_file(&job.file, files)?;
        let pixel = raw.pixel_pitch(job.pixel.map(|length| length.0))?;
        let sign = sign_of(job.sag);
        let mut values = raw.metres(job.unit.map(|length| length.0))?;
        values.iter_mut().for_each(|value| *value *= sign);
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let (row, column) = (at / raw.columns, at % raw.columns);
            let message = format!("the form's file knows no height in row {row}, column {column}");
            return Err(Problem::error(codes::E0605, "file", message)
                .note("a nominal form must be known in the whole rectangle of its file, or its slopes are guessed")
                .help("export the design on a full rectangle that reaches beyond the path"));
        }
        let picture = Picture { columns: raw.columns, rows: raw.rows, pixel, values };
        let centre = picture.centre(&job.centre);
        let grid = lay(&picture, job.up, job.view == View::from_back, centre);
        let Some(spline) = Spline::through(&grid) else {
            let message = format!(
                "the form's file has {} columns and {} rows; a spline needs {FEWEST_PIXELS} of each",
                raw.columns, raw.rows
            );
            return Err(Problem::error(codes::E0605, "file", message).help("export the design with more pixels"));
        };
        Ok(HeightField { base, spline })
    }
}

impl Surface for HeightField {
    fn at(&self, x: f64, y: f64) -> Option<SurfacePoint> {
        Some(self.base.at(x, y)?.plus(&self.spline.at(x, y)?, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn grid(columns: usize, rows: usize, height: impl Fn(f64, f64) -> f64) -> Grid {
        let mut grid = Grid {
            columns,
            rows,
            pixel: [2e-3, 3e-3],
            origin: [-0.01, -0.02],
            values: Vec::with_capacity(columns * rows),
        };
        for i in 0..columns * rows {
            let [x, y] = grid.position(i / columns, i % columns);
            grid.values.push(height(x, y));
        }
        grid
    }

    /// A bicubic polynomial is its own not-a-knot spline, on every size of grid and up to the border.
    #[test]
    fn polynomials_of_third_degree_are_met() {
        let f = |x: f64, y: f64| 0.3 * x * x * x - x * y * y + 2.0 * x * x * y * y * y + 0.5 * y - 0.01;
        for (columns, rows) in [(4, 4), (5, 4), (6, 5), (7, 9), (30, 20)] {
            let spline = Spline::through(&grid(columns, rows, f)).expect("enough pixels");
            let (wide, high) = ((columns - 1) as f64 * 2e-3, (rows - 1) as f64 * 3e-3);
            for (a, b) in [(0.0, 0.0), (1.0, 1.0), (0.37, 0.81), (0.5, 0.02), (0.99, 0.4)] {
                let (x, y) = (-0.01 + a * wide, -0.02 + b * high);
                let found = spline.at(x, y).expect("inside");
                assert!((found.sag - f(x, y)).abs() < 1e-16, "{columns} {rows} {a} {b}");
                let slope = [0.9 * x * x - y * y + 4.0 * x * y * y * y, -2.0 * x * y + 6.0 * x * x * y * y + 0.5];
                assert!((0..2).all(|i| (found.slope[i] - slope[i]).abs() < 1e-12), "{found:?} {slope:?}");
                let second = [1.8 * x + 4.0 * y * y * y, -2.0 * y + 12.0 * x * y * y, -2.0 * x + 12.0 * x * x * y];
                assert!((0..3).all(|i| (found.second[i] - second[i]).abs() < 1e-9), "{found:?} {second:?}");
            }
            assert!(spline.at(-0.01 - 1e-6, 0.0).is_none() && spline.at(0.0, -0.02 + high + 1e-6).is_none());
        }
        assert!(Spline::through(&grid(3, 9, f)).is_none());
    }

    /// A sphere of 300 mm radius on pixels of 2 x 3 mm: a cubic spline is off by at most (5/384) h⁴ of the fourth derivative,
    /// 3/R³ = 111 /m³ in the middle: 1.4e-10 m for both axes; its slope by h³/24 of it: 1.3e-7. Towards the rim the
    /// derivative grows a little.
    #[test]
    fn a_sphere_is_met_closely() {
        let sphere = |x: f64, y: f64| 0.3 - (0.09 - x * x - y * y).sqrt();
        let spline = Spline::through(&grid(41, 31, sphere)).expect("enough pixels");
        for (x, y) in [(0.0011, 0.0007), (0.013, -0.0093), (0.0307, 0.0211)] {
            let found = spline.at(x, y).expect("inside");
            let root = (0.09 - x * x - y * y).sqrt();
            assert!((found.sag - sphere(x, y)).abs() < 2e-10);
            assert!((found.slope[0] - x / root).abs() < 2e-7 && (found.slope[1] - y / root).abs() < 2e-7);
        }
    }

    proptest! {
        // Through every value, and smooth: derivatives agree from both sides of a pixel's middle.
        #[test]
        fn the_spline_passes_through_every_pixel(values in prop::collection::vec(-1.0f64..1.0, 7 * 6)) {
            let mut any = grid(7, 6, |_, _| 0.0);
            any.values = values;
            let spline = Spline::through(&any).expect("enough pixels");
            for i in 0..42 {
                let [x, y] = any.position(i / 7, i % 7);
                prop_assert!((spline.at(x, y).expect("inside").sag - any.values[i]).abs() < 1e-13);
            }
            for (column, row) in [(1.0, 2.3), (3.0, 3.0), (4.6, 4.0)] {
                let place = |e: f64| (-0.01 + (column + e) * 2e-3, -0.02 + (row + e) * 3e-3);
                let ((ax, ay), (bx, by)) = (place(-1e-9), place(1e-9));
                let (a, b) = (spline.at(ax, ay).expect("inside"), spline.at(bx, by).expect("inside"));
                // Slopes are up to some thousand, curvatures some million; their change over 4e-12 m is invisible.
                prop_assert!((0..2).all(|i| (a.slope[i] - b.slope[i]).abs() < 1e-3));
                prop_assert!((0..3).all(|i| (a.second[i] - b.second[i]).abs() < 10.0));
            }
        }
    }
}
