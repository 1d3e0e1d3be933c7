//! Speeds as a target can write them.
//!
//! In: a speed in m/s. Out: the nearest that the target's text can say, or the next below or above. A speed is planned on
//! these steps, so that the prediction speaks of the numbers that stand in the program.

/// The speeds that a target can write.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedSteps {
    /// Whole multiples of this, m/s: a power of ten, or any whole part of one.
    Fixed(f64),
    /// Numbers of so many significant digits, in m/s.
    Digits(usize),
}

/// Powers of ten that are exact in `f64`.
const POWERS: [f64; 19] =
    [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18];

/// The decimals that a positive number below a million has when it is written with so many significant digits, 1 to 15.
pub fn decimals_of(value: f64, digits: usize) -> usize {
    let least = POWERS[(digits.max(1) - 1).min(15)];
    // Rounded first: 9.9999999 with seven digits is 10.00000.
    (0..POWERS.len() - 1).find(|d| (value * POWERS[*d]).round() >= least).unwrap_or(POWERS.len() - 1)
}

impl SpeedSteps {
    /// Steps in 1 m/s, around `speed`. Multiples are made by division by this whole number, so that they are the nearest
    /// numbers to their decimal writing.
    fn in_unit(self, speed: f64) -> f64 {
        match self {
            SpeedSteps::Fixed(step) => (1.0 / step).round(),
            SpeedSteps::Digits(digits) => POWERS[decimals_of(speed, digits)],
        }
    }

    /// The distance to the next speed, m/s.
    pub fn step(self, speed: f64) -> f64 {
        1.0 / self.in_unit(speed)
    }

    pub fn nearest(self, speed: f64) -> f64 {
        let count = self.in_unit(speed);
        (speed * count).round() / count
    }

    /// The greatest that is not above `speed`, but for the rounding of `speed` itself; 0 where there is none.
    pub fn down(self, speed: f64) -> f64 {
        let count = self.in_unit(speed);
        (speed * count * (1.0 + 1e-12)).floor() / count
    }

    /// The least that is not below `speed`, but for the rounding of `speed` itself.
    pub fn up(self, speed: f64) -> f64 {
        let count = self.in_unit(speed);
        (speed * count * (1.0 - 1e-12)).ceil() / count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn by_hand() {
        let fixed = SpeedSteps::Fixed(1e-6);
        assert_eq!(
            (fixed.nearest(0.0123456), fixed.down(0.0123456), fixed.up(0.0123452)),
            (0.012346, 0.012345, 0.012346)
        );
        assert_eq!((fixed.down(0.05), fixed.up(0.05), fixed.down(4e-7)), (0.05, 0.05, 0.0));
        let digits = SpeedSteps::Digits(7);
        assert_eq!(digits.nearest(0.000_512_345_678), 0.000_512_345_7);
        assert_eq!(digits.down(0.020_123_456_78), 0.020_123_45);
        assert_eq!(digits.nearest(0.009_999_999_96), 0.01);
        assert_eq!((digits.down(0.05), digits.up(0.05)), (0.05, 0.05));
        assert_eq!(digits.step(0.05), 1e-8);
    }

    proptest! {
        #[test]
        fn seven_digits_are_what_the_general_formatter_writes(speed in 1e-6f64..0.999) {
            let written: f64 = format!("{speed:.6e}").parse().expect("a number");
            prop_assert_eq!(SpeedSteps::Digits(7).nearest(speed), written);
        }

        #[test]
        fn down_and_up_enclose(speed in 1e-5f64..0.5, digits in 3usize..9) {
            for steps in [SpeedSteps::Digits(digits), SpeedSteps::Fixed(1e-6)] {
                let (down, up) = (steps.down(speed), steps.up(speed));
                prop_assert!(down <= speed * (1.0 + 1e-9) && up >= speed * (1.0 - 1e-9));
                prop_assert!(up - down <= 1.01 * steps.step(speed));
            }
        }
    }
}
