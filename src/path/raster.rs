//! Raster: parallel straight lines over an aperture.
//!
//! In: the job's `raster`, the surface, and the most points that may be made. Out: the lines of one pass.
//!
//! The rule: in a frame turned by `direction` about the aperture's centre, lines lie at `v = v_0 + j * line_pitch` for
//! j = 0, 1, … while they meet the aperture, `v_0` being its extreme across the lines; points lie on each line at whole
//! multiples of `point_step` about the centre, so that the lattice is symmetric. The boundary belongs to the aperture. A pass
//! turns the frame, and moves all lines by its shift, to whole pitches from `v_0 + shift` that meet the aperture.
//! Where an outline turns inwards, one line of the lattice gives several lines of the path, in order of travel.
//!
//! The lattice lies in the plane across the part's axis and is laid onto the surface along z. On a slope points and
//! lines so lie farther apart, by one over the cosine of the slope in their direction; lengths, speeds and times are
//! those on the surface.

use super::{Laid, Line, Link, Setting, Strategy};
use crate::diagnostics::{Problem, codes};
use crate::job::{Aperture, Lines, Pass, Place, Polygon, Raster};
use crate::units::si::Length;
use crate::workpiece::aperture::BOUNDARY;

/// Points on a line of the lattice: the multiples of the step that they stand on.
struct Stretch {
    first: i64,
    last: i64,
}

/// The lattice without its points: what can be counted before anything is allocated.
struct Lattice<'a> {
    raster: &'a Raster,
    over: Aperture,
    along: [f64; 2],
    across: [f64; 2],
    /// The first line's place across.
    first: f64,
    lines: u64,
}

impl<'a> Lattice<'a> {
    fn new(raster: &'a Raster, pass: Pass) -> Lattice<'a> {
        let (sin, cos) = libm::sincos(raster.direction.0 + pass.turn.0);
        let across = [-sin, cos];
        let [first, last] = raster.over.extent(across);
        // Moved lines begin at the first whole pitch from there that meets the aperture.
        let pitch = raster.line_pitch.0;
        let shift = pass.shift.0 - (pass.shift.0 / pitch).floor() * pitch;
        let first = first + shift;
        let lines = ((last - first + 2.0 * BOUNDARY) / pitch).floor().max(0.0);
        Lattice {
            raster,
            over: grown(&raster.over),
            along: [cos, sin],
            across,
            first,
            // A quotient beyond the range of whole numbers saturates, which the limit then refuses.
            lines: (lines as u64).saturating_add(1),
        }
    }

    fn place(&self, u: f64, v: f64) -> [f64; 2] {
        let [cx, cy] = self.raster.over.centre();
        [cx + u * self.along[0] + v * self.across[0], cy + u * self.along[1] + v * self.across[1]]
    }

    /// The lines of the lattice that hold a point, in order; each has a stretch of points for each of its chords.
    fn iter(&self) -> impl Iterator<Item = (f64, Vec<Stretch>)> + '_ {
        (0..self.lines).filter_map(move |j| {
            let v = self.first + j as f64 * self.raster.line_pitch.0;
            let step = self.raster.point_step.0;
            let chords = self.over.chords(self.place(0.0, v), self.along).into_iter();
            let stretches: Vec<Stretch> = chords
                .map(|[from, to]| Stretch { first: (from / step).ceil() as i64, last: (to / step).floor() as i64 })
                .filter(|stretch| stretch.first <= stretch.last)
                .collect();
            (!stretches.is_empty()).then_some((v, stretches))
        })
    }
}

/// The aperture with its boundary moved outwards by [`BOUNDARY`].
fn grown(aperture: &Aperture) -> Aperture {
    let wider = |length: Length| Length(length.0 + 2.0 * BOUNDARY);
    let mut aperture = aperture.clone();
    match &mut aperture {
        Aperture::circle(a) => a.diameter = wider(a.diameter),
        Aperture::annulus(a) => a.outer_diameter = wider(a.outer_diameter),
        Aperture::rectangle(a) => (a.x, a.y) = (wider(a.x), wider(a.y)),
        Aperture::hexagon(a) => a.across_flats = wider(a.across_flats),
        Aperture::polygon(a) => {
            let corners: Vec<[f64; 2]> = a.vertices.iter().map(|p| [p.x.0, p.y.0]).collect();
            let moved = crate::workpiece::grown(&corners, BOUNDARY);
            *a = Polygon { vertices: moved.iter().map(|[x, y]| Place { x: Length(*x), y: Length(*y) }).collect() };
        }
    }
    aperture
}

impl Strategy for Raster {
    fields_of_lines!();

    /// # Errors
    ///
    /// E0640: a number that is not positive. E0641: more points than there may be, said before any is made. E0642: `over`
    /// has a hole.
    fn lay(&self, pass: Pass, setting: &Setting) -> Result<Laid, Problem> {
        let raster = self;
        super::positive(&[("point_step", raster.point_step.0), ("line_pitch", raster.line_pitch.0)])?;
        if !raster.direction.0.is_finite() {
            return Err(Problem::error(codes::E0640, "path.direction", "`direction` is not a finite angle"));
        }
        if raster.over.has_hole() {
            let message = "the area of a raster has a hole, which a raster cannot leave out";
            return Err(Problem::error(codes::E0642, "path.over", message).help(format!(
                "write `over: circle {{ diameter: {:.6} mm }}`; what happens over the part's hole is said by `holes`",
                raster.over.outer_radius() * 2e3
            )));
        }
        let lattice = Lattice::new(raster, pass);
        let points = count(&lattice, setting.most_points)?;
        let mut laid = Laid { places: Vec::with_capacity(points), ..Laid::default() };
        let link = match raster.lines {
            Lines::serpentine => Link::OnSurface,
            Lines::one_way => Link::Lifted,
        };
        for (j, (v, mut stretches)) in lattice.iter().enumerate() {
            let backwards = raster.lines == Lines::serpentine && j % 2 == 1;
            if backwards {
                stretches.reverse();
            }
            for Stretch { first, last } in stretches {
                let start = laid.places.len();
                for i in 0..=last - first {
                    let multiple = if backwards { last - i } else { first + i };
                    laid.places.push(lattice.place(multiple as f64 * raster.point_step.0, v));
                }
                laid.lines.push(Line { points: start..laid.places.len(), link });
            }
        }
        Ok(laid)
    }
}

/// Points of the lattice, refused as soon as they exceed the limit.
fn count(lattice: &Lattice, most_points: u64) -> Result<usize, Problem> {
    let refuse = |at_least: String| {
        let message = format!("the raster has {at_least} points; the limit is {most_points}");
        Problem::error(codes::E0641, "path", message)
            .help("widen `line_pitch` or `point_step`, or raise the controller's `most_points`")
    };
    // A line may hold no point, but no aperture is so small that most do: the number of lines is bounded first, so
    // that the loop below ends.
    if lattice.lines > most_points.saturating_mul(2).saturating_add(2) {
        return Err(refuse(format!("about {} lines, more than its", lattice.lines)));
    }
    let mut points = 0u64;
    for Stretch { first, last } in lattice.iter().flat_map(|(_, stretches)| stretches) {
        points = points.saturating_add(last.abs_diff(first).saturating_add(1));
        if points > most_points {
            return Err(refuse(format!("more than {most_points}")));
        }
    }
    if points == 0 {
        let message = "the raster holds no point at all";
        return Err(Problem::error(codes::E0640, "path.point_step", message)
            .help("make `point_step` smaller than the area `over`"));
    }
    usize::try_from(points).map_err(|_| refuse(points.to_string()))
}

#[cfg(test)]
mod tests {
    use super::super::examples::{circle, plan_on_plane};
    use super::super::{ToolPath, examples};
    use super::*;
    use crate::job::{self, Annulus, Place, Rectangle};
    use crate::units::si::Angle;

    fn raster(over: Aperture, step_mm: f64, pitch_mm: f64, degrees: f64, lines: Lines) -> Raster {
        Raster {
            over,
            point_step: Length(step_mm * 1e-3),
            line_pitch: Length(pitch_mm * 1e-3),
            direction: Angle(degrees.to_radians()),
            lines,
            chord_error: Length(1e-5),
            holes: None,
            landing: None,
            passes: None,
        }
    }

    fn plan(raster: &Raster, most_points: u64) -> Result<ToolPath, Problem> {
        plan_on_plane(job::Path::raster(raster.clone()), most_points)
    }

    fn planned(raster: &Raster) -> ToolPath {
        plan(raster, 1_000_000).expect("a path")
    }

    #[test]
    fn points_on_the_circle_itself_count() {
        // Radius 5, step 1, pitch 1: lines at y = -5 .. 5. |x| <= sqrt(25 - y²): 0, 3, 4, 4, 4, 5, so
        // 1 + 7 + 9 + 9 + 9 points below, the same above, 11 in the middle: 81. (0, ±5), (±3, ±4), (±4, ±3), (±5, 0) lie
        // on the circle.
        let path = planned(&raster(circle(10.0), 1.0, 1.0, 0.0, Lines::serpentine));
        assert_eq!((path.points.len(), path.lines.len()), (81, 11));
    }

    #[test]
    fn turning_a_circular_raster_changes_no_count() {
        let straight = planned(&raster(circle(10.0), 1.0, 1.0, 0.0, Lines::serpentine));
        for degrees in [30.0, 90.0, -135.0, 180.0] {
            let turned = planned(&raster(circle(10.0), 1.0, 1.0, degrees, Lines::serpentine));
            assert_eq!(turned.points.len(), straight.points.len(), "{degrees} deg");
            // Each point is the straight one, turned.
            let (sin, cos) = libm::sincos(degrees.to_radians());
            for i in 0..turned.points.len() {
                let [x, y, _] = straight.points.position(i);
                let [tx, ty, _] = turned.points.position(i);
                assert!((tx - (x * cos - y * sin)).abs() < 1e-15 && (ty - (x * sin + y * cos)).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn rectangle_keeps_its_centre_and_its_border() {
        let over = Aperture::rectangle(Rectangle {
            x: Length(0.010),
            y: Length(0.006),
            centre: Some(Place { x: Length(0.1), y: Length(-0.05) }),
        });
        // x: -5 .. 5 in steps of 2 about the centre is -4 .. 4, five points; y: -3 .. 3 by 1.5, five lines.
        let path = planned(&raster(over.clone(), 2.0, 1.5, 0.0, Lines::one_way));
        assert_eq!((path.points.len(), path.lines.len()), (25, 5));
        let [x, y, z] = path.points.position(0);
        assert!((x - 0.096).abs() < 1e-15 && (y + 0.053).abs() < 1e-15 && z == 0.0);
        assert!(path.lines.iter().all(|line| line.link == Link::Lifted));
        // Along y the sides change roles: y: -2 .. 2 by 2, three points; x: -5 .. 5 by 1.5, seven lines.
        let path = planned(&raster(over, 2.0, 1.5, 90.0, Lines::one_way));
        assert_eq!((path.points.len(), path.lines.len()), (21, 7));
    }

    #[test]
    fn a_rectangle_turned_by_45_degrees_loses_the_empty_corners() {
        // A square of side 10 seen along its diagonal: lines at v = -7.071 + 2 j, j = 0 .. 7, half chords
        // 7.071 - |v|: 0, 2, 4, 6, 6.142, 4.142, 2.142, 0.142. Multiples of 3 inside: 1, 1, 3, 5, 5, 3, 1, 1.
        let over = Aperture::rectangle(Rectangle { x: Length(0.01), y: Length(0.01), centre: None });
        let path = planned(&raster(over, 3.0, 2.0, 45.0, Lines::serpentine));
        let counts: Vec<usize> = path.lines.iter().map(|line| line.points.len()).collect();
        assert_eq!(counts, [1, 1, 3, 5, 5, 3, 1, 1]);
    }

    /// 12 x 10 with a notch of 4 x 6 in its upper side. Lines at y = -5 .. 5 by 2: at -5, -3, -1 one stretch, at 1, 3, 5
    /// two; points at multiples of 2: -6 .. 6 are 7, and -6 .. -2 with 2 .. 6 are 3 and 3.
    #[test]
    fn an_outline_that_turns_inwards_has_several_lines_in_one() {
        let corners = [(-6, -5), (6, -5), (6, 5), (2, 5), (2, -1), (-2, -1), (-2, 5), (-6, 5)];
        let place = |(x, y): (i32, i32)| Place { x: Length(f64::from(x) * 1e-3), y: Length(f64::from(y) * 1e-3) };
        let over = Aperture::polygon(Polygon { vertices: corners.map(place).to_vec() });
        let path = planned(&raster(over.clone(), 2.0, 2.0, 0.0, Lines::serpentine));
        let counts: Vec<usize> = path.lines.iter().map(|line| line.points.len()).collect();
        assert_eq!(counts, [7, 7, 7, 3, 3, 3, 3, 3, 3]);
        // Backwards on every second line of the lattice: the right stretch first.
        let ends: Vec<[i32; 2]> = path.lines[3..7]
            .iter()
            .map(|line| [line.points.start, line.points.end - 1].map(|i| (path.points.x[i] * 1e3).round() as i32))
            .collect();
        assert_eq!(ends, [[6, 2], [-2, -6], [-6, -2], [2, 6]]);
        // One way always from left to right.
        let path = planned(&raster(over, 2.0, 2.0, 0.0, Lines::one_way));
        assert!(path.lines.iter().all(|line| path.points.x[line.points.start] < path.points.x[line.points.end - 1]));
    }

    #[test]
    fn serpentine_never_jumps_and_one_way_never_turns() {
        let path = planned(&raster(circle(50.0), 1.0, 0.5, 20.0, Lines::serpentine));
        for pair in path.lines.windows(2) {
            let [end, start] = [pair[0].points.end - 1, pair[1].points.start].map(|i| path.points.position(i));
            // From one line to the next along the circle of radius 25: never farther than the chord that drops one
            // pitch at the pole, sqrt(2 * 25 * 0.5) = 5 mm, and a step at either end.
            assert!(libm::hypot(end[0] - start[0], end[1] - start[1]) <= 7.1e-3);
        }
        let way = |path: &ToolPath, line: &Line| {
            let [a, b] = [line.points.start, line.points.end - 1].map(|i| path.points.position(i));
            b[0] - a[0]
        };
        let signs: Vec<bool> = path.lines.iter().filter(|l| l.points.len() > 1).map(|l| way(&path, l) > 0.0).collect();
        assert!(signs.windows(2).all(|pair| pair[0] != pair[1]));
        let path = planned(&raster(circle(50.0), 1.0, 0.5, 20.0, Lines::one_way));
        assert!(path.lines.iter().filter(|l| l.points.len() > 1).all(|l| way(&path, l) > 0.0));
    }

    #[test]
    fn normals_point_out_of_the_glass() {
        let path = planned(&raster(circle(10.0), 1.0, 1.0, 0.0, Lines::serpentine));
        assert!((0..path.points.len()).all(|i| path.points.normal(i) == [0.0, 0.0, 1.0]));
    }

    #[test]
    fn too_many_points_are_refused_before_they_are_made() {
        for (step, pitch) in [(1e-6, 1e-6), (1e-300, 1.0), (1.0, 1e-300), (0.01, 0.01)] {
            let problem = plan(&raster(circle(380.0), step, pitch, 0.0, Lines::serpentine), 100_000).unwrap_err();
            assert_eq!(problem.code, codes::E0641, "{step} {pitch}");
        }
        let exact = raster(circle(10.0), 1.0, 1.0, 0.0, Lines::serpentine);
        assert!(plan(&exact, 81).is_ok());
        assert_eq!(plan(&exact, 80).unwrap_err().code, codes::E0641);
    }

    #[test]
    fn what_is_no_raster_is_refused() {
        let code = |raster: &Raster| plan(raster, 1000).unwrap_err().code;
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(code(&raster(circle(10.0), bad, 1.0, 0.0, Lines::serpentine)), codes::E0640);
            assert_eq!(code(&raster(circle(10.0), 1.0, bad, 0.0, Lines::serpentine)), codes::E0640);
        }
        assert_eq!(code(&raster(circle(10.0), 1.0, 1.0, f64::NAN, Lines::serpentine)), codes::E0640);
        let ring =
            Aperture::annulus(Annulus { outer_diameter: Length(0.01), inner_diameter: Length(0.005), centre: None });
        assert_eq!(code(&raster(ring, 1.0, 1.0, 0.0, Lines::serpentine)), codes::E0642);
    }

    /// 10 x 6 in steps of 2 by lines of 1.5: 25 points on five lines at y = -3 .. 3. A second pass turned by 90 degrees and
    /// moved by 0.5: lines at u = -5 + 0.5 + 1.5 j up to 4, seven, with points at y = -2, 0, 2; seen from its own frame v
    /// runs along -x.
    #[test]
    fn passes_are_turned_and_moved_and_lifted_between() {
        let over = Aperture::rectangle(Rectangle { x: Length(0.010), y: Length(0.006), centre: None });
        let mut two = raster(over, 2.0, 1.5, 0.0, Lines::serpentine);
        let pass = |degrees: f64, mm: f64| Pass { turn: Angle(degrees.to_radians()), shift: Length(mm * 1e-3) };
        two.passes = Some(vec![pass(0.0, 0.0), pass(90.0, 0.5)]);
        let path = planned(&two);
        assert_eq!((path.points.len(), path.lines.len()), (25 + 21, 5 + 7));
        let links: Vec<Link> = path.lines.iter().map(|line| line.link).collect();
        assert_eq!(links[4], Link::Lifted);
        assert!(links.iter().enumerate().all(|(i, link)| i == 4 || *link == Link::OnSurface));
        for (j, line) in path.lines[5..].iter().enumerate() {
            let x = 4.5e-3 - 1.5e-3 * j as f64;
            assert!(line.points.clone().all(|i| (path.points.x[i] - x).abs() < 1e-15), "line {j}");
        }
        // A shift by a whole pitch, either way, changes nothing.
        let moved = |mm: f64| {
            let mut one = raster(examples::circle(10.0), 1.0, 1.0, 0.0, Lines::serpentine);
            one.passes = Some(vec![pass(0.0, mm)]);
            planned(&one).points.len()
        };
        assert_eq!((moved(0.0), moved(3.0), moved(-2.0)), (81, 81, 81));
    }
}
