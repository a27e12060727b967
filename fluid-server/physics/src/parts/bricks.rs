//! Which part owns what is where: space is cut in two again and again.
//!
//! A cut goes through one layer of units, of which some rows belong to either side: so both sides have their share of the
//! work however few layers there are.

use std::ops::Range;

use sph::space::Space;
use sph::space::tensors::SpaceVector;

use super::cell_boxes::{CellBox, CellBoxes};
use super::cuts::{Bounds, Cut, Particle, choose_cuts};
use super::lattice::Lattice;
use crate::team::Team;

/// Space divided among parts.
#[derive(Clone, Debug)]
pub struct Bricks<S: Space> {
    nodes: Vec<Node>,
    /// Disjoint boxes that together are what each part owns.
    boxes: Vec<Vec<Bounds<S>>>,
}

#[derive(Clone, Copy, Debug)]
enum Node {
    Part(usize),
    /// What is below the cut is in the next node, the rest in node `above`.
    Cut {
        cut: Cut,
        above: usize,
    },
}

/// A node that is to be divided among `parts`.
#[derive(Clone, Debug)]
struct Open<S: Space> {
    parts: Range<usize>,
    boxes: Vec<Bounds<S>>,
}

impl<S: Space> Open<S> {
    /// Of the weight, that of the lower side.
    fn share(&self) -> f64 {
        (self.parts.len() / 2) as f64 / self.parts.len() as f64
    }
}

impl<S: Space> Bricks<S> {
    /// Divides space among all parts so that each has about the same weight. Own particle i lies in the cell `cells[i]` of
    /// `lattice` and has the weight `weight(i)`. Cuts lie between units.
    pub fn divided(team: &Team, lattice: &Lattice<S>, cells: &[u32], weight: impl Fn(usize) -> f64) -> Self {
        let mut particles: Vec<Particle<S>> = cells
            .iter()
            .enumerate()
            .map(|(i, cell)| {
                let place = lattice.cells().place(*cell);
                let units = S::axes(|axis| lattice.unit(axis, place[axis]));
                Particle { units, weight: weight(i), node: Some(0) }
            })
            .collect();
        let infinite = S::Vector::repeat(f64::INFINITY);
        let all = vec![[-infinite, infinite]];
        let mut open: Vec<Open<S>> = vec![Open { parts: 0..team.size(), boxes: all.clone() }];
        let mut boxes = vec![all; team.size()];
        let mut cuts: Vec<(Range<usize>, Cut)> = Vec::new();
        while open.iter().any(|open| open.parts.len() > 1) {
            let shares: Vec<f64> = open.iter().map(Open::share).collect();
            let by_units = choose_cuts(team, lattice, &shares, &particles);
            let (mut next, mut halves) = (Vec::new(), Vec::with_capacity(open.len()));
            for (Open { parts, boxes: whole }, cut) in open.iter().zip(&by_units) {
                let cut = cut.in_space(lattice);
                cuts.push((parts.clone(), cut));
                let middle = parts.start + parts.len() / 2;
                let of_halves = [parts.start..middle, middle..parts.end];
                halves.push([0, 1].map(|half| {
                    let parts = of_halves[half].clone();
                    let whole =
                        whole.iter().flat_map(|bounds| std::mem::take(&mut cut.halves::<S>(bounds)[half]));
                    if parts.len() == 1 {
                        boxes[parts.start] = whole.collect();
                        return None;
                    }
                    next.push(Open { parts, boxes: whole.collect() });
                    Some(next.len() - 1)
                }));
            }
            for particle in &mut particles {
                particle.node = particle.node.and_then(|node| {
                    halves[node][usize::from(!by_units[node].is_below::<S>(&particle.units))]
                });
            }
            open = next;
        }
        let mut nodes = Vec::new();
        add_node(&mut nodes, 0..team.size(), &cuts);
        Self { nodes, boxes }
    }

    /// The part that owns what is at `x` \[m\].
    pub fn owner(&self, x: &S::Vector) -> usize {
        let mut node = 0;
        loop {
            match &self.nodes[node] {
                Node::Part(part) => return *part,
                Node::Cut { cut, above } => node = if cut.is_below::<S>(x) { node + 1 } else { *above },
            }
        }
    }

    /// The cells of `lattice` that `part` owns.
    pub fn cells(&self, lattice: &Lattice<S>, part: usize) -> CellBoxes<S> {
        let end = |axis: usize, end: f64| {
            // The units whose middle lies below.
            let (mut low, mut high) = (0, lattice.units(axis));
            while low < high {
                let unit = usize::midpoint(low, high);
                if lattice.middle(axis, unit) < end { low = unit + 1 } else { high = unit }
            }
            if low == 0 { 0 } else { lattice.places(axis, low - 1).end }
        };
        let boxes = self.boxes[part].iter().map(|[lower, upper]| CellBox {
            start: S::axes(|axis| end(axis, lower[axis])),
            end: S::axes(|axis| end(axis, upper[axis])),
        });
        CellBoxes::new(boxes, lattice.periods())
    }
}

/// Adds the node of `parts`, and those below it.
fn add_node(nodes: &mut Vec<Node>, parts: Range<usize>, cuts: &[(Range<usize>, Cut)]) {
    let Some((_, cut)) = cuts.iter().find(|(of, ..)| *of == parts).filter(|_| parts.len() > 1) else {
        nodes.push(Node::Part(parts.start));
        return;
    };
    let node = nodes.len();
    nodes.push(Node::Part(parts.start));
    let middle = parts.start + parts.len() / 2;
    add_node(nodes, parts.start..middle, cuts);
    nodes[node] = Node::Cut { cut: *cut, above: nodes.len() };
    add_node(nodes, middle..parts.end, cuts);
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;
    use sph::neighbours::Cells;
    use sph::space::Plane;
    use sph::space::domain::Domain;

    use super::*;
    use crate::team::Team;
    use crate::team::threads::ThreadTransport;
    use crate::team::transport::Transport;

    const SIZE: Vector2<f64> = Vector2::new(40.0, 24.0);

    fn lattice() -> Lattice<Plane> {
        let domain = Domain { lower: Vector2::zeros(), upper: SIZE, periodic: [false; 2] };
        Lattice::new(Cells::new(&domain, [domain.lower, domain.upper], 10_000, 1.0), 0.1)
    }

    /// Space divided among `parts`, with the same weight in each cell but none beyond half the width in the upper half.
    fn bricks(parts: usize) -> Vec<(Bricks<Plane>, Vec<u32>)> {
        let lattice = lattice();
        let is_wet = |cell: &u32| {
            let place = lattice.cells().place(*cell);
            place[1] < 12 || place[0] < 20
        };
        let cells: Vec<u32> = (0..lattice.cells().number() as u32).filter(is_wet).collect();
        let members: Vec<_> = ThreadTransport::of_parts(parts)
            .into_iter()
            .map(|end| {
                let own: Vec<u32> = cells.iter().copied().skip(end.rank()).step_by(parts).collect();
                std::thread::spawn(move || {
                    let team = Team::new(Box::new(end));
                    (Bricks::divided(&team, &lattice, &own, |_| 2.0), own)
                })
            })
            .collect();
        members.into_iter().map(|member| member.join().unwrap()).collect()
    }

    #[test]
    fn parts_own_equal_weights_and_every_cell_has_one_owner() {
        let lattice = lattice();
        for parts in [1, 2, 3, 5, 8] {
            let all = bricks(parts);
            let mut counts = vec![0; parts];
            for (bricks, own) in &all {
                for cell in own {
                    let owner = bricks.owner(&lattice.middle_of(*cell));
                    // All members find the same.
                    assert_eq!(all[0].0.owner(&lattice.middle_of(*cell)), owner);
                    counts[owner] += 1;
                }
            }
            let mean = counts.iter().sum::<i32>() as f64 / parts as f64;
            for count in &counts {
                // A cut is half a cell off, and there are three of them above a part of eight.
                assert!((f64::from(*count) - mean).abs() <= 1.5, "{counts:?}");
            }
            let boxes: Vec<_> = (0..parts).map(|part| all[0].0.cells(&lattice, part)).collect();
            for cell in 0..lattice.cells().number() as u32 {
                let place = lattice.cells().place(cell);
                let owners: Vec<_> =
                    (0..parts).filter(|part| boxes[*part].distance_to_cell(place) == Some(0)).collect();
                assert_eq!(
                    owners,
                    [all[0].0.owner(&lattice.middle_of(cell))],
                    "cell {cell} of {parts} parts"
                );
            }
        }
    }
}
