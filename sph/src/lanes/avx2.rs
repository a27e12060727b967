//! Lanes in AVX2 registers, with fused multiply-add. The only `unsafe` of this crate.
//!
//! Two things need it. Intrinsics are executed outside a function compiled for AVX2, as the operators of [`Avx2`] are
//! by themselves: sound because the type is private to [`super`] and reaches a kernel only through [`run`]. And `run`
//! calls a function compiled for AVX2: sound because `Arithmetic` holds this path only where [`available`] says so.

#![allow(unsafe_code)]

use std::arch::x86_64::{
    __m256d, _CMP_LT_OQ, _mm_loadu_pd, _mm256_add_pd, _mm256_blendv_pd, _mm256_castpd128_pd256,
    _mm256_cmp_pd, _mm256_div_pd, _mm256_fmadd_pd, _mm256_fnmadd_pd, _mm256_hadd_pd, _mm256_insertf128_pd,
    _mm256_loadu_pd, _mm256_max_pd, _mm256_min_pd, _mm256_movemask_pd, _mm256_mul_pd, _mm256_permute2f128_pd,
    _mm256_set1_pd, _mm256_setzero_pd, _mm256_sqrt_pd, _mm256_storeu_pd, _mm256_sub_pd, _mm256_unpackhi_pd,
    _mm256_unpacklo_pd,
};
use std::ops::{Add, Div, Mul, Sub};

use super::{LanePass, Lanes, Real, WIDTH};

/// Whether this processor has AVX2 and FMA.
pub fn available() -> bool {
    std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
}

/// Executes `kernel` with AVX2 and FMA, which the caller has found [`available`].
#[inline]
pub fn run<K: LanePass>(kernel: K) -> K::Output {
    debug_assert!(available());
    // SAFETY: see the module's description.
    unsafe { compiled(kernel) }
}

#[target_feature(enable = "avx2,fma")]
fn compiled<K: LanePass>(kernel: K) -> K::Output {
    kernel.run::<Avx2>()
}

/// Lanes in one register.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(__m256d);

// SAFETY of all that follows: see the module's description; the loads and stores take arrays of the register's size.

impl Add for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(unsafe { _mm256_add_pd(self.0, other.0) })
    }
}

impl Sub for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(unsafe { _mm256_sub_pd(self.0, other.0) })
    }
}

impl Mul for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(unsafe { _mm256_mul_pd(self.0, other.0) })
    }
}

impl Div for Avx2 {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(unsafe { _mm256_div_pd(self.0, other.0) })
    }
}

/// Both rows in one register.
#[inline(always)]
fn two_pairs(low: &[f64; 2], high: &[f64; 2]) -> __m256d {
    unsafe {
        let (low, high) = (_mm_loadu_pd(low.as_ptr()), _mm_loadu_pd(high.as_ptr()));
        _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(low), high)
    }
}

/// The first and the last two numbers of a row.
#[inline(always)]
fn split(row: &[f64; 4]) -> [&[f64; 2]; 2] {
    let [low, high] = row.as_chunks::<2>().0 else { unreachable!("four numbers are two pairs") };
    [low, high]
}

impl Real for Avx2 {
    #[inline(always)]
    fn zero() -> Self {
        Self(unsafe { _mm256_setzero_pd() })
    }

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(unsafe { _mm256_set1_pd(value) })
    }

    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        Self(unsafe { _mm256_fmadd_pd(a.0, b.0, self.0) })
    }

    #[inline(always)]
    fn minus_product(self, a: Self, b: Self) -> Self {
        Self(unsafe { _mm256_fnmadd_pd(a.0, b.0, self.0) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm256_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(unsafe { _mm256_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(unsafe { _mm256_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn choose_below(self, limit: Self, yes: Self, no: Self) -> Self {
        Self(unsafe { _mm256_blendv_pd(no.0, yes.0, _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, limit.0)) })
    }
}

impl Lanes for Avx2 {
    #[inline(always)]
    fn from_array(values: [f64; WIDTH]) -> Self {
        Self(unsafe { _mm256_loadu_pd(values.as_ptr()) })
    }

    #[inline(always)]
    fn to_array(self) -> [f64; WIDTH] {
        let mut values = [0.0; WIDTH];
        unsafe { _mm256_storeu_pd(values.as_mut_ptr(), self.0) };
        values
    }

    #[inline(always)]
    fn below(self, other: Self) -> u8 {
        // Four bits, one for each lane.
        (unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0)) }) as u8
    }

    #[inline(always)]
    fn columns(rows: [&[f64; 4]; WIDTH]) -> [Self; 4] {
        let [[a, a_high], [b, b_high], [c, c_high], [d, d_high]] = rows.map(split);
        let (even, odd) = (two_pairs(a, c), two_pairs(b, d));
        let (even_high, odd_high) = (two_pairs(a_high, c_high), two_pairs(b_high, d_high));
        unsafe {
            [
                Self(_mm256_unpacklo_pd(even, odd)),
                Self(_mm256_unpackhi_pd(even, odd)),
                Self(_mm256_unpacklo_pd(even_high, odd_high)),
                Self(_mm256_unpackhi_pd(even_high, odd_high)),
            ]
        }
    }

    #[inline(always)]
    fn halves(rows: [&[f64; 2]; WIDTH]) -> [Self; 2] {
        let [a, b, c, d] = rows;
        let (even, odd) = (two_pairs(a, c), two_pairs(b, d));
        unsafe { [Self(_mm256_unpacklo_pd(even, odd)), Self(_mm256_unpackhi_pd(even, odd))] }
    }

    #[inline(always)]
    fn sums(values: [Self; 4]) -> [f64; 4] {
        let [a, b, c, d] = values;
        unsafe {
            // (a₀+a₁, b₀+b₁, a₂+a₃, b₂+b₃) and the same of c and d.
            let (ab, cd) = (_mm256_hadd_pd(a.0, b.0), _mm256_hadd_pd(c.0, d.0));
            let low = _mm256_permute2f128_pd::<0x20>(ab, cd);
            let high = _mm256_permute2f128_pd::<0x31>(ab, cd);
            Self(_mm256_add_pd(low, high)).to_array()
        }
    }
}
