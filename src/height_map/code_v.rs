//! CODE V interferogram files (`.int`) that hold a grid.
//!
//! In: text. Out: a [`RawMap`] in metres; such a file says no pixel, since CODE V stretches it over the aperture of a
//! surface. The writer makes such files.
//!
//! Lines that begin with `!` are remarks. The first other line is a title, the next one describes the grid, and then come
//! `nx * ny` whole numbers, row by row, each row from -x to +x, **from the lowest row upwards**:
//!
//! | word | meaning |
//! | --- | --- |
//! | `GRD nx ny` | columns, rows |
//! | `SUR`, `WFR` | heights of a surface, of a wavefront; `FIL` (a transmission) is no map |
//! | `WVL w` | wavelength in micrometres: the unit of the heights |
//! | `SSZ s` | numbers a wavelength: height = value / s * w |
//! | `NDA n` | the number that means "no data" |
//! | `NNB` | how to read between the pixels; of no concern here |
//!
//! Source: *CODE V Reference Manual*, "Interferogram files", as the readers and writers of MetroPro and prysm have it.

use super::metropro::WAVELENGTHS;
use super::refusals::{impossible, unread, unreadable, within};
use super::text::{self, shown};
use super::{Format, RawMap, proved_pixels};
use crate::diagnostics::Problem;
use crate::job::Quantity;

/// Scales that can be: from a wavelength a number to a millionth of a picometre.
const SCALES: (f64, f64) = (1e-3, 1e15);

/// Descriptions of interferogram files that hold coefficients instead of a grid.
const COEFFICIENTS: [&str; 3] = ["ZFR", "ZRN", "XYP"];

/// Remark lines before the title that are looked through.
const MOST_REMARKS: usize = 1000;

/// Whether the text is such a file: a title, then a line that describes a grid or coefficients.
pub fn is_code_v(text: &str) -> bool {
    description(text).is_some()
}

/// The line that describes the grid, what follows it, and its number from 1.
fn description(text: &str) -> Option<(&str, &str, usize)> {
    let (mut rest, mut others, mut number) = (text, 0, 0);
    while number < MOST_REMARKS {
        let (line, after) = rest.split_once('\n')?;
        (rest, number) = (after, number + 1);
        if line.trim_start().starts_with('!') {
            continue;
        }
        others += 1;
        if others == 2 {
            let first = line.split_whitespace().next()?.to_ascii_uppercase();
            return (first == "GRD" || COEFFICIENTS.contains(&first.as_str())).then_some((line, rest, number));
        }
    }
    None
}

/// Reads a map. Fields are `file`.
///
/// # Errors
/// E0503 if description and numbers do not fit each other, E0504 for a description that cannot be, E0513 for what is no
/// grid of heights, E0515 for what is no whole number, E0501 for too many pixels.
pub fn read(text: &str, name: &str) -> Result<RawMap, Problem> {
    let Some((line, rest, number)) = description(text) else {
        return Err(unreadable(name, "has no line `GRD …` after its title"));
    };
    let words = Words::of(line, name)?;
    let pixels = proved_pixels(words.columns, words.rows, name)?;
    text::last_line_ends(text, name)?;
    let height = words.wavelength / words.scale;
    let value = |word: &str| {
        let value: i64 = word.parse().ok()?;
        Some(if Some(value) == words.no_data { f64::NAN } else { value as f64 * height })
    };
    let mut upwards = text::grid_values(name, rest.split('\n'), number + 1, rest.len(), pixels, value)?;
    let (columns, rows) = (words.columns as usize, words.rows as usize);
    flip(&mut upwards, columns, rows);
    Ok(RawMap {
        in_metres: true,
        wavelength: Some(words.wavelength),
        quantity: Some(words.quantity),
        ..RawMap::plain(Format::CodeV, columns, rows, upwards)
    })
}

/// Exchanges the rows of a picture, top for bottom.
fn flip(values: &mut [f64], columns: usize, rows: usize) {
    for row in 0..rows / 2 {
        let (above, below) = values.split_at_mut((rows - 1 - row) * columns);
        above[row * columns..(row + 1) * columns].swap_with_slice(&mut below[..columns]);
    }
}

struct Words {
    columns: u64,
    rows: u64,
    quantity: Quantity,
    /// Metres.
    wavelength: f64,
    /// Numbers a wavelength.
    scale: f64,
    no_data: Option<i64>,
}

impl Words {
    fn of(line: &str, name: &str) -> Result<Words, Problem> {
        let (mut size, mut quantity, mut wavelength, mut scale, mut no_data) = (None, None, None, None, None);
        let upper = line.to_ascii_uppercase();
        let mut words = upper.split_whitespace();
        while let Some(word) = words.next() {
            let mut after = |what: &str| {
                let value = words.next().and_then(text::number);
                value.ok_or_else(|| impossible(name, format!("has no {what} after `{word}`")))
            };
            let twice = match word {
                "GRD" => {
                    let sides = [after("number of columns")?, after("number of rows")?];
                    if !sides.iter().all(|side| *side >= 1.0 && side.fract() == 0.0) {
                        return Err(impossible(name, format!("says a grid of {} x {}", sides[0], sides[1])));
                    }
                    size.replace(sides.map(|side| side as u64)).is_some()
                }
                "SUR" => quantity.replace(Quantity::surface).is_some(),
                "WFR" => quantity.replace(Quantity::wavefront).is_some(),
                "WVL" => wavelength.replace(after("wavelength")? * 1e-6).is_some(),
                "SSZ" => scale.replace(after("scale")?).is_some(),
                "NDA" => no_data.replace(after("number")? as i64).is_some(),
                "NNB" => false,
                "FIL" => {
                    return Err(unread(
                        name,
                        "holds a filter (`FIL`), the transmission of an aperture",
                        "export the surface (`SUR`) or the wavefront (`WFR`)",
                    ));
                }
                _ if COEFFICIENTS.contains(&word) => {
                    return Err(unread(
                        name,
                        format!("holds coefficients (`{word}`), not a grid of heights"),
                        "export the map as a grid (`GRD`)",
                    ));
                }
                _ => {
                    let message = format!("describes its grid with the word `{}`, which is not known", shown(word));
                    return Err(unread(name, message, "known are GRD, SUR, WFR, WVL, SSZ, NDA and NNB"));
                }
            };
            if twice {
                return Err(impossible(name, format!("says `{word}`, or what it excludes, twice")));
            }
        }
        let missing = |word: &str| impossible(name, format!("describes its grid without `{word}`"));
        let [columns, rows] = size.ok_or_else(|| missing("GRD"))?;
        Ok(Words {
            columns,
            rows,
            quantity: quantity.ok_or_else(|| missing("SUR"))?,
            wavelength: within(name, "`WVL` in metres", wavelength.ok_or_else(|| missing("WVL"))?, WAVELENGTHS)?,
            scale: within(name, "`SSZ`", scale.ok_or_else(|| missing("SSZ"))?, SCALES)?,
            no_data,
        })
    }
}

/// What a written number may be at most, and the number for "no data": CODE V's own of 16 bits.
const LARGEST: f64 = 32_766.0;
const NO_DATA: i64 = 32_767;

/// Writes heights in metres, row-major from the upper left of the picture, NaN where invalid, as `SUR` or `WFR`. Rounded
/// to the nearest of 65,533 steps between the greatest height and its negative, so that reading gives each height back
/// within 1/65532 of the greatest. The unit is the micrometre (`WVL 1`), which no reader can mistake. `None` if `heights`
/// does not fill the rows, has more pixels than are read, or none that is valid, or one that is infinite.
pub fn write(columns: usize, heights: &[f64], quantity: Quantity, title: &str) -> Option<Vec<u8>> {
    if columns == 0 || !heights.len().is_multiple_of(columns) || heights.len() as u64 > super::MOST_PIXELS {
        return None;
    }
    let rows = heights.len() / columns;
    let valid = || heights.iter().copied().filter(|height| !height.is_nan());
    let greatest = valid().fold(f64::NEG_INFINITY, |most, height| most.max(height.abs())) * 1e6;
    if !greatest.is_finite() {
        return None;
    }
    // What a reader finds is the printed scale, so the numbers are made with it. Six digits, cut off: no number grows
    // beyond the greatest.
    let scale = if greatest > 0.0 { LARGEST / greatest } else { LARGEST };
    let scale: f64 = format!("{:.5e}", scale * (1.0 - 1e-5)).parse().ok()?;
    let title: String = title.chars().filter(|c| c.is_ascii() && !c.is_control()).take(80).collect();
    let word = match quantity {
        Quantity::surface => "SUR",
        Quantity::wavefront => "WFR",
    };
    // A title of blanks or one that reads as a remark would not be a title.
    let title = if title.trim().is_empty() || title.starts_with('!') { "map" } else { title.trim() };
    let mut text = format!("{title}\nGRD {columns} {rows} {word} WVL 1.0 SSZ {scale} NDA {NO_DATA}\n");
    for row in heights.chunks_exact(columns).rev() {
        // Records of at most 80 letters.
        for line in row.chunks(10) {
            let numbers: Vec<String> = line
                .iter()
                .map(|height| if height.is_nan() { NO_DATA } else { (height * 1e6 * scale).round() as i64 })
                .map(|number| number.to_string())
                .collect();
            text.push_str(&numbers.join(" "));
            text.push('\n');
        }
    }
    Some(text.into_bytes())
}
