//! Tables of text: `.csv`, `.xyz`, `.txt`.
//!
//! In: text. Out: a [`RawMap`], or a [`Profile`] where the table has one coordinate. What units the header names become
//! metres; what it does not name the job must say.
//!
//! - **Separators** are semicolons, else tabulators, else commas, else blanks, whichever the first line of numbers has. A
//!   comma is a decimal point only between semicolons: elsewhere `1,234` could be a thousand.
//! - **Header**: lines that begin with `#` or `%`, in which Gwyddion's `Width`, `Height` and `Value units` are understood,
//!   and one line of names, with units as in `x (mm)`, `Z [nm]`, `x in µm` or `X_(microns)`. A column named `index` is
//!   left out.
//! - **Three columns** are points x, y, height. They must lie on a grid, in any order; places without a point are not
//!   measured. x grows to the right and y upwards.
//! - **Four columns and more** are a matrix of heights; the first line is the top of the picture.
//! - **Two columns** are a profile: position, height.
//! - An empty cell, `NaN` and `No Data` were not measured.

use super::refusals::{unknown_unit, unreadable};
use super::text::{self, shown};
use super::{Content, Format, MOST_PIXELS, Profile, RawMap, grid_of_points, length_unit, proved_pixels};
use crate::diagnostics::Problem;

/// Lines before the first numbers that are looked through.
const MOST_HEADER_LINES: usize = 100;

/// Whether the text has a line of numbers, where a table would have it.
pub fn is_table(text: &str) -> bool {
    first_numbers(text).is_some()
}

/// Index and separator of the first line that is numbers, two or more.
fn first_numbers(text: &str) -> Option<(usize, Separator)> {
    text.lines().take(MOST_HEADER_LINES).enumerate().find_map(|(at, line)| {
        let separator = Separator::of(line);
        let mut count = 0;
        let numbers = separator.cells(line).all(|cell| {
            count += 1;
            separator.number(cell).is_some()
        });
        // With a blank or nothing between them, remarks and empty cells would be numbers too.
        (numbers && count >= 2 && line.bytes().any(|byte| byte.is_ascii_digit())).then_some((at, separator))
    })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Separator {
    Semicolon,
    Tab,
    Comma,
    Blanks,
}

impl Separator {
    fn of(line: &str) -> Separator {
        if line.contains(';') {
            Separator::Semicolon
        } else if line.trim().contains('\t') {
            Separator::Tab
        } else if line.contains(',') {
            Separator::Comma
        } else {
            Separator::Blanks
        }
    }

    /// The cells of a line, trimmed, without quotes.
    fn cells<'a>(self, line: &'a str) -> Box<dyn Iterator<Item = &'a str> + 'a> {
        // Blanks only: a tabulator at the end of a line is an empty cell.
        let line = line.trim_matches(' ');
        let tidy = |cell: &'a str| cell.trim().trim_matches('"').trim();
        match self {
            Separator::Semicolon => Box::new(line.split(';').map(tidy)),
            Separator::Tab => Box::new(line.split('\t').map(tidy)),
            Separator::Comma => Box::new(line.split(',').map(tidy)),
            Separator::Blanks => Box::new(line.split_whitespace().map(tidy)),
        }
    }

    /// The number in a cell; NaN for one that was not measured.
    fn number(self, cell: &str) -> Option<f64> {
        let decimal_comma = self == Separator::Semicolon && cell.contains(',');
        let number = if !decimal_comma {
            text::number(cell)
        } else if cell.contains('.') {
            None
        } else {
            text::number(&cell.replacen(',', ".", 1))
        };
        number.or_else(|| text::is_no_data(cell).then_some(f64::NAN))
    }
}

/// What the lines before the numbers say.
#[derive(Default)]
struct Header {
    /// Names of the columns with the units of their own, where there is a line of them.
    names: Vec<(String, Option<f64>)>,
    /// Width and height of the whole picture, metres, and metres a value, from remarks.
    width: Option<f64>,
    height: Option<f64>,
    unit: Option<f64>,
}

/// Reads a table. Fields are `file`.
///
/// # Errors
/// E0514 for a unit that is not known, E0515 for what is no table of numbers, E0516 for points that lie on no grid, E0501
/// for too many pixels.
pub fn read(text: &str, name: &str) -> Result<Content, Problem> {
    let Some((first, separator)) = first_numbers(text) else {
        return Err(unreadable(name, "has no line of numbers"));
    };
    let header = header(text, first, separator, name)?;
    // A column that only counts is left out.
    let index = header.names.iter().position(|(name, _)| matches!(name.as_str(), "index" | "no" | "nr"));
    let names: Vec<&(String, Option<f64>)> =
        header.names.iter().enumerate().filter(|(at, _)| Some(*at) != index).map(|(_, name)| name).collect();
    let (columns, values) = numbers(text, first, separator, index, name)?;
    if !names.is_empty() && names.len() != columns {
        let message = format!("names {} columns and has {columns}", names.len());
        return Err(unreadable(name, message));
    }
    if columns == 0 || values.len() < 2 * columns {
        return Err(unreadable(name, "has one line of numbers, which is neither a map nor a profile"));
    }
    match columns {
        1 => Err(unreadable(name, "has one column of numbers, which is neither a map nor a profile")),
        2 => Ok(Content::Profile(profile(&values, &names))),
        3 => points(&values, &names, name).map(Content::Map),
        _ if !names.is_empty() => {
            let message = format!("names its {columns} columns; a table of points has x, y and height");
            Err(unreadable(name, message))
        }
        _ => matrix(columns, values, &header, name).map(Content::Map),
    }
}

/// All numbers, line by line, without the column `index`, and how many a line has.
fn numbers(
    text: &str,
    first: usize,
    separator: Separator,
    index: Option<usize>,
    name: &str,
) -> Result<(usize, Vec<f64>), Problem> {
    let (mut columns, mut values) = (0, Vec::new());
    let mut each_ends_with_a_separator = separator != Separator::Blanks;
    for (at, line) in text.lines().enumerate().skip(first) {
        let line = line.trim_matches(['\u{1A}', ' ', '\r', '\u{C}']);
        if line.is_empty() || line.starts_with(['#', '%']) {
            continue;
        }
        let before = values.len();
        for (place, cell) in separator.cells(line).enumerate() {
            if Some(place) == index {
                continue;
            }
            let Some(value) = separator.number(cell) else {
                let message = format!("has `{}` in line {} where a number stands", shown(cell), at + 1);
                return Err(unreadable(name, message));
            };
            values.push(value);
        }
        each_ends_with_a_separator &= line.ends_with([';', ',', '\t']);
        let count = values.len() - before;
        if before == 0 {
            columns = count;
            // Once, instead of growing by doubling: the text may have a hundred million numbers.
            let lines = text.bytes().filter(|byte| *byte == b'\n').count();
            values.reserve_exact(lines.saturating_mul(count).min(3 * MOST_PIXELS as usize));
        }
        if count != columns {
            let message = format!("has {count} numbers in line {} and {columns} in the lines before", at + 1);
            return Err(unreadable(name, message));
        }
        // Three numbers a point are the most that a pixel takes.
        proved_pixels((values.len() as u64).div_ceil(3), 1, name)?;
    }
    if each_ends_with_a_separator && columns > 1 {
        // Of coordinates and heights none is left out. A matrix may end in a column that was not measured, or in a
        // separator that means nothing: a whole column more or less moves its middle.
        if columns > 4 {
            return Err(unreadable(
                name,
                "ends every line with a separator, which may or may not mean a column that was not measured",
            ));
        }
        values = values.chunks_exact(columns).flat_map(|line| line[..columns - 1].iter().copied()).collect();
        columns -= 1;
    }
    Ok((columns, values))
}

fn header(text: &str, first: usize, separator: Separator, name: &str) -> Result<Header, Problem> {
    let mut header = Header::default();
    let lines = || text.lines().take(first).map(str::trim).filter(|line| !line.is_empty());
    let length = |of: &str, value: &str| -> Result<Option<f64>, Problem> {
        let Some((number, unit)) = value.trim().split_once(' ') else { return Ok(None) };
        let Some(number) = text::number(number) else { return Ok(None) };
        match length_unit::metres(unit) {
            Some(metres) => Ok(Some(number * metres)),
            None => Err(unknown_unit(name, of, unit)),
        }
    };
    for line in lines().filter(|line| line.starts_with(['#', '%'])) {
        let Some((key, value)) = line.trim_start_matches(['#', '%', ' ']).split_once(':') else { continue };
        match key.trim().to_lowercase().as_str() {
            "width" => header.width = length("columns", value)?,
            "height" => header.height = length("rows", value)?,
            "value units" => {
                let metres = length_unit::metres(value);
                header.unit = Some(metres.ok_or_else(|| unknown_unit(name, "heights", value.trim()))?);
            }
            _ => {}
        }
    }
    // The names stand in the last line before the numbers.
    if let Some(line) = lines().filter(|line| !line.starts_with(['#', '%'])).last() {
        let separator = if separator == Separator::Blanks { Separator::of(line) } else { separator };
        let mut cells: Vec<String> = Vec::new();
        for cell in separator.cells(line) {
            match cells.last_mut() {
                // Between blanks a unit is a word of its own: `x (mm) y (mm)`.
                Some(last) if separator == Separator::Blanks && cell.starts_with(['(', '[']) => last.push_str(cell),
                _ => cells.push(cell.to_string()),
            }
        }
        if cells.len() > 1 && cells.last().is_some_and(String::is_empty) {
            cells.pop();
        }
        header.names = cells.iter().map(|cell| column(cell, name)).collect::<Result<_, _>>()?;
    }
    Ok(header)
}

/// Name and unit of a column: `x (mm)`, `Z [nm]`, `x in µm`, `X_(microns)`, `z/nm`, or a name alone.
fn column(cell: &str, name: &str) -> Result<(String, Option<f64>), Problem> {
    let split = |open: &[char], close: &[char]| -> Option<(&str, &str)> {
        let (before, after) = cell.split_once(open)?;
        Some((before, after.split_once(close).map_or(after, |(unit, _)| unit)))
    };
    let found = split(&['(', '['], &[')', ']']).or_else(|| cell.split_once(" in ")).or_else(|| cell.split_once('/'));
    let (column, unit) = found.map_or((cell, None), |(column, unit)| (column, Some(unit.trim())));
    let column = column.trim().trim_end_matches(['_', ' ', ',', ':']).to_lowercase();
    let metres = match unit {
        None | Some("") => None,
        Some(unit) => Some(length_unit::metres(unit).ok_or_else(|| {
            let column = shown(&column);
            unknown_unit(name, &format!("values of `{column}`"), unit)
        })?),
    };
    Ok((column, metres))
}

fn profile(values: &[f64], names: &[&(String, Option<f64>)]) -> Profile {
    let unit = |place: usize| names.get(place).and_then(|(_, unit)| *unit);
    let column = |place: usize| {
        let scale = unit(place).unwrap_or(1.0);
        values.chunks_exact(2).map(|pair| pair[place] * scale).collect()
    };
    Profile {
        format: Format::Table,
        positions: column(0),
        positions_in_metres: unit(0).is_some(),
        heights: column(1),
        in_metres: unit(1).is_some(),
    }
}

fn points(values: &[f64], names: &[&(String, Option<f64>)], name: &str) -> Result<RawMap, Problem> {
    let place = |letters: &[&str], otherwise: usize| {
        let found = names.iter().position(|(column, _)| letters.iter().any(|letter| column.starts_with(letter)));
        if names.is_empty() { Some(otherwise) } else { found }
    };
    let (Some(x), Some(y), Some(z)) = (place(&["x"], 0), place(&["y"], 1), place(&["z", "h", "sag"], 2)) else {
        let known: Vec<String> = names.iter().map(|(column, _)| format!("`{}`", shown(column))).collect();
        let message = format!("names its columns {}; a table of points has x, y and z", known.join(", "));
        return Err(unreadable(name, message));
    };
    let unit = |place: usize| names.get(place).and_then(|(_, unit)| *unit);
    let side = match (unit(x), unit(y)) {
        (Some(x), Some(y)) => Some([x, y]),
        (None, None) => None,
        _ => return Err(unreadable(name, "names the unit of one of x and y, and not of the other")),
    };
    let column = |place: usize| values.chunks_exact(3).map(|point| point[place]).collect::<Vec<f64>>();
    let grid = grid_of_points::grid(&column(x), &column(y), &column(z), name)?;
    let pixel = match side {
        Some(unit) => Some([grid.pitch[0] * unit[0], grid.pitch[1] * unit[1]]),
        None => {
            grid_of_points::prove_square(grid.pitch, name)?;
            None
        }
    };
    let scale = unit(z);
    let values = grid.values.iter().map(|value| value * scale.unwrap_or(1.0)).collect();
    Ok(RawMap { in_metres: scale.is_some(), pixel, ..RawMap::plain(Format::Table, grid.columns, grid.rows, values) })
}

fn matrix(columns: usize, values: Vec<f64>, header: &Header, name: &str) -> Result<RawMap, Problem> {
    let rows = values.len() / columns;
    proved_pixels(columns as u64, rows as u64, name)?;
    let pixel = match (header.width, header.height) {
        (Some(width), Some(height)) => Some([width / columns as f64, height / rows as f64]),
        _ => None,
    };
    if let Some(pixel) = pixel
        && !pixel.iter().all(|side| *side > 0.0 && side.is_finite())
    {
        return Err(unreadable(name, "says a width or a height that is not positive"));
    }
    let values = values.iter().map(|value| value * header.unit.unwrap_or(1.0)).collect();
    Ok(RawMap { in_metres: header.unit.is_some(), pixel, ..RawMap::plain(Format::Table, columns, rows, values) })
}
