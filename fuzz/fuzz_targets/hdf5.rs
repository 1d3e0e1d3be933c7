//! The readers of Zygo Mx and 4D maps, and the HDF5 under them.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = polishc::height_map::hdf5::read(data, "fuzz");
});
