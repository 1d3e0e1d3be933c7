//! Statements found against statements wanted.
//!
//! In: the body of a routine, and what the job asks it to say, step by step. Out: what differs, with the innermost line.
//! White space, capitals, the writing of numbers and names for literals make no difference; everything else does.

use super::reader;
use super::syntax::{Expression, Statement, What};
use super::values::{Scope, components};
use crate::diagnostics::codes::E1003;
use crate::diagnostics::{Code, Problem};
use crate::verify::align::{self, Met};
use crate::verify::findings::{Findings, at};
use crate::verify::replay::same_number;

/// One thing that a routine must say.
pub struct Step {
    /// The code for its absence or alteration.
    pub code: Code,
    /// The field of the job that asks for it.
    pub field: &'static str,
    pub want: Statement,
    /// Why it must be there, a sentence without full stop.
    pub why: &'static str,
}

impl Step {
    /// A statement as KRL text. Text that cannot be read gives a step that nothing fulfils, so that a mistake here is a
    /// refusal and never a permission.
    pub fn say(code: Code, field: &'static str, text: &str, why: &'static str) -> Step {
        let read = reader::read_statements(text).ok().filter(|all| all.len() == 1).and_then(|mut all| all.pop());
        let never = Statement { line: 0, what: What::Call(text.to_string(), vec![]) };
        Step { code, field, want: read.unwrap_or(never), why }
    }
}

/// A difference, its line in the program, and the words for it.
struct Different {
    line: u32,
    what: String,
}

/// Compares the body of a routine with the steps wanted.
pub fn compare(
    file: &str,
    scope: Scope,
    routine_line: u32,
    found: &[&Statement],
    wanted: &[Step],
    findings: &mut Findings,
) {
    let fits = |f: usize, w: usize| difference(found[f], &wanted[w].want, scope).is_none();
    let line = |f: usize| found.get(f).or(found.last()).map_or(routine_line, |statement| statement.line);
    align::statements(found.len(), wanted.len(), fits, |met| match met {
        Met::Pair { found: f, wanted: w } => {
            let step = &wanted[w];
            if let Some(different) = difference(found[f], &step.want, scope) {
                findings.add(|| at(file, different.line, step.code, step.field, different.what).note(step.why));
            }
        }
        Met::Missing { wanted: w, before } => {
            let step = &wanted[w.start];
            let place = if before < found.len() { "before this line" } else { "at the end" };
            let what = format!("`{}` is missing {place}", step.want);
            findings.add(|| at(file, line(before), step.code, step.field, what).note(step.why));
        }
        Met::Extra { found: f, before } => {
            let field = wanted.get(before).or(wanted.last()).map_or("target", |step| step.field);
            findings.add(|| extra(file, found[f.start], field));
        }
        // Statements are not looked for elsewhere.
        Met::Swapped { .. } => {}
    });
}

fn extra(file: &str, statement: &Statement, field: &str) -> Problem {
    let what = format!("the job does not ask for `{statement}`");
    at(file, statement.line, E1003, field, what).note("every statement of the program must come from the job")
}

/// The innermost first difference of two statements.
fn difference(found: &Statement, wanted: &Statement, scope: Scope) -> Option<Different> {
    let stands = |found: &dyn std::fmt::Display, wanted: &dyn std::fmt::Display, line: u32| {
        Some(Different { line, what: format!("`{found}` stands where the job asks for `{wanted}`") })
    };
    let conditions = |a: &Expression, b: &Expression| {
        if same(a, b, scope) {
            return None;
        }
        let (a, b) = smallest(a, b, scope);
        stands(a, b, found.line)
    };
    match (&found.what, &wanted.what) {
        (What::If(a, body, otherwise), What::If(b, wanted_body, wanted_otherwise)) => conditions(a, b)
            .or_else(|| bodies(found.line, body, wanted_body, scope))
            .or_else(|| bodies(found.line, otherwise, wanted_otherwise, scope)),
        (What::While(a, body), What::While(b, wanted_body)) => {
            conditions(a, b).or_else(|| bodies(found.line, body, wanted_body, scope))
        }
        (What::Loop(body), What::Loop(wanted_body)) => bodies(found.line, body, wanted_body, scope),
        (What::Return(Some(a)), What::Return(Some(b))) => conditions(a, b),
        (What::Halt, What::Halt) | (What::Return(None), What::Return(None)) => None,
        (What::Wait(a), What::Wait(b)) if same(a, b, scope) => None,
        (What::JointMove(a), What::JointMove(b)) if same(a, b, scope) => None,
        (What::Call(a, x), What::Call(b, y)) if a.eq_ignore_ascii_case(b) && all_same(x, y, scope) => None,
        // An assignment's target is a place, not a value.
        (What::Assign(a, x), What::Assign(b, y)) if a.eq_ignore_ascii_case(b) && same(x, y, scope) => None,
        _ => stands(found, wanted, found.line),
    }
}

fn bodies(line: u32, found: &[Statement], wanted: &[Statement], scope: Scope) -> Option<Different> {
    let mut last = line;
    for (i, wanted) in wanted.iter().enumerate() {
        let Some(statement) = found.get(i) else {
            return Some(Different { line: last, what: format!("`{wanted}` is missing after this line") });
        };
        if let Some(inner) = difference(statement, wanted, scope) {
            return Some(inner);
        }
        last = statement.line;
    }
    found
        .get(wanted.len())
        .map(|extra| Different { line: extra.line, what: format!("the job does not ask for `{extra}`") })
}

/// The smallest parts of two long conditions that differ.
fn smallest<'a>(
    mut found: &'a Expression,
    mut wanted: &'a Expression,
    scope: Scope,
) -> (&'a Expression, &'a Expression) {
    while let (Expression::Binary(a, x, p), Expression::Binary(b, y, q)) = (found, wanted) {
        if a != b || !matches!(*a, "AND" | "OR") {
            break;
        }
        (found, wanted) = match (same(x, y, scope), same(p, q, scope)) {
            (true, false) => (p, q),
            (false, true) => (x, y),
            _ => break,
        };
    }
    (found, wanted)
}

fn all_same(a: &[Expression], b: &[Expression], scope: Scope) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b, scope))
}

/// Whether two expressions say the same.
fn same(found: &Expression, wanted: &Expression, scope: Scope) -> bool {
    match (found, wanted) {
        (Expression::Name(a), Expression::Name(b)) if a.eq_ignore_ascii_case(b) => true,
        (Expression::Symbol(a), Expression::Symbol(b)) => a.eq_ignore_ascii_case(b),
        (Expression::Number(a), Expression::Number(b)) => same_number(*a, *b),
        (Expression::Text(a), Expression::Text(b)) => a == b,
        (Expression::Call(a, x), Expression::Call(b, y)) => a.eq_ignore_ascii_case(b) && all_same(x, y, scope),
        (Expression::Unary(a, x), Expression::Unary(b, y)) => a == b && same(x, y, scope),
        (Expression::Binary(a, x, p), Expression::Binary(b, y, q)) => a == b && same(x, y, scope) && same(p, q, scope),
        // A name where a literal is wanted.
        (Expression::Name(_), Expression::Number(_)) => match scope.resolve(found) {
            Expression::Number(a) => same(&Expression::Number(a), wanted, scope),
            _ => false,
        },
        // Joints written out where their name is wanted.
        (Expression::Aggregate(_), Expression::Name(_)) => {
            match (scope.numbers(found, components::AXIS), scope.numbers(wanted, components::AXIS)) {
                (Some(a), Some(b)) => a.iter().zip(b).all(|(a, b)| same_number(*a, b)),
                _ => false,
            }
        }
        _ => false,
    }
}
