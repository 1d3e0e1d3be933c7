//! Quasi-Newton steps from the last few moves.
//!
//! In: moves of the unknowns, and by how much each turned the gradient. Out: the gradient multiplied with the inverse of the
//! curvature that they tell of: the recursion of J. Nocedal, "Updating quasi-Newton matrices with limited storage", Math. Comp.
//! 35, 1980. Or that curvature itself: the formula of Broyden, Fletcher, Goldfarb and Shanno, unrolled (J. Nocedal, S. Wright,
//! "Numerical Optimization", 2nd edition, section 7.2).

use super::vectors::{dot, each, pass, sum, sums};

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
    pub fn add(&mut self, moved: impl Fn(usize) -> f64 + Sync, turned: &[f64]) {
        if !(sum(turned.len(), |i| moved(i) * turned[i]) > 0.0) {
            return;
        }
        // Room of the oldest is used again.
        let mut pair = if self.pairs.len() < self.most {
            Pair { moved: vec![0.0; turned.len()], turned: Vec::new() }
        } else {
            self.pairs.remove(0)
        };
        each(&mut pair.moved, |i, entry| *entry = moved(i));
        pair.turned.clear();
        pair.turned.extend_from_slice(turned);
        self.pairs.push(pair);
    }

    /// The curvature that the moves tell of; before anything is remembered of an unknown it is `stiffness`, up to a common
    /// factor (empty for 1). `None` without a memory.
    pub fn curvature<'a>(&self, stiffness: &'a [f64], n: usize) -> Option<Curvature<'a>> {
        let last = self.pairs.last()?;
        let [turned, size] = sums(n, |i| {
            let (moved, turned) = (last.moved[i], last.turned[i]);
            [turned * turned / stiffness.get(i).copied().unwrap_or(1.0), moved * turned]
        });
        let mut curvature = Curvature { scale: turned / size, stiffness, parts: Vec::new() };
        for pair in &self.pairs {
            let mut taken = vec![0.0; n];
            curvature.times(&pair.moved, &mut taken);
            let taken_size = dot(&pair.moved, &taken).sqrt();
            each(&mut taken, |_, taken| *taken /= taken_size);
            let size = dot(&pair.moved, &pair.turned).sqrt();
            let mut added = vec![0.0; n];
            each(&mut added, |i, added| *added = pair.turned[i] / size);
            curvature.parts.push([taken, added]);
        }
        Some(curvature)
    }

    /// The step against `gradient` over the unknowns that are `free` (1; 0 for held ones); before anything is remembered of an
    /// unknown its curvature is `stiffness`, up to a common factor (empty for 1). `None` without a usable memory.
    ///
    /// A pass over the vectors does what one pair asks for and sums what the next one needs: reading them is what it costs.
    pub fn step(&self, gradient: &[f64], free: &[f64], stiffness: &[f64]) -> Option<Vec<f64>> {
        let soft = |i: usize| stiffness.get(i).map_or(1.0, |stiffness| 1.0 / stiffness);
        let mut step = vec![0.0; gradient.len()];
        each(&mut step, |i, step| *step = free[i] * gradient[i]);
        // Of the pairs that grow over what is free, the latest first, and the part of its turn that the step gives away.
        let mut used: Vec<(&Pair, f64, f64)> = Vec::with_capacity(self.pairs.len());
        let mut scale = None;
        let mut given: Option<(&Pair, f64)> = None;
        for pair in self.pairs.iter().rev() {
            let (moved, turned) = (&pair.moved[..], &pair.turned[..]);
            let sums = |i: usize, step: f64| [moved[i] * step, free[i] * moved[i] * turned[i]];
            let [along, size] = match given {
                Some((last, part)) => {
                    let last = &last.turned[..];
                    pass(&mut step, |i, step| {
                        *step -= part * free[i] * last[i];
                        sums(i, *step)
                    })
                }
                None => pass(&mut step, |i, step| sums(i, *step)),
            };
            given = None;
            if size > 0.0 {
                scale.get_or_insert_with(|| size / sum(turned.len(), |i| free[i] * soft(i) * turned[i] * turned[i]));
                used.push((pair, size, along / size));
                given = Some((pair, along / size));
            }
        }
        let scale = scale?;
        let (last, part) = given.map_or((&[][..], 0.0), |(last, part)| (&last.turned[..], part));
        let finish = |i: usize, step: f64| {
            let turn = last.get(i).map_or(0.0, |turned| part * turned);
            scale * soft(i) * free[i] * (step - turn)
        };
        let (oldest, ..) = used.last()?;
        let [mut along] = pass(&mut step, |i, step| {
            *step = finish(i, *step);
            [oldest.turned[i] * *step]
        });
        for (k, (pair, size, part)) in used.iter().enumerate().rev() {
            let change = part - along / size;
            let next = k.checked_sub(1).map(|k| &used[k].0.turned[..]);
            [along] = pass(&mut step, |i, step| {
                *step += change * free[i] * pair.moved[i];
                [next.map_or(0.0, |turned| turned[i] * *step)]
            });
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
        // Two parts at a time: what they share is read once.
        let mut shares = Vec::with_capacity(self.parts.len());
        for parts in self.parts.chunks(2) {
            let [a, b] = [&parts[0], &parts[parts.len() - 1]];
            let found = sums(moved.len(), |i| [a[0][i], a[1][i], b[0][i], b[1][i]].map(|entry| entry * moved[i]));
            shares.extend([[-found[0], found[1]], [-found[2], found[3]]].into_iter().take(parts.len()));
        }
        each(turned, |i, turned| {
            *turned = self.scale * self.stiffness.get(i).copied().unwrap_or(1.0) * moved[i];
        });
        for (parts, shares) in self.parts.chunks(2).zip(shares.chunks(2)) {
            let [a, b] = [&parts[0], &parts[parts.len() - 1]];
            let [of_a, of_b] = [shares[0], if parts.len() == 2 { shares[1] } else { [0.0; 2] }];
            each(turned, |i, turned| {
                *turned += (of_a[1] * a[1][i] + of_a[0] * a[0][i]) + (of_b[1] * b[1][i] + of_b[0] * b[0][i]);
            });
        }
    }
}
