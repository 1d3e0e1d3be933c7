//! From the picture to the part: orientation, sign, scale, centre, low orders, holes.

use crate::workpiece::{annulus, circle, map, mm, part, rectangle};
use polishc::diagnostics::Problem;
use polishc::height_map::{Format, Grid, RawMap, metropro, npy, read};
use polishc::job::{Direction, Empty, HeightMap, MapCentre, PixelAt, Positive, Quantity, Term, View, Workpiece};
use polishc::metrology::{self, ErrorMap};
use polishc::source::MemoryFiles;
use polishc::units::si::{Area, Length};
use std::collections::BTreeMap;

/// A picture 40 wide and 30 high, 0.5 mm a pixel, as MetroPro writes it.
const COLUMNS: usize = 40;
const ROWS: usize = 30;

fn picture(height_nm: impl Fn(usize, usize) -> f64) -> RawMap {
    let heights: Vec<f64> = (0..COLUMNS * ROWS).map(|i| height_nm(i / COLUMNS, i % COLUMNS) * 1e-9).collect();
    let bytes = metropro::write(COLUMNS, &heights, &metropro::Settings::fizeau(0.5e-3)).unwrap();
    read(&bytes, "map.dat").unwrap()
}

fn place(raw: &RawMap, map: &HeightMap, part: &Workpiece) -> (Result<ErrorMap, Problem>, Vec<String>) {
    let mut warnings = Vec::new();
    let result = metrology::place(raw, map, part, &MemoryFiles::default(), &mut warnings);
    (
        result,
        warnings.into_iter().map(|w| format!("{} {} {}", w.code, w.field.unwrap_or_default(), w.message)).collect(),
    )
}

/// Place in mm and height in nm of the pixel that stands out most.
fn bump(grid: &Grid) -> (f64, f64, f64) {
    let known = (0..grid.values.len()).filter(|i| !grid.values[*i].is_nan());
    let i = known.max_by(|a, b| grid.values[*a].abs().total_cmp(&grid.values[*b].abs())).unwrap();
    let [x, y] = grid.position(i / grid.columns, i % grid.columns);
    (x * 1e3, y * 1e3, grid.values[i] * 1e9)
}

fn near(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance
}

/// The header keeps the pitch in single precision: 0.5 mm is right to 3e-8 of itself.
const MM: f64 = 1e-6;
/// One count of the writer is 0.01 nm.
const NM: f64 = 0.005_1;

#[test]
fn a_bump_lands_where_it_stands_in_all_orientations_and_signs() {
    // The bump stands in column 31, row 6. The middle of 40 x 30 pixels is column 19.5, row 14.5. So it stands 11.5
    // pixels = 5.75 mm to the right of the middle, and 8.5 pixels = 4.25 mm above it.
    //
    // Seen from the tool side, the part's z points at the eye: x, y turn counterclockwise.
    //   +y up: right is +x.                      ( 5.75,  4.25)
    //   -y up: half a turn.                      (-5.75, -4.25)
    //   +x up: +y is a quarter turn counterclockwise from it, to the left; right is -y.  ( 4.25, -5.75)
    //   -x up: right is +y.                      (-4.25,  5.75)
    // From behind, left and right change places while up stays.
    //   +y up: right is -x.                      (-5.75,  4.25)
    //   -y up: right is +x.                      ( 5.75, -4.25)
    //   +x up: right is +y.                      ( 4.25,  5.75)
    //   -x up: right is -y.                      (-4.25, -5.75)
    let raw = picture(|row, column| if (row, column) == (6, 31) { 100.0 } else { 0.0 });
    let part = part(circle(14.9, None), circle(14.6, None));
    for (view, up, x, y) in [
        (View::from_tool_side, Direction::plus_y, 5.75, 4.25),
        (View::from_tool_side, Direction::minus_y, -5.75, -4.25),
        (View::from_tool_side, Direction::plus_x, 4.25, -5.75),
        (View::from_tool_side, Direction::minus_x, -4.25, 5.75),
        (View::from_back, Direction::plus_y, -5.75, 4.25),
        (View::from_back, Direction::minus_y, 5.75, -4.25),
        (View::from_back, Direction::plus_x, 4.25, 5.75),
        (View::from_back, Direction::minus_x, -4.25, -5.75),
    ] {
        for (positive, height) in [(Positive::high, 100.0), (Positive::low, -100.0)] {
            let (result, warnings) = place(&raw, &HeightMap { view, up, positive, ..map() }, &part);
            let found = bump(&result.unwrap().grid);
            assert!(
                near(found.0, x, MM) && near(found.1, y, MM) && near(found.2, height, NM),
                "{view:?} {up:?} {positive:?}: {found:?}, expected {x} {y} {height}"
            );
            assert!(warnings.is_empty(), "{warnings:?}");
        }
    }
}

#[test]
fn pixels_that_are_not_square_keep_their_shape_when_x_points_up() {
    // 4 columns of 2 mm, 3 rows of 1 mm; the bump in the right upper pixel, 3 mm right of and 1 mm above the middle.
    let mut values = vec![0.0; 12];
    values[3] = 7e-9;
    let raw = RawMap { in_metres: true, pixel: Some([2e-3, 1e-3]), ..RawMap::plain(Format::Npy, 4, 3, values) };
    let small = part(rectangle(20.0, 20.0, None), circle(2.0, None));
    let (upright, _) = place(&raw, &map(), &small);
    let upright = upright.unwrap().grid;
    assert_eq!((upright.columns, upright.rows, upright.pixel), (4, 3, [2e-3, 1e-3]));
    let found = bump(&upright);
    assert!(near(found.0, 3.0, 1e-12) && near(found.1, 1.0, 1e-12));
    // With +x up, right is -y: 1 mm along x, -3 mm along y; the 2 mm sides now lie along y.
    let (turned, _) = place(&raw, &HeightMap { up: Direction::plus_x, ..map() }, &small);
    let turned = turned.unwrap().grid;
    assert_eq!((turned.columns, turned.rows, turned.pixel), (3, 4, [1e-3, 2e-3]));
    let found = bump(&turned);
    assert!(near(found.0, 1.0, 1e-12) && near(found.1, -3.0, 1e-12));
}

#[test]
fn the_centre_is_where_the_job_says() {
    let part = part(circle(30.0, None), circle(4.0, None));
    // Valid are columns 4 to 34 and rows 2 to 20: middle column 19, row 11. The bump stands in column 25, row 8.
    let raw = picture(|row, column| match (row, column) {
        (8, 25) => 50.0,
        (2..=20, 4..=34) => 0.0,
        _ => f64::NAN,
    });
    for (centre, x, y) in [
        // 25 - 19.5 = 5.5 pixels right, 14.5 - 8 = 6.5 up.
        (MapCentre::frame_centre(Empty {}), 2.75, 3.25),
        // 6 right, 3 up.
        (MapCentre::valid_centre(Empty {}), 3.0, 1.5),
        // 25 - 20.25 = 4.75 right, 10 - 8 = 2 up.
        (MapCentre::pixel_at(PixelAt { column: 20.25, row: 10.0 }), 2.375, 1.0),
    ] {
        let (result, _) = place(&raw, &HeightMap { centre: centre.clone(), ..map() }, &part);
        let found = bump(&result.unwrap().grid);
        assert!(near(found.0, x, MM) && near(found.1, y, MM), "{centre:?}: {found:?}");
    }
}

#[test]
fn a_map_beside_the_part_is_doubted() {
    // The valid pixels' middle lies 3.5 rows = 1.75 mm above the middle of the picture; more than three pixels.
    let raw = picture(|row, _| if row <= 22 { 0.0 } else { f64::NAN });
    let small = part(circle(30.0, None), circle(4.0, None));
    let (result, warnings) = place(&raw, &map(), &small);
    assert!(result.is_ok());
    assert_eq!(warnings.len(), 1);
    assert_eq!(
        warnings[0],
        "W0501 workpiece.error.centre the middle of the valid pixels lies at x 0.000 mm, y 1.750 mm, 3.5 pixels from \
         the middle of the part"
    );
    // Two rows less are invalid: 2.5 pixels, within what centring by hand does.
    let raw = picture(|row, _| if row <= 24 { 0.0 } else { f64::NAN });
    assert!(place(&raw, &map(), &small).1.is_empty());
}

#[test]
fn a_wavefront_is_twice_the_surface_and_a_file_that_speaks_against_it_is_doubted() {
    let raw = picture(|row, column| if (row, column) == (14, 20) { 80.0 } else { 0.0 });
    let part = part(circle(14.0, None), circle(13.0, None));
    let (result, warnings) = place(&raw, &HeightMap { quantity: Quantity::wavefront, ..map() }, &part);
    assert!(near(bump(&result.unwrap().grid).2, 40.0, NM));
    assert!(warnings.len() == 1 && warnings[0].starts_with("W0502 workpiece.error.quantity"), "{warnings:?}");
    let double = RawMap { quantity: Some(Quantity::wavefront), ..raw.clone() };
    assert!(place(&double, &HeightMap { quantity: Quantity::wavefront, ..map() }, &part).1.is_empty());
    assert!(place(&double, &map(), &part).1[0].starts_with("W0502"));
    let inverted = RawMap { sign_inverted: true, ..raw };
    assert!(place(&inverted, &map(), &part).1[0].starts_with("W0503 workpiece.error.positive"));
}

#[test]
fn there_is_no_glass_beyond_the_edge() {
    let raw = picture(|_, _| 10.0);
    let (result, _) = place(&raw, &map(), &part(annulus(14.0, 4.0, None), annulus(13.0, 5.0, None)));
    let grid = result.unwrap().grid;
    for i in 0..grid.values.len() {
        let [x, y] = grid.position(i / grid.columns, i % grid.columns);
        let r = (x * x + y * y).sqrt() * 1e3;
        assert_eq!(grid.values[i].is_nan(), !(2.0..=7.0).contains(&r), "at radius {r} mm");
    }
}

#[test]
fn subtract_takes_off_what_it_names_and_keeps_the_rest() {
    // 7 nm, 2 nm/mm along x, -3 nm/mm along y: x runs over ±9.75 mm, y over ±7.25 mm.
    let plane = |row: usize, column: usize| {
        let (x, y) = ((column as f64 - 19.5) * 0.5, (14.5 - row as f64) * 0.5);
        7.0 + 2.0 * x - 3.0 * y
    };
    let bowl = |row: usize, column: usize| {
        let (x, y) = ((column as f64 - 19.5) * 0.5, (14.5 - row as f64) * 0.5);
        0.4 * (x * x + y * y)
    };
    let whole = part(rectangle(20.0, 15.0, None), rectangle(19.9, 14.9, None));
    let raw = picture(|row, column| plane(row, column) + bowl(row, column));
    let with = |terms: &[Term]| place(&raw, &HeightMap { subtract: terms.to_vec(), ..map() }, &whole).0.unwrap();
    let corner = (9.75, 7.25);
    // Mean of x² over 40 equally spaced pixels of 0.5 mm is 0.25 (40² - 1)/12, of y² 0.25 (30² - 1)/12.
    let mean_bowl = 0.4 * 0.25 * (1599.0 + 899.0) / 12.0;

    let nothing = with(&[]);
    assert!(near(nothing.before.mean * 1e9, 7.0 + mean_bowl, NM));
    assert_eq!(nothing.before, nothing.after);

    let piston = with(&[Term::piston]);
    assert!(near(piston.after.mean, 0.0, 1e-20) && near(piston.after.pv, nothing.after.pv, 1e-20));
    assert!(near(piston.removed.piston * 1e9, 7.0 + mean_bowl, NM));

    // Without the plane the bowl is left: from the four middle pixels to the corners.
    let tilted = with(&[Term::piston, Term::tilt]);
    let low = 0.4 * (0.25 * 0.25 * 2.0);
    let high = 0.4 * (corner.0 * corner.0 + corner.1 * corner.1);
    assert!(near(tilted.after.pv * 1e9, high - low, 2.0 * NM), "{}", tilted.after.pv * 1e9);
    assert!(near(tilted.removed.tilt[0] * 1e6, 2.0, 1e-4) && near(tilted.removed.tilt[1] * 1e6, -3.0, 1e-4));

    // Tilt alone keeps the mean.
    let tilt_only = with(&[Term::tilt]);
    assert!(near(tilt_only.after.mean, nothing.before.mean, 1e-18) && near(tilt_only.after.pv, tilted.after.pv, 1e-16));
    assert_eq!(tilt_only.removed.piston, 0.0);

    // Power alone keeps mean and plane: what is left is 7 nm + mean of the bowl + the plane's slopes.
    let power = with(&[Term::power]);
    assert!(near(power.removed.power, 0.4e-3, 1e-8));
    assert!(near(power.after.mean, nothing.before.mean, 1e-18));
    let plane_pv = 2.0 * (2.0 * corner.0 + 3.0 * corner.1);
    assert!(near(power.after.pv * 1e9, plane_pv, 4.0 * NM), "{} {plane_pv}", power.after.pv * 1e9);

    // All three leave the rounding of the writer: half a count either way, a count in all, or two after the fit.
    let all = with(&[Term::power, Term::piston, Term::tilt]);
    assert!(all.after.pv * 1e9 < 4.0 * NM, "{}", all.after.pv * 1e9);
    assert!(all.grid.values.iter().all(|v| v.is_finite()));
}

/// The picture in the part frame with +y up, nothing else done to it: row 0 of the grid is the lowest.
fn lay_only(raw: &RawMap) -> Grid {
    let values = (0..COLUMNS * ROWS).map(|i| raw.values[(ROWS - 1 - i / COLUMNS) * COLUMNS + i % COLUMNS]).collect();
    let pixel = raw.pixel.unwrap();
    Grid { columns: COLUMNS, rows: ROWS, pixel, origin: [-19.5 * pixel[0], -14.5 * pixel[1]], values }
}

#[test]
fn low_orders_on_a_lopsided_aperture_are_the_joint_least_squares_fit() {
    // An aperture off the middle, where piston, tilt and power are far from orthogonal, and a rough map. The oracle is
    // nalgebra's singular value decomposition of the whole system.
    let rough = |row: usize, column: usize| {
        let (r, c) = (row as f64, column as f64);
        30.0 * (0.7 * r).sin() + 20.0 * (0.4 * c + 0.1 * r * r).cos() + 0.9 * c - 0.05 * r * c + 0.02 * c * c
    };
    // A wide piece on one side, between the two rims, was not seen: what counts is symmetric about no line, and the filling
    // must not count.
    let raw =
        picture(
            |row, column| {
                if (4..=13).contains(&row) && (15..=18).contains(&column) { f64::NAN } else { rough(row, column) }
            },
        );
    let clear = annulus(9.0, 3.0, crate::workpiece::at(-4.0, 2.5));
    let whole = part(rectangle(20.0, 15.0, None), clear.clone());
    let subtract = vec![Term::piston, Term::tilt, Term::power];
    let asked = HeightMap { subtract, fill_below: Some(Area(20e-6)), ..map() };
    let found = place(&raw, &asked, &whole).0.unwrap();
    assert!(found.filled_pixels > 30);
    let plain = lay_only(&raw);
    let inside: Vec<usize> = (0..plain.values.len())
        .filter(|i| {
            let [x, y] = plain.position(i / plain.columns, i % plain.columns);
            clear.contains(x, y) && !plain.values[*i].is_nan()
        })
        .collect();
    let terms = |i: &usize| {
        let [x, y] = plain.position(i / plain.columns, i % plain.columns).map(|v| v * 1e3);
        [1.0, x, y, x * x + y * y]
    };
    let matrix = nalgebra::DMatrix::from_fn(inside.len(), 4, |k, term| terms(&inside[k])[term]);
    let heights = nalgebra::DVector::from_fn(inside.len(), |k, _| plain.values[inside[k]] * 1e9);
    let solved = matrix.clone().svd(true, true).solve(&heights, 1e-12).unwrap();
    let left = &heights - matrix * &solved;
    for (k, i) in inside.iter().enumerate() {
        assert!(near(found.grid.values[*i] * 1e9, left[k], 1e-9));
    }
    assert!(near(found.removed.power * 1e3, solved[3], 1e-9));
    assert!(near(found.after.rms * 1e9, (left.norm_squared() / inside.len() as f64).sqrt(), 1e-9));
}

#[test]
fn a_hole_is_filled_up_to_the_stated_area_and_refused_above_it() {
    // Rows 10 to 12, columns 24 to 26 are invalid: 9 pixels of 0.25 mm², about column 25, row 11: x 2.75 mm, y 1.75 mm.
    // The surface is a plane, and the smooth filling of a plane is the plane.
    let plane = |row: usize, column: usize| 3.0 * column as f64 + 2.0 * row as f64;
    let raw = picture(|row, column| match (row, column) {
        (10..=12, 24..=26) => f64::NAN,
        _ => plane(row, column),
    });
    let whole = part(rectangle(20.0, 15.0, None), rectangle(19.0, 14.0, None));
    let fill = |area: f64| HeightMap { fill_below: Some(Area(area * 1e-6)), ..map() };

    let (result, warnings) = place(&raw, &fill(2.3), &whole);
    let filled = result.unwrap();
    assert_eq!((filled.filled_holes, filled.filled_pixels), (1, 9));
    assert!(near(filled.filled_area * 1e6, 2.25, 1e-6));
    assert_eq!(
        warnings,
        [
            "W0500 workpiece.error.fill_below 1 hole of the map inside the clear aperture was filled from its rim: 9 pixels, \
          2.250 mm^2 in all"
        ]
    );
    for row in 10..=12 {
        for column in 24..=26 {
            // With +y up, row 0 of the grid is the picture's lowest.
            let found = filled.grid.at(ROWS - 1 - row, column) * 1e9;
            assert!(near(found, plane(row, column), 2.0 * NM), "{found}");
        }
    }
    // Filled pixels do not count in the figures.
    assert_eq!(filled.after.count, 38 * 28 - 9);

    for refused in [fill(2.2), HeightMap { fill_below: None, ..map() }] {
        let problem = place(&raw, &refused, &whole).0.unwrap_err();
        assert_eq!((problem.code.as_str(), problem.field.as_deref()), ("E0510", Some("workpiece.error.fill_below")));
        assert!(
            problem
                .message
                .contains("a hole of 2.250 mm^2 (9 pixels) inside the clear aperture about x 2.750 mm, y 1.750 mm"),
            "{}",
            problem.message
        );
    }
    // Outside the clear aperture nobody needs the pixels.
    let (result, warnings) = place(&raw, &map(), &part(rectangle(20.0, 15.0, None), circle(3.0, None)));
    assert!(result.unwrap().grid.values.iter().filter(|v| v.is_nan()).count() == 9 && warnings.is_empty());
}

#[test]
fn a_filled_hole_is_the_harmonic_function_of_its_rim() {
    // x² - y² is harmonic: of second degree, so the nine-point equations hold exactly on square pixels.
    let saddle = |row: usize, column: usize| {
        let (x, y) = (column as f64 - 20.0, row as f64 - 15.0);
        0.5 * (x * x - y * y)
    };
    let hole = |row: usize, column: usize| (10..20).contains(&row) && (14..27).contains(&column) && row + column != 30;
    let raw = RawMap {
        in_metres: true,
        ..read(
            &npy::write(
                COLUMNS,
                &(0..COLUMNS * ROWS)
                    .map(|i| match (i / COLUMNS, i % COLUMNS) {
                        (row, column) if hole(row, column) => f64::NAN,
                        (row, column) => saddle(row, column) * 1e-9,
                    })
                    .collect::<Vec<_>>(),
            )
            .unwrap(),
            "map.npy",
        )
        .unwrap()
    };
    let asked = HeightMap { pixel: Some(mm(0.5)), fill_below: Some(Area(1e-4)), ..map() };
    let whole = part(rectangle(20.0, 15.0, None), rectangle(19.0, 14.0, None));
    let filled = place(&raw, &asked, &whole).0.unwrap();
    // 10 x 13 pixels without those on the diagonal, rows 10 to 16; corners still connect them.
    assert_eq!((filled.filled_holes, filled.filled_pixels), (1, 123));
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let found = filled.grid.at(ROWS - 1 - row, column) * 1e9;
            assert!(near(found, saddle(row, column), 1e-6), "{row} {column}: {found}");
        }
    }
}

#[test]
fn a_map_smaller_than_the_clear_aperture_is_refused_with_the_place() {
    let raw = picture(|_, _| 0.0);
    // The picture has 20 x 15 mm.
    let problem = place(&raw, &map(), &part(circle(18.0, None), circle(16.0, None))).0.unwrap_err();
    assert_eq!((problem.code.as_str(), problem.field.as_deref()), ("E0509", Some("workpiece.error.file")));
    assert!(
        problem.message.starts_with("the map ends 0.500 mm inside the clear aperture on the -y side"),
        "{}",
        problem.message
    );
    // It covers 15 mm exactly.
    assert!(place(&raw, &map(), &part(circle(18.0, None), circle(15.0, None))).0.is_ok());
    // Moved 10 columns to the right: the picture now ends 10 - 5 - 7.5 mm on the other side.
    let off = HeightMap { centre: MapCentre::pixel_at(PixelAt { column: 9.5, row: 14.5 }), ..map() };
    let problem = place(&raw, &off, &part(circle(18.0, None), circle(15.0, None))).0.unwrap_err();
    assert!(
        problem.message.starts_with("the map ends 2.500 mm inside the clear aperture on the -x side"),
        "{}",
        problem.message
    );

    // Three pixels at the right border of the picture are unknown, inside a clear aperture as large as the picture: not a
    // hole but an end of the map. Their middles lie 0.25 mm inside, their inner sides 0.5 mm.
    let bitten = picture(|row, column| if column == 39 && (10..=12).contains(&row) { f64::NAN } else { 0.0 });
    let problem =
        place(&bitten, &map(), &part(rectangle(20.0, 15.0, None), rectangle(20.0, 15.0, None))).0.unwrap_err();
    assert_eq!(problem.code.as_str(), "E0509");
    assert!(
        problem.message.contains("end up to 0.500 mm inside the clear aperture, near x 9.750 mm"),
        "{}",
        problem.message
    );
    // Nor is it one that may be filled, small as it is: 0.75 mm².
    let fill = HeightMap { fill_below: Some(Area(5e-6)), ..map() };
    let rim = part(rectangle(20.0, 15.0, None), rectangle(20.0, 15.0, None));
    assert_eq!(place(&bitten, &fill, &rim).0.unwrap_err().code.as_str(), "E0509");
    // Two columns farther in they are a hole, and one column in too: the last column was seen. A clear aperture that ends between the
    // unknown pixels cuts them, and the piece that it holds goes on beyond it.
    let inner =
        picture(|row, column| if (37..39).contains(&column) && (10..=12).contains(&row) { f64::NAN } else { 0.0 });
    assert_eq!(place(&inner, &fill, &rim).0.unwrap().filled_pixels, 6);
    let cut = part(rectangle(20.0, 15.0, None), rectangle(18.0, 15.0, None));
    let problem = place(&inner, &fill, &cut).0.unwrap_err();
    assert_eq!(problem.code.as_str(), "E0509", "{}", problem.message);

    // Seen were only the pixels up to 5 mm from the middle, the clear aperture has 6 mm radius.
    let seen = picture(|row, column| {
        let (x, y) = ((column as f64 - 19.5) * 0.5, (14.5 - row as f64) * 0.5);
        if x * x + y * y <= 25.0 { 0.0 } else { f64::NAN }
    });
    let small_fill = HeightMap { fill_below: Some(Area(5e-6)), ..map() };
    let problem = place(&seen, &small_fill, &part(circle(14.0, None), circle(12.0, None))).0.unwrap_err();
    assert_eq!(problem.code.as_str(), "E0509");
    // Between 5 and 6 mm everything is missing: the deepest missing pixel lies just beyond 5 mm, its cell reaches to 5.
    let depth: f64 = problem.message.split("end up to ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((0.75..=1.25).contains(&depth), "{}", problem.message);
}

#[test]
fn the_job_reads_its_map_through_the_files_it_is_given() {
    let heights = vec![1e-9; COLUMNS * ROWS];
    let bytes = metropro::write(COLUMNS, &heights, &metropro::Settings::fizeau(0.5e-3)).unwrap();
    let files =
        MemoryFiles(BTreeMap::from([("map.dat".to_string(), bytes), ("short.dat".into(), vec![0x88, 0x1B, 3, 0x6F])]));
    let whole = part(circle(14.0, None), circle(13.0, None));
    let map = metrology::error_map(&whole, &files, &mut Vec::new()).unwrap();
    assert!(near(map.after.mean * 1e9, 1.0, NM) && near(map.wavelength.unwrap(), 632.8e-9, 1e-13));
    for (file, code) in [("none.dat", "E0500"), ("short.dat", "E0503")] {
        let asked = HeightMap { file: file.into(), ..crate::workpiece::map() };
        let part = Workpiece { error: polishc::job::FormError::height_map(Box::new(asked)), ..whole.clone() };
        let problem = metrology::error_map(&part, &files, &mut Vec::new()).unwrap_err();
        assert_eq!((problem.code.as_str(), problem.field.as_deref()), (code, Some("workpiece.error.file")));
    }
}

#[test]
fn scale_problems_name_the_field_of_the_job() {
    let raw = read(&npy::write(2, &[1.0, 2.0, 3.0, 4.0]).unwrap(), "map.npy").unwrap();
    let whole = part(circle(2.0, None), circle(1.0, None));
    let problem = place(&raw, &map(), &whole).0.unwrap_err();
    assert_eq!((problem.code.as_str(), problem.field.as_deref()), ("E0506", Some("workpiece.error.pixel")));
    let asked = HeightMap { pixel: Some(mm(1.0)), ..map() };
    let problem = place(&raw, &asked, &whole).0.unwrap_err();
    assert_eq!((problem.code.as_str(), problem.field.as_deref()), ("E0506", Some("workpiece.error.unit")));
    // Only one pixel has its centre in the clear aperture: no plane.
    let asked = HeightMap {
        unit: Some(Length(1e-9)),
        subtract: vec![Term::tilt],
        centre: MapCentre::pixel_at(PixelAt { column: 0.0, row: 0.0 }),
        ..asked
    };
    let problem = place(&raw, &asked, &part(circle(2.0, None), circle(0.9, None))).0.unwrap_err();
    assert_eq!((problem.code.as_str(), problem.field.as_deref()), ("E0512", Some("workpiece.error.subtract")));
}

#[test]
fn a_clear_aperture_between_the_pixels_has_no_map() {
    // The middle of the picture lies between four pixels, 0.35 mm from each.
    let problem = place(&picture(|_, _| 0.0), &map(), &part(circle(14.0, None), circle(0.6, None))).0.unwrap_err();
    assert_eq!((problem.code.as_str(), problem.field.as_deref()), ("E0509", Some("workpiece.error.file")));
}

#[test]
fn a_grid_is_read_between_its_pixels() {
    // Values 10 c + 100 r on 3 x 2 pixels of 2 mm x 1 mm from (1 mm, 5 mm): bilinear is exact for it.
    let grid = Grid {
        columns: 3,
        rows: 2,
        pixel: [2e-3, 1e-3],
        origin: [1e-3, 5e-3],
        values: vec![0.0, 10.0, 20.0, 100.0, 110.0, 120.0],
    };
    let value = |x: f64, y: f64| grid.interpolate(x * 1e-3, y * 1e-3);
    assert!(near(value(2.0, 5.25).unwrap(), 5.0 + 25.0, 1e-9));
    assert!(near(value(5.0, 6.0).unwrap(), 120.0, 1e-9));
    // Half a pixel beyond the outermost centres the border goes on; farther there is nothing.
    assert!(near(value(5.9, 6.4).unwrap(), 120.0, 1e-9));
    assert_eq!((value(6.1, 6.0), value(1.0, 4.4), value(f64::NAN, 5.0)), (None, None, None));
    // With one corner unknown the others share; with less than half of the weight known there is no value.
    let mut torn = grid.clone();
    torn.values[4] = f64::NAN;
    let value = |x: f64, y: f64| torn.interpolate(x * 1e-3, y * 1e-3);
    assert!(near(value(2.0, 5.5).unwrap(), (0.0 + 10.0 + 100.0) / 3.0, 1e-9));
    assert_eq!(value(2.9, 5.9), None);

    // Two by two into one: (0 + 10 + 100 + 110)/4 at the middle of the four; the third column has its own mean.
    let binned = grid.binned(2);
    assert_eq!((binned.columns, binned.rows, binned.pixel), (2, 1, [4e-3, 2e-3]));
    assert_eq!(binned.values, [55.0, 70.0]);
    assert!(near(binned.origin[0], 2e-3, 1e-18) && near(binned.origin[1], 5.5e-3, 1e-18));
    assert_eq!(torn.binned(2).values[0], (0.0 + 10.0 + 100.0) / 3.0);
    assert_eq!(grid.binned(1), grid);
}

#[test]
fn a_real_map_with_a_real_hole_lies_on_its_part() {
    // Counted with NumPy: inside a circle of 44 mm about the middle of the picture 108,999 pixels are valid (PV 239.8298,
    // RMS 23.2662 nm), and one hole of 363 pixels (5.048 mm²) has its middle 9.597 mm left of and 11.080 mm below it.
    let Some(bytes) = crate::samples::sample("zygo_metropro.dat") else { return };
    let raw = read(&bytes, "zygo_metropro.dat").unwrap();
    let fifty = part(circle(51.0, None), circle(44.0, None));
    let fill = |area: f64| HeightMap { fill_below: Some(Area(area * 1e-6)), ..map() };
    let (result, warnings) = place(&raw, &fill(5.1), &fifty);
    let found = result.unwrap();
    assert_eq!((found.before.count, found.filled_holes, found.filled_pixels), (108_999, 1, 363));
    assert!(near(found.before.pv * 1e9, 239.829_8, 1e-4) && near(found.before.rms * 1e9, 23.266_2, 1e-4));
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let needed = |i: usize| {
        let [x, y] = found.grid.position(i / found.grid.columns, i % found.grid.columns);
        x * x + y * y <= 22e-3 * 22e-3
    };
    assert!((0..found.grid.values.len()).all(|i| !needed(i) || found.grid.values[i].is_finite()));
    let problem = place(&raw, &fill(5.0), &fifty).0.unwrap_err();
    assert_eq!(problem.code.as_str(), "E0510");
    assert!(
        problem.message.contains("5.048 mm^2 (363 pixels)")
            && problem.message.contains("about x -9.597 mm, y -11.080 mm"),
        "{}",
        problem.message
    );
}
