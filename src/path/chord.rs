//! Chords: between two points of a line the arm moves straight, and over a curved surface it leaves the surface.
//!
//! In: a [`ToolPath`], its surface, the largest departure that the job allows. Out: the largest departure there is, or a
//! refusal with the point step that would pass. The departure is taken midway between the points, along the normal: about
//! `s² / 8R` for a distance s and the radius of curvature R in the direction of travel.

use super::ToolPath;
use crate::diagnostics::{Problem, codes};
use crate::workpiece::form::Surface;

/// The largest departure of a straight move from the surface, metres.
///
/// # Errors
///
/// E0646 if it is more than `most`.
pub fn check(path: &ToolPath, surface: &dyn Surface, most: f64) -> Result<f64, Problem> {
    if surface.is_plane() {
        return Ok(0.0);
    }
    let points = &path.points;
    let (mut largest, mut place, mut step) = (0.0, [0.0; 2], 0.0);
    for line in &path.lines {
        for i in line.points.start + 1..line.points.end {
            let (a, b) = (points.position(i - 1), points.position(i));
            let middle = [0, 1, 2].map(|k| (a[k] + b[k]) / 2.0);
            let Some(point) = surface.at(middle[0], middle[1]) else { continue };
            let [_, _, normal_z] = point.normal();
            let departure = (middle[2] - point.sag).abs() * normal_z;
            if departure > largest {
                (largest, place, step) = (departure, [middle[0], middle[1]], libm::hypot(b[0] - a[0], b[1] - a[1]));
            }
        }
    }
    if largest <= most {
        return Ok(largest);
    }
    // The departure grows with the square of the step. Rounded down to a hundredth of a millimetre.
    let passes = (step * (most / largest).sqrt() * 1e5).floor() / 100.0;
    let message = format!(
        "midway between two points the path lies {:.3} um off the surface at x {:.3} mm, y {:.3} mm; {:.3} um are allowed",
        largest * 1e6,
        place[0] * 1e3,
        place[1] * 1e3,
        most * 1e6
    );
    Err(Problem::error(codes::E0646, "path.point_step", message)
        .note("the arm moves straight from point to point, and the gap changes by as much")
        .help(format!("make `point_step` at most {passes:.2} mm, or allow more by `chord_error`")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{Form, Plane, Side, Sphere};
    use crate::path::{Line, Link, Points};
    use crate::source::MemoryFiles;
    use crate::units::si::Length;
    use crate::workpiece::form;

    fn line(surface: &dyn Surface, step: f64) -> ToolPath {
        let mut points = Points::default();
        for i in -2..=2 {
            let point = surface.at(f64::from(i) * step, 0.02).expect("on it");
            points.push([f64::from(i) * step, 0.02, point.sag], point.normal());
        }
        ToolPath { points, lines: vec![Line { points: 0..5, link: Link::OnSurface }], ..ToolPath::default() }
    }

    /// On a sphere the departure is the sagitta R - sqrt(R² - s²/4) of the chord s, whatever its place.
    #[test]
    fn the_departure_is_the_sagitta_of_a_chord() {
        let sphere = Form::sphere(Sphere { side: Side::concave, radius: Length(0.2) });
        let sphere = form::surface(&sphere, &MemoryFiles::default()).expect("a sphere");
        let path = line(&*sphere, 4e-3);
        let sagitta = |i: usize| {
            let (a, b) = (path.points.position(i - 1), path.points.position(i));
            let square: f64 = (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum();
            0.2 - (0.04 - square / 4.0).sqrt()
        };
        let expected = (1..5).map(sagitta).fold(0.0, f64::max);
        let found = check(&path, &*sphere, 11e-6).expect("10 um: 16 mm² / 1600 mm");
        // Along the normal instead of towards the centre: the same but for terms of fourth order.
        assert!((found - expected).abs() < 1e-6 * expected, "{found} {expected}");
        let problem = check(&path, &*sphere, 5e-6).expect_err("half of it");
        assert_eq!(problem.code, codes::E0646);
        // 4 mm / sqrt 2, a little less on the slope.
        assert!(problem.help.as_deref().expect("a mend").contains("at most 2.8"), "{:?}", problem.help);
        assert!(check(&line(&*sphere, 2.8e-3), &*sphere, 5e-6).is_ok());
        assert_eq!(check(&line(&Plane {}, 1.0), &Plane {}, 0.0), Ok(0.0));
    }
}
