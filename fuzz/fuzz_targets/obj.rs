//! Fuzz target: Wavefront OBJ.

#![no_main]

mod reading;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    reading::read(&[b"v 0 0 0\n", bytes].concat(), "a.obj");
});
