//! Contacts that are read in one pass, without a check of the body's syntax before, are answered byte for byte as by the
//! general reader. A name that is written with an escape leaves a body to the general reader.

use crate::api::requests::{MAX_FEED, SCALLOP_HEIGHT, STEP_OVER, batch_of, shortest, without};
use crate::app::TestApp;
use serde_json::Value;

/// Sends a batch with `contacts`, a JSON text, to both readers, and returns the status and the answer.
async fn by_both(app: &TestApp, single: &str, contacts: &str) -> (u16, String) {
    let rest = without(batch_of(shortest(single)), "/contacts").to_string();
    let mut answers = Vec::new();
    // Equally long, so that places in the text are the same.
    for name in ["\"contacts\"     ", "\"contact\\u0073\""] {
        let body = format!("{},{name}: {contacts} , \"model\":\"analytic\"}}", &rest[..rest.len() - 1]);
        let answer = app.send(&format!("{single}/batch"), body).await;
        let status = answer.status().as_u16();
        let mut text = answer.text().await.unwrap();
        if status != 200 {
            text = without(serde_json::from_str(&text).unwrap(), "/request_id").to_string();
        }
        answers.push((status, text));
    }
    let shown: String = contacts.chars().take(300).collect();
    assert_eq!(answers[0], answers[1], "{single} {shown}");
    answers.remove(0)
}

/// Contacts of many kinds: with and without faults, each valid JSON.
const CONTACTS: [&str; 22] = [
    r#"{"slope_deg":40,"feed_angle_deg":30}"#,
    r#" { "feed_angle_deg" : 3.5e1 , "slope_deg" : 12.123456789012345678 } "#,
    r#"{"slope_deg":40,"feed_angle_deg":30,"step_over_mm":0.3,"feed_per_tooth_mm":0.05}"#,
    r#"{"slope_deg":40,"feed_angle_deg":30,"step_over_xy_mm":0.3,"surface_radius_mm":50}"#,
    r#"{"normal":[-0.64,0,0.77],"feed":[1,0,0.84]}"#,
    r#"{"normal":[-0.64,0,0.77],"feed":[1,0,0.84],"tool_axis":[0.1,0,0.99]}"#,
    r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":{"along_per_mm":-0.004,"twist_per_mm":0.001}}"#,
    r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":{"principal_per_mm":[0.012,-0.005],"angle_deg":30}}"#,
    r#"{"slope_deg":0,"feed_angle_deg":30}"#,
    r#"{"slope_deg":91,"feed_angle_deg":30}"#,
    r#"{"slope_deg":40}"#,
    r#"{"slope_deg":"40","feed_angle_deg":null}"#,
    r#"{"slope_deg":40,"feed_angle_deg":1e999}"#,
    r#"{"slope_deg":40,"slope_deg":41,"feed_angle_deg":1}"#,
    r#"{"slope\u005fdeg":40,"feed_angle_deg":30}"#,
    r#"{"slope_deg":40,"feed_angle_deg":30,"},{":[{}, "}"]}"#,
    r#"{"slope_deg":-1,"feed_angle_deg":true,"a":1,"b":1,"c":1,"d":1,"e":1,"f":1,"g":1,"h":1,"i":1}"#,
    "{}",
    "3",
    "null",
    r#""},{""#,
    "[[1],[2]]",
];

#[tokio::test]
async fn rows_are_answered_as_by_the_general_reader() {
    let app = TestApp::start().await;
    for single in [SCALLOP_HEIGHT, MAX_FEED, STEP_OVER] {
        for contact in CONTACTS {
            by_both(&app, single, &format!("[{contact}]")).await;
        }
        // Several runs, and faults in each of them.
        let many: Vec<&str> = CONTACTS.iter().cycle().take(6000).copied().collect();
        let (status, answer) = by_both(&app, single, &format!("[{}]", many.join(","))).await;
        let answer: Value = serde_json::from_str(&answer).unwrap();
        assert_eq!((status, answer["summary"]["count"].as_u64()), (200, Some(6000)));
        assert!(answer["failures"][999]["pointer"].as_str().unwrap().starts_with("/contacts/"));
        let (status, _) = by_both(&app, single, &format!("[{}]", vec![CONTACTS[9]; 3000].join(" ,\n"))).await;
        assert_eq!(status, 422);
    }
}

#[tokio::test]
async fn columns_are_answered_as_by_the_general_reader() {
    let app = TestApp::start().await;
    for columns in [
        r#"{"slope_deg":[40,20.5,91,null],"feed_angle_deg":[30, -20 ,1E1,3]}"#,
        r#"{"slope_deg":[40,20.5],"feed_angle_deg":[30,-20],"surface_radius_mm":[null,50]}"#,
        r#"{"slope_deg":[40,20.5],"feed_angle_deg":[30]}"#,
        r#"{"slope_deg":[40,"20"],"feed_angle_deg":[30,1]}"#,
        r#"{"slope_deg":[40,1e999],"feed_angle_deg":[30,1]}"#,
        r#"{"slope_deg":[40,1],"feed_angle_deg":[30,1],"slope_deg":[1,2]}"#,
        r#"{"slope_deg":[40,1],"feed_angle_deg":[30,1],"unknown":[1,2]}"#,
        r#"{"slope_deg":[],"feed_angle_deg":[]}"#,
        r#"{"slope_deg":[40]}"#,
        r#"{"normal":[[0,0.1,1]],"feed":[[1,0,0]]}"#,
        r#"{"slope_deg":[40],"feed_angle_deg":[30],"surface_curvature":{"along_per_mm":[0.01]}}"#,
        "{}",
    ] {
        by_both(&app, STEP_OVER, columns).await;
    }
    let column = |number: &str| vec![number; 9000].join(",");
    let many = format!(r#"{{"slope_deg":[{},90.5],"feed_angle_deg":[{},1]}}"#, column("40.25"), column("-17.123456"));
    assert_eq!(by_both(&app, STEP_OVER, &many).await.0, 200);
}

#[tokio::test]
async fn texts_that_are_not_json_are_refused_as_by_the_general_reader() {
    let app = TestApp::start().await;
    let good = CONTACTS[0];
    let many = vec![good; 3000].join(",");
    for contacts in [
        format!("[{good},]"),
        format!("[{good} {good}]"),
        format!("[{good}"),
        format!("[,{good}]"),
        "[{\"slope_deg\":040,\"feed_angle_deg\":30}]".to_owned(),
        "[{\"slope_deg\":4.,\"feed_angle_deg\":30}]".to_owned(),
        "[{\"slope_deg\":40,\"feed_angle_deg\":30,}]".to_owned(),
        "[{\"slope_deg\":NaN,\"feed_angle_deg\":30},{\"slope_deg\":40,\"feed_angle_deg\":30}]".to_owned(),
        "{\"slope_deg\":[40,],\"feed_angle_deg\":[30,1]}".to_owned(),
        "{\"slope_deg\":[40,NaN],\"feed_angle_deg\":[30,1]}".to_owned(),
        "{\"slope_deg\":[40 1],\"feed_angle_deg\":[30,1]}".to_owned(),
        format!("[{many},{{\"slope_deg\":40,\"feed_angle_deg\":\"\x01\"}},{many}]"),
        format!("[{many}]]"),
        format!("[{many},,{many}]"),
    ] {
        let (status, answer) = by_both(&app, SCALLOP_HEIGHT, &contacts).await;
        assert!(status == 400 || contacts.contains("NaN"), "{answer}");
    }
}
