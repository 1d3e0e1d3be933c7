//! The reader of X3P surfaces, and the ZIP and XML under it.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = polishc::height_map::x3p::read(data, "fuzz");
});
