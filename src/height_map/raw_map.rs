//! The raw map: a picture of heights as the file shows it, before the job says where it lies on the part.

use crate::diagnostics::{Problem, codes};
use crate::job::Quantity;

/// Formats of height maps and profiles that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    MetroPro,
    ZygoText,
    Datx,
    FourSight,
    CodeV,
    Zemax,
    X3p,
    Sdf,
    Npy,
    Table,
}

impl Format {
    /// The name in `polishc inspect`.
    pub fn name(self) -> &'static str {
        match self {
            Format::MetroPro => "metropro",
            Format::ZygoText => "zygo_text",
            Format::Datx => "datx",
            Format::FourSight => "4sight",
            Format::CodeV => "codev_int",
            Format::Zemax => "zemax_grid_sag",
            Format::X3p => "x3p",
            Format::Sdf => "sdf",
            Format::Npy => "npy",
            Format::Table => "table",
        }
    }
}

/// A picture of heights. Row 0 is the top of the picture, column 0 its left side; NaN marks invalid pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct RawMap {
    pub format: Format,
    pub columns: usize,
    pub rows: usize,
    /// Row-major from the top left. Metres where `in_metres`, else in the unit that the job must state.
    pub values: Vec<f64>,
    /// Whether the file says its vertical scale.
    pub in_metres: bool,
    /// Pitch of the pixels along rows and along columns, metres, where the file says it.
    pub pixel: Option<[f64; 2]>,
    /// Metres, where the file says it.
    pub wavelength: Option<f64>,
    /// What the values are, where the file says it: CODE V by a word, Zygo by its scale factor.
    pub quantity: Option<Quantity>,
    /// Zygo's remark that the sign was inverted when the data were taken.
    pub sign_inverted: bool,
}

/// How far a pixel stated by the job may differ from the file's own: one pixel in a thousand, which over the width of a
/// usual camera shifts no place by more than a pixel.
const PIXEL_AGREEMENT: f64 = 1e-3;

/// Largest believable height. No form error that is polished off by a dwell map comes near a centimetre; an array of
/// nanometres read as metres goes far beyond.
const LARGEST_HEIGHT: f64 = 0.01;

impl RawMap {
    /// A picture of which the file says nothing but the values, which fill the rows.
    pub fn plain(format: Format, columns: usize, rows: usize, values: Vec<f64>) -> RawMap {
        RawMap {
            format,
            columns,
            rows,
            values,
            in_metres: false,
            pixel: None,
            wavelength: None,
            quantity: None,
            sign_inverted: false,
        }
    }

    /// The pitch of the pixels along rows and along columns, metres: the file's own, or the one stated, which must agree
    /// where both exist. Fields are `pixel`. E0506 if nobody says it, E0507 if the two disagree.
    pub fn pixel_pitch(&self, stated: Option<f64>) -> Result<[f64; 2], Problem> {
        if let Some(pixel) = stated
            && !(pixel > 0.0 && pixel.is_finite())
        {
            let message = format!("the stated pixel is {:.6} mm; it must be positive", pixel * 1e3);
            return Err(Problem::error(codes::E0507, "pixel", message));
        }
        match (self.pixel, stated) {
            (Some(own), None) => Ok(own),
            (None, Some(pixel)) => Ok([pixel; 2]),
            (None, None) => {
                Err(Problem::error(codes::E0506, "pixel", "the map's file does not say how large a pixel is")
                    .help("state the side of one pixel: `pixel: 0.5 mm` (on the command line `--pixel 0.5mm`)"))
            }
            (Some(own), Some(pixel)) => {
                if own.iter().all(|side| (side / pixel - 1.0).abs() <= PIXEL_AGREEMENT) {
                    return Ok(own);
                }
                let message = format!(
                    "the map's file says that a pixel has {:.6} mm x {:.6} mm, but {:.6} mm is stated",
                    own[0] * 1e3,
                    own[1] * 1e3,
                    pixel * 1e3
                );
                Err(Problem::error(codes::E0507, "pixel", message)
                    .help("find out which is right; leave `pixel` out if the file is"))
            }
        }
    }

    /// All values in metres, NaN where invalid. `unit` is the height that the value 1 means. Fields are `unit`. E0506 if
    /// nobody says the unit, E0507 if it is stated although the file says its own.
    pub fn metres(&self, unit: Option<f64>) -> Result<Vec<f64>, Problem> {
        let scale = match (self.in_metres, unit) {
            (true, None) => 1.0,
            (false, Some(unit)) if unit > 0.0 && unit.is_finite() => unit,
            (false, Some(unit)) => {
                let message = format!("the stated unit is {:.6} nm; it must be positive", unit * 1e9);
                return Err(Problem::error(codes::E0507, "unit", message)
                    .help("the sense of the heights is said by `positive`, not by the sign of `unit`"));
            }
            (false, None) => {
                return Err(Problem::error(
                    codes::E0506,
                    "unit",
                    "the map's file does not say what its heights are measured in",
                )
                .help("state what the value 1 means: `unit: 1 nm` (on the command line `--unit 1nm`)"));
            }
            (true, Some(_)) => {
                return Err(Problem::error(
                    codes::E0507,
                    "unit",
                    "the map's file says its own scale, a unit beside it is one too many",
                )
                .help("leave `unit` out"));
            }
        };
        Ok(self.values.iter().map(|value| value * scale).collect())
    }

    /// [`metres`](Self::metres) of a form error. Fields are `unit`, or `file`. Beside its errors E0508 if no pixel is
    /// valid, E0511 if a height is infinite or beyond a centimetre.
    pub fn heights(&self, unit: Option<f64>) -> Result<Vec<f64>, Problem> {
        let heights = self.metres(unit)?;
        if heights.iter().all(|h| h.is_nan()) {
            return Err(Problem::error(codes::E0508, "file", "the map has no valid pixel")
                .help("look at the map on the instrument: the part was not seen, or was masked away"));
        }
        if let Some(at) = heights.iter().position(|h| h.abs() > LARGEST_HEIGHT) {
            let (row, column) = (at / self.columns, at % self.columns);
            let message = format!(
                "the height in row {row}, column {column} of the map is {:.3} mm; more than {:.0} mm is no form error",
                heights[at] * 1e3,
                LARGEST_HEIGHT * 1e3
            );
            let field = if self.in_metres { "file" } else { "unit" };
            return Err(Problem::error(codes::E0511, field, message)
                .help("check the unit; mark invalid pixels as NaN, not by a large number"));
        }
        Ok(heights)
    }
}
