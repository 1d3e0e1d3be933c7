//! Splines: how a sample is spread over pixels, so that a convolution between pixels is an interpolation.
//!
//! In: a place inside a pixel; values on pixels. Out: weights of the pixels around it; the spline's coefficients.

/// How a sample is spread over the pixels around it: the influence function between pixels is then a spline of that degree
/// through its values on pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spread {
    /// Over four pixels. Between pixels, of width h, a Gaussian comes out up to h²/8sigma² of its peak too low.
    Linear,
    /// Over sixteen. There it is within h⁴/128sigma⁴, 3e-5 of the peak at h = sigma/4.
    Cubic,
}

impl Spread {
    /// Pixels along each axis.
    pub(super) fn width(self) -> usize {
        match self {
            Spread::Linear => 2,
            Spread::Cubic => 4,
        }
    }

    /// Weights of these pixels for a place the part `f` of a pixel past the middle of the second but last half of them.
    pub(super) fn weights(self, f: f64) -> [f64; 4] {
        let g = 1.0 - f;
        match self {
            Spread::Linear => [g, f, 0.0, 0.0],
            Spread::Cubic => {
                let (ff, gg) = (f * f, g * g);
                let (near_f, near_g) = (4.0 - 6.0 * ff + 3.0 * ff * f, 4.0 - 6.0 * gg + 3.0 * gg * g);
                [gg * g / 6.0, near_f / 6.0, near_g / 6.0, ff * f / 6.0]
            }
        }
    }

    /// Turns values on pixels, cyclic along one axis, into the coefficients of the spline through them. The axis has entries
    /// of `width` numbers. (M. Unser, A. Aldroubi, M. Eden, "B-spline signal processing", IEEE Trans. Signal Process. 41, 1993:
    /// the inverse of (1, 4, 1)/6 as one recursion forward and one backward.)
    pub(super) fn coefficients(self, values: &mut [f64], width: usize) {
        if self == Spread::Linear {
            return;
        }
        // The root of z² + 4 z + 1 inside the unit circle. Its 30th power is beneath double precision.
        let pole = 3.0f64.sqrt() - 2.0;
        const REACH: usize = 30;
        let count = values.len() / width;
        let entry = |k: usize| k % count * width;
        let mut carried = vec![0.0; width];
        let mut power = 1.0;
        for k in 0..REACH {
            for (c, v) in carried.iter_mut().zip(&values[entry(count * REACH - 1 - k)..]) {
                *c += power * v;
            }
            power *= pole;
        }
        for entry in values.chunks_exact_mut(width) {
            for (c, v) in carried.iter_mut().zip(entry) {
                *c = *v + pole * *c;
                *v = *c;
            }
        }
        carried.fill(0.0);
        power = -pole;
        for k in 0..REACH {
            for (c, v) in carried.iter_mut().zip(&values[entry(k)..]) {
                *c += power * v;
            }
            power *= pole;
        }
        for entry in values.chunks_exact_mut(width).rev() {
            for (c, v) in carried.iter_mut().zip(entry) {
                *c = pole * (*c - *v);
                *v = 6.0 * *c;
            }
        }
    }
}
