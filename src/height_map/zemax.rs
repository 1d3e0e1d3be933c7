//! Zemax grid sag files (`.dat`).
//!
//! In: text. Out: a [`RawMap`] in metres with its pixels.
//!
//! Lines that begin with `!` are remarks. The first other line has seven numbers: columns, rows, pitch in x and in y, the
//! unit of all lengths (0 mm, 1 cm, 2 in, 3 m), and by how much the grid is decentred in x and y. Then comes a line for each
//! point: sag, its derivatives by x, by y and by both, and 1 where there is no data (0 or left out: there is). The first
//! point is the upper left one (-x, +y); x grows fastest, then y falls. The derivatives are not used.
//!
//! Source: *OpticStudio User Manual*, "Grid Sag".

use super::metropro::PITCHES;
use super::refusals::{impossible, sizes, unread, unreadable};
use super::text;
use super::{Format, RawMap, proved_pixels};
use crate::diagnostics::Problem;

/// Metres in the units by their numbers.
const UNITS: [f64; 4] = [1e-3, 1e-2, 0.0254, 1.0];

fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let numbered = text.split('\n').enumerate().map(|(at, line)| (at + 1, line.trim()));
    numbered.filter(|(_, line)| !line.is_empty() && !line.starts_with('!'))
}

/// The numbers of a line, if it has no other words and at most seven.
fn numbers(line: &str) -> Option<Vec<f64>> {
    let words = line.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    let numbers: Option<Vec<f64>> = words.take(8).map(text::number).collect();
    numbers.filter(|all| all.len() <= 7)
}

/// Whether the text is such a file: seven numbers, of which four can only be whole, and then four or five.
pub fn is_zemax(text: &str) -> bool {
    let mut lines = lines(text);
    let mut next = || lines.next().and_then(|(_, line)| numbers(line));
    let (Some(head), Some(first)) = (next(), next()) else { return false };
    let whole = |value: f64| value.fract() == 0.0;
    head.len() == 7 && (first.len() == 4 || first.len() == 5) && whole(head[0]) && whole(head[1]) && whole(head[4])
}

/// Reads a map. Fields are `file`.
///
/// # Errors
/// E0503 if the first line and the points do not fit each other, E0504 for a first line that cannot be, E0513 for a
/// decentred grid, E0515 for what is no number, E0501 for too many pixels.
pub fn read(text: &str, name: &str) -> Result<RawMap, Problem> {
    let mut lines = lines(text);
    let head: Option<[f64; 7]> =
        lines.next().and_then(|(_, line)| numbers(line)).and_then(|numbers| numbers.try_into().ok());
    let Some([columns, rows, dx, dy, unit, x, y]) = head else {
        return Err(unreadable(name, "does not begin with the seven numbers of a grid sag file"));
    };
    if !(columns >= 1.0 && rows >= 1.0 && columns.fract() == 0.0 && rows.fract() == 0.0) {
        return Err(impossible(name, format!("says a grid of {columns} x {rows}")));
    }
    let pixels = proved_pixels(columns as u64, rows as u64, name)?;
    let Some(metres) = UNITS.iter().enumerate().find(|(code, _)| *code as f64 == unit).map(|(_, metres)| *metres)
    else {
        return Err(impossible(name, format!("says {unit} for its unit; known are 0 (mm), 1 (cm), 2 (in) and 3 (m)")));
    };
    let pixel = [dx * metres, dy * metres];
    if !pixel.iter().all(|side| *side >= PITCHES.0 && *side <= PITCHES.1) {
        return Err(impossible(name, format!("says a pitch of {dx} x {dy}, which is not within 1 nm .. 1 m")));
    }
    if x != 0.0 || y != 0.0 {
        let [column, row] = [(columns - 1.0) / 2.0 - x / dx, (rows - 1.0) / 2.0 + y / dy];
        return Err(unread(
            name,
            format!("says that its grid is decentred by {x} in x and {y} in y"),
            format!("set both to 0, and let the job say `centre: pixel_at {{ column: {column}, row: {row} }}`"),
        ));
    }
    text::last_line_ends(text, name)?;
    if pixels > text.len() / 8 + 1 {
        // Four numbers and their blanks have eight letters.
        return Err(sizes(name, format!("is cut short: {pixels} points do not stand in {} bytes", text.len())));
    }
    let mut values = Vec::with_capacity(pixels);
    for (at, line) in lines {
        let value = match numbers(line).as_deref() {
            Some([sag, _, _, _]) | Some([sag, _, _, _, 0.0]) => sag * metres,
            Some([_, _, _, _, _]) => f64::NAN,
            _ => return Err(unreadable(name, format!("has in line {at} no sag, three derivatives and a flag"))),
        };
        if values.len() == pixels {
            return Err(sizes(name, format!("has more points than the {pixels} that its first line says")));
        }
        values.push(value);
    }
    if values.len() < pixels {
        return Err(sizes(name, format!("is cut short: it has {} points and should have {pixels}", values.len())));
    }
    Ok(RawMap {
        in_metres: true,
        pixel: Some(pixel),
        ..RawMap::plain(Format::Zemax, columns as usize, rows as usize, values)
    })
}
