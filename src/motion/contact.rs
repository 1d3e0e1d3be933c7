//! Contact frames: how the tool stands on the part.
//!
//! In: a contact point with its outward normal (part frame), the tool's stand-off and azimuth. Out: the tool frame in
//! the part frame, turned as the [`tool`](crate::tool::Azimuth) says.

use super::ToolPose;
use super::frames::{Transform, quaternion, quaternion_from_matrix, wxyz};
use crate::tool::Azimuth;
use nalgebra::{Translation3, UnitQuaternion};

/// The orientation of the tool on a surface with the outward unit normal `normal`: its axes are those of
/// [`Azimuth::axes`], and so is the `Err`.
pub fn orientation(normal: [f64; 3], azimuth: Azimuth) -> Result<UnitQuaternion<f64>, f64> {
    let [x, y, z] = azimuth.axes(normal)?;
    Ok(quaternion_from_matrix(&[[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]))
}

/// `contact` leaning: the shaft, which stands against the z axis, leans by `tilt` towards the direction that lies `direction` from +x
/// towards +y of the contact's frame, as the shaft of a bonnet does; the tool is not turned about it. Radians.
pub fn leaning(contact: UnitQuaternion<f64>, direction: f64, tilt: f64) -> UnitQuaternion<f64> {
    let (sine, cosine) = libm::sincos(direction);
    // About the axis that lies a quarter turn after the direction, backwards: the z axis goes away from where the shaft goes.
    let (half_sine, half_cosine) = libm::sincos(-0.5 * tilt);
    contact * quaternion([half_cosine, -sine * half_sine, cosine * half_sine, 0.0])
}

/// The point `distance` metres from `point` along the outward unit normal.
pub fn raised(point: [f64; 3], normal: [f64; 3], distance: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| point[i] + normal[i] * distance)
}

impl ToolPose {
    /// Position and unit quaternion as one transform.
    pub fn transform(&self) -> Transform {
        let [x, y, z] = self.position;
        Transform::from_parts(Translation3::new(x, y, z), quaternion(self.quaternion))
    }

    /// From a transform.
    pub fn new(transform: &Transform) -> ToolPose {
        let p = &transform.translation.vector;
        ToolPose { position: [p.x, p.y, p.z], quaternion: wxyz(&transform.rotation) }
    }
}
