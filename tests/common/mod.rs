//! What several tests share: the tree's files from memory, and data made for the tests.
#![allow(dead_code, reason = "each test crate uses its own part")]
#![allow(clippy::disallowed_methods, reason = "tests read the tree's own files")]

pub mod regions;

use polishc::height_map::metropro::{self, Settings};
use polishc::height_map::{npy, x3p};
use polishc::source::{FileError, FileProvider, normalise};
use std::collections::BTreeMap;
use std::io::{Cursor, Read, Write};

/// The files of the working tree, and under any folder, by name, generated data and the libraries of `tests/ui/lib`.
/// `extra` comes first.
#[derive(Default)]
pub struct TestFiles {
    pub extra: BTreeMap<String, Vec<u8>>,
}

impl FileProvider for TestFiles {
    fn read(&self, path: &str, limit: u64) -> Result<Vec<u8>, FileError> {
        let name = path.rsplit('/').next().unwrap_or(path);
        let bytes = match self.extra.get(path).cloned().or_else(|| generated(name)) {
            Some(bytes) => bytes,
            None => std::fs::read(path)
                .or_else(|_| std::fs::read(format!("tests/ui/lib/{name}")))
                .map_err(|_| FileError::NotFound)?,
        };
        // `@good.dat@` in a record of a run stands for the hash of that generated file.
        let bytes = match (name, generated("good.dat")) {
            ("result.json", Some(good)) => {
                String::from_utf8_lossy(&bytes).replace("@good.dat@", &blake3::hash(&good).to_hex()).into_bytes()
            }
            _ => bytes,
        };
        let size = bytes.len() as u64;
        if size > limit { Err(FileError::TooLarge { size, limit }) } else { Ok(bytes) }
    }

    fn resolve(&self, from: &str, path: &str) -> Result<String, FileError> {
        let whole = normalise(from, path).ok_or(FileError::Outside)?;
        // Each folder of fixtures is a project of its own.
        let folder = from.rsplit_once('/').map_or("", |(folder, _)| folder);
        if from.is_empty() || whole.starts_with(folder) { Ok(whole) } else { Err(FileError::Outside) }
    }

    fn list(&self, path: &str) -> Result<Vec<String>, FileError> {
        let entries = std::fs::read_dir(path).map_err(|_| FileError::NotFound)?;
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        Ok(names)
    }
}

/// Pixels of the generated maps, 1 mm each: 60 x 60, centred on the part's origin.
pub const SIZE: usize = 60;

/// Height in metres at a place of the part in metres: a tilted saddle with one bump, about 100 nm.
pub fn height(x: f64, y: f64) -> f64 {
    let d2 = (x - 0.008) * (x - 0.008) + (y - 0.005) * (y - 0.005);
    1e-6 * x - 5e-5 * (x * x - y * y) + 60e-9 * (-d2 / (2.0 * 0.004 * 0.004)).exp()
}

fn picture(valid: impl Fn(f64, f64) -> bool) -> Vec<f64> {
    let mut values = Vec::with_capacity(SIZE * SIZE);
    for row in 0..SIZE {
        for column in 0..SIZE {
            let x = (column as f64 - (SIZE - 1) as f64 / 2.0) * 1e-3;
            let y = ((SIZE - 1) as f64 / 2.0 - row as f64) * 1e-3;
            values.push(if valid(x, y) { height(x, y) } else { f64::NAN });
        }
    }
    values
}

/// A dip of 150 nm with a sigma of 4 mm in the middle, and what `more` adds at a squared distance from it.
fn spot(more: impl Fn(f64) -> f64) -> Vec<f64> {
    let middle = (SIZE - 1) as f64 / 2.0;
    (0..SIZE * SIZE)
        .map(|i| {
            let [x, y] = [(i % SIZE) as f64, (i / SIZE) as f64].map(|k| (k - middle) * 1e-3);
            let r2 = x * x + y * y;
            -150e-9 * (-r2 / (2.0 * 0.004 * 0.004)).exp() + more(r2)
        })
        .collect()
}

fn metropro(heights: Vec<f64>) -> Vec<u8> {
    let settings = Settings { header_format: 1, phase_resolution: 1, ..Settings::fizeau(1e-3) };
    metropro::write(SIZE, &heights, &settings).expect("heights that fit the format")
}

fn numpy(values: &[f64]) -> Vec<u8> {
    npy::write(SIZE, values).expect("whole rows")
}

/// The map as `.npy` whose header says another shape.
fn reshaped(shape: &str) -> Vec<u8> {
    const OLD: &[u8] = b"(60, 60)";
    let mut bytes = numpy(&picture(|_, _| true));
    let at = bytes.windows(OLD.len()).position(|words| words == OLD).expect("the shape stands in the header");
    // The header ends in blanks: as many are taken out as the shape is longer.
    let longer = shape.len() - OLD.len();
    let end = bytes.windows(longer + 1).position(|w| w.ends_with(b"\n") && w[..longer].iter().all(|b| *b == b' '));
    let end = end.expect("blanks at the header's end");
    bytes.drain(end..end + longer);
    bytes.splice(at..at + OLD.len(), shape.bytes());
    bytes
}

/// Data that fixtures name.
fn generated(name: &str) -> Option<Vec<u8>> {
    let disc = |x: f64, y: f64| x * x + y * y < 0.029 * 0.029;
    Some(match name {
        // A good map of a 58 mm disc.
        "good.dat" => metropro(picture(disc)),
        // The same as numbers in nanometres, with no scale in the file.
        "good.npy" => numpy(&picture(disc).iter().map(|h| h * 1e9).collect::<Vec<_>>()),
        "all_nan.npy" => numpy(&vec![f64::NAN; SIZE * SIZE]),
        "cube.npy" => reshaped("(60,6,1)"),
        // An array of 30,000 x 30,000 numbers, of which a few are there.
        "huge.npy" => reshaped("(30000, 30000)"),
        // A hole of 10 mm in the middle of the aperture.
        "hole.dat" => metropro(picture(|x, y| disc(x, y) && x * x + y * y > 0.005 * 0.005)),
        // A hole of three pixels.
        "speck.dat" => metropro(picture(|x, y| disc(x, y) && (x * x + y * y) > 0.001 * 0.001)),
        // Only a 20 mm disc was seen.
        "small.dat" => metropro(picture(|x, y| x * x + y * y < 0.010 * 0.010)),
        // The disc stands 9 mm off the middle of the picture.
        "off_centre.dat" => metropro(picture(|x, y| (x - 0.009) * (x - 0.009) + y * y < 0.020 * 0.020)),
        "empty.dat" => Vec::new(),
        "truncated.dat" => metropro(picture(disc))[..5000].to_vec(),
        "short_header.dat" => metropro(picture(disc))[..300].to_vec(),
        "lying.dat" => {
            // The width of the phase block says 30,000 columns.
            let mut bytes = metropro(picture(disc));
            bytes[68..70].copy_from_slice(&30_000_i16.to_be_bytes());
            bytes
        }
        // Taken with the control "sign" set to inverted.
        "inverted.dat" => {
            let mut bytes = metropro(picture(disc));
            bytes[232..234].copy_from_slice(&1_i16.to_be_bytes());
            bytes
        }
        // The wavelength of the header, bytes 168 to 171, is zero.
        "dark.dat" => {
            let mut bytes = metropro(picture(disc));
            bytes[168..172].fill(0);
            bytes
        }
        "coarse.npy" => npy::write(3, &[1.0, 2.0, 1.5, 0.5, 3.0, 1.0, 2.5, 0.5, 1.0]).expect("whole rows"),
        // Spots of 30 s.
        "spot.dat" => metropro(spot(|_| 0.0)),
        "spot_hole.dat" => metropro(spot(|r2| if r2 < 0.002 * 0.002 { f64::NAN } else { 0.0 })),
        "spot_masked.dat" => metropro(spot(|r2| if r2 > 0.015 * 0.015 { f64::NAN } else { 0.0 })),
        // 40 nm of glass stand up in a ring of 9 to 12 mm radius.
        "spot_ring.dat" => metropro(spot(|r2| if (0.009 * 0.009..0.012 * 0.012).contains(&r2) { 40e-9 } else { 0.0 })),
        // Any heights between -10 and 10 nm.
        "noise_map.dat" => {
            let height = |i: usize| ((i as u32).wrapping_mul(2_654_435_761) >> 24) as f64 * 8e-11 - 1e-8;
            metropro((0..SIZE * SIZE).map(height).collect())
        }
        // A row more than the spots.
        "tall.dat" => metropro(vec![0.0; SIZE * (SIZE + 1)]),
        // An archive in which one bit of the heights changed, and one whose heights were replaced by others.
        "damaged.x3p" => {
            let mut bytes = x3p::write(SIZE, &picture(disc), [1e-3; 2]).expect("whole rows");
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
            bytes
        }
        "edited.x3p" => {
            let [from, into] = [picture(disc), vec![0.0; SIZE * SIZE]]
                .map(|heights| x3p::write(SIZE, &heights, [1e-3; 2]).expect("whole rows"));
            let part = |bytes: &[u8], name: &str| {
                let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).expect("an archive");
                let mut found = Vec::new();
                archive.by_name(name).expect("a part").read_to_end(&mut found).expect("its bytes");
                found
            };
            let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
            for (name, bytes) in [("main.xml", &from), ("bindata/data.bin", &into), ("md5checksum.hex", &from)] {
                archive.start_file(name, zip::write::SimpleFileOptions::default()).expect("a part");
                archive.write_all(&part(bytes, name)).expect("its bytes");
            }
            archive.finish().expect("an archive").into_inner()
        }
        "flat.dat" => metropro(vec![0.0; SIZE * SIZE]),
        "noise.dat" => (0..4096_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect(),
        _ => return None,
    })
}
