//! The error where it counts.
//!
//! In: the error map and the clear aperture. Out: a [`Field`]: the map's pixels around the clear aperture with a weight,
//! zero where the job wants nothing. Pixels outside the clear aperture are left out of the problem: a target invented
//! there would pull at the rim of what matters.

use super::removal::Window;
use crate::diagnostics::{Problem, codes};
use crate::height_map::Grid;
use crate::job::Aperture;

/// The error map where it counts: its pixels around the clear aperture.
pub struct Field {
    pub window: Window,
    /// Metres; zero where the weight is.
    pub values: Vec<f64>,
    /// Part of the pixel's area that counts: 0 or 1 on the map's own pixels.
    pub weights: Vec<f64>,
    /// Column and row of the window's first pixel in the map, and the map's columns.
    corner: [usize; 2],
    map_columns: usize,
}

impl Field {
    /// # Errors
    ///
    /// E0509 if the map is smaller than the clear aperture or has a hole there.
    pub fn new(error: &Grid, clear: &Aperture) -> Result<Field, Problem> {
        let bounds = clear.bounds();
        let size = [error.columns, error.rows];
        let refuse = |message: String| {
            Problem::error(codes::E0509, "workpiece.error", message).help(
                "measure a larger area, make `clear` smaller, or check `pixel`, `centre` and `fill_below` of the map",
            )
        };
        let (mut corner, mut count) = ([0; 2], [0; 2]);
        for axis in 0..2 {
            // Pixels whose centre can lie inside the clear aperture. A millionth of a pixel is rounding: one that lies on the
            // boundary belongs to it on every side.
            let first = ((bounds.min[axis] - error.origin[axis]) / error.pixel[axis] - 1e-6).ceil();
            let last = ((bounds.max[axis] - error.origin[axis]) / error.pixel[axis] + 1e-6).floor();
            if !(first >= 0.0 && last < size[axis] as f64) {
                return Err(refuse("the map is smaller than the clear aperture".to_string()));
            }
            if last < first {
                return Err(refuse("not one pixel of the map lies inside the clear aperture".to_string()));
            }
            corner[axis] = first as usize;
            count[axis] = (last - first) as usize + 1;
        }
        let window = Window {
            columns: count[0],
            rows: count[1],
            pixel: error.pixel,
            origin: error.position(corner[1], corner[0]),
        };
        let mut field = Field { window, values: Vec::new(), weights: Vec::new(), corner, map_columns: error.columns };
        for i in 0..window.len() {
            let [x, y] = window.position(i);
            let height = error.values[field.place_in_map(i)];
            let inside = clear.contains(x, y);
            if inside && !height.is_finite() {
                let message = format!(
                    "the map knows nothing at x {:.3} mm, y {:.3} mm inside the clear aperture",
                    x * 1e3,
                    y * 1e3
                );
                return Err(refuse(message));
            }
            field.values.push(if inside { height } else { 0.0 });
            field.weights.push(if inside { 1.0 } else { 0.0 });
        }
        if field.weights.iter().all(|weight| *weight == 0.0) {
            return Err(refuse("not one pixel of the map lies inside the clear aperture".to_string()));
        }
        Ok(field)
    }

    /// The same pixels and weights with other values.
    pub fn with_values(&self, values: Vec<f64>) -> Field {
        let weights = self.weights.clone();
        Field { window: self.window, values, weights, corner: self.corner, map_columns: self.map_columns }
    }

    /// Index in the map's values of pixel `i` of the window.
    pub fn place_in_map(&self, i: usize) -> usize {
        (self.corner[1] + i / self.window.columns) * self.map_columns + self.corner[0] + i % self.window.columns
    }

    /// The greatest height inside the clear aperture.
    pub fn greatest(&self) -> f64 {
        let inside = self.values.iter().zip(&self.weights).filter(|(_, weight)| **weight > 0.0);
        inside.fold(f64::NEG_INFINITY, |most, (value, _)| most.max(*value))
    }

    /// Root mean square about the mean, weighted.
    pub fn rms(&self) -> f64 {
        let weight: f64 = self.weights.iter().sum();
        let mean = |value: &dyn Fn(f64) -> f64| {
            self.values.iter().zip(&self.weights).map(|(v, w)| w * value(*v)).sum::<f64>() / weight
        };
        let centre = mean(&|v| v);
        mean(&|v| (v - centre) * (v - centre)).sqrt()
    }

    /// Means over whole pixels that stay at most `side` wide, weighted by the area that counts. The field itself where
    /// its pixels are that wide already.
    pub fn binned(&self, side: f64) -> Field {
        let factor = self.window.pixel.map(|pixel| ((side / pixel).floor() as usize).max(1));
        let [fx, fy] = factor;
        let fine = &self.window;
        let window = Window {
            columns: fine.columns.div_ceil(fx),
            rows: fine.rows.div_ceil(fy),
            pixel: [fine.pixel[0] * fx as f64, fine.pixel[1] * fy as f64],
            origin: [0, 1].map(|a| fine.origin[a] + (factor[a] - 1) as f64 / 2.0 * fine.pixel[a]),
        };
        let mut binned = Field {
            window,
            values: vec![0.0; window.len()],
            weights: vec![0.0; window.len()],
            corner: self.corner,
            map_columns: self.map_columns,
        };
        for i in 0..fine.len() {
            let to = i / fine.columns / fy * window.columns + i % fine.columns / fx;
            binned.values[to] += self.weights[i] * self.values[i];
            binned.weights[to] += self.weights[i];
        }
        for (value, weight) in binned.values.iter_mut().zip(&mut binned.weights) {
            if *weight > 0.0 {
                *value /= *weight;
            }
            *weight /= (fx * fy) as f64;
        }
        binned
    }
}
