//! The proof of RAPID programs: hand edits that matter are caught and named, hand edits that do not are accepted.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

mod program;

use polishc::diagnostics::Problem;
use polishc::job::{Job, Plane};
use polishc::motion::{Checked, Motion, Purpose};
use polishc::target::{self, Draft, Program, ProgramFile};
use polishc::verify;
use program::{curved, job_with, plan, raster};
use proptest::prelude::*;
use serde_json::json;
use std::sync::LazyLock;

struct Built {
    job: Job,
    motion: Checked<Motion>,
    program: Program,
}

/// A program and what it came from.
fn build(changes: &[(&str, serde_json::Value)], lines: usize, points: usize, purpose: Purpose) -> Built {
    let job = job_with(changes);
    let motion = plan(&job, curved(raster(lines, points)), purpose);
    let draft = target::emit("flat_340", &motion, &job).unwrap_or_else(|p| panic!("{p:?}"));
    Built { job, motion, program: draft.0 }
}

/// 6 lines of 11 points in 3 modules.
static SMALL: LazyLock<Built> =
    LazyLock::new(|| build(&[("/target/rapid/controller/module_points", json!(25))], 6, 11, Purpose::Polish));

fn on_controller() -> Built {
    let changes = [("/target/rapid/frames", json!("on_controller"))];
    build(&changes, 2, 5, Purpose::Polish)
}

fn check(built: &Built, program: &Program) -> Vec<Problem> {
    verify::check(program, &built.motion, &built.job, &Plane {})
}

fn text(program: &Program, file: usize) -> String {
    String::from_utf8(program.files[file].bytes.clone()).expect("ASCII")
}

/// The program with the text of one file replaced.
fn with_text(program: &Program, file: usize, text: String) -> Program {
    let mut edited = program.clone();
    edited.files[file].bytes = text.into_bytes();
    edited
}

/// The program with one line of one file changed; lines count from 1.
fn with_line(program: &Program, file: usize, line: usize, edit: impl Fn(&str) -> String) -> Program {
    let text = text(program, file);
    let lines: Vec<String> =
        text.split("\r\n").enumerate().map(|(i, l)| if i + 1 == line { edit(l) } else { l.to_string() }).collect();
    let edited = lines.join("\r\n");
    assert_ne!(text, edited, "the edit of line {line} must change something: {}", lines[line - 1]);
    with_text(program, file, edited)
}

/// The program with `from` replaced by `to` where it first stands.
fn replaced(program: &Program, file: usize, from: &str, to: &str) -> Program {
    let text = text(program, file);
    assert!(text.contains(from), "`{from}` does not stand in file {file}");
    with_text(program, file, text.replacen(from, to, 1))
}

/// The line, from 1, of the `n`th `MoveL` of a file.
fn move_line(program: &Program, file: usize, n: usize) -> usize {
    let text = text(program, file);
    let mut moves = text.split("\r\n").enumerate().filter(|(_, line)| line.contains("MoveL"));
    moves.nth(n).expect("so many moves").0 + 1
}

/// The line, from 1, of the first line of a file that holds `words`.
fn line_of(program: &Program, file: usize, words: &str) -> usize {
    text(program, file).split("\r\n").position(|line| line.contains(words)).expect("the words") + 1
}

/// A move taken apart: its numbers in the order of the text (x y z, q1 to q4, confdata, 9E9 six times, speeds).
fn edit_number(line: &str, index: usize, edit: impl Fn(f64) -> String) -> String {
    let mut out = String::new();
    let mut number = String::new();
    let mut count = 0;
    let body = line.find('[').expect("a move");
    let (head, rest) = line.split_at(body);
    out.push_str(head);
    for c in rest.chars() {
        if c.is_ascii_digit() || matches!(c, '.' | '-' | 'E') && !out.ends_with(|c: char| c.is_ascii_alphabetic()) {
            number.push(c);
            continue;
        }
        if !number.is_empty() {
            if count == index {
                out.push_str(&edit(number.parse().expect("a number")));
            } else {
                out.push_str(&number);
            }
            count += 1;
            number.clear();
        }
        out.push(c);
    }
    out
}

fn verifies(built: &Built) {
    let found = check(built, &built.program);
    assert_eq!(found, [], "the emitted program must verify");
}

#[test]
fn emitted_programs_verify() {
    verifies(&SMALL);
    verifies(&on_controller());
    verifies(&build(&[], 2, 5, Purpose::DryRun));
    let manual = json!({"manual": {"interlock": "relay K3"}});
    verifies(&build(&[("/robot/cell/process", manual)], 3, 4, Purpose::Polish));
    let inertia = json!({"x": 0.4, "y": 0.5, "z": 0.25});
    verifies(&build(&[("/robot/cell/tcp/load/inertia", inertia)], 2, 5, Purpose::Polish));
    let small = [
        ("/target/rapid/controller/position_decimals", json!(3)),
        ("/target/rapid/controller/quaternion_decimals", json!(6)),
        ("/target/rapid/controller/speed_decimals", json!(3)),
        ("/target/rapid/zone", json!("fine")),
        ("/robot/cell/safe_poses", json!([])),
    ];
    verifies(&build(&small, 3, 7, Purpose::Polish));
}

#[test]
fn verify_gives_the_proof() {
    let draft = Draft(SMALL.program.clone());
    let verified = verify::verify(draft, &SMALL.motion, &SMALL.job, &Plane {}).expect("the emitted program");
    assert_eq!(*verified, SMALL.program);
    let draft = Draft(replaced(&SMALL.program, 0, "ConfL\\Off", "ConfL\\On"));
    assert!(verify::verify(draft, &SMALL.motion, &SMALL.job, &Plane {}).is_err());
}

/// A name, the edited program, the code that must be among the problems, and words that must be in its message.
type Edit = (&'static str, Program, &'static str, &'static [&'static str]);

fn hand_edits() -> Vec<Edit> {
    let p = &SMALL.program;
    // The sixth point of the first line of the second module: line 3 of the path, point 28.
    let line = move_line(p, 2, 6);
    let number = |index: usize, edit: &dyn Fn(f64) -> String| with_line(p, 2, line, |l| edit_number(l, index, edit));
    let point = &["Flat340_002.mod", "point 28 of 66 (line 3, x = 0"][..];
    let swap = |a: usize| {
        let text = text(p, 2);
        let mut lines: Vec<&str> = text.split("\r\n").collect();
        lines.swap(a - 1, a);
        with_text(p, 2, lines.join("\r\n"))
    };
    let without = |line: usize| {
        let text = text(p, 2);
        let mut lines: Vec<&str> = text.split("\r\n").collect();
        lines.remove(line - 1);
        with_text(p, 2, lines.join("\r\n"))
    };
    let twice =
        |line: usize| with_line(p, 2, line, |l| format!("{l}\r\n{}", edit_number(l, 0, |x| format!("{}", x + 2.0))));
    let mirrored = {
        let text = text(p, 1);
        let lines: Vec<String> = text
            .split("\r\n")
            .map(|l| if l.contains("MoveL") { edit_number(l, 0, |x| format!("{}", -x)) } else { l.to_string() })
            .collect();
        with_text(p, 1, lines.join("\r\n"))
    };
    vec![
        (
            "sign of x flipped",
            with_line(p, 2, move_line(p, 2, 5), |l| edit_number(l, 0, |x| format!("{}", -x))),
            "E1005",
            &["Flat340_002.mod", "point 27 of 66 (line 3, x = -4", "x = 3.996,", "7.996 mm from where"],
        ),
        ("contact 2 um high", number(2, &|z| format!("{}", z + 0.002)), "E1005", point),
        ("quaternion denormalised", number(4, &|q| format!("{}", q * 1.001)), "E1007", point),
        ("orientation off by 0.02 deg", number(3, &|q| format!("{}", q + 2e-4)), "E1014", point),
        ("confdata digit", number(9, &|c| format!("{}", c + 1.0)), "E1006", point),
        ("external axis", number(11, &|_| "0".into()), "E1006", point),
        ("speed +0.1 %", number(17, &|v| format!("{}", v * 1.001)), "E1008", point),
        ("orientation speed", number(18, &|_| "50".into()), "E1008", point),
        ("zone", with_line(p, 2, line, |l| l.replace("z0", "z5")), "E1004", point),
        ("stop on the part", with_line(p, 2, line, |l| l.replace("z0", "fine")), "E1004", point),
        (
            "no stop at a line's end",
            with_line(p, 2, move_line(p, 2, 11), |l| l.replace("fine", "z0")),
            "E1004",
            &["point 33 of 66 (line 3"],
        ),
        ("tool name", with_line(p, 2, line, |l| l.replace("tWheel", "tOther")), "E1010", point),
        ("object name", with_line(p, 2, line, |l| l.replace("wPart", "wOther")), "E1011", point),
        ("no object", with_line(p, 2, line, |l| l.replace("\\WObj:=wPart", "")), "E1011", point),
        ("point removed", without(line), "E1013", &["point 28 of 66 (line 3, x = 0", "missing"]),
        ("point put in", twice(line), "E1013", &["a move to x = 2, y = -0.2499, z = 1 mm is not planned", "line 3"]),
        ("two points swapped", swap(line), "E1013", &["point 28 of 66", "point 29 of 66", "swapped"]),
        ("mirrored x", mirrored, "E1005", &["Flat340_001.mod", "point 1 of 66 (line 1, x = -20", "x = 19.98,"]),
        (
            "start joint",
            with_line(p, 1, move_line(p, 1, 0) - 1, |l| edit_number(l, 3, |j| format!("{}", j + 0.01))),
            "E1006",
            &["the approach of run 1", "joint 4"],
        ),
        (
            "other turn of joint 6",
            with_line(p, 1, move_line(p, 1, 0) - 1, |l| edit_number(l, 5, |j| format!("{}", j + 360.0))),
            "E1006",
            &["the approach of run 1", "joint 6"],
        ),
        ("joint move slower", replaced(p, 1, "\\T:=", "\\T:=9"), "E1008", &["the approach of run 1", "time"]),
        ("retract removed", without(move_line(p, 2, 23)), "E1013", &["the retract of run 2", "missing"]),
        (
            "digest of a module",
            replaced(p, 2, "_digest<>\"", "_digest<>\"0"),
            "E1009",
            &["Flat340_002.mod", "Flat340_digest<>"],
        ),
        (
            "digest of the main module",
            replaced(p, 0, "_digest:=\"", "_digest:=\"0"),
            "E1009",
            &["Flat340.mod", "digest"],
        ),
        (
            "moves before the digest",
            {
                let line = move_line(p, 2, 0);
                let text = text(p, 2);
                let mut lines: Vec<&str> = text.split("\r\n").collect();
                let first = lines.remove(line - 1);
                lines.insert(4, first);
                with_text(p, 2, lines.join("\r\n"))
            },
            "E1003",
            &["before the digest is compared"],
        ),
        ("ConfL", replaced(p, 0, "ConfL\\Off", "ConfL\\On"), "E1003", &["Flat340.mod", "`ConfL\\On`", "`ConfL\\Off`"]),
        ("SingArea", replaced(p, 0, "SingArea\\Off", "SingArea\\Wrist"), "E1003", &["`SingArea\\Off`"]),
        ("ConfL removed", replaced(p, 0, "ConfL\\Off;", ""), "E1003", &["`ConfL\\Off` is missing"]),
        ("override not asked", replaced(p, 0, "<>100 DO", "<>50 DO"), "E1003", &["CSpeedOverride"]),
        (
            "override loop gone",
            replaced(p, 0, "WHILE CSpeedOverride()<>100 DO", "WHILE FALSE DO"),
            "E1003",
            &["`FALSE` stands where"],
        ),
        ("half speed", replaced(p, 0, "VelSet 100,", "VelSet 50,"), "E1003", &["`VelSet 50,5000`"]),
        (
            "home not checked",
            replaced(p, 0, "IF NOT (Flat340_near", "IF FALSE AND (Flat340_near"),
            "E1003",
            &["Flat340_near"],
        ),
        ("home tolerance", replaced(p, 0, "rax_3)<=1", "rax_3)<=10"), "E1003", &["rax_3"]),
        (
            "home joint",
            replaced(p, 0, "Flat340_home:=[[0,-20", "Flat340_home:=[[0,-21"),
            "E1003",
            &["Flat340_home", "joint 2 stands at -21 deg where -20 deg"],
        ),
        ("safe pose", replaced(p, 0, "Flat340_safe_1:=[[10", "Flat340_safe_1:=[[40"), "E1003", &["Flat340_safe_1"]),
        ("tool mass", replaced(p, 0, "[42,[5", "[24,[5"), "E1010", &["`tWheel`", "mass is 24 kg", "the job has 42 kg"]),
        ("centre of gravity", replaced(p, 0, "[42,[5", "[42,[50"), "E1010", &["`tWheel`", "cog.x is 50 mm"]),
        (
            "TCP off by 1 mm",
            replaced(p, 0, "[[200.34,", "[[201.34,"),
            "E1010",
            &["`tWheel`", "tframe.trans.x is 201.3", "the job has 200.34 mm"],
        ),
        (
            "object frame off by 5 mm",
            replaced(p, 0, "[[-150,80,85]", "[[-145,80,85]"),
            "E1011",
            &["`wPart`", "oframe.trans.x is -145 mm", "the job has -150 mm"],
        ),
        (
            "user frame turned",
            replaced(p, 0, "0.00018327", "0.00118327"),
            "E1011",
            &["`wPart`", "uframe.rot is turned"],
        ),
        ("tool on the table", replaced(p, 0, "tWheel:=[TRUE", "tWheel:=[FALSE"), "E1010", &["robhold must be `TRUE`"]),
        ("tool renamed", replaced(p, 0, "tooldata tWheel", "tooldata tWheel2"), "E1010", &["tooldata tWheel"]),
        ("object renamed", replaced(p, 0, "wobjdata wPart", "wobjdata wPart2"), "E1011", &["wobjdata wPart"]),
        ("tool as constant", replaced(p, 0, "PERS tooldata", "CONST tooldata"), "E1010", &["must be `PERS`"]),
        (
            "signal name",
            replaced(p, 0, "SetDO doSpindle,1", "SetDO doSpndle,1"),
            "E1012",
            &["`SetDO doSpndle,1`", "`SetDO doSpindle,1`"],
        ),
        ("signal level", replaced(p, 0, "SetDO doSlurry,0", "SetDO doSlurry,1"), "E1012", &["`SetDO doSlurry,1`"]),
        ("settle time", replaced(p, 0, "WaitTime 3;", "WaitTime 0.3;"), "E1012", &["`WaitTime 0.3`"]),
        ("input not awaited", replaced(p, 0, "MaxTime:=10", "MaxTime:=1000"), "E1012", &["diSpindleOk"]),
        (
            "process never off",
            replaced(p, 0, "Flat340_process_off;\r\n        ! Only", "! Only"),
            "E1012",
            &["`Flat340_process_off` is missing"],
        ),
        ("module skipped", replaced(p, 0, "%\"Flat340_run_002\"%;", ""), "E1002", &["Flat340_run_002"]),
        (
            "module run twice",
            replaced(p, 0, "%\"Flat340_run_002\"%;", "%\"Flat340_run_001\"%;"),
            "E1002",
            &["Flat340_run_001", "Flat340_run_002"],
        ),
        (
            "module of another folder",
            replaced(p, 0, "Load\\Dynamic,\"HOME:", "Load\\Dynamic,\"TEMP:"),
            "E1002",
            &["TEMP:"],
        ),
        (
            "a statement more",
            replaced(p, 0, "PDispOff;", "PDispOff; Reset doSpindle;"),
            "E1003",
            &["`Reset doSpindle`"],
        ),
        (
            "a statement more in a module",
            with_line(p, 2, line, |l| format!("WaitTime 5;\r\n{l}")),
            "E1003",
            &["`WaitTime 5`"],
        ),
        (
            "a routine more",
            replaced(p, 0, "ENDMODULE", "PROC TPWrite()\r\nENDPROC\r\nENDMODULE"),
            "E1003",
            &["routine `TPWrite`"],
        ),
        ("a joint move by way of a name", with_line(p, 2, line, |l| l.replace("MoveL", "MoveJ")), "E1000", &["MOVEJ"]),
        (
            "z0 declared anew",
            replaced(p, 2, "    PROC", "    CONST zonedata z0:=[FALSE,9,9,9,9,9,9];\r\n    PROC"),
            "E1004",
            &["`z0`"],
        ),
        (
            "tool declared anew",
            replaced(p, 2, "    PROC", "    LOCAL PERS tooldata tWheel;\r\n    PROC"),
            "E1000",
            &["LOCAL"],
        ),
        (
            "object hidden by a local",
            replaced(p, 2, "    PROC", "    PERS num wPart:=1;\r\n    PROC"),
            "E1001",
            &["`wPart` hides"],
        ),
        (
            "an unknown name for a target",
            with_line(p, 2, line, |l| {
                let from = l.find("[[").expect("a target");
                let to = l.find("]],").expect("a target") + 2;
                format!("{}pUnknown{}", &l[..from], &l[to..])
            }),
            "E1001",
            &["pUnknown"],
        ),
        ("a module missing", Program { files: p.files[..3].to_vec() }, "E1002", &["`Flat340_003.mod`", "missing"]),
        (
            "another file given",
            {
                let mut edited = p.clone();
                edited.files[3].name = "other.mod".into();
                edited
            },
            "E1002",
            &["Flat340_003.mod"],
        ),
        (
            "digest compared with itself",
            {
                let text = text(p, 2);
                let digest = text.split("_digest<>").nth(1).expect("a digest")[..34].to_string();
                with_text(p, 2, text.replacen(&digest, "Flat340_digest", 1))
            },
            "E1009",
            &["Flat340_002.mod", "Flat340_digest<>Flat340_digest"],
        ),
        (
            "digest compared with a constant of the main module",
            {
                let text = text(p, 2);
                let digest = text.split("_digest<>").nth(1).expect("a digest")[..34].to_string();
                let edited = with_text(p, 2, text.replacen(&digest, "dd", 1));
                replaced(&edited, 0, "    CONST string", &format!("    CONST string dd:={digest};\r\n    CONST string"))
            },
            "E1009",
            &["Flat340_002.mod", "Flat340_digest<>dd"],
        ),
        ("digest that can change", replaced(p, 0, "CONST string", "PERS string"), "E1001", &["`CONST`", "_digest"]),
        (
            "home that can change",
            replaced(p, 0, "CONST jointtarget", "PERS jointtarget"),
            "E1001",
            &["_home", "`CONST`"],
        ),
        ("home as a variable", replaced(p, 0, "CONST jointtarget", "VAR jointtarget"), "E1001", &["_home", "`CONST`"]),
        ("flag that cannot change", replaced(p, 0, "VAR bool", "CONST bool"), "E1001", &["_late", "`VAR`"]),
        ("flag that is kept", replaced(p, 0, "VAR bool", "PERS bool"), "E1001", &["_late", "`VAR`"]),
        (
            "a persistent in a routine",
            replaced(p, 2, "PROC Flat340_run_002()", "PROC Flat340_run_002()\r\n    PERS num n:=1;"),
            "E1001",
            &["`n`", "`CONST`"],
        ),
        (
            "data called as a function of the controller",
            replaced(p, 0, "    VAR bool", "    CONST num CJointT:=1;\r\n    VAR bool"),
            "E1001",
            &["`CJointT`", "controller declares"],
        ),
        (
            "data called as a routine",
            replaced(p, 0, "    VAR bool", "    CONST num Flat340_near:=1;\r\n    VAR bool"),
            "E1001",
            &["`Flat340_near` hides"],
        ),
        (
            "data called as a routine of a module",
            replaced(p, 0, "    VAR bool", "    CONST num Flat340_run_002:=1;\r\n    VAR bool"),
            "E1001",
            &["`Flat340_run_002` is one of the names"],
        ),
        (
            "data called as a signal",
            replaced(p, 0, "PROC main()", "PROC main()\r\n        VAR num doSpindle:=1;"),
            "E1001",
            &["`doSpindle` hides a signal"],
        ),
        (
            "code behind a lone CR",
            with_line(p, 2, line, |l| format!("! nothing\rMoveL pAway,v100,fine,tWheel;\r\n{l}")),
            "E1000",
            &["carriage return"],
        ),
        ("CR CR LF", replaced(p, 2, "ENDPROC\r\n", "ENDPROC\r\r\n"), "E1000", &["carriage return"]),
        (
            "not asked where the path ended",
            replaced(p, 0, "IF NOT Flat340_near(CJointT(),Flat340_end)", "IF FALSE"),
            "E1003",
            &["Flat340.mod", "`FALSE` stands where", "Flat340_end"],
        ),
        (
            "the end of the path elsewhere",
            with_line(p, 0, line_of(p, 0, "jointtarget Flat340_end"), |l| {
                edit_number(l, 0, |j| format!("{}", j + 9.0))
            }),
            "E1003",
            &["Flat340.mod", "`Flat340_end`: joint 1"],
        ),
        (
            "a module begins anywhere",
            replaced(p, 2, "IF NOT Flat340_near(CJointT(),Flat340_from_002)", "IF FALSE"),
            "E1003",
            &["Flat340_002.mod", "Flat340_from_002"],
        ),
        (
            "a module begins at home in place of where it should",
            replaced(p, 2, "CJointT(),Flat340_from_002", "CJointT(),Flat340_home"),
            "E1003",
            &["Flat340_002.mod", "Flat340_from_002"],
        ),
        (
            "the first module begins anywhere",
            replaced(p, 1, "CJointT(),Flat340_home", "CJointT(),CJointT()"),
            "E1003",
            &["Flat340_001.mod", "Flat340_home"],
        ),
        (
            "where a module begins elsewhere",
            with_line(p, 2, line_of(p, 2, "jointtarget Flat340_from_002"), |l| {
                edit_number(l, 0, |j| format!("{}", j + 9.0))
            }),
            "E1003",
            &["Flat340_002.mod", "`Flat340_from_002`: joint 1"],
        ),
        (
            "process left on where a module must not begin",
            {
                let text = text(p, 2);
                let at = text.rfind("            Flat340_process_off;\r\n").expect("the second switching off");
                let rest = &text[at..];
                with_text(
                    p,
                    2,
                    format!("{}{}", &text[..at], rest.replacen("            Flat340_process_off;\r\n", "", 1)),
                )
            },
            "E1003",
            &["Flat340_002.mod"],
        ),
        (
            "moves before the place is compared",
            {
                let from = move_line(p, 2, 0);
                let to = line_of(p, 2, "! The way to the first point");
                let text = text(p, 2);
                let mut lines: Vec<&str> = text.split("\r\n").collect();
                let first = lines.remove(from - 1);
                lines.insert(to - 1, first);
                with_text(p, 2, lines.join("\r\n"))
            },
            "E1003",
            &["before its place is compared"],
        ),
        (
            "inputs not waited for again",
            replaced(
                p,
                0,
                "Flat340_wait_inputs;\r\n        TPWrite \"Flat340: module 2",
                "TPWrite \"Flat340: module 2",
            ),
            "E1012",
            &["`Flat340_wait_inputs` is missing"],
        ),
        ("text after the end", with_text(p, 2, text(p, 2) + "MODULE x ENDMODULE"), "E1000", &["ENDMODULE"]),
        ("not ASCII in a comment", replaced(p, 2, "! run", "! l\u{e4}uft"), "E1000", &["plain ASCII"]),
    ]
}

#[test]
fn hand_edits_that_matter_are_caught_and_named() {
    let (mut shown, mut wrong) = (String::new(), Vec::new());
    for (name, edited, code, words) in hand_edits() {
        let found = check(&SMALL, &edited);
        let named = |p: &&Problem| {
            p.code.as_str() == code && words.iter().all(|word| p.message.contains(word)) && p.field.is_some()
        };
        match found.iter().find(named) {
            Some(first) => {
                shown.push_str(&format!("{name}: {} in all, [{}] {}\n", found.len(), first.code, first.message));
            }
            None => wrong.push(format!("{name}: {code} with {words:?} expected, found {found:#?}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    insta::assert_snapshot!(shown);
}

#[test]
fn frames_on_the_controller_are_compared_as_the_job_says() {
    let built = on_controller();
    let p = &built.program;
    for (name, edited, code, word) in [
        ("TCP", replaced(p, 0, "tframe:=[[200.34", "tframe:=[[201.34"), "E1010", "tframe.trans.x"),
        ("mass", replaced(p, 0, "mass:=42", "mass:=40"), "E1010", "mass is 40 kg"),
        ("object frame", replaced(p, 0, "oframe:=[[-150", "oframe:=[[-155"), "E1011", "oframe.trans.x"),
        ("tolerance of places", replaced(p, 0, "<=0.0025;", "<=25;"), "E1003", "<=25"),
        (
            "mass not compared",
            replaced(p, 0, "IF Abs(tWheel.tload.mass", "IF 0*Abs(tWheel.tload.mass"),
            "E1003",
            "tload.mass",
        ),
        (
            "no stop",
            replaced(p, 0, "IF differs THEN\r\n            EXIT;", "IF differs THEN"),
            "E1003",
            "`EXIT` is missing",
        ),
        ("never compared", replaced(p, 0, "Flat340_check_frames;", ""), "E1003", "Flat340_check_frames"),
        (
            "declared here",
            replaced(
                p,
                0,
                "    CONST string",
                "    PERS wobjdata wPart:=[FALSE,TRUE,\"\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\r\n    CONST string",
            ),
            "E1010",
            "`wPart` is declared here",
        ),
        (
            "tool hidden by a local",
            replaced(
                p,
                0,
                "        VAR bool differs",
                "        VAR tooldata tWheel:=[TRUE,[[200.34,-1.12,312.6],[1,0,0,0]],[42,[5,0,210],[1,0,0,0],0,0,0]];\r\n        VAR bool differs",
            ),
            "E1001",
            "`tWheel` hides",
        ),
        (
            "object hidden by a local",
            replaced(
                p,
                0,
                "        VAR bool differs",
                "        VAR wobjdata WPART:=[FALSE,TRUE,\"\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\r\n        VAR bool differs",
            ),
            "E1001",
            "`WPART` hides",
        ),
        (
            "routine hidden by a local",
            replaced(
                p,
                0,
                "        VAR bool differs",
                "        VAR num Flat340_same_pose:=1;\r\n        VAR bool differs",
            ),
            "E1001",
            "`Flat340_same_pose` hides",
        ),
        (
            "function hidden by a local",
            replaced(p, 0, "        VAR bool differs", "        VAR num abs:=1;\r\n        VAR bool differs"),
            "E1001",
            "`abs` cannot be declared",
        ),
        ("a frame that can change", replaced(p, 0, "CONST pose", "PERS pose"), "E1001", "must be `CONST`"),
        ("flag that cannot change", replaced(p, 0, "VAR bool differs", "CONST bool differs"), "E1003", "must be `VAR`"),
        ("flag", replaced(p, 0, "differs:=FALSE", "differs:=TRUE"), "E1003", "must begin as `FALSE`"),
    ] {
        let found = check(&built, &edited);
        let named = found.iter().any(|p| p.code.as_str() == code && p.message.contains(word));
        assert!(named, "{name}: {found:?}");
    }
}

/// The operator acts on what the screen shows, so that is proved like the moves.
#[test]
fn what_the_operator_is_shown_is_compared() {
    let manual = json!({"manual": {"interlock": "relay K3"}});
    let built = build(&[("/robot/cell/process", manual)], 2, 5, Purpose::Polish);
    verifies(&built);
    let p = &built.program;
    for (name, edited, word) in [
        ("part", replaced(p, 0, "\"part FS340-07\"", "\"part FS340-08\""), "part FS340-07"),
        ("rotation", replaced(p, 0, "\"wheel forward: ", "\"wheel reverse: "), "wheel forward"),
        ("speed", replaced(p, 0, "wheel at 60.000 rpm", "wheel at 90.000 rpm"), "60.000 rpm"),
        ("not shown", replaced(p, 0, "TPWrite \"wheel at 60.000 rpm\";", ""), "60.000 rpm"),
    ] {
        let found = check(&built, &edited);
        let named = found.iter().any(|p| p.code.as_str() == "E1012" && p.message.contains(word));
        assert!(named, "{name}: {found:?}");
    }
}

/// A dry run is first tried slowly; a wait for the full speed put in by hand is a statement too many.
#[test]
fn a_dry_run_may_run_slowly() {
    let dry = build(&[], 2, 5, Purpose::DryRun);
    verifies(&dry);
    let waits = replaced(&dry.program, 0, "VelSet 100,5000;", "VelSet 100,5000;\r\n        Flat340_full_speed;");
    assert!(check(&dry, &waits).iter().any(|p| p.code.as_str() == "E1003" && p.message.contains("full_speed")));
    let unseen = replaced(&dry.program, 1, "IF NOT Flat340_dry_near", "IF Flat340_dry_near");
    assert!(check(&dry, &unseen).iter().any(|p| p.code.as_str() == "E1003" && p.message.contains("_dry_near")));
}

#[test]
fn hand_edits_that_do_not_matter_are_accepted() {
    let p = &SMALL.program;
    let line = move_line(p, 2, 6);
    let negated =
        with_line(p, 2, line, |l| (3..7).fold(l.to_string(), |l, i| edit_number(&l, i, |q| format!("{}", -q))));
    let target_in_a_name = {
        let text = text(p, 2);
        let moved = text.split("\r\n").nth(line - 1).expect("the line").to_string();
        let (from, to) = (moved.find("[[").expect("a target"), moved.find("]],").expect("a target") + 2);
        let edited = text.replace(&moved, &format!("{}pMiddle{}", &moved[..from], &moved[to..])).replacen(
            "    PROC",
            &format!("    CONST robtarget pMiddle:={};\r\n    PROC", &moved[from..to]),
            1,
        );
        with_text(p, 2, edited)
    };
    // Also at the level of the module, as a variable that nothing sets.
    let target_in_a_variable =
        with_text(p, 2, text(&target_in_a_name, 2).replacen("CONST robtarget", "VAR robtarget", 1));
    assert_eq!(check(&SMALL, &target_in_a_variable), []);
    let number_in_a_name = {
        let edited = with_line(p, 2, line, |l| edit_number(l, 17, |_| "nSpeed".into()));
        let speed = {
            let mut speed = String::new();
            edit_number(text(p, 2).split("\r\n").nth(line - 1).expect("the line"), 17, |v| format!("{v}"))
                .split("],[")
                .last()
                .expect("the speeds")
                .split(',')
                .next()
                .expect("a speed")
                .trim_start_matches('[')
                .clone_into(&mut speed);
            speed
        };
        let head = format!("PROC Flat340_run_002()\r\n        VAR num nSpeed:={speed};");
        replaced(&edited, 2, "PROC Flat340_run_002()", &head)
    };
    let all_files = |edit: &dyn Fn(&str) -> String| Program {
        files: (0..p.files.len())
            .map(|i| ProgramFile { name: p.files[i].name.clone(), points: 0, bytes: edit(&text(p, i)).into_bytes() })
            .collect(),
    };
    for (name, edited) in [
        ("quaternion negated", negated),
        ("9E9 as 9E+09", all_files(&|t| t.replace("9E9", "9E+09"))),
        ("9E9 written out", all_files(&|t| t.replace("9E9", "9000000000.0"))),
        ("exponents and idle zeros", replaced(p, 0, "[42,[5", "[4.2E1,[5.000")),
        ("target moved to a constant", target_in_a_name),
        ("speed moved to a variable", number_in_a_name),
        ("VelSet moved to a constant", {
            let moved = replaced(p, 0, "VelSet 100,", "VelSet nFull,");
            replaced(&moved, 0, "    VAR bool", "    CONST num nFull:=1E2;\r\n    VAR bool")
        }),
        ("comments added", with_line(p, 2, line, |l| format!("! the middle\r\n{l} ! of the line"))),
        ("blank lines added", all_files(&|t| t.replace("\r\n", "\r\n\r\n  \t"))),
        ("LF line ends", all_files(&|t| t.replace("\r\n", "\n"))),
        ("all on few lines", all_files(&|t| t.replace(";\r\n", ";"))),
        ("capitals changed", all_files(&|t| t.replace("MoveL", "MOVEL").replace("PROC", "proc"))),
        ("spaces between tokens", all_files(&|t| t.replace(",", " , ").replace(":=", " := "))),
        ("files in another order", Program { files: p.files.iter().rev().cloned().collect() }),
    ] {
        assert_eq!(check(&SMALL, &edited), [], "{name}");
    }
}

#[test]
fn a_program_of_another_purpose_is_not_taken() {
    let dry = build(&[("/target/rapid/controller/module_points", json!(25))], 6, 11, Purpose::DryRun);
    assert!(check(&SMALL, &dry.program).iter().all(|p| p.code.as_str() == "E1002"));
    assert!(!check(&dry, &SMALL.program).is_empty());
}

#[test]
fn a_program_of_another_job_is_not_taken() {
    let other = build(
        &[("/target/rapid/controller/module_points", json!(25)), ("/robot/cell/tcp/load/mass", json!(41.0))],
        6,
        11,
        Purpose::Polish,
    );
    let found = check(&SMALL, &other.program);
    assert!(found.iter().any(|p| p.code.as_str() == "E1009") && found.iter().any(|p| p.code.as_str() == "E1010"));
}

#[test]
fn many_differences_are_counted() {
    let edited = with_text(&SMALL.program, 1, text(&SMALL.program, 1).replace(",z0,", ",z1,"));
    let found = check(&SMALL, &edited);
    // 2 lines of 11 points in the first module, of which 9 each are passed on the fly.
    assert_eq!(found.len(), verify::MOST_DIFFERENCES);
    assert_eq!(found[9].notes, ["8 more differences are not shown"]);
}

#[test]
fn truncated_programs_are_refused() {
    for file in 0..SMALL.program.files.len() {
        let whole = &SMALL.program.files[file].bytes;
        // Up to the `ENDMODULE` at the end, which is all that may be missing of its line end.
        for length in (0..whole.len() - 2).step_by(97).chain([whole.len() - 3]) {
            let mut edited = SMALL.program.clone();
            edited.files[file].bytes.truncate(length);
            assert!(!check(&SMALL, &edited).is_empty(), "{length} bytes of file {file}");
        }
    }
}

#[test]
fn deep_and_long_texts_end_in_an_error() {
    for body in [
        "(".repeat(100_000),
        "[".repeat(100_000),
        format!("x:={}1;", "-".repeat(100_000)),
        format!("x:=1{};", "+1".repeat(100_000)),
        "IF TRUE THEN ".repeat(100_000),
        format!("CONST num a:=b; {}", "x;".repeat(100)),
    ] {
        let edited = with_text(&SMALL.program, 2, format!("MODULE m PROC p() {body} ENDPROC ENDMODULE"));
        assert!(!check(&SMALL, &edited).is_empty());
    }
    // Names of lists of names, which would grow without end.
    let mut data = String::from("CONST num a0:=1;");
    for i in 1..20 {
        let items = vec![format!("a{}", i - 1); 50].join(",");
        data.push_str(&format!("CONST num a{i}:=[{items}];"));
    }
    let edited = replaced(&SMALL.program, 2, "    PROC", &format!("    {data}\r\n    PROC"));
    assert!(!check(&SMALL, &edited).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300), file in 0usize..4) {
        let mut edited = SMALL.program.clone();
        edited.files[file].bytes = bytes;
        prop_assert!(!check(&SMALL, &edited).is_empty());
    }

    #[test]
    fn random_edits_never_panic(
        file in 0usize..4,
        edits in proptest::collection::vec((any::<prop::sample::Index>(), 0u8..128), 1..4),
    ) {
        let mut edited = SMALL.program.clone();
        for (place, byte) in edits {
            let bytes = &mut edited.files[file].bytes;
            let at = place.index(bytes.len());
            bytes[at] = byte;
        }
        let _ = check(&SMALL, &edited);
    }

    /// One digit of a move changed to another always changes the motion, except beyond what single precision keeps.
    #[test]
    fn a_digit_of_a_move_changed_is_caught(
        file in 1usize..4, place in any::<prop::sample::Index>(), digit in b'0'..=b'9',
    ) {
        let mut edited = SMALL.program.clone();
        let bytes = &mut edited.files[file].bytes;
        let text = std::str::from_utf8(bytes).expect("ASCII").to_string();
        let digits: Vec<usize> = text
            .match_indices("MoveL [[")
            .flat_map(|(from, _)| {
                let to = from + text[from..].find(",t").expect("the tool");
                // Not the digits of a quaternion: its last decimals move the tool by less than the tolerance.
                let quaternion = from + text[from..].find("],[").expect("the quaternion");
                let confdata = quaternion + 3 + text[quaternion + 3..].find("],[").expect("the confdata");
                (from..to).filter(move |i| *i < quaternion || *i > confdata)
            })
            .filter(|i| text.as_bytes()[*i].is_ascii_digit())
            .collect();
        let at = digits[place.index(digits.len())];
        prop_assume!(bytes[at] != digit);
        bytes[at] = digit;
        let before: f64 = number_around(&text, at);
        let after: f64 = number_around(std::str::from_utf8(bytes).expect("ASCII"), at);
        // A coordinate may change by less than the 1 um that the proof allows.
        prop_assume!((before - after).abs() > 0.0015);
        prop_assert!(!check(&SMALL, &edited).is_empty());
    }
}

/// The number that the byte at `at` stands in.
fn number_around(text: &str, at: usize) -> f64 {
    let of_number = |c: u8| c.is_ascii_digit() || matches!(c, b'.' | b'-' | b'E' | b'+');
    let bytes = text.as_bytes();
    let from = (0..at).rev().take_while(|i| of_number(bytes[*i])).last().unwrap_or(at);
    let to = (at..bytes.len()).find(|i| !of_number(bytes[*i])).unwrap_or(bytes.len());
    text[from..to].parse().unwrap_or(f64::INFINITY)
}
