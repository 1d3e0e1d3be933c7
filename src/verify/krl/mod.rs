//! The proof of a KRL program: its text against the plan and the job.
//!
//! In: the files of a program, from the emitter or from a disk. Out: what differs. Everything is read from the text by
//! [`reader`]; the emitter's data are not used. [`main_program`] compares the data and statements that are not path,
//! [`path`] replays the moves as the controller would, [`spline`] says what is taken for the way between the points of a
//! block.

pub mod lexer;
mod main_program;
mod path;
pub mod reader;
mod routines;
pub mod spline;
mod statements;
pub mod syntax;
mod values;

use super::findings::Findings;
use super::replay::Frames;
use super::trace::Trace;
use crate::diagnostics::Problem;
use crate::diagnostics::codes::{E1000, E1002};
use crate::job::{Job, Krl, Robot, RobotCell};
use crate::motion::{Arm, Motion, Purpose};
use crate::target::krl::Names;
use crate::target::{Program, ProgramFile};
use crate::workpiece::form::Surface;
use lexer::Fault;

/// What a program is compared with.
struct Wanted<'a> {
    motion: &'a Motion,
    job: &'a Job,
    surface: &'a dyn Surface,
    krl: &'a Krl,
    cell: &'a RobotCell,
    arm: Arm,
    names: Names,
    digest: String,
}

/// The two files of one program.
#[derive(Clone, Copy)]
struct Pair<'a> {
    source: &'a ProgramFile,
    data: &'a ProgramFile,
}

/// What differs between `program` and the plan; see [`crate::verify::check`].
pub fn check(
    program: &Program,
    motion: &Motion,
    (job, surface): (&Job, &dyn Surface),
    krl: &Krl,
    robot: &Robot,
) -> Vec<Problem> {
    match open(program, motion, (job, surface), krl, robot, path::check) {
        Ok(((), findings)) => findings.into_problems(),
        Err(problems) => problems,
    }
}

/// The moves of `program` as the text says them; see `crate::verify::trace`.
pub fn trace(
    program: &Program,
    motion: &Motion,
    (job, surface): (&Job, &dyn Surface),
    krl: &Krl,
    robot: &Robot,
) -> Result<Trace, Vec<Problem>> {
    match open(program, motion, (job, surface), krl, robot, path::trace)? {
        (trace, findings) if findings.count == 0 => Ok(trace),
        (_, findings) => Err(findings.into_problems()),
    }
}

/// Reads the files, compares the main program with the job, and hands the sub-programs to `follow`.
fn open<T>(
    program: &Program,
    motion: &Motion,
    (job, surface): (&Job, &dyn Surface),
    krl: &Krl,
    robot: &Robot,
    follow: impl FnOnce(&Wanted, &Frames, &[Pair], &mut Findings) -> T,
) -> Result<(T, Findings), Vec<Problem>> {
    let Some(cell) = &robot.cell else {
        return Err(vec![Problem::error(E1002, "robot.cell", "the robot has no cell to compare a program with")]);
    };
    let arm = Arm::new(robot).map_err(|problem| vec![problem])?;
    let names = Names::new(krl, motion.purpose);
    let digest = crate::target::krl::digest(motion, job);
    let wanted = Wanted { motion, job, surface, krl, cell, arm, names, digest };
    let mut findings = Findings::default();
    let file = |name: String| program.files.iter().find(|file| file.name.eq_ignore_ascii_case(&name)).ok_or(name);
    let pair = |name: &str, findings: &mut Findings| -> Option<Pair> {
        let (source, data) = (file(format!("{name}.src")), file(format!("{name}.dat")));
        for missing in [&source, &data].into_iter().filter_map(|file| file.as_ref().err()) {
            findings.add(|| missing_file(&wanted, missing));
        }
        Some(Pair { source: source.ok()?, data: data.ok()? })
    };
    let Some(main) = pair(&wanted.names.module, &mut findings) else { return Err(findings.into_problems()) };
    let (source, data) = match (reader::read_source(&main.source.bytes), reader::read_data(&main.data.bytes)) {
        (Ok(source), Ok(data)) => (source, data),
        (source, data) => {
            let faults = [source.err().map(|fault| (main.source, fault)), data.err().map(|fault| (main.data, fault))];
            return Err(faults.into_iter().flatten().map(|(file, fault)| unreadable(file, &fault)).collect());
        }
    };
    // As many sub-programs as are called, or as are given: what is missing on one side is then found on the other.
    let own = wanted.names.own("").to_ascii_lowercase();
    let called = |statement: &&syntax::Statement| {
        matches!(&statement.what, syntax::What::Call(name, _) if name.to_ascii_lowercase().strip_prefix(&own)
            .is_some_and(|rest| rest.bytes().all(|byte| byte.is_ascii_digit())))
    };
    let calls = source.routines.first().map_or(0, |routine| routine.body.iter().filter(called).count());
    let parts = calls.max((program.files.len() - 2).div_ceil(2)).max(1);
    let mut pairs = Vec::with_capacity(parts);
    for k in 0..parts {
        pairs.extend(pair(&wanted.names.sub_program(k), &mut findings));
    }
    let known: Vec<&ProgramFile> = pairs.iter().chain([&main]).flat_map(|pair| [pair.source, pair.data]).collect();
    for file in &program.files {
        if !known.iter().any(|known| std::ptr::eq(*known, file)) {
            findings.add(|| {
                let (name, module) = (file.name.escape_default(), &wanted.names.module);
                Problem::error(E1002, "target.module", format!("`{name}` is not a file of the program `{module}`"))
                    .help("give the main program and all sub-programs that it calls, and nothing else")
            });
        }
    }
    if findings.count > 0 {
        return Err(findings.into_problems());
    }
    // The main program first: the moves are replayed with the tool and the base that it declares.
    let frames = main_program::check(&wanted, main, &source, &data, parts, &mut findings);
    let followed = follow(&wanted, &frames, &pairs, &mut findings);
    Ok((followed, findings))
}

fn missing_file(wanted: &Wanted, name: &str) -> Problem {
    let purpose = match wanted.motion.purpose {
        Purpose::Polish => "polishing program",
        Purpose::DryRun => "dry run",
    };
    Problem::error(E1002, "target.module", format!("the file `{name}` of the {purpose} is missing"))
        .help("give the two files of the main program and of all sub-programs that it calls")
}

fn unreadable(file: &ProgramFile, fault: &Fault) -> Problem {
    let message = format!("`{}` line {}: {}", file.name.escape_default(), fault.line, fault.message);
    Problem::error(E1000, "target", message)
        .note("only the part of KRL that the compiler writes, and the same written in other words, can be proved")
}
