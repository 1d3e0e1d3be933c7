//! Apertures and the checks of the workpiece, against geometry worked out by hand.

use polishc::job::{Annulus, Aperture, Circle, Form, FormError, HeightMap, Place, Plane, Rectangle, Workpiece};
use polishc::job::{Direction, Empty, MapCentre, Material, Positive, Quantity, Term, View};
use polishc::units::si::Length;
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

/// A part with a map that nothing is done to.
pub fn part(edge: Aperture, clear: Aperture) -> Workpiece {
    Workpiece {
        part: "P1".into(),
        x_mark: None,
        form: Form::plane(Plane {}),
        edge,
        clear,
        material: Material { name: "fused silica".into() },
        error: FormError::height_map(map()),
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
        pixel: None,
        unit: None,
        centre: MapCentre::frame_centre(Empty {}),
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
