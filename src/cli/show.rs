//! `polishc show`: the job as it stands, every value with who said it; to be pinned beside a run.

use super::arguments::{Common, Deny, MessageFormat};
use super::disk::Disk;
use super::terminal::{Timings, WRONG_INPUT, finish, say, show};
use crate::diagnostics::Severity;
use crate::eval::{self, CompiledJob, Options, Said, Shown, ShownField};
use crate::session::{Watch, allow};
use crate::source::{Sources, Span};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// Comments that say where a value comes from begin at most so far to the right; a longer line has its own after it.
const COMMENT_COLUMN: usize = 64;

/// Shows the jobs of a file: all of each, or only what the job does not say.
pub fn job(common: &Common, file: &Path, options: &Options, defaults: bool) -> u8 {
    let timings = Timings::new();
    timings.pass("check");
    let disk = Disk::new(file, common.allow_outside);
    let mut done = eval::compile(&disk, &file.to_string_lossy(), options);
    done.diagnostics.retain(|diagnostic| allow::reason(diagnostic, &done.allows).is_none());
    show(common, &done.sources, &done.diagnostics);
    let denied = common.deny == Some(Deny::Warnings);
    if done.diagnostics.iter().any(|d| denied || d.severity == Severity::Error) {
        return finish(common, &timings, WRONG_INPUT);
    }
    for (i, job) in done.jobs.iter().enumerate() {
        if common.message_format == MessageFormat::Json {
            say(&to_json(&done.sources, job, defaults).to_string());
            continue;
        }
        if i > 0 {
            say("");
        }
        let text = if defaults { not_said(job) } else { whole(&done.sources, job) };
        say(text.trim_end());
    }
    finish(common, &timings, 0)
}

/// The job as the language would write it, with a comment behind each value.
fn whole(sources: &Sources, job: &CompiledJob) -> String {
    let mut lines: Vec<(String, String)> = Vec::new();
    for param in &job.params {
        lines.push((format!("param {} = {}", param.name, param.value), String::new()));
    }
    if !lines.is_empty() {
        lines.push(Default::default());
    }
    lines.push((format!("job {} {{", job.name), String::new()));
    fields(sources, &job.fields, 1, &mut lines);
    if !job.requirements.is_empty() {
        lines.push(("    require {".into(), String::new()));
        for requirement in &job.requirements {
            lines.push((format!("        {}", requirement.text), place(sources, requirement.span)));
        }
        lines.push(("    }".into(), String::new()));
    }
    lines.push(("}".into(), String::new()));
    let width = |line: &str| line.chars().count();
    let commented = lines.iter().filter(|(_, comment)| !comment.is_empty());
    let column = commented.map(|(line, _)| width(line) + 2).filter(|end| *end <= COMMENT_COLUMN).max().unwrap_or(0);
    let mut out = String::new();
    for (line, comment) in lines {
        match comment.is_empty() {
            true => writeln!(out, "{line}"),
            false => writeln!(out, "{line}{:1$}// {comment}", "", column.saturating_sub(width(&line)).max(2)),
        }
        .ok();
    }
    out
}

fn fields(sources: &Sources, fields: &[ShownField], depth: usize, lines: &mut Vec<(String, String)>) {
    let indent = "    ".repeat(depth);
    for field in fields {
        let comment = match &field.said {
            Said::Written(span) => place(sources, *span),
            Said::Default { schema, .. } => format!("default of {schema}"),
            Said::LeftOut => "left out".into(),
        };
        // The elements of a list have no names.
        let name = match field.name.chars().next() {
            Some(first) if first.is_ascii_digit() => String::new(),
            _ => format!("{}: ", field.name),
        };
        match &field.value {
            Shown::Value(text) => lines.push((format!("{indent}{name}{text}"), comment)),
            Shown::Record { schema, fields: inner } => {
                let name = if *schema == field.name { "" } else { &name };
                lines.push((format!("{indent}{name}{schema} {{"), comment));
                self::fields(sources, inner, depth + 1, lines);
                lines.push((format!("{indent}}}"), String::new()));
            }
            Shown::List(elements) => {
                lines.push((format!("{indent}{name}["), comment));
                self::fields(sources, elements, depth + 1, lines);
                lines.push((format!("{indent}]"), String::new()));
            }
        }
    }
}

/// `cell.polish:12`.
fn place(sources: &Sources, span: Span) -> String {
    let name = sources.name(span.file);
    // What `--set` gave stands in no file.
    if name.starts_with("--") {
        return name.to_string();
    }
    format!("{name}:{}", sources.line_column(span.file, span.start as usize).0)
}

/// What the job leaves to the schemas, each with its reason.
fn not_said(job: &CompiledJob) -> String {
    let mut out = format!("{} leaves to their defaults:\n", job.name);
    let (mut left_out, mut any) = (Vec::new(), false);
    walk("", &job.fields, &mut |path, field| match (&field.said, &field.value) {
        (Said::Default { doc, .. }, Shown::Value(value)) => {
            any = true;
            writeln!(out, "\n  {path}: {value}").ok();
            doc.lines().for_each(|line| out.push_str(&format!("      {line}\n")));
        }
        (Said::LeftOut, _) => left_out.push(path.to_string()),
        _ => {}
    });
    if !any {
        out = format!("{} says everything: no default is used\n", job.name);
    }
    if !left_out.is_empty() {
        writeln!(out, "\nand leaves out: {}", left_out.join(", ")).ok();
    }
    out
}

/// Every field with its path.
fn walk(path: &str, fields: &[ShownField], act: &mut dyn FnMut(&str, &ShownField)) {
    for field in fields {
        let path = if path.is_empty() { field.name.clone() } else { format!("{path}.{}", field.name) };
        act(&path, field);
        match &field.value {
            Shown::Record { fields: inner, .. } | Shown::List(inner) => walk(&path, inner, act),
            Shown::Value(_) => {}
        }
    }
}

fn to_json(sources: &Sources, job: &CompiledJob, defaults: bool) -> Value {
    let mut all = Vec::new();
    walk("", &job.fields, &mut |path, field| {
        let Shown::Value(value) = &field.value else { return };
        let mut object = json!({ "field": path, "value": value });
        let (from, more) = match &field.said {
            Said::Written(_) if defaults => return,
            Said::Written(span) => {
                let (line, column) = sources.line_column(span.file, span.start as usize);
                ("text", json!({ "file": sources.name(span.file), "line": line, "column": column }))
            }
            Said::Default { schema, doc } => ("default", json!({ "schema": schema, "doc": doc })),
            Said::LeftOut => ("left_out", json!({})),
        };
        object["from"] = from.into();
        if let (Some(object), Value::Object(more)) = (object.as_object_mut(), more) {
            object.extend(more);
        }
        all.push(object);
    });
    json!({ "job": job.name, "fields": all })
}
