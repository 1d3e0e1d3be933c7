//! The reader of RAPID modules.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = polishc::verify::rapid::reader::read(data);
});
