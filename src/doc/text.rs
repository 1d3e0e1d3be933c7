//! The manual for a terminal.

use super::{Entry, FieldPage, Kind, Manual, Module, brief};
use std::fmt::Write;

/// Characters of a line. Lines of prose longer than this are hard to follow.
const WIDTH: usize = 100;

/// What there is: every module with its words.
pub fn overview(manual: &Manual) -> String {
    let mut out = String::from("`polishc doc NAME` tells of one of these words, or of a field.\n");
    for module in &manual.modules {
        let line = if module.core { String::new() } else { format!("  (use std.{})", module.name) };
        write!(out, "\n{}{line}", heading(module)).ok();
        out.push('\n');
        for kind in ["family", "schema", "value", "function", "dimension", "unit"] {
            let of_kind: Vec<&str> =
                module.entries.iter().filter(|e| e.kind.word() == kind).map(|e| e.name.as_str()).collect();
            if !of_kind.is_empty() {
                wrap(&mut out, &format!("{kind:<10}{}", of_kind.join(", ")), 2, 12);
            }
        }
    }
    out
}

fn heading(module: &Module) -> String {
    match brief(&module.doc) {
        "" => module.name.to_string(),
        doc => format!("{}: {}", module.name, lower(&doc.replace('\n', " "))),
    }
}

/// A sentence as it goes on after a colon; names and abbreviations stay.
fn lower(text: &str) -> String {
    let mut letters = text.chars();
    match (letters.next(), letters.clone().next()) {
        (Some(first), Some(second)) if !second.is_uppercase() => first.to_lowercase().chain(letters).collect(),
        _ => text.to_string(),
    }
}

/// One word. `manual` tells of the words that it names.
pub fn entry(manual: &Manual, module: &Module, entry: &Entry) -> String {
    let mut out = String::new();
    writeln!(out, "{} ({}, {})", title(entry), entry.kind.word(), origin(module)).ok();
    if !entry.doc.is_empty() {
        out.push('\n');
        prose(&mut out, &entry.doc, 0);
    }
    match &entry.kind {
        Kind::Family { members, used } => {
            out.push_str("\nMembers\n");
            for member in members {
                let found = manual.entries().map(|(_, e)| e).find(|e| e.name == *member && in_family(e, &entry.name));
                wrap(&mut out, &format!("{member:<18} {}", found.map_or("", |e| e.brief())), 2, 21);
            }
            stands_in(&mut out, used);
        }
        Kind::Schema { family, fields, checks, used } => {
            if !fields.is_empty() {
                out.push_str("\nFields\n");
            }
            for page in fields {
                out.push_str(&indented(&field(page), 2));
            }
            if !checks.is_empty() {
                writeln!(out, "\nMust hold: {}", checks.join("; ")).ok();
            }
            let of_family = family.as_ref().and_then(|family| {
                manual.entries().find_map(|(_, e)| match &e.kind {
                    Kind::Family { used, .. } if e.name == *family => Some(used.clone()),
                    _ => None,
                })
            });
            let all: Vec<String> = of_family.into_iter().flatten().chain(used.iter().cloned()).collect();
            stands_in(&mut out, &all);
        }
        Kind::Value { text, line, .. } => {
            write!(out, "\n{line}\n\n{}\n", indented(text, 2).trim_end()).ok();
        }
        Kind::Function { .. } => {}
        Kind::Unit { worth, dimension } => {
            match worth {
                Some(worth) => writeln!(out, "\n1 {} = {worth}; a unit of {dimension}", entry.name),
                None => writeln!(out, "\nThe SI unit of {dimension}",),
            }
            .ok();
        }
        Kind::Dimension { product, units } => {
            match product {
                Some(product) => writeln!(out, "\n{} = {product}", entry.name),
                None => writeln!(out, "\nA base: it is made of no others."),
            }
            .ok();
            if !units.is_empty() {
                writeln!(out, "Common units: {}", units.join(", ")).ok();
            }
        }
    }
    out
}

fn in_family(entry: &Entry, name: &str) -> bool {
    matches!(&entry.kind, Kind::Schema { family: Some(family), .. } if family == name)
}

/// A word as its declaration begins: `raster : Path`.
pub(super) fn title(entry: &Entry) -> String {
    match &entry.kind {
        Kind::Schema { family: Some(family), .. } => format!("{} : {family}", entry.name),
        Kind::Function { signature } => signature.clone(),
        Kind::Value { schema, .. } => format!("{}: {schema}", entry.name),
        _ => entry.name.clone(),
    }
}

fn origin(module: &Module) -> String {
    if module.core { format!("in stdlib/{}", module.name) } else { format!("std.{}", module.name) }
}

fn stands_in(out: &mut String, used: &[String]) {
    if !used.is_empty() {
        out.push('\n');
        wrap(out, &format!("Stands in: {}", used.join(", ")), 0, 11);
    }
}

/// A field with what it may be.
pub fn field(page: &FieldPage) -> String {
    let mut out = String::new();
    let mut line = format!("{}: {}", page.name, page.ty);
    if let Some(default) = &page.default {
        write!(line, " = {default}").ok();
    }
    writeln!(out, "{line}").ok();
    let facts = facts(page);
    if !facts.is_empty() {
        wrap(&mut out, &facts.join("; "), 4, 4);
    }
    if !page.doc.is_empty() {
        prose(&mut out, &page.doc, 4);
    }
    for (symbol, doc) in page.symbols.iter().filter(|(_, doc)| !doc.is_empty()) {
        wrap(&mut out, &format!("{symbol:<16} {}", doc.replace('\n', " ")), 4, 21);
    }
    out
}

/// What a field may be, in short phrases.
pub(super) fn facts(page: &FieldPage) -> Vec<String> {
    let mut facts = Vec::new();
    facts.extend(page.limit.as_ref().map(|limit| match limit.contains("..") {
        true => format!("within {limit}"),
        false => limit.clone(),
    }));
    facts.extend(page.usual.as_ref().map(|usual| format!("usually {usual}")));
    if !page.units.is_empty() {
        facts.push(format!("in {}", page.units.join(", ")));
    }
    if !page.required && page.default.is_none() {
        facts.push("may be left out".to_string());
    }
    facts
}

fn indented(text: &str, by: usize) -> String {
    let lines = text.lines().map(|line| match line.is_empty() {
        true => "\n".to_string(),
        false => format!("{:by$}{line}\n", ""),
    });
    lines.collect()
}

/// Paragraphs wrapped; what stands between three backticks as it is.
fn prose(out: &mut String, doc: &str, indent: usize) {
    for (code, block) in super::html::blocks(doc) {
        match code {
            true => out.push_str(&indented(&block, indent + 4)),
            false if block.is_empty() => out.push('\n'),
            false => wrap(out, &block, indent, indent),
        }
    }
}

/// Words on lines of at most [`WIDTH`] characters; the first line `first` deep, the others `rest`.
fn wrap(out: &mut String, text: &str, first: usize, rest: usize) {
    let start = text.len() - text.trim_start().len();
    let mut line = format!("{:first$}{}", "", &text[..start]);
    let mut empty = true;
    // Runs of blanks inside a line are columns, and stay.
    for word in text[start..].trim_end().split_inclusive(' ') {
        let word = word.trim_end_matches('\n');
        if !empty && line.trim_end().chars().count() + 1 + word.trim_end().chars().count() > WIDTH {
            out.push_str(line.trim_end());
            out.push('\n');
            line = " ".repeat(rest);
        }
        for (i, piece) in word.split('\n').enumerate() {
            if i > 0 && !line.ends_with(' ') {
                line.push(' ');
            }
            line.push_str(piece);
        }
        empty = false;
    }
    out.push_str(line.trim_end());
    out.push('\n');
}
