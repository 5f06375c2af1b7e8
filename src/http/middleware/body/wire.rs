//! A body as it comes over the wire: counted, and ended with an error where it stalls or trickles. Only the time spent waiting for
//! the client counts, not the time that the server takes over what came.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::body::{Body, Bytes, HttpBody};
use http_body::{Frame, SizeHint};
use tokio::time::{Instant, Sleep, sleep};

use super::fault::BodyFault;
use super::progress::BodyProgress;

/// How slowly a body may come.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Pace {
    /// How long nothing may come.
    pub(super) longest_stall: Duration,
    /// The slowest average, once the waits together are longer than `longest_stall`.
    pub(super) min_bytes_s: u64,
}

/// A body whose arrival is recorded and paced.
pub(in super::super) struct WireBody {
    body: Body,
    pace: Pace,
    progress: Arc<BodyProgress>,
    waited: Duration,
    wait: Option<Wait>,
}

/// The wait for the next bytes. A body that is there in one piece, as those of single calculations are, never makes one.
struct Wait {
    since: Instant,
    end: Pin<Box<Sleep>>,
}

impl WireBody {
    pub(in super::super) fn new(body: Body, pace: Pace, progress: Arc<BodyProgress>) -> Self {
        Self { body, pace, progress, waited: Duration::ZERO, wait: None }
    }

    /// Records that `bytes` came, and checks the average since the body's beginning.
    fn note_bytes(&mut self, bytes: u64) -> Result<(), BodyFault> {
        let all = self.progress.add_wire_bytes(bytes);
        if let Some(wait) = self.wait.take() {
            self.waited += wait.since.elapsed();
        }
        let min_bytes_s = self.pace.min_bytes_s;
        // 2^53 bytes are 8 PiB.
        #[expect(clippy::cast_precision_loss, reason = "rates need no more than a double's digits")]
        let is_too_slow = (all as f64) < min_bytes_s as f64 * self.waited.as_secs_f64();
        if self.waited > self.pace.longest_stall && is_too_slow {
            return Err(self.progress.note_fault(BodyFault::TooSlow { min_bytes_s }));
        }
        Ok(())
    }

    fn poll_wait(&mut self, context: &mut Context<'_>) -> Poll<BodyFault> {
        let longest = self.pace.longest_stall;
        let wait = self.wait.get_or_insert_with(|| Wait { since: Instant::now(), end: Box::pin(sleep(longest)) });
        wait.end.as_mut().poll(context).map(|()| self.progress.note_fault(BodyFault::Stalled { longest }))
    }
}

impl HttpBody for WireBody {
    type Data = Bytes;
    type Error = axum::BoxError;

    fn poll_frame(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::BoxError>>> {
        match Pin::new(&mut self.body).poll_frame(context) {
            Poll::Ready(Some(Ok(frame))) => {
                let paced = self.note_bytes(frame.data_ref().map_or(0, |data| data.len() as u64));
                if self.body.is_end_stream() {
                    self.progress.note_end();
                }
                Poll::Ready(Some(paced.map(|()| frame).map_err(Into::into)))
            }
            Poll::Ready(Some(Err(error))) => Poll::Ready(Some(Err(error.into()))),
            Poll::Ready(None) => {
                self.progress.note_end();
                Poll::Ready(None)
            }
            Poll::Pending => self.poll_wait(context).map(|fault| Some(Err(fault.into()))),
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

    const PACE: Pace = Pace { longest_stall: Duration::from_secs(15), min_bytes_s: 100 };

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
        let progress = Arc::new(BodyProgress::begin(true));
        let outcome = WireBody::new(Body::new(body), PACE, Arc::clone(&progress)).collect().await;
        assert_eq!(outcome.is_err(), progress.fault().is_some());
        progress.fault().cloned()
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
        assert_eq!(receive(1000, 1, Duration::from_secs(1)).await, Some(BodyFault::TooSlow { min_bytes_s: 100 }));
    }

    #[tokio::test(start_paused = true)]
    async fn a_slow_start_is_forgiven() {
        // 14 s at one byte a second are within the longest stall.
        assert_eq!(receive(14, 1, Duration::from_secs(1)).await, None);
    }
}
