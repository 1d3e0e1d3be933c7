//! The formatter: the one look of a `.polish` file, made from its tokens.
//!
//! In: the text of a file without mistakes. Out: the same text with other blanks. Blanks and line ends are all that
//! changes, beside commas at the ends of lines, which are dropped; so every comment stays, in its order, and the tree of
//! the result is the tree of the source. Both are asserted on every call.
//!
//! The look, in the order in which the files of this folder make it:
//!
//! - [`atoms`], [`structure`]: what there is: lexemes and comments, entries and brackets.
//! - [`spacing`]: one blank around operators and inside `{ }`, none inside `[ ]` and `( )`, none before `:` and `,`, units and
//!   powers close together.
//! - [`layout`]: lines end where they ended. A record or list stays on one line if it stood on one; else its brackets end
//!   their lines and its content stands four blanks deeper. Entries that shared a line share it still. At most one
//!   blank line. Items begin at the left edge.
//! - [`align`]: values of neighbouring lines stand under each other if they did.
//!
//! No line is broken because it is long: where a line ends says what belongs together, and that is the author's to say.

mod align;
mod atoms;
mod layout;
mod spacing;
mod structure;

use super::{ast::Ast, entries, lexemes, parse, tokens};
use crate::diagnostics::{Diagnostic, Severity};
use crate::source::FileId;
use tokens::TokenKind;

/// The text in the one look. A text with mistakes is refused, with what is wrong: nobody knows what it means.
///
/// # Panics
///
/// If the result would not mean what the source means: that is a bug, and no text is better than another one.
pub fn format(file: FileId, text: &str) -> Result<String, Vec<Diagnostic>> {
    let (before, mut diagnostics) = parse(file, text);
    diagnostics.retain(|d| d.severity == Severity::Error);
    if !diagnostics.is_empty() {
        return Err(diagnostics);
    }
    let tokens = tokens::tokenize(text);
    let lexed = lexemes::lexemes(file, text, &tokens, &mut diagnostics);
    let groups = entries::entries(file, text, &lexed, &mut diagnostics).groups;
    let mut atoms = atoms::atoms(text, &tokens);
    let lexemes = &lexed.lexemes;
    let places = structure::places(lexemes, &groups);
    let gaps = spacing::gaps(text, lexemes, &places);
    atoms::put_comments_before_minus(&mut atoms, &gaps);
    let shape = structure::shape(lexemes, &places, &atoms);
    let mut lines = layout::lines(lexemes, &places, &shape, &gaps, &atoms);
    align::align(&mut lines);
    let windows = tokens.iter().find(|token| token.kind == TokenKind::Newline).is_some_and(|t| t.end - t.start == 2);
    let formatted = layout::written(&lines, if windows { "\r\n" } else { "\n" });

    let (after, mistakes) = parse(file, &formatted);
    assert!(mistakes.iter().all(|d| d.severity != Severity::Error), "the formatter made a mistake: {mistakes:?}");
    assert!(tree(&before) == tree(&after), "the formatter changed what the file means");
    assert!(comments(text) == comments(&formatted), "the formatter changed a comment");
    Ok(formatted)
}

/// A tree as text, without the places of what is in it: equal for two files that mean the same.
fn tree(ast: &Ast) -> String {
    // Every node has its place; written out, each reads `Span { … }` with numbers only.
    let written = format!("{ast:?}");
    let mut pieces = written.split("Span {");
    let mut tree = pieces.next().unwrap_or_default().to_string();
    for piece in pieces {
        tree.push_str(piece.split_once('}').map_or(piece, |(_, rest)| rest));
    }
    tree
}

/// The comments in order, without the blanks at the ends of their lines.
fn comments(text: &str) -> Vec<String> {
    let comment = |kind| matches!(kind, TokenKind::Comment { .. } | TokenKind::Doc);
    let slice = |token: &tokens::Token| &text[token.start as usize..token.end as usize];
    let tokens = tokens::tokenize(text);
    tokens.iter().filter(|t| comment(t.kind)).map(|t| slice(t).replace("\r\n", "\n").trim_end().to_string()).collect()
}
