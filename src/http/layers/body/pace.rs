//! A body that ends with an error where it stalls or trickles. Only the time spent waiting for the client counts, not the time that
//! the server takes over what came.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::body::{Body, Bytes, HttpBody};
use http_body::{Frame, SizeHint};
use tokio::time::{Instant, Sleep, sleep};

use super::fault::BodyFault;
use super::reception::Reception;

/// How slowly a body may come.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pace {
    /// How long nothing may come.
    pub(super) longest_stall: Duration,
    /// The slowest average, once the waits together are longer than `longest_stall`.
    pub(super) slowest_bytes_s: u64,
}

/// A body as it comes over the wire, at no less than a pace.
pub(super) struct Paced {
    body: Body,
    pace: Pace,
    reception: Arc<Reception>,
    bytes: u64,
    waited: Duration,
    wait: Option<Wait>,
}

/// The wait for the next bytes. A body that is there in one piece, as those of single calculations are, never makes one.
struct Wait {
    since: Instant,
    end: Pin<Box<Sleep>>,
}

impl Paced {
    pub(super) fn new(body: Body, pace: Pace, reception: Arc<Reception>) -> Self {
        Self { body, pace, reception, bytes: 0, waited: Duration::ZERO, wait: None }
    }

    fn came(&mut self, bytes: u64) -> Result<(), BodyFault> {
        self.reception.note_bytes();
        self.bytes += bytes;
        if let Some(wait) = self.wait.take() {
            self.waited += wait.since.elapsed();
        }
        let slowest = self.pace.slowest_bytes_s;
        // 2^53 bytes are 8 PiB.
        #[expect(clippy::cast_precision_loss, reason = "rates need no more than a double's digits")]
        let too_slow = (self.bytes as f64) < slowest as f64 * self.waited.as_secs_f64();
        if self.waited > self.pace.longest_stall && too_slow {
            return Err(self.reception.note_fault(BodyFault::TooSlow { slowest_bytes_s: slowest }));
        }
        Ok(())
    }
}

impl HttpBody for Paced {
    type Data = Bytes;
    type Error = axum::BoxError;

    fn poll_frame(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::BoxError>>> {
        let paced = &mut *self;
        match Pin::new(&mut paced.body).poll_frame(context) {
            Poll::Ready(Some(Ok(frame))) => {
                let came = paced.came(frame.data_ref().map_or(0, |data| data.len() as u64));
                Poll::Ready(Some(came.map(|()| frame).map_err(Into::into)))
            }
            Poll::Ready(Some(Err(error))) => Poll::Ready(Some(Err(error.into()))),
            Poll::Ready(None) => Poll::Ready(None),
            Poll::Pending => {
                let longest = paced.pace.longest_stall;
                let wait = paced.wait.get_or_insert_with(|| Wait { since: Instant::now(), end: Box::pin(sleep(longest)) });
                match wait.end.as_mut().poll(context) {
                    Poll::Ready(()) => Poll::Ready(Some(Err(paced.reception.note_fault(BodyFault::Stalled { longest }).into()))),
                    Poll::Pending => Poll::Pending,
                }
            }
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
    use http_body_util::channel::Channel;

    use super::*;

    const PACE: Pace = Pace { longest_stall: Duration::from_secs(15), slowest_bytes_s: 100 };

    /// What becomes of a body of `pieces` of so many bytes, each sent after such a pause. The clock is tokio's paused one.
    async fn receive(pieces: u32, bytes: usize, pause: Duration) -> Option<BodyFault> {
        let (mut sender, body) = Channel::<Bytes, axum::BoxError>::new(1);
        tokio::spawn(async move {
            for _ in 0..pieces {
                tokio::time::sleep(pause).await;
                if sender.send_data(vec![b'x'; bytes].into()).await.is_err() {
                    return;
                }
            }
        });
        let reception = Arc::new(Reception::begin());
        let outcome = Paced::new(Body::new(body), PACE, Arc::clone(&reception)).collect().await;
        assert_eq!(outcome.is_err(), reception.fault().is_some());
        reception.fault().cloned()
    }

    #[tokio::test(start_paused = true)]
    async fn a_steady_body_arrives_however_long_it_takes() {
        assert_eq!(receive(1000, 200, Duration::from_secs(1)).await, None);
    }

    #[tokio::test(start_paused = true)]
    async fn a_stalled_body_ends() {
        let longest = Duration::from_secs(15);
        assert_eq!(receive(2, 1_000_000, Duration::from_secs(16)).await, Some(BodyFault::Stalled { longest }));
    }

    #[tokio::test(start_paused = true)]
    async fn a_trickling_body_ends() {
        assert_eq!(receive(1000, 1, Duration::from_secs(1)).await, Some(BodyFault::TooSlow { slowest_bytes_s: 100 }));
    }

    #[tokio::test(start_paused = true)]
    async fn a_slow_start_is_forgiven() {
        // 14 s at one byte a second are within the longest stall.
        assert_eq!(receive(14, 1, Duration::from_secs(1)).await, None);
    }
}
