//! The manual: every word of stdlib is in it, in the terminal's form and on the page, and every link leads somewhere.

use polishc::doc::{Found, Kind, Manual, brief, html, text};
use polishc::eval;
use std::collections::{BTreeMap, BTreeSet};

#[test]
fn every_word_of_stdlib_is_told() {
    let manual = Manual::new();
    let library = eval::library();
    for schema in &library.vocabulary.schemas {
        let Found::Words(found) = manual.find(&schema.name) else { panic!("`{}` is not found", schema.name) };
        let told: String = found.iter().map(|(module, entry)| text::entry(&manual, module, entry)).collect();
        for field in &schema.fields {
            assert!(told.contains(&format!("{}: {}", field.name, field.type_text)), "{}.{}", schema.name, field.name);
            let doc: Vec<&str> = field.doc.split_whitespace().collect();
            let words: Vec<&str> = told.split_whitespace().collect();
            assert!(words.windows(doc.len().max(1)).any(|part| doc.is_empty() || part == doc), "{}", field.name);
            assert!(
                matches!(manual.find(&format!("{}.{}", schema.name, field.name)), Found::Fields(_)),
                "{}",
                field.name
            );
        }
    }
    let units = library.vocabulary.units.unit_names().chain(library.vocabulary.units.dimension_names());
    for name in units.chain(library.vocabulary.families.iter().map(|family| family.name.as_str())) {
        assert!(matches!(manual.find(name), Found::Words(_)), "{name}");
    }
    for (module, entry) in manual.entries() {
        let told = text::entry(&manual, module, entry);
        assert!(told.ends_with('\n') && told.lines().all(|line| line.trim_end() == line), "{told}");
        assert!(!told.contains("\n\n\n"), "{told}");
        assert!(text::overview(&manual).contains(&entry.name), "{}", entry.name);
    }
}

#[test]
fn values_say_how_they_are_brought() {
    let manual = Manual::new();
    for name in ["irc5", "std.controllers.irc5"] {
        let Found::Words(found) = manual.find(name) else { panic!("{name}") };
        assert_eq!(found.len(), 1);
        let (module, entry) = found[0];
        assert!(matches!(&entry.kind, Kind::Value { schema, .. } if schema.contains("controller")));
        assert!(text::entry(&manual, module, entry).contains("\nuse std.controllers.irc5\n"));
    }
    assert!(matches!(manual.find("rastr"), Found::Near(near) if near == "raster"));
    assert!(matches!(manual.find("xyzzy_plugh"), Found::Nothing));
}

#[test]
fn the_first_sentence_ends_at_its_point() {
    for (doc, expected) in [
        ("A flat: z = 0. More.", "A flat: z = 0"),
        ("At 0.5 mm. More.", "At 0.5 mm"),
        ("No point\nat all\n\nMore.", "No point\nat all"),
        ("", ""),
    ] {
        assert_eq!(brief(doc), expected);
    }
}

/// The page is well formed: every element is closed in order, every anchor stands once, every link has its anchor.
#[test]
fn the_page_is_whole() {
    let page = html::page(&Manual::new(), "0.0.0");
    let (mut open, mut anchors, mut links) = (Vec::new(), BTreeMap::new(), BTreeSet::new());
    let body = page.replace("<!doctype html>", "");
    for piece in body.split('<').skip(1) {
        let (tag, _) = piece.split_once('>').expect("the end of a tag");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "in `<{piece}`");
            continue;
        }
        let (name, rest) = tag.split_once(' ').unwrap_or((tag, ""));
        if name != "meta" {
            open.push(name);
        }
        for (attribute, found) in [("id=\"", true), ("href=\"#", false)] {
            let Some(at) = rest.find(attribute) else { continue };
            let value = &rest[at + attribute.len()..];
            let value = value[..value.find('"').expect("the end of a value")].to_string();
            match found {
                true => *anchors.entry(value).or_insert(0) += 1,
                false => drop(links.insert(value)),
            }
        }
    }
    assert!(open.is_empty(), "{open:?}");
    let twice: Vec<_> = anchors.iter().filter(|(_, count)| **count > 1).collect();
    assert!(twice.is_empty(), "{twice:?}");
    let nowhere: Vec<_> = links.iter().filter(|link| !anchors.contains_key(*link)).collect();
    assert!(nowhere.is_empty(), "{nowhere:?}");
    assert!(links.len() > 300, "{}", links.len());
    assert!(!page.contains("<script") && !page.contains("http"), "the page needs nothing from elsewhere");
}
