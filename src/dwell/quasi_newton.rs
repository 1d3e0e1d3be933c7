//! Quasi-Newton steps from the last few moves.
//!
//! In: moves of the unknowns, and by how much each turned the gradient. Out: the gradient multiplied with the inverse of the
//! curvature that they tell of: the recursion of J. Nocedal, "Updating quasi-Newton matrices with limited storage", Math. Comp.
//! 35, 1980.

use super::objective::sum;

/// Moves that are remembered. Twenty gained hardly anything over five in the study of dwell solvers, and each is two numbers an
/// unknown.
const PAIRS: usize = 5;

/// A move, and by how much it turned the gradient.
struct Pair {
    moved: Vec<f64>,
    turned: Vec<f64>,
}

/// The last few moves, the latest last.
#[derive(Default)]
pub struct Memory {
    pairs: Vec<Pair>,
}

impl Memory {
    /// Remembers a move along which the gradient grew: only such curvature can be inverted.
    pub fn add(&mut self, moved: impl Fn(usize) -> f64, turned: impl Fn(usize) -> f64, unknowns: usize) {
        if !(sum(unknowns, |i| moved(i) * turned(i)) > 0.0) {
            return;
        }
        // Room of the oldest is used again.
        let mut pair = match self.pairs.len() {
            PAIRS => self.pairs.remove(0),
            _ => Pair { moved: vec![0.0; unknowns], turned: vec![0.0; unknowns] },
        };
        pair.moved.resize(unknowns, 0.0);
        pair.turned.resize(unknowns, 0.0);
        for i in 0..unknowns {
            (pair.moved[i], pair.turned[i]) = (moved(i), turned(i));
        }
        self.pairs.push(pair);
    }

    /// The memory in other unknowns, of which each stands for some of these: `reduce(values, is_move)`.
    pub fn reduced(&self, reduce: impl Fn(&[f64], bool) -> Vec<f64>) -> Memory {
        let pair = |pair: &Pair| Pair { moved: reduce(&pair.moved, true), turned: reduce(&pair.turned, false) };
        Memory { pairs: self.pairs.iter().map(pair).collect() }
    }

    /// The step against `gradient` over the unknowns that are not `held`; before anything is remembered of an unknown its
    /// curvature is `stiffness`, up to a common factor (empty for 1). `None` without a usable memory.
    pub fn step(&self, gradient: &[f64], held: &[bool], stiffness: &[f64]) -> Option<Vec<f64>> {
        let n = gradient.len();
        let free = |i: usize, value: f64| if held[i] { 0.0 } else { value };
        let soft = |i: usize| stiffness.get(i).map_or(1.0, |stiffness| 1.0 / stiffness);
        let product = |a: &[f64], b: &[f64]| sum(n, |i| free(i, a[i] * b[i]));
        let mut step: Vec<f64> = (0..n).map(|i| free(i, gradient[i])).collect();
        let used: Vec<(&Pair, f64)> =
            self.pairs.iter().map(|p| (p, product(&p.moved, &p.turned))).filter(|(_, size)| *size > 0.0).collect();
        let (last, size) = used.last()?;
        let scale = size / sum(n, |i| free(i, soft(i) * last.turned[i] * last.turned[i]));
        let mut parts = Vec::with_capacity(used.len());
        for (pair, size) in used.iter().rev() {
            let part = product(&pair.moved, &step) / size;
            for (i, step) in step.iter_mut().enumerate() {
                *step -= part * free(i, pair.turned[i]);
            }
            parts.push(part);
        }
        for (i, step) in step.iter_mut().enumerate() {
            *step *= scale * soft(i);
        }
        for ((pair, size), part) in used.iter().zip(parts.iter().rev()) {
            let change = part - product(&pair.turned, &step) / size;
            for (i, step) in step.iter_mut().enumerate() {
                *step += change * free(i, pair.moved[i]);
            }
        }
        Some(step)
    }
}
