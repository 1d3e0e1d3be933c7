//! The RAPID emitter: a small program to read, what it refuses, limits of modules, the same bytes with any number of
//! threads.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

mod program;

use polishc::diagnostics::Problem;
use polishc::motion::Purpose;
use polishc::target::{self, Program};
use program::{curved, job_with, plan, raster};
use serde_json::{Value, json};

fn build(changes: &[(&str, Value)], lines: usize, points: usize, purpose: Purpose) -> Result<Program, Vec<Problem>> {
    let job = job_with(changes);
    let motion = plan(&job, raster(lines, points), purpose);
    target::emit("flat_340", &motion, &job).map(|draft| draft.0)
}

fn text(program: &Program) -> String {
    let mut out = String::new();
    for file in &program.files {
        out.push_str(&format!("=== {} ({} points)\n", file.name, file.points));
        out.push_str(&String::from_utf8(file.bytes.clone()).expect("ASCII").replace("\r\n", "\n"));
    }
    out
}

#[test]
fn a_small_program() {
    let changes = [("/target/rapid/controller/module_points", json!(6))];
    insta::assert_snapshot!(text(&build(&changes, 3, 3, Purpose::Polish).expect("a program")));
}

#[test]
fn a_small_program_with_frames_on_the_controller_and_an_operator() {
    let changes = [
        ("/target/rapid/frames", json!("on_controller")),
        ("/robot/cell/process", json!({"manual": {"interlock": "relay K3"}})),
        ("/robot/cell/safe_poses", json!([])),
    ];
    insta::assert_snapshot!(text(&build(&changes, 1, 3, Purpose::Polish).expect("a program")));
}

#[test]
fn a_small_dry_run() {
    insta::assert_snapshot!(text(&build(&[], 1, 3, Purpose::DryRun).expect("a program")));
}

/// What the job says is refused, with the code, the field and the sentence.
#[test]
fn refusals() {
    let wait = json!([{"name": "diOk", "active": "high", "wait_at_most": 0.0}]);
    let cases: &[(&str, &[(&str, Value)])] = &[
        ("a module that begins with a digit", &[("/target/rapid/module", json!("340flat"))]),
        ("a module with a blank", &[("/target/rapid/module", json!("flat 340"))]),
        ("a module with an accent", &[("/target/rapid/module", json!("fl\u{e4}che"))]),
        ("a module without a name", &[("/target/rapid/module", json!(""))]),
        ("a module with a long name", &[("/target/rapid/module", json!("a23456789b12345678901"))]),
        ("a tool with a long name", &[("/target/rapid/tool_name", json!("a23456789b123456789c123456789d123"))]),
        ("a reserved word", &[("/target/rapid/tool_name", json!("EndIf"))]),
        ("a name of the controller", &[("/target/rapid/tool_name", json!("tool0"))]),
        ("a module called main", &[("/target/rapid/module", json!("Main"))]),
        ("tool and object alike", &[("/target/rapid/object_name", json!("TWHEEL"))]),
        ("a signal like the object", &[("/robot/cell/process/signals/outputs/1/name", json!("wPart"))]),
        ("a name that polishc could make", &[("/target/rapid/tool_name", json!("flat340_home"))]),
        ("a signal that is no name", &[("/robot/cell/process/signals/inputs/0/name", json!("di;EXIT"))]),
        ("a folder with a quote", &[("/target/rapid/controller/folder", json!("HOME:/a\"b"))]),
        ("a long folder", &[("/target/rapid/controller/folder", json!(format!("HOME:/{}", "a".repeat(70))))]),
        ("small modules", &[("/target/rapid/controller/module_bytes", json!(1000))]),
        (
            "a small main module",
            &[
                ("/target/rapid/controller/module_bytes", json!(8000)),
                ("/robot/cell/safe_poses", json!(vec![[0.0; 6]; 40])),
            ],
        ),
        ("a wait without time", &[("/robot/cell/process/signals/inputs", wait)]),
        ("a travel speed of nothing", &[("/robot/cell/travel/speed", json!(1e-8))]),
        ("no target", &[("/target", Value::Null)]),
        (
            "few decimals",
            &[
                ("/target/rapid/controller/position_decimals", json!(2)),
                ("/target/rapid/controller/quaternion_decimals", json!(10)),
                ("/target/rapid/controller/speed_decimals", json!(-1)),
            ],
        ),
    ];
    let mut shown = String::new();
    let motion_job = job_with(&[]);
    let motion = plan(&motion_job, raster(1, 3), Purpose::Polish);
    for (name, changes) in cases {
        let problems = target::emit("flat_340", &motion, &job_with(changes)).err().unwrap_or_default();
        assert!(!problems.is_empty(), "{name} must be refused");
        for problem in problems {
            let field = problem.field.as_deref().unwrap_or("");
            shown.push_str(&format!("{name}: [{}] {field}: {}\n", problem.code, problem.message));
        }
    }
    insta::assert_snapshot!(shown);
}

#[test]
fn words_of_the_job_cannot_become_code() {
    let changes = [
        ("/workpiece/x_mark", json!("a\r\nEXIT; \u{e9}\u{0}")),
        ("/workpiece/part", json!("y".repeat(500))),
        ("/robot/cell/process/signals/interlock", json!("relay\nK3")),
    ];
    let text = text(&build(&changes, 1, 3, Purpose::Polish).expect("a program"));
    assert!(text.contains("    ! +x of the part: a\\u{d}\\u{a}EXIT; \\u{e9}\\u{0}\n"));
    assert!(text.is_ascii() && !text.contains("\nEXIT") && text.contains("relay\\u{a}K3"));
}

/// What the operator is shown fits the screen, whatever the job says.
#[test]
fn the_operator_is_shown_part_and_wheel() {
    let part = format!("\"K\u{e4}rcher\\\r\n{}", "y".repeat(100));
    let changes = [
        ("/workpiece/part", json!(part)),
        ("/tool/mrf_wheel/rotation", json!("reverse")),
        ("/robot/cell/process", json!({"manual": {"interlock": "relay K3"}})),
    ];
    let text = text(&build(&changes, 1, 3, Purpose::Polish).expect("a program"));
    let on = text.split("PROC Flat340_process_on()\n").nth(1).expect("the routine");
    let shown: Vec<&str> = on.split("Stop;").next().expect("a stop").lines().map(str::trim).collect();
    // 5 characters of `part `, 11 of the name, three of which a RAPID string cannot hold as they are, two line ends.
    let first = format!("TPWrite \"part ?K?rcher???{}\";", "y".repeat(24));
    assert_eq!(shown[0], first);
    assert_eq!(shown[1], format!("TPWrite \"{}\";", "y".repeat(40)));
    assert_eq!(shown[2], format!("TPWrite \"{}\";", "y".repeat(36)));
    assert_eq!(shown[3..5], ["TPWrite \"wheel reverse: fluid along -x of tool\";", "TPWrite \"wheel at 60.000 rpm\";"]);
}

#[test]
fn the_process_is_asked_for_before_every_module_and_the_speed_only_to_polish() {
    let changes = [("/target/rapid/controller/module_points", json!(6))];
    let polish = text(&build(&changes, 3, 3, Purpose::Polish).expect("a program"));
    let (loads, waits) =
        (polish.matches("Load\\Dynamic").count(), polish.matches("Flat340_wait_inputs;\n        TPWrite"));
    assert_eq!((loads, waits.count()), (2, 2));
    let dry = text(&build(&changes, 3, 3, Purpose::DryRun).expect("a program"));
    assert!(!dry.contains("CSpeedOverride") && !dry.contains("_wait_inputs") && dry.contains("_end)"));
}

#[test]
fn the_form_that_controllers_ask_for() {
    // The longest names that are possible, so that lines are as long as they can be.
    let changes = [
        ("/target/rapid/module", json!("a23456789b123456789")),
        ("/target/rapid/tool_name", json!("t23456789b123456789c123456789d12")),
        ("/target/rapid/object_name", json!("w23456789b123456789c123456789d12")),
        ("/target/rapid/controller/module_points", json!(40)),
    ];
    for changes in [&changes[..], &[]] {
        let job = job_with(changes);
        let motion = plan(&job, curved(raster(9, 17)), Purpose::Polish);
        let program = target::emit("flat_340", &motion, &job).expect("a program").0;
        for file in &program.files {
            let text = std::str::from_utf8(&file.bytes).expect("text");
            assert!(text.is_ascii() && text.starts_with("MODULE ") && text.ends_with("ENDMODULE\r\n"), "{}", file.name);
            assert_eq!(text.matches('\n').count(), text.matches("\r\n").count());
            let longest = text.split("\r\n").map(str::len).max().unwrap_or(0);
            assert!(longest < 200, "{}: a line of {longest} characters", file.name);
            assert!(!text.contains("-0,") && !text.contains("-0]") && !text.contains("NaN"), "{}", file.name);
            let module = file.name.strip_suffix(".mod").expect("a module's file");
            assert!(text.starts_with(&format!("MODULE {module}\r\n")) && module.len() <= 32);
        }
    }
}

#[test]
fn modules_keep_their_limits_and_hold_whole_runs() {
    let changes = [
        ("/target/rapid/controller/module_points", json!(50)),
        ("/target/rapid/controller/module_bytes", json!(12_000)),
    ];
    let program = build(&changes, 9, 17, Purpose::Polish).expect("a program");
    let points: Vec<usize> = program.files.iter().map(|file| file.points).collect();
    // Two lines of 17 points fit into 50 points, three do not: runs of 34 points, the last of 17. Two runs would fit
    // neither 50 points nor, at some 150 bytes a point, 12,000 bytes.
    assert_eq!(points, [0, 34, 34, 34, 34, 17]);
    for file in &program.files {
        assert!(file.bytes.len() <= 12_000, "{} has {} bytes", file.name, file.bytes.len());
    }
}

#[test]
fn the_same_bytes_with_any_number_of_threads() {
    let job = job_with(&[("/target/rapid/controller/module_points", json!(100))]);
    let motion = plan(&job, curved(raster(40, 31)), Purpose::Polish);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| target::emit("flat_340", &motion, &job).expect("a program").0)
    };
    let one = with(1);
    assert!(one.files.len() > 8);
    assert_eq!(one, with(2));
    assert_eq!(one, with(8));
}

#[test]
fn the_digest_follows_what_moves_the_robot() {
    let digest = |changes: &[(&str, Value)], name: &str| {
        let job = job_with(changes);
        let motion = plan(&job, raster(2, 5), Purpose::Polish);
        let program = target::emit(name, &motion, &job).expect("a program").0;
        let text = String::from_utf8(program.files[0].bytes.clone()).expect("ASCII");
        text.split("_digest:=\"").nth(1).expect("a digest")[..32].to_string()
    };
    let first = digest(&[], "flat_340");
    assert_eq!(first, digest(&[("/workpiece/part", json!("other")), ("/wavelength", json!(5e-7))], "other"));
    for change in [
        ("/tool/mrf_wheel/gap", json!(0.0011)),
        ("/robot/cell/tcp/load/mass", json!(42.1)),
        ("/robot/cell/home_tolerance", json!(0.02)),
        ("/target/rapid/zone", json!("z1")),
        ("/robot/cell/object/at/x", json!(-0.1501)),
        ("/robot/cell/process/signals/outputs/0/settle", json!(4.0)),
    ] {
        let name = change.0;
        assert_ne!(first, digest(&[change], "flat_340"), "{name}");
    }
}
