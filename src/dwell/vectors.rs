//! Sums and changes of long vectors, on all cores.
//!
//! In: vectors as long as the times or the pixels. Out: the same bits on any number of threads: the chunks are fixed, and what
//! is summed in them is added in their order.

use rayon::prelude::*;

/// Numbers of a chunk: enough work to be worth a task, and few enough for the first-level cache.
const CHUNK: usize = 8192;

/// Sums of several terms over `0 .. n`.
pub fn sums<const K: usize>(n: usize, term: impl Fn(usize) -> [f64; K] + Sync) -> [f64; K] {
    // Four interleaved lanes, which a processor adds side by side.
    let chunk = |from: usize, to: usize| {
        let mut lanes = [[0.0; K]; 4];
        let quads = (to - from) / 4;
        for quad in 0..quads {
            for (lane, total) in lanes.iter_mut().enumerate() {
                add(total, term(from + 4 * quad + lane));
            }
        }
        for i in from + 4 * quads..to {
            add(&mut lanes[0], term(i));
        }
        let [mut first, second, mut third, fourth] = lanes;
        add(&mut first, second);
        add(&mut third, fourth);
        add(&mut first, third);
        first
    };
    if n <= CHUNK {
        return chunk(0, n);
    }
    let parts: Vec<[f64; K]> =
        (0..n.div_ceil(CHUNK)).into_par_iter().map(|c| chunk(c * CHUNK, n.min((c + 1) * CHUNK))).collect();
    in_order(parts)
}

fn add<const K: usize>(total: &mut [f64; K], more: [f64; K]) {
    for (total, more) in total.iter_mut().zip(more) {
        *total += more;
    }
}

fn in_order<const K: usize>(parts: Vec<[f64; K]>) -> [f64; K] {
    parts.into_iter().fold([0.0; K], |mut total, part| {
        add(&mut total, part);
        total
    })
}

/// Sum over `0 .. n`.
pub fn sum(n: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
    sums(n, |i| [term(i)])[0]
}

/// Sum of products.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let b = &b[..a.len()];
    sum(a.len(), |i| a[i] * b[i])
}

/// Changes every entry, given its index.
pub fn each(values: &mut [f64], change: impl Fn(usize, &mut f64) + Sync) {
    pass(values, |i, value| {
        change(i, value);
        []
    });
}

/// Changes every entry, given its index, and sums what the change says.
pub fn pass<const K: usize>(values: &mut [f64], change: impl Fn(usize, &mut f64) -> [f64; K] + Sync) -> [f64; K] {
    let chunk = |from: usize, values: &mut [f64]| {
        let mut lanes = [[0.0; K]; 4];
        for (i, value) in values.iter_mut().enumerate() {
            add(&mut lanes[i % 4], change(from + i, value));
        }
        let [mut first, second, mut third, fourth] = lanes;
        add(&mut first, second);
        add(&mut third, fourth);
        add(&mut first, third);
        first
    };
    if values.len() <= CHUNK {
        return chunk(0, values);
    }
    let parts: Vec<[f64; K]> =
        values.par_chunks_mut(CHUNK).enumerate().map(|(c, values)| chunk(c * CHUNK, values)).collect();
    in_order(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_added_once() {
        // Whole numbers add up exactly in any order: n (n - 1) / 2, on both sides of a chunk and of a quad.
        for n in [0, 1, 3, 4, 5, CHUNK - 1, CHUNK, CHUNK + 1, 5 * CHUNK + 7] {
            let half = (n * n.saturating_sub(1) / 2) as f64;
            assert_eq!(sums(n, |i| [i as f64, 2.0 * i as f64]), [half, 2.0 * half], "{n}");
            let mut values = vec![1.0; n];
            let said = pass(&mut values, |i, value| {
                *value += i as f64;
                [*value]
            });
            assert_eq!(said, [half + n as f64], "{n}");
            assert!(values.iter().enumerate().all(|(i, value)| *value == 1.0 + i as f64));
        }
    }

    #[test]
    fn threads_do_not_matter() {
        let values: Vec<f64> = (0..50_000).map(|i| libm::sin(i as f64) * libm::exp((i % 40) as f64)).collect();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| dot(&values, &values).to_bits())
        };
        assert!(on(1) == on(2) && on(1) == on(7));
    }
}
