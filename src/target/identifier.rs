//! Names as all targets have them.
//!
//! In: a name of the job. Out: why it is none. Each target adds the words that its language keeps for itself.

/// Why `name` is no identifier of at most `most` characters, or `None` if it is one.
pub fn not_an_identifier(name: &str, most: usize) -> Option<String> {
    let mut characters = name.chars();
    if !characters.next().is_some_and(|c| c.is_ascii_alphabetic()) {
        return Some("it does not begin with a letter from A to Z".into());
    }
    if let Some(c) = characters.find(|c| !c.is_ascii_alphanumeric() && *c != '_') {
        let what = if c.is_control() { "a control character".to_string() } else { format!("the character `{c}`") };
        return Some(format!("{what} is not allowed in one"));
    }
    if name.len() > most {
        return Some(format!("it has {} characters where {most} fit", name.len()));
    }
    None
}
