//! Combine: the members of `FormError` become one map of the part.
//!
//! In: the job's `error` (or `target`), a tree of maps and of what is made of them. Out: one [`Placed`] map, and a
//! `Record` of every file that went in. Maps are put on the part one by one (`place`), so that each may have
//! been taken with the part turned, from the other side, or with another instrument; then they are brought onto the
//! pixels of the first.

use super::place::{self, Extent, MapRecord, Placed, blank, measured, place_map, too_many_pixels};
use super::resample::{Pixels, onto, value_at};
use super::{LowOrder, cover, low_order, stitch};
use crate::diagnostics::{Problem, codes};
use crate::height_map::{Grid, MOST_PIXELS, read_file};
use crate::job::{Aperture, Average, Difference, FormError, Positive, Stitched, Workpiece, ZernikeError};
use crate::source::FileProvider;
use crate::workpiece::form::zernike;

/// What the report tells of how a map came about.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Record {
    /// Every file, in the order in which the job says them.
    pub maps: Vec<MapRecord>,
    /// Every stitched map, the pieces of another one before it.
    pub stitched: Vec<StitchedRecord>,
    /// Standard deviation of one map among those that are averaged, over the pixels that at least two of them know, metres:
    /// root mean square over the pixels. Of the last average that was formed.
    pub spread: Option<f64>,
}

/// What was done to make one map of pieces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StitchedRecord {
    /// Of the job: `workpiece.error`, or where in it.
    pub field: String,
    pub seams: Vec<stitch::Seam>,
    /// What its `subtract` took off the whole.
    pub removed: LowOrder,
}

/// How far beyond the edge of the part polynomials are told that are taken off another map, in pixels of theirs: as far as
/// the cubic of a place on the edge looks. So no pixel at the edge is lost for lying between others.
const BEYOND_EDGE: f64 = 2.0;

/// Most pixels of all maps that are put together: eight of the largest, which is a gigabyte.
const MOST_TOGETHER: u64 = 8 * MOST_PIXELS;

/// Makes maps of the part.
pub(super) struct Combine<'a> {
    pub workpiece: &'a Workpiece,
    pub files: &'a dyn FileProvider,
    /// Of the job, the map that is being made.
    pub field: String,
    pub record: Record,
}

impl<'a> Combine<'a> {
    /// For the map at `field` of the job.
    pub fn new(workpiece: &'a Workpiece, files: &'a dyn FileProvider, field: &str) -> Combine<'a> {
        Combine { workpiece, files, field: field.to_string(), record: Record::default() }
    }

    /// One map of all. Fields are those of `error`; warnings go to `warnings`.
    pub fn form_error(
        &mut self,
        error: &FormError,
        extent: Extent,
        warnings: &mut Vec<Problem>,
    ) -> Result<Placed, Problem> {
        match error {
            FormError::height_map(map) => {
                let raw = read_file(&map.file, self.files)?;
                let (placed, record) = place_map(&raw, map, self.workpiece, extent, self.files, warnings)?;
                self.record.maps.push(record);
                Ok(placed)
            }
            FormError::zernike_error(polynomials) => self.zernike_error(polynomials, 0.0),
            FormError::average(average) => self.average(average, extent, warnings),
            FormError::difference(difference) => self.difference(difference, extent, warnings),
            FormError::stitched(stitched) => self.stitched(stitched, extent, warnings),
        }
    }

    /// [`form_error`](Self::form_error) of a map that is taken off another one, whose pixels may lie otherwise.
    pub fn taken_off(
        &mut self,
        error: &FormError,
        extent: Extent,
        warnings: &mut Vec<Problem>,
    ) -> Result<Placed, Problem> {
        match error {
            FormError::zernike_error(polynomials) => self.zernike_error(polynomials, BEYOND_EDGE),
            measured => self.form_error(measured, extent, warnings),
        }
    }

    /// What `make` makes of the field at `field`.
    fn within(
        &mut self,
        field: &str,
        warnings: &mut Vec<Problem>,
        make: impl FnOnce(&mut Self, &mut Vec<Problem>) -> Result<Placed, Problem>,
    ) -> Result<Placed, Problem> {
        let mut said = Vec::new();
        let around = self.field.len();
        self.field.push('.');
        self.field.push_str(field);
        let placed = make(self, &mut said);
        self.field.truncate(around);
        warnings.extend(said.into_iter().map(|warning| warning.within(field)));
        placed.map_err(|problem| problem.within(field))
    }

    /// Several, at least two. Fields are `field.0`, `field.1`, ….
    fn several(
        &mut self,
        field: &str,
        errors: &[FormError],
        extent: Extent,
        warnings: &mut Vec<Problem>,
    ) -> Result<Vec<Placed>, Problem> {
        if errors.len() < 2 {
            let message = format!("`{field}` names {} of the maps that are to be put together", errors.len());
            return Err(
                Problem::error(codes::E0544, field, message).help("name two or more, or use the one map itself")
            );
        }
        let (mut all, mut pixels) = (Vec::new(), 0);
        for (i, error) in errors.iter().enumerate() {
            let make = |this: &mut Self, said: &mut Vec<Problem>| this.form_error(error, extent, said);
            let one = self.within(&format!("{field}.{i}"), warnings, make)?;
            pixels += one.grid.values.len() as u64;
            if pixels > MOST_TOGETHER {
                let message = format!("the first {} maps have {pixels} pixels together", i + 1);
                return Err(Problem::error(codes::E0547, format!("{field}.{i}"), message)
                    .help(format!("bin the maps: at most {MOST_TOGETHER} pixels are put together")));
            }
            all.push(one);
        }
        Ok(all)
    }

    fn average(&mut self, average: &Average, extent: Extent, warnings: &mut Vec<Problem>) -> Result<Placed, Problem> {
        let members = if extent == Extent::Piece { Extent::Piece } else { Extent::Covering };
        let all = self.several("of", &average.of, members, warnings)?;
        let pixels = Pixels::of(&all[0].grid);
        let grids: Vec<Grid> = all.iter().map(|placed| onto(&placed.grid, &pixels)).collect();
        let mut mean = all[0].grid.clone();
        let (mut variances, mut compared) = (0.0, 0_usize);
        for (i, value) in mean.values.iter_mut().enumerate() {
            let known = || grids.iter().map(|grid| grid.values[i]).filter(|v| !v.is_nan());
            let count = known().count();
            let here = known().sum::<f64>() / count as f64;
            if count >= 2 {
                variances += known().map(|v| (v - here) * (v - here)).sum::<f64>() / (count - 1) as f64;
                compared += 1;
            }
            *value = if 2 * count >= grids.len() { here } else { f64::NAN };
        }
        self.record.spread = (compared > 0).then(|| (variances / compared as f64).sqrt());
        let placed = self.put_together(mean, &all);
        if extent == Extent::Whole {
            cover::no_holes(&placed.grid, &self.workpiece.clear, |hole| {
                let place = placed.grid.position(hole.pixels[0] / pixels.columns, hole.pixels[0] % pixels.columns);
                blind("of", &average.of, &all, place)
            })
            .map_err(|problem| problem.note("fewer than half of the maps know a height there"))?;
        }
        Ok(placed)
    }

    fn difference(
        &mut self,
        difference: &Difference,
        extent: Extent,
        warnings: &mut Vec<Problem>,
    ) -> Result<Placed, Problem> {
        let of = self.within("of", warnings, |this, said| this.form_error(&difference.of, extent, said))?;
        let minus = self.within("minus", warnings, |this, said| this.taken_off(&difference.minus, extent, said))?;
        let mut grid = of.grid.clone();
        take_off(&mut grid, &minus.grid);
        if extent == Extent::Whole {
            only_between_pixels(&grid, &self.workpiece.clear).map_err(|problem| problem.within("minus"))?;
        }
        Ok(self.put_together(grid, &[of, minus]))
    }

    fn stitched(
        &mut self,
        stitched: &Stitched,
        extent: Extent,
        warnings: &mut Vec<Problem>,
    ) -> Result<Placed, Problem> {
        let all = self.several("maps", &stitched.maps, Extent::Piece, warnings)?;
        let grids: Vec<&Grid> = all.iter().map(|placed| &placed.grid).collect();
        let (grid, seams) = stitch::stitch(&grids, stitched.mismatch.0)?;
        if extent == Extent::Whole {
            cover::frame_covers(&grid, &self.workpiece.clear)
                .map_err(|p| Problem { field: Some("maps".into()), ..p })?;
        }
        let mut placed = self.put_together(grid, &all);
        let needed = cover::inside(&placed.grid, &self.workpiece.clear);
        let removed = low_order::subtract(&mut placed.grid, &needed, &stitched.subtract)
            .ok_or_else(|| place::not_fixed(placed.before.count))?;
        placed.after = measured(&placed.grid, &needed);
        self.record.stitched.push(StitchedRecord { field: self.field.clone(), seams, removed });
        if extent == Extent::Whole {
            let columns = placed.grid.columns;
            cover::no_holes(&placed.grid, &self.workpiece.clear, |hole| {
                // Where the pieces end, no single one of them ends too soon.
                if hole.open {
                    return (Some("maps".into()), 0.0);
                }
                let place = placed.grid.position(hole.pixels[0] / columns, hole.pixels[0] % columns);
                blind("maps", &stitched.maps, &all, place)
            })?;
        }
        Ok(placed)
    }

    /// On pixels of its own, up to so many of them beyond the edge of the part.
    fn zernike_error(&self, error: &ZernikeError, beyond: f64) -> Result<Placed, Problem> {
        let most = zernike::most_terms(error.order);
        if error.coefficients.is_empty() || error.coefficients.len() > most {
            let message = format!("the error has {} coefficients; its order has 1 to {most}", error.coefficients.len());
            return Err(Problem::error(codes::E0545, "coefficients", message)
                .help("the first coefficient belongs to the first polynomial of the order; write 0 nm for those that are not used"));
        }
        let sign = if error.positive == Positive::low { -1.0 } else { 1.0 };
        let coefficients: Vec<f64> = error.coefficients.iter().map(|a| sign * a.0).collect();
        let sum = zernike::Sum::new(error.order, error.radius.0, &coefficients);
        let edge = &self.workpiece.edge;
        let bounds = edge.bounds();
        let room = beyond * error.pixel.0;
        let (low, high) = (bounds.min.map(|at| at - room), bounds.max.map(|at| at + room));
        let pixels = Pixels::covering(low, high, [error.pixel.0; 2], [0.0; 2]);
        if pixels.count() > MOST_PIXELS {
            return Err(Problem { field: Some("pixel".into()), ..too_many_pixels(&pixels) });
        }
        let Pixels { columns, rows, pixel, origin } = pixels;
        let mut grid = Grid { columns, rows, pixel, origin, values: Vec::with_capacity(columns * rows) };
        for i in 0..columns * rows {
            let [x, y] = grid.position(i / columns, i % columns);
            grid.values.push(sum.at(x, y).sag);
        }
        blank(&mut grid, |x, y| !edge.contains(x, y) && (beyond == 0.0 || -edge.distance(x, y) > 1.5 * room));
        Ok(self.put_together(grid, &[]))
    }

    /// A map made of others.
    fn put_together(&self, grid: Grid, from: &[Placed]) -> Placed {
        let figures = measured(&grid, &cover::inside(&grid, &self.workpiece.clear));
        Placed {
            grid,
            before: figures,
            after: figures,
            filled_holes: from.iter().map(|placed| placed.filled_holes).sum(),
            filled_pixels: from.iter().map(|placed| placed.filled_pixels).sum(),
            filled_area: from.iter().map(|placed| placed.filled_area).sum(),
            wavelength: from.first().and_then(|placed| placed.wavelength),
        }
    }
}

/// The map among `all`, the maps of `field`, that shows `place` and knows no height there: its field, and the largest hole that
/// its words let be filled.
fn blind(field: &str, errors: &[FormError], all: &[Placed], place: [f64; 2]) -> (Option<String>, f64) {
    let shows = |grid: &Grid| {
        let [low, high] = Pixels::of(grid).bounds();
        (0..2).all(|k| low[k] <= place[k] && place[k] <= high[k])
    };
    let blind = |placed: &Placed| shows(&placed.grid) && value_at(&placed.grid, place).is_nan();
    let Some(i) = all.iter().position(blind) else { return (Some(field.to_string()), 0.0) };
    let limit = match &errors[i] {
        FormError::height_map(map) => place::fill_limit(map, all[i].grid.pixel),
        _ => 0.0,
    };
    (Some(format!("{field}.{i}")), limit)
}

/// Refuses what a map without holes has lost to another one without holes: pixels at the rim, which have no neighbours all
/// around on the other one's pixels.
pub(super) fn only_between_pixels(grid: &Grid, clear: &Aperture) -> Result<(), Problem> {
    cover::no_holes(grid, clear, |_| (None, 0.0)).map_err(|problem| {
        Problem { field: None, ..problem }.note(
            "each map covers the clear aperture; brought onto the other one's pixels, a map ends up to a pixel sooner",
        )
    })
}

/// `minus` off `grid`; unknown where either is.
pub(super) fn take_off(grid: &mut Grid, minus: &Grid) {
    let minus = onto(minus, &Pixels::of(grid));
    for (value, minus) in grid.values.iter_mut().zip(minus.values) {
        *value -= minus;
    }
}
