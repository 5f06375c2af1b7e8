//! The memory of a recommendation, which is reserved in the budget before the calculation.

use crate::cancellation::CancelFlag;
use crate::http::worker_pool::Work;
use crate::memory_budget::{BudgetExceeded, Reservation};
use crate::planning::memory::{Parallelism, RankingSize, TRIAL_SIDE, bytes_of_mesh, bytes_to_prepare, bytes_to_rank, fitting};
use crate::planning::zigzag::PlanRoom;
use crate::surface::mesh::MeshSize;
use crate::surface::{MeshBuilder, ReceivedSurface};
use std::time::Duration;

/// The resources of a recommendation: its memory, and what it may use of threads and room for plans.
#[derive(Debug)]
pub(super) struct Resources {
    pub(super) memory: Reservation,
    pub(super) parallelism: Parallelism,
    pub(super) room: PlanRoom,
    /// The threads of a permit.
    threads: usize,
    /// The longest wait for more memory.
    longest_wait: Duration,
    /// The largest memory of one request, in bytes.
    largest: usize,
}

impl Resources {
    /// Resources with an empty reservation.
    pub(super) fn none(work: &Work, longest_wait: Duration) -> Self {
        Self {
            memory: work.budget().open(),
            parallelism: Parallelism { threads: work.threads(), candidates: work.threads() },
            room: PlanRoom::USUAL,
            threads: work.threads(),
            longest_wait,
            largest: usize::try_from(work.budget().largest()).unwrap_or(usize::MAX),
        }
    }

    /// The same resources with another reservation.
    pub(super) fn with(self, memory: Reservation) -> Self {
        Self { memory, ..self }
    }

    /// The memory in bytes of a ranking on a mesh of this size, and its use of threads: as many threads and candidates
    /// at once as `most` bytes allow; one of each if none fits.
    fn within(&self, mesh: MeshSize, size: RankingSize, most: usize) -> (u64, Parallelism) {
        let mesh = bytes_of_mesh(mesh);
        let (parallelism, bytes) = fitting(size, self.threads, self.room, most.saturating_sub(mesh));
        ((mesh + bytes) as u64, parallelism)
    }

    /// The largest memory in bytes of a ranking on a mesh of this size, limited by the memory of one request.
    pub(super) fn most(&self, mesh: MeshSize, size: RankingSize) -> u64 {
        self.within(mesh, size, self.largest).0
    }

    /// The smallest memory in bytes with which a ranking on a mesh of this size is possible.
    pub(super) fn least(&self, mesh: MeshSize, size: RankingSize) -> u64 {
        self.within(mesh, size, 0).0
    }

    /// Reserves the memory for a ranking: at least the smallest amount, and as much of the free memory as it can use.
    /// Blocks, so it must be called on a worker thread.
    pub(super) fn provide(&mut self, mesh: MeshSize, size: RankingSize, stop: &dyn Fn() -> bool) -> Result<(), BudgetExceeded> {
        let attainable = usize::try_from(self.memory.attainable()).unwrap_or(usize::MAX);
        let (bytes, parallelism) = self.within(mesh, size, self.largest.min(attainable));
        self.memory.shrink_to(bytes);
        self.add(bytes - self.memory.bytes(), stop)?;
        self.parallelism = parallelism;
        Ok(())
    }

    /// Returns the memory of the ranking, except that of one plan, from which passes and map are computed.
    pub(super) fn keep_one_plan(&mut self, mesh: MeshSize, size: RankingSize) {
        let parallelism = Parallelism { candidates: 1, ..self.parallelism };
        let plan = bytes_to_rank(RankingSize { candidates: 1, ..size }, parallelism, PlanRoom::LARGEST);
        self.memory.shrink_to((bytes_of_mesh(mesh) + plan) as u64);
    }

    /// Reserves `bytes` more. Blocks, so it must be called on a worker thread.
    pub(super) fn add(&mut self, bytes: u64, stop: &dyn Fn() -> bool) -> Result<(), BudgetExceeded> {
        self.memory.grow_blocking(bytes, self.longest_wait, stop)
    }

    /// Reserves the memory for larger plans, after one did not fit. Blocks, so it must be called on a worker thread.
    pub(super) fn enlarge(&mut self, mesh: MeshSize, size: RankingSize, stop: &dyn Fn() -> bool) -> Result<(), BudgetExceeded> {
        self.room = self.room.larger();
        self.provide(mesh, size, stop)
    }
}

/// The memory in bytes to prepare the facets of the plan, in addition to the memory of the surface itself.
pub(super) fn bytes_of_machined_surface(mesh: &MeshBuilder) -> u64 {
    let size = mesh.size();
    (bytes_of_mesh(size) + mesh.bytes_to_finish().max(bytes_to_prepare(size))) as u64
}

/// The memory of a map: the figures of each cell and their text, in a vector that doubles when it grows.
pub(super) const BYTES_OF_A_MAP: u64 = 256 * (TRIAL_SIDE * TRIAL_SIDE) as u64;

/// The memory of the facets of a JSON surface, in bytes for each byte of the body, while their vectors double in size.
/// A point has at least 8 bytes in the body, `[0,0,0],`. It takes 72 bytes and 15 of the vertex table, and in a grid
/// two facets of 36 bytes each.
const BYTES_OF_A_BYTE: usize = 20;

/// The points and triangles of a JSON mesh, which are stored until all are read: 24 bytes for each 8 of the body.
const BYTES_OF_A_BYTE_OF_A_MESH: usize = 3;

/// The points that are read from blocks of a body at the same time, and the parts of the surface made from them: 72
/// bytes for each 8 bytes, of at most a million bytes.
const BYTES_OF_A_BYTE_OF_BLOCKS: usize = 9;
const MOST_BYTES_OF_BLOCKS: usize = 1 << 20;

/// The facets of a sampled patch: one million, before they are merged.
const BYTES_OF_A_PATCH: usize = 48 << 20;

/// The bytes for each facet of a patch: the facet, half of a point and of its entry in the table, in vectors that
/// double when they grow, and the samples.
const BYTES_OF_A_SAMPLED_FACET: usize = 120;

/// The most samples along a parameter of a patch.
const MOST_SAMPLES: usize = 1000;

/// The memory in bytes to read the surface of a JSON body, in addition to the body itself.
pub(super) fn bytes_to_read(json: &[u8]) -> u64 {
    let facets = (BYTES_OF_A_BYTE * json.len()).min(bytes_of_most_facets()).max(bytes_of_patch(json));
    let blocks = BYTES_OF_A_BYTE_OF_BLOCKS * json.len().min(MOST_BYTES_OF_BLOCKS);
    (BYTES_OF_A_BYTE_OF_A_MESH * json.len() + facets + blocks) as u64
}

/// The memory of the facets of a sampled patch, if the JSON may contain one: two facets for each square of the largest
/// number after the name `samples`.
fn bytes_of_patch(json: &[u8]) -> usize {
    // The name of a member may be written with escapes.
    if memchr::memchr(b'\\', json).is_some() {
        return BYTES_OF_A_PATCH;
    }
    let number_after = |place: usize| {
        let text = json[place..].trim_ascii_start();
        let text = text.strip_prefix(b":").unwrap_or(text).trim_ascii_start();
        let digits = text.iter().take(5).take_while(|byte| byte.is_ascii_digit()).count();
        let number = text[..digits].iter().fold(0_usize, |number, digit| 10 * number + usize::from(digit - b'0'));
        // Numbers in another form, such as 1e3, count as the largest.
        let is_plain = digits > 0 && !matches!(text.get(digits), Some(b'.' | b'e' | b'E'));
        if is_plain { number.min(MOST_SAMPLES) } else { MOST_SAMPLES }
    };
    let name = b"\"samples\"";
    let samples = memchr::memmem::find_iter(json, name).map(|place| number_after(place + name.len())).max();
    samples.map_or(0, |samples| (2 * samples * samples * BYTES_OF_A_SAMPLED_FACET).min(BYTES_OF_A_PATCH))
}

/// The most memory in bytes of a surface's facets while they are read.
fn bytes_of_most_facets() -> usize {
    usize::try_from(ReceivedSurface::until(&CancelFlag::default()).bytes_to_take_package()).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_patch_is_counted_by_its_samples_however_they_are_written() {
        let patch = |samples: &str| bytes_to_read(format!("{{\"bezier\": [], {samples}}}").as_bytes());
        assert_eq!(patch("\"points\": 1000"), bytes_to_read(b"{\"bezier\": [], \"points\": 1000}"));
        let [few, many] = ["\"samples\": 80", "\"samples\" :\n 1000"].map(patch);
        assert!(few > 1 << 20 && few < 2 << 20, "{few}");
        assert!(many > BYTES_OF_A_PATCH as u64);
        for unclear in ["\"samples\": 8e2", "\"samples\": 800.0", "\"sample\\u0073\": 8", "\"samples\": \"8\"", "\"samples\": 10000000"] {
            assert!(patch(unclear) > BYTES_OF_A_PATCH as u64, "{unclear}");
        }
    }
}
