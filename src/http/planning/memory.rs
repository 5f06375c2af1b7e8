//! The memory that a recommendation takes, which is reserved from the budget before it is worked out.

use crate::http::wire::ReceivedSurface;
use crate::http::worker_pool::Work;
use crate::memory_budget::Reservation;
use crate::planning::memory::{Parallelism, bytes_of_mesh, bytes_to_prepare, fitting};
use crate::surface::MeshBuilder;
use crate::surface::mesh::MeshSize;

/// What a recommendation may use.
#[derive(Debug)]
pub(super) struct Means {
    pub(super) memory: Reservation,
    pub(super) parallelism: Parallelism,
}

/// What a recommendation needs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Needs {
    pub(super) bytes: u64,
    pub(super) parallelism: Parallelism,
}

impl Needs {
    /// For a mesh of this size, with as many threads and candidates at once as fit one request.
    pub(super) fn of_plan(size: MeshSize, candidates: usize, work: &Work) -> Self {
        let mesh = bytes_of_mesh(size);
        let largest = usize::try_from(work.budget().largest()).unwrap_or(usize::MAX);
        let (parallelism, bytes) = fitting(size.facets, candidates, work.threads(), largest.saturating_sub(mesh));
        Self { bytes: (mesh + bytes) as u64, parallelism }
    }

    /// For all that follows the reading of a surface, whatever the selection and with up to `candidates` candidates.
    pub(super) fn after_reading(mesh: &MeshBuilder, candidates: usize, work: &Work) -> Self {
        let plan = Self::of_plan(mesh.size(), candidates, work);
        Self { bytes: plan.bytes.max(bytes_of_workpiece(mesh)), ..plan }
    }
}

/// The memory that it takes to make facets to plan on out of a surface, in bytes, beside what is held of the surface.
pub(super) fn bytes_of_workpiece(mesh: &MeshBuilder) -> u64 {
    let size = mesh.size();
    (bytes_of_mesh(size) + mesh.bytes_to_finish().max(bytes_to_prepare(size))) as u64
}

/// The memory that the facets of a surface in JSON take for each byte in which the body states it, while their vectors move to twice their size. A point
/// takes 8 bytes at least, `[0,0,0],`, and in a grid stands for two facets: 72 bytes and 15 of the table that finds it, and 36 for each facet.
const BYTES_OF_A_BYTE: usize = 20;

/// The points and triangles of a JSON mesh, held until all have come: 24 bytes for each 8 of the body.
const BYTES_OF_A_BYTE_OF_A_MESH: usize = 3;

/// The points that are read of a body's blocks at once, and the parts that are summed of them: 72 bytes for each 8 of a million bytes.
const BYTES_OF_A_BYTE_OF_BLOCKS: usize = 9;
const MOST_BYTES_OF_BLOCKS: usize = 1 << 20;

/// The facets of a patch as it is sampled: a million, which are merged.
const BYTES_OF_A_PATCH: usize = 48 << 20;

/// The memory that it takes to read the surface in a JSON body, in bytes, beside the body.
pub(super) fn bytes_to_read(json: &[u8]) -> u64 {
    // The name of a member may be written with escapes.
    let may_be_patch = memchr::memchr(b'\\', json).is_some() || memchr::memmem::find(json, b"bezier").is_some();
    let facets = (BYTES_OF_A_BYTE * json.len()).min(bytes_of_most_facets()).max(if may_be_patch { BYTES_OF_A_PATCH } else { 0 });
    let blocks = BYTES_OF_A_BYTE_OF_BLOCKS * json.len().min(MOST_BYTES_OF_BLOCKS);
    (BYTES_OF_A_BYTE_OF_A_MESH * json.len() + facets + blocks) as u64
}

/// The memory that the facets of a surface take at most while they are taken in, in bytes.
fn bytes_of_most_facets() -> usize {
    usize::try_from(ReceivedSurface::new().bytes_to_take_package()).unwrap_or(usize::MAX)
}
