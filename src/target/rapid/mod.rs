//! The RAPID emitter: one main module, and chunk modules that it loads one after the other.
//!
//! In: `Checked<Motion>` and the job. Out: the program's text. The main module ([`main_module`]) holds everything that
//! is not path: data, the checks before anything moves, process switching, the loader. The chunks ([`chunk`]) hold the
//! path and nothing else. A chunk begins and ends lifted off the part at a fine point, since loading stops the robot.

mod chunk;
mod main_module;
mod names;
mod writing;

pub use names::{Names, not_a_name};

use crate::diagnostics::Problem;
use crate::diagnostics::codes::{E0903, E0904, E0906, E0907};
use crate::job::{Job, Process, Rapid, Robot, RobotCell, Target};
use crate::motion::{Arm, Checked, Motion};
use crate::target::digest::{Rounding, digest as digest_of};
use crate::target::number::{MOST_DECIMALS, degrees, push_fixed, scaled};
use crate::target::{Draft, Program, no_target, text};
use rayon::prelude::*;
use std::ops::Range;
use writing::Decimals;

/// Everything that the writers of the modules look at.
struct Setup<'a> {
    /// The job's name.
    name: &'a str,
    motion: &'a Motion,
    arm: Arm,
    job: &'a Job,
    rapid: &'a Rapid,
    robot: &'a Robot,
    cell: &'a RobotCell,
    names: Names,
    decimals: Decimals,
    digest: String,
    chunks: Vec<Chunk>,
}

/// The part of the path that one module holds.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Chunk {
    /// Indices into `Motion::runs`.
    runs: Range<usize>,
    points: Range<usize>,
}

/// The RAPID program of `motion`. Errors: `E0900` to `E0907`.
pub fn emit(name: &str, motion: &Checked<Motion>, job: &Job) -> Result<Draft<Program>, Vec<Problem>> {
    let (Some(Target::rapid(rapid)), Some(robot)) = (&job.target, &job.robot) else { return Err(vec![no_target()]) };
    let Some(cell) = &robot.cell else { return Err(vec![no_target()]) };
    let names = Names::new(rapid, motion.purpose);
    let mut problems = names.check(rapid, cell);
    problems.extend(profile(rapid));
    let decimals = Decimals::of(job);
    problems.extend(values(cell, decimals));
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut setup = Setup {
        name,
        motion,
        arm: Arm::new(robot).map_err(|problem| vec![problem])?,
        job,
        rapid,
        robot,
        cell,
        names,
        decimals,
        digest: digest(motion, job),
        chunks: Vec::new(),
    };
    // All results first, so that the error is that of the first run with any number of threads.
    let runs: Vec<_> = (0..motion.runs.len()).into_par_iter().map(|r| chunk::run(&setup, r)).collect();
    let runs = runs.into_iter().collect::<Result<Vec<_>, _>>().map_err(|problem| vec![problem])?;
    setup.chunks = pack(&setup, &runs)?;
    let mut files = vec![main_module::write(&setup)?];
    let mut runs = runs.into_iter();
    for index in 0..setup.chunks.len() {
        // Each run's text is freed once it stands in its module, so that a large program is not held twice.
        let parts = runs.by_ref().take(setup.chunks[index].runs.len());
        files.push(chunk::module(&setup, index, parts).map_err(|problem| vec![problem])?);
    }
    Ok(Draft(Program { files }))
}

/// The digest of the program of `motion` for `job`; see [`crate::target::digest`].
pub fn digest(motion: &Motion, job: &Job) -> String {
    let Decimals { position, quaternion, speed, joint } = Decimals::of(job);
    digest_of(motion, job, Rounding { label: b"polishc rapid 2", position, quaternion, joint, speed })
}

/// Whether the controller's profile makes sense.
fn profile(rapid: &Rapid) -> Vec<Problem> {
    let controller = &rapid.controller;
    let mut problems = Vec::new();
    for (field, value, from) in [
        ("position_decimals", controller.position_decimals, 3),
        ("quaternion_decimals", controller.quaternion_decimals, 6),
        ("speed_decimals", controller.speed_decimals, 0),
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
                     coordinate in mm and 6 of a quaternion",
                ),
            );
        }
    }
    problems
}

/// Values of the cell that RAPID cannot take although the job's language can say them.
fn values(cell: &RobotCell, decimals: Decimals) -> Vec<Problem> {
    let mut problems = Vec::new();
    let travel = cell.travel.speed.0 * 1e3;
    if scaled(travel, decimals.speed).is_none_or(|speed| speed <= 0) {
        problems.push(
            Problem::error(
                E0904,
                "robot.cell.travel.speed",
                format!("the travel speed {travel} mm/s cannot be written"),
            )
            .note(format!("a speed has {} decimals in mm/s and must be above 0", decimals.speed))
            .help("raise the speed, or `speed_decimals` of the controller"),
        );
    }
    if let Process::signals(signals) = &cell.process {
        let numbers = signals.outputs.iter().map(|o| (&o.name, o.number)).enumerate().map(|(i, n)| ("outputs", i, n));
        let numbers = numbers
            .chain(signals.inputs.iter().map(|o| (&o.name, o.number)).enumerate().map(|(i, n)| ("inputs", i, n)));
        for (list, i, (name, number)) in numbers {
            if number.is_some() {
                problems.push(
                    Problem::error(
                        E0907,
                        format!("robot.cell.process.{list}.{i}.number"),
                        format!("the signal `{name}` has a number, and RAPID knows signals by name"),
                    )
                    .help("take `number` out"),
                );
            }
        }
        for (i, input) in signals.inputs.iter().enumerate() {
            let has_time = input.wait_at_most.0 > 0.0;
            if has_time {
                continue;
            }
            let field = format!("robot.cell.process.inputs.{i}.wait_at_most");
            problems.push(
                Problem::error(E0904, field, format!("the wait for `{}` has no time", input.name))
                    .note("RAPID's `WaitDI` takes a time limit above 0 s"),
            );
        }
    }
    problems
}

/// Points that fit into one module by both of its limits, each point written as long as it can be; see
/// [`crate::target::Limits`].
pub fn points_per_module(rapid: &Rapid) -> usize {
    let limit = |value: i64| usize::try_from(value).unwrap_or(0);
    let line = chunk::MOVE_LENGTH + chunk::WRAP.len() + rapid.tool_name.len() + rapid.object_name.len();
    // Approach, start and retract of a run, and its comment.
    let around = chunk::FRAME_BYTES + 4 * (line + text::LINE_LENGTH);
    let by_bytes = limit(rapid.controller.module_bytes).saturating_sub(around) / line;
    limit(rapid.controller.module_points).min(by_bytes)
}

/// Runs gathered into modules: as many as fit the limits of points and bytes, in order.
fn pack(setup: &Setup, runs: &[Vec<u8>]) -> Result<Vec<Chunk>, Vec<Problem>> {
    let limit = |value: i64| usize::try_from(value).unwrap_or(0);
    let most_points = limit(setup.rapid.controller.module_points);
    let most_bytes = limit(setup.rapid.controller.module_bytes).saturating_sub(chunk::FRAME_BYTES);
    let mut chunks: Vec<Chunk> = Vec::new();
    let mut bytes = 0;
    for (r, (run, text)) in setup.motion.runs.iter().zip(runs).enumerate() {
        let limits = &setup.rapid.controller;
        for (field, size, room, most, what) in [
            ("module_points", run.points.len(), most_points, limits.module_points, "points"),
            ("module_bytes", text.len(), most_bytes, limits.module_bytes, "bytes"),
        ] {
            if size > room {
                return Err(vec![
                    Problem::error(
                        E0903,
                        format!("target.controller.{field}"),
                        format!("run {} needs {size} {what}, a module of {most} {what} has room for {room}", r + 1),
                    )
                    .note("a module ends only where the tool is lifted off the part")
                    .help(format!(
                        "raise `{field}` if the controller takes larger modules, or take a longer `path.point_step`"
                    )),
                ]);
            }
        }
        match chunks.last_mut() {
            Some(last) if last.points.len() + run.points.len() <= most_points && bytes + text.len() <= most_bytes => {
                last.runs.end = r + 1;
                last.points.end = run.points.end;
                bytes += text.len();
            }
            _ => {
                chunks.push(Chunk { runs: r..r + 1, points: run.points.clone() });
                bytes = text.len();
            }
        }
    }
    Ok(chunks)
}

impl Setup<'_> {
    /// The time that a move between two joint poses gets, so that no joint needs more than the cell's share of its rated
    /// speed, seconds, rounded up to a millisecond. At least 0.1 s: a time of nothing is no time, and the arm's own
    /// acceleration makes short moves longer anyhow.
    fn joint_move_time(&self, changes: impl Fn(usize) -> f64) -> f64 {
        let mut time = 0.1_f64;
        for (j, joint) in self.robot.joints.iter().enumerate() {
            time = time.max(changes(j).abs() / (self.cell.joint_move_speed * joint.speed.0));
        }
        (time * 1e3).ceil() * 1e-3
    }

    /// `[v,orientation speed,5000,1000]`, the speed in m/s. The last two belong to external axes, which are not there.
    fn speeddata(&self, speed: f64) -> Option<String> {
        let mut out = b"[".to_vec();
        push_fixed(&mut out, speed * 1e3, self.decimals.speed)?;
        out.push(b',');
        let orientation = degrees(self.rapid.controller.orientation_speed.0);
        push_fixed(&mut out, orientation, self.decimals.speed)?;
        out.extend_from_slice(b",5000,1000]");
        String::from_utf8(out).ok()
    }
}
