//! Checks for every surface file, read whole and in pieces.

#[path = "memory.rs"]
mod memory;

use scallopd::file_fault::FileFault;
use scallopd::surface::read::{FormatHint, ReadError, Reader, ReadSummary};
use scallopd::surface::{LARGEST_COORDINATE, Sink};
use std::io::Read;

/// A sink that hashes points and facets, so that two readings can be compared without storing them.
#[derive(Default, PartialEq, Debug)]
struct Digest {
    points: u64,
    facets: u64,
    mixed: u64,
}

impl Digest {
    fn take(&mut self, numbers: &[f64]) {
        for number in numbers {
            assert!(number.abs() <= LARGEST_COORDINATE, "{number}");
            self.mixed = self.mixed.rotate_left(5).wrapping_add(number.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
    }
}

impl Sink for Digest {
    fn point(&mut self, point: [f64; 3]) {
        self.points += 1;
        self.take(&point);
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        self.facets += 1;
        self.take(corners.as_flattened());
    }
}

/// A source that delivers at most this many bytes at a time.
struct InPieces<'a>(&'a [u8], usize);

impl Read for InPieces<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let length = buffer.len().min(self.1);
        self.0.read(&mut buffer[..length])
    }
}

fn digest(file: &[u8], piece: usize, name: &str) -> (Digest, Result<ReadSummary, FileFault>) {
    let mut digest = Digest::default();
    let reader = Reader::new(FormatHint::new(None, Some(name))).with_vertex_limit(1_000_000);
    let result = reader.read(InPieces(file, piece), &mut digest).map_err(|error| match error {
        ReadError::Fault(fault) => fault,
        ReadError::Source(error) => panic!("{error}"),
    });
    (digest, result)
}

/// The largest memory for a file of at most 16 KB, with a vertex for every other byte, in blocks and in vectors that
/// double when they grow. A compressed file expands to some MB.
const MOST_BYTES: usize = 64 << 20;

/// Reads a file of this name whole and in pieces of a size that its own bytes choose.
pub fn read(file: &[u8], name: &str) {
    memory::bounded(MOST_BYTES, || read_twice(file, name));
}

fn read_twice(file: &[u8], name: &str) {
    let (whole, result) = digest(file, file.len().max(1), name);
    let size = 1 + file.iter().fold(0, |sum: usize, byte| sum + usize::from(*byte)) % 13;
    let (pieces, in_pieces) = digest(file, size, name);
    assert_eq!((&whole, &result), (&pieces, &in_pieces));
    match result {
        Ok(summary) => {
            assert_eq!((summary.points, summary.facets), (whole.points, whole.facets));
            assert!(summary.points + summary.facets > 0 && (summary.points == 0 || summary.facets == 0));
        }
        Err(fault) => assert!(fault.to_string().chars().all(|c| !c.is_control())),
    }
}
