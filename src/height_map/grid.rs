//! The grid: values on regular pixels of the part (or tool) frame, and how to read between them.

/// Values on a regular grid of the part (or tool) frame. Row-major; rows run towards +y, columns towards +x; pixel
/// `(row, column)` has its centre at `origin + (column * pixel[0], row * pixel[1])`. NaN marks the unknown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    pub columns: usize,
    pub rows: usize,
    /// Pixel pitch in x and y, metres.
    pub pixel: [f64; 2],
    /// Centre of pixel (0, 0), metres.
    pub origin: [f64; 2],
    pub values: Vec<f64>,
}

impl Grid {
    /// Centre of the pixel, metres.
    pub fn position(&self, row: usize, column: usize) -> [f64; 2] {
        [self.origin[0] + column as f64 * self.pixel[0], self.origin[1] + row as f64 * self.pixel[1]]
    }

    /// The value at `(row, column)`.
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.values[row * self.columns + column]
    }

    /// The bilinear value at `(x, y)` metres. `None` farther than half a pixel outside the outermost centres. Between
    /// half a pixel outside and the outermost centres the value is that of the border. Where some of the four corners
    /// are unknown, the known ones share their weights, if these are at least half of the whole; otherwise `None`: a
    /// value that rests mostly on nothing is not one.
    pub fn interpolate(&self, x: f64, y: f64) -> Option<f64> {
        let (column, u) = cell((x - self.origin[0]) / self.pixel[0], self.columns)?;
        let (row, v) = cell((y - self.origin[1]) / self.pixel[1], self.rows)?;
        let (next_column, next_row) = ((column + 1).min(self.columns - 1), (row + 1).min(self.rows - 1));
        let corners = [
            ((1.0 - u) * (1.0 - v), self.at(row, column)),
            (u * (1.0 - v), self.at(row, next_column)),
            ((1.0 - u) * v, self.at(next_row, column)),
            (u * v, self.at(next_row, next_column)),
        ];
        let (mut sum, mut known) = (0.0, 0.0);
        for (weight, value) in corners {
            if !value.is_nan() {
                sum += weight * value;
                known += weight;
            }
        }
        (known >= 0.5).then(|| if known < 1.0 { sum / known } else { sum })
    }

    /// The grid with `factor` by `factor` pixels averaged into one, from pixel (0, 0) on. Unknown pixels are left out
    /// of the mean; a pixel of which fewer than half are known is unknown. What remains at the far sides when the size
    /// is not a multiple of `factor` becomes a last row and column of its own mean, so nothing is dropped.
    pub fn binned(&self, factor: usize) -> Grid {
        let factor = factor.max(1);
        let (columns, rows) = (self.columns.div_ceil(factor), self.rows.div_ceil(factor));
        let shift = (factor as f64 - 1.0) / 2.0;
        let mut values = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let (mut sum, mut known, mut all) = (0.0, 0_usize, 0_usize);
                for r in row * factor..((row + 1) * factor).min(self.rows) {
                    for c in column * factor..((column + 1) * factor).min(self.columns) {
                        all += 1;
                        let value = self.at(r, c);
                        if !value.is_nan() {
                            sum += value;
                            known += 1;
                        }
                    }
                }
                values.push(if 2 * known >= all { sum / known as f64 } else { f64::NAN });
            }
        }
        Grid {
            columns,
            rows,
            pixel: [self.pixel[0] * factor as f64, self.pixel[1] * factor as f64],
            origin: [self.origin[0] + shift * self.pixel[0], self.origin[1] + shift * self.pixel[1]],
            values,
        }
    }
}

/// Index of the pixel below `at` (in pixels) and the part of the way to the next; `None` outside the pixels' area.
fn cell(at: f64, count: usize) -> Option<(usize, f64)> {
    let last = count.checked_sub(1)? as f64;
    if !(at >= -0.5 && at <= last + 0.5) {
        return None;
    }
    let at = at.clamp(0.0, last);
    let index = at.floor();
    Some((index as usize, at - index))
}
