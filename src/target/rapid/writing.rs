//! Values in the units and notation of RAPID: millimetres, degrees, millimetres a second.
//!
//! In: SI numbers of the motion. Out: bytes of program text. One place, so that a unit is converted in one place.

use crate::job::{Job, RapidController, Target};
use crate::motion::ToolPose;
use crate::target::number::{MOST_DECIMALS, joint_degrees, millimetres, push_fixed, unit_quaternion};

/// Decimals of joint angles in degrees: 1e-5 deg is what single precision resolves at 170 deg, and moves the tool of a
/// 3 m arm by half a micrometre.
const JOINT_DECIMALS: usize = 5;

/// Unused external axes: RAPID's mark for "not connected".
pub const NO_EXTERNAL_AXES: &str = "[9E9,9E9,9E9,9E9,9E9,9E9]";

/// Decimals of each kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimals {
    /// Of a coordinate in millimetres.
    pub position: usize,
    pub quaternion: usize,
    /// Of a speed in mm/s and an orientation speed in deg/s.
    pub speed: usize,
    /// Of a joint angle in degrees.
    pub joint: usize,
}

impl Decimals {
    /// What the job's controller asks for; a profile out of range is refused elsewhere (`E0906`).
    pub fn of(job: &Job) -> Decimals {
        let of = |controller: &RapidController| Decimals {
            position: decimals(controller.position_decimals),
            quaternion: decimals(controller.quaternion_decimals),
            speed: decimals(controller.speed_decimals),
            joint: JOINT_DECIMALS,
        };
        match &job.target {
            Some(Target::rapid(rapid)) => of(&rapid.controller),
            _ => Decimals { position: 0, quaternion: 0, speed: 0, joint: 0 },
        }
    }
}

fn decimals(count: i64) -> usize {
    usize::try_from(count).unwrap_or(0).min(MOST_DECIMALS)
}

/// Writes `[a,b,c]`; `None` where a number cannot be written.
pub fn push_list(out: &mut Vec<u8>, values: &[f64], decimals: usize) -> Option<()> {
    out.push(b'[');
    for (i, value) in values.iter().enumerate() {
        if i > 0 {
            out.push(b',');
        }
        push_fixed(out, *value, decimals)?;
    }
    out.push(b']');
    Some(())
}

/// Writes `[x,y,z],[q1,q2,q3,q4]`: the inside of a pose and the beginning of a robtarget.
pub fn push_pose(out: &mut Vec<u8>, pose: ToolPose, decimals: Decimals) -> Option<()> {
    push_list(out, &millimetres(pose.position), decimals.position)?;
    out.push(b',');
    push_list(out, &unit_quaternion(pose.quaternion), decimals.quaternion)
}

/// Writes `[[six joints],[no external axes]]`.
pub fn push_jointtarget(out: &mut Vec<u8>, joints: [f64; 6], decimals: Decimals) -> Option<()> {
    out.push(b'[');
    push_list(out, &joint_degrees(joints), decimals.joint)?;
    out.push(b',');
    out.extend_from_slice(NO_EXTERNAL_AXES.as_bytes());
    out.push(b']');
    Some(())
}
