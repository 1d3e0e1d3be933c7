//! Orientation: one bump, off the axis, in every way in which a map can be turned, mirrored and negated, must be dwelt
//! on where it is in the robot's world.
//!
//! The slowest feed of the emitted program text, replayed by a small reader of the test, must lie over the bump: the
//! place in the text's own object frame goes through the text's own `uframe` and `oframe` into the world, and is compared
//! with the bump's place in the part, taken into the world by the job's frames. No code of the crate takes part
//! between the text and the verdict. The tolerance is one pixel of the map, 1 mm.
//!
//! The bump is positive glass, 600 nm high, at x +11 mm, y +6 mm of the part. The part's +z points out of the glass at
//! the tool. Where the bump lies in the picture is derived by hand:
//!
//! * Seen from the tool side, +z points at the eye, as on a sheet of paper: with +y up, +x is on the right. Turned on
//!   the table until +x is up, +y is on the left (a quarter turn against the clock); until -y is up, -x is on the
//!   right; until -x is up, +y is on the right.
//! * Seen from the back, through the glass, +z points away from the eye. What is up stays up, left and right change
//!   places: with +y up, +x is on the left; with +x up, +y is on the right; with -y up, +x is on the right; with -x up, +y
//!   is on the left.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

mod replay;

use replay::forms::FORMS;
use replay::program_text::ProgramText;
use replay::rigid::distance;
use replay::{ASKEW, KRL, compile, compile_with, job_text, npy, program_text, world_part};

/// Place of the bump in the part, mm.
const BUMP: [f64; 2] = [11.0, 6.0];

/// One pixel, mm.
const PIXEL: f64 = 1.0;

/// `view`, `up`, and the bump's place in the picture: mm to the right of the middle and above it.
const ORIENTATIONS: [(&str, &str, [f64; 2]); 8] = [
    ("from_tool_side", "plus_y", [11.0, 6.0]),
    // Up is +x: 11 above. Right is -y: 6 to the left.
    ("from_tool_side", "plus_x", [-6.0, 11.0]),
    // Up is -y: 6 below. Right is -x: 11 to the left.
    ("from_tool_side", "minus_y", [-11.0, -6.0]),
    // Up is -x: 11 below. Right is +y: 6 to the right.
    ("from_tool_side", "minus_x", [6.0, -11.0]),
    // Right is -x.
    ("from_back", "plus_y", [-11.0, 6.0]),
    // Up is +x, right is +y.
    ("from_back", "plus_x", [6.0, 11.0]),
    // Up is -y, right is +x.
    ("from_back", "minus_y", [11.0, -6.0]),
    // Up is -x, right is -y.
    ("from_back", "minus_x", [-6.0, -11.0]),
];

/// A picture of `columns` x `rows` pixels with a round bump `right` and `above` of the pixel `centre` (column, row), in
/// nanometres. Row 0 is the top.
fn picture([columns, rows]: [usize; 2], centre: [f64; 2], [right, above]: [f64; 2], height: f64) -> Vec<u8> {
    let mut values = Vec::with_capacity(columns * rows);
    for row in 0..rows {
        for column in 0..columns {
            let x = (column as f64 - centre[0]) * PIXEL - right;
            let y = (centre[1] - row as f64) * PIXEL - above;
            // 6 mm of sigma: wider than the spot of 4 mm, so that the dwell over it has its peak on it.
            values.push(height * (-(x * x + y * y) / (2.0 * 6.0 * 6.0)).exp());
        }
    }
    npy(columns, &values)
}

/// A landscape picture, so that columns taken for rows do not fit, its middle between two pixels across.
const SIZE: [usize; 2] = [84, 65];
const MIDDLE: [f64; 2] = [41.5, 32.0];

fn build(map: Vec<u8>, changes: &[(&str, &str)]) -> ProgramText {
    program_text(&compile(job_text(&ASKEW, changes), map).jobs[0])
}

/// World coordinates of the slowest feed, and that feed: the middle of the straight move that has it. Moves that come
/// down from above are no polishing moves.
fn slowest(program: &ProgramText) -> ([f64; 3], f64) {
    let mut found = ([0.0; 3], f64::INFINITY);
    for run in program.runs() {
        for pair in run.points.windows(2) {
            if pair[1].speed < found.1 {
                let (a, b) = (pair[0].target.at, pair[1].target.at);
                found = (std::array::from_fn(|i| (a[i] + b[i]) / 2.0), pair[1].speed);
            }
        }
    }
    (program.world_object().place(found.0), found.1)
}

/// The bump in the world, one gap of 1 mm above the glass, where the tool centre point stands over it.
fn bump_in_the_world() -> [f64; 3] {
    world_part(&ASKEW).place([BUMP[0], BUMP[1], 1.0])
}

fn assert_over_the_bump(program: &ProgramText, what: &str) {
    let (place, feed) = slowest(program);
    let off = distance(place, bump_in_the_world());
    assert!(off <= PIXEL, "{what}: the slowest feed, {feed} mm/s, is {off:.2} mm from the bump");
}

/// The eight orientations, each with both signs, each with the raster along another direction, for both targets.
#[test]
fn the_slowest_feed_lies_over_the_bump() {
    let directions = ["0 deg", "90 deg", "-30 deg", "45 deg", "17 deg", "180 deg", "-135 deg", "60 deg"];
    for ((view, up, place), direction) in ORIENTATIONS.iter().zip(directions) {
        for (positive, height) in [("high", 600.0), ("low", -600.0)] {
            let changes = [("view", *view), ("up", *up), ("positive", positive), ("direction", direction)];
            for (target, words) in [("RAPID", &[][..]), ("KRL", &KRL)] {
                let program = build(picture(SIZE, MIDDLE, *place, height), &[&changes, words].concat());
                let what = format!("{target}, {view}, {up}, positive {positive}, raster {direction}");
                assert_over_the_bump(&program, &what);
            }
        }
    }
}

/// The test can fail: with any other of the eight orientations, or with the other sign, the same picture is polished
/// somewhere else. The nearest of the other seven places is (6, 11) mm, 7.07 mm away; a pixel less is asked.
#[test]
fn the_wrong_words_polish_elsewhere() {
    let (view, up, place) = ORIENTATIONS[0];
    for (i, (wrong_view, wrong_up, _)) in ORIENTATIONS.iter().enumerate().skip(1) {
        let program = build(picture(SIZE, MIDDLE, place, 600.0), &[("view", wrong_view), ("up", wrong_up)]);
        let off = distance(slowest(&program).0, bump_in_the_world());
        assert!(off > 6.0, "orientation {i} instead of {view} {up}: only {off:.2} mm from the bump");
    }
    let program = build(picture(SIZE, MIDDLE, place, 600.0), &[("positive", "low")]);
    let off = distance(slowest(&program).0, bump_in_the_world());
    assert!(off > 6.0, "the wrong sign: only {off:.2} mm from the bump");
}

/// On every curved form, each in another orientation: the map's x and y are those of the part, and the tool stands one gap
/// from the bump along the normal there. The steep ones turn it by ten degrees at the bump.
#[test]
fn the_bump_is_found_on_every_form() {
    for (i, form) in FORMS.iter().enumerate().skip(1) {
        let (view, up, place) = ORIENTATIONS[i % ORIENTATIONS.len()];
        let (positive, height) = if i % 2 == 0 { ("high", 600.0) } else { ("low", -600.0) };
        let changes = [("form", form.text), ("view", view), ("up", up), ("positive", positive)];
        // The targets in turn.
        let words = if i % 2 == 0 { &[][..] } else { &KRL };
        let text = job_text(&ASKEW, &[&changes, words].concat());
        let done = compile_with(text, picture(SIZE, MIDDLE, place, height), form.files());
        let program = program_text(&done.jobs[0]);
        let (found, feed) = slowest(&program);
        let (contact, normal) = form.at(BUMP[0], BUMP[1]);
        let expected = world_part(&ASKEW).place(std::array::from_fn(|k| contact[k] + normal[k]));
        let off = distance(found, expected);
        assert!(
            off <= PIXEL,
            "{}, {view}, {up}: the slowest feed, {feed} mm/s, is {off:.2} mm from the bump",
            form.name
        );
    }
}

/// A wavefront of a double pass reads twice the surface: the same glass, so the same moves.
#[test]
fn a_wavefront_of_twice_the_height_is_the_same_glass() {
    let surface = build(picture(SIZE, MIDDLE, [11.0, 6.0], 600.0), &[]);
    let wavefront = build(picture(SIZE, MIDDLE, [11.0, 6.0], 1200.0), &[("quantity", "wavefront")]);
    assert_over_the_bump(&wavefront, "wavefront");
    assert_eq!(surface.moves, wavefront.moves);
    // Read as a surface it asks for twice the removal: about half the feed.
    let wrong = build(picture(SIZE, MIDDLE, [11.0, 6.0], 1200.0), &[]);
    let ratio = slowest(&wrong).1 / slowest(&surface).1;
    assert!((0.4..0.65).contains(&ratio), "{ratio}");
}

/// The part's origin at a stated pixel of an upright picture, far from its middle, seen from the back.
#[test]
fn a_stated_centre_pixel_is_the_parts_origin() {
    let (size, centre) = ([70, 90], [30.0, 50.0]);
    let map = picture(size, centre, [-6.0, -11.0], 600.0);
    let changes = [
        ("view", "from_back"),
        ("up", "minus_x"),
        ("centre", "pixel_at { column: 30, row: 50 }"),
        ("direction", "-30 deg"),
    ];
    assert_over_the_bump(&build(map, &changes), "a stated centre");
}

/// Where a place of the part lies in a picture, mm to the right of its middle and above it: the part turned by `turned` degrees
/// from +x towards +y, then seen as `view` and `up` say (the table above), then moved in the picture by `shift`.
fn seen(view: &str, up: &str, turned: f64, shift: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    let (sine, cosine) = turned.to_radians().sin_cos();
    let (x, y) = (cosine * x - sine * y, sine * x + cosine * y);
    let [right, above] = match up {
        "plus_y" => [x, y],
        "plus_x" => [-y, x],
        "minus_y" => [-x, -y],
        _ => [y, -x],
    };
    [if view == "from_back" { -right } else { right } + shift[0], above + shift[1]]
}

/// By its marks a map finds its place however it was laid down: turned by an odd angle, beside the middle, in all eight
/// orientations. Twice the same job, with the turn said by `rotated` instead.
#[test]
fn marks_lead_the_tool_to_the_bump() {
    let marks = [("A", [20.0, 2.0]), ("B", [-3.0, 18.0]), ("C", [-16.0, -11.0])];
    let on_the_part: Vec<String> = marks
        .iter()
        .map(|(name, [x, y])| format!("fiducial {{ name: \"{name}\", at: place {{ x: {x} mm, y: {y} mm }} }}"))
        .collect();
    let form = format!("plane\n        fiducials: [{}]", on_the_part.join(", "));
    let turns = [7.3, -4.1, 12.9, -13.3, 1.7, -9.2, 5.8, -11.6];
    for (((view, up, place), turned), positive) in ORIENTATIONS.iter().zip(turns).zip(["high", "low"].iter().cycle()) {
        // The table of this file and the function agree where nothing is turned.
        let plain = seen(view, up, 0.0, [0.0; 2], BUMP);
        assert!((plain[0] - place[0]).abs() < 1e-12 && (plain[1] - place[1]).abs() < 1e-12, "{view} {up}");
        let height = if *positive == "high" { 600.0 } else { -600.0 };
        for (shift, rotated) in [([4.3, -2.6], false), ([0.0; 2], true)] {
            let bump = seen(view, up, turned, shift, BUMP);
            let words = if rotated {
                format!("frame_centre\n            rotated: {turned} deg")
            } else {
                let in_the_picture: Vec<String> = marks
                    .iter()
                    .map(|(name, place)| {
                        let [right, above] = seen(view, up, turned, shift, *place);
                        let (column, row) = (MIDDLE[0] + right / PIXEL, MIDDLE[1] - above / PIXEL);
                        format!("mark {{ name: \"{name}\", column: {column:.6}, row: {row:.6} }}")
                    })
                    .collect();
                let marks = in_the_picture.join(", ");
                format!("frame_centre\n            fiducials: {{ marks: [{marks}], within: 0.1 mm }}")
            };
            let changes = [("view", *view), ("up", *up), ("positive", *positive), ("centre", &words), ("form", &form)];
            let program = build(picture(SIZE, MIDDLE, bump, height), &changes);
            assert_over_the_bump(&program, &format!("{view}, {up}, turned by {turned} deg, rotated {rotated}"));
        }
    }
}
