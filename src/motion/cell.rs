//! The cell as motion needs it: frames, home, safe poses, travel, load, margins; each number checked before it is used.
//!
//! In: the job's robot. Out: [`Station`]: the arm with everything around it that a plan needs.

use super::arm::{Arm, Joints, joint_field, six};
use super::frames::{FrameChain, matrix};
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
        check_inertia(robot, &cell.tcp.load, &frames)?;
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

/// What the wrist must turn, against what it can, where the maker's numbers are known: the moments of the load about axis
/// 6, and about axis 5 for the most unfavourable turn of axis 6. Both axes pass through the wrist centre, which lies `c4`
/// behind the flange; moments go there by the parallel axis theorem.
fn check_inertia(robot: &job::Robot, load: &job::Load, frames: &FrameChain) -> Result<(), Problem> {
    let Some(most) = &robot.wrist_inertia else { return Ok(()) };
    let job::Arm::ortho_parallel(arm) = &robot.arm;
    let mass = load.mass.0;
    let [x, y, z] = [load.centre.x.0, load.centre.y.0, load.centre.z.0 + arm.c4.0];
    let m = matrix(&frames.flange_tool.rotation);
    let own = load.inertia.map_or([0.0; 3], |i| [i.x.0, i.y.0, i.z.0]);
    // The load's own moments lie along the tool frame's axes; this is their tensor in the flange frame.
    let tensor = |i: usize, j: usize| (0..3).map(|k| m[i][k] * own[k] * m[j][k]).fold(0.0, |sum, part| sum + part);
    let about_z = tensor(2, 2) + mass * (x * x + y * y);
    // The greatest moment about an axis across the flange's: the larger eigenvalue of that part of the tensor.
    let (xx, yy, xy) =
        (tensor(0, 0) + mass * (y * y + z * z), tensor(1, 1) + mass * (x * x + z * z), tensor(0, 1) - mass * x * y);
    let across = 0.5 * (xx + yy) + libm::hypot(0.5 * (xx - yy), xy);
    for (axis, found, most) in [(5, across, most.axis_5.0), (6, about_z, most.axis_6.0)] {
        // Written so that a moment that is no number is refused.
        let carried = found <= most;
        if !carried {
            let message = format!(
                "the tool has a moment of inertia of {found:.3} kg*m^2 about axis {axis}, the robot's wrist turns {most:.3} kg*m^2"
            );
            return Err(Problem::error(codes::E0802, "robot.cell.tcp.load", message)
                .help("check the load's mass, centre and inertia, and the robot's `wrist_inertia`"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Transform;
    use crate::units::si::{Inertia, Length, Mass};

    /// 10 kg, 30 mm beside axis 6 and 300 mm from the flange, which lies 200 mm from the wrist centre, with 0.1, 0.2 and
    /// 0.3 kg m^2 of its own along a tool frame turned a quarter about y: the flange's z is the tool's -x. About axis 6:
    /// 0.1 + 10 * 0.03^2 = 0.109. Across: about the flange's x 0.3 + 10 * 0.5^2 = 2.8, about y 0.2 + 10 (0.03^2 + 0.5^2) =
    /// 2.709; the greater is 2.8.
    #[test]
    fn moments_about_the_wrist() {
        let load = job::Load {
            mass: Mass(10.0),
            centre: job::Point { x: Length(0.03), y: Length(0.0), z: Length(0.3) },
            inertia: Some(job::LoadInertia { x: Inertia(0.1), y: Inertia(0.2), z: Inertia(0.3) }),
        };
        let quarter = std::f64::consts::FRAC_1_SQRT_2;
        let tool = super::super::frames::quaternion([quarter, 0.0, quarter, 0.0]);
        let frames = FrameChain {
            world_base: Transform::identity(),
            world_user: Transform::identity(),
            user_object: Transform::identity(),
            flange_tool: Transform::from_parts(nalgebra::Translation3::identity(), tool),
        };
        let length = Length;
        let robot = |axis_5: f64, axis_6: f64| job::Robot {
            maker: "A".into(),
            model: "B".into(),
            arm: job::Arm::ortho_parallel(job::OrthoParallel {
                a1: length(0.3),
                a2: length(0.0),
                b: length(0.0),
                c1: length(0.7),
                c2: length(1.0),
                c3: length(1.0),
                c4: length(0.2),
                offsets: vec![],
                signs: vec![],
            }),
            joints: vec![],
            payload: Mass(100.0),
            wrist_inertia: Some(job::WristInertia { axis_5: Inertia(axis_5), axis_6: Inertia(axis_6) }),
            range_margin: crate::units::si::Angle(0.0),
            wrist_margin: crate::units::si::Angle(0.0),
            elbow_margin: 0.1,
            shoulder_margin: length(0.1),
            cell: None,
        };
        let said = |axis_5, axis_6| check_inertia(&robot(axis_5, axis_6), &load, &frames).err().map(|p| p.message);
        assert_eq!(said(2.801, 0.1091), None);
        assert!(said(2.799, 1.0).is_some_and(|said| said.contains("2.800 kg*m^2 about axis 5")));
        assert!(said(3.0, 0.1089).is_some_and(|said| said.contains("0.109 kg*m^2 about axis 6")));
        assert_eq!(check_inertia(&job::Robot { wrist_inertia: None, ..robot(0.0, 0.0) }, &load, &frames), Ok(()));
    }
}
