//! The moves that a plan asks for, in order, in terms of the part.
//!
//! In: the motion. Out: [`Planned`] moves with their poses, joints and words; which runs a file most likely holds.

use crate::motion::{Joints, Motion, ToolPose, Travel};
use std::ops::Range;

/// A move that the plan asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Planned {
    /// Straight to the approach point of a run.
    Approach(usize),
    /// The joint move to a run's approach point.
    Start(usize),
    /// To a point, by its index.
    Point(usize),
    /// To the retract point of a run.
    Retract(usize),
}

/// Where in its line of the path a point stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct InLine {
    pub first: usize,
    pub last: usize,
}

impl Planned {
    /// The moves that the plan asks for in these runs.
    pub fn of_runs(motion: &Motion, runs: Range<usize>) -> Vec<Planned> {
        let mut all = Vec::new();
        for r in runs {
            let Some(run) = motion.runs.get(r) else { continue };
            if run.travel == Travel::Straight {
                all.push(Planned::Approach(r));
            }
            all.push(Planned::Start(r));
            all.extend(run.points.clone().map(Planned::Point));
            all.push(Planned::Retract(r));
        }
        all
    }

    /// The pose that the move ends in.
    pub fn pose(self, motion: &Motion) -> ToolPose {
        match self {
            Planned::Approach(r) | Planned::Start(r) => motion.runs[r].approach,
            Planned::Retract(r) => motion.runs[r].retract,
            Planned::Point(i) => ToolPose { position: motion.position[i], quaternion: motion.quaternion[i] },
        }
    }

    /// The joints that the move ends in.
    pub fn joints(self, motion: &Motion) -> Joints {
        match self {
            Planned::Approach(r) | Planned::Start(r) => motion.runs[r].approach_joints,
            Planned::Retract(r) => motion.runs[r].retract_joints,
            Planned::Point(i) => motion.joints[i],
        }
    }

    /// The move in words, in terms of the part.
    pub fn place(self, motion: &Motion) -> String {
        match self {
            Planned::Approach(r) | Planned::Start(r) => format!("the approach of run {}", r + 1),
            Planned::Retract(r) => format!("the retract of run {}", r + 1),
            Planned::Point(i) => {
                let lines = &motion.timed.path.lines;
                let line = lines.partition_point(|line| line.points.end <= i) + 1;
                let [x, y, _] = motion.timed.path.points.position(i).map(millimetres);
                format!("point {} of {} (line {line}, x = {x}, y = {y} mm)", i + 1, motion.position.len())
            }
        }
    }
}

/// The words for moves that are missing.
pub(super) fn missing(motion: &Motion, planned: &[Planned]) -> String {
    match planned {
        [] => "a move is missing before this line".into(),
        [one] => format!("{} is missing before this line", one.place(motion)),
        [first, .., last] => {
            let (first, last) = (first.place(motion), last.place(motion));
            format!("{} moves are missing before this line, from {first} to {last}", planned.len())
        }
    }
}

/// The ends of the line that point `i` belongs to.
pub(super) fn line_of(motion: &Motion, i: usize) -> InLine {
    let lines = &motion.timed.path.lines;
    match lines.get(lines.partition_point(|line| line.points.end <= i)) {
        Some(line) => InLine { first: line.points.start, last: line.points.end.saturating_sub(1) },
        None => InLine { first: i, last: i },
    }
}

/// How many runs, from `first` on, a file with so many moves most likely holds. A move too many or too few, put in or taken
/// out by hand, does not change the answer.
pub(super) fn runs_in(motion: &Motion, first: usize, moves: usize) -> usize {
    let mut best = (usize::MAX, 0);
    let mut sum = 0;
    for (n, run) in motion.runs.iter().skip(first).enumerate() {
        sum += 2 + run.points.len() + usize::from(run.travel == Travel::Straight);
        if sum.abs_diff(moves) < best.0 {
            best = (sum.abs_diff(moves), n + 1);
        }
        if sum > moves {
            break;
        }
    }
    best.1
}

/// Metres to millimetres, to the tenth of a micrometre, for messages.
pub(super) fn millimetres(value: f64) -> f64 {
    // Adding zero takes the sign off -0.
    (value * 1e7).round() / 1e4 + 0.0
}
