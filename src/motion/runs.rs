//! Runs: which lines are travelled between one approach and one retract.
//!
//! In: the path's lines and the room that a run has. Out: ranges of lines and points. A run ends where the
//! path lifts, and before a line that no longer fits; never inside a line, where the tool would mark the part.

use super::Room;
use crate::diagnostics::{Problem, codes};
use crate::path::{Line, Link};
use std::ops::Range;

/// The lines and points of one run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub lines: Range<usize>,
    pub points: Range<usize>,
}

/// Splits the lines into runs that fit into `room`. A single line that does not is refused.
pub(super) fn split(lines: &[Line], room: Room) -> Result<Vec<Span>, Problem> {
    let mut runs: Vec<Span> = Vec::new();
    let mut lifted = true;
    let size = |points: usize, lines: usize| points.saturating_mul(room.point).saturating_add(lines * room.line);
    for (i, line) in lines.iter().enumerate() {
        if size(line.points.len(), 1) > room.total {
            let most = room.line_points();
            let message = format!(
                "line {} of the path has {} points, one file of the program holds {most}",
                i + 1,
                line.points.len()
            );
            return Err(Problem::error(codes::E0804, "path.point_step", message).help(
                "a line is broken only where the path says how the tool lands there: say `landing` in `path`, take a larger \
                 `point_step`, or raise the limits of one file in `target.controller` (`module_bytes`, `file_lines`) if the \
                 controller takes larger files",
            ));
        }
        match runs.last_mut() {
            Some(run) if !lifted && size(line.points.end - run.points.start, run.lines.len() + 1) <= room.total => {
                run.lines.end = i + 1;
                run.points.end = line.points.end;
            }
            _ => runs.push(Span { lines: i..i + 1, points: line.points.clone() }),
        }
        lifted = line.link == Link::Lifted;
    }
    Ok(runs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(lengths: &[usize], links: &[Link]) -> Vec<Line> {
        let mut start = 0;
        lengths
            .iter()
            .zip(links)
            .map(|(length, link)| {
                start += length;
                Line { points: start - length..start, link: *link }
            })
            .collect()
    }

    #[test]
    fn a_run_takes_as_many_lines_as_fit() {
        let found = split(&lines(&[4, 4, 4, 4, 4], &[Link::OnSurface; 5]), Room::points(9)).expect("fits");
        let spans: Vec<_> = found.iter().map(|run| (run.lines.clone(), run.points.clone())).collect();
        assert_eq!(spans, [(0..2, 0..8), (2..4, 8..16), (4..5, 16..20)]);
    }

    #[test]
    fn what_a_line_takes_of_itself_counts() {
        // Two a point and three a line: 11 for a line of four points. Two of them are 22.
        let room = |total| Room { total, point: 2, line: 3 };
        let found = split(&lines(&[4, 4, 4], &[Link::OnSurface; 3]), room(22)).expect("fits");
        assert_eq!(found.iter().map(|run| run.lines.clone()).collect::<Vec<_>>(), [0..2, 2..3]);
        let found = split(&lines(&[4, 4, 4], &[Link::OnSurface; 3]), room(21)).expect("fits");
        assert_eq!(found.len(), 3);
        let problem = split(&lines(&[4], &[Link::OnSurface]), room(10)).expect_err("11 do not fit into 10");
        assert!(problem.message.ends_with("has 4 points, one file of the program holds 3"));
    }

    #[test]
    fn lifting_ends_a_run() {
        let found = split(&lines(&[4, 4, 4], &[Link::OnSurface, Link::Lifted, Link::OnSurface]), Room::points(100))
            .expect("fits");
        let spans: Vec<_> = found.iter().map(|run| (run.lines.clone(), run.points.clone())).collect();
        assert_eq!(spans, [(0..2, 0..8), (2..3, 8..12)]);
    }

    #[test]
    fn a_line_that_no_module_holds_is_refused() {
        let problem =
            split(&lines(&[4, 10], &[Link::OnSurface; 2]), Room::points(9)).expect_err("10 points do not fit in 9");
        assert_eq!(problem.code, codes::E0804);
        assert_eq!(problem.message, "line 2 of the path has 10 points, one file of the program holds 9");
    }
}
