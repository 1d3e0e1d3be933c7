//! Runs: which lines are travelled between one approach and one retract.
//!
//! In: the path's lines and the most points that a run may hold. Out: ranges of lines and points. A run ends where the
//! path lifts, and before a line that no longer fits; never inside a line, where the tool would mark the part.

use crate::diagnostics::{Problem, codes};
use crate::path::{Line, Link};
use std::ops::Range;

/// The lines and points of one run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub lines: Range<usize>,
    pub points: Range<usize>,
}

/// Splits the lines into runs of at most `most` points. A single line of more points is refused.
pub(super) fn split(lines: &[Line], most: usize) -> Result<Vec<Span>, Problem> {
    let mut runs: Vec<Span> = Vec::new();
    let mut lifted = true;
    for (i, line) in lines.iter().enumerate() {
        if line.points.len() > most {
            let message =
                format!("line {} of the path has {} points, a program module holds {most}", i + 1, line.points.len());
            return Err(Problem::error(codes::E0804, "path.point_step", message).help(
                "a run is never broken inside a line: take a larger `point_step`, or raise `module_bytes` and `module_points` \
                 of the controller if it takes larger modules",
            ));
        }
        match runs.last_mut() {
            Some(run) if !lifted && run.points.len() + line.points.len() <= most => {
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
        let found = split(&lines(&[4, 4, 4, 4, 4], &[Link::OnSurface; 5]), 9).expect("fits");
        let spans: Vec<_> = found.iter().map(|run| (run.lines.clone(), run.points.clone())).collect();
        assert_eq!(spans, [(0..2, 0..8), (2..4, 8..16), (4..5, 16..20)]);
    }

    #[test]
    fn lifting_ends_a_run() {
        let found = split(&lines(&[4, 4, 4], &[Link::OnSurface, Link::Lifted, Link::OnSurface]), 100).expect("fits");
        let spans: Vec<_> = found.iter().map(|run| (run.lines.clone(), run.points.clone())).collect();
        assert_eq!(spans, [(0..2, 0..8), (2..3, 8..12)]);
    }

    #[test]
    fn a_line_that_no_module_holds_is_refused() {
        let problem = split(&lines(&[4, 10], &[Link::OnSurface; 2]), 9).expect_err("10 points do not fit in 9");
        assert_eq!(problem.code, codes::E0804);
        assert_eq!(problem.message, "line 2 of the path has 10 points, a program module holds 9");
    }
}
