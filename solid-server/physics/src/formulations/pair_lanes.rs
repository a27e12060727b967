//! The sums of [`SumLaw`] over the particles of one body, four neighbours at a time.

use sph::kernel::KernelLanes;
use sph::kernel::shape::Spline;
use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::laws::artificial_viscosity::ArtificialViscosity;
use sph::space::geometry::Geometry;
use sph::space::tensors::SpaceVector;

use crate::formulations::pair_law::{PairParticle, PairSums, PairTerms, SumLaw, fourth_power};
use crate::neighbours::lists::Rows;
use crate::neighbours::stencil::four;
use crate::space::SolidSpace;

/// The particles of one body as pairs read them.
#[derive(Clone, Copy)]
pub struct BodyArrays<'a, S: SolidSpace> {
    /// Position \[m\].
    pub position: &'a [S::Vector],
    /// Velocity \[m/s\].
    pub velocity: &'a [S::Vector],
    /// Mass per depth \[kg/m\].
    pub mass: &'a [f64],
    /// Density \[kg/m³\].
    pub density: &'a [f64],
    /// Cauchy stress \[Pa\].
    pub stress: &'a [S::SymmetricTensor],
    /// Artificial stress R_i \[m⁵/(kg s²)\].
    pub artificial: &'a [S::SymmetricTensor],
}

/// Sums over own-body pairs of the particles from `first` on.
pub struct PairPass<'a, G, S: SolidSpace> {
    pub geometry: G,
    pub law: &'a SumLaw<S>,
    pub members: BodyArrays<'a, S>,
    /// Candidates of each particle.
    pub neighbours: &'a Rows,
    pub first: usize,
    pub sums: &'a mut [PairSums<S>],
}

impl<G: Geometry<S>, S: SolidSpace> LanePass for PairPass<'_, G, S> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { geometry, law, members, neighbours, first, sums } = self;
        // Loops, since a closure would not be compiled for the path's instructions.
        if law.artificial_stress == 0.0 {
            let law = LawLanes::<S, L, false>::new(law);
            for (k, sums) in sums.iter_mut().enumerate() {
                *sums = law.sum(geometry, &members, neighbours.of(first + k), first + k);
            }
        } else {
            let law = LawLanes::<S, L, true>::new(law);
            for (k, sums) in sums.iter_mut().enumerate() {
                *sums = law.sum(geometry, &members, neighbours.of(first + k), first + k);
            }
        }
    }
}

/// [`SumLaw`] in lanes; `ARTIFICIAL` where it has an artificial stress.
struct LawLanes<'a, S: SolidSpace, L, const ARTIFICIAL: bool> {
    law: &'a SumLaw<S>,
    kernel: KernelLanes<L>,
    square_support: f64,
    viscosity: ArtificialViscosity<L>,
    /// F of Eq. (26).
    nearness: Spline<L>,
}

impl<'a, S: SolidSpace, L: Lanes, const ARTIFICIAL: bool> LawLanes<'a, S, L, ARTIFICIAL> {
    #[inline(always)]
    fn new(law: &'a SumLaw<S>) -> Self {
        Self {
            law,
            kernel: law.pair_kernel.lanes(),
            square_support: law.kernel.support_radius().powi(2),
            viscosity: law.artificial_viscosity().lanes(),
            nearness: law.nearness(),
        }
    }

    /// The sums of particle `i` over those of `candidates` that lie within support.
    ///
    /// These alone fill the batches, in the order of the row: when a list was built does not show in the sums.
    #[inline(always)]
    fn sum<G: Geometry<S>>(
        &self,
        geometry: G,
        members: &BodyArrays<'_, S>,
        candidates: &[u32],
        i: usize,
    ) -> PairSums<S> {
        let position = S::splat_vector(&members.position[i]);
        let (own, mut sums) = (members.splat(i), PairSums::zero());
        // The particle itself adds nothing. Indices of a body stay below 2^32.
        let filler = [i as u32; WIDTH];
        let (mut batch, mut filled) = (filler, 0);
        for j in candidates {
            let d = geometry.separation(&members.position[i], &members.position[*j as usize]);
            if d.norm_squared() < self.square_support {
                batch[filled] = *j;
                filled += 1;
            }
            if filled == WIDTH {
                self.add(geometry, &mut sums, position, &own, members, batch);
                (batch, filled) = (filler, 0);
            }
        }
        if filled > 0 {
            self.add(geometry, &mut sums, position, &own, members, batch);
        }
        sums.total()
    }

    /// Adds four neighbours, as [`SumLaw::add_pair`] adds one.
    #[inline(always)]
    fn add<G: Geometry<S>>(
        &self,
        geometry: G,
        sums: &mut PairSums<S, L>,
        position: S::Of<L>,
        own: &PairParticle<S, L>,
        members: &BodyArrays<'_, S>,
        batch: [u32; WIDTH],
    ) {
        let separation = geometry.nearest(S::minus(position, four::<S, L>(members.position, batch)));
        let other = members.batch::<L, ARTIFICIAL>(batch);
        let velocity = S::minus(own.velocity, other.velocity);
        let square = S::dot(separation, separation);
        let (s, slope) = self.kernel.slope(square);
        let gradient_factor = slope / s;
        // All that a pair shares is symmetric in its particles to the last bit, so that forces are opposite.
        let inverse_densities = L::splat(1.0) / (own.density * other.density);

        // Π_ij of Eq. (23), with one division for θ and 1/ρ̄.
        let approach = S::dot(velocity, separation);
        let (softened, density_sum) = (self.viscosity.softened(square), own.density + other.density);
        let inverse = L::splat(1.0) / (softened * density_sum);
        let damping = self.viscosity.pressure_over_density(approach * (inverse * density_sum));
        let pair = PairTerms {
            separation,
            velocity,
            gradient_factor,
            weight: other.mass * own.density * inverse_densities * gradient_factor,
            inverse_densities,
            viscosity: (damping + damping) * (inverse * softened),
            nearness: if ARTIFICIAL { Some(self.power_of_nearness(s)) } else { None },
        };
        sums.add_pair(own, &other, &pair);
    }

    /// Fⁿ of Eq. (26) \[-\] at s = r/h.
    #[inline(always)]
    fn power_of_nearness(&self, s: L) -> L {
        let ratio = self.nearness.at(s);
        if self.law.exponent == 4.0 {
            fourth_power(ratio)
        } else {
            L::from_array(ratio.to_array().map(|ratio| ratio.powf(self.law.exponent)))
        }
    }
}

impl<S: SolidSpace> BodyArrays<'_, S> {
    /// Particle `i` in all lanes.
    #[inline(always)]
    fn splat<L: Lanes>(&self, i: usize) -> PairParticle<S, L> {
        PairParticle {
            mass: L::splat(self.mass[i]),
            density: L::splat(self.density[i]),
            velocity: S::splat_vector(&self.velocity[i]),
            stress: S::splat_symmetric(&S::symmetric_components(&self.stress[i])),
            artificial_stress: S::splat_symmetric(&S::symmetric_components(&self.artificial[i])),
        }
    }

    /// Four particles, without artificial stress unless `ARTIFICIAL`.
    #[inline(always)]
    fn batch<L: Lanes, const ARTIFICIAL: bool>(&self, batch: [u32; WIDTH]) -> PairParticle<S, L> {
        PairParticle {
            mass: L::from_array(batch.map(|j| self.mass[j as usize])),
            density: L::from_array(batch.map(|j| self.density[j as usize])),
            velocity: four::<S, L>(self.velocity, batch),
            stress: S::symmetric_lanes(batch.map(|j| &self.stress[j as usize])),
            artificial_stress: if ARTIFICIAL {
                S::symmetric_lanes(batch.map(|j| &self.artificial[j as usize]))
            } else {
                S::zero_symmetric()
            },
        }
    }
}

impl<S: SolidSpace, L: Lanes> PairSums<S, L> {
    /// Sums over the lanes.
    #[inline(always)]
    fn total(self) -> PairSums<S> {
        let [force, viscous] = S::vector_sums(self.force, self.viscous);
        let [artificial, _] = S::vector_sums(self.artificial, S::splat(L::zero()));
        PairSums {
            force,
            viscous,
            artificial,
            gradient: S::matrix_sums(self.gradient),
            moment: S::symmetric_sums(self.moment),
        }
    }
}

#[cfg(test)]
mod tests;
