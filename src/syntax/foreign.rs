//! Foreign writings: signs of other languages and of word processors whose meaning is plain.
//!
//! In: a token, and what stands before it. Out: how far the writing reaches, what is read in its place, and what is said,
//! with the mend. It is read as it was meant, so that one slip is one diagnostic.

use super::lexemes::{Bracket, Lexeme, LexemeKind};
use super::tokens::{Token, TokenKind};
use crate::diagnostics::{Diagnostic, codes};
use crate::source::{FileId, Span};

/// A foreign writing.
pub struct Foreign {
    /// Where it ends.
    pub end: u32,
    /// What is read; `None` for what is read as a blank.
    pub read: Option<(LexemeKind, String)>,
    /// Its value cannot be known.
    pub lost: bool,
    pub diagnostic: Diagnostic,
}

/// Quotes of word processors and of other languages.
pub const QUOTES: [char; 9] = ['“', '”', '„', '«', '»', '‘', '’', '\'', '`'];

/// Operators of other languages and ours. Blanks keep a word apart from its neighbours.
const OPERATORS: [(&str, &str, LexemeKind); 9] = [
    ("&&", " and ", LexemeKind::Keyword),
    ("||", " or ", LexemeKind::Keyword),
    ("!==", "!=", LexemeKind::Operator),
    ("!", " not ", LexemeKind::Keyword),
    ("**", "^", LexemeKind::Operator),
    ("===", "==", LexemeKind::Operator),
    ("=<", "<=", LexemeKind::Operator),
    ("<>", "!=", LexemeKind::Operator),
    ("...", "..", LexemeKind::Operator),
];

/// Where a token is met.
pub struct Place<'a> {
    pub file: FileId,
    pub text: &'a str,
    /// The lexemes before it.
    pub before: &'a [Lexeme],
    /// The innermost open bracket.
    pub inside: Option<Bracket>,
}

/// The foreign writing that begins with this token, if one does.
pub fn foreign(place: &Place<'_>, token: &Token) -> Option<Foreign> {
    match token.kind {
        TokenKind::Number => decimal_comma(place, token),
        TokenKind::Punctuation => operator(place, token).or_else(|| walrus(place, token)),
        TokenKind::Unknown => operator(place, token)
            .or_else(|| temperature(place, token))
            .or_else(|| hash(place, token))
            .or_else(|| quoted(place, token))
            .or_else(|| sign_of_angle(place, token))
            .or_else(|| superscript(place, token))
            .or_else(|| invisible(place, token)),
        _ => None,
    }
}

impl Place<'_> {
    fn slice(&self, token: &Token) -> &str {
        &self.text[token.start as usize..token.end as usize]
    }

    fn rest(&self, token: &Token) -> &str {
        &self.text[token.start as usize..]
    }

    fn span(&self, start: u32, end: u32) -> Span {
        Span { file: self.file, start, end }
    }

    /// `what` of `length` bytes read as `ours`.
    fn read(&self, token: &Token, length: usize, ours: &str, kind: LexemeKind) -> Foreign {
        let end = token.start + length as u32;
        let span = self.span(token.start, end);
        let (written, plain) = (&self.text[token.start as usize..end as usize], ours.trim());
        let diagnostic = Diagnostic::error(codes::E0101, span, format!("`{written}` has no meaning in this language"))
            .help(format!("write `{plain}`"))
            .suggest(span, self.apart(span, ours));
        Foreign { end, read: Some((kind, ours.to_string())), lost: false, diagnostic }
    }

    /// A word that replaces a sign is kept apart from words beside it.
    fn apart(&self, span: Span, ours: &str) -> String {
        if ours.trim() == ours {
            return ours.to_string();
        }
        let before = self.text[..span.start as usize].chars().next_back().is_none_or(char::is_whitespace);
        let after = self.text[span.end as usize..].chars().next().is_none_or(char::is_whitespace);
        format!("{}{}{}", if before { "" } else { " " }, ours.trim(), if after { "" } else { " " })
    }
}

fn operator(place: &Place<'_>, token: &Token) -> Option<Foreign> {
    let rest = place.rest(token);
    let (written, ours, kind) = OPERATORS.into_iter().find(|(written, _, _)| rest.starts_with(written))?;
    // A run of unknown characters is one token; a part of it is nothing that we know. Nor is `!` in our own `!=`.
    if token.end - token.start > written.len() as u32 {
        return None;
    }
    // `...5` is `..` and `.5`.
    if written == "..." && rest[3..].starts_with(|c: char| c.is_ascii_digit()) {
        return None;
    }
    Some(place.read(token, written.len(), ours, kind))
}

/// `:=` sets a field in a record and a value elsewhere.
fn walrus(place: &Place<'_>, token: &Token) -> Option<Foreign> {
    if !place.rest(token).starts_with(":=") {
        return None;
    }
    let (ours, kind) = match place.inside {
        Some(Bracket::Curly) => (":", LexemeKind::Colon),
        _ => ("=", LexemeKind::Operator),
    };
    Some(place.read(token, 2, ours, kind))
}

/// `# a comment`.
fn hash(place: &Place<'_>, token: &Token) -> Option<Foreign> {
    if !place.slice(token).starts_with('#') {
        return None;
    }
    let line = place.rest(token).split('\n').next().unwrap_or("");
    let marks = line.len() - line.trim_start_matches('#').len();
    let span = place.span(token.start, token.start + marks as u32);
    let diagnostic = Diagnostic::error(codes::E0101, span, "a comment does not begin with `#`")
        .help("write `//`")
        .suggest(span, "//");
    Some(Foreign { end: token.start + line.len() as u32, read: None, lost: false, diagnostic })
}

/// `'text'`, `“text”`.
fn quoted(place: &Place<'_>, token: &Token) -> Option<Foreign> {
    let slice = place.slice(token);
    let mut letters = slice.chars();
    if !letters.next().is_some_and(|c| QUOTES.contains(&c)) || letters.next().is_some() {
        return None;
    }
    let line = place.text[token.end as usize..].lines().next().unwrap_or("");
    let (at, quote) = line.char_indices().find(|(_, c)| QUOTES.contains(c))?;
    let inner = &line[..at];
    if inner.contains('"') {
        return None;
    }
    let closing = place.span(token.end + at as u32, token.end + (at + quote.len_utf8()) as u32);
    let opening = place.span(token.start, token.end);
    let diagnostic = Diagnostic::error(codes::E0101, opening, format!("a text does not stand between `{slice}`"))
        .help("a text stands between straight double quotes: `\"…\"`")
        .suggest(opening, "\"")
        .suggest(closing, "\"");
    let read = Some((LexemeKind::Text, format!("\"{inner}\"")));
    Some(Foreign { end: closing.end, read, lost: false, diagnostic })
}

/// `45°`.
fn sign_of_angle(place: &Place<'_>, token: &Token) -> Option<Foreign> {
    let ours = match place.slice(token) {
        "°" => "deg",
        "′" => "arcmin",
        "″" => "arcsec",
        _ => return None,
    };
    // `20 °C` is no angle.
    if place.text[token.end as usize..].starts_with(char::is_alphabetic) {
        return None;
    }
    let length = (token.end - token.start) as usize;
    let mut found = place.read(token, length, ours, LexemeKind::Word);
    let close = place.before.last().is_some_and(|last| last.end == token.start && last.kind == LexemeKind::Number);
    if let (true, Some(mend)) = (close, found.diagnostic.suggestions.first_mut()) {
        mend.replacement = format!(" {ours}");
    }
    Some(found)
}

/// `20 °C`: nothing is computed with temperatures, only with their differences.
fn temperature(place: &Place<'_>, token: &Token) -> Option<Foreign> {
    let rest = place.rest(token).strip_prefix('°')?;
    let scale = rest.chars().next().filter(|c| matches!(c, 'C' | 'F'))?;
    if rest[1..].starts_with(super::tokens::continues_word) {
        return None;
    }
    let span = place.span(token.start, token.end + 1);
    let diagnostic = Diagnostic::error(codes::E0101, span, format!("`°{scale}` is no unit of this language"))
        .help("a difference of temperature is in `K`: `20 K`");
    Some(Foreign { end: span.end, read: Some((LexemeKind::Word, "K".into())), lost: false, diagnostic })
}

/// `mm²`, `s⁻¹`.
fn superscript(place: &Place<'_>, token: &Token) -> Option<Foreign> {
    let plain = |c: char| match c {
        '⁻' => Some('-'),
        '⁰' => Some('0'),
        '¹' => Some('1'),
        '²' => Some('2'),
        '³' => Some('3'),
        '⁴'..='⁹' => char::from_digit(c as u32 - '⁰' as u32, 10),
        _ => None,
    };
    let power: String = place.slice(token).chars().map(plain).collect::<Option<String>>()?;
    Some(place.read(token, (token.end - token.start) as usize, &format!("^{power}"), LexemeKind::Mark))
}

/// Characters that nobody sees, from a word processor or a web page.
fn invisible(place: &Place<'_>, token: &Token) -> Option<Foreign> {
    let hidden = |c: char| matches!(c, '\u{200b}'..='\u{200f}' | '\u{2060}' | '\u{feff}' | '\u{ad}');
    let slice = place.slice(token);
    let first = slice.chars().next().filter(|_| slice.chars().all(hidden))?;
    let span = place.span(token.start, token.end);
    let message = format!("an invisible character, U+{:04X}, stands here", u32::from(first));
    let diagnostic = Diagnostic::error(codes::E0101, span, message).help("delete it").suggest(span, "");
    Some(Foreign { end: token.end, read: None, lost: false, diagnostic })
}

/// `0,5 mm`, `1,000 nm`. In a list a comma separates elements, and in `( )` arguments.
fn decimal_comma(place: &Place<'_>, token: &Token) -> Option<Foreign> {
    if matches!(place.inside, Some(Bracket::Square | Bracket::Round)) || place.slice(token).contains(['.', 'e', 'E']) {
        return None;
    }
    let rest = place.rest(token);
    let length = rest.find(|c: char| !c.is_ascii_digit() && c != ',').unwrap_or(rest.len());
    let written = rest[..length].trim_end_matches(',');
    let groups: Vec<&str> = written.split(',').collect();
    if groups.len() < 2 || groups.iter().any(|group| group.is_empty()) {
        return None;
    }
    let span = place.span(token.start, token.start + written.len() as u32);
    let diagnostic = Diagnostic::error(codes::E0112, span, format!("`{written}` is not how a number is written"))
        .note("a decimal point is `.`, and nothing stands between the thousands");
    let whole = groups.concat();
    let (mended, diagnostic) = match groups.as_slice() {
        // Three digits: a fraction or thousands, nobody knows.
        [above, below] if below.len() == 3 && *above != "0" => {
            (None, diagnostic.help(format!("write `{above}.{below}` or `{whole}`")))
        }
        [above, below] => {
            let mended = format!("{above}.{below}");
            (Some(mended.clone()), diagnostic.help(format!("write `{mended}`")).suggest(span, mended))
        }
        _ => (Some(whole.clone()), diagnostic.help(format!("write `{whole}`")).suggest(span, whole)),
    };
    let lost = mended.is_none();
    Some(Foreign { end: span.end, read: Some((LexemeKind::Number, mended.unwrap_or("0".into()))), lost, diagnostic })
}
