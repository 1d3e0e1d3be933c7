//! The profile: heights along one line. It tells people what a file holds; no job takes it for a map.

use super::Format;
use crate::diagnostics::{Problem, codes};

/// Heights along one line as the file shows them, in its order. NaN marks invalid points.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    pub format: Format,
    /// Positions along the line; metres where `positions_in_metres`. As many as heights.
    pub positions: Vec<f64>,
    pub positions_in_metres: bool,
    /// Metres where `in_metres`.
    pub heights: Vec<f64>,
    pub in_metres: bool,
}

impl Profile {
    /// Positions and heights in metres. `unit` is the height that the value 1 means, `step` the distance from one point
    /// to the next, where the file does not say them. Fields are `unit`, `pixel`. E0506 if nobody says one, E0507 if it is
    /// stated although the file says its own or is not positive, E0508 if no point is valid.
    pub fn metres(&self, unit: Option<f64>, step: Option<f64>) -> Result<(Vec<f64>, Vec<f64>), Problem> {
        let one_too_many = |field: &str| {
            let message = format!("the profile's file says its own scale, a {field} beside it is one too many");
            Problem::error(codes::E0507, field, message).help(format!("leave `{field}` out"))
        };
        for (field, stated) in [("unit", unit), ("pixel", step)] {
            if stated.is_some_and(|length| !(length > 0.0 && length.is_finite())) {
                return Err(Problem::error(codes::E0507, field, format!("the stated {field} must be positive")));
            }
        }
        let missing = |field: &str, what: &str, example: &str| {
            Problem::error(codes::E0506, field, format!("the profile's file does not say {what}"))
                .help(format!("state it on the command line: `--{field} {example}`"))
        };
        let heights = match (self.in_metres, unit) {
            (true, None) => self.heights.clone(),
            (true, Some(_)) => return Err(one_too_many("unit")),
            (false, None) => return Err(missing("unit", "what its heights are measured in", "1nm")),
            (false, Some(unit)) => self.heights.iter().map(|height| height * unit).collect(),
        };
        let positions = match (self.positions_in_metres, step) {
            (true, None) => self.positions.clone(),
            (true, Some(_)) => return Err(one_too_many("pixel")),
            (false, None) => return Err(missing("pixel", "how far its points lie apart", "0.5mm")),
            (false, Some(step)) => (0..self.positions.len()).map(|i| i as f64 * step).collect(),
        };
        if heights.iter().all(|height| height.is_nan()) {
            return Err(Problem::error(codes::E0508, "file", "the profile has no valid point"));
        }
        Ok((positions, heights))
    }
}
