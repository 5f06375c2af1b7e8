//! Fuzz target: binary STL. The first byte is the lowest of the count.

#![no_main]

mod reading;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let (count, records) = bytes.split_at(bytes.len().min(1));
    reading::read(&[&[0; 80], count, &[0; 3], records].concat(), "a.stl");
});
