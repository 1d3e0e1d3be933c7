//! Place: a picture becomes the form error of a part.
//!
//! In: a [`RawMap`], the job's `height_map`, the workpiece. Out: an [`ErrorMap`] in the part frame. Every word of the
//! job has one effect here, in this order:
//!
//! 1. `unit`, `pixel`: metres (see [`RawMap`]).
//! 2. `quantity: wavefront`: halved, since light passes an error of the surface twice. `positive: low`: negated.
//! 3. `up`, `view`, `centre`: laid into the part frame (see [`lay`]). `from_back` is the picture seen from behind the
//!    part, through the glass: what points up stays up, left and right change places.
//! 4. Off the part (`edge`) there is no glass: unknown.
//! 5. The picture must cover the clear aperture.
//! 6. `subtract`: taken off by least squares over the measured pixels of the clear aperture.
//! 7. `fill_below`: holes inside the clear aperture up to this area are filled, a larger one refuses the map.

use super::{Figures, LowOrder, holes, low_order};
use crate::diagnostics::{Problem, codes};
use crate::height_map::{Grid, Picture, RawMap, lay, valid_middle};
use crate::job::{Aperture, HeightMap, Positive, Quantity, View, Workpiece};

/// The form error of a part, ready for dwell.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    /// Part frame, metres, positive where glass stands too high. No NaN at a pixel inside the clear aperture; NaN off the
    /// part and where the instrument saw nothing.
    pub grid: Grid,
    /// Of the measured pixels inside the clear aperture, before `subtract`; metres.
    pub before: Figures,
    /// The same pixels after `subtract`: what is left to correct.
    pub after: Figures,
    /// What `subtract` took off.
    pub removed: LowOrder,
    /// Number of holes filled inside the clear aperture, their pixels, and their area in square metres.
    pub filled_holes: usize,
    pub filled_pixels: usize,
    pub filled_area: f64,
    /// Metres, where the file says it.
    pub wavelength: Option<f64>,
}

/// How far, in pixels, the middle of the valid pixels may lie from the middle of the part before a warning: centring by
/// hand on an edge is good to a pixel or two.
const CENTRING: f64 = 3.0;

/// Most pixels of a hole that is filled, whatever the job allows: half a thousand each way. A smooth surface over more is
/// no measurement, and solving for it would take minutes.
const MOST_FILLED: f64 = 250_000.0;

/// Puts the map on the part. Fields are `workpiece.error.…`; warnings go to `warnings`.
///
/// # Errors
/// E0506, E0507, E0508, E0511 from scale and unit; E0509 if the map does not cover the clear aperture; E0510 if a hole
/// is too large to be filled; E0512 if `subtract` is not fixed by the measured pixels.
pub fn place(
    raw: &RawMap,
    map: &HeightMap,
    workpiece: &Workpiece,
    warnings: &mut Vec<Problem>,
) -> Result<ErrorMap, Problem> {
    let mut said = Vec::new();
    let result = place_within(raw, map, workpiece, &mut said);
    warnings.extend(said.into_iter().map(|warning| warning.within("workpiece.error")));
    result.map_err(|problem| problem.within("workpiece.error"))
}

fn place_within(
    raw: &RawMap,
    map: &HeightMap,
    workpiece: &Workpiece,
    warnings: &mut Vec<Problem>,
) -> Result<ErrorMap, Problem> {
    let pixel = raw.pixel_pitch(map.pixel.map(|length| length.0))?;
    let mut values = raw.heights(map.unit.map(|length| length.0))?;
    doubt_scale(raw, map.quantity, warnings);
    let factor = surface_factor(map.quantity) * if map.positive == Positive::low { -1.0 } else { 1.0 };
    values.iter_mut().for_each(|value| *value *= factor);

    let picture = Picture { columns: raw.columns, rows: raw.rows, pixel, values };
    let centre = picture.centre(&map.centre);
    let mut grid = lay(&picture, map.up, map.view == View::from_back, centre);
    doubt_centre(&grid, &workpiece.edge, warnings);

    let needed = inside(&grid, &workpiece.clear);
    let glass = inside(&grid, &workpiece.edge);
    for (value, on_the_part) in grid.values.iter_mut().zip(glass) {
        if !on_the_part {
            *value = f64::NAN;
        }
    }
    frame_covers(&grid, &workpiece.clear)?;
    let found = holes::find(&grid, &needed);
    let limit = map.fill_below.map_or(0.0, |area| area.0).min(MOST_FILLED * pixel[0] * pixel[1]);
    refuse_large_holes(&grid, &found, limit, &workpiece.clear)?;

    let measured = |grid: &Grid| -> Figures {
        Figures::of(grid.values.iter().zip(&needed).filter(|(_, needed)| **needed).map(|(value, _)| *value))
    };
    let before = measured(&grid);
    if before.count == 0 {
        return Err(Problem::error(
            codes::E0509,
            "file",
            "no pixel of the map has its centre inside the clear aperture",
        )
        .help("check `pixel`, `centre` and the size of `clear`"));
    }
    let removed = low_order::subtract(&mut grid, &needed, &map.subtract).ok_or_else(|| {
        let message = format!(
            "{} measured inside the clear aperture cannot say what `subtract` names",
            plural(before.count, "pixel")
        );
        Problem::error(codes::E0512, "subtract", message).help("measure the part with more pixels, or check `pixel`")
    })?;
    let after = measured(&grid);

    let filled_pixels: usize = found.iter().map(|hole| hole.pixels.len()).sum();
    let filled_area = filled_pixels as f64 * pixel[0] * pixel[1];
    for hole in &found {
        if !holes::fill(&mut grid, hole) {
            return Err(too_large_hole(&grid, hole, limit));
        }
    }
    if !found.is_empty() {
        let message = format!(
            "{} of the map inside the clear aperture {} filled from {} rim: {filled_pixels} pixels, {} in all",
            plural(found.len(), "hole"),
            if found.len() == 1 { "was" } else { "were" },
            if found.len() == 1 { "its" } else { "their" },
            square_millimetres(filled_area)
        );
        warnings.push(Problem::warning(codes::W0500, "fill_below", message));
    }
    Ok(ErrorMap {
        grid,
        before,
        after,
        removed,
        filled_holes: found.len(),
        filled_pixels,
        filled_area,
        wavelength: raw.wavelength,
    })
}

/// What a value is multiplied with to be a height of the surface: a wavefront that was reflected has passed the error
/// twice.
pub(crate) fn surface_factor(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::surface => 1.0,
        Quantity::wavefront => 0.5,
    }
}

/// Which pixels have their centre inside the aperture.
fn inside(grid: &Grid, aperture: &Aperture) -> Vec<bool> {
    (0..grid.values.len())
        .map(|i| {
            let [x, y] = grid.position(i / grid.columns, i % grid.columns);
            aperture.contains(x, y)
        })
        .collect()
}

/// A factor of two is the commonest mistake with heights: warns where the file's scale factor speaks against the job's
/// `quantity`, and where the file says that its sign was inverted.
pub(crate) fn doubt_scale(raw: &RawMap, quantity: Quantity, warnings: &mut Vec<Problem>) {
    if let Some(said) = raw.quantity
        && said != quantity
    {
        let (file, job) = match said {
            Quantity::surface => ("surface heights", "wavefront"),
            Quantity::wavefront => ("a wavefront", "surface"),
        };
        let message = format!("the map's file says that its values are {file}, but the job says `quantity: {job}`");
        warnings.push(
            Problem::warning(codes::W0502, "quantity", message)
                .note("one of the two is wrong by a factor of two, unless the part was measured in an unusual set-up"),
        );
    }
    if raw.sign_inverted {
        let message =
            "the map's file says that its sign was inverted when it was taken; its values are used as they stand";
        warnings.push(
            Problem::warning(codes::W0503, "positive", message)
                .help("make sure on the instrument that `positive` speaks of the values as they are stored"),
        );
    }
}

/// Warns when what was measured does not lie around the middle of the part.
fn doubt_centre(grid: &Grid, edge: &Aperture, warnings: &mut Vec<Problem>) {
    let Some([column, row]) = valid_middle(grid.columns, &grid.values) else { return };
    let found = [grid.origin[0] + column * grid.pixel[0], grid.origin[1] + row * grid.pixel[1]];
    let expected = edge.centre();
    let off = [found[0] - expected[0], found[1] - expected[1]];
    if (off[0] / grid.pixel[0]).abs() <= CENTRING && (off[1] / grid.pixel[1]).abs() <= CENTRING {
        return;
    }
    let message = format!(
        "the middle of the valid pixels lies at x {:.3} mm, y {:.3} mm, {:.1} pixels from the middle of the part",
        found[0] * 1e3,
        found[1] * 1e3,
        libm::hypot(off[0] / grid.pixel[0], off[1] / grid.pixel[1])
    );
    warnings.push(
        Problem::warning(codes::W0501, "centre", message)
            .note("a map that lies wrong on the part moves all removal by as much")
            .help("check `centre`; say `valid_centre` if the map was masked to the part"),
    );
}

/// The pixels' area must hold the clear aperture. A pixel reaches half its side beyond its centre.
fn frame_covers(grid: &Grid, clear: &Aperture) -> Result<(), Problem> {
    let bounds = clear.bounds();
    let counts = [grid.columns, grid.rows];
    let [cx, cy] = clear.centre();
    let mut worst = (0.0, String::new());
    for axis in 0..2 {
        let low = grid.origin[axis] - 0.5 * grid.pixel[axis];
        let high = low + counts[axis] as f64 * grid.pixel[axis];
        let name = ["x", "y"][axis];
        for (sign, missing) in [("-", low - bounds.min[axis]), ("+", bounds.max[axis] - high)] {
            // Sizes written in millimetres and pixels in metres meet with rounding far below a thousandth pixel.
            if missing > 1e-3 * grid.pixel[axis] && missing > worst.0 {
                worst = (missing, format!("on the {sign}{name} side"));
            }
        }
    }
    if worst.0 == 0.0 {
        return Ok(());
    }
    let message = format!(
        "the map ends {:.3} mm inside the clear aperture {}: it has {:.3} mm x {:.3} mm about x {:.3} mm, y {:.3} mm, \
         the clear aperture {:.3} mm x {:.3} mm about x {:.3} mm, y {:.3} mm",
        worst.0 * 1e3,
        worst.1,
        counts[0] as f64 * grid.pixel[0] * 1e3,
        counts[1] as f64 * grid.pixel[1] * 1e3,
        (grid.origin[0] + 0.5 * (counts[0] as f64 - 1.0) * grid.pixel[0]) * 1e3,
        (grid.origin[1] + 0.5 * (counts[1] as f64 - 1.0) * grid.pixel[1]) * 1e3,
        (bounds.max[0] - bounds.min[0]) * 1e3,
        (bounds.max[1] - bounds.min[1]) * 1e3,
        cx * 1e3,
        cy * 1e3
    );
    Err(Problem::error(codes::E0509, "file", message).help(smaller_clear(worst.0)))
}

/// Refuses the largest hole that is larger than `limit` square metres.
fn refuse_large_holes(grid: &Grid, found: &[holes::Hole], limit: f64, clear: &Aperture) -> Result<(), Problem> {
    let pixel_area = grid.pixel[0] * grid.pixel[1];
    let area = |hole: &holes::Hole| hole.pixels.len() as f64 * pixel_area;
    let Some(hole) = found.iter().rev().max_by_key(|hole| hole.pixels.len()).filter(|hole| area(hole) > limit) else {
        return Ok(());
    };
    let others = found.iter().filter(|hole| area(hole) > limit).count() - 1;
    let problem = if hole.open { falls_short(grid, hole, clear) } else { too_large_hole(grid, hole, limit) };
    Err(if others == 0 {
        problem
    } else {
        problem.note(format!("{others} more {} refused too", if others == 1 { "hole is" } else { "holes are" }))
    })
}

/// The map ends inside the clear aperture: says how deep, and where the deepest pixel is.
fn falls_short(grid: &Grid, hole: &holes::Hole, clear: &Aperture) -> Problem {
    let (mut deepest, mut place) = (0.0, [0.0; 2]);
    for i in &hole.pixels {
        let [x, y] = grid.position(i / grid.columns, i % grid.columns);
        let depth = clear.distance(x, y) + 0.5 * grid.pixel[0].max(grid.pixel[1]);
        if depth > deepest {
            (deepest, place) = (depth, [x, y]);
        }
    }
    let message = format!(
        "the measured pixels end up to {:.3} mm inside the clear aperture, near x {:.3} mm, y {:.3} mm",
        deepest * 1e3,
        place[0] * 1e3,
        place[1] * 1e3
    );
    Problem::error(codes::E0509, "file", message).help(smaller_clear(deepest))
}

/// What to do where the map falls short of the clear aperture by `missing` metres.
fn smaller_clear(missing: f64) -> String {
    // In whole tenths of a millimetre, upwards.
    let inward = (missing * 1e4).ceil() / 10.0;
    format!(
        "measure the whole part, or let `clear` end {inward:.1} mm farther in on every side (that is, {:.1} mm less in \
         diameter); check `centre`, and `pixel` where the file does not state it",
        2.0 * inward
    )
}

fn too_large_hole(grid: &Grid, hole: &holes::Hole, limit: f64) -> Problem {
    let count = hole.pixels.len() as f64;
    let (mut x, mut y) = (0.0, 0.0);
    for i in &hole.pixels {
        let place = grid.position(i / grid.columns, i % grid.columns);
        x += place[0] / count;
        y += place[1] / count;
    }
    let (filled, help) = if limit > 0.0 {
        (format!("holes up to {} are filled", square_millimetres(limit)), "raise `fill_below`")
    } else {
        ("the job lets none be filled".to_string(), "allow holes of that size by `fill_below`")
    };
    // Adding zero turns -0.0 into 0.0.
    let message = format!(
        "the map has a hole of {} ({}) inside the clear aperture about x {:.3} mm, y {:.3} mm; {filled}",
        square_millimetres(count * grid.pixel[0] * grid.pixel[1]),
        plural(hole.pixels.len(), "pixel"),
        (x * 1e6).round() / 1e3 + 0.0,
        (y * 1e6).round() / 1e3 + 0.0
    );
    Problem::error(codes::E0510, "fill_below", message)
        .help(format!("measure again, or {help} if a smooth surface may be assumed there"))
}

fn plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

fn square_millimetres(area: f64) -> String {
    format!("{:.3} mm^2", area * 1e6)
}
