//! Decompression of request bodies.
//!
//! `tower_http::decompression` 0.7.1 ends a request's body after the first member of a gzip file and drops the others
//! without an error; `pigz`, `bgzip` and `cat` write files of several members.

use async_compression::tokio::bufread::GzipDecoder;
use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, header};
use http_body_util::BodyExt;
use tokio_util::io::{ReaderStream, StreamReader};

/// The largest part of a body that is decompressed at once, in bytes.
const PART: usize = 16 * 1024;

/// Whether the headers name gzip as the coding of the body; `None` for another coding and for several. Names are
/// case-insensitive, and `x-gzip` is another name of gzip (RFC 9110, section 8.4.1).
pub(super) fn is_gzip(headers: &HeaderMap) -> Option<bool> {
    let mut names = headers.get_all(header::CONTENT_ENCODING).iter();
    let Some(name) = names.next() else { return Some(false) };
    let is = |coding: &[u8]| name.as_bytes().eq_ignore_ascii_case(coding);
    match names.next() {
        None if is(b"gzip") || is(b"x-gzip") => Some(true),
        None if is(b"identity") => Some(false),
        _ => None,
    }
}

/// The request with its body decompressed, all members of it.
pub(super) fn decompressed(mut request: Request) -> Request {
    if is_gzip(request.headers()) != Some(true) {
        return request;
    }
    request.headers_mut().remove(header::CONTENT_ENCODING);
    request.headers_mut().remove(header::CONTENT_LENGTH);
    request.map(|body| {
        let compressed = body.map_err(std::io::Error::other).into_data_stream();
        let mut decoder = GzipDecoder::new(StreamReader::new(compressed));
        decoder.multiple_members(true);
        Body::from_stream(ReaderStream::with_capacity(decoder, PART))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use std::io::Write;

    fn member(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    async fn read(body: Vec<u8>) -> Result<Vec<u8>, String> {
        let request = Request::builder().header(header::CONTENT_ENCODING, "gzip").body(Body::from(body)).unwrap();
        let body = decompressed(request).into_body().collect().await;
        body.map(|body| body.to_bytes().to_vec()).map_err(|error| error.to_string())
    }

    #[tokio::test]
    async fn all_members_are_decompressed() {
        let long = vec![b'x'; 100_000];
        let bodies = [b"first,".as_slice(), &[], &long, b"last"];
        let file: Vec<u8> = bodies.iter().flat_map(|body| member(body)).collect();
        assert_eq!(read(file.clone()).await.unwrap(), bodies.concat());
        for end in [file.len() - 1, file.len() - 9, file.len() - 20] {
            read(file[..end].to_vec()).await.unwrap_err();
        }
        read([file, b"no gzip member".to_vec()].concat()).await.unwrap_err();
    }

    #[test]
    fn names_of_codings_have_no_case() {
        let of = |names: &[&'static str]| {
            let headers = names.iter().map(|name| (header::CONTENT_ENCODING, HeaderValue::from_static(name)));
            is_gzip(&headers.collect())
        };
        assert_eq!(of(&[]), Some(false));
        assert_eq!(["gzip", "GZIP", "x-gzip"].map(|name| of(&[name])), [Some(true); 3]);
        assert_eq!(of(&["Identity"]), Some(false));
        assert_eq!(["br", "gzip, gzip", ""].map(|name| of(&[name])), [None; 3]);
        assert_eq!(of(&["gzip", "br"]), None);
    }
}
