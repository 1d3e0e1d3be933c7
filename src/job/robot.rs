//! The robot of a job: the arm, and the cell it stands in.
//!
//! Plain structs, one a record, fields named as in the schema; see [`super`].

use super::Empty;
use crate::units::si::*;
use serde::{Deserialize, Serialize};

/// An arm and the cell it stands in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    pub maker: String,
    pub model: String,
    pub arm: Arm,
    /// Exactly six, from the base.
    pub joints: Vec<Joint>,
    pub payload: Mass,
    /// Where it is unknown the load's inertia is not checked, and the result says so.
    pub wrist_inertia: Option<WristInertia>,
    /// Distance that every joint keeps from both ends of its range.
    pub range_margin: Angle,
    /// Least |axis 5|.
    pub wrist_margin: Angle,
    /// Least |sin| of the angle between lower and upper arm.
    pub elbow_margin: f64,
    /// Least distance of the wrist centre from axis 1.
    pub shoulder_margin: Length,
    pub cell: Option<RobotCell>,
}

/// Largest moments of inertia of all that hangs on the flange.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WristInertia {
    /// About axis 5, for the most unfavourable turn of axis 6.
    pub axis_5: Inertia,
    pub axis_6: Inertia,
}

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Arm {
    ortho_parallel(OrthoParallel),
}

/// Ortho-parallel basis with spherical wrist (Brandstötter, Angerer, Hofbaur 2014): the seven lengths, and per joint
/// the offset and sign of `internal = sign * joint - offset`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrthoParallel {
    pub a1: Length,
    pub a2: Length,
    pub b: Length,
    pub c1: Length,
    pub c2: Length,
    pub c3: Length,
    pub c4: Length,
    /// Six.
    pub offsets: Vec<Angle>,
    /// Six, each 1 or -1.
    pub signs: Vec<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    pub range: Range<Angle>,
    pub speed: AngularSpeed,
}

/// Frames, tool, signals and safe poses of one installation. No frame has a default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotCell {
    /// The robot's base in the world.
    pub base: Frame,
    /// The user frame (the table) in the world.
    pub user: Frame,
    /// The part frame in the user frame: the object frame of the programs.
    pub object: Frame,
    pub tcp: TcpNumbers,
    /// Six joint angles.
    pub home: Vec<Angle>,
    /// Further joint poses from which a program may start.
    pub safe_poses: Vec<Vec<Angle>>,
    /// How near each joint must be to home or a safe pose at the start.
    pub home_tolerance: Angle,
    pub travel: Lifted,
    /// Part of the arm's rated joint speeds for moves between home and the part, 0 to 1.
    pub joint_move_speed: f64,
    pub process: Process,
}

/// `at` and `rotation` of this frame in the frame named by the schema.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    pub at: Point,
    pub rotation: Rotation,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    pub x: Length,
    pub y: Length,
    pub z: Length,
}

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Rotation {
    no_rotation(Empty),
    quaternion(Quaternion),
    zyx_intrinsic(ZyxIntrinsic),
}

/// Must be of unit length to 1e-4; it is normalised.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quaternion {
    pub w: f64,
    pub x: f64,
    pub y: f64,
    pub z: f64,
}

/// R = Rz(about_z) Ry(about_y) Rx(about_x).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ZyxIntrinsic {
    pub about_z: Angle,
    pub about_y: Angle,
    pub about_x: Angle,
}

/// Tool frame in the flange frame: origin at the wheel's lowest point, +z out of the tool into the glass.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TcpNumbers {
    /// Of the wheel that `at` was measured with; compared with the job's, where it is given.
    pub wheel_diameter: Option<Length>,
    pub at: Point,
    pub rotation: Rotation,
    pub load: Load,
}

/// What hangs on the flange. Mass and centre have no default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    pub mass: Mass,
    pub centre: Point,
    /// Moments about the centre, along the tool frame's axes.
    pub inertia: Option<LoadInertia>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadInertia {
    pub x: Inertia,
    pub y: Inertia,
    pub z: Inertia,
}

/// Off-part travel: lifted along the normal by `height`, at `speed`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lifted {
    pub height: Length,
    pub speed: Speed,
}

/// How wheel and pump are switched.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Process {
    /// The program stops off the part; the operator switches and confirms.
    manual(Manual),
    /// Named signals, set and confirmed by the program off the part.
    signals(Signals),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manual {
    /// The hardware interlock that drops wheel and pump at a protective stop, as the shop calls it.
    pub interlock: String,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Signals {
    pub interlock: String,
    /// Switched on in this order, off in the reverse order.
    pub outputs: Vec<DigitalOut>,
    /// Waited for after the outputs are on; the program stops when one does not come.
    pub inputs: Vec<DigitalIn>,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Level {
    high,
    low,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DigitalOut {
    pub name: String,
    /// For controllers that know signals by number.
    pub number: Option<i64>,
    pub active: Level,
    /// Waited after switching on.
    pub settle: Time,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DigitalIn {
    pub name: String,
    /// For controllers that know signals by number.
    pub number: Option<i64>,
    pub active: Level,
    pub wait_at_most: Time,
}
