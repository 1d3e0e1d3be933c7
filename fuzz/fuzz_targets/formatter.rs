//! The formatter: what it accepts it changes once, and it panics if the meaning would change.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let file = polishc::source::FileId(0);
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(once) = polishc::syntax::format::format(file, text) {
        assert_eq!(polishc::syntax::format::format(file, &once).as_ref(), Ok(&once), "formatting twice changes again");
    }
});
