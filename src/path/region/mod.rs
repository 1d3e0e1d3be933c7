//! Region-adaptive path: polish only where the error is high.
//!
//! In: the job's `region_adaptive`, the error map, the spot's diameter. Out: a [`RegionPath`]: curves with evenly spaced points,
//! each run without a stop, and what was left out. Late in a campaign most of a part is good; a path over all of it would take
//! off the least depth that the tool can (full feed still removes) where nothing should go.
//!
//! One step after the other, a file each:
//!
//! 1. [`select`]: the pixels that stand too high.
//! 2. [`mesh`]: hexagons over them; islands dropped and holes filled.
//! 3. [`fill`]: paths that visit every hexagon once, with the wall on the right.
//! 4. [`merge`]: fewer paths, so that the tool is lifted less often.
//! 5. [`smooth`] and [`turns`]: smooth curves, cut apart where they turn too sharply, with points at equal steps.
//! 6. [`coverage`]: how near the points come to all of the region.
//!
//! Source: the region-adaptive paper's equations 1 to 4 and both listings; where this differs the file says so.

pub mod coverage;
pub mod fill;
pub mod merge;
pub mod mesh;
pub mod select;
pub mod smooth;
pub mod turns;

use crate::diagnostics::{Problem, codes};
use crate::height_map::Grid;
use crate::job::{self, Merge, RegionAdaptive};
use coverage::Coverage;
use merge::{Merged, Within};
use mesh::{Cells, Cleaned, Hexagon, Mesh};
use select::{Lift, Region};
use smooth::Place;

/// A planned way over the region. Lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionPath {
    /// Points of each run, in order.
    pub runs: Vec<Vec<Place>>,
    pub region: Region,
    pub figures: Figures,
}

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
    /// Places where a path was cut because it turned too sharply, and the sharpest turn that is left, radians.
    pub cuts: usize,
    pub sharpest_turn: f64,
    /// Of the region's pixels: part within a diagonal of a point of the path, greatest distance of any from one, and the volume
    /// above the lifted level at those that are farther away than a diagonal.
    pub coverage: f64,
    pub farthest: f64,
    pub lost_volume: f64,
}

/// Part of the pixels that `bounded` leaves below zero, where the job names no other: a half percent are dust and single bad
/// pixels, not depth.
const USUAL_QUANTILE: f64 = 0.005;

/// How much larger the region of `rms3` may be than that of `bounded` before a warning.
const LARGER: f64 = 1.3;

/// Part of the region's volume that may be lost without a warning: less than what an influence function is known to.
const LOST: f64 = 0.01;

/// Part of the spot's diameter that a hexagon's diagonal may be: columns then lie at most three sixteenths of the spot apart,
/// which leaves no ripple.
const SPOT_PART: f64 = 0.25;

/// Pixels across a hexagon: fewer, and the map does not say whether it belongs to the region.
const PIXELS_ACROSS: f64 = 2.0;

/// Rounding of sizes that are written in millimetres, as a part of them.
const ROUNDING: f64 = 1e-9;

/// Plans the path over the region where the error is high. `spot_diameter` is the width of what the tool removes at a time;
/// `most_points` limits hexagons and points. Fields are `path.…`. What leaves the plan usable is said to `warnings`.
///
/// A plan without runs is no failure: nothing stands too high.
///
/// # Errors
///
/// E0640: a number that cannot be used. E0641: too many hexagons or points. E0680: hexagons too large for the spot. E0681: too
/// small for the map. E0682: points farther apart than hexagons. E0683: the map knows nothing within reach. E0684: the smoothing
/// window is longer than every path. E0685: the mesh itself turns more sharply than the turn limit. E0686: smoothing takes the
/// path out of `over`. E0687: a jump inside a run.
pub fn plan(
    job: &RegionAdaptive,
    error: &Grid,
    spot_diameter: f64,
    most_points: u64,
    warnings: &mut Vec<Problem>,
) -> Result<RegionPath, Problem> {
    check_numbers(job, error, spot_diameter, most_points)?;
    let reach: Vec<bool> = (0..error.values.len())
        .map(|i| {
            let [x, y] = error.position(i / error.columns, i % error.columns);
            job.over.contains(x, y)
        })
        .collect();
    let region = region(job, error, &reach, warnings)?;
    let mesh = Mesh { diagonal: job.mesh.diagonal.0, centre: job.over.centre() };
    let pixel_area = error.pixel[0] * error.pixel[1];
    let mut figures = Figures {
        rms: region.statistics.rms,
        lift: region.lift,
        area: region.count as f64 * pixel_area,
        area_share: region.count as f64 / region.statistics.count as f64,
        volume: region.height_sum * pixel_area,
        coverage: 1.0,
        ..Figures::default()
    };

    let bounds = job.over.bounds();
    let sheet = mesh.sheet(bounds.min, bounds.max);
    let in_reach = Cells::of(sheet, |hexagon| {
        let [x, y] = mesh.place(hexagon);
        job.over.contains(x, y)
    });
    let mut cells =
        Cells::of(sheet, |hexagon| in_reach.contains(hexagon) && holds(error, &region.pixels, mesh.place(hexagon)));
    figures.cells = cells.len();
    let Cleaned { dropped, filled } =
        mesh::clean(&mut cells, &in_reach, job.mesh.islands as usize, job.mesh.holes as usize);
    figures.dropped_cells = dropped.len();
    figures.filled_cells = filled.len();
    figures.cleaned_cells = cells.len();

    let weights = smooth::weights(job.smoothing, smooth::half_window(job.smoothing));
    check_turn_limit(job, &mesh, &weights)?;
    let parts = cells.components();
    figures.parts = parts.len();
    let reach_of_spot = (spot_diameter / mesh.diagonal).round() as usize;
    let within =
        Within { steps: reach_of_spot, shortest: reach_of_spot, weights: &weights, turn_limit: job.turn_limit.0 };
    let (primary, merged) = match job.merge {
        Merge::paper => {
            let primary = fill::fill(&cells.iter().collect::<Vec<_>>(), &mut cells.clone());
            (primary.len(), merge::paper(primary, within.steps, within.shortest))
        }
        Merge::bridge_or_trim => part_by_part(parts, &cells, &within),
    };
    figures.primary_paths = primary;
    figures.merged_paths = merged.paths.len();
    figures.trimmed = merged.trimmed;
    figures.dropped_nodes = merged.dropped;
    figures.bridged = merged.bridged;

    let runs = runs(job, &mesh, &weights, &merged.paths, most_points, &mut figures)?;
    let pixels: Vec<(Place, f64)> = region
        .pixels
        .iter()
        .enumerate()
        .filter(|(_, chosen)| **chosen)
        .map(|(i, _)| (error.position(i / error.columns, i % error.columns), region.wanted(error.values[i])))
        .collect();
    let points: Vec<Place> = runs.iter().flatten().copied().collect();
    if !points.is_empty() {
        let Coverage { share, farthest, left } = coverage::measure(&pixels, &points, mesh.diagonal);
        figures.coverage = share;
        figures.farthest = farthest;
        figures.lost_volume = left * pixel_area;
    } else if region.count > 0 {
        figures.coverage = 0.0;
        figures.lost_volume = figures.volume;
    }
    warn_of_loss(&figures, warnings);
    Ok(RegionPath { runs, region, figures })
}

/// Selects the region, and warns of lifts that are odd.
fn region(job: &RegionAdaptive, error: &Grid, reach: &[bool], warnings: &mut Vec<Problem>) -> Result<Region, Problem> {
    let (above, tolerance) = (job.above.0, job.tolerance.0);
    let select = |lift: Lift| {
        select::select(&error.values, reach, lift, above, tolerance).ok_or_else(|| {
            let message = "the error map has no known pixel inside `over`";
            Problem::error(codes::E0683, "path.over", message)
                .help("let `over` lie where the part was measured; its usual place is the clear aperture")
        })
    };
    let lift = match &job.lift {
        job::Lift::rms3(_) => Lift::Rms3,
        job::Lift::bounded(bounded) => Lift::Bounded(bounded.quantile),
        job::Lift::fixed(fixed) => Lift::Fixed(fixed.height.0),
    };
    let region = select(lift)?;
    if lift == Lift::Rms3 {
        let bounded = select(Lift::Bounded(USUAL_QUANTILE))?;
        if region.count as f64 > LARGER * bounded.count as f64 {
            let message = format!(
                "`rms3` lifts {:.1} % of the area into the region, `bounded` only {:.1} %",
                1e2 * region.count as f64 / region.statistics.count as f64,
                1e2 * bounded.count as f64 / region.statistics.count as f64
            );
            warnings.push(
                Problem::warning(codes::W0642, "path.lift", message)
                    .note("three times the RMS is more than the depth of the lowest places: the map has a few high bumps on good ground")
                    .help("write `lift: bounded`"),
            );
        }
    }
    if !matches!(lift, Lift::Fixed(_)) && region.lift < 0.0 && region.count > 0 {
        let message = format!(
            "the error has {:.2} nm RMS, so small that the lift is {:.2} nm: only single peaks stand above {:.2} nm",
            region.statistics.rms * 1e9,
            region.lift * 1e9,
            above * 1e9
        );
        warnings.push(
            Problem::warning(codes::W0643, "path.lift", message)
                .note("the part may be finished within `tolerance`")
                .help("make `tolerance` and `above` smaller if the rest shall be corrected too"),
        );
    }
    Ok(region)
}

/// Fills and merges every connected part for itself: the largest first, then always the one nearest to where the last path
/// ended. So no path jumps over ground that was not selected.
fn part_by_part(mut parts: Vec<Vec<Hexagon>>, cells: &Cells, within: &Within) -> (usize, Merged) {
    let mut of_part = vec![0_usize; cells.sheet().len()];
    for (number, part) in parts.iter().enumerate() {
        for index in part.iter().filter_map(|hexagon| cells.sheet().index(*hexagon)) {
            of_part[index] = number;
        }
    }
    let mut left = cells.clone();
    let mut all = Merged::default();
    let mut primary_paths = 0;
    // Of several largest ones the first.
    let mut next = (0..parts.len()).rev().max_by_key(|number| parts[*number].len());
    while let Some(number) = next {
        let part = std::mem::take(&mut parts[number]);
        part.iter().for_each(|hexagon| left.remove(*hexagon));
        let own = Cells::from_list(&part);
        let primary = fill::fill(&part, &mut own.clone());
        primary_paths += primary.len();
        let merged = merge::bridge_or_trim(primary, &own, within);
        all.paths.extend(merged.paths);
        all.trimmed += merged.trimmed;
        all.dropped += merged.dropped;
        all.bridged += merged.bridged;
        let end = all.paths.last().and_then(|path| path.last()).or(part.last()).copied();
        let nearest = end.and_then(|end| fill::nearest(end, &left));
        next = nearest.and_then(|hexagon| cells.sheet().index(hexagon)).map(|index| of_part[index]);
    }
    (primary_paths, all)
}

/// Smooth curves with points at equal steps.
fn runs(
    job: &RegionAdaptive,
    mesh: &Mesh,
    weights: &[f64],
    paths: &[Vec<Hexagon>],
    most_points: u64,
    figures: &mut Figures,
) -> Result<Vec<Vec<Place>>, Problem> {
    let longest = paths.iter().map(Vec::len).max().unwrap_or(0);
    if longest > 0 && longest < weights.len() {
        let widest = (longest.max(1) - 1) / 2;
        let message = format!(
            "the smoothing window has {} nodes, and the longest path only {longest}: it would be bent as a whole",
            weights.len()
        );
        return Err(Problem::error(codes::E0684, "path.smoothing", message).help(format!(
            "write `smoothing: {:.2}` or less (0 for none), or drop such paths by `mesh.islands: {longest}`",
            ((widest as f64 + 1.0) / 3.0 * 100.0).floor() / 100.0
        )));
    }
    let mut runs = Vec::new();
    let mut points = 0_u64;
    for path in paths {
        let nodes: Vec<Place> = path.iter().map(|hexagon| mesh.place(*hexagon)).collect();
        let pieces = turns::pieces(nodes, weights, job.turn_limit.0);
        figures.cuts += pieces.len() - 1;
        for piece in pieces {
            let sharpest = smooth::turns(&piece).into_iter().fold(0.0, f64::max);
            figures.sharpest_turn = figures.sharpest_turn.max(sharpest);
            points += (smooth::length(&piece) / job.point_step.0) as u64 + 2;
            if points > most_points {
                let message = format!("the path has more than {most_points} points, which is the limit");
                return Err(Problem::error(codes::E0641, "path", message)
                    .help("widen `point_step`, or raise the controller's `most_points`"));
            }
            runs.push(smooth::resample(&piece, job.point_step.0));
        }
    }
    stays_within(job, mesh, runs.iter().flatten())?;
    check_jumps(&runs, mesh.diagonal)?;
    Ok(runs)
}

/// Whether a place lies in a pixel of the region. A place on the border of two pixels lies in the upper or right one.
fn holds(grid: &Grid, pixels: &[bool], place: Place) -> bool {
    // Borders are written in millimetres and come out a last digit too low or too high.
    let index = |axis: usize| ((place[axis] - grid.origin[axis]) / grid.pixel[axis] + 0.5 + 1e-6).floor();
    let (column, row) = (index(0), index(1));
    let on_the_map = column >= 0.0 && row >= 0.0 && column < grid.columns as f64 && row < grid.rows as f64;
    on_the_map && pixels[row as usize * grid.columns + column as usize]
}

/// Numbers that no plan can be made with.
fn check_numbers(job: &RegionAdaptive, error: &Grid, spot_diameter: f64, most_points: u64) -> Result<(), Problem> {
    let diagonal = job.mesh.diagonal.0;
    let positive = [("mesh.diagonal", diagonal), ("point_step", job.point_step.0)];
    for (name, value) in positive {
        if !(value > 0.0 && value.is_finite()) {
            let message = format!("`{name}` is {} mm; it must be positive", value * 1e3);
            return Err(Problem::error(codes::E0640, format!("path.{name}"), message));
        }
    }
    for (name, value) in [("above", job.above.0), ("tolerance", job.tolerance.0)] {
        if !(value >= 0.0 && value.is_finite()) {
            let message = format!("`{name}` is {} nm; it must not be negative", value * 1e9);
            return Err(Problem::error(codes::E0640, format!("path.{name}"), message));
        }
    }
    if let Some(problem) = crate::workpiece::aperture::check(&job.over, "path.over") {
        return Err(problem);
    }
    let widest = SPOT_PART * spot_diameter;
    if diagonal > widest * (1.0 + ROUNDING) {
        let message = format!(
            "hexagons of {:.3} mm diagonal are too large for a spot of {:.3} mm diameter: the columns would show",
            diagonal * 1e3,
            spot_diameter * 1e3
        );
        return Err(Problem::error(codes::E0680, "path.mesh.diagonal", message)
            .help(format!("write `diagonal: {} mm` or less, a quarter of the spot", down(widest * 1e3))));
    }
    let pixel = error.pixel[0].max(error.pixel[1]);
    let narrowest = PIXELS_ACROSS * pixel;
    if diagonal < narrowest * (1.0 - ROUNDING) {
        let message = format!(
            "hexagons of {:.3} mm diagonal are too small for a map of {:.3} mm a pixel, which cannot tell them apart",
            diagonal * 1e3,
            pixel * 1e3
        );
        return Err(Problem::error(codes::E0681, "path.mesh.diagonal", message)
            .help(format!("write `diagonal: {} mm` or more, two pixels", up(narrowest * 1e3))));
    }
    if job.point_step.0 > diagonal * (1.0 + ROUNDING) {
        let message =
            format!("points {:.3} mm apart skip hexagons of {:.3} mm diagonal", job.point_step.0 * 1e3, diagonal * 1e3);
        return Err(Problem::error(codes::E0682, "path.point_step", message)
            .help(format!("write `point_step: {} mm` or less, the diagonal", down(diagonal * 1e3))));
    }
    let bounds = job.over.bounds();
    let mesh = Mesh { diagonal, centre: job.over.centre() };
    let count = mesh.count(bounds.min, bounds.max);
    // A sheet has up to twice the hexagons of the box that it covers.
    if count > 2.0 * most_points as f64 {
        let message = format!("about {count:.0} hexagons lie over the area; the limit is {}", 2 * most_points);
        return Err(Problem::error(codes::E0641, "path.mesh.diagonal", message).help("make `diagonal` larger"));
    }
    Ok(())
}

/// A hundredth of a millimetre down, or up: numbers that pass and can be written.
fn down(millimetres: f64) -> f64 {
    (millimetres * 100.0 * (1.0 + ROUNDING)).floor() / 100.0
}
fn up(millimetres: f64) -> f64 {
    (millimetres * 100.0 * (1.0 - ROUNDING)).ceil() / 100.0
}

/// A corner of the mesh turns by 60 degrees, and by less once it is smoothed. A limit below that would cut every path to pieces.
fn check_turn_limit(job: &RegionAdaptive, mesh: &Mesh, weights: &[f64]) -> Result<(), Problem> {
    let corner = Hexagon::default();
    let way = |direction: i32, steps: usize| {
        std::iter::successors(Some(corner), move |h| Some(h.neighbour(direction))).take(steps + 1)
    };
    let mut hexagons: Vec<Hexagon> = way(3, weights.len()).collect();
    hexagons.reverse();
    hexagons.extend(way(1, weights.len()).skip(1));
    let nodes: Vec<Place> = hexagons.into_iter().map(|hexagon| mesh.place(hexagon)).collect();
    let own = smooth::turns(&smooth::smooth(&nodes, weights, smooth::Ends::Reflected)).into_iter().fold(0.0, f64::max);
    if job.turn_limit.0 >= own {
        return Ok(());
    }
    let degrees = |angle: f64| angle * 180.0 / std::f64::consts::PI;
    let message = format!(
        "a corner of the mesh turns by {:.1} deg once it is smoothed, more than `turn_limit`, {:.1} deg",
        degrees(own),
        degrees(job.turn_limit.0)
    );
    Err(Problem::error(codes::E0685, "path.turn_limit", message).help(format!(
        "write `turn_limit: {:.0} deg` or more; 90 deg cuts only where a path comes back on itself",
        degrees(own).ceil()
    )))
}

/// No point may lie outside `over` by more than half a hexagon, which the centre of one on its border reaches.
fn stays_within<'a>(job: &RegionAdaptive, mesh: &Mesh, points: impl Iterator<Item = &'a Place>) -> Result<(), Problem> {
    let outside = points.map(|point| (-job.over.distance(point[0], point[1]), *point));
    let Some((most, [x, y])) = outside.max_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
    if most <= mesh.step() / 2.0 {
        return Ok(());
    }
    let message = format!(
        "smoothing takes the path {:.3} mm out of `over` at x {:.3} mm, y {:.3} mm",
        most * 1e3,
        x * 1e3 + 0.0,
        y * 1e3 + 0.0
    );
    Err(Problem::error(codes::E0686, "path.smoothing", message)
        .help(format!("smooth over fewer nodes, or let `over` end {} mm farther in", up(most * 1e3))))
}

/// No two points of a run lie farther apart than a hexagon and a half: between them the tool would cross what is not to be
/// polished.
pub fn check_jumps(runs: &[Vec<Place>], diagonal: f64) -> Result<(), Problem> {
    for pair in runs.iter().flat_map(|run| run.windows(2)) {
        let length = smooth::length(pair);
        if !(length <= 1.5 * diagonal) {
            let [x, y] = pair[0];
            let message =
                format!("a run of the path jumps {:.3} mm from x {:.3} mm, y {:.3} mm", length * 1e3, x * 1e3, y * 1e3);
            return Err(Problem::error(codes::E0687, "path", message)
                .help(format!("lift the tool where the path goes on more than {:.3} mm away", 1.5 * diagonal * 1e3)));
        }
    }
    Ok(())
}

/// Says what of the region the path does not reach.
fn warn_of_loss(figures: &Figures, warnings: &mut Vec<Problem>) {
    if figures.lost_volume <= LOST * figures.volume {
        return;
    }
    let cubic = 1e9;
    let message = format!(
        "{:.2e} mm^3 of the {:.2e} mm^3 that the region asks for lie farther than a hexagon from the path, up to {:.1} mm",
        figures.lost_volume * cubic,
        figures.volume * cubic,
        figures.farthest * 1e3
    );
    warnings.push(
        Problem::warning(codes::W0641, "path.mesh", message)
            .note(format!("{} of {} hexagons were dropped as islands", figures.dropped_cells, figures.cells))
            .help("lower `islands`, or make `diagonal` smaller"),
    );
}
