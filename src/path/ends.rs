//! Where lines start and end: the tool stands still there, so it must not stand over the glass, unless the job says how it
//! lands.
//!
//! In: a [`ToolPath`], the part's edge, how far the spot reaches and how fast the tool gets to speed. Out: how far the
//! line ends lie beyond the edge, or a refusal that says by how much the path must grow.
//!
//! Where a path with a landing is lifted, what the standing tool removes is known, and part of the solved dwell. Where it
//! goes on along the surface from line to line, it is not.

use super::{Link, ToolPath};
use crate::diagnostics::{Problem, codes};
use crate::job::Aperture;

/// How the ends of the lines lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineEnds {
    /// Least distance of a line end, or of the way from one line to the next, beyond the part's edge, metres; negative where
    /// the tool lands on the part.
    pub least_overrun: f64,
    /// What every line would need so that the tool reaches full feed before its spot touches the part, metres: the
    /// spot's radius and `v²/2a`. Where the overrun is smaller, the solver reckons with the ramp.
    pub full_feed_overrun: f64,
    /// How often the tool comes down or goes up where its spot touches the part.
    pub landings: usize,
}

/// Checks that at both ends of every line, and on the way to the next line where the tool stays on the surface, the spot
/// stands clear of the part; at the ends where it is lifted only if the path has no landing.
///
/// # Errors
///
/// E0644 if the spot, standing still, would touch the part.
pub fn check(
    path: &ToolPath,
    edge: &Aperture,
    spot_radius: f64,
    feed: f64,
    acceleration: f64,
) -> Result<LineEnds, Problem> {
    // The least, its place, and whether the tool is lifted there, so that it could land.
    let mut least = (f64::INFINITY, [0.0; 2], false);
    let (mut landed, mut landings) = (f64::INFINITY, 0);
    let mut look = |[x, y]: [f64; 2], lifted: bool| {
        // The distance is that to the outer boundary: the hole of a ring is no place to stand either.
        let overrun = outside(edge, x, y);
        if overrun < least.0 {
            least = (overrun, [x, y], lifted);
        }
    };
    let mut lifted = true;
    for (i, line) in path.lines.iter().enumerate() {
        let [first, last] = [line.points.start, line.points.end - 1].map(|p| path.points.position(p));
        let down = std::mem::replace(&mut lifted, line.link == Link::Lifted || i + 1 == path.lines.len());
        for (place, lands) in [(first, down), (last, lifted)] {
            if lands && path.landing.is_some() {
                let overrun = outside(edge, place[0], place[1]);
                landed = landed.min(overrun);
                landings += usize::from(overrun < spot_radius);
            } else {
                look([place[0], place[1]], lands);
            }
        }
        if let (Link::OnSurface, Some(next)) = (line.link, path.lines.get(i + 1)) {
            let next = path.points.position(next.points.start);
            // Along the whole way, its middle included, at places no farther apart than a tenth of the spot's radius: between
            // them the edge is nearer by no more than a twentieth. However long the way is: removal is summed up in finer steps.
            let length = libm::hypot(next[0] - last[0], next[1] - last[1]);
            let parts = 2 * (5.0 * length / spot_radius).ceil() as usize;
            for k in 1..parts {
                let t = k as f64 / parts as f64;
                look([last[0] + t * (next[0] - last[0]), last[1] + t * (next[1] - last[1])], false);
            }
        }
    }
    let (least_overrun, [x, y], lifted) = least;
    let full_feed_overrun = spot_radius + feed * feed / (2.0 * acceleration);
    if least_overrun < spot_radius {
        // Lines end at whole point steps, so that a little more room may not yet move their ends.
        let step = path.lines.iter().find_map(|line| {
            let [a, b] =
                [line.points.start, line.points.start + 1].map(|p| path.points.position(p.min(line.points.end - 1)));
            let step = libm::hypot(b[0] - a[0], b[1] - a[1]);
            (step > 0.0).then_some(step)
        });
        // In whole tenths of a millimetre, upwards.
        let wider = ((spot_radius - least_overrun + step.unwrap_or(0.0)) * 1e4).ceil() / 10.0;
        let side = if least_overrun < 0.0 { "inside" } else { "beyond" };
        let message = format!(
            "the tool stands still {:.3} mm {side} the edge at x {:.3} mm, y {:.3} mm, where its spot of {:.3} mm \
             radius still touches the part",
            least_overrun.abs() * 1e3,
            x * 1e3 + 0.0,
            y * 1e3 + 0.0,
            spot_radius * 1e3
        );
        let mut help = format!(
            "let `over` reach {wider:.1} mm farther out on every side (that is, {:.1} mm more in diameter)",
            2.0 * wider
        );
        // Far inside the part, as at the centre of a spiral, a larger area moves nothing.
        let deep = least_overrun < -spot_radius;
        let land = "say how the tool lands there: `landing: landing { speed: …, reach: …, stand: … }`";
        if lifted {
            help = if deep { land.to_string() } else { format!("{help}, or {land}") };
        }
        return Err(Problem::error(codes::E0644, "path.over", message)
            .note(
                "a standing tool removes most of all; every line must start and end off the part, or say how it lands",
            )
            .help(help));
    }
    Ok(LineEnds { least_overrun: least_overrun.min(landed), full_feed_overrun, landings })
}

/// W0645 if the last run ends over the part: the process is switched off there.
pub fn check_last(path: &ToolPath, edge: &Aperture, spot_radius: f64) -> Option<Problem> {
    let last = path.points.len().checked_sub(1)?;
    let [x, y, _] = path.points.position(last);
    if outside(edge, x, y) >= spot_radius {
        return None;
    }
    let message = format!(
        "the path ends over the part, at x {:.3} mm, y {:.3} mm: the process is switched off there, the tool lifted",
        x * 1e3 + 0.0,
        y * 1e3 + 0.0
    );
    Some(
        Problem::warning(codes::W0645, "path.landing", message)
            .note("what drips while a wheel runs down falls on the part")
            .help("let the path end off the part: a spiral and rings with `start: inside`, other paths over a larger `over`"),
    )
}

/// Distance beyond the outer boundary, negative on the part and in its hole.
pub(super) fn outside(edge: &Aperture, x: f64, y: f64) -> f64 {
    match edge {
        Aperture::annulus(a) => {
            let [cx, cy] = edge.centre();
            libm::hypot(x - cx, y - cy) - a.outer_diameter.0 / 2.0
        }
        solid => -solid.distance(x, y),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{Circle, Landing};
    use crate::path::{Line, Points};
    use crate::units::si::{Length, Speed, Time};

    /// One line along x from -`reach` to `reach` millimetres.
    fn line(reach: f64) -> ToolPath {
        let mut points = Points::default();
        for x in [-reach, 0.0, reach] {
            points.push([x * 1e-3, 0.0, 0.0], [0.0, 0.0, 1.0]);
        }
        ToolPath { points, lines: vec![Line { points: 0..3, link: Link::OnSurface }], ..ToolPath::default() }
    }

    fn part() -> Aperture {
        Aperture::circle(Circle { diameter: Length(0.1), centre: None })
    }

    #[test]
    fn overrun_is_the_distance_beyond_the_edge() {
        // Part radius 50, line to 62: 12 mm beyond. At 100 mm/s and 500 mm/s² the ramp is 10 mm, the spot 8 mm.
        let ends = check(&line(62.0), &part(), 8e-3, 0.1, 0.5).expect("clear of the part");
        assert!((ends.least_overrun - 12e-3).abs() < 1e-15);
        assert!((ends.full_feed_overrun - 18e-3).abs() < 1e-15);
    }

    #[test]
    fn standing_over_the_part_is_refused_with_the_distance_that_is_missing() {
        let problem = check(&line(57.0), &part(), 8e-3, 0.1, 0.5).unwrap_err();
        assert_eq!(problem.code, codes::E0644);
        // 1 mm is missing, and a point step of 57 mm may have to be added before the ends move.
        assert!(problem.help.expect("a mend").contains("58.0 mm farther"));
        // On the part, 10 mm inside its edge.
        let problem = check(&line(40.0), &part(), 8e-3, 0.1, 0.5).unwrap_err();
        // So deep inside that it can only land.
        assert!(problem.help.as_deref().expect("a mend").starts_with("say how the tool lands there"));
        assert!(problem.message.contains("10.000 mm inside the edge"), "{}", problem.message);
    }

    #[test]
    fn the_way_to_the_next_line_must_stay_off_the_part_too() {
        // Two lines whose ends are well outside, joined straight across the part.
        let mut path = line(70.0);
        path.points.push([-0.07, 0.01, 0.0], [0.0, 0.0, 1.0]);
        path.lines.push(Line { points: 3..4, link: Link::OnSurface });
        assert_eq!(check(&path, &part(), 8e-3, 0.1, 0.5).unwrap_err().code, codes::E0644);
        // Lifted, the tool may pass over it.
        path.lines[0].link = Link::Lifted;
        assert!(check(&path, &part(), 8e-3, 0.1, 0.5).is_ok());
    }

    #[test]
    fn a_long_way_over_a_small_part_is_seen() {
        // A way of ten metres along x, ten thousand spot radii, over a part of 1 mm diameter and a spot of 0.1 mm radius. 2000 even
        // parts of it would have no end nearer than 1 mm to the part's middle, which lies at x = 0.
        let mut path = ToolPath::default();
        for (line, x) in [-5.002, 5.0].into_iter().enumerate() {
            path.points.push([x, 0.0, 0.0], [0.0, 0.0, 1.0]);
            path.lines.push(Line { points: line..line + 1, link: Link::OnSurface });
        }
        let small = Aperture::circle(Circle { diameter: Length(1e-3), centre: None });
        let problem = check(&path, &small, 0.1e-3, 0.1, 0.5).unwrap_err();
        assert_eq!(problem.code, codes::E0644);
    }

    #[test]
    fn a_path_that_says_how_it_lands_may_be_lifted_over_the_part() {
        let mut path = line(40.0);
        path.landing = Some(Landing { speed: Speed(0.01), reach: Length(1e-3), stand: Time(0.1) });
        let ends = check(&path, &part(), 8e-3, 0.1, 0.5).expect("lands");
        assert!((ends.least_overrun + 10e-3).abs() < 1e-15);
        assert_eq!(ends.landings, 2);
        // A second line joined along the surface still stands there for nobody knows how long.
        path.points.push([-0.04, 0.01, 0.0], [0.0, 0.0, 1.0]);
        path.lines.push(Line { points: 3..4, link: Link::OnSurface });
        assert_eq!(check(&path, &part(), 8e-3, 0.1, 0.5).unwrap_err().code, codes::E0644);
        path.lines[0].link = Link::Lifted;
        assert!(check(&path, &part(), 8e-3, 0.1, 0.5).is_ok());
    }
}
