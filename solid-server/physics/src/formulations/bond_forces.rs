//! Pair forces of a total-Lagrangian body over its fixed neighbours, four at a time.

use sph::lanes::{LanePass, Lanes};
use sph::laws::artificial_viscosity::ArtificialViscosity;
use sph::space::geometry::Geometry;
use sph::space::{Tensor, Vector};

use crate::formulations::reference_forces::ForceUnits;
use crate::neighbours::stencil::{Stencils, separations, splat, vectors};

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

/// λ of Eq. (24) in total-Lagrangian bodies \[-\]: no key of a case.
pub const TOTAL_LAGRANGIAN_LAMBDA: f64 = 0.01;

/// State that the pair forces of a body read.
#[derive(Clone, Copy)]
pub struct Bonds<'a, G> {
    pub geometry: G,
    pub stencils: &'a Stencils,
    /// Positions of the whole body \[m\].
    pub position: &'a [Vector],
    /// Its velocities \[m/s\].
    pub velocity: &'a [Vector],
    /// Its N of [`crate::neighbours::reference::Reference::pair_tensor`] \[-\].
    pub pair_tensor: &'a [Tensor],
    pub units: ForceUnits,
    /// `None` without viscosity, which is then compiled out.
    pub viscosity: Option<Viscosity>,
}

/// Pair forces \[N/m\] on the particles from `first` on.
pub struct ForcePass<'a, G> {
    pub bonds: &'a Bonds<'a, G>,
    pub first: usize,
    pub forces: &'a mut [Vector],
}

impl<G: Geometry> LanePass for ForcePass<'_, G> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { bonds, first, forces } = self;
        for (k, force) in forces.iter_mut().enumerate() {
            *force = match &bonds.viscosity {
                Some(viscosity) => bonds.force::<L, true>(first + k, viscosity),
                None => bonds.force::<L, false>(first + k, &NO_VISCOSITY),
            };
        }
    }
}

const NO_VISCOSITY: Viscosity = Viscosity { law: ArtificialViscosity::NONE, density: 0.0 };

impl<G: Geometry> Bonds<'_, G> {
    #[inline(always)]
    fn force<L: Lanes, const VISCOUS: bool>(&self, i: usize, viscosity: &Viscosity) -> Vector {
        let (own, velocity) = (splat::<L>(&self.position[i]), splat::<L>(&self.velocity[i]));
        let pair_tensor = L::splat_each(entries(&self.pair_tensor[i]));
        let twice = L::splat(2.0 * self.units.hourglass);
        let (law, density) = (viscosity.law.lanes::<L>(), L::splat(viscosity.density));
        // Elastic x, y in units of the modulus, viscous x, y.
        let mut sums = [L::zero(); 4];
        for batch in self.stencils.of(i) {
            let [x, y] = separations(self.geometry, &own, self.position, batch);
            let [a, b, c, d] = batch.neighbours.map(|j| entries_of(&self.pair_tensor[j as usize]));
            let [xx, yx, xy, yy] = L::columns([a, b, c, d]);
            let ([arm_x, arm_y], weight) = (batch.arm.map(L::from_array), L::from_array(batch.weight));
            // Each pair by itself, so that an undeformed body at rest cancels to the last bit.
            let x_part = (twice * (weight * x)).plus_product(pair_tensor[0] + xx, arm_x);
            let y_part = (twice * (weight * y)).plus_product(pair_tensor[1] + yx, arm_x);
            sums[0] = sums[0] + x_part.plus_product(pair_tensor[2] + xy, arm_y);
            sums[1] = sums[1] + y_part.plus_product(pair_tensor[3] + yy, arm_y);
            if VISCOUS {
                let [v_x, v_y] = vectors::<L>(self.velocity, batch.neighbours);
                let approach = ((velocity[0] - v_x) * x).plus_product(velocity[1] - v_y, y);
                let factor = weight * density * law.pressure(approach, (x * x).plus_product(y, y));
                sums[2] = sums[2].plus_product(factor, x);
                sums[3] = sums[3].plus_product(factor, y);
            }
        }
        let [x, y, viscous_x, viscous_y] = L::sums(sums);
        Vector::new(x, y) * -self.units.modulus + Vector::new(viscous_x, viscous_y)
    }
}

/// T_xx, T_yx, T_xy, T_yy of a tensor.
#[inline(always)]
fn entries(tensor: &Tensor) -> [f64; 4] {
    let [[xx, yx], [xy, yy]] = tensor.data.0;
    [xx, yx, xy, yy]
}

/// The same without a copy.
#[inline(always)]
fn entries_of(tensor: &Tensor) -> &[f64; 4] {
    let [entries] = tensor.data.0.as_flattened().as_chunks().0 else { unreachable!("two by two are four") };
    entries
}

#[cfg(test)]
mod tests;
