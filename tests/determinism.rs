//! The same job gives the same bytes: with 1, 2 and 8 threads, in this process and by the tool, in another folder, and
//! whatever the processor can do.
//!
//! Jobs: `flat_340` with its lines 2 mm apart (14,177 points, 5 modules), and tests/jobs/real_map.polish with a generated
//! map of a 50 mm part that has a hole to fill (12,043 points, 4 modules), and the same for a KUKA. Compared are all files, `result.json` among
//! them; that they hold what they should is other tests' business.
//!
//! What may depend on the processor, found by going through the dependencies of the binary:
//!
//! * `blake3` chooses SSE2, SSE4.1, AVX2 or AVX-512 code when it runs. It hashes whole numbers: the digest is one.
//! * `libm` chooses the processor's fused multiply-add when it runs, for `fma` alone, whose result IEEE 754 fixes to the
//!   last bit.
//! * `nalgebra` brings `matrixmultiply`, which chooses AVX and FMA kernels when it runs, with other roundings. Only products
//!   of matrices whose size the compiler does not know reach it; the crate has none (a test below).
//! * `memchr` (in `pest` and `serde_json`) searches bytes. `realfft`, `faer` and `rs-opw-kinematics` are only in tests and
//!   benches.
//! * The platform's mathematics (sine, exponential) may differ between machines and processors: `clippy.toml` bans
//!   them, and the tool does not even link them (a test below).
//! * The compiler itself neither fuses nor reorders floating-point operations, whatever `target-cpu` says.
//!
//! Measured once by hand, x86-64, rustc 1.95.0: the tool built for release with `-C target-feature=-avx,-avx2,-fma`, with
//! `-C target-cpu=native` (AVX-512; fourteen times as many instructions on registers of 256 bits, no fused multiply-add),
//! and in the dev profile wrote the same bytes: all 26 files of `flat_340`, and (the two release builds) all of `real_map`
//! with the MetroPro sample.
#![allow(clippy::disallowed_methods, reason = "tests read files and run the tool")]

mod common;

use common::TestFiles;
use polishc::diagnostics::render::{self, Style};
use polishc::height_map::metropro::{self, Settings};
use polishc::report::ResultFile;
use polishc::session::{self, Request, Unwatched};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// All files of a build, by name.
type Files = BTreeMap<String, Vec<u8>>;

/// A job with what it is given on the command line.
struct Job {
    /// A folder that holds all the job needs, relative to the tree.
    folder: &'static str,
    file: &'static str,
    set: String,
    /// Where the job's map lies in memory.
    map: Option<(String, Vec<u8>)>,
}

fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("determinism").join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("an old folder goes");
    }
    std::fs::create_dir_all(&folder).expect("a new folder");
    folder
}

/// A 50 mm part on 240 x 240 pixels of 0.22 mm, some hundred nanometres, with a hole of nine pixels to fill.
fn map() -> Vec<u8> {
    let pixel = 0.22e-3;
    let mut heights = Vec::new();
    for row in 0..240 {
        for column in 0..240 {
            let (x, y) = ((f64::from(column) - 119.5) * pixel, (119.5 - f64::from(row)) * pixel);
            let hole = (100..103).contains(&row) && (130..133).contains(&column);
            let inside = x * x + y * y < 25.2e-3 * 25.2e-3;
            let height = 2e-4 * (x * x - y * y) + 30e-9 * (x / 3e-3).sin() * (y / 4e-3).cos();
            heights.push(if inside && !hole { height } else { f64::NAN });
        }
    }
    metropro::write(240, &heights, &Settings::fizeau(pixel)).expect("heights that fit the format")
}

fn flat() -> Job {
    Job { folder: "examples/flat_340", file: "flat_340.polish", set: "pitch=2mm".into(), map: None }
}

/// `map` lies on the disk for the tool, and by the same name in memory; tests that run at the same time each have their own.
fn real(folder: &str) -> Job {
    let path = scratch(folder).join("generated.dat");
    std::fs::write(&path, map()).expect("a map");
    let name = path.to_str().expect("UTF-8").to_string();
    Job { folder: "tests/jobs", file: "real_map.polish", set: format!("map={name}"), map: Some((name, map())) }
}

/// The same part on a KUKA.
fn kuka() -> Job {
    let mut job = real("map_kuka");
    job.file = "kuka_map.polish";
    job
}

/// Builds with the tool in the working directory `here`.
fn by_the_tool(job: &Job, here: &Path, path: &str, name: &str, more: &[&str], variables: &[(&str, &str)]) -> Files {
    let out = scratch(name);
    let run = Command::new(env!("CARGO_BIN_EXE_polishc"))
        .args(["build", path, "--set", &job.set, "-o", out.to_str().expect("UTF-8")])
        .args(more)
        .current_dir(here)
        .envs(variables.iter().copied())
        .output()
        .expect("the tool runs");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let files: Files = std::fs::read_dir(&out)
        .expect("the output")
        .map(|entry| entry.expect("an entry").path())
        .map(|path| {
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            (name, std::fs::read(path).expect("a readable file"))
        })
        .collect();
    assert!(files.len() >= 3 && files.contains_key("result.json"), "{:?}", files.keys());
    files
}

/// Builds in this process, on a pool of so many threads.
fn in_process(job: &Job, threads: usize) -> Files {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    let mut files = TestFiles::default();
    let (word, mut value) = job.set.split_once('=').map(|(a, b)| (a.to_string(), b.to_string())).expect("NAME=VALUE");
    if let Some((_, bytes)) = &job.map {
        // In memory a project has no paths from the root.
        value = format!("{}/generated.dat", job.folder);
        files.extra.insert(value.clone(), bytes.clone());
    }
    let mut request = Request::new(&format!("{}/{}", job.folder, job.file));
    request.sets.push((word, value));
    let done = pool.install(|| session::compile(&files, &request, &Unwatched));
    assert!(!done.failed(), "{}", render::render(&done.sources, &done.diagnostics, Style::Human, false));
    let planned = &done.jobs[0];
    let program = planned.program.as_ref().expect("a program");
    let mut out: Files = program.files.iter().map(|f| (f.name.clone(), f.bytes.clone())).collect();
    let result = planned.result.clone().expect("a result");
    let whole = ResultFile { polishc: env!("CARGO_PKG_VERSION"), jobs: vec![result] };
    out.insert("result.json".into(), (serde_json::to_string_pretty(&whole).expect("JSON") + "\n").into_bytes());
    out
}

/// Equal names and bytes; the first difference is shown, not megabytes.
fn assert_same(a: &Files, b: &Files, what: &str) {
    let names = |files: &Files| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(a), names(b), "{what}: files");
    for (name, bytes) in a {
        let other = &b[name];
        if bytes != other {
            let lines = |bytes: &[u8]| String::from_utf8_lossy(bytes).lines().map(str::to_string).collect::<Vec<_>>();
            let (mine, theirs) = (lines(bytes), lines(other));
            let differ: Vec<_> = mine.iter().zip(&theirs).enumerate().filter(|(_, (a, b))| a != b).collect();
            let (i, (one, two)) = differ.first().expect("a line differs");
            panic!("{what}: {} lines of {name} differ, the first is {}:\n{one}\n{two}", differ.len(), i + 1);
        }
    }
}

fn same_with_any_threads(job: &Job, name: &str) {
    let here = Path::new(".");
    let path = format!("{}/{}", job.folder, job.file);
    let one = by_the_tool(job, here, &path, &format!("{name}_1"), &["--threads", "1"], &[]);
    for threads in ["2", "8"] {
        let more = by_the_tool(job, here, &path, &format!("{name}_{threads}"), &["--threads", threads], &[]);
        assert_same(&one, &more, &format!("{name}, {threads} threads"));
    }
    for threads in [1, 2, 8] {
        assert_same(&one, &in_process(job, threads), &format!("{name}, {threads} threads in this process"));
    }
}

#[test]
fn threads_do_not_change_flat_340() {
    same_with_any_threads(&flat(), "flat");
}

#[test]
fn threads_do_not_change_a_measured_part() {
    same_with_any_threads(&real("map"), "real");
}

#[test]
fn threads_do_not_change_a_krl_program() {
    same_with_any_threads(&kuka(), "kuka");
}

/// The same job, copied elsewhere and built from there, by a path of another kind.
#[test]
fn the_folder_does_not_matter() {
    let job = flat();
    let path = format!("{}/{}", job.folder, job.file);
    let here = by_the_tool(&job, Path::new("."), &path, "folder_here", &[], &[]);
    let elsewhere = scratch("else where").join("deeper");
    std::fs::create_dir_all(&elsewhere).expect("a folder");
    for entry in std::fs::read_dir(job.folder).expect("the example") {
        let from = entry.expect("an entry").path();
        std::fs::copy(&from, elsewhere.join(from.file_name().expect("a name"))).expect("a copy");
    }
    assert_same(&here, &by_the_tool(&job, &elsewhere, job.file, "folder_there", &[], &[]), "another folder");
    let absolute = elsewhere.join(job.file);
    let absolute = absolute.to_str().expect("UTF-8");
    assert_same(&here, &by_the_tool(&job, Path::new("."), absolute, "folder_whole", &[], &[]), "a whole path");
}

/// glibc chooses its sine and exponential by the processor, and can be told to do as if there were no AVX: nothing of
/// that may reach a program.
#[cfg(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64"))]
#[test]
fn the_platforms_vector_code_does_not_matter() {
    let job = flat();
    let path = format!("{}/{}", job.folder, job.file);
    let as_it_is = by_the_tool(&job, Path::new("."), &path, "avx", &[], &[]);
    let tunables =
        [("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX,-AVX2,-FMA,-FMA4,-AVX512F,-AVX512VL,-AVX_Fast_Unaligned_Load")];
    let without = by_the_tool(&job, Path::new("."), &path, "no_avx", &[], &tunables);
    assert_same(&as_it_is, &without, "without AVX in glibc");
}

/// The tool does not link the platform's mathematics at all.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
#[test]
fn the_tool_does_not_link_the_platforms_mathematics() {
    let bytes = std::fs::read(env!("CARGO_BIN_EXE_polishc")).expect("the tool");
    let has = |name: &[u8]| bytes.windows(name.len()).any(|window| window == name);
    assert!(has(b"libc.so.6"), "the names of linked libraries stand in the file");
    assert!(!has(b"libm.so.6"), "something calls the platform's mathematics");
}

/// Products of matrices of a size known only at run time would go to kernels that choose their instructions by the processor.
#[test]
fn no_matrix_is_sized_at_run_time() {
    let mut todo = vec![PathBuf::from("src")];
    let mut wrong = Vec::new();
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            todo.extend(std::fs::read_dir(&path).expect("a folder").map(|entry| entry.expect("an entry").path()));
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("a readable file");
        for word in ["DMatrix", "DVector", "Dyn>", "OMatrix", "MatrixXx", "matrixmultiply"] {
            if text.contains(word) {
                wrong.push(format!("{}: {word}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}
