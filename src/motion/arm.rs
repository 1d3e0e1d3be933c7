//! Arms: forward and inverse kinematics of six joints with an ortho-parallel basis and a spherical wrist.
//!
//! In: the seven lengths, offsets and signs of Brandstötter, Angerer, Hofbaur, "An analytical solution of the inverse
//! kinematics problem of industrial serial manipulators with an ortho-parallel basis and a spherical wrist" (2014), and
//! the joints' ranges and speeds. Out: flange poses and joint angles, radians, in the maker's convention, whole turns
//! counted.
//!
//! Written anew because what exists tests joint ranges modulo one turn and is slower. The inverse takes angles from
//! `atan2` only and carries sines and cosines between the steps as plain algebra, so nothing is lost near
//! singularities and most of the trigonometry falls away.

use super::frames::{Matrix, Transform, matrix, quaternion_from_matrix};
use super::turns::{AllTurns, nearest_turn, wrap};
use crate::diagnostics::{Problem, codes};
use crate::job;
use nalgebra::Translation3;
use std::f64::consts::{PI, TAU};

/// Six joint angles in radians, maker's convention, whole turns counted.
pub type Joints = [f64; 6];

/// A joint may lie this far outside its range and still count as inside: the rounding of a pose in metres and of the
/// formulas, some 1e-15 of a turn magnified by the lengths, not a permission to move.
const RANGE_ROUNDING: f64 = 1e-9;

/// Below this sine of joint 5, or this distance in metres of the wrist from axis 1, the pose says nothing about the
/// angle of joint 4, or 1: the pose's own rounding (1e-16) would be a millionth of a radian of it. Setting the
/// sine to zero moves the flange by less than a nanometre.
const INDEFINITE: f64 = 1e-10;

/// The two elbow solutions nearer to one another than this (sine of the elbow angle) count as one: a stretched arm,
/// seen through the square root of the pose's rounding.
const SAME_ELBOW: f64 = 1e-7;

/// How far the cosine of the elbow angle may pass 1 by rounding.
const REACH_ROUNDING: f64 = 1e-12;

/// Joint ranges end within two turns of zero (and the rounding of 720 degrees), as the schema of `joint` says: flange
/// and hoses of arms of this kind turn no further, and more is degrees taken for radians.
const MOST_TURN: f64 = 2.0 * TAU + RANGE_ROUNDING;

/// Which of the up to eight solutions: three questions, as ABB's cfx asks them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Branch {
    /// The wrist centre lies behind axis 1.
    pub behind_axis_1: bool,
    /// The wrist centre lies behind the lower arm.
    pub behind_lower_arm: bool,
    /// The wrist's angle (joint 5 from its straight position) is negative.
    pub wrist_negative: bool,
}

impl Branch {
    /// All eight, in the order of [`Branch::number`].
    pub const ALL: [Branch; 8] = {
        let mut all = [Branch { behind_axis_1: false, behind_lower_arm: false, wrist_negative: false }; 8];
        let mut n = 0;
        while n < 8 {
            all[n] = Branch { behind_axis_1: n & 4 != 0, behind_lower_arm: n & 2 != 0, wrist_negative: n & 1 != 0 };
            n += 1;
        }
        all
    };

    /// 0 to 7: 4 behind axis 1, 2 behind the lower arm, 1 wrist negative.
    pub fn number(self) -> usize {
        4 * usize::from(self.behind_axis_1) + 2 * usize::from(self.behind_lower_arm) + usize::from(self.wrist_negative)
    }
}

/// How far a posture is from the three singularities; each is zero there and signed by the branch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distances {
    /// Wrist centre from axis 1, in the plane of the arm, metres.
    pub shoulder: f64,
    /// Sine of the angle between lower and upper arm (the upper arm from elbow to wrist centre).
    pub elbow: f64,
    /// Joint 5 from its straight position, radians.
    pub wrist: f64,
}

/// One solution of the inverse kinematics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    pub branch: Branch,
    pub joints: Joints,
    pub distances: Distances,
}

/// An arm whose numbers were checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    a1: f64,
    a2: f64,
    b: f64,
    c1: f64,
    c2: f64,
    c3: f64,
    c4: f64,
    offsets: [f64; 6],
    signs: [f64; 6],
    /// From the elbow to the wrist centre, and the angle of that line from the upper arm's own axis.
    upper_arm: f64,
    lean: f64,
    sin_lean: f64,
    cos_lean: f64,
    /// Joint ranges, radians.
    pub lower: Joints,
    pub upper: Joints,
    /// Rated joint speeds, rad/s.
    pub speeds: Joints,
}

impl Arm {
    /// The arm of the job's robot. Refuses what is no arm: a count other than six, a sign that is not 1 or -1, a range
    /// with its ends the wrong way round or beyond two turns, a length or speed that cannot be.
    pub fn new(robot: &job::Robot) -> Result<Arm, Problem> {
        let job::Arm::ortho_parallel(arm) = &robot.arm;
        let bad = |field: &str, message: String| Problem::error(codes::E0800, field, message);
        let offsets = six(arm.offsets.iter().map(|angle| angle.0), "robot.arm.offsets", "offsets")?;
        let signs = six(arm.signs.iter().copied(), "robot.arm.signs", "signs")?;
        let lower = six(robot.joints.iter().map(|joint| joint.range.from.0), "robot.joints", "joints")?;
        let upper = six(robot.joints.iter().map(|joint| joint.range.to.0), "robot.joints", "joints")?;
        let speeds = six(robot.joints.iter().map(|joint| joint.speed.0), "robot.joints", "joints")?;
        if let Some(i) = signs.iter().position(|sign| sign.abs() != 1.0) {
            let message = format!("the sign of joint {} is {}, it must be 1 or -1", i + 1, signs[i]);
            return Err(bad("robot.arm.signs", message));
        }
        if let Some(i) = offsets.iter().position(|offset| !offset.is_finite()) {
            return Err(bad("robot.arm.offsets", format!("the offset of joint {} is not a finite number", i + 1)));
        }
        let [a1, a2, b, c1, c2, c3, c4] = [arm.a1.0, arm.a2.0, arm.b.0, arm.c1.0, arm.c2.0, arm.c3.0, arm.c4.0];
        for (name, length) in [("a1", a1), ("a2", a2), ("b", b), ("c1", c1), ("c2", c2), ("c3", c3), ("c4", c4)] {
            if !length.is_finite() {
                return Err(bad(
                    &format!("robot.arm.{name}"),
                    format!("the arm's length `{name}` is not a finite number"),
                ));
            }
        }
        let upper_arm = libm::hypot(a2, c3);
        if c2 <= 0.0 || upper_arm <= 0.0 {
            return Err(bad(
                "robot.arm",
                "the lower arm `c2` and the upper arm (`a2`, `c3`) must be longer than 0 mm".into(),
            ));
        }
        for i in 0..6 {
            let field = joint_field(i);
            // Written so that numbers that are none are refused too.
            if !(lower[i] < upper[i] && lower[i].is_finite() && upper[i].is_finite()) {
                let (from, to) = (lower[i].to_degrees(), upper[i].to_degrees());
                let message = format!("the range of joint {} runs from {from:.3} deg to {to:.3} deg", i + 1);
                return Err(bad(&format!("{field}.range"), message).help("give the smaller angle first"));
            }
            if lower[i] < -MOST_TURN || upper[i] > MOST_TURN {
                let message = format!("the range of joint {} goes beyond two turns", i + 1);
                return Err(bad(&format!("{field}.range"), message).help("check the unit of the angles"));
            }
            if !(speeds[i] > 0.0 && speeds[i].is_finite()) {
                let message = format!("the rated speed of joint {} is {:.3} deg/s", i + 1, speeds[i].to_degrees());
                return Err(bad(&format!("{field}.speed"), message).help("give the speed of the maker's data sheet"));
            }
        }
        let (sin_lean, cos_lean) = (-a2 / upper_arm, c3 / upper_arm);
        let lean = libm::atan2(-a2, c3);
        Ok(Arm { a1, a2, b, c1, c2, c3, c4, offsets, signs, upper_arm, lean, sin_lean, cos_lean, lower, upper, speeds })
    }

    /// The flange frame in the robot's base.
    pub fn forward(&self, joints: &Joints) -> Transform {
        let (position, rotation) = self.forward_matrix(joints);
        let [x, y, z] = position;
        Transform::from_parts(Translation3::new(x, y, z), quaternion_from_matrix(&rotation))
    }

    /// The flange's position in the base, and its axes as the columns of a matrix.
    pub fn forward_matrix(&self, joints: &Joints) -> ([f64; 3], Matrix) {
        let t = self.internal(joints);
        let [(s1, c1), (s2, c2), (s4, c4), (s5, c5), (s6, c6)] = [t[0], t[1], t[3], t[4], t[5]].map(libm::sincos);
        let (s23, c23) = libm::sincos(t[1] + t[2]);
        let radius = self.a1 + self.c2 * s2 + self.a2 * c23 + self.c3 * s23;
        let height = self.c1 + self.c2 * c2 - self.a2 * s23 + self.c3 * c23;
        // The wrist's own rotation Rz(t4) Ry(t5) Rz(t6), then Ry(t2 + t3), then Rz(t1).
        let wrist = [
            [c4 * c5 * c6 - s4 * s6, -c4 * c5 * s6 - s4 * c6, c4 * s5],
            [s4 * c5 * c6 + c4 * s6, -s4 * c5 * s6 + c4 * c6, s4 * s5],
            [-s5 * c6, s5 * s6, c5],
        ];
        let mut m = [[0.0; 3]; 3];
        for i in 0..3 {
            let (x, y) = (c23 * wrist[0][i] + s23 * wrist[2][i], wrist[1][i]);
            m[0][i] = c1 * x - s1 * y;
            m[1][i] = s1 * x + c1 * y;
            m[2][i] = -s23 * wrist[0][i] + c23 * wrist[2][i];
        }
        let position = [
            c1 * radius - s1 * self.b + self.c4 * m[0][2],
            s1 * radius + c1 * self.b + self.c4 * m[1][2],
            height + self.c4 * m[2][2],
        ];
        (position, m)
    }

    /// All solutions, one a branch, joint angles in [-pi, pi), joint ranges not asked. Where the pose leaves a joint's
    /// angle open, joint 1 or joint 4 is at its offset's zero; solutions that fall together are given once.
    pub fn inverse(&self, flange: &Transform) -> Branches {
        let mut branches = self.principal(flange, None, Ranges::NotAsked);
        for solution in &mut branches.solutions[..branches.count] {
            solution.joints = solution.joints.map(wrap);
        }
        branches
    }

    /// All solutions inside the joint ranges with every whole turn that fits, branch by branch.
    pub fn inverse_all_turns(&self, flange: &Transform) -> AllTurns<'_> {
        AllTurns::new(self, self.principal(flange, None, Ranges::FirstThree))
    }

    /// The solution of one branch, each joint in the turn nearest to `previous`; where the pose leaves joint 1 or 4
    /// open, `previous` says it. The joint ranges are not asked. `None` when the pose is out of reach.
    pub fn inverse_in_branch(&self, flange: &Transform, branch: Branch, previous: &Joints) -> Option<Solution> {
        let pose = Pose::new(self, flange);
        let shoulder = self.shoulder(&pose, branch.behind_axis_1, Some(previous))?;
        let elbow = self.elbow(&shoulder, branch.behind_lower_arm);
        let mut solution = self.wrist(&pose, &shoulder, &elbow, branch.wrist_negative, Some(previous));
        solution.branch = branch;
        for (joint, near) in solution.joints.iter_mut().zip(previous) {
            *joint = nearest_turn(*joint, *near);
        }
        Some(solution)
    }

    /// The solution nearest to `previous` of all branches, each joint in the turn nearest to it: what a controller that
    /// does not watch the configuration (`ConfL\Off`) drives to. Nearest is the least sum of squared joint changes;
    /// of two equally near ones, the first in the order of [`Branch::ALL`]. The joint ranges are not asked.
    pub fn nearest_solution(&self, flange: &Transform, previous: &Joints) -> Option<Solution> {
        let mut branches = self.principal(flange, Some(previous), Ranges::NotAsked);
        let mut best: Option<(f64, Solution)> = None;
        for solution in &mut branches.solutions[..branches.count] {
            let mut square = 0.0;
            for (joint, near) in solution.joints.iter_mut().zip(previous) {
                *joint = nearest_turn(*joint, *near);
                square += (*joint - near) * (*joint - near);
            }
            if best.as_ref().is_none_or(|(least, _)| square < *least) {
                best = Some((square, *solution));
            }
        }
        best.map(|(_, solution)| solution)
    }

    /// Whether all joints lie inside their ranges, `margin` from both ends.
    pub fn within(&self, joints: &Joints, margin: f64) -> bool {
        self.least_margin(joints).0 >= margin - RANGE_ROUNDING
    }

    /// The least distance of any joint to the ends of its range (negative outside), and which joint (from 0).
    pub fn least_margin(&self, joints: &Joints) -> (f64, usize) {
        let mut least = (f64::INFINITY, 0);
        for (i, joint) in joints.iter().enumerate() {
            let margin = (joint - self.lower[i]).min(self.upper[i] - joint);
            if margin < least.0 {
                least = (margin, i);
            }
        }
        least
    }

    /// The posture's branch and its distances from the singularities.
    pub fn posture(&self, joints: &Joints) -> (Branch, Distances) {
        let t = self.internal(joints);
        let (s23, c23) = libm::sincos(t[1] + t[2]);
        let distances = Distances {
            shoulder: self.a1 + self.c2 * libm::sin(t[1]) + self.a2 * c23 + self.c3 * s23,
            elbow: libm::sin(t[2] - self.lean),
            wrist: wrap(t[4]),
        };
        let branch = Branch {
            behind_axis_1: distances.shoulder < 0.0,
            behind_lower_arm: distances.elbow < 0.0,
            wrist_negative: distances.wrist < 0.0,
        };
        (branch, distances)
    }

    /// The angle between lower arm and the line from elbow to wrist centre, radians in [-pi, pi): zero when stretched,
    /// positive with the wrist in front of the lower arm.
    pub fn elbow_angle(&self, joints: &Joints) -> f64 {
        wrap(self.internal(joints)[2] - self.lean)
    }

    /// Where the wrist centre would have to lie for this flange pose, from axis 2, and the least and most that the arm
    /// can do, metres; in front of axis 1 or behind it. `None` when it would lie nearer to axis 1 than the arm's offset
    /// `b`.
    pub fn reach(&self, flange: &Transform, behind: bool) -> Option<(f64, f64, f64)> {
        let pose = Pose::new(self, flange);
        let (_, r, z) = self.arm_plane(&pose, behind)?;
        Some((libm::hypot(r, z), (self.c2 - self.upper_arm).abs(), self.c2 + self.upper_arm))
    }

    /// `sign * joint - offset` of each joint: the angles of the formulas.
    fn internal(&self, joints: &Joints) -> [f64; 6] {
        let mut t = [0.0; 6];
        for i in 0..6 {
            t[i] = self.signs[i] * joints[i] - self.offsets[i];
        }
        t
    }

    /// The maker's angle of joint `i` (from 0) whose angle in the formulas is `t`.
    fn maker(&self, i: usize, t: f64) -> f64 {
        self.signs[i] * (t + self.offsets[i])
    }

    /// The lowest turn of an angle of joint `i` (from 0) inside its range, if one is.
    pub(super) fn lowest_turn(&self, i: usize, angle: f64) -> Option<f64> {
        let lower = self.lower[i] - RANGE_ROUNDING;
        // The turn nearest to the lower end, or the one above it.
        let nearest = nearest_turn(angle, lower);
        let lowest = if nearest < lower { nearest + TAU } else { nearest };
        (lowest <= self.upper[i] + RANGE_ROUNDING).then_some(lowest)
    }

    /// How many whole turns more than `angle`, which is in the range of joint `i`, fit into the range.
    pub(super) fn turns_above(&self, i: usize, angle: f64) -> u32 {
        ((self.upper[i] + RANGE_ROUNDING - angle) * (1.0 / TAU)) as u32
    }

    /// All branches, not wrapped to one turn. When `ranges` are asked, without those whose first three joints have no
    /// turn in range: half of the work is the wrist's.
    fn principal(&self, flange: &Transform, previous: Option<&Joints>, ranges: Ranges) -> Branches {
        let pose = Pose::new(self, flange);
        let mut found = Branches::default();
        let outside =
            |i: usize, t: f64| ranges == Ranges::FirstThree && self.lowest_turn(i, self.maker(i, t)).is_none();
        for behind in [false, true] {
            let Some(shoulder) = self.shoulder(&pose, behind, previous) else { continue };
            for behind_lower_arm in [false, true] {
                if behind_lower_arm && shoulder.sin_elbow < SAME_ELBOW {
                    continue;
                }
                let elbow = self.elbow(&shoulder, behind_lower_arm);
                if outside(0, shoulder.t1) || outside(1, elbow.t2) || outside(2, elbow.t3) {
                    continue;
                }
                let plus = self.wrist(&pose, &shoulder, &elbow, false, previous);
                found.push(plus);
                // A straight (or folded) wrist leaves joint 4 open: the other branch is the same posture.
                if plus.distances.wrist == 0.0 || plus.distances.wrist == PI {
                    continue;
                }
                let mut minus = plus;
                minus.branch.wrist_negative = true;
                minus.distances.wrist = -plus.distances.wrist;
                minus.joints[3] += PI;
                minus.joints[4] = self.maker(4, minus.distances.wrist);
                minus.joints[5] += PI;
                found.push(minus);
            }
            // With the wrist centre on axis 1 both shoulders are the same postures, joint 1 being open.
            if shoulder.radius.abs() < INDEFINITE {
                break;
            }
        }
        found
    }

    /// In the plane of the arm: the wrist centre's signed distance from axis 1, and its place from axis 2.
    fn arm_plane(&self, pose: &Pose, behind: bool) -> Option<(f64, f64, f64)> {
        let [x, y, z] = pose.wrist;
        let square = x * x + y * y - self.b * self.b;
        if square < 0.0 {
            return None;
        }
        let radius = if behind { -square.sqrt() } else { square.sqrt() };
        Some((radius, radius - self.a1, z - self.c1))
    }

    fn shoulder(&self, pose: &Pose, behind: bool, previous: Option<&Joints>) -> Option<Shoulder> {
        let [x, y, _] = pose.wrist;
        let (radius, r, z) = self.arm_plane(pose, behind)?;
        let square = r * r + z * z;
        let k = self.upper_arm;
        let cos_elbow = (square - self.c2 * self.c2 - k * k) / (2.0 * self.c2 * k);
        // Written so that a cosine that is no number has no solution.
        let reached = cos_elbow.abs() <= 1.0 + REACH_ROUNDING;
        if !reached {
            return None;
        }
        let cos_elbow = cos_elbow.clamp(-1.0, 1.0);
        let sin_elbow = ((1.0 - cos_elbow) * (1.0 + cos_elbow)).sqrt();
        let h = x * x + y * y;
        let (t1, s1, c1) = if h < INDEFINITE * INDEFINITE {
            let t1 = previous.map_or(0.0, |joints| self.signs[0] * joints[0] - self.offsets[0]);
            let (s1, c1) = libm::sincos(t1);
            (t1, s1, c1)
        } else {
            let (s1, c1) = ((y * radius - x * self.b) / h, (x * radius + y * self.b) / h);
            (libm::atan2(s1, c1), s1, c1)
        };
        let along = self.c2 + k * cos_elbow;
        let across = k * sin_elbow;
        Some(Shoulder {
            radius,
            t1,
            s1,
            c1,
            r,
            z,
            square,
            along,
            across,
            direction: libm::atan2(r, z),
            inset: libm::atan2(across, along),
            elbow: libm::atan2(sin_elbow, cos_elbow),
            sin_elbow,
            cos_elbow,
        })
    }

    fn elbow(&self, shoulder: &Shoulder, behind: bool) -> Elbow {
        let side = if behind { -1.0 } else { 1.0 };
        let Shoulder { r, z, square, along, .. } = *shoulder;
        let across = side * shoulder.across;
        let elbow = side * shoulder.elbow;
        // The lower arm's direction by subtraction of angles; with the wrist centre on axis 2 (both arms equally long
        // and folded) any direction will do, and `direction - inset` is the one of the angles.
        let (s2, c2) = if square > 0.0 {
            ((r * along - z * across) / square, (z * along + r * across) / square)
        } else {
            libm::sincos(shoulder.direction - side * shoulder.inset)
        };
        // The upper arm's axis lies at t2 + elbow + lean.
        let (se, ce) = (
            side * shoulder.sin_elbow * self.cos_lean + shoulder.cos_elbow * self.sin_lean,
            shoulder.cos_elbow * self.cos_lean - side * shoulder.sin_elbow * self.sin_lean,
        );
        Elbow {
            behind,
            t2: shoulder.direction - side * shoulder.inset,
            t3: elbow + self.lean,
            sin: side * shoulder.sin_elbow,
            s23: s2 * ce + c2 * se,
            c23: c2 * ce - s2 * se,
        }
    }

    /// The wrist's three angles, and all joints together.
    fn wrist(
        &self,
        pose: &Pose,
        shoulder: &Shoulder,
        elbow: &Elbow,
        negative: bool,
        previous: Option<&Joints>,
    ) -> Solution {
        let m = &pose.rotation;
        let Shoulder { s1, c1, .. } = *shoulder;
        let Elbow { s23, c23, .. } = *elbow;
        // The first two rows of (Rz(t1) Ry(t2 + t3))^T R, and the last element of the third.
        let row = |i: usize| c1 * m[0][i] + s1 * m[1][i];
        let first = [0, 1, 2].map(|i| c23 * row(i) - s23 * m[2][i]);
        let second = [0, 1, 2].map(|i| c1 * m[1][i] - s1 * m[0][i]);
        let cos5 = s23 * row(2) + c23 * m[2][2];
        let sin5 = (first[2] * first[2] + second[2] * second[2]).sqrt();
        let (t4, s4, c4, t5) = if sin5 < INDEFINITE {
            let t4 = previous.map_or(0.0, |joints| self.signs[3] * joints[3] - self.offsets[3]);
            let (s4, c4) = libm::sincos(t4);
            (t4, s4, c4, if cos5 > 0.0 { 0.0 } else { PI })
        } else {
            let sign = if negative { -1.0 } else { 1.0 };
            let (s4, c4) = (sign * second[2] / sin5, sign * first[2] / sin5);
            (libm::atan2(s4, c4), s4, c4, sign * libm::atan2(sin5, cos5))
        };
        // From the row that joint 5 does not touch, so that t6 makes up for whatever t4 was taken to be.
        let t6 = libm::atan2(c4 * second[0] - s4 * first[0], c4 * second[1] - s4 * first[1]);
        Solution {
            branch: Branch {
                behind_axis_1: shoulder.radius < 0.0,
                behind_lower_arm: elbow.behind,
                wrist_negative: negative,
            },
            joints: [
                self.maker(0, shoulder.t1),
                self.maker(1, elbow.t2),
                self.maker(2, elbow.t3),
                self.maker(3, t4),
                self.maker(4, t5),
                self.maker(5, t6),
            ],
            distances: Distances { shoulder: shoulder.radius, elbow: elbow.sin, wrist: t5 },
        }
    }
}

/// The field path of joint `i` (from 0) of the robot.
pub(super) fn joint_field(i: usize) -> String {
    format!("robot.joints.{i}")
}

/// Exactly six numbers, or the refusal that says how many there are.
pub(super) fn six(numbers: impl Iterator<Item = f64>, field: &str, what: &str) -> Result<[f64; 6], Problem> {
    let numbers: Vec<f64> = numbers.collect();
    <[f64; 6]>::try_from(numbers.as_slice()).map_err(|_| {
        let message = format!("there are {} {what}, an arm of this kind has six", numbers.len());
        Problem::error(codes::E0800, field, message)
    })
}

/// Which joint ranges the formulas ask.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ranges {
    NotAsked,
    FirstThree,
}

/// A flange pose as the formulas want it: the rotation and the wrist centre.
struct Pose {
    rotation: Matrix,
    wrist: [f64; 3],
}

impl Pose {
    fn new(arm: &Arm, flange: &Transform) -> Pose {
        let rotation = matrix(&flange.rotation);
        let p = &flange.translation.vector;
        let wrist = [p.x - arm.c4 * rotation[0][2], p.y - arm.c4 * rotation[1][2], p.z - arm.c4 * rotation[2][2]];
        Pose { rotation, wrist }
    }
}

/// What both elbows of one shoulder share.
struct Shoulder {
    radius: f64,
    t1: f64,
    s1: f64,
    c1: f64,
    /// The wrist centre from axis 2, outwards and up, and the square of its distance.
    r: f64,
    z: f64,
    square: f64,
    /// The wrist centre along and across the lower arm.
    along: f64,
    across: f64,
    direction: f64,
    inset: f64,
    elbow: f64,
    sin_elbow: f64,
    cos_elbow: f64,
}

struct Elbow {
    behind: bool,
    t2: f64,
    t3: f64,
    sin: f64,
    s23: f64,
    c23: f64,
}

/// Up to eight solutions, one a branch.
#[derive(Clone, Copy, Debug)]
pub struct Branches {
    solutions: [Solution; 8],
    count: usize,
}

impl Default for Branches {
    fn default() -> Branches {
        let nothing = Solution { branch: Branch::ALL[0], joints: [0.0; 6], distances: Distances::default() };
        Branches { solutions: [nothing; 8], count: 0 }
    }
}

impl Branches {
    fn push(&mut self, solution: Solution) {
        self.solutions[self.count] = solution;
        self.count += 1;
    }
}

impl std::ops::Deref for Branches {
    type Target = [Solution];
    fn deref(&self) -> &[Solution] {
        &self.solutions[..self.count]
    }
}
