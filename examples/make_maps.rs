//! Makes the data of the examples: `cargo run --release --example make_maps`.
//!
//! The maps are invented, smooth where a polished optic is smooth, and the same on every machine: a sum of low orders,
//! a ripple of the earlier polishing, and a few bumps.
#![allow(clippy::disallowed_methods, reason = "this program writes files, once, by hand")]

use polishc::height_map::metropro::{self, Settings};

fn main() {
    for (path, bytes) in maps() {
        std::fs::write(path, bytes).expect("a writable examples folder");
    }
}

/// Every data file of the examples, by its path. A test compares them with those in the tree.
pub fn maps() -> Vec<(&'static str, Vec<u8>)> {
    vec![("examples/first/first.dat", first()), ("examples/flat_340/flat_340.dat", flat_340())]
}

/// A 100 mm flat on a 228 x 228 grid of 0.45 mm, centred, MetroPro format 3: the inner part of the same error.
fn first() -> Vec<u8> {
    disc(228, 0.45e-3, 0.0..=0.0495)
}

/// A 340/60 mm flat on a 494 x 494 grid of 0.7 mm, centred, MetroPro format 3, invalid outside the glass.
fn flat_340() -> Vec<u8> {
    disc(494, 0.7e-3, 0.0305..=0.1695)
}

/// The error of the flats on `size` x `size` pixels, known where the radius lies in `glass`; metres.
fn disc(size: usize, pixel: f64, glass: std::ops::RangeInclusive<f64>) -> Vec<u8> {
    let mut height = vec![f64::NAN; size * size];
    for row in 0..size {
        for column in 0..size {
            // The picture is seen from the tool side with +y up: row 0 is at the top.
            let x = (column as f64 - (size - 1) as f64 / 2.0) * pixel;
            let y = ((size - 1) as f64 / 2.0 - row as f64) * pixel;
            if glass.contains(&libm::hypot(x, y)) {
                height[row * size + column] = flat_error(x, y);
            }
        }
    }
    metropro::write(size, &height, &Settings::fizeau(pixel)).expect("heights that fit the format")
}

/// Height error in metres at a place of the part.
fn flat_error(x: f64, y: f64) -> f64 {
    let (u, v) = (x / 0.17, y / 0.17);
    let r2 = u * u + v * v;
    let astigmatism = 32e-9 * (u * u - v * v);
    let coma = 18e-9 * (3.0 * r2 - 2.0) * v;
    let zone = 14e-9 * libm::cos(2.0 * std::f64::consts::PI * libm::sqrt(r2) * 2.2);
    let ripple = 4e-9 * libm::sin(2.0 * std::f64::consts::PI * (x * 0.8 + y * 0.6) / 0.045);
    let bump = |cx: f64, cy: f64, width: f64, height: f64| {
        let d2 = (x - cx) * (x - cx) + (y - cy) * (y - cy);
        height * libm::exp(-d2 / (2.0 * width * width))
    };
    astigmatism
        + coma
        + zone
        + ripple
        + bump(0.095, 0.040, 0.014, 45e-9)
        + bump(-0.060, 0.085, 0.020, 30e-9)
        + bump(-0.030, -0.120, 0.011, -25e-9)
}
