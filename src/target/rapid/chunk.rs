//! Chunk modules: the path itself, one instruction a point.
//!
//! In: the setup and one run, or the texts of a chunk's runs. Out: bytes. This is where nearly all bytes of a program
//! come from, so the constant parts of a line are prepared once and numbers are written straight into the buffer.

use super::Setup;
use super::writing::{NO_EXTERNAL_AXES, push_jointtarget, push_list, push_pose};
use crate::diagnostics::Problem;
use crate::diagnostics::codes::E0904;
use crate::job::Zone;
use crate::motion::configuration::confdata;
use crate::motion::{ToolPose, Travel};
use crate::target::ProgramFile;
use crate::target::number::{degrees, millimetres, push_fixed, push_scaled, scaled, unit_quaternion};
use crate::target::text::{LINE_LENGTH, Text};

/// Bytes that a module has around its runs, as an upper bound: comments and the checks before the first move, some of
/// which grow with the names.
pub const FRAME_BYTES: usize = 24 * LINE_LENGTH;

/// Characters that a move of one line has at most beside the names of tool and work object.
pub const MOVE_LENGTH: usize = 182;

/// What stands where a move is broken into two lines.
pub const WRAP: &str = "\r\n            ";

/// How a zone is written.
pub fn zone_name(zone: Zone) -> &'static str {
    match zone {
        Zone::fine => "fine",
        Zone::z0 => "z0",
        Zone::z1 => "z1",
        Zone::z5 => "z5",
    }
}

/// The parts of a move that do not change along a run.
struct Constant {
    /// What stands between the robtarget's configuration and the speed.
    after_target: Vec<u8>,
    /// What stands behind the speed: orientation speed and those of the external axes.
    after_speed: Vec<u8>,
    /// Tool and work object, to the line's end.
    tail: Vec<u8>,
}

/// The text of one run: to its approach point, down, the lines, up again.
pub fn run(setup: &Setup, index: usize) -> Result<Vec<u8>, Problem> {
    let motion = setup.motion;
    let run = &motion.runs[index];
    let travel = setup.cell.travel.speed.0;
    let bad = |what: &str| {
        Problem::error(E0904, "path", format!("run {}: {what} cannot be written as a RAPID number", index + 1))
    };
    // With long names the arguments of a move go on the next line.
    let names = &setup.names;
    let wrap = if MOVE_LENGTH + names.tool.len() + names.object.len() > LINE_LENGTH { WRAP } else { "" };
    let mut after_speed = vec![b','];
    push_fixed(&mut after_speed, degrees(setup.rapid.controller.orientation_speed.0), setup.decimals.speed)
        .ok_or_else(|| bad("the orientation speed"))?;
    after_speed.extend_from_slice(b",5000,1000],");
    let constant = Constant {
        after_target: format!(",{NO_EXTERNAL_AXES}],{wrap}[").into_bytes(),
        after_speed,
        tail: format!(",{}\\WObj:={};\r\n", names.tool, names.object).into_bytes(),
    };
    let mut text = Text::new("!", (run.points.len() + 8) * 160);
    text.comment(
        2,
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
    let [approach_confdata, retract_confdata] =
        [run.approach_joints, run.retract_joints].map(|joints| confdata(&setup.arm, &joints));
    let line = |out: &mut Vec<u8>, pose: ToolPose, confdata: [i32; 4], speed: f64, zone: &str| {
        move_l(setup, &constant, out, pose, confdata, speed, zone)
    };
    // A joint move gets the time that the joints' speeds need. A straight move from the run before arrives in the planned
    // joints: the joint move behind it only makes the arm's configuration certain and has no way to go.
    let speed = setup.speeddata(travel).map(String::into_bytes);
    let joint_speed = match run.travel {
        Travel::Joint => {
            let from = if index == 0 { motion.home } else { motion.runs[index - 1].retract_joints };
            let time = setup.joint_move_time(|j| run.approach_joints[j] - from[j]);
            speed.and_then(|mut speed| {
                speed.extend_from_slice(b"\\T:=");
                push_fixed(&mut speed, time, 3).map(|()| speed)
            })
        }
        Travel::Straight => {
            line(&mut out, run.approach, approach_confdata, travel, "fine").ok_or_else(|| bad("the approach point"))?;
            speed
        }
    };
    let joint_speed = joint_speed.ok_or_else(|| bad("the approach speed"))?;
    out.extend_from_slice(b"        MoveAbsJ ");
    push_jointtarget(&mut out, run.approach_joints, setup.decimals)
        .ok_or_else(|| bad("a joint of the approach point"))?;
    out.push(b',');
    out.extend_from_slice(wrap.as_bytes());
    out.extend_from_slice(&joint_speed);
    out.extend_from_slice(b",fine");
    out.extend_from_slice(&constant.tail);
    let fly_by = zone_name(setup.rapid.zone);
    for path_line in &motion.timed.path.lines[run.lines.clone()] {
        let ends = [path_line.points.start, path_line.points.end.saturating_sub(1)];
        for i in path_line.points.clone() {
            // The plan has the tool at rest at both ends of a line.
            let zone = if ends.contains(&i) { "fine" } else { fly_by };
            let pose = ToolPose { position: motion.position[i], quaternion: motion.quaternion[i] };
            let speed = motion.timed.speed[i];
            line(&mut out, pose, motion.confdata[i], speed, zone).ok_or_else(|| point_problem(setup, i))?;
        }
    }
    line(&mut out, run.retract, retract_confdata, run.retract_speed, "fine").ok_or_else(|| bad("the retract point"))?;
    out.shrink_to_fit();
    Ok(out)
}

/// One linear move with everything inline. `None` where a number cannot be written, or the speed would be written as 0.
fn move_l(
    setup: &Setup,
    constant: &Constant,
    out: &mut Vec<u8>,
    pose: ToolPose,
    confdata: [i32; 4],
    speed: f64,
    zone: &str,
) -> Option<()> {
    let speed = scaled(speed * 1e3, setup.decimals.speed).filter(|speed| *speed > 0)?;
    out.extend_from_slice(b"        MoveL [");
    push_pose(out, pose, setup.decimals)?;
    out.extend_from_slice(b",[");
    for (k, quarter) in confdata.into_iter().enumerate() {
        if k > 0 {
            out.push(b',');
        }
        push_scaled(out, i64::from(quarter), 0);
    }
    out.push(b']');
    out.extend_from_slice(&constant.after_target);
    push_scaled(out, speed, setup.decimals.speed);
    out.extend_from_slice(&constant.after_speed);
    out.extend_from_slice(zone.as_bytes());
    out.extend_from_slice(&constant.tail);
    Some(())
}

/// What is said of a point whose move cannot be written.
fn point_problem(setup: &Setup, i: usize) -> Problem {
    let motion = setup.motion;
    let [x, y, _] = millimetres(motion.timed.path.points.position(i));
    let place = format!("point {} of {} (x = {x:.3}, y = {y:.3} mm)", i + 1, motion.position.len());
    let mut scratch = Vec::new();
    let finite = push_list(&mut scratch, &millimetres(motion.position[i]), setup.decimals.position)
        .and_then(|()| push_list(&mut scratch, &unit_quaternion(motion.quaternion[i]), setup.decimals.quaternion));
    if finite.is_none() {
        return Problem::error(E0904, "path", format!("the tool pose at {place} cannot be written as RAPID numbers"));
    }
    let speed = motion.timed.speed[i] * 1e3;
    Problem::error(E0904, "dwell.feed", format!("the speed {speed} mm/s at {place} cannot be written"))
        .note(format!("a speed has {} decimals in mm/s and must be above 0", setup.decimals.speed))
        .help("raise the lower end of `dwell.feed`, or `speed_decimals` of the controller")
}

/// The module of one chunk, from the texts of its runs. It moves only in its own build, and only from where the plan has
/// the robot: after a stop it may stand anywhere.
pub fn module(setup: &Setup, index: usize, runs: impl Iterator<Item = Vec<u8>>) -> Result<ProgramFile, Problem> {
    let names = &setup.names;
    let chunk = &setup.chunks[index];
    let module = names.chunk_module(index);
    let runs: Vec<Vec<u8>> = runs.collect();
    let mut text = Text::new("!", FRAME_BYTES + runs.iter().map(Vec::len).sum::<usize>());
    text.line(0, &format!("MODULE {module}"));
    text.comment(
        1,
        &format!(
            "module {} of {}, points {} to {} of {}; loaded and called by {}. Generated: edit the job, not this.",
            index + 1,
            setup.chunks.len(),
            chunk.points.start + 1,
            chunk.points.end,
            setup.motion.position.len(),
            names.module
        ),
    );
    // The first module begins at home, every other where the run before it ended.
    let before = chunk.runs.start.checked_sub(1).and_then(|run| setup.motion.runs.get(run));
    let start = match before {
        None => names.own("home"),
        Some(run) => {
            let name = names.chunk_start(index);
            let mut joints = Vec::new();
            push_jointtarget(&mut joints, run.retract_joints, setup.decimals).ok_or_else(|| {
                Problem::error(E0904, "path", format!("a joint where `{module}` begins cannot be written"))
            })?;
            text.line(1, &format!("CONST jointtarget {name}:={};", String::from_utf8_lossy(&joints)));
            name
        }
    };
    text.line(1, &format!("PROC {}()", names.chunk_routine(index)));
    text.comment(2, "A module of another build never moves the robot.");
    text.line(2, &format!("IF {}<>\"{}\" THEN", names.own("digest"), setup.digest));
    text.line(3, &format!("TPWrite \"{module} belongs to another build\";"));
    if setup.switches_process() {
        text.line(3, &format!("{};", names.own("process_off")));
    }
    text.line(3, "EXIT;");
    text.line(2, "ENDIF");
    text.comment(2, "The way to the first point is checked from here only.");
    text.line(2, &format!("IF NOT {}(CJointT(),{start}) THEN", names.own("near")));
    text.line(3, &format!("TPWrite \"{module}: not where it begins\";"));
    if setup.switches_process() {
        text.line(3, &format!("{};", names.own("process_off")));
    }
    text.line(3, "EXIT;");
    text.line(2, "ENDIF");
    for run in runs {
        text.bytes.extend_from_slice(&run);
    }
    text.line(1, "ENDPROC");
    text.line(0, "ENDMODULE");
    Ok(ProgramFile { name: names.file(&module), points: chunk.points.len(), bytes: text.bytes })
}
