//! What a region-adaptive path is refused for, each with the number that would pass.

use super::mesh::{Hexagon, Mesh};
use super::smooth::{self, Place};
use crate::diagnostics::{Problem, codes};
use crate::height_map::Grid;
use crate::job::RegionAdaptive;

/// Part of the spot's diameter that a hexagon's diagonal may be: columns then lie at most three sixteenths of the spot apart,
/// which leaves no ripple.
const SPOT_PART: f64 = 0.25;

/// Pixels across a hexagon: fewer, and the map does not say whether it belongs to the region.
const PIXELS_ACROSS: f64 = 2.0;

/// Widest smoothing, in nodes: a path over a hundred hexagons and more smoothed into one bow has nothing of the mesh left.
const MOST_SMOOTHING: f64 = 100.0;

/// Rounding of sizes, as a part of them: instruments write their pixels in single precision.
const ROUNDING: f64 = 1e-6;

/// Numbers that no plan can be made with.
pub(super) fn numbers(job: &RegionAdaptive, error: &Grid, spot_diameter: f64, most_points: u64) -> Result<(), Problem> {
    let diagonal = job.mesh.diagonal.0;
    let positive = [("mesh.diagonal", diagonal), ("point_step", job.point_step.0)];
    for (name, value) in positive {
        if !(value > 0.0 && value.is_finite()) {
            let message = format!("`{name}` is {} mm; it must be positive", value * 1e3);
            return Err(Problem::error(codes::E0640, format!("path.{name}"), message));
        }
    }
    for (name, value) in [("above", job.above.0), ("tolerance", job.tolerance.0)] {
        if !(value >= 0.0 && value.is_finite()) {
            let message = format!("`{name}` is {} nm; it must not be negative", value * 1e9);
            return Err(Problem::error(codes::E0640, format!("path.{name}"), message));
        }
    }
    if !(0.0..=MOST_SMOOTHING).contains(&job.smoothing) {
        let message = format!("`smoothing` is {} nodes; it must lie between 0 and {MOST_SMOOTHING}", job.smoothing);
        return Err(Problem::error(codes::E0640, "path.smoothing", message));
    }
    let widest = SPOT_PART * spot_diameter;
    if diagonal > widest * (1.0 + ROUNDING) {
        let message = format!(
            "hexagons of {:.3} mm diagonal are too large for a spot of {:.3} mm diameter: the columns would show",
            diagonal * 1e3,
            spot_diameter * 1e3
        );
        return Err(Problem::error(codes::E0680, "path.mesh.diagonal", message)
            .help(format!("write `diagonal: {} mm` or less, a quarter of the spot", down(widest * 1e3))));
    }
    let pixel = error.pixel[0].max(error.pixel[1]);
    let narrowest = PIXELS_ACROSS * pixel;
    if diagonal < narrowest * (1.0 - ROUNDING) {
        let message = format!(
            "hexagons of {:.3} mm diagonal are too small for a map of {:.3} mm a pixel, which cannot tell them apart",
            diagonal * 1e3,
            pixel * 1e3
        );
        return Err(Problem::error(codes::E0681, "path.mesh.diagonal", message)
            .help(format!("write `diagonal: {} mm` or more, two pixels", up(narrowest * 1e3))));
    }
    if job.point_step.0 > diagonal * (1.0 + ROUNDING) {
        let message =
            format!("points {:.3} mm apart skip hexagons of {:.3} mm diagonal", job.point_step.0 * 1e3, diagonal * 1e3);
        return Err(Problem::error(codes::E0682, "path.point_step", message)
            .help(format!("write `point_step: {} mm` or less, the diagonal", down(diagonal * 1e3))));
    }
    let bounds = job.over.bounds();
    let mesh = Mesh { diagonal, centre: job.over.centre() };
    let count = mesh.count(bounds.min, bounds.max);
    // A sheet has up to twice the hexagons of the box that it covers.
    if count > 2.0 * most_points as f64 {
        let message = format!("about {count:.0} hexagons lie over the area; the limit is {}", 2 * most_points);
        return Err(Problem::error(codes::E0641, "path.mesh.diagonal", message).help("make `diagonal` larger"));
    }
    Ok(())
}

/// A hundredth of a millimetre down, or up: numbers that pass and can be written.
fn down(millimetres: f64) -> f64 {
    (millimetres * 100.0 * (1.0 + ROUNDING)).floor() / 100.0
}
fn up(millimetres: f64) -> f64 {
    (millimetres * 100.0 * (1.0 - ROUNDING)).ceil() / 100.0
}

/// A corner of the mesh turns by 60 degrees, and by less once it is smoothed. A limit below that would cut every path to pieces.
pub(super) fn turn_limit(job: &RegionAdaptive, mesh: &Mesh, weights: &[f64]) -> Result<(), Problem> {
    let corner = Hexagon::default();
    let way = |direction: i32, steps: usize| {
        std::iter::successors(Some(corner), move |h| Some(h.neighbour(direction))).take(steps + 1)
    };
    let mut hexagons: Vec<Hexagon> = way(3, weights.len()).collect();
    hexagons.reverse();
    hexagons.extend(way(1, weights.len()).skip(1));
    let nodes: Vec<Place> = hexagons.into_iter().map(|hexagon| mesh.place(hexagon)).collect();
    let own = smooth::turns(&smooth::smooth(&nodes, weights, smooth::Ends::Reflected)).into_iter().fold(0.0, f64::max);
    if job.turn_limit.0 >= own {
        return Ok(());
    }
    let degrees = |angle: f64| angle * 180.0 / std::f64::consts::PI;
    let message = format!(
        "a corner of the mesh turns by {:.1} deg once it is smoothed, more than `turn_limit`, {:.1} deg",
        degrees(own),
        degrees(job.turn_limit.0)
    );
    Err(Problem::error(codes::E0685, "path.turn_limit", message).help(format!(
        "write `turn_limit: {:.0} deg` or more; 90 deg cuts only where a path comes back on itself",
        degrees(own).ceil()
    )))
}

/// No point may lie outside `over` by more than half a hexagon, which the centre of one on its border reaches.
pub(super) fn stays_within<'a>(
    job: &RegionAdaptive,
    mesh: &Mesh,
    points: impl Iterator<Item = &'a Place>,
) -> Result<(), Problem> {
    let outside = points.map(|point| (-job.over.distance(point[0], point[1]), *point));
    let Some((most, [x, y])) = outside.max_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
    if most <= mesh.step() / 2.0 {
        return Ok(());
    }
    let message = format!(
        "smoothing takes the path {:.3} mm out of `over` at x {:.3} mm, y {:.3} mm",
        most * 1e3,
        x * 1e3 + 0.0,
        y * 1e3 + 0.0
    );
    Err(Problem::error(codes::E0686, "path.smoothing", message)
        .help(format!("smooth over fewer nodes, or let `over` end {} mm farther in", up(most * 1e3))))
}

/// No two points of a run lie farther apart than a hexagon and a half: between them the tool would cross what is not to be
/// polished.
pub fn jumps(runs: &[Vec<Place>], diagonal: f64) -> Result<(), Problem> {
    for pair in runs.iter().flat_map(|run| run.windows(2)) {
        let length = smooth::length(pair);
        if !(length <= 1.5 * diagonal) {
            let [x, y] = pair[0];
            let message =
                format!("a run of the path jumps {:.3} mm from x {:.3} mm, y {:.3} mm", length * 1e3, x * 1e3, y * 1e3);
            return Err(Problem::error(codes::E0687, "path", message)
                .help(format!("lift the tool where the path goes on more than {:.3} mm away", 1.5 * diagonal * 1e3)));
        }
    }
    Ok(())
}

/// Smoothing that reaches farther to each side than every path is long bends them all as a whole.
pub(super) fn window(paths: &[Vec<Hexagon>], window: usize) -> Result<(), Problem> {
    let longest = paths.iter().map(Vec::len).max().unwrap_or(0);
    let half = window / 2;
    if longest == 0 || half <= longest {
        return Ok(());
    }
    let message = format!(
        "the smoothing reaches {half} hexagons to each side, farther than the longest path, which has {longest}"
    );
    // A half window is the whole number below three sigmas.
    let sigma = ((longest as f64 + 1.0) / 3.0 * 100.0).floor() / 100.0;
    Err(Problem::error(codes::E0684, "path.smoothing", message)
        .help(format!("write `smoothing: {sigma:.2}` or less, or drop such paths by `mesh.islands: {longest}`")))
}
