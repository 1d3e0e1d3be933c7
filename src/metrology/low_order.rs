//! Low order: piston, tilt, power and the aberrations after them, by least squares.
//!
//! In: a grid, which of its pixels count, which terms to take off. Out: the grid without them, and what they were.
//!
//! The terms are the first eleven Zernike polynomials in Noll's order, made orthogonal over the pixels that count, in
//! this order: piston is the mean, tilt the rest of the least-squares plane, power what x² + y² has beyond a plane,
//! astigmatism what its two polynomials have beyond all these, and so on over coma and trefoil to spherical. So each is
//! found as if all lower ones were fitted with it, taking several off is the joint least-squares fit, and a term
//! that is not taken off is kept exactly: without `piston` the mean stays, without `tilt` the plane. Centre and radius
//! of the polynomials do not matter for what is taken off.

use super::fit::Fit;
use crate::height_map::Grid;
use crate::job::{Term, ZernikeOrder};
use crate::workpiece::form::zernike::Basis;

/// What was taken off. Zero for a term that was kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LowOrder {
    /// Metres: the mean.
    pub piston: f64,
    /// Slopes along x and y, metres a metre.
    pub tilt: [f64; 2],
    /// Factor of x² + y², one over metres.
    pub power: f64,
    /// Root mean square of what else was taken off, over the pixels that count: astigmatism, coma, trefoil, spherical; metres.
    pub aberrations: f64,
}

/// A least-squares plane `mean + slope · (place - centre)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    pub centre: [f64; 2],
    pub mean: f64,
    pub slope: [f64; 2],
}

impl Plane {
    /// Its height at a place, metres.
    pub fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.mean + self.slope[0] * (x - self.centre[0]) + self.slope[1] * (y - self.centre[1])
    }
}

/// Smallest spread of the pixels across the direction in which they are narrowest, against that along it, from which a
/// plane is still taken: below it the pixels lie on a line, and the tilt across is made of rounding.
const NARROWEST: f64 = 1e-6;

/// Sums about the centroid; lengths in units of the grid's width, so that all sums are near one.
struct Moments {
    count: f64,
    scale: f64,
    centre: [f64; 2],
    mean: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

/// Calls `see(x, y, value)` for every known pixel that counts, in order.
fn each(grid: &Grid, counts: &[bool], mut see: impl FnMut(f64, f64, f64)) {
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let i = row * grid.columns + column;
            if !grid.values[i].is_nan() && counts[i] {
                let [x, y] = grid.position(row, column);
                see(x, y, grid.values[i]);
            }
        }
    }
}

fn moments(grid: &Grid, counts: &[bool]) -> Option<Moments> {
    let scale = (grid.columns as f64 * grid.pixel[0]).max(grid.rows as f64 * grid.pixel[1]);
    let (mut n, mut sx, mut sy, mut sz) = (0.0, 0.0, 0.0, 0.0);
    each(grid, counts, |x, y, z| {
        n += 1.0;
        sx += x / scale;
        sy += y / scale;
        sz += z;
    });
    if n < 3.0 {
        return None;
    }
    let centre = [sx / n, sy / n];
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    each(grid, counts, |x, y, _| {
        let (u, v) = (x / scale - centre[0], y / scale - centre[1]);
        xx += u * u;
        xy += u * v;
        yy += v * v;
    });
    let moments = Moments { count: n, scale, centre, mean: sz / n, xx, xy, yy };
    let (trace, determinant) = (xx + yy, xx * yy - xy * xy);
    // Smaller over larger principal moment is about determinant / trace².
    (determinant > NARROWEST * NARROWEST * trace * trace).then_some(moments)
}

impl Moments {
    fn place(&self, x: f64, y: f64) -> (f64, f64) {
        (x / self.scale - self.centre[0], y / self.scale - self.centre[1])
    }

    /// The slopes `s` with `[xx xy; xy yy] s = b`.
    fn solve(&self, b: [f64; 2]) -> [f64; 2] {
        let determinant = self.xx * self.yy - self.xy * self.xy;
        [(self.yy * b[0] - self.xy * b[1]) / determinant, (self.xx * b[1] - self.xy * b[0]) / determinant]
    }

    fn slope(&self, grid: &Grid, counts: &[bool]) -> [f64; 2] {
        let mut b = [0.0; 2];
        each(grid, counts, |x, y, z| {
            let (u, v) = self.place(x, y);
            b[0] += u * (z - self.mean);
            b[1] += v * (z - self.mean);
        });
        self.solve(b)
    }
}

/// The least-squares plane through the known pixels marked in `counts`; `None` if these are fewer than three or
/// lie on a line.
pub fn plane_through(grid: &Grid, counts: &[bool]) -> Option<Plane> {
    let m = moments(grid, counts)?;
    let [a, b] = m.slope(grid, counts);
    Some(Plane {
        centre: [m.centre[0] * m.scale, m.centre[1] * m.scale],
        mean: m.mean,
        slope: [a / m.scale, b / m.scale],
    })
}

/// Takes the `terms` off the whole grid; they are found over the known pixels marked in `counts`. `None` (and a grid of
/// which nothing more is to be made) if these do not fix the terms: fewer than three or on a line, or, for power, all on
/// one circle.
pub fn subtract(grid: &mut Grid, counts: &[bool], terms: &[Term]) -> Option<LowOrder> {
    if terms.is_empty() {
        return Some(LowOrder::default());
    }
    let has = |term| terms.contains(&term);
    let m = moments(grid, counts)?;
    let slope = m.slope(grid, counts);
    // x² + y² without what a plane takes of it.
    let (mut mean, mut b) = (0.0, [0.0; 2]);
    each(grid, counts, |x, y, _| {
        let (u, v) = m.place(x, y);
        mean += (u * u + v * v) / m.count;
        b[0] += u * (u * u + v * v);
        b[1] += v * (u * u + v * v);
    });
    let [pu, pv] = m.solve(b);
    let bowl = |u: f64, v: f64| u * u + v * v - mean - pu * u - pv * v;
    let mut bowl_factor = 0.0;
    if has(Term::power) {
        let (mut with_z, mut with_itself) = (0.0, 0.0);
        each(grid, counts, |x, y, z| {
            let (u, v) = m.place(x, y);
            with_z += bowl(u, v) * (z - m.mean);
            with_itself += bowl(u, v) * bowl(u, v);
        });
        let spread = m.xx + m.yy;
        if with_itself * m.count <= NARROWEST * NARROWEST * spread * spread {
            return None;
        }
        bowl_factor = with_z / with_itself;
    }
    let piston = if has(Term::piston) { m.mean } else { 0.0 };
    let [su, sv] = if has(Term::tilt) { slope } else { [0.0; 2] };
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let [x, y] = grid.position(row, column);
            let (u, v) = m.place(x, y);
            grid.values[row * grid.columns + column] -= piston + su * u + sv * v + bowl_factor * bowl(u, v);
        }
    }
    let squared = m.scale * m.scale;
    let low = LowOrder { piston, tilt: [su / m.scale, sv / m.scale], power: bowl_factor / squared, aberrations: 0.0 };
    let aberrations =
        if terms.iter().any(|term| *term > Term::power) { aberrations(grid, counts, &m, terms)? } else { 0.0 };
    Some(LowOrder { aberrations, ..low })
}

/// The term that each of Noll's first eleven polynomials belongs to.
const NOLL: [Term; 11] = {
    use Term::{astigmatism, coma, piston, power, spherical, tilt, trefoil};
    [piston, tilt, tilt, power, astigmatism, astigmatism, coma, coma, trefoil, trefoil, spherical]
};

/// Takes those of the `terms` off that stand after power. The root mean square of what that was.
fn aberrations(grid: &mut Grid, counts: &[bool], m: &Moments, terms: &[Term]) -> Option<f64> {
    let basis = Basis::new(ZernikeOrder::noll, NOLL.len());
    // Over the grid's half width around the centroid, so that the polynomials are near one.
    let at = |[x, y]: [f64; 2], values: &mut [f64]| {
        let (u, v) = m.place(x, y);
        basis.at(2.0 * u, 2.0 * v, values);
    };
    let wanted = |k: usize| NOLL[k] > Term::power && terms.contains(&NOLL[k]);
    let coefficients = Fit::over(grid, counts, NOLL.len(), at).coefficients(wanted)?;
    let (mut squares, mut values) = (0.0, [0.0; NOLL.len()]);
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let i = row * grid.columns + column;
            if grid.values[i].is_nan() {
                continue;
            }
            at(grid.position(row, column), &mut values);
            let sum: f64 = coefficients.iter().zip(values).map(|(a, z)| a * z).sum();
            grid.values[i] -= sum;
            if counts[i] {
                squares += sum * sum;
            }
        }
    }
    Some((squares / m.count).sqrt())
}
