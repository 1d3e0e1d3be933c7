//! `polishc simulate`: what a job's program, an edited program or a run leaves on the part.
#![allow(clippy::disallowed_methods, reason = "cli is where the disk is")]

use super::arguments::{Common, LogFrame, MessageFormat};
use super::commands::{last_name, read_program};
use super::disk::Disk;
use super::figures::{hours, short};
use super::output::{self, Output, RealFolder};
use super::terminal::{Timings, WRONG_INPUT, finish, say, show};
use crate::diagnostics::{Diagnostic, codes as code};
use crate::height_map::npy;
use crate::report::{Input, Met, PlaceResult, SimulationResult};
use crate::session::simulation::{Of, Simulation};
use crate::session::{self, Compilation, Request, Watch, simulation};
use crate::simulate::log::{Frame, MOST_BYTES};
use crate::source::{FileError, FileProvider};
use std::path::{Path, PathBuf};

/// Simulates a job: its own program, or the program or log of `what`, and writes to `folder` if there is one.
pub fn simulate(
    common: &Common,
    request: &Request,
    (programs, log, frame): (&[PathBuf], Option<&Path>, Option<LogFrame>),
    folder: Option<&Path>,
) -> u8 {
    let timings = Timings::new();
    let disk = Disk::new(request.path.as_ref(), common.allow_outside);
    let mut done = session::compile(&disk, request, &timings);
    // That the plan does not do what the job requires is no mistake here: `simulate` shows what it does.
    done.diagnostics.retain(|d| ![code::E1101, code::E1102].contains(&d.code));
    let found = (!done.failed()).then(|| {
        timings.pass("simulate");
        run(&mut done, &disk, (programs, log, frame))
    });
    let (Some(Some(found)), false) = (found, done.failed()) else {
        show(common, &done.sources, &done.diagnostics);
        return finish(common, &timings, WRONG_INPUT);
    };
    let mut written = 0;
    if let Some(folder) = folder {
        timings.pass("write");
        let done_writing =
            files(&found).ok_or_else(|| "the result does not fit into its files".to_string()).and_then(|files| {
                written = files.len();
                let outputs = [Output { folder: folder.to_path_buf(), files, stale: Vec::new() }];
                output::write_all(&mut RealFolder, &outputs)
            });
        if let Err(message) = done_writing {
            done.diagnostics.push(
                Diagnostic::placeless(code::E1201, message)
                    .help("nothing was written; choose a folder that can be written to with `-o DIR`, or make room"),
            );
            show(common, &done.sources, &done.diagnostics);
            return finish(common, &timings, WRONG_INPUT);
        }
    }
    show(common, &done.sources, &done.diagnostics);
    if common.message_format == MessageFormat::Json {
        say(&serde_json::to_string(&found.result).unwrap_or_default());
    } else if !common.quiet {
        tell(&found.result);
        if let Some(folder) = folder {
            say(&format!("  wrote      {written} files in {}", folder.display()));
        }
    }
    finish(common, &timings, 0)
}

fn run(
    done: &mut Compilation,
    disk: &Disk,
    (programs, log, frame): (&[PathBuf], Option<&Path>, Option<LogFrame>),
) -> Option<Simulation> {
    let hash = |name: String, bytes: &[u8]| Input { file: name, blake3: blake3::hash(bytes).to_hex().to_string() };
    if let Some(path) = log {
        // A path of the command line is allowed wherever it lies.
        let read = disk.resolve("", &path.to_string_lossy()).and_then(|whole| disk.read(&whole, MOST_BYTES));
        let bytes = match read {
            Ok(bytes) => bytes,
            Err(error) => {
                let words = match error {
                    FileError::NotFound => "no such file".to_string(),
                    FileError::TooLarge { size, limit } => format!("it has {size} bytes; at most {limit} are read"),
                    FileError::Outside => "it lies outside the project".into(),
                    FileError::Other(words) => words,
                };
                let message = format!("the log `{}` could not be read: {words}", path.display());
                done.diagnostics.push(Diagnostic::placeless(code::E1202, message));
                return None;
            }
        };
        let name = last_name(path);
        let frame = frame.map(|LogFrame::Part| Frame::Part);
        let mut found = simulation::simulate(done, &Of::Run { name: &name, bytes: &bytes, frame })?;
        found.result.files.push(hash(name, &bytes));
        return Some(found);
    }
    if programs.is_empty() {
        return simulation::simulate(done, &Of::Job);
    }
    let program = read_program(programs, done);
    if done.failed() {
        return None;
    }
    let mut found = simulation::simulate(done, &Of::Program(&program))?;
    found.result.files.extend(program.files.iter().map(|file| hash(file.name.clone(), &file.bytes)));
    Some(found)
}

/// `NAME.residual.npy`, `NAME.removal.npy`: metres, the error map's grid, rows towards +y; `simulate.json`. `None` where one of them
/// cannot be written as such.
fn files(found: &Simulation) -> Option<Vec<(String, Vec<u8>)>> {
    let outcome = &found.outcome;
    let mut files = Vec::new();
    for (word, grid) in [("residual", &outcome.residual), ("removal", &outcome.removal)] {
        let bytes = npy::write(grid.columns, &grid.values)?;
        files.push((format!("{}.{word}.npy", found.result.job), bytes));
    }
    let text = serde_json::to_string_pretty(&found.result).ok()? + "\n";
    files.push(("simulate.json".into(), text.into_bytes()));
    Some(files)
}

fn tell(result: &SimulationResult) {
    let of = match (result.of, result.files.as_slice()) {
        ("plan", _) => "as planned".to_string(),
        ("program", []) => "by the text of its program".into(),
        (_, [one]) => format!("by {}", one.file),
        (_, many) => format!("by the program of {} files", many.len()),
    };
    say(&format!("{} ({}), {of}", result.job, result.part));
    let p = &result.predicted;
    say(&format!("  before     RMS {} nm, PV {} nm", short(p.rms_before_nm), short(p.pv_before_nm)));
    let robust = p.pvr_fringe36_nm.map_or(String::new(), |pvr| format!(", PVr {} nm (36 Fringe terms)", short(pvr)));
    say(&format!("  left       RMS {} nm, PV {} nm{robust}", short(p.rms_nm), short(p.pv_nm)));
    if let (Some(ripple), Some(period)) = (p.ripple_nm, p.ripple_period_mm) {
        say(&format!("  ripple     of the pitch: {ripple:.3} nm RMS at {period} mm"));
    }
    say(&format!(
        "  removed    {} nm in the mean, {} nm at most, in {}",
        short(p.removal_mean_nm),
        short(p.removal_max_nm),
        hours(p.time_s)
    ));
    if let Some(d) = &result.against_plan {
        say(&format!(
            "  plan       leaves RMS {} nm, PV {} nm; the removal differs by {} nm RMS, {} nm at most",
            short(d.planned_rms_nm),
            short(d.planned_pv_nm),
            short(d.rms_nm),
            short(d.most_nm.abs())
        ));
    }
    if let Some(run) = &result.run {
        let at = |place: &PlaceResult| format!("x {:.1} mm, y {:.1} mm", place.x_mm, place.y_mm);
        say(&format!(
            "  log        {} samples, one every {} s, {}; {:.1} % of those in contact on the path, {} mm beside it",
            run.samples,
            run.interval_s,
            hours(run.duration_s),
            run.on_path * 100.0,
            short(run.beside_mm)
        ));
        let sign = |share: f64| format!("{:+.1} %", share * 100.0);
        say(&format!(
            "  speed      {} in the mean, {:.1} % RMS, at most {} at {}",
            sign(run.mean_speed_error),
            run.rms_speed_error * 100.0,
            sign(run.most_speed_error.value),
            at(&run.most_speed_error)
        ));
    }
    for requirement in &result.requirements {
        let word = if requirement.met == Met::Yes { "met" } else { "not met" };
        say(&format!("  {word:<9}  {} (is {})", requirement.text, requirement.value));
    }
}
