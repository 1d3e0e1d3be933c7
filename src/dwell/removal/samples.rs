//! Where on the part times are spent, and where depths are asked.
//!
//! In: a path; a grid. Out: [`Samples`], places with the unknown that each belongs to; a [`Window`], pixels without values.

use crate::height_map::Grid;
use crate::path::ToolPath;

/// The pixels that depths are asked on; the geometry of a [`Grid`] without its values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    pub columns: usize,
    pub rows: usize,
    /// Metres.
    pub pixel: [f64; 2],
    /// Centre of pixel (0, 0), metres.
    pub origin: [f64; 2],
}

impl Window {
    /// Of a grid.
    pub fn of(grid: &Grid) -> Window {
        Window { columns: grid.columns, rows: grid.rows, pixel: grid.pixel, origin: grid.origin }
    }

    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Whether it has no pixel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Centre of pixel `i`, row-major, metres.
    pub fn position(&self, i: usize) -> [f64; 2] {
        let (row, column) = (i / self.columns, i % self.columns);
        [self.origin[0] + column as f64 * self.pixel[0], self.origin[1] + row as f64 * self.pixel[1]]
    }
}

/// Places where the time of the unknowns is spent, in equal shares of each unknown's samples.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// Samples of unknown `i` are `start[i] .. start[i + 1]`.
    pub start: Vec<usize>,
}

impl Samples {
    /// One sample an unknown.
    pub fn points(x: &[f64], y: &[f64]) -> Samples {
        Samples { x: x.to_vec(), y: y.to_vec(), start: (0..=x.len()).collect() }
    }

    /// The unknowns are the segments of the path, one for each point that is not the first of its line; each segment's
    /// time is spread evenly along it, at the middles of equal parts no longer than `spacing`. For a spot of width sigma
    /// and parts of sigma/2, the error of this midpoint rule is beyond double precision.
    pub fn segments(path: &ToolPath, spacing: f64) -> Samples {
        let mut samples = Samples { start: vec![0], ..Samples::default() };
        for segment in segments(path) {
            let ([ax, ay], [bx, by]) = ends(path, segment);
            let dz = path.points.z[segment] - path.points.z[segment - 1];
            let parts = parts(libm::hypot(libm::hypot(bx - ax, by - ay), dz), spacing);
            for k in 0..parts {
                let t = (k as f64 + 0.5) / parts as f64;
                samples.x.push(ax + t * (bx - ax));
                samples.y.push(ay + t * (by - ay));
            }
            samples.start.push(samples.x.len());
        }
        samples
    }
}

/// Number of equal parts of a segment that are no longer than `spacing`.
pub fn parts(length: f64, spacing: f64) -> usize {
    // A segment is never cut into more than a thousand parts: that would be a spot a thousand times finer than the
    // distance of the points, which the coverage check refuses anyway.
    ((length / spacing).ceil() as usize).clamp(1, 1000)
}

/// The points that end a segment, in order: all but the first of each line.
pub fn segments(path: &ToolPath) -> impl Iterator<Item = usize> + '_ {
    path.lines.iter().flat_map(|line| line.points.clone().skip(1))
}

/// Start and end of the segment that ends at `point`, in the part's xy plane.
pub fn ends(path: &ToolPath, point: usize) -> ([f64; 2], [f64; 2]) {
    let points = &path.points;
    ([points.x[point - 1], points.y[point - 1]], [points.x[point], points.y[point]])
}
