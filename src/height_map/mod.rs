//! Height maps: the files that instruments and designers write.
//!
//! In: the bytes of a file. Out: a [`RawMap`], the picture as the file shows it, and from it a [`Grid`] in a frame of the
//! part or the tool ([`lay`]). What the heights mean, an error of the glass, a spot, a nominal form, is said by those who
//! read them.

mod grid;
pub mod metropro;
pub mod npy;
mod orientation;
mod raw_map;

pub use grid::Grid;
pub(crate) use orientation::valid_middle;
pub use orientation::{Picture, lay, position_in_frame};
pub use raw_map::{Format, RawMap};

use crate::diagnostics::{Problem, codes};
use crate::source::{FileError, FileProvider};

/// Most pixels of a map: 4096 x 4096. The largest cameras of interferometers have 3400 x 3400; at eight bytes a pixel
/// and three copies (picture, part frame, filled) this stays under half a gigabyte.
pub const MOST_PIXELS: u64 = 1 << 24;

/// Most bytes of a map file: the most pixels at sixteen bytes, which leaves a MetroPro file room for five frames of
/// intensity beside its heights.
pub const MOST_BYTES: u64 = MOST_PIXELS * 16;

/// Reads a map of any known format. The format is known from the content; `name` is for messages only. Fields are
/// `file`.
///
/// # Errors
/// E0501 too large, E0502 unknown format, E0503 sizes that do not fit the file, E0504 impossible header values, E0505
/// an array that is no height map.
pub fn read(bytes: &[u8], name: &str) -> Result<RawMap, Problem> {
    if bytes.len() as u64 > MOST_BYTES {
        return Err(too_large(name, bytes.len() as u64));
    }
    if bytes.is_empty() {
        return Err(Problem::error(codes::E0503, "file", format!("`{name}` is empty"))
            .help("copy the map from the instrument again"));
    }
    if metropro::is_metropro(bytes) {
        metropro::read(bytes, name)
    } else if npy::is_npy(bytes) {
        npy::read(bytes, name)
    } else {
        Err(Problem::error(codes::E0502, "file", format!("`{name}` is neither a MetroPro map nor a NumPy array"))
            .note("the format is taken from the first bytes, not from the file's name")
            .help("export the map as MetroPro `.dat` or save the array as `.npy`"))
    }
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
