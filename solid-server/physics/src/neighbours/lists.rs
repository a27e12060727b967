//! Neighbour lists with a skin, in index order.
//!
//! Rows ascend by index and sums skip pairs beyond the support, so that results do not depend on when a list was
//! built: lists are disposable and no part of the state.

use sph::neighbours::{CellGrid, NeighbourList, largest_displacement};
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::sums::ordered_sum;
use sph::tasks::largest;

use crate::space::SolidSpace;

/// Particles per task below which splitting costs more than it gains.
pub const TASK: usize = 64;

/// Skin of own-body lists in particle spacings \[-\]: large enough for a hundred steps of a turning body.
pub const OWN_SKIN: f64 = 0.3;

/// Skin of contact lists in particle spacings \[-\]: contact rows are short, rebuilding them dominates their cost.
pub const CONTACT_SKIN: f64 = 1.0;

/// Rows of ascending neighbour indices that keep their allocations.
#[derive(Debug, Default)]
pub struct Rows {
    offsets: Vec<u32>,
    indices: Vec<u32>,
}

impl Rows {
    /// `count` rows without neighbours.
    pub fn empty(count: usize) -> Self {
        Self { offsets: vec![0; count + 1], indices: Vec::new() }
    }

    /// Neighbours of `i`, ascending.
    #[inline]
    pub fn of(&self, i: usize) -> &[u32] {
        &self.indices[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }

    /// Takes over the pairs (i, j) of `list` that `keep` accepts.
    pub fn fill(&mut self, list: &NeighbourList, keep: impl Fn(usize, usize) -> bool) {
        self.offsets.clear();
        self.indices.clear();
        self.offsets.push(0);
        for i in 0..list.targets() {
            let start = self.indices.len();
            self.indices.extend(list.of(i).iter().filter(|j| keep(i, **j as usize)));
            self.indices[start..].sort_unstable();
            self.offsets.push(self.indices.len() as u32);
        }
    }

    /// The same pairs seen from the `count` sources.
    pub fn transpose_into(&self, count: usize, transposed: &mut Rows) {
        let Rows { offsets, indices } = transposed;
        offsets.clear();
        offsets.resize(count + 1, 0);
        for j in &self.indices {
            offsets[*j as usize + 1] += 1;
        }
        for j in 0..count {
            offsets[j + 1] += offsets[j];
        }
        let mut next = offsets.clone();
        indices.clear();
        indices.resize(self.indices.len(), 0);
        for i in 0..self.offsets.len() - 1 {
            for j in self.of(i) {
                let slot = &mut next[*j as usize];
                indices[*slot as usize] = i as u32;
                *slot += 1;
            }
        }
    }
}

/// Neighbours of one body's particles among themselves.
#[derive(Debug)]
pub struct OwnLists<S: SolidSpace> {
    /// Local indices of the body.
    pub rows: Rows,
    support_radius: f64,
    skin: f64,
    built_at: Vec<S::Vector>,
}

impl<S: SolidSpace> OwnLists<S> {
    /// Lists that hold all pairs within `support_radius` \[m\] while no pair approaches by more than `skin` \[m\].
    pub fn new(support_radius: f64, skin: f64) -> Self {
        Self { rows: Rows::default(), support_radius, skin, built_at: Vec::new() }
    }

    /// Rebuilds the lists if `positions` have deformed too far; returns whether it did.
    pub fn refresh(&mut self, domain: &Domain<S>, positions: &[S::Vector]) -> bool {
        if !self.stale(domain, positions) {
            return false;
        }
        let radius = self.support_radius + self.skin;
        let list = CellGrid::new(domain, positions, radius).list_among(domain, positions, radius);
        self.rows.fill(&list, |_, _| true);
        self.built_at.clear();
        self.built_at.extend_from_slice(positions);
        true
    }

    /// A body that drifts as a whole keeps its pairs: only motion relative to the mean counts.
    fn stale(&self, domain: &Domain<S>, positions: &[S::Vector]) -> bool {
        let built_at = &self.built_at;
        if built_at.len() != positions.len() {
            return true;
        }
        let total: S::Vector =
            ordered_sum(positions.len(), |i| domain.separation(&positions[i], &built_at[i]));
        let mean = total / positions.len() as f64;
        let farthest = largest(positions.len(), 2048, |i| {
            (domain.separation(&positions[i], &built_at[i]) - mean).norm_squared()
        });
        2.0 * farthest.sqrt() > self.skin
    }
}

/// Which pairs are candidates of contact.
pub struct ContactFilter<P, W> {
    /// Whether two particles are; `None` where none are.
    pub particles: Option<P>,
    /// Whether a particle and a wall particle are.
    pub walls: W,
    /// Number of supports and walls released so far: `walls` changes with it.
    pub released: usize,
}

/// Candidate pairs of contact: particles of different bodies or distant parts of one, and particles with walls.
#[derive(Debug)]
pub struct ContactLists<S: SolidSpace> {
    /// For each particle those of other bodies, and of its own with self-contact.
    pub bodies: Rows,
    /// For each particle the wall particles that act on it.
    pub walls: Rows,
    /// For each wall particle the particles on which it acts.
    pub of_walls: Rows,
    /// Ascending indices of the particles, then of the wall particles behind them, that have any pair.
    pub active: Vec<u32>,
    released: usize,
    radius: f64,
    skin: f64,
    built_at: Vec<S::Vector>,
    walls_built_at: Vec<S::Vector>,
}

impl<S: SolidSpace> ContactLists<S> {
    /// Lists that hold all pairs within `radius` \[m\] until they approach by more than `skin` \[m\].
    pub fn new(radius: f64, skin: f64, particles: usize, walls: usize) -> Self {
        Self {
            bodies: Rows::empty(particles),
            walls: Rows::empty(particles),
            of_walls: Rows::empty(walls),
            active: Vec::new(),
            released: 0,
            radius,
            skin,
            built_at: Vec::new(),
            walls_built_at: Vec::new(),
        }
    }

    /// Rebuilds the lists if `positions` or `walls` have moved too far or a release occurred; returns whether it did.
    pub fn refresh<P, W>(
        &mut self,
        domain: &Domain<S>,
        positions: &[S::Vector],
        walls: &[S::Vector],
        filter: &ContactFilter<P, W>,
    ) -> bool
    where
        P: Fn(usize, usize) -> bool,
        W: Fn(usize, usize) -> bool,
    {
        let none = filter.particles.is_none() && walls.is_empty();
        if none || self.released == filter.released && !self.stale(domain, positions, walls) {
            return false;
        }
        let radius = self.radius + self.skin;
        let grid = CellGrid::new(domain, positions, radius);
        if let Some(may_be_in_contact) = &filter.particles {
            let list = grid.list_among(domain, positions, radius);
            self.bodies.fill(&list, may_be_in_contact);
        }
        if !walls.is_empty() {
            let list = grid.list(domain, walls, positions, radius);
            self.of_walls.fill(&list, |w, i| (filter.walls)(i, w));
            self.of_walls.transpose_into(positions.len(), &mut self.walls);
        }
        let Self { bodies, walls: of_particles, of_walls, active, .. } = self;
        let particles =
            (0..positions.len()).filter(|i| !(bodies.of(*i).is_empty() && of_particles.of(*i).is_empty()));
        let walls_in_contact =
            (0..walls.len()).filter(|w| !of_walls.of(*w).is_empty()).map(|w| positions.len() + w);
        active.clear();
        // Particles and wall particles of a run stay below 2^32.
        active.extend(particles.chain(walls_in_contact).map(|k| k as u32));
        self.released = filter.released;
        self.built_at.clear();
        self.built_at.extend_from_slice(positions);
        self.walls_built_at.clear();
        self.walls_built_at.extend_from_slice(walls);
        true
    }

    fn stale(&self, domain: &Domain<S>, positions: &[S::Vector], walls: &[S::Vector]) -> bool {
        if self.built_at.len() != positions.len() {
            return true;
        }
        let moved = largest_displacement(domain, positions, &self.built_at);
        let walls_moved = largest_displacement(domain, walls, &self.walls_built_at);
        moved + moved.max(walls_moved) > self.skin
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sph::space::Vector;

    #[test]
    fn transposed_rows_hold_the_same_pairs() {
        let domain: Domain =
            Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [false; 2] };
        let at = |k: u32| Vector::new(0.1 * f64::from(k % 7), 0.13 * f64::from(k % 5));
        let a: Vec<Vector> = (0..20).map(at).collect();
        let b: Vec<Vector> = (3..12).map(|k| at(k) + Vector::new(0.05, 0.0)).collect();
        let mut rows = Rows::default();
        rows.fill(&CellGrid::new(&domain, &b, 0.2).list(&domain, &a, &b, 0.2), |_, _| true);
        let mut transposed = Rows::default();
        rows.transpose_into(b.len(), &mut transposed);
        let pairs = |rows: &Rows, n: usize| -> Vec<(u32, u32)> {
            (0..n).flat_map(|i| rows.of(i).iter().map(move |j| (i as u32, *j))).collect()
        };
        let mut swapped: Vec<_> = pairs(&transposed, b.len()).into_iter().map(|(j, i)| (i, j)).collect();
        assert!((0..b.len()).all(|j| transposed.of(j).is_sorted()));
        swapped.sort_unstable();
        let expected = pairs(&rows, a.len());
        assert!(expected.len() > 20);
        assert_eq!(swapped, expected);
    }

    #[test]
    fn drift_keeps_a_body_s_list_and_deformation_renews_it() {
        let domain: Domain =
            Domain { lower: Vector::zeros(), upper: Vector::new(9.0, 9.0), periodic: [false; 2] };
        let block: Vec<Vector> = (0..25).map(|k| Vector::new(f64::from(k % 5), f64::from(k / 5))).collect();
        let mut lists = OwnLists::new(1.3, 0.2);
        assert!(lists.refresh(&domain, &block));
        let drifted: Vec<Vector> = block.iter().map(|x| x + Vector::new(3.0, 1.0)).collect();
        assert!(!lists.refresh(&domain, &drifted));
        let stretched: Vec<Vector> = block.iter().map(|x| x * 1.06).collect();
        assert!(lists.refresh(&domain, &stretched));
    }
}
