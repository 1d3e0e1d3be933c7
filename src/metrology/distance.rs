//! Distance: how far each pixel of an area is from where the area ends.
//!
//! In: which pixels belong to the area, and their pitch. Out: for each of them the distance, metres, from its centre to the
//! centre of the nearest pixel outside; what lies beyond the picture is outside. Exact, in time proportional to the pixels
//! (lower envelope of parabolas along rows, then columns: P. Felzenszwalb and D. Huttenlocher, "Distance Transforms of
//! Sampled Functions", Theory of Computing 8, 2012).

/// Distance to the nearest pixel outside, metres; zero outside. `inside` is row-major, `pixel` the pitch in x and y.
pub(super) fn to_outside(inside: &[bool], columns: usize, pixel: [f64; 2]) -> Vec<f64> {
    let rows = inside.len() / columns.max(1);
    // One pixel of outside all around.
    let (wide, high) = (columns + 2, rows + 2);
    let mut squares = vec![0.0; wide * high];
    for row in 0..rows {
        for column in 0..columns {
            if inside[row * columns + column] {
                squares[(row + 1) * wide + column + 1] = f64::INFINITY;
            }
        }
    }
    let mut room = Envelope::default();
    for line in squares.chunks_exact_mut(wide) {
        room.run(line, pixel[0]);
    }
    let mut line = vec![0.0; high];
    for column in 0..wide {
        for (row, value) in line.iter_mut().enumerate() {
            *value = squares[row * wide + column];
        }
        room.run(&mut line, pixel[1]);
        for (row, value) in line.iter().enumerate() {
            squares[row * wide + column] = *value;
        }
    }
    let distance = |i: usize| squares[(i / columns + 1) * wide + i % columns + 1].sqrt();
    (0..inside.len()).map(distance).collect()
}

/// The parabolas that are lowest somewhere, from left to right: where each stands, and from where on it is the lowest.
#[derive(Default)]
struct Envelope {
    at: Vec<usize>,
    from: Vec<f64>,
    heights: Vec<f64>,
}

impl Envelope {
    /// Every value becomes the least of `value[j] + (step * (i - j))²`. The first value must be finite.
    fn run(&mut self, values: &mut [f64], step: f64) {
        self.at.clear();
        self.from.clear();
        self.heights.clear();
        self.heights.extend_from_slice(values);
        let heights = &self.heights;
        let square = step * step;
        for (i, height) in heights.iter().enumerate().filter(|(_, height)| height.is_finite()) {
            let mut start = f64::NEG_INFINITY;
            while let Some(last) = self.at.last() {
                // Where the two parabolas cross.
                let (a, b) = (*last as f64, i as f64);
                start = (height - heights[*last] + square * (b * b - a * a)) / (2.0 * square * (b - a));
                if self.from.last().is_some_and(|from| start <= *from) {
                    self.at.pop();
                    self.from.pop();
                    start = f64::NEG_INFINITY;
                } else {
                    break;
                }
            }
            self.at.push(i);
            self.from.push(start);
        }
        let mut k = 0;
        for (i, value) in values.iter_mut().enumerate() {
            while self.from.get(k + 1).is_some_and(|from| *from <= i as f64) {
                k += 1;
            }
            let away = step * (i as f64 - self.at[k] as f64);
            *value = heights[self.at[k]] + away * away;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The definition, pixel by pixel.
        #[test]
        fn distances_are_those_of_the_definition(
            inside in prop::collection::vec(prop::bool::weighted(0.8), 12 * 9), tall in 0.3f64..3.0,
        ) {
            let (columns, rows) = (12_isize, 9_isize);
            let found = to_outside(&inside, 12, [1.0, tall]);
            for (i, found) in found.into_iter().enumerate() {
                let (row, column) = (i as isize / columns, i as isize % columns);
                let mut least = f64::INFINITY;
                for r in -1..=rows {
                    for c in -1..=columns {
                        let out = r < 0 || c < 0 || r == rows || c == columns || !inside[(r * columns + c) as usize];
                        if out {
                            let (x, y) = ((c - column) as f64, (r - row) as f64 * tall);
                            least = least.min((x * x + y * y).sqrt());
                        }
                    }
                }
                prop_assert!((found - least).abs() < 1e-12, "{} {} {}", i, found, least);
            }
        }
    }
}
