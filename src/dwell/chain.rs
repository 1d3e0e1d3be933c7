//! The nearest chain of numbers whose neighbours do not differ too much.
//!
//! In: numbers y with weights m > 0, bounds, and how much each may differ from the one before. Out: the x that is
//! `min 1/2 sum m (x - y)²` with `low <= x_i <= high_i` and `|x_i - x_(i-1)| <= reach_i`: squares of speeds that an arm of limited
//! acceleration can follow.
//!
//! Method: dynamic programming over the chain, exact. What the chain so far costs, as a function of its last number, is convex,
//! and its slope is piecewise linear. To the next number it passes on with its left half moved left and its right half moved
//! right by `reach`, the gap between them level; then the next parabola is added. Only the place of the minimum is needed of
//! each; backwards, each number is the nearest to that place that its successor allows.

/// A place where the slope changes: its jump, and the jump of its own slope.
#[derive(Clone, Copy)]
struct Knot {
    place: f64,
    slope: f64,
    bend: f64,
}

/// The slope of the cost of the chain so far, around its minimum. Knots are kept outwards from it, the nearest last; the
/// sides move as wholes, so their places are kept without their shift.
struct Cost {
    left: Vec<Knot>,
    right: Vec<Knot>,
    shift: f64,
    /// Where the minimum is; slope and bend on both sides of it.
    at: f64,
    before: [f64; 2],
    after: [f64; 2],
}

impl Cost {
    /// The two halves part by `reach` each way.
    fn widen(&mut self, reach: f64) {
        let place = self.at - self.shift;
        // Kept in the coordinates of each side before the shift that now grows.
        self.left.push(Knot { place: self.at + self.shift, slope: -self.before[0], bend: -self.before[1] });
        self.right.push(Knot { place, slope: self.after[0], bend: self.after[1] });
        self.shift += reach;
    }

    /// Adds `1/2 weight (x - wanted)²` and finds the new minimum in `low ..= high`. The slope is level around `at`.
    fn add(&mut self, wanted: f64, weight: f64, low: f64, high: f64) {
        // Of the linear piece in hand: its slope at x is value + bend * (x - x0).
        let mut x0 = wanted;
        let (mut value, mut bend) = (0.0, weight);
        // Leftwards while the piece is still rising at its left end, rightwards while it falls at its right end.
        loop {
            let left = self.left.last().map(|knot| knot.place - self.shift).unwrap_or(f64::NEG_INFINITY);
            let right = self.right.last().map(|knot| knot.place + self.shift).unwrap_or(f64::INFINITY);
            let at_left = value + bend * (left - x0);
            let at_right = value + bend * (right - x0);
            if left.is_finite() && left >= low && at_left > 0.0 {
                let Some(knot) = self.left.pop() else { break };
                if at_left - knot.slope <= 0.0 && left <= high {
                    // The slope jumps through zero here.
                    (self.at, self.before, self.after) =
                        (left, [at_left - knot.slope, bend - knot.bend], [at_left, bend]);
                    return;
                }
                self.right.push(Knot { place: left - self.shift, ..knot });
                (x0, value, bend) = (left, at_left - knot.slope, (bend - knot.bend).max(weight));
            } else if right.is_finite() && right <= high && at_right < 0.0 {
                let Some(knot) = self.right.pop() else { break };
                if at_right + knot.slope >= 0.0 && right >= low {
                    (self.at, self.before, self.after) =
                        (right, [at_right, bend], [at_right + knot.slope, bend + knot.bend]);
                    return;
                }
                self.left.push(Knot { place: right + self.shift, ..knot });
                (x0, value, bend) = (right, at_right + knot.slope, (bend + knot.bend).max(weight));
            } else {
                break;
            }
        }
        let place = (x0 - value / bend).max(low).min(high);
        // Knots that the new upper bound has cut off.
        while let Some(knot) = self.left.pop_if(|knot| knot.place - self.shift >= place) {
            let left = knot.place - self.shift;
            (value, bend) = (value + bend * (left - x0) - knot.slope, (bend - knot.bend).max(weight));
            x0 = left;
        }
        let slope = value + bend * (place - x0);
        self.at = place;
        // At a bound the cost rises without end beyond it, which the bounds themselves take care of.
        self.before = [slope.min(0.0), bend];
        self.after = [slope.max(0.0), bend];
    }
}

/// One chain. `high_i >= low` must hold, and `reach_i >= 0`; `reach[0]` is not used. `x` holds the wanted numbers and becomes
/// the nearest ones.
pub fn project(x: &mut [f64], weights: &[f64], low: f64, high: &[f64], reach: &[f64]) {
    let n = x.len();
    let Some(&first) = x.first() else { return };
    let mut cost = Cost {
        left: Vec::with_capacity(n),
        right: Vec::with_capacity(n),
        shift: 0.0,
        at: first,
        before: [0.0; 2],
        after: [0.0; 2],
    };
    // Greatest value that the chain can have so far.
    let mut most = f64::INFINITY;
    for i in 0..n {
        if i > 0 {
            cost.widen(reach[i]);
            most += reach[i];
        }
        most = most.min(high[i]);
        cost.add(x[i], weights[i], low, most);
        x[i] = cost.at;
    }
    for i in (1..n).rev() {
        // The bounds again, for rounding alone.
        x[i - 1] = x[i - 1].max(x[i] - reach[i]).min(x[i] + reach[i]).max(low).min(high[i - 1]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clarabel::algebra::CscMatrix;
    use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
    use proptest::prelude::*;

    /// The same by an interior-point solver.
    fn oracle(y: &[f64], weights: &[f64], low: f64, high: &[f64], reach: &[f64]) -> Vec<f64> {
        let n = y.len();
        let p = CscMatrix::from(
            &(0..n)
                .map(|i| (0..n).map(|j| if i == j { weights[i] } else { 0.0 }).collect::<Vec<_>>())
                .collect::<Vec<_>>(),
        );
        let q: Vec<f64> = y.iter().zip(weights).map(|(y, w)| -y * w).collect();
        let (mut rows, mut limits) = (Vec::new(), Vec::new());
        let mut add = |entries: &[(usize, f64)], limit: f64| {
            let mut row = vec![0.0; n];
            entries.iter().for_each(|(i, value)| row[*i] = *value);
            rows.push(row);
            limits.push(limit);
        };
        for i in 0..n {
            add(&[(i, 1.0)], high[i]);
            add(&[(i, -1.0)], -low);
            if i > 0 {
                add(&[(i, 1.0), (i - 1, -1.0)], reach[i]);
                add(&[(i, -1.0), (i - 1, 1.0)], reach[i]);
            }
        }
        let cones = [SupportedConeT::NonnegativeConeT(limits.len())];
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: 1e-11,
            tol_gap_rel: 1e-11,
            tol_feas: 1e-11,
            ..DefaultSettings::default()
        };
        let mut solver =
            DefaultSolver::new(&p, &q, &CscMatrix::from(&rows), &limits, &cones, settings).expect("a problem");
        solver.solve();
        solver.solution.x.clone()
    }

    proptest! {
        #[test]
        fn it_is_the_quadratic_programs_answer(
            n in 1usize..14,
            y in prop::collection::vec(-1.0f64..3.0, 14),
            weights in prop::collection::vec(0.1f64..5.0, 14),
            high in prop::collection::vec(0.2f64..2.0, 14),
            reach in prop::collection::vec(0.0f64..0.6, 14),
        ) {
            let mut found = y[..n].to_vec();
            project(&mut found, &weights[..n], 0.1, &high[..n], &reach[..n]);
            let expected = oracle(&y[..n], &weights[..n], 0.1, &high[..n], &reach[..n]);
            for i in 0..n {
                prop_assert!(found[i] >= 0.1 && found[i] <= high[i]);
                prop_assert!(i == 0 || (found[i] - found[i - 1]).abs() <= reach[i] * (1.0 + 1e-12) + 1e-15);
                prop_assert!((found[i] - expected[i]).abs() < 1e-5, "{:?} {:?}", found, expected);
            }
        }
    }
}
