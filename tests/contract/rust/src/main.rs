//! Calls a server with the client that progenitor generates from the OpenAPI 3.0 document: typed requests, typed
//! answers, a typed problem. Usage: scallopd-contract-client BASE_URL OPENAPI_JSON

#![deny(warnings)]

#[allow(dead_code)]
mod client {
    include!(concat!(env!("OUT_DIR"), "/client.rs"));
}

use client::{Client, Error, types};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::error::Error as StdError;
use std::fs;
use std::num::NonZeroU64;

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn StdError>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [base_url, document] = arguments.as_slice() else { return Err("usage: BASE_URL OPENAPI_JSON".into()) };
    let examples = Examples(serde_json::from_str(&fs::read_to_string(document)?)?);
    let client = Client::new(base_url);
    height(&client).await?;
    problem(&client).await?;
    upload(base_url, &examples).await?;
    unknown_code()?;
    every_example(&client, &examples).await?;
    println!("progenitor: typed calls, a typed problem, an upload and all examples");
    Ok(())
}

fn toroidal() -> types::Cutter {
    types::Cutter::ToroidalCutter(types::ToroidalCutter {
        type_: types::ToroidalCutterType::Toroidal,
        diameter_mm: 10.0,
        corner_radius_mm: 2.0,
        teeth: NonZeroU64::new(4),
    })
}

fn contact() -> types::Contact {
    types::Contact::AngleContact(types::AngleContact { slope_deg: 40.0, feed_angle_deg: 30.0 })
}

async fn height(client: &Client) -> Result<(), Box<dyn StdError>> {
    let request = types::ScallopHeightRequest {
        cutter: toroidal(),
        contact: contact(),
        step_over_mm: Some(0.687),
        feed_per_tooth_mm: Some(0.3),
        model: Some(types::Model::Envelope),
        runout: None,
        step_over_xy_mm: None,
        surface_curvature: None,
        surface_radius_mm: None,
    };
    let answer = client.scallop_height(&request).await?.into_inner();
    assert!((0.014..0.016).contains(&answer.scallop_height_mm), "{answer:?}");
    let vector =
        types::Contact::VectorContact(types::VectorContact { normal: [-0.64, 0.0, 0.77], feed: [1.0, 0.0, 0.84], tool_axis: None });
    let request = types::ScallopHeightRequest { contact: vector, ..request };
    client.scallop_height(&request).await?;
    let tapered = types::Cutter::TaperedBallCutter(types::TaperedBallCutter {
        type_: types::TaperedBallCutterType::TaperedBall,
        diameter_mm: 2.0,
        taper_deg: 5.0,
        shank_diameter_mm: 6.0,
        teeth: None,
    });
    let request = types::ScallopHeightRequest { cutter: tapered, step_over_mm: Some(0.1), ..request };
    client.scallop_height(&request).await?;
    Ok(())
}

async fn problem(client: &Client) -> Result<(), Box<dyn StdError>> {
    let request = types::MaxFeedRequest {
        cutter: toroidal(),
        contact: contact(),
        scallop_tolerance_mm: Some(0.013),
        roughness: None,
        step_over_mm: Some(0.987),
        max_feed_per_tooth_mm: None,
        max_feed_rate_mm_min: None,
        model: None,
        runout: None,
        spindle_speed_rpm: Some(10000.0),
        step_over_xy_mm: None,
        surface_curvature: None,
        surface_radius_mm: None,
    };
    let Err(Error::ErrorResponse(refusal)) = client.max_feed(&request).await else { return Err("the request is not refused".into()) };
    assert_eq!(refusal.status(), 422);
    let problem = refusal.into_inner();
    assert_eq!(problem.type_.as_str(), "tolerance-exceeded");
    assert!(problem.max_step_over_mm.is_some_and(|largest| (0.78..0.79).contains(&largest)), "{problem:?}");
    let fed = types::MaxFeedRequest { step_over_mm: Some(0.687), ..request };
    let feed = client.max_feed(&fed).await?.into_inner();
    assert!(feed.feed_rate_mm_min.is_some_and(|rate| (11898.0..11899.0).contains(&rate)), "{feed:?}");
    Ok(())
}

/// The generator does not support forms, so the form is built by hand from generated types.
async fn upload(base_url: &str, examples: &Examples) -> Result<(), Box<dyn StdError>> {
    let example = examples.request("cutter_recommendation_upload", "multipart/form-data");
    let parameters: types::RecommendationParameters = serde_json::from_value(example["parameters"].clone())?;
    let surface = example["surface"].as_str().ok_or("the example has no surface")?.to_owned();
    let form = reqwest::multipart::Form::new()
        .part("parameters", reqwest::multipart::Part::text(serde_json::to_string(&parameters)?).mime_str("application/json")?)
        .part("surface", reqwest::multipart::Part::text(surface).file_name("surface.csv"));
    let url = format!("{base_url}/v1/cutter-recommendation/upload");
    let answer: types::RecommendationAnswer =
        reqwest::Client::new().post(url).multipart(form).send().await?.error_for_status()?.json().await?;
    assert_eq!(answer.recommended.name.as_deref(), Some("T10"));
    Ok(())
}

/// An unknown code must be accepted, because later versions may add codes.
fn unknown_code() -> Result<(), Box<dyn StdError>> {
    let warning: types::Warning = serde_json::from_value(json!({"code": "a-code-of-a-later-version", "detail": "news"}))?;
    assert_eq!(warning.code.as_str(), "a-code-of-a-later-version");
    Ok(())
}

async fn every_example(client: &Client, examples: &Examples) -> Result<(), Box<dyn StdError>> {
    macro_rules! check {
        (posted: $($posted:ident),*; fetched: $($fetched:ident),*) => {{
            $({
                let request = typed(examples.request(stringify!($posted), "application/json"))?;
                let answer = client.$posted(&request).await?.into_inner();
                alike(&examples.answer(stringify!($posted)), &serde_json::to_value(answer)?, stringify!($posted));
            })*
            $({
                let answer = client.$fetched().await?.into_inner();
                alike(&examples.answer(stringify!($fetched)), &serde_json::to_value(answer)?, stringify!($fetched));
            })*
        }};
    }
    include!(concat!(env!("OUT_DIR"), "/examples.rs"));
    Ok(())
}

/// The document with its examples.
struct Examples(Value);

impl Examples {
    fn operation(&self, id: &str) -> &Value {
        let operations = self.0["paths"].as_object().into_iter().flatten().filter_map(|(_, methods)| methods.as_object());
        let found = operations.flat_map(|methods| methods.values()).find(|operation| operation["operationId"] == id);
        found.unwrap_or_else(|| panic!("the document has no operation {id}"))
    }

    fn request(&self, id: &str, media_type: &str) -> Value {
        self.operation(id)["requestBody"]["content"][media_type]["example"].clone()
    }

    fn answer(&self, id: &str) -> Value {
        self.operation(id)["responses"]["200"]["content"]["application/json"]["example"].clone()
    }
}

/// The request as the generated type; it must keep every member.
fn typed<T: DeserializeOwned + Serialize>(request: Value) -> Result<T, Box<dyn StdError>> {
    let typed = serde_json::from_value(request.clone())?;
    alike(&request, &serde_json::to_value(&typed)?, "the request");
    Ok(typed)
}

/// Fails unless the values agree, numbers to a relative 1e-9. Empty lists may be absent: the generator does not
/// distinguish them.
fn alike(expected: &Value, found: &Value, place: &str) {
    match (expected, found) {
        (Value::Object(expected), Value::Object(found)) => {
            for name in found.keys() {
                assert!(expected.contains_key(name), "{place}/{name} is not in the example");
            }
            for (name, value) in expected {
                if *value != json!([]) || found.contains_key(name) {
                    alike(value, found.get(name).unwrap_or(&Value::Null), &format!("{place}/{name}"));
                }
            }
        }
        (Value::Array(expected), Value::Array(found)) => {
            assert_eq!(expected.len(), found.len(), "{place}");
            for (index, (expected, found)) in expected.iter().zip(found).enumerate() {
                alike(expected, found, &format!("{place}/{index}"));
            }
        }
        (Value::Number(expected), Value::Number(found)) => {
            let (expected, found) = (expected.as_f64().unwrap_or(f64::NAN), found.as_f64().unwrap_or(f64::NAN));
            assert!((expected - found).abs() <= 1e-9 * expected.abs() + 1e-12, "{place}: {expected} expected, found {found}");
        }
        _ => assert_eq!(expected, found, "{place}"),
    }
}
