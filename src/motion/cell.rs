//! The cell as motion needs it: frames, home, safe poses, travel, load, margins; each number checked before it is used.
//!
//! In: the job's robot. Out: [`Station`]: the arm with everything around it that a plan needs.

use super::arm::{Arm, Joints, joint_field, six};
use super::frames::FrameChain;
use crate::diagnostics::{Problem, codes};
use crate::job;

/// An arm in its cell, all numbers checked.
#[derive(Clone, Debug)]
pub struct Station {
    pub arm: Arm,
    pub frames: FrameChain,
    pub home: Joints,
    pub safe_poses: Vec<Joints>,
    /// Height of the lifted poses over the contact point, along the normal, metres.
    pub travel_height: f64,
    /// Speed of lifted moves, m/s.
    pub travel_speed: f64,
    /// Part of the rated joint speeds in joint moves, above 0, at most 1.
    pub joint_move_speed: f64,
    /// What every joint keeps from both ends of its range, radians.
    pub range_margin: f64,
    /// Least angle of the wrist from its singular positions, radians.
    pub wrist_margin: f64,
    /// Least |sine| of the elbow angle.
    pub elbow_margin: f64,
    /// Least distance of the wrist centre from axis 1, metres.
    pub shoulder_margin: f64,
}

impl Station {
    /// The robot of the job with its cell. Refuses an arm that is none, frames whose rotations are none, a load that
    /// the arm cannot carry or that nobody measured, poses outside the joint ranges, and margins, heights and speeds
    /// that cannot be.
    pub fn new(robot: &job::Robot) -> Result<Station, Problem> {
        let arm = Arm::new(robot)?;
        let Some(cell) = &robot.cell else {
            let message = "the robot has no cell: no frames, no tool centre point, no home";
            return Err(Problem::error(codes::E0803, "robot.cell", message).help("give the robot its `cell`"));
        };
        check_load(&cell.tcp.load, robot.payload.0)?;
        let frames = FrameChain::new(cell)?;
        let bad = |field: &str, message: String| Err(Problem::error(codes::E0803, field, message));
        // All comparisons are written so that a number that is none is refused.
        for (field, value) in [
            ("range_margin", robot.range_margin.0),
            ("wrist_margin", robot.wrist_margin.0),
            ("elbow_margin", robot.elbow_margin),
            ("shoulder_margin", robot.shoulder_margin.0),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return bad(&format!("robot.{field}"), format!("`{field}` must not be negative"));
            }
        }
        if !(cell.travel.height.0 > 0.0 && cell.travel.height.0.is_finite()) {
            let height = cell.travel.height.0 * 1e3;
            return bad(
                "robot.cell.travel.height",
                format!("the travel height is {height:.3} mm, it must be above 0 mm"),
            );
        }
        if !(cell.travel.speed.0 > 0.0 && cell.travel.speed.0.is_finite()) {
            let speed = cell.travel.speed.0 * 1e3;
            return bad(
                "robot.cell.travel.speed",
                format!("the travel speed is {speed:.3} mm/s, it must be above 0 mm/s"),
            );
        }
        if !(cell.joint_move_speed > 0.0 && cell.joint_move_speed <= 1.0) {
            let share = cell.joint_move_speed;
            let message = format!(
                "joint moves are to run at {share} of the rated joint speeds, the part lies above 0 and up to 1"
            );
            return bad("robot.cell.joint_move_speed", message);
        }
        let margin = robot.range_margin.0;
        let pose = |angles: &[crate::units::si::Angle], field: &str, name: &str| -> Result<Joints, Problem> {
            let joints = six(angles.iter().map(|angle| angle.0), field, "joint angles")?;
            let (least, i) = arm.least_margin(&joints);
            if joints.iter().all(|angle| angle.is_finite()) && arm.within(&joints, margin) {
                return Ok(joints);
            }
            let i = joints.iter().position(|angle| !angle.is_finite()).unwrap_or(i);
            let message = format!(
                "in {name} joint {} stands at {:.3} deg, {:.3} deg from the end of its range, the margin is {:.3} deg",
                i + 1,
                joints[i].to_degrees(),
                least.to_degrees(),
                margin.to_degrees()
            );
            let range = format!("the range is {}", range(&arm, i));
            Err(Problem::error(codes::E0803, field, message).note(range).help(format!(
                "give a pose inside the range, or a smaller `range_margin` if the robot may go there (`{}`)",
                joint_field(i)
            )))
        };
        let home = pose(&cell.home, "robot.cell.home", "`home`")?;
        let safe_poses = cell
            .safe_poses
            .iter()
            .enumerate()
            .map(|(i, angles)| pose(angles, &format!("robot.cell.safe_poses.{i}"), &format!("safe pose {}", i + 1)))
            .collect::<Result<Vec<Joints>, Problem>>()?;
        Ok(Station {
            frames,
            home,
            safe_poses,
            travel_height: cell.travel.height.0,
            travel_speed: cell.travel.speed.0,
            joint_move_speed: cell.joint_move_speed,
            range_margin: margin,
            wrist_margin: robot.wrist_margin.0,
            elbow_margin: robot.elbow_margin,
            shoulder_margin: robot.shoulder_margin.0,
            arm,
        })
    }
}

/// A joint's range in words.
pub(super) fn range(arm: &Arm, joint: usize) -> String {
    format!("{:.3} deg .. {:.3} deg", arm.lower[joint].to_degrees(), arm.upper[joint].to_degrees())
}

/// A wrong load makes a controller steer wrongly (RAPID reference, `tooldata`), and controllers refuse a mass of zero
/// and a centre of gravity exactly in the flange: such numbers were never measured.
fn check_load(load: &job::Load, payload: f64) -> Result<(), Problem> {
    let mass = load.mass.0;
    if !(mass > 0.0 && mass.is_finite()) {
        let message = format!("the tool's mass is {mass} kg");
        return Err(Problem::error(codes::E0802, "robot.cell.tcp.load.mass", message).help("weigh the tool"));
    }
    // Written so that a payload that is no number is refused.
    let carried = mass <= payload;
    if !carried {
        let message = format!("the tool's mass of {mass} kg is above the robot's payload of {payload} kg");
        return Err(Problem::error(codes::E0802, "robot.cell.tcp.load.mass", message)
            .help("check both numbers; a heavier tool needs a stronger robot"));
    }
    let centre = [load.centre.x.0, load.centre.y.0, load.centre.z.0];
    if centre.iter().any(|x| !x.is_finite()) || centre == [0.0; 3] {
        let message = "the tool's centre of gravity lies exactly in the origin, where no tool has it";
        return Err(Problem::error(codes::E0802, "robot.cell.tcp.load.centre", message)
            .help("let the controller identify the load, or take it from the tool's drawing"));
    }
    if let Some(inertia) = &load.inertia
        && [inertia.x.0, inertia.y.0, inertia.z.0].iter().any(|i| !(*i >= 0.0 && i.is_finite()))
    {
        let message = "a moment of inertia of the tool is negative or no number";
        return Err(Problem::error(codes::E0802, "robot.cell.tcp.load.inertia", message));
    }
    Ok(())
}
