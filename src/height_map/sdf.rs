//! SDF: the surface data file of ISO 25178-71, as text (`aISO`) and binary (`bISO`), versions 1.0 and 2.0.
//!
//! In: bytes. Out: a [`RawMap`] in metres with its pixels, or a [`Profile`] where the file has one line.
//!
//! | field | bytes in `bISO-1.0` (`2.0`) | meaning |
//! | --- | --- | --- |
//! | version | 0..8 | `aISO-1.0`, `bISO-1.0` |
//! | ManufacID, CreateDate, ModDate | 8..42 | not used |
//! | NumPoints, NumProfiles | two of 16 bits from 42 (32 bits) | columns, rows |
//! | Xscale, Yscale, Zscale, Zresolution | four floats of 64 bits from 46 (50) | pitch in x, in y (m); metres a number; not used |
//! | Compression, DataType, CheckType | three bytes from 78 (82) | 0; the type of the numbers; 0 |
//!
//! The text file says the same as lines `Field = value`, up to a line `*`; its numbers end with another `*`, and what
//! follows is free. `BAD` in the text, and the least number of its type in the binary file, mean "not measured". All
//! binary numbers are little-endian. Height = number * Zscale. The first row is the top of the picture.
//!
//! Source: ISO 25178-71:2012, *Software measurement standards*, clauses 4 to 6.

use super::element::{Element, Kind};
use super::metropro::PITCHES;
use super::refusals::{impossible, sizes, unread, unreadable, within};
use super::text;
use super::{Content, Format, Profile, RawMap, proved_pixels};
use crate::diagnostics::Problem;

/// Metres a number that can be: a kilometre of a femtometre's steps would still fit.
const SCALES: (f64, f64) = (1e-18, 1.0);

/// Types of binary numbers by their code, and the value that means "not measured".
const TYPES: [(u8, Kind, usize, f64); 5] = [
    (3, Kind::Float, 4, f32::MIN as f64),
    (4, Kind::Signed, 1, i8::MIN as f64),
    (5, Kind::Signed, 2, i16::MIN as f64),
    (6, Kind::Signed, 4, i32::MIN as f64),
    (7, Kind::Float, 8, f64::MIN),
];

/// Whether the bytes begin as such a file does.
pub fn is_sdf(bytes: &[u8]) -> bool {
    matches!(bytes, [b'a' | b'b', b'I', b'S', b'O', b'-', b'1' | b'2', b'.', b'0', ..])
}

/// What a header says.
struct Header {
    points: u64,
    profiles: u64,
    /// Metres along x and y a step, and in z a number.
    scales: [f64; 3],
    compression: u64,
    check: u64,
}

impl Header {
    /// Number of heights, if the header can be and nothing in it asks for what is not read.
    fn proved(&self, name: &str) -> Result<usize, Problem> {
        let pixels = proved_pixels(self.points, self.profiles, name)?;
        if self.compression != 0 {
            return Err(unread(name, "is compressed", "save it without compression"));
        }
        if self.check != 0 {
            return Err(unread(name, "has a check of its numbers that is not known", "save it with CheckType 0"));
        }
        for (what, value, range) in [
            ("`Xscale`", self.scales[0], PITCHES),
            // One line has no pitch across it.
            ("`Yscale`", if self.profiles == 1 { PITCHES.1 } else { self.scales[1] }, PITCHES),
            ("`Zscale`", self.scales[2], SCALES),
        ] {
            within(name, what, value, range)?;
        }
        Ok(pixels)
    }

    fn content(&self, heights: Vec<f64>) -> Content {
        let (columns, rows) = (self.points as usize, self.profiles as usize);
        let [x, y, _] = self.scales;
        if rows == 1 {
            return Content::Profile(Profile {
                format: Format::Sdf,
                positions: (0..columns).map(|i| i as f64 * x).collect(),
                positions_in_metres: true,
                heights,
                in_metres: true,
            });
        }
        Content::Map(RawMap {
            in_metres: true,
            pixel: Some([x, y]),
            ..RawMap::plain(Format::Sdf, columns, rows, heights)
        })
    }
}

/// Reads a map or a profile. Fields are `file`.
///
/// # Errors
/// E0503 if header and numbers do not fit each other, E0504 for header values that cannot be, E0513 for compression and
/// other types of numbers, E0515 for what is no number, E0501 for too many pixels.
pub fn read(bytes: &[u8], name: &str) -> Result<Content, Problem> {
    if bytes.first() == Some(&b'b') { binary(bytes, name) } else { ascii(bytes, name) }
}

fn binary(bytes: &[u8], name: &str) -> Result<Content, Problem> {
    let wide = bytes.get(5) == Some(&b'2');
    let (scales_at, end) = if wide { (50, 85) } else { (46, 81) };
    let Some(head) = bytes.get(..end) else {
        let message = format!("ends after {} bytes, inside its header of {end} bytes", bytes.len());
        return Err(sizes(name, message));
    };
    let side = |i: usize| {
        let element = Element { kind: Kind::Unsigned, size: if wide { 4 } else { 2 }, big_endian: false };
        let at = 42 + i * element.size;
        element.decode(&head[at..at + element.size]) as u64
    };
    let scale = |i: usize| {
        let at = scales_at + 8 * i;
        Element { kind: Kind::Float, size: 8, big_endian: false }.decode(&head[at..at + 8])
    };
    let header = Header {
        points: side(0),
        profiles: side(1),
        scales: [scale(0), scale(1), scale(2)],
        compression: u64::from(head[end - 3]),
        check: u64::from(head[end - 1]),
    };
    let count = header.proved(name)?;
    let code = head[end - 2];
    let Some((_, kind, size, bad)) = TYPES.iter().copied().find(|(known, ..)| *known == code) else {
        let message = format!("has numbers of the type {code}; known are 3 to 7");
        return Err(unread(name, message, "save it with 64-bit floats (type 7)"));
    };
    let needed = count * size;
    let Some(data) = bytes.get(end..end + needed) else {
        let found = bytes.len() - end;
        return Err(sizes(name, format!("is cut short: its heights have {found} bytes and should have {needed}")));
    };
    let mut heights = Element { kind, size, big_endian: false }.decode_all(data);
    for height in &mut heights {
        *height = if *height == bad { f64::NAN } else { *height * header.scales[2] };
    }
    Ok(header.content(heights))
}

fn ascii(bytes: &[u8], name: &str) -> Result<Content, Problem> {
    let Some(text) = text::decode(bytes) else {
        return Err(unreadable(name, "says that it is text and is none"));
    };
    let cut = || sizes(name, "is cut short: a line `*` must end its header, and another one its heights");
    let (head, rest) = text.split_once('*').ok_or_else(cut)?;
    let (numbers, _) = rest.split_once('*').ok_or_else(cut)?;
    let field = |field: &str| {
        let mut lines = head.lines().filter_map(|line| line.split_once('='));
        let found = lines.find(|(key, _)| key.trim().eq_ignore_ascii_case(field)).map(|(_, value)| value.trim());
        found.and_then(text::number).ok_or_else(|| impossible(name, format!("has no number `{field}` in its header")))
    };
    let whole = |what: &str| {
        let value = field(what)?;
        if value >= 0.0 && value.fract() == 0.0 {
            return Ok(value as u64);
        }
        Err(impossible(name, format!("says `{what} = {value}`, which must be a whole number")))
    };
    let header = Header {
        points: whole("NumPoints")?,
        profiles: whole("NumProfiles")?,
        scales: [field("Xscale")?, field("Yscale")?, field("Zscale")?],
        compression: whole("Compression")?,
        check: whole("CheckType")?,
    };
    let count = header.proved(name)?;
    let scale = header.scales[2];
    let value = |word: &str| match text::number(word) {
        Some(number) => Some(number * scale),
        None => text::is_no_data(word).then_some(f64::NAN),
    };
    let first = head.matches('\n').count() + 1;
    let heights = text::grid_values(name, numbers.split('\n'), first, numbers.len(), count, value)?;
    Ok(header.content(heights))
}
