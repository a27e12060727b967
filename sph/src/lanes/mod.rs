//! Four particles at a time: arithmetic on lanes, and the choice of instructions at run time.
//!
//! A pass over pairs is a [`LanePass`], written once for any [`Lanes`]; [`Arithmetic::run`] executes it with the
//! instructions of one arithmetic path. Each path gives the same bits wherever and on however many threads it runs;
//! two paths differ in round-off, since one of them fuses products with sums.

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Sub};
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

#[cfg(target_arch = "x86_64")]
mod avx2;
mod portable;
mod scalar;

#[cfg(test)]
mod tests;

/// Number of lanes.
pub const WIDTH: usize = 4;

/// A real number, or one for each of [`WIDTH`] particles: what laws are written over.
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// Zero.
    fn zero() -> Self;

    /// `value`, in each lane.
    fn splat(value: f64) -> Self;

    /// Four numbers, each in all lanes of a result.
    #[inline(always)]
    fn splat_each([a, b, c, d]: [f64; 4]) -> [Self; 4] {
        [Self::splat(a), Self::splat(b), Self::splat(c), Self::splat(d)]
    }

    /// `self + a·b`, rounded once where the path fuses.
    fn plus_product(self, a: Self, b: Self) -> Self;

    /// `self − a·b`, rounded once where the path fuses.
    fn minus_product(self, a: Self, b: Self) -> Self;

    /// Square root.
    fn sqrt(self) -> Self;

    /// The larger of `self` and `other`; `other` where one of them is NaN.
    fn max(self, other: Self) -> Self;

    /// The smaller of `self` and `other`; `other` where one of them is NaN.
    fn min(self, other: Self) -> Self;

    /// `yes` where `self` is below `limit`, else `no`.
    fn choose_below(self, limit: Self, yes: Self, no: Self) -> Self;
}

/// One number for each of [`WIDTH`] particles.
pub trait Lanes: Real {
    /// The numbers of an array.
    fn from_array(values: [f64; WIDTH]) -> Self;

    /// The lanes as an array.
    fn to_array(self) -> [f64; WIDTH];

    /// Bit l is set where lane l of `self` is below that of `other`.
    fn below(self, other: Self) -> u8;

    /// Transposes: lane l of result k is `rows[l][k]`.
    fn columns(rows: [&[f64; 4]; WIDTH]) -> [Self; 4];

    /// Transposes: lane l of result k is `rows[l][k]`.
    fn halves(rows: [&[f64; 2]; WIDTH]) -> [Self; 2];

    /// Sum over the lanes of each value: (0 + 1) + (2 + 3).
    fn sums(values: [Self; 4]) -> [f64; 4];
}

/// Work that [`Arithmetic::run`] executes; `run` and what it calls must be `#[inline(always)]`, so that all of it is
/// compiled for the instructions of the path. A closure that computes with lanes is many times slower where it happens
/// not to be inlined: such are loops and functions instead.
pub trait LanePass {
    /// Result.
    type Output;

    /// Does the work.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// How numbers are computed: decides the last bits of every sum over neighbours.
///
/// A value exists only for a path that this machine can execute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arithmetic(Path);

/// An arithmetic path by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Path {
    /// Products and sums are rounded one by one, by instructions that every machine has.
    Portable,
    /// AVX2 instructions of x86-64 with fused multiply-add.
    Avx2,
}

/// What the command line says, for the whole process: which instructions it executes is no matter of a run.
static FORCED: OnceLock<Arithmetic> = OnceLock::new();

/// Makes this process take `path` for every solver that it makes from now on.
///
/// # Errors
/// When this machine can not execute it, or another one was forced before.
pub fn force(path: Path) -> Result<(), String> {
    let wanted = Arithmetic::of(path)?;
    let set = *FORCED.get_or_init(|| wanted);
    if set == wanted {
        Ok(())
    } else {
        Err(format!("arithmetic `{path}` comes too late: this process takes `{}`", set.0))
    }
}

/// The path that was forced on this process.
pub fn forced() -> Option<Path> {
    FORCED.get().map(|arithmetic| arithmetic.0)
}

impl Path {
    /// All paths, the fastest first.
    pub const ALL: [Self; 2] = [Self::Avx2, Self::Portable];

    /// Name in the handshake, the run header and checkpoints.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "f64x4-portable",
            Self::Avx2 => "f64x4-avx2-fma",
        }
    }

    /// The path of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|path| path.name() == name)
    }

    /// Name as an option of a program.
    pub fn option(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
        }
    }
}

impl std::str::FromStr for Path {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Self::ALL
            .into_iter()
            .find(|path| path.option() == text)
            .ok_or_else(|| format!("arithmetic `{text}` is unknown; choose `portable` or `avx2`"))
    }
}

impl std::fmt::Display for Path {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.option())
    }
}

impl Arithmetic {
    /// The fastest path of this machine.
    pub fn best() -> Self {
        Path::ALL.into_iter().find_map(|path| Self::of(path).ok()).unwrap_or(Self(Path::Portable))
    }

    /// The given path.
    ///
    /// # Errors
    /// When this machine can not execute it.
    pub fn of(path: Path) -> Result<Self, String> {
        let available = match path {
            Path::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Path::Avx2 => avx2::available(),
            #[cfg(not(target_arch = "x86_64"))]
            Path::Avx2 => false,
        };
        if available {
            Ok(Self(path))
        } else {
            Err(format!(
                "arithmetic `{path}` needs a processor with AVX2 and FMA, which this machine lacks; choose `portable`"
            ))
        }
    }

    /// The path that was forced on this process, or else the fastest of this machine.
    pub fn chosen() -> Self {
        FORCED.get().copied().unwrap_or_else(Self::best)
    }

    /// All paths of this machine.
    pub fn all() -> impl Iterator<Item = Self> {
        Path::ALL.into_iter().filter_map(|path| Self::of(path).ok())
    }

    /// Name in the handshake, the run header and checkpoints.
    pub fn name(self) -> &'static str {
        self.0.name()
    }

    /// Executes `kernel`.
    #[inline]
    pub fn run<K: LanePass>(self, kernel: K) -> K::Output {
        match self.0 {
            Path::Portable => kernel.run::<portable::Portable>(),
            #[cfg(target_arch = "x86_64")]
            Path::Avx2 => avx2::run(kernel),
            #[cfg(not(target_arch = "x86_64"))]
            Path::Avx2 => kernel.run::<portable::Portable>(),
        }
    }
}
