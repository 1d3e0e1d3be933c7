//! The proof of KRL programs: hand edits that matter are caught and named, hand edits that do not are accepted.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

mod program;

use polishc::diagnostics::Problem;
use polishc::job::{Job, Plane};
use polishc::motion::{Checked, Motion, Purpose};
use polishc::target::{self, Draft, Program, ProgramFile};
use polishc::verify;
use program::{curved, krl_job_with, plan, raster};
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
    let job = krl_job_with(changes);
    let motion = plan(&job, raster(lines, points), purpose);
    let draft = target::emit("flat_340", &motion, &job).unwrap_or_else(|p| panic!("{p:?}"));
    Built { job, motion, program: draft.0 }
}

/// 6 lines of 11 points in 3 sub-programs: 32 lines of a file's frame and 10 of a run's leave 58, a line takes 13 of
/// them, and two runs are too much for one file.
static SMALL: LazyLock<Built> =
    LazyLock::new(|| build(&[("/target/krl/controller/file_lines", json!(100))], 9, 11, Purpose::Polish));

static LINEAR: LazyLock<Built> = LazyLock::new(|| {
    let changes = [
        ("/target/krl/frames", json!({"on_controller": {"tool": 3, "base": 7, "load": 4}})),
        ("/target/krl/motion", json!({"linear": {"rounding": 3e-4}})),
    ];
    build(&changes, 2, 7, Purpose::Polish)
});

fn check(built: &Built, program: &Program) -> Vec<Problem> {
    verify::check(program, &built.motion, &built.job, &Plane {})
}

fn verifies(built: &Built) {
    let found = check(built, &built.program);
    assert_eq!(found, [], "the emitted program must verify");
}

fn index(program: &Program, name: &str) -> usize {
    program.files.iter().position(|file| file.name == name).unwrap_or_else(|| panic!("no file {name}"))
}

fn text(program: &Program, name: &str) -> String {
    String::from_utf8(program.files[index(program, name)].bytes.clone()).expect("ASCII")
}

/// The program with the text of one file replaced.
fn with_text(program: &Program, name: &str, text: String) -> Program {
    let mut edited = program.clone();
    edited.files[index(program, name)].bytes = text.into_bytes();
    edited
}

/// The program with `from` replaced by `to` where it first stands in a file.
fn replaced(program: &Program, name: &str, from: &str, to: &str) -> Program {
    let text = text(program, name);
    assert!(text.contains(from), "`{from}` does not stand in {name}");
    with_text(program, name, text.replacen(from, to, 1))
}

/// The program with one line of a file changed: the `n`th, from 0, that holds `words`.
fn with_line(program: &Program, name: &str, (words, n): (&str, usize), edit: impl Fn(&str) -> String) -> Program {
    let text = text(program, name);
    let mut lines: Vec<String> = text.split("\r\n").map(str::to_string).collect();
    let at = lines.iter().enumerate().filter(|(_, line)| line.contains(words)).nth(n).expect("so many lines").0;
    let new = edit(&lines[at]);
    assert_ne!(lines[at], new, "the edit must change something");
    lines[at] = new;
    with_text(program, name, lines.join("\r\n"))
}

/// A line with the number behind `label` edited: `X `, `A `, `$VEL.CP=`.
fn number(line: &str, label: &str, edit: impl Fn(f64) -> String) -> String {
    let at = line.find(label).unwrap_or_else(|| panic!("no `{label}` in {line}")) + label.len();
    let end = line[at..].find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-'))).map_or(line.len(), |k| at + k);
    format!("{}{}{}", &line[..at], edit(line[at..end].parse().expect("a number")), &line[end..])
}

const PART: &str = "Flat340_002.src";
const MAIN: &str = "Flat340.src";
const DATA: &str = "Flat340.dat";

#[test]
fn emitted_programs_verify() {
    verifies(&SMALL);
    verifies(&LINEAR);
    verifies(&build(&[], 2, 5, Purpose::DryRun));
    verifies(&build(&[], 3, 2, Purpose::Polish));
    let manual = json!({"manual": {"interlock": "relay K3"}});
    verifies(&build(&[("/robot/cell/process", manual)], 3, 4, Purpose::Polish));
    let inertia = json!({"x": 0.4, "y": 0.5, "z": 0.25});
    verifies(&build(&[("/robot/cell/tcp/load/inertia", inertia)], 2, 5, Purpose::Polish));
    let small = [
        ("/target/krl/controller/position_decimals", json!(3)),
        ("/target/krl/controller/angle_decimals", json!(4)),
        ("/target/krl/controller/speed_digits", json!(5)),
        ("/robot/cell/safe_poses", json!([])),
        ("/robot/cell/process/signals/inputs", json!([])),
    ];
    verifies(&build(&small, 3, 7, Purpose::Polish));
}

#[test]
fn verify_gives_the_proof() {
    let verified =
        verify::verify(Draft(SMALL.program.clone()), &SMALL.motion, &SMALL.job, &Plane {}).expect("the program");
    assert_eq!(*verified, SMALL.program);
    let draft = Draft(replaced(&SMALL.program, MAIN, "$ORI_TYPE=#VAR", "$ORI_TYPE=#CONSTANT"));
    assert!(verify::verify(draft, &SMALL.motion, &SMALL.job, &Plane {}).is_err());
}

/// A name, the edited program, the code that must be among the problems, and words that must be in its message.
type Edit = (&'static str, Program, &'static str, &'static [&'static str]);

/// Edits of one segment of the second file: its third `SPL`, point 5 of the file's first line.
fn edits_of_a_segment(p: &Program) -> Vec<Edit> {
    let spl = ("  SPL {", 2);
    let edit =
        |label: &'static str, change: &dyn Fn(f64) -> String| with_line(p, PART, spl, |l| number(l, label, change));
    let point = &["Flat340_002.src", "point 49 of 99 (line 5, x = -4, y = 0 mm)"][..];
    let moved = |line: &str, by: f64| number(line, "X ", |x| format!("{}", x + by));
    let lines = |order: &dyn Fn(&mut Vec<&str>, usize)| {
        let text = text(p, PART);
        let mut lines: Vec<&str> = text.split("\r\n").collect();
        let at = lines.iter().enumerate().filter(|(_, line)| line.contains(spl.0)).nth(spl.1).expect("a segment").0;
        order(&mut lines, at);
        with_text(p, PART, lines.join("\r\n"))
    };
    vec![
        ("sign of x flipped", edit("X ", &|x| format!("{}", -x)), "E1005", &["point 49 of 99", "mm from where"]),
        ("contact 2 um high", edit("Z ", &|z| format!("{}", z + 0.002)), "E1005", point),
        ("A turned by 0.02 deg", edit("A ", &|a| format!("{}", a + 0.02)), "E1014", point),
        ("B leaning by 0.02 deg", edit("B ", &|b| format!("{}", b + 0.02)), "E1014", point),
        ("status", edit("S ", &|s| format!("{}", s + 4.0)), "E1006", point),
        ("turn", edit("T ", &|t| format!("{}", t + 1.0)), "E1006", point),
        ("speed +0.1 %", edit("$VEL.CP=", &|v| format!("{}", v * 1.001)), "E1008", point),
        ("speed +1 in the seventh digit", edit("$VEL.CP=", &|v| format!("{}", v + 1e-7)), "E1008", point),
        (
            "mm/s where m/s belongs",
            edit("$VEL.CP=", &|v| format!("{}", v * 1e3)),
            "E1008",
            &["point 49 of 99", "it is written in mm/s"],
        ),
        ("no speed", with_line(p, PART, spl, |l| l.split(" WITH").next().expect("a segment").into()), "E1008", point),
        ("another variable", with_line(p, PART, spl, |l| l.replace("$VEL.CP", "$ACC.CP")), "E1000", &["WITH $ACC.CP"]),
        ("C_DIS inside a block", with_line(p, PART, spl, |l| format!("{l} C_DIS")), "E1000", &["`C_DIS`"]),
        (
            "straight inside a block",
            with_line(p, PART, spl, |l| l.replace("SPL", "SLIN")),
            "E1004",
            &["`SLIN`", "`SPL`"],
        ),
        (
            "an output inside a block",
            with_line(p, PART, spl, |l| format!("$OUT[17]=FALSE\r\n{l}")),
            "E1000",
            &["`$OUT` has no place in a `SPLINE` block"],
        ),
        (
            "an unknown name for a target",
            with_line(p, PART, spl, |l| format!("  SPL xUnknown{}", &l[l.find('}').expect("a target") + 1..])),
            "E1001",
            &["xUnknown"],
        ),
        ("no turn", with_line(p, PART, spl, |l| l.replace(",T ", ",E1 ")), "E1001", &["written out"]),
        (
            "a component left out",
            with_line(p, PART, spl, |l| l.replacen(",B 0", "", 1)),
            "E1000",
            &["does not say `B`"],
        ),
        (
            "point removed",
            lines(&|lines, at| {
                lines.remove(at);
            }),
            "E1013",
            &["point 49 of 99", "missing"],
        ),
        (
            "two points swapped",
            lines(&|lines, at| lines.swap(at, at + 1)),
            "E1013",
            &["49 of 99", "50 of 99", "swapped"],
        ),
        (
            "point put in",
            with_line(p, PART, spl, |l| format!("{l}\r\n{}", moved(l, 2.0))),
            "E1013",
            &["a move to x = -2, y = 0, z = 1 mm is not planned"],
        ),
        (
            "segment moved out of its block",
            lines(&|lines, at| {
                let line = lines.remove(at).trim_start();
                let block = (0..at).rev().find(|k| lines[*k] == "SPLINE").expect("a block");
                lines.insert(block, line);
            }),
            "E1000",
            &["`SPL` has its place in a `SPLINE` block only"],
        ),
        (
            "a block broken in two",
            with_line(p, PART, spl, |l| format!("{l}\r\nENDSPLINE\r\nSPLINE")),
            "E1004",
            &["point 49 of 99", "the last of its block where it must be inside"],
        ),
        (
            "a classical move for the run-in",
            with_line(p, PART, ("SLIN {", 0), |l| {
                l.replace("SLIN", "LIN").split(" WITH").next().expect("a move").into()
            }),
            "E1004",
            &["`LIN`"],
        ),
    ]
}

fn hand_edits() -> Vec<Edit> {
    let p = &SMALL.program;
    let mut all = edits_of_a_segment(p);
    let from = "Flat340_002.dat";
    let mirrored = {
        let text = text(p, "Flat340_001.src");
        let flipped = |l: &str| number(l, "X ", |x| format!("{}", -x));
        let lines: Vec<String> =
            text.split("\r\n").map(|l| if l.contains("{X ") { flipped(l) } else { l.to_string() }).collect();
        with_text(p, "Flat340_001.src", lines.join("\r\n"))
    };
    let before_the_digest = {
        let text = text(p, PART);
        let mut lines: Vec<&str> = text.split("\r\n").collect();
        let from = lines.iter().position(|line| line.starts_with("SLIN")).expect("a move");
        let first = lines.remove(from);
        lines.insert(4, first);
        with_text(p, PART, lines.join("\r\n"))
    };
    let files = |names: &[&str]| Program { files: names.iter().map(|name| p.files[index(p, name)].clone()).collect() };
    all.extend::<Vec<Edit>>(vec![
        (
            "mirrored x",
            mirrored,
            "E1005",
            &["Flat340_001.src", "point 1 of 99 (line 1, x = -20", "39.9999 mm from where"],
        ),
        (
            "start joint",
            with_line(p, PART, ("PTP {", 0), |l| number(l, "A4 ", |j| format!("{}", j + 0.01))),
            "E1006",
            &["the approach of run 2", "joint 4"],
        ),
        (
            "other turn of joint 6",
            with_line(p, PART, ("PTP {", 0), |l| number(l, "A6 ", |j| format!("{}", j + 360.0))),
            "E1006",
            &["joint 6"],
        ),
        (
            "a joint move that is rounded",
            with_line(p, PART, ("PTP {", 0), |l| format!("{l} C_PTP")),
            "E1000",
            &["C_PTP"],
        ),
        (
            "retract removed",
            with_line(p, PART, ("Z 51", 1), |_| String::new()),
            "E1013",
            &["the retract of run 2", "missing"],
        ),
        ("digest in a sub-program", replaced(p, PART, "(d1<>", "(d1<>1"), "E1009", &["Flat340_002.src", "d1<>1"]),
        (
            "digest compared with itself",
            with_line(p, PART, ("(d1<>", 0), |l| l.replacen("(d1<>", "(d1<>d1+", 1)),
            "E1009",
            &["d1<>"],
        ),
        (
            "digest in the data",
            with_line(p, DATA, ("Flat340_d2=", 0), |l| number(l, "=", |d| format!("{}", d + 1.0))),
            "E1009",
            &["Flat340.dat", "Flat340_d2"],
        ),
        ("moves before the digest", before_the_digest, "E1003", &["before the digest is compared"]),
        (
            "a sub-program begins anywhere",
            replaced(p, PART, "IF NOT Flat340_near(Flat340_from)", "IF FALSE"),
            "E1003",
            &["Flat340_near(Flat340_from)"],
        ),
        (
            "where a sub-program begins elsewhere",
            with_line(p, from, ("_from=", 0), |l| number(l, "A1 ", |j| format!("{}", j + 9.0))),
            "E1003",
            &["Flat340_002.dat", "joint 1"],
        ),
        (
            "process left on where it must not begin",
            replaced(p, PART, "Flat340_off ()\r\n", ""),
            "E1009",
            &["Flat340_002.src", "Flat340_stop"],
        ),
        ("override asked for 50", replaced(p, MAIN, "$OV_PRO<>100", "$OV_PRO<>50"), "E1003", &["$OV_PRO<>50"]),
        (
            "override set",
            replaced(p, MAIN, "$ADVANCE=5", "$ADVANCE=5\r\n$OV_PRO=100"),
            "E1003",
            &["does not ask for `$OV_PRO=100`"],
        ),
        ("T1 allowed", replaced(p, MAIN, "$MODE_OP==#T1", "$MODE_OP==#T2"), "E1003", &["$MODE_OP==#T2"]),
        (
            "a halt in place of the loop",
            replaced(p, MAIN, "LOOP\r\n    HALT\r\nENDLOOP", "HALT"),
            "E1003",
            &["`HALT` stands where the job asks for `LOOP`"],
        ),
        ("BAS of speed", replaced(p, MAIN, "#VEL_PTP,10", "#VEL_PTP,100"), "E1008", &["BAS(#VEL_PTP,100)"]),
        ("BAS left out", replaced(p, MAIN, "BAS (#INITMOV,0)\r\n", ""), "E1003", &["`BAS(#INITMOV,0)` is missing"]),
        (
            "BAS in a sub-program",
            with_line(p, PART, ("PTP {", 0), |l| format!("BAS (#INITMOV,0)\r\n{l}")),
            "E1003",
            &["does not ask for `BAS(#INITMOV,0)`"],
        ),
        ("tool", replaced(p, MAIN, "$TOOL=Flat340_tool", "$TOOL=TOOL_DATA[1]"), "E1010", &["TOOL_DATA[1]"]),
        ("base", replaced(p, MAIN, "$BASE=Flat340_base", "$BASE=$NULLFRAME"), "E1011", &["$NULLFRAME"]),
        ("load", replaced(p, MAIN, "$LOAD=Flat340_load\r\n", ""), "E1010", &["`$LOAD=Flat340_load` is missing"]),
        ("tool in the world", replaced(p, MAIN, "#BASE", "#TCP"), "E1003", &["#TCP"]),
        ("acceleration", replaced(p, MAIN, "$ACC.CP=0.5", "$ACC.CP=5"), "E1008", &["`$ACC.CP=5`", "`$ACC.CP=0.5`"]),
        ("orientation speed", replaced(p, MAIN, "$VEL.ORI1=200", "$VEL.ORI1=2"), "E1008", &["$VEL.ORI1=2"]),
        (
            "home not asked for",
            replaced(p, MAIN, "IF NOT start THEN", "IF FALSE THEN"),
            "E1003",
            &["`FALSE` stands where"],
        ),
        ("home tolerance", replaced(p, MAIN, ".A3)>1", ".A3)>10"), "E1003", &["A3"]),
        (
            "not asked where the path ended",
            replaced(p, MAIN, "IF NOT Flat340_near(Flat340_end)", "IF NOT TRUE"),
            "E1003",
            &["Flat340_end"],
        ),
        (
            "home elsewhere",
            with_line(p, DATA, ("_home=", 0), |l| number(l, "A2 ", |j| format!("{}", j + 1.0))),
            "E1003",
            &["Flat340_home", "joint 2 stands at -109 deg where -110 deg"],
        ),
        (
            "safe pose",
            with_line(p, DATA, ("_safe1=", 0), |l| number(l, "A1 ", |_| "40".into())),
            "E1003",
            &["Flat340_safe1"],
        ),
        (
            "end of the path elsewhere",
            with_line(p, DATA, ("_end=", 0), |l| number(l, "A1 ", |j| format!("{}", j + 9.0))),
            "E1003",
            &["Flat340_end"],
        ),
        (
            "robot's base",
            with_line(p, DATA, ("_root=", 0), |l| number(l, "X ", |x| format!("{}", x + 1.0))),
            "E1011",
            &["Flat340_root", "X is 11 mm, the job has 10 mm"],
        ),
        (
            "TCP off by 1 mm",
            with_line(p, DATA, ("_tool=", 0), |l| number(l, "X ", |x| format!("{}", x + 1.0))),
            "E1010",
            &["Flat340_tool", "the job has 200.34 mm"],
        ),
        (
            "tool turned",
            with_line(p, DATA, ("_tool=", 0), |l| number(l, "B ", |b| format!("{}", b + 0.1))),
            "E1010",
            &["turned by 0.1000 deg"],
        ),
        (
            "part frame off by 5 mm",
            with_line(p, DATA, ("_base=", 0), |l| number(l, "Y ", |y| format!("{}", y + 5.0))),
            "E1011",
            &["Flat340_base"],
        ),
        ("tool mass", replaced(p, DATA, "{M 42", "{M 24"), "E1010", &["M is 24 kg, the job has 42 kg"]),
        ("centre of gravity", replaced(p, DATA, "CM {X 5,", "CM {X 50,"), "E1010", &["CM.X is 50 mm"]),
        (
            "declared twice",
            with_line(p, DATA, ("_home=", 0), |l| format!("{l}\r\n{l}")),
            "E1001",
            &["`flat340_home` is declared twice"],
        ),
        ("data for all programs", replaced(p, DATA, "DECL AXIS", "DECL GLOBAL AXIS"), "E1000", &["GLOBAL"]),
        (
            "data called as a routine",
            with_line(p, DATA, ("_home=", 0), |l| format!("{l}\r\nDECL INT Flat340_near=1")),
            "E1001",
            &["`Flat340_near` hides"],
        ),
        (
            "data called as a local",
            with_line(p, DATA, ("_home=", 0), |l| format!("{l}\r\nDECL BOOL start")),
            "E1001",
            &["`start` hides"],
        ),
        (
            "a name of the controller",
            with_line(p, DATA, ("_home=", 0), |l| format!("{l}\r\nDECL REAL abs=1")),
            "E1001",
            &["`abs` cannot be declared"],
        ),
        (
            "a name too long",
            with_line(p, DATA, ("_home=", 0), |l| format!("{l}\r\nDECL REAL a23456789b123456789c12345=1")),
            "E1001",
            &["25 characters where 24 fit"],
        ),
        ("a local more", replaced(p, MAIN, "BOOL start", "BOOL start,looks"), "E1001", &["looks"]),
        (
            "output",
            replaced(p, MAIN, "$OUT[17]=TRUE", "$OUT[16]=TRUE"),
            "E1012",
            &["`$OUT[16]=TRUE`", "`$OUT[17]=TRUE`"],
        ),
        ("level of an output", replaced(p, MAIN, "$OUT[18]=FALSE", "$OUT[18]=TRUE"), "E1012", &["$OUT[18]=TRUE"]),
        ("settle time", replaced(p, MAIN, "WAIT SEC 3", "WAIT SEC 0.3"), "E1012", &["WAIT SEC 0.3"]),
        ("input never awaited", replaced(p, MAIN, "looks<100", "looks<0"), "E1012", &["looks<0"]),
        (
            "process never off",
            replaced(p, MAIN, "Flat340_off ()\r\n; Only", "; Only"),
            "E1012",
            &["`Flat340_off()` is missing"],
        ),
        ("sub-program skipped", with_line(p, MAIN, ("Flat340_002 (", 0), |_| String::new()), "E1002", &["Flat340_002"]),
        (
            "sub-program called twice",
            with_line(p, MAIN, ("Flat340_002 (", 0), |l| l.replace("_002", "_001")),
            "E1002",
            &["Flat340_001"],
        ),
        (
            "called with another digest",
            replaced(p, MAIN, "Flat340_001 (Flat340_d1", "Flat340_001 (Flat340_d2"),
            "E1002",
            &["Flat340_d2"],
        ),
        (
            "a statement more",
            with_line(p, PART, ("PTP {", 0), |l| format!("WAIT SEC 5\r\n{l}")),
            "E1003",
            &["`WAIT SEC 5`"],
        ),
        (
            "a routine more",
            with_text(p, MAIN, text(p, MAIN) + "DEF MsgNotify ( )\r\nEND\r\n"),
            "E1003",
            &["routine `MsgNotify`"],
        ),
        ("an interrupt", replaced(p, MAIN, "$ADVANCE=5", "INTERRUPT ON 3"), "E1000", &["INTERRUPT"]),
        ("a circle", with_line(p, PART, ("Z 51", 0), |l| l.replace("SLIN", "CIRC")), "E1000", &["CIRC"]),
        (
            "an unclear condition",
            replaced(p, MAIN, "($OV_PRO<>100) OR ($MODE_OP==#T1)", "$OV_PRO<>100 OR $MODE_OP==#T1"),
            "E1000",
            &["brackets"],
        ),
        (
            "file called otherwise",
            with_line(p, PART, ("DEF ", 0), |l| l.replace("_002", "_003")),
            "E1002",
            &["Flat340_002.src", "`Flat340_003`"],
        ),
        (
            "data file called otherwise",
            replaced(p, from, "DEFDAT Flat340_002", "DEFDAT Flat340_003"),
            "E1002",
            &["Flat340_002.dat"],
        ),
        (
            "a data file missing",
            files(&[MAIN, DATA, "Flat340_001.src", "Flat340_001.dat", PART, "Flat340_003.src", "Flat340_003.dat"]),
            "E1002",
            &["`Flat340_002.dat`", "missing"],
        ),
        (
            "a sub-program missing",
            files(&[MAIN, DATA, "Flat340_001.src", "Flat340_001.dat", PART, from]),
            "E1002",
            &["`Flat340_003.src`", "missing"],
        ),
        (
            "code behind a lone CR",
            with_line(p, PART, ("PTP {", 0), |l| format!("; nothing\rPTP xAway\r\n{l}")),
            "E1000",
            &["carriage return"],
        ),
        ("text after the end", with_text(p, from, text(p, from) + "DECL INT a=1\r\n"), "E1000", &["ENDDAT"]),
        ("not ASCII in a comment", replaced(p, PART, "; run", "; l\u{e4}uft"), "E1000", &["plain ASCII"]),
    ]);
    all
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

/// Frames on the controller by number, and moves in the other form.
#[test]
fn numbers_of_the_controller_and_linear_moves_are_compared() {
    let p = &LINEAR.program;
    let part = "Flat340_001.src";
    for (name, edited, code, word) in [
        ("tool number", replaced(p, MAIN, "$TOOL=TOOL_DATA[3]", "$TOOL=TOOL_DATA[4]"), "E1010", "TOOL_DATA[4]"),
        ("base number", replaced(p, MAIN, "$BASE=BASE_DATA[7]", "$BASE=BASE_DATA[6]"), "E1011", "BASE_DATA[6]"),
        ("load number", replaced(p, MAIN, "$LOAD=LOAD_DATA[4]", "$LOAD=LOAD_DATA[3]"), "E1010", "LOAD_DATA[3]"),
        (
            "another tool compared",
            replaced(p, MAIN, "_same(TOOL_DATA[3]", "_same(TOOL_DATA[4]"),
            "E1003",
            "TOOL_DATA[4]",
        ),
        ("nothing compared", replaced(p, MAIN, "Flat340_frames ()\r\n", ""), "E1003", "Flat340_frames"),
        ("tolerance of places", replaced(p, MAIN, "<=0.0025", "<=25"), "E1003", "<=25"),
        ("tolerance of angles", replaced(p, MAIN, "angle<=0.01", "angle<=1"), "E1003", "angle<=1"),
        ("tolerance of the mass", replaced(p, MAIN, ".M)>0.042", ".M)>42"), "E1003", ".M)>42"),
        ("rounding", replaced(p, MAIN, "$APO.CDIS=0.3", "$APO.CDIS=30"), "E1003", "$APO.CDIS=30"),
        (
            "stop on the part",
            with_line(p, part, ("C_DIS", 2), |l| l.replace(" C_DIS", "")),
            "E1004",
            "`LIN` with `C_DIS`",
        ),
        ("rounding of a line's end", with_line(p, part, ("LIN {", 6), |l| format!("{l} C_DIS")), "E1004", "`LIN`"),
        (
            "another way of rounding",
            with_line(p, part, ("C_DIS", 2), |l| l.replace("C_DIS", "C_VEL")),
            "E1000",
            "C_VEL",
        ),
        (
            "speed of a move",
            with_line(p, part, ("$VEL.CP=", 3), |l| number(l, "=", |v| format!("{}", 1.01 * v))),
            "E1008",
            "speed",
        ),
        (
            "mm/s where m/s belongs",
            with_line(p, part, ("$VEL.CP=", 3), |l| number(l, "=", |v| format!("{}", 1e3 * v))),
            "E1008",
            "it is written in mm/s",
        ),
        ("speed left out", with_line(p, part, ("$VEL.CP=", 3), |_| String::new()), "E1008", "speed"),
        (
            "first speed left out",
            with_line(p, part, ("$VEL.CP=", 0), |_| String::new()),
            "E1008",
            "has no speed of its own",
        ),
    ] {
        let found = check(&LINEAR, &edited);
        let named = found.iter().any(|p| p.code.as_str() == code && p.message.contains(word));
        assert!(named, "{name}: {found:?}");
    }
}

#[test]
fn hand_edits_that_do_not_matter_are_accepted() {
    let p = &SMALL.program;
    let all_files = |edit: &dyn Fn(&str) -> String| Program {
        files: p
            .files
            .iter()
            .map(|file| ProgramFile {
                name: file.name.clone(),
                points: 0,
                bytes: edit(std::str::from_utf8(&file.bytes).expect("ASCII")).into_bytes(),
            })
            .collect(),
    };
    let spl = ("  SPL {", 2);
    let in_a_name = {
        let text = text(p, PART);
        let line = text.split("\r\n").filter(|line| line.contains(spl.0)).nth(spl.1).expect("a segment");
        let (from, to) = (line.find('{').expect("a target"), line.find('}').expect("a target") + 1);
        let edited = with_line(p, PART, spl, |l| format!("{}xMiddle{}", &l[..from], &l[to..]));
        replaced(&edited, "Flat340_002.dat", "ENDDAT", &format!("DECL POS xMiddle={}\r\nENDDAT", &line[from..to]))
    };
    for (name, edited) in [
        ("comments added", with_line(p, PART, spl, |l| format!("; the middle\r\n{l} ; of the line"))),
        ("blank lines added", all_files(&|t| t.replace("\r\n", "\r\n\r\n  \t"))),
        ("LF line ends", all_files(&|t| t.replace("\r\n", "\n"))),
        ("no heads", all_files(&|t| t.lines().filter(|l| !l.starts_with('&')).collect::<Vec<_>>().join("\n"))),
        (
            "capitals changed",
            all_files(&|t| t.replace("SPL ", "spl ").replace("DEF ", "Def ").replace("start", "START")),
        ),
        (
            "spaces between tokens",
            all_files(&|t| {
                let spaced =
                    |l: &str| if l.contains('"') { l.to_string() } else { l.replace(',', " , ").replace("{X", "{ X") };
                t.lines().map(spaced).collect::<Vec<_>>().join("\r\n")
            }),
        ),
        ("idle zeros and exponents", with_line(p, PART, spl, |l| number(l, "$VEL.CP=", |v| format!("{v:.12E}")))),
        ("mass as an exponent", replaced(p, DATA, "{M 42,", "{M 4.2E1,")),
        ("components in another order", with_line(p, PART, spl, |l| l.replace(",S 2", "").replace("{X", "{S 2,X"))),
        ("the type of a place", with_line(p, PART, spl, |l| l.replace("{X", "{POS: X"))),
        ("a whole turn of A", with_line(p, PART, spl, |l| number(l, "A ", |a| format!("{}", a - 360.0)))),
        ("target moved to the data", in_a_name),
        ("home written out", replaced(p, MAIN, "PTP Flat340_home", "PTP {A1 0,A2 -110.0,A3 100,A4 0,A5 55,A6 0}")),
        ("a number moved to the data", {
            let moved = replaced(p, MAIN, "$ADVANCE=5", "$ADVANCE=nAhead");
            replaced(&moved, DATA, "ENDDAT", "DECL INT nAhead=5\r\nENDDAT")
        }),
        ("declarations apart", replaced(p, MAIN, "FRAME found,wanted", "DECL FRAME wanted\r\nDECL FRAME found")),
        (
            "the same speed for all, set before too",
            with_line(p, PART, ("PTP {", 0), |l| format!("$VEL.CP=0.05\r\n{l}")),
        ),
        ("files in another order", Program { files: p.files.iter().rev().cloned().collect() }),
    ] {
        assert_eq!(check(&SMALL, &edited), [], "{name}");
    }
}

/// Points on the plan's surface, which is not the job's plane between them: what a spline does there is looked at.
#[test]
fn the_way_between_the_points_is_compared_with_the_surface() {
    let job = krl_job_with(&[]);
    let motion = plan(&job, curved(raster(1, 11)), Purpose::Polish);
    let program = target::emit("flat_340", &motion, &job).expect("a program").0;
    let found = verify::check(&program, &motion, &job, &Plane {});
    assert!(found.iter().all(|problem| problem.code.as_str() == "E1015"), "{found:?}");
    // z = x²/4 m over the line: at x = 14 mm 49 um.
    insta::assert_snapshot!(format!("[{}] {}", found[0].code, found[0].message));
}

#[test]
fn the_operator_and_the_purpose_are_compared() {
    let manual = json!({"manual": {"interlock": "relay K3"}});
    let built = build(&[("/robot/cell/process", manual)], 2, 5, Purpose::Polish);
    let p = &built.program;
    for (name, edited, word) in [
        ("part", replaced(p, MAIN, "(\"part FS340-07", "(\"part FS340-08"), "part FS340-07"),
        ("rotation", replaced(p, MAIN, "wheel forward: ", "wheel reverse: "), "wheel forward"),
        ("no stop", replaced(p, MAIN, "press start\",\"Flat340\")\r\nHALT", "press start\",\"Flat340\")"), "HALT"),
    ] {
        let found = check(&built, &edited);
        let named = found.iter().any(|p| p.code.as_str() == "E1012" && p.message.contains(word));
        assert!(named, "{name}: {found:?}");
    }
    let dry = build(&[("/target/krl/controller/file_lines", json!(100))], 9, 11, Purpose::DryRun);
    assert!(check(&SMALL, &dry.program).iter().all(|p| p.code.as_str() == "E1002"));
    assert!(!check(&dry, &SMALL.program).is_empty());
}

#[test]
fn a_program_of_another_job_is_not_taken() {
    let changes = [("/target/krl/controller/file_lines", json!(100)), ("/robot/cell/tcp/load/mass", json!(41.0))];
    let other = build(&changes, 9, 11, Purpose::Polish);
    let found = check(&SMALL, &other.program);
    assert!(found.iter().any(|p| p.code.as_str() == "E1009") && found.iter().any(|p| p.code.as_str() == "E1010"));
}

#[test]
fn truncated_programs_are_refused() {
    for file in 0..SMALL.program.files.len() {
        let whole = &SMALL.program.files[file].bytes;
        // Up to the word at the end, which is all that may be missing of its line end.
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
        format!("x={}", "(".repeat(100_000)),
        format!("x={}", "{A ".repeat(100_000)),
        format!("x={}1", "-".repeat(100_000)),
        format!("x={}1", "NOT ".repeat(100_000)),
        format!("x=1{}", "+1".repeat(100_000)),
        "IF TRUE THEN\n".repeat(100_000),
        "SPLINE\n".repeat(1000),
        format!("SPLINE\n{}", "SLIN a\n".repeat(10_000)),
    ] {
        let edited = with_text(&SMALL.program, PART, format!("DEF Flat340_002 ( )\n{body}\nEND"));
        assert!(!check(&SMALL, &edited).is_empty());
    }
    let mut data = String::new();
    for i in 1..40 {
        data.push_str(&format!("DECL FRAME a{i}={{X a{},Y a{},Z 0,A 0,B 0,C 0}}\n", i - 1, i - 1));
    }
    let edited = replaced(&SMALL.program, DATA, "ENDDAT", &format!("{data}ENDDAT"));
    assert!(!check(&SMALL, &edited).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300), file in 0usize..8) {
        let mut edited = SMALL.program.clone();
        edited.files[file].bytes = bytes;
        prop_assert!(!check(&SMALL, &edited).is_empty());
    }

    #[test]
    fn random_edits_never_panic(
        file in 0usize..8,
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

    /// One digit of a segment changed to another always changes the motion, except beyond what the proof allows.
    #[test]
    fn a_digit_of_a_segment_changed_is_caught(
        file in 1usize..4, place in any::<prop::sample::Index>(), digit in b'0'..=b'9',
    ) {
        let name = format!("Flat340_00{file}.src");
        let text = text(&SMALL.program, &name);
        let digits: Vec<usize> = text
            .match_indices("{X ")
            .flat_map(|(from, _)| {
                let to = from + text[from..].find("\r\n").expect("an end");
                from..to
            })
            .filter(|i| text.as_bytes()[*i].is_ascii_digit())
            .collect();
        let at = digits[place.index(digits.len())];
        prop_assume!(text.as_bytes()[at] != digit);
        let mut bytes = text.clone().into_bytes();
        bytes[at] = digit;
        let changed = String::from_utf8(bytes).expect("ASCII");
        let (before, after) = (number_around(&text, at), number_around(&changed, at));
        // A coordinate may change by less than 1 um, an angle by less than 0.001 deg; a speed is compared to its last digit.
        let speed = text[..at].rfind('=').is_some_and(|equals| equals > text[..at].rfind('\n').unwrap_or(0));
        prop_assume!(before != after && (speed || (before - after).abs() > 0.0025));
        prop_assert!(!check(&SMALL, &with_text(&SMALL.program, &name, changed)).is_empty());
    }
}

/// The number that the byte at `at` stands in.
fn number_around(text: &str, at: usize) -> f64 {
    let of_number = |c: u8| c.is_ascii_digit() || matches!(c, b'.' | b'-');
    let bytes = text.as_bytes();
    let from = (0..at).rev().take_while(|i| of_number(bytes[*i])).last().unwrap_or(at);
    let to = (at..bytes.len()).find(|i| !of_number(bytes[*i])).unwrap_or(bytes.len());
    text[from..to].parse().unwrap_or(f64::INFINITY)
}
