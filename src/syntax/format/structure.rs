//! Structure: where entries begin, which bracket closes which, and what stands on several lines.
//!
//! In: lexemes, groups, atoms. Out: [`Places`], which follow from the text's meaning, and [`Shape`], which follows from
//! where its lines end.

use super::super::entries::{Group, Part};
use super::super::lexemes::{Bracket, Lexeme, LexemeKind};
use super::atoms::Atom;

/// What each lexeme is among the entries.
pub struct Places {
    /// Whether it is the first of an entry.
    pub begins_entry: Vec<bool>,
    /// Whether it is a comma between two entries, or after the last.
    pub separates: Vec<bool>,
    /// Whether it is the first of an item.
    pub begins_item: Vec<bool>,
}

/// What is to stand on several lines.
pub struct Shape {
    /// For an opening `{` or `[`: its content stands on lines of its own.
    pub broken: Vec<bool>,
    /// For the first lexeme of an entry: the entry takes several lines.
    pub spans_lines: Vec<bool>,
    /// For each atom: whether it stands between two entries or at the end of a group, not inside an entry.
    pub between: Vec<bool>,
}

/// Finds the places in a file without mistakes.
pub fn places(lexemes: &[Lexeme], groups: &[Group]) -> Places {
    let nowhere = vec![false; lexemes.len()];
    let mut places = Places { begins_entry: nowhere.clone(), separates: nowhere.clone(), begins_item: nowhere };
    for (index, group) in groups.iter().enumerate() {
        for entry in &group.entries {
            let first = match entry.parts.first() {
                Some(Part::Lexeme(at)) => *at,
                Some(Part::Group(inner)) => lexemes.partition_point(|lexeme| lexeme.start < groups[*inner].start),
                None => continue,
            };
            places.begins_entry[first] = true;
            places.begins_item[first] = index == 0;
        }
    }
    let mut open = Vec::new();
    for (at, lexeme) in lexemes.iter().enumerate() {
        match lexeme.kind {
            LexemeKind::Open(bracket) => open.push(bracket),
            LexemeKind::Close(_) => drop(open.pop()),
            LexemeKind::Comma => places.separates[at] = open.last() != Some(&Bracket::Round),
            _ => {}
        }
    }
    places
}

/// A bracket that waits for its closer, or the file.
struct Frame {
    opener: Option<usize>,
    round: bool,
    square: bool,
    /// A line ends in it, outside inner groups.
    newline: bool,
    /// A group in it takes several lines.
    inner: bool,
    entries: usize,
    comments: bool,
    /// First lexeme of the present entry.
    entry: Option<usize>,
}

impl Frame {
    fn new(opener: Option<usize>, bracket: Bracket) -> Frame {
        Frame {
            opener,
            round: bracket == Bracket::Round,
            square: bracket == Bracket::Square,
            newline: false,
            inner: false,
            entries: 0,
            comments: false,
            entry: None,
        }
    }
}

/// Finds what stands on several lines.
pub fn shape(lexemes: &[Lexeme], places: &Places, atoms: &[Atom<'_>]) -> Shape {
    let mut shape = Shape {
        broken: vec![false; lexemes.len()],
        spans_lines: vec![false; lexemes.len()],
        between: between(lexemes, places, atoms),
    };
    let mut frames = vec![Frame::new(None, Bracket::Curly)];
    for (i, atom) in atoms.iter().enumerate() {
        let entries = frames.iter_mut().rev().find(|frame| !frame.round);
        if let Some(frame) = entries {
            frame.comments |= atom.lexeme().is_none();
            frame.newline |= atom.newlines > 0;
            if atom.newlines > 0
                && !shape.between[i]
                && let Some(entry) = frame.entry
            {
                shape.spans_lines[entry] = true;
            }
        }
        let Some(at) = atom.lexeme() else { continue };
        if places.begins_entry[at]
            && let Some(frame) = frames.last_mut()
        {
            frame.entries += 1;
            frame.entry = Some(at);
        }
        match lexemes[at].kind {
            LexemeKind::Open(bracket) => frames.push(Frame::new(Some(at), bracket)),
            LexemeKind::Close(_) => {
                let Some(frame) = frames.pop() else { continue };
                close(&frame, &mut frames, &mut shape);
            }
            _ => {}
        }
    }
    shape
}

fn close(frame: &Frame, frames: &mut [Frame], shape: &mut Shape) {
    let Some(opener) = frame.opener.filter(|_| !frame.round) else { return };
    let empty = frame.entries == 0 && !frame.comments;
    // `[{` and `}]` hold a list of one record together.
    let hugs = frame.square && frame.entries == 1;
    shape.broken[opener] = !empty && (frame.newline || frame.inner && !hugs);
    if !empty
        && (frame.newline || frame.inner)
        && let Some(outer) = frames.iter_mut().rev().find(|outer| !outer.round)
    {
        outer.inner = true;
        if let Some(entry) = outer.entry {
            shape.spans_lines[entry] = true;
        }
    }
}

fn between(lexemes: &[Lexeme], places: &Places, atoms: &[Atom<'_>]) -> Vec<bool> {
    // What follows decides; after the last lexeme stands nothing but comments.
    let mut next = true;
    let mut between: Vec<bool> = atoms
        .iter()
        .rev()
        .map(|atom| {
            if let Some(at) = atom.lexeme() {
                let closes = matches!(lexemes[at].kind, LexemeKind::Close(Bracket::Curly | Bracket::Square));
                next = places.begins_entry[at] || places.separates[at] || closes;
            }
            next
        })
        .collect();
    between.reverse();
    between
}
