//! The index of errors: every code with its title, in the order of the table, and examples that cause what they explain.

use crate::blocks::blocks;
use crate::code::{BookFiles, CELL, FILE, JOB, compile, said, whole};
use crate::splice::{first_field, home_of, splice};
use crate::{between, keep, read};
use polishc::diagnostics::Code;
use polishc::session::Until;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The ranges of the table of codes, by the two digits that a code begins with.
const RANGES: &[(&str, &str)] = &[
    ("01", "Syntax"),
    ("02", "Names"),
    ("03", "Types and dimensions"),
    ("04", "Fields, ranges, values"),
    ("05", "Files and metrology"),
    ("06", "Workpiece, tool, path"),
    ("07", "Dwell"),
    ("08", "Motion"),
    ("09", "Target"),
    ("10", "Verify"),
    ("11", "Requirements"),
    ("12", "Command line"),
    ("13", "Simulate"),
];

#[test]
fn the_index_lists_every_code() {
    let mut index = String::new();
    let mut summary = String::new();
    let mut listed = 0;
    for (digits, title) in RANGES {
        index.push_str(&format!("\n## {title}\n\n| code | what it says |\n| --- | --- |\n"));
        let of_range = |letter: char| {
            let start = format!("{letter}{digits}");
            Code::all().filter(move |code| code.as_str().starts_with(&start))
        };
        for code in of_range('E').chain(of_range('W')) {
            index.push_str(&format!("| [{code}]({code}.md) | {} |\n", code.title()));
            summary.push_str(&format!("  - [{code}: {}](errors/{code}.md)\n", code.title()));
            listed += 1;
        }
    }
    assert_eq!(listed, Code::all().count(), "a code belongs to none of the ranges");
    let path = Path::new("docs/errors/README.md");
    let start = "<!-- made from the table of codes -->\n";
    keep(path, &between(&read(path), start, "<!-- end -->", &format!("{index}\n")), "the index of errors");
    let path = Path::new("docs/SUMMARY.md");
    let start = "- [Index of errors](errors/README.md)\n";
    keep(path, &between(&read(path), start, "\n#", &summary), "the list of errors");
}

/// Pages whose example alone does not cause the code.
const NEEDS_MORE: &[&str] = &[
    // A value that another file does not let out; a file that uses itself; a job in a file that is used.
    "E0207", "E0209", "E0213",
    // The schema's own limits speak first; the code guards jobs that a program makes through the library.
    "E0600", "E0620", // They speak of what is not there, or of a map.
    "W0704", "E0904", "E1102", "E1103", // The part stands so that the arm passes its singular position.
    "E0810",
];

/// How far an excerpt must be compiled to say a code.
fn until(code: Code) -> Until {
    match &code.as_str()[1..3] {
        "01" | "02" | "03" | "04" => Until::Types,
        _ => Until::Program,
    }
}

#[test]
fn examples_of_the_index_cause_what_they_explain() {
    let mut silent = Vec::new();
    for code in Code::all().filter(|code| !NEEDS_MORE.contains(&code.as_str())) {
        let blocks = blocks(code.page());
        // `…` stands for what an excerpt leaves out; the files of `tests/ui` show those codes.
        let examples = || blocks.iter().filter(|block| block.language == "polish" && !block.text.contains('…'));
        let far = until(code) == Until::Program;
        let said_by = |(files, path): (BookFiles, String)| said(&compile(&files, &path, until(code)));
        let causes = |text: &str| ways(text, far).into_iter().any(|way| said_by(way).contains(code.as_str()));
        if examples().next().is_some() && !examples().any(|block| causes(&block.text)) {
            let found: BTreeSet<&str> = examples().flat_map(|block| ways(&block.text, far)).flat_map(said_by).collect();
            silent.push(format!("{code}: its example causes {found:?}"));
        }
    }
    assert!(silent.is_empty(), "{}", silent.join("\n"));
}

/// The ways to read an excerpt: as a file, as a value, as entries where the example has the first of them; what only shows
/// in a plan stands in the example in any case.
fn ways(text: &str, in_a_plan: bool) -> Vec<(BookFiles, String)> {
    let file = |path: &str, text: String| (BookFiles(BTreeMap::from([(path.to_string(), text)])), path.to_string());
    let value = |before: &str, after: &str| {
        file(FILE, whole(&format!("use std.controllers.irc5\nlet book = {before}{text}{after}\n")))
    };
    let mut ways = Vec::new();
    if !in_a_plan {
        ways = vec![file(FILE, whole(text)), file(FILE, text.into()), value("", ""), value("irc5 with { ", " }")];
    }
    let job = read(Path::new(JOB));
    for path in [JOB, CELL] {
        let whole = read(Path::new(path));
        let place = first_field(text).and_then(|name| home_of(&whole, &name));
        for place in place.into_iter().chain((!in_a_plan).then(String::new)) {
            if let Ok(spliced) = splice(&whole, &place, text) {
                ways.push((BookFiles(BTreeMap::from([(path.to_string(), spliced)])), JOB.to_string()));
            }
        }
    }
    // Fields that the example leaves at the robot's own.
    let robot = format!("robot: irb6700_200_260 with {{ cell: cell.mrf\n{text} }}");
    ways.extend(splice(&job, "", &robot).map(|text| file(JOB, text)));
    ways
}
