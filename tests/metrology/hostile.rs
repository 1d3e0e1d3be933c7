//! Files that are cut, changed at random, or made to trap: no reader panics, hangs, or asks for more memory than a map
//! may have. What a fuzzer does in `fuzz/` for hours is done here for a moment.

use crate::files::{X3p, all, made, zipped};
use polishc::height_map::{Content, content, read};
use polishc::metrology::inspect;
use proptest::prelude::*;

#[track_caller]
fn refused(bytes: &[u8], code: &str, words: &str) {
    let problem = content(bytes, "map").expect_err("a refusal");
    assert!(problem.code.as_str() == code && problem.message.contains(words), "{} {}", problem.code, problem.message);
    assert!(problem.message.len() < 400, "{}", problem.message);
}

/// Tables say nowhere how many lines they have, so a cut one is a table: it must only be read or refused. All others know.
#[test]
fn every_truncation_of_every_format_is_refused() {
    for (name, bytes) in all() {
        let table = name.starts_with("table") || name.starts_with("profile");
        // The free text at the end of an SDF file ends where it ends; its heights end with the second `*`.
        let needed = match name {
            "sdf text" => bytes.iter().enumerate().filter(|(_, byte)| **byte == b'*').nth(1).unwrap().0 + 1,
            // Zygo's texts end with `#`.
            _ if name.starts_with("zygo_text") => bytes.iter().rposition(|byte| *byte == b'#').unwrap() + 1,
            _ => bytes.len(),
        };
        for length in 0..bytes.len() {
            match content(&bytes[..length], name) {
                Ok(_) => assert!(table || length >= needed, "{name}: {length} of {} bytes are read", bytes.len()),
                Err(problem) => assert!(problem.message.contains(name), "{}", problem.message),
            }
        }
    }
}

#[test]
fn nothing_valid_is_refused_in_every_format_that_can_say_it() {
    let nan = f64::NAN.to_le_bytes().repeat(6);
    let files = [
        X3p { data: nan, ..X3p::small() }.bytes(),
        X3p { mask: Some(vec![0]), ..X3p::small() }.bytes(),
        b"t\nGRD 2 1 SUR WVL 1 SSZ 1 NDA 7\n7 7\n".to_vec(),
        b"2 1 1 1 0 0 0\n0 0 0 0 1\n0 0 0 0 1\n".to_vec(),
        b"x (mm),y (mm),z (mm)\n0,0,nan\n0,1,nan\n1,0,\n1,1,nan\n".to_vec(),
        b"x (mm),z (mm)\n0,nan\n1,nan\n".to_vec(),
    ];
    for bytes in files {
        let pixel = matches!(content(&bytes, "map"), Ok(Content::Map(map)) if map.pixel.is_none()).then_some(1e-3);
        assert_eq!(inspect(&bytes, "map", None, pixel).unwrap_err().code.as_str(), "E0508");
    }
}

#[test]
fn zip_bombs_stop_at_the_size_that_was_known() {
    let zeros = |count: usize| vec![0_u8; count];
    // The heights unpack to a million times what the grid has room for; so do the mask and the checksum.
    let bomb = |change: fn(String) -> String, parts: Vec<(&str, Vec<u8>)>| {
        let main = change(X3p { mask: Some(vec![0x3F]), ..X3p::small() }.main());
        zipped(&[vec![("main.xml", main.into_bytes())], parts].concat())
    };
    let no_sums = |main: String| {
        main.replace("<ChecksumFile>md5checksum.hex</ChecksumFile>", "").replace("MD5Checksum", "Another")
    };
    let data = X3p::small().data;
    refused(&bomb(no_sums, vec![("bindata/data.bin", zeros(1 << 26))]), "E0518", "more than the 48 bytes");
    refused(
        &bomb(no_sums, vec![("bindata/data.bin", data), ("bindata/valid.bin", zeros(1 << 26))]),
        "E0518",
        "more than the 1 bytes",
    );
    refused(&bomb(|main| main, vec![("md5checksum.hex", zeros(1 << 26))]), "E0518", "more than the 1024 bytes");
    // A description of blanks without end.
    refused(&zipped(&[("main.xml", vec![b' '; (1 << 26) + 1])]), "E0518", "more than the 67108864 bytes");
    // A size that is a lie: the list says 4 GB for a part of 48 bytes.
    let mut lying = X3p::small().bytes();
    let list = lying.windows(4).position(|mark| mark == b"PK\x01\x02").unwrap();
    for record in (list..lying.len() - 46).filter(|at| lying[*at..].starts_with(b"PK\x01\x02")).collect::<Vec<_>>() {
        lying[record + 24..record + 28].copy_from_slice(&u32::MAX.wrapping_sub(1).to_le_bytes());
    }
    // It is either read for what it is, or refused; never allocated.
    let _ = content(&lying, "map");
}

#[test]
fn archives_that_keep_a_reader_busy_are_refused() {
    let good = X3p::small().bytes();
    // The mark of an end a thousand times behind each other.
    let many = [good.clone(), b"PK\x05\x06".repeat(1000), vec![0; 40]].concat();
    refused(&many, "E0518", "that no instrument writes");
    // The tables of large archives, which claim as many parts as they like.
    let end = good.windows(4).rposition(|mark| mark == b"PK\x05\x06").unwrap();
    let mut large = good[..end].to_vec();
    large.extend_from_slice(b"PK\x06\x07");
    large.extend_from_slice(&[0; 16]);
    large.extend_from_slice(&good[end..]);
    refused(&large, "E0518", "that no instrument writes");
    // An archive that is no X3P.
    refused(&zipped(&[("word/document.xml", b"<a/>".to_vec())]), "E0502", "no height map");
}

/// The billion laughs: nothing of it is expanded, since its document type is refused before.
#[test]
fn xml_entities_are_not_expanded() {
    let mut laughs = "<?xml version=\"1.0\"?>\n<!DOCTYPE l [\n<!ENTITY l0 \"ha\">\n".to_string();
    for i in 1..40 {
        laughs += &format!("<!ENTITY l{i} \"&l{};&l{};\">\n", i - 1, i - 1);
    }
    laughs += "]>\n<p:ISO5436_2><Record1><FeatureType>&l39;</FeatureType></Record1></p:ISO5436_2>";
    refused(&X3p { change: Some(laughs), ..X3p::small() }.bytes(), "E0518", "document type");
    let file = "<!DOCTYPE a [<!ENTITY x SYSTEM \"file:///etc/passwd\">]><a>&x;</a>".to_string();
    refused(&X3p { change: Some(file), ..X3p::small() }.bytes(), "E0518", "document type");
    let many = format!("<a>{}</a>", (0..20_000).map(|i| format!("<b{i}/>")).collect::<String>());
    refused(&X3p { change: Some(many), ..X3p::small() }.bytes(), "E0518", "more elements");
}

/// The lists of HDF5 made to point at themselves: the group's tree, its symbol node, an object header, its continuation.
#[test]
fn hdf5_loops_end() {
    let whole = made("fringes.datx");
    let starts = |mark: &[u8]| -> Vec<usize> {
        (0..whole.len() - mark.len()).filter(|at| whole[*at..].starts_with(mark)).collect()
    };
    let point = |at: usize, to: usize| {
        let mut bytes = whole.clone();
        bytes[at..at + 8].copy_from_slice(&(to as u64).to_le_bytes());
        bytes
    };
    let (trees, nodes) = (starts(b"TREE"), starts(b"SNOD"));
    assert!(trees.len() >= 3 && nodes.len() >= 3, "the file has the old lists of groups");
    let mut tried = 0;
    for tree in &trees {
        // Siblings left and right, first child; level one says that the child is a tree again.
        for field in [8, 16, 32] {
            for level in [0_u8, 1, 255] {
                for to in [*tree, trees[0], nodes[0]] {
                    let mut bytes = point(tree + field, to);
                    bytes[tree + 5] = level;
                    let _ = inspect(&bytes, "loop", None, None);
                    tried += 1;
                }
            }
        }
    }
    for node in &nodes {
        // The object header of the first entry.
        for to in trees.iter().chain(&nodes).chain(&[96, 0, whole.len()]) {
            let _ = inspect(&point(node + 16, *to), "loop", None, None);
            tried += 1;
        }
    }
    // Every word of the first 4096 bytes that could be an address, pointed at the root's header.
    for at in (8..4096.min(whole.len() - 8)).step_by(8) {
        let _ = inspect(&point(at, 96), "loop", None, None);
        let _ = inspect(&point(at, at), "loop", None, None);
        tried += 2;
    }
    assert!(tried > 1000);
}

/// Nothing outside the file is read, whatever it says of itself: `fringes.datx` and `make.py` stand beside these.
#[test]
fn hdf5_does_not_leave_its_file() {
    refused(&made("in_another_file.datx"), "E0513", "without heights");
    refused(&made("in_itself.datx"), "E0513", "without heights");
    refused(&made("raw_in_another_file.datx"), "E0518", "damaged HDF5");
}

/// Headers that say more than is there, in every format: refused before anything of that size is allocated.
#[test]
fn lying_dimensions_are_refused_before_memory_is_asked_for() {
    for (name, text) in all().iter().filter_map(|(name, bytes)| Some((name, std::str::from_utf8(bytes).ok()?))) {
        let lie = text
            .replace("10 20 3 2", "10 20 4096 4096")
            .replace("GRD 3 2", "GRD 4096 4096")
            .replace("\n3 2 0.5", "\n4096 4096 0.5")
            .replace("NumPoints = 3", "NumPoints = 8000000");
        if lie != *text {
            let problem = content(lie.as_bytes(), name).expect_err("a refusal");
            assert!(matches!(problem.code.as_str(), "E0501" | "E0503"), "{name}: {}", problem.message);
        }
    }
    // HDF5: both sides of the data set, wherever they stand, made as large as may be and larger. In one file the heights
    // stand in one piece, in the other in four, and those that are not there would be taken for zeros.
    let sides: Vec<u8> = [3_u64, 4].into_iter().flat_map(u64::to_le_bytes).collect();
    for name in ["fringes.datx", "packed.h5"] {
        let whole = made(name);
        let places: Vec<usize> = (0..whole.len() - 16).filter(|at| whole[*at..].starts_with(&sides)).collect();
        assert!(!places.is_empty(), "the sides stand in the file");
        for (rows, columns) in [(4096_u64, 4096_u64), (1 << 31, 1 << 31), (u64::MAX, u64::MAX), (0, 4), (3, 5), (6, 8)]
        {
            let mut bytes = whole.clone();
            for at in &places {
                bytes[*at..at + 8].copy_from_slice(&rows.to_le_bytes());
                bytes[at + 8..at + 16].copy_from_slice(&columns.to_le_bytes());
            }
            // A fifth column stands in the pieces of the second file, which are three wide each.
            if (rows, columns, name) == (3, 5, "packed.h5") {
                continue;
            }
            let problem = read(&bytes, "map").expect_err("a refusal");
            assert!(matches!(problem.code.as_str(), "E0501" | "E0503" | "E0504" | "E0518"), "{}", problem.message);
        }
    }
    // Heights that were never written.
    refused(&made("never_written.datx"), "E0518", "nothing but zeros");
}

/// What a fuzzer does to a file: bytes changed, pieces taken out, doubled, and brought from another file.
fn mutated(seed: &[u8], other: &[u8], changes: &[(u8, u16, u16, u8)]) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for (what, at, length, value) in changes {
        if bytes.is_empty() {
            break;
        }
        let at = usize::from(*at) * bytes.len() / 65536;
        let end = (at + usize::from(*length) % 64).min(bytes.len());
        match what % 7 {
            0 => bytes[at] = *value,
            1 => bytes[at] ^= 1 << (value % 8),
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..end)),
            4 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
            5 => {
                let from = usize::from(*value) * other.len() / 256;
                let piece = other[from..(from + end - at).min(other.len())].to_vec();
                bytes.splice(at..end, piece);
            }
            // Numbers at the borders of their types.
            _ => {
                let border: &[u8] = match value % 4 {
                    0 => &[0xFF; 8],
                    1 => &[0xFF, 0xFF, 0xFF, 0x7F],
                    2 => &[0; 8],
                    _ => b"99999999999",
                };
                let end = (at + border.len()).min(bytes.len());
                bytes.splice(at..end, border.iter().copied());
            }
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutated_files_are_read_or_refused(
        which in any::<prop::sample::Index>(),
        other in any::<prop::sample::Index>(),
        changes in prop::collection::vec(any::<(u8, u16, u16, u8)>(), 1..12),
        stated in any::<bool>(),
    ) {
        let files = FILES.with(std::clone::Clone::clone);
        let (name, seed) = which.get(&files);
        let bytes = mutated(seed, &other.get(&files).1, &changes);
        let scale = |value: f64| stated.then_some(value);
        if let Err(problem) = inspect(&bytes, "mutated", scale(1e-9), scale(1e-3)) {
            prop_assert!(!problem.message.is_empty() && problem.message.len() < 500, "{name}: {}", problem.message);
            let rust = ["Some(", "None", "Err(", "unwrap", "f64", "usize", "::", "panicked"];
            prop_assert!(!rust.iter().any(|word| problem.message.contains(word)), "{name}: {}", problem.message);
        }
    }

    #[test]
    fn any_bytes_behind_a_known_beginning_are_read_or_refused(
        which in any::<prop::sample::Index>(),
        kept in 4_usize..200,
        bytes in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let files = FILES.with(std::clone::Clone::clone);
        let (_, seed) = which.get(&files);
        let _ = inspect(&[&seed[..kept.min(seed.len())], &bytes].concat(), "any", Some(1e-9), Some(1e-3));
    }

    #[test]
    fn any_table_is_read_or_refused(text in "[xyz0-9 ,;\t\n.eE+nadm()#-]{0,300}") {
        let _ = inspect(text.as_bytes(), "table", Some(1e-9), Some(1e-3));
        let _ = inspect(format!("1 2 3\n{text}").as_bytes(), "table", None, None);
    }
}

thread_local! {
    static FILES: Vec<(&'static str, Vec<u8>)> = all();
}
