//! The reader of 3MF packages: units, components, build items, and hostile packages.

use super::*;
use crate::writers::{RELATIONSHIPS, directory_alone, mesh_object, model, package, zip};
use scallopd::file_fault::FilePlace;
use scallopd::surface::Unit;

const VERTICES: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [0.0, 1.0, 0.25]];

fn triangle_object(id: u32) -> String {
    mesh_object(id, &VERTICES, &[[0, 1, 2]])
}

fn components(id: u32, components: &str) -> String {
    format!("<object id=\"{id}\"><components>{components}</components></object>")
}

fn moved(by: [f64; 3]) -> [[f64; 3]; 3] {
    VERTICES.map(|[x, y, z]| [x + by[0], y + by[1], z + by[2]])
}

#[test]
fn the_unit_reaches_the_summary() {
    for (attributes, unit) in [
        ("", Unit::Millimetre),
        ("unit=\"micron\"", Unit::Micrometre),
        ("unit=\"millimeter\"", Unit::Millimetre),
        ("unit='centimeter'", Unit::Centimetre),
        ("unit=\"inch\"", Unit::Inch),
        ("unit=\"foot\"", Unit::Foot),
        ("unit=\"meter\"", Unit::Metre),
    ] {
        let (recorder, summary) = read(package(&model(attributes, &triangle_object(1), "<item objectid=\"1\"/>"))).unwrap();
        assert_eq!((summary.format, summary.facets, summary.unit), (Format::ThreeMf, 1, Some(unit)));
        assert_eq!(recorder.facets, [VERTICES]);
    }
    assert_eq!((Unit::Micrometre.mm(), Unit::Foot.mm()), (1e-3, 304.8));
}

#[test]
fn components_and_items_are_placed() {
    let objects = triangle_object(7)
        + &components(8, "<component objectid=\"7\"/><component objectid=\"7\" transform=\"1 0 0 0 1 0 0 0 1 10 0 0\"/>")
        + &components(9, "<component objectid=\"8\" transform=\"1 0 0 0 1 0 0 0 1 0 20 0\"></component>");
    let items = "<item objectid=\"9\" transform=\"1 0 0 0 1 0 0 0 1 0 0 5\"/><item objectid=\"7\"/>";
    let expected = [moved([0.0, 20.0, 5.0]), moved([10.0, 20.0, 5.0]), VERTICES];
    assert_eq!(facets(package(&model("", &objects, items))), expected);
}

#[test]
fn a_reflection_keeps_the_orientation_of_facets() {
    let items = "<item objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"/>";
    let facet = facets(package(&model("", &triangle_object(1), items)))[0];
    assert_eq!(facet, [[0.0, 0.0, 0.0], [0.0, 1.0, 0.25], [-1.0, 0.0, 0.5]]);
}

#[test]
fn objects_in_other_model_files_are_read() {
    let root = model(
        "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" requiredextensions=\"p\"",
        &components(2, "<component p:path=\"/3D/Objects/part.model\" objectid=\"5\"/>"),
        "<item objectid=\"2\"/>",
    );
    let part = model("", &triangle_object(5), "");
    let file = |part: &str| {
        zip(&[("_rels/.rels", RELATIONSHIPS.as_bytes()), ("3D/3dmodel.model", root.as_bytes()), ("3d/objects/PART.model", part.as_bytes())])
    };
    assert_eq!(facets(file(&part)), [VERTICES]);
    let inches = refusal(file(&part.replace("<model ", "<model unit=\"inch\" ")));
    assert_eq!(inches, "3D/Objects/part.model, byte 0: expected one unit in all models of the package, found another");
}

#[test]
fn support_is_left_out_and_counted() {
    let objects = triangle_object(1) + &triangle_object(2).replace("type=\"model\"", "type=\"support\"");
    let (recorder, summary) = read(package(&model("", &objects, "<item objectid=\"2\"/><item objectid=\"1\"/>"))).unwrap();
    assert_eq!((recorder.facets.len(), summary.notes), (1, Notes { other_elements: 1, ..Notes::default() }));
}

#[test]
fn models_without_a_surface_are_refused_with_their_file() {
    let item = "<item objectid=\"1\"/>";
    let place = "3D/3dmodel.model, byte ";
    for (model, sentence) in [
        (model("", &triangle_object(1), ""), "expected a build item with a mesh, found none"),
        (model("", "", item), "expected the number of an object, found 1"),
        (
            model("", &triangle_object(1).replace("v3=\"2\"", "v3=\"3\""), item),
            "expected the number of one of 3 vertices, from 0, found \"3\"",
        ),
        (
            model("", &triangle_object(1).replace("z=\"0.5\"", "z=\"nan\""), item),
            "expected a finite coordinate of at most 1e12 in magnitude, found \"nan\"",
        ),
        (model("", &triangle_object(1).replace("z=\"0.5\"", ""), item), "expected a vertex with x, y and z, found one of them missing"),
        (model("", &(triangle_object(1) + &triangle_object(1)), item), "expected each object number once, found 1"),
        (
            model("unit=\"furlong\"", &triangle_object(1), item),
            "expected micron, millimeter, centimeter, inch, foot or meter, found \"furlong\"",
        ),
        (
            model(
                "requiredextensions=\"b\" xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\"",
                &triangle_object(1),
                item,
            ),
            "expected a model of meshes and components alone, found the required extension \"beamlattice/2017/02\"",
        ),
        (
            model("", &triangle_object(1), "<item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 0 0 0 0\"/>"),
            "expected a transform that is not singular, found \"1 0 0 0 1 0 0 0 0 0 0 0\"",
        ),
        (
            model("", &triangle_object(1), "<item objectid=\"1\" transform=\"1e12 0 0 0 1 0 0 0 1 1 0 0\"/>"),
            "expected a finite coordinate of at most 1e12 in magnitude, found a vertex beyond it after placing its object",
        ),
        ("<!DOCTYPE a [<!ENTITY b \"c\">]><model></model>".into(), "expected no document type definition, found one"),
        ("<html></html>".into(), "expected the element model, found \"html\""),
        ("<model><build>".into(), "expected the end of every element, found the end of the file"),
    ] {
        let found = refusal(package(&model));
        assert!(found.starts_with(place) && found.ends_with(sentence), "{found}");
    }
    let fault = read(package("<model></build>")).unwrap_err();
    assert_eq!((fault.kind(), fault.expected()), (FileFaultKind::Malformed, "well-formed XML"));
    assert_eq!(*fault.place(), FilePlace::Entry { path: "3D/3dmodel.model".into(), byte: 7 });
}

#[test]
fn archives_other_than_packages_are_named() {
    for (name, found) in [("xl/workbook.xml", "an Excel workbook"), ("Document.xml", "a FreeCAD document"), ("part.stl", "an XML file")] {
        let fault = read(zip(&[(name, b"<a/>")])).unwrap_err();
        assert_eq!(fault.kind(), FileFaultKind::UnknownFormat);
        assert!(fault.found().starts_with(found), "{fault}");
    }
    assert_eq!(read(&package("<model/>")[..200]).unwrap_err().kind(), FileFaultKind::Malformed);
}

#[test]
fn components_that_multiply_exponentially_are_refused() {
    let layer = |id: u32| components(id, &format!("<component objectid=\"{}\"/>", id - 1).repeat(10));
    let objects = triangle_object(1) + &(2..12).map(layer).collect::<String>();
    let fault = read(package(&model("", &objects, "<item objectid=\"11\"/>"))).unwrap_err();
    assert_eq!(
        (fault.kind(), fault.expected()),
        (FileFaultKind::TooLarge, "components nested at most 32 deep, and at most 100000 objects placed")
    );
}

#[test]
fn objects_that_contain_themselves_are_refused_with_their_cycle() {
    let of = |id: u32, inner: &[u32]| {
        let inner: Vec<String> = inner.iter().map(|inner| format!("<component objectid=\"{inner}\"/>")).collect();
        components(id, &inner.concat())
    };
    let long: String = (1..=40_000).map(|id| of(id, &[id % 40_000 + 1])).collect();
    let wide: String = triangle_object(1) + &(2..40).map(|id| of(id, &[id - 1; 10])).collect::<String>() + &of(40, &[39, 40]);
    for (objects, item, cycle) in [
        (of(2, &[2]), 2, "2 > 2"),
        (of(1, &[2]) + &of(2, &[1]), 1, "1 > 2 > 1"),
        (triangle_object(9) + &of(1, &[9, 2]) + &of(2, &[9, 3]) + &of(3, &[9, 9, 2]), 1, "2 > 3 > 2"),
        (long, 1, "1 > 2 > 3 > 4 > 5 > 6 > 7 > 8 > ... > 1"),
        (wide, 40, "40 > 40"),
    ] {
        let fault = read(package(&model("", &objects, &format!("<item objectid=\"{item}\"/>")))).unwrap_err();
        assert_eq!(fault.kind(), FileFaultKind::Malformed, "{fault}");
        let expected = "3D/3dmodel.model, byte 0: expected objects that do not contain themselves";
        assert_eq!(fault.to_string(), format!("{expected}, found a cycle of objects: {cycle}"));
    }
    // An object may be placed more than once. A cycle that no build item places is allowed.
    let shared = triangle_object(1) + &of(2, &[1, 1]) + &of(3, &[2, 1]) + &of(4, &[4]);
    assert_eq!(facets(package(&model("", &shared, "<item objectid=\"3\"/><item objectid=\"2\"/>"))).len(), 5);
}

#[test]
fn a_cycle_through_other_model_files_is_found() {
    let root = model(
        "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" requiredextensions=\"p\"",
        &components(2, "<component p:path=\"/3D/Objects/part.model\" objectid=\"5\"/>"),
        "<item objectid=\"2\"/>",
    );
    let part = model("", &components(5, "<component p:path=\"/3D/3dmodel.model\" objectid=\"2\"/>"), "");
    let file = zip(&[
        ("_rels/.rels", RELATIONSHIPS.as_bytes()),
        ("3D/3dmodel.model", root.as_bytes()),
        ("3D/Objects/part.model", part.as_bytes()),
    ]);
    let fault = read(file).unwrap_err();
    assert_eq!((fault.kind(), fault.found()), (FileFaultKind::Malformed, "a cycle of objects: 2 > 5 > 2"));
}

#[test]
fn hostile_packages_are_refused_within_their_limits() {
    let limited = |file: &[u8]| {
        let reader = Reader::new(FormatHint::default()).with_vertex_limit(1000).with_archive_limit(1 << 20);
        reader.read(file, &mut Recorder::default()).map_err(fault)
    };
    let refused = |file: &[u8]| {
        let fault = limited(file).unwrap_err();
        assert_eq!(fault.kind(), FileFaultKind::TooLarge, "{fault}");
        fault.expected().to_owned()
    };
    let item = "<item objectid=\"1\"/>";
    let vertices = mesh_object(1, &vec![[0.0; 3]; 1001], &[]);
    assert_eq!(refused(&package(&model("", &vertices, item))), "at most 1000 vertices");
    let triangles = mesh_object(1, &VERTICES, &vec![[0, 1, 2]; 2001]);
    assert_eq!(refused(&package(&model("", &triangles, item))), "at most 2000 triangles");
    let placed = mesh_object(1, &VERTICES, &vec![[0, 1, 2]; 2000]);
    assert_eq!(refused(&package(&model("", &placed, &item.repeat(3)))), "at most 4000 facets after placing all components");
    let long = model("", &" ".repeat(3 << 20), item);
    assert_eq!(refused(&package(&long)), "at most 1048576 bytes in a tag or text");
    let deep = model("", &"<a>".repeat(100), item);
    assert_eq!(refused(&package(&deep)), "at most 64 nested elements");
    let many = model("", "<object id=\"1\"/>", &item.repeat(100_001));
    assert_eq!(refused(&package(&many)), "at most 100000 objects, components and build items");
    assert_eq!(refused(&directory_alone(20_000)), "a ZIP archive within its limits");
    assert_eq!(refused(&directory_alone(600_000)), "a 3MF file of at most 1048576 bytes");
    assert_eq!(read(directory_alone(4_000_000)).unwrap_err().kind(), FileFaultKind::TooLarge);
}

/// A package with a slicer's settings at this path.
fn with_settings(model: &str, path: &str, settings: &str) -> Vec<u8> {
    zip(&[("_rels/.rels", RELATIONSHIPS.as_bytes()), ("3D/3dmodel.model", model.as_bytes()), (path, settings.as_bytes())])
}

/// PrusaSlicer's settings with a part of one triangle and a second volume of one.
fn prusa(kind: &str) -> String {
    let volume = |triangle: u32, name: &str, kind: &str| {
        format!(
            "<volume firstid=\"{triangle}\" lastid=\"{triangle}\"><metadata type=\"volume\" key=\"name\" value=\"{name}\"/>{kind}</volume>"
        )
    };
    let part = "<metadata type=\"volume\" key=\"volume_type\" value=\"ModelPart\"/>";
    format!(
        "<?xml version=\"1.0\"?>\n<config><object id=\"1\">{}{}</object></config>",
        volume(0, "part", part),
        volume(1, "a &amp; b", kind)
    )
}

#[test]
fn volumes_that_slicers_exclude_are_left_out_and_named() {
    let object = mesh_object(1, &VERTICES, &[[0, 1, 2], [0, 2, 1]]);
    let model_of = |object: &str| model("", object, "<item objectid=\"1\" printable=\"1\"/>");
    for (kind, name) in [
        ("volume_type\" value=\"ParameterModifier", "ParameterModifier \"a & b\""),
        ("volume_type\" value=\"SupportBlocker", "SupportBlocker \"a & b\""),
        ("volume_type\" value=\"SupportEnforcer", "SupportEnforcer \"a & b\""),
        ("modifier\" value=\"1", "ParameterModifier \"a & b\""),
    ] {
        let settings = prusa(&format!("<metadata type=\"volume\" key=\"{kind}\"/>"));
        let (recorder, summary) = read(with_settings(&model_of(&object), "Metadata/Slic3r_PE_model.config", &settings)).unwrap();
        assert_eq!((recorder.facets, summary.notes.volumes), (vec![VERTICES], vec![name.to_owned()]));
    }
    let whole = prusa("<metadata type=\"volume\" key=\"volume_type\" value=\"ModelPart\"/>");
    let (recorder, summary) = read(with_settings(&model_of(&object), "Metadata/Slic3r_PE_model.config", &whole)).unwrap();
    assert_eq!((recorder.facets.len(), summary.notes), (2, Notes::default()));
    let negative = prusa("<metadata type=\"volume\" key=\"volume_type\" value=\"NegativeVolume\"/>");
    let fault = read(with_settings(&model_of(&object), "Metadata/Slic3r_PE_model.config", &negative)).unwrap_err();
    assert_eq!(fault.found(), "the negative volume \"a & b\", which the slicer subtracts; export the finished part as STL");
    // A range beyond the triangles, and a damaged file.
    let beyond =
        prusa("<metadata type=\"volume\" key=\"volume_type\" value=\"SupportBlocker\"/>").replace("lastid=\"1\"", "lastid=\"4000000000\"");
    assert_eq!(facets(with_settings(&model_of(&object), "Metadata/Slic3r_PE_model.config", &beyond)), [VERTICES]);
    assert!(
        refusal(with_settings(&model_of(&object), "Metadata/Slic3r_PE_model.config", "<config><object>"))
            .contains("the end of every element")
    );
}

#[test]
fn components_that_bambu_and_orca_exclude_are_left_out() {
    let objects = triangle_object(1)
        + &triangle_object(2)
        + &components(3, "<component objectid=\"1\"/><component objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 9 0 0\"/>");
    let package = |subtype: &str| {
        let settings = format!(
            "<config><object id=\"3\"><metadata key=\"name\" value=\"all\"/><part id=\"1\" subtype=\"normal_part\"><metadata key=\"name\" value=\"body\"/></part>\
             <part id=\"2\" subtype=\"{subtype}\"><metadata key=\"name\" value=\"cube\"/></part></object></config>"
        );
        with_settings(&model("", &objects, "<item objectid=\"3\"/>"), "Metadata/model_settings.config", &settings)
    };
    for subtype in ["modifier_part", "support_blocker", "support_enforcer"] {
        let (recorder, summary) = read(package(subtype)).unwrap();
        assert_eq!((recorder.facets, summary.notes.volumes), (vec![VERTICES], vec![format!("{subtype} \"cube\"")]));
    }
    assert_eq!(facets(package("normal_part")).len(), 2);
    assert!(refusal(package("negative_part")).contains("the negative volume \"cube\""));
}

#[test]
fn items_that_are_not_printable_are_left_out() {
    let objects = triangle_object(1) + &triangle_object(2);
    let items = "<item objectid=\"1\"/><item objectid=\"2\" printable=\"0\"/>";
    let (recorder, summary) = read(package(&model("", &objects, items))).unwrap();
    assert_eq!((recorder.facets.len(), summary.notes.volumes), (1, vec!["the object 2, which is not printable".to_owned()]));
    let none = refusal(package(&model("", &objects, "<item objectid=\"1\" printable=\"0\"/>")));
    assert!(none.ends_with("expected a build item with a mesh, found none"));
}

#[test]
fn targets_with_entities_and_percent_escapes_are_found() {
    let part = model("", &triangle_object(1), "<item objectid=\"1\"/>");
    for (target, path) in [
        ("/3D/a&amp;b.model", "3D/a&b.model"),
        ("/3D/my%20part.model", "3D/my part.model"),
        ("/3D/my%20part.model", "3D/my%20part.model"),
        ("/3D/%C3%9Cbung.model", "3D/\u{dc}bung.model"),
        ("/3D/a&#38;b%2B.model", "3D/a&b+.model"),
        ("./3D/3dmodel.model", "3D/3dmodel.model"),
    ] {
        let relationships = RELATIONSHIPS.replace("/3D/3dmodel.model", target);
        assert_eq!(facets(zip(&[("_rels/.rels", relationships.as_bytes()), (path, part.as_bytes())])), [VERTICES], "{target}");
    }
}

#[test]
fn the_only_file_of_an_archive_is_read() {
    let stl = binary_stl("", &[TRIANGLE]);
    let csv = b"x,y,z\n1,2,3\n".as_slice();
    assert_eq!(read(zip(&[("part.stl", &stl)])).unwrap().1.format, Format::StlBinary);
    assert_eq!(
        read(zip(&[("folder/part.stl", &stl), ("__MACOSX/folder/._part.stl", b"x"), ("folder/.DS_Store", b"x")])).unwrap().1.facets,
        1
    );
    assert_eq!(read(zip(&[("folder/", b""), ("points.csv", csv)])).unwrap().1.points, 1);
    assert_eq!(refusal(zip(&[("points.csv", b"x,y,z\n1,2\n")])), "line 2: expected three numbers, found two");
    for (archive, found) in [
        (zip(&[("a.stl", &stl), ("b.stl", &stl)]), "a ZIP archive of 2 files that is not a 3MF package; send the file itself"),
        (zip(&[]), "a ZIP archive of 0 files that is not a 3MF package; send the file itself"),
        (zip(&[("a.zip", &zip(&[("a.stl", &stl)]))]), "a ZIP archive in a ZIP archive; send the file itself"),
        (zip(&[("xl/workbook.xml", b"<a/>")]), "an Excel workbook; save the points as CSV"),
    ] {
        assert_eq!(read(archive).unwrap_err().found(), found);
    }
    let mut damaged = zip(&[("part.stl", &[stl.as_slice(), &[7; 500]].concat())]);
    let middle = 30 + "part.stl".len() + 60;
    damaged[middle] ^= 0x55;
    assert!(read(damaged).is_err());
}
