//! The Job: what a `.polish` job says, checked, evaluated and in SI.
//!
//! One plain struct a record of the language, one enum a family, fields named as in the schema (a test compares both
//! directions). Made by `eval` from text, or by hand without any text. [`Origins`] knows beside it which line said what.

mod aperture;
mod form;
mod metrology;
mod path;
mod region;
mod robot;
mod target;
mod tool;
mod uncertainty;

pub use aperture::*;
pub use form::*;
pub use metrology::*;
pub use path::*;
pub use region::*;
pub use robot::*;
pub use target::*;
pub use tool::*;
pub use uncertainty::*;

use crate::source::Span;
use crate::units::si::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Field path (`workpiece.error.file`) to the place in the text that said it. A list element is `robot.joints.2`.
#[derive(Clone, Debug, Default)]
pub struct Origins(pub BTreeMap<String, Span>);

impl Origins {
    /// The place of `field`, or of the nearest field around it, or of the job (the empty path): the first of them that
    /// `wanted` takes.
    pub fn find(&self, field: &str, wanted: impl Fn(&Span) -> bool) -> Option<Span> {
        let mut path = field;
        loop {
            if let Some(span) = self.0.get(path).filter(|span| wanted(span)) {
                return Some(*span);
            }
            match path.rfind('.') {
                Some(dot) => path = &path[..dot],
                None => return self.0.get("").copied(),
            }
        }
    }
}

/// A whole job. A job without `robot` and `target` plans as far as dwell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Job {
    pub wavelength: Option<Length>,
    pub cycle: Option<i64>,
    pub after: Option<String>,
    pub workpiece: Workpiece,
    pub tool: Tool,
    pub path: Path,
    pub dwell: Dwell,
    pub uncertainty: Option<Uncertainty>,
    pub figures: Option<Figures>,
    pub robot: Option<Robot>,
    pub target: Option<Target>,
    pub unchecked: Option<Vec<Unchecked>>,
}

/// What this compiler does not check, said by the job.
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Unchecked {
    arm,
    cell,
    cable,
    fixture,
}

impl Unchecked {
    /// All that there are.
    pub const ALL: [Unchecked; 4] = [Unchecked::arm, Unchecked::cell, Unchecked::cable, Unchecked::fixture];

    /// As the job spells it.
    pub fn name(self) -> &'static str {
        match self {
            Unchecked::arm => "arm",
            Unchecked::cell => "cell",
            Unchecked::cable => "cable",
            Unchecked::fixture => "fixture",
        }
    }
}

/// The optic. Part frame: origin at the vertex, +z out of the glass towards the tool, +x at `x_mark`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Workpiece {
    pub part: String,
    pub x_mark: Option<String>,
    pub form: Form,
    pub edge: Aperture,
    pub clear: Aperture,
    pub material: Material,
    pub fiducials: Option<Vec<Fiducial>>,
    pub error: FormError,
    /// The departure from `form` that is wanted, instead of none.
    pub target: Option<FormError>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    pub name: String,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quantity {
    surface,
    wavefront,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Positive {
    high,
    low,
}

#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum View {
    from_tool_side,
    from_back,
}

/// An axis direction of the part (or of the tool, where the schema says so).
#[allow(non_camel_case_types, reason = "symbols are spelt as in the job")]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Direction {
    plus_x,
    minus_x,
    plus_y,
    minus_y,
}

#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Dwell {
    corrective(Corrective),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Corrective {
    pub objective: Objective,
    /// Part of the measured error that this run is to take off, 0 to 1.
    pub removal_fraction: f64,
    pub piston: Piston,
    pub feed: Range<Speed>,
    pub acceleration: Acceleration,
    /// Across the way; without it `acceleration` holds there too.
    pub lateral_acceleration: Option<Acceleration>,
}

/// What the dwell times are to be best at.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Objective {
    /// The least residual, root mean square.
    rms(Empty),
    /// The least residual, peak to valley.
    pv(Empty),
    /// The shortest run whose residual is small enough.
    time(TimeObjective),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeObjective {
    /// Most that may be left of what this run is to take off, root mean square.
    pub rms: Length,
}

/// Whether the solver may take off an even layer (the base) beside the error.
#[allow(non_camel_case_types, reason = "family members are spelt as in the job")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Piston {
    /// Free, but no more than `at_most`, if that is given.
    free(FreePiston),
    /// Exactly this even layer.
    fixed(FixedPiston),
    /// No even layer.
    held(Empty),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FreePiston {
    pub at_most: Option<Length>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedPiston {
    pub depth: Length,
}
