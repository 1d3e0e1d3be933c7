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
