//! Figures that a page gives to be checked against are those of the code.

use crate::code::{BookFiles, JOB, compile};
use crate::read;
use polishc::motion::Arm;
use polishc::session::Until;
use std::path::Path;

/// The rows of the table with joint angles and flange positions: six angles in degrees, three coordinates in millimetres.
fn rows(page: &str) -> Vec<([f64; 6], [f64; 3])> {
    let table = page.split("Values to check").nth(1).expect("the table").split("\n## ").next().expect("its end");
    let numbers = |cell: &str| {
        cell.split(',').map(|n| n.trim().parse::<f64>()).collect::<Result<Vec<_>, _>>().unwrap_or_default()
    };
    let row = |line: &str| {
        let cells: Vec<Vec<f64>> = line.split('|').map(numbers).collect();
        Some((cells.get(1)?.as_slice().try_into().ok()?, cells.get(2)?.as_slice().try_into().ok()?))
    };
    table.lines().filter_map(row).collect()
}

#[test]
fn the_flange_stands_where_the_page_of_arms_says() {
    let done = compile(&BookFiles::default(), JOB, Until::Types);
    let robot = done.jobs[0].job.robot.as_ref().expect("the example's robot");
    let arm = Arm::new(robot).expect("an arm");
    let rows = rows(&read(Path::new("docs/models/arms.md")));
    assert_eq!(rows.len(), 3);
    for (joints, wanted) in rows {
        let found = arm.forward(&joints.map(f64::to_radians)).translation.vector;
        for (found, wanted) in found.iter().zip(wanted) {
            // Four decimals are written.
            assert!((found * 1e3 - wanted).abs() < 5.1e-5, "{joints:?}: {found} {wanted}");
        }
    }
}

/// `V = 0.00224 mm³/s` and the floor of 45 nm, which four pages work with.
#[test]
fn the_floor_of_the_example_is_the_one_of_the_pages() {
    let done = compile(&BookFiles::default(), JOB, Until::Dwell);
    let figures = done.jobs[0].dwell.as_ref().expect("a dwell solution").figures;
    let volume_rate = figures.floor * 0.1 * 0.5e-3;
    assert!((volume_rate * 1e9 - 0.00224).abs() < 5e-6, "{volume_rate}");
    assert!((figures.floor * 1e9 - 44.7).abs() < 0.05, "{}", figures.floor);
    for (page, words) in [
        ("docs/models/dwell.md", "V = 0.002237 mm³/s, v = 100 mm/s, p = 0.5 mm: 44.7 nm"),
        ("docs/howto/feed.md", "V = 0.00224 mm³/s, v = 100 mm/s, p = 0.5 mm: 45 nm"),
        ("docs/tutorial.md", "= 45 nm everywhere"),
    ] {
        assert!(read(Path::new(page)).contains(words), "{page} does not say `{words}`");
    }
}
