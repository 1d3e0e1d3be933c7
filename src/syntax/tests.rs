//! Tests of the whole parser. Tests of one step stand beside it.

use super::ast::*;
use super::parse;
use crate::diagnostics::{Diagnostic, Severity};
use crate::source::FileId;
use crate::syntax::tokens::{TokenKind, tokenize};
use std::collections::BTreeMap;

const JOB: &str = include_str!("../../tests/syntax/flat_340.polish");

fn read(text: &str) -> (Ast, Vec<Diagnostic>) {
    parse(FileId(0), text)
}

fn codes(text: &str) -> Vec<&'static str> {
    read(text).1.iter().map(|d| d.code.as_str()).collect()
}

fn show(text: &str, d: &Diagnostic) -> String {
    let p = d.primary.as_ref().unwrap().span;
    format!("{} {} @{}..{} `{}`", d.code, d.message, p.start, p.end, &text[p.start as usize..p.end as usize])
}

/// The paths of all entries with a value, as `job.workpiece.edge.outer_diameter`, with how often each occurs.
fn entry_paths(ast: &Ast) -> BTreeMap<String, usize> {
    fn value(path: &str, expr: &Expr, paths: &mut BTreeMap<String, usize>) {
        match &expr.kind {
            ExprKind::Record { body, .. } => block(path, body, paths),
            ExprKind::With(base, body) => {
                value(path, base, paths);
                block(path, body, paths);
            }
            ExprKind::List(elements, _) => elements.iter().for_each(|element| {
                *paths.entry(format!("{path}[]")).or_default() += usize::from(element.kind != ExprKind::Missing);
                value(&format!("{path}[]"), element, paths);
            }),
            _ => {}
        }
    }
    fn block(path: &str, body: &Block, paths: &mut BTreeMap<String, usize>) {
        for entry in &body.entries {
            let (name, expr) = match &entry.kind {
                EntryKind::Field { name, value } => (name.text.as_str(), value),
                EntryKind::Expr(value) => ("", value),
            };
            let path = format!("{path}.{name}");
            *paths.entry(path.clone()).or_default() += usize::from(expr.kind != ExprKind::Missing);
            value(&path, expr, paths);
        }
    }
    let mut paths = BTreeMap::new();
    for item in &ast.items {
        let name = match &item.kind {
            ItemKind::Use(_) => "use",
            ItemKind::Let { .. } | ItemKind::Param { .. } => "value",
            ItemKind::Job { body, .. } => {
                block("job", body, &mut paths);
                "job"
            }
            _ => "other",
        };
        *paths.entry(name.to_string()).or_default() += 1;
    }
    paths
}

#[test]
fn explore() {
    let whole = entry_paths(&read(JOB).0);
    let total: usize = whole.values().sum();
    let (mut lost_total, mut n) = (0, 0);
    let mut hist = BTreeMap::new();
    for token in tokenize(JOB) {
        if matches!(token.kind, TokenKind::Blank | TokenKind::Newline | TokenKind::Comment { .. } | TokenKind::Doc) {
            continue;
        }
        n += 1;
        let (a, b) = (token.start as usize, token.end as usize);
        let text = format!("{}{}", &JOB[..a], &JOB[b..]);
        let (ast, said) = read(&text);
        let left = entry_paths(&ast);
        let lost: usize = whole.iter().map(|(p, n)| n.saturating_sub(left.get(p).copied().unwrap_or(0))).sum();
        lost_total += lost.saturating_sub(1);
        *hist.entry(said.len()).or_insert(0) += 1;
        if lost > 2 || said.len() > 1 {
            println!("-- {} `{}` at {}: lost {lost}", JOB[..a].matches('\n').count() + 1, &JOB[a..b], a);
            for d in &said {
                println!("      {}", show(&text, d));
            }
        }
    }
    println!("{n} deletions, {total} entries, lost beyond one {lost_total}, {hist:?}");
}
