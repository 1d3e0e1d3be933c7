//! Tokens of KRL text.
//!
//! In: the bytes of a file. Out: tokens one after the other, each with its line. The end of a line is a token, because it
//! ends a statement. The text must be plain ASCII, also in comments; line ends may be CRLF or LF, a lone CR is refused:
//! some readers end a line there, and with it a comment, where others go on.

/// A token. Words and texts are slices of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Token<'a> {
    /// An identifier or keyword, as written; a system variable with its `$`.
    Word(&'a str),
    Number(f64),
    /// The inside of a text in quotes.
    Text(&'a str),
    /// One of `( ) [ ] { } , : . # + - * / = < > == <> <= >= &`.
    Symbol(&'static str),
    EndOfLine,
    End,
}

/// What is wrong, and on which line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    pub line: u32,
    pub message: String,
}

/// Reads tokens; a copy of it is a place to go back to.
#[derive(Clone, Copy, Debug)]
pub struct Lexer<'a> {
    bytes: &'a [u8],
    at: usize,
    line: u32,
}

impl<'a> Lexer<'a> {
    /// Starts at the first byte, on line 1.
    pub fn new(bytes: &'a [u8]) -> Lexer<'a> {
        Lexer { bytes, at: 0, line: 1 }
    }

    /// The line of the place reached.
    pub fn line(&self) -> u32 {
        self.line
    }

    fn byte(&self, ahead: usize) -> u8 {
        // 0 stands for the end; a zero byte in the text is refused wherever it could be met.
        self.bytes.get(self.at + ahead).copied().unwrap_or(0)
    }

    fn fault<T>(&self, message: impl Into<String>) -> Result<T, Fault> {
        Err(Fault { line: self.line, message: message.into() })
    }

    /// Skips blanks and a comment; the byte where the next token begins (`\n` at the end of a line), or 0 at the end.
    #[inline]
    pub fn skip(&mut self) -> Result<u8, Fault> {
        loop {
            match self.bytes.get(self.at) {
                Some(b' ' | b'\t') => self.at += 1,
                Some(b'\r') => {
                    if self.byte(1) != b'\n' {
                        return self.fault("a carriage return stands in the text without a line feed behind it");
                    }
                    self.at += 1;
                }
                Some(b';') => self.comment()?,
                Some(0) => return self.fault("a zero byte stands in the text"),
                Some(byte) => return Ok(*byte),
                None => return Ok(0),
            }
        }
    }

    fn comment(&mut self) -> Result<(), Fault> {
        while let Some(byte) = self.bytes.get(self.at) {
            match byte {
                b'\n' | b'\r' => return Ok(()),
                b' '..=b'~' | b'\t' => self.at += 1,
                _ => return self.fault("a character that is not plain ASCII stands in a comment"),
            }
        }
        Ok(())
    }

    /// Skips the rest of the line, which must be plain ASCII: the head of a file is for its manager.
    pub fn skip_line(&mut self) -> Result<(), Fault> {
        self.comment()
    }

    /// Takes the byte `symbol` if it comes next: the short way through targets.
    #[inline]
    pub fn take(&mut self, symbol: u8) -> Result<bool, Fault> {
        let found = self.skip()? == symbol;
        self.at += usize::from(found);
        Ok(found)
    }

    /// Takes a number with its sign if one comes next.
    #[inline]
    pub fn take_number(&mut self) -> Result<Option<f64>, Fault> {
        let mut byte = self.skip()?;
        let before = *self;
        let negative = byte == b'-';
        if negative || byte == b'+' {
            self.at += 1;
            byte = self.skip()?;
        }
        if !(byte.is_ascii_digit() || byte == b'.' && self.byte(1).is_ascii_digit()) {
            *self = before;
            return Ok(None);
        }
        let value = self.number()?;
        Ok(Some(if negative { -value } else { value }))
    }

    /// The next token.
    pub fn next_token(&mut self) -> Result<Token<'a>, Fault> {
        let byte = self.skip()?;
        if byte == 0 {
            return Ok(Token::End);
        }
        if byte == b'\n' {
            self.at += 1;
            self.line += 1;
            return Ok(Token::EndOfLine);
        }
        if byte.is_ascii_alphabetic() || byte == b'$' || byte == b'_' {
            return Ok(Token::Word(self.word()));
        }
        if byte.is_ascii_digit() || (byte == b'.' && self.byte(1).is_ascii_digit()) {
            return self.number().map(Token::Number);
        }
        if byte == b'"' {
            return self.text();
        }
        let two = match (byte, self.byte(1)) {
            (b'=', b'=') => Some("=="),
            (b'<', b'>') => Some("<>"),
            (b'<', b'=') => Some("<="),
            (b'>', b'=') => Some(">="),
            _ => None,
        };
        if let Some(symbol) = two {
            self.at += 2;
            return Ok(Token::Symbol(symbol));
        }
        const ONE: &[&str] =
            &["(", ")", "[", "]", "{", "}", ",", ":", ".", "#", "+", "-", "*", "/", "=", "<", ">", "&"];
        match ONE.iter().find(|symbol| symbol.as_bytes() == [byte]) {
            Some(symbol) => {
                self.at += 1;
                Ok(Token::Symbol(symbol))
            }
            None => {
                self.fault(format!("the character `{}` has no place in a program", char::from(byte).escape_default()))
            }
        }
    }

    /// The word at the place reached; the byte there is a letter, `$` or `_`.
    #[inline]
    pub fn word(&mut self) -> &'a str {
        let start = self.at;
        while self.byte(0).is_ascii_alphanumeric() || matches!(self.byte(0), b'_' | b'$') {
            self.at += 1;
        }
        slice(self.bytes, start, self.at)
    }

    fn text(&mut self) -> Result<Token<'a>, Fault> {
        self.at += 1;
        let start = self.at;
        loop {
            match self.byte(0) {
                b'"' => break,
                b' '..=b'~' => self.at += 1,
                _ => return self.fault("a text in quotes is not closed on its line, or holds what is not plain ASCII"),
            }
        }
        self.at += 1;
        Ok(Token::Text(slice(self.bytes, start, self.at - 1)))
    }

    /// A number at the place reached, without sign: `12`, `12.5`, `12.`, `.5`, `1E-3`, `1.2e+09`.
    fn number(&mut self) -> Result<f64, Fault> {
        // Powers of ten that are exact in f64: with at most 2^53 before them, one division rounds once.
        const POWERS: [f64; 23] = [
            1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
            1e19, 1e20, 1e21, 1e22,
        ];
        let start = self.at;
        let (mut digits, mut count, mut exponent, mut point) = (0_u64, 0, 0_i32, false);
        loop {
            let byte = self.byte(0);
            if byte.is_ascii_digit() {
                digits = digits.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                count += 1;
                exponent -= i32::from(point);
            } else if byte == b'.' && !point {
                point = true;
            } else {
                break;
            }
            self.at += 1;
        }
        if matches!(self.byte(0), b'E' | b'e') {
            self.at += 1;
            let negative = self.byte(0) == b'-';
            if matches!(self.byte(0), b'+' | b'-') {
                self.at += 1;
            }
            if !self.byte(0).is_ascii_digit() {
                return self.fault("a number ends after its `E`");
            }
            let mut given: i32 = 0;
            while self.byte(0).is_ascii_digit() {
                given = given.saturating_mul(10).saturating_add(i32::from(self.byte(0) - b'0'));
                self.at += 1;
            }
            exponent = exponent.saturating_add(if negative { -given } else { given });
        }
        if self.byte(0).is_ascii_alphanumeric() || matches!(self.byte(0), b'_' | b'.' | b'$') {
            return self.fault("a number runs into a word; this compiler reads decimal numbers only");
        }
        // 15 digits always fit 2^53.
        if count <= 15 && exponent.unsigned_abs() < POWERS.len() as u32 {
            let power = POWERS[exponent.unsigned_abs() as usize];
            return Ok(if exponent < 0 { digits as f64 / power } else { digits as f64 * power });
        }
        match slice(self.bytes, start, self.at).parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => self.fault("a number is too large"),
        }
    }
}

/// A slice that holds ASCII only, because every caller has looked at each of its bytes.
fn slice(bytes: &[u8], from: usize, to: usize) -> &str {
    bytes.get(from..to).and_then(|bytes| std::str::from_utf8(bytes).ok()).unwrap_or("")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn tokens(text: &str) -> Result<Vec<Token<'_>>, Fault> {
        let mut lexer = Lexer::new(text.as_bytes());
        let mut found = Vec::new();
        loop {
            match lexer.next_token()? {
                Token::End => return Ok(found),
                token => found.push(token),
            }
        }
    }

    #[test]
    fn lines_end_statements_and_comments() {
        use Token::{EndOfLine, Number, Symbol, Text, Word};
        assert_eq!(
            tokens("$VEL.CP=1.5E-2 ; m/s\r\nIF A==\"x;y\" THEN\n"),
            Ok(vec![
                Word("$VEL"),
                Symbol("."),
                Word("CP"),
                Symbol("="),
                Number(0.015),
                EndOfLine,
                Word("IF"),
                Word("A"),
                Symbol("=="),
                Text("x;y"),
                Word("THEN"),
                EndOfLine
            ])
        );
    }

    #[test]
    fn refuses_what_a_controller_may_read_otherwise() {
        for text in ["; caf\u{e9}", "\"open", "a\0b", "@", "a\rb", "; c\rb", "a\r\r\n", "12abc", "1.2.3", "1E", "'H1F'"]
        {
            assert!(tokens(text).is_err(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn numbers_agree_with_the_standard_parser(value in -1e12..1e12f64, decimals in 0usize..12) {
            let text = format!("{value:.decimals$}");
            let read = Lexer::new(text.as_bytes()).take_number().expect("a number");
            prop_assert_eq!(read, text.parse::<f64>().ok());
        }

        #[test]
        fn any_bytes_end_without_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let mut lexer = Lexer::new(&bytes);
            for _ in 0..300 {
                match lexer.next_token() {
                    Ok(Token::End) | Err(_) => break,
                    Ok(_) => {}
                }
            }
        }
    }
}
