//! Slope: how steep a map is over a stated length.
//!
//! In: a grid, which of its pixels count, a length. Out: the RMS of the slope. Without a length a slope of a measured map says
//! nothing: noise of neighbouring pixels has any slope.

use crate::height_map::Grid;

/// Root mean square slopes, no dimension (radians).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlopeRms {
    /// Along x and along y.
    pub axes: [f64; 2],
    /// Of the gradient: the root of the sum of both squares.
    pub gradient: f64,
}

/// Of the known pixels marked in `counts`: central differences over `length`, `(h(x + length/2) - h(x - length/2)) /
/// length`, about their mean (so a tilt has no slope), along x and along y. The ends are read bilinearly; a pixel with
/// an end on an unknown pixel, or on one that does not count, is left out, so a rim half a length wide says
/// nothing. `None` where no pixel has a slope along each axis.
pub fn slope_rms(grid: &Grid, counts: &[bool], length: f64) -> Option<SlopeRms> {
    let mut axes = [0.0; 2];
    for (axis, rms) in axes.iter_mut().enumerate() {
        // In pixels, to a millionth: an end on the centre of a pixel must not ask for the one beyond it.
        let reach = (length / 2.0 / grid.pixel[axis] * 1e6).round() / 1e6;
        // An end that lies beyond the map from every pixel leaves no slope (and would overflow a place in it).
        if !(reach < [grid.columns, grid.rows][axis] as f64) {
            return None;
        }
        let (whole, part) = (reach.floor() as isize, reach - reach.floor());
        let value = |row: usize, column: usize, steps: isize| -> f64 {
            let (row, column) = match axis {
                0 => (row as isize, column as isize + steps),
                _ => (row as isize + steps, column as isize),
            };
            if row < 0 || column < 0 || row >= grid.rows as isize || column >= grid.columns as isize {
                return f64::NAN;
            }
            let i = row as usize * grid.columns + column as usize;
            if counts[i] { grid.values[i] } else { f64::NAN }
        };
        let end = |row, column, sign: isize| {
            let near = value(row, column, sign * whole);
            // NaN times zero is NaN.
            if part == 0.0 { near } else { (1.0 - part) * near + part * value(row, column, sign * (whole + 1)) }
        };
        let (mut count, mut mean, mut squares) = (0.0, 0.0, 0.0);
        for row in 0..grid.rows {
            for column in 0..grid.columns {
                let slope = (end(row, column, 1) - end(row, column, -1)) / length;
                if counts[row * grid.columns + column] && !slope.is_nan() {
                    // Welford's running mean and sum of squares.
                    count += 1.0;
                    let off = slope - mean;
                    mean += off / count;
                    squares += off * (slope - mean);
                }
            }
        }
        if count == 0.0 {
            return None;
        }
        *rms = (squares / count).sqrt();
    }
    Some(SlopeRms { axes, gradient: libm::hypot(axes[0], axes[1]) })
}
