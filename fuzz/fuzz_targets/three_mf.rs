//! Fuzz target: 3MF. If the first byte is even, the others are a model, which is packed; if it is odd, they are the
//! archive itself.

#![no_main]

mod packing;
mod reading;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((first, content)) = bytes.split_first() else { return };
    if first % 2 == 0 {
        reading::read(&packing::zip(&[("3D/3dmodel.model", content)]), "a.3mf");
    } else {
        reading::read(content, "a.3mf");
    }
});
