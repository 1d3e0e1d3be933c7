//! A job and its motion, for the tests and the bench of the program text: the 340 mm flat on an IRB 6700 with an MRF
//! wheel, a raster over it, speeds that vary from point to point.

#![allow(dead_code, reason = "each user takes what it needs")]

use polishc::dwell::{SpeedSteps, TimedPath};
use polishc::job::{Job, Target};
use polishc::motion::{self, Checked, Motion, Purpose, Request, Room};
use polishc::path::{Line, Link, Points};
use serde_json::{Value, json};

/// The job as its structs spell it, SI numbers.
pub fn job_value() -> Value {
    let deg = std::f64::consts::PI / 180.0;
    let joint =
        |range: f64, speed: f64| json!({"range": {"from": -range * deg, "to": range * deg}, "speed": speed * deg});
    let ranged =
        |from: f64, to: f64, speed: f64| json!({"range": {"from": from * deg, "to": to * deg}, "speed": speed * deg});
    json!({
        "wavelength": 632.8e-9,
        "workpiece": {
            "part": "FS340-07", "x_mark": "engraved line at the edge", "form": {"plane": {}},
            "edge": {"annulus": {"outer_diameter": 0.34, "inner_diameter": 0.06, "centre": null}},
            "clear": {"annulus": {"outer_diameter": 0.323, "inner_diameter": 0.07, "centre": null}},
            "material": {"name": "fused silica"},
            "error": {"height_map": {
                "file": "flat.dat", "quantity": "surface", "positive": "high", "view": "from_tool_side", "up": "plus_y",
                "subtract": ["piston", "tilt"], "pixel": null, "unit": null, "centre": {"frame_centre": {}},
                "fill_below": null
            }}
        },
        "tool": {"mrf_wheel": {
            "diameter": 0.36, "speed": 60.0 * 6.0 * deg, "rotation": "forward", "gap": 0.001, "azimuth": 165.0 * deg,
            "influence": {"gaussian": {"peak": 1e-8, "sigma": 0.003, "diameter": 0.02}}
        }},
        "path": {"raster": {
            "over": {"circle": {"diameter": 0.38, "centre": null}}, "point_step": 0.004, "line_pitch": 0.0005,
            "direction": 0.0, "lines": "serpentine", "chord_error": 1e-5, "holes": {"cross": {"process": "on"}}
        }},
        "dwell": {"corrective": {
            "objective": {"rms": {}}, "removal_fraction": 0.8, "lateral_acceleration": null, "piston": {"free": {"at_most": 2e-8}}, "feed": {"from": 2e-4, "to": 0.1},
            "acceleration": 0.5
        }},
        "robot": {
            "maker": "ABB", "model": "IRB 6700-200/2.60",
            "arm": {"ortho_parallel": {
                "a1": 0.32, "a2": -0.2, "b": 0.0, "c1": 0.78, "c2": 1.125, "c3": 1.1425, "c4": 0.2,
                "offsets": [0.0, 0.0, -90.0 * deg, 0.0, 0.0, 0.0], "signs": [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
            }},
            "joints": [
                joint(170.0, 110.0), ranged(-65.0, 85.0, 110.0), ranged(-180.0, 70.0, 110.0),
                joint(300.0, 190.0), joint(130.0, 150.0), joint(360.0, 210.0)
            ],
            "payload": 200.0, "wrist_inertia": null, "range_margin": 5.0 * deg, "wrist_margin": 5.0 * deg, "elbow_margin": 0.1,
            "shoulder_margin": 0.1,
            "cell": {
                "base": {"at": {"x": 0.01, "y": -0.02, "z": 0.3}, "rotation": {"zyx_intrinsic": {
                    "about_z": 1.5 * deg, "about_y": 0.1 * deg, "about_x": -0.2 * deg}}},
                "user": {"at": {"x": 1.85042, "y": -0.0128, "z": 0.94015}, "rotation": {"zyx_intrinsic": {
                    "about_z": 0.021 * deg, "about_y": -0.008 * deg, "about_x": 0.013 * deg}}},
                "object": {"at": {"x": -0.15, "y": 0.08, "z": 0.085}, "rotation": {"zyx_intrinsic": {
                    "about_z": 30.0 * deg, "about_y": 0.0, "about_x": 0.0}}},
                "tcp": {
                    "at": {"x": 0.20034, "y": -0.00112, "z": 0.3126},
                    "rotation": {"zyx_intrinsic": {"about_z": 0.0, "about_y": 45.0 * deg, "about_x": 0.0}},
                    "load": {"mass": 42.0, "centre": {"x": 0.005, "y": 0.0, "z": 0.21}, "inertia": null}
                },
                "home": [0.0, -20.0 * deg, 10.0 * deg, 0.0, 55.0 * deg, 0.0],
                "safe_poses": [[10.0 * deg, -20.0 * deg, 10.0 * deg, 0.0, 55.0 * deg, 0.0]],
                "home_tolerance": 1.0 * deg,
                "travel": {"height": 0.05, "speed": 0.05},
                "joint_move_speed": 0.1,
                "process": {"signals": {
                    "interlock": "relay K3",
                    "outputs": [
                        {"name": "doSpindle", "number": null, "active": "high", "settle": 3.0},
                        {"name": "doSlurry", "number": null, "active": "low", "settle": 5.0}
                    ],
                    "inputs": [{"name": "diSpindleOk", "number": null, "active": "high", "wait_at_most": 10.0}]
                }}
            }
        },
        "target": {"rapid": {
            "controller": {
                "name": "IRC5", "name_length": 32, "position_decimals": 4, "quaternion_decimals": 8,
                "speed_decimals": 3, "module_points": 5000, "module_bytes": 2_000_000, "segment_time_least": 0.01,
                "segment_time_usual": 0.02, "folder": "HOME:/polishc", "orientation_speed": 500.0 * deg,
                "most_points": 5_000_000
            },
            "module": "Flat340", "frames": "in_program", "tool_name": "tWheel", "object_name": "wPart",
            "frame_tolerance": 5e-5, "frame_angle_tolerance": 0.01 * deg, "zone": "z0"
        }},
        "unchecked": ["arm", "cell", "cable", "fixture"]
    })
}

/// The same on a KUKA KR 210 R2700-2, for KRL.
pub fn krl_job_value() -> Value {
    let deg = std::f64::consts::PI / 180.0;
    let joint =
        |from: f64, to: f64, speed: f64| json!({"range": {"from": from * deg, "to": to * deg}, "speed": speed * deg});
    let mut job = job_value();
    let robot = &mut job["robot"];
    robot["maker"] = json!("KUKA");
    robot["model"] = json!("KR 210 R2700-2");
    robot["arm"] = json!({"ortho_parallel": {
        "a1": 0.33, "a2": -0.115, "b": 0.0, "c1": 0.645, "c2": 1.15, "c3": 1.22, "c4": 0.215,
        "offsets": [0.0, -90.0 * deg, 0.0, 0.0, 0.0, 0.0], "signs": [-1.0, 1.0, 1.0, -1.0, 1.0, -1.0]
    }});
    robot["joints"] = json!([
        joint(-185.0, 185.0, 117.0),
        joint(-140.0, -5.0, 111.0),
        joint(-120.0, 168.0, 112.0),
        joint(-350.0, 350.0, 179.0),
        joint(-125.0, 125.0, 172.0),
        joint(-350.0, 350.0, 220.0)
    ]);
    let cell = &mut robot["cell"];
    let home = [0.0, -110.0 * deg, 100.0 * deg, 0.0, 55.0 * deg, 0.0];
    cell["home"] = json!(home);
    cell["safe_poses"] = json!([[10.0 * deg, home[1], home[2], home[3], home[4], home[5]]]);
    let signals = &mut cell["process"]["signals"];
    signals["outputs"][0]["number"] = json!(17);
    signals["outputs"][1]["number"] = json!(18);
    signals["inputs"][0]["number"] = json!(5);
    job["target"] = json!({"krl": {
        "controller": {
            "name": "KRC4", "name_length": 24, "position_decimals": 4, "angle_decimals": 6, "speed_digits": 7,
            "file_lines": 1400, "file_bytes": 250_000, "program_bytes": 2_000_000, "block_segments": 500,
            "dir_loader": "absent", "advance": 5, "segment_time_least": 0.01, "segment_time_usual": 0.02,
            "orientation_speed": 200.0 * deg, "orientation_acceleration": 400.0 * deg, "most_points": 500_000
        },
        "module": "Flat340", "frames": {"in_program": {}}, "frame_tolerance": 5e-5,
        "frame_angle_tolerance": 0.01 * deg, "motion": {"spline": {}}, "memory": "resident"
    }});
    job
}

/// The job of [`krl_job_value`] with the value at `path` replaced.
pub fn krl_job_with(changes: &[(&str, Value)]) -> Job {
    changed(krl_job_value(), changes)
}

/// The job of [`job_value`] with the value at `path` (`/target/rapid/zone`) replaced.
pub fn job_with(changes: &[(&str, Value)]) -> Job {
    changed(job_value(), changes)
}

fn changed(mut value: Value, changes: &[(&str, Value)]) -> Job {
    for (path, new) in changes {
        *value.pointer_mut(path).expect("a field of the job") = new.clone();
    }
    serde_json::from_value(value).expect("a job")
}

/// A serpentine raster of `lines` lines of `points` points on z = 0, centred on the part, pitch 0.5 mm, step 4 mm, speeds
/// from 10 to 60 mm/s in steps of 0.001 mm/s.
pub fn raster(lines: usize, points: usize) -> TimedPath {
    let mut found = TimedPath::default();
    let Points { x, y, z, normal_x, normal_y, normal_z } = &mut found.path.points;
    for line in 0..lines {
        let start = x.len();
        for i in 0..points {
            let along = if line % 2 == 0 { i } else { points - 1 - i };
            x.push((along as f64 - (points - 1) as f64 / 2.0) * 0.004);
            y.push((line as f64 - (lines - 1) as f64 / 2.0) * 0.0005);
            z.push(0.0);
            normal_x.push(0.0);
            normal_y.push(0.0);
            normal_z.push(1.0);
            // Any numbers do; these spread over the range without repeating.
            let step = 10_000 + (x.len() * 7919) % 50_000;
            found.speed.push(step as f64 * 1e-6);
        }
        found.path.lines.push(Line { points: start..x.len(), link: Link::OnSurface });
    }
    found
}

/// The path on a slightly curved, tilted patch, so that normals differ from point to point.
pub fn curved(mut timed: TimedPath) -> TimedPath {
    let points = &mut timed.path.points;
    for i in 0..points.x.len() {
        let (x, y) = (points.x[i], points.y[i]);
        // z = (x² + y²) / 2R with R = 2 m, and its normal.
        points.z[i] = (x * x + y * y) / 4.0;
        let length = (x * x + y * y + 4.0).sqrt();
        points.normal_x[i] = -x / length;
        points.normal_y[i] = -y / length;
        points.normal_z[i] = 2.0 / length;
    }
    timed
}

/// The planned motion of `timed` for `job`.
pub fn plan(job: &Job, timed: TimedPath, purpose: Purpose) -> Checked<Motion> {
    // RAPID programs of these tests end their runs at the number of points, KRL programs at the room of a file.
    let limits = polishc::target::limits(job.target.as_ref().expect("a target"));
    let room = match &job.target {
        Some(Target::rapid(rapid)) => Room::points(usize::try_from(rapid.controller.module_points).expect("a count")),
        _ => limits.room,
    };
    let request = Request {
        standoff: job.tool.standoff(),
        azimuth: job.tool.azimuth(),
        tool_ball: job.tool.ball(),
        part: [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]],
        acceleration: 0.5,
        purpose,
        room,
        // Speeds of these tests are whole micrometres a second, which every target can write.
        speed_steps: SpeedSteps::Fixed(1e-6),
    };
    motion::plan(timed, job.robot.as_ref().expect("a robot"), &request).unwrap_or_else(|p| panic!("{p:?}"))
}
