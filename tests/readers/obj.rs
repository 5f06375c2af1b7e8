//! The reader of Wavefront OBJ.

use super::*;

const A: [f64; 3] = [0.0, 0.0, 0.0];
const B: [f64; 3] = [2.0, 0.0, 0.0];
const C: [f64; 3] = [2.0, 2.0, 1.0];
const D: [f64; 3] = [0.0, 2.0, 1.0];
const VERTICES: &str = "v 0 0 0\nv 2 0 0\nv 2 2 1\nv 0 2 1\n";

#[test]
fn corners_are_named_in_all_four_ways() {
    for face in [
        "f 1 2 3",
        "f 1/1 2/2 3/3",
        "f 1//1 2//1 3//1",
        "f 1/5/6 2/5/6 3/5/6",
        "f -4 -3 -2",
        "f -4/1 2//-1 -2/-1/-1",
        "f 1/ 2/ 3/ # note",
        "\tf  1\t2  3 ",
    ] {
        assert_eq!(facets(format!("{VERTICES}{face}\n")), [[A, B, C]], "{face}");
    }
}

#[test]
fn polygons_become_triangles() {
    assert_eq!(facets(format!("{VERTICES}f 1 2 3 4")), [[A, B, C], [A, C, D]]);
    // Numbers need not follow one another.
    let holes = "v 9 9 9\nv 0 0 0\nv 8 8 8\nv 2 0 0\nv 7 7 7\nv 2 2 1\nv 6 6 6\nv 0 2 1\nf 2 4 6 8\n";
    assert_eq!(facets(holes), [[A, B, C], [A, C, D]]);
    // Reflex at the third corner: no triangle may have the opposite orientation.
    let hollow = facets("v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 2 3 4 1\nf 1 2 3 4\nf 4 1 2 3\n");
    let doubled = |[a, b, c]: [[f64; 3]; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    assert!(hollow.iter().all(|facet| doubled(*facet) > 0.0), "{hollow:?}");
    let sum: f64 = hollow.iter().map(|facet| doubled(*facet)).sum();
    assert!((sum - 3.0 * 8.0).abs() < 1e-12, "small whole numbers are exact: {sum}");
}

#[test]
fn statements_that_do_not_affect_the_shape_are_skipped() {
    let file = format!(
        "# a comment that ends like a folder\\\nmtllib a.mtl\no part\n{}vn 0 0 1\nvt 0 0\ng one\ns 1\nusemtl red\n\nf 1 2 \\\n 3 \\\r\n\ns off\n",
        VERTICES.replace("2 2 1", "2 2 1 0.5 0.5 0.5").replace("2 0 0", "2 0 0 1.0")
    );
    let (recorder, summary) = read(file).unwrap();
    assert_eq!(recorder.facets, [[A, B, C]]);
    assert_eq!(summary, ReadSummary { format: Format::Obj, points: 0, facets: 1, unit: None, notes: Notes::default() });
}

#[test]
fn without_faces_the_vertices_are_the_surface() {
    let (recorder, summary) = read(format!("{VERTICES}p 1 2\nl 1 2 3")).unwrap();
    assert_eq!(recorder, Recorder { points: vec![A, B, C, D], facets: vec![] });
    assert_eq!(summary.notes, Notes { other_elements: 2, ..Notes::default() });
}

#[test]
fn facets_without_area_are_passed_to_the_sink() {
    assert_eq!(facets(format!("{VERTICES}f 1 1 1\nf 1 2 2\n")), [[A, A, A], [A, B, B]]);
}

#[test]
fn crossed_polygons_are_counted() {
    let (_, summary) = read("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\nf 1 3 2\n").unwrap();
    assert_eq!((summary.facets, summary.notes.crossed_polygons), (3, 1));
}

#[test]
fn wrong_corners_are_refused_with_their_line() {
    for (face, sentence) in [
        ("f 1 2 5", "line 5: expected the number of one of the 4 vertices before this line, found \"5\""),
        ("f 1 2 0", "line 5: expected the number of one of the 4 vertices before this line, found \"0\""),
        ("f 1 2 -5", "line 5: expected the number of one of the 4 vertices before this line, found \"-5\""),
        ("f 1 2 -0", "line 5: expected the number of one of the 4 vertices before this line, found \"-0\""),
        (
            "f 1 2 99999999999999999999/1",
            "line 5: expected the number of one of the 4 vertices before this line, found \"99999999999999999999/1\"",
        ),
        (
            "f 1 2 18446744073709551617",
            "line 5: expected the number of one of the 4 vertices before this line, found \"18446744073709551617\"",
        ),
        ("f 1 2 -", "line 5: expected a corner as v, v/vt, v//vn or v/vt/vn, found \"-\""),
        ("f 1 2 3.0", "line 5: expected a corner as v, v/vt, v//vn or v/vt/vn, found \"3.0\""),
        ("f 1 2 3/1/1/1", "line 5: expected a corner as v, v/vt, v//vn or v/vt/vn, found \"3/1/1/1\""),
        ("f /1 2 3", "line 5: expected a corner as v, v/vt, v//vn or v/vt/vn, found \"/1\""),
        ("f 1 2", "line 5: expected a face with three corners at least, found two"),
        ("f", "line 5: expected a face with three corners at least, found none"),
        ("f 1 \\\n 2 \\\n 7", "line 7: expected the number of one of the 4 vertices before this line, found \"7\""),
        ("v 1 2", "line 5: expected three numbers after \"v\", found two"),
        ("v 1 2 nan", "line 5: expected a finite coordinate of at most 1e12 in magnitude, found \"nan\""),
        ("hello world", "line 5: expected a statement of OBJ, found \"hello\""),
        (
            "surf 0 1 0 1 1 2 3 4",
            "line 5: expected vertices and polygons, found the free-form statement \"surf\"; export the surface as a mesh",
        ),
    ] {
        assert_eq!(refusal(format!("{VERTICES}{face}\nf 1 2 3\n")), sentence, "{face}");
    }
    assert_eq!(
        refusal("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"),
        "line 1: expected the number of one of the 0 vertices before this line, found \"1\""
    );
    assert_eq!(refusal("vn 0 0 1\n"), "line 2: expected a vertex, found the end of the file");
}

#[test]
fn a_comment_may_state_the_unit() {
    for (comment, unit) in [
        ("# Units: mm", Some(Unit::Millimetre)),
        ("#units = inches", Some(Unit::Inch)),
        ("# File units = meters", Some(Unit::Metre)),
        ("# unit: m", Some(Unit::Metre)),
        ("# Blender 4.1", None),
        ("# 1 unit = 10 mm", None),
    ] {
        for file in [format!("{comment}\n{VERTICES}f 1 2 3\n"), format!("{VERTICES}f 1 2 3\n{comment}\r\n")] {
            assert_eq!(read(&file).unwrap().1.unit, unit, "{file}");
        }
    }
    assert_eq!(refusal(format!("# units: mm\n{VERTICES}# units: cm\n")), "line 6: expected one unit in the comments, found different ones");
    assert!(refusal("# units: km\nv 0 0 0\n").starts_with("line 1: expected coordinates in micrometres, mm"));
}
