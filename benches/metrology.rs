//! Maps: cleaning, turning, fitting and the power spectrum of a million pixels, beside reading them once.
//!
//! `cargo bench --bench metrology`. The first row is the yardstick: the sum over all pixels.

use polishc::height_map::{Grid, npy, read};
use polishc::job::{
    Aperture, Circle, Despike, Direction, Empty, HeightMap, MapCentre, Positive, Quantity, Term, View, Workpiece,
    ZernikeOrder,
};
use polishc::job::{Form, FormError, Material, Plane};
use polishc::metrology::{self, psd, slope_rms, zernike_fit};
use polishc::source::MemoryFiles;
use polishc::units::si::{Angle, Length};

const SIZE: usize = 1000;

fn main() {
    divan::main();
}

fn heights() -> Vec<f64> {
    (0..SIZE * SIZE)
        .map(|i| {
            let (x, y) = ((i % SIZE) as f64 - 499.5, (i / SIZE) as f64 - 499.5);
            let noise = ((i as u32).wrapping_mul(2_654_435_761) >> 20) as f64 / 4096.0;
            if x * x + y * y > 499.0 * 499.0 {
                f64::NAN
            } else {
                50.0 * libm::sin(x / 90.0) * libm::cos(y / 60.0) + noise
            }
        })
        .collect()
}

fn grid() -> Grid {
    let values = heights().into_iter().map(|h| h * 1e-9).collect();
    Grid { columns: SIZE, rows: SIZE, pixel: [0.2e-3; 2], origin: [-0.0999; 2], values }
}

fn map() -> HeightMap {
    HeightMap {
        file: "map.npy".into(),
        quantity: Quantity::surface,
        positive: Positive::high,
        view: View::from_tool_side,
        up: Direction::plus_y,
        rotated: None,
        subtract: vec![Term::piston, Term::tilt],
        pixel: Some(Length(0.2e-3)),
        unit: Some(Length(1e-9)),
        centre: MapCentre::frame_centre(Empty {}),
        fiducials: None,
        mask: None,
        leave_out: None,
        trim: None,
        despike: None,
        fill_below: None,
    }
}

fn place(bencher: divan::Bencher, map: HeightMap) {
    let raw = read(&npy::write(SIZE, &heights()).expect("whole rows"), "map.npy").expect("a map");
    let circle = |diameter: f64| Aperture::circle(Circle { diameter: Length(diameter), centre: None });
    let part = Workpiece {
        part: "P".into(),
        x_mark: None,
        form: Form::plane(Plane {}),
        edge: circle(0.2),
        clear: circle(0.18),
        material: Material { name: "fused silica".into() },
        fiducials: None,
        error: FormError::height_map(Box::new(map.clone())),
        target: None,
    };
    let files = MemoryFiles::default();
    bencher.bench_local(|| metrology::place(&raw, &map, &part, &files, &mut Vec::new()).expect("a good map"));
}

#[divan::bench]
fn a_sum(bencher: divan::Bencher) {
    let grid = grid();
    bencher.bench_local(|| grid.values.iter().filter(|v| !v.is_nan()).sum::<f64>());
}

#[divan::bench]
fn placed(bencher: divan::Bencher) {
    place(bencher, map());
}

#[divan::bench]
fn placed_with_a_trim(bencher: divan::Bencher) {
    place(bencher, HeightMap { trim: Some(Length(1e-3)), ..map() });
}

#[divan::bench]
fn placed_despiked(bencher: divan::Bencher) {
    place(bencher, HeightMap { despike: Some(Despike { above: 20.0, reach: 2 }), ..map() });
}

#[divan::bench]
fn placed_turned_by_an_odd_angle(bencher: divan::Bencher) {
    place(bencher, HeightMap { rotated: Some(Angle(0.3)), ..map() });
}

#[divan::bench]
fn fit_of_36_polynomials(bencher: divan::Bencher) {
    let grid = grid();
    let all = vec![true; grid.values.len()];
    bencher.bench_local(|| zernike_fit(&grid, &all, ZernikeOrder::fringe, 36, [0.0; 2], 0.1));
}

#[divan::bench]
fn power_spectrum(bencher: divan::Bencher) {
    let grid = grid();
    let all = vec![true; grid.values.len()];
    bencher.bench_local(|| psd(&grid, &all));
}

#[divan::bench]
fn slopes(bencher: divan::Bencher) {
    let grid = grid();
    let all = vec![true; grid.values.len()];
    bencher.bench_local(|| slope_rms(&grid, &all, 2e-3));
}
