//! Removal on a curved surface.
//!
//! In: a [`TimedPath`], the footprint, the surface. Out: the depth along the normal at every pixel of a window, whose x and y
//! are those across the part's axis.
//!
//! The model: over a contact point the influence function lies in the tangent plane, turned as the tool is. A place of the
//! glass loses the rate at its foot in that plane, along its own normal. So a spot on a slope is foreshortened in x and y
//! along the slope and not across it, and its depth does not change. What that leaves out, the change of pressure and gap
//! with the curvature, and the normals that differ under one spot, is of the order of half the square of the angle by
//! which the surface turns from the middle of the spot to its rim: [`check`] warns from 1 % on and refuses where the angle
//! is half a radian.
//!
//! Between two points the contact lies on the straight move, the tool turned evenly.

use super::TimedPath;
use super::field::Field;
use super::footprint::Footprint;
use super::prediction::{Place, ROWS, each_stamp};
use super::removal::Window;
use super::speed::Limits;
use crate::diagnostics::{Problem, codes};
use crate::workpiece::form::Surface;
use rayon::prelude::*;

/// A spot on a curved surface may reach farther in x and y than on a plane, where the glass turns towards the part's
/// axis: with the largest angle below, 0.5, its rim lies 0.25 of the radius off the tangent plane, and no place with its foot
/// in the spot is farther away in x and y than 1.05 radii.
const WIDER: f64 = 1.05;

/// The angle from the middle of the spot to its rim from which the model is wrong by 1 %: half its square.
const DOUBTFUL_ANGLE: f64 = 0.141;

/// The angle at which nothing can be said: an eighth.
const LARGEST_ANGLE: f64 = 0.5;

/// Steps of the table of the influence function in a sigma: linear interpolation is then within 2e-4 of the peak, as in
/// the table of the plane.
const STEPS_IN_SIGMA: f64 = 32.0;

/// The glass at the pixels of a window.
pub struct Relief {
    pub window: Window,
    /// Sag at the middle of each pixel, metres; NaN where the form does not exist.
    heights: Vec<f64>,
}

impl Relief {
    /// Of the surface; `None` for a plane, which needs none.
    pub fn of(surface: &dyn Surface, window: &Window) -> Option<Relief> {
        if surface.is_plane() {
            return None;
        }
        let heights = (0..window.len())
            .into_par_iter()
            .map(|i| {
                let [x, y] = window.position(i);
                surface.at(x, y).map_or(f64::NAN, |point| point.sag)
            })
            .collect();
        Some(Relief { window: *window, heights })
    }

    /// Depth removed at every pixel, metres along the normal, row-major; 0 where the form does not exist.
    pub fn removal(&self, timed: &TimedPath, footprint: &Footprint, limits: &Limits) -> Vec<f64> {
        let window = &self.window;
        let tables: Vec<Table> = (0..footprint.parts()).map(|part| Table::new(footprint, part)).collect();
        let reach = WIDER * footprint.radius;
        let half = (reach / window.pixel[1]).ceil() as usize + 1;
        let (stamps, start) = by_rows(stamps(timed, footprint, reach, limits, window), window, half);
        // A stamp reaches `half` rows either way, so this many chunks of rows below its own.
        let below = (2 * half).div_ceil(ROWS) + 1;
        let mut depths = vec![0.0; window.len()];
        depths.par_chunks_mut(ROWS * window.columns.max(1)).enumerate().for_each(|(chunk, depths)| {
            let mut weights = vec![1.0; tables.len()];
            for stamp in &stamps[start[(chunk + 1).saturating_sub(below)]..start[chunk + 1]] {
                footprint.weights(stamp.contact[0], stamp.contact[1], &mut weights);
                for (table, weight) in tables.iter().zip(&weights) {
                    self.stamp(&Stamp { time: stamp.time * weight, ..*stamp }, table, reach, chunk * ROWS, depths);
                }
            }
        });
        depths
    }

    /// Adds one stamp to the rows of `depths`, of which the first is `first_row` of the window.
    fn stamp(&self, stamp: &Stamp, table: &Table, reach: f64, first_row: usize, depths: &mut [f64]) {
        let window = &self.window;
        let rows = depths.len() / window.columns;
        let range = |axis: usize, from: usize, to: usize| {
            let place = (stamp.contact[axis] - window.origin[axis]) / window.pixel[axis];
            let wide = reach / window.pixel[axis];
            let low = (place - wide).ceil().max(from as f64);
            let high = (place + wide).floor().min(to as f64 - 1.0);
            if high >= low { low as usize..high as usize + 1 } else { 0..0 }
        };
        let columns = range(0, 0, window.columns);
        let [a, b] = stamp.axes;
        for row in range(1, first_row, first_row + rows) {
            let dy = window.origin[1] + row as f64 * window.pixel[1] - stamp.contact[1];
            let heights = &self.heights[row * window.columns..][..window.columns];
            let out = &mut depths[(row - first_row) * window.columns..][..window.columns];
            for column in columns.clone() {
                let dx = window.origin[0] + column as f64 * window.pixel[0] - stamp.contact[0];
                let dz = heights[column] - stamp.contact[2];
                let u = a[0] * dx + a[1] * dy + a[2] * dz;
                let v = b[0] * dx + b[1] * dy + b[2] * dz;
                out[column] += stamp.time * table.rate(u, v);
            }
        }
    }
}

/// Time spent at a contact point, and the axes that its footprint lies along.
#[derive(Clone, Copy)]
struct Stamp {
    contact: [f64; 3],
    axes: [[f64; 3]; 2],
    time: f64,
}

fn stamps(timed: &TimedPath, footprint: &Footprint, reach: f64, limits: &Limits, window: &Window) -> Vec<Stamp> {
    let points = &timed.path.points;
    let mut stamps = Vec::new();
    each_stamp(timed, footprint, reach, limits, window, |Place { from, to, t, .. }, time| {
        let between = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] + t * (b[i] - a[i]));
        let contact = between(points.position(from), points.position(to));
        let normal = between(points.normal(from), points.normal(to));
        let length = (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]).sqrt();
        // Where the normal runs along the azimuth motion refuses the path; here it removes nothing.
        if let Some(axes) = footprint.carried_axes(normal.map(|n| n / length)) {
            stamps.push(Stamp { contact, axes, time });
        }
    });
    stamps
}

/// The stamps by the chunk of rows that holds their first row, travel order kept inside; those of chunk `c` are
/// `start[c] .. start[c + 1]`.
fn by_rows(mut stamps: Vec<Stamp>, window: &Window, half: usize) -> (Vec<Stamp>, Vec<usize>) {
    let chunks = window.rows.div_ceil(ROWS);
    let chunk = |stamp: &Stamp| {
        let first = ((stamp.contact[1] - window.origin[1]) / window.pixel[1]).floor() - half as f64;
        (first.max(0.0) as usize / ROWS).min(chunks.saturating_sub(1))
    };
    stamps.sort_by_key(chunk);
    let start = (0..=chunks).map(|c| stamps.partition_point(|stamp| chunk(stamp) < c)).collect();
    (stamps, start)
}

/// The footprint sampled on a square grid about the contact point, read between its points linearly in both axes.
struct Table {
    step: f64,
    half: usize,
    values: Vec<f64>,
}

impl Table {
    fn new(footprint: &Footprint, part: usize) -> Table {
        let step = footprint.sigma / STEPS_IN_SIGMA;
        let half = (footprint.radius / step).ceil() as usize + 1;
        let side = 2 * half + 1;
        let at = |k: usize| (k as f64 - half as f64) * step;
        let values =
            (0..side * side).into_par_iter().map(|i| footprint.rate_of(part, at(i % side), at(i / side))).collect();
        Table { step, half, values }
    }

    /// Zero outside, and for a place that is no number.
    fn rate(&self, x: f64, y: f64) -> f64 {
        let side = 2 * self.half + 1;
        let (u, v) = (x / self.step + self.half as f64, y / self.step + self.half as f64);
        let last = (side - 1) as f64;
        if !(u >= 0.0 && v >= 0.0 && u < last && v < last) {
            return 0.0;
        }
        let (column, row) = (u as usize, v as usize);
        let (fu, fv) = (u - column as f64, v - row as f64);
        let corner = row * side + column;
        let (low, high) = (&self.values[corner..corner + 2], &self.values[corner + side..corner + side + 2]);
        let along = |pair: &[f64]| pair[0] + fu * (pair[1] - pair[0]);
        along(low) + fv * (along(high) - along(low))
    }
}

/// Cosine of the surface's slope at every pixel; 1 where the form does not exist.
pub(crate) fn cosines(surface: &dyn Surface, window: &Window) -> Vec<f64> {
    let cosine = |i: usize| {
        let [x, y] = window.position(i);
        surface.at(x, y).map_or(1.0, |point| point.normal()[2])
    };
    (0..window.len()).into_par_iter().map(cosine).collect()
}

/// Least cosine of the slope where the field counts.
pub(super) fn steepest(surface: &dyn Surface, field: &Field) -> f64 {
    if surface.is_plane() {
        return 1.0;
    }
    let cosines = cosines(surface, &field.window);
    cosines.iter().zip(&field.weights).filter(|(_, w)| **w > 0.0).fold(1.0, |least, (cosine, _)| cosine.min(least))
}

/// Whether the model holds: W0706 where it is wrong by more than 1 %, E0709 where it says nothing.
pub(super) fn check(
    surface: &dyn Surface,
    field: &Field,
    footprint: &Footprint,
    warnings: &mut Vec<Problem>,
) -> Result<(), Problem> {
    if surface.is_plane() {
        return Ok(());
    }
    let window = &field.window;
    let mut sharpest = ([0.0; 2], 0.0);
    for i in (0..window.len()).filter(|i| field.weights[*i] > 0.0) {
        let [x, y] = window.position(i);
        let curvature = surface.at(x, y).map_or(0.0, |point| point.sharpest());
        if curvature > sharpest.1 {
            sharpest = ([x, y], curvature);
        }
    }
    let ([x, y], curvature) = sharpest;
    let angle = curvature * footprint.radius;
    if angle <= DOUBTFUL_ANGLE {
        return Ok(());
    }
    let message = format!(
        "from the middle of the spot to its rim, {:.3} mm away, the surface turns by {:.1} deg at x {:.3} mm, y {:.3} mm",
        footprint.radius * 1e3,
        angle.to_degrees(),
        x * 1e3,
        y * 1e3
    );
    let help =
        |angle: f64| format!("use a spot of at most {:.1} mm diameter", (angle / curvature * 2e4).floor() / 10.0);
    if angle > LARGEST_ANGLE {
        return Err(Problem::error(codes::E0709, "tool.influence", message)
            .note("the removal of a spot is known on a plane; on a surface that turns so much it says nothing")
            .help(help(LARGEST_ANGLE)));
    }
    warnings.push(
        Problem::warning(codes::W0706, "tool.influence", message)
            .note(format!("the predicted removal is right to about {:.0} % only", angle * angle * 50.0))
            .help(help(DOUBTFUL_ANGLE)),
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::footprint::examples::gaussian;
    use super::super::prediction;
    use super::*;
    use crate::job::{Form, Side, Sphere};
    use crate::path::{Line, Link, ToolPath};
    use crate::source::MemoryFiles;
    use crate::units::si::Length;
    use crate::workpiece::form;

    const SIGMA: f64 = 2e-3;
    const LIMITS: Limits = Limits { least: 1e-4, greatest: 0.1, acceleration: 0.5, lateral: 0.5 };

    fn window() -> Window {
        Window { columns: 81, rows: 84, pixel: [0.5e-3; 2], origin: [-20e-3, -21e-3] }
    }

    /// Three lines of 20 mm along x, points 1 mm apart, about (x, y) on the surface.
    fn timed(surface: &dyn Surface, x: f64, y: f64) -> TimedPath {
        let mut path = ToolPath::default();
        for line in 0..3 {
            let start = path.points.len();
            for i in 0..21 {
                let (x, y) = (x + f64::from(i) * 1e-3 - 10e-3, y + f64::from(line) * 1.5e-3 - 1.5e-3);
                let point = surface.at(x, y).expect("on it");
                path.points.push([x, y, point.sag], point.normal());
            }
            path.lines.push(Line { points: start..path.points.len(), link: Link::OnSurface });
        }
        let speed = (0..path.points.len()).map(|i| if i % 21 < 10 { 0.02 } else { 0.025 }).collect();
        TimedPath { path, speed, standing: Vec::new() }
    }

    /// A tilted plane, to look at foreshortening without curvature.
    #[derive(Debug)]
    struct Slope(f64);

    impl Surface for Slope {
        fn at(&self, x: f64, _: f64) -> Option<form::SurfacePoint> {
            Some(form::SurfacePoint { sag: self.0 * x, slope: [self.0, 0.0], second: [0.0; 3] })
        }
    }

    #[test]
    fn without_slope_it_is_the_removal_of_the_plane() {
        let footprint = gaussian(1e-8, SIGMA, 6e-3);
        let timed = timed(&Slope(0.0), 1e-3, -0.7e-3);
        let curved = Relief::of(&Slope(0.0), &window()).expect("not called a plane");
        let (found, flat) =
            (curved.removal(&timed, &footprint, &LIMITS), prediction::removal(&timed, &footprint, &LIMITS, &window()));
        let greatest = flat.iter().fold(0.0f64, |m, d| m.max(*d));
        let worst = flat.iter().zip(&found).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        // Both tables are within 2e-4; the rim of the cut, 1.1 % of the peak, is smeared over an eighth of a pixel by one
        // and a thirty-second of a sigma by the other.
        assert!(worst < 2e-3 * greatest, "{}", worst / greatest);
    }

    /// On a plane that rises by 3 in 4, whatever the tool does along x takes place on a length 5/4 as long: seen along z the
    /// same removal as on a flat, squeezed to 4/5 in x.
    #[test]
    fn a_slope_squeezes_the_spot_along_it_and_keeps_its_depth() {
        let footprint = gaussian(1e-8, SIGMA, 6e-3);
        let sloped = timed(&Slope(0.75), 0.0, 0.0);
        // The same path rolled out flat: x is 5/4 as long.
        let mut flat = sloped.clone();
        for i in 0..flat.path.points.len() {
            flat.path.points.x[i] *= 1.25;
            flat.path.points.z[i] = 0.0;
            (flat.path.points.normal_x[i], flat.path.points.normal_z[i]) = (0.0, 1.0);
        }
        let wide = Window { pixel: [0.625e-3, 0.5e-3], origin: [-25e-3, -21e-3], ..window() };
        let found = Relief::of(&Slope(0.75), &window()).expect("a slope").removal(&sloped, &footprint, &LIMITS);
        let expected = prediction::removal(&flat, &footprint, &LIMITS, &wide);
        let greatest = expected.iter().fold(0.0f64, |m, d| m.max(*d));
        let worst = expected.iter().zip(&found).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(worst < 2e-3 * greatest, "{}", worst / greatest);
    }

    /// The depth integrated over the glass is the volume rate times the time, less what the curvature makes of it.
    #[test]
    fn volume_on_a_sphere_is_rate_times_time() {
        let sphere = Form::sphere(Sphere { side: Side::concave, radius: Length(0.1) });
        let sphere = form::surface(&sphere, &MemoryFiles::default()).expect("a sphere");
        let footprint = gaussian(1e-8, SIGMA, 6e-3);
        // 60 mm from the axis of a sphere of 100 mm: slope 3 in 4.
        let window = Window { origin: [40e-3, -21e-3], ..window() };
        let timed = timed(&*sphere, 60e-3, 0.0);
        let relief = Relief::of(&*sphere, &window).expect("curved");
        let depths = relief.removal(&timed, &footprint, &LIMITS);
        let volume: f64 = (0..window.len())
            .map(|i| {
                let [x, y] = window.position(i);
                let [_, _, normal_z] = sphere.at(x, y).expect("on it").normal();
                depths[i] * 0.5e-3 * 0.5e-3 / normal_z
            })
            .sum();
        let segments = super::super::speed::Segments::new(&timed.path, 0.0);
        let speeds: Vec<f64> = segments.point.iter().map(|p| timed.speed[*p]).collect();
        let time: f64 = super::super::speed::times(&speeds, &segments, &LIMITS).iter().sum();
        // An area of the glass is larger than its foot in the tangent plane by one over the cosine of the angle between
        // them: for a Gaussian of 2 mm on 100 mm about (sigma/R)² = 4e-4.
        let expected = footprint.volume_rate * time;
        assert!((volume - expected).abs() < 3e-3 * expected, "{volume} {expected}");
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let sphere = Form::sphere(Sphere { side: Side::convex, radius: Length(0.1) });
        let sphere = form::surface(&sphere, &MemoryFiles::default()).expect("a sphere");
        let footprint = gaussian(1e-8, SIGMA, 6e-3);
        let timed = timed(&*sphere, 5e-3, 3e-3);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| Relief::of(&*sphere, &window()).expect("curved").removal(&timed, &footprint, &LIMITS))
        };
        let one = with(1);
        assert!(one == with(2) && one == with(8));
    }
}
