//! Metrology: the error of a part, from height maps.
//!
//! In: the job's words on maps, and their files. Out: an [`ErrorMap`], whose [`Grid`] lies in the
//! part frame, metres, positive where glass stands too high, NaN where nothing is known.
//!
//! [`error_map`] puts the pictures on the part as the job says ([`place()`] does so with one), by marks if it has some,
//! puts several of them together, takes off what `subtract` names and fills small holes. [`SurfaceFigures`] are what a
//! drawing asks of a surface; [`inspect()`] tells a person what is in a file; [`run_record`] knows which maps are void
//! because glass was removed since.

mod clean;
mod combine;
mod cover;
mod distance;
mod figures;
mod fit;
mod holes;
mod inspect;
mod low_order;
mod place;
mod psd;
mod pvr;
mod registration;
mod resample;
pub mod run_record;
mod slope;
mod stitch;
mod surface_figures;
mod zernike_fit;

pub use combine::{Record, StitchedRecord};
pub use figures::Figures;
pub use inspect::{Inspection, MapFacts, ProfileFacts, inspect};
pub use low_order::LowOrder;
pub(crate) use low_order::{plane_through, subtract};
pub use place::MapRecord;
pub(crate) use place::{doubt_scale, surface_factor};
pub use psd::{Profile, Psd, psd};
pub use pvr::{Pvr, pvr};
pub use registration::Registered;
pub use resample::Similarity;
pub use slope::{SlopeRms, slope_rms};
pub use stitch::Seam;
pub use surface_figures::{SurfaceFigures, spectrum, surface_figures};
pub use zernike_fit::{ZernikeFit, zernike_fit};

use crate::diagnostics::Problem;
use crate::height_map::{Grid, RawMap};
use crate::job::{HeightMap, Workpiece};
use crate::source::FileProvider;
use combine::Combine;
use place::{Extent, Placed};

/// The form error of a part, ready for dwell.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    /// Part frame, metres, positive where glass stands higher than wanted. No NaN at a pixel inside the clear aperture; NaN
    /// off the part and where the instrument saw nothing.
    pub grid: Grid,
    /// Of the measured pixels inside the clear aperture, before `subtract`; metres.
    pub before: Figures,
    /// The same pixels after `subtract`, and without the `target` of the part: what is left to correct.
    pub after: Figures,
    /// What `subtract` took off a single map.
    pub removed: LowOrder,
    /// Number of holes filled inside the clear aperture, their pixels, and their area in square metres.
    pub filled_holes: usize,
    pub filled_pixels: usize,
    pub filled_area: f64,
    /// Metres, where the (first) file says it.
    pub wavelength: Option<f64>,
    /// How it came about.
    pub record: Record,
}

/// Reads and places the maps of the job's workpiece: what dwell starts from. Fields are `workpiece.error.…` and
/// `workpiece.target.…`; warnings go to `warnings`.
///
/// # Errors
/// Those of reading a file; E0506, E0507, E0508, E0511 from scale and unit; E0509 if a map does not cover the clear
/// aperture; E0510 if a hole is too large to be filled; E0512 if `subtract` is not fixed by the measured pixels; E0530
/// to E0534 from marks, E0535 and E0536 from pieces, E0537 and E0538 from masks, E0544, E0545 and E0547 from what is put
/// together.
pub fn error_map(
    workpiece: &Workpiece,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<ErrorMap, Problem> {
    let mut combine = Combine::new(workpiece, files, "workpiece.error");
    let mut said = Vec::new();
    let error = combine.form_error(&workpiece.error, Extent::Whole, &mut said);
    let error = of_field("workpiece.error", error, said, warnings)?;
    let mut map = finished(error, combine.record);
    if let Some(target) = &workpiece.target {
        let mut combine = Combine::new(workpiece, files, "workpiece.target");
        let mut said = Vec::new();
        let target = combine.taken_off(target, Extent::Whole, &mut said);
        let target = of_field("workpiece.target", target, said, warnings)?;
        combine::take_off(&mut map.grid, &target.grid);
        combine::only_between_pixels(&map.grid, &workpiece.clear)
            .map_err(|problem| problem.within("workpiece.target"))?;
        map.after = place::measured(&map.grid, &cover::inside(&map.grid, &workpiece.clear));
        map.record.maps.extend(combine.record.maps);
        map.record.stitched.extend(combine.record.stitched);
    }
    Ok(map)
}

/// Puts one picture on the part, as [`error_map`] does with the file that the job names.
pub fn place(
    raw: &RawMap,
    map: &HeightMap,
    workpiece: &Workpiece,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<ErrorMap, Problem> {
    let mut said = Vec::new();
    let placed = place::place_map(raw, map, workpiece, Extent::Whole, files, &mut said);
    let (placed, record) = of_field("workpiece.error", placed, said, warnings)?;
    Ok(finished(placed, Record { maps: vec![record], ..Record::default() }))
}

/// What was found and `said` of the map at `field`.
fn of_field<T>(
    field: &str,
    found: Result<T, Problem>,
    said: Vec<Problem>,
    warnings: &mut Vec<Problem>,
) -> Result<T, Problem> {
    warnings.extend(said.into_iter().map(|warning| warning.within(field)));
    found.map_err(|problem| problem.within(field))
}

fn finished(placed: Placed, record: Record) -> ErrorMap {
    let Placed { grid, before, after, filled_holes, filled_pixels, filled_area, wavelength } = placed;
    let removed = match record.maps.as_slice() {
        [one] => one.removed,
        _ => LowOrder::default(),
    };
    ErrorMap { grid, before, after, removed, filled_holes, filled_pixels, filled_area, wavelength, record }
}
