//! The reader of Zygo MetroPro maps.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = polishc::height_map::metropro::read(data, "fuzz");
});
