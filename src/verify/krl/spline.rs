//! The way between the points of a `SPLINE` block: a model.
//!
//! In: the poses of a block in order, the point where the robot stands before it first. Out: the pose at a share of each
//! segment. KUKA does not publish its spline. What users' manuals say of it is this (from memory, unsourced): the curve
//! goes through the points; a moved point changes the two segments before and the two behind it and no more; beside an
//! `SLIN` the curve leaves along the straight line.
//!
//! The model that has these properties and no others: a cubic Hermite curve over the chord lengths, its direction at each
//! point that of the parabola through the point and its two neighbours (Bessel's, with chord lengths as parameter), and at
//! the ends of the curve that of the straight segments. Orientations turn at an even rate on the shortest way from point to
//! point. On a surface with radius of curvature R and points h apart the curve of the model leaves the surface by less than
//! a part in a hundred of the chord's h^2 / 8R, so what the real spline does differently is small beside the tolerances as
//! long as the model's own deviation is.
//!
//! **Not controller-verified.** Whoever has the controller can trace the path and compare.

use crate::motion::Transform;
use crate::motion::frames::between;
use nalgebra::Vector3;

/// The pose at `share` (0 to 1) of the segment that ends at `points[end]`. The first and the last segment are straight, all
/// others belong to one curve. `None` where there is no such segment.
pub fn at(points: &[Transform], end: usize, share: f64) -> Option<Transform> {
    let begin = end.checked_sub(1)?;
    let (from, to) = (points.get(begin)?, points.get(end)?);
    let mut pose = between(from, to, share);
    let last = points.len() - 1;
    if begin == 0 || end == last {
        return Some(pose);
    }
    let place = |i: usize| points[i].translation.vector;
    let length = (place(end) - place(begin)).norm();
    let (m0, m1) = (tangent(points, begin), tangent(points, end));
    let (s, t) = (share, 1.0 - share);
    // Hermite's basis.
    let position =
        place(begin) * (t * t * (1.0 + 2.0 * s)) + m0 * (length * s * t * t) + place(end) * (s * s * (1.0 + 2.0 * t))
            - m1 * (length * s * s * t);
    pose.translation.vector = position;
    Some(pose)
}

/// The derivative by chord length of the curve at point `i`, which has a point on either side.
fn tangent(points: &[Transform], i: usize) -> Vector3<f64> {
    let place = |i: usize| points[i].translation.vector;
    let (before, after) = (place(i) - place(i - 1), place(i + 1) - place(i));
    let (a, b) = (before.norm(), after.norm());
    let last = points.len() - 1;
    if i == 1 {
        return before / a;
    }
    if i + 1 == last {
        return after / b;
    }
    // The slope of the parabola through three points.
    (before / a * b + after / b * a) / (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};

    fn points(place: impl Fn(f64) -> [f64; 3], count: usize, step: f64) -> Vec<Transform> {
        (0..count)
            .map(|i| {
                let [x, y, z] = place(i as f64 * step);
                Transform::from_parts(Translation3::new(x, y, z), UnitQuaternion::identity())
            })
            .collect()
    }

    #[test]
    fn a_straight_line_stays_one() {
        let points = points(|s| [s, 2.0 * s, 0.0], 6, 0.001);
        for end in 1..6 {
            let pose = at(&points, end, 0.3).unwrap().translation.vector;
            let s = (end as f64 - 0.7) * 0.001;
            assert!((pose - Vector3::new(s, 2.0 * s, 0.0)).norm() < 1e-15);
        }
    }

    #[test]
    fn it_goes_through_the_points_and_its_ends_are_straight() {
        let points = points(|s| [s, libm::sin(40.0 * s), 0.0], 8, 0.01);
        for end in 1..8 {
            for (share, i) in [(0.0, end - 1), (1.0, end)] {
                let found = at(&points, end, share).unwrap().translation.vector;
                assert!((found - points[i].translation.vector).norm() < 1e-15);
            }
        }
        let chord = |a: usize, b: usize| (points[a].translation.vector + points[b].translation.vector) / 2.0;
        assert!((at(&points, 1, 0.5).unwrap().translation.vector - chord(0, 1)).norm() < 1e-15);
        assert!((at(&points, 7, 0.5).unwrap().translation.vector - chord(6, 7)).norm() < 1e-15);
        assert_eq!(at(&points, 8, 0.5), None);
        assert_eq!(at(&points, 0, 0.5), None);
    }

    /// On a circle of radius R with chords h the chord's middle lies h²/8R inside. The curve's lies nearer by two orders:
    /// the direction of the parabola is the circle's tangent by symmetry, and its length 1 instead of h/2R / tan(h/2R)
    /// turned into the Hermite middle gives less than h^4/384R^3 plus h²/8R · h²/12R² of rounding of the parameter.
    #[test]
    fn a_circle_is_followed_far_closer_than_by_chords() {
        let (radius, step) = (0.5_f64, 0.01);
        let circle = |s: f64| [radius * libm::sin(s / radius), 0.0, radius * (1.0 - libm::cos(s / radius))];
        let points = points(circle, 12, step);
        let chord = step * step / (8.0 * radius);
        for end in 4..9 {
            let pose = at(&points, end, 0.5).unwrap().translation.vector;
            let off = ((pose - Vector3::new(0.0, 0.0, radius)).norm() - radius).abs();
            assert!(off < chord / 100.0, "{off} against {chord}");
        }
    }

    /// What the prediction of removal, which knows chords, misses of the curve: on a sphere of 1500 mm with points 4 mm apart
    /// the curve leaves its chord by h²/8R = 1.33 um, along the normal, and is longer by h²/24R² = 2.96e-7 of itself; where it
    /// begins and ends along a chord, by half as much again and by 0.1 h²/R² = 7.11e-7 (Hermite with end slopes a and b: h (a -
    /// b)/8 and (2a² - ab + 2b²)/30, with h/2R and -h/2R, there h/R and -h/2R). A spot is millimetres wide and its time is
    /// known to a part in a thousand: neither can be seen.
    #[test]
    fn chords_and_curve_lie_a_micrometre_apart() {
        let (radius, step) = (1.5_f64, 4e-3);
        let circle = |s: f64| [radius * libm::sin(s / radius), 0.0, radius * (1.0 - libm::cos(s / radius))];
        let points = points(circle, 30, step);
        for end in 2..29 {
            let (a, b) = (points[end - 1].translation.vector, points[end].translation.vector);
            let chord = (b - a).norm();
            let place = |k: u32| at(&points, end, f64::from(k) / 64.0).unwrap().translation.vector;
            let length: f64 = (1..=64).map(|k| (place(k) - place(k - 1)).norm()).sum();
            let off = (place(32) - (a + b) / 2.0).norm();
            let at_its_ends = end == 2 || end == 28;
            let (wanted_off, wanted_excess) = if at_its_ends { (2e-6, 7.11e-7) } else { (1.3333e-6, 2.96e-7) };
            assert!((off - wanted_off).abs() < 1e-9, "{off}");
            assert!((length / chord - 1.0 - wanted_excess).abs() < 2e-9, "{}", length / chord - 1.0);
        }
    }

    #[test]
    fn a_moved_point_changes_four_segments() {
        let whole = points(|s| [s, libm::sin(9.0 * s) / 50.0, 0.0], 13, 0.01);
        let mut moved = whole.clone();
        moved[6].translation.vector.z += 1e-3;
        for end in 1..13 {
            let [a, b] = [&whole, &moved].map(|points| at(points, end, 0.5).unwrap().translation.vector);
            assert_eq!((a - b).norm() > 0.0, (5..=8).contains(&end), "segment {end}");
        }
    }
}
