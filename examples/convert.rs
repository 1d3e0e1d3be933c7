//! Turns a height map of any readable format into MetroPro `.dat`, X3P, CODE V `.int` or `.npy`; the ending of the second
//! name says which.
//!
//!     cargo run --example convert -- [--unit 1nm] [--pixel 0.5mm] IN OUT
//!
//! `--unit` is what the value 1 means and `--pixel` the side of a pixel, where the file does not say them.
#![allow(clippy::disallowed_methods, clippy::print_stderr, reason = "an example is a program of its own")]

use polishc::height_map::{code_v, metropro, npy, read, x3p};
use polishc::job::Quantity;
use std::process::ExitCode;

fn main() -> ExitCode {
    match convert() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

fn convert() -> Result<(), String> {
    let (mut unit, mut pixel, mut names) = (None, None, Vec::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "--unit" => unit = Some(length(&words.next().unwrap_or_default())?),
            "--pixel" => pixel = Some(length(&words.next().unwrap_or_default())?),
            _ => names.push(word),
        }
    }
    let [from, to] = names.as_slice() else {
        return Err("say the map to read and the map to write: convert [--unit 1nm] [--pixel 0.5mm] IN OUT".into());
    };
    let bytes = std::fs::read(from).map_err(|why| format!("`{from}` cannot be read: {why}"))?;
    let said = |problem: polishc::diagnostics::Problem| {
        format!("{}: {}\n{}", problem.code, problem.message, problem.help.unwrap_or_default())
    };
    let map = read(&bytes, from).map_err(said)?;
    let heights = map.heights(unit).map_err(said)?;
    let written = match to.rsplit('.').next() {
        Some("dat") => {
            let [x, y] = map.pixel_pitch(pixel).map_err(said)?;
            if (x / y - 1.0).abs() > 1e-9 {
                return Err(format!("a MetroPro file has square pixels; those of `{from}` are not"));
            }
            let settings = metropro::Settings { header_format: 1, ..metropro::Settings::fizeau(x) };
            let wavelength = map.wavelength.unwrap_or(settings.wavelength);
            metropro::write(map.columns, &heights, &metropro::Settings { wavelength, ..settings })
        }
        Some("x3p") => x3p::write(map.columns, &heights, map.pixel_pitch(pixel).map_err(said)?),
        Some("int") => code_v::write(map.columns, &heights, map.quantity.unwrap_or(Quantity::surface), from),
        Some("npy") => npy::write(map.columns, &heights),
        _ => return Err(format!("`{to}` ends in none of .dat, .x3p, .int and .npy")),
    };
    let written = written.ok_or_else(|| format!("the map does not fit the format of `{to}`"))?;
    std::fs::write(to, written).map_err(|why| format!("`{to}` cannot be written: {why}"))
}

/// Metres of `0.5mm`, or of a unit alone.
fn length(text: &str) -> Result<f64, String> {
    let units = [("nm", 1e-9), ("um", 1e-6), ("mm", 1e-3), ("m", 1.0)];
    let found = units.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?.trim(), size)));
    let number = found.and_then(|(number, size)| {
        let number: f64 = if number.is_empty() { 1.0 } else { number.parse().ok()? };
        (number > 0.0 && number.is_finite()).then_some(number * size)
    });
    number.ok_or_else(|| format!("`{text}` is no length such as 0.5mm"))
}
