//! NumPy `.npy` arrays, versions 1 to 3, two-dimensional, of real numbers.
//!
//! In: bytes. Out: a [`RawMap`] in file units: an array says neither pixel nor unit, so the job must. Row 0 of the array
//! is the top of the picture; NaN marks invalid pixels.
//!
//! Source: NumPy Enhancement Proposal 1, "A Simple File Format for NumPy Arrays", and `numpy.lib.format`.

use super::element::{Element, Kind};
use super::refusals::no_map;
use super::{Format, RawMap, proved_pixels};
use crate::diagnostics::{Problem, codes};

const MAGIC: &[u8] = b"\x93NUMPY";

/// Longest header that is read: NumPy's own limit. A real header has about a hundred bytes.
const LONGEST_HEADER: usize = 10_000;

/// Whether the bytes begin as an array of NumPy does.
pub fn is_npy(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// Reads an array. Its size is proved against the length of `bytes` before anything is allocated. Fields are `file`.
///
/// # Errors
/// E0503 if header and file do not fit each other, E0505 for an array that is no height map, E0501 for too many pixels.
pub fn read(bytes: &[u8], name: &str) -> Result<RawMap, Problem> {
    let short = || sizes(name, format!("ends after {} bytes, inside its header", bytes.len()));
    let version = *bytes.get(6).ok_or_else(short)?;
    let (length, start) = match version {
        1 => bytes.get(8..10).map(|b| (usize::from(u16::from_le_bytes([b[0], b[1]])), 10)),
        2 | 3 => bytes.get(8..12).map(|b| (u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize, 12)),
        _ => return Err(no_map(name, format!("is a NumPy array of version {version}; versions 1 to 3 are known"))),
    }
    .ok_or_else(short)?;
    if length > LONGEST_HEADER {
        return Err(sizes(name, format!("says that its header has {length} bytes; at most {LONGEST_HEADER} are read")));
    }
    let text = bytes.get(start..start + length).ok_or_else(short)?;
    let header = std::str::from_utf8(text)
        .ok()
        .and_then(parse_header)
        .ok_or_else(|| no_map(name, "has a header that does not describe a plain array"))?;
    let element = element(&header.descr).ok_or_else(|| {
        no_map(
            name,
            format!("holds `{}` numbers; real numbers of 1 to 8 bytes are read (`<f8`, `<f4`, `<i4`)", header.descr),
        )
    })?;
    let &[rows, columns] = header.shape.as_slice() else {
        return Err(no_map(name, format!("has {} dimensions; a map has two", header.shape.len())));
    };
    let pixels = proved_pixels(columns, rows, name)?;
    let data = &bytes[start + length..];
    if data.len() != pixels * element.size {
        return Err(sizes(
            name,
            format!(
                "says {rows} rows of {columns} numbers of {} bytes but has {} bytes of them",
                element.size,
                data.len()
            ),
        ));
    }
    let (rows, columns) = (rows as usize, columns as usize);
    let mut values = element.decode_all(data);
    if header.fortran_order {
        // Element (row, column) stands at column * rows + row.
        values = (0..pixels).map(|i| values[(i % columns) * rows + i / columns]).collect();
    }
    Ok(RawMap::plain(Format::Npy, columns, rows, values))
}

/// Writes an array of 64-bit floats, version 1, C order, row 0 first. `None` if `values` does not fill the rows.
pub fn write(columns: usize, values: &[f64]) -> Option<Vec<u8>> {
    if columns == 0 || !values.len().is_multiple_of(columns) {
        return None;
    }
    let mut header =
        format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {columns}), }}", values.len() / columns);
    // The data must begin at a multiple of 64 bytes, and the header must end with a newline.
    while !(MAGIC.len() + 4 + header.len() + 1).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(&[1, 0]);
    bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
    bytes.extend_from_slice(header.as_bytes());
    for value in values {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    Some(bytes)
}

/// From NumPy's type text, such as `<f8`.
fn element(descr: &str) -> Option<Element> {
    let &[order, kind, digit] = descr.as_bytes() else { return None };
    let size = usize::from(digit.wrapping_sub(b'0'));
    let kind = match kind {
        b'f' if matches!(size, 4 | 8) => Kind::Float,
        b'i' if matches!(size, 1 | 2 | 4 | 8) => Kind::Signed,
        b'u' if matches!(size, 1 | 2 | 4 | 8) => Kind::Unsigned,
        _ => return None,
    };
    // `|` says that the order of bytes does not matter: only for one byte.
    let ordered = matches!(order, b'<' | b'>') || (order == b'|' && size == 1);
    ordered.then_some(Element { kind, size, big_endian: order == b'>' })
}

struct ArrayHeader {
    descr: String,
    fortran_order: bool,
    shape: Vec<u64>,
}

/// The header is the text of a Python dictionary with exactly the keys `descr`, `fortran_order` and `shape`.
fn parse_header(text: &str) -> Option<ArrayHeader> {
    let (mut descr, mut fortran_order, mut shape) = (None, None, None);
    let mut rest = text.trim().strip_prefix('{')?.trim_start();
    loop {
        if let Some(after) = rest.strip_prefix('}') {
            return if after.trim().is_empty() {
                Some(ArrayHeader { descr: descr?, fortran_order: fortran_order?, shape: shape? })
            } else {
                None
            };
        }
        let (key, after) = quoted(rest)?;
        let value = after.trim_start().strip_prefix(':')?.trim_start();
        rest = match key {
            "descr" => {
                let (text, after) = quoted(value)?;
                descr = Some(text.to_string());
                after
            }
            "fortran_order" => {
                let (flag, after) = match value.strip_prefix("True") {
                    Some(after) => (true, after),
                    None => (false, value.strip_prefix("False")?),
                };
                fortran_order = Some(flag);
                after
            }
            "shape" => {
                let (inner, after) = value.strip_prefix('(')?.split_once(')')?;
                let sides = inner.split(',').map(str::trim).filter(|side| !side.is_empty());
                shape = Some(sides.map(|side| side.parse().ok()).collect::<Option<Vec<u64>>>()?);
                after
            }
            _ => return None,
        }
        .trim_start();
        if let Some(after) = rest.strip_prefix(',') {
            rest = after.trim_start();
        } else if !rest.starts_with('}') {
            return None;
        }
    }
}

/// A text in single or double quotes, without escapes, and what follows it.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    text[1..].split_once(quote)
}

fn sizes(name: &str, what: String) -> Problem {
    Problem::error(codes::E0503, "file", format!("`{name}` {what}")).help("save the array again")
}
