//! Tool libraries of an upload: faulty tools, tools that are left out, and presets.

use crate::app::{Answer, TestApp, warnings};
use crate::planning::{job, with};
use crate::writers::zip;
use serde_json::{Value, json};

const SURFACE: &str = "x,y,z\n0,0,0\n60,0,0\n0,20,11\n60,20,11\n30,10,5.7\n";

/// A groove whose sides are at 18 deg.
const GROOVE: &str = "x,y,z\n0,0,10\n30,0,0\n60,0,10\n0,20,10\n30,20,0\n60,20,10\n";

async fn upload(app: &TestApp, libraries: &[&[u8]], own: Value) -> Answer {
    upload_surface(app, SURFACE, libraries, own).await
}

/// The answer to a surface with these libraries and no other cutters than `own`.
async fn upload_surface(app: &TestApp, surface: &str, libraries: &[&[u8]], own: Value) -> Answer {
    let mut parameters = with(job(), json!({"method": "surface", "directions_deg": [0], "cutters": own}));
    if parameters["cutters"].is_null() {
        parameters.as_object_mut().unwrap().remove("cutters");
    }
    let mut parts = vec![("surface", surface.as_bytes().to_vec()), ("parameters", parameters.to_string().into_bytes())];
    parts.extend(libraries.iter().map(|library| ("library", library.to_vec())));
    app.upload_parts(parts).await
}

fn table(rows: &str) -> Vec<u8> {
    format!("name,type,diameter_mm,corner_radius_mm,teeth\n{rows}").into_bytes()
}

fn names(answer: &Value, list: &str) -> Vec<String> {
    answer[list].as_array().unwrap().iter().map(|cutter| cutter["name"].as_str().unwrap().to_owned()).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn faulty_tools_are_not_ranked_with_their_faults_and_the_others_are() {
    let app = TestApp::start().await;
    let first = table("B6,ball_end,6,,2\nbad,toroidal,10,7,2.5\nT8,toroidal,8,2,4\n");
    let second = table(",ball_end,six,,\nF8,flat_end,8,,\n");
    let own = json!([{"name": "own", "type": "ball_end", "diameter_mm": 5}]);
    let answer = upload(&app, &[&first, &second], own).await.ok();
    let mut ranked = names(&answer, "candidates");
    let not_ranked = answer["not_ranked"].as_array().unwrap();
    let faulty: Vec<_> = not_ranked.iter().filter(|tool| tool["code"] == "faulty-tool").collect();
    // The sharp flat-end cutter may be ranked or not; what matters is that it was read.
    ranked.extend(not_ranked.iter().filter(|tool| tool["code"] != "faulty-tool").map(|tool| tool["name"].as_str().unwrap().to_owned()));
    ranked.sort_unstable();
    assert_eq!(ranked, ["B6", "F8", "T8", "own"]);
    // Their positions follow those of the four cutters that were read.
    let shown: Vec<_> = faulty.iter().map(|tool| (tool["cutter"].as_u64().unwrap(), tool["name"].as_str().unwrap())).collect();
    assert_eq!(shown, [(4, "bad"), (5, "tool 1")]);
    let detail = faulty[0]["detail"].as_str().unwrap();
    for part in ["tool 2 \"bad\"", "corner_radius: expected", "teeth: expected a whole number of teeth"] {
        assert!(detail.contains(part), "{part} is not in {detail}");
    }
    assert!(warnings(&answer).contains(&"faulty-tools"), "{:?}", warnings(&answer));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn libraries_of_faulty_tools_alone_are_refused_with_all_their_faults() {
    let app = TestApp::start().await;
    let (one, other) = (table("A,ball_end,-6,,\nB,toroidal,10,7,200\n"), table("C,ball_end,0,,\n"));
    let answer = upload(&app, &[&one, &other], Value::Null).await;
    let (_, faults) = answer.faults();
    let expected = [("/library/0", "out-of-range"); 3].into_iter().chain([("/library/1", "malformed-file")]);
    assert_eq!(faults, expected.collect::<Vec<_>>(), "{}", answer.body);
    for (error, part) in
        answer.body["errors"].as_array().unwrap().iter().zip(["tool 1 \"A\"", "tool 2 \"B\"", "tool 2 \"B\"", "tool 1 \"C\""])
    {
        assert!(error["detail"].as_str().unwrap().contains(part), "{error}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_library_that_cannot_be_read_is_refused_with_the_faults_of_its_tools() {
    let app = TestApp::start().await;
    let libraries = zip(&[("a.csv", &table("A,ball_end,-6,,\n")), ("b.json", b"{\"data\": ["), ("c.csv", b"type,diameter\n")]);
    let own = json!([{"type": "ball_end", "diameter_mm": 5}]);
    let answer = upload(&app, &[&libraries, b"nothing known"], own).await;
    let details: Vec<_> = answer.body["errors"].as_array().unwrap().iter().map(|error| error["detail"].as_str().unwrap()).collect();
    assert_eq!(details.len(), 4, "{details:?}");
    for (detail, part) in details.iter().zip(["/b.json", "/c.csv: expected diameter_mm or diameter_in", "/a.csv, tool 1 \"A\"", "CSV"]) {
        assert!(detail.contains(part), "{part} is not in {detail}");
    }
    assert_eq!(answer.status, 400);
}

/// The answer to a surface with these libraries, chosen from by `filter`.
async fn filtered(app: &TestApp, libraries: &[&[u8]], filter: Value) -> Answer {
    let mut parameters = with(job(), json!({"method": "surface", "directions_deg": [0], "library_filter": filter}));
    parameters.as_object_mut().unwrap().remove("cutters");
    let mut parts = vec![("surface", SURFACE.as_bytes().to_vec()), ("parameters", parameters.to_string().into_bytes())];
    parts.extend(libraries.iter().map(|library| ("library", library.to_vec())));
    app.upload_parts(parts).await
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_filter_chooses_from_libraries_by_diameter_type_and_number() {
    let app = TestApp::start().await;
    let library = b"number,name,type,diameter_mm,corner_radius_mm\n1,B4,ball_end,4,\n2,B6,ball_end,6,\n3,T6,bull_nose,6,1\n7,T8,toroidal,8,2\n,T9,toroidal,9,2\n";
    for (filter, expected) in [
        (json!({}), vec!["B4", "B6", "T6", "T8", "T9"]),
        (json!({"diameter_mm": [6, 8]}), vec!["B6", "T6", "T8"]),
        (json!({"types": ["ball_end"]}), vec!["B4", "B6"]),
        (json!({"types": ["bull_nose", "flat_end"]}), vec!["T6", "T8", "T9"]),
        (json!({"numbers": [7, 1, 99]}), vec!["B4", "T8"]),
        (json!({"diameter_mm": [5, 20], "types": ["toroidal"], "numbers": [1, 2, 3]}), vec!["T6"]),
    ] {
        let answer = filtered(&app, &[library], filter.clone()).await.ok();
        let mut ranked = names(&answer, "candidates");
        ranked.extend(names(&answer, "not_ranked"));
        ranked.sort_unstable();
        assert_eq!(ranked, expected, "{filter}");
    }
    for (filter, fault) in [
        (json!({"diameter_mm": [20, 30]}), ("/cutters", "missing-field")),
        (json!({"diameter_mm": [8, 6]}), ("/library_filter/diameter_mm", "out-of-range")),
        (json!({"diameter_mm": [8]}), ("/library_filter/diameter_mm", "wrong-count")),
        (json!({"types": ["drill"]}), ("/library_filter/types/0", "unknown-value")),
        (json!({"numbers": [1.5]}), ("/library_filter/numbers/0", "wrong-type")),
        (json!({"vendor": "x"}), ("/library_filter/vendor", "unknown-field")),
    ] {
        assert_eq!(filtered(&app, &[library], filter).await.faults(), (422, vec![fault]));
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn more_than_two_hundred_cutters_of_libraries_are_refused_with_the_filter_as_the_way_out() {
    let app = TestApp::start().await;
    let rows = (0..201).map(|number| format!("B{number},ball_end,{},,\n", 4 + number % 40)).collect::<Vec<_>>().concat();
    let answer = upload(&app, &[&table(&rows)], Value::Null).await;
    assert_eq!(answer.faults(), (422, vec![("/cutters", "too-many-items")]));
    let detail = answer.body["errors"][0]["detail"].as_str().unwrap();
    assert!(detail.contains("there are 201") && detail.contains("library_filter"), "{detail}");
    filtered(&app, &[&table(&rows)], json!({"diameter_mm": [4, 4.5]})).await.ok();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_surface_that_no_cutter_fits_names_the_faulty_tools_too() {
    let app = TestApp::start().await;
    let own = json!([{"name": "B500", "type": "ball_end", "diameter_mm": 500}]);
    let answer = upload_surface(&app, GROOVE, &[&table("bad,ball_end,-6,,\n")], own).await;
    assert_eq!((answer.status, &answer.body["type"]), (422, &json!("no-cutter-fits")), "{}", answer.body);
    assert_eq!(names(&answer.body, "not_ranked"), ["B500", "bad"]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn very_many_faulty_tools_are_counted_beyond_the_first_hundred() {
    let app = TestApp::start().await;
    let many = table(&format!("{}B6,ball_end,6,,2\n", "A,ball_end,-6,,\n".repeat(5000)));
    let answer = upload(&app, &[&many, &many], Value::Null).await.ok();
    assert_eq!(answer["not_ranked"].as_array().unwrap().len(), 100);
    let warning = answer["warnings"].as_array().unwrap().iter().find(|warning| warning["code"] == "faulty-tools").unwrap();
    let detail = "finishing cutters of the libraries that cannot be used: 10000; the first of them are in not_ranked, with their faults";
    assert_eq!(warning["detail"], detail);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn tools_that_no_list_of_a_zip_names_are_counted_in_a_warning() {
    let app = TestApp::start().await;
    let ball = |name: &str| json!({"version": 2, "name": name, "shape": "ballend.fcstd", "parameter": {"Diameter": "6 mm"}}).to_string();
    let (listed, unlisted) = (ball("listed"), ball("unlisted"));
    let list = json!({"tools": [{"nr": 1, "path": "a.fctb"}]}).to_string();
    let library = zip(&[("a.fctb", listed.as_bytes()), ("b.fctb", unlisted.as_bytes()), ("mine.fctl", list.as_bytes())]);
    let answer = upload(&app, &[&library], Value::Null).await.ok();
    assert_eq!(names(&answer, "candidates"), ["listed"]);
    assert_eq!(warnings(&answer), ["other-tools"]);
    assert_eq!(answer["warnings"][0]["detail"], "tool files that no .fctl list of their zip names were left out: 1");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_answer_names_the_preset_of_a_library() {
    let app = TestApp::start().await;
    let tool = |name: &str, presets: Value| json!({"type": "ball end mill", "unit": "millimeters", "description": name, "geometry": {"DC": 6, "NOF": 2}, "start-values": {"presets": presets}});
    let presets = json!([{"name": "Steel roughing", "n": 6000, "f_z": 0.08}, {"name": "Steel finishing", "n": 9000, "f_z": 0.05}]);
    let library = json!({"data": [tool("with", presets), tool("without", json!([]))]}).to_string();
    let answer = upload(&app, &[library.as_bytes()], Value::Null).await.ok();
    let preset = |name: &str| {
        let candidates = answer["candidates"].as_array().unwrap();
        candidates.iter().find(|candidate| candidate["name"] == name).unwrap()["preset"].clone()
    };
    assert_eq!((preset("with"), preset("without")), (json!("Steel finishing"), Value::Null));
    assert_eq!(answer["recommended"]["preset"], preset(answer["recommended"]["name"].as_str().unwrap()));
}
