//! What a path does not reach, and what it cannot help removing.
//!
//! In: the [`Task`], the error on the solver's pixels, the removal operator of the path. Out: a [`Reach`].
//!
//! Two bounds that no solver can beat. A pixel that no part of the path reaches keeps what it has. A pixel that the fastest run
//! takes more off than its share of the error and the even layer ask for is left at least that much too low: with
//! `ep = φ e + c` and the shortest times T, `max(0, -(ep - H T))`. A free layer without `at_most` can always be deeper, so the
//! second bound is then zero.

use crate::dwell::descent::LinearOperator;
use crate::dwell::field::Field;
use crate::dwell::removal::Removal;
use crate::dwell::speed::{self, Limits, Segments};
use crate::dwell::{Footprint, Task, standing_depths};
use crate::job::Piston;

/// A pixel is not reached where the path is weaker than this part of its usual strength: what the transform rounds to.
const NOTHING: f64 = 1e-9;

/// How a path covers the clear aperture. Lengths in metres, places in the part frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reach {
    /// Pixels of the clear aperture, as the solver sees them, that no part of the path reaches.
    pub pixels: usize,
    /// Their area, m².
    pub area: f64,
    /// The one of them that keeps most.
    pub place: [f64; 2],
    /// What it keeps: the greatest height above or below the wanted one.
    pub left: f64,
    /// Least strength of the path over the clear aperture against its mean, and where.
    pub least_strength: f64,
    pub weakest: [f64; 2],
    /// The most that the fastest run takes off beyond what is wanted, and where.
    pub excess: f64,
    pub excess_place: [f64; 2],
    /// RMS of that over the clear aperture: no residual, counted from the wanted layer and not from its own mean, is less.
    pub excess_rms: f64,
}

impl Reach {
    /// `operator` is that of the path's segments on the window of `coarse`.
    pub fn of(task: &Task, coarse: &Field, footprint: &Footprint, operator: &mut Removal) -> Reach {
        let dwell = task.dwell;
        let segments = Segments::new(&task.path, footprint.standoff);
        let limits = Limits::of(dwell);
        let mut fastest: Vec<f64> = (0..segments.length.len()).map(|i| segments.greatest(i, &limits)).collect();
        speed::limit(&mut fastest, &segments, &limits);
        let shortest = speed::times(&fastest, &segments, &limits);
        let (mut strength, mut removed) = (vec![0.0; coarse.values.len()], vec![0.0; coarse.values.len()]);
        operator.forward(&segments.length, &mut strength);
        operator.forward(&shortest, &mut removed);
        let standing = standing_depths(&task.path, &task.standing, footprint, &coarse.window);
        removed.iter_mut().zip(standing).for_each(|(depth, more)| *depth += more);

        let inside: Vec<usize> = (0..strength.len()).filter(|&i| coarse.weights[i] > 0.0).collect();
        let weight: f64 = coarse.weights.iter().sum();
        let mean = inside.iter().map(|&i| coarse.weights[i] * strength[i]).sum::<f64>() / weight;
        // The deepest layer that the job allows: the wanted depth can nowhere be more.
        let layer = match &dwell.piston {
            Piston::free(free) => free.at_most.map_or(f64::INFINITY, |most| most.0),
            Piston::fixed(fixed) => fixed.depth.0,
            Piston::held(_) => 0.0,
        };
        let area = coarse.window.pixel[0] * coarse.window.pixel[1];
        let mut reach = Reach { least_strength: f64::INFINITY, ..Reach::default() };
        let mut squares = 0.0;
        for i in inside {
            let wanted = dwell.removal_fraction * coarse.values[i] + layer;
            if strength[i] <= NOTHING * mean {
                reach.pixels += 1;
                reach.area += coarse.weights[i] * area;
                // Against an unlimited layer the height itself is what stays.
                let left = if wanted.is_finite() { wanted.abs() } else { coarse.values[i].abs() };
                if left >= reach.left {
                    (reach.left, reach.place) = (left, coarse.window.position(i));
                }
            }
            if strength[i] < reach.least_strength * mean {
                (reach.least_strength, reach.weakest) = (strength[i] / mean, coarse.window.position(i));
            }
            let excess = (removed[i] - wanted).max(0.0);
            squares += coarse.weights[i] * excess * excess;
            if excess > reach.excess {
                (reach.excess, reach.excess_place) = (excess, coarse.window.position(i));
            }
        }
        reach.excess_rms = (squares / weight).sqrt();
        reach
    }
}
