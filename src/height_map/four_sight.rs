//! 4D Technology `.h5` maps, as 4Sight writes them.
//!
//! In: a file of HDF5. Out: a [`RawMap`] in metres with the wavelength; such a file says no pixel that could be trusted,
//! so the job must.
//!
//! The heights are the data set `/measurement0/genraw/data`, in waves; the attribute `wavelength` of the group above (or
//! of the data set) is a text such as `632.8 nm`. Values above 1e38 were not measured. Row 0 is the top of the picture.
//!
//! Source: the format has no public description; the reading follows what laboratories that own such instruments do.

use super::hdf5::{self, File};
use super::metropro::WAVELENGTHS;
use super::refusals::{impossible, unknown_unit};
use super::{Format, RawMap, length_unit, text};
use crate::diagnostics::Problem;

const HEIGHTS: &str = "/measurement0/genraw/data";
const GROUP: &str = "/measurement0/genraw";

/// From here on a value means "not measured": the file is filled up with the largest number of single precision.
const INVALID: f64 = 1e38;

/// Whether the file has heights where 4Sight keeps them.
pub(super) fn is_four_sight(file: &File) -> bool {
    file.dataset(HEIGHTS).is_some()
}

/// Reads the map. Fields are `file`.
pub(super) fn read(file: &File, name: &str) -> Result<RawMap, Problem> {
    let dataset = file.dataset(HEIGHTS).ok_or_else(|| impossible(name, format!("has no `{HEIGHTS}`")))?;
    let of_group = file.group_attribute(GROUP, "wavelength");
    let attribute = of_group.or_else(|| dataset.attribute("wavelength").ok());
    let stated = attribute.as_ref().and_then(hdf5::words).ok_or_else(|| {
        impossible(name, format!("measures heights in waves but has no text `wavelength` with a unit at `{GROUP}`"))
    })?;
    // The unit is what follows the last digit: `632.8 nm`, `6.328e-7 m`.
    let (number, unit) = stated.split_at(stated.rfind(|c: char| c.is_ascii_digit()).map_or(0, |last| last + 1));
    let Some(unit) = length_unit::metres(unit) else { return Err(unknown_unit(name, "wavelength", unit.trim())) };
    let wavelength = text::number(number.trim()).map(|number| number * unit);
    let Some(wavelength) = wavelength.filter(|w| *w >= WAVELENGTHS.0 && *w <= WAVELENGTHS.1) else {
        return Err(impossible(name, format!("says that its wavelength is `{stated}`, not one of light")));
    };
    let (columns, rows, mut values) = file.picture(&dataset)?;
    for value in &mut values {
        *value = if *value > INVALID { f64::NAN } else { *value * wavelength };
    }
    Ok(RawMap {
        in_metres: true,
        wavelength: Some(wavelength),
        ..RawMap::plain(Format::FourSight, columns, rows, values)
    })
}
