//! Generates the client from the OpenAPI document that the variable OPENAPI_DOCUMENT names, and a call of each operation
//! that has an example.

use openapiv3::{OpenAPI, ReferenceOr};
use std::path::Path;
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-env-changed=OPENAPI_DOCUMENT");
    let document = env::var("OPENAPI_DOCUMENT").expect("OPENAPI_DOCUMENT names the document");
    println!("cargo::rerun-if-changed={document}");
    let document = fs::read_to_string(document).expect("the document can be read");
    let document: OpenAPI = serde_json::from_str(&document).expect("the document is OpenAPI 3.0");
    let tokens = progenitor_impl::Generator::default().generate_tokens(&document).expect("the generator accepts the document");
    let file = syn::parse2(tokens).expect("the generator writes Rust");
    let out = env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    fs::write(Path::new(&out).join("client.rs"), prettyplease::unparse(&file)).expect("the client can be written");
    fs::write(Path::new(&out).join("examples.rs"), calls_of_examples(&document)).expect("the calls can be written");
}

/// A call of the macro `check!` with the ids of the operations whose answer has an example: those with a JSON body, and
/// those without input.
fn calls_of_examples(document: &OpenAPI) -> String {
    let (mut posted, mut fetched) = (Vec::new(), Vec::new());
    for (_, _, operation) in document.operations() {
        let answer = operation.responses.responses.get(&openapiv3::StatusCode::Code(200)).and_then(ReferenceOr::as_item);
        let has_example = answer.and_then(|answer| answer.content.get("application/json")).is_some_and(|json| json.example.is_some());
        let id = operation.operation_id.clone().expect("an operation has an id");
        match (&operation.request_body, operation.parameters.is_empty()) {
            _ if !has_example => {}
            (Some(_), _) => posted.push(id),
            (None, true) => fetched.push(id),
            // The generated Python client calls the queries.
            (None, false) => {}
        }
    }
    assert!(!posted.is_empty() && !fetched.is_empty(), "the document has no examples");
    format!("check!(posted: {}; fetched: {})", posted.join(", "), fetched.join(", "))
}
