//! Where space is cut in two.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use sph::space::Space;

use super::lattice::Lattice;
use super::reach::Reach;
use crate::team::Team;

/// What a copy costs, over an own particle: measured in space.
const WORK_OF_COPY: f64 = 0.3;

/// Lower and upper end \[m\]; infinite at the outside.
pub type Bounds<S> = [<S as Space>::Vector; 2];

/// A surface between two sides: across `axis`, with one step in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    axis: usize,
    /// Ends of the layer that both sides have rows of \[m\].
    layer: [f64; 2],
    /// Axis along which these rows follow each other.
    across: usize,
    /// Place of the step along it \[m\].
    at: f64,
}

impl Cut {
    /// Whether `x` \[m\] is on the lower side.
    pub fn is_below<S: Space>(&self, x: &S::Vector) -> bool {
        let [start, end] = self.layer;
        x[self.axis] < start || x[self.axis] < end && x[self.across] < self.at
    }

    /// The boxes into which `bounds` are cut, those below and those above.
    pub fn halves<S: Space>(&self, bounds: &Bounds<S>) -> [Vec<Bounds<S>>; 2] {
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
pub struct UnitCut {
    axis: usize,
    /// The layer that both sides have rows of.
    layer: usize,
    across: usize,
    /// The first row of it that belongs to the upper side.
    row: usize,
}

impl UnitCut {
    /// Whether what lies in `units` is on the lower side.
    pub fn is_below<S: Space>(&self, units: &S::Of<usize>) -> bool {
        (units[self.axis], units[self.across]) < (self.layer, self.row)
    }

    /// The same by places \[m\].
    pub fn in_space<S: Space>(&self, lattice: &Lattice<S>) -> Cut {
        let Self { axis, layer, across, row } = *self;
        let layer = [layer, layer + 1].map(|unit| between(lattice, axis, unit));
        Cut { axis, layer, across, at: between(lattice, across, row) }
    }
}

/// A particle that is to be divided.
#[derive(Clone, Copy, Debug)]
pub struct Particle<S: Space> {
    /// Its unit along each axis.
    pub units: S::Of<usize>,
    /// Its work.
    pub weight: f64,
    /// Number of its node among the open ones; `None` once its part is known.
    pub node: Option<usize>,
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

/// The cut of each of the open nodes, of whose weight the lower side gets one of `shares`, for the particles of all parts.
pub fn choose_cuts<S: Space>(
    team: &Team,
    lattice: &Lattice<S>,
    shares: &[f64],
    particles: &[Particle<S>],
) -> Vec<UnitCut> {
    let all_spans = spans(team, shares.len(), particles);
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
        (0..shares.len()).map(|k| choose_layer(lattice, shares[k], spans[k], weights[k])).collect();
    let across = |k: usize| spans[k][cuts[k].across].units();
    let in_layers = divided()
        .filter(|(node, particle)| particle.units[cuts[*node].axis] == cuts[*node].layer)
        .map(|(node, particle)| {
            (node, particle.units[cuts[node].across] - across(node).start, particle.weight)
        });
    let rows = sums(team, (0..shares.len()).map(|k| across(k).len()), in_layers);
    for (k, cut) in cuts.iter_mut().enumerate() {
        let along = &weights[k][cut.axis];
        let below: f64 = along[..cut.layer - spans[k][cut.axis].units().start].iter().sum();
        let count = nearest(&rows[k], shares[k] * along.iter().sum::<f64>() - below);
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
