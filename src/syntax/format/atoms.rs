//! Atoms: all that is to be written again, with the blanks that stood before it.
//!
//! In: the tokens. Out: lexemes and comments in one row.

use super::super::tokens::{Token, TokenKind};
use super::spacing::Gap;

/// A lexeme or a comment.
#[derive(Clone, Copy, Debug)]
pub struct Atom<'a> {
    pub text: &'a str,
    pub kind: AtomKind,
    /// Line ends between the atom before and this one.
    pub newlines: usize,
    /// Characters of blanks right before it, on its line.
    pub blanks: usize,
    /// Characters before it on its line.
    pub column: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtomKind {
    /// Its index among the lexemes.
    Lexeme(usize),
    /// `// …` or `/* … */`.
    Comment,
    /// `/// …`.
    Doc,
}

impl Atom<'_> {
    /// Whether nothing more can stand on its line.
    pub fn ends_line(&self) -> bool {
        self.kind != AtomKind::Comment && self.lexeme().is_none() || self.is_line_comment()
    }

    fn is_line_comment(&self) -> bool {
        self.kind == AtomKind::Comment && self.text.starts_with("//")
    }

    /// The index of the lexeme, if it is one.
    pub fn lexeme(&self) -> Option<usize> {
        match self.kind {
            AtomKind::Lexeme(at) => Some(at),
            _ => None,
        }
    }
}

/// All atoms of a file without mistakes, in which every other token is a lexeme.
pub fn atoms<'a>(text: &'a str, tokens: &[Token]) -> Vec<Atom<'a>> {
    let mut atoms = Vec::new();
    let (mut newlines, mut blanks, mut column, mut lexemes) = (0, 0, 0, 0);
    for token in tokens {
        let slice = &text[token.start as usize..token.end as usize];
        let kind = match token.kind {
            TokenKind::Newline => {
                (newlines, blanks, column) = (newlines + 1, 0, 0);
                continue;
            }
            TokenKind::Blank => {
                blanks = slice.chars().count();
                column += blanks;
                continue;
            }
            TokenKind::Comment { .. } => AtomKind::Comment,
            TokenKind::Doc => AtomKind::Doc,
            _ => {
                lexemes += 1;
                AtomKind::Lexeme(lexemes - 1)
            }
        };
        // Blanks at the end of a line comment are no part of it.
        let shown = if slice.starts_with("//") { slice.trim_end() } else { slice };
        atoms.push(Atom { text: shown, kind, newlines, blanks, column });
        (newlines, blanks) = (0, 0);
        column = match slice.rsplit_once('\n') {
            Some((_, last)) => last.chars().count(),
            None => column + slice.chars().count(),
        };
    }
    atoms
}

/// `- /* why */ 2` becomes `/* why */ -2`: a minus sign with a blank after it may not begin a line of a list.
pub fn put_comments_before_minus(atoms: &mut [Atom<'_>], gaps: &[Gap]) {
    for i in 1..atoms.len() {
        let minus = atoms[i - 1];
        let unary = minus.lexeme().is_some_and(|at| gaps[at].is_sign);
        if unary && atoms[i].kind == AtomKind::Comment && !atoms[i].ends_line() && atoms[i].newlines == 0 {
            let Atom { newlines, blanks, column, .. } = minus;
            atoms[i - 1] = Atom { newlines, blanks, column, ..atoms[i] };
            atoms[i] = Atom { newlines: 0, blanks: 1, ..minus };
        }
    }
}
