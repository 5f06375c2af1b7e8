//! The readers of STL in text and binary.

use super::*;

const ASCII: &str = "solid part\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0.5\n   vertex 0 1 0.25\n  endloop\n endfacet\nendsolid part\n";

const FACET: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25]];

#[test]
fn ascii_is_read_in_any_case_and_layout() {
    let facet = ASCII.strip_prefix("solid part\n").and_then(|rest| rest.strip_suffix(" part\n")).unwrap();
    let words: Vec<&str> = facet.split_whitespace().collect();
    for file in [
        ASCII.to_owned(),
        ASCII.to_uppercase(),
        ASCII.replace('\n', "\r\n"),
        ASCII.replace('\n', "\r"),
        format!("\u{feff}{ASCII}"),
        format!("\n\n  {ASCII}\n\n"),
        ASCII.replace("solid part", "solid"),
        ASCII.replace("solid part", "solid facet of a vertex"),
        ASCII.replacen("solid part\n", "", 1),
        format!("solid part\n{}", words.join(" ")),
        format!("solid part\n{}", words.join("\n\n\t")),
    ] {
        assert_eq!(facets(&file), [FACET], "{file:?}");
    }
}

#[test]
fn several_solids_are_one_surface() {
    assert_eq!(facets(ASCII.repeat(3)), [FACET; 3]);
    let without_ends = ASCII.replace("endsolid part\n", "").repeat(2);
    let (recorder, summary) = read(without_ends).unwrap();
    assert_eq!(recorder.facets, [FACET; 2]);
    assert!(summary.notes.missing_end);
    assert_eq!(read(ASCII).unwrap().1.notes, Notes::default());
    // A solid may be empty if another is not.
    assert_eq!(facets(format!("solid a\nendsolid a\n{ASCII}")), [FACET]);
}

#[test]
fn normals_are_ignored() {
    for normal in ["0 0 0", "nan nan nan", "-nan(ind) 1.#QNAN inf", "1e999 0 0"] {
        assert_eq!(facets(ASCII.replace("0 0 1\n", &format!("{normal}\n"))), [FACET], "{normal}");
    }
}

#[test]
fn text_other_than_stl_is_refused_with_its_line() {
    for (wrong, right, sentence) in [
        ("0 0.5", "0", "line 6: expected a number, three for each vertex, found \"vertex\""),
        ("0 0.5", "0 0.5 7", "line 5: expected \"vertex\", three for each facet, found \"7\""),
        ("0 0.5", "0 nan", "line 5: expected a finite coordinate of at most 1e12 in magnitude, found \"nan\""),
        ("0 0.5", "0 0,5", "line 6: expected a number with a decimal comma, as before, found \"0.25\""),
        ("0 0.5", "0 1e13", "line 5: expected a finite coordinate of at most 1e12 in magnitude, found \"1e13\""),
        ("  endloop", "vertex 1 1 1\nendloop", "line 7: expected \"endloop\" after three vertices, found \"vertex\""),
        ("   vertex 0 1 0.25\n", "", "line 6: expected \"vertex\", three for each facet, found \"endloop\""),
        ("normal 0 0 1", "normal 0 0", "line 3: expected three numbers of the normal, then \"outer loop\", found \"outer\""),
        ("normal 0 0 1", "normal 0 0 1 1", "line 2: expected \"outer\", found \"1\""),
        ("endsolid part", "endsolid part\nendsolid", "line 10: expected \"solid\" or \"facet\", found \"endsolid\""),
        (" endfacet\n", " endfacet\nhello\n", "line 9: expected \"facet\" or \"endsolid\", found \"hello\""),
    ] {
        assert!(ASCII.contains(wrong));
        let file = ASCII.replacen(wrong, right, 1);
        assert_eq!(refusal(&file), sentence, "{file}");
    }
    assert_eq!(refusal("solid part\nendsolid part\n"), "line 3: expected \"facet\", found the end of the file");
}

#[test]
fn ascii_that_is_cut_off_is_read_only_between_facets() {
    let file = ASCII.repeat(2);
    for length in 0..file.len() {
        let head = &file[..length];
        match read(head) {
            Ok((recorder, summary)) => {
                // The number of complete words `endfacet` is the number of facets.
                assert_eq!(recorder.facets.len(), head.matches("endfacet").count(), "{head:?}");
                let after = head.rsplit("endfacet").next().unwrap().trim();
                assert!(["", "endsolid", "solid"].iter().any(|word| after.starts_with(word)), "{after:?}");
                let ended = head.matches("endsolid").count() == head.replace("endsolid", "").matches("solid").count();
                assert_eq!(summary.notes.missing_end, !ended, "{head:?}");
            }
            Err(fault) => assert!(
                fault.found() == "the end of the file"
                    || fault.found() == "an empty file"
                    || length < 90
                    || *fault.place() == last_line(head),
                "{fault}"
            ),
        }
    }
}

/// The line number at which a word that is cut off is refused: the last line.
fn last_line(text: &str) -> scallopd::file_fault::FilePlace {
    scallopd::file_fault::FilePlace::Line(text.split('\n').count() as u64)
}

#[test]
fn binary_is_read_with_any_header_and_any_trailing_bytes() {
    for header in ["", "made by nobody", "solid part", "solid part\nfrom afar", "SOLID"] {
        assert_eq!(facets(binary_stl(header, &[TRIANGLE; 3])), [FACET; 3], "{header:?}");
    }
    let mut file = binary_stl("", &[TRIANGLE]);
    file.extend(b"and a colour table");
    let (recorder, summary) = read(file).unwrap();
    assert_eq!(recorder.facets, [FACET]);
    assert_eq!(summary.notes, Notes { trailing_bytes: 18, ..Notes::default() });
}

#[test]
fn binary_with_fewer_facets_than_its_count_is_refused() {
    let mut file = binary_stl("", &[TRIANGLE; 2]);
    for (count, sentence) in [
        (3_u32, "byte 184: expected 3 facets, as the count at byte 80 says, found the end of the file after 2"),
        (u32::MAX, "byte 184: expected 4294967295 facets, as the count at byte 80 says, found the end of the file after 2"),
        (0, "byte 80: expected a facet, found the count 0, and 100 bytes after it"),
    ] {
        file[80..84].copy_from_slice(&count.to_le_bytes());
        assert_eq!(refusal(&file), sentence);
    }
}

#[test]
fn binary_cut_anywhere_is_refused() {
    let file = binary_stl("made by nobody", &[TRIANGLE; 3]);
    for length in 0..file.len() {
        let fault = read(&file[..length]).unwrap_err();
        if length > 84 {
            assert_eq!((fault.kind(), fault.place()), (FileFaultKind::Truncated, &scallopd::file_fault::FilePlace::Byte(length as u64)));
        }
    }
}

#[test]
fn binary_numbers_out_of_range_are_refused_with_their_byte() {
    for (value, found) in [(f32::NAN, "NaN"), (f32::NEG_INFINITY, "-inf"), (2e12_f32, "1999999991808")] {
        let mut wrong = TRIANGLE;
        wrong[2][1] = value;
        // 84 + 50 + 12 + 4 (3 2 + 1) = 174
        let sentence = format!("byte 174: expected a finite coordinate of at most 1e12 in magnitude, found {found}");
        assert_eq!(refusal(binary_stl("", &[TRIANGLE, wrong])), sentence);
    }
}

#[test]
fn decimal_commas_are_read_where_blanks_separate() {
    let comma = |text: &str| text.replace('.', ",");
    let stl = "solid a\nfacet normal 0.0 0.0 1.0e0\nouter loop\nvertex 0.0 0.0 0.5\nvertex 2.05e1 0.0 1.25\nvertex 20.5 20.5 7.5e-01\nendloop\nendfacet\nendsolid a\n";
    assert_eq!(facets(comma(stl)), facets(stl));
    let obj = "v 0.0 0.0 0.5\nv 20.5 0 1.25\nv 20.5 20.5 0.75\nf 1 2 3\n";
    assert_eq!(facets(comma(obj)), facets(obj));
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let rows = "0.0 0.0 0.5\n20.5 0 1.25\n20.5 20.5 0.75\n3 0 1 2\n";
    assert_eq!(facets(format!("{head}{}", comma(rows))), facets(format!("{head}{rows}")));
    for (file, sentence) in [
        ("v 0,5 0 0\nv 1.5 0 0\n", "line 2: expected a number with a decimal comma, as before, found \"1.5\""),
        ("v 0.5 0 0\nv 1,5 0 0\n", "line 2: expected a number with a decimal point, found \"1,5\", with a decimal comma"),
        ("v 1,234,5 0 0\n", "line 1: expected a number, found \"1,234,5\""),
    ] {
        assert_eq!(refusal(file), sentence);
    }
}
