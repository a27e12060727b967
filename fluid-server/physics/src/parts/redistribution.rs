//! Particles change their owner.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::bricks::Bricks;
use super::lattice::Lattice;
use crate::system::packed_particle::FluidSpace;
use crate::system::state::{FluidState, Scratch, StepStart};
use crate::team::Team;

/// The particles of `part` among `total`, of which `size` parts have equal numbers before the first lists.
pub fn share(total: usize, part: usize, size: usize) -> Range<usize> {
    total * part / size..total * (part + 1) / size
}

/// Particles that one part gives to another, with their cells.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "", deserialize = ""))]
struct Given<S: FluidSpace> {
    cells: Vec<u32>,
    state: FluidState<S>,
    base: StepStart<S>,
}

/// Gives each part what it owns by `bricks`, in the order of all particles: by cell, within a cell as before. Own particle
/// i lies in the cell `cells[i]` of `lattice`; returns the cells of those that this part has then.
pub fn redistribute<S: FluidSpace>(
    team: &Team,
    lattice: &Lattice<S>,
    bricks: &Bricks<S>,
    mut cells: Vec<u32>,
    state: &mut FluidState<S>,
    base: &mut StepStart<S>,
) -> Vec<u32> {
    let total = state.total();
    let mut given: Vec<Vec<u32>> = vec![Vec::new(); team.size()];
    // Most particles lie in the run of the one before.
    let mut last: Option<(u32, usize)> = None;
    for (i, cell) in (0u32..).zip(&cells) {
        let owner = match last {
            Some((known, owner)) if known == *cell => owner,
            _ => bricks.owner(&lattice.middle_of(*cell)),
        };
        last = Some((*cell, owner));
        given[owner].push(i);
    }
    let mut order = std::mem::take(&mut given[team.rank()]);
    let receivers: Vec<usize> = (0..team.size()).filter(|part| !given[*part].is_empty()).collect();
    let all_receivers = team.all(receivers.clone());
    for part in receivers {
        let (state, base) = state.some(base, &given[part]);
        let cells = given[part].iter().map(|i| cells[*i as usize]).collect();
        team.send_value(part, &Given { cells, state, base });
    }
    for (part, receivers) in all_receivers.iter().enumerate() {
        if receivers.contains(&team.rank()) {
            let taken: Given<S> = team.receive_value(part);
            // Indices of particles are of 32 bits.
            order.extend((state.len() as u32..).take(taken.state.len()));
            cells.extend(taken.cells);
            state.append(base, taken.state, taken.base);
        }
    }
    order.sort_by_key(|i| (cells[*i as usize], state.order[*i as usize]));
    state.reorder(base, &order, Scratch { integers: &mut Vec::new(), numbers: &mut Vec::new() });
    let cells: Vec<u32> = order.iter().map(|i| cells[*i as usize]).collect();
    state.order = numbered(&cells).collect();
    state.others = total - order.len();
    cells
}

/// The place of each particle among all, by the ascending `cells` in which they lie: all of a cell are there.
fn numbered(cells: &[u32]) -> impl Iterator<Item = u64> + '_ {
    cells.chunk_by(|a, b| a == b).flat_map(|of_cell| {
        (0..).zip(of_cell).map(|(place, cell): (u64, _)| (u64::from(*cell) << 32) + place)
    })
}
