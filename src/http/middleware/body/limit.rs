//! The limit of a request body's size. A body over the limit ends with an error. Its bytes are reserved in the memory
//! budget while they are in memory.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};

use axum::body::{Body, Bytes, HttpBody};
use http_body::{Frame, SizeHint};

use super::progress::BodyProgress;
use crate::http::codes::ServiceProblem;
use crate::http::problem::Problem;
use crate::memory_budget::Reserved;

/// A decompressed body of at most `max_bytes`.
pub(super) struct LimitedBody {
    body: Body,
    /// The bytes so far.
    bytes: u64,
    max_bytes: u64,
    progress: Arc<BodyProgress>,
}

impl LimitedBody {
    pub(super) fn new(body: Body, max_bytes: u64, progress: Arc<BodyProgress>) -> Self {
        Self { body, bytes: 0, max_bytes, progress }
    }
}

/// The problem of a body of more than `max_bytes`.
pub(super) fn too_large(max_bytes: u64) -> Problem {
    Problem::new(ServiceProblem::TooLarge, format!("the body, counted decompressed, is larger than {max_bytes} bytes"))
}

impl HttpBody for LimitedBody {
    type Data = Bytes;
    type Error = Problem;

    fn poll_frame(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Problem>>> {
        let frame = match ready!(Pin::new(&mut self.body).poll_frame(context)) {
            None => return Poll::Ready(None),
            Some(Ok(frame)) => frame,
            Some(Err(error)) => {
                let fault = Problem::new(ServiceProblem::UnreadableBody, format!("the body could not be read: {error}"));
                return Poll::Ready(Some(Err(self.progress.note_fault(fault))));
            }
        };
        let length = frame.data_ref().map_or(0, |data| data.len() as u64);
        self.bytes += length;
        if self.bytes > self.max_bytes {
            return Poll::Ready(Some(Err(self.progress.note_fault(too_large(self.max_bytes)))));
        }
        match self.progress.budget().reserve(length) {
            Ok(reservation) => Poll::Ready(Some(Ok(frame.map_data(|bytes| Bytes::from_owner(Reserved { bytes, reservation }))))),
            Err(exceeded) => Poll::Ready(Some(Err(self.progress.note_fault(exceeded.into())))),
        }
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use http_body_util::BodyExt;

    use super::*;
    use crate::memory_budget::{BudgetExceeded, MemoryBudget};

    async fn read(bytes: usize, max_bytes: u64) -> Result<usize, String> {
        let progress = Arc::new(BodyProgress::begin(true, MemoryBudget::new(150)));
        let body = LimitedBody::new(Body::from(vec![b'x'; bytes]), max_bytes, Arc::clone(&progress));
        let read = body.collect().await.map(|whole| whole.to_bytes().len()).map_err(|fault| fault.to_string());
        assert_eq!(read.as_ref().err(), progress.fault().map(Problem::to_string).as_ref());
        read
    }

    #[tokio::test]
    async fn the_limit_itself_is_accepted_and_one_byte_more_is_not() {
        assert_eq!(read(100, 100).await, Ok(100));
        assert_eq!(read(101, 100).await, Err(too_large(100).to_string()));
    }

    #[tokio::test]
    async fn a_body_that_does_not_fit_the_budget_ends() {
        assert_eq!(read(151, 200).await, Err(BudgetExceeded::Always.to_string()));
    }

    #[tokio::test]
    async fn bytes_are_reserved_as_long_as_a_part_of_them_is_held() {
        let budget = MemoryBudget::new(150);
        let progress = Arc::new(BodyProgress::begin(true, budget.clone()));
        let mut body = LimitedBody::new(Body::from(vec![b'x'; 100]), 100, progress);
        let mut held = body.frame().await.unwrap().unwrap().into_data().unwrap();
        assert_eq!(budget.reserved(), 100);
        drop(held.split_to(99));
        assert_eq!(budget.reserved(), 100);
        drop(held);
        assert_eq!(budget.reserved(), 0);
    }
}
