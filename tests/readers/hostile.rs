//! Files that would take far more memory or time than their size.

use super::*;

/// Pushes `part` until the reader refuses; returns the number of bytes pushed and the fault.
fn refused_after(head: &[u8], part: &[u8], name: &str) -> (usize, Fault) {
    let mut reader = Reader::new(FormatHint::new(None, Some(name)));
    let mut recorder = Recorder::default();
    reader.push(head, &mut recorder).unwrap();
    for count in 1..=100_000_000 / part.len() {
        if let Err(fault) = reader.push(part, &mut recorder) {
            assert_eq!(reader.push(b"1 2 3\n", &mut recorder), Err(fault.clone()), "a refusal is final");
            assert_eq!(reader.finish(&mut recorder), Err(fault.clone()));
            return (head.len() + count * part.len(), fault);
        }
    }
    panic!("100 MB have been taken");
}

#[test]
fn a_line_of_100_mb_is_refused_as_soon_as_it_is_too_long() {
    for (head, name, line) in [
        ("1 2 3\n", "a.csv", 2),
        ("# ", "a.csv", 1),
        ("solid part\n", "a.stl", 2),
        ("v 0 0 0\nf", "a.obj", 2),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n", "a.ply", 8),
    ] {
        let (bytes, fault) = refused_after(head.as_bytes(), &[b' '; 1000], name);
        assert!(bytes <= 2 * (1 << 16) + 2000, "{bytes} bytes were taken of {head:?}");
        assert_eq!(fault.kind(), FaultKind::TooLarge);
        assert_eq!(fault.to_string(), format!("line {line}: expected at most 65536 bytes in a line, found a longer one"));
    }
}

#[test]
fn a_statement_of_endless_lines_is_refused() {
    let (bytes, fault) = refused_after(b"v 0 0 0\nf ", b"1 1 1 1 \\\n", "a.obj");
    assert!(bytes < 3 * (1 << 16), "{bytes}");
    assert_eq!(fault.expected(), "at most 65536 bytes in a line");
}

#[test]
fn an_endless_header_is_refused() {
    let (bytes, fault) = refused_after(b"ply\nformat ascii 1.0\n", b"comment on and on\n", "a.ply");
    assert!(bytes < 2 * (1 << 16), "{bytes}");
    assert_eq!(fault.expected(), "a header of at most 65536 bytes");
}

#[test]
fn an_endless_face_is_refused() {
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\nproperty uchar y\nproperty uchar z\nelement face 1\nproperty list uint uchar vertex_index\nend_header\nabc";
    let head = [head.as_bytes(), &u32::MAX.to_le_bytes()].concat();
    let (bytes, fault) = refused_after(&head, &[0; 1000], "a.ply");
    assert!(bytes < 2 * (1 << 16), "{bytes}");
    assert_eq!(fault.expected(), "at most 65536 corners in a face");
}

#[test]
fn a_list_of_four_billion_numbers_is_skipped_up_to_the_end_of_the_file() {
    let head = "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty list uint double w\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    let file = [head.as_bytes(), &[0xff; 4], &[0; 5000]].concat();
    let sentence =
        format!("byte {}: expected 1 rows of the element \"vertex\", as the header says, found the end of the file after 0", file.len());
    assert_eq!(refusal(file), sentence);
}

#[test]
fn vertices_are_limited() {
    let ply = |count: usize| {
        let head = format!(
            "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
        );
        format!("{head}{}3 0 1 2\n", "0 0 0\n".repeat(count))
    };
    let obj = |count: usize| format!("{}f 1 2 3\n", "v 0 0 0\n".repeat(count));
    let result = |file: String| {
        let mut reader = Reader::new(FormatHint::default()).with_vertex_limit(10);
        let mut recorder = Recorder::default();
        reader.push(file.as_bytes(), &mut recorder)?;
        reader.finish(&mut recorder).map(|summary| summary.facets)
    };
    for file in [ply(10), obj(10)] {
        assert_eq!(result(file), Ok(1));
    }
    for (file, line) in [(ply(11), 9), (obj(11), 11)] {
        assert_eq!(result(file).unwrap_err().to_string(), format!("line {line}: expected at most 10 vertices, found more"));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn stated_counts_take_no_memory() {
    let pages = || -> u64 {
        let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
        statm.split_whitespace().next().unwrap().parse().unwrap()
    };
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 20000000\nproperty float x\nproperty float y\nproperty float z\nelement face 4000000000\nproperty list uint int vertex_index\nend_header\n";
    let stl = [&[0; 80][..], &[0xff; 4], &[0; 50]].concat();
    // More than the 64 KiB that determine the format, so that the bodies are being read.
    let padding = vec![0; 1 << 16];
    let before = pages();
    let readers: Vec<Reader> = (0..40)
        .map(|index| {
            let mut reader = Reader::new(FormatHint::default());
            reader.push(if index % 2 == 0 { head.as_bytes() } else { &stl }, &mut Nothing).unwrap();
            reader.push(&padding, &mut Nothing).unwrap();
            reader
        })
        .collect();
    // 20 readers with room for 480 MB each would take 10 GB. The bound of 256 MB is for 40 readers with some hundred kB
    // each, and for other tests that run at the same time.
    assert!(pages() < before + (256 << 20) / 4096, "{} readers", readers.len());
}

struct Nothing;

impl Sink for Nothing {
    fn point(&mut self, _: [f64; 3]) {}
    fn facet(&mut self, _: [[f64; 3]; 3]) {}
}

#[test]
fn an_empty_file_is_refused() {
    assert_eq!(refusal(""), "byte 0: expected a surface, found an empty file");
}
