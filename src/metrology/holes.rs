//! Holes: pixels that the part needs and the instrument did not see.
//!
//! In: a grid, and which of its pixels are needed. Out: the holes as lists of pixels, and, for those that may be filled,
//! the values of the smooth surface that spans their rim.
//!
//! A hole is filled by the harmonic function of its rim (every pixel becomes the weighted mean of its eight neighbours):
//! it has no bump of its own and stays between the lowest and the highest value of the rim, so a filled hole never asks
//! for more removal than its surroundings.

use crate::height_map::Grid;
use std::collections::VecDeque;

/// Needed pixels without a value, connected by sides or corners.
#[derive(Clone, Debug, PartialEq)]
pub struct Hole {
    /// Indices into the grid's values, ascending.
    pub pixels: Vec<usize>,
    /// Whether it goes on beyond what is needed, or to the end of the picture: then it is no hole in the map but a
    /// place where the map falls short.
    pub open: bool,
}

/// All holes of `grid` among the pixels marked in `needed`, in the order of their first pixel.
pub fn find(grid: &Grid, needed: &[bool]) -> Vec<Hole> {
    let missing = |i: usize| needed[i] && grid.values[i].is_nan();
    let mut seen = vec![false; grid.values.len()];
    let mut holes = Vec::new();
    for start in 0..grid.values.len() {
        if !missing(start) || seen[start] {
            continue;
        }
        seen[start] = true;
        let mut hole = Hole { pixels: Vec::new(), open: false };
        let mut queue = VecDeque::from([start]);
        while let Some(i) = queue.pop_front() {
            hole.pixels.push(i);
            let mut neighbours = 0;
            for (j, _) in neighbours_of(grid, i) {
                neighbours += 1;
                if missing(j) && !seen[j] {
                    seen[j] = true;
                    queue.push_back(j);
                }
                hole.open |= !needed[j] && grid.values[j].is_nan();
            }
            hole.open |= neighbours < 8;
        }
        hole.pixels.sort_unstable();
        holes.push(hole);
    }
    holes
}

/// Fills the hole from its rim; `false`, and nothing filled, if no pixel of the rim is known.
///
/// The equations (weighted graph Laplacian: 1/dx² and 1/dy² to the sides, 1/(dx² + dy²) to the corners) are symmetric
/// and positive definite as soon as one rim pixel is known, and are solved by conjugate gradients, scaled by the
/// diagonal, until the residual is 1e-9 of the rim's: far below any instrument's noise. Each pixel is an exact convex
/// mean in the limit.
pub fn fill(grid: &mut Grid, hole: &Hole) -> bool {
    let count = hole.pixels.len();
    // Values are taken relative to the rim's mean, so that the residual measures the rim's variation.
    let (mut rim_sum, mut rim_count) = (0.0, 0.0);
    for i in &hole.pixels {
        for (j, _) in neighbours_of(grid, *i) {
            if !grid.values[j].is_nan() {
                rim_sum += grid.values[j];
                rim_count += 1.0;
            }
        }
    }
    if rim_count == 0.0 {
        return false;
    }
    let level = rim_sum / rim_count;

    // Row by row: the diagonal, the right side from the rim, and the links inside the hole.
    let mut diagonal = Vec::with_capacity(count);
    let mut right = Vec::with_capacity(count);
    let mut links: Vec<(usize, f64)> = Vec::with_capacity(8 * count);
    let mut starts = Vec::with_capacity(count + 1);
    for i in &hole.pixels {
        starts.push(links.len());
        let (mut sum, mut b) = (0.0, 0.0);
        for (j, weight) in neighbours_of(grid, *i) {
            if !grid.values[j].is_nan() {
                sum += weight;
                b += weight * (grid.values[j] - level);
            } else if let Ok(k) = hole.pixels.binary_search(&j) {
                sum += weight;
                links.push((k, weight));
            }
        }
        diagonal.push(sum);
        right.push(b);
    }
    starts.push(links.len());

    let solution = conjugate_gradients(&diagonal, &right, |x, out| {
        for k in 0..count {
            let inside: f64 = links[starts[k]..starts[k + 1]].iter().map(|(j, weight)| weight * x[*j]).sum();
            out[k] = diagonal[k] * x[k] - inside;
        }
    });
    for (i, value) in hole.pixels.iter().zip(solution) {
        grid.values[*i] = level + value;
    }
    true
}

/// Solves `apply(x) = right` for a symmetric positive definite operator with the given diagonal.
fn conjugate_gradients(diagonal: &[f64], right: &[f64], apply: impl Fn(&[f64], &mut [f64])) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let scaled = |r: &[f64]| r.iter().zip(diagonal).map(|(r, d)| r / d).collect::<Vec<f64>>();
    let count = right.len();
    let mut x = vec![0.0; count];
    let mut residual = right.to_vec();
    let mut direction = scaled(&residual);
    let mut product = vec![0.0; count];
    let mut size = dot(&residual, &direction);
    let enough = 1e-18 * size;
    // In exact arithmetic `count` steps suffice; rounding asks for a few more.
    for _ in 0..2 * count + 10 {
        if size <= enough {
            break;
        }
        apply(&direction, &mut product);
        let step = size / dot(&direction, &product);
        for k in 0..count {
            x[k] += step * direction[k];
            residual[k] -= step * product[k];
        }
        let next = scaled(&residual);
        let next_size = dot(&residual, &next);
        let turn = next_size / size;
        for k in 0..count {
            direction[k] = next[k] + turn * direction[k];
        }
        size = next_size;
    }
    x
}

/// The up to eight neighbours of a pixel with the weights of their links, in order.
fn neighbours_of(grid: &Grid, i: usize) -> impl Iterator<Item = (usize, f64)> + use<> {
    let (columns, rows) = (grid.columns as isize, grid.rows as isize);
    let (row, column) = ((i / grid.columns) as isize, (i % grid.columns) as isize);
    let [dx2, dy2] = [grid.pixel[0] * grid.pixel[0], grid.pixel[1] * grid.pixel[1]];
    // Relative to the x link, so that the weights are numbers near one.
    let [side_x, side_y, corner] = [1.0, dx2 / dy2, dx2 / (dx2 + dy2)];
    [
        (-1, -1, corner),
        (-1, 0, side_y),
        (-1, 1, corner),
        (0, -1, side_x),
        (0, 1, side_x),
        (1, -1, corner),
        (1, 0, side_y),
        (1, 1, corner),
    ]
    .into_iter()
    .filter_map(move |(dr, dc, weight)| {
        let (r, c) = (row + dr, column + dc);
        (r >= 0 && r < rows && c >= 0 && c < columns).then_some(((r * columns + c) as usize, weight))
    })
}
