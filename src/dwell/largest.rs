//! The least largest residual: minimax, half of the least peak to valley where the even layer is free.
//!
//! In: a [problem](Wanted) whose objective is not looked at, a domain at the least squares. Out: the domain at the answer.
//!
//! Two stages. The largest residual is replaced by a smooth stand-in, sharpened step by step
//! ([`Objective::Largest`]). It says nothing of the places where the residual is smaller, so many runs reach the same: the second
//! stage lowers the RMS among them.

use super::descent::{self, Domain, Ended, Found, LinearOperator, Stop};
use super::objective::{Base, Objective, Price, Wanted};

/// Sharpness times largest residual, one solve each: the stand-in is above the largest by log(2n)/sharpness, 5 % of it at 200
/// and 1 % at 1000 for 25,000 pixels, and each start lies where the next one's is good.
pub const SHARPENING: [f64; 5] = [5.0, 20.0, 80.0, 300.0, 1000.0];

/// What the largest residual may grow by in the second stage: the sharpening ends as near to its own optimum.
const SLACK: f64 = 0.003;

/// Of the squares beyond the largest residual in the second stage: as stiff as leaves the descent a way.
const STIFFNESS: f64 = 3e4;

/// The first stage. `found.value` is the largest residual.
pub fn sharpen(
    operator: &mut dyn LinearOperator,
    wanted: &Wanted,
    domain: &mut dyn Domain,
    sharpening: &[f64],
    stop: Stop,
) -> Found {
    let (mut iterations, mut ended) = (0, Ended::Slow);
    for sharpening in sharpening {
        let largest = wanted.figures(operator, domain.times()).largest;
        if !(largest > 0.0) {
            break;
        }
        let objective = Objective::Largest { sharpness: sharpening / largest };
        // The stand-in changes by its height itself, not by its square, and what is left to gain is a few thousandths of it.
        let stop = Stop { relative_decrease: 0.0125 * stop.relative_decrease, elsewhere: 0.0, value: 0.0, ..stop };
        let found = descent::descend(operator, &Wanted { objective, price: Price::NONE, ..*wanted }, domain, stop);
        (iterations, ended) = (iterations + found.iterations, found.ended);
    }
    let figures = wanted.figures(operator, domain.times());
    Found { value: figures.largest, base: figures.middle, price: 0.0, iterations, ended }
}

/// Both stages, from the domain's present times. `found.value` is the largest residual.
pub fn minimise(
    operator: &mut dyn LinearOperator,
    wanted: &Wanted,
    domain: &mut dyn Domain,
    sharpening: &[f64],
    stop: Stop,
) -> Found {
    let Found { mut iterations, ended, .. } = sharpen(operator, wanted, domain, sharpening, stop);
    let first = wanted.figures(operator, domain.times());
    // The layer of the first stage stays, so that the largest residual does.
    let objective = Objective::SquaresWithin { most: first.largest, stiffness: STIFFNESS };
    let within = Wanted { objective, base: Base::Fixed(first.middle), price: Price::NONE, ..*wanted };
    let mut second = domain.fork();
    iterations += descent::descend(operator, &within, &mut *second, stop).iterations;
    let figures = wanted.figures(operator, second.times());
    let place = second.place().to_vec();
    drop(second);
    if figures.rms < first.rms {
        // On the way between the two the largest residual grows at most evenly.
        let grown = figures.largest - first.largest;
        domain.towards(&place, if grown > SLACK * first.largest { SLACK * first.largest / grown } else { 1.0 });
    }
    let last = wanted.figures(operator, domain.times());
    Found { value: last.largest, base: last.middle, price: 0.0, iterations, ended }
}
