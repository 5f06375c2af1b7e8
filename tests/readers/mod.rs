//! The readers of surface files and tool libraries on ordinary, messy and hostile files.

mod cutting;
mod formats_agree;
mod hostile;
mod libraries;
mod obj;
mod parallel;
mod ply;
mod stl;
mod text;
mod three_mf;

use crate::writers::binary_stl;
use scallopd::surface::Sink;
use scallopd::surface::read::{Fault, FaultKind, Format, FormatHint, Notes, Reader, Summary};

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

/// Reads a whole file in one chunk, without a hint about its format.
fn read(file: impl AsRef<[u8]>) -> Result<(Recorder, Summary), Fault> {
    read_in_chunks(&[file.as_ref()], FormatHint::default()).1
}

/// The contents of the sink, and the result of reading.
fn read_in_chunks(chunks: &[&[u8]], hint: FormatHint) -> (Recorder, Result<(Recorder, Summary), Fault>) {
    let mut reader = Reader::new(hint);
    let mut recorder = Recorder::default();
    for chunk in chunks {
        if let Err(fault) = reader.push(chunk, &mut recorder) {
            return (recorder, Err(fault));
        }
    }
    let result = reader.finish(&mut recorder);
    (recorder.clone(), result.map(|summary| (recorder, summary)))
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
