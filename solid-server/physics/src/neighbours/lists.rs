//! Neighbour lists with a skin, in index order.
//!
//! Rows ascend by index and sums skip pairs beyond the support, so that results do not depend on when a list was
//! built: lists are disposable and no part of the state.

use sph::neighbours::{CellGrid, NeighbourList, largest_displacement, largest_distance};
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::sums::ordered_sum;
use sph::tasks::largest;

use crate::space::SolidSpace;

/// Particles per task below which splitting costs more than it gains.
pub const TASK: usize = 64;

/// Skin of own-body lists in particle spacings \[-\]: large enough for a hundred steps of a turning body.
pub const OWN_SKIN: f64 = 0.3;

/// Skin in particle spacings \[-\] of the candidates of contact: the search for them is costly.
pub const CONTACT_SKIN: f64 = 1.0;

/// Skin in particle spacings \[-\] of contact lists, which are found among the candidates. Distant parts of a body at rest are half a
/// spacing or more beyond the reach of contact, so that with this skin they are no pairs.
const NEAR_SKIN: f64 = 0.25;

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

    /// Takes over the pairs (i, j) of `rows` that `keep` accepts.
    fn take_from(&mut self, rows: &Self, keep: impl Fn(usize, usize) -> bool) {
        self.offsets.clear();
        self.indices.clear();
        self.offsets.push(0);
        for i in 0..rows.offsets.len() - 1 {
            self.indices.extend(rows.of(i).iter().filter(|j| keep(i, **j as usize)));
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

/// Pairs of particles of different bodies or of distant parts of one, and of particles with walls.
#[derive(Debug)]
pub struct PairLists {
    /// For each particle those of other bodies, and of its own with self-contact.
    pub bodies: Rows,
    /// For each particle the wall particles that act on it.
    pub walls: Rows,
    /// For each wall particle the particles on which it acts.
    pub of_walls: Rows,
    /// Ascending indices of the particles, then of the wall particles behind them, that have any pair.
    pub active: Vec<u32>,
}

impl PairLists {
    fn empty(particles: usize, walls: usize) -> Self {
        Self {
            bodies: Rows::empty(particles),
            walls: Rows::empty(particles),
            of_walls: Rows::empty(walls),
            active: Vec::new(),
        }
    }

    /// What follows from `bodies` and `of_walls`, for `particles` particles and `walls` wall particles.
    fn complete(&mut self, particles: usize, walls: usize) {
        let Self { bodies, walls: of_particles, of_walls, active } = self;
        of_walls.transpose_into(particles, of_particles);
        let of_bodies =
            (0..particles).filter(|i| !(bodies.of(*i).is_empty() && of_particles.of(*i).is_empty()));
        let walls_in_contact = (0..walls).filter(|w| !of_walls.of(*w).is_empty()).map(|w| particles + w);
        active.clear();
        // Particles and wall particles of a run stay below 2^32.
        active.extend(of_bodies.chain(walls_in_contact).map(|k| k as u32));
    }
}

/// Distances within which pairs are wanted: of two bodies, and of a body and a wall \[m\].
#[derive(Clone, Copy, Debug)]
pub struct PairRadii {
    pub bodies: f64,
    pub walls: f64,
}

impl PairRadii {
    /// The same distance \[m\] for both.
    pub fn both(radius: f64) -> Self {
        Self { bodies: radius, walls: radius }
    }

    /// The larger of each and `radius` \[m\].
    pub fn at_least(self, radius: f64) -> Self {
        Self { bodies: self.bodies.max(radius), walls: self.walls.max(radius) }
    }

    /// The larger of both \[m\].
    pub fn largest(self) -> f64 {
        self.bodies.max(self.walls)
    }
}

/// Pairs that may be in contact, found in two steps: candidates by a search, and among them those that are near.
#[derive(Debug)]
pub struct ContactLists<S: SolidSpace> {
    /// All pairs within the reach.
    pub candidates: PairLists,
    /// All pairs within the radii of contact.
    pub near: PairLists,
    reach: PairRadii,
    contact: PairRadii,
    skin: f64,
    near_skin: f64,
    /// How far a pair may approach after `found_at` until one may be missing \[m\].
    slack: f64,
    released: usize,
    built_at: Places<S>,
    found_at: Places<S>,
}

/// Wall particles, most of which stay where they are in most scenes.
#[derive(Clone, Copy, Debug)]
pub struct WallPlaces<'a, S: SolidSpace> {
    /// Positions of all \[m\].
    pub position: &'a [S::Vector],
    /// Indices of those that can move.
    pub moving: &'a [usize],
}

/// Positions of all particles, and of the wall particles that can move \[m\].
#[derive(Debug)]
struct Places<S: SolidSpace> {
    particles: Vec<S::Vector>,
    walls: Vec<S::Vector>,
}

impl<S: SolidSpace> Places<S> {
    fn new() -> Self {
        Self { particles: Vec::new(), walls: Vec::new() }
    }

    fn copy_from(&mut self, particles: &[S::Vector], walls: WallPlaces<'_, S>) {
        self.particles.clear();
        self.particles.extend_from_slice(particles);
        self.walls.clear();
        self.walls.extend(walls.moving.iter().map(|w| walls.position[*w]));
    }

    /// Most that a pair can have approached since \[m\]; infinite before the first copy.
    fn approach(&self, domain: &Domain<S>, particles: &[S::Vector], walls: WallPlaces<'_, S>) -> f64 {
        if self.particles.len() != particles.len() {
            return f64::INFINITY;
        }
        let moved = largest_displacement(domain, particles, &self.particles);
        let of_wall = |k: usize| (&walls.position[walls.moving[k]], &self.walls[k]);
        moved + moved.max(largest_distance(domain, walls.moving.len(), of_wall))
    }
}

impl<S: SolidSpace> ContactLists<S> {
    /// Lists for `particles` particles a spacing of `spacing` \[m\] apart and `walls` wall particles, of contact within
    /// `contact` and candidates within `reach`, which is no less.
    pub fn new(spacing: f64, contact: PairRadii, reach: PairRadii, particles: usize, walls: usize) -> Self {
        Self {
            candidates: PairLists::empty(particles, walls),
            near: PairLists::empty(particles, walls),
            reach,
            contact,
            skin: CONTACT_SKIN * spacing,
            near_skin: NEAR_SKIN * spacing,
            slack: 0.0,
            released: 0,
            built_at: Places::new(),
            found_at: Places::new(),
        }
    }

    /// Makes the lists hold all pairs of `positions` and `walls`; returns whether it searched for candidates again, since
    /// something has moved too far or was released.
    pub fn refresh<P, W>(
        &mut self,
        domain: &Domain<S>,
        positions: &[S::Vector],
        walls: WallPlaces<'_, S>,
        filter: &ContactFilter<P, W>,
    ) -> bool
    where
        P: Fn(usize, usize) -> bool,
        W: Fn(usize, usize) -> bool,
    {
        let none = filter.particles.is_none() && walls.position.is_empty();
        let same = self.released == filter.released;
        if none || same && self.found_at.approach(domain, positions, walls) <= self.slack {
            return false;
        }
        let mut approach = self.built_at.approach(domain, positions, walls);
        let is_stale = !same || approach > self.skin;
        if is_stale {
            self.search(domain, positions, walls, filter);
            approach = 0.0;
        }
        self.slack = self.near_skin.min(self.skin - approach);
        self.find_near(domain, positions, walls);
        is_stale
    }

    /// Searches for candidates.
    fn search<P, W>(
        &mut self,
        domain: &Domain<S>,
        positions: &[S::Vector],
        walls: WallPlaces<'_, S>,
        filter: &ContactFilter<P, W>,
    ) where
        P: Fn(usize, usize) -> bool,
        W: Fn(usize, usize) -> bool,
    {
        let Self { candidates, reach, skin, .. } = self;
        if let Some(may_be_in_contact) = &filter.particles {
            let radius = reach.bodies + *skin;
            let list = CellGrid::new(domain, positions, radius).list_among(domain, positions, radius);
            candidates.bodies.fill(&list, may_be_in_contact);
        }
        if !walls.position.is_empty() {
            let radius = reach.walls + *skin;
            let list =
                CellGrid::new(domain, positions, radius).list(domain, walls.position, positions, radius);
            candidates.of_walls.fill(&list, |w, i| (filter.walls)(i, w));
        }
        candidates.complete(positions.len(), walls.position.len());
        self.released = filter.released;
        self.built_at.copy_from(positions, walls);
    }

    /// Takes over the candidates that are near.
    fn find_near(&mut self, domain: &Domain<S>, positions: &[S::Vector], walls: WallPlaces<'_, S>) {
        let Self { candidates, near, contact, slack, found_at, .. } = self;
        let [bodies, of_walls] = [contact.bodies, contact.walls].map(|radius| (radius + *slack).powi(2));
        let square = |a: &S::Vector, b: &S::Vector| domain.separation(a, b).norm_squared();
        near.bodies.take_from(&candidates.bodies, |i, j| square(&positions[i], &positions[j]) <= bodies);
        let of_wall = |w: usize, i: usize| square(&walls.position[w], &positions[i]) <= of_walls;
        near.of_walls.take_from(&candidates.of_walls, of_wall);
        near.complete(positions.len(), walls.position.len());
        found_at.copy_from(positions, walls);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sph::space::{Plane, Vector};

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

    /// A block on wall particles, some of which move, and another that slides over it: each pair within the radius is
    /// listed at every step.
    #[test]
    fn near_pairs_are_found_among_candidates_as_blocks_pass() {
        let domain: Domain =
            Domain { lower: Vector::new(-20.0, -9.0), upper: Vector::new(20.0, 9.0), periodic: [false; 2] };
        let at = |k: u32| Vector::new(f64::from(k % 6), f64::from(k / 6));
        let start: Vec<Vector> = (0..12).map(|k| Vector::new(f64::from(k), -1.1)).collect();
        let moving: Vec<usize> = (2..7).collect();
        let (radius, reach) = (2.0, PairRadii::both(2.5));
        let mut lists =
            ContactLists::<Plane>::new(1.0, PairRadii { bodies: radius, walls: 1.5 }, reach, 36, start.len());
        let filter = ContactFilter {
            particles: Some(|i: usize, j: usize| (i < 18) != (j < 18)),
            walls: |_, _| true,
            released: 0,
        };
        let (mut searches, mut counts) = (0, Vec::new());
        for step in 0..200 {
            let slid = Vector::new(0.1 * f64::from(step) - 10.0, 3.9);
            let shaken = Vector::new(0.0, 0.1 * f64::from(step).sin());
            let positions: Vec<Vector> =
                (0..36).map(|k| if k < 18 { at(k) + shaken } else { at(k - 18) + slid }).collect();
            let mut walls = start.clone();
            moving.iter().for_each(|w| walls[*w].y -= 1.0 + (0.5 * f64::from(step)).cos());
            let places = WallPlaces { position: &walls, moving: &moving };
            searches += u32::from(lists.refresh(&domain, &positions, places, &filter));
            let apart = |a: &Vector, b: &Vector| (a - b).norm();
            let mut pairs = 0;
            for (i, x_i) in positions.iter().enumerate() {
                for (j, x_j) in positions.iter().enumerate() {
                    let listed = lists.near.bodies.of(i).contains(&(j as u32));
                    let is_pair = (i < 18) != (j < 18);
                    assert!(listed || !is_pair || apart(x_i, x_j) > radius, "{step}: {i}, {j}");
                    assert!(
                        !listed || is_pair && apart(x_i, x_j) < radius + 2.0 * NEAR_SKIN,
                        "{step}: {i}, {j}"
                    );
                    pairs += u32::from(listed);
                }
                for (w, x_w) in walls.iter().enumerate() {
                    let listed = lists.near.walls.of(i).contains(&(w as u32));
                    assert!(listed || apart(x_i, x_w) > 1.5, "{step}: {i}, wall {w}");
                    assert_eq!(listed, lists.near.of_walls.of(w).contains(&(i as u32)));
                }
                let is_active = lists.near.active.contains(&(i as u32));
                assert_eq!(
                    is_active,
                    !(lists.near.bodies.of(i).is_empty() && lists.near.walls.of(i).is_empty())
                );
            }
            counts.push(pairs);
        }
        // A skin of 1 lasts for 10 steps of 0.1, 5 where both sides count, and 2 where walls move by 0.5; blocks far apart
        // have no pair.
        assert!((40..=100).contains(&searches), "{searches}");
        assert!(counts[0] == 0 && counts[100] > 20 && counts[199] == 0, "{counts:?}");
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
