//! Motion: from contact points in the part frame to joint angles, checked.
//!
//! In: a `TimedPath`, the robot with its cell. Out: [`Checked`]`<Motion>`, which only the checks of this module make:
//! every point reachable inside the joint ranges with margin, off singularities, in one configuration along each run,
//! also between points, within joint speeds. The frames, the arm's kinematics and the contact frame are public for
//! `verify`, which replays a program's text with them.
//!
//! What is checked of collisions is the tool against the part, in the joint moves: see [`joint_move`]. Arm, cell, cable
//! and fixture are not checked, and the job says so itself (`unchecked`).

pub mod arm;
pub mod cell;
pub mod configuration;
pub mod contact;
mod fault;
mod follow;
pub mod frames;
mod joint_move;
mod plan;
mod runs;
mod time;
pub mod turns;

pub use arm::{Arm, Branch, Joints, Solution};
pub use frames::{FrameChain, Transform};
pub use plan::plan;

use crate::dwell::{SpeedSteps, TimedPath};
use crate::tool::Ball;

/// A proof that the checks of motion were passed. Only this module can make one.
#[derive(Clone, Debug)]
pub struct Checked<T>(T);

impl<T> std::ops::Deref for Checked<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0
    }
}

/// What the program is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    Polish,
    /// Lifted along the normals by `travel.height`, at no more than `travel.speed`, process off.
    DryRun,
}

/// What [`plan()`] needs to know beside the path and the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// From the nominal surface to the tool centre point along the outward normal, metres (an MRF wheel's gap).
    pub standoff: f64,
    /// Direction of the tool's x axis on the part, radians from +x towards +y of the part, seen from the tool side.
    pub azimuth: f64,
    /// The ball that stands for the tool in the check of joint moves.
    pub tool_ball: Ball,
    /// Lower left and upper right corner of the box around the part's edge, metres, in the part frame.
    pub part: [[f64; 2]; 2],
    /// The path's acceleration, m/s², for the estimate of time.
    pub acceleration: f64,
    pub purpose: Purpose,
    /// What one run may hold: one file of the program.
    pub room: Room,
    /// The speeds that the target can write; those that are cut to the travel speed stay of them.
    pub speed_steps: SpeedSteps,
}

/// What one file of a program holds, in a measure of its own (points, lines of text), and what a point and a line of the
/// path take of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    pub total: usize,
    pub point: usize,
    pub line: usize,
}

impl Room {
    /// Room for so many points, however many lines they make.
    pub const fn points(total: usize) -> Room {
        Room { total, point: 1, line: 0 }
    }

    /// Most points of a line that fits.
    pub fn line_points(self) -> usize {
        self.total.saturating_sub(self.line) / self.point.max(1)
    }
}

/// How the tool gets to a run's approach pose: from home before the first run, from the run before otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Travel {
    /// All joints at once to `approach_joints`, at `joint_move_speed` of their rated speeds.
    Joint,
    /// Straight from the last run's retract pose at `travel.speed`; it arrives at `approach_joints`.
    Straight,
}

/// One run: approach above the first point, down, lines without lifting, up to the retract point. A run ends where the
/// path lifts, and where the next line would make it longer than [`Request::room`]; a file of the program
/// holds one run or several consecutive ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Indices into `TimedPath::path.lines`.
    pub lines: std::ops::Range<usize>,
    /// Indices of the run's points.
    pub points: std::ops::Range<usize>,
    /// How the tool gets to `approach`.
    pub travel: Travel,
    /// The configuration held from approach to retract.
    pub branch: Branch,
    /// Tool pose in the object frame above the first point, and its joints (radians, maker's convention).
    pub approach: ToolPose,
    pub approach_joints: Joints,
    /// Tool pose in the object frame above the last point, and its joints.
    pub retract: ToolPose,
    pub retract_joints: Joints,
    /// Of the way up to `retract`, m/s, as the target can write it: the landing's where the path lands on the part, else the
    /// travel speed.
    pub retract_speed: f64,
}

/// Position (metres) and unit quaternion [w, x, y, z] of the tool frame in the object frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPose {
    pub position: [f64; 3],
    pub quaternion: [f64; 4],
}

/// The whole motion of one program: a joint move to `home`, the runs, a joint move to `home`.
#[derive(Clone, Debug)]
pub struct Motion {
    pub purpose: Purpose,
    /// The path with its speeds as they are driven: down to a run's first point, and in a dry run everywhere, at most
    /// the travel speed.
    pub timed: TimedPath,
    pub frames: FrameChain,
    pub runs: Vec<Run>,
    /// Tool poses in the object frame, one a point (flat arrays; consecutive quaternions have dot >= 0).
    pub position: Vec<[f64; 3]>,
    pub quaternion: Vec<[f64; 4]>,
    /// Joint angles in radians, maker's convention, whole turns counted.
    pub joints: Vec<Joints>,
    /// ABB configuration data [cf1, cf4, cf6, cfx], one a point.
    pub confdata: Vec<[i32; 4]>,
    pub home: Joints,
    pub figures: MotionFigures,
}

/// What the report says of the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionFigures {
    /// Seconds from home to home, links, approaches and retracts included; a kinematic estimate, not the controller's.
    pub time: f64,
    /// Least distance to the end of any joint's range, radians.
    pub joint_margin: f64,
    /// Largest joint change between two points of a line, radians.
    pub largest_joint_step: f64,
    /// Least angle of the wrist (axis 5) from its singular positions, radians.
    pub wrist_margin: f64,
    /// Largest joint speed over its rated speed on the way from approach to retract, 0 to 1.
    pub joint_speed_share: f64,
    /// Number of points where axis 1, 4 or 6 is within 0.1 degrees of a whole quarter turn, so that the confdata of the
    /// written, rounded target may name the neighbouring quarter.
    pub points_near_quarter: usize,
}
