//! The drawing of the eight ways in which a picture can lie on the part is made by the code that lays it there.

use crate::{between, keep, read};
use polishc::height_map::{Picture, lay};
use polishc::job::Direction;
use std::path::Path;

/// Pixels of the drawn picture, both ways; its middle is the part's origin.
const SIDE: usize = 5;

/// Where each pixel of the picture lies on the part, in pixels.
fn places(up: Direction, from_back: bool) -> Vec<[i64; 2]> {
    let values = (0..SIDE * SIDE).map(|i| i as f64).collect();
    let picture = Picture { columns: SIDE, rows: SIDE, pixel: [1.0; 2], values };
    let grid = lay(&picture, up, from_back, picture.middle());
    let mut places = vec![[0; 2]; SIDE * SIDE];
    for row in 0..SIDE {
        for column in 0..SIDE {
            let place = grid.position(row, column);
            places[grid.at(row, column) as usize] = place.map(|a| a.round() as i64);
        }
    }
    places
}

/// The name of the direction in which a place lies from the middle.
fn side([x, y]: [i64; 2]) -> &'static str {
    match (x.signum(), y.signum()) {
        (1, 0) => "+x",
        (-1, 0) => "-x",
        (0, 1) => "+y",
        (0, -1) => "-y",
        _ => panic!("{x} {y}"),
    }
}

fn drawing() -> String {
    let ups = [
        ("plus_y", Direction::plus_y),
        ("minus_y", Direction::minus_y),
        ("plus_x", Direction::plus_x),
        ("minus_x", Direction::minus_x),
    ];
    let mut out = String::new();
    for (view, from_back) in [("from_tool_side", false), ("from_back", true)] {
        out.push_str(&format!("view: {view}\n\n"));
        let all: Vec<Vec<[i64; 2]>> = ups.iter().map(|(_, up)| places(*up, from_back)).collect();
        let mut line = |cells: Vec<String>| {
            let text = cells.iter().map(|cell| format!("{cell:<19}")).collect::<String>();
            out.push_str(&format!("  {}\n", text.trim_end()));
        };
        line(ups.iter().map(|(name, _)| format!("up: {name}")).collect());
        let middle = SIDE / 2;
        line(all.iter().map(|p| format!("       {}", side(p[middle]))).collect());
        for row in 0..SIDE {
            let cell = |p: &Vec<[i64; 2]>| {
                let dots = (0..SIDE).map(|column| if p[row * SIDE + column] == [2, 1] { "#" } else { "." });
                let dots = dots.collect::<Vec<_>>().join(" ");
                match row == middle {
                    true => format!("{} {dots} {}", side(p[row * SIDE]), side(p[row * SIDE + SIDE - 1])),
                    false => format!("   {dots}"),
                }
            };
            line(all.iter().map(cell).collect());
        }
        line(all.iter().map(|p| format!("       {}", side(p[(SIDE - 1) * SIDE + middle]))).collect());
        out.push('\n');
    }
    out.trim_end().to_string() + "\n"
}

#[test]
fn the_drawing_of_the_orientations_is_what_the_code_does() {
    let path = Path::new("docs/howto/map.md");
    let page = read(path);
    keep(path, &between(&page, "at its sides:\n\n```text\n", "```", &drawing()), "the drawing");
}

/// By hand: with +y up and seen from the tool side, +x is on the right; from behind it is on the left; up stays up.
#[test]
fn the_drawing_begins_as_it_must() {
    let front = places(Direction::plus_y, false);
    assert_eq!((front[2], front[14]), ([0, 2], [2, 0]));
    let back = places(Direction::plus_y, true);
    assert_eq!((back[2], back[14]), ([0, 2], [-2, 0]));
}
