//! Paths: the way of the contact point over the part.
//!
//! In: the job's `path`, the workpiece, and for strategies that plan from them the measured error and the influence
//! function. Out: a [`ToolPath`], points on the surface in travel order, in the part frame.
//!
//! A [`Strategy`] lays out lines in the plane across the part's axis, each in a file of its own; [`plan`] puts its passes one
//! after the other, lays them onto the surface and breaks lines that are too long for one file of a program. Then
//! [`chord::check`] makes sure that points lie close enough for the curvature, and [`ends::check`] that no tool stands over the
//! glass unless the job says how it lands there ([`landing`]).

/// The fields that every path of lines has under the same names, as a [`Strategy`] tells them.
macro_rules! fields_of_lines {
    () => {
        fn over(&self) -> &crate::job::Aperture {
            &self.over
        }
        fn line_pitch(&self) -> f64 {
            self.line_pitch.0
        }
        fn chord_error(&self) -> f64 {
            self.chord_error.0
        }
        fn holes(&self) -> Option<&crate::job::Crossing> {
            self.holes.as_ref()
        }
        fn landing(&self) -> Option<crate::job::Landing> {
            self.landing
        }
        fn passes(&self) -> &[crate::job::Pass] {
            self.passes.as_deref().unwrap_or_default()
        }
    };
}

pub mod chord;
pub mod ends;
mod hilbert;
pub mod landing;
mod lattice;
mod pseudo_random;
mod raster;
pub mod region;
mod rings;
mod round;
mod spiral;

use crate::diagnostics::{Problem, codes};
use crate::job::{self, Aperture, Crossing, Landing, Pass};
use crate::metrology::ErrorMap;
use crate::tool::InfluenceFunction;
use crate::units::si::{Angle, Length};
use crate::workpiece::form::Surface;
use crate::workpiece::where_it_ends;
use std::ops::Range;

/// Most points of a path where no controller states its own limit: 5 million points are what fits into 2 GiB with
/// everything that the later passes keep of each.
pub const MOST_POINTS: u64 = 5_000_000;

/// Contact points and outward unit normals in the part frame, metres, one structure of arrays for all points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub z: Vec<f64>,
    pub normal_x: Vec<f64>,
    pub normal_y: Vec<f64>,
    pub normal_z: Vec<f64>,
}

impl Points {
    pub fn len(&self) -> usize {
        self.x.len()
    }
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }
    /// Room for `n` points.
    pub fn with_capacity(n: usize) -> Points {
        let room = || Vec::with_capacity(n);
        Points { x: room(), y: room(), z: room(), normal_x: room(), normal_y: room(), normal_z: room() }
    }
    /// Adds a point.
    pub fn push(&mut self, position: [f64; 3], normal: [f64; 3]) {
        self.x.push(position[0]);
        self.y.push(position[1]);
        self.z.push(position[2]);
        self.normal_x.push(normal[0]);
        self.normal_y.push(normal[1]);
        self.normal_z.push(normal[2]);
    }
    pub fn position(&self, i: usize) -> [f64; 3] {
        [self.x[i], self.y[i], self.z[i]]
    }
    pub fn normal(&self, i: usize) -> [f64; 3] {
        [self.normal_x[i], self.normal_y[i], self.normal_z[i]]
    }
    /// The place `standoff` metres off the surface along the normal: of a tool's centre point.
    pub fn off_surface(&self, i: usize, standoff: f64) -> [f64; 3] {
        let (place, normal) = (self.position(i), self.normal(i));
        [0, 1, 2].map(|k| place[k] + standoff * normal[k])
    }
}

/// What is done between two lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// Straight on along the surface to the next line's first point, off the part (serpentine).
    OnSurface,
    /// Lifted along the normal, over, and down (one way). The next line may start where this one ends.
    Lifted,
}

/// A stretch of points travelled without stopping: the tool is at rest at its first and at its last point. Both lie beyond
/// the part's edge, unless the path lands and lifts there. Range of point indices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    pub points: Range<usize>,
    /// How the tool gets from the end of this line to the start of the next.
    pub link: Link,
}

/// The planned way over the part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolPath {
    pub points: Points,
    pub lines: Vec<Line>,
    /// How the tool lands and lifts where the path is lifted, if the job lets it do so over the glass.
    pub landing: Option<Landing>,
    /// Of a path over a region: what it is, and what the path leaves out of it. It is there for an empty region too, which has no
    /// points.
    pub region: Option<region::Figures>,
}

/// What a path is planned from.
#[derive(Clone, Copy)]
pub struct Setting<'a> {
    /// The part's edge, and its clear aperture.
    pub edge: &'a Aperture,
    pub clear: &'a Aperture,
    pub surface: &'a dyn Surface,
    /// The controller's limit, or [`MOST_POINTS`].
    pub most_points: u64,
    /// Most points that a line may have, which must fit into one file of the program; `usize::MAX` without a target.
    pub line_points: usize,
    /// For strategies that ask for it ([`Strategy::needs_measurement`]).
    pub measured: Option<Measured<'a>>,
}

/// What a path that looks at the error is planned from.
#[derive(Clone, Copy)]
pub struct Measured<'a> {
    pub error: &'a ErrorMap,
    pub influence: &'a InfluenceFunction,
}

/// The lines of one pass in the plane across the part's axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Laid {
    /// Places in the part's xy plane, metres, in travel order.
    pub places: Vec<[f64; 2]>,
    /// Ranges of `places`. The link of the last line means nothing.
    pub lines: Vec<Line>,
    /// Of a strategy that plans over a region.
    pub region: Option<region::Figures>,
}

/// How the lines of a path run. One a member of the family `Path`; fields of problems are `path.…`.
pub trait Strategy {
    /// The area that the lines run over.
    fn over(&self) -> &Aperture;
    /// Distance of neighbouring lines in one pass, metres.
    fn line_pitch(&self) -> f64;
    /// Most that a straight move may leave the surface, metres.
    fn chord_error(&self) -> f64;
    /// What happens over a hole of the part.
    fn holes(&self) -> Option<&Crossing>;
    /// Whether lines may run over a hole of the part, which then must be spoken of.
    fn crosses_holes(&self) -> bool {
        true
    }
    /// How the tool lands where a line starts or ends over the glass.
    fn landing(&self) -> Option<Landing>;
    /// The passes, empty for a single one as the fields say it.
    fn passes(&self) -> &[Pass] {
        &[]
    }
    /// Whether [`Setting::measured`] is needed: the error map is then read before the path is planned.
    fn needs_measurement(&self) -> bool {
        false
    }
    /// The lines of one pass.
    fn lay(&self, pass: Pass, setting: &Setting) -> Result<Laid, Problem>;
}

impl job::Path {
    /// The strategy behind the family's member.
    pub fn strategy(&self) -> &dyn Strategy {
        match self {
            job::Path::raster(raster) => raster,
            job::Path::spiral(spiral) => spiral,
            job::Path::rings(rings) => rings,
            job::Path::hilbert(hilbert) => hilbert,
            job::Path::pseudo_random(random) => random,
            job::Path::region_adaptive(region) => region,
        }
    }

    /// How often the path goes over its area.
    pub fn pass_count(&self) -> usize {
        self.strategy().passes().len().max(1)
    }
}

/// Plans the job's path.
///
/// # Errors
///
/// E0645 if the part has a hole and the path does not say what happens there; E0603 for a point where the form does not
/// exist; E0640 for a landing that is none; those of the check of the area, and of [`Strategy::lay`].
pub fn plan(path: &job::Path, setting: &Setting) -> Result<ToolPath, Problem> {
    let strategy = path.strategy();
    let over = strategy.over();
    if setting.edge.has_hole() && !over.has_hole() && strategy.crosses_holes() && strategy.holes().is_none() {
        let message = "the part has a hole, and the path does not say what happens there";
        return Err(Problem::error(codes::E0645, "path", message).help(
            "write `holes: cross { process: on }` if the tool may run on over the hole with the process on (plugged, \
             or harmless to what lies behind)",
        ));
    }
    if let Some(problem) = crate::workpiece::aperture::check(over, "path.over") {
        return Err(problem);
    }
    let landing = strategy.landing();
    if let Some(landing) = &landing {
        landing::check(landing)?;
    }
    let single = [Pass { turn: Angle(0.0), shift: Length(0.0) }];
    let passes = match strategy.passes() {
        [] => &single,
        passes => passes,
    };
    let mut planned = ToolPath { landing, ..ToolPath::default() };
    for pass in passes {
        let most_points = setting.most_points.saturating_sub(planned.points.len() as u64);
        let laid = strategy.lay(*pass, &Setting { most_points, ..*setting })?;
        if let Some(last) = planned.lines.last_mut() {
            last.link = Link::Lifted;
        }
        // Without a landing a line stays whole: `motion` refuses it if it is too long.
        let most = if landing.is_some() { setting.line_points.max(2) } else { usize::MAX };
        for (points, link) in laid.lines.iter().flat_map(|line| broken(line, most)) {
            let start = planned.points.len();
            for place in &laid.places[points] {
                planned.push(*place, setting, over)?;
            }
            planned.lines.push(Line { points: start..planned.points.len(), link });
        }
        planned.region = planned.region.or(laid.region);
    }
    Ok(planned)
}

impl ToolPath {
    /// Adds a point, laid onto the surface along z.
    fn push(&mut self, [x, y]: [f64; 2], setting: &Setting, over: &Aperture) -> Result<(), Problem> {
        let Some(point) = setting.surface.at(x, y) else {
            return Err(where_it_ends(setting.surface, over.centre(), [x, y], "path.over", "the path passes"));
        };
        self.points.push([x, y, point.sag], point.normal());
        Ok(())
    }
}

/// A line in as few pieces as have at most so many points, all about as long; each begins at the point where the one before
/// it ends, lifted in between.
fn broken(line: &Line, most: usize) -> Vec<(Range<usize>, Link)> {
    let segments = line.points.len().saturating_sub(1);
    let pieces = segments.div_ceil(most.saturating_sub(1).max(1)).max(1);
    let at = |piece: usize| line.points.start + segments * piece / pieces;
    (0..pieces)
        .map(|piece| {
            let last = piece + 1 == pieces;
            let end = if last { line.points.end } else { at(piece + 1) + 1 };
            (at(piece)..end, if last { line.link } else { Link::Lifted })
        })
        .collect()
}

/// E0640 for lengths of `path` that are not positive.
fn positive(fields: &[(&str, f64)]) -> Result<(), Problem> {
    for (name, value) in fields {
        if !(*value > 0.0 && value.is_finite()) {
            let message = format!("`{name}` is {} mm; it must be positive", value * 1e3);
            return Err(Problem::error(codes::E0640, format!("path.{name}"), message));
        }
    }
    Ok(())
}

/// E0641 if a path of about so many points is more than there may be, before any is made.
fn few_enough(points: f64, setting: &Setting) -> Result<(), Problem> {
    if points <= setting.most_points as f64 {
        return Ok(());
    }
    let message = format!("the path has about {points:.0} points; the limit is {}", setting.most_points);
    Err(Problem::error(codes::E0641, "path", message)
        .help("widen `line_pitch` or `point_step`, or raise the controller's `most_points`"))
}

/// Most squares of a lattice that are looked at, those of the box around the area: one of four is a node with 22 bytes, which
/// makes 0.4 GB.
const MOST_SQUARES: f64 = 67_108_864.0;

/// E0641 if the box around an area holds more squares than are looked at, before any is made.
fn few_squares(squares: f64) -> Result<(), Problem> {
    if squares <= MOST_SQUARES {
        return Ok(());
    }
    let message = format!(
        "the box around the path's area holds about {squares:.0} squares of `line_pitch`; at most {MOST_SQUARES:.0} are looked at"
    );
    Err(Problem::error(codes::E0641, "path.line_pitch", message)
        .help("widen `line_pitch`, or take an area that fills its box"))
}

#[cfg(test)]
mod examples;

#[cfg(test)]
mod tests {
    use super::examples::setting;
    use super::*;
    use crate::job::*;

    #[test]
    fn a_hole_must_be_spoken_of() {
        let ring =
            Aperture::annulus(Annulus { outer_diameter: Length(0.04), inner_diameter: Length(0.01), centre: None });
        let mut raster = Raster {
            over: Aperture::circle(Circle { diameter: Length(0.06), centre: None }),
            point_step: Length(0.004),
            line_pitch: Length(0.002),
            direction: Angle(0.0),
            lines: Lines::serpentine,
            chord_error: Length(1e-5),
            holes: None,
            landing: None,
            passes: None,
        };
        let planned =
            |raster: &Raster, edge: &Aperture| plan(&Path::raster(raster.clone()), &setting(edge, MOST_POINTS));
        let problem = planned(&raster, &ring).unwrap_err();
        assert_eq!(problem.code, codes::E0645);
        raster.holes = Some(Crossing::cross(Cross { process: OnOff::on }));
        let path = planned(&raster, &ring).expect("a path");
        // The same path as over a part without the hole: the tool goes on.
        let solid = Aperture::circle(Circle { diameter: Length(0.04), centre: None });
        raster.holes = None;
        assert_eq!(path, planned(&raster, &solid).expect("a path"));
    }

    /// Ten segments in pieces of at most five points, four segments: three pieces of 3, 3 and 4, each from where the last ended.
    #[test]
    fn a_long_line_is_broken_where_it_is_lifted() {
        let line = Line { points: 7..18, link: Link::OnSurface };
        let pieces = broken(&line, 5);
        assert_eq!(pieces, [(7..11, Link::Lifted), (10..14, Link::Lifted), (13..18, Link::OnSurface)]);
        assert_eq!(broken(&line, 11), [(7..18, Link::OnSurface)]);
        assert_eq!(broken(&Line { points: 3..4, link: Link::Lifted }, 2), [(3..4, Link::Lifted)]);
    }
}
