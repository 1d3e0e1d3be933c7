//! Following: one configuration along straight moves, checked at the points and between them.
//!
//! In: tool poses in the object frame, a branch, the joints at the start. Out: the joints at every point with whole
//! turns continuous, and what was [`Seen`] on the way; or the first [`Fault`].
//!
//! The solutions of a branch do not depend on one another, only the whole turns do: chunks of fixed size are solved in
//! parallel, then joined in order by whole turns.

use super::arm::{Branch, Joints, Solution};
use super::cell::Station;
use super::fault::Fault;
use super::frames::{Transform, between, quaternion, turn};
use nalgebra::Translation3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Between two samples of a straight move the tool goes no farther than this, and turns no more. There the joints leave
/// the straight line between the samples by less than a thousandth of a degree (measured over a 400 mm part on a 2.6 m
/// arm: 0.0013 degrees for samples 20 mm apart, and it falls with the square), which is far below any margin. Every
/// move has at least one sample inside.
const SAMPLE_LENGTH: f64 = 5e-3;
const SAMPLE_TURN: f64 = 0.5 * PI / 180.0;

/// A joint that changes by more than this between two samples has passed a singular position: with a wrist margin of 5
/// degrees and a shoulder margin of 0.1 m, 0.5 degrees and 5 mm of tool motion are at most 9 degrees of a joint, and a
/// change of branch is far more than this.
const LARGEST_CHANGE: f64 = 30.0 * PI / 180.0;

/// Points solved by one task; constant, so that the joining is the same with any number of threads.
const CHUNK: usize = 1024;

/// The extremes met on a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    pub lower: Joints,
    pub upper: Joints,
    pub wrist: f64,
    pub speed_share: f64,
}

impl Seen {
    pub const NOTHING: Seen =
        Seen { lower: [f64::INFINITY; 6], upper: [f64::NEG_INFINITY; 6], wrist: f64::INFINITY, speed_share: 0.0 };

    fn add(&mut self, solution: &Solution) {
        for i in 0..6 {
            self.lower[i] = self.lower[i].min(solution.joints[i]);
            self.upper[i] = self.upper[i].max(solution.joints[i]);
        }
        self.wrist = self.wrist.min(wrist_angle(solution));
    }

    pub fn join(&mut self, other: &Seen) {
        for i in 0..6 {
            self.lower[i] = self.lower[i].min(other.lower[i]);
            self.upper[i] = self.upper[i].max(other.upper[i]);
        }
        self.wrist = self.wrist.min(other.wrist);
        self.speed_share = self.speed_share.max(other.speed_share);
    }
}

/// The angle of the wrist from the nearer of its singular positions, straight and folded.
fn wrist_angle(solution: &Solution) -> f64 {
    let angle = solution.distances.wrist.abs();
    angle.min(PI - angle)
}

/// A fault on a straight move, at the part `share` (0 to 1) of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Broken {
    pub fault: Fault,
    pub share: f64,
}

/// A fault on the move that ends at `point` (index into the poses that were followed).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BrokenAt {
    pub broken: Broken,
    pub point: usize,
}

/// Tool poses in the object frame with the speed of the straight move that ends at each.
#[derive(Clone, Copy)]
pub(super) struct Poses<'a> {
    pub position: &'a [[f64; 3]],
    pub quaternion: &'a [[f64; 4]],
    pub speed: &'a [f64],
}

impl Poses<'_> {
    pub fn at(&self, i: usize) -> Transform {
        let [x, y, z] = self.position[i];
        Transform::from_parts(Translation3::new(x, y, z), quaternion(self.quaternion[i]))
    }
}

/// Follows straight moves with the checks of a station.
pub(super) struct Follower<'a> {
    station: &'a Station,
    base_object: Transform,
    tool_flange: Transform,
}

/// Whether joint ranges are asked: not while whole turns are still open.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ranges {
    Asked,
    Open,
}

impl<'a> Follower<'a> {
    pub fn new(station: &'a Station) -> Follower<'a> {
        Follower {
            station,
            base_object: station.frames.base_object(),
            tool_flange: station.frames.flange_tool.inverse(),
        }
    }

    /// The flange in the base for a tool pose in the object frame.
    pub fn flange(&self, tool: &Transform) -> Transform {
        self.base_object * tool * self.tool_flange
    }

    /// The branch's solution nearest to `previous`, all margins but the ranges kept.
    fn solve(&self, tool: &Transform, branch: Branch, previous: &Joints) -> Result<Solution, Fault> {
        let flange = self.flange(tool);
        let Some(solution) = self.station.arm.inverse_in_branch(&flange, branch, previous) else {
            return Err(Fault::Reach(self.station.arm.reach(&flange, branch.behind_axis_1)));
        };
        let distances = solution.distances;
        // Written so that a distance that is no number is refused.
        let clear_of_shoulder = distances.shoulder.abs() >= self.station.shoulder_margin;
        if !clear_of_shoulder {
            return Err(Fault::Shoulder(distances.shoulder));
        }
        let clear_of_elbow = distances.elbow.abs() >= self.station.elbow_margin;
        if !clear_of_elbow {
            return Err(Fault::Elbow(distances.elbow));
        }
        let wrist = wrist_angle(&solution);
        let clear_of_wrist = wrist >= self.station.wrist_margin;
        if !clear_of_wrist {
            return Err(Fault::Wrist(wrist));
        }
        Ok(solution)
    }

    /// The joint that is outside its range with margin, if one is.
    pub fn out_of_range(&self, joints: &Joints) -> Option<Fault> {
        if self.station.arm.within(joints, self.station.range_margin) {
            return None;
        }
        let (_, joint) = self.station.arm.least_margin(joints);
        Some(Fault::Range { joint, angle: joints[joint] })
    }

    /// Follows one straight move at `speed` from `joints`, gives the joints at its end.
    pub fn straight(
        &self,
        branch: Branch,
        (from, joints): (&Transform, &Joints),
        to: &Transform,
        speed: f64,
        seen: &mut Seen,
    ) -> Result<Joints, Broken> {
        self.step(branch, (from, joints), to, speed, Ranges::Asked, seen)
    }

    fn step(
        &self,
        branch: Branch,
        (from, joints): (&Transform, &Joints),
        to: &Transform,
        speed: f64,
        ranges: Ranges,
        seen: &mut Seen,
    ) -> Result<Joints, Broken> {
        let length = (to.translation.vector - from.translation.vector).norm();
        let samples = (length / SAMPLE_LENGTH).max(turn(&from.rotation, &to.rotation) / SAMPLE_TURN).ceil().max(2.0);
        let seconds = length / samples / speed;
        let mut joints = *joints;
        for sample in 1..=samples as usize {
            let share = sample as f64 / samples;
            let tool = if sample as f64 == samples { *to } else { between(from, to, share) };
            let solution = self.solve(&tool, branch, &joints).map_err(|fault| Broken { fault, share })?;
            for (joint, (now, before)) in solution.joints.iter().zip(&joints).enumerate() {
                let step = now - before;
                if step.abs() > LARGEST_CHANGE {
                    return Err(Broken { fault: Fault::Jump { joint, step }, share });
                }
                let needed = step.abs() / seconds;
                let part = needed / self.station.arm.speeds[joint];
                if part > 1.0 {
                    return Err(Broken { fault: Fault::Speed { joint, needed, programmed: speed }, share });
                }
                seen.speed_share = seen.speed_share.max(part);
            }
            if ranges == Ranges::Asked
                && let Some(fault) = self.out_of_range(&solution.joints)
            {
                return Err(Broken { fault, share });
            }
            seen.add(&solution);
            joints = solution.joints;
        }
        Ok(joints)
    }

    /// Follows the poses one after the other from the first one, whose joints are `start`. Writes the joints at every
    /// pose.
    pub fn chain(
        &self,
        branch: Branch,
        start: &Joints,
        poses: Poses<'_>,
        joints: &mut [Joints],
    ) -> Result<Seen, BrokenAt> {
        let parts: Vec<Result<(Joints, Seen), BrokenAt>> = joints
            .par_chunks_mut(CHUNK)
            .enumerate()
            .map(|(chunk, joints)| {
                let first = chunk * CHUNK;
                let begin = self.begin(branch, start, poses, first)?;
                let seen = self.part(branch, &begin, poses, first, joints, Ranges::Open)?;
                Ok((begin, seen))
            })
            .collect();
        let mut all = Seen::NOTHING;
        let mut end = *start;
        for (chunk, (part, joints)) in parts.into_iter().zip(joints.chunks_mut(CHUNK)).enumerate() {
            let first = chunk * CHUNK;
            let seen = match part {
                Ok((begin, mut seen)) if let Some(turns) = turns_between(&begin, &end) => {
                    for i in 0..6 {
                        if turns[i] != 0.0 {
                            joints.iter_mut().for_each(|joints| joints[i] += turns[i]);
                            seen.lower[i] += turns[i];
                            seen.upper[i] += turns[i];
                        }
                    }
                    let inside = self.out_of_range(&seen.lower).or(self.out_of_range(&seen.upper)).is_none();
                    inside.then_some(seen)
                }
                _ => None,
            };
            // Followed once more, in order and with the ranges asked, where something is wrong: it finds the first
            // fault on the way, whichever it is. Also where the pose at the seam leaves a joint open.
            let seen = match seen {
                Some(seen) => seen,
                None => self.part(branch, &end, poses, first, joints, Ranges::Asked)?,
            };
            all.join(&seen);
            if let Some(last) = joints.last() {
                end = *last;
            }
        }
        Ok(all)
    }

    /// The joints before pose `first`: `start`, or those of the pose before it, whole turns open.
    fn begin(&self, branch: Branch, start: &Joints, poses: Poses<'_>, first: usize) -> Result<Joints, BrokenAt> {
        if first == 0 {
            return Ok(*start);
        }
        let solution = self.solve(&poses.at(first - 1), branch, start);
        let solution = solution.map_err(|fault| BrokenAt { broken: Broken { fault, share: 1.0 }, point: first - 1 })?;
        Ok(solution.joints)
    }

    /// Follows `joints.len()` poses from `first` on, in order.
    fn part(
        &self,
        branch: Branch,
        begin: &Joints,
        poses: Poses<'_>,
        first: usize,
        joints: &mut [Joints],
        ranges: Ranges,
    ) -> Result<Seen, BrokenAt> {
        let mut seen = Seen::NOTHING;
        let mut now = *begin;
        let mut from = poses.at(first.saturating_sub(1));
        for (i, place) in joints.iter_mut().enumerate() {
            let point = first + i;
            if point == 0 {
                *place = now;
                continue;
            }
            let to = poses.at(point);
            now = self
                .step(branch, (&from, &now), &to, poses.speed[point], ranges, &mut seen)
                .map_err(|broken| BrokenAt { broken, point })?;
            *place = now;
            from = to;
        }
        Ok(seen)
    }
}

/// The whole turns from one writing of a posture to another; nothing if they are not the same posture.
fn turns_between(from: &Joints, to: &Joints) -> Option<[f64; 6]> {
    /// Two solutions of one pose in one branch differ by the rounding of adding a turn.
    const SAME: f64 = 1e-9;
    let mut turns = [0.0; 6];
    for i in 0..6 {
        let change = to[i] - from[i];
        let whole = TAU * (change / TAU).round();
        if (change - whole).abs() > SAME {
            return None;
        }
        turns[i] = whole;
    }
    Some(turns)
}
