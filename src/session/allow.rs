//! `allow CODE because "…"`: takes the warnings away that the files allow, and says which line allows nothing.
//!
//! In: all that a compilation said, and the `allow` lines of its files. Out: the same without the allowed warnings. It
//! compares places only: a warning of that code inside the entry that the line stands before.

use crate::diagnostics::{Diagnostic, Severity, codes};
use crate::syntax::ast::Allow;

/// The line that allows this warning, by its index.
fn allowing(diagnostic: &Diagnostic, allows: &[Allow]) -> Option<usize> {
    let place = diagnostic.primary.as_ref()?.span;
    if diagnostic.severity != Severity::Warning {
        return None;
    }
    allows.iter().position(|allow| {
        let target = allow.target;
        allow.code.text == diagnostic.code.as_str()
            && target.file == place.file
            && target.start <= place.start
            && place.end <= target.end
    })
}

/// Why the warning is allowed, if it is.
pub fn reason<'a>(diagnostic: &Diagnostic, allows: &'a [Allow]) -> Option<&'a str> {
    allowing(diagnostic, allows).map(|index| allows[index].reason.as_str())
}

/// Takes the allowed warnings away. `could` says whether a warning of that code could have come up at all where the line
/// stands; of the others nobody knows whether the line is of use.
pub fn silence(said: &mut Vec<Diagnostic>, allows: &[Allow], could: impl Fn(&Allow) -> bool) {
    let mut used = vec![false; allows.len()];
    said.retain(|diagnostic| match allowing(diagnostic, allows) {
        Some(index) => {
            used[index] = true;
            false
        }
        None => true,
    });
    for (allow, _) in allows.iter().zip(&used).filter(|(allow, used)| !**used && could(allow)) {
        let message = format!("nothing in the entry after this line is warned of by `{}`", allow.code.text);
        said.push(Diagnostic::warning(codes::W0102, allow.span, message).help("delete the line"));
    }
}
