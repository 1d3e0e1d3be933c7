//! Random numbers that are the same each time: numbered, not drawn.
//!
//! In: the number of a stream and of a draw. Out: a normal deviate. There is no state and no clock: whoever asks for the k-th
//! number of a stream gets it, on any thread. The bits are those of SplitMix64 at the position k (G. Steele, D. Lea, C. Flood,
//! "Fast splittable pseudorandom number generators", OOPSLA 2014), whose finaliser mixes a counter well enough to pass BigCrush.

/// One stream of numbers.
#[derive(Clone, Copy, Debug)]
pub struct Stream(u64);

/// The golden ratio's fraction in 64 bits, the step of SplitMix64's counter.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Stream {
    /// Streams of different numbers start at places of the sequence that have nothing to do with each other.
    pub fn new(number: u64) -> Stream {
        Stream(mix(number.wrapping_mul(STEP) ^ STEP))
    }

    /// The k-th 64 bits.
    pub fn bits(&self, k: u64) -> u64 {
        mix(self.0.wrapping_add(k.wrapping_add(1).wrapping_mul(STEP)))
    }

    /// The k-th number above 0 and at most 1.
    fn uniform(&self, k: u64) -> f64 {
        ((self.bits(k) >> 11) + 1) as f64 / (1u64 << 53) as f64
    }

    /// The k-th of normal deviates, mean 0 and variance 1 (Box and Muller, from two numbers of its own).
    pub fn normal(&self, k: u64) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(self.uniform(2 * k)));
        radius * libm::cos(2.0 * std::f64::consts::PI * self.uniform(2 * k + 1))
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]
mod tests {
    use super::*;

    #[test]
    fn the_bits_are_those_of_the_published_generator() {
        // SplitMix64 seeded with 1234567 gives these first two numbers (the reference program's output, as Rosetta Code
        // "Pseudo-random numbers/Splitmix64" prints it).
        let stream = Stream(1_234_567);
        assert_eq!([stream.bits(0), stream.bits(1)], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
    }

    #[test]
    fn normal_deviates_have_the_moments_of_a_normal_distribution() {
        // 100,000 deviates: the mean of the powers 1 to 4 lies within four standard errors of 0, 1, 0, 3; the variances of the
        // powers are 1, 2, 15 and 96.
        let stream = Stream::new(7);
        let n = 100_000;
        for (power, expected, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0f64)] {
            let mean = (0..n).map(|k| stream.normal(k).powi(power)).sum::<f64>() / n as f64;
            assert!((mean - expected).abs() < 4.0 * (variance / n as f64).sqrt(), "power {power}: {mean}");
        }
        // Neighbours and streams do not know of each other: correlations within four standard errors of 0.
        for (a, b, shift) in [(7, 7, 1), (7, 8, 0)] {
            let (a, b) = (Stream::new(a), Stream::new(b));
            let product = (0..n).map(|k| a.normal(k) * b.normal(k + shift)).sum::<f64>() / n as f64;
            assert!(product.abs() < 4.0 / (n as f64).sqrt(), "{product}");
        }
    }
}
