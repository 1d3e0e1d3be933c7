//! Contact: where a program's tool touches the part, and how fast it goes there.
//!
//! In: the [`Trace`] of a program, the nominal surface, the tool's stand-off. Out: a [`TimedPath`] of the stretches on the
//! surface, each from rest to rest, as the prediction reckons with. Nothing of the plan goes in: where lines begin and end is
//! read from where the moves stop, what is lifted from how high the tool stands.

use crate::diagnostics::{Problem, codes};
use crate::dwell::speed::{self, Limits, Segments};
use crate::dwell::{Standing, TimedPath};
use crate::job::{Aperture, Landing};
use crate::path::{Line, Link, landing};
use crate::verify::{Arrival, Trace};
use crate::workpiece::form::Surface;

/// How far the tool may stand from its nominal height and still count as in contact, metres: what an arm itself errs by
/// along the normal, so that every influence function was measured with as much.
pub const CONTACT: f64 = 1e-4;

/// The stand of the tool over the part.
pub struct Stand<'a> {
    pub surface: &'a dyn Surface,
    pub edge: &'a Aperture,
    /// From the contact to the tool centre point along the normal, metres.
    pub standoff: f64,
    /// Height above the contact from which the tool counts as lifted, metres.
    pub lifted: f64,
    /// How far from the contact the tool removes anything, metres.
    pub reach: f64,
    /// How the tool lands on the part and leaves it, if the job lets it.
    pub landing: Option<Landing>,
}

/// The stretches of a program on the surface.
#[derive(Clone, Debug, Default)]
pub struct Contact {
    pub timed: TimedPath,
    /// Farthest that the tool stands from its nominal height over the part, metres.
    pub height: f64,
    /// Farthest that it leans from the normal there, radians.
    pub lean: f64,
    /// Moves whose speed the stated acceleration does not reach; they are reckoned with what it reaches.
    pub too_fast: usize,
}

/// A place over the surface.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    /// Below it on the surface, metres.
    pub contact: [f64; 3],
    /// Outward unit normal there.
    pub normal: [f64; 3],
    /// Of the place above the surface along the normal, metres.
    pub height: f64,
}

/// The foot along its own axis of a tool at `position` with its +z along `axis`, whose height is that above its nominal
/// stand; beside it how far the tool leans, radians. `None` where the form does not exist.
fn foot_of_tool(stand: &Stand, position: [f64; 3], axis: [f64; 3]) -> Option<(Foot, f64)> {
    let tip = [0, 1, 2].map(|k| position[k] + stand.standoff * axis[k]);
    let point = stand.surface.at(tip[0], tip[1])?;
    let normal = point.normal();
    // The surface is nearly plane over the height of a contact; of a lifted tool only that it is lifted counts.
    let height = (tip[2] - point.sag) * normal[2];
    let dot: f64 = -(0..3).map(|k| axis[k] * normal[k]).sum::<f64>();
    let cross = [
        axis[1] * normal[2] - axis[2] * normal[1],
        axis[2] * normal[0] - axis[0] * normal[2],
        axis[0] * normal[1] - axis[1] * normal[0],
    ];
    let sine = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
    Some((Foot { contact: [tip[0], tip[1], point.sag], normal, height }, libm::atan2(sine, dot)))
}

/// The foot of a place on the surface along the normal. `None` where the form does not exist.
pub fn foot_on(surface: &dyn Surface, position: [f64; 3]) -> Option<Foot> {
    let [mut x, mut y, z] = position;
    let mut found = None;
    // Each step leaves the height times the change of the normal over the last step: after three a place 1 mm over a ball of
    // 20 mm radius is found to a tenth of a micrometre.
    let steps = if surface.is_plane() { 1 } else { 4 };
    for _ in 0..steps {
        let point = surface.at(x, y)?;
        let normal = point.normal();
        let d = [position[0] - x, position[1] - y, z - point.sag];
        let height = (0..3).map(|k| d[k] * normal[k]).sum::<f64>();
        found = Some(Foot { contact: [x, y, point.sag], normal, height });
        (x, y) = (position[0] - height * normal[0], position[1] - height * normal[1]);
    }
    found
}

/// The stretches of `trace` on the surface.
///
/// # Errors
///
/// E1300 where the tool stands over the part neither in contact nor lifted: what it removes there is not known.
pub fn of_trace(trace: &Trace, stand: &Stand, acceleration: f64) -> Result<Contact, Problem> {
    let mut found = Contact::default();
    let mut before = false;
    let mut first = 0;
    // Whether the stretch begins where the one before it stopped.
    let mut goes_on = false;
    for i in 0..trace.len() {
        let foot = foot_of_tool(stand, trace.position[i], trace.axis[i]);
        let on = match foot {
            None => false,
            Some((Foot { height, .. }, _)) if height >= stand.lifted => false,
            Some((Foot { contact, height, .. }, lean)) => {
                let over_the_part = stand.edge.distance(contact[0], contact[1]) >= -stand.reach;
                // Written so that a height that is no number is refused.
                if over_the_part && !(height.abs() <= CONTACT) {
                    return Err(neither(contact, height));
                }
                if over_the_part {
                    found.height = found.height.max(height.abs());
                    found.lean = found.lean.max(lean);
                }
                true
            }
        };
        let straight = trace.arrival[i] != Arrival::Joints;
        let follows = on && before && straight;
        let stands = |timed: &mut TimedPath| {
            if let (Some(landing), Some(point)) = (&stand.landing, timed.path.points.len().checked_sub(1)) {
                let seconds = landing::standing(landing, trace.speed[i], acceleration);
                timed.standing.push(Standing { point, seconds });
            }
        };
        if !follows {
            if !goes_on {
                check_goes_somewhere(&found.timed, first, stand)?;
            }
            goes_on = false;
            close(&mut found.timed, first);
            if before && !on && straight {
                stands(&mut found.timed);
            }
            first = found.timed.path.points.len();
        }
        let comes_down = on && !before && straight;
        before = on;
        let Some((Foot { contact, normal, .. }, _)) = foot.filter(|_| on) else { continue };
        found.timed.path.points.push(contact, normal);
        found.timed.speed.push(trace.speed[i]);
        if comes_down {
            stands(&mut found.timed);
        }
        if follows && trace.arrival[i] == Arrival::Stopping {
            // The next stretch begins at rest where this one ends.
            close(&mut found.timed, first);
            first = found.timed.path.points.len();
            goes_on = true;
            found.timed.path.points.push(contact, normal);
            found.timed.speed.push(trace.speed[i]);
        }
    }
    if !goes_on {
        check_goes_somewhere(&found.timed, first, stand)?;
    }
    close(&mut found.timed, first);
    found.too_fast = reachable(&mut found.timed, stand.standoff, acceleration);
    Ok(found)
}

/// E1300 where the tool touches the part in the one point from `first` on and goes nowhere: a touch is no stretch, and what it
/// removes is not reckoned.
fn check_goes_somewhere(timed: &TimedPath, first: usize, stand: &Stand) -> Result<(), Problem> {
    let points = &timed.path.points;
    if points.len() != first + 1 || stand.edge.distance(points.x[first], points.y[first]) < -stand.reach {
        return Ok(());
    }
    let message = format!(
        "the tool touches the part at x {:.3} mm, y {:.3} mm and goes nowhere from there",
        points.x[first] * 1e3 + 0.0,
        points.y[first] * 1e3 + 0.0
    );
    Err(Problem::error(codes::E1300, "target", message)
        .note("what a touch without a move removes is not reckoned")
        .help("put the moves back, and see `polishc verify` for what else differs"))
}

/// Makes a line of the points from `first` on; a single point is no stretch.
fn close(timed: &mut TimedPath, first: usize) {
    let end = timed.path.points.len();
    if end >= first + 2 {
        timed.path.lines.push(Line { points: first..end, link: Link::Lifted });
    } else {
        truncate(timed, first);
    }
}

/// Keeps the first `length` points.
pub fn truncate(timed: &mut TimedPath, length: usize) {
    let points = &mut timed.path.points;
    for values in [
        &mut points.x,
        &mut points.y,
        &mut points.z,
        &mut points.normal_x,
        &mut points.normal_y,
        &mut points.normal_z,
        &mut timed.speed,
    ] {
        values.truncate(length);
    }
    timed.standing.retain(|standing| standing.point < length);
}

/// Lowers the speeds to what the arm reaches; how many were lowered by more than rounding.
fn reachable(timed: &mut TimedPath, standoff: f64, acceleration: f64) -> usize {
    let segments = Segments::new(&timed.path, standoff);
    let mut speeds: Vec<f64> = segments.point.iter().map(|&p| timed.speed[p]).collect();
    speed::limit(&mut speeds, &segments, &Limits::of_arm(acceleration));
    let mut lowered = 0;
    for (&point, &speed) in segments.point.iter().zip(&speeds) {
        // Positions are written to a micrometre, so that a segment of a millimetre may be wrong by a thousandth of itself, and the
        // speed that it is long enough for by half of that.
        lowered += usize::from(speed < timed.speed[point] * (1.0 - 1e-3));
        timed.speed[point] = speed;
    }
    lowered
}

fn neither([x, y, _]: [f64; 3], height: f64) -> Problem {
    let side = if height < 0.0 { "below" } else { "above" };
    let message = format!(
        "at x {:.3} mm, y {:.3} mm the program holds the tool {:.3} mm {side} its contact with the part: neither in \
         contact nor lifted",
        x * 1e3 + 0.0,
        y * 1e3 + 0.0,
        height.abs() * 1e3
    );
    Problem::error(codes::E1300, "target", message)
        .note(format!(
            "within {:.1} mm of the contact the influence function holds; what is removed elsewhere is not known",
            CONTACT * 1e3
        ))
        .help("put the position back, and see `polishc verify` for what else differs")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{Circle, Plane};
    use crate::units::si::{Length, Speed, Time};

    fn trace(moves: &[([f64; 3], f64, Arrival)]) -> Trace {
        Trace {
            position: moves.iter().map(|m| m.0.map(|v| v * 1e-3)).collect(),
            axis: vec![[0.0, 0.0, -1.0]; moves.len()],
            speed: moves.iter().map(|m| m.1 * 1e-3).collect(),
            arrival: moves.iter().map(|m| m.2).collect(),
        }
    }

    fn follow(trace: &Trace) -> Result<Contact, Problem> {
        landing_with(trace, None)
    }

    fn landing_with(trace: &Trace, landing: Option<Landing>) -> Result<Contact, Problem> {
        let edge = Aperture::circle(Circle { diameter: Length(0.04), centre: None });
        let stand = Stand { surface: &Plane {}, edge: &edge, standoff: 1e-3, lifted: 15e-3, reach: 5e-3, landing };
        of_trace(trace, &stand, 0.5)
    }

    use Arrival::{Joints, Passing, Stopping};

    #[test]
    fn stretches_end_where_moves_stop_and_where_the_tool_lifts() {
        // Approach, down, a line of three points, the link, a line of two, up, over, down, one more line.
        let found = follow(&trace(&[
            ([0.0, 0.0, 31.0], 0.0, Joints),
            ([0.0, 0.0, 1.0], 20.0, Stopping),
            ([4.0, 0.0, 1.0], 30.0, Passing),
            ([8.0, 0.0, 1.0], 40.0, Stopping),
            ([8.0, 1.0, 1.0], 15.0, Stopping),
            ([4.0, 1.0, 1.0], 20.0, Stopping),
            ([4.0, 1.0, 31.0], 50.0, Stopping),
            ([0.0, 2.0, 31.0], 50.0, Stopping),
            ([0.0, 2.0, 31.0], 0.0, Joints),
            ([0.0, 2.0, 1.0], 50.0, Stopping),
            ([4.0, 2.0, 1.0], 20.0, Stopping),
            ([4.0, 2.0, 31.0], 50.0, Stopping),
        ]))
        .expect("a path");
        let lines: Vec<Vec<[f64; 2]>> = found
            .timed
            .path
            .lines
            .iter()
            .map(|line| {
                let place = |i: usize| [found.timed.path.points.x[i] * 1e3, found.timed.path.points.y[i] * 1e3];
                line.points.clone().map(place).collect()
            })
            .collect();
        assert_eq!(
            lines,
            [
                vec![[0.0, 0.0], [4.0, 0.0], [8.0, 0.0]],
                vec![[8.0, 0.0], [8.0, 1.0]],
                vec![[8.0, 1.0], [4.0, 1.0]],
                vec![[0.0, 2.0], [4.0, 2.0]],
            ]
        );
        assert_eq!(found.timed.path.points.z, vec![0.0; 9]);
        assert_eq!(found.too_fast, 0);
        let speeds: Vec<f64> = [1, 2, 4, 6, 8].map(|i| (found.timed.speed[i] * 1e3).round()).to_vec();
        assert_eq!(speeds, [30.0, 40.0, 15.0, 20.0, 20.0]);
    }

    #[test]
    fn a_tool_that_lands_stands_at_both_ends_of_a_run() {
        let moves = [
            ([0.0, 0.0, 31.0], 0.0, Joints),
            ([0.0, 0.0, 1.0], 10.0, Stopping),
            ([4.0, 0.0, 1.0], 20.0, Stopping),
            ([8.0, 0.0, 1.0], 20.0, Stopping),
            ([8.0, 0.0, 31.0], 10.0, Stopping),
        ];
        let landing = Landing { speed: Speed(0.01), reach: Length(2e-3), stand: Time(0.2) };
        let found = landing_with(&trace(&moves), Some(landing)).expect("a path").timed;
        // By hand, as on the page of paths: 0.11 s of way down and 0.2 s of standing.
        let places: Vec<(f64, f64)> = found
            .standing
            .iter()
            .map(|s| (found.path.points.x[s.point] * 1e3, (s.seconds * 1e6).round() / 1e6))
            .collect();
        assert_eq!(places, [(0.0, 0.309917), (8.0, 0.309917)]);
        assert!(follow(&trace(&moves)).expect("a path").timed.standing.is_empty());
    }

    #[test]
    fn what_the_arm_does_not_reach_is_counted() {
        // From rest over 1 mm and back to rest at 0.5 m/s²: half of it speeds up, v² = a ds, 22.36 mm/s.
        let found = follow(&trace(&[([0.0, 0.0, 1.0], 20.0, Stopping), ([1.0, 0.0, 1.0], 60.0, Stopping)]));
        let found = found.expect("a path");
        assert_eq!(found.too_fast, 1);
        assert!((found.timed.speed[1] - 0.5e-3f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_tool_that_hovers_over_the_part_is_refused() {
        for height in [1.3, 0.8, 9.0, -3.0, f64::NAN] {
            let moves = [([0.0, 0.0, 1.0], 20.0, Stopping), ([4.0, 0.0, height], 20.0, Stopping)];
            let problem = follow(&trace(&moves)).expect_err("neither in contact nor lifted");
            assert_eq!(problem.code, codes::E1300, "{height}");
        }
        // Far beside the part nobody minds.
        let moves = [([60.0, 0.0, 1.3], 20.0, Stopping), ([64.0, 0.0, 1.3], 20.0, Stopping)];
        assert!(follow(&trace(&moves)).is_ok());
    }
}
