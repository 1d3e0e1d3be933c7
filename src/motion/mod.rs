//! Motion: from contact points in the part frame to joint angles, checked.
//!
//! In: a `TimedPath`, the robot with its cell. Out: [`Checked`]`<Motion>`, which only the checks of this module make:
//! every point reachable inside the joint ranges with margin, off singularities, in one configuration along each run,
//! also between points, within joint speeds.

use crate::dwell::TimedPath;

/// A proof that the checks of motion were passed. Only this module can make one.
#[derive(Clone, Debug)]
pub struct Checked<T>(T);

impl<T> std::ops::Deref for Checked<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0
    }
}

/// A rigid transform: `p_outer = rotation * p_inner + translation`, metres.
pub type Transform = nalgebra::Isometry3<f64>;

/// What the program is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    Polish,
    /// Lifted along the normals by `travel.height`, at no more than `travel.speed`, process off.
    DryRun,
}

/// All frames of a job, none assumed to be the identity.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameChain {
    /// Robot base in the world.
    pub world_base: Transform,
    /// User frame in the world.
    pub world_user: Transform,
    /// Object frame (the part frame) in the user frame.
    pub user_object: Transform,
    /// Tool frame in the flange frame.
    pub flange_tool: Transform,
}

/// One run: approach above the first point, down, lines without lifting, up to the retract point.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Indices into `TimedPath::path.lines`.
    pub lines: std::ops::Range<usize>,
    /// Indices of the run's points.
    pub points: std::ops::Range<usize>,
    /// Tool pose in the object frame above the first point, and its joints (radians, maker's convention).
    pub approach: ToolPose,
    pub approach_joints: [f64; 6],
    /// Tool pose in the object frame above the last point, and its joints.
    pub retract: ToolPose,
    pub retract_joints: [f64; 6],
}

/// Position (metres) and unit quaternion [w, x, y, z] of the tool frame in the object frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolPose {
    pub position: [f64; 3],
    pub quaternion: [f64; 4],
}

/// The whole motion of one program.
#[derive(Clone, Debug)]
pub struct Motion {
    pub purpose: Purpose,
    pub timed: TimedPath,
    pub frames: FrameChain,
    pub runs: Vec<Run>,
    /// Tool poses in the object frame, one a point (flat arrays; consecutive quaternions have dot >= 0).
    pub position: Vec<[f64; 3]>,
    pub quaternion: Vec<[f64; 4]>,
    /// Joint angles in radians, maker's convention, whole turns counted.
    pub joints: Vec<[f64; 6]>,
    /// ABB configuration data [cf1, cf4, cf6, cfx], one a point.
    pub confdata: Vec<[i32; 4]>,
    pub home: [f64; 6],
    pub figures: MotionFigures,
}

/// What the report says of the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionFigures {
    /// Seconds, links, approaches and retracts included; a kinematic estimate.
    pub time: f64,
    /// Least distance to the end of any joint's range, radians.
    pub joint_margin: f64,
    /// Largest joint change between two points, radians.
    pub largest_joint_step: f64,
    /// Least |axis 5|, radians.
    pub wrist_margin: f64,
    /// Largest joint speed over its rated speed, 0 to 1.
    pub joint_speed_share: f64,
}
