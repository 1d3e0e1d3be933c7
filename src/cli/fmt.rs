//! `polishc fmt`: files in the one look, all of them or none.
#![allow(clippy::disallowed_methods, reason = "cli is where the disk is")]

use super::arguments::{Common, MessageFormat};
use super::disk::Disk;
use super::output::{self, Output, RealFolder};
use super::terminal::{Timings, WRONG_INPUT, finish, say, show};
use crate::check::load;
use crate::diagnostics::codes as code;
use crate::diagnostics::{Diagnostic, Severity};
use crate::session::Watch;
use crate::source::{FileId, Sources, Span};
use crate::syntax::format;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A file as it is and as it is to be.
struct Formatted<'a> {
    path: &'a Path,
    /// Without links: what is written is the file that a link names.
    place: PathBuf,
    file: FileId,
    new: String,
    changed: bool,
}

/// Formats `files`, or with `check` only says which would change.
pub fn format(common: &Common, files: &[PathBuf], check: bool) -> u8 {
    let timings = Timings::new();
    timings.pass("format");
    let mut sources = Sources::default();
    let mut diagnostics = Vec::new();
    let mut formatted = Vec::new();
    let mut seen = BTreeSet::new();
    for path in files {
        let place = path.canonicalize().unwrap_or_else(|_| path.clone());
        if seen.insert(place.clone()) {
            match one(path, place, &mut sources) {
                Ok(done) => formatted.push(done),
                Err(mut mistakes) => diagnostics.append(&mut mistakes),
            }
        }
    }
    if diagnostics.is_empty() {
        match check {
            true => diagnostics.extend(formatted.iter().filter(|f| f.changed).map(|f| unformatted(f, &sources))),
            false => diagnostics.extend(write(&formatted).err().map(|refused| *refused)),
        }
    }
    show(common, &sources, &diagnostics);
    let failed = diagnostics.iter().any(|d| d.severity == Severity::Error);
    if !common.quiet && common.message_format != MessageFormat::Json && (check || !failed) {
        for file in formatted.iter().filter(|file| !(check && file.changed)) {
            let word = if file.changed { "formatted" } else { "good" };
            say(&format!("{}: {word}", file.path.display()));
        }
    }
    finish(common, &timings, if failed { WRONG_INPUT } else { 0 })
}

fn one<'a>(path: &'a Path, place: PathBuf, sources: &mut Sources) -> Result<Formatted<'a>, Vec<Diagnostic>> {
    let name = path.to_string_lossy();
    let text = load::read_text(&Disk::new(path, true), &name).map_err(|unusable| vec![*unusable])?;
    let file = sources.add(name.as_ref(), text.as_str());
    let new = format::format(file, &text)?;
    let changed = new != text;
    Ok(Formatted { path, place, file, new, changed })
}

fn unformatted(formatted: &Formatted<'_>, sources: &Sources) -> Diagnostic {
    let old = sources.text(formatted.file);
    let same = old.split_inclusive('\n').zip(formatted.new.split_inclusive('\n')).take_while(|(old, new)| old == new);
    let start = same.map(|(old, _)| old.len()).sum::<usize>();
    let line = old[start..].lines().next().unwrap_or_default();
    let span = Span::new(formatted.file, start, start + line.len());
    Diagnostic::error(code::E1204, span, format!("`{}` is not formatted", formatted.path.display()))
        .help(format!("run `polishc fmt {}`", formatted.path.display()))
}

fn write(formatted: &[Formatted<'_>]) -> Result<(), Box<Diagnostic>> {
    let refuse = |message: String| Box::new(Diagnostic::placeless(code::E1201, message).help("no file was changed"));
    let mut outputs = Vec::new();
    for file in formatted.iter().filter(|file| file.changed) {
        // Moving a new file into its place would succeed: the folder's right, not the file's, decides that.
        if std::fs::metadata(&file.place).is_ok_and(|found| found.permissions().readonly()) {
            return Err(refuse(format!("`{}` could not be written: it is read-only", file.path.display())));
        }
        let folder = file.place.parent().unwrap_or(Path::new(".")).to_path_buf();
        let name = file.place.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        outputs.push(Output { folder, files: vec![(name, file.new.clone().into_bytes())], stale: Vec::new() });
    }
    output::write_all(&mut RealFolder, &outputs).map_err(refuse)
}
