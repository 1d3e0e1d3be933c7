//! Spacing: the blanks between two lexemes on one line.
//!
//! In: the lexemes. Out: a [`Gap`] for each. Blanks carry meaning in one place: `mm/s` close together is a unit, `mm / s`
//! a division. So units are found first, as the grammar finds them, and kept close.

use super::super::lexemes::{Bracket, Lexeme, LexemeKind};
use super::structure::Places;

/// How a lexeme follows the one before it on its line.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gap {
    /// Blanks before it: 0 or 1.
    pub blanks: usize,
    /// It is a sign before its operand, not a subtraction.
    pub is_sign: bool,
}

/// What is known of a lexeme on the way.
#[derive(Clone, Copy, Default)]
struct Note {
    /// It belongs to a unit and is not the unit's first word.
    in_unit: bool,
    begins_unit: bool,
    ends_unit: bool,
    is_sign: bool,
    /// The `/` of a power such as `(1/2)`.
    is_fraction: bool,
}

/// The gap before each lexeme of a file without mistakes.
pub fn gaps(text: &str, lexemes: &[Lexeme], places: &Places) -> Vec<Gap> {
    let row = Row { text, lexemes, places };
    let mut notes = vec![Note::default(); lexemes.len()];
    for at in 0..lexemes.len() {
        row.note_unit(at, &mut notes);
        row.note_fraction(at, &mut notes);
        notes[at].is_sign = row.is_sign(at, &notes);
    }
    (0..lexemes.len())
        .map(|at| Gap { blanks: usize::from(row.is_spaced(at, &notes)), is_sign: notes[at].is_sign })
        .collect()
}

struct Row<'a> {
    text: &'a str,
    lexemes: &'a [Lexeme],
    places: &'a Places,
}

impl<'a> Row<'a> {
    fn slice(&self, at: usize) -> &'a str {
        self.lexemes.get(at).map_or("", |lexeme| &self.text[lexeme.start as usize..lexeme.end as usize])
    }

    fn kind(&self, at: usize) -> Option<LexemeKind> {
        self.lexemes.get(at).map(|lexeme| lexeme.kind)
    }

    fn is_close(&self, at: usize) -> bool {
        at > 0 && self.lexemes.get(at).is_some_and(|lexeme| lexeme.start == self.lexemes[at - 1].end)
    }

    fn is_unit_word(&self, at: usize) -> bool {
        self.kind(at) == Some(LexemeKind::Word) || self.slice(at) == "%"
    }

    /// A unit stands on the line of its number or list; its factors are close together, with at most one `/`, the last.
    fn note_unit(&self, before: usize, notes: &mut [Note]) {
        let number = matches!(self.kind(before), Some(LexemeKind::Number | LexemeKind::Close(Bracket::Square)));
        let first = before + 1;
        let here = self.lexemes.get(first).is_some_and(|lexeme| lexeme.line == self.lexemes[before].line);
        if !number || !here || !self.is_unit_word(first) || self.places.begins_entry[first] || notes[before].in_unit {
            return;
        }
        notes[first].begins_unit = true;
        let mut last = self.unit_power(first);
        while self.is_close(last + 1) && self.is_close(last + 2) && self.is_unit_word(last + 2) {
            let divided = match self.slice(last + 1) {
                "*" => false,
                "/" => true,
                _ => break,
            };
            last = self.unit_power(last + 2);
            if divided {
                break;
            }
        }
        notes[first + 1..=last].iter_mut().for_each(|note| note.in_unit = true);
        notes[last].ends_unit = true;
    }

    /// The last lexeme of the factor whose word is `word`: `s`, `s^2`, `m^-1`.
    fn unit_power(&self, word: usize) -> usize {
        let number = if self.slice(word + 2) == "-" { word + 3 } else { word + 2 };
        let close = (word + 1..=number).all(|at| self.is_close(at));
        if close && self.slice(word + 1) == "^" && self.kind(number) == Some(LexemeKind::Number) {
            number
        } else {
            word
        }
    }

    /// `^(1/2)` and `^(-1/2)`: in a type the grammar wants the fraction close together.
    fn note_fraction(&self, at: usize, notes: &mut [Note]) {
        if self.slice(at) != "^" || self.slice(at + 1) != "(" {
            return;
        }
        let number = if self.slice(at + 2) == "-" { at + 3 } else { at + 2 };
        let is_number = |at: usize| self.kind(at) == Some(LexemeKind::Number);
        if is_number(number) && self.slice(number + 1) == "/" && is_number(number + 2) && self.slice(number + 3) == ")"
        {
            notes[number + 1].is_fraction = true;
        }
    }

    /// Whether it is a minus before an operand.
    fn is_sign(&self, at: usize, notes: &[Note]) -> bool {
        if self.slice(at) != "-" || notes[at].in_unit {
            return false;
        }
        if at == 0 || self.places.begins_entry[at] || self.is_opening_word(at - 1) {
            return true;
        }
        !matches!(
            self.lexemes[at - 1].kind,
            LexemeKind::Word | LexemeKind::Number | LexemeKind::Text | LexemeKind::Close(_) | LexemeKind::Mark
        )
    }

    /// A word that stands before an expression without being reserved.
    fn is_opening_word(&self, at: usize) -> bool {
        self.places.begins_entry[at] && matches!(self.slice(at), "check" | "assert")
    }

    fn is_spaced(&self, at: usize, notes: &[Note]) -> bool {
        let Some(before) = at.checked_sub(1) else { return false };
        let (note, last) = (notes[at], notes[before]);
        if note.in_unit || note.is_fraction || last.is_fraction || last.is_sign {
            return false;
        }
        if note.begins_unit {
            return true;
        }
        // After a unit a close `^` would be the unit's own power.
        if self.slice(at) == "^" {
            return last.ends_unit;
        }
        if self.slice(before) == "^" && !last.in_unit {
            return before > 0 && notes[before - 1].ends_unit;
        }
        let opener = match self.lexemes[before].kind {
            LexemeKind::Open(bracket) => Some(bracket),
            _ => None,
        };
        match self.lexemes[at].kind {
            LexemeKind::Comma | LexemeKind::Close(Bracket::Round | Bracket::Square) => false,
            LexemeKind::Close(Bracket::Curly) => opener != Some(Bracket::Curly),
            LexemeKind::Colon => self.is_schema_colon(at),
            LexemeKind::Mark if matches!(self.slice(at), ";" | "?") => false,
            LexemeKind::Operator if self.slice(at) == "." => false,
            _ if matches!(opener, Some(Bracket::Round | Bracket::Square)) => false,
            _ if self.slice(before) == "." => false,
            LexemeKind::Open(Bracket::Round) => !self.is_called(before),
            _ => true,
        }
    }

    /// Whether a `(` after it belongs to it: `sin(…)`.
    fn is_called(&self, at: usize) -> bool {
        match self.lexemes[at].kind {
            LexemeKind::Word => !self.is_opening_word(at),
            LexemeKind::Close(_) => true,
            _ => false,
        }
    }

    /// The colon of `schema raster : Path`, which names no value.
    fn is_schema_colon(&self, at: usize) -> bool {
        let Some(word) = at.checked_sub(2) else { return false };
        let first = if word > 0 && self.slice(word - 1) == "pub" { word - 1 } else { word };
        self.slice(word) == "schema" && self.places.begins_item[first]
    }
}
