//! The OpenAPI document in version 3.0.3, converted from version 3.1. Generators that read 3.0 differ in the features
//! that they accept, so this document uses only those that all accept:
//!
//! - no forms, because several generators refuse a document with `multipart/form-data`;
//! - one schema for the problems of all statuses, with the figures of every type of problem;
//! - codes that occur only in answers are strings, not enumerations: a client that checks enumerations would fail on a
//!   code that a later version adds. `x-extensible-enum` lists the codes of this version.

use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

const PROBLEM: &str = "Problem";
const PROBLEMS_BY_TYPE: &str = "UnprocessableProblem";
const PROBLEM_JSON: &str = "application/problem+json";
const REFERENCE: &str = "#/components/schemas/";
const NOTE: &str = "This document is OpenAPI 3.0.3 for generators that do not read 3.1. It leaves out the upload of files, which takes a form; /openapi.json \
                    has it. Sets of codes in answers are open and may gain codes.";

/// Converts `document` from version 3.1 to 3.0.3.
pub(super) fn converted(mut document: Value) -> Value {
    document["openapi"] = "3.0.3".into();
    let about = document["info"]["description"].as_str().unwrap_or_default();
    document["info"]["description"] = format!("{about}\n\n{NOTE}").into();
    // Version 3.0 has no licence identifier.
    document["info"]["license"].as_object_mut().and_then(|license| license.shift_remove("identifier"));
    open_codes(&mut document);
    leave_out_forms(&mut document);
    unite_problems(&mut document);
    convert_schemas(&mut document);
    document
}

/// Calls `change` for every object of the document, innermost first, except for those in examples. A schema's own
/// members have other types than the descriptions of the members of the same name that it lists.
fn each_object(value: &mut Value, change: &mut impl FnMut(&mut Map<String, Value>)) {
    match value {
        Value::Object(members) => {
            let inside = members.iter_mut().filter(|(name, _)| !matches!(name.as_str(), "example" | "examples"));
            inside.for_each(|(_, member)| each_object(member, change));
            change(members);
        }
        Value::Array(items) => items.iter_mut().for_each(|item| each_object(item, change)),
        _ => {}
    }
}

fn members_mut(object: &mut Value) -> impl Iterator<Item = &mut Value> {
    object.as_object_mut().into_iter().flat_map(|members| members.values_mut())
}

fn operations_mut(document: &mut Value) -> impl Iterator<Item = &mut Value> {
    members_mut(&mut document["paths"]).flat_map(members_mut)
}

/// Removes the operations that take forms, and the schemas of the forms.
fn leave_out_forms(document: &mut Value) {
    let mut forms = Vec::new();
    for path in members_mut(&mut document["paths"]).filter_map(Value::as_object_mut) {
        path.retain(|_, operation| {
            let form = &operation["requestBody"]["content"]["multipart/form-data"];
            forms.extend(form["schema"]["$ref"].as_str().map(str::to_owned));
            form.is_null()
        });
    }
    if let Some(paths) = document["paths"].as_object_mut() {
        paths.retain(|_, path| path.as_object().is_some_and(|operations| !operations.is_empty()));
    }
    remove_schemas(document, &forms);
}

/// Adds the figures of every type of problem to the schema of problems, and refers to it from every response with a
/// problem. The responses name `application/json` beside the media type that is sent, because some generators read only
/// that.
fn unite_problems(document: &mut Value) {
    let schemas = &document["components"]["schemas"];
    let variants = schemas[PROBLEMS_BY_TYPE]["oneOf"].as_array().into_iter().flatten();
    let mut replaced: Vec<String> = variants.filter_map(|variant| variant["$ref"].as_str()).map(str::to_owned).collect();
    let mut problem = schemas[PROBLEM].clone();
    for variant in &replaced {
        for (name, figure) in schemas[name_in(variant)]["properties"].as_object().into_iter().flatten() {
            if problem["properties"].get(name).is_none() {
                problem["properties"][name] = figure.clone();
            }
        }
    }
    document["components"]["schemas"][PROBLEM] = problem;
    replaced.push(format!("{REFERENCE}{PROBLEMS_BY_TYPE}"));
    remove_schemas(document, &replaced);
    for response in operations_mut(document).flat_map(|operation| members_mut(&mut operation["responses"])) {
        if response["content"].get(PROBLEM_JSON).is_some() {
            let schema = json!({"$ref": format!("{REFERENCE}{PROBLEM}")});
            response["content"][PROBLEM_JSON]["schema"] = schema.clone();
            response["content"]["application/json"] = json!({"schema": schema});
        }
    }
}

fn name_in(reference: &str) -> &str {
    reference.strip_prefix(REFERENCE).unwrap_or(reference)
}

fn remove_schemas(document: &mut Value, references: &[String]) {
    if let Some(schemas) = document["components"]["schemas"].as_object_mut() {
        schemas.retain(|name, _| references.iter().all(|reference| name_in(reference) != name));
    }
}

/// Turns the enumerations that occur only in answers into strings with their codes in `x-extensible-enum`.
fn open_codes(document: &mut Value) {
    let mut sent = BTreeSet::new();
    for operation in members(&document["paths"]).flat_map(members) {
        collect(document, &operation["requestBody"], &mut sent);
        collect(document, &operation["parameters"], &mut sent);
    }
    let Some(schemas) = document["components"]["schemas"].as_object_mut() else { return };
    let mut open = |members: &mut Map<String, Value>| {
        if let Some(codes) = members.shift_remove("enum") {
            members.insert("x-extensible-enum".to_owned(), codes);
        }
    };
    for (_, schema) in schemas.iter_mut().filter(|(name, _)| !sent.contains(name.as_str())) {
        each_object(schema, &mut open);
    }
}

fn members(object: &Value) -> impl Iterator<Item = &Value> {
    object.as_object().into_iter().flat_map(|members| members.values())
}

/// Adds the names of the schemas to which `value` refers, directly or through others.
fn collect(document: &Value, value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(members) => {
            if let Some(name) = members.get("$ref").and_then(Value::as_str).map(name_in)
                && names.insert(name.to_owned())
            {
                collect(document, &document["components"]["schemas"][name], names);
            }
            members.values().for_each(|member| collect(document, member, names));
        }
        Value::Array(items) => items.iter().for_each(|item| collect(document, item, names)),
        _ => {}
    }
}

/// Converts all schemas of `document`.
fn convert_schemas(document: &mut Value) {
    each_object(document, &mut bare_references);
    each_object(document, &mut wrap_reference);
    each_object(document, &mut convert);
}

fn convert(members: &mut Map<String, Value>) {
    replace_null(members);
    if let Some(value) = members.shift_remove("const") {
        members.insert("enum".to_owned(), json!([value]));
    }
    // The examples of a schema are an array, those of a response an object.
    if let Some(Value::Array(examples)) = members.get_mut("examples") {
        let first = examples.drain(..).next();
        members.shift_remove("examples");
        members.extend(first.map(|example| ("example".to_owned(), example)));
    }
    for (bound, exclusive) in [("minimum", "exclusiveMinimum"), ("maximum", "exclusiveMaximum")] {
        if let Some(limit) = members.get_mut(exclusive) {
            let limit = std::mem::replace(limit, true.into());
            members.insert(bound.to_owned(), limit);
        }
    }
    // The names of members are always strings.
    members.shift_remove("propertyNames");
}

/// Drops the descriptions of the references in a union: generators would create another type for a wrapped reference.
fn bare_references(members: &mut Map<String, Value>) {
    for union in ["oneOf", "allOf", "anyOf"] {
        for form in members.get_mut(union).and_then(Value::as_array_mut).into_iter().flatten() {
            if let Some(reference) = form.get("$ref").cloned() {
                *form = json!({"$ref": reference});
            }
        }
    }
}

/// Version 3.0 ignores members beside a reference, so the reference is wrapped.
fn wrap_reference(members: &mut Map<String, Value>) {
    if members.len() > 1
        && let Some(reference) = members.shift_remove("$ref")
    {
        members.insert("allOf".to_owned(), json!([{"$ref": reference}]));
    }
}

/// Replaces a type "null" beside others by `nullable`.
fn replace_null(members: &mut Map<String, Value>) {
    if let Some(Value::Array(types)) = members.get_mut("type") {
        types.retain(|kind| kind != "null");
        if let [kind] = types.as_slice() {
            members["type"] = kind.clone();
            members.insert("nullable".to_owned(), true.into());
        }
    }
    let Some(Value::Array(forms)) = members.get_mut("oneOf") else { return };
    let count = forms.len();
    forms.retain(|form| form["type"] != "null");
    if forms.len() == count {
        return;
    }
    if let [form] = forms.as_mut_slice() {
        let mut form = std::mem::take(form);
        if form.get("$ref").is_some() {
            form = json!({"allOf": [form]});
        }
        members.shift_remove("oneOf");
        // The description of the member takes precedence over that of the referenced form.
        for (name, member) in form.as_object_mut().into_iter().flat_map(std::mem::take) {
            members.entry(name).or_insert(member);
        }
    }
    members.insert("nullable".to_owned(), true.into());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The document of the service in both versions.
    fn documents() -> (Value, Value) {
        let document = crate::http::document::of(crate::http::routes());
        (document.clone(), converted(document))
    }

    fn assert_becomes(mut schema: Value, expected: &Value) {
        convert_schemas(&mut schema);
        assert_eq!(&schema, expected);
    }

    #[test]
    fn null_becomes_nullable() {
        assert_becomes(json!({"type": ["number", "null"], "minimum": 0}), &json!({"type": "number", "minimum": 0, "nullable": true}));
        let column = json!({"type": "array", "items": {"oneOf": [{"type": "string", "description": ""}, {"type": "null"}]}});
        assert_becomes(column, &json!({"type": "array", "items": {"type": "string", "description": "", "nullable": true}}));
        let reference = json!({"oneOf": [{"$ref": "#/a"}, {"type": "null"}], "description": "b"});
        assert_becomes(reference, &json!({"allOf": [{"$ref": "#/a"}], "description": "b", "nullable": true}));
        let forms = json!({"oneOf": [{"$ref": "#/a"}, {"$ref": "#/b"}, {"type": "null"}]});
        assert_becomes(forms, &json!({"oneOf": [{"$ref": "#/a"}, {"$ref": "#/b"}], "nullable": true}));
    }

    #[test]
    fn keywords_of_3_1_become_those_of_3_0() {
        assert_becomes(json!({"exclusiveMinimum": 0, "maximum": 9}), &json!({"minimum": 0, "exclusiveMinimum": true, "maximum": 9}));
        assert_becomes(json!({"minimum": 0, "exclusiveMaximum": 180}), &json!({"minimum": 0, "maximum": 180, "exclusiveMaximum": true}));
        assert_becomes(json!({"const": "a", "examples": ["a", "b"]}), &json!({"enum": ["a"], "example": "a"}));
        let described = json!({"properties": {"a": {"$ref": "#/a", "description": "b"}, "examples": {"$ref": "#/c"}}});
        assert_becomes(
            described,
            &json!({"properties": {"a": {"allOf": [{"$ref": "#/a"}], "description": "b"}, "examples": {"$ref": "#/c"}}}),
        );
        let named = json!({"additionalProperties": {"const": 1}, "propertyNames": {"type": "string"}});
        assert_becomes(named, &json!({"additionalProperties": {"enum": [1]}}));
    }

    #[test]
    fn problems_of_all_statuses_have_the_figures_of_every_type() {
        let (document, converted) = documents();
        let problem = &converted["components"]["schemas"][PROBLEM];
        assert_eq!(problem["required"], document["components"]["schemas"][PROBLEM]["required"]);
        for variant in document["components"]["schemas"][PROBLEMS_BY_TYPE]["oneOf"].as_array().unwrap() {
            let name = name_in(variant["$ref"].as_str().unwrap());
            for (figure, _) in document["components"]["schemas"][name]["properties"].as_object().unwrap() {
                assert!(problem["properties"][figure].is_object(), "{figure}");
            }
            assert!(converted["components"]["schemas"][name].is_null());
        }
    }

    #[test]
    fn codes_of_answers_are_open_and_those_of_requests_closed() {
        let (document, converted) = documents();
        let (before, after) = (&document["components"]["schemas"], &converted["components"]["schemas"]);
        for open in ["WarningCode", "FaultCode", "ProblemType", "BindingLimit"] {
            assert_eq!(after[open]["x-extensible-enum"], before[open]["enum"], "{open}");
            assert_eq!((&after[open]["type"], after[open].get("enum")), (&json!("string"), None));
        }
        for closed in ["Model", "PresetName"] {
            assert_eq!(after[closed]["enum"], before[closed]["enum"], "{closed}");
        }
        // The schema of an upload's parameters stays: clients write the form by hand.
        let include = |schemas: &Value| schemas["RecommendationParameters"]["properties"]["include"]["items"]["enum"].clone();
        assert!(include(before).is_array());
        assert_eq!(include(after), include(before));
    }

    #[test]
    fn every_operation_without_a_form_is_in_the_document() {
        let (document, converted) = documents();
        let paths = |document: &Value| document["paths"].as_object().unwrap().keys().cloned().collect::<Vec<_>>();
        let mut expected = paths(&document);
        expected.retain(|path| path != "/v1/cutter-recommendation/upload");
        assert_eq!(paths(&converted), expected);
    }

    #[test]
    fn every_reference_has_its_schema() {
        let (_, converted) = documents();
        let mut names = BTreeSet::new();
        collect(&converted, &converted["paths"], &mut names);
        assert!(names.contains(PROBLEM));
        collect(&converted, &converted["components"], &mut names);
        for name in names {
            assert!(converted["components"]["schemas"][&name].is_object(), "{name}");
        }
    }
}
