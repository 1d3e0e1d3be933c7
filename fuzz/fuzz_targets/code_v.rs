//! The reader of CODE V grids.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = polishc::height_map::code_v::read(text, "fuzz");
    }
});
