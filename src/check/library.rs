//! stdlib: the vocabulary in the language itself, embedded, seen as virtual files `<std>/…`.
//!
//! A job uses a small part of it, so only that part is read ([`needed`]): the words of the job's files say which items.

use std::collections::BTreeMap;

/// A file of stdlib.
#[derive(Clone, Copy, Debug)]
pub struct LibraryFile {
    /// Its words after `std` in a `use`, joined by dots: `robots.abb.irb6700_200_260`.
    pub module: &'static str,
    /// As shown to people: `<std>/robots/abb/irb6700_200_260.polish`.
    pub path: &'static str,
    pub text: &'static str,
    /// Whether it is visible without `use`.
    pub core: bool,
}

macro_rules! library {
    ($($core:literal $module:literal $path:literal)*) => {
        /// All files. Core files come first, in the order they are read.
        pub const FILES: &[LibraryFile] = &[
            $(LibraryFile {
                module: $module,
                path: concat!("<std>/", $path),
                text: include_str!(concat!("../../stdlib/", $path)),
                core: $core,
            }),*
        ];
    };
}

library! {
    true "dimensions" "dimensions.polish"
    true "units" "units.polish"
    true "functions" "functions.polish"
    true "geometry" "geometry.polish"
    true "workpiece" "workpiece.polish"
    true "metrology" "metrology.polish"
    true "tool" "tool.polish"
    true "influence" "influence.polish"
    true "path" "path.polish"
    true "dwell" "dwell.polish"
    true "uncertainty" "uncertainty.polish"
    true "robot" "robot.polish"
    true "cell" "cell.polish"
    true "target" "target.polish"
    true "controller" "controller.polish"
    true "result" "result.polish"
    true "job" "job.polish"
    false "materials.fused_silica" "materials/fused_silica.polish"
    false "materials.k9" "materials/k9.polish"
    false "materials.n_bk7" "materials/n_bk7.polish"
    false "materials.silicon_carbide" "materials/silicon_carbide.polish"
    false "materials.ule" "materials/ule.polish"
    false "materials.zerodur" "materials/zerodur.polish"
    false "robots.abb.irb6700_200_260" "robots/abb/irb6700_200_260.polish"
    false "robots.abb.irb6620_150_220" "robots/abb/irb6620_150_220.polish"
    false "robots.kuka.kr210_r2700_extra" "robots/kuka/kr210_r2700_extra.polish"
    false "robots.kuka.kr210_r2700_2" "robots/kuka/kr210_r2700_2.polish"
    false "controllers.irc5" "controllers/irc5.polish"
    false "controllers.krc4" "controllers/krc4.polish"
}

/// Prefix of the names of stdlib's files.
pub const PREFIX: &str = "<std>/";

/// An item of a core file: its name, and its bytes with the comment before it.
struct Item {
    name: &'static str,
    start: usize,
    end: usize,
}

/// The items of a library file. Each begins at the left edge, as the formatter leaves them.
fn items(text: &'static str) -> Vec<Item> {
    let mut found: Vec<Item> = Vec::new();
    let (mut at, mut comment) = (0, None);
    for line in text.split_inclusive('\n') {
        let start = at;
        at += line.len();
        let bare = line.strip_prefix("pub ").unwrap_or(line);
        if line.starts_with("//") {
            comment = comment.or(Some(start));
            continue;
        }
        if let Some((word, rest)) = bare.split_once(' ')
            && matches!(word, "dimension" | "unit" | "fn" | "family" | "schema" | "let")
        {
            let start = comment.unwrap_or(start);
            if let Some(last) = found.last_mut() {
                last.end = start;
            }
            let name = rest.split(|c: char| c.is_whitespace() || matches!(c, '(' | ':' | '=')).next().unwrap_or(rest);
            found.push(Item { name, start, end: text.len() });
        }
        comment = None;
    }
    found
}

/// Every word of a text, and `%`. Text of the library is read without its comments.
fn words<'t>(text: &'t str, comments: bool, mut see: impl FnMut(&'t str)) {
    for line in text.lines() {
        let line = if comments { line } else { line.split("//").next().unwrap_or(line) };
        let mut from = None;
        for (at, c) in line.char_indices() {
            let letter = c == '_' || c.is_alphabetic();
            match from {
                // `4mm` is a number and a word.
                None if letter => from = Some(at),
                Some(start) if !letter && !c.is_alphanumeric() => {
                    see(&line[start..at]);
                    from = None;
                }
                _ => {}
            }
            if c == '%' {
                see("%");
            }
        }
        if let Some(start) = from {
            see(&line[start..]);
        }
    }
}

/// The core files, cut down to the items that `texts` name, directly or through other items, and to those that every job
/// needs. What is left out is left as empty lines, so that places stay true. A name that is not there is found to be
/// missing, and then the whole library is read: this is only for files without a mistake.
pub fn needed<'t>(texts: impl Iterator<Item = &'t str>) -> Vec<(&'static LibraryFile, String)> {
    let core: Vec<(&LibraryFile, Vec<Item>)> =
        FILES.iter().filter(|file| file.core).map(|file| (file, items(file.text))).collect();
    let mut index: BTreeMap<&str, Vec<(usize, usize)>> = BTreeMap::new();
    for (file, (_, items)) in core.iter().enumerate() {
        for (number, item) in items.iter().enumerate() {
            index.entry(item.name).or_default().push((file, number));
        }
    }
    let mut wanted: Vec<Vec<bool>> = core.iter().map(|(_, items)| vec![false; items.len()]).collect();
    let mut todo: Vec<(usize, usize)> = Vec::new();
    let mut want = |word: &str, todo: &mut Vec<(usize, usize)>| {
        for &(file, number) in index.get(word).into_iter().flatten() {
            if !std::mem::replace(&mut wanted[file][number], true) {
                todo.push((file, number));
            }
        }
    };
    want("job", &mut todo);
    for text in texts {
        words(text, true, |word| want(word, &mut todo));
    }
    while let Some((file, number)) = todo.pop() {
        let (source, items) = &core[file];
        let item = &items[number];
        words(&source.text[item.start..item.end], false, |word| want(word, &mut todo));
    }
    let mut files = Vec::new();
    for ((file, items), wanted) in core.iter().zip(&wanted) {
        if !wanted.contains(&true) {
            continue;
        }
        let head = items.first().map_or(file.text.len(), |item| item.start);
        let mut text = file.text[..head].to_string();
        for (item, wanted) in items.iter().zip(wanted) {
            let written = &file.text[item.start..item.end];
            match wanted {
                true => text.push_str(written),
                false => text.extend(written.matches('\n')),
            }
        }
        files.push((*file, text));
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<String> {
        let mut names = Vec::new();
        for (file, excerpt) in needed([text].into_iter()) {
            assert_eq!(excerpt.lines().count(), file.text.lines().count(), "{}: places stay true", file.path);
            let excerpt: &'static str = excerpt.leak();
            names.extend(items(excerpt).into_iter().map(|item| item.name.to_string()));
        }
        names
    }

    #[test]
    fn only_what_is_named_is_read() {
        let names = names("let a = circle { diameter: 3 mm }");
        for name in ["job", "Tool", "Path", "circle", "Aperture", "mm", "m", "Length"] {
            assert!(names.iter().any(|n| n == name), "{name} in {names:?}");
        }
        for name in ["raster", "mrf_wheel", "annulus", "arcsec", "sin", "rapid"] {
            assert!(!names.iter().any(|n| n == name), "{name} in {names:?}");
        }
    }

    #[test]
    fn every_item_of_the_core_can_be_found() {
        for file in FILES.iter().filter(|file| file.core) {
            let (ast, _) = crate::syntax::parse(crate::source::FileId(0), file.text);
            assert_eq!(items(file.text).len(), ast.items.len(), "{}", file.path);
        }
    }
}
