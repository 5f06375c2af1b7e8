//! Pages for people: the workbench, an interactive page with its scripts and styles embedded in the binary, and the
//! documentation of the API.

use super::app_state::AppState;
use super::{OPENAPI_3_0_JSON, openapi_json};
use axum::Router;
use axum::extract::Path;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;
use memchr::memmem;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::LazyLock;
use utoipa_swagger_ui::{Config, SwaggerUi};

/// Embeds files of `web/`, each with its path.
macro_rules! embedded {
    ($($path:literal),* $(,)?) => {
        [$(($path, include_bytes!(concat!("../../web/", $path)) as &'static [u8])),*]
    };
}

const FILES: &[(&str, &[u8])] = &embedded![
    "charts.js",
    "clipboard.js",
    "contact/curves.js",
    "contact/drawing.js",
    "contact/fields.js",
    "contact/frame.js",
    "contact/polar.js",
    "contact/profile.js",
    "contact/remedies.js",
    "contact/request.js",
    "contact/view.js",
    "docs.css",
    "docs.html",
    "dom.js",
    "drop.js",
    "examples/surface_1.json",
    "examples/surface_2.json",
    "favicon.svg",
    "fields.js",
    "figures.js",
    "glossary.html",
    "glossary.js",
    "index.html",
    "link.js",
    "main.js",
    "part/answer.js",
    "part/colouring.js",
    "part/cutter_drawing.js",
    "part/cutters.js",
    "part/examples.js",
    "part/kept.js",
    "part/legend.js",
    "part/map.js",
    "part/operations.js",
    "part/overlays.js",
    "part/palette.js",
    "part/program.js",
    "part/request.js",
    "part/sending.js",
    "part/sheet.js",
    "part/slider.js",
    "part/verdict.js",
    "part/view.js",
    "path/check.js",
    "path/check_answer.js",
    "path/check_request.js",
    "path/contacts.js",
    "path/example.js",
    "path/table.js",
    "path/view.js",
    "service.js",
    "solid/geometry.js",
    "solid/view.js",
    "terms.js",
    "tolerance.js",
    "tooling/csv.js",
    "tooling/freecad.js",
    "tooling/fusion.js",
    "tooling/library.js",
    "tooling/shape.js",
    "tooling/zip.js",
    "tooltip.js",
    "units.js",
    "vendor/ogl/LICENSE",
    "vendor/ogl/ogl.min.js",
    "vendor/uplot/LICENSE",
    "vendor/uplot/uPlot.iife.min.js",
    "vendor/uplot/uPlot.min.css",
    "workbench.css",
];

/// The table of codes, which the glossary page shows.
const CODES: (&str, &[u8]) = ("codes.md", include_bytes!("../../docs/codes.md"));

/// Allows only scripts, styles and requests of this server, and nothing inline. The API's documentation has another
/// policy.
const PAGE_POLICY: HeaderValue = HeaderValue::from_static(
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; \
     form-action 'none'; frame-ancestors 'none'",
);

/// Browsers must revalidate files each time, so that a page never runs with the scripts of another version.
const REVALIDATE: HeaderValue = HeaderValue::from_static("no-cache");

/// The routes of the workbench at `/`, of its files under `/workbench/`, and of the API's documentation with its scripts and
/// styles. They are not in the OpenAPI document, because programs do not call them.
pub(super) fn routes() -> Router<AppState> {
    let page = |name: &'static str| get(async move |headers: HeaderMap| serve(name, &headers));
    let documentation = SwaggerUi::new("/docs/ui").config(
        Config::from("/openapi.json")
            // Expanded, the list of a hundred schemas would hide the operations.
            .default_models_expand_depth(0)
            .display_request_duration(true)
            .try_it_out_enabled(true),
    );
    Router::new()
        .route("/", page("index.html"))
        .route("/favicon.ico", page("favicon.svg"))
        .route("/glossary", page("glossary.html"))
        .route("/docs", get(async || Redirect::to("/docs/")))
        .route("/docs/", page("docs.html"))
        .route("/workbench/{*file}", get(async |Path(file): Path<String>, headers: HeaderMap| serve(&file, &headers)))
        .merge(documentation)
}

/// The entity tag of all files. It is weak, because a layer may compress them.
static TAG: LazyLock<HeaderValue> = LazyLock::new(|| {
    let mut hasher = DefaultHasher::new();
    (FILES, CODES).hash(&mut hasher);
    HeaderValue::try_from(format!("W/\"{:016x}\"", hasher.finish()))
        .unwrap_or_else(|error| unreachable!("digits are a header's value: {error}"))
});

fn media_type(path: &str) -> &'static str {
    match path.rsplit_once('.').map(|(_, extension)| extension) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("json") => "application/json",
        _ => "text/plain; charset=utf-8",
    }
}

/// The file, or status 304 if the browser has the same version.
fn serve(path: &str, headers: &HeaderMap) -> Response {
    let Some((_, file)) = FILES.iter().chain([&CODES]).find(|(known, _)| *known == path) else {
        return StatusCode::NOT_FOUND.into_response();
    };
    // Tags are compared without `W/`, and `*` stands for any version (RFC 9110, section 13.1.2).
    let digest = &TAG.as_bytes()[b"W/".len()..];
    let is_known = |tags: &HeaderValue| tags == "*" || memmem::find(tags.as_bytes(), digest).is_some();
    let is_known = headers.get_all(header::IF_NONE_MATCH).iter().any(is_known);
    let mut response = if is_known { StatusCode::NOT_MODIFIED.into_response() } else { file.into_response() };
    let media_type = media_type(path);
    let answered = response.headers_mut();
    answered.insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    answered.insert(header::ETAG, TAG.clone());
    answered.insert(header::CACHE_CONTROL, REVALIDATE);
    // The layer that compresses answers adds it only to those with a body.
    answered.insert(header::VARY, header::ACCEPT_ENCODING.into());
    if media_type.starts_with("text/html") && path != "docs.html" {
        answered.insert(header::CONTENT_SECURITY_POLICY, PAGE_POLICY);
    }
    response
}

/// The OpenAPI document
///
/// This description of the service, in OpenAPI 3.1.
#[utoipa::path(
    get, path = "/openapi.json", tag = "service", operation_id = "openapi",
    responses((status = 200, description = "The document", body = serde_json::Value, content_type = "application/json")),
)]
pub(super) async fn openapi() -> impl IntoResponse {
    static DOCUMENT: LazyLock<String> = LazyLock::new(openapi_json);
    ([(header::CONTENT_TYPE, "application/json")], DOCUMENT.as_str())
}

/// The OpenAPI document in version 3.0.3
///
/// For generators of clients that do not read 3.1. It leaves out operations that take forms, which many of these
/// generators refuse.
#[utoipa::path(
    get, path = "/openapi-3.0.json", tag = "service", operation_id = "openapi_3_0",
    responses((status = 200, description = "The document", body = serde_json::Value, content_type = "application/json")),
)]
pub(super) async fn openapi_3_0() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "application/json")], OPENAPI_3_0_JSON)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn files_of(folder: &Path, found: &mut Vec<String>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                files_of(&path, found);
            } else {
                found.push(path.to_str().unwrap().rsplit_once("/web/").unwrap().1.to_owned());
            }
        }
    }

    #[test]
    fn every_file_of_the_page_is_embedded() {
        let mut found = Vec::new();
        files_of(&Path::new(env!("CARGO_MANIFEST_DIR")).join("web"), &mut found);
        found.retain(|path| !path.starts_with("tests/") && !path.ends_with("README.md"));
        found.sort();
        assert_eq!(found, FILES.iter().map(|(path, _)| *path).collect::<Vec<_>>());
    }

    fn asked(headers: &[(header::HeaderName, &'static str)], path: &str) -> Response {
        serve(path, &headers.iter().map(|(name, value)| (name.clone(), HeaderValue::from_static(value))).collect())
    }

    #[test]
    fn a_file_is_sent_only_once() {
        let tag = asked(&[], "main.js").headers()[header::ETAG].to_str().unwrap().to_owned();
        for (known, status) in [
            (tag.clone(), StatusCode::NOT_MODIFIED),
            (tag.replace("W/", ""), StatusCode::NOT_MODIFIED),
            (format!("\"other\", {tag}"), StatusCode::NOT_MODIFIED),
            ("*".to_owned(), StatusCode::NOT_MODIFIED),
            ("\"other\"".to_owned(), StatusCode::OK),
            ("\"*\"".to_owned(), StatusCode::OK),
        ] {
            let known = HeaderValue::try_from(known).unwrap();
            let answer = serve("main.js", &[(header::IF_NONE_MATCH, known)].into_iter().collect());
            assert_eq!((answer.status(), &answer.headers()[header::VARY]), (status, &HeaderValue::from_static("accept-encoding")));
        }
        assert_eq!(asked(&[], "../Cargo.toml").status(), StatusCode::NOT_FOUND);
    }

    #[test]
    fn pages_forbid_inline_scripts_and_styles() {
        for page in ["index.html", "glossary.html"] {
            let policy = asked(&[], page).headers()[header::CONTENT_SECURITY_POLICY].to_str().unwrap().to_owned();
            assert!(!policy.contains("unsafe"), "{policy}");
        }
    }
}
