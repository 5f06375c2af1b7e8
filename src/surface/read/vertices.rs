//! The vertices of an OBJ or PLY file, which are stored because faces refer to them by number. They are in blocks of a
//! fixed size: a growing vector would copy all of them to twice the memory each time that it is full.

/// Vertices in a block: 96 KiB.
const BLOCK: usize = 4096;

/// Vertices in the order of the file.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    blocks: Vec<Vec<[f64; 3]>>,
}

impl Vertices {
    pub(super) fn push(&mut self, vertex: [f64; 3]) {
        match self.blocks.last_mut() {
            Some(last) if last.len() < BLOCK => last.push(vertex),
            _ => {
                let mut block = Vec::with_capacity(BLOCK);
                block.push(vertex);
                self.blocks.push(block);
            }
        }
    }

    pub(super) fn get(&self, index: usize) -> Option<&[f64; 3]> {
        self.blocks.get(index / BLOCK)?.get(index % BLOCK)
    }

    pub(super) fn len(&self) -> usize {
        self.blocks.last().map_or(0, |last| (self.blocks.len() - 1) * BLOCK + last.len())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &[f64; 3]> {
        self.blocks.iter().flatten()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_keep_their_numbers_across_blocks() {
        let vertex = |index: usize| [f64::from(u32::try_from(index).unwrap()), 1.0, 2.0];
        let mut vertices = Vertices::default();
        assert!(vertices.is_empty() && vertices.get(0).is_none());
        for index in 0..=2 * BLOCK {
            assert_eq!(vertices.len(), index);
            vertices.push(vertex(index));
        }
        assert!((0..vertices.len()).all(|index| vertices.get(index) == Some(&vertex(index))));
        assert_eq!(vertices.get(vertices.len()), None);
        assert!(vertices.iter().copied().eq((0..vertices.len()).map(vertex)));
    }
}
