//! The tool as a body: how far from the surface it stands, and whether its numbers can be.
//!
//! In: the job's `tool` and the form it works on. Out: the stand-off for motion, and problems of the description.

use crate::diagnostics::{Problem, codes};
use crate::job::{Form, MrfWheel, Tool};

impl Tool {
    /// Distance from the tool centre point to the nominal surface along the outward normal, metres: an MRF wheel's
    /// `gap`. The tool centre point stands at contact point + stand-off * normal.
    pub fn standoff(&self) -> f64 {
        match self {
            Tool::mrf_wheel(wheel) => wheel.gap.0,
        }
    }

    /// Direction of the tool's x axis on the part, radians from +x towards +y, seen from the tool side.
    pub fn azimuth(&self) -> f64 {
        match self {
            Tool::mrf_wheel(wheel) => wheel.azimuth.0,
        }
    }
}

/// What is wrong with the tool as a body (E0630), and with the tool on this form. Fields are `tool.…`.
pub fn check(tool: &Tool, form: &Form) -> Vec<Problem> {
    let Tool::mrf_wheel(wheel) = tool;
    let mut problems = wheel_numbers(wheel);
    match form {
        // A wheel touches a plane at its lowest point whatever its diameter.
        Form::plane(_) => {}
    }
    problems.sort_by(|a, b| a.field.cmp(&b.field));
    problems
}

fn wheel_numbers(wheel: &MrfWheel) -> Vec<Problem> {
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
