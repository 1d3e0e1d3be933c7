//! Makes the man pages: `cargo run --example make_man -- DIR`. For those who package polishc.
#![allow(clippy::disallowed_methods, reason = "this program writes files, by hand")]

fn main() -> std::io::Result<()> {
    let folder = std::env::args_os().nth(1).unwrap_or_else(|| "out/man".into());
    std::fs::create_dir_all(&folder)?;
    clap_mangen::generate_to(polishc::cli::command(), folder)
}
