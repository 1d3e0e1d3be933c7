//! The short report: what a plan comes to, in a few lines, for `check` and `build`.
//!
//! In: a [`JobResult`]. Out: lines of text, each with a word in front that says what it speaks of.

use crate::report::{JobResult, Met, Predicted};

/// The lines of one job.
pub fn lines(result: &JobResult) -> Vec<String> {
    let mut lines = Vec::new();
    let mut say = |word: &str, text: String| lines.push(format!("  {word:<9}  {text}"));
    if let Some(region) = &result.path.region {
        let (area, coverage) = (1e2 * region.area_share, 1e2 * region.coverage);
        let farthest = region.farthest_mm;
        say(
            "region",
            format!(
                "{area:.1} % of the area, {coverage:.2} % of it within a hexagon of the path, {farthest:.1} mm at most away"
            ),
        );
    }
    if result.purpose == "dry_run" {
        say("dry run", "lifted along the normals, slow, process off: it removes nothing".into());
    } else {
        tell_surface(result, &mut say);
    }
    if let Some(motion) = &result.motion {
        let margin = motion.joint_margin_deg;
        let time = hours(motion.time_s);
        say("motion", format!("{time}, every joint at least {margin:.1} deg inside its range (kinematic estimate)"));
    }
    for requirement in &result.requirements {
        let word = match requirement.met {
            Met::Yes => "met",
            Met::No => "not met",
            Met::Pending => "pending",
        };
        say(word, format!("{} (is {})", requirement.text, requirement.value));
    }
    lines
}

fn tell_surface(result: &JobResult, say: &mut impl FnMut(&str, String)) {
    let Some(dwell) = &result.dwell else { return };
    if let Some(landings) = &dwell.landings {
        let (count, depth) = (landings.count, short(landings.depth_nm));
        say("landings", format!("{count} times down on the part or up from it, each removes {depth} nm at most"));
    }
    let predicted = &result.predicted;
    if let Some(correctable) = &result.correctable {
        say(
            "tool",
            format!(
                "follows periods above {:.1} mm, {} nm RMS of the error; {} nm are finer; at best {} nm stay",
                correctable.period_mm,
                short(correctable.rms_nm),
                short(correctable.finer_rms_nm),
                short(correctable.best_rms_nm)
            ),
        );
    }
    if let Some(reach) = result.reach.as_ref().filter(|reach| reach.missed_pixels > 0) {
        let (area, left) = (short(reach.missed_mm2), short(reach.missed_left_nm));
        say("missed", format!("{area} mm² of the clear aperture, where up to {left} nm stay"));
    }
    say(
        "predicted",
        format!(
            "RMS {} -> {} nm, PV {} -> {} nm, {} nm removed in the mean",
            short(predicted.rms_before_nm),
            short(predicted.rms_nm),
            short(predicted.pv_before_nm),
            short(predicted.pv_nm),
            short(predicted.removal_mean_nm)
        ),
    );
    say("expected", expected(predicted));
    if let Some(stock) = &result.stock {
        let mut text = format!(
            "{} nm even layer beside the error (full feed takes {} nm), {} nm at most, {} mm³, power {} nm",
            short(dwell.base_nm),
            short(dwell.floor_nm),
            short(stock.depth_nm),
            small(stock.volume_mm3),
            short(stock.power_nm)
        );
        if let Some(change) = stock.radius_change_um {
            text += &format!(", radius {change:+.3} um");
        }
        say("stock", text);
    }
    say("dwell", format!("{} on the part", hours(dwell.total_s)));
}

/// The honest prediction, with what limits it; or why there is none.
fn expected(predicted: &Predicted) -> String {
    let (Some(rms), Some(most)) = (predicted.rms_expected_nm, predicted.rms_p90_nm) else {
        return "not known: the job states no `uncertainty`".into();
    };
    let mut text = format!("RMS {} nm, 90 % of runs below {} nm", short(rms), short(most));
    let largest = predicted.contributions.iter().reduce(|a, b| if b.share > a.share { b } else { a });
    if let Some(largest) = largest {
        let name = match largest.source {
            "ideal" => "the ideal residual",
            "gain" => "the error of the rate",
            "drift" => "the drift of the rate",
            "registration" => "the place of the removal on the map",
            "map_noise" => "the noise of the map",
            "position" => "the error of the arm's place",
            _ => "the error of the feed",
        };
        text += &format!("; {name} is the largest share, {:.0} %", largest.share * 1e2);
    }
    if !predicted.not_stated.is_empty() {
        text += &format!("; not stated: {}", predicted.not_stated.join(", "));
    }
    text
}

/// A figure with about three digits, so that a small one is not told as 0.0.
pub fn short(value: f64) -> String {
    let size = value.abs();
    let decimals = if size >= 100.0 {
        0
    } else if size >= 1.0 {
        1
    } else {
        3
    };
    format!("{value:.decimals$}")
}

/// The same for figures that may be much smaller than 1: three digits.
fn small(value: f64) -> String {
    if value.abs() >= 1.0 || value == 0.0 { short(value) } else { crate::units::format::significant(value, 3) }
}

/// A time as a person tells it: 1 h 12 min, or 26.8 min.
pub fn hours(seconds: f64) -> String {
    let minutes = (seconds / 60.0).round() as u64;
    if minutes >= 60 {
        format!("{} h {} min", minutes / 60, minutes % 60)
    } else {
        format!("{:.1} min", seconds / 60.0)
    }
}
