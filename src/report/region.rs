//! What a region-adaptive path polishes and leaves out, and the result of a job that finds nothing to polish.

use super::{DEGREES, Predicted, rounded};
use crate::metrology::ErrorMap;
use crate::path::region::Figures;
use serde::Serialize;
use std::collections::BTreeMap;

/// The region of a region-adaptive path, and what the path leaves out of it.
#[derive(Clone, Debug, Serialize)]
pub struct RegionResult {
    pub lift_nm: f64,
    pub area_mm2: f64,
    /// Its part of the measured area within reach.
    pub area_share: f64,
    /// Hexagons whose centre lies in the region; of them dropped as islands; beside them taken in as holes.
    pub cells: usize,
    pub dropped_cells: usize,
    pub filled_cells: usize,
    /// Connected parts, paths as they were filled, and after they were joined.
    pub parts: usize,
    pub primary_paths: usize,
    pub merged_paths: usize,
    /// Hexagons that joining cut off, that were dropped with short paths, that are visited once more.
    pub trimmed: usize,
    pub dropped_nodes: usize,
    pub bridged: usize,
    /// Hexagons at which a joined path turns back to the one it came from; places where a path was cut because it turned too
    /// sharply once it was smoothed.
    pub u_turns: usize,
    pub cuts: usize,
    pub sharpest_turn_deg: f64,
    /// Part of the region within a hexagon's diagonal of the path, and the greatest distance of any of it.
    pub coverage: f64,
    pub farthest_mm: f64,
    /// Glass to be removed, and how much of it lies farther from the path than a diagonal.
    pub volume_mm3: f64,
    pub lost_volume_mm3: f64,
}

/// The region as `result.json` tells of it.
pub fn region(figures: &Figures) -> RegionResult {
    RegionResult {
        lift_nm: rounded(figures.lift * 1e9, 3),
        area_mm2: rounded(figures.area * 1e6, 1),
        area_share: rounded(figures.area_share, 4),
        cells: figures.cells,
        dropped_cells: figures.dropped_cells,
        filled_cells: figures.filled_cells,
        parts: figures.parts,
        primary_paths: figures.primary_paths,
        merged_paths: figures.merged_paths,
        trimmed: figures.trimmed,
        dropped_nodes: figures.dropped_nodes,
        bridged: figures.bridged,
        u_turns: figures.u_turns,
        cuts: figures.cuts,
        sharpest_turn_deg: rounded(figures.sharpest_turn * DEGREES, 2),
        coverage: rounded(figures.coverage, 4),
        farthest_mm: rounded(figures.farthest * 1e3, 2),
        volume_mm3: rounded(figures.volume * 1e9, 6),
        lost_volume_mm3: rounded(figures.lost_volume * 1e9, 6),
    }
}

/// What `require` may ask of the region, in SI.
pub(super) fn results(figures: &Figures) -> [(String, f64); 4] {
    [
        ("region.area".to_string(), figures.area),
        ("region.coverage".into(), figures.coverage),
        ("region.farthest".into(), figures.farthest),
        ("region.lost".into(), if figures.volume > 0.0 { figures.lost_volume / figures.volume } else { 0.0 }),
    ]
}

/// What `require` may ask for where there is nothing to polish: the surface stays as it was measured, and no program runs.
pub fn results_of_nothing(error: &ErrorMap, figures: &Figures) -> BTreeMap<String, f64> {
    let zero =
        ["predicted.removal.mean", "predicted.removal.rms", "predicted.removal.range", "dwell.time", "dwell.base"];
    let none = ["program.points", "program.bytes", "program.modules"];
    let mut results: BTreeMap<String, f64> = zero.into_iter().chain(none).map(|name| (name.to_string(), 0.0)).collect();
    results.insert("predicted.rms".into(), error.after.rms);
    results.insert("predicted.pv".into(), error.after.pv);
    results.extend(self::results(figures));
    results
}

/// The surface where nothing is done to it.
pub fn untouched(error: &ErrorMap) -> Predicted {
    let [rms, pv] = [error.after.rms, error.after.pv].map(|height| rounded(height * 1e9, 3));
    Predicted { rms_before_nm: rms, pv_before_nm: pv, rms_nm: rms, pv_nm: pv, ..Predicted::default() }
}

/// Why there is nothing to polish, in a sentence.
pub fn nothing(figures: &Figures) -> String {
    if figures.cells == 0 {
        return format!(
            "no place stands too high: the error of {:.2} nm RMS lies within `above` and `tolerance`",
            figures.rms * 1e9
        );
    }
    format!(
        "what stands too high, {:.3} mm^2, lies in {} hexagons apart from one another, which `islands` drops",
        figures.area * 1e6,
        figures.dropped_cells
    )
}
