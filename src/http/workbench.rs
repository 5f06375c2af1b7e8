//! The workbench: an interactive page with its scripts and styles, embedded in the binary.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Write;
use std::sync::LazyLock;

use axum::Router;
use axum::extract::Path;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use flate2::Compression;
use flate2::write::GzEncoder;

use super::app_state::AppState;

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
    "contact/frame.js",
    "contact/polar.js",
    "contact/profile.js",
    "contact/request.js",
    "contact/view.js",
    "docs.css",
    "docs.html",
    "dom.js",
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
    "part/cutters.js",
    "part/examples.js",
    "part/legend.js",
    "part/map.js",
    "part/overlays.js",
    "part/palette.js",
    "part/relief.js",
    "part/request.js",
    "part/view.js",
    "path/example.js",
    "path/table.js",
    "path/view.js",
    "service.js",
    "terms.js",
    "tooltip.js",
    "units.js",
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

/// The routes of the workbench at `/`, of its files under `/workbench/`, and of the page around the API's
/// documentation.
pub(super) fn routes() -> Router<AppState> {
    let page = |name: &'static str| get(async move |headers: HeaderMap| serve(name, &headers));
    Router::new()
        .route("/", page("index.html"))
        .route("/favicon.ico", page("favicon.svg"))
        .route("/glossary", page("glossary.html"))
        .route("/docs/", page("docs.html"))
        .route("/workbench/{*file}", get(async |Path(file): Path<String>, headers: HeaderMap| serve(&file, &headers)))
}

/// A file, plain and compressed.
struct Asset {
    media_type: &'static str,
    plain: &'static [u8],
    gzip: Vec<u8>,
    /// Each encoding has its own entity tag, because the bytes differ.
    plain_tag: HeaderValue,
    gzip_tag: HeaderValue,
}

/// All files, compressed on the first request, which takes some 10 ms.
static ASSETS: LazyLock<HashMap<&'static str, Asset>> =
    LazyLock::new(|| FILES.iter().chain([&CODES]).map(|&(path, plain)| (path, Asset::new(path, plain))).collect());

impl Asset {
    fn new(path: &str, plain: &'static [u8]) -> Self {
        let mut hasher = DefaultHasher::new();
        plain.hash(&mut hasher);
        let digest = hasher.finish();
        let tag = |encoding: &str| {
            HeaderValue::try_from(format!("\"{digest:016x}{encoding}\""))
                .unwrap_or_else(|error| unreachable!("digits are a header's value: {error}"))
        };
        Self { media_type: media_type(path), plain, gzip: gzip(plain), plain_tag: tag(""), gzip_tag: tag("-gzip") }
    }
}

fn gzip(plain: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    encoder
        .write_all(plain)
        .and_then(|()| encoder.finish())
        .unwrap_or_else(|error| unreachable!("a vector takes all that is written: {error}"))
}

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
    let Some(asset) = ASSETS.get(path) else { return StatusCode::NOT_FOUND.into_response() };
    let compressed = accepts_gzip(headers);
    let (body, tag) = if compressed { (asset.gzip.as_slice(), &asset.gzip_tag) } else { (asset.plain, &asset.plain_tag) };
    let mut response = if has_tag(headers, tag) { StatusCode::NOT_MODIFIED.into_response() } else { body.into_response() };
    let answered = response.headers_mut();
    answered.insert(header::CONTENT_TYPE, HeaderValue::from_static(asset.media_type));
    answered.insert(header::ETAG, tag.clone());
    answered.insert(header::CACHE_CONTROL, REVALIDATE);
    answered.insert(header::VARY, HeaderValue::from_static("accept-encoding"));
    if compressed && response.status() == StatusCode::OK {
        response.headers_mut().insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
    if asset.media_type.starts_with("text/html") && path != "docs.html" {
        response.headers_mut().insert(header::CONTENT_SECURITY_POLICY, PAGE_POLICY);
    }
    response
}

fn listed(headers: &HeaderMap, name: header::HeaderName) -> impl Iterator<Item = &str> {
    headers.get_all(name).into_iter().filter_map(|value| value.to_str().ok()).flat_map(|value| value.split(',')).map(str::trim)
}

fn accepts_gzip(headers: &HeaderMap) -> bool {
    listed(headers, header::ACCEPT_ENCODING).any(|encoding| {
        let (name, quality) = encoding.split_once(';').unwrap_or((encoding, "q=1"));
        let refused =
            quality.trim().strip_prefix("q=").and_then(|quality| quality.parse::<f32>().ok()).is_some_and(|quality| quality <= 0.0);
        name.trim().eq_ignore_ascii_case("gzip") && !refused
    })
}

fn has_tag(headers: &HeaderMap, tag: &HeaderValue) -> bool {
    listed(headers, header::IF_NONE_MATCH)
        .any(|known| known == "*" || known.strip_prefix("W/").unwrap_or(known).as_bytes() == tag.as_bytes())
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
    fn a_file_is_sent_as_the_browser_accepts_it_and_only_once() {
        let plain = asked(&[], "main.js");
        assert_eq!((plain.status(), plain.headers().get(header::CONTENT_ENCODING)), (StatusCode::OK, None));
        for (accepted, compressed) in [("gzip", true), ("br, gzip;q=0.5", true), ("gzip;q=0", false), ("br", false)] {
            let response = asked(&[(header::ACCEPT_ENCODING, accepted)], "main.js");
            assert_eq!(response.headers().contains_key(header::CONTENT_ENCODING), compressed, "{accepted}");
            assert_eq!(response.headers()[header::ETAG] == plain.headers()[header::ETAG], !compressed);
        }
        let tag = plain.headers()[header::ETAG].clone();
        let again = serve("main.js", &[(header::IF_NONE_MATCH, tag)].into_iter().collect());
        assert_eq!(again.status(), StatusCode::NOT_MODIFIED);
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
