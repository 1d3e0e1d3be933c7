//! The cycle study: full spirals against region-adaptive paths over a whole campaign, with a machine that errs.
//!
//! `cargo run --release --example cycle_study` prints a row for every campaign and a table of all (`!` where the plan warned
//! that it makes the part worse); `cycle_study 3 C D` runs three seeds of two cases. Paths, dwell and prediction are the crate's
//! own, as a build uses them; the machine between plan and glass is this file's, with the errors that the study of cycles
//! states: a random field fixed in position (correlation 30 mm, new every cycle), a random error along the path (4 %, 10 mm), a
//! gain (3 %), a lag of the feed (0.05 s) and an offset of the path (0.2 mm). The seed and the cycle fix the random numbers.
//! `docs/models/cycles.md` tells what comes out.
#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "an example prints, and may use the platform's mathematics"
)]

use polishc::diagnostics::codes;
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

/// What a campaign is run with.
#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    /// Of the random field, as a share of the removal.
    field: f64,
    /// Of the errors along the path, of the gain and of the offset: 1 as the study states them, 0 for none.
    others: f64,
    /// Peak of the spot, nm/s: sigma 25/6 mm, 25 mm wide.
    peak: f64,
    /// Greatest feeds, mm/s.
    spiral_feed: f64,
    region_feed: f64,
    /// Seconds that the feed lags by.
    lag: f64,
    /// The last cycles are spirals too, at the feed of the regions.
    spirals_only: bool,
}

const fn case(name: &'static str, field: f64, peak: f64, spiral_feed: f64, region_feed: f64) -> Case {
    Case { name, field, others: 1.0, peak, spiral_feed, region_feed, lag: 0.05, spirals_only: false }
}

/// Cases of the study, and three more: `0` is a machine without error, which shows what the plans alone leave; `K4` and `K5` are
/// `C` and `D` whose last cycles are spirals as fast as the regions.
const CASES: &[Case] = &[
    Case { others: 0.0, lag: 0.0, ..case("0", 0.0, 30.0, 18.0, 100.0) },
    case("A", 0.04, 30.0, 100.0, 100.0),
    case("B", 0.04, 30.0, 18.0, 100.0),
    case("C", 0.10, 30.0, 18.0, 100.0),
    case("D", 0.05, 80.0, 18.0, 150.0),
    case("F", 0.10, 30.0, 18.0, 43.0),
    Case { lag: 0.2, ..case("H", 0.10, 30.0, 18.0, 100.0) },
    case("K1", 0.10, 30.0, 100.0, 100.0),
    case("K2", 0.10, 30.0, 18.0, 18.0),
    case("K3", 0.05, 80.0, 150.0, 150.0),
    Case { spirals_only: true, ..case("K4", 0.10, 30.0, 18.0, 100.0) },
    Case { spirals_only: true, ..case("K5", 0.05, 80.0, 18.0, 150.0) },
];

const SPIRAL_CYCLES: u64 = 10;
const REGION_CYCLES: u64 = 4;

/// Until then the first spirals are still at work on the error that the part came with.
const SETTLED: u64 = 4;

/// The study's own seeds are 31, 32 and 33.
const FIRST_SEED: u64 = 31;
const SEEDS: u64 = 10;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let seeds = arguments.iter().find_map(|argument| argument.parse().ok()).filter(|n| *n > 0).unwrap_or(SEEDS);
    let named: Vec<&String> = arguments.iter().filter(|argument| CASES.iter().any(|c| c.name == **argument)).collect();
    let cases = CASES.iter().filter(|case| named.is_empty() || named.iter().any(|name| *name == case.name));
    println!("| case | seed | spirals: PVr | nm | min | last cycles: PVr | nm | min | area |");
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let mut rows = Vec::new();
    for case in cases {
        let all: Vec<Campaign> = (0..if case.others > 0.0 { seeds } else { 1 })
            .map(|k| {
                let seed = FIRST_SEED + k;
                let campaign = Campaign::run(case, seed);
                println!("| {} | {seed} | {}", case.name, campaign.row());
                campaign
            })
            .collect();
        rows.push(format!("| {} | {}", case.name, summary(&all)));
    }
    println!();
    println!(
        "| case | spirals: PVr | nm | min | first of the last: PVr before | after | nm | min | area | at the end: PVr | all min |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    rows.iter().for_each(|row| println!("{row}"));
}

/// One cycle: the figure that it left in waves, the depth that its plan removes on the mean in nm, its minutes, the part of the
/// aperture that it polishes.
#[derive(Clone, Copy)]
struct Cycle {
    pvr: f64,
    depth: f64,
    minutes: f64,
    area: f64,
    /// The plan warned that it makes the part worse (W0704).
    warned: bool,
}

/// Ten spirals, and then the last cycles: regions until nothing stands too high, at most four.
struct Campaign {
    spirals: Vec<Cycle>,
    last: Vec<Cycle>,
    /// Why it went no further.
    refused: Option<String>,
}

impl Campaign {
    fn run(case: &Case, seed: u64) -> Campaign {
        let mut part = Part::new();
        let influence: InfluenceField =
            InfluenceFunction::gaussian(case.peak * 1e-9, 25e-3 / 6.0, 25e-3).expect("a Gaussian").into();
        let landing = json!({"speed": 1.0, "reach": 0.0, "stand": 0.0});
        let spiral = json!({"spiral": {
            "over": {"circle": {"diameter": 0.196, "centre": null}}, "point_step": 2e-3, "line_pitch": 2e-3,
            "start": "outside", "hand": "counterclockwise", "direction": 0.0, "chord_error": 1e-5, "holes": null,
            "landing": landing, "passes": null
        }});
        let mut campaign = Campaign { spirals: Vec::new(), last: Vec::new(), refused: None };
        for cycle in 1..=SPIRAL_CYCLES + REGION_CYCLES {
            let (path, feed, done) = if cycle <= SPIRAL_CYCLES {
                (&spiral, case.spiral_feed, &mut campaign.spirals)
            } else if case.spirals_only {
                (&spiral, case.region_feed, &mut campaign.last)
            } else {
                (&region(), case.region_feed, &mut campaign.last)
            };
            match part.polish(path, &influence, case, feed, seed * 1000 + cycle) {
                Ok(Some(cycle)) => done.push(cycle),
                Ok(None) => break,
                Err(why) => {
                    campaign.refused = Some(why);
                    break;
                }
            }
        }
        campaign
    }

    /// The spirals that go on with what their own errors left.
    fn settled(&self) -> &[Cycle] {
        self.spirals.get(SETTLED as usize - 1..).unwrap_or_default()
    }

    fn row(&self) -> String {
        let list = |format: &dyn Fn(&Cycle) -> String| self.last.iter().map(format).collect::<Vec<_>>().join(" ");
        let pvr = |c: &Cycle| format!("{:.3}{}", c.pvr, if c.warned { "!" } else { "" });
        let pvr = match &self.refused {
            Some(why) => format!("{} refused: {why}", list(&pvr)),
            None if self.last.is_empty() => "none needed".into(),
            None => list(&pvr),
        };
        let spirals = self.settled();
        format!(
            "{} | {:.0} | {:.1} | {pvr} | {} | {} | {} |",
            spread(spirals.iter().map(|c| c.pvr)),
            mean(spirals.iter().map(|c| c.depth)),
            mean(spirals.iter().map(|c| c.minutes)),
            list(&|c| format!("{:.0}", c.depth)),
            list(&|c| format!("{:.2}", c.minutes)),
            list(&|c| format!("{:.2}", c.area)),
        )
    }
}

/// The row of a case: means over its seeds, with the least and the greatest.
fn summary(all: &[Campaign]) -> String {
    let spirals = || all.iter().map(Campaign::settled).filter(|spirals| !spirals.is_empty());
    let of_spirals = |value: fn(&Cycle) -> f64| spirals().map(|spirals| mean(spirals.iter().map(value))).collect();
    let (pvr, depth, minutes): (Vec<f64>, Vec<f64>, Vec<f64>) =
        (of_spirals(|c| c.pvr), of_spirals(|c| c.depth), of_spirals(|c| c.minutes));
    let mut row = format!("{} | {:.0} | {:.1} |", spread(pvr), mean(depth), mean(minutes));
    let with = || all.iter().filter(|campaign| !campaign.last.is_empty());
    if with().next().is_none() {
        row += " none needed | | | | | | |";
    } else {
        row += &format!(
            " ({} of {}) {} | {} | {:.0} | {} | {} | {} | {} |",
            with().count(),
            all.len(),
            spread(with().filter_map(|c| c.spirals.last()).map(|c| c.pvr)),
            spread(with().map(|c| c.last[0].pvr)),
            mean(with().map(|c| c.last[0].depth)),
            spread(with().map(|c| c.last[0].minutes)),
            spread(with().map(|c| c.last[0].area)),
            spread(with().filter_map(|c| c.last.last()).map(|c| c.pvr)),
            spread(with().map(|c| c.last.iter().map(|c| c.minutes).sum())),
        );
    }
    let refused = all.iter().filter(|campaign| campaign.refused.is_some()).count();
    if refused > 0 { row + &format!(" {refused} refused") } else { row }
}

fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.into_iter().collect();
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean, and from the least to the greatest.
fn spread(values: impl IntoIterator<Item = f64>) -> String {
    let values: Vec<f64> = values.into_iter().collect();
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{:.3} [{low:.3}, {high:.3}]", mean(values))
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

    /// In waves, 36 Fringe terms; like every figure of form without piston and tilt, which are how the part stands.
    fn pvr(&self) -> f64 {
        pvr(&self.measured().grid, &self.inside(), ZernikeOrder::fringe).expect("pixels enough").pvr / WAVE
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

    /// One cycle: measured, planned, and done by the machine that errs. `None` where nothing stands too high; else why no plan
    /// can be made.
    fn polish(
        &mut self,
        path: &Value,
        influence: &InfluenceField,
        case: &Case,
        feed: f64,
        seed: u64,
    ) -> Result<Option<Cycle>, String> {
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
        let tool_path = path::plan(&path, &setting).map_err(|problem| problem.message)?;
        if tool_path.points.is_empty() {
            return Ok(None);
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
        let mut warnings = Vec::new();
        let outcome = dwell::solve(task, &mut warnings).map_err(|problem| problem.message)?;
        let warned = warnings.iter().any(|warning| warning.code == codes::W0704);
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
        let figures = outcome.figures;
        Ok(Some(Cycle {
            pvr: self.pvr(),
            depth: figures.mean_removal * 1e9,
            minutes: figures.time / 60.0,
            area,
            warned,
        }))
    }
}

/// What the machine makes of a plan.
fn driven(mut timed: TimedPath, case: &Case, seed: u64) -> TimedPath {
    let normal = Normal(seed);
    let gain = 1.0 + case.others * 0.03 * normal.at(0);
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
            let (mean, now) = lagging(before, programmed, length, case.lag);
            before = now;
            let middle = [(points.x[i] + points.x[i - 1]) / 2.0, (points.y[i] + points.y[i - 1]) / 2.0];
            let rate = gain * (1.0 + case.others * 0.04 * along) * (1.0 + case.field * field.at(middle));
            // A rate that is larger by a part removes as a time does that is longer by it.
            timed.speed[i] = mean / rate.max(0.1);
        }
    }
    for (x, y) in timed.path.points.x.iter_mut().zip(&mut timed.path.points.y) {
        *x += case.others * 0.2e-3 * angle.cos();
        *y += case.others * 0.2e-3 * angle.sin();
    }
    timed
}

/// The feed follows the programmed one with a lag of first order, `v(t) = to + (from - to) exp(-t/lag)`. Its mean over a
/// segment of this length, and what it is at the end.
fn lagging(from: f64, to: f64, length: f64, lag: f64) -> (f64, f64) {
    if lag == 0.0 {
        return (to, to);
    }
    let way = |time: f64| to * time + (from - to) * lag * (1.0 - (-time / lag).exp());
    // The time lies between those at the two speeds; each halving gains a bit of the number's 53.
    let (mut low, mut high) = (length / from.max(to), length / from.min(to));
    for _ in 0..53 {
        let middle = (low + high) / 2.0;
        *(if way(middle) < length { &mut low } else { &mut high }) = middle;
    }
    (length / high, to + (from - to) * (-high / lag).exp())
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
