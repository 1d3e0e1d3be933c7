//! The reader of NumPy arrays.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = polishc::height_map::npy::read(data, "fuzz");
});
