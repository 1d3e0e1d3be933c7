//! Time: how long the moves take, as a kinematic estimate.
//!
//! In: lengths, programmed speeds, the path's acceleration. Out: seconds. Speeds change at constant acceleration inside
//! a move, joint speeds of joint moves at once; a controller also filters, blends and waits, which is not modelled.

/// Seconds of one straight move from `start` to `end` speed (m/s) over `length` metres at up to `speed`, with
/// `acceleration` m/s². `start` and `end` must be no more than `speed` and reachable from one another.
pub(super) fn straight(length: f64, start: f64, end: f64, speed: f64, acceleration: f64) -> f64 {
    let (start_square, end_square) = (start * start, end * end);
    // The speed where acceleration meets braking, if the programmed speed is not reached before.
    let peak = ((2.0 * acceleration * length + start_square + end_square) / 2.0).max(0.0).sqrt().min(speed);
    let ramps = (peak * peak - start_square + peak * peak - end_square) / (2.0 * acceleration);
    let cruise = (length - ramps).max(0.0);
    (peak - start + peak - end) / acceleration + if cruise > 0.0 { cruise / peak } else { 0.0 }
}

/// Seconds of a chain of straight moves, at rest before the first and after the last: `(length, speed)` each.
pub(super) fn chain(moves: &[(f64, f64)], acceleration: f64) -> f64 {
    // The speed at each joint of two moves: no more than either move's, than acceleration from the start allows, and
    // than braking to the end allows.
    let count = moves.len();
    let mut at = vec![0.0_f64; count + 1];
    for i in 1..count {
        let allowed = moves[i - 1].1.min(moves[i].1);
        at[i] = allowed.min((at[i - 1] * at[i - 1] + 2.0 * acceleration * moves[i - 1].0).sqrt());
    }
    for i in (1..count).rev() {
        at[i] = at[i].min((at[i + 1] * at[i + 1] + 2.0 * acceleration * moves[i].0).sqrt());
    }
    (0..count).map(|i| straight(moves[i].0, at[i], at[i + 1], moves[i].1, acceleration)).fold(0.0, |sum, t| sum + t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_move_ramps_cruises_and_brakes() {
        // 1 m at 0.5 m/s with 1 m/s²: half a second and 0.125 m for each ramp, 0.75 m at 0.5 m/s in 1.5 s.
        assert!((straight(1.0, 0.0, 0.0, 0.5, 1.0) - 2.5).abs() < 1e-12);
    }

    #[test]
    fn a_short_move_never_reaches_its_speed() {
        // 0.25 m with 1 m/s²: up to 0.5 m/s in 0.5 s over 0.125 m, and down again.
        assert!((straight(0.25, 0.0, 0.0, 9.0, 1.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_chain_slows_before_a_slow_move() {
        // 1 m at 0.5 m/s into 0.1 m at 0.1 m/s, 1 m/s². First: 0.5 s up (0.125 m), down to 0.1 in 0.4 s (0.12 m), 0.755
        // m cruise in 1.51 s. Second: 0.1 s down over 0.005 m, 0.095 m cruise in 0.95 s.
        let found = chain(&[(1.0, 0.5), (0.1, 0.1)], 1.0);
        assert!((found - (0.5 + 0.4 + 1.51 + 0.95 + 0.1)).abs() < 1e-12, "{found}");
    }

    #[test]
    fn two_equal_moves_are_one() {
        let found = chain(&[(0.5, 0.5), (0.5, 0.5)], 1.0);
        assert!((found - 2.5).abs() < 1e-12, "{found}");
    }
}
