//! Inspect: what is in a log, for `polishc inspect`.
//!
//! In: the bytes of a log. Out: [`RunFacts`], which serialises to the JSON that the command line promises. Whether the log is one
//! of a job's runs only [`follow`](super::follow) can say.

use super::log::{self, Layout};
use crate::diagnostics::Problem;
use serde::Serialize;
use std::collections::BTreeMap;

/// Facts of one log. Lengths are rounded to a nanometre, times to a microsecond.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunFacts {
    pub kind: &'static str,
    pub format: &'static str,
    /// What the file calls its frame.
    pub frame: Option<String>,
    /// Of x in the file.
    pub unit: String,
    pub points: usize,
    /// SpatialAnalyzer's groups with their points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub groups: Option<BTreeMap<String, usize>>,
    pub duration_s: f64,
    /// The median time from a sample to the next.
    pub interval_s: f64,
    pub longest_interval_s: f64,
    /// Least and greatest x, y, z.
    pub bounds_mm: [[f64; 3]; 2],
    pub blake3: String,
}

/// Looks into a log of this layout. Errors as of [`log::read`].
pub fn inspect(bytes: &[u8], name: &str, layout: Layout) -> Result<RunFacts, Problem> {
    let log = log::read(bytes, name)?;
    let points = log.time.len();
    let mut intervals: Vec<f64> = log.time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    intervals.sort_by(f64::total_cmp);
    let extreme = |from: f64, pick: fn(f64, f64) -> f64| {
        [0, 1, 2].map(|axis| nanometre(log.position.iter().map(|place| place[axis] * 1e3).fold(from, pick)))
    };
    let (kind, format) = match layout {
        Layout::Table => ("controller_log", "table"),
        Layout::SpatialAnalyzer => ("tracker_run", "spatial_analyzer"),
    };
    Ok(RunFacts {
        kind,
        format,
        bounds_mm: [extreme(f64::INFINITY, f64::min), extreme(f64::NEG_INFINITY, f64::max)],
        frame: log.frame_name,
        unit: log.unit,
        points,
        groups: log.group.map(|group| BTreeMap::from([(group, points)])),
        duration_s: microsecond(log.time.last().copied().unwrap_or(0.0)),
        interval_s: microsecond(intervals[intervals.len() / 2]),
        longest_interval_s: microsecond(intervals[intervals.len() - 1]),
        blake3: blake3::hash(bytes).to_hex().to_string(),
    })
}

/// Millimetres to a nanometre; adding zero turns -0.0 into 0.0.
fn nanometre(millimetres: f64) -> f64 {
    (millimetres * 1e6).round() / 1e6 + 0.0
}

fn microsecond(seconds: f64) -> f64 {
    (seconds * 1e6).round() / 1e6
}
