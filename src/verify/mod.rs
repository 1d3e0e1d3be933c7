//! Verify: reads a program's text with a reader of its own and proves that it does what the job asks.
//!
//! In: the text alone, and the job's plan. Out: `Verified<Program>`, or what differs, in terms of the part.

mod align;
mod facts;
mod findings;
pub mod krl;
mod planned;
pub mod rapid;
mod replay;
mod trace;

pub use findings::MOST_DIFFERENCES;
pub use trace::{Arrival, Trace};

use crate::diagnostics::Problem;
use crate::diagnostics::codes::E1002;
use crate::job::{Job, Target};
use crate::motion::{Checked, Motion};
use crate::target::{Draft, Program};
use crate::workpiece::form::Surface;

/// A proof that the text was read back and compared. Only this module can make one.
#[derive(Clone, Debug)]
pub struct Verified<T>(T);

impl<T> std::ops::Deref for Verified<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0
    }
}

/// Proves that the draft does what `plan` and `job`, whose form is `surface`, ask, or says what differs (`E1000` to `E1015`).
pub fn verify(
    draft: Draft<Program>,
    plan: &Checked<Motion>,
    job: &Job,
    surface: &dyn Surface,
) -> Result<Verified<Program>, Vec<Problem>> {
    let problems = check(&draft.0, plan, job, surface);
    if problems.is_empty() { Ok(Verified(draft.0)) } else { Err(problems) }
}

/// What in `program`, which may come from anywhere, differs from `plan` and `job`; nothing when it does what they ask.
/// At most [`MOST_DIFFERENCES`] are described, the last problem then counts the rest.
pub fn check(program: &Program, plan: &Checked<Motion>, job: &Job, surface: &dyn Surface) -> Vec<Problem> {
    match (&job.target, &job.robot) {
        (Some(Target::rapid(rapid)), Some(robot)) => rapid::check(program, plan, job, rapid, robot),
        (Some(Target::krl(krl)), Some(robot)) => krl::check(program, plan, (job, surface), krl, robot),
        _ => vec![Problem::error(E1002, "target", "the job names no robot and target to compare a program with")],
    }
}

/// The moves of `program`, which may come from anywhere, as its text says them: where the tool goes and how fast. Moves
/// may differ from the plan; all else must be as `plan` and `job` ask (frames, process, digest, routines), since what the
/// moves do depends on it. Whether the arm can follow them is not looked at: that is [`check`].
///
/// # Errors
///
/// What is unreadable or, apart from the moves, not as the job asks (`E1000` to `E1012`).
pub fn trace(
    program: &Program,
    plan: &Checked<Motion>,
    job: &Job,
    surface: &dyn Surface,
) -> Result<Trace, Vec<Problem>> {
    match (&job.target, &job.robot) {
        (Some(Target::rapid(rapid)), Some(robot)) => rapid::trace(program, plan, job, rapid, robot),
        (Some(Target::krl(krl)), Some(robot)) => krl::trace(program, plan, (job, surface), krl, robot),
        _ => Err(vec![Problem::error(E1002, "target", "the job names no robot and target to read a program with")]),
    }
}
