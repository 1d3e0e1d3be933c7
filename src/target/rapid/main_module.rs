//! The main module: data, the checks before anything moves, process switching, the loader.
//!
//! In: the setup with its chunks. Out: bytes. Nothing moves before the start pose and the frames were checked, nor at
//! another override than 100 % where it polishes, nor after a stop before the place was checked again. There is no error handler that moves: after a protective stop an operator decides, and wheel and pump fall
//! by the interlock that the cell names.

use super::Setup;
use super::writing::{push_jointtarget, push_list, push_pose};
use crate::diagnostics::Problem;
use crate::diagnostics::codes::{E0903, E0904};
use crate::job::{DigitalOut, Frames, Level, Process};
use crate::motion::{Purpose, ToolPose};
use crate::target::number::{degrees, millimetres, pose_of, single, unit_quaternion};
use crate::target::text::Text;
use crate::target::{ProgramFile, facts};

/// With `frames: on_controller`, how far the mass may differ, as a share: the two are meant to be the same number, typed
/// with at least three digits.
const MASS_SHARE: f64 = 1e-3;

/// The main module of the program.
pub fn write(setup: &Setup) -> Result<ProgramFile, Vec<Problem>> {
    let names = &setup.names;
    let mut text = Text::new("!", 0);
    text.line(0, &format!("MODULE {}", names.module));
    let written = header(setup, &mut text).ok_or("the robot's base").and_then(|()| body(setup, &mut text));
    written.map_err(|what| {
        vec![Problem::error(E0904, "robot.cell", format!("{what} cannot be written as a RAPID number"))]
    })?;
    text.line(0, "ENDMODULE");
    let most = usize::try_from(setup.rapid.controller.module_bytes).unwrap_or(0);
    if text.bytes.len() > most {
        return Err(vec![
            Problem::error(
                E0903,
                "target.controller.module_bytes",
                format!(
                    "the main module needs {} bytes, more than the {most} that one module may have",
                    text.bytes.len()
                ),
            )
            .help("raise `module_bytes`, or `module_points` so that there are fewer modules to load"),
        ]);
    }
    Ok(ProgramFile { name: names.file(&names.module), points: 0, bytes: text.bytes })
}

impl Setup<'_> {
    /// A dry run leaves wheel and pump alone.
    pub(super) fn switches_process(&self) -> bool {
        self.motion.purpose == Purpose::Polish
    }

    /// Whether the process says by inputs that it runs.
    fn waits_for_inputs(&self) -> bool {
        self.switches_process() && matches!(&self.cell.process, Process::signals(s) if !s.inputs.is_empty())
    }
}

fn header(setup: &Setup, text: &mut Text) -> Option<()> {
    let mut base = b"[".to_vec();
    push_pose(&mut base, pose_of(&setup.motion.frames.world_base), setup.decimals)?;
    base.push(b']');
    let modules = format!("modules: {}", setup.chunks.len());
    let base = String::from_utf8_lossy(&base);
    for line in facts::header(setup.name, setup.motion, setup.job, setup.cell, &setup.digest, &base, &modules) {
        text.comment(1, &line);
    }
    Some(())
}

/// Everything below the header; the error names what cannot be written.
fn body(setup: &Setup, text: &mut Text) -> Result<(), &'static str> {
    data(setup, text)?;
    main(setup, text)?;
    near(setup, text)?;
    if setup.switches_process() {
        full_speed(setup, text);
    }
    if setup.rapid.frames == Frames::on_controller {
        check_frames(setup, text)?;
    }
    if setup.switches_process() {
        process(setup, text)?;
    }
    Ok(())
}

/// Data declarations; the error names what cannot be written.
fn data(setup: &Setup, text: &mut Text) -> Result<(), &'static str> {
    let names = &setup.names;
    let frames = &setup.motion.frames;
    let (tool, user, object) =
        (pose_of(&frames.flange_tool), pose_of(&frames.world_user), pose_of(&frames.user_object));
    let d = setup.decimals;
    let pose = |pose: ToolPose| -> Option<String> {
        let mut out = b"[".to_vec();
        push_pose(&mut out, pose, d)?;
        out.push(b']');
        String::from_utf8(out).ok()
    };
    let list = |values: &[f64], decimals: usize| -> Option<String> {
        let mut out = Vec::new();
        push_list(&mut out, values, decimals)?;
        String::from_utf8(out).ok()
    };
    let tframe = pose(tool).ok_or("the tool frame")?;
    let uframe = pose(user).ok_or("the user frame")?;
    let oframe = pose(object).ok_or("the object frame")?;
    let load = &setup.cell.tcp.load;
    let mass = single(load.mass.0).ok_or("the tool's mass")?;
    let centre = millimetres([load.centre.x.0, load.centre.y.0, load.centre.z.0]);
    let cog = list(&centre, d.position).ok_or("the tool's centre of gravity")?;
    match setup.rapid.frames {
        Frames::in_program => {
            // The moments are given along the tool frame's axes. Without them the load counts as a point of mass.
            let (axes, inertia) = match load.inertia {
                Some(inertia) => (unit_quaternion(tool.quaternion), [inertia.x.0, inertia.y.0, inertia.z.0]),
                None => ([1.0, 0.0, 0.0, 0.0], [0.0; 3]),
            };
            let axes = list(&axes, d.quaternion).ok_or("the axes of inertia")?;
            let [x, y, z] = inertia.map(single);
            let (Some(x), Some(y), Some(z)) = (x, y, z) else { return Err("a moment of inertia") };
            text.line(1, &format!("PERS tooldata {}:=[TRUE,{tframe},", names.tool));
            text.line(2, &format!("[{mass},{cog},{axes},{x},{y},{z}]];"));
            text.line(1, &format!("PERS wobjdata {}:=[FALSE,TRUE,\"\",{uframe},", names.object));
            text.line(2, &format!("{oframe}];"));
        }
        Frames::on_controller => {
            text.comment(1, "What tool and work object on the controller must be.");
            text.line(1, &format!("CONST pose {}:={tframe};", names.own("tframe")));
            text.line(1, &format!("CONST num {}:={mass};", names.own("mass")));
            text.line(1, &format!("CONST pos {}:={cog};", names.own("cog")));
            text.line(1, &format!("CONST pose {}:={uframe};", names.own("uframe")));
            text.line(1, &format!("CONST pose {}:={oframe};", names.own("oframe")));
        }
    }
    text.line(1, &format!("CONST string {}:=\"{}\";", names.own("digest"), setup.digest));
    let mut joints = |ending: &str, joints: [f64; 6]| -> Option<()> {
        let mut out = Vec::new();
        push_jointtarget(&mut out, joints, d)?;
        text.line(1, &format!("CONST jointtarget {}:={};", names.own(ending), String::from_utf8(out).ok()?));
        Some(())
    };
    joints("home", setup.motion.home).ok_or("a joint of home")?;
    for (i, pose) in setup.cell.safe_poses.iter().enumerate() {
        let angles: Vec<f64> = pose.iter().map(|angle| angle.0).collect();
        let angles: [f64; 6] = angles.try_into().map_err(|_| "a safe pose without six joints")?;
        joints(&format!("safe_{}", i + 1), angles).ok_or("a joint of a safe pose")?;
    }
    // Where the path ends: from there only the way home is checked.
    if let Some(last) = setup.motion.runs.last() {
        joints("end", last.retract_joints).ok_or("a joint of the last retract point")?;
    }
    if setup.waits_for_inputs() {
        text.line(1, &format!("VAR bool {}:=FALSE;", names.own("late")));
    }
    Ok(())
}

fn main(setup: &Setup, text: &mut Text) -> Result<(), &'static str> {
    let names = &setup.names;
    let (m, tool, object) = (&names.module, &names.tool, &names.object);
    let motion = setup.motion;
    text.line(0, "");
    text.line(1, "PROC main()");
    text.comment(2, "Only from home or a safe pose: nothing moves before.");
    let mut at_start = format!("{}(CJointT(),{})", names.own("near"), names.own("home"));
    for i in 0..setup.cell.safe_poses.len() {
        at_start.push_str(&format!(
            " OR\r\n            {}(CJointT(),{})",
            names.own("near"),
            names.own(&format!("safe_{}", i + 1))
        ));
    }
    text.line(2, &format!("IF NOT ({at_start}) THEN"));
    text.line(3, &format!("TPWrite \"{m}: not near home or a safe pose\";"));
    text.line(3, "EXIT;");
    text.line(2, "ENDIF");
    if setup.rapid.frames == Frames::on_controller {
        text.line(2, &format!("{};", names.own("check_frames")));
    }
    text.comment(
        2,
        "Linear moves keep the orientation exactly and take the nearest arm configuration: each run starts",
    );
    text.comment(2, "from planned joints. No displacement may be left over from another program.");
    text.line(2, "SingArea\\Off;");
    text.line(2, "ConfL\\Off;");
    text.line(2, "ConfJ\\On;");
    text.line(2, "PDispOff;");
    text.line(2, "VelSet 100,5000;");
    if setup.switches_process() {
        text.line(2, &format!("{};", names.own("full_speed")));
    }
    // From the farthest start that the check above lets pass.
    let start = setup.joint_move_time(|j| {
        let far = |pose: &Vec<_>| pose.get(j).map_or(0.0, |v: &crate::units::si::Angle| (v.0 - motion.home[j]).abs());
        setup.cell.home_tolerance.0 + setup.cell.safe_poses.iter().map(far).fold(0.0, f64::max)
    });
    let travel = setup.speeddata(setup.cell.travel.speed.0).ok_or("the travel speed")?;
    let home = |time: f64| -> Result<String, &'static str> {
        let time = single(time).ok_or("the time of a move to home")?;
        Ok(format!("MoveAbsJ {},{travel}\\T:={time},fine,{tool}\\WObj:={object};", names.own("home")))
    };
    text.line(2, &home(start)?);
    if setup.switches_process() {
        text.comment(2, "At home, far off the part. The process then stays on until the last run is done: between");
        text.comment(2, "modules the tool waits lifted off the part, and switching there would disturb the flow.");
        text.line(2, &format!("{};", names.own("process_on")));
    }
    for index in 0..setup.chunks.len() {
        let module = names.chunk_module(index);
        if setup.switches_process() {
            text.line(2, &format!("{};", names.own("full_speed")));
        }
        if setup.waits_for_inputs() {
            text.line(2, &format!("{};", names.own("wait_inputs")));
        }
        text.line(2, &format!("TPWrite \"{m}: module {} of {}\";", index + 1, setup.chunks.len()));
        text.line(2, &format!("Load\\Dynamic,\"{}\";", names.path(&module)));
        text.line(2, &format!("%\"{}\"%;", names.chunk_routine(index)));
        text.line(2, &format!("UnLoad \"{}\";", names.path(&module)));
    }
    if setup.switches_process() {
        text.line(2, &format!("{};", names.own("process_off")));
    }
    if let Some(last) = motion.runs.last() {
        text.comment(2, "Only from where the path ended: nobody may have moved the robot meanwhile.");
        text.line(2, &format!("IF NOT {}(CJointT(),{}) THEN", names.own("near"), names.own("end")));
        text.line(3, &format!("TPWrite \"{m}: not where the path ended\";"));
        text.line(3, "EXIT;");
        text.line(2, "ENDIF");
        text.line(2, &home(setup.joint_move_time(|j| last.retract_joints[j] - motion.home[j]))?);
    }
    text.line(2, &format!("TPWrite \"{m}: done\";"));
    text.line(1, "ENDPROC");
    Ok(())
}

fn near(setup: &Setup, text: &mut Text) -> Result<(), &'static str> {
    let tolerance = single(degrees(setup.cell.home_tolerance.0)).ok_or("the tolerance around home")?;
    text.line(0, "");
    text.comment(1, "Whether every joint lies near that of another pose, deg.");
    text.line(1, &format!("FUNC bool {}(jointtarget found,jointtarget wanted)", setup.names.own("near")));
    for j in 1..=6 {
        let (begin, end) = (if j == 1 { "RETURN " } else { "    " }, if j == 6 { ";" } else { " AND" });
        text.line(2, &format!("{begin}Abs(found.robax.rax_{j}-wanted.robax.rax_{j})<={tolerance}{end}"));
    }
    text.line(1, "ENDFUNC");
    Ok(())
}

fn full_speed(setup: &Setup, text: &mut Text) {
    text.line(0, "");
    text.comment(
        1,
        "Dwell scales with the speed override: no module begins at less than 100 %. Inside a module nothing",
    );
    text.comment(1, "watches it: leave it alone until the program is done.");
    text.line(1, &format!("PROC {}()", setup.names.own("full_speed")));
    text.line(2, "WHILE CSpeedOverride()<>100 DO");
    text.line(3, &format!("TPWrite \"{}: set the speed override to 100\";", setup.names.module));
    text.line(3, "WaitTime 2;");
    text.line(2, "ENDWHILE");
    text.line(1, "ENDPROC");
}

/// Compares the controller's tool and work object with the job's. Orientations are compared by the difference of the
/// quaternions, for either sign: the cosine of a small angle is 1 in single precision.
fn check_frames(setup: &Setup, text: &mut Text) -> Result<(), &'static str> {
    let names = &setup.names;
    let (tool, object) = (&names.tool, &names.object);
    let far = setup.rapid.frame_tolerance.0 * 1e3;
    // Two unit quaternions that are an angle a apart differ by a vector of length 2 sin(a/4).
    let chord = 2.0 * libm::sin(setup.rapid.frame_angle_tolerance.0 / 4.0);
    let mass = setup.cell.tcp.load.mass.0 * MASS_SHARE;
    let number = |value: f64| single(value).ok_or("a tolerance of the frames");
    text.line(0, "");
    text.comment(1, "Tool and work object of the controller must be those of the job.");
    text.line(1, &format!("PROC {}()", names.own("check_frames")));
    text.line(2, "VAR bool differs:=FALSE;");
    text.line(
        2,
        &format!(
            "IF {tool}.robhold=FALSE OR {object}.robhold=TRUE OR {object}.ufprog=FALSE OR {object}.ufmec<>\"\" THEN"
        ),
    );
    text.line(3, "TPWrite \"robhold, ufprog or ufmec differs\";");
    text.line(3, "differs:=TRUE;");
    text.line(2, "ENDIF");
    for (found, wanted) in [
        (format!("{tool}.tframe"), names.own("tframe")),
        (format!("{object}.uframe"), names.own("uframe")),
        (format!("{object}.oframe"), names.own("oframe")),
    ] {
        text.line(2, &format!("IF NOT {}({found},{wanted}) THEN", names.own("same_pose")));
        text.line(3, &format!("TPWrite \"{found} differs\";"));
        text.line(3, &format!("TPWrite \"controller \"\\Pos:={found}.trans;"));
        text.line(3, &format!("TPWrite \"job        \"\\Pos:={wanted}.trans;"));
        text.line(3, "differs:=TRUE;");
        text.line(2, "ENDIF");
    }
    text.line(2, &format!("IF Abs({tool}.tload.mass-{})>{} THEN", names.own("mass"), number(mass)?));
    text.line(3, &format!("TPWrite \"{tool}.tload.mass differs\";"));
    text.line(3, "differs:=TRUE;");
    text.line(2, "ENDIF");
    text.line(2, &format!("IF NOT {}({tool}.tload.cog,{}) THEN", names.own("same_pos"), names.own("cog")));
    text.line(3, &format!("TPWrite \"{tool}.tload.cog differs\";"));
    text.line(3, "differs:=TRUE;");
    text.line(2, "ENDIF");
    text.line(2, "IF differs THEN");
    text.line(3, "EXIT;");
    text.line(2, "ENDIF");
    text.line(1, "ENDPROC");

    text.line(0, "");
    text.comment(1, "Whether two places are the same within the job's tolerance, mm.");
    text.line(1, &format!("FUNC bool {}(pos found,pos wanted)", names.own("same_pos")));
    for (k, axis) in ["x", "y", "z"].iter().enumerate() {
        let begin = if k == 0 { "RETURN " } else { "    " };
        let end = if k == 2 { format!("<={};", number(far * far)?) } else { "+".into() };
        text.line(2, &format!("{begin}(found.{axis}-wanted.{axis})*(found.{axis}-wanted.{axis}){end}"));
    }
    text.line(1, "ENDFUNC");

    text.line(0, "");
    text.comment(1, "Whether two poses are the same; q and -q are one orientation.");
    text.line(1, &format!("FUNC bool {}(pose found,pose wanted)", names.own("same_pose")));
    let squares = |sign: &str| {
        let term = |k: usize| format!("(found.rot.q{k}{sign}wanted.rot.q{k})*(found.rot.q{k}{sign}wanted.rot.q{k})");
        [1, 2, 3, 4].map(term).join("+\r\n            ")
    };
    let limit = number(chord * chord)?;
    text.line(2, &format!("IF {}>{limit} AND", squares("-")));
    text.line(3, &format!("{}>{limit} THEN", squares("+")));
    text.line(3, "RETURN FALSE;");
    text.line(2, "ENDIF");
    text.line(2, &format!("RETURN {}(found.trans,wanted.trans);", names.own("same_pos")));
    text.line(1, "ENDFUNC");
    Ok(())
}

/// The routines that switch the process on and off.
fn process(setup: &Setup, text: &mut Text) -> Result<(), &'static str> {
    let names = &setup.names;
    let m = &names.module;
    let near_home = format!("{}(CJointT(),{})", names.own("near"), names.own("home"));
    text.line(0, "");
    text.comment(1, "Called at home, before the first run.");
    text.line(1, &format!("PROC {}()", names.own("process_on")));
    match &setup.cell.process {
        Process::manual(_) => {
            for fact in facts::operator(setup.job) {
                text.line(2, &format!("TPWrite \"{fact}\";"));
            }
            text.line(2, &format!("TPWrite \"{m}: switch wheel and fluid on,\";"));
            text.line(2, "TPWrite \"wait until they run steadily, press start\";");
            text.line(2, "Stop;");
            text.comment(2, "Nobody may have moved the robot meanwhile.");
            text.line(2, &format!("IF NOT {near_home} THEN"));
            text.line(3, &format!("TPWrite \"{m}: not at home\";"));
            text.line(3, &format!("{};", names.own("process_off")));
            text.line(3, "EXIT;");
            text.line(2, "ENDIF");
        }
        Process::signals(signals) => {
            for output in &signals.outputs {
                text.line(2, &format!("SetDO {},{};", output.name, level(output, true)));
                text.line(
                    2,
                    &format!("WaitTime {};", single(output.settle.0).ok_or("the time that an output settles")?),
                );
            }
            if setup.waits_for_inputs() {
                text.line(2, &format!("{};", names.own("wait_inputs")));
            }
        }
    }
    text.line(1, "ENDPROC");
    if let Process::signals(signals) = &setup.cell.process
        && setup.waits_for_inputs()
    {
        text.line(0, "");
        text.comment(1, "Called before every module, off the part: the process may have failed meanwhile.");
        text.line(1, &format!("PROC {}()", names.own("wait_inputs")));
        for input in &signals.inputs {
            let active = i32::from(input.active == Level::high);
            let most = single(input.wait_at_most.0).ok_or("the time that an input is waited for")?;
            let late = names.own("late");
            text.line(2, &format!("WaitDI {},{active}\\MaxTime:={most}\\TimeFlag:={late};", input.name));
            text.line(2, &format!("IF {late} THEN"));
            text.line(3, &format!("TPWrite \"{} did not come\";", input.name));
            text.line(3, &format!("{};", names.own("process_off")));
            text.line(3, "EXIT;");
            text.line(2, "ENDIF");
        }
        text.line(1, "ENDPROC");
    }
    text.line(0, "");
    text.comment(1, "Called off the part: after the last run, and before every early end.");
    text.line(1, &format!("PROC {}()", names.own("process_off")));
    match &setup.cell.process {
        Process::manual(_) => {
            text.line(2, &format!("TPWrite \"{m}: switch wheel and fluid off,\";"));
            text.line(2, "TPWrite \"then press start\";");
            text.line(2, "Stop;");
        }
        Process::signals(signals) => {
            for output in signals.outputs.iter().rev() {
                text.line(2, &format!("SetDO {},{};", output.name, level(output, false)));
            }
        }
    }
    text.line(1, "ENDPROC");
    Ok(())
}

/// The value that switches an output on or off.
fn level(output: &DigitalOut, on: bool) -> i32 {
    i32::from((output.active == Level::high) == on)
}
