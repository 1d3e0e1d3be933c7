//! Report: what a build says of itself.
//!
//! In: the outcomes of the passes. Out: [`ResultFile`], the content of `result.json`, whose field names are fixed by the
//! command line's page. Numbers are in the unit that their name ends with.

mod simulation;

pub use simulation::{
    ContactResult, DifferenceResult, PlaceResult, RunResult, SimulatedResult, SimulationResult, simulation,
};

use crate::dwell::Outcome;
use crate::eval::Requirement;
use crate::metrology::Figures;
use crate::motion::Motion;
use crate::path::ToolPath;
use crate::target::Program;
use serde::Serialize;
use std::collections::BTreeMap;

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
    /// What the compiler does not check: what the job lists, and what the robot leaves unknown.
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
    /// Solves, one more each time that the arm asked for slower speeds.
    pub rounds: usize,
    pub total_s: f64,
    /// The even layer that the solver took off beside the error.
    pub base_nm: f64,
    /// Depth that the path takes off at the greatest feed.
    pub floor_nm: f64,
    /// Programmed feeds of the segments that reach the clear aperture.
    pub least_feed_mm_s: f64,
    pub greatest_feed_mm_s: f64,
    /// Part of those segments whose time lies at a bound.
    pub at_bounds: f64,
    /// Least distance of the standing tool from the part's edge at the ends of lines.
    pub overrun_mm: f64,
}

/// Figures over the clear aperture: RMS about the mean, PV; `before` is the map as placed, after `subtract`.
#[derive(Clone, Debug, Serialize)]
pub struct Predicted {
    /// Of a dry run: what the figures are about.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speaks_of: Option<&'static str>,
    pub rms_before_nm: f64,
    pub pv_before_nm: f64,
    pub rms_nm: f64,
    pub pv_nm: f64,
    pub removal_mean_nm: f64,
    pub removal_max_nm: f64,
    /// RMS at the frequency of the lines, where most is removed, and their distance. Missing where the clear aperture has no
    /// room to see it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ripple_nm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ripple_period_mm: Option<f64>,
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

const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// What `require` may ask of the surface and the dwell, in SI, by its path without `result.`.
fn results_of(outcome: &Outcome) -> BTreeMap<String, f64> {
    let figures = &outcome.figures;
    let removal = Figures::of(outcome.removal.values.iter().copied());
    let ripple = outcome.ripple.map(|ripple| ("predicted.ripple".to_string(), ripple.rms));
    let all = BTreeMap::from([
        ("predicted.rms".to_string(), figures.rms),
        ("predicted.pv".into(), figures.pv),
        ("predicted.removal.mean".into(), removal.mean),
        ("predicted.removal.rms".into(), removal.rms),
        ("predicted.removal.range".into(), removal.pv),
        ("dwell.time".into(), figures.time),
        ("dwell.base".into(), figures.base),
    ]);
    all.into_iter().chain(ripple).collect()
}

/// What `require` may ask for, in SI, by its path without `result.`.
pub fn results(
    outcome: &Outcome,
    path: &ToolPath,
    motion: Option<&Motion>,
    program: Option<&Program>,
) -> BTreeMap<String, f64> {
    let mut results = results_of(outcome);
    results.insert("program.points".into(), path.points.len() as f64);
    if let Some(motion) = motion {
        let figures = &motion.figures;
        results.extend([
            ("motion.time".to_string(), figures.time),
            ("motion.joint_margin".into(), figures.joint_margin),
            ("motion.wrist_margin".into(), figures.wrist_margin),
            ("motion.largest_joint_step".into(), figures.largest_joint_step),
            ("motion.joint_speed_share".into(), figures.joint_speed_share),
        ]);
    }
    if let Some(program) = program {
        let bytes: usize = program.files.iter().map(|f| f.bytes.len()).sum();
        results.extend([
            ("program.bytes".to_string(), bytes as f64),
            ("program.modules".into(), program.files.len() as f64),
        ]);
    }
    results
}

/// A requirement with what it came to.
pub fn requirement(requirement: &Requirement, results: &BTreeMap<String, f64>) -> RequirementResult {
    let outcome = requirement.evaluate(results);
    RequirementResult {
        text: requirement.text.clone(),
        value: outcome.value.unwrap_or_else(|| "pending".into()),
        met: match outcome.met {
            Some(true) => Met::Yes,
            Some(false) => Met::No,
            None => Met::Pending,
        },
    }
}

/// The program's files.
pub fn programs(program: Option<&Program>) -> Vec<ProgramResult> {
    let files = program.map(|p| p.files.as_slice()).unwrap_or_default();
    files
        .iter()
        .map(|file| ProgramResult {
            file: file.name.clone(),
            bytes: file.bytes.len(),
            points: file.points,
            blake3: blake3::hash(&file.bytes).to_hex().to_string(),
        })
        .collect()
}

/// The path's size.
pub fn path(path: &ToolPath) -> PathResult {
    let mut length = 0.0;
    for line in &path.lines {
        for i in line.points.start + 1..line.points.end {
            let (a, b) = (path.points.position(i - 1), path.points.position(i));
            let d = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            length += (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
        }
    }
    PathResult { points: path.points.len(), lines: path.lines.len(), length_mm: rounded(length * 1e3, 1) }
}

/// The solution.
pub fn dwell(outcome: &Outcome) -> DwellResult {
    let figures = &outcome.figures;
    DwellResult {
        solver: "projected Barzilai-Borwein",
        iterations: figures.iterations,
        rounds: figures.rounds,
        total_s: rounded(figures.time, 1),
        base_nm: rounded(figures.base * 1e9, 3),
        floor_nm: rounded(figures.floor * 1e9, 3),
        least_feed_mm_s: rounded(figures.least_speed * 1e3, 4),
        greatest_feed_mm_s: rounded(figures.greatest_speed * 1e3, 4),
        at_bounds: rounded(figures.at_bounds, 4),
        overrun_mm: rounded(figures.overrun * 1e3, 3),
    }
}

/// The surface before and after.
pub fn predicted(outcome: &Outcome, dry_run: bool) -> Predicted {
    let figures = &outcome.figures;
    Predicted {
        speaks_of: dry_run.then_some("the polishing program; a dry run removes nothing"),
        rms_before_nm: rounded(figures.before_rms * 1e9, 3),
        pv_before_nm: rounded(figures.before_pv * 1e9, 3),
        rms_nm: rounded(figures.rms * 1e9, 3),
        pv_nm: rounded(figures.pv * 1e9, 3),
        removal_mean_nm: rounded(figures.mean_removal * 1e9, 3),
        removal_max_nm: rounded(figures.greatest_removal * 1e9, 3),
        ripple_nm: outcome.ripple.map(|ripple| rounded(ripple.rms * 1e9, 4)),
        ripple_period_mm: outcome.ripple.map(|ripple| rounded(ripple.period * 1e3, 4)),
    }
}

/// The arm.
pub fn motion(motion: &Motion) -> MotionResult {
    let figures = &motion.figures;
    MotionResult {
        time_s: rounded(figures.time, 1),
        joint_margin_deg: rounded(figures.joint_margin * DEGREES, 3),
        largest_joint_step_deg: rounded(figures.largest_joint_step * DEGREES, 4),
        wrist_margin_deg: rounded(figures.wrist_margin * DEGREES, 3),
        joint_speed_share: rounded(figures.joint_speed_share, 4),
        runs: motion.runs.len(),
    }
}
