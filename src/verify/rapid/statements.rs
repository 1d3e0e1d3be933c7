//! Statements found against statements wanted.
//!
//! In: the body of a routine, and what the job asks it to say, step by step. Out: what differs, with the innermost line.
//! White space, capitals, the writing of numbers and names for literals make no difference; everything else does.

use super::syntax::{Argument, Expression, Move, Statement, What};
use super::values::Scope;
use super::{Findings, at, reader};
use crate::diagnostics::Code;
use crate::diagnostics::codes::E1003;
use crate::verify::align::{self, Met};
use crate::verify::replay::same_number;

/// One thing that a routine must say.
pub struct Step {
    /// The code for its absence or alteration.
    pub code: Code,
    /// The field of the job that asks for it.
    pub field: &'static str,
    pub want: Want,
    /// Why it must be there, a sentence without full stop.
    pub why: &'static str,
}

pub enum Want {
    Say(Statement),
    /// A joint move to home in this many seconds.
    Home(f64),
}

/// What the statements stand in.
pub struct Around<'a> {
    pub file: &'a str,
    pub scope: Scope<'a>,
    pub moves: &'a [Move],
    /// What is wrong with a move that must go to home in so many seconds.
    pub home: &'a dyn Fn(&Move, f64) -> Result<(), String>,
}

impl Step {
    /// A statement as RAPID text. Text that cannot be read gives a step that nothing fulfils, so that a mistake here is
    /// a refusal and never a permission.
    pub fn say(code: Code, field: &'static str, text: &str, why: &'static str) -> Step {
        let read = reader::read_statements(text).ok().and_then(|mut all| all.pop());
        let never = Statement { line: 0, what: What::Instruction(text.to_string(), vec![]) };
        Step { code, field, want: Want::Say(read.unwrap_or(never)), why }
    }

    /// What it asks for, in words.
    fn words(&self) -> String {
        match &self.want {
            Want::Say(statement) => format!("`{statement}`"),
            Want::Home(_) => "a joint move to home".into(),
        }
    }

    /// Where `found` differs: the line, what stands there, what should.
    fn difference(&self, found: &Statement, around: &Around) -> Option<Difference> {
        match (&self.want, &found.what) {
            (Want::Say(wanted), _) => difference(found, wanted, around.scope),
            (Want::Home(time), What::Move(index)) => {
                let one = around.moves.get(*index)?;
                (around.home)(one, *time).err().map(|what| Difference { line: found.line, what })
            }
            (Want::Home(_), _) => Some(Difference::plain(found, &self.words())),
        }
    }
}

/// A difference, its line in the program, and the words for it.
struct Difference {
    line: u32,
    what: String,
}

impl Difference {
    fn plain(found: &Statement, wanted: &str) -> Difference {
        Difference { line: found.line, what: format!("`{found}` stands where the job asks for {wanted}") }
    }
}

impl Difference {
    /// The smallest parts of two long conditions that differ.
    fn of_parts(line: u32, found: &Expression, wanted: &Expression, scope: Scope) -> Difference {
        let (mut found, mut wanted) = (found, wanted);
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
        Difference { line, what: format!("`{found}` stands where the job asks for `{wanted}`") }
    }
}

/// Compares the body of a routine with the steps wanted.
pub fn compare(around: &Around, routine_line: u32, found: &[Statement], wanted: &[Step], findings: &mut Findings) {
    let file = around.file;
    let fits = |f: usize, w: usize| wanted[w].difference(&found[f], around).is_none();
    let line = |f: usize| found.get(f).or(found.last()).map_or(routine_line, |statement| statement.line);
    align::statements(found.len(), wanted.len(), fits, |met| match met {
        Met::Pair { found: f, wanted: w } => {
            let step = &wanted[w];
            if let Some(difference) = step.difference(&found[f], around) {
                findings.add(|| at(file, difference.line, step.code, step.field, difference.what).note(step.why));
            }
        }
        Met::Missing { wanted: w, before } => {
            let step = &wanted[w.start];
            let place = if before < found.len() { "before this line" } else { "at the end" };
            let what = format!("{} is missing {place}", step.words());
            findings.add(|| at(file, line(before), step.code, step.field, what).note(step.why));
        }
        Met::Extra { found: f, before } => {
            if let Some(step) = wanted.get(before).or(wanted.last()) {
                findings.add(|| extra(file, &found[f.start], step));
            }
        }
        // Statements are not looked for elsewhere.
        Met::Swapped { .. } => {}
    });
}

fn extra(file: &str, statement: &Statement, near: &Step) -> crate::diagnostics::Problem {
    let what = format!("the job does not ask for `{statement}`");
    at(file, statement.line, E1003, near.field, what).note("every statement of the program must come from the job")
}

/// The innermost first difference of two statements.
fn difference(found: &Statement, wanted: &Statement, scope: Scope) -> Option<Difference> {
    let differs = || Some(Difference::plain(found, &format!("`{wanted}`")));
    match (&found.what, &wanted.what) {
        (What::If(found_arms, found_else), What::If(wanted_arms, wanted_else)) => {
            if found_arms.len() != wanted_arms.len() {
                return differs();
            }
            for ((condition, body), (wanted_condition, wanted_body)) in found_arms.iter().zip(wanted_arms) {
                if !same(condition, wanted_condition, scope) {
                    return Some(Difference::of_parts(found.line, condition, wanted_condition, scope));
                }
                if let Some(inner) = bodies(found.line, body, wanted_body, scope) {
                    return Some(inner);
                }
            }
            bodies(found.line, found_else, wanted_else, scope)
        }
        (What::While(condition, body), What::While(wanted_condition, wanted_body)) => {
            if !same(condition, wanted_condition, scope) {
                return Some(Difference::of_parts(found.line, condition, wanted_condition, scope));
            }
            bodies(found.line, body, wanted_body, scope)
        }
        (What::Instruction(name, arguments), What::Instruction(wanted_name, wanted_arguments)) => {
            let same_arguments = arguments.len() == wanted_arguments.len()
                && arguments.iter().zip(wanted_arguments).all(|(a, b)| same_argument(a, b, scope));
            if name.eq_ignore_ascii_case(wanted_name) && same_arguments { None } else { differs() }
        }
        (What::LateCall(name), What::LateCall(wanted_name)) if same(name, wanted_name, scope) => None,
        (What::Assign(target, value), What::Assign(wanted_target, wanted_value)) => {
            // An assignment's target is a place, not a value.
            let same_target = matches!((target, wanted_target), (Expression::Name(a), Expression::Name(b)) if a.eq_ignore_ascii_case(b));
            if same_target && same(value, wanted_value, scope) { None } else { differs() }
        }
        (What::Return(Some(value)), What::Return(Some(wanted_value))) => {
            (!same(value, wanted_value, scope)).then(|| Difference::of_parts(found.line, value, wanted_value, scope))
        }
        (What::Return(None), What::Return(None)) => None,
        _ => differs(),
    }
}

fn bodies(line: u32, found: &[Statement], wanted: &[Statement], scope: Scope) -> Option<Difference> {
    let mut last = line;
    for (i, wanted) in wanted.iter().enumerate() {
        let Some(statement) = found.get(i) else {
            return Some(Difference { line: last, what: format!("`{wanted}` is missing after this line") });
        };
        if let Some(inner) = difference(statement, wanted, scope) {
            return Some(inner);
        }
        last = statement.line;
    }
    found
        .get(wanted.len())
        .map(|extra| Difference { line: extra.line, what: format!("the job does not ask for `{extra}`") })
}

fn same_argument(found: &Argument, wanted: &Argument, scope: Scope) -> bool {
    let same_switch = match (&found.switch, &wanted.switch) {
        (Some(a), Some(b)) => a.eq_ignore_ascii_case(b),
        (None, None) => true,
        _ => false,
    };
    same_switch
        && match (&found.value, &wanted.value) {
            (Some(a), Some(b)) => same(a, b, scope),
            (None, None) => true,
            _ => false,
        }
}

/// Whether two expressions say the same.
fn same(found: &Expression, wanted: &Expression, scope: Scope) -> bool {
    let all =
        |a: &[Expression], b: &[Expression]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b, scope));
    match (found, wanted) {
        (Expression::Name(a), Expression::Name(b)) if a.eq_ignore_ascii_case(b) => true,
        (Expression::Number(a), Expression::Number(b)) => same_number(*a, *b),
        (Expression::Text(a), Expression::Text(b)) => a == b,
        (Expression::List(a), Expression::List(b)) => all(a, b),
        (Expression::Call(a, x), Expression::Call(b, y)) => a.eq_ignore_ascii_case(b) && all(x, y),
        (Expression::Unary(a, x), Expression::Unary(b, y)) => a == b && same(x, y, scope),
        (Expression::Binary(a, x, p), Expression::Binary(b, y, q)) => a == b && same(x, y, scope) && same(p, q, scope),
        // A name where a literal is wanted.
        (Expression::Name(_), Expression::Number(_) | Expression::Text(_)) => match scope.resolve(found) {
            Expression::Name(_) => false,
            value => same(&value, wanted, scope),
        },
        _ => false,
    }
}
