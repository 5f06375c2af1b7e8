//! Welding: numbering points so that equal points have the same number.

use hashbrown::HashTable;
use std::hash::{BuildHasher, RandomState};

/// The distinct points so far, and the hash table that finds them: 24 bytes for each point and, on average, 7 bytes of
/// table.
#[derive(Debug)]
pub(super) struct Welder {
    points: Vec<[f64; 3]>,
    table: HashTable<u32>,
    keys: HashKeys,
}

/// Secret factors of a hash function. If they were known, a file could put all its points into one bucket of the table,
/// which would take quadratic time.
#[derive(Debug, Clone, Copy)]
pub(super) struct HashKeys([u64; 3]);

impl Default for Welder {
    fn default() -> Self {
        Self::new()
    }
}

impl Welder {
    pub(super) fn new() -> Self {
        Self { points: Vec::new(), table: HashTable::new(), keys: HashKeys::random() }
    }

    /// The number of a point, from 0 in the order of the first occurrence. 0 and -0 are equal; there is no NaN.
    pub(super) fn index(&mut self, point: [f64; 3]) -> u32 {
        // Adding 0 removes the sign of a zero.
        let point = point.map(|coordinate| coordinate + 0.0);
        let hash = self.keys.hash(point);
        let Self { points, table, keys } = self;
        let same = |&index: &u32| points[index as usize].map(f64::to_bits) == point.map(f64::to_bits);
        if let Some(&index) = table.find(hash, same) {
            return index;
        }
        let index = u32::try_from(points.len()).expect("the bound on facets keeps point numbers within 32 bits");
        points.push(point);
        table.insert_unique(hash, index, |&other| keys.hash(points[other as usize]));
        index
    }

    pub(super) fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    pub(super) fn into_points(self) -> Vec<[f64; 3]> {
        self.points
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }
}

impl HashKeys {
    pub(super) fn random() -> Self {
        let random = RandomState::new();
        Self([0_u8, 1, 2].map(|n| random.hash_one(n) | 1))
    }

    /// Each number multiplied by a secret factor, with the high and low half of the product combined by XOR, as in
    /// wyhash.
    pub(super) fn hash(self, numbers: [f64; 3]) -> u64 {
        let keys = self.0;
        let fold = |a: u64, b: u64| {
            let product = u128::from(a) * u128::from(b);
            #[expect(clippy::cast_possible_truncation, reason = "the two halves")]
            let (low, high) = (product as u64, (product >> 64) as u64);
            low ^ high
        };
        let [x, y, z] = numbers.map(f64::to_bits);
        fold(fold(fold(x ^ keys[0], keys[1]) ^ y, keys[2]) ^ z ^ keys[0], keys[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_points_have_one_number_and_others_have_their_own() {
        let mut welder = Welder::new();
        let numbers: Vec<u32> = (0..10_000_u32)
            .map(|i| [f64::from(i % 100), f64::from(i / 100 % 10), -0.0])
            .chain([[0.0; 3], [0.0, 0.0, 1e-300]])
            .map(|point| welder.index(point))
            .collect();
        assert_eq!(numbers[..3], [0, 1, 2]);
        assert!((0..10_000).all(|i| numbers[i] as usize == i % 1000));
        assert_eq!(numbers[10_000..], [0, 1000]);
        assert_eq!(welder.into_points().len(), 1001);
    }
}
