//! A measured influence function: the maps of spots become a removal rate.
//!
//! In: maps of the depth that spots of known dwell left (or of the glass before and after them), and the job's words on scale,
//! orientation and origin. Out: an [`InfluenceFunction`] over the tool frame, the mean of the spots, and how well they agree.
//! What a spot was not is taken off: the least-squares plane of the pixels beyond `radius` (interferometers leave piston and tilt
//! in every map) is the baseline.

use super::InfluenceFunction;
use super::spread::{self, SpotFigures, Spread};
use crate::diagnostics::{Problem, codes};
use crate::height_map::{Grid, Picture, lay, read_file};
use crate::job::{CentroidNear, Direction, Measured, Origin, PeakNear, PixelAt, Positive, Spot, TurnsWith, View};
use crate::metrology::{doubt_scale, plane_through, surface_factor};
use crate::source::FileProvider;

/// Largest part of the volume that may read as added glass. The noise of a spot's map averages out far below it; more
/// means a wrong baseline, a wrong radius, or two spots in one map.
const NEGATIVE_SHARE: f64 = 0.02;

/// A spot that is nowhere deeper than a picometre removed nothing: that is a hundredth of an atom, and below the rounding
/// of any map.
const SHALLOWEST: f64 = 1e-12;

/// `peak` and `centroid` depend on the baseline, which depends on the origin: they are looked for again until the origin
/// moves by less than a hundredth pixel, which shifts no removal that could be measured.
const SETTLED: f64 = 0.01;
/// A spot that stands out of its map settles within a few rounds; one that wanders longer has no origin of its own.
const MOST_ROUNDS: usize = 20;

/// What measured spots say.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredSpots {
    pub function: InfluenceFunction,
    /// How well the spots agree; `None` for a single one.
    pub spread: Option<Spread>,
}

/// Reads the spots. `at` is the field of the influence function, within which all fields are.
///
/// # Errors
/// Those of reading and scaling a map; E0621 without a usable baseline or origin, E0622 for unknown pixels inside the
/// radius, E0623 for too much added glass, E0624 for no removal at all, E0656 for maps before and after that do not belong
/// together, E0657 for spots that are too old.
pub fn read(
    measured: &Measured,
    at: &str,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<MeasuredSpots, Problem> {
    let mut said = Vec::new();
    let result = read_within(measured, files, &mut said);
    warnings.extend(said.into_iter().map(|warning| warning.within(at)));
    result.map_err(|problem| problem.within(at))
}

/// One spot on the way: its depth over the tool frame, and where the job says it.
struct Laid<'a> {
    spot: &'a Spot,
    field: String,
    depth: Grid,
    /// The deepest pixel of the picture, where it was taken for the spot.
    guessed: Option<[f64; 2]>,
}

fn read_within(
    measured: &Measured,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<MeasuredSpots, Problem> {
    let radius = measured.radius.0;
    if !(radius > 0.0 && radius.is_finite()) {
        let message = format!("`radius` is {:.3} mm; it must be positive", radius * 1e3);
        return Err(Problem::error(codes::E0621, "radius", message));
    }
    if measured.spots.is_empty() {
        let message = "an influence function is measured from one spot at least, and `spots` is empty";
        return Err(Problem::error(codes::E0621, "spots", message));
    }
    let mut laid = Vec::new();
    for (i, spot) in measured.spots.iter().enumerate() {
        let field = format!("spots.{i}");
        laid.push(lay_spot(measured, spot, &field, files, warnings).map_err(|p| of_spot(p, &field))?);
    }
    separate(&laid, radius)?;
    // The places of the spots in one picture depend on each other by the baseline around them: twice round is enough, since a
    // place moves by pixels and the other spots' discs are left out as a whole.
    let mut levelled = Vec::new();
    for _ in 0..2 {
        levelled = (0..laid.len()).map(|i| place(&mut laid, i, radius)).collect::<Result<Vec<Grid>, Problem>>()?;
    }
    // Two that were looked for may have been found at one place.
    separate(&laid, radius)?;
    let mut rates = Vec::new();
    for (laid, spot) in laid.iter().zip(levelled) {
        rates.push(finish(spot, radius, laid.spot.dwell.0).map_err(|p| of_spot(p, &laid.field))?);
    }
    let figures: Vec<SpotFigures> = laid
        .iter()
        .zip(&rates)
        .map(|(laid, spot)| SpotFigures {
            volume_rate: volume_rate(spot, radius),
            peak_rate: peak_rate(spot, radius),
            clock: laid.spot.clock.map(|clock| clock.0),
        })
        .collect();
    let (scale, spread) = spread::of(&figures, measured.ageing.as_ref(), warnings)?;
    let mut mean = mean(&rates, radius);
    mean.values.iter_mut().for_each(|rate| *rate *= scale);
    let (volume, sigma) = (volume_rate(&mean, radius), smaller_width(&mean, radius));
    Ok(MeasuredSpots { function: InfluenceFunction::of_map(mean, radius, volume, sigma), spread })
}

/// The field of a problem that a spot has: `radius` and the like belong to all of them.
fn of_spot(problem: Problem, field: &str) -> Problem {
    let of_one = matches!(problem.field.as_deref(), Some("file" | "before" | "dwell" | "origin"));
    if of_one { problem.within(field) } else { problem }
}

/// Depth in metres over the tool frame, its origin at the place that the job names or guesses.
fn lay_spot<'a>(
    measured: &Measured,
    spot: &'a Spot,
    field: &str,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<Laid<'a>, Problem> {
    if !(spot.dwell.0 > 0.0 && spot.dwell.0.is_finite()) {
        let message = format!("`dwell` is {:.3} s; it must be positive", spot.dwell.0);
        return Err(Problem::error(codes::E0621, "dwell", message));
    }
    let mut picture = heights(measured, &spot.file, files, warnings)?;
    if let Some(before) = &spot.before {
        let earlier = heights(measured, before, files, warnings).map_err(|mut problem| {
            if problem.field.as_deref() == Some("file") {
                problem.field = Some("before".into());
            }
            problem
        })?;
        let same = |a: f64, b: f64| (a - b).abs() <= 1e-6 * a.abs();
        let fits = [earlier.columns, earlier.rows] == [picture.columns, picture.rows]
            && (0..2).all(|axis| same(picture.pixel[axis], earlier.pixel[axis]));
        if !fits {
            let size = |p: &Picture| format!("{} x {} pixels of {:.4} mm", p.columns, p.rows, p.pixel[0] * 1e3);
            let message = format!(
                "the map before the spot has {}, the map after it {}: one cannot be taken from the other",
                size(&earlier),
                size(&picture)
            );
            return Err(Problem::error(codes::E0656, "before", message)
                .help("measure both with the same settings, without moving the part"));
        }
        for (value, earlier) in picture.values.iter_mut().zip(&earlier.values) {
            *value -= earlier;
        }
    }
    let guess = |origin: &Origin| matches!(origin, Origin::peak(_) | Origin::centroid(_));
    let guessed = guess(&spot.origin).then(|| deepest(&picture));
    let start = match &spot.origin {
        Origin::pixel_at(PixelAt { column, row })
        | Origin::peak_near(PeakNear { column, row })
        | Origin::centroid_near(CentroidNear { column, row }) => [*column, *row],
        Origin::frame_centre(_) => picture.middle(),
        Origin::peak(_) | Origin::centroid(_) => guessed.unwrap_or([0.0; 2]),
    };
    // The tool's z points into the glass, away from the eye on the tool side. A spot that does not turn with the tool is seen in
    // the part's axes, which are those of a tool with the azimuth 0 but for the sense of y.
    let mirrored = measured.view == View::from_tool_side;
    let up = match measured.turns_with {
        TurnsWith::tool => measured.up,
        TurnsWith::nothing => match measured.up {
            Direction::plus_y => Direction::minus_y,
            Direction::minus_y => Direction::plus_y,
            along_x => along_x,
        },
    };
    Ok(Laid { spot, field: field.into(), depth: lay(&picture, up, mirrored, start), guessed })
}

/// A file's picture as depth: positive where glass is missing.
fn heights(
    measured: &Measured,
    file: &str,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<Picture, Problem> {
    let raw = read_file(file, files)?;
    let pixel = raw.pixel_pitch(measured.pixel.map(|length| length.0))?;
    let mut values = raw.heights(measured.unit.map(|length| length.0))?;
    doubt_scale(&raw, measured.quantity, warnings);
    // Where glass is missing the surface stands low: depth is the negative of a height that is positive upwards.
    let factor = surface_factor(measured.quantity) * if measured.positive == Positive::high { -1.0 } else { 1.0 };
    values.iter_mut().for_each(|value| *value *= factor);
    Ok(Picture { columns: raw.columns, rows: raw.rows, pixel, values })
}

/// The deepest pixel `[column, row]` of the picture; heights were checked to have one.
fn deepest(picture: &Picture) -> [f64; 2] {
    let mut best = (f64::NEG_INFINITY, 0);
    for (i, value) in picture.values.iter().enumerate() {
        if *value > best.0 {
            best = (*value, i);
        }
    }
    [(best.1 % picture.columns) as f64, (best.1 / picture.columns) as f64]
}

/// Whether two spots stand in the same picture.
fn share_a_picture(a: &Spot, b: &Spot) -> bool {
    a.file == b.file && a.before == b.before
}

/// Where the other spots of its picture lie, from spot `i`, in the tool frame.
fn others(laid: &[Laid], i: usize) -> Vec<[f64; 2]> {
    let own = laid[i].depth.origin;
    let beside = laid.iter().enumerate().filter(|(k, other)| *k != i && share_a_picture(other.spot, laid[i].spot));
    // Both grids are one picture, laid about different places.
    beside.map(|(_, other)| [own[0] - other.depth.origin[0], own[1] - other.depth.origin[1]]).collect()
}

/// E0621 if two spots of one picture lie on each other.
fn separate(laid: &[Laid], radius: f64) -> Result<(), Problem> {
    for i in 0..laid.len() {
        for [x, y] in others(laid, i) {
            let apart = libm::hypot(x, y);
            if apart < 2.0 * radius {
                let message = format!(
                    "two spots of one picture lie {:.3} mm apart, less than two of their radii of {:.3} mm",
                    apart * 1e3,
                    radius * 1e3
                );
                let field = format!("{}.origin", laid[i].field);
                return Err(Problem::error(codes::E0621, field, message).help(
                    "say of each where it lies, by `peak_near { column: …, row: … }`, and make `radius` no larger than a spot is",
                ));
            }
        }
    }
    Ok(())
}

/// Finds the origin of spot `i` and takes its baseline off.
fn place(laid: &mut [Laid], i: usize, radius: f64) -> Result<Grid, Problem> {
    let others = others(laid, i);
    let Laid { spot, field, depth, guessed } = &mut laid[i];
    let guessed = *guessed;
    let found = match &spot.origin {
        Origin::frame_centre(_) | Origin::pixel_at(_) => levelled(depth, radius, &others),
        Origin::peak(_) | Origin::peak_near(_) => settle(depth, radius, &others, peak),
        Origin::centroid(_) | Origin::centroid_near(_) => settle(depth, radius, &others, centroid),
    };
    found.map_err(|problem| of_spot(told_of_guess(problem, guessed), field))
}

/// The problem of a spot that was looked for: with the wrong sign the deepest pixel is any pixel but that of the spot.
fn told_of_guess(problem: Problem, guessed: Option<[f64; 2]>) -> Problem {
    let Some([column, row]) = guessed else { return problem };
    problem.note(format!(
        "the deepest pixel of the map was taken for the spot: column {column}, row {row} of the picture; if the spot is \
         not there, check `positive`"
    ))
}

/// Moves the grid's origin to the place that `locate` finds in the levelled spot, until it stays.
fn settle(
    depth: &mut Grid,
    radius: f64,
    others: &[[f64; 2]],
    locate: fn(&Grid, f64) -> [f64; 2],
) -> Result<Grid, Problem> {
    let mut others = others.to_vec();
    for _ in 0..MOST_ROUNDS {
        let spot = levelled(depth, radius, &others)?;
        let [x, y] = locate(&spot, radius);
        if x.abs() <= SETTLED * depth.pixel[0] && y.abs() <= SETTLED * depth.pixel[1] {
            return Ok(spot);
        }
        depth.origin = [depth.origin[0] - x, depth.origin[1] - y];
        others.iter_mut().for_each(|[ox, oy]| (*ox, *oy) = (*ox - x, *oy - y));
    }
    Err(Problem::error(codes::E0621, "origin", "the origin of the spot does not settle: no spot stands out of the map")
        .help("check `positive` and `radius`, or say where the tool stood by `pixel_at`"))
}

/// The deepest pixel inside the radius, metres from the origin.
fn peak(spot: &Grid, radius: f64) -> [f64; 2] {
    let mut best = (f64::NEG_INFINITY, [0.0; 2]);
    each_inside(spot, radius, |x, y, depth| {
        if depth > best.0 {
            best = (depth, [x, y]);
        }
    });
    best.1
}

/// The centre of the removed volume inside the radius, metres from the origin.
fn centroid(spot: &Grid, radius: f64) -> [f64; 2] {
    let (mut volume, mut sums) = (0.0, [0.0; 2]);
    each_inside(spot, radius, |x, y, depth| {
        volume += depth;
        sums[0] += x * depth;
        sums[1] += y * depth;
    });
    if volume > 0.0 { [sums[0] / volume, sums[1] / volume] } else { [0.0; 2] }
}

/// Calls `see(x, y, depth)` for every known pixel whose centre lies inside the radius.
fn each_inside(spot: &Grid, radius: f64, mut see: impl FnMut(f64, f64, f64)) {
    for row in 0..spot.rows {
        for column in 0..spot.columns {
            let [x, y] = spot.position(row, column);
            let depth = spot.at(row, column);
            if x * x + y * y <= radius * radius && !depth.is_nan() {
                see(x, y, depth);
            }
        }
    }
}

/// The map without its baseline, which the discs about the `others` are no part of; the spot must lie wholly in the picture,
/// every pixel of it known (E0622), with enough pixels around it (E0621).
fn levelled(depth: &Grid, radius: f64, others: &[[f64; 2]]) -> Result<Grid, Problem> {
    let counts = [depth.columns, depth.rows];
    for axis in 0..2 {
        let low = depth.origin[axis];
        let high = low + (counts[axis] as f64 - 1.0) * depth.pixel[axis];
        if low > -radius || high < radius {
            let message = format!(
                "the spot of radius {:.3} mm leaves its map, which reaches from {} {:.3} mm to {:.3} mm of the tool frame",
                radius * 1e3,
                ["x", "y"][axis],
                low * 1e3,
                high * 1e3
            );
            return Err(Problem::error(codes::E0622, "radius", message)
                .help("make `radius` smaller, check `pixel` and `origin`, or measure a wider field"));
        }
    }
    let mut outside = vec![false; depth.values.len()];
    for row in 0..depth.rows {
        for column in 0..depth.columns {
            let i = row * depth.columns + column;
            let [x, y] = depth.position(row, column);
            let inside = |x: f64, y: f64| x * x + y * y <= radius * radius;
            let known = depth.values[i].is_finite();
            outside[i] = known && !inside(x, y) && !others.iter().any(|[ox, oy]| inside(x - ox, y - oy));
            if inside(x, y) && !known {
                let message = format!(
                    "the spot has an unknown pixel at x {:.3} mm, y {:.3} mm of the tool frame",
                    x * 1e3,
                    y * 1e3
                );
                return Err(Problem::error(codes::E0622, "file", message)
                    .help("measure the spot again: inside `radius` every pixel must be known"));
            }
        }
    }
    let baseline = plane_through(depth, &outside).ok_or_else(|| {
        Problem::error(
            codes::E0621,
            "radius",
            "no plane can be laid through the pixels beyond `radius`: there are too few",
        )
        .help("make `radius` smaller, or measure a wider field around the spot")
    })?;
    let mut spot = depth.clone();
    for i in 0..spot.values.len() {
        spot.values[i] -= baseline.at(spot.position(i / spot.columns, i % spot.columns));
    }
    Ok(spot)
}

/// From depth to rate: checks the volume, divides by the dwell.
fn finish(mut spot: Grid, radius: f64, dwell: f64) -> Result<Grid, Problem> {
    let (mut removed, mut added, mut extreme) = (0.0, 0.0, 0.0_f64);
    each_inside(&spot, radius, |_, _, depth| {
        extreme = extreme.max(depth.abs());
        if depth > 0.0 { removed += depth } else { added -= depth }
    });
    let volume = removed - added;
    if extreme < SHALLOWEST {
        return Err(Problem::error(codes::E0624, "file", "the spot removed nothing")
            .help("take the map of the spot, not one of the part before"));
    }
    if volume <= 0.0 {
        return Err(Problem::error(codes::E0624, "positive", "the spot reads as added glass, not as removed glass")
            .help(
                "check `positive`: `high` if glass that stands high reads positive, `low` if removal reads positive",
            ));
    }
    if added > NEGATIVE_SHARE * volume {
        let message = format!(
            "{:.1} % of the spot's volume reads as added glass; at most {:.0} % can be noise",
            100.0 * added / volume,
            100.0 * NEGATIVE_SHARE
        );
        return Err(Problem::error(codes::E0623, "radius", message)
            .help("check that `radius` holds this one spot and that the map around it is flat"));
    }
    spot.values.iter_mut().for_each(|depth| *depth /= dwell);
    Ok(spot)
}

/// Volume removed in a second inside the radius, m³/s.
fn volume_rate(spot: &Grid, radius: f64) -> f64 {
    let mut sum = 0.0;
    each_inside(spot, radius, |_, _, rate| sum += rate);
    sum * spot.pixel[0] * spot.pixel[1]
}

/// The greatest rate inside the radius, m/s.
fn peak_rate(spot: &Grid, radius: f64) -> f64 {
    let mut most = f64::NEG_INFINITY;
    each_inside(spot, radius, |_, _, rate| most = most.max(rate));
    most
}

/// The mean of the spots on the pixels of the first, laid on each other by their origins; a single spot is itself.
fn mean(rates: &[Grid], radius: f64) -> Grid {
    let mut mean = rates[0].clone();
    if rates.len() == 1 {
        return mean;
    }
    for i in 0..mean.values.len() {
        let [x, y] = mean.position(i / mean.columns, i % mean.columns);
        // Beyond the radius nothing is asked; just beyond it the reading between pixels needs values.
        let near = libm::hypot(x, y) <= radius + 2.0 * mean.pixel[0].max(mean.pixel[1]);
        let sum: f64 = if near { rates.iter().map(|spot| spot.interpolate(x, y).unwrap_or(0.0)).sum() } else { 0.0 };
        mean.values[i] = sum / rates.len() as f64;
    }
    mean
}

/// Root of the smaller principal second moment about the centroid, of what was removed (noise below zero has no width),
/// with a pixel's own moment, side²/12, so that it is never zero.
fn smaller_width(spot: &Grid, radius: f64) -> f64 {
    let (mut sum, mut sx, mut sy, mut sxx, mut sxy, mut syy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    each_inside(spot, radius, |x, y, depth| {
        let depth = depth.max(0.0);
        sum += depth;
        sx += depth * x;
        sy += depth * y;
        sxx += depth * x * x;
        sxy += depth * x * y;
        syy += depth * y * y;
    });
    let (x, y) = (sx / sum, sy / sum);
    let xx = sxx / sum - x * x + spot.pixel[0] * spot.pixel[0] / 12.0;
    let yy = syy / sum - y * y + spot.pixel[1] * spot.pixel[1] / 12.0;
    let xy = sxy / sum - x * y;
    let (half_sum, half_difference) = ((xx + yy) / 2.0, (xx - yy) / 2.0);
    (half_sum - libm::hypot(half_difference, xy)).sqrt()
}
