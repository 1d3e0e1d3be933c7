//! Single moves: their values with names resolved, and the comparisons that all of them share.
//!
//! In: a move of the text. Out: [`Resolved`], numbers as the controller stores them, or words for what differs. Lengths
//! here are the text's millimetres, angles the text's degrees, unless a name says otherwise.

use super::Wanted;
use super::syntax::{Goal, Module, Move, Robtarget, Speed};
use super::values::{Scope, shape};
use crate::diagnostics::Code;
use crate::diagnostics::codes::{E1004, E1006, E1008, E1010, E1011, E1013};
use crate::motion::Joints;
use crate::verify::findings::Difference;
use crate::verify::replay::{half_digit, same_number, shortest, single_step};

/// How far the square of a quaternion's length may lie from 1. Rounding to five decimals, the fewest that public
/// generators write, leaves 1.8e-5; controllers stop with "orientation not correct" beyond some 1e-4.
const UNIT_TOLERANCE: f64 = 2e-5;

/// Decimals of a joint angle in degrees. What single precision resolves at 170 deg is 1.5e-5.
const JOINT_DECIMALS: i64 = 5;

/// RAPID's mark for an axis that is not there.
const NO_AXIS: f64 = 9e9;

/// Whether a quaternion is of unit length as closely as controllers ask; otherwise words for it.
pub fn unit_length(q: [f64; 4]) -> Result<(), String> {
    let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    // Written so that a length that is no number is refused.
    if (square - 1.0).abs() <= UNIT_TOLERANCE {
        return Ok(());
    }
    Err(format!("the quaternion has the length {:.6} where it must have 1", square.sqrt()))
}

/// Twelve numbers of a jointtarget against joint angles in radians.
pub fn same_jointtarget(found: &[f64], joints: &[f64]) -> Result<(), String> {
    for (j, (found, wanted)) in found.iter().zip(joints).enumerate() {
        let wanted = wanted * (180.0 / std::f64::consts::PI);
        let same = (found - wanted).abs() <= half_digit(JOINT_DECIMALS) + single_step(wanted);
        if !same {
            let (found, wanted) = (shortest(*found), shortest(wanted));
            return Err(format!("joint {} stands at {found} deg where {wanted} deg is planned", j + 1));
        }
    }
    no_external_axes(&found[found.len().min(6)..])
}

/// Whether all external axes are marked as not there.
pub fn no_external_axes(axes: &[f64]) -> Result<(), String> {
    match axes.iter().all(|axis| same_number(*axis, NO_AXIS)) {
        true => Ok(()),
        false => Err("an external axis is given where the robot has none (9E9)".into()),
    }
}

/// A move with all names resolved.
#[derive(Clone, Debug)]
pub struct Resolved<'a> {
    pub line: u32,
    pub goal: ResolvedGoal,
    pub speed: [f32; 4],
    /// Seconds.
    pub time: Option<f64>,
    pub zone: &'a str,
    pub tool: &'a str,
    pub object: Option<&'a str>,
}

#[derive(Clone, Debug)]
pub enum ResolvedGoal {
    Linear(Robtarget),
    /// Six joints and six external axes.
    Joints([f32; 12]),
}

/// `one` with its names resolved, or the name that cannot be.
pub fn resolve<'a>(module: &'a Module, scope: Scope, one: &Move) -> Result<Resolved<'a>, String> {
    let name = |name: super::syntax::Name| module.names.get(usize::from(name.0)).map_or("", String::as_str);
    let unknown = |what: &dyn std::fmt::Display, of_type: &str| {
        format!("this compiler cannot prove what `{what}` is: it must be a `{of_type}` with values written out")
    };
    let goal = match &one.goal {
        Goal::Target(target) => ResolvedGoal::Linear(*target),
        Goal::LinearTo(expression) => {
            let n = scope.numbers(expression, shape::ROBTARGET).ok_or_else(|| unknown(expression, "robtarget"))?;
            let single = |i: usize| n.get(i).map_or(f32::NAN, |v| *v as f32);
            ResolvedGoal::Linear(Robtarget {
                position: [0, 1, 2].map(single),
                quaternion: [3, 4, 5, 6].map(single),
                confdata: [7, 8, 9, 10].map(single),
                external: [11, 12, 13, 14, 15, 16].map(single),
            })
        }
        Goal::JointsTo(expression) => {
            let n = scope.numbers(expression, shape::JOINTTARGET).ok_or_else(|| unknown(expression, "jointtarget"))?;
            let mut joints = [0.0; 12];
            for (place, value) in joints.iter_mut().zip(n) {
                *place = value as f32;
            }
            ResolvedGoal::Joints(joints)
        }
    };
    let speed = match &one.speed {
        Speed::Written(speed) => *speed,
        Speed::Other(expression) => {
            let n = scope.numbers(expression, shape::SPEEDDATA).ok_or_else(|| unknown(expression, "speeddata"))?;
            [0, 1, 2, 3].map(|i| n.get(i).map_or(f32::NAN, |v| *v as f32))
        }
    };
    let time = match &one.time {
        Some(expression) => {
            let n = scope.numbers(expression, shape::NUM).ok_or_else(|| unknown(expression, "num"))?;
            n.first().copied()
        }
        None => None,
    };
    Ok(Resolved {
        line: one.line,
        goal,
        speed,
        time,
        zone: name(one.zone),
        tool: name(one.tool),
        object: one.object.map(name),
    })
}

/// The values of a zone: of data declared in the program, or of the controller's own.
fn zone_values(scope: Scope, name: &str) -> Option<Vec<f64>> {
    // ABB RAPID reference, zonedata: stop point, then TCP, orientation and external zones in mm and deg.
    const OWN: &[(&str, [f64; 7])] = &[
        ("fine", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ("z0", [0.0, 0.3, 0.3, 0.3, 0.03, 0.3, 0.03]),
        ("z1", [0.0, 1.0, 1.0, 1.0, 0.1, 1.0, 0.1]),
        ("z5", [0.0, 5.0, 8.0, 8.0, 0.8, 8.0, 0.8]),
        ("z10", [0.0, 10.0, 15.0, 15.0, 1.5, 15.0, 1.5]),
    ];
    match scope.find(name) {
        Some(data) if data.of_type.eq_ignore_ascii_case("zonedata") => {
            data.value.as_ref().and_then(|value| scope.numbers(value, shape::ZONEDATA))
        }
        Some(_) => None,
        None => OWN.iter().find(|(own, _)| own.eq_ignore_ascii_case(name)).map(|(_, values)| values.to_vec()),
    }
}

fn differs(code: Code, field: &'static str, what: String) -> Difference {
    Difference { code, field, what }
}

/// The zone against the one wanted, by its values.
pub fn zone(scope: Scope, found: &str, wanted: &str) -> Option<Difference> {
    if found.eq_ignore_ascii_case(wanted) && scope.find(found).is_none() {
        return None;
    }
    let (a, b) = (zone_values(scope, found), zone_values(Scope { levels: &[] }, wanted));
    let same = match (&a, &b) {
        // Of a stop point only that it is one counts.
        (Some(a), Some(b)) if b[0] == 1.0 => a[0] == 1.0,
        (Some(a), Some(b)) => a.iter().zip(b).all(|(a, b)| same_number(*a, *b)),
        _ => false,
    };
    (!same).then(|| {
        let anew = if scope.find(found).is_some() { ", as the program declares it," } else { "" };
        differs(
            E1004,
            "target.zone",
            format!("has the zone `{found}`{anew} where the controller's `{wanted}` is planned"),
        )
    })
}

/// Whether the tool comes to rest in a zone; `None` for one that this compiler does not know.
pub fn stops(scope: Scope, zone: &str) -> Option<bool> {
    zone_values(scope, zone).and_then(|values| values.first().map(|stop| *stop == 1.0))
}

/// Speed, in mm/s and deg/s, against the planned one in m/s, which is rounded as the target writes it.
pub fn speed(wanted: &Wanted, found: [f32; 4], planned: f64) -> Option<Difference> {
    let controller = &wanted.rapid.controller;
    let power = libm::pow(10.0, controller.speed_decimals as f64);
    let rounded = |value: f64| (value * power).round() / power;
    let planned = rounded(planned * 1e3);
    let found = found.map(f64::from);
    if !same_number(found[0], planned) {
        let what = format!("has the speed {} mm/s where {planned} mm/s is planned", shortest(found[0]));
        return Some(differs(E1008, "dwell.feed", what));
    }
    other_speeds(wanted, found)
}

/// The three speeds beside the one along the path, in deg/s, mm/s, deg/s, against those that every move has.
pub fn other_speeds(wanted: &Wanted, found: [f64; 4]) -> Option<Difference> {
    let controller = &wanted.rapid.controller;
    let power = libm::pow(10.0, controller.speed_decimals as f64);
    let orientation = (controller.orientation_speed.0 * (180.0 / std::f64::consts::PI) * power).round() / power;
    for (found, planned, what, unit, field) in [
        (found[1], orientation, "orientation speed", "deg/s", "target.controller.orientation_speed"),
        (found[2], 5000.0, "speed of linear external axes", "mm/s", "target.controller"),
        (found[3], 1000.0, "speed of rotating external axes", "deg/s", "target.controller"),
    ] {
        if !same_number(found, planned) {
            let what = format!("has the {what} {} {unit} where {planned} {unit} is planned", shortest(found));
            return Some(differs(E1008, field, what));
        }
    }
    None
}

/// Tool and work object against the job's, by name.
pub fn names(wanted: &Wanted, one: &Resolved) -> Option<Difference> {
    let (tool, object) = (&wanted.names.tool, &wanted.names.object);
    if !one.tool.eq_ignore_ascii_case(tool) {
        let what = format!("uses the tool `{}` where the job has `{tool}`", one.tool);
        return Some(differs(E1010, "target.tool_name", what));
    }
    match one.object {
        Some(found) if found.eq_ignore_ascii_case(object) => None,
        Some(found) => {
            let what = format!("uses the work object `{found}` where the job has `{object}`");
            Some(differs(E1011, "target.object_name", what))
        }
        None => Some(differs(E1011, "target.object_name", format!("has no work object where the job has `{object}`"))),
    }
}

/// A joint move to planned joints (radians), in `time` seconds or else at the travel speed.
pub fn joint_move(
    wanted: &Wanted,
    scope: Scope,
    one: &Resolved,
    joints: &Joints,
    time: Option<f64>,
) -> Vec<Difference> {
    let ResolvedGoal::Joints(found) = &one.goal else {
        let what = "is a linear move where a joint move is planned".to_string();
        return vec![differs(E1013, "path", what)];
    };
    let mut all = Vec::new();
    if let Err(what) = same_jointtarget(&found.map(f64::from), joints) {
        all.push(differs(E1006, "robot", format!("goes elsewhere: {what}")));
    }
    let same_time = match (one.time, time) {
        (Some(found), Some(wanted)) => same_number(found, wanted),
        (None, None) => true,
        _ => false,
    };
    if !same_time {
        let words = |time: Option<f64>| time.map_or("no time".to_string(), |time| format!("the time {time:.3} s"));
        let what = format!("has {} where {} is planned", words(one.time), words(time));
        all.push(differs(E1008, "robot.cell.joint_move_speed", what));
    }
    all.extend(speed(wanted, one.speed, wanted.cell.travel.speed.0));
    all.extend(zone(scope, one.zone, "fine"));
    all.extend(names(wanted, one));
    all
}

/// What is wrong with a move of the main module that must go home in `time` seconds.
pub fn home_move(wanted: &Wanted, module: &Module, scope: Scope, one: &Move, time: f64) -> Result<(), String> {
    let resolved = resolve(module, scope, one)?;
    match joint_move(wanted, scope, &resolved, &wanted.motion.home, Some(time)).into_iter().next() {
        Some(difference) => Err(format!("the move to home {}", difference.what)),
        None => Ok(()),
    }
}
