//! The parser: any text gives a tree and diagnostics.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(text) = std::str::from_utf8(data) {
        let _ = polishc::syntax::parse(polishc::source::FileId(0), text);
    }
});
