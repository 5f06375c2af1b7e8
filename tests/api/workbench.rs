//! The workbench and the pages around it: every file that a page names is served, and nothing inline is allowed.

use crate::app::TestApp;

/// The addresses in the `href` and `src` attributes of a page.
fn addresses(page: &str) -> Vec<&str> {
    ["href=\"", "src=\""].iter().flat_map(|attribute| page.split(attribute).skip(1)).filter_map(|rest| rest.split('"').next()).collect()
}

#[tokio::test]
async fn pages_find_every_file_that_they_name() {
    let app = TestApp::start().await;
    for (path, folder) in [("/", "/"), ("/glossary", "/"), ("/docs/", "/docs/")] {
        let page = app.get(path).await.text().await.unwrap();
        let named = addresses(&page);
        assert!(named.len() > 3, "{path}");
        for address in named {
            let address = address
                .strip_prefix("../")
                .map_or_else(|| format!("{folder}{}", address.trim_start_matches('.')), |rest| format!("/{rest}"));
            let answer = app.get(&address).await;
            assert_eq!(answer.status(), 200, "{path} names {address}");
            assert!(!answer.headers()["content-type"].is_empty());
        }
    }
}

#[tokio::test]
async fn the_workbench_forbids_inline_scripts_and_is_revalidated() {
    let app = TestApp::start().await;
    let page = app.get("/").await;
    let policy = page.headers()["content-security-policy"].to_str().unwrap();
    assert!(policy.contains("script-src 'self'") && !policy.contains("unsafe"), "{policy}");
    let tag = page.headers()["etag"].clone();
    let again = app.client.get(app.url("/")).header("if-none-match", tag).send().await.unwrap();
    assert_eq!(again.status(), 304);
    assert_eq!((&again.headers()["vary"], &again.headers()["etag"]), (&page.headers()["vary"], &page.headers()["etag"]));
    assert_eq!(app.get("/workbench/no-such-file.js").await.status(), 404);
}
