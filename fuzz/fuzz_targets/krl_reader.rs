//! The reader of KRL modules.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = polishc::verify::krl::reader::read_source(data);
    let _ = polishc::verify::krl::reader::read_data(data);
});
