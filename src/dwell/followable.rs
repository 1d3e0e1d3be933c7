//! Times that the arm can follow.
//!
//! In: the segments, the limits of feed, acceleration and cornering, speeds to start from. Out: a [`Domain`] of the times of the
//! speeds that keep them all.
//!
//! In times or speeds the limit of acceleration bounds a set that is not convex. In squares of speeds u = v² it is a chain,
//! `|u_i - u_(i-1)| <= 2 a ds_i`, and the [nearest point of it](super::chain) is found exactly. So the unknowns are the u; the times
//! follow the ramps of [`speed`](super::speed).
//!
//! The way is a [quasi-Newton step](super::quasi_newton) over stretches that move together (segments between which the arm
//! accelerates as hard as it can keep the differences of their squares), brought to the nearest chain. Where that does not lead
//! down, a scaled projected gradient does (S. Bonettini, R. Zanella, L. Zanni, "A scaled gradient projection method for
//! constrained image deblurring", Inverse Problems 25, 2009): each segment's u goes where its time alone would, and the
//! projection weighs segments by how far that is.

use super::chain;
use super::descent::Domain;
use super::objective::{dot, sum};
use super::quasi_newton::Memory;
use super::speed::{self, Limits, Segments};

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
    weights: Vec<f64>,
    memory: Memory,
    /// The slope before the last move.
    earlier: Vec<f64>,
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
            weights: vec![0.0; n],
            memory: Memory::default(),
            earlier: Vec::new(),
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
    fn pull_back(&mut self, gradient: &[f64]) {
        let a = self.limits.acceleration;
        for line in self.segments.lines() {
            let last = line.end - 1;
            let mut before = 0.0;
            for i in line {
                let v = self.squares[i].sqrt();
                let change: f64 = v - before;
                // Of ds/v + change |change| / (2 a v), and v/(2a) more in the last segment.
                let mut own = -self.segments.length[i] / (v * v) + change.abs() / (a * v)
                    - change * change.abs() / (2.0 * a * v * v);
                if i == last {
                    own += 0.5 / a;
                }
                self.slope[i] = gradient[i] * own / (2.0 * v);
                if before > 0.0 {
                    self.slope[i - 1] -= gradient[i] * change.abs() / (a * v) / (2.0 * before);
                }
                before = v;
            }
        }
    }

    /// Change of a segment's plain time with its u.
    fn inner(&self, i: usize) -> f64 {
        let u = self.squares[i];
        -0.5 * self.segments.length[i] / (u * u.sqrt())
    }

    /// The stretch that each segment belongs to, and how many there are.
    fn stretches(&self) -> (Vec<usize>, usize) {
        let mut stretch = vec![0; self.squares.len()];
        let mut count = 0;
        for line in self.segments.lines() {
            for i in line.clone() {
                let apart = |i: usize| (self.squares[i] - self.squares[i - 1]).abs();
                if i == line.start || apart(i) < TIED * self.reach[i] {
                    count += 1;
                }
                stretch[i] = count - 1;
            }
        }
        (stretch, count)
    }

    /// Where the quasi-Newton step over the stretches leads, into `way`; the projection's weights into `weights`.
    fn newton(&mut self) -> bool {
        let n = self.squares.len();
        let (stretch, count) = self.stretches();
        let add = |values: &dyn Fn(usize) -> f64| {
            let mut sums = vec![0.0; count];
            for (i, stretch) in stretch.iter().enumerate() {
                sums[*stretch] += values(i);
            }
            sums
        };
        for i in 0..n {
            let inner = self.inner(i);
            self.weights[i] = self.stiff(i) * inner * inner;
        }
        let stiffness = add(&|i| self.weights[i]);
        let slope = add(&|i| self.slope[i]);
        let low = self.limits.least * self.limits.least;
        let mut held = vec![false; count];
        for (i, &stretch) in stretch.iter().enumerate() {
            let (u, down) = (self.squares[i], slope[stretch] > 0.0);
            held[stretch] |= if down { u <= low / TIED } else { u >= TIED * self.high[i] };
        }
        let reduced = self.memory.reduced(|values, is_move| {
            if !is_move {
                return add(&|i| values[i]);
            }
            let mut means = add(&|i| values[i] * self.weights[i]);
            means.iter_mut().zip(&stiffness).for_each(|(mean, stiffness)| *mean /= stiffness);
            means
        });
        let Some(step) = reduced.step(&slope, &held, &stiffness) else { return false };
        for i in 0..n {
            self.way[i] = self.squares[i] - step[stretch[i]];
        }
        true
    }

    /// Makes `way`, the u that are wanted, the way to the nearest chain; the slope along it.
    fn project(&mut self) -> f64 {
        let low = self.limits.least * self.limits.least;
        for line in self.segments.lines() {
            chain::project(
                &mut self.way[line.clone()],
                &self.weights[line.clone()],
                low,
                &self.high[line.clone()],
                &self.reach[line],
            );
        }
        for (way, square) in self.way.iter_mut().zip(&self.squares) {
            *way -= square;
        }
        dot(&self.way, &self.slope)
    }
}

/// Part of a limit from which it is taken as reached: what double precision leaves of it after a projection.
const TIED: f64 = 1.0 - 1e-9;

impl Domain for Followable<'_> {
    fn times(&self) -> &[f64] {
        &self.times
    }

    fn stiffness(&self) -> &[f64] {
        self.stiffness
    }

    fn aim(&mut self, gradient: &[f64], step: f64) -> f64 {
        let n = self.squares.len();
        self.pull_back(gradient);
        let mut step = step;
        if !self.earlier.is_empty() {
            // Of the last move the spectral step too, in these unknowns: the move in times over the curvature along it.
            let turned = |i: usize| self.slope[i] - self.earlier[i];
            let moved = sum(n, |i| self.stiff(i) * (self.inner(i) * self.way[i]) * (self.inner(i) * self.way[i]));
            let spectral = moved / sum(n, |i| self.way[i] * turned(i));
            if spectral.is_finite() && spectral > 0.0 {
                step = spectral;
            }
            self.memory.add(|i| self.way[i], turned, n);
        }
        if self.newton() {
            let slope = self.project();
            if slope < 0.0 {
                return slope;
            }
        }
        for i in 0..n {
            let (u, length) = (self.squares[i], self.segments.length[i]);
            let (time, inner, step) = (length / u.sqrt(), self.inner(i), step / self.stiff(i));
            // A time may shrink to half in a step, so that the square grows to four times itself: beyond that the
            // gradient of here says nothing.
            let wanted = (time - step * self.slope[i] / inner).max(0.5 * time);
            let square = (length / wanted) * (length / wanted);
            self.way[i] = square;
            let ratio = -self.slope[i] / (square - u);
            // What the segment's own step makes of its gradient; where it hardly moves, the limit of that.
            let moves = (square - u).abs() > 1e-9 * u && ratio > 0.0;
            self.weights[i] = if moves { ratio } else { inner * inner / step };
        }
        self.project()
    }

    fn at(&self, length: f64, times: &mut [f64]) {
        let speeds: Vec<f64> =
            self.squares.iter().zip(&self.way).map(|(square, way)| (square + length * way).sqrt()).collect();
        times.copy_from_slice(&speed::times(&speeds, self.segments, self.limits));
    }

    fn go(&mut self, length: f64, _: &[f64]) {
        for (square, way) in self.squares.iter_mut().zip(&mut self.way) {
            *way *= length;
            *square += *way;
        }
        self.earlier.clone_from(&self.slope);
        let speeds = self.speeds();
        self.times = speed::times(&speeds, self.segments, self.limits);
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
        self.memory = Memory::default();
        self.earlier.clear();
        let speeds = self.speeds();
        self.times = speed::times(&speeds, self.segments, self.limits);
    }
}
