//! Contact frames: how the tool stands on the part.
//!
//! In: a contact point with its outward normal (part frame), the tool's stand-off and azimuth. Out: the tool frame in
//! the part frame. The tool's z axis points into the glass against the normal; its x axis is a reference direction of
//! the part, laid into the tangent plane. The frame depends on the point alone, not on the way there, and has no place
//! where its sign turns, except where the normal runs along the reference direction itself.

use super::ToolPose;
use super::frames::{Transform, quaternion, quaternion_from_matrix, wxyz};
use nalgebra::{Translation3, UnitQuaternion};

/// The least length of the reference direction's projection, the sine of its angle to the normal: at about 6 degrees
/// from the normal the tool's azimuth turns ten times as fast as the normal does, and is no longer what the job meant.
const LEAST_PROJECTION: f64 = 0.1;

/// The direction of the tool's x axis over the part, from +x towards +y of the part seen from the tool side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Azimuth {
    cosine: f64,
    sine: f64,
}

impl Azimuth {
    /// From the angle in radians.
    pub fn new(angle: f64) -> Azimuth {
        let (sine, cosine) = libm::sincos(angle);
        Azimuth { cosine, sine }
    }
}

/// The orientation of the tool on a surface with the outward unit normal `normal`: z = -normal, x = the reference
/// direction (cos azimuth, sin azimuth, 0) in the tangent plane, y = z cross x. `Err` holds the sine of the angle
/// between normal and reference direction, when it is less than 0.1.
pub fn orientation(normal: [f64; 3], azimuth: Azimuth) -> Result<UnitQuaternion<f64>, f64> {
    let z = normal.map(|n| -n);
    let along = azimuth.cosine * z[0] + azimuth.sine * z[1];
    let x = [azimuth.cosine - along * z[0], azimuth.sine - along * z[1], -along * z[2]];
    let length = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt();
    if length < LEAST_PROJECTION {
        return Err(length);
    }
    let x = x.map(|a| a / length);
    let y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
    Ok(quaternion_from_matrix(&[[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]))
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
