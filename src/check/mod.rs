//! Checking: names, types, dimensions and fields.
//!
//! In: the files of a job, parsed. Out: [`Checked`], in which every name is resolved and every dimension proved, and
//! what was wrong. Why it exists: after this pass an expression cannot mean two things, so `eval` only has numbers to
//! work out. What depends on numbers (ranges, divisions by zero) is `eval`'s.
//!
//! A mistake is said once: what was wrong becomes [`Type::Failed`], which fits everything.

mod choice;
mod expression;
mod functions;
mod globals;
pub mod library;
pub mod load;
pub mod meant;
mod mismatch;
mod names;
mod record;
pub mod similar;
pub mod typed;
pub mod types;
mod units;
mod vocabulary;

use crate::diagnostics::{Diagnostic, codes};
use crate::source::{FileProvider, Sources, Span};
use crate::syntax::ast::ItemKind;
use globals::Global;
use load::{Loaded, Module, ModuleId, SetValue};
use std::collections::BTreeMap;
use typed::{FieldValue, GlobalId, Typed};
use types::{FamilyId, Limit, SchemaId, Type, Vocabulary};

/// Deepest nesting of expressions, values that use values included. No job comes near; it keeps the stack small.
pub const DEEPEST: usize = 200;

/// A `let` or `param`, checked.
#[derive(Clone, Debug)]
pub struct CheckedGlobal {
    pub name: String,
    pub doc: String,
    pub span: Span,
    pub is_param: bool,
    /// The type that was declared, or that of the value.
    pub ty: Type,
    /// Of a function its body, which speaks of the parameters as local values.
    pub value: Typed,
    pub restriction: Option<Limit>,
    pub usual: Option<Limit>,
    /// The parameters, if it is a function.
    pub parameters: Option<Vec<(String, Type)>>,
}

/// An `assert`, checked.
#[derive(Clone, Debug)]
pub struct CheckedAssert {
    pub condition: Typed,
    pub reason: String,
}

/// A `job`, checked: a record of the schema `job`, and its requirements apart.
#[derive(Clone, Debug)]
pub struct CheckedJob {
    pub name: String,
    pub name_span: Span,
    pub record: Typed,
    pub requirements: Vec<Typed>,
}

/// Everything that `eval` needs.
#[derive(Debug, Default)]
pub struct Checked {
    pub vocabulary: Vocabulary,
    pub globals: Vec<CheckedGlobal>,
    /// The globals in an order in which each comes after those that it uses.
    pub order: Vec<GlobalId>,
    pub asserts: Vec<CheckedAssert>,
    pub jobs: Vec<CheckedJob>,
}

/// Checks all files. The diagnostics are in no order.
pub fn check(loaded: &Loaded, files: &dyn FileProvider) -> (Checked, Vec<Diagnostic>) {
    let mut checker = Checker {
        files,
        sources: &loaded.sources,
        modules: &loaded.modules,
        sets: &loaded.sets,
        vocabulary: Vocabulary::default(),
        scopes: loaded.modules.iter().map(|_| Scope::default()).collect(),
        core: Scope::default(),
        globals: Vec::new(),
        order: Vec::new(),
        active: Vec::new(),
        locals: Vec::new(),
        depth: 0,
        diagnostics: Vec::new(),
    };
    checker.declare();
    checker.check_schemas();
    checker.check_globals();
    checker.check_allows();
    let asserts = checker.check_asserts();
    let jobs = checker.check_jobs();
    let globals = checker.globals.iter().map(Global::checked).collect();
    let checked = Checked { vocabulary: checker.vocabulary, globals, order: checker.order, asserts, jobs };
    (checked, checker.diagnostics)
}

/// What a name of a value means in a file.
#[derive(Clone, Copy, Debug)]
enum Binding {
    Global(GlobalId),
    Module(ModuleId),
    /// What it names was wrong; that has been said.
    Failed,
}

/// The names of one file.
#[derive(Debug, Default)]
struct Scope {
    values: BTreeMap<String, (Binding, Span)>,
    schemas: BTreeMap<String, SchemaId>,
    families: BTreeMap<String, FamilyId>,
}

/// Whether the unit `wave` has a meaning here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wave {
    OutsideJob,
    NotStated,
    Stated,
}

/// Where an expression stands.
#[derive(Clone, Copy, Debug)]
struct Place {
    module: ModuleId,
    wave: Wave,
    /// Whether `result.…` may be used.
    results: bool,
    /// In a `check` line: the schema whose fields are names.
    siblings: Option<SchemaId>,
}

impl Place {
    fn outside_job(module: ModuleId) -> Place {
        Place { module, wave: Wave::OutsideJob, results: false, siblings: None }
    }
}

/// What an expression must be, and what asks for it, in words: `` `line_pitch` ``.
#[derive(Clone, Debug)]
struct Want {
    ty: Type,
    what: String,
    /// The unit that the field's own limits are written in: what a number without one most likely meant.
    unit: Option<String>,
}

impl Want {
    /// The same of an element or an end, whose type is `ty`.
    fn part(&self, ty: &Type) -> Want {
        Want { ty: ty.clone(), what: self.what.clone(), unit: self.unit.clone() }
    }
}

/// A name that is known only within a function or a list.
#[derive(Clone, Debug)]
struct Local {
    name: String,
    ty: Type,
    span: Span,
}

struct Checker<'a> {
    files: &'a dyn FileProvider,
    sources: &'a Sources,
    modules: &'a [Module],
    sets: &'a BTreeMap<String, SetValue>,
    vocabulary: Vocabulary,
    scopes: Vec<Scope>,
    /// What is visible without `use`.
    core: Scope,
    globals: Vec<Global<'a>>,
    order: Vec<GlobalId>,
    /// The globals being checked, each because the one before uses it, with the place of that use.
    active: Vec<(GlobalId, Span)>,
    /// The parameters of the function being checked, and the variables of the lists around, outermost first.
    locals: Vec<Local>,
    depth: usize,
    diagnostics: Vec<Diagnostic>,
}

impl<'a> Checker<'a> {
    fn say(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }

    /// Only warnings that there are can be allowed.
    fn check_allows(&mut self) {
        for allow in self.modules.iter().flat_map(|module| &module.ast.allows) {
            let code = &allow.code;
            let known = crate::diagnostics::Code::find(&code.text).filter(|found| found.as_str() == code.text);
            let diagnostic = match known {
                Some(_) if code.text.starts_with('W') => continue,
                Some(_) => {
                    let message = format!("`{}` is an error, and only a warning can be allowed", code.text);
                    Diagnostic::error(codes::E0126, code.span, message).help("mend it; there is no way around an error")
                }
                None => Diagnostic::error(codes::E0126, code.span, format!("there is no warning `{}`", code.text))
                    .note("a warning shows its code in brackets, such as `warning[W0401]`"),
            };
            self.say(diagnostic);
        }
    }

    fn check_asserts(&mut self) -> Vec<CheckedAssert> {
        let mut asserts = Vec::new();
        for (index, module) in self.modules.iter().enumerate() {
            for item in &module.ast.items {
                let ItemKind::Assert { condition, reason } = &item.kind else { continue };
                let place = Place::outside_job(ModuleId(index));
                let condition = self.wanted(place, condition, Type::Bool, "`assert`".into());
                asserts.push(CheckedAssert { condition, reason: reason.clone() });
            }
        }
        asserts
    }

    fn check_jobs(&mut self) -> Vec<CheckedJob> {
        let mut jobs: Vec<CheckedJob> = Vec::new();
        for (index, module) in self.modules.iter().enumerate() {
            for item in &module.ast.items {
                let ItemKind::Job { name, body } = &item.kind else { continue };
                if index != 0 {
                    let message = format!("the file `{}` is used by a job and cannot hold a job", module.path);
                    let place = self.sources.name(self.modules[0].file).to_string();
                    self.say(
                        Diagnostic::error(codes::E0213, name.span, message).help(format!("move it into `{place}`")),
                    );
                    continue;
                }
                if let Some(first) = jobs.iter().find(|job| job.name == name.text) {
                    let first = first.name_span;
                    let message = format!("two jobs are called `{}`", name.text);
                    self.say(Diagnostic::error(codes::E0206, name.span, message).also(first, "the first one"));
                    continue;
                }
                let job = self.job(ModuleId(index), name, body);
                jobs.push(job);
            }
        }
        jobs
    }
}

/// The values given by a checked record, if it is one as written.
pub(crate) fn given_fields(record: &Typed) -> &[FieldValue] {
    match &record.kind {
        typed::TypedKind::Record(_, fields) => fields,
        _ => &[],
    }
}
