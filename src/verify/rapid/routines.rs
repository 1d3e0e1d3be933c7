//! What the routines of the main module must say, written from the job in RAPID.
//!
//! In: the job and the plan. Out: routines, each a list of steps with the reason for it. This is the statement of what a
//! program is, apart from the emitter: where the two differ, nothing is written to disk.

use super::super::facts;
use super::Wanted;
use super::statements::{Step, Want};
use crate::diagnostics::codes::{E1002, E1003, E1012};
use crate::job::{self, Level, Process};
use crate::motion::Purpose;

/// Share of the mass by which the controller's may differ with `frames: on_controller`: the same number, typed with at
/// least three digits.
const MASS_SHARE: f64 = 1e-3;

/// A routine as it must be.
pub struct WantedRoutine {
    pub name: String,
    /// A function that gives a `bool`.
    pub function: bool,
    /// Type and name of each parameter.
    pub parameters: Vec<(&'static str, &'static str)>,
    /// A local truth value that must begin as `FALSE`.
    pub flag: Option<&'static str>,
    pub steps: Vec<Step>,
}

impl WantedRoutine {
    fn procedure(name: String, steps: Vec<Step>) -> WantedRoutine {
        WantedRoutine { name, function: false, parameters: Vec::new(), flag: None, steps }
    }

    fn function(name: String, of_type: &'static str, steps: Vec<Step>) -> WantedRoutine {
        let parameters = vec![(of_type, "found"), (of_type, "wanted")];
        WantedRoutine { name, function: true, parameters, flag: None, steps }
    }
}

/// All routines of a main module that loads `chunks` others.
pub fn wanted_routines(wanted: &Wanted, chunks: usize) -> Vec<WantedRoutine> {
    let mut all = vec![main(wanted, chunks), near(wanted)];
    if wanted.rapid.frames == job::Frames::on_controller {
        all.extend(frame_checks(wanted));
    }
    if wanted.motion.purpose == Purpose::Polish {
        all.push(full_speed(wanted));
        all.extend(process(wanted));
    }
    all
}

fn main(wanted: &Wanted, chunks: usize) -> WantedRoutine {
    let m = &wanted.names.module;
    let polishes = wanted.motion.purpose == Purpose::Polish;
    let safe = (1..=wanted.cell.safe_poses.len()).map(|i| format!("safe_{i}"));
    let near: Vec<String> =
        std::iter::once("home".to_string()).chain(safe).map(|pose| format!("{m}_near(CJointT(),{m}_{pose})")).collect();
    let start =
        format!("IF NOT ({}) THEN TPWrite \"{m}: not near home or a safe pose\"; EXIT; ENDIF", near.join(" OR "));
    let mut steps =
        vec![Step::say(E1003, "robot.cell.home", &start, "the program may start only near home or a safe pose")];
    let mut say = |code, field, text: &str, why| steps.push(Step::say(code, field, text, why));
    let call = |ending: &str| format!("{m}_{ending};");
    if wanted.rapid.frames == job::Frames::on_controller {
        let why = "tool and work object of the controller must be the job's";
        say(E1003, "target.frames", &call("check_frames"), why);
    }
    say(E1003, "target", "SingArea\\Off;", "the tool's orientation is held along every line");
    say(E1003, "target", "ConfL\\Off;", "linear moves take the nearest configuration, from planned joints on");
    say(E1003, "target", "ConfJ\\On;", "a joint move put in by hand must name its configuration");
    say(E1003, "target", "PDispOff;", "no displacement of another program may shift the path");
    say(E1003, "target", "VelSet 100,5000;", "dwell scales with the speed");
    let full_speed = call("full_speed");
    let at_full_speed = "dwell scales with the speed override, which must be 100 %";
    if polishes {
        say(E1003, "target", &full_speed, at_full_speed);
    }
    steps.push(home(wanted.start_time()));
    let mut say = |code, field, text: &str, why| steps.push(Step::say(code, field, text, why));
    if polishes {
        let why = "the process is switched on at home, before the first run";
        say(E1012, "robot.cell.process", &call("process_on"), why);
    }
    for k in 0..chunks {
        let (path, routine) = (wanted.names.path(&wanted.names.chunk_module(k)), wanted.names.chunk_routine(k));
        let progress = format!("TPWrite \"{m}: module {} of {chunks}\";", k + 1);
        if polishes {
            say(E1003, "target", &full_speed, at_full_speed);
        }
        if wanted.waits_for_inputs() {
            let why = "the process must still run before every module";
            say(E1012, "robot.cell.process", &call("wait_inputs"), why);
        }
        say(E1003, "target", &progress, "the operator sees where the program is");
        say(E1002, "target", &format!("Load\\Dynamic,\"{path}\";"), "every module is loaded, in order");
        say(E1002, "target", &format!("%\"{routine}\"%;"), "every module is run, in order");
        say(E1002, "target", &format!("UnLoad \"{path}\";"), "every module is unloaded before the next");
    }
    if polishes {
        let why = "the process is switched off after the last run, before the way home";
        say(E1012, "robot.cell.process", &call("process_off"), why);
    }
    let moved =
        format!("IF NOT {m}_near(CJointT(),{m}_end) THEN TPWrite \"{m}: not where the path ended\"; EXIT; ENDIF");
    let why = "the way home is checked from the end of the path only, and the robot may have been moved";
    say(E1003, "robot.cell.home", &moved, why);
    steps.push(home(wanted.end_time()));
    let done = format!("TPWrite \"{m}: done\";");
    steps.push(Step::say(E1003, "target", &done, "the operator sees that the program is done"));
    WantedRoutine::procedure("main".into(), steps)
}

fn home(time: f64) -> Step {
    let why = "the path starts and ends with a checked joint move from and to home";
    Step { code: E1003, field: "robot.cell.home", want: Want::Home(time), why }
}

fn near(wanted: &Wanted) -> WantedRoutine {
    let tolerance = wanted.cell.home_tolerance.0 * (180.0 / std::f64::consts::PI);
    let joints: Vec<String> =
        (1..=6).map(|j| format!("Abs(found.robax.rax_{j}-wanted.robax.rax_{j})<={tolerance}")).collect();
    let text = format!("RETURN {};", joints.join(" AND "));
    let why = "each joint must lie within `home_tolerance` of a pose that the program may start from";
    let step = Step::say(E1003, "robot.cell.home_tolerance", &text, why);
    WantedRoutine::function(wanted.names.own("near"), "jointtarget", vec![step])
}

fn full_speed(wanted: &Wanted) -> WantedRoutine {
    let m = &wanted.names.module;
    let text =
        format!("WHILE CSpeedOverride()<>100 DO TPWrite \"{m}: set the speed override to 100\"; WaitTime 2; ENDWHILE");
    let step = Step::say(E1003, "target", &text, "dwell scales with the speed override: the program waits for 100 %");
    WantedRoutine::procedure(wanted.names.own("full_speed"), vec![step])
}

fn frame_checks(wanted: &Wanted) -> Vec<WantedRoutine> {
    let m = &wanted.names.module;
    let (tool, object) = (&wanted.names.tool, &wanted.names.object);
    let far = wanted.rapid.frame_tolerance.0 * 1e3;
    // |q - p| of unit quaternions an angle a apart is 2 sin(a/4).
    let chord = 2.0 * libm::sin(wanted.rapid.frame_angle_tolerance.0 / 4.0);
    let (far_square, chord_square) = (far * far, chord * chord);
    let mass = wanted.cell.tcp.load.mass.0 * MASS_SHARE;
    let why = "tool and work object of the controller must be the job's, or the program stops";
    let mut steps = Vec::new();
    let mut say = |text: String| steps.push(Step::say(E1003, "target.frames", &text, why));
    say(format!(
        "IF {tool}.robhold=FALSE OR {object}.robhold=TRUE OR {object}.ufprog=FALSE OR {object}.ufmec<>\"\" THEN \
         TPWrite \"robhold, ufprog or ufmec differs\"; differs:=TRUE; ENDIF"
    ));
    for (found, ending) in [
        (format!("{tool}.tframe"), "tframe"),
        (format!("{object}.uframe"), "uframe"),
        (format!("{object}.oframe"), "oframe"),
    ] {
        say(format!(
            "IF NOT {m}_same_pose({found},{m}_{ending}) THEN TPWrite \"{found} differs\"; \
             TPWrite \"controller \"\\Pos:={found}.trans; TPWrite \"job        \"\\Pos:={m}_{ending}.trans; \
             differs:=TRUE; ENDIF"
        ));
    }
    say(format!(
        "IF Abs({tool}.tload.mass-{m}_mass)>{mass} THEN TPWrite \"{tool}.tload.mass differs\"; differs:=TRUE; ENDIF"
    ));
    say(format!(
        "IF NOT {m}_same_pos({tool}.tload.cog,{m}_cog) THEN TPWrite \"{tool}.tload.cog differs\"; differs:=TRUE; ENDIF"
    ));
    say("IF differs THEN EXIT; ENDIF".into());
    let mut check = WantedRoutine::procedure(wanted.names.own("check_frames"), steps);
    check.flag = Some("differs");

    let squares: Vec<String> =
        ["x", "y", "z"].iter().map(|k| format!("(found.{k}-wanted.{k})*(found.{k}-wanted.{k})")).collect();
    let text = format!("RETURN {}<={far_square};", squares.join("+"));
    let why = "places are compared within `frame_tolerance`";
    let same_pos = vec![Step::say(E1003, "target.frame_tolerance", &text, why)];

    let sum = |sign: &str| {
        let squares: Vec<String> = (1..=4)
            .map(|k| format!("(found.rot.q{k}{sign}wanted.rot.q{k})*(found.rot.q{k}{sign}wanted.rot.q{k})"))
            .collect();
        squares.join("+")
    };
    let text = format!("IF {}>{chord_square} AND {}>{chord_square} THEN RETURN FALSE; ENDIF", sum("-"), sum("+"));
    let why = "orientations are compared within `frame_angle_tolerance`, for both signs of the quaternion";
    let same_pose = vec![
        Step::say(E1003, "target.frame_angle_tolerance", &text, why),
        Step::say(E1003, "target.frames", &format!("RETURN {m}_same_pos(found.trans,wanted.trans);"), why),
    ];
    vec![
        check,
        WantedRoutine::function(wanted.names.own("same_pos"), "pos", same_pos),
        WantedRoutine::function(wanted.names.own("same_pose"), "pose", same_pose),
    ]
}

fn process(wanted: &Wanted) -> Vec<WantedRoutine> {
    let m = &wanted.names.module;
    let (mut on, mut waits, mut off) = (Vec::new(), Vec::new(), Vec::new());
    let field = "robot.cell.process";
    let say = |steps: &mut Vec<Step>, text: String, why| steps.push(Step::say(E1012, field, &text, why));
    match &wanted.cell.process {
        Process::manual(_) => {
            let why = "the operator switches wheel and fluid on, and confirms";
            for (fact, field) in operator_facts(wanted) {
                let why = "the operator sees which part it is and how the wheel must turn";
                on.push(Step::say(E1012, field, &format!("TPWrite \"{fact}\";"), why));
            }
            say(&mut on, format!("TPWrite \"{m}: switch wheel and fluid on,\";"), why);
            say(&mut on, "TPWrite \"wait until they run steadily, press start\";".into(), why);
            say(&mut on, "Stop;".into(), why);
            let moved = format!(
                "IF NOT {m}_near(CJointT(),{m}_home) THEN TPWrite \"{m}: not at home\"; {m}_process_off; EXIT; ENDIF"
            );
            say(&mut on, moved, "nobody may have moved the robot meanwhile");
            let why = "the operator switches wheel and fluid off, and confirms";
            say(&mut off, format!("TPWrite \"{m}: switch wheel and fluid off,\";"), why);
            say(&mut off, "TPWrite \"then press start\";".into(), why);
            say(&mut off, "Stop;".into(), why);
        }
        Process::signals(signals) => {
            let value = |active: Level, on: bool| u8::from((active == Level::high) == on);
            for output in &signals.outputs {
                let why = "outputs are switched on in the order of the job, each with its time to settle";
                say(&mut on, format!("SetDO {},{};", output.name, value(output.active, true)), why);
                say(&mut on, format!("WaitTime {};", output.settle.0), why);
            }
            if wanted.waits_for_inputs() {
                say(&mut on, format!("{m}_wait_inputs;"), "the process must run before the path begins");
            }
            for input in &signals.inputs {
                let why = "an input that does not come ends the program, process off";
                let (name, active, most) = (&input.name, value(input.active, true), input.wait_at_most.0);
                say(&mut waits, format!("WaitDI {name},{active}\\MaxTime:={most}\\TimeFlag:={m}_late;"), why);
                let late = format!("IF {m}_late THEN TPWrite \"{name} did not come\"; {m}_process_off; EXIT; ENDIF");
                say(&mut waits, late, why);
            }
            for output in signals.outputs.iter().rev() {
                let why = "outputs are switched off in the reverse order";
                say(&mut off, format!("SetDO {},{};", output.name, value(output.active, false)), why);
            }
        }
    }
    let mut all = vec![
        WantedRoutine::procedure(wanted.names.own("process_on"), on),
        WantedRoutine::procedure(wanted.names.own("process_off"), off),
    ];
    if wanted.waits_for_inputs() {
        all.push(WantedRoutine::procedure(wanted.names.own("wait_inputs"), waits));
    }
    all
}

/// What the operator must be shown before the process is switched on, in lines of 40 characters, and the fields that
/// say it. A character that a RAPID string cannot hold as it is becomes a question mark.
fn operator_facts(wanted: &Wanted) -> Vec<(String, &'static str)> {
    let mut shown = String::from("part ");
    for c in wanted.job.workpiece.part.chars() {
        let fits = c == ' ' || c.is_ascii_graphic() && c != '"' && c != '\\';
        shown.push(if fits { c } else { '?' });
    }
    let mut facts = Vec::new();
    while !shown.is_empty() {
        // Plain ASCII: a byte is a character.
        let rest = shown.split_off(shown.len().min(40));
        facts.push((shown, "workpiece.part"));
        shown = rest;
    }
    facts.extend(facts::of_tool(&wanted.job.tool));
    facts
}

impl Wanted<'_> {
    /// Whether the process has inputs to wait for, and is switched at all.
    pub fn waits_for_inputs(&self) -> bool {
        let inputs = matches!(&self.cell.process, Process::signals(signals) if !signals.inputs.is_empty());
        inputs && self.motion.purpose == Purpose::Polish
    }

    /// Seconds of a joint move whose joints change so much, at the cell's share of the rated speeds; at least 0.1 s, in
    /// whole milliseconds, rounded up.
    pub fn joint_move_time(&self, change: impl Fn(usize) -> f64) -> f64 {
        let share = self.cell.joint_move_speed;
        let longest = self.robot.joints.iter().enumerate().map(|(j, joint)| change(j).abs() / (share * joint.speed.0));
        (longest.fold(0.1, f64::max) * 1e3).ceil() * 1e-3
    }

    /// From the farthest pose that the program may start from to home.
    fn start_time(&self) -> f64 {
        let (home, tolerance) = (&self.motion.home, self.cell.home_tolerance.0);
        self.joint_move_time(|j| {
            let away = |pose: &Vec<crate::units::si::Angle>| pose.get(j).map_or(0.0, |angle| (angle.0 - home[j]).abs());
            self.cell.safe_poses.iter().map(away).fold(0.0, f64::max) + tolerance
        })
    }

    /// From the last retract point to home.
    fn end_time(&self) -> f64 {
        let (runs, home) = (&self.motion.runs, &self.motion.home);
        self.joint_move_time(|j| runs.last().map_or(0.0, |run| run.retract_joints[j] - home[j]))
    }
}
