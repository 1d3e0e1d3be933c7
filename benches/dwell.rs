//! Dwell at the size of the main example (56,703 points over a 340 mm part, one map pixel a millimetre) and larger.
//!
//! References, measured in the same run: `convolution_library` is the transforms of one `operator_pair` by realfft, on one thread,
//! which may use whatever vector instructions the processor has; `memory_traffic` moves as many bytes as the passes of one pair's
//! transforms read and write. Ratios to them say what the fixed order of our own transform costs, and how far a step is from
//! the bounds of arithmetic and of memory.

#![allow(
    clippy::disallowed_methods,
    clippy::print_stderr,
    reason = "the published map is read where it lies, and its absence is said"
)]

use polishc::dwell::bounds::Bounds;
use polishc::dwell::descent::{LinearOperator, descend};
use polishc::dwell::objective::{Base, Objective, Price, Wanted};
use polishc::dwell::removal::{Removal, Samples, Window};
use polishc::dwell::solver::STOP;
use polishc::dwell::{Footprint, SpeedSteps, Task, pareto, predict, solve};
use polishc::height_map::{Grid, npy};
use polishc::job::{
    self, Annulus, Aperture, Circle, Corrective, Empty, FreePiston, Lines, Path, Piston, Plane, Raster, Rectangle,
    TimeObjective,
};
use polishc::path::{self, Setting, ToolPath};
use polishc::tool::{InfluenceField, InfluenceFunction};
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
    influence: InfluenceField,
    dwell: Corrective,
    pitch: f64,
}

fn circle(diameter: f64) -> Aperture {
    Aperture::circle(Circle { diameter: mm(diameter), centre: None })
}

/// A form of 340 mm with astigmatism, coma and a wave of 70 mm, on `n` x `n` pixels of `pixel` metres.
fn form(n: usize, pixel: f64) -> Grid {
    let first = -0.5 * (n as f64 - 1.0) * pixel;
    let mut error = Grid { columns: n, rows: n, pixel: [pixel; 2], origin: [first; 2], values: Vec::new() };
    error.values = (0..n * n)
        .map(|i| {
            let [x, y] = error.position(i / n, i % n).map(|p| p / 0.17);
            let wave = 25.0 * libm::sin(9.0 * x + 4.0 * y * y);
            (60.0 * (x * x - y * y) + 40.0 * (3.0 * x * x + 2.0 * y * y) * x + wave) * 1e-9
        })
        .collect();
    error
}

fn corrective(objective: job::Objective) -> Corrective {
    Corrective {
        objective,
        removal_fraction: 1.0,
        piston: Piston::free(FreePiston { at_most: None }),
        feed: Range { from: Speed(0.2e-3), to: Speed(0.1) },
        acceleration: Acceleration(0.5),
        lateral_acceleration: None,
    }
}

fn lines(over: Aperture, part: &Aperture, step: f64, pitch: f64) -> ToolPath {
    let raster = Raster {
        over,
        point_step: mm(step),
        line_pitch: mm(pitch),
        direction: Angle(0.0),
        lines: Lines::serpentine,
        chord_error: mm(0.01),
        holes: None,
        landing: None,
        passes: None,
    };
    let setting = Setting {
        edge: part,
        clear: part,
        surface: &Plane {},
        most_points: 2_000_000,
        line_points: usize::MAX,
        measured: None,
    };
    path::plan(&Path::raster(raster), &setting).expect("a path")
}

fn lines_of_disc(over: f64, step: f64, pitch: f64) -> ToolPath {
    lines(circle(over), &circle(over - 30.0), step, pitch)
}

fn example() -> Example {
    let ring = |outer: f64, inner: f64| {
        Aperture::annulus(Annulus { outer_diameter: mm(outer), inner_diameter: mm(inner), centre: None })
    };
    Example {
        path: lines_of_disc(380.0, 4.0, 0.5),
        error: form(341, 1e-3),
        clear: ring(323.0, 70.0),
        edge: ring(340.0, 60.0),
        influence: InfluenceFunction::gaussian(30e-9, 4e-3, 16e-3).expect("an influence function").into(),
        dwell: Corrective { removal_fraction: 0.8, ..corrective(job::Objective::rms(Empty {})) },
        pitch: 0.5e-3,
    }
}

/// A part of 190 mm with a million pixels of 0.2 mm and a spot of 25 mm; about `points` points on a raster of 220 mm.
fn large(points: usize) -> Example {
    let step = (std::f64::consts::PI * 110.0 * 110.0 / points as f64).sqrt();
    Example {
        path: lines_of_disc(220.0, step, step),
        error: form(1000, 0.2e-3),
        clear: circle(180.0),
        edge: circle(190.0),
        influence: InfluenceFunction::gaussian(10e-9, 25e-3 / 6.0, 25e-3).expect("an influence function").into(),
        dwell: corrective(job::Objective::rms(Empty {})),
        pitch: step * 1e-3,
    }
}

/// A published strip of 190 mm by 15 mm with a Gaussian of 1 mm (tests/jobs/dwell_a.polish), where its map is at hand: in the
/// folder of samples, POLISHC_SAMPLES or beside the project.
fn published() -> Option<Example> {
    let folder = std::env::var_os("POLISHC_SAMPLES").map_or("../shared/samples".into(), std::path::PathBuf::from);
    let bytes = std::fs::read(folder.join("dwell_a_height_m.npy")).ok()?;
    let map = npy::read(&bytes, "dwell_a_height_m.npy").expect("the published map");
    let pixel = 0.361515e-3;
    let origin = [-294.0 * pixel, -40.0 * pixel];
    let error = Grid { columns: map.columns, rows: map.rows, pixel: [pixel; 2], origin, values: map.values };
    let rectangle = |x: f64, y: f64| Aperture::rectangle(Rectangle { x: mm(x), y: mm(y), centre: None });
    let clear = rectangle(190.16, 15.19);
    let influence = InfluenceFunction::gaussian(10e-9, 1e-3, 10e-3).expect("an influence function");
    Some(Example {
        path: lines(rectangle(200.27931, 25.30605), &clear, 0.361515, 0.361515),
        error,
        edge: clear.clone(),
        clear,
        influence: influence.into(),
        dwell: Corrective {
            feed: Range { from: Speed(1e-5), to: Speed(0.1) },
            acceleration: Acceleration(5.0),
            ..corrective(job::Objective::rms(Empty {}))
        },
        pitch: pixel,
    })
}

fn task(example: &Example) -> Task<'_> {
    Task {
        path: example.path.clone(),
        standing: Vec::new(),
        line_pitch: example.pitch,
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
    let footprint = Footprint::of(&example.influence.parts[0], 0.0);
    bencher.bench_local(|| {
        predict(outcome.timed.clone(), &footprint, &Plane {}, &example.error, &example.clear, &example.dwell)
            .expect("a prediction")
    });
}

/// The whole pass for the least peak to valley.
#[divan::bench(sample_count = 5)]
fn whole_pass_pv(bencher: divan::Bencher) {
    let example = Example { dwell: corrective(job::Objective::pv(Empty {})), ..example() };
    bencher.bench_local(|| solve(task(&example), &mut Vec::new()).expect("a solved run"));
}

/// The whole pass for the least time that leaves 2 nm.
#[divan::bench(sample_count = 5)]
fn whole_pass_time(bencher: divan::Bencher) {
    let dwell = corrective(job::Objective::time(TimeObjective { rms: Length(2e-9) }));
    let example = Example { dwell, ..example() };
    bencher.bench_local(|| solve(task(&example), &mut Vec::new()).expect("a solved run"));
}

/// The table of residual against time.
#[divan::bench(sample_count = 5)]
fn table_of_choices(bencher: divan::Bencher) {
    let example = example();
    bencher.bench_local(|| pareto(&task(&example), &mut Vec::new()).expect("a table"));
}

/// From ten thousand points to a million, on a million pixels: checks, solve and prediction.
#[divan::bench(args = [10_000, 100_000, 1_000_000], sample_count = 3)]
fn whole_pass_on_a_million_pixels(bencher: divan::Bencher, points: usize) {
    let example = large(points);
    bencher.bench_local(|| solve(task(&example), &mut Vec::new()).expect("a solved run"));
}

/// Sixty steps on the grid that the solver works on (a quarter of sigma), and one evaluation on the million pixels.
#[divan::bench(sample_count = 5)]
fn sixty_steps_and_one_fine_evaluation(bencher: divan::Bencher) {
    let example = large(100_000);
    let footprint = Footprint::of(&example.influence.parts[0], 0.0);
    let samples = Samples::segments(&example.path, footprint.sigma / 2.0);
    let fine = Window::of(&example.error);
    let coarse = Window { columns: 200, rows: 200, pixel: [1e-3; 2], origin: fine.origin.map(|o| o + 0.4e-3) };
    let wanted: Vec<f64> = (0..coarse.len())
        .map(|i| {
            let [x, y] = coarse.position(i);
            let place = |v: f64| ((v - fine.origin[0]) / 0.2e-3).round() as usize;
            example.error.at(place(y).min(999), place(x).min(999))
        })
        .collect();
    bencher.bench_local(|| {
        let mut operator = Removal::new(&samples, &footprint, coarse);
        let found = steps(&mut operator, &wanted, &coarse, 60);
        let mut operator = Removal::new(&samples, &footprint, fine);
        let mut depths = vec![0.0; fine.len()];
        operator.forward(&found, &mut depths);
        depths
    });
}

/// A hundred steps on 1024 x 1024 pixels, nothing binned, with an influence of 165 x 165 pixels.
#[divan::bench(sample_count = 3)]
fn a_hundred_steps_on_1024_pixels(bencher: divan::Bencher) {
    let error = form(1024, 0.33e-3);
    let influence = InfluenceFunction::gaussian(10e-9, 9e-3, 164.0 * 0.33e-3).expect("an influence function");
    let footprint = Footprint::of(&influence, 0.0);
    let path = lines_of_disc(330.0, 0.92, 0.92);
    let samples = Samples::segments(&path, footprint.sigma / 2.0);
    let window = Window::of(&error);
    bencher.bench_local(|| steps(&mut Removal::new(&samples, &footprint, window), &error.values, &window, 100));
}

/// So many steps of least squares, none left out.
fn steps(operator: &mut Removal, wanted: &[f64], window: &Window, count: usize) -> Vec<f64> {
    let n = operator.unknowns();
    let (lower, upper, start) = (vec![1e-3; n], vec![1e3; n], vec![0.1; n]);
    let weights: Vec<f64> = (0..window.len())
        .map(|i| {
            let [x, y] = window.position(i);
            if x * x + y * y < 0.09 * 0.09 { 1.0 } else { 0.0 }
        })
        .collect();
    let (base, objective) = (Base::AtMost(f64::INFINITY), Objective::Squares);
    let problem = Wanted { depths: wanted, weights: &weights, base, objective, price: Price::NONE };
    let mut domain = Bounds::new(&lower, &upper, &start);
    let stop = polishc::dwell::descent::Stop { most_iterations: count, relative_decrease: 0.0, value: 0.0, ..STOP };
    let found = descend(operator, &problem, &mut domain, stop);
    assert_eq!(found.iterations, count);
    domain.into_times()
}

/// The published problem: the shortest run that leaves so many picometres, from the checks to the prediction.
#[divan::bench(args = [5.0, 94.0], sample_count = 5)]
fn published_problem(bencher: divan::Bencher, picometres: f64) {
    let Some(example) = published() else { return eprintln!("skipped: no map of the published problem at hand") };
    let dwell = Corrective {
        objective: job::Objective::time(TimeObjective { rms: Length(picometres * 1e-12) }),
        ..example.dwell.clone()
    };
    let example = Example { dwell, ..example };
    // As a job without a robot plans.
    let task = || Task { speed_steps: SpeedSteps::Digits(7), ..task(&example) };
    bencher.bench_local(|| solve(task(), &mut Vec::new()).expect("a solved run"));
}

/// The published problem as it is stated for other solvers: bounded least squares beneath an even layer of 50 nm down to 5 pm,
/// the time not looked at.
#[divan::bench(sample_count = 5)]
fn published_problem_least_squares(bencher: divan::Bencher) {
    let Some(example) = published() else { return eprintln!("skipped: no map of the published problem at hand") };
    let footprint = Footprint::of(&example.influence.parts[0], 0.0);
    let samples = Samples::segments(&example.path, footprint.sigma / 2.0);
    let window =
        Window { columns: 527, rows: 43, pixel: example.error.pixel, origin: [-263.0, -21.0].map(|k| k * 0.361515e-3) };
    let heights: Vec<f64> = (0..window.len()).map(|i| example.error.at(i / 527 + 19, i % 527 + 31)).collect();
    let lowest = heights.iter().fold(f64::INFINITY, |low, h| low.min(*h));
    let wanted: Vec<f64> = heights.iter().map(|height| height - lowest + 50e-9).collect();
    let weights = vec![1.0; window.len()];
    bencher.bench_local(|| {
        rayon::scope(|_| {
            let mut operator = Removal::new(&samples, &footprint, window);
            let n = operator.unknowns();
            let (lower, upper) = (vec![0.361515e-3 / 0.1; n], vec![0.361515e-3 / 1e-5; n]);
            // As long as the depth around each segment asks for, against what a second everywhere removes there.
            let (mut unit, mut local, mut have) = (vec![0.0; window.len()], vec![0.0; n], vec![0.0; n]);
            operator.forward(&vec![1.0; n], &mut unit);
            operator.transpose(&wanted, &mut local);
            operator.transpose(&unit, &mut have);
            let mut stiffness = vec![0.0; n];
            operator.transpose(&weights, &mut stiffness);
            let whole = stiffness.iter().fold(0.0f64, |most, s| most.max(*s));
            stiffness.iter_mut().for_each(|s| *s = (*s / whole).max(1e-3));
            let quotient = |i: usize| if have[i] > 1e-6 * have[n / 2] { local[i] / have[i] } else { 0.0 };
            let start: Vec<f64> = (0..n).map(quotient).collect();
            let base = Base::AtMost(f64::INFINITY);
            let problem =
                Wanted { depths: &wanted, weights: &weights, base, objective: Objective::Squares, price: Price::NONE };
            let stop = polishc::dwell::descent::Stop {
                value: 0.5 * window.len() as f64 * 5e-12 * 5e-12,
                relative_decrease: 0.0,
                ..STOP
            };
            let mut domain = Bounds::new(&lower, &upper, &start).with_stiffness(&stiffness);
            descend(&mut operator, &problem, &mut domain, stop)
        })
    });
}

/// One forward product and one transpose: a step of the solver.
#[divan::bench]
fn operator_pair(bencher: divan::Bencher) {
    let example = example();
    let footprint = Footprint::of(&example.influence.parts[0], 0.0);
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

/// The other reference: two products, each of four passes that read and write a grid of that size.
#[divan::bench]
fn memory_traffic(bencher: divan::Bencher) {
    let (from, mut to) = (vec![1.0f64; 360 * 360], vec![0.0f64; 360 * 360]);
    bencher.bench_local(|| {
        for _pass in 0..8 {
            to.copy_from_slice(divan::black_box(&from));
            divan::black_box(&mut to);
        }
    });
}
