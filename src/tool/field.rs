//! The influence of a tool over the part: what it removes may depend on where it stands.
//!
//! In: the job's `tool` and `workpiece`. Out: an [`InfluenceField`]: a few influence functions and the weight of each at
//! every place of the part. Dwell takes it.

use super::influence::InfluenceFunction;
use super::{bonnet, pad};
use crate::diagnostics::{Problem, codes};
use crate::job::{Influence, Tool, Workpiece};
use crate::source::FileProvider;

/// What the tool removes wherever it stands: a tool standing at the part's (x, y) removes
/// `sum_k weight_k(x, y) * parts[k].rate(dx, dy)`, with `(dx, dy)` in the tool frame.
#[derive(Clone, Debug, PartialEq)]
pub struct InfluenceField {
    /// At least one.
    pub parts: Vec<InfluenceFunction>,
}

impl From<InfluenceFunction> for InfluenceField {
    /// The same everywhere.
    fn from(function: InfluenceFunction) -> InfluenceField {
        InfluenceField { parts: vec![function] }
    }
}

impl InfluenceField {
    /// What the job's tool removes. `files` is asked only for measured spots. What is odd but usable is said to `warnings`.
    /// Fields are `tool.…`.
    ///
    /// # Errors
    /// E0620 to E0624 and those of a map for a spot, E0650 for numbers that give no rate, E0651 for an influence function that
    /// is not one of this tool.
    pub fn new(
        tool: &Tool,
        _workpiece: &Workpiece,
        files: &dyn FileProvider,
        warnings: &mut Vec<Problem>,
    ) -> Result<InfluenceField, Problem> {
        let function = match (tool.influence(), tool) {
            (Influence::gaussian(g), _) => InfluenceFunction::gaussian(g.peak.0, g.sigma.0, g.diameter.0)?,
            (Influence::measured(measured), _) => InfluenceFunction::measured(measured, files, warnings)?,
            (Influence::preston(preston), Tool::planetary_pad(pad)) => pad::influence(pad, preston)?,
            (Influence::preston(_), _) => return Err(not_of("preston", "planetary_pad", tool)),
            (Influence::bonnet_contact(contact), Tool::bonnet(bonnet)) => bonnet::influence(bonnet, contact, 0.0)?,
            (Influence::bonnet_contact(_), _) => return Err(not_of("bonnet_contact", "bonnet", tool)),
        };
        Ok(function.into())
    }

    /// Whether it is the same everywhere: one part, whose weight is 1.
    pub fn is_uniform(&self) -> bool {
        self.parts.len() == 1
    }

    /// The weight of each part for a tool standing at the part's `(x, y)`, metres; `out` is as long as `parts`.
    pub fn weights(&self, _x: f64, _y: f64, out: &mut [f64]) {
        out.fill(1.0);
    }

    /// Nothing is removed farther than this from the tool centre point, metres.
    pub fn radius(&self) -> f64 {
        self.parts.iter().fold(0.0, |most, part| part.radius().max(most))
    }

    /// The least width of all parts, metres: grids that resolve it resolve all.
    pub fn sigma_scale(&self) -> f64 {
        self.parts.iter().fold(f64::INFINITY, |least, part| part.sigma_scale().min(least))
    }
}

/// An influence function that another tool has.
fn not_of(influence: &str, of: &str, tool: &Tool) -> Problem {
    let message = format!("`{influence}` tells the removal of a `{of}`, and the job's tool is a {}", tool.name());
    Problem::error(codes::E0651, "tool.influence", message)
        .help("measure a spot: `measured { … }`, or describe it: `gaussian { … }`")
}
