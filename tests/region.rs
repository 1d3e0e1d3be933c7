//! The region-adaptive path on the reference maps and on regions made here.
//!
//! Expected counts and coverages are those of the reference that was made for this project (its maps.json and the table of its
//! section 2.3); the rest is derived by hand or by brute force.
#![allow(clippy::disallowed_methods, reason = "tests may use the platform's mathematics")]

mod common;

use common::TestFiles;
use common::regions::{self, MESH, SIDE, TOLERANCE, cells_in, cells_in_reach, heights, pixel, reach};
use polishc::diagnostics::{Problem, codes};
use polishc::height_map::Grid;
use polishc::job::{
    Annulus, Aperture, Bounded, Circle, Empty, FixedLift, HexagonalMesh, Landing, Lift as JobLift, Merge,
    Place as JobPlace, RegionAdaptive,
};
use polishc::path::region::merge::{self, Within};
use polishc::path::region::mesh::{self, Cells, Hexagon};
use polishc::path::region::select::{Lift, Region, select};
use polishc::path::region::smooth::{self, Ends, Place};
use polishc::path::region::{self, RegionPath, coverage, fill};
use polishc::report::Met;
use polishc::session::{self, Compilation, Request, Unwatched};
use polishc::target::Program;
use polishc::units::si::{Angle, Length, Speed, Time};

fn selected(map: char, lift: Lift) -> Region {
    select(&heights(map), &reach(), lift, TOLERANCE, TOLERANCE).expect("known pixels")
}

/// Nodes within a diagonal of the region's pixels: the coverage of the table, and the greatest distance in millimetres.
fn covered(map: char, region: &Region, nodes: &[Place]) -> (f64, f64) {
    let heights = heights(map);
    let pixels: Vec<(Place, f64)> =
        (0..SIDE * SIDE).filter(|i| region.pixels[*i]).map(|i| (pixel(i), region.wanted(heights[i]))).collect();
    let found = coverage::measure(&pixels, nodes, MESH.diagonal);
    if map != 'C' {
        return (found.share, found.farthest);
    }
    // Again, pixel against node.
    let distance = |p: Place| nodes.iter().map(|n| (n[0] - p[0]).hypot(n[1] - p[1])).fold(f64::INFINITY, f64::min);
    let distances: Vec<f64> = pixels.iter().map(|(place, _)| distance(*place)).collect();
    let share = distances.iter().filter(|d| **d <= MESH.diagonal * (1.0 + 1e-6)).count() as f64 / pixels.len() as f64;
    assert_eq!(found.share, share);
    assert!((found.farthest - distances.iter().copied().fold(0.0, f64::max)).abs() < 1e-12);
    (share, found.farthest)
}

fn nodes(paths: &[Vec<Hexagon>]) -> Vec<Place> {
    paths.iter().flatten().map(|hexagon| MESH.place(*hexagon)).collect()
}

/// maps.json: lift (nm), pixels, hexagons, after cleaning, primary paths, paths of the corrected paper merge, nodes it drops.
#[test]
fn counts_of_the_reference_are_met_exactly() {
    let expected = [
        ('A', 327.031_767_131_435_63, 25364, 6207, 6207, 1, 1, 0, 1.0, 2.0),
        ('B', 29.875_096_887_863_556, 21622, 5306, 5310, 43, 11, 82, 0.9958, 11.9),
        ('C', 15.120_586_583_447_935, 12637, 3087, 3091, 49, 8, 99, 0.9968, 5.6),
    ];
    assert_eq!(cells_in_reach().len(), 6233);
    for (map, lift, pixels, passable, cleaned, primary, merged, dropped, share, farthest) in expected {
        let region = selected(map, Lift::Rms3);
        assert!((region.lift - lift).abs() < 1e-9, "{map}: lift {}", region.lift);
        assert_eq!(region.count, pixels, "{map}");
        let mut cells = cells_in(&region);
        assert_eq!(cells.len(), passable, "{map}");
        mesh::clean(&mut cells, &cells_in_reach(), 1, 1);
        assert_eq!(cells.len(), cleaned, "{map}");
        let paths = fill::fill(&cells.iter().collect::<Vec<_>>(), &mut cells.clone());
        assert_eq!(paths.len(), primary, "{map}");
        assert_eq!(paths.iter().map(Vec::len).sum::<usize>(), cleaned, "{map}");
        let paper = merge::paper(paths, 10, 10);
        assert_eq!((paper.paths.len(), paper.trimmed + paper.dropped), (merged, dropped), "{map}");
        let (found, far) = covered(map, &region, &nodes(&paper.paths));
        assert!((found - share).abs() < 0.5e-4 && (far - farthest).abs() < 0.05, "{map}: {found} {far}");
    }
}

/// The table of 2.3: coverage and farthest pixel of its own rule.
#[test]
fn bridge_or_trim_covers_at_least_what_the_reference_did() {
    for (map, share, farthest) in [('A', 1.0, 2.0), ('B', 0.9987, 6.7), ('C', 0.9987, 3.6)] {
        for turn_limit in [180.1_f64, 90.0] {
            let region = selected(map, Lift::Rms3);
            let mut cells = cells_in(&region);
            mesh::clean(&mut cells, &cells_in_reach(), 1, 1);
            let weights = smooth::weights(1.0, smooth::half_window(1.0));
            let within = Within { steps: 10, shortest: 10, weights: &weights, turn_limit: turn_limit.to_radians() };
            let mut paths = Vec::new();
            let mut visited = Cells::new(cells.sheet());
            for part in cells.components() {
                let own = Cells::from_list(&part);
                let primary = fill::fill(&part, &mut own.clone());
                let merged = merge::bridge_or_trim(primary, &own, &within);
                // No path leaves its part, and none jumps.
                for pair in merged.paths.iter().flat_map(|path| path.windows(2)) {
                    assert_eq!(pair[0].distance(pair[1]), 1, "{map}");
                }
                let count = merged.paths.iter().flatten().inspect(|h| assert!(own.contains(**h))).count();
                assert_eq!(count + merged.trimmed + merged.dropped, part.len() + merged.bridged, "{map}");
                merged.paths.iter().flatten().for_each(|hexagon| visited.insert(*hexagon));
                paths.extend(merged.paths);
            }
            // What is not visited has a visited neighbour: it is never farther than a step from the path.
            for hexagon in cells.iter().filter(|h| !visited.contains(*h)) {
                assert!((0..6).any(|k| visited.contains(hexagon.neighbour(k))), "{map}: {hexagon:?}");
            }
            let (found, far) = covered(map, &region, &nodes(&paths));
            assert!(found >= share - 0.5e-4 && far <= farthest + 0.05, "{map} {turn_limit}: {found} {far}");
        }
    }
}

/// solver_reference.json, path `full`: 6011 points, 12019.604282333965 mm before resampling.
#[test]
fn the_full_path_is_that_of_the_solver_references() {
    let path = regions::full_path();
    assert_eq!(path.len(), 6011);
    // The chords of the resampled curve are a little shorter than the curve.
    let length = smooth::length(&path);
    assert!(length < 12_019.604_282_333_965 && length > 0.998 * 12_019.604_282_333_965);
    let cells = cells_in_reach();
    let paths = fill::fill(&cells.iter().collect::<Vec<_>>(), &mut cells.clone());
    let curve = smooth::smooth(&nodes(&paths), &smooth::weights(1.0, 2), Ends::Reflected);
    assert!((smooth::length(&curve) - 12_019.604_282_333_965).abs() < 1e-6);
}

/// Table of section 1: part of the area and volume (nm mm²) of both lifts on map B, and no difference on map C.
#[test]
fn the_bounded_lift_keeps_good_ground_out() {
    let known = |region: &Region| region.count as f64 / region.statistics.count as f64;
    let (rms3, bounded) = (selected('B', Lift::Rms3), selected('B', Lift::Bounded(0.005)));
    assert!((known(&rms3) - 0.850).abs() < 5e-4 && (rms3.height_sum / 7.10e5 - 1.0).abs() < 1e-3);
    assert!((known(&bounded) - 0.650).abs() < 5e-4 && (bounded.height_sum / 5.37e5 - 1.0).abs() < 1e-3);
    assert_eq!(selected('C', Lift::Rms3), selected('C', Lift::Bounded(0.005)));
}

/// Numbers without rhyme, the same in every run.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % sides
    }
}

/// A patch of the mesh with holes: of each hexagon so many in ten.
fn patch(dice: &mut Dice, radius: i32, in_ten: u64) -> Vec<Hexagon> {
    let centre = Hexagon::default();
    let all = (-radius..=radius).flat_map(|p| (-radius..=radius).map(move |q| Hexagon { p, q }));
    all.filter(|hexagon| hexagon.distance(centre) <= radius as u32 && dice.roll(10) < in_ten).collect()
}

#[test]
fn every_hexagon_is_visited_once_whatever_the_set() {
    let mut dice = Dice(1);
    for round in 0..200 {
        let list = patch(&mut dice, 3 + round % 9, 4 + dice_step(round));
        let paths = fill::fill(&list, &mut Cells::from_list(&list));
        let mut visited: Vec<Hexagon> = paths.iter().flatten().copied().collect();
        visited.sort();
        let mut wanted = list.clone();
        wanted.sort();
        assert_eq!(visited, wanted);
        for path in &paths {
            assert!(path.windows(2).all(|pair| pair[0].distance(pair[1]) == 1));
            // Never sharper than 120 degrees: the step back is not tried, except to leave where a path starts.
            assert!(path.windows(3).all(|three| three[0] != three[2]));
        }
    }
    // A whole disc is one spiral, whatever its size.
    for radius in 0..12 {
        let disc = patch(&mut dice, radius, 10);
        assert_eq!(fill::fill(&disc, &mut Cells::from_list(&disc)).len(), 1, "{radius}");
    }
}

fn dice_step(round: i32) -> u64 {
    [0, 2, 4, 5][round as usize % 4]
}

#[test]
fn the_nearest_is_the_nearest() {
    let mut dice = Dice(7);
    for round in 0..200 {
        let list = patch(&mut dice, 8, 1 + round % 5);
        let free = Cells::from_list(&list);
        let from = Hexagon { p: dice.roll(30) as i32 - 15, q: dice.roll(30) as i32 - 15 };
        let crowd = |hexagon: Hexagon| (0..6).filter(|k| free.contains(hexagon.neighbour(*k))).count();
        let rank = |h: &Hexagon| (from.distance(*h), crowd(*h), from.square(*h), *h);
        assert_eq!(fill::nearest(from, &free), list.iter().min_by_key(|h| rank(h)).copied());
    }
}

#[test]
fn joining_keeps_every_hexagon_in_reach_whatever_the_set() {
    let weights = smooth::weights(1.0, 2);
    let mut dice = Dice(3);
    for round in 0..300 {
        let turn_limit = [3.2, 1.6, 1.2][round % 3];
        let within = Within { steps: 2 + round % 9, shortest: 2 + round % 9, weights: &weights, turn_limit };
        let list = patch(&mut dice, 3 + (round % 9) as i32, [5, 7, 8, 9][round % 4]);
        for part in Cells::from_list(&list).components() {
            let cells = Cells::from_list(&part);
            let primary = fill::fill(&part, &mut cells.clone());
            let merged = merge::bridge_or_trim(primary.clone(), &cells, &within);
            assert!(merged.paths.len() <= primary.len());
            let mut visited = Cells::new(cells.sheet());
            merged.paths.iter().flatten().for_each(|hexagon| visited.insert(*hexagon));
            for path in &merged.paths {
                assert!(path.windows(2).all(|pair| pair[0].distance(pair[1]) == 1));
                assert!(path.iter().all(|hexagon| cells.contains(*hexagon)));
            }
            // Of a part that is more than one hexagon nothing is given up that no path passes.
            let passed = |h: &Hexagon| visited.contains(*h) || (0..6).any(|k| visited.contains(h.neighbour(k)));
            assert!(part.len() == 1 || part.iter().all(passed));
            let all: usize = merged.paths.iter().map(Vec::len).sum();
            assert_eq!(all + merged.trimmed + merged.dropped, part.len() + merged.bridged);
        }
    }
}

/// There and back on one line: cut at the far end, which both pieces keep.
#[test]
fn a_path_that_comes_back_on_itself_is_cut_there() {
    let there = (0..9).map(|i| [f64::from(i), 0.0]);
    let back = (0..8).rev().map(|i| [f64::from(i), 0.0]);
    let nodes: Vec<Place> = there.chain(back).collect();
    let weights = smooth::weights(1.0, 2);
    let pieces = region::turns::pieces(nodes.clone(), &weights, 1.6);
    assert_eq!(pieces.len(), 2);
    for (place, x) in [(pieces[0][0], 0.0), (pieces[0][8], 8.0), (pieces[1][0], 8.0), (pieces[1][8], 0.0)] {
        assert!((place[0] - x).abs() < 1e-12 && place[1] == 0.0, "{place:?}");
    }
    assert_eq!(region::turns::pieces(nodes, &weights, 3.2).len(), 1);
    // By hand, from the weights 0.0545 0.2442 0.4026: a corner of 120 degrees keeps 69.8, one of 60 degrees 26.2.
    for (corner, kept) in [(120.0_f64, 69.8), (60.0, 26.2)] {
        let (sin, cos) = corner.to_radians().sin_cos();
        let before = (0..6).map(|i| [f64::from(i) - 6.0, 0.0]);
        let after = (0..7).map(|i| [f64::from(i) * cos, f64::from(i) * sin]);
        let nodes: Vec<Place> = before.chain(after).collect();
        let turns = smooth::turns(&smooth::smooth(&nodes, &weights, Ends::Reflected));
        let most = turns.iter().copied().fold(0.0, f64::max).to_degrees();
        assert!((most - kept).abs() < 0.06, "{corner}: {most}");
    }
}

/// Straight paths stay straight and keep their ends, however short they are beside the window.
#[test]
fn smoothing_leaves_straight_paths_alone() {
    for (count, sigma) in [(2, 1.0), (3, 2.0), (4, 5.0), (40, 1.0)] {
        let nodes: Vec<Place> = (0..count).map(|i| [f64::from(i) * 0.3, f64::from(i) * -0.1]).collect();
        let weights = smooth::weights(sigma, smooth::half_window(sigma));
        let curve = smooth::smooth(&nodes, &weights, Ends::Reflected);
        assert_eq!(curve.len(), nodes.len());
        for end in [0, nodes.len() - 1] {
            assert!((curve[end][0] - nodes[end][0]).abs() < 1e-12 && (curve[end][1] - nodes[end][1]).abs() < 1e-12);
        }
        assert!(curve.iter().all(|[x, y]| (x / 3.0 + y).abs() < 1e-12));
    }
    assert_eq!(smooth::weights(0.0, smooth::half_window(0.0)), [1.0]);
}

#[test]
fn a_quantile_lies_between_two_pixels() {
    let heights: Vec<f64> = [5.0, 1.0, f64::NAN, 3.0, 2.0, 4.0, -9.0].to_vec();
    let reach = [true, true, true, true, true, true, false];
    // Of 1 2 3 4 5: a quarter of the way is 2, an eighth lies halfway between 1 and 2.
    for (part, expected) in [(0.0, 1.0), (0.25, 2.0), (0.125, 1.5), (1.0, 5.0)] {
        assert_eq!(region::select::quantile(&heights, &reach, part), expected);
    }
    assert!(region::select::quantile(&heights, &[false; 7], 0.5).is_nan());
}

// ---- The whole plan, in metres, as a job asks for it.

const SPOT: f64 = 0.025;

fn circle(diameter: f64) -> Aperture {
    Aperture::circle(Circle { diameter: Length(diameter), centre: None })
}

fn job() -> RegionAdaptive {
    RegionAdaptive {
        over: circle(0.18),
        lift: JobLift::bounded(Bounded { quantile: 0.005 }),
        above: Length(TOLERANCE * 1e-9),
        tolerance: Length(TOLERANCE * 1e-9),
        mesh: HexagonalMesh { diagonal: Length(0.0025), islands: 1, holes: 1 },
        merge: Merge::bridge_or_trim,
        smoothing: 1.0,
        point_step: Length(0.002),
        turn_limit: Angle(90f64.to_radians()),
        chord_error: Length(1e-5),
        landing: Landing { speed: Speed(0.1), reach: Length(1e-3), stand: Time(0.05) },
    }
}

/// 200 x 200 pixels of 1 mm; heights in metres by place in metres.
fn grid(height: impl Fn(f64, f64) -> f64) -> Grid {
    let origin = [-0.0995; 2];
    let mut grid = Grid { columns: SIDE, rows: SIDE, pixel: [1e-3; 2], origin, values: Vec::new() };
    let value = |i: usize| {
        let [x, y] = grid.position(i / SIDE, i % SIDE);
        height(x, y)
    };
    grid.values = (0..SIDE * SIDE).map(value).collect();
    grid
}

fn map(name: char) -> Grid {
    Grid { values: heights(name).iter().map(|h| h * 1e-9).collect(), ..grid(|_, _| 0.0) }
}

fn plan(job: &RegionAdaptive, error: &Grid) -> (RegionPath, Vec<Problem>) {
    let path = region::plan(job, error, SPOT, 100_000).unwrap_or_else(|p| panic!("{}", p.message));
    let warnings = path.figures.warnings();
    (path, warnings)
}

fn refused(job: &RegionAdaptive, error: &Grid) -> Problem {
    region::plan(job, error, SPOT, 100_000).expect_err("a refusal")
}

/// What holds of every plan.
fn check(job: &RegionAdaptive, path: &RegionPath) {
    for run in &path.runs {
        assert!(run.len() >= 2);
        let steps: Vec<f64> = run.windows(2).map(smooth::length).collect();
        // Equal along the curve, so no chord is longer; a path shorter than half a step has one.
        assert!(steps.iter().all(|step| *step <= 1.5 * job.point_step.0 + 1e-12), "{steps:?}");
        for [x, y] in run {
            assert!(job.over.distance(*x, *y) >= -0.5 * 3.0_f64.sqrt() / 2.0 * job.mesh.diagonal.0);
        }
    }
    assert!(path.figures.sharpest_turn <= job.turn_limit.0);
}

#[test]
fn a_job_plans_what_the_reference_did_but_for_the_centres_on_the_border() {
    // Of the six centres on the circle the job takes all (a place on the border belongs to an aperture), the reference, by
    // rounding, four. Of the two others (+-90, 0) one lies over a pixel within reach; map B does not select it.
    let paper = RegionAdaptive { lift: JobLift::rms3(Empty {}), merge: Merge::paper, ..job() };
    for (name, cells, cleaned, primary, merged) in
        [('A', 6207 + 1, 6207 + 1, 1, 1), ('B', 5306, 5310, 43, 11), ('C', 3087 + 1, 3091 + 1, 49, 8)]
    {
        let (path, _) = plan(&paper, &map(name));
        let figures = path.figures;
        assert_eq!((figures.cells, figures.cleaned_cells), (cells, cleaned), "{name}");
        assert_eq!((figures.primary_paths, figures.merged_paths), (primary, merged), "{name}");
        // A hair less, and the six lie outside.
        let less = RegionAdaptive { over: circle(0.179_999), ..paper.clone() };
        let border = match name {
            'A' => 4,
            'B' => 4,
            _ => 2,
        };
        assert_eq!(plan(&less, &map(name)).0.figures.cells, cells - border - usize::from(name != 'B'), "{name}");
    }
}

#[test]
fn the_maps_are_covered_without_a_sharp_turn() {
    for name in ['A', 'B', 'C'] {
        let job = job();
        let (path, warnings) = plan(&job, &map(name));
        check(&job, &path);
        assert!(path.figures.coverage >= 0.997, "{name}: {}", path.figures.coverage);
        assert!(path.figures.lost_volume <= 2e-3 * path.figures.volume, "{name}");
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
        // A second plan is the same, whatever ran beside it.
        assert_eq!(path, plan(&job, &map(name)).0);
        // Mirrored maps are covered as well.
        let mirrored = Grid { values: map(name).values.into_iter().rev().collect(), ..map(name) };
        assert!(plan(&job, &mirrored).0.figures.coverage >= 0.997);
    }
}

/// 45 islands on a lattice: each is a part, none is joined to another.
#[test]
fn islands_stay_apart() {
    let lattice = grid(|x, y| {
        let near = |t: f64| t - (t / 0.024).round() * 0.024;
        let inside = x.hypot(y) < 0.092 && near(x).hypot(near(y)) < 0.0085;
        if inside { 100e-9 } else { -20e-9 }
    });
    let job = job();
    let (path, _) = plan(&job, &lattice);
    check(&job, &path);
    // Lattice points (i, j) * 24 mm whose disc of 8.5 mm reaches into the circle of 90 mm, counted by hand: i² + j² <= 14 (the
    // disc's inner side at 24 sqrt(i² + j²) - 8.5 < 90, so that i² + j² < 16.8; at 16, (±4, 0) and (0, ±4), the disc begins at 87.5).
    let points = (-4..=4).flat_map(|i: i32| (-4..=4).map(move |j: i32| i * i + j * j)).filter(|r| *r < 16).count();
    assert_eq!(points, 45);
    assert_eq!(path.figures.parts, 45 + 4);
    assert!(path.runs.len() >= 49);
    assert!(path.figures.coverage > 0.99);
    // Every run stays on one island.
    let island = |p: &Place| [(p[0] / 0.024).round() as i32, (p[1] / 0.024).round() as i32];
    for run in &path.runs {
        assert!(run.iter().all(|p| island(p) == island(&run[0])));
    }
}

/// A ring with low ground in its middle: the path goes round and never across.
#[test]
fn a_ring_is_polished_as_a_ring() {
    let ring = grid(|x, y| if (0.045..0.075).contains(&x.hypot(y)) { 80e-9 } else { 0.0 });
    let job = job();
    let (path, _) = plan(&job, &ring);
    check(&job, &path);
    assert_eq!(path.figures.parts, 1);
    assert!(path.figures.coverage > 0.999);
    // Of a hexagon half may lie beyond the ring, and smoothing draws a round path in by less than a tenth of one.
    for [x, y] in path.runs.iter().flatten() {
        assert!((0.0435..0.0765).contains(&x.hypot(*y)), "{x} {y}");
    }
    // The area: pi (75² - 45²) mm² within a rim of half a pixel on both circles.
    let area = std::f64::consts::PI * (0.075f64.powi(2) - 0.045f64.powi(2));
    assert!((path.figures.area / area - 1.0).abs() < 0.01);
}

#[test]
fn salt_and_pepper_is_planned_and_accounted_for() {
    // Pixels high or low by a hash of their place: a thousand islands and holes.
    let noise = grid(|x, y| {
        let (i, j) = ((x * 1e3).floor() as i64 / 3, (y * 1e3).floor() as i64 / 3);
        let hash = (i.wrapping_mul(73_856_093) ^ j.wrapping_mul(19_349_663)).wrapping_mul(2_654_435_761) >> 13;
        if hash & 3 == 0 { 60e-9 } else { -20e-9 }
    });
    let job = job();
    let (path, warnings) = plan(&job, &noise);
    check(&job, &path);
    let figures = path.figures;
    assert!(figures.parts > 100 && figures.dropped_cells > 0);
    assert!(figures.coverage > 0.9 && figures.lost_volume > 0.0 && figures.lost_volume < 0.1 * figures.volume);
    assert_eq!(warnings.iter().any(|w| w.code == codes::W0641), figures.lost_volume > 0.01 * figures.volume);
}

#[test]
fn nothing_too_high_is_an_empty_plan() {
    let good = grid(|x, y| 1e-9 * (x * 100.0).sin() * (y * 100.0).cos());
    let (path, warnings) = plan(&job(), &good);
    assert!(path.runs.is_empty() && path.region.count == 0);
    assert_eq!((path.figures.coverage, path.figures.lost_volume), (1.0, 0.0));
    assert!(warnings.is_empty(), "{warnings:?}");
    // One speck of a pixel: dropped as an island, and said.
    let mut speck = good;
    speck.values[100 * SIDE + 100] = 80e-9;
    let (path, warnings) =
        plan(&RegionAdaptive { lift: JobLift::fixed(FixedLift { height: Length(0.0) }), ..job() }, &speck);
    assert!(path.runs.is_empty() && path.region.count == 1);
    assert_eq!(path.figures.lost_volume, path.figures.volume);
    assert_eq!(warnings.iter().map(|w| w.code).collect::<Vec<_>>(), [codes::W0641]);
}

#[test]
fn unknown_pixels_are_never_polished() {
    let half = grid(|x, _| if x < 0.0 { f64::NAN } else { 50e-9 * (x * 40.0).sin() });
    let (path, _) = plan(&job(), &half);
    assert!(!path.runs.is_empty());
    assert!(path.runs.iter().flatten().all(|[x, _]| *x > -1e-3));
    let problem = refused(&job(), &grid(|_, _| f64::NAN));
    assert_eq!(problem.code, codes::E0683);
}

/// Every refusal names a value, and that value passes.
#[test]
fn refusals_say_what_would_pass() {
    let c = map('C');
    let says = |problem: &Problem, text: &str| {
        let help = problem.help.clone().unwrap_or_default();
        assert!(help.contains(text), "{}: {help}", problem.code);
    };
    let diagonal = |mm: f64| HexagonalMesh { diagonal: Length(mm * 1e-3), ..job().mesh };

    let large = RegionAdaptive { mesh: diagonal(8.0), ..job() };
    let problem = refused(&large, &c);
    assert_eq!(problem.code, codes::E0680);
    says(&problem, "diagonal: 6.25 mm");
    plan(&RegionAdaptive { mesh: diagonal(6.25), ..job() }, &c);

    let small = RegionAdaptive { mesh: diagonal(1.99), point_step: Length(0.001), ..job() };
    let problem = refused(&small, &c);
    assert_eq!(problem.code, codes::E0681);
    says(&problem, "diagonal: 2 mm");
    plan(&RegionAdaptive { mesh: diagonal(2.0), ..job() }, &c);

    let wide = RegionAdaptive { point_step: Length(0.0026), ..job() };
    let problem = refused(&wide, &c);
    assert_eq!(problem.code, codes::E0682);
    says(&problem, "point_step: 2.5 mm");
    plan(&RegionAdaptive { point_step: Length(0.0025), ..job() }, &c);

    // A disc of seven hexagons, and a window of eleven nodes to each side.
    let dot = grid(|x, y| if x.hypot(y) < 0.003 { 60e-9 } else { 0.0 });
    let smoothed =
        |smoothing: f64| RegionAdaptive { smoothing, lift: JobLift::fixed(FixedLift { height: Length(0.0) }), ..job() };
    let problem = refused(&smoothed(4.0), &dot);
    assert_eq!(problem.code, codes::E0684);
    says(&problem, "smoothing: 2.66");
    plan(&smoothed(2.66), &dot);

    let strict = RegionAdaptive { turn_limit: Angle(20f64.to_radians()), ..job() };
    let problem = refused(&strict, &c);
    assert_eq!(problem.code, codes::E0685);
    // Two sides of 60 degrees, smoothed with 0.0545 0.2442 0.4026: the corner keeps 26.2 degrees (by hand).
    says(&problem, "turn_limit: 27 deg");
    let passing = RegionAdaptive { turn_limit: Angle(27f64.to_radians()), ..job() };
    check(&passing, &plan(&passing, &map('A')).0);

    // Round a hole of 12 mm smoothing over 8 nodes cuts across.
    let ring = Annulus { outer_diameter: Length(0.18), inner_diameter: Length(0.012), centre: None };
    let all = grid(|x, _| 40e-9 + 1e-9 * x);
    let across = |smoothing: f64| RegionAdaptive {
        over: Aperture::annulus(ring.clone()),
        lift: JobLift::fixed(FixedLift { height: Length(50e-9) }),
        smoothing,
        ..job()
    };
    let problem = refused(&across(8.0), &all);
    assert_eq!(problem.code, codes::E0686, "{}", problem.message);
    plan(&across(1.0), &all);

    let far =
        Aperture::circle(Circle { diameter: Length(0.01), centre: Some(JobPlace { x: Length(0.3), y: Length(0.0) }) });
    assert_eq!(refused(&RegionAdaptive { over: far, ..job() }, &c).code, codes::E0683);

    let fine = RegionAdaptive { mesh: diagonal(2.0), point_step: Length(1e-6), ..job() };
    assert_eq!(refused(&fine, &c).code, codes::E0641);
    let nothing = RegionAdaptive { point_step: Length(0.0), ..job() };
    assert_eq!(refused(&nothing, &c).code, codes::E0640);
}

#[test]
fn a_jump_inside_a_run_is_refused() {
    let run = vec![[0.0, 0.0], [2e-3, 0.0], [9e-3, 0.0]];
    let problem = region::checks::jumps(std::slice::from_ref(&run), 2.5e-3).expect_err("a jump of 7 mm");
    assert_eq!(problem.code.as_str(), "E0687");
    assert!(problem.message.contains("7.000 mm"), "{}", problem.message);
    assert!(region::checks::jumps(&[run[..2].to_vec(), run[2..].to_vec()], 2.5e-3).is_ok());
}

#[test]
fn odd_lifts_are_warned_of() {
    // Seven bumps on good ground: three times the RMS is more than the ground lies low.
    let bumps = grid(|x, y| {
        let d2 = |k: i32| (x - 0.01 * f64::from(k) * 2.0).powi(2) + (y - 0.005 * f64::from(k)).powi(2);
        (-3..=3).map(|k| 200e-9 * (-d2(k) / (2.0 * 0.003f64.powi(2))).exp()).sum::<f64>()
    });
    let rms3 = RegionAdaptive { lift: JobLift::rms3(Empty {}), ..job() };
    let (path, warnings) = plan(&rms3, &bumps);
    assert!(path.figures.area_share > 0.99);
    assert_eq!(warnings.iter().map(|w| w.code).collect::<Vec<_>>(), [codes::W0642]);
    let (path, warnings) = plan(&job(), &bumps);
    assert!(path.figures.area_share < 0.3 && warnings.is_empty());
    // A good part with one peak: the lift is negative.
    let peak = grid(|x, y| if x.hypot(y) < 0.004 { 60e-9 } else { 0.0 });
    let (path, warnings) = plan(&rms3, &peak);
    assert!(path.figures.lift < 0.0 && path.region.count > 0);
    assert!(warnings.iter().any(|w| w.code == codes::W0643));
}

// ---- A whole job.

fn compile(sets: &[(&str, &str)]) -> Compilation {
    let mut request = Request::new("examples/region_200/region_200.polish");
    request.sets = sets.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
    session::compile(&TestFiles::default(), &request, &Unwatched)
}

/// A good part ends a campaign: success, said, and no program.
#[test]
fn a_job_with_nothing_to_polish_succeeds_without_a_program() {
    let mut done = compile(&[("tolerance", "100 nm")]);
    assert!(!done.failed());
    let planned = &done.jobs[0];
    assert!(planned.program.is_none() && planned.dwell.is_none() && planned.motion.is_none());
    let result = planned.result.as_ref().expect("a result");
    assert!(result.nothing_to_polish.as_ref().is_some_and(|why| why.starts_with("no place stands too high")));
    assert!(result.programs.is_empty() && result.dwell.is_none());
    assert_eq!(result.path.points, 0);
    // maps.json: 10.3135 nm RMS stay as they are.
    assert!((result.predicted.rms_nm - 10.3135).abs() < 1e-3 && result.predicted.removal_mean_nm == 0.0);
    // The requirement on the RMS is not met, which is warned of; what only a run has is pending.
    let met: Vec<Met> = result.requirements.iter().map(|found| found.met).collect();
    assert_eq!(met, [Met::Yes, Met::No, Met::Pending, Met::Pending]);
    assert_eq!(done.diagnostics.iter().map(|d| d.code.as_str()).collect::<Vec<_>>(), ["W0640"]);
    // No program does what this job asks.
    session::verify(&mut done, &Program::default());
    assert!(done.failed() && done.diagnostics.iter().any(|d| d.code.as_str() == "E0688"));
}

/// The example: lands and lifts at both ends of every line, stays on the part, and says what it leaves out.
#[test]
fn the_example_runs_only_where_the_error_is_high() {
    let done = compile(&[]);
    let said: Vec<&str> = done.diagnostics.iter().map(|d| d.message.as_str()).collect();
    assert!(!done.failed(), "{said:?}");
    let planned = &done.jobs[0];
    let result = planned.result.as_ref().expect("a result");
    let region = result.path.region.as_ref().expect("a region");
    assert!((region.lift_nm - 15.1206).abs() < 1e-3, "{}", region.lift_nm);
    assert!(region.coverage >= 0.995 && region.area_share < 0.5);
    let dwell = result.dwell.as_ref().expect("a dwell");
    let landings = dwell.landings.as_ref().expect("landings");
    assert_eq!(landings.count, 2 * result.path.lines);
    assert!(result.predicted.rms_nm < 0.5 * result.predicted.rms_before_nm);
    assert!(planned.program.is_some());
}

/// As people call it: exit status 0, a sentence, and `result.json` alone; a program of the cycle before is taken away.
#[test]
#[allow(clippy::disallowed_methods, reason = "the test runs the tool and reads what it wrote")]
fn the_tool_says_that_there_is_nothing_to_polish() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("region_nothing");
    std::fs::remove_dir_all(&folder).ok();
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("Region200.mod"), "an earlier program").expect("a file");
    let earlier = r#"{"polishc":"0","jobs":[{"for":"polish","programs":[{"file":"Region200.mod"}]}]}"#;
    std::fs::write(folder.join("result.json"), earlier).expect("a file");
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_polishc"))
        .args(["build", "examples/region_200/region_200.polish", "--set", "tolerance=100nm", "-o"])
        .arg(&folder)
        .output()
        .expect("the tool runs");
    let said = String::from_utf8_lossy(&run.stdout);
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    assert!(said.contains("nothing to polish: no place stands too high"), "{said}");
    let names: Vec<String> = std::fs::read_dir(&folder)
        .expect("the folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(names, ["result.json"]);
    let text = std::fs::read_to_string(folder.join("result.json")).expect("result.json");
    let result: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert!(result["jobs"][0]["nothing_to_polish"].is_string());
    assert_eq!(result["jobs"][0]["programs"], serde_json::json!([]));
}
