//! Particles change their owner.

use std::ops::Range;

use super::partition::Partition;
use crate::system::packed_particle::FluidSpace;
use crate::system::state::{FluidState, Scratch, StepStart};
use crate::team::Team;

/// Gives each part the particles that `partition` gives it, in order. `order` is that of its own particles in their
/// pieces: entry k is the index of particle k.
pub fn redistribute<S: FluidSpace>(
    team: &Team,
    partition: &Partition,
    state: &mut FluidState<S>,
    base: &mut StepStart<S>,
    order: &[u32],
) {
    let (rank, size) = (team.rank(), team.size());
    let own = partition.of_part(rank);
    // What each part gets of the particles of this one, as ranges of `order`; what this one gets of each.
    let mut given: Vec<Range<usize>> = vec![0..0; size];
    let mut taken: Vec<(usize, usize)> = Vec::new();
    let mut next = 0;
    for piece in partition.pieces() {
        for (owner, range) in partition.by_owner(piece.first..piece.first + piece.count) {
            if piece.part == rank {
                if given[owner].is_empty() {
                    given[owner] = next..next;
                }
                next += range.len();
                given[owner].end = next;
            }
            if owner == rank {
                taken.push((piece.part, range.len()));
            }
        }
    }
    for (part, range) in given.iter().enumerate().filter(|(part, range)| *part != rank && !range.is_empty()) {
        team.send_value(part, &state.some(base, &order[range.clone()]));
    }
    // Those of each part follow each other behind the own ones.
    let mut firsts = vec![0; size];
    for part in (0..size).filter(|part| *part != rank) {
        firsts[part] = state.len();
        if taken.iter().any(|(from, _)| *from == part) {
            let (others, others_base) = team.receive_value(part);
            state.append(base, others, others_base);
        }
    }
    let mut new_order = Vec::with_capacity(own.len());
    let mut kept = order[given[rank].clone()].iter().copied();
    for (part, count) in taken {
        if part == rank {
            new_order.extend(kept.by_ref().take(count));
        } else {
            // Indices of particles are of 32 bits.
            new_order.extend((firsts[part]..firsts[part] + count).map(|i| i as u32));
            firsts[part] += count;
        }
    }
    let scratch = Scratch { integers: &mut Vec::new(), numbers: &mut Vec::new() };
    state.reorder(base, &new_order, scratch);
    state.first = own.start;
    state.others = partition.total() - own.len();
}
