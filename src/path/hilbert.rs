//! Hilbert's curve.
//!
//! In: the job's `hilbert`. Out: the curve through the squares of a grid about the middle of `over`, as far as their middles
//! lie in it.
//!
//! The curve of order n goes once through each of 2^n by 2^n squares, from each into one beside it; n is the least whose grid
//! covers `over` (D. Hilbert, Math. Ann. 38, 459 (1891)). Where it leaves `over` and comes back into a square beside that
//! which it left, it goes straight on; elsewhere the tool is lifted. A piece of a single square is left out: there is no way
//! to go in it.

use super::lattice::{Lattice, Square};
use super::{Laid, Line, Link, Setting, Strategy};
use crate::diagnostics::{Problem, codes};
use crate::job::{Hilbert, Pass};

impl Strategy for Hilbert {
    fields_of_lines!();

    /// # Errors
    ///
    /// E0640: a length that is not positive, or no square inside. E0641: too many points. E0692: points too far apart.
    fn lay(&self, pass: Pass, setting: &Setting) -> Result<Laid, Problem> {
        let (step, pitch) = (self.point_step.0, self.line_pitch.0);
        let lattice = Lattice::new(&self.over, (step, pitch), self.direction.0, pass)?;
        let half = lattice.range(&self.over).iter().flatten().fold(1.0, |most: f64, k| most.max(k.abs()));
        let order = libm::ceil(libm::log2(half)) + 1.0;
        super::few_squares(libm::exp2(2.0 * order))?;
        let order = order as u32;
        let side = 1i64 << order;
        let mut lines: Vec<Vec<Square>> = Vec::new();
        for square in (0..side * side).map(|k| square(order, k).map(|c| c - side / 2)) {
            let [x, y] = lattice.middle(square);
            if !self.over.contains(x, y) {
                continue;
            }
            match lines.last_mut() {
                Some(line) if line.last().is_some_and(|last| beside(*last, square)) => line.push(square),
                _ => lines.push(vec![square]),
            }
        }
        lines.retain(|line| line.len() > 1);
        if lines.is_empty() {
            let message = "the area of Hilbert's curve holds less than two of its squares";
            return Err(Problem::error(codes::E0640, "path.line_pitch", message)
                .help("make `line_pitch` smaller than the area `over`"));
        }
        let mut laid = Laid::default();
        for line in lattice.trace(&lines, step, setting)? {
            let start = laid.places.len();
            laid.places.extend(line);
            laid.lines.push(Line { points: start..laid.places.len(), link: Link::Lifted });
        }
        Ok(laid)
    }
}

fn beside(a: Square, b: Square) -> bool {
    (a[0] - b[0]).abs() + (a[1] - b[1]).abs() == 1
}

/// Square `k` of the curve through 2^order by 2^order squares: from the finest two bits of `k`, which choose a quarter of a
/// square of two, to the coarsest, each time the part so far is put into its quarter, mirrored where the curve needs it.
fn square(order: u32, k: i64) -> Square {
    let [mut x, mut y] = [0, 0];
    for level in 0..order {
        let side = 1i64 << level;
        match k >> (2 * level) & 3 {
            0 => (x, y) = (y, x),
            1 => y += side,
            2 => (x, y) = (x + side, y + side),
            _ => (x, y) = (2 * side - 1 - y, side - 1 - x),
        }
    }
    [x, y]
}

#[cfg(test)]
mod tests {
    use super::super::examples::*;
    use super::*;
    use crate::job::{Annulus, Aperture, Path, Place, Polygon};
    use crate::units::si::{Angle, Length};
    use std::collections::BTreeSet;

    fn hilbert(over: Aperture, step_mm: f64, pitch_mm: f64) -> Hilbert {
        Hilbert {
            over,
            point_step: Length(step_mm * 1e-3),
            line_pitch: Length(pitch_mm * 1e-3),
            direction: Angle(0.2),
            chord_error: Length(1e-5),
            holes: None,
            landing: None,
            passes: None,
        }
    }

    fn planned(hilbert: &Hilbert) -> super::super::ToolPath {
        plan_on_plane(Path::hilbert(hilbert.clone()), 1_000_000).expect("a path")
    }

    /// The curve of order 1 is the U of Hilbert's first figure, lying: up, right, down. All orders go from square to square
    /// through all of them.
    #[test]
    fn the_curve_goes_through_all_squares() {
        assert_eq!([0, 1, 2, 3].map(|k| square(1, k)), [[0, 0], [0, 1], [1, 1], [1, 0]]);
        for order in 1..7 {
            let squares: Vec<Square> = (0..1 << (2 * order)).map(|k| square(order, k)).collect();
            assert!(squares.windows(2).all(|pair| beside(pair[0], pair[1])), "order {order}");
            assert_eq!(squares.iter().collect::<BTreeSet<_>>().len(), 1 << (2 * order));
            assert!(squares.iter().flatten().all(|c| (0..1 << order).contains(c)));
        }
    }

    #[test]
    fn it_covers_its_area_without_a_crossing_and_turns_gently() {
        let corners = [(-15, -12), (14, -12), (14, 12), (3, 12), (3, 1), (-4, 1), (-4, 12), (-15, 12)];
        let place = |(x, y): (i32, i32)| Place { x: Length(f64::from(x) * 1e-3), y: Length(f64::from(y) * 1e-3) };
        let notched = Aperture::polygon(Polygon { vertices: corners.map(place).to_vec() });
        let ring =
            Aperture::annulus(Annulus { outer_diameter: Length(0.03), inner_diameter: Length(0.006), centre: None });
        for over in [circle(30.0), notched, ring] {
            let path = planned(&hilbert(over.clone(), 0.35, 1.0));
            assert!(!crosses(&path));
            assert!((0..path.points.len()).all(|i| over.contains(path.points.x[i], path.points.y[i])));
            assert!(sharpest_turn(&path) <= 45.1f64.to_radians(), "{}", sharpest_turn(&path).to_degrees());
            // No place farther from the line than a corner cut short, √2 p - p/2, and s²/4p that chords cut off; pieces of one
            // square are left out at the rim.
            let farthest = farthest(&path, |x, y| over.distance(x, y) > 1.5e-3);
            assert!(farthest <= 0.945e-3, "{farthest}");
            let uneven = unevenness(&path, 1.2e-3, |x, y| over.distance(x, y) > 5.5e-3);
            assert!(uneven < 0.25, "{uneven}");
        }
    }

    #[test]
    fn a_square_of_a_power_of_two_is_one_line() {
        let square = |mm: f64| {
            let half = mm / 2.0;
            let place = |x: f64, y: f64| Place { x: Length(x * half * 1e-3), y: Length(y * half * 1e-3) };
            Aperture::polygon(Polygon {
                vertices: vec![place(-1.0, -1.0), place(1.0, -1.0), place(1.0, 1.0), place(-1.0, 1.0)],
            })
        };
        let mut whole = hilbert(square(16.0), 0.35, 1.0);
        whole.direction = Angle(0.0);
        assert_eq!(planned(&whole).lines.len(), 1);
        whole.over = square(14.0);
        let path = planned(&whole);
        assert!(path.lines.len() > 1 && path.lines.iter().all(|line| line.link == Link::Lifted));
    }

    #[test]
    fn what_is_too_much_or_nothing_is_refused() {
        let code = |hilbert: &Hilbert| plan_on_plane(Path::hilbert(hilbert.clone()), 1000).unwrap_err().code;
        assert_eq!(code(&hilbert(circle(30.0), 0.39, 1.0)), codes::E0641);
        assert_eq!(code(&hilbert(circle(30.0), 1e-9, 1e-8)), codes::E0641);
        assert_eq!(code(&hilbert(circle(30.0), 0.5, 1.0)), codes::E0692);
        assert_eq!(code(&hilbert(circle(0.5), 0.39, 1.0)), codes::E0640);
    }
}
