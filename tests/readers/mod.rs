//! The readers of surface files and tool libraries on ordinary, messy and hostile files.

mod formats_agree;
mod hostile;
mod libraries;
mod obj;
mod pieces;
mod ply;
mod stl;
mod text;
mod three_mf;

use crate::writers::binary_stl;
use scallopd::file_fault::{FileFault, FileFaultKind};
use scallopd::surface::read::{Format, FormatHint, Notes, ReadError, ReadSummary, Reader};
use scallopd::surface::{Sink, Unit};
use std::io::{self, Read};

/// A sink that keeps all points and facets.
#[derive(Debug, Default, Clone, PartialEq)]
struct Recorder {
    points: Vec<[f64; 3]>,
    facets: Vec<[[f64; 3]; 3]>,
}

impl Sink for Recorder {
    fn point(&mut self, point: [f64; 3]) {
        self.points.push(point);
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        self.facets.push(corners);
    }
}

/// A source that delivers at most this many bytes at a time.
struct InPieces<'a>(&'a [u8], usize);

impl Read for InPieces<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = buffer.len().min(self.1);
        self.0.read(&mut buffer[..length])
    }
}

/// Reads a whole file without a hint about its format.
fn read(file: impl AsRef<[u8]>) -> Result<(Recorder, ReadSummary), FileFault> {
    let (recorder, result) = read_in_pieces(file.as_ref(), usize::MAX, FormatHint::default());
    result.map(|summary| (recorder, summary))
}

/// The contents of the sink, and the result of reading a file that arrives in pieces of this size.
fn read_in_pieces(file: &[u8], piece: usize, hint: FormatHint) -> (Recorder, Result<ReadSummary, FileFault>) {
    let mut recorder = Recorder::default();
    let result = Reader::new(hint).read(InPieces(file, piece), &mut recorder);
    (recorder, result.map_err(fault))
}

/// The fault of a file whose source does not fail.
fn fault(error: ReadError) -> FileFault {
    match error {
        ReadError::Fault(fault) => fault,
        ReadError::Source(error) => panic!("{error}"),
    }
}

/// The points of a file without facets; the summary must agree.
fn points(file: impl AsRef<[u8]>) -> Vec<[f64; 3]> {
    let (recorder, summary) = read(file).unwrap();
    assert_eq!((summary.points, summary.facets), (recorder.points.len() as u64, 0));
    assert_eq!(recorder.facets, Vec::<[[f64; 3]; 3]>::new());
    recorder.points
}

/// The facets of a file that has them; the summary must agree.
fn facets(file: impl AsRef<[u8]>) -> Vec<[[f64; 3]; 3]> {
    let (recorder, summary) = read(file).unwrap();
    assert_eq!((summary.points, summary.facets), (0, recorder.facets.len() as u64));
    assert_eq!(recorder.points, Vec::<[f64; 3]>::new());
    recorder.facets
}

/// The text of the fault with which a file is refused.
fn refusal(file: impl AsRef<[u8]>) -> String {
    read(file).unwrap_err().to_string()
}

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25]];
