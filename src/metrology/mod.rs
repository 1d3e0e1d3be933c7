//! Metrology: height maps as instruments write them, and as the part needs them.
//!
//! In: the bytes of a file and the job's words on orientation and scale. Out: a [`Grid`] in the part frame, metres,
//! positive where glass stands too high, NaN where nothing is known.

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
}
