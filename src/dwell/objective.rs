//! What is to be small: the size of a residual over the pixels that count.
//!
//! In: depths, the wanted ones, weights, whether an even layer may be taken out. Out: one number, the even layer that suits
//! it best, and the slope over the depths.

use super::descent::LinearOperator;
use super::vectors::{each, pass, sum, sums};

/// Whether an even layer is added to the wanted depths, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Base {
    Fixed(f64),
    /// Chosen with the times, at most this.
    AtMost(f64),
}

/// The size F of a residual `r = H t - b - c`, over rows with weights w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Objective {
    /// `1/2 sum w r²`.
    Squares,
    /// `1/p log sum w (exp(p r) + exp(-p r))`: a smooth stand-in for the largest |r|, never below it (by at most `log(1/w)/p` where a
    /// rim pixel counts in part), above it by at most
    /// `log(2 sum w)/p`. With the even layer free it is half of a smooth peak to valley. `sharpness` is p, one over the
    /// unit of r.
    Largest { sharpness: f64 },
    /// `1/2 sum w (r² + stiffness max(0, |r| - most)²)`: the squares of residuals that should stay within `most`. The even layer
    /// must be fixed.
    SquaresWithin { most: f64, stiffness: f64 },
}

/// What is wanted.
pub struct Wanted<'a> {
    /// b, the unit of H t.
    pub depths: &'a [f64],
    /// w >= 0; zero leaves the row out.
    pub weights: &'a [f64],
    pub base: Base,
    pub objective: Objective,
    pub price: Price,
}

/// What a second of the run may cost of F.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Price {
    /// λ of `min F + λ sum t`. Zero where time does not count.
    Fixed(f64),
    /// `min sum t` with an F of at most `most`: λ is looked for, from `first` on where it is about known, otherwise 0.
    Sought { most: f64, first: f64 },
}

impl Price {
    /// Time does not count.
    pub const NONE: Price = Price::Fixed(0.0);
}

/// `depths + length * moved`, or `depths` alone.
#[derive(Clone, Copy)]
pub struct Trial<'a> {
    pub depths: &'a [f64],
    pub moved: &'a [f64],
    pub length: f64,
}

impl Trial<'_> {
    pub fn here(depths: &[f64]) -> Trial<'_> {
        Trial { depths, moved: depths, length: 0.0 }
    }
}

/// `max x + 1/p log sum w exp(p (x - max x))` over the n entries `x(i)` that have weight, in two parts: the greatest
/// entry, and the sum. Beyond 40 the exponential adds nothing to a number of 53 bits.
fn soft_maximum(weights: &[f64], sharpness: f64, x: impl Fn(usize) -> f64 + Sync) -> (f64, f64) {
    let n = weights.len();
    let greatest = (0..n).filter(|&i| weights[i] > 0.0).fold(f64::NEG_INFINITY, |most, i| most.max(x(i)));
    let term = |i: usize| weights[i] * share(sharpness * (x(i) - greatest));
    (greatest, if greatest.is_finite() { sum(n, term) } else { 0.0 })
}

/// `exp(z)` for z <= 0; zero where it is lost in the rounding of 1.
fn share(z: f64) -> f64 {
    if z > -40.0 { libm::exp(z) } else { 0.0 }
}

/// `1/p log sum w exp(p x)`, and its slope over each x: the shares, which add up to 1.
pub fn log_sum_exp(values: &[f64], weights: &[f64], sharpness: f64) -> (f64, Vec<f64>) {
    let (greatest, total) = soft_maximum(weights, sharpness, |i| values[i]);
    let shares = (0..values.len()).map(|i| weights[i] * share(sharpness * (values[i] - greatest)) / total).collect();
    (greatest + libm::log(total) / sharpness, shares)
}

impl Wanted<'_> {
    /// Size of the residual of a trial, and the even layer that suits it; into `slope` the derivative over each depth.
    pub fn measure(&self, trial: Trial, slope: Option<&mut [f64]>) -> (f64, f64) {
        let n = trial.depths.len();
        let (wanted, weights) = (&self.depths[..n], &self.weights[..n]);
        let (depths, moved, length) = (&trial.depths[..n], &trial.moved[..n], trial.length);
        let excess = |i: usize| depths[i] + length * moved[i] - wanted[i];
        match self.objective {
            Objective::Squares => {
                let base = match self.base {
                    Base::Fixed(base) => base,
                    Base::AtMost(most) => {
                        let [weight, excess] = sums(n, |i| [weights[i], weights[i] * excess(i)]);
                        if weight > 0.0 { (excess / weight).min(most) } else { 0.0 }
                    }
                };
                let square = |i: usize, slope: &mut f64| {
                    let r = excess(i) - base;
                    *slope = weights[i] * r;
                    [*slope * r]
                };
                let [squares] = match slope {
                    Some(slope) => pass(&mut slope[..n], square),
                    None => sums(n, |i| square(i, &mut 0.0)),
                };
                (0.5 * squares, base)
            }
            Objective::Largest { sharpness: p } => {
                let (top, above) = soft_maximum(weights, p, excess);
                let (bottom, below) = soft_maximum(weights, p, |i| -excess(i));
                if !(above > 0.0 && below > 0.0) {
                    return (0.0, 0.0);
                }
                let (high, low) = (top + libm::log(above) / p, bottom + libm::log(below) / p);
                // The two sides balance at half their difference.
                let base = match self.base {
                    Base::Fixed(base) => base,
                    Base::AtMost(most) => (0.5 * (high - low)).min(most),
                };
                let sides = [high - base, low + base];
                let larger = sides[0].max(sides[1]);
                let value = larger + libm::log(sum(2, |k| libm::exp(p * (sides[k] - larger)))) / p;
                if let Some(slope) = slope {
                    let up = libm::exp(p * (top - base - value));
                    let down = libm::exp(p * (bottom + base - value));
                    each(&mut slope[..n], |i, slope| {
                        let x = excess(i);
                        *slope = weights[i] * (up * share(p * (x - top)) - down * share(p * (-x - bottom)));
                    });
                }
                (value, base)
            }
            Objective::SquaresWithin { most, stiffness } => {
                let base = match self.base {
                    Base::Fixed(base) | Base::AtMost(base) => base,
                };
                let beyond = |r: f64| (r - r.clamp(-most, most)) * stiffness;
                if let Some(slope) = slope {
                    each(&mut slope[..n], |i, slope| {
                        let r = excess(i) - base;
                        *slope = weights[i] * (r + beyond(r));
                    });
                }
                let square = |i: usize| {
                    let r = excess(i) - base;
                    weights[i] * (r * r + beyond(r) * (r - r.clamp(-most, most)))
                };
                (0.5 * sum(n, square), base)
            }
        }
    }

    /// A bound of the second derivative of F along `moved`, where its slope is `slope`.
    pub fn curvature(&self, moved: &[f64], slope: &[f64]) -> f64 {
        let n = moved.len();
        match self.objective {
            Objective::Squares => sum(n, |i| self.weights[i] * moved[i] * moved[i]),
            Objective::Largest { sharpness } => sharpness * sum(n, |i| slope[i].abs() * moved[i] * moved[i]),
            Objective::SquaresWithin { stiffness, .. } => {
                (1.0 + stiffness) * sum(n, |i| self.weights[i] * moved[i] * moved[i])
            }
        }
    }

    /// Weighted RMS of the residual about the even layer that suits it, that layer, and the largest residual beside the layer
    /// half way between the extremes (as far as it is free): what the objectives are compared by.
    pub fn figures(&self, operator: &mut dyn LinearOperator, times: &[f64]) -> Figures {
        let mut depths = vec![0.0; operator.rows()];
        operator.forward(times, &mut depths);
        let squares = Wanted { objective: Objective::Squares, ..*self };
        let (value, base) = squares.measure(Trial::here(&depths), None);
        let weight = sum(self.weights.len(), |i| self.weights[i]);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in (0..depths.len()).filter(|&i| self.weights[i] > 0.0) {
            let excess = depths[i] - self.depths[i];
            (low, high) = (low.min(excess), high.max(excess));
        }
        let middle = match self.base {
            Base::Fixed(base) => base,
            Base::AtMost(most) => (0.5 * (low + high)).min(most),
        };
        let rms = if weight > 0.0 { (2.0 * value / weight).sqrt() } else { 0.0 };
        let largest = if low <= high { (high - middle).max(middle - low) } else { 0.0 };
        Figures { rms, base, largest, middle, pv: (high - low).max(0.0) }
    }
}

/// See [`Wanted::figures`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    pub rms: f64,
    pub base: f64,
    pub largest: f64,
    pub middle: f64,
    /// Peak to valley.
    pub pv: f64,
}
