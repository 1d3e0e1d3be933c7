//! The cycle study: full spirals against region-adaptive paths over a whole campaign, with a machine that errs.
//!
//! `cargo run --release --example cycle_study` prints the table of the study. Paths, dwell and prediction are the
//! crate's own, as a build uses them; the machine between plan and glass is this file's, with the errors that the study of
//! cycles states: a random field fixed in position (correlation 30 mm, new every cycle), a random error along the path (4 %,
//! 10 mm), a gain (3 %), a lag of the feed (0.05 s) and an offset of the path (0.2 mm). Random numbers are numbered by a seed.
#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "an example prints, and may use the platform's mathematics"
)]

use polishc::dwell::{self, Footprint, SpeedSteps, Task, TimedPath};
use polishc::height_map::{Grid, npy};
use polishc::job::{Aperture, Circle, Corrective, Path, Plane, ZernikeOrder};
use polishc::metrology::{ErrorMap, Figures, pvr};
use polishc::path::{self, Measured, Setting};
use polishc::tool::{InfluenceField, InfluenceFunction};
use polishc::units::si::{Acceleration, Length};
use serde_json::{Value, json};

const WAVE: f64 = 632.8e-9;

/// Part, and the radius that counts: k = m = 0.9 of 100 mm.
const PART: f64 = 0.2;
const CLEAR: f64 = 0.18;

/// One campaign.
struct Case {
    name: &'static str,
    /// Of the random field, as a share of the removal.
    field: f64,
    /// Peak of the spot, nm/s: sigma 25/6 mm, 25 mm wide.
    peak: f64,
    /// Greatest feeds, mm/s.
    spiral_feed: f64,
    region_feed: f64,
    /// Seconds that the feed lags by.
    lag: f64,
    region_cycles: usize,
    seeds: &'static [u64],
}

const CASES: &[Case] = &[
    Case {
        name: "A",
        field: 0.04,
        peak: 30.0,
        spiral_feed: 100.0,
        region_feed: 100.0,
        lag: 0.05,
        region_cycles: 4,
        seeds: &[31],
    },
    Case {
        name: "B",
        field: 0.04,
        peak: 30.0,
        spiral_feed: 18.0,
        region_feed: 100.0,
        lag: 0.05,
        region_cycles: 4,
        seeds: &[31],
    },
    Case {
        name: "C",
        field: 0.10,
        peak: 30.0,
        spiral_feed: 18.0,
        region_feed: 100.0,
        lag: 0.05,
        region_cycles: 4,
        seeds: &[31, 32, 33],
    },
    Case {
        name: "D",
        field: 0.05,
        peak: 80.0,
        spiral_feed: 18.0,
        region_feed: 150.0,
        lag: 0.05,
        region_cycles: 4,
        seeds: &[31, 32, 33],
    },
    Case {
        name: "F",
        field: 0.10,
        peak: 30.0,
        spiral_feed: 18.0,
        region_feed: 43.0,
        lag: 0.05,
        region_cycles: 4,
        seeds: &[31],
    },
    Case {
        name: "H",
        field: 0.10,
        peak: 30.0,
        spiral_feed: 18.0,
        region_feed: 100.0,
        lag: 0.2,
        region_cycles: 4,
        seeds: &[31],
    },
    Case {
        name: "K1",
        field: 0.10,
        peak: 30.0,
        spiral_feed: 100.0,
        region_feed: 100.0,
        lag: 0.05,
        region_cycles: 4,
        seeds: &[31, 32],
    },
    Case {
        name: "K2",
        field: 0.10,
        peak: 30.0,
        spiral_feed: 18.0,
        region_feed: 18.0,
        lag: 0.05,
        region_cycles: 4,
        seeds: &[31, 32],
    },
    Case {
        name: "K3",
        field: 0.05,
        peak: 80.0,
        spiral_feed: 150.0,
        region_feed: 150.0,
        lag: 0.05,
        region_cycles: 4,
        seeds: &[31, 32],
    },
];

const SPIRAL_CYCLES: usize = 10;

fn main() {
    println!("| case | seed | spiral cycles 4-10: PVr mean [range], min a cycle | region cycles: PVr | min | area |");
    println!("| --- | --- | --- | --- | --- | --- |");
    for case in CASES {
        for seed in case.seeds {
            println!("{}", campaign(case, *seed));
        }
    }
}

/// One row of the table.
fn campaign(case: &Case, seed: u64) -> String {
    let mut part = Part::new();
    let influence: InfluenceField =
        InfluenceFunction::gaussian(case.peak * 1e-9, 25e-3 / 6.0, 25e-3).expect("a Gaussian").into();
    let landing = json!({"speed": 1.0, "reach": 0.0, "stand": 0.0});
    let spiral = json!({"spiral": {
        "over": {"circle": {"diameter": 0.196, "centre": null}}, "point_step": 2e-3, "line_pitch": 2e-3, "start": "outside",
        "hand": "counterclockwise", "direction": 0.0, "chord_error": 1e-5, "holes": null, "landing": landing, "passes": null
    }});
    let mut cycle = 0;
    let (mut spirals, mut minutes) = (Vec::new(), Vec::new());
    for k in 1..=SPIRAL_CYCLES {
        cycle += 1;
        match part.polish(&spiral, &influence, case, case.spiral_feed, seed * 1000 + cycle) {
            Done::Polished { seconds, .. } if k >= 4 => {
                spirals.push(part.pvr());
                minutes.push(seconds / 60.0);
            }
            Done::Polished { .. } => {}
            Done::Nothing => break,
            Done::Refused(why) => return format!("| {} | {seed} | refused: {why} | | | |", case.name),
        }
    }
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
    let low = spirals.iter().copied().fold(f64::INFINITY, f64::min);
    let high = spirals.iter().copied().fold(0.0, f64::max);
    let mut row =
        format!("| {} | {seed} | {:.3} [{low:.3}, {high:.3}], {:.1} |", case.name, mean(&spirals), mean(&minutes));
    let (mut figures, mut times, mut areas) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..case.region_cycles {
        cycle += 1;
        match part.polish(&region(), &influence, case, case.region_feed, seed * 1000 + cycle) {
            Done::Polished { seconds, area } => {
                figures.push(format!("{:.3}", part.pvr()));
                times.push(format!("{:.2}", seconds / 60.0));
                areas.push(format!("{area:.2}"));
            }
            Done::Nothing => break,
            Done::Refused(why) => {
                figures.push(format!("refused: {why}"));
                break;
            }
        }
    }
    if figures.is_empty() {
        figures.push("none needed".into());
    }
    row += &format!(" {} | {} | {} |", figures.join(" "), times.join(" "), areas.join(" "));
    row
}

/// The region-adaptive path of the study: hexagons of 2.5 mm, lambda/40, the lift of the paper.
fn region() -> Value {
    json!({"region_adaptive": {
        "over": {"circle": {"diameter": CLEAR, "centre": null}}, "lift": {"rms3": {}}, "above": WAVE / 40.0,
        "tolerance": WAVE / 40.0, "mesh": {"diagonal": 2.5e-3, "islands": 1, "holes": 1}, "merge": "bridge_or_trim",
        "smoothing": 1.0, "point_step": 2e-3, "turn_limit": std::f64::consts::FRAC_PI_2, "chord_error": 1e-5,
        "landing": {"speed": 1.0, "reach": 0.0, "stand": 0.0}
    }})
}

enum Done {
    /// Minutes of the plan, and the part of the aperture that the path polishes.
    Polished {
        seconds: f64,
        area: f64,
    },
    Nothing,
    Refused(String),
}

/// The glass between the cycles.
struct Part {
    error: Grid,
}

fn circle(diameter: f64) -> Aperture {
    Aperture::circle(Circle { diameter: Length(diameter), centre: None })
}

impl Part {
    /// Map A of the study: 200 x 200 pixels of 1 mm, PV of one wave, in nanometres, rows towards +y.
    fn new() -> Part {
        let bytes = std::fs::read("tests/maps/map_a.npy").expect("the map lies in tests/maps");
        let raw = npy::read(&bytes, "map_a.npy").expect("an array");
        let (columns, rows) = (raw.columns, raw.rows);
        let values: Vec<f64> = raw.values.iter().map(|nm| nm * 1e-9).collect();
        Part { error: Grid { columns, rows, pixel: [1e-3; 2], origin: [-99.5e-3; 2], values } }
    }

    fn inside(&self) -> Vec<bool> {
        let clear = circle(CLEAR);
        let place = |i: usize| self.error.position(i / self.error.columns, i % self.error.columns);
        (0..self.error.values.len()).map(|i| clear.contains(place(i)[0], place(i)[1])).collect()
    }

    /// In waves, 36 Fringe terms.
    fn pvr(&self) -> f64 {
        pvr(&self.error, &self.inside(), ZernikeOrder::fringe).expect("pixels enough").pvr / WAVE
    }

    /// The map as an interferometer shows it: piston and tilt fitted over the clear aperture are taken off.
    fn measured(&self) -> ErrorMap {
        let inside = self.inside();
        let place = |i: usize| self.error.position(i / self.error.columns, i % self.error.columns);
        // Over a centred aperture that is symmetric, piston, x and y are orthogonal.
        let (mut n, mut sum, mut sx, mut sy, mut xx, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        for i in (0..inside.len()).filter(|i| inside[*i]) {
            let ([x, y], h) = (place(i), self.error.values[i]);
            n += 1.0;
            sum += h;
            sx += x * h;
            sy += y * h;
            xx += x * x;
            yy += y * y;
        }
        let mut grid = self.error.clone();
        for i in 0..inside.len() {
            let [x, y] = place(i);
            grid.values[i] -= sum / n + sx / xx * x + sy / yy * y;
        }
        let after = Figures::of((0..inside.len()).filter(|i| inside[*i]).map(|i| grid.values[i]));
        ErrorMap {
            grid,
            before: after,
            after,
            removed: Default::default(),
            filled_holes: 0,
            filled_pixels: 0,
            filled_area: 0.0,
            wavelength: None,
            record: Default::default(),
        }
    }

    /// One cycle: measured, planned, and done by the machine that errs.
    fn polish(&mut self, path: &Value, influence: &InfluenceField, case: &Case, feed: f64, seed: u64) -> Done {
        let map = self.measured();
        let (edge, clear) = (circle(PART), circle(CLEAR));
        let path: Path = serde_json::from_value(path.clone()).expect("a path");
        let setting = Setting {
            edge: &edge,
            clear: &clear,
            surface: &Plane {},
            most_points: path::MOST_POINTS,
            line_points: usize::MAX,
            measured: Some(Measured { error: &map, influence: &influence.parts[0] }),
        };
        let tool_path = match path::plan(&path, &setting) {
            Ok(path) => path,
            Err(problem) => return Done::Refused(problem.message),
        };
        if tool_path.points.is_empty() {
            return Done::Nothing;
        }
        let area = tool_path.region.as_ref().map_or(1.0, |region| region.area_share);
        let rule: Corrective = serde_json::from_value(json!({
            "objective": {"rms": {}}, "removal_fraction": 1.0, "piston": {"free": {"at_most": null}},
            "feed": {"from": 5e-4, "to": feed * 1e-3}, "acceleration": 20.0, "lateral_acceleration": 1e6
        }))
        .expect("a rule");
        let task = Task {
            standing: Vec::new(),
            path: tool_path,
            line_pitch: path.strategy().line_pitch(),
            passes: 1,
            error: &map.grid,
            clear: &clear,
            edge: &edge,
            surface: &Plane {},
            influence,
            azimuth: 0.0,
            standoff: 0.0,
            dwell: &rule,
            speed_steps: SpeedSteps::Fixed(1e-6),
        };
        let outcome = match dwell::solve(task, &mut Vec::new()) {
            Ok(outcome) => outcome,
            Err(problem) => return Done::Refused(problem.message),
        };
        let driven = driven(outcome.timed, case, seed);
        // What really goes, over all of the part that is measured; each move at the speed that the machine had.
        let footprint = Footprint::over(influence, 0.0);
        let instant = Corrective { acceleration: Acceleration(1e9), ..rule };
        let whole = circle(PART - 1e-3);
        let removed = dwell::predict(driven, &footprint, &Plane {}, &map.grid, &whole, &instant).expect("a prediction");
        for (height, depth) in self.error.values.iter_mut().zip(&removed.removal.values) {
            if !depth.is_nan() {
                *height -= depth;
            }
        }
        Done::Polished { seconds: outcome.figures.time, area }
    }
}

/// What the machine makes of a plan.
fn driven(mut timed: TimedPath, case: &Case, seed: u64) -> TimedPath {
    let normal = Normal(seed);
    let gain = 1.0 + 0.03 * normal.at(0);
    let angle = std::f64::consts::TAU * normal.uniform(1);
    let field = Field::new(seed, 30e-3);
    let points = &timed.path.points;
    // Along the path: an autoregressive error with a correlation length of 10 mm.
    let mut along = normal.at(2);
    let mut draw = 100;
    for line in timed.path.lines.iter().filter(|line| line.points.len() > 1) {
        let mut before = timed.speed[line.points.start + 1];
        for i in line.points.start + 1..line.points.end {
            let length = (points.x[i] - points.x[i - 1]).hypot(points.y[i] - points.y[i - 1]);
            let keep = (-length / 10e-3).exp();
            along = keep * along + (1.0 - keep * keep).sqrt() * normal.at(draw);
            draw += 1;
            let programmed = timed.speed[i];
            // The feed follows the programmed one with a lag of first order; over a segment its mean counts.
            let time = length / before.max(1e-6);
            let late = (-time / case.lag).exp();
            let now = programmed + (before - programmed) * late;
            let mean = programmed + (before - programmed) * (1.0 - late) * case.lag / time;
            before = now;
            let middle = [(points.x[i] + points.x[i - 1]) / 2.0, (points.y[i] + points.y[i - 1]) / 2.0];
            let rate = gain * (1.0 + 0.04 * along) * (1.0 + case.field * field.at(middle));
            // A rate that is larger by a part removes as a time does that is longer by it.
            timed.speed[i] = mean / rate.max(0.1);
        }
    }
    for (x, y) in timed.path.points.x.iter_mut().zip(&mut timed.path.points.y) {
        *x += 0.2e-3 * angle.cos();
        *y += 0.2e-3 * angle.sin();
    }
    timed
}

/// Normal deviates by number: SplitMix64 and Box-Muller.
struct Normal(u64);

impl Normal {
    fn uniform(&self, k: u64) -> f64 {
        let mut z = self.0.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(k.wrapping_mul(0xd1b5_4a32_d192_ed03));
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        ((z >> 11) + 1) as f64 / (1u64 << 53) as f64
    }

    fn at(&self, k: u64) -> f64 {
        let (a, b) = (self.uniform(2 * k + 7), self.uniform(2 * k + 8));
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}

/// A random field of unit variance whose correlation falls as a Gaussian of this length: a sum of waves, whose frequencies are
/// drawn from its spectrum.
struct Field {
    waves: Vec<([f64; 2], f64)>,
}

const WAVES: u64 = 200;

impl Field {
    fn new(seed: u64, length: f64) -> Field {
        let normal = Normal(seed ^ 0xf1e1d);
        // exp(-d²/2l²) has the spectrum exp(-k² l²/2): each component of k is normal with the deviation 1/l.
        let wave = |k: u64| {
            let frequency = [normal.at(3 * k) / length, normal.at(3 * k + 1) / length];
            (frequency, std::f64::consts::TAU * normal.uniform(900_000 + k))
        };
        Field { waves: (0..WAVES).map(wave).collect() }
    }

    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let sum: f64 = self.waves.iter().map(|([kx, ky], phase)| (kx * x + ky * y + phase).cos()).sum();
        sum * (2.0 / WAVES as f64).sqrt()
    }
}
