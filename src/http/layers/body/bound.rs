//! A body that ends with an error at its limit.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};

use axum::body::{Body, Bytes, HttpBody};
use http_body::{Frame, SizeHint};

use super::fault::BodyFault;
use super::reception::Reception;

/// A decompressed body of at most so many bytes.
pub(super) struct Bound {
    body: Body,
    largest: u64,
    left: u64,
    reception: Arc<Reception>,
}

impl Bound {
    pub(super) fn new(body: Body, largest: u64, reception: Arc<Reception>) -> Self {
        Self { body, largest, left: largest, reception }
    }
}

impl HttpBody for Bound {
    type Data = Bytes;
    type Error = BodyFault;

    fn poll_frame(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, BodyFault>>> {
        let frame = match ready!(Pin::new(&mut self.body).poll_frame(context)) {
            None => return Poll::Ready(None),
            Some(Ok(frame)) => frame,
            Some(Err(error)) => return Poll::Ready(Some(Err(self.reception.note_fault(BodyFault::Unreadable(error.to_string()))))),
        };
        let length = frame.data_ref().map_or(0, |data| data.len() as u64);
        let Some(left) = self.left.checked_sub(length) else {
            return Poll::Ready(Some(Err(self.reception.note_fault(BodyFault::TooLarge { largest: self.largest }))));
        };
        self.left = left;
        Poll::Ready(Some(Ok(frame)))
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

    async fn read(bytes: usize, largest: u64) -> (Result<usize, String>, Option<BodyFault>) {
        let reception = Arc::new(Reception::begin());
        let bound = Bound::new(Body::from(vec![b'x'; bytes]), largest, Arc::clone(&reception));
        let read = bound.collect().await.map(|whole| whole.to_bytes().len()).map_err(|fault| fault.to_string());
        (read, reception.fault().cloned())
    }

    #[tokio::test]
    async fn the_limit_itself_is_accepted_and_one_byte_more_is_not() {
        assert_eq!(read(100, 100).await, (Ok(100), None));
        let (read, fault) = read(101, 100).await;
        assert!(read.is_err());
        assert_eq!(fault, Some(BodyFault::TooLarge { largest: 100 }));
    }
}
