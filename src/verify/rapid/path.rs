//! The path: every move of the text against the plan.
//!
//! In: the chunk modules, the frames that the text states. Out: findings, in terms of the part. The moves are replayed as
//! the controller would run them under `ConfL\Off`: from the planned joints of each run's start, to the nearest solution
//! at every target, with numbers in single precision.

use super::declarations::{self, Place};
use super::moves::{self, Resolved, ResolvedGoal, resolve, same_jointtarget};
use super::statements::{Around, Step, compare};
use super::syntax::{Data, Module, Robtarget, Statement, What};
use super::values::{Scope, shape};
use super::{Findings, Wanted, at, read_all};
use crate::diagnostics::codes::{E1001, E1002, E1003, E1004, E1006, E1007, E1008, E1009, E1013};
use crate::job::Zone;
use crate::motion::configuration::confdata;
use crate::motion::{Joints, Purpose, Transform, Travel};
use crate::target::ProgramFile;
use crate::verify::align::{self, Met};
use crate::verify::findings::Difference;
use crate::verify::planned::{self, Planned, runs_in};
use crate::verify::replay::{Frames, Replay};
use crate::verify::trace::{Arrival, Trace};
use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use rayon::prelude::*;
use std::ops::Range;

/// Modules held in memory at a time, so that five million points need no more than the text itself.
const WINDOW: usize = 32;

/// Compares all chunk modules with the plan.
pub fn check(wanted: &Wanted, main: &Module, frames: &Frames, files: &[&ProgramFile], findings: &mut Findings) {
    each_chunk(wanted, main, frames, files, findings, |chunk, scope, runs, resolved, findings| {
        let planned = Planned::of_runs(wanted.motion, runs);
        chunk.moves(scope, &planned, resolved, findings);
    });
}

/// The moves of all chunk modules, as the text says them.
pub fn trace(
    wanted: &Wanted,
    main: &Module,
    frames: &Frames,
    files: &[&ProgramFile],
    findings: &mut Findings,
) -> Trace {
    let mut trace = Trace::default();
    each_chunk(wanted, main, frames, files, findings, |chunk, scope, _, resolved, findings| {
        chunk.trace(scope, resolved, findings)
    })
    .into_iter()
    .for_each(|part| trace.append(part));
    trace
}

/// Reads every chunk module, compares what in it is no move, and lets `see` look at its moves. What `see` says comes in
/// the order of the modules.
fn each_chunk<T: Send + Default>(
    wanted: &Wanted,
    main: &Module,
    frames: &Frames,
    files: &[&ProgramFile],
    findings: &mut Findings,
    see: impl Fn(&Chunk, Scope, Range<usize>, &[Resolved], &mut Findings) -> T + Sync,
) -> Vec<T> {
    let replay = Replay::new(wanted.motion, wanted.job, wanted.cell, &wanted.arm, frames);
    let count = wanted.motion.runs.len();
    let mut next_run = 0;
    let mut seen = Vec::with_capacity(files.len());
    for (window, part) in files.chunks(WINDOW).enumerate() {
        let first = window * WINDOW;
        let modules = read_all(part);
        let mut runs: Vec<Range<usize>> = Vec::with_capacity(part.len());
        for (k, module) in modules.iter().enumerate() {
            let last = first + k + 1 == files.len();
            let moves = module.as_ref().map_or(0, |module| module.moves.len());
            let end = if last { count } else { next_run + runs_in(wanted.motion, next_run, moves) };
            runs.push(next_run..end);
            next_run = end;
        }
        let found: Vec<(T, Findings)> = modules
            .into_par_iter()
            .enumerate()
            .map(|(k, module)| {
                let mut found = Findings::default();
                let mut said = T::default();
                match module {
                    Ok(module) => {
                        let data = [module.data.as_slice(), main.data.as_slice()];
                        let chunk = Chunk {
                            wanted,
                            replay: &replay,
                            file: &part[k].name,
                            index: first + k,
                            module: &module,
                            main,
                        };
                        let runs = runs[k].clone();
                        chunk.read(&data, runs.start, &mut found, |scope, resolved, found| {
                            said = see(&chunk, scope, runs, resolved, found);
                        });
                    }
                    Err(problem) => found.add(|| problem),
                }
                (said, found)
            })
            .collect();
        for (said, found) in found {
            seen.push(said);
            findings.join(found);
        }
    }
    seen
}

/// The pose of a target in the text's object frame.
fn pose_of(target: &Robtarget) -> Transform {
    let [x, y, z] = target.position.map(|v| f64::from(v) * 1e-3);
    let [w, i, j, k] = target.quaternion.map(f64::from);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    Transform::from_parts(Translation3::new(x, y, z), rotation)
}

struct Chunk<'a> {
    wanted: &'a Wanted<'a>,
    replay: &'a Replay<'a>,
    file: &'a str,
    /// Which module, from 0.
    index: usize,
    module: &'a Module,
    main: &'a Module,
}

impl Chunk<'_> {
    /// Compares all that is no move with the job and the plan, and hands over the moves. `run` is the first run that the
    /// module holds.
    fn read(
        &self,
        data: &[&[Data]],
        run: usize,
        findings: &mut Findings,
        then: impl FnOnce(Scope, &[Resolved], &mut Findings),
    ) {
        let names = &self.wanted.names;
        let (name, routine_name) = (names.chunk_module(self.index), names.chunk_routine(self.index));
        if !self.module.name.eq_ignore_ascii_case(&name) {
            let what = format!("the module is called `{}`, the job asks for `{name}`", self.module.name);
            findings.add(|| at(self.file, 1, E1002, "target.module", what));
        }
        let [routine] = self.module.routines.as_slice() else {
            let what = format!("the module must hold the routine `{routine_name}` and no other");
            findings.add(|| at(self.file, 1, E1002, "target.module", what));
            return;
        };
        if !routine.name.eq_ignore_ascii_case(&routine_name)
            || routine.returns.is_some()
            || !routine.parameters.is_empty()
        {
            let what = format!("the routine must be `PROC {routine_name}()`");
            findings.add(|| at(self.file, routine.line, E1002, "target.module", what));
        }
        let levels: Vec<&[Data]> = std::iter::once(routine.data.as_slice()).chain(data.iter().copied()).collect();
        let scope = Scope { levels: &levels };
        let (module, start) = (self.module, names.chunk_start(self.index));
        for place in [Place::Chunk { module, start: &start }, Place::ChunkRoutine { module, routine, start: &start }] {
            declarations::check(self.wanted, self.file, place, self.main, scope, findings);
        }

        let is_move = |statement: &&Statement| matches!(statement.what, What::Move(_));
        let others: Vec<Statement> = routine.body.iter().filter(|s| !is_move(s)).cloned().collect();
        // Only what the module itself declares: data of the main module are those of another build where it matters.
        let own_levels: [&[Data]; 2] = [&routine.data, &self.module.data];
        let own = Scope { levels: &own_levels };
        self.start(own, run, findings);
        self.before_the_path(own, run, routine.line, &routine.body, &others, findings);

        let mut resolved: Vec<Resolved> = Vec::with_capacity(self.module.moves.len());
        for statement in &routine.body {
            let What::Move(index) = statement.what else { continue };
            let Some(one) = self.module.moves.get(index) else { continue };
            match resolve(self.module, scope, one) {
                Ok(one) => resolved.push(one),
                Err(what) => {
                    findings.add(|| at(self.file, one.line, E1001, "target", what));
                    return;
                }
            }
        }
        then(scope, &resolved, findings);
    }

    /// The moves as the text says them. Whatever leaves their place or speed open is a finding.
    fn trace(&self, scope: Scope, found: &[Resolved], findings: &mut Findings) -> Trace {
        let mut trace = Trace::default();
        for one in found {
            let mut report = |difference: Difference| {
                let Difference { code, field, what } = difference;
                findings.add(|| at(self.file, one.line, code, field, format!("the move {what}")));
            };
            moves::names(self.wanted, one).into_iter().for_each(&mut report);
            match &one.goal {
                ResolvedGoal::Joints(joints) => {
                    let joints = std::array::from_fn(|j| f64::from(joints[j]).to_radians());
                    trace.push(&self.replay.tool_of_joints(&joints), 0.0, Arrival::Joints);
                }
                ResolvedGoal::Linear(target) => {
                    moves::other_speeds(self.wanted, one.speed.map(f64::from)).into_iter().for_each(&mut report);
                    if let Err(what) = moves::unit_length(target.quaternion.map(f64::from)) {
                        report(Difference {
                            code: E1007,
                            field: "path",
                            what: format!("turns by no rotation: {what}"),
                        });
                    }
                    if one.time.is_some() {
                        let what = "has a time where it must have a speed".to_string();
                        report(Difference { code: E1008, field: "dwell", what });
                    }
                    let speed = f64::from(one.speed[0]) * 1e-3;
                    if !(speed > 0.0 && speed.is_finite()) {
                        let what = format!("has the speed {} mm/s", one.speed[0]);
                        report(Difference { code: E1008, field: "dwell.feed", what });
                    }
                    let arrival = match moves::stops(scope, one.zone) {
                        Some(true) => Arrival::Stopping,
                        Some(false) => Arrival::Passing,
                        None => {
                            let what = format!("has the zone `{}`, which this compiler does not know", one.zone);
                            report(Difference { code: E1004, field: "target.zone", what });
                            Arrival::Passing
                        }
                    };
                    trace.push(&self.replay.tool(&pose_of(target)), speed, arrival);
                }
            }
        }
        trace
    }

    /// The constant that says where the module begins, unless that is at home.
    fn start(&self, scope: Scope, run: usize, findings: &mut Findings) {
        let Some(before) = run.checked_sub(1).and_then(|run| self.wanted.motion.runs.get(run)) else { return };
        let name = self.wanted.names.chunk_start(self.index);
        let field = "path";
        let Some(data) = scope.find(&name) else {
            let what = format!("`jointtarget {name}` is not declared in this module");
            findings.add(|| at(self.file, 1, E1003, field, what));
            return;
        };
        let value = data.value.as_ref().and_then(|value| scope.numbers(value, shape::JOINTTARGET));
        let same = match value {
            Some(found) if data.of_type.eq_ignore_ascii_case("jointtarget") => {
                same_jointtarget(&found, &before.retract_joints)
            }
            _ => Err("it is no `jointtarget` with values written out".to_string()),
        };
        if let Err(what) = same {
            findings.add(|| at(self.file, data.line, E1003, field, format!("`{name}`: {what}")));
        }
    }

    /// What is no move: the comparison of the digest and of the place, before everything else.
    fn before_the_path(
        &self,
        scope: Scope,
        run: usize,
        line: u32,
        body: &[Statement],
        others: &[Statement],
        findings: &mut Findings,
    ) {
        let name = self.wanted.names.chunk_module(self.index);
        let m = &self.wanted.names.module;
        let off = match self.wanted.motion.purpose {
            Purpose::Polish => format!("{m}_process_off; "),
            Purpose::DryRun => String::new(),
        };
        let text = format!(
            "IF {m}_digest<>\"{}\" THEN TPWrite \"{name} belongs to another build\"; {off}EXIT; ENDIF",
            self.wanted.digest
        );
        let why = "a module of another build must never move the robot";
        let digest = Step::say(E1009, "target", &text, why);
        let start = if run == 0 { format!("{m}_home") } else { self.wanted.names.chunk_start(self.index) };
        let text = format!(
            "IF NOT {m}_near(CJointT(),{start}) THEN TPWrite \"{name}: not where it begins\"; {off}EXIT; ENDIF"
        );
        let why_here = "the way to the first point is checked from the planned place only";
        let place = Step::say(E1003, "robot.cell.home_tolerance", &text, why_here);
        let around = Around {
            file: self.file,
            scope,
            moves: &self.module.moves,
            home: &|_, _| Err("a joint move to home has no place here".into()),
        };
        compare(&around, line, others, &[digest, place], findings);
        let early = body.iter().take(2).enumerate().find(|(_, statement)| matches!(statement.what, What::Move(_)));
        if let Some((before, statement)) = early {
            let (what, why) = match before {
                0 => ("the robot moves before the digest is compared", why),
                _ => ("the robot moves before its place is compared", why_here),
            };
            findings.add(|| at(self.file, statement.line, E1003, "target", what.to_string()).note(why));
        }
    }

    /// Follows text and plan side by side.
    fn moves(&self, scope: Scope, planned: &[Planned], found: &[Resolved], findings: &mut Findings) {
        let motion = self.wanted.motion;
        let mut joints = match planned.first() {
            Some(Planned::Approach(r)) if *r > 0 => motion.runs[*r - 1].retract_joints,
            _ => motion.home,
        };
        let first_line = self.module.routines.first().map_or(1, |routine| routine.line);
        let line = |f: usize| found.get(f).or(found.last()).map_or(first_line, |one| one.line);
        align::moves(
            found.len(),
            planned.len(),
            |f, p| self.lies_at(&found[f], planned[p]),
            |met| match met {
                Met::Pair { found: f, wanted: p } => self.one_move(scope, planned[p], &found[f], &mut joints, findings),
                Met::Missing { wanted: p, before } => {
                    let what = planned::missing(motion, &planned[p]);
                    findings.add(|| at(self.file, line(before), E1013, "path", what));
                }
                Met::Extra { found: f, before } => match planned.get(before).or(planned.last()) {
                    Some(near) => self.extra(&found[f], *near, findings),
                    None => {
                        let what = "the plan has no moves for this module".to_string();
                        findings.add(|| at(self.file, line(f.start), E1013, "path", what));
                    }
                },
                Met::Swapped { found: f, wanted: p } => {
                    let [one, next] = [planned[p], planned[p + 1]];
                    let what = format!("{} and {} are swapped", one.place(motion), next.place(motion));
                    findings.add(|| at(self.file, line(f), E1013, "path", what));
                    joints = next.joints(motion);
                }
            },
        );
    }

    fn extra(&self, found: &[Resolved], before: Planned, findings: &mut Findings) {
        let Some(first) = found.first() else { return };
        let goal = match &first.goal {
            ResolvedGoal::Linear(target) => {
                let [x, y, z] = target.position;
                format!("to x = {x}, y = {y}, z = {z} mm")
            }
            ResolvedGoal::Joints(_) => "of the joints".into(),
        };
        let near = before.place(self.wanted.motion);
        let what = match found.len() {
            1 => format!("a move {goal} is not planned, near {near}"),
            count => format!("{count} moves are not planned, the first {goal}, near {near}"),
        };
        findings.add(|| at(self.file, first.line, E1013, "path", what));
    }

    /// Whether a move ends where the plan's does, orientation apart.
    fn lies_at(&self, found: &Resolved, planned: Planned) -> bool {
        match (&found.goal, planned) {
            (ResolvedGoal::Joints(joints), Planned::Start(r)) => {
                moves::same_jointtarget(&joints.map(f64::from), &self.wanted.motion.runs[r].approach_joints).is_ok()
            }
            (ResolvedGoal::Linear(target), Planned::Approach(_) | Planned::Point(_) | Planned::Retract(_)) => {
                self.replay.lies_at(&pose_of(target), planned)
            }
            _ => false,
        }
    }

    /// Compares one move with its plan, and replays it.
    fn one_move(&self, scope: Scope, planned: Planned, one: &Resolved, joints: &mut Joints, findings: &mut Findings) {
        let motion = self.wanted.motion;
        let mut report = |difference: Difference| {
            let Difference { code, field, what } = difference;
            findings.add(|| at(self.file, one.line, code, field, format!("{} {what}", planned.place(motion))));
        };
        let travel = self.wanted.cell.travel.speed.0;
        let (pose_is_good, speed, zone) = match (planned, &one.goal) {
            (Planned::Start(r), _) => {
                let run = &motion.runs[r];
                let time = (run.travel == Travel::Joint).then(|| {
                    let from = if r == 0 { motion.home } else { motion.runs[r - 1].retract_joints };
                    self.wanted.joint_move_time(|j| run.approach_joints[j] - from[j])
                });
                moves::joint_move(self.wanted, scope, one, &run.approach_joints, time).into_iter().for_each(report);
                *joints = run.approach_joints;
                return;
            }
            (_, ResolvedGoal::Joints(_)) => {
                let what = "is a joint move where a linear move is planned".to_string();
                report(Difference { code: E1013, field: "path", what });
                *joints = planned.joints(motion);
                return;
            }
            (Planned::Point(i), ResolvedGoal::Linear(target)) => {
                let good = self.pose(planned, target, &mut report);
                (good, motion.timed.speed[i], self.zone(i))
            }
            (Planned::Retract(r), ResolvedGoal::Linear(target)) => {
                (self.pose(planned, target, &mut report), motion.runs[r].retract_speed, "fine")
            }
            (_, ResolvedGoal::Linear(target)) => (self.pose(planned, target, &mut report), travel, "fine"),
        };
        if let ResolvedGoal::Linear(target) = &one.goal {
            self.configuration(planned, target, pose_is_good, joints, &mut report);
        }
        if one.time.is_some() {
            let what = "has a time where a speed is planned".to_string();
            report(Difference { code: E1008, field: "dwell", what });
        }
        let rest = [
            moves::speed(self.wanted, one.speed, speed),
            moves::zone(scope, one.zone, zone),
            moves::names(self.wanted, one),
        ];
        rest.into_iter().flatten().for_each(report);
    }

    /// The zone at a point: none at the ends of a line, where the plan has the tool at rest.
    fn zone(&self, i: usize) -> &'static str {
        let line = planned::line_of(self.wanted.motion, i);
        if i == line.first || i == line.last {
            return "fine";
        }
        match self.wanted.rapid.zone {
            Zone::fine => "fine",
            Zone::z0 => "z0",
            Zone::z1 => "z1",
            Zone::z5 => "z5",
        }
    }

    /// Where the tool stands on the part. Whether all is as planned.
    fn pose(&self, planned: Planned, target: &Robtarget, report: &mut impl FnMut(Difference)) -> bool {
        if let Err(what) = moves::unit_length(target.quaternion.map(f64::from)) {
            report(Difference { code: E1007, field: "path", what: format!("is turned by no rotation: {what}") });
            return false;
        }
        self.replay.pose(planned, &pose_of(target), report)
    }

    /// Configuration data as planned, and the arm arriving in the planned joints.
    fn configuration(
        &self,
        planned: Planned,
        target: &Robtarget,
        pose_is_good: bool,
        joints: &mut Joints,
        report: &mut impl FnMut(Difference),
    ) {
        let wanted = match planned {
            Planned::Point(i) => self.wanted.motion.confdata[i],
            _ => confdata(&self.wanted.arm, &planned.joints(self.wanted.motion)),
        };
        let found = target.confdata.map(f64::from);
        if !found.iter().zip(wanted).all(|(found, wanted)| *found == f64::from(wanted)) {
            let list = |values: [f64; 4]| values.map(|value| value.to_string()).join(",");
            let (found, wanted) = (list(found), list(wanted.map(f64::from)));
            let what = format!("has the configuration data [{found}] where [{wanted}] is planned");
            report(Difference { code: E1006, field: "robot", what });
        }
        if let Err(what) = moves::no_external_axes(&target.external.map(f64::from)) {
            report(Difference { code: E1006, field: "robot", what: format!("cannot be reached so: {what}") });
        }
        self.replay.arrives(planned, &pose_of(target), pose_is_good, joints, report);
    }
}
