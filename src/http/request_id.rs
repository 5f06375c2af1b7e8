//! Request ids: the caller's if it is valid, otherwise one created here.

use std::hash::{BuildHasher, RandomState};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use axum::extract::Request;
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use axum::response::Response;

/// The header of the id, in requests and answers.
pub(super) const HEADER: HeaderName = HeaderName::from_static("x-request-id");

/// The longest id that is accepted, because every log line contains it.
const LONGEST: usize = 128;

/// The id of the request that a handler answers, as an extension of the request.
#[derive(Debug, Clone)]
pub(crate) struct RequestId(HeaderValue);

impl RequestId {
    /// The caller's id if it is valid: letters, digits, `-`, `_`, `.`, `:`, `/`, `+` and `=`, which covers UUIDs and
    /// trace ids and excludes characters that could break a log line or a page.
    fn of_caller(headers: &HeaderMap) -> Option<Self> {
        let id = headers.get(HEADER)?;
        let sane = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.:/+=".contains(byte);
        (!id.is_empty() && id.len() <= LONGEST && id.as_bytes().iter().all(sane)).then(|| Self(id.clone()))
    }

    /// An id that is unique among the requests of all processes: a random number drawn at the start of the process, and
    /// a counter. It is not a secret.
    pub(super) fn create() -> Self {
        static PREFIX: LazyLock<String> = LazyLock::new(|| format!("{:016x}-", RandomState::new().hash_one(std::process::id())));
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let id = format!("{}{count:08x}", *PREFIX);
        Self(HeaderValue::try_from(id).unwrap_or_else(|_| unreachable!("hexadecimal digits make a header")))
    }

    /// The id.
    #[must_use]
    pub(crate) fn as_str(&self) -> &str {
        // Both constructors ensure visible ASCII.
        self.0.to_str().unwrap_or_default()
    }

    /// Adds the id to an answer.
    pub(super) fn mark(&self, response: &mut Response) {
        response.headers_mut().insert(HEADER, self.0.clone());
    }
}

/// Adds the id to the request, as an extension and as the header.
pub(super) fn take_or_create(request: &mut Request) -> RequestId {
    let id = RequestId::of_caller(request.headers()).unwrap_or_else(RequestId::create);
    request.headers_mut().insert(HEADER, id.0.clone());
    request.extensions_mut().insert(id.clone());
    id
}

#[cfg(test)]
mod tests {
    use axum::body::Body;

    use super::*;

    fn id_for(sent: Option<&[u8]>) -> String {
        let mut request = Request::new(Body::empty());
        if let Some(sent) = sent {
            request.headers_mut().insert(HEADER, HeaderValue::from_bytes(sent).unwrap());
        }
        take_or_create(&mut request).as_str().to_owned()
    }

    #[test]
    fn a_usable_id_is_kept() {
        for sent in ["7", "3f2c-9", "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01", "a/b+c=="] {
            assert_eq!(id_for(Some(sent.as_bytes())), sent);
        }
    }

    #[test]
    fn an_unusable_id_is_replaced() {
        let long = "x".repeat(LONGEST + 1);
        for sent in ["", "a b", "{\"a\":1}", "<script>", long.as_str()] {
            assert_ne!(id_for(Some(sent.as_bytes())), sent);
        }
        assert!(id_for(Some(b"\xff\xfe")).is_ascii());
    }

    #[test]
    fn created_ids_differ() {
        let ids: std::collections::HashSet<_> = (0..1000).map(|_| id_for(None)).collect();
        assert_eq!(ids.len(), 1000);
    }
}
