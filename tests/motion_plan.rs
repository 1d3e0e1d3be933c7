//! Whole plans: the tool stands on the contact points through all frames, runs hold one configuration, and what cannot
//! be done is refused with the place on the part.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

#[path = "common/motion.rs"]
mod common;

use common::{IRB_6700, irb_6700_in_cell, point, raster};
use nalgebra::{Translation3, Vector3};
use polishc::diagnostics::{Problem, codes};
use polishc::dwell::{SpeedSteps, TimedPath};
use polishc::job::{self, Frame, Quaternion, RobotCell, Rotation};
use polishc::motion::arm::Arm;
use polishc::motion::contact::orientation;
use polishc::motion::frames::{FrameChain, between, matrix, turn, wxyz};
use polishc::motion::{Checked, Motion, Purpose, Request, Room, Transform, Travel, plan};
use polishc::path::Link;
use polishc::tool::{Azimuth, Ball};
use polishc::units::si::{Angle, AngularSpeed, Length, Mass, Speed};
use std::f64::consts::PI;

const REQUEST: Request = Request {
    standoff: 1.5e-3,
    azimuth: 0.5,
    tool_ball: Ball { radius: 0.1, below: 0.0 },
    part: [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]],
    acceleration: 1.0,
    purpose: Purpose::Polish,
    room: Room::points(100_000),
    speed_steps: SpeedSteps::Fixed(1e-6),
};

fn planned(timed: TimedPath, robot: &job::Robot, request: &Request) -> Checked<Motion> {
    plan(timed, robot, request).unwrap_or_else(|problem| panic!("refused: {problem:?}"))
}

fn refused(timed: TimedPath, robot: &job::Robot, request: &Request) -> Problem {
    match plan(timed, robot, request) {
        Ok(_) => panic!("planned"),
        Err(problem) => problem,
    }
}

fn cell(robot: &mut job::Robot) -> &mut RobotCell {
    robot.cell.as_mut().expect("the test's robot has a cell")
}

/// A flat part under a tool that hangs straight from the flange, all frames parallel: the part's origin at (x, y, z) mm
/// in the base.
fn straight_above(x: f64, y: f64, z: f64) -> job::Robot {
    let parallel = |x, y, z| Frame { at: point(x, y, z), rotation: Rotation::no_rotation(job::Empty {}) };
    let mut robot = irb_6700_in_cell();
    let cell = cell(&mut robot);
    (cell.base, cell.user, cell.object) = (parallel(0.0, 0.0, 0.0), parallel(x, y, z), parallel(0.0, 0.0, 0.0));
    cell.tcp.at = point(0.0, 0.0, 300.0);
    cell.tcp.rotation = Rotation::no_rotation(job::Empty {});
    robot
}

fn assert_quaternion(found: [f64; 4], wanted: [f64; 4]) {
    assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} {wanted:?}");
}

/// Flat, from above: z = (0, 0, -1). Azimuth 0: x = (1, 0, 0), so y = z cross x = (0, -1, 0): half a turn about x.
/// Azimuth 90 degrees: x = (0, 1, 0), y = (1, 0, 0): half a turn about the diagonal (1, 1, 0). Azimuth a: half a turn
/// about (cos a/2, sin a/2, 0).
#[test]
fn contact_frames_of_a_flat_part() {
    let up = [0.0, 0.0, 1.0];
    let stands = |degrees: f64| wxyz(&orientation(up, Azimuth::new(degrees.to_radians())).expect("across"));
    assert_eq!(stands(0.0), [0.0, 1.0, 0.0, 0.0]);
    assert_quaternion(stands(90.0), [0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0]);
    assert_quaternion(stands(30.0), [0.0, 15_f64.to_radians().cos(), 15_f64.to_radians().sin(), 0.0]);
}

/// A slope of 30 degrees falling towards +x, azimuth 0: normal (1/2, 0, √3/2), so z = (-1/2, 0, -√3/2), x lies
/// downhill: (√3/2, 0, -1/2).
#[test]
fn contact_frame_on_a_slope() {
    let (half, root) = (0.5, 0.75_f64.sqrt());
    let m = matrix(&orientation([half, 0.0, root], Azimuth::new(0.0)).expect("across"));
    let wanted = [[root, 0.0, -half], [0.0, -1.0, 0.0], [-half, 0.0, -root]];
    for i in 0..3 {
        for j in 0..3 {
            assert!((m[i][j] - wanted[i][j]).abs() < 1e-12, "{m:?}");
        }
    }
    // The normal 5 degrees from the azimuth's direction: refused with the sine of it.
    let (sine, cosine) = 5_f64.to_radians().sin_cos();
    let near = orientation([cosine, 0.0, sine], Azimuth::new(0.0)).expect_err("too near");
    assert!((near - sine).abs() < 1e-12);
}

/// A quarter turn about z halves to an eighth, whichever of its two quaternions is given; the position halves too. A
/// third of a turn from 0 to 0.3 rad about x is 0.1 rad.
#[test]
fn between_two_poses_the_turn_is_even() {
    let pose = |x: f64, q: [f64; 4]| {
        let rotation = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]));
        Transform::from_parts(Translation3::new(x, 0.0, 0.0), rotation)
    };
    let root = 0.5_f64.sqrt();
    let from = pose(0.0, [1.0, 0.0, 0.0, 0.0]);
    for sign in [1.0, -1.0] {
        let to = pose(0.2, [sign * root, 0.0, 0.0, sign * root]);
        assert!((turn(&from.rotation, &to.rotation) - PI / 2.0).abs() < 1e-15);
        let half = between(&from, &to, 0.5);
        assert!((half.translation.x - 0.1).abs() < 1e-15);
        assert_quaternion(wxyz(&half.rotation), [(PI / 8.0).cos(), 0.0, 0.0, (PI / 8.0).sin()]);
    }
    let third = between(&from, &pose(0.0, [0.15_f64.cos(), 0.15_f64.sin(), 0.0, 0.0]), 1.0 / 3.0);
    assert_quaternion(wxyz(&third.rotation), [0.05_f64.cos(), 0.05_f64.sin(), 0.0, 0.0]);
}

/// world_base * FK(joints) * tool = world_user * user_object * pose at every point, and the tool centre point stands
/// `standoff` over the contact point, its z axis against the normal, its x axis along the azimuth.
#[test]
fn joints_put_the_tool_on_the_part_through_all_frames() {
    let robot = irb_6700_in_cell();
    let timed = raster(7, 41, 5e-3, 20e-3, 0.02, Link::OnSurface);
    let motion = planned(timed.clone(), &robot, &REQUEST);
    let arm = Arm::new(&robot).expect("an arm");
    for i in 0..motion.joints.len() {
        let chain = &motion.frames;
        let tool = chain.world_base * arm.forward(&motion.joints[i]) * chain.flange_tool;
        let in_object = (chain.world_user * chain.user_object).inverse() * tool;
        let contact = Vector3::from(timed.path.points.position(i));
        let off = in_object.translation.vector - contact - Vector3::new(0.0, 0.0, 1.5e-3);
        assert!(off.norm() < 1e-9, "{off}");
        let z = in_object.rotation * Vector3::z();
        let x = in_object.rotation * Vector3::x();
        assert!(
            (z + Vector3::z()).norm() < 1e-9 && (x - Vector3::new(0.5_f64.cos(), 0.5_f64.sin(), 0.0)).norm() < 1e-9
        );
        assert!(arm.within(&motion.joints[i], robot.range_margin.0));
        let (branch, _) = arm.posture(&motion.joints[i]);
        assert_eq!(branch, motion.runs[0].branch);
    }
    for quaternions in motion.quaternion.windows(2) {
        let dot: f64 = quaternions[0].iter().zip(quaternions[1]).map(|(a, b)| a * b).sum();
        assert!(dot >= 0.0);
    }
}

/// A controller that drives to the nearest solution from the approach joints stands at the planned joints everywhere;
/// more points than one parallel task solves, so the seams between tasks are among them.
#[test]
fn the_nearest_solution_follows_the_plan() {
    let robot = irb_6700_in_cell();
    let motion = planned(raster(21, 201, 2e-3, 15e-3, 0.02, Link::OnSurface), &robot, &REQUEST);
    let arm = Arm::new(&robot).expect("an arm");
    let replayed = replayed(&motion, &arm);
    let mut largest = 0.0_f64;
    for i in 0..motion.joints.len() {
        assert!(replayed[i].iter().zip(&motion.joints[i]).all(|(a, b)| (a - b).abs() < 1e-9), "point {i}");
        if i % 201 != 0 {
            let before = &replayed[i - 1];
            largest = replayed[i].iter().zip(before).fold(largest, |most, (a, b)| most.max((a - b).abs()));
        }
    }
    assert!((motion.figures.largest_joint_step - largest).abs() < 1e-9);
}

/// The nearest solutions of the tool poses, one after the other from the first approach.
fn replayed(motion: &Motion, arm: &Arm) -> Vec<[f64; 6]> {
    let mut joints = motion.runs[0].approach_joints;
    let poses = motion.position.iter().zip(&motion.quaternion);
    poses
        .map(|([x, y, z], [w, i, j, k])| {
            let rotation = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(*w, *i, *j, *k));
            let pose = Transform::from_parts(Translation3::new(*x, *y, *z), rotation);
            joints = arm.nearest_solution(&motion.frames.flange(&pose), &joints).expect("reachable").joints;
            joints
        })
        .collect()
}

/// Once around a ball that faces the robot, the tool leaning 15 degrees all the way: axis 4 makes a whole turn, counted
/// across the seams between parallel tasks (1024 points).
#[test]
fn whole_turns_go_on_along_a_run() {
    let mut robot = straight_above(0.0, 0.0, 0.0);
    cell(&mut robot).home = [5.0, 0.0, 0.0, -150.0, 20.0, 150.0].map(|a: f64| Angle(a.to_radians())).to_vec();
    let mut timed = raster(1, 2500, 1e-3, 1.0, 0.02, Link::OnSurface);
    let points = &mut timed.path.points;
    let (radius, lean) = (0.2, 15_f64.to_radians());
    for i in 0..2500 {
        // Not quite closed.
        let (sine, cosine) = (i as f64 / 2500.0 * 2.0 * PI).sin_cos();
        let normal = [-lean.cos(), lean.sin() * cosine, lean.sin() * sine];
        (points.normal_x[i], points.normal_y[i], points.normal_z[i]) = normal.into();
        let centre = [1.4625 + 0.2 + 0.3 + radius, 0.0, 2.105];
        (points.x[i], points.y[i], points.z[i]) = [0, 1, 2].map(|k| centre[k] + radius * normal[k]).into();
    }
    let request = Request { azimuth: 90_f64.to_radians(), tool_ball: Ball { radius: 0.0, below: 0.0 }, ..REQUEST };
    let motion = planned(timed, &robot, &request);
    let arm = Arm::new(&robot).expect("an arm");
    let fourth = motion.joints.iter().map(|joints| joints[3].to_degrees());
    let (least, most) = fourth.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
    assert!(most - least > 355.0, "{least} {most}");
    assert!(arm.least_margin(&motion.joints[0]).0 >= robot.range_margin.0);
    for (replayed, joints) in replayed(&motion, &arm).iter().zip(&motion.joints) {
        assert!(replayed.iter().zip(joints).all(|(a, b)| (a - b).abs() < 1e-9), "{replayed:?} {joints:?}");
    }
}

/// On a dome the tool leans to all sides, around half a turn from the part's frame, where a quaternion's canonical sign
/// changes: the written ones stay on one side. The tool stands along each normal.
#[test]
fn quaternions_stay_on_one_side_over_a_dome() {
    let mut timed = raster(9, 41, 5e-3, 25e-3, 0.02, Link::OnSurface);
    let points = &mut timed.path.points;
    for i in 0..points.x.len() {
        // z = -(x² + y²) / 2 m.
        let (x, y) = (points.x[i], points.y[i]);
        let length = (1.0 + x * x + y * y).sqrt();
        points.z[i] = -(x * x + y * y) / 2.0;
        (points.normal_x[i], points.normal_y[i], points.normal_z[i]) = (x / length, y / length, 1.0 / length);
    }
    let motion = planned(timed.clone(), &irb_6700_in_cell(), &REQUEST);
    let signs: Vec<f64> = motion.quaternion.iter().map(|q| q[0]).collect();
    assert!(signs.iter().any(|w| *w > 1e-3) && signs.iter().any(|w| *w < -1e-3), "w changes its sign on the way");
    for pair in motion.quaternion.windows(2) {
        let dot: f64 = pair[0].iter().zip(pair[1]).map(|(a, b)| a * b).sum();
        assert!(dot > 0.9);
    }
    for i in 0..motion.position.len() {
        let (normal, contact) = (timed.path.points.normal(i), timed.path.points.position(i));
        let [w, a, b, c] = motion.quaternion[i];
        let rotation = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, a, b, c));
        assert!((rotation * Vector3::z() + Vector3::from(normal)).norm() < 1e-12);
        let off = Vector3::from(motion.position[i]) - Vector3::from(contact) - Vector3::from(normal) * 1.5e-3;
        assert!(off.norm() < 1e-12);
    }
}

#[test]
fn any_number_of_threads_plans_the_same() {
    let robot = irb_6700_in_cell();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let timed = raster(31, 201, 2e-3, 10e-3, 0.02, Link::OnSurface);
        pool.install(|| planned(timed, &robot, &Request { room: Room::points(2100), ..REQUEST }))
    };
    let one = with(1);
    for threads in [2, 8] {
        let other = with(threads);
        assert_eq!(one.joints, other.joints);
        assert_eq!((&one.runs, &one.confdata, &one.quaternion), (&other.runs, &other.confdata, &other.quaternion));
        assert_eq!(one.figures, other.figures);
    }
}

/// 10 lines of 41 points with room for 100: runs of 2 lines. The first is reached from home, the others straight on, in
/// the same configuration and without a jump.
#[test]
fn runs_are_whole_lines_and_go_on_lifted() {
    let motion = planned(
        raster(10, 41, 5e-3, 20e-3, 0.02, Link::OnSurface),
        &irb_6700_in_cell(),
        &Request { room: Room::points(100), ..REQUEST },
    );
    let lines: Vec<_> = motion.runs.iter().map(|run| run.lines.clone()).collect();
    assert_eq!(lines, [0..2, 2..4, 4..6, 6..8, 8..10]);
    for (i, run) in motion.runs.iter().enumerate() {
        assert_eq!(run.points, i * 82..(i + 1) * 82);
        assert_eq!(run.travel, if i == 0 { Travel::Joint } else { Travel::Straight });
        assert_eq!(run.branch, motion.runs[0].branch);
        // 50 mm above the first and the last tool pose.
        let above = |i: usize| [motion.position[i][0], motion.position[i][1], motion.position[i][2] + 0.05];
        assert_eq!(run.approach.position, above(run.points.start));
        assert_eq!(run.retract.position, above(run.points.end - 1));
        assert_eq!(run.approach.quaternion, motion.quaternion[run.points.start]);
    }
    for pair in motion.runs.windows(2) {
        // 20 mm sideways: no joint goes far.
        let change = pair[0].retract_joints.iter().zip(pair[1].approach_joints).map(|(a, b)| (a - b).abs());
        assert!(change.fold(0.0, f64::max) < 0.05);
    }
}

#[test]
fn every_lifted_line_is_a_run() {
    let timed = raster(4, 21, 5e-3, 20e-3, 0.02, Link::Lifted);
    let motion = planned(timed, &irb_6700_in_cell(), &REQUEST);
    let runs: Vec<_> = motion.runs.iter().map(|run| (run.points.clone(), run.travel)).collect();
    assert_eq!(
        runs,
        [(0..21, Travel::Joint), (21..42, Travel::Straight), (42..63, Travel::Straight), (63..84, Travel::Straight)]
    );
}

/// A dry run stands higher by the travel height and is no faster than travel, in whole steps of the target.
#[test]
fn a_dry_run_is_lifted_and_slow() {
    let mut robot = irb_6700_in_cell();
    cell(&mut robot).travel.speed = Speed(0.0123456789);
    let timed = raster(2, 21, 5e-3, 20e-3, 0.02, Link::OnSurface);
    let dry = Request { purpose: Purpose::DryRun, speed_steps: SpeedSteps::Fixed(1e-4), ..REQUEST };
    let motion = planned(timed, &robot, &dry);
    assert!(motion.position.iter().all(|p| (p[2] - 0.0515).abs() < 1e-12));
    assert!(motion.timed.speed.iter().all(|v| (v - 0.0123).abs() < 1e-12));
    assert!((motion.runs[0].approach.position[2] - 0.1015).abs() < 1e-12);
    let problem = refused(
        raster(2, 21, 5e-3, 20e-3, 0.02, Link::OnSurface),
        &robot,
        &Request { purpose: Purpose::DryRun, speed_steps: SpeedSteps::Fixed(0.02), ..REQUEST },
    );
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0803, Some("robot.cell.travel.speed")));
}

/// One line of 0.2 m at 0.1 m/s with 1 m/s²: 2 s and 0.1 s of ramps. Down 50 mm and up again at the travel speed of 0.05
/// m/s: 1 s and 0.05 s each. Joint moves at a tenth of the rated speeds.
#[test]
fn time_is_the_sum_of_the_moves() {
    let robot = irb_6700_in_cell();
    let motion = planned(raster(1, 3, 0.1, 1.0, 0.1, Link::OnSurface), &robot, &REQUEST);
    let joint_move = |joints: &[f64; 6]| {
        let seconds = (0..6).map(|i| (joints[i] - motion.home[i]).abs() / (0.1 * IRB_6700.speeds[i].to_radians()));
        seconds.fold(0.0, f64::max)
    };
    // Only the way down is cut to the travel speed.
    assert!(motion.timed.speed.iter().zip([0.05, 0.1, 0.1]).all(|(found, wanted)| (found - wanted).abs() < 1e-12));
    let run = &motion.runs[0];
    let wanted = joint_move(&run.approach_joints) + 1.05 + 2.1 + 1.05 + joint_move(&run.retract_joints);
    assert!((motion.figures.time - wanted).abs() < 1e-9, "{} {wanted}", motion.figures.time);
}

/// The figures, counted again from the joints. The margins may be less by what the samples between the points and the
/// way up and down add, tens of microradians; the part of the joint speeds is that of one of the steps.
#[test]
fn figures_are_those_of_the_joints() {
    let robot = straight_above(1600.0, 0.0, 500.0);
    let motion = planned(raster(9, 41, 5e-3, 30e-3, 0.2, Link::OnSurface), &robot, &REQUEST);
    let ends = [motion.runs[0].approach_joints, motion.runs[0].retract_joints];
    let all = || motion.joints.iter().chain(&ends);
    let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
    let margin = least(&mut all().map(|joints| {
        let ends = (0..6)
            .map(|i| (joints[i].to_degrees() - IRB_6700.lower[i]).min(IRB_6700.upper[i] - joints[i].to_degrees()));
        ends.fold(f64::INFINITY, f64::min).to_radians()
    }));
    let found = &motion.figures;
    assert!(found.joint_margin <= margin + 1e-12 && found.joint_margin > margin - 1e-4, "{found:?} {margin}");
    // Axis 5 of this arm is straight at 0, and here it stays below 90 deg.
    let wrist = least(&mut all().map(|joints| joints[4].abs()));
    assert!(found.wrist_margin <= wrist + 1e-12 && found.wrist_margin > wrist - 1e-4, "{found:?} {wrist}");
    let mut share = 0.0_f64;
    for i in 1..motion.joints.len() {
        let length = (Vector3::from(motion.position[i]) - Vector3::from(motion.position[i - 1])).norm();
        for joint in 0..6 {
            let speed = (motion.joints[i][joint] - motion.joints[i - 1][joint]).abs() / length * 0.2;
            share = share.max(speed / IRB_6700.speeds[joint].to_radians());
        }
    }
    // Half steps are faster than whole ones by their curvature, some thousandths here.
    assert!(found.joint_speed_share >= share && found.joint_speed_share < share * 1.01, "{found:?} {share}");
    // The line over y = 0 keeps joint 1 at 0; other points near a quarter turn of axes 1, 4, 6 are counted by their
    // degrees.
    let near = motion.joints.iter().filter(|joints| {
        [joints[0], joints[3], joints[5]].iter().any(|angle| {
            let beyond = angle.to_degrees().rem_euclid(90.0);
            beyond.min(90.0 - beyond) < 0.1
        })
    });
    let near = near.count();
    assert!(near >= 41);
    assert_eq!(found.points_near_quarter, near);
}

/// Tool straight down over x = 2100 mm + x: the wrist centre stands 300 + 200 mm above the tool centre point, at height
/// 80 + 1.5 + 500 mm, 198.5 mm below axis 2 (780 mm), and at a distance of 2100 + x - 320 mm from it. The arm
/// does 1125 + hypot(200, 1142.5) = 2284.9 mm, reached at x = 496.2 mm along the line from -600 to 600 mm; elbow margin 0 and a
/// wide range of joint 2, so that nothing else stops it before.
#[test]
fn out_of_reach_names_the_place() {
    let mut robot = straight_above(2100.0, 0.0, 80.0);
    robot.elbow_margin = 0.0;
    robot.joints[1].range.to = Angle(130_f64.to_radians());
    cell(&mut robot).travel.height = Length(0.01);
    let problem = refused(raster(1, 7, 0.2, 1.0, 0.02, Link::OnSurface), &robot, &REQUEST);
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0806, Some("robot.cell.object")), "{problem:?}");
    let arm_length = 1125.0 + 200_f64.hypot(1142.5);
    let limit = (arm_length * arm_length - 198.5 * 198.5_f64).sqrt() + 320.0 - 2100.0;
    let x: f64 = number_after(&problem.message, "cannot reach x ");
    // The first sample after it; samples are at most 5 mm apart.
    assert!(x > limit && x <= limit + 5.0, "{limit} {}", problem.message);
    assert!(problem.message.contains("y 0.000 mm, z 0.000 mm (line 1)"), "{}", problem.message);
    assert!(problem.message.contains("the arm does 34.9 mm to 2284.9 mm"), "{}", problem.message);
}

fn number_after(text: &str, words: &str) -> f64 {
    let rest = &text[text.find(words).unwrap_or_else(|| panic!("no `{words}` in `{text}`")) + words.len()..];
    let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-')).unwrap_or(rest.len());
    rest[..end].parse().unwrap_or_else(|_| panic!("no number after `{words}` in `{text}`"))
}

/// Joint 1 stands at atan2(y, 1600 + x), y and x in the base: the three lines lie at y = 0, 70 and 140 mm there, at
/// -70, 0 and 70 mm on the part. With a range of ±6 deg and a margin of 1 deg, the way to the third line, at x = -100
/// mm, leaves 5 deg at y = 1500 mm tan 5 deg = 131.2 mm. On the first two lines joint 1 stays below 70 / 1500, 2.7 deg.
#[test]
fn a_joint_out_of_range_names_place_angle_and_range() {
    let mut robot = straight_above(1600.0, 70.0, 500.0);
    robot.joints[0].range.from = Angle(-6_f64.to_radians());
    robot.joints[0].range.to = Angle(6_f64.to_radians());
    robot.range_margin = Angle(1_f64.to_radians());
    let problem = refused(raster(3, 41, 5e-3, 70e-3, 0.02, Link::OnSurface), &robot, &REQUEST);
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0807, Some("robot.joints.0.range")), "{problem:?}");
    let y = number_after(&problem.message, ", y ");
    let limit = 5_f64.to_radians().tan() * 1500.0 - 70.0;
    assert!(y > limit && y <= limit + 5.0, "{limit} {}", problem.message);
    assert!(problem.message.starts_with("joint 1 would stand at 5."), "{}", problem.message);
    assert!(problem.message.contains("(on the way to line 3)"), "{}", problem.message);
    assert!(problem.message.contains("-6.000 deg .. 6.000 deg with a margin of 1.000 deg"), "{}", problem.message);
}

/// A wall facing the robot (normal -x): the tool is level, its flange 300 mm before the wall. With joint 2 at 0 and
/// joint 3 at 0 the upper arm is level and the wrist centre at (1462.5, 0, 2105) mm. One segment, from y = -300 mm to
/// 300 mm: the wrist is bent by joint 1, atan(y / 1462.5), at both ends, and straight in the middle.
fn across_a_straight_wrist() -> (TimedPath, job::Robot, Request) {
    let mut robot = straight_above(0.0, 0.0, 0.0);
    cell(&mut robot).home = [10.0, 0.0, 0.0, 90.0, 15.0, -90.0].map(|a: f64| Angle(a.to_radians())).to_vec();
    let mut timed = raster(1, 2, 0.6, 1.0, 0.02, Link::OnSurface);
    let points = &mut timed.path.points;
    for i in 0..2 {
        (points.y[i], points.x[i], points.z[i]) = (points.x[i], 1.4625 + 0.2 + 0.3 + 1.5e-3, 2.105);
        (points.normal_x[i], points.normal_z[i]) = (-1.0, 0.0);
    }
    (timed, robot, Request { azimuth: 90_f64.to_radians(), tool_ball: Ball { radius: 0.0, below: 0.0 }, ..REQUEST })
}

/// 5 degrees at y = -128 mm, coming from -300 mm.
#[test]
fn a_singularity_between_points_is_found() {
    let (timed, robot, request) = across_a_straight_wrist();
    let problem = refused(timed, &robot, &request);
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0808, Some("robot.wrist_margin")), "{problem:?}");
    let y = number_after(&problem.message, ", y ");
    // The arm's tilt, some tenths of a degree there, makes it a little less than the flat calculation.
    assert!((-128.0..=-118.0).contains(&y), "{}", problem.message);
}

/// With hardly a margin the wrist passes its straight position between two samples: joint 4 turns by half a turn there.
#[test]
fn a_jump_through_a_singularity_is_found() {
    let (mut timed, mut robot, request) = across_a_straight_wrist();
    // So that no sample falls on y = 0 itself.
    timed.path.points.y[0] = -0.301;
    robot.wrist_margin = Angle(1e-9);
    let problem = refused(timed, &robot, &request);
    assert_eq!(problem.code.as_str(), "E0810", "{problem:?}");
    let y = number_after(&problem.message, ", y ");
    assert!(y.abs() < 5.0, "{}", problem.message);
}

#[test]
fn each_singularity_has_its_margin() {
    let timed = || raster(1, 11, 10e-3, 1.0, 0.02, Link::OnSurface);
    // Straight over x = 1600 mm: the wrist centre is 1600 mm from axis 1 and no further than that.
    let mut robot = straight_above(1600.0, 0.0, 500.0);
    robot.shoulder_margin = Length(1.6);
    let problem = refused(timed(), &robot, &REQUEST);
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0808, Some("robot.shoulder_margin")));
    assert!(
        problem.message.starts_with("the wrist centre would be 1550.0 mm from axis 1 at x -50.000 mm"),
        "{problem:?}"
    );
    // No elbow angle has a sine above 1.
    let mut robot = straight_above(1600.0, 0.0, 500.0);
    robot.elbow_margin = 1.0;
    let problem = refused(timed(), &robot, &REQUEST);
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0808, Some("robot.elbow_margin")));
}

/// Along a line in x at y = 300 mm, joint 1 turns at v y / (X² + y²): at X = 1500 mm and v = 0.5 m/s 3.672 deg/s, first
/// on the line, where it is most.
#[test]
fn too_fast_a_joint_says_the_speed_that_passes() {
    let mut robot = straight_above(1600.0, 300.0, 500.0);
    robot.joints[0].speed = AngularSpeed(3_f64.to_radians());
    cell(&mut robot).joint_move_speed = 1.0;
    // Up and down do not turn joint 1.
    let problem = refused(raster(1, 41, 5e-3, 1.0, 0.5, Link::OnSurface), &robot, &REQUEST);
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0809, Some("dwell.feed")), "{problem:?}");
    let needed = number_after(&problem.message, "joint 1 would turn at ");
    let wanted = (0.5 * 0.3 / (1.5_f64 * 1.5 + 0.3 * 0.3)).to_degrees();
    // Two written decimals, and the sample's 2.5 mm along the line.
    assert!((needed - wanted).abs() < 0.02, "{wanted} {}", problem.message);
    let help = problem.help.expect("the mend");
    let passes = number_after(&help, "a speed of ");
    assert!((passes - 500.0 * 3.0 / wanted).abs() < 3.0, "{help}");
    // At that speed, less the little that the worst place of the line is worse, it passes.
    planned(raster(1, 41, 5e-3, 1.0, passes * 1e-3 * 0.99, Link::OnSurface), &robot, &REQUEST);
}

/// The start nearest to home would run joint 6 out of its range on the way; the same posture a turn away does not, and
/// is taken.
#[test]
fn whole_turns_are_chosen_for_the_whole_run() {
    let mut robot = straight_above(1600.0, 0.0, 500.0);
    // The other wrist, which would be nearer than a whole turn, is kept out.
    robot.joints[4].range.from = Angle(0.0);
    let path = || raster(9, 41, 5e-3, 50e-3, 0.02, Link::OnSurface);
    let free = planned(path(), &robot, &REQUEST);
    let start = free.runs[0].approach_joints[5];
    let most = free.joints.iter().map(|joints| joints[5]).fold(f64::NEG_INFINITY, f64::max);
    assert!(most > start + 0.05, "joint 6 turns on along the run");
    let margin = robot.range_margin.0;
    robot.joints[5].range.to = Angle((start + most) / 2.0 + margin);
    robot.joints[5].range.from = Angle(start - 7.5);
    let home = &mut cell(&mut robot).home;
    home[5] = Angle(start - 0.1);
    let turned = planned(path(), &robot, &REQUEST);
    let full = std::f64::consts::TAU;
    assert!((turned.runs[0].approach_joints[5] - (start - full)).abs() < 1e-9);
    assert!(turned.joints.iter().zip(&free.joints).all(|(a, b)| (a[5] + full - b[5]).abs() < 1e-9));
    assert!(turned.figures.joint_margin >= margin);
}

/// Home with the tool centre point inside the part, 100 mm below the surface.
#[test]
fn a_joint_move_through_the_part_is_refused() {
    let mut robot = straight_above(1600.0, 0.0, 500.0);
    let arm = Arm::new(&robot).expect("an arm");
    let down = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(0.0, 1.0, 0.0, 0.0));
    let inside = Transform::from_parts(Translation3::new(1.6, 0.0, 0.4 + 0.3), down);
    let joints = arm.nearest_solution(&inside, &[0.0; 6]).expect("reachable").joints;
    cell(&mut robot).home = joints.map(Angle).to_vec();
    let timed = || raster(3, 41, 5e-3, 50e-3, 0.02, Link::OnSurface);
    let problem = refused(timed(), &robot, &REQUEST);
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0805, Some("robot.cell.home")), "{problem:?}");
    assert!(
        problem.message.contains("bring the tool into the part")
            && problem.message.contains("with its centre point at x 0.000 mm, y 0.000 mm, z -100.000 mm"),
        "{problem:?}"
    );
    // Beside the path and still in the part: 400 mm along y from a path that is 10 mm wide.
    let inside = Transform::from_parts(Translation3::new(1.6, 0.4, 0.4 + 0.3), down);
    let beside = arm.nearest_solution(&inside, &[0.0; 6]).expect("reachable").joints;
    let mut robot = straight_above(1600.0, 0.0, 500.0);
    cell(&mut robot).safe_poses = vec![beside.map(Angle).to_vec()];
    let part = [[-0.5; 2], [0.5; 2]];
    let problem = refused(timed(), &robot, &Request { part, ..REQUEST });
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0805, Some("robot.cell.safe_poses.0")));
    // With nothing there, the way is free.
    planned(timed(), &robot, &REQUEST);
    // The same as a safe pose.
    let mut robot = straight_above(1600.0, 0.0, 500.0);
    cell(&mut robot).safe_poses = vec![joints.map(Angle).to_vec()];
    let problem = refused(timed(), &robot, &REQUEST);
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0805, Some("robot.cell.safe_poses.0")));
}

#[test]
fn a_line_longer_than_a_module_is_refused() {
    let request = Request { room: Room::points(40), ..REQUEST };
    let problem = refused(raster(2, 41, 5e-3, 20e-3, 0.02, Link::OnSurface), &irb_6700_in_cell(), &request);
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0804, Some("path.point_step")));
}

#[test]
fn a_normal_along_the_azimuth_is_refused() {
    let mut timed = raster(1, 11, 5e-3, 20e-3, 0.02, Link::OnSurface);
    let (sine, cosine) = 3_f64.to_radians().sin_cos();
    (timed.path.points.normal_x[7], timed.path.points.normal_z[7]) = (cosine, sine);
    let problem = refused(timed, &irb_6700_in_cell(), &Request { azimuth: 0.0, ..REQUEST });
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0808, Some("tool.azimuth")));
    assert!(problem.message.starts_with("at x 10.000 mm, y 0.000 mm, z 0.000 mm (line 1)"), "{}", problem.message);
    assert!(problem.message.contains("is 3.00 deg from"), "{}", problem.message);
}

/// A change of the robot that must be refused: the code and the field of the refusal.
#[test]
fn wrong_numbers_of_the_robot_are_refused() {
    type Change = fn(&mut job::Robot);
    let changes: &[(Change, &str, &str)] = &[
        (|r| r.joints.truncate(5), "E0800", "robot.joints"),
        (|r| r.joints[2].range.from = Angle(2.0), "E0800", "robot.joints.2.range"),
        (|r| r.joints[3].range.to = Angle(f64::NAN), "E0800", "robot.joints.3.range"),
        (|r| r.joints[5].range.to = Angle(360.0), "E0800", "robot.joints.5.range"),
        (|r| r.joints[4].speed = AngularSpeed(0.0), "E0800", "robot.joints.4.speed"),
        (|r| ortho_parallel(r).signs[1] = 0.5, "E0800", "robot.arm.signs"),
        (|r| ortho_parallel(r).offsets.push(Angle(0.0)), "E0800", "robot.arm.offsets"),
        (|r| ortho_parallel(r).c2 = Length(0.0), "E0800", "robot.arm"),
        (|r| ortho_parallel(r).b = Length(f64::INFINITY), "E0800", "robot.arm.b"),
        (|r| cell(r).object.rotation = quaternion(1.0, 0.0, 0.0, 2e-2), "E0801", "robot.cell.object.rotation"),
        (|r| cell(r).tcp.rotation = quaternion(0.0, 0.0, 0.0, 0.0), "E0801", "robot.cell.tcp.rotation"),
        (|r| cell(r).user.at.x = Length(f64::NAN), "E0801", "robot.cell.user.at"),
        (|r| cell(r).tcp.load.mass = Mass(200.5), "E0802", "robot.cell.tcp.load.mass"),
        (|r| cell(r).tcp.load.mass = Mass(0.0), "E0802", "robot.cell.tcp.load.mass"),
        (|r| cell(r).tcp.load.centre = point(0.0, 0.0, 0.0), "E0802", "robot.cell.tcp.load.centre"),
        (|r| r.cell = None, "E0803", "robot.cell"),
        (|r| cell(r).home.truncate(3), "E0800", "robot.cell.home"),
        (|r| cell(r).home[1] = Angle(1.5), "E0803", "robot.cell.home"),
        (|r| cell(r).safe_poses.push(vec![Angle(f64::NAN); 6]), "E0803", "robot.cell.safe_poses.0"),
        (|r| cell(r).travel.height = Length(0.0), "E0803", "robot.cell.travel.height"),
        (|r| cell(r).travel.speed = Speed(-1.0), "E0803", "robot.cell.travel.speed"),
        (|r| cell(r).joint_move_speed = 1.5, "E0803", "robot.cell.joint_move_speed"),
        (|r| r.wrist_margin = Angle(-0.1), "E0803", "robot.wrist_margin"),
    ];
    for (change, code, field) in changes {
        let mut robot = irb_6700_in_cell();
        change(&mut robot);
        let problem = refused(raster(1, 5, 5e-3, 1.0, 0.02, Link::OnSurface), &robot, &REQUEST);
        assert_eq!((problem.code.as_str(), problem.field.as_deref()), (*code, Some(*field)), "{problem:?}");
    }
}

fn ortho_parallel(robot: &mut job::Robot) -> &mut job::OrthoParallel {
    let job::Arm::ortho_parallel(arm) = &mut robot.arm;
    arm
}

fn quaternion(w: f64, x: f64, y: f64, z: f64) -> Rotation {
    Rotation::quaternion(Quaternion { w, x, y, z })
}

/// Four decimals are accepted and normalised: 30 degrees about z, of length 0.99997.
#[test]
fn a_rounded_quaternion_is_normalised() {
    let mut robot = irb_6700_in_cell();
    cell(&mut robot).object.rotation = quaternion(0.9659, 0.0, 0.0, 0.2588);
    let chain = FrameChain::new(robot.cell.as_ref().expect("a cell")).expect("a rotation");
    let found = wxyz(&chain.user_object.rotation);
    let wanted = [15_f64.to_radians().cos(), 0.0, 0.0, 15_f64.to_radians().sin()];
    // The written digits, no more.
    assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}");
    let length: f64 = found.iter().map(|a| a * a).sum();
    assert!((length - 1.0).abs() < 1e-15);
}

#[test]
fn a_path_that_is_none_is_refused() {
    type Change = fn(&mut TimedPath);
    let changes: &[Change] = &[
        |t| *t = TimedPath::default(),
        |t| t.speed.truncate(3),
        |t| t.speed[2] = 0.0,
        |t| t.speed[2] = f64::NAN,
        |t| t.path.points.x[2] = t.path.points.x[1],
        |t| t.path.points.y[2] = f64::NAN,
        |t| t.path.points.y[2] = 1e300,
        |t| t.path.points.normal_z[2] = 0.9,
        |t| t.path.lines[1].points.start += 1,
        |t| t.path.lines.truncate(1),
    ];
    for (i, change) in changes.iter().enumerate() {
        let mut timed = raster(2, 5, 5e-3, 1e-2, 0.02, Link::OnSurface);
        change(&mut timed);
        let problem = refused(timed, &irb_6700_in_cell(), &REQUEST);
        assert_eq!(problem.code, codes::E0804, "change {i}: {problem:?}");
    }
    let timed = raster(2, 5, 5e-3, 1e-2, 0.02, Link::OnSurface);
    let problem = refused(timed, &irb_6700_in_cell(), &Request { acceleration: 0.0, ..REQUEST });
    assert_eq!((problem.code, problem.field.as_deref()), (codes::E0804, Some("dwell.acceleration")));
}
