//! Bounded least squares: the times that come nearest to a wanted removal.
//!
//! In: a linear operator H, wanted depths b with weights w, bounds of the times, and whether an even layer c may be added
//! to what is wanted. Out: `min over lower <= t <= upper and c of 1/2 sum w (H t - b - c)²`.
//!
//! Method: spectral projected gradient: steps of Barzilai and Borwein, projected on the bounds, with a non-monotone line
//! search over the last ten values (E. G. Birgin, J. M. Martínez, M. Raydan, "Nonmonotone spectral projected gradient
//! methods on convex sets", SIAM J. Optim. 10, 2000, algorithm SPG2). The problem is quadratic along each line, so a step costs one
//! product with H and one with its transpose. c is eliminated: for given t the best one is a clamped mean.

/// A linear map from times to depths. It may keep room to work in.
pub trait LinearOperator {
    fn unknowns(&self) -> usize;
    fn rows(&self) -> usize;
    /// `depths = H times`.
    fn forward(&mut self, times: &[f64], depths: &mut [f64]);
    /// `times = H' depths`, the exact transpose.
    fn transpose(&mut self, depths: &[f64], times: &mut [f64]);
}

/// Whether an even layer is added to the wanted depths, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Base {
    Fixed(f64),
    /// Chosen with the times, at most this.
    AtMost(f64),
}

/// What is wanted.
pub struct Wanted<'a> {
    /// b, the unit of H t.
    pub depths: &'a [f64],
    /// w >= 0; zero leaves the row out.
    pub weights: &'a [f64],
    pub lower: &'a [f64],
    pub upper: &'a [f64],
    pub base: Base,
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    pub most_iterations: usize,
    /// Stop when ten steps together have lowered the weighted RMS of the residual by less than this part of itself.
    pub relative_decrease: f64,
    /// Stop when the RMS of the residual is below this, in the unit of b.
    pub rms: f64,
    /// Stop when a projected step changes no time by more than this part of the mean time.
    pub relative_step: f64,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    pub times: Vec<f64>,
    /// The even layer c.
    pub base: f64,
    /// Weighted root mean square of `H t - b - c`.
    pub rms: f64,
    pub iterations: usize,
}

/// Values of the objective that a step may exceed the last of: the window of the non-monotone line search.
const MEMORY: usize = 10;

/// Solves from `start`, which is first projected on the bounds. `lower <= upper` must hold, lengths must agree.
pub fn solve(operator: &mut dyn LinearOperator, wanted: &Wanted, start: &[f64], stop: Stop) -> Solution {
    let (unknowns, rows) = (operator.unknowns(), operator.rows());
    let weight: f64 = wanted.weights.iter().sum();
    let mut times = start.to_vec();
    project(&mut times, wanted);
    let mut depths = vec![0.0; rows];
    operator.forward(&times, &mut depths);
    let mut residual = vec![0.0; rows];
    let mut gradient = vec![0.0; unknowns];
    let (mut value, mut base) = objective(&depths, None, wanted, weight, Some(&mut residual));
    operator.transpose(&residual, &mut gradient);
    let rms = |value: f64| if weight > 0.0 { (2.0 * value / weight).sqrt() } else { 0.0 };
    let mut best = Solution { times: times.clone(), base, rms: rms(value), iterations: 0 };
    let mut values = vec![value];
    let mut bests = vec![best.rms];
    let mut direction = vec![0.0; unknowns];
    let mut moved = vec![0.0; rows];
    // First step: the exact one along the gradient.
    operator.forward(&gradient, &mut moved);
    let first = dot(&gradient, &gradient) / weighted_square(&moved, wanted.weights);
    let mut step = if first.is_finite() && first > 0.0 { first } else { 1.0 };
    let (least_step, greatest_step) = (1e-10 * step, 1e10 * step);

    for iteration in 1..=stop.most_iterations {
        let mut largest = 0.0f64;
        let mut slope = 0.0;
        for i in 0..unknowns {
            let to = (times[i] - step * gradient[i]).max(wanted.lower[i]).min(wanted.upper[i]);
            direction[i] = to - times[i];
            largest = largest.max(direction[i].abs());
            slope += direction[i] * gradient[i];
        }
        let mean = times.iter().sum::<f64>() / unknowns.max(1) as f64;
        // No feasible way down is left (or none that a time could show). The comparison is written so that it also
        // ends the loop if anything is not a number.
        let way_down = largest > stop.relative_step * mean && slope < 0.0;
        if !way_down {
            break;
        }
        operator.forward(&direction, &mut moved);
        let ceiling = values.iter().rev().take(MEMORY).fold(f64::NEG_INFINITY, |a, b| a.max(*b));
        let mut length = 1.0;
        loop {
            let (trial, _) = objective(&depths, Some((&moved, length)), wanted, weight, None);
            // Sufficient decrease with the usual factor 1e-4; below 1e-10 the arithmetic itself is the obstacle.
            if trial <= ceiling + 1e-4 * length * slope || length < 1e-10 {
                break;
            }
            // The minimum of the parabola through value, slope and trial, kept inside a tenth and a half.
            let curvature = trial - value - length * slope;
            let minimum = -slope * length * length / (2.0 * curvature);
            length = if minimum.is_finite() { minimum.clamp(0.1 * length, 0.5 * length) } else { 0.5 * length };
        }
        for (time, d) in times.iter_mut().zip(&direction) {
            *time += length * d;
        }
        project(&mut times, wanted);
        for (depth, m) in depths.iter_mut().zip(&moved) {
            *depth += length * m;
        }
        (value, base) = objective(&depths, None, wanted, weight, Some(&mut residual));
        // Barzilai-Borwein: s's / s'y with s the move and y the change of the gradient.
        let before = gradient.clone();
        operator.transpose(&residual, &mut gradient);
        let mut curvature = 0.0;
        for i in 0..unknowns {
            curvature += direction[i] * (gradient[i] - before[i]);
        }
        let next = length * dot(&direction, &direction) / curvature;
        step = if next.is_finite() && next > 0.0 { next.clamp(least_step, greatest_step) } else { greatest_step };
        values.push(value);
        if rms(value) < best.rms {
            best.times.copy_from_slice(&times);
            best.base = base;
            best.rms = rms(value);
        }
        best.iterations = iteration;
        bests.push(best.rms);
        let slow = bests.len() > MEMORY && {
            let earlier = bests[bests.len() - 1 - MEMORY];
            earlier - best.rms < stop.relative_decrease * earlier
        };
        if slow || best.rms <= stop.rms {
            break;
        }
    }
    best
}

/// Weighted RMS of the residual of given times, and the even layer that suits them best.
pub fn evaluate(operator: &mut dyn LinearOperator, wanted: &Wanted, times: &[f64]) -> (f64, f64) {
    let mut depths = vec![0.0; operator.rows()];
    operator.forward(times, &mut depths);
    let weight: f64 = wanted.weights.iter().sum();
    let (value, base) = objective(&depths, None, wanted, weight, None);
    (if weight > 0.0 { (2.0 * value / weight).sqrt() } else { 0.0 }, base)
}

fn project(times: &mut [f64], wanted: &Wanted) {
    for ((time, lower), upper) in times.iter_mut().zip(wanted.lower).zip(wanted.upper) {
        *time = time.max(*lower).min(*upper);
    }
}

/// Half the weighted square sum of `depths + length * moved - b - c`, and the best c; into `residual` the weighted
/// residual `w (H t - b - c)`, of which the transpose makes the gradient.
fn objective(
    depths: &[f64],
    moved: Option<(&[f64], f64)>,
    wanted: &Wanted,
    weight: f64,
    residual: Option<&mut Vec<f64>>,
) -> (f64, f64) {
    let excess = |i: usize| match moved {
        Some((moved, length)) => depths[i] + length * moved[i] - wanted.depths[i],
        None => depths[i] - wanted.depths[i],
    };
    let base = match wanted.base {
        Base::Fixed(base) => base,
        Base::AtMost(most) => {
            let sum: f64 = (0..depths.len()).map(|i| wanted.weights[i] * excess(i)).sum();
            if weight > 0.0 { (sum / weight).min(most) } else { 0.0 }
        }
    };
    let mut value = 0.0;
    match residual {
        Some(residual) => {
            for i in 0..depths.len() {
                let r = excess(i) - base;
                residual[i] = wanted.weights[i] * r;
                value += residual[i] * r;
            }
        }
        None => {
            for i in 0..depths.len() {
                let r = excess(i) - base;
                value += wanted.weights[i] * r * r;
            }
        }
    }
    (0.5 * value, base)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn weighted_square(a: &[f64], weights: &[f64]) -> f64 {
    a.iter().zip(weights).map(|(a, w)| w * a * a).sum()
}
