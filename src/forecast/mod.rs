//! Forecast: what a corrective run can reach, before it is solved, and what will honestly come of it, after.
//!
//! In: the [`Task`] of a run; afterwards its solved [`Outcome`](crate::dwell::Outcome), the nominal surface, and the job's
//! `uncertainty`. Out: a [`Prospect`] (what the tool cannot follow, what the path does not reach), the [`Stock`] that goes,
//! and the [`Expected`] residual with what limits it. A solver's residual is what would come of a perfect rate, arm and
//! map; a user decides by what will come of his own.

mod correctable;
mod expected;
mod random;
mod reach;
mod stock;
mod transfer;

pub use correctable::Correctable;
pub use expected::{Expected, Run, Share, expect};
pub use reach::Reach;
pub use stock::{Stock, stock};
pub use transfer::Transfer;

use crate::diagnostics::{Problem, codes};
use crate::dwell::field::Field;
use crate::dwell::removal::{Removal, Samples};
use crate::dwell::{Footprint, Task, cosines, floor_depth};
use crate::job::Piston;

/// What can be said of a run before it is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prospect {
    /// RMS of the error map over the clear aperture, about its mean, and its peak to valley.
    pub before_rms: f64,
    pub before_pv: f64,
    pub correctable: Correctable,
    pub reach: Reach,
    /// The least RMS that can be hoped for, metres: the part that is not to be taken off, with what is finer than the tool can
    /// follow.
    pub best_rms: f64,
}

/// Looks at a run before it is solved and warns of what stands against it. `None` where the map does not cover the clear
/// aperture, its pixels are too coarse, or the feed is no feed: the solver says so.
pub fn prospect(task: &Task, warnings: &mut Vec<Problem>) -> Option<Prospect> {
    let dwell = task.dwell;
    let numbers = [dwell.feed.from.0, dwell.feed.to.0, dwell.acceleration.0, dwell.removal_fraction];
    if !numbers.iter().all(|number| *number > 0.0 && number.is_finite()) {
        return None;
    }
    let mut footprint = Footprint::over(task.influence, task.azimuth);
    footprint.standoff = task.standoff;
    let field = Field::new(task.error, task.clear).ok()?;
    // The pixels of the solver: the spot smooths away everything finer.
    let coarse = field.binned(footprint.sigma / 4.0);
    // Such a map is refused before it is solved (E0706), and a path cut into parts of so small a spot might not fit into memory.
    if field.window.pixel.iter().any(|side| *side > footprint.sigma / 2.0) {
        return None;
    }
    let mut operator = Removal::new(&Samples::segments(&task.path, footprint.sigma / 2.0), &footprint, coarse.window);
    if !task.surface.is_plane() {
        operator = operator.on_slopes(cosines(task.surface, &coarse.window));
    }
    let correctable = Correctable::of(&field, &footprint);
    let reach = Reach::of(task, &coarse, &footprint, &mut operator);
    let best_rms = correctable.left(dwell.removal_fraction);
    let highest = field.greatest();
    let inside =
        || field.values.iter().zip(&field.weights).filter(|(_, weight)| **weight > 0.0).map(|(value, _)| *value);
    let before_pv = inside().fold(f64::NEG_INFINITY, f64::max) - inside().fold(f64::INFINITY, f64::min);
    let prospect = Prospect { before_rms: field.rms(), before_pv, correctable, reach, best_rms };
    warn(task, &footprint, &prospect, highest, warnings);
    Some(prospect)
}

/// One sigma beyond the clear aperture a path that ends there works at its rim with the share of a normal distribution below
/// one sigma: 84 %. The study of the rim found the residual twenty times as large without that sigma and no better with two.
const RIM_STRENGTH: f64 = 0.84;

fn warn(task: &Task, footprint: &Footprint, prospect: &Prospect, highest: f64, warnings: &mut Vec<Problem>) {
    let Prospect { correctable, reach, .. } = prospect;
    // More of the error's power is finer than the tool than the tool can follow.
    if correctable.finer_rms > correctable.rms {
        let message = format!(
            "most of the error is finer than the tool can follow: {:.3} nm RMS of {:.3} nm have periods below {:.2} mm",
            correctable.finer_rms * 1e9,
            prospect.before_rms * 1e9,
            correctable.period * 1e3
        );
        warnings.push(
            Problem::warning(codes::W0730, "workpiece.error", message)
                .note("no dwell of this spot takes that off; a run leaves it as it is")
                .help("use a narrower spot, or look whether the map's noise is what you see"),
        );
    }
    // A path over a region leaves the rest as it is, and says itself how well it covers the region.
    let everywhere = task.path.region.is_none();
    if everywhere && reach.pixels > 0 {
        let [x, y] = reach.place;
        let message = format!(
            "the path does not reach {:.2} mm² of the clear aperture, around x {:.2} mm, y {:.2} mm: up to {:.3} nm stay there",
            reach.area * 1e6,
            x * 1e3,
            y * 1e3,
            reach.left * 1e9
        );
        warnings.push(
            Problem::warning(codes::W0731, "path", message)
                .help("let the path reach them, or make `clear` what must be good"),
        );
    } else if everywhere && reach.least_strength < RIM_STRENGTH {
        let [x, y] = reach.weakest;
        let message = format!(
            "at x {:.2} mm, y {:.2} mm of the clear aperture the path works with {:.0} % of its usual strength",
            x * 1e3,
            y * 1e3,
            reach.least_strength * 1e2
        );
        warnings.push(
            Problem::warning(codes::W0732, "path.over", message)
                .note("the rim can then only be polished by a tool that stays there long; the residual suffers")
                .help(format!(
                    "let the path go on for {:.2} mm, the spot's sigma, beyond the clear aperture",
                    footprint.sigma * 1e3
                )),
        );
    }
    let (field, layer, deepest) = match &task.dwell.piston {
        Piston::free(free) => {
            let most = free.at_most.map_or(f64::INFINITY, |most| most.0);
            ("dwell.piston.at_most", "the deepest layer allowed", most)
        }
        Piston::fixed(fixed) => ("dwell.piston.depth", "the fixed layer", fixed.depth.0),
        Piston::held(_) => ("dwell.piston", "no layer", task.dwell.removal_fraction * highest),
    };
    // A floor below the whole layer is refused by the solver, with better words.
    let floor = task.passes as f64 * floor_depth(footprint.volume_rate, task.dwell.feed.to.0, task.line_pitch);
    if floor <= deepest && reach.excess_rms > prospect.best_rms {
        let [x, y] = reach.excess_place;
        let message = format!(
            "even at its greatest feed the path removes {:.3} nm more than error and {layer} ask for at x {:.2} mm, y {:.2} mm",
            reach.excess * 1e9,
            x * 1e3,
            y * 1e3,
        );
        warnings.push(
            Problem::warning(codes::W0733, field, message)
                .note(format!(
                    "over the clear aperture that is {:.3} nm RMS about the wanted layer, whatever the dwell",
                    reach.excess_rms * 1e9
                ))
                .help("allow a deeper even layer, raise the upper end of `feed`, or lay the lines farther apart"),
        );
    }
}
