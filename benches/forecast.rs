//! The forecast at the size of the main example: 56,703 points over a 340 mm part, one map pixel a millimetre, all errors stated.
//!
//! `solve` is the reference: what is said beside a solution should cost no more than the solution.

use polishc::dwell::{Footprint, SpeedSteps, Task, solve};
use polishc::forecast::{Run, expect, prospect};
use polishc::height_map::Grid;
use polishc::job::*;
use polishc::path::{self, Setting, ToolPath};
use polishc::tool::{InfluenceField, InfluenceFunction};
use polishc::units::si::*;

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
        passes: None,
        landing: None,
    };
    let ring = |outer: f64, inner: f64| {
        Aperture::annulus(Annulus { outer_diameter: mm(outer), inner_diameter: mm(inner), centre: None })
    };
    let mut error = Grid { columns: 341, rows: 341, pixel: [1e-3; 2], origin: [-0.17; 2], values: Vec::new() };
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
        influence: InfluenceFunction::gaussian(30e-9, 4e-3, 16e-3).expect("an influence function").into(),
        dwell: Corrective {
            objective: Objective::rms(Empty {}),
            removal_fraction: 0.8,
            piston: Piston::free(FreePiston { at_most: None }),
            feed: Range { from: Speed(0.2e-3), to: Speed(0.1) },
            acceleration: Acceleration(0.5),
            lateral_acceleration: None,
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

#[divan::bench]
fn solve_the_run(bencher: divan::Bencher) {
    let example = example();
    bencher.bench_local(|| solve(task(&example), &mut Vec::new()).expect("a solved run"));
}

#[divan::bench]
fn before(bencher: divan::Bencher) {
    let example = example();
    bencher.bench_local(|| prospect(&task(&example), &mut Vec::new()).expect("a prospect"));
}

#[divan::bench]
fn expected(bencher: divan::Bencher) {
    let example = example();
    let outcome = solve(task(&example), &mut Vec::new()).expect("a solved run");
    let footprint = Footprint::over(&example.influence, 0.0);
    let stated = Uncertainty {
        gain: Some(0.03),
        drift: Some(0.02),
        registration: Some(mm(0.2)),
        map_noise: Some(Length(1e-9)),
        position: Some(PositionError { rms: mm(0.1), over: mm(40.0) }),
        feed: Some(FeedError { rms: 0.01, over: mm(10.0) }),
    };
    let run = Run {
        outcome: &outcome,
        footprint: &footprint,
        surface: &Plane {},
        clear: &example.clear,
        dwell: &example.dwell,
    };
    bencher.bench_local(|| expect(&stated, &run).expect("a forecast"));
}
