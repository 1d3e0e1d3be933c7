//! The digest that ties the files of one program together.
//!
//! In: the motion and the job. Out: 32 hexadecimal digits. The main program carries it, every other file carries it, and
//! compares the two before it moves: a file that stayed on the controller from an older build stops the program.
//!
//! It is the BLAKE3 hash, shortened to 128 bits, of what decides the motion: the job's target and robot, the purpose,
//! and, for each run in order, a hash of every number as it is written: rounded, in millimetres and degrees. Comments
//! and layout are not part of it.

use super::number::{joint_degrees, millimetres, scaled, unit_quaternion};
use crate::job::Job;
use crate::motion::{Motion, Purpose, ToolPose};
use rayon::prelude::*;

/// How the numbers of a target are rounded for the digest.
#[derive(Clone, Copy, Debug)]
pub struct Rounding {
    /// The target, and the version of its program's structure.
    pub label: &'static [u8],
    /// Decimals of a coordinate in mm, of a quaternion, of a joint in degrees, of a speed in mm/s.
    pub position: usize,
    pub quaternion: usize,
    pub joint: usize,
    pub speed: usize,
}

/// The digest of the program of `motion` for `job`.
pub fn digest(motion: &Motion, job: &Job, decimals: Rounding) -> String {
    let runs: Vec<blake3::Hash> = (0..motion.runs.len()).into_par_iter().map(|r| run(motion, r, decimals)).collect();
    let mut hasher = blake3::Hasher::new();
    hasher.update(decimals.label);
    hasher.update(match motion.purpose {
        Purpose::Polish => b"polish",
        Purpose::DryRun => b"dryrun",
    });
    // Records serialise field by field in the order of their declaration, numbers in their shortest exact form.
    hasher.update(&serde_json::to_vec(&(&job.target, &job.robot)).unwrap_or_default());
    for hash in runs {
        hasher.update(hash.as_bytes());
    }
    let hex = hasher.finalize().to_hex();
    hex[..32].to_string()
}

fn run(motion: &Motion, index: usize, decimals: Rounding) -> blake3::Hash {
    // Large pieces: the hash is fastest on more than a kilobyte at a time.
    const PIECE: usize = 1 << 14;
    let mut hasher = blake3::Hasher::new();
    let mut bytes: Vec<u8> = Vec::with_capacity(PIECE + 256);
    let number = |bytes: &mut Vec<u8>, value: f64, decimals: usize| {
        // A number that cannot be written is refused by the emitter; here it only needs to be something.
        bytes.extend_from_slice(&scaled(value, decimals).unwrap_or(i64::MIN).to_le_bytes());
    };
    let pose = |bytes: &mut Vec<u8>, pose: ToolPose| {
        for value in millimetres(pose.position) {
            number(bytes, value, decimals.position);
        }
        for value in unit_quaternion(pose.quaternion) {
            number(bytes, value, decimals.quaternion);
        }
    };
    let Some(run) = motion.runs.get(index) else { return hasher.finalize() };
    for (end, joints) in [(run.approach, run.approach_joints), (run.retract, run.retract_joints)] {
        pose(&mut bytes, end);
        for value in joint_degrees(joints) {
            number(&mut bytes, value, decimals.joint);
        }
    }
    for line in &motion.timed.path.lines[run.lines.clone()] {
        bytes.extend_from_slice(&(line.points.len() as u64).to_le_bytes());
        for i in line.points.clone() {
            pose(&mut bytes, ToolPose { position: motion.position[i], quaternion: motion.quaternion[i] });
            for quarter in motion.confdata[i] {
                bytes.extend_from_slice(&quarter.to_le_bytes());
            }
            number(&mut bytes, motion.timed.speed[i] * 1e3, decimals.speed);
            if bytes.len() >= PIECE {
                hasher.update(&bytes);
                bytes.clear();
            }
        }
    }
    hasher.update(&bytes);
    hasher.finalize()
}
