//! The pair law of fluid and solid particles, and the dummy state of a solid particle.

use super::fluid_regions::Dummy;
use super::lists::CrossPair;
use super::states::InterfaceStates;
use crate::kernel::CubicSpline;
use crate::laws::artificial_viscosity::ArtificialViscosity;
use crate::laws::equation_of_state::Tait;
use crate::laws::repulsion::Repulsion;
use crate::setup::{Coupling, GradientCorrection, InterfaceLaw};
use crate::space::Space;
use crate::space::domain::Domain;
use crate::space::tensors::{SpaceSymmetric, SpaceVector};

/// Constants of the pair law.
#[derive(Clone, Copy, Debug)]
pub struct PairLaw<S: Space> {
    law: InterfaceLaw,
    kernel: CubicSpline<S>,
    equation_of_state: Tait,
    /// 1/M or 1: fluid-solid pairs never use L_i, which needs second neighbours.
    gradient_scale: f64,
    rest_density: f64,
    artificial_viscosity: ArtificialViscosity,
    dynamic_viscosity: f64,
    /// Repulsion of close pairs.
    repulsion: Repulsion,
}

impl<S: Space> PairLaw<S> {
    /// The law with the constants of `coupling`.
    pub fn new(coupling: &Coupling) -> Self {
        let fluid = &coupling.fluid;
        let kernel = CubicSpline::<S>::new(fluid.smoothing_length());
        let gradient_scale = match fluid.correction {
            GradientCorrection::None => 1.0,
            GradientCorrection::LatticeMoment
            | GradientCorrection::Continuity
            | GradientCorrection::Renormalised => 1.0 / kernel.lattice_moment(fluid.particle_spacing),
        };
        Self {
            law: coupling.law,
            kernel,
            equation_of_state: fluid.equation_of_state(),
            gradient_scale,
            rest_density: fluid.rest_density,
            artificial_viscosity: fluid.artificial_viscosity(),
            dynamic_viscosity: fluid.dynamic_viscosity,
            repulsion: Repulsion::new(
                coupling.repulsion,
                0.5 * (fluid.particle_spacing + coupling.solid_spacing),
                fluid.particle_spacing,
                fluid.sound_speed,
            ),
        }
    }

    /// Which law it is.
    pub fn kind(&self) -> InterfaceLaw {
        self.law
    }

    /// Distance from which particles do not interact \[m\].
    pub fn support_radius(&self) -> f64 {
        self.kernel.support_radius()
    }

    /// Dummy state of solid state `s` toward `region`: pressure by Eq. (28), without the solid's acceleration, which would
    /// make light solids unstable, and velocity, without slip that of Eq. (27).
    pub fn wall_dummy(
        &self,
        domain: &Domain<S>,
        body_force: &S::Vector,
        [fluid, solid]: [&InterfaceStates<S>; 2],
        s: usize,
        row: &[CrossPair],
        region: u32,
    ) -> Dummy<S> {
        let no_slip = self.law == InterfaceLaw::WallNoSlip;
        let (mut weighted, mut weight, mut flow) = (0.0, 0.0, S::Vector::zeros());
        for f in row.iter().filter(|pair| pair.region == region).map(|pair| pair.other as usize) {
            let x_fs = domain.separation(&fluid.position[f], &solid.position[s]);
            let w = self.kernel.value(x_fs.norm());
            weighted += w * (fluid.pressure[f] - fluid.density[f] * body_force.dot(&x_fs));
            weight += w;
            if no_slip {
                flow += fluid.velocity[f] * w;
            }
        }
        let pressure = if weight > 0.0 { weighted / weight } else { 0.0 };
        let mut velocity = solid.velocity[s];
        if no_slip && weight > 0.0 {
            velocity = velocity * 2.0 - flow / weight;
        }
        Dummy {
            pressure,
            density: self.equation_of_state.wall_density(pressure),
            // In this order: coupling points of a solid with force coupling carry the volume alone.
            mass: self.rest_density * solid.volume(s),
            velocity,
        }
    }

    /// Force of solid state `s` on fluid state `f` \[N\], Eq. (22) with the fluid's h and c₀.
    #[inline]
    pub fn force_on_fluid(
        &self,
        x_fs: &S::Vector,
        fluid: &InterfaceStates<S>,
        f: usize,
        solid: &InterfaceStates<S>,
        s: usize,
        dummy: &Dummy<S>,
    ) -> S::Vector {
        let distance = x_fs.norm();
        let gradient_factor = self.gradient_scale * self.kernel.gradient_factor(distance);
        let (rho_f, rho_s) = (fluid.density[f], dummy.density);
        let masses = fluid.mass[f] * dummy.mass;
        let square = distance * distance;
        let approach = (fluid.velocity[f] - solid.velocity[s]).dot(x_fs);
        let viscous_v_fs = fluid.velocity[f] - dummy.velocity;
        // Π_fs of Eq. (23).
        let viscosity =
            self.artificial_viscosity.pressure(viscous_v_fs.dot(x_fs), square) / (0.5 * (rho_f + rho_s));
        let central = fluid.mass[f] * self.repulsion(distance, approach)
            - masses * ((fluid.pressure[f] + dummy.pressure) / (rho_f * rho_s) + viscosity) * gradient_factor;
        match self.law {
            InterfaceLaw::Wall => *x_fs * central,
            InterfaceLaw::WallNoSlip => {
                // Morris, Fox & Zhu 1997: 2 μ (x·∇W)/(ρ_f ρ_s r²) v_fs.
                let softened = self.artificial_viscosity.softened(square);
                let friction = masses * 2.0 * self.dynamic_viscosity * square * gradient_factor
                    / (rho_f * rho_s * softened);
                *x_fs * central + viscous_v_fs * friction
            }
            InterfaceLaw::PlainSum => {
                let stress = S::SymmetricTensor::isotropic(-fluid.pressure[f]).plus(&solid.stress[s]);
                let factor = masses * gradient_factor;
                stress.dot(x_fs) * (factor / (rho_f * rho_s)) - *x_fs * (factor * viscosity)
            }
        }
    }

    /// Repulsion over distance and mass of the fluid particle \[1/s²\], for v_fs·x_fs.
    ///
    /// Pressure alone can not keep out a particle that has been squeezed between two of the solid's. Coincident
    /// particles have no direction in which to part.
    #[inline]
    pub(super) fn repulsion(&self, distance: f64, approach: f64) -> f64 {
        if distance >= self.repulsion.distance() || distance == 0.0 {
            return 0.0;
        }
        self.repulsion.acceleration(distance, approach / distance) / distance
    }
}
