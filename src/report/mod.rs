//! Report: what a build says of itself.
//!
//! In: the outcomes of the passes. Out: [`ResultFile`], the content of `result.json`, whose field names are fixed by the
//! command line's page. Numbers are in the unit that their name ends with.

pub mod metrology;
mod region;
mod simulation;

pub use region::{RegionResult, nothing, region, results_of_nothing, untouched};
pub use simulation::{
    ContactResult, DifferenceResult, PlaceResult, RunResult, SimulatedResult, SimulationResult, simulation,
};

use crate::dwell::{Choice, Outcome};
use crate::eval::Requirement;
use crate::forecast::{Expected, Prospect, Stock};
use crate::job::Uncertainty;
use crate::metrology::Figures;
use crate::motion::Motion;
use crate::path::ToolPath;
use crate::target::Program;
use crate::tool::Spread;
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
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cycle: Option<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
    pub programs: Vec<ProgramResult>,
    /// Why there is no program: no place stands too high.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nothing_to_polish: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metrology: Option<metrology::MetrologyResult>,
    pub path: PathResult,
    /// Of a run; where there is nothing to polish there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dwell: Option<DwellResult>,
    pub predicted: Predicted,
    pub correctable: Option<CorrectableResult>,
    pub reach: Option<ReachResult>,
    pub stock: Option<StockResult>,
    /// Of a tool that was measured by several spots.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spots: Option<SpotsResult>,
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

/// How well the spots of an influence function agree: one standard deviation of a spot, as a part of the mean.
#[derive(Clone, Debug, Serialize)]
pub struct SpotsResult {
    pub spots: usize,
    pub volume_spread: Option<f64>,
    pub peak_spread: Option<f64>,
    /// Change of the rate in an hour of the process clock, as a part of the rate at the start of the run.
    pub drift_per_hour: Option<f64>,
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
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<RegionResult>,
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
    /// Where the tool comes down onto the part, or goes up from it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landings: Option<LandingResult>,
}

/// What landing on the part does, taken into the solved dwell.
#[derive(Clone, Debug, Serialize)]
pub struct LandingResult {
    /// How often the tool comes down or goes up where its spot touches the part.
    pub count: usize,
    /// How long each of them counts as standing.
    pub standing_s: f64,
    /// What one of them removes at most.
    pub depth_nm: f64,
}

/// Figures over the clear aperture: RMS about the mean, PV; `before` is the map as placed, after `subtract`.
#[derive(Clone, Debug, Default, Serialize)]
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
    /// Root of the mean square over many runs with the errors that the job states; nothing where it states none.
    pub rms_expected_nm: Option<f64>,
    /// 90 % of such runs stay below this.
    pub rms_p90_nm: Option<f64>,
    /// What each stated error adds in squares, the ideal residual first: what limits this run.
    pub contributions: Vec<Contribution>,
    /// The errors of `uncertainty` that the job does not state; they count as nothing.
    pub not_stated: Vec<&'static str>,
}

/// One part of the expected residual.
#[derive(Clone, Debug, Serialize)]
pub struct Contribution {
    /// `ideal`, or the field of `uncertainty`.
    pub source: &'static str,
    pub rms_nm: f64,
    /// Its part of the expected mean square.
    pub share: f64,
}

/// The error against the tool's transfer function, over the clear aperture.
#[derive(Clone, Debug, Serialize)]
pub struct CorrectableResult {
    /// Ripples shorter than this are finer than the tool.
    pub period_mm: f64,
    pub rms_nm: f64,
    pub finer_rms_nm: f64,
    /// The least RMS that a run can be hoped to leave.
    pub best_rms_nm: f64,
}

/// The path against the clear aperture.
#[derive(Clone, Debug, Serialize)]
pub struct ReachResult {
    /// Pixels as the solver sees them that no part of the path reaches, their area, and the one that keeps most.
    pub missed_pixels: usize,
    pub missed_mm2: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missed_at_mm: Option<[f64; 2]>,
    /// What stays there at most.
    pub missed_left_nm: f64,
    /// The path's least strength against its mean.
    pub least_strength: f64,
    /// The most that the fastest run takes off beyond error and allowed layer, and where.
    pub excess_nm: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub excess_at_mm: Option<[f64; 2]>,
}

/// The glass that goes, over the clear aperture.
#[derive(Clone, Debug, Serialize)]
pub struct StockResult {
    pub depth_nm: f64,
    pub volume_mm3: f64,
    /// Sag of the removal's best-fit sphere; positive makes the surface more concave.
    pub power_nm: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_change_um: Option<f64>,
}

/// What is said beside the solution: of the run before it was solved, and of what will come of it.
#[derive(Clone, Copy, Default)]
pub struct Beside<'a> {
    pub prospect: Option<&'a Prospect>,
    pub stock: Option<&'a Stock>,
    pub expected: Option<&'a Expected>,
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

/// What `require` may ask for, in SI, by its path without `result.`.
pub fn results(
    outcome: &Outcome,
    beside: Beside,
    path: &ToolPath,
    motion: Option<&Motion>,
    program: Option<&Program>,
) -> BTreeMap<String, f64> {
    let figures = &outcome.figures;
    let removal = Figures::of(outcome.removal.values.iter().copied());
    let mut results = BTreeMap::from([
        ("predicted.rms".to_string(), figures.rms),
        ("predicted.pv".into(), figures.pv),
        ("predicted.removal.mean".into(), removal.mean),
        ("predicted.removal.rms".into(), removal.rms),
        ("predicted.removal.range".into(), removal.pv),
        ("dwell.time".into(), figures.time),
        ("dwell.base".into(), figures.base),
        ("dwell.floor".into(), figures.floor),
        ("program.points".into(), path.points.len() as f64),
    ]);
    results.extend(path.region.iter().flat_map(region::results));
    results.extend(outcome.ripple.map(|ripple| ("predicted.ripple".to_string(), ripple.rms)));
    if let Some(expected) = beside.expected {
        results.extend([
            ("predicted.rms_expected".to_string(), expected.rms),
            ("predicted.rms_p90".into(), expected.rms_p90),
        ]);
    }
    if let Some(prospect) = beside.prospect {
        results.extend(before(prospect));
    }
    if let Some(stock) = beside.stock {
        results.extend([
            ("stock.depth".to_string(), stock.depth),
            ("stock.volume".into(), stock.volume),
            ("stock.power".into(), stock.power),
        ]);
        results.extend(stock.radius_change.map(|change| ("stock.radius_change".to_string(), change)));
    }
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

/// Those of them that are known before the run is solved.
pub fn before(prospect: &Prospect) -> [(String, f64); 6] {
    [
        ("correctable.period".to_string(), prospect.correctable.period),
        ("correctable.rms".into(), prospect.correctable.rms),
        ("correctable.finer".into(), prospect.correctable.finer_rms),
        ("correctable.best".into(), prospect.best_rms),
        ("reach.missed".into(), prospect.reach.area),
        ("reach.excess".into(), prospect.reach.excess),
    ]
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
    PathResult {
        points: path.points.len(),
        lines: path.lines.len(),
        length_mm: rounded(length * 1e3, 1),
        region: path.region.as_ref().map(region),
    }
}

/// The solution.
pub fn dwell(outcome: &Outcome) -> DwellResult {
    let figures = &outcome.figures;
    DwellResult {
        solver: "projected quasi-Newton",
        iterations: figures.iterations,
        rounds: figures.rounds,
        total_s: rounded(figures.time, 1),
        base_nm: rounded(figures.base * 1e9, 3),
        floor_nm: rounded(figures.floor * 1e9, 3),
        least_feed_mm_s: rounded(figures.least_speed * 1e3, 4),
        greatest_feed_mm_s: rounded(figures.greatest_speed * 1e3, 4),
        at_bounds: rounded(figures.at_bounds, 4),
        overrun_mm: rounded(figures.overrun * 1e3, 3),
        landings: (figures.landings > 0).then(|| LandingResult {
            count: figures.landings,
            standing_s: rounded(figures.landing_time, 4),
            depth_nm: rounded(figures.landing_depth * 1e9, 3),
        }),
    }
}

/// What the tool can follow.
pub fn correctable(prospect: &Prospect) -> CorrectableResult {
    CorrectableResult {
        period_mm: rounded(prospect.correctable.period * 1e3, 2),
        rms_nm: rounded(prospect.correctable.rms * 1e9, 3),
        finer_rms_nm: rounded(prospect.correctable.finer_rms * 1e9, 3),
        best_rms_nm: rounded(prospect.best_rms * 1e9, 3),
    }
}

/// What the path leaves out.
pub fn reach(prospect: &Prospect) -> ReachResult {
    let reach = &prospect.reach;
    let place = |[x, y]: [f64; 2]| [rounded(x * 1e3, 2), rounded(y * 1e3, 2)];
    ReachResult {
        missed_pixels: reach.pixels,
        missed_mm2: rounded(reach.area * 1e6, 3),
        missed_at_mm: (reach.pixels > 0).then(|| place(reach.place)),
        missed_left_nm: rounded(reach.left * 1e9, 3),
        least_strength: rounded(reach.least_strength, 4),
        excess_nm: rounded(reach.excess * 1e9, 3),
        excess_at_mm: (reach.excess > 0.0).then(|| place(reach.excess_place)),
    }
}

/// The glass that goes.
pub fn stock(stock: &Stock) -> StockResult {
    StockResult {
        depth_nm: rounded(stock.depth * 1e9, 3),
        volume_mm3: rounded(stock.volume * 1e9, 6),
        power_nm: rounded(stock.power * 1e9, 3),
        radius_change_um: stock.radius_change.map(|change| rounded(change * 1e6, 3)),
    }
}

fn contributions(ideal: f64, expected: &Expected) -> Vec<Contribution> {
    let all = std::iter::once(("ideal", ideal)).chain(expected.shares.iter().map(|share| (share.source, share.rms)));
    all.map(|(source, rms)| Contribution {
        source,
        rms_nm: rounded(rms * 1e9, 3),
        share: rounded(rms * rms / (expected.rms * expected.rms), 4),
    })
    .collect()
}

/// Content of `NAME.pareto.json`.
#[derive(Clone, Debug, Serialize)]
pub struct ParetoResult {
    pub job: String,
    /// What the figures are.
    pub speaks_of: &'static str,
    /// The least residual first.
    pub rows: Vec<ParetoRow>,
}

#[derive(Clone, Debug, Serialize)]
pub struct ParetoRow {
    /// On the lines, without the ways between them.
    pub time_s: f64,
    pub rms_nm: f64,
    pub pv_nm: f64,
    pub base_nm: f64,
}

/// Residual against machine time.
pub fn pareto(job: &str, rows: &[Choice]) -> ParetoResult {
    let row = |choice: &Choice| ParetoRow {
        time_s: rounded(choice.time, 1),
        rms_nm: rounded(choice.rms * 1e9, 4),
        pv_nm: rounded(choice.pv * 1e9, 3),
        base_nm: rounded(choice.base * 1e9, 2),
    };
    ParetoResult {
        job: job.into(),
        speaks_of: "what is left of the part of the error that the run is to take off, by the solver's own grid",
        rows: rows.iter().map(row).collect(),
    }
}

/// The surface before and after.
pub fn predicted(
    outcome: &Outcome,
    expected: Option<&Expected>,
    stated: Option<&Uncertainty>,
    dry_run: bool,
) -> Predicted {
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
        rms_expected_nm: expected.map(|expected| rounded(expected.rms * 1e9, 3)),
        rms_p90_nm: expected.map(|expected| rounded(expected.rms_p90 * 1e9, 3)),
        contributions: expected.map(|expected| contributions(figures.rms, expected)).unwrap_or_default(),
        not_stated: stated.cloned().unwrap_or_default().not_stated(),
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

/// How well spots agree; to a hundredth of a per cent, which is closer than any repeat.
pub fn spots(spread: Spread) -> SpotsResult {
    let part = |value: Option<f64>| value.map(|value| rounded(value, 4));
    SpotsResult {
        spots: spread.spots,
        volume_spread: part(spread.volume),
        peak_spread: part(spread.peak),
        drift_per_hour: part(spread.drift.map(|drift| drift * 3600.0)),
    }
}
