//! The reader of PLY in its three encodings.

use super::*;
use crate::writers::words;
use scallopd::file_fault::FilePlace;

const ASCII: &str = "ply\nformat ascii 1.0\ncomment by nobody\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0.5\n1 1 0.75\n0 1 0.25\n3 0 1 2\n4 0 1 2 3\n";

const A: [f64; 3] = [0.0, 0.0, 0.0];
const B: [f64; 3] = [1.0, 0.0, 0.5];
const C: [f64; 3] = [1.0, 1.0, 0.75];
const D: [f64; 3] = [0.0, 1.0, 0.25];
const SURFACE: [[[f64; 3]; 3]; 3] = [[A, B, C], [A, B, C], [A, C, D]];

/// Numbers in either byte order.
struct Bytes {
    big: bool,
    bytes: Vec<u8>,
}

macro_rules! put {
    ($to:expr, $($value:expr),*) => { $($to.bytes.extend(if $to.big { $value.to_be_bytes().to_vec() } else { $value.to_le_bytes().to_vec() });)* };
}

/// The surface of `ASCII` with all types, with lists before, between and after the properties that are read, and with
/// other elements.
fn rich(big: bool) -> Vec<u8> {
    let header = format!(
        "ply\nformat binary_{}_endian 1.0\nobj_info any\nelement range_grid 2\nproperty list uchar int vertex_indices\nelement nothing 4294967295\n\
         element vertex 4\nproperty uchar red\nproperty float64 z\nproperty list short double weights\nproperty int16 x\nproperty uint y\n\
         element material 1\nproperty float32 a\nproperty list uint8 uint8 name\n\
         element face 2\nproperty uint8 flags\nproperty list uint32 uint16 vertex_index\nproperty list uchar float texcoord\nproperty double quality\n\
         element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n",
        if big { "big" } else { "little" }
    );
    let mut to = Bytes { big, bytes: header.into_bytes() };
    put!(to, 1_u8, 7_i32, 0_u8);
    for ([x, y, z], weights) in [([0_i16, 0, 0], 0), ([1, 0, 2], 1), ([1, 1, 3], 0), ([0, 1, 1], 3)] {
        put!(to, 200_u8, f64::from(z) / 4.0, i16::try_from(weights).unwrap());
        for _ in 0..weights {
            put!(to, 0.5_f64);
        }
        put!(to, x, u32::try_from(y).unwrap());
    }
    put!(to, 1.5_f32, 3_u8, b'a', b'b', b'c');
    for face in [&[0_u16, 1, 2][..], &[0, 1, 2, 3]] {
        put!(to, 1_u8, u32::try_from(face.len()).unwrap());
        for corner in face {
            put!(to, corner);
        }
        put!(to, 2_u8, 0.0_f32, 1.0_f32, 0.25_f64);
    }
    put!(to, 0_i32, 1_i32);
    to.bytes
}

fn small(big: bool) -> Vec<u8> {
    let (head, _) = ASCII.split_once("0 0 0\n").unwrap();
    let head = head.replace("ascii", if big { "binary_big_endian" } else { "binary_little_endian" });
    let mut to = Bytes { big, bytes: head.into_bytes() };
    for vertex in [A, B, C, D] {
        for value in vertex {
            #[allow(clippy::cast_possible_truncation, reason = "quarters are exact")]
            let value = value as f32;
            put!(to, value);
        }
    }
    put!(to, 3_u8, 0_i32, 1_i32, 2_i32, 4_u8, 0_i32, 1_i32, 2_i32, 3_i32);
    to.bytes
}

#[test]
fn all_three_encodings_give_the_same_surface() {
    for file in [ASCII.into(), small(false), small(true), rich(false), rich(true)] {
        assert_eq!(facets(file), SURFACE);
    }
    assert_eq!(read(small(true)).unwrap().1.format, Format::PlyBigEndian);
    assert_eq!(read(ASCII).unwrap().1, ReadSummary { format: Format::PlyAscii, points: 0, facets: 3, unit: None, notes: Notes::default() });
    // 2 range grids, 4294967295 of nothing, 1 material, 1 edge.
    assert_eq!(read(rich(false)).unwrap().1.notes, Notes { other_elements: 4_294_967_299, ..Notes::default() });
}

#[test]
fn ascii_is_read_in_any_layout() {
    for file in [
        ASCII.replace('\n', "\r\n"),
        ASCII.replace('\n', "\r"),
        format!("\u{feff}{ASCII}"),
        ASCII.replace('\n', "\n\n").replacen("\n\n", "\n", 1),
        ASCII.replace("float ", "double "),
        ASCII.trim_end().replace(' ', "\t "),
    ] {
        assert_eq!(facets(&file), SURFACE, "{file:?}");
    }
}

#[test]
fn a_binary_body_may_begin_with_a_line_feed() {
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\nproperty uchar y\nproperty uchar z\nend_header\n";
    for end in ["\n", "\r\n", "\r"] {
        let file = [head.replace('\n', end).as_bytes(), b"\n\r\n"].concat();
        assert_eq!(points(file), [[10.0, 13.0, 10.0]], "{end:?}");
    }
}

#[test]
fn unused_elements_and_lists_are_skipped_in_text() {
    let file = "ply\nformat ascii 1.0\nelement nothing 4000000000\nelement grid 2\nproperty list int int n\nelement vertex 3\nproperty list uchar float w\nproperty int z\n\
        property double y\nproperty float x\nproperty uchar red\nelement face 1\nproperty uchar flag\nproperty list uchar uint vertex_index\nproperty list uchar float t\nend_header\n\
        0\n2 5 6\n0 0 0 0 255\n2 0.5 nan 1 0 1 255\n1 9 0 1 0 0\n7 3 0 1 2 2 0.5 0.5\n";
    assert_eq!(facets(file), [[[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 0.0]]]);
}

#[test]
fn without_faces_the_vertices_are_the_surface() {
    let cloud = ASCII.replace("face 2", "face 0").replace("3 0 1 2\n4 0 1 2 3\n", "");
    assert_eq!(points(&cloud), [A, B, C, D]);
    let (head, _) = cloud.split_once("element face").unwrap();
    assert_eq!(points(format!("{head}end_header\n0 0 0\n1 0 0.5\n1 1 0.75\n0 1 0.25")), [A, B, C, D]);
    let mut binary = small(true);
    let end = binary.len() - 13 - 17;
    binary.truncate(end);
    let text = String::from_utf8_lossy(&binary).find("face 2").unwrap();
    binary[text + 5] = b'0';
    assert_eq!(points(binary), [A, B, C, D]);
}

#[test]
fn bytes_after_the_last_row_are_counted() {
    for (mut file, format) in [(ASCII.as_bytes().to_vec(), Format::PlyAscii), (small(false), Format::PlyLittleEndian)] {
        file.extend(b"more");
        let (recorder, summary) = read(file).unwrap();
        assert_eq!(recorder.facets, SURFACE);
        assert_eq!((summary.format, summary.notes), (format, Notes { trailing_bytes: 4, ..Notes::default() }));
    }
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    for file in [small(false), small(true), rich(false)] {
        let body = file.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
        for length in 0..file.len() {
            let fault = read(&file[..length]).unwrap_err();
            if length >= body {
                assert_eq!((fault.kind(), fault.place()), (FileFaultKind::Truncated, &FilePlace::Byte(length as u64)), "{fault}");
            }
        }
    }
    // In text, a cut inside the last number would not be noticed, so the last number here has a single digit.
    for length in 0..ASCII.len() - 1 {
        assert!(read(&ASCII[..length]).is_err(), "{length}");
    }
}

#[test]
fn headers_without_a_surface_are_refused() {
    for (wrong, right, sentence) in [
        ("ascii 1.0", "ascii 2.0", "line 2: expected version 1.0, found \"2.0\""),
        ("ascii 1.0", "morse 1.0", "line 2: expected ascii, binary_little_endian or binary_big_endian, found \"morse\""),
        ("format ascii 1.0\n", "", "line 9: expected a format, found the end of the header without it"),
        ("float z", "float w", "line 10: expected a vertex property z, found the end of the header without it"),
        ("float z", "float x", "line 7: expected each coordinate and the corners once, found a second time"),
        ("float z", "quad z", "line 7: expected a type such as float or int32, found \"quad\""),
        ("float z", "float", "line 7: expected the name of a property, found nothing"),
        ("float z", "float z z", "line 7: expected the end of the line, found \"z\""),
        ("element vertex 4", "element vertex many", "line 4: expected a count of at most 18 digits, found \"many\""),
        ("element vertex 4", "element vertex -4", "line 4: expected a count of at most 18 digits, found \"-4\""),
        ("element vertex 4\n", "", "line 4: expected an element before its properties, found a property"),
        ("element vertex 4", "element vertex 0", "line 10: expected a vertex, found 0 vertices in the header"),
        ("element vertex 4", "element point 4", "line 10: expected an element vertex, found the end of the header without it"),
        ("element face 2", "element vertex 2", "line 8: expected one element of this name, found \"vertex\""),
        ("list uchar int vertex_indices", "list float int vertex_indices", "line 9: expected integers, found \"vertex_indices\""),
        ("list uchar int vertex_indices", "list uchar float vertex_indices", "line 9: expected integers, found \"vertex_indices\""),
        (
            "list uchar int vertex_indices",
            "list uchar int corners",
            "line 10: expected a list vertex_indices of the faces, found the end of the header without it",
        ),
        (
            "comment by",
            "remark by",
            "line 3: expected format, element, property, comment, obj_info or end_header, found \"remark by nobody\"",
        ),
        ("element vertex 4", "element vertex 4294967295", "line 10: expected at most 20000000 vertices, found more"),
    ] {
        assert!(ASCII.contains(wrong));
        assert_eq!(refusal(ASCII.replacen(wrong, right, 1)), sentence, "{right}");
    }
    let faces_first = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    assert_eq!(refusal(faces_first), "line 9: expected vertices before faces, found the element face before vertex");
}

#[test]
fn faulty_rows_are_refused_with_their_line() {
    for (wrong, right, sentence) in [
        ("1 1 0.75", "1 1", "line 13: expected as many numbers as a row of the element \"vertex\" has, found the end of the line"),
        ("1 1 0.75", "1 1 0.75 1", "line 13: expected the end of a row of the element \"vertex\", found \"1\""),
        ("1 1 0.75", "1 1 inf", "line 13: expected a finite coordinate of at most 1e12 in magnitude, found \"inf\""),
        ("1 1 0.75", "1 1 ?", "line 13: expected a number, found \"?\""),
        ("3 0 1 2\n4", "3 0 1 4\n4", "line 15: expected the number of one of 4 vertices, from 0, found \"4\""),
        ("3 0 1 2\n4", "3 0 1 -1\n4", "line 15: expected the number of one of 4 vertices, from 0, found \"-1\""),
        ("3 0 1 2\n4", "3 0 1 x\n4", "line 15: expected the number of a vertex, found \"x\""),
        ("3 0 1 2\n4", "2 0 1\n4", "line 15: expected a face with three corners at least, found two"),
        ("3 0 1 2\n4", "-3 0 1 2\n4", "line 15: expected the length of a list, found \"-3\""),
        (
            "3 0 1 2\n4",
            "4000000000 0 1 2\n4",
            "line 15: expected as many numbers as a row of the element \"face\" has, found the end of the line",
        ),
        ("4 0 1 2 3\n", "", "line 16: expected 2 rows of the element \"face\", as the header says, found the end of the file after 1"),
    ] {
        assert!(ASCII.contains(wrong));
        assert_eq!(refusal(ASCII.replacen(wrong, right, 1)), sentence, "{right}");
    }
}

#[test]
fn faulty_binary_rows_are_refused_with_their_byte() {
    let file = small(false);
    let body = file.len() - 4 * 12 - 13 - 17;
    let with = |at: usize, bytes: &[u8]| {
        let mut file = file.clone();
        file[body + at..body + at + bytes.len()].copy_from_slice(bytes);
        read(file).unwrap_err()
    };
    let nan = with(12 + 4, &f32::NAN.to_le_bytes());
    assert_eq!((nan.kind(), nan.place(), nan.found()), (FileFaultKind::OutOfRange, &FilePlace::Byte((body + 16) as u64), "NaN"));
    for number in [4_i32, -1, i32::MIN, i32::MAX] {
        let fault = with(48 + 1 + 8, &number.to_le_bytes());
        assert_eq!(
            (fault.kind(), fault.place(), fault.found()),
            (FileFaultKind::OutOfRange, &FilePlace::Byte((body + 57) as u64), &*number.to_string())
        );
    }
    let two = with(48, &[2]);
    assert_eq!((two.kind(), two.found()), (FileFaultKind::Malformed, "two"));
}

#[test]
fn triangle_strips_are_read_in_all_encodings() {
    let head = |encoding: &str| {
        format!(
            "ply\nformat {encoding} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
        )
    };
    // A strip of two triangles, a break, one more triangle, and a repeated vertex, which forms no triangle.
    let strip = [0_i32, 1, 3, 2, -1, 0, 1, 2, 2];
    let expected = [[A, B, D], [D, B, C], [A, B, C]];
    let vertices = [A, B, C, D].map(|vertex| words(&vertex, " ") + "\n").concat();
    let strip_words = words(&strip, " ");
    assert_eq!(facets(format!("{}{vertices}9 {strip_words}\n", head("ascii"))), expected);
    for big in [false, true] {
        let mut to = Bytes { big, bytes: head(if big { "binary_big_endian" } else { "binary_little_endian" }).into_bytes() };
        for value in [A, B, C, D].as_flattened() {
            #[allow(clippy::cast_possible_truncation, reason = "quarters are exact")]
            let value = *value as f32;
            put!(to, value);
        }
        put!(to, 9_i32);
        for vertex in strip {
            put!(to, vertex);
        }
        assert_eq!(read_in_pieces(&to.bytes, 1, FormatHint::default()).0.facets, expected);
        assert_eq!(facets(&to.bytes), expected);
    }
    let missing = refusal(format!("{}{vertices}3 0 1 4\n", head("ascii")));
    assert_eq!(missing, "line 14: expected the number of one of 4 vertices, from 0, found \"4\"");
    assert_eq!(read(format!("{}{vertices}2 0 1\n", head("ascii"))).unwrap_err().kind(), FileFaultKind::Empty);
}

#[test]
fn a_comment_may_state_the_unit() {
    for (line, unit) in [
        ("comment units: cm", Some(Unit::Centimetre)),
        ("obj_info Units = Inches", Some(Unit::Inch)),
        ("comment unit of length: ft", Some(Unit::Foot)),
        ("comment units unknown", None),
    ] {
        assert_eq!(read(ASCII.replace("comment by nobody", line)).unwrap().1.unit, unit, "{line}");
    }
    let two = ASCII.replace("comment by nobody", "comment units: mm\ncomment units: inches");
    assert_eq!(refusal(two), "line 4: expected one unit in the comments, found different ones");
}
