//! Path and dwell. The golden files speak mm, nm and s; the library SI.

use polishc::dwell::bounds::Bounds;
use polishc::dwell::descent::{self, LinearOperator, Stop};
use polishc::dwell::largest;
use polishc::dwell::objective::{self, Base, Objective, Price, Wanted};
use polishc::dwell::removal::{self, Removal, Samples, Spread, Window};
use polishc::dwell::{Footprint, floor_depth};
use polishc::job::{Aperture, Circle, Lines, Path, Plane, Raster};
use polishc::path::{self, Setting};
use polishc::tool::InfluenceFunction;
use polishc::units::si::{Angle, Length};
use serde_json::{Value, json};

pub fn run(function: &str, input: &Value, _expected: &Value, _context: &Value) -> Option<Result<Value, String>> {
    Some(match function {
        "raster_count" => raster_count(input),
        "H_apply_exact" => exact(input),
        "H_apply_bilinear" => bilinear(input),
        "HT_apply_exact" => transpose(input),
        "bounded_ls" => bounded_ls(input),
        "lse_penalty" => log_sum_exp(input),
        "minimax_lp" => minimax(input),
        "tif_volume_rate" => influence(input).map(|f| json!({ "V_nm_mm2_s": f.volume_rate() * 1e15 })),
        "floor_depth" => floor(input),
        _ => return None,
    })
}

fn number(value: &Value, key: &str) -> Result<f64, String> {
    value[key].as_f64().ok_or_else(|| format!("no number `{key}`"))
}

fn numbers(value: &Value, scale: f64) -> Result<Vec<f64>, String> {
    let list = value.as_array().ok_or("no list")?;
    list.iter().map(|v| v.as_f64().map(|v| v * scale).ok_or_else(|| "not a number".to_string())).collect()
}

fn raster_count(input: &Value) -> Result<Value, String> {
    let raster = Raster {
        over: Aperture::circle(Circle { diameter: Length(number(input, "diameter_mm")? * 1e-3), centre: None }),
        point_step: Length(number(input, "step_mm")? * 1e-3),
        line_pitch: Length(number(input, "line_spacing_mm")? * 1e-3),
        direction: Angle(0.0),
        lines: Lines::serpentine,
        chord_error: Length(1e-5),
        holes: None,
        landing: None,
        passes: None,
    };
    let over = raster.over.clone();
    let setting = Setting {
        edge: &over,
        clear: &over,
        surface: &Plane {},
        most_points: 10_000_000,
        line_points: usize::MAX,
        measured: None,
    };
    let path = path::plan(&Path::raster(raster), &setting).map_err(|p| p.message)?;
    Ok(json!({ "points": path.points.len(), "lines": path.lines.len() }))
}

fn influence(tif: &Value) -> Result<InfluenceFunction, String> {
    if tif["type"] != "gauss" {
        return Err(format!("unknown influence function {}", tif["type"]));
    }
    let (peak, sigma) = (number(tif, "peak_nm_s")? * 1e-9, number(tif, "sigma_mm")? * 1e-3);
    InfluenceFunction::gaussian(peak, sigma, number(tif, "D_mm")? * 1e-3).map_err(|p| p.message)
}

struct Setup {
    influence: InfluenceFunction,
    samples: Samples,
    window: Window,
}

fn setup(input: &Value) -> Result<Setup, String> {
    let n = input["N"].as_u64().ok_or("no `N`")? as usize;
    let pixel = number(input, "width_mm")? * 1e-3 / n as f64;
    let first = -0.5 * (n as f64 - 1.0) * pixel;
    Ok(Setup {
        influence: influence(&input["tif"])?,
        samples: Samples::points(&numbers(&input["mu_mm"], 1e-3)?, &numbers(&input["eta_mm"], 1e-3)?),
        window: Window { columns: n, rows: n, pixel: [pixel; 2], origin: [first; 2] },
    })
}

fn map_figures(depths: &[f64], window: &Window) -> Value {
    let nm: Vec<f64> = depths.iter().map(|depth| depth * 1e9).collect();
    let row = |r: usize| &nm[(r * window.columns).min(nm.len())..((r + 1) * window.columns).min(nm.len())];
    let mut out = json!({
        "sum": nm.iter().sum::<f64>(),
        "max": nm.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b)),
    });
    for r in 0..window.rows {
        out[format!("z_row{r}")] = json!(row(r));
    }
    out
}

fn exact(input: &Value) -> Result<Value, String> {
    let Setup { influence, samples, window } = setup(input)?;
    let times = numbers(&input["T_s"], 1.0)?;
    Ok(map_figures(&removal::deposit(&samples, &times, &Footprint::of(&influence, 0.0), &window), &window))
}

fn bilinear(input: &Value) -> Result<Value, String> {
    let Setup { influence, samples, window } = setup(input)?;
    let times = numbers(&input["T_s"], 1.0)?;
    let mut operator = Removal::spreading(Spread::Linear, &samples, &Footprint::of(&influence, 0.0), window);
    let mut depths = vec![0.0; window.len()];
    operator.forward(&times, &mut depths);
    Ok(map_figures(&depths, &window))
}

fn transpose(input: &Value) -> Result<Value, String> {
    let Setup { influence, samples, window } = setup(input)?;
    if input["B"] != "x + 2 y + 0.1 x y" {
        return Err(format!("unknown field {}", input["B"]));
    }
    let field: Vec<f64> = (0..window.len())
        .map(|i| {
            let [x, y] = window.position(i).map(|metres| metres * 1e3);
            x + 2.0 * y + 0.1 * x * y
        })
        .collect();
    let sums = removal::gather(&samples, &field, &Footprint::of(&influence, 0.0), &window);
    Ok(json!({ "A": sums.iter().map(|sum| sum * 1e9).collect::<Vec<_>>() }))
}

struct Dense(Vec<Vec<f64>>);

impl LinearOperator for Dense {
    fn unknowns(&self) -> usize {
        self.0[0].len()
    }
    fn rows(&self) -> usize {
        self.0.len()
    }
    fn forward(&mut self, times: &[f64], depths: &mut [f64]) {
        for (depth, row) in depths.iter_mut().zip(&self.0) {
            *depth = row.iter().zip(times).map(|(h, t)| h * t).sum();
        }
    }
    fn transpose(&mut self, depths: &[f64], times: &mut [f64]) {
        for (j, time) in times.iter_mut().enumerate() {
            *time = self.0.iter().zip(depths).map(|(row, d)| row[j] * d).sum();
        }
    }
}

fn dense(input: &Value) -> Result<Dense, String> {
    let rows = input["H"].as_array().ok_or("no `H`")?;
    Ok(Dense(rows.iter().map(|row| numbers(row, 1.0)).collect::<Result<_, _>>()?))
}

const EXACT: Stop =
    Stop { most_iterations: 1000, over: 10, relative_decrease: 0.0, elsewhere: 0.0, value: 0.0, relative_step: 1e-13 };

fn bounded_ls(input: &Value) -> Result<Value, String> {
    let mut operator = dense(input)?;
    let depths = numbers(&input["ep_nm"], 1.0)?;
    let (n, m) = (operator.unknowns(), operator.rows());
    let (lower, upper) = (vec![number(input, "T_min")?; n], vec![number(input, "T_max")?; n]);
    let weights = vec![1.0; m];
    let (base, objective) = (Base::Fixed(0.0), Objective::Squares);
    let wanted = Wanted { depths: &depths, weights: &weights, base, objective, price: Price::NONE };
    let mut domain = Bounds::new(&lower, &upper, &lower);
    let found = descent::descend(&mut operator, &wanted, &mut domain, EXACT);
    Ok(json!({ "T_s": domain.into_times(), "rss": 2.0 * found.value }))
}

/// The penalty of squares: `1/p log sum exp(p delta²)`, its shares, and by the chain rule its gradient.
fn log_sum_exp(input: &Value) -> Result<Value, String> {
    let mut operator = dense(input)?;
    let (wanted, times) = (numbers(&input["ep_nm"], 1.0)?, numbers(&input["T_s"], 1.0)?);
    let mut removed = vec![0.0; operator.rows()];
    operator.forward(&times, &mut removed);
    let delta: Vec<f64> = wanted.iter().zip(&removed).map(|(e, z)| e - z).collect();
    let squares: Vec<f64> = delta.iter().map(|d| d * d).collect();
    let weights = vec![1.0; delta.len()];
    let (value, shares) = objective::log_sum_exp(&squares, &weights, number(input, "p_per_nm2")?);
    let slopes: Vec<f64> = shares.iter().zip(&delta).map(|(share, d)| -2.0 * share * d).collect();
    let mut gradient = vec![0.0; times.len()];
    operator.transpose(&slopes, &mut gradient);
    Ok(json!({ "delta_nm": delta, "E_nm2": value, "zeta": shares, "grad_nm2_per_s": gradient }))
}

fn minimax(input: &Value) -> Result<Value, String> {
    let mut operator = dense(input)?;
    let depths = numbers(&input["ep_nm"], 1.0)?;
    let (n, m) = (operator.unknowns(), operator.rows());
    let (lower, upper) = (vec![number(input, "T_min")?; n], vec![number(input, "T_max")?; n]);
    let weights = vec![1.0; m];
    let free = input["piston_free"].as_bool().ok_or("no `piston_free`")?;
    let base = if free { Base::AtMost(f64::INFINITY) } else { Base::Fixed(0.0) };
    let wanted = Wanted { depths: &depths, weights: &weights, base, objective: Objective::Squares, price: Price::NONE };
    let mut domain = Bounds::new(&lower, &upper, &lower);
    descent::descend(&mut operator, &wanted, &mut domain, EXACT);
    // The value itself to 1e-8 asks for a far sharper stand-in than a run does.
    let sharpening: Vec<f64> = (0..16).map(|k| 5.0 * 4.0f64.powi(k)).collect();
    let found = largest::sharpen(&mut operator, &wanted, &mut domain, &sharpening, EXACT);
    Ok(json!({ "max_abs_delta_nm": found.value }))
}

fn floor(input: &Value) -> Result<Value, String> {
    let volume_rate = number(input, "V_nm_mm2_s")? * 1e-15;
    let depth = floor_depth(volume_rate, number(input, "v_max_mm_s")? * 1e-3, number(input, "pitch_mm")? * 1e-3);
    Ok(json!({ "z_floor_nm": depth * 1e9 }))
}
