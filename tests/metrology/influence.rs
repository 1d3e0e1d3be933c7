//! Influence functions: the Gaussian in closed form, and spots from maps.

use polishc::diagnostics::Problem;
use polishc::height_map::npy;
use polishc::job::{
    self, Along, Bonnet, BonnetContact, Conditions, ContactRate, Direction, Empty, Form, Gaussian, Influence,
    InfluenceAt, Material, Measured, MrfConditions, MrfWheel, Origin, PixelAt, Plane, Positive, Precession, Quantity,
    Seen, Sense, Set, Side, Sphere, Spot, SpotPeak, Tool, Turn, TurnsWith, View, Workpiece,
};
use polishc::source::MemoryFiles;
use polishc::tool::measured as spots_of;
use polishc::tool::{InfluenceField, InfluenceFunction, part_to_tool};
use polishc::units::si::{Angle, AngularSpeed, Length, Pressure, Speed, Time};
use std::collections::BTreeMap;

fn mm(value: f64) -> Length {
    Length(value * 1e-3)
}

fn near(found: f64, expected: f64, relative: f64) -> bool {
    (found - expected).abs() <= relative * expected.abs()
}

#[test]
fn a_gaussian_has_its_closed_volume_and_width() {
    // Case tif_volume_1 of the golden file: diameter 25 mm, sigma 25/6 mm, peak 10 nm/s: 1078.712747109895 nm mm²/s.
    let spot = InfluenceFunction::gaussian(10e-9, 25e-3 / 6.0, 25e-3).unwrap();
    assert!(near(spot.volume_rate(), 1.078_712_747_109_895e-12, 1e-13));
    assert_eq!(spot.radius(), 12.5e-3);
    assert_eq!(spot.rate(0.0, 0.0), 10e-9);
    // One sigma out: exp(-1/2).
    assert!(near(spot.rate(0.0, -25e-3 / 6.0), 10e-9 * 0.606_530_659_712_633_4, 1e-14));
    assert_eq!(spot.rate(12.6e-3, 0.0), 0.0);
    assert!(spot.rate(12.4e-3, 0.0) > 0.0);
    // Cut at three sigma: sigma² (1 - u e^-u / (1 - e^-u)) with u = 4.5: 4.5 e^-4.5 = 0.049990, 1 - e^-4.5 = 0.988891.
    assert!(near(spot.sigma_scale(), 25e-3 / 6.0 * (1.0_f64 - 0.049_990_484 / 0.988_891_003).sqrt(), 1e-8));
}

#[test]
fn a_gaussian_without_size_is_refused() {
    for (peak, sigma, diameter, field) in
        [(0.0, 1e-3, 1e-2, "peak"), (1e-9, -1e-3, 1e-2, "sigma"), (1e-9, 1e-3, f64::NAN, "diameter")]
    {
        let problem = InfluenceFunction::gaussian(peak, sigma, diameter).unwrap_err();
        assert_eq!((problem.code.as_str(), problem.field.as_deref()), ("E0620", Some(field)));
    }
}

#[test]
fn a_stamp_holds_the_volume() {
    let spot = InfluenceFunction::gaussian(10e-9, 2e-3, 20e-3).unwrap();
    let stamp = spot.stamp(0.25e-3, 0.3);
    assert_eq!((stamp.columns, stamp.rows), (81, 81));
    assert_eq!(stamp.position(40, 40), [0.0, 0.0]);
    assert_eq!(stamp.at(40, 40), 10e-9);
    // The trapezium rule on a smooth spot that has died away at its rim (exp(-12.5)) is right to 1e-5.
    let sum: f64 = stamp.values.iter().sum();
    assert!(near(sum * 0.25e-3 * 0.25e-3, spot.volume_rate(), 1e-5));
}

#[test]
fn the_tool_frame_is_right_handed_with_z_into_the_glass() {
    // Tool x along part x: with z down, y = z x x points along part -y. Tool x along part y: y = (-z) x y = x.
    for (azimuth_deg, dx, dy, x, y) in [
        (0.0, 1.0, 0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0, 0.0, -1.0),
        (90.0, 0.0, 1.0, 1.0, 0.0),
        (90.0, 1.0, 0.0, 0.0, 1.0),
        (180.0, 1.0, 0.0, -1.0, 0.0),
        (180.0, 0.0, 1.0, 0.0, 1.0),
    ] {
        let found = part_to_tool(dx, dy, f64::to_radians(azimuth_deg));
        assert!((found[0] - x).abs() < 1e-15 && (found[1] - y).abs() < 1e-15, "{azimuth_deg} {dx} {dy}: {found:?}");
    }
}

/// A spot of the tool frame without any symmetry, in nm/s at millimetres: the rate that the measured map must give.
fn lopsided(x: f64, y: f64) -> f64 {
    40.0 * (-((x - 0.6) * (x - 0.6) / 8.0 + (y + 0.3) * (y + 0.3) / 3.0 + (x - 0.6) * (y + 0.3) / 6.0)).exp()
}

const COLUMNS: usize = 121;
const ROWS: usize = 101;
const PIXEL: f64 = 0.2;

/// The picture (nm) of ten seconds of the spot: the tool centre point at column 57, row 48; `right` and `up` are the
/// tool axes that point so in the picture. The interferometer left 25 nm and a tilt in it.
fn picture(right: [f64; 2], up: [f64; 2], sign: f64) -> Vec<f64> {
    (0..COLUMNS * ROWS)
        .map(|i| {
            let (row, column) = ((i / COLUMNS) as f64, (i % COLUMNS) as f64);
            let (along, above) = ((column - 57.0) * PIXEL, (48.0 - row) * PIXEL);
            let (x, y) = (along * right[0] + above * up[0], along * right[1] + above * up[1]);
            sign * 10.0 * lopsided(x, y) + 25.0 + 0.8 * column - 0.5 * row
        })
        .collect()
}

fn measured() -> Measured {
    Measured {
        spots: vec![one_spot(10.0, Origin::pixel_at(PixelAt { column: 57.0, row: 48.0 }))],
        quantity: Quantity::surface,
        positive: Positive::high,
        view: View::from_tool_side,
        up: Direction::plus_y,
        pixel: Some(mm(PIXEL)),
        unit: Some(Length(1e-9)),
        radius: mm(8.5),
        turns_with: TurnsWith::tool,
        flow_in_map: None,
        taken: Conditions::mrf_conditions(MrfConditions {
            diameter: mm(360.0),
            speed: AngularSpeed(60.0 * std::f64::consts::TAU / 60.0),
            rotation: job::WheelRotation::forward,
            gap: mm(1.0),
            material: Material { name: "glass".into() },
        }),
        ageing: None,
    }
}

fn one_spot(dwell: f64, origin: Origin) -> Spot {
    Spot { file: "spot.npy".into(), before: None, dwell: Time(dwell), origin, clock: None }
}

fn read(measured: &Measured, values: &[f64]) -> Result<InfluenceFunction, Problem> {
    let files = MemoryFiles(BTreeMap::from([("spot.npy".to_string(), npy::write(COLUMNS, values).unwrap())]));
    spots_of::read(measured, "tool.influence", &files, &mut Vec::new()).map(|spots| spots.function)
}

/// Bilinear reading of a curve with second derivative f'' is off by f'' h²/8 along each axis. The spot's steepest are
/// 40/4 along x and 40 · 2/3 along y (nm/s/mm²): 36.7 · 0.04 / 8 = 0.183. What of the spot lies beyond the radius tilts
/// the baseline by less than 0.005.
const RATE: f64 = 0.19;

fn agrees(spot: &InfluenceFunction) {
    for ix in -20..=20 {
        for iy in -20..=20 {
            let (x, y) = (f64::from(ix) * 0.31, f64::from(iy) * 0.27);
            let (found, expected) = (spot.rate(x * 1e-3, y * 1e-3) * 1e9, lopsided(x, y));
            assert!((found - expected).abs() < RATE, "at {x}, {y}: {found}, expected {expected}");
        }
    }
}

#[test]
fn a_measured_spot_gives_back_the_rate_in_every_orientation() {
    // The tool's z points into the glass. From the tool side it points away from the eye, so x, y turn clockwise:
    // with +y up, +x is on the left; with +x up, +y is on the right. From behind they turn counterclockwise.
    for (view, up_word, right, up) in [
        (View::from_tool_side, Direction::plus_y, [-1.0, 0.0], [0.0, 1.0]),
        (View::from_tool_side, Direction::minus_y, [1.0, 0.0], [0.0, -1.0]),
        (View::from_tool_side, Direction::plus_x, [0.0, 1.0], [1.0, 0.0]),
        (View::from_tool_side, Direction::minus_x, [0.0, -1.0], [-1.0, 0.0]),
        (View::from_back, Direction::plus_y, [1.0, 0.0], [0.0, 1.0]),
        (View::from_back, Direction::minus_y, [-1.0, 0.0], [0.0, -1.0]),
        (View::from_back, Direction::plus_x, [0.0, -1.0], [1.0, 0.0]),
        (View::from_back, Direction::minus_x, [0.0, 1.0], [-1.0, 0.0]),
    ] {
        // Glass that is gone stands low: with `high` the spot reads negative.
        for (positive, sign) in [(Positive::high, -1.0), (Positive::low, 1.0)] {
            let spot =
                read(&Measured { view, up: up_word, positive, ..measured() }, &picture(right, up, sign)).unwrap();
            agrees(&spot);
        }
    }
}

#[test]
fn a_measured_spot_has_the_volume_and_the_width_of_the_spot() {
    let spot = read(&measured(), &picture([-1.0, 0.0], [0.0, 1.0], -1.0)).unwrap();
    // The exponent is -v·M·v/2 with M = [1/4, 1/6; 1/6, 2/3]: determinant 1/6 - 1/36 = 5/36, volume 40 · 2π/√(5/36).
    let volume = 40.0 * std::f64::consts::TAU * 6.0 / 5.0_f64.sqrt();
    assert!(near(spot.volume_rate() * 1e15, volume, 2e-3), "{} {volume}", spot.volume_rate() * 1e15);
    // The smaller width is one over the root of M's larger eigenvalue, (11/12 + √((11/12)² - 5/9))/2.
    let larger = (11.0 / 12.0 + (121.0_f64 / 144.0 - 5.0 / 9.0).sqrt()) / 2.0;
    assert!(near(spot.sigma_scale() * 1e3, 1.0 / larger.sqrt(), 1e-2), "{}", spot.sigma_scale() * 1e3);
    assert_eq!(spot.radius(), 8.5e-3);
    // A wavefront is twice the surface; twice the dwell is half the rate.
    let half = read(&Measured { quantity: Quantity::wavefront, ..measured() }, &picture([-1.0, 0.0], [0.0, 1.0], -1.0));
    assert!(near(half.unwrap().volume_rate(), spot.volume_rate() / 2.0, 1e-12));
    let slow = read(
        &Measured { spots: vec![one_spot(20.0, measured().spots[0].origin.clone())], ..measured() },
        &picture([-1.0, 0.0], [0.0, 1.0], -1.0),
    );
    assert!(near(slow.unwrap().volume_rate(), spot.volume_rate() / 2.0, 1e-12));
}

#[test]
fn the_origin_is_where_the_job_says() {
    let values = picture([-1.0, 0.0], [0.0, 1.0], -1.0);
    // The deepest pixel is the one at (0.6, -0.4) or (0.6, -0.2), the centroid is (0.6, -0.3): from there, the rate is
    // that of the spot moved by as much.
    let centroid =
        read(&Measured { spots: vec![one_spot(10.0, Origin::centroid(Empty {}))], ..measured() }, &values).unwrap();
    for (x, y) in [(0.0, 0.0), (2.0, 1.0), (-1.5, 0.7)] {
        let (found, expected) = (centroid.rate(x * 1e-3, y * 1e-3) * 1e9, lopsided(x + 0.6, y - 0.3));
        assert!((found - expected).abs() < RATE, "{found} {expected}");
    }
    let peak = read(&Measured { spots: vec![one_spot(10.0, Origin::peak(Empty {}))], ..measured() }, &values).unwrap();
    let (found, lower, upper) = (peak.rate(1e-3, 1e-3) * 1e9, lopsided(1.6, 0.6), lopsided(1.6, 0.8));
    assert!((found - lower).abs() < RATE || (found - upper).abs() < RATE, "{found} {lower} {upper}");
    // The middle of the picture is column 60, row 50: three pixels right of and two below the tool centre point; seen
    // from the tool side with +y up, right is -x.
    let frame =
        read(&Measured { spots: vec![one_spot(10.0, Origin::frame_centre(Empty {}))], ..measured() }, &values).unwrap();
    for (x, y) in [(0.0, 0.0), (2.0, 1.0)] {
        let (found, expected) = (frame.rate(x * 1e-3, y * 1e-3) * 1e9, lopsided(x - 0.6, y - 0.4));
        assert!((found - expected).abs() < RATE, "{found} {expected}");
    }
}

#[test]
fn spots_that_cannot_be_are_refused() {
    let good = picture([-1.0, 0.0], [0.0, 1.0], -1.0);
    let said = |measured: Measured, values: &[f64]| {
        let problem = read(&measured, values).map(|_| ()).unwrap_err();
        (problem.code.to_string(), problem.field.unwrap(), problem.message)
    };
    let expect = |found: (String, String, String), code: &str, field: &str, words: &str| {
        assert_eq!((found.0.as_str(), found.1.as_str()), (code, field), "{}", found.2);
        assert!(found.2.contains(words), "{}", found.2);
    };
    expect(
        said(Measured { spots: vec![one_spot(0.0, Origin::peak(Empty {}))], ..measured() }, &good),
        "E0621",
        "tool.influence.spots.0.dwell",
        "`dwell` is 0.000 s",
    );
    expect(said(Measured { radius: mm(-1.0), ..measured() }, &good), "E0621", "tool.influence.radius", "-1.000 mm");
    expect(
        said(Measured { pixel: None, ..measured() }, &good),
        "E0506",
        "tool.influence.pixel",
        "how large a pixel is",
    );
    // From the tool centre point in row 48 of 101 the picture reaches 9.6 mm up.
    expect(said(Measured { radius: mm(9.7), ..measured() }, &good), "E0622", "tool.influence.radius", "leaves its map");
    expect(
        said(Measured { positive: Positive::low, ..measured() }, &good),
        "E0624",
        "tool.influence.positive",
        "added glass",
    );
    expect(said(measured(), &vec![5.0; COLUMNS * ROWS]), "E0624", "tool.influence.spots.0.file", "removed nothing");
    // One unknown pixel 2 mm above the tool centre point.
    let mut torn = good.clone();
    torn[38 * COLUMNS + 57] = f64::NAN;
    expect(said(measured(), &torn), "E0622", "tool.influence.spots.0.file", "x 0.000 mm, y 2.000 mm");
    // Outside the spot it does not matter.
    let mut torn = good.clone();
    torn[0] = f64::NAN;
    assert!(read(&measured(), &torn).is_ok());
    // A heap of glass of 5 % of the spot's volume (in ten seconds, nm mm²), 5 x 5 pixels of 0.04 mm², beside the spot.
    let volume = 10.0 * 40.0 * std::f64::consts::TAU * 6.0 / 5.0_f64.sqrt();
    let heaped = |share: f64| {
        let mut values = good.clone();
        for row in 20..25 {
            for column in 75..80 {
                values[row * COLUMNS + column] += share * volume / (25.0 * 0.04);
            }
        }
        values
    };
    expect(
        said(measured(), &heaped(0.05)),
        "E0623",
        "tool.influence.radius",
        "reads as added glass; at most 2 % can be noise",
    );
    assert!(read(&measured(), &heaped(0.01)).is_ok());
}

#[test]
fn a_measured_stamp_turns_with_the_azimuth() {
    let spot = read(&measured(), &picture([-1.0, 0.0], [0.0, 1.0], -1.0)).unwrap();
    // Tool x along part +y, so tool y along part +x: the spot's centre, tool (0.6, -0.3), lies at part (-0.3, 0.6).
    let stamp = spot.stamp(0.1e-3, f64::to_radians(90.0));
    let top = (0..stamp.values.len()).max_by(|a, b| stamp.values[*a].total_cmp(&stamp.values[*b])).unwrap();
    let [x, y] = stamp.position(top / stamp.columns, top % stamp.columns);
    // Bilinear reading finds the maximum at a pixel of the map, within 0.1 mm of it.
    assert!((x * 1e3 + 0.3).abs() < 0.11 && (y * 1e3 - 0.6).abs() < 0.11, "{x} {y}");
}

#[test]
fn a_wheel_has_a_size_and_a_gap() {
    let wheel = |diameter: f64, gap: f64, rpm: f64| {
        let tool = job::Tool::mrf_wheel(job::MrfWheel {
            diameter: mm(diameter),
            speed: AngularSpeed(rpm * std::f64::consts::TAU / 60.0),
            rotation: job::WheelRotation::forward,
            gap: mm(gap),
            azimuth: polishc::units::si::Angle(0.5),
            influence: job::Influence::measured(measured()),
        });
        let problems = polishc::tool::check(&tool, None);
        let said: Vec<(String, String)> =
            problems.into_iter().map(|p| (p.code.to_string(), p.field.unwrap())).collect();
        (tool.standoff(), tool.azimuth(), said)
    };
    assert_eq!(wheel(360.0, 1.0, 60.0), (1e-3, 0.5, vec![]));
    assert_eq!(wheel(360.0, 0.0, 60.0).2, [("E0630".to_string(), "tool.gap".to_string())]);
    assert_eq!(wheel(0.0, -1.0, -60.0).2.len(), 3);
    assert_eq!(wheel(100.0, 60.0, 60.0).2, [("E0630".to_string(), "tool.gap".to_string())]);
}

/// The field of the first thing that is wrong with a tool on a part of this form.
fn wrong(tool: Tool, form: Form) -> (String, String) {
    let files = MemoryFiles::default();
    let surface = polishc::workpiece::form::surface(&form, &files).unwrap();
    let circle = |diameter| crate::workpiece::circle(diameter, None);
    let part = Workpiece { form, ..crate::workpiece::part(circle(50.0), circle(40.0)) };
    let mut problems = InfluenceField::new(&tool, &part, &*surface, &files, &mut Vec::new()).unwrap_err();
    let first = problems.remove(0);
    (first.code.to_string(), first.field.unwrap_or_default())
}

#[test]
fn what_is_wrong_with_a_member_of_a_set_is_said_there() {
    let set = |members: [Influence; 2]| {
        let at = |(i, influence)| InfluenceAt { place: mm(10.0 * i as f64), influence };
        Influence::set(Set { along: Along::radius, at: members.into_iter().enumerate().map(at).collect() })
    };
    let gaussian =
        |sigma: f64| Influence::gaussian(Gaussian { peak: Speed(1e-9), sigma: mm(sigma), diameter: mm(20.0) });
    let wheel = |influence| {
        Tool::mrf_wheel(MrfWheel {
            diameter: mm(100.0),
            speed: AngularSpeed(20.0),
            rotation: job::WheelRotation::forward,
            gap: mm(1.0),
            azimuth: Angle(0.0),
            influence,
        })
    };
    let field = |influence| wrong(wheel(influence), Form::plane(Plane {}));
    assert_eq!(field(gaussian(-1.0)), ("E0620".into(), "tool.influence.sigma".into()));
    assert_eq!(
        field(set([gaussian(3.0), gaussian(-1.0)])),
        ("E0620".into(), "tool.influence.at.1.influence.sigma".into())
    );
    // A cap of 80 mm does not reach the bottom of a hollow of 50 mm: its contact is no circle.
    let bonnet = |influence| {
        Tool::bonnet(Bonnet {
            radius: mm(80.0),
            cap: Angle(0.8),
            offset: mm(0.3),
            pressure: Pressure(1e5),
            spin: Turn { speed: AngularSpeed(50.0), positive: Sense::clockwise, seen: Seen::from_tool_side },
            precession: Precession::upright(Empty {}),
            influence,
        })
    };
    let contact = Influence::bonnet_contact(BonnetContact {
        exponent: 1.0,
        rate: ContactRate::spot_peak(SpotPeak { rate: Speed(1e-9) }),
    });
    let hollow = Form::sphere(Sphere { side: Side::concave, radius: mm(50.0) });
    assert_eq!(wrong(bonnet(contact.clone()), hollow.clone()), ("E0650".into(), "tool.influence".into()));
    assert_eq!(
        wrong(bonnet(set([gaussian(3.0), contact])), hollow),
        ("E0650".into(), "tool.influence.at.1.influence".into())
    );
}
