//! The session: all passes in order, for the jobs of one file. The library's front door.
//!
//! In: a [`FileProvider`], a [`Request`]. Out: a [`Compilation`]: the sources read, everything there is to say, and what
//! was planned for each job. Nothing is written and no clock is read: [`Watch`] tells the caller which pass begins.

pub mod allow;
mod hashed;
mod passes;
mod requirements;
pub mod simulation;

use crate::check;
use crate::diagnostics::codes as code;
use crate::diagnostics::render;
use crate::diagnostics::{Diagnostic, Problem, Severity};
use crate::dwell::{self, TimedPath};
use crate::eval::{self, Requirement};
use crate::forecast::{Expected, Prospect, Stock};
use crate::height_map;
use crate::job::{self, Job, Origins};
use crate::metrology::{self, ErrorMap, SurfaceFigures};
use crate::motion::{Checked, Motion, Purpose};
use crate::path::{self, ToolPath};
use crate::report::{self, Input, JobResult};
use crate::simulate::inspect::RunFacts;
use crate::simulate::{self, log};
use crate::source::{FileProvider, Sources, Span};
use crate::syntax;
use crate::syntax::ast::Allow;
use crate::target::{self, Program};
use crate::tool::InfluenceField;
use crate::verify::{self, Verified};
use crate::workpiece::form::Surface;
use hashed::Hashed;
use passes::Passes;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Told when a pass begins.
pub trait Watch {
    /// `name` is the pass: `check`, `metrology`, `path`, `forecast`, `dwell`, `motion`, `target`, `verify`.
    fn pass(&self, name: &'static str);
}

/// Nobody watches.
pub struct Unwatched;

impl Watch for Unwatched {
    fn pass(&self, _: &'static str) {}
}

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Until {
    /// Names, types, dimensions, ranges: the job is evaluated, no data file is read.
    Types,
    Path,
    Dwell,
    Motion,
    Program,
}

/// What is to be compiled.
#[derive(Clone, Debug)]
pub struct Request {
    /// The job file.
    pub path: String,
    /// `--set NAME=VALUE`.
    pub sets: Vec<(String, String)>,
    /// Only this job of the file.
    pub job: Option<String>,
    /// Whether what comes after is done with one job: then a file with several is refused (E0213) unless `job` names one.
    pub one_job: bool,
    pub purpose: Purpose,
    pub until: Until,
    /// Whether the table of residual against machine time is wanted.
    pub pareto: bool,
    pub warnings_are_errors: bool,
}

impl Request {
    /// The whole way, for polishing, nothing set.
    pub fn new(path: &str) -> Request {
        Request {
            path: path.into(),
            sets: Vec::new(),
            job: None,
            one_job: false,
            purpose: Purpose::Polish,
            until: Until::Program,
            pareto: false,
            warnings_are_errors: false,
        }
    }
}

/// What came of a request.
#[derive(Debug, Default)]
pub struct Compilation {
    pub sources: Sources,
    /// In order of place.
    pub diagnostics: Vec<Diagnostic>,
    pub jobs: Vec<Planned>,
    warnings_are_errors: bool,
}

impl Compilation {
    /// The tree of the job file, for people who work on the compiler.
    pub fn ast(&self) -> String {
        let Some((file, _, text)) = self.sources.iter().next() else { return String::new() };
        format!("{:#?}\n", syntax::parse(file, text).0)
    }

    /// Whether anything said is an error (or a warning, where those are denied).
    pub fn failed(&self) -> bool {
        self.diagnostics.iter().any(|d| self.warnings_are_errors || d.severity == Severity::Error)
    }
}

/// One job, as far as it came.
#[derive(Debug)]
pub struct Planned {
    pub name: String,
    pub job: Job,
    pub origins: Origins,
    pub requirements: Vec<Requirement>,
    pub error_map: Option<ErrorMap>,
    /// The figures that the job asks for: of the error map, and of what is predicted to be left.
    pub figures: Option<[SurfaceFigures; 2]>,
    /// The nominal surface.
    surface: Option<Arc<dyn Surface>>,
    /// The path, until a later pass takes it over; see [`Planned::path`].
    path: Option<ToolPath>,
    /// Its `timed` is empty once motion has taken it over; see [`Planned::timed`].
    pub dwell: Option<dwell::Outcome>,
    /// Residual against machine time, if the request asks for it.
    pub pareto: Option<report::ParetoResult>,
    /// What could be said before the dwell was solved.
    pub prospect: Option<Prospect>,
    pub stock: Option<Stock>,
    /// What will come of the run, if the job states how well it knows what it was planned from.
    pub expected: Option<Expected>,
    /// What the tool removes where.
    pub influence: Option<InfluenceField>,
    /// What the expectation reckons with: the job's, and of the gain, where the job says nothing, what several spots say.
    uncertainty: Option<job::Uncertainty>,
    pub motion: Option<Checked<Motion>>,
    pub program: Option<Verified<Program>>,
    pub result: Option<JobResult>,
}

/// Compiles the jobs of one file.
pub fn compile(files: &dyn FileProvider, request: &Request, watch: &dyn Watch) -> Compilation {
    watch.pass("check");
    let files = &Hashed::new(files);
    let options = eval::Options { sets: request.sets.clone(), job: request.job.clone() };
    let compiled = eval::compile(files, &request.path, &options);
    let mut done = Compilation {
        sources: compiled.sources,
        diagnostics: compiled.diagnostics,
        jobs: Vec::new(),
        warnings_are_errors: request.warnings_are_errors,
    };
    let mut jobs = compiled.jobs;
    if request.one_job && jobs.len() > 1 {
        done.diagnostics.push(several(&jobs));
        jobs.clear();
    }
    for job in jobs {
        let mut planned = Planned {
            name: job.name,
            job: job.job,
            origins: job.origins,
            requirements: job.requirements,
            error_map: None,
            figures: None,
            surface: None,
            path: None,
            dwell: None,
            pareto: None,
            prospect: None,
            stock: None,
            expected: None,
            influence: None,
            uncertainty: None,
            motion: None,
            program: None,
            result: None,
        };
        if request.until > Until::Types {
            let mut said = Vec::new();
            let mut passes = Passes { files, request, watch, planned: &mut planned, said: &mut said };
            if let Err(problems) = passes.run() {
                said.extend(problems);
            }
            let whole_way = request.until == Until::Program && request.purpose == Purpose::Polish;
            if whole_way && !said.iter().any(|problem| problem.severity == Severity::Error) {
                said.extend(planned.required_nothing());
            }
            let in_text = |problem| in_text(problem, &planned.origins, &done.sources);
            let mut found: Vec<Diagnostic> = said.into_iter().map(in_text).collect();
            if whole_way && !found.iter().any(|d| d.severity == Severity::Error) {
                found.extend(planned.doubtful());
            }
            let warnings = warnings(&found, &compiled.allows);
            let inputs = planned.inputs(files, &done.sources, &request.path);
            planned.summarise(request.purpose, &request.path, inputs, warnings);
            // A program for polishing must do what the job requires; a rehearsal, or a look at a form on the way, need not.
            let finished = !found.iter().any(|d| d.severity == Severity::Error);
            if finished && whole_way {
                done.diagnostics.extend(planned.unmet());
            }
            done.diagnostics.extend(found);
        }
        done.jobs.push(planned);
    }
    let finished = !done.diagnostics.iter().any(|d| d.severity == Severity::Error) && request.job.is_none();
    // Where there is nothing to polish the later passes found nothing because they did not run.
    let all_passes = done.jobs.iter().all(|planned| planned.nothing().is_none());
    let whole_way = request.until == Until::Program && request.purpose == Purpose::Polish && all_passes;
    allow::silence(&mut done.diagnostics, &compiled.allows, |allow| {
        // A library is used by other jobs too, in which the passes may find what they do not find in this one.
        let ours = done.sources.name(allow.span.file) == request.path;
        finished && (of_text(&allow.code.text) || (whole_way && ours))
    });
    render::sort(&mut done.diagnostics);
    done
}

/// E0213 for a file that holds several jobs where one is asked for. Taking the first would show another mirror than the one meant.
fn several(jobs: &[eval::CompiledJob]) -> Diagnostic {
    let names: Vec<String> = jobs.iter().map(|job| format!("`{}`", job.name)).collect();
    Diagnostic::placeless(code::E0213, format!("the file has {} jobs, and none of them is named", jobs.len()))
        .note(format!("its jobs: {}", names.join(", ")))
        .help("name one of them: `--job NAME`, or `--name NAME` for `verify`")
}

/// Whether a code belongs to the text (syntax to values), not to a pass after it.
fn of_text(code: &str) -> bool {
    code.get(1..3).is_some_and(|range| range <= "04")
}

/// The warnings as the result keeps them: those that are allowed too, with the reason.
fn warnings(found: &[Diagnostic], allows: &[Allow]) -> Vec<String> {
    let warnings = found.iter().filter(|d| d.severity == Severity::Warning);
    let with_reason = |d: &Diagnostic| match allow::reason(d, allows) {
        Some(reason) => format!("{}: {} (allowed: {reason})", d.code, d.message),
        None => format!("{}: {}", d.code, d.message),
    };
    warnings.map(with_reason).collect()
}

/// What a pass said of a field, put at the line of the job that said the field.
fn in_text(problem: Problem, origins: &Origins, sources: &Sources) -> Diagnostic {
    // A value of the standard library is right as it stands; what is wrong is the line that took it for this job.
    let ours = |span: &Span| !sources.name(span.file).starts_with(check::library::PREFIX);
    let span = problem.field.as_deref().and_then(|field| origins.find(field, ours)).map(|span| head(span, sources));
    let mut diagnostic = match span {
        Some(span) => Diagnostic::error(problem.code, span, problem.message),
        None => Diagnostic::placeless(problem.code, problem.message),
    };
    diagnostic.severity = problem.severity;
    diagnostic.notes = problem.notes;
    diagnostic.help = problem.help;
    diagnostic
}

/// Of a value over several lines the first line without its bracket: `height_map`, `frame`. What matters is which one.
fn head(span: Span, sources: &Sources) -> Span {
    let text = sources.slice(span);
    match text.split_once('\n') {
        Some((first, _)) => {
            let length = first.trim_end().trim_end_matches('{').trim_end().len().max(1);
            Span { end: span.start + length as u32, ..span }
        }
        None => span,
    }
}

/// Says whether an edited or foreign `program` does what the job of `done` asks, as diagnostics of `done`.
/// The job must have been compiled as far as [`Until::Motion`].
pub fn verify(done: &mut Compilation, program: &Program) {
    let Some(planned) = done.jobs.first() else { return };
    let problems = match (&planned.motion, &planned.surface) {
        (Some(checked), Some(surface)) => {
            let mut problems = verify::check(program, checked, &planned.job, &**surface);
            if let (Some(help), Some(first)) = (other_purpose(program, checked.purpose), problems.first_mut()) {
                first.help = Some(help.into());
            }
            problems
        }
        _ if planned.nothing().is_some() => vec![no_program()],
        _ => vec![target::no_target()],
    };
    let found: Vec<Diagnostic> =
        problems.into_iter().map(|problem| in_text(problem, &planned.origins, &done.sources)).collect();
    done.diagnostics.extend(found);
    render::sort(&mut done.diagnostics);
}

/// E0688: of a job that finds nothing to polish there is no program to look at.
fn no_program() -> Problem {
    Problem::error(code::E0688, "path", "the job finds nothing to polish, so no program does what it asks")
        .help("do not run it; a program of an earlier cycle belongs to an earlier map")
}

/// What to say of a program that was written for another purpose: the names of a dry run's files say so.
fn other_purpose(program: &Program, wanted: Purpose) -> Option<&'static str> {
    let dry = program.files.iter().any(|file| file.name.to_lowercase().contains("_dry"));
    match (wanted, dry) {
        (Purpose::Polish, true) => Some("this is a dry run: compare it with `--for dry_run`"),
        (Purpose::DryRun, false) => Some("this is no dry run: compare it without `--for dry_run`"),
        _ => None,
    }
}

impl Planned {
    /// The path, from whichever pass holds it.
    pub fn path(&self) -> Option<&ToolPath> {
        self.path.as_ref().or_else(|| self.timed().map(|timed| &timed.path))
    }

    /// The path with its speeds: those of the motion, where there is one (a dry run's are slower than dwell's).
    pub fn timed(&self) -> Option<&TimedPath> {
        match (&self.motion, &self.dwell) {
            (Some(motion), _) => Some(&motion.timed),
            (None, Some(outcome)) => Some(&outcome.timed),
            (None, None) => None,
        }
    }

    /// The map and the empty region of a path that finds nothing to polish.
    pub fn nothing(&self) -> Option<(&ErrorMap, &path::region::Figures)> {
        let path = self.path.as_ref().filter(|path| path.points.is_empty())?;
        Some((self.error_map.as_ref()?, path.region.as_ref()?))
    }

    /// What is said beside the solution.
    fn beside(&self) -> report::Beside<'_> {
        report::Beside {
            prospect: self.prospect.as_ref(),
            stock: self.stock.as_ref(),
            expected: self.expected.as_ref(),
        }
    }

    /// The results that are known.
    fn known(&self) -> BTreeMap<String, f64> {
        let Some(path) = self.path() else { return BTreeMap::new() };
        let mut results = match (&self.dwell, self.nothing()) {
            (Some(outcome), _) => {
                report::results(outcome, self.beside(), path, self.motion.as_deref(), self.program.as_deref())
            }
            (None, Some((error, region))) => report::results_of_nothing(error, region),
            (None, None) => BTreeMap::new(),
        };
        if let Some([_, predicted]) = &self.figures {
            results.extend(report::metrology::results(predicted));
        }
        results
    }

    /// Puts together what is known.
    fn summarise(&mut self, purpose: Purpose, job_file: &str, inputs: Vec<Input>, warnings: Vec<String>) {
        let Some(path) = self.path() else { return };
        let program = self.program.as_deref();
        let (dwell, predicted) = match (&self.dwell, self.nothing()) {
            (Some(outcome), _) => (
                Some(report::dwell(outcome)),
                report::predicted(
                    outcome,
                    self.expected.as_ref(),
                    self.uncertainty.as_ref(),
                    purpose == Purpose::DryRun,
                ),
            ),
            (None, Some((error, _))) => (None, report::untouched(error)),
            (None, None) => return,
        };
        let results = self.known();
        self.result = Some(JobResult {
            name: self.name.clone(),
            part: self.job.workpiece.part.clone(),
            purpose: match purpose {
                Purpose::Polish => "polish",
                Purpose::DryRun => "dry_run",
            },
            programs: report::programs(program),
            cycle: self.job.cycle,
            after: self.job.after.clone(),
            nothing_to_polish: self.nothing().map(|(_, region)| report::nothing(region)),
            metrology: self.error_map.as_ref().map(|map| {
                let figures = self.job.figures.as_ref().zip(self.figures.as_ref());
                report::metrology::result(map, figures, |path| shown(path, job_file))
            }),
            path: report::path(path),
            dwell,
            predicted,
            correctable: self.prospect.as_ref().map(report::correctable),
            reach: self.prospect.as_ref().map(report::reach),
            stock: self.stock.as_ref().map(report::stock),
            spots: self.influence.as_ref().and_then(|influence| influence.spread).map(report::spots),
            motion: self.motion.as_deref().map(report::motion),
            inputs,
            requirements: self.requirements.iter().map(|r| report::requirement(r, &results)).collect(),
            warnings,
            unchecked: target::facts::unchecked(&self.job),
            note: target::facts::note(&self.job),
        });
    }

    /// The files that the job was made from, by content: the texts, then the data. Names are relative to the job's folder
    /// (the last part alone for a file elsewhere), so that a build in another place is the same.
    fn inputs(&self, files: &Hashed, sources: &Sources, job: &str) -> Vec<Input> {
        let input =
            |path: &str, hash: blake3::Hash| Input { file: shown(path, job), blake3: hash.to_hex().to_string() };
        // stdlib belongs to the compiler, whose version is stated; values of `--set` stand in no file.
        let texts = sources.iter().filter(|(_, name, _)| !name.starts_with(['<', '-']));
        let workpiece = &self.job.workpiece;
        let wanted = workpiece.target.iter().flat_map(job::FormError::files);
        let data = workpiece
            .error
            .files()
            .into_iter()
            .chain(wanted)
            .chain(workpiece.form.files())
            .chain(self.job.tool.influence().files())
            // What a job names and no pass has read made nothing of the plan.
            .filter_map(|path| Some(input(path, files.hash(path)?)));
        texts.map(|(_, name, text)| input(name, blake3::hash(text.as_bytes()))).chain(data).collect()
    }
}

/// A file's name in a result: relative to the job's folder, the last part alone for a file elsewhere.
fn shown(path: &str, job: &str) -> String {
    let folder = job.rfind('/').map_or("", |slash| &job[..=slash]);
    let last = path.rsplit(['/', '\\']).next().unwrap_or(path);
    path.strip_prefix(folder).filter(|rest| !rest.starts_with('/')).unwrap_or(last).to_string()
}

/// A problem that no job stands behind, as a diagnostic.
pub fn placeless(problem: Problem) -> Diagnostic {
    in_text(problem, &Origins::default(), &Sources::default())
}

/// What is in a data file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Inspection {
    Heights(metrology::Inspection),
    Run(RunFacts),
}

/// What is in the data file at `path`: heights, or the log of a run. `unit` is the height that the value 1 means and `pixel` a
/// pixel's side, in metres, where the file does not say them.
pub fn inspect(
    files: &dyn FileProvider,
    path: &str,
    unit: Option<f64>,
    pixel: Option<f64>,
) -> Result<Inspection, Problem> {
    let found = height_map::file_bytes(path, files).and_then(|bytes| match log::layout(&bytes) {
        Some(layout) => {
            if let Some((option, _)) = [("unit", unit), ("pixel", pixel)].iter().find(|(_, stated)| stated.is_some()) {
                let message = format!("`{path}` is the log of a run, which states its units");
                return Err(Problem::error(code::E0507, *option, message).help(format!("leave `--{option}` out")));
            }
            simulate::inspect::inspect(&bytes, path, layout).map(Inspection::Run)
        }
        None => metrology::inspect(&bytes, path, unit, pixel).map(Inspection::Heights),
    });
    found.map_err(|mut problem| {
        // No job stands behind: the sentence must say itself which file it speaks of.
        if !problem.message.contains(path) {
            problem.message = format!("`{path}`: {}", problem.message);
        }
        problem
    })
}
