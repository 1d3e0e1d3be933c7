//! Evaluation: from checked text to the Job, and the one call that does all from text on, [`compile`].
//!
//! In: the files of a job. Out: [`Compiled`]: for each job its [`Job`] in SI, the place of every field, and its
//! requirements; or what was wrong, in order of place. No data file is read here: a field of type `File` becomes a whole
//! path.

mod choice;
mod deserialize;
mod evaluate;
mod limits;
mod requirement;
mod shown;
pub mod value;

pub use deserialize::{Misfit, from_value};
pub use requirement::{Outcome, Requirement};
pub use shown::{Said, Shown, ShownField};

use crate::check::types::Vocabulary;
use crate::check::{self, Checked, CheckedJob, given_fields, load};
use crate::diagnostics::{Diagnostic, Severity, codes};
use crate::job::{Job, Origins};
use crate::source::{FileId, FileProvider, Sources, Span};
use crate::syntax::ast::Allow;
use evaluate::{Evaluator, Surroundings};
use std::collections::BTreeSet;

/// What the caller may choose.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// `--set NAME=VALUE`, in order. A value is written as in the job (`0.4mm`, `"x.dat"`); for a parameter of type
    /// `Text` or `File` the quotes may be left out. A file given so is resolved by `FileProvider::resolve("", path)`:
    /// relative to the working directory, and always allowed.
    pub sets: Vec<(String, String)>,
    /// Only this job of the file.
    pub job: Option<String>,
}

/// Everything that is known of a file and its jobs.
#[derive(Debug, Default)]
pub struct Compiled {
    /// The files that were read, the job's file first; `--set` values and stdlib are among them.
    pub sources: Sources,
    /// In order of place.
    pub diagnostics: Vec<Diagnostic>,
    /// Empty when there is an error.
    pub jobs: Vec<CompiledJob>,
    /// Schemas with fields, types, defaults and docs.
    pub vocabulary: Vocabulary,
    /// The `allow` lines of all files; the warnings are still among the diagnostics.
    pub allows: Vec<Allow>,
}

/// A job that is ready for the passes.
#[derive(Clone, Debug)]
pub struct CompiledJob {
    pub name: String,
    pub name_span: Span,
    pub job: Job,
    pub origins: Origins,
    pub requirements: Vec<Requirement>,
    pub params: Vec<ParamValue>,
    /// Every value with who said it.
    pub fields: Vec<ShownField>,
}

/// A parameter with the value that this compilation used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParamValue {
    pub name: String,
    pub doc: String,
    /// For people: `0.5 mm`.
    pub value: String,
    pub span: Span,
}

/// Reads, checks and evaluates the file at `path`.
pub fn compile(files: &dyn FileProvider, path: &str, options: &Options) -> Compiled {
    let mut loaded = load::load(files, path, &options.sets);
    let (checked, mistakes) = check::check(&loaded, files);
    let doubtful = doubtful_lines(&loaded);
    let said = std::mem::take(&mut loaded.diagnostics).into_iter().chain(mistakes).collect();
    let mut evaluator = Evaluator::new(&checked, &loaded.sources, said);
    let chosen = chosen_jobs(&checked, options, &mut evaluator.diagnostics);
    let jobs: Vec<CompiledJob> = chosen.into_iter().filter_map(|job| evaluator.job(job)).collect();
    let mut diagnostics = in_order(evaluator.diagnostics);
    diagnostics.retain(|d| {
        let place = d.primary.as_ref().map(|label| line_of(&loaded.sources, label.span));
        is_syntax(d) || place.is_none_or(|place| !doubtful.contains(&place))
    });
    let failed = diagnostics.iter().any(|d| d.severity == Severity::Error);
    let jobs = if failed { Vec::new() } else { jobs };
    let allows = loaded.modules.iter().flat_map(|module| module.ast.allows.iter().cloned()).collect();
    Compiled { sources: loaded.sources, diagnostics, jobs, vocabulary: checked.vocabulary, allows }
}

/// stdlib alone: its sources, its vocabulary, and what is wrong with it (nothing, says a test).
pub fn library() -> Compiled {
    let mut loaded = load::load_library();
    let (checked, mistakes) = check::check(&loaded, &crate::source::MemoryFiles::default());
    let said = std::mem::take(&mut loaded.diagnostics).into_iter().chain(mistakes).collect();
    let mut evaluator = Evaluator::new(&checked, &loaded.sources, said);
    evaluator.defaults_keep_to_limits();
    let diagnostics = in_order(evaluator.diagnostics);
    Compiled {
        sources: loaded.sources,
        diagnostics,
        jobs: Vec::new(),
        vocabulary: checked.vocabulary,
        allows: Vec::new(),
    }
}

fn line_of(sources: &Sources, span: Span) -> (FileId, usize) {
    (span.file, sources.line_column(span.file, span.start as usize).0)
}

fn is_syntax(diagnostic: &Diagnostic) -> bool {
    diagnostic.code.as_str().starts_with("E01")
}

/// The lines with a bracket too many or too few, or with a unit that is none: what stands in which record there is a guess, and what follows from the
/// guess is no second mistake.
fn doubtful_lines(loaded: &load::Loaded) -> BTreeSet<(FileId, usize)> {
    let doubtful = |d: &&Diagnostic| [codes::E0102, codes::E0103, codes::E0113].contains(&d.code);
    let places = loaded.diagnostics.iter().filter(doubtful).filter_map(|d| d.primary.as_ref());
    places.map(|label| line_of(&loaded.sources, label.span)).collect()
}

fn chosen_jobs<'c>(checked: &'c Checked, options: &Options, diagnostics: &mut Vec<Diagnostic>) -> Vec<&'c CheckedJob> {
    let Some(name) = &options.job else { return checked.jobs.iter().collect() };
    let chosen: Vec<&CheckedJob> = checked.jobs.iter().filter(|job| job.name == *name).collect();
    // A file with errors may have lost the job with them.
    if chosen.is_empty() && diagnostics.is_empty() {
        let names: Vec<&str> = checked.jobs.iter().map(|job| job.name.as_str()).collect();
        let diagnostic = Diagnostic::placeless(codes::E0213, format!("the file has no job `{name}`"));
        diagnostics.push(match names.as_slice() {
            [] => diagnostic.note("it has no job at all"),
            names => diagnostic.note(format!("its jobs: {}", check::types::listed(names.iter().copied()))),
        });
    }
    chosen
}

/// By file and place, each once. What has no place comes first.
fn in_order(mut diagnostics: Vec<Diagnostic>) -> Vec<Diagnostic> {
    let place = |d: &Diagnostic| d.primary.as_ref().map(|label| (label.span.file, label.span.start, label.span.end));
    diagnostics.sort_by_key(|d| (place(d), d.severity == Severity::Warning, d.code));
    diagnostics.dedup();
    diagnostics
}

impl<'a> Evaluator<'a> {
    /// Evaluates the values of all files; `said` is what loading and checking found.
    fn new(checked: &'a Checked, sources: &'a Sources, said: Vec<Diagnostic>) -> Evaluator<'a> {
        let globals = vec![None; checked.globals.len()];
        let mut evaluator = Evaluator { checked, sources, globals, depth: 0, steps: 0, diagnostics: said };
        evaluator.globals();
        evaluator.asserts();
        evaluator
    }

    fn job(&mut self, job: &CheckedJob) -> Option<CompiledJob> {
        // The wavelength first: the rest may be counted in it.
        let stated = given_fields(&job.record).iter().find(|field| field.name == "wavelength");
        let wavelength = stated
            .and_then(|field| self.value(&field.value, Surroundings::default()))
            .and_then(|value| value.as_quantity())
            .map(|quantity| quantity.value);
        let value = self.value(&job.record, Surroundings { wavelength, ..Surroundings::default() });
        let requirements: Vec<Option<Requirement>> =
            job.requirements.iter().map(|line| self.requirement(line, wavelength)).collect();
        let (value, requirements) = value.zip(requirements.into_iter().collect::<Option<Vec<Requirement>>>())?;
        let mut origins = Origins::default();
        value.origins("", &mut origins.0);
        let fields = self.shown_fields(&value);
        let params = self.params();
        match from_value::<Job>(&value) {
            Ok(described) => Some(CompiledJob {
                name: job.name.clone(),
                name_span: job.name_span,
                job: described,
                origins,
                requirements,
                params,
                fields,
            }),
            Err(why) => {
                let message = format!("this job does not fit the compiler: {why}");
                let note = "the vocabulary and the compiler disagree; this is a bug of polishc, please report it";
                self.say(Diagnostic::error(codes::E0301, job.name_span, message).note(note));
                None
            }
        }
    }

    fn params(&self) -> Vec<ParamValue> {
        let mut params = Vec::new();
        for (global, value) in self.checked.globals.iter().zip(&self.globals) {
            if let (true, Some(value)) = (global.is_param, value) {
                let (name, doc, value) = (global.name.clone(), global.doc.clone(), self.shown(value));
                params.push(ParamValue { name, doc, value, span: global.span });
            }
        }
        params
    }

    /// Every default of a schema keeps to the limits of its own field.
    fn defaults_keep_to_limits(&mut self) {
        let checked = self.checked;
        for schema in &checked.vocabulary.schemas {
            for field in &schema.fields {
                let Some(default) = &field.default else { continue };
                if let Some(value) = self.value(default, Surroundings::default()) {
                    let what = format!("`{}`", field.name);
                    self.keeps_to(&value, &field.ty, &what, field.restriction.as_ref(), field.usual.as_ref());
                }
            }
        }
    }
}
