//! Values in the units and notation of KRL: millimetres, degrees, metres a second.
//!
//! In: SI numbers of the motion. Out: bytes of program text. One place, so that a unit is converted in one place.

use crate::job::KrlController;
use crate::motion::frames::{kuka_abc, matrix};
use crate::motion::{ToolPose, Transform};
use crate::target::number::{MOST_DECIMALS, degrees, joint_degrees, millimetres, push_fixed, push_significant};
use nalgebra::{Quaternion, UnitQuaternion};

/// Decimals of joint angles in degrees: 1e-5 deg is what single precision resolves at 170 deg, and moves the tool of a
/// 3 m arm by half a micrometre.
pub const JOINT_DECIMALS: usize = 5;

/// Digits of each kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digits {
    /// Decimals of a coordinate in millimetres.
    pub position: usize,
    /// Decimals of A, B and C in degrees.
    pub angle: usize,
    /// Significant digits of a speed in m/s.
    pub speed: usize,
}

impl Digits {
    /// What the controller asks for; a profile out of range is refused elsewhere (`E0906`).
    pub fn of(controller: &KrlController) -> Digits {
        let count = |value: i64| usize::try_from(value).unwrap_or(0).min(MOST_DECIMALS);
        Digits {
            position: count(controller.position_decimals),
            angle: count(controller.angle_decimals),
            speed: count(controller.speed_digits),
        }
    }
}

/// Writes `X 1,Y 2,Z 3,A 4,B 5,C 6`; `None` where a number cannot be written.
pub fn push_frame(out: &mut Vec<u8>, position: [f64; 3], abc: [f64; 3], digits: Digits) -> Option<()> {
    for (label, value) in [&b"X "[..], b",Y ", b",Z "].into_iter().zip(millimetres(position)) {
        out.extend_from_slice(label);
        push_fixed(out, value, digits.position)?;
    }
    for (label, value) in [&b",A "[..], b",B ", b",C "].into_iter().zip(abc) {
        out.extend_from_slice(label);
        push_fixed(out, degrees(value), digits.angle)?;
    }
    Some(())
}

/// A, B and C of a unit quaternion [w, x, y, z], radians.
pub fn abc_of([w, x, y, z]: [f64; 4]) -> [f64; 3] {
    kuka_abc(&matrix(&UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))))
}

/// Writes a target: `{X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 35}`.
pub fn push_target(out: &mut Vec<u8>, pose: ToolPose, (status, turn): (u8, u8), digits: Digits) -> Option<()> {
    out.push(b'{');
    push_frame(out, pose.position, abc_of(pose.quaternion), digits)?;
    out.extend_from_slice(b",S ");
    push_fixed(out, f64::from(status), 0)?;
    out.extend_from_slice(b",T ");
    push_fixed(out, f64::from(turn), 0)?;
    out.push(b'}');
    Some(())
}

/// A frame as text: `{X 1,Y 2,Z 3,A 4,B 5,C 6}`.
pub fn frame(frame: &Transform, digits: Digits) -> Option<String> {
    let mut out = b"{".to_vec();
    let t = frame.translation.vector;
    push_frame(&mut out, [t.x, t.y, t.z], kuka_abc(&matrix(&frame.rotation)), digits)?;
    out.push(b'}');
    String::from_utf8(out).ok()
}

/// Joints in radians as text: `{A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}`.
pub fn axis(joints: [f64; 6]) -> Option<String> {
    let mut out = b"{".to_vec();
    for (i, value) in joint_degrees(joints).into_iter().enumerate() {
        out.extend_from_slice(if i > 0 { b",A" } else { b"A" });
        out.push(b'1' + i as u8);
        out.push(b' ');
        push_fixed(&mut out, value, JOINT_DECIMALS)?;
    }
    out.push(b'}');
    String::from_utf8(out).ok()
}

/// Writes a speed in m/s. `None` where it cannot be written, or would be written as 0.
pub fn push_speed(out: &mut Vec<u8>, speed: f64, digits: Digits) -> Option<()> {
    push_significant(out, speed, digits.speed)
}
