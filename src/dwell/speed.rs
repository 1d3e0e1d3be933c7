//! Speeds: what the arm can do between two points, and what it then really does.
//!
//! In: a path, wanted times of its segments, feed limits and acceleration. Out: programmed speeds that the arm can
//! follow and the target can write, and the time that each part of a segment really takes.
//!
//! Model of the motion. The programmed speed is constant over a segment. The tool enters a segment with the speed of
//! the one before and changes to the new speed at once, with constant acceleration `a`; a line starts from rest and
//! comes to rest at the end of its last segment. So a segment of length `ds` holds one change, and the last one of a
//! line two, to each of which half of its length is given:
//!
//! ```text
//! |v_i² - v_(i-1)²| <= 2 a ds_i        and in the last segment |v_n² - v_(n-1)²| <= a ds_n,  v_n² <= a ds_n
//! v_i² kappa_i <= a_lateral             kappa_i the sharper curvature of the way at the two ends of the segment
//! ```
//!
//! The curvature at a point of the way is the angle by which it turns there over the mean length of the two segments.
//! Every change of speed ends inside its segment. A segment entered at u and programmed at v takes
//! `ds/v + (v - u)|v - u| / (2 a v)`, the last one of a line `v/(2a)` more.

use super::SpeedSteps;
use super::removal::segments;
use crate::job::Corrective;
use crate::path::ToolPath;
use rayon::prelude::*;
use std::ops::Range;

/// What limits the speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Programmed speeds, m/s.
    pub least: f64,
    pub greatest: f64,
    /// Along the way, m/s².
    pub acceleration: f64,
    /// Across the way, m/s².
    pub lateral: f64,
}

impl Limits {
    /// Of an arm alone, in m/s²: no feed is too slow or too fast.
    pub fn of_arm(acceleration: f64) -> Limits {
        Limits { least: 0.0, greatest: f64::INFINITY, acceleration, lateral: f64::INFINITY }
    }

    /// Of the job. What is not said of the way across holds as along it: an arm does not know the direction of the path.
    pub fn of(dwell: &Corrective) -> Limits {
        let acceleration = dwell.acceleration.0;
        Limits {
            least: dwell.feed.from.0,
            greatest: dwell.feed.to.0,
            acceleration,
            lateral: dwell.lateral_acceleration.map_or(acceleration, |lateral| lateral.0),
        }
    }
}

/// The segments of a path, line by line.
#[derive(Clone, Debug, Default)]
pub struct Segments {
    /// Metres, along the straight way of the tool centre point, to which programmed speeds belong: over a hollow part it is
    /// shorter than that of the contact, over a convex one longer.
    pub length: Vec<f64>,
    /// Segments of line `i` are `start[i] .. start[i + 1]`; a line of one point has none.
    pub start: Vec<usize>,
    /// The point that ends each segment.
    pub point: Vec<usize>,
    /// The sharper curvature of the way at the two ends of each segment, 1/m.
    pub curvature: Vec<f64>,
}

impl Segments {
    /// Of a tool whose centre point stands `standoff` metres off the contact, along the normal.
    pub fn new(path: &ToolPath, standoff: f64) -> Segments {
        let point: Vec<usize> = segments(path).collect();
        let tool = |i: usize| path.points.off_surface(i, standoff);
        let way = |p: usize| {
            let (a, b) = (tool(p - 1), tool(p));
            [0, 1, 2].map(|k| b[k] - a[k])
        };
        let size = |d: [f64; 3]| libm::hypot(libm::hypot(d[0], d[1]), d[2]);
        let length: Vec<f64> = point.iter().map(|&p| size(way(p))).collect();
        let mut start = vec![0];
        for line in &path.lines {
            start.push(start[start.len() - 1] + line.points.len().saturating_sub(1));
        }
        let mut curvature = vec![0.0f64; length.len()];
        for line in start.windows(2) {
            for i in line[0] + 1..line[1] {
                let (before, after) = (way(point[i - 1]), way(point[i]));
                let apart = size([0, 1, 2].map(|k| after[k] / length[i] - before[k] / length[i - 1]));
                let turn = 2.0 * libm::asin((0.5 * apart).min(1.0));
                let here = turn / (0.5 * (length[i - 1] + length[i]));
                curvature[i - 1] = here.max(curvature[i - 1]);
                curvature[i] = here;
            }
        }
        Segments { length, start, point, curvature }
    }

    /// The greatest speed of segment `i` alone: the feed, and what its corners allow.
    pub fn greatest(&self, i: usize, limits: &Limits) -> f64 {
        limits.greatest.min((limits.lateral / self.curvature[i]).sqrt())
    }

    /// By how much the square of the speed may change in segment `i`: in the last of a line half of the way is for the stop.
    pub fn change(&self, i: usize, last: bool, limits: &Limits) -> f64 {
        if last { limits.acceleration * self.length[i] } else { 2.0 * limits.acceleration * self.length[i] }
    }

    pub(super) fn lines(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        self.start.windows(2).map(|pair| pair[0]..pair[1]).filter(|line| !line.is_empty())
    }

    /// Changes the entries of each line by itself, on all cores.
    pub(super) fn each_line(&self, values: &mut [f64], change: impl Fn(Range<usize>, &mut [f64]) + Sync) {
        let mut rest = values;
        let mut lines = Vec::with_capacity(self.start.len());
        for line in self.lines() {
            let (entries, after) = rest.split_at_mut(line.len());
            lines.push((line, entries));
            rest = after;
        }
        lines.into_par_iter().for_each(|(line, entries)| change(line, entries));
    }
}

/// Lowers speeds until the arm can follow them. Only ever slows down, and never below the least feed: a neighbour's
/// speed plus what can be gained on the way is more than the neighbour's.
pub fn limit(speeds: &mut [f64], segments: &Segments, limits: &Limits) {
    slow_down(speeds, segments, limits, |square| square.sqrt());
}

/// The same for speeds that a target can write, which stay so.
fn slow_down(speeds: &mut [f64], segments: &Segments, limits: &Limits, root: impl Fn(f64) -> f64 + Sync) {
    segments.each_line(speeds, |line, speeds| {
        let last = line.len() - 1;
        let change = |i: usize| segments.change(line.start + i, i == last, limits);
        let half = change(last);
        let mut before = 0.0;
        for (i, speed) in speeds.iter_mut().enumerate() {
            let most = before * before + change(i);
            if *speed * *speed > most {
                *speed = root(most);
            }
            before = *speed;
        }
        if speeds[last] * speeds[last] > half {
            speeds[last] = root(half);
        }
        for i in (0..last).rev() {
            let most = speeds[i + 1] * speeds[i + 1] + change(i + 1);
            if speeds[i] * speeds[i] > most {
                speeds[i] = root(most);
            }
        }
    });
}

/// What a change of speed from `before` to `speed` adds to the time of its segment, seconds (negative when slowing).
fn change_time(before: f64, speed: f64, acceleration: f64) -> f64 {
    (speed - before) * (speed - before).abs() / (2.0 * acceleration * speed)
}

/// Time that every segment takes, seconds.
pub fn times(speeds: &[f64], segments: &Segments, limits: &Limits) -> Vec<f64> {
    let mut times = vec![0.0; speeds.len()];
    times_into(speeds, segments, limits, &mut times);
    times
}

/// The same into `times`.
pub(super) fn times_into(speeds: &[f64], segments: &Segments, limits: &Limits, times: &mut [f64]) {
    segments.each_line(times, |line, times| {
        let mut before = 0.0;
        for (i, time) in line.zip(times.iter_mut()) {
            *time = segments.length[i] / speeds[i] + change_time(before, speeds[i], limits.acceleration);
            before = speeds[i];
        }
        if let Some(last) = times.last_mut() {
            *last += before / (2.0 * limits.acceleration);
        }
    });
}

/// Speeds for wanted times, within the feed limits and what the arm can follow. The time that the changes of speed add
/// or take is allowed for to first order; what is left appears in the prediction, which uses the full model.
pub fn for_times(times: &[f64], segments: &Segments, limits: &Limits) -> Vec<f64> {
    let mut speeds: Vec<f64> = times
        .iter()
        .enumerate()
        .map(|(i, time)| (segments.length[i] / time).max(limits.least).min(segments.greatest(i, limits)))
        .collect();
    limit(&mut speeds, segments, limits);
    let plain = speeds.clone();
    for line in segments.lines() {
        let last = line.end - 1;
        let mut before = 0.0;
        for i in line {
            let mut extra = change_time(before, plain[i], limits.acceleration);
            if i == last {
                extra += plain[i] / (2.0 * limits.acceleration);
            }
            before = plain[i];
            // A ramp that alone takes longer than wanted cannot be made up for.
            if times[i] > extra {
                let wanted = segments.length[i] / (times[i] - extra);
                speeds[i] = wanted.max(limits.least).min(segments.greatest(i, limits));
            }
        }
    }
    limit(&mut speeds, segments, limits);
    speeds
}

/// Speeds as the target can write them, inside the same limits.
pub fn round(speeds: &mut [f64], segments: &Segments, limits: &Limits, steps: SpeedSteps) {
    let least = steps.up(limits.least);
    let down = |speed: f64| steps.down(speed).max(least);
    for (i, speed) in speeds.iter_mut().enumerate() {
        *speed = steps.nearest(*speed).max(least).min(down(segments.greatest(i, limits)));
    }
    slow_down(speeds, segments, limits, |square| down(square.sqrt()));
}

/// The moments at which the tool passes the ends of `parts` equal parts of a segment of `length`, entered at `before`
/// and programmed at `speed`; `stops` if it comes to rest at its end. Calls `each(part, time)` with the time spent in
/// each part, seconds.
pub fn part_times(
    (length, parts): (f64, usize),
    (before, speed, stops): (f64, f64, bool),
    acceleration: f64,
    mut each: impl FnMut(usize, f64),
) {
    // Length of the change at the start, and of the stop at the end.
    let start = ((speed * speed - before * before) / (2.0 * acceleration)).abs();
    let stop = if stops { speed * speed / (2.0 * acceleration) } else { 0.0 };
    let sign = if speed >= before { 1.0 } else { -1.0 };
    let start_time = (speed - before).abs() / acceleration;
    // `rest` is what is left of the segment; it is passed beside `s` so that it vanishes exactly at the end, where the
    // root would blow up its rounding.
    let when = |s: f64, rest: f64| {
        if s < start {
            let now = (before * before + 2.0 * sign * acceleration * s).max(0.0).sqrt();
            (now - before).abs() / acceleration
        } else if rest >= stop {
            start_time + (s - start) / speed
        } else {
            let now = (2.0 * acceleration * rest).sqrt();
            start_time + (length - stop - start) / speed + (speed - now) / acceleration
        }
    };
    let mut earlier = 0.0;
    for part in 0..parts {
        let share = |count: usize| length * count as f64 / parts as f64;
        let now = when(share(part + 1), share(parts - part - 1));
        each(part, now - earlier);
        earlier = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// One line of segments of these lengths in metres.
    fn line(lengths: &[f64]) -> Segments {
        Segments {
            length: lengths.to_vec(),
            start: vec![0, lengths.len()],
            point: (1..=lengths.len()).collect(),
            curvature: vec![0.0; lengths.len()],
        }
    }

    const LIMITS: Limits = Limits { least: 1e-4, greatest: 0.1, acceleration: 0.5, lateral: 0.5 };

    #[test]
    fn full_feed_follows_the_ramp_of_constant_acceleration() {
        // 4 mm segments at 0.5 m/s²: v² grows by 2 a ds = 0.004 m²/s² a segment, so v = sqrt(0.004 n), full feed
        // (0.01) within three: 0.0632, 0.0894, 0.1. The last segment holds v² <= a ds = 0.002: 0.0447; before it
        // v² <= 0.002 + 0.002 = 0.004, and 0.008 before that.
        let segments = line(&[4e-3; 8]);
        let mut speeds = [0.1; 8];
        limit(&mut speeds, &segments, &LIMITS);
        let expected = [0.004, 0.008, 0.01, 0.01, 0.01, 0.008, 0.004, 0.002].map(|square: f64| square.sqrt());
        for (found, expected) in speeds.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn time_of_an_accelerating_segment() {
        // From rest to 0.05 m/s at 0.5 m/s²: 0.1 s and 2.5 mm. The other 2.5 mm of the first segment at 0.05 m/s:
        // 0.05 s. Second, 0.04 m/s: the change takes 0.02 s and (0.0025 - 0.0016) / 1 = 0.9 mm, the other 4.1 mm 0.1025 s,
        // of which the stop from 0.04 m/s takes 1.6 mm in 0.08 s instead of 0.04 s: 0.04 s more.
        let segments = line(&[5e-3, 5e-3]);
        let found = times(&[0.05, 0.04], &segments, &LIMITS);
        assert!((found[0] - 0.15).abs() < 1e-15 && (found[1] - (0.02 + 0.1025 + 0.04)).abs() < 1e-15, "{found:?}");
    }

    #[test]
    fn parts_of_an_accelerating_segment() {
        // The first segment above in four parts of 1.25 mm: sqrt(2 s / a) = 0.0707 s to 1.25 mm, 0.1 s to 2.5 mm, then
        // 0.025 s each.
        let mut found = Vec::new();
        part_times((5e-3, 4), (0.0, 0.05, false), 0.5, |_, time| found.push(time));
        let expected = [0.005f64.sqrt(), 0.1 - 0.005f64.sqrt(), 0.025, 0.025];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
        // And the second, which stops: half of it, 2.5 mm, is passed after 0.02 s and (2.5 - 0.9) / 40 = 0.04 s.
        found.clear();
        part_times((5e-3, 2), (0.05, 0.04, true), 0.5, |_, time| found.push(time));
        assert!((found[0] - 0.06).abs() < 1e-15 && (found[0] + found[1] - 0.1625).abs() < 1e-15);
    }

    #[test]
    fn corners_limit_both_segments_beside_them() {
        // A square corner between two moves of 2 mm, then a straight one: a turn of pi/2 over 2 mm. 0.5 m/s² allow
        // sqrt(0.5 * 2 mm / (pi/2)) = 25.2 mm/s.
        let mut path = ToolPath::default();
        for [x, y] in [[0.0, 0.0], [2e-3, 0.0], [2e-3, 2e-3], [2e-3, 4e-3]] {
            path.points.push([x, y, 0.0], [0.0, 0.0, 1.0]);
        }
        path.lines.push(crate::path::Line { points: 0..4, link: crate::path::Link::Lifted });
        let segments = Segments::new(&path, 0.0);
        let corner = (0.5 * 2e-3 / std::f64::consts::FRAC_PI_2).sqrt();
        for (i, expected) in [corner, corner, 0.1].into_iter().enumerate() {
            assert!((segments.greatest(i, &LIMITS) - expected).abs() < 1e-15, "{i}");
        }
        // Steps of half a degree on a circle of 50 mm: 1/r to the square of the half step.
        let mut path = ToolPath::default();
        for i in 0..20 {
            let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::PI / 360.0);
            path.points.push([50e-3 * cos, 50e-3 * sin, 0.0], [0.0, 0.0, 1.0]);
        }
        path.lines.push(crate::path::Line { points: 0..20, link: crate::path::Link::Lifted });
        for curvature in Segments::new(&path, 0.0).curvature {
            assert!((curvature * 50e-3 - 1.0).abs() < 1e-5, "{curvature}");
        }
    }

    proptest! {
        #[test]
        fn what_is_limited_can_be_followed(
            lengths in prop::collection::vec(1e-3f64..6e-3, 1..12),
            wanted in prop::collection::vec(1e-3f64..0.1, 12),
            acceleration in 0.01f64..2.0,
            step in prop::sample::select(vec![1e-3, 1e-4, 1e-5, 1e-6, 1e-7]),
        ) {
            let segments = line(&lengths);
            let n = lengths.len();
            let limits = Limits { least: 1e-3, greatest: 0.1, acceleration, lateral: acceleration };
            let mut speeds = wanted[..n].to_vec();
            round(&mut speeds, &segments, &limits, SpeedSteps::Fixed(step));
            let mut before = 0.0f64;
            for i in 0..n {
                let v = speeds[i];
                // Whole multiples, inside the feed, never faster than asked by more than half a step.
                let count = v / step;
                prop_assert!((count - count.round()).abs() < 1e-6);
                prop_assert!(v >= limits.least * (1.0 - 1e-9) && v <= limits.greatest);
                prop_assert!(v <= wanted[i] + 0.5000001 * step);
                // The change fits its segment; the last holds the stop too, and together they are no longer than it.
                let change = (v * v - before * before).abs() / (2.0 * acceleration);
                let stop = if i + 1 == n { v * v / (2.0 * acceleration) } else { 0.0 };
                prop_assert!(change + stop <= lengths[i] * (1.0 + 1e-9), "segment {}: {} + {} in {}", i, change, stop, lengths[i]);
                // The parts of a segment add up to its time.
                let mut sum = 0.0;
                part_times((lengths[i], 5), (before, v, i + 1 == n), acceleration, |_, time| sum += time);
                let whole = times(&speeds, &segments, &limits)[i];
                prop_assert!((sum - whole).abs() < 1e-9 * whole, "{} {}", sum, whole);
                before = v;
            }
        }

        #[test]
        fn speeds_for_times_take_those_times(
            slowness in prop::collection::vec(0.0f64..1.0, 40),
        ) {
            // Smooth times, as a spot asks for: 20 to 30 mm/s, over many segments of 2 mm at 0.5 m/s².
            let n = slowness.len();
            let segments = line(&vec![2e-3; n]);
            let smooth = |i: usize| {
                let near: Vec<f64> = (i.saturating_sub(6)..(i + 7).min(n)).map(|k| slowness[k]).collect();
                near.iter().sum::<f64>() / near.len() as f64
            };
            let wanted: Vec<f64> = (0..n).map(|i| 2e-3 / (0.02 + 0.01 * smooth(i))).collect();
            let speeds = for_times(&wanted, &segments, &LIMITS);
            let found = times(&speeds, &segments, &LIMITS);
            // Apart from the start and the stop, where the arm sets the pace.
            for i in 2..n - 2 {
                prop_assert!((found[i] - wanted[i]).abs() < 1e-4 * wanted[i], "{}: {} {}", i, found[i], wanted[i]);
            }
        }
    }
}
