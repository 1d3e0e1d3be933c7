//! Every block of the language compiles, or fails as it says.

use crate::blocks::{Block, blocks};
use crate::splice::splice;
use crate::{all_pages, read};
use polishc::diagnostics::render::{self, Style};
use polishc::session::{self, Compilation, Request, Until, Unwatched};
use polishc::source::{FileError, FileId, FileProvider, normalise};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The example that fragments are put into, and the folder that files of the book stand in.
pub const JOB: &str = "examples/flat_340/flat_340.polish";
pub const CELL: &str = "examples/flat_340/cell.polish";
/// A file of the book, in the example's folder.
pub const FILE: &str = "examples/flat_340/book.polish";

/// The tree's files, some of them changed.
#[derive(Default)]
pub struct BookFiles(pub BTreeMap<String, String>);

impl FileProvider for BookFiles {
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>, FileError> {
        let bytes = match self.0.get(path) {
            Some(text) => text.as_bytes().to_vec(),
            None => std::fs::read(path).map_err(|_| FileError::NotFound)?,
        };
        let size = bytes.len() as u64;
        if size > limit { Err(FileError::TooLarge { size, limit }) } else { Ok(bytes) }
    }

    fn resolve(&self, from: &str, path: &str) -> Result<String, FileError> {
        let whole = normalise(from, path).ok_or(FileError::Outside)?;
        if whole.starts_with("examples/flat_340/") { Ok(whole) } else { Err(FileError::Outside) }
    }
}

/// A file with the line that every file begins with.
pub fn whole(text: &str) -> String {
    let begins = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with("//"));
    if begins.is_some_and(|line| line.starts_with("language ")) { text.into() } else { format!("language 1\n{text}") }
}

/// The files that a fragment makes of the example's, and the one to compile.
pub fn fragment(path: &str, text: &str) -> Result<(BookFiles, String), String> {
    let (file, path) = match path.strip_prefix("cell") {
        Some(rest) => (CELL, rest.trim_start_matches('.')),
        None => (JOB, path),
    };
    let spliced = splice(&read(Path::new(file)), path, text)?;
    Ok((BookFiles(BTreeMap::from([(file.to_string(), spliced)])), JOB.to_string()))
}

pub fn compile(files: &BookFiles, path: &str, until: Until) -> Compilation {
    let request = Request { until, ..Request::new(path) };
    session::compile(files, &request, &Unwatched)
}

/// The codes that were said.
pub fn said(done: &Compilation) -> BTreeSet<&'static str> {
    done.diagnostics.iter().map(|diagnostic| diagnostic.code.as_str()).collect()
}

/// What is wrong with a block, if anything is.
fn wrong(block: &Block) -> Option<String> {
    for (word, _) in &block.words {
        if !["fragment", "use", "plan", "fails", "warns", "edit"].contains(&word.as_str()) {
            return Some(format!("`{word}` is no word of a mark"));
        }
    }
    if block.word("fragment").is_none() && block.word("fails").is_none() {
        let text = whole(&block.text);
        match polishc::syntax::format::format(FileId(0), &text) {
            Ok(formatted) if formatted != text => return Some(format!("`polishc fmt` would write\n{formatted}")),
            _ => {}
        }
    }
    let (files, path) = match block.word("fragment") {
        Some(place) => match fragment(place, &block.text) {
            Ok((mut files, path)) => {
                if let Some(modules) = block.word("use") {
                    let uses: String = modules.split(' ').map(|module| format!("use {module}\n")).collect();
                    let text = files.0.remove(&path).unwrap_or_else(|| read(Path::new(&path)));
                    files.0.insert(path.clone(), text.replacen("language 1\n", &format!("language 1\n{uses}"), 1));
                }
                (files, path)
            }
            Err(why) => return Some(why),
        },
        None => (BookFiles(BTreeMap::from([(FILE.to_string(), whole(&block.text))])), FILE.to_string()),
    };
    let until = if block.word("plan").is_some() { Until::Program } else { Until::Types };
    let done = compile(&files, &path, until);
    let expected: BTreeSet<&str> =
        block.word("fails").into_iter().chain(block.word("warns")).flat_map(|codes| codes.split(' ')).collect();
    if block.word("plan").is_some() && expected.is_empty() && done.jobs.iter().all(|job| job.result.is_none()) {
        return Some("it was to be planned, and holds no job".into());
    }
    (said(&done) != expected).then(|| {
        let told = render::render(&done.sources, &done.diagnostics, Style::Human, false);
        format!("it was to say {expected:?}, and says\n{told}")
    })
}

#[test]
fn every_block_compiles_or_fails_as_it_says() {
    let (mut tested, mut bad) = (0, Vec::new());
    let mut look = |name: &str, text: &str| {
        for block in blocks(text).into_iter().filter(|block| block.language == "polish") {
            tested += 1;
            if let Some(why) = wrong(&block) {
                bad.push(format!("{name}:{}: {why}\n{}", block.line, block.text));
            }
        }
    };
    for page in all_pages() {
        // Those of the error index have a test of their own.
        if page.parent().is_some_and(|folder| folder.ends_with("errors")) {
            continue;
        }
        look(&page.display().to_string(), &read(&page));
    }
    // Examples in the doc comments of the vocabulary: files, or, for functions, conditions.
    let mut todo = vec![std::path::PathBuf::from("stdlib")];
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            todo.extend(std::fs::read_dir(&path).expect("a readable folder").map(|e| e.expect("an entry").path()));
            continue;
        }
        let text = read(&path);
        let docs: Vec<&str> = text.lines().map(|line| line.trim_start().strip_prefix("///").unwrap_or("")).collect();
        let docs: Vec<&str> = docs.iter().map(|line| line.strip_prefix(' ').unwrap_or(line)).collect();
        let conditions = path.ends_with("functions.polish");
        let mut code = false;
        let mut lines = Vec::new();
        for (i, line) in docs.into_iter().enumerate() {
            code ^= line.starts_with("```");
            let is_condition = conditions && code && !line.starts_with("```");
            lines.push(if is_condition { format!("let book_{i}: Bool = {line}") } else { line.to_string() });
        }
        look(&path.display().to_string(), &lines.join("\n"));
    }
    assert!(bad.is_empty(), "{} of {tested} blocks:\n\n{}", bad.len(), bad.join("\n"));
    assert!(tested > 40, "only {tested} blocks of the language were found");
}
