//! Mistakes that people made, in this language's words: those that users of numbat, KCL and OpenSCAD reported, and their
//! like. Each is one diagnostic at its place, and where the mend is mechanical, the mend applied compiles.
//!
//! Every mistake is an edit of one job. `whose` says where it was met; a number is the issue of that project.
#![allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]

use polishc::diagnostics::Diagnostic;
use polishc::eval::{self, Compiled, Options};
use polishc::source::MemoryFiles;

struct Mistake {
    whose: &'static str,
    /// What of the right job is replaced, by what.
    right: &'static str,
    wrong: &'static str,
    code: &'static str,
    /// The text at the primary place.
    place: &'static str,
    /// What the edit becomes when the suggestions are applied; empty where nothing mechanical mends it.
    mended: &'static str,
    /// Words that the help or a note must hold.
    says: &'static str,
}

const fn mistake(
    whose: &'static str,
    edit: (&'static str, &'static str),
    code: &'static str,
    place: &'static str,
    mended: &'static str,
    says: &'static str,
) -> Mistake {
    Mistake { whose, right: edit.0, wrong: edit.1, code, place, mended, says }
}

const MISTAKES: &[Mistake] = &[
    // ---- numbers and units
    mistake(
        "KCL 11013: a number without a unit",
        ("gap:      0.8 mm", "gap:      0.8"),
        "E0302",
        "0.8",
        "gap:      0.8 mm",
        "units that fit",
    ),
    mistake("angle as a plain number", ("azimuth:  0 deg", "azimuth:  45"), "E0302", "45", "azimuth:  45 deg", "`deg`"),
    mistake("Calcpad 561: Hz for rpm", ("200 rpm", "200 Hz"), "E0303", "200 Hz", "", "`rpm`"),
    mistake("mm/min written for um/min", ("peak: 20 nm/s", "peak: 20 mm/min"), "W0401", "20 mm/min", "", "`20 um/min`"),
    mistake(
        "90 for 90 %",
        ("removal_fraction: 90 %", "removal_fraction: 90"),
        "E0404",
        "90",
        "removal_fraction: 90 %",
        "90 %",
    ),
    mistake(
        "OpenSCAD: decimal comma",
        ("gap:      0.8 mm", "gap:      0,8 mm"),
        "E0112",
        "0,8",
        "gap:      0.8 mm",
        "decimal point",
    ),
    mistake(
        "thousands by commas",
        ("over:       circle { diameter: 62 mm }", "over:       circle { diameter: 62,000,000 nm }"),
        "E0112",
        "62,000,000",
        "over:       circle { diameter: 62000000 nm }",
        "thousands",
    ),
    mistake(
        "1. without a digit after it",
        ("point_step: 1 mm", "point_step: 1. mm"),
        "E0112",
        "1.",
        "point_step: 1.0 mm",
        "both sides",
    ),
    mistake(
        ".5 without a digit before it",
        ("line_pitch: 0.25 mm", "line_pitch: .25 mm"),
        "E0112",
        ".25",
        "line_pitch: 0.25 mm",
        "both sides",
    ),
    mistake("numbat: mm/s2", ("200 mm/s^2", "200 mm/s2"), "E0210", "s2", "200 mm/s^2", "s^2"),
    mistake("numbat: mm/s²", ("200 mm/s^2", "200 mm/s²"), "E0101", "²", "200 mm/s^2", "^2"),
    mistake("two slashes in a unit", ("200 mm/s^2", "200 mm/s/s"), "E0113", "200 mm/s/s", "200 mm*s^-1*s^-1", "write"),
    mistake("blanks in a unit", ("peak: 20 nm/s", "peak: 20 nm / s"), "E0201", "s", "peak: 20 nm/s", "20 nm/s"),
    mistake(
        "a unit spelt out",
        ("gap:      0.8 mm", "gap:      0.8 millimeters"),
        "E0210",
        "millimeters",
        "gap:      0.8 mm",
        "`mm`",
    ),
    mistake(
        "a unit spelt out, British",
        ("line_pitch: 0.25 mm", "line_pitch: 250 micrometres"),
        "E0210",
        "micrometres",
        "line_pitch: 250 um",
        "`um`",
    ),
    mistake(
        "degrees spelt out",
        ("azimuth:  0 deg", "azimuth:  0 degrees"),
        "E0210",
        "degrees",
        "azimuth:  0 deg",
        "`deg`",
    ),
    mistake("the degree sign", ("azimuth:  0 deg", "azimuth:  45°"), "E0101", "°", "azimuth:  45 deg", "`deg`"),
    mistake("a unit in capitals", ("200 rpm", "200 RPM"), "E0210", "RPM", "200 rpm", "`rpm`"),
    mistake("a unit in capitals", ("gap:      0.8 mm", "gap:      0.8 MM"), "E0210", "MM", "gap:      0.8 mm", "`mm`"),
    mistake(
        "KCL 7705: a unit after a bracket",
        ("gap:      0.8 mm", "gap:      (0.5 + 0.3) mm"),
        "E0107",
        "mm",
        "gap:      (0.5 + 0.3) * 1 mm",
        "number right before it",
    ),
    mistake(
        "two quantities without an operator",
        ("gap:      0.8 mm", "gap:      0.5 mm 0.3 mm"),
        "E0107",
        "0.3",
        "",
        "an entry ends",
    ),
    mistake("OpenSCAD: per", ("peak: 20 nm/s", "peak: 20 nm per s"), "E0107", "per", "", "an entry ends"),
    mistake(
        "a quantity in quotes",
        ("gap:      0.8 mm", "gap:      \"0.8 mm\""),
        "E0301",
        "\"0.8 mm\"",
        "gap:      0.8 mm",
        "0.8 mm",
    ),
    mistake(
        "numbat: a power without brackets",
        ("fill_below: 8 mm^2", "fill_below: 3 mm ^ 2"),
        "E0114",
        "^",
        "fill_below: (3 mm) ^ 2",
        "`(3 mm)`",
    ),
    mistake(
        "numbat 766: a length where an area belongs",
        ("fill_below: 8 mm^2", "fill_below: 8 mm"),
        "E0303",
        "8 mm",
        "",
        "`mm^2`",
    ),
    mistake(
        "numbat: a fraction before a unit",
        ("<= 15 nm", "<= 1/40 wave"),
        "E0113",
        "1/40 wave",
        "<= 1 wave / 40",
        "`1 / (40 wave)`",
    ),
    mistake(
        "a reciprocal length",
        ("job real_map {", "let density = 3/mm\njob real_map {"),
        "E0113",
        "3/mm",
        "let density = 3 mm^-1\njob real_map {",
        "`3 mm^-1`",
    ),
    mistake(
        "rpm times a radius as a speed",
        ("peak: 20 nm/s", "peak: 0.01 rpm * 1 um"),
        "E0303",
        "0.01 rpm * 1 um",
        "peak: tangential(0.01 rpm, 1 um)",
        "an angle does not cancel",
    ),
    mistake("a temperature", ("job real_map {", "let warm = 20 °C\njob real_map {"), "E0101", "°C", "", "`20 K`"),
    mistake("a tolerance by ±", ("gap:      0.8 mm", "gap:      0.8 mm ± 0.1 mm"), "E0101", "±", "", "both ends"),
    mistake("the wavelength as a name", ("<= 15 nm", "<= wavelength / 40"), "E0201", "wavelength", "", "`1 wave / 20`"),
    mistake("lambda as a unit", ("<= 15 nm", "<= 0.02 lambda"), "E0210", "lambda", "<= 0.02 wave", "`wave`"),
    // ---- ranges and lists
    mistake(
        "a range upside down",
        ("0.2 mm/s .. 20 mm/s", "20 mm/s .. 0.2 mm/s"),
        "E0409",
        "20 mm/s .. 0.2 mm/s",
        "0.2 mm/s .. 20 mm/s",
        "0.2 mm/s .. 20 mm/s",
    ),
    mistake(
        "a range by `to`",
        ("0.2 mm/s .. 20 mm/s", "0.2 mm/s to 20 mm/s"),
        "E0107",
        "to",
        "0.2 mm/s .. 20 mm/s",
        "`..`",
    ),
    mistake(
        "a range by `-`",
        ("0.2 mm/s .. 20 mm/s", "0.2 mm/s - 20 mm/s"),
        "E0301",
        "0.2 mm/s - 20 mm/s",
        "0.2 mm/s .. 20 mm/s",
        "`..`",
    ),
    mistake(
        "a range by three dots",
        ("0.2 mm/s .. 20 mm/s", "0.2 mm/s ... 20 mm/s"),
        "E0101",
        "...",
        "0.2 mm/s .. 20 mm/s",
        "`..`",
    ),
    mistake(
        "OpenSCAD: a range as a list",
        ("0.2 mm/s .. 20 mm/s", "[0.2 mm/s, 20 mm/s]"),
        "E0301",
        "[0.2 mm/s, 20 mm/s]",
        "0.2 mm/s .. 20 mm/s",
        "0.2 mm/s .. 20 mm/s",
    ),
    mistake(
        "one end of a range without its unit",
        ("0.2 mm/s .. 20 mm/s", "0.2 .. 20 mm/s"),
        "E0302",
        "0.2",
        "0.2 mm/s .. 20 mm/s",
        "units that fit",
    ),
    mistake("one value for a range", ("0.2 mm/s .. 20 mm/s", "20 mm/s"), "E0301", "20 mm/s", "", "both ends"),
    mistake(
        "a word for a list",
        ("subtract:   [piston, tilt]", "subtract:   piston"),
        "E0301",
        "piston",
        "subtract:   [piston]",
        "`[ ]`",
    ),
    mistake(
        "a list with a comma too many",
        ("[piston, tilt]", "[piston,, tilt]"),
        "E0111",
        ",",
        "[piston, tilt]",
        "delete",
    ),
    mistake(
        "a word twice in a list",
        ("[piston, tilt]", "[piston, tilt, tilt]"),
        "E0416",
        "tilt",
        "[piston, tilt]",
        "keep one",
    ),
    mistake("KCL 4871: a missing bracket", ("[piston, tilt]", "[piston, tilt"), "E0102", "[", "", "`]`"),
    // ---- names
    mistake(
        "numbat 95: a misspelt field",
        ("line_pitch:", "line_ptich:"),
        "E0401",
        "line_ptich",
        "line_pitch:",
        "`line_pitch`",
    ),
    mistake("camel case", ("line_pitch:", "linePitch:"), "E0401", "linePitch", "line_pitch:", "`line_pitch`"),
    mistake("kebab case", ("line_pitch:", "line-pitch:"), "E0107", "line-pitch", "line_pitch:", "subtracts"),
    mistake("a blank in a name", ("line_pitch:", "line pitch:"), "E0107", "line pitch", "line_pitch:", "comma"),
    mistake("a wrong capital", ("serpentine", "Serpentine"), "E0309", "Serpentine", "serpentine", "`serpentine`"),
    mistake(
        "a wrong capital in a kind",
        ("path: raster {", "path: Raster {"),
        "E0202",
        "Raster",
        "path: raster {",
        "`raster`",
    ),
    mistake(
        "a word in quotes",
        ("serpentine", "\"serpentine\""),
        "E0301",
        "\"serpentine\"",
        "serpentine",
        "`serpentine`",
    ),
    mistake(
        "American spelling",
        ("circle { diameter: 62 mm }", "circle { diameter: 62 mm, center: { x: 0 mm, y: 0 mm } }"),
        "E0401",
        "center",
        "circle { diameter: 62 mm, centre: { x: 0 mm, y: 0 mm } }",
        "`centre`",
    ),
    mistake(
        "KCL 7285: a name of another file",
        ("cell: cell.mrf", "cell: mrf"),
        "E0201",
        "mrf",
        "cell: cell.mrf",
        "`cell.mrf`",
    ),
    mistake(
        "a name of stdlib without its use",
        ("material: fused_silica", "material: zerodur_glass"),
        "E0201",
        "zerodur_glass",
        "",
        "",
    ),
    mistake(
        "a field as a value",
        ("line_pitch: 0.25 mm", "line_pitch: point_step / 4"),
        "E0201",
        "point_step",
        "",
        "a field is no value",
    ),
    mistake(
        "a result without `result.`",
        ("result.predicted.rms ", "predicted.rms "),
        "E0201",
        "predicted",
        "result.predicted.rms ",
        "`result.predicted`",
    ),
    mistake(
        "a misspelt result",
        ("result.predicted.rms ", "result.predicted.rsm "),
        "E0217",
        "rsm",
        "result.predicted.rms ",
        "`rms`",
    ),
    mistake(
        "KCL: fields of another kind",
        ("edge:     circle { diameter: 50 mm }", "edge:     circle { outer_diameter: 50 mm, inner_diameter: 4 mm }"),
        "E0401",
        "circle",
        "edge:     annulus { outer_diameter: 50 mm, inner_diameter: 4 mm }",
        "`annulus`",
    ),
    mistake("a field left out", ("        gap:      0.8 mm\n", ""), "E0402", "mrf_wheel", "", "gap: Length"),
    mistake("a kind left out", ("path: raster {", "path: {"), "E0410", "{", "", "`raster"),
    // ---- text and files
    mistake(
        "a text without quotes",
        ("part:     \"FS50-01\"", "part:     FS50-01"),
        "E0301",
        "FS50-01",
        "part:     \"FS50-01\"",
        "\"FS50-01\"",
    ),
    mistake(
        "a file without quotes",
        ("file:       map", "file:       metrology/part.dat"),
        "E0301",
        "metrology/part.dat",
        "file:       \"metrology/part.dat\"",
        "\"metrology/part.dat\"",
    ),
    mistake(
        "a number for a text",
        ("part:     \"FS50-01\"", "part:     5001"),
        "E0301",
        "5001",
        "part:     \"5001\"",
        "\"5001\"",
    ),
    mistake("single quotes", ("\"RealMap\"", "'RealMap'"), "E0101", "'", "\"RealMap\"", "straight double quotes"),
    mistake(
        "quotes of a word processor",
        ("\"RealMap\"", "“RealMap”"),
        "E0101",
        "“",
        "\"RealMap\"",
        "straight double quotes",
    ),
    mistake("an unclosed text", ("\"FS50-01\"", "\"FS50-01"), "E0104", "\"FS50-01", "\"FS50-01\"", "close it"),
    mistake(
        "a path with backslashes",
        ("file:       map", "file:       \"maps\\part.dat\""),
        "E0116",
        "\\p",
        "file:       \"maps\\\\part.dat\"",
        "paths are written with `/`",
    ),
    // ---- signs of other languages
    mistake("numbat: `=` for `:`", ("gap:      0.8 mm", "gap =     0.8 mm"), "E0121", "=", "gap:     0.8 mm", "`:`"),
    mistake("`:=` for `:`", ("gap:      0.8 mm", "gap := 0.8 mm"), "E0101", ":=", "gap : 0.8 mm", "`:`"),
    mistake(
        "OpenSCAD: a semicolon",
        ("gap:      0.8 mm", "gap:      0.8 mm;"),
        "E0107",
        ";",
        "gap:      0.8 mm",
        "delete",
    ),
    mistake("no colon", ("gap:      0.8 mm", "gap       0.8 mm"), "E0121", "gap", "gap:       0.8 mm", "`name: value`"),
    mistake(
        "no comma",
        ("view:       from_tool_side\n            up:         plus_y", "view:       from_tool_side up: plus_y"),
        "E0119",
        "up",
        "view:       from_tool_side, up: plus_y",
        "commas",
    ),
    mistake(
        "KCL 8159's other side: a comment by `#`",
        ("gap:      0.8 mm", "gap:      0.8 mm  # by the gauge"),
        "E0101",
        "#",
        "gap:      0.8 mm  // by the gauge",
        "`//`",
    ),
    mistake(
        "`&&`",
        ("<= 15 nm", "<= 15 nm && result.predicted.pv <= 90 nm"),
        "E0101",
        "&&",
        "<= 15 nm and result.predicted.pv <= 90 nm",
        "`and`",
    ),
    mistake(
        "`||`",
        ("<= 15 nm", "<= 15 nm||result.predicted.pv <= 90 nm"),
        "E0101",
        "||",
        "<= 15 nm or result.predicted.pv <= 90 nm",
        "`or`",
    ),
    mistake(
        "`!`",
        ("result.predicted.rms       <= 15 nm", "!(result.predicted.rms > 15 nm)"),
        "E0101",
        "!",
        "not (result.predicted.rms > 15 nm)",
        "`not`",
    ),
    mistake("`**`", ("fill_below: 8 mm^2", "fill_below: (3 mm)**2"), "E0101", "**", "fill_below: (3 mm)^2", "`^`"),
    mistake("`=<`", ("<= 15 nm", "=< 15 nm"), "E0101", "=<", "<= 15 nm", "`<=`"),
    mistake(
        "`=` for a comparison",
        ("result.predicted.rms       <= 15 nm", "result.predicted.rms = 15 nm"),
        "E0107",
        "=",
        "",
        "an entry ends",
    ),
    mistake(
        "comparisons in a chain",
        ("result.predicted.rms       <= 15 nm", "1 nm <= result.predicted.rms <= 15 nm"),
        "E0120",
        "<=",
        "",
        "`and`",
    ),
    mistake(
        "an angle sign for minus",
        ("azimuth:  0 deg", "azimuth:  −5 deg"),
        "E0101",
        "−",
        "azimuth:  -5 deg",
        "`-`",
    ),
    mistake(
        "true for on",
        ("lines:      serpentine", "lines:      serpentine\n        holes:      cross { process: true }"),
        "E0301",
        "true",
        "lines:      serpentine\n        holes:      cross { process: on }",
        "`on`",
    ),
    mistake(
        "OpenSCAD: a call for a record",
        ("circle { diameter: 62 mm }", "circle(diameter: 62 mm)"),
        "E0107",
        "(",
        "circle { diameter: 62 mm }",
        "`{ }`",
    ),
    mistake(
        "OpenSCAD: a call with `=`",
        ("circle { diameter: 62 mm }", "circle(diameter = 62 mm)"),
        "E0107",
        "(",
        "circle { diameter: 62 mm }",
        "`{ }`",
    ),
    mistake(
        "OpenSCAD: a call by position",
        ("circle { diameter: 62 mm }", "circle(62 mm)"),
        "E0201",
        "circle",
        "circle { diameter: 62 mm }",
        "is a record",
    ),
    mistake(
        "C#: a brace on the next line",
        ("path: raster {", "path: raster\n    {"),
        "E0118",
        "{",
        "path: raster {",
        "on one line",
    ),
    mistake("a field without its value", ("gap:      0.8 mm", "gap:"), "E0106", ":", "", "write a value"),
    mistake(
        "KCL 6126: a stray brace",
        ("gap:      0.8 mm", "gap:      0.8 mm }"),
        "E0103",
        "}",
        "gap:      0.8 mm ",
        "delete",
    ),
    mistake(
        "KCL 4871: a missing brace far away",
        ("diameter: 6 mm }\n    }", "diameter: 6 mm }"),
        "E0102",
        "{",
        "",
        "`}`",
    ),
    mistake(
        "a field twice",
        ("gap:      0.8 mm", "gap:      0.8 mm\n        gap:      0.9 mm"),
        "E0403",
        "gap",
        "",
        "keep one",
    ),
    // ---- items
    mistake(
        "Rust: a module by `::`",
        ("use std.materials.fused_silica", "use std::materials::fused_silica"),
        "E0107",
        "std::materials::fused_silica",
        "use std.materials.fused_silica",
        "dots",
    ),
    mistake(
        "a module by slashes",
        ("use std.materials.fused_silica", "use std/materials/fused_silica"),
        "E0107",
        "std/materials/fused_silica",
        "use std.materials.fused_silica",
        "dots",
    ),
    mistake(
        "a module's last word alone",
        ("use std.materials.fused_silica", "use fused_silica"),
        "E0203",
        "fused_silica",
        "use std.materials.fused_silica",
        "`std.materials.fused_silica`",
    ),
    mistake(
        "import for use",
        ("use std.materials.fused_silica", "import std.materials.fused_silica"),
        "E0123",
        "import",
        "use std.materials.fused_silica",
        "`use`",
    ),
    mistake(
        "a file without its ending",
        ("use \"cell.polish\"", "use \"cell\""),
        "E0204",
        "\"cell\"",
        "use \"cell.polish\"",
        "\"cell.polish\"",
    ),
    mistake(
        "a file without its quotes",
        ("use \"cell.polish\"", "use cell.polish"),
        "E0203",
        "cell.polish",
        "use \"cell.polish\"",
        "in quotes",
    ),
    mistake(
        "a file that is not there",
        ("use \"cell.polish\"", "use \"cells.polish\""),
        "E0204",
        "\"cells.polish\"",
        "",
        "looked for beside",
    ),
    mistake(
        "OpenSCAD: a semicolon after a value",
        ("job real_map {", "let margin = 3 mm;\njob real_map {"),
        "E0107",
        ";",
        "let margin = 3 mm\njob real_map {",
        "delete",
    ),
    mistake(
        "a value without let",
        ("job real_map {", "margin = 3 mm\njob real_map {"),
        "E0123",
        "margin",
        "let margin = 3 mm\njob real_map {",
        "`let margin",
    ),
    mistake(
        "const for let",
        ("job real_map {", "const margin = 3 mm\njob real_map {"),
        "E0123",
        "const",
        "let margin = 3 mm\njob real_map {",
        "`let`",
    ),
    mistake(
        "a colon in let",
        ("job real_map {", "let margin: 3 mm\njob real_map {"),
        "E0107",
        ":",
        "let margin = 3 mm\njob real_map {",
        "`=`",
    ),
    mistake(
        "Rust: f64 for Number",
        ("job real_map {", "let share: f64 = 0.3\njob real_map {"),
        "E0202",
        "f64",
        "let share: Number = 0.3\njob real_map {",
        "`Number`",
    ),
    mistake(
        "a unit for a type",
        ("job real_map {", "let margin: mm = 3 mm\njob real_map {"),
        "E0202",
        "mm",
        "let margin: Length = 3 mm\njob real_map {",
        "`Length`",
    ),
    mistake(
        "a type in small letters",
        ("job real_map {", "let margin: length = 3 mm\njob real_map {"),
        "E0202",
        "length",
        "let margin: Length = 3 mm\njob real_map {",
        "`Length`",
    ),
    mistake(
        "a parameter without a type",
        ("job real_map {", "param margin = 3 mm\njob real_map {"),
        "E0107",
        "margin",
        "",
        "`param margin: Length",
    ),
    mistake(
        "a hyphen in a job's name",
        ("job real_map {", "job real-map {"),
        "E0107",
        "real-map",
        "job real_map {",
        "`real_map`",
    ),
    mistake("a misspelt job", ("job real_map {", "jobb real_map {"), "E0123", "jobb", "", "items begin with"),
    mistake(
        "a program for a job",
        ("job real_map {", "program real_map {"),
        "E0123",
        "program",
        "job real_map {",
        "`job`",
    ),
    mistake("a job without a name", ("job real_map {", "job {"), "E0122", "job", "", "its_name"),
    mistake(
        "sin of a plain number",
        ("job real_map {", "let share = sin(30)\njob real_map {"),
        "E0302",
        "30",
        "let share = sin(30 deg)\njob real_map {",
        "`deg`",
    ),
    mistake(
        "numbat: a list of two dimensions",
        ("job real_map {", "let both = [1 mm, 2 s]\njob real_map {"),
        "E0303",
        "2 s",
        "",
        "units that fit",
    ),
    mistake(
        "numbat: a length and a time",
        ("job real_map {", "let sum = 1 mm + 2 s\njob real_map {"),
        "E0304",
        "+",
        "",
        "Length",
    ),
    mistake(
        "KCL 12657: a ratio is a plain number",
        ("job real_map {", "let half: Length = 3 mm / 2 mm\njob real_map {"),
        "E0302",
        "3 mm / 2 mm",
        "",
        "multiply by a",
    ),
    mistake(
        "a list of plain numbers",
        ("job real_map {", "let home: [Angle; 3] = [0, -20, 30]\njob real_map {"),
        "E0302",
        "[0, -20, 30]",
        "let home: [Angle; 3] = [0, -20, 30] deg\njob real_map {",
        "belongs to each",
    ),
    mistake(
        "a unit as a power of a name",
        ("job real_map {", "let x = 2^3^4\njob real_map {"),
        "E0120",
        "^",
        "",
        "parentheses",
    ),
    mistake(
        "an unknown function",
        ("job real_map {", "let x = squareroot(4 mm^2)\njob real_map {"),
        "E0201",
        "squareroot",
        "",
        "",
    ),
    mistake(
        "an invisible character",
        ("gap:      0.8 mm", "gap:      0.8\u{200b} mm"),
        "E0101",
        "\u{200b}",
        "gap:      0.8 mm",
        "delete",
    ),
];

/// Writings that people try and that are right.
const RIGHT: &[(&str, (&str, &str))] = &[
    ("KCL 8159: a comment after the colon", ("gap:      0.8 mm", "gap: // by the gauge\n            0.8 mm")),
    ("a comment in the middle", ("gap:      0.8 mm", "gap: /* by the gauge */ 0.8 mm")),
    ("no blank before a unit", ("gap:      0.8 mm", "gap:      0.8mm")),
    ("no blanks around `..`", ("0.2 mm/s .. 20 mm/s", "0.2mm/s..20mm/s")),
    ("the micro sign", ("line_pitch: 0.25 mm", "line_pitch: 250 µm")),
    ("the Greek letter", ("line_pitch: 0.25 mm", "line_pitch: 250 μm")),
    ("KCL 11474: areas have units", ("fill_below: 8 mm^2", "fill_below: 0.08 cm^2")),
    ("a trailing comma", ("[piston, tilt]", "[piston, tilt,]")),
    ("lines of Windows", ("gap:      0.8 mm\n", "gap:      0.8 mm\r\n")),
    ("a blank that is none of ASCII", ("gap:      0.8 mm", "gap:      0.8\u{a0}mm")),
    ("a record without the name of its field's schema", ("    workpiece {", "    workpiece: {")),
];

fn files(text: &str) -> MemoryFiles {
    let cell = include_str!("jobs/cell.polish");
    let files = [("job.polish", text), ("cell.polish", cell)];
    MemoryFiles(files.iter().map(|(name, text)| (name.to_string(), text.as_bytes().to_vec())).collect())
}

fn compile(text: &str) -> Compiled {
    eval::compile(&files(text), "job.polish", &Options::default())
}

/// The job of `tests/jobs`, with a map of its own.
fn base() -> String {
    include_str!("jobs/real_map.polish").replace("param map: File", "param map: File = \"map.dat\"")
}

fn edited(right: &str, wrong: &str) -> String {
    let base = base();
    assert_eq!(base.matches(right).count(), 1, "`{right}` stands once in the job");
    base.replace(right, wrong)
}

fn shown(compiled: &Compiled) -> Vec<String> {
    let one = |d: &Diagnostic| {
        let place = d.primary.as_ref().map_or("nowhere", |label| compiled.sources.slice(label.span));
        let mends: Vec<&str> = d.suggestions.iter().map(|mend| mend.replacement.as_str()).collect();
        format!("{} at `{place}`: {} | {:?} | help {:?} | mend {mends:?}", d.code, d.message, d.notes, d.help)
    };
    compiled.diagnostics.iter().map(one).collect()
}

/// The text with a diagnostic's suggestions applied, from the last to the first.
fn mended(text: &str, diagnostic: &Diagnostic) -> String {
    let mut text = text.to_string();
    let mut mends = diagnostic.suggestions.clone();
    mends.sort_by_key(|mend| std::cmp::Reverse(mend.span.start));
    for mend in mends {
        text.replace_range(mend.span.start as usize..mend.span.end as usize, &mend.replacement);
    }
    text
}

#[test]
fn the_job_is_right_and_so_are_writings_that_people_try() {
    let compiled = compile(&base());
    assert_eq!(shown(&compiled), Vec::<String>::new());
    for (whose, (right, other)) in RIGHT {
        let compiled = compile(&edited(right, other));
        assert_eq!(shown(&compiled), Vec::<String>::new(), "{whose}");
    }
}

#[test]
fn every_mistake_is_one_diagnostic_at_its_place_with_its_mend() {
    let mut wrong = Vec::new();
    for m in MISTAKES {
        let text = edited(m.right, m.wrong);
        let compiled = compile(&text);
        let mut complain = |what: &str| {
            wrong.push(format!("{}: {what}: `{}`\n    {}", m.whose, m.wrong, shown(&compiled).join("\n    ")));
        };
        let [one] = compiled.diagnostics.as_slice() else {
            complain("not one diagnostic");
            continue;
        };
        if one.code.as_str() != m.code {
            complain(&format!("not {}", m.code));
            continue;
        }
        let place = one.primary.as_ref().map_or("", |label| compiled.sources.slice(label.span));
        if place != m.place {
            complain(&format!("not at `{}`", m.place));
        }
        let words: Vec<&str> = one.notes.iter().chain(&one.help).map(String::as_str).collect();
        if !words.iter().any(|words| words.contains(m.says)) && !m.says.is_empty() {
            complain(&format!("does not say `{}`", m.says));
        }
        if m.mended.is_empty() {
            if !one.suggestions.is_empty() {
                complain("has a mend that the table does not know");
            }
            continue;
        }
        let after = mended(&text, one);
        if after != edited(m.right, m.mended) {
            let line = after.lines().zip(text.lines()).find(|(a, b)| a != b).map_or("", |(a, _)| a);
            complain(&format!("mended to `{line}`, not to `{}`", m.mended));
            continue;
        }
        let again = compile(&after);
        if !again.diagnostics.is_empty() {
            complain(&format!("the mend leaves {:?}", shown(&again)));
        }
    }
    assert!(wrong.is_empty(), "{} of {} mistakes:\n{}", wrong.len(), MISTAKES.len(), wrong.join("\n"));
    println!(
        "{} mistakes, {} of them with a mend",
        MISTAKES.len(),
        MISTAKES.iter().filter(|m| !m.mended.is_empty()).count()
    );
    assert!(MISTAKES.len() >= 60);
}

#[test]
fn three_mistakes_are_three_diagnostics_in_order_of_place() {
    // numbat 228: errors came one by one.
    let text = edited("gap:      0.8 mm", "gap:      0.8")
        .replace("lines:      serpentine", "lines:      serpentin")
        .replace("0.2 mm/s .. 20 mm/s", "20 mm/s .. 0.2 mm/s");
    let codes: Vec<&str> = compile(&text).diagnostics.iter().map(|d| d.code.as_str()).collect();
    // The range is evaluated although the names before it are wrong.
    assert_eq!(codes, ["E0302", "E0309", "E0409"]);
}
