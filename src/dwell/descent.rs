//! Descent: the times that bring what is removed nearest to what is wanted.
//!
//! In: a linear operator H, wanted depths with an [objective](super::objective), and a [`Domain`]: the times that may be. Out:
//! `min over t in the domain and c of F(H t - b - c) + λ sum t`, or the least sum of t with an F of at most so much.
//!
//! Method: projected descent along straight ways inside the domain, with the non-monotone line search of E. G. Birgin, J. M.
//! Martínez, M. Raydan, "Nonmonotone spectral projected gradient methods on convex sets", SIAM J. Optim. 10, 2000 (algorithm
//! SPG2). The domain chooses the way: [`Bounds`](super::bounds) by a quasi-Newton step, [`Followable`](super::followable) by a
//! quadratic model's minimum. The depths change linearly on a way between bounds, so that a step costs one product with H and
//! one with its transpose. c is eliminated: for given t the best one is known in closed form.
//!
//! For the least time the price λ of a second is looked for on the way: it rises while less is left than may be, and falls while
//! more is. The price is linear in the times, so that it changes no curvature, and the quasi-Newton memory stays good.

use super::objective::{Price, Trial, Wanted};
use super::price::Search;
use super::vectors::{dot, each, pass, sum, sums};

/// A linear map from times to depths. It may keep room to work in.
pub trait LinearOperator {
    fn unknowns(&self) -> usize;
    fn rows(&self) -> usize;
    /// `depths = H times`.
    fn forward(&mut self, times: &[f64], depths: &mut [f64]);
    /// `times = H' depths`, the exact transpose.
    fn transpose(&mut self, depths: &[f64], times: &mut [f64]);
}

/// The times that may be, and the present ones among them.
pub trait Domain {
    /// The present times.
    fn times(&self) -> &[f64];
    /// How stiff each time is beside the others, about: the second derivative of the objective over it alone, up to a common
    /// factor. Empty where all are alike.
    fn stiffness(&self) -> &[f64];
    /// Looks for a way down, where the objective has this `gradient` over the times; `step` is the inverse of its
    /// curvature on the last way, beside the stiffness. The slope along the whole way: negative, or zero where there is none.
    fn aim(&mut self, gradient: &[f64], step: f64) -> f64;
    /// The times after the part `length` of the way.
    fn at(&self, length: f64, times: &mut [f64]);
    /// Goes so far; `turned` is by how much the gradient changed on the way.
    fn go(&mut self, length: f64, turned: &[f64]);
    /// Whether times change evenly along the way.
    fn is_straight(&self) -> bool;
    /// The present times are the best so far.
    fn keep(&mut self);
    /// Goes back to the best.
    fn take_best(&mut self);
    /// Another one at the same place.
    fn fork(&self) -> Box<dyn Domain + '_>;
    /// Goes the part `length` of the way to where the other domain is, whose [place](Domain::place) it can reach straight.
    fn towards(&mut self, place: &[f64], length: f64);
    /// The unknowns in which ways are straight.
    fn place(&self) -> &[f64];
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// For the least time [`LONGER`] times as many more, once so little is left as is wanted.
    pub most_iterations: usize,
    /// Steps over which progress is judged.
    pub over: usize,
    /// Stop when so many steps together have lowered the objective by less than this part of F, or by less than a tenth of
    /// this part of F with `elsewhere` added.
    pub relative_decrease: f64,
    /// F of what will be left whatever the solver does.
    pub elsewhere: f64,
    /// Stop when F is below this.
    pub value: f64,
    /// Stop when a way changes no time by more than this part of the mean time.
    pub relative_step: f64,
}

/// Why the descent ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// F is as small as was asked.
    Reached,
    /// No way inside the domain leads down.
    NoWayDown,
    /// Steps gain hardly anything any more.
    Slow,
    /// The iterations are used up.
    Iterations,
}

/// What was found; the times are the domain's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// F, without the price of the time.
    pub value: f64,
    /// The last price of a second.
    pub price: f64,
    /// The even layer c.
    pub base: f64,
    pub iterations: usize,
    pub ended: Ended,
}

/// Values of the objective that a step may exceed the last of.
const MEMORY: usize = 10;

/// See [`Stop::most_iterations`].
const LONGER: usize = 4;

/// Descends from the domain's present times to the best that were found.
pub fn descend(operator: &mut dyn LinearOperator, wanted: &Wanted, domain: &mut dyn Domain, stop: Stop) -> Found {
    let (unknowns, rows) = (operator.unknowns(), operator.rows());
    let mut times = domain.times().to_vec();
    let mut depths = vec![0.0; rows];
    operator.forward(&times, &mut depths);
    let mut slopes = vec![0.0; rows];
    let mut gradient = vec![0.0; unknowns];
    let (mut price, sought) = match wanted.price {
        Price::Fixed(price) => (price, None),
        Price::Sought { most, first } => (0.0, Some((most, first))),
    };
    let (mut size, mut base) = wanted.measure(Trial::here(&depths), Some(&mut slopes));
    let mut spent = sum(unknowns, |i| times[i]);
    operator.transpose(&slopes, &mut gradient);
    add(&mut gradient, price);
    domain.keep();
    let mut best = Found { value: size, price, base, iterations: 0, ended: Ended::Iterations };
    // F and the time of every step; the least F with its price so far.
    let mut steps = vec![(size, spent)];
    let mut best_value = size + price * spent;
    let mut bests = vec![best_value];
    let mut search: Option<Search> = None;
    let mut moved = vec![0.0; rows];
    let mut change = vec![0.0; unknowns];
    let mut turned = gradient.clone();
    let stiffness = domain.stiffness().to_vec();
    let stiff = |i: usize| stiffness.get(i).copied().unwrap_or(1.0);
    // First step: the one that the curvature along the gradient asks for.
    each(&mut change, |i, change| *change = gradient[i] / stiff(i));
    operator.forward(&change, &mut moved);
    let first = dot(&gradient, &change) / wanted.curvature(&moved, &slopes);
    let mut step = if first.is_finite() && first > 0.0 { first } else { 1.0 };
    let (least_step, greatest_step) = (1e-10 * step, 1e10 * step);

    let mut most_iterations = stop.most_iterations;
    let mut iteration = 0;
    loop {
        if let (Some((most, first)), None) = (sought, &search)
            && size <= most
        {
            // So little is left as may be: from here on time counts.
            search = Some(Search::new(most, first, spent));
            most_iterations = iteration + LONGER * stop.most_iterations;
        }
        if let Some(search) = &mut search {
            let before = price;
            price = search.price(size, spent);
            add(&mut gradient, price - before);
        }
        if iteration == most_iterations {
            break;
        }
        if sought.is_none() && best.value <= stop.value {
            best.ended = Ended::Reached;
            break;
        }
        let slope = domain.aim(&gradient, step);
        let mut length = 1.0;
        way(domain, length, &times, &mut change);
        let largest = change.iter().fold(0.0f64, |most, d| most.max(d.abs()));
        let mean = spent / unknowns.max(1) as f64;
        // No feasible way down is left (or none that a time could show). The comparison is written so that it also
        // ends the loop if anything is not a number.
        if !(largest > stop.relative_step * mean && slope < 0.0) {
            if search.as_mut().is_some_and(Search::is_stuck) {
                continue;
            }
            best.ended = Ended::NoWayDown;
            break;
        }
        iteration += 1;
        operator.forward(&change, &mut moved);
        let value = size + price * spent;
        let recent = steps.iter().rev().take(MEMORY);
        let ceiling = recent.fold(f64::NEG_INFINITY, |most, (size, spent)| most.max(size + price * spent));
        // Part of the way that `moved` and `change` belong to.
        let mut known = 1.0;
        let part = loop {
            let part = length / known;
            let here = Trial { depths: &depths, moved: &moved, length: part };
            (size, base) = wanted.measure(here, Some(&mut slopes));
            let saved = if price == 0.0 { 0.0 } else { part * sum(unknowns, |i| change[i]) };
            let trial = size + price * (spent + saved);
            // Sufficient decrease with the usual factor 1e-4; below 1e-10 the arithmetic itself is the obstacle.
            if trial <= ceiling + 1e-4 * length * slope || length < 1e-10 {
                break part;
            }
            // The minimum of the parabola through value, slope and trial, kept inside a tenth and a half.
            let curvature = trial - value - length * slope;
            let minimum = -slope * length * length / (2.0 * curvature);
            length = if minimum.is_finite() { minimum.clamp(0.1 * length, 0.5 * length) } else { 0.5 * length };
            if !domain.is_straight() {
                way(domain, length, &times, &mut change);
                operator.forward(&change, &mut moved);
                known = length;
            }
        };
        each(&mut depths, |i, depth| *depth += part * moved[i]);
        [spent] = pass(&mut times, |i, time| {
            *time += part * change[i];
            [*time]
        });
        std::mem::swap(&mut turned, &mut gradient);
        operator.transpose(&slopes, &mut gradient);
        add(&mut gradient, price);
        each(&mut turned, |i, turned| *turned = gradient[i] - *turned);
        domain.go(length, &turned);
        // Barzilai-Borwein: s's / s'y with s the move and y the change of the gradient.
        let [moves, turns] = sums(unknowns, |i| [part * stiff(i) * change[i] * change[i], change[i] * turned[i]]);
        let next = moves / turns;
        step = if next.is_finite() && next > 0.0 { next.clamp(least_step, greatest_step) } else { greatest_step };
        steps.push((size, spent));
        best.iterations = iteration;
        if let Some(search) = &mut search {
            if search.take(size, spent) {
                (best.value, best.base) = (size, base);
                domain.keep();
            }
            if search.is_settled() {
                break;
            }
            continue;
        }
        let value = size + price * spent;
        if value < best_value {
            best_value = value;
            (best.value, best.base) = (size, base);
            domain.keep();
        }
        bests.push(best_value);
        if bests.len() > stop.over {
            let gained = bests[bests.len() - 1 - stop.over] - best_value;
            let enough = stop.relative_decrease * best.value.max(0.1 * (best.value + stop.elsewhere));
            if gained < enough && sought.is_none_or(|(most, _)| size > most) {
                best.ended = Ended::Slow;
                break;
            }
        }
    }
    if search.is_some() {
        best.ended = Ended::Reached;
    }
    best.price = price;
    domain.take_best();
    best
}

/// The change of the times on the part `length` of the way.
fn way(domain: &dyn Domain, length: f64, times: &[f64], change: &mut [f64]) {
    domain.at(length, change);
    each(change, |i, change| *change -= times[i]);
}

/// Adds the price of a second to the gradient over the times.
fn add(gradient: &mut [f64], price: f64) {
    if price != 0.0 {
        each(gradient, |_, gradient| *gradient += price);
    }
}

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::super::objective::{Base, Objective};
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

    const EXACT: Stop = Stop {
        most_iterations: 2000,
        over: 10,
        relative_decrease: 0.0,
        elsewhere: 0.0,
        value: 0.0,
        relative_step: 1e-13,
    };

    fn squares<'a>(depths: &'a [f64], weights: &'a [f64], base: Base) -> Wanted<'a> {
        Wanted { depths, weights, base, objective: Objective::Squares, price: Price::NONE }
    }

    /// What was found, and the times.
    fn solve(operator: &mut Dense, wanted: &Wanted, [lower, upper]: [&[f64]; 2], start: &[f64]) -> (Found, Vec<f64>) {
        let mut domain = Bounds::new(lower, upper, start);
        let found = descend(operator, wanted, &mut domain, EXACT);
        (found, domain.into_times())
    }

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
            let wanted = squares(&depths, &weights, base);
            let (found, times) = solve(&mut operator, &wanted, [&lower, &upper], &[0.0; UNKNOWNS]);
            let mut residual = vec![0.0; ROWS];
            operator.forward(&times, &mut residual);
            for i in 0..ROWS {
                residual[i] = weights[i] * (residual[i] - depths[i] - found.base);
            }
            let mut slope = vec![0.0; UNKNOWNS];
            operator.transpose(&residual, &mut slope);
            for i in 0..UNKNOWNS {
                let (t, l, u) = (times[i], lower[i], upper[i]);
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
            let wanted = squares(&depths, &weights, Base::Fixed(0.0));
            let (_, times) = solve(&mut operator, &wanted, [&lower, &upper], &[0.0; UNKNOWNS]);
            let h = faer::Mat::from_fn(ROWS, UNKNOWNS, |i, j| operator.values[i * UNKNOWNS + j]);
            let b = faer::Mat::from_fn(ROWS, 1, |i, _| depths[i]);
            let expected = (h.transpose() * &h).partial_piv_lu().solve(h.transpose() * b);
            // Random matrices of this kind have condition numbers of the normal equations up to about 1e4.
            for i in 0..UNKNOWNS {
                prop_assert!((times[i] - expected[(i, 0)]).abs() < 1e-6, "{} {}", times[i], expected[(i, 0)]);
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
        let wanted = |base| squares(&depths, &weights, base);
        let (free, times) = solve(&mut operator, &wanted(Base::AtMost(f64::INFINITY)), [&lower, &upper], &[1.0; 3]);
        assert!((free.base - 1.5).abs() < 1e-9 && (times[1] - 1.5).abs() < 1e-9);
        assert!((free.value - 0.25).abs() < 1e-9);
        // Held at 1: t = (1, 1, 2), residuals 1, 0, 0.
        let (bounded, _) = solve(&mut operator, &wanted(Base::AtMost(1.0)), [&lower, &upper], &[2.0; 3]);
        assert!((bounded.base - 1.0).abs() < 1e-12 && (bounded.value - 0.5).abs() < 1e-9);
    }

    #[test]
    fn nothing_to_do_ends_at_once() {
        let mut operator = Dense { rows: 1, unknowns: 2, values: vec![0.0, 0.0] };
        let wanted = squares(&[1.0], &[1.0], Base::Fixed(0.0));
        let (found, times) = solve(&mut operator, &wanted, [&[0.5; 2], &[1.0; 2]], &[0.0; 2]);
        assert_eq!((found.iterations, found.ended, times), (0, Ended::NoWayDown, vec![0.5, 0.5]));
    }

    #[test]
    fn time_has_its_price() {
        // H = 1, wanted 3: 1/2 (t - 3)² + 0.5 t is least at t = 2.5.
        let mut operator = Dense { rows: 1, unknowns: 1, values: vec![1.0] };
        let wanted = Wanted { price: Price::Fixed(0.5), ..squares(&[3.0], &[1.0], Base::Fixed(0.0)) };
        let (_, times) = solve(&mut operator, &wanted, [&[0.0], &[9.0]], &[1.0]);
        assert!((times[0] - 2.5).abs() < 1e-9, "{times:?}");
    }

    #[test]
    fn the_least_time_leaves_what_may_be_left() {
        // H = identity, wanted 3, 2 and 0.2, times from 0 on. With (t - b)²/2 in sum at most 0.52 the last time is worth most at
        // its bound, which leaves 0.2; the two others share the rest of 1.04 - 0.04 = 1 alike: 3 and 2 less sqrt(1/2).
        let mut operator = Dense { rows: 3, unknowns: 3, values: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0] };
        let (depths, weights, lower, upper) = ([3.0, 2.0, 0.2], [1.0; 3], [0.0; 3], [9.0; 3]);
        for first in [0.0, 1e-6, 1e3] {
            let price = Price::Sought { most: 0.52, first };
            let wanted = Wanted { price, ..squares(&depths, &weights, Base::Fixed(0.0)) };
            let (found, times) = solve(&mut operator, &wanted, [&lower, &upper], &[1.0; 3]);
            assert!(found.value <= 0.52 && found.ended == Ended::Reached, "{found:?}");
            for (time, wanted) in times.iter().zip([3.0 - 0.5f64.sqrt(), 2.0 - 0.5f64.sqrt(), 0.0]) {
                assert!((time - wanted).abs() < 0.005 * 3.6, "from a price of {first}: {times:?}");
            }
        }
    }

    #[test]
    fn what_cannot_be_left_is_come_near() {
        // Times up to 2 leave 1 of 3 at the least: F = 1/2, and 0.1 is wanted.
        let mut operator = Dense { rows: 1, unknowns: 1, values: vec![1.0] };
        let wanted =
            Wanted { price: Price::Sought { most: 0.1, first: 0.0 }, ..squares(&[3.0], &[1.0], Base::Fixed(0.0)) };
        let (found, times) = solve(&mut operator, &wanted, [&[0.0], &[2.0]], &[1.0]);
        assert!(times == [2.0] && found.ended == Ended::NoWayDown && found.price == 0.0, "{found:?} {times:?}");
    }

    #[test]
    fn what_needs_no_time_takes_none() {
        let mut operator = Dense { rows: 1, unknowns: 1, values: vec![1.0] };
        let wanted =
            Wanted { price: Price::Sought { most: 8.0, first: 0.0 }, ..squares(&[3.0], &[1.0], Base::Fixed(0.0)) };
        let (found, times) = solve(&mut operator, &wanted, [&[0.5], &[9.0]], &[1.0]);
        assert!(times == [0.5] && found.ended == Ended::Reached, "{found:?} {times:?}");
    }
}
