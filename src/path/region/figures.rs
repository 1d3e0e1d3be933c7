//! Figures of a region and of the path over it, and what is odd about them.

use crate::diagnostics::{Problem, codes};

/// What is to be said of a plan. Lengths in metres, volumes in cubic metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Of the error within reach, about its mean.
    pub rms: f64,
    /// What the map was lifted by.
    pub lift: f64,
    /// Area of the region, and its part of the known area within reach.
    pub area: f64,
    pub area_share: f64,
    /// The part that the bounded lift would select; that of the region where the lift is not `rms3`.
    pub bounded_share: f64,
    /// Whether the job states the lift.
    pub stated_lift: bool,
    /// Glass that stands above the lifted level in the region.
    pub volume: f64,
    /// Hexagons whose centre lies in the region, and after islands were dropped and holes filled.
    pub cells: usize,
    pub cleaned_cells: usize,
    pub dropped_cells: usize,
    pub filled_cells: usize,
    /// Connected parts.
    pub parts: usize,
    /// Paths as they were filled, and after merging.
    pub primary_paths: usize,
    pub merged_paths: usize,
    /// Hexagons cut off the tails of paths, of paths dropped, and visited once more.
    pub trimmed: usize,
    pub dropped_nodes: usize,
    pub bridged: usize,
    /// Hexagons at which a joined path turns back to the one it came from.
    pub u_turns: usize,
    /// Places where a path was cut because it turned too sharply, and the sharpest turn that is left, radians.
    pub cuts: usize,
    pub sharpest_turn: f64,
    /// Of the region's pixels: part within a diagonal of a point of the path, greatest distance of any from one, and the volume
    /// above the lifted level at those that are farther away than a diagonal.
    pub coverage: f64,
    pub farthest: f64,
    pub lost_volume: f64,
}

/// How much larger the region of `rms3` may be than that of `bounded` before a warning.
const LARGER: f64 = 1.3;

/// Part of the region's volume that may be lost without a warning: less than what an influence function is known to.
const LOST: f64 = 0.01;

impl Figures {
    /// What leaves the plan usable and should be known. Fields are `path.…`.
    pub fn warnings(&self) -> Vec<Problem> {
        [self.large_lift(), self.negative_lift(), self.loss()].into_iter().flatten().collect()
    }

    fn large_lift(&self) -> Option<Problem> {
        if self.area_share <= LARGER * self.bounded_share {
            return None;
        }
        let message = format!(
            "`rms3` lifts {:.1} % of the area into the region, `bounded` only {:.1} %",
            1e2 * self.area_share,
            1e2 * self.bounded_share
        );
        let note =
            "three times the RMS is more than the lowest places lie low: the map has a few high bumps on good ground";
        Some(Problem::warning(codes::W0642, "path.lift", message).note(note).help("write `lift: bounded`"))
    }

    fn negative_lift(&self) -> Option<Problem> {
        // Of a stated lift the job knows its sign; of an empty region there is nothing to doubt.
        if self.stated_lift || self.lift >= 0.0 || self.area == 0.0 {
            return None;
        }
        let message = format!(
            "the error has {:.2} nm RMS, so little that the lift is {:.2} nm: only single peaks are selected",
            self.rms * 1e9,
            self.lift * 1e9
        );
        Some(
            Problem::warning(codes::W0643, "path.tolerance", message)
                .note("the part may be finished within `tolerance`")
                .help("make `tolerance` and `above` smaller if the rest shall be corrected too"),
        )
    }

    fn loss(&self) -> Option<Problem> {
        if self.lost_volume <= LOST * self.volume {
            return None;
        }
        let message = if self.coverage == 0.0 {
            "no path is left for the region: all of it is dropped".to_string()
        } else {
            format!(
                "{:.1} % of the glass that the region asks for lie farther than a hexagon from the path, up to {:.1} mm",
                1e2 * self.lost_volume / self.volume,
                self.farthest * 1e3
            )
        };
        Some(
            Problem::warning(codes::W0641, "path.mesh", message)
                .note(format!("{} of {} hexagons were dropped as islands", self.dropped_cells, self.cells))
                .help("lower `islands`, or make `diagonal` smaller"),
        )
    }
}
