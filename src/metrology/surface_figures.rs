//! Surface figures: what a drawing asks of a surface beside RMS and PV.
//!
//! In: a map, the clear aperture, and which figures the job asks for. Out: [`SurfaceFigures`]. All are taken over the
//! known pixels whose centre lies inside the clear aperture. PVr and the polynomials are of the map without piston and tilt, slopes
//! are about their mean along each axis, and of the band all of the eleven lowest polynomials of Noll are, since what they leak would be taken for waves.

use super::{Psd, ZernikeFit, low_order, psd, pvr, slope_rms, zernike_fit};
use crate::diagnostics::{Problem, codes};
use crate::height_map::Grid;
use crate::job::{self, Aperture, Term};

/// Polynomials of the fit: both PVr and the report have 36.
const TERMS: usize = 36;

/// What the band's figure and the spectrum take off.
const LOW_ORDERS: [Term; 7] = {
    use Term::{astigmatism, coma, piston, power, spherical, tilt, trefoil};
    [piston, tilt, power, astigmatism, coma, trefoil, spherical]
};

/// Figures that were asked for; lengths in metres, slopes in radians.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceFigures {
    /// Robust peak to valley.
    pub pvr: Option<f64>,
    /// Normalised on the smallest circle about the clear aperture's centre that holds it.
    pub zernike: Option<ZernikeFit>,
    /// Of the gradient, over the length that the job states.
    pub slope_rms: Option<f64>,
    /// Of the periods that the job states, in all directions.
    pub band_rms: Option<f64>,
}

/// How the mean square of a map over the clear aperture is shared out over frequencies, its low orders taken off. `None` where
/// its pixels do not fix these.
pub fn spectrum(grid: &Grid, clear: &Aperture) -> Option<Psd> {
    let inside = super::cover::inside(grid, clear);
    let mut map = grid.clone();
    low_order::subtract(&mut map, &inside, &LOW_ORDERS)?;
    psd(&map, &inside)
}

/// Of `grid`. Fields are `figures.…`.
///
/// # Errors
/// E0546 for a figure that the pixels cannot give.
pub fn surface_figures(grid: &Grid, clear: &Aperture, asked: &job::Figures) -> Result<SurfaceFigures, Problem> {
    let inside = super::cover::inside(grid, clear);
    let mut found = SurfaceFigures::default();
    let [dx, dy] = grid.pixel;
    let coarsest = dx.max(dy);
    if let Some(order) = asked.zernike {
        let few = || cannot("zernike", format!("the pixels of the clear aperture do not fix {TERMS} polynomials"));
        let mut map = grid.clone();
        low_order::subtract(&mut map, &inside, &[Term::piston, Term::tilt]).ok_or_else(few)?;
        let fit = zernike_fit(&map, &inside, order, TERMS, clear.centre(), clear.outer_radius()).ok_or_else(few)?;
        found.pvr = Some(pvr(&map, &inside, order).ok_or_else(few)?.pvr);
        found.zernike = Some(fit);
    }
    if let Some(length) = asked.slope_length {
        if length.0 < coarsest * (1.0 - 1e-6) {
            let message =
                format!("slopes over {:.4} mm cannot be seen with pixels of {:.4} mm", length.0 * 1e3, coarsest * 1e3);
            return Err(cannot("slope_length", message).help("ask for slopes over at least a pixel"));
        }
        let slopes = slope_rms(grid, &inside, length.0).ok_or_else(|| {
            cannot("slope_length", format!("no two pixels of the clear aperture lie {:.4} mm apart", length.0 * 1e3))
        })?;
        found.slope_rms = Some(slopes.gradient);
    }
    if let Some(band) = asked.band {
        let (shortest, longest) = (band.from.0, band.to.0);
        let bounds = clear.bounds();
        let width = (bounds.max[0] - bounds.min[0]).min(bounds.max[1] - bounds.min[1]);
        if shortest < 2.0 * coarsest * (1.0 - 1e-6) || longest > width * (1.0 + 1e-6) {
            let message = format!(
                "a band from {:.4} mm to {:.4} mm cannot be seen: the pixels show periods from {:.4} mm, the clear aperture \
                 up to {:.4} mm",
                shortest * 1e3,
                longest * 1e3,
                2e3 * coarsest,
                width * 1e3
            );
            return Err(cannot("band", message).help("ask for a band between the two"));
        }
        let few = || cannot("band", "the pixels of the clear aperture do not fix its low orders".into());
        found.band_rms = Some(spectrum(grid, clear).ok_or_else(few)?.band_rms(shortest, longest));
    }
    Ok(found)
}

fn cannot(field: &str, message: String) -> Problem {
    Problem::error(codes::E0546, format!("figures.{field}"), message)
}
