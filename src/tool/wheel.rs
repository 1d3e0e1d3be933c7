//! The MRF wheel as a body: whether its numbers can be, and whether it fits the surface.
//!
//! In: the job's wheel and the surface it works on. Out: problems of the description.

use crate::diagnostics::{Problem, codes};
use crate::job::{MrfWheel, Robot};

/// How far the two diameters may differ: the rounding of the numbers of a job. Both are written by people, so another
/// number is another wheel.
const SAME_WHEEL: f64 = 1e-9;

/// E0632 if the tool centre point was measured with another wheel than the job's: its lowest point lies half the
/// difference away.
pub(super) fn centre_point(wheel: &MrfWheel, robot: &Robot) -> Option<Problem> {
    let measured = robot.cell.as_ref()?.tcp.wheel_diameter?.0;
    if (measured - wheel.diameter.0).abs() <= SAME_WHEEL {
        return None;
    }
    let message = format!(
        "the wheel has {:.3} mm diameter, and the tool centre point was measured with one of {:.3} mm",
        wheel.diameter.0 * 1e3,
        measured * 1e3
    );
    let off = (wheel.diameter.0 - measured).abs() * 5e2;
    Some(
        Problem::error(codes::E0632, "tool.diameter", message)
            .note(format!("its lowest point lies {off:.3} mm from there, along the tool's z axis"))
            .help("measure `robot.cell.tcp` with this wheel, and say so in its `wheel_diameter`"),
    )
}

/// E0631 if the wheel does not fit into the surface where it is hollow most sharply (the place, and one over the radius
/// there): a wheel of radius r, its lowest point one gap h over the glass, comes nearer to it elsewhere where the surface is
/// hollow with a radius below r + h. The wheel is taken for a ball of its radius, since its shape across the rim is not
/// stated (gap model of a spherical wheel: a concave radius of at most the wheel's is refused).
pub(super) fn fit(wheel: &MrfWheel, (place, sharpest): ([f64; 2], f64)) -> Option<Problem> {
    let needed = wheel.diameter.0 / 2.0 + wheel.gap.0;
    if sharpest * needed < 1.0 {
        return None;
    }
    let radius = 1.0 / sharpest;
    let message = format!(
        "the wheel of {:.3} mm radius with its gap of {:.3} mm does not fit into the surface at x {:.3} mm, y {:.3} mm, \
         which is hollow there with a radius of {:.3} mm",
        wheel.diameter.0 * 5e2,
        wheel.gap.0 * 1e3,
        place[0] * 1e3,
        place[1] * 1e3,
        radius * 1e3
    );
    // Rounded down to a tenth of a millimetre, and one less, so that it fits.
    let fits = ((radius - wheel.gap.0) * 2e4).floor() / 10.0 - 0.1;
    let help = if fits > 0.0 {
        format!("take a wheel of at most {fits:.1} mm diameter")
    } else {
        "no wheel with this gap fits there; check the numbers of `form`".to_string()
    };
    Some(Problem::error(codes::E0631, "tool.diameter", message).help(help))
}

/// What is wrong with the wheel's numbers (E0630). Fields are `tool.…`.
pub(super) fn numbers(wheel: &MrfWheel) -> Vec<Problem> {
    let mut problems = Vec::new();
    let mut positive = |name: &str, value: f64, text: String, why: &str| {
        if !(value > 0.0 && value.is_finite()) {
            let message = format!("the wheel's `{name}` is {text}; it must be positive");
            problems.push(Problem::error(codes::E0630, format!("tool.{name}"), message).note(why));
        }
    };
    positive("diameter", wheel.diameter.0, format!("{:.3} mm", wheel.diameter.0 * 1e3), "a wheel has a size");
    positive(
        "gap",
        wheel.gap.0,
        format!("{:.3} mm", wheel.gap.0 * 1e3),
        "the ribbon of fluid works in the gap; without a gap the wheel itself would touch the glass",
    );
    let rpm = wheel.speed.0 * 60.0 / std::f64::consts::TAU;
    positive("speed", wheel.speed.0, format!("{rpm:.3} rpm"), "the sense of rotation is said by `rotation`");
    if problems.is_empty() && wheel.gap.0 >= wheel.diameter.0 / 2.0 {
        let message = format!(
            "the gap of {:.3} mm is not smaller than the wheel's radius of {:.3} mm",
            wheel.gap.0 * 1e3,
            wheel.diameter.0 * 5e2
        );
        problems
            .push(Problem::error(codes::E0630, "tool.gap", message).help("a gap is a few millimetres: check the unit"));
    }
    problems
}
