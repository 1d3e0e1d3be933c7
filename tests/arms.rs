//! The arms of the library, as a job gets them: by numbers of their sources, by somebody else's solver, by their reach.
//!
//! Expected flange poses: tests/golden/robots.json has them from a chain of URDF frames (the same numbers for all four
//! arms); the few here are sums of lengths. KUKA's a2 changes its sign between the two KR 210: +41 and -115 mm.
#![allow(clippy::disallowed_methods, reason = "tests use the platform's mathematics and files")]

use polishc::job::{self, Robot};
use polishc::motion::{Arm, Transform};
use polishc::session::{self, Request, Until, Unwatched};
use polishc::source::MemoryFiles;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use rs_opw_kinematics::glam::{DQuat, DVec3};
use rs_opw_kinematics::kinematic_traits::{Kinematics, Pose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use serde_json::Value;
use std::f64::consts::TAU;

const JOB: &str = r#"language 1
@use@
use std.materials.fused_silica

job arm {
    workpiece {
        part: "A", form: plane, edge: circle { diameter: 60 mm }, clear: circle { diameter: 50 mm }
        material: fused_silica
        error: height_map {
            file: "map.npy", quantity: surface, positive: high, view: from_tool_side, up: plus_y, subtract: []
            pixel: 1 mm, unit: 1 nm
        }
    }
    tool: mrf_wheel {
        diameter: 100 mm, speed: 200 rpm, rotation: forward, gap: 1 mm, azimuth: 0 deg
        influence: gaussian { peak: 20 nm/s, sigma: 4 mm, diameter: 20 mm }
    }
    path:  raster { over: circle { diameter: 90 mm }, point_step: 1 mm, line_pitch: 1 mm, lines: serpentine }
    dwell: corrective {
        removal_fraction: 90 %, piston: free {}, feed: 0.2 mm/s .. 60 mm/s, acceleration: 500 mm/s^2
    }
    robot: @robot@
}
"#;

/// The robot of a job that says `robot: <name>`.
fn robot(module: &str, name: &str) -> Robot {
    let text = JOB.replace("@use@", &format!("use std.robots.{module}")).replace("@robot@", name);
    let files = MemoryFiles([("a/a.polish".to_string(), text.into_bytes())].into_iter().collect());
    let request = Request { until: Until::Types, ..Request::new("a/a.polish") };
    let done = session::compile(&files, &request, &Unwatched);
    assert!(!done.failed(), "{:?}", done.diagnostics);
    done.jobs[0].job.robot.clone().expect("a robot")
}

/// `use` of an arm, its value, its name in tests/golden/robots.json.
const ARMS: [(&str, &str, &str); 4] = [
    ("abb.irb6700_200_260", "irb6700_200_260", "IRB 6700-200/2.60"),
    ("abb.irb6620_150_220", "irb6620_150_220", "IRB 6620-150/2.2"),
    ("kuka.kr210_r2700_extra", "kr210_r2700_extra", "KR 210 R2700 extra"),
    ("kuka.kr210_r2700_2", "kr210_r2700_2", "KR 210 R2700-2"),
];

fn all() -> Vec<Robot> {
    ARMS.iter().map(|(module, name, _)| robot(module, name)).collect()
}

fn geometry(robot: &Robot) -> &job::OrthoParallel {
    let job::Arm::ortho_parallel(arm) = &robot.arm;
    arm
}

/// Lengths, offsets, signs, ranges and speeds against the file that the golden poses were made from.
#[test]
fn numbers_are_those_of_the_golden_poses() {
    let text = std::fs::read_to_string("tests/golden/robots.json").expect("golden");
    let document: Value = serde_json::from_str(&text).expect("JSON");
    for (robot, (_, _, name)) in all().iter().zip(ARMS) {
        assert_eq!(format!("{}", robot.model), name);
        let golden = document["robots"].as_array().expect("robots").iter().find(|r| r["name"] == name).expect(name);
        let arm = geometry(robot);
        let lengths = [("a1", arm.a1), ("a2", arm.a2), ("b", arm.b), ("c1", arm.c1), ("c2", arm.c2), ("c3", arm.c3)];
        for (key, found) in lengths.into_iter().chain([("c4", arm.c4)]) {
            let wanted = golden[key].as_f64().expect(key);
            assert!((found.0 * 1e3 - wanted).abs() < 1e-9, "{name} {key}: {} {wanted}", found.0 * 1e3);
        }
        let six = |key: &str| -> Vec<f64> {
            golden[key].as_array().expect(key).iter().map(|v| v.as_f64().expect("a number")).collect()
        };
        let near = |found: f64, wanted: f64| (found.to_degrees() - wanted).abs() < 1e-9;
        for i in 0..6 {
            let joint = &robot.joints[i];
            assert!(near(arm.offsets[i].0, six("offsets_deg")[i]) && arm.signs[i] == six("signs")[i], "{name} {i}");
            assert!(near(joint.range.from.0, six("lower_deg")[i]), "{name} {i}");
            assert!(near(joint.range.to.0, six("upper_deg")[i]), "{name} {i}");
            assert!(near(joint.speed.0, six("vmax_deg_s")[i]), "{name} {i}");
        }
        // No source gives the wrist's inertia, so none is stated.
        assert!(robot.wrist_inertia.is_none());
    }
}

/// In the upright pose with the forearm level the flange lies a1 + c3 + c4 ahead and c1 + c2 + a2 up (a2 points down the
/// wrist of such an arm where it is negative), its z axis ahead: mm by adding lengths.
#[test]
fn poses_by_adding_lengths() {
    let deg = std::f64::consts::PI / 180.0;
    for (robot, joints, x, z) in [
        (&all()[0], [0.0; 6], 320.0 + 1142.5 + 200.0, 780.0 + 1125.0 + 200.0),
        (&all()[1], [0.0; 6], 320.0 + 887.0 + 200.0, 680.0 + 975.0 + 200.0),
        (&all()[2], [0.0, -90.0, 90.0, 0.0, 0.0, 0.0], 350.0 + 1200.0 + 215.0, 675.0 + 1150.0 - 41.0),
        (&all()[3], [0.0, -90.0, 90.0, 0.0, 0.0, 0.0], 330.0 + 1220.0 + 215.0, 645.0 + 1150.0 + 115.0),
    ] {
        let arm = Arm::new(robot).expect("an arm");
        let (position, axes) = arm.forward_matrix(&joints.map(|angle| angle * deg));
        let [fx, fy, fz] = position.map(|v| v * 1e3);
        assert!((fx - x).abs() < 1e-9 && fy.abs() < 1e-9 && (fz - z).abs() < 1e-9, "{}: {fx} {fy} {fz}", robot.model);
        assert!((axes[0][2] - 1.0).abs() < 1e-12, "{}", robot.model);
    }
}

/// The farthest that the wrist centre gets sideways with axis 2 inside its range, against the published reach, which is
/// rounded to whole millimetres (KUKA) or centimetres (ABB): mm.
#[test]
fn reach_is_the_published_one() {
    for (robot, published, rounding) in
        [(&all()[0], 2600.0, 5.0), (&all()[1], 2200.0, 5.0), (&all()[2], 2696.0, 0.5), (&all()[3], 2701.0, 0.5)]
    {
        let arm = geometry(robot);
        let (a1, a2, c2, c3) = (arm.a1.0 * 1e3, arm.a2.0 * 1e3, arm.c2.0 * 1e3, arm.c3.0 * 1e3);
        let range = &robot.joints[1].range;
        let mut most = 0.0_f64;
        for k in 0..=20_000 {
            let maker = range.from.0 + (range.to.0 - range.from.0) * f64::from(k) / 20_000.0;
            let lean = arm.signs[1] * maker - arm.offsets[1].0;
            // The upper arm stretched level, from the elbow to the wrist centre.
            most = most.max(a1 + c2 * lean.sin() + a2.hypot(c3));
        }
        assert!((most - published).abs() <= rounding, "{}: {most} mm, published {published} mm", robot.model);
    }
}

fn oracle(robot: &Robot) -> OPWKinematics {
    let arm = geometry(robot);
    let six = |values: Vec<f64>| -> [f64; 6] { values.try_into().expect("six") };
    OPWKinematics::new(Parameters {
        a1: arm.a1.0,
        a2: arm.a2.0,
        b: arm.b.0,
        c1: arm.c1.0,
        c2: arm.c2.0,
        c3: arm.c3.0,
        c4: arm.c4.0,
        offsets: six(arm.offsets.iter().map(|offset| offset.0).collect()),
        sign_corrections: std::array::from_fn(|i| arm.signs[i] as i8),
        dof: 6,
    })
}

/// Over the ranges of every arm: their forward kinematics give our pose, and each of their solutions is among ours, in
/// every whole turn that the ranges hold.
#[test]
fn another_solver_agrees_over_the_ranges() {
    for robot in all() {
        let (arm, theirs) = (Arm::new(&robot).expect("an arm"), oracle(&robot));
        let mut runner =
            TestRunner::new(ProptestConfig { cases: 2000, failure_persistence: None, ..Default::default() });
        let shares = prop::array::uniform6(0.0..1.0_f64);
        runner
            .run(&shares, |shares| {
                let joints: [f64; 6] =
                    std::array::from_fn(|i| arm.lower[i] + shares[i] * (arm.upper[i] - arm.lower[i]));
                let pose = arm.forward(&joints);
                let their_pose = theirs.try_forward(&joints).expect("finite joints");
                let apart = (DVec3::from_array(pose.translation.vector.into()) - their_pose.translation).length();
                prop_assert!(apart < 1e-9, "{}: {apart} m", robot.model);
                let (_, distances) = arm.posture(&joints);
                prop_assume!(distances.wrist.abs() > 0.01 && distances.elbow.abs() > 0.01);
                prop_assume!(distances.shoulder.abs() > 0.01);
                let ours: Vec<[f64; 6]> = arm.inverse_all_turns(&pose).map(|solution| solution.joints).collect();
                prop_assert!(ours.iter().all(|joints| arm.within(joints, 0.0)));
                for solution in theirs.inverse(&pose_of(&pose)) {
                    for turned in turns(&arm, solution) {
                        let found = ours.iter().any(|ours| ours.iter().zip(&turned).all(|(a, b)| (a - b).abs() < 1e-7));
                        prop_assert!(found, "{}: {turned:?} not found", robot.model);
                    }
                }
                Ok(())
            })
            .unwrap_or_else(|failure| panic!("{failure}"));
    }
}

fn pose_of(pose: &Transform) -> Pose {
    let (t, q) = (pose.translation.vector, pose.rotation);
    Pose::from_parts(DVec3::new(t.x, t.y, t.z), DQuat::from_xyzw(q.i, q.j, q.k, q.w))
}

/// A solution in every whole turn inside the ranges, a micro-radian inside their ends.
fn turns(arm: &Arm, solution: [f64; 6]) -> Vec<[f64; 6]> {
    let mut all = vec![solution];
    for i in 0..6 {
        let inside = |angle: f64| angle > arm.lower[i] + 1e-6 && angle < arm.upper[i] - 1e-6;
        all = all
            .iter()
            .flat_map(|joints| {
                (-2..=2).map(|k| {
                    let mut turned = *joints;
                    turned[i] += TAU * f64::from(k);
                    turned
                })
            })
            .filter(|joints| inside(joints[i]))
            .collect();
    }
    all
}
