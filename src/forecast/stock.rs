//! Stock: the glass that a run takes off, and what that does to the part's radius.
//!
//! In: the predicted removal, the nominal surface. Out: a [`Stock`]. Over the clear aperture, which is where the removal is known;
//! what goes on the way over the rim beyond it is not counted.
//!
//! The power of a removal is that of its best-fit sphere: to the removal along z, `d / n_z`, the sum
//! `piston + tilt x + tilt y + q s(r)` is fitted by least squares over the clear aperture, with `s = dz/dκ`, the height that a change of
//! the vertex curvature κ makes on a sphere of that curvature: with u = sqrt(1 - κ² r²) it is `r²/u - r²/(1 + u)`, on a flat `r²/2`. Taking
//! off a bowl (q < 0) makes a concave surface more so: the new curvature, positive for concave, is `κ - q`.

use crate::height_map::Grid;
use crate::job::{Aperture, Form, Side};
use crate::workpiece::form::Surface;

/// What a run takes off, over the clear aperture. Metres, m³.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stock {
    /// The greatest depth, along the normal.
    pub depth: f64,
    pub volume: f64,
    /// Sag of the best-fit sphere of the removal between the middle and the rim of the clear aperture: positive where the
    /// middle loses more, which makes a surface more concave.
    pub power: f64,
    /// Change of the vertex radius, positive where it grows; none for a form that states no radius about its own vertex.
    pub radius_change: Option<f64>,
}

/// Of the predicted `removal`, NaN outside the clear aperture.
pub fn stock(removal: &Grid, clear: &Aperture, form: &Form, surface: &dyn Surface) -> Stock {
    // Positive for concave.
    let radius = vertex_radius(form);
    let curvature = radius.map_or(0.0, |radius| 1.0 / radius);
    let [cx, cy] = match radius {
        // The vertex is where the form says it: at the part's origin.
        Some(_) => [0.0; 2],
        None => clear.centre(),
    };
    let pixel = removal.pixel[0] * removal.pixel[1];
    let rim = clear.outer_radius();
    let mut stock = Stock::default();
    let mut normal = [[0.0; 5]; 4];
    for i in (0..removal.values.len()).filter(|i| !removal.values[*i].is_nan()) {
        let depth = removal.values[i];
        let [x, y] = removal.position(i / removal.columns, i % removal.columns);
        let [_, _, cosine] = surface.at(x, y).map_or([0.0, 0.0, 1.0], |point| point.normal());
        stock.depth = stock.depth.max(depth);
        stock.volume += depth * pixel / cosine;
        // In parts of the rim, so that the four columns are of one size.
        let (u, v) = ((x - cx) / rim, (y - cy) / rim);
        let row = [1.0, u, v, bend(libm::hypot(x - cx, y - cy), curvature) / (rim * rim), depth / cosine];
        for (equation, a) in normal.iter_mut().zip(row) {
            for (sum, b) in equation.iter_mut().zip(row) {
                *sum += a * b;
            }
        }
    }
    let Some([_, _, _, q]) = solved(normal) else { return stock };
    let q = q / (rim * rim);
    stock.power = -q * bend(rim, curvature);
    // The surface loses the removal: its curvature κ becomes κ - q.
    stock.radius_change = radius.map(|radius| 1.0 / (curvature - q) - radius).map(|change| change * curvature.signum());
    stock
}

/// `dz/dκ` at the distance r from the axis of a sphere of curvature κ.
fn bend(r: f64, curvature: f64) -> f64 {
    let u = (1.0 - curvature * curvature * r * r).max(0.0).sqrt();
    // A form may go on beyond the sphere that touches its vertex; there the parabola stands in.
    if u < 1e-3 { r * r / 2.0 } else { r * r / u - r * r / (1.0 + u) }
}

/// Vertex radius, positive for concave, of forms with their vertex in the part's origin.
fn vertex_radius(form: &Form) -> Option<f64> {
    let (side, radius) = match form {
        Form::sphere(sphere) => (sphere.side, sphere.radius),
        Form::conic(conic) => (conic.side, conic.radius),
        Form::even_asphere(asphere) => (asphere.side, asphere.radius),
        Form::odd_asphere(asphere) => (asphere.side, asphere.radius),
        Form::plane(_) | Form::off_axis(_) | Form::xy_polynomial(_) | Form::zernike(_) | Form::height_grid(_) => {
            return None;
        }
    };
    Some(match side {
        Side::concave => radius.0,
        Side::convex => -radius.0,
    })
}

/// Four equations of four unknowns, positive definite, by elimination. `None` if the places do not tell them apart.
fn solved(mut equations: [[f64; 5]; 4]) -> Option<[f64; 4]> {
    let scale = equations[0][0];
    for i in 0..4 {
        let pivot = equations[i][i];
        // Fewer than four pixels, or all on a line or circle: a rounding error is no shape.
        let usable = pivot > 1e-12 * scale;
        if !usable {
            return None;
        }
        for k in 0..4 {
            let factor = equations[k][i] / pivot;
            if k != i {
                let row = equations[i];
                equations[k].iter_mut().zip(row).for_each(|(value, other)| *value -= factor * other);
            }
        }
    }
    Some([0, 1, 2, 3].map(|i| equations[i][4] / equations[i][i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{Circle, Plane, Sphere};
    use crate::units::si::Length;
    use crate::workpiece::form::examples;

    fn circle(diameter: f64) -> Aperture {
        Aperture::circle(Circle { diameter: Length(diameter), centre: None })
    }

    /// Pixels of 1 mm over 100 mm, known inside the aperture.
    fn removal(clear: &Aperture, depth: impl Fn(f64, f64) -> f64) -> Grid {
        let mut grid = Grid { columns: 101, rows: 101, pixel: [1e-3; 2], origin: [-50e-3; 2], values: Vec::new() };
        for i in 0..101 * 101 {
            let [x, y] = grid.position(i / 101, i % 101);
            grid.values.push(if clear.contains(x, y) { depth(x, y) } else { f64::NAN });
        }
        grid
    }

    fn sphere(side: Side, radius: f64) -> Form {
        Form::sphere(Sphere { side, radius: Length(radius) })
    }

    #[test]
    fn an_even_layer_has_no_power() {
        let clear = circle(80e-3);
        let form = Form::plane(Plane {});
        let stock = stock(&removal(&clear, |_, _| 2e-6), &clear, &form, &*examples::of(form.clone()));
        assert!((stock.depth - 2e-6).abs() < 1e-20 && stock.power.abs() < 1e-18 && stock.radius_change.is_none());
        // 2 um times the area; the pixels of 1 mm count the disc of 40 mm to about the square root of its border's pixels.
        let area = std::f64::consts::PI * 1.6e-3;
        assert!((stock.volume / (2e-6 * area) - 1.0).abs() < 3e-3, "{}", stock.volume);
    }

    #[test]
    fn taking_the_middle_off_a_flat_makes_it_hollow() {
        // 1 um in the middle, nothing at 40 mm: 1 um of sag.
        let clear = circle(80e-3);
        let form = Form::plane(Plane {});
        let bowl = removal(&clear, |x, y| 1e-6 * (1.0 - (x * x + y * y) / 1.6e-3));
        let stock = stock(&bowl, &clear, &form, &*examples::of(form.clone()));
        assert!((stock.power - 1e-6).abs() < 1e-17, "{}", stock.power);
    }

    #[test]
    fn the_radius_changes_as_the_sphere_that_is_left() {
        // Taken off: what lies between a sphere and the one of another radius through the same vertex, along z, made a depth along
        // the normal. What is left is the other sphere.
        for (side, sign) in [(Side::concave, 1.0), (Side::convex, -1.0)] {
            let (radius, clear) = (200e-3, circle(80e-3));
            let form = sphere(side, radius);
            for change in [5e-6, -20e-6] {
                let sag = |radius: f64, r2: f64| sign * r2 / (radius + (radius * radius - r2).sqrt());
                let off = |x: f64, y: f64| {
                    let r2 = x * x + y * y;
                    let cosine = (1.0 - r2 / (radius * radius)).sqrt();
                    (sag(radius, r2) - sag(radius + change, r2)) * cosine
                };
                let found = stock(&removal(&clear, off), &clear, &form, &*examples::of(form.clone()));
                let found = found.radius_change.expect("a radius");
                assert!((found / change - 1.0).abs() < 1e-3, "{side:?} {change}: {found}");
            }
        }
    }
}
