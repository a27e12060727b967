//! Work on particles, task by task, that writes several arrays at once.

use std::ops::{AddAssign, Range};

use serde::Serialize;
use serde::de::DeserializeOwned;
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

/// The sum of `term` over the particles of all parts, of which this one has `particles`, the first with the number
/// `first`; grouped by task.
pub fn sum_over_particles<T>(
    team: &Team,
    first: usize,
    particles: usize,
    term: impl Fn(usize) -> T + Sync,
) -> T
where
    T: Clone + Default + AddAssign + Send + Serialize + DeserializeOwned,
{
    let mut sums = Vec::new();
    let of_task = per_task(&mut sums, particles);
    for_each_task(particles, of_task, &|particles, PerTask(sum)| particles.for_each(|i| sum[0] += term(i)));
    team.sum(first / TASK, &sums)
}

/// One value of each task of `particles` particles, in `values`; the memory is kept.
pub fn per_task<T: Clone + Default>(values: &mut Vec<T>, particles: usize) -> PerTask<'_, T> {
    sph::tasks::per_task(values, particles, TASK)
}
