//! The path: every move of the text against the plan.
//!
//! In: the chunk modules, the frames that the text states. Out: findings, in terms of the part. The moves are replayed as
//! the controller would run them under `ConfL\Off`: from the planned joints of each run's start, to the nearest solution
//! at every target, with numbers in single precision.

use super::declarations::{self, Place};
use super::main_module::Frames;
use super::moves::{self, Difference, Resolved, ResolvedGoal, resolve, same_jointtarget};
use super::statements::{Around, Step, compare};
use super::syntax::{Data, Module, Robtarget, Statement, What};
use super::values::{Scope, shape};
use super::{Findings, Wanted, at, read_all};
use crate::diagnostics::codes::{E1001, E1002, E1003, E1005, E1006, E1007, E1008, E1009, E1013, E1014};
use crate::job::{Tool, Zone};
use crate::motion::configuration::confdata;
use crate::motion::{Joints, Purpose, ToolPose, Transform, Travel};
use crate::target::ProgramFile;
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};
use rayon::prelude::*;
use std::ops::Range;

/// How far a contact point may lie from the planned one, metres: a few times what four decimals of a millimetre leave,
/// and a thousandth of what an influence function changes over.
const CONTACT_TOLERANCE: f64 = 1e-6;

/// A joint that arrives farther than this from its plan is in another configuration, radians: rounding moves joints by a
/// millionth of a degree, branches lie apart by twice the margins to the singularities, turns by 360 deg.
const CONFIGURATION_TOLERANCE: f64 = std::f64::consts::PI / 180.0;

/// Modules held in memory at a time, so that five million points need no more than the text itself.
const WINDOW: usize = 32;

/// A move that the plan asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Planned {
    /// Straight to the approach point of a run.
    Approach(usize),
    /// The joint move to a run's approach point.
    Start(usize),
    /// To a point, by its index.
    Point(usize),
    /// To the retract point of a run.
    Retract(usize),
}

/// Compares all chunk modules with the plan.
pub fn check(wanted: &Wanted, main: &Module, frames: &Frames, files: &[&ProgramFile], findings: &mut Findings) {
    let replay = Replay::new(wanted, frames);
    let count = wanted.motion.runs.len();
    let mut next_run = 0;
    for (window, part) in files.chunks(WINDOW).enumerate() {
        let first = window * WINDOW;
        let modules = read_all(part);
        let mut runs: Vec<Range<usize>> = Vec::with_capacity(part.len());
        for (k, module) in modules.iter().enumerate() {
            let last = first + k + 1 == files.len();
            let moves = module.as_ref().map_or(0, |module| module.moves.len());
            let end = if last { count } else { next_run + runs_in(wanted, next_run, moves) };
            runs.push(next_run..end);
            next_run = end;
        }
        let found: Vec<Findings> = modules
            .into_par_iter()
            .enumerate()
            .map(|(k, module)| {
                let mut found = Findings::default();
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
                        chunk.check(&data, runs[k].clone(), &mut found);
                    }
                    Err(problem) => found.add(|| problem),
                }
                found
            })
            .collect();
        found.into_iter().for_each(|found| findings.join(found));
    }
}

/// How many runs, from `first` on, a module with so many moves most likely holds. A move too many or too few, put in or
/// taken out by hand, does not change the answer.
fn runs_in(wanted: &Wanted, first: usize, moves: usize) -> usize {
    let mut best = (usize::MAX, 0);
    let mut sum = 0;
    for (n, run) in wanted.motion.runs.iter().skip(first).enumerate() {
        sum += 2 + run.points.len() + usize::from(run.travel == Travel::Straight);
        if sum.abs_diff(moves) < best.0 {
            best = (sum.abs_diff(moves), n + 1);
        }
        if sum > moves {
            break;
        }
    }
    best.1
}

/// The frames of the replay, put together once.
struct Replay {
    /// Object frame of the text in the part frame: the identity when the text's frames are the job's.
    part_object: Transform,
    /// Tool frame of the job in the tool frame of the text: the identity when they are the same.
    tool_change: Transform,
    /// Object frame of the text in the robot's base.
    base_object: Transform,
    /// Flange in the tool frame of the text.
    tool_flange: Transform,
    /// From the contact point to the tool centre point along the normal, metres.
    standoff: f64,
}

impl Replay {
    fn new(wanted: &Wanted, frames: &Frames) -> Replay {
        let chain = &wanted.motion.frames;
        let Tool::mrf_wheel(wheel) = &wanted.job.tool;
        let lift = match wanted.motion.purpose {
            Purpose::Polish => 0.0,
            Purpose::DryRun => wanted.cell.travel.height.0,
        };
        let object = frames.world_user * frames.user_object;
        Replay {
            part_object: (chain.world_user * chain.user_object).inverse() * object,
            tool_change: frames.flange_tool.inverse() * chain.flange_tool,
            base_object: chain.world_base.inverse() * object,
            tool_flange: frames.flange_tool.inverse(),
            standoff: wheel.gap.0 + lift,
        }
    }

    /// The target's pose in the text's object frame.
    fn target(target: &Robtarget) -> Transform {
        let [x, y, z] = target.position.map(|v| f64::from(v) * 1e-3);
        let [w, i, j, k] = target.quaternion.map(f64::from);
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        Transform::from_parts(Translation3::new(x, y, z), rotation)
    }

    /// The job's tool in the part frame, when the text's tool is at `target`.
    fn tool(&self, target: &Transform) -> Transform {
        self.part_object * target * self.tool_change
    }
}

struct Chunk<'a> {
    wanted: &'a Wanted<'a>,
    replay: &'a Replay,
    file: &'a str,
    /// Which module, from 0.
    index: usize,
    module: &'a Module,
    main: &'a Module,
}

impl Chunk<'_> {
    fn check(&self, data: &[&[Data]], runs: Range<usize>, findings: &mut Findings) {
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
        self.start(own, runs.start, findings);
        self.before_the_path(own, runs.start, routine.line, &routine.body, &others, findings);

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
        let planned = self.planned(runs);
        self.moves(scope, &planned, &resolved, findings);
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

    /// The moves that the plan asks for in these runs.
    fn planned(&self, runs: Range<usize>) -> Vec<Planned> {
        let mut all = Vec::new();
        for r in runs {
            let Some(run) = self.wanted.motion.runs.get(r) else { continue };
            if run.travel == Travel::Straight {
                all.push(Planned::Approach(r));
            }
            all.push(Planned::Start(r));
            all.extend(run.points.clone().map(Planned::Point));
            all.push(Planned::Retract(r));
        }
        all
    }

    /// Follows text and plan side by side.
    fn moves(&self, scope: Scope, planned: &[Planned], found: &[Resolved], findings: &mut Findings) {
        let (mut f, mut p) = (0, 0);
        let mut joints = match planned.first() {
            Some(Planned::Approach(r)) if *r > 0 => self.wanted.motion.runs[*r - 1].retract_joints,
            _ => self.wanted.motion.home,
        };
        let mut line = self.module.routines.first().map_or(1, |routine| routine.line);
        loop {
            let (rest_found, rest_planned) = (&found[f..], &planned[p..]);
            let (Some(one), Some(plan)) = (rest_found.first(), rest_planned.first()) else { break };
            if !self.lies_at(one, *plan) {
                // Fewer moves than planned: perhaps some are missing here. More: perhaps some were put in.
                let missing = rest_planned.len().saturating_sub(rest_found.len());
                let extra = rest_found.len().saturating_sub(rest_planned.len());
                if let Some(k) = (1..=missing).find(|k| self.lies_at(one, rest_planned[*k])) {
                    self.missing(one.line, &rest_planned[..k], findings);
                    p += k;
                    continue;
                }
                if let Some(k) = (1..=extra).find(|k| self.lies_at(&rest_found[*k], *plan)) {
                    self.extra(&rest_found[..k], *plan, findings);
                    f += k;
                    continue;
                }
                if let (Some(next), Some(next_plan)) = (rest_found.get(1), rest_planned.get(1))
                    && self.lies_at(one, *next_plan)
                    && self.lies_at(next, *plan)
                {
                    let what = format!("{} and {} are swapped", self.place(*plan), self.place(*next_plan));
                    findings.add(|| at(self.file, one.line, E1013, "path", what));
                    joints = self.planned_joints(*next_plan);
                    line = next.line;
                    f += 2;
                    p += 2;
                    continue;
                }
            }
            self.one_move(scope, *plan, one, &mut joints, findings);
            line = one.line;
            f += 1;
            p += 1;
        }
        if p < planned.len() {
            self.missing(line, &planned[p..], findings);
        }
        if let (Some(last), true) = (planned.last(), f < found.len()) {
            self.extra(&found[f..], *last, findings);
        } else if let (None, Some(first)) = (planned.last(), found.get(f)) {
            let what = "the plan has no moves for this module".to_string();
            findings.add(|| at(self.file, first.line, E1013, "path", what));
        }
    }

    fn missing(&self, line: u32, planned: &[Planned], findings: &mut Findings) {
        let [first, .., last] = planned else {
            if let [one] = planned {
                let what = format!("{} is missing before this line", self.place(*one));
                findings.add(|| at(self.file, line, E1013, "path", what));
            }
            return;
        };
        let (first, last) = (self.place(*first), self.place(*last));
        let what = format!("{} moves are missing before this line, from {first} to {last}", planned.len());
        findings.add(|| at(self.file, line, E1013, "path", what));
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
        let near = self.place(before);
        let what = match found.len() {
            1 => format!("a move {goal} is not planned, near {near}"),
            count => format!("{count} moves are not planned, the first {goal}, near {near}"),
        };
        findings.add(|| at(self.file, first.line, E1013, "path", what));
    }

    /// The pose that a move of the plan ends in.
    fn planned_pose(&self, planned: Planned) -> ToolPose {
        let motion = self.wanted.motion;
        match planned {
            Planned::Approach(r) | Planned::Start(r) => motion.runs[r].approach,
            Planned::Retract(r) => motion.runs[r].retract,
            Planned::Point(i) => ToolPose { position: motion.position[i], quaternion: motion.quaternion[i] },
        }
    }

    fn planned_joints(&self, planned: Planned) -> Joints {
        let motion = self.wanted.motion;
        match planned {
            Planned::Approach(r) | Planned::Start(r) => motion.runs[r].approach_joints,
            Planned::Retract(r) => motion.runs[r].retract_joints,
            Planned::Point(i) => motion.joints[i],
        }
    }

    /// Whether a move ends where the plan's does, orientation apart.
    fn lies_at(&self, found: &Resolved, planned: Planned) -> bool {
        match (&found.goal, planned) {
            (ResolvedGoal::Joints(joints), Planned::Start(r)) => {
                moves::same_jointtarget(&joints.map(f64::from), &self.wanted.motion.runs[r].approach_joints).is_ok()
            }
            (ResolvedGoal::Linear(target), Planned::Approach(_) | Planned::Point(_) | Planned::Retract(_)) => {
                let tool = self.replay.tool(&Replay::target(target));
                let [x, y, z] = self.planned_pose(planned).position;
                (tool.translation.vector - Vector3::new(x, y, z)).norm() <= CONTACT_TOLERANCE
            }
            _ => false,
        }
    }

    /// A move of the plan, in terms of the part.
    fn place(&self, planned: Planned) -> String {
        let motion = self.wanted.motion;
        match planned {
            Planned::Approach(r) | Planned::Start(r) => format!("the approach of run {}", r + 1),
            Planned::Retract(r) => format!("the retract of run {}", r + 1),
            Planned::Point(i) => {
                let lines = &motion.timed.path.lines;
                let line = lines.partition_point(|line| line.points.end <= i) + 1;
                let [x, y, _] = motion.timed.path.points.position(i).map(millimetres);
                format!("point {} of {} (line {line}, x = {x}, y = {y} mm)", i + 1, motion.position.len())
            }
        }
    }

    /// Compares one move with its plan, and replays it.
    fn one_move(&self, scope: Scope, planned: Planned, one: &Resolved, joints: &mut Joints, findings: &mut Findings) {
        let motion = self.wanted.motion;
        let mut report = |difference: Difference| {
            let Difference { code, field, what } = difference;
            findings.add(|| at(self.file, one.line, code, field, format!("{} {what}", self.place(planned))));
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
                *joints = self.planned_joints(planned);
                return;
            }
            (Planned::Point(i), ResolvedGoal::Linear(target)) => {
                let good = self.pose(planned, target, &mut report);
                (good, motion.timed.speed[i], self.zone(i))
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
        let lines = &self.wanted.motion.timed.path.lines;
        let line = lines.get(lines.partition_point(|line| line.points.end <= i));
        if line.is_some_and(|line| i == line.points.start || i + 1 == line.points.end) {
            return "fine";
        }
        match self.wanted.rapid.zone {
            Zone::fine => "fine",
            Zone::z0 => "z0",
            Zone::z1 => "z1",
            Zone::z5 => "z5",
        }
    }

    /// Where the tool stands on the part: contact point, normal, turn about it. Whether all is as planned.
    fn pose(&self, planned: Planned, target: &Robtarget, report: &mut impl FnMut(Difference)) -> bool {
        if let Err(what) = moves::unit_length(target.quaternion.map(f64::from)) {
            report(Difference { code: E1007, field: "path", what: format!("is turned by no rotation: {what}") });
            return false;
        }
        let wanted = self.planned_pose(planned);
        let tool = self.replay.tool(&Replay::target(target));
        let [w, x, y, z] = wanted.quaternion;
        let wanted_rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        // The tool's +z points into the glass.
        let axis = tool.rotation * Vector3::z();
        let (contact, normal) = match planned {
            Planned::Point(i) => {
                let points = &self.wanted.motion.timed.path.points;
                (points.position(i), Vector3::from(points.normal(i)))
            }
            _ => {
                let axis = wanted_rotation * Vector3::z();
                ((Vector3::from(wanted.position) + axis * self.replay.standoff).into(), -axis)
            }
        };
        let found = tool.translation.vector + axis * self.replay.standoff;
        let off = (found - Vector3::from(contact)).norm();
        // Written so that a place that is no number differs.
        let at_place = off <= CONTACT_TOLERANCE;
        if !at_place {
            let [x, y, z] = [found.x, found.y, found.z].map(millimetres);
            let what =
                format!("is met at x = {x}, y = {y}, z = {z} mm, {} mm from where it is planned", millimetres(off));
            report(Difference { code: E1005, field: "path", what });
        }
        let tilt = libm::atan2(axis.cross(&-normal).norm(), axis.dot(&-normal));
        let upright = tilt <= moves::ORIENTATION_TOLERANCE;
        if !upright {
            let what = format!("is met {:.4} deg off the normal", tilt.to_degrees());
            report(Difference { code: E1014, field: "path", what });
            return false;
        }
        let turn = moves::angle_between(&tool.rotation, &wanted_rotation);
        let aligned = turn <= 2.0 * moves::ORIENTATION_TOLERANCE;
        if !aligned {
            let what = format!("is met with the tool turned by {:.4} deg about the normal", turn.to_degrees());
            report(Difference { code: E1014, field: "tool.azimuth", what });
            return false;
        }
        at_place
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
        let planned_joints = self.planned_joints(planned);
        let wanted = match planned {
            Planned::Point(i) => self.wanted.motion.confdata[i],
            _ => confdata(&self.wanted.arm, &planned_joints),
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
        // A wrong place was reported; from there on the plan's joints count.
        if !pose_is_good {
            *joints = planned_joints;
            return;
        }
        let flange = self.replay.base_object * Replay::target(target) * self.replay.tool_flange;
        match self.wanted.arm.nearest_solution(&flange, joints) {
            Some(solution) => {
                let far = (0..6).find(|j| (solution.joints[*j] - planned_joints[*j]).abs() > CONFIGURATION_TOLERANCE);
                *joints = solution.joints;
                if let Some(j) = far {
                    let [found, wanted] = [solution.joints[j], planned_joints[j]].map(f64::to_degrees);
                    let what = format!(
                        "is reached in another configuration: joint {} arrives at {found:.3} deg where {wanted:.3} deg is planned",
                        j + 1
                    );
                    report(Difference { code: E1006, field: "robot", what });
                    *joints = planned_joints;
                }
            }
            None => {
                report(Difference { code: E1006, field: "robot", what: "is out of the arm's reach".into() });
                *joints = planned_joints;
            }
        }
    }
}

/// Metres to millimetres, to the tenth of a micrometre, for messages.
fn millimetres(value: f64) -> f64 {
    // Adding zero takes the sign off -0.
    (value * 1e7).round() / 1e4 + 0.0
}
