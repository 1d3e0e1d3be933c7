//! Workpiece: the optic as geometry.
//!
//! In: the job's `workpiece`. Out: whether a place lies on the part ([`aperture`]), how high the nominal surface is and
//! where its normal points ([`form`]), and what is wrong with the description ([`check`], [`check_surface`]). Path,
//! metrology, dwell and motion all ask here, so that the shape of the part is said in one place.
//!
//! Part frame: origin at the vertex, +z out of the glass towards the tool, x and y as marked on the part; metres.

pub mod aperture;
pub mod form;
mod polygon;

pub(crate) use polygon::grown;

use crate::diagnostics::{Problem, codes};
use crate::job::{Aperture, Workpiece};
use form::Surface;

/// How far the clear aperture may reach past the edge before it is an error: the rounding of the numbers of a job
/// (a clear aperture equal to the edge must pass), far below anything that can be measured on a part.
const ROUNDING: f64 = 1e-9;

/// Everything that is wrong with the workpiece as geometry: sizes that are not positive, a ring whose hole is as wide
/// as itself (E0600), a clear aperture that leaves the part (E0601). Fields are `workpiece.…`.
pub fn check(workpiece: &Workpiece) -> Vec<Problem> {
    let mut problems = Vec::new();
    problems.extend(aperture::check(&workpiece.edge, "workpiece.edge"));
    problems.extend(aperture::check(&workpiece.clear, "workpiece.clear"));
    if problems.is_empty() {
        problems.extend(clear_inside_edge(&workpiece.edge, &workpiece.clear));
    }
    problems
}

fn clear_inside_edge(edge: &Aperture, clear: &Aperture) -> Option<Problem> {
    let say = |message: String| {
        Problem::error(codes::E0601, "workpiece.clear", message)
            .help("make `clear` smaller, or correct its `centre` or the `edge`")
    };
    // The hole first: a place in the hole is outside the edge too.
    if let Some(hole) = edge.hole_radius() {
        let [x, y] = edge.centre();
        let into_the_hole = clear.distance(x, y) + hole;
        if into_the_hole > ROUNDING {
            return Some(say(format!(
                "the clear aperture reaches into the hole of the part, which has {:.3} mm diameter about x {:.3} mm, y \
                 {:.3} mm",
                hole * 2e3,
                x * 1e3,
                y * 1e3
            )));
        }
    }
    let ([x, y], excess) = clear.farthest_beyond(edge);
    (excess > ROUNDING).then(|| {
        say(format!(
            "the clear aperture reaches {:.3} mm beyond the edge of the part at x {:.3} mm, y {:.3} mm",
            excess * 1e3,
            x * 1e3,
            y * 1e3
        ))
    })
}

/// How many places across the part are asked whether the form exists there: ten thousand over the area, and as dense on
/// the edge. The path is asked at every point besides.
const PLACES_ACROSS: usize = 100;

/// E0603 if the form does not exist everywhere on the part.
pub fn check_surface(workpiece: &Workpiece, surface: &dyn Surface) -> Option<Problem> {
    let edge = &workpiece.edge;
    let aperture::Bounds { min, max } = edge.bounds();
    let step = [0, 1].map(|axis| (max[axis] - min[axis]) / PLACES_ACROSS as f64);
    let inside = (0..(PLACES_ACROSS + 1) * (PLACES_ACROSS + 1))
        .map(|i| {
            let (row, column) = (i / (PLACES_ACROSS + 1), i % (PLACES_ACROSS + 1));
            [min[0] + column as f64 * step[0], min[1] + row as f64 * step[1]]
        })
        .filter(|[x, y]| edge.contains(*x, *y));
    let mut places = edge.outline(step[0].max(step[1])).into_iter().chain(inside);
    let bad = places.find(|[x, y]| surface.at(*x, *y).is_none())?;
    Some(where_it_ends(surface, edge.centre(), bad, "workpiece.form", "the part reaches"))
}

/// E0603: the form does not exist at `place`; `what` reaches there. Says how far from `centre` in that direction it exists.
pub fn where_it_ends(surface: &dyn Surface, centre: [f64; 2], place: [f64; 2], field: &str, what: &str) -> Problem {
    let at = |t: f64| [0, 1].map(|i| centre[i] + t * (place[i] - centre[i]));
    let exists = |t: f64| {
        let [x, y] = at(t);
        surface.at(x, y).is_some()
    };
    let [x, y] = place.map(|metres| metres * 1e3);
    let problem =
        Problem::error(codes::E0603, field, format!("{what} x {x:.3} mm, y {y:.3} mm, where the form does not exist"));
    if !exists(0.0) {
        return problem.help("check the numbers of `form`: it does not exist in the middle either");
    }
    // The greatest share of the way that exists, to a millionth of it.
    let (mut good, mut bad) = (0.0, 1.0);
    while bad - good > 1e-6 {
        let middle = (good + bad) / 2.0;
        if exists(middle) { good = middle } else { bad = middle }
    }
    let length = libm::hypot(place[0] - centre[0], place[1] - centre[1]);
    let [cx, cy] = centre.map(|metres| metres * 1e3 + 0.0);
    // Rounded down to a micrometre, so that what is said exists.
    let reach = (good * length * 1e6).floor() / 1e3;
    let narrower = if field.starts_with("path") { "`over`" } else { "the part" };
    problem.help(format!(
        "in that direction the form exists up to {reach:.3} mm from x {cx:.3} mm, y {cy:.3} mm: let {narrower} stay inside, \
         or correct the numbers of `form`"
    ))
}
