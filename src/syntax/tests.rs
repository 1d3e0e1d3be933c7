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
fn the_design_files_are_read_without_a_word() {
    for (name, text) in FILES {
        let (_, said) = read(text);
        let said: Vec<String> = said.iter().map(|d| show(text, d)).collect();
        // Comprehensions and `allow` come with a later version; everything else of these files is there.
        let later: &[&str] = match *name {
            "asphere_400" => &["E0117 a list with `for` is not part of language 1 yet @1342..1345 `for`"],
            "spot_test" => &["E0117 a list with `for` is not part of language 1 yet @1169..1172 `for`"],
            "k9_200" => &["E0117 `allow … because` is not part of language 1 yet @1031..1036 `allow`"],
            _ => &[],
        };
        assert_eq!(said, later, "{name}");
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
            ItemKind::Param { name, ty, value, restriction } => {
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
    assert_eq!(schema.checks.iter().map(prefix).collect::<Vec<_>>(), ["(< over step)"]);
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
            ItemKind::Job { body, .. } => block(body, see),
            ItemKind::Schema(schema) => {
                let values = schema.fields.iter().flat_map(|field| field.default.iter().chain(&field.usual));
                values.chain(&schema.checks).for_each(|v| value(v, see));
            }
            _ => {}
        }
    }
}
