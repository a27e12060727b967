//! Sums over particles whose bits do not depend on the number of threads.

use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::space::components::Components;
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

/// Bits of a unit of [`ExactSum`].
const UNIT_BITS: usize = 32;

/// Number of units: exponents from −1074 to 971.
const UNITS: usize = 64;

/// Exponent of the last bit of the smallest number.
const LAST_EXPONENT: i32 = -1074;

/// An exact sum of numbers, which does not depend on their order.
///
/// Each is added as a whole number of one of 64 units, 2^(32 k − 1074): integers lose nothing. A term takes 85 bits of the
/// 127 of a count, which holds 2^42 of them.
///
/// ```
/// let terms = [1e100, 1.0, -1e100, 1e-300];
/// let mut sum = sph::sums::ExactSum::default();
/// terms.iter().for_each(|term| sum.add(*term));
/// assert_eq!(sum.total(), 1.0);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "SparseCounts", into = "SparseCounts")]
pub struct ExactSum {
    /// How many there are of each unit; empty before the first term.
    counts: Vec<i128>,
    /// Whether a term was infinite or no number.
    is_unbounded: bool,
}

/// [`ExactSum`] as it is written: most units are not there.
#[derive(Serialize, Deserialize)]
struct SparseCounts {
    counts: Vec<(u8, i128)>,
    is_unbounded: bool,
}

impl From<ExactSum> for SparseCounts {
    fn from(sum: ExactSum) -> Self {
        let counts = (0..).zip(sum.counts).filter(|(_, count)| *count != 0).collect();
        Self { counts, is_unbounded: sum.is_unbounded }
    }
}

impl From<SparseCounts> for ExactSum {
    fn from(sparse: SparseCounts) -> Self {
        let mut sum = Self { counts: Vec::new(), is_unbounded: sparse.is_unbounded };
        for (unit, count) in sparse.counts {
            sum.add_units(usize::from(unit) % UNITS, count);
        }
        sum
    }
}

impl ExactSum {
    /// Takes all terms out; the memory is kept.
    pub fn clear(&mut self) {
        self.counts.fill(0);
        self.is_unbounded = false;
    }

    /// Adds `term`.
    #[inline]
    pub fn add(&mut self, term: f64) {
        let bits = term.to_bits();
        // The exponent has 11 bits.
        let exponent = (bits >> 52) as usize & 0x7ff;
        let mut mantissa = i128::from(bits & ((1 << 52) - 1));
        if exponent == 0x7ff {
            self.is_unbounded = true;
            return;
        }
        let mut shift = 0;
        if exponent > 0 {
            mantissa |= 1 << 52;
            shift = exponent - 1;
        }
        if mantissa != 0 {
            let count = mantissa << (shift % UNIT_BITS);
            // At most 2045 / 32.
            self.add_units(shift / UNIT_BITS, if term < 0.0 { -count } else { count });
        }
    }

    #[inline]
    fn add_units(&mut self, unit: usize, count: i128) {
        if self.counts.is_empty() {
            self.counts.resize(UNITS, 0);
        }
        self.counts[unit] += count;
    }

    /// Adds all terms of `other`.
    pub fn merge(&mut self, other: &Self) {
        self.is_unbounded |= other.is_unbounded;
        other.counts.iter().enumerate().for_each(|(unit, count)| self.add_units(unit, *count));
    }

    /// The sum, to its last bit or two; NaN where a term was infinite or no number.
    pub fn total(&self) -> f64 {
        if self.is_unbounded {
            return f64::NAN;
        }
        // Digits to the base 2^32: the last one has the sign, and no other is negative.
        let mut digits = [0; UNITS];
        let mut carry = 0;
        for (digit, count) in digits.iter_mut().zip(&self.counts) {
            carry += count;
            *digit = carry & i128::from(u32::MAX);
            carry >>= UNIT_BITS;
        }
        // The largest first, as far as they show.
        let sum = in_units(carry, self.counts.len());
        (0..self.counts.len()).rev().fold(sum, |sum, unit| sum + in_units(digits[unit], unit))
    }
}

/// `count` times the unit of number `unit`.
fn in_units(count: i128, unit: usize) -> f64 {
    if count == 0 {
        return 0.0;
    }
    // Two factors: the smallest unit itself is no normal number.
    let exponent = (unit * UNIT_BITS) as i32 + LAST_EXPONENT;
    let half = exponent / 2;
    count as f64 * 2.0_f64.powi(half) * 2.0_f64.powi(exponent - half)
}

/// A value of some numbers.
pub trait Numbers {
    /// Calls `visit` for each number, always in the same order.
    fn each(&mut self, visit: &mut dyn FnMut(&mut f64));
}

/// Calls `visit` for each component of `quantity`.
pub fn each_of<C: Components>(quantity: &mut C, visit: &mut dyn FnMut(&mut f64)) {
    let mut row = quantity.row();
    row.as_mut().iter_mut().for_each(visit);
    *quantity = C::from_row(row);
}

/// Exact sums of values, number by number: see [`ExactSum`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ExactSums(Vec<ExactSum>);

impl ExactSums {
    /// Takes all values out; the memory is kept.
    pub fn clear(&mut self) {
        self.0.iter_mut().for_each(ExactSum::clear);
    }

    /// Adds `value`.
    pub fn add(&mut self, mut value: impl Numbers) {
        let mut number = 0;
        value.each(&mut |term| {
            self.of(number).add(*term);
            number += 1;
        });
    }

    fn of(&mut self, number: usize) -> &mut ExactSum {
        while self.0.len() <= number {
            // All memory that it will take, so that a steady step asks for none.
            self.0.push(ExactSum { counts: vec![0; UNITS], is_unbounded: false });
        }
        &mut self.0[number]
    }

    /// Adds all values of `other`.
    pub fn merge(&mut self, other: &Self) {
        other.0.iter().enumerate().for_each(|(number, sum)| self.of(number).merge(sum));
    }

    /// The sums, written over the numbers of `value`.
    pub fn total<T: Numbers>(&self, mut value: T) -> T {
        let mut sums = self.0.iter();
        value.each(&mut |number| *number = sums.next().map_or(0.0, ExactSum::total));
        value
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

    /// Numbers of all sizes and both signs, each with its negative but for the last three.
    fn terms() -> Vec<f64> {
        let term = |k: i32| (f64::from(k) * 0.7).sin() * 10f64.powi(k * 37 % 600 - 300);
        let mut terms: Vec<f64> = (0..200).map(term).collect();
        terms.extend((0..200).map(|k| -term(k)));
        terms.extend([f64::MIN_POSITIVE / 8.0, 2.5, 1e-17]);
        terms
    }

    #[test]
    fn an_exact_sum_loses_nothing_and_does_not_depend_on_the_order() {
        let terms = terms();
        let sum = |terms: &mut dyn Iterator<Item = f64>| {
            let mut sum = ExactSum::default();
            terms.for_each(|term| sum.add(term));
            sum
        };
        let expected = sum(&mut terms.iter().copied());
        // The nearest number to 2.5 + 1e-17.
        assert_eq!(expected.total(), 2.5);
        for step in [7, 29, 101] {
            let shuffled = sum(&mut (0..terms.len()).map(|k| terms[k * step % terms.len()]));
            assert_eq!(shuffled.total().to_bits(), expected.total().to_bits());
            let (first, rest) = terms.split_at(step);
            let mut merged = sum(&mut rest.iter().copied());
            merged.merge(&sum(&mut first.iter().copied()));
            assert_eq!(merged.total().to_bits(), expected.total().to_bits());
        }
    }

    #[test]
    fn totals_are_right_to_the_last_bits() {
        for terms in [
            vec![],
            vec![-0.75],
            vec![f64::MAX, -f64::MAX, -1e-300],
            vec![1.0, f64::EPSILON],
            vec![-1.0, -f64::EPSILON],
            vec![f64::MIN_POSITIVE, -f64::MIN_POSITIVE / 2.0],
            vec![1e16, 1.0, -1e16],
            vec![-3.0; 1000],
        ] {
            let mut sum = ExactSum::default();
            terms.iter().for_each(|term| sum.add(*term));
            // From the largest to the smallest, these sums round nothing that shows.
            let expected: f64 = terms.iter().sum();
            let exact = if terms.first() == Some(&1e16) { 1.0 } else { expected };
            assert!(
                (sum.total() - exact).abs() <= 2.0 * f64::EPSILON * exact.abs(),
                "{terms:?} {}",
                sum.total()
            );
        }
        let mut sum = ExactSum::default();
        [1.0, f64::INFINITY].into_iter().for_each(|term| sum.add(term));
        assert!(sum.total().is_nan());
    }
}
