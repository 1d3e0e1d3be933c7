//! Bad input through the program itself: exit status 1, the code, and nothing written.
#![allow(clippy::disallowed_methods, reason = "these tests are about files")]

mod common;

use common::TestFiles;
use polishc::source::FileProvider;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder of its own for one test, gone when the test ends.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Folder {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("polishc-bad-input-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(path.join("project")).expect("a writable temporary folder");
        let folder = Folder(path.canonicalize().expect("the folder just made"));
        folder.put("project/shop.polish", include_str!("ui/lib/shop.polish"));
        for data in ["good.dat", "spot.dat"] {
            folder.put(&format!("project/{data}"), generated(data));
        }
        folder
    }

    fn put(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.0.join(name), content).expect("a writable folder");
    }

    /// The good job with one line changed.
    fn job(&self, line: &str, instead: &str) {
        assert!(JOB.contains(line), "the job has the line `{line}`");
        self.put("project/job.polish", JOB.replace(line, instead));
    }

    /// The good job with another map in its error.
    fn job_with_map(&self, fields: &str) {
        self.job("shop.flat", &format!("shop.flat with {{ error: shop.map with {{ {fields} }} }}"));
    }

    fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_polishc"))
            .args(arguments)
            .current_dir(self.0.join("project"))
            .output()
            .expect("polishc starts")
    }

    /// All files of the project, by name, with their content.
    fn files(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let mut todo = vec![self.0.clone()];
        let mut found = Vec::new();
        while let Some(path) = todo.pop() {
            if path.is_dir() {
                todo.extend(std::fs::read_dir(&path).expect("a folder").map(|entry| entry.expect("an entry").path()));
            }
            // Of a huge file its length is enough.
            let small = std::fs::metadata(&path).is_ok_and(|meta| meta.is_file() && meta.len() < 1 << 20);
            let content = if small { std::fs::read(&path).expect("a readable file") } else { Vec::new() };
            found.push((path, content));
        }
        found.sort();
        found
    }

    /// Builds the job, which must fail with `code` and leave everything as it was. What it says is given back.
    #[track_caller]
    fn refuses(&self, code: &str) -> String {
        self.refuses_with(code, &["build", "job.polish"])
    }

    #[track_caller]
    fn refuses_with(&self, code: &str, arguments: &[&str]) -> String {
        let before = self.files();
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).expect("messages are UTF-8");
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(&format!("error[{code}]")), "{code} is not said: {said}");
        assert_eq!(String::from_utf8_lossy(&output.stdout), "", "a failed build tells of nothing");
        assert!(before == self.files(), "files changed");
        said
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

fn generated(name: &str) -> Vec<u8> {
    TestFiles::default().read(name, u64::MAX).expect("data made for the tests")
}

const JOB: &str = r#"language 1

use "shop.polish"

job flat {
    workpiece: shop.flat
    tool:      shop.wheel
    path:      shop.lines
    dwell:     shop.rule
    robot:     shop.arm
    target:    shop.program
    unchecked: [arm, cell, cable, fixture]
}
"#;

#[test]
fn the_job_itself_is_good() {
    let folder = Folder::new();
    folder.put("project/job.polish", JOB);
    let output = folder.run(&["build", "job.polish"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    for file in ["Flat50.mod", "Flat50_001.mod", "result.json"] {
        assert!(folder.0.join("project/out/flat").join(file).is_file(), "{file}");
    }
}

#[test]
fn maps_that_are_none() {
    for (data, more, code) in [
        ("truncated.dat", "", "E0503"),
        ("empty.dat", "", "E0503"),
        ("short_header.dat", "", "E0503"),
        ("lying.dat", "", "E0503"),
        ("dark.dat", "", "E0504"),
        ("noise.dat", "", "E0502"),
        ("huge.npy", ", pixel: 1 mm, unit: 1 nm", "E0501"),
        ("all_nan.npy", ", pixel: 1 mm, unit: 1 nm", "E0508"),
        ("small.dat", "", "E0509"),
        ("hole.dat", "", "E0510"),
        ("good.npy", "", "E0506"),
        ("filter.int", "", "E0513"),
        ("waves.csv", "", "E0514"),
        ("remark.csv", "", "E0515"),
        ("probed.xyz", "", "E0516"),
        ("edited.x3p", "", "E0517"),
        ("damaged.x3p", "", "E0518"),
        ("trace.csv", "", "E0519"),
    ] {
        let folder = Folder::new();
        folder.put(&format!("project/{data}"), generated(data));
        folder.job_with_map(&format!("file: \"{data}\"{more}"));
        let said = folder.refuses(code);
        assert!(said.contains("job.polish:6:"), "{data}: the place is the line of the job: {said}");
    }
    let folder = Folder::new();
    folder.job_with_map("file: \"not_there.dat\"");
    folder.refuses("E0500");
    folder.put("project/longer.dat", [generated("good.dat"), vec![0; 100]].concat());
    folder.job_with_map("file: \"longer.dat\"");
    folder.refuses("E0503");
    // Every length of the header and some of the data: never a panic, always the same answer.
    let good = generated("good.dat");
    for length in (0..900).step_by(73) {
        folder.put("project/cut.dat", &good[..length]);
        folder.job_with_map("file: \"cut.dat\"");
        let output = folder.run(&["build", "job.polish"]);
        assert_eq!(output.status.code(), Some(1), "{length} bytes");
    }
}

/// Files of a few kilobytes that ask for gigabytes: each is refused within the address space that the largest map takes
/// (its file of 256 MiB twice, and three copies of its heights).
#[cfg(unix)]
#[test]
fn bombs_stay_within_their_memory() {
    let folder = Folder::new();
    let zipped = |parts: &[(&str, Vec<u8>)]| {
        let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        for (name, bytes) in parts {
            archive.start_file(*name, zip::write::SimpleFileOptions::default()).expect("a part");
            std::io::Write::write_all(&mut archive, bytes).expect("its bytes");
        }
        archive.finish().expect("an archive").into_inner()
    };
    let description = |heights: &str| {
        format!(
            "<a><Record1><FeatureType>SUR</FeatureType><Axes><CX><AxisType>I</AxisType><Increment>1e-3</Increment></CX>\
             <CY><AxisType>I</AxisType><Increment>1e-3</Increment></CY><CZ><AxisType>A</AxisType><DataType>D</DataType></CZ>\
             </Axes></Record1><Record3><MatrixDimension><SizeX>2</SizeX><SizeY>2</SizeY><SizeZ>1</SizeZ></MatrixDimension>\
             {heights}</Record3></a>"
        )
        .into_bytes()
    };
    let linked = "<DataLink><PointDataLink>data.bin</PointDataLink></DataLink>";
    let mut sdf = b"bISO-1.0".to_vec();
    sdf.extend_from_slice(&[b' '; 34]);
    sdf.extend_from_slice(&[0xFF, 0xFF, 0x00, 0x01]);
    for scale in [1e-3_f64, 1e-3, 1e-9, 0.0] {
        sdf.extend_from_slice(&scale.to_le_bytes());
    }
    sdf.extend_from_slice(&[0, 7, 0]);
    // The sides of the data set, 3 and 4, wherever they stand.
    let mut hdf5 = std::fs::read("tests/metrology/files/packed.h5").expect("a file of the tests");
    let sides: Vec<u8> = [3_u64, 4].into_iter().flat_map(u64::to_le_bytes).collect();
    for at in 0..hdf5.len() - 16 {
        if hdf5[at..].starts_with(&sides) {
            hdf5[at..at + 16].copy_from_slice(&[4096_u64, 4096].map(u64::to_le_bytes).concat());
        }
    }
    for (name, bytes) in [
        ("heights.x3p", zipped(&[("main.xml", description(linked)), ("data.bin", vec![0; 1 << 28])])),
        ("description.x3p", zipped(&[("main.xml", vec![b' '; 1 << 28])])),
        ("list.x3p", zipped(&[("main.xml", description(&"<Datum>1</Datum>".repeat(1 << 22)))])),
        ("short.sdf", sdf),
        ("lying.h5", hdf5),
        ("apart.xyz", b"0 0 1\n1e-9 1e-9 1\n1 1 1\n2e-9 2e-9 1\n".to_vec()),
        ("huge.npy", generated("huge.npy")),
    ] {
        folder.put(name, bytes);
        let output = Command::new("sh")
            .args(["-c", "ulimit -v 1200000 && exec \"$@\"", "sh", env!("CARGO_BIN_EXE_polishc"), "inspect"])
            .args(["--unit", "nm", "--pixel", "1mm"])
            .arg(folder.0.join(name))
            .output()
            .expect("a shell");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{name}: {said}");
        assert!(said.starts_with("error[E05"), "{name}: {said}");
    }
}

#[test]
fn a_map_without_orientation() {
    for field in ["view:     from_tool_side", "up:       plus_y", "positive: high", "quantity: surface"] {
        let folder = Folder::new();
        let shop = include_str!("ui/lib/shop.polish");
        // The first of them belongs to the map.
        folder.put("project/shop.polish", shop.replacen(field, "", 1));
        folder.put("project/job.polish", JOB);
        let said = folder.refuses("E0402");
        let name = field.split(':').next().expect("a name");
        assert!(said.contains(&format!("`{name}`")), "{said}");
    }
}

#[test]
fn units_that_nobody_knows_and_fields_that_this_tool_has_not() {
    let folder = Folder::new();
    folder.job("shop.rule", "shop.rule with { acceleration: 500 mm/fortnight^2 }");
    folder.refuses("E0210");
    folder.job("shop.wheel", "shop.wheel with { precession: 20 }");
    let said = folder.refuses("E0401");
    assert!(said.contains("`precession`"), "{said}");
}

#[test]
fn a_file_that_uses_itself() {
    let folder = Folder::new();
    folder.job("use \"shop.polish\"", "use \"shop.polish\"\nuse \"job.polish\"");
    folder.refuses("E0209");
}

#[test]
fn nesting_without_end() {
    let folder = Folder::new();
    for (open, close) in [("[", "]"), ("(", ")"), ("plane {", "}")] {
        let deep = format!("let deep = {}1{}\n", open.repeat(100_000), close.repeat(100_000));
        folder.put("project/job.polish", format!("{JOB}\n{deep}"));
        let said = folder.refuses("E0110");
        assert!(said.len() < 5000, "the message is buried");
        folder.put("project/job.polish", format!("{JOB}\nlet deep = {}", open.repeat(100_000)));
        folder.refuses("E0110");
    }
}

#[test]
fn random_bytes() {
    let folder = Folder::new();
    folder.put("project/job.polish", generated("noise.dat"));
    folder.refuses("E0204");
    // As text: whatever the bytes say, the compiler answers.
    let mut state = 1_u32;
    for _ in 0..20 {
        let text: String = (0..400)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                char::from(b"{}[]()\":,.+-*/^<>=! \nabjoblet19mm%\\\t|"[(state >> 16) as usize % 37])
            })
            .collect();
        folder.put("project/job.polish", text);
        let output = folder.run(&["build", "job.polish"]);
        assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    }
    assert!(!folder.0.join("project/out").exists());
}

#[test]
fn a_file_of_a_gigabyte() {
    let folder = Folder::new();
    // Sparse: the disk holds nothing of it.
    let huge = std::fs::File::create(folder.0.join("project/huge.dat")).expect("a writable folder");
    huge.set_len(1 << 30).expect("a sparse file");
    folder.job_with_map("file: \"huge.dat\"");
    let said = folder.refuses("E0501");
    assert!(said.contains("1024 MiB"), "{said}");
    let huge = std::fs::File::create(folder.0.join("project/job.polish")).expect("a writable folder");
    huge.set_len(1 << 30).expect("a sparse file");
    folder.refuses("E0204");
}

#[test]
fn a_path_outside_the_project() {
    let folder = Folder::new();
    folder.put("outside.dat", generated("good.dat"));
    folder.job_with_map("file: \"../outside.dat\"");
    folder.refuses("E0205");
    let absolute = folder.0.join("outside.dat").to_string_lossy().replace('\\', "/");
    folder.job_with_map(&format!("file: \"{absolute}\""));
    folder.refuses("E0205");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.0.join("outside.dat"), folder.0.join("project/link.dat")).expect("a link");
        folder.job_with_map("file: \"link.dat\"");
        folder.refuses("E0205");
    }
    folder.put("outside.polish", "language 1\n");
    folder.job("use \"shop.polish\"", "use \"shop.polish\"\nuse \"../outside.polish\"");
    folder.refuses("E0205");
}

/// The good job with another cell.
fn with_cell(folder: &Folder, fields: &str) {
    folder.job("shop.arm", &format!("shop.arm with {{ cell: shop.mrf with {{ {fields} }} }}"));
}

#[test]
fn points_that_the_arm_cannot_reach() {
    let folder = Folder::new();
    with_cell(&folder, "user: frame { at: point { x: 3200 mm, y: 0 mm, z: 640 mm }, rotation: no_rotation }");
    let said = folder.refuses("E0806");
    assert!(said.contains("x 0.000 mm, y -42.000 mm, z 0.000 mm"), "part coordinates: {said}");
    assert!(said.contains("mm from axis 2, the arm does"), "the quantity that failed: {said}");
    with_cell(&folder, "user: frame { at: point { x: 2400 mm, y: 0 mm, z: -300 mm }, rotation: no_rotation }");
    let said = folder.refuses("E0807");
    assert!(said.contains("joint 2 would stand at") && said.contains("x 0.000 mm, y -42.000 mm"), "{said}");
    folder.job("shop.arm", "shop.arm with { wrist_margin: 75 deg }");
    let said = folder.refuses("E0808");
    assert!(said.contains("wrist"), "{said}");
}

#[test]
fn faster_than_a_joint_turns() {
    let folder = Folder::new();
    with_cell(&folder, "travel: lifted { height: 30 mm, speed: 8 m/s }");
    let said = folder.refuses("E0809");
    assert!(said.contains("deg/s") && said.contains("line"), "{said}");
}

#[test]
fn more_points_than_the_limit() {
    let folder = Folder::new();
    folder.job("shop.lines", "shop.lines with { point_step: 4 um, line_pitch: 0.5 um }");
    folder.refuses("E0641");
}

#[test]
fn a_folder_that_cannot_be_written() {
    let folder = Folder::new();
    folder.put("project/job.polish", JOB);
    folder.put("project/file", "no folder");
    // A file is no folder, for anybody: the tests may run as the owner of everything.
    folder.refuses_with("E1201", &["build", "job.polish", "-o", "file/out"]);
    folder.refuses_with("E1201", &["build", "job.polish", "-o", "file"]);
}

#[test]
fn a_failed_build_leaves_the_good_one() {
    let folder = Folder::new();
    folder.put("project/job.polish", JOB);
    assert_eq!(folder.run(&["build", "job.polish"]).status.code(), Some(0));
    folder.job("shop.lines", "shop.lines with { point_step: 4 um, line_pitch: 0.5 um }");
    folder.refuses("E0641");
    folder.job("}\n", "\n    require {\n        result.predicted.rms <= 0.001 nm\n    }\n}\n");
    folder.refuses("E1101");
    // A target that a folder of that name stands in the way of: nothing of the build arrives.
    folder.put("project/job.polish", JOB.replace("shop.program", "shop.program with { module: \"Other\" }"));
    std::fs::create_dir_all(folder.0.join("project/out/flat/Other_001.mod/x")).expect("a folder");
    folder.refuses("E1201");
}

#[test]
fn a_smaller_build_takes_its_old_modules_away() {
    let folder = Folder::new();
    let small = "shop.program with { controller: shop.controller with { module_points: 100 } }";
    folder.job("shop.program", small);
    assert_eq!(folder.run(&["build", "job.polish"]).status.code(), Some(0));
    let out = folder.0.join("project/out/flat");
    assert!(out.join("Flat50_004.mod").is_file());
    std::fs::write(out.join("notes.txt"), "the shop's own").expect("a writable folder");
    folder.put("project/job.polish", JOB);
    assert_eq!(folder.run(&["build", "job.polish"]).status.code(), Some(0));
    assert_eq!(names(&out), ["Flat50.mod", "Flat50_001.mod", "notes.txt", "result.json"]);
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn wrong_command_lines() {
    let folder = Folder::new();
    folder.put("project/job.polish", JOB);
    for arguments in [
        &["build"][..],
        &["build", "job.polish", "--nonsense"],
        &["polish", "job.polish"],
        &["build", "job.polish", "--emit", "magic"],
        &["build", "job.polish", "--threads", "many"],
        &["verify", "Flat50.mod"],
        &["inspect", "good.dat", "--pixel", "wide"],
        &["explain", "E9999"],
    ] {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(!output.stderr.is_empty(), "{arguments:?} says why");
    }
    assert!(!folder.0.join("project/out").exists());
}
