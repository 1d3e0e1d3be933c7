//! Values in the units and notation of RAPID: millimetres, degrees, millimetres a second.
//!
//! In: SI numbers of the motion. Out: bytes of program text. One place, so that a unit is converted in one place.

use crate::job::{Controller, Job, Target};
use crate::motion::{ToolPose, Transform};
use crate::target::number::{MOST_DECIMALS, push_fixed};

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
        let of = |controller: &Controller| Decimals {
            position: decimals(controller.position_decimals),
            quaternion: decimals(controller.quaternion_decimals),
            speed: decimals(controller.speed_decimals),
            joint: JOINT_DECIMALS,
        };
        match &job.target {
            Some(Target::rapid(rapid)) => of(&rapid.controller),
            None => Decimals { position: 0, quaternion: 0, speed: 0, joint: 0 },
        }
    }
}

fn decimals(count: i64) -> usize {
    usize::try_from(count).unwrap_or(0).min(MOST_DECIMALS)
}

/// Metres to millimetres.
pub fn millimetres(position: [f64; 3]) -> [f64; 3] {
    position.map(|v| v * 1e3)
}

/// Radians to degrees.
pub fn degrees(angle: f64) -> f64 {
    angle * (180.0 / std::f64::consts::PI)
}

/// Joint angles in degrees.
pub fn joint_degrees(joints: [f64; 6]) -> [f64; 6] {
    joints.map(degrees)
}

/// The quaternion brought to unit length: rounding to the last decimal must be the only error in the text.
pub fn unit_quaternion(q: [f64; 4]) -> [f64; 4] {
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    q.map(|v| v / length)
}

/// Position and quaternion of a transform.
pub fn pose_of(transform: &Transform) -> ToolPose {
    let (t, q) = (transform.translation.vector, transform.rotation);
    // The sign is free; the one with w >= 0 is written, as in the rest of the program's constants.
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    ToolPose { position: [t.x, t.y, t.z], quaternion: [q.w, q.i, q.j, q.k].map(|v| v * sign) }
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

/// Longest line of text that the programs have, the line end not counted. No limit of the controller is documented;
/// this is what public generators write.
pub const LINE_LENGTH: usize = 199;

/// Program text being written: lines with indents and CRLF.
#[derive(Default)]
pub struct Text {
    pub bytes: Vec<u8>,
}

impl Text {
    /// One line at `depth` steps of indent.
    pub fn line(&mut self, depth: usize, text: &str) {
        for _ in 0..depth {
            self.bytes.extend_from_slice(b"    ");
        }
        self.bytes.extend_from_slice(text.as_bytes());
        self.end();
    }

    /// Ends the line.
    pub fn end(&mut self) {
        self.bytes.extend_from_slice(b"\r\n");
    }

    /// A comment, broken at blanks where the line grows too long. What is not plain ASCII is written as an escape:
    /// controllers refuse other characters even in comments, and a line end would let words of the job become code.
    pub fn comment(&mut self, depth: usize, text: &str) {
        let mut plain = String::new();
        for c in text.chars() {
            match c {
                ' '..='~' => plain.push(c),
                _ => plain.extend(c.escape_unicode()),
            }
        }
        let room = LINE_LENGTH - 4 * depth - 2;
        let mut rest = plain.as_str();
        loop {
            // Everything is ASCII here, so a byte is a character.
            if rest.len() <= room {
                self.line(depth, &format!("! {rest}"));
                return;
            }
            let cut = rest[..room].rfind(' ').filter(|at| *at > 0).unwrap_or(room);
            self.line(depth, &format!("! {}", &rest[..cut]));
            rest = rest[cut..].trim_start();
        }
    }
}
