//! Geometry: from a program's text and its job alone, the tool touches the glass where the form says.
//!
//! The way of the proof, none of which is the crate's: a small reader takes the joint moves, targets, tool and work
//! object from the text. rs-opw-kinematics, somebody else's solver, turns each target into joints, starting at the
//! `MoveAbsJ` joints of each run and taking the nearest solution from point to point, as a controller with `ConfL\Off`
//! does. Its forward kinematics then place the flange, and matrices composed here from the job's own numbers (base, user,
//! object, tool; none the identity, the tool askew) place the tool frame in the part.
//!
//! Expected, by hand: height and normal of every form by the formulas of `replay/forms.rs`. The contact point lies one gap
//! from the tool centre point along the tool's z axis, which points into the glass against the normal. The raster's points
//! are the lattice of the job, laid onto the surface along z: lines at v = -48 + j * pitch while |v| <= 48, points at whole
//! multiples u of the step with u² + v² <= 48² (mm, exact in whole numbers), turned by `direction`; every second line of a
//! serpentine backwards. Tool x lies along `azimuth`, laid into the tangent plane.
//! Tolerances are those of the project: 1 um, and 0.001 degrees; for joints, what five written decimals of a degree mean.
#![allow(clippy::disallowed_methods, clippy::print_stdout, reason = "tests use mathematics and files, and say figures")]

mod replay;

use replay::forms::{FORMS, FormCase};
use replay::krl_text::PASSED;
use replay::program_text::{Configuration, PathPoint, ProgramText, RunText};
use replay::rigid::{Frame, Pose, Quaternion, degrees_between, distance, dot};
use replay::{ASKEW, FrameNumbers, Frames, KRL, KRL_LINEAR, compile_with, job_text, npy, program_text, world_part};
use rs_opw_kinematics::glam::{DMat3, DQuat, DVec3};
use rs_opw_kinematics::kinematic_traits::{Kinematics, Pose as TheirPose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;
use std::f64::consts::{PI, TAU};
use std::process::Command;

/// 1 um in mm.
const PLACE: f64 = 1e-3;
/// Degrees.
const ANGLE: f64 = 1e-3;

/// A target with its arm, as in tests/golden/robots.json: the arm by somebody else, ranges in degrees.
struct Target {
    name: &'static str,
    /// Words of the job.
    words: &'static [(&'static str, &'static str)],
    parameters: Parameters,
    lower: [f64; 6],
    upper: [f64; 6],
    /// How a point is passed that is no line's end.
    passed: &'static str,
}

fn rapid() -> Target {
    Target {
        name: "RAPID",
        words: &[],
        parameters: Parameters {
            a1: 0.32,
            a2: -0.2,
            b: 0.0,
            c1: 0.78,
            c2: 1.125,
            c3: 1.1425,
            c4: 0.2,
            offsets: [0.0, 0.0, -PI / 2.0, 0.0, 0.0, 0.0],
            sign_corrections: [1; 6],
            dof: 6,
        },
        lower: [-170.0, -65.0, -180.0, -300.0, -130.0, -360.0],
        upper: [170.0, 85.0, 70.0, 300.0, 130.0, 360.0],
        passed: "z0",
    }
}

fn krl() -> Target {
    Target {
        name: "KRL",
        words: &KRL,
        parameters: Parameters {
            a1: 0.33,
            a2: -0.115,
            b: 0.0,
            c1: 0.645,
            c2: 1.15,
            c3: 1.22,
            c4: 0.215,
            offsets: [0.0, -PI / 2.0, 0.0, 0.0, 0.0, 0.0],
            sign_corrections: [-1, 1, 1, -1, 1, -1],
            dof: 6,
        },
        lower: [-185.0, -140.0, -120.0, -350.0, -125.0, -350.0],
        upper: [185.0, -5.0, 168.0, 350.0, 125.0, 350.0],
        passed: PASSED,
    }
}

/// What a case changes: frames, and words of the job with their numbers.
struct Case {
    name: &'static str,
    frames: Frames,
    /// Degrees.
    azimuth: f64,
    /// mm.
    gap: f64,
    /// Degrees.
    direction: f64,
    one_way: bool,
    /// Whole mm.
    step: i64,
    pitch: i64,
}

const CASES: [Case; 4] = [
    Case { name: "askew", frames: ASKEW, azimuth: 0.0, gap: 1.0, direction: 0.0, one_way: false, step: 2, pitch: 2 },
    Case {
        name: "one way, turned by -30 deg, azimuth 165 deg",
        frames: ASKEW,
        azimuth: 165.0,
        gap: 0.8,
        direction: -30.0,
        one_way: true,
        step: 3,
        pitch: 4,
    },
    // The table leans 25 deg towards the robot and is turned; the tool stands out sideways by 35 deg.
    Case {
        name: "a leaning table",
        frames: Frames {
            base: FrameNumbers { at: [-40.0, 15.0, 350.0], zyx: [-8.0, 0.0, 0.0] },
            user: FrameNumbers { at: [1450.0, 200.0, 900.0], zyx: [35.0, -25.0, 3.0] },
            object: FrameNumbers { at: [-60.0, 30.0, 45.0], zyx: [-70.0, 2.0, 1.0] },
            tool: FrameNumbers { at: [-15.0, 60.0, 280.0], zyx: [0.0, 0.0, 35.0] },
        },
        azimuth: -75.0,
        gap: 1.3,
        direction: 90.0,
        one_way: false,
        step: 1,
        pitch: 3,
    },
    // The part's z axis lies 60 deg from the world's, the robot stands on a wall of 20 deg.
    Case {
        name: "a steep part",
        frames: Frames {
            base: FrameNumbers { at: [0.0, -120.0, 80.0], zyx: [15.0, 20.0, -5.0] },
            user: FrameNumbers { at: [1700.0, 100.0, 1000.0], zyx: [0.0, -60.0, 0.0] },
            object: FrameNumbers { at: [10.0, 20.0, 30.0], zyx: [110.0, 0.0, 0.0] },
            tool: FrameNumbers { at: [55.0, 0.0, 250.0], zyx: [90.0, 10.0, 20.0] },
        },
        azimuth: 40.0,
        gap: 2.0,
        direction: 17.5,
        one_way: false,
        step: 4,
        pitch: 1,
    },
];

/// A map of 61 x 61 pixels of 1 mm: a slope, a saddle, a bump, some hundred nanometres.
fn map() -> Vec<u8> {
    let mut values = Vec::new();
    for row in 0..61 {
        for column in 0..61 {
            let (x, y) = (f64::from(column) - 30.0, 30.0 - f64::from(row));
            let bump = 150.0 * (-((x - 9.0).powi(2) + (y + 5.0).powi(2)) / 72.0).exp();
            values.push(0.05 * (x * x - y * y) + 1.5 * x + bump);
        }
    }
    npy(61, &values)
}

fn text_of(case: &Case, form: &FormCase, target: &Target) -> String {
    let (azimuth, gap, direction) =
        (format!("{} deg", case.azimuth), format!("{} mm", case.gap), format!("{} deg", case.direction));
    let (step, pitch) = (format!("{} mm", case.step), format!("{} mm", case.pitch));
    let changes = [
        ("form", form.text),
        ("azimuth", azimuth.as_str()),
        ("gap", &gap),
        ("direction", &direction),
        ("step", &step),
        ("pitch", &pitch),
        ("lines", if case.one_way { "one_way" } else { "serpentine" }),
    ];
    job_text(&case.frames, &[&changes[..], target.words].concat())
}

/// The lattice of the raster in order of travel, mm in the part, by lines.
fn lattice(case: &Case) -> Vec<Vec<[f64; 2]>> {
    let (sine, cosine) = case.direction.to_radians().sin_cos();
    let mut lines = Vec::new();
    for j in 0.. {
        let v = -48 + j * case.pitch;
        if v > 48 {
            break;
        }
        let mut line: Vec<i64> = (-48..=48).filter(|u| u % case.step == 0 && u * u + v * v <= 48 * 48).collect();
        if !case.one_way && j % 2 == 1 {
            line.reverse();
        }
        let place = |u: i64| {
            let (u, v) = (u as f64, v as f64);
            [u * cosine - v * sine, u * sine + v * cosine]
        };
        lines.push(line.into_iter().map(place).collect());
    }
    lines
}

/// A frame of this test, in the solver's type and metres.
fn their_pose(frame: &Frame) -> TheirPose {
    let [x, y, z] = [0, 1, 2].map(|k| DVec3::from_array(frame.axis(k)));
    let at = DVec3::from_array(frame.at) * 1e-3;
    TheirPose::from_parts(at, DQuat::from_mat3(&DMat3::from_cols(x, y, z)))
}

/// The flange that the solver's forward kinematics give, mm.
fn flange(oracle: &OPWKinematics, joints: &[f64; 6]) -> Frame {
    let pose = oracle.try_forward(joints).expect("finite joints");
    let (at, q) = (pose.translation * 1e3, pose.rotation);
    Pose { at: at.to_array(), turn: Quaternion([q.w, q.x, q.y, q.z]) }.matrix()
}

/// The solution nearest to `previous`, whole turns counted.
fn nearest(oracle: &OPWKinematics, pose: &TheirPose, previous: &[f64; 6]) -> [f64; 6] {
    let turned = |solution: [f64; 6]| -> [f64; 6] {
        std::array::from_fn(|i| solution[i] + TAU * ((previous[i] - solution[i]) / TAU).round())
    };
    let far = |joints: &[f64; 6]| joints.iter().zip(previous).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let solutions = oracle.inverse(pose).into_iter().map(turned);
    solutions.min_by(|a, b| far(a).total_cmp(&far(b))).expect("the target can be reached")
}

/// Base, user, object and tool frame of the job, and what follows from them.
struct Replay<'a> {
    case: &'a Case,
    form: &'a FormCase,
    target: &'a Target,
    oracle: OPWKinematics,
    /// The part in the robot's base, and the tool in the flange: from the job.
    base_part: Frame,
    tool: Frame,
    /// From the text: the object frame in the robot's base, and the flange in the tool frame. The robot's base in the world is
    /// in no program: the controller has it.
    base_object: Frame,
    tool_flange: Frame,
}

impl Replay<'_> {
    fn new<'a>(case: &'a Case, form: &'a FormCase, target: &'a Target, text: &ProgramText) -> Replay<'a> {
        let world_base = case.frames.base.frame().inverse();
        Replay {
            case,
            form,
            target,
            oracle: OPWKinematics::new(target.parameters),
            base_part: world_base.then(&world_part(&case.frames)),
            tool: case.frames.tool.frame(),
            base_object: world_base.then(&text.world_object().matrix()),
            tool_flange: text.tool.matrix().inverse(),
        }
    }

    /// The tool frame in the part, from joints and the job's frames, mm.
    fn tool_in_part(&self, joints: &[f64; 6]) -> Frame {
        self.base_part.inverse().then(&flange(&self.oracle, joints)).then(&self.tool)
    }

    /// Joints at a target of the text, from those before.
    fn joints(&self, target: &Pose, previous: &[f64; 6]) -> [f64; 6] {
        let flange = self.base_object.then(&target.matrix()).then(&self.tool_flange);
        nearest(&self.oracle, &their_pose(&flange), previous)
    }

    /// Checks that the tool stands over `place` of the part, `height` above the contact. Gives back how far it is off, mm
    /// and degrees.
    fn stands(&self, joints: &[f64; 6], place: [f64; 2], height: f64, place_tolerance: f64, what: &str) -> [f64; 2] {
        let tool = self.tool_in_part(joints);
        let into_the_glass = tool.axis(2);
        let reach = self.case.gap + height;
        let contact: [f64; 3] = std::array::from_fn(|i| tool.at[i] + reach * into_the_glass[i]);
        let ([x, y], (expected, normal)) = (place, self.form.at(place[0], place[1]));
        let off_surface = self.form.at(contact[0], contact[1]).0[2] - contact[2];
        assert!(off_surface.abs() <= place_tolerance, "{what}: {off_surface} mm off the surface");
        let off = distance(contact, expected);
        assert!(off <= place_tolerance, "{what}: {off} mm from its place in the lattice");
        let lean = degrees_between(into_the_glass, normal.map(|n| -n));
        assert!(lean <= ANGLE, "{what}: {lean} deg off the normal");
        let turned = degrees_between(tool.axis(0), self.form.tool_x(x, y, self.case.azimuth));
        assert!(turned <= ANGLE, "{what}: {turned} deg off the azimuth");
        [off, lean.max(turned)]
    }

    /// Replays one run over its lines of the lattice; gives back how far its worst point is off, mm and degrees.
    fn run(&self, run: &RunText, lines: &[Vec<[f64; 2]>], what: &str) -> [f64; 2] {
        // Five decimals of a degree leave up to 0.5e-5 deg a joint, which six joints and 3 m of arm turn into less
        // than 6 * 0.87e-7 rad * 3000 mm = 1.6 um.
        let start = run.start.map(f64::to_radians);
        self.stands(&start, lines[0][0], 40.0, 1.6e-3, &format!("{what}, approach"));
        let mut joints = start;
        let mut worst = [0.0_f64; 2];
        let places = lines.iter().flat_map(|line| {
            let last = line.len() - 1;
            line.iter().enumerate().map(move |(i, place)| (*place, i == 0 || i == last))
        });
        assert_eq!(run.points.len(), lines.iter().map(Vec::len).sum::<usize>(), "{what}: points");
        for (i, (point, (place, end))) in run.points.iter().zip(places).enumerate() {
            let what = format!("{what}, point {i}");
            let next = self.joints(&point.target, &joints);
            let off = self.stands(&next, place, 0.0, PLACE, &what);
            worst = [worst[0].max(off[0]), worst[1].max(off[1])];
            assert_eq!(point.zone, if end { "fine" } else { self.target.passed }, "{what}");
            self.joints_are_sound(&next, &joints, point, &what);
            joints = next;
        }
        let up = self.joints(&run.retract, &joints);
        let last = lines.last().and_then(|line| line.last()).expect("a point");
        self.stands(&up, *last, 40.0, PLACE, &format!("{what}, retract"));
        worst
    }

    /// Inside the ranges, near the joints before, and in the configuration that the text names.
    fn joints_are_sound(&self, joints: &[f64; 6], before: &[f64; 6], point: &PathPoint, what: &str) {
        let degrees = joints.map(f64::to_degrees);
        for i in 0..6 {
            // The job's robot keeps a degree from both ends.
            assert!(
                degrees[i] > self.target.lower[i] + 1.0 && degrees[i] < self.target.upper[i] - 1.0,
                "{what}: joint {} {degrees:?}",
                i + 1
            );
            assert!((joints[i] - before[i]).abs() < 0.5, "{what}: joint {} jumps, {degrees:?}", i + 1);
        }
        match point.configuration {
            Configuration::Abb(confdata) => abb_configuration(&degrees, confdata, what),
            Configuration::Kuka { status, turn } => kuka_configuration(&degrees, status, turn, what),
        }
    }
}

/// Technical reference manual RAPID, confdata: the quarter turn that axes 1, 4 and 6 stand in, 0 for 0 to 90 deg, -1 for -90
/// to 0 deg. Within a thousandth of a degree of a quarter either number is right. cfx of such an arm: odd where axis 5 is
/// negative; 2 and 3, 6 and 7 with the wrist centre behind the lower arm; from 4 on with it behind axis 1, where none of
/// these parts is.
fn abb_configuration(degrees: &[f64; 6], confdata: [i32; 4], what: &str) {
    for (axis, quarter) in [(0, confdata[0]), (3, confdata[1]), (5, confdata[2])] {
        let sides = [-1e-3, 1e-3].map(|d| ((degrees[axis] + d) / 90.0).floor() as i32);
        assert!(sides.contains(&quarter), "{what}: axis {} {degrees:?} {confdata:?}", axis + 1);
    }
    let cfx = confdata[3];
    assert_eq!(cfx % 2 == 1, degrees[4] < 0.0, "{what}: axis 5 {degrees:?}, cfx {cfx}");
    assert!((0..4).contains(&cfx), "{what}: cfx {cfx}");
}

/// KUKA's turn: a bit an axis, set where it is negative; within a thousandth of a degree of zero either is right. Its status: 1
/// with the wrist behind axis 1, where none of these parts is; 4 with axis 5 negative; 2 where axis 3 is above the angle at
/// which this arm is stretched, atan(115 / 1220) = 5.38 deg, as it is wherever the elbow is up.
fn kuka_configuration(degrees: &[f64; 6], status: i32, turn: i32, what: &str) {
    for (axis, angle) in degrees.iter().enumerate() {
        let bit = turn >> axis & 1 == 1;
        assert!(bit == (*angle < 0.0) || angle.abs() < 1e-3, "{what}: axis {} {degrees:?}, T {turn}", axis + 1);
    }
    let wanted = 2 * i32::from(degrees[2] > 5.38) + 4 * i32::from(degrees[4] < 0.0);
    assert_eq!(status, wanted, "{what}: {degrees:?}");
    assert!((0..64).contains(&turn), "{what}: T {turn}");
}

fn contact_points_and_normals_are_those_of(form: &FormCase, case: &Case, target: &Target) {
    let name = format!("{}, {}, {}", form.name, case.name, target.name);
    let done = compile_with(text_of(case, form, target), map(), form.files());
    let text = program_text(&done.jobs[0]);
    let replay = Replay::new(case, form, target, &text);
    let lines = lattice(case);
    let runs = text.runs();
    // A serpentine of less than a module's 4800 points goes in one run, one way lifts after every line.
    assert_eq!(runs.len(), if case.one_way { lines.len() } else { 1 }, "{name}");
    let mut left = lines.as_slice();
    let mut worst = [0.0_f64; 2];
    for (k, run) in runs.iter().enumerate() {
        let (these, rest) = left.split_at(if case.one_way { 1 } else { lines.len() });
        left = rest;
        let off = replay.run(run, these, &format!("{name}, run {k}"));
        worst = [worst[0].max(off[0]), worst[1].max(off[1])];
    }
    println!("{name}: at most {:.4} um and {:.2e} deg off", worst[0] * 1e3, worst[1]);
    assert!(left.is_empty(), "{name}: lines are missing");
}

/// The line that a strategy's points lie on: how far a place is from it, mm.
type Curve = fn([f64; 2]) -> f64;

/// r = 2 theta / 2 pi mm, met at 48 mm in the direction 25 deg; clockwise from outside, so seen outwards theta grows from +x
/// towards +y.
fn spiral([x, y]: [f64; 2]) -> f64 {
    let (radius, angle) = (x.hypot(y), y.atan2(x) - 25f64.to_radians());
    if radius < 0.01 {
        // It ends at the centre, where there is no direction.
        return radius;
    }
    let off = (radius - 2.0 * angle / TAU).rem_euclid(2.0);
    off.min(2.0 - off)
}

/// Circles of 1, 3, 5 … mm; and the ways over from one to the next. Clockwise from inside: a ring of radius r in n steps, n =
/// 2 pi r / 1.5 rounded up, at least 8, comes back to the direction 0 deg from above; m of its steps make up a pitch, m = 2
/// over the step rounded up, at most n / 2. In these the radius grows evenly.
fn rings([x, y]: [f64; 2]) -> f64 {
    let radius = x.hypot(y);
    let beside = (radius - 1.0).rem_euclid(2.0);
    let on_a_ring = beside.min(2.0 - beside);
    let inner = 1.0 + 2.0 * ((radius - 1.0) / 2.0).floor().max(0.0);
    let n = (TAU * inner / 1.5).ceil().max(8.0);
    let m = (2.0 / (TAU * inner / n)).ceil().min((n / 2.0).floor());
    let left = y.atan2(x).rem_euclid(TAU) / (TAU / n);
    let over = if left <= m { (radius - (inner + 2.0 * (1.0 - left / m))).abs() } else { f64::INFINITY };
    on_a_ring.min(over)
}

/// Through the middles of squares of 3 mm, or on a quarter circle about a corner of them.
fn squares([x, y]: [f64; 2]) -> f64 {
    let (sine, cosine) = 10f64.to_radians().sin_cos();
    let [u, v] = [cosine * x + sine * y, cosine * y - sine * x].map(|c| c - 3.0 * (c / 3.0).round());
    // Now about the nearest corner: the middles lie 1.5 mm away.
    (1.5 - u.abs()).abs().min((1.5 - v.abs()).abs()).min((u.hypot(v) - 1.5).abs())
}

/// Every strategy: at every target of the text the tool meets the glass, upright, on the strategy's own curve.
fn strategy_lies_on(path: &str, curve: Curve, form: &FormCase, target: &Target) {
    let case = &CASES[0];
    let name = format!("{path}, {}, {}", form.name, target.name);
    let text = job_text(&case.frames, &[&[("form", form.text), ("path", path)][..], target.words].concat());
    let done = compile_with(text, map(), form.files());
    let text = program_text(&done.jobs[0]);
    let replay = Replay::new(case, form, target, &text);
    let mut worst = [0.0_f64; 3];
    let mut broken: Option<[f64; 2]> = None;
    for run in text.runs() {
        let mut joints = run.start.map(f64::to_radians);
        let place_of = |tool: &Frame| -> [f64; 2] { std::array::from_fn(|i| tool.at[i] + case.gap * tool.axis(2)[i]) };
        let last = run.points.len() - 1;
        for (i, point) in run.points.iter().enumerate() {
            let what = format!("{name}, point {i}");
            let next = replay.joints(&point.target, &joints);
            let place = place_of(&replay.tool_in_part(&next));
            // Its own place in x and y; height, normal and azimuth by the form.
            let off = replay.stands(&next, place, 0.0, PLACE, &what);
            worst = [worst[0].max(off[0]), worst[1].max(off[1]), worst[2].max(curve(place))];
            assert_eq!(point.zone, if i == 0 || i == last { "fine" } else { target.passed }, "{what}");
            if i == 0
                && let Some(up) = broken
            {
                // A line that was broken goes on where it ended.
                let off = (place[0] - up[0]).hypot(place[1] - up[1]);
                assert!(!(2.0 * PLACE..=2.0).contains(&off), "{what}: {off} mm from where the tool went up");
            }
            replay.joints_are_sound(&next, &joints, point, &what);
            joints = next;
            broken = Some(place);
        }
        let up = replay.joints(&run.retract, &joints);
        replay.stands(&up, broken.expect("a point"), 40.0, PLACE, &format!("{name}, retract"));
    }
    println!(
        "{name}: at most {:.4} um, {:.2e} deg off, {:.4} um beside the curve",
        worst[0] * 1e3,
        worst[1],
        worst[2] * 1e3
    );
    assert!(worst[2] < PLACE, "{name}: {} mm beside the curve", worst[2]);
}

#[test]
fn every_strategy_lies_on_its_curve() {
    let area = "over: circle { diameter: 96 mm }";
    let landing = "landing: landing { speed: 10 mm/s, reach: 2 mm, stand: 0.1 s }";
    let strategies: [(String, Curve); 4] = [
        (
            format!(
                "spiral {{ {area}, point_step: 1.5 mm, line_pitch: 2 mm, start: outside, hand: clockwise, direction: 25 deg, {landing} }}"
            ),
            spiral,
        ),
        (
            format!(
                "rings {{ {area}, point_step: 1.5 mm, line_pitch: 2 mm, start: inside, hand: clockwise, {landing} }}"
            ),
            rings,
        ),
        (format!("hilbert {{ {area}, point_step: 1.1 mm, line_pitch: 3 mm, direction: 10 deg, {landing} }}"), squares),
        (
            format!(
                "pseudo_random {{ {area}, point_step: 1.1 mm, line_pitch: 3 mm, direction: 10 deg, seed: 1, {landing} }}"
            ),
            squares,
        ),
    ];
    for (path, curve) in &strategies {
        strategy_lies_on(path, *curve, &FORMS[1], &rapid());
        strategy_lies_on(path, *curve, &FORMS[0], &krl());
    }
}

#[test]
fn a_plane_in_every_cell() {
    for target in [rapid(), krl(), Target { name: "KRL, linear moves", words: &KRL_LINEAR, ..krl() }] {
        for case in &CASES {
            contact_points_and_normals_are_those_of(&FORMS[0], case, &target);
        }
    }
}

#[test]
fn every_form_in_an_askew_cell() {
    for target in [rapid(), krl()] {
        for form in &FORMS[1..] {
            contact_points_and_normals_are_those_of(form, &CASES[0], &target);
        }
    }
}

/// Another azimuth, direction and gap, points as close as a steep form needs.
#[test]
fn every_form_on_a_leaning_table() {
    for target in [rapid(), krl()] {
        for form in &FORMS[1..] {
            contact_points_and_normals_are_those_of(form, &CASES[2], &target);
        }
    }
}

/// The proof can fail: a frame of the job a hundredth of a millimetre or 0.002 degrees away, and it does.
#[test]
fn a_frame_that_is_not_the_jobs_is_noticed() {
    let (case, form, target) = (&CASES[0], &FORMS[0], rapid());
    let text = program_text(&compile_with(text_of(case, form, &target), map(), Vec::new()).jobs[0]);
    let lines = lattice(case);
    let fails = |change: &dyn Fn(&mut Frames)| {
        let mut changed = Case { frames: case.frames, name: "changed", ..CASES[0] };
        change(&mut changed.frames);
        let run = text.runs().remove(0);
        let replay = Replay::new(&changed, form, &target, &text);
        let target = run.points[500].target;
        let joints = replay.joints(&target, &run.start.map(f64::to_radians));
        let tool = replay.tool_in_part(&joints);
        let contact: [f64; 3] = std::array::from_fn(|i| tool.at[i] + changed.gap * tool.axis(2)[i]);
        let place = lines.iter().flatten().nth(500).expect("so many points");
        let off = distance(contact, [place[0], place[1], 0.0]);
        off > PLACE || degrees_between(tool.axis(2), [0.0, 0.0, -1.0]) > ANGLE
    };
    assert!(!fails(&|_| {}), "unchanged it must hold");
    assert!(fails(&|frames| frames.object.at[0] += 0.01));
    assert!(fails(&|frames| frames.user.zyx[1] += 0.002));
    assert!(fails(&|frames| frames.tool.at[1] -= 0.01));
    assert!(fails(&|frames| frames.tool.zyx[2] += 0.002));
    // The base is the same on both sides of the chain: moving it moves robot and part alike, so it does not show here but
    // in the joints, which must fit the `MoveAbsJ` of the text.
    let mut changed = Case { frames: case.frames, name: "changed", ..CASES[0] };
    changed.frames.base.at[2] += 0.01;
    let replay = Replay::new(&changed, form, &target, &text);
    let run = text.runs().remove(0);
    let tool = replay.tool_in_part(&run.start.map(f64::to_radians));
    let over = [lines[0][0][0], lines[0][0][1], changed.gap + 40.0];
    assert!(distance(tool.at, over) > 1.6e-3, "the base must show in the approach");
    assert!(dot(tool.axis(2), [0.0, 0.0, -1.0]) > 0.999);
}

/// The speeds in the text are those that `--emit dwell` gives out, to the last written decimal, point by point.
#[test]
fn speeds_are_those_of_the_dwell_plan() {
    speeds_of(&rapid(), ".mod");
    speeds_of(&krl(), ".src");
}

fn speeds_of(target: &Target, ending: &str) {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("geometry_speeds_{}", target.name));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("trial.polish"), text_of(&CASES[1], &FORMS[0], target)).expect("a job");
    std::fs::write(folder.join("map.npy"), map()).expect("a map");
    let out = folder.join("out");
    let run = Command::new(env!("CARGO_BIN_EXE_polishc"))
        .args(["build", "trial.polish", "--emit", "dwell,program", "-o", "out"])
        .current_dir(&folder)
        .output()
        .expect("the tool runs");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let mut files: Vec<(String, Vec<u8>)> = std::fs::read_dir(&out)
        .expect("a folder of output")
        .map(|entry| entry.expect("an entry").path())
        .map(|path| {
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            (name, std::fs::read(&path).expect("a readable file"))
        })
        .collect();
    // `Trial.mod` before `Trial_001.mod`.
    files.sort();
    let dwell = files.iter().find(|(name, _)| name == "trial.dwell.npy").expect("the dwell").1.clone();
    files.retain(|(name, _)| name.ends_with(ending) || name.ends_with(".dat"));
    let header = 10 + usize::from(u16::from_le_bytes([dwell[8], dwell[9]]));
    let planned: Vec<f64> =
        dwell[header..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("eight bytes"))).collect();
    let written: Vec<f64> =
        ProgramText::read(&files).runs().into_iter().flat_map(|run| run.points).map(|point| point.speed).collect();
    assert_eq!(written.len(), planned.len());
    let mut different = Vec::new();
    for (i, (mm, m)) in written.iter().zip(&planned).enumerate() {
        // m/s against mm/s: the same number to the rounding of the division.
        if (mm - m * 1e3).abs() > 1e-9 {
            different.push((i, *mm, m * 1e3));
        }
    }
    assert!(different.is_empty(), "{different:?}");
    let (least, most) = written.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
    // The job's feed; that speeds differ at all is what makes the comparison worth something.
    assert!(least >= 0.2 && most <= 60.0 && least < most / 2.0, "{least} {most}");
}
