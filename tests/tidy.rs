//! What must agree across the tree: the direction of the modules, the table of codes, the pages, the tests of each code.
#![allow(clippy::disallowed_methods, reason = "this test reads the source tree")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Every module and those that it may use: the arrows of docs/dev/architecture.md.
const LAYERS: &[(&str, &[&str])] = &[
    ("source", &[]),
    ("units", &[]),
    ("fourier", &[]),
    ("diagnostics", &["source"]),
    ("syntax", &["source", "diagnostics"]),
    ("job", &["source", "units"]),
    ("check", &["source", "units", "diagnostics", "syntax"]),
    ("eval", &["source", "units", "diagnostics", "syntax", "check", "job"]),
    ("doc", &["source", "units", "syntax", "check", "eval"]),
    ("height_map", &["source", "diagnostics", "job"]),
    ("workpiece", &["source", "units", "diagnostics", "job", "height_map"]),
    ("metrology", &["source", "units", "fourier", "diagnostics", "job", "height_map", "workpiece"]),
    ("tool", &["source", "units", "diagnostics", "job", "height_map", "workpiece", "metrology"]),
    ("path", &["units", "diagnostics", "job", "height_map", "workpiece", "metrology", "tool"]),
    ("dwell", &["units", "fourier", "diagnostics", "job", "height_map", "workpiece", "metrology", "tool", "path"]),
    (
        "forecast",
        &["units", "diagnostics", "job", "height_map", "workpiece", "metrology", "tool", "path", "dwell", "fourier"],
    ),
    ("motion", &["units", "diagnostics", "job", "workpiece", "tool", "path", "dwell"]),
    ("target", &["units", "diagnostics", "job", "path", "dwell", "motion"]),
    ("verify", &["units", "diagnostics", "job", "workpiece", "path", "dwell", "motion", "target"]),
    ("simulate", &["units", "diagnostics", "job", "height_map", "workpiece", "tool", "path", "dwell", "verify"]),
    (
        "report",
        &[
            "units",
            "diagnostics",
            "job",
            "eval",
            "metrology",
            "tool",
            "path",
            "dwell",
            "forecast",
            "motion",
            "target",
            "simulate",
        ],
    ),
];

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut todo = vec![folder.to_path_buf()];
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            todo.extend(fs::read_dir(&path).expect("a readable folder").map(|e| e.expect("an entry").path()));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn modules_use_only_what_stands_before_them() {
    let layers: BTreeMap<&str, &[&str]> = LAYERS.iter().copied().collect();
    let mut wrong = Vec::new();
    for file in rust_files(Path::new("src")) {
        let inner = file.strip_prefix("src").expect("under src");
        let first = inner.components().next().expect("a name").as_os_str().to_string_lossy().replace(".rs", "");
        let Some(allowed) = layers.get(first.as_str()) else {
            assert!(
                ["lib", "main", "cli", "session"].contains(&first.as_str()),
                "module `{first}` is missing in the layers of this test"
            );
            continue;
        };
        let text = fs::read_to_string(&file).expect("a readable file");
        // Tests may use what they like.
        let code = text.split("#[cfg(test)]").next().unwrap_or("");
        for (i, line) in code.lines().enumerate() {
            let mut rest = line.split("//").next().unwrap_or("");
            while let Some(at) = rest.find("crate::") {
                rest = &rest[at + 7..];
                let word: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                if !word.is_empty() && word != first && !allowed.contains(&word.as_str()) {
                    wrong.push(format!("{}:{}: `{first}` may not use `{word}`", file.display(), i + 1));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_code_has_a_page_a_title_and_a_test() {
    let codes: BTreeSet<String> = polishc::diagnostics::Code::all().map(|c| c.as_str().to_string()).collect();
    let pages: BTreeSet<String> = fs::read_dir("docs/errors")
        .expect("docs/errors")
        .map(|e| e.expect("an entry").path().file_stem().expect("a name").to_string_lossy().into_owned())
        .filter(|name| name != "README")
        .collect();
    assert_eq!(codes, pages, "codes and pages differ");
    for code in polishc::diagnostics::Code::all() {
        let first = code.page().lines().next().unwrap_or("");
        assert!(first.starts_with(&format!("# {code}: ")), "page of {code} opens with `{first}`");
        assert!(!code.title().is_empty() && !code.title().ends_with('.'), "title of {code}");
        assert!(code.page().lines().count() >= 4, "the page of {code} says too little");
    }
    let mut shown = String::new();
    for folder in ["tests/snapshots", "tests/cli"] {
        for entry in fs::read_dir(folder).expect("a folder of snapshots") {
            let path = entry.expect("an entry").path();
            shown.push_str(&fs::read_to_string(path).unwrap_or_default());
        }
    }
    // No text causes these, since the schema's own limits (`where > 0 mm`, `check inner_diameter < outer_diameter`) speak
    // first: they guard jobs that a program makes through the library, and are tested there. A jump of a joint through a
    // singular position (E0810) needs margins of nearly nothing, a pose to the millimetre and no other way. No
    // path that is planned jumps (E0687), and a job with nothing to polish (E0688) has no program that a fixture could edit.
    let by_hand = [
        ("E0600", "tests/metrology/workpiece.rs"),
        ("E0620", "tests/metrology/influence.rs"),
        ("W0710", "src/dwell/feasibility.rs"),
        ("E0687", "tests/region.rs"),
        ("E0688", "tests/region.rs"),
        ("E0810", "tests/motion_plan.rs"),
        // Of programs that somebody edited, and of a compiler that is wrong.
        ("E1300", "tests/simulate.rs"),
        ("E1301", "src/simulate/mod.rs"),
        ("W1301", "tests/simulate.rs"),
    ];
    for (code, test) in by_hand {
        assert!(fs::read_to_string(test).expect("a test").contains(&format!("\"{code}\"")), "{test} tests {code}");
        shown.push_str(&format!("[{code}]"));
    }
    let untested: Vec<&String> = codes.iter().filter(|c| !shown.contains(&format!("[{c}]"))).collect();
    assert!(untested.is_empty(), "no ui file or command line case shows: {untested:?}");
}

#[test]
fn every_code_is_raised() {
    let mut code_text = String::new();
    for file in rust_files(Path::new("src")) {
        if !file.ends_with("codes.rs") {
            let text = fs::read_to_string(&file).expect("a readable file");
            // A comment raises nothing.
            code_text.extend(text.lines().map(|line| line.split("//").next().unwrap_or("")));
        }
    }
    let silent: Vec<_> = polishc::diagnostics::Code::all().filter(|c| !code_text.contains(c.as_str())).collect();
    assert!(silent.is_empty(), "no code raises {silent:?}");
}

#[test]
fn every_snapshot_has_its_file() {
    let mut orphans = Vec::new();
    for entry in fs::read_dir("tests/snapshots").expect("tests/snapshots") {
        let path = entry.expect("an entry").path();
        let text = fs::read_to_string(&path).expect("a readable snapshot");
        if let Some(line) = text.lines().find(|l| l.starts_with("input_file: ")) {
            let input = line.trim_start_matches("input_file: ").trim_matches('"');
            if !Path::new(input).exists() {
                orphans.push(format!("{}: {input}", path.display()));
            }
        }
    }
    assert!(orphans.is_empty(), "snapshots without a source: {orphans:?}");
}

#[test]
fn the_project_names_no_path_of_one_machine() {
    let mut todo: Vec<PathBuf> =
        ["src", "docs", "stdlib", "examples", "tests", "grammar", "benches", "README.md", "CHANGELOG.md", "Cargo.toml"]
            .iter()
            .map(PathBuf::from)
            .collect();
    let mut wrong = Vec::new();
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            todo.extend(fs::read_dir(&path).expect("a readable folder").map(|e| e.expect("an entry").path()));
        } else if let Ok(text) = fs::read_to_string(&path) {
            // Written in two parts, so that this file does not find itself.
            for word in [concat!("/wo", "rk/"), concat!("/tm", "p/"), concat!("/ro", "ot/"), concat!("/ho", "me/")] {
                if text.contains(word) {
                    wrong.push(format!("{}: {word}", path.display()));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_message_is_one_plain_sentence() {
    let mut wrong = Vec::new();
    let mut messages = 0;
    for entry in fs::read_dir("tests/snapshots").expect("tests/snapshots") {
        let path = entry.expect("an entry").path();
        let text = fs::read_to_string(&path).expect("a readable snapshot");
        let Some((source, said)) = text.split_once("---- says ----") else { continue };
        for line in said.lines() {
            for word in ["::", "Some(", "None)", "Rule", "unwrap", "Err(", "Ok(", "{:?}", "panicked"] {
                if line.contains(word) && !source.contains(word) {
                    wrong.push(format!("{}: `{word}` in: {line}", path.display()));
                }
            }
            let head = line.strip_prefix("error[").or_else(|| line.strip_prefix("warning["));
            let Some((_, message)) = head.and_then(|rest| rest.split_once("]: ")) else { continue };
            messages += 1;
            // What stands in backticks is the job's own.
            let plain: String = message.split('`').step_by(2).collect::<Vec<_>>().join("x");
            // A range has dots of its own, and names such as KRL their capitals.
            let plain = plain.replace(" .. ", " to ");
            let mut letters = plain.chars();
            let capital =
                letters.next().is_some_and(char::is_uppercase) && letters.next().is_some_and(char::is_lowercase);
            if capital || message.ends_with('.') || plain.contains(". ") {
                wrong.push(format!("{}: not one sentence in small letters: {message}", path.display()));
            }
        }
    }
    assert!(messages > 200, "only {messages} messages");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
