//! Selection: where the error is high.
//!
//! In: an error map, the pixels within reach, and how far the map is lifted. Out: a [`Region`], the pixels to be polished.
//!
//! Removal can only lower the glass, so the map is lifted until (almost) all of it asks for removal, down to a tolerance;
//! what then stands above another tolerance is the region (paper, equation 1):
//! `e - mean + lift > above`. A single threshold says the same: `e - mean > above - lift`.

/// How far the map is lifted before it is cut. All heights in one unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lift {
    /// `3 rms - tolerance`, the paper's. A few high bumps on a flat part lift the flat itself into the region.
    Rms3,
    /// The same, but no more than brings the given part of the pixels to zero: `min(3 rms - tolerance, -quantile)`.
    Bounded(f64),
    /// As the job says.
    Fixed(f64),
}

/// The lifts of one map, whichever is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Known pixels within reach.
    pub count: usize,
    pub mean: f64,
    /// About the mean.
    pub rms: f64,
    pub least: f64,
    pub greatest: f64,
}

impl Statistics {
    /// Of the known pixels of `heights` that are within reach. `None` if there is no such pixel.
    pub fn of(heights: &[f64], reach: &[bool]) -> Option<Statistics> {
        let known = || heights.iter().zip(reach).filter(|(h, reach)| **reach && !h.is_nan()).map(|(h, _)| *h);
        let count = known().count();
        if count == 0 {
            return None;
        }
        let mean = known().sum::<f64>() / count as f64;
        let rms = (known().map(|h| (h - mean) * (h - mean)).sum::<f64>() / count as f64).sqrt();
        let least = known().fold(f64::INFINITY, f64::min);
        let greatest = known().fold(f64::NEG_INFINITY, f64::max);
        Some(Statistics { count, mean, rms, least, greatest })
    }
}

/// The height below which the given part of the known pixels within reach lies, between two pixels in proportion.
pub fn quantile(heights: &[f64], reach: &[bool], part: f64) -> f64 {
    let known = heights.iter().zip(reach).filter(|(h, reach)| **reach && !h.is_nan()).map(|(h, _)| *h);
    let mut known: Vec<f64> = known.collect();
    if known.is_empty() {
        return f64::NAN;
    }
    let at = part.clamp(0.0, 1.0) * (known.len() - 1) as f64;
    let below = at.floor() as usize;
    let (_, low, above) = known.select_nth_unstable_by(below, f64::total_cmp);
    let low = *low;
    let high = above.iter().copied().fold(f64::INFINITY, f64::min);
    if high.is_finite() { low + (at - at.floor()) * (high - low) } else { low }
}

/// What is to be polished.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The map's pixels that belong to it.
    pub pixels: Vec<bool>,
    pub count: usize,
    pub statistics: Statistics,
    /// What the map was lifted by, about its mean.
    pub lift: f64,
    /// Pixels higher than this (as the map has them) belong to the region.
    pub threshold: f64,
    /// Sum of the lifted heights of its pixels.
    pub height_sum: f64,
}

impl Region {
    /// What the glass at a pixel stands above the level that the lift aims at.
    pub fn wanted(&self, height: f64) -> f64 {
        (height - self.statistics.mean + self.lift).max(0.0)
    }
}

/// Selects the pixels within reach that stand higher than `above` once the map is lifted. `None` if no pixel within reach is
/// known. Unknown pixels belong to no region.
pub fn select(heights: &[f64], reach: &[bool], lift: Lift, above: f64, tolerance: f64) -> Option<Region> {
    let statistics = Statistics::of(heights, reach)?;
    let rms3 = 3.0 * statistics.rms - tolerance;
    let lift = match lift {
        Lift::Rms3 => rms3,
        Lift::Bounded(part) => rms3.min(statistics.mean - quantile(heights, reach, part)),
        Lift::Fixed(lift) => lift,
    };
    let threshold = statistics.mean + above - lift;
    // The lifted map is never negative: a lift of less than nothing selects what stands higher than `above` at least.
    let pixels: Vec<bool> = heights
        .iter()
        .zip(reach)
        .map(|(h, reach)| *reach && *h > threshold && *h - statistics.mean + lift > 0.0)
        .collect();
    let mut region = Region { count: 0, pixels, statistics, lift, threshold, height_sum: 0.0 };
    region.count = region.pixels.iter().filter(|pixel| **pixel).count();
    let chosen = heights.iter().zip(&region.pixels).filter(|(_, chosen)| **chosen);
    region.height_sum = chosen.map(|(h, _)| region.wanted(*h)).sum();
    Some(region)
}
