//! Apertures: circle, annulus, rectangle, hexagon and polygon.
//!
//! In: a place or a line of the part frame, metres. Out: whether, and how far, it lies inside. The edge of the part, its
//! clear aperture and the area of a raster are all the same kind of thing, so the answers are methods of
//! [`job::Aperture`](crate::job::Aperture).

use super::polygon;
use crate::diagnostics::{Problem, codes};
use crate::job::{Aperture, Hexagon, Place};

/// A place this far beyond the aperture still counts as inside, metres. The numbers of a job (`54 mm`, a pixel of `1 mm`)
/// are not exact in binary, and a place on the boundary must not come and go with their last bit, on one side of the part
/// and not on the other. A nanometre is a thousand times more than that rounding and a thousand times less than any robot
/// or map can resolve.
pub const BOUNDARY: f64 = 1e-9;

/// Most vertices of a polygon: every pixel of a map is asked against every side.
const MOST_VERTICES: usize = 200;

/// A box along the axes of the part frame, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub min: [f64; 2],
    pub max: [f64; 2],
}

impl Bounds {
    fn around(points: &[[f64; 2]]) -> Bounds {
        let mut bounds = Bounds { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2] };
        for [x, y] in points {
            bounds.min = [bounds.min[0].min(*x), bounds.min[1].min(*y)];
            bounds.max = [bounds.max[0].max(*x), bounds.max[1].max(*y)];
        }
        bounds
    }
}

/// The six corners, counter-clockwise.
fn corners(hexagon: &Hexagon) -> Vec<[f64; 2]> {
    let [cx, cy] = hexagon.centre.map_or([0.0; 2], |Place { x, y }| [x.0, y.0]);
    // A corner lies 30 degrees beside the middle of a flat, at across_flats / sqrt 3.
    let root = 3.0_f64.sqrt();
    let radius = hexagon.across_flats.0 / root;
    let (sin, cos) = libm::sincos(hexagon.direction.0);
    let half = root / 2.0;
    [[half, 0.5], [0.0, 1.0], [-half, 0.5], [-half, -0.5], [0.0, -1.0], [half, -0.5]]
        .map(|[x, y]| [cx + radius * (cos * x - sin * y), cy + radius * (sin * x + cos * y)])
        .to_vec()
}

impl Aperture {
    /// The corners of an outline with straight sides, in order; `None` for a round one.
    pub fn vertices(&self) -> Option<Vec<[f64; 2]>> {
        match self {
            Aperture::circle(_) | Aperture::annulus(_) => None,
            Aperture::rectangle(_) => {
                let Bounds { min, max } = self.bounds();
                Some(vec![min, [max[0], min[1]], max, [min[0], max[1]]])
            }
            Aperture::hexagon(a) => Some(corners(a)),
            Aperture::polygon(a) => Some(a.vertices.iter().map(|p| [p.x.0, p.y.0]).collect()),
        }
    }

    /// The centre; the part's origin if the job names none. Of a polygon the middle of the box around it.
    pub fn centre(&self) -> [f64; 2] {
        let place = match self {
            Aperture::circle(a) => a.centre,
            Aperture::annulus(a) => a.centre,
            Aperture::rectangle(a) => a.centre,
            Aperture::hexagon(a) => a.centre,
            Aperture::polygon(_) => {
                let Bounds { min, max } = self.bounds();
                return [(min[0] + max[0]) / 2.0, (min[1] + max[1]) / 2.0];
            }
        };
        place.map_or([0.0; 2], |Place { x, y }| [x.0, y.0])
    }

    /// Whether `(x, y)` lies inside, or beyond by no more than [`BOUNDARY`].
    pub fn contains(&self, x: f64, y: f64) -> bool {
        self.distance(x, y) >= -BOUNDARY
    }

    /// Distance to the nearest point of the boundary, positive inside, negative outside, metres. Exact.
    pub fn distance(&self, x: f64, y: f64) -> f64 {
        let from_centre = || {
            let [cx, cy] = self.centre();
            [x - cx, y - cy]
        };
        match self {
            Aperture::circle(a) => {
                let [dx, dy] = from_centre();
                a.diameter.0 / 2.0 - libm::hypot(dx, dy)
            }
            Aperture::annulus(a) => {
                let [dx, dy] = from_centre();
                let r = libm::hypot(dx, dy);
                (a.outer_diameter.0 / 2.0 - r).min(r - a.inner_diameter.0 / 2.0)
            }
            Aperture::rectangle(a) => {
                let [dx, dy] = from_centre();
                let (ox, oy) = (dx.abs() - a.x.0 / 2.0, dy.abs() - a.y.0 / 2.0);
                if ox > 0.0 && oy > 0.0 { -libm::hypot(ox, oy) } else { -ox.max(oy) }
            }
            Aperture::hexagon(a) => polygon::distance(&corners(a), [x, y]).0,
            Aperture::polygon(_) => polygon::distance(&self.vertices().unwrap_or_default(), [x, y]).0,
        }
    }

    /// The smallest box that holds it.
    pub fn bounds(&self) -> Bounds {
        let half = match self {
            Aperture::circle(a) => [a.diameter.0 / 2.0; 2],
            Aperture::annulus(a) => [a.outer_diameter.0 / 2.0; 2],
            Aperture::rectangle(a) => [a.x.0 / 2.0, a.y.0 / 2.0],
            Aperture::hexagon(a) => return Bounds::around(&corners(a)),
            Aperture::polygon(_) => return Bounds::around(&self.vertices().unwrap_or_default()),
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
            Aperture::hexagon(a) => polygon::signed_area(&corners(a)),
            Aperture::polygon(_) => polygon::signed_area(&self.vertices().unwrap_or_default()).abs(),
        }
    }

    /// Radius of the smallest circle about [`centre`](Self::centre) that holds it, metres.
    pub fn outer_radius(&self) -> f64 {
        match self {
            Aperture::circle(a) => a.diameter.0 / 2.0,
            Aperture::annulus(a) => a.outer_diameter.0 / 2.0,
            Aperture::rectangle(a) => libm::hypot(a.x.0, a.y.0) / 2.0,
            Aperture::hexagon(_) | Aperture::polygon(_) => {
                let [cx, cy] = self.centre();
                let corners = self.vertices().unwrap_or_default();
                corners.iter().fold(0.0, |most, p| libm::hypot(p[0] - cx, p[1] - cy).max(most))
            }
        }
    }

    /// How far it reaches from its centre along the unit vector `direction`: least and greatest distance, metres.
    pub fn extent(&self, direction: [f64; 2]) -> [f64; 2] {
        let half = match self {
            Aperture::circle(_) | Aperture::annulus(_) => self.outer_radius(),
            Aperture::rectangle(a) => (a.x.0 * direction[0].abs() + a.y.0 * direction[1].abs()) / 2.0,
            Aperture::hexagon(_) | Aperture::polygon(_) => {
                let [cx, cy] = self.centre();
                let along = |p: &[f64; 2]| (p[0] - cx) * direction[0] + (p[1] - cy) * direction[1];
                let corners = self.vertices().unwrap_or_default();
                return corners
                    .iter()
                    .map(along)
                    .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], t| [low.min(t), high.max(t)]);
            }
        };
        [-half, half]
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

    /// Places on the outer boundary, in order round it: all corners, and between them no two farther apart than `spacing`
    /// metres.
    pub fn outline(&self, spacing: f64) -> Vec<[f64; 2]> {
        // At most ten thousand a side: a finer outline is not needed by anyone who asks.
        let parts = |length: f64| ((length / spacing).ceil().max(1.0) as usize).min(10_000);
        let Some(corners) = self.vertices() else {
            let ([cx, cy], radius) = (self.centre(), self.outer_radius());
            let count = parts(std::f64::consts::TAU * radius).max(16);
            let place = |i: usize| {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * i as f64 / count as f64);
                [cx + radius * cos, cy + radius * sin]
            };
            return (0..count).map(place).collect();
        };
        polygon::sides(&corners)
            .flat_map(|(a, b)| {
                let count = parts(libm::hypot(b[0] - a[0], b[1] - a[1]));
                (0..count).map(move |i| {
                    let t = i as f64 / count as f64;
                    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
                })
            })
            .collect()
    }

    /// Where the line `through + t * direction` runs inside: intervals `[from, to]` of `t`, in order, none empty.
    /// `direction` is a unit vector, so `t` is in metres; a ring cut through its hole, and an outline that turns inwards,
    /// give several intervals, a tangent gives none.
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
            Aperture::hexagon(a) => polygon::chords(&corners(a), through, direction),
            Aperture::polygon(_) => polygon::chords(&self.vertices().unwrap_or_default(), through, direction),
        }
    }

    /// The place of `self` that lies farthest beyond the outer boundary of `other`, and how far, metres (negative: inside).
    pub(super) fn farthest_beyond(&self, other: &Aperture) -> ([f64; 2], f64) {
        let (own, others) = (self.vertices(), other.vertices());
        let candidates = match (&own, &others) {
            // A straight side lies farthest out at an end of it, if the other outline is nowhere hollow there.
            (Some(corners), _) => corners.clone(),
            // A circle against straight sides: along the outward normal of each; against a circle: away from its centre.
            (None, Some(corners)) => {
                let ([cx, cy], radius) = (self.centre(), self.outer_radius());
                let sign = if polygon::signed_area(corners) >= 0.0 { radius } else { -radius };
                polygon::sides(corners)
                    .map(|(a, b)| {
                        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                        let length = libm::hypot(dx, dy);
                        [cx + sign * dy / length, cy - sign * dx / length]
                    })
                    .collect()
            }
            (None, None) => {
                let ([cx, cy], [ox, oy], radius) = (self.centre(), other.centre(), self.outer_radius());
                let apart = libm::hypot(cx - ox, cy - oy);
                let away = if apart > 0.0 { [(cx - ox) / apart, (cy - oy) / apart] } else { [1.0, 0.0] };
                vec![[cx + radius * away[0], cy + radius * away[1]]]
            }
        };
        let beyond = candidates.into_iter().map(|p| (p, -other.distance(p[0], p[1])));
        // Where a side of the other outline runs through this one, both hands of it cannot be inside the other.
        let cut_by = polygon::sides(others.as_deref().unwrap_or_default()).filter_map(|(a, b)| {
            let length = libm::hypot(b[0] - a[0], b[1] - a[1]);
            let direction = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
            let inside = self.chords(a, direction).into_iter().map(|[from, to]| (from.max(0.0), to.min(length)));
            let (from, to) = inside.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
            let middle = (from + to) / 2.0;
            let place = [a[0] + middle * direction[0], a[1] + middle * direction[1]];
            (to > from).then(|| (place, self.distance(place[0], place[1])))
        });
        beyond.chain(cut_by).fold(([0.0; 2], f64::NEG_INFINITY), |a, b| if b.1 > a.1 { b } else { a })
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

/// What is wrong with one aperture: sizes that are not positive, a hole as wide as the ring (E0600); a polygon of too few
/// or too many corners, or whose sides cross (E0604).
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
        Aperture::hexagon(a) => positive("across_flats", a.across_flats.0),
        Aperture::polygon(_) => polygon_problem(&aperture.vertices().unwrap_or_default(), field),
    }
}

fn polygon_problem(vertices: &[[f64; 2]], field: &str) -> Option<Problem> {
    let refuse = |field: String, message: String| Some(Problem::error(codes::E0604, field, message));
    let place = |[x, y]: [f64; 2]| format!("x {:.3} mm, y {:.3} mm", x * 1e3, y * 1e3);
    let n = vertices.len();
    if !(3..=MOST_VERTICES).contains(&n) {
        return refuse(
            format!("{field}.vertices"),
            format!("the polygon has {n} corners; 3 to {MOST_VERTICES} make an outline"),
        );
    }
    for (i, (a, b)) in polygon::sides(vertices).enumerate() {
        if !(a[0].is_finite() && a[1].is_finite()) {
            return refuse(format!("{field}.vertices.{i}"), "a corner of the polygon is not finite".into());
        }
        // Closer than this two corners cannot be told from one (see BOUNDARY).
        if libm::hypot(b[0] - a[0], b[1] - a[1]) <= BOUNDARY {
            let message = format!("the polygon has two corners in one place, {}", place(a));
            return refuse(format!("{field}.vertices.{}", (i + 1) % n), message)
                .map(|problem| problem.help("say every corner once; the outline closes by itself"));
        }
    }
    if let Some([i, j]) = polygon::crossing(vertices) {
        let message = format!(
            "the polygon's side from {} to {} meets its side from {} to {}",
            place(vertices[i]),
            place(vertices[(i + 1) % n]),
            place(vertices[j]),
            place(vertices[(j + 1) % n])
        );
        return refuse(format!("{field}.vertices.{j}"), message).map(|problem| {
            problem.help("name the corners in order round the outline, clockwise or counter-clockwise")
        });
    }
    None
}
