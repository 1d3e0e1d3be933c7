//! Dimensions: products of base dimensions with rational exponents, always canonical, so that equal means equal.
//!
//! Angle is a base dimension of its own: it never cancels by itself, so an angular speed times a length is not a speed.

/// A rational number in lowest terms with a positive denominator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Ratio {
    numerator: i32,
    denominator: i32,
}

fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    let (mut a, mut b) = (a.abs(), b.abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl Ratio {
    pub const ZERO: Ratio = Ratio { numerator: 0, denominator: 1 };
    pub const ONE: Ratio = Ratio { numerator: 1, denominator: 1 };

    /// `numerator / denominator` in lowest terms; `None` for a zero denominator or numbers beyond 32 bits.
    pub fn new(numerator: i64, denominator: i64) -> Option<Ratio> {
        if denominator == 0 {
            return None;
        }
        let divisor = greatest_common_divisor(numerator, denominator).max(1);
        let sign = if denominator < 0 { -1 } else { 1 };
        let numerator = (numerator / divisor).checked_mul(sign)?;
        let denominator = (denominator / divisor).checked_mul(sign)?;
        Some(Ratio { numerator: i32::try_from(numerator).ok()?, denominator: i32::try_from(denominator).ok()? })
    }

    fn plus(self, other: Ratio) -> Option<Ratio> {
        let (a, b) = (i64::from(self.numerator), i64::from(self.denominator));
        let (c, d) = (i64::from(other.numerator), i64::from(other.denominator));
        Ratio::new((a.checked_mul(d)?).checked_add(c.checked_mul(b)?)?, b.checked_mul(d)?)
    }

    fn times(self, other: Ratio) -> Option<Ratio> {
        Ratio::new(
            i64::from(self.numerator).checked_mul(i64::from(other.numerator))?,
            i64::from(self.denominator).checked_mul(i64::from(other.denominator))?,
        )
    }

    fn negated(self) -> Ratio {
        Ratio { numerator: self.numerator.saturating_neg(), denominator: self.denominator }
    }

    /// The nearest `f64`.
    pub fn to_f64(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }
}

/// The base dimensions. A `dimension` of stdlib without a right side must be one of these.
pub const BASES: [&str; 6] = ["Length", "Mass", "Time", "Angle", "Temperature", "Current"];

/// The coherent SI unit of each base dimension.
const BASE_UNITS: [&str; 6] = ["m", "kg", "s", "rad", "K", "A"];

/// One rational exponent for each of [`BASES`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Dimension([Ratio; BASES.len()]);

impl Dimension {
    /// A plain number: all exponents zero.
    pub const NUMBER: Dimension = Dimension([Ratio::ZERO; BASES.len()]);
    pub const LENGTH: Dimension = Dimension::single(0);
    pub const MASS: Dimension = Dimension::single(1);
    pub const TIME: Dimension = Dimension::single(2);
    pub const ANGLE: Dimension = Dimension::single(3);

    const fn single(index: usize) -> Dimension {
        let mut exponents = [Ratio::ZERO; BASES.len()];
        exponents[index] = Ratio::ONE;
        Dimension(exponents)
    }

    /// The base dimension of that name.
    pub fn base(name: &str) -> Option<Dimension> {
        BASES.iter().position(|base| *base == name).map(Dimension::single)
    }

    /// From whole exponents of length, mass, time and angle.
    pub fn whole(length: i32, mass: i32, time: i32, angle: i32) -> Dimension {
        let mut dimension = Dimension::NUMBER;
        for (exponent, whole) in dimension.0.iter_mut().zip([length, mass, time, angle]) {
            *exponent = Ratio { numerator: whole, denominator: 1 };
        }
        dimension
    }

    /// Whether it is a plain number.
    pub fn is_number(self) -> bool {
        self == Dimension::NUMBER
    }

    /// The product; `None` if an exponent grows beyond 32 bits.
    pub fn times(self, other: Dimension) -> Option<Dimension> {
        let mut product = Dimension::NUMBER;
        for (i, exponent) in product.0.iter_mut().enumerate() {
            *exponent = self.0[i].plus(other.0[i])?;
        }
        Some(product)
    }

    /// The quotient; `None` if an exponent grows beyond 32 bits.
    pub fn over(self, other: Dimension) -> Option<Dimension> {
        self.times(Dimension(other.0.map(Ratio::negated)))
    }

    /// The power; `None` if an exponent grows beyond 32 bits.
    pub fn power(self, exponent: Ratio) -> Option<Dimension> {
        let mut power = Dimension::NUMBER;
        for (i, target) in power.0.iter_mut().enumerate() {
            *target = self.0[i].times(exponent)?;
        }
        Some(power)
    }

    /// `Length^2 / Time`: the base dimensions factor by factor. `Number` for a plain number.
    pub fn factors(self) -> String {
        self.written(&BASES, " * ", " / ", "Number", "1")
    }

    /// `m^2/s`: the coherent SI unit, as a job writes it. Empty for a plain number.
    pub fn si_unit(self) -> String {
        self.written(&BASE_UNITS, "*", "/", "", "")
    }

    fn written(self, words: &[&str], times: &str, over: &str, nothing: &str, one: &str) -> String {
        let factor = |word: &str, exponent: Ratio| match (exponent.numerator, exponent.denominator) {
            (1, 1) => word.to_string(),
            (n, 1) => format!("{word}^{n}"),
            (n, d) => format!("{word}^({n}/{d})"),
        };
        let mut above = Vec::new();
        let mut below = Vec::new();
        for (word, exponent) in words.iter().zip(self.0) {
            if exponent > Ratio::ZERO && exponent.numerator > 0 {
                above.push(factor(word, exponent));
            } else if exponent.numerator < 0 {
                below.push((word, exponent));
            }
        }
        if above.is_empty() && below.is_empty() {
            return nothing.to_string();
        }
        if one.is_empty() {
            // A unit ends in at most one `/`, which has something before it: the rest are negative powers.
            let divisor = if above.is_empty() { None } else { below.pop() };
            above.extend(below.iter().map(|(word, exponent)| factor(word, *exponent)));
            let divisor = divisor.map(|(word, exponent)| format!("{over}{}", factor(word, exponent.negated())));
            return above.join(times) + &divisor.unwrap_or_default();
        }
        let mut text = if above.is_empty() { one.to_string() } else { above.join(times) };
        for (word, exponent) in below {
            text.push_str(over);
            text.push_str(&factor(word, exponent.negated()));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_canonical() {
        assert_eq!(Ratio::new(2, 4), Ratio::new(-1, -2));
        assert_eq!(Ratio::new(0, -7), Some(Ratio::ZERO));
        assert_eq!(Ratio::new(1, 0), None);
        assert_eq!(Ratio::new(i64::MAX, 1), None);
    }

    #[test]
    fn algebra_is_exact() {
        let speed = Dimension::LENGTH.over(Dimension::TIME).expect("small exponents");
        assert_eq!(speed, Dimension::whole(1, 0, -1, 0));
        let half = Ratio::new(1, 2).expect("a ratio");
        let root = Dimension::LENGTH.power(half).expect("small exponents");
        assert_eq!(root.times(root), Some(Dimension::LENGTH));
        // Angle does not cancel: rad/s * m is not m/s.
        let angular = Dimension::ANGLE.over(Dimension::TIME).expect("small exponents");
        assert_ne!(angular.times(Dimension::LENGTH), Some(speed));
        // An exponent beyond 32 bits is refused, not wrapped.
        let huge = Dimension::LENGTH.power(Ratio::new(i64::from(i32::MAX), 1).expect("a ratio")).expect("fits");
        assert_eq!(huge.times(Dimension::LENGTH), None);
    }

    #[test]
    fn dimensions_are_written_factor_by_factor() {
        assert_eq!(Dimension::whole(1, 0, -2, 0).factors(), "Length / Time^2");
        assert_eq!(Dimension::whole(-3, 0, 0, 0).factors(), "1 / Length^3");
        assert_eq!(Dimension::NUMBER.factors(), "Number");
        assert_eq!(Dimension::whole(1, 0, -2, 0).si_unit(), "m/s^2");
        assert_eq!(Dimension::whole(-1, 1, -2, 0).si_unit(), "kg*m^-1/s^2");
        assert_eq!(Dimension::whole(-3, 0, 0, 0).si_unit(), "m^-3");
    }
}
