//! Quasi-Newton steps from the last few moves.
//!
//! In: moves of the unknowns, and by how much each turned the gradient. Out: the gradient multiplied with the inverse of the
//! curvature that they tell of: the recursion of J. Nocedal, "Updating quasi-Newton matrices with limited storage", Math. Comp.
//! 35, 1980. Or that curvature itself: the formula of Broyden, Fletcher, Goldfarb and Shanno, unrolled (J. Nocedal, S. Wright,
//! "Numerical Optimization", 2nd edition, section 7.2).

use super::objective::sum;

/// Moves that are remembered. Between bounds twenty gained hardly anything over five in the study of dwell solvers, and each is two numbers an
/// unknown.
const PAIRS: usize = 5;

/// A move, and by how much it turned the gradient.
struct Pair {
    moved: Vec<f64>,
    turned: Vec<f64>,
}

/// The last few moves, the latest last.
pub struct Memory {
    pairs: Vec<Pair>,
    most: usize,
}

impl Default for Memory {
    fn default() -> Memory {
        Memory::of(PAIRS)
    }
}

impl Memory {
    /// Of at most so many moves.
    pub fn of(most: usize) -> Memory {
        Memory { pairs: Vec::new(), most }
    }

    /// Remembers a move along which the gradient grew: only such curvature can be inverted.
    pub fn add(&mut self, moved: impl Fn(usize) -> f64, turned: impl Fn(usize) -> f64, unknowns: usize) {
        if !(sum(unknowns, |i| moved(i) * turned(i)) > 0.0) {
            return;
        }
        // Room of the oldest is used again.
        let mut pair = if self.pairs.len() < self.most {
            Pair { moved: vec![0.0; unknowns], turned: vec![0.0; unknowns] }
        } else {
            self.pairs.remove(0)
        };
        pair.moved.resize(unknowns, 0.0);
        pair.turned.resize(unknowns, 0.0);
        for i in 0..unknowns {
            (pair.moved[i], pair.turned[i]) = (moved(i), turned(i));
        }
        self.pairs.push(pair);
    }

    /// The curvature that the moves tell of; before anything is remembered of an unknown it is `stiffness`, up to a common
    /// factor (empty for 1). `None` without a memory.
    pub fn curvature<'a>(&self, stiffness: &'a [f64], n: usize) -> Option<Curvature<'a>> {
        let last = self.pairs.last()?;
        let soft = |i: usize| stiffness.get(i).map_or(1.0, |stiffness| 1.0 / stiffness);
        let size = |pair: &Pair| sum(n, |i| pair.moved[i] * pair.turned[i]);
        let scale = sum(n, |i| soft(i) * last.turned[i] * last.turned[i]) / size(last);
        let mut curvature = Curvature { scale, stiffness, parts: Vec::new() };
        for pair in &self.pairs {
            let mut taken = vec![0.0; n];
            curvature.times(&pair.moved, &mut taken);
            let taken_size = sum(n, |i| pair.moved[i] * taken[i]).sqrt();
            taken.iter_mut().for_each(|taken| *taken /= taken_size);
            let size = size(pair).sqrt();
            let added = pair.turned.iter().map(|turned| turned / size).collect();
            curvature.parts.push([taken, added]);
        }
        Some(curvature)
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
            for i in 0..n {
                step[i] -= part * free(i, pair.turned[i]);
            }
            parts.push(part);
        }
        for (i, step) in step.iter_mut().enumerate() {
            *step *= scale * soft(i);
        }
        for ((pair, size), part) in used.iter().zip(parts.iter().rev()) {
            let change = part - product(&pair.turned, &step) / size;
            for i in 0..n {
                step[i] += change * free(i, pair.moved[i]);
            }
        }
        Some(step)
    }
}

/// A symmetric, positive definite map from moves to how they turn the gradient.
pub struct Curvature<'a> {
    scale: f64,
    stiffness: &'a [f64],
    /// By move: what is taken away and what is added, as vectors whose outer squares these are.
    parts: Vec<[Vec<f64>; 2]>,
}

impl Curvature<'_> {
    /// By how much a move turns the gradient.
    pub fn times(&self, moved: &[f64], turned: &mut [f64]) {
        let n = moved.len();
        for i in 0..n {
            turned[i] = self.scale * self.stiffness.get(i).copied().unwrap_or(1.0) * moved[i];
        }
        for [taken, added] in &self.parts {
            let (less, more) = (sum(n, |i| taken[i] * moved[i]), sum(n, |i| added[i] * moved[i]));
            for i in 0..n {
                turned[i] += more * added[i] - less * taken[i];
            }
        }
    }
}
