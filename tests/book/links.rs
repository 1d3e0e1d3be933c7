//! Links lead to pages and headings that are there, and every page is in the book's list.

use crate::{all_pages, pages, read};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A page without its blocks of code.
fn prose(page: &str) -> String {
    let mut code = false;
    let mut text = String::new();
    for line in page.lines() {
        if line.trim_start().starts_with("```") {
            code = !code;
        } else if !code {
            text.push_str(line);
            text.push('\n');
        }
    }
    text
}

/// The targets of a page's links, with the line they stand on.
fn links(page: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut code = false;
    for (i, line) in page.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            code = !code;
        }
        if code {
            continue;
        }
        // Text in backticks is no link.
        let plain: String = line.split('`').step_by(2).collect::<Vec<_>>().join("`");
        for part in plain.split("](").skip(1) {
            if let Some((target, _)) = part.split_once(')') {
                found.push((i + 1, target.to_string()));
            }
        }
    }
    found
}

/// The names that forges and mdBook give to headings.
fn anchors(page: &str) -> BTreeSet<String> {
    let headings = prose(page);
    let headings = headings.lines().filter(|line| line.starts_with('#'));
    headings
        .map(|line| {
            let text = line.trim_start_matches('#').trim().to_lowercase();
            let kept = text.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
            kept.map(|c| if c == ' ' { '-' } else { c }).collect()
        })
        .collect()
}

fn joined(page: &Path, target: &str) -> PathBuf {
    let mut path = page.parent().map(Path::to_path_buf).unwrap_or_default();
    for part in target.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(path.pop()),
            word => path.push(word),
        }
    }
    path
}

#[test]
fn links_lead_somewhere() {
    let mut bad = Vec::new();
    let others = ["CONTRIBUTING.md", "grammar/README.md"].map(PathBuf::from);
    for page in all_pages().into_iter().chain(others) {
        let text = read(&page);
        for (line, target) in links(&text) {
            if target.contains("://") {
                continue;
            }
            let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let path = if file.is_empty() { page.clone() } else { joined(&page, file) };
            if !path.exists() {
                bad.push(format!("{}:{line}: nothing is at `{target}`", page.display()));
            } else if !anchor.is_empty() && !anchors(&read(&path)).contains(anchor) {
                bad.push(format!("{}:{line}: no heading is called `{anchor}`", page.display()));
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}

#[test]
fn every_page_is_in_the_list() {
    let summary = Path::new("docs/SUMMARY.md");
    let listed: BTreeSet<PathBuf> = links(&read(summary)).iter().map(|(_, target)| joined(summary, target)).collect();
    // What readers were asked and answered is kept for those who work on the book; it is no page of it.
    let is_page = |page: &PathBuf| page != summary && !page.starts_with("docs/dev/transcripts");
    let missing: Vec<_> = pages("docs").into_iter().filter(|page| is_page(page) && !listed.contains(page)).collect();
    assert!(missing.is_empty(), "docs/SUMMARY.md does not list {missing:?}");
}
