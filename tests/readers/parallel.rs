//! A file read in blocks on several threads gives the points, facets and faults of a file that is read in order.

use super::*;
use crate::writers::{ascii_stl, exact, facets_of, obj, ply, words};
use proptest::prelude::*;
use scallopd::surface::PartedSink;

impl PartedSink for Recorder {
    type Part = Self;

    fn part(&self) -> Self {
        Self::default()
    }

    fn append(&mut self, part: Self) {
        self.points.extend(part.points);
        self.facets.extend(part.facets);
    }
}

/// The result of reading a file in blocks of about `block` bytes, from chunks of `size`. The recorder is returned only
/// for a file without a fault.
fn in_blocks(file: &[u8], block: usize, size: usize) -> Result<(Recorder, Summary), Fault> {
    let (mut reader, mut recorder) = (Reader::new(FormatHint::default()).with_block_size(block), Recorder::default());
    let chunks: Vec<&[u8]> = file.chunks(size).collect();
    for some in chunks.chunks(5) {
        reader.push_in_parallel(some.iter().copied(), &mut recorder)?;
    }
    let summary = reader.finish(&mut recorder)?;
    Ok((recorder, summary))
}

/// Files of a wavy surface in every format that is read in blocks, and of points in several layouts, including whole
/// numbers.
fn files(count: u16) -> Vec<Vec<u8>> {
    let columns = 7;
    let vertex = |index: u16| [f32::from(index % columns), f32::from(index / columns) * 0.5, f32::from(index * 7 % 11) * 0.25];
    let vertices: Vec<[f32; 3]> = (0..count.max(3 * columns)).map(vertex).collect();
    let quads = (0..vertices.len() - usize::from(columns) - 1).map(|a| (a, a + 1, a + usize::from(columns) + 1));
    let triangles: Vec<[usize; 3]> = quads.map(|(a, b, c)| [a, b, c]).collect();
    let points: Vec<[f64; 3]> = vertices.iter().map(|vertex| exact(*vertex)).collect();
    let facets: Vec<[[f64; 3]; 3]> = triangles.iter().map(|triangle| triangle.map(|vertex| points[vertex])).collect();
    let lines = |separator: &str, end: &str| points.iter().map(|point| words(point, separator) + end).collect::<String>();
    let whole = (0..count).map(|index| format!("{index},{},{}\n", index % 5, 3 * index)).collect::<Vec<_>>().concat();
    let polygons = (0..count)
        .map(|index| format!("v {index} 0 {0}\nv {index} 1 0\nv 0 {index}.5 \\\n 1\nf -1 -2 -3\nl 1 2\nf 1/1 2/2 3//3 1\n", index % 3))
        .collect::<Vec<_>>()
        .concat();
    let quads = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face {}\nproperty list uchar int vertex_indices\nelement edge 1\nproperty int vertex1\nend_header\n{}\n{}7\ntail\n",
        points.len(),
        triangles.len(),
        points.iter().map(|point| words(point, " ") + " 7\r\n").collect::<String>(),
        triangles.iter().map(|[a, b, c]| format!("4 {a} {b} {c} {a}\n")).collect::<Vec<_>>().concat(),
    );
    vec![
        lines(",", "\n").into_bytes(),
        lines(";", "\r\n").replace('.', ",").into_bytes(),
        lines("\t", "\r").into_bytes(),
        whole.clone().into_bytes(),
        whole.replace(',', " ").into_bytes(),
        (whole.clone() + &lines(",", "\n")).into_bytes(),
        (whole.replace(',', ";") + &lines(";", "\n").replace('.', ",") + &whole.replace(',', ";")).into_bytes(),
        // Six whole numbers can be three numbers with decimal commas.
        whole.replace('\n', ",1,2,3\n").into_bytes(),
        (whole.replace('\n', ",1,2,3\n") + &whole).into_bytes(),
        ascii_stl(&facets).into_bytes(),
        ascii_stl(&facets).replace('\n', "\r").to_uppercase().into_bytes(),
        (ascii_stl(&facets).replace('\n', " ").replace("endfacet", "endfacet\n").replace("solid", "\nsolid\n").into_bytes()),
        [ascii_stl(&facets), ascii_stl(&facets)].concat().replace("endfacet", "endfacet #").replace(" #", "").into_bytes(),
        binary_stl("", &facets_of(&vertices, &triangles)),
        [binary_stl("", &facets_of(&vertices, &triangles)), b"tail".to_vec()].concat(),
        obj(&vertices, &triangles).into_bytes(),
        obj(&vertices, &[]).into_bytes(),
        polygons.into_bytes(),
        ply("ascii", &vertices, &triangles),
        ply("ascii", &vertices, &[]),
        quads.into_bytes(),
        ply("binary_little_endian", &vertices, &triangles),
        ply("binary_big_endian", &vertices, &triangles),
        ply("binary_big_endian", &vertices, &[]),
    ]
}

/// The number of files that [`files`] makes.
const FILES: usize = 24;

fn assert_same(file: &[u8], block: usize, size: usize) {
    let (expected, found) = (read(file), in_blocks(file, block, size));
    let shown = || String::from_utf8_lossy(&file[..file.len().min(200)]).into_owned();
    match (&expected, &found) {
        (Ok(expected), Ok(found)) => assert!(expected == found, "{}: {:?} is not {:?}", shown(), found.1, expected.1),
        _ => assert_eq!(found.as_ref().err(), expected.as_ref().err(), "{}", shown()),
    }
}

#[test]
fn every_format_gives_the_same_in_blocks_of_any_size() {
    for count in [30, 900] {
        let all = files(count);
        assert_eq!(all.len(), FILES);
        for file in all {
            for (block, size) in [(1, 64), (100, 1 << 20), (1000, 777), (1 << 17, 1 << 16)] {
                assert_same(&file, block, size);
            }
        }
    }
}

proptest! {
    #[test]
    fn damaged_files_have_the_same_first_fault(
        which in 0..FILES,
        count in 20_u16..300,
        damage in proptest::collection::vec((any::<usize>(), prop_oneof![any::<u8>(), Just(b'\n'), Just(b'9'), Just(b'-'), Just(b'.'), Just(b'\\')]), 0..4),
        cut in proptest::option::of(any::<usize>()),
        block in 1_usize..3000,
        size in 1_usize..5000,
    ) {
        let mut file = files(count).swap_remove(which);
        for (at, byte) in damage {
            let at = at % file.len();
            file[at] = byte;
        }
        if let Some(cut) = cut {
            file.truncate(cut % file.len() + 1);
        }
        assert_same(&file, block, size);
    }
}
