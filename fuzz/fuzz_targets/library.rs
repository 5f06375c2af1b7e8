//! Fuzz target: tool libraries. The first byte chooses between the bytes themselves and a zip with them as one file.

#![no_main]

mod memory;
mod packing;

use scallopd::tooling::{MOST_FAULTY, MOST_TOOLS, ToolLibrary};

/// The most memory for a library of at most 16 KB.
const MOST_BYTES: usize = 64 << 20;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((first, content)) = bytes.split_first() else { return };
    let names = ["tools.json", "a.fctb", "a.csv", "a.fctl"];
    let result = memory::bounded(MOST_BYTES, || match first % 5 {
        4 => ToolLibrary::read(content, Some("library")),
        name => ToolLibrary::read(&packing::zip(&[(names[usize::from(name)], content)]), Some("library")),
    });
    match result {
        Ok(library) => {
            assert!(library.tools().len() <= MOST_TOOLS && library.faulty().len() <= MOST_FAULTY);
            let is_other = library.others().count() > 0 || library.unlisted_files() > 0;
            assert!(is_other || !library.tools().is_empty() || !library.faulty().is_empty());
            for tool in library.faulty() {
                assert!(!tool.faults().is_empty() && tool.to_string().chars().all(|c| !c.is_control()));
            }
            for tool in library.tools() {
                let (profile, outer) = (tool.cutter.profile(), tool.cutter.outer_radius().mm());
                assert!(outer > 0.0 && profile.low(0.0) <= profile.low(outer) && profile.low(outer).is_finite());
                assert!(tool.name.chars().all(|c| !c.is_control()));
            }
        }
        Err(faults) => assert!(!faults.all().is_empty() && faults.to_string().chars().all(|c| !c.is_control())),
    }
});
