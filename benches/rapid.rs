//! RAPID: emission, reading, and the whole proof of 56,703 points, beside a plain copy of the same bytes in the same round.
//! Prints megabytes a second on one thread and on all, the best of several rounds, and how many copies each costs.
#![allow(clippy::disallowed_methods, clippy::print_stdout, reason = "a bench reads the clock and says what it found")]

#[path = "../tests/program/mod.rs"]
mod program;

use polishc::job::Plane;
use polishc::motion::Purpose;
use polishc::verify::rapid::reader;
use polishc::{target, verify};
use program::{curved, job_with, plan, raster};
use std::hint::black_box;
use std::time::Instant;

const ROUNDS: usize = 9;

fn main() {
    let job = job_with(&[]);
    // 597 lines of 95 points, less a dozen: as many as the 340 mm flat has, within a few.
    let motion = plan(&job, curved(raster(597, 95)), Purpose::Polish);
    let draft = target::emit("bench", &motion, &job).expect("a program");
    let program = draft.0;
    let bytes: usize = program.files.iter().map(|file| file.bytes.len()).sum();
    println!("{} points, {} files, {:.3} MB", motion.position.len(), program.files.len(), bytes as f64 * 1e-6);

    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let mut best = [f64::INFINITY; 4];
        for _ in 0..ROUNDS {
            let mut time = |which: usize, work: &mut (dyn FnMut() + Send)| {
                let start = Instant::now();
                pool.install(work);
                best[which] = best[which].min(start.elapsed().as_secs_f64());
            };
            time(0, &mut || {
                black_box(program.files.iter().map(|file| black_box(&file.bytes).clone()).collect::<Vec<_>>());
            });
            time(1, &mut || {
                black_box(target::emit("bench", black_box(&motion), &job).expect("a program"));
            });
            time(2, &mut || {
                for file in &program.files {
                    black_box(reader::read(black_box(&file.bytes)).expect("a module"));
                }
            });
            time(3, &mut || {
                assert!(verify::check(black_box(&program), &motion, &job, &Plane {}).is_empty());
            });
        }
        println!("{threads} threads:");
        for (name, seconds) in ["copy", "emit", "read (one thread)", "read, replay, compare"].iter().zip(best) {
            let rate = bytes as f64 * 1e-6 / seconds;
            println!("  {name:<22} {:8.2} ms {rate:8.0} MB/s  {:6.1} copies", seconds * 1e3, seconds / best[0]);
        }
    }
}
