//! What is known of the error of the form, and what is to be said of it.

use super::{Aperture, Direction, Place, Positive, Quantity, View, ZernikeOrder};
use crate::units::si::*;
use serde::{Deserialize, Serialize};

/// How the surface departs from its form.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum FormError {
    height_map(Box<HeightMap>),
    zernike_error(ZernikeError),
    average(Average),
    difference(Box<Difference>),
    stitched(Stitched),
}

impl FormError {
    /// The maps that say how the part stands now: what a run on the glass makes void. Not those that are only taken off.
    pub fn measurements(&self) -> Vec<&HeightMap> {
        match self {
            FormError::height_map(map) => vec![map],
            FormError::zernike_error(_) => Vec::new(),
            FormError::average(average) => average.of.iter().flat_map(FormError::measurements).collect(),
            FormError::difference(difference) => difference.of.measurements(),
            FormError::stitched(stitched) => stitched.maps.iter().flat_map(FormError::measurements).collect(),
        }
    }

    /// All data files that it is made from, in the order in which the job says them.
    pub fn files(&self) -> Vec<&str> {
        match self {
            FormError::height_map(map) => std::iter::once(map.file.as_str()).chain(map.mask.as_deref()).collect(),
            FormError::zernike_error(_) => Vec::new(),
            FormError::average(average) => average.of.iter().flat_map(FormError::files).collect(),
            FormError::difference(difference) => [difference.of.files(), difference.minus.files()].concat(),
            FormError::stitched(stitched) => stitched.maps.iter().flat_map(FormError::files).collect(),
        }
    }
}

/// A measured map of heights, as the job describes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeightMap {
    /// Whole path, resolved by `eval`.
    pub file: String,
    pub quantity: Quantity,
    pub positive: Positive,
    pub view: View,
    pub up: Direction,
    /// How far the part was turned, from +x towards +y of the part, beyond what `up` says.
    pub rotated: Option<Angle>,
    pub subtract: Vec<Term>,
    /// Side of one pixel, where the file does not say it; in a file that says it, both must agree.
    pub pixel: Option<Length>,
    /// The height that the value 1 means, where the file does not say it (`unit: 1 nm`).
    pub unit: Option<Length>,
    pub centre: MapCentre,
    /// Where the part's marks lie in the picture.
    pub fiducials: Option<Registration>,
    /// Whole path of a picture of the same size: pixels that are zero or invalid in it are left out.
    pub mask: Option<String>,
    /// Areas of the part that are left out.
    pub leave_out: Option<Vec<Aperture>>,
    /// Pixels nearer than this to the border of what was seen are left out.
    pub trim: Option<Length>,
    pub despike: Option<Despike>,
    /// Holes (connected invalid pixels inside what is needed) up to this area are filled; larger ones refuse the map.
    pub fill_below: Option<Area>,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Term {
    piston,
    tilt,
    power,
    astigmatism,
    coma,
    trefoil,
    spherical,
}

/// A mark on the part whose place is known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fiducial {
    pub name: String,
    pub at: Place,
}

/// The part's marks as they are seen in a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Registration {
    pub marks: Vec<Mark>,
    /// Farthest that a mark may lie from where the fit puts it.
    pub within: Length,
}

/// Where a mark of the part lies in the picture as the file shows it, in pixels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mark {
    pub name: String,
    pub column: f64,
    pub row: f64,
}

/// What counts as a spike.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Despike {
    /// In robust standard deviations.
    pub above: f64,
    /// Pixels to each side that a pixel is compared with.
    pub reach: i64,
}

/// Where the part's (or the tool's) origin lies in the picture.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum MapCentre {
    /// The middle of the picture.
    frame_centre(Empty),
    /// The middle of the box around the valid pixels.
    valid_centre(Empty),
    /// A pixel: column from the left, row from the top of the picture as the file shows it, both from 0, centres of
    /// pixels at whole numbers.
    pixel_at(PixelAt),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Empty {}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PixelAt {
    pub column: f64,
    pub row: f64,
}

/// An error that is known as Zernike polynomials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ZernikeError {
    pub positive: Positive,
    /// The radius that the polynomials are normalised on, about the part's origin.
    pub radius: Length,
    pub order: ZernikeOrder,
    /// From the first polynomial of the order on.
    pub coefficients: Vec<Length>,
    /// Side of the pixels that it is laid on.
    pub pixel: Length,
}

/// The mean of several maps of the same part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Average {
    pub of: Vec<FormError>,
}

/// A map without what another one says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Difference {
    pub of: FormError,
    pub minus: FormError,
}

/// Maps of pieces of the part, put together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stitched {
    pub maps: Vec<FormError>,
    pub subtract: Vec<Term>,
    /// Largest RMS of the difference of two maps where they overlap.
    pub mismatch: Length,
}

/// Figures that the report is to hold, and that `require` may speak of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figures {
    pub zernike: Option<ZernikeOrder>,
    /// The length that slopes are taken over.
    pub slope_length: Option<Length>,
    /// Shortest and longest period of the band.
    pub band: Option<Range<Length>>,
}
