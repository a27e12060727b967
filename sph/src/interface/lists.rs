//! Cross lists: the pairs within support, seen from either side.

use crate::domain::Domain;
use crate::exchange::InterfaceStates;
use crate::neighbours::CellGrid;

/// A neighbour across the interface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CrossPair {
    /// Index of the other side's state.
    pub other: u32,
    /// Index of the face of the solid's state that the pair acts through.
    pub face: u32,
}

/// Rows of pairs that keep their allocations.
#[derive(Debug, Default)]
pub struct Rows {
    offsets: Vec<u32>,
    pairs: Vec<CrossPair>,
    cursors: Vec<u32>,
}

impl Rows {
    /// Pairs of state `i`, indices ascending.
    pub fn of(&self, i: usize) -> &[CrossPair] {
        &self.pairs[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// The same, to set their faces.
    pub fn of_mut(&mut self, i: usize) -> &mut [CrossPair] {
        &mut self.pairs[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Fills the rows of the fluid with exactly the pairs within `support` \[m\], faces not yet set.
    pub fn find(&mut self, domain: &Domain, support: f64, fluid: &InterfaceStates, solid: &InterfaceStates) {
        let grid = CellGrid::new(domain, &solid.position, support);
        let list = grid.list(domain, &fluid.position, &solid.position, support, false);
        self.offsets.clear();
        self.pairs.clear();
        self.offsets.push(0);
        for f in 0..fluid.len() {
            let start = self.pairs.len();
            self.pairs.extend(list.of(f).iter().map(|s| CrossPair { other: *s, face: 0 }));
            self.pairs[start..].sort_unstable_by_key(|pair| pair.other);
            self.offsets.push(self.pairs.len() as u32);
        }
    }

    /// Turns the rows of the other side into `count` rows of this: the same pairs, indices ascending.
    pub fn transpose(&mut self, other: &Rows, count: usize) {
        let Self { offsets, pairs, .. } = self;
        offsets.clear();
        offsets.resize(count + 1, 0);
        for pair in &other.pairs {
            offsets[pair.other as usize + 1] += 1;
        }
        for i in 0..count {
            offsets[i + 1] += offsets[i];
        }
        pairs.clear();
        pairs.resize(other.pairs.len(), CrossPair::default());
        // Fill backwards from the row ends, so that no second array of cursors is needed.
        for k in (0..other.len()).rev() {
            for pair in other.of(k) {
                let end = &mut offsets[pair.other as usize + 1];
                *end -= 1;
                pairs[*end as usize] = CrossPair { other: k as u32, face: pair.face };
            }
        }
        // Each end now is its row's start: shift back.
        for i in 0..count {
            offsets[i] = offsets[i + 1];
        }
        offsets[count] = other.pairs.len() as u32;
    }

    /// Takes the faces of the same pairs from the rows of the other side.
    pub fn take_faces(&mut self, other: &Rows) {
        // Indices ascend within rows, so that each row meets its partners in its own order.
        self.cursors.clear();
        self.cursors.extend_from_slice(&self.offsets);
        for k in 0..other.len() {
            for pair in other.of(k) {
                let cursor = &mut self.cursors[pair.other as usize];
                self.pairs[*cursor as usize].face = pair.face;
                *cursor += 1;
            }
        }
    }
}
