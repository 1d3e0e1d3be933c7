//! The price of a second that the least time asks for.
//!
//! In: how much each step of a descent left, and how long its run took. Out: the price at which the next step reckons, which
//! step was the best, and when more steps are not worth their while.
//!
//! The least time with a residual F of at most so much is the least `F + λ sum t` at the right λ. λ starts too low, rises until
//! F is once too large, and then follows it.

/// A sought price is looked at again after so many steps. From 1 to 10 do alike on the published problem; fewer follow better.
const EVERY: usize = 2;

/// Until a sought price is once too high it grows by this factor: it starts so low that three or four times suffice.
const RISE: f64 = 8.0;

/// Then it follows the square root of what may be left over what is, but no faster than by this factor: the times need steps
/// to answer.
const FOLLOW: f64 = 2.0;

/// The least time is found when a hundred steps save less than 1 % of it: on the published problem four hundred more then
/// save 2 %. Fifty are too few: now and then as many save nothing half way.
const SAVING: (usize, f64) = (100, 0.01);

/// The same where the price is about known from a run before, which saved what was to be saved.
const SAVING_LATER: (usize, f64) = (20, 0.002);

/// A price at which no way leads down gives way to the next; at so many in a row the run is as fast as it can be.
const MOST_STUCK: usize = 20;

/// A search for the price, from the first step that leaves no more than may be left.
pub(super) struct Search {
    /// F that may be left.
    most: f64,
    price: f64,
    /// The price is about known: it was too high once, or comes from a run before.
    known: bool,
    /// It was too high once in this run.
    crossed: bool,
    /// Steps since the price was looked at.
    steps: usize,
    /// Prices in a row at which no way led down.
    stuck: usize,
    /// By step: the least time so far, of those that leave little enough.
    least: Vec<f64>,
    saving: (usize, f64),
}

impl Search {
    /// `first` is the price where it is about known, otherwise 0; `spent` the time of the run now.
    pub fn new(most: f64, first: f64, spent: f64) -> Search {
        let known = first > 0.0;
        let saving = if known { SAVING_LATER } else { SAVING };
        Search { most, price: first, known, crossed: false, steps: 0, stuck: 0, least: vec![spent], saving }
    }

    /// The price for the next step, after one that leaves `size` and takes `spent`.
    pub fn price(&mut self, size: f64, spent: f64) -> f64 {
        self.steps += 1;
        if self.steps < EVERY && self.stuck == 0 {
            return self.price;
        }
        self.steps = 0;
        self.crossed |= size > self.most;
        self.known |= self.crossed;
        self.price = if self.price == 0.0 {
            RISE * self.most / spent
        } else if self.known {
            self.price * (self.most / size).sqrt().clamp(1.0 / FOLLOW, FOLLOW)
        } else {
            self.price * RISE
        };
        self.price
    }

    /// At this price no way leads down. Whether another is to be tried.
    pub fn is_stuck(&mut self) -> bool {
        self.stuck += 1;
        self.stuck <= MOST_STUCK
    }

    /// Takes a step to `size` and `spent`. Whether it is the best so far.
    pub fn take(&mut self, size: f64, spent: f64) -> bool {
        self.stuck = 0;
        let least = self.least[self.least.len() - 1];
        let better = size <= self.most && spent < least;
        self.least.push(if better { spent } else { least });
        better
    }

    /// Whether more steps would save hardly anything.
    pub fn is_settled(&self) -> bool {
        let (over, part) = self.saving;
        let Some(before) = self.least.len().checked_sub(1 + over) else { return false };
        let now = self.least[self.least.len() - 1];
        self.crossed && self.least[before] - now < part * now
    }
}
