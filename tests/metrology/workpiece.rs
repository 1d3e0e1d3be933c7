//! Apertures and the checks of the workpiece, against geometry worked out by hand.

use polishc::job::{
    Annulus, Aperture, Circle, Form, FormError, HeightMap, Hexagon, Place, Plane, Polygon, Rectangle, Workpiece,
};
use polishc::job::{Direction, Empty, MapCentre, Material, Positive, Quantity, Term, View};
use polishc::units::si::{Angle, Length};
use polishc::workpiece;

pub fn mm(value: f64) -> Length {
    Length(value * 1e-3)
}

pub fn at(x: f64, y: f64) -> Option<Place> {
    Some(Place { x: mm(x), y: mm(y) })
}

pub fn circle(diameter: f64, centre: Option<Place>) -> Aperture {
    Aperture::circle(Circle { diameter: mm(diameter), centre })
}

pub fn annulus(outer: f64, inner: f64, centre: Option<Place>) -> Aperture {
    Aperture::annulus(Annulus { outer_diameter: mm(outer), inner_diameter: mm(inner), centre })
}

pub fn rectangle(x: f64, y: f64, centre: Option<Place>) -> Aperture {
    Aperture::rectangle(Rectangle { x: mm(x), y: mm(y), centre })
}

pub fn hexagon(across_flats: f64, degrees: f64, centre: Option<Place>) -> Aperture {
    Aperture::hexagon(Hexagon { across_flats: mm(across_flats), direction: Angle(degrees.to_radians()), centre })
}

pub fn polygon(vertices: &[[f64; 2]]) -> Aperture {
    Aperture::polygon(Polygon { vertices: vertices.iter().map(|[x, y]| Place { x: mm(*x), y: mm(*y) }).collect() })
}

/// 40 x 30 with a notch of 10 x 15 taken out of the middle of its upper side.
const NOTCHED: [[f64; 2]; 8] =
    [[-20.0, -15.0], [20.0, -15.0], [20.0, 15.0], [5.0, 15.0], [5.0, 0.0], [-5.0, 0.0], [-5.0, 15.0], [-20.0, 15.0]];

/// A part with a map that nothing is done to.
pub fn part(edge: Aperture, clear: Aperture) -> Workpiece {
    Workpiece {
        part: "P1".into(),
        x_mark: None,
        form: Form::plane(Plane {}),
        edge,
        clear,
        material: Material { name: "fused silica".into() },
        fiducials: None,
        error: FormError::height_map(Box::new(map())),
        target: None,
    }
}

pub fn map() -> HeightMap {
    HeightMap {
        file: "map.dat".into(),
        quantity: Quantity::surface,
        positive: Positive::high,
        view: View::from_tool_side,
        up: Direction::plus_y,
        subtract: Vec::<Term>::new(),
        rotated: None,
        pixel: None,
        unit: None,
        centre: MapCentre::frame_centre(Empty {}),
        fiducials: None,
        mask: None,
        leave_out: None,
        trim: None,
        despike: None,
        fill_below: None,
    }
}

fn distance_mm(aperture: &Aperture, x: f64, y: f64) -> f64 {
    aperture.distance(x * 1e-3, y * 1e-3) * 1e3
}

#[test]
fn distances_are_those_of_a_drawing() {
    let c = circle(20.0, at(3.0, 4.0));
    let a = annulus(20.0, 8.0, None);
    let r = rectangle(20.0, 10.0, at(1.0, 0.0));
    for (aperture, x, y, expected) in [
        (&c, 3.0, 4.0, 10.0),
        (&c, 0.0, 0.0, 5.0),    // 3-4-5 triangle: 10 - 5
        (&c, 15.0, 9.0, -3.0),  // 12-5-13 triangle: 10 - 13
        (&a, 7.0, 0.0, 3.0),    // halfway in the ring
        (&a, 0.0, 5.0, 1.0),    // nearer to the hole
        (&a, 0.0, 0.0, -4.0),   // in the hole
        (&a, 0.0, -12.0, -2.0), // outside
        (&r, 1.0, 0.0, 5.0),    // the middle
        (&r, 10.0, 0.0, 1.0),   // near the +x side, which stands at 11
        (&r, 1.0, 8.0, -3.0),   // beyond the +y side
        (&r, 14.0, -9.0, -5.0), // beyond a corner: 3-4-5
    ] {
        let found = distance_mm(aperture, x, y);
        assert!((found - expected).abs() < 1e-12, "{aperture:?} at {x}, {y}: {found}, expected {expected}");
        assert_eq!(aperture.contains(x * 1e-3, y * 1e-3), expected >= 0.0);
    }
}

/// Pixels of 1 mm about the middle of a circle of 54 mm, as a map lays them: the four on its boundary, (±27, 0) and
/// (0, ±27), belong to it whatever the last bits of `-0.03 + 57 * 0.001` are. By whole numbers, x² + y² <= 27² holds
/// for 2289 pairs.
#[test]
fn a_boundary_belongs_to_the_aperture_on_every_side() {
    let places = |i: usize| -0.03 + i as f64 * 1e-3;
    let whole =
        (-30..=30_i32).flat_map(|x| (-30..=30_i32).map(move |y| x * x + y * y)).filter(|r| *r <= 27 * 27).count();
    assert_eq!(whole, 2289);
    for aperture in [circle(54.0, None), annulus(54.0, 1.0, None)] {
        let inside = |i: usize| aperture.contains(places(i % 61), places(i / 61));
        // The ring's hole of 1 mm takes the middle pixel away.
        let hole = usize::from(aperture.has_hole());
        assert_eq!((0..61 * 61).filter(|i| inside(*i)).count(), whole - hole, "{aperture:?}");
    }
    let square = rectangle(54.0, 54.0, None);
    assert_eq!((0..61 * 61).filter(|i| square.contains(places(i % 61), places(i / 61))).count(), 55 * 55);
}

#[test]
fn sizes_are_those_of_a_drawing() {
    let a = annulus(20.0, 8.0, at(1.0, 2.0));
    // Pi (10² - 4²) mm².
    assert!((a.area() * 1e6 - 84.0 * std::f64::consts::PI).abs() < 1e-10);
    let bounds = a.bounds();
    for (found, expected) in
        [bounds.min[0], bounds.min[1], bounds.max[0], bounds.max[1]].iter().zip([-9.0, -8.0, 11.0, 12.0])
    {
        assert!((found * 1e3 - expected).abs() < 1e-12);
    }
    assert!(a.has_hole() && (a.outer_radius() - 0.010).abs() < 1e-15);
    let r = rectangle(6.0, 8.0, None);
    assert!(!r.has_hole() && (r.outer_radius() - 0.005).abs() < 1e-15 && (r.area() - 48e-6).abs() < 1e-18);
}

#[test]
fn chords_are_those_of_a_drawing() {
    let close = |found: Vec<[f64; 2]>, expected: &[[f64; 2]]| {
        assert_eq!(found.len(), expected.len(), "{found:?} {expected:?}");
        for (f, e) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((f * 1e3 - e).abs() < 1e-12, "{found:?} {expected:?}");
        }
    };
    let line =
        |aperture: &Aperture, x: f64, y: f64, direction: [f64; 2]| aperture.chords([x * 1e-3, y * 1e-3], direction);
    let along_x = [1.0, 0.0];
    // 6-8-10 triangle: at y = 6 a circle of radius 10 has the half chord 8.
    close(line(&circle(20.0, None), 0.0, 6.0, along_x), &[[-8.0, 8.0]]);
    // The same from another point of the line, backwards, and off centre.
    close(line(&circle(20.0, at(5.0, 1.0)), 3.0, 7.0, [-1.0, 0.0]), &[[-10.0, 6.0]]);
    // Along a slope of 3 to 4 through the centre.
    close(line(&circle(20.0, None), 0.0, 0.0, [0.8, 0.6]), &[[-10.0, 10.0]]);
    // A ring: through the hole (3-4-5 with radius 5) and past it.
    close(line(&annulus(20.0, 10.0, None), 0.0, 0.0, along_x), &[[-10.0, -5.0], [5.0, 10.0]]);
    close(line(&annulus(20.0, 10.0, None), 0.0, 6.0, along_x), &[[-8.0, 8.0]]);
    close(line(&annulus(20.0, 10.0, None), 0.0, 10.0, along_x), &[]);
    close(line(&circle(20.0, None), 0.0, -11.0, along_x), &[]);
    // A box 12 x 6: along x, and along the diagonal of a 3-4-5 triangle through its centre (leaves at y = ±3).
    close(line(&rectangle(12.0, 6.0, None), 1.0, 2.0, along_x), &[[-7.0, 5.0]]);
    close(line(&rectangle(12.0, 6.0, None), 0.0, 0.0, [0.8, 0.6]), &[[-5.0, 5.0]]);
    close(line(&rectangle(12.0, 6.0, None), 0.0, 3.5, along_x), &[]);
    close(line(&rectangle(12.0, 6.0, None), 20.0, 0.0, [0.0, 1.0]), &[]);
}

#[test]
fn impossible_apertures_are_refused() {
    let said = |edge: Aperture, clear: Aperture| -> Vec<(String, String, String)> {
        let problems = workpiece::check(&part(edge, clear));
        problems.into_iter().map(|p| (p.code.to_string(), p.field.unwrap(), p.message)).collect()
    };
    assert_eq!(said(annulus(340.0, 60.0, None), annulus(323.0, 70.0, None)), vec![]);
    assert_eq!(said(circle(50.0, None), circle(50.0, None)), vec![], "a clear aperture may be as large as the part");
    assert_eq!(said(annulus(340.0, 60.0, at(1.0, 2.0)), annulus(340.0, 60.0, at(1.0, 2.0))), vec![]);
    assert_eq!(said(rectangle(40.0, 30.0, None), rectangle(40.0, 30.0, None)), vec![]);

    let found = said(annulus(60.0, 340.0, None), circle(0.0, None));
    assert_eq!(found[0].0, "E0600");
    assert_eq!(found[0].1, "workpiece.edge.inner_diameter");
    assert_eq!(
        (found[1].1.as_str(), found[1].2.as_str()),
        ("workpiece.clear.diameter", "`diameter` is 0.000 mm; it must be positive")
    );
    assert_eq!(said(rectangle(10.0, f64::NAN, None), circle(1.0, None))[0].1, "workpiece.edge.y");

    // The ring's hole is covered; a circle moved by 3-4 sticks out by 5; a box in a circle at its corner (30, 40): 50 - 45.
    for (edge, clear, words) in [
        (
            annulus(340.0, 60.0, None),
            circle(323.0, None),
            "reaches into the hole of the part, which has 60.000 mm diameter",
        ),
        (annulus(340.0, 60.0, None), annulus(323.0, 59.0, None), "reaches into the hole"),
        (
            circle(100.0, None),
            circle(100.0, at(3.0, 4.0)),
            "reaches 5.000 mm beyond the edge of the part at x 33.000 mm, y 44.000 mm",
        ),
        (circle(90.0, None), rectangle(60.0, 80.0, None), "reaches 5.000 mm beyond the edge"),
        (rectangle(40.0, 30.0, None), circle(34.0, None), "reaches 2.000 mm beyond the edge"),
    ] {
        let found = said(edge, clear);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].0.as_str(), found[0].1.as_str()), ("E0601", "workpiece.clear"));
        assert!(found[0].2.contains(words), "{}", found[0].2);
    }
}

#[test]
fn hexagons_are_those_of_a_drawing() {
    // Across flats 20: inscribed radius 10, corners at 20 / sqrt 3; flats at +x and -x, corners at +y and -y.
    let corner = 20.0 / 3_f64.sqrt();
    let upright = hexagon(20.0, 0.0, at(1.0, 2.0));
    for (x, y, expected) in [
        (1.0, 2.0, 10.0),
        (8.0, 2.0, 3.0),           // 3 from the flat at x = 11
        (13.0, 2.0, -2.0),         // beyond it
        (1.0, 2.0 + corner, 0.0),  // a corner
        (1.0, 7.0 + corner, -5.0), // beyond a corner, straight out
    ] {
        let found = distance_mm(&upright, x, y);
        assert!((found - expected).abs() < 1e-12, "{x}, {y}: {found}, expected {expected}");
    }
    let bounds = upright.bounds();
    for (found, expected) in bounds.min.iter().chain(&bounds.max).zip([-9.0, 2.0 - corner, 11.0, 2.0 + corner]) {
        assert!((found * 1e3 - expected).abs() < 1e-12);
    }
    // Area: (sqrt 3 / 2) of the square over the flats.
    assert!((upright.area() * 1e6 - 3_f64.sqrt() / 2.0 * 400.0).abs() < 1e-10);
    assert!((upright.outer_radius() * 1e3 - corner).abs() < 1e-12);
    // Turned by 30 degrees the flats lie at +y and -y; by 60 it is the same.
    assert!((distance_mm(&hexagon(20.0, 30.0, None), 0.0, 7.0) - 3.0).abs() < 1e-12);
    for (x, y) in [(3.0, 4.0), (-9.0, 5.0), (12.0, -1.0)] {
        let turned = distance_mm(&hexagon(20.0, 60.0, None), x, y);
        assert!((distance_mm(&hexagon(20.0, 0.0, None), x, y) - turned).abs() < 1e-12);
    }
    let chord = hexagon(20.0, 0.0, None).chords([0.0, 3e-3], [1.0, 0.0]);
    assert!(chord.len() == 1 && (chord[0][0] * 1e3 + 10.0).abs() < 1e-12 && (chord[0][1] * 1e3 - 10.0).abs() < 1e-12);
    let [low, high] = hexagon(20.0, 0.0, None).extent([0.0, 1.0]);
    assert!((low * 1e3 + corner).abs() < 1e-12 && (high * 1e3 - corner).abs() < 1e-12);
}

#[test]
fn polygons_are_those_of_a_drawing() {
    for vertices in [NOTCHED.to_vec(), NOTCHED.iter().rev().copied().collect()] {
        let notched = polygon(&vertices);
        for (x, y, expected) in [
            (0.0, -10.0, 5.0),  // over the lower side
            (0.0, -2.0, 2.0),   // under the notch
            (0.0, 5.0, -5.0),   // in the notch, 5 from each wall and from its bottom
            (8.0, 10.0, 3.0),   // right of the notch
            (24.0, 18.0, -5.0), // beyond a corner: 3-4-5
            (8.0, -4.0, 5.0),   // 3-4-5 from the corner that points inwards
        ] {
            let found = distance_mm(&notched, x, y);
            assert!((found - expected).abs() < 1e-12, "{x}, {y}: {found}, expected {expected}");
            assert_eq!(notched.contains(x * 1e-3, y * 1e-3), expected >= 0.0);
        }
        assert!((notched.area() * 1e6 - (1200.0 - 150.0)).abs() < 1e-10);
        let chords = |y: f64| notched.chords([0.0, y * 1e-3], [1.0, 0.0]);
        let across = chords(5.0);
        assert_eq!(across.len(), 2);
        for (found, expected) in across.iter().flatten().zip([-20.0, -5.0, 5.0, 20.0]) {
            assert!((found * 1e3 - expected).abs() < 1e-12, "{across:?}");
        }
        assert_eq!((chords(-5.0).len(), chords(16.0).len()), (1, 0));
        // Every place of the outline lies on it, no two neighbours farther apart than asked.
        let outline = notched.outline(1e-3);
        assert!(outline.iter().all(|[x, y]| notched.distance(*x, *y).abs() < 1e-12));
        assert!(outline.windows(2).all(|p| (p[0][0] - p[1][0]).hypot(p[0][1] - p[1][1]) < 1.0001e-3));
    }
}

#[test]
fn a_clear_aperture_with_straight_sides_must_lie_on_the_part() {
    let said = |edge: Aperture, clear: Aperture| -> Vec<String> {
        workpiece::check(&part(edge, clear)).into_iter().map(|p| format!("{}: {}", p.code, p.message)).collect()
    };
    let good = Vec::<String>::new();
    assert_eq!(said(hexagon(50.0, 15.0, None), hexagon(50.0, 15.0, None)), good);
    assert_eq!(said(hexagon(50.0, 15.0, None), hexagon(50.0, 75.0, None)), good, "the same hexagon");
    assert_eq!(said(hexagon(50.0, 15.0, None), circle(50.0, None)), good);
    assert_eq!(said(circle(60.0, None), hexagon(50.0, 15.0, None)), good, "corners at 28.9");
    assert_eq!(said(polygon(&NOTCHED), polygon(&NOTCHED)), good);
    assert_eq!(said(polygon(&NOTCHED), rectangle(30.0, 14.0, at(0.0, -7.5))), good);
    for (edge, clear, words) in [
        // The circle of 26 stands 1 beyond each flat of 25.
        (hexagon(50.0, 0.0, None), circle(52.0, None), "reaches 1.000 mm beyond the edge"),
        // The corner at 28.868 of a hexagon in a circle of 27.
        (circle(54.0, None), hexagon(50.0, 0.0, None), "reaches 1.868 mm beyond the edge"),
        // Every corner of the rectangle lies on the part, but the notch runs into it: the middle of its bottom lies 14 mm
        // inside the rectangle.
        (polygon(&NOTCHED), rectangle(30.0, 28.0, at(0.0, 0.0)), "reaches 14.000 mm beyond the edge"),
        // A circle over the notch: 4 beyond its bottom side.
        (polygon(&NOTCHED), circle(20.0, at(0.0, -6.0)), "beyond the edge"),
    ] {
        let found = said(edge, clear);
        assert_eq!(found.len(), 1);
        assert!(found[0].starts_with("E0601") && found[0].contains(words), "{found:?}");
    }
}

#[test]
fn outlines_that_cross_themselves_are_refused() {
    let code = |vertices: &[[f64; 2]]| {
        workpiece::aperture::check(&polygon(vertices), "workpiece.edge").map(|p| (p.code.to_string(), p.field.unwrap()))
    };
    let refused = |field: &str| Some(("E0604".to_string(), format!("workpiece.edge.{field}")));
    assert_eq!(code(&NOTCHED), None);
    assert_eq!(code(&[[0.0, 0.0], [1.0, 0.0]]), refused("vertices"));
    assert_eq!(code(&[[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [9.0, 9.0]]), refused("vertices.3"));
    assert_eq!(code(&[[0.0, 0.0], [9.0, 9.0], [9.0, 0.0], [0.0, 9.0]]), refused("vertices.2"));
    // A side that runs back over the one before, and a corner that touches a far side.
    assert_eq!(code(&[[0.0, 0.0], [9.0, 0.0], [4.0, 0.0], [4.0, 9.0]]), refused("vertices.1"));
    assert_eq!(code(&[[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [4.0, 0.0], [0.0, 9.0]]), refused("vertices.2"));
    assert_eq!(code(&[[0.0, 0.0], [f64::NAN, 0.0], [9.0, 9.0]]), refused("vertices.1"));
    let negative = workpiece::aperture::check(&hexagon(-1.0, 0.0, None), "workpiece.edge").expect("a refusal");
    assert_eq!(negative.code.to_string(), "E0600");
}
