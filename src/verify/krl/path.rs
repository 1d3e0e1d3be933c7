//! The path: every move of the text against the plan.
//!
//! In: the sub-programs, the frames that the text states. Out: findings, in terms of the part. The moves are replayed as
//! the controller would run them: from the planned joints of each run's start, to the nearest solution at every target
//! (path motions do not look at S and T), with numbers in single precision; and halfway along every segment of a block by
//! the model of [`super::spline`].

use super::main_program::{self, rotation, same_joints};
use super::routines::WantedRoutine;
use super::spline;
use super::statements::{Step, compare};
use super::syntax::{Goal, Kind, Source, Statement, Target, What};
use super::values::{Scope, components};
use super::{Pair, Wanted, reader, unreadable};
use crate::diagnostics::Problem;
use crate::diagnostics::codes::{E1001, E1003, E1004, E1006, E1008, E1009, E1013, E1015};
use crate::job::LineMotion;
use crate::motion::configuration::status_turn;
use crate::motion::{Joints, Purpose, Transform};
use crate::target::krl::digest_words;
use crate::verify::align::{self, Met};
use crate::verify::findings::{Difference, Findings, at};
use crate::verify::planned::{self, Planned, line_of, millimetres, runs_in};
use crate::verify::replay::{CONFIGURATION_TOLERANCE, Frames, Replay, angle_between_directions, shortest};
use crate::verify::trace::{Arrival, Trace};
use nalgebra::{Translation3, Vector3};
use rayon::prelude::*;
use std::ops::Range;

/// Files held in memory at a time.
const WINDOW: usize = 32;

/// How far the contact point may leave the surface between two points, metres: half a percent of the gap of an MRF
/// wheel, the smallest distance that a tool keeps, and several times what the points themselves may.
const BETWEEN_TOLERANCE: f64 = 5e-6;

/// How far the tool may lean there, radians: 0.01 deg, under a micrometre of height over a 10 mm spot.
const LEAN_TOLERANCE: f64 = 0.01 * std::f64::consts::PI / 180.0;

/// How far a written speed may lie from the planned one, as a share: half of the last of seven digits, and the rounding of
/// single precision.
const SPEED_SHARE: f64 = 6e-7;

/// Compares all sub-programs with the plan.
pub fn check(wanted: &Wanted, frames: &Frames, pairs: &[Pair], findings: &mut Findings) {
    each_sub_program(wanted, frames, pairs, findings, |part, line, runs, resolved, findings| {
        let planned = Planned::of_runs(wanted.motion, runs);
        part.moves(&planned, resolved, line, findings);
    });
}

/// The moves of all sub-programs, as the text says them.
pub fn trace(wanted: &Wanted, frames: &Frames, pairs: &[Pair], findings: &mut Findings) -> Trace {
    let mut trace = Trace::default();
    each_sub_program(wanted, frames, pairs, findings, |part, _, _, resolved, findings| part.trace(resolved, findings))
        .into_iter()
        .for_each(|part| trace.append(part));
    trace
}

/// Reads every sub-program, compares what in it is no move, and lets `see` look at its moves, beside the line where its
/// routine begins. What `see` says comes in the order of the sub-programs.
fn each_sub_program<T: Send + Default>(
    wanted: &Wanted,
    frames: &Frames,
    pairs: &[Pair],
    findings: &mut Findings,
    see: impl Fn(&SubProgram, u32, Range<usize>, &[Resolved], &mut Findings) -> T + Sync,
) -> Vec<T> {
    let replay = Replay::new(wanted.motion, wanted.job, wanted.cell, &wanted.arm, frames);
    let count = wanted.motion.runs.len();
    let mut next_run = 0;
    let mut seen = Vec::with_capacity(pairs.len());
    for (window, part) in pairs.chunks(WINDOW).enumerate() {
        let first = window * WINDOW;
        let sources: Vec<Result<Source, Problem>> = part
            .par_iter()
            .map(|pair| reader::read_source(&pair.source.bytes).map_err(|fault| unreadable(pair.source, &fault)))
            .collect();
        let mut runs: Vec<Range<usize>> = Vec::with_capacity(part.len());
        for (k, source) in sources.iter().enumerate() {
            let last = first + k + 1 == pairs.len();
            let moves = source.as_ref().map_or(0, moves_in);
            let end = if last { count } else { next_run + runs_in(wanted.motion, next_run, moves) };
            runs.push(next_run..end);
            next_run = end;
        }
        let found: Vec<(T, Findings)> = sources
            .into_par_iter()
            .enumerate()
            .map(|(k, source)| {
                let mut found = Findings::default();
                let mut said = T::default();
                match source {
                    Ok(source) => {
                        let part =
                            SubProgram { wanted, replay: &replay, files: part[k], index: first + k, source: &source };
                        let runs = runs[k].clone();
                        part.read(runs.start, &mut found, |line, resolved, found| {
                            said = see(&part, line, runs, resolved, found);
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

/// All moves of a file, joint moves included.
fn moves_in(source: &Source) -> usize {
    let joint_moves = |statement: &&Statement| matches!(statement.what, What::JointMove(_));
    let joint = source.routines.iter().flat_map(|routine| &routine.body).filter(joint_moves).count();
    source.moves.len() + joint
}

/// A move with all names resolved.
struct Resolved {
    line: u32,
    goal: ResolvedGoal,
}

enum ResolvedGoal {
    /// Six joints, degrees.
    Joints([f64; 6]),
    Place {
        pose: Transform,
        status: f32,
        turn: f32,
        kind: Kind,
        opens: bool,
        closes: bool,
        speed: Option<f32>,
    },
}

struct SubProgram<'a> {
    wanted: &'a Wanted<'a>,
    replay: &'a Replay<'a>,
    files: Pair<'a>,
    /// Which one, from 0.
    index: usize,
    source: &'a Source,
}

impl SubProgram<'_> {
    /// Compares all that is no move with the job and the plan, and hands over the moves and the line where the routine
    /// begins. `run` is the first run that the file holds.
    fn read(&self, run: usize, findings: &mut Findings, then: impl FnOnce(u32, &[Resolved], &mut Findings)) {
        let file = &self.files.source.name;
        let names = &self.wanted.names;
        let name = names.sub_program(self.index);
        let data = match reader::read_data(&self.files.data.bytes) {
            Ok(data) => data,
            Err(fault) => return findings.add(|| unreadable(self.files.data, &fault)),
        };
        main_program::same_name(self.files.data, data.line, &data.name, &name, findings);
        let scope = Scope { data: &data.data };
        let [routine] = self.source.routines.as_slice() else {
            let what = format!("the file must hold `DEF {name}` and no other routine");
            return findings.add(|| at(file, 1, E1003, "target.module", what));
        };
        main_program::same_name(self.files.source, routine.line, &routine.name, &name, findings);
        let want = WantedRoutine {
            name: name.clone(),
            global: false,
            returns: None,
            parameters: &["d1", "d2", "d3", "d4"],
            data: &[("INT", "d1"), ("INT", "d2"), ("INT", "d3"), ("INT", "d4")],
            steps: self.before_the_path(&name),
        };
        main_program::heading(file, routine, &want, findings);
        self.data(scope, run, findings);

        // Setting the speed is part of the moves: the reader followed it.
        let of_the_path = |statement: &Statement| match &statement.what {
            What::Move(_) | What::JointMove(_) => true,
            What::Assign(target, _) => target.eq_ignore_ascii_case("$VEL.CP"),
            _ => false,
        };
        let others: Vec<&Statement> = routine.body.iter().filter(|statement| !of_the_path(statement)).collect();
        // Only literals count in what comes before the path: data of another build would be its own proof.
        compare(file, Scope { data: &[] }, routine.line, &others, &want.steps, findings);
        let early = routine.body.iter().take(2).position(of_the_path);
        if let Some(before) = early {
            let (what, why) = match before {
                0 => ("the robot moves before the digest is compared", want.steps[0].why),
                _ => ("the robot moves before its place is compared", want.steps[1].why),
            };
            findings.add(|| at(file, routine.body[before].line, E1003, "target", what.to_string()).note(why));
        }

        let mut resolved: Vec<Resolved> = Vec::with_capacity(self.source.moves.len());
        for statement in &routine.body {
            match self.resolve(scope, statement) {
                Ok(one) => resolved.extend(one),
                Err(what) => return findings.add(|| at(file, statement.line, E1001, "target", what)),
            }
        }
        then(routine.line, &resolved, findings);
    }

    /// The moves as the text says them. Whatever leaves their speed open is a finding.
    fn trace(&self, found: &[Resolved], findings: &mut Findings) -> Trace {
        let mut trace = Trace::default();
        for one in found {
            match &one.goal {
                ResolvedGoal::Joints(joints) => {
                    let tool = self.replay.tool_of_joints(&joints.map(f64::to_radians));
                    trace.push(&tool, 0.0, Arrival::Joints);
                }
                ResolvedGoal::Place { pose, kind, closes, speed, .. } => {
                    let speed = speed.map_or(f64::NAN, f64::from);
                    if !(speed > 0.0 && speed.is_finite()) {
                        let what = "the move has no speed of its own above 0".to_string();
                        findings.add(|| at(&self.files.source.name, one.line, E1008, "dwell.feed", what));
                    }
                    let arrival = match kind {
                        Kind::Lin | Kind::Slin => Arrival::Stopping,
                        Kind::LinRounded => Arrival::Passing,
                        Kind::BlockSlin | Kind::Spl if *closes => Arrival::Stopping,
                        Kind::BlockSlin | Kind::Spl => Arrival::Passing,
                    };
                    trace.push(&self.replay.tool(pose), speed, arrival);
                }
            }
        }
        trace
    }

    /// The data of the file: where it begins, and perhaps literals.
    fn data(&self, scope: Scope, run: usize, findings: &mut Findings) {
        let file = &self.files.data.name;
        let motion = self.wanted.motion;
        main_program::declarations(self.wanted, file, scope, &["d1", "d2", "d3", "d4"], findings);
        let from = self.wanted.names.own("from");
        let prefix = self.wanted.names.own("").to_ascii_lowercase();
        for one in scope.data {
            if one.name.to_ascii_lowercase().starts_with(&prefix) && !one.name.eq_ignore_ascii_case(&from) {
                let what = format!("`{}` is one of the names that the program keeps for itself", one.name);
                findings.add(|| at(file, one.line, E1001, "target", what));
            }
        }
        let before = run.checked_sub(1).and_then(|run| motion.runs.get(run));
        let joints = before.map_or(motion.home, |run| run.retract_joints);
        let found = main_program::value(file, scope, (&from, "AXIS"), (E1003, "path"), findings);
        if let Some((line, numbers)) = found
            && let Err(what) = same_joints(&numbers, &joints)
        {
            findings.add(|| at(file, line, E1003, "path", format!("`{from}`: {what}")));
        }
    }

    /// What is no move: the comparison of the digest and of the place, before everything else.
    fn before_the_path(&self, name: &str) -> Vec<Step> {
        let m = &self.wanted.names.module;
        let off = match self.wanted.motion.purpose {
            Purpose::Polish => format!("{m}_off ()\n"),
            Purpose::DryRun => String::new(),
        };
        let differs: Vec<String> = digest_words(&self.wanted.digest)
            .iter()
            .enumerate()
            .map(|(k, word)| format!("(d{}<>{word})", k + 1))
            .collect();
        let refuse = |words: &str| format!("MsgNotify(\"{words}\",\"{m}\")\n{off}{m}_stop ()\nENDIF");
        let digest =
            format!("IF {} THEN\n{}", differs.join(" OR "), refuse(&format!("{name} belongs to another build")));
        let place = format!("IF NOT {m}_near({m}_from) THEN\n{}", refuse(&format!("{name}: not where it begins")));
        vec![
            Step::say(E1009, "target", &digest, "a sub-program of another build must never move the robot"),
            Step::say(
                E1003,
                "robot.cell.home_tolerance",
                &place,
                "the way to the first point is checked from the planned place only",
            ),
        ]
    }

    /// The move of a statement, if it is one, or the name that stands for no place.
    fn resolve(&self, scope: Scope, statement: &Statement) -> Result<Option<Resolved>, String> {
        let unknown = |what: &dyn std::fmt::Display| {
            format!("this compiler cannot prove where `{what}` is: it must have all its values written out")
        };
        let line = statement.line;
        match &statement.what {
            What::JointMove(goal) => {
                let n = scope.numbers(goal, components::AXIS).ok_or_else(|| unknown(goal))?;
                let joints = std::array::from_fn(|j| n.get(j).map_or(f64::NAN, |v| f64::from(*v as f32)));
                Ok(Some(Resolved { line, goal: ResolvedGoal::Joints(joints) }))
            }
            What::Move(index) => {
                let Some(one) = self.source.moves.get(*index) else { return Ok(None) };
                let target = match &one.goal {
                    Goal::Written(target) => *target,
                    Goal::Named(goal) => {
                        let n = scope.numbers(goal, components::PLACE).ok_or_else(|| unknown(goal))?;
                        let single = |i: usize| n.get(i).map_or(f32::NAN, |v| *v as f32);
                        Target {
                            position: [0, 1, 2].map(single),
                            angles: [3, 4, 5].map(single),
                            status: single(6),
                            turn: single(7),
                        }
                    }
                };
                let [x, y, z] = target.position.map(|v| f64::from(v) * 1e-3);
                let pose = Transform::from_parts(Translation3::new(x, y, z), rotation(target.angles.map(f64::from)));
                let Target { status, turn, .. } = target;
                let (kind, opens, closes, speed) = (one.kind, one.opens, one.closes, one.speed);
                Ok(Some(Resolved {
                    line,
                    goal: ResolvedGoal::Place { pose, status, turn, kind, opens, closes, speed },
                }))
            }
            _ => Ok(None),
        }
    }

    /// Follows text and plan side by side.
    fn moves(&self, planned: &[Planned], found: &[Resolved], first_line: u32, findings: &mut Findings) {
        let (file, motion) = (&self.files.source.name, self.wanted.motion);
        let mut joints = match planned.first() {
            Some(Planned::Approach(r)) if *r > 0 => motion.runs[*r - 1].retract_joints,
            _ => motion.home,
        };
        let mut way = Way::default();
        let line = |f: usize| found.get(f).or(found.last()).map_or(first_line, |one| one.line);
        align::moves(
            found.len(),
            planned.len(),
            |f, p| self.lies_at(&found[f], planned[p]),
            |met| match met {
                Met::Pair { found: f, wanted: p } => {
                    self.one_move(planned[p], &found[f], &mut joints, &mut way, findings);
                }
                Met::Missing { wanted: p, before } => {
                    way.lost();
                    let what = planned::missing(motion, &planned[p]);
                    findings.add(|| at(file, line(before), E1013, "path", what));
                }
                Met::Extra { found: f, before } => {
                    way.lost();
                    let near = planned.get(before).or(planned.last());
                    let near = near.map_or("the end of the path".to_string(), |near| near.place(motion));
                    let goal = match &found[f.start].goal {
                        ResolvedGoal::Joints(_) => "of the joints".to_string(),
                        ResolvedGoal::Place { pose, .. } => {
                            let t = pose.translation.vector;
                            let [x, y, z] = [t.x, t.y, t.z].map(millimetres);
                            format!("to x = {x}, y = {y}, z = {z} mm")
                        }
                    };
                    let what = match f.len() {
                        1 => format!("a move {goal} is not planned, near {near}"),
                        count => format!("{count} moves are not planned, the first {goal}, near {near}"),
                    };
                    findings.add(|| at(file, line(f.start), E1013, "path", what));
                }
                Met::Swapped { found: f, wanted: p } => {
                    way.lost();
                    let [one, next] = [planned[p], planned[p + 1]];
                    let what = format!("{} and {} are swapped", one.place(motion), next.place(motion));
                    findings.add(|| at(file, line(f), E1013, "path", what));
                    joints = next.joints(motion);
                }
            },
        );
    }

    /// Whether a move ends where the plan's does, orientation apart.
    fn lies_at(&self, found: &Resolved, planned: Planned) -> bool {
        match (&found.goal, planned) {
            (ResolvedGoal::Joints(joints), Planned::Start(r)) => {
                same_joints(joints, &self.wanted.motion.runs[r].approach_joints).is_ok()
            }
            (ResolvedGoal::Place { pose, .. }, Planned::Approach(_) | Planned::Point(_) | Planned::Retract(_)) => {
                self.replay.lies_at(pose, planned)
            }
            _ => false,
        }
    }

    /// Compares one move with its plan, and replays it.
    fn one_move(&self, planned: Planned, one: &Resolved, joints: &mut Joints, way: &mut Way, findings: &mut Findings) {
        let (file, motion) = (&self.files.source.name, self.wanted.motion);
        let mut report = |difference: Difference| {
            let Difference { code, field, what } = difference;
            findings.add(|| at(file, one.line, code, field, format!("{} {what}", planned.place(motion))));
        };
        match (&one.goal, planned) {
            (ResolvedGoal::Joints(found), Planned::Start(r)) => {
                if let Err(what) = same_joints(found, &motion.runs[r].approach_joints) {
                    report(Difference { code: E1006, field: "robot", what: format!("goes elsewhere: {what}") });
                }
                *joints = motion.runs[r].approach_joints;
                way.lost();
            }
            (ResolvedGoal::Joints(_), _) => {
                let what = "is a joint move where a straight move or a curve is planned".to_string();
                report(Difference { code: E1013, field: "path", what });
                *joints = planned.joints(motion);
                way.lost();
            }
            (ResolvedGoal::Place { .. }, Planned::Start(r)) => {
                let what = "is a move to a place where a joint move is planned".to_string();
                report(Difference { code: E1013, field: "path", what });
                *joints = motion.runs[r].approach_joints;
                way.lost();
            }
            (ResolvedGoal::Place { pose, status, turn, kind, opens, closes, speed }, _) => {
                self.kind(planned, (*kind, *opens, *closes), &mut report);
                let good = self.replay.pose(planned, pose, &mut report);
                self.status_turn(planned, *status, *turn, &mut report);
                self.replay.arrives(planned, pose, good, joints, &mut report);
                self.speed(planned, *speed, &mut report);
                way.goes_on(good, *kind, *pose, *joints);
                if *closes {
                    self.between(planned, way, &mut report);
                }
            }
        }
    }

    /// How the move is made, and where the blocks begin and end.
    fn kind(&self, planned: Planned, found: (Kind, bool, bool), report: &mut impl FnMut(Difference)) {
        let spline = matches!(self.wanted.krl.motion, LineMotion::spline(_));
        let straight = if spline { Kind::Slin } else { Kind::Lin };
        let wanted = match planned {
            Planned::Point(i) => {
                let line = line_of(self.wanted.motion, i);
                match (spline, i) {
                    (_, i) if i == line.first => (straight, false, false),
                    (true, i) => {
                        let (opens, closes) = (i == line.first + 1, i == line.last);
                        (if opens || closes { Kind::BlockSlin } else { Kind::Spl }, opens, closes)
                    }
                    (false, i) => (if i == line.last { Kind::Lin } else { Kind::LinRounded }, false, false),
                }
            }
            _ => (straight, false, false),
        };
        if found.0 != wanted.0 {
            let what = format!("is reached by {} where {} is planned", found.0, wanted.0);
            report(Difference { code: E1004, field: "target.motion", what });
        } else if found != wanted {
            let side = |(_, opens, closes): (Kind, bool, bool)| match (opens, closes) {
                (true, true) => "alone in its block",
                (true, false) => "the first of its block",
                (false, true) => "the last of its block",
                (false, false) => "inside its block",
            };
            let what = format!("is {} where it must be {}", side(found), side(wanted));
            report(Difference { code: E1004, field: "target.motion", what });
        }
    }

    fn status_turn(&self, planned: Planned, status: f32, turn: f32, report: &mut impl FnMut(Difference)) {
        let wanted = status_turn(&self.wanted.arm, &planned.joints(self.wanted.motion));
        let same = (status, turn) == (f32::from(wanted.0), f32::from(wanted.1));
        if !same {
            let what = format!("has S {status}, T {turn} where S {}, T {} is planned", wanted.0, wanted.1);
            report(Difference { code: E1006, field: "robot", what });
        }
    }

    fn speed(&self, planned: Planned, found: Option<f32>, report: &mut impl FnMut(Difference)) {
        let wanted = match planned {
            Planned::Point(i) => self.wanted.motion.timed.speed[i],
            Planned::Retract(r) => self.wanted.motion.runs[r].retract_speed,
            _ => self.wanted.cell.travel.speed.0,
        };
        let Some(found) = found.map(f64::from) else {
            let what = format!("has no speed of its own where {wanted} m/s is planned");
            return report(Difference { code: E1008, field: "dwell.feed", what });
        };
        let same = |found: f64| (found - wanted).abs() <= SPEED_SHARE * wanted;
        if same(found) {
            return;
        }
        let what = format!("has the speed {} m/s where {} m/s is planned", shortest(found), shortest(wanted));
        let what = if same(found * 1e-3) { format!("{what}: it is written in mm/s") } else { what };
        report(Difference { code: E1008, field: "dwell.feed", what });
    }

    /// Halfway along the segments of a block that was just closed: on the surface, along its normal, in the same posture.
    fn between(&self, last: Planned, way: &mut Way, report: &mut impl FnMut(Difference)) {
        let Planned::Point(last) = last else { return way.lost() };
        let motion = self.wanted.motion;
        let count = way.poses.len();
        // Whether the whole block was followed, from the point that it begins at.
        let whole = line_of(motion, last).first + count == last + 1;
        if !whole {
            return way.lost();
        }
        let workpiece = &self.wanted.job.workpiece;
        for end in 1..count {
            let Some(pose) = spline::at(&way.poses, end, 0.5) else { continue };
            let tool = self.replay.tool(&pose);
            // The tool's +z points into the glass.
            let axis = tool.rotation * Vector3::z();
            let contact = tool.translation.vector + axis * self.replay.standoff;
            // Beside the part, where blocks begin and end, nothing is polished.
            let on_the_part = workpiece.edge.distance(contact.x, contact.y) >= 0.0;
            let mut say = |what: String| {
                let [from, to] = [end - 1, end].map(|k| Planned::Point(last + 1 + k - count).place(motion));
                let what = format!("ends a block that {what}, halfway from {from} to {to}");
                let (code, field) = (E1015, "path.point_step");
                report(Difference { code, field, what });
            };
            if let (true, Some(surface)) = (on_the_part, self.wanted.surface.at(contact.x, contact.y)) {
                let normal = Vector3::from(surface.normal());
                let off = ((contact.z - surface.sag) * normal.z).abs();
                let lean = angle_between_directions(&axis, &-normal);
                // Written so that what is no number differs.
                let on_surface = off <= BETWEEN_TOLERANCE && lean <= LEAN_TOLERANCE;
                if !on_surface {
                    let off = off * 1e6;
                    say(format!("leaves the surface by {off:.2} um and the normal by {:.4} deg", lean.to_degrees()));
                    continue;
                }
            }
            let (before, after) = (way.joints[end - 1], way.joints[end]);
            let middle = self.replay.solve(&pose, &before);
            let follows = middle.is_some_and(|middle| {
                (0..6).all(|j| (middle[j] - 0.5 * (before[j] + after[j])).abs() <= CONFIGURATION_TOLERANCE)
            });
            if !follows {
                say("takes the arm out of its posture".into());
            }
        }
        way.lost();
    }
}

/// The poses of a block and the joints at them, the point before it first.
#[derive(Default)]
struct Way {
    poses: Vec<Transform>,
    joints: Vec<Joints>,
}

impl Way {
    /// One more pose, where the arm has these joints. One that is wrong, and was reported, ends the way; one
    /// outside a block may begin the next.
    fn goes_on(&mut self, good: bool, kind: Kind, pose: Transform, joints: Joints) {
        if !good || !matches!(kind, Kind::BlockSlin | Kind::Spl) {
            self.lost();
        }
        if good {
            self.poses.push(pose);
            self.joints.push(joints);
        }
    }

    fn lost(&mut self) {
        self.poses.clear();
        self.joints.clear();
    }
}
