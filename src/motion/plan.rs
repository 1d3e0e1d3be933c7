//! The plan: a path's tool poses, runs, configurations and joints, every check passed.
//!
//! In: the timed path, the robot, the [`Request`]. Out: [`Checked`]`<Motion>`, or the first thing that makes it
//! impossible.

use super::arm::{Branch, Joints, Solution};
use super::cell::Station;
use super::contact::{orientation, raised};
use super::fault::{Fault, Place, Stage, in_millimetres};
use super::follow::{Broken, Follower, Poses, Seen};
use super::joint_move::{Glass, TooNear};
use super::runs::{Span, split};
use super::{Checked, Motion, MotionFigures, Purpose, Request, Run, ToolPose, Travel};
use super::{configuration, frames, joint_move, time};
use crate::diagnostics::{Problem, codes};
use crate::dwell::{TimedPath, written};
use crate::job;
use crate::path::Link;
use crate::tool::Azimuth;
use rayon::prelude::*;

/// Points handled by one task; constant, so that errors are found in the same order with any number of threads.
const CHUNK: usize = 4096;

/// How far the length of a normal may lie from 1. Normals are computed in double precision; anything more is a mistake.
const NORMAL_TOLERANCE: f64 = 1e-9;

/// No part is a kilometre wide: a coordinate beyond is a mistake in its unit, and sampling the way there would never
/// end.
const FARTHEST: f64 = 1e3;

/// Plans the motion of one program: places the tool on every contact point, splits the lines into runs, finds for each
/// run the configuration nearest to home in which all of it passes every check, and checks the ways between the runs.
///
/// The tool centre point stands `standoff` from the surface along the normal, for a dry run `travel.height` higher.
/// Approach and retract poses lie `travel.height` above the run's first and last tool pose.
pub fn plan(timed: TimedPath, robot: &job::Robot, request: &Request) -> Result<Checked<Motion>, Problem> {
    let station = Station::new(robot)?;
    check_path(&timed, request)?;
    check_landing(&timed, &station)?;
    let spans = split(&timed.path.lines, request.room)?;
    let timed = slowed(timed, &spans, &station, request)?;
    let lift = match request.purpose {
        Purpose::Polish => 0.0,
        Purpose::DryRun => station.travel_height,
    };
    let (position, quaternion) = tool_poses(&timed, request.standoff + lift, request.azimuth)?;
    let retract_speed = match (&timed.path.landing, request.purpose) {
        (Some(landing), Purpose::Polish) => written(landing.speed.0, request.speed_steps),
        _ => station.travel_speed,
    };
    let planner = Planner {
        retract_speed,
        follower: Follower::new(&station),
        glass: Glass::new(&timed.path.points, request.part, request.tool_ball, station.travel_height),
        station: &station,
        timed: &timed,
        poses: Poses { position: &position, quaternion: &quaternion, speed: &timed.speed },
    };
    for (i, safe) in station.safe_poses.iter().enumerate() {
        joint_move::check(&station, &planner.glass, safe, &station.home)
            .map_err(|near| too_near(near, &format!("robot.cell.safe_poses.{i}"), "from a safe pose to `home`"))?;
    }
    let mut joints = vec![[0.0; 6]; position.len()];
    let mut seen = Seen::NOTHING;
    let mut runs: Vec<Run> = Vec::with_capacity(spans.len());
    for span in &spans {
        let run = planner.run(span, runs.last(), &mut joints[span.points.clone()], &mut seen)?;
        runs.push(run);
    }
    if let Some(last) = runs.last() {
        joint_move::check(&station, &planner.glass, &last.retract_joints, &station.home)
            .map_err(|near| too_near(near, "robot.cell.home", "from the last retract to `home`"))?;
    }
    let confdata: Vec<[i32; 4]> =
        joints.par_iter().with_min_len(CHUNK).map(|joints| configuration::confdata(&station.arm, joints)).collect();
    let figures = planner.figures(&runs, &joints, &seen, request);
    let home = station.home;
    let frames = station.frames.clone();
    let purpose = request.purpose;
    Ok(Checked(Motion { purpose, timed, frames, runs, position, quaternion, joints, confdata, home, figures }))
}

/// Refuses a path that cannot be travelled at all.
fn check_path(timed: &TimedPath, request: &Request) -> Result<(), Problem> {
    let bad = |field: &str, message: String| Err(Problem::error(codes::E0804, field, message));
    let points = &timed.path.points;
    let count = points.len();
    if count == 0 || timed.path.lines.is_empty() {
        return bad("path", "the path has no points".into());
    }
    let lengths = [points.y.len(), points.z.len(), points.normal_x.len(), points.normal_y.len(), points.normal_z.len()];
    if lengths.iter().any(|length| *length != count) || timed.speed.len() != count {
        return bad("path", "the path's coordinates, normals and speeds differ in number".into());
    }
    let mut next = 0;
    for (i, line) in timed.path.lines.iter().enumerate() {
        if line.points.start != next || line.points.end <= line.points.start {
            return bad("path", format!("line {} does not go on where the line before ends", i + 1));
        }
        next = line.points.end;
    }
    if next != count {
        return bad("path", "the path has points that belong to no line".into());
    }
    if !(request.acceleration > 0.0 && request.acceleration.is_finite()) {
        return bad("dwell.acceleration", "the path's acceleration must be above 0 mm/s^2".into());
    }
    if !(request.standoff.is_finite()
        && request.azimuth.is_finite()
        && request.tool_ball.radius >= 0.0
        && request.tool_ball.below.is_finite())
    {
        return bad("tool", "the tool's stand-off, azimuth or radius is not a finite number".into());
    }
    for i in 0..count {
        let (point, normal) = (points.position(i), points.normal(i));
        let square: f64 = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
        let fault = if point.iter().any(|x| !x.is_finite()) {
            "has a coordinate that is not finite"
        } else if point.iter().any(|x| x.abs() > FARTHEST) {
            "lies more than 1 km from the part's origin"
        } else if square.is_nan() || (square - 1.0).abs() > 2.0 * NORMAL_TOLERANCE {
            "has a normal that is not of unit length"
        } else if !(timed.speed[i] > 0.0 && timed.speed[i].is_finite()) {
            "has a speed that is not above 0 mm/s"
        } else if i > 0 && point == points.position(i - 1) && !starts_lifted(timed, i) {
            "lies in the same place as the point before"
        } else {
            continue;
        };
        let (at, line) = (in_millimetres(point), line_of(timed, i) + 1);
        return bad("path", format!("the point at {at} (line {line}) {fault}"));
    }
    Ok(())
}

/// Whether point `i` is the first after a lift: it may lie where the tool went up.
fn starts_lifted(timed: &TimedPath, i: usize) -> bool {
    let lines = &timed.path.lines;
    let line = line_of(timed, i);
    lines[line].points.start == i && line > 0 && lines[line - 1].link == Link::Lifted
}

/// Whether the cell can land as the dwell was planned with.
fn check_landing(timed: &TimedPath, station: &Station) -> Result<(), Problem> {
    let Some(landing) = &timed.path.landing else { return Ok(()) };
    if landing.speed.0 > station.travel_speed {
        let message = format!(
            "the tool is to land at {:.3} mm/s, and the cell moves it at {:.3} mm/s at most when it is lifted",
            landing.speed.0 * 1e3,
            station.travel_speed * 1e3
        );
        return Err(Problem::error(codes::E0690, "path.landing.speed", message)
            .note("a slower landing removes more than the dwell was solved with")
            .help(format!("make `speed` at most {:.3} mm/s", station.travel_speed * 1e3)));
    }
    if landing.reach.0 >= station.travel_height {
        let message = format!(
            "the tool removes up to {:.3} mm above its place, and the cell lifts it by {:.3} mm only",
            landing.reach.0 * 1e3,
            station.travel_height * 1e3
        );
        return Err(Problem::error(codes::E0690, "path.landing.reach", message)
            .help("raise `robot.cell.travel.height` above the `reach` of the landing"));
    }
    Ok(())
}

/// The speeds as they are driven: at most the travel speed, as the target can write it, on the way down to the first
/// point of a run; in a dry run everywhere.
fn slowed(mut timed: TimedPath, spans: &[Span], station: &Station, request: &Request) -> Result<TimedPath, Problem> {
    let steps = request.speed_steps;
    let most = steps.down(station.travel_speed);
    if !(most > 0.0 && most.is_finite()) {
        let message = format!(
            "the travel speed of {:.6} mm/s is less than the smallest speed that the target writes, {:.6} mm/s",
            station.travel_speed * 1e3,
            steps.step(station.travel_speed) * 1e3
        );
        return Err(Problem::error(codes::E0803, "robot.cell.travel.speed", message));
    }
    match request.purpose {
        Purpose::Polish => {
            for span in spans {
                let down = &mut timed.speed[span.points.start];
                *down = down.min(most);
            }
        }
        Purpose::DryRun => timed.speed.iter_mut().for_each(|speed| *speed = speed.min(most)),
    }
    Ok(timed)
}

/// The tool poses in the object frame, `distance` metres from the contact points along their normals; consecutive
/// quaternions on the same side.
#[allow(clippy::type_complexity, reason = "two flat arrays of one length")]
fn tool_poses(timed: &TimedPath, distance: f64, azimuth: f64) -> Result<(Vec<[f64; 3]>, Vec<[f64; 4]>), Problem> {
    let points = &timed.path.points;
    let azimuth = Azimuth::new(azimuth);
    let mut position = vec![[0.0; 3]; points.len()];
    let mut quaternion = vec![[0.0; 4]; points.len()];
    let found: Vec<Result<(), (usize, f64)>> = position
        .par_chunks_mut(CHUNK)
        .zip(quaternion.par_chunks_mut(CHUNK))
        .enumerate()
        .map(|(chunk, (position, quaternion))| {
            for (k, (position, quaternion)) in position.iter_mut().zip(quaternion).enumerate() {
                let i = chunk * CHUNK + k;
                let normal = points.normal(i);
                *position = raised(points.position(i), normal, distance);
                *quaternion = frames::wxyz(&orientation(normal, azimuth).map_err(|sine| (i, sine))?);
            }
            Ok(())
        })
        .collect();
    if let Some(Err((i, sine))) = found.into_iter().find(Result::is_err) {
        let message = format!(
            "at {} (line {}) the surface's normal is {:.2} deg from the direction of `azimuth`, 5.74 deg are needed",
            in_millimetres(points.position(i)),
            line_of(timed, i) + 1,
            libm::asin(sine.min(1.0)).to_degrees()
        );
        return Err(
            Problem::error(codes::E0808, "tool.azimuth", message).help("choose an azimuth across the slope there")
        );
    }
    for i in 1..quaternion.len() {
        let (a, b) = (quaternion[i - 1], quaternion[i]);
        if a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0.0 {
            quaternion[i] = b.map(|x| -x);
        }
    }
    Ok((position, quaternion))
}

/// The line (from 0) that point `i` belongs to.
fn line_of(timed: &TimedPath, i: usize) -> usize {
    timed.path.lines.partition_point(|line| line.points.end <= i)
}

/// The refusal of a joint move.
fn too_near(near: TooNear, field: &str, what: &str) -> Problem {
    let place = in_millimetres(near.point);
    let message = if near.distance < 0.0 {
        format!("the joint move {what} would bring the tool into the part, with its centre point at {place}")
    } else {
        format!(
            "the joint move {what} would bring the tool within {:.1} mm of the part, with its centre point at {place}; \
             {:.1} mm above it are kept clear",
            near.distance * 1e3,
            near.least * 1e3
        )
    };
    Problem::error(codes::E0805, field, message)
        .note("checked are a ball in place of the tool and the part; nothing else of tool, arm and cell is known")
        .help("choose another pose, from which the tool comes from above, or a larger `travel.height`")
}

/// Where a run begins: joints above its first point, and how the tool gets there.
#[derive(Clone, Copy)]
struct Start {
    branch: Branch,
    joints: Joints,
    travel: Travel,
}

struct Planner<'a> {
    retract_speed: f64,
    station: &'a Station,
    timed: &'a TimedPath,
    follower: Follower<'a>,
    glass: Glass,
    poses: Poses<'a>,
}

impl Planner<'_> {
    /// Plans one run. The first start that passes is taken: straight on from the run before, then the solutions above
    /// the first point in the configuration of the run before, then all others, each nearest to home first (by the time
    /// of the joint move).
    fn run(&self, span: &Span, before: Option<&Run>, joints: &mut [Joints], seen: &mut Seen) -> Result<Run, Problem> {
        let approach = self.lifted(span.points.start);
        let mut first_problem = None;
        if let Some(before) = before {
            match self.straight_on(span, before, &approach) {
                Ok((start, on_the_way)) => match self.try_start(span, &approach, start, joints) {
                    Ok((run, met)) => {
                        seen.join(&on_the_way);
                        seen.join(&met);
                        return Ok(run);
                    }
                    Err(problem) => first_problem = Some(problem),
                },
                Err(problem) => first_problem = Some(problem),
            }
        }
        let from = before.map_or(self.station.home, |before| before.retract_joints);
        let starts = self.starts(&approach, before.map(|before| before.branch));
        let tried_starts = starts.len();
        for start in starts {
            let tried = joint_move::check(self.station, &self.glass, &from, &start.joints)
                .map_err(|near| {
                    too_near(near, "robot.cell.home", &format!("to the approach of line {}", span.lines.start + 1))
                })
                .and_then(|()| self.try_start(span, &approach, start, joints));
            match tried {
                Ok((run, met)) => {
                    seen.join(&met);
                    return Ok(run);
                }
                Err(problem) => first_problem = first_problem.or(Some(problem)),
            }
        }
        let problem = first_problem.unwrap_or_else(|| self.no_start(span, &approach));
        Err(match tried_starts {
            0 | 1 => problem,
            count => problem.note(format!(
                "{count} configurations and turns were tried above the start of line {}; this is about the first choice",
                span.lines.start + 1
            )),
        })
    }

    /// The tool pose lifted above point `i`, in the object frame.
    fn lifted(&self, i: usize) -> ToolPose {
        let normal = self.timed.path.points.normal(i);
        let position = raised(self.poses.position[i], normal, self.station.travel_height);
        ToolPose { position, quaternion: self.poses.quaternion[i] }
    }

    /// Goes straight on from the run before, lifted.
    fn straight_on(&self, span: &Span, before: &Run, approach: &ToolPose) -> Result<(Start, Seen), Problem> {
        // Where a line was broken the tool comes down where it went up: there is no way to go.
        if before.retract == *approach {
            let start = Start { branch: before.branch, joints: before.retract_joints, travel: Travel::Joint };
            return Ok((start, Seen::NOTHING));
        }
        let (from, to) = (before.retract.transform(), approach.transform());
        joint_move::check_straight(&self.glass, &from, &to).map_err(|near| {
            too_near(near, "robot.cell.travel.height", &format!("to the approach of line {}", span.lines.start + 1))
        })?;
        let mut seen = Seen::NOTHING;
        let (branch, joints) = (before.branch, &before.retract_joints);
        let joints = self
            .follower
            .straight(branch, (&from, joints), &to, self.station.travel_speed, &mut seen)
            .map_err(|broken| {
                let ends = [before.points.end - 1, span.points.start].map(|i| self.timed.path.points.position(i));
                self.problem(broken, ends, span.lines.start, Stage::Travel)
            })?;
        Ok((Start { branch, joints, travel: Travel::Straight }, seen))
    }

    /// All solutions at the approach pose inside the ranges with margin, in the order in which they are tried.
    fn starts(&self, approach: &ToolPose, prefer: Option<Branch>) -> Vec<Start> {
        let flange = self.follower.flange(&approach.transform());
        let (home, arm) = (self.station.home, &self.station.arm);
        let mut starts: Vec<(bool, f64, f64, Start)> = arm
            .inverse_all_turns(&flange)
            .filter(|solution| arm.within(&solution.joints, self.station.range_margin))
            .map(|Solution { branch, joints, .. }| {
                let sum = (0..6).map(|i| (joints[i] - home[i]).abs()).fold(0.0, |sum, x| sum + x);
                let other = prefer.is_some_and(|prefer| prefer != branch);
                let start = Start { branch, joints, travel: Travel::Joint };
                (other, joint_move::seconds(self.station, &home, &joints), sum, start)
            })
            .collect();
        // The sort is stable: what is equally near stays in the order of branches and turns.
        starts.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2)));
        starts.into_iter().map(|(.., start)| start).collect()
    }

    /// Follows a whole run from one start.
    fn try_start(
        &self,
        span: &Span,
        approach: &ToolPose,
        start: Start,
        joints: &mut [Joints],
    ) -> Result<(Run, Seen), Problem> {
        let Start { branch, joints: approach_joints, travel } = start;
        let points = &self.timed.path.points;
        let mut seen = Seen::NOTHING;
        let (first, last) = (span.points.start, span.points.end - 1);
        let down = self
            .follower
            .straight(
                branch,
                (&approach.transform(), &approach_joints),
                &self.poses.at(first),
                self.poses.speed[first],
                &mut seen,
            )
            .map_err(|broken| self.problem(broken, [points.position(first); 2], span.lines.start, Stage::Approach))?;
        let poses = Poses {
            position: &self.poses.position[span.points.clone()],
            quaternion: &self.poses.quaternion[span.points.clone()],
            speed: &self.poses.speed[span.points.clone()],
        };
        let met = self.follower.chain(branch, &down, poses, joints).map_err(|at| {
            let i = first + at.point;
            let line = line_of(self.timed, i);
            let stage = if self.timed.path.lines[line].points.start == i { Stage::Link } else { Stage::Line };
            let ends = [i.saturating_sub(1).max(first), i].map(|i| points.position(i));
            self.problem(at.broken, ends, line, stage)
        })?;
        seen.join(&met);
        let end = joints.last().copied().unwrap_or(down);
        let retract = self.lifted(last);
        let retract_joints = self
            .follower
            .straight(branch, (&self.poses.at(last), &end), &retract.transform(), self.retract_speed, &mut seen)
            .map_err(|broken| self.problem(broken, [points.position(last); 2], span.lines.end - 1, Stage::Retract))?;
        let (lines, points, approach) = (span.lines.clone(), span.points.clone(), *approach);
        let retract_speed = self.retract_speed;
        let run =
            Run { lines, points, travel, branch, approach, approach_joints, retract, retract_joints, retract_speed };
        Ok((run, seen))
    }

    /// Why the arm has no solution above the first point of a run.
    fn no_start(&self, span: &Span, approach: &ToolPose) -> Problem {
        let (arm, home) = (&self.station.arm, &self.station.home);
        let flange = self.follower.flange(&approach.transform());
        // Of all postures with their turns nearest to home, the one that is outside its ranges by the least.
        let nearest = Branch::ALL
            .iter()
            .filter_map(|branch| arm.inverse_in_branch(&flange, *branch, home))
            .map(|solution| (arm.least_margin(&solution.joints).0, solution.joints))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let fault = match nearest {
            Some((_, joints)) => {
                let (_, joint) = arm.least_margin(&joints);
                Fault::Range { joint, angle: joints[joint] }
            }
            None => Fault::Reach(arm.reach(&flange, false)),
        };
        let point = self.timed.path.points.position(span.points.start);
        self.problem(Broken { fault, share: 0.0 }, [point; 2], span.lines.start, Stage::Approach)
    }

    /// The refusal of a move between two contact points.
    fn problem(&self, broken: Broken, [from, to]: [[f64; 3]; 2], line: usize, stage: Stage) -> Problem {
        let point = [0, 1, 2].map(|i| from[i] + (to[i] - from[i]) * broken.share);
        broken.fault.problem(&Place { point, line, stage }, self.station)
    }

    fn figures(&self, runs: &[Run], joints: &[Joints], seen: &Seen, request: &Request) -> MotionFigures {
        let arm = &self.station.arm;
        let lines = &self.timed.path.lines;
        let step = |i: usize| (0..6).map(|j| (joints[i][j] - joints[i - 1][j]).abs()).fold(0.0, f64::max);
        // The largest of all does not depend on the order in which they are compared.
        let largest_joint_step = lines
            .par_iter()
            .map(|line| (line.points.start + 1..line.points.end).map(step).fold(0.0, f64::max))
            .reduce(|| 0.0, f64::max);
        MotionFigures {
            time: self.seconds(runs, request),
            joint_margin: arm.least_margin(&seen.lower).0.min(arm.least_margin(&seen.upper).0),
            largest_joint_step,
            wrist_margin: seen.wrist,
            joint_speed_share: seen.speed_share,
            points_near_quarter: joints.par_iter().filter(|joints| configuration::near_quarter(joints)).count(),
        }
    }

    /// Seconds from home to home.
    fn seconds(&self, runs: &[Run], request: &Request) -> f64 {
        let (position, speed) = (self.poses.position, self.poses.speed);
        let travel_speed = self.station.travel_speed;
        let stopping = |length: f64, speed: f64| time::straight(length, 0.0, 0.0, speed, request.acceleration);
        let lines: Vec<f64> = self
            .timed
            .path
            .lines
            .par_iter()
            .map(|line| {
                let moves: Vec<(f64, f64)> = (line.points.start + 1..line.points.end)
                    .map(|i| (distance(&position[i - 1], &position[i]), speed[i]))
                    .collect();
                time::chain(&moves, request.acceleration)
            })
            .collect();
        let mut seconds = lines.iter().fold(0.0, |sum, t| sum + t);
        let mut from = (self.station.home, None);
        for run in runs {
            seconds += match (run.travel, from.1) {
                (Travel::Straight, Some(retract)) => stopping(distance(&retract, &run.approach.position), travel_speed),
                _ => joint_move::seconds(self.station, &from.0, &run.approach_joints),
            };
            seconds += stopping(self.station.travel_height, speed[run.points.start]);
            for line in run.lines.clone().skip(1) {
                let i = self.timed.path.lines[line].points.start;
                seconds += stopping(distance(&position[i - 1], &position[i]), speed[i]);
            }
            seconds += stopping(self.station.travel_height, run.retract_speed);
            from = (run.retract_joints, Some(run.retract.position));
        }
        seconds + joint_move::seconds(self.station, &from.0, &self.station.home)
    }
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let square = |i: usize| (a[i] - b[i]) * (a[i] - b[i]);
    (square(0) + square(1) + square(2)).sqrt()
}
