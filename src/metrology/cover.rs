//! Cover: whether a map says enough of the part.
//!
//! In: a grid in the part frame and the clear aperture. Out: nothing, or the refusal that says where and how much is
//! missing: the picture ends too soon, or it has a hole inside the clear aperture.

use super::holes;
use crate::diagnostics::{Problem, codes};
use crate::height_map::Grid;
use crate::job::Aperture;

/// Which pixels have their centre inside the aperture.
pub(super) fn inside(grid: &Grid, aperture: &Aperture) -> Vec<bool> {
    (0..grid.values.len())
        .map(|i| {
            let [x, y] = grid.position(i / grid.columns, i % grid.columns);
            aperture.contains(x, y)
        })
        .collect()
}

/// The pixels' area must hold the clear aperture. A pixel reaches half its side beyond its centre.
pub(super) fn frame_covers(grid: &Grid, clear: &Aperture) -> Result<(), Problem> {
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

/// Refuses the largest hole that is left in the clear aperture. `whose` tells of a hole the field of the map that it is in,
/// if that is not the map itself, and the largest area that the job lets be filled there.
pub(super) fn no_holes(
    grid: &Grid,
    clear: &Aperture,
    whose: impl FnOnce(&holes::Hole) -> (Option<String>, f64),
) -> Result<(), Problem> {
    let found = holes::find(grid, &inside(grid, clear));
    let Some(hole) = found.iter().rev().max_by_key(|hole| hole.pixels.len()) else { return Ok(()) };
    let (field, limit) = whose(hole);
    let mut problem = if hole.open { falls_short(grid, hole, clear) } else { too_large_hole(grid, hole, limit) };
    if let Some(field) = field {
        problem = problem.within(&field);
    }
    Err(match found.len() - 1 {
        0 => problem,
        1 => problem.note("1 more hole is refused too"),
        others => problem.note(format!("{others} more holes are refused too")),
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

pub(super) fn plural(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

pub(super) fn square_millimetres(area: f64) -> String {
    format!("{:.3} mm^2", area * 1e6)
}
