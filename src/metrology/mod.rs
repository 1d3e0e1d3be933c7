//! Metrology: height maps as instruments write them, and as the part needs them.
//!
//! In: the bytes of a file and the job's words on orientation and scale. Out: an [`ErrorMap`], whose [`Grid`] lies in
//! the part frame, metres, positive where glass stands too high, NaN where nothing is known.
//!
//! The way of a map: [`read()`] turns bytes into a [`RawMap`], the picture as the instrument shows it; [`place()`] puts
//! the picture on the part as the job says, takes off what `subtract` names, and fills small holes; [`inspect()`] tells
//! a person what is in a file.

mod figures;
mod grid;
mod holes;
mod inspect;
mod low_order;
pub mod metropro;
pub mod npy;
mod orientation;
mod place;
mod raw_map;

pub use figures::Figures;
pub use grid::Grid;
pub use inspect::{Inspection, inspect};
pub use low_order::LowOrder;
pub(crate) use low_order::plane_through;
pub use orientation::{Picture, lay};
pub use place::{ErrorMap, place};
pub(crate) use place::{doubt_scale, surface_factor};
pub use raw_map::{Format, RawMap};

use crate::diagnostics::{Problem, codes};
use crate::job;
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

/// Reads and places the map of the job's workpiece: what dwell starts from. Fields are `workpiece.error.…`.
pub fn error_map(
    workpiece: &job::Workpiece,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<ErrorMap, Problem> {
    let job::FormError::height_map(map) = &workpiece.error;
    let raw = read_file(&map.file, files).map_err(|problem| problem.within("workpiece.error"))?;
    place(&raw, map, workpiece, warnings)
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
