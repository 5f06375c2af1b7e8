//! The result does not depend on the pieces in which a file arrives, and no bytes make a reader panic.

use super::*;
use crate::writers::three_mf;
use proptest::prelude::*;

/// Files of every format, clean and faulty.
fn files() -> Vec<Vec<u8>> {
    let ply = "ply\r\nformat ascii 1.0\r\nelement vertex 4\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\nelement face 1\r\nproperty list uchar int vertex_indices\r\nend_header\r\n0 0 0\r\n4 0 0\r\n1 1 0\r\n0 4 0\r\n4 1 2 3 0\r\n";
    let binary_ply = b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty uchar x\nproperty ushort y\nproperty list uchar short s\nproperty uchar z\nelement face 2\nproperty list uchar uchar vertex_index\nend_header\n\x01\x00\x02\x01\x00\x00\x03\x04\x00\x05\x00\x06\x07\x00\x08\x00\x09\x03\x00\x01\x02\x03\x02\x01\x00tail";
    let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    vec![
        b"\xef\xbb\xbfX;Y;Z\r\n1,5;2;3\r\n\r\n4;5;6,25\r7;8;9".to_vec(),
        b"1,2,3\r\n4,5\r\n".to_vec(),
        stl.as_bytes().to_vec(),
        stl.replace("1 0 0", "1 0 x").into_bytes(),
        binary_stl("solid", &[TRIANGLE; 2]),
        binary_stl("x", &[TRIANGLE, [[f32::NAN; 3]; 3]]),
        b"v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 1 2 \\\n3 -1\nf 2 3 1\n".to_vec(),
        b"v 0 0 0\nf 1 1 2\n".to_vec(),
        ply.as_bytes().to_vec(),
        ply.replace('\n', "").into_bytes(),
        ply.replace("4 1 2 3 0", "4 1 2 3 4").into_bytes(),
        binary_ply.to_vec(),
        binary_ply[..binary_ply.len() - 6].to_vec(),
        three_mf("inch", &TRIANGLE, &[[0, 1, 2]]),
        "\u{feff}x y z\r\n1 2 3\r\n".encode_utf16().flat_map(u16::to_be_bytes).collect(),
    ]
}

/// The outcome as text, because NaN in a sink does not equal itself.
fn outcome(file: &[u8], piece: usize) -> String {
    format!("{:?}", read_in_pieces(file, piece, FormatHint::default()))
}

/// The file after a comment so long that the format is detected before the data begin.
fn after_the_head(file: &[u8]) -> Vec<u8> {
    [b"# padding\n".repeat(6554).as_slice(), file].concat()
}

#[test]
fn files_are_read_from_single_bytes() {
    for file in files() {
        assert_eq!(outcome(&file, 1), outcome(&file, usize::MAX), "{}", String::from_utf8_lossy(&file));
    }
}

#[test]
fn a_large_file_gives_the_same_result_byte_by_byte_and_whole() {
    let numbers = |index: u32| format!("{} {} {}", index % 97, f64::from(index) * 0.37, f64::from(index).sqrt());
    let repeat = |count: u32, part: &dyn Fn(u32) -> String| (0..count).map(part).collect::<Vec<_>>().concat();
    let text = repeat(5000, &|index| numbers(index) + "\n");
    let obj = repeat(5000, &|index| format!("v {}\nf -1 -1 1\n", numbers(index)));
    let facet =
        |index: u32| format!("facet normal 0 0 0 outer loop\nvertex {0}\nvertex {0}\nvertex {0}\nendloop endfacet\n", numbers(index));
    let stl = "solid\n".to_owned() + &repeat(2000, &facet);
    let binary = binary_stl("", &vec![TRIANGLE; 3000]);
    let cloud = text.replace('\n', "\r\n");
    let head =
        "ply\r\nformat ascii 1.0\r\nelement vertex 5000\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\nend_header\r\n";
    for file in [
        text.as_bytes(),
        obj.as_bytes(),
        stl.as_bytes(),
        &binary,
        (head.to_owned() + &cloud).as_bytes(),
        &after_the_head(b"1,2,3\n4,5,6\n"),
    ] {
        assert!(file.len() > 1 << 16);
        let whole = read(file).unwrap();
        for size in [1, 7, 4096, (1 << 16) - 1, (1 << 16) + 1] {
            let (recorder, summary) = read_in_pieces(file, size, FormatHint::default());
            assert_eq!((recorder, summary.unwrap()), whole, "pieces of {size}");
        }
    }
}

proptest! {
    #[test]
    fn the_result_does_not_depend_on_the_pieces(which in 0_usize..15, piece in 1_usize..100) {
        let file = &files()[which];
        prop_assert_eq!(outcome(file, piece), outcome(file, usize::MAX));
    }

    #[test]
    fn damaged_files_make_no_reader_panic(which in 0_usize..15, damage in proptest::collection::vec((any::<usize>(), any::<u8>()), 1..4), piece in 1_usize..100) {
        let mut file = files()[which].clone();
        for (at, byte) in damage {
            let at = at % file.len();
            file[at] = byte;
        }
        prop_assert_eq!(outcome(&file, piece), outcome(&file, usize::MAX));
        if let Ok((recorder, summary)) = read(&file) {
            prop_assert_eq!((recorder.points.len() as u64, recorder.facets.len() as u64), (summary.points, summary.facets));
            let numbers = recorder.points.iter().flatten().chain(recorder.facets.iter().flatten().flatten());
            prop_assert!(numbers.into_iter().all(|value| value.abs() <= 1e12));
        }
    }

    #[test]
    fn any_bytes_are_read_or_refused(file in proptest::collection::vec(any::<u8>(), 0..300), name in "a\\.(csv|stl|obj|ply)") {
        let hint = FormatHint::new(None, Some(&name));
        prop_assert_eq!(format!("{:?}", read_in_pieces(&file, 1, hint)), format!("{:?}", read_in_pieces(&file, usize::MAX, hint)));
    }
}
