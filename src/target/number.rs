//! Numbers as text, fast and the same on every machine, and the units that all targets write.
//!
//! In: a value and a number of decimals. Out: the shortest text of the value rounded to that many decimals: trailing
//! zeros and an idle point are left out (`12.5`, `0`, `-190`), there is no `-0` and no exponent. A program has a dozen
//! numbers a point, so the digits come straight from an integer, without the general formatter.

use crate::dwell::decimals_of;
use crate::motion::{ToolPose, Transform};

/// The largest magnitude whose every whole number is an `f64`: 2^53. Beyond it a scaled value has no last digit.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// Powers of ten that are exact in `f64`, one for each number of decimals.
const POWERS: [f64; 10] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];

/// Most decimals that can be asked for. Single precision, in which a controller stores numbers, carries seven digits.
pub const MOST_DECIMALS: usize = POWERS.len() - 1;

/// `value * 10^decimals` as a whole number, halves rounded away from zero; `None` when the value is not finite, is too
/// large for its last decimal to mean anything, or `decimals` exceeds [`MOST_DECIMALS`].
pub fn scaled(value: f64, decimals: usize) -> Option<i64> {
    let product = value * POWERS.get(decimals)?;
    (product.abs() < EXACT).then(|| product.round() as i64)
}

/// Writes `value` with at most `decimals` decimals; `None`, with nothing written, where [`scaled`] has none.
pub fn push_fixed(out: &mut Vec<u8>, value: f64, decimals: usize) -> Option<()> {
    push_scaled(out, scaled(value, decimals)?, decimals);
    Some(())
}

/// Writes `scaled / 10^decimals`; `decimals` is at most [`MOST_DECIMALS`].
pub fn push_scaled(out: &mut Vec<u8>, scaled: i64, decimals: usize) {
    let mut rest = scaled.unsigned_abs();
    if rest == 0 {
        out.push(b'0');
        return;
    }
    let mut decimals = decimals;
    while decimals > 0 && rest.is_multiple_of(10) {
        rest /= 10;
        decimals -= 1;
    }
    // Room for the sign, the point and the 19 digits that 2^63 has, filled from the back.
    let mut text = [0u8; 24];
    let mut at = text.len();
    let mut written = 0;
    while rest > 0 || written <= decimals {
        if written == decimals && decimals > 0 {
            at -= 1;
            text[at] = b'.';
        }
        at -= 1;
        text[at] = b'0' + (rest % 10) as u8;
        rest /= 10;
        written += 1;
    }
    if scaled < 0 {
        at -= 1;
        text[at] = b'-';
    }
    out.extend_from_slice(&text[at..]);
}

/// Writes a positive number with so many significant digits (fewer where zeros end it). `None`, with nothing written, for
/// what is not above 0, or not below a million.
pub fn push_significant(out: &mut Vec<u8>, value: f64, digits: usize) -> Option<()> {
    if !(value > 0.0 && value < 1e6) {
        return None;
    }
    let decimals = decimals_of(value, digits);
    let product = value * libm::pow(10.0, decimals as f64);
    (product.abs() < EXACT).then(|| push_scaled(out, product.round() as i64, decimals))
}

/// A mass, a moment, a time or a tolerance: the shortest text of what single precision, in which the controllers store
/// it, makes of the number. `None` where that is no number.
pub fn single(value: f64) -> Option<String> {
    let value = value as f32;
    match value.abs() {
        0.0 => Some("0".into()),
        size if !size.is_finite() => None,
        // Beyond seven digits before or after the point an exponent is shorter than zeros.
        size if !(1e-4..1e7).contains(&size) => Some(format!("{value:E}")),
        _ => Some(format!("{value}")),
    }
}

/// Metres to millimetres.
pub fn millimetres(position: [f64; 3]) -> [f64; 3] {
    position.map(|v| v * 1e3)
}

/// Radians to degrees.
pub fn degrees(angle: f64) -> f64 {
    angle * (180.0 / std::f64::consts::PI)
}

/// Joint angles in degrees.
pub fn joint_degrees(joints: [f64; 6]) -> [f64; 6] {
    joints.map(degrees)
}

/// The quaternion brought to unit length: rounding to the last decimal must be the only error in the text.
pub fn unit_quaternion(q: [f64; 4]) -> [f64; 4] {
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    q.map(|v| v / length)
}

/// Position and quaternion of a transform.
pub fn pose_of(transform: &Transform) -> ToolPose {
    let (t, q) = (transform.translation.vector, transform.rotation);
    // The sign is free; the one with w >= 0 is written, as in the rest of the program's constants.
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    ToolPose { position: [t.x, t.y, t.z], quaternion: [q.w, q.i, q.j, q.k].map(|v| v * sign) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn text(value: f64, decimals: usize) -> String {
        let mut out = Vec::new();
        push_fixed(&mut out, value, decimals).expect("a number that can be written");
        String::from_utf8(out).expect("ASCII")
    }

    /// The general formatter's text with idle zeros, an idle point and the sign of zero taken off.
    fn oracle(value: f64, decimals: usize) -> String {
        let full = format!("{value:.decimals$}");
        let short = if full.contains('.') { full.trim_end_matches('0').trim_end_matches('.') } else { &full };
        if short == "-0" { "0".into() } else { short.into() }
    }

    #[test]
    fn writes_by_hand() {
        for (value, decimals, expected) in [
            (0.0, 4, "0"),
            (-0.0, 4, "0"),
            (-0.00004, 4, "0"),
            (-0.00005, 4, "-0.0001"),
            (0.5, 0, "1"),
            (-190.0, 4, "-190"),
            (0.92387953, 8, "0.92387953"),
            (0.1, 9, "0.1"),
            (12.345, 3, "12.345"),
            (0.05, 1, "0.1"),
            (1000.0, 0, "1000"),
            (10.01, 2, "10.01"),
        ] {
            assert_eq!(text(value, decimals), expected, "{value} to {decimals}");
        }
    }

    #[test]
    fn refuses_what_has_no_digits() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e16] {
            assert_eq!(push_fixed(&mut Vec::new(), value, 4), None);
        }
        assert_eq!(push_fixed(&mut Vec::new(), 1.0, MOST_DECIMALS + 1), None);
    }

    /// How far from a half of the last digit the rounding is certain, in last digits: 3000 with nine decimals is a product of
    /// 3e12, which double precision holds to 2^-53 of itself, and the text is read with as much again.
    fn tie(product: f64) -> f64 {
        1e-6 + product.abs() * f64::EPSILON
    }

    proptest! {
        #[test]
        fn agrees_with_the_general_formatter(value in -3000.0..3000.0f64, decimals in 0usize..=9) {
            // At a tie the product may round across the half; such a value is left to the second property.
            let product = value * POWERS[decimals];
            prop_assume!(((product - product.floor()) - 0.5).abs() > tie(product));
            prop_assert_eq!(text(value, decimals), oracle(value, decimals));
        }

        #[test]
        fn never_farther_than_half_the_last_digit(value in -3000.0..3000.0f64, decimals in 0usize..=9) {
            let read: f64 = text(value, decimals).parse().expect("a number");
            prop_assert!((read - value).abs() <= (0.5 + tie(value * POWERS[decimals])) / POWERS[decimals]);
        }

        #[test]
        fn whole_numbers_come_back(scaled in any::<i64>(), decimals in 0usize..=9) {
            let mut out = Vec::new();
            push_scaled(&mut out, scaled, decimals);
            let text = String::from_utf8(out).expect("ASCII");
            let (whole, fraction) = text.split_once('.').unwrap_or((&text, ""));
            let digits = format!("{whole}{fraction:0<decimals$}");
            prop_assert_eq!(digits.parse::<i128>().expect("digits"), i128::from(scaled));
        }
    }
}
