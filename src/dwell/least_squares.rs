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
    /// Stop when ten steps together have lowered the weighted RMS of the residual by less than this part of itself,
    /// or the RMS with `elsewhere` added in squares by less than a tenth of this part.
    pub relative_decrease: f64,
    /// RMS of what will be left whatever the solver does, in the unit of b.
    pub elsewhere: f64,
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
    let mut earlier_gradient = gradient.clone();
    let mut moved = vec![0.0; rows];
    // First step: the exact one along the gradient.
    operator.forward(&gradient, &mut moved);
    let first = dot(&gradient, &gradient) / weighted_square(&moved, wanted.weights);
    let mut step = if first.is_finite() && first > 0.0 { first } else { 1.0 };
    let (least_step, greatest_step) = (1e-10 * step, 1e10 * step);

    for iteration in 1..=stop.most_iterations {
        for (i, direction) in direction.iter_mut().enumerate() {
            let to = (times[i] - step * gradient[i]).max(wanted.lower[i]).min(wanted.upper[i]);
            *direction = to - times[i];
        }
        let largest = direction.iter().fold(0.0f64, |most, d| most.max(d.abs()));
        let slope = dot(&direction, &gradient);
        let mean = sum(unknowns, |i| times[i]) / unknowns.max(1) as f64;
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
        earlier_gradient.copy_from_slice(&gradient);
        operator.transpose(&residual, &mut gradient);
        let curvature = sum(unknowns, |i| direction[i] * (gradient[i] - earlier_gradient[i]));
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
            let (all_earlier, all) = (libm::hypot(earlier, stop.elsewhere), libm::hypot(best.rms, stop.elsewhere));
            earlier - best.rms < stop.relative_decrease * earlier
                || all_earlier - all < 0.1 * stop.relative_decrease * all_earlier
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
    let n = depths.len();
    let (wanted_depths, weights) = (&wanted.depths[..n], &wanted.weights[..n]);
    let (moved, length) = moved.map_or((depths, 0.0), |(moved, length)| (&moved[..n], length));
    let excess = |i: usize| depths[i] + length * moved[i] - wanted_depths[i];
    let base = match wanted.base {
        Base::Fixed(base) => base,
        Base::AtMost(most) if weight > 0.0 => (sum(n, |i| weights[i] * excess(i)) / weight).min(most),
        Base::AtMost(_) => 0.0,
    };
    if let Some(residual) = residual {
        for (i, residual) in residual[..n].iter_mut().enumerate() {
            *residual = weights[i] * (excess(i) - base);
        }
    }
    let square = |i: usize| {
        let r = excess(i) - base;
        weights[i] * r * r
    };
    (0.5 * sum(n, square), base)
}

/// Sum over `0 .. n` in four interleaved lanes: always in the same order, and fast.
fn sum(n: usize, term: impl Fn(usize) -> f64) -> f64 {
    let mut lanes = [0.0; 4];
    for quad in 0..n / 4 {
        for (lane, total) in lanes.iter_mut().enumerate() {
            *total += term(4 * quad + lane);
        }
    }
    let rest: f64 = (n / 4 * 4..n).map(&term).sum();
    (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]) + rest
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let b = &b[..a.len()];
    sum(a.len(), |i| a[i] * b[i])
}

fn weighted_square(a: &[f64], weights: &[f64]) -> f64 {
    let weights = &weights[..a.len()];
    sum(a.len(), |i| weights[i] * a[i] * a[i])
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::linalg::solvers::Solve;
    use proptest::prelude::*;

    struct Dense {
        rows: usize,
        unknowns: usize,
        values: Vec<f64>,
    }

    impl LinearOperator for Dense {
        fn unknowns(&self) -> usize {
            self.unknowns
        }
        fn rows(&self) -> usize {
            self.rows
        }
        fn forward(&mut self, times: &[f64], depths: &mut [f64]) {
            for (depth, row) in depths.iter_mut().zip(self.values.chunks_exact(self.unknowns)) {
                *depth = row.iter().zip(times).map(|(h, t)| h * t).sum();
            }
        }
        fn transpose(&mut self, depths: &[f64], times: &mut [f64]) {
            times.fill(0.0);
            for (depth, row) in depths.iter().zip(self.values.chunks_exact(self.unknowns)) {
                for (time, h) in times.iter_mut().zip(row) {
                    *time += h * depth;
                }
            }
        }
    }

    /// Well-conditioned: random entries and a strong diagonal.
    fn dense(rows: usize, unknowns: usize, random: &[f64]) -> Dense {
        let values =
            (0..rows * unknowns).map(|i| random[i] + if i / unknowns == i % unknowns { 3.0 } else { 0.0 }).collect();
        Dense { rows, unknowns, values }
    }

    const EXACT: Stop =
        Stop { most_iterations: 2000, relative_decrease: 0.0, elsewhere: 0.0, rms: 0.0, relative_step: 1e-13 };

    const ROWS: usize = 12;
    const UNKNOWNS: usize = 7;

    proptest! {
        // The conditions of Karush, Kuhn and Tucker are necessary and sufficient here (the problem is convex): inside its
        // bounds a time has no slope, at the lower bound it would only rise, at the upper only fall; and the even
        // layer balances the residual or stands at its own bound with the residual pushing outwards.
        #[test]
        fn the_answer_is_the_minimum(
            random in prop::collection::vec(-1.0f64..1.0, ROWS * UNKNOWNS),
            depths in prop::collection::vec(-3.0f64..6.0, ROWS),
            weights in prop::collection::vec(0.0f64..1.0, ROWS),
            lower in prop::collection::vec(-0.5f64..0.5, UNKNOWNS),
            width in prop::collection::vec(0.0f64..2.0, UNKNOWNS),
            free in prop::option::of(-1.0f64..1.0),
        ) {
            let mut operator = dense(ROWS, UNKNOWNS, &random);
            let upper: Vec<f64> = lower.iter().zip(&width).map(|(l, w)| l + w).collect();
            let base = free.map_or(Base::Fixed(0.25), Base::AtMost);
            let wanted = Wanted { depths: &depths, weights: &weights, lower: &lower, upper: &upper, base };
            let found = solve(&mut operator, &wanted, &[0.0; UNKNOWNS], EXACT);
            let mut residual = vec![0.0; ROWS];
            operator.forward(&found.times, &mut residual);
            for i in 0..ROWS {
                residual[i] = weights[i] * (residual[i] - depths[i] - found.base);
            }
            let mut slope = vec![0.0; UNKNOWNS];
            operator.transpose(&residual, &mut slope);
            for i in 0..UNKNOWNS {
                let (t, l, u) = (found.times[i], lower[i], upper[i]);
                prop_assert!(t >= l && t <= u);
                if t > l + 1e-9 {
                    prop_assert!(slope[i] < 1e-6, "time {} could fall: {}", i, slope[i]);
                }
                if t < u - 1e-9 {
                    prop_assert!(slope[i] > -1e-6, "time {} could rise: {}", i, slope[i]);
                }
            }
            let balance: f64 = residual.iter().sum();
            match base {
                Base::Fixed(base) => prop_assert_eq!(found.base, base),
                Base::AtMost(most) => {
                    prop_assert!(found.base <= most);
                    // A residual above zero asks for a deeper layer, which only the limit may forbid.
                    prop_assert!(balance.abs() < 1e-9 || (found.base == most && balance > 0.0), "{} {}", balance, found.base);
                }
            }
        }

        // Without bounds in the way the answer is the solution of the normal equations, by faer's dense solver.
        #[test]
        fn without_bounds_it_is_the_dense_solution(
            random in prop::collection::vec(-1.0f64..1.0, ROWS * UNKNOWNS),
            depths in prop::collection::vec(-3.0f64..6.0, ROWS),
        ) {
            let mut operator = dense(ROWS, UNKNOWNS, &random);
            let (lower, upper, weights) = ([-1e6; UNKNOWNS], [1e6; UNKNOWNS], [1.0; ROWS]);
            let wanted =
                Wanted { depths: &depths, weights: &weights, lower: &lower, upper: &upper, base: Base::Fixed(0.0) };
            let found = solve(&mut operator, &wanted, &[0.0; UNKNOWNS], EXACT);
            let h = faer::Mat::from_fn(ROWS, UNKNOWNS, |i, j| operator.values[i * UNKNOWNS + j]);
            let b = faer::Mat::from_fn(ROWS, 1, |i, _| depths[i]);
            let expected = (h.transpose() * &h).partial_piv_lu().solve(h.transpose() * b);
            // Random matrices of this kind have condition numbers of the normal equations up to about 1e4.
            for i in 0..UNKNOWNS {
                prop_assert!((found.times[i] - expected[(i, 0)]).abs() < 1e-6, "{} {}", found.times[i], expected[(i, 0)]);
            }
        }
    }

    #[test]
    fn a_free_layer_takes_what_all_rows_share() {
        // H = identity, bounds 1 .. 2, wanted -1, 0, 1. With c = 2 all three lie at 1, 2, 3: the last stops at 2. The best c
        // moves down until the residuals balance: t = (1, c, 2) leaves 1 - c + 1, 0, 2 - c - 1, zero in sum at c = 1.5:
        // t = (1, 1.5, 2), residuals 0.5, 0, -0.5.
        let mut operator = Dense { rows: 3, unknowns: 3, values: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0] };
        let (depths, weights, lower, upper) = ([-1.0, 0.0, 1.0], [1.0; 3], [1.0; 3], [2.0; 3]);
        let wanted = |base| Wanted { depths: &depths, weights: &weights, lower: &lower, upper: &upper, base };
        let free = solve(&mut operator, &wanted(Base::AtMost(f64::INFINITY)), &[1.0; 3], EXACT);
        assert!((free.base - 1.5).abs() < 1e-9 && (free.times[1] - 1.5).abs() < 1e-9);
        assert!((free.rms - (0.5f64 / 3.0).sqrt()).abs() < 1e-9);
        // Held at 1: t = (1, 1, 2), residuals 1, 0, 0.
        let bounded = solve(&mut operator, &wanted(Base::AtMost(1.0)), &[2.0; 3], EXACT);
        assert!((bounded.base - 1.0).abs() < 1e-12 && (bounded.rms - (1.0f64 / 3.0).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn nothing_to_do_ends_at_once() {
        let mut operator = Dense { rows: 1, unknowns: 2, values: vec![0.0, 0.0] };
        let wanted =
            Wanted { depths: &[1.0], weights: &[1.0], lower: &[0.5; 2], upper: &[1.0; 2], base: Base::Fixed(0.0) };
        let found = solve(&mut operator, &wanted, &[0.0; 2], EXACT);
        assert_eq!((found.iterations, found.times.as_slice()), (0, &[0.5, 0.5][..]));
    }
}
