//! `POST /v1/cutter-recommendation/upload`: the form around the file, and hostile or faulty files.

use crate::app::{TestApp, figure, gzip};
use crate::planning::{job, with};
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

const CSV: &str = "x,y,z\n0,0,0\n60,0,0\n0,20,11\n60,20,11\n30,10,5.7\n";
const PATH: &str = "/v1/cutter-recommendation/upload";

/// The bytes of a form with the boundary `edge`.
fn written(parts: &[(&str, &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    for (name, data) in parts {
        body.extend(format!("--edge\r\nContent-Disposition: form-data; name=\"{name}\"\r\n\r\n").bytes());
        body.extend(data.iter().chain(b"\r\n"));
    }
    body.extend(b"--edge--\r\n");
    body
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_parts_may_be_in_either_order() {
    let app = TestApp::start().await;
    let parameters = with(job(), json!({"unit": "cm"})).to_string().into_bytes();
    let (surface, parameters) = (("surface", CSV.as_bytes().to_vec()), ("parameters", parameters));
    let one = app.upload_parts([surface.clone(), parameters.clone()]).await.ok();
    let other = app.upload_parts([parameters, surface]).await.ok();
    assert_eq!(one, other);
    assert_eq!((figure(&one, "/surface/points"), figure(&one, "/surface/bounds_mm/max/0")), (5.0, 600.0));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_file_is_answered_as_its_points_in_json() {
    let app = TestApp::start().await;
    let mut answer = app.upload(CSV, &job()).await.ok();
    let points = json!([[0, 0, 0], [60, 0, 0], [0, 20, 11], [60, 20, 11], [30, 10, 5.7]]);
    let expected = app.recommend(&with(job(), json!({"surface": {"points": points}}))).await.ok();
    answer["surface"]["source"] = json!("points");
    assert_eq!(answer, expected);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn compressed_forms_are_decompressed_and_counted() {
    let app = TestApp::start().await;
    // Many times the size of one block of the reader.
    let line = |index: i32| format!("{},{},{}\n", index % 601, index / 601, 0.25 * f64::from(index / 601));
    let points = (0..300_000).map(line).collect::<Vec<_>>().concat();
    let body = written(&[("surface", points.as_bytes()), ("parameters", job().to_string().as_bytes())]);
    let plain = app.upload_raw(body.clone(), false).await.ok();
    let compressed = app.upload_raw(gzip(&body), true).await.ok();
    assert_eq!(plain, compressed);
    assert!((figure(&plain, "/surface/points") - 300_000.0).abs() < 0.5);
    let metrics = app.metrics().await;
    assert!(metrics.contains(&format!("scallopd_upload_bytes_total {}\n", 2 * points.len())), "{metrics}");
    assert!(metrics.contains("scallopd_upload_facets_total{format=\"text\"} 600000\n"), "{metrics}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn missing_unknown_and_repeated_parts_are_listed_together() {
    let app = TestApp::start().await;
    let parameters = job().to_string().into_bytes();
    let csv = CSV.as_bytes().to_vec();
    assert_eq!(app.upload_parts([("parameters", parameters.clone())]).await.faults(), (422, vec![("/surface", "missing-field")]));
    assert_eq!(app.upload_parts([("surface", csv.clone())]).await.faults(), (422, vec![("/parameters", "missing-field")]));
    let answer = app.upload_raw(written(&[]), false).await;
    assert_eq!(answer.faults(), (422, vec![("/surface", "missing-field"), ("/parameters", "missing-field")]));
    let answer = app
        .upload_parts([("surface", csv.clone()), ("parameters", parameters.clone()), ("note", b"x".to_vec()), ("surface", csv.clone())])
        .await;
    assert_eq!(answer.faults(), (422, vec![("/note", "unknown-field"), ("/surface", "repeated-field")]));
    let parameters = with(job(), json!({"surface": {"points": []}, "unit": 1})).to_string().into_bytes();
    let answer = app.upload_parts([("surface", b"0,0,zero\n1,2,x\n".to_vec()), ("parameters", parameters)]).await;
    let (status, faults) = answer.faults();
    assert_eq!(status, 400, "{}", answer.body);
    for fault in [("/unit", "wrong-type"), ("/surface", "malformed-file"), ("/surface", "unknown-field")] {
        assert!(faults.contains(&fault), "{fault:?} is not in {faults:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn malformed_forms_are_refused() {
    let app = TestApp::start().await;
    for (media_type, status) in [
        ("multipart/form-data", 400),
        ("multipart/form-data; boundary=", 400),
        ("multipart/mixed; boundary=edge", 415),
        ("application/json", 415),
        ("text/csv", 415),
    ] {
        assert_eq!(app.post_as(PATH, media_type, CSV).await.status, status, "{media_type}");
    }
    let whole = written(&[("surface", CSV.as_bytes()), ("parameters", job().to_string().as_bytes())]);
    for path in ["/v1/cutter-recommendation", "/v1/path-check"] {
        let to_json = app.post_as(path, "multipart/form-data; boundary=edge", whole.clone()).await;
        assert_eq!(to_json.status, 415);
        assert!(to_json.body["detail"].as_str().unwrap().contains("/upload"), "{}", to_json.body);
    }
    for body in [
        &b""[..],
        b"x",
        b"--edge",
        b"--edge--",
        b"--edge\r\nno colon\r\n\r\n\r\n--edge--\r\n",
        &whole[..whole.len() / 2],
        &whole[..whole.len() - 4],
    ] {
        let answer = app.upload_raw(body.to_vec(), false).await;
        let expected = if body == b"--edge--" { 422 } else { 400 };
        assert_eq!(answer.status, expected, "{}", answer.body);
    }
    let endless_head = [&b"--edge\r\nX: "[..], &vec![b'x'; 100_000]].concat();
    assert_eq!(app.upload_raw(endless_head, false).await.status, 400);
    assert_eq!(app.upload_raw(b"no gzip".to_vec(), true).await.status, 400);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn faulty_parameters_are_refused_as_in_json() {
    let app = TestApp::start().await;
    let answer = app.upload(CSV, &with(job(), json!({"machine": {"preset": "lathe"}, "facing": "left"}))).await;
    assert_eq!(answer.faults(), (422, vec![("/machine/preset", "unknown-value"), ("/facing", "unknown-value")]));
    assert_eq!(app.upload(CSV, &Value::Null).await.faults(), (422, vec![("", "wrong-type")]));
    assert_eq!(app.upload_parts([("surface", CSV.into()), ("parameters", b"{".to_vec())]).await.status, 400);
    assert_eq!(app.upload_parts([("surface", CSV.into()), ("parameters", vec![b' '; 300_000])]).await.status, 413);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn hostile_files_are_refused_with_their_line_or_byte() {
    let app = TestApp::start().await;
    let mut promising = vec![0; 84 + 50];
    promising[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let ply_with_large_count = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    // Long enough to be read in several blocks.
    let late = format!("{}1,2\n3,4,5\n", "0.5,0,0\n".repeat(100_000)).into_bytes();
    for (file, status, code, place) in [
        (late, 400, "malformed-file", "line 100001"),
        (Vec::new(), 422, "empty-file", ""),
        (b"x,y,z\n".to_vec(), 422, "empty-file", "line"),
        (b"0,0,0\n1,2\n3,4,5\n".to_vec(), 400, "malformed-file", "line 2"),
        (b"0,0,0\n1,nan,1\n".to_vec(), 422, "out-of-range", "line 2"),
        (b"0 0 0\n1 1e13 1\n".to_vec(), 422, "out-of-range", "line 2"),
        (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n".to_vec(), 422, "out-of-range", "line 4"),
        (b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 up\n".to_vec(), 400, "malformed-file", "line 4"),
        (b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n".to_vec(), 400, "truncated-file", "line 5"),
        (promising, 400, "truncated-file", "byte"),
        (ply_with_large_count.into(), 400, "truncated-file", "byte"),
        (b"%PDF-1.7\n\x00\x01\x02".to_vec(), 415, "unknown-format", ""),
    ] {
        let shown = String::from_utf8_lossy(&file[..file.len().min(40)]).into_owned();
        let answer = app.upload(file, &job()).await;
        assert_eq!(answer.faults(), (status, vec![("/surface", code)]), "{shown}: {}", answer.body);
        assert!(answer.detail().contains(place) && answer.detail().contains("expected"), "{shown}: {}", answer.detail());
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn files_that_span_no_surface_are_refused() {
    let app = TestApp::start().await;
    for (file, code) in [
        ("1,2,3\n", "too-few-points"),
        ("1,2,3\n1,2,3\n1,2,3\n", "all-points-equal"),
        ("0,0,0\n1,2,0\n2,4,0\n3,6,0\n", "collinear"),
        ("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n", "only-degenerate-facets"),
    ] {
        assert_eq!(app.upload(file, &job()).await.faults(), (422, vec![("/surface", code)]), "{file}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_gzip_bomb_ends_at_the_limit() {
    let app = TestApp::start_with(|settings| settings.max_upload = 8 << 20).await;
    // 64 MiB of one line, in 64 kB.
    let bomb = gzip(&written(&[("surface", &vec![b'1'; 64 << 20])]));
    let answer = app.upload_raw(bomb, true).await;
    // The line is too long for the reader as well; the fault of the body takes precedence.
    assert_eq!((answer.status, &answer.body["type"]), (413, &json!("too-large")));
    let blank = gzip(&written(&[("surface", &vec![b'\n'; 64 << 20])]));
    assert_eq!(app.upload_raw(blank, true).await.status, 413);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn media_type_and_name_of_the_part_decide_if_the_content_is_ambiguous() {
    let app = TestApp::start().await;
    // Without facets, only the sender's statement can distinguish ASCII STL from text.
    let form = |name: &'static str| {
        Form::new().part("surface", Part::bytes(Vec::new()).file_name(name)).part("parameters", Part::text(job().to_string()))
    };
    for name in ["part.stl", "part.csv", "part; \"quoted\".xyz", "teil-\u{e4}.obj"] {
        assert_eq!(app.upload_form(form(name)).await.faults(), (422, vec![("/surface", "empty-file")]), "{name}");
    }
}
