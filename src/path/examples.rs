//! Settings that the tests of this module plan in.

use super::{Setting, ToolPath, plan};
use crate::diagnostics::Problem;
use crate::job::*;
use crate::units::si::Length;

/// A circle about the origin, millimetres.
pub fn circle(diameter_mm: f64) -> Aperture {
    Aperture::circle(Circle { diameter: Length(diameter_mm * 1e-3), centre: None })
}

/// On a plane, with nothing measured.
pub fn setting(edge: &Aperture, most_points: u64) -> Setting<'_> {
    Setting { edge, clear: edge, surface: &Plane {}, most_points, line_points: usize::MAX, measured: None }
}

/// A path over a plane part of 40 mm without a hole.
pub fn plan_on_plane(path: Path, most_points: u64) -> Result<ToolPath, Problem> {
    plan(&path, &setting(&circle(40.0), most_points))
}

/// The segments of a path, line by line.
fn segments(path: &ToolPath) -> Vec<[[f64; 2]; 2]> {
    let place = |i: usize| [path.points.x[i], path.points.y[i]];
    path.lines.iter().flat_map(|line| line.points.clone().skip(1)).map(|i| [place(i - 1), place(i)]).collect()
}

/// Whether any two segments that do not follow one another cross or touch.
pub fn crosses(path: &ToolPath) -> bool {
    let segments = segments(path);
    let side = |[a, b]: [[f64; 2]; 2], p: [f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let apart = |s: [[f64; 2]; 2], t: [[f64; 2]; 2]| {
        (0..2).any(|k| {
            let (low, high) = (s[0][k].min(s[1][k]), s[0][k].max(s[1][k]));
            t[0][k].min(t[1][k]) > high || t[0][k].max(t[1][k]) < low
        })
    };
    (0..segments.len()).any(|i| {
        (i + 2..segments.len()).any(|j| {
            let (s, t) = (segments[i], segments[j]);
            !apart(s, t) && side(s, t[0]) * side(s, t[1]) <= 0.0 && side(t, s[0]) * side(t, s[1]) <= 0.0
        })
    })
}

/// Places 0.3 mm apart in a box of 40 mm that are `inside`.
fn places(inside: impl Fn(f64, f64) -> bool) -> Vec<[f64; 2]> {
    let at = |k: i32| f64::from(k) * 0.3e-3;
    (-66..=66).flat_map(|i| (-66..=66).map(move |j| [at(i), at(j)])).filter(|[x, y]| inside(*x, *y)).collect()
}

/// Greatest distance of a place that is `inside` from the path.
pub fn farthest(path: &ToolPath, inside: impl Fn(f64, f64) -> bool) -> f64 {
    let segments = segments(path);
    let distance = |[a, b]: [[f64; 2]; 2], p: [f64; 2]| {
        let (d, q) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let t = ((d[0] * q[0] + d[1] * q[1]) / (d[0] * d[0] + d[1] * d[1])).clamp(0.0, 1.0);
        libm::hypot(q[0] - t * d[0], q[1] - t * d[1])
    };
    let near = |p: [f64; 2]| segments.iter().map(|s| distance(*s, p)).fold(f64::INFINITY, f64::min);
    places(inside).into_iter().map(near).fold(0.0, f64::max)
}

/// Sharpest turn between two segments of a line, radians.
pub fn sharpest_turn(path: &ToolPath) -> f64 {
    let way = |i: usize| [path.points.x[i] - path.points.x[i - 1], path.points.y[i] - path.points.y[i - 1]];
    let turn = |i: usize| {
        let (a, b) = (way(i - 1), way(i));
        libm::atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]).abs()
    };
    path.lines.iter().flat_map(|line| line.points.clone().skip(2)).map(turn).fold(0.0, f64::max)
}

/// What a Gaussian of width `sigma` that goes along the path at constant feed removes: largest less smallest depth over the
/// mean, at the places that are `inside`. The sum is taken along pieces of at most a tenth of a sigma, by definition.
pub fn unevenness(path: &ToolPath, sigma: f64, inside: impl Fn(f64, f64) -> bool) -> f64 {
    let mut stamps = Vec::new();
    for [a, b] in segments(path) {
        let length = libm::hypot(b[0] - a[0], b[1] - a[1]);
        let parts = (10.0 * length / sigma).ceil().max(1.0);
        for k in 0..parts as usize {
            let t = (k as f64 + 0.5) / parts;
            stamps.push(([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])], length / parts));
        }
    }
    let depth = |[x, y]: [f64; 2]| {
        let rate = |([u, v], length): &([f64; 2], f64)| {
            let square = (x - u) * (x - u) + (y - v) * (y - v);
            length * libm::exp(-square / (2.0 * sigma * sigma))
        };
        stamps.iter().map(rate).sum::<f64>()
    };
    let depths: Vec<f64> = places(inside).into_iter().map(depth).collect();
    let (low, high) = depths.iter().fold((f64::INFINITY, 0.0f64), |(low, high), d| (low.min(*d), high.max(*d)));
    (high - low) / (depths.iter().sum::<f64>() / depths.len() as f64)
}
