//! Sums over particles whose bits do not depend on the number of threads.

use std::ops::AddAssign;

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
}
