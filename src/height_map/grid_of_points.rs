//! The grid of points: a list of x, y and height, in any order, becomes a picture.
//!
//! In: coordinates and heights. Out: columns, rows, pitch in the list's own unit, and the heights with the greatest y on
//! top; a place without a point is NaN.

use super::proved_pixels;
use super::refusals::no_grid;
use crate::diagnostics::Problem;

/// How far a point may lie from its place on the grid, in pitches: instruments print coordinates with few digits.
const OFF_THE_GRID: f64 = 0.05;

/// Least part of the places that have a point. A ring as narrow as a tenth of its radius in its own square fills 0.15;
/// points that fill less were not measured on this grid.
const FILLED: f64 = 0.1;

/// How far both pitches may differ where their unit is not stated: then a pixel has one side, which the job states.
const SQUARE: f64 = 1e-3;

pub(super) struct Picture {
    pub columns: usize,
    pub rows: usize,
    /// Along x and y, in the unit of the coordinates.
    pub pitch: [f64; 2],
    /// Row-major from the top.
    pub values: Vec<f64>,
}

/// Puts the points on their grid; all three lists are of one length. E0516 if there is none, E0501 if it is too large.
pub(super) fn grid(x: &[f64], y: &[f64], heights: &[f64], name: &str) -> Result<Picture, Problem> {
    if let Some(at) = x.iter().zip(y).position(|(x, y)| !(x.is_finite() && y.is_finite())) {
        return Err(no_grid(name, format!("has no place for its point {}: x or y is not a number", at + 1)));
    }
    let (along_x, along_y) = (Axis::of(x, "x", name)?, Axis::of(y, "y", name)?);
    let pixels = proved_pixels(along_x.count, along_y.count, name)?;
    if (heights.len() as f64) < FILLED * pixels as f64 {
        let message = format!(
            "has {} points, too few for the {} x {} places that their distances ask for",
            heights.len(),
            along_x.count,
            along_y.count
        );
        return Err(no_grid(name, message));
    }
    let (columns, rows) = (along_x.count as usize, along_y.count as usize);
    let (mut values, mut seen) = (vec![f64::NAN; pixels], vec![false; pixels]);
    for (point, ((x, y), height)) in x.iter().zip(y).zip(heights).enumerate() {
        let (Some(column), Some(row)) = (along_x.place(*x), along_y.place(*y)) else {
            let message = format!("has its point {} at x = {x}, y = {y}, between the places of a grid", point + 1);
            return Err(no_grid(name, message));
        };
        let at = (rows - 1 - row) * columns + column;
        if std::mem::replace(&mut seen[at], true) {
            return Err(no_grid(name, format!("has two points at x = {x}, y = {y}")));
        }
        values[at] = *height;
    }
    Ok(Picture { columns, rows, pitch: [along_x.pitch, along_y.pitch], values })
}

/// E0516 if the two pitches differ.
pub(super) fn prove_square(pitch: [f64; 2], name: &str) -> Result<(), Problem> {
    if (pitch[0] / pitch[1] - 1.0).abs() <= SQUARE {
        return Ok(());
    }
    let message = format!("has points {} apart in x and {} in y, and does not name the unit", pitch[0], pitch[1]);
    Err(no_grid(name, message).help("name the units in a header: `x (mm), y (mm), z (nm)`"))
}

struct Axis {
    first: f64,
    pitch: f64,
    count: u64,
}

impl Axis {
    /// The pitch is the middle one of the distances between neighbours, made exact by the whole length.
    fn of(coordinates: &[f64], what: &str, name: &str) -> Result<Axis, Problem> {
        let mut sorted = coordinates.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let (Some(first), Some(last)) = (sorted.first().copied(), sorted.last().copied()) else {
            return Err(no_grid(name, "has no points"));
        };
        // Coordinates that were worked out differ in their last digits. Sixteen million places, the most that are read,
        // lie more than thirty times as far apart.
        let same = 1e-9 * (last - first);
        sorted.dedup_by(|next, before| *next - *before <= same);
        let mut steps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).collect();
        if steps.is_empty() {
            return Err(no_grid(name, format!("has all points at one {what}: that is a profile, not a map")));
        }
        let middle = steps.len() / 2;
        let (_, step, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
        let places = (last - first) / *step;
        if !places.is_finite() || places > super::MOST_PIXELS as f64 {
            return Err(no_grid(name, format!("has no common distance between its points in {what}")));
        }
        let count = places.round();
        Ok(Axis { first, pitch: (last - first) / count, count: count as u64 + 1 })
    }

    fn place(&self, coordinate: f64) -> Option<usize> {
        let at = (coordinate - self.first) / self.pitch;
        let place = at.round();
        ((at - place).abs() <= OFF_THE_GRID && place >= 0.0 && place < self.count as f64).then_some(place as usize)
    }
}
