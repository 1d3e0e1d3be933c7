//! What the session says of a job's requirements: those that do not hold, and those that look like a slip.
//!
//! In: a [`Planned`] job. Out: diagnostics at the lines of `require`.

use super::Planned;
use crate::diagnostics::codes as code;
use crate::diagnostics::{Diagnostic, Problem};
use crate::eval::Requirement;
use crate::report::{self, Met};
use std::collections::{BTreeMap, BTreeSet};

/// The results that tell how good the surface will be.
const ROUGHLY: [&str; 3] = ["predicted.rms", "predicted.rms_expected", "predicted.rms_p90"];

impl Planned {
    /// A warning of a job that writes a program whatever its plan comes to.
    pub(super) fn required_nothing(&self) -> Option<Problem> {
        (self.requirements.is_empty() && self.job.target.is_some()).then(|| {
            Problem::warning(code::W0736, "", format!("the job `{}` requires nothing of its plan", self.name))
                .help("say what the run is for: `require { result.predicted.rms <= 5 nm }`")
        })
    }

    /// Warnings of requirements that no run of this tool will meet, or any would, from what is known before the dwell is
    /// solved.
    pub(super) fn doubtful(&self) -> Vec<Diagnostic> {
        self.requirements.iter().filter_map(|requirement| self.doubt(requirement)).collect()
    }

    fn doubt(&self, requirement: &Requirement) -> Option<Diagnostic> {
        let prospect = self.prospect.as_ref()?;
        let asked = requirement.results();
        let about_rms = ROUGHLY.iter().any(|name| asked.contains(name));
        if !about_rms && !asked.contains("predicted.pv") {
            return None;
        }
        // The requirement's answer if the run left this.
        let if_left = |rms: f64, pv: f64| {
            let mut results = BTreeMap::from(report::before(prospect));
            results.extend(ROUGHLY.map(|name| (name.to_string(), rms)));
            results.insert("predicted.pv".into(), pv);
            requirement.evaluate(&results)
        };
        let text = &requirement.text;
        let now = if_left(prospect.before_rms, prospect.before_pv);
        if now.met == Some(true) {
            // A condition by a function has no value of its own but `true`.
            let value = now.value.filter(|value| value != "true");
            let value = value.map(|value| format!(" (it is {value})")).unwrap_or_default();
            return Some(
                Diagnostic::warning(
                    code::W0735,
                    requirement.span,
                    format!("the surface meets `{text}` before the run{value}"),
                )
                .help("write the limit that the part is polished for"),
            );
        }
        // A peak to valley has no bound that is known beforehand.
        let best = if_left(prospect.best_rms, 0.0);
        if about_rms && best.met == Some(false) && if_left(0.0, 0.0).met == Some(true) {
            let value = prospect.best_rms * 1e9;
            return Some(
                Diagnostic::warning(
                    code::W0734,
                    requirement.span,
                    format!("`{text}` is less than the tool can be hoped to reach, which is about {value:.3} nm RMS"),
                )
                .note(self.reasons_of_best())
                .help("use a narrower spot, take off a larger part of the error, or ask for what can be had"),
            );
        }
        None
    }

    /// What the least residual is made of.
    fn reasons_of_best(&self) -> String {
        let Some(prospect) = &self.prospect else { return String::new() };
        let crate::job::Dwell::corrective(dwell) = &self.job.dwell;
        let correctable = &prospect.correctable;
        let finer = format!(
            "{:.3} nm RMS of the error have periods below {:.2} mm and cost ten times their height in glass; {:.3} nm of them no \
             run follows",
            correctable.finer_rms * 1e9,
            correctable.period * 1e3,
            correctable.least_rms * 1e9
        );
        let left = 1.0 - dwell.removal_fraction;
        if left > 0.0 {
            let all = prospect.before_rms * prospect.before_rms - correctable.least_rms * correctable.least_rms;
            let kept = left * all.max(0.0).sqrt();
            format!("{finer}; {:.3} nm RMS are the {:.0} % that `removal_fraction` leaves", kept * 1e9, left * 1e2)
        } else {
            finer
        }
    }

    /// Errors for the requirements that do not hold, or cannot be known.
    pub(super) fn unmet(&self) -> Vec<Diagnostic> {
        // Requirements hold a program back; where there is nothing to polish there is none.
        let Some(result) = self.result.as_ref().filter(|_| self.nothing().is_none()) else { return Vec::new() };
        let mut diagnostics = Vec::new();
        for (requirement, found) in self.requirements.iter().zip(&result.requirements) {
            match found.met {
                Met::Yes => {}
                Met::No => {
                    let mut diagnostic = Diagnostic::error(
                        code::E1101,
                        requirement.span,
                        format!("the job requires `{}`, and the plan gives {}", found.text, found.value),
                    );
                    let doubted = self.doubt(requirement).is_some();
                    for reason in self.reasons(&requirement.results(), doubted) {
                        diagnostic = diagnostic.note(reason);
                    }
                    diagnostics.push(
                        diagnostic.help("change the plan, or the requirement if it asks for more than the part needs"),
                    );
                }
                Met::Pending => diagnostics.push(
                    Diagnostic::error(
                        code::E1102,
                        requirement.span,
                        format!("the requirement `{}` speaks of a result that this job does not have", found.text),
                    )
                    .help(self.source_of(&requirement.results())),
                ),
            }
        }
        diagnostics
    }

    /// What limits the residual, where a requirement speaks of it.
    fn reasons(&self, asked: &BTreeSet<&str>, doubted: bool) -> Vec<String> {
        let mut reasons = Vec::new();
        let of_surface = ROUGHLY.iter().any(|name| asked.contains(name)) || asked.contains("predicted.pv");
        let (Some(outcome), Some(prospect), true) = (&self.dwell, &self.prospect, of_surface) else { return reasons };
        let expected = ["predicted.rms_expected", "predicted.rms_p90"].iter().any(|name| asked.contains(name));
        if let (true, Some(expected)) = (expected, &self.expected) {
            let parts: Vec<String> = expected
                .shares
                .iter()
                .map(|share| format!("`{}` adds {:.3} nm", share.source, share.rms * 1e9))
                .collect();
            reasons.push(format!(
                "in squares, to {:.3} nm of the ideal run, {}",
                outcome.figures.rms * 1e9,
                parts.join(", ")
            ));
        }
        // Where that is the whole reason, the warning beside has said it.
        if !doubted {
            reasons.push(self.reasons_of_best());
        }
        if outcome.figures.at_bounds > 0.1 {
            reasons.push(format!(
                "{:.0} % of the moves over the clear aperture run at an end of the feed",
                outcome.figures.at_bounds * 1e2
            ));
        }
        if prospect.reach.pixels > 0 {
            reasons.push(format!("the path does not reach {:.2} mm² of the clear aperture", prospect.reach.area * 1e6));
        }
        reasons
    }

    /// What a job must say to have the results that are missing.
    fn source_of(&self, asked: &BTreeSet<&str>) -> &'static str {
        let known = self.known();
        let missing: Vec<&str> = asked.iter().copied().filter(|name| !known.contains_key(*name)).collect();
        if missing.iter().any(|name| ROUGHLY.contains(name)) {
            "give the job its `uncertainty`, which the figure comes from, or take the line out"
        } else if missing.contains(&"stock.radius_change") {
            "the form states no vertex radius: ask for `result.stock.power`, or take the line out"
        } else if missing.contains(&"predicted.pvr") {
            "say which Zernike polynomials, as by `figures: { zernike: fringe }`, or take the line out"
        } else if missing.contains(&"predicted.slope_rms") {
            "say over which length, as by `figures: { slope_length: 2 mm }`, or take the line out"
        } else if missing.contains(&"predicted.band_rms") {
            "say of which periods, as by `figures: { band: 1 mm .. 10 mm }`, or take the line out"
        } else {
            "give the job the `robot` and `target` that the result comes from, or take the line out"
        }
    }
}
