//! Forms: the nominal surface as a height over the part's xy plane.
//!
//! In: a place `(x, y)` of the part frame, metres. Out: [`SurfacePoint`]: sag, slope and second derivatives, from which
//! normal and contact point follow. A further form is one more `impl Surface` and one arm of [`Form::surface`].

use crate::job::{Form, Plane};

/// The surface at one place. With sag `z(x, y)` in metres:
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

/// A nominal surface.
pub trait Surface {
    /// The surface at `(x, y)`, or `None` where the form does not exist (beyond a sphere's radius, say).
    fn at(&self, x: f64, y: f64) -> Option<SurfacePoint>;
}

impl Form {
    /// The surface that the form describes.
    pub fn surface(&self) -> &dyn Surface {
        match self {
            Form::plane(plane) => plane,
        }
    }
}

impl Surface for Plane {
    fn at(&self, _x: f64, _y: f64) -> Option<SurfacePoint> {
        Some(SurfacePoint { sag: 0.0, slope: [0.0; 2], second: [0.0; 3] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plane_is_flat_and_looks_at_the_tool() {
        let form = Form::plane(Plane {});
        let point = form.surface().at(0.1, -0.2).unwrap();
        assert_eq!(point.sag, 0.0);
        assert_eq!(point.normal(), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn normal_of_a_tilted_surface_is_perpendicular_to_its_tangents() {
        // Slopes 3/4 and 0: the tangent is (4, 0, 3)/5, so the normal is (-3, 0, 4)/5.
        let point = SurfacePoint { sag: 0.0, slope: [0.75, 0.0], second: [0.0; 3] };
        let [x, y, z] = point.normal();
        assert!((x + 0.6).abs() < 1e-15 && y == 0.0 && (z - 0.8).abs() < 1e-15);
    }
}
