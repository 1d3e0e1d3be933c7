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

pub mod checks;
pub mod coverage;
mod figures;
pub mod fill;
pub mod merge;
pub mod mesh;
pub mod select;
pub mod smooth;
pub mod turns;

use super::{Laid, Line, Link, Setting, Strategy};
use crate::diagnostics::{Problem, codes};
use crate::height_map::Grid;
use crate::job::{self, Aperture, Crossing, Landing, Merge, Pass, RegionAdaptive};
use coverage::Coverage;
pub use figures::Figures;
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

/// Part of the pixels that `bounded` leaves below zero, where the job names no other: a half percent are dust and single bad
/// pixels, not depth.
const USUAL_QUANTILE: f64 = 0.005;

impl Strategy for RegionAdaptive {
    fn over(&self) -> &Aperture {
        &self.over
    }
    /// Of the columns of the mesh.
    fn line_pitch(&self) -> f64 {
        0.75 * self.mesh.diagonal.0
    }
    fn chord_error(&self) -> f64 {
        self.chord_error.0
    }
    /// A hole of the part is not measured, so it belongs to no region.
    fn crosses_holes(&self) -> bool {
        false
    }
    fn holes(&self) -> Option<&Crossing> {
        None
    }
    fn landing(&self) -> Option<Landing> {
        Some(self.landing)
    }
    fn needs_measurement(&self) -> bool {
        true
    }

    /// # Errors
    ///
    /// Those of [`plan`].
    fn lay(&self, _: Pass, setting: &Setting) -> Result<Laid, Problem> {
        let Some(measured) = &setting.measured else {
            let message = "a region is selected from the error map, and there is none";
            return Err(Problem::error(codes::E0683, "path", message).help("give the workpiece an `error`"));
        };
        let planned = plan(self, &measured.error.grid, 2.0 * measured.influence.radius(), setting.most_points)?;
        let mut laid = Laid { region: Some(planned.figures), ..Laid::default() };
        for run in planned.runs {
            let start = laid.places.len();
            laid.places.extend(run);
            laid.lines.push(Line { points: start..laid.places.len(), link: Link::Lifted });
        }
        Ok(laid)
    }
}

/// Plans the path over the region where the error is high. `spot_diameter` is the width of what the tool removes at a time;
/// `most_points` limits hexagons and points. Fields are `path.…`.
///
/// A plan without runs is no failure: nothing stands too high.
///
/// # Errors
///
/// E0640: a number that cannot be used. E0641: too many hexagons or points. E0680: hexagons too large for the spot. E0681: too
/// small for the map. E0682: points farther apart than hexagons. E0683: the map knows nothing within reach. E0684: the smoothing
/// reaches farther than every path is long. E0685: the mesh itself turns more sharply than the turn limit. E0686: smoothing takes the
/// path out of `over`. E0687: a jump inside a run.
pub fn plan(job: &RegionAdaptive, error: &Grid, spot_diameter: f64, most_points: u64) -> Result<RegionPath, Problem> {
    checks::numbers(job, error, spot_diameter, most_points)?;
    let reach: Vec<bool> = (0..error.values.len())
        .map(|i| {
            let [x, y] = error.position(i / error.columns, i % error.columns);
            job.over.contains(x, y)
        })
        .collect();
    let (region, bounded) = region(job, error, &reach)?;
    let mesh = Mesh { diagonal: job.mesh.diagonal.0, centre: job.over.centre() };
    let pixel_area = error.pixel[0] * error.pixel[1];
    let mut figures = Figures {
        rms: region.statistics.rms,
        lift: region.lift,
        area: region.count as f64 * pixel_area,
        area_share: region.count as f64 / region.statistics.count as f64,
        bounded_share: bounded as f64 / region.statistics.count as f64,
        stated_lift: matches!(job.lift, job::Lift::fixed(_)),
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
        mesh::clean(&mut cells, &in_reach, whole(job.mesh.islands), whole(job.mesh.holes));
    figures.dropped_cells = dropped.len();
    figures.filled_cells = filled.len();
    figures.cleaned_cells = cells.len();

    let weights = smooth::weights(job.smoothing, smooth::half_window(job.smoothing));
    checks::turn_limit(job, &mesh, &weights)?;
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
    let threes = merged.paths.iter().flat_map(|path| path.windows(3));
    figures.u_turns = threes.filter(|three| three[0] == three[2]).count();

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
    Ok(RegionPath { runs, region, figures })
}

/// Selects the region as the job says; beside it, the number of pixels that the bounded lift would select.
fn region(job: &RegionAdaptive, error: &Grid, reach: &[bool]) -> Result<(Region, usize), Problem> {
    let select = |lift: Lift| {
        select::select(&error.values, reach, lift, job.above.0, job.tolerance.0).ok_or_else(|| {
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
    let bounded = if lift == Lift::Rms3 { select(Lift::Bounded(USUAL_QUANTILE))?.count } else { region.count };
    Ok((region, bounded))
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
    checks::window(paths, weights.len())?;
    let mut runs = Vec::new();
    let mut points = 0_u64;
    for path in paths {
        if path.len() < 2 {
            // A place to stand is no way to go.
            figures.dropped_nodes += path.len();
            continue;
        }
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
    checks::stays_within(job, mesh, runs.iter().flatten())?;
    checks::jumps(&runs, mesh.diagonal)?;
    Ok(runs)
}

/// A count as the job says it; nothing below zero.
fn whole(count: i64) -> usize {
    usize::try_from(count).unwrap_or(0)
}

/// Whether a place lies in a pixel of the region. A place on the border of two pixels lies in the upper or right one.
fn holds(grid: &Grid, pixels: &[bool], place: Place) -> bool {
    // Borders are written in millimetres and come out a last digit too low or too high.
    let index = |axis: usize| ((place[axis] - grid.origin[axis]) / grid.pixel[axis] + 0.5 + 1e-6).floor();
    let (column, row) = (index(0), index(1));
    let on_the_map = column >= 0.0 && row >= 0.0 && column < grid.columns as f64 && row < grid.rows as f64;
    on_the_map && pixels[row as usize * grid.columns + column as usize]
}
