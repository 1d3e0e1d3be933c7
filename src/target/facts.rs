//! What a program says of itself to people, whatever its language.
//!
//! In: the job and its motion. Out: sentences for the head of the main program, and the lines that the operator compares
//! before the process is switched on.

use crate::job::{Job, LineMotion, Process, RobotCell, SpinMeasured, Target, Tool, Unchecked, WheelRotation};
use crate::motion::{Motion, Purpose};

/// Comments at the head of the main program, one a line. `base` is the robot's base in the world as the language writes
/// it, `files` how many files hold the path, in the language's words (`modules: 3`).
pub fn header(
    name: &str,
    motion: &Motion,
    job: &Job,
    cell: &RobotCell,
    digest: &str,
    base: &str,
    files: &str,
) -> Vec<String> {
    let part = &job.workpiece;
    let mut lines = Vec::new();
    if motion.purpose == Purpose::DryRun {
        let height = cell.travel.height.0 * 1e3;
        lines.push(format!("DRY RUN: lifted {height} mm off the part, process off, slow."));
    }
    lines.push(format!("polishc {}: job {name}, part {}", env!("CARGO_PKG_VERSION"), part.part));
    if let Some(mark) = &part.x_mark {
        lines.push(format!("+x of the part: {mark}"));
    }
    lines.push(match &job.tool {
        Tool::mrf_wheel(wheel) => {
            let rotation = match wheel.rotation {
                WheelRotation::forward => "forward (the fluid is dragged along +x of the tool at the contact)",
                WheelRotation::reverse => "reverse (the fluid is dragged along -x of the tool at the contact)",
            };
            format!("tool: wheel turns {rotation}, {:.3} rpm", rpm(wheel.speed.0))
        }
        Tool::planetary_pad(_) | Tool::bonnet(_) => {
            format!("tool: {}; senses seen from the tool side", turns(&job.tool).join(", "))
        }
    });
    lines.push(format!("points: {}, runs: {}, {files}", motion.position.len(), motion.runs.len()));
    lines.push(format!("digest {digest}"));
    lines.push(format!("planned with the robot's base frame at {base} in the world: compare it by hand"));
    let process = match &cell.process {
        _ if motion.purpose == Purpose::DryRun => "off".to_string(),
        Process::manual(manual) => {
            format!("switched by the operator off the part; interlock at a protective stop: {}", manual.interlock)
        }
        Process::signals(signals) => {
            format!("switched by signals off the part; interlock at a protective stop: {}", signals.interlock)
        }
    };
    lines.push(format!("process: {process}"));
    lines.push(format!("not checked by the compiler: {}", unchecked(job).join(", ")));
    lines.push(
        "Planned with a kinematic model, not controller-verified. Generated: edit the job, not this text.".into(),
    );
    lines
}

/// What the compiler does not check: what the job lists, and what the robot leaves unknown.
pub fn unchecked(job: &Job) -> Vec<&'static str> {
    let mut all: Vec<&str> = job.unchecked.iter().flatten().map(|one: &Unchecked| one.name()).collect();
    if job.robot.as_ref().is_some_and(|robot| robot.cell.is_some() && robot.wrist_inertia.is_none()) {
        all.push("wrist inertia");
    }
    all
}

/// What every report repeats: no controller has run the program for us, and what of it stands on a model.
pub fn note(job: &Job) -> &'static str {
    match &job.target {
        Some(Target::krl(krl)) if matches!(krl.motion, LineMotion::spline(_)) => {
            "not controller-verified; the way between the points of a SPLINE block is a model, not KUKA's own"
        }
        _ => "not controller-verified",
    }
}

/// Characters of a line that the operator's screen surely shows.
const SCREEN_LENGTH: usize = 40;

/// What the operator compares before switching the process on: the part, and how the tool must turn. Each line is fit for
/// a text in quotes; what is not plain ASCII, or would end the text, is shown as a question mark.
pub fn operator(job: &Job) -> Vec<String> {
    let part: Vec<char> = plain(&format!("part {}", job.workpiece.part)).chars().collect();
    let mut facts: Vec<String> = part.chunks(SCREEN_LENGTH).map(|line| line.iter().collect()).collect();
    facts.extend(turns(&job.tool));
    facts
}

/// How the tool must turn and press, a fact a line. Senses of a pad and a bonnet are those seen from the tool side.
fn turns(tool: &Tool) -> Vec<String> {
    let turn = |what: &str, speed: f64, against: &str| {
        let sense = if speed < 0.0 { "clockwise" } else { "counter-clockwise" };
        format!("{what} {:.3} rpm {sense}{against}", rpm(speed.abs()))
    };
    match tool {
        Tool::mrf_wheel(wheel) => vec![
            match wheel.rotation {
                WheelRotation::forward => "wheel forward: fluid along +x of tool".into(),
                WheelRotation::reverse => "wheel reverse: fluid along -x of tool".into(),
            },
            format!("wheel at {:.3} rpm", rpm(wheel.speed.0)),
        ],
        Tool::planetary_pad(pad) => vec![
            turn("orbit", pad.orbit.counterclockwise(), ""),
            turn(
                "spin",
                pad.spin.counterclockwise(),
                match pad.spin_measured {
                    SpinMeasured::on_arm => " on arm",
                    SpinMeasured::absolute => "",
                },
            ),
            format!("force {:.3} N", pad.force.0),
        ],
        Tool::bonnet(bonnet) => vec![
            turn("bonnet", bonnet.spin.counterclockwise(), ""),
            format!("bonnet at {:.4} MPa", bonnet.pressure.0 * 1e-6),
        ],
    }
}

fn rpm(speed: f64) -> f64 {
    speed * 30.0 / std::f64::consts::PI
}

/// Words of the job as a text in quotes can hold them.
pub fn plain(words: &str) -> String {
    words.chars().map(|c| if matches!(c, ' '..='~') && c != '"' && c != '\\' { c } else { '?' }).collect()
}
