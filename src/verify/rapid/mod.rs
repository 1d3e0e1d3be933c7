//! The proof of a RAPID program: its text against the plan and the job.
//!
//! In: the files of a program, from the emitter or from a disk. Out: what differs. Everything is read from the text by
//! [`reader`]; the emitter's data are not used. [`main_module`] compares the data and statements that are not path,
//! [`path`] replays the moves as the controller would.

mod declarations;
pub mod lexer;
mod main_module;
mod moves;
mod path;
pub mod reader;
mod routines;
mod statements;
pub mod syntax;
mod values;

use super::findings::{Findings, at};
use super::replay::Frames;
use super::trace::Trace;
use crate::diagnostics::Problem;
use crate::diagnostics::codes::{E1000, E1002};
use crate::job::{Job, Rapid, Robot, RobotCell};
use crate::motion::{Arm, Motion, Purpose};
use crate::target::rapid::Names;
use crate::target::{Program, ProgramFile};
use rayon::prelude::*;
use syntax::Module;

/// What a program is compared with.
struct Wanted<'a> {
    motion: &'a Motion,
    job: &'a Job,
    rapid: &'a Rapid,
    robot: &'a Robot,
    cell: &'a RobotCell,
    arm: Arm,
    names: Names,
    digest: String,
}

/// What differs between `program` and the plan; see [`crate::verify::check`].
pub fn check(program: &Program, motion: &Motion, job: &Job, rapid: &Rapid, robot: &Robot) -> Vec<Problem> {
    match open(program, motion, job, rapid, robot, path::check) {
        Ok(((), findings)) => findings.into_problems(),
        Err(problems) => problems,
    }
}

/// The moves of `program` as the text says them; see `crate::verify::trace`.
pub fn trace(
    program: &Program,
    motion: &Motion,
    job: &Job,
    rapid: &Rapid,
    robot: &Robot,
) -> Result<Trace, Vec<Problem>> {
    match open(program, motion, job, rapid, robot, path::trace)? {
        (trace, findings) if findings.count == 0 => Ok(trace),
        (_, findings) => Err(findings.into_problems()),
    }
}

/// Reads the files, compares the main module with the job, and hands the modules of the path to `follow`.
fn open<T>(
    program: &Program,
    motion: &Motion,
    job: &Job,
    rapid: &Rapid,
    robot: &Robot,
    follow: impl FnOnce(&Wanted, &Module, &Frames, &[&ProgramFile], &mut Findings) -> T,
) -> Result<(T, Findings), Vec<Problem>> {
    let Some(cell) = &robot.cell else {
        return Err(vec![Problem::error(E1002, "robot.cell", "the robot has no cell to compare a program with")]);
    };
    let arm = Arm::new(robot).map_err(|problem| vec![problem])?;
    let names = Names::new(rapid, motion.purpose);
    let digest = crate::target::rapid::digest(motion, job);
    let wanted = Wanted { motion, job, rapid, robot, cell, arm, names, digest };
    let mut findings = Findings::default();
    let file = |module: &str| -> Option<&ProgramFile> {
        let name = wanted.names.file(module);
        program.files.iter().find(|file| file.name.eq_ignore_ascii_case(&name))
    };
    let Some(main_file) = file(&wanted.names.module) else {
        return Err(vec![missing_file(&wanted, &wanted.names.module)]);
    };
    let main = reader::read(&main_file.bytes).map_err(|fault| vec![unreadable(main_file, &fault)])?;
    // As many modules as are called, or as are given: what is missing on one side is then found on the other.
    let calls = |routine: &syntax::Routine| {
        routine.body.iter().filter(|statement| matches!(statement.what, syntax::What::LateCall(_))).count()
    };
    let called = main.routines.iter().map(calls).max().unwrap_or(0);
    let chunks = called.max(program.files.len() - 1).max(1);
    let modules: Vec<String> = (0..chunks).map(|k| wanted.names.chunk_module(k)).collect();
    let mut files: Vec<&ProgramFile> = Vec::with_capacity(chunks);
    for module in &modules {
        match file(module) {
            Some(file) => files.push(file),
            None => findings.add(|| missing_file(&wanted, module)),
        }
    }
    for file in &program.files {
        if !std::ptr::eq(file, main_file) && !files.iter().any(|known| std::ptr::eq(*known, file)) {
            findings.add(|| {
                let (name, module) = (file.name.escape_default(), &wanted.names.module);
                Problem::error(E1002, "target.module", format!("`{name}` is not a file of the program `{module}`"))
                    .help("give the main module and all modules that it loads, and nothing else")
            });
        }
    }
    if findings.count > 0 {
        return Err(findings.into_problems());
    }
    // The main module first: the moves are replayed with the tool and the work object that it declares.
    let frames = main_module::check(&wanted, &main_file.name, &main, chunks, &mut findings);
    let followed = follow(&wanted, &main, &frames, &files, &mut findings);
    Ok((followed, findings))
}

/// Reads the modules of the path in parallel, in order.
fn read_all(files: &[&ProgramFile]) -> Vec<Result<Module, Problem>> {
    files.par_iter().map(|file| reader::read(&file.bytes).map_err(|fault| unreadable(file, &fault))).collect()
}

fn missing_file(wanted: &Wanted, module: &str) -> Problem {
    let name = wanted.names.file(module);
    let purpose = match wanted.motion.purpose {
        Purpose::Polish => "polishing program",
        Purpose::DryRun => "dry run",
    };
    Problem::error(E1002, "target.module", format!("the file `{name}` of the {purpose} is missing"))
        .help("give the main module and all modules that it loads")
}

fn unreadable(file: &ProgramFile, fault: &lexer::Fault) -> Problem {
    let message = format!("`{}` line {}: {}", file.name.escape_default(), fault.line, fault.message);
    Problem::error(E1000, "target", message)
        .note("only the part of RAPID that the compiler writes, and the same written in other words, can be proved")
}
