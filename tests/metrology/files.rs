//! Small files of every format, made here, or by `files/make.py` where another library must write them.

use crate::formats::{SMALL_INT, SMALL_ZEMAX, small_zygo_texts};
use md5::{Digest, Md5};
use polishc::height_map::{metropro, npy};
use polishc::metrology::{Inspection, MapFacts};
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;

/// A file of `tests/metrology/files`.
pub fn made(name: &str) -> Vec<u8> {
    std::fs::read(format!("tests/metrology/files/{name}")).unwrap()
}

/// The facts of a map.
pub fn facts(inspection: Inspection) -> MapFacts {
    match inspection {
        Inspection::HeightMap(facts) => facts,
        Inspection::Profile(profile) => panic!("a profile: {profile:?}"),
    }
}

/// An X3P archive to be changed in one place.
pub struct X3p {
    pub size: (usize, usize, usize),
    /// Type of the heights, and the axis they have.
    pub kind: &'static str,
    pub height_axis: &'static str,
    pub more_z: &'static str,
    pub data: Vec<u8>,
    pub mask: Option<Vec<u8>>,
    /// Heights as text instead of `data`.
    pub list: Option<&'static str>,
    /// The sum of `main.xml`; the right one if empty.
    pub main_sum: &'static str,
    /// Another `main.xml`.
    pub change: Option<String>,
}

impl X3p {
    /// 3 columns 0.5 um apart, 2 rows 2 um apart, heights 1 to 6 nm as 64-bit floats.
    pub fn small() -> X3p {
        X3p {
            size: (3, 2, 1),
            kind: "D",
            height_axis: "A",
            more_z: "",
            data: (1..=6).flat_map(|i| (f64::from(i) * 1e-9).to_le_bytes()).collect(),
            mask: None,
            list: None,
            main_sum: "",
            change: None,
        }
    }

    pub fn main(&self) -> String {
        let X3p { size: (columns, rows, layers), kind, height_axis, more_z, .. } = self;
        let sum = |bytes: &[u8]| Md5::digest(bytes).iter().map(|byte| format!("{byte:02X}")).collect::<String>();
        let data = match (self.list, &self.mask) {
            (Some(list), _) => format!("<DataList>{list}</DataList>"),
            (None, None) => format!(
                "<DataLink><PointDataLink>bindata/data.bin</PointDataLink>\
                 <MD5ChecksumPointData>{}</MD5ChecksumPointData></DataLink>",
                sum(&self.data)
            ),
            (None, Some(mask)) => format!(
                "<DataLink><PointDataLink>bindata/data.bin</PointDataLink>\
                 <MD5ChecksumPointData>{}</MD5ChecksumPointData>\
                 <ValidPointsLink>bindata/valid.bin</ValidPointsLink>\
                 <MD5ChecksumValidPoints>{}</MD5ChecksumValidPoints></DataLink>",
                sum(&self.data),
                sum(mask)
            ),
        };
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<p:ISO5436_2 xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\">\n\
             <Record1><Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>\
             <CX><AxisType>I</AxisType><DataType>L</DataType><Increment>5e-7</Increment><Offset>1e-3</Offset></CX>\
             <CY><AxisType>I</AxisType><DataType>L</DataType><Increment>2e-6</Increment></CY>\
             <CZ><AxisType>{height_axis}</AxisType>{more_z}<DataType>{kind}</DataType></CZ></Axes></Record1>\n\
             <Record2><Comment>a &lt; b &amp; c</Comment></Record2>\n\
             <Record3><MatrixDimension><SizeX>{columns}</SizeX><SizeY>{rows}</SizeY><SizeZ>{layers}</SizeZ></MatrixDimension>\
             {data}</Record3>\n<Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>\n</p:ISO5436_2>\n"
        )
    }

    pub fn bytes(&self) -> Vec<u8> {
        let main = self.change.clone().unwrap_or_else(|| self.main());
        let right: String = Md5::digest(main.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
        let sum = if self.main_sum.is_empty() { &right } else { self.main_sum };
        let mut parts = vec![
            ("main.xml", main.into_bytes()),
            ("bindata/data.bin", self.data.clone()),
            ("md5checksum.hex", format!("{sum} *main.xml\n").into_bytes()),
        ];
        parts.extend(self.mask.clone().map(|mask| ("bindata/valid.bin", mask)));
        zipped(&parts)
    }
}

/// A ZIP archive of these parts.
pub fn zipped(parts: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in parts {
        archive.start_file(*name, SimpleFileOptions::default()).unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A binary SDF file of 3 columns (1 um) and 2 rows (2 um), version 1.0 or 2.0, numbers in nanometres of the type `code`
/// with `size` bytes.
pub fn sdf_binary(wide: bool, code: u8, size: usize, heights: &[f64]) -> Vec<u8> {
    let mut bytes = if wide { b"bISO-2.0".to_vec() } else { b"bISO-1.0".to_vec() };
    bytes.extend_from_slice(b"somebody  040120100853050320101353");
    for side in [3_u32, 2] {
        if wide {
            bytes.extend_from_slice(&side.to_le_bytes());
        } else {
            bytes.extend_from_slice(&(side as u16).to_le_bytes());
        }
    }
    for scale in [1e-6_f64, 2e-6, 1e-9, -1.0] {
        bytes.extend_from_slice(&scale.to_le_bytes());
    }
    bytes.extend_from_slice(&[0, code, 0]);
    for height in heights {
        let bad = height.is_nan();
        match (code, size) {
            (3, _) => bytes.extend_from_slice(&(if bad { f32::MIN } else { *height as f32 }).to_le_bytes()),
            (7, _) => bytes.extend_from_slice(&(if bad { f64::MIN } else { *height }).to_le_bytes()),
            (_, 1) => bytes.extend_from_slice(&(if bad { i8::MIN } else { *height as i8 }).to_le_bytes()),
            (_, 2) => bytes.extend_from_slice(&(if bad { i16::MIN } else { *height as i16 }).to_le_bytes()),
            _ => bytes.extend_from_slice(&(if bad { i32::MIN } else { *height as i32 }).to_le_bytes()),
        }
    }
    bytes
}

/// One good file of each format and kind, by the format's name in `polishc inspect` and what is special.
pub fn all() -> Vec<(&'static str, Vec<u8>)> {
    let heights = [1e-9, 2e-9, 4e-9, f64::NAN, 0.0, -1e-9];
    let fizeau = metropro::Settings::fizeau(1e-3);
    let [ascii, xyz] = small_zygo_texts();
    vec![
        ("metropro 1", metropro::write(3, &heights, &metropro::Settings { header_format: 1, ..fizeau }).unwrap()),
        ("metropro 3", metropro::write(3, &heights, &fizeau).unwrap()),
        ("npy", npy::write(3, &heights).unwrap()),
        ("datx", made("fringes.datx")),
        ("4sight", made("plain.h5")),
        ("4sight packed", made("packed.h5")),
        ("zygo_text ascii", ascii.into_bytes()),
        ("zygo_text xyz", xyz.into_bytes()),
        ("codev_int", SMALL_INT.into()),
        ("zemax_grid_sag", SMALL_ZEMAX.into()),
        ("x3p", X3p::small().bytes()),
        ("x3p masked", X3p { mask: Some(vec![0b11_1011]), ..X3p::small() }.bytes()),
        ("x3p as text", X3p { list: Some("<Datum>1e-9</Datum><Datum/><Datum>3e-9</Datum><Datum>1e-9</Datum><Datum>5e-9</Datum><Datum>6e-9</Datum>"), ..X3p::small() }.bytes()),
        ("sdf binary", sdf_binary(false, 7, 8, &[1.0, 2.0, 4.0, f64::NAN, 0.0, 2.5])),
        ("sdf text", b"aISO-1.0\nNumPoints = 3\nNumProfiles = 2\nXscale = 1.0E-6\nYscale = 2.0E-6\nZscale = 1.0E-9\n\
            Compression = 0\nDataType = 7\nCheckType = 0\n*\n1 -2 3\n4 BAD 6\n*\n<Name> x </Name>\n*".to_vec()),
        ("table of points", b"x (mm), y (mm), z (nm)\n0,0,1\n1,0,2\n0,1,3\n1,1,5\n".to_vec()),
        ("table in UTF-16", [0xFF, 0xFE].into_iter().chain("x [um];y [um];z [nm]\n0;0;1\n1;0;2\n0;1;3\n1;1;5,5\n".encode_utf16().flat_map(u16::to_le_bytes)).collect()),
        ("table as matrix", b"# Width: 3 mm\n# Height: 2 mm\n# Value units: nm\n1 2 3 4\n5 6 7 9\n".to_vec()),
        ("profile", b"x (mm), z (nm)\n0, 1\n0.5, 2\n1, 6\n".to_vec()),
    ]
}
