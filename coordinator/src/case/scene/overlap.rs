//! Which particles stand too close to particles of something else.
//!
//! Pairs are visited and not kept: where many things stand on one spot there are as many as particles squared.

use std::collections::HashSet;

use sph::neighbours::CellGrid;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::space::{Plane, Space};

use crate::case::errors::{ErrorList, Place};

sph::constants! {
    /// On one lattice neighbours of touching shapes are a whole spacing apart and overlapping ones coincide; the
    /// fraction lies above √½, so that no point inside a filled square lattice escapes.
    const CLOSENESS: f64 = 0.75, "scene.overlap", "distance below which particles overlap, in mean spacings of the two [-]";
}

/// Overlaps of groups that are reported; a further one is found when these are mended.
pub const MOST_CLASHES: usize = 20;

/// Steps of work for a pair that is looked at, more where images are compared.
fn pair_steps<S: Space>(domain: &Domain<S>) -> f64 {
    if domain.is_periodic() { 20.0 } else { 6.0 }
}

/// Particles that others may stand too close to.
pub struct Crowd<'a, S: Space = Plane> {
    domain: &'a Domain<S>,
    positions: &'a [S::Vector],
    radius: f64,
    grid: CellGrid<S>,
}

impl<'a, S: Space> Crowd<'a, S> {
    /// `positions` \[m\] of particles of one of the `spacings` \[m\], to be compared with particles of the other.
    pub fn new(domain: &'a Domain<S>, positions: &'a [S::Vector], spacings: [f64; 2]) -> Self {
        let radius = CLOSENESS * 0.5 * (spacings[0] + spacings[1]);
        Self { domain, positions, radius, grid: CellGrid::new(domain, positions, radius) }
    }

    /// Calls `found` with each particle that overlaps one at `x` \[m\], until it answers `false`; the number of particles
    /// that were looked at.
    fn visit(&self, x: &S::Vector, mut found: impl FnMut(usize) -> bool) -> usize {
        let mut seen = 0;
        if self.positions.is_empty() {
            return seen;
        }
        let x = self.domain.wrapped(x);
        for range in self.grid.ranges(self.grid.cell(&x)).iter().cloned() {
            for &j in &self.grid.order()[range] {
                seen += 1;
                let j = j as usize;
                let square = self.domain.separation(&x, &self.positions[j]).norm_squared();
                if square < self.radius * self.radius && !found(j) {
                    return seen;
                }
            }
        }
        seen
    }

    /// Whether each of `targets` \[m\] overlaps a particle; all that are left do not when `errors` allow no more work.
    pub fn touches(&self, targets: &[S::Vector], place: &Place, errors: &ErrorList) -> Vec<bool> {
        let mut touches = vec![false; targets.len()];
        for (touch, x) in touches.iter_mut().zip(targets) {
            let seen = self.visit(x, |_| {
                *touch = true;
                false
            });
            if !errors.spend(place, pair_steps(self.domain) * (1 + seen) as f64) {
                break;
            }
        }
        touches
    }

    /// All particles that overlap one at `x` \[m\]; none when `errors` allow no more work.
    pub fn around(&self, x: &S::Vector, found: &mut Vec<usize>, place: &Place, errors: &ErrorList) {
        found.clear();
        // A clear answer needs few of them, whatever stands here.
        const ENOUGH: usize = 1000;
        let seen = self.visit(x, |j| {
            found.push(j);
            found.len() < ENOUGH
        });
        if !errors.spend(place, pair_steps(self.domain) * (1 + seen) as f64) {
            found.clear();
        }
    }
}

/// First pairs of particles of one list that overlap though their groups differ, one of each pair of groups; at most
/// [`MOST_CLASHES`].
pub fn first_clashes<S: Space>(
    domain: &Domain<S>,
    positions: &[S::Vector],
    groups: &[u32],
    spacing: f64,
    place: &Place,
    errors: &ErrorList,
) -> Vec<Clash<S>> {
    let crowd = Crowd::new(domain, positions, [spacing; 2]);
    let mut clashes: Vec<Clash<S>> = Vec::new();
    let mut known = HashSet::new();
    for (position, &a) in positions.iter().zip(groups) {
        let seen = crowd.visit(position, |j| {
            let b = groups[j];
            if a < b && known.insert((a, b)) {
                clashes.push(Clash { groups: (a, b), position: *position });
            }
            clashes.len() < MOST_CLASHES
        });
        if clashes.len() >= MOST_CLASHES || !errors.spend(place, pair_steps(domain) * seen as f64) {
            break;
        }
    }
    clashes
}

/// Two groups of particles that overlap.
pub struct Clash<S: Space> {
    /// The groups, smaller first.
    pub groups: (u32, u32),
    /// Where \[m\].
    pub position: S::Vector,
}
