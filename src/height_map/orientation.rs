//! Orientation: from a picture to a frame.
//!
//! In: a picture (row 0 on top) and the job's words: which axis points up in it, from which side it is seen, where the
//! origin lies. Out: a [`Grid`] of the part or tool frame.
//!
//! Let `up` be the unit vector, in the frame, that points up in the picture, and `z` the frame's third axis. Seen with
//! +z towards the eye, what lies to the right is `up x z`: with +y up, +x is on the right. Seen with +z away from the
//! eye, left and right change places and up stays: with +y up, +x is on the **left**. The part's +z points at the
//! tool, so the part is mirrored when it is seen `from_back` (through the glass, from behind). The tool's +z points
//! into the glass, so the tool frame is mirrored when it is seen `from_tool_side`.

use super::Grid;
use crate::job::{Direction, MapCentre, PixelAt};

/// Heights of a picture, row-major from its upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub columns: usize,
    pub rows: usize,
    /// Pitch along rows and along columns, metres.
    pub pixel: [f64; 2],
    pub values: Vec<f64>,
}

impl Picture {
    /// The place `[column, row]`, in pixels, that `centre` names. `valid_centre` of a picture without valid pixels is
    /// the middle of the picture.
    pub fn centre(&self, centre: &MapCentre) -> [f64; 2] {
        match centre {
            MapCentre::frame_centre(_) => self.middle(),
            MapCentre::valid_centre(_) => self.valid_middle().unwrap_or(self.middle()),
            MapCentre::pixel_at(PixelAt { column, row }) => [*column, *row],
        }
    }

    /// The middle of the picture `[column, row]`, in pixels.
    pub fn middle(&self) -> [f64; 2] {
        [(self.columns as f64 - 1.0) / 2.0, (self.rows as f64 - 1.0) / 2.0]
    }

    /// The middle `[column, row]`, in pixels, of the box around the valid pixels; `None` if there are none.
    pub fn valid_middle(&self) -> Option<[f64; 2]> {
        valid_middle(self.columns, &self.values)
    }
}

/// The middle `[column, row]`, in pixels, of the box around the values that are not NaN; `None` if there are none.
pub(crate) fn valid_middle(columns: usize, values: &[f64]) -> Option<[f64; 2]> {
    let (mut low, mut high) = ([usize::MAX; 2], [0_usize; 2]);
    for (row, line) in values.chunks_exact(columns).enumerate() {
        let Some(first) = line.iter().position(|v| !v.is_nan()) else { continue };
        let last = line.iter().rposition(|v| !v.is_nan()).unwrap_or(first);
        low = [low[0].min(first), low[1].min(row)];
        high = [high[0].max(last), high[1].max(row)];
    }
    (low[0] <= high[0]).then(|| [(low[0] + high[0]) as f64 / 2.0, (low[1] + high[1]) as f64 / 2.0])
}

/// Unit vector of a direction.
fn vector(direction: Direction) -> [f64; 2] {
    match direction {
        Direction::plus_x => [1.0, 0.0],
        Direction::minus_x => [-1.0, 0.0],
        Direction::plus_y => [0.0, 1.0],
        Direction::minus_y => [0.0, -1.0],
    }
}

/// The picture's axes in the frame: the unit vectors that point to the right in it and upwards.
fn axes(up: Direction, mirrored: bool) -> [[f64; 2]; 2] {
    let up = vector(up);
    let turn = if mirrored { -1.0 } else { 1.0 };
    [[turn * up[1], -turn * up[0]], up]
}

/// Where [`lay`] puts the place `[column, row]` (pixels, as `centre`) of a picture with pixels of that size: metres.
pub fn position_in_frame(
    pixel: [f64; 2],
    up: Direction,
    mirrored: bool,
    centre: [f64; 2],
    [column, row]: [f64; 2],
) -> [f64; 2] {
    let [right, up] = axes(up, mirrored);
    let along = (column - centre[0]) * pixel[0];
    let above = (centre[1] - row) * pixel[1];
    [along * right[0] + above * up[0], along * right[1] + above * up[1]]
}

/// Puts the picture into the frame. `up` is the axis that points up in it, `mirrored` whether the frame's +z points
/// away from the eye, `centre` the place `[column, row]` (pixels) where the frame's origin lies. Every pixel keeps its
/// value; pixels that are not square keep their shape.
pub fn lay(picture: &Picture, up: Direction, mirrored: bool, centre: [f64; 2]) -> Grid {
    let axis = up;
    let [right, up] = axes(axis, mirrored);
    let (columns, rows) = (picture.columns, picture.rows);
    // Which pixel of the picture lies at the frame's smallest x and y, and how the index grows along x and along y.
    let first_column = if right[0] + right[1] > 0.0 { 0 } else { columns - 1 };
    let first_row = if up[0] + up[1] > 0.0 { rows - 1 } else { 0 };
    let column_step = if first_column == 0 { 1_isize } else { -1 };
    let row_step = if first_row == 0 { columns as isize } else { -(columns as isize) };
    let upright = up[1] != 0.0;
    let (grid_columns, grid_rows, pixel, step_x, step_y) = if upright {
        (columns, rows, picture.pixel, column_step, row_step)
    } else {
        (rows, columns, [picture.pixel[1], picture.pixel[0]], row_step, column_step)
    };
    let start = (first_row * columns + first_column) as isize;
    let origin = position_in_frame(picture.pixel, axis, mirrored, centre, [first_column as f64, first_row as f64]);
    let mut values = Vec::with_capacity(picture.values.len());
    for r in 0..grid_rows as isize {
        let line = start + r * step_y;
        values.extend((0..grid_columns as isize).map(|c| picture.values[(line + c * step_x) as usize]));
    }
    Grid { columns: grid_columns, rows: grid_rows, pixel, origin, values }
}
