//! The readers of Zygo's text exports.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = polishc::height_map::zygo_text::read(text, "fuzz");
    }
});
