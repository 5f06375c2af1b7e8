//! A request's body before decompression. Its bytes are counted, small frames are joined, and the body ends with an
//! error if it stalls or is too slow. Only the time spent waiting for the client counts, not the time in which the
//! server processes the data.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::body::{Body, Bytes, HttpBody};
use bytes::BytesMut;
use http_body::{Frame, SizeHint};
use tokio::time::{Instant, Sleep, sleep_until};

use super::progress::BodyProgress;
use crate::http::codes::ServiceProblem;
use crate::http::problem::Problem;

/// Smaller frames are joined: a client may send a body in chunks of one byte, each of which would pass through all
/// layers.
const SMALL_FRAME: usize = 4 * 1024;

/// Small frames are joined up to this size.
const GATHERED_FRAME: usize = 16 * 1024;

/// A body may have this many frames of any size, and one further frame for each `MIN_AVERAGE_FRAME` bytes: each frame
/// takes processor time.
const FREE_FRAMES: u64 = 1 << 16;
const MIN_AVERAGE_FRAME: u64 = 64;

/// The limits of a slow body.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Pace {
    /// The longest pause.
    pub(super) longest_stall: Duration,
    /// The lowest average rate since the body's first byte.
    pub(super) min_bytes_s: u64,
}

impl Pace {
    /// How late a body may be compared with the lowest average rate, because lost packets are sent again.
    const TOLERANCE: Duration = Duration::from_secs(2);

    /// Whether the average rate of `bytes` received in the time `waited` is too low.
    #[expect(clippy::cast_precision_loss, reason = "rates need no more than a double's digits, and 2^53 bytes are 8 PiB")]
    fn is_too_slow(&self, bytes: u64, waited: Duration) -> bool {
        (bytes as f64) < self.min_bytes_s as f64 * waited.saturating_sub(Self::TOLERANCE).as_secs_f64()
    }

    fn too_slow(&self) -> Problem {
        Problem::new(ServiceProblem::Timeout, format!("the body arrived at less than {} bytes a second", self.min_bytes_s))
    }

    fn stalled(&self) -> Problem {
        Problem::new(ServiceProblem::Timeout, format!("no data of the body arrived for {} s", self.longest_stall.as_secs()))
    }
}

fn fragmented() -> Problem {
    Problem::new(ServiceProblem::UnreadableBody, "the body arrived in too many chunks of a few bytes")
}

/// A body whose progress is recorded and whose rate is checked.
pub(in super::super) struct WireBody {
    body: Body,
    pace: Pace,
    progress: Arc<BodyProgress>,
    frames: u64,
    gathered: BytesMut,
    /// The frame that follows the joined ones.
    next: Option<Frame<Bytes>>,
    has_ended: bool,
    /// The time spent waiting since the first byte.
    waited: Duration,
    waiting_since: Option<Instant>,
    /// Wakes the task when the longest pause has passed or earlier.
    alarm: Option<Pin<Box<Sleep>>>,
}

impl WireBody {
    pub(in super::super) fn new(body: Body, pace: Pace, progress: Arc<BodyProgress>) -> Self {
        Self {
            body,
            pace,
            progress,
            frames: 0,
            gathered: BytesMut::new(),
            next: None,
            has_ended: false,
            waited: Duration::ZERO,
            waiting_since: None,
            alarm: None,
        }
    }

    /// Records a frame of `bytes`, and checks the average rate since the first frame.
    fn note_frame(&mut self, bytes: u64) -> Result<(), Problem> {
        let is_first = self.frames == 0;
        self.frames += 1;
        let all = self.progress.add_wire_bytes(bytes);
        if let Some(since) = self.waiting_since.take()
            && !is_first
        {
            self.waited += since.elapsed();
        }
        if self.pace.is_too_slow(all, self.waited) {
            return Err(self.progress.note_fault(self.pace.too_slow()));
        }
        if self.frames > FREE_FRAMES + all / MIN_AVERAGE_FRAME {
            return Err(self.progress.note_fault(fragmented()));
        }
        Ok(())
    }

    /// Ready when the longest pause has passed.
    fn poll_stall(&mut self, context: &mut Context<'_>) -> Poll<Problem> {
        let longest = self.pace.longest_stall;
        let deadline = *self.waiting_since.get_or_insert_with(Instant::now) + longest;
        loop {
            // An early wake-up costs less than resetting the timer for each frame.
            let alarm = self.alarm.get_or_insert_with(|| Box::pin(sleep_until(deadline)));
            if alarm.is_elapsed() {
                alarm.as_mut().reset(deadline);
            }
            ready!(alarm.as_mut().poll(context));
            if Instant::now() >= deadline {
                return Poll::Ready(self.progress.note_fault(self.pace.stalled()));
            }
        }
    }

    /// The joined frames.
    fn take_gathered(&mut self) -> Option<Frame<Bytes>> {
        (!self.gathered.is_empty()).then(|| Frame::data(self.gathered.split().freeze()))
    }

    /// The next frame. The connection returns one frame at a time; a small one is held until others follow.
    fn poll_gathered(&mut self, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::BoxError>>> {
        if let Some(next) = self.next.take() {
            return Poll::Ready(Some(Ok(next)));
        }
        while !self.has_ended {
            let Some(frame) = ready!(Pin::new(&mut self.body).poll_frame(context)).transpose()? else {
                self.has_ended = true;
                break;
            };
            self.note_frame(frame.data_ref().map_or(0, |data| data.len() as u64))?;
            let is_last = self.body.is_end_stream();
            match frame.data_ref() {
                Some(data) if data.len() < SMALL_FRAME && !(is_last && self.gathered.is_empty()) => {
                    self.gathered.extend_from_slice(data);
                    if self.gathered.len() >= GATHERED_FRAME || is_last {
                        break;
                    }
                }
                _ => {
                    let Some(gathered) = self.take_gathered() else { return Poll::Ready(Some(Ok(frame))) };
                    self.next = Some(frame);
                    return Poll::Ready(Some(Ok(gathered)));
                }
            }
        }
        Poll::Ready(self.take_gathered().map(Ok))
    }
}

impl HttpBody for WireBody {
    type Data = Bytes;
    type Error = axum::BoxError;

    fn poll_frame(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::BoxError>>> {
        let polled = self.poll_gathered(context);
        if self.is_end_stream() {
            self.progress.note_end();
        }
        match polled {
            Poll::Ready(_) => polled,
            Poll::Pending => self.poll_stall(context).map(|fault| Some(Err(fault.into()))),
        }
    }

    fn is_end_stream(&self) -> bool {
        self.next.is_none() && self.gathered.is_empty() && (self.has_ended || self.body.is_end_stream())
    }

    fn size_hint(&self) -> SizeHint {
        if self.next.is_none() && self.gathered.is_empty() { self.body.size_hint() } else { SizeHint::default() }
    }
}

#[cfg(test)]
mod tests {
    use http_body_util::BodyExt;
    use http_body_util::channel::Channel;

    use super::*;
    use crate::memory_budget::MemoryBudget;

    const PACE: Pace = Pace { longest_stall: Duration::from_secs(15), min_bytes_s: 100 };

    /// The fault, if any, of a body of `pieces` chunks of `bytes` bytes, each sent after `pause`. The clock is tokio's
    /// paused clock.
    async fn receive(pieces: u32, bytes: usize, pause: Duration) -> Option<String> {
        let (mut sender, body) = Channel::<Bytes, axum::BoxError>::new(1);
        tokio::spawn(async move {
            for _ in 0..pieces {
                tokio::time::sleep(pause).await;
                if sender.send_data(vec![b'x'; bytes].into()).await.is_err() {
                    return;
                }
            }
        });
        let progress = Arc::new(BodyProgress::begin(true, MemoryBudget::new(1)));
        let outcome = WireBody::new(Body::new(body), PACE, Arc::clone(&progress)).collect().await;
        assert_eq!(outcome.is_err(), progress.fault().is_some());
        progress.fault().map(Problem::to_string)
    }

    #[tokio::test(start_paused = true)]
    async fn a_steady_body_arrives_however_long_it_takes() {
        assert_eq!(receive(1000, 200, Duration::from_secs(1)).await, None);
    }

    #[tokio::test(start_paused = true)]
    async fn a_stalled_body_ends() {
        assert_eq!(receive(2, 1_000_000, Duration::from_secs(16)).await, Some(PACE.stalled().to_string()));
    }

    #[tokio::test(start_paused = true)]
    async fn a_trickling_body_ends() {
        assert_eq!(receive(1000, 1, Duration::from_secs(1)).await, Some(PACE.too_slow().to_string()));
    }

    #[tokio::test(start_paused = true)]
    async fn the_average_counts_from_the_first_byte() {
        // No pause is too long, but 14 bytes arrive in 13 s, although 100 bytes a second are required and 2 s
        // tolerated.
        assert_eq!(receive(14, 1, Duration::from_secs(1)).await, Some(PACE.too_slow().to_string()));
        assert_eq!(receive(3, 1, Duration::from_millis(900)).await, None);
        // The time until the first byte counts only as a pause.
        assert_eq!(receive(1, 1, Duration::from_secs(14)).await, None);
    }

    /// The sizes of the frames passed on when frames of `sizes` are received, and the fault.
    async fn passed_on(sizes: Vec<usize>) -> (Vec<usize>, Option<String>) {
        let expected: Vec<u8> = (0_u8..251).cycle().take(sizes.iter().sum()).collect();
        let mut left = &expected[..];
        // All frames are available at once.
        let (mut sender, body) = Channel::<Bytes, axum::BoxError>::new(sizes.len());
        for size in sizes {
            sender.send_data(Bytes::copy_from_slice(left.split_off(..size).unwrap())).await.unwrap();
        }
        drop(sender);
        let progress = Arc::new(BodyProgress::begin(true, MemoryBudget::new(1)));
        let mut body = WireBody::new(Body::new(body), PACE, Arc::clone(&progress));
        let (mut all, mut lengths) = (Vec::new(), Vec::new());
        while let Some(Ok(frame)) = body.frame().await {
            let data = frame.into_data().unwrap();
            lengths.push(data.len());
            all.extend(data);
        }
        assert!(expected.starts_with(&all));
        assert_eq!(progress.fault().is_some(), progress.is_unread());
        (lengths, progress.fault().map(Problem::to_string))
    }

    #[tokio::test]
    async fn small_frames_are_joined_and_large_ones_passed_on_in_order() {
        let mut sizes = vec![1; 40_000];
        sizes.extend([10_000, 1, 2, 5000, 3]);
        assert_eq!(passed_on(sizes).await, (vec![16_384, 16_384, 7232, 10_000, 3, 5000, 3], None));
    }

    #[tokio::test]
    async fn a_body_in_very_many_tiny_frames_ends() {
        assert_eq!(passed_on(vec![1; 70_000]).await.1, Some(fragmented().to_string()));
        assert_eq!(passed_on(vec![64; 70_000]).await.1, None);
    }
}
