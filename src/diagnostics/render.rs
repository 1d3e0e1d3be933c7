//! Renderers: the same diagnostics as text for a terminal, as one line each, or as JSON lines.
//!
//! In: [`Sources`] and [`Diagnostic`]s, any order. Out: a string. Diagnostics come in order of place, those without a
//! place last, so that the same mistakes always read the same.

use super::{Diagnostic, Label, Severity};
use crate::source::{FileId, Sources};
use codespan_reporting::diagnostic as codespan;
use codespan_reporting::files::{Error, Files, SimpleFile};
use codespan_reporting::term::{self, Config, DisplayStyle};
use serde_json::{Value, json};
use std::ops::Range;

/// How diagnostics are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// With the source, for people.
    Human,
    /// One line each: `file:line:column: error[E0101]: message`.
    Short,
    /// One JSON object a line (the fields are fixed by the command line's page).
    Json,
}

/// Puts diagnostics into the order of their places and drops those that are said twice.
pub fn sort(diagnostics: &mut Vec<Diagnostic>) {
    diagnostics.sort_by_key(|d| {
        let place = d.primary.as_ref().map(|p| (p.span.file, p.span.start, p.span.end));
        (place.is_none(), place, d.code, d.message.clone())
    });
    diagnostics.dedup();
}

/// All diagnostics as one text. `colour` only matters for [`Style::Human`] and [`Style::Short`].
pub fn render(sources: &Sources, diagnostics: &[Diagnostic], style: Style, colour: bool) -> String {
    match style {
        Style::Json => diagnostics.iter().map(|d| format!("{}\n", to_json(sources, d))).collect(),
        Style::Human => terminal(sources, diagnostics, DisplayStyle::Rich, colour),
        Style::Short => terminal(sources, diagnostics, DisplayStyle::Short, colour),
    }
}

/// The closing line: `2 errors, 1 warning`, or nothing.
pub fn summary(diagnostics: &[Diagnostic]) -> String {
    let errors = diagnostics.iter().filter(|d| d.severity == Severity::Error).count();
    let warnings = diagnostics.len() - errors;
    let count = |n: usize, word: &str| match n {
        0 => None,
        1 => Some(format!("1 {word}")),
        n => Some(format!("{n} {word}s")),
    };
    [count(errors, "error"), count(warnings, "warning")].into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// The JSON object of one diagnostic. Lines and columns count from 1, columns in characters; `end_column` is the
/// column after the last character.
pub fn to_json(sources: &Sources, diagnostic: &Diagnostic) -> Value {
    let place = |label: &Label| {
        let (line, column) = sources.line_column(label.span.file, label.span.start as usize);
        let (end_line, end_column) = sources.line_column(label.span.file, label.span.end as usize);
        json!({
            "file": sources.name(label.span.file),
            "line": line, "column": column, "end_line": end_line, "end_column": end_column,
            "text": label.text,
        })
    };
    let primary = diagnostic.primary.as_ref().map(place).unwrap_or_else(|| json!({}));
    let mut labels: Vec<Value> = Vec::new();
    if diagnostic.primary.as_ref().is_some_and(|p| !p.text.is_empty()) {
        labels.push(primary.clone());
    }
    labels.extend(diagnostic.secondary.iter().map(place));
    let suggestions: Vec<Value> = diagnostic
        .suggestions
        .iter()
        .map(|s| {
            let mut value = place(&Label { span: s.span, text: String::new() });
            if let Some(map) = value.as_object_mut() {
                map.remove("text");
                map.insert("replacement".into(), json!(s.replacement));
            }
            value
        })
        .collect();
    json!({
        "code": diagnostic.code.as_str(),
        "severity": match diagnostic.severity { Severity::Error => "error", Severity::Warning => "warning" },
        "message": diagnostic.message,
        "file": primary["file"], "line": primary["line"], "column": primary["column"],
        "end_line": primary["end_line"], "end_column": primary["end_column"],
        "labels": labels,
        "notes": diagnostic.notes,
        "help": diagnostic.help,
        "suggestions": suggestions,
    })
}

/// [`Sources`] as codespan wants to see them.
struct View(Vec<SimpleFile<String, String>>);

impl<'a> Files<'a> for View {
    type FileId = usize;
    type Name = &'a str;
    type Source = &'a str;

    fn name(&'a self, id: usize) -> Result<&'a str, Error> {
        Ok(self.0.get(id).ok_or(Error::FileMissing)?.name().as_str())
    }
    fn source(&'a self, id: usize) -> Result<&'a str, Error> {
        Ok(self.0.get(id).ok_or(Error::FileMissing)?.source().as_str())
    }
    fn line_index(&'a self, id: usize, byte: usize) -> Result<usize, Error> {
        self.0.get(id).ok_or(Error::FileMissing)?.line_index((), byte)
    }
    fn line_range(&'a self, id: usize, line: usize) -> Result<Range<usize>, Error> {
        self.0.get(id).ok_or(Error::FileMissing)?.line_range((), line)
    }
}

/// Bytes of a source line that is still shown. Six lines of a usual terminal; a file that is one line of a megabyte would
/// bury its message.
const WIDEST: usize = 500;

fn labels(diagnostic: &Diagnostic) -> impl Iterator<Item = &Label> {
    diagnostic.primary.iter().chain(&diagnostic.secondary)
}

/// Whether a line that the label touches is too wide to be shown.
fn too_wide(sources: &Sources, label: &Label) -> bool {
    let bytes = sources.text(label.span.file).as_bytes();
    let (start, end) = ((label.span.start as usize).min(bytes.len()), (label.span.end as usize).min(bytes.len()));
    let before = bytes[..start].iter().rev().take_while(|byte| **byte != b'\n').count();
    let after = bytes[end.max(start)..].iter().take_while(|byte| **byte != b'\n').count();
    bytes[start - before..end.max(start) + after].split(|byte| *byte == b'\n').any(|line| line.len() > WIDEST)
}

fn terminal(sources: &Sources, diagnostics: &[Diagnostic], style: DisplayStyle, colour: bool) -> String {
    let view =
        View(sources.iter().map(|(_, name, text)| SimpleFile::new(name.to_string(), text.to_string())).collect());
    let with_source = matches!(style, DisplayStyle::Rich);
    let config = Config { display_style: style, tab_width: 4, ..Config::default() };
    let mut text = String::new();
    for diagnostic in diagnostics {
        let report = to_codespan(diagnostic);
        if with_source && labels(diagnostic).any(|label| too_wide(sources, label)) {
            text.push_str(&terminal(sources, std::slice::from_ref(diagnostic), DisplayStyle::Short, colour));
            for note in &report.notes {
                text.push_str(&format!("  = {note}\n"));
            }
            text.push('\n');
            continue;
        }
        let done = if colour {
            coloured(&config, &view, &report).map(|t| text.push_str(&t))
        } else {
            term::emit_into_string(&config, &view, &report).map(|t| text.push_str(&t))
        };
        if done.is_err() {
            // A place outside its file is a fault of ours; the sentence is still worth having.
            text.push_str(&format!("{}: {}\n", diagnostic.code, diagnostic.message));
        }
    }
    text
}

fn coloured(config: &Config, view: &View, report: &codespan::Diagnostic<usize>) -> Result<String, Error> {
    use codespan_reporting::term::termcolor::Ansi;
    let mut writer = Ansi::new(Vec::new());
    term::emit_to_write_style(&mut writer, config, view, report)?;
    Ok(String::from_utf8_lossy(&writer.into_inner()).into_owned())
}

fn to_codespan(diagnostic: &Diagnostic) -> codespan::Diagnostic<usize> {
    let severity = match diagnostic.severity {
        Severity::Error => codespan::Severity::Error,
        Severity::Warning => codespan::Severity::Warning,
    };
    let range = |label: &Label| label.span.start as usize..label.span.end as usize;
    let file = |FileId(id): FileId| id as usize;
    let mut labels = Vec::new();
    if let Some(primary) = &diagnostic.primary {
        labels.push(
            codespan::Label::primary(file(primary.span.file), range(primary)).with_message(primary.text.as_str()),
        );
    }
    for label in &diagnostic.secondary {
        labels.push(codespan::Label::secondary(file(label.span.file), range(label)).with_message(label.text.as_str()));
    }
    let mut notes = diagnostic.notes.clone();
    notes.extend(diagnostic.help.iter().map(|help| format!("help: {help}")));
    codespan::Diagnostic::new(severity)
        .with_code(diagnostic.code.as_str())
        .with_message(&diagnostic.message)
        .with_labels(labels)
        .with_notes(notes)
}
