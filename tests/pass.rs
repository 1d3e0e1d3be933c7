//! The example `flat_340`, pass by pass: one snapshot a pass, abridged so that a change in any pass shows as a readable
//! difference in the snapshot of that pass and of those behind it.
//!
//! These snapshots say what is, not what ought to be: what the passes must do is proved by the tests of each and by
//! tests/orientation.rs, geometry.rs and removal.rs. Numbers are rounded to what physics or the controller resolves, so
//! that a snapshot changes when the result does. Hashes and digests, which change with every digit, are left out.
#![allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]

mod common;

use common::TestFiles;
use polishc::dwell::Outcome;
use polishc::motion::{Motion, Transform};
use polishc::path::{Link, ToolPath};
use polishc::session::{self, Compilation, Planned, Request, Unwatched};
use polishc::syntax::ast::{
    Block, EntryKind, Expr, ExprKind, Item, ItemKind, Name, Restriction, Type, TypeKind, Unit, UsePath,
};
use polishc::target::Program;
use std::fmt::Write;
use std::sync::LazyLock;

static DONE: LazyLock<Compilation> = LazyLock::new(|| {
    let request = Request::new("examples/flat_340/flat_340.polish");
    let done = session::compile(&TestFiles::default(), &request, &Unwatched);
    assert!(!done.failed(), "{:?}", done.diagnostics);
    done
});

fn planned() -> &'static Planned {
    &DONE.jobs[0]
}

fn assert_pass(name: &str, text: &str) {
    insta::with_settings!({ omit_expression => true, snapshot_path => "snapshots" }, {
        insta::assert_snapshot!(format!("flat_340_{name}"), text);
    });
}

#[test]
fn ast() {
    let (file, _, text) = DONE.sources.iter().next().expect("the job's text");
    let (tree, diagnostics) = polishc::syntax::parse(file, text);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let mut out = format!("language {}\n", tree.language.expect("a language").0);
    for item in &tree.items {
        out_item(&mut out, item);
    }
    assert_pass("ast", &out);
}

/// An item as an outline: a line an entry, indented, every expression in full brackets.
fn out_item(out: &mut String, item: &Item) {
    let doc = if item.doc.is_empty() { String::new() } else { format!("  -- {}", item.doc) };
    match &item.kind {
        ItemKind::Use(UsePath::Module(words)) => {
            let words: Vec<&str> = words.iter().map(|word| word.text.as_str()).collect();
            writeln!(out, "use module {}", words.join(" . "))
        }
        ItemKind::Use(UsePath::File { path, .. }) => writeln!(out, "use file {path:?}"),
        ItemKind::Param { name, ty, value, restriction, .. } => {
            let value = value.as_ref().map_or_else(|| "no value".into(), expression);
            let restriction = match restriction {
                Some(Restriction::Range(range)) => format!(" where {}", expression(range)),
                Some(Restriction::Comparisons(all)) => format!(" where {} comparisons", all.len()),
                None => String::new(),
            };
            writeln!(out, "param {}: {} = {value}{restriction}{doc}", name.text, type_text(ty))
        }
        ItemKind::Job { name, body } => {
            writeln!(out, "job {}{doc}", name.text).expect("text");
            out_block(out, body, 1);
            Ok(())
        }
        other => writeln!(out, "{}", format!("{other:?}").split(' ').next().unwrap_or("?")),
    }
    .expect("text");
}

fn out_block(out: &mut String, block: &Block, depth: usize) {
    for entry in &block.entries {
        let indent = "  ".repeat(depth);
        match &entry.kind {
            EntryKind::Field { name, value } => match &value.kind {
                ExprKind::Record { schema, body } => {
                    let schema = schema.as_ref().map_or("(schema of the field)", |name| name.text.as_str());
                    writeln!(out, "{indent}{}: record {schema}", name.text).expect("text");
                    out_block(out, body, depth + 1);
                }
                ExprKind::With(base, body) => {
                    writeln!(out, "{indent}{}: {} with", name.text, expression(base)).expect("text");
                    out_block(out, body, depth + 1);
                }
                _ => writeln!(out, "{indent}{}: {}", name.text, expression(value)).expect("text"),
            },
            EntryKind::Expr(value) => writeln!(out, "{indent}{}", expression(value)).expect("text"),
        }
    }
}

fn expression(value: &Expr) -> String {
    let all = |values: &[Expr]| values.iter().map(expression).collect::<Vec<_>>().join(", ");
    match &value.kind {
        ExprKind::Number(number) => number.to_string(),
        ExprKind::Quantity { value, unit } => format!("{value} {}", unit_text(unit)),
        ExprKind::Text(text) => format!("{text:?}"),
        ExprKind::Bool(value) => value.to_string(),
        ExprKind::None => "none".into(),
        ExprKind::Name(name) => name.clone(),
        ExprKind::Member(base, name) => format!("{}.{}", expression(base), name.text),
        ExprKind::Call(function, arguments) => format!("{}({})", expression(function), all(arguments)),
        ExprKind::Record { schema, body } => {
            let fields: Vec<String> = body
                .entries
                .iter()
                .map(|entry| match &entry.kind {
                    EntryKind::Field { name, value } => format!("{}: {}", name.text, expression(value)),
                    EntryKind::Expr(value) => expression(value),
                })
                .collect();
            format!("{} {{ {} }}", schema.as_ref().map_or("", |name| name.text.as_str()), fields.join(", "))
        }
        ExprKind::With(base, body) => format!("({} with {} entries)", expression(base), body.entries.len()),
        ExprKind::List(values, unit) => {
            format!("[{}]{}", all(values), unit.as_ref().map(|u| format!(" {}", unit_text(u))).unwrap_or_default())
        }
        ExprKind::Comprehension { element, variable, over, .. } => {
            format!("[{} for {} in {}]", expression(element), variable.text, expression(over))
        }
        ExprKind::If { branches, otherwise } => {
            let branches: Vec<String> =
                branches.iter().map(|(a, b)| format!("if {} then {}", expression(a), expression(b))).collect();
            format!("({} else {})", branches.join(" else "), expression(otherwise))
        }
        ExprKind::Range(from, to) => format!("({} .. {})", expression(from), expression(to)),
        ExprKind::Unary(op, value) => format!("({op:?} {})", expression(value)),
        ExprKind::Binary(op, _, a, b) => format!("({} {op:?} {})", expression(a), expression(b)),
        ExprKind::Missing => "missing".into(),
    }
}

fn unit_text(unit: &Unit) -> String {
    let factor = |(name, power): &(Name, i32)| {
        if *power == 1 { name.text.clone() } else { format!("{}^{power}", name.text) }
    };
    unit.factors.iter().map(factor).collect::<Vec<_>>().join("*")
}

fn type_text(ty: &Type) -> String {
    match &ty.kind {
        TypeKind::Named(name) => name.clone(),
        other => format!("{other:?}"),
    }
}

#[test]
fn job() {
    assert_pass("job", &(serde_json::to_string_pretty(&planned().job).expect("JSON") + "\n"));
}

/// Indices of the first, second, middle and last line.
fn some_lines(path: &ToolPath) -> [usize; 4] {
    [0, 1, path.lines.len() / 2, path.lines.len() - 1]
}

/// The first three and the last three of a range, and how many stand between.
fn ends(range: std::ops::Range<usize>) -> (Vec<usize>, usize, Vec<usize>) {
    if range.len() <= 6 {
        return (range.collect(), 0, Vec::new());
    }
    let (first, last) = (range.start..range.start + 3, range.end - 3..range.end);
    (first.collect(), range.len() - 6, last.collect())
}

fn out_points(out: &mut String, path: &ToolPath, point: impl Fn(usize) -> String) {
    for line in some_lines(path) {
        let points = path.lines[line].points.clone();
        let link = match path.lines[line].link {
            Link::OnSurface => "then along the surface",
            Link::Lifted => "then lifted",
        };
        writeln!(out, "line {line}: points {points:?}, {link}").expect("text");
        let (first, between, last) = ends(points);
        for i in first {
            writeln!(out, "  {}", point(i)).expect("text");
        }
        if between > 0 {
            writeln!(out, "  … {between} more …").expect("text");
        }
        for i in last {
            writeln!(out, "  {}", point(i)).expect("text");
        }
    }
}

/// Fixed decimals without a minus before zero.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') {
        text.trim_start_matches('-').to_string()
    } else {
        text
    }
}

fn list(values: &[f64], decimals: usize) -> String {
    values.iter().map(|value| fixed(*value, decimals)).collect::<Vec<_>>().join(" ")
}

#[test]
fn path() {
    let path = planned().path().expect("a path");
    let mut out = format!("{} points on {} lines; mm, then the normal\n", path.points.len(), path.lines.len());
    out_points(&mut out, path, |i| {
        format!("{}   {}", list(&path.points.position(i).map(|m| m * 1e3), 4), list(&path.points.normal(i), 6))
    });
    assert_pass("path", &out);
}

#[test]
fn dwell() {
    let outcome: &Outcome = planned().dwell.as_ref().expect("a dwell plan");
    let figures = &outcome.figures;
    let nm = |metres: f64, decimals: usize| fixed(metres * 1e9, decimals);
    let mut out = String::from("error map over the clear aperture, nm\n");
    let map = planned().error_map.as_ref().expect("a map");
    for (name, figures) in [("as measured", &map.before), ("without piston and tilt", &map.after)] {
        writeln!(out, "  {name}: {} pixels, RMS {}, PV {}", figures.count, nm(figures.rms, 2), nm(figures.pv, 1))
            .expect("text");
    }
    writeln!(
        out,
        "prediction, nm\n  RMS {} -> {}, PV {} -> {}\n  removal: mean {}, greatest {}, even layer {}, floor {}",
        nm(figures.before_rms, 1),
        nm(figures.rms, 1),
        nm(figures.before_pv, 0),
        nm(figures.pv, 0),
        nm(figures.mean_removal, 1),
        nm(figures.greatest_removal, 1),
        nm(figures.base, 1),
        nm(figures.floor, 1),
    )
    .expect("text");
    writeln!(
        out,
        "time {} s, feed {} .. {} mm/s over the clear aperture, {} % at a bound, overrun {} mm",
        fixed(figures.time, 0),
        fixed(figures.least_speed * 1e3, 1),
        fixed(figures.greatest_speed * 1e3, 1),
        fixed(figures.at_bounds * 1e2, 1),
        fixed(figures.overrun * 1e3, 3),
    )
    .expect("text");
    out.push_str("speed of the move that ends at a point, mm/s\n");
    let timed = planned().timed().expect("a timed path");
    out_points(&mut out, &timed.path, |i| fixed(timed.speed[i] * 1e3, 2));
    assert_pass("dwell", &out);
}

fn frame(transform: &Transform) -> String {
    let (at, q) = (transform.translation.vector * 1e3, transform.rotation);
    format!("at {} mm, wxyz {}", list(&[at.x, at.y, at.z], 4), list(&[q.w, q.i, q.j, q.k], 8))
}

fn degrees(joints: &[f64]) -> String {
    list(&joints.iter().map(|angle| angle.to_degrees()).collect::<Vec<_>>(), 3)
}

#[test]
fn motion() {
    let motion: &Motion = planned().motion.as_ref().expect("a motion");
    let frames = &motion.frames;
    let mut out = String::new();
    for (name, transform) in [
        ("base in world", &frames.world_base),
        ("user in world", &frames.world_user),
        ("object in user", &frames.user_object),
        ("tool in flange", &frames.flange_tool),
    ] {
        writeln!(out, "{name}: {}", frame(transform)).expect("text");
    }
    writeln!(out, "home {} deg", degrees(&motion.home)).expect("text");
    for (i, run) in motion.runs.iter().enumerate() {
        writeln!(
            out,
            "run {i}: lines {:?}, points {:?}, {:?} travel, branch {}, approach {}, retract {} deg",
            run.lines,
            run.points,
            run.travel,
            run.branch.number(),
            degrees(&run.approach_joints),
            degrees(&run.retract_joints)
        )
        .expect("text");
    }
    let figures = &motion.figures;
    writeln!(
        out,
        "time {} s, joint margin {} deg, largest joint step {} deg, wrist margin {} deg, joint speed share {}",
        fixed(figures.time, 0),
        fixed(figures.joint_margin.to_degrees(), 2),
        fixed(figures.largest_joint_step.to_degrees(), 3),
        fixed(figures.wrist_margin.to_degrees(), 2),
        fixed(figures.joint_speed_share, 3),
    )
    .expect("text");
    out.push_str("tool centre point in the object frame, mm; tool wxyz; joints, deg; confdata\n");
    out_points(&mut out, &motion.timed.path, |i| {
        format!(
            "{}   {}   {}   {:?}",
            list(&motion.position[i].map(|m| m * 1e3), 4),
            list(&motion.quaternion[i], 6),
            degrees(&motion.joints[i]),
            motion.confdata[i]
        )
    });
    assert_pass("motion", &out);
}

/// The text with every run of 32 or 64 hexadecimal digits (digests, hashes) named and not shown.
fn without_hashes(text: &str) -> String {
    let mut out = String::new();
    let mut word = String::new();
    for c in text.chars().chain(['\n']) {
        if c.is_ascii_hexdigit() {
            word.push(c);
            continue;
        }
        out.push_str(if word.len() >= 32 { "<hash>" } else { &word });
        word.clear();
        out.push(c);
    }
    out.pop();
    out
}

#[test]
fn program() {
    let program: &Program = planned().program.as_ref().expect("a program");
    let text = |i: usize| {
        let text = String::from_utf8(program.files[i].bytes.clone()).expect("ASCII");
        assert!(text.contains("\r\n") && !text.replace("\r\n", "").contains('\n'), "every line ends with CR LF");
        without_hashes(&text.replace("\r\n", "\n"))
    };
    let mut out = format!("---- {}\n", program.files[0].name);
    // Of the modules, each loaded in five lines, the first and the last are shown.
    let count = program.files.len() - 1;
    let mut skipped = 0;
    let main = text(0);
    let mut module = 0;
    for line in main.lines() {
        if line.trim_start().starts_with("Flat340_full_speed;") && module < count {
            // Before home, and before each module.
            module += usize::from(out.contains("Flat340_process_on;"));
        }
        if (2..count).contains(&module) {
            skipped += 1;
            continue;
        }
        if skipped > 0 {
            writeln!(out, "        … {skipped} lines for the modules between …").expect("text");
            skipped = 0;
        }
        writeln!(out, "{line}").expect("text");
    }
    let first = text(1);
    let lines: Vec<&str> = first.lines().collect();
    writeln!(out, "---- {}", program.files[1].name).expect("text");
    for line in &lines[..24] {
        writeln!(out, "{line}").expect("text");
    }
    writeln!(out, "        … {} lines …", lines.len() - 24 - 8).expect("text");
    for line in &lines[lines.len() - 8..] {
        writeln!(out, "{line}").expect("text");
    }
    out.push_str("---- all files\n");
    for file in &program.files {
        writeln!(out, "{}: {} points, {} bytes", file.name, file.points, file.bytes.len()).expect("text");
    }
    assert_pass("program", &out);
}

/// A small job for a KUKA: the main program and its data whole, of the path's first sub-program the two ends.
#[test]
fn krl_program() {
    let request = Request::new("tests/ui/verify/krl_untouched.polish");
    let done = session::compile(&TestFiles::default(), &request, &Unwatched);
    assert!(!done.failed(), "{:?}", done.diagnostics);
    let program: &Program = done.jobs[0].program.as_ref().expect("a program");
    let mut out = String::new();
    for file in &program.files {
        let text = String::from_utf8(file.bytes.clone()).expect("ASCII");
        let text = without_hashes(&text.replace("\r\n", "\n"));
        // The words of the digest change with every digit of the path.
        let shown = |line: &str| !(line.starts_with("DECL INT Flat50_d") || line.starts_with("IF (d1<>"));
        let lines: Vec<&str> = text.lines().filter(|line| shown(line)).collect();
        writeln!(out, "---- {}: {} points, {} bytes", file.name, file.points, file.bytes.len()).expect("text");
        let whole = if file.points > 0 { 34 } else { lines.len() };
        for line in &lines[..whole] {
            writeln!(out, "{line}").expect("text");
        }
        if whole < lines.len() {
            writeln!(out, "    … {} lines …", lines.len() - whole - 8).expect("text");
            for line in &lines[lines.len() - 8..] {
                writeln!(out, "{line}").expect("text");
            }
        }
    }
    insta::with_settings!({ omit_expression => true, snapshot_path => "snapshots" }, {
        insta::assert_snapshot!("flat_50_krl_program", out);
    });
    let note = &done.jobs[0].result.as_ref().expect("a result").note;
    assert!(note.contains("a model"), "{note}");
}

#[test]
fn result() {
    let mut result = serde_json::to_value(planned().result.as_ref().expect("a result")).expect("JSON");
    let programs = result["programs"].as_array_mut().expect("a list");
    let between = programs.len() - 3;
    programs.drain(2..2 + between);
    programs.insert(2, serde_json::json!(format!("… {between} more …")));
    // How many steps the solver takes is its own affair.
    result["dwell"].as_object_mut().expect("a record").remove("iterations");
    assert_pass("result", &(without_hashes(&serde_json::to_string_pretty(&result).expect("JSON")) + "\n"));
}
