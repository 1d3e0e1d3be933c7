//! The book says what is so: its code compiles, its commands run, its links lead somewhere, its tables are the sources'.
//!
//! A block of code is marked by its first line, as any Markdown reader takes it:
//!
//! | mark | what it is | what is tested |
//! | --- | --- | --- |
//! | `polish` | a file; `language 1` is put before it if it does not begin so | names, types, dimensions, ranges; no warning |
//! | `polish,fragment` | entries of the job of `examples/flat_340`, in place of its own or beside them | the same |
//! | `polish,fragment(workpiece.error)` | entries of that record of the job; `cell` is the cell's record | the same |
//! | … `,use(std.controllers.krc4)` | the fragment needs this module | |
//! | … `,plan` | as far as its program | everything |
//! | … `,fails(E0303)` | wrong on purpose | it says that code, and no other |
//! | … `,warns(W0702)` | odd on purpose | it says that warning, and nothing else |
//! | … `,edit` | a fragment that is also put into the file of the page's own copy of the example | the commands below it |
//! | `diff,file(NAME)` | an edit of a file in the page's copy | the commands below it |
//! | `console` | commands behind `$ `, with all that they say; `...` is any number of lines | they say it, `? N` they end with N |
//!
//! Commands of one page run one after the other in a copy of `examples/`. Pages of the error index are excerpts with `…` in
//! them: those that have none must give their code; the others are shown by `tests/ui`.
//!
//! `BOOK_UPDATE=always` puts into the pages what the tool says now: outputs, the grammar, the index of errors. Read the diff.
#![allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]

mod blocks;
mod code;
mod commands;
mod errors;
mod figures;
mod functions;
mod grammar;
mod links;
mod orientation;
mod splice;

use std::path::{Path, PathBuf};

/// Whether pages are to be brought up to date instead of tested.
fn update() -> bool {
    std::env::var("BOOK_UPDATE").is_ok_and(|value| value == "always")
}

/// The Markdown files under a folder, in order.
fn pages(folder: &str) -> Vec<PathBuf> {
    let (mut found, mut todo) = (Vec::new(), vec![PathBuf::from(folder)]);
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            todo.extend(std::fs::read_dir(&path).expect("a readable folder").map(|e| e.expect("an entry").path()));
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// All pages that are tested: the book and the README.
fn all_pages() -> Vec<PathBuf> {
    let mut all = pages("docs");
    all.push("README.md".into());
    all
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// `text` must be what stands in the page; where pages are brought up to date it is put there.
fn keep(path: &Path, text: &str, what: &str) {
    if read(path) == text {
        return;
    }
    assert!(
        update(),
        "{}: {what} is not what the sources say; run `BOOK_UPDATE=always cargo test --test book` and read the diff",
        path.display()
    );
    std::fs::write(path, text).expect("a page that can be written");
}

/// The page with what stands between the two marks replaced.
fn between(page: &str, start: &str, end: &str, text: &str) -> String {
    let from = page.find(start).unwrap_or_else(|| panic!("no `{start}`")) + start.len();
    let to = from + page[from..].find(end).unwrap_or_else(|| panic!("no `{end}`"));
    format!("{}{text}{}", &page[..from], &page[to..])
}
