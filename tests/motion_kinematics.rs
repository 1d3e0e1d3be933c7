//! The arm's kinematics: forward and inverse are each other's inverse, beside somebody else's solver, every whole turn
//! found, singular postures held.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

#[path = "common/motion.rs"]
mod common;

use common::{ArmNumbers, IRB_6700, KR_210, WITH_OFFSET_B, deg, robot};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
use polishc::motion::frames::{matrix, turn};
use polishc::motion::{Arm, Branch, Transform, configuration};
use proptest::prelude::*;
use rs_opw_kinematics::glam::{DQuat, DVec3};
use rs_opw_kinematics::kinematic_traits::{Kinematics, Pose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use std::f64::consts::{PI, TAU};

/// Metres and radians that two double-precision solutions of a pose may differ by on an arm of some metres.
const SAME: f64 = 1e-9;

fn arm(numbers: &ArmNumbers) -> Arm {
    Arm::new(&robot(numbers)).expect("the numbers are an arm's")
}

fn oracle(numbers: &ArmNumbers) -> OPWKinematics {
    let [a1, a2, b, c1, c2, c3, c4] = numbers.lengths.map(|mm| mm * 1e-3);
    let offsets = deg(numbers.offsets);
    let sign_corrections = numbers.signs.map(|sign| sign as i8);
    OPWKinematics::new(Parameters { a1, a2, b, c1, c2, c3, c4, offsets, sign_corrections, dof: 6 })
}

fn assert_same_pose(found: &Transform, wanted: &Transform, tolerance: f64) {
    let apart = (found.translation.vector - wanted.translation.vector).norm();
    assert!(apart < tolerance, "{apart} m apart: {found} {wanted}");
    let turned = turn(&found.rotation, &wanted.rotation);
    assert!(turned < tolerance, "{turned} rad apart: {found} {wanted}");
}

/// The largest difference of two joint vectors, whole turns not counted.
fn apart(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| ((a - b) - TAU * ((a - b) / TAU).round()).abs()).fold(0.0, f64::max)
}

fn any_arm() -> impl Strategy<Value = &'static ArmNumbers> {
    prop_oneof![Just(&IRB_6700), Just(&KR_210), Just(&WITH_OFFSET_B)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// FK of every solution is the pose, and the joints that made the pose are among the solutions. Postures nearer
    /// than 0.01 rad to a singularity are left to the tests below: there joints may differ though poses agree.
    #[test]
    fn inverse_undoes_forward(numbers in any_arm(), share in prop::array::uniform6(0.0..1.0_f64)) {
        let arm = arm(numbers);
        let joints: [f64; 6] = std::array::from_fn(|i| arm.lower[i] + share[i] * (arm.upper[i] - arm.lower[i]));
        let pose = arm.forward(&joints);
        let solutions = arm.inverse(&pose);
        for solution in solutions.iter() {
            assert_same_pose(&arm.forward(&solution.joints), &pose, SAME);
            prop_assert!(solution.joints.iter().all(|joint| (-PI..PI).contains(joint)));
            let (branch, distances) = arm.posture(&solution.joints);
            if distances.wrist.abs() > 1e-6 && distances.elbow.abs() > 1e-6 && distances.shoulder.abs() > 1e-6 {
                prop_assert_eq!(branch, solution.branch);
            }
        }
        let (_, distances) = arm.posture(&joints);
        prop_assume!(distances.wrist.abs() > 0.01 && distances.elbow.abs() > 0.01 && distances.shoulder.abs() > 0.01);
        prop_assert!(solutions.iter().any(|solution| apart(&solution.joints, &joints) < SAME));
        // And with its own whole turns, among all turns.
        let found = arm.inverse_all_turns(&pose).any(|solution| {
            solution.joints.iter().zip(&joints).all(|(a, b)| (a - b).abs() < SAME)
        });
        prop_assert!(found);
        // And it is what a controller at these joints would stay at.
        let nearest = arm.nearest_solution(&pose, &joints).expect("it has solutions");
        prop_assert!(nearest.joints.iter().zip(&joints).all(|(a, b)| (a - b).abs() < SAME));
    }

    /// The same flange and the same solutions as rs-opw-kinematics.
    #[test]
    fn another_solver_finds_the_same(numbers in any_arm(), share in prop::array::uniform6(0.0..1.0_f64)) {
        let (arm, oracle) = (arm(numbers), oracle(numbers));
        let joints: [f64; 6] = std::array::from_fn(|i| arm.lower[i] + share[i] * (arm.upper[i] - arm.lower[i]));
        let pose = arm.forward(&joints);
        let theirs = oracle.try_forward(&joints).expect("finite joints");
        let at = theirs.translation;
        let q = theirs.rotation;
        let theirs = Transform::from_parts(
            Translation3::new(at.x, at.y, at.z),
            UnitQuaternion::new_normalize(nalgebra::Quaternion::new(q.w, q.x, q.y, q.z)),
        );
        assert_same_pose(&pose, &theirs, SAME);
        let ours = arm.inverse(&pose);
        // Near singularities the sets may differ by duplicates.
        prop_assume!(ours.iter().all(|s| s.distances.wrist.abs() > 0.01 && s.distances.wrist.abs() < PI - 0.01));
        prop_assume!(ours.iter().all(|s| s.distances.elbow.abs() > 0.01 && s.distances.shoulder.abs() > 0.01));
        let theirs = oracle.inverse(&their_pose(&pose));
        prop_assert_eq!(ours.len(), theirs.len());
        for solution in ours.iter() {
            prop_assert!(theirs.iter().any(|theirs| apart(theirs, &solution.joints) < 1e-8));
        }
    }

    /// All turns are exactly those that counting every turn of every branch finds inside the ranges.
    #[test]
    fn no_turn_is_missed(numbers in any_arm(), share in prop::array::uniform6(0.0..1.0_f64)) {
        let arm = arm(numbers);
        let joints: [f64; 6] = std::array::from_fn(|i| arm.lower[i] + share[i] * (arm.upper[i] - arm.lower[i]));
        let pose = arm.forward(&joints);
        let mut counted = 0;
        for solution in arm.inverse(&pose).iter() {
            let fitting = |i: usize| {
                (-4..=4).filter(|n| {
                    let turned = solution.joints[i] + TAU * f64::from(*n);
                    (arm.lower[i]..=arm.upper[i]).contains(&turned)
                }).count()
            };
            counted += (0..6).map(fitting).product::<usize>();
        }
        let found: Vec<_> = arm.inverse_all_turns(&pose).collect();
        prop_assert_eq!(found.len(), counted);
        for solution in &found {
            prop_assert!(arm.within(&solution.joints, 0.0));
            assert_same_pose(&arm.forward(&solution.joints), &pose, SAME);
        }
    }
}

fn their_pose(pose: &Transform) -> Pose {
    let (at, q) = (pose.translation, &pose.rotation);
    Pose::from_parts(DVec3::new(at.x, at.y, at.z), DQuat::from_xyzw(q.i, q.j, q.k, q.w))
}

/// Axis 6 at 0 with a range of -360 .. 360 deg stands in three turns, at both ends exactly; the other wrist's 180 in
/// two.
#[test]
fn ends_of_a_range_belong_to_it() {
    let arm = arm(&IRB_6700);
    let pose = arm.forward(&deg([10.0, 20.0, 15.0, 0.0, 60.0, 0.0]));
    let mut sixth: Vec<i64> = arm
        .inverse_all_turns(&pose)
        .filter(|s| !s.branch.wrist_negative && !s.branch.behind_lower_arm && !s.branch.behind_axis_1)
        .map(|s| s.joints[5].to_degrees().round() as i64)
        .collect();
    sixth.sort();
    assert_eq!(sixth, [-360, 0, 360]);
    let flipped: Vec<_> = arm
        .inverse_all_turns(&pose)
        .filter(|s| s.branch.wrist_negative && !s.branch.behind_lower_arm && !s.branch.behind_axis_1)
        .map(|s| [s.joints[3], s.joints[5]].map(|a| a.to_degrees().round() as i64))
        .collect();
    assert_eq!(flipped, [[-180, -180], [-180, 180], [180, -180], [180, 180]]);
}

/// With the wrist straight only the sum of axes 4 and 6 counts: one solution a posture, no duplicates, and following it
/// keeps axis 4 where it was.
#[test]
fn a_straight_wrist_keeps_axis_4() {
    let arm = arm(&IRB_6700);
    for bend in [0.0, 1e-12] {
        let joints = [0.3, 0.2, 0.4, 1.1, bend, -0.6];
        let pose = arm.forward(&joints);
        let solutions = arm.inverse(&pose);
        for (i, one) in solutions.iter().enumerate() {
            assert_same_pose(&arm.forward(&one.joints), &pose, SAME);
            for other in &solutions[..i] {
                assert!(apart(&one.joints, &other.joints) > 1e-3, "twice the same: {one:?} {other:?}");
            }
        }
        let nearest = arm.nearest_solution(&pose, &joints).expect("reachable");
        assert!(nearest.joints.iter().zip(&joints).all(|(a, b)| (a - b).abs() < 1e-8), "{nearest:?}");
    }
}

/// The wrist centre on axis 1 leaves joint 1 open: `nearest_solution` keeps it, all solutions still make the pose.
#[test]
fn a_wrist_over_axis_1_keeps_joint_1() {
    let arm = arm(&IRB_6700);
    // The flange 200 mm from the wrist centre (0, 0, 2.3 m) along its own z axis, the axis chosen askew.
    let rotation = UnitQuaternion::from_euler_angles(0.4, 0.9, -0.3);
    let flange = Transform::from_parts(
        Translation3::from(Vector3::new(0.0, 0.0, 2.3) + rotation * Vector3::new(0.0, 0.0, 0.2)),
        rotation,
    );
    let solutions = arm.inverse(&flange);
    assert!(!solutions.is_empty());
    for solution in solutions.iter() {
        assert_same_pose(&arm.forward(&solution.joints), &flange, SAME);
    }
    let previous =
        arm.inverse_in_branch(&flange, solutions[0].branch, &[0.7, 0.0, 0.0, 0.0, 0.0, 0.0]).expect("reachable");
    assert!((previous.joints[0] - 0.7).abs() < 1e-12);
    assert_same_pose(&arm.forward(&previous.joints), &flange, SAME);
}

/// Stretched: both elbows are one. At 6700's t3 = atan2(200, 1142.5), axis 3 stands at 9.9297 - 90 deg.
#[test]
fn a_stretched_arm_has_one_elbow() {
    let arm = arm(&IRB_6700);
    let stretched = 200_f64.atan2(1142.5) - PI / 2.0;
    let joints = [0.2, 0.5, stretched, 0.3, 0.8, 0.1];
    assert!(arm.elbow_angle(&joints).abs() < 1e-12);
    let pose = arm.forward(&joints);
    let solutions = arm.inverse(&pose);
    let front = solutions.iter().filter(|s| !s.branch.behind_axis_1).count();
    assert_eq!(front, 2, "one elbow, two wrists");
    for solution in solutions.iter() {
        // The square root of the pose's rounding, 1e-8 rad on each side, moves the stretched arm by its square only.
        assert_same_pose(&arm.forward(&solution.joints), &pose, 1e-7);
    }
}

#[test]
fn what_no_arm_reaches_has_no_solution() {
    let arm = arm(&IRB_6700);
    let far = Transform::from_parts(Translation3::new(9.0, 0.0, 0.0), UnitQuaternion::identity());
    assert!(arm.inverse(&far).is_empty());
    assert_eq!(arm.inverse_all_turns(&far).count(), 0);
    assert!(arm.nearest_solution(&far, &[0.0; 6]).is_none());
    let no_number = Transform::from_parts(Translation3::new(f64::NAN, 0.0, 1.0), UnitQuaternion::identity());
    assert_eq!(arm.inverse_all_turns(&no_number).count(), 0);
    assert!(arm.nearest_solution(&no_number, &[0.0; 6]).is_none());
}

/// In the plane of the arm at joint 1 = 0 the flange of the KR 210 home pose is known by adding lengths: lower arm
/// upright, upper arm level: x = a1 + c3 + c4 = 350 + 1200 + 215, z = c1 + c2 - (-a2) = 675 + 1150 - 41.
#[test]
fn home_pose_by_adding_lengths() {
    let pose = arm(&KR_210).forward(&deg([0.0, -90.0, 90.0, 0.0, 0.0, 0.0]));
    let m = matrix(&pose.rotation);
    assert!((pose.translation.vector - Vector3::new(1.765, 0.0, 1.784)).norm() < 1e-12);
    assert!((m[0][2] - 1.0).abs() < 1e-12, "the flange's z axis points along x");
}

/// The offset b shifts the whole arm sideways: at joints 0 the IRB's flange (1662.5, 0, 2105) moves to y = b.
#[test]
fn offset_b_moves_the_arm_sideways() {
    let pose = arm(&WITH_OFFSET_B).forward(&[0.0; 6]);
    assert!((pose.translation.vector - Vector3::new(1.6625, 0.085, 2.105)).norm() < 1e-12);
}

/// The joint sets and configuration data that a public post processor's test prints for an arm of the IRB 6700 family.
#[test]
fn confdata_of_published_joint_sets() {
    let arm = arm(&IRB_6700);
    for (joints, wanted) in [
        ([22.50953, 5.58534, 8.15717, 67.51143, -24.42689, -64.06258], [0, 0, -1, 1]),
        ([18.58928, 43.77805, -40.05410, 155.58093, -37.76022, -148.70252], [0, 1, -2, 1]),
        ([25.21677, 13.65153, -17.95808, 107.03387, -26.40518, -107.19412], [0, 1, -2, 1]),
    ] {
        assert_eq!(configuration::confdata(&arm, &deg(joints)), wanted);
    }
}

#[test]
fn a_tenth_of_a_degree_from_a_quarter_turn_is_near() {
    assert!(configuration::near_quarter(&deg([89.95, 45.0, 45.0, 45.0, 45.0, 45.0])));
    assert!(configuration::near_quarter(&deg([45.0, 0.0, 0.0, -180.05, 0.0, 45.0])));
    assert!(!configuration::near_quarter(&deg([0.2, 0.0, 0.0, -179.8, 0.0, 90.2])));
}

/// The eight branches are the eight numbers of cfx.
#[test]
fn branches_are_numbered_as_cfx() {
    for (number, branch) in Branch::ALL.iter().enumerate() {
        assert_eq!(branch.number(), number);
    }
}
