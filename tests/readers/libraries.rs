//! Tool libraries as written by Fusion, FreeCAD and spreadsheets, and libraries that are refused.

use crate::writers::{directory_alone, zip};
use approx::assert_relative_eq;
use scallopd::file_fault::{FileFault, FileFaultKind, FilePlace};
use scallopd::milling::CutterKind;
use scallopd::tooling::{FaultyTool, LibraryTool, MOST_FAULTY, MOST_TOOLS, ToolLibrary};
use serde_json::{Value, json};

fn read(bytes: impl AsRef<[u8]>) -> ToolLibrary {
    ToolLibrary::read(bytes.as_ref(), Some("mills")).unwrap()
}

/// The only tool of a library.
fn only(bytes: impl AsRef<[u8]>) -> LibraryTool {
    let library = read(bytes);
    assert_eq!(library.faulty(), []);
    let mut tools = library.into_tools();
    assert_eq!(tools.len(), 1);
    tools.remove(0)
}

/// The fault of a library that has only one.
fn refused(bytes: &[u8], file: &str) -> FileFault {
    let faults = ToolLibrary::read(bytes, Some(file)).unwrap_err();
    assert_eq!(faults.all().len(), 1, "{faults}");
    faults.all()[0].clone()
}

fn refusal(bytes: impl AsRef<[u8]>) -> String {
    refused(bytes.as_ref(), "mills").to_string()
}

/// The texts of the faulty tools of a library.
fn faulty(bytes: impl AsRef<[u8]>) -> Vec<String> {
    read(bytes).faulty().iter().map(FaultyTool::to_string).collect()
}

fn fusion(tools: &[Value]) -> Vec<u8> {
    json!({"data": tools, "version": 36}).to_string().into_bytes()
}

/// A bull nose as in Fusion's sample library: 5/8 in with a corner of 0.03 in, on a holder in millimetres, with two
/// presets.
fn bull_nose() -> Value {
    json!({
        "BMC": "carbide", "GRADE": "Mill Generic", "type": "bull nose end mill", "unit": "inches", "vendor": "", "guid": "00000000-0000-4000-8000-000000000001",
        "description": "5/8\" R.03 bull nose", "product-id": "BN-625-03", "product-link": "",
        "geometry": {"CSP": false, "DC": 0.625, "HAND": true, "LB": 1.9, "LCF": 1.25, "NOF": 4, "NT": 1, "OAL": 3.5, "RE": 0.03, "SFDM": 0.625, "SIG": 0, "TA": 0, "shoulder-length": 1.3},
        "holder": {"type": "holder", "unit": "millimeters", "description": "BT40", "segments": [{"height": 10, "lower-diameter": 40, "upper-diameter": 40}]},
        "post-process": {"break-control": false, "comment": "", "diameter-offset": 7, "length-offset": 7, "live": true, "manual-tool-change": false, "number": 7, "turret": 0},
        "start-values": {"presets": [
            {"name": "Aluminum - Roughing", "material": {"category": "all", "query": "aluminum", "use-hardness": false}, "n": 5000, "v_f": 80, "f_z": 0.004, "v_c": 818, "stepover": 0.3, "stepdown": 0.1, "use-stepover": true},
            {"name": "Aluminum - Finishing", "n": 8000.5, "v_f": 64, "f_z": 0.002, "v_c": 1309}
        ]},
        "expressions": {"tool_diameter": "0.625 in"}, "reference_guid": ""
    })
}

fn with(mut tool: Value, pointer: &str, value: Value) -> Value {
    *tool.pointer_mut(pointer).unwrap() = value;
    tool
}

fn without(mut tool: Value, parent: &str, member: &str) -> Value {
    tool.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(member);
    tool
}

#[test]
fn a_fusion_tool_in_inches_is_read_in_millimetres() {
    let tool = only(fusion(&[bull_nose()]));
    assert_eq!((tool.name.as_str(), tool.number, tool.teeth), ("5/8\" R.03 bull nose", Some(7), Some(4)));
    assert_eq!(tool.cutter.kind(), CutterKind::Toroidal);
    assert_relative_eq!(tool.cutter.outer_radius().mm(), 0.3125 * 25.4, max_relative = 1e-15);
    assert_relative_eq!(tool.cutter.corner_radius().mm(), 0.03 * 25.4, max_relative = 1e-15);
    assert_relative_eq!(tool.flute_length.unwrap().mm(), 1.25 * 25.4, max_relative = 1e-15);
}

#[test]
fn the_finishing_preset_gives_speed_and_feed() {
    let tool = only(fusion(&[bull_nose()]));
    assert_eq!((tool.preset.as_deref(), tool.spindle_speed_rpm), (Some("Aluminum - Finishing"), Some(8000.5)));
    assert_relative_eq!(tool.max_feed_per_tooth.unwrap().mm(), 0.002 * 25.4, max_relative = 1e-15);
    // Without a preset with "finish" in its name, the first preset is used.
    let tool = only(fusion(&[with(bull_nose(), "/start-values/presets/1/name", json!("Steel"))]));
    assert_eq!((tool.preset.as_deref(), tool.spindle_speed_rpm), (Some("Aluminum - Roughing"), Some(5000.0)));
    // A missing feed per tooth is computed from the feed rate: 80 / (4 5000) = 0.004 in.
    let tool = only(fusion(&[with(with(bull_nose(), "/start-values/presets/1/name", json!("")), "/start-values/presets/0/f_z", json!(0))]));
    assert_relative_eq!(tool.max_feed_per_tooth.unwrap().mm(), 0.004 * 25.4, max_relative = 1e-15);
    let tool = only(fusion(&[with(bull_nose(), "/start-values/presets", json!([]))]));
    assert_eq!((tool.preset, tool.spindle_speed_rpm, tool.max_feed_per_tooth), (None, None, None));
}

#[test]
fn a_ball_without_a_corner_radius_is_half_its_diameter() {
    let ball = with(with(bull_nose(), "/type", json!("ball end mill")), "/unit", json!("millimeters"));
    for ball in [
        without(ball.clone(), "/geometry", "RE"),
        with(ball.clone(), "/geometry/RE", json!(0)),
        with(ball.clone(), "/geometry/RE", json!(0.3125)),
    ] {
        let tool = only(fusion(&[ball]));
        assert_eq!((tool.cutter.kind(), tool.cutter.corner_radius().mm()), (CutterKind::BallEnd, 0.3125));
    }
    let flat = with(bull_nose(), "/type", json!("flat end mill"));
    for flat in [without(flat.clone(), "/geometry", "RE"), with(flat.clone(), "/geometry/RE", json!(0))] {
        assert_eq!(only(fusion(&[flat])).cutter.kind(), CutterKind::FlatEnd);
    }
}

#[test]
fn tools_other_than_finishing_cutters_are_counted_by_type() {
    let other =
        |kind: &str| json!({"type": kind, "unit": "millimeters", "geometry": {"DC": "none", "segments": [1, [2]]}, "description": kind});
    let tapered = with(bull_nose(), "/geometry/TA", json!(3));
    let library = read(fusion(&[other("drill"), bull_nose(), other("holder"), other("drill"), other("tap right hand"), tapered]));
    assert_eq!(library.tools().len(), 1);
    let others: Vec<_> = library.others().collect();
    assert_eq!(others, [("drill", 2), ("holder", 1), ("tap right hand", 1), ("tapered bull nose end mill", 1)]);
}

#[test]
fn a_tools_file_is_a_zip_with_one_library() {
    let library = read(zip(&[("tools.json", &fusion(&[bull_nose(), bull_nose()]))]));
    assert_eq!(library.tools().len(), 2);
    let utf_8 = [b"\xef\xbb\xbf".as_slice(), &fusion(&[bull_nose()])].concat();
    assert_eq!(read(utf_8).tools().len(), 1);
}

#[test]
fn faults_of_fusion_name_file_tool_and_member() {
    let unit = "\"millimeters\" or \"inches\"";
    for (tool, sentence) in [
        (without(bull_nose(), "/geometry", "DC"), "geometry.DC: expected the diameter of the cutter, found nothing".to_owned()),
        (without(bull_nose(), "/geometry", "RE"), "geometry.RE: expected the corner radius of a bull nose end mill, found nothing".into()),
        (without(bull_nose(), "", "unit"), format!("unit: expected {unit}, found nothing")),
        (with(bull_nose(), "/unit", json!("furlongs")), format!("unit: expected {unit}, found \"furlongs\"")),
        (with(bull_nose(), "/unit", json!([1])), format!("unit: expected {unit}, found an array")),
        (
            with(bull_nose(), "/geometry/DC", json!("wide")),
            "geometry.DC: expected a number with a decimal point or a decimal comma, found \"wide\"".into(),
        ),
        (
            with(bull_nose(), "/geometry/DC", json!(-1)),
            "geometry.DC: expected a length from 0.000001 mm to 1000000 mm, found -25.4 mm".into(),
        ),
        (
            with(bull_nose(), "/geometry/RE", json!(0.5)),
            "geometry.RE: expected a corner radius of at most half the diameter, 7.9375 mm, found 12.7 mm".into(),
        ),
        (with(bull_nose(), "/geometry/NOF", json!(2.5)), "geometry.NOF: expected a whole number of teeth up to 100, found 2.5".into()),
        (
            with(bull_nose(), "/post-process/number", json!(-7)),
            "post-process.number: expected a whole number that is not negative, found -7".into(),
        ),
        (
            with(bull_nose(), "/start-values/presets/1/n", json!(1e9)),
            "start-values.presets.n: expected a spindle speed from 1 to 1000000 rpm, found 1000000000".into(),
        ),
        (
            with(bull_nose(), "/type", json!("ball end mill")),
            "geometry.RE: expected half the diameter of the ball, 7.9375 mm, found 0.762 mm".into(),
        ),
        (
            with(bull_nose(), "/type", json!("flat end mill")),
            "geometry.RE: expected 0 or nothing on a flat end mill; a cutter with a corner is a bull nose, found 0.762 mm".into(),
        ),
    ] {
        let file = fusion(&[bull_nose(), tool, bull_nose()]);
        assert_eq!(faulty(&file), [format!("mills, tool 2 \"5/8\" R.03 bull nose\", {sentence}")]);
        let library = ToolLibrary::read(&zip(&[("shop/tools.json", &file)]), Some("mills.tools")).unwrap();
        assert_eq!(library.tools().len(), 2);
        let [tool] = library.faulty() else { panic!("{:?}", library.faulty()) };
        let [fault] = tool.faults() else { panic!("{tool:?}") };
        assert_eq!(tool.name(), "5/8\" R.03 bull nose");
        assert_eq!(fault.place().to_string(), "mills.tools/shop/tools.json, tool 2 \"5/8\" R.03 bull nose\"");
        assert!(fault.member().is_some_and(|member| sentence.starts_with(member)));
    }
}

#[test]
fn all_faults_of_all_tools_are_listed_and_the_other_tools_are_read() {
    let poor = with(with(bull_nose(), "/geometry/DC", json!("wide")), "/geometry/NOF", json!(2.5));
    let poor = with(with(poor, "/geometry/LCF", json!(-1)), "/start-values/presets/1/n", json!(1e9));
    let odd = with(bull_nose(), "/geometry", json!(7));
    let library = read(fusion(&[poor, bull_nose(), odd, json!(5), json!({"type": "drill", "geometry": 7})]));
    assert_eq!((library.tools().len(), library.others().collect::<Vec<_>>()), (1, vec![("drill", 1)]));
    let texts: Vec<String> = library.faulty().iter().map(FaultyTool::to_string).collect();
    assert_eq!(
        texts[0],
        "mills, tool 1 \"5/8\" R.03 bull nose\", geometry.NOF: expected a whole number of teeth up to 100, found 2.5; \
         geometry.DC: expected a number with a decimal point or a decimal comma, found \"wide\"; \
         geometry.LCF: expected a length from 0.000001 mm to 1000000 mm, found -25.4 mm; \
         start-values.presets.n: expected a spindle speed from 1 to 1000000 rpm, found 1000000000"
    );
    assert_eq!(texts.len(), 3);
    assert!(texts[1].starts_with("mills, tool 3: expected a tool in JSON, found integer `7`, a value of another type"), "{}", texts[1]);
    assert!(texts[2].starts_with("mills, tool 4: expected a tool in JSON, found integer `5`, a value of another type"), "{}", texts[2]);
    // Beyond the limit, faulty tools are only counted.
    let many = format!("name,type,diameter_mm\n{}B6,ball_end,6\n", "A,ball_end,-1\n".repeat(MOST_FAULTY + 50));
    let library = read(many);
    assert_eq!((library.tools().len(), library.faulty().len(), library.unlisted_faulty()), (1, MOST_FAULTY, 50));
}

fn bit(name: &str, shape: &str, parameters: &Value) -> Vec<u8> {
    json!({"version": 2, "name": name, "shape": shape, "parameter": parameters, "attribute": {}}).to_string().into_bytes()
}

#[test]
fn freecad_tools_carry_units_and_decimal_commas() {
    let tool = only(bit(
        "6 mm Ball End",
        "ballend.fcstd",
        &json!({"CuttingEdgeHeight": "40,0000 mm", "Diameter": "5,00 mm", "Flutes": "0", "Length": "50,00 mm", "Chipload": "0,0000 mm"}),
    ));
    assert_eq!(
        (tool.name.as_str(), tool.cutter.kind(), tool.teeth, tool.max_feed_per_tooth),
        ("6 mm Ball End", CutterKind::BallEnd, None, None)
    );
    assert_eq!((tool.cutter.outer_radius().mm(), tool.flute_length.unwrap().mm()), (2.5, 40.0));
    for (shape, parameters, corner) in [
        ("bullnose.fcstd", json!({"Diameter": "6.0000 mm", "FlatRadius": "1.5000 mm", "Flutes": 4}), 1.5),
        ("Shapes/bullnose.fcstd", json!({"Diameter": "6.0000 mm", "CornerRadius": "0.5 mm", "Chipload": "0.05 mm"}), 0.5),
        ("torus.fcstd", json!({"Diameter": "0.25 in", "TorusRadius": "0.0625 in"}), 1.5875),
        ("endmill.fcstd", json!({"Diameter": "5.00 mm"}), 0.0),
        ("bullnose.fcstd", json!({"Diameter": "6 mm", "FlatRadius": "3 mm"}), 0.0),
        ("bullnose.fcstd", json!({"Diameter": "6 mm", "FlatRadius": "0 mm"}), 3.0),
    ] {
        assert_relative_eq!(only(bit("a", shape, &parameters)).cutter.corner_radius().mm(), corner, max_relative = 1e-14);
    }
    let mut second: Value = serde_json::from_slice(&bit("a", "mine.fcstd", &json!({"Diameter": "5.00 mm"}))).unwrap();
    second["shape-type"] = json!("Ballend");
    assert_eq!(only(second.to_string()).cutter.kind(), CutterKind::BallEnd);
    assert_eq!(read(bit("a", "drill.fcstd", &json!({}))).others().collect::<Vec<_>>(), [("drill", 1)]);
}

#[test]
fn a_zip_of_freecad_tools_takes_their_numbers_from_the_list() {
    let list = json!({"tools": [{"nr": 3, "path": "ball.fctb"}, {"nr": 12, "path": "Bit/END.fctb"}], "version": 1}).to_string();
    let ball = bit("ball", "ballend.fcstd", &json!({"Diameter": "6.0 mm", "Flutes": "2"}));
    let end = bit("end", "endmill.fcstd", &json!({"Diameter": "8.0 mm"}));
    let files: [(&str, &[u8]); 5] = [
        ("Bit/ball.fctb", &ball),
        ("Bit/end.fctb", &end),
        ("Library/mine.fctl", list.as_bytes()),
        ("Shape/a.fcstd", b"PK\x03\x04"),
        ("__MACOSX/._ball.fctb", b"\0\x05"),
    ];
    let library = read(zip(&files));
    let tools: Vec<_> = library.tools().iter().map(|tool| (tool.name.as_str(), tool.number)).collect();
    assert_eq!((tools, library.skipped_files()), (vec![("ball", Some(3)), ("end", Some(12))], 2));
    let library = read(zip(&files[1..]));
    assert_eq!(library.tools().len(), 1);
    assert_eq!(
        library.faulty()[0].to_string(),
        "mills/Library/mine.fctl, tool 1 \"ball.fctb\", path: expected every listed tool in the zip, found no file \"ball.fctb\" in the zip"
    );
    assert!(refusal(list).contains("send a zip of them all"));
}

#[test]
fn tool_files_that_no_list_of_the_zip_names_are_counted_not_read() {
    let list = |path: &str| json!({"tools": [{"nr": 1, "path": path}], "version": 1}).to_string().into_bytes();
    let ball = |name: &str| bit(name, "ballend.fcstd", &json!({"Diameter": "6.0 mm"}));
    let (one, other) = (list("Bit/a.fctb"), list("b.fctb"));
    let (a, b, c) = (ball("a"), ball("b"), ball("c"));
    let bits: [(&str, &[u8]); 3] = [("Bit/a.fctb", &a), ("Bit/b.fctb", &b), ("Bit/c.fctb", &c)];
    let named = |lists: &[(&str, &[u8])]| {
        let library = read(zip(&[&bits, lists].concat()));
        assert_eq!(library.faulty(), []);
        let names: Vec<_> = library.tools().iter().map(|tool| tool.name.clone()).collect();
        (names.join(" "), library.unlisted_files())
    };
    assert_eq!(named(&[]), ("a b c".to_owned(), 0));
    assert_eq!(named(&[("Library/one.fctl", &one)]), ("a".to_owned(), 2));
    assert_eq!(named(&[("Library/one.fctl", &one), ("Library/other.fctl", &other)]), ("a b".to_owned(), 1));
    // A tool file that is not JSON is a faulty tool. A list that is not JSON is a fault of the library.
    let broken: [(&str, &[u8]); 2] = [("a.fctb", &a), ("b.fctb", b"{")];
    let library = read(zip(&broken));
    assert_eq!((library.tools().len(), library.faulty().len()), (1, 1));
    assert!(library.faulty()[0].to_string().starts_with("mills/b.fctb, tool 1: expected a tool of FreeCAD in JSON"));
    let broken: [(&str, &[u8]); 4] = [("a.fctb", &a), ("x.fctl", b"{"), ("y.fctl", b"[]"), ("z.fctl", &other)];
    let faults = ToolLibrary::read(&zip(&broken), Some("mills")).unwrap_err();
    let places: Vec<String> = faults.all().iter().map(|fault| fault.place().to_string()).collect();
    assert_eq!(places, ["mills/x.fctl", "mills/y.fctl"]);
}

#[test]
fn faults_of_freecad_name_the_member() {
    for (shape, parameters, sentence) in [
        (
            "ballend.fcstd",
            json!({"Diameter": "6"}),
            "parameter.Diameter: expected a length with its unit, such as \"6.0 mm\" or \"0.25 in\", found \"6\"",
        ),
        ("ballend.fcstd", json!({}), "parameter.Diameter: expected the diameter of the cutter, found nothing"),
        (
            "ballend.fcstd",
            json!({"Diameter": "1,000.5 mm"}),
            "parameter.Diameter: expected a number with a decimal point or a decimal comma, found \"1,000.5\"",
        ),
        (
            "bullnose.fcstd",
            json!({"Diameter": "6 mm"}),
            "parameter.CornerRadius: expected the corner radius of a bull nose end mill, found nothing",
        ),
        (
            "bullnose.fcstd",
            json!({"Diameter": "6 mm", "FlatRadius": "4 mm"}),
            "parameter.FlatRadius: expected a flat inside the diameter, of a radius up to 3 mm, found 4 mm",
        ),
        (
            "ballend.fcstd",
            json!({"Diameter": "6 mm", "Flutes": "two"}),
            "parameter.Flutes: expected a number with a decimal point or a decimal comma, found \"two\"",
        ),
    ] {
        assert_eq!(faulty(bit("a", shape, &parameters)), [format!("mills, tool 1 \"a\", {sentence}")]);
    }
}

#[test]
fn a_table_is_read_in_any_layout() {
    let comma = "name,type,diameter_mm,corner_radius_mm,teeth,spindle_speed_rpm,max_feed_per_tooth_mm\nB6,ball_end,6.0,,2,12000,0.05\nT10,toroidal,10,1.5,4,,\n";
    let semicolon = "\u{feff}sep=;\r\nNumber;Name;Type;Diameter mm;corner_radius_mm;Flute length mm;teeth;vendor\r\n5;B6;ball end;6,0;3,0;12,5;2;x\r\n\r\n6;T10;bull nose;10;1,5;;4;y\r\n";
    for text in [comma.to_owned(), comma.replace(',', "\t").replace('.', ","), semicolon.to_owned(), comma.replace("6.0", "\"6,0\"")] {
        let tools = read(&text).into_tools();
        let described: Vec<_> = tools
            .iter()
            .map(|tool| (tool.name.as_str(), tool.cutter.outer_radius().mm(), tool.cutter.corner_radius().mm(), tool.teeth))
            .collect();
        assert_eq!(described, [("B6", 3.0, 3.0, Some(2)), ("T10", 5.0, 1.5, Some(4))], "{text}");
    }
    assert_relative_eq!(read(semicolon).tools()[0].flute_length.unwrap().mm(), 12.5, max_relative = 1e-15);
    let utf_16: Vec<u8> = format!("\u{feff}{comma}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(read(utf_16).tools().len(), 2);
    let inches = only("type,diameter_in,number,name\nflat_end,0.5,9,\n");
    assert_relative_eq!(inches.cutter.outer_radius().mm(), 6.35, max_relative = 1e-15);
    assert_eq!((inches.name.as_str(), inches.number), ("tool 9", Some(9)));
}

#[test]
fn faults_of_a_table_name_line_and_column() {
    let head = "name,type,diameter_mm,corner_radius_mm,teeth\n";
    for (row, sentence) in [
        ("A,toroidal,10,,4", "tool 1 \"A\", corner_radius: expected the corner radius of a bull nose end mill, found nothing"),
        ("A,toroidal,10,6,4", "tool 1 \"A\", corner_radius: expected a corner radius of at most half the diameter, 5 mm, found 6 mm"),
        ("A,ball_end,,,", "tool 1 \"A\", diameter: expected the diameter of the cutter, found nothing"),
        ("A,ball_end,six,,", "tool 1 \"A\", diameter: expected a number with a decimal point or a decimal comma, found \"six\""),
        ("A,ball_end,6,5,,,2", "tool 1 \"A\": expected 5 fields, as the header has, found 7"),
        ("A,ball_end,6", "tool 1 \"A\": expected 5 fields, as the header has, found 3"),
        ("A,,6,,", "tool 1 \"A\", type: expected ball_end, toroidal, flat_end or another type, found nothing"),
    ] {
        let library = read(format!("{head}B6,ball_end,6,,2\n{row}\nB8,ball_end,8,,2\n"));
        assert_eq!(library.tools().len(), 2);
        assert_eq!(library.faulty()[0].to_string(), format!("mills, {}", sentence.replacen('1', "2", 1)));
    }
    assert_eq!(
        faulty(format!("{head}A,toroidal,six,x,2.5\n")),
        ["mills, tool 1 \"A\", diameter: expected a number with a decimal point or a decimal comma, found \"six\"; \
          teeth: expected a whole number of teeth up to 100, found 2.5"]
    );
    let faults = ToolLibrary::read(b"name,diameter,corner_radius_cm,teeth,teeth\n", Some("mills")).unwrap_err();
    assert_eq!(faults.all().len(), 4, "{faults}");
    assert_eq!(refusal("type,diameter\nball_end,6\n"), "mills: expected diameter_mm or diameter_in, found \"diameter\"");
    assert_eq!(
        refusal("type,diameter_mm,diameter_in\n"),
        "mills: expected each quantity in one column, in one unit, found \"diameter_in\" again"
    );
}

#[test]
fn a_spindle_speed_with_a_mark_between_thousands_is_refused() {
    let speeds =
        [("12000", Some(12e3)), ("12000.5", Some(12_000.5)), ("\"8500,25\"", Some(8500.25)), ("\"12,000\"", None), ("12.000", None)];
    for (speed, rpm) in speeds {
        let library = read(format!("name,type,diameter_mm,spindle_speed_rpm\nA,ball_end,6,{speed}\n"));
        assert_eq!(library.tools().first().and_then(|tool| tool.spindle_speed_rpm), rpm, "{speed}");
        if rpm.is_none() {
            let found = format!("\"{}\": either three decimals, or a mark between thousands", speed.trim_matches('"'));
            let sentence = format!("expected a spindle speed without a mark between thousands, found {found}");
            assert_eq!(library.faulty()[0].to_string(), format!("mills, tool 1 \"A\", spindle_speed_rpm: {sentence}"));
        }
    }
}

#[test]
fn files_other_than_libraries_are_refused() {
    for (file, kind) in [
        (b"".as_slice(), FileFaultKind::Empty),
        (b"solid part\n", FileFaultKind::UnknownFormat),
        (b"x,y,z\n1,2,3\n", FileFaultKind::UnknownFormat),
        (b"\x89PNG\r\n\x1a\n\0\0", FileFaultKind::UnknownFormat),
        (b"{}", FileFaultKind::UnknownFormat),
        (b"[1, 2]", FileFaultKind::Malformed),
        (b"{\"data\": 5}", FileFaultKind::Malformed),
        (b"{\"data\": []}", FileFaultKind::Empty),
        (b"{\"data\": [{\"type\": \"drill\"}", FileFaultKind::Malformed),
        (b"type,diameter_mm\n", FileFaultKind::Empty),
        (b"PK\x03\x04 and nothing else", FileFaultKind::Malformed),
    ] {
        let faults = ToolLibrary::read(file, None).unwrap_err();
        let [fault] = faults.all() else { panic!("{faults}") };
        assert_eq!(fault.kind(), kind, "{fault}");
        assert_eq!(*fault.place(), FilePlace::Tool { file: "the library".into(), tool: None });
    }
}

#[test]
fn hostile_libraries_are_refused_within_their_limits() {
    let kind = |bytes: &[u8]| refused(bytes, "bomb").kind();
    let zeros = vec![b' '; 40 << 20];
    assert_eq!(kind(&zip(&[("a.json", &zeros)])), FileFaultKind::TooLarge);
    // Every entry is within the limit, but not their sum.
    let quarter = zeros[..10 << 20].to_vec();
    let bomb: Vec<(String, &[u8])> = (0..5).map(|index| (format!("{index}.csv"), quarter.as_slice())).collect();
    let bomb: Vec<(&str, &[u8])> = bomb.iter().map(|(name, content)| (name.as_str(), *content)).collect();
    assert_eq!(kind(&zip(&bomb)), FileFaultKind::TooLarge);
    let inner = zip(&[("tools.json", &fusion(&[bull_nose()]))]);
    for name in ["a.tools", "a.zip", "a.json"] {
        let fault = refused(&zip(&[(name, &inner)]), "b.zip");
        assert_eq!(fault.to_string(), format!("b.zip/{name}: expected no zip inside a zip, found one"));
    }
    let many = "B6,ball_end,6\n".repeat(MOST_TOOLS + 1);
    assert_eq!(kind(format!("name,type,diameter_mm\n{many}").as_bytes()), FileFaultKind::TooLarge);
    let drills = format!("{{\"data\": [{}{{\"type\": \"drill\"}}]}}", "{\"type\": \"drill\"},".repeat(MOST_TOOLS));
    assert_eq!(kind(drills.as_bytes()), FileFaultKind::TooLarge);
    let deep = format!("{{\"data\": [{}", "[".repeat(1 << 20));
    assert_eq!(kind(deep.as_bytes()), FileFaultKind::Malformed);
    let list = format!("{{\"tools\": [{}{{}}]}}", "{},".repeat(1 << 20));
    assert_eq!(kind(&zip(&[("a.fctl", list.as_bytes())])), FileFaultKind::Malformed);
    assert_eq!(kind(",".repeat(5 << 20).as_bytes()), FileFaultKind::TooLarge);
    assert_eq!(kind(&vec![b'x'; 33 << 20]), FileFaultKind::TooLarge);
}

#[test]
fn a_zip_of_many_entries_is_refused_at_the_limit() {
    let fault = refused(&directory_alone(600_000), "many.zip");
    assert_eq!((fault.kind(), fault.found()), (FileFaultKind::TooLarge, "a ZIP archive of more than 20000 entries"));
}

/// The shapes of a library's tools: outer and corner radius, in mm.
fn radii(bytes: impl AsRef<[u8]>) -> Vec<[f64; 2]> {
    let library = read(bytes);
    assert_eq!(library.faulty(), []);
    let round = |mm: f64| (mm * 1e6).round() / 1e6;
    library.tools().iter().map(|tool| [round(tool.cutter.outer_radius().mm()), round(tool.cutter.corner_radius().mm())]).collect()
}

const FUSION_TABLE: &str = "\"Tool Index (tool_index)\",\"Type (tool_type)\",\"Description (tool_description)\",\"Diameter (tool_diameter)\",\"Unit (tool_unit)\",\"Corner Radius (tool_cornerRadius)\",\"Feed per Tooth (tool_feedPerTooth)\",\"Number of Flutes (tool_numberOfFlutes)\",\"Spindle Speed (tool_spindleSpeed)\"\n1,\"ball end mill\",\"quarter ball\",0.25,\"inches\",0.125,0.002,2,18000\n2,\"bull nose end mill\",\"BN\",10,\"millimeters\",1,0.05,4,9000\n";

#[test]
fn the_table_that_fusion_exports_is_read() {
    assert_eq!(radii(FUSION_TABLE), [[3.175, 3.175], [5.0, 1.0]]);
    // The clipboard separates by tabs.
    assert_eq!(radii(FUSION_TABLE.replace(',', "\t")), [[3.175, 3.175], [5.0, 1.0]]);
    let library = read(FUSION_TABLE);
    let [ball, bull] = library.tools() else { panic!("{library:?}") };
    assert_eq!((ball.name.as_str(), ball.teeth, ball.spindle_speed_rpm), ("quarter ball", Some(2), Some(18000.0)));
    assert_relative_eq!(ball.max_feed_per_tooth.unwrap().mm(), 0.0508, max_relative = 1e-15);
    assert_relative_eq!(bull.max_feed_per_tooth.unwrap().mm(), 0.05, max_relative = 1e-15);
    assert!(faulty(FUSION_TABLE.replace("inches", "yards"))[0].contains("expected mm or inches, found \"yards\""));
}

#[test]
fn names_of_columns_and_types_in_catalogues_are_read() {
    for (table, expected) in [
        ("Type,Diameter (mm)\nballnose,6\n", [[3.0, 3.0]]),
        ("type;Diameter [mm];Corner Radius [mm]\nbullnose;10;1,5\n", [[5.0, 1.5]]),
        ("Type\tDia (in)\tFlutes\nSquare End Mill\t0.5\t4\n", [[6.35, 0.0]]),
        ("Description,Type,Diameter (inch)\nX,endmill,0.25\n", [[3.175, 0.0]]),
        ("type,diameter,unit\nball nose,6,mm\n", [[3.0, 3.0]]),
        ("type,diameter,corner radius,units\ncorner radius,0.5,0.0625,inches\n", [[6.35, 1.5875]]),
        ("type,DC (mm),RE (mm),LCF (mm),RPM\ntoroidal,8,2,20,9000\n", [[4.0, 2.0]]),
    ] {
        assert_eq!(radii(table), expected, "{table}");
    }
    let other = read("type,diameter_mm\nlollipop,6\nball,4\n");
    assert_eq!((other.tools().len(), other.others().collect::<Vec<_>>()), (1, vec![("lollipop", 1)]));
    assert!(refusal("type,diameter (cm)\nball,6\n").contains("expected diameter_mm or diameter_in, found \"diameter (cm)\""));
}

#[test]
fn shapes_of_the_better_tool_library_are_read() {
    let tool = |shape: &str, parameters: Value| {
        json!({"version": 2, "name": "x", "shape": shape, "parameter": parameters, "attribute": {}}).to_string()
    };
    assert_eq!(
        radii(tool("_fusion_ball_end_mill.fcstd", json!({"Diameter": "0,25 in", "CuttingEdgeHeight": "1,0 in", "Flutes": "2"}))),
        [[3.175, 3.175]]
    );
    assert_eq!(
        radii(tool("_fusion_bull_nose_end_mill.fcstd", json!({"Diameter": "10 mm", "TorusRadius": "1 mm", "Flutes": "4"}))),
        [[5.0, 1.0]]
    );
    assert_eq!(radii(tool("_fusion_flat_end_mill.fcstd", json!({"Diameter": "8 mm"}))), [[4.0, 0.0]]);
    let chamfer = read(tool("_fusion_chamfer_mill.fcstd", json!({"Diameter": "8 mm"})));
    assert_eq!(chamfer.others().collect::<Vec<_>>(), [("_fusion_chamfer_mill", 1)]);
}

#[test]
fn messages_name_no_type_of_the_program() {
    for library in [
        json!({"data": ["x"]}).to_string(),
        json!({"data": [5]}).to_string(),
        json!({"data": [{"type": "ball end mill", "geometry": 7}]}).to_string(),
    ] {
        for text in faulty(library) {
            assert!(!text.contains("struct") && text.contains("a value of another type"), "{text}");
        }
    }
}

/// The tools of a library with their kinds, outer radii and tip radii in mm.
fn shapes_of(bytes: impl AsRef<[u8]>) -> Vec<(CutterKind, f64, f64)> {
    let library = read(bytes);
    assert_eq!(library.faulty(), []);
    let rounded = |mm: f64| (mm * 1e6).round() / 1e6;
    let shape =
        |tool: LibraryTool| (tool.cutter.kind(), rounded(tool.cutter.outer_radius().mm()), rounded(tool.cutter.corner_radius().mm()));
    library.into_tools().into_iter().map(shape).collect()
}

/// Fusion states a tapered mill by the diameter of its cone at the height of the tip: 1.872 mm for a ball of 1 mm and 3.8 deg.
#[test]
fn tapered_mills_and_circle_segments_of_fusion_are_read() {
    let tool = |kind: &str, geometry: Value| json!({"type": kind, "unit": "millimeters", "geometry": geometry, "description": kind});
    let tools = [
        tool("tapered mill", json!({"DC": 1.872, "RE": 1, "TA": 3.8, "SFDM": 6, "LCF": 15})),
        // Without a shank the cone ends with the flutes: 1.872 + 2 * 15 tan(3.8 deg) = 3.864598 mm.
        tool("tapered mill", json!({"DC": 1.872, "RE": 1, "TA": 3.8, "LCF": 15})),
        tool("tapered mill", json!({"DC": 3, "RE": 0.5, "TA": 5, "SFDM": 6})),
        tool("tapered mill", json!({"DC": 3, "RE": 0, "TA": 5, "SFDM": 6})),
        tool("circle segment lens", json!({"DC": 10, "RE": 0.5, "lower-radius": 20, "profile-radius": 100})),
        tool("circle segment oval", json!({"DC": 6, "RE": 0, "lower-radius": 1, "profile-radius": 90})),
        tool("circle segment taper", json!({"DC": 16, "TA": 20, "lower-radius": 4, "profile-radius": 500, "upper-radius": 8})),
    ];
    let expected = [
        (CutterKind::TaperedBall, 3.0, 1.000_231),
        (CutterKind::TaperedBall, 1.932_299, 1.000_231),
        (CutterKind::Profile, 3.0, 0.5),
        (CutterKind::Profile, 3.0, 0.0),
        (CutterKind::Lens, 5.0, 20.0),
        (CutterKind::Oval, 3.0, 1.0),
        (CutterKind::ConicalBarrel, 8.0, 4.0),
    ];
    let found = shapes_of(fusion(&tools));
    for (found, expected) in found.iter().zip(expected) {
        assert_eq!(found.0, expected.0);
        assert_relative_eq!(found.1, expected.1, epsilon = 1e-6);
        assert_relative_eq!(found.2, expected.2, epsilon = 1e-6);
    }
    assert_eq!(found.len(), expected.len());
    // The cone of 5 deg at a flat of 3 mm: 1 mm up its radius is 1.5 + tan(5 deg).
    let flat = read(fusion(&tools)).into_tools()[3].cutter.profile();
    assert_relative_eq!(flat.low(1.5 + 5.0_f64.to_radians().tan()), 1.0, max_relative = 1e-12);
    for (tool, fault) in [
        (tool("tapered mill", json!({"DC": 3, "RE": 0.5, "SFDM": 6})), "geometry.TA: expected the taper"),
        (tool("tapered mill", json!({"DC": 3, "RE": 4, "TA": 5, "SFDM": 6})), "geometry.RE: expected a corner radius of at most"),
        (tool("tapered mill", json!({"DC": 3, "RE": 0.5, "TA": 5})), "geometry.SFDM: expected the diameter of the shank"),
        (tool("circle segment oval", json!({"DC": 6, "profile-radius": 90})), "geometry.lower-radius: expected the radius of the tip"),
        (tool("circle segment lens", json!({"DC": 10, "lower-radius": 20})), "geometry.RE: expected the corner radius of a lens"),
        (
            tool("circle segment taper", json!({"DC": 16, "TA": 20, "lower-radius": 4, "profile-radius": 9, "upper-radius": 8})),
            "geometry.profile-radius: expected",
        ),
    ] {
        let texts = faulty(fusion(&[tool]));
        assert!(texts.len() == 1 && texts[0].contains(fault), "{texts:?}");
    }
}

/// FreeCAD states the angle between the flanks.
#[test]
fn tapered_balls_of_freecad_are_read() {
    let tool = |parameters: Value| {
        json!({"version": 2, "name": "x", "shape": "taperedballnose.fcstd", "shape-type": "TaperedBallNose", "parameter": parameters})
            .to_string()
    };
    let parameters = json!({"Diameter": "2.00 mm", "TaperAngle": "10.00 \u{b0}", "TaperDiameter": "5,00 mm", "ShankDiameter": "6 mm"});
    let read = only(tool(parameters.clone()));
    assert_eq!((read.cutter.kind(), read.cutter.outer_radius().mm()), (CutterKind::TaperedBall, 2.5));
    assert_relative_eq!(read.cutter.profile().steepest_cut().to_degrees(), 85.0, max_relative = 1e-12);
    let mut without = parameters;
    without.as_object_mut().unwrap().remove("TaperDiameter");
    assert_relative_eq!(only(tool(without.clone())).cutter.outer_radius().mm(), 3.0);
    without.as_object_mut().unwrap().remove("TaperAngle");
    assert!(faulty(tool(without))[0].contains("parameter.TaperAngle: expected the taper"));
}

#[test]
fn a_table_can_state_every_shape() {
    let table = "type,diameter_mm,corner_radius_mm,taper_deg,shank_diameter_mm,lens_radius_mm,tip_radius_in,side_radius_mm\n\
        tapered_ball,2,,5,6,,,\nlens,16,1,,,40,,\noval,10,,,,,0.1,80\nconical barrel,10,,20,,,0.1,250\n";
    assert_eq!(
        shapes_of(table),
        [
            (CutterKind::TaperedBall, 3.0, 1.0),
            (CutterKind::Lens, 8.0, 40.0),
            (CutterKind::Oval, 5.0, 2.54),
            (CutterKind::ConicalBarrel, 5.0, 2.54),
        ]
    );
    assert!(faulty("type,diameter_mm\ntapered ball,6\n")[0].contains("taper_deg: expected the taper"));
    // The columns of others' tables that state no unit are not read.
    assert_eq!(shapes_of("type,diameter_mm,Shank Diameter,Tip Radius\nball,6,x,y\n"), [(CutterKind::BallEnd, 3.0, 3.0)]);
}
