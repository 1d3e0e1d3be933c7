//! The conditions that spots were taken under, against those of the job.
//!
//! In: the job's tool and material, the conditions of its measured influence function. Out: what differs (E0654), and a flow that
//! runs the other way in the picture (E0655).

use crate::diagnostics::{Problem, codes};
use crate::job::{
    BonnetConditions, Conditions, Direction, InPicture, Measured, MrfConditions, PadConditions, SpinMeasured, Tool,
    Turn, TurnsWith, View, WheelRotation,
};
use std::f64::consts::TAU;

/// How far two conditions may differ. Removal is proportional to speed and pressure, so a per cent of one is a per cent of it,
/// which is less than spots repeat to; no machine holds its settings much better.
const CLOSE: f64 = 0.01;

/// Two numbers that should be the same, in the unit in which they are told.
struct Pair {
    field: &'static str,
    taken: f64,
    job: f64,
    unit: &'static str,
}

/// What of `taken` is not so in the job, and what the picture of the spots contradicts. `at` is the field of the influence
/// function.
pub(super) fn check(measured: &Measured, tool: &Tool, material: &str, at: &str) -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut words = Vec::new();
    let rpm = |speed: f64| speed * 60.0 / TAU;
    let (pairs, glass) = match (&measured.taken, tool) {
        (Conditions::mrf_conditions(taken), Tool::mrf_wheel(wheel)) => {
            let MrfConditions { diameter, speed, rotation, gap, material } = taken;
            if *rotation != wheel.rotation {
                let name = |rotation: WheelRotation| match rotation {
                    WheelRotation::forward => "forward",
                    WheelRotation::reverse => "reverse",
                };
                words.push(("rotation", name(*rotation).to_string(), name(wheel.rotation).to_string()));
            }
            let pairs = vec![
                Pair { field: "diameter", taken: diameter.0 * 1e3, job: wheel.diameter.0 * 1e3, unit: "mm" },
                Pair { field: "speed", taken: rpm(speed.0), job: rpm(wheel.speed.0), unit: "rpm" },
                Pair { field: "gap", taken: gap.0 * 1e3, job: wheel.gap.0 * 1e3, unit: "mm" },
            ];
            (pairs, material)
        }
        (Conditions::pad_conditions(taken), Tool::planetary_pad(pad)) => {
            let PadConditions { diameter, eccentricity, orbit, spin, spin_measured, force, material } = taken;
            if *spin_measured != pad.spin_measured {
                let name = |against: SpinMeasured| match against {
                    SpinMeasured::on_arm => "on_arm".to_string(),
                    SpinMeasured::absolute => "absolute".to_string(),
                };
                words.push(("spin_measured", name(*spin_measured), name(pad.spin_measured)));
            }
            let turn = |turn: &Turn| rpm(turn.counterclockwise());
            let pairs = vec![
                Pair { field: "diameter", taken: diameter.0 * 1e3, job: pad.diameter.0 * 1e3, unit: "mm" },
                Pair { field: "eccentricity", taken: eccentricity.0 * 1e3, job: pad.eccentricity.0 * 1e3, unit: "mm" },
                Pair { field: "orbit", taken: turn(orbit), job: turn(&pad.orbit), unit: "rpm counter-clockwise" },
                Pair { field: "spin", taken: turn(spin), job: turn(&pad.spin), unit: "rpm counter-clockwise" },
                Pair { field: "force", taken: force.0, job: pad.force.0, unit: "N" },
            ];
            (pairs, material)
        }
        (Conditions::bonnet_conditions(taken), Tool::bonnet(bonnet)) => {
            let BonnetConditions { radius, offset, pressure, speed, tilt, material } = taken;
            let pairs = vec![
                Pair { field: "radius", taken: radius.0 * 1e3, job: bonnet.radius.0 * 1e3, unit: "mm" },
                Pair { field: "offset", taken: offset.0 * 1e3, job: bonnet.offset.0 * 1e3, unit: "mm" },
                Pair { field: "pressure", taken: pressure.0 * 1e-6, job: bonnet.pressure.0 * 1e-6, unit: "MPa" },
                Pair { field: "speed", taken: rpm(speed.0), job: rpm(bonnet.spin.speed.0.abs()), unit: "rpm" },
                Pair { field: "tilt", taken: tilt.0.to_degrees(), job: bonnet.tilt().to_degrees(), unit: "deg" },
            ];
            (pairs, material)
        }
        (taken, _) => {
            let of = match taken {
                Conditions::mrf_conditions(_) => "wheel",
                Conditions::pad_conditions(_) => "pad",
                Conditions::bonnet_conditions(_) => "bonnet",
            };
            let message = format!("the spots were taken with a {of}, and the job's tool is a {}", tool.name());
            return vec![
                Problem::error(codes::E0654, format!("{at}.taken"), message)
                    .help("measure a spot with this tool, or correct `taken`"),
            ];
        }
    };
    for pair in pairs {
        // Written so that what is no number differs.
        if !((pair.taken - pair.job).abs() <= CLOSE * pair.job.abs()) {
            let shown = |value: f64| format!("{value:.3} {}", pair.unit);
            words.push((pair.field, shown(pair.taken), shown(pair.job)));
        }
    }
    if glass.name != material {
        words.push(("material", format!("`{}`", glass.name), format!("`{material}`")));
    }
    for (field, taken, job) in words {
        let what = field.replace('_', " ");
        let message = format!("the spots were taken with the {what} {taken}, and the job's is {job}");
        problems.push(
            Problem::error(codes::E0654, format!("{at}.taken.{field}"), message)
                .note("an influence function holds under the conditions that it was measured under")
                .help("measure a spot under the job's conditions, or correct what is written wrong"),
        );
    }
    problems.extend(flow(measured, tool, at));
    problems
}

/// E0655: the fluid does not flow through the picture as the job says.
fn flow(measured: &Measured, tool: &Tool, at: &str) -> Option<Problem> {
    let stated = measured.flow_in_map?;
    let field = format!("{at}.flow_in_map");
    let (Tool::mrf_wheel(wheel), TurnsWith::tool) = (tool, measured.turns_with) else {
        let message = "only the fluid of a wheel, whose spot turns with the tool, flows through the picture";
        return Some(Problem::error(codes::E0655, field, message).help("take `flow_in_map` out"));
    };
    // The fluid is dragged along the tool's +x by a wheel that turns forward.
    let sense = if wheel.rotation == WheelRotation::forward { 1 } else { -1 };
    // The tool's +z points away from an eye on the tool side: with +x up, +y is on the right (height_map::orientation).
    let away = if measured.view == View::from_tool_side { 1 } else { -1 };
    // What points up and to the right in the picture, along the tool's x.
    let (up, right) = match measured.up {
        Direction::plus_x => (sense, 0),
        Direction::minus_x => (-sense, 0),
        Direction::plus_y => (0, -sense * away),
        Direction::minus_y => (0, sense * away),
    };
    let found = match (up, right) {
        (1, _) => InPicture::up,
        (-1, _) => InPicture::down,
        (_, 1) => InPicture::right,
        _ => InPicture::left,
    };
    if found == stated {
        return None;
    }
    let name = |flow: InPicture| match flow {
        InPicture::up => "up",
        InPicture::down => "down",
        InPicture::left => "to the left",
        InPicture::right => "to the right",
    };
    let message = format!(
        "the fluid flows {} through the picture by `flow_in_map`, and {} by `rotation`, `up` and `view`",
        name(stated),
        name(found)
    );
    Some(
        Problem::error(codes::E0655, field, message)
            .help("find out which is right: turned or mirrored, the spot removes in the wrong place"),
    )
}
