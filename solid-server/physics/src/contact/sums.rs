//! Contact of the source paper: other bodies enter the sums over particles, walls as in its section 4.1.

use sph::prescribed::body_force::BodyForceField;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::tasks::for_each;

use crate::boundary::walls::WallState;
use crate::formulations::body::Body;
use crate::formulations::pair_law::{PairParticle, PairSums, SumLaw};
use crate::materials::hooke::density;
use crate::neighbours::lists::{PairLists, TASK};
use crate::particles::constants::ParticleConstants;
use crate::particles::fields::StressFields;
use crate::particles::forces::ContactForces;
use crate::particles::variables::Particles;
use crate::space::SolidSpace;

/// Contact through the sums (17) and (25).
///
/// Particles of other bodies are neighbours like any other, with the means of both bodies' constants. A wall particle
/// has the velocity of its wall, the pressure of Eq. (28) over solid particles, the density that Eq. (5) gives for it,
/// and no shear. Both attract where the pressure is negative; the force sets in at the support radius.
pub struct SumContact {
    /// Support radius of the sums \[m\].
    pub support_radius: f64,
}

/// The state at which contact through the sums is evaluated.
pub struct SumStage<'a, S: SolidSpace> {
    pub domain: &'a Domain<S>,
    /// Spacing of the particles \[m\].
    pub spacing: f64,
    pub constants: &'a ParticleConstants<S>,
    pub bodies: &'a [Body<S>],
    pub body_force: &'a BodyForceField<S>,
    /// Time of the state \[s\].
    pub at: f64,
    pub stage: &'a Particles<S>,
    pub stress: &'a StressFields<S>,
    pub lists: &'a PairLists,
    pub walls: &'a WallState<S>,
}

impl<S: SolidSpace> SumStage<'_, S> {
    fn particle(&self, i: usize) -> PairParticle<S> {
        PairParticle {
            mass: self.constants.mass[i],
            density: self.stage.density[i],
            velocity: S::components(&self.stage.velocity[i]),
            stress: S::symmetric_components(&self.stress.cauchy[i]),
            artificial_stress: S::symmetric_components(&self.stress.artificial[i]),
        }
    }

    fn body(&self, i: usize) -> &Body<S> {
        &self.bodies[self.constants.body[i] as usize]
    }

    fn law(&self, i: usize) -> Option<&SumLaw<S>> {
        self.body(i).formulation.sum_law()
    }

    /// Pressure of wall particle `w` toward solids \[Pa\], Eq. (28) over solid particles.
    ///
    /// ```text
    /// p_w = Σ_i W_wi (p_i + ρ_i (g − a_w)·(x_w − x_i)) / Σ_i W_wi
    /// ```
    ///
    /// a_w is the prescribed acceleration of a moving wall.
    fn wall_pressure(&self, w: usize) -> f64 {
        let x_w = &self.walls.position[w];
        let g = self.body_force.acceleration(x_w, self.at) - self.walls.acceleration[w];
        let (mut weighted, mut weight) = (0.0, 0.0);
        for i in self.lists.of_walls.of(w).iter().map(|i| *i as usize) {
            let Some(law) = self.law(i) else { continue };
            let x_wi = self.domain.separation(x_w, &self.stage.position[i]);
            let kernel = law.kernel.value(x_wi.norm());
            weighted += kernel * (self.stress.pressure[i] + self.stage.density[i] * g.dot(&x_wi));
            weight += kernel;
        }
        if weight > 0.0 { weighted / weight } else { 0.0 }
    }

    /// Adds the pairs of particle `i` with walls to `sums`, and the power of their forces by the motion of the walls to
    /// `power` \[W/m\].
    fn add_walls(
        &self,
        i: usize,
        law: &SumLaw<S>,
        wall_pressure: &[f64],
        sums: &mut PairSums<S>,
        power: &mut f64,
    ) {
        let material = &self.body(i).material;
        let own = self.particle(i);
        let cell = S::cell_volume(self.spacing);
        for w in self.lists.walls.of(i).iter().map(|w| *w as usize) {
            let wall = PairParticle {
                mass: material.density * cell,
                density: density(material, wall_pressure[w]),
                velocity: S::components(&self.walls.velocity[w]),
                stress: S::symmetric_plus_isotropic(S::zero_symmetric(), -wall_pressure[w]),
                artificial_stress: S::zero_symmetric(),
            };
            // R_ij belongs to pairs of solid particles only.
            let own = PairParticle { artificial_stress: S::zero_symmetric(), ..own };
            let x_iw = self.domain.separation(&self.stage.position[i], &self.walls.position[w]);
            let before = sums.force;
            law.add_pair(sums, &own, &wall, &x_iw);
            *power += S::vector(S::minus(sums.force, before)).dot(&self.walls.velocity[w]);
        }
    }
}

impl SumContact {
    /// Adds foreign neighbours to the gradients of `sums` and their forces to `contact`.
    ///
    /// `wall_pressure` is room for one value per wall particle.
    pub fn evaluate<S: SolidSpace>(
        &self,
        at: &SumStage<'_, S>,
        wall_pressure: &mut [f64],
        sums: &mut [PairSums<S>],
        contact: &mut [ContactForces<S>],
    ) {
        for_each(&mut *wall_pressure, TASK, |w, p| *p = at.wall_pressure(w));
        let wall_pressure = &*wall_pressure;
        for_each((sums, contact), TASK, |i, (sums, contact)| {
            *contact = ContactForces::default();
            let Some(law) = at.law(i) else { return };
            let mut foreign = PairSums::zero();
            let own = at.particle(i);
            for j in at.lists.bodies.of(i).iter().map(|j| *j as usize) {
                let Some(other) = at.law(j) else { continue };
                let x_ij = at.domain.separation(&at.stage.position[i], &at.stage.position[j]);
                law.between(other).add_pair(&mut foreign, &own, &at.particle(j), &x_ij);
            }
            let mut of_walls = PairSums::zero();
            at.add_walls(i, law, wall_pressure, &mut of_walls, &mut contact.wall_power);
            contact.bodies = S::vector(foreign.force);
            contact.walls = S::vector(of_walls.force);
            for more in [foreign, of_walls] {
                sums.add_gradients_of(&more);
            }
        });
    }
}
