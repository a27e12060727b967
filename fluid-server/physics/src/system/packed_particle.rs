//! The layout in which pair sums read a particle.

use sph::lanes::{Lanes, WIDTH};
use sph::space::Vector;

use super::lane_arrays::rows;

/// State of a particle as pair sums read it: one cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct PackedParticle {
    /// x, y \[m\], v_x, v_y \[m/s\].
    pub motion: [f64; 4],
    /// Density ρ \[kg/m³\], pressure p \[Pa\], volume per depth V = m/ρ \[m²\], unused.
    pub matter: [f64; 4],
}

/// Results of the gradient pass as neighbours read them: pressure q of the acoustic damper \[Pa\], surface flag
/// \[-\], ∇ρ of Eq. (20) \[kg/m⁴\].
pub type NeighbourFields = [f64; 4];

impl PackedParticle {
    /// A particle; one of zero `volume` does not act.
    #[inline(always)]
    pub fn new(position: &Vector, velocity: &Vector, density: f64, pressure: f64, volume: f64) -> Self {
        Self {
            motion: [position.x, position.y, velocity.x, velocity.y],
            matter: [density, pressure, volume, 0.0],
        }
    }

    /// Four particles, from the numbers of [`PackedParticle::motion`] and from density, pressure and volume.
    #[inline(always)]
    pub fn pack<L: Lanes>(motion: [L; 4], [density, pressure, volume]: [L; 3]) -> [Self; WIDTH] {
        let [a, b, c, d] = rows(motion);
        let [m_a, m_b, m_c, m_d] = rows([density, pressure, volume, L::zero()]);
        let particle = |motion, matter| Self { motion, matter };
        [particle(a, m_a), particle(b, m_b), particle(c, m_c), particle(d, m_d)]
    }

    /// Position \[m\].
    #[inline(always)]
    pub fn position(&self) -> Vector {
        Vector::new(self.motion[0], self.motion[1])
    }

    /// Velocity \[m/s\].
    #[inline(always)]
    pub fn velocity(&self) -> Vector {
        Vector::new(self.motion[2], self.motion[3])
    }

    /// Density ρ \[kg/m³\].
    #[inline(always)]
    pub fn density(&self) -> f64 {
        self.matter[0]
    }

    /// Pressure p \[Pa\], without damper.
    #[inline(always)]
    pub fn pressure(&self) -> f64 {
        self.matter[1]
    }

    /// Volume per depth V = m/ρ \[m²\]; zero for a particle that does not act.
    #[inline(always)]
    pub fn volume(&self) -> f64 {
        self.matter[2]
    }
}
