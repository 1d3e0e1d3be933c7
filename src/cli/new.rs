//! `polishc new`: a project that builds, from a template: all of it or nothing.
//!
//! A template is a folder under `templates/`, whose job is called `my_mirror`; a test builds it. Its map is that of
//! `examples/first`.
#![allow(clippy::disallowed_methods, reason = "cli is where the disk is")]

use super::arguments::{Common, MessageFormat, Template};
use super::output::{self, Output, RealFolder};
use super::terminal::{WRONG_INPUT, say, show};
use crate::diagnostics::Diagnostic;
use crate::diagnostics::codes as code;
use crate::source::Sources;
use crate::syntax::is_reserved;
use std::path::Path;

/// The files of the template for MRF, by name.
const MRF: [(&str, &[u8]); 6] = [
    ("my_mirror.polish", include_bytes!("../../templates/mrf/my_mirror.polish")),
    ("cell.polish", include_bytes!("../../templates/mrf/cell.polish")),
    ("my_mirror.dat", include_bytes!("../../examples/first/first.dat")),
    ("polish.toml", include_bytes!("../../templates/mrf/polish.toml")),
    ("README.md", include_bytes!("../../templates/mrf/README.md")),
    (".gitignore", include_bytes!("../../templates/mrf/gitignore")),
];

/// Longest name of a job: KUKA controllers allow 24 characters in a program's name, and its parts have a suffix.
const LONGEST_NAME: usize = 20;

/// Makes the project in `folder`.
pub fn project(common: &Common, folder: &Path, template: Template) -> u8 {
    match make(folder, template) {
        Ok(name) => {
            if !common.quiet && common.message_format != MessageFormat::Json {
                tell(folder, &name);
            }
            0
        }
        Err(diagnostic) => {
            show(common, &Sources::default(), &[*diagnostic]);
            WRONG_INPUT
        }
    }
}

fn make(folder: &Path, template: Template) -> Result<String, Box<Diagnostic>> {
    let refuse = |message: String, help: &str| Box::new(Diagnostic::placeless(code::E1206, message).help(help));
    if template != Template::Mrf {
        let message = format!("the template `{}` is not there yet: templates come with their tools", template.name());
        return Err(refuse(message, "`--template mrf` is there"));
    }
    let shown = folder.display();
    // `.` and `a/..` have a name, too.
    let whole = std::path::absolute(folder).ok().and_then(|path| path.canonicalize().ok().or(Some(path)));
    let last = whole.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    let name = last.as_deref().and_then(job_name).ok_or_else(|| {
        let message = format!("`{shown}` does not make the name of a job");
        refuse(message, "name the folder in small letters, digits and `_`, beginning with a letter: `my_mirror`")
    })?;
    if folder.exists() && !folder.is_dir() {
        return Err(refuse(format!("`{shown}` is a file, not a folder"), "name a folder that does not exist yet"));
    }
    let full = std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if full {
        return Err(refuse(format!("the folder `{shown}` is not empty"), "name a folder that does not exist yet"));
    }
    let files = MRF.iter().map(|(file, bytes)| (renamed(file, &name), filled(file, bytes, &name))).collect();
    let output = Output { folder: folder.to_path_buf(), files, stale: Vec::new() };
    output::write_all(&mut RealFolder, &[output]).map_err(|message| {
        Box::new(Diagnostic::placeless(code::E1201, message).help("nothing was written; choose another folder"))
    })?;
    Ok(name)
}

/// The job's name from that of its folder: other letters in small, `-`, `.` and blanks as `_`.
fn job_name(folder: &str) -> Option<String> {
    let plain = |c: char| match c {
        'A'..='Z' => c.to_ascii_lowercase(),
        '-' | ' ' | '.' => '_',
        c => c,
    };
    let name: String = folder.trim_matches(['-', ' ', '.', '_']).chars().map(plain).collect();
    let good = name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c == '_' || c.is_ascii_lowercase() || c.is_ascii_digit())
        && name.len() <= LONGEST_NAME
        && name != "cell"
        && !is_reserved(&name);
    good.then_some(name)
}

fn renamed(file: &str, name: &str) -> String {
    file.replace("my_mirror", name)
}

/// The file with the project's name in place of the template's.
fn filled(file: &str, bytes: &[u8], name: &str) -> Vec<u8> {
    let Ok(text) = std::str::from_utf8(bytes) else { return bytes.to_vec() };
    // A program's module is named as controllers like it: `MyMirror`.
    let words = name.split('_').filter(|word| !word.is_empty());
    let module: String = words.map(|word| word[..1].to_ascii_uppercase() + &word[1..]).collect();
    debug_assert!(!file.ends_with(".polish") || text.starts_with("language 1"));
    text.replace("my_mirror", name).replace("MyMirror", &module).into_bytes()
}

fn tell(folder: &Path, name: &str) {
    let shown = folder.display();
    let last = folder.file_name().map(|name| name.to_string_lossy());
    if last.is_some_and(|last| last != name) {
        say(&format!("the job is called `{name}`: a name has small letters, digits and `_`"));
    }
    say(&format!("made {shown}, a job that builds:"));
    say(&format!("  polishc build {}", folder.join(format!("{name}.polish")).display()));
    say(&format!("{} says what to put in place of the example's numbers", folder.join("README.md").display()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_mended_where_the_mend_is_plain() {
        for (folder, name) in [
            ("my_mirror", Some("my_mirror")),
            ("My-Mirror 2.v3", Some("my_mirror_2_v3")),
            ("340mm", None),
            ("job", None),
            ("if", None),
            ("cell", None),
            ("spiegel_größe", None),
            ("-", None),
            ("a_name_longer_than_twenty", None),
        ] {
            assert_eq!(job_name(folder).as_deref(), name, "{folder}");
        }
    }
}
