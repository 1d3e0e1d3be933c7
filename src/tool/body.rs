//! The tool as a body, whatever it is: how far from the surface it stands, how it is turned, and whether it can be.
//!
//! In: the job's `tool` and the surface it works on. Out: the stand-off and the ball that stands for it in motion, and
//! problems of the description.

use super::{bonnet, pad, wheel};
use crate::diagnostics::{Problem, codes};
use crate::job::{Influence, Robot, Tool};
use crate::workpiece::form::Surface;

/// A ball that holds what of the tool is near the glass: its middle lies on the tool's -z axis, its lowest point `below` the
/// tool centre point, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    pub radius: f64,
    pub below: f64,
}

/// A pad is a disc and no ball: the one that holds its whole orbit reaches below its face by this part of its reach. A flatter
/// one would be wider than the tool by far, a rounder one would ask for a higher travel.
const BELOW_A_PAD: f64 = 0.25;

impl Tool {
    /// Distance from the tool centre point to the nominal surface along the outward normal, metres: an MRF wheel's
    /// `gap`, nothing for a pad, a bonnet's radius less its offset. The tool centre point stands at contact point +
    /// stand-off * normal.
    pub fn standoff(&self) -> f64 {
        match self {
            Tool::mrf_wheel(wheel) => wheel.gap.0,
            Tool::planetary_pad(_) => 0.0,
            Tool::bonnet(bonnet) => bonnet.radius.0 - bonnet.offset.0,
        }
    }

    /// Direction of the tool's x axis on the part, radians from +x towards +y, seen from the tool side.
    pub fn azimuth(&self) -> f64 {
        match self {
            Tool::mrf_wheel(wheel) => wheel.azimuth.0,
            Tool::planetary_pad(pad) => pad.azimuth.0,
            Tool::bonnet(bonnet) => bonnet.azimuth(),
        }
    }

    /// What the job says of its removal.
    pub fn influence(&self) -> &Influence {
        match self {
            Tool::mrf_wheel(wheel) => &wheel.influence,
            Tool::planetary_pad(pad) => &pad.influence,
            Tool::bonnet(bonnet) => &bonnet.influence,
        }
    }

    /// What stands for the tool where it must not come near the part.
    pub fn ball(&self) -> Ball {
        match self {
            Tool::mrf_wheel(wheel) => Ball { radius: wheel.diameter.0 / 2.0, below: 0.0 },
            Tool::planetary_pad(pad) => {
                let reach = pad.diameter.0 / 2.0 + pad.eccentricity.0;
                // A cap of height b over a disc of radius r belongs to a ball of radius (r² + b²) / 2b.
                let below = BELOW_A_PAD * reach;
                Ball { radius: (reach * reach + below * below) / (2.0 * below), below }
            }
            // The tool centre point is the middle of the cap.
            Tool::bonnet(bonnet) => Ball { radius: bonnet.radius.0, below: bonnet.radius.0 },
        }
    }

    /// As a sentence names it.
    pub fn name(&self) -> &'static str {
        match self {
            Tool::mrf_wheel(_) => "wheel",
            Tool::planetary_pad(_) => "pad",
            Tool::bonnet(_) => "bonnet",
        }
    }
}

impl Influence {
    /// The files that it is made from.
    pub fn files(&self) -> Vec<&str> {
        match self {
            Influence::measured(measured) => {
                let mut files: Vec<&str> = Vec::new();
                for file in measured.spots.iter().flat_map(|spot| spot.before.iter().chain([&spot.file])) {
                    // Several spots may stand in one picture.
                    if !files.contains(&file.as_str()) {
                        files.push(file);
                    }
                }
                files
            }
            Influence::set(set) => set.at.iter().flat_map(|at| at.influence.files()).collect(),
            Influence::gaussian(_) | Influence::preston(_) | Influence::bonnet_contact(_) => Vec::new(),
        }
    }
}

/// What is wrong with the tool as a body (E0630, E0650), or with what it is asked to do on a robot (E0652). Fields are
/// `tool.…`.
pub fn check(tool: &Tool, robot: Option<&Robot>) -> Vec<Problem> {
    let mut problems = match tool {
        Tool::mrf_wheel(wheel) => wheel::numbers(wheel),
        Tool::planetary_pad(pad) => pad::numbers(pad),
        Tool::bonnet(bonnet) => bonnet::numbers(bonnet),
    };
    if let (Tool::mrf_wheel(wheel), Some(robot)) = (tool, robot) {
        problems.extend(wheel::centre_point(wheel, robot));
    }
    let taught_with = robot.and_then(|robot| robot.cell.as_ref()?.tcp.wheel_diameter);
    if let (Tool::planetary_pad(_), Some(diameter)) = (tool, taught_with) {
        let message = format!(
            "the tool centre point was measured with a wheel of {:.3} mm diameter, and the job's tool is a pad",
            diameter.0 * 1e3
        );
        problems.push(
            Problem::error(codes::E0632, "tool", message).help(
                "measure `robot.cell.tcp` with the pad, in the middle of its face, and take `wheel_diameter` out",
            ),
        );
    }
    if let (Tool::bonnet(_), Some(_)) = (tool, robot) {
        let message =
            "a bonnet cannot be put on a robot yet: motion keeps the tool's axis along the normal, and cannot lean it";
        problems.push(
            Problem::error(codes::E0652, "robot", message)
                .help("take `robot` and `target` out of the job: it is then planned as far as dwell"),
        );
    }
    problems.sort_by(|a, b| a.field.cmp(&b.field));
    problems
}

/// Whether the tool fits into the surface at the `places` (x, y in metres): E0631 where it does not, W0604 where it hardly
/// does. The worst place is said.
pub fn check_fit(tool: &Tool, surface: &dyn Surface, places: impl Iterator<Item = [f64; 2]>) -> Option<Problem> {
    if surface.is_plane() {
        return None;
    }
    let hollow = |[x, y]: [f64; 2]| surface.at(x, y).map(|point| ([x, y], point.curvature().principal_values()[1]));
    let sharpest =
        places.filter_map(hollow).fold(([0.0; 2], 0.0), |worst, here| if here.1 > worst.1 { here } else { worst });
    match tool {
        Tool::mrf_wheel(wheel) => wheel::fit(wheel, sharpest),
        // A pad is soft; how well it follows a curve is not known here.
        Tool::planetary_pad(_) => None,
        Tool::bonnet(bonnet) => bonnet::fit(bonnet, sharpest),
    }
}
