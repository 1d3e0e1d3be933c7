//! Faults: why a posture or a step between two postures is refused, and where on the part.
//!
//! In: a [`Fault`] found by following a run, and its [`Place`]. Out: a [`Problem`] that names part coordinates, line,
//! joint, quantity and limit, and the mend.

use super::arm::joint_field;
use super::cell::{Station, range};
use crate::diagnostics::{Problem, codes};

/// What failed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fault {
    /// The wrist centre would lie `distance` from axis 2, the arm can do `least` to `most` (metres). No distance:
    /// nearer to axis 1 than the arm's offset lets it.
    Reach(Option<(f64, f64, f64)>),
    /// Joint (from 0) and its angle.
    Range { joint: usize, angle: f64 },
    /// Angle of the wrist from its singular position.
    Wrist(f64),
    /// Sine of the elbow angle.
    Elbow(f64),
    /// Wrist centre from axis 1.
    Shoulder(f64),
    /// Joint (from 0), the speed it would need (rad/s), and the tool's programmed speed (m/s).
    Speed { joint: usize, needed: f64, programmed: f64 },
    /// Joint (from 0) and its change between two samples of one move.
    Jump { joint: usize, step: f64 },
}

/// On which move it failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    Line,
    Link,
    Approach,
    Retract,
    Travel,
}

/// Where it failed: the place on the part (metres) and the line (from 0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub point: [f64; 3],
    pub line: usize,
    pub stage: Stage,
}

impl Place {
    /// The place in words.
    fn words(&self) -> String {
        let line = self.line + 1;
        let at = in_millimetres(self.point);
        match self.stage {
            Stage::Line => format!("{at} (line {line})"),
            Stage::Link => format!("{at} (on the way to line {line})"),
            Stage::Approach => format!("{at} (approach of line {line})"),
            Stage::Retract => format!("{at} (retract from line {line})"),
            Stage::Travel => format!("{at} (lifted, on the way to line {line})"),
        }
    }
}

/// A place on the part for people.
pub(super) fn in_millimetres(point: [f64; 3]) -> String {
    // Rounded before it is written, and adding zero turns -0.0 into 0.0.
    let [x, y, z] = point.map(|a| (a * 1e6).round() / 1e3 + 0.0);
    format!("x {x:.3} mm, y {y:.3} mm, z {z:.3} mm")
}

impl Fault {
    /// The refusal.
    pub fn problem(&self, place: &Place, station: &Station) -> Problem {
        let at = place.words();
        let move_part = "move the part towards the middle of the robot's working range (`robot.cell.object` or `user`)";
        match *self {
            Fault::Reach(None) => {
                let message = format!("the tool cannot reach {at}: the wrist centre would lie too near to axis 1");
                Problem::error(codes::E0806, "robot.cell.object", message)
                    .help(format!("{move_part}, away from axis 1"))
            }
            Fault::Reach(Some((distance, least, most))) => {
                let message = format!(
                    "the tool cannot reach {at}: the wrist centre would lie {:.1} mm from axis 2, the arm does {:.1} mm \
                     to {:.1} mm",
                    distance * 1e3,
                    least * 1e3,
                    most * 1e3
                );
                Problem::error(codes::E0806, "robot.cell.object", message).help(move_part)
            }
            Fault::Range { joint, angle } => {
                let message = format!(
                    "joint {} would stand at {:.3} deg at {at}, its range is {} with a margin of {:.3} deg",
                    joint + 1,
                    angle.to_degrees(),
                    range(&station.arm, joint),
                    station.range_margin.to_degrees()
                );
                Problem::error(codes::E0807, format!("{}.range", joint_field(joint)), message)
                    .help(format!("{move_part}, or turn the tool on the part (`tool.azimuth`)"))
            }
            Fault::Wrist(angle) => {
                let message = format!(
                    "the wrist would be {:.3} deg from its singular position at {at}, `wrist_margin` is {:.3} deg",
                    angle.to_degrees(),
                    station.wrist_margin.to_degrees()
                );
                Problem::error(codes::E0808, "robot.wrist_margin", message).help(
                    "lower or raise the part (`robot.cell.object`), tilt it, or mount the tool at an angle to the flange",
                )
            }
            Fault::Elbow(sine) => {
                let message = format!(
                    "the sine of the elbow angle would be {:.4} at {at}, `elbow_margin` is {:.4}",
                    sine.abs(),
                    station.elbow_margin
                );
                Problem::error(codes::E0808, "robot.elbow_margin", message)
                    .help("move the part (`robot.cell.object`): the arm is nearly stretched or folded")
            }
            Fault::Shoulder(distance) => {
                let message = format!(
                    "the wrist centre would be {:.1} mm from axis 1 at {at}, `shoulder_margin` is {:.1} mm",
                    distance.abs() * 1e3,
                    station.shoulder_margin * 1e3
                );
                Problem::error(codes::E0808, "robot.shoulder_margin", message)
                    .help("move the part (`robot.cell.object`) away from the robot's first axis")
            }
            Fault::Speed { joint, needed, programmed } => {
                let rated = station.arm.speeds[joint];
                let passes = programmed * rated / needed;
                let message = format!(
                    "joint {} would turn at {:.2} deg/s at {at}, it is rated {:.2} deg/s",
                    joint + 1,
                    needed.to_degrees(),
                    rated.to_degrees()
                );
                let field = match place.stage {
                    Stage::Line => "dwell.feed",
                    _ => "robot.cell.travel.speed",
                };
                Problem::error(codes::E0809, field, message).help(format!(
                    "a speed of {:.3} mm/s or less passes here, programmed are {:.3} mm/s",
                    passes * 1e3,
                    programmed * 1e3
                ))
            }
            Fault::Jump { joint, step } => {
                let message = format!(
                    "joint {} would change by {:.2} deg within one small step of the tool at {at}",
                    joint + 1,
                    step.to_degrees()
                );
                Problem::error(codes::E0810, "robot.cell.object", message)
                    .help("the way passes a singular position: set the three margins of the robot, and move the part")
            }
        }
    }
}
