//! Fuzz target: forms with a surface, parameters and tool libraries.

#![no_main]

mod service;

libfuzzer_sys::fuzz_target!(|form: &[u8]| {
    service::post("/v1/cutter-recommendation/upload", "multipart/form-data; boundary=edge", form);
});
