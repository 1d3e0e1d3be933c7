//! The reference maps (200 x 200 pixels of 1 mm, nanometres, rows towards +y, the part's centre in the middle), and the
//! hexagonal path over the whole of their aperture.

use polishc::height_map::npy;
use polishc::path::region::mesh::{Cells, Hexagon, Mesh};
use polishc::path::region::smooth::{self, Ends, Place};
use polishc::path::region::{fill, select};

pub const SIDE: usize = 200;
/// Radius of the aperture that the references speak of, mm.
pub const REACH: f64 = 90.0;
/// A fortieth of 632.8 nm, nm.
pub const TOLERANCE: f64 = 632.8 / 40.0;
/// Corner to corner, mm.
pub const MESH: Mesh = Mesh { diagonal: 2.5, centre: [0.0; 2] };

/// Heights of a reference map in nanometres, as the file has them.
#[allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]
pub fn heights(map: char) -> Vec<f64> {
    let path = match map {
        'A' => "tests/maps/map_a.npy",
        'B' => "examples/sphere_200/map_b.npy",
        'C' => "examples/region_200/map_c.npy",
        _ => panic!("no map {map}"),
    };
    let bytes = std::fs::read(path).expect("the map");
    let raw = npy::read(&bytes, path).expect("a map");
    assert_eq!((raw.columns, raw.rows), (SIDE, SIDE));
    raw.heights(Some(1e-9)).expect("heights").into_iter().map(|metres| metres * 1e9).collect()
}

/// Centre of a pixel, mm.
pub fn pixel(i: usize) -> Place {
    [(i % SIDE) as f64 + 0.5 - 100.0, (i / SIDE) as f64 + 0.5 - 100.0]
}

/// Pixels within reach.
pub fn reach() -> Vec<bool> {
    (0..SIDE * SIDE).map(|i| pixel(i)[0].hypot(pixel(i)[1]) < REACH).collect()
}

/// Hexagons within reach. Six centres lie on the circle itself, and which of them count is decided by how their places are
/// rounded. The reference reckoned in millimetres with these formulas; so four count.
pub fn cells_in_reach() -> Cells {
    Cells::of(MESH.sheet([-REACH; 2], [REACH; 2]), |hexagon| {
        let [x, y] = MESH.place(hexagon);
        x.hypot(y) < REACH
    })
}

/// Hexagons whose centre lies in a chosen pixel.
pub fn cells_in(region: &select::Region) -> Cells {
    let reach = cells_in_reach();
    Cells::of(reach.sheet(), |hexagon| {
        let [x, y] = MESH.place(hexagon).map(|t| (t + 100.0).floor() as usize);
        reach.contains(hexagon) && region.pixels[y * SIDE + x]
    })
}

/// The path `full` of the solver references: every hexagon within reach, smoothed over one node, points 2 mm apart. In
/// millimetres.
pub fn full_path() -> Vec<Place> {
    let cells = cells_in_reach();
    let list: Vec<Hexagon> = cells.iter().collect();
    let paths = fill::fill(&list, &mut cells.clone());
    assert_eq!(paths.len(), 1);
    let nodes: Vec<Place> = paths[0].iter().map(|hexagon| MESH.place(*hexagon)).collect();
    let weights = smooth::weights(1.0, smooth::half_window(1.0));
    smooth::resample(&smooth::smooth(&nodes, &weights, Ends::Reflected), 2.0)
}
