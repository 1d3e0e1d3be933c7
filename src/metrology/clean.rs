//! Clean: what of a picture is no glass.
//!
//! In: a picture as the file shows it, and the job's words. Out: the picture with more unknown pixels, and how many each
//! word took out. In this order: `mask`, `trim`, `despike`.

use super::{distance, holes};
use crate::diagnostics::{Problem, codes};
use crate::height_map::{Grid, Picture, RawMap};
use crate::job::Despike;
use rayon::prelude::*;

/// Takes out the pixels that are zero or invalid in `mask`. How many known ones that were. Fields are `mask`.
///
/// # Errors
/// E0537 for a mask of another size.
pub(super) fn mask(picture: &mut Picture, mask: &RawMap) -> Result<usize, Problem> {
    if (mask.columns, mask.rows) != (picture.columns, picture.rows) {
        let message = format!(
            "the mask has {} columns and {} rows, the map {} and {}",
            mask.columns, mask.rows, picture.columns, picture.rows
        );
        return Err(Problem::error(codes::E0537, "mask", message)
            .help("a mask has a pixel for each pixel of the map's file, in the same orientation"));
    }
    // A file with a scale of its own holds heights, of which zero is a good one; an array without one holds 0 and 1.
    let out = |value: f64| value.is_nan() || (!mask.in_metres && value == 0.0);
    let mut count = 0;
    for (value, _) in picture.values.iter_mut().zip(&mask.values).filter(|(_, mask)| out(**mask)) {
        count += usize::from(!value.is_nan());
        *value = f64::NAN;
    }
    Ok(count)
}

/// Takes out the pixels whose centre lies no farther than `width` from that of the nearest pixel that was not seen, the
/// surroundings of the picture included. Holes up to `small` square metres are not borders: they are filled later, and a
/// single lost pixel must not grow. How many pixels that were.
pub(super) fn trim(picture: &mut Picture, width: f64, small: f64) -> usize {
    let grid = as_grid(picture);
    let mut inside: Vec<bool> = grid.values.iter().map(|value| !value.is_nan()).collect();
    let pixel_area = picture.pixel[0] * picture.pixel[1];
    for hole in holes::find(&grid, &vec![true; inside.len()]) {
        if !hole.open && hole.pixels.len() as f64 * pixel_area <= small {
            hole.pixels.iter().for_each(|i| inside[*i] = true);
        }
    }
    let distances = distance::to_outside(&inside, picture.columns, picture.pixel);
    let mut count = 0;
    for (value, distance) in picture.values.iter_mut().zip(distances) {
        // Two pixels of 0.1 mm lie within 0.2 mm, whatever the last bits say.
        if distance <= width * (1.0 + 1e-9) && !value.is_nan() {
            *value = f64::NAN;
            count += 1;
        }
    }
    count
}

/// A height that follows a normal distribution has 1.4826 times its median absolute deviation as standard deviation.
const ROBUST: f64 = 1.4826;

/// Fewest pairs of opposite neighbours that a pixel is judged by: the median of three stands one that is wrong.
const FEWEST_PAIRS: usize = 3;

/// Takes out spikes: pixels that differ from the median of the means of their opposite neighbours by more than `above`
/// robust standard deviations of that difference. Means of opposite neighbours do not see slopes, also at a rim. A
/// pixel with fewer than three known pairs is not judged. How many pixels that were.
pub(super) fn despike(picture: &mut Picture, rule: &Despike) -> usize {
    let grid = as_grid(picture);
    let reach = rule.reach as isize;
    // One of each two opposite neighbours: those after the pixel in reading order.
    let ahead: Vec<(isize, isize)> = (0..=reach)
        .flat_map(|dr| (-reach..=reach).map(move |dc| (dr, dc)))
        .filter(|(dr, dc)| *dr > 0 || *dc > 0)
        .collect();
    let known = |row: isize, column: isize| {
        let there = row >= 0 && column >= 0 && row < grid.rows as isize && column < grid.columns as isize;
        if there { grid.at(row as usize, column as usize) } else { f64::NAN }
    };
    let mut off = vec![f64::NAN; grid.values.len()];
    off.par_chunks_mut(grid.columns).enumerate().for_each_init(
        || Vec::with_capacity(ahead.len()),
        |pairs, (row, line)| {
            for (column, off) in line.iter_mut().enumerate().filter(|(c, _)| !grid.at(row, *c).is_nan()) {
                let (r, c) = (row as isize, column as isize);
                pairs.clear();
                pairs.extend(
                    ahead
                        .iter()
                        .map(|(dr, dc)| (known(r + dr, c + dc) + known(r - dr, c - dc)) / 2.0)
                        .filter(|mean| !mean.is_nan()),
                );
                if pairs.len() >= FEWEST_PAIRS {
                    *off = grid.at(row, column) - median(pairs);
                }
            }
        },
    );
    let mut sizes: Vec<f64> = off.iter().map(|off| off.abs()).filter(|size| !size.is_nan()).collect();
    if sizes.is_empty() {
        return 0;
    }
    // In a map of few counts more than half of the differences may be nothing at all: then the smallest step that it knows
    // stands for its noise.
    let smallest = sizes.iter().copied().filter(|size| *size > 0.0).fold(f64::INFINITY, f64::min);
    let noise = (ROBUST * median(&mut sizes)).max(smallest);
    let mut count = 0;
    for (value, off) in picture.values.iter_mut().zip(off) {
        if off.abs() > rule.above * noise {
            *value = f64::NAN;
            count += 1;
        }
    }
    count
}

/// The median of at least one value; of an even number, the upper of the two in the middle.
fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The picture as a grid of its own frame, row 0 first.
fn as_grid(picture: &Picture) -> Grid {
    Grid {
        columns: picture.columns,
        rows: picture.rows,
        pixel: picture.pixel,
        origin: [0.0; 2],
        values: picture.values.clone(),
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]
mod tests {
    use super::*;

    fn picture(columns: usize, rows: usize, height: impl Fn(f64, f64) -> f64) -> Picture {
        let values = (0..columns * rows).map(|i| height((i % columns) as f64, (i / columns) as f64)).collect();
        Picture { columns, rows, pixel: [1e-3; 2], values }
    }

    fn unknown(picture: &Picture) -> usize {
        picture.values.iter().filter(|v| v.is_nan()).count()
    }

    #[test]
    fn spikes_go_and_slopes_stay() {
        // Noise of ±1 nm on a steep plane (50 nm a pixel) with a rim; spikes of 40 nm in the middle, beside each other, and
        // one at the rim. A bump of 30 nm over 12 pixels is glass: it stands out of its neighbours by some 2 nm.
        let noise = |x: f64, y: f64| {
            let k = (x * 31.0 + y * 57.0) as u64;
            ((k.wrapping_mul(6_364_136_223_846_793_005) >> 40) & 1023) as f64 / 512.0 - 1.0
        };
        let bump = |x: f64, y: f64| 30.0 * (-((x - 40.0).powi(2) + (y - 20.0).powi(2)) / 72.0).exp();
        let map = |x: f64, y: f64| {
            if (x - 30.0).powi(2) + (y - 30.0).powi(2) > 900.0 { f64::NAN } else { 50.0 * x + noise(x, y) + bump(x, y) }
        };
        let clean = picture(61, 61, map);
        let rule = Despike { above: 12.0, reach: 2 };
        let mut unspoilt = clean.clone();
        assert_eq!(despike(&mut unspoilt, &rule), 0);
        let mut spoilt = clean.clone();
        let spikes = [(30, 30), (31, 30), (20, 45), (30, 1), (12, 20)];
        for (column, row) in spikes {
            spoilt.values[row * 61 + column] += 60.0;
        }
        assert_eq!(despike(&mut spoilt, &rule), spikes.len());
        assert_eq!(unknown(&spoilt), unknown(&clean) + spikes.len());
        assert!(spikes.iter().all(|(column, row)| spoilt.values[row * 61 + column].is_nan()));
    }

    #[test]
    fn a_map_of_few_counts_keeps_its_steps() {
        // Steps of one count every eight columns: most differences are nothing, and one count is no spike.
        let mut steps = picture(40, 40, |x, _| (x / 8.0).floor());
        assert_eq!(despike(&mut steps, &Despike { above: 5.0, reach: 2 }), 0);
        steps.values[20 * 40 + 20] += 9.0;
        assert_eq!(despike(&mut steps, &Despike { above: 5.0, reach: 2 }), 1);
        let mut nothing = picture(5, 5, |_, _| f64::NAN);
        assert_eq!(despike(&mut nothing, &Despike { above: 5.0, reach: 2 }), 0);
    }

    #[test]
    fn trimming_follows_the_border_and_leaves_small_holes() {
        // 20 x 15 pixels, all seen but one pixel and a block of 4 x 4. Two pixels off: 16 x 11 stay of the frame.
        let seen = |x: f64, y: f64| {
            let lost = (x, y) == (5.0, 7.0) || ((11.0..=14.0).contains(&x) && (6.0..=9.0).contains(&y));
            if lost { f64::NAN } else { 1.0 }
        };
        let mut map = picture(20, 15, seen);
        // The single pixel is a small hole: nothing beside it goes. Around the block of 16 a ring within 2 mm: 4 * (4 + 4) to
        // the sides and, of each corner's, the places (1,1), that is 1.41 mm; (1,2) lies 2.2 mm away: 4.
        let count = trim(&mut map, 2e-3, 1.5e-6);
        let frame = 20 * 15 - 16 * 11;
        assert_eq!(count, frame + 32 + 4);
        // No hole is small: the single pixel has its own ring of 4 * 2 and 4.
        let mut map = picture(20, 15, seen);
        assert_eq!(trim(&mut map, 2e-3, 0.0), frame + 32 + 4 + 12);
    }
}
