//! Lists of neighbours.

/// For each target the indices of its neighbours among the sources.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NeighbourList {
    offsets: Vec<u32>,
    indices: Vec<u32>,
}

impl NeighbourList {
    /// A list of `targets` targets without neighbours.
    pub fn empty(targets: usize) -> Self {
        Self { offsets: vec![0; targets + 1], indices: Vec::new() }
    }

    /// Neighbours of target `i`.
    #[inline]
    pub fn of(&self, i: usize) -> &[u32] {
        &self.indices[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// Number of targets.
    pub fn targets(&self) -> usize {
        self.offsets.len().saturating_sub(1)
    }

    /// Number of pairs.
    pub fn pairs(&self) -> usize {
        self.indices.len()
    }

    /// The list of the targets of all tasks, each given by counts and indices of neighbours.
    pub(super) fn from_rows(rows: &[(Vec<u32>, Vec<u32>)]) -> Self {
        let pairs = rows.iter().map(|(_, indices)| indices.len()).sum();
        let mut list = Self { offsets: vec![0], indices: Vec::with_capacity(pairs) };
        let mut end = 0;
        for (counts, indices) in rows {
            for count in counts {
                end += count;
                list.offsets.push(end);
            }
            list.indices.extend_from_slice(indices);
        }
        list
    }
}
