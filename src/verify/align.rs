//! Two sequences side by side: what a program says, and what it should.
//!
//! In: their lengths, and whether two of their members fit. Out: events in order. What is missing or too much is found
//! where it is, so that one line put in does not make all later ones differ.

use std::ops::Range;

/// What was met; indices into both sequences.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Met {
    /// The found one stands where the wanted one should; whether they fit is for the caller to see.
    Pair { found: usize, wanted: usize },
    /// These are missing before the found one (at the end: its count).
    Missing { wanted: Range<usize>, before: usize },
    /// These are too many, before the wanted one.
    Extra { found: Range<usize>, before: usize },
    /// Two found ones stand in each other's place.
    Swapped { found: usize, wanted: usize },
}

/// Statements: a few, of which any may be missing, changed or put in. Looks one member ahead.
pub(super) fn statements(found: usize, wanted: usize, fits: impl Fn(usize, usize) -> bool, mut met: impl FnMut(Met)) {
    let (mut f, mut w) = (0, 0);
    while w < wanted {
        if f >= found {
            met(Met::Missing { wanted: w..w + 1, before: found });
            w += 1;
        } else if fits(f, w) {
            met(Met::Pair { found: f, wanted: w });
            (f, w) = (f + 1, w + 1);
        } else if f + 1 < found && fits(f + 1, w) {
            met(Met::Extra { found: f..f + 1, before: w });
            f += 1;
        } else if w + 1 < wanted && fits(f, w + 1) {
            met(Met::Missing { wanted: w..w + 1, before: f });
            w += 1;
        } else {
            met(Met::Pair { found: f, wanted: w });
            (f, w) = (f + 1, w + 1);
        }
    }
    if f < found {
        met(Met::Extra { found: f..found, before: wanted });
    }
}

/// Moves: many, of which a stretch may be missing or put in. Looks as far ahead as the lengths differ.
pub(super) fn moves(found: usize, wanted: usize, fits: impl Fn(usize, usize) -> bool, mut met: impl FnMut(Met)) {
    let (mut f, mut w) = (0, 0);
    while f < found && w < wanted {
        if !fits(f, w) {
            // Fewer than wanted: perhaps some are missing here. More: perhaps some were put in.
            let missing = (wanted - w).saturating_sub(found - f);
            let extra = (found - f).saturating_sub(wanted - w);
            if let Some(k) = (1..=missing).find(|k| w + k < wanted && fits(f, w + k)) {
                met(Met::Missing { wanted: w..w + k, before: f });
                w += k;
                continue;
            }
            if let Some(k) = (1..=extra).find(|k| f + k < found && fits(f + k, w)) {
                met(Met::Extra { found: f..f + k, before: w });
                f += k;
                continue;
            }
            if f + 1 < found && w + 1 < wanted && fits(f, w + 1) && fits(f + 1, w) {
                met(Met::Swapped { found: f, wanted: w });
                (f, w) = (f + 2, w + 2);
                continue;
            }
        }
        met(Met::Pair { found: f, wanted: w });
        (f, w) = (f + 1, w + 1);
    }
    if w < wanted {
        met(Met::Missing { wanted: w..wanted, before: f });
    }
    if f < found {
        met(Met::Extra { found: f..found, before: w });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fits<'a>(found: &'a str, wanted: &'a str) -> impl Fn(usize, usize) -> bool + 'a {
        |f, w| found.as_bytes()[f] == wanted.as_bytes()[w]
    }

    /// What was met, pairs that fit left out.
    fn differences(found: &str, wanted: &str, met: Vec<Met>) -> Vec<Met> {
        let same = |met: &Met| matches!(met, Met::Pair { found: f, wanted: w } if fits(found, wanted)(*f, *w));
        met.into_iter().filter(|met| !same(met)).collect()
    }

    #[test]
    fn moves_by_hand() {
        let moves = |found: &str, wanted: &str| {
            let mut all = Vec::new();
            moves(found.len(), wanted.len(), fits(found, wanted), |met| all.push(met));
            differences(found, wanted, all)
        };
        assert_eq!(moves("abc", "abc"), []);
        assert_eq!(moves("ade", "abcde"), [Met::Missing { wanted: 1..3, before: 1 }]);
        assert_eq!(moves("axybc", "abc"), [Met::Extra { found: 1..3, before: 1 }]);
        assert_eq!(moves("acbd", "abcd"), [Met::Swapped { found: 1, wanted: 1 }]);
        assert_eq!(moves("axc", "abc"), [Met::Pair { found: 1, wanted: 1 }]);
        assert_eq!(moves("ab", "abc"), [Met::Missing { wanted: 2..3, before: 2 }]);
        assert_eq!(moves("abc", ""), [Met::Extra { found: 0..3, before: 0 }]);
    }

    #[test]
    fn statements_by_hand() {
        let statements = |found: &str, wanted: &str| {
            let mut all = Vec::new();
            statements(found.len(), wanted.len(), fits(found, wanted), |met| all.push(met));
            differences(found, wanted, all)
        };
        assert_eq!(statements("acd", "abcd"), [Met::Missing { wanted: 1..2, before: 1 }]);
        assert_eq!(statements("axb", "ab"), [Met::Extra { found: 1..2, before: 1 }]);
        assert_eq!(statements("ax", "ab"), [Met::Pair { found: 1, wanted: 1 }]);
        assert_eq!(
            statements("a", "abc"),
            [Met::Missing { wanted: 1..2, before: 1 }, Met::Missing { wanted: 2..3, before: 1 }]
        );
        assert_eq!(statements("abx", "ab"), [Met::Extra { found: 2..3, before: 2 }]);
    }
}
