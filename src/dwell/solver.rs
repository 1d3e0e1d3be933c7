//! The solver: times for wanted depths by the job's objective, and speeds that the arm can follow.
//!
//! In: the removal operator, the wanted depths, the limits, the objective. Out: speeds of the segments, and what the operator
//! says of them.
//!
//! First the times alone, between the bounds that feed and ramps give each segment: a convex problem. Then, where the arm cannot
//! follow them, the speeds: from the fastest that it can, which never waits less than the times ask for, down the same objective.

use super::bounds::Bounds;
use super::descent::{self, Domain, Ended, LinearOperator, Stop};
use super::followable::Followable;
use super::largest;
use super::objective::{Base, Figures, Objective, Wanted, sum};
use super::speed::{self, Limits, Segments};

/// When the solver stops. Heights below a thousandth of a nanometre are not printed; ten steps that together gain less than
/// 1 % of the RMS (2 % of the squares) are not worth their time.
pub const STOP: Stop =
    Stop { most_iterations: MOST_ITERATIONS, relative_decrease: 0.02, elsewhere: 0.0, value: 0.0, relative_step: 1e-9 };

/// Steps of a solve: with the published cases the last hundred gain 1 %.
pub const MOST_ITERATIONS: usize = 200;

/// Residual that is as good as none, metres.
pub const NOTHING: f64 = 1e-12;

/// What the limits of the arm may cost before the speeds are solved for: less than the influence function is known to.
const LIMIT_COST: f64 = 0.01;

/// Part of the mean slowness by which a run gets slower everywhere, at first, to leave less: a twentieth of its time.
const DEEPER: f64 = 0.05;

/// Steps of a solve that starts from a solved neighbour.
pub const LATER_ITERATIONS: usize = 40;

/// What the job wants, of the solver's residual. Metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    Rms,
    Pv,
    /// The least time with a residual of at most this RMS.
    Time {
        rms: f64,
    },
}

/// Speeds of one solve, and what its operator says of them.
#[derive(Clone, Debug)]
pub struct Solved {
    pub figures: Figures,
    pub speeds: Vec<f64>,
    pub times: Vec<f64>,
    pub ended: Ended,
}

/// What all solves of a run share.
pub struct Solver<'a> {
    pub operator: &'a mut dyn LinearOperator,
    pub segments: &'a Segments,
    pub limits: &'a Limits,
    pub weights: &'a [f64],
    /// Times of the segments at their fastest and slowest.
    pub lower: &'a [f64],
    pub upper: &'a [f64],
    /// See [`Domain::stiffness`].
    pub stiffness: &'a [f64],
    pub base: Base,
    pub aim: Aim,
    /// RMS of what will be left whatever the solver does.
    pub elsewhere: f64,
    pub iterations: usize,
    /// Solves: one, and one more where the arm's limits asked for slower speeds.
    pub rounds: usize,
    /// Price of a second that the last search for the least time ended with.
    pub price: f64,
}

impl Solver<'_> {
    /// Times and speeds for the wanted depths.
    ///
    /// Where the even layer is free, the residual hardly tells how deep it should be, and the descent leaves it about where it
    /// starts. A residual that may not be more than so much may need a deeper one, which leaves room to be faster and slower.
    pub fn solve(&mut self, depths: &[f64], start: &[f64], most_iterations: usize) -> Solved {
        let stop = Stop { most_iterations, ..STOP };
        let (Aim::Time { rms }, Base::AtMost(_)) = (self.aim, self.base) else {
            return self.solve_from(depths, start, stop);
        };
        // Where ten steps gain less than a tenth of the RMS, a deeper layer will gain more.
        let hurry = Stop { relative_decrease: 0.2, ..stop };
        let mut found = self.solve_from(depths, start, hurry);
        let length: f64 = self.segments.length.iter().sum();
        let mut slowness = DEEPER * found.times.iter().sum::<f64>() / length;
        while found.figures.rms > rms {
            let deeper: Vec<f64> =
                found.times.iter().zip(&self.segments.length).map(|(time, length)| time + slowness * length).collect();
            let next = self.solve_from(depths, &deeper, hurry);
            if !(next.figures.rms < (1.0 - LIMIT_COST) * found.figures.rms) {
                // Nor does that: what is left to try is patience.
                return self.solve_from(depths, &found.times, stop);
            }
            found = next;
            slowness *= 2.0;
        }
        found
    }

    fn solve_from(&mut self, depths: &[f64], start: &[f64], stop: Stop) -> Solved {
        let mut domain = Bounds::new(self.lower, self.upper, start).with_stiffness(self.stiffness);
        let ended = self.descend_by_aim(depths, &mut domain, stop);
        let free_times = domain.into_times();
        let free = self.figures(depths, &free_times);
        let speeds = speed::for_times(&free_times, self.segments, self.limits);
        let times = speed::times(&speeds, self.segments, self.limits);
        let limited = self.figures(depths, &times);
        self.rounds += 1;
        let cost = |a: f64| libm::hypot(a, self.elsewhere);
        let enough = match self.aim {
            Aim::Rms => cost(limited.rms) <= (1.0 + LIMIT_COST) * cost(free.rms) || limited.rms <= NOTHING,
            Aim::Pv => limited.largest <= (1.0 + LIMIT_COST) * free.largest,
            // What is out of reach of any times is so of those that the arm can follow.
            Aim::Time { rms } => limited.rms <= rms || free.rms > rms,
        };
        if enough {
            return Solved { figures: limited, speeds, times, ended };
        }
        let (segments, limits) = (self.segments, self.limits);
        let mut domain = Followable::new(segments, limits, &speeds).with_stiffness(self.stiffness);
        let ended = self.descend_by_aim(depths, &mut domain, stop);
        let (found, found_times) = (domain.speeds(), domain.times().to_vec());
        self.rounds += 1;
        let figures = self.figures(depths, &found_times);
        let better = match self.aim {
            Aim::Rms | Aim::Time { .. } => figures.rms <= limited.rms,
            Aim::Pv => figures.largest <= limited.largest,
        };
        // Never worse than limiting afterwards.
        if better {
            Solved { figures, speeds: found, times: found_times, ended }
        } else {
            Solved { figures: limited, speeds, times, ended }
        }
    }

    /// Times of least squares at a price of a second: as asked, and as the arm can follow.
    pub(super) fn priced(&mut self, depths: &[f64], start: &[f64], price: f64, steps: usize) -> (Vec<f64>, Vec<f64>) {
        let mut domain = Bounds::new(self.lower, self.upper, start).with_stiffness(self.stiffness);
        self.descend(depths, &mut domain, price, Stop { most_iterations: steps, ..STOP });
        let asked = domain.into_times();
        let speeds = speed::for_times(&asked, self.segments, self.limits);
        let times = speed::times(&speeds, self.segments, self.limits);
        (asked, times)
    }

    /// Half of the weighted square sum of an RMS.
    pub fn squares(&self, rms: f64) -> f64 {
        0.5 * sum(self.weights.len(), |i| self.weights[i]) * rms * rms
    }

    pub(super) fn figures(&mut self, depths: &[f64], times: &[f64]) -> Figures {
        let wanted =
            Wanted { depths, weights: self.weights, base: self.base, objective: Objective::Squares, price: 0.0 };
        wanted.figures(self.operator, times)
    }

    /// Least squares, with a price of a second.
    fn descend(&mut self, depths: &[f64], domain: &mut dyn Domain, price: f64, stop: Stop) -> Ended {
        let stop = Stop { elsewhere: self.squares(self.elsewhere), ..stop };
        let wanted = Wanted { depths, weights: self.weights, base: self.base, objective: Objective::Squares, price };
        let found = descent::descend(self.operator, &wanted, domain, stop);
        self.iterations += found.iterations;
        found.ended
    }

    fn descend_by_aim(&mut self, depths: &[f64], domain: &mut dyn Domain, stop: Stop) -> Ended {
        let nothing = Stop { value: self.squares(NOTHING), ..stop };
        match self.aim {
            Aim::Rms => self.descend(depths, domain, 0.0, nothing),
            Aim::Pv => {
                self.descend(depths, domain, 0.0, nothing);
                let (weights, base) = (self.weights, self.base);
                let wanted = Wanted { depths, weights, base, objective: Objective::Squares, price: 0.0 };
                let found = largest::minimise(self.operator, &wanted, domain, &largest::SHARPENING, stop);
                self.iterations += found.iterations;
                found.ended
            }
            // With a price known from an earlier solve the search goes on from there.
            Aim::Time { rms } if self.price > 0.0 => self.least_time(depths, domain, rms, Ended::Reached),
            Aim::Time { rms } => {
                // Less than what may be left is not needed.
                let enough = Stop { value: self.squares((1.0 - TIGHT) * rms), ..stop };
                let ended = self.descend(depths, domain, 0.0, enough);
                self.least_time(depths, domain, rms, ended)
            }
        }
    }

    /// Raises the price of a second until the residual is what may be left.
    fn least_time(&mut self, depths: &[f64], domain: &mut dyn Domain, rms: f64, ended: Ended) -> Ended {
        let reached = self.figures(depths, domain.times()).rms;
        if self.price == 0.0 && !(reached < rms) {
            return ended;
        }
        // The RMS that was reached for a price, below and above what may be left.
        let (mut below, mut above) = ((0.0, 0.0), None::<(f64, f64)>);
        let seconds = sum(domain.times().len(), |i| domain.times()[i]);
        let mut price = if self.price > 0.0 { self.price } else { self.squares(rms) / seconds };
        let stop = Stop { most_iterations: LATER_ITERATIONS, ..STOP };
        for _ in 0..MOST_PRICES {
            self.descend(depths, domain, price, stop);
            let found = self.figures(depths, domain.times()).rms;
            if found <= rms {
                below = (price, found);
                if found >= (1.0 - TIGHT) * rms {
                    break;
                }
            } else {
                above = Some((price, found));
            }
            price = match above {
                None => 8.0 * price,
                Some(above) if below.0 > 0.0 => {
                    // Along the straight line in logarithms, kept off the ends; aimed at the middle of what is good enough.
                    let aim = libm::log((1.0 - 0.5 * TIGHT) * rms / below.1) / libm::log(above.1 / below.1);
                    below.0 * libm::exp(aim.clamp(0.1, 0.9) * libm::log(above.0 / below.0))
                }
                Some(above) => above.0 / 8.0,
            };
        }
        if self.figures(depths, domain.times()).rms > rms {
            self.descend(depths, domain, below.0, Stop { most_iterations: 2 * LATER_ITERATIONS, ..stop });
        }
        self.price = below.0;
        Ended::Reached
    }
}

/// Prices that are tried for the least time; each halves the distance at least.
const MOST_PRICES: usize = 12;

/// How much of the residual that may be left is given away: half a per cent of the residual is next to no time.
const TIGHT: f64 = 0.01;
