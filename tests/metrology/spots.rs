//! Several spots, maps before and after, the age of spots, and how they turn.

use polishc::diagnostics::Problem;
use polishc::height_map::npy;
use polishc::job::{
    Ageing, CentroidNear, Conditions, Direction, Material, Measured, MrfConditions, Origin, PeakNear, PixelAt,
    Positive, Quantity, Spot, TurnsWith, View, WheelRotation,
};
use polishc::source::MemoryFiles;
use polishc::tool::measured::{MeasuredSpots, read};
use polishc::tool::part_to_tool;
use polishc::units::si::{AngularSpeed, Length, Time};

const COLUMNS: usize = 200;
const ROWS: usize = 120;
/// Of a pixel, millimetres.
const PIXEL: f64 = 0.25;
const SIGMA: f64 = 2.0;

/// Depths in nm: for each spot the column and row of its middle and its depth; on a tilted plane.
fn picture(spots: &[(f64, f64, f64)], tilt: f64) -> Vec<u8> {
    let values: Vec<f64> = (0..COLUMNS * ROWS)
        .map(|i| {
            let (column, row) = ((i % COLUMNS) as f64, (i / COLUMNS) as f64);
            let depth = |(c, r, depth): &(f64, f64, f64)| {
                let square = ((column - c).powi(2) + (row - r).powi(2)) * PIXEL * PIXEL;
                depth * (-square / (2.0 * SIGMA * SIGMA)).exp()
            };
            spots.iter().map(depth).sum::<f64>() + tilt * (3.0 + 0.4 * column - 0.7 * row)
        })
        .collect();
    npy::write(COLUMNS, &values).expect("whole rows")
}

fn spot(file: &str, dwell: f64, origin: Origin) -> Spot {
    Spot { file: file.into(), before: None, dwell: Time(dwell), origin, clock: None }
}

fn pixel(column: f64, row: f64) -> Origin {
    Origin::pixel_at(PixelAt { column, row })
}

fn measured(spots: Vec<Spot>) -> Measured {
    Measured {
        spots,
        quantity: Quantity::surface,
        positive: Positive::low,
        view: View::from_tool_side,
        up: Direction::plus_y,
        pixel: Some(Length(PIXEL * 1e-3)),
        unit: Some(Length(1e-9)),
        radius: Length(10e-3),
        turns_with: TurnsWith::tool,
        flow_in_map: None,
        taken: Conditions::mrf_conditions(MrfConditions {
            diameter: Length(0.3),
            speed: AngularSpeed(6.0),
            rotation: WheelRotation::forward,
            gap: Length(1e-3),
            material: Material { name: "glass".into() },
        }),
        ageing: None,
    }
}

fn spots_of(measured: &Measured, maps: &[(&str, Vec<u8>)]) -> (Result<MeasuredSpots, Problem>, Vec<Problem>) {
    let files = MemoryFiles(maps.iter().map(|(name, bytes)| (name.to_string(), bytes.clone())).collect());
    let mut warnings = Vec::new();
    (read(measured, "tool.influence", &files, &mut warnings), warnings)
}

/// Volume of a Gaussian of a nanometre, in nm mm², up to five sigma; the pixels and the baseline resolve it to a thousandth.
fn volume() -> f64 {
    std::f64::consts::TAU * SIGMA * SIGMA
}

#[test]
fn spots_of_one_picture_are_found_apart_and_do_not_tilt_each_other() {
    // 90 nm in 30 s and 60 nm in 20 s: both 3 nm/s. The second one is only pointed at.
    let maps = [("two.npy", picture(&[(55.0, 60.0, 90.0), (145.0, 58.0, 60.0)], 1.0))];
    for near in [
        Origin::peak_near(PeakNear { column: 149.0, row: 55.0 }),
        Origin::centroid_near(CentroidNear { column: 149.0, row: 55.0 }),
    ] {
        let job = measured(vec![spot("two.npy", 30.0, pixel(55.0, 60.0)), spot("two.npy", 20.0, near)]);
        let spots = spots_of(&job, &maps).0.expect("two spots");
        let spread = spots.spread.expect("two of them");
        assert_eq!(spread.spots, 2);
        // Alike but for the baseline, of which each spot bends a little where the other one is not left out.
        assert!(spread.volume.expect("known") < 2e-3 && spread.peak.expect("known") < 2e-3, "{spread:?}");
        assert!((spots.function.rate(0.0, 0.0) * 1e9 - 3.0).abs() < 0.01, "{}", spots.function.rate(0.0, 0.0));
        let found = spots.function.volume_rate() * 1e15;
        assert!((found - 3.0 * volume()).abs() < 3e-3 * 3.0 * volume(), "{found}");
    }
}

#[test]
fn spots_that_lie_on_each_other_are_refused() {
    let maps = [("two.npy", picture(&[(80.0, 60.0, 90.0), (120.0, 60.0, 60.0)], 0.0))];
    let job = measured(vec![spot("two.npy", 30.0, pixel(80.0, 60.0)), spot("two.npy", 20.0, pixel(120.0, 60.0))]);
    let problem = spots_of(&job, &maps).0.expect_err("10 mm apart, of 10 mm radius");
    assert_eq!((problem.code.as_str(), problem.field.as_deref()), ("E0621", Some("tool.influence.spots.0.origin")));
    assert!(problem.message.contains("10.000 mm apart"), "{}", problem.message);
}

#[test]
fn the_map_before_is_taken_off() {
    // The glass stood in a bump of 500 nm before; the second measurement was tilted otherwise.
    let bump = (70.0, 30.0, -500.0);
    let maps = [
        ("before.npy", picture(&[bump], 2.0)),
        ("after.npy", picture(&[bump, (100.0, 60.0, 45.0)], -1.0)),
        ("alone.npy", picture(&[(100.0, 60.0, 45.0)], 0.0)),
    ];
    let with =
        measured(vec![Spot { before: Some("before.npy".into()), ..spot("after.npy", 15.0, pixel(100.0, 60.0)) }]);
    let alone = measured(vec![spot("alone.npy", 15.0, pixel(100.0, 60.0))]);
    let [with, alone] = [with, alone].map(|job| spots_of(&job, &maps).0.expect("a spot"));
    assert!(with.spread.is_none());
    for (x, y) in [(0.0, 0.0), (2e-3, 1e-3), (-4e-3, 3e-3)] {
        let (a, b) = (with.function.rate(x, y), alone.function.rate(x, y));
        assert!((a - b).abs() < 1e-6 * 3e-9, "{a} {b}");
    }
    // The bump's middle lies 10.6 mm from the spot's, 0.3 sigma beyond its radius of 10 mm: 38 % of the bump lie inside, which is four
    // times the volume of the spot (0.38 * 500 / 45). Not taken off, it reads as added glass.
    let forgotten = measured(vec![spot("after.npy", 15.0, pixel(100.0, 60.0))]);
    let problem = spots_of(&forgotten, &maps).0.expect_err("a spot that adds glass");
    assert_eq!((problem.code.as_str(), problem.field.as_deref()), ("E0624", Some("tool.influence.positive")));
}

#[test]
fn maps_of_two_sizes_do_not_belong_together() {
    let tall = npy::write(COLUMNS, &vec![0.0; COLUMNS * (ROWS + 1)]).expect("whole rows");
    let maps = [("before.npy", tall), ("after.npy", picture(&[(100.0, 60.0, 45.0)], 0.0))];
    let job = measured(vec![Spot { before: Some("before.npy".into()), ..spot("after.npy", 15.0, pixel(100.0, 60.0)) }]);
    let problem = spots_of(&job, &maps).0.expect_err("121 rows and 120");
    assert_eq!((problem.code.as_str(), problem.field.as_deref()), ("E0656", Some("tool.influence.spots.0.before")));
    assert!(problem.message.contains("200 x 121") && problem.message.contains("200 x 120"), "{}", problem.message);
}

#[test]
fn an_infinite_pixel_is_no_depth() {
    let values = vec![f64::INFINITY; COLUMNS * ROWS];
    let maps = [("spot.npy", npy::write(COLUMNS, &values).expect("whole rows"))];
    let job = measured(vec![spot("spot.npy", 15.0, pixel(100.0, 60.0))]);
    assert!(spots_of(&job, &maps).0.is_err());
}

/// Three spots of 30, 33 and 27 nm in 10 s each: the mean is 3 nm/s, one standard deviation is 0.3 of it, a tenth.
#[test]
fn the_spread_is_one_standard_deviation() {
    let depths = [30.0, 33.0, 27.0];
    let names = ["a.npy", "b.npy", "c.npy"];
    let maps: Vec<(&str, Vec<u8>)> =
        names.iter().zip(depths).map(|(name, depth)| (*name, picture(&[(100.0, 60.0, depth)], 0.0))).collect();
    let job = measured(names.iter().map(|name| spot(name, 10.0, pixel(100.0, 60.0))).collect());
    let (spots, _) = spots_of(&job, &maps);
    let spots = spots.expect("three spots");
    let spread = spots.spread.expect("three of them");
    for share in [spread.volume, spread.peak] {
        assert!((share.expect("known") - 0.1).abs() < 1e-6, "{share:?}");
    }
    assert_eq!(spread.drift, None);
    let found = spots.function.volume_rate() * 1e15;
    assert!((found - 3.0 * volume()).abs() < 3e-3 * 3.0 * volume(), "{found}");
}

/// 3 nm/s at 0 h, 2.7 nm/s at 10 h: 2.4 nm/s at 20 h, and there a change of -0.03/2.4 an hour.
#[test]
fn the_drift_carries_the_rate_to_the_start_of_the_run() {
    let maps = [("a.npy", picture(&[(100.0, 60.0, 30.0)], 0.0)), ("b.npy", picture(&[(100.0, 60.0, 27.0)], 0.0))];
    let hours = |h: f64| Time(h * 3600.0);
    let at = |file: &str, h: f64| Spot { clock: Some(hours(h)), ..spot(file, 10.0, pixel(100.0, 60.0)) };
    let aged = |now: f64, at_most: f64| Measured {
        ageing: Some(Ageing { now: hours(now), at_most: hours(at_most) }),
        ..measured(vec![at("a.npy", 0.0), at("b.npy", 10.0)])
    };
    let (spots, warnings) = spots_of(&aged(20.0, 10.0), &maps);
    let spots = spots.expect("young enough");
    assert!((spots.function.rate(0.0, 0.0) * 1e9 - 2.4).abs() < 0.01, "{}", spots.function.rate(0.0, 0.0));
    let spread = spots.spread.expect("two of them");
    assert!((spread.drift.expect("two times") * 3600.0 + 0.03 / 2.4).abs() < 1e-6, "{spread:?}");
    // Two spots make the line: nothing is left to tell how well they repeat.
    assert_eq!((spread.volume, spread.peak), (None, None));
    let said: Vec<&str> = warnings.iter().map(|warning| warning.code.as_str()).collect();
    assert!(said.contains(&"W0602"), "{said:?}");
    // In the middle between the spots nothing is carried.
    let (spots, warnings) = spots_of(&aged(5.0, 10.0), &maps);
    assert!((spots.expect("young").function.rate(0.0, 0.0) * 1e9 - 2.85).abs() < 0.01);
    assert!(warnings.iter().all(|warning| warning.code.as_str() != "W0602"));
    let problem = spots_of(&aged(20.0, 9.0), &maps).0.expect_err("ten hours old");
    assert_eq!(problem.code.as_str(), "E0657");
    assert!(problem.message.contains("10.00 h old"), "{}", problem.message);
    let problem = spots_of(&aged(-1.0, 9.0), &maps).0.expect_err("both made after the run");
    assert!(
        problem.code.as_str() == "E0657" && problem.message.contains("after the run starts"),
        "{}",
        problem.message
    );
}

/// A spot with a tail to the right and upwards in a picture of the part, taken from the tool side with the part's +y up: wherever the
/// tool's axis points, its tail lies towards +x and +y of the part. Read as a spot that turns, it is mirrored in the tool frame, whose
/// +y lies clockwise of +x.
#[test]
fn a_spot_that_turns_with_nothing_lies_as_it_was_seen() {
    let maps = [("spot.npy", picture(&[(100.0, 60.0, 30.0), (108.0, 56.0, 10.0)], 0.0))];
    let still =
        Measured { turns_with: TurnsWith::nothing, ..measured(vec![spot("spot.npy", 10.0, pixel(100.0, 60.0))]) };
    let spots = spots_of(&still, &maps).0.expect("a spot");
    // Its field stands at the azimuth 0.
    let rate = |x: f64, y: f64| {
        let [tx, ty] = part_to_tool(x, y, 0.0);
        spots.function.rate(tx, ty) * 1e9
    };
    let expected = |x: f64, y: f64| {
        let gauss = |x: f64, y: f64| (-(x * x + y * y) / (2.0 * SIGMA * SIGMA)).exp();
        3.0 * gauss(x, y) + gauss(x - 2.0, y - 1.0)
    };
    for (x, y) in [(2.0, 1.0), (2.0, -1.0), (-2.0, 1.0), (1.0, 2.5)] {
        let found = rate(x * 1e-3, y * 1e-3);
        assert!((found - expected(x, y)).abs() < 0.02, "{x} {y}: {found}, not {}", expected(x, y));
    }
}
