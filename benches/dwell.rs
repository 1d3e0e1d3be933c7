//! Dwell at the size of the main example: 56,703 points over a 340 mm part, one map pixel a millimetre.
//!
//! `convolution_library` is the reference: the transforms of one `operator_pair` by realfft, on one thread, which may use
//! whatever vector instructions the processor has. Ratios to it say what the fixed order of our own transform costs.

use polishc::dwell::least_squares::LinearOperator;
use polishc::dwell::removal::{Removal, Samples, Window};
use polishc::dwell::{Footprint, SpeedSteps, Task, predict, solve};
use polishc::height_map::Grid;
use polishc::job::{
    Annulus, Aperture, Circle, Corrective, Cross, Crossing, FreePiston, Lines, OnOff, Path, Piston, Plane, Raster,
};
use polishc::path::{self, Setting, ToolPath};
use polishc::tool::InfluenceFunction;
use polishc::units::si::{Acceleration, Angle, Length, Range, Speed};
use realfft::RealFftPlanner;

fn main() {
    divan::main();
}

fn mm(value: f64) -> Length {
    Length(value * 1e-3)
}

struct Example {
    path: ToolPath,
    error: Grid,
    clear: Aperture,
    edge: Aperture,
    influence: InfluenceFunction,
    dwell: Corrective,
}

fn example() -> Example {
    let raster = Raster {
        over: Aperture::circle(Circle { diameter: mm(380.0), centre: None }),
        point_step: mm(4.0),
        line_pitch: mm(0.5),
        direction: Angle(0.0),
        lines: Lines::serpentine,
        chord_error: mm(0.01),
        holes: Some(Crossing::cross(Cross { process: OnOff::on })),
        landing: None,
        passes: None,
    };
    let ring = |outer: f64, inner: f64| {
        Aperture::annulus(Annulus { outer_diameter: mm(outer), inner_diameter: mm(inner), centre: None })
    };
    let mut error =
        Grid { columns: 341, rows: 341, pixel: [1e-3; 2], origin: [-0.17; 2], values: Vec::with_capacity(341 * 341) };
    for i in 0..341 * 341 {
        let [x, y] = error.position(i / 341, i % 341).map(|p| p / 0.17);
        let form =
            60.0 * (x * x - y * y) + 40.0 * (3.0 * x * x + 2.0 * y * y) * x + 25.0 * libm::sin(9.0 * x + 4.0 * y * y);
        error.values.push(form * 1e-9);
    }
    let (clear, edge) = (ring(323.0, 70.0), ring(340.0, 60.0));
    let setting = Setting {
        edge: &edge,
        clear: &clear,
        surface: &Plane {},
        most_points: 100_000,
        line_points: usize::MAX,
        measured: None,
    };
    Example {
        path: path::plan(&Path::raster(raster), &setting).expect("a path"),
        error,
        clear,
        edge,
        influence: InfluenceFunction::gaussian(30e-9, 4e-3, 16e-3).expect("an influence function"),
        dwell: Corrective {
            removal_fraction: 0.8,
            piston: Piston::free(FreePiston { at_most: None }),
            feed: Range { from: Speed(0.2e-3), to: Speed(0.1) },
            acceleration: Acceleration(0.5),
        },
    }
}

fn task(example: &Example) -> Task<'_> {
    Task {
        path: example.path.clone(),
        standing: Vec::new(),
        line_pitch: 0.5e-3,
        passes: 1,
        error: &example.error,
        clear: &example.clear,
        edge: &example.edge,
        surface: &Plane {},
        influence: &example.influence,
        azimuth: 0.0,
        standoff: 0.0,
        dwell: &example.dwell,
        speed_steps: SpeedSteps::Fixed(1e-6),
    }
}

fn window() -> Window {
    Window { columns: 323, rows: 323, pixel: [1e-3; 2], origin: [-0.161; 2] }
}

/// The whole pass: checks, solve, speeds, prediction.
#[divan::bench]
fn whole_pass(bencher: divan::Bencher) {
    let example = example();
    bencher.bench_local(|| solve(task(&example), &mut Vec::new()).expect("a solved run"));
}

#[divan::bench]
fn prediction(bencher: divan::Bencher) {
    let example = example();
    let outcome = solve(task(&example), &mut Vec::new()).expect("a solved run");
    let footprint = Footprint::of(&example.influence, 0.0);
    bencher.bench_local(|| {
        predict(outcome.timed.clone(), &footprint, &Plane {}, &example.error, &example.clear, &example.dwell)
            .expect("a prediction")
    });
}

/// One forward product and one transpose: a step of the solver.
#[divan::bench]
fn operator_pair(bencher: divan::Bencher) {
    let example = example();
    let footprint = Footprint::of(&example.influence, 0.0);
    let samples = Samples::segments(&example.path, footprint.sigma / 2.0);
    let mut operator = Removal::new(&samples, &footprint, window());
    let mut times = vec![0.1; operator.unknowns()];
    let mut depths = vec![0.0; operator.rows()];
    bencher.bench_local(|| {
        operator.forward(&times, &mut depths);
        operator.transpose(&depths, &mut times);
        times.fill(0.1);
    });
}

/// The reference: as many real transforms of that length, there and back, as the pair above needs (the complex columns
/// of a real grid are half as many as its columns, and cost twice as much).
#[divan::bench]
fn convolution_library(bencher: divan::Bencher) {
    let length = 360;
    let mut planner = RealFftPlanner::<f64>::new();
    let (there, back) = (planner.plan_fft_forward(length), planner.plan_fft_inverse(length));
    let mut grid = vec![1.0; length * length];
    let mut spectrum = there.make_output_vec();
    bencher.bench_local(|| {
        for _product in 0..2 {
            for _axis in 0..2 {
                for line in grid.chunks_exact_mut(length) {
                    there.process(line, &mut spectrum).expect("lengths agree");
                    back.process(&mut spectrum, line).expect("lengths agree");
                }
            }
            grid.fill(1.0);
        }
    });
}
