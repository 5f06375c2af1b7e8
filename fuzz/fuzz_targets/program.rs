//! Fuzz target: programs of machine tools. What is read is written again with other feeds, and read back.

#![no_main]

mod memory;

use scallopd::path::program::{ReadSettings, Reached, read, with_feeds};

/// The most memory for a program of at most 16 KB: 10 000 points and their text.
const MOST_BYTES: usize = 16 << 20;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    let settings = ReadSettings { sagitta: 1e-3, most_points: 10_000 };
    memory::bounded(MOST_BYTES, || match read(&text, &settings) {
        Ok(program) => {
            assert!(!program.points.is_empty() && program.points.len() <= settings.most_points);
            assert!(program.points.iter().all(|point| point.point.iter().all(|value| value.is_finite())));
            assert!(program.points[0].reached == Reached::FromUnknown);
            let (moves, points) = program.moves();
            assert!(moves.len() == points.len() && moves.len() < program.points.len());
            let written = with_feeds(&text, &program, &vec![123.4; program.points.len()], true);
            if let Ok(again) = read(&written, &settings) {
                let place = |at: usize| (again.points[at].point, program.points[at].point);
                assert!(again.points.len() == program.points.len() && (0..again.points.len()).all(|at| place(at).0 == place(at).1));
            }
        }
        Err(faults) => {
            assert!(!faults.is_empty() && faults.len() <= 100);
            assert!(faults.iter().all(|fault| fault.line > 0));
        }
    });
});
