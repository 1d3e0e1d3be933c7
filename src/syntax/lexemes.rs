//! Lexemes: the tokens that mean something, each with where it stands in its line.
//!
//! In: the tokens of a file. Out: [`Lexeme`]s without blanks and comments, and the diagnostics about single tokens.
//! A token that is wrong but whose meaning is plain (`1.`, `−`, an unclosed text) is handed on mended, so that
//! nothing further is said about it.

use super::foreign::{self, QUOTES};
use super::tokens::{Token, TokenKind};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::{FileId, Span};

/// What a lexeme is, as far as finding the entries needs to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LexemeKind {
    Word,
    /// One of the reserved words, where it is not a name by its place (before a `:`, after a `.`).
    Keyword,
    Number,
    Text,
    Open(Bracket),
    Close(Bracket),
    Comma,
    Colon,
    /// An operator after which a newline does not end an entry.
    Operator,
    /// `?`, `%`, `;`.
    Mark,
    /// Was reported and takes no further part.
    Unknown,
}

/// The three kinds of brackets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bracket {
    Round,
    Square,
    Curly,
}

impl Bracket {
    /// The closing bracket as written.
    pub fn closer(self) -> &'static str {
        match self {
            Bracket::Round => ")",
            Bracket::Square => "]",
            Bracket::Curly => "}",
        }
    }
}

/// A token with its surroundings.
#[derive(Clone, Debug)]
pub struct Lexeme {
    pub kind: LexemeKind,
    pub start: u32,
    pub end: u32,
    /// Only blanks and comments stand before it on its line.
    pub begins_line: bool,
    /// The line's number, counted where only newlines outside comments count.
    pub line: u32,
    /// Bytes between the start of the line and the line's first lexeme.
    pub indent: u32,
    /// The `///` tokens before it: indices `start..end` into the file's doc comments.
    pub docs: (u32, u32),
    /// What is to be read in its place.
    pub mended: Option<String>,
    /// Its value cannot be known (an unclosed text, a number beyond all numbers); that was said.
    pub lost: bool,
}

/// The file as lexemes.
pub struct Lexed {
    pub lexemes: Vec<Lexeme>,
    /// The `///` tokens, in order.
    pub docs: Vec<Token>,
    /// An unclosed comment swallowed the rest of the file.
    pub cut_short: bool,
}

pub const KEYWORDS: [&str; 12] =
    ["and", "or", "not", "if", "then", "else", "for", "in", "with", "where", "usual", "because"];

/// Drops blanks and comments, and says what is wrong with single tokens.
pub fn lexemes(file: FileId, text: &str, tokens: &[Token], diagnostics: &mut Vec<Diagnostic>) -> Lexed {
    let mut lexed = Lexed { lexemes: Vec::new(), docs: Vec::new(), cut_short: false };
    let (mut line, mut line_start, mut indent, mut begins_line) = (0, 0, 0, true);
    let mut docs_from = 0;
    let mut foreign_line = None;
    let (mut open, mut read_up_to): (Vec<Bracket>, u32) = (Vec::new(), 0);
    for token in tokens {
        if token.start < read_up_to {
            continue;
        }
        let place = foreign::Place { file, text, before: &lexed.lexemes, inside: open.last().copied() };
        let mut token = *token;
        let mut known = None;
        if let Some(found) = foreign::foreign(&place, &token) {
            diagnostics.push(found.diagnostic);
            read_up_to = found.end;
            token.end = found.end;
            match found.read {
                Some((kind, mended)) => known = Some((kind, mended, found.lost)),
                None => continue,
            }
        }
        let token = &token;
        let slice = &text[token.start as usize..token.end as usize];
        let span = Span { file, start: token.start, end: token.end };
        let (mut mended, mut lost) = (None, false);
        let kind = match token.kind {
            _ if known.is_some() => {
                let (kind, writing, unknown) = known.unwrap_or((LexemeKind::Unknown, String::new(), true));
                (mended, lost) = (Some(writing), unknown);
                kind
            }
            TokenKind::Comment { closed: true } => {
                if let Some(diagnostic) = comment_in_unit(file, text, token, &lexed.lexemes) {
                    diagnostics.push(diagnostic);
                    // What the comment swallowed may have held anything.
                    lexed.lexemes.iter_mut().last().into_iter().for_each(|unit| unit.lost = true);
                }
                continue;
            }
            TokenKind::Blank => continue,
            TokenKind::Newline => {
                (line, line_start, begins_line) = (line + 1, token.end, true);
                continue;
            }
            TokenKind::Comment { closed: false } => {
                let opener = Span { end: span.start + 2, ..span };
                diagnostics.push(
                    Diagnostic::error(codes::E0105, opener, "this comment is never closed")
                        .label("the comment begins here")
                        .help("close it with `*/`; comments nest, so each `/*` needs its own"),
                );
                lexed.cut_short = true;
                continue;
            }
            TokenKind::Doc => {
                lexed.docs.push(*token);
                continue;
            }
            TokenKind::Number | TokenKind::BadNumber => {
                (mended, lost) = check_number(slice, span, diagnostics);
                LexemeKind::Number
            }
            TokenKind::Word => LexemeKind::Word,
            TokenKind::Text { closed } => {
                check_escapes(slice, span, diagnostics);
                if !closed {
                    let whole = slice.trim_end();
                    let end = span.start + whole.len() as u32;
                    let diagnostic = Diagnostic::error(codes::E0104, Span { end, ..span }, "this text is never closed")
                        .label("a text ends on its line")
                        .help("close it with `\"`");
                    // Where more may stand on the line than the text, nobody knows its end.
                    diagnostics.push(match whole.contains([',', '}', ')', ']', '{', '\\']) || whole.contains("//") {
                        true => diagnostic,
                        false => diagnostic.suggest(Span { start: end, end, ..span }, "\""),
                    });
                    (mended, lost) = (Some("\"\"".to_string()), true);
                }
                LexemeKind::Text
            }
            TokenKind::Punctuation => punctuation(slice),
            TokenKind::Unknown => {
                let plain = plain_writing(slice);
                // The second of two foreign quotes, say, belongs to the first.
                if plain.is_some() || foreign_line != Some(line) {
                    diagnostics.push(unknown(slice, span, plain));
                    foreign_line = if plain.is_some() { foreign_line } else { Some(line) };
                }
                mended = plain.map(str::to_string);
                plain.map_or(LexemeKind::Unknown, punctuation)
            }
        };
        match kind {
            LexemeKind::Open(bracket) => open.push(bracket),
            LexemeKind::Close(_) => drop(open.pop()),
            _ => {}
        }
        if begins_line {
            indent = token.start - line_start;
        }
        let docs = (docs_from, lexed.docs.len() as u32);
        docs_from = docs.1;
        let (start, end) = (token.start, token.end);
        lexed.lexemes.push(Lexeme { kind, start, end, begins_line, line, indent, docs, mended, lost });
        begins_line = false;
    }
    name_keywords(text, &mut lexed.lexemes);
    lexed
}

/// `50 mm//s`: a slash too many makes the rest of the line a comment. A comment that really stands so close to a unit is
/// asked to keep a blank.
fn comment_in_unit(file: FileId, text: &str, comment: &Token, before: &[Lexeme]) -> Option<Diagnostic> {
    let [.., number, unit] = before else { return None };
    let rest = text[comment.start as usize..].strip_prefix("//")?;
    let close = unit.end == comment.start && rest.starts_with(char::is_alphabetic);
    if !close || unit.kind != LexemeKind::Word || number.kind != LexemeKind::Number || number.line != unit.line {
        return None;
    }
    let place = Span { file, start: comment.start, end: comment.start + 2 };
    Some(
        Diagnostic::error(codes::E0113, place, "`//` right after a unit begins a comment")
            .help("write one `/`, or a blank before the comment")
            .suggest(place, "/"),
    )
}

/// A reserved word is a keyword unless a `:` follows on its line or a `.` stands before it.
fn name_keywords(text: &str, lexemes: &mut [Lexeme]) {
    for i in 0..lexemes.len() {
        let slice = &text[lexemes[i].start as usize..lexemes[i].end as usize];
        if lexemes[i].kind != LexemeKind::Word || !KEYWORDS.contains(&slice) {
            continue;
        }
        let colon =
            lexemes.get(i + 1).is_some_and(|next| next.kind == LexemeKind::Colon && next.line == lexemes[i].line);
        let dot = i > 0 && lexemes[i - 1].kind == LexemeKind::Operator && {
            let before = &lexemes[i - 1];
            &text[before.start as usize..before.end as usize] == "."
        };
        if !colon && !dot {
            lexemes[i].kind = LexemeKind::Keyword;
        }
    }
}

fn punctuation(slice: &str) -> LexemeKind {
    match slice {
        "(" => LexemeKind::Open(Bracket::Round),
        "[" => LexemeKind::Open(Bracket::Square),
        "{" => LexemeKind::Open(Bracket::Curly),
        ")" => LexemeKind::Close(Bracket::Round),
        "]" => LexemeKind::Close(Bracket::Square),
        "}" => LexemeKind::Close(Bracket::Curly),
        "," => LexemeKind::Comma,
        ":" => LexemeKind::Colon,
        "?" | "%" | ";" => LexemeKind::Mark,
        _ => LexemeKind::Operator,
    }
}

/// Characters that come with text copied from a paper or a word processor, and the plain writing of each.
fn plain_writing(slice: &str) -> Option<&'static str> {
    Some(match slice {
        "−" | "–" | "—" => "-",
        "×" | "·" | "⋅" => "*",
        "÷" => "/",
        "≤" => "<=",
        "≥" => ">=",
        "≠" => "!=",
        "…" => "..",
        _ => return None,
    })
}

fn unknown(slice: &str, span: Span, plain: Option<&'static str>) -> Diagnostic {
    // A run of a thousand stray bytes is one mistake; its beginning is enough to recognise it.
    let mut shown: String = slice.chars().take(8).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if shown.len() < slice.len() && slice.chars().count() > 8 {
        shown.push('…');
    }
    let diagnostic = Diagnostic::error(codes::E0101, span, format!("`{shown}` has no meaning in this language"));
    match (plain, slice) {
        (Some(plain), _) => diagnostic.help(format!("write `{plain}`")).suggest(span, plain),
        (None, s) if s.contains(QUOTES) => diagnostic.help("a text stands between straight double quotes: `\"…\"`"),
        (None, "°") => diagnostic.help("a difference of temperature is in `K`: `20 K`"),
        (None, s) if s.starts_with('&') => diagnostic.help("write `and`"),
        (None, s) if s.contains('±') => diagnostic.help("write both ends of a range: `a .. b`"),
        _ => diagnostic,
    }
}

/// What to read in place of a number that is not well written, and whether its value is lost.
fn check_number(slice: &str, span: Span, diagnostics: &mut Vec<Diagnostic>) -> (Option<String>, bool) {
    let plain: String = slice.chars().filter(|&c| c != '_').collect();
    let (mantissa, exponent) = match plain.find(['e', 'E']) {
        Some(i) => plain.split_at(i),
        None => (plain.as_str(), ""),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, "0"));
    let zero = |digits: &str| if digits.is_empty() { "0".to_string() } else { digits.to_string() };
    if fraction.contains('.') {
        diagnostics.push(
            Diagnostic::error(codes::E0112, span, format!("`{slice}` is not a number"))
                .label("more than one decimal point")
                .help("write a version or a date as text, between quotes"),
        );
        return (Some("0".to_string()), true);
    }
    let mended = match mantissa.contains('.') {
        true => format!("{}.{}{exponent}", zero(whole), zero(fraction)),
        false => plain.clone(),
    };
    let value = mended.parse::<f64>().unwrap_or(f64::INFINITY);
    let is_zero = !mantissa.contains(|c: char| c.is_ascii_digit() && c != '0');
    if value.is_infinite() || (value == 0.0 && !is_zero) {
        let extreme = if value.is_infinite() { "large" } else { "small" };
        diagnostics.push(
            Diagnostic::error(codes::E0112, span, format!("this number is too {extreme}"))
                .note("numbers lie between about 1e-308 and 1e308"),
        );
        return (Some("0".to_string()), true);
    }
    if mended == slice {
        return (None, false);
    }
    diagnostics.push(
        Diagnostic::error(codes::E0112, span, format!("`{slice}` is not how a number is written"))
            .note("a number has digits on both sides of its point, and nothing but digits")
            .help(format!("write `{mended}`"))
            .suggest(span, mended.clone()),
    );
    (Some(mended), false)
}

fn check_escapes(slice: &str, span: Span, diagnostics: &mut Vec<Diagnostic>) {
    let mut chars = slice.char_indices();
    while let Some((i, c)) = chars.next() {
        if c != '\\' {
            continue;
        }
        let Some((_, escaped)) = chars.next() else { return };
        if matches!(escaped, '"' | '\\' | 'n') {
            continue;
        }
        let place =
            Span { start: span.start + i as u32, end: span.start + (i + 1 + escaped.len_utf8()) as u32, ..span };
        diagnostics.push(
            Diagnostic::error(codes::E0116, place, format!("`\\{escaped}` is not an escape"))
                .note("the escapes are `\\\"`, `\\\\` and `\\n`; paths are written with `/`")
                .help("write `\\\\` for a backslash")
                .suggest(place, format!("\\\\{escaped}")),
        );
    }
}

/// The content of a text as written, with its escapes worked out.
pub fn unescape(written: &str) -> String {
    let inner = written.strip_prefix('"').unwrap_or(written);
    let inner = inner.strip_suffix('"').unwrap_or(inner);
    let mut content = String::with_capacity(inner.len());
    let mut chars = inner.chars();
    while let Some(c) = chars.next() {
        match c {
            '\\' => match chars.next() {
                Some('n') => content.push('\n'),
                Some(other @ ('"' | '\\')) => content.push(other),
                Some(other) => content.extend(['\\', other]),
                None => content.push('\\'),
            },
            _ => content.push(c),
        }
    }
    content
}
