//! As run: what a machine did, by its log, against the plan.
//!
//! In: a [`Log`], the plan. Out: an [`AsRun`]: the way of the contact with the speeds that were driven, which the
//! prediction takes like a plan, and where the run departs from the plan.
//!
//! What a log cannot say: how hard the tool pressed, whether the process ran, what happened between two samples. Positions
//! are those of the point that was recorded; an error of the frame that it was recorded in is an error of the removal map.

use super::contact::{Foot, Stand, foot_on, truncate};
use super::follow::{Followed, Way, follow};
use super::log::Log;
use crate::diagnostics::{Problem, codes};
use crate::dwell::TimedPath;
use crate::job::Aperture;
use crate::path::{Line, Link};

/// A tool farther than this from its usual height is lifted (or pressed in), metres: arms err by tenths of a millimetre, and
/// travel heights begin at 5 mm.
const LIFTED: f64 = 2e-3;

/// Least part of the samples in contact that must be on the path. A run in another frame or unit is on it by chance only,
/// where it crosses lines; a good one is everywhere but at a disturbance.
const LEAST_ON_PATH: f64 = 0.9;

/// Least way along the path against the samples' own: they are the same but for corners that samples cut, and nothing of it
/// is left where places are near the path by chance.
const LEAST_PROGRESS: f64 = 0.5;

/// Samples are a hole when they lie farther apart in time than this many usual intervals.
const HOLE: f64 = 5.0;

/// Standing longer than this, beyond what is planned, is a stop, seconds: in half a second an ordinary spot of 10 to 50 nm/s
/// makes a pit that an interferometer sees.
const STOP: f64 = 0.5;

/// Parts of the spot's sigma: a place that is left by less is not left, and pieces of the way that are shorter are joined.
/// A spot moved by a twentieth of its sigma removes the same within 0.1 %.
const STANDING: f64 = 1.0 / 20.0;

/// What the log is compared with.
pub struct Plan<'a> {
    pub timed: &'a TimedPath,
    /// Distance of neighbouring lines, metres.
    pub line_pitch: f64,
    /// m/s².
    pub acceleration: f64,
    pub clear: &'a Aperture,
    /// Width of the spot, metres.
    pub sigma: f64,
}

/// A place on the part, metres, and what happened there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct At {
    pub place: [f64; 2],
    /// Seconds, or metres, or a share, as the list says.
    pub value: f64,
}

/// What a run was.
#[derive(Clone, Debug, Default)]
pub struct AsRun {
    /// The way of the contact; the speed of every move is its length over the time that it took.
    pub timed: TimedPath,
    pub samples: usize,
    /// Usual seconds between two samples.
    pub interval: f64,
    /// Seconds from the first sample to the last.
    pub duration: f64,
    /// Part of the samples in contact that lie on the path.
    pub on_path: f64,
    /// Usual height of the recorded point above the surface, metres.
    pub height: f64,
    /// Usual and greatest distance of the samples from the path, across the normal, metres.
    pub beside: f64,
    pub most_beside: At,
    /// Over the clear aperture, of stretches as long as the spot is wide: actual over planned speed, less 1.
    pub mean_speed: f64,
    pub rms_speed: f64,
    pub most_speed: At,
    /// Times that the machine stood over the part, beyond the plan: seconds.
    pub stops: Vec<At>,
    /// Times without samples while the machine went on: seconds, where they begin. Nothing is reckoned to be removed.
    pub holes: Vec<At>,
    /// Part of the path over the clear aperture that no sample tells of.
    pub missing: f64,
}

/// Compares a log with the plan.
///
/// # Errors
///
/// E1306 where the log does not follow the path, as one in another frame or unit does not.
pub fn as_run(log: &Log, plan: &Plan, stand: &Stand) -> Result<AsRun, Problem> {
    let n = log.time.len();
    let mut run = AsRun { samples: n, duration: log.time[n - 1] - log.time[0], ..AsRun::default() };
    run.interval = median(log.time.windows(2).map(|pair| pair[1] - pair[0]));
    let feet: Vec<Option<Foot>> = log.position.iter().map(|p| foot_on(stand.surface, *p)).collect();
    run.height = median(feet.iter().flatten().map(|foot| foot.height));
    // A log tells of the contact or of the tool centre point; a height that is no number is neither.
    let near = |height: f64| (run.height - height).abs() <= LIFTED;
    if !(near(0.0) || near(stand.standoff)) {
        let message = format!(
            "the log lies {:.3} mm above the surface, where the tool centre point goes at {:.3} mm",
            run.height * 1e3,
            stand.standoff * 1e3
        );
        return Err(another_frame(message));
    }
    let on: Vec<bool> =
        feet.iter().map(|foot| foot.is_some_and(|foot| (foot.height - run.height).abs() <= LIFTED)).collect();
    let places: Vec<[f64; 2]> =
        feet.iter().map(|foot| foot.map_or([f64::NAN; 2], |foot| [foot.contact[0], foot.contact[1]])).collect();
    let way = Way::new(plan.timed, stand.standoff, plan.acceleration);
    let followed = follow(&way, &places, &on, plan.sigma);
    on_the_path(&mut run, &followed, &places, &on, plan)?;
    let holes = holes(&mut run, log, &places, &on, plan);
    run.timed = contact(log, &feet, &on, &holes, plan.sigma);
    speeds(&mut run, log, &followed, &holes, &way, plan);
    stops(&mut run, log, &places, &on, &followed, &way, (plan, stand));
    missing(&mut run, &followed, &holes, &way, plan);
    Ok(run)
}

fn another_frame(message: String) -> Problem {
    Problem::error(codes::E1306, "log", message)
        .note("positions must be in the part frame, which is the program's object frame, and of the run of this job")
        .help("check the frame and the unit of the log, and that it belongs to this program")
}

/// The middle value; NaN of nothing.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut all: Vec<f64> = values.collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}

/// How well the run lies on the path.
fn on_the_path(
    run: &mut AsRun,
    followed: &Followed,
    places: &[[f64; 2]],
    on: &[bool],
    plan: &Plan,
) -> Result<(), Problem> {
    let in_contact = on.iter().filter(|on| **on).count();
    let matched = followed.length.iter().filter(|length| !length.is_nan()).count();
    run.on_path = if in_contact == 0 { 0.0 } else { matched as f64 / in_contact as f64 };
    if run.on_path < LEAST_ON_PATH || matched < 2 {
        let share = run.on_path * 100.0;
        return Err(another_frame(format!(
            "the log does not follow the path of the job: {share:.1} % of its {in_contact} samples in contact lie on it, \
             in order and within {:.3} mm",
            plan.sigma * 1e3
        )));
    }
    let (gone, along) = progress(followed, places, plan.sigma);
    if !(gone > 0.0 && along >= LEAST_PROGRESS * gone) {
        return Err(another_frame(format!(
            "the log does not go along the path of the job: while it goes {:.3} mm, the nearest place of the path goes on by {:.3} mm",
            gone * 1e3,
            along * 1e3
        )));
    }
    run.beside = median(followed.beside.iter().copied().filter(|beside| !beside.is_nan()));
    if run.beside > plan.line_pitch / 2.0 {
        return Err(another_frame(format!(
            "the log runs {:.3} mm beside the path, more than half of the {:.3} mm between two lines: which line it is on \
             cannot be told",
            run.beside * 1e3,
            plan.line_pitch * 1e3
        )));
    }
    let beside = followed.beside.iter().zip(places).filter(|(beside, _)| !beside.is_nan());
    run.most_beside = greatest(beside.map(|(value, place)| At { place: *place, value: *value }));
    Ok(())
}

/// How far the samples that lie on the path go, in steps of half a spot's width, and how far the path goes on meanwhile.
fn progress(followed: &Followed, places: &[[f64; 2]], sigma: f64) -> (f64, f64) {
    let (mut gone, mut along) = (0.0, 0.0);
    let mut last: Option<([f64; 2], f64)> = None;
    for (place, length) in places.iter().zip(&followed.length).filter(|(_, length)| !length.is_nan()) {
        let Some((from, before)) = last else {
            last = Some((*place, *length));
            continue;
        };
        let step = libm::hypot(place[0] - from[0], place[1] - from[1]);
        if step >= sigma / 2.0 {
            gone += step;
            along += length - before;
            last = Some((*place, *length));
        }
    }
    (gone, along)
}

/// The entry of greatest size; the first of equals.
fn greatest(all: impl Iterator<Item = At>) -> At {
    all.fold(At::default(), |most, at| if at.value.abs() > most.value.abs() { at } else { most })
}

/// Whether nothing is known between the samples `i - 1` and `i`.
fn holes(run: &mut AsRun, log: &Log, places: &[[f64; 2]], on: &[bool], plan: &Plan) -> Vec<bool> {
    let mut hole = vec![false; places.len()];
    for i in 1..places.len() {
        let (a, b) = (places[i - 1], places[i]);
        let late = log.time[i] - log.time[i - 1];
        // A machine that did not go far meanwhile was somewhere on the straight way.
        let far = libm::hypot(b[0] - a[0], b[1] - a[1]) > 2.0 * plan.sigma;
        if on[i - 1] && on[i] && late > HOLE * run.interval && far {
            hole[i] = true;
            run.holes.push(At { place: a, value: late });
        }
    }
    hole
}

/// The way of the contact, in stretches without lifting and without holes.
fn contact(log: &Log, feet: &[Option<Foot>], on: &[bool], holes: &[bool], sigma: f64) -> TimedPath {
    let least = STANDING * sigma;
    let mut timed = TimedPath::default();
    let mut i = 0;
    while i < feet.len() {
        let Some(Foot { contact: place, normal, .. }) = feet[i].filter(|_| on[i]) else {
            i += 1;
            continue;
        };
        let first = timed.path.points.len();
        timed.path.points.push(place, normal);
        timed.speed.push(0.0);
        let (mut kept, mut since) = (place, log.time[i]);
        let mut direction = [1.0, 0.0, 0.0];
        let mut push = |timed: &mut TimedPath, place: [f64; 3], normal, kept: [f64; 3], time: f64| {
            let d = [0, 1, 2].map(|k| place[k] - kept[k]);
            let length = d.iter().map(|d| d * d).sum::<f64>().sqrt();
            timed.path.points.push(place, normal);
            timed.speed.push(length / time);
            direction = d.map(|d| d / length);
        };
        i += 1;
        while i < feet.len() && on[i] && !holes[i] {
            let Some(Foot { contact: place, normal, .. }) = feet[i] else { break };
            let square: f64 = (0..3).map(|k| (place[k] - kept[k]) * (place[k] - kept[k])).sum();
            if square >= least * least {
                push(&mut timed, place, normal, kept, log.time[i] - since);
                (kept, since) = (place, log.time[i]);
            }
            i += 1;
        }
        // Time that was spent standing at the end belongs there.
        let (end, rest) = (timed.path.points.len(), log.time[i - 1] - since);
        if rest > 0.0 {
            let normal = timed.path.points.normal(end - 1);
            let beside = [0, 1, 2].map(|k| kept[k] + least * direction[k]);
            timed.path.points.push(beside, normal);
            timed.speed.push(least / rest);
        }
        let points = first..timed.path.points.len();
        if points.len() >= 2 {
            timed.path.lines.push(Line { points, link: Link::Lifted });
        } else {
            // A single sample has no duration.
            truncate(&mut timed, first);
        }
    }
    timed
}

/// Speeds of stretches as long as the spot is wide (or three samples, where these lie farther apart).
fn speeds(run: &mut AsRun, log: &Log, followed: &Followed, holes: &[bool], way: &Way, plan: &Plan) {
    let pairs = || {
        (1..log.time.len()).filter(|i| !holes[*i]).filter_map(|i| {
            let (a, b) = (followed.length[i - 1], followed.length[i]);
            (!a.is_nan() && !b.is_nan()).then_some((i, a, b))
        })
    };
    let spacing = median(pairs().map(|(_, a, b)| b - a).filter(|step| *step > 0.0));
    let stretch = plan.sigma.max(3.0 * spacing);
    if !(stretch > 0.0) {
        return;
    }
    let (mut planned, mut actual, mut squares, mut worst) = (0.0, 0.0, 0.0, At::default());
    // Where the current stretch began: length and time.
    let mut from: Option<(f64, f64)> = None;
    let mut before = 0;
    for (i, a, b) in pairs() {
        if before + 1 != i {
            from = None;
        }
        before = i;
        let start = *from.get_or_insert((a, log.time[i - 1]));
        if b - start.0 < stretch {
            continue;
        }
        let ([place, end], [t0, t1]) = {
            let (p, t0) = way.at(start.0);
            let (q, t1) = way.at(b);
            ([p, q], [t0, t1])
        };
        let (wanted, took) = (t1 - t0, log.time[i] - start.1);
        let middle = [0, 1].map(|k| (place[k] + end[k]) / 2.0);
        if plan.clear.contains(middle[0], middle[1]) && wanted > 0.0 && took > 0.0 {
            let off = wanted / took - 1.0;
            planned += wanted;
            actual += took;
            squares += wanted * off * off;
            if off.abs() > worst.value.abs() {
                worst = At { place: middle, value: off };
            }
        }
        from = Some((b, log.time[i]));
    }
    if planned > 0.0 {
        run.mean_speed = planned / actual - 1.0;
        run.rms_speed = (squares / planned).sqrt();
        run.most_speed = worst;
    }
}

/// Where the machine stood over the part.
fn stops(
    run: &mut AsRun,
    log: &Log,
    places: &[[f64; 2]],
    on: &[bool],
    followed: &Followed,
    way: &Way,
    (plan, stand): (&Plan, &Stand),
) {
    let near = STANDING * plan.sigma;
    let mut i = 0;
    while i < places.len() {
        let [x, y] = places[i];
        if !on[i] {
            i += 1;
            continue;
        }
        let mut end = i;
        while end + 1 < places.len()
            && on[end + 1]
            && libm::hypot(places[end + 1][0] - x, places[end + 1][1] - y) <= near
        {
            end += 1;
        }
        let stood = log.time[end] - log.time[i];
        if stood > STOP && stand.edge.distance(x, y) >= -stand.reach {
            let length = followed.length[i];
            let planned = if length.is_nan() { 0.0 } else { way.at(length + near).1 - way.at(length - near).1 };
            if stood - planned > STOP {
                run.stops.push(At { place: [x, y], value: stood - planned });
            }
        }
        i = end + 1;
    }
}

/// The part of the path over the clear aperture that the log does not tell of.
fn missing(run: &mut AsRun, followed: &Followed, holes: &[bool], way: &Way, plan: &Plan) {
    // Told are the ways from sample to sample, where no hole lies between.
    let mut told: Vec<[f64; 2]> = Vec::new();
    let mut last: Option<f64> = None;
    for (length, hole) in followed.length.iter().zip(holes) {
        if length.is_nan() {
            continue;
        }
        match (last, told.last_mut()) {
            // Samples that skip more than a few spots have left the path in between.
            (Some(before), Some(open)) if !hole && length - before < 5.0 * plan.sigma => {
                open[0] = open[0].min(*length);
                open[1] = open[1].max(*length);
            }
            _ => told.push([*length; 2]),
        }
        last = Some(*length);
    }
    told.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut whole, mut known, mut next) = (0.0, 0.0, 0);
    for i in 1..way.nodes() {
        let (a, b) = (way.length[i - 1], way.length[i]);
        let middle = [(way.x[i - 1] + way.x[i]) / 2.0, (way.y[i - 1] + way.y[i]) / 2.0];
        if !(b > a && plan.clear.contains(middle[0], middle[1])) {
            continue;
        }
        whole += b - a;
        while next < told.len() && told[next][1] <= a {
            next += 1;
        }
        let over = told[next..].iter().take_while(|[from, _]| *from < b);
        known += over.map(|[from, to]| (to.min(b) - from.max(a)).max(0.0)).sum::<f64>().min(b - a);
    }
    run.missing = if whole > 0.0 { (1.0 - known / whole).max(0.0) } else { 0.0 };
}
