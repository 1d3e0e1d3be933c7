//! Influence functions of pads and bonnets. The golden files speak mm, N, rpm and um; the library SI.

use polishc::tool::bonnet::{Contact, ContactCircle};
use polishc::tool::edge::EdgeContact;
use polishc::tool::pad::PadMotion;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

pub fn run(function: &str, input: &Value, _expected: &Value, _context: &Value) -> Option<Result<Value, String>> {
    Some(match function {
        "tif_rate" => bonnet_rate(input),
        "tif_peak" => bonnet_peak(input),
        "tif_mean_speed_mm_s" => pad(input, |pad, _| Ok(pad.mean_speed(number(input, "s")? * 1e-3) * 1e3)),
        // kp in mm²/N times force over face, mm: 1e9 from m³ to mm³, 1e-6 from mm² to m² in the pressure's area.
        "tif_vrr_mm3_s" => pad(input, |pad, tool| {
            let pressure = number(tool, "F")? / (PI * pad.radius * pad.radius);
            Ok(number(tool, "kp")? * 1e-6 * pressure * pad.swept() * 1e9)
        }),
        "contact_area_ratio" => contact_share(input),
        "tif_sigma_mm" => pad(input, |pad, _| Ok(pad.sigma() * 1e3)),
        "tif_transfer" => pad(input, |pad, _| Ok(pad.transfer(number(input, "period")? * 1e-3))),
        _ => return None,
    })
}

fn number(value: &Value, key: &str) -> Result<f64, String> {
    value[key].as_f64().ok_or_else(|| format!("no number `{key}`"))
}

fn pad(input: &Value, figure: impl Fn(&PadMotion, &Value) -> Result<f64, String>) -> Result<Value, String> {
    let tool = &input["tool"];
    let turn = |key: &str| number(tool, key).map(|rpm| rpm * TAU / 60.0);
    let (orbit, spin) = (turn("n_orbit")?, turn("n_spin")?);
    let turn = match tool["spin_frame"].as_str() {
        Some("arm") => orbit + spin,
        Some("abs") => spin,
        other => return Err(format!("unknown frame {other:?}")),
    };
    let motion = PadMotion { radius: number(tool, "D")? * 5e-4, eccentricity: number(tool, "e")? * 1e-3, orbit, turn };
    Ok(json!(figure(&motion, tool)?))
}

/// The contact with the given kp0 (a plain number).
fn contact(input: &Value, wear: f64) -> Result<(Contact, ContactCircle), String> {
    let exponent = match input["pressure"].as_str() {
        Some("hertz") => 0.5,
        Some("parabolic") => 1.0,
        other => return Err(format!("unknown pressure {other:?}")),
    };
    let circle = ContactCircle::new(number(input, "R_mm")? * 1e-3, number(input, "z_offset_mm")? * 1e-3, 0.0)
        .ok_or("no contact")?;
    let spin = number(input, "rpm")? * TAU / 60.0;
    Ok((Contact::new(circle, exponent, wear, number(input, "rho_deg")?.to_radians(), spin), circle))
}

fn bonnet_rate(input: &Value) -> Result<Value, String> {
    let (contact, circle) = contact(input, number(input, "kp0")?)?;
    // `eps_deg` is the azimuth of the shaft's lean on the surface, which is the tool frame's x axis.
    let azimuth = number(input, "eps_deg")?.to_radians();
    let [x, y] = polishc::tool::part_to_tool(number(input, "x")? * 1e-3, number(input, "y")? * 1e-3, azimuth);
    Ok(json!({ "rate_um_per_s": contact.rate(x, y) * 1e6, "contact_radius_mm": circle.radius * 1e3 }))
}

/// A pad of radius a whose middle lies D from that of a part of radius R.
fn contact_share(input: &Value) -> Result<Value, String> {
    let (a, outline, distance) = (number(input, "a")? * 1e-3, number(input, "R")? * 1e-3, number(input, "D")? * 1e-3);
    Ok(json!(EdgeContact { radius: a, outline }.share(outline - distance)))
}

fn bonnet_peak(input: &Value) -> Result<Value, String> {
    let (unit, _) = contact(input, 1.0)?;
    let offset = unit.peak_offset();
    let wear = number(input, "peak_rate_um_s")? * 1e-6 / unit.rate(offset, 0.0);
    Ok(json!({ "peak_offset_mm": offset * 1e3, "kp0": wear }))
}
