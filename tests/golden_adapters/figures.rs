//! Figures of maps.

use polishc::height_map::Grid;
use polishc::job::ZernikeOrder;
use polishc::metrology::{Figures, pvr};
use serde_json::{Value, json};

pub fn run(function: &str, input: &Value, _expected: &Value, _context: &Value) -> Option<Result<Value, String>> {
    Some(match function {
        "pv" => pv(input),
        "pvr" => robust_pv(input),
        _ => return None,
    })
}

fn pv(input: &Value) -> Result<Value, String> {
    let values: Vec<f64> = input["dz_mm"].as_array().ok_or("no `dz_mm`")?.iter().filter_map(Value::as_f64).collect();
    let figures = Figures::of(values.iter().copied());
    Ok(json!({ "pv_mm": figures.pv, "rms_mm": figures.rms, "mean_mm": figures.mean }))
}

/// The map of the case, piston and tilt taken off by the normal equations of a plane about the symmetric mask.
fn robust_pv(input: &Value) -> Result<Value, String> {
    let number = |key: &str| input[key].as_f64().ok_or_else(|| format!("no number `{key}`"));
    if input["mask"] != "r<90 mm" || input["map"] != "a4(2rho^2-1)+a9(6rho^4-6rho^2+1)+ag cos(2 pi x/per), rho=r/90" {
        return Err("a map that this adapter does not know".into());
    }
    let n = input["N"].as_u64().ok_or("no `N`")? as usize;
    let pixel = number("width_mm")? * 1e-3 / n as f64;
    let first = -0.5 * (n as f64 - 1.0) * pixel;
    let (a4, a9, ag, period) = (number("a4_nm")?, number("a9_nm")?, number("ag_nm")?, number("per_mm")?);
    let mut grid = Grid { columns: n, rows: n, pixel: [pixel; 2], origin: [first; 2], values: Vec::new() };
    let mut mask = Vec::new();
    for i in 0..n * n {
        let [x, y] = grid.position(i / n, i % n).map(|metres| metres * 1e3);
        let square = (x * x + y * y) / 8100.0;
        let wave = ag * (2.0 * std::f64::consts::PI * x / period).cos();
        mask.push(square < 1.0);
        grid.values.push(a4 * (2.0 * square - 1.0) + a9 * (6.0 * square * square - 6.0 * square + 1.0) + wave);
    }
    // The mask is symmetric about the origin, so that mean, slope along x and slope along y are independent.
    let inside: Vec<usize> = (0..n * n).filter(|i| mask[*i]).collect();
    let place = |i: usize| grid.position(i / n, i % n);
    let mean = inside.iter().map(|i| grid.values[*i]).sum::<f64>() / inside.len() as f64;
    let slope: Vec<f64> = [0, 1]
        .iter()
        .map(|k| {
            let (mut with, mut own) = (0.0, 0.0);
            for i in &inside {
                with += place(*i)[*k] * grid.values[*i];
                own += place(*i)[*k] * place(*i)[*k];
            }
            with / own
        })
        .collect();
    let planed: Vec<f64> = (0..n * n)
        .map(|i| {
            let [x, y] = place(i);
            grid.values[i] - mean - slope[0] * x - slope[1] * y
        })
        .collect();
    grid.values = planed;
    let figures = Figures::of(inside.iter().map(|i| grid.values[*i]));
    let fringe = pvr(&grid, &mask, ZernikeOrder::fringe).ok_or("no fit")?;
    let standard = pvr(&grid, &mask, ZernikeOrder::noll).ok_or("no fit")?;
    Ok(json!({
        "n_mask": inside.len(),
        "pv_nm": figures.pv,
        "rms_nm": figures.rms,
        "pv_fit_nm": fringe.pv_of_fit,
        "rms_resid_nm": fringe.rms_of_residual,
        "pvr_nm": fringe.pvr,
        "pvr_std36_nm": standard.pvr,
    }))
}
