//! Fit: linear least squares over the pixels of a map.
//!
//! In: a grid, which of its pixels count, and the functions to be fitted. Out: their coefficients, or those of a part of
//! them.
//!
//! The pixels go through faer's QR in blocks of fixed size, and the triangles that come out are put on each other
//! and go through it again, so that a million pixels with 37 functions never stand in one matrix, and the order of the
//! arithmetic does not depend on the number of threads. faer chooses its instructions by the processor: coefficients
//! are rounded to a femtometre, a millionth of what an interferometer resolves, before anything is made of them.
//! (J. Demmel and others, "Communication-optimal parallel and sequential QR", SIAM J. Sci. Comput. 34, 2012.)

use crate::height_map::Grid;
use faer::Mat;
use rayon::prelude::*;

/// Pixels of one block: with 37 functions half a megabyte, which a second-level cache holds.
const BLOCK: usize = 2048;

/// Triangles that are put on each other at once.
const STACK: usize = 32;

/// Smallest pivot, against the largest, from which a function is still taken to be fixed by the pixels: Zernike
/// polynomials are nearly orthogonal over a disc and over most parts of one, while pixels on a line or too few give
/// rounding, 1e-16.
const LEAST_PIVOT: f64 = 1e-9;

/// Coefficients are rounded to this, in the unit of the map: a femtometre.
const QUANTUM: f64 = 1e-15;

/// A least-squares problem, triangular.
pub(super) struct Fit {
    /// Upper triangle of the functions, with the right side as a last column: `functions + 1` square.
    triangle: Mat<f64>,
    functions: usize,
    /// How many pixels took part.
    pub count: usize,
}

impl Fit {
    /// Over the known pixels marked in `counts`. `values([x, y], out)` gives the functions at a place in metres.
    pub fn over(grid: &Grid, counts: &[bool], functions: usize, values: impl Fn([f64; 2], &mut [f64]) + Sync) -> Fit {
        let used: Vec<usize> = (0..grid.values.len()).filter(|i| counts[*i] && !grid.values[*i].is_nan()).collect();
        let block = |pixels: &[usize]| {
            let mut rows = Mat::zeros(pixels.len(), functions + 1);
            let mut line = vec![0.0; functions];
            for (r, i) in pixels.iter().enumerate() {
                values(grid.position(i / grid.columns, i % grid.columns), &mut line);
                for (k, value) in line.iter().enumerate() {
                    rows[(r, k)] = *value;
                }
                rows[(r, functions)] = grid.values[*i];
            }
            triangle(&rows)
        };
        let mut triangles: Vec<Mat<f64>> = used.par_chunks(BLOCK).map(block).collect();
        while triangles.len() > 1 {
            triangles = triangles.par_chunks(STACK).map(stacked).collect();
        }
        let mut whole = Mat::zeros(functions + 1, functions + 1);
        if let Some(last) = triangles.first() {
            for r in 0..last.nrows() {
                for c in r..functions + 1 {
                    whole[(r, c)] = last[(r, c)];
                }
            }
        }
        Fit { triangle: whole, functions, count: used.len() }
    }

    /// The coefficients of the functions that are `wanted`, each made orthogonal to all before it: what is taken off with
    /// them is the wanted part of the joint fit, and what is not wanted stays in the map as it is. With all wanted, the
    /// plain least-squares fit. `None` where the pixels do not fix the functions.
    pub fn coefficients(&self, wanted: impl Fn(usize) -> bool) -> Option<Vec<f64>> {
        let n = self.functions;
        let largest = (0..n).map(|k| self.triangle[(k, k)].abs()).fold(0.0, f64::max);
        let mut solution = vec![0.0; n];
        for k in (0..n).rev() {
            let pivot = self.triangle[(k, k)];
            if !(pivot.abs() > LEAST_PIVOT * largest) {
                return None;
            }
            let known: f64 = (k + 1..n).map(|j| self.triangle[(k, j)] * solution[j]).sum();
            let right = if wanted(k) { self.triangle[(k, n)] } else { 0.0 };
            solution[k] = (right - known) / pivot;
        }
        Some(solution.into_iter().map(|a| (a / QUANTUM).round() * QUANTUM).collect())
    }
}

/// The triangular factor of a matrix, with as many rows as it has rows or columns, whichever is less.
fn triangle(rows: &Mat<f64>) -> Mat<f64> {
    rows.qr().thin_R().to_owned()
}

/// The triangular factor of triangles on each other.
fn stacked(triangles: &[Mat<f64>]) -> Mat<f64> {
    let height = triangles.iter().map(|t| t.nrows()).sum();
    let mut rows = Mat::zeros(height, triangles[0].ncols());
    let mut first = 0;
    for t in triangles {
        for r in 0..t.nrows() {
            for c in 0..t.ncols() {
                rows[(first + r, c)] = t[(r, c)];
            }
        }
        first += t.nrows();
    }
    triangle(&rows)
}
