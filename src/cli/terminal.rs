//! What a command says while and after it runs: diagnostics and times on standard error, results on standard output.
#![allow(clippy::disallowed_methods, reason = "cli is where disk, clock and environment are")]
#![allow(clippy::print_stderr, reason = "cli is where standard output is")]

use super::arguments::{Colour, Common, MessageFormat};
use super::output;
use crate::diagnostics::render::{self, Style};
use crate::diagnostics::{Diagnostic, Severity};
use crate::session::Watch;
use crate::source::Sources;
use std::io::{IsTerminal, Write};
use std::sync::Mutex;
use std::time::Instant;

/// Exit status of a job or data with errors.
pub const WRONG_INPUT: u8 = 1;
/// Exit status of a wrong command line.
pub const WRONG_COMMAND: u8 = 2;
/// Exit status of a bug in polishc.
pub const BUG: u8 = 101;

/// Times the passes: each is counted from its own call to the next one's.
pub struct Timings {
    start: Instant,
    passes: Mutex<Vec<(&'static str, f64)>>,
}

impl Timings {
    pub fn new() -> Timings {
        Timings { start: Instant::now(), passes: Mutex::new(Vec::new()) }
    }

    /// The passes with their milliseconds, and those of all.
    fn milliseconds(&self) -> (Vec<(&'static str, f64)>, f64) {
        let end = self.start.elapsed().as_secs_f64();
        let passes = self.passes.lock().map(|p| p.clone()).unwrap_or_default();
        let rounded = |seconds: f64| (seconds * 1e5).round() / 100.0;
        let each = passes.iter().enumerate().map(|(i, (name, from))| {
            let to = passes.get(i + 1).map_or(end, |(_, at)| *at);
            (*name, rounded(to - from))
        });
        (each.collect(), rounded(end))
    }

    fn to_json(&self) -> String {
        let (passes, total) = self.milliseconds();
        let lines: Vec<_> = passes.iter().map(|(name, ms)| serde_json::json!({ "pass": name, "ms": ms })).collect();
        serde_json::json!({ "passes": lines, "total_ms": total }).to_string() + "\n"
    }
}

impl Watch for Timings {
    fn pass(&self, name: &'static str) {
        if let Ok(mut passes) = self.passes.lock() {
            passes.push((name, self.start.elapsed().as_secs_f64()));
        }
    }
}

pub fn show(common: &Common, sources: &Sources, diagnostics: &[Diagnostic]) {
    let style = match common.message_format {
        MessageFormat::Human => Style::Human,
        MessageFormat::Short => Style::Short,
        MessageFormat::Json => Style::Json,
    };
    let colour = match common.color {
        Colour::Always => true,
        Colour::Never => false,
        Colour::Auto => std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()),
    };
    let shown: Vec<Diagnostic> = diagnostics
        .iter()
        .filter(|d| !(common.quiet && d.severity == Severity::Warning && common.deny.is_none()))
        .cloned()
        .collect();
    eprint!("{}", render::render(sources, &shown, style, colour));
    let mut summary = render::summary(&shown);
    if common.deny.is_some() && !shown.is_empty() && shown.iter().all(|d| d.severity == Severity::Warning) {
        summary.push_str(", denied by `--deny warnings`");
    }
    if style != Style::Json && !summary.is_empty() {
        eprintln!("{summary}");
    }
}

/// Ends a command: tells and writes the timings if they were asked for.
pub fn finish(common: &Common, timings: &Timings, status: u8) -> u8 {
    if common.verbose && common.message_format != MessageFormat::Json {
        let (passes, total) = timings.milliseconds();
        for (name, ms) in passes.into_iter().chain([("all", total)]) {
            eprintln!("{name:<10} {ms:>10.2} ms");
        }
    }
    if let Some(path) = &common.timings
        && let Err(error) = std::fs::write(path, timings.to_json())
    {
        eprintln!("the timings could not be written to `{}`: {}", path.display(), output::words(&error));
        return status.max(WRONG_INPUT);
    }
    status
}

/// One line on standard output; a closed pipe is nobody's error.
pub fn say(text: &str) {
    writeln!(std::io::stdout(), "{text}").ok();
}
