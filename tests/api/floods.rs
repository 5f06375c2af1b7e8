//! Requests with very many faulty contacts, members and parts: answers list a bounded number of faults and count the
//! rest.

use serde_json::{Value, json};

use crate::app::TestApp;

const PATH: &str = "/v1/scallop-height/batch";

fn batch(contacts: &[Value]) -> Value {
    json!({"cutter": {"type": "ball_end", "diameter_mm": 10}, "step_over_mm": 0.5, "contacts": contacts})
}

fn valid() -> Value {
    json!({"slope_deg": 40, "feed_angle_deg": 30})
}

#[tokio::test]
async fn the_first_thousand_failures_are_listed_and_all_are_counted() {
    let app = TestApp::start().await;
    let mut contacts = vec![json!(0); 2500];
    contacts.push(valid());
    let answer = app.answer(PATH, &batch(&contacts)).await;
    let failures = answer["failures"].as_array().unwrap();
    assert_eq!(failures.len(), 1000);
    assert!(failures.iter().enumerate().all(|(index, failure)| failure["index"] == index));
    assert_eq!((&answer["summary"]["count"], &answer["summary"]["failures"]), (&json!(2501), &json!(2500)));
    let column = answer["scallop_height_mm"].as_array().unwrap();
    assert_eq!(column.len(), 2501);
    assert!(column[2499].is_null() && column[2500].is_number());
}

#[tokio::test]
async fn of_many_unknown_members_of_a_contact_a_few_are_listed() {
    let app = TestApp::start().await;
    let flood: serde_json::Map<_, _> = (0..256).map(|index| (format!("member{index}"), json!(0))).collect();
    let body = batch(&[flood.into(), valid()]);
    let answer = app.answer(PATH, &body).await;
    let detail = answer["failures"][0]["detail"].as_str().unwrap();
    assert!(detail.contains("further faults are not listed"), "{detail}");
    assert!(answer.to_string().len() < body.to_string().len(), "the answer is longer than the request");
}

#[tokio::test]
async fn a_long_name_is_not_repeated_whole() {
    let app = TestApp::start().await;
    let problem = app.refusal("/v1/scallop-height", &json!({"x".repeat(20_000): 0})).await;
    assert!(problem.to_string().len() < 5000, "{}", problem.to_string().len());
}

#[tokio::test]
async fn a_form_of_very_many_parts_is_refused() {
    let app = TestApp::start().await;
    let body = format!("{}--edge--\r\n", "--edge\r\n\r\n\r\n".repeat(1000));
    let request = app.client.post(app.url("/v1/cutter-recommendation/upload"));
    let answer = request.header("content-type", "multipart/form-data; boundary=edge").body(body).send().await.unwrap();
    assert_eq!(answer.status(), 400);
    let problem: Value = answer.json().await.unwrap();
    assert_eq!(problem["type"], "malformed-form");
}
