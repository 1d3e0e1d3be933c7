//! Report: what a build says of itself.
//!
//! In: the outcomes of the passes. Out: [`ResultFile`], the content of `result.json`, whose field names are fixed by the
//! command line's page. Numbers are in the unit that their name ends with.

use serde::Serialize;

/// `result.json`.
#[derive(Clone, Debug, Serialize)]
pub struct ResultFile {
    /// The compiler's version.
    pub polishc: &'static str,
    pub jobs: Vec<JobResult>,
}

/// One job's part of `result.json`.
#[derive(Clone, Debug, Serialize)]
pub struct JobResult {
    pub name: String,
    pub part: String,
    /// `polish` or `dry_run`.
    #[serde(rename = "for")]
    pub purpose: &'static str,
    pub programs: Vec<ProgramResult>,
    pub path: PathResult,
    pub dwell: DwellResult,
    pub predicted: Predicted,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionResult>,
    pub inputs: Vec<Input>,
    pub requirements: Vec<RequirementResult>,
    pub warnings: Vec<String>,
    /// What the compiler does not check, as the job lists it.
    pub unchecked: Vec<&'static str>,
    /// Repeated in every report: no controller has run this program for us.
    pub note: &'static str,
}

#[derive(Clone, Debug, Serialize)]
pub struct ProgramResult {
    pub file: String,
    pub bytes: usize,
    pub points: usize,
    pub blake3: String,
}

#[derive(Clone, Debug, Serialize)]
pub struct PathResult {
    pub points: usize,
    pub lines: usize,
    pub length_mm: f64,
}

#[derive(Clone, Debug, Serialize)]
pub struct DwellResult {
    pub solver: &'static str,
    pub iterations: usize,
    pub total_s: f64,
    /// The even layer that the solver took off beside the error.
    pub base_nm: f64,
    pub shortest_segment_ms: f64,
    pub largest_feed_mm_s: f64,
}

/// Figures over the clear aperture: RMS about the mean, PV; `before` is the map as placed, after `subtract`.
#[derive(Clone, Debug, Serialize)]
pub struct Predicted {
    pub rms_before_nm: f64,
    pub pv_before_nm: f64,
    pub rms_nm: f64,
    pub pv_nm: f64,
    pub removal_mean_nm: f64,
    pub removal_max_nm: f64,
}

#[derive(Clone, Debug, Serialize)]
pub struct MotionResult {
    /// A kinematic estimate.
    pub time_s: f64,
    pub joint_margin_deg: f64,
    pub largest_joint_step_deg: f64,
    pub wrist_margin_deg: f64,
    pub joint_speed_share: f64,
    pub runs: usize,
}

#[derive(Clone, Debug, Serialize)]
pub struct Input {
    pub file: String,
    pub blake3: String,
}

#[derive(Clone, Debug, Serialize)]
pub struct RequirementResult {
    pub text: String,
    pub value: String,
    pub met: Met,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Met {
    Yes,
    No,
    Pending,
}

impl Serialize for Met {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Met::Yes => serializer.serialize_bool(true),
            Met::No => serializer.serialize_bool(false),
            Met::Pending => serializer.serialize_str("pending"),
        }
    }
}

/// `value` with `decimals` digits after the point: what the physics resolves, and the same text on every platform.
pub fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = libm::pow(10.0, f64::from(decimals));
    let rounded = (value * scale).round() / scale;
    if rounded == 0.0 { 0.0 } else { rounded }
}
