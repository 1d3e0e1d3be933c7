//! Sub-programs: the path itself, one segment a point.
//!
//! In: the setup and one run, or the texts of a part's runs. Out: bytes. This is where nearly all bytes of a program come
//! from, so numbers are written straight into the buffer.
//!
//! A line of the path is at rest at both ends. As a spline it is one `SPLINE` block: the robot stands at the first point;
//! the first and the last segment are straight (`SLIN`), all between them one curve (`SPL`), each with the speed of its
//! own. As linear moves every point but the line's ends is rounded (`C_DIS`), and the speed is set before each move: an
//! assignment to `$VEL.CP` does not stop the advance run, as an output or a wait would.

use super::Setup;
use super::writing::{axis, push_speed, push_target};
use crate::diagnostics::Problem;
use crate::diagnostics::codes::{E0904, E0908, E0911};
use crate::job::LineMotion;
use crate::motion::configuration::status_turn;
use crate::motion::{ToolPose, Travel};
use crate::target::ProgramFile;
use crate::target::number::millimetres;
use crate::target::text::{LINE_LENGTH, Text};

/// Lines that a file has around its runs, as an upper bound: header, comments, the checks before the first move.
pub const FRAME_LINES: usize = 32;

/// Lines of one run that are no points: comment, approach, joint move, retract, each with its speed.
pub const RUN_LINES: usize = 10;

/// Characters of a line of the path with its end, at most: every number as long as it can be.
pub const SEGMENT_LENGTH: usize = 160;

/// Two targets nearer to one another than this, mm, and turned by less than this, are one to the controller, which
/// cannot plan a segment of no length (KSS message 3171).
const SAME_PLACE: f64 = 1e-3;

/// How a move is made.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Move {
    /// Straight, with a stop at its end.
    Straight,
    /// Straight inside a block.
    BlockStraight,
    /// Part of a block's curve.
    Curve,
    /// Straight, rounded at its end.
    Rounded,
}

/// The text of one run: to its approach point, down, the lines, up again. And how many lines of text it has.
pub fn run(setup: &Setup, index: usize) -> Result<(Vec<u8>, usize), Problem> {
    let motion = setup.motion;
    let run = &motion.runs[index];
    let travel = setup.cell.travel.speed.0;
    let bad = |what: &str| {
        Problem::error(E0904, "path", format!("run {}: {what} cannot be written as a KRL number", index + 1))
    };
    let mut text = Text::new(";", (run.points.len() + 16) * 128);
    text.comment(
        0,
        &format!(
            "run {} of {}: lines {} to {}, points {} to {}",
            index + 1,
            motion.runs.len(),
            run.lines.start + 1,
            run.lines.end,
            run.points.start + 1,
            run.points.end
        ),
    );
    let mut out = text.bytes;
    let [approach_configuration, retract_configuration] =
        [run.approach_joints, run.retract_joints].map(|joints| status_turn(&setup.arm, &joints));
    let spline = matches!(setup.krl.motion, LineMotion::spline(_));
    // Straight from the run before, the arm arrives in the planned joints: the joint move behind it only makes its
    // configuration certain and has no way to go.
    if run.travel == Travel::Straight {
        move_to(setup, &mut out, Move::Straight, run.approach, approach_configuration, travel)
            .ok_or_else(|| bad("the approach point"))?;
    }
    let joints = axis(run.approach_joints).ok_or_else(|| bad("a joint of the approach point"))?;
    out.extend_from_slice(format!("PTP {joints}\r\n").as_bytes());
    for (l, path_line) in run.lines.clone().zip(&motion.timed.path.lines[run.lines.clone()]) {
        let (first, last) = (path_line.points.start, path_line.points.end.saturating_sub(1));
        check_block(setup, l, last - first, spline)?;
        for i in path_line.points.clone() {
            if i > run.points.start {
                apart(setup, i)?;
            }
            let how = match (spline, i) {
                (_, i) if i == first => Move::Straight,
                (true, i) if i == first + 1 || i == last => Move::BlockStraight,
                (true, _) => Move::Curve,
                (false, i) if i == last => Move::Straight,
                (false, _) => Move::Rounded,
            };
            if spline && i == first + 1 {
                out.extend_from_slice(b"SPLINE\r\n");
            }
            let pose = ToolPose { position: motion.position[i], quaternion: motion.quaternion[i] };
            let configuration = status_turn(&setup.arm, &motion.joints[i]);
            move_to(setup, &mut out, how, pose, configuration, motion.timed.speed[i])
                .ok_or_else(|| point_problem(setup, i))?;
        }
        if spline && last > first {
            out.extend_from_slice(b"ENDSPLINE\r\n");
        }
    }
    move_to(setup, &mut out, Move::Straight, run.retract, retract_configuration, run.retract_speed)
        .ok_or_else(|| bad("the retract point"))?;
    out.shrink_to_fit();
    let lines = out.iter().filter(|byte| **byte == b'\n').count();
    Ok((out, lines))
}

/// Writes one move to a target at a speed. `None` where a number cannot be written, or the speed would be written as 0.
fn move_to(
    setup: &Setup,
    out: &mut Vec<u8>,
    how: Move,
    pose: ToolPose,
    configuration: (u8, u8),
    speed: f64,
) -> Option<()> {
    let digits = setup.digits;
    if matches!(setup.krl.motion, LineMotion::linear(_)) {
        out.extend_from_slice(b"$VEL.CP=");
        push_speed(out, speed, digits)?;
        out.extend_from_slice(b"\r\nLIN ");
        push_target(out, pose, configuration, digits)?;
        out.extend_from_slice(if how == Move::Rounded { b" C_DIS\r\n" } else { b"\r\n" });
        return Some(());
    }
    out.extend_from_slice(match how {
        Move::BlockStraight => b"  SLIN ",
        Move::Curve => b"  SPL ",
        Move::Straight | Move::Rounded => b"SLIN ",
    });
    push_target(out, pose, configuration, digits)?;
    out.extend_from_slice(b" WITH $VEL.CP=");
    push_speed(out, speed, digits)?;
    out.extend_from_slice(b"\r\n");
    Some(())
}

/// Whether line `line` (from 0) of so many segments goes into one block.
fn check_block(setup: &Setup, line: usize, segments: usize, spline: bool) -> Result<(), Problem> {
    let most = usize::try_from(setup.krl.controller.block_segments).unwrap_or(0);
    if !spline || segments <= most {
        return Ok(());
    }
    let what = format!("line {} of the path has {segments} segments, and one `SPLINE` block takes {most}", line + 1);
    Err(Problem::error(E0908, "path.point_step", what)
        .note("the robot stops between blocks: a line is broken only where the path says how the tool lands there")
        .help(
            "say `landing` in `path`, take a longer `point_step`, or raise `block_segments` of the controller if it was seen to plan longer blocks",
        ))
}

/// Whether point `i` is another place than the one before it, as they are written.
fn apart(setup: &Setup, i: usize) -> Result<(), Problem> {
    let motion = setup.motion;
    let [a, b] = [i - 1, i].map(|i| millimetres(motion.position[i]));
    let square: f64 = (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).fold(0.0, |sum, square| sum + square);
    if square >= SAME_PLACE * SAME_PLACE {
        return Ok(());
    }
    let [x, y, _] = millimetres(motion.timed.path.points.position(i));
    let what = format!("points {} and {} (x = {x:.3}, y = {y:.3} mm) lie {:.6} mm apart", i, i + 1, square.sqrt());
    Err(Problem::error(E0911, "path.point_step", what)
        .note(format!("the controller cannot plan a segment of no length; it takes points {SAME_PLACE} mm apart"))
        .help("take a longer `point_step`"))
}

/// What is said of a point whose move cannot be written.
fn point_problem(setup: &Setup, i: usize) -> Problem {
    let motion = setup.motion;
    let [x, y, _] = millimetres(motion.timed.path.points.position(i));
    let place = format!("point {} of {} (x = {x:.3}, y = {y:.3} mm)", i + 1, motion.position.len());
    let pose = ToolPose { position: motion.position[i], quaternion: motion.quaternion[i] };
    if push_target(&mut Vec::new(), pose, (0, 0), setup.digits).is_none() {
        return Problem::error(E0904, "path", format!("the tool pose at {place} cannot be written as KRL numbers"));
    }
    let speed = motion.timed.speed[i];
    Problem::error(E0904, "dwell.feed", format!("the speed {speed} m/s at {place} cannot be written"))
}

/// The two files of one part of the path, from the texts of its runs. It moves only in its own build, and only from where
/// the plan has the robot: after a stop it may stand anywhere.
pub fn files(setup: &Setup, index: usize, runs: impl Iterator<Item = Vec<u8>>) -> Result<[ProgramFile; 2], Problem> {
    let names = &setup.names;
    let part = &setup.parts[index];
    let name = names.sub_program(index);
    let runs: Vec<Vec<u8>> = runs.collect();
    let mut text = Text::new(";", FRAME_LINES * LINE_LENGTH + runs.iter().map(Vec::len).sum::<usize>());
    super::heading(&mut text);
    text.line(0, &format!("DEF {name} (d1:IN,d2:IN,d3:IN,d4:IN)"));
    text.line(0, "INT d1,d2,d3,d4");
    text.comment(
        0,
        &format!(
            "part {} of {}, points {} to {} of {}; called by {}. Generated: edit the job, not this.",
            index + 1,
            setup.parts.len(),
            part.points.start + 1,
            part.points.end,
            setup.motion.position.len(),
            names.module
        ),
    );
    let refuse = |text: &mut Text, message: &str| {
        text.line(0, &format!("MsgNotify(\"{message}\",\"{}\")", names.module));
        if setup.switches_process() {
            text.line(0, &format!("{} ()", names.own("off")));
        }
        text.line(0, &format!("{} ()", names.own("stop")));
        text.line(0, "ENDIF");
    };
    text.comment(0, "A part of another build never moves the robot.");
    let differs: Vec<String> = super::digest_words(&setup.digest)
        .iter()
        .enumerate()
        .map(|(k, word)| format!("(d{}<>{word})", k + 1))
        .collect();
    text.line(0, &format!("IF {} THEN", differs.join(" OR ")));
    refuse(&mut text, &format!("{name} belongs to another build"));
    text.comment(0, "The way to the first point is checked from here only.");
    text.line(0, &format!("IF NOT {}({}) THEN", names.own("near"), names.own("from")));
    refuse(&mut text, &format!("{name}: not where it begins"));
    for run in runs {
        text.bytes.extend_from_slice(&run);
    }
    text.line(0, "END");
    let source = ProgramFile { name: format!("{name}.src"), points: part.points.len(), bytes: text.bytes };
    // The first part begins at home, every other where the run before it ended.
    let before = part.runs.start.checked_sub(1).and_then(|run| setup.motion.runs.get(run));
    let joints = before.map_or(setup.motion.home, |run| run.retract_joints);
    let joints = axis(joints)
        .ok_or_else(|| Problem::error(E0904, "path", format!("a joint where `{name}` begins cannot be written")))?;
    let mut text = Text::new(";", 0);
    super::heading(&mut text);
    text.line(0, &format!("DEFDAT {name}"));
    text.line(0, &format!("DECL AXIS {}={joints}", names.own("from")));
    text.line(0, "ENDDAT");
    Ok([source, ProgramFile { name: format!("{name}.dat"), points: 0, bytes: text.bytes }])
}
