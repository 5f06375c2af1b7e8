//! One surface in every format reaches the sink as the same points or facets.

use super::*;
use proptest::prelude::*;

/// A wavy surface over a rectangle as vertices in rows and triangles by number; in single precision, which all formats can hold.
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

fn words(values: &[impl ToString], separator: &str) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(separator)
}

/// A single-precision number as the double that equals it, so that text holds it exactly.
fn exact(vertex: [f32; 3]) -> [f64; 3] {
    vertex.map(f64::from)
}

fn ply(encoding: &str, vertices: &[[f32; 3]], triangles: &[[usize; 3]]) -> Vec<u8> {
    let head = format!(
        "ply\nformat {encoding} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    );
    let mut file = head.into_bytes();
    let number = |value: f32| if encoding == "binary_big_endian" { value.to_be_bytes() } else { value.to_le_bytes() };
    let index = |vertex: usize| i32::try_from(vertex).unwrap();
    let index = |vertex: usize| if encoding == "binary_big_endian" { index(vertex).to_be_bytes() } else { index(vertex).to_le_bytes() };
    for vertex in vertices {
        match encoding {
            "ascii" => file.extend(format!("{}\n", words(&exact(*vertex), " ")).bytes()),
            _ => file.extend(vertex.iter().flat_map(|value| number(*value))),
        }
    }
    for triangle in triangles {
        match encoding {
            "ascii" => file.extend(format!("3 {}\n", words(triangle, " ")).bytes()),
            _ => file.extend([3].into_iter().chain(triangle.iter().flat_map(|vertex| index(*vertex)))),
        }
    }
    file
}

fn obj(vertices: &[[f32; 3]], triangles: &[[usize; 3]]) -> String {
    let vertices = vertices.iter().map(|vertex| format!("v {}\n", words(&exact(*vertex), " ")));
    let faces = triangles.iter().map(|triangle| format!("f {}\n", words(&triangle.map(|vertex| vertex + 1), " ")));
    vertices.chain(faces).collect::<Vec<_>>().concat()
}

fn ascii_stl(facets: &[[[f64; 3]; 3]]) -> String {
    let vertex = |corner: &[f64; 3]| format!("vertex {}\n", words(corner, " "));
    let facet =
        |corners: &[[f64; 3]; 3]| format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", corners.each_ref().map(vertex).concat());
    format!("solid surface\n{}endsolid surface\n", facets.iter().map(facet).collect::<Vec<_>>().concat())
}

#[test]
fn facets_are_the_same_in_six_encodings() {
    let (vertices, triangles) = surface(30, 40);
    let expected: Vec<[[f64; 3]; 3]> = triangles.iter().map(|triangle| triangle.map(|vertex| exact(vertices[vertex]))).collect();
    let single: Vec<[[f32; 3]; 3]> = triangles.iter().map(|triangle| triangle.map(|vertex| vertices[vertex])).collect();
    for file in [
        ascii_stl(&expected).into_bytes(),
        binary_stl("", &single),
        obj(&vertices, &triangles).into_bytes(),
        ply("ascii", &vertices, &triangles),
        ply("binary_little_endian", &vertices, &triangles),
        ply("binary_big_endian", &vertices, &triangles),
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
    fn points_come_back_as_they_were_written(points in proptest::collection::vec([-1e12..1e12, -1.0..1.0, -1e-9..1e-9_f64], 1..20), separator in "[;\t ]", comma: bool) {
        let text: String = points.iter().map(|point| words(point, &separator)).collect::<Vec<_>>().join("\n");
        let text = if comma { text.replace('.', ",") } else { text };
        prop_assert_eq!(super::points(text), points);
    }
}
