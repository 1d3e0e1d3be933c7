//! What each command does: ask the library, show, write, and say how it ended.
#![allow(clippy::disallowed_methods, reason = "cli is where disk, clock and environment are")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "cli is where standard output is")]

use super::arguments::{Arguments, Command, Common, Deny, Emit, For, MessageFormat};
use super::disk::Disk;
use super::output::{self, Output, RealFolder};
use super::terminal::{BUG, Timings, WRONG_COMMAND, WRONG_INPUT, finish, say, show};
use super::{doc, figures, fmt, new, show as shown, simulate, sweep};
use crate::diagnostics::codes as code;
use crate::diagnostics::{Code, Diagnostic};
use crate::height_map;
use crate::metrology;
use crate::motion::Purpose;
use crate::report::{self, ResultFile};
use crate::session::{self, Compilation, Planned, Request, Until, Watch};
use crate::source::Sources;
use crate::target::Program;
use clap::{Parser, ValueEnum};
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs the command line `arguments` (the first is the program's name) and says how it ended.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            let asked_for_help = !error.use_stderr();
            error.print().ok();
            return ExitCode::from(if asked_for_help { 0 } else { WRONG_COMMAND });
        }
    };
    std::panic::set_hook(Box::new(|info| {
        eprintln!("polishc has a bug: {info}");
        eprintln!("Nothing was written. Please report it with the job, its data and the line above.");
    }));
    let threads = arguments.common.threads.map_or(0, usize::from);
    let pool = match rayon::ThreadPoolBuilder::new().num_threads(threads).build() {
        Ok(pool) => pool,
        Err(error) => {
            eprintln!("polishc could not start its threads: {error}");
            return ExitCode::from(WRONG_INPUT);
        }
    };
    let ended = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| pool.install(|| dispatch(&arguments))));
    ExitCode::from(ended.unwrap_or(BUG))
}

fn dispatch(arguments: &Arguments) -> u8 {
    let common = &arguments.common;
    match &arguments.command {
        Command::Check { files, fast, set } => {
            let mut status = 0;
            for file in files {
                let until = if *fast { Until::Types } else { Until::Program };
                status = status.max(check(common, file, set, until));
            }
            status
        }
        Command::Build { file, output, job, set, purpose, emit } => {
            build(common, file, output.as_deref(), job.as_deref(), set, *purpose, emit)
        }
        Command::Verify { programs, file, name, set, purpose } => {
            verify(common, programs, file, name.as_deref(), set, *purpose)
        }
        Command::Inspect { files, json, unit, pixel } => {
            inspect(common, files, *json, unit.as_deref(), pixel.as_deref())
        }
        Command::New { folder, template } => new::project(common, folder, *template),
        Command::Simulate { file, program, log, frame, output, job, set } => {
            let until = if program.is_empty() && log.is_none() { Until::Program } else { Until::Motion };
            let request = Request { one_job: true, ..request(common, file, job.as_deref(), set, For::Polish, until) };
            simulate::simulate(common, &request, (program, log.as_deref(), *frame), output.as_deref())
        }
        Command::Sweep { file, over, job, set } => {
            let request = request(common, file, job.as_deref(), set, For::Polish, Until::Program);
            sweep::sweep(common, &request, over)
        }
        Command::Show { file, defaults, job, set } => {
            let options = crate::eval::Options { sets: sets(set), job: job.clone() };
            shown::job(common, file, &options, *defaults)
        }
        Command::Fmt { files, check } => fmt::format(common, files, *check),
        Command::Doc { html: true, output, .. } => doc::page(common, output.as_deref()),
        Command::Doc { name, .. } => doc::word(common, name.as_deref()),
        Command::Explain { code } => explain(code),
        Command::Completions { shell } => {
            clap_complete::generate(*shell, &mut super::command(), "polishc", &mut std::io::stdout());
            0
        }
    }
}

/// The pairs of `--set NAME=VALUE`.
pub fn sets(set: &[String]) -> Vec<(String, String)> {
    let pair = |pair: &String| match pair.split_once('=') {
        Some((name, value)) => (name.trim().to_string(), value.trim().to_string()),
        None => (pair.trim().to_string(), String::new()),
    };
    set.iter().map(pair).collect()
}

fn request(common: &Common, file: &Path, job: Option<&str>, set: &[String], purpose: For, until: Until) -> Request {
    Request {
        path: file.to_string_lossy().into_owned(),
        sets: sets(set),
        job: job.map(str::to_string),
        one_job: false,
        purpose: match purpose {
            For::Polish => Purpose::Polish,
            For::DryRun => Purpose::DryRun,
        },
        until,
        pareto: false,
        warnings_are_errors: common.deny == Some(Deny::Warnings),
    }
}

fn check(common: &Common, file: &Path, set: &[String], until: Until) -> u8 {
    let timings = Timings::new();
    let disk = Disk::new(file, common.allow_outside);
    let done = session::compile(&disk, &request(common, file, None, set, For::Polish, until), &timings);
    show(common, &done.sources, &done.diagnostics);
    let status = if done.failed() { WRONG_INPUT } else { 0 };
    if status == 0 && !common.quiet && common.message_format != MessageFormat::Json {
        say(&format!("{}: good", file.display()));
        for result in done.jobs.iter().filter_map(|planned| planned.result.as_ref()) {
            say(&format!("{} ({})", result.name, result.part));
            figures::lines(result).iter().for_each(|line| say(line));
        }
    }
    finish(common, &timings, status)
}

fn build(
    common: &Common,
    file: &Path,
    folder: Option<&Path>,
    job: Option<&str>,
    set: &[String],
    purpose: For,
    emit: &[Emit],
) -> u8 {
    let timings = Timings::new();
    let disk = Disk::new(file, common.allow_outside);
    let programs = emit.is_empty() || emit.contains(&Emit::Program);
    let until =
        if programs { Until::Program } else { emit.iter().map(|form| until_of(*form)).max().unwrap_or(Until::Program) };
    let request = Request { pareto: emit.contains(&Emit::Pareto), ..request(common, file, job, set, purpose, until) };
    let mut done = session::compile(&disk, &request, &timings);
    if done.failed() {
        show(common, &done.sources, &done.diagnostics);
        return finish(common, &timings, WRONG_INPUT);
    }
    timings.pass("write");
    for form in emit {
        if let Some(planned) = done.jobs.iter().find(|planned| {
            *form != Emit::Program && planned.nothing().is_none() && emitted(&done, planned, *form).is_none()
        }) {
            let word = form.to_possible_value().map(|value| value.get_name().to_string()).unwrap_or_default();
            let message = format!("the job `{}` has no `{word}` to emit", planned.name);
            done.diagnostics.push(
                Diagnostic::placeless(code::E1203, message).help("`motion` needs a `robot` and a `target` in the job"),
            );
            show(common, &done.sources, &done.diagnostics);
            return finish(common, &timings, WRONG_INPUT);
        }
    }
    let outputs: Vec<Output> = done
        .jobs
        .iter()
        .map(|planned| {
            let folder = match folder {
                // Several jobs never share a folder.
                Some(folder) if done.jobs.len() > 1 => folder.join(&planned.name),
                Some(folder) => folder.to_path_buf(),
                None => Path::new("out").join(&planned.name),
            };
            let files = files_of(&done, planned, emit, programs);
            let stale = stale_files(&folder, &files);
            Output { folder, files, stale }
        })
        .collect();
    if let Err(message) = output::write_all(&mut RealFolder, &outputs) {
        done.diagnostics.push(
            Diagnostic::placeless(code::E1201, message)
                .help("nothing was written; choose a folder that can be written to with `-o DIR`, or make room"),
        );
        show(common, &done.sources, &done.diagnostics);
        return finish(common, &timings, WRONG_INPUT);
    }
    show(common, &done.sources, &done.diagnostics);
    if !common.quiet && common.message_format != MessageFormat::Json {
        for (planned, output) in done.jobs.iter().zip(&outputs) {
            tell(planned, &output.folder, &output.files);
        }
    }
    finish(common, &timings, 0)
}

fn until_of(form: Emit) -> Until {
    match form {
        Emit::Ast | Emit::Job => Until::Types,
        Emit::Path | Emit::Dwell | Emit::Residual | Emit::Pareto | Emit::Psd => Until::Dwell,
        Emit::Motion => Until::Motion,
        Emit::Program => Until::Program,
    }
}

/// The files of one job: programs and result, and the forms that were asked for.
fn files_of(done: &Compilation, planned: &Planned, emit: &[Emit], programs: bool) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<(String, Vec<u8>)> = Vec::new();
    for form in emit {
        files.extend(emitted(done, planned, *form));
    }
    if programs {
        if let Some(program) = &planned.program {
            files.extend(program.files.iter().map(|f| (f.name.clone(), f.bytes.clone())));
        }
        if let Some(result) = &planned.result {
            let whole = ResultFile { polishc: env!("CARGO_PKG_VERSION"), jobs: vec![result.clone()] };
            let text = serde_json::to_string_pretty(&whole).unwrap_or_default() + "\n";
            files.push(("result.json".into(), text.into_bytes()));
        }
    }
    files
}

/// One intermediate form, if the job came so far.
fn emitted(done: &Compilation, planned: &Planned, form: Emit) -> Option<(String, Vec<u8>)> {
    let npy = |columns: usize, values: Vec<f64>| height_map::npy::write(columns, &values);
    let (ending, bytes) = match form {
        Emit::Ast => ("ast.txt", Some(done.ast().into_bytes())),
        Emit::Job => ("job.json", serde_json::to_vec_pretty(&planned.job).ok()),
        Emit::Path => {
            let points = &planned.path()?.points;
            let rows = (0..points.len()).flat_map(|i| [points.position(i), points.normal(i)].concat());
            ("path.npy", npy(6, rows.collect()))
        }
        Emit::Dwell => ("dwell.npy", npy(1, planned.timed()?.speed.clone())),
        Emit::Motion => ("motion.npy", npy(6, planned.motion.as_ref()?.joints.concat())),
        Emit::Residual => {
            let residual = &planned.dwell.as_ref()?.residual;
            ("residual.npy", npy(residual.columns, residual.values.clone()))
        }
        Emit::Pareto => ("pareto.json", serde_json::to_vec_pretty(planned.pareto.as_ref()?).ok()),
        Emit::Psd => {
            let of = |grid| metrology::spectrum(grid, &planned.job.workpiece.clear);
            let (before, left) = (of(&planned.error_map.as_ref()?.grid)?, of(&planned.dwell.as_ref()?.residual)?);
            ("psd.json", serde_json::to_vec_pretty(&report::metrology::spectra(&before, &left)).ok())
        }
        Emit::Program => return None,
    };
    Some((format!("{}.{ending}", planned.name), bytes?))
}

/// Programs of an earlier build in the folder that this build does not make: its `result.json` names them.
fn stale_files(folder: &Path, files: &[(String, Vec<u8>)]) -> Vec<String> {
    if !files.iter().any(|(name, _)| name == "result.json") {
        return Vec::new();
    }
    let Ok(text) = std::fs::read_to_string(folder.join("result.json")) else { return Vec::new() };
    let Ok(old) = serde_json::from_str::<serde_json::Value>(&text) else { return Vec::new() };
    let purpose = |result: &serde_json::Value| result["jobs"][0]["for"].clone();
    let new =
        files.iter().find(|(name, _)| name == "result.json").map(|(_, bytes)| bytes.as_slice()).unwrap_or_default();
    // A dry run does not take the polishing program away, nor the other way round.
    if serde_json::from_slice(new).map(|new: serde_json::Value| purpose(&new)).ok() != Some(purpose(&old)) {
        return Vec::new();
    }
    let jobs = old["jobs"].as_array().cloned().unwrap_or_default();
    jobs.iter()
        .flat_map(|job| job["programs"].as_array().cloned().unwrap_or_default())
        .filter_map(|program| program["file"].as_str().map(str::to_string))
        .filter(|name| !name.contains(['/', '\\']) && !files.iter().any(|(new, _)| new == name))
        .collect()
}

/// A few lines on what was written and what it predicts.
fn tell(planned: &Planned, folder: &Path, files: &[(String, Vec<u8>)]) {
    let Some(result) = &planned.result else { return };
    let bytes: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
    say(&format!("{} ({})", result.name, result.part));
    if let Some(first) = result.programs.first() {
        say(&format!(
            "  wrote      {} files, {}, in {}; load `{}`",
            files.len(),
            if bytes < 1_000_000 {
                format!("{} kB", bytes.div_ceil(1000))
            } else {
                format!("{:.1} MB", bytes as f64 / 1e6)
            },
            folder.display(),
            first.file
        ));
    } else {
        let files = if files.len() == 1 { "1 file".to_string() } else { format!("{} files", files.len()) };
        say(&format!("  wrote      {files} in {}", folder.display()));
    }
    if let Some(why) = &result.nothing_to_polish {
        say(&format!("  nothing to polish: {why}"));
        say("  no program");
        return;
    }
    say(&format!("  path       {} points on {} lines", result.path.points, result.path.lines));
    figures::lines(result).iter().for_each(|line| say(line));
    if let Some(pareto) = &planned.pareto {
        say("  to be had      time       RMS        PV     layer");
        for row in &pareto.rows {
            say(&format!(
                "            {:>8.1} min {:>9.3} {:>9.3} {:>9.1} nm",
                row.time_s / 60.0,
                row.rms_nm,
                row.pv_nm,
                row.base_nm
            ));
        }
    }
    if result.programs.is_empty() && files.iter().any(|(name, _)| name == "result.json") {
        say("  no program: the job names no robot and target");
    }
    if !result.programs.is_empty() {
        say(&format!("  unchecked  {}; {}", result.unchecked.join(", "), result.note));
    }
}

fn verify(common: &Common, programs: &[PathBuf], file: &Path, name: Option<&str>, set: &[String], purpose: For) -> u8 {
    let timings = Timings::new();
    let disk = Disk::new(file, common.allow_outside);
    let request = Request { one_job: true, ..request(common, file, name, set, purpose, Until::Motion) };
    let mut done = session::compile(&disk, &request, &timings);
    if done.failed() {
        show(common, &done.sources, &done.diagnostics);
        return finish(common, &timings, WRONG_INPUT);
    }
    let program = read_program(programs, &mut done);
    if !done.failed() {
        timings.pass("verify");
        session::verify(&mut done, &program);
    }
    show(common, &done.sources, &done.diagnostics);
    let status = if done.failed() { WRONG_INPUT } else { 0 };
    if status == 0 && !common.quiet && common.message_format != MessageFormat::Json {
        say(&format!("{} does what {} asks", programs_name(programs), file.display()));
    }
    finish(common, &timings, status)
}

/// The files of a program; what cannot be read is said to `done`.
pub fn read_program(programs: &[PathBuf], done: &mut Compilation) -> Program {
    let mut program = Program::default();
    for path in programs {
        match std::fs::read(path) {
            Ok(bytes) => program.files.push(crate::target::ProgramFile { name: last_name(path), bytes, points: 0 }),
            Err(error) => {
                done.diagnostics.push(Diagnostic::placeless(
                    code::E1202,
                    format!("the program `{}` could not be read: {}", path.display(), output::words(&error)),
                ));
            }
        }
    }
    program
}

/// A path without its folder.
pub fn last_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn programs_name(programs: &[PathBuf]) -> String {
    match programs {
        [one] => one.display().to_string(),
        many => format!("the program of {} files", many.len()),
    }
}

fn inspect(common: &Common, files: &[PathBuf], json: bool, unit: Option<&str>, pixel: Option<&str>) -> u8 {
    let mut status = 0;
    let lengths = [("--unit", unit), ("--pixel", pixel)].map(|(option, text)| match text.map(length) {
        Some(None) => {
            eprintln!("`{option}` takes a length such as `0.5mm`, or a unit of length such as `nm`");
            Err(WRONG_COMMAND)
        }
        Some(found) => Ok(found),
        None => Ok(None),
    });
    let [Ok(unit), Ok(pixel)] = lengths else { return WRONG_COMMAND };
    for file in files {
        let disk = Disk::new(file, true);
        match session::inspect(&disk, &file.to_string_lossy(), unit, pixel) {
            Ok(found) => {
                if json {
                    // The struct itself, not a map of it: the order of the keys is part of the format.
                    say(&serde_json::to_string(&found).unwrap_or_default());
                    continue;
                }
                let found = serde_json::to_value(&found).unwrap_or_default();
                say(&format!("{}", file.display()));
                for (key, value) in found.as_object().into_iter().flatten() {
                    say(&format!("  {key:<16} {}", value.to_string().trim_matches('"')));
                }
            }
            Err(problem) => {
                show(common, &Sources::default(), &[session::placeless(problem)]);
                status = WRONG_INPUT;
            }
        }
    }
    status
}

/// A length of the command line in metres: `0.5mm`, `0.5 mm`, or a unit alone.
fn length(text: &str) -> Option<f64> {
    const UNITS: &[(&str, f64)] = &[("nm", 1e-9), ("um", 1e-6), ("µm", 1e-6), ("mm", 1e-3), ("m", 1.0)];
    let (number, size) = UNITS.iter().find_map(|(unit, size)| Some((text.trim().strip_suffix(unit)?.trim(), size)))?;
    let number: f64 = if number.is_empty() { 1.0 } else { number.parse().ok()? };
    (number > 0.0 && number.is_finite()).then_some(number * size)
}

fn explain(text: &str) -> u8 {
    match Code::find(text) {
        Some(code) => {
            write!(std::io::stdout(), "{}", code.page()).ok();
            0
        }
        None => {
            eprintln!("there is no code `{text}`; codes look like `{}`", code::E0101);
            WRONG_COMMAND
        }
    }
}
