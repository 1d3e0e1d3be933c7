//! How well spots agree, and how the rate drifts with the age of what polishes.
//!
//! In: volume and peak rate of each spot, and when it was made on a clock of the process. Out: the spread of the spots, the drift
//! of their rate, and what the mean is multiplied with so that it holds at the start of the run. A clock of the process (hours of
//! the fluid, of the pad, of polishing) is read off the machine and stated by the job: a compiler that read the date would give
//! another program tomorrow.

use crate::diagnostics::{Problem, codes};
use crate::job::Ageing;

/// What is known of one spot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotFigures {
    pub volume_rate: f64,
    pub peak_rate: f64,
    /// Reading of the process clock, seconds.
    pub clock: Option<f64>,
}

/// How well the spots agree. Parts of the mean, one standard deviation of a single spot; with a drift that is known, about its
/// line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    pub spots: usize,
    /// Of the volume rate: what the gain of a run is known to. `None` where two spots make the line of the drift, and none is
    /// left to tell how well.
    pub volume: Option<f64>,
    pub peak: Option<f64>,
    /// Change of the rate in a second of the process clock, in parts of the rate at the start of the run; `None` without clocks.
    pub drift: Option<f64>,
}

/// A gain that is wrong by a tenth leaves a tenth of the error: spots that differ by more are no basis for a better run.
const WIDE_SPREAD: f64 = 0.1;

/// From this part on, what is carried on from the spots to the start of the run is worth a look.
const LONG_CARRY: f64 = 0.05;

/// The factor on the mean, and the spread. Fields are within `tool.influence`.
///
/// # Errors
/// E0657 if the spots are older than the job allows, or do not say how old they are.
pub(super) fn of(
    spots: &[SpotFigures],
    ageing: Option<&Ageing>,
    warnings: &mut Vec<Problem>,
) -> Result<(f64, Option<Spread>), Problem> {
    let clocks = clocks(spots, ageing)?;
    let count = spots.len() as f64;
    let mean = |value: &dyn Fn(usize) -> f64| (0..spots.len()).map(value).sum::<f64>() / count;
    let (volume, peak) = (mean(&|i| spots[i].volume_rate), mean(&|i| spots[i].peak_rate));
    // The line of the volume rate over the clock, by least squares, if there are two times at least.
    let (mut scale, mut drift, mut slope): (f64, Option<f64>, f64) = (1.0, None, 0.0);
    let middle = clocks.as_ref().map_or(0.0, |clocks| mean(&|i| clocks[i]));
    if let (Some(clocks), Some(ageing)) = (&clocks, ageing) {
        let square = mean(&|i| (clocks[i] - middle) * (clocks[i] - middle));
        if square > 0.0 {
            slope = mean(&|i| (clocks[i] - middle) * (spots[i].volume_rate / volume - 1.0)) / square;
            scale = 1.0 + slope * (ageing.now.0 - middle);
            if !(scale > 0.0) {
                let message = "carried on to the start of the run, the drift of the spots leaves no removal";
                return Err(Problem::error(codes::E0657, "ageing.now", message).help("polish a new spot"));
            }
            drift = Some(slope / scale);
        }
    }
    if (scale - 1.0).abs() > LONG_CARRY {
        let message = format!(
            "the drift of the spots carries the rate {:+.1} % from their mean to the start of the run",
            (scale - 1.0) * 100.0
        );
        warnings.push(
            Problem::warning(codes::W0602, "ageing", message)
                .note(format!("it changes by {:+.3} % an hour", drift.unwrap_or(0.0) * 3600.0 * 100.0))
                .help("polish a spot nearer to the run"),
        );
    }
    if spots.len() == 1 {
        return Ok((scale, None));
    }
    // About the line, which takes a degree of freedom of its own.
    let free = spots.len() - if drift.is_some() { 2 } else { 1 };
    let about = |of: f64, value: &dyn Fn(usize) -> f64| {
        let left = |i: usize| value(i) / of - 1.0 - clocks.as_ref().map_or(0.0, |clocks| slope * (clocks[i] - middle));
        (free > 0).then(|| ((0..spots.len()).map(|i| left(i) * left(i)).sum::<f64>() / free as f64).sqrt())
    };
    let spread = Spread {
        spots: spots.len(),
        volume: about(volume, &|i| spots[i].volume_rate),
        peak: about(peak, &|i| spots[i].peak_rate),
        drift,
    };
    if let Some(wide) = spread.volume.filter(|spread| *spread > WIDE_SPREAD) {
        let message = format!(
            "the volume rates of the {} spots differ: one standard deviation is {:.1} %",
            spots.len(),
            wide * 1e2
        );
        warnings.push(
            Problem::warning(codes::W0603, "spots", message)
                .note("so much of the error will stay, whatever the plan says")
                .help("find out why, or polish the spots again"),
        );
    }
    Ok((scale, Some(spread)))
}

/// The spots' readings, if the job states an age; checked against it.
fn clocks(spots: &[SpotFigures], ageing: Option<&Ageing>) -> Result<Option<Vec<f64>>, Problem> {
    let stated: Vec<f64> = spots.iter().filter_map(|spot| spot.clock).collect();
    let Some(ageing) = ageing else {
        if let Some(i) = spots.iter().position(|spot| spot.clock.is_some()) {
            let message = "a spot states its `clock`, and the influence function no `ageing` to compare it with";
            return Err(Problem::error(codes::E0657, format!("spots.{i}.clock"), message)
                .help("add `ageing: { now: …, at_most: … }`, or take `clock` out"));
        }
        return Ok(None);
    };
    if let Some(i) = spots.iter().position(|spot| spot.clock.is_none()) {
        let message = "the influence function has an `ageing`, and a spot does not state its `clock`";
        return Err(Problem::error(codes::E0657, format!("spots.{i}"), message)
            .help("say of every spot what the process clock read when it was made"));
    }
    // Spots made later belong to it, too, where one was made before: what was measured on both sides of a run tells the rate in it.
    let first = stated.iter().copied().fold(f64::INFINITY, f64::min);
    if first > ageing.now.0 {
        let message = format!(
            "the first spot was made at {:.2} h on the process clock, after the run starts at {:.2} h",
            first / 3600.0,
            ageing.now.0 / 3600.0
        );
        return Err(Problem::error(codes::E0657, "spots", message)
            .help("correct the readings, or `ageing.now`: a spot must be made before the run"));
    }
    let youngest = stated.iter().map(|clock| (ageing.now.0 - clock).abs()).fold(f64::INFINITY, f64::min);
    if youngest > ageing.at_most.0 {
        let message = format!(
            "the youngest spot is {:.2} h old at the start of the run, and may be {:.2} h",
            youngest / 3600.0,
            ageing.at_most.0 / 3600.0
        );
        return Err(Problem::error(codes::E0657, "ageing", message).help("polish a new spot"));
    }
    Ok(Some(stated))
}
