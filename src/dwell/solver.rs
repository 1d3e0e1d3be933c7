//! The solver: times for wanted depths by the job's objective, and speeds that the arm can follow.
//!
//! In: the removal operator, the wanted depths, the limits, the objective. Out: speeds of the segments, and what the operator
//! says of them.
//!
//! First the times alone, between the bounds that feed and ramps give each segment: a convex problem. Then, where the arm cannot
//! follow them, the speeds: from the fastest that it can, which never waits less than the times ask for, down the same
//! objective; and once more from evened speeds where the limits are strong.

use super::bounds::Bounds;
use super::descent::{self, Domain, Ended, LinearOperator, Stop};
use super::followable::Followable;
use super::largest;
use super::objective::{Base, Figures, Objective, Price, Wanted};
use super::speed::{self, Limits, Segments};
use super::vectors::sum;

/// When the solver stops. Ten steps that together gain less than
/// 1 % of the RMS (2 % of the squares) are not worth their time.
pub const STOP: Stop = Stop {
    most_iterations: MOST_ITERATIONS,
    over: 10,
    relative_decrease: 0.02,
    elsewhere: 0.0,
    value: 0.0,
    relative_step: 1e-9,
};

/// Steps of a solve: with the published cases the last hundred gain 1 %.
pub const MOST_ITERATIONS: usize = 200;

/// Residual that is as good as none, metres: beneath every interferometer's repeatability. Below it only a deeper layer and
/// more time are to be had. Who asks for less, by `time`, gets it.
pub const NOTHING: f64 = 1e-11;

/// The same as a part of what is to be taken off: no influence function is known to a two-hundredth, so that less would be a
/// promise that no run keeps.
const KNOWN: f64 = 0.005;

/// What the limits of the arm may cost before the speeds are solved for: less than the influence function is known to.
const LIMIT_COST: f64 = 0.01;

/// Part of the way to an even speed of a second start. Where the limits are strong, limited speeds lean on each other almost
/// everywhere, which makes them a corner of a poor valley: on the test problem with an acceleration of 5 mm/s² the descent
/// from them stays at 8.8 nm, and from a quarter to all of the way to an even speed it ends between 6.66 and 6.67 nm.
const EVENED: f64 = 0.5;

/// Limits are strong that leave so many times as much as would be left without: on the test problem the second start gains from
/// 20 mm/s² down (1.5 times) and never at 50 mm/s² (1.2 times).
const STRONG: f64 = 1.3;

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
        // What the arm makes of times may be a little more than the times themselves leave: that is for the caller to see.
        while found.figures.rms > (1.0 + 5.0 * LIMIT_COST) * rms {
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
        let elsewhere = self.elsewhere;
        let cost = |a: f64| libm::hypot(a, elsewhere);
        let enough = match self.aim {
            Aim::Rms => cost(limited.rms) <= (1.0 + LIMIT_COST) * cost(free.rms) || limited.rms <= self.nothing(depths),
            Aim::Pv => limited.largest <= (1.0 + LIMIT_COST) * free.largest,
            // What is out of reach of any times is so of those that the arm can follow; a little too much is asked less of.
            Aim::Time { rms } => limited.rms <= (1.0 + 5.0 * LIMIT_COST) * rms || free.rms > rms,
        };
        let limited = Solved { figures: limited, speeds, times, ended };
        if enough {
            return limited;
        }
        // The way down is bent there: ten steps may gain nothing, and forty still a lot.
        let stop = Stop {
            over: 40,
            relative_decrease: 0.5 * stop.relative_decrease,
            most_iterations: 10 * stop.most_iterations,
            ..stop
        };
        let aim = self.aim;
        let left = |figures: &Figures| if aim == Aim::Pv { figures.largest } else { figures.rms };
        let mean = self.segments.length.iter().sum::<f64>() / limited.times.iter().sum::<f64>();
        let mut even: Vec<f64> = limited.speeds.iter().map(|speed| speed + EVENED * (mean - speed)).collect();
        speed::limit(&mut even, self.segments, self.limits);
        // Never worse than limiting afterwards.
        let from_limited = self.follow(depths, &limited.speeds, stop);
        let mut best = limited;
        if left(&from_limited.figures) <= left(&best.figures) {
            best = from_limited;
        }
        if best.ended != Ended::Reached && cost(left(&best.figures)) > STRONG * cost(left(&free)) {
            let from_even = self.follow(depths, &even, stop);
            if left(&from_even.figures) <= left(&best.figures) {
                best = from_even;
            }
        }
        best
    }

    /// The speeds that the descent over what the arm can follow leads to.
    fn follow(&mut self, depths: &[f64], speeds: &[f64], stop: Stop) -> Solved {
        let mut domain = Followable::new(self.segments, self.limits, speeds).with_stiffness(self.stiffness);
        let ended = self.descend_by_aim(depths, &mut domain, stop);
        let (speeds, times) = (domain.speeds(), domain.times().to_vec());
        self.rounds += 1;
        Solved { figures: self.figures(depths, &times), speeds, times, ended }
    }

    /// Times of least squares at a price of a second, before the arm's limits.
    pub(super) fn priced(&mut self, depths: &[f64], start: &[f64], price: f64, steps: usize) -> Vec<f64> {
        let mut domain = Bounds::new(self.lower, self.upper, start).with_stiffness(self.stiffness);
        // At a price there is always less time to be had.
        let value = if price > 0.0 { 0.0 } else { self.squares(self.nothing(depths)) };
        self.descend(depths, &mut domain, Price::Fixed(price), Stop { most_iterations: steps, value, ..STOP });
        domain.into_times()
    }

    /// Half of the weighted square sum of an RMS.
    pub fn squares(&self, rms: f64) -> f64 {
        0.5 * sum(self.weights.len(), |i| self.weights[i]) * rms * rms
    }

    pub(super) fn figures(&mut self, depths: &[f64], times: &[f64]) -> Figures {
        let wanted = Wanted {
            depths,
            weights: self.weights,
            base: self.base,
            objective: Objective::Squares,
            price: Price::NONE,
        };
        wanted.figures(self.operator, times)
    }

    /// Least squares, with a price of a second.
    fn descend(&mut self, depths: &[f64], domain: &mut dyn Domain, price: Price, stop: Stop) -> Ended {
        let stop = Stop { elsewhere: self.squares(self.elsewhere), ..stop };
        let wanted = Wanted { depths, weights: self.weights, base: self.base, objective: Objective::Squares, price };
        let found = descent::descend(self.operator, &wanted, domain, stop);
        self.iterations += found.iterations;
        self.price = found.price;
        found.ended
    }

    /// RMS that is as good as none beside the wanted depths.
    fn nothing(&self, depths: &[f64]) -> f64 {
        let (n, weights) = (depths.len(), self.weights);
        let weight = sum(n, |i| weights[i]);
        let mean = sum(n, |i| weights[i] * depths[i]) / weight;
        let square = sum(n, |i| weights[i] * (depths[i] - mean) * (depths[i] - mean)) / weight;
        (KNOWN * square.sqrt()).max(NOTHING)
    }

    fn descend_by_aim(&mut self, depths: &[f64], domain: &mut dyn Domain, stop: Stop) -> Ended {
        let nothing = Stop { value: self.squares(self.nothing(depths)), ..stop };
        match self.aim {
            Aim::Rms => self.descend(depths, domain, Price::NONE, nothing),
            Aim::Pv => {
                self.descend(depths, domain, Price::NONE, nothing);
                let (weights, base) = (self.weights, self.base);
                let wanted = Wanted { depths, weights, base, objective: Objective::Squares, price: Price::NONE };
                let found = largest::minimise(self.operator, &wanted, domain, &largest::SHARPENING, stop);
                self.iterations += found.iterations;
                found.ended
            }
            Aim::Time { rms } => {
                let price = Price::Sought { most: self.squares(rms), first: self.price };
                self.descend(depths, domain, price, stop)
            }
        }
    }
}
