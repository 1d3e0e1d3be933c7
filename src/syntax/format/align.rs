//! Alignment: what stood under each other stands under each other.
//!
//! In: lines with the least blanks. Out: some blanks more. An author who puts more than one blank before a value asks for
//! a column; its lines are those that follow each other, and it is as far to the right as the longest of them needs that
//! does not reach beyond the place asked for. A longer name sticks out, as it did. So a list that grows is put right by one blank
//! too many, and a file without columns gets none.

use super::layout::{Column, Line};

/// Adds the blanks that make columns. A blank line parts columns, a line with nothing but a comment does not.
pub fn align(lines: &mut [Line<'_>]) {
    for paragraph in lines.chunk_by_mut(|_, below| !below.blank_before) {
        let mut rows: Vec<&mut Line<'_>> = paragraph.iter_mut().filter(|line| !line.is_comment()).collect();
        let deepest = rows.iter().map(|line| columns(line).len()).max().unwrap_or(0);
        for nth in 0..deepest {
            rows.chunk_by_mut(|above, below| share(above, below, nth)).for_each(|run| align_column(run, nth));
        }
        rows.chunk_by_mut(|above, below| share_comments(above, below)).for_each(align_comments);
    }
}

/// The places of the pieces that may be aligned.
fn columns(line: &Line<'_>) -> Vec<usize> {
    if !line.whole {
        return Vec::new();
    }
    (0..line.pieces.len()).filter(|&i| line.pieces[i].column.is_some()).collect()
}

/// Whether two lines can share their `nth` column. Cells make a table only if the lines are alike from end to end.
fn share(above: &Line<'_>, below: &Line<'_>, nth: usize) -> bool {
    let kinds =
        |line: &Line<'_>| -> Vec<Option<Column>> { columns(line).into_iter().map(|i| line.pieces[i].column).collect() };
    let (above, below) = (kinds(above), kinds(below));
    match (above.get(nth), below.get(nth)) {
        (Some(a), Some(b)) => a == b && (*a != Some(Column::Cell) || above == below),
        _ => false,
    }
}

/// Characters between the line's first piece and the piece at `at`.
fn place(line: &Line<'_>, at: usize) -> usize {
    let before: usize = line.pieces[..at].iter().map(|piece| piece.blanks + piece.text.chars().count()).sum();
    before + line.pieces[at].blanks
}

fn align_column(lines: &mut [&mut Line<'_>], nth: usize) {
    let cells: Vec<(usize, usize)> =
        lines.iter().filter_map(|line| columns(line).get(nth).map(|&at| (at, place(line, at)))).collect();
    if cells.len() < lines.len() {
        return;
    }
    let pieces = lines.iter().zip(&cells).map(|(line, &(at, _))| &line.pieces[at]);
    let Some(asked) = pieces.filter(|piece| piece.written > 1).map(|piece| piece.offset).max() else { return };
    let Some(target) = cells.iter().map(|(_, natural)| *natural).filter(|natural| *natural <= asked).max() else {
        return;
    };
    for (line, (at, natural)) in lines.iter_mut().zip(cells) {
        line.pieces[at].blanks += target.saturating_sub(natural);
    }
}

/// Whether the comments at the ends of two lines began in one column of the source.
fn share_comments(above: &Line<'_>, below: &Line<'_>) -> bool {
    let one_line = |line: &Line<'_>| !line.pieces.iter().any(|piece| piece.text.contains('\n'));
    match (&above.trailing, &below.trailing) {
        (Some(a), Some(b)) => {
            a.column == b.column && above.indent == below.indent && one_line(above) && one_line(below)
        }
        _ => false,
    }
}

/// They do so again.
fn align_comments(lines: &mut [&mut Line<'_>]) {
    let end = |line: &Line<'_>| {
        let width: usize = line.pieces.iter().map(|piece| piece.blanks + piece.text.chars().count()).sum();
        line.indent + width
    };
    let Some(longest) = lines.iter().map(|line| end(line)).max() else { return };
    let Some(blanks) = lines.iter().filter_map(|line| line.trailing.as_ref()).map(|t| t.blanks).min() else { return };
    for line in lines {
        let more = longest + blanks - end(line);
        if let Some(trailing) = &mut line.trailing {
            trailing.blanks = more;
        }
    }
}
