//! Mistakes: each said once, in order of place, with its mend. The sentences are part of the language, so they stand
//! here as they are to read; `tests/ui` shows more of them as a person sees them.

use super::{compile_text, files, library, said};
use polishc::diagnostics::Severity;
use polishc::eval::{Options, compile};

/// Asserts what is said of a text, without notes and helps.
fn says(text: &str, expected: &[&str]) {
    let compiled = compile_text(text);
    let found: Vec<String> = said(&compiled)
        .iter()
        .map(|line| line.split(" | ").next().unwrap_or(line).split(" > ").next().unwrap_or(line).to_string())
        .collect();
    assert_eq!(found, expected, "{text}");
}

#[test]
fn values_and_dimensions_that_are_right() {
    for text in [
        "param a: Length = 0.5 mm",
        "param a: Length = -4 mm + 2 * 3 mm",
        "param a: Speed = tangential(60 rpm, 180 mm)",
        "param a: Length = arc(90 deg, 100 mm)",
        "param a: Area = pi / 4 * (40 mm)^2",
        "param a: Length = sqrt(4 mm^2)",
        "param a: Length = (4 mm^2)^(1/2)",
        "param a: Number = sin(30 deg) + abs(-1) * min(1, 2, 3) / max(1, 2)",
        "param a: Length^-3 = 1e-10 mm^-3",
        "param a: [Length] = [1600, 0, 700] mm",
        "param a: [Length; 2] = [1 mm, 2 um]",
        "param a: Length .. Length = 1 mm .. 2 mm",
        "param a: Length? = none",
        "param a: Length?",
        "param a: high | low = high",
        "param a: Bool = 3 mm < 4 mm and not (1 == 2)",
        "param a: Integer = 3 where 1 .. 4",
        "let high = digital_out { name: \"do1\", active: high, settle: 0 s }",
        "let base: frame = { at: { x: 0 mm, y: 0 mm, z: 0 mm }, rotation: no_rotation }\nlet x = base.at.x + 1 mm",
        "let centre: MapCentre = pixel_at { column: 3, row: 4 }\nlet origin: Origin = pixel_at { column: 3, row: 4 }",
        "family Finish\nschema rough : Finish { by: Length }\nlet f: Finish = rough { by: 1 mm }",
    ] {
        says(text, &[]);
    }
}

#[test]
fn values_are_what_arithmetic_says() {
    // tangential: 2 pi 1/s * 0.18 m; arc: pi/2 * 0.1 m; a circle of 40 mm: 400 pi mm^2.
    for (text, expected) in [
        ("param a: Speed = tangential(60 rpm, 180 mm)", "1130.97 mm/s"),
        ("param a: Length = arc(90 deg, 100 mm)", "157.08 mm"),
        ("param a: Area = pi / 4 * (40 mm)^2", "1256.64 mm^2"),
        ("param a: Length = (4 mm^2)^(1/2)", "2 mm"),
        ("param a: Number = 2^3 - 10 %", "7.9"),
        ("param a: [Length] = [1, 2.5] inch", "[25.4 mm, 63.5 mm]"),
    ] {
        let text = format!("language 1\n{text}\njob j {{}}\n");
        let compiled = compile(&files(&[("t.polish", &text)]), "t.polish", &Options::default());
        // The job lacks everything; the parameter's value is seen through a limit that it breaks.
        assert_eq!(compiled.diagnostics.len(), 1);
        let limited =
            text.replace("\njob", " where > 1e30\njob").replace("1e30", &format!("1e30 * {}", unit_of(&text)));
        let compiled = compile(&files(&[("t.polish", &limited)]), "t.polish", &Options::default());
        let first = compiled.diagnostics.first().expect("a broken limit");
        let values: Vec<&str> = expected.trim_matches(['[', ']']).split(", ").collect();
        assert!(first.message.starts_with(&format!("`a` is {}, and must be", values[0])), "{}", first.message);
    }
}

/// A unit of the dimension that the parameter declares, as a factor for its limit.
fn unit_of(text: &str) -> &'static str {
    match text {
        _ if text.contains(": Speed") => "(1 m/s)",
        _ if text.contains(": Area") => "(1 m^2)",
        _ if text.contains(": Number") => "1",
        _ => "(1 m)",
    }
}

#[test]
fn mistakes_in_values() {
    says("param p: Angle = 20", &["E0302 2:18 `p` expects an angle, found a plain number"]);
    says("param p: Length = 3 deg", &["E0303 2:19 `p` expects a length, found an angle"]);
    says("let x = 3 mm + 2 s", &["E0304 2:14 cannot add a length and a time"]);
    says("let x = \"a\" * 2", &["E0305 2:9 `*` needs numbers, found a text in quotes"]);
    says(
        "let x = (2 mm)^1.3",
        &["E0306 2:16 a quantity can be raised only to a power written as a number, such as `2` or `(1/2)`"],
    );
    // (1e-9)^60 is below the least double, 2.2e-308.
    says("let x = 1 nm^60", &["E0306 2:11 the power of this unit is too large"]);
    says("let x = nothing", &["E0201 2:9 there is no value `nothing`"]);
    says("let x = 1 / 0", &["E0406 2:9 `1 / 0` divides by zero"]);
    says("let x = 1e300 * 1e300", &["E0406 2:9 `1e300 * 1e300` is too large for a number"]);
    says("param n: Integer = 2.5", &["E0407 2:20 `n` is 2.5, and must be a whole number"]);
    says("param n: Integer = 1e30", &["E0407 2:20 `n` is 1e30, and must be a whole number"]);
    says("let x = [1 mm, 2 s]", &["E0303 2:16 this list expects a length, found a time"]);
    says("let x = [1, 2 mm] mm", &["E0303 2:13 a list with a unit after it expects a plain number, found a length"]);
    says("let x = { a: 1 }", &["E0410 2:9 this record does not say which kind it is"]);
    says("let x = frame", &["E0402 2:9 `frame` lacks `at` and `rotation`"]);
    says("let x: Text = none", &["E0301 2:15 `x` expects a text in quotes, found `none`"]);
    says("let a: Length? = none\nlet b: Length = a", &["E0301 3:17 `b` expects a length, and this may be `none`"]);
}

#[test]
fn one_mistake_is_one_diagnostic() {
    // What uses a failed value stays silent, and so does a record that holds one.
    says("let a = 3 mm + 2 s\nlet b = 2 * a\nparam c: Angle = b", &["E0304 2:14 cannot add a length and a time"]);
    says(
        "let a = 1 mm / 0\nlet b = 2 * a\nparam c: Length = b where > 1 mm",
        &["E0406 2:9 `1 mm / 0` divides by zero"],
    );
    says("let c = circle { diamter: 3 mm }", &["E0401 2:18 `circle` has no field `diamter`"]);
    says(
        "let c = circle { diamter: 3 s }",
        &["E0401 2:18 `circle` has no field `diamter`", "E0303 2:27 `diamter` expects a length, found a time"],
    );
    says(
        "let a = b\nlet b = c\nlet c = a",
        &["E0208 2:5 `a` is defined by itself: it uses `b`, which uses `c`, which uses `a`"],
    );
    says(
        "let a: Lenght = 3 mm\nlet b = a + 1 s",
        &["E0202 2:8 there is no type `Lenght`", "E0304 3:11 cannot add a length and a time"],
    );
}

#[test]
fn syntax_errors_make_no_noise() {
    for text in [
        "let a = \nlet b = a + 1 mm",
        "let a = 3 +* 2\nlet b = 2 * a",
        "let c = circle { diameter 3 mm }",
        "schema x {{ }\nlet c = x { a: 3 }",
        "job j { tool: mrf_wheel { diameter: } }",
    ] {
        let compiled = compile_text(text);
        let codes: Vec<&str> = compiled.diagnostics.iter().map(|d| d.code.as_str()).collect();
        assert!(
            codes.iter().all(|code| code.starts_with("E01")) && !codes.is_empty() || text.starts_with("job"),
            "{text}: {codes:?}"
        );
    }
}

#[test]
fn precession_on_a_wheel_names_the_fields_there_are() {
    let mut library = library();
    let flat = String::from_utf8(library.0["jobs/flat.polish"].clone()).expect("text");
    let flat = flat.replace("gap:      1 mm", "gap:      1 mm\n        precession: 20");
    library.0.insert("jobs/flat.polish".into(), flat.into_bytes());
    let options = Options { sets: vec![("map".into(), "m".into())], job: None };
    assert_eq!(
        said(&compile(&library, "jobs/flat.polish", &options)),
        [
            "E0401 44:9 `mrf_wheel` has no field `precession` | its fields: `diameter`, `speed`, `rotation`, `gap`, `azimuth` and `influence`"
        ]
    );
}

#[test]
fn files_that_cannot_be_used() {
    let options = Options::default();
    let missing = compile(&files(&[]), "no.polish", &options);
    assert_eq!(said(&missing), ["E0204 the file `no.polish` does not exist"]);
    let mut bytes = files(&[]);
    bytes.0.insert("b.polish".into(), vec![b'l', 0xff, 0xfe]);
    assert_eq!(
        said(&compile(&bytes, "b.polish", &options)),
        ["E0204 the file `b.polish` is no UTF-8 text: line 1 holds something else, save it as UTF-8"]
    );
    bytes.0.insert("large.polish".into(), vec![b' '; (4 << 20) + 1]);
    assert_eq!(
        said(&compile(&bytes, "large.polish", &options)),
        ["E0204 the file `large.polish` is too large: 4194305 bytes, at most 4194304 are read"]
    );
    let outside = files(&[("a.polish", "language 1\nuse \"../../x.polish\"\n")]);
    assert_eq!(compile(&outside, "a.polish", &options).diagnostics[0].code.as_str(), "E0205");
    let itself = files(&[("a.polish", "language 1\nuse \"a.polish\"\n")]);
    assert_eq!(
        said(&compile(&itself, "a.polish", &options)),
        ["E0209 2:5 the file `a.polish` uses itself > delete this line"]
    );
    // The same under another name of the first file.
    let dotted = compile(&itself, "./a.polish", &options);
    assert_eq!(said(&dotted).len(), 1, "{:?}", said(&dotted));
    let three = files(&[
        ("a.polish", "language 1\nuse \"b.polish\"\n"),
        ("b.polish", "language 1\nuse \"c.polish\"\n"),
        ("c.polish", "language 1\nuse \"b.polish\"\n"),
    ]);
    // The circle does not hold `a`.
    assert_eq!(
        said(&compile(&three, "a.polish", &options)),
        [
            "E0209 2:5 the file `b.polish` uses itself: it uses `c.polish`, which uses `b.polish` > move what both need into a third file"
        ]
    );
    // A file that two others use is no circle.
    let shared = files(&[
        ("a.polish", "language 1\nuse \"b.polish\"\nuse \"c.polish\"\nlet x = b.x + c.x\n"),
        ("b.polish", "language 1\nuse \"d.polish\"\npub let x = d.x\n"),
        ("c.polish", "language 1\nuse \"d.polish\"\npub let x = 2 * d.x\n"),
        ("d.polish", "language 1\npub let x = 1 mm\n"),
    ]);
    assert_eq!(said(&compile(&shared, "a.polish", &options)), Vec::<String>::new());
}

#[test]
fn too_many_files_are_refused_once() {
    let names: Vec<(String, String)> = (0..400)
        .map(|i| (format!("f{i}.polish"), format!("language 1\nuse \"f{}.polish\"\npub let x = {i}\n", i + 1)))
        .collect();
    let texts: Vec<(&str, &str)> = names.iter().map(|(n, t)| (n.as_str(), t.as_str())).collect();
    let compiled = compile(&files(&texts), "f0.polish", &Options::default());
    assert_eq!(said(&compiled), ["E0204 2:5 this job uses more than 256 files"]);
}

#[test]
fn no_text_exhausts_the_stack() {
    let sum = vec!["1"; 5000].join(" + ");
    let brackets = format!("{}1{}", "(".repeat(150), ")".repeat(150));
    let chain: String = (0..5000).map(|i| format!("let a{i} = a{}\n", i + 1)).collect::<String>() + "let a5000 = 1\n";
    let members = format!("x{}", ".a".repeat(5000));
    let records = "frame { at: ".repeat(150);
    for text in [
        format!("let x = {sum}"),
        format!("let x = {brackets}"),
        chain,
        format!("let y = {members}"),
        format!("let y = {records}"),
        format!("let x = {}1", "-".repeat(5000)),
        format!("let x = {}", vec!["1 mm"; 5000].join(" with { a: 3 } + ")),
    ] {
        let compiled = compile_text(&text);
        assert!(compiled.diagnostics.len() < 1100, "{} diagnostics", compiled.diagnostics.len());
        assert!(compiled.diagnostics.iter().filter(|d| d.code.as_str() == "E0412").count() <= 1);
    }
    let deep: String = (0..300).map(|i| format!("let a{i} = a{}\n", i + 1)).collect::<String>() + "let a300 = 1\n";
    assert_eq!(compile_text(&deep).diagnostics.iter().map(|d| d.code.as_str()).collect::<Vec<_>>(), ["E0412"]);
}

#[test]
fn no_text_exhausts_the_memory() {
    // Lists of lists: 10 to the power of the nesting. A schema that holds itself: without end.
    let tens: String =
        (1..30).map(|i| format!("let a{i} = [{}]\n", vec![format!("a{}", i - 1); 10].join(", "))).collect();
    let compiled = compile_text(&format!("let a0 = [1, 2]\n{tens}"));
    let codes: Vec<&str> = compiled.diagnostics.iter().map(|d| d.code.as_str()).collect();
    // 2 * 10^4 values are too many; the types go on to the nesting of eight.
    assert_eq!(codes, ["E0413", "E0412"]);
    let deep: String = (1..20_000).map(|i| format!("let a{i} = [a{}]\n", i - 1)).collect();
    let compiled = compile_text(&format!("let a0 = [1]\n{deep}"));
    assert_eq!(compiled.diagnostics.iter().map(|d| d.code.as_str()).collect::<Vec<_>>(), ["E0412"]);
    says(
        "schema link { next: link = link {} }\nlet chain = link {}",
        &["E0412 2:28 working this out goes more than 400 values deep"],
    );
}

#[test]
fn warnings_do_not_stop_a_job() {
    let mut library = library();
    let flat = String::from_utf8(library.0["jobs/flat.polish"].clone()).expect("text");
    let flat = flat.replace("gap:      1 mm", "gap:      10 mm");
    library.0.insert("jobs/flat.polish".into(), flat.into_bytes());
    let options = Options { sets: vec![("map".into(), "m".into())], job: None };
    let compiled = compile(&library, "jobs/flat.polish", &options);
    assert_eq!(compiled.jobs.len(), 1);
    let [warning] = compiled.diagnostics.as_slice() else { panic!("one warning") };
    assert_eq!((warning.code.as_str(), warning.severity), ("W0401", Severity::Warning));
    assert_eq!(warning.message, "`gap` is 10 mm, which is unusual: it is mostly 0.2 mm .. 5 mm");
}

#[test]
fn every_field_of_a_job_dropped_misspelt_doubled_or_plain_is_one_error_at_its_place() {
    let whole = library();
    let flat = String::from_utf8(whole.0["jobs/flat.polish"].clone()).expect("text");
    let options = Options { sets: vec![("map".into(), "m".into())], job: None };
    let mut tried = 0;
    // The one-line fields of the job itself: `name: value` from the job's bracket on.
    let start = flat.find("job flat_340").expect("the job");
    let mut offset = 0;
    for line in flat.split_inclusive('\n') {
        let at = offset;
        offset += line.len();
        let field = line.trim();
        let Some((name, value)) = field.split_once(':') else { continue };
        // The fixture's lines with several fields, blocks and optional fields are not for this test.
        let simple = at > start
            && name.chars().all(|c| c.is_ascii_lowercase() || c == '_')
            && !value.contains(['{', '[', ','])
            && !["x_mark", "fill_below", "holes"].contains(&name);
        if !simple {
            continue;
        }
        let number = value.trim().split(' ').next().is_some_and(|word| word.parse::<f64>().is_ok());
        let dropped = (String::new(), "E0402");
        let doubled = (format!("{line}{line}"), "E0403");
        let misspelt = (line.replacen(name, &format!("{name}q"), 1), "E0401");
        let unitless = (line.replacen(value.trim(), "7", 1), "E0302");
        let mut mutations = vec![doubled, misspelt];
        if name != "wavelength" {
            mutations.push(dropped);
        }
        if number && value.trim().contains(' ') && !value.contains('%') && !value.contains("..") {
            mutations.push(unitless);
        }
        for (mutation, code) in mutations {
            let text = format!("{}{mutation}{}", &flat[..at], &flat[offset..]);
            let mut mutated = whole.clone();
            mutated.0.insert("jobs/flat.polish".into(), text.clone().into_bytes());
            let compiled = compile(&mutated, "jobs/flat.polish", &options);
            // Without its wavelength the job's `wave` has no meaning, but a misspelt or doubled one is understood.
            let said = said(&compiled);
            let [one] = compiled.diagnostics.as_slice() else { panic!("{name}: {said:?}") };
            assert_eq!(one.code.as_str(), code, "{name}: {said:?}");
            let place = one.primary.as_ref().expect("a place").span.start as usize;
            if code != "E0402" {
                assert!((at..at + mutation.len()).contains(&place), "{name}: {said:?}");
            }
            tried += 1;
        }
    }
    assert!(tried > 50, "only {tried} mutations were tried");
}

#[test]
fn every_mend_mends() {
    // A text with a mistake, applied suggestions, and the mistake is gone.
    for text in [
        "param p: Angle = 20",
        "param p: Length = -5",
        "let x = 3 mm + 2",
        "let c = circle { diamter: 3 mm }",
        "let c = circel { diameter: 3 mm }",
        "param p: Lenght = 3 mm",
        "param p: high | low = \"high\"",
        "let gap = 1 MM",
        "let rim = tangental(60 rpm, 180 mm)",
        "let pitch = 1 mm\nlet y = 2 * ptich",
        "let o: Origin = centriod",
        "param p: [Length] = 3 mm",
        "let p = raster { over: circle { diameter: 9 mm }, point_step: 1 mm, line_pitch: 1 mm, lines: serpentin }",
    ] {
        let source = format!("language 1\n{text}\n");
        let compiled = compile(&files(&[("t.polish", &source)]), "t.polish", &Options::default());
        let [one] = compiled.diagnostics.as_slice() else { panic!("{text}: {:?}", said(&compiled)) };
        let [suggestion] = one.suggestions.as_slice() else { panic!("{text}: no suggestion") };
        let (start, end) = (suggestion.span.start as usize, suggestion.span.end as usize);
        let mended = format!("{}{}{}", &source[..start], suggestion.replacement, &source[end..]);
        let again = compile(&files(&[("t.polish", &mended)]), "t.polish", &Options::default());
        assert_eq!(said(&again), Vec::<String>::new(), "{mended}");
    }
}

#[test]
fn no_cut_in_a_job_breaks_the_compiler() {
    // Every 23rd place: a few letters taken out, or a bracket put in. Whatever is said, it is in order of place,
    // it is said once, and no job comes out of a text with an error.
    let whole = library();
    let flat = String::from_utf8(whole.0["jobs/flat.polish"].clone()).expect("text");
    let options = Options { sets: vec![("map".into(), "m".into())], job: None };
    for at in (0..flat.len() - 4).step_by(23).filter(|at| flat.is_char_boundary(*at) && flat.is_char_boundary(at + 3)) {
        for (removed, inserted) in [(3, ""), (0, "}"), (1, "9")] {
            if !flat.is_char_boundary(at + removed) {
                continue;
            }
            let text = format!("{}{inserted}{}", &flat[..at], &flat[at + removed..]);
            let mut cut = whole.clone();
            cut.0.insert("jobs/flat.polish".into(), text.into_bytes());
            let compiled = compile(&cut, "jobs/flat.polish", &options);
            let errors = compiled.diagnostics.iter().any(|d| d.severity == Severity::Error);
            assert!(!errors || compiled.jobs.is_empty(), "a job with errors");
            let places: Vec<_> =
                compiled.diagnostics.iter().map(|d| d.primary.as_ref().map(|p| (p.span.file, p.span.start))).collect();
            assert!(places.is_sorted(), "{:?}", said(&compiled));
            let lines = said(&compiled);
            assert!(lines.iter().all(|line| lines.iter().filter(|other| *other == line).count() == 1), "{lines:?}");
        }
    }
}
