//! The KRL emitter: one main program, and sub-programs that it calls one after the other.
//!
//! In: `Checked<Motion>` and the job. Out: the program's text, a pair of files a program (`NAME.src`, `NAME.dat`). The main
//! program ([`main_program`]) holds everything that is not path: data, the checks before anything moves, process
//! switching, the calls. The sub-programs ([`sub_program`]) hold the path and nothing else. All of them are in the
//! controller's memory at once, so the whole has a budget. A sub-program begins and ends lifted off the part: the robot
//! stops there.
//!
//! What the language asks (KSS 8; KUKA quick guide and message catalogue): one statement a line, no continuation; the
//! name behind `DEF` is the file's; declarations before the first statement; `$VEL.CP` in metres a second; inside a
//! `SPLINE` block nothing but segments. External axes are not addressed: a controller that has some leaves them where
//! they stand.

mod main_program;
mod names;
mod sub_program;
mod writing;

pub use names::{Names, not_a_name};

use crate::diagnostics::Problem;
use crate::diagnostics::codes::{E0903, E0904, E0906, E0907, E0909, E0910};
use crate::job::{Job, Krl, LineMotion, Memory, Presence, Process, RobotCell, Target};
use crate::motion::{Arm, Checked, Motion, Purpose, Room};
use crate::target::digest::{Rounding, digest as digest_of};
use crate::target::number::MOST_DECIMALS;
use crate::target::text::{LINE_LENGTH, Text};
use crate::target::{Draft, Program, no_target};
use rayon::prelude::*;
use std::ops::Range;
use writing::{Digits, push_speed};

/// Everything that the writers of the programs look at.
struct Setup<'a> {
    /// The job's name.
    name: &'a str,
    motion: &'a Motion,
    arm: Arm,
    job: &'a Job,
    krl: &'a Krl,
    cell: &'a RobotCell,
    names: Names,
    digits: Digits,
    digest: String,
    parts: Vec<Part>,
}

impl Setup<'_> {
    /// A dry run leaves wheel and pump alone.
    fn switches_process(&self) -> bool {
        self.motion.purpose == Purpose::Polish
    }

    /// Whether the process says by inputs that it runs.
    fn waits_for_inputs(&self) -> bool {
        self.switches_process() && matches!(&self.cell.process, Process::signals(s) if !s.inputs.is_empty())
    }
}

/// The part of the path that one sub-program holds.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Part {
    /// Indices into `Motion::runs`.
    runs: Range<usize>,
    points: Range<usize>,
}

/// The KRL program of `motion`. Errors: `E0900` to `E0911`.
pub fn emit(name: &str, motion: &Checked<Motion>, job: &Job) -> Result<Draft<Program>, Vec<Problem>> {
    let (Some(Target::krl(krl)), Some(robot)) = (&job.target, &job.robot) else { return Err(vec![no_target()]) };
    let Some(cell) = &robot.cell else { return Err(vec![no_target()]) };
    let mut problems = Names::check(krl);
    problems.extend(profile(krl));
    problems.extend(values(cell));
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut setup = Setup {
        name,
        motion,
        arm: Arm::new(robot).map_err(|problem| vec![problem])?,
        job,
        krl,
        cell,
        names: Names::new(krl, motion.purpose),
        digits: Digits::of(&krl.controller),
        digest: digest(motion, job),
        parts: Vec::new(),
    };
    // All results first, so that the error is that of the first run with any number of threads.
    let runs: Vec<_> = (0..motion.runs.len()).into_par_iter().map(|r| sub_program::run(&setup, r)).collect();
    let runs = runs.into_iter().collect::<Result<Vec<_>, _>>().map_err(|problem| vec![problem])?;
    setup.parts = pack(&setup, &runs)?;
    let mut files = Vec::with_capacity(2 * setup.parts.len() + 2);
    files.extend(main_program::write(&setup)?);
    let mut runs = runs.into_iter().map(|(text, _)| text);
    for index in 0..setup.parts.len() {
        // Each run's text is freed once it stands in its file, so that a large program is not held twice.
        let texts = runs.by_ref().take(setup.parts[index].runs.len());
        files.extend(sub_program::files(&setup, index, texts).map_err(|problem| vec![problem])?);
    }
    let bytes: usize = files.iter().map(|file| file.bytes.len()).sum();
    let most = limit(krl.controller.program_bytes);
    if krl.memory == Memory::resident && bytes > most {
        return Err(vec![
            Problem::error(
                E0909,
                "target.memory",
                format!("the program has {bytes} bytes, and {most} of it fit into the controller's memory"),
            )
            .note("all sub-programs of a KRL program are in memory at once")
            .help(
                "take a longer `path.point_step` or `line_pitch`, or `memory: dir_loader` with a controller that has that \
                 option; raise `program_bytes` only if the controller has the memory",
            ),
        ]);
    }
    Ok(Draft(Program { files }))
}

fn limit(value: i64) -> usize {
    usize::try_from(value).unwrap_or(0)
}

/// The digest of the program of `motion` for `job`; see [`crate::target::digest`].
pub fn digest(motion: &Motion, job: &Job) -> String {
    let position = match &job.target {
        Some(Target::krl(krl)) => Digits::of(&krl.controller).position,
        _ => 0,
    };
    // A, B and C follow from the quaternion: its eight decimals are a millionth of a degree. Speeds lie above 0.01 mm/s:
    // nine decimals of mm/s hold all their digits.
    digest_of(
        motion,
        job,
        Rounding { label: b"polishc krl 1", position, quaternion: 8, joint: writing::JOINT_DECIMALS, speed: 9 },
    )
}

/// The digest as KRL can compare it: four whole numbers of 31 bits, which fit its `INT`, from the first, second, third
/// and fourth eight digits, the highest bit of each left out.
pub fn digest_words(digest: &str) -> [u32; 4] {
    let word = |k: usize| {
        let digits = digest.get(8 * k..8 * k + 8).unwrap_or("0");
        u32::from_str_radix(digits, 16).unwrap_or(0) & 0x7fff_ffff
    };
    [0, 1, 2, 3].map(word)
}

/// Whether the controller's profile makes sense.
fn profile(krl: &Krl) -> Vec<Problem> {
    let controller = &krl.controller;
    let mut problems = Vec::new();
    for (field, value, from) in [
        ("position_decimals", controller.position_decimals, 3),
        ("angle_decimals", controller.angle_decimals, 4),
        ("speed_digits", controller.speed_digits, 3),
    ] {
        if !(from..=MOST_DECIMALS as i64).contains(&value) {
            problems.push(
                Problem::error(
                    E0906,
                    format!("target.controller.{field}"),
                    format!("`{field}` is {value}, and a program can have {from} to {MOST_DECIMALS} of them"),
                )
                .note(
                    "rounding must leave contact points within 1 um and normals within 0.001 deg: that takes 3 decimals of a \
                     coordinate in mm and 4 of an angle in degrees",
                ),
            );
        }
    }
    if krl.memory == Memory::dir_loader && controller.dir_loader == Presence::absent {
        problems.push(
            Problem::error(
                E0910,
                "target.memory",
                format!(
                    "the program is to be loaded by an option that the controller `{}` does not have",
                    controller.name
                ),
            )
            .help("say `dir_loader: installed` in the controller's profile if it is there, or take `memory: resident`"),
        );
    }
    problems
}

/// Values of the cell that KRL cannot take although the job's language can say them.
fn values(cell: &RobotCell) -> Vec<Problem> {
    let mut problems = Vec::new();
    if percent(cell.joint_move_speed).is_none() {
        problems.push(
            Problem::error(
                E0904,
                "robot.cell.joint_move_speed",
                format!("KRL takes whole percents of the joint speeds, and {} % is none", cell.joint_move_speed * 1e2),
            )
            .help("give 1 % to 100 % without decimals"),
        );
    }
    if push_speed(&mut Vec::new(), cell.travel.speed.0, Digits { position: 0, angle: 0, speed: 7 }).is_none() {
        problems.push(Problem::error(E0904, "robot.cell.travel.speed", "the travel speed cannot be written in m/s"));
    }
    if let Process::signals(signals) = &cell.process {
        let mut numbers = Vec::new();
        for (i, output) in signals.outputs.iter().enumerate() {
            numbers.push(("outputs", i, &output.name, output.number));
        }
        for (i, input) in signals.inputs.iter().enumerate() {
            numbers.push(("inputs", i, &input.name, input.number));
        }
        for (k, (list, i, name, number)) in numbers.iter().enumerate() {
            let field = format!("robot.cell.process.{list}.{i}");
            let Some(number) = number else {
                problems.push(
                    Problem::error(E0907, field, format!("the signal `{name}` has no number, by which KRL knows it"))
                        .help("add `number: …`, n of `$OUT[n]` or `$IN[n]`"),
                );
                continue;
            };
            let twice = numbers[..k].iter().find(|(other, _, _, before)| other == list && before == &Some(*number));
            if let Some((_, _, first, _)) = twice {
                let what = format!("the signals `{first}` and `{name}` have the same number {number}");
                problems.push(Problem::error(E0907, format!("{field}.number"), what));
            }
        }
        for (i, input) in signals.inputs.iter().enumerate() {
            // Written so that a time that is no number is refused.
            let has_time = input.wait_at_most.0 > 0.0 && input.wait_at_most.0 < 1e6;
            if !has_time {
                let field = format!("robot.cell.process.inputs.{i}.wait_at_most");
                problems.push(Problem::error(E0904, field, format!("the wait for `{}` has no time", input.name)));
            }
        }
    }
    problems
}

/// A share of the joint speeds as whole percents, 1 to 100; `None` where it is none.
pub fn percent(share: f64) -> Option<u32> {
    let percent = (share * 100.0).round();
    // A share is written in percent or as a decimal: both are within the rounding of a product.
    ((1.0..=100.0).contains(&percent) && (share * 100.0 - percent).abs() < 1e-9).then_some(percent as u32)
}

/// The room of one file, in lines of text: those of the points, of the blocks around them, and what surrounds a run. Bytes
/// are counted as lines of full length.
pub fn room(krl: &Krl) -> Room {
    let controller = &krl.controller;
    let by_bytes = limit(controller.file_bytes).saturating_sub(sub_program::FRAME_LINES * LINE_LENGTH);
    let lines = limit(controller.file_lines).saturating_sub(sub_program::FRAME_LINES);
    let total = lines.min(by_bytes / sub_program::SEGMENT_LENGTH).saturating_sub(sub_program::RUN_LINES);
    match krl.motion {
        // `SPLINE` and `ENDSPLINE`.
        LineMotion::spline(_) => Room { total, point: 1, line: 2 },
        LineMotion::linear(_) => Room { total, point: 2, line: 0 },
    }
}

/// Most points of a line that is one block.
pub fn points_per_block(krl: &Krl) -> usize {
    match krl.motion {
        LineMotion::spline(_) => limit(krl.controller.block_segments).saturating_add(1),
        LineMotion::linear(_) => usize::MAX,
    }
}

/// Runs gathered into sub-programs: as many as fit the limits of lines and bytes, in order.
fn pack(setup: &Setup, runs: &[(Vec<u8>, usize)]) -> Result<Vec<Part>, Vec<Problem>> {
    let controller = &setup.krl.controller;
    let most_lines = limit(controller.file_lines).saturating_sub(sub_program::FRAME_LINES);
    let most_bytes = limit(controller.file_bytes).saturating_sub(sub_program::FRAME_LINES * LINE_LENGTH);
    let mut parts: Vec<Part> = Vec::new();
    let (mut bytes, mut lines) = (0, 0);
    for (r, (run, (text, count))) in setup.motion.runs.iter().zip(runs).enumerate() {
        for (field, size, room, most, what) in [
            ("file_lines", *count, most_lines, controller.file_lines, "lines"),
            ("file_bytes", text.len(), most_bytes, controller.file_bytes, "bytes"),
        ] {
            if size > room {
                return Err(vec![
                    Problem::error(
                        E0903,
                        format!("target.controller.{field}"),
                        format!("run {} needs {size} {what}, a file of {most} {what} has room for {room}", r + 1),
                    )
                    .note("a file ends only where the tool is lifted off the part")
                    .help(format!(
                        "raise `{field}` if the controller takes larger files, or take a longer `path.point_step`"
                    )),
                ]);
            }
        }
        match parts.last_mut() {
            Some(last) if lines + count <= most_lines && bytes + text.len() <= most_bytes => {
                last.runs.end = r + 1;
                last.points.end = run.points.end;
                bytes += text.len();
                lines += count;
            }
            _ => {
                parts.push(Part { runs: r..r + 1, points: run.points.clone() });
                (bytes, lines) = (text.len(), *count);
            }
        }
    }
    Ok(parts)
}

/// The lines for the control's file handling that begin every file: visible to operators, first release.
fn heading(text: &mut Text) {
    text.line(0, "&ACCESS RVP");
    text.line(0, "&REL 1");
}
