//! Text of instruments: from bytes to lines and numbers.

use super::refusals::{sizes, unreadable};
use crate::diagnostics::Problem;
use std::borrow::Cow;

/// How much of a file is looked at to tell text from other bytes.
const LOOK: usize = 4096;

/// The bytes as text: UTF-8, UTF-16 with its mark, or one of the older sets of Western Windows, of which only the micro
/// sign and the letters matter here. `None` for what is no text.
pub(super) fn decode(bytes: &[u8]) -> Option<Cow<'_, str>> {
    let wide = |rest: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = rest.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect::<String>()
    };
    let text = match bytes {
        [0xFF, 0xFE, rest @ ..] => Cow::Owned(wide(rest, u16::from_le_bytes)),
        [0xFE, 0xFF, rest @ ..] => Cow::Owned(wide(rest, u16::from_be_bytes)),
        _ => {
            let bytes = bytes.strip_prefix(&[0xEF, 0xBB, 0xBF]).unwrap_or(bytes);
            // Told from the beginning: nobody wants to wait for 200 MB of noise to be turned into letters.
            if !bytes.iter().take(LOOK).all(|byte| *byte >= b' ' || is_white(char::from(*byte))) {
                return None;
            }
            match std::str::from_utf8(bytes) {
                Ok(text) => Cow::Borrowed(text),
                Err(_) => Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect()),
            }
        }
    };
    text.chars().take(LOOK).all(|c| !c.is_control() || is_white(c) || !c.is_ascii()).then_some(text)
}

/// Blanks of texts, with the sign by which DOS ended a file.
fn is_white(c: char) -> bool {
    matches!(c, '\t' | '\n' | '\r' | '\x0B' | '\x0C' | '\x1A' | ' ')
}

/// A number that is one: what `parse` takes for infinity or NaN is none here.
pub(super) fn number(word: &str) -> Option<f64> {
    // `inf`, `nan` and their kin begin with a letter, also behind a sign.
    let first = word.trim_start_matches(['+', '-']).as_bytes().first()?;
    if !(first.is_ascii_digit() || *first == b'.') {
        return None;
    }
    word.parse().ok().filter(|value: &f64| value.is_finite())
}

/// Words for a place that was not measured.
pub(super) fn is_no_data(word: &str) -> bool {
    ["", "nan", "na", "n/a", "bad", "no data", "nodata", "---", "***"]
        .iter()
        .any(|known| word.trim().eq_ignore_ascii_case(known))
}

/// A piece of a file for a message: short, and without what would spoil a terminal.
pub(super) fn shown(word: &str) -> String {
    word.chars().filter(|c| !c.is_control()).take(40).collect()
}

/// The numbers of lines that are one picture after the other, `count` of them, by `value`: `Some(NaN)` for an invalid
/// pixel, `None` for no number at all. `first_line` is the number of the first line, from 1. Nothing is allocated before
/// the text proves long enough: a number needs two bytes.
pub(super) fn grid_values<'a>(
    name: &str,
    lines: impl Iterator<Item = &'a str>,
    first_line: usize,
    bytes: usize,
    count: usize,
    value: impl Fn(&str) -> Option<f64>,
) -> Result<Vec<f64>, Problem> {
    if count > bytes / 2 + 1 {
        return Err(sizes(name, format!("is cut short: {count} heights do not stand in {bytes} bytes of text")));
    }
    let mut values = Vec::with_capacity(count);
    for (at, line) in lines.enumerate() {
        for word in line.split(is_white).filter(|word| !word.is_empty()) {
            let Some(value) = value(word) else {
                let line = first_line + at;
                return Err(unreadable(name, format!("has `{}` in line {line} where a height stands", shown(word))));
            };
            if values.len() == count {
                return Err(sizes(name, format!("has more heights than the {count} that its header says")));
            }
            values.push(value);
        }
    }
    if values.len() < count {
        return Err(sizes(name, format!("is cut short: it has {} heights and should have {count}", values.len())));
    }
    Ok(values)
}

/// E0503 if the last line of a text has no end. A format that says neither its length nor where its numbers end could be
/// cut within the last number, and that would read as another height.
pub(super) fn last_line_ends(text: &str, name: &str) -> Result<(), Problem> {
    if text.ends_with(['\n', '\r', '\x1A']) {
        return Ok(());
    }
    Err(sizes(name, "is cut short: its last line has no end").help("if the file is whole, end its last line"))
}

/// Whether two bytes of text are left over at the end of UTF-16: half a letter.
pub(super) fn half_a_letter(bytes: &[u8]) -> bool {
    matches!(bytes, [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..]) && !bytes.len().is_multiple_of(2)
}
