//! Metrology: the error of a part, from a height map.
//!
//! In: a [`RawMap`](crate::height_map::RawMap) and the job's words on orientation and scale. Out: an [`ErrorMap`], whose
//! [`Grid`](crate::height_map::Grid) lies in the part frame, metres, positive where glass stands too high, NaN where nothing
//! is known.
//!
//! [`place()`] puts the picture on the part as the job says, takes off what `subtract` names, and fills small holes;
//! [`inspect()`] tells a person what is in a file.

mod distance;
mod figures;
mod fit;
mod holes;
mod inspect;
mod low_order;
mod place;
mod psd;
mod pvr;
mod slope;
mod zernike_fit;

pub use figures::Figures;
pub use inspect::{Inspection, MapFacts, ProfileFacts, inspect};
pub use low_order::LowOrder;
pub(crate) use low_order::plane_through;
pub use place::{ErrorMap, place};
pub(crate) use place::{doubt_scale, surface_factor};
pub use psd::{Profile, Psd, psd};
pub use pvr::{Pvr, pvr};
pub use slope::{SlopeRms, slope_rms};
pub use zernike_fit::{ZernikeFit, zernike_fit};

use crate::diagnostics::Problem;
use crate::height_map::read_file;
use crate::job;
use crate::source::FileProvider;

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
