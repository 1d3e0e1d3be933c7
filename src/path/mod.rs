//! Paths: the way of the contact point over the part.
//!
//! In: the job's `path` and the workpiece. Out: a [`ToolPath`], points on the surface in travel order, in the part frame.

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
