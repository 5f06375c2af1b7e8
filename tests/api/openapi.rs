//! The OpenAPI document as tests use it: its operations, requests from their examples, and validators of its schemas.

use std::collections::BTreeSet;

use crate::app::TestApp;
use jsonschema::Validator;
use reqwest::RequestBuilder;
use reqwest::multipart::{Form, Part};
use scallopd::http::openapi_json;
use serde_json::Value;

pub(crate) const JSON: &str = "application/json";
pub(crate) const FORM: &str = "multipart/form-data";
const PROBLEM: &str = "application/problem+json";

pub(crate) fn document() -> Value {
    serde_json::from_str(&openapi_json()).unwrap()
}

/// An operation of the document.
#[derive(Clone, Copy)]
pub(crate) struct Operation<'a> {
    pub(crate) path: &'a str,
    /// The method in lower case.
    pub(crate) method: &'a str,
    pub(crate) described: &'a Value,
}

/// The operations of the API, without probes, metrics and pages.
pub(crate) fn operations(document: &Value) -> impl Iterator<Item = Operation<'_>> {
    let paths = document["paths"].as_object().unwrap().iter().filter(|(path, _)| path.starts_with("/v1/"));
    paths.flat_map(|(path, item)| {
        item.as_object().unwrap().iter().map(|(method, described)| Operation { path: path.as_str(), method: method.as_str(), described })
    })
}

/// The operations that take a JSON body.
pub(crate) fn json_operations(document: &Value) -> impl Iterator<Item = Operation<'_>> {
    operations(document).filter(|operation| operation.media_type() == Some(JSON))
}

/// The operation with a method, in lower case, at a path.
pub(crate) fn operation<'a>(document: &'a Value, method: &'a str, path: &'a str) -> Operation<'a> {
    Operation { path, method, described: &document["paths"][path][method] }
}

impl<'a> Operation<'a> {
    pub(crate) fn id(self) -> &'a str {
        self.described["operationId"].as_str().unwrap()
    }

    /// The media type of its requests, if they have a body.
    pub(crate) fn media_type(self) -> Option<&'a str> {
        self.described["requestBody"]["content"].as_object().and_then(|content| content.keys().next()).map(String::as_str)
    }

    /// The schema and the example of its requests' bodies.
    pub(crate) fn body(self) -> &'a Value {
        self.media_type().map_or(&Value::Null, |media_type| &self.described["requestBody"]["content"][media_type])
    }

    /// The schema and the example of its answers.
    pub(crate) fn answer(self) -> &'a Value {
        &self.described["responses"]["200"]["content"][JSON]
    }

    /// The schema and the examples of its problems with a status.
    pub(crate) fn problem(self, status: u16) -> &'a Value {
        &self.described["responses"][status.to_string()]["content"][PROBLEM]
    }

    pub(crate) fn statuses(self) -> BTreeSet<u16> {
        self.described["responses"].as_object().unwrap().keys().map(|status| status.parse().unwrap()).collect()
    }

    /// The example of its requests: a query, or a body.
    pub(crate) fn example(self) -> Value {
        if self.method != "get" {
            return self.body()["example"].clone();
        }
        let parameters = self.described["parameters"].as_array().into_iter().flatten();
        let with_example = parameters.filter(|parameter| !parameter["example"].is_null());
        let written = with_example.map(|parameter| {
            let value = match &parameter["example"] {
                Value::Array(items) => items.iter().map(Value::to_string).collect::<Vec<_>>().join(","),
                Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            format!("{}={value}", parameter["name"].as_str().unwrap())
        });
        written.collect::<Vec<_>>().join("&").into()
    }

    /// A request: a query, or a body.
    pub(crate) fn request(self, app: &TestApp, request: &Value) -> RequestBuilder {
        if let Some(query) = request.as_str() {
            return app.client.get(app.url(&format!("{}?{query}", self.path)));
        }
        let post = app.client.post(app.url(self.path));
        if self.media_type() == Some(JSON) {
            return post.json(request);
        }
        let parts = request.as_object().unwrap().iter();
        post.multipart(parts.fold(Form::new(), |form, (name, value)| match value.as_str() {
            Some(file) => form.part(name.clone(), Part::text(file.to_owned()).file_name("surface.csv")),
            None => form.text(name.clone(), value.to_string()),
        }))
    }
}

/// A validator of `schema`, which refers to the document's components.
pub(crate) fn validator(document: &Value, schema: &Value) -> Validator {
    let mut schema = schema.clone();
    schema["components"] = document["components"].clone();
    jsonschema::draft202012::new(&schema).unwrap()
}

#[track_caller]
pub(crate) fn assert_valid(validator: &Validator, instance: &Value) {
    let errors: Vec<_> = validator.iter_errors(instance).map(|error| format!("{}: {error}", error.instance_path())).collect();
    assert!(errors.is_empty(), "{errors:#?} in {instance}");
}
