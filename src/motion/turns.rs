//! Whole turns: the same posture in every turn that the joint ranges hold.
//!
//! In: the solutions of an arm, one a branch. Out: [`AllTurns`], an iterator over all of them with all whole turns
//! inside the ranges, and the arithmetic of turns. A range wider than one turn holds several; testing ranges modulo one
//! turn would let a joint run against its stop.

use super::arm::{Arm, Branches, Joints, Solution};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The angle in [-pi, pi).
pub(super) fn wrap(angle: f64) -> f64 {
    let wrapped = angle - TAU * whole_turns(angle);
    if wrapped >= PI { wrapped - TAU } else { wrapped }
}

/// The angle, turned by whole turns, nearest to `near`.
pub(super) fn nearest_turn(angle: f64, near: f64) -> f64 {
    angle + TAU * whole_turns(near - angle)
}

/// The whole number of turns nearest to `angle`. A cast instead of `round`: joint angles are a few turns, and the call
/// costs as much as the rest.
fn whole_turns(angle: f64) -> f64 {
    let turns = angle * (1.0 / TAU);
    (turns + if turns < 0.0 { -0.5 } else { 0.5 }) as i64 as f64
}

/// Number of whole quarter turns below an angle: floor(angle / 90 deg).
pub(super) fn quarter(angle: f64) -> f64 {
    libm::floor(angle / FRAC_PI_2)
}

/// All solutions with all whole turns inside the joint ranges; made without allocation.
pub struct AllTurns<'a> {
    arm: &'a Arm,
    branches: Branches,
    /// The branch being counted out, its joints in their lowest turns, and how many turns more each has.
    branch: usize,
    lowest: Joints,
    more: [u32; 6],
    /// The turns of the next solution, or nothing when the branch is counted out.
    next: Option<[u32; 6]>,
}

impl<'a> AllTurns<'a> {
    pub(super) fn new(arm: &'a Arm, branches: Branches) -> AllTurns<'a> {
        let mut turns = AllTurns { arm, branches, branch: 0, lowest: [0.0; 6], more: [0; 6], next: None };
        turns.open();
        turns
    }

    /// Goes on from `branch` to the first branch of which every joint has a turn in its range.
    fn open(&mut self) {
        'branches: while let Some(solution) = self.branches.get(self.branch) {
            for i in 0..6 {
                let Some(lowest) = self.arm.lowest_turn(i, solution.joints[i]) else {
                    self.branch += 1;
                    continue 'branches;
                };
                self.lowest[i] = lowest;
                self.more[i] = self.arm.turns_above(i, lowest);
            }
            self.next = Some([0; 6]);
            return;
        }
        self.next = None;
    }
}

impl Iterator for AllTurns<'_> {
    type Item = Solution;

    fn next(&mut self) -> Option<Solution> {
        let turns = self.next.as_mut()?;
        let mut solution = *self.branches.get(self.branch)?;
        for ((joint, lowest), turn) in solution.joints.iter_mut().zip(&self.lowest).zip(turns.iter()) {
            *joint = lowest + TAU * f64::from(*turn);
        }
        // Counts on, joint 6 fastest.
        for i in (0..6).rev() {
            if turns[i] < self.more[i] {
                turns[i] += 1;
                return Some(solution);
            }
            turns[i] = 0;
        }
        self.branch += 1;
        self.open();
        Some(solution)
    }
}
