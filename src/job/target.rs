//! The target of a job: which language, on which controller.
//!
//! Plain structs, one a record, fields named as in the schema; see [`super`].

use crate::units::si::*;
use serde::{Deserialize, Serialize};

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Target {
    rapid(Rapid),
}

/// ABB RAPID.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rapid {
    pub controller: Controller,
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

/// What a controller can take. Values marked unsourced in stdlib stay parameters here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Controller {
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
