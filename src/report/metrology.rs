//! What a build says of its maps: how they came to lie on the part, and the figures that the job asks for.
//!
//! In: the [`ErrorMap`] and its [`SurfaceFigures`]. Out: the `metrology` of `result.json`. Every figure stands with its mask, the
//! terms that were taken off for it, and its definition.

use super::{DEGREES, rounded};
use crate::job::{Figures, ZernikeOrder};
use crate::metrology::{ErrorMap, LowOrder, MapRecord, Profile, Psd, Registered, Seam, StitchedRecord, SurfaceFigures};
use serde::Serialize;

/// The `metrology` of a job's result.
#[derive(Clone, Debug, Serialize)]
pub struct MetrologyResult {
    /// Every map, in the order of the job.
    pub maps: Vec<MapResult>,
    /// Every map that was made of pieces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stitched: Vec<StitchedResult>,
    /// Standard deviation of one map among those averaged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread_nm: Option<f64>,
    pub filled_holes: usize,
    pub filled_area_mm2: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub figures: Option<FiguresResult>,
}

/// One file.
#[derive(Clone, Debug, Serialize)]
pub struct MapResult {
    pub file: String,
    /// Known pixels that `mask`, `trim` and `despike` took out.
    pub masked: usize,
    pub trimmed: usize,
    pub spikes: usize,
    #[serde(flatten)]
    pub removed: RemovedResult,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub registration: Option<RegistrationResult>,
}

/// What `subtract` took off.
#[derive(Clone, Debug, Serialize)]
pub struct RemovedResult {
    pub piston_nm: f64,
    pub tilt_urad: [f64; 2],
    /// Factor of x² + y².
    pub power_per_m: f64,
    /// Root mean square of astigmatism, coma, trefoil and spherical, as far as they were named.
    pub aberrations_nm: f64,
}

/// How the marks put a map on the part, against the declared orientation.
#[derive(Clone, Debug, Serialize)]
pub struct RegistrationResult {
    pub marks: usize,
    pub scale: f64,
    pub turned_deg: f64,
    pub shift_mm: [f64; 2],
    pub residual_rms_mm: f64,
    pub residual_max_mm: f64,
}

/// One map that was made of pieces.
#[derive(Clone, Debug, Serialize)]
pub struct StitchedResult {
    /// Where the job says it, such as `workpiece.error`.
    pub field: String,
    pub seams: Vec<SeamResult>,
    #[serde(flatten)]
    pub removed: RemovedResult,
}

/// One overlap of two pieces.
#[derive(Clone, Debug, Serialize)]
pub struct SeamResult {
    /// Which of the stitched map's `maps`, from 1.
    pub maps: [usize; 2],
    pub pixels: usize,
    pub rms_nm: f64,
}

/// The figures that the job asks for, of the error map (`before`) and of what is predicted to be left (`predicted`).
#[derive(Clone, Debug, Serialize)]
pub struct FiguresResult {
    /// The pixels that they are taken over.
    pub mask: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pvr: Option<FigureResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zernike: Option<ZernikeResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slope_rms: Option<FigureResult>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band_rms: Option<FigureResult>,
}

#[derive(Clone, Debug, Serialize)]
pub struct FigureResult {
    pub definition: String,
    /// What was taken off first.
    pub removed: &'static str,
    pub unit: &'static str,
    pub before: f64,
    pub predicted: f64,
}

/// Coefficients, from the first polynomial of the order on.
#[derive(Clone, Debug, Serialize)]
pub struct ZernikeResult {
    pub definition: &'static str,
    pub removed: &'static str,
    pub order: &'static str,
    pub radius_mm: f64,
    pub centre_mm: [f64; 2],
    pub before_nm: Vec<f64>,
    pub predicted_nm: Vec<f64>,
}

/// `NAME.psd.json`: power spectral densities of the error map and of what is predicted to be left.
#[derive(Clone, Debug, Serialize)]
pub struct Spectra {
    pub mask: &'static str,
    pub removed: &'static str,
    pub window: &'static str,
    pub before: Spectrum,
    pub predicted: Spectrum,
}

/// One map's densities.
#[derive(Clone, Debug, Serialize)]
pub struct Spectrum {
    /// Of the windowed map: the integral of each of the one-dimensional densities.
    pub mean_square_nm2: f64,
    /// One-sided, of profiles along x and along y, averaged over the profiles.
    pub along_x: Density,
    pub along_y: Density,
    /// The two-dimensional density, averaged over rings of equal frequency.
    pub radial: Density,
}

#[derive(Clone, Debug, Serialize)]
pub struct Density {
    /// Cycles a millimetre.
    pub frequency_per_mm: Vec<f64>,
    pub unit: &'static str,
    pub density: Vec<f64>,
}

/// Of the error map and of what is predicted to be left.
pub fn spectra(before: &Psd, predicted: &Psd) -> Spectra {
    // Six digits: more than window and pixels let mean.
    let digits = |value: f64| format!("{value:.5e}").parse().unwrap_or(value);
    let density = |profile: Profile, unit, scale: f64| Density {
        frequency_per_mm: profile.frequency.iter().map(|f| rounded(f * 1e-3, 6)).collect(),
        unit,
        density: profile.density.iter().map(|value| digits(value * scale)).collect(),
    };
    let spectrum = |psd: &Psd| Spectrum {
        mean_square_nm2: digits(psd.mean_square() * 1e18),
        along_x: density(psd.along_x(), "nm^2 mm", 1e21),
        along_y: density(psd.along_y(), "nm^2 mm", 1e21),
        radial: density(psd.radial(), "nm^2 mm^2", 1e24),
    };
    Spectra {
        mask: INSIDE,
        removed: LOW_ORDERS,
        window: "square of a sine of the distance to the mask's border, one from a quarter of the largest distance on",
        before: spectrum(before),
        predicted: spectrum(predicted),
    }
}

/// What `require` may ask for, in SI, by its path without `result.`.
pub fn results(predicted: &SurfaceFigures) -> impl Iterator<Item = (String, f64)> {
    [
        ("predicted.pvr", predicted.pvr),
        ("predicted.slope_rms", predicted.slope_rms),
        ("predicted.band_rms", predicted.band_rms),
    ]
    .into_iter()
    .filter_map(|(name, value)| Some((name.to_string(), value?)))
}

/// Of the map; `shown` gives a file's name as the result has it.
pub fn result(
    map: &ErrorMap,
    figures: Option<(&Figures, &[SurfaceFigures; 2])>,
    shown: impl Fn(&str) -> String,
) -> MetrologyResult {
    MetrologyResult {
        maps: map.record.maps.iter().map(|record| one_map(record, shown(&record.file))).collect(),
        stitched: map.record.stitched.iter().map(stitched).collect(),
        spread_nm: map.record.spread.map(|spread| rounded(spread * 1e9, 3)),
        filled_holes: map.filled_holes,
        filled_area_mm2: rounded(map.filled_area * 1e6, 3),
        figures: figures.map(|(asked, found)| figures_result(asked, found)),
    }
}

fn one_map(record: &MapRecord, file: String) -> MapResult {
    MapResult {
        file,
        masked: record.masked,
        trimmed: record.trimmed,
        spikes: record.spikes,
        removed: removed(&record.removed),
        registration: record.registered.as_ref().map(registration),
    }
}

fn removed(removed: &LowOrder) -> RemovedResult {
    RemovedResult {
        piston_nm: rounded(removed.piston * 1e9, 3),
        tilt_urad: removed.tilt.map(|slope| rounded(slope * 1e6, 4)),
        power_per_m: rounded(removed.power, 9),
        aberrations_nm: rounded(removed.aberrations * 1e9, 3),
    }
}

fn stitched(record: &StitchedRecord) -> StitchedResult {
    let seam = |seam: &Seam| SeamResult {
        maps: seam.pieces.map(|piece| piece + 1),
        pixels: seam.pixels,
        rms_nm: rounded(seam.rms * 1e9, 3),
    };
    StitchedResult {
        field: record.field.clone(),
        seams: record.seams.iter().map(seam).collect(),
        removed: removed(&record.removed),
    }
}

fn registration(registered: &Registered) -> RegistrationResult {
    RegistrationResult {
        marks: registered.marks,
        scale: rounded(registered.similarity.scale, 6),
        turned_deg: rounded(registered.turned * DEGREES, 4),
        shift_mm: registered.similarity.shift.map(|metres| rounded(metres * 1e3, 4)),
        residual_rms_mm: rounded(registered.residual_rms * 1e3, 4),
        residual_max_mm: rounded(registered.residual_max * 1e3, 4),
    }
}

const PISTON_AND_TILT: &str = "piston, tilt";
const LOW_ORDERS: &str = "piston, tilt, power, astigmatism, coma, trefoil, spherical";
const INSIDE: &str = "pixels whose centre lies inside the clear aperture";

fn figures_result(asked: &Figures, [before, predicted]: &[SurfaceFigures; 2]) -> FiguresResult {
    let order = match asked.zernike {
        Some(ZernikeOrder::fringe) => "fringe",
        Some(ZernikeOrder::noll) => "noll",
        Some(ZernikeOrder::ansi) => "ansi",
        None => "",
    };
    let pair = |of: fn(&SurfaceFigures) -> Option<f64>, scale: f64| {
        let of = |figures| of(figures).map(|value| rounded(value * scale, 4));
        of(before).zip(of(predicted))
    };
    let figure = |values: Option<(f64, f64)>, unit, removed, definition: String| {
        values.map(|(before, predicted)| FigureResult { definition, removed, unit, before, predicted })
    };
    let millimetres = |length: f64| rounded(length * 1e3, 6);
    FiguresResult {
        mask: INSIDE,
        pvr: figure(
            pair(|figures| figures.pvr, 1e9),
            "nm",
            PISTON_AND_TILT,
            format!("peak to valley of the fit with 36 {order} polynomials, and 3 times the RMS of what it leaves"),
        ),
        zernike: before.zernike.as_ref().zip(predicted.zernike.as_ref()).map(|(before, predicted)| {
            let nanometres = |a: &[f64]| a.iter().map(|a| rounded(a * 1e9, 4)).collect();
            ZernikeResult {
                definition: "joint least-squares fit of the full disc's polynomials over the mask, whatever its outline",
                removed: PISTON_AND_TILT,
                order,
                radius_mm: millimetres(before.radius),
                centre_mm: before.centre.map(millimetres),
                before_nm: nanometres(&before.coefficients),
                predicted_nm: nanometres(&predicted.coefficients),
            }
        }),
        slope_rms: figure(
            pair(|figures| figures.slope_rms, 1e6),
            "urad",
            PISTON_AND_TILT,
            format!(
                "root mean square of the gradient by central differences over {} mm",
                asked.slope_length.map_or(0.0, |length| millimetres(length.0))
            ),
        ),
        band_rms: figure(
            pair(|figures| figures.band_rms, 1e9),
            "nm",
            LOW_ORDERS,
            asked.band.as_ref().map_or_else(String::new, |band| {
                format!(
                    "root of the integral of the two-dimensional power spectral density over periods from {} mm to {} mm, \
                     windowed at the border",
                    millimetres(band.from.0),
                    millimetres(band.to.0)
                )
            }),
        ),
    }
}
