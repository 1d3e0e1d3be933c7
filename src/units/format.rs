//! Quantities as people read them: the number with a unit of sensible size.
//!
//! The same table says which units a message offers for a dimension. A test compares its factors with
//! `stdlib/units.polish`.

use super::Dimension;
use super::si::*;
use std::f64::consts::PI;
use std::fmt;

/// A unit that is in common use for a dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommonUnit {
    pub dimension: Dimension,
    /// As a job writes it.
    pub text: &'static str,
    /// Its size in the coherent SI unit.
    pub factor: f64,
    /// The least magnitude, in the SI unit, from which it is chosen over the units before it.
    from: f64,
}

const MINUTE: f64 = 60.0;
const HOUR: f64 = 3600.0;
const DEGREE: f64 = PI / 180.0;

/// The common units: a dimension's units stand together, from the smallest magnitude up. `from` says how large a value
/// must be for the unit: the habit of the optical shop (a part is 340 mm, not 0.34 m; a form error 25 nm; a removal rate um/min).
fn common_units() -> Vec<CommonUnit> {
    let length = Dimension::LENGTH;
    let time = Dimension::TIME;
    let rows: &[(Dimension, &'static str, f64, f64)] = &[
        (length, "nm", 1e-9, 0.0),
        (length, "um", 1e-6, 999.999_5e-9),
        (length, "mm", 1e-3, 99.999_95e-6),
        (length, "m", 1.0, 10.0),
        (Dimension::whole(2, 0, 0, 0), "mm^2", 1e-6, 0.0),
        (Dimension::whole(2, 0, 0, 0), "m^2", 1.0, 1.0),
        (Dimension::whole(3, 0, 0, 0), "mm^3", 1e-9, 0.0),
        (Dimension::ANGLE, "arcsec", DEGREE / 3600.0, 0.0),
        (Dimension::ANGLE, "deg", DEGREE, 0.005 * DEGREE),
        (time, "ms", 1e-3, 0.0),
        (time, "s", 1.0, 0.1),
        (time, "min", MINUTE, 180.0),
        (time, "h", HOUR, 2.0 * HOUR),
        (Dimension::whole(1, 0, -1, 0), "nm/s", 1e-9, 0.0),
        (Dimension::whole(1, 0, -1, 0), "um/s", 1e-6, 999.999_5e-9),
        (Dimension::whole(1, 0, -1, 0), "mm/s", 1e-3, 99.999_95e-6),
        (Dimension::whole(1, 0, -2, 0), "mm/s^2", 1e-3, 0.0),
        (Dimension::whole(0, 0, -1, 1), "deg/s", DEGREE, 0.0),
        (Dimension::whole(0, 0, -1, 1), "rpm", 2.0 * PI / 60.0, 720.0 * DEGREE),
        (Dimension::MASS, "g", 1e-3, 0.0),
        (Dimension::MASS, "kg", 1.0, 0.1),
        (Dimension::whole(2, 1, 0, 0), "kg*m^2", 1.0, 0.0),
        (Dimension::whole(1, 1, -2, 0), "N", 1.0, 0.0),
        (Dimension::whole(-1, 1, -2, 0), "Pa", 1.0, 0.0),
        (Dimension::whole(-1, 1, -2, 0), "MPa", 1e6, 1e4),
        (Dimension::whole(0, 0, -1, 0), "Hz", 1.0, 0.0),
    ];
    rows.iter().map(|&(dimension, text, factor, from)| CommonUnit { dimension, text, factor, from }).collect()
}

/// The common units of `dimension`, from the smallest up. Empty for a plain number and for unusual dimensions.
pub fn units_of(dimension: Dimension) -> Vec<CommonUnit> {
    common_units().into_iter().filter(|unit| unit.dimension == dimension).collect()
}

/// The unit to propose first where one is missing: the one that a value of ordinary size has.
pub fn usual_unit(dimension: Dimension) -> Option<&'static str> {
    let units = units_of(dimension);
    let text = ["mm", "deg", "s", "mm/s", "rpm", "kg"];
    units.iter().find(|unit| text.contains(&unit.text)).or_else(|| units.first()).map(|unit| unit.text)
}

/// `value` (SI) of `dimension` for people: `4 mm`, `20 deg`, `1.5 h`; six significant digits.
pub fn show(value: f64, dimension: Dimension) -> String {
    if dimension.is_number() {
        return number(value);
    }
    let units = units_of(dimension);
    let size = value.abs();
    let fitting = units.iter().rev().find(|unit| size >= unit.from);
    match fitting {
        Some(_) if value == 0.0 => format!("0 {}", usual_unit(dimension).unwrap_or_default()),
        Some(unit) => format!("{} {}", number(value / unit.factor), unit.text),
        None => format!("{} {}", number(value), dimension.si_unit()),
    }
}

/// A number with at most six significant digits, without trailing zeros; powers of ten outside 1e-4 .. 1e7.
pub fn number(value: f64) -> String {
    significant(value, 6)
}

/// The same with at most `digits` significant digits.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return if value.is_nan() { "not a number".into() } else { "infinite".into() };
    }
    // The exponent form rounds first, so that 9.9999999 becomes 10 and not 10.0000.
    let after = digits.max(1) - 1;
    let scientific = format!("{value:.after$e}");
    let (digits, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..7).contains(&exponent) {
        let decimals = (after as i32 - exponent).max(0) as usize;
        trimmed(&format!("{value:.decimals$}")).to_string()
    } else {
        format!("{}e{exponent}", trimmed(digits))
    }
}

fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

macro_rules! shown {
    ($($name:ident = $dimension:expr;)*) => {
        $(
            /// For people: the number with a unit of sensible size.
            impl fmt::Display for $name {
                fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                    f.pad(&show(self.0, $dimension))
                }
            }
        )*

        /// The dimension of the SI newtype of that name.
        pub fn newtype_dimension(name: &str) -> Option<Dimension> {
            match name {
                $(stringify!($name) => Some($dimension),)*
                _ => None,
            }
        }
    };
}

shown! {
    Length = Dimension::LENGTH;
    Area = Dimension::whole(2, 0, 0, 0);
    Angle = Dimension::ANGLE;
    Time = Dimension::TIME;
    Speed = Dimension::whole(1, 0, -1, 0);
    Acceleration = Dimension::whole(1, 0, -2, 0);
    AngularSpeed = Dimension::whole(0, 0, -1, 1);
    AngularAcceleration = Dimension::whole(0, 0, -2, 1);
    Mass = Dimension::MASS;
    Inertia = Dimension::whole(2, 1, 0, 0);
    Force = Dimension::whole(1, 1, -2, 0);
    Pressure = Dimension::whole(-1, 1, -2, 0);
    PerPressure = Dimension::whole(1, -1, 2, 0);
    PerLength2 = Dimension::whole(-2, 0, 0, 0);
    PerLength3 = Dimension::whole(-3, 0, 0, 0);
    PerLength4 = Dimension::whole(-4, 0, 0, 0);
    PerLength5 = Dimension::whole(-5, 0, 0, 0);
    PerLength6 = Dimension::whole(-6, 0, 0, 0);
    PerLength7 = Dimension::whole(-7, 0, 0, 0);
    PerLength8 = Dimension::whole(-8, 0, 0, 0);
    PerLength9 = Dimension::whole(-9, 0, 0, 0);
    PerLength10 = Dimension::whole(-10, 0, 0, 0);
    PerLength11 = Dimension::whole(-11, 0, 0, 0);
    PerLength12 = Dimension::whole(-12, 0, 0, 0);
    PerLength13 = Dimension::whole(-13, 0, 0, 0);
    PerLength14 = Dimension::whole(-14, 0, 0, 0);
    PerLength15 = Dimension::whole(-15, 0, 0, 0);
    PerLength16 = Dimension::whole(-16, 0, 0, 0);
    PerLength17 = Dimension::whole(-17, 0, 0, 0);
    PerLength18 = Dimension::whole(-18, 0, 0, 0);
    PerLength19 = Dimension::whole(-19, 0, 0, 0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_read_like_a_shop_traveller() {
        // Hand conversions: 340 mm = 0.34 m; 632.8 nm; pi/9 rad = 20 deg; 5400 s = 90 min; 2 pi rad/s = 360 deg/s.
        for (shown, expected) in [
            (Length(0.34).to_string(), "340 mm"),
            (Length(632.8e-9).to_string(), "632.8 nm"),
            (Length(25e-6).to_string(), "25 um"),
            (Length(1e-6).to_string(), "1 um"),
            (Length(-0.0005).to_string(), "-0.5 mm"),
            (Length(0.0).to_string(), "0 mm"),
            (Length(12.0).to_string(), "12 m"),
            (Angle(PI / 9.0).to_string(), "20 deg"),
            (Angle(PI / 180.0 / 3600.0).to_string(), "1 arcsec"),
            (Time(5400.0).to_string(), "90 min"),
            (Time(10800.0).to_string(), "3 h"),
            (Speed(0.0002).to_string(), "0.2 mm/s"),
            (AngularSpeed(2.0 * PI).to_string(), "360 deg/s"),
            // 1000 turns in 60 s: 1000 * 2 pi / 60 = 100 pi / 3.
            (AngularSpeed(100.0 * PI / 3.0).to_string(), "1000 rpm"),
            (Mass(42.0).to_string(), "42 kg"),
            (show(0.8, Dimension::NUMBER), "0.8"),
            (show(1600.0, Dimension::whole(-3, 0, 0, 0)), "1600 m^-3"),
        ] {
            assert_eq!(shown, expected);
        }
    }

    #[test]
    fn numbers_keep_six_digits() {
        for (value, expected) in [
            (1.0, "1"),
            (0.1 + 0.2, "0.3"),
            (123_456.7, "123457"),
            (9.999_999_9, "10"),
            (1e-9, "1e-9"),
            (-2.5e8, "-2.5e8"),
        ] {
            assert_eq!(number(value), expected);
        }
        assert_eq!(number(f64::NAN), "not a number");
    }

    #[test]
    fn every_newtype_has_its_dimension() {
        for name in QUANTITY_NAMES {
            assert!(newtype_dimension(name).is_some(), "{name}");
        }
    }
}
