//! A job of a 60 mm part that a test can turn every way, its program, and what reads that program: for the tests that
//! prove the whole chain from the job's text to the program's text.
#![allow(dead_code, reason = "each test crate uses its own part")]

pub mod forms;
pub mod krl_text;
pub mod program_text;
pub mod rigid;

use polishc::diagnostics::render::{self, Style};
use polishc::session::{self, Compilation, Planned, Request, Unwatched};
use polishc::source::MemoryFiles;
use program_text::ProgramText;
use rigid::Frame;
use std::collections::BTreeMap;

/// A frame as a test states it: mm, and degrees about z, y, x of `zyx_intrinsic`.
#[derive(Clone, Copy, Debug)]
pub struct FrameNumbers {
    pub at: [f64; 3],
    pub zyx: [f64; 3],
}

impl FrameNumbers {
    pub fn frame(&self) -> Frame {
        Frame::zyx(self.at, self.zyx)
    }

    fn text(&self) -> String {
        let ([x, y, z], [about_z, about_y, about_x]) = (self.at, self.zyx);
        format!(
            "at: point {{ x: {x} mm, y: {y} mm, z: {z} mm }}, rotation: zyx_intrinsic {{ about_z: {about_z} deg, \
             about_y: {about_y} deg, about_x: {about_x} deg }}"
        )
    }
}

/// Base and user frame in the world, object frame in the user frame, tool frame in the flange.
#[derive(Clone, Copy, Debug)]
pub struct Frames {
    pub base: FrameNumbers,
    pub user: FrameNumbers,
    pub object: FrameNumbers,
    pub tool: FrameNumbers,
}

/// A cell in which no frame is the identity and the tool stands askew on the flange.
pub const ASKEW: Frames = Frames {
    base: FrameNumbers { at: [100.0, 50.0, 20.0], zyx: [4.0, 0.3, -0.2] },
    user: FrameNumbers { at: [1500.0, -150.0, 600.0], zyx: [-11.0, 1.0, 0.5] },
    object: FrameNumbers { at: [150.0, 250.0, 60.0], zyx: [20.0, -0.7, -1.5] },
    tool: FrameNumbers { at: [40.0, -3.0, 330.0], zyx: [2.0, 17.0, -1.0] },
};

/// The part frame in the world.
pub fn world_part(frames: &Frames) -> Frame {
    frames.user.frame().then(&frames.object.frame())
}

/// The job. `@word@` is replaced.
const JOB: &str = r#"language 1

use std.robots.abb.irb6700_200_260
use std.robots.kuka.kr210_r2700_2
use std.controllers.irc5
use std.controllers.krc4
use std.materials.fused_silica

let cell = robot_cell {
    base:   frame { @base@ }
    user:   frame { @user@ }
    object: frame { @object@ }
    tcp: tcp_numbers {
        @tool@
        load: { mass: 60 kg, centre: point { x: 10 mm, y: 0 mm, z: 140 mm } }
    }
    home:    @home@
    travel:  lifted { height: 40 mm, speed: 50 mm/s }
    process: manual { interlock: "relay K1" }
}

job trial {
    workpiece {
        part:     "B60"
        form:     @form@
        edge:     circle { diameter: 60 mm }
        clear:    circle { diameter: 55 mm }
        material: fused_silica
        error: height_map {
            file:     "map.npy"
            quantity: @quantity@
            positive: @positive@
            view:     @view@
            up:       @up@
            subtract: []
            pixel:    1 mm
            unit:     1 nm
            centre:   @centre@
        }
    }

    tool: mrf_wheel {
        diameter: 100 mm
        speed:    200 rpm
        rotation: forward
        gap:      @gap@
        azimuth:  @azimuth@
        influence: gaussian { peak: 20 nm/s, sigma: 4 mm, diameter: 20 mm }
    }

    path: @path@

    dwell: corrective {
        removal_fraction: 90 %
        piston:           free { at_most: 400 nm }
        feed:             0.2 mm/s .. 60 mm/s
        acceleration:     500 mm/s^2
    }

    robot:  @arm@ with { cell: cell }
    target: @target@
    unchecked: [arm, cell, cable, fixture]
}
"#;

/// The path of most tests, with words of its own.
const RASTER: &str = "raster {
        over:       circle { diameter: 96 mm }
        point_step: @step@
        line_pitch: @pitch@
        direction:  @direction@
        lines:      @lines@
    }";

/// The words of [`JOB`] that most tests leave alone.
const USUAL: &[(&str, &str)] = &[
    ("form", "plane"),
    ("quantity", "surface"),
    ("positive", "high"),
    ("view", "from_tool_side"),
    ("up", "plus_y"),
    ("centre", "frame_centre"),
    ("gap", "1 mm"),
    ("azimuth", "0 deg"),
    ("path", RASTER),
    ("step", "1 mm"),
    ("pitch", "1 mm"),
    ("direction", "0 deg"),
    ("lines", "serpentine"),
    ("arm", "irb6700_200_260"),
    ("home", "[0 deg, -20 deg, 30 deg, 0 deg, 70 deg, 0 deg]"),
    ("target", "rapid { controller: irc5 with { module_bytes: 1000000 }, module: \"Trial\", frames: in_program }"),
];

/// The words that make the job one for a KUKA. Its files hold what a module of the other job holds.
pub const KRL: [(&str, &str); 3] = [
    ("arm", "kr210_r2700_2"),
    ("home", "[0 deg, -110 deg, 120 deg, 0 deg, 70 deg, 0 deg]"),
    (
        "target",
        "krl { controller: krc4 with { file_lines: 6000, file_bytes: 1000000 }, module: \"Trial\", frames: in_program }",
    ),
];

/// The same with linear moves.
pub const KRL_LINEAR: [(&str, &str); 3] = [
    KRL[0],
    KRL[1],
    (
        "target",
        "krl { controller: krc4 with { file_lines: 20000, file_bytes: 1000000 }, module: \"Trial\", frames: in_program, motion: linear }",
    ),
];

/// The job's text with `frames`, and `changes` of the words in [`USUAL`].
pub fn job_text(frames: &Frames, changes: &[(&str, &str)]) -> String {
    let mut words: BTreeMap<&str, String> = USUAL.iter().map(|(word, value)| (*word, value.to_string())).collect();
    for (word, value) in changes {
        assert!(words.insert(word, value.to_string()).is_some(), "the job has no word `{word}`");
    }
    for (word, frame) in
        [("base", frames.base), ("user", frames.user), ("object", frames.object), ("tool", frames.tool)]
    {
        words.insert(word, frame.text());
    }
    let job = JOB.replace("@path@", &words["path"]);
    words.iter().fold(job, |text, (word, value)| text.replace(&format!("@{word}@"), value))
}

/// A NumPy array of `<f8`, version 1: what numpy.save writes, row 0 first. Values row by row from the picture's upper
/// left corner.
pub fn npy(columns: usize, values: &[f64]) -> Vec<u8> {
    let rows = values.len() / columns;
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}");
    // Magic, version and length take 10 bytes; with the header and its newline, a multiple of 64.
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Compiles a job of one text and one map all the way. It must succeed.
pub fn compile(text: String, map: Vec<u8>) -> Compilation {
    compile_with(text, map, Vec::new())
}

/// The same of a job that names more files.
pub fn compile_with(text: String, map: Vec<u8>, more: Vec<(String, Vec<u8>)>) -> Compilation {
    let files = [("trial/trial.polish".to_string(), text.into_bytes()), ("trial/map.npy".to_string(), map)];
    let files = MemoryFiles(files.into_iter().chain(more).collect());
    let done = session::compile(&files, &Request::new("trial/trial.polish"), &Unwatched);
    assert!(!done.failed(), "{}", render::render(&done.sources, &done.diagnostics, Style::Human, false));
    done
}

/// The text of a job's program.
pub fn program_text(planned: &Planned) -> ProgramText {
    let program = planned.program.as_ref().expect("a program");
    let files: Vec<(String, Vec<u8>)> = program.files.iter().map(|f| (f.name.clone(), f.bytes.clone())).collect();
    ProgramText::read(&files)
}
