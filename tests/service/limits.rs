//! Bodies over the size limit, before or after decompression.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use axum::body::{Body, Bytes};
use axum::routing::post;
use http_body_util::BodyExt;
use scallopd::http::{RouteClass, Routes};
use tokio::io::AsyncWriteExt;

use crate::app::{PATIENCE, TestApp, defaults, gzip};
use crate::service::server::{self, read_all, send};

const LIMIT: usize = 1 << 20;

/// A route that counts the bytes it reads, and the count.
fn counting() -> (Routes, Arc<AtomicUsize>) {
    let count = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&count);
    let read = move |mut body: Body| async move {
        while let Some(Ok(frame)) = body.frame().await {
            counted.fetch_add(frame.data_ref().map_or(0, Bytes::len), Ordering::SeqCst);
        }
        "whatever the handler makes of the error"
    };
    let routes = Routes::new().undocumented(RouteClass::Batch, "/read/batch", post(read.clone()));
    (routes.undocumented(RouteClass::Single, "/read", post(read)), count)
}

async fn start() -> (TestApp, Arc<AtomicUsize>) {
    let (routes, count) = counting();
    let mut settings = defaults();
    settings.max_json = LIMIT as u64;
    (server::start(settings, routes).await, count)
}

async fn post_gzip(server: &TestApp, path: &str, body: Vec<u8>) -> reqwest::Response {
    server.client.post(server.url(path)).header("content-encoding", "gzip").body(body).send().await.unwrap()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stated_length_over_the_limit_is_refused_unread() {
    let (server, count) = start().await;
    let mut stream = server.connect().await;
    send(&mut stream, "POST /read/batch HTTP/1.1\r\nhost: test\r\ncontent-length: 1048577\r\n\r\n").await;
    let answer = read_all(&mut stream).await;
    assert!(answer.starts_with("HTTP/1.1 413"), "{answer}");
    assert!(answer.contains("\"type\":\"too-large\""), "{answer}");
    assert_eq!(count.load(Ordering::SeqCst), 0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_endless_body_is_read_up_to_the_limit_and_refused() {
    let (server, count) = start().await;
    let stream = server.connect().await;
    let (mut reader, mut writer) = stream.into_split();
    let sending = tokio::spawn(async move {
        writer.write_all(b"POST /read/batch HTTP/1.1\r\nhost: test\r\ntransfer-encoding: chunked\r\n\r\n").await.unwrap();
        let chunk = [&b"800\r\n"[..], &[b'x'; 0x800], b"\r\n"].concat();
        let mut sent = 0;
        while writer.write_all(&chunk).await.is_ok() {
            sent += chunk.len();
        }
        sent
    });
    let mut answer = [0; 12];
    tokio::io::AsyncReadExt::read_exact(&mut reader, &mut answer).await.unwrap();
    assert_eq!(&answer, b"HTTP/1.1 413");
    let read = count.load(Ordering::SeqCst);
    assert!(read > 0 && read <= LIMIT, "{read}");
    // The server closes the connection, so the client cannot send without end.
    tokio::time::timeout(PATIENCE, sending).await.expect("the connection ends").unwrap();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_gzip_bomb_is_decompressed_up_to_the_limit_and_refused() {
    let (server, count) = start().await;
    let bomb = gzip(&vec![0; 200 << 20]);
    assert!(bomb.len() < LIMIT, "the bomb is small before decompression: {}", bomb.len());
    let answer = post_gzip(&server, "/read/batch", bomb).await;
    assert_eq!(answer.status(), 413);
    let read = count.load(Ordering::SeqCst);
    assert!(read > 0 && read <= LIMIT, "{read}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_body_of_exactly_the_limit_is_accepted_plain_and_compressed() {
    let (server, count) = start().await;
    let body = vec![b'x'; LIMIT];
    let plain = server.client.post(server.url("/read/batch")).body(body.clone()).send().await.unwrap();
    assert_eq!(plain.status(), 200);
    assert_eq!(post_gzip(&server, "/read/batch", gzip(&body)).await.status(), 200);
    assert_eq!(count.load(Ordering::SeqCst), 2 * LIMIT);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn single_calculations_have_a_smaller_limit() {
    let (server, _) = start().await;
    for (length, status) in [(64 * 1024, 200), (64 * 1024 + 1, 413)] {
        let answer = server.client.post(server.url("/read")).body(vec![b'x'; length]).send().await.unwrap();
        assert_eq!(answer.status(), status, "{length}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_body_that_contradicts_its_encoding_is_malformed_and_an_unknown_encoding_unsupported() {
    let (server, _) = start().await;
    let broken = post_gzip(&server, "/read", b"not gzip at all".to_vec()).await;
    assert_eq!(broken.status(), 400);
    assert_eq!(broken.headers()["content-type"], "application/problem+json");
    let unknown = server.client.post(server.url("/read")).header("content-encoding", "br").body("x").send().await.unwrap();
    assert_eq!(unknown.status(), 415);
    assert_eq!(unknown.headers()["accept-encoding"], "gzip");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_answer_to_an_unread_body_announces_the_end_of_the_connection() {
    let (server, _) = start().await;
    let unread = server.client.post(server.url("/nothing")).body("x".repeat(10)).send().await.unwrap();
    assert_eq!(unread.status(), 404);
    assert_eq!(unread.headers()["connection"], "close");
    let read = server.client.post(server.url("/read")).body("x".repeat(10)).send().await.unwrap();
    assert!(!read.headers().contains_key("connection"));
    assert!(!server.get("/nothing").await.headers().contains_key("connection"));
}
