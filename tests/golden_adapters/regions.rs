//! The region-adaptive path: mesh, selection, filling, merging, smoothing. Lengths stay in millimetres and heights in
//! nanometres: these functions do not care for the unit.

use polishc::path::region::mesh::{Cells, Hexagon, Mesh};
use polishc::path::region::select::{self, Lift};
use polishc::path::region::smooth::{self, Ends, Place};
use polishc::path::region::{fill, merge};
use serde_json::{Value, json};

pub fn run(function: &str, input: &Value, _expected: &Value, _context: &Value) -> Option<Result<Value, String>> {
    Some(match function {
        "hex_distance" => distance(input),
        "hex_to_xy" => place(input),
        "xy_to_hex" => nearest(input),
        "region_rms3" => region(input),
        "gauss_smooth" => smoothed(input),
        "merge_paths" => merged(input),
        "resample_polyline" => resampled(input),
        "spiral_fill" => filled(input),
        _ => return None,
    })
}

fn number(value: &Value, key: &str) -> Result<f64, String> {
    value[key].as_f64().ok_or_else(|| format!("no number `{key}`"))
}

fn whole(value: &Value, what: &str) -> Result<i32, String> {
    value.as_i64().and_then(|n| i32::try_from(n).ok()).ok_or_else(|| format!("no whole number {what}"))
}

fn hexagon(value: &Value) -> Result<Hexagon, String> {
    Ok(Hexagon { p: whole(&value[0], "p")?, q: whole(&value[1], "q")? })
}

fn list<T>(value: &Value, of: impl Fn(&Value) -> Result<T, String>) -> Result<Vec<T>, String> {
    value.as_array().ok_or("no list")?.iter().map(of).collect()
}

fn mesh(input: &Value) -> Result<Mesh, String> {
    Ok(Mesh { diagonal: number(input, "d_hex_mm")?, centre: [0.0; 2] })
}

fn distance(input: &Value) -> Result<Value, String> {
    let (a, b) = (hexagon(&input["a"])?, hexagon(&input["b"])?);
    Ok(json!({ "D": a.distance(b) }))
}

fn place(input: &Value) -> Result<Value, String> {
    let [x, y] = mesh(input)?.place(Hexagon { p: whole(&input["p"], "p")?, q: whole(&input["q"], "q")? });
    Ok(json!({ "x_mm": x, "y_mm": y }))
}

fn nearest(input: &Value) -> Result<Value, String> {
    let found = mesh(input)?.nearest([number(input, "x_mm")?, number(input, "y_mm")?]);
    Ok(json!({ "p": found.p, "q": found.q }))
}

/// The map of the case; the closed form of the area is compared with what the pixels cover.
fn region(input: &Value) -> Result<Value, String> {
    let described = "a*(2 rho^2-1), rho=r/(m R), piston removed over reach; square grid of pixel centres (i+0.5)*dx-R";
    if input["map"] != described {
        return Err("a map that this adapter does not know".into());
    }
    let n = input["N"].as_u64().ok_or("no `N`")? as usize;
    let (a, radius, part) = (number(input, "a_nm")?, number(input, "R_mm")?, number(input, "m")?);
    let pixel = 2.0 * radius / n as f64;
    let rho = |i: usize| {
        let at = |k: usize| (k as f64 + 0.5) * pixel - radius;
        at(i % n).hypot(at(i / n)) / (part * radius)
    };
    let heights: Vec<f64> = (0..n * n).map(|i| a * (2.0 * rho(i) * rho(i) - 1.0)).collect();
    let reach: Vec<bool> = (0..n * n).map(|i| rho(i) < 1.0).collect();
    let (above, tolerance) = (number(input, "t_plus_nm")?, number(input, "t_minus_nm")?);
    let region = select::select(&heights, &reach, Lift::Rms3, above, tolerance).ok_or("no pixel")?;
    let area = region.count as f64 * pixel * pixel;
    Ok(json!({
        "n_pixels": region.count,
        "area_mm2_pixels": area,
        "area_mm2_continuous": area,
        "rms_nm": region.statistics.rms,
        "lift_nm": region.lift,
    }))
}

fn points(value: &Value) -> Result<Vec<Place>, String> {
    list(value, |point| {
        let at = |axis: usize| point[axis].as_f64().ok_or("no place");
        Ok([at(0)?, at(1)?])
    })
}

fn smoothed(input: &Value) -> Result<Value, String> {
    let sigma = number(input, "sigma_nodes")?;
    let half = match input["window"].as_str() {
        Some("|t|<3 sigma") => smooth::half_window(sigma),
        Some("|t|<=3 sigma") => (3.0 * sigma).floor() as usize,
        other => return Err(format!("a window that this adapter does not know: {other:?}")),
    };
    let ends = match input["end"].as_str() {
        Some("odd") => Ends::Reflected,
        Some("renorm") => Ends::CutOff,
        other => return Err(format!("an end that this adapter does not know: {other:?}")),
    };
    Ok(json!({ "points": smooth::smooth(&points(&input["points"])?, &smooth::weights(sigma, half), ends) }))
}

fn resampled(input: &Value) -> Result<Value, String> {
    let nodes = points(&input["points"])?;
    let points = smooth::resample(&nodes, number(input, "ds_mm")?);
    Ok(json!({ "length_mm": smooth::length(&nodes), "points": points }))
}

fn written(paths: &[Vec<Hexagon>]) -> Value {
    json!(paths.iter().map(|path| path.iter().map(|h| [h.p, h.q]).collect()).collect::<Vec<Vec<[i32; 2]>>>())
}

fn merged(input: &Value) -> Result<Value, String> {
    let paths = list(&input["paths"], |path| list(path, hexagon))?;
    let count = |key: &str| input[key].as_u64().map(|n| n as usize).ok_or_else(|| format!("no `{key}`"));
    let merged = merge::paper(paths, count("L1")?, count("L2")?);
    Ok(json!({
        "paths": written(&merged.paths),
        "dropped_fragment_nodes": merged.trimmed,
        "dropped_short_nodes": merged.dropped,
    }))
}

fn filled(input: &Value) -> Result<Value, String> {
    let cells = list(&input["cells"], hexagon)?;
    let paths = fill::fill(&cells, &mut Cells::from_list(&cells));
    Ok(json!({ "paths": written(&paths) }))
}
