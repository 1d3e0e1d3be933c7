//! A small reader of KRL text, for tests only; see [`super::program_text`].
//!
//! Written from what public references say of KRL: `FRAME` is `{X,Y,Z,A,B,C}` in mm and degrees with R = Rz(A) Ry(B) Rx(C);
//! `AXIS` is `{A1..A6}`; `$VEL.CP` is in metres a second; the robot stops at the end of a `SPLINE` block and of an `SLIN` or
//! `LIN` that stands alone. `$BASE` is one frame in the world.

use super::program_text::{Configuration, Move, ProgramText};
use super::rigid::{Pose, Quaternion};

/// Where the robot does not stop.
pub const PASSED: &str = "passed";

/// Reads the files of a program: the main one has the shortest name.
pub fn read(files: &[(String, Vec<u8>)]) -> ProgramText {
    let main = files.iter().map(|(name, _)| name).filter(|name| name.ends_with(".src")).min_by_key(|name| name.len());
    let main = main.expect("a main program").strip_suffix(".src").expect("the ending");
    let lines = |name: &str| -> Vec<String> {
        let (_, bytes) = files.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no file `{name}`"));
        let text = String::from_utf8(bytes.clone()).expect("ASCII");
        let code = |line: &str| line.split(';').next().unwrap_or("").split_whitespace().collect::<Vec<_>>().join(" ");
        text.lines().map(code).filter(|line| !line.is_empty()).collect()
    };
    let data = lines(&format!("{main}.dat"));
    let declared = |of_type: &str, ending: &str| -> String {
        let start = format!("DECL {of_type} {main}_{ending}=");
        data.iter().find_map(|line| line.strip_prefix(&start)).unwrap_or_else(|| panic!("no `{start}`")).to_string()
    };
    let home = six(&declared("AXIS", "home"), ["A1", "A2", "A3", "A4", "A5", "A6"]);
    let mut moves = Vec::new();
    for line in lines(&format!("{main}.src")) {
        if line == "END" {
            break;
        }
        if line == format!("PTP {main}_home") {
            moves.push(Move::Joint { joints: home });
        }
        let called = line.split(" (").next().unwrap_or("");
        if called.strip_prefix(&format!("{main}_")).is_some_and(|k| k.bytes().all(|b| b.is_ascii_digit())) {
            part(&lines(&format!("{called}.src")), &mut moves);
        }
    }
    ProgramText {
        tool: pose(&declared("FRAME", "tool")),
        user: pose(&declared("FRAME", "base")),
        object: Pose::IDENTITY,
        moves,
    }
}

/// The moves of a sub-program.
fn part(lines: &[String], moves: &mut Vec<Move>) {
    let (mut speed, mut in_block) = (f64::NAN, false);
    for line in lines {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        match word {
            "SPLINE" => in_block = true,
            "ENDSPLINE" => {
                in_block = false;
                if let Some(Move::Straight { zone, .. }) = moves.last_mut() {
                    *zone = "fine".into();
                }
            }
            "PTP" => moves.push(Move::Joint { joints: six(rest, ["A1", "A2", "A3", "A4", "A5", "A6"]) }),
            "SPL" | "SLIN" | "LIN" => {
                let (place, more) = rest.split_once('}').expect("a place");
                let with = more.split_once("$VEL.CP=").map(|(_, v)| v.trim().parse::<f64>().expect("a speed"));
                let [status, turn] = ["S", "T"].map(|label| number(place, label) as i32);
                let rests = !in_block && !more.contains("C_DIS");
                moves.push(Move::Straight {
                    target: pose(place),
                    configuration: Configuration::Kuka { status, turn },
                    speed: with.unwrap_or(speed) * 1e3,
                    zone: if rests { "fine" } else { PASSED }.into(),
                });
            }
            word => {
                if let Some(value) = word.strip_prefix("$VEL.CP=") {
                    speed = value.parse().expect("a speed");
                }
            }
        }
    }
}

/// The number behind `label` in an aggregate.
fn number(text: &str, label: &str) -> f64 {
    let found = text.split(['{', '}', ',']).find_map(|part| part.trim().strip_prefix(label)?.strip_prefix(' '));
    found.unwrap_or_else(|| panic!("no `{label}` in {text}")).trim().parse().expect("a number")
}

fn six(text: &str, labels: [&str; 6]) -> [f64; 6] {
    labels.map(|label| number(text, label))
}

fn pose(text: &str) -> Pose {
    let [x, y, z, a, b, c] = six(text, ["X", "Y", "Z", "A", "B", "C"]);
    let half = |angle: f64| (angle.to_radians() / 2.0).sin_cos();
    let ((sa, ca), (sb, cb), (sc, cc)) = (half(a), half(b), half(c));
    let turn =
        Quaternion([ca, 0.0, 0.0, sa]).times(&Quaternion([cb, 0.0, sb, 0.0])).times(&Quaternion([cc, sc, 0.0, 0.0]));
    Pose { at: [x, y, z], turn }
}
