//! The binary: see `polishc::cli`.

fn main() -> std::process::ExitCode {
    polishc::cli::run(std::env::args_os())
}
