//! A small reader of program text, for tests only.
//!
//! Written from the RAPID reference manual's description of `robtarget`, `jointtarget`, `speeddata`, `tooldata` and
//! `wobjdata`, so that a test can ask the text what it says without the crate's own reader or planner. It knows no more
//! than the statements that the tests look at.

use super::krl_text;
use super::rigid::{Pose, Quaternion, dot};

/// Half of the travel height of the test's job, mm: a move that goes so far off the glass lifts the tool.
const LIFT: f64 = 20.0;

/// A move, in the order in which the controller makes them. Lengths in mm, angles in degrees, speeds in mm/s.
#[derive(Clone, Debug, PartialEq)]
pub enum Move {
    /// `MoveAbsJ`.
    Joint { joints: [f64; 6] },
    /// `MoveL`: the tool frame in the object frame.
    Straight { target: Pose, configuration: Configuration, speed: f64, zone: String },
}

/// What a target says of the arm's configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Configuration {
    /// cf1, cf4, cf6, cfx.
    Abb([i32; 4]),
    /// S and T.
    Kuka { status: i32, turn: i32 },
}

/// What a program says.
#[derive(Clone, Debug)]
pub struct ProgramText {
    /// `tframe` of the tool data.
    pub tool: Pose,
    /// `uframe` and `oframe` of the work object data.
    pub user: Pose,
    pub object: Pose,
    pub moves: Vec<Move>,
}

/// A straight move that polishes, or links two lines.
#[derive(Clone, Debug)]
pub struct PathPoint {
    pub target: Pose,
    pub configuration: Configuration,
    /// Of the move that ends here.
    pub speed: f64,
    pub zone: String,
}

/// What happens between one `MoveAbsJ` and the next: down on the path, along it, up again.
#[derive(Clone, Debug)]
pub struct RunText {
    /// Joints over the run's first point, degrees.
    pub start: [f64; 6],
    pub points: Vec<PathPoint>,
    pub retract: Pose,
    /// Of the move up to it.
    pub retract_speed: f64,
}

impl ProgramText {
    /// Reads the files of a program, the main module first; modules are taken in the order in which main loads them.
    pub fn read(files: &[(String, Vec<u8>)]) -> ProgramText {
        if files.iter().any(|(name, _)| name.ends_with(".src")) {
            return krl_text::read(files);
        }
        let text = |name: &str| -> String {
            let (_, bytes) = files.iter().find(|(n, _)| n == name).unwrap_or_else(|| panic!("no file `{name}`"));
            String::from_utf8(bytes.clone()).expect("ASCII")
        };
        let (mut tool, mut object, mut home) = (None, None, None);
        let mut moves = Vec::new();
        for statement in statements(&text(&files[0].0)) {
            if statement.starts_with("PERS tooldata") {
                let n = numbers(&statement);
                tool = Some(pose(&n[..7]));
            } else if statement.starts_with("PERS wobjdata") {
                let n = numbers(&statement);
                object = Some((pose(&n[..7]), pose(&n[7..14])));
            } else if statement.starts_with("CONST jointtarget") {
                // The first is home; safe poses follow.
                home = home.or(Some(six(&numbers(&statement))));
            } else if statement.starts_with("Load") {
                let name =
                    statement.split('"').nth(1).and_then(|path| path.rsplit('/').next()).expect("a file to load");
                moves.extend(statements(&text(name)).iter().filter_map(|statement| read_move(statement, home)));
            } else if let Some(one) = read_move(&statement, home) {
                moves.push(one);
            }
        }
        let (user, object) = object.expect("work object data");
        ProgramText { tool: tool.expect("tool data"), user, object, moves }
    }

    /// The runs: what stands between two joint moves goes down to a first point, along, and up; a straight move to the
    /// next run's approach may follow. A run ends where the tool goes off the glass against its own z axis, by more than
    /// from any line to the next.
    pub fn runs(&self) -> Vec<RunText> {
        let mut runs: Vec<RunText> = Vec::new();
        for one in &self.moves {
            match one.clone() {
                Move::Joint { joints } => {
                    runs.push(RunText {
                        start: joints,
                        points: Vec::new(),
                        retract: Pose::IDENTITY,
                        retract_speed: 0.0,
                    });
                }
                Move::Straight { target, configuration, speed, zone } => {
                    let run = runs.last_mut().expect("a straight move comes after a joint move");
                    run.points.push(PathPoint { target, configuration, speed, zone });
                }
            }
        }
        // After the joint moves to home there is nothing.
        runs.retain(|run| !run.points.is_empty());
        for run in &mut runs {
            let lifted = |pair: &[PathPoint]| {
                let away: [f64; 3] = std::array::from_fn(|i| pair[1].target.at[i] - pair[0].target.at[i]);
                dot(away, pair[0].target.turn.rotate([0.0, 0.0, -1.0])) > LIFT
            };
            let count = run.points.windows(2).position(lifted).expect("a run ends lifted") + 1;
            run.retract = run.points[count].target;
            run.retract_speed = run.points[count].speed;
            run.points.truncate(count);
        }
        runs
    }

    /// The object frame of the text in the world: `uframe * oframe`.
    pub fn world_object(&self) -> Pose {
        self.user.then(&self.object)
    }
}

/// Statements of a module: comments taken out, split at semicolons, blanks at the ends taken off.
fn statements(text: &str) -> Vec<String> {
    let mut out = vec![String::new()];
    let (mut in_text, mut in_comment) = (false, false);
    for c in text.chars() {
        match c {
            '\n' => in_comment = false,
            _ if in_comment => continue,
            '"' => in_text = !in_text,
            '!' if !in_text => in_comment = true,
            ';' if !in_text => {
                out.push(String::new());
                continue;
            }
            _ => {}
        }
        if !in_comment {
            out.last_mut().expect("one at least").push(c);
        }
    }
    out.iter().map(|whole| statement(whole)).collect()
}

/// From the word that begins a statement of interest; what opens a routine has no semicolon and stands before it.
fn statement(whole: &str) -> String {
    let words = ["PERS ", "CONST ", "MoveL ", "MoveAbsJ ", "Load\\"];
    let at = words.iter().filter_map(|word| whole.find(word)).min().unwrap_or(0);
    whole[at..].split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Numbers that stand inside brackets.
fn numbers(statement: &str) -> Vec<f64> {
    let mut depth = 0;
    let mut word = String::new();
    let mut out = Vec::new();
    for c in statement.chars() {
        if matches!(c, '[' | ']' | ',') {
            if depth > 0 {
                out.extend(word.trim().parse::<f64>().ok());
            }
            word.clear();
            depth += i32::from(c == '[') - i32::from(c == ']');
        } else {
            word.push(c);
        }
    }
    out
}

fn six(numbers: &[f64]) -> [f64; 6] {
    std::array::from_fn(|i| numbers[i])
}

fn pose(n: &[f64]) -> Pose {
    Pose { at: [n[0], n[1], n[2]], turn: Quaternion([n[3], n[4], n[5], n[6]]) }
}

fn read_move(statement: &str, home: Option<[f64; 6]>) -> Option<Move> {
    let n = numbers(statement);
    if statement.starts_with("MoveAbsJ") {
        // A literal jointtarget has twelve numbers, a speed four; without the twelve it is the constant.
        let joints = if n.len() >= 12 { six(&n) } else { home.expect("the constant is declared before it is used") };
        return Some(Move::Joint { joints });
    }
    if !statement.starts_with("MoveL") {
        return None;
    }
    // 3 + 4 numbers of the pose, 4 of the configuration, 6 external axes, then the speed.
    let configuration = Configuration::Abb(std::array::from_fn(|i| n[7 + i] as i32));
    let after = &statement[statement.rfind("],").expect("the end of the speed") + 2..];
    let zone = after.split(',').next().expect("a zone").trim().to_string();
    Some(Move::Straight { target: pose(&n), configuration, speed: n[17], zone })
}
