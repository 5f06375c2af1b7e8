//! Collects a request's body into one buffer, whose memory is reserved in the budget as it grows.

use axum::body::{Body, Bytes, HttpBody};
use http_body_util::BodyExt;

use super::codes::ServiceProblem;
use super::problem::Problem;
use crate::memory_budget::{BudgetExceeded, MemoryBudget, Reserved};

/// The initial capacity for a body in several pieces.
const FIRST_CAPACITY: usize = 64 * 1024;

/// The number of bytes collected before the task yields: less than a millisecond of decompression.
const TURN: usize = 64 * 1024;

/// Collects `body`. Its memory returns to the budget when the last reference to it is dropped.
pub(super) async fn collect(mut body: Body, budget: &MemoryBudget) -> Result<Bytes, Problem> {
    let Some(first) = next_data(&mut body).await? else { return Ok(Bytes::new()) };
    if body.is_end_stream() {
        return Ok(first);
    }
    let mut collected = Reserved { bytes: Vec::new(), reservation: budget.open() };
    let mut piece = Some(first);
    let mut turn = 0;
    while let Some(data) = piece {
        turn += data.len();
        append(&mut collected, &data, body.size_hint().exact())?;
        drop(data);
        if turn >= TURN {
            // Decompression returns data without waiting, so this yields to other tasks.
            tokio::task::yield_now().await;
            turn = 0;
        }
        piece = next_data(&mut body).await?;
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

/// Appends `data`; `to_come` is the number of bytes that follow, if known.
fn append(collected: &mut Reserved<Vec<u8>>, data: &[u8], to_come: Option<u64>) -> Result<(), BudgetExceeded> {
    let length = collected.bytes.len() + data.len();
    if length > collected.bytes.capacity() {
        // The stated length limits the growth, but is not reserved at once: the client may send less.
        let known = to_come.and_then(|to_come| usize::try_from(to_come).ok()).map(|to_come| length.saturating_add(to_come));
        let doubled = (2 * length).max(FIRST_CAPACITY);
        let capacity = known.map_or(doubled, |known| known.min(doubled));
        // Both buffers are reserved while the bytes move from one to the other.
        collected.reservation.grow(capacity as u64)?;
        collected.bytes.reserve_exact(capacity - collected.bytes.len());
        collected.reservation.shrink_to(capacity as u64);
    }
    collected.bytes.extend_from_slice(data);
    Ok(())
}

#[cfg(test)]
mod tests {
    use http_body_util::channel::Channel;

    use super::*;

    /// The result for a body of `count` pieces of `size` bytes without a stated length, and the memory reserved while
    /// it is held.
    async fn collected(count: usize, size: usize, budget: u64) -> (Result<usize, Problem>, u64) {
        let (mut sender, channel) = Channel::<Bytes, axum::BoxError>::new(1);
        let sending = tokio::spawn(async move {
            for _ in 0..count {
                if sender.send_data(vec![b'x'; size].into()).await.is_err() {
                    return;
                }
            }
        });
        let budget = MemoryBudget::new(budget);
        let whole = collect(Body::new(channel), &budget).await;
        sending.await.unwrap();
        let reserved = budget.reserved();
        (whole.map(|bytes| bytes.len()), reserved)
    }

    #[tokio::test]
    async fn a_body_is_reserved_as_long_as_it_is_held() {
        let (length, reserved) = collected(100, 10_000, 4_000_000).await;
        assert_eq!(length.unwrap(), 1_000_000);
        // At most twice the length of the body.
        assert!((1_000_000..=2_000_000).contains(&reserved), "{reserved}");
    }

    #[tokio::test]
    async fn a_body_that_does_not_fit_is_refused_and_its_memory_is_free() {
        let (length, reserved) = collected(100, 10_000, 500_000).await;
        assert!(length.is_err());
        assert_eq!(reserved, 0);
    }
}
