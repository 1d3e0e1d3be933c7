//! Figures of maps: Zernike coefficients, power spectra, slopes.

use polishc::height_map::Grid;
use polishc::job::ZernikeOrder;
use polishc::metrology::{psd, slope_rms, zernike_fit};
use std::f64::consts::PI;

/// A grid with its middle at the origin; `height` of x and y in metres.
pub fn grid(columns: usize, rows: usize, pixel: [f64; 2], height: impl Fn(f64, f64) -> f64) -> Grid {
    let origin = [-(columns as f64 - 1.0) / 2.0 * pixel[0], -(rows as f64 - 1.0) / 2.0 * pixel[1]];
    let mut grid = Grid { columns, rows, pixel, origin, values: Vec::new() };
    for i in 0..columns * rows {
        let [x, y] = grid.position(i / columns, i % columns);
        grid.values.push(height(x, y));
    }
    grid
}

fn disc(grid: &Grid, radius: f64) -> Vec<bool> {
    (0..grid.values.len())
        .map(|i| {
            let [x, y] = grid.position(i / grid.columns, i % grid.columns);
            x * x + y * y <= radius * radius
        })
        .collect()
}

fn close(found: f64, expected: f64, part: f64) -> bool {
    (found - expected).abs() <= part * expected.abs()
}

#[test]
fn zernike_coefficients_on_an_annulus_are_those_of_numpy() {
    // numpy 2.4.6: the sixteen Fringe polynomials as Wyant and Creath print them, r/20 mm, on the 1148 pixels with 6 mm <=
    // r <= 20 mm, numpy.linalg.lstsq.
    let nanometre = 1e-9;
    let map = grid(41, 41, [1e-3; 2], |x, y| {
        let waves = 30.0 * (400.0 * x + 100.0 * y).cos() + 20.0 * (250.0 * y - 0.3).sin();
        nanometre * (waves + 5e6 * x * y + 1e3 * x)
    });
    let counts: Vec<bool> = (0..map.values.len())
        .map(|i| {
            let [x, y] = map.position(i / 41, i % 41).map(|v| (v * 1e3).round());
            (36.0..=400.0).contains(&(x * x + y * y))
        })
        .collect();
    assert_eq!(counts.iter().filter(|c| **c).count(), 1148);
    let expected = [
        1.277442, 20.0, 1.004858, 13.299879, 6.411304, 1006.13352, 0.0, -24.321996, -4.033986, 0.0, 23.842415,
        14.369204, 4.173483, 0.0, 10.513113, -8.568387,
    ];
    let fit = zernike_fit(&map, &counts, ZernikeOrder::fringe, 16, [0.0; 2], 20e-3).unwrap();
    for (k, (found, expected)) in fit.coefficients.iter().zip(expected).enumerate() {
        // Printed to 1e-6 nm, which is also the rounding of ours.
        assert!((found / nanometre - expected).abs() < 1.1e-6, "{k}: {found} {expected}");
    }
    assert!((fit.rms_of_residual / nanometre - 19.838178).abs() < 1e-6, "{}", fit.rms_of_residual);
    // Noll's set spans other polynomials, so a fit of 15 leaves something else, and the same surfaces for 36 to n = 7.
    assert!(zernike_fit(&map, &counts, ZernikeOrder::noll, 15, [0.0; 2], 20e-3).is_some());
    assert!(zernike_fit(&map, &vec![false; 1681], ZernikeOrder::noll, 3, [0.0; 2], 20e-3).is_none());
}

#[test]
fn a_map_made_of_polynomials_gives_its_coefficients_back() {
    // Noll 4 (defocus, sqrt 3 (2 r² - 1)) with 50 nm and Noll 8 (coma along x, sqrt 8 (3 r² - 2) x) with -20 nm, ANSI numbers
    // 4 and 8 of the same polynomials, on a square inside the circle of 30 mm.
    let map = grid(37, 37, [1e-3; 2], |x, y| {
        let (u, v) = (x / 0.03, y / 0.03);
        let square = u * u + v * v;
        50e-9 * 3_f64.sqrt() * (2.0 * square - 1.0) - 20e-9 * 8_f64.sqrt() * (3.0 * square - 2.0) * u
    });
    for (order, defocus, coma) in [(ZernikeOrder::noll, 3, 7), (ZernikeOrder::ansi, 4, 8)] {
        let fit = zernike_fit(&map, &[true; 1369], order, 15, [0.0; 2], 0.03).unwrap();
        for (k, found) in fit.coefficients.iter().enumerate() {
            let expected = if k == defocus {
                50e-9
            } else if k == coma {
                -20e-9
            } else {
                0.0
            };
            assert!((found - expected).abs() <= 1e-15, "{order:?} {k}: {found}");
        }
        assert!(fit.rms_of_residual < 1e-14);
    }
}

#[test]
fn the_density_integrates_to_the_mean_square_whatever_the_window() {
    // Heights of ±3 nm in no order: their mean square is 9 nm² under any weights.
    let mut state = 7_u64;
    let mut sign = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        if state >> 63 == 0 { 3e-9 } else { -3e-9 }
    };
    let mut map = grid(61, 47, [1e-3, 1.3e-3], |_, _| 0.0);
    map.values.iter_mut().for_each(|v| *v = sign());
    let mut counts = disc(&map, 25e-3);
    // A hole, unknown pixels and a corner that does not count.
    counts[1500..1510].fill(false);
    map.values[1700] = f64::NAN;
    let found = psd(&map, &counts).unwrap();
    let expected = 9e-18;
    assert!(close(found.mean_square(), expected, 1e-12), "{}", found.mean_square());
    assert!(close(found.along_x().integral(), expected, 1e-12));
    assert!(close(found.along_y().integral(), expected, 1e-12));
    let split = found.mean_square_between(0.0, 200.0) + found.mean_square_between(200.0, f64::INFINITY);
    assert!(close(split, expected, 1e-12));
    assert!(psd(&map, &vec![false; map.values.len()]).is_none());
}

#[test]
fn profiles_have_the_density_of_scipy() {
    // One row of 60 points; the pixel is so tall that only the ends of the row are near. scipy 1.17.1: periodogram(x, fs=1000,
    // window=w, detrend=False, scaling='density'), w = sin²(pi/2 min(1, d/7.5 mm)), d the distance to the first point
    // outside.
    let mut map = grid(60, 1, [1e-3, 1.0], |_, _| 0.0);
    for (i, value) in map.values.iter_mut().enumerate() {
        let k = i as f64;
        *value = (0.9 * k).cos() + 0.5 * (0.31 * k + 0.2).sin() + 0.01 * (i % 7) as f64;
    }
    let found = psd(&map, &[true; 60]).unwrap().along_x();
    for (k, frequency, expected) in [
        (0, 0.0, 5.87941774099792e-05),
        (1, 1e3 / 60.0, 1.1587777745656908e-05),
        (3, 50.0, 0.007333811059638308),
        (8, 8e3 / 60.0, 0.010483313314964401),
        (9, 150.0, 0.016598982540743656),
        (20, 20e3 / 60.0, 3.0784216539224704e-08),
        (30, 500.0, 1.0298785881338421e-08),
    ] {
        assert!(close(found.frequency[k], frequency, 1e-12) || k == 0);
        // The smallest values are made of cancellation.
        assert!((found.density[k] - expected).abs() < 1e-9 * expected + 1e-15, "{k}: {} {expected}", found.density[k]);
    }
    assert!(close(found.integral(), 0.632404934559777, 1e-12));
}

#[test]
fn a_wave_lies_in_its_band_with_its_root_mean_square() {
    // 4 nm amplitude, 5 mm period, in a slanted direction, over a disc of 100 mm: nearly all of 4 / sqrt 2 nm = 2.828 nm lies in
    // the band from 4 to 6.25 mm. A bowl of 300 nm leaks into it. Figures by numpy 2.4.6 and scipy 1.17.1: fft2 on 216 x 216,
    // window from ndimage.distance_transform_edt, |f| from 160 up to, without, 250 cycles a metre.
    let slanted = |x: f64, y: f64| 4e-9 * (2.0 * PI / 5e-3 * (0.6 * x + 0.8 * y)).sin();
    let map = grid(201, 201, [0.5e-3; 2], slanted);
    let inside = disc(&map, 50e-3);
    let found = psd(&map, &inside).unwrap();
    let rms = found.band_rms(4e-3, 6.25e-3);
    assert!(close(rms, 2.823527637372907e-9, 1e-9), "{rms}");
    let bowl = grid(201, 201, [0.5e-3; 2], |x, y| 300e-9 * ((x * x + y * y) / 0.0025 - 0.5));
    let leaks = psd(&bowl, &inside).unwrap().band_rms(4e-3, 6.25e-3);
    assert!(close(leaks, 0.33969796698589017e-9, 1e-9), "{leaks}");
    // The ring of 200 cycles a metre stands out of the rings beside it.
    let radial = found.radial();
    let peak = radial.density.iter().enumerate().skip(10).max_by(|a, b| a.1.total_cmp(b.1)).unwrap().0;
    assert!((radial.frequency[peak] - 200.0).abs() < 10.0, "{}", radial.frequency[peak]);
}

#[test]
fn slopes_are_central_differences_over_the_length() {
    // h = a sin(2 pi x / p) + tilt: differences over L have the amplitude 2 a sin(pi L / p) / L, over whole periods that /
    // sqrt 2; the tilt is no slope. p = 20 mm, L = 3 mm: 3 pixels, so the ends lie halfway between two, which reading
    // bilinearly multiplies the wave's amplitude with cos(pi dx / p).
    let (a, p, l, dx) = (100e-9, 20e-3, 3e-3, 1e-3);
    let map = grid(124, 30, [dx; 2], |x, y| a * (2.0 * PI * x / p).sin() + 1e-5 * x - 2e-5 * y);
    // 124 columns: 120 have both ends, six periods.
    let found = slope_rms(&map, &vec![true; map.values.len()], l).unwrap();
    let expected = 2.0 * a * (PI * l / p).sin() / l * (PI * dx / p).cos() / 2_f64.sqrt();
    assert!(close(found.axes[0], expected, 1e-9), "{} {expected}", found.axes[0]);
    assert!(found.axes[1] < 1e-15 && close(found.gradient, expected, 1e-9));
    // Two pixels: the ends stand on pixels.
    let map = grid(122, 30, [dx; 2], |x, _| a * (2.0 * PI * x / p).sin());
    let found = slope_rms(&map, &vec![true; map.values.len()], 2.0 * dx).unwrap();
    assert!(close(found.axes[0], 2.0 * a * (PI * 0.1).sin() / 2e-3 / 2_f64.sqrt(), 1e-9));
    // Longer than the map: nothing has a slope.
    assert_eq!(slope_rms(&map, &vec![true; map.values.len()], 31e-3), None);
}

#[test]
fn a_pixel_that_does_not_count_spoils_only_its_own_slopes() {
    let mut map = grid(50, 50, [1e-3; 2], |x, _| 3e-6 * x + 1e-4 * x * x);
    let all = vec![true; 2500];
    let clean = slope_rms(&map, &all, 2e-3).unwrap();
    map.values[25 * 50 + 25] = 1.0;
    let mut counts = all;
    counts[25 * 50 + 25] = false;
    let without = slope_rms(&map, &counts, 2e-3).unwrap();
    assert!(close(without.axes[0], clean.axes[0], 1e-3), "{without:?} {clean:?}");
}

#[test]
fn inspect_tells_zernike_coefficients_of_the_picture() {
    // 30 nm of Fringe 6, r² sin 2θ = 2 x y, +x to the right and +y upwards in the picture, over the circle that 61 x 61 pixels
    // hold: 30 pixels.
    let values: Vec<f64> = (0..61 * 61)
        .map(|i| {
            let (x, y) = ((i % 61) as f64 - 30.0, 30.0 - (i / 61) as f64);
            30.0 * 2.0 * x * y / 900.0
        })
        .collect();
    let bytes = polishc::height_map::npy::write(61, &values).unwrap();
    let told = polishc::metrology::inspect(&bytes, "map.npy", Some(1e-9), Some(1e-3)).unwrap();
    let polishc::metrology::Inspection::HeightMap(facts) = told else { panic!("a height map") };
    let mut expected = vec![0.0; 16];
    expected[5] = 30.0;
    assert_eq!(facts.zernike_fringe_nm.unwrap(), expected);
}
