//! One surface in every format reaches the sink as the same points or facets.

use super::*;
use crate::writers::{ascii_stl, exact, facets_of, obj, ply, three_mf, words};
use proptest::prelude::*;

/// A wavy surface over a rectangle as vertices in rows and triangles by number. The vertices are in single precision,
/// which all formats can represent.
fn surface(rows: u16, columns: u16) -> (Vec<[f32; 3]>, Vec<[usize; 3]>) {
    let vertex = |row: u16, column: u16| {
        let (x, y) = (f32::from(column) * 1.37, f32::from(row) * 0.73);
        [x, y, (0.3 * x).sin() * 2.0 + (0.2 * y).cos()]
    };
    let vertices = (0..rows).flat_map(|row| (0..columns).map(move |column| vertex(row, column))).collect();
    let number = |row: u16, column: u16| usize::from(row) * usize::from(columns) + usize::from(column);
    let quads = (1..rows).flat_map(|row| (1..columns).map(move |column| (row, column)));
    let triangles = quads.flat_map(|(row, column)| {
        let [a, b, c, d] = [number(row - 1, column - 1), number(row - 1, column), number(row, column), number(row, column - 1)];
        [[a, b, c], [a, c, d]]
    });
    (vertices, triangles.collect())
}

#[test]
fn facets_are_the_same_in_seven_encodings() {
    let (vertices, triangles) = surface(30, 40);
    let expected: Vec<[[f64; 3]; 3]> = triangles.iter().map(|triangle| triangle.map(|vertex| exact(vertices[vertex]))).collect();
    for file in [
        ascii_stl(&expected).into_bytes(),
        binary_stl("", &facets_of(&vertices, &triangles)),
        obj(&vertices, &triangles).into_bytes(),
        ply("ascii", &vertices, &triangles),
        ply("binary_little_endian", &vertices, &triangles),
        ply("binary_big_endian", &vertices, &triangles),
        three_mf("inch", &vertices, &triangles),
    ] {
        assert!(facets(&file) == expected, "{}", String::from_utf8_lossy(&file[..100]));
    }
}

#[test]
fn points_are_the_same_in_every_layout() {
    let (vertices, _) = surface(30, 40);
    let expected: Vec<[f64; 3]> = vertices.iter().map(|vertex| exact(*vertex)).collect();
    let lines = |separator: &str| expected.iter().map(|point| words(point, separator)).collect::<Vec<_>>().join("\n");
    let files = [lines(","), lines(";"), lines(";").replace('.', ","), lines("\t"), lines(" "), lines(" ").replace('.', ",")];
    for file in files.into_iter().map(String::into_bytes).chain([
        obj(&vertices, &[]).into_bytes(),
        ply("ascii", &vertices, &[]),
        ply("binary_big_endian", &vertices, &[]),
    ]) {
        assert!(points(&file) == expected, "{}", String::from_utf8_lossy(&file[..100]));
    }
}

proptest! {
    #[test]
    fn points_are_read_as_they_were_written(points in proptest::collection::vec([-1e12..1e12, -1.0..1.0, -1e-9..1e-9_f64], 1..20), separator in "[;\t ]", comma: bool) {
        let text: String = points.iter().map(|point| words(point, &separator)).collect::<Vec<_>>().join("\n");
        let text = if comma { text.replace('.', ",") } else { text };
        prop_assert_eq!(super::points(text), points);
    }
}
