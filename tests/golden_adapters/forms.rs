//! Nominal surfaces. The golden files speak mm; the library SI.

use polishc::job::*;
use polishc::source::MemoryFiles;
use polishc::units::si::*;
use polishc::workpiece::form::{self, Surface, SurfacePoint};
use serde_json::{Value, json};

pub fn run(function: &str, input: &Value, _expected: &Value, _context: &Value) -> Option<Result<Value, String>> {
    Some(match function {
        "surface_point" => surface_point(input),
        "asphere" => asphere(input),
        _ => return None,
    })
}

fn number(value: &Value, key: &str) -> Result<f64, String> {
    value[key].as_f64().ok_or_else(|| format!("no number `{key}`"))
}

/// A coefficient of r^i in mm^(1-i), in SI.
fn coefficient(value: &Value, power: i32) -> Option<f64> {
    value.as_f64().map(|a| a * 1e3_f64.powi(power - 1))
}

/// A signed vertex radius in millimetres, positive where hollow.
fn side_and_radius(radius: f64) -> (Side, Length) {
    let side = if radius > 0.0 { Side::concave } else { Side::convex };
    (side, Length(radius.abs() * 1e-3))
}

fn even_asphere(radius: f64, conic: f64, sag: Sag, a4: Option<f64>, a6: Option<f64>) -> Form {
    let (side, radius) = side_and_radius(radius);
    let (a4, a6) = (a4.map(PerLength3), a6.map(PerLength5));
    let form = EvenAsphere {
        side,
        radius,
        conic,
        sag,
        a4,
        a6,
        a8: None,
        a10: None,
        a12: None,
        a14: None,
        a16: None,
        a18: None,
        a20: None,
    };
    Form::even_asphere(form)
}

fn surface(form: &Form) -> Result<Box<dyn Surface>, String> {
    form::surface(form, &MemoryFiles::default()).map_err(|problem| problem.message)
}

fn at(form: &Form, x: f64, y: f64) -> Result<SurfacePoint, String> {
    surface(form)?.at(x * 1e-3, y * 1e-3).ok_or_else(|| "the form does not exist there".to_string())
}

fn surface_point(input: &Value) -> Result<Value, String> {
    let with_conic = |radius: f64| -> Result<Form, String> {
        let sag = match input["coeff_sign"].as_str() {
            Some("iso_plus") => Sag::positive_towards_tool,
            None if input["A"].as_object().is_some_and(serde_json::Map::is_empty) => Sag::positive_towards_tool,
            other => return Err(format!("unknown sign {other:?}")),
        };
        let a = &input["A"];
        let known = ["4", "6"];
        if a.as_object().is_some_and(|a| a.keys().any(|key| !known.contains(&key.as_str()))) {
            return Err("a coefficient that this adapter does not know".into());
        }
        Ok(even_asphere(radius, number(input, "k")?, sag, coefficient(&a["4"], 4), coefficient(&a["6"], 6)))
    };
    let form = match input["surface"].as_str() {
        Some("flat") => Form::plane(Plane {}),
        Some("sphere") => {
            let side = match input["shape"].as_str() {
                Some("concave") => Side::concave,
                Some("convex") => Side::convex,
                other => return Err(format!("unknown shape {other:?}")),
            };
            Form::sphere(Sphere { side, radius: Length(number(input, "radius_mm")? * 1e-3) })
        }
        Some("asphere") => with_conic(1.0 / number(input, "C_per_mm")?)?,
        Some("offaxis_asphere") => Form::off_axis(OffAxis {
            parent: Box::new(with_conic(1.0 / number(input, "C_per_mm")?)?),
            distance: Length(number(input, "offset_x_mm")? * 1e-3),
            direction: Angle(0.0),
        }),
        Some("polynomial") => {
            let term = |term: &Value| -> Option<XyTerm> {
                let coefficient = Length(term[2].as_f64()? * 1e-3);
                Some(XyTerm { x_power: term[0].as_i64()?, y_power: term[1].as_i64()?, coefficient })
            };
            let terms = input["terms"].as_array().ok_or("no `terms`")?.iter().map(term);
            Form::xy_polynomial(XyPolynomial {
                base: Box::new(Form::plane(Plane {})),
                sag: Sag::positive_towards_tool,
                normalisation: Length(number(input, "norm_mm")? * 1e-3),
                terms: terms.collect::<Option<_>>().ok_or("a term that is none")?,
            })
        }
        other => return Err(format!("unknown surface {other:?}")),
    };
    let point = at(&form, number(input, "x")?, number(input, "y")?)?;
    Ok(json!({
        "z": point.sag * 1e3,
        "dzdx": point.slope[0],
        "dzdy": point.slope[1],
        "normal": point.normal(),
    }))
}

fn asphere(input: &Value) -> Result<Value, String> {
    let a = input["a4_a6"].as_array().ok_or("no `a4_a6`")?;
    if a.len() > 2 {
        return Err("more than two coefficients".into());
    }
    let a4 = a.first().and_then(|a| coefficient(a, 4));
    let a6 = a.get(1).and_then(|a| coefficient(a, 6));
    let sag = Sag::positive_towards_tool;
    let form = even_asphere(number(input, "radius_mm")?, number(input, "k")?, sag, a4, a6);
    let point = at(&form, number(input, "x_mm")?, 0.0)?;
    let theta = point.slope[0].atan();
    Ok(json!({ "z_mm": point.sag * 1e3, "slope": point.slope[0], "theta_rad": theta }))
}
