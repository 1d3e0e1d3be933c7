//! A measured influence function: one spot's map becomes a removal rate.
//!
//! In: the map of the depth that one spot of known dwell left, and the job's words on scale, orientation and origin.
//! Out: an [`InfluenceFunction`] over the tool frame. What the spot was not is taken off: the least-squares plane of the
//! pixels beyond `radius` (interferometers leave piston and tilt in every map) is the baseline.

use super::InfluenceFunction;
use crate::diagnostics::{Problem, codes};
use crate::height_map::{Grid, Picture, lay, read_file};
use crate::job::{Measured, Origin, PixelAt, Positive, View};
use crate::metrology::{doubt_scale, plane_through, surface_factor};
use crate::source::FileProvider;

/// Largest part of the volume that may read as added glass. The noise of a spot's map averages out far below it; more
/// means a wrong baseline, a wrong radius, or two spots in one map.
const NEGATIVE_SHARE: f64 = 0.02;

/// A spot that is nowhere deeper than a picometre removed nothing: that is a hundredth of an atom, and below the rounding
/// of any map.
const SHALLOWEST: f64 = 1e-12;

/// `peak` and `centroid` depend on the baseline, which depends on the origin: they are looked for again until the origin
/// moves by less than a hundredth pixel, which shifts no removal that could be measured.
const SETTLED: f64 = 0.01;
/// A spot that stands out of its map settles within a few rounds; one that wanders longer has no origin of its own.
const MOST_ROUNDS: usize = 20;

/// Reads the spot. Fields are `tool.influence.…`.
///
/// # Errors
/// Those of reading and scaling a map; E0621 without a usable baseline or origin, E0622 for unknown pixels inside the
/// radius, E0623 for too much added glass, E0624 for no removal at all.
pub(super) fn read(
    measured: &Measured,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<InfluenceFunction, Problem> {
    let mut said = Vec::new();
    let result = read_within(measured, files, &mut said);
    warnings.extend(said.into_iter().map(|warning| warning.within("tool.influence")));
    result.map_err(|problem| problem.within("tool.influence"))
}

fn read_within(
    measured: &Measured,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<InfluenceFunction, Problem> {
    for (name, value, unit, scale) in [("dwell", measured.dwell.0, "s", 1.0), ("radius", measured.radius.0, "mm", 1e3)]
    {
        if !(value > 0.0 && value.is_finite()) {
            let message = format!("`{name}` is {:.3} {unit}; it must be positive", value * scale);
            return Err(Problem::error(codes::E0621, name, message));
        }
    }
    let raw = read_file(&measured.file, files)?;
    let pixel = raw.pixel_pitch(measured.pixel.map(|length| length.0))?;
    let mut values = raw.heights(measured.unit.map(|length| length.0))?;
    doubt_scale(&raw, measured.quantity, warnings);
    // Where glass is missing the surface stands low: depth is the negative of a height that is positive upwards.
    let factor = surface_factor(measured.quantity) * if measured.positive == Positive::high { -1.0 } else { 1.0 };
    values.iter_mut().for_each(|value| *value *= factor);
    let picture = Picture { columns: raw.columns, rows: raw.rows, pixel, values };
    // The tool's z points into the glass, away from the eye on the tool side.
    let mirrored = measured.view == View::from_tool_side;
    let start = match &measured.origin {
        Origin::pixel_at(PixelAt { column, row }) => [*column, *row],
        Origin::frame_centre(_) => picture.middle(),
        Origin::peak(_) | Origin::centroid(_) => deepest(&picture),
    };
    let mut depth = lay(&picture, measured.up, mirrored, start);
    let radius = measured.radius.0;
    // With the wrong sign the deepest pixel is any pixel but that of the spot.
    let looked_for = |problem: Problem| {
        let [column, row] = start;
        problem.note(format!(
            "the deepest pixel of the map was taken for the spot: column {column}, row {row} of the picture; if the spot is \
             not there, check `positive`"
        ))
    };
    let spot = match &measured.origin {
        Origin::frame_centre(_) | Origin::pixel_at(_) => levelled(&depth, radius)?,
        Origin::peak(_) => settle(&mut depth, radius, peak).map_err(looked_for)?,
        Origin::centroid(_) => settle(&mut depth, radius, centroid).map_err(looked_for)?,
    };
    finish(spot, radius, measured.dwell.0)
}

/// The deepest pixel `[column, row]` of the picture; heights were checked to have one.
fn deepest(picture: &Picture) -> [f64; 2] {
    let mut best = (f64::NEG_INFINITY, 0);
    for (i, value) in picture.values.iter().enumerate() {
        if *value > best.0 {
            best = (*value, i);
        }
    }
    [(best.1 % picture.columns) as f64, (best.1 / picture.columns) as f64]
}

/// Moves the grid's origin to the place that `locate` finds in the levelled spot, until it stays.
fn settle(depth: &mut Grid, radius: f64, locate: fn(&Grid, f64) -> [f64; 2]) -> Result<Grid, Problem> {
    for _ in 0..MOST_ROUNDS {
        let spot = levelled(depth, radius)?;
        let [x, y] = locate(&spot, radius);
        if x.abs() <= SETTLED * depth.pixel[0] && y.abs() <= SETTLED * depth.pixel[1] {
            return Ok(spot);
        }
        depth.origin = [depth.origin[0] - x, depth.origin[1] - y];
    }
    Err(Problem::error(codes::E0621, "origin", "the origin of the spot does not settle: no spot stands out of the map")
        .help("check `positive` and `radius`, or say where the tool stood by `pixel_at`"))
}

/// The deepest pixel inside the radius, metres from the origin.
fn peak(spot: &Grid, radius: f64) -> [f64; 2] {
    let mut best = (f64::NEG_INFINITY, [0.0; 2]);
    each_inside(spot, radius, |x, y, depth| {
        if depth > best.0 {
            best = (depth, [x, y]);
        }
    });
    best.1
}

/// The centre of the removed volume inside the radius, metres from the origin.
fn centroid(spot: &Grid, radius: f64) -> [f64; 2] {
    let (mut volume, mut sums) = (0.0, [0.0; 2]);
    each_inside(spot, radius, |x, y, depth| {
        volume += depth;
        sums[0] += x * depth;
        sums[1] += y * depth;
    });
    if volume > 0.0 { [sums[0] / volume, sums[1] / volume] } else { [0.0; 2] }
}

/// Calls `see(x, y, depth)` for every known pixel whose centre lies inside the radius.
fn each_inside(spot: &Grid, radius: f64, mut see: impl FnMut(f64, f64, f64)) {
    for row in 0..spot.rows {
        for column in 0..spot.columns {
            let [x, y] = spot.position(row, column);
            let depth = spot.at(row, column);
            if x * x + y * y <= radius * radius && !depth.is_nan() {
                see(x, y, depth);
            }
        }
    }
}

/// The map without its baseline; the spot must lie wholly in the picture, every pixel of it known (E0622), with enough
/// pixels around it (E0621).
fn levelled(depth: &Grid, radius: f64) -> Result<Grid, Problem> {
    let counts = [depth.columns, depth.rows];
    for axis in 0..2 {
        let low = depth.origin[axis];
        let high = low + (counts[axis] as f64 - 1.0) * depth.pixel[axis];
        if low > -radius || high < radius {
            let message = format!(
                "the spot of radius {:.3} mm leaves its map, which reaches from {} {:.3} mm to {:.3} mm of the tool frame",
                radius * 1e3,
                ["x", "y"][axis],
                low * 1e3,
                high * 1e3
            );
            return Err(Problem::error(codes::E0622, "radius", message)
                .help("make `radius` smaller, check `pixel` and `origin`, or measure a wider field"));
        }
    }
    let mut outside = vec![false; depth.values.len()];
    for row in 0..depth.rows {
        for column in 0..depth.columns {
            let i = row * depth.columns + column;
            let [x, y] = depth.position(row, column);
            outside[i] = x * x + y * y > radius * radius;
            if !outside[i] && depth.values[i].is_nan() {
                let message = format!(
                    "the spot has an unknown pixel at x {:.3} mm, y {:.3} mm of the tool frame",
                    x * 1e3,
                    y * 1e3
                );
                return Err(Problem::error(codes::E0622, "file", message)
                    .help("measure the spot again: inside `radius` every pixel must be known"));
            }
        }
    }
    let baseline = plane_through(depth, &outside).ok_or_else(|| {
        Problem::error(
            codes::E0621,
            "radius",
            "no plane can be laid through the pixels beyond `radius`: there are too few",
        )
        .help("make `radius` smaller, or measure a wider field around the spot")
    })?;
    let mut spot = depth.clone();
    for i in 0..spot.values.len() {
        spot.values[i] -= baseline.at(spot.position(i / spot.columns, i % spot.columns));
    }
    Ok(spot)
}

/// From depth to rate: checks the volume, divides by the dwell, finds the width.
fn finish(mut spot: Grid, radius: f64, dwell: f64) -> Result<InfluenceFunction, Problem> {
    let (mut removed, mut added, mut extreme) = (0.0, 0.0, 0.0_f64);
    each_inside(&spot, radius, |_, _, depth| {
        extreme = extreme.max(depth.abs());
        if depth > 0.0 { removed += depth } else { added -= depth }
    });
    let volume = removed - added;
    if extreme < SHALLOWEST {
        return Err(Problem::error(codes::E0624, "file", "the spot removed nothing")
            .help("take the map of the spot, not one of the part before"));
    }
    if volume <= 0.0 {
        return Err(Problem::error(codes::E0624, "positive", "the spot reads as added glass, not as removed glass")
            .help(
                "check `positive`: `high` if glass that stands high reads positive, `low` if removal reads positive",
            ));
    }
    if added > NEGATIVE_SHARE * volume {
        let message = format!(
            "{:.1} % of the spot's volume reads as added glass; at most {:.0} % can be noise",
            100.0 * added / volume,
            100.0 * NEGATIVE_SHARE
        );
        return Err(Problem::error(codes::E0623, "radius", message)
            .help("check that `radius` holds this one spot and that the map around it is flat"));
    }
    let pixel_area = spot.pixel[0] * spot.pixel[1];
    let sigma = smaller_width(&spot, radius);
    spot.values.iter_mut().for_each(|depth| *depth /= dwell);
    Ok(InfluenceFunction::of_map(spot, radius, volume * pixel_area / dwell, sigma))
}

/// Root of the smaller principal second moment about the centroid, of what was removed (noise below zero has no width),
/// with a pixel's own moment, side²/12, so that it is never zero.
fn smaller_width(spot: &Grid, radius: f64) -> f64 {
    let (mut sum, mut sx, mut sy, mut sxx, mut sxy, mut syy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    each_inside(spot, radius, |x, y, depth| {
        let depth = depth.max(0.0);
        sum += depth;
        sx += depth * x;
        sy += depth * y;
        sxx += depth * x * x;
        sxy += depth * x * y;
        syy += depth * y * y;
    });
    let (x, y) = (sx / sum, sy / sum);
    let xx = sxx / sum - x * x + spot.pixel[0] * spot.pixel[0] / 12.0;
    let yy = syy / sum - y * y + spot.pixel[1] * spot.pixel[1] / 12.0;
    let xy = sxy / sum - x * y;
    let (half_sum, half_difference) = ((xx + yy) / 2.0, (xx - yy) / 2.0);
    (half_sum - libm::hypot(half_difference, xy)).sqrt()
}
