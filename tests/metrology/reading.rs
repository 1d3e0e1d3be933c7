//! MetroPro and NumPy by hand, what of them is refused, and what scales a job may state.

use crate::files::facts;
use polishc::diagnostics::Problem;
use polishc::height_map::{Format, Grid, metropro, npy, read};
use polishc::job::ZernikeOrder;
use polishc::metrology;
use proptest::prelude::*;

/// A MetroPro header made by hand from the table of the reference guide, all other bytes zero, with 2 x 2 heights.
fn by_hand(format: u16, phase_resolution: u16, counts: [i32; 4]) -> Vec<u8> {
    let (magic, size): (u32, usize) =
        [(0x881B_036F, 834), (0x881B_0370, 834), (0x881B_0371, 4096)][usize::from(format) - 1];
    let mut bytes = vec![0; size];
    put(&mut bytes, 0, &magic.to_be_bytes());
    put(&mut bytes, 4, &format.to_be_bytes());
    put(&mut bytes, 6, &(size as u32).to_be_bytes());
    put(&mut bytes, 68, &2_i16.to_be_bytes());
    put(&mut bytes, 70, &2_i16.to_be_bytes());
    put(&mut bytes, 72, &16_i32.to_be_bytes());
    put(&mut bytes, 164, &0.5_f32.to_be_bytes());
    put(&mut bytes, 168, &632.8e-9_f32.to_be_bytes());
    put(&mut bytes, 176, &1.0_f32.to_be_bytes());
    put(&mut bytes, 184, &0.25e-3_f32.to_be_bytes());
    put(&mut bytes, 218, &phase_resolution.to_be_bytes());
    for count in counts {
        bytes.extend_from_slice(&count.to_be_bytes());
    }
    bytes
}

fn put(bytes: &mut [u8], at: usize, field: &[u8]) {
    bytes[at..at + field.len()].copy_from_slice(field);
}

fn refused(bytes: &[u8]) -> Problem {
    read(bytes, "map.dat").expect_err("a refusal")
}

#[test]
fn the_three_formats_and_all_resolutions_give_half_a_wave_a_fringe() {
    // One fringe is R counts; with scale factor 0.5 it is half a wave of the surface.
    for (format, phase_resolution, counts_a_fringe) in [
        (1, 0, 4096),
        (1, 1, 32768),
        (2, 0, 4096),
        (2, 1, 32768),
        (2, 2, 131_072),
        (3, 0, 4096),
        (3, 1, 32768),
        (3, 2, 131_072),
    ] {
        let bytes = by_hand(format, phase_resolution, [counts_a_fringe, 0, -2 * counts_a_fringe, 2_147_483_640]);
        let map = read(&bytes, "map.dat").unwrap();
        assert_eq!((map.format, map.columns, map.rows, map.in_metres), (Format::MetroPro, 2, 2, true));
        let expected = [316.4e-9, 0.0, -632.8e-9];
        for (found, expected) in map.values.iter().zip(expected) {
            // The wavelength is stored in single precision: 6 parts in 10^8.
            assert!((found - expected).abs() <= 1e-7 * 632.8e-9, "format {format}: {found} {expected}");
        }
        assert!(map.values[3].is_nan());
        let pixel = map.pixel.unwrap();
        assert!((pixel[0] - 0.25e-3).abs() < 1e-10 && pixel[0] == pixel[1]);
    }
}

#[test]
fn intensity_frames_are_stepped_over() {
    let plain = by_hand(1, 1, [7, 8, 9, 10]);
    let mut bytes = plain[..834].to_vec();
    put(&mut bytes, 52, &3_i16.to_be_bytes());
    put(&mut bytes, 54, &2_i16.to_be_bytes());
    put(&mut bytes, 56, &2_i16.to_be_bytes());
    put(&mut bytes, 60, &24_i32.to_be_bytes());
    bytes.extend_from_slice(&[0xAB; 24]);
    bytes.extend_from_slice(&plain[834..]);
    let with = read(&bytes, "map.dat").unwrap();
    assert_eq!(with, read(&plain, "map.dat").unwrap());
}

#[test]
fn a_lateral_resolution_of_zero_means_that_the_job_must_say_the_pixel() {
    let mut bytes = by_hand(2, 1, [1, 2, 3, 4]);
    put(&mut bytes, 184, &0_f32.to_be_bytes());
    let map = read(&bytes, "map.dat").unwrap();
    assert_eq!(map.pixel, None);
    assert_eq!(map.pixel_pitch(None).unwrap_err().code.as_str(), "E0506");
    assert_eq!(map.pixel_pitch(Some(0.3e-3)).unwrap(), [0.3e-3; 2]);
    assert_eq!(map.pixel_pitch(Some(0.0)).unwrap_err().code.as_str(), "E0507");
}

#[test]
fn a_stated_pixel_must_agree_with_the_file() {
    let map = read(&by_hand(1, 1, [1, 2, 3, 4]), "map.dat").unwrap();
    assert!(map.pixel_pitch(Some(0.2501e-3)).is_ok(), "0.04 % off is the same pixel");
    let problem = map.pixel_pitch(Some(0.26e-3)).unwrap_err();
    assert_eq!(problem.code.as_str(), "E0507");
    assert_eq!(
        problem.message,
        "the map's file says that a pixel has 0.250000 mm x 0.250000 mm, but 0.260000 mm is stated"
    );
}

#[test]
fn a_unit_belongs_to_files_without_one() {
    let metropro = read(&by_hand(1, 1, [1, 2, 3, 4]), "map.dat").unwrap();
    assert_eq!(metropro.heights(Some(1e-9)).unwrap_err().code.as_str(), "E0507");
    let array = read(&npy::write(2, &[1.0, f64::NAN, -3.0, 4.0]).unwrap(), "map.npy").unwrap();
    assert_eq!(array.heights(None).unwrap_err().code.as_str(), "E0506");
    assert_eq!(array.heights(Some(-1e-9)).unwrap_err().code.as_str(), "E0507");
    let heights = array.heights(Some(1e-9)).unwrap();
    assert!((heights[0] - 1e-9).abs() < 1e-24 && heights[1].is_nan() && (heights[2] + 3e-9).abs() < 1e-24);
    // 4 m is no form error.
    assert_eq!(array.heights(Some(1.0)).unwrap_err().code.as_str(), "E0511");
    let infinite = read(&npy::write(2, &[1.0, f64::INFINITY]).unwrap(), "map.npy").unwrap();
    assert_eq!(infinite.heights(Some(1e-9)).unwrap_err().code.as_str(), "E0511");
    let nothing = read(&npy::write(2, &[f64::NAN; 4]).unwrap(), "map.npy").unwrap();
    assert_eq!(nothing.heights(Some(1e-9)).unwrap_err().code.as_str(), "E0508");
}

#[test]
fn every_truncation_is_refused() {
    for format in 1..=3 {
        let bytes = by_hand(format, 1, [1, 2, 3, 4]);
        for length in 0..bytes.len() {
            let problem = refused(&bytes[..length]);
            assert!(!problem.message.is_empty() && problem.field.as_deref() == Some("file"), "{length} bytes");
        }
    }
    let array = npy::write(3, &[1.0; 12]).unwrap();
    for length in 0..array.len() {
        refused(&array[..length]);
    }
    assert_eq!(refused(b"").message, "`map.dat` is empty");
    let cut = &by_hand(1, 1, [1, 2, 3, 4])[..840];
    assert_eq!(refused(cut).message, "`map.dat` is cut short: it has 840 bytes and should have 850");
}

#[test]
fn lying_headers_are_refused_by_name() {
    let changed = |at: usize, field: &[u8]| {
        let mut bytes = by_hand(1, 1, [1, 2, 3, 4]);
        put(&mut bytes, at, field);
        let problem = refused(&bytes);
        (problem.code.as_str(), problem.message)
    };
    let cases: Vec<(&str, &str, (&str, String))> = vec![
        ("E0504", "says format 2", changed(4, &2_u16.to_be_bytes())),
        ("E0504", "and 835 bytes", changed(6, &835_u32.to_be_bytes())),
        ("E0504", "-2 columns", changed(68, &(-2_i16).to_be_bytes())),
        ("E0504", "0 rows", changed(70, &0_i16.to_be_bytes())),
        ("E0503", "3 x 2 heights take 16 bytes; they take 24", changed(68, &3_i16.to_be_bytes())),
        ("E0503", "heights take 2147483647 bytes", changed(72, &i32::MAX.to_be_bytes())),
        ("E0503", "intensities take 4 bytes", changed(60, &4_i32.to_be_bytes())),
        ("E0504", "wavelength is NaN nm", changed(168, &f32::NAN.to_be_bytes())),
        ("E0504", "wavelength is 0 nm", changed(168, &0_f32.to_be_bytes())),
        ("E0504", "wavelength is 6327999", changed(168, &632.8_f32.to_be_bytes())),
        ("E0504", "scale factor is inf", changed(164, &f32::INFINITY.to_be_bytes())),
        ("E0504", "obliquity factor is 0", changed(176, &0_f32.to_be_bytes())),
        ("E0504", "pixel is -1000 mm", changed(184, &(-1_f32).to_be_bytes())),
        ("E0504", "pixel is NaN mm", changed(184, &f32::NAN.to_be_bytes())),
        ("E0504", "phase resolution is 2; format 1 knows 0 to 1", changed(218, &2_i16.to_be_bytes())),
        ("E0504", "phase resolution is -1", changed(218, &(-1_i16).to_be_bytes())),
        ("E0502", "no height map of a known format", changed(0, &[0])),
    ];
    for (code, words, (found_code, message)) in cases {
        assert_eq!(code, found_code, "{message}");
        assert!(message.contains(words), "{message}");
    }
    let mut long = by_hand(3, 1, [1, 2, 3, 4]);
    long.push(0);
    assert_eq!(
        refused(&long).message,
        "`map.dat` is longer than its header says: it has 4113 bytes and should have 4112"
    );
    // 32767 x 32767 heights: refused before four gigabytes are asked for.
    let mut huge = by_hand(1, 1, [1, 2, 3, 4]);
    put(&mut huge, 68, &i16::MAX.to_be_bytes());
    put(&mut huge, 70, &i16::MAX.to_be_bytes());
    assert_eq!(refused(&huge).code.as_str(), "E0501");
}

#[test]
fn the_writer_keeps_heights_within_half_a_count() {
    let heights = [0.0, 1e-9, -250e-9, f64::NAN, 10e-6, -3.3e-9];
    for (header_format, phase_resolution, counts) in [(1, 0, 4096.0), (2, 2, 131_072.0), (3, 1, 32768.0)] {
        let settings = metropro::Settings { header_format, phase_resolution, ..metropro::Settings::fizeau(0.5e-3) };
        let map = read(&metropro::write(3, &heights, &settings).unwrap(), "map.dat").unwrap();
        let half_a_count = 632.8e-9 * 0.5 / counts / 2.0;
        for (found, expected) in map.values.iter().zip(heights) {
            assert!(found.is_nan() == expected.is_nan());
            assert!(expected.is_nan() || (found - expected).abs() <= 1.000_001 * half_a_count);
        }
    }
    let fizeau = metropro::Settings::fizeau(0.5e-3);
    assert_eq!(metropro::write(4, &heights, &fizeau), None, "six heights are no rows of four");
    assert_eq!(metropro::write(3, &[1.0, 0.0, 0.0], &fizeau), None, "one metre does not fit 32 bits");
    assert_eq!(
        metropro::write(3, &heights, &metropro::Settings { header_format: 1, phase_resolution: 2, ..fizeau }),
        None
    );
}

/// An array file from its parts, version 1.
fn array(descr: &str, fortran: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    array_with(&format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}"), 1, data)
}

fn array_with(header: &str, version: u8, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY".to_vec();
    bytes.extend_from_slice(&[version, 0]);
    if version == 1 {
        bytes.extend_from_slice(&(header.len() as u16 + 1).to_le_bytes());
    } else {
        bytes.extend_from_slice(&(header.len() as u32 + 1).to_le_bytes());
    }
    bytes.extend_from_slice(header.as_bytes());
    bytes.push(b'\n');
    bytes.extend_from_slice(data);
    bytes
}

fn bytes_of<const N: usize, const M: usize>(numbers: [[u8; N]; M]) -> Vec<u8> {
    numbers.concat()
}

#[test]
fn arrays_of_every_real_type_and_order_read_the_same() {
    // Rows 1 2 3 and -4 5 6 (unsigned: 4 instead of -4).
    let signed = [1.0, 2.0, 3.0, -4.0, 5.0, 6.0];
    let cases: Vec<(&str, Vec<u8>)> = vec![
        ("<f8", bytes_of(signed.map(f64::to_le_bytes))),
        (">f8", bytes_of(signed.map(f64::to_be_bytes))),
        ("<f4", bytes_of(signed.map(|v| (v as f32).to_le_bytes()))),
        (">f4", bytes_of(signed.map(|v| (v as f32).to_be_bytes()))),
        ("<i8", bytes_of(signed.map(|v| (v as i64).to_le_bytes()))),
        (">i8", bytes_of(signed.map(|v| (v as i64).to_be_bytes()))),
        ("<i4", bytes_of(signed.map(|v| (v as i32).to_le_bytes()))),
        (">i2", bytes_of(signed.map(|v| (v as i16).to_be_bytes()))),
        ("|i1", bytes_of(signed.map(|v| (v as i8).to_le_bytes()))),
    ];
    for (descr, data) in cases {
        let map = read(&array(descr, "False", "(2, 3)", &data), "a.npy").unwrap();
        assert_eq!((map.rows, map.columns, &map.values[..]), (2, 3, &signed[..]), "{descr}");
    }
    let unsigned = [1.0, 2.0, 3.0, 4.0, 5.0, 60000.0];
    let map = read(&array("<u2", "False", "(2, 3)", &bytes_of(unsigned.map(|v| (v as u16).to_le_bytes()))), "a.npy");
    assert_eq!(map.unwrap().values, unsigned);
    // Fortran order: columns one after the other.
    let columns = [1.0, -4.0, 2.0, 5.0, 3.0, 6.0];
    let map = read(&array("<f8", "True", "(2, 3)", &bytes_of(columns.map(f64::to_le_bytes))), "a.npy");
    assert_eq!(map.unwrap().values, signed);
    // Versions 2 and 3, double quotes, other order of keys, no blanks.
    for version in [2, 3] {
        let header = "{\"shape\":(2,3),\"descr\":\"<f8\",\"fortran_order\":False}";
        let map = read(&array_with(header, version, &bytes_of(signed.map(f64::to_le_bytes))), "a.npy");
        assert_eq!(map.unwrap().values, signed);
    }
}

#[test]
fn arrays_that_are_no_maps_are_refused() {
    let eight = [0_u8; 8];
    for (code, words, bytes) in [
        ("E0505", "has 1 dimensions", array("<f8", "False", "(1,)", &eight)),
        ("E0505", "has 3 dimensions", array("<f8", "False", "(1, 1, 1)", &eight)),
        ("E0505", "holds `<c8` numbers", array("<c8", "False", "(1, 1)", &eight)),
        ("E0505", "holds `|b1` numbers", array("|b1", "False", "(2, 4)", &eight)),
        ("E0505", "holds `<f2` numbers", array("<f2", "False", "(2, 2)", &eight)),
        (
            "E0505",
            "does not describe a plain array",
            array_with("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (1, 1)}", 1, &eight),
        ),
        ("E0505", "does not describe a plain array", array_with("{'descr': '<f8'}", 1, &eight)),
        ("E0505", "does not describe a plain array", array("<f8", "Maybe", "(1, 1)", &eight)),
        ("E0505", "does not describe a plain array", array("<f8", "False", "(-1, 1)", &eight)),
        ("E0505", "version 9", array_with("{}", 9, &eight)),
        ("E0504", "0 columns and 3 rows", array("<f8", "False", "(3, 0)", &[])),
        ("E0503", "says 2 rows of 1 numbers of 8 bytes but has 8 bytes", array("<f8", "False", "(2, 1)", &eight)),
        ("E0501", "at most 16777216 pixels", array("<f8", "False", "(4294967296, 4294967296)", &eight)),
        ("E0501", "at most 16777216 pixels", array("<f8", "False", "(18446744073709551615, 2)", &eight)),
    ] {
        let problem = refused(&bytes);
        assert!(
            problem.code.as_str() == code && problem.message.contains(words),
            "{code} {words}: {}",
            problem.message
        );
    }
    let mut long = b"\x93NUMPY\x02\x00".to_vec();
    long.extend_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(refused(&long).code.as_str(), "E0503");
}

proptest! {
    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let _ = read(&bytes, "noise");
        let _ = metrology::inspect(&bytes, "noise", Some(1e-9), Some(1e-3));
    }

    #[test]
    fn random_changes_of_a_good_file_never_panic(
        format in 1_u16..=3,
        changes in prop::collection::vec((0_usize..850, any::<u8>()), 1..12),
        cut in 0_usize..4200,
    ) {
        let mut bytes = by_hand(format, 1, [1, 2, 3, i32::MAX]);
        for (at, byte) in changes {
            bytes[at] = byte;
        }
        bytes.truncate(cut.max(600));
        let _ = metrology::inspect(&bytes, "changed", None, None);
    }

    #[test]
    fn random_array_headers_never_panic(header in "[{}()',:a-z0-9< ]{0,60}", data in prop::collection::vec(any::<u8>(), 0..64)) {
        let _ = metrology::inspect(&array_with(&header, 1, &data), "a.npy", Some(1e-9), Some(1e-3));
        let _ = metrology::inspect(&array("<f8", "False", &header, &data), "a.npy", Some(1e-9), Some(1e-3));
    }
}

/// The study's maps inside 180 mm, piston and tilt off: PV, RMS and PVr with the 36 Fringe and with the 36 standard
/// polynomials, by the study's own code (NumPy). Map B is the example's; the others lie beside the samples.
#[test]
fn robust_figures_of_the_study() {
    let beside = |name: &str| {
        let folder = std::env::var_os("POLISHC_SAMPLES")
            .map_or_else(|| std::path::PathBuf::from("../shared/samples"), std::path::PathBuf::from);
        folder.join("../maps").join(name)
    };
    for (path, pv, rms, fringe, standard) in [
        ("examples/sphere_200/map_b.npy".into(), 96.416, 15.232, 100.101, 97.945),
        (beside("map_A_pv1.0.npy"), 632.326, 114.284, 664.832, 712.757),
        (beside("map_C_pv0.10.npy"), 64.447, 10.314, 67.262, 67.673),
    ] {
        let Ok(bytes) = std::fs::read(&path) else {
            println!("skipped: there is no {}", path.display());
            continue;
        };
        let map = read(&bytes, "map.npy").unwrap();
        let masked: Vec<f64> = (0..200 * 200)
            .map(|i| {
                let (x, y) = ((i % 200) as f64 - 99.5, (i / 200) as f64 - 99.5);
                if x * x + y * y < 90.0 * 90.0 { map.values[i] } else { f64::NAN }
            })
            .collect();
        let masked = npy::write(200, &masked).unwrap();
        let found = facts(metrology::inspect(&masked, "map.npy", Some(1e-9), Some(1e-3)).unwrap());
        let near = |found: Option<f64>, expected: f64| {
            let found = found.expect("a figure");
            assert!((found - expected).abs() < 1.1e-3, "{}: {found}, expected {expected}", path.display());
        };
        near(found.pv_detilted_nm, pv);
        near(found.rms_detilted_nm, rms);
        near(found.pvr_fringe36_nm, fringe);
        // The other set, of the picture without its plane: the mask is symmetric, so that mean and slopes are independent.
        let raw = read(&masked, "map.npy").unwrap();
        let mut grid = Grid { columns: 200, rows: 200, pixel: [1e-3; 2], origin: [-99.5e-3; 2], values: raw.values };
        let place = |i: usize| [(i % 200) as f64 - 99.5, (i / 200) as f64 - 99.5];
        let valid: Vec<usize> = (0..200 * 200).filter(|i| !grid.values[*i].is_nan()).collect();
        let mean = valid.iter().map(|i| grid.values[*i]).sum::<f64>() / valid.len() as f64;
        let slope = [0, 1].map(|k| {
            let sum = |f: &dyn Fn(usize) -> f64| valid.iter().map(|i| place(*i)[k] * f(*i)).sum::<f64>();
            sum(&|i| grid.values[i]) / sum(&|i| place(i)[k])
        });
        for i in valid {
            grid.values[i] -= mean + slope[0] * place(i)[0] + slope[1] * place(i)[1];
        }
        let other = metrology::pvr(&grid, &[true; 200 * 200], ZernikeOrder::noll).expect("enough pixels");
        near(Some(other.pvr), standard);
    }
}

#[test]
fn an_inspection_is_the_json_that_the_command_line_promises() {
    // Counts 0 and 32768 at resolution 1: 0 and half a wave, 316.4 nm; mean 158.2, RMS 158.2. Three corners of a square
    // have a plane through them exactly.
    let bytes = by_hand(1, 1, [0, 32768, 32768, i32::MAX]);
    let found = metrology::inspect(&bytes, "map.dat", None, None).unwrap();
    let json = serde_json::to_value(&found).unwrap();
    assert_eq!(json["kind"], "height_map");
    assert_eq!(json["pixel_mm"], serde_json::json!([0.25, 0.25]));
    assert_eq!((json["valid"].as_u64(), json["invalid"].as_u64()), (Some(3), Some(1)));
    assert_eq!(json["wavelength_nm"], 632.8);
    assert_eq!(json["pv_nm"], 316.4);
    // 0, h, h: variance 2/9 h², so RMS = 316.4 * sqrt(2) / 3.
    assert_eq!(json["rms_nm"], 149.152);
    assert_eq!((json["pv_detilted_nm"].as_f64(), json["rms_detilted_nm"].as_f64()), (Some(0.0), Some(0.0)));
    assert_eq!(json["blake3"], blake3_of(&bytes));
    // An array says neither pixel nor unit, and has no wavelength.
    let array = npy::write(2, &[1.0, 2.0, 3.0, 5.0]).unwrap();
    assert_eq!(metrology::inspect(&array, "a.npy", Some(1e-9), None).unwrap_err().field.as_deref(), Some("pixel"));
    assert_eq!(metrology::inspect(&array, "a.npy", None, Some(1e-3)).unwrap_err().field.as_deref(), Some("unit"));
    let json = serde_json::to_value(metrology::inspect(&array, "a.npy", Some(1e-9), Some(1e-3)).unwrap()).unwrap();
    assert_eq!((json["format"].as_str(), json.get("wavelength_nm")), (Some("npy"), None));
    assert_eq!(json["pv_nm"], 4.0);
}

fn blake3_of(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}
