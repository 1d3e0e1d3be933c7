//! Following: which place of the planned path a machine was at, sample by sample.
//!
//! In: the plan, positions on the surface in the order of time. Out: the length along the path of every sample. The path goes
//! through every region twice and more (neighbouring lines, crossings), so the nearest point of it says nothing: a sample is
//! looked for a little ahead of the one before, and only a sample that is lost is looked for everywhere ahead.

use crate::dwell::TimedPath;
use crate::dwell::speed::{self, Limits, Segments};
use crate::path::Link;

/// Change of speed within a segment, as a share, from which its ramp is followed: below, its time is shared out evenly
/// within a hundredth.
const STEADY: f64 = 0.02;

/// Parts of such a segment.
const RAMP_PARTS: usize = 8;

/// The plan as one way, its nodes in order.
pub struct Way {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// Metres from the start along the way of the contact; a lifted link has no length.
    pub length: Vec<f64>,
    /// Seconds from the start; a lifted link takes no time here.
    pub time: Vec<f64>,
    /// Whether the tool comes from the node before on the surface.
    joined: Vec<bool>,
}

impl Way {
    /// Of a plan whose programmed speeds belong to a point `standoff` metres above the contact.
    pub fn new(timed: &TimedPath, standoff: f64, acceleration: f64) -> Way {
        let limits = Limits::of_arm(acceleration);
        let segments = Segments::new(&timed.path, standoff);
        let speeds: Vec<f64> = segments.point.iter().map(|&p| timed.speed[p]).collect();
        let times = speed::times(&speeds, &segments, &limits);
        let points = &timed.path.points;
        let n = points.len();
        let room = || Vec::with_capacity(n);
        let mut way = Way { x: room(), y: room(), length: room(), time: room(), joined: Vec::with_capacity(n) };
        let (mut length, mut time, mut segment) = (0.0, 0.0, 0);
        let mut link = Link::Lifted;
        for line in &timed.path.lines {
            let mut before = 0.0;
            for i in line.points.clone() {
                let joined = i > line.points.start || link == Link::OnSurface;
                if i > line.points.start {
                    let step = distance(points.position(i - 1), points.position(i));
                    let (speed, stops) = (timed.speed[i], i + 1 == line.points.end);
                    // Where the speed changes much within a segment, nodes between say when the tool passes where.
                    if stops || (speed - before).abs() > STEADY * speed {
                        let mut passed = 0.0;
                        let whole = (segments.length[segment], RAMP_PARTS);
                        speed::part_times(whole, (before, speed, stops), acceleration, |part, spent| {
                            passed += spent;
                            if part + 1 < RAMP_PARTS {
                                let t = (part + 1) as f64 / RAMP_PARTS as f64;
                                let between = |v: &[f64]| v[i - 1] + t * (v[i] - v[i - 1]);
                                way.x.push(between(&points.x));
                                way.y.push(between(&points.y));
                                way.length.push(length + t * step);
                                way.time.push(time + passed);
                                way.joined.push(true);
                            }
                        });
                    }
                    length += step;
                    time += times[segment];
                    segment += 1;
                    before = speed;
                } else if let (Link::OnSurface, Some(before)) = (link, i.checked_sub(1)) {
                    let step = distance(points.position(before), points.position(i));
                    length += step;
                    time += step / timed.speed[i] + timed.speed[i] / acceleration;
                }
                way.x.push(points.x[i]);
                way.y.push(points.y[i]);
                way.length.push(length);
                way.time.push(time);
                way.joined.push(joined);
            }
            link = line.link;
        }
        way
    }

    /// Number of its nodes.
    pub fn nodes(&self) -> usize {
        self.x.len()
    }

    /// Place and planned time at a length along the way.
    pub fn at(&self, length: f64) -> ([f64; 2], f64) {
        let b = self.length.partition_point(|l| *l < length).clamp(1, self.nodes().max(2) - 1);
        let a = b - 1;
        let step = self.length[b] - self.length[a];
        let t = if step > 0.0 { ((length - self.length[a]) / step).clamp(0.0, 1.0) } else { 0.0 };
        let between = |v: &[f64]| v[a] + t * (v[b] - v[a]);
        ([between(&self.x), between(&self.y)], between(&self.time))
    }

    /// The place of segment `i` (from node `i - 1` to `i`) nearest to `p`: its share of the segment and its distance.
    fn nearest(&self, i: usize, p: [f64; 2]) -> (f64, f64) {
        let (a, b) = ([self.x[i - 1], self.y[i - 1]], [self.x[i], self.y[i]]);
        let d = [b[0] - a[0], b[1] - a[1]];
        let square = d[0] * d[0] + d[1] * d[1];
        let t =
            if square > 0.0 { (((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
        (t, libm::hypot(p[0] - a[0] - t * d[0], p[1] - a[1] - t * d[1]))
    }

    fn length_at(&self, i: usize, t: f64) -> f64 {
        self.length[i - 1] + t * (self.length[i] - self.length[i - 1])
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    libm::hypot(libm::hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2])
}

/// Samples that a place is judged by when a lost machine is looked for.
const JUDGED: usize = 40;

/// Most places that are looked at then: several lines lie within the tolerance of any place, each with a few segments.
const MOST_PLACES: usize = 400;

/// Searches of the whole way. A machine that is lost more often does not follow this path.
const MOST_SEARCHES: usize = 500;

/// Samples between two searches that find nothing: the machine must have moved on.
const LOST: usize = 3;

/// Weight of the difference from the expected length, against the distance from the way: neighbouring lines are told
/// apart by it near their ends, and on a straight line it moves nothing.
const EXPECTED: f64 = 0.1;

/// What the following found.
#[derive(Clone, Debug, Default)]
pub struct Followed {
    /// Length along the way at each sample; NaN where it was not on the way.
    pub length: Vec<f64>,
    /// Distance from the way there, metres, across the normal; NaN likewise.
    pub beside: Vec<f64>,
}

/// Follows `places` along the way. `on[i]` says whether sample `i` is in contact; the others are not looked for. A sample
/// farther from the way than `tolerance` is off it.
pub fn follow(way: &Way, places: &[[f64; 2]], on: &[bool], tolerance: f64) -> Followed {
    let n = places.len();
    let mut found = Followed { length: vec![f64::NAN; n], beside: vec![f64::NAN; n] };
    if way.nodes() < 2 {
        return found;
    }
    // The last sample that was on the way, and where.
    let mut last: Option<(usize, Place)> = None;
    let (mut wait, mut searches) = (0, 0);
    for i in 0..n {
        if !on[i] {
            continue;
        }
        let mut here = last.and_then(|(j, place)| ahead(way, places[i], place, step(places, j, i), tolerance));
        if here.is_none() {
            if wait == 0 && searches < MOST_SEARCHES {
                searches += 1;
                let from = last.map_or(0.0, |(_, place)| place.length - tolerance);
                here = search(way, places, on, i, from, tolerance);
                wait = LOST;
            } else {
                wait = wait.saturating_sub(1);
            }
        }
        if let Some(place) = here {
            wait = 0;
            found.length[i] = place.length;
            found.beside[i] = place.beside;
            last = Some((i, place));
        }
    }
    found
}

#[derive(Clone, Copy)]
struct Place {
    /// The node that ends the segment.
    segment: usize,
    length: f64,
    beside: f64,
}

fn step(places: &[[f64; 2]], a: usize, b: usize) -> f64 {
    libm::hypot(places[b][0] - places[a][0], places[b][1] - places[a][1])
}

/// The place of the way for `p`, after `last` and a move of `moved` metres; `None` if the way is not near.
fn ahead(way: &Way, p: [f64; 2], last: Place, moved: f64, tolerance: f64) -> Option<Place> {
    let expected = last.length + moved;
    let (low, high) = (last.length - tolerance, expected + moved + 2.0 * tolerance);
    let mut first = last.segment;
    while first > 1 && way.length[first - 1] > low {
        first -= 1;
    }
    let mut best: Option<(f64, Place)> = None;
    for i in first.max(1)..way.nodes() {
        if way.length[i - 1] > high {
            break;
        }
        if !way.joined[i] {
            continue;
        }
        let (t, beside) = way.nearest(i, p);
        if beside > tolerance {
            continue;
        }
        let length = way.length_at(i, t);
        let off = EXPECTED * (length - expected);
        let cost = beside * beside + off * off;
        if length >= low && best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, Place { segment: i, length, beside }));
        }
    }
    best.map(|(_, place)| place)
}

/// The place of sample `i` anywhere on the way from the length `from` on: the one from which the next samples follow best.
fn search(way: &Way, places: &[[f64; 2]], on: &[bool], i: usize, from: f64, tolerance: f64) -> Option<Place> {
    let judged: Vec<usize> = (i..places.len()).take_while(|k| on[*k]).take(JUDGED).collect();
    let mut best: Option<(f64, Place)> = None;
    let mut looked = 0;
    for segment in 1..way.nodes() {
        let near = |a: f64, b: f64, p: f64| p >= a.min(b) - tolerance && p <= a.max(b) + tolerance;
        if !way.joined[segment]
            || way.length[segment] < from
            || !near(way.x[segment - 1], way.x[segment], places[i][0])
            || !near(way.y[segment - 1], way.y[segment], places[i][1])
        {
            continue;
        }
        let (t, beside) = way.nearest(segment, places[i]);
        if beside > tolerance || looked == MOST_PLACES {
            continue;
        }
        looked += 1;
        let start = Place { segment, length: way.length_at(segment, t), beside };
        let mut place = start;
        let mut sum = 0.0;
        for pair in judged.windows(2) {
            let moved = step(places, pair[0], pair[1]);
            match ahead(way, places[pair[1]], place, moved, tolerance) {
                Some(next) => {
                    let off = EXPECTED * (next.length - place.length - moved);
                    sum += next.beside * next.beside + off * off;
                    place = next;
                }
                // As bad as a sample can be.
                None => sum += tolerance * tolerance,
            }
        }
        let cost = start.beside * start.beside + sum;
        if cost < 0.5 * judged.len() as f64 * tolerance * tolerance
            && best.as_ref().is_none_or(|(least, _)| cost < *least)
        {
            best = Some((cost, start));
        }
    }
    best.map(|(_, place)| place)
}
