//! Did you mean: the known name nearest to a misspelt one.

/// The name nearest to `word` by edits (insert, drop, replace, swap neighbours; case does not count), if it is near
/// enough to be meant (a third of the word's length, at least one edit) and no other is as near.
pub fn nearest<'a>(word: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A name of more than 64 letters is no slip of the finger, and the table below would grow with its square.
    if word.chars().count() > 64 {
        return None;
    }
    let allowed = (word.chars().count() / 3).max(1);
    let mut near: Vec<(usize, &str)> = names
        .into_iter()
        .filter(|name| name.chars().count() <= 64)
        .map(|name| (edits(word, name), name))
        .filter(|(distance, name)| *distance <= allowed && *distance < name.chars().count())
        .collect();
    near.sort_unstable();
    near.dedup();
    // Of two names that are equally near neither is proposed: `plus_z` for `plus_x` would turn a map around.
    match near.as_slice() {
        [(distance, name), rest @ ..] if rest.first().is_none_or(|(next, _)| next > distance) => Some(name),
        _ => None,
    }
}

/// The least number of edits between two words (optimal string alignment), ignoring case.
fn edits(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.to_lowercase().chars().collect();
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let width = b.len() + 1;
    let mut table = vec![0; (a.len() + 1) * width];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            table[i * width + j] = if i == 0 {
                j
            } else if j == 0 {
                i
            } else {
                let replaced = table[(i - 1) * width + j - 1] + usize::from(a[i - 1] != b[j - 1]);
                let dropped = table[(i - 1) * width + j] + 1;
                let inserted = table[i * width + j - 1] + 1;
                let mut least = replaced.min(dropped).min(inserted);
                if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                    least = least.min(table[(i - 2) * width + j - 2] + 1);
                }
                least
            };
        }
    }
    table[a.len() * width + b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_of_the_finger_are_found() {
        let names = ["point_step", "line_pitch", "lines", "over"];
        assert_eq!(nearest("pont_step", names), Some("point_step"));
        assert_eq!(nearest("line_pithc", names), Some("line_pitch"));
        assert_eq!(nearest("Lines", names), Some("lines"));
        assert_eq!(nearest("precession", names), None);
        // Two names are equally near.
        assert_eq!(nearest("plus_z", ["plus_x", "plus_y"]), None);
        // One letter is not near to any other letter.
        assert_eq!(nearest("x", ["y"]), None);
    }

    #[test]
    fn edits_are_counted_by_hand() {
        assert_eq!(edits("abc", "abc"), 0);
        assert_eq!(edits("abc", "acb"), 1);
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
    }
}
