//! Kinematics: forward, inverse with all whole turns, the nearest solution, beside rs-opw-kinematics; and a whole plan
//! of 56,700 points. Prints nanoseconds a pose, the best of several rounds, and the ratio to the other solver in the
//! same round.
#![allow(clippy::disallowed_methods, clippy::print_stdout, reason = "a bench reads the clock and says what it found")]

#[path = "../tests/common/motion.rs"]
mod common;

use common::{IRB_6700, deg, irb_6700_in_cell, raster, robot};
use nalgebra::{Translation3, UnitQuaternion};
use polishc::dwell::SpeedSteps;
use polishc::motion::{Arm, Purpose, Request, Room, Transform, plan};
use polishc::path::Link;
use rs_opw_kinematics::glam::{DQuat, DVec3};
use rs_opw_kinematics::kinematic_traits::{Kinematics, Pose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use std::hint::black_box;
use std::time::Instant;

const POSES: usize = 20_000;
const ROUNDS: usize = 15;

fn main() {
    let arm = Arm::new(&robot(&IRB_6700)).expect("an arm");
    let [a1, a2, b, c1, c2, c3, c4] = IRB_6700.lengths.map(|mm| mm * 1e-3);
    let (offsets, sign_corrections) = (deg(IRB_6700.offsets), [1; 6]);
    let other = OPWKinematics::new(Parameters { a1, a2, b, c1, c2, c3, c4, offsets, sign_corrections, dof: 6 });

    // Joints all over the ranges: a multiplicative sequence, the same on every machine.
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let joints: Vec<[f64; 6]> =
        (0..POSES).map(|_| std::array::from_fn(|i| arm.lower[i] + next() * (arm.upper[i] - arm.lower[i]))).collect();
    let poses: Vec<Transform> = joints.iter().map(|joints| arm.forward(joints)).collect();
    let theirs: Vec<Pose> = poses.iter().map(their_pose).collect();

    let mut best = [f64::INFINITY; 5];
    let mut solutions = 0;
    for _ in 0..ROUNDS {
        let mut time = |which: usize, work: &mut dyn FnMut()| {
            let start = Instant::now();
            work();
            best[which] = best[which].min(start.elapsed().as_secs_f64() / POSES as f64 * 1e9);
        };
        time(0, &mut || {
            for joints in &joints {
                let _ = black_box(arm.forward(black_box(joints)));
            }
        });
        time(1, &mut || {
            solutions = 0;
            for pose in &poses {
                for solution in arm.inverse_all_turns(black_box(pose)) {
                    black_box(solution.joints);
                    solutions += 1;
                }
            }
        });
        time(2, &mut || {
            for (pose, joints) in poses.iter().zip(&joints) {
                black_box(arm.nearest_solution(black_box(pose), joints));
            }
        });
        time(3, &mut || {
            for pose in &theirs {
                let _ = black_box(other.inverse(black_box(pose)));
            }
        });
        time(4, &mut || {
            for joints in &joints {
                let _ = black_box(other.try_forward(black_box(joints)));
            }
        });
    }
    let per_pose = solutions as f64 / POSES as f64;
    println!(
        "forward                      {:7.0} ns   rs-opw {:7.0} ns, ratio {:.1}",
        best[0],
        best[4],
        best[4] / best[0]
    );
    println!(
        "inverse, all turns in range  {:7.0} ns   rs-opw, one turn, no ranges {:7.0} ns, ratio {:.1}   {per_pose:.1} solutions a pose",
        best[1],
        best[3],
        best[3] / best[1]
    );
    println!("nearest solution             {:7.0} ns", best[2]);

    let request = Request {
        standoff: 1.5e-3,
        azimuth: 0.0,
        tool_ball: polishc::tool::Ball { radius: 0.1, below: 0.0 },
        part: [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]],
        acceleration: 1.0,
        purpose: Purpose::Polish,
        room: Room::points(5000),
        speed_steps: SpeedSteps::Fixed(1e-6),
    };
    let (robot, timed) = (irb_6700_in_cell(), raster(700, 81, 4e-3, 0.5e-3, 0.02, Link::OnSurface));
    let mut least = f64::INFINITY;
    for _ in 0..5 {
        let timed = timed.clone();
        let start = Instant::now();
        let motion = plan(timed, &robot, &request).expect("it can be planned");
        least = least.min(start.elapsed().as_secs_f64());
        black_box(motion.joints.len());
    }
    println!("plan of {} points         {:7.0} ms", timed.speed.len(), least * 1e3);
}

fn their_pose(pose: &Transform) -> Pose {
    let (at, q): (&Translation3<f64>, &UnitQuaternion<f64>) = (&pose.translation, &pose.rotation);
    Pose::from_parts(DVec3::new(at.x, at.y, at.z), DQuat::from_xyzw(q.i, q.j, q.k, q.w))
}
