//! Inspect: what is in a file of heights, for `polishc inspect`.
//!
//! In: the bytes of a file, and pixel and unit where the file does not say them. Out: [`Inspection`], which serialises to
//! the JSON that the command line promises. The picture is taken as it is: no orientation, sign or quantity of a job.

use super::pvr::{Pvr, robust_fit};
use super::{Figures, low_order};
use crate::diagnostics::Problem;
use crate::height_map::{Content, Grid, Profile, RawMap, content};
use crate::job::{Term, ZernikeOrder};
use serde::Serialize;

/// What is in a file of heights.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Inspection {
    HeightMap(MapFacts),
    Profile(ProfileFacts),
}

/// Facts of one height map. Numbers are rounded to what can be meant: heights to 0.001 nm, pixels to six digits.
/// RMS is about the mean over valid pixels; "detilted" is without the least-squares plane of the valid pixels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapFacts {
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
    /// The first sixteen coefficients of that fit, over the circle around the valid pixels, +x to the right of the picture and
    /// +y upwards.
    pub zernike_fringe_nm: Option<Vec<f64>>,
    pub blake3: String,
}

/// Facts of one profile, rounded as those of a map are. "Detilted" is without the least-squares line of the valid points.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ProfileFacts {
    pub kind: &'static str,
    pub format: &'static str,
    /// From the first point to the last.
    pub length_mm: f64,
    pub valid: usize,
    pub invalid: usize,
    pub pv_nm: f64,
    pub rms_nm: f64,
    /// `null` where the valid points have one position.
    pub pv_detilted_nm: Option<f64>,
    pub rms_detilted_nm: Option<f64>,
    pub blake3: String,
}

/// Looks into a file of heights. `unit` (metres for the value 1) and `pixel` (metres; for a profile the step from point to
/// point) where the file does not say them. Fields are `file`, `unit`, `pixel`. Errors as of [`content`], and E0506, E0507,
/// E0508, E0511.
pub fn inspect(bytes: &[u8], name: &str, unit: Option<f64>, pixel: Option<f64>) -> Result<Inspection, Problem> {
    let blake3 = blake3::hash(bytes).to_hex().to_string();
    match content(bytes, name)? {
        Content::Map(raw) => map_facts(&raw, unit, pixel, blake3).map(Inspection::HeightMap),
        Content::Profile(profile) => profile_facts(&profile, unit, pixel, blake3).map(Inspection::Profile),
    }
}

fn map_facts(raw: &RawMap, unit: Option<f64>, pixel: Option<f64>, blake3: String) -> Result<MapFacts, Problem> {
    let pixel = raw.pixel_pitch(pixel)?;
    let mut grid = Grid { columns: raw.columns, rows: raw.rows, pixel, origin: [0.0; 2], values: raw.heights(unit)? };
    // Row 0 is the top of the picture, and +y points upwards in it.
    let lines: Vec<f64> = grid.values.chunks_exact(grid.columns).rev().flatten().copied().collect();
    grid.values = lines;
    let figures = Figures::of(grid.values.iter().copied());
    let everywhere = vec![true; grid.values.len()];
    let detilted = low_order::subtract(&mut grid, &everywhere, &[Term::piston, Term::tilt])
        .map(|_| Figures::of(grid.values.iter().copied()));
    let robust = detilted.and_then(|_| robust_fit(&grid, &everywhere, ZernikeOrder::fringe));
    Ok(MapFacts {
        kind: "height_map",
        format: raw.format.name(),
        rows: raw.rows,
        columns: raw.columns,
        pixel_mm: pixel.map(|side| six_digits(side * 1e3)),
        valid: figures.count,
        invalid: grid.values.len() - figures.count,
        wavelength_nm: raw.wavelength.map(nanometres),
        pv_nm: nanometres(figures.pv),
        rms_nm: nanometres(figures.rms),
        pv_detilted_nm: detilted.map(|figures| nanometres(figures.pv)),
        rms_detilted_nm: detilted.map(|figures| nanometres(figures.rms)),
        pvr_fringe36_nm: robust.as_ref().map(|fit| nanometres(Pvr::of(fit).pvr)),
        zernike_fringe_nm: robust.map(|fit| fit.coefficients.iter().take(16).map(|a| nanometres(*a)).collect()),
        blake3,
    })
}

fn profile_facts(
    profile: &Profile,
    unit: Option<f64>,
    step: Option<f64>,
    blake3: String,
) -> Result<ProfileFacts, Problem> {
    let (positions, heights) = profile.metres(unit, step)?;
    let figures = Figures::of(heights.iter().copied());
    let detilted = without_line(&positions, &heights).map(|rest| Figures::of(rest.into_iter()));
    let length = positions.last().zip(positions.first()).map_or(0.0, |(last, first)| (last - first).abs());
    Ok(ProfileFacts {
        kind: "profile",
        format: profile.format.name(),
        length_mm: six_digits(length * 1e3),
        valid: figures.count,
        invalid: heights.len() - figures.count,
        pv_nm: nanometres(figures.pv),
        rms_nm: nanometres(figures.rms),
        pv_detilted_nm: detilted.map(|figures| nanometres(figures.pv)),
        rms_detilted_nm: detilted.map(|figures| nanometres(figures.rms)),
        blake3,
    })
}

/// The valid heights without their least-squares line; `None` if they all stand at one position.
fn without_line(positions: &[f64], heights: &[f64]) -> Option<Vec<f64>> {
    let valid: Vec<(f64, f64)> = positions
        .iter()
        .zip(heights)
        .filter(|(position, height)| position.is_finite() && !height.is_nan())
        .map(|(position, height)| (*position, *height))
        .collect();
    let count = valid.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| valid.iter().map(of).sum::<f64>() / count;
    let middle = [mean(&|point| point.0), mean(&|point| point.1)];
    let spread = mean(&|point| (point.0 - middle[0]) * (point.0 - middle[0]));
    if !(spread > 0.0) {
        return None;
    }
    let slope = mean(&|point| (point.0 - middle[0]) * (point.1 - middle[1])) / spread;
    Some(valid.iter().map(|(position, height)| height - middle[1] - slope * (position - middle[0])).collect())
}

/// Metres in nanometres, to the picometre.
fn nanometres(metres: f64) -> f64 {
    // Adding zero turns -0.0 into 0.0.
    rounded(metres * 1e9, 1e3) + 0.0
}

/// Six digits, wherever the point stands: pixels are measured from tenths of a micrometre to centimetres.
fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// To the nearest whole number of `1 / per_unit`.
fn rounded(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}
