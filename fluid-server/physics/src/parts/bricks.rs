//! Which part owns what is where: space is cut in two again and again.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use sph::space::Space;
use sph::space::tensors::SpaceVector;

use super::lattice::Lattice;
use super::reach::Reach;
use crate::team::Team;

/// What a copy costs, over an own particle: measured in space.
const WORK_OF_COPY: f64 = 0.3;

/// Space divided among parts by planes across the axes.
#[derive(Clone, Debug)]
pub struct Bricks<S: Space> {
    nodes: Vec<Node>,
    /// Lower and upper ends of what each part owns \[m\]; infinite at the outside.
    boxes: Vec<[S::Vector; 2]>,
}

#[derive(Clone, Copy, Debug)]
enum Node {
    Part(usize),
    /// What is below `at` \[m\] along `axis` is in the next node, the rest in node `above`.
    Cut {
        axis: usize,
        at: f64,
        above: usize,
    },
}

/// A node that is to be divided among `parts`.
#[derive(Clone, Debug)]
struct Open<S: Space> {
    parts: Range<usize>,
    bounds: [S::Vector; 2],
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
        let mut open: Vec<Open<S>> = vec![Open { parts: 0..team.size(), bounds: [-infinite, infinite] }];
        let mut boxes = vec![[-infinite, infinite]; team.size()];
        let mut cuts: Vec<(Range<usize>, usize, f64)> = Vec::new();
        while open.iter().any(|open| open.parts.len() > 1) {
            let cut_units = choose_cuts(team, lattice, &open, &particles);
            let (mut next, mut halves) = (Vec::new(), Vec::with_capacity(open.len()));
            for (Open { parts, bounds }, (axis, unit)) in open.iter().zip(&cut_units) {
                let at = between(lattice, *axis, *unit);
                cuts.push((parts.clone(), *axis, at));
                let middle = parts.start + parts.len() / 2;
                let of_halves = [parts.start..middle, middle..parts.end];
                halves.push([0, 1].map(|half| {
                    let (parts, mut bounds) = (of_halves[half].clone(), *bounds);
                    bounds[1 - half][*axis] = at;
                    if parts.len() == 1 {
                        boxes[parts.start] = bounds;
                        return None;
                    }
                    next.push(Open { parts, bounds });
                    Some(next.len() - 1)
                }));
            }
            for particle in &mut particles {
                particle.node = particle.node.and_then(|node| {
                    let (axis, unit) = cut_units[node];
                    halves[node][usize::from(particle.units[axis] >= unit)]
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
            match self.nodes[node] {
                Node::Part(part) => return part,
                Node::Cut { axis, at, above } => node = if x[axis] < at { node + 1 } else { above },
            }
        }
    }

    /// Places of the cells of `lattice` along each axis that `part` owns.
    pub fn cells(&self, lattice: &Lattice<S>, part: usize) -> CellBox {
        let [lower, upper] = self.boxes[part];
        let ranges = (0..S::DIMENSIONS).map(|axis| {
            // The units whose middle lies in it: as many as lie below.
            let below = |end: f64| {
                let units = lattice.units(axis);
                let (mut low, mut high) = (0, units);
                while low < high {
                    let unit = usize::midpoint(low, high);
                    if lattice.middle(axis, unit) < end { low = unit + 1 } else { high = unit }
                }
                low
            };
            let place = |unit: usize| match unit {
                0 => 0,
                unit => lattice.places(axis, unit - 1).end,
            };
            place(below(lower[axis]))..place(below(upper[axis]))
        });
        CellBox(ranges.collect())
    }
}

/// Adds the node of `parts`, and those below it.
fn add_node(nodes: &mut Vec<Node>, parts: Range<usize>, cuts: &[(Range<usize>, usize, f64)]) {
    let Some((_, axis, at)) = cuts.iter().find(|(of, ..)| *of == parts).filter(|_| parts.len() > 1) else {
        nodes.push(Node::Part(parts.start));
        return;
    };
    let node = nodes.len();
    nodes.push(Node::Part(parts.start));
    let middle = parts.start + parts.len() / 2;
    add_node(nodes, parts.start..middle, cuts);
    nodes[node] = Node::Cut { axis: *axis, at: *at, above: nodes.len() };
    add_node(nodes, middle..parts.end, cuts);
}

/// Axis and unit before which each of the `open` nodes is cut, for the particles of all parts.
fn choose_cuts<S: Space>(
    team: &Team,
    lattice: &Lattice<S>,
    open: &[Open<S>],
    particles: &[Particle<S>],
) -> Vec<(usize, usize)> {
    let spans = spans(team, open.len(), particles);
    let mut weights: Vec<Vec<f64>> = spans.iter().map(|span| vec![0.0; span.units().len()]).collect();
    for Particle { units, weight, node } in particles {
        let Some(node) = node else { continue };
        for axis in 0..S::DIMENSIONS {
            let k = node * S::DIMENSIONS + axis;
            weights[k][units[axis] - spans[k].units().start] += weight;
        }
    }
    let weights = team.join(weights, |all, others| {
        for (all, others) in all.iter_mut().flatten().zip(others.into_iter().flatten()) {
            *all += others;
        }
    });
    let along = spans.chunks(S::DIMENSIONS).zip(weights.chunks(S::DIMENSIONS));
    open.iter().zip(along).map(|(open, (spans, weights))| choose_cut(lattice, open, spans, weights)).collect()
}

/// The cut of `open` after which the slower side has least to do.
fn choose_cut<S: Space>(
    lattice: &Lattice<S>,
    open: &Open<S>,
    spans: &[Span],
    weights: &[Vec<f64>],
) -> (usize, usize) {
    let share = (open.parts.len() / 2) as f64 / open.parts.len() as f64;
    let cuts = spans.iter().zip(weights).enumerate().map(|(axis, (span, weights))| {
        let count = nearest(weights, share);
        let (below, above) = weights.split_at(count);
        let sum = |weights: &[f64]| weights.iter().sum::<f64>();
        let slower = (sum(below) / share).max(sum(above) / (1.0 - share));
        // Copies of what is next to the cut, for two parts at least.
        let units =
            Reach::FARTHEST.rings() as f64 / lattice.places(axis, span.units().start).len().max(1) as f64;
        let near = |weights: &mut dyn Iterator<Item = &f64>| {
            let mut rest = units;
            weights
                .map_while(|weight| {
                    let part = rest.clamp(0.0, 1.0);
                    rest -= 1.0;
                    (part > 0.0).then_some(part * weight)
                })
                .sum::<f64>()
        };
        let copies = near(&mut below.iter().rev()).max(near(&mut above.iter()));
        (axis, span.units().start + count, slower + 2.0 * WORK_OF_COPY * copies)
    });
    let best = cuts.min_by(|a, b| a.2.total_cmp(&b.2));
    best.map_or((0, 0), |(axis, unit, _)| (axis, unit))
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

/// How many of the first units have the sum of `weights` that is nearest to `share` of all.
fn nearest(weights: &[f64], share: f64) -> usize {
    let target = share * weights.iter().sum::<f64>();
    let (mut nearest, mut distance, mut sum) = (0, target, 0.0);
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

/// A box of cells: their places along each axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellBox(Vec<Range<usize>>);

impl CellBox {
    /// Whether there is no cell.
    pub fn is_empty(&self) -> bool {
        self.0.iter().any(Range::is_empty)
    }

    /// Cells between this box, which is not empty, and the cells at `places`: 0 for those of it, 1 for its neighbours. A
    /// lattice that is periodic along an axis has as many cells there as `periods` says.
    pub fn distance(&self, places: &[Range<usize>], periods: &[Option<usize>]) -> usize {
        let along = |axis: usize| {
            let (own, other) = (&self.0[axis], &places[axis]);
            let apart = |shift: usize, count: usize| {
                // `other` is moved by `shift` less `count` cells.
                let (start, end) = (other.start + shift, other.end + shift);
                let (own_start, own_end) = (own.start + count, own.end + count);
                (own_start + 1).saturating_sub(end).max((start + 1).saturating_sub(own_end))
            };
            match periods[axis] {
                None => apart(0, 0),
                Some(count) => apart(0, 0).min(apart(count, 0)).min(apart(0, count)),
            }
        };
        (0..self.0.len()).map(along).max().unwrap_or_default()
    }

    /// Their places along each axis.
    pub fn places(&self) -> &[Range<usize>] {
        &self.0
    }
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
                // A cut is a row of at most 24 cells off, and there are three of them above a part of eight.
                assert!((f64::from(*count) - mean).abs() <= 36.0, "{counts:?}");
            }
            let boxes: Vec<_> = (0..parts).map(|part| all[0].0.cells(&lattice, part)).collect();
            for cell in 0..lattice.cells().number() as u32 {
                let place = lattice.cells().place(cell);
                let places = [place[0]..place[0] + 1, place[1]..place[1] + 1];
                let owners: Vec<_> =
                    (0..parts).filter(|part| boxes[*part].distance(&places, &[None; 2]) == 0).collect();
                assert_eq!(
                    owners,
                    [all[0].0.owner(&lattice.middle_of(cell))],
                    "cell {cell} of {parts} parts"
                );
            }
        }
    }

    #[test]
    fn distances_are_those_of_the_nearest_image() {
        let cells = CellBox(vec![2..4, 0..1]);
        let distance =
            |x: usize, y: usize, periods: [Option<usize>; 2]| cells.distance(&[x..x + 1, y..y + 1], &periods);
        let open = [None; 2];
        assert_eq!([distance(2, 0, open), distance(3, 0, open), distance(4, 0, open)], [0, 0, 1]);
        assert_eq!([distance(1, 0, open), distance(0, 0, open), distance(0, 5, open)], [1, 2, 5]);
        assert_eq!(distance(9, 0, open), 6);
        assert_eq!(distance(9, 0, [Some(10), None]), 3);
        assert_eq!(distance(3, 9, [None, Some(10)]), 1);
    }
}
