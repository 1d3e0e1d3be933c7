//! Helpers of the language's tests, and the tests by topic.

mod functions;
mod mistakes;
mod schemas;
mod whole_job;

use polishc::diagnostics::Severity;
use polishc::eval::{Compiled, Options, compile};
use polishc::source::MemoryFiles;

/// The files of a small project.
pub fn files(texts: &[(&str, &str)]) -> MemoryFiles {
    MemoryFiles(texts.iter().map(|(name, text)| (name.to_string(), text.as_bytes().to_vec())).collect())
}

/// The shop's library of `tests/library/`.
pub fn library() -> MemoryFiles {
    files(&[
        ("jobs/flat.polish", include_str!("../library/flat.polish")),
        ("jobs/cell.polish", include_str!("../library/cell.polish")),
    ])
}

/// `language 1` and the text, compiled as a file of its own.
pub fn compile_text(text: &str) -> Compiled {
    compile(&files(&[("test.polish", &format!("language 1\n{text}\n"))]), "test.polish", &Options::default())
}

/// Every diagnostic as `code line:column message`, with help and notes behind it.
pub fn said(compiled: &Compiled) -> Vec<String> {
    compiled
        .diagnostics
        .iter()
        .map(|d| {
            let place = d.primary.as_ref().map_or_else(String::new, |label| {
                let (line, column) = compiled.sources.line_column(label.span.file, label.span.start as usize);
                format!(" {line}:{column}")
            });
            let severity = if d.severity == Severity::Error { "" } else { " warning" };
            let mut text = format!("{}{severity}{place} {}", d.code, d.message);
            d.notes.iter().for_each(|note| text.push_str(&format!(" | {note}")));
            d.help.iter().for_each(|help| text.push_str(&format!(" > {help}")));
            text
        })
        .collect()
}
