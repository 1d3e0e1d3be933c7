#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]
//! fk, ik_all_turns, tool_pose, matrix_to_quat_abc, abb_confdata, kuka_status_turn, robtarget_from_joints: millimetres and degrees
//! outside, SI inside.

use nalgebra::{Translation3, UnitQuaternion};
use polishc::job;
use polishc::motion::frames::{self, FrameChain, Matrix, Transform};
use polishc::motion::{Arm, configuration, contact};
use polishc::tool::Azimuth;
use polishc::tool::bonnet::ContactCircle;
use polishc::units::si::{Angle, AngularSpeed, Length, Mass, Range};
use serde_json::{Value, json};

/// The functions of this area.
pub fn run(function: &str, input: &Value, expected: &Value, document: &Value) -> Option<Result<Value, String>> {
    let answer: fn(&Value, &Value, &Value) -> Result<Value, String> = match function {
        "fk" => fk,
        "ik_all_turns" => ik_all_turns,
        "matrix_to_quat_abc" => matrix_to_quat_abc,
        "abb_confdata" => abb_confdata,
        "kuka_status_turn" => kuka_status_turn,
        "robtarget_from_joints" => robtarget_from_joints,
        "tool_pose" => tool_pose,
        _ => return None,
    };
    Some(answer(input, expected, document))
}

fn fk(input: &Value, expected: &Value, document: &Value) -> Result<Value, String> {
    let pose = arm(input, document)?.forward(&joints(&input["joints_deg"])?);
    Ok(json!({
        "position_mm": position_mm(&pose),
        "quat_wxyz": same_side(frames::wxyz(&pose.rotation), &expected["quat_wxyz"])?,
        "abc_deg": abc_deg(&frames::matrix(&pose.rotation), &expected["abc_deg"])?,
    }))
}

/// Sorted like the expected list: both by their numbers, to a thousandth of a degree, so that rounding does not swap
/// two.
fn ik_all_turns(input: &Value, expected: &Value, document: &Value) -> Result<Value, String> {
    let arm = arm(input, document)?;
    let [x, y, z] = numbers(&input["flange_position_mm"])?.map(|a| a * 1e-3);
    let [w, i, j, k] = numbers(&input["flange_quat_wxyz"])?;
    let rotation = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, i, j, k));
    let flange = Transform::from_parts(Translation3::new(x, y, z), rotation);
    let mut found: Vec<[f64; 6]> =
        arm.inverse_all_turns(&flange).map(|solution| solution.joints.map(f64::to_degrees)).collect();
    let wanted: Vec<[f64; 6]> =
        expected["joints_deg"].as_array().ok_or("no list")?.iter().map(numbers).collect::<Result<_, _>>()?;
    // Puts each found solution where the nearest expected one stands; one that is nobody's nearest stays and differs.
    let mut ordered = Vec::new();
    for wanted in &wanted {
        let distance = |a: &[f64; 6]| a.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let Some(i) = (0..found.len()).min_by(|a, b| distance(&found[*a]).total_cmp(&distance(&found[*b]))) else {
            break;
        };
        ordered.push(found.swap_remove(i));
    }
    ordered.extend(found);
    Ok(json!({ "joints_deg": ordered }))
}

fn matrix_to_quat_abc(input: &Value, expected: &Value, _: &Value) -> Result<Value, String> {
    let matrix = matrix(&input["R"])?;
    let quaternion = frames::wxyz(&frames::quaternion_from_matrix(&matrix));
    Ok(json!({
        "quat_wxyz": same_side(quaternion, &expected["quat_wxyz"])?,
        "abc_deg": abc_deg(&matrix, &expected["abc_deg"])?,
    }))
}

fn abb_confdata(input: &Value, _: &Value, document: &Value) -> Result<Value, String> {
    let arm = arm(input, document)?;
    let joints = joints(&input["joints_deg"])?;
    let (_, distances) = arm.posture(&joints);
    Ok(json!({
        "confdata": configuration::confdata(&arm, &joints),
        "wrist_radius_mm": distances.shoulder * 1e3,
        "elbow_gamma_deg": arm.elbow_angle(&joints).to_degrees(),
    }))
}

fn kuka_status_turn(input: &Value, _: &Value, document: &Value) -> Result<Value, String> {
    let arm = arm(input, document)?;
    let joints = joints(&input["joints_deg"])?;
    let (status, turn) = configuration::status_turn(&arm, &joints);
    let (_, distances) = arm.posture(&joints);
    Ok(json!({
        "S": status,
        "T": turn,
        "wrist_radius_mm": distances.shoulder * 1e3,
        "elbow_gamma_deg": arm.elbow_angle(&joints).to_degrees(),
    }))
}

fn robtarget_from_joints(input: &Value, expected: &Value, document: &Value) -> Result<Value, String> {
    let arm = arm(input, document)?;
    let joints = joints(&input["joints_deg"])?;
    let chain = FrameChain {
        world_base: transform(&input["T_world_base"])?,
        world_user: transform(&input["uframe"])?,
        user_object: transform(&input["oframe"])?,
        flange_tool: transform(&input["tframe"])?,
    };
    let pose = chain.tool(&arm.forward(&joints));
    Ok(json!({
        "trans": position_mm(&pose),
        "rot": same_side(frames::wxyz(&pose.rotation), &expected["rot"])?,
        "confdata": configuration::confdata(&arm, &joints),
    }))
}

/// A bonnet's pose over a point, metres: its middle, and the contact frame (reference direction +x of the part) leaning. The file's
/// angle eps says to where the tool's z axis goes; the shaft leans the other way.
fn leaning(input: &Value, point: [f64; 3], normal: [f64; 3]) -> Result<Transform, String> {
    if input["frame"] != "ref_x" {
        return Err(format!("unknown frame {}", input["frame"]));
    }
    let angle = |key: &str| input[key].as_f64().unwrap_or(0.0).to_radians();
    if angle("roll_deg") != 0.0 {
        return Err("a tool turned about its shaft".into());
    }
    let frame = contact::orientation(normal, Azimuth::new(0.0)).map_err(|_| "the normal runs along x")?;
    let rotation = contact::leaning(frame, angle("eps_deg") + std::f64::consts::PI, angle("rho_deg"));
    let [radius, offset] = ["R_mm", "z_offset_mm"].map(|key| input[key].as_f64().unwrap_or(f64::NAN) * 1e-3);
    let [x, y, z] = contact::raised(point, normal, radius - offset);
    Ok(Transform::from_parts(Translation3::new(x, y, z), rotation))
}

fn tool_pose(input: &Value, expected: &Value, _: &Value) -> Result<Value, String> {
    let pose = leaning(input, numbers(&input["point"])?.map(|mm: f64| mm * 1e-3), numbers(&input["normal"])?)?;
    let matrix = frames::matrix(&pose.rotation);
    let [radius, offset] = ["R_mm", "z_offset_mm"].map(|key| input[key].as_f64().unwrap_or(f64::NAN) * 1e-3);
    let circle = ContactCircle::new(radius, offset, 0.0).ok_or("no contact")?;
    Ok(json!({
        "R_tool": matrix,
        "centre": position_mm(&pose),
        "quat_wxyz": same_side(frames::wxyz(&pose.rotation), &expected["quat_wxyz"])?,
        "abc_deg": abc_deg(&matrix, &expected["abc_deg"])?,
        "shaft_dir": ([0, 1, 2].map(|i| -matrix[i][2])),
        "contact_radius_mm": circle.radius * 1e3,
    }))
}

fn arm(input: &Value, document: &Value) -> Result<Arm, String> {
    let name = &input["robot"];
    let robots = document["robots"].as_array().ok_or("no list of robots")?;
    let robot = robots.iter().find(|robot| robot["name"] == *name).ok_or("no such robot")?;
    let length = |key: &str| robot[key].as_f64().map(|mm| Length(mm * 1e-3)).ok_or(format!("no `{key}`"));
    let six = |key: &str| numbers::<6>(&robot[key]);
    let (lower, upper, speed) = (six("lower_deg")?, six("upper_deg")?, six("vmax_deg_s")?);
    let joint = |i: usize| job::Joint {
        range: Range { from: Angle(lower[i].to_radians()), to: Angle(upper[i].to_radians()) },
        speed: AngularSpeed(speed[i].to_radians()),
    };
    let robot = job::Robot {
        maker: String::new(),
        model: String::new(),
        arm: job::Arm::ortho_parallel(job::OrthoParallel {
            a1: length("a1")?,
            a2: length("a2")?,
            b: length("b")?,
            c1: length("c1")?,
            c2: length("c2")?,
            c3: length("c3")?,
            c4: length("c4")?,
            offsets: six("offsets_deg")?.map(|a| Angle(a.to_radians())).to_vec(),
            signs: six("signs")?.to_vec(),
        }),
        joints: (0..6).map(joint).collect(),
        payload: Mass(200.0),
        wrist_inertia: None,
        range_margin: Angle(0.0),
        wrist_margin: Angle(0.0),
        elbow_margin: 0.0,
        shoulder_margin: Length(0.0),
        cell: None,
    };
    Arm::new(&robot).map_err(|problem| problem.message)
}

fn numbers<const N: usize>(value: &Value) -> Result<[f64; N], String> {
    let numbers: Option<Vec<f64>> = value.as_array().ok_or("not a list")?.iter().map(Value::as_f64).collect();
    numbers.ok_or("not numbers")?.try_into().map_err(|_| "wrong count".into())
}

fn joints(value: &Value) -> Result<[f64; 6], String> {
    Ok(numbers(value)?.map(f64::to_radians))
}

fn matrix(value: &Value) -> Result<Matrix, String> {
    let rows: Vec<[f64; 3]> = value.as_array().ok_or("not a matrix")?.iter().map(numbers).collect::<Result<_, _>>()?;
    rows.try_into().map_err(|_| "wrong count".into())
}

/// A 4 x 4 matrix in millimetres.
fn transform(value: &Value) -> Result<Transform, String> {
    let rows: Vec<[f64; 4]> = value.as_array().ok_or("not a matrix")?.iter().map(numbers).collect::<Result<_, _>>()?;
    let rows: [[f64; 4]; 4] = rows.try_into().map_err(|_| "wrong count")?;
    let rotation = [0, 1, 2].map(|i| [rows[i][0], rows[i][1], rows[i][2]]);
    let at = Translation3::new(rows[0][3] * 1e-3, rows[1][3] * 1e-3, rows[2][3] * 1e-3);
    Ok(Transform::from_parts(at, frames::quaternion_from_matrix(&rotation)))
}

fn position_mm(pose: &Transform) -> [f64; 3] {
    let p = pose.translation.vector;
    [p.x * 1e3, p.y * 1e3, p.z * 1e3]
}

/// The same rotation, written with the expected one's sign.
fn same_side(found: [f64; 4], expected: &Value) -> Result<[f64; 4], String> {
    let expected: [f64; 4] = numbers(expected)?;
    let dot: f64 = found.iter().zip(expected).map(|(a, b)| a * b).sum();
    Ok(if dot < 0.0 { found.map(|x| -x) } else { found })
}

/// A, B, C in degrees; an angle of 180 degrees is written with the expected sign. Where B is a quarter turn (to the
/// rounding of the matrix) only the matrix counts: the angles are written as expected if they make the same matrix.
fn abc_deg(m: &Matrix, expected: &Value) -> Result<[f64; 3], String> {
    let expected: [f64; 3] = numbers(expected)?;
    let mut found = frames::kuka_abc(m).map(f64::to_degrees);
    if (expected[1].abs() - 90.0).abs() < 1e-6 {
        let [(sa, ca), (sb, cb), (sc, cc)] = expected.map(|a| a.to_radians().sin_cos());
        let rebuilt = [
            [ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
            [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc],
            [-sb, cb * sc, cb * cc],
        ];
        let [(sa, ca), (sb, cb), (sc, cc)] = found.map(|a| a.to_radians().sin_cos());
        let ours = [
            [ca * cb, ca * sb * sc - sa * cc, ca * sb * cc + sa * sc],
            [sa * cb, sa * sb * sc + ca * cc, sa * sb * cc - ca * sc],
            [-sb, cb * sc, cb * cc],
        ];
        let same = rebuilt.iter().flatten().zip(ours.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-8);
        return Ok(if same { expected } else { found });
    }
    for (found, expected) in found.iter_mut().zip(expected) {
        if (*found - expected).abs() > 359.0 {
            *found += 360.0_f64.copysign(expected - *found);
        }
    }
    Ok(found)
}
