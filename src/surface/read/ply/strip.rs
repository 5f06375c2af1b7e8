//! Conversion of the triangle strips of PLY to facets.

use super::super::mesh::Mesh;
use super::Sink;

/// A strip that is being read.
#[derive(Debug, Default)]
pub(super) struct Strip {
    /// The last two vertices, or fewer at the start of a strip.
    last: [Option<usize>; 2],
    /// Whether the next triangle has the opposite orientation, as every second one has.
    is_odd: bool,
}

impl Strip {
    /// Adds a vertex by its number, and passes the triangle that it completes to the sink; `None` starts a new strip.
    /// Returns `None` if the vertex is missing.
    pub(super) fn add<S: Sink>(&mut self, vertex: Option<usize>, mesh: &mut Mesh, sink: &mut S) -> Option<()> {
        let Some(vertex) = vertex else {
            *self = Self::default();
            return Some(());
        };
        mesh.vertices().get(vertex)?;
        if let [Some(first), Some(second)] = self.last {
            let corners = if self.is_odd { [second, first, vertex] } else { [first, second, vertex] };
            mesh.add_triangle(corners, sink)?;
            self.is_odd = !self.is_odd;
        }
        self.last = [self.last[1], Some(vertex)];
        Some(())
    }
}
