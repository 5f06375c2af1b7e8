//! Generates the client from the OpenAPI document that the variable OPENAPI_DOCUMENT names.

use std::path::Path;
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-env-changed=OPENAPI_DOCUMENT");
    let document = env::var("OPENAPI_DOCUMENT").expect("OPENAPI_DOCUMENT names the document");
    println!("cargo::rerun-if-changed={document}");
    let document = fs::read_to_string(document).expect("the document can be read");
    let document: openapiv3::OpenAPI = serde_json::from_str(&document).expect("the document is OpenAPI 3.0");
    let tokens = progenitor_impl::Generator::default().generate_tokens(&document).expect("the generator accepts the document");
    let file = syn::parse2(tokens).expect("the generator writes Rust");
    let out = env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    fs::write(Path::new(&out).join("client.rs"), prettyplease::unparse(&file)).expect("the client can be written");
}
