//! Slips: entries that the grammar cannot read and whose meaning is plain all the same.
//!
//! In: an entry, and where the grammar stopped. Out: a diagnostic that names the habit behind it and mends it, in place of
//! the general "expected …, found …".

use super::entries::{Part, RawEntry};
use super::lexemes::LexemeKind;
use super::{Diagnostic, Reader, Span, codes};

/// Words that begin a definition in other languages, and ours.
const ITEM_WORDS: [(&[&str], &str); 6] = [
    (&["var", "const", "set", "define", "def", "auto", "static"], "let"),
    (&["import", "include", "require", "from", "using", "open"], "use"),
    (&["function", "func", "fun", "proc", "macro"], "fn"),
    (&["struct", "class", "record", "type", "interface", "enum"], "schema"),
    (&["parameter", "parameters", "input", "arg", "variable"], "param"),
    (&["program", "task", "main", "module", "process", "recipe"], "job"),
];

/// The word of our language that another language's word for an item means.
pub fn item_meant(word: &str) -> Option<&'static str> {
    let word = word.to_lowercase();
    ITEM_WORDS.iter().find(|(others, _)| others.contains(&word.as_str())).map(|(_, ours)| *ours)
}

impl Reader<'_> {
    /// What is to be said of an entry in which the grammar stopped at `part`, if the slip is a known one.
    pub(super) fn slip(&self, entry: &RawEntry, part: Option<Part>) -> Option<Diagnostic> {
        let Some(Part::Lexeme(at)) = part else { return None };
        let item = entry.parts.first().map_or("", |&first| self.writer.slice(first));
        match self.word(at) {
            "to" | "until" | "upto" | "through" => self.range_in_words(at),
            "-" if super::entries::is_item_word(item) => self.hyphen_in_name(entry, at),
            ":" | "/" | "-" if item == "use" => self.path_of_use(entry),
            ":" | "=" if self.opener_around(at).is_some() => self.record_as_call(at),
            "=" if item == "param" => self.param_without_type(entry, at),
            _ if item == "let" => self.colon_in_let(entry, at).or_else(|| self.unit_after_bracket(at)),
            _ => self.unit_after_bracket(at),
        }
    }

    fn word(&self, at: usize) -> &str {
        self.writer.lexemes.get(at).map_or("", |_| self.writer.slice(Part::Lexeme(at)))
    }

    fn place(&self, from: usize, to: usize) -> Span {
        let lexemes = self.writer.lexemes;
        Span { file: self.writer.file, start: lexemes[from].start, end: lexemes[to].end }
    }

    fn kind_at(&self, at: usize) -> Option<LexemeKind> {
        self.writer.lexemes.get(at).map(|lexeme| lexeme.kind)
    }

    fn same_line(&self, a: usize, b: usize) -> bool {
        self.writer.lexemes[a].line == self.writer.lexemes[b].line
    }

    /// `0.2 mm/s to 20 mm/s`.
    fn range_in_words(&self, at: usize) -> Option<Diagnostic> {
        self.kind_at(at + 1).filter(|_| at > 0 && self.same_line(at, at + 1))?;
        let place = self.place(at, at);
        Some(
            Diagnostic::error(codes::E0107, place, format!("a range is not written with `{}`", self.word(at)))
                .help("write `..` between its ends: `a .. b`")
                .suggest(place, ".."),
        )
    }

    /// `job flat-340 {`.
    fn hyphen_in_name(&self, entry: &RawEntry, at: usize) -> Option<Diagnostic> {
        let name = at.checked_sub(1)?;
        let second = matches!(entry.parts.get(1), Some(Part::Lexeme(l)) if *l == name);
        let third = matches!(entry.parts.get(2), Some(Part::Lexeme(l)) if *l == name);
        if !(second || third) || self.kind_at(name) != Some(LexemeKind::Word) {
            return None;
        }
        let lexemes = self.writer.lexemes;
        let joined = |i: usize| {
            lexemes.get(i + 1).is_some_and(|next| {
                next.start == lexemes[i].end
                    && (matches!(next.kind, LexemeKind::Word | LexemeKind::Number) || self.word(i + 1) == "-")
            })
        };
        let mut last = name;
        while joined(last) {
            last += 1;
        }
        if last <= at {
            return None;
        }
        let place = self.place(name, last);
        let written = &self.writer.text[place.start as usize..place.end as usize];
        let mended = written.replace('-', "_");
        Some(
            Diagnostic::error(codes::E0107, place, format!("`{written}` is not one name"))
                .note("a name has letters, digits and `_`; a `-` subtracts")
                .help(format!("write `{mended}`"))
                .suggest(place, mended.clone()),
        )
    }

    /// `use std::materials::k9`, `use std/materials/k9`.
    fn path_of_use(&self, entry: &RawEntry) -> Option<Diagnostic> {
        let (Some(&Part::Lexeme(first)), Some(&Part::Lexeme(last))) = (entry.parts.get(1), entry.parts.last()) else {
            return None;
        };
        let place = self.place(first, last);
        let written = &self.writer.text[place.start as usize..place.end as usize];
        if written.contains(|c: char| c.is_whitespace()) || written.contains('"') {
            return None;
        }
        if written.ends_with(".polish") {
            return Some(
                Diagnostic::error(codes::E0107, place, format!("the file `{written}` does not stand in quotes"))
                    .help(format!("write `\"{written}\"`"))
                    .suggest(place, format!("\"{written}\"")),
            );
        }
        let mended = written.replace("::", ".").replace(['/', ':'], ".");
        Some(
            Diagnostic::error(codes::E0107, place, format!("`{written}` is not how a module is named"))
                .help(format!("join its words by dots: `{mended}`"))
                .suggest(place, mended.clone()),
        )
    }

    /// The `(` that a lexeme stands in, if a word stands right before it.
    fn opener_around(&self, at: usize) -> Option<usize> {
        let mut depth = 0usize;
        for i in (0..at).rev() {
            match self.word(i) {
                ")" | "]" | "}" => depth += 1,
                "(" if depth == 0 => {
                    let before = i.checked_sub(1)?;
                    let name = self.kind_at(before) == Some(LexemeKind::Word);
                    return (name && self.writer.lexemes[before].end == self.writer.lexemes[i].start).then_some(i);
                }
                "[" | "{" if depth == 0 => return None,
                "(" | "[" | "{" => depth -= 1,
                _ => {}
            }
        }
        None
    }

    /// `circle(diameter: 62 mm)`.
    fn record_as_call(&self, at: usize) -> Option<Diagnostic> {
        let open = self.opener_around(at)?;
        let (mut depth, mut marks, mut close) = (0usize, Vec::new(), None);
        for i in open + 1..self.writer.lexemes.len() {
            match self.word(i) {
                "(" | "[" | "{" => depth += 1,
                ")" if depth == 0 => {
                    close = Some(i);
                    break;
                }
                ")" | "]" | "}" => depth = depth.checked_sub(1)?,
                "=" if depth == 0 => marks.push(i),
                _ => {}
            }
        }
        let close = close?;
        let name = self.word(open - 1);
        let mut diagnostic =
            Diagnostic::error(codes::E0107, self.place(open, open), format!("`{name}` with fields is not a call"))
                .also(self.place(at, at), "a field")
                .help(format!("a record stands in `{{ }}`: `{name} {{ … }}`"))
                .suggest(self.place(open, open), " { ");
        for mark in marks {
            let gap = Span { start: self.writer.lexemes[mark - 1].end, ..self.place(mark, mark) };
            diagnostic = diagnostic.suggest(gap, ":");
        }
        Some(diagnostic.suggest(self.place(close, close), " }"))
    }

    /// `param pitch = 0.5 mm`.
    fn param_without_type(&self, entry: &RawEntry, at: usize) -> Option<Diagnostic> {
        let name = at.checked_sub(1).filter(|name| self.kind_at(*name) == Some(LexemeKind::Word))?;
        let second = matches!(entry.parts.get(1), Some(Part::Lexeme(l)) if *l == name);
        let word = self.word(name);
        second.then(|| {
            Diagnostic::error(
                codes::E0107,
                self.place(name, name),
                format!("the parameter `{word}` does not say its type"),
            )
            .note("what `--set` gives from outside is checked against it")
            .help(format!("write it after the name: `param {word}: Length = …`"))
        })
    }

    /// `let pitch: 0.5 mm`.
    fn colon_in_let(&self, entry: &RawEntry, at: usize) -> Option<Diagnostic> {
        let colon = at.checked_sub(1)?;
        let third = matches!(entry.parts.get(2), Some(Part::Lexeme(l)) if *l == colon);
        let value = matches!(self.kind_at(at), Some(LexemeKind::Number | LexemeKind::Text));
        if !third || !value || self.kind_at(colon) != Some(LexemeKind::Colon) {
            return None;
        }
        let place = self.place(colon, colon);
        Some(
            Diagnostic::error(codes::E0107, place, "a value is given a name by `=`; `:` says its type")
                .help("write `=`")
                .suggest(place, " ="),
        )
    }

    /// `(1 + 2) mm`.
    fn unit_after_bracket(&self, at: usize) -> Option<Diagnostic> {
        let before = at.checked_sub(1)?;
        let word = self.word(at);
        if self.word(before) != ")" || self.kind_at(at) != Some(LexemeKind::Word) || !self.same_line(before, at) {
            return None;
        }
        // Units have short names; a longer word was meant as something else.
        if word.chars().count() > 6 {
            return None;
        }
        let gap =
            Span { start: self.writer.lexemes[before].end, end: self.writer.lexemes[at].start, ..self.place(at, at) };
        Some(
            Diagnostic::error(
                codes::E0107,
                self.place(at, at),
                format!("`{word}` stands after a bracket, not after a number"),
            )
            .note("a unit belongs to the number right before it")
            .help(format!("multiply by it: `(…) * 1 {word}`"))
            .suggest(gap, " * 1 "),
        )
    }
}
