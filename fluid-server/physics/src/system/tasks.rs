//! Work on particles, task by task, that writes several arrays at once.

use std::ops::Range;

use sph::tasks::{PerTask, Split};

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

/// One value of each task of `particles` particles, in `values`; the memory is kept.
pub fn per_task<T: Clone + Default>(values: &mut Vec<T>, particles: usize) -> PerTask<'_, T> {
    sph::tasks::per_task(values, particles, TASK)
}
