//! `polishc sweep`: one job with several values of its params, and what each is predicted to give.
//!
//! The values are tried one after the other, each as a build in memory would, as far as the job's requirements need: one that
//! speaks of the arm's motion plans the motion, one of the program writes and verifies it, all others end at dwell. A
//! value that fails is a row that says so; the others are still worked out. Data files are read once.

use super::arguments::{Common, MessageFormat};
use super::disk::Disk;
use super::terminal::{Timings, WRONG_COMMAND, WRONG_INPUT, finish, say, show};
use crate::diagnostics::codes as code;
use crate::diagnostics::{Diagnostic, Severity};
use crate::report::{JobResult, Met};
use crate::session::{self, Compilation, Request, Until, Unwatched};
use crate::source::{FileError, FileProvider};
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

/// Most combinations of values. A thousand plans of an ordinary job take an hour; more is a slip.
const MOST_ROWS: usize = 1000;

/// A param with the values to try: `pitch=0.3mm,0.5mm`.
struct Over {
    name: String,
    values: Vec<String>,
}

/// Tries all combinations of the values of `over` on `request`.
#[allow(clippy::print_stderr, reason = "cli is where standard output is")]
pub fn sweep(common: &Common, request: &Request, over: &[String]) -> u8 {
    let timings = Timings::new();
    let mut params = Vec::new();
    for text in over {
        match parse(text) {
            Some(param) => params.push(param),
            None => {
                eprintln!("`--over {text}`: write a param and its values, `--over pitch=0.3mm,0.5mm,1mm`");
                return WRONG_COMMAND;
            }
        }
    }
    let rows = params.iter().fold(1usize, |rows, param| rows.saturating_mul(param.values.len()));
    if rows > MOST_ROWS {
        eprintln!("these are {rows} combinations of values; at most {MOST_ROWS} are tried");
        return WRONG_COMMAND;
    }
    let disk = Disk::new(request.path.as_ref(), common.allow_outside);
    let files = Once { files: &disk, read: Mutex::default() };
    let until = needed(&files, request, &params);
    let mut table = Table { params: params.iter().map(|param| param.name.clone()).collect(), rows: Vec::new() };
    let mut said = BTreeSet::new();
    let mut failed = false;
    for row in 0..rows {
        let values = combination(&params, row);
        let one = Request { until, ..with(request, &params, &values) };
        let done = session::compile(&files, &one, &timings);
        failed |= tell(common, &done, &params, &values, &mut said);
        table.add(&done, values);
    }
    if common.message_format == MessageFormat::Json {
        table.rows.iter().for_each(|row| say(&table.to_json(row)));
    } else {
        say(table.text().trim_end());
        table.not_met().iter().chain(&table.without_effect()).for_each(|line| say(line));
    }
    finish(common, &timings, if failed { WRONG_INPUT } else { 0 })
}

/// The request with the values of a row.
fn with(request: &Request, params: &[Over], values: &[String]) -> Request {
    let mut one = request.clone();
    one.sets.extend(params.iter().map(|param| param.name.clone()).zip(values.iter().cloned()));
    one
}

/// How far the rows must go for the requirements of the job: a param changes values, not what is required.
fn needed(files: &dyn FileProvider, request: &Request, params: &[Over]) -> Until {
    let first = Request { until: Until::Types, ..with(request, params, &combination(params, 0)) };
    let done = session::compile(files, &first, &Unwatched);
    let names = done.jobs.iter().flat_map(|planned| &planned.requirements).flat_map(|one| one.results());
    let until = |name: &str| match name.split('.').next() {
        Some("motion") => Until::Motion,
        Some("program") => Until::Program,
        _ => Until::Dwell,
    };
    names.map(until).max().unwrap_or(Until::Dwell)
}

/// Says what was not said for an earlier row; whether something but a requirement failed.
fn tell(
    common: &Common,
    done: &Compilation,
    params: &[Over],
    values: &[String],
    said: &mut BTreeSet<(String, String)>,
) -> bool {
    let with: Vec<String> = params.iter().zip(values).map(|(p, value)| format!("`{} = {value}`", p.name)).collect();
    let mut new = Vec::new();
    let mut failed = false;
    for diagnostic in done.diagnostics.iter().filter(|d| !is_requirement(d)) {
        failed |= diagnostic.severity == Severity::Error || common.deny.is_some();
        if said.insert((diagnostic.code.to_string(), diagnostic.message.clone())) {
            new.push(diagnostic.clone().note(format!("with {}", with.join(" and "))));
        }
    }
    show(common, &done.sources, &new);
    failed
}

/// That a plan does not do what the job requires is a result here.
fn is_requirement(diagnostic: &Diagnostic) -> bool {
    [code::E1101, code::E1102].contains(&diagnostic.code)
}

/// `pitch=0.3mm,0.5mm`: commas inside brackets and quotes belong to a value.
fn parse(text: &str) -> Option<Over> {
    let (name, list) = text.split_once('=')?;
    let (mut values, mut value, mut depth, mut quoted) = (Vec::new(), String::new(), 0i32, false);
    for c in list.chars() {
        match c {
            '"' => quoted = !quoted,
            '[' | '(' | '{' if !quoted => depth += 1,
            ']' | ')' | '}' if !quoted => depth -= 1,
            _ => {}
        }
        if c == ',' && depth == 0 && !quoted {
            values.push(std::mem::take(&mut value));
        } else {
            value.push(c);
        }
    }
    values.push(value);
    let values: Vec<String> = values.iter().map(|value| value.trim().to_string()).collect();
    let good = !name.trim().is_empty() && values.iter().all(|value| !value.is_empty());
    good.then(|| Over { name: name.trim().to_string(), values })
}

/// The values of the `row`-th combination; the last param changes first.
fn combination(params: &[Over], mut row: usize) -> Vec<String> {
    let mut values: Vec<String> = params
        .iter()
        .rev()
        .map(|param| {
            let value = param.values[row % param.values.len()].clone();
            row /= param.values.len();
            value
        })
        .collect();
    values.reverse();
    values
}

/// Reads every file once.
struct Once<'a> {
    files: &'a dyn FileProvider,
    read: Mutex<BTreeMap<String, Vec<u8>>>,
}

impl FileProvider for Once<'_> {
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>, FileError> {
        let mut read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bytes) = read.get(path).filter(|bytes| bytes.len() as u64 <= limit) {
            return Ok(bytes.clone());
        }
        let bytes = self.files.read(path, limit)?;
        read.insert(path.to_string(), bytes.clone());
        Ok(bytes)
    }

    fn resolve(&self, from: &str, path: &str) -> Result<String, FileError> {
        self.files.resolve(from, path)
    }

    fn list(&self, path: &str) -> Result<Vec<String>, FileError> {
        self.files.list(path)
    }

    fn project_file(&self) -> Option<String> {
        self.files.project_file()
    }
}

struct Row {
    values: Vec<String>,
    /// The job's result, or the codes of what is wrong.
    outcome: Result<Box<JobResult>, String>,
}

struct Table {
    params: Vec<String>,
    rows: Vec<Row>,
}

impl Table {
    fn add(&mut self, done: &Compilation, values: Vec<String>) {
        let wrong = |d: &&Diagnostic| d.severity == Severity::Error && !is_requirement(d);
        let codes: BTreeSet<&str> = done.diagnostics.iter().filter(wrong).map(|d| d.code.as_str()).collect();
        if !codes.is_empty() {
            let codes: Vec<&str> = codes.into_iter().collect();
            self.rows.push(Row { values, outcome: Err(codes.join(", ")) });
            return;
        }
        for planned in &done.jobs {
            if let Some(result) = &planned.result {
                self.rows.push(Row { values: values.clone(), outcome: Ok(Box::new(result.clone())) });
            }
        }
    }

    fn text(&self) -> String {
        let mut names: BTreeSet<&str> = BTreeSet::new();
        names.extend(self.rows.iter().filter_map(|row| row.outcome.as_ref().ok()).map(|result| result.name.as_str()));
        let several = names.len() > 1;
        let mut cells: Vec<Vec<String>> = Vec::new();
        let mut head = self.params.clone();
        head.extend(several.then(|| "job".to_string()));
        let figures: Vec<_> =
            self.rows.iter().map(|row| row.outcome.as_ref().ok().map(|result| figures(result))).collect();
        // A column that no row fills is not shown.
        let filled = |column: usize| figures.iter().flatten().any(|row| row[column].is_some());
        let shown: Vec<usize> = (0..COLUMNS.len()).filter(|column| filled(*column)).collect();
        head.extend(shown.iter().map(|column| COLUMNS[*column].to_string()));
        cells.push(head);
        for (row, figures) in self.rows.iter().zip(&figures) {
            let mut line = row.values.clone();
            match (&row.outcome, figures) {
                (Ok(result), Some(figures)) => {
                    line.extend(several.then(|| result.name.clone()));
                    line.extend(shown.iter().map(|column| figures[*column].clone().unwrap_or_else(|| "-".into())));
                }
                (Err(codes), _) => line.push(codes.clone()),
                (Ok(_), None) => {}
            }
            cells.push(line);
        }
        let widths: Vec<usize> = (0..cells[0].len())
            .map(|i| cells.iter().filter_map(|line| line.get(i)).map(|cell| cell.chars().count()).max().unwrap_or(0))
            .collect();
        let first = self.params.len() + usize::from(several);
        let mut out = String::new();
        for line in cells {
            let padded = line.iter().zip(&widths).enumerate().map(|(i, (cell, &width))| match i < first {
                true => format!("{cell:<width$}"),
                false => format!("{cell:>width$}"),
            });
            out.push_str(padded.collect::<Vec<_>>().join("  ").trim_end());
            out.push('\n');
        }
        out
    }

    /// A line for each requirement that is not met somewhere: with which values, and what it came to there.
    fn not_met(&self) -> Vec<String> {
        let mut failures: Vec<(&str, Vec<String>)> = Vec::new();
        for row in &self.rows {
            let Ok(result) = &row.outcome else { continue };
            for requirement in result.requirements.iter().filter(|requirement| requirement.met == Met::No) {
                let place = format!("{} ({})", row.values.join(" "), requirement.value);
                match failures.iter_mut().find(|(text, _)| *text == requirement.text) {
                    Some((_, places)) => places.push(place),
                    None => failures.push((&requirement.text, vec![place])),
                }
            }
        }
        failures.into_iter().map(|(text, places)| format!("not met: {text} with {}", places.join(", "))).collect()
    }

    /// A line for each param of which every value gives the same plan.
    fn without_effect(&self) -> Vec<String> {
        let same = |param: usize| {
            let mut groups: BTreeMap<(Vec<&String>, &str), BTreeSet<String>> = BTreeMap::new();
            let (mut rows, mut values) = (0, BTreeSet::new());
            for row in &self.rows {
                let Ok(result) = &row.outcome else { return false };
                let others =
                    row.values.iter().enumerate().filter(|(i, _)| *i != param).map(|(_, value)| value).collect();
                let plan = json!([result.path, result.dwell, result.predicted, result.motion, result.programs]);
                groups.entry((others, &result.name)).or_default().insert(plan.to_string());
                values.insert(&row.values[param]);
                rows += 1;
            }
            rows > 0 && values.len() > 1 && groups.values().all(|plans| plans.len() == 1)
        };
        (0..self.params.len())
            .filter(|&param| same(param))
            .map(|param| format!("`{}` changes nothing: every value gives the same plan", self.params[param]))
            .collect()
    }

    fn to_json(&self, row: &Row) -> String {
        let set: serde_json::Map<String, serde_json::Value> =
            self.params.iter().cloned().zip(row.values.iter().map(|value| json!(value))).collect();
        match &row.outcome {
            Ok(result) => json!({
                "set": set, "job": result.name, "dwell": result.dwell, "predicted": result.predicted,
                "motion": result.motion, "requirements": result.requirements,
            }),
            Err(codes) => json!({ "set": set, "errors": codes.split(", ").collect::<Vec<_>>() }),
        }
        .to_string()
    }
}

/// Heads of the columns: `expected` is the RMS with the errors of `uncertainty`, `ripple` what the distance of the lines
/// leaves.
const COLUMNS: [&str; 8] =
    ["RMS nm", "expected nm", "PV nm", "ripple nm", "removed nm", "time min", "joint margin deg", "required"];

/// What stands in the columns; `None` where the job has no such figure or the sweep did not go so far.
fn figures(result: &JobResult) -> [Option<String>; 8] {
    let met = result.requirements.iter().filter(|requirement| requirement.met == Met::Yes).count();
    let seconds =
        result.motion.as_ref().map_or(result.dwell.as_ref().map_or(0.0, |dwell| dwell.total_s), |motion| motion.time_s);
    [
        Some(format!("{:.2}", result.predicted.rms_nm)),
        result.predicted.rms_expected_nm.map(|rms| format!("{rms:.2}")),
        Some(format!("{:.1}", result.predicted.pv_nm)),
        result.predicted.ripple_nm.map(|ripple| format!("{ripple:.3}")),
        Some(format!("{:.1}", result.predicted.removal_mean_nm)),
        Some(format!("{:.1}", seconds / 60.0)),
        result.motion.as_ref().map(|motion| format!("{:.1}", motion.joint_margin_deg)),
        match result.requirements.len() {
            0 => None,
            all if met == all => Some("met".into()),
            all => Some(format!("{met} of {all} met")),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_parted_at_commas_outside_brackets() {
        let over = parse("holes = [1, 2], f(3, 4) ,\"a,b\"").expect("a param");
        assert_eq!(
            (over.name.as_str(), over.values),
            ("holes", ["[1, 2]", "f(3, 4)", "\"a,b\""].map(str::to_string).into())
        );
        for wrong in ["pitch", "=1mm", "pitch=", "pitch=1mm,,2mm"] {
            assert!(parse(wrong).is_none(), "{wrong}");
        }
    }

    #[test]
    fn the_last_param_changes_first() {
        let params = [parse("a=1,2").expect("a param"), parse("b=3,4").expect("a param")];
        let all: Vec<Vec<String>> = (0..4).map(|row| combination(&params, row)).collect();
        assert_eq!(all, [["1", "3"], ["1", "4"], ["2", "3"], ["2", "4"]].map(|row| row.map(str::to_string)));
    }
}
