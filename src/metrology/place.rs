//! Place: a picture becomes a map in the frame of the part.
//!
//! In: a [`RawMap`], the job's `height_map`, the workpiece. Out: a [`Placed`] map. Every word of the job has one effect
//! here, in this order:
//!
//! 1. `unit`, `pixel`: metres (see [`RawMap`]).
//! 2. `mask`, `trim`, `despike`: what is no glass becomes unknown (see [`clean`]).
//! 3. `quantity: wavefront`: halved, since light passes an error of the surface twice. `positive: low`: negated.
//! 4. `up`, `view`, `centre`: laid into the part frame (see [`lay`]). `from_back` is the picture seen from behind the
//!    part, through the glass: what points up stays up, left and right change places.
//! 5. `fiducials`, or else `rotated`: turned, scaled and shifted into the part frame (see [`resample`]). A quarter turn
//!    moves pixels as they are.
//! 6. Off the part (`edge`) there is no glass: unknown, as what `leave_out` names.
//! 7. The picture must cover the clear aperture, unless it is a piece of a stitched map.
//! 8. `subtract`: taken off by least squares over the measured pixels of the clear aperture.
//! 9. `fill_below`: holes inside the clear aperture up to this area are filled, if measured pixels lie all around them.
//!    Others stay; whether they are refused hangs on what the map is for ([`Extent`]).

use super::cover::{self, inside, plural, square_millimetres};
use super::registration::{Registered, quarter_turned, register};
use super::resample::{Pixels, Similarity, resample};
use super::{Figures, LowOrder, clean, holes, low_order};
use crate::diagnostics::{Problem, codes};
use crate::height_map::{Grid, MOST_PIXELS, Picture, RawMap, lay, position_in_frame, read_file, valid_middle};
use crate::job::{Aperture, HeightMap, Positive, Quantity, View, Workpiece};
use crate::source::FileProvider;
use std::f64::consts::FRAC_PI_2;

/// A map in the frame of the part.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Placed {
    /// Part frame, metres, positive where glass stands too high; NaN off the part and where nothing is known.
    pub grid: Grid,
    /// Of the measured pixels inside the clear aperture, before `subtract`; metres.
    pub before: Figures,
    /// The same pixels after `subtract`.
    pub after: Figures,
    /// Number of holes filled inside the clear aperture, their pixels, and their area in square metres.
    pub filled_holes: usize,
    pub filled_pixels: usize,
    pub filled_area: f64,
    /// Metres, where the file says it.
    pub wavelength: Option<f64>,
}

/// What was done to one file on its way into the frame of the part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapRecord {
    /// Whole path.
    pub file: String,
    /// Known pixels that each word took out.
    pub masked: usize,
    pub trimmed: usize,
    pub spikes: usize,
    pub registered: Option<Registered>,
    /// What `subtract` took off.
    pub removed: LowOrder,
}

/// How far, in pixels, the middle of the valid pixels may lie from the middle of the part before a warning: centring by
/// hand on an edge is good to a pixel or two.
const CENTRING: f64 = 3.0;

/// Most pixels of a hole that is filled, whatever the job allows: half a thousand each way. A smooth surface over more is
/// no measurement, and solving for it would take minutes.
const MOST_FILLED: f64 = 250_000.0;

/// How much wider than the part the measured pixels may lie before a warning: a pixel that does not know of binning, or is
/// stated in the wrong unit, makes them at least twice as wide; what was seen around a part seldom does.
const WIDER: f64 = 1.9;

/// Largest part of the pixels that may be spikes before a warning: dust and lost fringes are fewer; more is the noise, or
/// the glass.
const MANY_SPIKES: f64 = 0.01;

/// How much a map must say of the clear aperture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extent {
    /// Every pixel.
    Whole,
    /// Its picture covers it; where it has a hole, other maps of an average may know.
    Covering,
    /// It is a piece of a stitched map.
    Piece,
}

/// The largest area of a hole that the map's words let be filled, square metres.
pub(super) fn fill_limit(map: &HeightMap, pixel: [f64; 2]) -> f64 {
    map.fill_below.map_or(0.0, |area| area.0).min(MOST_FILLED * pixel[0] * pixel[1])
}

/// Puts a map on the part. Fields are those of `height_map`; warnings go to `warnings`.
pub(super) fn place_map(
    raw: &RawMap,
    map: &HeightMap,
    workpiece: &Workpiece,
    extent: Extent,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<(Placed, MapRecord), Problem> {
    let pixel = raw.pixel_pitch(map.pixel.map(|length| length.0))?;
    let values = raw.heights(map.unit.map(|length| length.0))?;
    doubt_scale(raw, map.quantity, warnings);
    let mut picture = Picture { columns: raw.columns, rows: raw.rows, pixel, values };
    let mut record = clean_picture(&mut picture, map, files, warnings)?;
    let factor = surface_factor(map.quantity) * if map.positive == Positive::low { -1.0 } else { 1.0 };
    picture.values.iter_mut().for_each(|value| *value *= factor);

    let mut grid = lay_on_part(&picture, map, workpiece, &mut record)?;
    if extent != Extent::Piece {
        doubt_size(&grid, &workpiece.edge, warnings);
        if record.registered.is_none() {
            doubt_centre(&grid, &workpiece.edge, warnings);
        }
    }

    let needed = inside(&grid, &workpiece.clear);
    blank(&mut grid, |x, y| {
        let left_out = map.leave_out.iter().flatten().any(|area| area.contains(x, y));
        left_out || !workpiece.edge.contains(x, y)
    });
    if extent != Extent::Piece {
        cover::frame_covers(&grid, &workpiece.clear)?;
    }

    let before = measured(&grid, &needed);
    if before.count == 0 {
        return Err(Problem::error(
            codes::E0509,
            "file",
            "no pixel of the map has its centre inside the clear aperture",
        )
        .help("check `pixel`, `centre` and the size of `clear`"));
    }
    record.removed = low_order::subtract(&mut grid, &needed, &map.subtract).ok_or_else(|| not_fixed(before.count))?;
    let after = measured(&grid, &needed);

    // A hole that goes on beyond the clear aperture has no rim on that side: filling it would be guessing on.
    let limit = fill_limit(map, grid.pixel);
    let pixel_area = grid.pixel[0] * grid.pixel[1];
    let small = |hole: &holes::Hole| !hole.open && hole.pixels.len() as f64 * pixel_area <= limit;
    let mut found = holes::find(&grid, &needed);
    found.retain(|hole| small(hole) && holes::fill(&mut grid, hole));
    let filled_pixels: usize = found.iter().map(|hole| hole.pixels.len()).sum();
    let filled_area = filled_pixels as f64 * pixel_area;
    if !found.is_empty() {
        let message = format!(
            "{} of the map inside the clear aperture {} filled from {} rim: {filled_pixels} pixels, {} in all",
            plural(found.len(), "hole"),
            if found.len() == 1 { "was" } else { "were" },
            if found.len() == 1 { "its" } else { "their" },
            square_millimetres(filled_area)
        );
        warnings.push(Problem::warning(codes::W0500, "fill_below", message));
    }
    if extent == Extent::Whole {
        cover::no_holes(&grid, &workpiece.clear, |_| (None, limit))?;
    }
    let wavelength = raw.wavelength;
    let placed = Placed { grid, before, after, filled_holes: found.len(), filled_pixels, filled_area, wavelength };
    Ok((placed, record))
}

/// `mask`, `trim` and `despike`.
fn clean_picture(
    picture: &mut Picture,
    map: &HeightMap,
    files: &dyn FileProvider,
    warnings: &mut Vec<Problem>,
) -> Result<MapRecord, Problem> {
    let mut record = MapRecord { file: map.file.clone(), ..MapRecord::default() };
    if let Some(file) = &map.mask {
        let mask = read_file(file, files).map_err(|problem| Problem { field: Some("mask".into()), ..problem })?;
        record.masked = clean::mask(picture, &mask)?;
    }
    if let Some(width) = map.trim {
        record.trimmed = clean::trim(picture, width.0, fill_limit(map, picture.pixel));
    }
    let known = |picture: &Picture| picture.values.iter().filter(|value| !value.is_nan()).count();
    if let Some(rule) = &map.despike {
        let before = known(picture);
        record.spikes = clean::despike(picture, rule);
        if record.spikes as f64 > MANY_SPIKES * before as f64 {
            let message = format!("{} of {before} were taken for spikes", plural(record.spikes, "pixel"));
            warnings.push(
                Problem::warning(codes::W0511, "despike", message)
                    .note("dust is rare; a rule that takes so many takes noise or glass")
                    .help("raise `above`"),
            );
        }
    }
    if known(picture) == 0 {
        let field = if record.masked > 0 { "mask" } else { "trim" };
        return Err(Problem::error(codes::E0538, field, "nothing of the map is left once it is masked and trimmed")
            .help("check that the mask is 1 where the glass is good, and that `trim` is a small part of the map"));
    }
    Ok(record)
}

/// The picture in the part frame: by its marks where it has some, else by `up`, `rotated`, `view` and `centre`.
fn lay_on_part(
    picture: &Picture,
    map: &HeightMap,
    workpiece: &Workpiece,
    record: &mut MapRecord,
) -> Result<Grid, Problem> {
    let centre = picture.centre(&map.centre);
    let mirrored = map.view == View::from_back;
    let turned = map.rotated.map_or(0.0, |angle| angle.0);
    if map.fiducials.is_none() {
        // A part turned by a quarter from +x to +y shows upwards what lies a quarter back.
        let quarters = (turned / FRAC_PI_2).round();
        if (turned - quarters * FRAC_PI_2).abs() < 1e-9 {
            return Ok(lay(picture, quarter_turned(map.up, -(quarters as i32)), mirrored, centre));
        }
    }
    let laid = lay(picture, map.up, mirrored, centre);
    let similarity = if map.fiducials.is_some() {
        let fiducials = workpiece.fiducials.as_deref().unwrap_or_default();
        let declared = |at: [f64; 2]| position_in_frame(picture.pixel, map.up, mirrored, centre, at);
        let registered = register(map, fiducials, picture.pixel, declared)?;
        let similarity = registered.similarity;
        record.registered = Some(registered);
        similarity
    } else {
        Similarity::turn(-turned)
    };
    let pixel = laid.pixel.map(|side| side * similarity.scale);
    let wanted = pixels_of_part(&laid, &similarity, pixel, &workpiece.edge)?;
    let back = similarity.inverse();
    Ok(resample(&laid, &wanted, |place| back.apply(place)))
}

/// The pixels of the part frame that the picture says something of: one of them has its centre on the part's origin.
fn pixels_of_part(laid: &Grid, similarity: &Similarity, pixel: [f64; 2], edge: &Aperture) -> Result<Pixels, Problem> {
    let [[x0, y0], [x1, y1]] = Pixels::of(laid).bounds();
    let corners = [[x0, y0], [x1, y0], [x0, y1], [x1, y1]].map(|corner| similarity.apply(corner));
    let part = edge.bounds();
    let limit =
        |k: usize, start: f64, pick: fn(f64, f64) -> f64| corners.iter().fold(start, |best, c| pick(best, c[k]));
    let low = [0, 1].map(|k| limit(k, f64::INFINITY, f64::min).max(part.min[k]));
    let high = [0, 1].map(|k| limit(k, f64::NEG_INFINITY, f64::max).min(part.max[k]));
    if !(0..2).all(|k| low[k] < high[k]) {
        return Err(
            Problem::error(codes::E0509, "file", "the map lies beside the part").help("check `centre` and `fiducials`")
        );
    }
    let wanted = Pixels::covering(low, high, pixel, [0.0; 2]);
    if wanted.count() > MOST_PIXELS {
        return Err(too_many_pixels(&wanted));
    }
    Ok(wanted)
}

/// E0547 for more pixels than a map may have.
pub(super) fn too_many_pixels(wanted: &Pixels) -> Problem {
    let message = format!(
        "the map in the frame of the part would have {} columns and {} rows; at most {MOST_PIXELS} pixels are worked with",
        wanted.columns, wanted.rows
    );
    Problem::error(codes::E0547, "file", message).help("bin the map, or check `pixel`")
}

/// E0512 for `count` pixels that do not fix the terms.
pub(super) fn not_fixed(count: usize) -> Problem {
    let message =
        format!("{} measured inside the clear aperture cannot say what `subtract` names", plural(count, "pixel"));
    Problem::error(codes::E0512, "subtract", message).help("measure the part with more pixels, or check `pixel`")
}

/// Figures of the known pixels among those needed.
pub(super) fn measured(grid: &Grid, needed: &[bool]) -> Figures {
    Figures::of(grid.values.iter().zip(needed).filter(|(_, needed)| **needed).map(|(value, _)| *value))
}

/// Makes the pixels unknown whose centres are `out`.
pub(super) fn blank(grid: &mut Grid, out: impl Fn(f64, f64) -> bool) {
    for i in 0..grid.values.len() {
        let [x, y] = grid.position(i / grid.columns, i % grid.columns);
        if !grid.values[i].is_nan() && out(x, y) {
            grid.values[i] = f64::NAN;
        }
    }
}

/// What a value is multiplied with to be a height of the surface: a wavefront that was reflected has passed the error
/// twice.
pub(crate) fn surface_factor(quantity: Quantity) -> f64 {
    match quantity {
        Quantity::surface => 1.0,
        Quantity::wavefront => 0.5,
    }
}

/// A factor of two is the commonest mistake with heights: warns where the file's scale factor speaks against the job's
/// `quantity`, and where the file says that its sign was inverted.
pub(crate) fn doubt_scale(raw: &RawMap, quantity: Quantity, warnings: &mut Vec<Problem>) {
    if let Some(said) = raw.quantity
        && said != quantity
    {
        let (file, job) = match said {
            Quantity::surface => ("surface heights", "wavefront"),
            Quantity::wavefront => ("a wavefront", "surface"),
        };
        let message = format!("the map's file says that its values are {file}, but the job says `quantity: {job}`");
        warnings.push(
            Problem::warning(codes::W0502, "quantity", message)
                .note("one of the two is wrong by a factor of two, unless the part was measured in an unusual set-up"),
        );
    }
    if raw.sign_inverted {
        let message =
            "the map's file says that its sign was inverted when it was taken; its values are used as they stand";
        warnings.push(
            Problem::warning(codes::W0503, "positive", message)
                .help("make sure on the instrument that `positive` speaks of the values as they are stored"),
        );
    }
}

/// Warns when what was measured does not lie around the middle of the part.
fn doubt_centre(grid: &Grid, edge: &Aperture, warnings: &mut Vec<Problem>) {
    let Some([column, row]) = valid_middle(grid.columns, &grid.values) else { return };
    let found = [grid.origin[0] + column * grid.pixel[0], grid.origin[1] + row * grid.pixel[1]];
    let expected = edge.centre();
    let off = [found[0] - expected[0], found[1] - expected[1]];
    if (off[0] / grid.pixel[0]).abs() <= CENTRING && (off[1] / grid.pixel[1]).abs() <= CENTRING {
        return;
    }
    let message = format!(
        "the middle of the valid pixels lies at x {:.3} mm, y {:.3} mm, {:.1} pixels from the middle of the part",
        found[0] * 1e3,
        found[1] * 1e3,
        libm::hypot(off[0] / grid.pixel[0], off[1] / grid.pixel[1])
    );
    warnings.push(
        Problem::warning(codes::W0501, "centre", message)
            .note("a map that lies wrong on the part moves all removal by as much")
            .help("check `centre`; say `valid_centre` if the map was masked to the part"),
    );
}

/// Warns when what was measured is much wider than the part.
fn doubt_size(grid: &Grid, edge: &Aperture, warnings: &mut Vec<Problem>) {
    let (mut low, mut high) = ([usize::MAX; 2], [0_usize; 2]);
    for (i, _) in grid.values.iter().enumerate().filter(|(_, value)| !value.is_nan()) {
        let at = [i % grid.columns, i / grid.columns];
        low = [0, 1].map(|k| low[k].min(at[k]));
        high = [0, 1].map(|k| high[k].max(at[k]));
    }
    let part = edge.bounds();
    let width = |k: usize| (high[k] + 1).saturating_sub(low[k]) as f64 * grid.pixel[k];
    let size = |k: usize| part.max[k] - part.min[k];
    // One that fills the frame was not masked to the part: nothing can be said.
    let filled = low == [0, 0] && high == [grid.columns - 1, grid.rows - 1];
    if filled || (0..2).all(|k| width(k) <= WIDER * size(k)) {
        return;
    }
    let message = format!(
        "the measured pixels reach over {:.3} mm x {:.3} mm, the part has {:.3} mm x {:.3} mm",
        width(0) * 1e3,
        width(1) * 1e3,
        size(0) * 1e3,
        size(1) * 1e3
    );
    warnings.push(
        Problem::warning(codes::W0510, "pixel", message)
            .note("what lies beyond the edge of the part is left out")
            .help("check `pixel` and the size of `edge`"),
    );
}
