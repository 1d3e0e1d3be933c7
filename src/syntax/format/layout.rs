//! Layout: which atoms stand on which line, and how deep.
//!
//! In: atoms with what is known of them. Out: [`Line`]s, whose pieces know the least blanks before them. A line ends
//! where it ended in the source; further ends come from brackets whose content has lines of its own.

use super::super::lexemes::{Bracket, Lexeme, LexemeKind};
use super::atoms::{Atom, AtomKind};
use super::spacing::Gap;
use super::structure::{Places, Shape};
use std::borrow::Cow;

/// Blanks by which what stands in brackets is deeper than its bracket's line.
const STEP: usize = 4;

/// A line to be written.
#[derive(Debug, Default)]
pub struct Line<'a> {
    pub indent: usize,
    pub blank_before: bool,
    pub pieces: Vec<Piece<'a>>,
    pub trailing: Option<Trailing<'a>>,
    /// It holds whole entries and nothing else.
    pub whole: bool,
}

impl Line<'_> {
    /// Whether nothing but a comment stands on it.
    pub fn is_comment(&self) -> bool {
        matches!(self.pieces.as_slice(), [piece] if is_comment(&piece.text))
    }
}

fn is_comment(text: &str) -> bool {
    text.starts_with("//") || text.starts_with("/*")
}

/// A lexeme, or a comment in the middle of a line.
#[derive(Debug)]
pub struct Piece<'a> {
    pub text: Cow<'a, str>,
    /// Blanks before it.
    pub blanks: usize,
    /// What a reader may want to stand under its like on the next line.
    pub column: Option<Column>,
    /// Blanks right before it in the source.
    pub written: usize,
    /// Characters between the line's first piece and this one, in the source.
    pub offset: usize,
}

/// A comment that ends a line.
#[derive(Debug)]
pub struct Trailing<'a> {
    pub text: Cow<'a, str>,
    pub blanks: usize,
    /// Characters before it on its line of the source.
    pub column: usize,
}

/// Why a piece may be aligned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// The value of the line's first field.
    Value,
    /// The comparison of a requirement.
    Comparison,
    /// A value inside a record, or what follows a comma.
    Cell,
}

/// An open bracket, or the file.
struct Frame {
    round: bool,
    broken: bool,
    /// Of the line with the bracket.
    outer: usize,
    /// Of what stands in it.
    indent: usize,
    /// Of the line on which the present entry began.
    entry: usize,
    /// No line has begun in it.
    fresh: bool,
    /// The entry before took several lines.
    after_long: bool,
}

/// Puts the atoms on lines.
pub fn lines<'a>(
    lexemes: &[Lexeme],
    places: &Places,
    shape: &Shape,
    gaps: &[Gap],
    atoms: &[Atom<'a>],
) -> Vec<Line<'a>> {
    let file = Frame { round: false, broken: true, outer: 0, indent: 0, entry: 0, fresh: true, after_long: false };
    let mut layout = Layout {
        lexemes,
        places,
        shape,
        gaps,
        atoms,
        lines: Vec::new(),
        line: Line::default(),
        frames: vec![file],
        first: 0,
        depth: 0,
        begins_entry: false,
        carried: 0,
    };
    for i in 0..atoms.len() {
        layout.place(i);
    }
    layout.end_line(false);
    layout.lines
}

struct Layout<'a, 'b> {
    lexemes: &'b [Lexeme],
    places: &'b Places,
    shape: &'b Shape,
    gaps: &'b [Gap],
    atoms: &'b [Atom<'a>],
    lines: Vec<Line<'a>>,
    line: Line<'a>,
    frames: Vec<Frame>,
    /// The atom that the present line begins with, the open brackets at that place, and whether it begins an entry.
    first: usize,
    depth: usize,
    begins_entry: bool,
    /// Line ends before a comma in `( )`: they come after it.
    carried: usize,
}

impl<'a> Layout<'a, '_> {
    fn place(&mut self, i: usize) {
        let atom = self.atoms[i];
        let kind = atom.lexeme().map(|at| self.lexemes[at].kind);
        if let (Some(at), Some(LexemeKind::Comma)) = (atom.lexeme(), kind) {
            let ends_line = i > 0 && self.atoms[i - 1].ends_line();
            if self.keeps_comma(i, at) {
                if ends_line {
                    self.end_line(true);
                    self.begin_line(i, self.depth_within(), false);
                }
                self.push(i, ",", 0);
                self.carried = if ends_line { 0 } else { atom.newlines };
            } else {
                self.carried = atom.newlines;
            }
            return;
        }
        let newlines = atom.newlines + std::mem::take(&mut self.carried);
        if self.breaks(i, newlines) {
            let inside = !self.shape.between[i];
            self.end_line(inside);
            let closes = matches!(kind, Some(LexemeKind::Close(_)));
            let indent = match (closes, self.frames.last()) {
                (_, None) => 0,
                (true, Some(frame)) => frame.outer,
                (false, Some(frame)) if inside && !frame.round => frame.entry + STEP,
                (false, Some(frame)) => frame.indent,
            };
            let after_doc = i > 0 && self.atoms[i - 1].kind == AtomKind::Doc;
            let fresh = self.frames.last_mut().is_none_or(|frame| std::mem::take(&mut frame.fresh));
            let blank = newlines > 1 && !inside && !closes && !fresh && !after_doc && !self.lines.is_empty();
            self.begin_line(i, indent, blank);
        }
        self.push(i, atom.text, self.blanks(i));
        let Some(at) = atom.lexeme() else { return };
        let indent = self.line.indent;
        if let Some(frame) = self.frames.last_mut()
            && self.places.begins_entry[at]
        {
            frame.entry = indent;
            frame.after_long = self.shape.spans_lines[at];
        }
        match self.lexemes[at].kind {
            LexemeKind::Open(bracket) => self.frames.push(Frame {
                round: bracket == Bracket::Round,
                broken: self.shape.broken[at],
                outer: indent,
                indent: indent + STEP,
                entry: indent,
                fresh: true,
                after_long: false,
            }),
            LexemeKind::Close(_) => drop(self.frames.pop()),
            _ => {}
        }
    }

    /// Whether the atom begins a line.
    fn breaks(&self, i: usize, newlines: usize) -> bool {
        let atom = &self.atoms[i];
        let Some(frame) = self.frames.last() else { return true };
        if i == 0 || atom.kind == AtomKind::Doc || self.atoms[i - 1].ends_line() {
            return true;
        }
        match atom.lexeme() {
            Some(at) if self.places.begins_item[at] => true,
            Some(at) if self.places.begins_entry[at] => {
                let long = self.shape.spans_lines[at] || frame.after_long;
                frame.broken && (frame.fresh || newlines > 0 || long)
            }
            Some(at) => match self.lexemes[at].kind {
                LexemeKind::Close(Bracket::Curly | Bracket::Square) => frame.broken,
                _ => newlines > 0,
            },
            // A comment on the line of a bracket belongs to the bracket, unless something follows it there.
            None if frame.fresh && frame.broken && self.shape.between[i] => {
                newlines > 0 || self.atoms.get(i + 1).is_some_and(|next| !atom.ends_line() && next.newlines == 0)
            }
            None => newlines > 0,
        }
    }

    /// A comma stays between what shares a line.
    fn keeps_comma(&self, i: usize, at: usize) -> bool {
        let rest = &self.atoms[i + 1..];
        let Some(count) = rest.iter().position(|atom| atom.lexeme().is_some()) else { return false };
        let Some(next) = rest[count].lexeme() else { return false };
        if !self.places.separates[at] {
            return self.lexemes[next].kind != LexemeKind::Close(Bracket::Round);
        }
        let Some(frame) = self.frames.last() else { return false };
        let ended = rest[..=count].iter().any(|atom| atom.newlines > 0) || rest[..count].iter().any(Atom::ends_line);
        let long = frame.broken && (self.shape.spans_lines[next] || frame.after_long);
        self.places.begins_entry[next] && !self.places.begins_item[next] && !ended && !long
    }

    /// The depth of a line that begins inside an entry.
    fn depth_within(&self) -> usize {
        self.frames.last().map_or(0, |frame| if frame.round { frame.indent } else { frame.entry + STEP })
    }

    /// Blanks before an atom that does not begin a line.
    fn blanks(&self, i: usize) -> usize {
        let Some(before) = i.checked_sub(1).map(|before| &self.atoms[before]) else { return 0 };
        match (before.lexeme(), self.atoms[i].lexeme()) {
            (Some(_), Some(at)) => self.gaps[at].blanks,
            (Some(at), None) => {
                let tight = [LexemeKind::Open(Bracket::Round), LexemeKind::Open(Bracket::Square)];
                usize::from(!tight.contains(&self.lexemes[at].kind))
            }
            (None, Some(at)) => {
                let tight = [LexemeKind::Close(Bracket::Round), LexemeKind::Close(Bracket::Square), LexemeKind::Comma];
                usize::from(!tight.contains(&self.lexemes[at].kind))
            }
            (None, None) => 1,
        }
    }

    fn push(&mut self, i: usize, text: &'a str, blanks: usize) {
        let atom = &self.atoms[i];
        let blanks = if self.line.pieces.is_empty() { 0 } else { blanks };
        self.line.pieces.push(Piece {
            text: if text.contains('\r') { text.replace("\r\n", "\n").into() } else { text.into() },
            blanks,
            column: if blanks == 0 { None } else { self.column(i) },
            written: atom.blanks,
            offset: atom.column.saturating_sub(self.atoms[self.first].column),
        });
    }

    /// Whether the atom stands where columns are made.
    fn column(&self, i: usize) -> Option<Column> {
        let at = self.atoms[i].lexeme()?;
        let before = self.atoms[i.checked_sub(1)?].lexeme()?;
        let outermost = self.frames.len() == self.depth;
        let first = self.line.pieces.iter().all(|piece| piece.column.is_none());
        match self.lexemes[before].kind {
            LexemeKind::Colon if outermost && first => return Some(Column::Value),
            LexemeKind::Colon | LexemeKind::Comma => return Some(Column::Cell),
            LexemeKind::Keyword => return None,
            _ => {}
        }
        let comparison = matches!(self.atoms[i].text, "<" | "<=" | ">" | ">=" | "==" | "!=");
        (comparison && self.lexemes[at].kind == LexemeKind::Operator && outermost && first)
            .then_some(Column::Comparison)
    }

    fn begin_line(&mut self, i: usize, indent: usize, blank_before: bool) {
        self.line = Line { indent, blank_before, ..Line::default() };
        self.first = i;
        self.depth = self.frames.len();
        self.begins_entry = self.atoms[i].lexeme().is_some_and(|at| self.places.begins_entry[at]);
    }

    /// Ends the present line. `inside`: in the middle of an entry.
    fn end_line(&mut self, inside: bool) {
        let mut line = std::mem::take(&mut self.line);
        if line.pieces.is_empty() {
            return;
        }
        let several = |text: &str| text.contains('\n');
        line.whole = self.begins_entry
            && !inside
            && self.frames.len() == self.depth
            && !line.pieces.iter().any(|piece| several(&piece.text));
        if line.pieces.len() > 1
            && let Some(last) = line.pieces.pop_if(|piece| is_comment(&piece.text))
        {
            // The author's blanks before it are kept: they put it under another one, perhaps far away.
            let (column, blanks) = (last.offset + self.atoms[self.first].column, last.written.max(1));
            line.trailing = Some(Trailing { text: last.text, blanks, column });
        }
        self.lines.push(line);
    }
}

/// The lines as text.
pub fn written(lines: &[Line<'_>], newline: &str) -> String {
    let mut out = String::new();
    let pad = |out: &mut String, blanks: usize| out.extend(std::iter::repeat_n(' ', blanks));
    for line in lines {
        if line.blank_before {
            out.push('\n');
        }
        pad(&mut out, line.indent);
        for piece in &line.pieces {
            pad(&mut out, piece.blanks);
            out.push_str(&piece.text);
        }
        if let Some(comment) = &line.trailing {
            pad(&mut out, comment.blanks);
            out.push_str(&comment.text);
        }
        out.push('\n');
    }
    if newline == "\n" { out } else { out.replace('\n', newline) }
}
