//! Four particles at a time of arrays that hold a value for each: passes over particles without neighbours.
//!
//! Where fewer than four are left, the last one fills the lanes; [`weight`] keeps it from counting twice.

use sph::lanes::{Lanes, WIDTH};
use sph::space::Space;

/// Values `first` and following.
#[inline(always)]
pub fn get<T: Copy>(values: &[T], first: usize) -> [T; WIDTH] {
    match values[first..].first_chunk() {
        Some(four) => *four,
        None => std::array::from_fn(|lane| values[(first + lane).min(values.len() - 1)]),
    }
}

/// Replaces values `first` and following, as many as there are.
#[inline(always)]
pub fn put<T: Copy>(values: &mut [T], first: usize, new: [T; WIDTH]) {
    match values[first..].first_chunk_mut() {
        Some(place) => *place = new,
        None => values[first..].iter_mut().zip(new).for_each(|(place, new)| *place = new),
    }
}

/// Numbers `first` and following.
#[inline(always)]
pub fn numbers<L: Lanes>(values: &[f64], first: usize) -> L {
    L::from_array(get(values, first))
}

/// Components of vectors `first` and following.
#[inline(always)]
pub fn vectors<S: Space, L: Lanes>(values: &[S::Vector], first: usize) -> S::Of<L> {
    S::lanes(get(values, first).each_ref())
}

/// Transposes: number k of row l is lane l of column k.
#[inline(always)]
pub fn rows<L: Lanes>([a, b, c, d]: [L; 4]) -> [[f64; 4]; WIDTH] {
    let [a, b, c, d] = L::columns([&a.to_array(), &b.to_array(), &c.to_array(), &d.to_array()]);
    [a.to_array(), b.to_array(), c.to_array(), d.to_array()]
}

/// One for each of the particles from `first` on, of `count` in all, zero in lanes beyond.
#[inline(always)]
pub fn weight<L: Lanes>(first: usize, count: usize) -> L {
    if first + WIDTH <= count {
        return L::splat(1.0);
    }
    L::from_array(std::array::from_fn(|lane| if first + lane < count { 1.0 } else { 0.0 }))
}

/// |x|; NaN stays.
#[inline(always)]
pub fn abs<L: Lanes>(x: L) -> L {
    x.max(L::zero() - x)
}

/// The largest of the lanes that are numbers, and of zero.
#[inline(always)]
pub fn largest<L: Lanes>(values: L) -> f64 {
    values.to_array().into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use sph::lanes::{Arithmetic, LanePass};
    use sph::space::{Plane, Vector};

    use super::*;

    /// Doubles numbers and swaps the components of vectors, four at a time.
    struct Passes<'a>(&'a mut [f64], &'a mut [Vector]);

    impl LanePass for Passes<'_> {
        type Output = f64;

        #[inline(always)]
        fn run<L: Lanes>(self) -> f64 {
            let Self(numbers_of, vectors_of) = self;
            let (count, mut sum) = (numbers_of.len(), L::zero());
            for first in (0..count).step_by(WIDTH) {
                let value = numbers::<L>(numbers_of, first);
                sum = sum + value * weight(first, count);
                let [x, y] = vectors::<Plane, L>(vectors_of, first);
                put(numbers_of, first, (value + value).to_array());
                let rows = rows([y, x, value, value]);
                put(vectors_of, first, rows.map(|[x, y, ..]| Vector::new(x, y)));
            }
            sum.to_array().iter().sum()
        }
    }

    #[test]
    fn each_value_is_read_and_replaced_once_however_many_there_are() {
        for (arithmetic, count) in Arithmetic::all().flat_map(|path| (1..=9).map(move |count| (path, count)))
        {
            let mut numbers: Vec<f64> = (1..=count).map(f64::from).collect();
            let mut vectors: Vec<Vector> = numbers.iter().map(|n| Vector::new(*n, -n)).collect();
            let sum = arithmetic.run(Passes(&mut numbers, &mut vectors));
            assert_eq!(sum, f64::from(count * (count + 1) / 2));
            for (k, (number, vector)) in (1..=count).map(f64::from).zip(numbers.iter().zip(&vectors)) {
                assert_eq!((*number, *vector), (2.0 * k, Vector::new(-k, k)));
            }
        }
    }
}
