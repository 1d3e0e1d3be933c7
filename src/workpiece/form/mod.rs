//! Forms: the nominal surface as a height over the part's xy plane.
//!
//! In: the job's `form`, for a [`height_grid`] also its file. Out: a [`Surface`], which knows for every place `(x, y)` of
//! the part frame, metres, its [`SurfacePoint`]: sag, slope and second derivatives, from which normal, contact point and
//! [curvature](Curvature) follow. A further form is one more file, one `impl Surface` and one arm of [`surface`].
//!
//! Sag counts positive out of the glass, towards the tool: a concave part rises towards its rim. Whatever sign a drawing
//! gives its coefficients is turned here, once, by the form's `sag`.

mod asphere;
mod curvature;
mod height_grid;
mod off_axis;
mod xy_polynomial;
pub mod zernike;

pub use asphere::Asphere;
pub use curvature::{Curvature, PrincipalCurvature};
pub use height_grid::Spline;

use crate::diagnostics::{Problem, codes};
use crate::job::{Form, Plane, Sag, Side};
use crate::source::FileProvider;

/// The surface at one place. With sag `z(x, y)` in metres:
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfacePoint {
    /// z.
    pub sag: f64,
    /// dz/dx and dz/dy, no dimension.
    pub slope: [f64; 2],
    /// d²z/dx², d²z/dxdy, d²z/dy², one over metres.
    pub second: [f64; 3],
}

impl SurfacePoint {
    /// Unit normal that points out of the glass, towards the tool: (-dz/dx, -dz/dy, 1), normalised. A slope of the
    /// surface never makes its z component negative.
    pub fn normal(&self) -> [f64; 3] {
        let [p, q] = self.slope;
        let length = (1.0 + p * p + q * q).sqrt();
        [-p / length, -q / length, 1.0 / length]
    }

    /// The sum of two surfaces, `scale` times the second.
    fn plus(&self, other: &SurfacePoint, scale: f64) -> SurfacePoint {
        SurfacePoint {
            sag: self.sag + scale * other.sag,
            slope: [0, 1].map(|i| self.slope[i] + scale * other.slope[i]),
            second: [0, 1, 2].map(|i| self.second[i] + scale * other.second[i]),
        }
    }
}

/// A nominal surface.
pub trait Surface: Send + Sync + std::fmt::Debug {
    /// The surface at `(x, y)`, metres, or `None` where the form does not exist (beyond a sphere's radius, say) or has no
    /// normal that points at the tool.
    fn at(&self, x: f64, y: f64) -> Option<SurfacePoint>;

    /// Whether it is z = 0 everywhere.
    fn is_plane(&self) -> bool {
        false
    }
}

impl Surface for Plane {
    fn at(&self, _x: f64, _y: f64) -> Option<SurfacePoint> {
        Some(SurfacePoint::default())
    }

    fn is_plane(&self) -> bool {
        true
    }
}

/// The surface that the form describes. `files` is asked only for a `height_grid`. Fields are `workpiece.form.…`.
///
/// # Errors
///
/// E0602 for numbers that describe no surface; for a height grid those of [`read_file`](crate::height_map::read_file),
/// E0506, E0507 and E0605.
pub fn surface(form: &Form, files: &dyn FileProvider) -> Result<Box<dyn Surface>, Problem> {
    build(form, files).map_err(|problem| problem.within("workpiece.form"))
}

fn build(form: &Form, files: &dyn FileProvider) -> Result<Box<dyn Surface>, Problem> {
    let base = |base: &Form| build(base, files).map_err(|problem| problem.within("base"));
    Ok(match form {
        Form::plane(_) => Box::new(Plane {}),
        Form::sphere(_) | Form::conic(_) | Form::even_asphere(_) | Form::odd_asphere(_) => {
            Box::new(Asphere::new(form)?)
        }
        Form::off_axis(off_axis) => Box::new(off_axis::Segment::new(off_axis)?),
        Form::xy_polynomial(polynomial) => {
            Box::new(xy_polynomial::Polynomial::new(polynomial, base(&polynomial.base)?)?)
        }
        Form::zernike(zernike) => Box::new(zernike::Freeform::new(zernike, base(&zernike.base)?)?),
        Form::height_grid(grid) => Box::new(height_grid::HeightField::new(grid, base(&grid.base)?, files)?),
    })
}

/// +1 where the coefficients count towards the tool, -1 where they count into the glass.
fn sign_of(sag: Sag) -> f64 {
    match sag {
        Sag::positive_towards_tool => 1.0,
        Sag::positive_into_glass => -1.0,
    }
}

/// Curvature at the vertex, positive for a concave surface.
fn vertex_curvature(side: Side, radius: f64) -> Result<f64, Problem> {
    let radius = positive("radius", radius)?;
    Ok(match side {
        Side::concave => 1.0 / radius,
        Side::convex => -1.0 / radius,
    })
}

/// `value` in metres, if it is a positive number.
fn positive(name: &str, value: f64) -> Result<f64, Problem> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    let message = format!("the form's `{name}` is {:.3} mm; it must be positive", value * 1e3);
    Err(Problem::error(codes::E0602, name, message).help("which way the surface is hollow is said by `side`"))
}

/// E0602 for a number that is not finite.
fn finite(name: impl Into<String>, value: f64) -> Result<f64, Problem> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(Problem::error(codes::E0602, name, "a number of the form is not finite"))
}

/// Surfaces for the tests of this module's neighbours.
#[cfg(test)]
pub(crate) mod examples {
    use super::*;
    use crate::source::MemoryFiles;

    /// The surface of a form that needs no file.
    pub fn of(form: Form) -> Box<dyn Surface> {
        surface(&form, &MemoryFiles::default()).expect("a form that can be")
    }

    /// First and second derivatives by central differences of step `h`, against those that `at` gives: the largest
    /// difference of a slope, and of a second derivative times `h`.
    pub fn differences(surface: &dyn Surface, x: f64, y: f64, h: f64) -> (f64, f64) {
        let at = |dx: f64, dy: f64| surface.at(x + dx, y + dy).expect("a place of the form");
        let here = at(0.0, 0.0);
        let (east, west, north, south) = (at(h, 0.0), at(-h, 0.0), at(0.0, h), at(0.0, -h));
        let slope = [(east.sag - west.sag) / (2.0 * h), (north.sag - south.sag) / (2.0 * h)];
        let second = [
            (east.slope[0] - west.slope[0]) / (2.0 * h),
            (east.slope[1] - west.slope[1]) / (2.0 * h),
            (north.slope[1] - south.slope[1]) / (2.0 * h),
        ];
        let worst = |found: &[f64], expected: &[f64]| {
            found.iter().zip(expected).map(|(f, e)| (f - e).abs()).fold(0.0, f64::max)
        };
        (worst(&here.slope, &slope), worst(&here.second, &second) * h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plane_is_flat_and_looks_at_the_tool() {
        let plane = examples::of(Form::plane(Plane {}));
        let point = plane.at(0.1, -0.2).unwrap();
        assert_eq!(point.sag, 0.0);
        assert_eq!(point.normal(), [0.0, 0.0, 1.0]);
        assert!(plane.is_plane());
    }

    #[test]
    fn normal_of_a_tilted_surface_is_perpendicular_to_its_tangents() {
        // Slopes 3/4 and 0: the tangent is (4, 0, 3)/5, so the normal is (-3, 0, 4)/5.
        let point = SurfacePoint { sag: 0.0, slope: [0.75, 0.0], second: [0.0; 3] };
        let [x, y, z] = point.normal();
        assert!((x + 0.6).abs() < 1e-15 && y == 0.0 && (z - 0.8).abs() < 1e-15);
    }
}
