//! The text exports of Zygo's MetroPro and Mx: "Zygo ASCII Data File" and "Zygo XYZ Data File".
//!
//! In: text. Out: a [`RawMap`]. Both begin with the same header, line by line:
//!
//! | line | meaning |
//! | --- | --- |
//! | 1 | `Zygo ASCII Data File - Format 2`, or `Zygo XYZ Data File - Format 1` |
//! | 4 | first column and row of the heights on the camera, columns, rows |
//! | 8 | source, scale factor S, wavelength W (m), numerical aperture, obliquity O, magnification, metres a pixel (0: not calibrated), time |
//! | 11 | phase resolution (0: R = 4096; 1: 32768; 2: 131072) and six more, then the sign (1: inverted) |
//!
//! A line `#` ends the header. In the ASCII file intensities follow, a line `#`, then the heights from the upper left, row
//! by row, as whole numbers: height = value * W * S * O / R metres, invalid from 2147483640 on. In the XYZ file a line
//! for each pixel follows: column, row, and the height or `No Data`. MetroPro writes these heights in micrometres; Mx in
//! the unit that was set when it wrote them. The file does not say which, so the job must.
//!
//! Source: *MetroPro Reference Guide* (Zygo OMP-0347), chapters "ASCII data format" and "XYZ data format".

use super::metropro::{FACTORS, INVALID, PITCHES, RESOLUTIONS, WAVELENGTHS, said_by_factor};
use super::refusals::{impossible, sizes, unreadable, within};
use super::text::{self, shown};
use super::{Format, RawMap, proved_pixels};
use crate::diagnostics::Problem;

const ASCII: &str = "Zygo ASCII Data File";
const XYZ: &str = "Zygo XYZ Data File";

/// Lines before the first `#`: fourteen, and a comment that was broken into several.
const MOST_HEADER_LINES: usize = 40;

/// Whether the text begins as one of the two exports does.
pub fn is_zygo_text(text: &str) -> bool {
    text.starts_with(ASCII) || text.starts_with(XYZ)
}

/// Reads a map. Fields are `file`.
///
/// # Errors
/// E0503 if header and heights do not fit each other, E0504 for header values that cannot be, E0515 for what is no
/// number, E0501 for too many pixels.
pub fn read(text: &str, name: &str) -> Result<RawMap, Problem> {
    let header = Header::of(text, name)?;
    let [_, _, columns, rows] = header.numbers(4).and_then(|all| all.try_into().ok()).unwrap_or([-1.0; 4]);
    if !(columns >= 1.0 && rows >= 1.0 && columns.fract() == 0.0 && rows.fract() == 0.0) {
        return Err(impossible(name, "does not say in its line 4 how many columns and rows its heights have"));
    }
    let pixels = proved_pixels(columns as u64, rows as u64, name)?;
    let scale_factor = header.within(8, 1, "scale factor", FACTORS)?;
    let wavelength = header.within(8, 2, "wavelength", WAVELENGTHS)?;
    let obliquity = header.within(8, 4, "obliquity factor", FACTORS)?;
    let pixel = match header.number(8, 6) {
        Some(0.0) => None,
        _ => Some([header.within(8, 6, "pixel", PITCHES)?; 2]),
    };
    let (columns, rows) = (columns as usize, rows as usize);
    let (values, in_metres) = if text.starts_with(ASCII) {
        let resolution = header.number(11, 0).filter(|code| code.fract() == 0.0 && *code >= 0.0);
        let Some(resolution) = resolution.and_then(|code| RESOLUTIONS.get(code as usize)) else {
            return Err(impossible(name, "does not say in its line 11 a phase resolution of 0, 1 or 2"));
        };
        (phases(&header, pixels, wavelength * scale_factor * obliquity / resolution)?, true)
    } else {
        (points(&header, columns, rows)?, false)
    };
    Ok(RawMap {
        in_metres,
        pixel,
        wavelength: Some(wavelength),
        quantity: said_by_factor(scale_factor),
        sign_inverted: header.number(11, 7) == Some(1.0),
        ..RawMap::plain(Format::ZygoText, columns, rows, values)
    })
}

/// The lines before the first `#`, and all after it.
struct Header<'a> {
    name: &'a str,
    lines: Vec<&'a str>,
    rest: &'a str,
}

impl<'a> Header<'a> {
    fn of(text: &'a str, name: &'a str) -> Result<Header<'a>, Problem> {
        let (mut lines, mut rest) = (Vec::new(), text);
        while let Some((line, after)) = rest.split_once('\n') {
            rest = after;
            if line.trim() == "#" {
                return Ok(Header { name, lines, rest });
            }
            lines.push(line.trim());
            if lines.len() > MOST_HEADER_LINES {
                break;
            }
        }
        Err(sizes(name, "has no `#` where the header of a Zygo text ends"))
    }

    /// The number at `place`, from 0, of a line, from 1.
    fn number(&self, line: usize, place: usize) -> Option<f64> {
        text::number(self.lines.get(line - 1)?.split_whitespace().nth(place)?)
    }

    fn numbers(&self, line: usize) -> Option<Vec<f64>> {
        self.lines.get(line - 1)?.split_whitespace().map(text::number).collect()
    }

    fn within(&self, line: usize, place: usize, what: &str, range: (f64, f64)) -> Result<f64, Problem> {
        match self.number(line, place) {
            Some(value) => within(self.name, what, value, range),
            None => Err(impossible(self.name, format!("has no {what} in its line {line}"))),
        }
    }
}

/// The heights of an ASCII file, after its intensities.
fn phases(header: &Header, pixels: usize, height: f64) -> Result<Vec<f64>, Problem> {
    let mut lines = header.rest.split('\n').enumerate();
    if !lines.by_ref().any(|(_, line)| line.trim() == "#") {
        return Err(sizes(header.name, "is cut short: no `#` ends its intensities"));
    }
    let first = lines.clone().next().map_or(0, |(at, _)| at) + header.lines.len() + 2;
    let value = |word: &str| {
        let count: i64 = word.parse().ok()?;
        Some(if count >= i64::from(INVALID) { f64::NAN } else { count as f64 * height })
    };
    let mut ended = false;
    let heights = lines.map(|(_, line)| line).take_while(|line| {
        ended = line.trim() == "#";
        !ended
    });
    let values = text::grid_values(header.name, heights, first, header.rest.len(), pixels, value)?;
    if !ended {
        return Err(sizes(header.name, "is cut short: no `#` ends its heights"));
    }
    Ok(values)
}

/// The heights of an XYZ file, in its own unit.
fn points(header: &Header, columns: usize, rows: usize) -> Result<Vec<f64>, Problem> {
    let name = header.name;
    // A line has at least two digits and `No Data`, or three digits, with their blanks.
    if columns * rows > header.rest.len() / 5 {
        let message = format!("is cut short: {} pixels do not stand in {} bytes", columns * rows, header.rest.len());
        return Err(sizes(name, message));
    }
    let (first_column, first_row) = (header.number(4, 0).unwrap_or(0.0), header.number(4, 1).unwrap_or(0.0));
    let mut values = vec![f64::NAN; columns * rows];
    let mut seen = vec![false; columns * rows];
    let mut ended = false;
    for (at, line) in header.rest.split('\n').enumerate() {
        let line = line.trim();
        if line == "#" {
            ended = true;
            break;
        }
        if line.is_empty() {
            continue;
        }
        let number = at + header.lines.len() + 2;
        let mut words = line.split_whitespace();
        let mut place = |first: f64, count: usize| {
            let at = text::number(words.next()?)? - first;
            (at >= 0.0 && at < count as f64 && at.fract() == 0.0).then_some(at as usize)
        };
        let (Some(column), Some(row)) = (place(first_column, columns), place(first_row, rows)) else {
            let message = format!("names in line {number} no pixel of its {columns} columns and {rows} rows");
            return Err(unreadable(name, message));
        };
        let height: Vec<&str> = words.take(3).collect();
        let value = match height.as_slice() {
            [word] => text::number(word),
            ["No", "Data"] => Some(f64::NAN),
            _ => None,
        };
        let Some(value) = value else {
            let message = format!("has `{}` in line {number} where a height stands", shown(&height.join(" ")));
            return Err(unreadable(name, message));
        };
        let pixel = row * columns + column;
        if std::mem::replace(&mut seen[pixel], true) {
            return Err(unreadable(name, format!("says column {column}, row {row} twice, again in line {number}")));
        }
        values[pixel] = value;
    }
    if !ended {
        return Err(sizes(name, "is cut short: no `#` ends its heights"));
    }
    Ok(values)
}
