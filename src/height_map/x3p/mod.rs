//! X3P: surfaces of ISO 25178-72 (and its forerunner ISO 5436-2), a ZIP archive of a description and data.
//!
//! In: bytes. Out: a [`RawMap`] in metres with its pixels, which need not be square, or a [`Profile`] where the file has one
//! line. `write` makes such files.
//!
//! `main.xml` describes the axes: x and y must be incremental (`I`), with a pitch in metres; z is absolute (`A`: metres) or
//! incremental (height = value * increment + offset). The numbers stand in a binary file, little-endian, in rows along x,
//! or as text in `main.xml` itself. A number that is not finite, and a bit 0 in the mask of valid points (least bit first),
//! mean "not measured". MD5 sums guard the binary files and `main.xml`. The first row is the top of the picture, as the
//! programs show it that write such files.
//!
//! Refused, with the reason: point clouds, absolute x and y axes, several layers, rotated axes.
//!
//! Source: ISO 25178-72:2017 with Amd 1:2020, and the schema of openGPS.

mod archive;
mod description;
mod write;

pub use write::write;

use super::element::{Element, Kind};
use super::metropro::PITCHES;
use super::refusals::{checksum, impossible, sizes, unread};
use super::{Content, Format, Profile, RawMap, proved_pixels};
use crate::diagnostics::Problem;
use archive::Archive;
use description::Description;
use md5::{Digest, Md5};

const MAIN: &str = "main.xml";

/// Metres an increment of height that can be.
const HEIGHT_STEPS: (f64, f64) = (1e-18, 1.0);

/// Whether the bytes begin as a ZIP archive does.
pub fn is_x3p(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

/// Reads a map or a profile. Fields are `file`.
///
/// # Errors
/// E0502 for an archive that is no X3P, E0503 if sizes do not fit each other, E0504 for descriptions that cannot be, E0513
/// for surfaces that are no grid, E0517 for a checksum that does not agree, E0518 for a damaged archive or description,
/// E0501 for too many pixels.
pub fn read(bytes: &[u8], name: &str) -> Result<Content, Problem> {
    let mut archive = Archive::open(bytes, name)?;
    let Some(main) = archive.part(MAIN, archive::MOST_DESCRIPTION)? else {
        return Err(super::unknown_format(name));
    };
    let description = Description::of(&main, name)?;
    if let Some(file) = description.text("Record4/ChecksumFile") {
        let Some(sum) = archive.part(file, 1024)? else {
            return Err(sizes(name, format!("names a checksum file `{file}` that is not in it")));
        };
        let sum = String::from_utf8_lossy(&sum);
        prove(&main, MAIN, sum.split_whitespace().next().unwrap_or(""), name)?;
    }
    let grid = Grid::of(&description, name)?;
    let mut heights = match description.text("Record3/DataLink/PointDataLink") {
        Some(file) => {
            let element = grid.element;
            let data = exact(&mut archive, file, grid.points * element.size, name)?;
            if let Some(sum) = description.text("Record3/DataLink/MD5ChecksumPointData") {
                prove(&data, file, sum, name)?;
            }
            element.decode_all(&data)
        }
        None if description.heights.len() == grid.points => description.heights.clone(),
        None => {
            let found = description.heights.len();
            return Err(sizes(name, format!("has {found} heights and should have {}", grid.points)));
        }
    };
    for height in &mut heights {
        *height = if height.is_finite() { *height * grid.height_step + grid.height_offset } else { f64::NAN };
    }
    if let Some(file) = description.text("Record3/DataLink/ValidPointsLink") {
        let mask = exact(&mut archive, file, grid.points.div_ceil(8), name)?;
        if let Some(sum) = description.text("Record3/DataLink/MD5ChecksumValidPoints") {
            prove(&mask, file, sum, name)?;
        }
        for (i, height) in heights.iter_mut().enumerate() {
            if mask[i / 8] >> (i % 8) & 1 == 0 {
                *height = f64::NAN;
            }
        }
    }
    Ok(grid.content(heights))
}

/// A part of the archive that must have exactly `size` bytes.
fn exact(archive: &mut Archive, file: &str, size: usize, name: &str) -> Result<Vec<u8>, Problem> {
    match archive.part(file, size as u64)? {
        Some(data) if data.len() == size => Ok(data),
        Some(data) => Err(sizes(name, format!("has {} bytes in its part `{file}` and should have {size}", data.len()))),
        None => Err(sizes(name, format!("names a part `{file}` that is not in it"))),
    }
}

/// E0517 if the MD5 sum of the bytes is not `sum`, in hexadecimal.
fn prove(bytes: &[u8], part: &str, sum: &str, name: &str) -> Result<(), Problem> {
    let found: String = Md5::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    if found.eq_ignore_ascii_case(sum.trim()) {
        return Ok(());
    }
    Err(checksum(name, format!("was changed after it was written: the MD5 sum of its part `{part}` does not agree")))
}

/// The grid that the description says.
struct Grid {
    columns: usize,
    rows: usize,
    points: usize,
    /// Metres.
    pixel: [f64; 2],
    element: Element,
    height_step: f64,
    height_offset: f64,
}

impl Grid {
    fn of(description: &Description, name: &str) -> Result<Grid, Problem> {
        let word = |path: &str| {
            description.text(path).ok_or_else(|| impossible(name, format!("does not say `{path}` in its {MAIN}")))
        };
        let number = |path: &str| description.number(path, name);
        let kind = word("Record1/FeatureType")?;
        if kind == "PCL" || description.has("Record3/ListDimension") {
            return Err(unread(name, "is a cloud of points (PCL), not a grid", "export the surface as a grid (SUR)"));
        }
        if !matches!(kind, "SUR" | "PRF") {
            return Err(unread(name, format!("holds a feature `{kind}`; known are SUR and PRF"), "export a surface"));
        }
        let turned = (1..=3).flat_map(|row| (1..=3).map(move |column| (row, column)));
        for (row, column) in turned {
            let value = number(&format!("Record1/Axes/Rotation/r{row}{column}"))?;
            let unmoved = if row == column { 1.0 } else { 0.0 };
            if value.is_some_and(|value| value != unmoved) {
                return Err(unread(name, "has rotated axes", "export the surface in its own axes"));
            }
        }
        let side = |path: &str| match number(path)? {
            Some(value) if value >= 1.0 && value.fract() == 0.0 => Ok(value as u64),
            Some(value) => Err(impossible(name, format!("says `{path}` with {value}"))),
            None => Err(impossible(name, format!("does not say `{path}` in its {MAIN}"))),
        };
        let (columns, rows) = (side("Record3/MatrixDimension/SizeX")?, side("Record3/MatrixDimension/SizeY")?);
        let layers = side("Record3/MatrixDimension/SizeZ")?;
        if layers != 1 {
            return Err(unread(name, format!("has {layers} layers of heights"), "export one layer alone"));
        }
        let points = proved_pixels(columns, rows, name)?;
        let pitch = |axis: &str, count: u64| {
            let kind = word(&format!("Record1/Axes/{axis}/AxisType"))?;
            if kind == "A" {
                let message = format!("has an absolute axis {axis}: each point says its own place");
                return Err(unread(name, message, "export the surface on a grid with incremental axes"));
            }
            let increment = number(&format!("Record1/Axes/{axis}/Increment"))?;
            match increment {
                Some(pitch) if pitch >= PITCHES.0 && pitch <= PITCHES.1 => Ok(pitch),
                // One line has no pitch across it.
                _ if count == 1 => Ok(0.0),
                Some(pitch) => Err(impossible(
                    name,
                    format!("says that its axis {axis} has an increment of {pitch:e} m, not within 1 nm .. 1 m"),
                )),
                None => Err(impossible(name, format!("says no increment of its axis {axis}"))),
            }
        };
        let pixel = [pitch("CX", columns)?, pitch("CY", rows)?];
        let (kind, size) = match word("Record1/Axes/CZ/DataType")? {
            "I" => (Kind::Signed, 2),
            "L" => (Kind::Signed, 4),
            "F" => (Kind::Float, 4),
            "D" => (Kind::Float, 8),
            other => {
                let message = format!("has heights of the type `{other}`; known are I, L, F and D");
                return Err(unread(name, message, "export the heights as 64-bit floats (D)"));
            }
        };
        let (step, offset) = (number("Record1/Axes/CZ/Increment")?, number("Record1/Axes/CZ/Offset")?);
        let (height_step, height_offset) = match word("Record1/Axes/CZ/AxisType")? {
            "A" if step.is_some_and(|step| step != 1.0) => {
                return Err(unread(
                    name,
                    "has absolute heights with an increment, which programs read in two ways",
                    "export the heights in metres, with an increment of 1",
                ));
            }
            "A" => (1.0, offset.unwrap_or(0.0)),
            _ => match step {
                Some(step) if step >= HEIGHT_STEPS.0 && step <= HEIGHT_STEPS.1 => (step, offset.unwrap_or(0.0)),
                _ => return Err(impossible(name, "has incremental heights and no increment that can be")),
            },
        };
        let element = Element { kind, size, big_endian: false };
        let (columns, rows) = (columns as usize, rows as usize);
        Ok(Grid { columns, rows, points, pixel, element, height_step, height_offset })
    }

    fn content(&self, heights: Vec<f64>) -> Content {
        if self.rows > 1 {
            return Content::Map(RawMap {
                in_metres: true,
                pixel: Some(self.pixel),
                ..RawMap::plain(Format::X3p, self.columns, self.rows, heights)
            });
        }
        Content::Profile(Profile {
            format: Format::X3p,
            positions: (0..self.columns).map(|i| i as f64 * self.pixel[0]).collect(),
            positions_in_metres: true,
            heights,
            in_metres: true,
        })
    }
}
