//! Workpiece: the optic as geometry.
//!
//! In: the job's `workpiece`. Out: whether a place lies on the part ([`aperture`]), how high the nominal surface is and
//! where its normal points ([`form`]), and what is wrong with the description ([`check`]). Path, metrology, dwell and
//! motion all ask here, so that the shape of the part is said in one place.
//!
//! Part frame: origin at the vertex, +z out of the glass towards the tool, x and y as marked on the part; metres.

pub mod aperture;
pub mod form;

use crate::diagnostics::{Problem, codes};
use crate::job::{Aperture, Workpiece};

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
    let beyond = |[x, y]: &[f64; 2]| -edge.distance(*x, *y);
    let places = clear.extremes(edge);
    let [x, y] = places.into_iter().max_by(|a, b| beyond(a).total_cmp(&beyond(b)))?;
    let excess = beyond(&[x, y]);
    (excess > ROUNDING).then(|| {
        say(format!(
            "the clear aperture reaches {:.3} mm beyond the edge of the part at x {:.3} mm, y {:.3} mm",
            excess * 1e3,
            x * 1e3,
            y * 1e3
        ))
    })
}
