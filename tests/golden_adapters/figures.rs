//! Figures of maps.

use polishc::metrology::Figures;
use serde_json::{Value, json};

pub fn run(function: &str, input: &Value, _expected: &Value, _context: &Value) -> Option<Result<Value, String>> {
    (function == "pv").then(|| pv(input))
}

fn pv(input: &Value) -> Result<Value, String> {
    let values: Vec<f64> = input["dz_mm"].as_array().ok_or("no `dz_mm`")?.iter().filter_map(Value::as_f64).collect();
    let figures = Figures::of(values.iter().copied());
    Ok(json!({ "pv_mm": figures.pv, "rms_mm": figures.rms, "mean_mm": figures.mean }))
}
