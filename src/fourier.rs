//! Convolution of a real grid with a fixed kernel by discrete Fourier transform, and its transpose.
//!
//! In: a kernel, once; then grids. Out: the cyclic convolution, or the cyclic correlation, which is its exact transpose;
//! and of a grid alone its [power spectrum](power_spectrum).
//! Why our own: a solved dwell time decides a printed digit of a robot program, and a program must not depend on the
//! processor. The libraries choose vector instructions at run time and take their roots of unity from the platform's
//! sine, so their last bits differ between machines. Here every operation is written out, in one order, on plain `f64`,
//! and the roots come from `libm`: the same bits everywhere, on any number of threads.
//!
//! Method: the first axis is transformed for many columns side by side (Stockham's self-sorting form, radices 4, 2, 3
//! and 5), so the inner loops run along memory. Two real columns travel as one complex column. The second axis is the
//! same after a transposition. (C. Van Loan, "Computational Frameworks for the Fast Fourier Transform", SIAM 1992.)

use rayon::prelude::*;

/// Columns that are transformed side by side: 16 columns of 1000 rows, with their copy, fit a second-level cache.
const BLOCK: usize = 16;

/// The least number that is at least `n` and has no prime factor above 5; even if `even`.
pub fn good_length(n: usize, even: bool) -> usize {
    let mut length = n.max(2);
    loop {
        let mut rest = length;
        for prime in [2, 3, 5] {
            while rest.is_multiple_of(prime) {
                rest /= prime;
            }
        }
        if rest == 1 && (!even || length.is_multiple_of(2)) {
            return length;
        }
        length += 1;
    }
}

/// One stage of the transform: a radix, and the roots of unity `exp(-2 pi i p k / n)` for k = 1 .. radix at each p.
struct Stage {
    radix: usize,
    roots: Vec<[f64; 2]>,
}

/// A transform of one length along the first axis.
struct Plan {
    length: usize,
    stages: Vec<Stage>,
}

impl Plan {
    fn new(length: usize) -> Plan {
        let mut stages = Vec::new();
        let mut rest = length;
        while rest > 1 {
            let radix = [4, 2, 3, 5].into_iter().find(|r| rest.is_multiple_of(*r)).unwrap_or(rest);
            let mut roots = Vec::with_capacity(rest / radix * (radix - 1));
            for p in 0..rest / radix {
                for k in 1..radix {
                    // The exponent is reduced as a whole number first, so that the angle keeps its full precision.
                    let turn = (p * k % rest) as f64 / rest as f64;
                    let (sine, cosine) = libm::sincos(-2.0 * std::f64::consts::PI * turn);
                    roots.push([cosine, sine]);
                }
            }
            stages.push(Stage { radix, roots });
            rest /= radix;
        }
        Plan { length, stages }
    }

    /// Transforms `length` rows of `BLOCK` columns in place, exponent negative. With `re` and `im` exchanged it is the
    /// transform with positive exponent. Not normalised.
    fn run(&self, re: &mut [f64], im: &mut [f64], scratch: &mut [Vec<f64>; 2]) {
        let [scratch_re, scratch_im] = scratch;
        scratch_re.resize(re.len(), 0.0);
        scratch_im.resize(im.len(), 0.0);
        let (mut n, mut stride, mut here) = (self.length, BLOCK, true);
        for stage in &self.stages {
            if here {
                stage.run(n, stride, [re, im], [scratch_re, scratch_im]);
            } else {
                stage.run(n, stride, [scratch_re, scratch_im], [re, im]);
            }
            here = !here;
            n /= stage.radix;
            stride *= stage.radix;
        }
        if !here {
            re.copy_from_slice(scratch_re);
            im.copy_from_slice(scratch_im);
        }
    }
}

impl Stage {
    /// `n` points remain to be transformed, `stride` numbers (columns times finished points) share each root.
    fn run(&self, n: usize, stride: usize, from: [&[f64]; 2], to: [&mut [f64]; 2]) {
        let m = n / self.radix;
        let [to_re, to_im] = to;
        let out = to_re.chunks_exact_mut(self.radix * stride).zip(to_im.chunks_exact_mut(self.radix * stride));
        for (p, (out_re, out_im)) in out.enumerate() {
            let roots = &self.roots[p * (self.radix - 1)..(p + 1) * (self.radix - 1)];
            let part = |j: usize| {
                let start = stride * (p + m * j);
                (&from[0][start..start + stride], &from[1][start..start + stride])
            };
            match self.radix {
                2 => radix2([part(0), part(1)], roots, out_re, out_im),
                3 => radix3([part(0), part(1), part(2)], roots, out_re, out_im),
                4 => radix4([part(0), part(1), part(2), part(3)], roots, out_re, out_im),
                _ => radix5([part(0), part(1), part(2), part(3), part(4)], roots, out_re, out_im),
            }
        }
    }
}

type Part<'a> = (&'a [f64], &'a [f64]);

fn times(re: f64, im: f64, root: [f64; 2]) -> (f64, f64) {
    (re * root[0] - im * root[1], re * root[1] + im * root[0])
}

fn radix2(parts: [Part; 2], roots: &[[f64; 2]], out_re: &mut [f64], out_im: &mut [f64]) {
    let n = parts[0].0.len();
    let [(ar, ai), (br, bi)] = parts.map(|(re, im)| (&re[..n], &im[..n]));
    let (r0, r1) = out_re.split_at_mut(n);
    let (i0, i1) = out_im.split_at_mut(n);
    let (r1, i0, i1) = (&mut r1[..n], &mut i0[..n], &mut i1[..n]);
    for q in 0..n {
        r0[q] = ar[q] + br[q];
        i0[q] = ai[q] + bi[q];
        (r1[q], i1[q]) = times(ar[q] - br[q], ai[q] - bi[q], roots[0]);
    }
}

fn radix3(parts: [Part; 3], roots: &[[f64; 2]], out_re: &mut [f64], out_im: &mut [f64]) {
    const HALF_SQRT_3: f64 = 0.866_025_403_784_438_6;
    let n = parts[0].0.len();
    let [(ar, ai), (br, bi), (cr, ci)] = parts.map(|(re, im)| (&re[..n], &im[..n]));
    let (r0, rest) = out_re.split_at_mut(n);
    let (r1, r2) = rest.split_at_mut(n);
    let (i0, rest) = out_im.split_at_mut(n);
    let (i1, i2) = rest.split_at_mut(n);
    let (r1, r2, i0, i1, i2) = (&mut r1[..n], &mut r2[..n], &mut i0[..n], &mut i1[..n], &mut i2[..n]);
    for q in 0..n {
        let (sum_r, sum_i) = (br[q] + cr[q], bi[q] + ci[q]);
        let (diff_r, diff_i) = (HALF_SQRT_3 * (br[q] - cr[q]), HALF_SQRT_3 * (bi[q] - ci[q]));
        let (mid_r, mid_i) = (ar[q] - 0.5 * sum_r, ai[q] - 0.5 * sum_i);
        r0[q] = ar[q] + sum_r;
        i0[q] = ai[q] + sum_i;
        (r1[q], i1[q]) = times(mid_r + diff_i, mid_i - diff_r, roots[0]);
        (r2[q], i2[q]) = times(mid_r - diff_i, mid_i + diff_r, roots[1]);
    }
}

fn radix4(parts: [Part; 4], roots: &[[f64; 2]], out_re: &mut [f64], out_im: &mut [f64]) {
    let n = parts[0].0.len();
    let [(ar, ai), (br, bi), (cr, ci), (dr, di)] = parts.map(|(re, im)| (&re[..n], &im[..n]));
    let (r0, rest) = out_re.split_at_mut(n);
    let (r1, rest) = rest.split_at_mut(n);
    let (r2, r3) = rest.split_at_mut(n);
    let (i0, rest) = out_im.split_at_mut(n);
    let (i1, rest) = rest.split_at_mut(n);
    let (i2, i3) = rest.split_at_mut(n);
    let (r1, r2, r3) = (&mut r1[..n], &mut r2[..n], &mut r3[..n]);
    let (i0, i1, i2, i3) = (&mut i0[..n], &mut i1[..n], &mut i2[..n], &mut i3[..n]);
    let (w1, w2, w3) = (roots[0], roots[1], roots[2]);
    for q in 0..n {
        let (even_r, even_i) = (ar[q] + cr[q], ai[q] + ci[q]);
        let (odd_r, odd_i) = (ar[q] - cr[q], ai[q] - ci[q]);
        let (sum_r, sum_i) = (br[q] + dr[q], bi[q] + di[q]);
        let (diff_r, diff_i) = (br[q] - dr[q], bi[q] - di[q]);
        r0[q] = even_r + sum_r;
        i0[q] = even_i + sum_i;
        (r1[q], i1[q]) = times(odd_r + diff_i, odd_i - diff_r, w1);
        (r2[q], i2[q]) = times(even_r - sum_r, even_i - sum_i, w2);
        (r3[q], i3[q]) = times(odd_r - diff_i, odd_i + diff_r, w3);
    }
}

fn radix5(parts: [Part; 5], roots: &[[f64; 2]], out_re: &mut [f64], out_im: &mut [f64]) {
    const COS_72: f64 = 0.309_016_994_374_947_45;
    const COS_144: f64 = -0.809_016_994_374_947_5;
    const SIN_72: f64 = 0.951_056_516_295_153_5;
    const SIN_144: f64 = 0.587_785_252_292_473_1;
    let n = parts[0].0.len();
    let [(ar, ai), (br, bi), (cr, ci), (dr, di), (er, ei)] = parts.map(|(re, im)| (&re[..n], &im[..n]));
    let mut out = out_re.chunks_exact_mut(n).zip(out_im.chunks_exact_mut(n));
    let mut next = || out.next().unwrap_or_default();
    let ((r0, i0), (r1, i1), (r2, i2), (r3, i3), (r4, i4)) = (next(), next(), next(), next(), next());
    for q in 0..n {
        let (s1r, s1i, d1r, d1i) = (br[q] + er[q], bi[q] + ei[q], br[q] - er[q], bi[q] - ei[q]);
        let (s2r, s2i, d2r, d2i) = (cr[q] + dr[q], ci[q] + di[q], cr[q] - dr[q], ci[q] - di[q]);
        let (m1r, m1i) = (ar[q] + COS_72 * s1r + COS_144 * s2r, ai[q] + COS_72 * s1i + COS_144 * s2i);
        let (m2r, m2i) = (ar[q] + COS_144 * s1r + COS_72 * s2r, ai[q] + COS_144 * s1i + COS_72 * s2i);
        let (n1r, n1i) = (SIN_72 * d1r + SIN_144 * d2r, SIN_72 * d1i + SIN_144 * d2i);
        let (n2r, n2i) = (SIN_144 * d1r - SIN_72 * d2r, SIN_144 * d1i - SIN_72 * d2i);
        r0[q] = ar[q] + s1r + s2r;
        i0[q] = ai[q] + s1i + s2i;
        (r1[q], i1[q]) = times(m1r + n1i, m1i - n1r, roots[0]);
        (r2[q], i2[q]) = times(m2r + n2i, m2i - n2r, roots[1]);
        (r3[q], i3[q]) = times(m2r - n2i, m2i + n2r, roots[2]);
        (r4[q], i4[q]) = times(m1r - n1i, m1i + n1r, roots[3]);
    }
}

/// Room that one thread needs besides its block.
#[derive(Default)]
struct Room {
    re: Vec<f64>,
    im: Vec<f64>,
    scratch: [Vec<f64>; 2],
}

/// Cyclic convolution of `rows * columns` grids (row-major) with a fixed kernel.
pub struct Convolution {
    rows: usize,
    columns: usize,
    along_rows: Plan,
    along_columns: Plan,
    /// Spectrum of the kernel over `rows * columns`, laid out like `spectrum`.
    kernel: Vec<f64>,
    /// Blocks of column pairs: for each frequency of the first axis left real, left imaginary, right real, right
    /// imaginary parts of `BLOCK` columns; on the way back two real columns of `rows`.
    pairs: Vec<f64>,
    /// Blocks of first-axis frequencies, `columns` rows of `BLOCK` numbers: real parts, then imaginary parts.
    spectrum: Vec<f64>,
}

impl Convolution {
    /// `kernel` is row-major with its origin at (0, 0), negative offsets wrapped round. `rows` and `columns` must come
    /// from [`good_length`], `columns` even.
    pub fn new(rows: usize, columns: usize, kernel: &[f64]) -> Convolution {
        let frequencies = rows / 2 + 1;
        let pair_blocks = (columns / 2).div_ceil(BLOCK);
        let spectrum_blocks = frequencies.div_ceil(BLOCK);
        let mut convolution = Convolution {
            rows,
            columns,
            along_rows: Plan::new(rows),
            along_columns: Plan::new(columns),
            kernel: Vec::new(),
            pairs: vec![0.0; pair_blocks * frequencies * 4 * BLOCK],
            spectrum: vec![0.0; spectrum_blocks * columns * 2 * BLOCK],
        };
        convolution.transform_rows(kernel);
        convolution.transform_columns(None);
        let scale = 1.0 / (rows * columns) as f64;
        convolution.kernel = convolution.spectrum.iter().map(|value| value * scale).collect();
        convolution
    }

    /// A filter: the same with `shape` of each value of the kernel's spectrum, real and imaginary part, in its place. `shape`
    /// of the conjugate value must be the conjugate, so that a real grid stays real.
    pub fn shaped(
        rows: usize,
        columns: usize,
        kernel: &[f64],
        shape: impl Fn([f64; 2]) -> [f64; 2] + Sync,
    ) -> Convolution {
        let mut convolution = Convolution::new(rows, columns, kernel);
        let (size, count) = (columns * BLOCK, (rows * columns) as f64);
        convolution.kernel.par_chunks_mut(2 * size).for_each(|block| {
            let (re, im) = block.split_at_mut(size);
            for (re, im) in re.iter_mut().zip(im) {
                let shaped = shape([*re * count, *im * count]);
                (*re, *im) = (shaped[0] / count, shaped[1] / count);
            }
        });
        convolution
    }

    /// `grid` becomes its convolution with the kernel.
    pub fn convolve(&mut self, grid: &mut [f64]) {
        self.transform_rows(grid);
        self.transform_columns(Some(1.0));
        self.transform_rows_back(grid);
    }

    /// `grid` becomes its correlation with the kernel: the transpose of [`Convolution::convolve`].
    pub fn correlate(&mut self, grid: &mut [f64]) {
        self.transform_rows(grid);
        self.transform_columns(Some(-1.0));
        self.transform_rows_back(grid);
    }

    /// Real grid to `pairs`: the first axis transformed. The left half of the columns travels as real, the right half
    /// as imaginary part; both are sorted out by their symmetry.
    fn transform_rows(&mut self, grid: &[f64]) {
        let Convolution { rows, columns, along_rows, pairs, .. } = self;
        let (rows, columns, half) = (*rows, *columns, *columns / 2);
        pairs.par_chunks_mut((rows / 2 + 1) * 4 * BLOCK).enumerate().for_each_init(
            Room::default,
            |room, (b, pairs)| {
                let first = b * BLOCK;
                let width = BLOCK.min(half - first);
                room.clear(rows * BLOCK);
                for row in 0..rows {
                    let left = row * columns + first;
                    room.re[row * BLOCK..][..width].copy_from_slice(&grid[left..left + width]);
                    room.im[row * BLOCK..][..width].copy_from_slice(&grid[left + half..left + half + width]);
                }
                along_rows.run(&mut room.re, &mut room.im, &mut room.scratch);
                for (k, pair) in pairs.chunks_exact_mut(4 * BLOCK).enumerate() {
                    let (here, mirror) = (k * BLOCK, (rows - k) % rows * BLOCK);
                    for j in 0..BLOCK {
                        let (ar, ai) = (room.re[here + j], room.im[here + j]);
                        let (br, bi) = (room.re[mirror + j], room.im[mirror + j]);
                        pair[j] = 0.5 * (ar + br);
                        pair[BLOCK + j] = 0.5 * (ai - bi);
                        pair[2 * BLOCK + j] = 0.5 * (ai + bi);
                        pair[3 * BLOCK + j] = 0.5 * (br - ar);
                    }
                }
            },
        );
    }

    /// `pairs` to `spectrum`: the second axis transformed. With a `sign`, then multiplied with the kernel's spectrum,
    /// its imaginary part taken with that sign, and transformed back along the second axis.
    fn transform_columns(&mut self, sign: Option<f64>) {
        let Convolution { rows, columns, along_columns, pairs, spectrum, kernel, .. } = self;
        let (columns, frequencies) = (*columns, *rows / 2 + 1);
        let (half, size) = (columns / 2, columns * BLOCK);
        let pairs = &*pairs;
        let kernel = &*kernel;
        spectrum.par_chunks_mut(2 * size).enumerate().for_each_init(Room::default, |room, (b, block)| {
            let first = b * BLOCK;
            let width = BLOCK.min(frequencies - first);
            let (re, im) = block.split_at_mut(size);
            for (pair_block, pairs) in pairs.chunks_exact(frequencies * 4 * BLOCK).enumerate() {
                let column = pair_block * BLOCK;
                let count = BLOCK.min(half - column);
                for k in 0..width {
                    let pair = &pairs[(first + k) * 4 * BLOCK..][..4 * BLOCK];
                    for j in 0..count {
                        let (left, right) = ((column + j) * BLOCK + k, (half + column + j) * BLOCK + k);
                        re[left] = pair[j];
                        im[left] = pair[BLOCK + j];
                        re[right] = pair[2 * BLOCK + j];
                        im[right] = pair[3 * BLOCK + j];
                    }
                }
            }
            along_columns.run(re, im, &mut room.scratch);
            if let Some(sign) = sign {
                let (kernel_re, kernel_im) = kernel[b * 2 * size..(b + 1) * 2 * size].split_at(size);
                for (((re, im), kr), ki) in re.iter_mut().zip(im.iter_mut()).zip(kernel_re).zip(kernel_im) {
                    (*re, *im) = times(*re, *im, [*kr, sign * ki]);
                }
                along_columns.run(im, re, &mut room.scratch);
            }
        });
    }

    /// `spectrum`, back along the second axis already, to the real grid.
    fn transform_rows_back(&mut self, grid: &mut [f64]) {
        let Convolution { rows, columns, along_rows, pairs, spectrum, .. } = self;
        let (rows, columns, frequencies) = (*rows, *columns, *rows / 2 + 1);
        let (half, size) = (columns / 2, columns * BLOCK);
        let spectrum = &*spectrum;
        pairs.par_chunks_mut(frequencies * 4 * BLOCK).enumerate().for_each_init(Room::default, |room, (b, pairs)| {
            let first = b * BLOCK;
            let width = BLOCK.min(half - first);
            room.clear(rows * BLOCK);
            for (frequency_block, block) in spectrum.chunks_exact(2 * size).enumerate() {
                let (re, im) = block.split_at(size);
                let start = frequency_block * BLOCK;
                let count = BLOCK.min(frequencies - start);
                for j in 0..width {
                    let left = (first + j) * BLOCK;
                    let right = (half + first + j) * BLOCK;
                    for k in 0..count {
                        let (ar, ai, br, bi) = (re[left + k], im[left + k], re[right + k], im[right + k]);
                        let (here, mirror) = ((start + k) * BLOCK + j, (rows - start - k) % rows * BLOCK + j);
                        // The mirror first: at the two frequencies that are their own mirror the imaginary parts of a
                        // real grid vanish but for rounding, and either writing is right.
                        room.re[mirror] = ar + bi;
                        room.im[mirror] = br - ai;
                        room.re[here] = ar - bi;
                        room.im[here] = ai + br;
                    }
                }
            }
            along_rows.run(&mut room.im, &mut room.re, &mut room.scratch);
            for row in 0..rows {
                pairs[row * 2 * BLOCK..][..BLOCK].copy_from_slice(&room.re[row * BLOCK..][..BLOCK]);
                pairs[(row * 2 + 1) * BLOCK..][..BLOCK].copy_from_slice(&room.im[row * BLOCK..][..BLOCK]);
            }
        });
        let pairs = &*pairs;
        grid.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
            let (left, right) = line.split_at_mut(half);
            let blocks = left.chunks_mut(BLOCK).zip(right.chunks_mut(BLOCK));
            for ((left, right), pairs) in blocks.zip(pairs.chunks_exact(frequencies * 4 * BLOCK)) {
                let both = &pairs[row * 2 * BLOCK..][..2 * BLOCK];
                left.copy_from_slice(&both[..left.len()]);
                right.copy_from_slice(&both[BLOCK..BLOCK + right.len()]);
            }
        });
    }
}

/// The squared magnitudes of a grid's transform, not normalised: row-major, `rows / 2 + 1` frequencies of the first axis
/// (the others are the mirror images of a real grid) by all `columns` of the second. Lengths as for [`Convolution::new`].
pub fn power_spectrum(rows: usize, columns: usize, grid: &[f64]) -> Vec<f64> {
    let transform = Convolution::new(rows, columns, grid);
    // The kernel's spectrum was divided by the number of pixels.
    let scale = (rows * columns) as f64;
    let frequencies = rows / 2 + 1;
    let mut power = vec![0.0; frequencies * columns];
    for (b, block) in transform.kernel.chunks_exact(2 * columns * BLOCK).enumerate() {
        let (re, im) = block.split_at(columns * BLOCK);
        for j in 0..BLOCK.min(frequencies - b * BLOCK) {
            let line = &mut power[(b * BLOCK + j) * columns..][..columns];
            for (column, value) in line.iter_mut().enumerate() {
                let (re, im) = (re[column * BLOCK + j] * scale, im[column * BLOCK + j] * scale);
                *value = re * re + im * im;
            }
        }
    }
    power
}

impl Room {
    fn clear(&mut self, size: usize) {
        for part in [&mut self.re, &mut self.im] {
            part.clear();
            part.resize(size, 0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers without pattern, the same each time.
    fn noise(n: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        (0..n)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
            })
            .collect()
    }

    /// The definition, written as sums.
    fn convolve_by_definition(rows: usize, columns: usize, kernel: &[f64], grid: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; rows * columns];
        for r in 0..rows {
            for c in 0..columns {
                for i in 0..rows {
                    for j in 0..columns {
                        out[(r + i) % rows * columns + (c + j) % columns] +=
                            grid[r * columns + c] * kernel[i * columns + j];
                    }
                }
            }
        }
        out
    }

    #[test]
    fn convolution_is_the_sum_it_is_defined_by() {
        // Lengths that use every radix, odd first axis, one and several blocks.
        for (rows, columns) in [(2, 2), (3, 4), (5, 6), (15, 10), (16, 36), (9, 50), (30, 8), (12, 20)] {
            let (kernel, grid) = (noise(rows * columns, 1), noise(rows * columns, 2));
            let mut found = grid.clone();
            Convolution::new(rows, columns, &kernel).convolve(&mut found);
            let expected = convolve_by_definition(rows, columns, &kernel, &grid);
            for (f, e) in found.iter().zip(&expected) {
                assert!((f - e).abs() < 1e-13 * (rows * columns) as f64, "{rows} x {columns}: {f} {e}");
            }
        }
    }

    #[test]
    fn correlation_is_the_transpose_of_convolution() {
        let (rows, columns) = (45, 72);
        let (kernel, a, b) = (noise(rows * columns, 3), noise(rows * columns, 4), noise(rows * columns, 5));
        let mut convolution = Convolution::new(rows, columns, &kernel);
        let (mut ka, mut kb) = (a.clone(), b.clone());
        convolution.convolve(&mut ka);
        convolution.correlate(&mut kb);
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
        let size = dot(&ka, &ka).sqrt() * dot(&b, &b).sqrt();
        assert!((dot(&ka, &b) - dot(&a, &kb)).abs() < 1e-13 * size);
    }

    #[test]
    fn a_shaped_kernel_filters() {
        // A cosine with 3 periods along the columns, and an even kernel 1/4, 1/2, 1/4 along them: its transfer there is
        // (1 + cos(2 pi 3 / n)) / 2. Shaped into its square root it passes the root of that.
        let (rows, columns) = (6, 20);
        let mut kernel = vec![0.0; rows * columns];
        (kernel[0], kernel[1], kernel[columns - 1]) = (0.5, 0.25, 0.25);
        let turn = 2.0 * std::f64::consts::PI * 3.0 / columns as f64;
        let wave: Vec<f64> = (0..rows * columns).map(|i| libm::cos(turn * (i % columns) as f64)).collect();
        let mut filtered = wave.clone();
        Convolution::shaped(rows, columns, &kernel, |[re, im]| [libm::sqrt(libm::hypot(re, im)), 0.0])
            .convolve(&mut filtered);
        let passed = libm::sqrt((1.0 + libm::cos(turn)) / 2.0);
        for (found, wave) in filtered.iter().zip(&wave) {
            assert!((found - passed * wave).abs() < 1e-14, "{found} {}", passed * wave);
        }
    }

    #[test]
    fn a_long_transform_agrees_with_the_library() {
        // realfft is the oracle: one row pair of a 1-D problem, the kernel a unit impulse moved by one.
        let n = 360;
        let signal = noise(n, 6);
        let plan = Plan::new(n);
        let (mut re, mut im) = (vec![0.0; n * BLOCK], vec![0.0; n * BLOCK]);
        for (i, value) in signal.iter().enumerate() {
            re[i * BLOCK + 3] = *value;
        }
        plan.run(&mut re, &mut im, &mut Default::default());
        let mut input = signal;
        let transform = realfft::RealFftPlanner::<f64>::new().plan_fft_forward(n);
        let mut output = transform.make_output_vec();
        transform.process(&mut input, &mut output).expect("lengths agree");
        for (k, value) in output.iter().enumerate() {
            assert!((re[k * BLOCK + 3] - value.re).abs() < 1e-12 && (im[k * BLOCK + 3] - value.im).abs() < 1e-12);
        }
    }

    #[test]
    fn the_power_spectrum_is_the_sum_it_is_defined_by() {
        for (rows, columns) in [(2, 2), (5, 6), (15, 10), (36, 18), (40, 4)] {
            let grid = noise(rows * columns, 9);
            let found = power_spectrum(rows, columns, &grid);
            assert_eq!(found.len(), (rows / 2 + 1) * columns);
            for (i, found) in found.iter().enumerate() {
                let (k, l) = (i / columns, i % columns);
                let (mut re, mut im) = (0.0, 0.0);
                for (j, value) in grid.iter().enumerate() {
                    let turn = (k * (j / columns)) as f64 / rows as f64 + (l * (j % columns)) as f64 / columns as f64;
                    let (sine, cosine) = libm::sincos(-2.0 * std::f64::consts::PI * turn);
                    (re, im) = (re + value * cosine, im + value * sine);
                }
                let expected = re * re + im * im;
                assert!(
                    (found - expected).abs() < 1e-11 * (rows * columns) as f64,
                    "{rows} x {columns}, {i}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let (rows, columns) = (100, 120);
        let (kernel, grid) = (noise(rows * columns, 7), noise(rows * columns, 8));
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| {
                let mut out = grid.clone();
                Convolution::new(rows, columns, &kernel).convolve(&mut out);
                out
            })
        };
        let one = with(1);
        assert!(one == with(2) && one == with(8));
    }

    #[test]
    fn good_lengths_hold_small_primes_only() {
        assert_eq!(good_length(7, false), 8);
        // 362 .. 374 all hold a prime above 5, 375 = 3 * 5 * 5 * 5 is odd, 376 .. 383 hold one too; 384 = 2^7 * 3.
        assert_eq!(good_length(361, false), 375);
        assert_eq!(good_length(361, true), 384);
    }
}
