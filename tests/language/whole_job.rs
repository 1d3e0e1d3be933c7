//! A whole job, its cell in another file: what lands in the structs, where it was said, what its requirements come to.

use super::{library, said};
use polishc::diagnostics::Severity;
use polishc::eval::value::{Value, ValueKind};
use polishc::eval::{Compiled, Options, Said, Shown, ShownField, compile, from_value};
use polishc::job::*;
use polishc::source::{FileId, Span};
use polishc::units::si::*;
use polishc::units::{Dimension, Quantity};
use std::collections::BTreeMap;
use std::f64::consts::PI;

fn options(sets: &[(&str, &str)]) -> Options {
    Options { sets: sets.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect(), job: None }
}

fn flat(sets: &[(&str, &str)]) -> Compiled {
    compile(&library(), "jobs/flat.polish", &options(sets))
}

fn near(found: f64, expected: f64) {
    // Conversions are one or two roundings: a few parts in 1e16.
    assert!((found - expected).abs() <= 1e-15 * expected.abs(), "found {found}, expected {expected}");
}

#[test]
fn the_job_is_in_si_and_whole() {
    let compiled = flat(&[("map", "maps/flat.dat")]);
    assert_eq!(said(&compiled), Vec::<String>::new());
    let [compiled_job] = compiled.jobs.as_slice() else { panic!("one job") };
    assert_eq!(compiled_job.name, "flat_340");
    let job = &compiled_job.job;
    near(job.wavelength.expect("stated").0, 632.8e-9);
    assert_eq!(job.workpiece.part, "FS340-07");
    assert_eq!(job.workpiece.form, Form::plane(Plane {}));
    assert_eq!(
        job.workpiece.edge,
        Aperture::annulus(Annulus { outer_diameter: Length(0.34), inner_diameter: Length(0.06), centre: None })
    );
    assert_eq!(job.workpiece.material.name, "fused silica");
    let FormError::height_map(map) = &job.workpiece.error else { panic!("a height map") };
    // Given by --set: relative to the working directory, not to the job's folder.
    assert_eq!(map.file, "maps/flat.dat");
    assert_eq!(map.subtract, [Term::piston, Term::tilt]);
    assert_eq!(map.centre, MapCentre::frame_centre(Empty {}));
    near(map.fill_below.expect("stated").0, 4e-6);
    assert_eq!(map.pixel, None);
    let Tool::mrf_wheel(wheel) = &job.tool else { panic!("a wheel") };
    near(wheel.speed.0, 2.0 * PI);
    near(wheel.gap.0, 0.001);
    near(wheel.azimuth.0, PI / 2.0);
    assert_eq!(wheel.rotation, WheelRotation::forward);
    let Influence::measured(spot) = &wheel.influence else { panic!("a measured influence") };
    // Said in the job's file: relative to its folder.
    assert_eq!(spot.spots[0].file, "jobs/spots/12.dat");
    assert_eq!(spot.flow_in_map, Some(InPicture::up));
    assert_eq!(spot.spots[0].origin, Origin::pixel_at(PixelAt { column: 120.5, row: 64.0 }));
    let Path::raster(raster) = &job.path else { panic!("no raster") };
    near(raster.point_step.0, 0.004);
    near(raster.line_pitch.0, 0.0005);
    assert_eq!(raster.direction, Angle(0.0));
    assert_eq!(raster.lines, Lines::serpentine);
    assert_eq!(raster.holes, Some(Crossing::cross(Cross { process: OnOff::on })));
    let Dwell::corrective(dwell) = &job.dwell;
    near(dwell.removal_fraction, 0.8);
    near(dwell.feed.from.0, 0.0002);
    near(dwell.feed.to.0, 0.1);
    near(dwell.acceleration.0, 0.5);
    let Piston::free(free) = &dwell.piston else { panic!("a free piston") };
    near(free.at_most.expect("stated").0, 20e-9);
    assert_eq!(job.unchecked.as_ref().map(Vec::len), Some(4));
}

#[test]
fn robot_cell_and_target_are_there() {
    let compiled = flat(&[("map", "flat.dat")]);
    let job = &compiled.jobs.first().expect("a job").job;
    let robot = job.robot.as_ref().expect("a robot");
    assert_eq!((robot.maker.as_str(), robot.model.as_str()), ("ABB", "IRB 6700-200/2.60"));
    let Arm::ortho_parallel(arm) = &robot.arm;
    near(arm.c3.0, 1.1425);
    near(arm.a2.0, -0.2);
    near(arm.offsets[2].0, -PI / 2.0);
    assert_eq!(arm.signs, [1.0; 6]);
    assert_eq!(robot.joints.len(), 6);
    near(robot.joints[1].range.from.0, -65.0 * PI / 180.0);
    near(robot.joints[3].speed.0, 190.0 * PI / 180.0);
    // Defaults of the schema.
    near(robot.wrist_margin.0, 5.0 * PI / 180.0);
    near(robot.shoulder_margin.0, 0.1);
    let cell = robot.cell.as_ref().expect("a cell");
    near(cell.user.at.x.0, 1.85042);
    near(cell.user.at.y.0, -0.0128);
    let Rotation::zyx_intrinsic(turn) = cell.user.rotation else { panic!("angles") };
    near(turn.about_y.0, -0.008 * PI / 180.0);
    assert_eq!(cell.tcp.load.mass, Mass(42.0));
    assert_eq!(cell.tcp.load.inertia, None);
    near(cell.home[4].0, 70.0 * PI / 180.0);
    assert_eq!(cell.safe_poses.len(), 1);
    // Changed by `with` inside `with`.
    near(cell.home_tolerance.0, PI / 180.0);
    let Process::signals(signals) = &cell.process else { panic!("signals") };
    assert_eq!(signals.outputs[1].name, "doMagnet");
    assert_eq!(signals.inputs[0].wait_at_most, Time(10.0));
    let Some(Target::rapid(rapid)) = &job.target else { panic!("a target") };
    assert_eq!((rapid.module.as_str(), rapid.zone, rapid.frames), ("Flat340", Zone::z0, Frames::on_controller));
    assert_eq!((rapid.controller.name_length, rapid.controller.module_bytes), (32, 500_000));
    near(rapid.controller.segment_time_least.0, 0.01);
}

#[test]
fn every_field_knows_its_line() {
    let compiled = flat(&[("map", "flat.dat")]);
    let job = compiled.jobs.first().expect("a job");
    let text = |field: &str| {
        let span = job.origins.find(field, |_| true).unwrap_or_else(|| panic!("no origin of {field}"));
        (compiled.sources.name(span.file).to_string(), compiled.sources.slice(span).to_string())
    };
    let here = |text: &str| ("jobs/flat.polish".to_string(), text.to_string());
    assert_eq!(text("path.line_pitch"), here("pitch"));
    assert_eq!(text("tool.speed"), here("60 rpm"));
    assert_eq!(text("dwell.feed.to"), here("100 mm/s"));
    assert_eq!(text("robot.cell.home_tolerance"), here("1 deg"));
    // A default has the place of the record that left it out.
    assert_eq!(text("workpiece.error.centre").1.lines().next(), Some("height_map {"));
    assert_eq!(text("robot.cell.process.outputs.1.name"), ("jobs/cell.polish".into(), "\"doMagnet\"".into()));
    assert_eq!(text("robot.joints.3.speed"), ("<std>/robots/abb/irb6700_200_260.polish".into(), "190 deg/s".into()));
    // A field that is not there is found at what is around it.
    assert_eq!(text("path.line_pitch.nothing"), here("pitch"));
    assert_eq!(text("nowhere"), here("flat_340"));
}

#[test]
fn requirements_wait_for_results_and_use_the_units_of_their_line() {
    let compiled = flat(&[("map", "flat.dat")]);
    let requirements = &compiled.jobs.first().expect("a job").requirements;
    assert_eq!(requirements.len(), 4);
    assert_eq!(requirements[0].text, "result.predicted.rms <= 1 wave / 60");
    assert_eq!(requirements[0].evaluate(&BTreeMap::new()).met, None);
    let mut results: BTreeMap<String, f64> = BTreeMap::new();
    // 632.8 nm / 60 = 10.547 nm: 10.5 nm is good, 10.6 nm is not. 6.328 nm is a hundredth of a wave.
    results.insert("predicted.rms".into(), 6.328e-9);
    let outcome = requirements[0].evaluate(&results);
    assert_eq!((outcome.value.as_deref(), outcome.met), (Some("1 wave / 100"), Some(true)));
    results.insert("predicted.rms".into(), 10.6e-9);
    assert_eq!(requirements[0].evaluate(&results).met, Some(false));
    results.insert("motion.time".into(), 5400.0);
    let outcome = requirements[1].evaluate(&results);
    assert_eq!((outcome.value.as_deref(), outcome.met), (Some("1.5 h"), Some(true)));
    results.insert("motion.joint_margin".into(), PI / 45.0);
    let outcome = requirements[2].evaluate(&results);
    assert_eq!((outcome.value.as_deref(), outcome.met), (Some("4 deg"), Some(false)));
    // One side of `and` decides while the other is pending.
    assert_eq!(
        requirements[3].results().into_iter().collect::<Vec<_>>(),
        ["motion.joint_speed_share", "predicted.removal.mean"]
    );
    results.insert("motion.joint_speed_share".into(), 0.95);
    assert_eq!(requirements[3].evaluate(&results).met, Some(false));
    results.insert("motion.joint_speed_share".into(), 0.5);
    assert_eq!(requirements[3].evaluate(&results).met, None);
    results.insert("predicted.removal.mean".into(), f64::NAN);
    assert_eq!(requirements[3].evaluate(&results).met, Some(false));
}

/// The values that schemas gave, by their paths.
fn defaults_of(path: &str, fields: &[ShownField], into: &mut BTreeMap<String, String>) {
    for field in fields {
        let path = if path.is_empty() { field.name.clone() } else { format!("{path}.{}", field.name) };
        match (&field.value, &field.said) {
            (Shown::Value(value), Said::Default { .. }) => drop(into.insert(path, value.clone())),
            (Shown::Record { fields, .. } | Shown::List(fields), _) => defaults_of(&path, fields, into),
            _ => {}
        }
    }
}

#[test]
fn params_are_set_and_shown() {
    let compiled = flat(&[("pitch", "0.4mm"), ("map", "\"a map.dat\"")]);
    let job = compiled.jobs.first().unwrap_or_else(|| panic!("{:?}", said(&compiled)));
    let Path::raster(raster) = &job.job.path else { panic!("no raster") };
    near(raster.line_pitch.0, 0.0004);
    let FormError::height_map(map) = &job.job.workpiece.error else { panic!("a height map") };
    assert_eq!(map.file, "a map.dat");
    let shown: Vec<(&str, &str)> = job.params.iter().map(|p| (p.name.as_str(), p.value.as_str())).collect();
    assert_eq!(shown, [("pitch", "0.4mm"), ("map", "\"a map.dat\"")]);
    assert_eq!(job.params[0].doc, "Distance between raster lines.");
    let mut defaults = BTreeMap::new();
    defaults_of("", &job.fields, &mut defaults);
    assert_eq!(defaults.get("robot.wrist_margin").map(String::as_str), Some("5 deg"));
    assert_eq!(defaults.get("path.direction").map(String::as_str), Some("0 deg"));
    assert!(!defaults.contains_key("robot.cell.home_tolerance"));
}

#[test]
fn wrong_sets_are_said() {
    for (sets, expected) in [
        (
            vec![("ptich", "0.4mm"), ("map", "m")],
            "E0214 `--set ptich`: the job has no `param ptich` | its parameters: `map` and `pitch` > did you mean `pitch`?",
        ),
        (
            vec![("pitch", "0.4 s"), ("map", "m")],
            "E0303 1:23 `pitch` expects a length, found a time | expected: Length | found:    Time > units that fit: `nm`, `um`, `mm` and `m`",
        ),
        (
            vec![("pitch", "0.4"), ("map", "m")],
            "E0302 1:23 `pitch` expects a length, found a plain number | units that fit: `nm`, `um`, `mm` and `m` > write `0.4 mm`",
        ),
        (vec![("pitch", "3 mm"), ("map", "m")], "E0404 1:23 `pitch` is 3 mm, and must be > 0 mm and <= 2 mm"),
        (vec![("pitch", "1 mm"), ("pitch", "1 mm"), ("map", "m")], "E0214 `--set pitch` is given twice > give it once"),
        (vec![], "E0215 14:7 the parameter `map` has no value > give it one: `--set map=…`"),
    ] {
        assert_eq!(said(&flat(&sets)), [expected], "{sets:?}");
    }
    let compiled = flat(&[("pitch", "1 mm\nlet x = 3"), ("map", "m")]);
    assert_eq!(said(&compiled).len(), 1, "{:?}", said(&compiled));
    assert!(compiled.jobs.is_empty());
}

#[test]
fn a_job_is_chosen_by_name() {
    let chosen = Options { job: Some("flat_340".into()), ..options(&[("map", "m")]) };
    assert_eq!(compile(&library(), "jobs/flat.polish", &chosen).jobs.len(), 1);
    let wrong = Options { job: Some("flat".into()), ..options(&[("map", "m")]) };
    assert_eq!(
        said(&compile(&library(), "jobs/flat.polish", &wrong)),
        ["E0213 the file has no job `flat` | its jobs: `flat_340`"]
    );
}

#[test]
fn a_value_of_another_dimension_does_not_become_a_newtype() {
    let span = Span::new(FileId(0), 0, 0);
    let second = Value::quantity(span, Quantity { value: 1.0, dimension: Dimension::TIME });
    assert_eq!(from_value::<Time>(&second), Ok(Time(1.0)));
    assert!(from_value::<Length>(&second).is_err());
    assert!(from_value::<f64>(&second).is_err());
    let half = Value::quantity(span, Quantity::number(0.5));
    assert_eq!(from_value::<f64>(&half), Ok(0.5));
    assert!(from_value::<i64>(&half).is_err());
    assert!(from_value::<Lines>(&Value { span, kind: ValueKind::Symbol("round".into()) }).is_err());
    assert_eq!(from_value::<Lines>(&Value { span, kind: ValueKind::Symbol("one_way".into()) }), Ok(Lines::one_way));
}

/// A job comes to the same with the part of stdlib that it names as with all of it.
#[test]
fn a_part_of_the_library_is_enough() {
    use polishc::check::load::Core;
    use polishc::eval::compile_with;
    struct Tree;
    impl polishc::source::FileProvider for Tree {
        #[allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]
        fn read(&self, path: &str, _: u64) -> Result<Vec<u8>, polishc::source::FileError> {
            std::fs::read(path)
                .or_else(|_| std::fs::read(format!("tests/ui/lib/{}", path.rsplit('/').next().unwrap_or(path))))
                .map_err(|_| polishc::source::FileError::NotFound)
        }
        fn resolve(&self, from: &str, path: &str) -> Result<String, polishc::source::FileError> {
            polishc::source::normalise(from, path).ok_or(polishc::source::FileError::Outside)
        }
    }
    let mut todo = vec![std::path::PathBuf::from("examples"), "tests/ui".into(), "tests/jobs".into()];
    let mut compared = 0;
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            todo.extend(std::fs::read_dir(&path).expect("a folder").map(|entry| entry.expect("an entry").path()));
            continue;
        }
        let name = path.to_string_lossy().into_owned();
        if !name.ends_with(".polish") {
            continue;
        }
        let part = compile_with(&Tree, &name, &Options::default(), Core::Needed);
        let whole = compile_with(&Tree, &name, &Options::default(), Core::Whole);
        let failed = |done: &Compiled| done.diagnostics.iter().any(|d| d.severity == Severity::Error);
        // What is wrong with the whole is never right with a part: then it would be missed.
        assert_eq!(failed(&part), failed(&whole), "{name}");
        if failed(&whole) {
            continue;
        }
        assert_eq!(said(&part), said(&whole), "{name}");
        let jobs = |done: &Compiled| -> Vec<String> {
            done.jobs.iter().map(|job| format!("{:?} {:?} {:?}", job.job, job.requirements, job.fields)).collect()
        };
        // Places of the library are the same, but its files may have other numbers.
        let strip = |jobs: Vec<String>| -> Vec<String> {
            jobs.into_iter()
                .map(|job| job.split("FileId(").map(|p| p.split_once(')').map_or(p, |(_, r)| r)).collect())
                .collect()
        };
        assert_eq!(strip(jobs(&part)), strip(jobs(&whole)), "{name}");
        compared += whole.jobs.len();
    }
    assert!(compared > 20, "only {compared} jobs without a mistake were compared");
}
