//! Tokens: the text cut up, nothing lost.
//!
//! In: any text. Out: tokens whose slices, put one after the other, are the text again. There is one rule for every
//! byte, so this never fails: what belongs to no other kind is [`TokenKind::Unknown`], and what is not finished (a text,
//! a comment) says so. The formatter and the editor need this losslessness; the parser drops the blanks.

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TokenKind {
    /// Blanks within a line, a lone carriage return, and the byte order mark at the start of a file.
    Blank,
    /// One end of line, `\n` or `\r\n`.
    Newline,
    /// `// …` and `//// …` up to the end of the line, or a nesting `/* … */`.
    Comment { closed: bool },
    /// `/// …` up to the end of the line.
    Doc,
    /// `12`, `0.5`, `1e-10`.
    Number,
    /// `1.`, `.5`, `1_000`, `1.2.3`: meant as a number, but not one.
    BadNumber,
    /// A letter or `_`, then letters, digits and `_`. Letters of all scripts, for `µm`, `λ` and `Å`.
    Word,
    /// `"…"` on one line.
    Text { closed: bool },
    /// A bracket, a comma, an operator.
    Punctuation,
    /// Neighbouring characters that the language has no use for.
    Unknown,
}

/// A token: its kind and its bytes `start..end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token {
    pub kind: TokenKind,
    pub start: u32,
    pub end: u32,
}

/// Cuts `text` up.
pub fn tokenize(text: &str) -> Vec<Token> {
    let mut tokens: Vec<Token> = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let (kind, length) = next_token(&text[at..], first, at, tokens.last());
        let (start, end) = (at as u32, (at + length) as u32);
        at += length;
        if let (TokenKind::Unknown, Some(last)) = (kind, tokens.last_mut())
            && last.kind == TokenKind::Unknown
        {
            last.end = end;
            continue;
        }
        tokens.push(Token { kind, start, end });
    }
    tokens
}

/// Whether a word can begin with it.
pub fn begins_word(c: char) -> bool {
    c == '_' || c.is_alphabetic()
}

/// Whether a word can go on with it.
pub fn continues_word(c: char) -> bool {
    begins_word(c) || c.is_ascii_digit()
}

/// The two-character operators; `->` belongs to functions and is kept whole so that it is named whole.
const PAIRS: [&str; 6] = ["..", "<=", ">=", "==", "!=", "->"];

fn next_token(rest: &str, first: char, at: usize, last: Option<&Token>) -> (TokenKind, usize) {
    match first {
        '\n' => (TokenKind::Newline, 1),
        '\r' if rest.starts_with("\r\n") => (TokenKind::Newline, 2),
        '\u{feff}' if at == 0 => (TokenKind::Blank, first.len_utf8()),
        c if is_blank(rest, c) => {
            let length = rest.char_indices().find(|&(i, c)| !is_blank(&rest[i..], c)).map_or(rest.len(), |(i, _)| i);
            (TokenKind::Blank, length)
        }
        '/' if rest.starts_with("//") => {
            let line = rest.split('\n').next().unwrap_or(rest);
            let line = line.strip_suffix('\r').unwrap_or(line);
            let doc = line.starts_with("///") && !line.starts_with("////");
            (if doc { TokenKind::Doc } else { TokenKind::Comment { closed: true } }, line.len())
        }
        '/' if rest.starts_with("/*") => block_comment(rest),
        '"' => text_literal(rest),
        '0'..='9' => number(rest),
        '.' if rest[1..].starts_with(|c: char| c.is_ascii_digit()) && !follows_operand(at, last) => {
            (TokenKind::BadNumber, number(rest).1)
        }
        c if begins_word(c) => (TokenKind::Word, rest.find(|c| !continues_word(c)).unwrap_or(rest.len())),
        _ if PAIRS.iter().any(|pair| rest.starts_with(pair)) => (TokenKind::Punctuation, 2),
        '(' | ')' | '[' | ']' | '{' | '}' | ',' | ':' | ';' | '=' | '+' | '-' | '*' | '/' | '^' | '<' | '>' | '|'
        | '.' | '?' | '%' => (TokenKind::Punctuation, 1),
        c => (TokenKind::Unknown, c.len_utf8()),
    }
}

fn is_blank(rest: &str, c: char) -> bool {
    c != '\n' && c.is_whitespace() && !rest.starts_with("\r\n")
}

/// Whether a `.` at `at` would take a field of what stands right before it.
fn follows_operand(at: usize, last: Option<&Token>) -> bool {
    last.is_some_and(|token| {
        token.end as usize == at && matches!(token.kind, TokenKind::Word | TokenKind::Number | TokenKind::BadNumber)
    })
}

/// The nesting is counted in a loop, so that no text can exhaust the stack.
fn block_comment(rest: &str) -> (TokenKind, usize) {
    let bytes = rest.as_bytes();
    let mut depth = 0usize;
    let mut at = 0;
    while at < bytes.len() {
        match bytes.get(at..at + 2) {
            Some(b"/*") => {
                depth += 1;
                at += 2;
            }
            Some(b"*/") => {
                depth -= 1;
                at += 2;
                if depth == 0 {
                    return (TokenKind::Comment { closed: true }, at);
                }
            }
            _ => at += 1,
        }
    }
    (TokenKind::Comment { closed: false }, rest.len())
}

fn text_literal(rest: &str) -> (TokenKind, usize) {
    let bytes = rest.as_bytes();
    let mut at = 1;
    while at < bytes.len() {
        match bytes[at] {
            b'"' => return (TokenKind::Text { closed: true }, at + 1),
            b'\n' => break,
            b'\r' if bytes.get(at + 1) == Some(&b'\n') => break,
            // The escaped byte may be the first of several: the others are then ordinary content.
            b'\\' if !matches!(bytes.get(at + 1), None | Some(b'\n' | b'\r')) => at += 2,
            _ => at += 1,
        }
    }
    // Stepping over an escape may have ended inside a character; a text goes on to the end of its line in any case.
    while !rest.is_char_boundary(at) {
        at += 1;
    }
    (TokenKind::Text { closed: false }, at)
}

fn number(rest: &str) -> (TokenKind, usize) {
    let bytes = rest.as_bytes();
    let digits = |mut at: usize| {
        let from = at;
        let mut underscored = false;
        while let Some(b) = bytes.get(at) {
            match b {
                b'0'..=b'9' => at += 1,
                b'_' if at > from && bytes.get(at + 1).is_some_and(u8::is_ascii_digit) => {
                    underscored = true;
                    at += 1;
                }
                _ => break,
            }
        }
        (at, underscored)
    };
    let (mut at, mut bad) = digits(0);
    bad |= at == 0;
    let mut fractions = 0;
    // `1..2` is a range; `1.x` is a number and a field, which the grammar refuses.
    while bytes.get(at) == Some(&b'.') && bytes.get(at + 1) != Some(&b'.') {
        if rest[at + 1..].starts_with(|c: char| begins_word(c) && !starts_exponent(&rest[at + 1..])) {
            break;
        }
        let (end, underscored) = digits(at + 1);
        bad |= underscored || end == at + 1 || fractions == 1;
        fractions += 1;
        at = end;
    }
    if starts_exponent(&rest[at..]) {
        let sign = usize::from(matches!(bytes.get(at + 1), Some(b'+' | b'-')));
        let (end, underscored) = digits(at + 1 + sign);
        bad |= underscored;
        at = end;
    }
    (if bad { TokenKind::BadNumber } else { TokenKind::Number }, at)
}

/// `e` or `E`, perhaps a sign, and a digit.
fn starts_exponent(rest: &str) -> bool {
    let Some(rest) = rest.strip_prefix(['e', 'E']) else { return false };
    rest.strip_prefix(['+', '-']).unwrap_or(rest).starts_with(|c: char| c.is_ascii_digit())
}
