//! Mends: every suggestion that a fixture of `tests/ui` draws is applied, and the text compiled again. The diagnostic is gone
//! then, and nothing new is said.
#![allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]

mod common;

use common::TestFiles;
use polishc::diagnostics::{Diagnostic, Severity};
use polishc::motion::Purpose;
use polishc::session::{self, Compilation, Request, Until, Unwatched};
use std::path::{Path, PathBuf};

fn fixtures(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        match path.is_dir() {
            true if path.ends_with("lib") => {}
            true => fixtures(&path, into),
            false if path.extension().is_some_and(|e| e == "polish") => into.push(path),
            false => {}
        }
    }
}

/// Compiled as far as names, types and numbers: no pass below makes suggestions.
fn compile(name: &str, text: &str, source: &str) -> Compilation {
    let mut request = Request { until: Until::Types, ..Request::new(name) };
    for set in source.lines().filter_map(|line| line.strip_prefix("// set: ")) {
        let (key, value) = set.split_once('=').expect("`// set: NAME=VALUE`");
        request.sets.push((key.into(), value.into()));
    }
    if source.contains("// for: dry_run") {
        request.purpose = Purpose::DryRun;
    }
    let mut files = TestFiles::default();
    files.extra.insert(name.to_string(), text.as_bytes().to_vec());
    session::compile(&files, &request, &Unwatched)
}

fn mended(text: &str, diagnostic: &Diagnostic) -> String {
    let mut text = text.to_string();
    let mut mends = diagnostic.suggestions.clone();
    mends.sort_by_key(|mend| std::cmp::Reverse(mend.span.start));
    for mend in mends {
        text.replace_range(mend.span.start as usize..mend.span.end as usize, &mend.replacement);
    }
    text
}

fn said(diagnostics: &[Diagnostic]) -> Vec<String> {
    diagnostics.iter().map(|d| format!("{}: {}", d.code, d.message)).collect()
}

#[test]
fn every_suggestion_of_every_fixture_mends_and_breaks_nothing() {
    let mut paths = Vec::new();
    fixtures(Path::new("tests/ui"), &mut paths);
    paths.sort();
    let (mut applied, mut wrong) = (0, Vec::new());
    let mut without: std::collections::BTreeMap<String, usize> = std::collections::BTreeMap::new();
    for path in &paths {
        let Ok(text) = std::fs::read_to_string(path) else { continue };
        let name = path.to_string_lossy().replace('\\', "/");
        let before = compile(&name, &text, &text);
        for diagnostic in &before.diagnostics {
            let here = |mend: &polishc::diagnostics::Suggestion| before.sources.name(mend.span.file) == name;
            if diagnostic.suggestions.is_empty() {
                *without.entry(diagnostic.code.as_str().to_string()).or_default() += 1;
                continue;
            }
            if !diagnostic.suggestions.iter().all(here) {
                wrong.push(format!("{name}: {} mends another file", diagnostic.code));
                continue;
            }
            applied += 1;
            let after = mended(&text, diagnostic);
            let again = compile(&name, &after, &text);
            let (mut old, new) = (said(&before.diagnostics), said(&again.diagnostics));
            let own = format!("{}: {}", diagnostic.code, diagnostic.message);
            old.retain(|other| *other != own);
            // The same slip may stand in a file several times; each mend takes one away.
            let count = |all: &[String], one: &str| all.iter().filter(|other| *other == one).count();
            let gone = count(&new, &own) < count(&said(&before.diagnostics), &own);
            let fresh: Vec<&String> = new.iter().filter(|line| **line != own && !old.contains(line)).collect();
            // A file whose mistakes hid what comes after them (types, say) may say more; what a mend itself causes is an
            // error at its own place.
            let at_mend = again.diagnostics.iter().filter(|d| d.severity == Severity::Error).any(|d| {
                let place = d.primary.as_ref().map(|label| label.span.start);
                let start = diagnostic.suggestions.iter().map(|mend| mend.span.start).min();
                place.zip(start).is_some_and(|(place, start)| place.abs_diff(start) < 4)
                    && fresh.contains(&&format!("{}: {}", d.code, d.message))
            });
            if !gone || at_mend || (before.diagnostics.len() == 1 && !fresh.is_empty() && !own.starts_with("E01")) {
                wrong.push(format!("{name}: the mend of {own}\n    leaves {new:?}"));
            }
        }
    }
    println!("{applied} suggestions applied; without one: {without:?}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(applied > 50, "only {applied} suggestions");
}
