//! The memory of a recommendation, which is reserved from the budget before the calculation.

use crate::http::wire::ReceivedSurface;
use crate::http::worker_pool::Work;
use crate::memory_budget::Reservation;
use crate::planning::memory::{Parallelism, bytes_of_mesh, bytes_to_prepare, fitting};
use crate::surface::MeshBuilder;
use crate::surface::mesh::MeshSize;

/// The resources that a recommendation holds.
#[derive(Debug)]
pub(super) struct Means {
    pub(super) memory: Reservation,
    pub(super) parallelism: Parallelism,
}

/// The resources that a recommendation needs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Needs {
    pub(super) bytes: u64,
    pub(super) parallelism: Parallelism,
}

impl Needs {
    /// The needs of a plan on a mesh of this size, with as many threads and candidates at once as one request may use.
    pub(super) fn of_plan(size: MeshSize, candidates: usize, work: &Work) -> Self {
        let mesh = bytes_of_mesh(size);
        let largest = usize::try_from(work.budget().largest()).unwrap_or(usize::MAX);
        let (parallelism, bytes) = fitting(size.facets, candidates, work.threads(), largest.saturating_sub(mesh));
        Self { bytes: (mesh + bytes) as u64, parallelism }
    }

    /// The needs of all that follows the reading of a surface, for any selection and up to `candidates` candidates.
    pub(super) fn after_reading(mesh: &MeshBuilder, candidates: usize, work: &Work) -> Self {
        let plan = Self::of_plan(mesh.size(), candidates, work);
        Self { bytes: plan.bytes.max(bytes_of_workpiece(mesh)), ..plan }
    }
}

/// The memory in bytes to prepare the facets of the plan, beside the memory of the surface itself.
pub(super) fn bytes_of_workpiece(mesh: &MeshBuilder) -> u64 {
    let size = mesh.size();
    (bytes_of_mesh(size) + mesh.bytes_to_finish().max(bytes_to_prepare(size))) as u64
}

/// The memory of the facets of a JSON surface, in bytes for each byte of the body, while their vectors grow to twice
/// their size. A point takes at least 8 bytes, `[0,0,0],`, and a point of a grid makes two facets: 72 bytes, 15 of the
/// vertex table, and 36 for each facet.
const BYTES_OF_A_BYTE: usize = 20;

/// The points and triangles of a JSON mesh, which are held until all are read: 24 bytes for each 8 of the body.
const BYTES_OF_A_BYTE_OF_A_MESH: usize = 3;

/// The facets of a sampled patch: one million, before they are merged.
const BYTES_OF_A_PATCH: usize = 48 << 20;

/// The memory in bytes to read the surface of a JSON body, beside the body itself.
pub(super) fn bytes_to_read(json: &[u8]) -> u64 {
    // A member's name may be written with escapes.
    let may_be_patch = memchr::memchr(b'\\', json).is_some() || memchr::memmem::find(json, b"bezier").is_some();
    let facets = (BYTES_OF_A_BYTE * json.len()).min(bytes_of_most_facets()).max(if may_be_patch { BYTES_OF_A_PATCH } else { 0 });
    (BYTES_OF_A_BYTE_OF_A_MESH * json.len() + facets) as u64
}

/// The most memory in bytes of a surface's facets while they are read.
fn bytes_of_most_facets() -> usize {
    usize::try_from(ReceivedSurface::new().bytes_to_take_package()).unwrap_or(usize::MAX)
}
