//! Fuzz target: any bytes as a surface file with any name.

#![no_main]

mod reading;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let names = ["a", "a.csv", "a.stl", "a.obj", "a.ply", "a.3mf"];
    if let Some((first, file)) = bytes.split_first() {
        reading::read(file, names[usize::from(*first) % names.len()]);
    }
});
