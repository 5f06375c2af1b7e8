//! Fuzz target: PLY.

#![no_main]

mod reading;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    reading::read(&[b"ply\n", bytes].concat(), "a.ply");
});
