//! Targets: from checked motion to program text.
//!
//! In: `Checked<Motion>` and the job. Out: a [`Draft`], text that nobody may write to disk: only `verify` turns it into
//! a `Verified<Program>`.

mod digest;
pub mod facts;
mod identifier;
pub mod krl;
pub mod number;
pub mod rapid;
mod text;

use crate::diagnostics::Problem;
use crate::diagnostics::codes::E0905;
use crate::dwell::{SegmentTimes, SpeedSteps};
use crate::job::{Job, Target};
use crate::motion::{Checked, Motion, Room};

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

/// What the passes before the text must know of a target.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Most points of a job.
    pub most_points: u64,
    /// What one file is sure to hold, whatever its numbers: motion ends its runs there.
    pub room: Room,
    /// Most points of one line of the path: it is never spread over two files, nor over two blocks of KRL.
    pub line_points: usize,
    /// The speeds that can be written.
    pub speed_steps: SpeedSteps,
    pub segment_times: SegmentTimes,
}

/// The limits of a target.
pub fn limits(target: &Target) -> Limits {
    let count = |value: i64| u64::try_from(value).unwrap_or(0);
    match target {
        Target::rapid(rapid) => {
            let controller = &rapid.controller;
            let room = Room::points(rapid::points_per_module(rapid));
            Limits {
                most_points: count(controller.most_points),
                room,
                line_points: room.line_points(),
                // The last decimal of a speed in mm/s.
                speed_steps: SpeedSteps::Fixed(1e-3 / libm::pow(10.0, controller.speed_decimals as f64)),
                segment_times: SegmentTimes {
                    controller: controller.name.clone(),
                    least: controller.segment_time_least.0,
                    usual: controller.segment_time_usual.0,
                },
            }
        }
        Target::krl(krl) => {
            let controller = &krl.controller;
            let room = krl::room(krl);
            Limits {
                most_points: count(controller.most_points),
                room,
                line_points: room.line_points().min(krl::points_per_block(krl)),
                speed_steps: SpeedSteps::Digits(usize::try_from(controller.speed_digits).unwrap_or(0)),
                segment_times: SegmentTimes {
                    controller: controller.name.clone(),
                    least: controller.segment_time_least.0,
                    usual: controller.segment_time_usual.0,
                },
            }
        }
    }
}

/// The program text of `motion` in the language of the job's target; `name` is the job's name, for the comments at the
/// head of the text. Errors: those of the target.
pub fn emit(name: &str, motion: &Checked<Motion>, job: &Job) -> Result<Draft<Program>, Vec<Problem>> {
    match &job.target {
        Some(Target::rapid(_)) => rapid::emit(name, motion, job),
        Some(Target::krl(_)) => krl::emit(name, motion, job),
        None => Err(vec![no_target()]),
    }
}

/// What is said of a job that asks for a program and names no target.
pub(crate) fn no_target() -> Problem {
    Problem::error(E0905, "target", "a program needs `robot` with a `cell`, and `target`; the job has not all of them")
        .help("add what is missing, or build an earlier stage with `--emit`")
}
