//! Pair forces of a total-Lagrangian body over its fixed neighbours, four at a time.

use sph::lanes::{LanePass, Lanes};
use sph::laws::artificial_viscosity::ArtificialViscosity;
use sph::space::geometry::Geometry;

use crate::formulations::reference_forces::ForceUnits;
use crate::neighbours::stencil::{Stencils, four};
use crate::space::SolidSpace;

/// The artificial viscosity of Eq. (23)-(24) between material points, of density ρ₀ both.
#[derive(Clone, Copy, Debug)]
pub struct Viscosity {
    /// The law.
    pub law: ArtificialViscosity,
    /// ρ₀ \[kg/m³\].
    pub density: f64,
}

impl Viscosity {
    /// Force of one pair over a_ij x_ij \[Pa\] for v_ij·x_ij = `approach` \[m²/s\] and x_ij² = `square` \[m²\].
    pub fn pressure(&self, approach: f64, square: f64) -> f64 {
        self.density * self.law.pressure(approach, square)
    }
}

sph::constants! {
    pub const TOTAL_LAGRANGIAN_LAMBDA: f64 = 0.01, "solid.artificial_viscosity.lambda",
        "lambda of Eq. (24) in total-Lagrangian bodies [-]";
}

/// State that the pair forces of a body read.
#[derive(Clone, Copy)]
pub struct Bonds<'a, G, S: SolidSpace> {
    pub geometry: G,
    pub stencils: &'a Stencils<S>,
    /// Positions of the whole body \[m\].
    pub position: &'a [S::Vector],
    /// Its velocities \[m/s\].
    pub velocity: &'a [S::Vector],
    /// Its N of [`crate::neighbours::reference::Reference::pair_tensor`] \[-\].
    pub pair_tensor: &'a [S::Matrix<f64>],
    pub units: ForceUnits,
    /// `None` without viscosity, which is then compiled out.
    pub viscosity: Option<Viscosity>,
}

/// Pair forces \[N/m\] on the particles from `first` on, and the part of them by artificial viscosity.
pub struct ForcePass<'a, G, S: SolidSpace> {
    pub bonds: &'a Bonds<'a, G, S>,
    pub first: usize,
    pub forces: &'a mut [S::Vector],
    pub viscous: &'a mut [S::Vector],
}

impl<G: Geometry<S>, S: SolidSpace> LanePass for ForcePass<'_, G, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { bonds, first, forces, viscous } = self;
        for (k, (force, viscous)) in forces.iter_mut().zip(viscous).enumerate() {
            [*force, *viscous] = match &bonds.viscosity {
                Some(viscosity) => bonds.force::<L, true>(first + k, viscosity),
                None => bonds.force::<L, false>(first + k, &NO_VISCOSITY),
            };
        }
    }
}

const NO_VISCOSITY: Viscosity = Viscosity { law: ArtificialViscosity::NONE, density: 0.0 };

impl<G: Geometry<S>, S: SolidSpace> Bonds<'_, G, S> {
    #[inline(always)]
    fn force<L: Lanes, const VISCOUS: bool>(&self, i: usize, viscosity: &Viscosity) -> [S::Vector; 2] {
        let own = S::splat_vector::<L>(&self.position[i]);
        let velocity = S::splat_vector::<L>(&self.velocity[i]);
        let pair_tensor = S::splat_matrix::<L>(&self.pair_tensor[i]);
        let twice = L::splat(2.0 * self.units.hourglass);
        let (law, density) = (viscosity.law.lanes::<L>(), L::splat(viscosity.density));
        // In units of the modulus, and of viscosity.
        let (mut elastic, mut viscous) = (S::splat(L::zero()), S::splat(L::zero()));
        for batch in self.stencils.of(i) {
            let x_ij = self.geometry.nearest(S::minus(own, four::<S, L>(self.position, batch.neighbours)));
            let others = S::tensor_lanes(batch.neighbours.map(|j| &self.pair_tensor[j as usize]));
            let weight = L::from_array(batch.weight);
            // Each pair by itself, so that an undeformed body at rest cancels to the last bit.
            let hourglass = S::scaled(S::scaled(x_ij, weight), twice);
            let both = S::matrix_plus(pair_tensor, others);
            elastic = S::plus(elastic, S::plus_matrix_times(hourglass, both, batch.arms()));
            if VISCOUS {
                let v_ij = S::minus(velocity, four::<S, L>(self.velocity, batch.neighbours));
                let pressure = law.pressure(S::dot(v_ij, x_ij), S::dot(x_ij, x_ij));
                viscous = S::plus_product(viscous, weight * density * pressure, x_ij);
            }
        }
        let [elastic, viscous] = S::vector_sums(elastic, viscous);
        let viscous = S::vector(viscous);
        [S::vector(elastic) * -self.units.modulus + viscous, viscous]
    }
}

#[cfg(test)]
mod tests;
