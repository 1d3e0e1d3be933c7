//! Syntax: text to tree. Parsing never fails; see [`parse`].
//!
//! In: the text of one file. Out: its [`Ast`] and what is wrong with it. The way there, each step a file:
//! [`tokens`] cuts the text up, [`lexemes`] drops the blanks, [`entries`] matches brackets and cuts entries,
//! [`written`] puts one entry into the form of the [`grammar`] (`grammar/polish.pest`), and the readers
//! (`items`, `types`, `expressions`, `lists`, `allowed`) make the tree of what the grammar found. What an entry is and how the parser
//! recovers from mistakes is told in `grammar/README.md`.

mod allowed;
pub mod ast;
mod entries;
mod expressions;
mod foreign;
mod forgotten;
pub mod format;
mod grammar;
mod items;
mod lexemes;
mod lists;
mod slips;
pub mod tokens;
mod types;
mod written;

#[cfg(test)]
mod recovery_tests;
#[cfg(test)]
mod tests;

use crate::diagnostics::{Diagnostic, codes};
use crate::source::{FileId, Span};
use ast::{Allow, Ast};
use entries::{Entries, Part, RawEntry};
use grammar::{Rule, Stopped};
use lexemes::{Bracket, Lexeme, LexemeKind};
use tokens::Token;
use written::{Writer, Written};

/// How many mistakes of one file are told. A file with more is not a `.polish` file.
const DIAGNOSTIC_LIMIT: usize = 1000;

/// Reads a file. Whatever could not be read is left out or stands as [`ast::ExprKind::Missing`], and a diagnostic
/// says so; diagnostics come in order of place.
pub fn parse(file: FileId, text: &str) -> (Ast, Vec<Diagnostic>) {
    let mut diagnostics = Vec::new();
    if u32::try_from(text.len()).is_err() {
        let start = Span::new(file, 0, 0);
        diagnostics.push(Diagnostic::error(codes::E0110, start, "this file is larger than 4 GiB"));
        return (Ast::default(), diagnostics);
    }
    let tokens = tokens::tokenize(text);
    let lexed = lexemes::lexemes(file, text, &tokens, &mut diagnostics);
    let Entries { groups } = entries::entries(file, text, &lexed, &mut diagnostics);
    let writer = Writer { file, text, lexemes: &lexed.lexemes, groups: &groups };
    let mut reader = Reader {
        writer,
        docs: &lexed.docs,
        used_docs: vec![false; lexed.lexemes.len()],
        carried_doc: String::new(),
        allows: Vec::new(),
        diagnostics,
        quiet: false,
    };
    let ast = reader.file();
    let unsupported = reader.diagnostics.iter().any(|d| d.code == codes::E0109);
    if unsupported {
        // Another version of the language may allow what this one does not.
        reader.diagnostics.retain(|d| d.code == codes::E0109);
    } else {
        reader.warn_of_lost_docs();
    }
    let mut diagnostics = reader.diagnostics;
    diagnostics.sort_by_key(|d| d.primary.as_ref().map_or((0, 0), |label| (label.span.start, label.span.end)));
    if diagnostics.len() > DIAGNOSTIC_LIMIT {
        let more = diagnostics.len() - DIAGNOSTIC_LIMIT;
        diagnostics.truncate(DIAGNOSTIC_LIMIT);
        if let Some(last) = diagnostics.last_mut() {
            last.notes.push(format!("this file has {more} more mistakes, which are not shown"));
        }
    }
    (ast, diagnostics)
}

/// Whether `word` cannot name an item: a keyword, or a word that begins one.
pub fn is_reserved(word: &str) -> bool {
    lexemes::KEYWORDS.contains(&word) || entries::is_item_word(word)
}

/// An entry could not be read, and that was said.
struct Unreadable;

/// Makes the tree.
struct Reader<'a> {
    writer: Writer<'a>,
    docs: &'a [Token],
    /// Whether the doc comment before each lexeme belongs to something.
    used_docs: Vec<bool>,
    /// The doc comment before an `allow` line: it belongs to the entry after that.
    carried_doc: String,
    allows: Vec<Allow>,
    diagnostics: Vec<Diagnostic>,
    /// The entry being read was reported already.
    quiet: bool,
}

impl<'a> Reader<'a> {
    fn say(&mut self, diagnostic: Diagnostic) {
        if !self.quiet {
            self.diagnostics.push(diagnostic);
        }
    }

    /// Runs the grammar on an entry, and says what is wrong if it cannot be read.
    fn run<T>(
        &mut self,
        entry: &RawEntry,
        written: &Written,
        rule: Rule,
        read: impl FnOnce(&mut Self, pest::iterators::Pairs<'_, Rule>) -> Option<T>,
    ) -> Result<Option<T>, Unreadable> {
        match grammar::parse(rule, &written.text) {
            Ok(pairs) => {
                let outer = std::mem::replace(&mut self.quiet, entry.damaged);
                let tree = read(self, pairs);
                self.quiet = outer;
                Ok(tree)
            }
            Err(stopped) => {
                if !entry.damaged {
                    self.explain(entry, written, &stopped);
                }
                self.use_docs_within(entry);
                Err(Unreadable)
            }
        }
    }

    /// Says where and why the grammar stopped.
    fn explain(&mut self, entry: &RawEntry, written: &Written, stopped: &Stopped) {
        let part = written.part_at(stopped.at);
        if let Some(slip) = self.slip(entry, part).filter(|_| !stopped.limit) {
            self.say(slip);
            return;
        }
        let span = match part {
            Some(part) => {
                let (start, end) = self.writer.range(part);
                // Of a group only its bracket: what is in it may be right.
                let end = if matches!(part, Part::Group(_)) { start + 1 } else { end };
                Span { file: self.writer.file, start, end }
            }
            None => written.end(),
        };
        if stopped.limit {
            let message = "this entry is too long to be read";
            self.say(Diagnostic::error(codes::E0110, span, message).help("divide it with `let`"));
            return;
        }
        let place = match (part, written.part_before(stopped.at)) {
            (Some(part), _) => format!(", found `{}`", self.short(part)),
            (None, Some(before)) => format!(" after `{}`", self.short(before)),
            (None, None) => String::new(),
        };
        let mut diagnostic =
            Diagnostic::error(codes::E0107, span, format!("expected {}{place}", listed(&stopped.expected)));
        if self.writer.kind(part.as_ref()) == Some(LexemeKind::Keyword)
            && stopped.expected.contains("a name")
            && let Some(part) = part
        {
            diagnostic = diagnostic.note(format!("`{}` is a reserved word", self.writer.slice(part)));
        }
        if stopped.expected.contains("`else`") {
            diagnostic = diagnostic.note("every `if` needs an `else`: it stands for a value in both cases");
        }
        if part.is_some_and(|part| self.writer.slice(part) == "if") {
            diagnostic = diagnostic.help("inside an expression an `if` stands in parentheses: `(if … then … else …)`");
        }
        if stopped.expected.contains("the end of the entry") {
            diagnostic = diagnostic.note("an entry ends at the end of its line or at a comma");
        }
        self.say(diagnostic);
    }

    /// A part as shown in a message.
    fn short(&self, part: Part) -> String {
        let slice = self.writer.slice(part);
        match part {
            Part::Group(g) if self.writer.groups[g].bracket == Bracket::Curly => "{".to_string(),
            Part::Group(_) => "[".to_string(),
            Part::Lexeme(_) if slice.chars().count() > 30 => slice.chars().take(30).chain(['…']).collect(),
            Part::Lexeme(_) => slice.to_string(),
        }
    }

    fn entry_span(&self, entry: &RawEntry) -> Span {
        let first = entry.parts.first().map_or((0, 0), |&part| self.writer.range(part));
        let last = entry.parts.last().map_or(first, |&part| self.writer.range(part));
        Span { file: self.writer.file, start: first.0, end: last.1 }
    }

    /// The doc comment before the entry.
    fn entry_doc(&mut self, entry: &RawEntry) -> String {
        let own = match entry.parts.first() {
            Some(&part) => self.doc_at(self.writer.range(part).0),
            None => String::new(),
        };
        let carried = std::mem::take(&mut self.carried_doc);
        if carried.is_empty() || own.is_empty() { carried + &own } else { carried + "\n" + &own }
    }

    /// The doc comment before the lexeme at byte `start`, its lines joined by newlines.
    fn doc_at(&mut self, start: u32) -> String {
        let at = self.writer.lexeme_from(start);
        let Some(lexeme) = self.writer.lexemes.get(at) else { return String::new() };
        self.used_docs[at] = true;
        let lines: Vec<&str> = self.docs[lexeme.docs.0 as usize..lexeme.docs.1 as usize]
            .iter()
            .map(|token| {
                let line = &self.writer.text[token.start as usize + 3..token.end as usize];
                line.strip_prefix(' ').unwrap_or(line).trim_end()
            })
            .collect();
        lines.join("\n")
    }

    /// Of what could not be read, nobody knows which doc comments belong to something.
    fn use_docs_within(&mut self, entry: &RawEntry) {
        let span = self.entry_span(entry);
        let from = self.writer.lexeme_from(span.start);
        let to = self.writer.lexeme_from(span.end);
        self.used_docs[from..to].fill(true);
    }

    fn warn_of_lost_docs(&mut self) {
        let lexemes: &[Lexeme] = self.writer.lexemes;
        let attached = lexemes.last().map_or(0, |lexeme| lexeme.docs.1);
        let mut lost: Vec<(u32, u32)> =
            lexemes.iter().zip(&self.used_docs).filter(|(_, used)| !**used).map(|(lexeme, _)| lexeme.docs).collect();
        lost.push((attached, self.docs.len() as u32));
        for (from, to) in lost {
            let Some([first, ..]) = self.docs.get(from as usize..to as usize) else { continue };
            let marker = Span { file: self.writer.file, start: first.start, end: first.start + 3 };
            let mut diagnostic = Diagnostic::warning(codes::W0101, marker, "this doc comment belongs to nothing")
                .note("a doc comment belongs to the field or the item after it")
                .help("write it as a plain comment with `//`, or move it");
            for token in &self.docs[from as usize..to as usize] {
                let marker = Span { file: self.writer.file, start: token.start, end: token.start + 3 };
                diagnostic = diagnostic.suggest(marker, "//");
            }
            self.say(diagnostic);
        }
    }
}

/// `a, b or c`.
fn listed(words: &std::collections::BTreeSet<&'static str>) -> String {
    let words: Vec<&str> = words.iter().copied().collect();
    match words.as_slice() {
        [] => "something else".to_string(),
        [one] => (*one).to_string(),
        [rest @ .., last] => format!("{} or {last}", rest.join(", ")),
    }
}
