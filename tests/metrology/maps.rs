//! Maps put on the part by marks, turned, masked, and put together.

use crate::figures::grid;
use crate::workpiece::{at, circle, map, mm, part, rectangle};
use polishc::diagnostics::Problem;
use polishc::height_map::{Grid, npy};
use polishc::job::{
    Average, Despike, Difference, Direction, Fiducial, FormError, HeightMap, Mark, PixelAt, Place, Positive,
    Registration, Stitched, Term, View, Workpiece, ZernikeError, ZernikeOrder,
};
use polishc::job::{Empty, MapCentre};
use polishc::metrology::{self, ErrorMap};
use polishc::source::MemoryFiles;
use polishc::units::si::{Angle, Area, Length};
use std::collections::BTreeMap;

/// Files by name.
fn files(all: &[(&str, Vec<u8>)]) -> MemoryFiles {
    MemoryFiles(all.iter().map(|(name, bytes)| (name.to_string(), bytes.clone())).collect::<BTreeMap<_, _>>())
}

/// A picture in nanometres; `height` of the place in pixels to the right of its middle and above it.
fn picture(columns: usize, rows: usize, height: impl Fn(f64, f64) -> f64) -> Vec<u8> {
    let middle = [(columns as f64 - 1.0) / 2.0, (rows as f64 - 1.0) / 2.0];
    let values: Vec<f64> = (0..columns * rows)
        .map(|i| height((i % columns) as f64 - middle[0], middle[1] - (i / columns) as f64))
        .collect();
    npy::write(columns, &values).unwrap()
}

/// A map of nanometres with pixels of 1 mm.
fn asked(file: &str) -> HeightMap {
    HeightMap { file: file.into(), pixel: Some(mm(1.0)), unit: Some(Length(1e-9)), ..map() }
}

fn of(map: HeightMap) -> FormError {
    FormError::height_map(Box::new(map))
}

fn error_map(part: &Workpiece, files: &MemoryFiles) -> (Result<ErrorMap, Problem>, Vec<String>) {
    let mut warnings = Vec::new();
    let found = metrology::error_map(part, files, &mut warnings);
    (found, warnings.iter().map(|w| format!("{} {}", w.code, w.field.clone().unwrap_or_default())).collect())
}

fn refused(part: &Workpiece, files: &MemoryFiles) -> (String, String, String) {
    let problem = error_map(part, files).0.unwrap_err();
    (problem.code.to_string(), problem.field.unwrap_or_default(), problem.message)
}

/// The centre, in mm, of what stands more than half as high as the highest pixel, and that height in nm.
fn bump(grid: &Grid) -> [f64; 3] {
    let highest = grid.values.iter().copied().filter(|v| !v.is_nan()).fold(f64::NEG_INFINITY, f64::max);
    let (mut x, mut y, mut sum) = (0.0, 0.0, 0.0);
    for i in 0..grid.values.len() {
        let over = grid.values[i] - 0.5 * highest;
        if over > 0.0 {
            let at = grid.position(i / grid.columns, i % grid.columns);
            (x, y, sum) = (x + over * at[0], y + over * at[1], sum + over);
        }
    }
    [x / sum * 1e3, y / sum * 1e3, highest * 1e9]
}

/// The part's places in mm, of the bump and of three marks.
const BUMP: [f64; 2] = [11.0, 6.0];
const MARKS: [(&str, [f64; 2]); 3] = [("A", [20.0, 3.0]), ("B", [-4.0, 19.0]), ("C", [-15.0, -12.0])];

/// How a picture shows the part: where a place of the part, mm, lies to the right of the picture's middle and above it, in
/// pixels. By hand: the part is first turned by `turned` degrees from +x towards +y, then lies as `view` and `up`
/// say (tests/orientation.rs derives the eight), then is magnified and shifted.
struct Shown {
    view: View,
    up: Direction,
    turned: f64,
    /// Pixels a millimetre.
    scale: f64,
    shift: [f64; 2],
}

impl Shown {
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (s, c) = self.turned.to_radians().sin_cos();
        let (x, y) = (c * x - s * y, s * x + c * y);
        let tool_side = match self.up {
            Direction::plus_y => [x, y],
            Direction::plus_x => [-y, x],
            Direction::minus_y => [-x, -y],
            Direction::minus_x => [y, -x],
        };
        let right = if self.view == View::from_back { -tool_side[0] } else { tool_side[0] };
        [right * self.scale + self.shift[0], tool_side[1] * self.scale + self.shift[1]]
    }

    /// A round bump of 600 nm and 3 mm sigma on 80 x 70 pixels.
    fn picture(&self) -> Vec<u8> {
        let [u, v] = self.place(BUMP);
        let sigma = 3.0 * self.scale;
        picture(80, 70, |x, y| 600.0 * (-((x - u).powi(2) + (y - v).powi(2)) / (2.0 * sigma * sigma)).exp())
    }

    /// The marks as a person reads them off: column and row.
    fn marks(&self) -> Vec<Mark> {
        let mark = |(name, place): (&str, [f64; 2])| {
            let [u, v] = self.place(place);
            Mark { name: name.into(), column: 39.5 + u, row: 34.5 - v }
        };
        MARKS.into_iter().map(mark).collect()
    }
}

fn fiducials() -> Option<Vec<Fiducial>> {
    let fiducial = |(name, [x, y]): (&str, [f64; 2])| Fiducial { name: name.into(), at: Place { x: mm(x), y: mm(y) } };
    Some(MARKS.into_iter().map(fiducial).collect())
}

fn with_marks(marks: Vec<Mark>, more: HeightMap) -> Workpiece {
    let registration = Registration { marks, within: mm(0.05) };
    let error = of(HeightMap { fiducials: Some(registration), ..more });
    Workpiece { fiducials: fiducials(), error, ..part(circle(54.0, None), circle(44.0, None)) }
}

const EIGHT: [(View, Direction); 8] = [
    (View::from_tool_side, Direction::plus_y),
    (View::from_tool_side, Direction::plus_x),
    (View::from_tool_side, Direction::minus_y),
    (View::from_tool_side, Direction::minus_x),
    (View::from_back, Direction::plus_y),
    (View::from_back, Direction::plus_x),
    (View::from_back, Direction::minus_y),
    (View::from_back, Direction::minus_x),
];

#[test]
fn marks_put_the_map_on_the_part_in_all_orientations() {
    let odd = [3.7, -11.3, 7.1, -2.9, 13.9, -8.3, 0.0, 5.5];
    for ((view, up), turned) in EIGHT.into_iter().zip(odd) {
        // The pixel is 2 % smaller than stated, and the part lies beside the middle.
        let shown = Shown { view, up, turned, scale: 1.02, shift: [3.4, -2.2] };
        let files = files(&[("map.npy", shown.picture())]);
        let part = with_marks(shown.marks(), HeightMap { view, up, ..asked("map.npy") });
        let (found, warnings) = error_map(&part, &files);
        let found = found.unwrap_or_else(|problem| panic!("{view:?} {up:?} {turned}: {}", problem.message));
        assert!(warnings.is_empty(), "{warnings:?}");
        let [x, y, height] = bump(&found.grid);
        // A hundredth of a pixel, and what the interpolation loses of the peak.
        assert!((x - 11.0).abs() < 0.01 && (y - 6.0).abs() < 0.01, "{view:?} {up:?} {turned}: {x} {y}");
        assert!((height - 600.0).abs() < 3.0, "{height}");
        let registered = found.record.maps[0].registered.as_ref().unwrap();
        assert!((registered.similarity.scale - 1.0 / 1.02).abs() < 1e-9);
        // The part was turned one way, so the map is turned back; seen from behind the way is the same, about the part's z.
        assert!((registered.turned.to_degrees() + turned).abs() < 1e-6, "{}", registered.turned.to_degrees());
        assert!(registered.residual_max < 1e-12 && registered.marks == 3);
    }
}

#[test]
fn a_turn_that_is_said_needs_no_marks() {
    for ((view, up), turned) in EIGHT.into_iter().zip([90.0, 33.0, -90.0, 180.0, 71.0, 270.0, -147.0, 5.0]) {
        let shown = Shown { view, up, turned, scale: 1.0, shift: [0.0; 2] };
        let files = files(&[("map.npy", shown.picture())]);
        let said = HeightMap { view, up, rotated: Some(Angle(turned.to_radians())), ..asked("map.npy") };
        let whole = Workpiece { error: of(said.clone()), ..part(circle(54.0, None), circle(44.0, None)) };
        let [x, y, _] = bump(&error_map(&whole, &files).0.unwrap().grid);
        assert!((x - 11.0).abs() < 0.01 && (y - 6.0).abs() < 0.01, "{view:?} {up:?} {turned}: {x} {y}");
        // With marks the same words are proved.
        let marked = with_marks(shown.marks(), said);
        let found = error_map(&marked, &files).0.unwrap();
        assert!(found.record.maps[0].registered.as_ref().unwrap().turned.abs() < 1e-9);
    }
}

#[test]
fn marks_prove_view_and_up() {
    // All eight pictures against all eight words: only the true ones pass. The other side is a mirror image, another quarter
    // on the same side a turn.
    for (view, up) in EIGHT {
        let shown = Shown { view, up, turned: 2.0, scale: 1.0, shift: [0.0; 2] };
        let files = files(&[("map.npy", shown.picture())]);
        for (said_view, said_up) in EIGHT {
            let part = with_marks(shown.marks(), HeightMap { view: said_view, up: said_up, ..asked("map.npy") });
            let expected = match ((said_view, said_up) == (view, up), said_view == view) {
                (true, _) => {
                    assert!(error_map(&part, &files).0.is_ok());
                    continue;
                }
                (false, true) => ("E0533", "workpiece.error.up"),
                (false, false) => ("E0532", "workpiece.error.view"),
            };
            let problem = error_map(&part, &files).0.unwrap_err();
            assert_eq!((problem.code.as_str(), problem.field.as_deref().unwrap()), expected);
            if said_view == view {
                // The mend that it names passes.
                assert_eq!(problem.help.unwrap(), format!("`up: {up:?}` would fit"));
            }
        }
    }
}

#[test]
fn marks_that_do_not_decide_are_refused() {
    let shown = Shown { view: View::from_tool_side, up: Direction::plus_y, turned: 0.0, scale: 1.0, shift: [0.0; 2] };
    let files = files(&[("map.npy", shown.picture())]);
    let of_marks = |marks: Vec<Mark>| with_marks(marks, asked("map.npy"));
    let two = of_marks(shown.marks()[..2].to_vec());
    assert_eq!(refused(&two, &files).2, "two marks are seen; a map needs three to be placed by");
    // On a line: the mirror image fits as well. Four marks in a row are no better than three.
    let line = [("A", [-20.0, -10.0]), ("B", [0.0, 0.0]), ("C", [10.0, 5.0])];
    let mut part = of_marks(
        line.iter().map(|(name, [x, y])| Mark { name: name.to_string(), column: 39.5 + x, row: 34.5 - y }).collect(),
    );
    part.fiducials = Some(
        line.iter()
            .map(|(name, [x, y])| Fiducial { name: name.to_string(), at: Place { x: mm(*x), y: mm(*y) } })
            .collect(),
    );
    let (code, _, message) = refused(&part, &files);
    assert!(code == "E0530" && message.contains("too nearly on a line"), "{message}");
    // A mark that was read off 0.3 mm wrong leaves 0.130 mm there and less at the others (by numpy).
    let mut marks = shown.marks();
    marks[1].column += 0.3;
    let (code, field, message) = refused(&of_marks(marks.clone()), &files);
    assert_eq!((code.as_str(), field.as_str()), ("E0531", "workpiece.error.fiducials"));
    assert!(message.contains("`B` lies 0.130 mm"), "{message}");
    // A wider limit takes it, and says what is left.
    let mut wider = of_marks(marks);
    let FormError::height_map(asked) = &mut wider.error else { panic!() };
    asked.fiducials.as_mut().unwrap().within = mm(0.3);
    let found = error_map(&wider, &files).0.unwrap();
    assert!(found.record.maps[0].registered.as_ref().unwrap().residual_max > 0.1e-3);
    // All at one place; a name that the part does not have; a name twice.
    let mut marks = shown.marks();
    marks.iter_mut().for_each(|mark| (mark.column, mark.row) = (30.0, 30.0));
    let (code, field, message) = refused(&of_marks(marks), &files);
    assert_eq!((code.as_str(), field.as_str()), ("E0530", "workpiece.error.fiducials"));
    assert_eq!(message, "all marks lie at one place of the picture");
    let mut marks = shown.marks();
    marks[2].name = "Z".into();
    assert_eq!(refused(&of_marks(marks.clone()), &files).1, "workpiece.error.fiducials.marks.2.name");
    marks[2].name = "A".into();
    assert_eq!(refused(&of_marks(marks), &files).1, "workpiece.error.fiducials.marks.2.name");
    let mut named_twice = of_marks(shown.marks());
    let first = named_twice.fiducials.as_ref().unwrap()[0].clone();
    named_twice.fiducials.as_mut().unwrap().push(first);
    assert_eq!(refused(&named_twice, &files).2, "the part has two marks that are called `A`");
    // Pixels of 1.1 mm that were stated as 1 mm.
    let smaller = Shown { scale: 1.0 / 1.1, ..shown };
    let (code, field, message) = refused(&with_marks(smaller.marks(), asked_map()), &files);
    assert_eq!((code.as_str(), field.as_str()), ("E0534", "workpiece.error.pixel"));
    assert!(message.contains("1.100000 mm x 1.100000 mm, +10.0 %"), "{message}");
}

fn asked_map() -> HeightMap {
    asked("map.npy")
}

#[test]
fn what_is_masked_trimmed_and_left_out_does_not_count() {
    // Everything is zero but three bad pixels of 1000 nm: one under the mask, one near the rim of a disc of 25 mm radius, one
    // under an area that is left out.
    let bad = |x: f64, y: f64| [(3.5, 2.5), (23.5, 0.5), (-9.5, 4.5)].contains(&(x, y));
    let map = picture(60, 60, |x, y| {
        if x * x + y * y > 625.0 {
            f64::NAN
        } else if bad(x, y) {
            1000.0
        } else {
            0.0
        }
    });
    let mask = picture(60, 60, |x, y| if (x, y) == (3.5, 2.5) { 0.0 } else { 1.0 });
    let files = files(&[("map.npy", map), ("mask.npy", mask)]);
    let words = HeightMap {
        mask: Some("mask.npy".into()),
        trim: Some(mm(3.0)),
        leave_out: Some(vec![circle(3.0, at(-9.5, 4.5))]),
        fill_below: Some(Area(10e-6)),
        ..asked("map.npy")
    };
    let whole = Workpiece { error: of(words), ..part(circle(60.0, None), circle(42.0, None)) };
    let (found, warnings) = error_map(&whole, &files);
    let found = found.unwrap();
    assert_eq!(found.after.pv, 0.0);
    let record = &found.record.maps[0];
    assert_eq!(record.masked, 1);
    // The rim of 3 pixels' width: about pi (25² - 22²) = 443 pixels.
    assert!((400..=500).contains(&record.trimmed), "{}", record.trimmed);
    // The masked pixel and the nine of the left-out disc are filled.
    assert_eq!((found.filled_holes, found.filled_pixels), (2, 10));
    assert_eq!(warnings, ["W0500 workpiece.error.fill_below"]);
    // Without one of the words its bad pixel is seen.
    for (change, height) in [("mask", 1000.0), ("leave_out", 1000.0)] {
        let FormError::height_map(mut words) = whole.error.clone() else { panic!() };
        match change {
            "mask" => words.mask = None,
            _ => words.leave_out = None,
        }
        let part = Workpiece { error: FormError::height_map(words), ..whole.clone() };
        let found = error_map(&part, &files).0.unwrap();
        assert!((found.after.pv * 1e9 - height).abs() < 1e-6, "{change}");
    }
}

#[test]
fn spikes_are_taken_out_and_counted() {
    let wave =
        |x: f64, y: f64| 50.0 * (x / 9.0).sin() * (y / 11.0).cos() + ((x * 7.0 + y * 3.0) as i64 % 5) as f64 * 0.1;
    let spikes = [(3.5, 2.5), (-11.5, 8.5), (-12.5, 8.5)];
    let map = picture(60, 60, |x, y| wave(x, y) + if spikes.contains(&(x, y)) { 90.0 } else { 0.0 });
    let files = files(&[("map.npy", map), ("clean.npy", picture(60, 60, wave))]);
    let words = |file: &str| HeightMap {
        despike: Some(Despike { above: 12.0, reach: 2 }),
        fill_below: Some(Area(3e-6)),
        ..asked(file)
    };
    let whole = |file: &str| Workpiece { error: of(words(file)), ..part(circle(58.0, None), circle(50.0, None)) };
    let found = error_map(&whole("map.npy"), &files).0.unwrap();
    assert_eq!((found.record.maps[0].spikes, found.filled_pixels), (3, 3));
    let clean = error_map(&whole("clean.npy"), &files).0.unwrap();
    assert_eq!(clean.record.maps[0].spikes, 0);
    // What the rim says of the three pixels is the surface to a few nanometres.
    for (a, b) in found.grid.values.iter().zip(&clean.grid.values) {
        assert!(a.is_nan() == b.is_nan() && (a.is_nan() || (a - b).abs() < 3e-9));
    }
    // Without `fill_below` a spike is a hole.
    let FormError::height_map(mut open) = whole("map.npy").error else { panic!() };
    open.fill_below = None;
    let part = Workpiece { error: FormError::height_map(open), ..whole("map.npy") };
    assert_eq!(refused(&part, &files).0, "E0510");
}

#[test]
fn higher_orders_go_and_what_is_not_named_stays() {
    // On a square, where Zernike polynomials are not orthogonal: astigmatism along x and y, coma along x, and a wave.
    let r2 = |x: f64, y: f64| (x * x + y * y) / 900.0;
    let saddle = |x: f64, y: f64| 40.0 * (x * x - y * y) / 900.0;
    let coma = |x: f64, y: f64| 25.0 * (3.0 * r2(x, y) - 2.0) * x / 30.0;
    let files = files(&[("map.npy", picture(61, 61, |x, y| 5.0 + 0.3 * x + saddle(x, y) + coma(x, y)))]);
    let whole = |terms: &[Term]| Workpiece {
        error: of(HeightMap { subtract: terms.to_vec(), ..asked("map.npy") }),
        ..part(rectangle(61.0, 61.0, None), rectangle(60.9, 60.9, None))
    };
    let with = |terms: &[Term]| error_map(&whole(terms), &files).0.unwrap();
    // All of it is within eleven terms, whose coefficients are rounded to 1e-15 m; they reach 29 at the corners.
    use Term::{astigmatism, coma as comatic, piston, power, spherical, tilt, trefoil};
    let all = with(&[piston, tilt, power, astigmatism, comatic, trefoil, spherical]);
    assert!(all.after.pv < 1e-13, "{}", all.after.pv);
    // The saddle alone is what is left when all but astigmatism are taken off: on a square it is orthogonal to all lower ones.
    let left = with(&[piston, tilt, power, comatic, trefoil, spherical]);
    let plain = grid(61, 61, [1e-3; 2], |x, y| saddle(x * 1e3, y * 1e3) * 1e-9);
    for (found, expected) in left.grid.values.iter().zip(&plain.values) {
        assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    }
    // Astigmatism alone takes the saddle, and keeps mean, plane and coma.
    let taken = with(&[astigmatism]);
    let rest = grid(61, 61, [1e-3; 2], |x, y| (5.0 + 300.0 * x + coma(x * 1e3, y * 1e3)) * 1e-9);
    for (found, expected) in taken.grid.values.iter().zip(&rest.values) {
        assert!((found - expected).abs() < 1e-13, "{found} {expected}");
    }
    // RMS of the saddle: x² - y² over 61 x 61 points of step 1: variance 2 (n² - 1)(n² - 4)/180.
    let n2 = 61.0 * 61.0;
    let expected = 40.0 / 900.0 * (2.0 * (n2 - 1.0) * (n2 - 4.0) / 180.0_f64).sqrt();
    assert!((taken.removed.aberrations * 1e9 - expected).abs() < 1e-5, "{} {expected}", taken.removed.aberrations);
}

#[test]
fn a_reference_is_taken_off() {
    let glass = |x: f64, y: f64| 80.0 * (-(x * x + (y - 5.0) * (y - 5.0)) / 128.0).exp();
    let flat = |x: f64, y: f64| 0.05 * x * y - 7.0;
    let files = files(&[
        ("map.npy", picture(60, 60, |x, y| glass(x, y) + flat(x, y))),
        ("flat.npy", picture(60, 60, flat)),
        // The same reference with pixels of 1.5 mm, and one that covers 30 mm.
        ("coarse.npy", picture(41, 41, |x, y| flat(1.5 * x, 1.5 * y))),
        ("small.npy", picture(30, 30, flat)),
        ("holed.npy", picture(60, 60, |x, y| if x * x + y * y < 9.0 { f64::NAN } else { 0.0 })),
    ]);
    let whole = |minus: HeightMap| Workpiece {
        error: FormError::difference(Box::new(Difference { of: of(asked("map.npy")), minus: of(minus) })),
        ..part(circle(50.0, None), circle(46.0, None))
    };
    let alone = grid(60, 60, [1e-3; 2], |x, y| glass(x * 1e3, y * 1e3) * 1e-9);
    for minus in [asked("flat.npy"), HeightMap { pixel: Some(mm(1.5)), ..asked("coarse.npy") }] {
        let found = error_map(&whole(minus), &files).0.unwrap();
        for (found, expected) in found.grid.values.iter().zip(&alone.values).filter(|(found, _)| !found.is_nan()) {
            // xy is reproduced by the interpolation exactly.
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
        assert_eq!(found.record.maps.len(), 2);
    }
    let (code, field, _) = refused(&whole(asked("small.npy")), &files);
    assert_eq!((code.as_str(), field.as_str()), ("E0509", "workpiece.error.minus.file"));
    // What the reference does not know, the difference does not know.
    assert_eq!(refused(&whole(asked("holed.npy")), &files).0, "E0510");
    // Only the map itself is made void by a run.
    let measured: Vec<String> =
        whole(asked("flat.npy")).error.measurements().iter().map(|map| map.file.clone()).collect();
    assert_eq!(measured, ["map.npy"]);
    assert_eq!(whole(asked("flat.npy")).error.files(), ["map.npy", "flat.npy"]);
}

#[test]
fn turned_maps_average_to_the_part() {
    // The glass has a bump; the instrument adds an error of its own that stays in the picture: averaged over four quarter turns
    // a slope over the picture vanishes, while the bump stays where it is.
    let turns = [0.0, 90.0, 180.0, 270.0];
    let names = ["0.npy", "1.npy", "2.npy", "3.npy"];
    let made: Vec<(&str, Vec<u8>)> = turns
        .iter()
        .zip(names)
        .map(|(turned, name)| {
            let shown = Shown {
                view: View::from_tool_side,
                up: Direction::plus_y,
                turned: *turned,
                scale: 1.0,
                shift: [0.0; 2],
            };
            let [u, v] = shown.place(BUMP);
            let lost = |x: f64, y: f64| *turned == 90.0 && (x - u).powi(2) + (y - v).powi(2) < 4.0;
            let bytes = picture(61, 61, |x, y| {
                let bump = 600.0 * (-((x - u).powi(2) + (y - v).powi(2)) / 18.0).exp();
                if lost(x, y) { f64::NAN } else { bump + 2.0 * x - 3.0 * y }
            });
            (name, bytes)
        })
        .collect();
    let files = files(&made);
    let one = |(turned, name): (&f64, &str)| of(HeightMap { rotated: Some(Angle(turned.to_radians())), ..asked(name) });
    let all: Vec<FormError> = turns.iter().zip(names).map(one).collect();
    let whole = Workpiece {
        error: FormError::average(Average { of: all.clone() }),
        ..part(circle(56.0, None), circle(50.0, None))
    };
    let found = error_map(&whole, &files).0.unwrap();
    let [x, y, _] = bump(&found.grid);
    assert!((x - 11.0).abs() < 0.05 && (y - 6.0).abs() < 0.05, "{x} {y}");
    // Away from the dust of the second map all four know the surface, and the slopes cancel.
    let at = |x: f64, y: f64| {
        let i = (0..found.grid.values.len()).find(|i| {
            let [px, py] = found.grid.position(i / found.grid.columns, i % found.grid.columns);
            (px - x * 1e-3).abs() < 1e-9 && (py - y * 1e-3).abs() < 1e-9
        });
        found.grid.values[i.unwrap()] * 1e9
    };
    let glass = |x: f64, y: f64| 600.0 * (-((x - 11.0_f64).powi(2) + (y - 6.0_f64).powi(2)) / 18.0).exp();
    for (x, y) in [(0.0, 0.0), (-12.0, 7.0), (20.0, -9.0), (5.0, 6.0)] {
        assert!((at(x, y) - glass(x, y)).abs() < 1e-9, "{x} {y}: {}", at(x, y));
    }
    // Where the second map is blind the other three say 2x - 3y, minus that, and 3x + 2y the other way: their mean is a third of
    // what the second one's slope would have taken away, (3 x + 2 y) / 3 up to its sign.
    let off = at(11.0, 6.0) - 600.0;
    assert!((off.abs() - (3.0 * 11.0 + 2.0 * 6.0) / 3.0).abs() < 1e-9, "{off}");
    // One map differs from their mean by its slope: at a place with the distance r the four are ± and ± of two numbers
    // a, b with a² + b² = 13 r², so their variance is 2 (a² + b²) / 3; the mean of r² over a disc of 28 mm radius, to
    // which the part reaches, is 392 mm².
    let expected = (2.0 * 13.0 * 392.0 / 3.0_f64).sqrt();
    assert!((found.record.spread.unwrap() * 1e9 - expected).abs() < 0.01 * expected, "{:?}", found.record.spread);
    let single = Workpiece { error: FormError::average(Average { of: all[..1].to_vec() }), ..whole.clone() };
    assert_eq!(refused(&single, &files).0, "E0544");
}

#[test]
fn pieces_are_levelled_and_stitched() {
    // A part of 100 x 40 mm, seen in three pictures of 44 mm width, each with a piston and a tilt of its own, and one turned.
    let glass = |x: f64, y: f64| 30.0 * (x / 14.0).sin() + 12.0 * (y / 8.0).cos() + 0.02 * x * y;
    let centres = [-28.0, 0.0, 28.0];
    let made: Vec<(&str, Vec<u8>)> = ["l.npy", "m.npy", "r.npy"]
        .into_iter()
        .zip(centres)
        .enumerate()
        .map(|(k, (name, middle))| {
            let k = k as f64;
            let bytes = picture(45, 45, |u, v| {
                // The middle picture was taken with the part turned by 90 degrees: the part's x runs upwards.
                let (x, y) = if k == 1.0 { (v, -u) } else { (u, v) };
                glass(x + middle, y) + 100.0 * k + 5.0 * (k - 1.0) * u - 3.0 * k * v
            });
            (name, bytes)
        })
        .collect();
    let files = files(&made);
    let piece = |file: &str, middle: f64| HeightMap {
        centre: MapCentre::pixel_at(PixelAt { column: 22.0 - middle, row: 22.0 }),
        ..asked(file)
    };
    let pieces = [
        piece("l.npy", -28.0),
        // Its origin stands in its middle.
        HeightMap {
            rotated: Some(Angle(90_f64.to_radians())),
            centre: MapCentre::frame_centre(Empty {}),
            ..asked("m.npy")
        },
        piece("r.npy", 28.0),
    ];
    let stitched = |pieces: &[HeightMap], mismatch: f64| Workpiece {
        error: FormError::stitched(Stitched {
            maps: pieces.iter().cloned().map(of).collect(),
            subtract: vec![Term::piston, Term::tilt],
            mismatch: Length(mismatch * 1e-9),
        }),
        ..part(rectangle(100.0, 44.0, None), rectangle(98.0, 40.0, None))
    };
    let found = error_map(&stitched(&pieces, 0.001), &files).0.unwrap();
    assert_eq!((found.grid.columns, found.grid.rows), (101, 45));
    // The same glass seen in one picture, detilted over the same aperture.
    let one = picture(101, 45, glass);
    let single = Workpiece {
        error: of(HeightMap { subtract: vec![Term::piston, Term::tilt], ..asked("one.npy") }),
        ..stitched(&pieces, 0.001)
    };
    let whole = error_map(&single, &self::files(&[("one.npy", one)])).0.unwrap();
    for (i, (a, b)) in found.grid.values.iter().zip(&whole.grid.values).enumerate() {
        assert!(a.is_nan() == b.is_nan() && (a.is_nan() || (a - b).abs() < 1e-15), "{i}: {a} {b}");
    }
    let [stitch] = found.record.stitched.as_slice() else { panic!("{:?}", found.record.stitched) };
    let seams = &stitch.seams;
    assert_eq!(seams.iter().map(|seam| seam.pieces).collect::<Vec<_>>(), [[0, 1], [1, 2]]);
    // 17 columns are common, of 45 rows, less what the part's edge leaves: 43.
    assert!(seams.iter().all(|seam| seam.rms < 1e-15 && (17 * 43..=17 * 45).contains(&seam.pixels)), "{seams:?}");

    // The whole keeps the slope of the first picture, -5 nm a millimetre along x about x = -28 mm, which `subtract` takes off beside
    // what it takes off the glass: at x = 0, the middle of the aperture, that is a piston of -140 nm.
    assert_eq!(stitch.field, "workpiece.error");
    let [more, glass] = [&stitch.removed, &whole.removed];
    assert!((more.tilt[0] - glass.tilt[0] + 5e-6).abs() < 1e-13, "{more:?} {glass:?}");
    assert!((more.tilt[1] - glass.tilt[1]).abs() < 1e-13, "{more:?} {glass:?}");
    assert!((more.piston - glass.piston + 140e-9).abs() < 1e-15, "{more:?} {glass:?}");

    // One piece two pixels beside its place: the difference (0.075 nm RMS over the fifteen common columns without piston
    // and tilt, by NumPy) is seen, and named.
    let mut aside = pieces.clone();
    aside[2] = piece("r.npy", 30.0);
    let (code, field, message) = refused(&stitched(&aside, 0.05), &files);
    assert_eq!((code.as_str(), field.as_str()), ("E0536", "workpiece.error.mismatch"));
    assert!(message.starts_with("maps 2 and 3 differ by"), "{message}");
    // Too far away to touch.
    let mut away = pieces.clone();
    away[2] = piece("r.npy", 60.0);
    let (code, field, _) = refused(&stitched(&away, 0.5), &files);
    assert_eq!((code.as_str(), field.as_str()), ("E0535", "workpiece.error.maps.2"));
    // Without the last piece the clear aperture is not covered.
    assert_eq!(refused(&stitched(&pieces[..2], 0.5), &files).0, "E0509");
}

#[test]
fn an_error_may_be_known_as_polynomials_and_a_target_wanted() {
    // 100 nm of Fringe 4, 2 r² - 1 over 25 mm, standing low: -100 in the middle... is +100 with `positive: low`.
    let polynomials = ZernikeError {
        positive: Positive::low,
        radius: mm(25.0),
        order: ZernikeOrder::fringe,
        coefficients: vec![Length(0.0), Length(0.0), Length(0.0), Length(100e-9)],
        pixel: mm(1.0),
    };
    let whole = Workpiece {
        error: FormError::zernike_error(polynomials.clone()),
        ..part(circle(50.0, None), circle(46.0, None))
    };
    let nothing = MemoryFiles::default();
    let found = error_map(&whole, &nothing).0.unwrap();
    let expected = |x: f64, y: f64| 100e-9 * (1.0 - 2.0 * (x * x + y * y) / 0.000_625);
    for i in (0..found.grid.values.len()).filter(|i| !found.grid.values[*i].is_nan()) {
        let [x, y] = found.grid.position(i / found.grid.columns, i % found.grid.columns);
        assert!((found.grid.values[i] - expected(x, y)).abs() < 1e-20);
    }
    assert!(whole.error.measurements().is_empty());
    // Wanted is that very departure: nothing is left to do.
    let reached = Workpiece { target: Some(whole.error.clone()), ..whole.clone() };
    assert!(error_map(&reached, &nothing).0.unwrap().after.pv < 1e-20);
    // Wanted is twice as much: what stands there is as much too low in the middle.
    let more = ZernikeError {
        coefficients: polynomials.coefficients.iter().map(|a| Length(2.0 * a.0)).collect(),
        ..polynomials
    };
    let wanted = Workpiece { target: Some(FormError::zernike_error(more)), ..whole };
    let left = error_map(&wanted, &nothing).0.unwrap();
    let middle = left.grid.values[left.grid.values.len() / 2];
    assert!((middle + 100e-9).abs() < 1e-20, "{middle}");
    assert!((left.after.rms - found.after.rms).abs() < 1e-20);
}

#[test]
fn a_hole_is_refused_in_the_map_that_has_it() {
    // In one of the pictures nine pixels of the middle are unknown.
    let files = files(&[
        ("whole.npy", picture(61, 61, |x, _| x)),
        ("holed.npy", picture(61, 61, |x, y| if x.abs() < 2.0 && y.abs() < 2.0 { f64::NAN } else { x })),
    ]);
    let [whole, holed] = ["whole.npy", "holed.npy"].map(|file| of(asked(file)));
    let with = |error: FormError| Workpiece { error, ..part(circle(50.0, None), circle(40.0, None)) };
    let average = |of: &[&FormError]| FormError::average(Average { of: of.iter().map(|map| (*map).clone()).collect() });
    let difference = |of: &FormError, minus: &FormError| {
        FormError::difference(Box::new(Difference { of: of.clone(), minus: minus.clone() }))
    };
    let stitched = FormError::stitched(Stitched {
        maps: vec![holed.clone(), holed.clone()],
        subtract: Vec::new(),
        mismatch: Length(1e-9),
    });
    for (error, field) in [
        (holed.clone(), "workpiece.error.fill_below"),
        (average(&[&whole, &holed, &holed]), "workpiece.error.of.1.fill_below"),
        (average(&[&whole, &average(&[&holed, &holed]), &holed]), "workpiece.error.of.1.fill_below"),
        (difference(&holed, &whole), "workpiece.error.of.fill_below"),
        (difference(&whole, &holed), "workpiece.error.minus.fill_below"),
        (difference(&whole, &average(&[&whole, &holed, &holed])), "workpiece.error.minus.of.1.fill_below"),
        (stitched, "workpiece.error.maps.0.fill_below"),
    ] {
        let (code, found, message) = refused(&with(error), &files);
        assert_eq!((code.as_str(), found.as_str()), ("E0510", field), "{message}");
        assert!(message.starts_with("the map has a hole of 9.000 mm^2 (9 pixels)"), "{message}");
    }
    let target = Workpiece { target: Some(holed.clone()), ..with(whole.clone()) };
    assert_eq!(refused(&target, &files).1, "workpiece.target.fill_below");
    // Where half of the maps know the place, there is no hole.
    assert!(error_map(&with(average(&[&whole, &holed])), &files).0.is_ok());
}

#[test]
fn what_is_taken_off_on_other_pixels_may_end_a_pixel_sooner() {
    // The clear aperture is the whole part. 60 x 60 pixels have their centres on half millimetres, polynomials theirs on whole ones.
    // Fringe 4 over 25 mm, 2 r² - 1, is a parabola, which cubic convolution keeps exactly.
    let bowl = |x: f64, y: f64| 100.0 * (2.0 * (x * x + y * y) / 625.0 - 1.0);
    let files = files(&[
        ("map.npy", picture(60, 60, |x, y| bowl(x, y) + 7.0)),
        ("other.npy", picture(61, 61, bowl)),
        ("same.npy", picture(60, 60, bowl)),
    ]);
    let polynomials = FormError::zernike_error(ZernikeError {
        positive: Positive::high,
        radius: mm(25.0),
        order: ZernikeOrder::fringe,
        coefficients: vec![Length(0.0), Length(0.0), Length(0.0), Length(100e-9)],
        pixel: mm(1.0),
    });
    let with = |minus: &FormError, clear: f64| {
        let both = Difference { of: of(asked("map.npy")), minus: minus.clone() };
        Workpiece { error: FormError::difference(Box::new(both)), ..part(circle(50.0, None), circle(clear, None)) }
    };
    let all_seven = |part: &Workpiece| {
        let found = error_map(part, &files).0.unwrap();
        for (i, value) in found.grid.values.iter().enumerate() {
            let [x, y] = found.grid.position(i / found.grid.columns, i % found.grid.columns);
            assert_eq!(value.is_nan(), x * x + y * y > 25e-3 * 25e-3, "{x} {y}");
            assert!(value.is_nan() || (value * 1e9 - 7.0).abs() < 1e-9, "{x} {y}: {value}");
        }
    };
    // Polynomials are known up to the edge on any pixels, whether they are taken off or wanted.
    all_seven(&with(&polynomials, 50.0));
    let wanted =
        Workpiece { error: of(asked("map.npy")), target: Some(polynomials.clone()), ..with(&polynomials, 50.0) };
    all_seven(&wanted);
    // So is a picture on the same pixels. One on others has glass only up to its last pixel inside the edge.
    all_seven(&with(&of(asked("same.npy")), 50.0));
    let other = of(asked("other.npy"));
    let (code, field, message) = refused(&with(&other, 50.0), &files);
    assert_eq!((code.as_str(), field.as_str()), ("E0509", "workpiece.error.minus"), "{message}");
    // No pixel's centre lies farther from its neighbours than its diagonal, 1.4 mm: 1.5 mm farther in nothing is lost.
    assert!(error_map(&with(&other, 47.0), &files).0.is_ok());
}
