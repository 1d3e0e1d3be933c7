//! What the routines of the main program must say, written from the job in KRL.
//!
//! In: the job and the plan. Out: routines, each a list of steps with the reason for it. This is the statement of what a
//! program is, apart from the emitter: where the two differ, nothing is written to disk.

use super::super::facts;
use super::Wanted;
use super::statements::Step;
use crate::diagnostics::codes::{E1002, E1003, E1008, E1010, E1011, E1012};
use crate::job::{KrlFrames, Level, LineMotion, Process};
use crate::motion::Purpose;

/// Share of the mass by which the controller's may differ with `frames: on_controller`: the same number, typed with at
/// least three digits.
const MASS_SHARE: f64 = 1e-3;

/// A routine as it must be.
pub struct WantedRoutine {
    pub name: String,
    /// Seen by the sub-programs.
    pub global: bool,
    pub returns: Option<&'static str>,
    pub parameters: &'static [&'static str],
    /// Type and name of all that it declares, parameters included.
    pub data: &'static [(&'static str, &'static str)],
    pub steps: Vec<Step>,
}

/// All routines of a main program that calls `parts` others, the main routine first.
pub fn wanted_routines(wanted: &Wanted, parts: usize) -> Vec<WantedRoutine> {
    let mut all = vec![main(wanted, parts), near(wanted), stop(wanted)];
    all.extend(frames(wanted));
    if wanted.motion.purpose == Purpose::Polish {
        all.push(full_speed(wanted));
        all.extend(process(wanted));
    }
    all
}

fn procedure(name: String, steps: Vec<Step>) -> WantedRoutine {
    WantedRoutine { name, global: false, returns: None, parameters: &[], data: &[], steps }
}

/// A message to the operator. `%` begins a place holder of the message library.
fn message(m: &str, words: &str) -> String {
    format!("MsgNotify(\"{}\",\"{m}\")", words.replace('%', "?"))
}

fn main(wanted: &Wanted, parts: usize) -> WantedRoutine {
    let m = &wanted.names.module;
    let polishes = wanted.motion.purpose == Purpose::Polish;
    let mut steps = Vec::new();
    let mut say = |code, field, text: String, why| steps.push(Step::say(code, field, &text, why));
    let why = "the program may start only near home or a safe pose";
    say(E1003, "robot.cell.home", format!("start={m}_near({m}_home)"), why);
    for i in 1..=wanted.cell.safe_poses.len() {
        say(E1003, "robot.cell.safe_poses", format!("IF {m}_near({m}_safe{i}) THEN\nstart=TRUE\nENDIF"), why);
    }
    let refuse = message(m, &format!("{m}: not near home or a safe pose"));
    say(E1003, "robot.cell.home", format!("IF NOT start THEN\n{refuse}\n{m}_stop ()\nENDIF"), why);
    let why = "the robot's base, and tool and base of the controller, must be the job's";
    say(E1003, "target.frames", format!("{m}_frames ()"), why);
    let why = "motion begins from the controller's own settings, in the main program only";
    say(E1003, "target", "BAS (#INITMOV,0)".into(), why);
    let percent = (wanted.cell.joint_move_speed * 100.0).round();
    let why = "joint moves keep the cell's share of the rated joint speeds";
    say(E1008, "robot.cell.joint_move_speed", format!("BAS (#VEL_PTP,{percent})"), why);
    let (tool, base, load) = match &wanted.krl.frames {
        KrlFrames::on_controller(n) => {
            (format!("TOOL_DATA[{}]", n.tool), format!("BASE_DATA[{}]", n.base), format!("LOAD_DATA[{}]", n.load))
        }
        KrlFrames::in_program(_) => (format!("{m}_tool"), format!("{m}_base"), format!("{m}_load")),
    };
    say(E1010, "target.frames", format!("$TOOL={tool}"), "the path is written for the job's tool");
    say(E1011, "target.frames", format!("$BASE={base}"), "the path is written for the job's part frame");
    say(E1010, "target.frames", format!("$LOAD={load}"), "a wrong load bends the path");
    say(E1003, "target", "$IPO_MODE=#BASE".into(), "the robot holds the tool, the part stands still");
    say(E1003, "target", "$ORI_TYPE=#VAR".into(), "the tool's orientation is held along every line");
    let crate::job::Dwell::corrective(dwell) = &wanted.job.dwell;
    let why = "the dwell is planned with this acceleration";
    say(E1008, "dwell.acceleration", format!("$ACC.CP={}", dwell.acceleration.0), why);
    let degrees = 180.0 / std::f64::consts::PI;
    let controller = &wanted.krl.controller;
    let speed = controller.orientation_speed.0 * degrees;
    let acceleration = controller.orientation_acceleration.0 * degrees;
    for (variable, value) in
        [("$VEL.ORI1", speed), ("$VEL.ORI2", speed), ("$ACC.ORI1", acceleration), ("$ACC.ORI2", acceleration)]
    {
        let why = "turning the tool must never limit the path";
        say(E1008, "target.controller", format!("{variable}={value}"), why);
    }
    if let LineMotion::linear(linear) = &wanted.krl.motion {
        say(E1003, "target.motion", format!("$APO.CDIS={}", linear.rounding.0 * 1e3), "points are rounded so much");
    }
    say(
        E1003,
        "target.controller.advance",
        format!("$ADVANCE={}", controller.advance),
        "dense points are planned ahead",
    );
    let full_speed = format!("{m}_speed ()");
    let at_full_speed = "dwell scales with the override, which must be 100 %, and T1 cuts speeds";
    if polishes {
        say(E1003, "target", full_speed.clone(), at_full_speed);
    }
    let home_why = "the path starts and ends with a checked joint move from and to home";
    say(E1003, "robot.cell.home", format!("PTP {m}_home"), home_why);
    if polishes {
        let why = "the process is switched on at home, before the first run";
        say(E1012, "robot.cell.process", format!("{m}_on ()"), why);
    }
    for k in 0..parts {
        if polishes {
            say(E1003, "target", full_speed.clone(), at_full_speed);
        }
        if wanted.waits_for_inputs() {
            let why = "the process must still run before every sub-program";
            say(E1012, "robot.cell.process", format!("{m}_inputs ()"), why);
        }
        let progress = message(m, &format!("{m}: part {} of {parts}", k + 1));
        say(E1003, "target", progress, "the operator sees where the program is");
        let call = format!("{} ({m}_d1,{m}_d2,{m}_d3,{m}_d4)", wanted.names.sub_program(k));
        say(E1002, "target", call, "every sub-program is called with the digest, in order");
    }
    if polishes {
        let why = "the process is switched off after the last run, before the way home";
        say(E1012, "robot.cell.process", format!("{m}_off ()"), why);
    }
    if !wanted.motion.runs.is_empty() {
        let moved = message(m, &format!("{m}: not where the path ended"));
        let why = "the way home is checked from the end of the path only, and the robot may have been moved";
        say(E1003, "robot.cell.home", format!("IF NOT {m}_near({m}_end) THEN\n{moved}\n{m}_stop ()\nENDIF"), why);
        say(E1003, "robot.cell.home", format!("PTP {m}_home"), home_why);
    }
    say(E1003, "target", message(m, &format!("{m}: done")), "the operator sees that the program is done");
    WantedRoutine { data: &[("BOOL", "start")], ..procedure(m.clone(), steps) }
}

fn near(wanted: &Wanted) -> WantedRoutine {
    let tolerance = wanted.cell.home_tolerance.0 * (180.0 / std::f64::consts::PI);
    let why = "each joint must lie within `home_tolerance` of a pose that the program may start from";
    let mut steps = Vec::new();
    let mut say = |text: String, why| steps.push(Step::say(E1003, "robot.cell.home_tolerance", &text, why));
    say("WAIT SEC 0".into(), "the robot must be at rest when its place is asked");
    say("found=TRUE".into(), why);
    for j in 1..=6 {
        say(format!("IF ABS($AXIS_ACT.A{j}-wanted.A{j})>{tolerance} THEN\nfound=FALSE\nENDIF"), why);
    }
    say("RETURN found".into(), why);
    WantedRoutine {
        global: true,
        returns: Some("BOOL"),
        parameters: &["wanted"],
        data: &[("AXIS", "wanted"), ("BOOL", "found")],
        ..procedure(wanted.names.own("near"), steps)
    }
}

fn stop(wanted: &Wanted) -> WantedRoutine {
    let why = "a program that may not go on must not go on when start is pressed";
    let step = Step::say(E1003, "target", "LOOP\nHALT\nENDLOOP", why);
    WantedRoutine { global: true, ..procedure(wanted.names.own("stop"), vec![step]) }
}

fn full_speed(wanted: &Wanted) -> WantedRoutine {
    let m = &wanted.names.module;
    let why = "dwell scales with the override: the program waits for 100 %, outside of T1";
    let words = message(m, &format!("{m}: set override to 100, leave T1"));
    let looped = format!("WHILE ($OV_PRO<>100) OR ($MODE_OP==#T1)\n{words}\nWAIT SEC 2\nENDWHILE");
    let steps = vec![
        Step::say(E1003, "target", "WAIT SEC 0", "the override must be asked when the robot is at rest"),
        Step::say(E1003, "target", &looped, why),
    ];
    procedure(wanted.names.own("speed"), steps)
}

fn frames(wanted: &Wanted) -> Vec<WantedRoutine> {
    let m = &wanted.names.module;
    let far = wanted.krl.frame_tolerance.0 * 1e3;
    let far_square = far * far;
    let angle = wanted.krl.frame_angle_tolerance.0 * (180.0 / std::f64::consts::PI);
    let why = "the frames of the controller must be the job's, or the program stops";
    let mut steps = Vec::new();
    let mut say = |text: String| steps.push(Step::say(E1003, "target.frames", &text, why));
    say("differs=FALSE".into());
    let differs = |condition: String, what: &str| {
        format!("IF {condition} THEN\n{}\ndiffers=TRUE\nENDIF", message(m, &format!("{what} differs from the job")))
    };
    say(differs(format!("NOT {m}_same($ROBROOT,{m}_root)"), "$ROBROOT"));
    if let KrlFrames::on_controller(n) = &wanted.krl.frames {
        let (tool, base, load) =
            (format!("TOOL_DATA[{}]", n.tool), format!("BASE_DATA[{}]", n.base), format!("LOAD_DATA[{}]", n.load));
        say(differs(format!("NOT {m}_same({tool},{m}_tool)"), &tool));
        say(differs(format!("NOT {m}_same({base},{m}_base)"), &base));
        let mass = wanted.cell.tcp.load.mass.0 * MASS_SHARE;
        say(differs(format!("ABS({load}.M-{m}_load.M)>{mass}"), &format!("the mass of {load}")));
        say(differs(format!("{m}_far({load}.CM,{m}_load.CM)>{far_square}"), &format!("the centre of {load}")));
    }
    say(format!("IF differs THEN\n{m}_stop ()\nENDIF"));
    let check = WantedRoutine { data: &[("BOOL", "differs")], ..procedure(wanted.names.own("frames"), steps) };

    let turns: Vec<String> = ["A", "B", "C"].iter().map(|k| format!("{m}_turn(found.{k}-wanted.{k})")).collect();
    let why = "frames are compared within `frame_tolerance` and `frame_angle_tolerance`";
    let same = WantedRoutine {
        returns: Some("BOOL"),
        parameters: &["found", "wanted"],
        data: &[("FRAME", "found"), ("FRAME", "wanted"), ("REAL", "angle")],
        ..procedure(
            wanted.names.own("same"),
            vec![
                Step::say(E1003, "target.frame_angle_tolerance", &format!("angle={}", turns.join("+")), why),
                Step::say(
                    E1003,
                    "target.frame_tolerance",
                    &format!("RETURN ({m}_far(found,wanted)<={far_square}) AND (angle<={angle})"),
                    why,
                ),
            ],
        )
    };
    let squares: Vec<String> =
        ["X", "Y", "Z"].iter().map(|k| format!("(found.{k}-wanted.{k})*(found.{k}-wanted.{k})")).collect();
    let why = "places are compared by their distance";
    let distance = WantedRoutine {
        returns: Some("REAL"),
        parameters: &["found", "wanted"],
        data: &[("FRAME", "found"), ("FRAME", "wanted")],
        ..procedure(
            wanted.names.own("far"),
            vec![Step::say(E1003, "target.frame_tolerance", &format!("RETURN {}", squares.join("+")), why)],
        )
    };
    let why = "angles are compared without whole turns";
    let turn = WantedRoutine {
        returns: Some("REAL"),
        parameters: &["angle"],
        data: &[("REAL", "angle")],
        ..procedure(
            wanted.names.own("turn"),
            vec![
                Step::say(
                    E1003,
                    "target.frame_angle_tolerance",
                    "IF ABS(angle)>180 THEN\nRETURN ABS(ABS(angle)-360)\nENDIF",
                    why,
                ),
                Step::say(E1003, "target.frame_angle_tolerance", "RETURN ABS(angle)", why),
            ],
        )
    };
    vec![check, same, distance, turn]
}

fn process(wanted: &Wanted) -> Vec<WantedRoutine> {
    let m = &wanted.names.module;
    let (mut on, mut waits, mut off) = (Vec::new(), Vec::new(), Vec::new());
    let field = "robot.cell.process";
    let say = |steps: &mut Vec<Step>, text: String, why| steps.push(Step::say(E1012, field, &text, why));
    match &wanted.cell.process {
        Process::manual(_) => {
            for (fact, field) in operator_facts(wanted) {
                let why = "the operator sees which part it is and how the wheel must turn";
                on.push(Step::say(E1012, field, &message(m, &fact), why));
            }
            let why = "the operator switches wheel and fluid on, and confirms";
            say(&mut on, message(m, &format!("{m}: switch wheel and fluid on")), why);
            say(&mut on, message(m, "wait until they run steadily, press start"), why);
            say(&mut on, "HALT".into(), why);
            let moved = message(m, &format!("{m}: not at home"));
            let check = format!("IF NOT {m}_near({m}_home) THEN\n{moved}\n{m}_off ()\n{m}_stop ()\nENDIF");
            say(&mut on, check, "nobody may have moved the robot meanwhile");
            let why = "the operator switches wheel and fluid off, and confirms";
            say(&mut off, message(m, &format!("{m}: switch wheel and fluid off")), why);
            say(&mut off, message(m, "then press start"), why);
            say(&mut off, "HALT".into(), why);
        }
        Process::signals(signals) => {
            let value = |active: Level, on: bool| if (active == Level::high) == on { "TRUE" } else { "FALSE" };
            // A signal without a number gives a statement that nothing fulfils.
            let number = |number: Option<i64>| number.map_or("none".to_string(), |n| n.to_string());
            for output in &signals.outputs {
                let why = "outputs are switched on in the order of the job, each with its time to settle";
                say(&mut on, format!("$OUT[{}]={}", number(output.number), value(output.active, true)), why);
                say(&mut on, format!("WAIT SEC {}", output.settle.0), why);
            }
            if wanted.waits_for_inputs() {
                say(&mut on, format!("{m}_inputs ()"), "the process must run before the path begins");
            }
            for input in &signals.inputs {
                let why = "an input that does not come ends the program, process off";
                let (number, missing) = (number(input.number), value(input.active, false));
                // Looked at ten times a second.
                let looks = (input.wait_at_most.0 * 10.0 - 1e-9).ceil().max(1.0);
                say(&mut waits, "looks=0".into(), why);
                let looked = format!(
                    "WHILE ($IN[{number}]=={missing}) AND (looks<{looks})\nWAIT SEC 0.1\nlooks=looks+1\nENDWHILE"
                );
                say(&mut waits, looked, why);
                let name: String = input
                    .name
                    .chars()
                    .map(|c| if (c == ' ' || c.is_ascii_graphic()) && c != '"' && c != '\\' { c } else { '?' })
                    .collect();
                let late = message(m, &format!("{name} did not come"));
                say(
                    &mut waits,
                    format!("IF $IN[{number}]=={missing} THEN\n{late}\n{m}_off ()\n{m}_stop ()\nENDIF"),
                    why,
                );
            }
            let why = "outputs are switched off in the reverse order, with the robot at rest";
            say(&mut off, "WAIT SEC 0".into(), why);
            for output in signals.outputs.iter().rev() {
                say(&mut off, format!("$OUT[{}]={}", number(output.number), value(output.active, false)), why);
            }
        }
    }
    let mut all = vec![
        procedure(wanted.names.own("on"), on),
        WantedRoutine { global: true, ..procedure(wanted.names.own("off"), off) },
    ];
    if wanted.waits_for_inputs() {
        all.push(WantedRoutine { data: &[("INT", "looks")], ..procedure(wanted.names.own("inputs"), waits) });
    }
    all
}

/// What the operator must be shown before the process is switched on, in lines of 40 characters, and the fields that say
/// it. A character that a text cannot hold as it is becomes a question mark.
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
}
