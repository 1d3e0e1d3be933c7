//! Refusals: what readers say of a file that they do not read, one function a code. Each names the file first; `what`
//! goes on the sentence. Fields are `file`.

use crate::diagnostics::{Code, Problem, codes};

fn refusal(code: Code, name: &str, what: impl AsRef<str>, help: impl Into<String>) -> Problem {
    Problem::error(code, "file", format!("`{name}` {}", what.as_ref())).help(help)
}

/// E0503: sizes do not fit the file.
pub(super) fn sizes(name: &str, what: impl AsRef<str>) -> Problem {
    refusal(codes::E0503, name, what, "copy or export the map from the instrument again")
}

/// E0504: a header says what cannot be.
pub(super) fn impossible(name: &str, what: impl AsRef<str>) -> Problem {
    refusal(codes::E0504, name, what, "export the map from the instrument again")
}

/// The value, if it lies within what can be. E0504 names it by `what` if not, NaN among them.
pub(super) fn within(name: &str, what: &str, value: f64, (from, to): (f64, f64)) -> Result<f64, Problem> {
    if value >= from && value <= to {
        return Ok(value);
    }
    Err(impossible(name, format!("says that its {what} is {value:e}, which is not within {from:e} .. {to:e}")))
}

/// E0505: an array that is no picture of real numbers.
pub(super) fn no_map(name: &str, what: impl AsRef<str>) -> Problem {
    refusal(codes::E0505, name, what, "save the heights alone as a two-dimensional array of floats")
}

/// E0513: a part of the format that is not read.
pub(super) fn unread(name: &str, what: impl AsRef<str>, help: impl Into<String>) -> Problem {
    refusal(codes::E0513, name, what, help)
}

/// E0514: a unit that nobody knows. `of` is what is measured in it.
pub(super) fn unknown_unit(name: &str, of: &str, unit: &str) -> Problem {
    // A hostile file may call a unit by a megabyte of text.
    let unit: String = unit.chars().filter(|c| !c.is_control()).take(40).collect();
    refusal(
        codes::E0514,
        name,
        format!("says that its {of} are in `{unit}`, a unit that is not known"),
        "export it in metres, millimetres, micrometres or nanometres",
    )
}

/// E0515: a text that does not read as the map it seems to be.
pub(super) fn unreadable(name: &str, what: impl AsRef<str>) -> Problem {
    refusal(codes::E0515, name, what, "export the map again, as numbers alone under a header that names their units")
}

/// E0516: points that lie on no grid.
pub(super) fn no_grid(name: &str, what: impl AsRef<str>) -> Problem {
    refusal(codes::E0516, name, what, "export the map on a regular grid of x and y, or as a matrix of heights")
}

/// E0517: a checksum that does not agree.
pub(super) fn checksum(name: &str, what: impl AsRef<str>) -> Problem {
    refusal(codes::E0517, name, what, "copy the file again; do not edit the parts of an archive by hand")
}

/// E0518: a container that is damaged, or made to trap its reader.
pub(super) fn container(name: &str, what: impl AsRef<str>) -> Problem {
    refusal(codes::E0518, name, what, "copy or export the map from the instrument again")
}

/// E0519: a profile where a map is wanted.
pub(super) fn profile(name: &str, points: usize) -> Problem {
    refusal(
        codes::E0519,
        name,
        format!("is a line profile of {points} points, not a map"),
        "measure an area; one line says nothing of the surface beside it",
    )
}
