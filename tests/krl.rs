//! The KRL emitter: a small program to read, what it refuses, limits of files, the same bytes with any number of threads.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

mod program;

use polishc::diagnostics::Problem;
use polishc::motion::Purpose;
use polishc::target::{self, Program};
use program::{curved, krl_job_with, plan, raster};
use serde_json::{Value, json};

fn build(changes: &[(&str, Value)], lines: usize, points: usize, purpose: Purpose) -> Result<Program, Vec<Problem>> {
    let job = krl_job_with(changes);
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
    // 32 lines of frame and 10 of the run's own leave 58: a line of 4 points takes 6, so runs of 9 lines.
    let changes = [("/target/krl/controller/file_lines", json!(100))];
    insta::assert_snapshot!(text(&build(&changes, 11, 4, Purpose::Polish).expect("a program")));
}

#[test]
fn a_small_program_with_frames_on_the_controller_and_an_operator() {
    let changes = [
        ("/target/krl/frames", json!({"on_controller": {"tool": 3, "base": 7, "load": 3}})),
        ("/target/krl/motion", json!({"linear": {"rounding": 3e-4}})),
        ("/robot/cell/process", json!({"manual": {"interlock": "relay K3"}})),
        ("/robot/cell/safe_poses", json!([])),
    ];
    insta::assert_snapshot!(text(&build(&changes, 1, 4, Purpose::Polish).expect("a program")));
}

#[test]
fn a_small_dry_run() {
    insta::assert_snapshot!(text(&build(&[], 1, 3, Purpose::DryRun).expect("a program")));
}

/// What the job says is refused, with the code, the field and the sentence.
#[test]
fn refusals() {
    let signals = "/robot/cell/process/signals";
    let (out, wait) = (format!("{signals}/outputs/1/number"), format!("{signals}/inputs/0/wait_at_most"));
    let cases: &[(&str, &[(&str, Value)])] = &[
        ("a name that begins with a digit", &[("/target/krl/module", json!("340flat"))]),
        ("a name with a blank", &[("/target/krl/module", json!("flat 340"))]),
        ("a name of 25 characters", &[("/target/krl/module", json!("a23456789b123456789c12345"))]),
        ("a name that leaves no room", &[("/target/krl/module", json!("a23456789b1234"))]),
        ("a reserved word", &[("/target/krl/module", json!("EndFor"))]),
        ("a name of the controller", &[("/target/krl/module", json!("Tool_Data"))]),
        ("a signal without a number", &[(&out, Value::Null)]),
        ("two signals of one number", &[(&out, json!(17))]),
        ("a wait without time", &[(&wait, json!(0.0))]),
        ("half a percent", &[("/robot/cell/joint_move_speed", json!(0.025))]),
        ("a long block", &[("/target/krl/controller/block_segments", json!(3))]),
        ("little memory", &[("/target/krl/controller/program_bytes", json!(5_000))]),
        ("an option that is not there", &[("/target/krl/memory", json!("dir_loader"))]),
        ("a short file", &[("/target/krl/controller/file_lines", json!(40))]),
        ("a small file", &[("/target/krl/controller/file_bytes", json!(5000))]),
        (
            "few decimals",
            &[
                ("/target/krl/controller/position_decimals", json!(2)),
                ("/target/krl/controller/angle_decimals", json!(12)),
                ("/target/krl/controller/speed_digits", json!(2)),
            ],
        ),
    ];
    let mut shown = String::new();
    let motion_job = krl_job_with(&[]);
    let motion = plan(&motion_job, raster(1, 6), Purpose::Polish);
    for (name, changes) in cases {
        let problems = target::emit("flat_340", &motion, &krl_job_with(changes)).err().unwrap_or_default();
        assert!(!problems.is_empty(), "{name} must be refused");
        for problem in problems {
            let field = problem.field.as_deref().unwrap_or("");
            shown.push_str(&format!("{name}: [{}] {field}: {}\n", problem.code, problem.message));
        }
    }
    insta::assert_snapshot!(shown);
}

#[test]
fn points_that_are_one_to_the_controller_are_refused() {
    let job = krl_job_with(&[]);
    let mut timed = raster(1, 6);
    timed.path.points.x[3] = timed.path.points.x[2] + 0.9e-6;
    let motion = plan(&job, timed, Purpose::Polish);
    let problems = target::emit("flat_340", &motion, &job).expect_err("0.9 um are no segment");
    assert_eq!(problems[0].field.as_deref(), Some("path.point_step"));
    insta::assert_snapshot!(format!("[{}] {}", problems[0].code, problems[0].message));
}

#[test]
fn an_option_that_is_there_lifts_the_budget() {
    let changes = [
        ("/target/krl/controller/program_bytes", json!(5_000)),
        ("/target/krl/controller/dir_loader", json!("installed")),
        ("/target/krl/memory", json!("dir_loader")),
    ];
    assert!(build(&changes, 3, 20, Purpose::Polish).is_ok());
}

#[test]
fn words_of_the_job_cannot_become_code() {
    let changes = [
        ("/workpiece/x_mark", json!("a\r\nHALT\n \u{e9}\u{0}")),
        ("/workpiece/part", json!("y".repeat(500))),
        ("/robot/cell/process/signals/interlock", json!("relay\nK3")),
        ("/robot/cell/process/signals/inputs/0/name", json!("ok\"\n100 %1")),
    ];
    let text = text(&build(&changes, 1, 3, Purpose::Polish).expect("a program"));
    assert!(text.contains("; +x of the part: a\\u{d}\\u{a}HALT\\u{a} \\u{e9}\\u{0}\n"));
    assert!(text.contains("MsgNotify(\"ok??100 ?1 did not come\",\"Flat340\")"));
    assert!(text.is_ascii() && text.contains("relay\\u{a}K3"));
}

#[test]
fn every_file_is_plain_text_of_short_lines() {
    let long = [
        ("/target/krl/module", json!("a23456789b123")),
        ("/target/krl/controller/file_lines", json!(100)),
        ("/target/krl/controller/angle_decimals", json!(9)),
        ("/target/krl/controller/position_decimals", json!(9)),
    ];
    for changes in [&long[..], &[]] {
        let job = krl_job_with(changes);
        let motion = plan(&job, curved(raster(9, 17)), Purpose::Polish);
        let program = target::emit("flat_340", &motion, &job).expect("a program").0;
        for file in &program.files {
            let text = std::str::from_utf8(&file.bytes).expect("text");
            assert!(text.is_ascii() && text.starts_with("&ACCESS RVP\r\n&REL 1\r\n"), "{}", file.name);
            assert_eq!(text.matches('\n').count(), text.matches("\r\n").count());
            let longest = text.split("\r\n").map(str::len).max().unwrap_or(0);
            assert!(longest < 200, "{}: a line of {longest} characters", file.name);
            let segment = text.split("\r\n").filter(|line| line.contains("SPL {")).map(str::len).max().unwrap_or(0);
            // What the room of a file is counted with.
            assert!(segment + 2 <= 160, "{}: a segment of {segment} characters", file.name);
            assert!(!text.contains(" -0,") && !text.contains("NaN") && !text.to_lowercase().contains("$ov_pro="));
            let (name, kind) = file.name.split_once('.').expect("a name and a kind");
            let head = if kind == "src" { format!("\r\nDEF {name} (") } else { format!("\r\nDEFDAT {name}\r\n") };
            assert!(text.contains(&head) && name.len() <= 24, "{}", file.name);
            let ends = if kind == "src" { ["END\r\n", "ENDFCT\r\n"] } else { ["ENDDAT\r\n"; 2] };
            assert!(ends.iter().any(|end| text.ends_with(end)), "{}", file.name);
        }
    }
}

#[test]
fn files_keep_their_limits_and_hold_whole_runs() {
    for (motion, bytes) in [(json!({"spline": {}}), 250_000), (json!({"linear": {"rounding": 3e-4}}), 14_000)] {
        let changes = [
            ("/target/krl/controller/file_lines", json!(140)),
            ("/target/krl/controller/file_bytes", json!(bytes)),
            ("/target/krl/motion", motion),
        ];
        let program = build(&changes, 9, 17, Purpose::Polish).expect("a program");
        assert!(program.files.len() > 4);
        for file in &program.files {
            assert!(file.bytes.len() <= bytes, "{} has {} bytes", file.name, file.bytes.len());
            let lines = file.bytes.iter().filter(|byte| **byte == b'\n').count();
            assert!(lines <= 140 || file.name.starts_with("Flat340."), "{} has {lines} lines", file.name);
            assert!(file.points % 17 == 0);
        }
        assert_eq!(program.files.iter().map(|file| file.points).sum::<usize>(), 9 * 17);
    }
}

#[test]
fn the_same_bytes_with_any_number_of_threads() {
    let job = krl_job_with(&[("/target/krl/controller/file_lines", json!(200))]);
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
        let job = krl_job_with(changes);
        let motion = plan(&job, raster(2, 5), Purpose::Polish);
        let program = target::emit(name, &motion, &job).expect("a program").0;
        let text = String::from_utf8(program.files[1].bytes.clone()).expect("ASCII");
        text.lines().filter(|line| line.starts_with("DECL INT")).map(str::to_string).collect::<Vec<_>>()
    };
    let first = digest(&[], "flat_340");
    assert_eq!(first.len(), 4);
    assert_eq!(first, digest(&[("/workpiece/part", json!("other")), ("/wavelength", json!(5e-7))], "other"));
    for change in [
        ("/tool/mrf_wheel/gap", json!(0.0011)),
        ("/robot/cell/tcp/load/mass", json!(42.1)),
        ("/robot/cell/home_tolerance", json!(0.02)),
        ("/target/krl/motion", json!({"linear": {"rounding": 3e-4}})),
        ("/robot/cell/object/at/x", json!(-0.1501)),
        ("/robot/cell/process/signals/outputs/0/settle", json!(4.0)),
    ] {
        let name = change.0;
        assert_ne!(first, digest(&[change], "flat_340"), "{name}");
    }
}
