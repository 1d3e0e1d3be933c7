//! Coverage: how much of a region the path comes near to.
//!
//! In: the region's pixels and the path's points. Out: a [`Coverage`]. The points are sorted into square bins, so that each
//! pixel asks only those around it.

use super::smooth::Place;
use rayon::prelude::*;

/// How the path covers its region.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Part of the region's pixels within the given distance of a point of the path; 1 for an empty region.
    pub share: f64,
    /// Greatest distance of a pixel of the region from the nearest point.
    pub farthest: f64,
    /// Sum of the weights of the pixels that are farther away.
    pub left: f64,
}

/// Pixels that are worked on together: the sums are taken in this order whatever the number of threads.
const CHUNK: usize = 4096;

/// Measures how near `points` come to `pixels`, each with a weight. `near` is the distance that counts as covered.
pub fn measure(pixels: &[(Place, f64)], points: &[Place], near: f64) -> Coverage {
    if pixels.is_empty() {
        return Coverage { share: 1.0, ..Coverage::default() };
    }
    let bins = Bins::new(points, near);
    // Covered pixels, farthest, what is left.
    let of_chunk = |chunk: &[(Place, f64)]| {
        chunk.iter().fold((0_usize, 0.0_f64, 0.0), |(covered, farthest, left), (place, weight)| {
            let distance = bins.nearest(*place);
            // A millionth: a pixel just at the distance is near, however its distance was rounded.
            let is_near = distance <= near * (1.0 + 1e-6);
            (covered + usize::from(is_near), farthest.max(distance), if is_near { left } else { left + weight })
        })
    };
    let chunks: Vec<(usize, f64, f64)> = pixels.par_chunks(CHUNK).map(of_chunk).collect();
    let covered: usize = chunks.iter().map(|chunk| chunk.0).sum();
    Coverage {
        share: covered as f64 / pixels.len() as f64,
        farthest: chunks.iter().map(|chunk| chunk.1).fold(0.0, f64::max),
        left: chunks.iter().map(|chunk| chunk.2).sum(),
    }
}

/// Most bins a side: a square of them is then as large as a map.
const MOST_BINS: f64 = 2000.0;

/// Points in square bins.
struct Bins<'a> {
    points: &'a [Place],
    size: f64,
    low: Place,
    columns: isize,
    rows: isize,
    /// Indices of the points, bin after bin, and where each bin starts.
    order: Vec<u32>,
    starts: Vec<usize>,
}

impl<'a> Bins<'a> {
    fn new(points: &'a [Place], size: f64) -> Bins<'a> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let extent = (high[0] - low[0]).max(high[1] - low[1]).max(0.0);
        let size = size.max(extent / MOST_BINS);
        let count = |axis: usize| if points.is_empty() { 1 } else { ((high[axis] - low[axis]) / size) as isize + 1 };
        let mut bins =
            Bins { points, size, low, columns: count(0), rows: count(1), order: Vec::new(), starts: Vec::new() };
        let mut counts = vec![0_usize; (bins.columns * bins.rows) as usize + 1];
        points.iter().for_each(|point| counts[bins.bin(*point) + 1] += 1);
        for i in 1..counts.len() {
            counts[i] += counts[i - 1];
        }
        bins.starts = counts.clone();
        bins.order = vec![0; points.len()];
        for (i, point) in points.iter().enumerate() {
            let bin = bins.bin(*point);
            bins.order[counts[bin]] = i as u32;
            counts[bin] += 1;
        }
        bins
    }

    fn bin(&self, [x, y]: Place) -> usize {
        let column = (((x - self.low[0]) / self.size) as isize).clamp(0, self.columns - 1);
        let row = (((y - self.low[1]) / self.size) as isize).clamp(0, self.rows - 1);
        (row * self.columns + column) as usize
    }

    /// Distance of the nearest point; infinite if there is none.
    fn nearest(&self, [x, y]: Place) -> f64 {
        if self.points.is_empty() {
            return f64::INFINITY;
        }
        let column = ((x - self.low[0]) / self.size).floor() as isize;
        let row = ((y - self.low[1]) / self.size).floor() as isize;
        let mut least = f64::INFINITY;
        // As far as from here to the farthest bin.
        let most = column.abs().max((self.columns - column).abs()).max(row.abs()).max((self.rows - row).abs());
        for ring in 0..=most {
            for r in (row - ring).max(0)..=(row + ring).min(self.rows - 1) {
                // Of a row in the ring's middle only its two ends.
                let whole = (r - row).abs() == ring;
                let stride = if whole || ring == 0 { 1 } else { 2 * ring };
                let mut c = column - ring;
                while c <= column + ring {
                    if (0..self.columns).contains(&c) {
                        let bin = (r * self.columns + c) as usize;
                        for i in &self.order[self.starts[bin]..self.starts[bin + 1]] {
                            let [px, py] = self.points[*i as usize];
                            least = least.min((px - x) * (px - x) + (py - y) * (py - y));
                        }
                    }
                    c += stride;
                }
            }
            // Nothing in a farther ring is nearer than this.
            let reached = ring as f64 * self.size;
            if least <= reached * reached {
                break;
            }
        }
        least.sqrt()
    }
}
