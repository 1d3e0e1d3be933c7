//! Program text being written, line by line.
//!
//! In: lines and comments. Out: plain ASCII with CRLF, no line longer than [`LINE_LENGTH`].

/// Longest line of text that the programs have, the line end not counted. No limit of the controller is documented;
/// this is what public generators write.
pub const LINE_LENGTH: usize = 199;

/// Program text being written: lines with indents and CRLF.
pub struct Text {
    pub bytes: Vec<u8>,
    /// What begins a comment.
    mark: &'static str,
}

impl Text {
    /// Empty text with room for so many bytes; `mark` begins a comment.
    pub fn new(mark: &'static str, capacity: usize) -> Text {
        Text { bytes: Vec::with_capacity(capacity), mark }
    }

    /// One line at `depth` steps of indent.
    pub fn line(&mut self, depth: usize, text: &str) {
        for _ in 0..depth {
            self.bytes.extend_from_slice(b"    ");
        }
        self.bytes.extend_from_slice(text.as_bytes());
        self.end();
    }

    /// Ends the line.
    pub fn end(&mut self) {
        self.bytes.extend_from_slice(b"\r\n");
    }

    /// A comment, broken at blanks where the line grows too long. What is not plain ASCII is written as an escape:
    /// controllers refuse other characters even in comments, and a line end would let words of the job become code.
    pub fn comment(&mut self, depth: usize, text: &str) {
        let mut plain = String::new();
        for c in text.chars() {
            match c {
                ' '..='~' => plain.push(c),
                _ => plain.extend(c.escape_unicode()),
            }
        }
        let room = LINE_LENGTH - 4 * depth - 2;
        let mut rest = plain.as_str();
        loop {
            // Everything is ASCII here, so a byte is a character.
            if rest.len() <= room {
                self.line(depth, &format!("{} {rest}", self.mark));
                return;
            }
            let cut = rest[..room].rfind(' ').filter(|at| *at > 0).unwrap_or(room);
            self.line(depth, &format!("{} {}", self.mark, &rest[..cut]));
            rest = rest[cut..].trim_start();
        }
    }
}
