//! Stance: how the tool is turned over a contact point.
//!
//! In: the outward unit normal there, the job's azimuth. Out: the tool's axes in the part frame. The z axis points into
//! the glass against the normal; the x axis is a reference direction of the part, laid into the tangent plane. It depends on
//! the point alone, not on the way there, and has no place where its sign turns, except where the normal runs along the
//! reference direction itself.

/// The least length of the reference direction's projection, the sine of its angle to the normal: at about 6 degrees
/// from the normal the tool's azimuth turns ten times as fast as the normal does, and is no longer what the job meant.
const LEAST_PROJECTION: f64 = 0.1;

/// The direction of the tool's x axis over the part, from +x towards +y of the part seen from the tool side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Azimuth {
    pub(super) cosine: f64,
    pub(super) sine: f64,
}

impl Azimuth {
    /// From the angle in radians.
    pub fn new(angle: f64) -> Azimuth {
        let (sine, cosine) = libm::sincos(angle);
        Azimuth { cosine, sine }
    }

    /// The tool's x, y and z axis over the outward unit normal `normal`: z = -normal, x = the reference direction
    /// (cos azimuth, sin azimuth, 0) in the tangent plane, y = z cross x. `Err` holds the sine of the angle between normal
    /// and reference direction, when it is less than 0.1.
    pub fn axes(self, normal: [f64; 3]) -> Result<[[f64; 3]; 3], f64> {
        let z = normal.map(|n| -n);
        let along = self.cosine * z[0] + self.sine * z[1];
        let x = [self.cosine - along * z[0], self.sine - along * z[1], -along * z[2]];
        let length = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt();
        if length < LEAST_PROJECTION {
            return Err(length);
        }
        let x = x.map(|a| a / length);
        let y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
        Ok([x, y, z])
    }

    /// The part's axes x and y turned with the tool, whose own are `x` and `y`: the transpose of
    /// [`part_to_tool`](super::part_to_tool), which is its own inverse.
    pub fn carried(self, x: [f64; 3], y: [f64; 3]) -> [[f64; 3]; 2] {
        let (c, s) = (self.cosine, self.sine);
        [[0, 1, 2].map(|i| c * x[i] + s * y[i]), [0, 1, 2].map(|i| s * x[i] - c * y[i])]
    }
}

#[cfg(test)]
mod tests {
    use super::super::part_to_tool;
    use super::*;

    fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn on_a_plane_the_axes_are_those_of_the_plane() {
        for degrees in [0.0, 30.0, 90.0, -135.0, 180.0] {
            let angle = f64::to_radians(degrees);
            let azimuth = Azimuth::new(angle);
            let [x, y, z] = azimuth.axes([0.0, 0.0, 1.0]).expect("across");
            assert_eq!(z, [0.0, 0.0, -1.0]);
            let place = [0.3, -0.2, 0.0];
            let [tx, ty] = part_to_tool(0.3, -0.2, angle);
            assert!((dot(place, x) - tx).abs() < 1e-15 && (dot(place, y) - ty).abs() < 1e-15);
            let [a, b] = azimuth.carried(x, y);
            assert!((dot(place, a) - 0.3).abs() < 1e-15 && (dot(place, b) + 0.2).abs() < 1e-15);
        }
    }

    #[test]
    fn on_a_slope_the_carried_axes_lie_in_the_tangent_plane() {
        // Falling by 3 in 4 along x: the normal is (3, 0, 4)/5. With the azimuth along x the tool's x runs downhill, with
        // the azimuth along y it stays level; the part's axes are carried to the same two lines.
        for degrees in [0.0, 90.0_f64] {
            let azimuth = Azimuth::new(degrees.to_radians());
            let [x, y, _] = azimuth.axes([0.6, 0.0, 0.8]).expect("across");
            let [a, b] = azimuth.carried(x, y);
            for (found, expected) in a.iter().chain(&b).zip([0.8, 0.0, -0.6, 0.0, 1.0, 0.0]) {
                assert!((found - expected).abs() < 1e-15, "{a:?} {b:?}");
            }
        }
    }
}
