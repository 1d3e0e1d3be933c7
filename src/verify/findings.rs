//! What differs between a program and its plan: the first differences in words, and how many there were.

use crate::diagnostics::{Code, Problem};

/// Differences that are described one by one; more of them say nothing new, and are counted.
pub const MOST_DIFFERENCES: usize = 10;

/// Differences found: the first ones, and how many there were.
#[derive(Default)]
pub(super) struct Findings {
    pub first: Vec<Problem>,
    pub count: usize,
}

impl Findings {
    /// Notes a difference; its words are made only if they will be shown.
    pub fn add(&mut self, problem: impl FnOnce() -> Problem) {
        self.count += 1;
        if self.first.len() < MOST_DIFFERENCES {
            self.first.push(problem());
        }
    }

    pub fn join(&mut self, other: Findings) {
        self.count += other.count;
        let room = MOST_DIFFERENCES.saturating_sub(self.first.len());
        self.first.extend(other.first.into_iter().take(room));
    }

    pub fn into_problems(mut self) -> Vec<Problem> {
        let more = self.count - self.first.len();
        if let (1.., Some(last)) = (more, self.first.last_mut()) {
            let are = if more == 1 { "difference is" } else { "differences are" };
            last.notes.push(format!("{more} more {are} not shown"));
        }
        self.first
    }
}

/// A difference of a move: its code, the field of the job, words.
pub(super) struct Difference {
    pub code: Code,
    pub field: &'static str,
    pub what: String,
}

/// A problem at a line of a program file.
pub(super) fn at(file: &str, line: u32, code: Code, field: &str, what: String) -> Problem {
    Problem::error(code, field, format!("`{}` line {line}: {what}", file.escape_default()))
}
