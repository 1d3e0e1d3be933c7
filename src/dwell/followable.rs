//! Times that the arm can follow.
//!
//! In: the segments, the limits of feed, acceleration and cornering, speeds to start from. Out: a [`Domain`] of the times of the
//! speeds that keep them all.
//!
//! In times or speeds the limit of acceleration bounds a set that is not convex. In squares of speeds u = v² it is a chain,
//! `|u_i - u_(i-1)| <= 2 a ds_i`, and the [nearest point of it](super::chain) is found exactly. So the unknowns are the u. A step is a
//! scaled projected gradient (S. Bonettini, R. Zanella, L. Zanni, "A scaled gradient projection method for constrained image
//! deblurring", Inverse Problems 25, 2009): each segment's time alone would go the way of the spectral step, its u is where that time
//! leads, and the projection weighs segments by how far that is. The times follow the ramps of [`speed`](super::speed) exactly.

use super::chain;
use super::descent::Domain;
use super::objective::dot;
use super::speed::{self, Limits, Segments};

/// Times of speeds that the arm can follow.
pub struct Followable<'a> {
    segments: &'a Segments,
    limits: &'a Limits,
    /// Greatest square, and how far from the one before, of each segment.
    high: Vec<f64>,
    reach: Vec<f64>,
    squares: Vec<f64>,
    times: Vec<f64>,
    way: Vec<f64>,
    wanted: Vec<f64>,
    slope: Vec<f64>,
    weights: Vec<f64>,
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
            high,
            reach,
            squares: speeds.iter().map(|v| v * v).collect(),
            times: speed::times(speeds, segments, limits),
            way: vec![0.0; n],
            wanted: vec![0.0; n],
            slope: vec![0.0; n],
            weights: vec![0.0; n],
            best: Vec::new(),
        }
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
}

impl Domain for Followable<'_> {
    fn times(&self) -> &[f64] {
        &self.times
    }

    fn aim(&mut self, gradient: &[f64], step: f64) -> f64 {
        self.pull_back(gradient);
        for i in 0..self.squares.len() {
            let (u, length) = (self.squares[i], self.segments.length[i]);
            let time = length / u.sqrt();
            // Change of the plain time with u.
            let inner = -0.5 * time / u;
            // A time may shrink to half in a step, so that the square grows to four times itself: beyond that the
            // gradient of here says nothing.
            let wanted = (time - step * self.slope[i] / inner).max(0.5 * time);
            let square = (length / wanted) * (length / wanted);
            self.wanted[i] = square;
            let newton = inner * inner / step;
            let ratio = -self.slope[i] / (square - u);
            // What the segment's own step makes of its gradient; where it hardly moves, the limit of that.
            self.weights[i] = if (square - u).abs() > 1e-9 * u && ratio > 0.0 { ratio } else { newton };
        }
        self.way.copy_from_slice(&self.wanted);
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

    fn at(&self, length: f64, times: &mut [f64]) {
        let speeds: Vec<f64> =
            self.squares.iter().zip(&self.way).map(|(square, way)| (square + length * way).sqrt()).collect();
        times.copy_from_slice(&speed::times(&speeds, self.segments, self.limits));
    }

    fn go(&mut self, length: f64, _: &[f64]) {
        for (square, way) in self.squares.iter_mut().zip(&self.way) {
            *square += length * way;
        }
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
        Box::new(Followable::new(self.segments, self.limits, &self.speeds()))
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
        let speeds = self.speeds();
        self.times = speed::times(&speeds, self.segments, self.limits);
    }
}
