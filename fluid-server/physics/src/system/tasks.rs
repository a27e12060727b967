//! Work on particles, task by task, that writes several arrays at once.

use std::ops::Range;

use sph::sums::{ExactSums, Numbers};
use sph::tasks::{PerTask, Split};

use crate::team::Team;

/// Particles per task: fixed, so that sums grouped by task have the same bits on any number of threads.
pub const TASK: usize = 256;

/// Implements [`Split`] for a struct of results, field by field.
macro_rules! split_by_field {
    ($name:ident$(<$space:ident>)? { $($field:ident),+ }) => {
        impl$(<$space: $crate::system::packed_particle::FluidSpace>)? sph::tasks::Split
            for $name<'_$(, $space)?>
        {
            fn split(self, items: usize, tasks: usize) -> (Self, Self) {
                $(let $field = self.$field.split(items, tasks);)+
                (Self { $($field: $field.0),+ }, Self { $($field: $field.1),+ })
            }
        }
    };
}
pub(crate) use split_by_field;

/// Calls `work` for each task of `particles` particles, in parallel, with the task's particles and its part of
/// `results`. Allocates nothing.
pub fn for_each_task<S: Split>(particles: usize, results: S, work: &(dyn Fn(Range<usize>, S) + Sync)) {
    sph::tasks::for_each_task(particles, TASK, results, work);
}

/// Groups of particles whose sums are made one after the other.
#[derive(Clone, Debug, Default)]
pub struct Groups {
    /// End of each.
    ends: Vec<u32>,
    /// The numbers of all.
    all: Vec<u32>,
}

impl Groups {
    /// Those that end with the particles before `ends`.
    pub fn new(ends: Vec<u32>) -> Self {
        let all = (0u32..).take(ends.len()).collect();
        Self { ends, all }
    }

    /// The numbers of all.
    pub fn all(&self) -> &[u32] {
        &self.all
    }

    /// The particles of group `group`.
    pub fn particles(&self, group: u32) -> Range<usize> {
        let group = group as usize;
        let start = if group == 0 { 0 } else { self.ends[group - 1] };
        start as usize..self.ends[group] as usize
    }

    /// Bytes in use.
    pub fn bytes(&self) -> usize {
        4 * (self.ends.capacity() + self.all.capacity())
    }

    /// Calls `work` for each of the `chosen` groups, in parallel, with its particles and its part of `results`, which are
    /// those of all. Allocates nothing.
    pub fn for_each<S: Split>(&self, chosen: &[u32], results: S, work: &(dyn Fn(Range<usize>, S) + Sync)) {
        sph::tasks::for_each_group(&self.ends, chosen, TASK, results, work);
    }

    /// One value of each group, in `values`; the memory is kept.
    pub fn values<'a, T: Clone + Default>(&self, values: &'a mut Vec<T>) -> PerTask<'a, T> {
        sph::tasks::per_task(values, self.ends.len(), 1)
    }
}

/// The sum of `term` over the particles of all parts, of which this one has `particles`, with the shape of `zero`.
pub fn sum_over_particles<T: Numbers>(
    team: &Team,
    particles: usize,
    zero: T,
    term: impl Fn(usize) -> T + Sync,
) -> T {
    let mut sums = Vec::new();
    let of_task = per_task(&mut sums, particles);
    for_each_task(particles, of_task, &|particles, PerTask(sum): PerTask<'_, ExactSums>| {
        particles.for_each(|i| sum[0].add(term(i)));
    });
    let mut own = ExactSums::default();
    sums.iter().for_each(|sum| own.merge(sum));
    team.join(own, |all, others| all.merge(&others)).total(zero)
}

/// One value of each task of `particles` particles, in `values`; the memory is kept.
pub fn per_task<T: Clone + Default>(values: &mut Vec<T>, particles: usize) -> PerTask<'_, T> {
    sph::tasks::per_task(values, particles, TASK)
}
