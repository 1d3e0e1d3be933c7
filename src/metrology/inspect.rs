//! Inspect: what is in a height map, for `polishc inspect`.
//!
//! In: the bytes of a file, and pixel and unit where the file does not say them. Out: [`Inspection`], which serialises to
//! the JSON that the command line promises. The picture is taken as it is: no orientation, sign or quantity of a job.

use super::{Figures, low_order, pvr};
use crate::diagnostics::Problem;
use crate::height_map::{Grid, read};
use crate::job::{Term, ZernikeOrder};
use serde::Serialize;

/// Facts of one height map. Lengths are rounded to what can be meant: figures to 0.001 nm, pixels to 0.000001 mm.
/// RMS is about the mean over valid pixels; "detilted" is without the least-squares plane of the valid pixels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    pub kind: &'static str,
    pub format: &'static str,
    pub rows: usize,
    pub columns: usize,
    /// Pitch along rows and along columns.
    pub pixel_mm: [f64; 2],
    pub valid: usize,
    pub invalid: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelength_nm: Option<f64>,
    pub pv_nm: f64,
    pub rms_nm: f64,
    /// `null` where fewer than three valid pixels, or pixels on a line, have no plane.
    pub pv_detilted_nm: Option<f64>,
    pub rms_detilted_nm: Option<f64>,
    /// Robust peak to valley with the 36 Fringe polynomials, of the detilted map; `null` where the pixels do not fix them.
    pub pvr_fringe36_nm: Option<f64>,
    pub blake3: String,
}

/// Looks into a height map. `unit` (metres for the value 1) and `pixel` (metres) where the file does not say them. Fields
/// are `file`, `unit`, `pixel`. Errors as of [`read`], and E0506, E0507, E0508, E0511.
pub fn inspect(bytes: &[u8], name: &str, unit: Option<f64>, pixel: Option<f64>) -> Result<Inspection, Problem> {
    let raw = read(bytes, name)?;
    let pixel = raw.pixel_pitch(pixel)?;
    let mut grid = Grid { columns: raw.columns, rows: raw.rows, pixel, origin: [0.0; 2], values: raw.heights(unit)? };
    let figures = Figures::of(grid.values.iter().copied());
    let everywhere = vec![true; grid.values.len()];
    let detilted = low_order::subtract(&mut grid, &everywhere, &[Term::piston, Term::tilt])
        .map(|_| Figures::of(grid.values.iter().copied()));
    let robust = detilted.and_then(|_| pvr(&grid, &everywhere, ZernikeOrder::fringe));
    let nanometres = |metres: f64| rounded(metres * 1e9, 1e3);
    Ok(Inspection {
        kind: "height_map",
        format: raw.format.name(),
        rows: raw.rows,
        columns: raw.columns,
        pixel_mm: pixel.map(|side| rounded(side * 1e3, 1e6)),
        valid: figures.count,
        invalid: grid.values.len() - figures.count,
        wavelength_nm: raw.wavelength.map(nanometres),
        pv_nm: nanometres(figures.pv),
        rms_nm: nanometres(figures.rms),
        pv_detilted_nm: detilted.map(|figures| nanometres(figures.pv)),
        rms_detilted_nm: detilted.map(|figures| nanometres(figures.rms)),
        pvr_fringe36_nm: robust.map(|figures| nanometres(figures.pvr)),
        blake3: blake3::hash(bytes).to_hex().to_string(),
    })
}

/// To the nearest whole number of `1 / per_unit`.
fn rounded(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}
