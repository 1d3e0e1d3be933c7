//! Configuration data: which of an arm's solutions a target means, in ABB's numbers.
//!
//! In: joint angles at full precision. Out: `[cf1, cf4, cf6, cfx]`. cf1, cf4 and cf6 count the quarter turns of axes 1,
//! 4 and 6 (0 for 0 to 90 degrees, -1 for 0 to -90; ABB RAPID reference, `confdata`), cfx asks three yes-or-no
//! questions of serial-link arms: 4 wrist centre behind axis 1, 2 wrist centre behind the lower arm, 1 axis 5 negative.
//! For KUKA arms: [`status_turn`].
//! The programs run with `ConfL\Off` from a stated joint pose, so these numbers inform and do not steer.

use super::arm::{Arm, Joints};
use super::turns::quarter;
use std::f64::consts::FRAC_PI_2;

/// Nearer than this to a whole quarter turn, the rounding of the written target can tip the quarter: 0.1 degrees.
const NEAR_QUARTER: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// ABB configuration data `[cf1, cf4, cf6, cfx]`.
pub fn confdata(arm: &Arm, joints: &Joints) -> [i32; 4] {
    let (branch, _) = arm.posture(joints);
    // cfx asks the sign of axis 5 as the maker counts it.
    let cfx = 4 * i32::from(branch.behind_axis_1) + 2 * i32::from(branch.behind_lower_arm) + i32::from(joints[4] < 0.0);
    [quarter(joints[0]) as i32, quarter(joints[3]) as i32, quarter(joints[5]) as i32, cfx]
}

/// KUKA's status S and turn T of a posture. S: 1 wrist centre behind axis 1, 2 elbow on the side where axis 3 is at or
/// above its stretched angle, 4 axis 5 negative. T: bit i is set where axis i + 1 is negative. The polarity of the third
/// bit of S follows the positions in public programs (status 6 always with a negative axis 5); sources disagree. Bit 4 of
/// S, which controllers with an absolutely accurate model set, is not.
pub fn status_turn(arm: &Arm, joints: &Joints) -> (u8, u8) {
    let (branch, _) = arm.posture(joints);
    let status =
        u8::from(branch.behind_axis_1) + 2 * u8::from(!branch.behind_lower_arm) + 4 * u8::from(joints[4] < 0.0);
    let turn = joints.iter().enumerate().map(|(i, joint)| u8::from(*joint < 0.0) << i).sum();
    (status, turn)
}

/// Whether axis 1, 4 or 6 stands within 0.1 degrees of a whole quarter turn.
pub fn near_quarter(joints: &Joints) -> bool {
    [joints[0], joints[3], joints[5]].iter().any(|joint| {
        let quarters = joint / FRAC_PI_2;
        (quarters - libm::round(quarters)).abs() * FRAC_PI_2 < NEAR_QUARTER
    })
}
