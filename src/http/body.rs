//! The JSON body of a request.

use super::problem::Problem;
use super::reading::{Faulted, Faults, Object, Place};
use axum::body::Bytes;
use axum::extract::{FromRequest, Request};
use axum::http::{HeaderMap, StatusCode, header};
use serde_json::value::RawValue;

/// A body that says it is JSON, not yet read. The framework's own extractor answers plain text and stops at the first fault.
pub(crate) struct JsonBody(Bytes);

impl<S: Send + Sync> FromRequest<S> for JsonBody {
    type Rejection = Problem;

    async fn from_request(request: Request, state: &S) -> Result<Self, Problem> {
        if !is_json(request.headers()) {
            return Err(Problem::new(
                StatusCode::UNSUPPORTED_MEDIA_TYPE,
                "unsupported-media-type",
                "The media type is not supported",
                "send JSON with the header content-type: application/json",
            ));
        }
        match Bytes::from_request(request, state).await {
            Ok(bytes) => Ok(Self(bytes)),
            Err(rejection) if rejection.status() == StatusCode::PAYLOAD_TOO_LARGE => Err(Problem::of_status(StatusCode::PAYLOAD_TOO_LARGE)),
            Err(rejection) => Err(Problem::new(StatusCode::BAD_REQUEST, "unreadable-body", "The body could not be read", rejection.body_text())),
        }
    }
}

impl JsonBody {
    /// Reads the body, an object, with `read`, which records the faults that it finds and gives the result if there is one.
    ///
    /// `read` can give a result and record faults; then the faults prevail.
    pub(crate) fn read<T>(&self, read: impl FnOnce(&mut Object<'_, '_>, &mut Faults) -> Result<T, Problem>) -> Result<T, Problem> {
        let raw: &RawValue = serde_json::from_slice(&self.0).map_err(|error| {
            Problem::new(StatusCode::BAD_REQUEST, "malformed-json", "The body is not JSON", format!("the body is not JSON: {error}"))
        })?;
        let mut faults = Faults::default();
        let mut object = Object::open(raw, Place::Root, &mut faults);
        todo_read(read)
    }
}
