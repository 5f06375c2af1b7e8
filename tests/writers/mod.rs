//! Writers of the surface files and archives that tests send: STL, OBJ, PLY, 3MF and ZIP.

use std::io::Write;

/// Numbers as text, joined by a separator.
pub(crate) fn words(values: &[impl ToString], separator: &str) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(separator)
}

/// A single-precision vertex as doubles, so that text represents it exactly.
pub(crate) fn exact(vertex: [f32; 3]) -> [f64; 3] {
    vertex.map(f64::from)
}

/// The corners of each triangle.
pub(crate) fn facets_of<T: Copy>(vertices: &[[T; 3]], triangles: &[[usize; 3]]) -> Vec<[[T; 3]; 3]> {
    triangles.iter().map(|triangle| triangle.map(|vertex| vertices[vertex])).collect()
}

/// An ASCII STL with zero normals.
pub(crate) fn ascii_stl(facets: &[[[f64; 3]; 3]]) -> String {
    let vertex = |corner: &[f64; 3]| format!("vertex {}\n", words(corner, " "));
    let facet =
        |corners: &[[f64; 3]; 3]| format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", corners.each_ref().map(vertex).concat());
    format!("solid surface\n{}endsolid surface\n", facets.iter().map(facet).collect::<String>())
}

/// A binary STL with this header, padded, and these facets, whose normals are NaN.
pub(crate) fn binary_stl(header: &str, facets: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut file = header.as_bytes().to_vec();
    file.resize(80, 0);
    file.extend(u32::try_from(facets.len()).unwrap().to_le_bytes());
    for facet in facets {
        file.extend([f32::NAN; 3].iter().chain(facet.as_flattened()).flat_map(|value| value.to_le_bytes()));
        file.extend([0xab, 0xcd]);
    }
    file
}

/// A Wavefront OBJ.
pub(crate) fn obj(vertices: &[[f32; 3]], triangles: &[[usize; 3]]) -> String {
    let vertices = vertices.iter().map(|vertex| format!("v {}\n", words(&exact(*vertex), " ")));
    let faces = triangles.iter().map(|triangle| format!("f {}\n", words(&triangle.map(|vertex| vertex + 1), " ")));
    vertices.chain(faces).collect()
}

/// A PLY in the encoding `ascii`, `binary_little_endian` or `binary_big_endian`.
pub(crate) fn ply(encoding: &str, vertices: &[[f32; 3]], triangles: &[[usize; 3]]) -> Vec<u8> {
    let is_big = encoding == "binary_big_endian";
    let mut file = format!(
        "ply\nformat {encoding} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    )
    .into_bytes();
    for vertex in vertices {
        match encoding {
            "ascii" => file.extend(format!("{}\n", words(&exact(*vertex), " ")).bytes()),
            _ => file.extend(vertex.iter().flat_map(|value| if is_big { value.to_be_bytes() } else { value.to_le_bytes() })),
        }
    }
    for triangle in triangles {
        if encoding == "ascii" {
            file.extend(format!("3 {}\n", words(triangle, " ")).bytes());
        } else {
            file.push(3);
            let index = |vertex: &usize| i32::try_from(*vertex).unwrap();
            file.extend(triangle.iter().map(index).flat_map(|index| if is_big { index.to_be_bytes() } else { index.to_le_bytes() }));
        }
    }
    file
}

/// A ZIP archive of these files, deflated.
pub(crate) fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Deflated).compression_level(Some(1));
    for (name, content) in files {
        archive.start_file(*name, options).unwrap();
        archive.write_all(content).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A ZIP archive whose directory has this many entries, 47 bytes each, without their files.
pub(crate) fn directory_alone(entries: u32) -> Vec<u8> {
    let entry = [b"PK\x01\x02".as_slice(), &[20, 0, 20, 0], &[0; 20], &[1, 0], &[0; 16], b"a"].concat();
    let size = entries * u32::try_from(entry.len()).unwrap();
    let directory = entry.repeat(usize::try_from(entries).unwrap());
    let counts = [0xff; 4];
    [b"PK\x03\x04".as_slice(), &directory, b"PK\x05\x06\0\0\0\0", &counts, &size.to_le_bytes(), &4_u32.to_le_bytes(), &[0; 2]].concat()
}

/// The XML of an object of 3MF with a mesh.
pub(crate) fn mesh_object<T: ToString>(id: u32, vertices: &[[T; 3]], triangles: &[[usize; 3]]) -> String {
    let vertices =
        vertices.iter().map(|[x, y, z]| format!("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>", x.to_string(), y.to_string(), z.to_string()));
    let triangles = triangles.iter().map(|[a, b, c]| format!("<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\" />\n"));
    format!(
        "<object id=\"{id}\" type=\"model\"><mesh><vertices>{}</vertices><triangles>{}</triangles></mesh></object>",
        vertices.collect::<String>(),
        triangles.collect::<String>()
    )
}

/// The XML of a model of 3MF with these attributes, objects and build items.
pub(crate) fn model(attributes: &str, objects: &str, items: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model {attributes} xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n\
         <metadata name=\"Title\">a &lt;part&gt;</metadata><resources>{objects}</resources><build>{items}</build></model>"
    )
}

/// A 3MF package of this model.
pub(crate) fn package(model: &str) -> Vec<u8> {
    let types = "<?xml version=\"1.0\"?><Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\"><Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/><Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/></Types>";
    zip(&[("[Content_Types].xml", types.as_bytes()), ("_rels/.rels", RELATIONSHIPS.as_bytes()), ("3D/3dmodel.model", model.as_bytes())])
}

/// The relationships of a package whose model is `3D/3dmodel.model`.
pub(crate) const RELATIONSHIPS: &str = "<?xml version=\"1.0\"?><Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship Target=\"/3D/3dmodel.model\" Id=\"rel0\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";

/// A 3MF package of one mesh in this unit.
pub(crate) fn three_mf(unit: &str, vertices: &[[f32; 3]], triangles: &[[usize; 3]]) -> Vec<u8> {
    let vertices: Vec<_> = vertices.iter().map(|vertex| exact(*vertex)).collect();
    package(&model(&format!("unit=\"{unit}\""), &mesh_object(1, &vertices, triangles), "<item objectid=\"1\"/>"))
}
