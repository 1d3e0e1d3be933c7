//! Height maps: the files that instruments and designers write.
//!
//! In: the bytes of a file. Out: a [`RawMap`], the picture as the file shows it, and from it a [`Grid`] in a frame of the
//! part or the tool ([`lay`]). What the heights mean, an error of the glass, a spot, a nominal form, is said by those who
//! read them.
//!
//! Each format is a file of its own, and says at its head how it lies in bytes. [`content`] knows them apart. Whatever a
//! file says of sizes is proved against its length and against [`MOST_PIXELS`] before anything is allocated.

pub mod code_v;
mod datx;
mod element;
mod four_sight;
mod grid;
mod grid_of_points;
pub mod hdf5;
mod length_unit;
pub mod metropro;
pub mod npy;
mod orientation;
mod profile;
mod raw_map;
mod refusals;
pub mod sdf;
pub mod table;
mod text;
pub mod x3p;
pub mod zemax;
pub mod zygo_text;

pub use grid::Grid;
pub(crate) use orientation::valid_middle;
pub use orientation::{Picture, lay, position_in_frame};
pub use profile::Profile;
pub use raw_map::{Format, RawMap};

use crate::diagnostics::{Problem, codes};
use crate::source::{FileError, FileProvider};

/// Most pixels of a map: 4096 x 4096. The largest cameras of interferometers have 3400 x 3400; at eight bytes a pixel
/// and three copies (picture, part frame, filled) this stays under half a gigabyte.
pub const MOST_PIXELS: u64 = 1 << 24;

/// Most bytes of a map file: the most pixels at sixteen bytes, which leaves a MetroPro file room for five frames of
/// intensity beside its heights.
pub const MOST_BYTES: u64 = MOST_PIXELS * 16;

/// What a file of heights holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    Map(RawMap),
    /// Heights along one line: no job takes it for a map.
    Profile(Profile),
}

/// Reads a file of any known format. The format is known from the content; `name` is for messages only. Fields are `file`.
///
/// # Errors
/// E0501 too large, E0502 unknown format, E0503 sizes that do not fit the file, E0504 impossible header values, E0505
/// an array that is no height map, E0513 a part of the format that is not read, E0514 an unknown unit, E0515 text that is
/// no table of numbers, E0516 points that lie on no grid, E0517 a wrong checksum, E0518 a damaged or hostile container.
pub fn content(bytes: &[u8], name: &str) -> Result<Content, Problem> {
    if bytes.len() as u64 > MOST_BYTES {
        return Err(too_large(name, bytes.len() as u64));
    }
    if bytes.is_empty() {
        return Err(Problem::error(codes::E0503, "file", format!("`{name}` is empty"))
            .help("copy the map from the instrument again"));
    }
    if metropro::is_metropro(bytes) {
        return metropro::read(bytes, name).map(Content::Map);
    }
    if npy::is_npy(bytes) {
        return npy::read(bytes, name).map(Content::Map);
    }
    if hdf5::is_hdf5(bytes) {
        return hdf5::read(bytes, name).map(Content::Map);
    }
    if x3p::is_x3p(bytes) {
        return x3p::read(bytes, name);
    }
    if sdf::is_sdf(bytes) {
        return sdf::read(bytes, name);
    }
    let text = text::decode(bytes).ok_or_else(|| unknown_format(name))?;
    if text::half_a_letter(bytes) {
        return Err(refusals::sizes(name, "is cut short: it ends in half a letter of UTF-16"));
    }
    if zygo_text::is_zygo_text(&text) {
        zygo_text::read(&text, name).map(Content::Map)
    } else if code_v::is_code_v(&text) {
        code_v::read(&text, name).map(Content::Map)
    } else if zemax::is_zemax(&text) {
        zemax::read(&text, name).map(Content::Map)
    } else if table::is_table(&text) {
        table::read(&text, name)
    } else {
        Err(unknown_format(name))
    }
}

/// [`content`] that must be a map. E0519 for a profile; fields are `file`.
pub fn read(bytes: &[u8], name: &str) -> Result<RawMap, Problem> {
    match content(bytes, name)? {
        Content::Map(map) => Ok(map),
        Content::Profile(profile) => Err(refusals::profile(name, profile.heights.len())),
    }
}

fn unknown_format(name: &str) -> Problem {
    Problem::error(codes::E0502, "file", format!("`{name}` is no height map of a known format"))
        .note("known are Zygo `.dat`, `.datx`, `.asc` and `.xyz`, 4D `.h5`, CODE V `.int`, Zemax grid sag, X3P, SDF, NumPy `.npy` and tables of text; the format is taken from the content, not from the file's name")
        .help("export the map in one of these formats")
}

/// The bytes of the data file at `path`. Fields are `file`. E0500 if it cannot be had, E0501 if it is too large.
pub fn file_bytes(path: &str, files: &dyn FileProvider) -> Result<Vec<u8>, Problem> {
    files.read(path, MOST_BYTES).map_err(|error| match error {
        FileError::NotFound => Problem::error(codes::E0500, "file", format!("there is no file `{path}`"))
            .help("a file that a job names is looked for beside the `.polish` file that says it"),
        FileError::TooLarge { size, .. } => too_large(path, size),
        FileError::Outside => Problem::error(codes::E0500, "file", format!("`{path}` lies outside the project"))
            .help("copy it into the project's folder, or name it on the command line"),
        FileError::Other(why) => Problem::error(codes::E0500, "file", format!("`{path}` cannot be read: {why}")),
    })
}

/// [`file_bytes`], then [`read()`].
pub fn read_file(path: &str, files: &dyn FileProvider) -> Result<RawMap, Problem> {
    read(&file_bytes(path, files)?, path)
}

fn too_large(name: &str, size: u64) -> Problem {
    let mib = 1024.0 * 1024.0;
    let message =
        format!("`{name}` has {:.0} MiB; a map may have {:.0} MiB", size as f64 / mib, MOST_BYTES as f64 / mib);
    Problem::error(codes::E0501, "file", message).help("export the heights alone, without intensity frames")
}

/// Both sides of a picture as a number of pixels, if it is between 1 and [`MOST_PIXELS`]: asked by every reader before
/// it allocates anything.
fn proved_pixels(columns: u64, rows: u64, name: &str) -> Result<usize, Problem> {
    match columns.checked_mul(rows) {
        Some(0) => Err(Problem::error(
            codes::E0504,
            "file",
            format!("`{name}` says that its map has {columns} columns and {rows} rows"),
        )
        .help("a map has at least one pixel: export it again")),
        Some(pixels) if pixels <= MOST_PIXELS => Ok(pixels as usize),
        _ => Err(Problem::error(
            codes::E0501,
            "file",
            format!("`{name}` says that its map has {columns} columns and {rows} rows; at most {MOST_PIXELS} pixels are read"),
        )
        .help("bin the map, or cut it to the part")),
    }
}
