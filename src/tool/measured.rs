//! A measured influence function: one spot's map, turned into a removal rate.

use super::InfluenceFunction;
use crate::diagnostics::Problem;
use crate::job::Measured;
use crate::source::FileProvider;

pub(super) fn read(
    measured: &Measured,
    files: &dyn FileProvider,
    _warnings: &mut Vec<Problem>,
) -> Result<InfluenceFunction, Problem> {
    let _ = (measured, files);
    Err(Problem::error(crate::diagnostics::codes::E0620, "tool.influence", "not read yet"))
}
