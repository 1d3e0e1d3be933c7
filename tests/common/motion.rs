//! An IRB 6700-200/2.60 in a cell, and flat paths, for the tests of motion.
#![allow(dead_code, reason = "each test file uses its part")]

use polishc::dwell::TimedPath;
use polishc::job::*;
use polishc::path::{Line, Link, Points, ToolPath};
use polishc::units::si::{Angle, AngularSpeed, Length, Mass, Range, Speed};

pub fn deg(angles: [f64; 6]) -> [f64; 6] {
    angles.map(f64::to_radians)
}

/// Lengths in millimetres, angles in degrees, speeds in degrees a second.
#[derive(Debug)]
pub struct ArmNumbers {
    pub lengths: [f64; 7],
    pub offsets: [f64; 6],
    pub signs: [f64; 6],
    pub lower: [f64; 6],
    pub upper: [f64; 6],
    pub speeds: [f64; 6],
}

/// Of the maker's data, as in tests/golden/robots.json.
pub const IRB_6700: ArmNumbers = ArmNumbers {
    lengths: [320.0, -200.0, 0.0, 780.0, 1125.0, 1142.5, 200.0],
    offsets: [0.0, 0.0, -90.0, 0.0, 0.0, 0.0],
    signs: [1.0; 6],
    lower: [-170.0, -65.0, -180.0, -300.0, -130.0, -360.0],
    upper: [170.0, 85.0, 70.0, 300.0, 130.0, 360.0],
    speeds: [110.0, 110.0, 110.0, 190.0, 150.0, 210.0],
};

/// KR 210 R2700 extra, as in tests/golden/robots.json: other signs, other offsets, a2 of the other sign.
pub const KR_210: ArmNumbers = ArmNumbers {
    lengths: [350.0, 41.0, 0.0, 675.0, 1150.0, 1200.0, 215.0],
    offsets: [0.0, -90.0, 0.0, 0.0, 0.0, 0.0],
    signs: [-1.0, 1.0, 1.0, -1.0, 1.0, -1.0],
    lower: [-185.0, -140.0, -120.0, -350.0, -125.0, -350.0],
    upper: [185.0, -5.0, 155.0, 350.0, 125.0, 350.0],
    speeds: [123.0, 115.0, 112.0, 179.0, 172.0, 219.0],
};

/// No maker's arm: the offset b, which the others have not.
pub const WITH_OFFSET_B: ArmNumbers =
    ArmNumbers { lengths: [320.0, -200.0, 85.0, 780.0, 1125.0, 1142.5, 200.0], ..IRB_6700 };

pub fn robot(numbers: &ArmNumbers) -> Robot {
    let [a1, a2, b, c1, c2, c3, c4] = numbers.lengths.map(|mm| Length(mm * 1e-3));
    let joint = |i: usize| Joint {
        range: Range { from: Angle(numbers.lower[i].to_radians()), to: Angle(numbers.upper[i].to_radians()) },
        speed: AngularSpeed(numbers.speeds[i].to_radians()),
    };
    Robot {
        maker: "test".into(),
        model: "test".into(),
        arm: Arm::ortho_parallel(OrthoParallel {
            a1,
            a2,
            b,
            c1,
            c2,
            c3,
            c4,
            offsets: numbers.offsets.map(|a| Angle(a.to_radians())).to_vec(),
            signs: numbers.signs.to_vec(),
        }),
        joints: (0..6).map(joint).collect(),
        payload: Mass(200.0),
        wrist_inertia: None,
        range_margin: Angle(5_f64.to_radians()),
        wrist_margin: Angle(5_f64.to_radians()),
        elbow_margin: 0.1,
        shoulder_margin: Length(0.1),
        cell: None,
    }
}

pub fn point(x: f64, y: f64, z: f64) -> Point {
    Point { x: Length(x * 1e-3), y: Length(y * 1e-3), z: Length(z * 1e-3) }
}

/// The IRB 6700 before a table, no frame being the identity and the tool standing askew on the flange.
pub fn irb_6700_in_cell() -> Robot {
    let turned = |z: f64, y: f64, x: f64| {
        Rotation::zyx_intrinsic(ZyxIntrinsic {
            about_z: Angle(z.to_radians()),
            about_y: Angle(y.to_radians()),
            about_x: Angle(x.to_radians()),
        })
    };
    let cell = RobotCell {
        base: Frame { at: point(100.0, 50.0, 20.0), rotation: turned(4.0, 0.0, 0.0) },
        user: Frame { at: point(1500.0, -150.0, 600.0), rotation: turned(-11.0, 1.0, 0.0) },
        object: Frame { at: point(150.0, 250.0, 60.0), rotation: turned(20.0, 0.0, -1.5) },
        tcp: TcpNumbers {
            wheel_diameter: None,
            at: point(40.0, 0.0, 330.0),
            rotation: turned(0.0, 17.0, 0.0),
            load: Load { mass: Mass(60.0), centre: point(10.0, 0.0, 140.0), inertia: None },
        },
        home: [0.0, -20.0, 30.0, 0.0, 70.0, 0.0].map(|a: f64| Angle(a.to_radians())).to_vec(),
        safe_poses: vec![],
        home_tolerance: Angle(0.01),
        travel: Lifted { height: Length(0.05), speed: Speed(0.05) },
        joint_move_speed: 0.1,
        process: Process::manual(Manual { interlock: "K1".into() }),
    };
    Robot { cell: Some(cell), ..robot(&IRB_6700) }
}

/// A serpentine raster over a plane: lines along x, metres, one speed.
pub fn raster(lines: usize, points_per_line: usize, step: f64, pitch: f64, speed: f64, link: Link) -> TimedPath {
    let mut points = Points::default();
    let mut path_lines = Vec::new();
    let half = |count: usize, step: f64| (count as f64 - 1.0) * step / 2.0;
    for line in 0..lines {
        let start = points.len();
        for i in 0..points_per_line {
            let along = i as f64 * step - half(points_per_line, step);
            points.x.push(if line % 2 == 0 || link == Link::Lifted { along } else { -along });
            points.y.push(line as f64 * pitch - half(lines, pitch));
            points.z.push(0.0);
            points.normal_x.push(0.0);
            points.normal_y.push(0.0);
            points.normal_z.push(1.0);
        }
        path_lines.push(Line { points: start..points.len(), link });
    }
    let speed = vec![speed; points.len()];
    TimedPath { path: ToolPath { points, lines: path_lines, ..ToolPath::default() }, speed, standing: Vec::new() }
}
