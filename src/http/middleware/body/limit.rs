//! The limit of a request body's size, and the problems of bodies that end with an error.

use std::error::Error;
use std::sync::Arc;

use axum::body::Body;
use http_body_util::{BodyExt, LengthLimitError, Limited};
use tower_http::timeout::TimeoutError;

use super::progress::BodyProgress;
use crate::http::codes::ServiceProblem;
use crate::http::problem::Problem;

/// A decompressed body of at most `max_bytes`. Its first error is recorded.
pub(super) fn limited(body: Body, max_bytes: u64, progress: Arc<BodyProgress>) -> Body {
    let most = usize::try_from(max_bytes).unwrap_or(usize::MAX);
    Body::new(Limited::new(body, most).map_err(move |error| progress.note_fault(problem_of(&*error, max_bytes))))
}

/// The problem of a body of more than `max_bytes`.
pub(super) fn too_large(max_bytes: u64) -> Problem {
    Problem::new(ServiceProblem::TooLarge, format!("the body, counted decompressed, is larger than {max_bytes} bytes"))
}

/// The problem of a body of at most `max_bytes` that ends with `error`.
fn problem_of(error: &(dyn Error + 'static), max_bytes: u64) -> Problem {
    let is = |kind: fn(&(dyn Error + 'static)) -> bool| std::iter::successors(Some(error), |&error| error.source()).any(kind);
    if is(<dyn Error>::is::<LengthLimitError>) {
        too_large(max_bytes)
    } else if is(<dyn Error>::is::<TimeoutError>) {
        Problem::new(ServiceProblem::Timeout, "the body arrived too slowly, or no data of it for too long")
    } else {
        Problem::new(ServiceProblem::UnreadableBody, format!("the body could not be read: {error}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn read(bytes: usize, max_bytes: u64) -> Result<usize, String> {
        let progress = Arc::new(BodyProgress::begin(true));
        let body = limited(Body::from(vec![b'x'; bytes]), max_bytes, Arc::clone(&progress));
        let read = body.collect().await.map(|whole| whole.to_bytes().len()).map_err(|fault| fault.to_string());
        assert_eq!(read.as_ref().err(), progress.fault().map(Problem::to_string).as_ref());
        read
    }

    #[tokio::test]
    async fn the_limit_itself_is_accepted_and_one_byte_more_is_not() {
        assert_eq!(read(100, 100).await, Ok(100));
        assert_eq!(read(101, 100).await, Err(too_large(100).to_string()));
    }
}
