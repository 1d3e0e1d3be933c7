//! The main program: data, the checks before anything moves, process switching, the calls of the sub-programs.
//!
//! In: the setup with its parts. Out: two files. Nothing moves before the start pose and the frames were checked, nor at
//! another override than 100 % or in T1 where it polishes, nor after a stop before the place was checked again. A refusal
//! ends in a loop of `HALT`, which no start key leaves. The program never sets `$OV_PRO`, and no interrupt routine moves:
//! after a protective stop an operator decides, and wheel and pump fall by the interlock that the cell names.
//!
//! Messages go through `MsgNotify` of KUKA's message library (MsgLib, on every controller since KSS 8.2; unsourced).
//! `WAIT SEC 0` stops the advance run, so that what is asked is asked where the robot stands.

use super::Setup;
use super::writing::{axis, frame};
use crate::diagnostics::Problem;
use crate::diagnostics::codes::{E0903, E0904};
use crate::job::{KrlFrames, Level, LineMotion, Process};
use crate::motion::frames::{kuka_abc, matrix};
use crate::target::number::{degrees, single};
use crate::target::text::Text;
use crate::target::{ProgramFile, facts};

/// With `frames: on_controller`, how far the mass may differ, as a share: the two are meant to be the same number, typed
/// with at least three digits.
const MASS_SHARE: f64 = 1e-3;

/// Seconds between two looks at an input.
const LOOK: f64 = 0.1;

/// What cannot be written.
type Written = Result<(), &'static str>;

/// The two files of the main program.
pub fn write(setup: &Setup) -> Result<[ProgramFile; 2], Vec<Problem>> {
    let (mut source, mut data) = (Text::new(";", 0), Text::new(";", 0));
    write_source(setup, &mut source).and_then(|()| write_data(setup, &mut data)).map_err(|what| {
        vec![Problem::error(E0904, "robot.cell", format!("{what} cannot be written as a KRL number"))]
    })?;
    let name = &setup.names.module;
    let files = [
        ProgramFile { name: format!("{name}.src"), points: 0, bytes: source.bytes },
        ProgramFile { name: format!("{name}.dat"), points: 0, bytes: data.bytes },
    ];
    let most = super::limit(setup.krl.controller.file_bytes);
    match files.iter().find(|file| file.bytes.len() > most) {
        Some(file) => Err(vec![
            Problem::error(
                E0903,
                "target.controller.file_bytes",
                format!(
                    "the main program needs {} bytes, more than the {most} that one file may have",
                    file.bytes.len()
                ),
            )
            .help("raise `file_bytes`, or `file_lines` so that there are fewer sub-programs to call"),
        ]),
        None => Ok(files),
    }
}

fn write_source(setup: &Setup, text: &mut Text) -> Written {
    let base = frame(&setup.motion.frames.world_base, setup.digits).ok_or("the robot's base")?;
    super::heading(text);
    text.line(0, "&COMMENT polishc");
    text.line(0, &format!("DEF {} ( )", setup.names.module));
    text.line(0, "BOOL start");
    let parts = format!("sub-programs: {}", setup.parts.len());
    for line in facts::header(setup.name, setup.motion, setup.job, setup.cell, &setup.digest, &base, &parts) {
        text.comment(0, &line);
    }
    main(setup, text)?;
    near(setup, text)?;
    stop(setup, text);
    frames(setup, text)?;
    if setup.switches_process() {
        full_speed(setup, text);
        process(setup, text)?;
    }
    Ok(())
}

/// The data file; the error names what cannot be written.
fn write_data(setup: &Setup, text: &mut Text) -> Written {
    let names = &setup.names;
    let chain = &setup.motion.frames;
    super::heading(text);
    text.line(0, &format!("DEFDAT {}", names.module));
    for (k, word) in super::digest_words(&setup.digest).iter().enumerate() {
        text.line(0, &format!("DECL INT {}={word}", names.own(&format!("d{}", k + 1))));
    }
    let joints = |text: &mut Text, ending: &str, joints: [f64; 6]| -> Option<()> {
        text.line(0, &format!("DECL AXIS {}={}", names.own(ending), axis(joints)?));
        Some(())
    };
    joints(text, "home", setup.motion.home).ok_or("a joint of home")?;
    for (i, pose) in setup.cell.safe_poses.iter().enumerate() {
        let angles: Vec<f64> = pose.iter().map(|angle| angle.0).collect();
        let angles: [f64; 6] = angles.try_into().map_err(|_| "a safe pose without six joints")?;
        joints(text, &format!("safe{}", i + 1), angles).ok_or("a joint of a safe pose")?;
    }
    // Where the path ends: from there only the way home is checked.
    if let Some(last) = setup.motion.runs.last() {
        joints(text, "end", last.retract_joints).ok_or("a joint of the last retract point")?;
    }
    text.comment(
        0,
        match setup.krl.frames {
            KrlFrames::in_program(_) => "The robot's base as planned; tool, base and load as the program uses them.",
            KrlFrames::on_controller(_) => "What base, tool, part frame and load on the controller must be.",
        },
    );
    // One base on this controller stands for user and object frame.
    for (ending, transform, what) in [
        ("root", &chain.world_base, "the robot's base"),
        ("tool", &chain.flange_tool, "the tool frame"),
        ("base", &(chain.world_user * chain.user_object), "the part frame"),
    ] {
        text.line(0, &format!("DECL FRAME {}={}", names.own(ending), frame(transform, setup.digits).ok_or(what)?));
    }
    let load = &setup.cell.tcp.load;
    let centre = [load.centre.x.0, load.centre.y.0, load.centre.z.0];
    // The moments are given along the tool frame's axes. Without them the load counts as a point of mass.
    let (axes, moments) = match load.inertia {
        Some(inertia) => (kuka_abc(&matrix(&chain.flange_tool.rotation)), [inertia.x.0, inertia.y.0, inertia.z.0]),
        None => ([0.0; 3], [0.0; 3]),
    };
    let mut centre_frame = Vec::new();
    super::writing::push_frame(&mut centre_frame, centre, axes, setup.digits).ok_or("the tool's centre of gravity")?;
    let mass = single(load.mass.0).ok_or("the tool's mass")?;
    let [x, y, z] = moments.map(single);
    let (Some(x), Some(y), Some(z)) = (x, y, z) else { return Err("a moment of inertia") };
    let centre = String::from_utf8_lossy(&centre_frame);
    text.line(0, &format!("DECL LOAD {}={{M {mass},CM {{{centre}}},J {{X {x},Y {y},Z {z}}}}}", names.own("load")));
    text.line(0, "ENDDAT");
    Ok(())
}

impl Setup<'_> {
    /// A message to the operator. `%` would begin a place holder of the message library.
    fn say(&self, text: &mut Text, depth: usize, words: &str) {
        text.line(depth, &format!("MsgNotify(\"{}\",\"{}\")", words.replace('%', "?"), self.names.module));
    }
}

fn main(setup: &Setup, text: &mut Text) -> Written {
    let names = &setup.names;
    let m = &names.module;
    let motion = setup.motion;
    let number = |value: f64, what: &'static str| single(value).ok_or(what);
    text.comment(0, "Only from home or a safe pose: nothing moves before.");
    text.line(0, &format!("start={}({})", names.own("near"), names.own("home")));
    for i in 1..=setup.cell.safe_poses.len() {
        text.line(0, &format!("IF {}({}) THEN", names.own("near"), names.own(&format!("safe{i}"))));
        text.line(1, "start=TRUE");
        text.line(0, "ENDIF");
    }
    text.line(0, "IF NOT start THEN");
    setup.say(text, 1, &format!("{m}: not near home or a safe pose"));
    text.line(1, &format!("{} ()", names.own("stop")));
    text.line(0, "ENDIF");
    text.line(0, &format!("{} ()", names.own("frames")));
    text.comment(0, "Here only: in a sub-program it would set back what follows.");
    text.line(0, "BAS (#INITMOV,0)");
    let percent = super::percent(setup.cell.joint_move_speed).ok_or("the speed of joint moves")?;
    text.line(0, &format!("BAS (#VEL_PTP,{percent})"));
    match setup.krl.frames {
        KrlFrames::on_controller(numbers) => {
            text.line(0, &format!("$TOOL=TOOL_DATA[{}]", numbers.tool));
            text.line(0, &format!("$BASE=BASE_DATA[{}]", numbers.base));
            text.line(0, &format!("$LOAD=LOAD_DATA[{}]", numbers.load));
        }
        KrlFrames::in_program(_) => {
            for (variable, ending) in [("$TOOL", "tool"), ("$BASE", "base"), ("$LOAD", "load")] {
                text.line(0, &format!("{variable}={}", names.own(ending)));
            }
        }
    }
    text.line(0, "$IPO_MODE=#BASE");
    text.line(0, "$ORI_TYPE=#VAR");
    text.line(0, &format!("$ACC.CP={}", number(acceleration(setup), "the path's acceleration")?));
    let controller = &setup.krl.controller;
    let speed = number(degrees(controller.orientation_speed.0), "the orientation speed")?;
    let acceleration = number(degrees(controller.orientation_acceleration.0), "the orientation acceleration")?;
    for (variable, value) in
        [("$VEL.ORI1", &speed), ("$VEL.ORI2", &speed), ("$ACC.ORI1", &acceleration), ("$ACC.ORI2", &acceleration)]
    {
        text.line(0, &format!("{variable}={value}"));
    }
    if let LineMotion::linear(linear) = &setup.krl.motion {
        text.line(0, &format!("$APO.CDIS={}", number(linear.rounding.0 * 1e3, "the rounding")?));
    }
    text.line(0, &format!("$ADVANCE={}", controller.advance));
    let full_speed = |text: &mut Text| {
        if setup.switches_process() {
            text.line(0, &format!("{} ()", names.own("speed")));
        }
    };
    full_speed(text);
    text.line(0, &format!("PTP {}", names.own("home")));
    if setup.switches_process() {
        text.comment(0, "At home, far off the part. The process then stays on until the last run is done: between");
        text.comment(0, "sub-programs the tool waits lifted off the part, and switching there would disturb the flow.");
        text.line(0, &format!("{} ()", names.own("on")));
    }
    let digest: Vec<String> = (1..=4).map(|k| names.own(&format!("d{k}"))).collect();
    for index in 0..setup.parts.len() {
        full_speed(text);
        if setup.waits_for_inputs() {
            text.line(0, &format!("{} ()", names.own("inputs")));
        }
        setup.say(text, 0, &format!("{m}: part {} of {}", index + 1, setup.parts.len()));
        text.line(0, &format!("{} ({})", names.sub_program(index), digest.join(",")));
    }
    if setup.switches_process() {
        text.line(0, &format!("{} ()", names.own("off")));
    }
    if !motion.runs.is_empty() {
        text.comment(0, "Only from where the path ended: nobody may have moved the robot meanwhile.");
        text.line(0, &format!("IF NOT {}({}) THEN", names.own("near"), names.own("end")));
        setup.say(text, 1, &format!("{m}: not where the path ended"));
        text.line(1, &format!("{} ()", names.own("stop")));
        text.line(0, "ENDIF");
        text.line(0, &format!("PTP {}", names.own("home")));
    }
    setup.say(text, 0, &format!("{m}: done"));
    text.line(0, "END");
    Ok(())
}

/// The acceleration that the dwell was planned with: the controller must not take another.
fn acceleration(setup: &Setup) -> f64 {
    let crate::job::Dwell::corrective(corrective) = &setup.job.dwell;
    corrective.acceleration.0
}

fn near(setup: &Setup, text: &mut Text) -> Written {
    let tolerance = single(degrees(setup.cell.home_tolerance.0)).ok_or("the tolerance around home")?;
    text.line(0, "");
    text.line(0, &format!("GLOBAL DEFFCT BOOL {} (wanted:IN)", setup.names.own("near")));
    text.line(0, "AXIS wanted");
    text.line(0, "BOOL found");
    text.comment(0, "Whether every joint lies near that of a pose, deg. The wait lets the robot come to rest first.");
    text.line(0, "WAIT SEC 0");
    text.line(0, "found=TRUE");
    for j in 1..=6 {
        text.line(0, &format!("IF ABS($AXIS_ACT.A{j}-wanted.A{j})>{tolerance} THEN"));
        text.line(1, "found=FALSE");
        text.line(0, "ENDIF");
    }
    text.line(0, "RETURN found");
    text.line(0, "ENDFCT");
    Ok(())
}

fn stop(setup: &Setup, text: &mut Text) {
    text.line(0, "");
    text.line(0, &format!("GLOBAL DEF {} ( )", setup.names.own("stop")));
    text.comment(0, "The end of a program that may not go on: no start key leaves it.");
    text.line(0, "LOOP");
    text.line(1, "HALT");
    text.line(0, "ENDLOOP");
    text.line(0, "END");
}

fn full_speed(setup: &Setup, text: &mut Text) {
    text.line(0, "");
    text.line(0, &format!("DEF {} ( )", setup.names.own("speed")));
    text.comment(
        0,
        "Dwell scales with the override, and T1 cuts speeds: no sub-program begins below 100 % or in T1. Inside one nothing",
    );
    text.comment(0, "watches it: leave it alone until the program is done.");
    text.line(0, "WAIT SEC 0");
    text.line(0, "WHILE ($OV_PRO<>100) OR ($MODE_OP==#T1)");
    setup.say(text, 1, &format!("{}: set override to 100, leave T1", setup.names.module));
    text.line(1, "WAIT SEC 2");
    text.line(0, "ENDWHILE");
    text.line(0, "END");
}

/// Compares the controller's frames with the job's. Rotations are compared by the differences of A, B and C: their sum is
/// never less than the angle between the two.
fn frames(setup: &Setup, text: &mut Text) -> Written {
    let names = &setup.names;
    let number = |value: f64| single(value).ok_or("a tolerance of the frames");
    let far = setup.krl.frame_tolerance.0 * 1e3;
    let (far_square, angle) = (number(far * far)?, number(degrees(setup.krl.frame_angle_tolerance.0))?);
    text.line(0, "");
    text.line(0, &format!("DEF {} ( )", names.own("frames")));
    text.line(0, "BOOL differs");
    text.comment(
        0,
        "The robot's base, and the frames on the controller that the program uses, must be those of the job.",
    );
    text.line(0, "differs=FALSE");
    let mut compared = vec![("$ROBROOT".to_string(), "root")];
    if let KrlFrames::on_controller(numbers) = setup.krl.frames {
        compared.push((format!("TOOL_DATA[{}]", numbers.tool), "tool"));
        compared.push((format!("BASE_DATA[{}]", numbers.base), "base"));
    }
    let differs = |text: &mut Text, what: &str| {
        setup.say(text, 1, &format!("{what} differs from the job"));
        text.line(1, "differs=TRUE");
        text.line(0, "ENDIF");
    };
    for (found, ending) in &compared {
        text.line(0, &format!("IF NOT {}({found},{}) THEN", names.own("same"), names.own(ending)));
        differs(text, found);
    }
    if let KrlFrames::on_controller(numbers) = setup.krl.frames {
        let load = format!("LOAD_DATA[{}]", numbers.load);
        let mass = number(setup.cell.tcp.load.mass.0 * MASS_SHARE)?;
        text.line(0, &format!("IF ABS({load}.M-{}.M)>{mass} THEN", names.own("load")));
        differs(text, &format!("the mass of {load}"));
        text.line(0, &format!("IF {}({load}.CM,{}.CM)>{far_square} THEN", names.own("far"), names.own("load")));
        differs(text, &format!("the centre of {load}"));
    }
    text.line(0, "IF differs THEN");
    text.line(1, &format!("{} ()", names.own("stop")));
    text.line(0, "ENDIF");
    text.line(0, "END");

    text.line(0, "");
    text.line(0, &format!("DEFFCT BOOL {} (found:IN,wanted:IN)", names.own("same")));
    text.line(0, "FRAME found,wanted");
    text.line(0, "REAL angle");
    text.comment(0, "Whether two frames are the same within the job's tolerances, mm and deg.");
    let turns: Vec<String> =
        ["A", "B", "C"].iter().map(|axis| format!("{}(found.{axis}-wanted.{axis})", names.own("turn"))).collect();
    text.line(0, &format!("angle={}", turns.join("+")));
    text.line(0, &format!("RETURN ({}(found,wanted)<={far_square}) AND (angle<={angle})", names.own("far")));
    text.line(0, "ENDFCT");

    text.line(0, "");
    text.line(0, &format!("DEFFCT REAL {} (found:IN,wanted:IN)", names.own("far")));
    text.line(0, "FRAME found,wanted");
    text.comment(0, "The square of the distance of two frames, mm^2.");
    let squares: Vec<String> = ["X", "Y", "Z"]
        .iter()
        .map(|axis| format!("(found.{axis}-wanted.{axis})*(found.{axis}-wanted.{axis})"))
        .collect();
    text.line(0, &format!("RETURN {}", squares.join("+")));
    text.line(0, "ENDFCT");

    text.line(0, "");
    text.line(0, &format!("DEFFCT REAL {} (angle:IN)", names.own("turn")));
    text.line(0, "REAL angle");
    text.comment(0, "The size of a difference of angles without its whole turn, deg.");
    text.line(0, "IF ABS(angle)>180 THEN");
    text.line(1, "RETURN ABS(ABS(angle)-360)");
    text.line(0, "ENDIF");
    text.line(0, "RETURN ABS(angle)");
    text.line(0, "ENDFCT");
    Ok(())
}

/// The routines that switch the process on and off.
fn process(setup: &Setup, text: &mut Text) -> Written {
    let names = &setup.names;
    let m = &names.module;
    text.line(0, "");
    text.line(0, &format!("DEF {} ( )", names.own("on")));
    text.comment(0, "Called at home, before the first run.");
    match &setup.cell.process {
        Process::manual(_) => {
            for fact in facts::operator(setup.job) {
                setup.say(text, 0, &fact);
            }
            setup.say(text, 0, &format!("{m}: switch wheel and fluid on"));
            setup.say(text, 0, "wait until they run steadily, press start");
            text.line(0, "HALT");
            text.comment(0, "Nobody may have moved the robot meanwhile.");
            text.line(0, &format!("IF NOT {}({}) THEN", names.own("near"), names.own("home")));
            setup.say(text, 1, &format!("{m}: not at home"));
            text.line(1, &format!("{} ()", names.own("off")));
            text.line(1, &format!("{} ()", names.own("stop")));
            text.line(0, "ENDIF");
        }
        Process::signals(signals) => {
            for output in &signals.outputs {
                switch(text, output.number, output.active, true);
                let settle = single(output.settle.0).ok_or("the time that an output settles")?;
                text.line(0, &format!("WAIT SEC {settle}"));
            }
            if setup.waits_for_inputs() {
                text.line(0, &format!("{} ()", names.own("inputs")));
            }
        }
    }
    text.line(0, "END");
    if let Process::signals(signals) = &setup.cell.process
        && setup.waits_for_inputs()
    {
        text.line(0, "");
        text.line(0, &format!("DEF {} ( )", names.own("inputs")));
        text.line(0, "INT looks");
        text.comment(0, "Called before every sub-program, off the part: the process may have failed meanwhile.");
        for input in &signals.inputs {
            let number = input.number.unwrap_or(0);
            let missing = if input.active == Level::high { "FALSE" } else { "TRUE" };
            // A time of whole looks may be a rounding more.
            let looks = (input.wait_at_most.0 / LOOK - 1e-9).ceil().max(1.0);
            text.line(0, "looks=0");
            text.line(0, &format!("WHILE ($IN[{number}]=={missing}) AND (looks<{looks})"));
            text.line(1, &format!("WAIT SEC {LOOK}"));
            text.line(1, "looks=looks+1");
            text.line(0, "ENDWHILE");
            text.line(0, &format!("IF $IN[{number}]=={missing} THEN"));
            setup.say(text, 1, &format!("{} did not come", facts::plain(&input.name)));
            text.line(1, &format!("{} ()", names.own("off")));
            text.line(1, &format!("{} ()", names.own("stop")));
            text.line(0, "ENDIF");
        }
        text.line(0, "END");
    }
    text.line(0, "");
    text.line(0, &format!("GLOBAL DEF {} ( )", names.own("off")));
    text.comment(0, "Called off the part: after the last run, and before every early end.");
    match &setup.cell.process {
        Process::manual(_) => {
            setup.say(text, 0, &format!("{m}: switch wheel and fluid off"));
            setup.say(text, 0, "then press start");
            text.line(0, "HALT");
        }
        Process::signals(signals) => {
            text.line(0, "WAIT SEC 0");
            for output in signals.outputs.iter().rev() {
                switch(text, output.number, output.active, false);
            }
        }
    }
    text.line(0, "END");
    Ok(())
}

/// Switches an output on or off.
fn switch(text: &mut Text, number: Option<i64>, active: Level, on: bool) {
    let value = if (active == Level::high) == on { "TRUE" } else { "FALSE" };
    text.line(0, &format!("$OUT[{}]={value}", number.unwrap_or(0)));
}
