//! Zygo Mx `.datx` maps.
//!
//! In: a file of HDF5. Out: a [`RawMap`] in metres, with wavelength and, where it was calibrated, pixel.
//!
//! The heights are the one data set of the group `/Data/Surface`; its attributes say the rest:
//!
//! | attribute | meaning |
//! | --- | --- |
//! | `Unit` | `Fringes`: height = value * S * O * W; a unit of length: height = value in that unit |
//! | `Wavelength`, `Interferometric Scale Factor`, `Obliquity Factor` | W (metres), S, O |
//! | `No Data` | from this value on a value means "not measured" |
//! | `X Converter`, `Y Converter` | `Category`, `BaseUnit`, `Parameters`; a lateral axis in `Pixels` has metres a pixel as its second parameter, 0 where it was not calibrated |
//!
//! Row 0 is the top of the picture. Under `/Attributes` stands what MetroPro kept in its header, with the `sign`.
//!
//! Source: the format has no public description; the reading follows prysm's, and files of the instrument.

use super::hdf5::{self, File};
use super::length_unit;
use super::metropro::{FACTORS, PITCHES, WAVELENGTHS, said_by_factor};
use super::refusals::{impossible, unknown_unit, unread, within};
use super::{Format, RawMap};
use crate::diagnostics::Problem;
use hdf5_reader::Dataset;

const SURFACES: &str = "/Data/Surface";

/// The attribute of the groups under `/Attributes` that says whether the sign was inverted.
const SIGN: &str = "attr.sign";

/// Whether the file has a group where Mx keeps its heights.
pub(super) fn is_datx(file: &File) -> bool {
    file.has_group(SURFACES)
}

/// Reads the map. Fields are `file`.
pub(super) fn read(file: &File, name: &str) -> Result<RawMap, Problem> {
    let surfaces = file.datasets(SURFACES)?;
    let [surface] = surfaces.as_slice() else {
        let message = format!("holds {} maps of heights; one is read", surfaces.len());
        return Err(unread(name, message, "save one map alone in Mx"));
    };
    let attributes = Attributes { surface, name };
    let wavelength = attributes.optional("Wavelength", WAVELENGTHS)?;
    let scale_factor = attributes.optional("Interferometric Scale Factor", FACTORS)?;
    let unit = attributes.words("Unit")?;
    let scale = match length_unit::metres(&unit) {
        Some(scale) => scale,
        None if unit == "Fringes" => {
            let needed = |found: Option<f64>, what: &str| {
                found.ok_or_else(|| impossible(name, format!("measures heights in fringes but has no `{what}`")))
            };
            needed(scale_factor, "Interferometric Scale Factor")?
                * needed(attributes.optional("Obliquity Factor", FACTORS)?, "Obliquity Factor")?
                * needed(wavelength, "Wavelength")?
        }
        None => return Err(unknown_unit(name, "heights", &unit)),
    };
    let no_data = surface.attribute("No Data").ok().as_ref().and_then(hdf5::number).unwrap_or(f64::MAX);
    let pixel = match (attributes.pitch("X Converter")?, attributes.pitch("Y Converter")?) {
        (Some(x), Some(y)) => Some([x, y]),
        _ => None,
    };
    let (columns, rows, mut values) = file.picture(surface)?;
    for value in &mut values {
        // Written so that NaN stays NaN.
        *value = if *value >= no_data { f64::NAN } else { *value * scale };
    }
    Ok(RawMap {
        in_metres: true,
        pixel,
        wavelength,
        quantity: scale_factor.and_then(said_by_factor),
        sign_inverted: sign_inverted(file),
        ..RawMap::plain(Format::Datx, columns, rows, values)
    })
}

/// What is said about the heights.
struct Attributes<'a> {
    surface: &'a Dataset,
    name: &'a str,
}

impl Attributes<'_> {
    fn words(&self, attribute: &str) -> Result<String, Problem> {
        let found = self.surface.attribute(attribute).ok().as_ref().and_then(hdf5::words);
        found.ok_or_else(|| impossible(self.name, format!("does not say the `{attribute}` of its heights")))
    }

    /// A number that may be missing but must be believable.
    fn optional(&self, attribute: &str, range: (f64, f64)) -> Result<Option<f64>, Problem> {
        let Ok(found) = self.surface.attribute(attribute) else { return Ok(None) };
        match hdf5::number(&found) {
            Some(value) => within(self.name, &format!("`{attribute}`"), value, range).map(Some),
            None => Err(impossible(self.name, format!("says a `{attribute}` that is no number"))),
        }
    }

    /// Metres a pixel along an axis; `None` where it was not calibrated.
    fn pitch(&self, attribute: &str) -> Result<Option<f64>, Problem> {
        let Ok(found) = self.surface.attribute(attribute) else { return Ok(None) };
        let part = |field: &str| {
            hdf5::field(&found, field)
                .ok_or_else(|| impossible(self.name, format!("has no `{field}` in its `{attribute}`")))
        };
        let unit = hdf5::long_text(self.surface, part("BaseUnit")?).unwrap_or_default();
        if unit != "Pixels" {
            return Err(unknown_unit(self.name, "columns and rows", &unit));
        }
        let parameters = hdf5::list(self.surface, part("Parameters")?).unwrap_or_default();
        match parameters.get(1).copied() {
            None | Some(0.0) => Ok(None),
            Some(pitch) => within(self.name, &format!("pixel in `{attribute}`"), pitch, PITCHES).map(Some),
        }
    }
}

fn sign_inverted(file: &File) -> bool {
    file.attributes_below("/Attributes")
        .iter()
        .any(|attribute| attribute.name.ends_with(SIGN) && hdf5::number(attribute).is_some_and(|sign| sign != 0.0))
}
