//! Fuzz target: ASCII STL.

#![no_main]

mod reading;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    reading::read(&[b"solid\n", bytes].concat(), "a.stl");
});
