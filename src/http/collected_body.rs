//! Collects a request's body into one buffer, within the memory budget.

use axum::body::{Body, Bytes};
use http_body_util::BodyExt;

use super::codes::ServiceProblem;
use super::problem::Problem;
use crate::budget::{Budget, FREE_INPUT, Held, Job, LONGEST_WAIT};

/// The number of bytes collected before the task yields: less than a millisecond of decompression.
const TURN: usize = 64 * 1024;

/// A body with its share of the memory.
struct Collected {
    bytes: Vec<u8>,
    held: Held,
}

impl AsRef<[u8]> for Collected {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

/// Collects `body`, of `stated` bytes if the client states its length and does not compress it. The memory is taken
/// before the body is read if its length is known, otherwise as it arrives; it is returned when the last reference to
/// the bytes is dropped.
pub(super) async fn collect(mut body: Body, stated: Option<u64>, budget: &Budget) -> Result<Bytes, Problem> {
    let stated = stated.unwrap_or(0);
    let held = budget.take(Job::Body { bytes: stated }, LONGEST_WAIT).await?;
    let capacity = usize::try_from(stated.min(FREE_INPUT)).unwrap_or(0);
    let mut collected = Collected { bytes: Vec::with_capacity(capacity), held };
    let mut turn = 0;
    while let Some(data) = next_data(&mut body).await? {
        collected.held.grow_input((collected.bytes.len() + data.len()) as u64)?;
        collected.bytes.extend_from_slice(&data);
        turn += data.len();
        drop(data);
        if turn >= TURN {
            // Decompression returns data without waiting, so this yields to other tasks.
            tokio::task::yield_now().await;
            turn = 0;
        }
    }
    Ok(Bytes::from_owner(collected))
}

/// The body's next data; `None` at its end.
pub(super) async fn next_data(body: &mut Body) -> Result<Option<Bytes>, Problem> {
    while let Some(frame) = body.frame().await {
        // If a body is over its limit, too slow or damaged, the middleware replaces the answer; this problem is for
        // other errors.
        let frame = frame.map_err(|error| Problem::new(ServiceProblem::UnreadableBody, error.to_string()))?;
        if let Ok(data) = frame.into_data() {
            return Ok(Some(data));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use http_body_util::channel::Channel;

    use super::*;

    /// The result for a body of `count` pieces of `size` bytes without a stated length, and the memory held with it.
    async fn collected(count: usize, size: usize, budget: &Budget) -> (Result<usize, Problem>, u64) {
        let (mut sender, channel) = Channel::<Bytes, axum::BoxError>::new(1);
        let sending = tokio::spawn(async move {
            for _ in 0..count {
                if sender.send_data(vec![b'x'; size].into()).await.is_err() {
                    return;
                }
            }
        });
        let whole = collect(Body::new(channel), None, budget).await;
        sending.await.unwrap();
        let held = budget.held();
        (whole.map(|bytes| bytes.len()), held)
    }

    #[tokio::test]
    async fn memory_is_held_as_long_as_the_body() {
        let (length, held) = collected(500, 10_000, &Budget::new(64 << 20)).await;
        assert_eq!((length.unwrap(), held), (5_000_000, 5 << 20));
    }

    #[tokio::test]
    async fn a_body_that_does_not_fit_is_refused_and_its_memory_is_free() {
        let budget = Budget::new(16 << 20);
        let other = budget.take(Job::Body { bytes: 3 << 20 }, LONGEST_WAIT).await.unwrap();
        let (length, held) = collected(500, 10_000, &budget).await;
        assert!(length.is_err());
        assert_eq!(held, 3 << 20);
        drop(other);
        assert_eq!(budget.held(), 0);
    }
}
