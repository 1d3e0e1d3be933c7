//! The residuals of the study that the solver was chosen by: maps of 200 x 200 pixels over 200 mm, a hexagonal spiral of 2 mm steps
//! inside 90 mm, a Gaussian of 25 mm diameter with a sixth of it as sigma and 10 nm/s in the middle, up to 100 mm/s.
#![allow(clippy::disallowed_methods, reason = "tests read files and may use the platform's mathematics")]

use polishc::dwell::Footprint;
use polishc::dwell::bounds::Bounds;
use polishc::dwell::descent::{Ended, LinearOperator, descend};
use polishc::dwell::objective::{Base, Objective, Price, Wanted};
use polishc::dwell::removal::{Removal, Samples, Window, deposit};
use polishc::dwell::solver::STOP;
use polishc::path::{Line, Link, Points, ToolPath};
use polishc::tool::InfluenceFunction;
use std::collections::BTreeSet;

/// Cells of a hexagonal mesh of 2.5 mm diagonal whose centres lie within 90 mm, in the order of a spiral from the outside that
/// keeps the visited cells on its right; smoothed over five nodes, and resampled to 2 mm. 6011 nodes, 12019.6 mm.
fn spiral() -> ToolPath {
    const D: f64 = 2.5e-3;
    const STEPS: [(i32, i32); 6] = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)];
    let place =
        |(p, q): (i32, i32)| [0.75 * D * f64::from(p), 0.75f64.sqrt() * D * (f64::from(q) + 0.5 * f64::from(p))];
    let mut free: BTreeSet<(i32, i32)> = (-60..=60)
        .flat_map(|p| (-60..=60).map(move |q| (p, q)))
        .filter(|cell| place(*cell)[0].hypot(place(*cell)[1]) < 90e-3)
        .collect();
    let most = free.iter().map(|cell| cell.0).max().expect("cells");
    let mut cell = *free.iter().find(|cell| cell.0 == most).expect("cells");
    let (mut heading, mut nodes) = (1, vec![place(cell)]);
    free.remove(&cell);
    let mut turns = 0..6;
    while let Some((turn, next)) = turns.clone().find_map(|turn| {
        let (dp, dq) = STEPS[(heading + turn) as usize % 6];
        let next = (cell.0 + dp, cell.1 + dq);
        free.contains(&next).then_some((turn, next))
    }) {
        (cell, heading) = (next, (heading + turn) % 6);
        free.remove(&cell);
        nodes.push(place(cell));
        // Right hand first: two to the right, that is four to the left of six.
        turns = 4..9;
    }
    assert!(free.is_empty(), "one spiral fills a disc");
    let n = nodes.len() as i64;
    let weights: Vec<f64> = (-2..=2).map(|t: i32| (-0.5 * f64::from(t * t)).exp()).collect();
    let total: f64 = weights.iter().sum();
    // Beyond the ends the path goes on mirrored at its end point.
    let at = |i: i64, axis: usize| match i {
        i if i < 0 => 2.0 * nodes[0][axis] - nodes[(-i) as usize][axis],
        i if i >= n => 2.0 * nodes[n as usize - 1][axis] - nodes[(2 * n - 2 - i) as usize][axis],
        i => nodes[i as usize][axis],
    };
    let smooth: Vec<[f64; 2]> = (0..n)
        .map(|i| [0, 1].map(|axis| (0..5).map(|k| weights[k as usize] * at(i + k - 2, axis)).sum::<f64>() / total))
        .collect();
    let mut along = vec![0.0];
    for pair in smooth.windows(2) {
        along.push(along[along.len() - 1] + (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]));
    }
    let length = along[along.len() - 1];
    assert!((length - 12.0196).abs() < 1e-3, "{length}");
    let parts = (length / 2e-3).round() as usize;
    let mut points = Points::default();
    for k in 0..=parts {
        let s = length * k as f64 / parts as f64;
        let i = along.partition_point(|a| *a <= s).clamp(1, smooth.len() - 1);
        let t = (s - along[i - 1]) / (along[i] - along[i - 1]);
        let [x, y] = [0, 1].map(|axis| smooth[i - 1][axis] + t * (smooth[i][axis] - smooth[i - 1][axis]));
        points.push([x, y, 0.0], [0.0, 0.0, 1.0]);
    }
    assert_eq!(points.len(), 6011);
    ToolPath { lines: vec![Line { points: 0..points.len(), link: Link::Lifted }], points, ..ToolPath::default() }
}

/// Float32 of a `.npy` of version 1, to metres.
fn map(file: &str) -> Vec<f64> {
    let bytes = std::fs::read(file).expect("a map");
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let values: Vec<f64> = bytes[header..]
        .chunks_exact(4)
        .map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])) * 1e-9)
        .collect();
    assert_eq!(values.len(), 200 * 200);
    values
}

/// RMS about the mean in nm, and time in s, by the exact operator: of least squares, or of the shortest run that leaves `most` nm.
fn solve(file: &str, base: Base, most: Option<f64>) -> (f64, f64) {
    let window = Window { columns: 200, rows: 200, pixel: [1e-3; 2], origin: [-99.5e-3; 2] };
    let error = map(file);
    let weights: Vec<f64> = (0..window.len())
        .map(|i| {
            let [x, y] = window.position(i);
            if x.hypot(y) < 90e-3 { 1.0 } else { 0.0 }
        })
        .collect();
    let depths: Vec<f64> = error.iter().zip(&weights).map(|(e, w)| if *w > 0.0 { *e } else { 0.0 }).collect();
    let path = spiral();
    let influence = InfluenceFunction::gaussian(10e-9, 25e-3 / 6.0, 25e-3).expect("positive numbers");
    let footprint = Footprint::of(&influence, 0.0);
    let samples = Samples::segments(&path, footprint.sigma / 2.0);
    let mut operator = Removal::new(&samples, &footprint, window);
    let n = operator.unknowns();
    let (lower, upper) = (vec![0.02; n], vec![1e3; n]);
    let count = weights.iter().sum::<f64>();
    let price = most.map_or(Price::NONE, |nm| Price::Sought { most: 0.5 * count * (nm * 1e-9).powi(2), first: 0.0 });
    let wanted = Wanted { depths: &depths, weights: &weights, base, objective: Objective::Squares, price };
    // Where the study starts too: the wanted depth over the volume rate, on the area of a cell.
    let start: Vec<f64> = samples
        .start
        .windows(2)
        .map(|range| {
            let (x, y) = (samples.x[range[0]], samples.y[range[0]]);
            let pixel = |v: f64| (v * 1e3 + 99.5).round() as usize;
            let depth = depths[pixel(y) * 200 + pixel(x)] + lift(base, &depths, &weights);
            depth.max(0.0) * 2e-3 * 1.875e-3 / footprint.volume_rate
        })
        .collect();
    let mut domain = Bounds::new(&lower, &upper, &start);
    let found = descend(&mut operator, &wanted, &mut domain, STOP);
    assert_ne!(found.ended, Ended::Iterations);
    let times = domain.into_times();
    let removed = deposit(&samples, &times, &footprint, &window);
    let left: Vec<f64> =
        (0..window.len()).filter(|i| weights[*i] > 0.0).map(|i| (removed[i] - depths[i]) * 1e9).collect();
    let mean = left.iter().sum::<f64>() / left.len() as f64;
    let rms = (left.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>() / left.len() as f64).sqrt();
    (rms, times.iter().sum())
}

fn lift(base: Base, depths: &[f64], weights: &[f64]) -> f64 {
    match base {
        Base::Fixed(depth) => depth,
        Base::AtMost(_) => {
            let inside = depths.iter().zip(weights).filter(|(_, w)| **w > 0.0);
            -inside.fold(0.0f64, |low, (depth, _)| low.min(*depth))
        }
    }
}

#[test]
fn residual_and_time_are_those_of_the_study() {
    // RMS and time of maps/solver_reference.json, 200 steps of a spectral gradient each; `ls` with the lift of maps.json.
    let as_good = |(rms, time): (f64, f64), (their_rms, their_time): (f64, f64)| {
        assert!(rms <= 1.05 * their_rms && (time / their_time - 1.0).abs() < 0.03, "{rms} {time}");
    };
    let [map_a, map_b, map_c] =
        ["tests/maps/map_a.npy", "examples/sphere_200/map_b.npy", "examples/region_200/map_c.npy"];
    for (file, lift, theirs) in [
        (map_a, 327.0317671314356e-9, (6.537888348945716, 8203.1023326331)),
        (map_b, 29.875096887863556e-9, (1.1014566458410908, 789.7509392028658)),
        (map_c, 15.120586583447936e-9, (2.3955120172587643, 424.1881006137136)),
    ] {
        as_good(solve(file, Base::Fixed(lift), None), theirs);
    }
    let free = Base::AtMost(f64::INFINITY);
    as_good(solve(map_b, free, None), (1.1052295722360896, 752.9650566767317));
    as_good(solve(map_c, free, None), (0.9198688380258923, 720.0542014842098));
    // Of map A the descent goes a third below the residual of the study, by a deeper layer that takes 16 % more time. Asked for the
    // study's residual in the least time it takes less than the study.
    let (their_rms, their_time) = (6.477970488437824, 7873.403407502302);
    let (rms, time) = solve(map_a, free, Some(their_rms));
    assert!(rms <= their_rms && time < their_time, "{rms} {time}");
    let (rms, _) = solve(map_a, free, None);
    assert!(rms < their_rms, "{rms}");
}
