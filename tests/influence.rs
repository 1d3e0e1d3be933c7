//! Tools with an influence function of their own, from the job to the removal that is predicted: compared with a sum over the
//! driven path that knows nothing of the library but the speeds.
#![allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]

mod common;

use common::TestFiles;
use polishc::diagnostics::render::{self, Style};
use polishc::height_map::npy;
use polishc::session::{self, Planned, Request, Until, Unwatched};
use std::f64::consts::{PI, TAU};

/// Pixels of the map, 0.4 mm each.
const SIZE: usize = 161;

/// A map of two bumps and a slow wave, nanometres.
fn map() -> Vec<u8> {
    let values: Vec<f64> = (0..SIZE * SIZE)
        .map(|i| {
            let x = ((i % SIZE) as f64 - 80.0) * 0.4;
            let y = (80.0 - (i / SIZE) as f64) * 0.4;
            let bump = |cx: f64, cy: f64, w: f64| (-((x - cx).powi(2) + (y - cy).powi(2)) / (2.0 * w * w)).exp();
            60.0 * bump(8.0, 5.0, 8.0) + 40.0 * bump(-10.0, -6.0, 10.0) + 15.0 * (x / 9.0).sin()
        })
        .collect();
    npy::write(SIZE, &values).expect("whole rows")
}

/// The job of `tests/jobs`, planned as far as dwell; `edit` changes its text.
fn planned(name: &str, edit: impl Fn(String) -> String) -> Planned {
    let path = format!("tests/jobs/{name}.polish");
    let text = edit(std::fs::read_to_string(&path).expect("the job"));
    let mut files = TestFiles::default();
    files.extra.insert(path.clone(), text.into_bytes());
    files.extra.insert("tests/jobs/map.npy".into(), map());
    let request =
        Request { sets: vec![("map".into(), "tests/jobs/map.npy".into())], until: Until::Dwell, ..Request::new(&path) };
    let mut done = session::compile(&files, &request, &Unwatched);
    let said = render::render(&done.sources, &done.diagnostics, Style::Short, false);
    assert!(!done.failed(), "{said}");
    done.jobs.remove(0)
}

/// Depth in metres at `(x, y)`: every segment of the path in steps of a fifth of a millimetre, each for its length over the
/// programmed speed, times `rate(dx, dy)` in m/s. At 5000 mm/s² a change of speed takes a hundredth of a segment.
fn removed(planned: &Planned, [x, y]: [f64; 2], rate: impl Fn(f64, f64) -> f64) -> f64 {
    let timed = planned.timed().expect("speeds");
    let points = &timed.path.points;
    let mut depth = 0.0;
    for line in &timed.path.lines {
        for i in line.points.start + 1..line.points.end {
            let (ax, ay, bx, by) = (points.x[i - 1], points.y[i - 1], points.x[i], points.y[i]);
            let length = (bx - ax).hypot(by - ay);
            let steps = (length / 0.2e-3).ceil();
            for k in 0..steps as usize {
                let t = (k as f64 + 0.5) / steps;
                let time = length / timed.speed[i] / steps;
                depth += time * rate(x - ax - t * (bx - ax), y - ay - t * (by - ay));
            }
        }
    }
    depth
}

/// Compares at places over the clear aperture; half a per cent is what the table of the prediction and the changes of speed cost.
fn compare(planned: &Planned, rate: impl Fn(f64, f64) -> f64) {
    let outcome = planned.dwell.as_ref().expect("a solved run");
    let grid = &outcome.removal;
    let mut greatest = 0.0_f64;
    for (column, row) in [(80, 80), (100, 92), (60, 65), (85, 40), (120, 100), (45, 110)] {
        let found = grid.at(row, column);
        let expected = removed(planned, grid.position(row, column), &rate);
        assert!((found - expected).abs() < 5e-3 * expected, "{column}, {row}: {found} is predicted, {expected} summed");
        greatest = greatest.max(found);
    }
    assert!(greatest > 50e-9, "the tool works: {greatest}");
    assert!(outcome.figures.rms < 0.5 * outcome.figures.before_rms, "and mends: {:?}", outcome.figures);
}

/// The rate of a pad by Preston's law, phase of the orbit by phase: a lattice of places of the pad's middle, the rubbing speed there
/// as the cross product of the turns and levers, where the pad is.
fn pad_rate(absolute_spin: f64) -> impl Fn(f64, f64) -> f64 {
    let (a, e, orbit) = (5e-3, 4e-3, 90.0 * TAU / 60.0);
    let pressure = 10.0 / (PI * a * a);
    // 4e-7 mm²/N is 4e-13 m²/N.
    let factor = 4e-13 * pressure;
    let phases = 20_000;
    let table: Vec<f64> = (0..=200)
        .map(|k| {
            let s = f64::from(k) * 0.05e-3;
            let mut sum = 0.0;
            for p in 0..phases {
                let phase = TAU * (f64::from(p) + 0.5) / f64::from(phases);
                let (cx, cy) = (e * phase.cos(), e * phase.sin());
                if (s - cx).hypot(cy) < a {
                    // The pad's middle moves with the orbit, the pad turns about it.
                    let (vx, vy) = (-orbit * cy - absolute_spin * (0.0 - cy), orbit * cx + absolute_spin * (s - cx));
                    sum += vx.hypot(vy);
                }
            }
            factor * sum / f64::from(phases)
        })
        .collect();
    move |dx, dy| {
        let place = dx.hypot(dy) / 0.05e-3;
        let k = place as usize;
        if k >= 200 { 0.0 } else { table[k] + (place - k as f64) * (table[k + 1] - table[k]) }
    }
}

#[test]
fn a_pad_removes_what_its_phases_sum_to() {
    // On the arm: 90 less 250 rpm in all.
    compare(&planned("pad_60", |text| text), pad_rate((90.0 - 250.0) * TAU / 60.0));
    // The same numbers counted against the housing are another tool; and a turn seen from the other side turns around.
    let absolute = |text: String| {
        text.replace("spin_measured: on_arm", "spin_measured: absolute")
            .replace("positive: clockwise, seen: from_tool_side", "positive: counterclockwise, seen: from_glass")
    };
    compare(&planned("pad_60", absolute), pad_rate(-250.0 * TAU / 60.0));
}

/// The rate of a bonnet at one lean, from the cross product of its turn with the lever from its middle, the normal part dropped.
fn bonnet_rate(leans: &[f64]) -> impl Fn(f64, f64) -> f64 {
    let (radius, offset, tilt, m) = (80e-3_f64, 0.2e-3, 20.0_f64.to_radians(), 1.5);
    let height = radius - offset;
    let a = (radius * radius - height * height).sqrt();
    let spin = 500.0 * TAU / 60.0;
    let speed = move |lean: f64, x: f64, y: f64| {
        let axis = [tilt.sin() * lean.cos(), tilt.sin() * lean.sin(), tilt.cos()];
        let lever = [x, y, -height];
        let v = [axis[1] * lever[2] - axis[2] * lever[1], axis[2] * lever[0] - axis[0] * lever[2]];
        spin * v[0].hypot(v[1])
    };
    let pressure = move |x: f64, y: f64| (1.0 - (x * x + y * y) / (a * a)).max(0.0).powf(m);
    // The greatest rate of a single lean, on a fine lattice, is 4 nm/s.
    let mut most = 0.0_f64;
    for i in -400..=400 {
        for j in -400..=400 {
            let (x, y) = (f64::from(i) * a / 400.0, f64::from(j) * a / 400.0);
            most = most.max(pressure(x, y) * speed(0.0, x, y));
        }
    }
    let leans = leans.to_vec();
    move |x, y| {
        let mean = leans.iter().map(|lean| speed(*lean, x, y)).sum::<f64>() / leans.len() as f64;
        4e-9 / most * pressure(x, y) * mean
    }
}

#[test]
fn a_bonnet_removes_by_its_turn_and_lean() {
    let lean = 30.0_f64.to_radians();
    compare(&planned("bonnet_60", |text| text), bonnet_rate(&[lean]));
    let stepped = |text: String| text.replace("held { at: 30 deg }", "stepped { first: 30 deg, positions: 3 }");
    compare(&planned("bonnet_60", stepped), bonnet_rate(&[lean, lean + TAU / 3.0, lean + 2.0 * TAU / 3.0]));
}

/// A tool that grows weaker and wider outwards: two Gaussians of a set along the radius, linear in between.
#[test]
fn a_set_removes_by_where_the_tool_stands() {
    let set = |text: String| {
        let start = text.find("    tool: planetary_pad {").expect("the tool");
        let end = start + text[start..].find("\n    }\n").expect("its end") + 7;
        let wheel = "    tool: mrf_wheel {
        diameter: 50 mm, speed: 200 rpm, rotation: forward, gap: 1 mm, azimuth: 0 deg
        influence: set {
            along: radius
            at: [
                { place: 0 mm,  influence: gaussian { peak: 20 nm/s, sigma: 2 mm, diameter: 14 mm } }
                { place: 40 mm, influence: gaussian { peak: 10 nm/s, sigma: 3 mm, diameter: 18 mm } }
            ]
        }
    }
";
        format!("{}{wheel}{}", &text[..start], &text[end..])
    };
    let planned = planned("pad_60", set);
    let gaussian = |r: f64, peak: f64, sigma: f64, radius: f64| {
        if r > radius { 0.0 } else { peak * (-r * r / (2.0 * sigma * sigma)).exp() }
    };
    let grid = &planned.dwell.as_ref().expect("a solved run").removal;
    for (column, row) in [(80, 80), (100, 92), (60, 65), (85, 40), (120, 100)] {
        let [x, y] = grid.position(row, column);
        // The weight belongs to the place where the tool stands: (x, y) less the offset.
        let expected = removed(&planned, [x, y], |dx, dy| {
            let share = (x - dx).hypot(y - dy) / 40e-3;
            let r = dx.hypot(dy);
            if share >= 1.0 {
                gaussian(r, 10e-9, 3e-3, 9e-3)
            } else {
                (1.0 - share) * gaussian(r, 20e-9, 2e-3, 7e-3) + share * gaussian(r, 10e-9, 3e-3, 9e-3)
            }
        });
        let found = grid.at(row, column);
        assert!((found - expected).abs() < 5e-3 * expected, "{column}, {row}: {found} is predicted, {expected} summed");
    }
}

/// A pad on a robot goes the whole way: its program is written, read back and verified, and tells the operator how it turns.
#[test]
fn a_pad_on_a_robot_is_written_and_verified() {
    let path = "tests/jobs/pad_60.polish";
    let text = std::fs::read_to_string(path).expect("the job");
    let uses =
        "use std.materials.k9\nuse std.robots.abb.irb6700_200_260\nuse std.controllers.irc5\nuse \"cell.polish\"\n";
    let robot = "\n    robot:     irb6700_200_260 with { cell: cell.mrf }
    target:    rapid { controller: irc5, module: \"Pad60\", frames: in_program }
    unchecked: [arm, cell, cable, fixture]
}
";
    let text = text.replace("use std.materials.k9\n", uses);
    let text = format!("{}{robot}", text.trim_end().strip_suffix('}').expect("the job's end"));
    let mut files = TestFiles::default();
    files.extra.insert(path.into(), text.into_bytes());
    files.extra.insert("tests/jobs/map.npy".into(), map());
    let request = Request { sets: vec![("map".into(), "tests/jobs/map.npy".into())], ..Request::new(path) };
    let done = session::compile(&files, &request, &Unwatched);
    let said = render::render(&done.sources, &done.diagnostics, Style::Short, false);
    assert!(!done.failed(), "{said}");
    let program = done.jobs[0].program.as_ref().expect("a verified program");
    let text: String = program.files.iter().map(|file| String::from_utf8_lossy(&file.bytes).into_owned()).collect();
    for fact in ["orbit 90.000 rpm counter-clockwise", "spin 250.000 rpm clockwise on arm", "force 10.000 N"] {
        assert!(text.contains(fact), "{fact}");
    }
}
