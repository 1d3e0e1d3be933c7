//! Targets: from checked motion to program text.
//!
//! In: `Checked<Motion>` and the job. Out: a [`Draft`], text that nobody may write to disk: only `verify` turns it into
//! a `Verified<Program>`.

pub mod number;
pub mod rapid;

use crate::diagnostics::Problem;
use crate::diagnostics::codes::E0905;
use crate::job::{Job, Target};
use crate::motion::{Checked, Motion};

/// One file of a program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProgramFile {
    /// File name without folder.
    pub name: String,
    pub bytes: Vec<u8>,
    /// Points of the path that this file holds, for the report; 0 in the main module and in files from a disk.
    pub points: usize,
}

/// A program: its files in order, the main module first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Program {
    pub files: Vec<ProgramFile>,
}

/// Text that was not yet read back.
#[derive(Clone, Debug)]
pub struct Draft<T>(pub T);

/// How many points one module is sure to hold, whatever their numbers: motion ends its runs there.
pub fn points_per_module(target: &Target) -> usize {
    match target {
        Target::rapid(rapid) => rapid::points_per_module(rapid),
    }
}

/// The program text of `motion` in the language of the job's target; `name` is the job's name, for the comments at the
/// head of the text. Errors: those of the target.
pub fn emit(name: &str, motion: &Checked<Motion>, job: &Job) -> Result<Draft<Program>, Vec<Problem>> {
    match &job.target {
        Some(Target::rapid(_)) => rapid::emit(name, motion, job),
        None => Err(vec![no_target()]),
    }
}

/// What is said of a job that asks for a program and names no target.
pub(crate) fn no_target() -> Problem {
    Problem::error(E0905, "target", "a program needs `robot` with a `cell`, and `target`; the job has not all of them")
        .help("add what is missing, or build an earlier stage with `--emit`")
}
