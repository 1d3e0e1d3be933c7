//! Times that the arm can follow.
//!
//! In: the segments, the limits of feed, acceleration and cornering, speeds to start from. Out: a [`Domain`] of the times of the
//! speeds that keep them all.
//!
//! In times or speeds the limit of acceleration bounds a set that is not convex. In squares of speeds u = v² it is a chain,
//! `|u_i - u_(i-1)| <= 2 a ds_i`, and the [nearest point of it](super::chain) is found exactly. So the unknowns are the u; the times
//! follow the ramps of [`speed`].
//!
//! The way is that of a projected quasi-Newton method (M. Schmidt, E. van den Berg, M. Friedlander, K. Murphy, "Optimizing costly
//! functions with simple constraints: a limited-memory projected quasi-Newton algorithm", AISTATS 2009): over the times the
//! objective is nearly quadratic, and the [last moves](super::quasi_newton) tell its curvature. That model costs no product with
//! the operator. It is minimised over the squares, along the bent ways that their times take, by a scaled projected gradient
//! (S. Bonettini, R. Zanella, L. Zanni, "A scaled gradient projection method for constrained image deblurring", Inverse Problems
//! 25, 2009): each segment's u goes where its time alone would, and the projection weighs segments by how far that is. What it
//! finds is the end of the way.

use super::chain;
use super::descent::Domain;
use super::quasi_newton::{Curvature, Memory};
use super::speed::{self, Limits, Segments};
use super::vectors::{dot, each, pass, sums};

/// Times of speeds that the arm can follow.
pub struct Followable<'a> {
    segments: &'a Segments,
    limits: &'a Limits,
    stiffness: &'a [f64],
    /// Greatest square, and how far from the one before, of each segment.
    high: Vec<f64>,
    reach: Vec<f64>,
    squares: Vec<f64>,
    times: Vec<f64>,
    way: Vec<f64>,
    slope: Vec<f64>,
    memory: Memory,
    best: Vec<f64>,
}

impl<'a> Followable<'a> {
    /// `speeds` must keep the limits, as [`speed::limit`] makes them.
    pub fn new(segments: &'a Segments, limits: &'a Limits, speeds: &[f64]) -> Followable<'a> {
        let n = speeds.len();
        let (mut high, mut reach) = (vec![0.0; n], vec![0.0; n]);
        for line in segments.lines() {
            let last = line.end - 1;
            for i in line.clone() {
                let greatest = segments.greatest(i, limits);
                reach[i] = segments.change(i, i == last, limits);
                high[i] = greatest * greatest;
            }
            // From rest, and to rest.
            high[line.start] = high[line.start].min(reach[line.start]);
            high[last] = high[last].min(reach[last]);
        }
        Followable {
            segments,
            limits,
            stiffness: &[],
            high,
            reach,
            squares: speeds.iter().map(|v| v * v).collect(),
            times: speed::times(speeds, segments, limits),
            way: vec![0.0; n],
            slope: vec![0.0; n],
            memory: Memory::of(PAIRS),
            best: Vec::new(),
        }
    }

    /// The same with a [stiffness](Domain::stiffness) of each time.
    pub fn with_stiffness(mut self, stiffness: &'a [f64]) -> Followable<'a> {
        self.stiffness = stiffness;
        self
    }

    fn stiff(&self, i: usize) -> f64 {
        self.stiffness.get(i).copied().unwrap_or(1.0)
    }

    /// The present speeds.
    pub fn speeds(&self) -> Vec<f64> {
        self.squares.iter().map(|u| u.sqrt()).collect()
    }

    /// The gradient over the squares, from that over the times: a speed is part of its own segment's time and of the next one's.
    fn pull_back(&self, squares: &[f64], gradient: &[f64], slope: &mut [f64]) {
        let a = self.limits.acceleration;
        self.segments.each_line(slope, |line, slope| {
            let last = slope.len() - 1;
            let mut before = 0.0;
            for (k, i) in line.enumerate() {
                let v = squares[i].sqrt();
                let change: f64 = v - before;
                // Of ds/v + change |change| / (2 a v), and v/(2a) more in the last segment.
                let mut own = -self.segments.length[i] / (v * v) + change.abs() / (a * v)
                    - change * change.abs() / (2.0 * a * v * v);
                if k == last {
                    own += 0.5 / a;
                }
                slope[k] = gradient[i] * own / (2.0 * v);
                if before > 0.0 {
                    slope[k - 1] -= gradient[i] * change.abs() / (a * v) / (2.0 * before);
                }
                before = v;
            }
        });
    }

    /// Change of a segment's plain time with its u.
    fn inner(&self, i: usize, u: f64) -> f64 {
        -0.5 * self.segments.length[i] / (u * u.sqrt())
    }

    /// The scaled projected gradient: the way from these squares, and the slope along it.
    fn downhill(&self, squares: &[f64], slope: &[f64], step: f64, way: &mut [f64]) -> f64 {
        let low = self.limits.least * self.limits.least;
        self.segments.each_line(way, |line, way| {
            let weights: Vec<f64> = line
                .clone()
                .zip(way.iter_mut())
                .map(|(i, way)| {
                    let (u, length) = (squares[i], self.segments.length[i]);
                    let (time, inner, step) = (length / u.sqrt(), self.inner(i, u), step / self.stiff(i));
                    // A time may shrink to half in a step, so that the square grows to four times itself: beyond that the
                    // gradient of here says nothing.
                    let wanted = (time - step * slope[i] / inner).max(0.5 * time);
                    let square = (length / wanted) * (length / wanted);
                    *way = square;
                    let ratio = -slope[i] / (square - u);
                    // What the segment's own step makes of its gradient; where it hardly moves, the limit of that.
                    let moves = (square - u).abs() > 1e-9 * u && ratio > 0.0;
                    if moves { ratio } else { inner * inner / step }
                })
                .collect();
            chain::project(way, &weights, low, &self.high[line.clone()], &self.reach[line.clone()]);
            for (way, square) in way.iter_mut().zip(&squares[line]) {
                *way -= square;
            }
        });
        dot(way, slope)
    }

    /// The squares whose times would cost least if their `gradient` changed as `curvature` tells; `step` as in
    /// [`Domain::aim`].
    fn least_of_model(&self, gradient: &[f64], curvature: &Curvature, mut step: f64) -> Vec<f64> {
        let n = gradient.len();
        let mut here = self.squares.clone();
        let mut best = here.clone();
        let mut slope = self.slope.clone();
        let mut way = vec![0.0; n];
        let (mut squares, mut change, mut turned) = (here.clone(), vec![0.0; n], vec![0.0; n]);
        let mut next = vec![0.0; n];
        let mut values = vec![0.0f64];
        let (mut least, mut first) = (0.0, 0.0f64);
        for _ in 0..MODEL_STEPS {
            let down = self.downhill(&here, &slope, step, &mut way);
            first = first.min(down);
            if !(down < SETTLED * first) {
                break;
            }
            let ceiling = values.iter().rev().take(CEILING).fold(f64::NEG_INFINITY, |a, b| a.max(*b));
            let last = values[values.len() - 1];
            let mut length = 1.0;
            let value = loop {
                each(&mut squares, |i, square| *square = here[i] + length * way[i]);
                self.times_of(&squares, &mut change);
                each(&mut change, |i, change| *change -= self.times[i]);
                curvature.times(&change, &mut turned);
                let [value] = pass(&mut turned, |i, turned| {
                    let half = change[i] * (gradient[i] + 0.5 * *turned);
                    *turned += gradient[i];
                    [half]
                });
                // As in `descent`, whose line search this is.
                if value <= ceiling + 1e-4 * length * down || length < 1e-10 {
                    break value;
                }
                let minimum = -down * length * length / (2.0 * (value - last - length * down));
                length = if minimum.is_finite() { minimum.clamp(0.1 * length, 0.5 * length) } else { 0.5 * length };
            };
            self.pull_back(&squares, &turned, &mut next);
            // The spectral step in these unknowns: the move in times over the curvature along it.
            let [moves, turns] = sums(n, |i| {
                let change = squares[i] - here[i];
                let moved = self.inner(i, here[i]) * change;
                [self.stiff(i) * moved * moved, change * (next[i] - slope[i])]
            });
            let spectral = moves / turns;
            step = if spectral.is_finite() && spectral > 0.0 { spectral } else { 10.0 * step };
            std::mem::swap(&mut slope, &mut next);
            std::mem::swap(&mut here, &mut squares);
            values.push(value);
            if value < least {
                least = value;
                best.clone_from(&here);
            }
        }
        best
    }

    fn times_of(&self, squares: &[f64], times: &mut [f64]) {
        let mut speeds = vec![0.0; squares.len()];
        each(&mut speeds, |i, speed| *speed = squares[i].sqrt());
        speed::times_into(&speeds, self.segments, self.limits, times);
    }
}

/// Moves that are remembered. On the test problem five need a quarter more steps, and twenty gain 0.3 % for twice the room.
const PAIRS: usize = 10;

/// Steps down the model, and the part of its greatest slope at which it has settled: with 100 steps the answers are no better.
const MODEL_STEPS: usize = 15;
const SETTLED: f64 = 1e-3;

/// Values of the model that a step may exceed the last of.
const CEILING: usize = 10;

impl Domain for Followable<'_> {
    fn times(&self) -> &[f64] {
        &self.times
    }

    fn stiffness(&self) -> &[f64] {
        self.stiffness
    }

    fn aim(&mut self, gradient: &[f64], step: f64) -> f64 {
        let n = self.squares.len();
        let mut slope = std::mem::take(&mut self.slope);
        self.pull_back(&self.squares, gradient, &mut slope);
        self.slope = slope;
        if let Some(curvature) = self.memory.curvature(self.stiffness, n) {
            let to = self.least_of_model(gradient, &curvature, step);
            for ((way, to), square) in self.way.iter_mut().zip(&to).zip(&self.squares) {
                *way = to - square;
            }
            let slope = dot(&self.way, &self.slope);
            if slope < 0.0 {
                return slope;
            }
        }
        let mut way = std::mem::take(&mut self.way);
        let slope = self.downhill(&self.squares, &self.slope, step, &mut way);
        self.way = way;
        slope
    }

    fn at(&self, length: f64, times: &mut [f64]) {
        let speeds: Vec<f64> =
            self.squares.iter().zip(&self.way).map(|(square, way)| (square + length * way).sqrt()).collect();
        times.copy_from_slice(&speed::times(&speeds, self.segments, self.limits));
    }

    fn go(&mut self, length: f64, turned: &[f64]) {
        for (square, way) in self.squares.iter_mut().zip(&mut self.way) {
            *way *= length;
            *square += *way;
        }
        let speeds = self.speeds();
        let times = speed::times(&speeds, self.segments, self.limits);
        self.memory.add(|i| times[i] - self.times[i], turned);
        self.times = times;
    }

    fn is_straight(&self) -> bool {
        false
    }

    fn keep(&mut self) {
        self.best.clone_from(&self.squares);
    }

    fn fork(&self) -> Box<dyn Domain + '_> {
        Box::new(Followable::new(self.segments, self.limits, &self.speeds()).with_stiffness(self.stiffness))
    }

    fn place(&self) -> &[f64] {
        &self.squares
    }

    fn towards(&mut self, place: &[f64], length: f64) {
        for (square, place) in self.squares.iter_mut().zip(place) {
            *square += length * (place - *square);
        }
        let speeds = self.speeds();
        self.times = speed::times(&speeds, self.segments, self.limits);
    }

    fn take_best(&mut self) {
        self.squares.clone_from(&self.best);
        // The next descent may have another objective.
        self.memory = Memory::of(PAIRS);
        let speeds = self.speeds();
        self.times = speed::times(&speeds, self.segments, self.limits);
    }
}
