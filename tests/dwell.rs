//! Whole corrective runs: path, solve, rounded speeds, prediction.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

use polishc::diagnostics::Problem;
use polishc::diagnostics::codes::*;
use polishc::dwell::removal::{Samples, Window, deposit};
use polishc::dwell::speed::{Limits, Segments, times};
use polishc::dwell::{
    Footprint, Outcome, SegmentTimes, SpeedSteps, Standing, Task, TimedPath, check_segment_times, pareto, predict,
    solve,
};
use polishc::height_map::Grid;
use polishc::job::*;
use polishc::path::{self, Setting, ToolPath};
use polishc::tool::{InfluenceField, InfluenceFunction};
use polishc::units::si::*;

const SIGMA: f64 = 2e-3;

/// A part of 40 mm with 35.9 mm clear, a spot of 2 mm sigma and 12 mm diameter, a raster of 54 mm.
#[derive(Clone)]
struct Run {
    over: f64,
    step: f64,
    pitch: f64,
    direction: f64,
    lines: Lines,
    error: Grid,
    clear: Aperture,
    edge: Aperture,
    influence: InfluenceField,
    dwell: Corrective,
}

fn circle(diameter: f64) -> Aperture {
    Aperture::circle(Circle { diameter: Length(diameter), centre: None })
}

/// A map of 41 mm about the origin with pixels of `pixel`.
fn map(pixel: f64, height: impl Fn(f64, f64) -> f64) -> Grid {
    let n = (41e-3 / pixel).round() as usize / 2 * 2 + 1;
    let first = -(n as f64 - 1.0) / 2.0 * pixel;
    let mut grid = Grid { columns: n, rows: n, pixel: [pixel; 2], origin: [first; 2], values: Vec::new() };
    for i in 0..n * n {
        let [x, y] = grid.position(i / n, i % n);
        grid.values.push(height(x, y));
    }
    grid
}

fn bump(x: f64, y: f64) -> f64 {
    let square = (x - 6e-3) * (x - 6e-3) + (y + 4e-3) * (y + 4e-3);
    100e-9 * (-square / (2.0 * 5e-3 * 5e-3)).exp()
}

fn run(error: Grid) -> Run {
    Run {
        over: 54e-3,
        step: 1e-3,
        pitch: 1e-3,
        direction: 0.0,
        lines: Lines::serpentine,
        error,
        clear: circle(35.9e-3),
        edge: circle(40e-3),
        influence: InfluenceFunction::gaussian(20e-9, SIGMA, 12e-3).expect("positive numbers").into(),
        dwell: Corrective {
            objective: Objective::rms(Empty {}),
            removal_fraction: 1.0,
            piston: Piston::free(FreePiston { at_most: None }),
            feed: Range { from: Speed(0.05e-3), to: Speed(50e-3) },
            acceleration: Acceleration(0.5),
            lateral_acceleration: None,
        },
    }
}

impl Run {
    fn path(&self) -> ToolPath {
        let raster = Raster {
            over: circle(self.over),
            point_step: Length(self.step),
            line_pitch: Length(self.pitch),
            direction: Angle(self.direction),
            lines: self.lines,
            chord_error: Length(1e-5),
            holes: None,
            landing: None,
            passes: None,
        };
        let setting = Setting {
            edge: &self.edge,
            clear: &self.clear,
            surface: &Plane {},
            most_points: 1_000_000,
            line_points: usize::MAX,
            measured: None,
        };
        path::plan(&Path::raster(raster), &setting).expect("a path")
    }

    fn task(&self) -> Task<'_> {
        Task {
            path: self.path(),
            standing: Vec::new(),
            line_pitch: self.pitch,
            passes: 1,
            error: &self.error,
            clear: &self.clear,
            edge: &self.edge,
            surface: &Plane {},
            influence: &self.influence,
            azimuth: 0.0,
            standoff: 0.0,
            dwell: &self.dwell,
            speed_steps: SpeedSteps::Fixed(1e-6),
        }
    }

    fn solve(&self) -> (Result<Outcome, Problem>, Vec<Problem>) {
        let mut warnings = Vec::new();
        (solve(self.task(), &mut warnings), warnings)
    }

    fn limits(&self) -> Limits {
        Limits::of(&self.dwell)
    }

    #[track_caller]
    fn good(&self) -> Outcome {
        self.solve().0.expect("a solved run")
    }

    #[track_caller]
    fn refused(&self) -> Problem {
        self.solve().0.expect_err("a refusal")
    }

    #[track_caller]
    fn warned(&self) -> Vec<polishc::diagnostics::Code> {
        let (outcome, warnings) = self.solve();
        outcome.expect("a solved run");
        warnings.into_iter().map(|w| w.code).collect()
    }
}

#[test]
fn a_bump_is_taken_off() {
    for direction in [0.0, 0.6, -2.0] {
        let run = Run { direction, ..run(map(0.4e-3, bump)) };
        let outcome = run.good();
        let figures = outcome.figures;
        assert!(figures.rms < 0.02 * figures.before_rms, "{direction}: {figures:?}");
        assert!(figures.pv < 0.1 * figures.before_pv, "{direction}: {figures:?}");
        // The even layer is at least what the path cannot help removing, and the prediction agrees with the solver.
        assert!(figures.base > 0.9 * figures.floor);
        // The tool is slowest over the bump, the place of which is known: within one pitch and one step.
        let path = &outcome.timed.path;
        let slowest = (0..path.points.len()).min_by(|&a, &b| outcome.timed.speed[a].total_cmp(&outcome.timed.speed[b]));
        let [x, y, _] = path.points.position(slowest.expect("points"));
        assert!((x - 6e-3).hypot(y + 4e-3) < 1.5e-3, "{direction}: slowest at {x} {y}");
    }
}

#[test]
fn removal_fraction_leaves_the_rest() {
    let mut run = run(map(0.4e-3, bump));
    run.dwell.removal_fraction = 0.8;
    let outcome = run.good();
    // A fifth of the error stays, and what the solver could not reach besides.
    let ratio = outcome.figures.rms / outcome.figures.before_rms;
    assert!((ratio - 0.2).abs() < 0.01, "{ratio}");
}

#[test]
fn prediction_agrees_with_the_definition() {
    // From the emitted speeds, by the plain sum over segments and pixels of the true rate. The spot runs out to 4 sigma,
    // where the cut is 3e-4 of the peak: with a step of 1 % there, the definition itself would hang on single pixels.
    let influence = InfluenceFunction::gaussian(20e-9, SIGMA, 16e-3).expect("positive numbers");
    let run = Run { influence: influence.into(), over: 60e-3, ..run(map(0.4e-3, bump)) };
    let mut run = run;
    run.dwell.acceleration = Acceleration(1e4);
    let outcome = run.good();
    let segments = Segments::new(&outcome.timed.path, 0.0);
    let speeds: Vec<f64> = segments.point.iter().map(|&p| outcome.timed.speed[p]).collect();
    let seconds = times(&speeds, &segments, &run.limits());
    let footprint = Footprint::of(&run.influence.parts[0], 0.0);
    let window = Window::of(&run.error);
    let exact = deposit(&Samples::segments(&outcome.timed.path, footprint.sigma / 2.0), &seconds, &footprint, &window);
    let mut inside = 0;
    for (found, exact) in outcome.removal.values.iter().zip(&exact).filter(|(found, _)| found.is_finite()) {
        inside += 1;
        assert!((found - exact).abs() < 1e-5 * outcome.figures.greatest_removal, "{found} {exact}");
    }
    // 35.9 mm circle of 0.4 mm pixels: pi 44.875² = 6326 pixels, boundary and all.
    assert!((inside as f64 - 6326.0).abs() < 40.0, "{inside}");
}

#[test]
fn what_a_standing_tool_removes_is_reckoned_with() {
    // Two seconds on a point over the part: 40 nm at the peak, on an error that asks for 100 nm there. Told to the solver, the
    // segments leave that out; the removal is that of the segments and of the spot, by the definition.
    let error = map(0.4e-3, |x, y| 80e-9 * (-(x * x + y * y) / (2.0 * 8e-3 * 8e-3)).exp());
    let run = run(error);
    let path = run.path();
    let near = |i: &usize| path.points.x[*i].hypot(path.points.y[*i]);
    let point = (0..path.points.len()).min_by(|a, b| near(a).total_cmp(&near(b))).expect("points");
    let standing = vec![Standing { point, seconds: 2.0 }];
    let told = solve(Task { standing: standing.clone(), ..run.task() }, &mut Vec::new()).expect("a solved run");
    let plain = run.good();
    let footprint = Footprint::of(&run.influence.parts[0], 0.0);
    let predict_both = |mut timed: TimedPath| {
        timed.standing = standing.clone();
        predict(timed, &footprint, &Plane {}, &run.error, &run.clear, &run.dwell).expect("a prediction")
    };
    assert_eq!(predict_both(told.timed.clone()).figures.rms, told.figures.rms);
    let untold = predict_both(plain.timed.clone());
    assert!(told.figures.rms < 0.1 * untold.figures.rms, "{} {}", told.figures.rms, untold.figures.rms);
    let (x, y) = (path.points.x[point], path.points.y[point]);
    for (i, (with, without)) in untold.removal.values.iter().zip(&plain.removal.values).enumerate() {
        let [px, py] = run.error.position(i / run.error.columns, i % run.error.columns);
        let spot = 2.0 * run.influence.parts[0].rate(px - x, py - y);
        // The table is within 2e-4 of the peak, beside the rim of the cut, 1.1 % of the peak, which it smears.
        assert!(with.is_nan() || (with - without - spot).abs() < 0.012 * 40e-9, "{with} {without} {spot}");
    }
}

#[test]
fn predicting_again_gives_the_same() {
    let run = run(map(0.4e-3, bump));
    let outcome = run.good();
    let footprint = Footprint::of(&run.influence.parts[0], 0.0);
    let again = predict(outcome.timed.clone(), &footprint, &Plane {}, &run.error, &run.clear, &run.dwell)
        .expect("a prediction");
    let bits = |grid: &Grid| grid.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&again.removal), bits(&outcome.removal));
    assert_eq!(bits(&again.residual), bits(&outcome.residual));
    assert_eq!(again.figures.rms, outcome.figures.rms);
}

#[test]
fn speeds_are_what_the_target_writes_and_the_arm_can_do() {
    let mut run = run(map(0.4e-3, bump));
    run.dwell.acceleration = Acceleration(0.05);
    let outcome = run.good();
    for speed in &outcome.timed.speed {
        let steps = speed / 1e-6;
        assert!((steps - steps.round()).abs() < 1e-6 && *speed >= 0.05e-3 && *speed <= 50e-3, "{speed}");
    }
    for line in &outcome.timed.path.lines {
        let mut before = 0.0;
        for point in line.points.clone().skip(1) {
            let v = outcome.timed.speed[point];
            assert!((v * v - before * before).abs() <= 2.0 * 0.05 * 1e-3 * (1.0 + 1e-9));
            before = v;
        }
    }
}

#[test]
fn slow_arms_cost_residual_but_are_solved_for() {
    // The model's study: a stronger limit touches more points and leaves more; solving again with it recovers part.
    let mut rms = Vec::new();
    for acceleration in [2.0, 0.05, 0.005] {
        let mut run = run(map(0.4e-3, bump));
        run.dwell.acceleration = Acceleration(acceleration);
        rms.push(run.good().figures.rms);
    }
    assert!(rms[0] < rms[2] && rms[1] <= rms[2], "{rms:?}");
}

/// Waves of 9 mm, near what the spot can follow, so that something is left.
fn waves(x: f64, y: f64) -> f64 {
    bump(x, y) + 5e-9 * (x * 700.0).sin() * (y * 700.0).sin()
}

#[test]
fn the_shortest_run_leaves_what_it_may() {
    // Waves of 3 mm, which a spot of 2 mm sigma cannot follow, stay: 2.5 nm RMS.
    let fine = |x: f64, y: f64| bump(x, y) + 5e-9 * (x * 2000.0).sin() * (y * 2000.0).sin();
    let mut run = run(map(0.4e-3, fine));
    let best = run.good().figures;
    let mut times = vec![best.time];
    for factor in [1.5, 3.0, 6.0] {
        let asked = factor * best.rms;
        run.dwell.objective = Objective::time(TimeObjective { rms: Length(asked) });
        let found = run.good().figures;
        // Never more than asked, by the prediction; nor much less.
        assert!(found.rms <= asked && found.rms > 0.9 * asked, "{factor}: {} {asked}", found.rms);
        assert!(found.time < 0.995 * times[times.len() - 1], "{factor}: {} {times:?}", found.time);
        times.push(found.time);
    }
    // What no run leaves is refused, with what one does.
    run.dwell.objective = Objective::time(TimeObjective { rms: Length(0.5 * best.rms) });
    let problem = run.refused();
    assert_eq!(problem.code, E0711);
    let nm: f64 =
        problem.help.as_deref().unwrap_or("").split(' ').find_map(|word| word.parse().ok()).expect("a number");
    assert!(nm * 1e-9 >= best.rms * 0.98 && nm * 1e-9 < 1.1 * best.rms + 2e-12, "{nm} {}", best.rms);
    run.dwell.objective = Objective::time(TimeObjective { rms: Length(nm * 1.02e-9) });
    run.good();
}

#[test]
fn the_table_of_choices_goes_from_the_least_residual_to_the_least_time() {
    let run = run(map(0.4e-3, waves));
    let best = run.good().figures;
    let rows = pareto(&run.task(), &mut Vec::new()).expect("a table");
    assert!(rows.len() >= 4, "{rows:?}");
    assert!(rows[0].rms < 0.02 * best.before_rms, "{rows:?}");
    for pair in rows.windows(2) {
        assert!(pair[1].time < pair[0].time && pair[1].rms > 0.9 * rows[0].rms, "{rows:?}");
    }
    assert!(rows[rows.len() - 1].rms > 2.0 * rows[0].rms, "{rows:?}");
    assert!(rows[rows.len() - 1].time < 0.9 * rows[0].time, "{rows:?}");
}

#[test]
fn symmetric_errors_get_symmetric_runs() {
    // The error is even in y, and the raster has every line's mirror image: so has the removal. (In x the ramps differ.)
    let mut run = run(map(0.4e-3, |x, y| 60e-9 * (-((x - 3e-3) * (x - 3e-3) + 2.0 * y * y) / 1e-4).exp()));
    run.lines = Lines::one_way;
    let outcome = run.good();
    let (grid, greatest) = (&outcome.removal, outcome.figures.greatest_removal);
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let (a, b) = (grid.at(row, column), grid.at(grid.rows - 1 - row, column));
            assert_eq!(a.is_nan(), b.is_nan());
            // Rounding differs between the halves, and the steps of the solver carry it on.
            assert!(a.is_nan() || (a - b).abs() < 1e-4 * greatest, "{a} {b}");
        }
    }
}

#[test]
fn the_even_layer_obeys_the_job() {
    let mut run = run(map(0.4e-3, bump));
    let free = run.good().figures;
    run.dwell.piston = Piston::fixed(FixedPiston { depth: Length(200e-9) });
    let fixed = run.good().figures;
    assert!((fixed.base - 200e-9).abs() < 1e-9, "{}", fixed.base);
    assert!(fixed.time > free.time);
    // Held: the bump is all above zero, and the path's floor of V/(v pitch) is the only layer.
    run.dwell.piston = Piston::held(Empty {});
    let held = run.good().figures;
    assert!(held.base < 1.2 * held.floor, "{} {}", held.base, held.floor);
    // V = 2 pi sigma² peak (1 - exp(-4.5)) = 4.97e-13 m³/s; over 50 mm/s and 1 mm: 9.94 nm.
    assert!((held.floor - 9.94e-9).abs() < 0.01e-9, "{}", held.floor);
}

#[test]
fn a_saddle_needs_the_free_layer() {
    // Half of the wanted removal is negative: with the layer free the saddle goes, held only its upper half can.
    let mut run = run(map(0.4e-3, |x, y| 50e-9 * (x * x - y * y) / (18e-3 * 18e-3)));
    let free = run.good().figures;
    assert!(free.rms < 0.03 * free.before_rms, "{free:?}");
    run.dwell.piston = Piston::held(Empty {});
    let held = run.good().figures;
    assert!(held.rms > 0.2 * held.before_rms && held.rms < 0.8 * held.before_rms, "{held:?}");
    run.dwell.piston = Piston::free(FreePiston { at_most: Some(Length(40e-9)) });
    let bounded = run.good().figures;
    assert!(free.rms < bounded.rms && bounded.rms < held.rms);
}

#[test]
fn finer_maps_give_the_same_run() {
    // The solver bins to a quarter of sigma; the same error on a third of its pixels, which bin to the same.
    let coarse = run(map(0.4e-3, bump)).good().figures;
    let fine = run(map(0.4e-3 / 3.0, bump)).good().figures;
    assert!((fine.time - coarse.time).abs() < 0.01 * coarse.time, "{} {}", fine.time, coarse.time);
    assert!(fine.rms < 0.02 * fine.before_rms, "{fine:?}");
}

#[test]
fn an_off_centre_spot_is_led_the_other_way() {
    // The tool's x axis along `azimuth`; a spot whose mass lies 2 mm along tool +x must be steered 2 mm back from the
    // bump: at azimuth 90 degrees that is 2 mm in -y of the part. The spot is a measured one, read from a file.
    let n = 61;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({n}, {n}), }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    for row in 0..n {
        for column in 0..n {
            // Picture: column to the right, row downwards, 0.3 mm; `up: plus_x` puts tool +x upwards.
            let up = -(row as f64 - 30.0) * 0.3e-3 - 2e-3;
            let right = (column as f64 - 30.0) * 0.3e-3;
            bytes.extend((60e-9 * (-(up * up + right * right) / (2.0 * SIGMA * SIGMA)).exp()).to_le_bytes());
        }
    }
    let files = polishc::source::MemoryFiles([("spot.npy".to_string(), bytes)].into());
    let measured = Measured {
        spots: vec![polishc::job::Spot {
            file: "spot.npy".into(),
            before: None,
            dwell: Time(3.0),
            origin: Origin::frame_centre(Empty {}),
            clock: None,
        }],
        quantity: Quantity::surface,
        positive: Positive::low,
        view: View::from_tool_side,
        up: Direction::plus_x,
        pixel: Some(Length(0.3e-3)),
        unit: Some(Length(1.0)),
        radius: Length(9e-3),
        turns_with: polishc::job::TurnsWith::tool,
        flow_in_map: None,
        taken: polishc::job::Conditions::mrf_conditions(polishc::job::MrfConditions {
            diameter: Length(0.3),
            speed: polishc::units::si::AngularSpeed(6.0),
            rotation: polishc::job::WheelRotation::forward,
            gap: Length(1e-3),
            material: polishc::job::Material { name: "glass".into() },
        }),
        ageing: None,
    };
    let spots = polishc::tool::measured::read(&measured, "tool.influence", &files, &mut Vec::new()).expect("a spot");
    let run = Run { influence: spots.function.into(), over: 64e-3, ..run(map(0.4e-3, bump)) };
    let mut warnings = Vec::new();
    for (azimuth, shift) in [(0.0, [-2e-3, 0.0]), (std::f64::consts::FRAC_PI_2, [0.0, -2e-3])] {
        let timed = solve(Task { azimuth, ..run.task() }, &mut warnings).expect("a solved run").timed;
        let slowest =
            (0..timed.speed.len()).min_by(|&a, &b| timed.speed[a].total_cmp(&timed.speed[b])).expect("points");
        let [x, y, _] = timed.path.points.position(slowest);
        let (dx, dy) = (x - 6e-3 - shift[0], y + 4e-3 - shift[1]);
        assert!(dx.hypot(dy) < 1.5e-3, "azimuth {azimuth}: slowest at {x} {y}");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let run = run(map(0.4e-3, bump));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let outcome = pool.install(|| run.good());
        let bits: Vec<u64> = outcome.timed.speed.iter().chain(&outcome.removal.values).map(|v| v.to_bits()).collect();
        (bits, format!("{:?}", outcome.figures))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(8));
}

#[test]
fn links_start_and_end_at_rest() {
    let outcome = run(map(0.4e-3, bump)).good();
    let (path, speed) = (&outcome.timed.path, &outcome.timed.speed);
    for pair in path.lines.windows(2) {
        let [a, b] = [pair[0].points.end - 1, pair[1].points.start].map(|p| path.points.position(p));
        let length = (a[0] - b[0]).hypot(a[1] - b[1]);
        // Half of the way to speed up, half to slow down: v² <= a * length.
        let v = speed[pair[1].points.start];
        assert!(v > 0.0 && v * v <= 0.5 * length * (1.0 + 1e-9), "{v} {length}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let good = run(map(0.4e-3, bump));
    type Change = fn(&mut Run);
    let cases: &[(polishc::diagnostics::Code, Change)] = &[
        (E0644, |r| r.over = 50e-3),
        (E0700, |r| r.dwell.feed.from = Speed(0.0)),
        (E0700, |r| r.dwell.feed = Range { from: Speed(0.02), to: Speed(0.01) }),
        (E0700, |r| r.dwell.feed = Range { from: Speed(1.2e-6), to: Speed(1.8e-6) }),
        (E0700, |r| r.dwell.feed.to = Speed(f64::INFINITY)),
        (E0700, |r| r.dwell.acceleration = Acceleration(0.0)),
        (E0700, |r| r.dwell.acceleration = Acceleration(f64::NAN)),
        (E0700, |r| r.dwell.lateral_acceleration = Some(Acceleration(-1.0))),
        (E0700, |r| r.dwell.removal_fraction = 0.0),
        (E0700, |r| r.dwell.removal_fraction = 1.1),
        (E0701, |r| r.dwell.acceleration = Acceleration(1e-6)),
        (E0702, |r| r.dwell.piston = Piston::fixed(FixedPiston { depth: Length(5e-9) })),
        (E0702, |r| r.dwell.piston = Piston::free(FreePiston { at_most: Some(Length(5e-9)) })),
        (E0509, |r| r.clear = circle(44e-3)),
        (E0509, |r| r.error.values[41 * 103 + 50] = f64::NAN),
        (E0509, |r| r.error = Grid::default()),
        (E0704, |r| (r.edge, r.clear, r.over) = (circle(12e-3), circle(39e-3), 28e-3)),
        (E0705, |r| {
            r.error.values.iter_mut().for_each(|v| *v = -*v - 1e-9);
            r.dwell.piston = Piston::held(Empty {});
        }),
        (E0706, |r| r.error = map(1.2e-3, bump)),
    ];
    for (i, (code, change)) in cases.iter().enumerate() {
        let mut run = good.clone();
        change(&mut run);
        let problem = run.solve().0.err().unwrap_or_else(|| panic!("case {i} is a refusal"));
        assert_eq!(problem.code, *code, "case {i}: {}", problem.message);
    }
}

#[test]
fn floors_name_the_feed_that_would_do() {
    // The floor is 9.94 nm at 50 mm/s; 5 nm need 99.4 mm/s.
    let mut run = run(map(0.4e-3, bump));
    run.dwell.piston = Piston::fixed(FixedPiston { depth: Length(5e-9) });
    let help = run.refused().help.expect("a mend");
    assert!(help.contains("99.4"), "{help}");
    run.dwell.feed.to = Speed(0.1);
    run.good();
}

#[test]
fn oddities_are_warned_of() {
    let good = run(map(0.4e-3, bump));
    assert_eq!(good.warned(), []);
    assert_eq!(Run { error: map(0.8e-3, bump), ..good.clone() }.warned(), [W0700]);
    assert_eq!(Run { pitch: 3.5e-3, ..good.clone() }.warned(), [W0701]);
    let mut slow = good.clone();
    slow.dwell.feed = Range { from: Speed(5e-3), to: Speed(8e-3) };
    assert_eq!(slow.warned(), [W0702]);
    // A deep ring-shaped valley below the layer that is allowed.
    let mut valley = run(map(0.4e-3, |x, y| -100e-9 * (x * x + y * y) / (18e-3 * 18e-3)));
    valley.dwell.piston = Piston::free(FreePiston { at_most: Some(Length(20e-9)) });
    assert_eq!(valley.refused().code, E0708);
    // An even part, and a layer fixed so deep on lines so far apart that their ripple is all that happens.
    let mut ripple = run(map(0.4e-3, |x, _| 0.1e-9 * (x * 2000.0).sin()));
    (ripple.pitch, ripple.over) = (4.5e-3, 64e-3);
    ripple.dwell.piston = Piston::fixed(FixedPiston { depth: Length(300e-9) });
    assert!(ripple.warned().contains(&W0704));
}

#[test]
fn quick_moves_are_the_controllers_business() {
    let controller = |least: f64, usual: f64| SegmentTimes { controller: "irc5".into(), least, usual };
    // Full feed is 50 mm/s over 1 mm: 20 ms.
    let run = run(map(0.4e-3, bump));
    let timed = run.good().timed;
    let check = |controller: SegmentTimes| {
        let mut warnings = Vec::new();
        let result = check_segment_times(&timed, 0.0, &run.dwell, &controller, &mut warnings);
        (result.err().map(|p| p.code), warnings.iter().map(|w| w.code).collect::<Vec<_>>())
    };
    assert_eq!(check(controller(10e-3, 19e-3)), (None, vec![]));
    assert_eq!(check(controller(10e-3, 30e-3)), (None, vec![W0705]));
    assert_eq!(check(controller(25e-3, 30e-3)), (Some(E0707), vec![]));
}
