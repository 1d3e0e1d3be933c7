//! Paths: the way of the contact point over the part.
//!
//! In: the job's `path` and the workpiece. Out: a [`ToolPath`], points on the surface in travel order, in the part frame.
//! [`plan`] lays it out, [`chord::check`] makes sure that its points lie close enough for the curvature, [`ends::check`] that no
//! line starts or ends over the glass.

pub mod chord;
pub mod ends;
pub mod raster;
pub mod region;

use crate::diagnostics::{Problem, codes};
use crate::job;
use crate::workpiece::form::Surface;

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
}

/// What is done between two lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// Straight on along the surface to the next line's first point, off the part (serpentine).
    OnSurface,
    /// Lifted along the normal, over, and down (one way).
    Lifted,
}

/// A stretch of points travelled without stopping: the tool is at rest at its first and at its last point, both of
/// which lie beyond the part's edge. Range of point indices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    pub points: std::ops::Range<usize>,
    /// How the tool gets from the end of this line to the start of the next.
    pub link: Link,
}

/// The planned way over the part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolPath {
    pub points: Points,
    pub lines: Vec<Line>,
}

/// Plans the job's path over the workpiece, whose form is `surface`. `most_points` is the controller's limit, or [`MOST_POINTS`].
///
/// # Errors
///
/// E0645 if the part has a hole and the path does not say what happens there, and those of [`raster::plan`].
pub fn plan(
    path: &job::Path,
    workpiece: &job::Workpiece,
    surface: &dyn Surface,
    most_points: u64,
) -> Result<ToolPath, Problem> {
    let job::Path::raster(raster) = path;
    if workpiece.edge.has_hole() && raster.holes.is_none() {
        let message = "the part has a hole, and the path does not say what happens there";
        return Err(Problem::error(codes::E0645, "path", message).help(
            "write `holes: cross { process: on }` if the tool may run on over the hole with the process on (plugged, \
             or harmless to what lies behind)",
        ));
    }
    raster::plan(raster, surface, most_points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::*;
    use crate::units::si::{Angle, Length};

    fn workpiece(edge: Aperture) -> Workpiece {
        let map = HeightMap {
            file: "map.npy".into(),
            quantity: Quantity::surface,
            positive: Positive::high,
            view: View::from_tool_side,
            up: Direction::plus_y,
            subtract: Vec::new(),
            pixel: None,
            unit: None,
            centre: MapCentre::frame_centre(Empty {}),
            fill_below: None,
        };
        Workpiece {
            part: "P".into(),
            x_mark: None,
            form: Form::plane(Plane {}),
            clear: edge.clone(),
            edge,
            material: Material { name: "glass".into() },
            error: FormError::height_map(map),
        }
    }

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
        };
        let problem =
            plan(&Path::raster(raster.clone()), &workpiece(ring.clone()), &Plane {}, MOST_POINTS).unwrap_err();
        assert_eq!(problem.code, codes::E0645);
        raster.holes = Some(Crossing::cross(Cross { process: OnOff::on }));
        let path = plan(&Path::raster(raster.clone()), &workpiece(ring), &Plane {}, MOST_POINTS).expect("a path");
        // The same path as over a part without the hole: the tool goes on.
        let solid = Aperture::circle(Circle { diameter: Length(0.04), centre: None });
        raster.holes = None;
        assert_eq!(path, plan(&Path::raster(raster), &workpiece(solid), &Plane {}, MOST_POINTS).expect("a path"));
    }
}
