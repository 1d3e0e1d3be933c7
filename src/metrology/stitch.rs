//! Stitch: maps of pieces of a part become one map.
//!
//! In: grids of the part frame, which overlap. Out: one grid over all of them, and how well they agree where they overlap.
//!
//! No interferometer knows piston and tilt of a piece. They are found, for all pieces but the first, which keeps its own, by
//! least squares over all pixels that two pieces know:
//!
//! ```text
//! minimise  sum over pairs i < j, over their common pixels, of ((h_i - q_i·b) - (h_j - q_j·b))²,   b = (1, x, y),  q_0 = 0
//! ```
//!
//! (M. Otsubo, K. Okada, J. Tsujiuchi, "Measurement of large plane surface shapes by connecting small-aperture
//! interferograms", Optical Engineering 33, 1994.) Where several pieces know a pixel, its height is their mean. Pieces are
//! brought onto the first one's pixels; each keeps its own box, so that room grows with what was measured.

use super::place::too_many_pixels;
use super::resample::{Pixels, onto};
use crate::diagnostics::{Problem, codes};
use crate::height_map::{Grid, MOST_PIXELS};
use rayon::prelude::*;

/// Fewest pixels on which two pieces must agree: ten each way. A tilt from fewer is noise, and is carried on over the piece.
const FEWEST_PIXELS: usize = 100;

/// Smallest pivot, against the largest of its kind, from which an unknown is still taken to be fixed: an overlap that is a line
/// of pixels gives rounding, 1e-16.
const LEAST_PIVOT: f64 = 1e-10;

/// How two pieces agree where they overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// Which pieces, from 0, in the order of the job.
    pub pieces: [usize; 2],
    pub pixels: usize,
    /// Root mean square of their difference once they are levelled, metres.
    pub rms: f64,
}

/// A piece on the pixels of the whole.
struct Piece {
    /// Column and row of its first pixel in the whole.
    first: [usize; 2],
    grid: Grid,
}

impl Piece {
    /// The height at a pixel of the whole; NaN outside.
    fn at(&self, column: usize, row: usize) -> f64 {
        let (Some(c), Some(r)) = (column.checked_sub(self.first[0]), row.checked_sub(self.first[1])) else {
            return f64::NAN;
        };
        if c < self.grid.columns && r < self.grid.rows { self.grid.at(r, c) } else { f64::NAN }
    }
}

/// What is summed up over an overlap: b bᵀ and b d, d the difference of two pieces.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: usize,
    bb: [[f64; 3]; 3],
    bd: [f64; 3],
}

/// Puts the pieces together. Fields are `maps`, `mismatch`.
///
/// # Errors
/// E0535 for pieces that do not overlap, E0536 for pieces that differ by more than `mismatch`, E0547 for too large a whole.
pub(super) fn stitch(grids: &[&Grid], mismatch: f64) -> Result<(Grid, Vec<Seam>), Problem> {
    let pixel = grids[0].pixel;
    let boxes: Vec<[[f64; 2]; 2]> = grids.iter().map(|grid| Pixels::of(grid).bounds()).collect();
    let anchor = grids[0].origin;
    let low = [0, 1].map(|k| boxes.iter().fold(f64::INFINITY, |low, b| low.min(b[0][k])));
    let high = [0, 1].map(|k| boxes.iter().fold(f64::NEG_INFINITY, |high, b| high.max(b[1][k])));
    let whole = Pixels::covering(low, high, pixel, anchor);
    if whole.count() > MOST_PIXELS {
        return Err(Problem { field: Some("maps".into()), ..too_many_pixels(&whole) });
    }
    let pieces: Vec<Piece> = grids
        .iter()
        .zip(&boxes)
        .map(|(grid, [low, high])| {
            let pixels = Pixels::covering(*low, *high, pixel, anchor);
            let first = [0, 1].map(|k| ((pixels.origin[k] - whole.origin[k]) / pixel[k]).round() as usize);
            Piece { first, grid: onto(grid, &pixels) }
        })
        .collect();

    // Places of pixels as numbers from -1 to 1, so that all sums are near one.
    let scale = [whole.columns, whole.rows].map(|n| 2.0 / (n as f64).max(2.0));
    let b = |column: usize, row: usize| [1.0, column as f64 * scale[0] - 1.0, row as f64 * scale[1] - 1.0];
    let pairs: Vec<(usize, usize)> = (0..pieces.len()).flat_map(|j| (0..j).map(move |i| (i, j))).collect();
    let overlaps: Vec<Sums> = pairs.par_iter().map(|(i, j)| overlap(&pieces[*i], &pieces[*j], b)).collect();
    all_connected(pieces.len(), &pairs, &overlaps)?;
    let levels = level(pieces.len(), &pairs, &overlaps)?;

    // The sums would give the difference of large numbers: what is left is looked at pixel by pixel.
    let left = |((i, j), sums): (&(usize, usize), &Sums)| {
        let q: [f64; 3] = std::array::from_fn(|k| levels[*i][k] - levels[*j][k]);
        let mut squares = 0.0;
        each_common(&pieces[*i], &pieces[*j], |column, row, d| {
            let b = b(column, row);
            let rest = d - (q[0] * b[0] + q[1] * b[1] + q[2] * b[2]);
            squares += rest * rest;
        });
        Seam { pieces: [*i, *j], pixels: sums.count, rms: (squares / sums.count as f64).sqrt() }
    };
    let overlapping: Vec<_> = pairs.iter().zip(&overlaps).filter(|(_, sums)| sums.count > 0).collect();
    let seams: Vec<Seam> = overlapping.into_par_iter().map(left).collect();
    if let Some(worst) = seams.iter().max_by(|a, b| a.rms.total_cmp(&b.rms)).filter(|seam| seam.rms > mismatch) {
        let message = format!(
            "maps {} and {} differ by {:.3} nm RMS where they overlap; {:.3} nm are allowed",
            worst.pieces[0] + 1,
            worst.pieces[1] + 1,
            worst.rms * 1e9,
            mismatch * 1e9
        );
        return Err(Problem::error(codes::E0536, "mismatch", message)
            .note("the difference is what piston and tilt of each map do not explain")
            .help("check `centre`, `up` and `view` of both: a piece that lies wrong by a few pixels shows so"));
    }

    let mut values = vec![f64::NAN; whole.columns * whole.rows];
    values.par_chunks_mut(whole.columns).enumerate().for_each(|(row, line)| {
        for (column, value) in line.iter_mut().enumerate() {
            let b = b(column, row);
            let (mut sum, mut count) = (0.0, 0.0);
            for (piece, q) in pieces.iter().zip(&levels) {
                let height = piece.at(column, row);
                if !height.is_nan() {
                    sum += height - (q[0] * b[0] + q[1] * b[1] + q[2] * b[2]);
                    count += 1.0;
                }
            }
            if count > 0.0 {
                *value = sum / count;
            }
        }
    });
    let Pixels { columns, rows, pixel, origin } = whole;
    Ok((Grid { columns, rows, pixel, origin, values }, seams))
}

/// Calls `see(column, row, difference)` for every pixel of the whole that both pieces know.
fn each_common(one: &Piece, other: &Piece, mut see: impl FnMut(usize, usize, f64)) {
    let end = |piece: &Piece| [piece.first[0] + piece.grid.columns, piece.first[1] + piece.grid.rows];
    let start = [0, 1].map(|k| one.first[k].max(other.first[k]));
    let stop = [0, 1].map(|k| end(one)[k].min(end(other)[k]));
    for row in start[1]..stop[1] {
        for column in start[0]..stop[0] {
            let d = one.at(column, row) - other.at(column, row);
            if !d.is_nan() {
                see(column, row, d);
            }
        }
    }
}

fn overlap(one: &Piece, other: &Piece, b: impl Fn(usize, usize) -> [f64; 3]) -> Sums {
    let mut sums = Sums::default();
    each_common(one, other, |column, row, d| {
        let b = b(column, row);
        sums.count += 1;
        for k in 0..3 {
            sums.bd[k] += b[k] * d;
            for l in 0..3 {
                sums.bb[k][l] += b[k] * b[l];
            }
        }
    });
    sums
}

/// E0535 unless every piece is joined to the first, over others if need be.
fn all_connected(count: usize, pairs: &[(usize, usize)], overlaps: &[Sums]) -> Result<(), Problem> {
    let mut joined = vec![false; count];
    joined[0] = true;
    // Each round joins at least one more piece, or none.
    for _ in 1..count {
        for ((i, j), _) in pairs.iter().zip(overlaps).filter(|(_, sums)| sums.count >= FEWEST_PIXELS) {
            if joined[*i] || joined[*j] {
                (joined[*i], joined[*j]) = (true, true);
            }
        }
    }
    let Some(lost) = joined.iter().position(|joined| !joined) else { return Ok(()) };
    let shared = pairs.iter().zip(overlaps).filter(|((i, j), _)| *i == lost || *j == lost).map(|(_, sums)| sums.count);
    let message = format!(
        "map {} does not overlap the others: it shares {} pixels with any of them, and {FEWEST_PIXELS} are needed",
        lost + 1,
        shared.max().unwrap_or(0)
    );
    Err(Problem::error(codes::E0535, format!("maps.{lost}"), message)
        .help("check `centre` of that map, or measure with more overlap"))
}

/// Piston and slopes of each piece, by the normal equations and Cholesky's factor. E0535 where an overlap does not fix them.
fn level(count: usize, pairs: &[(usize, usize)], overlaps: &[Sums]) -> Result<Vec<[f64; 3]>, Problem> {
    let n = 3 * (count - 1);
    let mut matrix = vec![0.0; n * n];
    let mut right = vec![0.0; n];
    for ((i, j), sums) in pairs.iter().zip(overlaps) {
        for k in 0..3 {
            // The first piece has no unknowns.
            let place = |piece: usize| piece.checked_sub(1).map(|p| 3 * p + k);
            for (at, sign) in [(place(*i), 1.0), (place(*j), -1.0)] {
                if let Some(at) = at {
                    right[at] += sign * sums.bd[k];
                }
            }
            for l in 0..3 {
                let column = |piece: usize| piece.checked_sub(1).map(|p| 3 * p + l);
                for (r, c, sign) in [
                    (place(*i), column(*i), 1.0),
                    (place(*j), column(*j), 1.0),
                    (place(*i), column(*j), -1.0),
                    (place(*j), column(*i), -1.0),
                ] {
                    if let (Some(r), Some(c)) = (r, c) {
                        matrix[r * n + c] += sign * sums.bb[k][l];
                    }
                }
            }
        }
    }
    // Lower triangle in place, row by row.
    for r in 0..n {
        let whole = matrix[r * n + r];
        for c in 0..=r {
            let known: f64 = (0..c).map(|k| matrix[r * n + k] * matrix[c * n + k]).sum();
            let rest = matrix[r * n + c] - known;
            if c < r {
                matrix[r * n + c] = rest / matrix[c * n + c];
            } else if rest > LEAST_PIVOT * whole {
                matrix[r * n + r] = rest.sqrt();
            } else {
                let message = format!("map {} overlaps the others only along a line", r / 3 + 2);
                return Err(Problem::error(codes::E0535, format!("maps.{}", r / 3 + 1), message)
                    .note("its tilt across that line is not known")
                    .help("measure with more overlap"));
            }
        }
    }
    for r in 0..n {
        let known: f64 = (0..r).map(|k| matrix[r * n + k] * right[k]).sum();
        right[r] = (right[r] - known) / matrix[r * n + r];
    }
    for r in (0..n).rev() {
        let known: f64 = (r + 1..n).map(|k| matrix[k * n + r] * right[k]).sum();
        right[r] = (right[r] - known) / matrix[r * n + r];
    }
    Ok(std::iter::once([0.0; 3]).chain(right.chunks_exact(3).map(|q| [q[0], q[1], q[2]])).collect())
}
