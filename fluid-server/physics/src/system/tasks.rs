//! Work on particles, task by task, that writes several arrays at once.

use std::ops::Range;

/// Particles per task: fixed, so that sums grouped by task have the same bits on any number of threads.
pub const TASK: usize = 256;

/// Results that can be divided among tasks.
pub trait Split: Sized + Send {
    /// The results of the first `at` particles, a multiple of [`TASK`], and the rest.
    fn split(self, at: usize) -> (Self, Self);
}

/// One value for each particle, or none at all where a case does not need the array.
impl<T: Send> Split for &mut [T] {
    fn split(self, at: usize) -> (Self, Self) {
        if self.is_empty() { (&mut [], &mut []) } else { self.split_at_mut(at) }
    }
}

/// One value for each task.
#[derive(Debug)]
pub struct PerTask<'a, T>(pub &'a mut [T]);

impl<T: Send> Split for PerTask<'_, T> {
    fn split(self, at: usize) -> (Self, Self) {
        let (first, rest) = self.0.split_at_mut(at / TASK);
        (Self(first), PerTask(rest))
    }
}

impl<A: Split, B: Split> Split for (A, B) {
    fn split(self, at: usize) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.split(at), self.1.split(at));
        ((a, b), (c, d))
    }
}

/// Implements [`Split`] for a struct of slices, field by field.
macro_rules! split_by_field {
    ($name:ident$(<$space:ident>)? { $($field:ident),+ }) => {
        impl$(<$space: $crate::system::packed_particle::FluidSpace>)? $crate::system::tasks::Split
            for $name<'_$(, $space)?>
        {
            fn split(self, at: usize) -> (Self, Self) {
                $(let $field = self.$field.split(at);)+
                (Self { $($field: $field.0),+ }, Self { $($field: $field.1),+ })
            }
        }
    };
}
pub(crate) use split_by_field;

/// Calls `work` for each task of `particles` particles, in parallel, with the task's particles and its part of
/// `results`. Allocates nothing. A dynamic call for each task costs nothing, and a pass that is compiled for many
/// combinations of terms shares one copy of the division.
pub fn for_each_task<S: Split>(particles: usize, results: S, work: &Work<'_, S>) {
    divide(0..particles, results, work);
}

/// Work on the particles of a task and its part of the results.
type Work<'a, S> = dyn Fn(Range<usize>, S) + Sync + 'a;

fn divide<S: Split>(particles: Range<usize>, results: S, work: &Work<'_, S>) {
    if particles.len() <= TASK {
        if !particles.is_empty() {
            work(particles, results);
        }
        return;
    }
    let at = particles.len().div_ceil(TASK) / 2 * TASK;
    let (first, rest) = results.split(at);
    let middle = particles.start + at;
    rayon::join(
        || divide(particles.start..middle, first, work),
        || divide(middle..particles.end, rest, work),
    );
}

/// One value of each task of `particles` particles, in `values`; the memory is kept.
pub fn per_task<T: Clone + Default>(values: &mut Vec<T>, particles: usize) -> PerTask<'_, T> {
    values.clear();
    values.resize(particles.div_ceil(TASK), T::default());
    PerTask(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_particle_and_each_task_is_visited_once() {
        for particles in [0, 1, TASK, TASK + 1, 7 * TASK + 13] {
            let (mut each, mut tasks, mut unused) = (vec![0; particles], Vec::<u32>::new(), [0_u8; 0]);
            let results = ((&mut each[..], per_task(&mut tasks, particles)), &mut unused[..]);
            for_each_task(particles, results, &|range, ((each, task), unused)| {
                assert_eq!((range.len(), task.0.len(), unused.len()), (each.len(), 1, 0));
                each.iter_mut().zip(range).for_each(|(value, i)| *value += i + 1);
                task.0[0] += 1;
            });
            assert!(each.iter().enumerate().all(|(i, value)| *value == i + 1));
            assert!(tasks.len() == particles.div_ceil(TASK) && tasks.iter().all(|count| *count == 1));
        }
    }
}
