//! Entries: brackets matched, and what stands in them cut into entries, before any grammar.
//!
//! In: the lexemes of a file. Out: an arena of [`Group`]s (the file itself, each `{ … }`, each `[ … ]`) whose
//! [`RawEntry`]s are short runs of lexemes and inner groups. A mistake inside one entry so stays inside it.
//!
//! A *chunk* runs from an item word at the left edge to the next one; no bracket reaches over its border. A chunk is
//! first matched by its brackets alone. Only if that fails is it matched again with the indentation as a witness of
//! what was meant, so a correct file means the same however it is indented, and one bracket error is said for a chunk.

use super::lexemes::{Bracket, Lexed, Lexeme, LexemeKind};
use crate::diagnostics::{Diagnostic, Suggestion, codes};
use crate::source::{FileId, Span};

/// How deep brackets may stand in each other. Jobs nest six to ten deep; every later pass recurses over the tree.
pub const BRACKET_LIMIT: usize = 64;

/// How deep the tree may get, operators included: a chain of operators is a tree as deep as it is long. The later
/// passes recurse over it, and a thread's stack (2 MiB) holds several thousand of their frames.
pub const DEPTH_LIMIT: usize = 512;

/// How many lexemes one entry may have, brackets of nested entries counted as one. More is data and belongs in a file.
pub const ENTRY_LIMIT: usize = 4096;

/// A piece of an entry.
#[derive(Clone, Copy, Debug)]
pub enum Part {
    /// Index of a lexeme.
    Lexeme(usize),
    /// Index of a group in the arena.
    Group(usize),
}

/// What stands between two ends of entries.
#[derive(Clone, Debug, Default)]
pub struct RawEntry {
    pub parts: Vec<Part>,
    /// Something in it was reported already: whatever else is wrong with it is a consequence.
    pub damaged: bool,
}

/// The file, or what stands in `{ }` or `[ ]`.
#[derive(Clone, Debug)]
pub struct Group {
    pub bracket: Bracket,
    /// Bytes from the opening bracket to the end of the closing one.
    pub start: u32,
    pub end: u32,
    pub entries: Vec<RawEntry>,
}

/// The groups of a file; the first is the file itself.
pub struct Entries {
    pub groups: Vec<Group>,
}

/// An opening bracket that still waits for its closer.
#[derive(Clone, Copy)]
pub(super) struct Opener {
    pub(super) bracket: Bracket,
    pub(super) lexeme: usize,
}

/// A group that is being filled.
pub(super) struct Frame {
    pub(super) group: usize,
    pub(super) bracket: Bracket,
    pub(super) entry: RawEntry,
    /// Operators of the entry so far, and the depth of the deepest group in it.
    pub(super) operators: usize,
    pub(super) deepest: usize,
    /// Depth of the deepest entry that has ended.
    pub(super) depth: usize,
}

pub(super) struct Matcher<'a> {
    pub(super) file: FileId,
    pub(super) text: &'a str,
    pub(super) lexemes: &'a [Lexeme],
    pub(super) groups: Vec<Group>,
    pub(super) frames: Vec<Frame>,
    pub(super) stack: Vec<Opener>,
    /// The second try: indentation decides between closers.
    pub(super) by_indent: bool,
    /// The first bracket error of the chunk; the others follow from it.
    pub(super) bracket_error: Option<Diagnostic>,
    pub(super) others: Vec<Diagnostic>,
    /// Brackets beyond the limit that are open.
    pub(super) beyond: usize,
    /// The limit of depth was passed and said.
    pub(super) too_deep: bool,
}

/// Cuts the file into entries.
pub fn entries(file: FileId, text: &str, lexed: &Lexed, diagnostics: &mut Vec<Diagnostic>) -> Entries {
    let lexemes = &lexed.lexemes;
    let whole = Group { bracket: Bracket::Curly, start: 0, end: text.len() as u32, entries: Vec::new() };
    let mut groups = vec![whole];
    let mut from = 0;
    while from < lexemes.len() {
        let to = (from + 1..lexemes.len()).find(|&i| begins_item(text, lexemes, i)).unwrap_or(lexemes.len());
        let (groups_before, entries_before) = (groups.len(), groups[0].entries.len());
        let mut matcher = Matcher::run(file, text, lexemes, from..to, groups, false);
        if let Some(by_brackets) = matcher.bracket_error {
            groups = matcher.groups;
            groups.truncate(groups_before);
            groups[0].entries.truncate(entries_before);
            matcher = Matcher::run(file, text, lexemes, from..to, groups, is_indented(&lexemes[from + 1..to]));
            // What an unclosed comment or text swallowed may have held the closing brackets.
            let swallowed = (lexed.cut_short && to == lexemes.len())
                || lexemes[from..to].iter().any(|lexeme| lexeme.lost && lexeme.kind != LexemeKind::Number);
            // A bracket beyond the depth limit that is not closed either is one mistake, said already.
            if !swallowed && !matcher.too_deep {
                diagnostics.push(matcher.bracket_error.unwrap_or(by_brackets));
            }
            // Whatever stands outside the item now stood inside it once.
            for entry in matcher.groups[0].entries.iter_mut().skip(entries_before + 1) {
                entry.damaged = true;
            }
        }
        diagnostics.append(&mut matcher.others);
        groups = matcher.groups;
        from = to;
    }
    if lexed.cut_short {
        damage_last(&mut groups);
    }
    Entries { groups }
}

/// Whether the lines after an item's first are indented, so that their indentation says something.
fn is_indented(lexemes: &[Lexeme]) -> bool {
    let flush = |lexeme: &Lexeme| {
        lexeme.begins_line && lexeme.indent == 0 && !matches!(lexeme.kind, LexemeKind::Open(_) | LexemeKind::Close(_))
    };
    !lexemes.iter().any(flush)
}

/// The entry that an unclosed comment cut short, and those around it, say nothing more.
fn damage_last(groups: &mut [Group]) {
    let mut group = 0;
    while let Some(entry) = groups[group].entries.last_mut() {
        entry.damaged = true;
        match entry.parts.last() {
            Some(&Part::Group(inner)) => group = inner,
            _ => return,
        }
    }
}

/// Whether the lexeme is an item's first word at the left edge. `allow` also stands inside records, so it begins nothing.
fn begins_item(text: &str, lexemes: &[Lexeme], at: usize) -> bool {
    let lexeme = &lexemes[at];
    let word = &text[lexeme.start as usize..lexeme.end as usize];
    if !lexeme.begins_line || lexeme.indent > 0 || !is_item_word(word) || word == "allow" {
        return false;
    }
    let next = lexemes.get(at + 1).filter(|next| next.line == lexeme.line).map(|next| next.kind);
    match next {
        Some(LexemeKind::Word | LexemeKind::Text | LexemeKind::Number) => true,
        // A condition may begin in many ways.
        Some(kind) => word == "assert" && kind != LexemeKind::Colon,
        None => false,
    }
}

/// The words that begin an item or, `allow`, stand before one.
pub fn is_item_word(word: &str) -> bool {
    const ITEMS: [&str; 13] = [
        "language",
        "use",
        "let",
        "param",
        "fn",
        "schema",
        "family",
        "job",
        "allow",
        "assert",
        "pub",
        "dimension",
        "unit",
    ];
    ITEMS.contains(&word)
}

impl<'a> Matcher<'a> {
    fn run(
        file: FileId,
        text: &'a str,
        lexemes: &'a [Lexeme],
        range: std::ops::Range<usize>,
        groups: Vec<Group>,
        by_indent: bool,
    ) -> Matcher<'a> {
        let mut matcher = Matcher {
            file,
            text,
            lexemes,
            groups,
            frames: Vec::new(),
            stack: Vec::new(),
            by_indent,
            bracket_error: None,
            others: Vec::new(),
            beyond: 0,
            too_deep: false,
        };
        matcher.frames.push(Frame::new(0, Bracket::Curly));
        for at in range {
            matcher.step(at);
        }
        while !matcher.stack.is_empty() {
            matcher.close_unclosed();
        }
        matcher.end_entry();
        matcher
    }

    fn step(&mut self, at: usize) {
        let lexeme = &self.lexemes[at];
        if self.beyond > 0 {
            match lexeme.kind {
                LexemeKind::Open(_) => self.beyond += 1,
                LexemeKind::Close(_) => self.beyond -= 1,
                _ => {}
            }
            return;
        }
        if lexeme.begins_line {
            self.begin_line(at);
        }
        if self.by_indent
            && let Some(bracket) = self.forgotten_opener(at)
        {
            self.open_forgotten(bracket, at);
        }
        if self.by_indent && self.is_doubled_opener(at) {
            let diagnostic = Diagnostic::error(codes::E0102, self.span(at), "this `{` is never closed");
            self.bracket_error.get_or_insert(diagnostic.help("delete it"));
            return;
        }
        match lexeme.kind {
            LexemeKind::Open(bracket) => self.open(bracket, at),
            LexemeKind::Close(bracket) => self.close(bracket, at),
            LexemeKind::Comma if !self.in_round() => self.comma(at),
            LexemeKind::Mark if self.slice(at) == ";" && !self.in_round() && self.frame().bracket == Bracket::Curly => {
                self.semicolon(at);
            }
            _ => {
                if self.lacks_comma(at) {
                    let before = self.span(at - 1);
                    let gap = Span { start: before.end, ..before };
                    self.others.push(
                        Diagnostic::error(codes::E0119, self.span(at), "a comma is missing between two fields")
                            .help("fields on one line are separated by commas")
                            .suggest(gap, ","),
                    );
                    self.end_entry();
                }
                self.push(Part::Lexeme(at));
            }
        }
    }

    /// What a newline before the lexeme ends.
    fn begin_line(&mut self, at: usize) {
        let lexeme = &self.lexemes[at];
        if self.by_indent && !matches!(lexeme.kind, LexemeKind::Close(_)) {
            while let Some(opener) = self.stack.last()
                && self.lexemes[opener.lexeme].indent >= lexeme.indent
                && self.lexemes[opener.lexeme].line < lexeme.line
            {
                self.close_unclosed();
            }
        }
        let field = self.names_field(at);
        if field {
            let argument = |kind| matches!(kind, LexemeKind::Open(Bracket::Round) | LexemeKind::Comma);
            while let Some(opener) = self.stack.last()
                && opener.bracket != Bracket::Curly
                && !(opener.bracket == Bracket::Round && argument(self.lexemes[at - 1].kind))
            {
                self.close_unclosed();
            }
        }
        if self.in_round() {
            return;
        }
        if !field && !self.begins_allow(at) && (self.goes_on_after() || self.goes_on_before(at)) {
            return;
        }
        if self.by_indent && self.forgotten_opener(at).is_some() {
            return;
        }
        if lexeme.kind == LexemeKind::Open(Bracket::Curly) && self.brace_is_late(at) || self.name_is_late(at) {
            return;
        }
        self.end_entry();
        if self.frame().bracket == Bracket::Square && self.slice(at) == "-" && self.is_spaced(at) {
            let gap = Span { start: lexeme.end, end: self.lexemes[at + 1].start, file: self.file };
            self.others.push(
                Diagnostic::error(codes::E0115, self.span(at), "a line of a list begins with `-` and a blank")
                    .note("it could be read as a new element or as a subtraction")
                    .help("write `-` close to its number for a new element, or end the line before with `-`")
                    .suggest(gap, ""),
            );
        }
    }

    pub(super) fn is_spaced(&self, at: usize) -> bool {
        self.lexemes
            .get(at + 1)
            .is_some_and(|next| next.start > self.lexemes[at].end && next.line == self.lexemes[at].line)
    }

    /// Whether the entry so far asks for more.
    pub(super) fn goes_on_after(&self) -> bool {
        match self.frame().entry.parts.last() {
            Some(&Part::Lexeme(i)) => {
                matches!(self.lexemes[i].kind, LexemeKind::Operator | LexemeKind::Keyword | LexemeKind::Colon)
            }
            _ => false,
        }
    }

    /// Whether a line that begins with this lexeme goes on with the entry before it.
    fn goes_on_before(&self, at: usize) -> bool {
        match self.lexemes[at].kind {
            LexemeKind::Operator => !matches!(self.slice(at), "+" | "-"),
            LexemeKind::Keyword => !matches!(self.slice(at), "not" | "if"),
            _ => false,
        }
    }

    /// A word with a `:` after it on its line.
    pub(super) fn names_field(&self, at: usize) -> bool {
        self.lexemes[at].kind == LexemeKind::Word
            && self
                .lexemes
                .get(at + 1)
                .is_some_and(|next| next.kind == LexemeKind::Colon && next.line == self.lexemes[at].line)
    }

    /// `allow` with a word after it on its line: no value is written so, and no value goes on into such a line.
    fn begins_allow(&self, at: usize) -> bool {
        let next = self.lexemes.get(at + 1);
        self.slice(at) == "allow"
            && next.is_some_and(|next| next.kind == LexemeKind::Word && next.line == self.lexemes[at].line)
    }

    fn comma(&mut self, at: usize) {
        if !self.frame().entry.parts.is_empty() {
            self.end_entry();
            return;
        }
        // Of several commas in a row the first that is too many is said, with the mend for all of them.
        let row = Span { start: self.lexemes[at.saturating_sub(1)].start, ..self.span(at) };
        if let Some(last) = self.others.last_mut()
            && last.code == codes::E0111
            && last.suggestions.last().is_some_and(|mend| mend.span.start == row.start)
            && self.text[row.start as usize + 1..row.end as usize - 1].trim().is_empty()
        {
            last.suggestions.push(Suggestion {
                span: Span { file: self.file, start: self.lexemes[at].start, end: self.lexemes[at].end },
                replacement: String::new(),
            });
            return;
        }
        self.others.push(
            Diagnostic::error(codes::E0111, self.span(at), "this comma has nothing before it")
                .note("an entry ends at a comma or at the end of its line, and one trailing comma is allowed")
                .help("delete the comma")
                .suggest(self.span(at), ""),
        );
    }

    /// Read as the comma that is meant; in `[ ]` it belongs to a type.
    fn semicolon(&mut self, at: usize) {
        let line = self.lexemes[at].line;
        let more = |next: &Lexeme| next.line == line && !matches!(next.kind, LexemeKind::Close(_));
        let (help, mend) = match self.lexemes.get(at + 1).is_some_and(more) {
            true => ("write a comma", ","),
            false => ("delete it", ""),
        };
        if !self.frame().entry.damaged {
            self.others.push(
                Diagnostic::error(codes::E0107, self.span(at), "entries are not ended by `;`")
                    .note("an entry ends at the end of its line or at a comma")
                    .help(help)
                    .suggest(self.span(at), mend),
            );
        }
        self.end_entry();
    }

    fn open(&mut self, bracket: Bracket, at: usize) {
        if self.stack.len() >= BRACKET_LIMIT {
            self.say_too_deep(at, format!("brackets stand more than {BRACKET_LIMIT} deep in each other"));
            self.frames.iter_mut().for_each(|frame| frame.entry.damaged = true);
            self.beyond = 1;
            return;
        }
        self.stack.push(Opener { bracket, lexeme: at });
        if bracket == Bracket::Round {
            self.push(Part::Lexeme(at));
            return;
        }
        let (start, end) = (self.lexemes[at].start, self.lexemes[at].end);
        self.groups.push(Group { bracket, start, end, entries: Vec::new() });
        self.frames.push(Frame::new(self.groups.len() - 1, bracket));
    }

    fn close(&mut self, bracket: Bracket, at: usize) {
        match self.matching(bracket, at) {
            Some(level) => {
                while self.stack.len() > level + 1 {
                    self.close_unclosed();
                }
                self.pop(Some(at));
            }
            None => {
                self.frame_mut().entry.damaged |= !self.lexemes[at].begins_line;
                let message = format!("`{}` closes nothing", bracket.closer());
                let mut diagnostic = Diagnostic::error(codes::E0103, self.span(at), message);
                if let Some(opener) = self.stack.last() {
                    let waits = format!("this waits for `{}`", opener.bracket.closer());
                    diagnostic = diagnostic.also(self.span(opener.lexeme), waits);
                }
                // By the lines around it there is no other reading.
                let sure = self.stack.len().checked_sub(1).is_some_and(|top| self.is_too_many(top, at));
                let span = self.span(at);
                self.bracket_error.get_or_insert(match sure {
                    true => diagnostic.help("delete it").suggest(span, ""),
                    false => diagnostic.help("delete it, or write the bracket that it closes"),
                });
            }
        }
    }

    /// The level of the opener that this closer closes.
    fn matching(&self, bracket: Bracket, at: usize) -> Option<usize> {
        let closer = &self.lexemes[at];
        let top = self.stack.len().checked_sub(1)?;
        if self.by_indent && closer.begins_line {
            let indent = |level: usize| self.lexemes[self.stack[level].lexeme].indent;
            let same = (0..=top).rev().find(|&l| self.stack[l].bracket == bracket && indent(l) == closer.indent);
            if same.is_some() || indent(top) < closer.indent {
                return same;
            }
        }
        if self.stack[top].bracket == bracket {
            return (!self.is_too_many(top, at)).then_some(top);
        }
        let level = (0..top).rev().find(|&l| self.stack[l].bracket == bracket)?;
        let same_line = |o: &Opener| self.lexemes[o.lexeme].line == closer.line;
        let inward = closer.begins_line || self.stack[level + 1..].iter().all(same_line);
        inward.then_some(level)
    }

    /// The `//` on the line of an opener behind which its closer stands: `speed: 50 mm//s }`.
    fn hidden_closer(&self, opener: usize, close: &str) -> Option<Span> {
        let line = self.lexemes[opener].line;
        let last = self.lexemes[opener..].iter().take_while(|lexeme| lexeme.line == line).last()?;
        let rest = self.text[last.end as usize..].lines().next().unwrap_or("");
        let blanks = rest.len() - rest.trim_start().len();
        let comment = rest[blanks..].strip_prefix("//")?;
        let start = last.end + blanks as u32;
        comment.contains(close).then_some(Span { file: self.file, start, end: start + 2 })
    }

    /// Whether a closer behind other words would close a bracket of an earlier line, though the lines after it still stand
    /// inside that bracket: `}}` for `}`.
    fn is_too_many(&self, level: usize, at: usize) -> bool {
        let (opener, closer) = (&self.lexemes[self.stack[level].lexeme], &self.lexemes[at]);
        if !self.by_indent || closer.begins_line || opener.line == closer.line {
            return false;
        }
        let next = self.lexemes[at..].iter().find(|lexeme| lexeme.begins_line && lexeme.line > closer.line);
        next.is_some_and(|next| {
            let closes = matches!(next.kind, LexemeKind::Close(_)) && next.indent == opener.indent;
            next.indent > opener.indent || closes
        })
    }

    /// Closes the innermost bracket, whose closer is missing.
    fn close_unclosed(&mut self) {
        if let Some(opener) = self.stack.last() {
            let span = self.span(opener.lexeme);
            let (open, close) = (self.slice(opener.lexeme), opener.bracket.closer());
            let hidden = self.hidden_closer(opener.lexeme, close);
            self.bracket_error.get_or_insert_with(|| match hidden {
                Some(comment) => Diagnostic::error(codes::E0102, comment, format!("this comment hides a `{close}`"))
                    .also(span, format!("this `{open}` is never closed"))
                    .help(format!("write the `{close}` before the comment")),
                None => Diagnostic::error(codes::E0102, span, format!("this `{open}` is never closed"))
                    .help(format!("write the `{close}` where what it opens ends")),
            });
            if opener.bracket == Bracket::Round {
                self.frame_mut().entry.damaged = true;
            }
            self.pop(None);
        }
    }

    fn pop(&mut self, closer: Option<usize>) {
        let Some(opener) = self.stack.pop() else { return };
        if opener.bracket == Bracket::Round {
            if let Some(at) = closer {
                self.push(Part::Lexeme(at));
            }
            return;
        }
        self.end_entry();
        let Some(frame) = self.frames.pop() else { return };
        let depth = frame.depth + 1;
        let last = frame.last_end(&self.groups, self.lexemes);
        let group = &mut self.groups[frame.group];
        group.end = closer.map_or(last.unwrap_or(group.end), |at| self.lexemes[at].end);
        let parent = self.frame_mut();
        parent.deepest = parent.deepest.max(depth);
        self.push(Part::Group(frame.group));
    }

    fn push(&mut self, part: Part) {
        let kind = match part {
            Part::Lexeme(i) => Some(self.lexemes[i].kind),
            _ => None,
        };
        let counts = matches!(kind, Some(LexemeKind::Operator | LexemeKind::Keyword | LexemeKind::Open(_)));
        let frame = self.frame_mut();
        frame.entry.damaged |= kind == Some(LexemeKind::Unknown);
        frame.operators += usize::from(counts);
        if frame.entry.parts.len() < ENTRY_LIMIT {
            frame.entry.parts.push(part);
        } else if !frame.entry.damaged {
            frame.entry.damaged = true;
            if let Part::Lexeme(at) = part {
                let message = format!("one entry has more than {ENTRY_LIMIT} words");
                self.others.push(
                    Diagnostic::error(codes::E0110, self.span(at), message)
                        .help("keep data in a file of its own, and name the file"),
                );
            }
        }
    }

    fn end_entry(&mut self) {
        let frame = self.frame_mut();
        let depth = frame.operators + frame.deepest;
        frame.operators = 0;
        frame.deepest = 0;
        if frame.entry.parts.is_empty() {
            return;
        }
        let entry = std::mem::take(&mut frame.entry);
        if depth > DEPTH_LIMIT {
            // The entry is dropped whole: a tree so deep could not even be taken apart again.
            if let Some(at) = self.first_lexeme(&entry).filter(|_| !entry.damaged) {
                self.say_too_deep(at, format!("this expression is more than {DEPTH_LIMIT} operations deep"));
            }
            return;
        }
        let frame = self.frame_mut();
        frame.depth = frame.depth.max(depth);
        let group = frame.group;
        self.groups[group].entries.push(entry);
    }

    fn first_lexeme(&self, entry: &RawEntry) -> Option<usize> {
        match *entry.parts.first()? {
            Part::Lexeme(i) => Some(i),
            Part::Group(g) => {
                let start = self.groups[g].start;
                self.lexemes.binary_search_by_key(&start, |lexeme| lexeme.start).ok()
            }
        }
    }

    fn say_too_deep(&mut self, at: usize, message: String) {
        if !std::mem::replace(&mut self.too_deep, true) {
            let diagnostic = Diagnostic::error(codes::E0110, self.span(at), message);
            self.others.push(diagnostic.help("give a part of it a name with `let`, and use the name"));
        }
    }

    pub(super) fn frame(&self) -> &Frame {
        // The file's own frame is never popped: only brackets on the stack pop a frame.
        self.frames.last().expect("the file's frame")
    }

    pub(super) fn frame_mut(&mut self) -> &mut Frame {
        self.frames.last_mut().expect("the file's frame")
    }

    pub(super) fn in_round(&self) -> bool {
        self.stack.last().is_some_and(|opener| opener.bracket == Bracket::Round)
    }

    pub(super) fn slice(&self, at: usize) -> &'a str {
        &self.text[self.lexemes[at].start as usize..self.lexemes[at].end as usize]
    }

    pub(super) fn span(&self, at: usize) -> Span {
        Span { file: self.file, start: self.lexemes[at].start, end: self.lexemes[at].end }
    }
}

impl Frame {
    pub(super) fn new(group: usize, bracket: Bracket) -> Frame {
        Frame { group, bracket, entry: RawEntry::default(), operators: 0, deepest: 0, depth: 0 }
    }

    /// Where the last thing in it ends.
    fn last_end(&self, groups: &[Group], lexemes: &[Lexeme]) -> Option<u32> {
        match *groups[self.group].entries.last()?.parts.last()? {
            Part::Lexeme(i) => Some(lexemes[i].end),
            Part::Group(g) => Some(groups[g].end),
        }
    }
}
