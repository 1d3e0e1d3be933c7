//! One file, one snapshot that begins with the source: every diagnostic is to be seen here as a person sees it.
//!
//! A fixture may begin with words to the runner, one a comment line: `// set: pitch=1mm`, `// for: dry_run`,
//! `// deny: warnings`, and, for what `verify` finds, `// edit: FIND => REPLACE` (the first place in the program's
//! files, main module last, that reads FIND), and `// mirror: x` for the sign of every x of the path. Libraries in `ui/lib` are seen from every folder (`use "shop.polish"`).
#![allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]

mod common;

use common::TestFiles;
use polishc::diagnostics::render::{self, Style};
use polishc::motion::Purpose;
use polishc::session::{self, Request, Unwatched};
use polishc::target::Program;

fn words<'a>(source: &'a str, key: &str) -> Vec<&'a str> {
    let prefix = format!("// {key}: ");
    source.lines().filter_map(|line| line.strip_prefix(prefix.as_str())).collect()
}

#[test]
fn ui() {
    insta::glob!("ui/**/*.polish", |path| {
        // What fixtures share is no fixture.
        if path.parent().is_some_and(|folder| folder.ends_with("ui/lib")) {
            return;
        }
        let bytes = std::fs::read(path).expect("a readable fixture");
        let source = String::from_utf8_lossy(&bytes).into_owned();
        let name = path.strip_prefix(std::env::current_dir().expect("a folder")).unwrap_or(path);
        let name = name.to_string_lossy().replace('\\', "/");
        let mut request = Request::new(&name);
        for set in words(&source, "set") {
            let (key, value) = set.split_once('=').expect("`// set: NAME=VALUE`");
            request.sets.push((key.into(), value.into()));
        }
        if words(&source, "for").contains(&"dry_run") {
            request.purpose = Purpose::DryRun;
        }
        request.warnings_are_errors = words(&source, "deny").contains(&"warnings");
        let files = TestFiles::default();
        let mut done = session::compile(&files, &request, &Unwatched);
        let edits = words(&source, "edit");
        let mirrored = words(&source, "mirror").contains(&"x");
        if mirrored || !edits.is_empty() {
            assert!(!done.failed(), "{}", render::render(&done.sources, &done.diagnostics, Style::Short, false));
            let mut program: Program = (**done.jobs[0].program.as_ref().expect("a program")).clone();
            for edit in edits {
                let (find, replace) = edit.split_once(" => ").expect("`// edit: FIND => REPLACE`");
                apply(&mut program, find, replace);
            }
            if mirrored {
                mirror(&mut program);
            }
            session::verify(&mut done, &program);
        }
        let shown = render::render(&done.sources, &done.diagnostics, Style::Human, false);
        for line in shown.lines() {
            for word in ["::", "Some(", "None)", "Rule", "unwrap", "Err("] {
                assert!(
                    !line.contains(word) || source.contains(word),
                    "{name}: a word of the implementation, `{word}`, in `{line}`"
                );
            }
        }
        let summary = render::summary(&done.diagnostics);
        let ending = if summary.is_empty() { "nothing to say".to_string() } else { summary };
        insta::with_settings!({
            omit_expression => true, prepend_module_to_snapshot => false, snapshot_path => "snapshots",
        }, {
            insta::assert_snapshot!(format!("{source}\n---- says ----\n{shown}{ending}\n"));
        });
    });
}

/// Changes the sign of the first number of every linear move.
fn mirror(program: &mut Program) {
    for file in &mut program.files {
        let text = String::from_utf8(file.bytes.clone()).expect("ASCII");
        let mut parts = text.split("MoveL [[");
        let mut mirrored = parts.next().unwrap_or_default().to_string();
        for part in parts {
            mirrored.push_str("MoveL [[");
            mirrored.push_str(&part.strip_prefix('-').map_or(format!("-{part}"), str::to_string));
        }
        file.bytes = mirrored.into_bytes();
    }
}

/// Changes one place of a program. `…` in what is looked for stands for the number that the program has there, and in what
/// takes its place for the same number: speeds change with every better solver, and no edit is about them.
fn apply(program: &mut Program, find: &str, replace: &str) {
    let (before, after) = find.split_once('…').unwrap_or((find, ""));
    for file in program.files.iter_mut().rev() {
        let text = String::from_utf8(file.bytes.clone()).expect("ASCII");
        let Some(start) = text.find(before) else { continue };
        let rest = &text[start + before.len()..];
        let number = rest.find(|c: char| !c.is_ascii_digit() && c != '.').map_or(rest, |end| &rest[..end]);
        let number = if find.contains('…') { number } else { "" };
        if let Some(rest) = rest[number.len()..].strip_prefix(after) {
            file.bytes = format!("{}{}{rest}", &text[..start], replace.replace('…', number)).into_bytes();
            return;
        }
    }
    let texts: Vec<_> = program.files.iter().map(|file| String::from_utf8_lossy(&file.bytes)).collect();
    panic!("no program file reads `{find}`:\n{}", texts.join("\n"));
}
