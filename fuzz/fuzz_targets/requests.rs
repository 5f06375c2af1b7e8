//! Fuzz target: JSON requests to every operation that accepts them. Every answer must be JSON without a status of 500.

#![no_main]

mod service;

const PATHS: [&str; 8] = [
    "/v1/scallop-height",
    "/v1/max-feed",
    "/v1/step-over",
    "/v1/scallop-height/batch",
    "/v1/max-feed/batch",
    "/v1/step-over/batch",
    "/v1/critical-slope",
    "/v1/cutter-recommendation",
];

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Some((first, body)) = bytes.split_first() {
        service::post(PATHS[usize::from(*first) % PATHS.len()], "application/json", body);
    }
});
