//! Cross lists: the pairs within support, seen from either side.

use super::states::InterfaceStates;
use crate::neighbours::CellGrid;
use crate::space::Space;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::tasks::{PerTask, for_each_task};

/// States per task.
pub const TASK: usize = 64;

/// A neighbour across the interface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CrossPair {
    /// Index of the other side's state.
    pub other: u32,
    /// Index of the fluid region that the fluid particle belongs to, around the solid particle.
    pub region: u32,
}

/// Finds the pairs within support; buffers are reused.
#[derive(Debug, Default)]
pub struct Search<S: Space> {
    grid: CellGrid<S>,
    /// Positions of the states that are searched, in the order of cells \[m\].
    placed: Vec<S::Vector>,
    found: Vec<Found>,
}

/// Rows of one task.
#[derive(Debug, Default)]
struct Found {
    ends: Vec<u32>,
    pairs: Vec<CrossPair>,
}

impl<S: Space> Search<S> {
    /// Fills the rows of `centres` with exactly the pairs with `others` within `support` \[m\], without their regions; the row of
    /// a centre that is not `wanted` stays empty.
    pub fn fill(
        &mut self,
        domain: &Domain<S>,
        support: f64,
        [centres, others]: [&InterfaceStates<S>; 2],
        wanted: impl Fn(usize) -> bool + Sync,
        rows: &mut Rows,
    ) {
        let Self { grid, placed, found } = self;
        grid.renew(domain, &others.position, support);
        placed.clear();
        placed.extend(grid.order().iter().map(|s| others.position[*s as usize]));
        found.resize_with(centres.len().div_ceil(TASK), Found::default);
        let (grid, square) = (&*grid, support * support);
        for_each_task(centres.len(), TASK, PerTask(&mut found[..]), &|particles, PerTask(found)| {
            let Found { ends, pairs } = &mut found[0];
            ends.clear();
            pairs.clear();
            for i in particles {
                let start = pairs.len();
                if wanted(i) {
                    let x = domain.wrapped(&centres.position[i]);
                    for k in grid.ranges(grid.cell(&x)).iter().cloned().flatten() {
                        if domain.separation(&x, &placed[k]).norm_squared() < square {
                            pairs.push(CrossPair { other: grid.order()[k], region: 0 });
                        }
                    }
                    pairs[start..].sort_unstable_by_key(|pair| pair.other);
                }
                ends.push(pairs.len() as u32);
            }
        });
        rows.take(found);
    }
}

/// Rows of the states of one task.
#[derive(Debug)]
pub struct TaskRows<'a> {
    /// The first state.
    pub first: usize,
    offsets: &'a [u32],
    pairs: &'a mut [CrossPair],
}

impl TaskRows<'_> {
    /// Each state with its row.
    pub fn each(&mut self, mut work: impl FnMut(usize, &mut [CrossPair])) {
        let start = self.offsets[0];
        for (k, ends) in self.offsets.windows(2).enumerate() {
            let row = (ends[0] - start) as usize..(ends[1] - start) as usize;
            work(self.first + k, &mut self.pairs[row]);
        }
    }
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

    /// The same, to set their regions.
    pub fn of_mut(&mut self, i: usize) -> &mut [CrossPair] {
        &mut self.pairs[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// All rows, task by task.
    pub fn tasks(&mut self) -> Vec<TaskRows<'_>> {
        let count = self.len();
        let mut pairs = &mut self.pairs[..];
        let mut task = |first: usize| {
            let offsets = &self.offsets[first..=count.min(first + TASK)];
            let length = offsets[offsets.len() - 1] - offsets[0];
            let (own, rest) = std::mem::take(&mut pairs).split_at_mut(length as usize);
            pairs = rest;
            TaskRows { first, offsets, pairs: own }
        };
        (0..count).step_by(TASK).map(&mut task).collect()
    }

    /// Number of states.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Fills the rows with `found`, which follows task by task.
    fn take(&mut self, found: &[Found]) {
        self.offsets.clear();
        self.pairs.clear();
        self.offsets.push(0);
        for Found { ends, pairs } in found {
            let before = self.pairs.len() as u32;
            self.offsets.extend(ends.iter().map(|end| before + end));
            self.pairs.extend_from_slice(pairs);
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
                pairs[*end as usize] = CrossPair { other: k as u32, region: pair.region };
            }
        }
        // Each end now is its row's start: shift back.
        for i in 0..count {
            offsets[i] = offsets[i + 1];
        }
        offsets[count] = other.pairs.len() as u32;
    }

    /// Takes the regions of the same pairs from the rows of the other side.
    pub fn take_regions(&mut self, other: &Rows) {
        // Indices ascend within rows, so that each row meets its partners in its own order.
        self.cursors.clear();
        self.cursors.extend_from_slice(&self.offsets);
        for k in 0..other.len() {
            for pair in other.of(k) {
                let cursor = &mut self.cursors[pair.other as usize];
                self.pairs[*cursor as usize].region = pair.region;
                *cursor += 1;
            }
        }
    }
}
