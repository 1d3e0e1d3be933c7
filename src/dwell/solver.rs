//! The solver within what the arm can do: times for wanted depths, and speeds that the arm can follow.
//!
//! In: the removal operator, the wanted depths, the limits. Out: speeds of the segments, and what the operator says of them.

use super::least_squares::{self, Base, Stop, Wanted};
use super::removal::Removal;
use super::speed::{self, Limits, Segments};

/// Rounds of limiting and solving again. After six the bounds hardly move (measured in the model's study of limits).
const MOST_ROUNDS: usize = 6;

/// Part of the residual that the arm's limits may cost, or another round must gain: a twentieth of the residual is less
/// than what the influence function is known to.
pub(super) const LIMIT_COST: f64 = 0.05;

/// Steps of a solve that starts from a solved neighbour.
pub(super) const LATER_ITERATIONS: usize = 40;

/// When the solver stops. Heights below a hundredth of a nanometre are beneath every interferometer's repeatability;
/// ten steps that together gain less than 1 % of the RMS are not worth their time.
pub(super) const STOP: Stop =
    Stop { most_iterations: 200, relative_decrease: 0.01, elsewhere: 0.0, rms: 1e-11, relative_step: 1e-9 };

/// Speeds of one solve, and what its operator says of them.
pub(super) struct Solved {
    pub rms: f64,
    pub speeds: Vec<f64>,
}

/// What all solves of a run share.
pub(super) struct Solver<'a> {
    pub operator: &'a mut Removal,
    pub segments: &'a Segments,
    pub limits: &'a Limits,
    pub weights: &'a [f64],
    /// Times of the segments at their fastest and slowest.
    pub lower: &'a [f64],
    pub upper: &'a [f64],
    pub base: Base,
    pub stop: Stop,
    pub iterations: usize,
    pub rounds: usize,
}

impl Solver<'_> {
    /// Times for the wanted depths, and speeds that the arm can follow: solved again, with the times that it needs as
    /// least ones, as long as that gains something.
    pub(super) fn solve(&mut self, depths: &[f64], start: &[f64], most_iterations: usize) -> Solved {
        let (mut lower, mut upper) = (self.lower.to_vec(), self.upper.to_vec());
        let mut start = start.to_vec();
        let all = |rms: f64| libm::hypot(rms, self.stop.elsewhere);
        let mut best: Option<Solved> = None;
        for round in 0..=MOST_ROUNDS {
            let most_iterations = if round == 0 { most_iterations } else { LATER_ITERATIONS };
            let stop = Stop { most_iterations, ..self.stop };
            let wanted = Wanted { depths, weights: self.weights, lower: &lower, upper: &upper, base: self.base };
            let solved = least_squares::solve(self.operator, &wanted, &start, stop);
            self.iterations += solved.iterations;
            self.rounds += 1;
            let speeds = speed::for_times(&solved.times, self.segments, self.limits);
            let times = speed::times(&speeds, self.segments, self.limits);
            let (rms, _) = least_squares::evaluate(self.operator, &wanted, &times);
            let earlier = best.as_ref().map_or(f64::INFINITY, |best| best.rms);
            if rms < earlier {
                best = Some(Solved { rms, speeds });
            }
            // Good enough: what the arm's limits cost is small beside the residual, or another round gained nothing.
            let cheap = all(rms) <= (1.0 + LIMIT_COST) * all(solved.rms) || rms <= STOP.rms;
            if cheap || rms > (1.0 - LIMIT_COST) * earlier {
                break;
            }
            for i in 0..times.len() {
                if times[i] > solved.times[i] * (1.0 + 1e-6) {
                    lower[i] = lower[i].max(times[i]);
                }
            }
            raise(&mut upper, &lower);
            start = times;
        }
        // Without a finite residual there is nothing to follow: the slowest speeds remove most and hide nothing.
        best.unwrap_or_else(|| Solved {
            rms: f64::INFINITY,
            speeds: vec![self.limits.least; self.segments.length.len()],
        })
    }
}

pub(super) fn raise(upper: &mut [f64], lower: &[f64]) {
    for (upper, lower) in upper.iter_mut().zip(lower) {
        *upper = upper.max(*lower);
    }
}
