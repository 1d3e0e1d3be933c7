//! The session: all passes in order, for the jobs of one file. The library's front door.
//!
//! In: a [`FileProvider`], a [`Request`]. Out: a [`Compilation`]: the sources read, everything there is to say, and what
//! was planned for each job. Nothing is written and no clock is read: [`Watch`] tells the caller which pass begins.

use crate::check;
use crate::diagnostics::codes as code;
use crate::diagnostics::render;
use crate::diagnostics::{Diagnostic, Problem, Severity};
use crate::dwell;
use crate::eval::Requirement;
use crate::job::{self, Job, Origins};
use crate::metrology::{self, ErrorMap};
use crate::motion::{self, Checked, Motion, Purpose};
use crate::path::{self, ToolPath};
use crate::report::{self, JobResult};
use crate::source::{FileProvider, Sources};
use crate::target::{self, Program};
use crate::tool::InfluenceFunction;
use crate::verify::{self, Verified};
use crate::workpiece;
use std::collections::BTreeMap;

/// Told when a pass begins.
pub trait Watch {
    /// `name` is the pass: `check`, `metrology`, `path`, `dwell`, `motion`, `target`, `verify`.
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
    pub purpose: Purpose,
    pub until: Until,
    pub warnings_are_errors: bool,
}

impl Request {
    /// The whole way, for polishing, nothing set.
    pub fn new(path: &str) -> Request {
        Request {
            path: path.into(),
            sets: Vec::new(),
            job: None,
            purpose: Purpose::Polish,
            until: Until::Program,
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
    pub path: Option<ToolPath>,
    pub dwell: Option<dwell::Outcome>,
    pub motion: Option<Checked<Motion>>,
    pub program: Option<Verified<Program>>,
    pub result: Option<JobResult>,
}

/// Compiles the jobs of one file.
pub fn compile(files: &dyn FileProvider, request: &Request, watch: &dyn Watch) -> Compilation {
    watch.pass("check");
    let options = check::Options { sets: request.sets.clone(), job: request.job.clone() };
    let compiled = crate::eval::compile(files, &request.path, &options);
    let mut done = Compilation {
        sources: compiled.sources,
        diagnostics: compiled.diagnostics,
        jobs: Vec::new(),
        warnings_are_errors: request.warnings_are_errors,
    };
    if !done.diagnostics.iter().any(|d| d.severity == Severity::Error) {
        for job in compiled.jobs {
            let mut planned = Planned {
                name: job.name,
                job: job.job,
                origins: job.origins,
                requirements: job.requirements,
                error_map: None,
                path: None,
                dwell: None,
                motion: None,
                program: None,
                result: None,
            };
            let mut problems = Vec::new();
            if let Err(problem) = plan(files, request, watch, &mut planned, &mut problems) {
                problems.push(problem);
            }
            done.diagnostics.extend(problems.into_iter().map(|p| placed(p, &planned.origins)));
            done.jobs.push(planned);
        }
    }
    render::sort(&mut done.diagnostics);
    done
}
