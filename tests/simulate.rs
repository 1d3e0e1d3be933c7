//! Simulation: what the text of a program removes, what an edit changes, what a log of a run tells.
//!
//! Expected values are derived by hand: a move that takes longer removes the volume rate times the time more; a log made by a
//! sampler of the test, from speeds and ramps as the page on dwell states them, removes what the plan does.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

mod replay;

use polishc::diagnostics::{Diagnostic, Severity};
use polishc::height_map::Grid;
use polishc::motion::Purpose;
use polishc::session::simulation::{Of, Simulation, simulate};
use polishc::session::{self, Compilation, Request, Until, Unwatched};
use polishc::simulate::{self, log::Frame};
use polishc::source::MemoryFiles;
use polishc::target::Program;
use replay::forms::FORMS;
use replay::{ASKEW, KRL, KRL_LINEAR, job_text, npy};

/// Acceleration of the job, mm/s².
const ACCELERATION: f64 = 500.0;

/// A bowl and a bump, 84 x 65 pixels of 1 mm, in nanometres.
fn map() -> Vec<u8> {
    let values = (0..84 * 65).map(|i| {
        let (x, y) = ((i % 84) as f64 - 41.5, 32.0 - (i / 84) as f64);
        (x * x + y * y) / 10.0 + 700.0 * (-((x - 8.0).powi(2) + (y + 5.0).powi(2)) / 60.0).exp()
    });
    npy(84, &values.collect::<Vec<_>>())
}

fn files(changes: &[(&str, &str)]) -> MemoryFiles {
    let text = job_text(&ASKEW, changes).into_bytes();
    MemoryFiles([("trial/trial.polish".to_string(), text), ("trial/map.npy".to_string(), map())].into())
}

fn compile(files: &MemoryFiles, until: Until) -> Compilation {
    let done = session::compile(files, &Request { until, ..Request::new("trial/trial.polish") }, &Unwatched);
    assert!(!done.failed(), "{:?}", done.diagnostics);
    done
}

/// The words of a job with coarser steps: some 1500 moves.
const COARSE: [(&str, &str); 2] = [("step", "2 mm"), ("pitch", "2 mm")];

fn words(more: &[(&'static str, &'static str)]) -> Vec<(&'static str, &'static str)> {
    [&COARSE[..], more].concat()
}

fn good(done: &mut Compilation, of: &Of) -> Simulation {
    done.diagnostics.clear();
    let found = simulate(done, of);
    assert!(!done.failed(), "{:?}", done.diagnostics);
    found.expect("a simulation")
}

/// The codes of errors (or of warnings) that a simulation says.
fn codes(done: &mut Compilation, of: &Of, severity: Severity) -> Vec<String> {
    done.diagnostics.clear();
    simulate(done, of);
    let of = |d: &&Diagnostic| d.severity == severity;
    done.diagnostics.iter().filter(of).map(|d| d.code.as_str().to_string()).collect()
}

fn program(done: &Compilation) -> Program {
    (**done.jobs[0].program.as_ref().expect("a program")).clone()
}

/// Sum over the pixels of what `found` removes more than `plan`, m³.
fn more_volume(plan: &Grid, found: &Grid) -> f64 {
    let pixel = plan.pixel[0] * plan.pixel[1];
    plan.values.iter().zip(&found.values).map(|(a, b)| b - a).filter(|d| !d.is_nan()).sum::<f64>() * pixel
}

/// Volume rate of the job's spot, m³/s: 2 pi sigma² peak (1 - exp(-R²/2 sigma²)), sigma 4 mm, R 10 mm, 20 nm/s.
fn volume_rate() -> f64 {
    std::f64::consts::TAU * 16e-6 * 20e-9 * (1.0 - (-3.125f64).exp())
}

#[test]
fn the_text_of_a_program_removes_what_was_planned() {
    let forms: Vec<&str> = FORMS.iter().map(|form| form.text).filter(|text| text.starts_with("sphere")).collect();
    assert!(!forms.is_empty());
    let mut cases: Vec<(String, Vec<(&str, &str)>)> = vec![
        ("RAPID".into(), words(&[])),
        ("KRL".into(), words(&KRL)),
        ("KRL, linear".into(), words(&KRL_LINEAR)),
        ("one way".into(), words(&[("lines", "one_way"), ("direction", "37 deg"), ("azimuth", "25 deg")])),
    ];
    for form in &forms {
        cases.push((form.to_string(), words(&[("form", form)])));
    }
    for (name, words) in cases {
        let files = files(&words);
        let mut done = compile(&files, Until::Program);
        let found = good(&mut done, &Of::Job);
        assert_eq!(found.result.of, "program", "{name}");
        let plan = done.jobs[0].dwell.as_ref().expect("a plan");
        let difference = simulate::difference(&plan.removal, &found.outcome.removal);
        // Places are written to a tenth of a micrometre and better, speeds to 1 um/s of some mm/s, in single precision: a
        // part in 10,000. The links between lines, which the plan leaves out, lie off the part.
        assert!(difference.share < 2e-4, "{name}: {difference:?}");
        assert!(difference.share > 0.0, "{name}: text is rounded, so something must differ");
        let time = (found.outcome.figures.time - plan.figures.time) / plan.figures.time;
        // Lengths of ways are those of the tool in both.
        assert!(time.abs() < 1e-3, "{name}: {} s, {} s", found.outcome.figures.time, plan.figures.time);
        let contact = found.result.program.expect("a program");
        assert!(contact.height_um < 1.0 && contact.lean_deg < 1e-3 && contact.too_fast == 0, "{name}: {contact:?}");
    }
}

#[test]
fn a_job_without_a_robot_gives_its_plan() {
    let text = job_text(&ASKEW, &words(&[]));
    let without = text.lines().filter(|line| {
        let line = line.trim_start();
        !["robot:", "target:", "unchecked:"].iter().any(|word| line.starts_with(word))
    });
    let text = without.collect::<Vec<_>>().join("\n");
    let files = MemoryFiles(
        [("trial/trial.polish".to_string(), text.into_bytes()), ("trial/map.npy".to_string(), map())].into(),
    );
    let mut done = compile(&files, Until::Program);
    let found = good(&mut done, &Of::Job);
    assert_eq!(found.result.of, "plan");
    assert!(found.result.against_plan.is_none());
    assert_eq!(found.outcome.removal.values.len(), done.jobs[0].dwell.as_ref().expect("a plan").removal.values.len());
    let none = codes(&mut done, &Of::Program(&Program::default()), Severity::Error);
    assert_eq!(none, ["E0905"]);
}

/// A move of a RAPID program: which file and line, where it goes (mm), its speed (mm/s) and zone.
#[derive(Clone, Debug, PartialEq)]
struct Move {
    file: usize,
    line: usize,
    at: [f64; 3],
    speed: f64,
    zone: String,
}

fn moves(program: &Program) -> Vec<Move> {
    let mut found = Vec::new();
    for (file, bytes) in program.files.iter().enumerate().map(|(i, f)| (i, &f.bytes)) {
        let text = std::str::from_utf8(bytes).expect("ASCII");
        for (line, words) in text.split("\r\n").enumerate() {
            let Some(rest) = words.trim_start().strip_prefix("MoveL [[") else { continue };
            let place: Vec<f64> =
                rest.split(']').next().expect("a place").split(',').map(|v| v.parse().expect("a number")).collect();
            let (_, speed) = rest.split_once("]],[").or_else(|| rest.rsplit_once("],[")).expect("a speed");
            let speed = speed.split(',').next().expect("a speed").parse().expect("a number");
            let zone = rest.rsplit_once("],").expect("a zone").1.split(',').next().expect("a zone").to_string();
            found.push(Move { file, line, at: [place[0], place[1], place[2]], speed, zone });
        }
    }
    found
}

/// The program with a move's line changed.
fn edited(program: &Program, one: &Move, edit: impl Fn(&str) -> String) -> Program {
    let mut edited = program.clone();
    let text = String::from_utf8(edited.files[one.file].bytes.clone()).expect("ASCII");
    let mut lines: Vec<String> = text.split("\r\n").map(str::to_string).collect();
    let new = edit(&lines[one.line]);
    assert_ne!(new, lines[one.line], "the edit must change something");
    lines[one.line] = new;
    edited.files[one.file].bytes = lines.join("\r\n").into_bytes();
    edited
}

/// The index of a move that passes near the middle of the part.
fn middle(moves: &[Move]) -> usize {
    moves.iter().position(|m| m.zone == "z0" && m.at[0].abs() < 1.5 && m.at[1].abs() < 1.5).expect("a move")
}

/// Seconds of a segment of 2 mm entered at `u` and programmed at `v`, mm/s.
fn seconds(u: f64, v: f64) -> f64 {
    2.0 / v + (v - u) * (v - u).abs() / (2.0 * ACCELERATION * v)
}

#[test]
fn an_edited_speed_removes_by_its_time() {
    let files = files(&words(&[]));
    let mut done = compile(&files, Until::Program);
    let ours = program(&done);
    let moves = moves(&ours);
    let i = middle(&moves);
    let (u, v, w) = (moves[i - 1].speed, moves[i].speed, moves[i + 1].speed);
    let slow = (v / 10.0 * 1e3).round() / 1e3;
    let slower = edited(&ours, &moves[i], |line| line.replacen(&format!("],[{v},"), &format!("],[{slow},"), 1));
    let found = good(&mut done, &Of::Program(&slower));
    let plan = done.jobs[0].dwell.as_ref().expect("a plan");
    let longer = seconds(u, slow) + seconds(slow, w) - seconds(u, v) - seconds(v, w);
    let expected = volume_rate() * longer;
    let volume = more_volume(&plan.removal, &found.outcome.removal);
    // Pixels of a quarter of sigma sum a Gaussian cut at 2.5 sigma to about 1 %.
    assert!((volume - expected).abs() < 0.02 * expected, "{volume:e} {expected:e}");
    let difference = simulate::difference(&plan.removal, &found.outcome.removal);
    // Most differs under the move's middle, within the rounding to pixels.
    let middle = [0, 1].map(|k| (moves[i].at[k] + moves[i - 1].at[k]) / 2.0);
    for k in 0..2 {
        assert!((difference.place[k] * 1e3 - middle[k]).abs() < 1.1, "{difference:?} {middle:?}");
    }
    assert!(difference.most > 0.0);
    // The peak of a spot spread over 2 mm: 20 nm/s, less (1 mm)²/(6 sigma²) of it, less up to half a pixel's diagonal.
    let peak = 20.0 * longer;
    assert!(difference.most * 1e9 > 0.94 * peak && difference.most * 1e9 < peak, "{difference:?} {peak}");
    let warned: Vec<&str> = done.diagnostics.iter().map(|d| d.code.as_str()).filter(|c| *c == "W1300").collect();
    assert_eq!(warned.len(), usize::from(difference.share > 0.01), "{difference:?}");
    assert!(difference.share > 0.01, "the edit must be one that is warned of: {difference:?}");
}

#[test]
fn a_stop_put_into_a_line_removes_more() {
    let files = files(&words(&[]));
    let mut done = compile(&files, Until::Program);
    let ours = program(&done);
    let moves = moves(&ours);
    let i = middle(&moves);
    let (v, w) = (moves[i].speed, moves[i + 1].speed);
    let stopping = edited(&ours, &moves[i], |line| line.replacen(",z0,", ",fine,", 1));
    let found = good(&mut done, &Of::Program(&stopping));
    let plan = done.jobs[0].dwell.as_ref().expect("a plan");
    let longer = v / (2.0 * ACCELERATION) + seconds(0.0, w) - seconds(v, w);
    let expected = volume_rate() * longer;
    let volume = more_volume(&plan.removal, &found.outcome.removal);
    assert!((volume - expected).abs() < 0.03 * expected, "{volume:e} {expected:e}");
}

#[test]
fn a_speed_that_the_arm_does_not_reach_is_told() {
    let files = files(&words(&[]));
    let mut done = compile(&files, Until::Program);
    let ours = program(&done);
    let moves = moves(&ours);
    let one = &moves[middle(&moves)];
    // To 200 mm/s from some 10 mm/s takes 40 mm at 500 mm/s²; the move has 2.
    let fast = edited(&ours, one, |line| line.replacen(&format!("],[{},", one.speed), "],[200,", 1));
    let warned = codes(&mut done, &Of::Program(&fast), Severity::Warning);
    assert!(warned.contains(&"W1301".to_string()), "{warned:?}");
}

#[test]
fn a_point_taken_out_is_passed_by_on_the_straight_way() {
    let files = files(&words(&[]));
    let mut done = compile(&files, Until::Program);
    let ours = program(&done);
    let moves = moves(&ours);
    let i = middle(&moves);
    let mut shorter = ours.clone();
    let text = String::from_utf8(shorter.files[moves[i].file].bytes.clone()).expect("ASCII");
    let lines: Vec<&str> =
        text.split("\r\n").enumerate().filter(|(k, _)| *k != moves[i].line).map(|(_, l)| l).collect();
    shorter.files[moves[i].file].bytes = lines.join("\r\n").into_bytes();
    let found = good(&mut done, &Of::Program(&shorter));
    let plan = done.jobs[0].dwell.as_ref().expect("a plan");
    let (u, v, w) = (moves[i - 1].speed, moves[i].speed, moves[i + 1].speed);
    // 4 mm at the next move's speed instead of 2 and 2.
    let longer = seconds(u, w) + 2.0 / w - seconds(u, v) - seconds(v, w);
    let expected = volume_rate() * longer;
    let volume = more_volume(&plan.removal, &found.outcome.removal);
    assert!((volume - expected).abs() < 0.02 * expected.abs() + 1e-16, "{volume:e} {expected:e}");
}

#[test]
fn programs_that_cannot_be_simulated_are_refused() {
    let words = words(&[]);
    let files = files(&words);
    let mut done = compile(&files, Until::Program);
    let ours = program(&done);
    let moves = moves(&ours);
    let one = &moves[middle(&moves)];
    let [x, y, z] = one.at;
    let raised = |height: f64| {
        edited(&ours, one, |line| line.replacen(&format!("[[{x},{y},{z}]"), &format!("[[{x},{y},{height}]"), 1))
    };
    let mut said = |program: &Program| codes(&mut done, &Of::Program(program), Severity::Error);
    // The gap is 1 mm: 0.05 mm is what an arm errs by, 0.4 mm is nothing known, 30 mm is lifted.
    assert_eq!(said(&raised(1.05)), [""; 0]);
    assert_eq!(said(&raised(1.4)), ["E1300"]);
    assert_eq!(said(&raised(0.2)), ["E1300"]);
    assert_eq!(said(&raised(31.0)), [""; 0]);
    // What is no move must be the job's: frames, process, digest, files.
    let main = |from: &str, to: &str| {
        let mut edited = ours.clone();
        let text = String::from_utf8(edited.files[0].bytes.clone()).expect("ASCII");
        assert!(text.contains(from), "{from}");
        edited.files[0].bytes = text.replacen(from, to, 1).into_bytes();
        edited
    };
    let digest_at = String::from_utf8(ours.files[0].bytes.clone()).expect("ASCII");
    let digest =
        digest_at.split("_digest:=\"").nth(1).expect("a digest").split('"').next().expect("a digest").to_string();
    assert!(said(&main(&format!("_digest:=\"{digest}"), "_digest:=\"0123")).contains(&"E1009".to_string()));
    assert!(!said(&main("VelSet 100,5000;", "VelSet 50,5000;")).is_empty());
    assert_eq!(said(&main("MODULE", "MADULE")), ["E1000"]);
    assert_eq!(said(&Program { files: ours.files[1..].to_vec() }), ["E1002"]);
    assert_eq!(said(&edited(&ours, one, |line| line.replacen(&format!("],[{},", one.speed), "],[0,", 1))), ["E1008"]);
    assert_eq!(said(&edited(&ours, one, |line| line.replacen(",500,", ",5,", 1))), ["E1008"]);
    assert_eq!(said(&edited(&ours, one, |line| line.replacen(",z0,", ",z77,", 1))), ["E1004"]);
    // The dry run is another program, that of another job too.
    let request = Request { purpose: Purpose::DryRun, ..Request::new("trial/trial.polish") };
    let dry = program(&session::compile(&files, &request, &Unwatched));
    assert_eq!(said(&dry), ["E1002"]);
    let other = files_with_feed(&words);
    let other = program(&compile(&other, Until::Program));
    assert!(said(&other).contains(&"E1009".to_string()));
}

fn files_with_feed(words: &[(&str, &str)]) -> MemoryFiles {
    let text = job_text(&ASKEW, words).replace("removal_fraction: 90 %", "removal_fraction: 60 %");
    MemoryFiles([("trial/trial.polish".to_string(), text.into_bytes()), ("trial/map.npy".to_string(), map())].into())
}

// ---- logs ----

/// A run of the plan, sampled every `interval` seconds: seconds, and mm in the part frame of the tool centre point. Segments
/// are driven as the page on dwell states: from one speed to the next at once with the job's acceleration, lines from rest
/// to rest, and so are the ways between them.
fn sampled(done: &Compilation, interval: f64) -> Vec<(f64, [f64; 3])> {
    let timed = done.jobs[0].timed().expect("a plan");
    // The tool centre point, to which the speeds belong: 1 mm along the normal.
    let place = |i: usize| {
        let (contact, normal) = (timed.path.points.position(i), timed.path.points.normal(i));
        [0, 1, 2].map(|k| contact[k] * 1e3 + normal[k])
    };
    // Pieces of constant acceleration: start, end (mm), speeds at both (mm/s).
    let mut pieces: Vec<([f64; 3], [f64; 3], f64, f64)> = Vec::new();
    let mut drive = |a: [f64; 3], b: [f64; 3], u: f64, v: f64, stops: bool| {
        let length = (0..3).map(|k| (b[k] - a[k]).powi(2)).sum::<f64>().sqrt();
        let at = |s: f64| [0, 1, 2].map(|k| a[k] + s / length * (b[k] - a[k]));
        let change = (v * v - u * u).abs() / (2.0 * ACCELERATION);
        let stop = if stops { v * v / (2.0 * ACCELERATION) } else { 0.0 };
        pieces.push((a, at(change), u, v));
        pieces.push((at(change), at(length - stop), v, v));
        if stops {
            pieces.push((at(length - stop), b, v, 0.0));
        }
    };
    for (n, line) in timed.path.lines.iter().enumerate() {
        if n > 0 {
            let (a, b) = (line.points.start - 1, line.points.start);
            drive(place(a), place(b), 0.0, timed.speed[b] * 1e3, true);
        }
        let mut before = 0.0;
        for i in line.points.start + 1..line.points.end {
            let v = timed.speed[i] * 1e3;
            drive(place(i - 1), place(i), before, v, i + 1 == line.points.end);
            before = v;
        }
    }
    let (mut samples, mut now, mut next) = (Vec::new(), 0.0, 0.0);
    // Before the path it comes down from 41 mm.
    for height in [40.0, 30.0, 20.0, 10.0] {
        let [x, y, z] = place(0);
        samples.push((next, [x, y, z + height]));
        next += interval;
    }
    now += next;
    for (a, b, u, v) in pieces {
        let length = (0..3).map(|k| (b[k] - a[k]).powi(2)).sum::<f64>().sqrt();
        if length < 1e-12 {
            continue;
        }
        let time = 2.0 * length / (u + v);
        while next <= now + time {
            let t = next - now;
            let s = u * t + (v - u) / time * t * t / 2.0;
            let [x, y, z] = [0, 1, 2].map(|k| a[k] + s / length * (b[k] - a[k]));
            samples.push((next, [x, y, z]));
            next += interval;
        }
        now += time;
    }
    samples
}

fn csv(samples: &[(f64, [f64; 3])]) -> Vec<u8> {
    let mut text = "# frame: part\nt [s], x [mm], y [mm], z [mm]\n".to_string();
    for (t, [x, y, z]) in samples {
        text += &format!("{t:.6}, {x:.6}, {y:.6}, {z:.6}\n");
    }
    text.into_bytes()
}

fn of_log(bytes: &[u8]) -> Of<'_> {
    Of::Run { name: "run.csv", bytes, frame: None }
}

struct Logged {
    done: Compilation,
    samples: Vec<(f64, [f64; 3])>,
}

fn logged(more: &[(&'static str, &'static str)]) -> Logged {
    let files = files(&words(more));
    let done = compile(&files, Until::Motion);
    let samples = sampled(&done, 0.01);
    Logged { done, samples }
}

impl Logged {
    fn run(&mut self, samples: &[(f64, [f64; 3])]) -> Simulation {
        good(&mut self.done, &of_log(&csv(samples)))
    }

    fn refused(&mut self, samples: &[(f64, [f64; 3])]) -> Vec<String> {
        codes(&mut self.done, &of_log(&csv(samples)), Severity::Error)
    }

    fn difference(&self, found: &Simulation) -> simulate::Difference {
        simulate::difference(&self.done.jobs[0].dwell.as_ref().expect("a plan").removal, &found.outcome.removal)
    }
}

#[test]
fn a_run_as_planned_removes_what_was_planned() {
    for form in ["plane", "sphere { side: concave, radius: 300 mm }"] {
        let mut logged = logged(&[("form", form)]);
        let samples = logged.samples.clone();
        let found = logged.run(&samples);
        let difference = logged.difference(&found);
        // Between two samples the speed is taken as constant and the way as straight: 10 ms of it are a fortieth of the
        // spot's sigma where it goes fast.
        assert!(difference.share < 5e-3, "{form}: {difference:?}");
        let run = found.result.run.expect("a run");
        assert!(run.on_path > 0.999 && run.beside_mm < 1e-3, "{form}: {run:?}");
        assert!((run.height_mm - 1.0).abs() < 1e-3, "{form}: {run:?}");
        assert!(run.mean_speed_error.abs() < 1e-3 && run.rms_speed_error < 5e-3, "{form}: {run:?}");
        assert!(run.stops_s.is_empty() && run.holes_s.is_empty() && run.missing < 1e-3, "{form}: {run:?}");
        assert_eq!(logged.done.diagnostics.iter().filter(|d| d.code.as_str().starts_with("W13")).count(), 0);
    }
}

#[test]
fn a_run_at_ninety_percent_removes_a_ninth_more() {
    let mut logged = logged(&[]);
    let slow: Vec<_> = logged.samples.iter().map(|(t, p)| (t / 0.9, *p)).collect();
    let found = logged.run(&slow);
    let plan = logged.done.jobs[0].dwell.as_ref().expect("a plan");
    let ratio = found.outcome.figures.mean_removal / plan.figures.mean_removal;
    // Stamps of the plan lie half a sigma apart, which for a spot that is cut at 2.5 sigma is right to some parts in a
    // thousand; those of the log lie closer.
    assert!((ratio - 1.0 / 0.9).abs() < 4e-3, "{ratio}");
    let run = found.result.run.expect("a run");
    assert!((run.mean_speed_error + 0.1).abs() < 1e-3 && (run.rms_speed_error - 0.1).abs() < 3e-3, "{run:?}");
    assert!(found.result.warnings.iter().any(|w| w.starts_with("W1300")), "{:?}", found.result.warnings);
}

#[test]
fn a_stop_over_the_part_is_found_and_digs_its_pit() {
    let mut logged = logged(&[]);
    // The sample nearest to the middle of the part; the machine stands there for 5 s, trembling by 2 um.
    let near = |p: &[f64; 3]| p[0].hypot(p[1]);
    let on: Vec<usize> = (0..logged.samples.len()).filter(|i| logged.samples[*i].1[2] < 2.0).collect();
    let at =
        on.into_iter().min_by(|a, b| near(&logged.samples[*a].1).total_cmp(&near(&logged.samples[*b].1))).expect("one");
    let mut samples = logged.samples[..=at].to_vec();
    let (t, [x, y, z]) = samples[at];
    for k in 1..=500 {
        let tremble = 2e-3 * if k % 2 == 0 { 1.0 } else { -1.0 };
        samples.push((t + k as f64 * 0.01, [x + tremble, y, z]));
    }
    samples.extend(logged.samples[at + 1..].iter().map(|(t, p)| (t + 5.0, *p)));
    let plain = logged.samples.clone();
    let before = logged.run(&plain);
    let found = logged.run(&samples);
    let run = found.result.run.as_ref().expect("a run");
    let [stop] = run.stops_s.as_slice() else { panic!("one stop: {run:?}") };
    assert!((stop.value - 5.0).abs() < 0.1 && (stop.x_mm - x).abs() < 0.25 && (stop.y_mm - y).abs() < 0.25, "{stop:?}");
    let volume = more_volume(&before.outcome.removal, &found.outcome.removal);
    let expected = volume_rate() * 5.0;
    assert!((volume - expected).abs() < 0.02 * expected, "{volume:e} {expected:e}");
    // The pit: 20 nm/s for 5 s, read on the nearest pixel, at most 0.7 mm beside.
    let pit = simulate::difference(&before.outcome.removal, &found.outcome.removal);
    assert!(pit.most > 98.0e-9 * (-0.5f64 / 32.0).exp() && pit.most < 100.5e-9, "{pit:?}");
    assert!(found.result.warnings.iter().any(|w| w.starts_with("W1303")), "{:?}", found.result.warnings);
}

#[test]
fn samples_that_are_missing_are_told() {
    let mut logged = logged(&[]);
    // 10 mm of a line in the middle are lost.
    let at = logged.samples.iter().position(|(_, [x, y, z])| *z < 2.0 && x.abs() < 1.0 && y.abs() < 1.5).expect("one");
    let gone = |k: usize| (logged.samples[k].1[0] - logged.samples[at].1[0]).abs();
    let lost = (at + 1..).position(|k| gone(k) > 10.0).expect("10 mm farther on");
    let mut samples = logged.samples.clone();
    samples.drain(at + 1..at + 1 + lost);
    let found = logged.run(&samples);
    let run = found.result.run.as_ref().expect("a run");
    let [hole] = run.holes_s.as_slice() else { panic!("one hole: {run:?}") };
    assert!((hole.value - (lost + 1) as f64 * 0.01).abs() < 0.011, "{hole:?}");
    // 10 mm and a bit of 27 lines that lie 2 mm apart over an aperture of 55 mm: area / pitch.
    let whole = std::f64::consts::PI * 27.5 * 27.5 / 2.0;
    assert!((run.missing * whole - 10.0).abs() < 1.5, "{}", run.missing * whole);
    assert!(found.result.warnings.iter().any(|w| w.starts_with("W1302")), "{:?}", found.result.warnings);
    // Half of the run.
    let half = logged.samples.len() / 2;
    let first_half = logged.samples[..half].to_vec();
    let found = logged.run(&first_half);
    let missing = found.result.run.expect("a run").missing;
    assert!(missing > 0.3 && missing < 0.7, "{missing}");
}

#[test]
fn a_log_of_another_frame_or_unit_is_refused() {
    let mut logged = logged(&[]);
    let samples = logged.samples.clone();
    let with = |change: &dyn Fn([f64; 3]) -> [f64; 3]| -> Vec<(f64, [f64; 3])> {
        samples.iter().map(|(t, p)| (*t, change(*p))).collect()
    };
    for (name, changed) in [
        ("metres as millimetres", with(&|p| p.map(|v| v * 1e-3))),
        ("inches as millimetres", with(&|p| p.map(|v| v / 25.4))),
        ("x and y changed about", with(&|[x, y, z]| [y, x, z])),
        ("x mirrored", with(&|[x, y, z]| [-x, y, z])),
        ("y mirrored", with(&|[x, y, z]| [x, -y, z])),
        ("half a turn", with(&|[x, y, z]| [-x, -y, z])),
        ("a quarter turn", with(&|[x, y, z]| [-y, x, z])),
        ("above", with(&|[x, y, z]| [x, y, z + 85.0])),
        ("below", with(&|[x, y, z]| [x, y, z - 20.0])),
    ] {
        assert_eq!(logged.refused(&changed), ["E1306"], "{name}");
    }
    // A tenth of a millimetre of noise and of offset is an arm.
    let mut seed = 1u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1u32 << 24) - 0.5
    };
    let shaken: Vec<_> = samples
        .iter()
        .map(|(t, [x, y, z])| (*t, [x + 0.1 + 0.1 * random(), y - 0.1 + 0.1 * random(), z + 0.2 * random()]))
        .collect();
    let run = logged.run(&shaken).result.run.expect("a run");
    assert!(run.on_path > 0.99 && run.beside_mm > 0.05 && run.beside_mm < 0.2, "{run:?}");
}

#[test]
fn a_log_must_say_its_frame() {
    let mut logged = logged(&[]);
    let text = String::from_utf8(csv(&logged.samples)).expect("ASCII");
    for (frame, stated, wanted) in [
        ("", None, &["E1305"][..]),
        ("# frame: world\n", None, &["E1305"]),
        ("# frame: object\n", None, &[]),
        ("", Some(Frame::Part), &[]),
    ] {
        let bytes = text.replacen("# frame: part\n", frame, 1).into_bytes();
        let of = Of::Run { name: "run.csv", bytes: &bytes, frame: stated };
        assert_eq!(codes(&mut logged.done, &of, Severity::Error), wanted, "{frame}");
    }
}

// ---- the residual that `build --emit residual` writes ----

/// Place of a bump in the part, mm.
const BUMP: [f64; 2] = [11.0, 6.0];

/// `view`, `up`, and where the bump then lies in the picture: mm to the right of the middle and above it. Derived by hand
/// in `tests/orientation.rs`.
const ORIENTATIONS: [(&str, &str, [f64; 2]); 8] = [
    ("from_tool_side", "plus_y", [11.0, 6.0]),
    ("from_tool_side", "plus_x", [-6.0, 11.0]),
    ("from_tool_side", "minus_y", [-11.0, -6.0]),
    ("from_tool_side", "minus_x", [6.0, -11.0]),
    ("from_back", "plus_y", [-11.0, 6.0]),
    ("from_back", "plus_x", [6.0, 11.0]),
    ("from_back", "minus_y", [11.0, -6.0]),
    ("from_back", "minus_x", [-6.0, -11.0]),
];

/// Rows, columns and values of a `.npy` of doubles, read by the rules of NumPy's format page alone.
fn read_npy(bytes: &[u8]) -> (usize, usize, Vec<f64>) {
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = std::str::from_utf8(&bytes[10..10 + length]).expect("ASCII");
    assert!(header.contains("'descr': '<f8'") && header.contains("'fortran_order': False"), "{header}");
    let shape = header.split("'shape': (").nth(1).expect("a shape").split(')').next().expect("a shape");
    let sizes: Vec<usize> = shape.split(',').map(|size| size.trim().parse().expect("a size")).collect();
    let data = bytes[10 + length..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes")));
    (sizes[0], sizes[1], data.collect())
}

/// A bump of 600 nm, 6 mm of sigma, in each of the eight orientations with both signs. The job removes 90 % of it, so 60 nm
/// of it are left where it is in the part: +11, +6 mm, whatever way the picture lies.
#[test]
fn the_emitted_residual_lies_in_the_part_frame() {
    for (case, (view, up, [right, above])) in ORIENTATIONS.iter().enumerate() {
        for (positive, sign) in [("high", 1.0), ("low", -1.0)] {
            let (columns, rows) = (84, 65);
            let heights: Vec<f64> = (0..columns * rows)
                .map(|i| {
                    let (x, y) = ((i % columns) as f64 - 41.5 - right, 32.0 - (i / columns) as f64 - above);
                    sign * 600.0 * (-(x * x + y * y) / 72.0).exp()
                })
                .collect();
            let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("residual_{case}_{positive}"));
            std::fs::create_dir_all(&folder).expect("a folder");
            let words = words(&[("view", view), ("up", up), ("positive", positive)]);
            std::fs::write(folder.join("trial.polish"), job_text(&ASKEW, &words)).expect("written");
            std::fs::write(folder.join("map.npy"), npy(columns, &heights)).expect("written");
            let built = std::process::Command::new(env!("CARGO_BIN_EXE_polishc"))
                .args(["build", "--emit", "residual", "-o"])
                .args([folder.join("out"), folder.join("trial.polish")])
                .output()
                .expect("the tool runs");
            assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
            let bytes = std::fs::read(folder.join("out/trial.residual.npy")).expect("the residual");
            let (found_rows, found_columns, values) = read_npy(&bytes);
            // The picture's columns are the part's rows where +x or -x is up.
            let turned = up.ends_with('x');
            let wanted = if turned { (columns, rows) } else { (rows, columns) };
            assert_eq!((found_rows, found_columns), wanted, "{view} {up}");
            // Rows towards +y, columns towards +x, pixels of 1 mm, the picture's middle on the part's origin.
            let place = |i: usize| {
                let middle = |count: usize| (count - 1) as f64 / 2.0;
                [(i % found_columns) as f64 - middle(found_columns), (i / found_columns) as f64 - middle(found_rows)]
            };
            let mut highest = (f64::NEG_INFINITY, 0);
            for (i, value) in values.iter().enumerate() {
                let [x, y] = place(i);
                assert_eq!(value.is_nan(), x.hypot(y) > 27.5, "{view} {up}: {x} {y} {value}");
                if *value > highest.0 {
                    highest = (*value, i);
                }
            }
            let [x, y] = place(highest.1);
            let off = (x - BUMP[0]).hypot(y - BUMP[1]);
            assert!(off <= 1.0, "{view} {up} positive {positive}: the rest of the bump is at {x}, {y}");
            // In metres: 60 nm above what is left far from it, within the ripples of the solution.
            let far: Vec<f64> = (0..values.len())
                .filter(|i| !values[*i].is_nan())
                .filter(|i| (place(*i)[0] - BUMP[0]).hypot(place(*i)[1] - BUMP[1]) > 20.0)
                .map(|i| values[i])
                .collect();
            let step = highest.0 - far.iter().sum::<f64>() / far.len() as f64;
            assert!((step - 60e-9).abs() < 6e-9, "{view} {up} positive {positive}: {step:e}");
        }
    }
}
