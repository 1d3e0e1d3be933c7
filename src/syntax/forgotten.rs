//! Brackets, colons and commas that were forgotten: where one must have been meant.
//!
//! In: the matcher of [`entries`](super::entries) in the middle of its work. Out: its guess, said as a diagnostic and
//! acted upon, so that what stands around the mistake keeps its place in the tree. The guesses about openers are asked
//! for only after matching by brackets alone has failed.

use super::entries::{BRACKET_LIMIT, Frame, Group, Matcher, Opener, Part, is_item_word};
use super::lexemes::{Bracket, LexemeKind};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::Span;

impl Matcher<'_> {
    /// A `{` on a line of its own belongs to the name that ends the line before it: said, and read so.
    pub(super) fn brace_is_late(&mut self, at: usize) -> bool {
        if self.frame().bracket == Bracket::Square {
            return false;
        }
        let Some(&Part::Lexeme(name)) = self.frame().entry.parts.last() else { return false };
        if self.lexemes[name].kind != LexemeKind::Word {
            return false;
        }
        // A unit is no name: what is missing is the name before the bracket.
        if name > 0 && self.lexemes[name - 1].kind == LexemeKind::Number {
            return false;
        }
        let gap = Span { start: self.lexemes[name].end, end: self.lexemes[at].start, file: self.file };
        let comment = self.text[gap.start as usize..gap.end as usize].contains('/');
        let mut diagnostic =
            Diagnostic::error(codes::E0118, self.span(at), "`{` does not stand on the line of the name before it")
                .also(self.span(name), "the name")
                .help(format!("write `{} {{` on one line", self.slice(name)));
        // A comment between the two would be lost by the mend.
        if !comment {
            diagnostic = diagnostic.suggest(gap, " ");
        }
        self.others.push(diagnostic);
        true
    }

    /// The name of an item on the line after its keyword: said, and read so.
    pub(super) fn name_is_late(&mut self, at: usize) -> bool {
        let [.., Part::Lexeme(keyword)] = *self.frame().entry.parts.as_slice() else { return false };
        let bare = self.frames.len() == 1 && self.frame().entry.parts.len() == 1 && is_item_word(self.slice(keyword));
        if !bare || self.lexemes[at].kind != LexemeKind::Word || self.names_field(at) {
            return false;
        }
        let gap = Span { start: self.lexemes[keyword].end, end: self.lexemes[at].start, file: self.file };
        let message = format!("`{}` does not stand on the line of its `{}`", self.slice(at), self.slice(keyword));
        let mut diagnostic = Diagnostic::error(codes::E0118, self.span(at), message).help(format!(
            "write `{} {}` on one line",
            self.slice(keyword),
            self.slice(at)
        ));
        // A comment between the two would be lost by the mend.
        if !self.text[gap.start as usize..gap.end as usize].contains('/') {
            diagnostic = diagnostic.suggest(gap, " ");
        }
        self.others.push(diagnostic);
        true
    }

    /// A second `name:` in one entry of a record.
    pub(super) fn lacks_comma(&self, at: usize) -> bool {
        let entry = &self.frame().entry;
        // A colon that is itself forgotten, or written as `=`, does not hide the second field.
        let first_is_name = |parts: &[Part]| match parts {
            [Part::Lexeme(name), Part::Lexeme(after), ..] => {
                self.lexemes[*name].kind == LexemeKind::Word
                    && (matches!(self.lexemes[*after].kind, LexemeKind::Colon | LexemeKind::Number | LexemeKind::Text)
                        || self.slice(*after) == "=")
            }
            _ => false,
        };
        self.frames.len() > 1
            && !self.in_round()
            && self.frame().bracket == Bracket::Curly
            && entry.parts.len() > 2
            && first_is_name(&entry.parts)
            && self.names_field(at)
            && !self.goes_on_after()
    }

    /// Whether an opening bracket was forgotten before the lexeme: a field stands where none can, deeper than the line
    /// that it belongs to, or a closer follows on this line that only such a bracket could explain.
    pub(super) fn forgotten_opener(&self, at: usize) -> Option<Bracket> {
        let entry = &self.frame().entry;
        let (Some(&Part::Lexeme(first)), Some(&Part::Lexeme(last))) = (entry.parts.first(), entry.parts.last()) else {
            return None;
        };
        let (lexeme, kind) = (&self.lexemes[at], self.lexemes[last].kind);
        if self.in_round() || last + 1 != at {
            return None;
        }
        let deeper = lexeme.begins_line && lexeme.indent > self.lexemes[first].indent;
        let headed = matches!(kind, LexemeKind::Word | LexemeKind::Colon) || self.slice(last) == "with";
        let field = headed && self.names_field(at);
        // `require` holds no fields; a line that is one word and nothing more can only be its like.
        let alone = first == last && kind == LexemeKind::Word && lexeme.kind == LexemeKind::Word;
        let condition = alone && self.slice(first) == "require";
        let beside = !lexeme.begins_line && (field || condition) && self.is_closed_on_line(at, Bracket::Curly);
        if deeper && (field || alone) || beside {
            return Some(Bracket::Curly);
        }
        let list = kind == LexemeKind::Colon
            && match lexeme.begins_line {
                true => deeper && self.is_closed_below(at, self.lexemes[first].indent),
                false => self.is_closed_on_line(at, Bracket::Square),
            };
        list.then_some(Bracket::Square)
    }

    /// A `{` right after a `{`, with no closer of its own on the line.
    pub(super) fn is_doubled_opener(&self, at: usize) -> bool {
        let curly = LexemeKind::Open(Bracket::Curly);
        at > 0
            && self.lexemes[at].kind == curly
            && self.lexemes[at - 1].kind == curly
            && self.stack.last().is_some_and(|opener| opener.lexeme == at - 1)
            && !self.is_closed_on_line(at + 1, Bracket::Curly)
    }

    /// Whether the rest of the line closes more such brackets than the line has opened, before another field begins.
    fn is_closed_on_line(&self, at: usize, bracket: Bracket) -> bool {
        // Longer lines are not written by hand; without a bound one endless line would be walked again and again.
        const WALK: usize = 256;
        let Some(line) = self.lexemes.get(at).map(|lexeme| lexeme.line) else { return false };
        let here = |o: &&Opener| o.bracket == bracket && self.lexemes[o.lexeme].line == line;
        let opened = self.stack.iter().filter(here).count();
        // Other brackets may be the ones that are wrong: each kind is counted for itself.
        let (mut depth, mut own, mut closed) = (0usize, 0usize, 0);
        // For every bracket opened behind `at`, whether a field stands in it: then a list may lack its opener there.
        let mut fields: Vec<bool> = Vec::new();
        for lexeme in self.lexemes[at..].iter().take_while(|lexeme| lexeme.line == line).take(WALK) {
            match lexeme.kind {
                LexemeKind::Open(opener) => {
                    depth += 1;
                    fields.push(false);
                    own += usize::from(opener == bracket);
                }
                LexemeKind::Close(closer) => {
                    if closer == Bracket::Square && bracket == closer && own == 0 && fields.last() == Some(&true) {
                        return false;
                    }
                    depth = depth.saturating_sub(1);
                    fields.pop();
                    if closer == bracket && own == 0 {
                        closed += 1;
                    } else if closer == bracket {
                        own -= 1;
                    }
                }
                LexemeKind::Colon if depth == 0 && closed == 0 && bracket == Bracket::Square => return false,
                LexemeKind::Colon => fields.last_mut().into_iter().for_each(|field| *field = true),
                _ => {}
            }
        }
        closed > opened
    }

    /// Whether the next line that is no deeper than `indent` begins with `]`.
    fn is_closed_below(&self, at: usize, indent: u32) -> bool {
        let next = self.lexemes[at..].iter().find(|lexeme| lexeme.begins_line && lexeme.indent <= indent);
        next.is_some_and(|lexeme| lexeme.kind == LexemeKind::Close(Bracket::Square) && lexeme.indent == indent)
    }

    pub(super) fn open_forgotten(&mut self, bracket: Bracket, at: usize) {
        if self.stack.len() >= BRACKET_LIMIT {
            return;
        }
        let before = at - 1;
        let open = if bracket == Bracket::Square { "[" } else { "{" };
        let gap = Span { start: self.lexemes[before].end, end: self.lexemes[before].end, file: self.file };
        let message = format!("`{open}` is missing after `{}`", self.slice(before));
        self.bracket_error.get_or_insert_with(|| {
            Diagnostic::error(codes::E0118, gap, message)
                .help(format!("write the `{open}` on the line of what it belongs to"))
                .suggest(gap, format!(" {open}"))
        });
        self.stack.push(Opener { bracket, lexeme: before });
        let start = self.lexemes[at].start;
        self.groups.push(Group { bracket, start, end: start, entries: Vec::new() });
        self.frames.push(Frame::new(self.groups.len() - 1, bracket));
    }
}
