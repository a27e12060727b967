//! The layout in which pair sums read particles.

use std::fmt::Debug;

use sph::lanes::{Lanes, WIDTH};
use sph::space::{Plane, Space, Vector};

use super::lane_arrays::rows;
use super::thresholds::Thresholds;

/// A space with a fluid in it.
pub trait FluidSpace: Thresholds {
    /// State of a particle as pair sums read it.
    type Particle: Packed<Self>;
    /// Results of the gradient pass as neighbours read them.
    type Fields: NeighbourFields<Self>;
}

impl FluidSpace for Plane {
    type Particle = PackedParticle;
    type Fields = [f64; 4];
}

/// State of a particle as pair sums read it.
pub trait Packed<S: Space>: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// A particle; one of zero `volume` does not act.
    fn new(position: &S::Vector, velocity: &S::Vector, density: f64, pressure: f64, volume: f64) -> Self;

    /// Four particles.
    fn pack<L: Lanes>(particles: LaneParticles<S, L>) -> [Self; WIDTH];

    /// Four particles.
    fn lanes<L: Lanes>(particles: [&Self; WIDTH]) -> LaneParticles<S, L>;

    /// Position and velocity in each lane.
    fn splat_motion<L: Lanes>(&self) -> LaneMotion<S, L>;

    /// Position \[m\].
    fn position(&self) -> S::Vector;

    /// Velocity \[m/s\].
    fn velocity(&self) -> S::Vector;

    /// Density ρ \[kg/m³\].
    fn density(&self) -> f64;

    /// Pressure p \[Pa\], without damper.
    fn pressure(&self) -> f64;

    /// Volume V = m/ρ, in the plane per depth \[m²\]; zero for a particle that does not act.
    fn volume(&self) -> f64;
}

/// Results of the gradient pass as neighbours read them.
pub trait NeighbourFields<S: Space>: Copy + Debug + Default + Send + Sync + 'static {
    /// Pressure q of the acoustic damper \[Pa\], smallest eigenvalue of the moment matrix \[-\], ∇ρ of Eq. (20) \[kg/m⁴\].
    fn new(damper: f64, eigenvalue: f64, density_gradient: S::Of<f64>) -> Self;

    /// Those of four particles: damper, eigenvalue and ∇ρ.
    fn lanes<L: Lanes>(fields: [&Self; WIDTH]) -> (L, L, S::Of<L>);

    /// Pressure q of the acoustic damper \[Pa\].
    fn damper(&self) -> f64;

    /// Smallest eigenvalue of the moment matrix \[-\]; 0 without particle regularisation.
    fn eigenvalue(&self) -> f64;

    /// ∇ρ of Eq. (20) \[kg/m⁴\].
    fn density_gradient(&self) -> S::Of<f64>;
}

/// Position \[m\] and velocity \[m/s\] for each lane.
#[derive(Clone, Copy, Debug)]
pub struct LaneMotion<S: Space, L: Lanes> {
    /// Position x \[m\].
    pub x: S::Of<L>,
    /// Velocity v \[m/s\].
    pub v: S::Of<L>,
}

/// A particle for each lane.
#[derive(Clone, Copy, Debug)]
pub struct LaneParticles<S: Space, L: Lanes> {
    /// Position and velocity.
    pub motion: LaneMotion<S, L>,
    /// Density ρ \[kg/m³\].
    pub density: L,
    /// Pressure p \[Pa\].
    pub pressure: L,
    /// Volume V, in the plane per depth \[m²\].
    pub volume: L,
}

/// A particle in the plane: one cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct PackedParticle {
    /// x, y \[m\], v_x, v_y \[m/s\].
    motion: [f64; 4],
    /// ρ \[kg/m³\], p \[Pa\], V \[m²\], unused.
    matter: [f64; 4],
}

impl Packed<Plane> for PackedParticle {
    #[inline(always)]
    fn new(position: &Vector, velocity: &Vector, density: f64, pressure: f64, volume: f64) -> Self {
        Self {
            motion: [position.x, position.y, velocity.x, velocity.y],
            matter: [density, pressure, volume, 0.0],
        }
    }

    #[inline(always)]
    fn pack<L: Lanes>(particles: LaneParticles<Plane, L>) -> [Self; WIDTH] {
        let LaneParticles { motion: LaneMotion { x: [x, y], v: [v_x, v_y] }, density, pressure, volume } =
            particles;
        let [a, b, c, d] = rows([x, y, v_x, v_y]);
        let [m_a, m_b, m_c, m_d] = rows([density, pressure, volume, L::zero()]);
        let particle = |motion, matter| Self { motion, matter };
        [particle(a, m_a), particle(b, m_b), particle(c, m_c), particle(d, m_d)]
    }

    #[inline(always)]
    fn lanes<L: Lanes>([a, b, c, d]: [&Self; WIDTH]) -> LaneParticles<Plane, L> {
        let [x, y, v_x, v_y] = L::columns([&a.motion, &b.motion, &c.motion, &d.motion]);
        let [density, pressure, volume, _] = L::columns([&a.matter, &b.matter, &c.matter, &d.matter]);
        LaneParticles { motion: LaneMotion { x: [x, y], v: [v_x, v_y] }, density, pressure, volume }
    }

    #[inline(always)]
    fn splat_motion<L: Lanes>(&self) -> LaneMotion<Plane, L> {
        let [x, y, v_x, v_y] = L::splat_each(self.motion);
        LaneMotion { x: [x, y], v: [v_x, v_y] }
    }

    #[inline(always)]
    fn position(&self) -> Vector {
        Vector::new(self.motion[0], self.motion[1])
    }

    #[inline(always)]
    fn velocity(&self) -> Vector {
        Vector::new(self.motion[2], self.motion[3])
    }

    #[inline(always)]
    fn density(&self) -> f64 {
        self.matter[0]
    }

    #[inline(always)]
    fn pressure(&self) -> f64 {
        self.matter[1]
    }

    #[inline(always)]
    fn volume(&self) -> f64 {
        self.matter[2]
    }
}

impl NeighbourFields<Plane> for [f64; 4] {
    #[inline(always)]
    fn new(damper: f64, eigenvalue: f64, [g_x, g_y]: [f64; 2]) -> Self {
        [damper, eigenvalue, g_x, g_y]
    }

    #[inline(always)]
    fn lanes<L: Lanes>([a, b, c, d]: [&Self; WIDTH]) -> (L, L, [L; 2]) {
        let [damper, eigenvalue, g_x, g_y] = L::columns([a, b, c, d]);
        (damper, eigenvalue, [g_x, g_y])
    }

    #[inline(always)]
    fn damper(&self) -> f64 {
        self[0]
    }

    #[inline(always)]
    fn eigenvalue(&self) -> f64 {
        self[1]
    }

    #[inline(always)]
    fn density_gradient(&self) -> [f64; 2] {
        [self[2], self[3]]
    }
}
