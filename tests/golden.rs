//! Runs every case of every `*.json` in the folder named by `POLISHC_GOLDEN` (default `tests/golden/`).
//!
//! Each area of the code has an adapter, `fn run(function, input, expected, context) -> Option<Result<Value, String>>`:
//! `None` when the function is not its own. The adapter may use `expected` only to put an answer that has several
//! equal writings (a quaternion's sign, the order of solutions) into the written one.
#![allow(clippy::disallowed_methods, clippy::print_stdout, reason = "a test runner reads files, prints and exits")]

use serde_json::Value;
use std::path::PathBuf;

#[path = "golden_adapters/mod.rs"]
mod adapters;

fn main() {
    let folder = std::env::var_os("POLISHC_GOLDEN").map_or_else(|| PathBuf::from("tests/golden"), PathBuf::from);
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap_or_else(|e| panic!("cannot list {}: {e}", folder.display()))
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "json"))
        .collect();
    files.sort();
    let (mut passed, mut failed) = (0, 0);
    for file in files {
        let text = std::fs::read_to_string(&file).expect("a readable golden file");
        let document: Value = serde_json::from_str(&text).expect("golden files are JSON");
        for case in document["cases"].as_array().expect("`cases` is a list") {
            match run_case(case, &document) {
                Ok(()) => passed += 1,
                Err(why) => {
                    failed += 1;
                    println!("FAILED {} {}: {why}", file.display(), case["id"]);
                }
            }
        }
    }
    println!("{passed} passed, {failed} failed");
    if failed > 0 || passed == 0 {
        std::process::exit(1);
    }
}

fn run_case(case: &Value, document: &Value) -> Result<(), String> {
    let function = case["fn"].as_str().ok_or("no `fn`")?;
    let (input, expected) = (&case["input"], &case["output"]);
    let found = adapters::ADAPTERS
        .iter()
        .find_map(|run| run(function, input, expected, document))
        .ok_or_else(|| format!("unknown function `{function}`"))??;
    let tolerance = Tolerance::of(&case["tol"])?;
    tolerance.compare("", &found, expected)
}

enum Tolerance {
    Absolute(f64),
    Relative(f64),
    /// By key of the output; see [`Tolerance::of_key`].
    ByKey(serde_json::Map<String, Value>),
}

impl Tolerance {
    fn of(value: &Value) -> Result<Tolerance, String> {
        if let Some(keys) = value["abs"].as_object() {
            return Ok(Tolerance::ByKey(keys.clone()));
        }
        match (value["abs"].as_f64(), value["rel"].as_f64()) {
            (Some(abs), None) => Ok(Tolerance::Absolute(abs)),
            (None, Some(rel)) => Ok(Tolerance::Relative(rel)),
            _ => Err("`tol` must be one of abs and rel".into()),
        }
    }

    /// Of keys with tolerances of their own: `KIND_rel` holds for every key that begins with KIND and is relative, any other is
    /// absolute and holds for its key; a key that is not named takes that of a key in the same unit (`lift_nm` that of `rms_nm`).
    fn of_key(keys: &serde_json::Map<String, Value>, key: &str) -> Result<Tolerance, String> {
        if let Some(own) = keys.get(key).and_then(Value::as_f64) {
            return Ok(Tolerance::Absolute(own));
        }
        let unit = |key: &str| key.rsplit('_').next().map(str::to_string);
        for (name, value) in keys {
            let value = value.as_f64().ok_or("a tolerance that is no number")?;
            match name.strip_suffix("_rel") {
                Some(kind) if key.starts_with(kind) => return Ok(Tolerance::Relative(value)),
                None if unit(name) == unit(key) => return Ok(Tolerance::Absolute(value)),
                _ => {}
            }
        }
        Err(format!("no tolerance for `{key}`"))
    }

    fn compare(&self, at: &str, found: &Value, expected: &Value) -> Result<(), String> {
        match (found, expected) {
            (Value::Number(f), Value::Number(e)) => {
                let (f, e) = (f.as_f64().ok_or("not a number")?, e.as_f64().ok_or("not a number")?);
                // A relative case that expects 0 uses an absolute tolerance of 1e-12 (the format says so).
                let allowed = match self {
                    Tolerance::Absolute(abs) => *abs,
                    Tolerance::Relative(_) if e == 0.0 => 1e-12,
                    Tolerance::Relative(rel) => rel * e.abs(),
                    Tolerance::ByKey(_) => return Err(format!("{at}: tolerances by key for a number")),
                };
                if (f - e).abs() <= allowed { Ok(()) } else { Err(format!("{at}: found {f}, expected {e}")) }
            }
            (Value::Array(f), Value::Array(e)) if f.len() == e.len() => {
                f.iter().zip(e).enumerate().try_for_each(|(i, (f, e))| self.compare(&format!("{at}[{i}]"), f, e))
            }
            (Value::Array(f), Value::Array(e)) => {
                Err(format!("{at}: found {} elements, expected {}", f.len(), e.len()))
            }
            // An expected key must be found; the adapter may know more.
            (Value::Object(f), Value::Object(e)) => e.iter().try_for_each(|(key, e)| {
                let f = f.get(key).ok_or_else(|| format!("{at}.{key}: missing"))?;
                let at = format!("{at}.{key}");
                match self {
                    Tolerance::ByKey(keys) => Tolerance::of_key(keys, key)?.compare(&at, f, e),
                    whole => whole.compare(&at, f, e),
                }
            }),
            (f, e) if f == e => Ok(()),
            (f, e) => Err(format!("{at}: found {f}, expected {e}")),
        }
    }
}
