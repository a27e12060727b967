//! Which particles stand too close to particles of something else.

use sph::domain::Domain;
use sph::neighbours::{CellGrid, NeighbourList};
use sph::vector::Vector;

/// Particles closer than this fraction of the mean spacing overlap.
///
/// On one lattice neighbours of touching shapes are a whole spacing apart and overlapping ones coincide; the
/// fraction lies above √½, so that no point inside a filled square lattice escapes.
const CLOSENESS: f64 = 0.75;

/// Sources within overlap of each target.
pub fn overlaps(
    domain: &Domain,
    targets: &[Vector],
    sources: &[Vector],
    spacings: [f64; 2],
) -> NeighbourList {
    if sources.is_empty() {
        return NeighbourList::empty(targets.len());
    }
    let radius = CLOSENESS * 0.5 * (spacings[0] + spacings[1]);
    CellGrid::new(domain, sources, radius).list(domain, targets, sources, radius, false)
}

/// First pair of particles of one list that overlap though their groups differ: smaller group first.
pub fn first_clashes(domain: &Domain, positions: &[Vector], groups: &[u32], spacing: f64) -> Vec<Clash> {
    let list = overlaps(domain, positions, positions, [spacing; 2]);
    let mut clashes: Vec<Clash> = Vec::new();
    for (i, position) in positions.iter().enumerate() {
        for &j in list.of(i) {
            let (a, b) = (groups[i], groups[j as usize]);
            if a < b && !clashes.iter().any(|clash| clash.groups == (a, b)) {
                clashes.push(Clash { groups: (a, b), position: *position });
            }
        }
    }
    clashes
}

/// Two groups of particles that overlap.
pub struct Clash {
    /// The groups, smaller first.
    pub groups: (u32, u32),
    /// Where \[m\].
    pub position: Vector,
}
