//! Apertures: circle, annulus and rectangle, each with an optional centre.
//!
//! In: a place or a line of the part frame, metres. Out: whether, and how far, it lies inside. The edge of the part, its
//! clear aperture and the area of a raster are all the same kind of thing, so the answers are methods of
//! [`job::Aperture`](crate::job::Aperture).

use crate::diagnostics::{Problem, codes};
use crate::job::{Aperture, Place};

/// A place this far beyond the aperture still counts as inside, metres. The numbers of a job (`54 mm`, a pixel of `1 mm`)
/// are not exact in binary, and a place on the boundary must not come and go with their last bit, on one side of the part
/// and not on the other. A nanometre is a thousand times more than that rounding and a thousand times less than any robot
/// or map can resolve.
pub const BOUNDARY: f64 = 1e-9;

/// A box along the axes of the part frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub min: [f64; 2],
    pub max: [f64; 2],
}

impl Aperture {
    /// The centre; the part's origin if the job names none.
    pub fn centre(&self) -> [f64; 2] {
        let place = match self {
            Aperture::circle(a) => a.centre,
            Aperture::annulus(a) => a.centre,
            Aperture::rectangle(a) => a.centre,
        };
        place.map_or([0.0; 2], |Place { x, y }| [x.0, y.0])
    }

    /// Whether `(x, y)` lies inside, or beyond by no more than [`BOUNDARY`].
    pub fn contains(&self, x: f64, y: f64) -> bool {
        self.distance(x, y) >= -BOUNDARY
    }

    /// Distance to the nearest point of the boundary, positive inside, negative outside, metres. Exact.
    pub fn distance(&self, x: f64, y: f64) -> f64 {
        let [cx, cy] = self.centre();
        let (dx, dy) = (x - cx, y - cy);
        match self {
            Aperture::circle(a) => a.diameter.0 / 2.0 - libm::hypot(dx, dy),
            Aperture::annulus(a) => {
                let r = libm::hypot(dx, dy);
                (a.outer_diameter.0 / 2.0 - r).min(r - a.inner_diameter.0 / 2.0)
            }
            Aperture::rectangle(a) => {
                let (ox, oy) = (dx.abs() - a.x.0 / 2.0, dy.abs() - a.y.0 / 2.0);
                if ox > 0.0 && oy > 0.0 { -libm::hypot(ox, oy) } else { -ox.max(oy) }
            }
        }
    }

    /// The smallest box that holds it.
    pub fn bounds(&self) -> Bounds {
        let half = match self {
            Aperture::circle(a) => [a.diameter.0 / 2.0; 2],
            Aperture::annulus(a) => [a.outer_diameter.0 / 2.0; 2],
            Aperture::rectangle(a) => [a.x.0 / 2.0, a.y.0 / 2.0],
        };
        let [cx, cy] = self.centre();
        Bounds { min: [cx - half[0], cy - half[1]], max: [cx + half[0], cy + half[1]] }
    }

    /// Square metres.
    pub fn area(&self) -> f64 {
        let disc = |diameter: f64| std::f64::consts::PI / 4.0 * diameter * diameter;
        match self {
            Aperture::circle(a) => disc(a.diameter.0),
            Aperture::annulus(a) => disc(a.outer_diameter.0) - disc(a.inner_diameter.0),
            Aperture::rectangle(a) => a.x.0 * a.y.0,
        }
    }

    /// Radius of the smallest circle about [`centre`](Self::centre) that holds it, metres.
    pub fn outer_radius(&self) -> f64 {
        match self {
            Aperture::circle(a) => a.diameter.0 / 2.0,
            Aperture::annulus(a) => a.outer_diameter.0 / 2.0,
            Aperture::rectangle(a) => libm::hypot(a.x.0, a.y.0) / 2.0,
        }
    }

    /// Radius of the hole about the centre, metres; `None` where there is none.
    pub fn hole_radius(&self) -> Option<f64> {
        match self {
            Aperture::annulus(a) if a.inner_diameter.0 > 0.0 => Some(a.inner_diameter.0 / 2.0),
            _ => None,
        }
    }

    /// Whether it has a hole.
    pub fn has_hole(&self) -> bool {
        self.hole_radius().is_some()
    }

    /// Where the line `through + t * direction` runs inside: intervals `[from, to]` of `t`, in order, none empty.
    /// `direction` is a unit vector, so `t` is in metres; a ring cut through its hole gives two intervals, a tangent
    /// gives none.
    pub fn chords(&self, through: [f64; 2], direction: [f64; 2]) -> Vec<[f64; 2]> {
        let [cx, cy] = self.centre();
        let from_centre = [through[0] - cx, through[1] - cy];
        match self {
            Aperture::circle(a) => circle_chord(from_centre, direction, a.diameter.0 / 2.0).into_iter().collect(),
            Aperture::annulus(a) => {
                let Some([start, end]) = circle_chord(from_centre, direction, a.outer_diameter.0 / 2.0) else {
                    return Vec::new();
                };
                match circle_chord(from_centre, direction, a.inner_diameter.0 / 2.0) {
                    Some([hole_start, hole_end]) => vec![[start, hole_start], [hole_end, end]],
                    None => vec![[start, end]],
                }
            }
            Aperture::rectangle(a) => {
                let half = [a.x.0 / 2.0, a.y.0 / 2.0];
                rectangle_chord(from_centre, direction, half).into_iter().collect()
            }
        }
    }

    /// The places of `self` of which one lies farthest out of `other`, if any does so past the outer boundary of
    /// `other`: the farthest from a circle's centre, the extremes along a rectangle's sides.
    pub(super) fn extremes(&self, other: &Aperture) -> Vec<[f64; 2]> {
        let Bounds { min, max } = self.bounds();
        let [cx, cy] = self.centre();
        match (self, other) {
            (Aperture::rectangle(_), _) => {
                vec![[min[0], min[1]], [min[0], max[1]], [max[0], min[1]], [max[0], max[1]]]
            }
            (_, Aperture::rectangle(_)) => vec![[min[0], cy], [max[0], cy], [cx, min[1]], [cx, max[1]]],
            (_, Aperture::circle(_) | Aperture::annulus(_)) => {
                let [ox, oy] = other.centre();
                let apart = libm::hypot(cx - ox, cy - oy);
                let away = if apart > 0.0 { [(cx - ox) / apart, (cy - oy) / apart] } else { [1.0, 0.0] };
                let radius = self.outer_radius();
                vec![[cx + radius * away[0], cy + radius * away[1]]]
            }
        }
    }
}

/// The chord of a circle about the origin.
fn circle_chord(through: [f64; 2], direction: [f64; 2], radius: f64) -> Option<[f64; 2]> {
    let along = through[0] * direction[0] + through[1] * direction[1];
    let across = through[0] * direction[1] - through[1] * direction[0];
    let square = (radius - across.abs()) * (radius + across.abs());
    if square <= 0.0 {
        return None;
    }
    let half = square.sqrt();
    Some([-along - half, -along + half])
}

/// The chord of a box about the origin: the overlap of the two slabs.
fn rectangle_chord(through: [f64; 2], direction: [f64; 2], half: [f64; 2]) -> Option<[f64; 2]> {
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..2 {
        let (p, d, h) = (through[axis], direction[axis], half[axis]);
        if d == 0.0 {
            if p.abs() >= h {
                return None;
            }
            continue;
        }
        let (a, b) = ((-h - p) / d, (h - p) / d);
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    (to > from).then_some([from, to])
}

/// What is wrong with one aperture (E0600): sizes that are not positive, a hole as wide as the ring.
pub fn check(aperture: &Aperture, field: &str) -> Option<Problem> {
    let positive = |name: &str, value: f64| {
        let message = format!("`{name}` is {:.3} mm; it must be positive", value * 1e3);
        (!(value > 0.0 && value.is_finite())).then(|| Problem::error(codes::E0600, format!("{field}.{name}"), message))
    };
    match aperture {
        Aperture::circle(a) => positive("diameter", a.diameter.0),
        Aperture::annulus(a) => positive("outer_diameter", a.outer_diameter.0)
            .or_else(|| positive("inner_diameter", a.inner_diameter.0))
            .or_else(|| {
                let message = format!(
                    "the hole of {:.3} mm is not smaller than the ring of {:.3} mm",
                    a.inner_diameter.0 * 1e3,
                    a.outer_diameter.0 * 1e3
                );
                (a.inner_diameter.0 >= a.outer_diameter.0).then(|| {
                    Problem::error(codes::E0600, format!("{field}.inner_diameter"), message)
                        .help("swap the two diameters, or write `circle` for a part without a hole")
                })
            }),
        Aperture::rectangle(a) => positive("x", a.x.0).or_else(|| positive("y", a.y.0)),
    }
}
