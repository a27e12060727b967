//! The layout in which pair sums read particles.

use std::fmt::Debug;

use sph::lanes::{Lanes, WIDTH};
use sph::space::{Plane, Space, Spatial, Vector};

use super::lane_arrays::rows;
use super::thresholds::Thresholds;

type SpatialVector = <Spatial as Space>::Vector;

/// A space with a fluid in it.
pub trait FluidSpace: Thresholds {
    /// Whether a symmetric T is made of pressure and L_i pair by pair: in the plane its four components are as fast to read.
    const SYMMETRIC_TENSORS: bool;
    /// State of a particle as pair sums read it.
    type Particle: Packed<Self>;
    /// Results of the gradient pass as neighbours read them.
    type Fields: NeighbourFields<Self>;
    /// Distance of the nodes of the volume correction along periodic axes.
    const PERIODIC_NODES: PeriodicNodes;
}

/// Distance of the nodes of the volume correction along periodic axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PeriodicNodes {
    /// The smoothing length, as along others.
    AsOther,
    /// The particle spacing: nodes lie alike to all layers of a lattice, so that a slab that repeats along an axis stays
    /// in layers.
    Lattice,
}

impl FluidSpace for Plane {
    const SYMMETRIC_TENSORS: bool = false;
    type Particle = PackedParticle;
    type Fields = [f64; 4];
    const PERIODIC_NODES: PeriodicNodes = PeriodicNodes::AsOther;
}

impl FluidSpace for Spatial {
    const SYMMETRIC_TENSORS: bool = true;
    type Particle = SpatialParticle;
    type Fields = [f64; 5];
    const PERIODIC_NODES: PeriodicNodes = PeriodicNodes::Lattice;
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

/// A particle in space: one cache line and a half. The pressure, which inviscid water reads in T, comes last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct SpatialParticle {
    /// x, y, z \[m\], ρ \[kg/m³\].
    place: [f64; 4],
    /// v_x, v_y, v_z \[m/s\], V \[m³\].
    motion: [f64; 4],
    /// p \[Pa\].
    pressure: f64,
}

impl Packed<Spatial> for SpatialParticle {
    #[inline(always)]
    fn new(x: &SpatialVector, v: &SpatialVector, density: f64, pressure: f64, volume: f64) -> Self {
        Self { place: [x.x, x.y, x.z, density], motion: [v.x, v.y, v.z, volume], pressure }
    }

    #[inline(always)]
    fn pack<L: Lanes>(particles: LaneParticles<Spatial, L>) -> [Self; WIDTH] {
        let LaneParticles { motion: LaneMotion { x: [x, y, z], v: [u, v, w] }, density, pressure, volume } =
            particles;
        let [a, b, c, d] = rows([x, y, z, density]);
        let [m_a, m_b, m_c, m_d] = rows([u, v, w, volume]);
        let [p_a, p_b, p_c, p_d] = pressure.to_array();
        let particle = |place, motion, pressure| Self { place, motion, pressure };
        [particle(a, m_a, p_a), particle(b, m_b, p_b), particle(c, m_c, p_c), particle(d, m_d, p_d)]
    }

    #[inline(always)]
    fn lanes<L: Lanes>([a, b, c, d]: [&Self; WIDTH]) -> LaneParticles<Spatial, L> {
        let [x, y, z, density] = L::columns([&a.place, &b.place, &c.place, &d.place]);
        let [u, v, w, volume] = L::columns([&a.motion, &b.motion, &c.motion, &d.motion]);
        let pressure = L::from_array([a.pressure, b.pressure, c.pressure, d.pressure]);
        LaneParticles { motion: LaneMotion { x: [x, y, z], v: [u, v, w] }, density, pressure, volume }
    }

    #[inline(always)]
    fn splat_motion<L: Lanes>(&self) -> LaneMotion<Spatial, L> {
        let ([x, y, z, _], [u, v, w, _]) = (L::splat_each(self.place), L::splat_each(self.motion));
        LaneMotion { x: [x, y, z], v: [u, v, w] }
    }

    #[inline(always)]
    fn position(&self) -> SpatialVector {
        Spatial::vector([self.place[0], self.place[1], self.place[2]])
    }

    #[inline(always)]
    fn velocity(&self) -> SpatialVector {
        Spatial::vector([self.motion[0], self.motion[1], self.motion[2]])
    }

    #[inline(always)]
    fn density(&self) -> f64 {
        self.place[3]
    }

    #[inline(always)]
    fn pressure(&self) -> f64 {
        self.pressure
    }

    #[inline(always)]
    fn volume(&self) -> f64 {
        self.motion[3]
    }
}

/// All but the last of five numbers.
#[inline(always)]
fn first_four(numbers: &[f64; 5]) -> &[f64; 4] {
    let Some(four) = numbers.first_chunk() else { unreachable!("four of five numbers") };
    four
}

impl NeighbourFields<Spatial> for [f64; 5] {
    #[inline(always)]
    fn new(damper: f64, eigenvalue: f64, [g_x, g_y, g_z]: [f64; 3]) -> Self {
        [g_x, g_y, g_z, damper, eigenvalue]
    }

    #[inline(always)]
    fn lanes<L: Lanes>([a, b, c, d]: [&Self; WIDTH]) -> (L, L, [L; 3]) {
        let [g_x, g_y, g_z, damper] =
            L::columns([first_four(a), first_four(b), first_four(c), first_four(d)]);
        (damper, L::from_array([a[4], b[4], c[4], d[4]]), [g_x, g_y, g_z])
    }

    #[inline(always)]
    fn damper(&self) -> f64 {
        self[3]
    }

    #[inline(always)]
    fn eigenvalue(&self) -> f64 {
        self[4]
    }

    #[inline(always)]
    fn density_gradient(&self) -> [f64; 3] {
        [self[0], self[1], self[2]]
    }
}
