//! Run record: which runs removed glass from the part, and so which maps are void.
//!
//! In: the job, and the folder `runs` beside its file. Out: what is wrong with `cycle`, `after` and the maps.
//!
//! After a polishing run the shop copies the folder of the build that was run to `runs/NNNN`, NNNN its number; the
//! `result.json` in it says the part and the content of every file that the build was made from. A map that stands
//! there was measured before glass was removed: it must not be used again. Dry runs remove nothing and do not count.

use crate::diagnostics::{Problem, codes};
use crate::height_map::file_bytes;
use crate::job::Job;
use crate::source::{FileError, FileProvider};
use serde_json::Value;

/// The folder beside the job.
pub const FOLDER: &str = "runs";

/// What stands in a run's folder.
const RESULT: &str = "result.json";

/// Most bytes of a result: a build's has some tens of kilobytes.
const MOST_BYTES: u64 = 16 << 20;

/// Most entries of the folder that are looked at.
const MOST_RUNS: usize = 10_000;

/// A polishing run of one part.
struct Run {
    /// `runs/0002`.
    name: String,
    number: u64,
    /// Hashes of the files that its build was made from.
    inputs: Vec<String>,
}

/// What is wrong with the job's `cycle`, `after` and maps. `job_file` is the file that says the job.
///
/// # Errors
/// E0540 for a map that a run made void, E0541 for an `after` that is not the latest run, E0542 for a `cycle` that is not
/// the next, E0543 for a record that cannot be read.
pub fn check(job_file: &str, job: &Job, files: &dyn FileProvider) -> Result<(), Problem> {
    let runs = polishing_runs(job_file, &job.workpiece.part, files)?;
    let measurements = job.workpiece.error.measurements();
    for map in &measurements {
        // A file that cannot be read is refused by those who need it.
        let Ok(bytes) = file_bytes(&map.file, files) else { continue };
        let hash = blake3::hash(&bytes).to_hex();
        if let Some(run) = runs.iter().find(|run| run.inputs.iter().any(|input| input.as_str() == hash.as_str())) {
            let message = format!(
                "the map `{}` was measured before the run `{}` removed glass from the part",
                map.file, run.name
            );
            return Err(Problem::error(codes::E0540, "workpiece.error", message)
                .help("measure the part as it is now; polishing the same error twice doubles it the other way"));
        }
    }
    match (&job.after, runs.last()) {
        (None, None) => {}
        (Some(after), None) => {
            let message =
                format!("the map was measured after `{after}`, and there is no polishing run of this part on record");
            return Err(Problem::error(codes::E0541, "after", message).help(
                "copy the folder of the build that was run to `runs/0001` beside the job, or leave `after` out if the part \
                 was not polished yet",
            ));
        }
        (Some(after), Some(last)) if after.trim_end_matches('/') != last.name => {
            let message = format!(
                "the map was measured after `{after}`, and the latest polishing run of this part is `{}`",
                last.name
            );
            return Err(Problem::error(codes::E0541, "after", message)
                .help(format!("measure the part again, then say `after: \"{}\"`", last.name)));
        }
        (Some(_), Some(_)) => {}
        (None, Some(last)) => {
            let message = format!("the job does not say whether its map was measured after the run `{}`", last.name);
            return Err(Problem::error(codes::E0541, "workpiece.error", message)
                .help(format!("if it was, say `after: \"{}\"` in the job", last.name)));
        }
    }
    let next = runs.len() as i64 + 1;
    match job.cycle {
        Some(cycle) if cycle != next => {
            let message = format!("the job says that it is cycle {cycle} of this part; it would be cycle {next}");
            let on_record = match runs.len() {
                0 => "no polishing run of this part is".to_string(),
                1 => "one polishing run of this part is".to_string(),
                many => format!("{many} polishing runs of this part are"),
            };
            Err(Problem::error(codes::E0542, "cycle", message)
                .note(format!("{on_record} on record in `{FOLDER}`"))
                .help(format!("say `cycle: {next}`, or put the missing runs on record")))
        }
        _ => Ok(()),
    }
}

/// The polishing runs of a part, in the order of their numbers.
fn polishing_runs(job_file: &str, part: &str, files: &dyn FileProvider) -> Result<Vec<Run>, Problem> {
    let folder = match job_file.rfind('/') {
        Some(slash) => format!("{}/{FOLDER}", &job_file[..slash]),
        None => FOLDER.to_string(),
    };
    let names = match files.list(&folder) {
        Ok(names) => names,
        // Nobody put a run on record.
        Err(FileError::NotFound) => return Ok(Vec::new()),
        Err(error) => return Err(unreadable(FOLDER, &said(&error))),
    };
    if names.len() > MOST_RUNS {
        return Err(unreadable(FOLDER, &format!("it has {} entries; at most {MOST_RUNS} are read", names.len())));
    }
    let mut runs = Vec::new();
    for entry in names {
        let name = format!("{FOLDER}/{entry}");
        let number = entry.bytes().all(|b| b.is_ascii_digit()).then(|| entry.parse::<u64>().ok()).flatten();
        let bytes = match files.read(&format!("{folder}/{entry}/{RESULT}"), MOST_BYTES) {
            Ok(bytes) => bytes,
            // Notes and pictures may lie beside the runs; a numbered folder is one.
            Err(_) if number.is_none() => continue,
            Err(error) => return Err(unreadable(&name, &format!("`{RESULT}`: {}", said(&error)))),
        };
        let result: Value =
            serde_json::from_slice(&bytes).map_err(|_| unreadable(&name, &format!("`{RESULT}` is no JSON")))?;
        let Some(inputs) = inputs_of(&result, part).map_err(|why| unreadable(&name, why))? else { continue };
        let Some(number) = number else {
            return Err(unreadable(&name, "the folder of a run is named by the run's number, as `0003`"));
        };
        if let Some(other) = runs.iter().find(|run: &&Run| run.number == number) {
            return Err(unreadable(&name, &format!("`{}` has the same number", other.name)));
        }
        runs.push(Run { name, number, inputs });
    }
    runs.sort_by_key(|run| run.number);
    Ok(runs)
}

/// The hashes of the inputs of the polishing jobs of `part` in a result; `None` if it has none.
fn inputs_of(result: &Value, part: &str) -> Result<Option<Vec<String>>, &'static str> {
    let text = |value: &Value, key: &str| value.get(key).and_then(Value::as_str).map(str::to_string);
    let jobs = result.get("jobs").and_then(Value::as_array).ok_or("`result.json` names no jobs")?;
    let mut found: Option<Vec<String>> = None;
    for job in jobs {
        let (Some(of), Some(purpose)) = (text(job, "part"), text(job, "for")) else {
            return Err("`result.json` does not say part and purpose of its jobs");
        };
        if of != part || purpose != "polish" {
            continue;
        }
        let inputs = job.get("inputs").and_then(Value::as_array).ok_or("`result.json` does not list its inputs")?;
        let hashes =
            inputs.iter().map(|input| text(input, "blake3").ok_or("`result.json` has an input without its hash"));
        found.get_or_insert_default().extend(hashes.collect::<Result<Vec<_>, _>>()?);
    }
    Ok(found)
}

fn unreadable(name: &str, why: &str) -> Problem {
    Problem::error(codes::E0543, "after", format!("the record of runs in `{name}` cannot be read: {why}"))
        .note("whether the map is void cannot be known without it")
        .help("copy the whole folder of the build that was run, with its `result.json`, or take the folder away")
}

fn said(error: &FileError) -> String {
    match error {
        FileError::NotFound => "there is no such file".into(),
        FileError::TooLarge { size, limit } => format!("it has {size} bytes; at most {limit} are read"),
        FileError::Outside => "it lies outside the project".into(),
        FileError::Other(why) => why.clone(),
    }
}
