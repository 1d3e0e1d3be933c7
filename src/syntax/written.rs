//! One entry as the grammar sees it: a short text in which inner groups are `{}` or `[]`, and the way back from
//! every byte of it to the file.
//!
//! In: the parts of an entry. Out: [`Written`]. Small slips whose meaning is plain (a forgotten `:`, `=` for `:`, a
//! closing `;`) are said here and put right in the text, so that the rest of the entry is still read.

use super::entries::{Group, Part, RawEntry};
use super::lexemes::{Bracket, Lexeme, LexemeKind};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::{FileId, Span};

/// An entry's text for the grammar.
pub struct Written {
    pub text: String,
    /// Where each part begins in `text`, ascending, and what it stands for.
    places: Vec<Place>,
    file: FileId,
}

#[derive(Clone, Copy)]
struct Place {
    offset: usize,
    /// Bytes of the file that it stands for; empty for what was put in.
    start: u32,
    end: u32,
    part: Option<Part>,
}

impl Written {
    /// The place in the file of the bytes `start..end` of the text.
    pub fn span(&self, start: usize, end: usize) -> Span {
        let from = match self.place(start) {
            Some(place) => (place.start + (start - place.offset) as u32).min(place.end),
            None => 0,
        };
        let to = match self.place(end.saturating_sub(1).max(start)) {
            Some(place) if end > start => {
                let length = self.length(place);
                let inside = end - place.offset;
                // A part that was mended, or a group, has another length in the text than in the file.
                if inside >= length { place.end } else { (place.start + inside as u32).min(place.end) }
            }
            _ => from,
        };
        Span { file: self.file, start: from, end: to.max(from) }
    }

    /// What stands at a byte of the text; nothing at its end.
    pub fn part_at(&self, offset: usize) -> Option<Part> {
        if offset >= self.text.len() { None } else { self.place(offset)?.part }
    }

    /// What stands before a byte of the text.
    pub fn part_before(&self, offset: usize) -> Option<Part> {
        self.places.iter().rev().find(|place| place.offset < offset)?.part
    }

    /// The end of the last part, in the file.
    pub fn end(&self) -> Span {
        let end = self.places.last().map_or(0, |place| place.end);
        Span { file: self.file, start: end, end }
    }

    fn place(&self, offset: usize) -> Option<&Place> {
        let after = self.places.partition_point(|place| place.offset <= offset);
        self.places.get(after.checked_sub(1)?)
    }

    /// How long a place's writing is in the text, without the blank after it.
    fn length(&self, place: &Place) -> usize {
        let next = self.places.partition_point(|other| other.offset <= place.offset);
        let end = self.places.get(next).map_or(self.text.len(), |other| other.offset);
        self.text[place.offset..end].trim_end_matches([' ', '\n']).len()
    }
}

/// What an entry is written from.
pub struct Writer<'a> {
    pub file: FileId,
    pub text: &'a str,
    pub lexemes: &'a [Lexeme],
    pub groups: &'a [Group],
}

impl<'a> Writer<'a> {
    /// Writes an entry. `field` says that it stands where a field `name: value` is expected.
    pub fn write(&self, entry: &RawEntry, field: bool, said: &mut Vec<Diagnostic>) -> Written {
        let mut written =
            Written { text: String::new(), places: Vec::with_capacity(entry.parts.len()), file: self.file };
        let slip = if field && !entry.damaged { self.colon_slip(entry) } else { None };
        let mut line = None;
        for (i, &part) in entry.parts.iter().enumerate() {
            let (mut start, end) = self.range(part);
            let joined;
            let writing = match part {
                Part::Lexeme(_) if matches!(slip, Some(Slip::Pieces(n)) if i + 1 < n) => continue,
                Part::Lexeme(_) if slip == Some(Slip::Pieces(i + 1)) => {
                    joined = self.say_pieces(&entry.parts[..=i], said);
                    start = self.range(entry.parts[0]).0;
                    &joined
                }
                Part::Group(g) if self.groups[g].bracket == Bracket::Curly => "{}",
                Part::Group(_) => "[]",
                Part::Lexeme(l) if self.lexemes[l].kind == LexemeKind::Unknown => continue,
                Part::Lexeme(_) if i == 1 && slip == Some(Slip::Equals) => {
                    said.push(self.say_equals(entry.parts[0], part));
                    ":"
                }
                Part::Lexeme(l) => self.lexemes[l].mended.as_deref().unwrap_or(self.slice(part)),
            };
            let this_line = self.line(part);
            if let Some(last) = written.places.last()
                && last.end != start
            {
                written.text.push(if line == Some(this_line.0) { ' ' } else { '\n' });
            }
            line = Some(this_line.1);
            written.places.push(Place { offset: written.text.len(), start, end, part: Some(part) });
            written.text.push_str(writing);
            if i == 0 && slip == Some(Slip::NoColon) {
                let name = Span { file: self.file, start, end };
                said.push(
                    Diagnostic::error(codes::E0121, name, format!("`:` is missing after `{}`", self.slice(part)))
                        .help("a field is written `name: value`")
                        .suggest(Span { start: end, ..name }, ":"),
                );
                written.places.push(Place { offset: written.text.len(), start: end, end, part: None });
                written.text.push(':');
            }
        }
        written
    }

    /// The bytes that a part stands for.
    pub fn range(&self, part: Part) -> (u32, u32) {
        match part {
            Part::Lexeme(i) => (self.lexemes[i].start, self.lexemes[i].end),
            Part::Group(g) => (self.groups[g].start, self.groups[g].end),
        }
    }

    /// What a part looks like in the file.
    pub fn slice(&self, part: Part) -> &'a str {
        let (start, end) = self.range(part);
        &self.text[start as usize..end as usize]
    }

    /// The kind of a lexeme; none for a group.
    pub fn kind(&self, part: Option<&Part>) -> Option<LexemeKind> {
        match part {
            Some(&Part::Lexeme(i)) => Some(self.lexemes[i].kind),
            _ => None,
        }
    }

    /// The lexeme that begins or ends at a byte: the first at or after `start`.
    pub fn lexeme_from(&self, start: u32) -> usize {
        self.lexemes.partition_point(|lexeme| lexeme.start < start)
    }

    /// The lines on which a part begins and ends.
    fn line(&self, part: Part) -> (u32, u32) {
        match part {
            Part::Lexeme(i) => (self.lexemes[i].line, self.lexemes[i].line),
            Part::Group(g) => {
                let line = |at: usize| self.lexemes.get(at).map_or(u32::MAX, |lexeme| lexeme.line);
                let last = self.lexemes.partition_point(|lexeme| lexeme.end <= self.groups[g].end);
                (line(self.lexeme_from(self.groups[g].start)), line(last.saturating_sub(1)))
            }
        }
    }

    fn colon_slip(&self, entry: &RawEntry) -> Option<Slip> {
        if self.kind(entry.parts.first()) != Some(LexemeKind::Word) {
            return None;
        }
        let second = *entry.parts.get(1)?;
        if self.line(entry.parts[0]).1 != self.line(second).0 {
            return None;
        }
        match self.kind(Some(&second)) {
            Some(LexemeKind::Operator) if self.slice(second) == "=" => Some(Slip::Equals),
            Some(LexemeKind::Word) if self.kind(entry.parts.get(2)) == Some(LexemeKind::Colon) => Some(Slip::Pieces(2)),
            Some(LexemeKind::Operator) if self.slice(second) == "-" => self.hyphens(entry),
            Some(LexemeKind::Number | LexemeKind::Text | LexemeKind::Word) => Some(Slip::NoColon),
            None if matches!(second, Part::Group(g) if self.groups[g].bracket == Bracket::Square) => {
                Some(Slip::NoColon)
            }
            _ => None,
        }
    }

    /// `point-step: 4 mm`: how many parts the name has.
    fn hyphens(&self, entry: &RawEntry) -> Option<Slip> {
        let colon = entry.parts.iter().position(|part| self.kind(Some(part)) == Some(LexemeKind::Colon))?;
        let pieces = &entry.parts[..colon];
        let name = |part: &Part| matches!(self.kind(Some(part)), Some(LexemeKind::Word | LexemeKind::Number));
        let good =
            pieces.iter().enumerate().all(|(i, part)| if i % 2 == 0 { name(part) } else { self.slice(*part) == "-" });
        let close = pieces.windows(2).all(|pair| self.range(pair[0]).1 == self.range(pair[1]).0);
        (good && close && colon % 2 == 1).then_some(Slip::Pieces(colon))
    }

    /// The pieces are read as the one name that may be meant.
    fn say_pieces(&self, pieces: &[Part], said: &mut Vec<Diagnostic>) -> String {
        let (first, last) = (pieces[0], pieces[pieces.len() - 1]);
        let place = Span { file: self.file, start: self.range(first).0, end: self.range(last).1 };
        let words: Vec<&str> = pieces.iter().map(|part| self.slice(*part)).filter(|word| *word != "-").collect();
        let name = if words.len() == 2 && words[0] == words[1] { words[0].to_string() } else { words.join("_") };
        let hyphens = words.len() < pieces.len();
        let written = words.join(if hyphens { "-" } else { " " });
        let help = match hyphens {
            true => format!("write `{name}`; a `-` subtracts"),
            false => format!("write `{name}`, or a comma between two fields"),
        };
        said.push(
            Diagnostic::error(codes::E0107, place, format!("`{written}` is not one name"))
                .help(help)
                .suggest(place, name.clone()),
        );
        name
    }

    fn say_equals(&self, name: Part, part: Part) -> Diagnostic {
        let (start, end) = self.range(part);
        let place = Span { file: self.file, start, end };
        let gap = Span { start: self.range(name).1, ..place };
        Diagnostic::error(codes::E0121, place, "a field is set by `:`, not by `=`").help("write `:`").suggest(gap, ":")
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Slip {
    Equals,
    NoColon,
    /// `outer diameter: 4 mm`, `outer-diameter: 4 mm`: the name is in so many parts.
    Pieces(usize),
}
