//! `polishc doc`: the vocabulary on the terminal or as a page.

use super::arguments::{Common, MessageFormat};
use super::output::{self, Output, RealFolder};
use super::terminal::{WRONG_INPUT, say, show};
use crate::diagnostics::codes as code;
use crate::diagnostics::{Code, Diagnostic};
use crate::doc::{Found, Manual, html, text};
use crate::source::Sources;
use std::path::Path;

/// Tells of one word, or which words there are.
pub fn word(common: &Common, name: Option<&str>) -> u8 {
    let manual = Manual::new();
    let Some(name) = name else {
        say(text::overview(&manual).trim_end());
        return 0;
    };
    let told: Vec<String> = match manual.find(name) {
        Found::Words(words) => words.into_iter().map(|(module, entry)| text::entry(&manual, module, entry)).collect(),
        Found::Fields(fields) => {
            let told =
                fields.into_iter().map(|(schema, page)| format!("A field of {}\n{}", schema.name, text::field(page)));
            told.collect()
        }
        missing => {
            show(common, &Sources::default(), &[unknown(name, missing)]);
            return WRONG_INPUT;
        }
    };
    say(told.join("\n").trim_end());
    0
}

fn unknown(name: &str, found: Found<'_>) -> Diagnostic {
    let diagnostic = Diagnostic::placeless(code::E1205, format!("the vocabulary has no word `{name}`"));
    match (Code::find(name), found) {
        (Some(code), _) => diagnostic.help(format!("`polishc explain {code}` tells of a diagnostic's code")),
        (None, Found::Near(near)) => diagnostic.help(format!("did you mean `{near}`?")),
        _ => diagnostic.help("`polishc doc` lists all words"),
    }
}

/// Writes the page.
pub fn page(common: &Common, folder: Option<&Path>) -> u8 {
    let folder = folder.unwrap_or(Path::new("out/doc")).to_path_buf();
    let page = html::page(&Manual::new(), env!("CARGO_PKG_VERSION"));
    let place = folder.join("index.html");
    let output = Output { folder, files: vec![("index.html".into(), page.into_bytes())], stale: Vec::new() };
    if let Err(message) = output::write_all(&mut RealFolder, &[output]) {
        let diagnostic = Diagnostic::placeless(code::E1201, message)
            .help("nothing was written; choose a folder that can be written to with `-o DIR`, or make room");
        show(common, &Sources::default(), &[diagnostic]);
        return WRONG_INPUT;
    }
    if !common.quiet && common.message_format != MessageFormat::Json {
        say(&format!("wrote {}", place.display()));
    }
    0
}
