//! What `simulate` says: the content of `simulate.json`. Field names are stable; numbers are in the unit that their name ends with.

use super::{Beside, DEGREES, RequirementResult, requirement, results, rounded};
use crate::dwell::{Figures, Outcome};
use crate::eval::Requirement;
use crate::job::{Job, ZernikeOrder};
use crate::metrology::pvr;
use crate::simulate::Difference;
use crate::simulate::as_run::{AsRun, At};
use crate::simulate::contact::Contact;
use serde::Serialize;

/// `simulate.json`.
#[derive(Clone, Debug, Serialize)]
pub struct SimulationResult {
    /// The compiler's version.
    pub polishc: &'static str,
    pub job: String,
    pub part: String,
    /// What was simulated: `plan`, `program` or `run`.
    pub of: &'static str,
    /// The program's files, or the log; empty for a plan and for the job's own program, which is not on a disk.
    pub files: Vec<super::Input>,
    pub predicted: SimulatedResult,
    /// The removal against the plan's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub against_plan: Option<DifferenceResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub program: Option<ContactResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub run: Option<RunResult>,
    /// The job's requirements on the surface, with what was simulated.
    pub requirements: Vec<RequirementResult>,
    pub warnings: Vec<String>,
}

/// The surface before and after, over the clear aperture. RMS about the mean.
#[derive(Clone, Debug, Serialize)]
pub struct SimulatedResult {
    pub rms_before_nm: f64,
    pub pv_before_nm: f64,
    pub rms_nm: f64,
    pub pv_nm: f64,
    /// With 36 Fringe terms; missing where the pixels do not fix them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pvr_fringe36_nm: Option<f64>,
    /// RMS at the frequency of the lines, where most is removed, and their distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ripple_nm: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ripple_period_mm: Option<f64>,
    pub removal_mean_nm: f64,
    pub removal_max_nm: f64,
    /// In contact, process on.
    pub time_s: f64,
}

#[derive(Clone, Debug, Serialize)]
pub struct DifferenceResult {
    /// Positive where more is removed than planned.
    pub most_nm: f64,
    pub x_mm: f64,
    pub y_mm: f64,
    /// Of the plan's largest removal.
    pub share: f64,
    pub rms_nm: f64,
    /// What the plan leaves.
    pub planned_rms_nm: f64,
    pub planned_pv_nm: f64,
}

#[derive(Clone, Debug, Serialize)]
pub struct ContactResult {
    /// Farthest from the nominal height, and from the normal, over the part.
    pub height_um: f64,
    pub lean_deg: f64,
    /// Moves that ask for more than the stated acceleration reaches.
    pub too_fast: usize,
}

/// A place and what was found there, in the unit of the list's name.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PlaceResult {
    pub value: f64,
    pub x_mm: f64,
    pub y_mm: f64,
}

#[derive(Clone, Debug, Serialize)]
pub struct RunResult {
    pub samples: usize,
    pub interval_s: f64,
    pub duration_s: f64,
    /// Part of the samples in contact that lie on the path.
    pub on_path: f64,
    /// Of the recorded point above the surface.
    pub height_mm: f64,
    pub beside_mm: f64,
    pub most_beside_mm: PlaceResult,
    /// Over the clear aperture, of stretches as long as the spot is wide: actual over planned, less 1.
    pub mean_speed_error: f64,
    pub rms_speed_error: f64,
    pub most_speed_error: PlaceResult,
    pub stops_s: Vec<PlaceResult>,
    pub holes_s: Vec<PlaceResult>,
    /// Part of the path over the clear aperture without samples.
    pub missing: f64,
}

fn place(at: &At, scale: f64, decimals: i32) -> PlaceResult {
    let [x, y] = at.place.map(|v| rounded(v * 1e3, 3));
    PlaceResult { value: rounded(at.value * scale, decimals), x_mm: x, y_mm: y }
}

/// Places listed in the result; a run with more of them needs no longer list.
const MOST_PLACES: usize = 100;

/// Puts together what was simulated of a job.
#[allow(clippy::too_many_arguments, reason = "one of each thing that the result speaks of")]
pub fn simulation(
    name: &str,
    job: &Job,
    of: &'static str,
    (outcome, planned): (&Outcome, &Figures),
    difference: Option<&Difference>,
    contact: Option<&Contact>,
    run: Option<&AsRun>,
    requirements: &[Requirement],
) -> SimulationResult {
    let figures = &outcome.figures;
    let nm = |metres: f64| rounded(metres * 1e9, 3);
    let mut results = results(outcome, Beside::default(), &outcome.timed.path, None, None);
    // The stretches of a simulation have points of their own.
    results.remove("program.points");
    let counts = vec![true; outcome.residual.values.len()];
    let robust = pvr(&outcome.residual, &counts, ZernikeOrder::fringe);
    SimulationResult {
        polishc: env!("CARGO_PKG_VERSION"),
        job: name.to_string(),
        part: job.workpiece.part.clone(),
        of,
        files: Vec::new(),
        predicted: SimulatedResult {
            rms_before_nm: nm(figures.before_rms),
            pv_before_nm: nm(figures.before_pv),
            rms_nm: nm(figures.rms),
            pv_nm: nm(figures.pv),
            pvr_fringe36_nm: robust.map(|robust| nm(robust.pvr)),
            ripple_nm: outcome.ripple.map(|ripple| rounded(ripple.rms * 1e9, 4)),
            ripple_period_mm: outcome.ripple.map(|ripple| rounded(ripple.period * 1e3, 4)),
            removal_mean_nm: nm(figures.mean_removal),
            removal_max_nm: nm(figures.greatest_removal),
            time_s: rounded(figures.time, 1),
        },
        against_plan: difference.map(|difference| DifferenceResult {
            most_nm: nm(difference.most),
            x_mm: rounded(difference.place[0] * 1e3, 3),
            y_mm: rounded(difference.place[1] * 1e3, 3),
            share: rounded(difference.share, 6),
            rms_nm: nm(difference.rms),
            planned_rms_nm: nm(planned.rms),
            planned_pv_nm: nm(planned.pv),
        }),
        program: contact.map(|contact| ContactResult {
            height_um: rounded(contact.height * 1e6, 2),
            lean_deg: rounded(contact.lean * DEGREES, 4),
            too_fast: contact.too_fast,
        }),
        run: run.map(|run| RunResult {
            samples: run.samples,
            interval_s: rounded(run.interval, 6),
            duration_s: rounded(run.duration, 3),
            on_path: rounded(run.on_path, 4),
            height_mm: rounded(run.height * 1e3, 3),
            beside_mm: rounded(run.beside * 1e3, 4),
            most_beside_mm: place(&run.most_beside, 1e3, 3),
            mean_speed_error: rounded(run.mean_speed, 5),
            rms_speed_error: rounded(run.rms_speed, 5),
            most_speed_error: place(&run.most_speed, 1.0, 4),
            stops_s: run.stops.iter().take(MOST_PLACES).map(|at| place(at, 1.0, 2)).collect(),
            holes_s: run.holes.iter().take(MOST_PLACES).map(|at| place(at, 1.0, 2)).collect(),
            missing: rounded(run.missing, 5),
        }),
        // What the simulation says nothing of (motion, program) is not its affair.
        requirements: requirements
            .iter()
            .map(|one| requirement(one, &results))
            .filter(|one| one.met != super::Met::Pending)
            .collect(),
        warnings: Vec::new(),
    }
}
