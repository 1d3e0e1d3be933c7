//! What the operator must be told of the tool, worked out from the job.
//!
//! In: the job's tool. Out: lines of at most 40 characters, each with the field that says it. The emitters have words of
//! their own: a wrong sense must not agree with itself.

use crate::job::{PlanetaryPad, Seen, Sense, SpinMeasured, Tool, Turn, WheelRotation};

/// One line a fact.
pub(super) fn of_tool(tool: &Tool) -> Vec<(String, &'static str)> {
    match tool {
        Tool::mrf_wheel(wheel) => {
            let sense = match wheel.rotation {
                WheelRotation::forward => "wheel forward: fluid along +x of tool",
                WheelRotation::reverse => "wheel reverse: fluid along -x of tool",
            };
            vec![
                (sense.into(), "tool.rotation"),
                (format!("wheel at {:.3} rpm", revolutions(wheel.speed.0)), "tool.speed"),
            ]
        }
        Tool::planetary_pad(PlanetaryPad { orbit, spin, spin_measured, force, .. }) => {
            let arm = match spin_measured {
                SpinMeasured::on_arm => " on arm",
                SpinMeasured::absolute => "",
            };
            vec![
                (format!("orbit {}", turn(orbit)), "tool.orbit"),
                (format!("spin {}{arm}", turn(spin)), "tool.spin"),
                (format!("force {:.3} N", force.0), "tool.force"),
            ]
        }
        Tool::bonnet(bonnet) => vec![
            (format!("bonnet {}", turn(&bonnet.spin)), "tool.spin"),
            (format!("bonnet at {:.4} MPa", bonnet.pressure.0 / 1e6), "tool.pressure"),
        ],
    }
}

fn revolutions(speed: f64) -> f64 {
    speed * 30.0 / std::f64::consts::PI
}

/// A turn as one sees it from the tool side.
fn turn(turn: &Turn) -> String {
    let positive_is_clockwise = (turn.positive == Sense::clockwise) == (turn.seen == Seen::from_tool_side);
    let sense = if positive_is_clockwise == (turn.speed.0 >= 0.0) { "clockwise" } else { "counter-clockwise" };
    format!("{:.3} rpm {sense}", revolutions(turn.speed.0.abs()))
}
