//! Figures: peak to valley and root mean square of a map.

/// Peak to valley, mean, and root mean square about the mean (the population's, over n), of valid values; in the unit
/// of the values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    pub pv: f64,
    pub rms: f64,
    pub mean: f64,
    /// How many values were valid.
    pub count: usize,
}

impl Figures {
    /// Of all values that are not NaN; all zero if there are none. Two passes: the spread is not lost in a large mean.
    pub fn of(values: impl Iterator<Item = f64> + Clone) -> Figures {
        let valid = values.filter(|v| !v.is_nan());
        let (mut count, mut sum, mut low, mut high) = (0_usize, 0.0, f64::INFINITY, f64::NEG_INFINITY);
        for v in valid.clone() {
            count += 1;
            sum += v;
            low = low.min(v);
            high = high.max(v);
        }
        if count == 0 {
            return Figures::default();
        }
        let mean = sum / count as f64;
        let squares: f64 = valid.map(|v| (v - mean) * (v - mean)).sum();
        Figures { pv: high - low, rms: (squares / count as f64).sqrt(), mean, count }
    }
}
