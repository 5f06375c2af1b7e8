//! Single calculations by query (`GET`). The parameters are the members of the JSON request, taken from its schema,
//! with the names of nested members joined. A query is converted to that JSON and read by the same readers; faults
//! point to the query's parameters.

use super::codes::RequestFault;
use super::json_body::malformed;
use super::problem::Problem;
use super::reading::{Components, Faulted, Faults, JsonPath, Object, mark, meant};
use serde_json::value::RawValue;
use serde_json::{Value, json};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Write;
use utoipa::openapi::path::{Parameter, ParameterBuilder, ParameterIn, ParameterStyle};
use utoipa::openapi::{RefOr, Required, Schema};

/// The most faults that an answer lists. The head of a request has room for some thousand parameters.
const MOST_FAULTS: usize = 100;

/// The most unknown parameters whose faults list the known ones.
const MOST_WITH_KNOWN: usize = 4;

/// The parameters of a calculation's query.
pub(crate) struct Query {
    members: Vec<QueryMember>,
}

/// A parameter, and the member of the JSON request that it sets.
#[derive(Clone)]
struct QueryMember {
    name: String,
    /// The names of the member and of the objects around it, outermost first.
    path: Vec<String>,
    is_required: bool,
    about: Option<String>,
    /// The schema without references and description.
    schema: Value,
    /// Whether its value is JSON: an array of objects.
    is_json: bool,
}

impl Query {
    /// The parameters for the members of the JSON request that `describe` describes.
    pub(crate) fn of(describe: fn(&mut Components) -> RefOr<Schema>) -> Self {
        let mut components = Components::default();
        let schema = value_of(&describe(&mut components));
        let named = components.into_named().into_iter().map(|(name, schema)| (name, value_of(&schema))).collect();
        Self { members: members_of(&schema, &named, &[]) }
    }

    /// The parameters for the OpenAPI document.
    pub(crate) fn describe(&self) -> Vec<Parameter> {
        let describe = |member: &QueryMember| {
            let schema: Schema = serde_json::from_value(member.schema.clone())
                .unwrap_or_else(|error| unreachable!("a schema that was written can be read: {error}"));
            let parameter = ParameterBuilder::new()
                .name(&member.name)
                .parameter_in(ParameterIn::Query)
                .required(if member.is_required { Required::True } else { Required::False })
                .description(member.about.clone())
                .schema(Some(schema));
            let parameter = if member.is_list() { parameter.style(Some(ParameterStyle::Form)).explode(Some(false)) } else { parameter };
            parameter.build()
        };
        self.members.iter().map(describe).collect()
    }

    /// Reads a query with the reader of the JSON request.
    pub(crate) fn read<T>(
        &self,
        query: &str,
        read: impl FnOnce(&mut Object<'_, '_>, &mut Faults) -> Result<T, Faulted>,
    ) -> Result<T, Problem> {
        let mut faults = Faults::at_most(MOST_FAULTS);
        let mut given: Vec<(&QueryMember, Cow<'_, str>)> = Vec::new();
        for (name, value) in form_urlencoded::parse(query.as_bytes()) {
            let root = JsonPath::Root;
            let path = root.member(&name);
            let Some(member) = self.members.iter().find(|member| member.name == name) else {
                self.unknown(&name, &path, &mut faults);
                continue;
            };
            if value.is_empty() {
                faults.add(&path, RequestFault::WrongType, "the parameter has no value; leave it out or give one");
            }
            match given.iter_mut().find(|(known, _)| known.name == member.name) {
                None => given.push((member, value)),
                // Generated clients repeat the name for each number, even if the document states another form.
                Some((_, numbers)) if member.is_list() => {
                    let numbers = numbers.to_mut();
                    numbers.push(',');
                    numbers.push_str(&value);
                }
                Some(_) => {
                    faults.add(&path, RequestFault::RepeatedField, "the parameter is given more than once");
                }
            }
        }
        let (json, mut of_json) = (json_of(&given), Faults::default());
        let object = Object::open_body(json.as_bytes(), &mut of_json).map_err(|error| malformed(&error))?;
        let result = object.and_then(|object| object.read(&mut of_json, read));
        let is_empty = |pointer: &str| given.iter().any(|(member, value)| value.is_empty() && format!("/{}", member.name) == pointer);
        of_json.name_others(|object, known| self.others(object, known));
        // The fault of an empty parameter has been recorded already.
        faults.take_in(of_json, |pointer| Some(self.pointer(pointer, &given)).filter(|pointer| !is_empty(pointer)));
        match result {
            Ok(result) if faults.is_empty() => Ok(result),
            _ => Err(Problem::faulty_request(faults)),
        }
    }

    /// Records an unknown parameter: with the one that was probably meant, or with all of them if it is among the first.
    fn unknown(&self, name: &str, path: &JsonPath<'_>, faults: &mut Faults) {
        let known = || self.members.iter().map(|member| member.name.as_str());
        let detail = match meant(name, known()) {
            Some(meant) => format!("unknown parameter; did you mean {meant}?"),
            None if faults.count() < MOST_WITH_KNOWN => {
                format!("unknown parameter; known here: {}", known().collect::<Vec<_>>().join(", "))
            }
            None => "unknown parameter".to_owned(),
        };
        faults.add(path, RequestFault::UnknownField, detail);
    }

    /// The text of a fault of a parameter that the others exclude, such as the corner radius of a ball-end cutter: the
    /// parameters that the object may have.
    fn others(&self, object: &str, known: &[&'static str]) -> String {
        let path =
            |name: &str| [object.trim_start_matches('/'), name].into_iter().filter(|part| !part.is_empty()).map(str::to_owned).collect();
        let names = known.iter().filter_map(|name| {
            let path: Vec<String> = path(name);
            self.members.iter().find(|member| member.path == path).map(|member| member.name.as_str())
        });
        format!("the parameter does not go with the others; those that do: {}", names.collect::<Vec<_>>().join(", "))
    }

    /// The pointer to the parameter for the member at `pointer` of the JSON request; for an object, to the first given
    /// parameter in it.
    fn pointer(&self, pointer: &str, given: &[(&QueryMember, Cow<'_, str>)]) -> String {
        for member in &self.members {
            if let Some(rest) = pointer.strip_prefix(&member.pointer())
                && (rest.is_empty() || rest.starts_with('/'))
            {
                return format!("/{}{rest}", member.name);
            }
        }
        let inside = format!("{pointer}/");
        if let Some((member, _)) = given.iter().find(|(member, _)| pointer.len() > 1 && member.pointer().starts_with(&inside)) {
            return format!("/{}", member.name);
        }
        // An object without parameters has no location in the query.
        let is_object = self.members.iter().any(|member| member.pointer().starts_with(&inside));
        if is_object { String::new() } else { pointer.to_owned() }
    }
}

impl QueryMember {
    /// Whether its value is numbers separated by commas, or the name repeated for each number.
    fn is_list(&self) -> bool {
        self.schema["type"] == "array"
    }

    fn pointer(&self) -> String {
        format!("/{}", self.path.join("/"))
    }
}

/// The name of the parameter for the member at `path`.
fn name_of(path: &[&str]) -> String {
    match path {
        ["cutter", "type"] => "cutter".to_owned(),
        ["cutter" | "contact", name] => (*name).to_owned(),
        names => names.join("_"),
    }
}

/// The parameters for a JSON request, with their values.
pub(crate) fn parameters_of(request: &Value) -> Vec<(String, &Value)> {
    let members = request.as_object().into_iter().flatten();
    let parameters = members.flat_map(|(outer, value)| match value.as_object() {
        Some(members) => members.iter().map(|(name, value)| (name_of(&[outer, name]), value)).collect(),
        None => vec![(name_of(&[outer]), value)],
    });
    parameters.collect()
}

/// The members of a request's schema that are not objects, including those of nested objects, each once.
fn members_of(schema: &Value, named: &BTreeMap<String, Value>, path: &[String]) -> Vec<QueryMember> {
    let schema = resolved(schema, named);
    if let Some(forms) = schema["oneOf"].as_array() {
        let forms: Vec<_> = forms.iter().map(|form| members_of(form, named, path)).collect();
        let mut members: Vec<QueryMember> = Vec::new();
        let is_in_all = |path: &[String]| forms.iter().all(|form| form.iter().any(|member| member.path == path && member.is_required));
        for member in forms.iter().flatten() {
            match members.iter_mut().find(|known| known.path == member.path) {
                // Each form has its own constant for `type`.
                Some(known) => {
                    if let (Some(words), Some(more)) = (known.schema["enum"].as_array_mut(), member.schema["enum"].as_array()) {
                        words.extend(more.iter().filter(|word| !words.contains(word)).cloned().collect::<Vec<_>>());
                    }
                }
                None => members.push(QueryMember { is_required: is_in_all(&member.path), ..member.clone() }),
            }
        }
        return members;
    }
    let Some(properties) = schema["properties"].as_object() else { return Vec::new() };
    let mut members = Vec::new();
    for (name, property) in properties {
        let path: Vec<String> = path.iter().chain([name]).cloned().collect();
        let is_required = schema["required"].as_array().is_some_and(|required| required.iter().any(|required| required == name));
        let target = resolved(property, named);
        let inner = members_of(target, named, &path);
        if !inner.is_empty() {
            members.extend(inner.into_iter().map(|inner| QueryMember { is_required: is_required && inner.is_required, ..inner }));
            continue;
        }
        let about = property["description"].as_str().or(target["description"].as_str()).map(str::to_owned);
        let items = resolved(&target["items"], named);
        let is_json = items["properties"].is_object();
        let about = about.map(|about| if is_json { format!("{about}; as JSON") } else { about });
        let mut schema =
            if is_json { json!({"type": "string", "examples": [example_of(items, named).to_string()]}) } else { target.clone() };
        if let Some(schema) = schema.as_object_mut() {
            schema.remove("description");
        }
        let name = name_of(&path.iter().map(String::as_str).collect::<Vec<_>>());
        members.push(QueryMember { name, path, is_required, about, schema, is_json });
    }
    members
}

/// An array of one object with the examples of its members.
fn example_of(object: &Value, named: &BTreeMap<String, Value>) -> Value {
    let members = object["properties"].as_object().into_iter().flatten();
    let examples = members.map(|(name, member)| (name.clone(), resolved(member, named)["examples"][0].clone()));
    json!([examples.collect::<serde_json::Map<_, _>>()])
}

fn resolved<'s>(schema: &'s Value, named: &'s BTreeMap<String, Value>) -> &'s Value {
    let name = schema["$ref"].as_str().and_then(|reference| reference.rsplit('/').next());
    name.and_then(|name| named.get(name)).unwrap_or(schema)
}

fn value_of(schema: &RefOr<Schema>) -> Value {
    serde_json::to_value(schema).unwrap_or_else(|error| unreachable!("a schema can be written: {error}"))
}

/// The JSON request for the given parameters. It always has a cutter and a contact, so that their missing members are
/// reported.
fn json_of(given: &[(&QueryMember, Cow<'_, str>)]) -> String {
    let mut objects: BTreeMap<&str, String> = BTreeMap::from([("cutter", String::new()), ("contact", String::new())]);
    let mut json = String::new();
    for (member, value) in given {
        let value = match member.schema["type"].as_str() {
            _ if member.is_json && serde_json::from_str::<&RawValue>(value).is_ok() => value.to_string(),
            Some("string") => quoted(value),
            Some("array") => format!("[{}]", value.split(',').map(number).collect::<Vec<_>>().join(",")),
            _ => number(value),
        };
        match member.path.as_slice() {
            [name] => _ = write!(json, "{}:{value},", quoted(name)),
            [object, name] => _ = write!(objects.entry(object).or_default(), "{}:{value},", quoted(name)),
            path => unreachable!("the requests of calculations have no objects in objects: {path:?}"),
        }
    }
    for (name, members) in objects {
        let _ = write!(json, "{}:{{{}}},", quoted(name), members.trim_end_matches(','));
    }
    format!("{{{}}}", json.trim_end_matches(','))
}

/// The value as JSON: a number as it is, anything else as a string, which the reader of numbers refuses.
fn number(value: &str) -> String {
    let token = match value.to_ascii_lowercase().as_str() {
        "nan" => "NaN",
        "inf" | "infinity" => "Infinity",
        "-inf" | "-infinity" => "-Infinity",
        _ => "",
    };
    if let Some(mark) = mark(token) {
        return mark.to_owned();
    }
    let is_number = value.starts_with(|first: char| first == '-' || first.is_ascii_digit())
        && serde_json::from_str::<&RawValue>(value).is_ok_and(|number| number.get().len() == value.len());
    if is_number { value.to_owned() } else { quoted(value) }
}

fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}
