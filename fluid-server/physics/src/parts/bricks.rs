//! Which part owns what is where: space is cut in two again and again.
//!
//! A cut goes through one layer of units, of which some rows belong to either side: so both sides have their share of the
//! work however few layers there are.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use sph::space::Space;
use sph::space::tensors::SpaceVector;

use super::cell_boxes::{CellBox, CellBoxes};
use super::lattice::Lattice;
use super::reach::Reach;
use crate::team::Team;

/// What a copy costs, over an own particle: measured in space.
const WORK_OF_COPY: f64 = 0.3;

/// Space divided among parts.
#[derive(Clone, Debug)]
pub struct Bricks<S: Space> {
    nodes: Vec<Node>,
    /// Disjoint boxes that together are what each part owns.
    boxes: Vec<Vec<Bounds<S>>>,
}

/// Lower and upper end \[m\]; infinite at the outside.
type Bounds<S> = [<S as Space>::Vector; 2];

#[derive(Clone, Copy, Debug)]
enum Node {
    Part(usize),
    /// What is below the cut is in the next node, the rest in node `above`.
    Cut {
        cut: Cut,
        above: usize,
    },
}

/// A surface between two sides: across `axis`, with one step in it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    axis: usize,
    /// Ends of the layer that both sides have rows of \[m\].
    layer: [f64; 2],
    /// Axis along which these rows follow each other.
    across: usize,
    /// Place of the step along it \[m\].
    at: f64,
}

impl Cut {
    fn is_below<S: Space>(&self, x: &S::Vector) -> bool {
        let [start, end] = self.layer;
        x[self.axis] < start || x[self.axis] < end && x[self.across] < self.at
    }

    /// The boxes into which `bounds` are cut, those below and those above.
    fn halves<S: Space>(&self, bounds: &Bounds<S>) -> [Vec<Bounds<S>>; 2] {
        let Self { axis, layer: [start, end], across, at } = *self;
        let within = |limits: &[(usize, f64, f64)]| {
            let [mut lower, mut upper] = *bounds;
            for (axis, start, end) in limits {
                lower[*axis] = lower[*axis].max(*start);
                upper[*axis] = upper[*axis].min(*end);
            }
            [lower, upper]
        };
        let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
        let below = [within(&[(axis, low, start)]), within(&[(axis, start, end), (across, low, at)])];
        let above = [within(&[(axis, start, end), (across, at, high)]), within(&[(axis, end, high)])];
        let is_box = |[lower, upper]: &Bounds<S>| (0..S::DIMENSIONS).all(|axis| lower[axis] < upper[axis]);
        [below, above].map(|boxes| boxes.into_iter().filter(is_box).collect())
    }
}

/// A cut by units.
#[derive(Clone, Copy, Debug)]
struct UnitCut {
    axis: usize,
    /// The layer that both sides have rows of.
    layer: usize,
    across: usize,
    /// The first row of it that belongs to the upper side.
    row: usize,
}

impl UnitCut {
    fn is_below<S: Space>(&self, units: &S::Of<usize>) -> bool {
        (units[self.axis], units[self.across]) < (self.layer, self.row)
    }

    fn in_space<S: Space>(&self, lattice: &Lattice<S>) -> Cut {
        let Self { axis, layer, across, row } = *self;
        let layer = [layer, layer + 1].map(|unit| between(lattice, axis, unit));
        Cut { axis, layer, across, at: between(lattice, across, row) }
    }
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

/// A particle that is to be divided.
#[derive(Clone, Copy, Debug)]
struct Particle<S: Space> {
    units: S::Of<usize>,
    weight: f64,
    /// Number of its node among the open ones; `None` once its part is known.
    node: Option<usize>,
}

/// First and last unit along an axis in which a node has particles, in that order where it has any.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Span {
    first: u32,
    last: u32,
}

impl Span {
    const NONE: Self = Self { first: u32::MAX, last: 0 };

    fn with(self, other: Self) -> Self {
        Self { first: self.first.min(other.first), last: self.last.max(other.last) }
    }

    fn units(self) -> Range<usize> {
        self.first.min(self.last) as usize..self.last as usize + 1
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
            let by_units = choose_cuts(team, lattice, &open, &particles);
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

/// The cut of each of the `open` nodes, for the particles of all parts.
fn choose_cuts<S: Space>(
    team: &Team,
    lattice: &Lattice<S>,
    open: &[Open<S>],
    particles: &[Particle<S>],
) -> Vec<UnitCut> {
    let all_spans = spans(team, open.len(), particles);
    let spans: Vec<&[Span]> = all_spans.chunks(S::DIMENSIONS).collect();
    let divided = || particles.iter().filter_map(|particle| Some((particle.node?, particle)));
    let lengths = all_spans.iter().map(|span| span.units().len());
    let along_all = divided().flat_map(|(node, Particle { units, weight, .. })| {
        let of_axis = move |axis: usize| (node * S::DIMENSIONS + axis, units[axis], *weight);
        (0..S::DIMENSIONS).map(of_axis)
    });
    let starts: Vec<usize> = all_spans.iter().map(|span| span.units().start).collect();
    let weights =
        sums(team, lengths, along_all.map(|(line, unit, weight)| (line, unit - starts[line], weight)));
    let weights: Vec<&[Vec<f64>]> = weights.chunks(S::DIMENSIONS).collect();
    let mut cuts: Vec<UnitCut> =
        (0..open.len()).map(|k| choose_layer(lattice, open[k].share(), spans[k], weights[k])).collect();
    let across = |k: usize| spans[k][cuts[k].across].units();
    let in_layers = divided()
        .filter(|(node, particle)| particle.units[cuts[*node].axis] == cuts[*node].layer)
        .map(|(node, particle)| {
            (node, particle.units[cuts[node].across] - across(node).start, particle.weight)
        });
    let rows = sums(team, (0..open.len()).map(|k| across(k).len()), in_layers);
    for (k, cut) in cuts.iter_mut().enumerate() {
        let along = &weights[k][cut.axis];
        let below: f64 = along[..cut.layer - spans[k][cut.axis].units().start].iter().sum();
        let count = nearest(&rows[k], open[k].share() * along.iter().sum::<f64>() - below);
        cut.row = match count {
            0 => 0,
            all if all == rows[k].len() => usize::MAX,
            some => spans[k][cut.across].units().start + some,
        };
    }
    cuts
}

/// Sums of all parts in lines of these `lengths`; own addends are `entries` of line, place and value.
fn sums(
    team: &Team,
    lengths: impl Iterator<Item = usize>,
    entries: impl Iterator<Item = (usize, usize, f64)>,
) -> Vec<Vec<f64>> {
    let mut sums: Vec<Vec<f64>> = lengths.map(|length| vec![0.0; length]).collect();
    entries.for_each(|(line, place, value)| sums[line][place] += value);
    team.join(sums, |all, others| {
        for (all, other) in all.iter_mut().flatten().zip(others.into_iter().flatten()) {
            *all += other;
        }
    })
}

/// The cut of a node, but for its row, after which both sides have least to do: `weights` are those of units in `spans`, of
/// which the lower side gets `share`.
fn choose_layer<S: Space>(lattice: &Lattice<S>, share: f64, spans: &[Span], weights: &[Vec<f64>]) -> UnitCut {
    let along = |axis: usize| {
        let others = (0..S::DIMENSIONS).filter(|other| *other != axis);
        // That with most rows.
        let across = others.max_by_key(|other| spans[*other].units().len()).unwrap_or(axis);
        let weights = &weights[axis];
        let target = share * weights.iter().sum::<f64>();
        let ends = weights.iter().scan(0.0, |sum, weight| {
            *sum += weight;
            Some(*sum)
        });
        let layer = ends.take_while(|end| *end <= target).count().min(weights.len() - 1);
        // Copies of what is next to the cut, for two parts at least.
        let first = spans[axis].units().start;
        let units = Reach::FARTHEST.rings() as f64 / lattice.places(axis, first).len().max(1) as f64;
        let near = |weights: &mut dyn Iterator<Item = &f64>| {
            let mut rest = units;
            let part = weights.map_while(|weight| {
                let part = rest.clamp(0.0, 1.0);
                rest -= 1.0;
                (part > 0.0).then_some(part * weight)
            });
            part.sum::<f64>()
        };
        let copies = near(&mut weights[..=layer].iter().rev()).max(near(&mut weights[layer..].iter()));
        let off = weights[layer] / spans[across].units().len() as f64;
        (UnitCut { axis, layer: first + layer, across, row: 0 }, off + 2.0 * WORK_OF_COPY * copies)
    };
    let mut best = along(0);
    for axis in 1..S::DIMENSIONS {
        let other = along(axis);
        if other.1 < best.1 {
            best = other;
        }
    }
    best.0
}

/// Where each of `count` nodes has particles along each axis, all parts together.
fn spans<S: Space>(team: &Team, count: usize, particles: &[Particle<S>]) -> Vec<Span> {
    let mut spans = vec![Span::NONE; count * S::DIMENSIONS];
    for Particle { units, node, .. } in particles {
        let Some(node) = node else { continue };
        for axis in 0..S::DIMENSIONS {
            let span = &mut spans[node * S::DIMENSIONS + axis];
            // Cells are counted in 32 bits.
            *span = span.with(Span { first: units[axis] as u32, last: units[axis] as u32 });
        }
    }
    team.join(spans, |all, others| {
        all.iter_mut().zip(others).for_each(|(all, other)| *all = all.with(other));
    })
}

/// How many of the first `weights` have the sum that is nearest to `target`.
fn nearest(weights: &[f64], target: f64) -> usize {
    let (mut nearest, mut distance, mut sum) = (0, target.abs(), 0.0);
    for (unit, weight) in weights.iter().enumerate() {
        sum += weight;
        if (sum - target).abs() < distance {
            (nearest, distance) = (unit + 1, (sum - target).abs());
        }
    }
    nearest
}

/// The place between the units before `unit` and those from it on, along `axis` \[m\].
fn between<S: Space>(lattice: &Lattice<S>, axis: usize, unit: usize) -> f64 {
    if unit == 0 {
        return f64::NEG_INFINITY;
    }
    if unit >= lattice.units(axis) {
        return f64::INFINITY;
    }
    0.5 * (lattice.middle(axis, unit - 1) + lattice.middle(axis, unit))
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
