//! Parallel work on particles, in tasks of a fixed number of them.
//!
//! All of it goes through one compiled copy of [`rayon::join`]. A parallel iterator is compiled once more for every
//! closure: that made a quarter of the code of the fluid and two fifths of that of solids. Which thread takes a task
//! is open; what is in a task is not, so that results do not depend on the number of threads.

use std::ops::Range;

/// Results that can be divided among tasks.
pub trait Split: Sized + Send {
    /// The results of the first `items`, which are those of the first `tasks` tasks, and the rest.
    fn split(self, items: usize, tasks: usize) -> (Self, Self);
}

/// One value for each item, or none at all where a case does not need the array.
impl<T: Send> Split for &mut [T] {
    fn split(self, items: usize, _tasks: usize) -> (Self, Self) {
        if self.is_empty() { (&mut [], &mut []) } else { self.split_at_mut(items) }
    }
}

/// Work that leaves no results.
impl Split for () {
    fn split(self, _items: usize, _tasks: usize) -> (Self, Self) {
        ((), ())
    }
}

impl<A: Split, B: Split> Split for (A, B) {
    fn split(self, items: usize, tasks: usize) -> (Self, Self) {
        let ((a, c), (b, d)) = (self.0.split(items, tasks), self.1.split(items, tasks));
        ((a, b), (c, d))
    }
}

/// One value for each task.
#[derive(Debug)]
pub struct PerTask<'a, T>(pub &'a mut [T]);

impl<T: Send> Split for PerTask<'_, T> {
    fn split(self, _items: usize, tasks: usize) -> (Self, Self) {
        let (first, rest) = self.0.split_at_mut(tasks);
        (Self(first), PerTask(rest))
    }
}

/// One value for each task of `task` among `items` items, in `values`; the memory is kept.
pub fn per_task<T: Clone + Default>(values: &mut Vec<T>, items: usize, task: usize) -> PerTask<'_, T> {
    values.clear();
    values.resize(items.div_ceil(task), T::default());
    PerTask(values)
}

/// Results with one value for each item, which [`for_each`] visits: a slice, or pairs of such results.
pub trait Columns: Split {
    /// What belongs to one item.
    type Item;

    /// The number of items.
    fn items(&self) -> usize;

    /// Each item in order.
    fn each(self) -> impl Iterator<Item = Self::Item>;
}

impl<'a, T: Send> Columns for &'a mut [T] {
    type Item = &'a mut T;

    fn items(&self) -> usize {
        self.len()
    }

    fn each(self) -> impl Iterator<Item = &'a mut T> {
        self.iter_mut()
    }
}

impl<A: Columns, B: Columns> Columns for (A, B) {
    type Item = (A::Item, B::Item);

    fn items(&self) -> usize {
        self.0.items()
    }

    fn each(self) -> impl Iterator<Item = Self::Item> {
        self.0.each().zip(self.1.each())
    }
}

/// Work on the items of a task and its part of the results.
type Work<'a, R> = dyn Fn(Range<usize>, R) + Sync + 'a;

/// Calls `work` for each task of `task` items among `items` items, in parallel, with the task's items and its part of
/// `results`. Allocates nothing.
pub fn for_each_task<R: Split>(items: usize, task: usize, results: R, work: &Work<'_, R>) {
    divide(0..items, task, results, work);
}

/// Calls `work` for each of the `chosen` groups, in ascending order, with its number, the group's items and its part of
/// `results`, in parallel. Group k ends with the item before `ends[k]`; `results` are those of all items, a task being a
/// group. Allocates nothing.
pub fn for_each_group<R: Split>(ends: &[u32], chosen: &[u32], task: usize, results: R, work: &Work<'_, R>) {
    divide_groups(Groups { ends, chosen, task }, (0, 0), results, work);
}

/// Input of [`for_each_group`].
#[derive(Clone, Copy)]
struct Groups<'a> {
    ends: &'a [u32],
    chosen: &'a [u32],
    task: usize,
}

impl Groups<'_> {
    fn items(&self, group: u32) -> Range<usize> {
        let start = if group == 0 { 0 } else { self.ends[group as usize - 1] };
        start as usize..self.ends[group as usize] as usize
    }
}

/// `results` are those from item and group `from` on.
fn divide_groups<R: Split>(groups: Groups<'_>, from: (usize, usize), results: R, work: &Work<'_, R>) {
    let Groups { chosen, .. } = groups;
    let ([first, ..], [.., last]) = (chosen, chosen) else { return };
    let items = groups.items(*first).start..groups.items(*last).end;
    if chosen.len() > 1 && items.len() > groups.task {
        let (some, rest) = chosen.split_at(chosen.len() / 2);
        let middle = (groups.items(rest[0]).start, rest[0] as usize);
        let (before, after) = results.split(middle.0 - from.0, middle.1 - from.1);
        let (some, rest) = (Groups { chosen: some, ..groups }, Groups { chosen: rest, ..groups });
        join(|| divide_groups(some, from, before, work), || divide_groups(rest, middle, after, work));
        return;
    }
    let (mut at, mut rest) = (from, results);
    for group in chosen {
        let items = groups.items(*group);
        let (_, from_group) = rest.split(items.start - at.0, *group as usize - at.1);
        let (own, following) = from_group.split(items.len(), 1);
        (at, rest) = ((items.end, *group as usize + 1), following);
        work(items, own);
    }
}

fn divide<R: Split>(items: Range<usize>, task: usize, results: R, work: &Work<'_, R>) {
    let Some((first, rest)) = halves(&items, task) else {
        if !items.is_empty() {
            work(items, results);
        }
        return;
    };
    let (before, after) = results.split(first.len(), first.len() / task);
    join(|| divide(first, task, before, work), || divide(rest, task, after, work));
}

/// Two ranges of whole tasks, the last task apart; `None` for a single task.
fn halves(items: &Range<usize>, task: usize) -> Option<(Range<usize>, Range<usize>)> {
    let middle = items.start + items.len().div_ceil(task) / 2 * task;
    (items.len() > task).then_some((items.start..middle, middle..items.end))
}

/// Calls `work` for each item of `columns` with its index, in parallel, `task` items at a time. Allocates nothing.
///
/// ```
/// let mut squares = [0; 1000];
/// sph::tasks::for_each(&mut squares[..], 64, |i, square| *square = i * i);
/// assert_eq!(squares[999], 999 * 999);
/// ```
pub fn for_each<C: Columns>(columns: C, task: usize, work: impl Fn(usize, C::Item) + Sync) {
    for_each_task(columns.items(), task, columns, &|items, columns: C| {
        for (i, item) in items.zip(columns.each()) {
            work(i, item);
        }
    });
}

/// Joins what `of_task` finds for each task of `task` among `items` items, in order; the default if there are none.
pub fn reduce<T: Default + Send>(
    items: usize,
    task: usize,
    of_task: &(dyn Fn(Range<usize>) -> T + Sync),
    join_both: fn(T, T) -> T,
) -> T {
    reduce_range(0..items, task, of_task, join_both)
}

fn reduce_range<T: Default + Send>(
    items: Range<usize>,
    task: usize,
    of_task: &(dyn Fn(Range<usize>) -> T + Sync),
    join_both: fn(T, T) -> T,
) -> T {
    let Some((first, rest)) = halves(&items, task) else {
        return if items.is_empty() { T::default() } else { of_task(items) };
    };
    let (mut before, mut after) = (T::default(), T::default());
    join(
        || before = reduce_range(first, task, of_task, join_both),
        || after = reduce_range(rest, task, of_task, join_both),
    );
    join_both(before, after)
}

/// The largest `value` of all items, at least 0; those that are not numbers do not count.
pub fn largest(items: usize, task: usize, value: impl Fn(usize) -> f64 + Sync) -> f64 {
    reduce(items, task, &|items| items.map(&value).fold(0.0, f64::max), f64::max)
}

/// Whether `test` holds for any item.
pub fn any(items: usize, task: usize, test: impl Fn(usize) -> bool + Sync) -> bool {
    reduce(items, task, &|mut items| items.any(&test), |a, b| a || b)
}

/// What `find` finds for the first item for which it finds anything.
pub fn first<T: Send>(items: usize, task: usize, find: impl Fn(usize) -> Option<T> + Sync) -> Option<T> {
    reduce(items, task, &|mut items| items.find_map(&find), Option::or)
}

/// `value` of each item, in order.
pub fn map<T: Send>(items: usize, task: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    reduce(items, task, &|items| items.map(&value).collect(), appended)
}

/// All `values` of each item, in order.
pub fn flat_map<T: Send, I: IntoIterator<Item = T>>(
    items: usize,
    task: usize,
    values: impl Fn(usize) -> I + Sync,
) -> Vec<T> {
    reduce(items, task, &|items| items.flat_map(&values).collect(), appended)
}

fn appended<T>(mut first: Vec<T>, mut rest: Vec<T>) -> Vec<T> {
    first.append(&mut rest);
    first
}

/// Runs both, possibly at once.
pub fn join(first: impl FnOnce() + Send, second: impl FnOnce() + Send) {
    let (mut first, mut second) = (Some(first), Some(second));
    join_erased(&mut || run_once(&mut first), &mut || run_once(&mut second));
}

fn run_once(work: &mut Option<impl FnOnce()>) {
    if let Some(work) = work.take() {
        work();
    }
}

/// Never inlined: this is the one copy.
#[inline(never)]
fn join_erased(first: &mut (dyn FnMut() + Send), second: &mut (dyn FnMut() + Send)) {
    rayon::join(first, second);
}

#[cfg(test)]
mod tests {
    use super::*;

    const TASK: usize = 256;
    const COUNTS: [usize; 5] = [0, 1, TASK, TASK + 1, 7 * TASK + 13];

    #[test]
    fn each_item_and_each_task_is_visited_once() {
        for items in COUNTS {
            let (mut each, mut tasks, mut unused) = (vec![0; items], Vec::<u32>::new(), [0_u8; 0]);
            let results = ((&mut each[..], per_task(&mut tasks, items, TASK)), &mut unused[..]);
            for_each_task(items, TASK, results, &|range, ((each, task), unused)| {
                assert_eq!((range.len(), task.0.len(), unused.len()), (each.len(), 1, 0));
                assert_eq!(range.start % TASK, 0);
                each.iter_mut().zip(range).for_each(|(value, i)| *value += i + 1);
                task.0[0] += 1;
            });
            assert!(each.iter().enumerate().all(|(i, value)| *value == i + 1));
            assert!(tasks.len() == items.div_ceil(TASK) && tasks.iter().all(|count| *count == 1));
        }
    }

    #[test]
    fn chosen_groups_are_visited_once_with_their_results() {
        // Groups of 1 to 40 items, and none.
        let sizes: Vec<u32> = (0..60).map(|k| 1 + k * 13 % 40).collect();
        let ends: Vec<u32> = sizes
            .iter()
            .scan(0, |end, size| {
                *end += size;
                Some(*end)
            })
            .collect();
        let items = *ends.last().unwrap() as usize;
        for chosen in [(0..60).collect::<Vec<u32>>(), (0..60).step_by(7).collect(), vec![59], vec![]] {
            let (mut each, mut groups, mut unused) = (vec![0; items], vec![0; sizes.len()], [0_u8; 0]);
            let results = ((&mut each[..], PerTask(&mut groups)), &mut unused[..]);
            for_each_group(&ends, &chosen, 64, results, &|range, ((each, group), _)| {
                assert_eq!((range.len(), group.0.len()), (each.len(), 1));
                each.iter_mut().zip(range).for_each(|(value, i)| *value += i + 1);
                group.0[0] += 1;
            });
            for (k, (end, size)) in ends.iter().zip(&sizes).enumerate() {
                let count = i32::from(chosen.contains(&(k as u32)));
                assert_eq!(groups[k], count);
                let items = (end - size) as usize..*end as usize;
                assert!(items.clone().zip(&each[items]).all(|(i, item)| *item == (i + 1) * count as usize));
            }
        }
    }

    #[test]
    fn columns_are_visited_together() {
        for items in COUNTS {
            let (mut a, mut b, mut c) = (vec![0; items], vec![0.0; items], vec![false; items]);
            for_each(((&mut a[..], &mut b[..]), &mut c[..]), TASK, |i, ((a, b), c)| {
                (*a, *b, *c) = (i, i as f64, i % 2 == 1);
            });
            assert!((0..items).all(|i| a[i] == i && b[i] == i as f64 && c[i] == (i % 2 == 1)));
        }
    }

    #[test]
    fn reductions_meet_those_of_one_thread() {
        for items in COUNTS {
            let value = |i: usize| ((i * 7919) % 1009) as f64 - 3.0;
            let largest_value = (0..items).map(value).fold(0.0, f64::max);
            assert_eq!(largest(items, TASK, value), largest_value);
            for wanted in [0, 255, 256, 1000, 5000] {
                assert_eq!(any(items, TASK, |i| i == wanted), wanted < items);
                let found = first(items, TASK, |i| (i >= wanted).then_some(i));
                assert_eq!(found, (wanted < items).then_some(wanted));
            }
            assert!(map(items, TASK, |i| i).into_iter().eq(0..items));
            let twice = flat_map(items, TASK, |i| [i, i]);
            assert!(twice.into_iter().eq((0..2 * items).map(|k| k / 2)));
        }
    }
}
