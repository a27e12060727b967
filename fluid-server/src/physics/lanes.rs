//! Several neighbours at a time.

use std::ops::{Add, AddAssign, Div, Mul, Sub, SubAssign};

use wide::f64x4;

/// Neighbours handled together. It decides the grouping of every sum over neighbours and so its last bits.
pub const LANES: usize = 4;

/// How sums over neighbours are made, for the handshake: `LANES` at a time.
pub const ARITHMETIC: &str = "f64x4";

/// One number per neighbour of a batch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lanes(f64x4);

impl Lanes {
    /// `value` in every lane.
    #[inline(always)]
    pub fn splat(value: f64) -> Self {
        Self(f64x4::splat(value))
    }

    /// `value(l)` in lane `l`.
    #[inline(always)]
    pub fn from_fn(value: impl FnMut(usize) -> f64) -> Self {
        Self(f64x4::new(std::array::from_fn(value)))
    }

    /// Square root.
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    /// The larger of each lane and `floor`; NaN may give either.
    #[inline(always)]
    pub fn at_least(self, floor: f64) -> Self {
        Self(self.0.fast_max(f64x4::splat(floor)))
    }

    /// The smaller of each lane and `ceiling`; NaN may give either.
    #[inline(always)]
    pub fn at_most(self, ceiling: f64) -> Self {
        Self(self.0.fast_min(f64x4::splat(ceiling)))
    }

    /// Lanes beyond ±`half` shifted by `period` toward zero.
    #[inline(always)]
    pub fn wrapped(self, half: f64, period: f64) -> Self {
        let (d, half, period) = (self.0, f64x4::splat(half), f64x4::splat(period));
        let shifted = d.simd_gt(half).select(d - period, d);
        Self(d.simd_lt(-half).select(d + period, shifted))
    }

    /// The lanes as an array.
    #[inline(always)]
    pub fn to_array(self) -> [f64; LANES] {
        self.0.to_array()
    }

    /// Sum over the lanes, in the same order whatever the machine.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        let [a, b, c, d] = self.0.to_array();
        (a + b) + (c + d)
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl Mul<Lanes> for f64 {
    type Output = Lanes;
    #[inline(always)]
    fn mul(self, other: Lanes) -> Lanes {
        Lanes(f64x4::splat(self) * other.0)
    }
}

impl Div for Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Lanes {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
