//! The replay: where the tool stands on the part, and how the arm gets there, from the numbers of the text.
//!
//! In: the frames that the text states, its targets. Out: differences from the plan, in terms of the part. Numbers are in
//! single precision, as controllers store them; the arm goes from planned joints to the nearest solution at every target.

use super::findings::Difference;
use super::planned::{Planned, millimetres};
use crate::diagnostics::codes::{E1005, E1006, E1014};
use crate::job::{Job, RobotCell};
use crate::motion::{Arm, Joints, Motion, Purpose, Transform};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// How far a contact point may lie from the planned one, metres: a few times what four decimals of a millimetre leave,
/// and a thousandth of what an influence function changes over.
pub(super) const CONTACT_TOLERANCE: f64 = 1e-6;

/// How far an orientation may lie from the planned one: 0.001 deg, in radians. Over a 10 mm spot that is 0.2 um of height,
/// and ten times what six decimals of a quaternion leave.
pub(super) const ORIENTATION_TOLERANCE: f64 = 0.001 * std::f64::consts::PI / 180.0;

/// A joint that arrives farther than this from its plan is in another configuration, radians: rounding moves joints by a
/// millionth of a degree, branches lie apart by twice the margins to the singularities, turns by 360 deg.
pub(super) const CONFIGURATION_TOLERANCE: f64 = std::f64::consts::PI / 180.0;

/// The frames that the text works with, in metres, from its numbers in single precision.
#[derive(Clone, Debug)]
pub(super) struct Frames {
    /// The object frame (the part) in the world.
    pub world_object: Transform,
    pub flange_tool: Transform,
}

/// The frames of the replay, put together once.
pub(super) struct Replay<'a> {
    motion: &'a Motion,
    arm: &'a Arm,
    /// Object frame of the text in the part frame: the identity when the text's frames are the job's.
    part_object: Transform,
    /// Tool frame of the job in the tool frame of the text: the identity when they are the same.
    tool_change: Transform,
    /// Object frame of the text in the robot's base.
    base_object: Transform,
    /// Flange in the tool frame of the text.
    tool_flange: Transform,
    /// From the contact point to the tool centre point along the normal, metres.
    pub standoff: f64,
}

impl<'a> Replay<'a> {
    pub fn new(motion: &'a Motion, job: &Job, cell: &RobotCell, arm: &'a Arm, frames: &Frames) -> Replay<'a> {
        let chain = &motion.frames;
        let lift = match motion.purpose {
            Purpose::Polish => 0.0,
            Purpose::DryRun => cell.travel.height.0,
        };
        Replay {
            motion,
            arm,
            part_object: (chain.world_user * chain.user_object).inverse() * frames.world_object,
            tool_change: frames.flange_tool.inverse() * chain.flange_tool,
            base_object: chain.world_base.inverse() * frames.world_object,
            tool_flange: frames.flange_tool.inverse(),
            standoff: job.tool.standoff() + lift,
        }
    }

    /// The job's tool in the part frame, when the text's tool is at `target`.
    pub fn tool(&self, target: &Transform) -> Transform {
        self.part_object * target * self.tool_change
    }

    /// The job's tool in the part frame, when the arm's joints (radians) are these.
    pub fn tool_of_joints(&self, joints: &Joints) -> Transform {
        let target = self.base_object.inverse() * self.arm.forward(joints) * self.tool_flange.inverse();
        self.tool(&target)
    }

    /// Whether a move to `target` ends where the plan's does, orientation apart.
    pub fn lies_at(&self, target: &Transform, planned: Planned) -> bool {
        let [x, y, z] = planned.pose(self.motion).position;
        (self.tool(target).translation.vector - Vector3::new(x, y, z)).norm() <= CONTACT_TOLERANCE
    }

    /// Where the tool stands on the part: contact point, normal, turn about it. Whether all is as planned.
    pub fn pose(&self, planned: Planned, target: &Transform, report: &mut impl FnMut(Difference)) -> bool {
        let wanted = planned.pose(self.motion);
        let tool = self.tool(target);
        let [w, x, y, z] = wanted.quaternion;
        let wanted_rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        // The tool's +z points into the glass.
        let axis = tool.rotation * Vector3::z();
        let (contact, normal) = match planned {
            Planned::Point(i) => {
                let points = &self.motion.timed.path.points;
                (points.position(i), Vector3::from(points.normal(i)))
            }
            _ => {
                let axis = wanted_rotation * Vector3::z();
                ((Vector3::from(wanted.position) + axis * self.standoff).into(), -axis)
            }
        };
        let found = tool.translation.vector + axis * self.standoff;
        let off = (found - Vector3::from(contact)).norm();
        // Written so that a place that is no number differs.
        let at_place = off <= CONTACT_TOLERANCE;
        if !at_place {
            let [x, y, z] = [found.x, found.y, found.z].map(millimetres);
            let what =
                format!("is met at x = {x}, y = {y}, z = {z} mm, {} mm from where it is planned", millimetres(off));
            report(Difference { code: E1005, field: "path", what });
        }
        let tilt = angle_between_directions(&axis, &-normal);
        let upright = tilt <= ORIENTATION_TOLERANCE;
        if !upright {
            let what = format!("is met {:.4} deg off the normal", tilt.to_degrees());
            report(Difference { code: E1014, field: "path", what });
            return false;
        }
        let turn = angle_between(&tool.rotation, &wanted_rotation);
        let aligned = turn <= 2.0 * ORIENTATION_TOLERANCE;
        if !aligned {
            let what = format!("is met with the tool turned by {:.4} deg about the normal", turn.to_degrees());
            report(Difference { code: E1014, field: "tool.azimuth", what });
            return false;
        }
        at_place
    }

    /// The arm's joints at `target`, from `joints` before.
    pub fn solve(&self, target: &Transform, joints: &Joints) -> Option<Joints> {
        let flange = self.base_object * target * self.tool_flange;
        self.arm.nearest_solution(&flange, joints).map(|solution| solution.joints)
    }

    /// Whether the arm arrives at `target` in the planned joints, which then are `joints`. After a wrong place, which was
    /// reported, the plan's joints count.
    pub fn arrives(
        &self,
        planned: Planned,
        target: &Transform,
        pose_is_good: bool,
        joints: &mut Joints,
        report: &mut impl FnMut(Difference),
    ) {
        let planned_joints = planned.joints(self.motion);
        if !pose_is_good {
            *joints = planned_joints;
            return;
        }
        match self.solve(target, joints) {
            Some(solution) => {
                let far = (0..6).find(|j| (solution[*j] - planned_joints[*j]).abs() > CONFIGURATION_TOLERANCE);
                *joints = solution;
                if let Some(j) = far {
                    let [found, wanted] = [solution[j], planned_joints[j]].map(f64::to_degrees);
                    let what = format!(
                        "is reached in another configuration: joint {} arrives at {found:.3} deg where {wanted:.3} deg is planned",
                        j + 1
                    );
                    report(Difference { code: E1006, field: "robot", what });
                    *joints = planned_joints;
                }
            }
            None => {
                report(Difference { code: E1006, field: "robot", what: "is out of the arm's reach".into() });
                *joints = planned_joints;
            }
        }
    }
}

/// The angle between two unit directions, radians; exact where it is small.
pub(super) fn angle_between_directions(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    libm::atan2(a.cross(b).norm(), a.dot(b))
}

/// The angle between two orientations, radians.
pub(super) fn angle_between(a: &UnitQuaternion<f64>, b: &UnitQuaternion<f64>) -> f64 {
    let turn = a.inverse() * b;
    let sine = (turn.i * turn.i + turn.j * turn.j + turn.k * turn.k).sqrt();
    2.0 * libm::atan2(sine, turn.w.abs())
}

/// Numbers are the same if single precision cannot tell them apart: its step is 1.2e-7 of the number, and both sides may
/// be rounded.
const SAME_SHARE: f64 = 3e-7;

/// Whether the controller stores the same number for both.
pub(super) fn same_number(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_SHARE * a.abs().max(b.abs())
}

/// Half of the last of so many decimals.
pub(super) fn half_digit(decimals: i64) -> f64 {
    0.5 * libm::pow(10.0, -decimals as f64) * (1.0 + 1e-9)
}

/// What storing `value` in single precision can change.
pub(super) fn single_step(value: f64) -> f64 {
    value.abs() * f64::from(f32::EPSILON) / 2.0
}

/// A number from single precision, without the digits that double precision adds.
pub(super) fn shortest(value: f64) -> String {
    format!("{}", value as f32)
}
