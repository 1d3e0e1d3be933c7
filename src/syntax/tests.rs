//! Tests of the whole parser. Tests of one step stand beside it.

use super::ast::*;
use super::parse;
use crate::diagnostics::Diagnostic;
use crate::source::FileId;
use crate::syntax::tokens::TokenKind;
use std::collections::BTreeMap;

pub(super) const JOB: &str = include_str!("../../tests/syntax/flat_340.polish");

pub(super) const FILES: &[(&str, &str)] = &[
    ("flat_340", JOB),
    ("asphere_400", include_str!("../../tests/syntax/asphere_400.polish")),
    ("k9_200", include_str!("../../tests/syntax/k9_200.polish")),
    ("sphere_200", include_str!("../../tests/syntax/sphere_200.polish")),
    ("spot_test", include_str!("../../tests/syntax/spot_test.polish")),
    ("cell", include_str!("../../tests/syntax/cell.polish")),
    ("schemas", include_str!("../../tests/syntax/schemas.polish")),
];

pub(super) fn read(text: &str) -> (Ast, Vec<Diagnostic>) {
    parse(FileId(0), text)
}

pub(super) fn show(text: &str, d: &Diagnostic) -> String {
    let p = d.primary.as_ref().unwrap().span;
    format!("{} {} @{}..{} `{}`", d.code, d.message, p.start, p.end, &text[p.start as usize..p.end as usize])
}

/// The paths of all entries with a value, as `job.workpiece.edge.outer_diameter`, with how often each occurs.
pub(super) fn entry_paths(ast: &Ast) -> BTreeMap<String, usize> {
    fn value(path: &str, expr: &Expr, paths: &mut BTreeMap<String, usize>) {
        match &expr.kind {
            ExprKind::Record { body, .. } => block(path, body, paths),
            ExprKind::With(base, body) => {
                value(path, base, paths);
                block(path, body, paths);
            }
            ExprKind::List(elements, _) => elements.iter().for_each(|element| {
                *paths.entry(format!("{path}[]")).or_default() += usize::from(element.kind != ExprKind::Missing);
                value(&format!("{path}[]"), element, paths);
            }),
            _ => {}
        }
    }
    fn block(path: &str, body: &Block, paths: &mut BTreeMap<String, usize>) {
        for entry in &body.entries {
            let (name, expr) = match &entry.kind {
                EntryKind::Field { name, value } => (name.text.as_str(), value),
                EntryKind::Expr(value) => ("", value),
            };
            let path = format!("{path}.{name}");
            *paths.entry(path.clone()).or_default() += usize::from(expr.kind != ExprKind::Missing);
            value(&path, expr, paths);
        }
    }
    let mut paths = BTreeMap::new();
    for item in &ast.items {
        let name = match &item.kind {
            ItemKind::Use(_) => "use",
            ItemKind::Let { .. } | ItemKind::Param { .. } => "value",
            ItemKind::Job { body, .. } => {
                block("job", body, &mut paths);
                "job"
            }
            _ => "other",
        };
        *paths.entry(name.to_string()).or_default() += 1;
    }
    paths
}

/// The text with all suggestions put in, the last place first.
pub(super) fn mended(text: &str, said: &[Diagnostic]) -> String {
    let mut suggestions: Vec<_> = said.iter().flat_map(|d| &d.suggestions).collect();
    suggestions.sort_by_key(|s| std::cmp::Reverse((s.span.start, s.span.end)));
    let mut text = text.to_string();
    for s in suggestions {
        text.replace_range(s.span.start as usize..s.span.end as usize, &s.replacement);
    }
    text
}

/// A value in prefix form: `(+ 1 (* 2 x))`.
fn prefix(expr: &Expr) -> String {
    let unit = |unit: &Unit| {
        let factors: Vec<String> = unit.factors.iter().map(|(name, power)| format!("{}^{power}", name.text)).collect();
        factors.join("·")
    };
    let all = |exprs: &[Expr]| exprs.iter().map(prefix).collect::<Vec<_>>().join(" ");
    match &expr.kind {
        ExprKind::Number(value) => format!("{value}"),
        ExprKind::Quantity { value, unit: u } => format!("{value}[{}]", unit(u)),
        ExprKind::Text(text) => format!("{text:?}"),
        ExprKind::Bool(value) => format!("{value}"),
        ExprKind::None => "none".to_string(),
        ExprKind::Name(name) => name.clone(),
        ExprKind::Member(of, name) => format!("{}.{}", prefix(of), name.text),
        ExprKind::Call(callee, arguments) => format!("({} {})", prefix(callee), all(arguments)),
        ExprKind::Record { schema, body } => {
            format!("{}{}", schema.as_ref().map_or("", |name| &name.text), prefix_block(body))
        }
        ExprKind::With(of, body) => format!("(with {} {})", prefix(of), prefix_block(body)),
        ExprKind::List(elements, None) => format!("[{}]", all(elements)),
        ExprKind::List(elements, Some(u)) => format!("[{}][{}]", all(elements), unit(u)),
        ExprKind::Comprehension { element, variable, over, unit: u } => {
            let u = u.as_ref().map_or_else(String::new, |u| format!("[{}]", unit(u)));
            format!("(for {} {} {}){u}", variable.text, prefix(over), prefix(element))
        }
        ExprKind::If { branches, otherwise } => {
            let branches: Vec<String> =
                branches.iter().map(|(condition, value)| format!("{} {}", prefix(condition), prefix(value))).collect();
            format!("(if {} {})", branches.join(" "), prefix(otherwise))
        }
        ExprKind::Range(low, high) => format!("(.. {} {})", prefix(low), prefix(high)),
        ExprKind::Unary(op, of) => format!("({} {})", if *op == UnaryOp::Minus { "-" } else { "not" }, prefix(of)),
        ExprKind::Binary(op, _, left, right) => format!("({} {} {})", sign(*op), prefix(left), prefix(right)),
        ExprKind::Missing => "?".to_string(),
    }
}

fn prefix_block(body: &Block) -> String {
    let entries: Vec<String> = body
        .entries
        .iter()
        .map(|entry| match &entry.kind {
            EntryKind::Field { name, value } => format!("{}:{}", name.text, prefix(value)),
            EntryKind::Expr(value) => prefix(value),
        })
        .collect();
    format!("{{{}}}", entries.join(" "))
}

fn sign(op: BinaryOp) -> &'static str {
    use BinaryOp as B;
    match op {
        B::Add => "+",
        B::Subtract => "-",
        B::Multiply => "*",
        B::Divide => "/",
        B::Power => "^",
        B::Less => "<",
        B::LessEqual => "<=",
        B::Greater => ">",
        B::GreaterEqual => ">=",
        B::Equal => "==",
        B::NotEqual => "!=",
        B::And => "and",
        B::Or => "or",
    }
}

/// A type in prefix form.
fn prefix_type(ty: &Type) -> String {
    match &ty.kind {
        TypeKind::Named(name) => name.clone(),
        TypeKind::Product(left, right) => format!("(* {} {})", prefix_type(left), prefix_type(right)),
        TypeKind::Quotient(left, right) => format!("(/ {} {})", prefix_type(left), prefix_type(right)),
        TypeKind::Power(base, above, below) => format!("(^ {} {above}/{below})", prefix_type(base)),
        TypeKind::List(of, None) => format!("[{}]", prefix_type(of)),
        TypeKind::List(of, Some(count)) => format!("[{};{count}]", prefix_type(of)),
        TypeKind::Range(of) => format!("(.. {})", prefix_type(of)),
        TypeKind::Optional(of) => format!("{}?", prefix_type(of)),
        TypeKind::Symbols(symbols) => {
            let symbols: Vec<String> = symbols.iter().map(|(name, doc)| format!("{}<{doc}>", name.text)).collect();
            symbols.join("|")
        }
    }
}

/// The value of `let a = …`, in prefix form, and the diagnostics.
fn value_of(text: &str) -> (String, Vec<&'static str>) {
    let text = format!("language 1\nlet a = {text}\n");
    let (ast, said) = read(&text);
    let value = ast.items.iter().find_map(|item| match &item.kind {
        ItemKind::Let { value, .. } => Some(prefix(value)),
        _ => None,
    });
    (value.unwrap_or_default(), said.iter().map(|d| d.code.as_str()).collect())
}

pub(super) fn is_meaningful(kind: TokenKind) -> bool {
    !matches!(kind, TokenKind::Blank | TokenKind::Newline | TokenKind::Comment { .. } | TokenKind::Doc)
}

// ---- what is read

#[test]
fn choices_and_repetitions() {
    for (text, tree) in [
        ("if a then b else c", "(if a b c)"),
        ("if a < 1 then 2 mm else if b then 3 mm else 4 mm", "(if (< a 1) 2[mm^1] b 3[mm^1] 4[mm^1])"),
        ("1 + (if a then b else c)", "(+ 1 (if a b c))"),
        ("(if a then (if b then c else d) else e) * 2", "(* (if a (if b c d) e) 2)"),
        // Both go on over lines at their words.
        ("if a\n    then b\n    else c", "(if a b c)"),
        ("[90 deg * i for i in 0 .. 3]", "(for i (.. 0 3) (* 90[deg^1] i))"),
        ("[90 * i for i in 0 .. 3] deg", "(for i (.. 0 3) (* 90 i))[deg^1]"),
        ("[place { x: 1 mm * i }\n    for i in 1 .. n]", "(for i (.. 1 n) place{x:(* 1[mm^1] i)})"),
        ("[[i * j for j in 1 .. 2] for i in 1 .. 2]", "(for i (.. 1 2) (for j (.. 1 2) (* i j)))"),
        ("[if i == 1 then 2 else 3 for i in 1 .. 2]", "(for i (.. 1 2) (if (== i 1) 2 3))"),
    ] {
        assert_eq!(value_of(text), (tree.to_string(), Vec::new()), "{text}");
    }
    // A chain is as long as the entry may be: its depth is not counted in stack.
    let chain = format!("{} 0", "if a then 1 else".to_string() + &" if b then 2 else".repeat(150));
    assert_eq!(value_of(&chain).1, Vec::<&str>::new());
}

#[test]
fn functions_asserts_and_allow_lines() {
    let text = "language 1\n\n/// Of a circle.\npub fn area(d: Length, k: [Number; 2],) -> Area\n    = d^2\n\
                assert (area(1 mm, [1, 2]) > 0 mm^2)\n    because \"so\"\n\
                allow W0401 because \"first\"\nparam gap: Length = 1 mm where > 0 mm usual 1 mm .. 2 mm\n\
                job x {\n/// doc\nallow W0700 because \"second\"\na: [\n    allow W0702 because \"third\"\n    1\n]\n}\n";
    let (ast, said) = read(text);
    assert_eq!(said, Vec::new());
    let [function, assert, param, job] = ast.items.as_slice() else { panic!("four items") };
    let ItemKind::Function { name, parameters, body: Some(body), .. } = &function.kind else { panic!("a function") };
    let types: Vec<String> = parameters.iter().map(|p| format!("{}: {}", p.name.text, prefix_type(&p.ty))).collect();
    assert_eq!((name.text.as_str(), prefix(body).as_str()), ("area", "(^ d 2)"));
    assert_eq!(types, ["d: Length", "k: [Number;2]"]);
    assert!(function.public && function.doc == "Of a circle.");
    let ItemKind::Assert { reason, .. } = &assert.kind else { panic!("an assert") };
    assert_eq!(reason, "so");
    assert!(matches!(&param.kind, ItemKind::Param { usual: Some(_), restriction: Some(_), .. }));
    let ItemKind::Job { body, .. } = &job.kind else { panic!("a job") };
    assert_eq!(body.entries.len(), 1, "an `allow` is no entry of the tree");
    assert_eq!(body.entries[0].doc, "doc", "the doc comment belongs to the entry after the `allow`");
    let allows: Vec<(&str, &str, &str)> = ast
        .allows
        .iter()
        .map(|a| (a.code.text.as_str(), a.reason.as_str(), &text[a.target.start as usize..a.target.end as usize]))
        .collect();
    assert_eq!(allows.len(), 3);
    assert_eq!((allows[0].0, allows[0].1), ("W0401", "first"));
    assert!(allows[0].2.starts_with("param gap"));
    assert!(allows[1].2.starts_with("a: ["), "{allows:?}");
    assert_eq!(allows[2], ("W0702", "third", "1"));
}

#[test]
fn the_design_files_are_read_without_a_word() {
    for (name, text) in FILES {
        let (_, said) = read(text);
        let said: Vec<String> = said.iter().map(|d| show(text, d)).collect();
        assert_eq!(said, Vec::<String>::new(), "{name}");
    }
}

#[test]
fn the_example_job_gives_the_tree_that_it_says() {
    let (ast, _) = read(JOB);
    assert_eq!(ast.language.map(|(number, span)| (number, span.start, span.end)), Some((1, 0, 10)));
    let kinds: Vec<String> = ast
        .items
        .iter()
        .map(|item| match &item.kind {
            ItemKind::Use(UsePath::Module(words)) => {
                words.iter().map(|word| word.text.as_str()).collect::<Vec<_>>().join(".")
            }
            ItemKind::Use(UsePath::File { path, .. }) => format!("{path:?}"),
            ItemKind::Param { name, ty, value, restriction, .. } => {
                assert_eq!(item.doc, "Distance between raster lines.");
                assert_eq!(*restriction, None);
                format!("{}: {} = {}", name.text, prefix_type(ty), prefix(value.as_ref().unwrap()))
            }
            ItemKind::Job { name, .. } => format!("job {}", name.text),
            other => format!("{other:?}"),
        })
        .collect();
    assert_eq!(
        kinds,
        [
            "std.robots.abb.irb6700_200_260",
            "std.controllers.irc5",
            "std.materials.fused_silica",
            "\"../cell.polish\"",
            "pitch: Length = 0.5[mm^1]",
            "job flat_340"
        ]
    );
    let Some(ItemKind::Job { body, .. }) = ast.items.last().map(|item| &item.kind) else { panic!("a job") };
    let field = |wanted: &str| {
        body.entries
            .iter()
            .find_map(|entry| match &entry.kind {
                EntryKind::Field { name, value } if name.text == wanted => Some(prefix(value)),
                _ => None,
            })
            .unwrap_or_default()
    };
    assert_eq!(field("wavelength"), "632.8[nm^1]");
    assert_eq!(
        field("workpiece"),
        "workpiece{part:\"FS340-07\" x_mark:\"engraved line at the edge\" form:plane \
         edge:annulus{outer_diameter:340[mm^1] inner_diameter:60[mm^1]} \
         clear:annulus{outer_diameter:323[mm^1] inner_diameter:70[mm^1]} material:fused_silica \
         error:height_map{file:\"metrology/flat_340.dat\" quantity:surface positive:high view:from_tool_side \
         up:plus_y subtract:[piston tilt]}}"
    );
    assert_eq!(
        field("dwell"),
        "corrective{removal_fraction:80[%^1] piston:free{at_most:20[nm^1]} \
         feed:(.. 0.2[mm^1·s^-1] 100[mm^1·s^-1]) acceleration:500[mm^1·s^-2]}"
    );
    assert_eq!(field("robot"), "(with irb6700_200_260 {cell:cell.mrf})");
    assert_eq!(
        field("require"),
        "require{(<= result.predicted.rms (/ 1[wave^1] 60)) (<= result.trajectory.range 0.1[mm^1]) \
         (<= result.motion.time 3[h^1]) (>= result.motion.joint_margin 5[deg^1])}"
    );
    assert!(field("compensation").contains("stages:[stage{mode:no_load runs:[run{program:\"out/a1\""));
}

#[test]
fn operators_bind_as_the_language_says() {
    for (text, tree) in [
        ("-2^2 + 3 * x", "(+ (- (^ 2 2)) (* 3 x))"),
        ("a - b - c / d / e", "(- (- a b) (/ (/ c d) e))"),
        ("not a == b and c or d", "(or (and (not (== a b)) c) d)"),
        ("2 ^ -n", "(^ 2 (- n))"),
        ("- -x", "(- (- x))"),
        ("a.b.c + f(1, g(2), )", "(+ a.b.c (f 1 (g 2)))"),
        ("a .. b + 1", "(.. a (+ b 1))"),
        ("(a .. b) == (c .. d)", "(== (.. a b) (.. c d))"),
        ("x.y with { z: 3 } with { w: 4 }", "(with (with x.y {z:3}) {w:4})"),
        ("2 * (3 + 4)", "(* 2 (+ 3 4))"),
        ("true and none", "(and true none)"),
        ("a.in.where", "a.in.where"),
        ("[1600, 0, 700] mm", "[1600 0 700][mm^1]"),
        ("[1, 2,]", "[1 2]"),
        ("[]", "[]"),
        ("{ in: 3, where: 4 }", "{in:3 where:4}"),
        (r#""a \" b \\ c \n""#, r#""a \" b \\ c \n""#),
    ] {
        assert_eq!(value_of(text), (tree.to_string(), vec![]), "{text}");
    }
}

#[test]
fn units_are_unspaced_and_everything_else_is_an_operator() {
    for (text, tree) in [
        ("4 mm", "4[mm^1]"),
        ("4mm", "4[mm^1]"),
        ("1e-10 mm^-3", "0.0000000001[mm^-3]"),
        ("500 mm/s^2", "500[mm^1·s^-2]"),
        ("15 Pa*s", "15[Pa^1·s^1]"),
        ("2.0e-7 mm^2/N", "0.0000002[mm^2·N^-1]"),
        ("5 %", "5[%^1]"),
        ("10 % * depth", "(* 10[%^1] depth)"),
        ("10 mm / s", "(/ 10[mm^1] s)"),
        ("90 deg * i", "(* 90[deg^1] i)"),
        ("4 mm*2", "(* 4[mm^1] 2)"),
        ("(4 mm)^2", "(^ 4[mm^1] 2)"),
        ("1 wave / 20", "(/ 1[wave^1] 20)"),
        ("1 / (20 wave)", "(/ 1 20[wave^1])"),
        ("0.1 µm + 2 λ + 3 Å", "(+ (+ 0.1[µm^1] 2[λ^1]) 3[Å^1])"),
        ("-1.5e-12 mm^-3", "(- 0.0000000000015[mm^-3])"),
        ("3 in", "?"),
    ] {
        assert_eq!(value_of(text).0, tree, "{text}");
    }
}

#[test]
fn types_and_restrictions() {
    let text = "language 1
pub schema raster : Path {
    /// Where.
    /// And how.
    over: Aperture?
    step: Length = 2 mm where > 0 mm and < 5 mm usual 0.1 mm .. 2 mm
    at: [Angle; 6] where 0 deg .. 360 deg
    coefficient: Length^-3 * Time / Mass^(1/2)
    span: Angle .. Angle
    lines:
        /// Turns at each end.
        serpentine
        /// Lifts.
        | one_way?
    remove: [piston | tilt]
    check over < step
}
dimension Speed = Length / Time
dimension Length
unit m: Length
unit µm = 1e-6 m
unit % = 0.01
";
    let (ast, said) = read(text);
    assert_eq!(said, []);
    let ItemKind::Schema(schema) = &ast.items[0].kind else { panic!("a schema") };
    assert!(ast.items[0].public);
    let family = schema.family.as_ref().map(|name| name.text.as_str());
    assert_eq!((schema.name.text.as_str(), family), ("raster", Some("Path")));
    let types: Vec<String> =
        schema.fields.iter().map(|field| format!("{}: {}", field.name.text, prefix_type(&field.ty))).collect();
    assert_eq!(
        types,
        [
            "over: Aperture?",
            "step: Length",
            "at: [Angle;6]",
            "coefficient: (/ (* (^ Length -3/1) Time) (^ Mass 1/2))",
            "span: (.. Angle)",
            "lines: serpentine<Turns at each end.>|one_way<Lifts.>?",
            "remove: [piston<>|tilt<>]"
        ]
    );
    assert_eq!(schema.fields[0].doc, "Where.\nAnd how.");
    let step = &schema.fields[1];
    let Some(Restriction::Comparisons(comparisons)) = &step.restriction else { panic!("comparisons") };
    let comparisons: Vec<_> =
        comparisons.iter().map(|(op, _, value)| format!("{} {}", sign(*op), prefix(value))).collect();
    assert_eq!(comparisons, ["> 0[mm^1]", "< 5[mm^1]"]);
    assert_eq!(step.usual.as_ref().map(prefix).as_deref(), Some("(.. 0.1[mm^1] 2[mm^1])"));
    assert_eq!(step.default.as_ref().map(prefix).as_deref(), Some("2[mm^1]"));
    let Some(Restriction::Range(range)) = &schema.fields[2].restriction else { panic!("a range") };
    assert_eq!(prefix(range), "(.. 0[deg^1] 360[deg^1])");
    assert_eq!(schema.checks.iter().map(|check| prefix(&check.condition)).collect::<Vec<_>>(), ["(< over step)"]);
    let rest: Vec<String> = ast.items[1..]
        .iter()
        .map(|item| match &item.kind {
            ItemKind::Dimension { name, value } => {
                format!("{} = {}", name.text, value.as_ref().map(prefix_type).unwrap_or_default())
            }
            ItemKind::Unit { name, ty, value } => {
                let ty = ty.as_ref().map(prefix_type).unwrap_or_default();
                format!("{}: {ty} = {}", name.text, value.as_ref().map(prefix).unwrap_or_default())
            }
            other => format!("{other:?}"),
        })
        .collect();
    assert_eq!(rest, ["Speed = (/ Length Time)", "Length = ", "m: Length = ", "µm:  = 0.000001[m^1]", "%:  = 0.01"]);
}

#[test]
fn entries_end_where_the_language_says() {
    for (text, tree) in [
        // After an operator, before an operator that is not a sign, after and before a keyword.
        ("{ a: 1 +\n 2\n b: 3 }", "{a:(+ 1 2) b:3}"),
        ("{ a: 6\n / 2\n b: x\n with { c: 1 } }", "{a:(/ 6 2) b:(with x {c:1})}"),
        ("{ a: p\n and q }", "{a:(and p q)}"),
        // A sign begins an entry of its own; `name:` always does.
        ("[1\n -2]", "[1 (- 2)]"),
        ("{ a:\n 3 }", "{a:3}"),
        // In round brackets newlines are blanks, and comments are blanks everywhere.
        ("f(1\n, 2\n + 3)", "(f 1 (+ 2 3))"),
        ("{ a: 1 /* \n */ + 2, b: 3 // x, y\n }", "{a:(+ 1 2) b:3}"),
        ("{ in: 1\n or: 2 }", "{in:1 or:2}"),
        ("[raster { a: 1 } raster]", "[?]"),
    ] {
        assert_eq!(value_of(text).0, tree, "{text}");
    }
}

#[test]
fn places_are_exact() {
    for (name, text) in FILES {
        let (ast, _) = read(text);
        let slice = |span: crate::source::Span| &text[span.start as usize..span.end as usize];
        let check_name = |n: &Name| assert_eq!(slice(n.span), n.text, "{name}");
        walk(&ast, &mut |expr| {
            let written = slice(expr.span);
            assert_eq!(written.trim(), written, "{name}: {expr:?}");
            match &expr.kind {
                ExprKind::Number(value) if !written.starts_with('(') => assert_eq!(written.parse(), Ok(*value)),
                ExprKind::Quantity { value, unit } => {
                    assert_eq!(written[..written.len() - slice(unit.span).len()].trim().parse(), Ok(*value));
                    unit.factors.iter().for_each(|(factor, _)| check_name(factor));
                }
                ExprKind::Text(content) => assert_eq!(written, format!("\"{content}\"")),
                ExprKind::Name(word) => assert_eq!(written, word),
                ExprKind::Member(of, field) => {
                    check_name(field);
                    assert_eq!(written, format!("{}.{}", slice(of.span), field.text));
                }
                ExprKind::Record { schema, body } => {
                    schema.iter().for_each(check_name);
                    assert!(written.ends_with(slice(body.span)) && slice(body.span).starts_with('{'));
                    assert!(slice(body.span).ends_with('}'), "{name}: {written}");
                }
                ExprKind::List(_, None) => assert!(written.starts_with('[') && written.ends_with(']')),
                ExprKind::Binary(op, place, left, right) => {
                    assert_eq!(slice(*place), sign(*op));
                    assert!(left.span.end <= place.start && place.end <= right.span.start);
                }
                _ => {}
            }
        });
    }
}

/// Visits every value of the tree.
pub(super) fn walk(ast: &Ast, see: &mut dyn FnMut(&Expr)) {
    fn value(expr: &Expr, see: &mut dyn FnMut(&Expr)) {
        see(expr);
        match &expr.kind {
            ExprKind::Member(of, _) | ExprKind::Unary(_, of) => value(of, see),
            ExprKind::Call(of, arguments) => {
                value(of, see);
                arguments.iter().for_each(|argument| value(argument, see));
            }
            ExprKind::Record { body, .. } => block(body, see),
            ExprKind::With(of, body) => {
                value(of, see);
                block(body, see);
            }
            ExprKind::List(elements, _) => elements.iter().for_each(|element| value(element, see)),
            ExprKind::Comprehension { element, over, .. } => {
                value(element, see);
                value(over, see);
            }
            ExprKind::If { branches, otherwise } => {
                for (condition, chosen) in branches {
                    value(condition, see);
                    value(chosen, see);
                }
                value(otherwise, see);
            }
            ExprKind::Range(left, right) | ExprKind::Binary(_, _, left, right) => {
                value(left, see);
                value(right, see);
            }
            _ => {}
        }
    }
    fn block(body: &Block, see: &mut dyn FnMut(&Expr)) {
        for entry in &body.entries {
            match &entry.kind {
                EntryKind::Field { value: v, .. } | EntryKind::Expr(v) => value(v, see),
            }
        }
    }
    for item in &ast.items {
        match &item.kind {
            ItemKind::Let { value: v, .. } => value(v, see),
            ItemKind::Param { value: v, .. } | ItemKind::Unit { value: v, .. } => v.iter().for_each(|v| value(v, see)),
            ItemKind::Function { body, .. } => body.iter().for_each(|v| value(v, see)),
            ItemKind::Assert { condition, .. } => value(condition, see),
            ItemKind::Job { body, .. } => block(body, see),
            ItemKind::Schema(schema) => {
                let values = schema.fields.iter().flat_map(|field| field.default.iter().chain(&field.usual));
                values.chain(schema.checks.iter().map(|check| &check.condition)).for_each(|v| value(v, see));
            }
            _ => {}
        }
    }
}
