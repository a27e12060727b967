//! Fluid regions around a solid particle, and the dummy state that each of them interacts with.
//!
//! A particle inside a thin plate has fluid within support on both sides. One mean over all of it would let the pressure
//! of one side act on the other through the plate. So each disconnected region of fluid has a dummy state of its own.

use super::states::InterfaceStates;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space};
use crate::tasks::for_each;

use super::lists::{CrossPair, Rows, TASK, TaskRows};

/// Dummy state of a solid particle toward one fluid region.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dummy<S: Space = Plane> {
    /// Pressure \[Pa\].
    pub pressure: f64,
    /// Density that belongs to the pressure \[kg/m³\].
    pub density: f64,
    /// Mass \[kg\], in the plane per depth.
    pub mass: f64,
    /// Velocity \[m/s\]: that of the fluid around the solid particle mirrored, along the face where it slips, so that the
    /// velocity of the solid is met at its face, half-way. In the plain sum that of the particle.
    pub velocity: S::Vector,
}

/// The fluid within support of one solid particle; buffers are reused.
#[derive(Debug, Default)]
struct Neighbourhood<S: Space> {
    separations: Vec<S::Vector>,
    stack: Vec<usize>,
}

/// Fluid regions around the solid particles of one task.
#[derive(Debug, Default)]
struct TaskRegions<S: Space> {
    neighbourhood: Neighbourhood<S>,
    /// Regions around each particle.
    counts: Vec<u32>,
    /// Pairs of fluid particles, smaller index first, that a solid particle separates.
    separated: Vec<(u32, u32)>,
    /// Solid particles with several regions on one side of them.
    ambiguous: Vec<u32>,
}

crate::constants! {
    /// A support holds about thirty particles, and the work grows with their square.
    const LARGEST_ROW: usize = 256, "interface.largest_row",
        "fluid particles around one of a solid above which they count as one region [-]";
}

/// A pair without a region.
const UNASSIGNED: u32 = u32::MAX;

impl<S: Space> TaskRegions<S> {
    /// Numbers the regions around every particle of the task from 0, in the pairs of `rows`.
    fn find(
        &mut self,
        domain: &Domain<S>,
        square: f64,
        [fluid, solid]: [&InterfaceStates<S>; 2],
        rows: &mut TaskRows,
    ) {
        let Self { neighbourhood, counts, separated, ambiguous } = self;
        counts.clear();
        separated.clear();
        ambiguous.clear();
        rows.each(|s, row| {
            neighbourhood.separate(domain, fluid, &solid.position[s], row);
            let mean: S::Vector = neighbourhood.separations.iter().copied().sum();
            let one_sided = neighbourhood.separations.iter().all(|x_fs| x_fs.dot(&mean) > 0.0);
            let regions =
                if neighbourhood.is_connected(square) { 1 } else { neighbourhood.flood(square, row) };
            if one_sided && regions > 1 {
                // Exact, as indices of pairs are.
                ambiguous.push(s as u32);
            }
            if one_sided || regions == 1 {
                row.iter_mut().for_each(|pair| pair.region = 0);
                counts.push(u32::from(!row.is_empty()));
                return;
            }
            counts.push(regions);
            for (k, a) in row.iter().enumerate() {
                let others = row[..k].iter().filter(|b| b.region != a.region);
                separated.extend(others.map(|b| (b.other, a.other)));
            }
        });
    }
}

impl<S: Space> Neighbourhood<S> {
    /// Stores the separations of `row` from the particle at `x_s`.
    fn separate(
        &mut self,
        domain: &Domain<S>,
        fluid: &InterfaceStates<S>,
        x_s: &S::Vector,
        row: &[CrossPair],
    ) {
        self.separations.clear();
        let separation = |pair: &CrossPair| domain.separation(&fluid.position[pair.other as usize], x_s);
        self.separations.extend(row.iter().map(separation));
    }

    /// Whether all fluid lies within a support of its particle nearest to the solid particle, the usual case.
    fn is_connected(&self, square: f64) -> bool {
        if self.separations.len() > LARGEST_ROW {
            return true;
        }
        let nearest = self.separations.iter().min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        nearest.is_none_or(|nearest| {
            self.separations.iter().all(|x_fs| (*x_fs - *nearest).norm_squared() < square)
        })
    }

    /// Numbers the connected components of `row`; returns their count.
    fn flood(&mut self, square: f64, row: &mut [CrossPair]) -> u32 {
        let Self { separations, stack, .. } = self;
        row.iter_mut().for_each(|pair| pair.region = UNASSIGNED);
        let mut count = 0;
        for k in 0..row.len() {
            if row[k].region != UNASSIGNED {
                continue;
            }
            row[k].region = count;
            stack.push(k);
            while let Some(a) = stack.pop() {
                for b in 0..row.len() {
                    if row[b].region == UNASSIGNED
                        && (separations[b] - separations[a]).norm_squared() < square
                    {
                        row[b].region = count;
                        stack.push(b);
                    }
                }
            }
            count += 1;
        }
        count
    }
}

/// Merges those of the `regions` of `row` that no pair of `separated` keeps apart and renumbers them; returns their count.
fn merge(separated: &[(u32, u32)], row: &mut [CrossPair], regions: u32) -> u32 {
    let apart = |a: u32, b: u32, row: &[CrossPair]| {
        let of = |region: u32| row.iter().filter(move |pair| pair.region == region).map(|pair| pair.other);
        of(a).any(|f| of(b).any(|g| separated.binary_search(&(f.min(g), f.max(g))).is_ok()))
    };
    let mut count = 0;
    for region in 0..regions {
        // Into the first earlier one that it is not separated from.
        let target = (0..count).find(|target| !apart(*target, region, row)).unwrap_or(count);
        row.iter_mut().filter(|pair| pair.region == region).for_each(|pair| pair.region = target);
        count = count.max(target + 1);
    }
    count
}

/// Fluid regions around all solid particles, with their dummy states.
#[derive(Debug, Default)]
pub struct FluidRegions<S: Space> {
    dummies: Vec<Dummy<S>>,
    tasks: Vec<TaskRegions<S>>,
    separated: Vec<(u32, u32)>,
}

impl<S: Space> FluidRegions<S> {
    /// The dummy state that the fluid of `pair` interacts with.
    pub fn dummy(&self, pair: &CrossPair) -> &Dummy<S> {
        &self.dummies[pair.region as usize]
    }

    /// One region around every solid particle, however the fluid lies.
    pub fn update_whole(&mut self, rows: &mut Rows, dummy: impl Fn(usize) -> Dummy<S>) {
        self.dummies.clear();
        for s in 0..rows.len() {
            rows.of_mut(s).iter_mut().for_each(|pair| pair.region = s as u32);
            self.dummies.push(dummy(s));
        }
    }

    /// The disconnected regions around every solid particle; `dummy` gives the dummy state of particle, row and region.
    pub fn update_disconnected(
        &mut self,
        domain: &Domain<S>,
        support: f64,
        states: [&InterfaceStates<S>; 2],
        rows: &mut Rows,
        dummy: impl Fn(usize, &[CrossPair], u32) -> Dummy<S> + Sync,
    ) {
        self.find(domain, support * support, states, rows);
        let Self { dummies, tasks, .. } = self;
        let counts = |task: &TaskRegions<S>| task.counts.iter().sum::<u32>();
        dummies.clear();
        dummies.resize(tasks.iter().map(counts).sum::<u32>() as usize, Dummy::default());
        let (mut rest, mut first) = (&mut dummies[..], 0);
        let each = rows.tasks().into_iter().zip(&*tasks).map(|(rows, task)| {
            let (own, others) = std::mem::take(&mut rest).split_at_mut(counts(task) as usize);
            let start = first;
            (rest, first) = (others, first + counts(task));
            (rows, task, own, start)
        });
        let mut each: Vec<_> = each.collect();
        for_each(&mut each[..], 1, |_, (rows, task, own, first)| {
            let (mut own, mut counts) = (own.iter_mut(), task.counts.iter());
            rows.each(|s, row| {
                let count = counts.next().copied().unwrap_or(0);
                row.iter_mut().for_each(|pair| pair.region += *first);
                (*first..*first + count).zip(&mut own).for_each(|(region, own)| *own = dummy(s, row, region));
                *first += count;
            });
        });
    }

    /// Numbers the regions around every solid particle from 0, in the pairs of `rows`.
    ///
    /// Two regions of a row are disconnected if no chain of its particles, each nearer than the root of `square` \[m²\] to
    /// the next, links them. A solid particle separates regions on different sides of it. Regions on one side of it, such
    /// as drops, count as one unless another particle separates them: the foot of a plate that stands in the floor has the
    /// fluid of both sides above it.
    fn find(&mut self, domain: &Domain<S>, square: f64, states: [&InterfaceStates<S>; 2], rows: &mut Rows) {
        let Self { tasks, separated, .. } = self;
        let mut of_tasks = rows.tasks();
        tasks.resize_with(of_tasks.len(), TaskRegions::default);
        for_each((&mut of_tasks[..], &mut tasks[..]), 1, |_, (rows, task)| {
            task.find(domain, square, states, rows);
        });
        separated.clear();
        tasks.iter().for_each(|task| separated.extend(&task.separated));
        if separated.is_empty() {
            return;
        }
        separated.sort_unstable();
        separated.dedup();
        let [fluid, solid] = states;
        for (task, TaskRegions { neighbourhood, counts, ambiguous, .. }) in tasks.iter_mut().enumerate() {
            for s in ambiguous.iter().map(|s| *s as usize) {
                let row = rows.of_mut(s);
                neighbourhood.separate(domain, fluid, &solid.position[s], row);
                let regions = neighbourhood.flood(square, row);
                counts[s - task * TASK] = merge(separated, row, regions);
            }
        }
    }
}
