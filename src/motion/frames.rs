//! Frames: rotations and rigid transforms of the job, and the chain from the robot's base to the part.
//!
//! In: the job's [`Frame`](job::Frame)s. Out: [`Transform`]s and [`FrameChain`]. A transform is made of a point and a
//! unit quaternion, so a left-handed frame cannot be said. `base`, `user` and `object` are all absolute or chained as
//! ABB defines them for a tool held by the robot (Application manual, work objects): `world_base * FK(q) * flange_tool
//! = world_user * user_object * pose`.

use crate::diagnostics::{Problem, codes};
use crate::job;
use nalgebra::{Quaternion, Translation3, UnitQuaternion};

/// A rigid transform: `p_outer = rotation * p_inner + translation`, metres.
pub type Transform = nalgebra::Isometry3<f64>;

/// A rotation matrix, row by row; its columns are the inner frame's axes in the outer frame.
pub type Matrix = [[f64; 3]; 3];

/// How far a written quaternion's length may lie from 1: four written decimals, each wrong by up to 5e-5, change the
/// length of a unit quaternion by no more than 1e-4. A larger deviation is a wrong number, not a rounded one.
const UNIT_TOLERANCE: f64 = 1e-4;

/// Below this |cos about_y| the angles about z and x of a rotation turn about the same axis.
const GIMBAL: f64 = 1e-9;

/// All frames of a job, none assumed to be the identity.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameChain {
    /// Robot base in the world.
    pub world_base: Transform,
    /// User frame in the world.
    pub world_user: Transform,
    /// Object frame (the part frame) in the user frame.
    pub user_object: Transform,
    /// Tool frame in the flange frame.
    pub flange_tool: Transform,
}

impl FrameChain {
    /// The chain of a cell. Fails when a rotation is no rotation or a number is not finite.
    pub fn new(cell: &job::RobotCell) -> Result<FrameChain, Problem> {
        Ok(FrameChain {
            world_base: transform(&cell.base.at, &cell.base.rotation, "robot.cell.base")?,
            world_user: transform(&cell.user.at, &cell.user.rotation, "robot.cell.user")?,
            user_object: transform(&cell.object.at, &cell.object.rotation, "robot.cell.object")?,
            flange_tool: transform(&cell.tcp.at, &cell.tcp.rotation, "robot.cell.tcp")?,
        })
    }

    /// The object frame in the robot's base.
    pub fn base_object(&self) -> Transform {
        self.world_base.inverse() * self.world_user * self.user_object
    }

    /// The flange in the robot's base, when the tool frame lies at `tool` in the object frame.
    pub fn flange(&self, tool: &Transform) -> Transform {
        self.base_object() * tool * self.flange_tool.inverse()
    }

    /// The tool frame in the object frame, when the flange lies at `flange` in the robot's base.
    pub fn tool(&self, flange: &Transform) -> Transform {
        self.base_object().inverse() * flange * self.flange_tool
    }
}

/// The transform of a frame's `at` and `rotation`; `field` is the path of the record that holds both.
pub fn transform(at: &job::Point, rotation: &job::Rotation, field: &str) -> Result<Transform, Problem> {
    let place = [at.x.0, at.y.0, at.z.0];
    if place.iter().any(|x| !x.is_finite()) {
        return Err(Problem::error(
            codes::E0801,
            format!("{field}.at"),
            "a coordinate of this frame is not a finite number",
        ));
    }
    let rotation = unit_quaternion(rotation, &format!("{field}.rotation"))?;
    Ok(Transform::from_parts(Translation3::new(place[0], place[1], place[2]), rotation))
}

/// The unit quaternion of a rotation as the job writes it; `field` is its path.
pub fn unit_quaternion(rotation: &job::Rotation, field: &str) -> Result<UnitQuaternion<f64>, Problem> {
    match rotation {
        job::Rotation::no_rotation(_) => Ok(UnitQuaternion::identity()),
        job::Rotation::quaternion(q) => {
            let length = (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z).sqrt();
            // Written so that a length that is no number is refused too.
            if (length - 1.0).abs() <= UNIT_TOLERANCE {
                Ok(quaternion([q.w / length, q.x / length, q.y / length, q.z / length]))
            } else {
                let message =
                    format!("the quaternion has length {length:.6}, a rotation has length 1 to {UNIT_TOLERANCE}");
                Err(Problem::error(codes::E0801, field, message)
                    .help("give more decimals, or check that the order is w, x, y, z"))
            }
        }
        job::Rotation::zyx_intrinsic(angles) => {
            let halves = [angles.about_z.0 / 2.0, angles.about_y.0 / 2.0, angles.about_x.0 / 2.0];
            if halves.iter().any(|a| !a.is_finite()) {
                return Err(Problem::error(codes::E0801, field, "an angle of this rotation is not a finite number"));
            }
            let [(sz, cz), (sy, cy), (sx, cx)] = halves.map(libm::sincos);
            Ok(quaternion([cz, 0.0, 0.0, sz]) * quaternion([cy, 0.0, sy, 0.0]) * quaternion([cx, sx, 0.0, 0.0]))
        }
    }
}

/// A unit quaternion from [w, x, y, z] that the caller knows to be of unit length.
pub(super) fn quaternion([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}

/// [w, x, y, z].
pub fn wxyz(q: &UnitQuaternion<f64>) -> [f64; 4] {
    [q.w, q.i, q.j, q.k]
}

/// The rotation matrix of a unit quaternion.
pub fn matrix(q: &UnitQuaternion<f64>) -> Matrix {
    let (w, x, y, z) = (q.w, q.i, q.j, q.k);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// The unit quaternion of a rotation matrix, with w > 0, or, where w = 0, the first other number positive.
///
/// Shepperd 1978: the largest of the four components is taken from the diagonal, the others from sums and differences
/// divided by it. A tool over a part stands near 180 degrees, where formulas that start from w lose all digits.
pub fn quaternion_from_matrix(m: &Matrix) -> UnitQuaternion<f64> {
    let [[m00, m01, m02], [m10, m11, m12], [m20, m21, m22]] = *m;
    let trace = m00 + m11 + m22;
    let mut q = if trace >= m00 && trace >= m11 && trace >= m22 {
        [1.0 + trace, m21 - m12, m02 - m20, m10 - m01]
    } else if m00 >= m11 && m00 >= m22 {
        [m21 - m12, 1.0 + m00 - m11 - m22, m01 + m10, m02 + m20]
    } else if m11 >= m22 {
        [m02 - m20, m01 + m10, 1.0 - m00 + m11 - m22, m12 + m21]
    } else {
        [m10 - m01, m02 + m20, m12 + m21, 1.0 - m00 - m11 + m22]
    };
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    let first = q.iter().find(|x| **x != 0.0).copied().unwrap_or(1.0);
    let scale = if first < 0.0 { -1.0 / length } else { 1.0 / length };
    for x in &mut q {
        *x *= scale;
    }
    quaternion(q)
}

/// KUKA's A, B, C in radians: `R = Rz(A) Ry(B) Rx(C)`. Where B is a quarter turn, C is taken as 0.
pub fn kuka_abc(m: &Matrix) -> [f64; 3] {
    let cos_b = libm::hypot(m[0][0], m[1][0]);
    let b = libm::atan2(-m[2][0], cos_b);
    if cos_b < GIMBAL {
        [libm::atan2(-m[0][1], m[1][1]), b, 0.0]
    } else {
        [libm::atan2(m[1][0], m[0][0]), b, libm::atan2(m[2][1], m[2][2])]
    }
}

/// The pose a part `share` (0 to 1) of the way along a straight move: the position on the line, the orientation on the
/// shortest turn at an even rate, which is how controllers lead a linear move.
pub fn between(from: &Transform, to: &Transform, share: f64) -> Transform {
    let position = from.translation.vector + (to.translation.vector - from.translation.vector) * share;
    let (a, mut b) = (wxyz(&from.rotation), wxyz(&to.rotation));
    let mut dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    if dot < 0.0 {
        dot = -dot;
        b = b.map(|x| -x);
    }
    // Below 1e-4 rad the chord and the arc share the same points to 1e-13, and the arc's formula divides by its sine.
    let (part_a, part_b) = if dot > 1.0 - 1e-9 {
        (1.0 - share, share)
    } else {
        let angle = libm::acos(dot);
        let sine = libm::sin(angle);
        (libm::sin((1.0 - share) * angle) / sine, libm::sin(share * angle) / sine)
    };
    let mut q = [0.0; 4];
    for i in 0..4 {
        q[i] = part_a * a[i] + part_b * b[i];
    }
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    Transform::from_parts(Translation3::from(position), quaternion(q.map(|x| x / length)))
}

/// The angle between two orientations, radians, 0 to pi.
pub fn turn(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    // Twice the arc sine of half the chord: exact for small angles, where the arc cosine has no digits left.
    let (p, q) = (wxyz(a), wxyz(b));
    let square = |sign: f64| (0..4).map(|i| (p[i] - sign * q[i]) * (p[i] - sign * q[i])).fold(0.0, |sum, x| sum + x);
    4.0 * libm::asin((square(1.0).min(square(-1.0)).sqrt() / 2.0).min(1.0))
}
