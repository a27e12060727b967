//! Sums over particles whose bits do not depend on the number of threads.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::tasks::for_each;

/// Particles per partial sum: fixed, so that the grouping of a sum never changes.
const CHUNK: usize = 2048;

/// Σ_i `term(i)` for i in 0..n: partial sums over fixed chunks in parallel, then added in order.
///
/// ```
/// let sum: f64 = sph::sums::ordered_sum(5000, |i| 1.0 / (1.0 + i as f64));
/// assert!((sum - 9.0945).abs() < 1e-4);
/// ```
pub fn ordered_sum<T, F>(n: usize, term: F) -> T
where
    T: Default + AddAssign + Send,
    F: Fn(usize) -> T + Sync,
{
    let partial = |chunk: usize| {
        let mut sum = T::default();
        for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(n) {
            sum += term(i);
        }
        sum
    };
    let chunks = n.div_ceil(CHUNK);
    let mut total = T::default();
    if chunks <= 1 {
        total += partial(0);
        return total;
    }
    let mut partials: Vec<T> = std::iter::repeat_with(T::default).take(chunks).collect();
    for_each(&mut partials[..], 1, |chunk, sum| *sum = partial(chunk));
    for sum in partials {
        total += sum;
    }
    total
}

/// The sum of `values` of tasks from the first on, added in pairs as [`PairwiseSums`] are. Allocates nothing.
pub fn pairwise_sum<T: Clone + Default + AddAssign>(values: &[T]) -> T {
    match values {
        [] => T::default(),
        [value] => value.clone(),
        _ => {
            let (pairs, rest) = values.split_at(values.len().next_power_of_two() / 2);
            let mut sum = pairwise_sum(pairs);
            sum += pairwise_sum(rest);
            sum
        }
    }
}

/// Sums over tasks that follow each other, added in pairs: those of tasks 2k and 2k + 1, then of pairs, and so on.
///
/// What is added to what follows from the numbers of the tasks alone. Parts of the particles that hold whole tasks can
/// add theirs apart and join the sums afterwards, with the bits of one sum over all.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PairwiseSums<T> {
    /// Sums that have no other of their level to be added to yet, in the order of the tasks.
    open: Vec<Partial<T>>,
}

/// The sum over the tasks from `number` · 2^`level` on, 2^`level` of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Partial<T> {
    level: u32,
    number: u64,
    sum: T,
}

impl<T> Default for PairwiseSums<T> {
    fn default() -> Self {
        Self { open: Vec::new() }
    }
}

impl<T: Default + AddAssign> PairwiseSums<T> {
    /// Of the `sums` of tasks, the first of which has the number `first`.
    pub fn of(first: usize, sums: impl IntoIterator<Item = T>) -> Self {
        let mut all = Self::default();
        for (number, sum) in (first as u64..).zip(sums) {
            all.push(Partial { level: 0, number, sum });
        }
        all
    }

    /// Joins the sums over the tasks that follow those of `self`.
    pub fn join(&mut self, following: Self) {
        following.open.into_iter().for_each(|partial| self.push(partial));
    }

    fn push(&mut self, mut partial: Partial<T>) {
        while let Some(before) = self.open.pop_if(|before| {
            before.level == partial.level && before.number + 1 == partial.number && partial.number % 2 == 1
        }) {
            let Partial { level, number, mut sum } = before;
            sum += partial.sum;
            partial = Partial { level: level + 1, number: number / 2, sum };
        }
        self.open.push(partial);
    }

    /// The sum over all tasks.
    pub fn total(self) -> T {
        let mut partials = self.open.into_iter().rev();
        let Some(Partial { sum: mut total, .. }) = partials.next() else { return T::default() };
        for Partial { mut sum, .. } in partials {
            sum += total;
            total = sum;
        }
        total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_has_the_same_bits_on_any_number_of_threads() {
        let term = |i: usize| (i as f64 * 0.7).sin() * 10f64.powi((i % 30) as i32 - 15);
        let sums: Vec<u64> = [1, 2, 4]
            .into_iter()
            .map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| ordered_sum::<f64, _>(100_001, term)).to_bits()
            })
            .collect();
        assert!(sums.iter().all(|bits| *bits == sums[0]), "{sums:?}");
    }

    #[test]
    fn nothing_sums_to_nothing() {
        assert_eq!(ordered_sum::<f64, _>(0, |_| 1.0), 0.0);
    }

    #[test]
    fn sums_of_parts_join_to_the_bits_of_one_sum() {
        for tasks in [0, 1, 2, 3, 7, 8, 9, 64, 100] {
            let value = |k: usize| (k as f64 * 0.7).sin() * 10f64.powi((k % 30) as i32 - 15);
            let values: Vec<f64> = (0..tasks).map(value).collect();
            let all = pairwise_sum(&values);
            let (plain, scale) =
                (values.iter().sum::<f64>(), values.iter().map(|value| value.abs()).sum::<f64>());
            // Each addition rounds a sum that is at most `scale`.
            assert!((all - plain).abs() <= f64::EPSILON * tasks as f64 * scale, "{all} {plain}");
            assert_eq!(PairwiseSums::of(0, values.iter().copied()).total().to_bits(), all.to_bits());
            for cuts in [[0, 0], [0, 1], [1, 2], [3, 3], [5, 6], [7, 63]] {
                let [a, b] = cuts.map(|cut: usize| cut.min(tasks));
                let mut joined = PairwiseSums::default();
                for part in [0..a, a..b, b..tasks] {
                    joined.join(PairwiseSums::of(part.start, part.map(value)));
                }
                assert_eq!(joined.total().to_bits(), all.to_bits(), "{tasks} tasks cut at {a} and {b}");
            }
        }
    }
}
