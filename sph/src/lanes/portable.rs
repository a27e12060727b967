//! Lanes as plain arrays, for any machine.

use std::ops::{Add, Div, Mul, Sub};

use super::{Lanes, Real, WIDTH};

/// Lanes as an array.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Portable([f64; WIDTH]);

impl Portable {
    #[inline(always)]
    fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let ([a, b, c, d], [e, g, h, i]) = (self.0, other.0);
        Self([f(a, e), f(b, g), f(c, h), f(d, i)])
    }
}

impl Add for Portable {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.map2(other, |a, b| a + b)
    }
}

impl Sub for Portable {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.map2(other, |a, b| a - b)
    }
}

impl Mul for Portable {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.map2(other, |a, b| a * b)
    }
}

impl Div for Portable {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.map2(other, |a, b| a / b)
    }
}

impl Real for Portable {
    #[inline(always)]
    fn zero() -> Self {
        Self([0.0; WIDTH])
    }

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; WIDTH])
    }

    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        self + a * b
    }

    #[inline(always)]
    fn minus_product(self, a: Self, b: Self) -> Self {
        self - a * b
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([a.sqrt(), b.sqrt(), c.sqrt(), d.sqrt()])
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.map2(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.map2(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn choose_below(self, limit: Self, yes: Self, no: Self) -> Self {
        let lane = |l: usize| if self.0[l] < limit.0[l] { yes.0[l] } else { no.0[l] };
        Self([lane(0), lane(1), lane(2), lane(3)])
    }
}

impl Lanes for Portable {
    #[inline(always)]
    fn from_array(values: [f64; WIDTH]) -> Self {
        Self(values)
    }

    #[inline(always)]
    fn to_array(self) -> [f64; WIDTH] {
        self.0
    }

    #[inline(always)]
    fn below(self, other: Self) -> u8 {
        let bit = |l: usize| u8::from(self.0[l] < other.0[l]) << l;
        bit(0) | bit(1) | bit(2) | bit(3)
    }

    #[inline(always)]
    fn columns(rows: [&[f64; 4]; WIDTH]) -> [Self; 4] {
        let [a, b, c, d] = rows;
        let column = |k: usize| Self([a[k], b[k], c[k], d[k]]);
        [column(0), column(1), column(2), column(3)]
    }

    #[inline(always)]
    fn halves(rows: [&[f64; 2]; WIDTH]) -> [Self; 2] {
        let [a, b, c, d] = rows;
        [0, 1].map(|k| Self([a[k], b[k], c[k], d[k]]))
    }

    #[inline(always)]
    fn sums(values: [Self; 4]) -> [f64; 4] {
        values.map(|Self([a, b, c, d])| (a + b) + (c + d))
    }
}
