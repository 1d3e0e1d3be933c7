//! Real files of instruments, with the figures of the list that came with them.

use crate::files::facts;
use polishc::height_map::{RawMap, read};
use polishc::metrology::{Inspection, inspect};
use std::path::PathBuf;

/// The sample of that name, or a line that says it is not there.
pub fn sample(name: &str) -> Option<Vec<u8>> {
    let folder = std::env::var_os("POLISHC_SAMPLES").map_or_else(|| PathBuf::from("../shared/samples"), PathBuf::from);
    let path = folder.join(name);
    let bytes = std::fs::read(&path).ok();
    if bytes.is_none() {
        println!("SKIPPED: there is no sample {} (POLISHC_SAMPLES names the folder)", path.display());
    }
    bytes
}

/// Place of the greatest and of the least height, row and column.
fn extremes(map: &RawMap) -> [(usize, usize); 2] {
    let place = |i: usize| (i / map.columns, i % map.columns);
    let valid = || map.values.iter().enumerate().filter(|(_, v)| !v.is_nan());
    let highest = valid().max_by(|a, b| a.1.total_cmp(b.1)).unwrap().0;
    let lowest = valid().min_by(|a, b| a.1.total_cmp(b.1)).unwrap().0;
    [place(highest), place(lowest)]
}

/// PV and RMS about the mean in micrometres, to seven digits after the point, as the list gives them.
fn figures_um(map: &RawMap) -> (f64, f64) {
    let valid: Vec<f64> = map.values.iter().copied().filter(|v| !v.is_nan()).collect();
    let mean = valid.iter().sum::<f64>() / valid.len() as f64;
    let rms = (valid.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / valid.len() as f64).sqrt();
    let [low, high] = [f64::min, f64::max].map(|of: fn(f64, f64) -> f64| valid.iter().copied().reduce(of).unwrap());
    let rounded = |metres: f64| (metres * 1e13).round() / 1e7;
    (rounded(high - low), rounded(rms))
}

#[test]
fn a_file_from_a_real_interferometer() {
    // "Detilted" by NumPy's lstsq over the valid pixels.
    let Some(bytes) = sample("zygo_metropro.dat") else { return };
    let found = facts(inspect(&bytes, "zygo_metropro.dat", None, None).unwrap());
    assert_eq!((found.kind, found.format), ("height_map", "metropro"));
    assert_eq!((found.rows, found.columns, found.valid, found.invalid), (432, 425, 136_359, 47_241));
    assert_eq!(found.pixel_mm, [0.117_924, 0.117_924]);
    assert_eq!((found.wavelength_nm, found.pv_nm, found.rms_nm), (Some(632.8), 330.700, 44.591));
    assert_eq!((found.pv_detilted_nm, found.rms_detilted_nm), (Some(330.700), Some(44.591)));
    // By NumPy.
    assert_eq!(extremes(&read(&bytes, "zygo_metropro.dat").unwrap()), [(401, 268), (146, 387)]);
}

#[test]
fn a_datx_in_fringes() {
    let Some(bytes) = sample("zygo_mx.datx") else { return };
    let found = facts(inspect(&bytes, "zygo_mx.datx", None, None).unwrap());
    assert_eq!((found.kind, found.format), ("height_map", "datx"));
    assert_eq!((found.rows, found.columns, found.valid, found.invalid), (259, 33, 7_771, 8_547 - 7_771));
    assert_eq!(found.pixel_mm, [1.0, 1.0]);
    assert_eq!((found.wavelength_nm, found.pv_nm, found.rms_nm), (Some(632.8), 453.030, 80.818));
    // By h5py and NumPy.
    assert_eq!(extremes(&read(&bytes, "zygo_mx.datx").unwrap()), [(258, 32), (217, 5)]);
}

#[test]
fn an_x3p_with_oblong_pixels() {
    let Some(bytes) = sample("areal.x3p") else { return };
    let found = facts(inspect(&bytes, "areal.x3p", None, None).unwrap());
    assert_eq!((found.kind, found.format), ("height_map", "x3p"));
    assert_eq!((found.rows, found.columns, found.valid, found.invalid), (650, 650, 650 * 650, 0));
    // 0.12765651 um and 0.314582114 um, to the six digits that inspect shows.
    assert_eq!(found.pixel_mm, [0.000_127_657, 0.000_314_582]);
    let map = read(&bytes, "areal.x3p").unwrap();
    assert_eq!(map.pixel, Some([1.276_565_098_373_46e-7, 3.145_821_135_277_46e-7]));
    assert_eq!((found.pv_nm, found.rms_nm), (554.336, 77.28));
    let (pv, rms) = figures_um(&map);
    assert_eq!(((pv * 1e6).round() / 1e6, rms), (0.554_336, 0.077_280_3));
    // By zipfile and NumPy.
    assert_eq!(extremes(&map), [(179, 8), (168, 194)]);
}

#[test]
fn an_sdf_of_the_standard() {
    let Some(bytes) = sample("ascii.sdf") else { return };
    let found = facts(inspect(&bytes, "ascii.sdf", None, None).unwrap());
    assert_eq!((found.kind, found.format), ("height_map", "sdf"));
    assert_eq!((found.columns, found.rows, found.valid), (7, 4, 28));
    assert_eq!(found.pixel_mm, [0.001, 0.001]);
    assert_eq!(figures_um(&read(&bytes, "ascii.sdf").unwrap()), (0.050_93, 0.013_602_9));
}

#[test]
fn texts_of_a_collection() {
    // Two columns are a profile; the unit of the heights stands in the header of the second and third only.
    if let Some(bytes) = sample("csv-1.csv") {
        assert_eq!(inspect(&bytes, "csv-1.csv", None, None).unwrap_err().code.as_str(), "E0506");
        let Inspection::Profile(found) = inspect(&bytes, "csv-1.csv", Some(1e-6), None).unwrap() else {
            panic!("a profile")
        };
        // 0.0386 .. 0.3089 um, 1.94981 .. 2.10425 um.
        assert_eq!((found.kind, found.valid, found.length_mm, found.pv_nm), ("profile", 8, 0.000_270_3, 154.44));
        assert_eq!(read(&bytes, "csv-1.csv").unwrap_err().code.as_str(), "E0519");
    }
    for name in ["csv-2.csv", "csv-3.csv"] {
        let Some(bytes) = sample(name) else { continue };
        let Inspection::Profile(found) = inspect(&bytes, name, None, None).unwrap() else { panic!("a profile") };
        // UTF-16; -99.95833 .. -99.375 um; all heights are the same.
        assert_eq!(
            (found.format, found.valid, found.length_mm, found.pv_nm),
            ("table", 8, 0.000_583_333, 0.0),
            "{name}"
        );
        assert_eq!(inspect(&bytes, name, Some(1e-6), None).unwrap_err().code.as_str(), "E0507", "{name}");
    }
    // 4 x 4 points without a word: the job must say both.
    if let Some(bytes) = sample("xyz-1.txt") {
        assert_eq!(inspect(&bytes, "xyz-1.txt", None, Some(1e-3)).unwrap_err().field.as_deref(), Some("unit"));
        assert_eq!(inspect(&bytes, "xyz-1.txt", Some(1e-9), None).unwrap_err().field.as_deref(), Some("pixel"));
        let found = facts(inspect(&bytes, "xyz-1.txt", Some(1e-9), Some(0.5e-3)).unwrap());
        assert_eq!((found.format, found.columns, found.rows, found.valid), ("table", 4, 4, 16));
        assert_eq!((found.pixel_mm, found.pv_nm), ([0.5, 0.5], 1.0));
        // Height 2 at (1, 1) and (1, 2); y grows upwards, so these are rows 2 and 1.
        let map = read(&bytes, "xyz-1.txt").unwrap();
        let twos: Vec<usize> = (0..16).filter(|i| map.values[*i] == 2.0).collect();
        assert_eq!(twos, [5, 9]);
    }
}

#[test]
fn an_array_of_a_published_problem() {
    let Some(bytes) = sample("dwell_a_height_m.npy") else { return };
    let found = facts(inspect(&bytes, "dwell_a_height_m.npy", Some(1.0), Some(0.361515e-3)).unwrap());
    assert_eq!((found.format, found.rows, found.columns), ("npy", 81, 580));
    assert_eq!(found.pixel_mm, [0.361_515, 0.361_515]);
}
