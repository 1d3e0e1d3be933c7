//! Residual against machine time: what is to be had, and what it takes.
//!
//! In: a [`Task`], whose objective is not looked at. Out: rows of a table from the least residual to the least time worth having. Each
//! row minimises `1/2 sum w r² + λ sum t` with another price λ of a second, starting from the row before; the residuals are the
//! solver's own, before the arm's acceleration, not rounded and not predicted on the map's own pixels.

use super::plan::{Task, prepare};
use super::solver::{MOST_ITERATIONS, Solver};
use crate::diagnostics::Problem;

/// A run that could be had. Lengths in metres, times in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// On the lines: without the ways between them.
    pub time: f64,
    pub rms: f64,
    pub pv: f64,
    /// Even layer removed beside the error.
    pub base: f64,
}

/// Rows of the table: each price is four times the one before, so that ten span a factor of 260,000.
const MOST_ROWS: usize = 10;

/// A run that is not faster than the one before by this part gets no row, and one as near to the fastest of all is the last.
const SAVED: f64 = 0.005;

/// Prices that are tried: each is four times the one before, sixteen span a factor of a thousand million.
const MOST_PRICES: usize = 16;

/// The table, the least residual first.
///
/// # Errors
///
/// Those of [`solve`](super::solve) that come before the solve.
pub fn pareto(task: &Task, warnings: &mut Vec<Problem>) -> Result<Vec<Choice>, Problem> {
    let (run, mut operator) = prepare(task, warnings)?;
    let mut solver = run.solver(&mut operator, task.dwell);
    let mut rows: Vec<Choice> = Vec::new();
    let mut start = run.start.times.clone();
    let mut price = 0.0;
    let fastest: f64 = solver.lower.iter().sum();
    for _ in 0..MOST_PRICES {
        let steps = if rows.is_empty() { MOST_ITERATIONS } else { MOST_ITERATIONS / 4 };
        let (choice, times) = solver.at_price(&run.depths, &start, price, steps);
        // A hundredth of the time may first cost a thousandth of the squares.
        price = if price > 0.0 { 4.0 * price } else { 0.1 * solver.squares(choice.rms) / choice.time };
        start = times;
        // What is neither faster nor better than a later one is no choice.
        while rows.last().is_some_and(|last| choice.time <= last.time && choice.rms <= last.rms) {
            rows.pop();
        }
        if rows.last().is_none_or(|last| choice.time <= (1.0 - SAVED) * last.time) {
            rows.push(choice);
        }
        if rows.len() == MOST_ROWS || choice.time <= (1.0 + SAVED) * fastest {
            break;
        }
    }
    Ok(rows)
}

impl Solver<'_> {
    /// The run at a price of a second, and its times.
    fn at_price(&mut self, depths: &[f64], start: &[f64], price: f64, steps: usize) -> (Choice, Vec<f64>) {
        let times = self.priced(depths, start, price, steps);
        let figures = self.figures(depths, &times);
        let time = times.iter().sum();
        (Choice { time, rms: figures.rms, pv: figures.pv, base: figures.base }, times)
    }
}
