//! Functions: what they come to, and the examples of stdlib, which are run.

use super::{compile_text, said};
use polishc::check::typed::Function;
use polishc::eval;

/// The lines of the code blocks of a doc comment.
fn examples(doc: &str) -> Vec<&str> {
    let mut inside = false;
    let mut lines = Vec::new();
    for line in doc.lines() {
        if line.starts_with("```") {
            inside = !inside;
        } else if inside && !line.trim().is_empty() {
            lines.push(line);
        }
    }
    lines
}

#[test]
fn every_function_of_stdlib_has_examples_that_hold() {
    let library = eval::library();
    assert_eq!(said(&library), Vec::<String>::new());
    let mut wrong = Vec::new();
    for function in &library.vocabulary.functions {
        let examples = examples(&function.doc);
        assert!(!examples.is_empty(), "`{}` has no example", function.name);
        for example in examples {
            assert!(example.contains(&format!("{}(", function.name)), "`{example}` does not show `{}`", function.name);
            let done = compile_text(&format!("assert {example} because \"the example holds\""));
            wrong.extend(said(&done).into_iter().map(|text| format!("{}: {example}: {text}", function.name)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn an_example_that_does_not_hold_is_found() {
    let done = compile_text("assert sin(90 deg) == 2 because \"the example holds\"");
    assert!(said(&done)[0].starts_with("E0414"), "{:?}", said(&done));
}

#[test]
fn the_compiler_has_a_body_for_every_declaration_without_one_and_the_other_way_round() {
    let library = eval::library();
    let names: Vec<&str> = library.vocabulary.functions.iter().map(|f| f.name.as_str()).collect();
    for (name, _) in Function::ALL {
        assert!(names.contains(&name), "`{name}` is not declared in stdlib/functions.polish");
    }
    // A declaration without a body whose name is not in the table is refused by `check`, as `library` shows.
    let signature = |name: &str| {
        library.vocabulary.functions.iter().find(|f| f.name == name).map(|f| f.signature.as_str()).unwrap_or_default()
    };
    assert_eq!(signature("sin"), "fn sin(angle: Angle) -> Number");
    assert_eq!(signature("circle_area"), "fn circle_area(diameter: Length) -> Area");
}

/// All of these hold, so nothing is said.
#[test]
fn what_functions_choices_and_lists_come_to() {
    let done = compile_text(
        r#"
        param rough: Bool = true
        fn square(x: Length) -> Area = x^2
        fn hypotenuse(a: Length, b: Length) -> Length = sqrt(square(a) + square(b))
        fn larger(a: Length, b: Length) -> Length = if a > b then a else b
        fn mean(values: [Length]) -> Length = sum(values) / count(values)
        fn half(i: Integer) -> Integer = i / 2
        fn twice(f: raster) -> raster = f with { line_pitch: 2 * f.line_pitch }
        fn side(out: Bool) -> high | low = if out then high else low

        let lines = raster { over: circle { diameter: 9 mm }, point_step: 1 mm, line_pitch: 1 mm, lines: one_way }
        // 3-4-5.
        assert hypotenuse(3 mm, 4 mm) == 5 mm because "Pythagoras"
        assert larger(3 mm, 4 mm) == 4 mm because "chosen"
        assert abs(mean([1 mm, 2 mm, 6 mm]) - 3 mm) < 1e-9 mm because "9 / 3"
        assert abs(mean([1 mm * i for i in 1 .. 5]) - 3 mm) < 1e-9 mm because "15 / 5"
        assert sum([i * j * (if i == j then 1 else 0) for i in 2 .. 2]) == 4 because "one element"
        assert half(4) == 2 because "whole"
        assert twice(lines).line_pitch == 2 mm because "copied"
        assert lines.line_pitch == 1 mm because "and left as it was"
        assert count([i for i in -2 .. 2]) == 5 because "both ends count"
        assert sum([sum([i * k for k in 1 .. 2]) for i in 1 .. 3]) == 18 because "3 * (1 + 2 + 3)"
        assert (if rough then 2 mm else 1 mm / 0) == 2 mm because "only the chosen branch is worked out"
        assert rough or 1 / 0 > 1 because "the first side decides"
        assert not (not rough and 1 / 0 > 1) because "here too"
        let turned: [Angle; 4] = [90 * i for i in 0 .. 3] deg
        assert sum(turned) == 540 deg because "0 + 90 + 180 + 270"
        let j = 2
        let nothing: Length? = if rough then none else 1 mm
        "#,
    );
    assert_eq!(said(&done), Vec::<String>::new());
}

#[test]
fn numbers_that_are_none_are_refused_where_they_arise() {
    for (text, code, place) in [
        ("let a = asin(2)", "E0406", "2:9"),
        ("let a = sqrt(-1)", "E0406", "2:9"),
        ("let a = sqrt(-1 mm^2)", "E0406", "2:9"),
        ("let a = 1 / (1 - 1)", "E0406", "2:9"),
        ("let a = 1e300 * 1e300", "E0406", "2:9"),
        ("let a = (-8)^(1/3)", "E0406", "2:9"),
        ("let a = 10^400", "E0406", "2:9"),
        ("let a = (1 mm)^1000000000000", "E0306", "2:16"),
        ("let a = (1e-300 mm)^2 * 1 mm^-2 / (0 mm)^0 / 0", "E0406", "2:9"),
        ("let a = 5 mm .. 3 mm", "E0409", "2:9"),
        ("fn f(i: Integer) -> Integer = i / 2\nlet a = f(3)", "E0407", "2:31"),
        ("fn f(i: Integer) -> Number = i / 2\nlet a = f(2.5)", "E0407", "3:11"),
        ("let a = [1 mm for i in 3 .. 1]", "E0409", "2:24"),
        ("let a = [[1 mm for i in 1 .. 200] for j in 1 .. 200]", "E0413", "2:9"),
        ("let a = max(1 mm)", "E0307", "2:9"),
        ("let a: [Angle; 3] = [1 deg * i for i in 1 .. 4]", "E0310", "2:21"),
    ] {
        let said = said(&compile_text(text));
        assert_eq!(said.len(), 1, "{text}: {said:?}");
        assert!(said[0].starts_with(&format!("{code} {place} ")), "{text}: {said:?}");
    }
}
