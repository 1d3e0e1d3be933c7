//! Each format by hand: what a small file means, worked out from its description, and what of it is refused.

use crate::files::{X3p, facts, made, sdf_binary};
use polishc::height_map::{Content, Format, Profile, RawMap, code_v, content, metropro, read, x3p};
use polishc::job::Quantity;
use polishc::metrology::{Inspection, inspect};

fn map(bytes: &[u8]) -> RawMap {
    read(bytes, "map").unwrap()
}

fn profile(bytes: &[u8]) -> Profile {
    match content(bytes, "profile").unwrap() {
        Content::Profile(profile) => profile,
        Content::Map(map) => panic!("a map of {} x {}", map.columns, map.rows),
    }
}

/// Heights in nanometres, to the picometre; -1 where invalid.
fn nanometres(map: &RawMap) -> Vec<f64> {
    map.values.iter().map(|v| if v.is_nan() { -1.0 } else { (v * 1e12).round() / 1e3 }).collect()
}

#[track_caller]
fn refused(bytes: &[u8], code: &str, words: &str) {
    let problem = content(bytes, "map").expect_err("a refusal");
    assert!(problem.code.as_str() == code && problem.message.contains(words), "{} {}", problem.code, problem.message);
    assert!(problem.message.starts_with("`map` ") && problem.field.as_deref() == Some("file"), "{}", problem.message);
    assert!(problem.help.is_some_and(|help| !help.is_empty()), "{words}: no mend");
}

#[test]
fn datx_in_fringes() {
    // Value 10 r + c fringes at 600 nm, S 0.5, O 1.25: 375 nm a fringe. Pixels 1 mm x 2 mm. tests/metrology/files/make.py.
    let found = map(&made("fringes.datx"));
    assert_eq!((found.format, found.columns, found.rows, found.in_metres), (Format::Datx, 4, 3, true));
    let expected = [0.0, 1.0, 2.0, 3.0, 10.0, 11.0, 12.0, 13.0, 20.0, 21.0, 22.0].map(|fringes| fringes * 375.0);
    assert_eq!(nanometres(&found)[..11], expected);
    assert!(found.values[11].is_nan());
    assert_eq!((found.pixel, found.wavelength), (Some([1e-3, 2e-3]), Some(600e-9)));
    assert_eq!((found.quantity, found.sign_inverted), (Some(Quantity::surface), false));
}

#[test]
fn datx_in_units_of_length_and_others() {
    let found = map(&made("nanometres.datx"));
    assert_eq!(nanometres(&found)[..5], [0.0, 1.0, 2.0, 3.0, 10.0]);
    // A pitch of 0 is "not calibrated"; the sign stands under /Attributes.
    assert_eq!((found.pixel, found.sign_inverted), (None, true));
    refused(&made("furlongs.datx"), "E0514", "heights are in `Furlongs`");
    refused(&made("two_surfaces.datx"), "E0513", "2 maps of heights");
}

#[test]
fn four_sight_in_waves() {
    for (file, wavelength) in [("plain.h5", 500.0), ("packed.h5", 500.0)] {
        let found = map(&made(file));
        assert_eq!((found.format, found.columns, found.rows, found.pixel), (Format::FourSight, 4, 3, None));
        let expected = [0.0, 1.0, 2.0, 3.0, 10.0, 11.0, 12.0, 13.0, 20.0, 21.0, 22.0].map(|waves| waves * wavelength);
        assert_eq!(nanometres(&found)[..11], expected, "{file}");
        assert!(found.values[11].is_nan(), "the largest number of single precision was not measured");
        assert!((found.wavelength.unwrap() - 500e-9).abs() < 1e-18);
    }
    refused(&made("no_unit.h5"), "E0514", "wavelength are in ``");
    refused(&made("no_wavelength.h5"), "E0504", "no text `wavelength`");
}

#[test]
fn hdf5_that_is_cut_or_holds_something_else() {
    let whole = made("fringes.datx");
    refused(&whole[..whole.len() - 1], "E0503", "cut short");
    refused(&whole[..100], "E0503", "cut short");
    refused(&whole[..20], "E0518", "damaged HDF5");
    // The name of a group is changed in the heap where it stands: nothing of the instruments' is left.
    let mut other = made("plain.h5");
    let at = other.windows(12).position(|name| name == b"measurement0").unwrap();
    other[at] = b'M';
    refused(&other, "E0513", "without heights where Zygo");
}

/// The header of Zygo's texts: 3 columns, 2 rows, 600 nm, S 0.5, O 1.25, 0.2 mm, resolution 1/32768 fringe.
fn zygo_header(first_line: &str) -> String {
    [
        first_line,
        "1 8 3 3 \"Wed Jan 30 10:35:03 2013\"",
        "0 0 2 1 1 255",
        "10 20 3 2",
        "\"a remark with a # in it\"",
        "\"serial\"",
        "\"part\"",
        "0 0.5 6e-07 0 1.25 0 0.0002 1647433367",
        "640 480 4 0 1 0 \"lens\"",
        "0 0 1 1293 0 1 0.1 40 17 50",
        "1 3 20 1 0 0 0 0 0",
        "0 \"\"",
        "1 0",
        "\"1X\"",
        "#",
    ]
    .join("\n")
}

fn zygo_ascii() -> String {
    // Intensities 7 and 8; the heights run over lines as they come.
    zygo_header("Zygo ASCII Data File - Format 2") + "\n7 8\n#\n32768 -32768 \n0 2147483640\n65536 16384\n#\n"
}

fn zygo_xyz() -> String {
    zygo_header("Zygo XYZ Data File - Format 1")
        + "\n10 20 0.5\n11 20 -0.5\n12 20 0\n10 21 No Data\n11 21\t1.0\n12 21 0.25\n#\n"
}

#[test]
fn zygo_texts() {
    // A fringe is 600 nm * 0.5 * 1.25 = 375 nm.
    let found = map(zygo_ascii().as_bytes());
    assert_eq!((found.format, found.columns, found.rows, found.in_metres), (Format::ZygoText, 3, 2, true));
    assert_eq!(nanometres(&found), [375.0, -375.0, 0.0, -1.0, 750.0, 187.5]);
    assert_eq!((found.pixel, found.wavelength), (Some([0.2e-3; 2]), Some(600e-9)));
    assert_eq!((found.quantity, found.sign_inverted), (Some(Quantity::surface), false));
    // With DOS ends of lines, and inverted.
    let inverted = zygo_ascii().replace("1 3 20 1 0 0 0 0 0", "1 3 20 1 0 0 0 1 0").replace('\n', "\r\n");
    assert!(map(inverted.as_bytes()).sign_inverted);
    // The XYZ file does not say its unit: MetroPro writes micrometres, Mx what was set.
    let found = map(zygo_xyz().as_bytes());
    assert!(!found.in_metres);
    assert_eq!(found.metres(None).unwrap_err().code.as_str(), "E0506");
    let micrometres = RawMap { values: found.metres(Some(1e-6)).unwrap(), ..found };
    assert_eq!(nanometres(&micrometres), [500.0, -500.0, 0.0, -1.0, 1000.0, 250.0]);
}

#[test]
fn zygo_texts_that_contradict_themselves() {
    let ascii = |old: &str, new: &str| zygo_ascii().replace(old, new).into_bytes();
    refused(&ascii("10 20 3 2", "10 20 3 3"), "E0503", "6 heights and should have 9");
    refused(&ascii("10 20 3 2", "10 20 3 1"), "E0503", "more heights than the 3");
    refused(&ascii("10 20 3 2", "10 20 0 2"), "E0504", "line 4");
    refused(&ascii("10 20 3 2", "10 20 60000 60000"), "E0501", "at most 16777216 pixels");
    refused(&ascii("10 20 3 2", "10 20 4000 4000"), "E0503", "do not stand in");
    refused(&ascii("6e-07", "6e-01"), "E0504", "wavelength is 6e-1");
    refused(&ascii("0.0002", "-0.0002"), "E0504", "pixel is -2e-4");
    refused(&ascii("1 3 20", "7 3 20"), "E0504", "phase resolution");
    refused(&ascii("65536 16384", "65536 sixteen"), "E0515", "`sixteen` in line 20");
    let xyz = |old: &str, new: &str| zygo_xyz().replace(old, new).into_bytes();
    refused(&xyz("12 21 0.25", "13 21 0.25"), "E0515", "no pixel of its 3 columns and 2 rows");
    refused(&xyz("12 21 0.25", "11 21 0.25"), "E0515", "column 1, row 1 twice");
    refused(&xyz("No Data", "no idea"), "E0515", "`no idea` in line 19");
    refused(&xyz("0.25\n#", "0.25"), "E0503", "no `#` ends its heights");
}

const INT: &str = "! made by hand\n  ! and another remark\nA title, GRD or not\nGRD 3 2 SUR WVL 0.5 SSZ 1000 NDA -32768 NNB\n\
    1000 2000 3000\n-1000 0\n-32768\n";

#[test]
fn code_v_rows_run_upwards() {
    // 1000 numbers a wavelength of 0.5 um: half a nanometre each. The first row of the file is the lowest one.
    let found = map(INT.as_bytes());
    assert_eq!((found.format, found.columns, found.rows, found.in_metres), (Format::CodeV, 3, 2, true));
    assert_eq!(nanometres(&found), [-500.0, 0.0, -1.0, 500.0, 1000.0, 1500.0]);
    assert_eq!((found.pixel, found.quantity), (None, Some(Quantity::surface)));
    assert_eq!(map(INT.replace("SUR", "wfr").as_bytes()).quantity, Some(Quantity::wavefront));
    // Three rows: the middle one stays.
    let three = "t\nGRD 1 3 WFR WVL 1 SSZ 1000 NDA 9\n1 2 3\n";
    assert_eq!(nanometres(&map(three.as_bytes())), [3.0, 2.0, 1.0]);
}

#[test]
fn code_v_that_is_no_map() {
    let int = |old: &str, new: &str| INT.replace(old, new).into_bytes();
    refused(&int("SUR", "FIL"), "E0513", "holds a filter");
    refused(&int("GRD 3 2", "ZFR 36"), "E0513", "holds coefficients (`ZFR`)");
    refused(&int("NNB", "XYZ"), "E0513", "the word `XYZ`");
    refused(&int("SUR ", ""), "E0504", "without `SUR`");
    refused(&int("WVL 0.5", ""), "E0504", "without `WVL`");
    refused(&int("SSZ 1000", "SSZ"), "E0504", "no scale after `SSZ`");
    refused(&int("SSZ 1000", "SSZ 0"), "E0504", "its `SSZ` is 0e0");
    refused(&int("SUR", "SUR WFR"), "E0504", "says `WFR`, or what it excludes, twice");
    refused(&int("GRD 3 2", "GRD 3 3"), "E0503", "6 heights and should have 9");
    refused(&int("GRD 3 2", "GRD 3 -2"), "E0504", "a grid of 3 x -2");
    refused(&int("GRD 3 2", "GRD 4000 4000"), "E0503", "16000000 heights do not stand in");
    refused(&int("2000", "20.5"), "E0515", "`20.5` in line 5");
    refused(&int("-32768\n", "-32768"), "E0503", "its last line has no end");
}

const ZEMAX: &str = "! made by hand\n3 2 0.5 0.25 1 0 0\n1e-7 0 0 0\n2e-7 0 0 0 0\n3e-7 0 0 0 1\n! the lower row\n-1e-7 9 9 9\n0 0 0 0\n5e-7 0 0 0\n";

#[test]
fn zemax_from_the_upper_left() {
    // Unit 1 is the centimetre.
    let found = map(ZEMAX.as_bytes());
    assert_eq!((found.format, found.columns, found.rows, found.in_metres), (Format::Zemax, 3, 2, true));
    assert_eq!(nanometres(&found), [1.0, 2.0, -1.0, -1.0, 0.0, 5.0]);
    assert_eq!(found.pixel, Some([0.5e-2, 0.25e-2]));
    let zemax = |old: &str, new: &str| ZEMAX.replace(old, new).into_bytes();
    // Inches: 0.5 in = 12.7 mm.
    assert_eq!(map(&zemax("0.25 1 0 0", "0.25 2 0 0")).pixel, Some([12.7e-3, 6.35e-3]));
    refused(&zemax("0.25 1 0 0", "0.25 4 0 0"), "E0504", "says 4 for its unit");
    refused(&zemax("0.25 1 0 0", "0.25 1 1 0"), "E0513", "decentred by 1 in x and 0 in y");
    let problem = read(&zemax("0.25 1 0 0", "0.25 1 1 0.5"), "map").unwrap_err();
    // The middle of the grid, column 1, row 0.5, stands at x = 1, y = 0.5: the origin two columns left, two rows below.
    assert!(problem.help.unwrap().contains("column: -1, row: 2.5"));
    refused(&zemax("5e-7 0 0 0\n", ""), "E0503", "5 points and should have 6");
    refused(&zemax("5e-7 0 0 0\n", "5e-7 0 0 0\n0 0 0 0\n"), "E0503", "more points than the 6");
    refused(&zemax("9 9 9", "9 9"), "E0515", "line 7");
    refused(&zemax("0.5 0.25", "0 0.25"), "E0504", "a pitch of 0 x 0.25");
    refused(&zemax("3 2 0.5", "3000 3000 0.5"), "E0503", "do not stand in");
}

#[test]
fn x3p_with_all_types_of_numbers() {
    // Columns 0.5 um, rows 2 um apart.
    let heights = [1.0, -2.0, 3.0, 4.0, 5.0, 6.0];
    for (kind, data) in [
        ("D", heights.map(|h: f64| (h * 1e-9).to_le_bytes().to_vec()).concat()),
        ("F", heights.map(|h| ((h * 1e-9) as f32).to_le_bytes().to_vec()).concat()),
    ] {
        let found = map(&X3p { kind, data, ..X3p::small() }.bytes());
        assert_eq!((found.format, found.columns, found.rows, found.in_metres), (Format::X3p, 3, 2, true));
        assert_eq!(nanometres(&found), [1.0, -2.0, 3.0, 4.0, 5.0, 6.0], "{kind}");
        assert_eq!(found.pixel, Some([0.5e-6, 2e-6]));
    }
    // Whole numbers have an increment, here a nanometre, and an offset, here 10 nm.
    for (kind, data) in [
        ("I", heights.map(|h| (h as i16).to_le_bytes().to_vec()).concat()),
        ("L", heights.map(|h| (h as i32).to_le_bytes().to_vec()).concat()),
    ] {
        let scaled = X3p {
            kind,
            data,
            height_axis: "I",
            more_z: "<Increment>1e-9</Increment><Offset>1e-8</Offset>",
            ..X3p::small()
        };
        assert_eq!(nanometres(&map(&scaled.bytes())), [11.0, 8.0, 13.0, 14.0, 15.0, 16.0], "{kind}");
        // Least bit first: points 0, 1, 3 and 5 are valid.
        let masked = X3p { mask: Some(vec![0b0010_1011]), ..scaled };
        assert_eq!(nanometres(&map(&masked.bytes())), [11.0, 8.0, -1.0, 14.0, -1.0, 16.0], "{kind}");
    }
    // As text, with an empty place.
    let listed = X3p {
        list: Some(
            "<Datum>1e-9</Datum><Datum/><Datum>;;3e-9</Datum><Datum>NaN</Datum><Datum>5e-9</Datum><Datum> 6e-9 </Datum>",
        ),
        ..X3p::small()
    };
    assert_eq!(nanometres(&map(&listed.bytes())), [1.0, -1.0, 3.0, -1.0, 5.0, 6.0]);
    // One row is a profile.
    let line = X3p { size: (6, 1, 1), ..X3p::small() };
    let found = profile(&line.bytes());
    assert!(found.heights.len() == 6 && (found.positions[5] - 2.5e-6).abs() < 1e-18);
}

#[test]
fn x3p_that_is_not_read() {
    let with =
        |change: &dyn Fn(String) -> String| X3p { change: Some(change(X3p::small().main())), ..X3p::small() }.bytes();
    let replaced = |old: &str, new: &str| with(&|main: String| main.replacen(old, new, 1));
    refused(&replaced("<FeatureType>SUR", "<FeatureType>PCL"), "E0513", "cloud of points");
    refused(&replaced("<CX><AxisType>I", "<CX><AxisType>A"), "E0513", "absolute axis CX");
    refused(&replaced("</CZ>", "</CZ><Rotation><r11>0</r11></Rotation>"), "E0513", "rotated axes");
    refused(&replaced("<SizeZ>1", "<SizeZ>2"), "E0513", "2 layers");
    refused(
        &replaced("<DataType>D</DataType></CZ>", "<DataType>D</DataType><Increment>2</Increment></CZ>"),
        "E0513",
        "in two ways",
    );
    refused(&replaced("<DataType>D</DataType></CZ>", "<DataType>Q</DataType></CZ>"), "E0513", "type `Q`");
    refused(&replaced("<SizeX>3", "<SizeX>4"), "E0503", "48 bytes in its part `bindata/data.bin` and should have 64");
    refused(&replaced("<SizeX>3", "<SizeX>30000000"), "E0501", "at most 16777216 pixels");
    refused(&replaced("<SizeX>3", "<SizeX>-3"), "E0504", "SizeX` with -3");
    refused(&replaced("5e-7", "5 km"), "E0504", "`5 km` for `Record1/Axes/CX/Increment`");
    refused(&replaced("bindata/data.bin", "bindata/other.bin"), "E0503", "`bindata/other.bin` that is not in it");
    refused(
        &replaced("<MD5ChecksumPointData>", "<MD5ChecksumPointData>0"),
        "E0517",
        "`bindata/data.bin` does not agree",
    );
    refused(
        &X3p { main_sum: "0123456789abcdef0123456789abcdef", ..X3p::small() }.bytes(),
        "E0517",
        "`main.xml` does not agree",
    );
    refused(&replaced("<p:ISO5436_2", "<!DOCTYPE x [<!ENTITY a \"b\">]><p:ISO5436_2"), "E0518", "document type");
    refused(&replaced("<SizeX>3", "<SizeX>&a;"), "E0518", "entities of its own");
    refused(&with(&|main: String| main.replace("</p:ISO5436_2>", "")), "E0503", "ends too soon");
    refused(&with(&|_| "<a>".repeat(100_000)), "E0518", "without end");
    refused(&with(&|_| "not xml <".to_string()), "E0518", "no XML");
}

#[test]
fn sdf_in_text_and_in_bytes() {
    let ascii = "aISO-1.0\nManufacID = someone\nNumPoints = 3\nNumProfiles = 2\nXscale = 1.0E-6\nYscale = 2.0E-6\nZscale = 1.0E-9\n\
        Zresolution = -1\nCompression = 0\nDataType = 7\nCheckType = 0\n*\n1 -2 3\n4 BAD\n6\n*\nfree * text\n*";
    let found = map(ascii.as_bytes());
    assert_eq!((found.format, found.columns, found.rows, found.pixel), (Format::Sdf, 3, 2, Some([1e-6, 2e-6])));
    assert_eq!(nanometres(&found), [1.0, -2.0, 3.0, 4.0, -1.0, 6.0]);
    let changed = |old: &str, new: &str| ascii.replace(old, new).into_bytes();
    refused(&changed("NumPoints = 3", "NumPoints = 4"), "E0503", "6 heights and should have 8");
    refused(&changed("NumPoints = 3", "NumPoints = 2"), "E0503", "more heights than the 4");
    refused(&changed("NumPoints = 3\n", ""), "E0504", "no number `NumPoints`");
    refused(&changed("Compression = 0", "Compression = 1"), "E0513", "compressed");
    refused(&changed("CheckType = 0", "CheckType = 1"), "E0513", "a check of its numbers");
    refused(&changed("Zscale = 1.0E-9", "Zscale = 0"), "E0504", "its `Zscale` is 0e0");
    refused(&changed("4 BAD", "4 WORSE"), "E0515", "`WORSE` in line 14");
    refused(ascii.split("6\n*").next().unwrap().as_bytes(), "E0503", "a line `*` must end");
    for (code, size) in [(4, 1), (5, 2), (6, 4), (3, 4), (7, 8)] {
        for wide in [false, true] {
            let bytes = sdf_binary(wide, code, size, &[1.0, -2.0, 3.0, 4.0, f64::NAN, 6.0]);
            let found = map(&bytes);
            assert_eq!((found.columns, found.rows, found.pixel), (3, 2, Some([1e-6, 2e-6])));
            assert_eq!(nanometres(&found), [1.0, -2.0, 3.0, 4.0, -1.0, 6.0], "type {code}");
            refused(&bytes[..bytes.len() - 1], "E0503", "cut short");
            refused(&bytes[..60], "E0503", "inside its header");
        }
    }
    refused(&sdf_binary(false, 1, 2, &[1.0; 6]), "E0513", "type 1");
}

#[test]
fn tables_of_points() {
    // x to the right, y upwards, whatever the order: (0,0) 1, (1,0) 2, (0,1) 3, (1,1) 4; the picture's top row is y = 1.
    let expected = [3.0, 4.0, 1.0, 2.0];
    for table in [
        "x (mm), y (mm), z (nm)\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n",
        "# a remark\n\nZ [nm];X [mm];Y [mm]\n1;0;0\n2;1;0\n3;0;1\n4;1,0;1\n",
        "index\tx in mm\ty in mm\tz in nm\n0\t0\t1\t3\n1\t1\t0\t2\n2\t1\t1\t4\n3\t0\t0\t1",
        "X_(microns),Y_(microns),Z_(angstroms)\r\n0,0,10\r\n1000,0,20\r\n0,1000,30\r\n1000,1000,40\r\n",
        "\"x/mm\",\"y/mm\",\"height/nm\"\n0,0,1,\n1,0,2,\n0,1,3,\n1,1,4,\n",
        "x (mm)  y (mm)  sag (µm)\n0 0 0.001\n1 0 0.002\n0 1 0.003\n1 1 0.004\n",
    ] {
        let found = map(table.as_bytes());
        assert_eq!((found.format, found.columns, found.rows, found.in_metres), (Format::Table, 2, 2, true), "{table}");
        assert_eq!(nanometres(&found), expected, "{table}");
        let pixel = found.pixel.unwrap();
        assert!(pixel.iter().all(|side| (side - 1e-3).abs() < 1e-15), "{table}");
    }
    // The same in UTF-16 of both orders, in UTF-8 with a mark, and with the micro sign of old Windows.
    let table = "x (µm), y (µm), z (nm)\n0,0,1\n1000,0,2\n0,1000,3\n1000,1000,4\n";
    let wide = |order: fn(u16) -> [u8; 2], mark: [u8; 2]| -> Vec<u8> {
        mark.into_iter().chain(table.encode_utf16().flat_map(order)).collect()
    };
    let little = wide(u16::to_le_bytes, [0xFF, 0xFE]);
    let narrow = table.chars().map(|c| c as u8).collect();
    for bytes in
        [little.clone(), wide(u16::to_be_bytes, [0xFE, 0xFF]), [&[0xEF, 0xBB, 0xBF], table.as_bytes()].concat(), narrow]
    {
        assert_eq!(nanometres(&map(&bytes)), expected);
    }
    refused(&little[..little.len() - 1], "E0503", "half a letter");
    // Places without a point were not measured; coordinates may be rounded.
    let ring = map(b"0.000 0.667 1\n0.333 0.000 2\n0.333 0.667 3\n0.667 0.333 4\n0.667 0 nan\n");
    assert_eq!((ring.columns, ring.rows, ring.pixel, ring.in_metres), (3, 3, None, false));
    let unit = ring.metres(Some(1e-9)).unwrap();
    assert_eq!(nanometres(&RawMap { values: unit, ..ring }), [1.0, 3.0, -1.0, -1.0, -1.0, 4.0, -1.0, 2.0, -1.0]);
}

#[test]
fn tables_that_say_no_unit_wait_for_the_job() {
    let found = map(b"0 0 1\n0 1 2\n1 0 3\n1 1 4\n");
    assert_eq!(found.pixel_pitch(None).unwrap_err().code.as_str(), "E0506");
    assert_eq!(found.heights(None).unwrap_err().code.as_str(), "E0506");
    assert_eq!(found.pixel_pitch(Some(0.5e-3)).unwrap(), [0.5e-3; 2]);
    // With steps that differ one stated side would be wrong for the other.
    refused(b"0 0 1\n0 2 2\n1 0 3\n1 2 4\n", "E0516", "1 apart in x and 2 in y");
    // A matrix, and Gwyddion's, which says all.
    let matrix = map(b"1;2;3;4,5\n5;;7;8\n");
    assert_eq!((matrix.columns, matrix.rows, matrix.in_metres), (4, 2, false));
    assert_eq!(matrix.values[3], 4.5);
    assert!(matrix.values[5].is_nan());
    let gwyddion = "# Channel: height\n# Width: 8.0 mm\n# Height: 3.0 mm\n# Value units: nm\n1\t2\t3\t4\n5\t6\t7\t8\n";
    let found = map(gwyddion.as_bytes());
    assert_eq!(nanometres(&found), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    assert_eq!(found.pixel, Some([2e-3, 1.5e-3]));
    refused(gwyddion.replace("units: nm", "units: V").as_bytes(), "E0514", "heights are in `V`");
    refused(gwyddion.replace("8.0 mm", "8.0 px").as_bytes(), "E0514", "columns are in `px`");
}

#[test]
fn tables_that_are_none() {
    refused(b"just words\nand more of them\n", "E0502", "no height map of a known format");
    refused(b"x (mm), y (mm), z (waves)\n0,0,1\n1,0,2\n", "E0514", "values of `z` are in `waves`");
    refused(b"x (mm), y, z (nm)\n0,0,1\n1,0,2\n", "E0515", "one of x and y");
    refused(b"a, b, c\n0,0,1\n1,0,2\n", "E0515", "names its columns `a`, `b`, `c`");
    refused(b"x, y, z, w\n0,0,1\n1,0,2\n", "E0515", "names 4 columns and has 3");
    refused(b"1,2,3,4\n1,2,3\n", "E0515", "3 numbers in line 2 and 4");
    refused(b"1,2,3,4\n1,2,3,four\n", "E0515", "`four` in line 2");
    refused(b"1\t2\t3\t4\n1\t2\t3\t4,5\n", "E0515", "`4,5` in line 2");
    refused(b"1;2;3;4\n1;2;3;1.234,5\n", "E0515", "`1.234,5` in line 2");
    refused(b"1,2,3,4,\n1,2,3,4,\n", "E0515", "ends every line with a separator");
    refused(b"0 0 1\n1 0 2\n0 1 3\n0.4 0.4 4\n", "E0516", "");
    refused(b"0 0 1\n1 0 2\n0 1 3\n1 0 4\n", "E0516", "two points at x = 1, y = 0");
    refused(b"0 0 1\n0 1 2\n0 2 3\n", "E0516", "all points at one x");
    refused(b"0 0 1\n0.001 0.001 2\n1 1 3\n0.002 0.002 1\n", "E0516", "too few");
    refused(b"0 nan 1\n1 0 2\n", "E0516", "its point 1");
}

#[test]
fn profiles_are_told_and_refused() {
    let bytes = b"x (mm), z (nm)\n0, 1\n0.5, 2\n1, 6\n1.5, nan\n";
    let found = profile(bytes);
    assert_eq!((found.positions_in_metres, found.in_metres, found.positions.len()), (true, true, 4));
    assert_eq!(read(bytes, "line.csv").unwrap_err().message, "`line.csv` is a line profile of 4 points, not a map");
    let Inspection::Profile(facts) = inspect(bytes, "line.csv", None, None).unwrap() else { panic!("a profile") };
    assert_eq!((facts.kind, facts.format, facts.valid, facts.invalid), ("profile", "table", 3, 1));
    // Heights 1, 2, 6: mean 3, squares 4 + 1 + 9. The line through them is 0.5 + 5 x / mm: rests 0.5, -1, 0.5.
    assert_eq!(
        (facts.length_mm, facts.pv_nm, facts.rms_nm),
        (1.5, 5.0, (1000.0 * (14.0_f64 / 3.0).sqrt()).round() / 1e3)
    );
    assert_eq!((facts.pv_detilted_nm, facts.rms_detilted_nm), (Some(1.5), Some(0.707)));
    // What the file does not say must be said.
    let plain = b"0 1\n1 2\n2 6\n";
    assert_eq!(inspect(plain, "p", None, Some(1e-3)).unwrap_err().field.as_deref(), Some("unit"));
    assert_eq!(inspect(plain, "p", Some(1e-9), None).unwrap_err().field.as_deref(), Some("pixel"));
    let Inspection::Profile(facts) = inspect(plain, "p", Some(1e-9), Some(1e-3)).unwrap() else { panic!("a profile") };
    assert_eq!((facts.length_mm, facts.pv_nm), (2.0, 5.0));
}

#[test]
fn what_is_written_is_read_again() {
    let heights: Vec<f64> =
        (0..35).map(|i| if i % 11 == 5 { f64::NAN } else { ((i * i) % 17) as f64 * 13.7e-9 - 90e-9 }).collect();
    let same = |found: &RawMap, within: f64| {
        assert_eq!((found.columns, found.rows), (7, 5));
        for (found, expected) in found.values.iter().zip(&heights) {
            assert!(found.is_nan() == expected.is_nan() && !((found - expected).abs() > within), "{found} {expected}");
        }
    };
    let bytes = x3p::write(7, &heights, [0.4e-3, 0.3e-3]).unwrap();
    let found = map(&bytes);
    same(&found, 0.0);
    assert_eq!(found.pixel, Some([0.4e-3, 0.3e-3]));
    let bytes = code_v::write(7, &heights, Quantity::wavefront, "! no remark").unwrap();
    let found = map(&bytes);
    // The greatest height is 128.7 nm: half a step is 128.7 nm / 65532.
    same(&found, 128.7e-9 / 65_532.0 * 1.0001);
    assert_eq!(found.quantity, Some(Quantity::wavefront));
    assert!(String::from_utf8(bytes).unwrap().lines().all(|line| line.len() <= 80));
    let settings = metropro::Settings { header_format: 1, ..metropro::Settings::fizeau(0.4e-3) };
    same(&map(&metropro::write(7, &heights, &settings).unwrap()), 632.8e-9 * 0.5 / 32768.0 / 2.0 * 1.0001);
    // What does not fit is not written.
    assert_eq!(x3p::write(6, &heights, [1e-3; 2]), None);
    assert_eq!(x3p::write(7, &heights, [0.0, 1e-3]), None);
    assert_eq!(x3p::write(1, &[f64::INFINITY], [1e-3; 2]), None);
    assert_eq!(code_v::write(6, &heights, Quantity::surface, "t"), None);
    assert_eq!(code_v::write(1, &[f64::NAN], Quantity::surface, "t"), None);
    // A flat map, and one that is invalid in places.
    assert_eq!(nanometres(&map(&code_v::write(2, &[0.0, 0.0], Quantity::surface, "").unwrap())), [0.0, 0.0]);
}

#[test]
fn inspect_names_each_format() {
    for (name, bytes) in crate::files::all() {
        let stated = |field: &str| match field {
            "unit" => Some(1e-9),
            _ => Some(1e-3),
        };
        let (mut unit, mut pixel) = (None, None);
        // As a person does: what the message asks for is stated.
        while let Err(problem) = inspect(&bytes, name, unit, pixel) {
            assert_eq!(problem.code.as_str(), "E0506", "{name}: {}", problem.message);
            match problem.field.as_deref() {
                Some("unit") if unit.is_none() => unit = stated("unit"),
                Some("pixel") if pixel.is_none() => pixel = stated("pixel"),
                other => panic!("{name} asks for {other:?} twice"),
            }
        }
        let found = inspect(&bytes, name, unit, pixel).unwrap();
        if !name.starts_with("profile") {
            let facts = facts(found);
            assert!(name.starts_with(facts.format), "{name} is {}", facts.format);
        }
    }
}

pub(crate) const SMALL_INT: &str = INT;
pub(crate) const SMALL_ZEMAX: &str = ZEMAX;

pub(crate) fn small_zygo_texts() -> [String; 2] {
    [zygo_ascii(), zygo_xyz()]
}
