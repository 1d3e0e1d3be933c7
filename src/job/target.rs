//! The target of a job: which language, on which controller.
//!
//! Plain structs, one a record, fields named as in the schema; see [`super`].

use super::Empty;
use crate::units::si::*;
use serde::{Deserialize, Serialize};

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Target {
    rapid(Rapid),
    krl(Krl),
}

/// ABB RAPID.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rapid {
    pub controller: RapidController,
    /// Name of the main module; chunks are named after it.
    pub module: String,
    pub frames: Frames,
    /// Name of the tool data.
    pub tool_name: String,
    /// Name of the work object data.
    pub object_name: String,
    /// With `frames: on_controller`: how far the controller's frames may lie from the job's.
    pub frame_tolerance: Length,
    pub frame_angle_tolerance: Angle,
    pub zone: Zone,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Frames {
    /// Tool and work object live on the controller; the program compares them with the job's and stops if they differ.
    on_controller,
    /// The program declares them.
    in_program,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Zone {
    fine,
    z0,
    z1,
    z5,
}

/// What an ABB controller can take. Values marked unsourced in stdlib stay parameters here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RapidController {
    pub name: String,
    pub name_length: i64,
    pub position_decimals: i64,
    pub quaternion_decimals: i64,
    /// Decimals of a speed in mm/s.
    pub speed_decimals: i64,
    /// Most points in one module.
    pub module_points: i64,
    /// Most bytes in one module.
    pub module_bytes: i64,
    /// A shorter segment is an error.
    pub segment_time_least: Time,
    /// A shorter segment is a warning.
    pub segment_time_usual: Time,
    /// Folder on the controller that the modules are loaded from.
    pub folder: String,
    /// Largest orientation speed while polishing, put into speeddata so that it never limits the path.
    pub orientation_speed: AngularSpeed,
    /// Most points of a job.
    pub most_points: i64,
}

/// KUKA KRL.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Krl {
    pub controller: KrlController,
    /// Name of the main program; sub-programs are named after it.
    pub module: String,
    pub frames: KrlFrames,
    /// How far the controller's frames may lie from the job's.
    pub frame_tolerance: Length,
    pub frame_angle_tolerance: Angle,
    pub motion: LineMotion,
    pub memory: Memory,
}

/// Where tool, base and load come from.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum KrlFrames {
    /// They live on the controller; the program compares them with the job's and stops if they differ.
    on_controller(OnController),
    /// The program declares them.
    in_program(Empty),
}

/// Numbers in TOOL_DATA, BASE_DATA and LOAD_DATA.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OnController {
    pub tool: i64,
    pub base: i64,
    pub load: i64,
}

/// How the points of a line are driven.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LineMotion {
    /// One `SPLINE` block a line.
    spline(Empty),
    /// `LIN` with `C_DIS`.
    linear(Linear),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Linear {
    /// `$APO.CDIS`.
    pub rounding: Length,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Memory {
    resident,
    dir_loader,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Presence {
    absent,
    installed,
}

/// What a KUKA controller can take. Values marked unsourced in stdlib stay parameters here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KrlController {
    pub name: String,
    pub name_length: i64,
    pub position_decimals: i64,
    /// Decimals of A, B and C in degrees.
    pub angle_decimals: i64,
    /// Significant digits of a speed in m/s.
    pub speed_digits: i64,
    pub file_lines: i64,
    pub file_bytes: i64,
    /// Most bytes of a program that is in memory as a whole.
    pub program_bytes: i64,
    /// Most segments of one `SPLINE` block.
    pub block_segments: i64,
    pub dir_loader: Presence,
    /// `$ADVANCE`.
    pub advance: i64,
    /// A shorter segment is an error.
    pub segment_time_least: Time,
    /// A shorter segment is a warning.
    pub segment_time_usual: Time,
    /// Largest orientation speed while polishing, so high that it never limits the path.
    pub orientation_speed: AngularSpeed,
    /// The same for the orientation acceleration.
    pub orientation_acceleration: AngularAcceleration,
    /// Most points of a job.
    pub most_points: i64,
}
