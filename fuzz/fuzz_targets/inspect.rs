//! Any file of heights, as `polishc inspect` takes it.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = polishc::metrology::inspect(data, "fuzz", None, None);
    let _ = polishc::metrology::inspect(data, "fuzz", Some(1e-9), Some(1e-3));
});
