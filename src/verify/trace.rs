//! The trace: where the tool goes and how fast, by the text of a program alone.
//!
//! In: the moves of a text, in order. Out: a [`Trace`], in the part frame. What the readers of all languages say of a move;
//! nothing here is compared with a plan.

use crate::motion::Transform;
use nalgebra::Vector3;

/// How a move ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrival {
    /// Straight to its place, where the tool comes to rest.
    Stopping,
    /// Straight to its place, and on without stopping.
    Passing,
    /// By the joints, on no known way.
    Joints,
}

/// The moves of a program, one entry each, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trace {
    /// Tool centre point at the move's end, part frame, metres.
    pub position: Vec<[f64; 3]>,
    /// Unit direction of the tool's +z there, which points into the glass.
    pub axis: Vec<[f64; 3]>,
    /// Programmed speed of the tool centre point, m/s; 0 for a move of the joints.
    pub speed: Vec<f64>,
    pub arrival: Vec<Arrival>,
}

impl Trace {
    pub(super) fn push(&mut self, tool: &Transform, speed: f64, arrival: Arrival) {
        self.position.push(tool.translation.vector.into());
        self.axis.push((tool.rotation * Vector3::z()).into());
        self.speed.push(speed);
        self.arrival.push(arrival);
    }

    pub(super) fn append(&mut self, mut next: Trace) {
        self.position.append(&mut next.position);
        self.axis.append(&mut next.axis);
        self.speed.append(&mut next.speed);
        self.arrival.append(&mut next.arrival);
    }

    pub fn len(&self) -> usize {
        self.position.len()
    }

    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }
}
