//! The interface between fluid and solid: cross lists, dummy states and pair forces, by the same code on both sides.
//!
//! Both solvers hold the same two sets of states, one own and one received, and evaluate the same pair function with
//! the fluid particle first; the solid negates. That makes action equal reaction bit for bit.

use rayon::prelude::*;

use crate::body_force::BodyForceField;
use crate::domain::Domain;
use crate::equation_of_state::Tait;
use crate::exchange::InterfaceStates;
use crate::kernel::CubicSpline;
use crate::ledger::InterfaceSums;
use crate::neighbours::CellGrid;
use crate::repulsion::Repulsion;
use crate::setup::{Coupling, GradientCorrection, InterfaceLaw};
use crate::sums::ordered_sum;
use crate::vector::{SymmetricTensor, Vector, cross};

/// State of an interface particle of the solid as the fluid feels it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dummy {
    /// Pressure \[Pa\].
    pub pressure: f64,
    /// Density that belongs to the pressure \[kg/m³\].
    pub density: f64,
    /// Mass per depth \[kg/m\].
    pub mass: f64,
}

/// Cross lists, dummy states and forces of one half-step; all buffers are reused.
#[derive(Debug)]
pub struct Interface {
    law: PairLaw,
    domain: Domain,
    body_force: BodyForceField,
    of_fluid: Rows,
    of_solid: Rows,
    dummies: Vec<Dummy>,
    sums: Vec<ParticleSums>,
}

/// Rows of neighbour indices that keep their allocations.
#[derive(Debug, Default)]
struct Rows {
    offsets: Vec<u32>,
    indices: Vec<u32>,
}

impl Rows {
    fn of(&self, i: usize) -> &[u32] {
        &self.indices[self.offsets[i] as usize..self.offsets[i + 1] as usize]
    }
}

/// What one particle receives across the interface.
#[derive(Clone, Copy, Debug, Default)]
struct ParticleSums {
    force: Vector,
    gross_force: f64,
    couple: f64,
    pairs: u64,
}

/// Constants of the pair law.
#[derive(Clone, Copy, Debug)]
struct PairLaw {
    law: InterfaceLaw,
    kernel: CubicSpline,
    equation_of_state: Tait,
    /// 1/M or 1: fluid-solid pairs never use L_i, which needs second neighbours.
    gradient_scale: f64,
    rest_density: f64,
    sound_speed: f64,
    viscosity_a: f64,
    viscosity_b: f64,
    lambda: f64,
    dynamic_viscosity: f64,
    /// Repulsion of close pairs.
    repulsion: Repulsion,
}

impl Interface {
    /// An interface with the laws and constants of `coupling`.
    pub fn new(coupling: &Coupling, domain: &Domain, body_force: BodyForceField) -> Self {
        let fluid = &coupling.fluid;
        let kernel = CubicSpline::new(fluid.smoothing_length);
        let gradient_scale = match fluid.correction {
            GradientCorrection::None => 1.0,
            GradientCorrection::LatticeMoment
            | GradientCorrection::Continuity
            | GradientCorrection::Renormalised => 1.0 / kernel.lattice_moment(fluid.particle_spacing),
        };
        Self {
            law: PairLaw {
                law: coupling.law,
                kernel,
                equation_of_state: Tait::new(fluid.rest_density, fluid.sound_speed, fluid.exponent),
                gradient_scale,
                rest_density: fluid.rest_density,
                sound_speed: fluid.sound_speed,
                viscosity_a: fluid.viscosity_a,
                viscosity_b: fluid.viscosity_b,
                lambda: fluid.lambda,
                dynamic_viscosity: fluid.dynamic_viscosity,
                repulsion: Repulsion::new(
                    coupling.repulsion,
                    0.5 * (fluid.particle_spacing + coupling.solid_spacing),
                    fluid.particle_spacing,
                    fluid.sound_speed,
                ),
            },
            domain: *domain,
            body_force,
            of_fluid: Rows::default(),
            of_solid: Rows::default(),
            dummies: Vec::new(),
            sums: Vec::new(),
        }
    }

    /// Builds the cross lists and the dummy states for states at `time` \[s\].
    ///
    /// The lists hold exactly the pairs within the support radius, in id order, whatever else was sent.
    pub fn update(&mut self, time: f64, fluid: &InterfaceStates, solid: &InterfaceStates) {
        self.build_lists(fluid, solid);
        let (law, domain, body_force, rows) = (&self.law, &self.domain, &self.body_force, &self.of_solid);
        self.dummies.clear();
        self.dummies.extend((0..solid.len()).map(|s| match law.law {
            InterfaceLaw::PlainSum => {
                Dummy { pressure: solid.pressure[s], density: solid.density[s], mass: solid.mass[s] }
            }
            InterfaceLaw::Wall | InterfaceLaw::WallNoSlip => law.wall_dummy(
                domain,
                &body_force.acceleration(&solid.position[s], time),
                fluid,
                solid,
                s,
                rows.of(s),
            ),
        }));
    }

    fn build_lists(&mut self, fluid: &InterfaceStates, solid: &InterfaceStates) {
        let support = self.law.kernel.support_radius();
        let grid = CellGrid::new(&self.domain, &solid.position, support);
        let list = grid.list(&self.domain, &fluid.position, &solid.position, support, false);
        let Rows { offsets, indices } = &mut self.of_fluid;
        offsets.clear();
        indices.clear();
        offsets.push(0);
        for f in 0..fluid.len() {
            let start = indices.len();
            indices.extend_from_slice(list.of(f));
            indices[start..].sort_unstable();
            offsets.push(indices.len() as u32);
        }
        self.transpose(solid.len());
    }

    /// Rows of the solid from those of the fluid: the same pairs, fluid indices ascending.
    fn transpose(&mut self, solids: usize) {
        let Rows { offsets, indices } = &mut self.of_solid;
        offsets.clear();
        offsets.resize(solids + 1, 0);
        for s in &self.of_fluid.indices {
            offsets[*s as usize + 1] += 1;
        }
        for s in 0..solids {
            offsets[s + 1] += offsets[s];
        }
        indices.clear();
        indices.resize(self.of_fluid.indices.len(), 0);
        // Fill backwards from the row ends, so that no second array of cursors is needed.
        let fluids = self.of_fluid.offsets.len() - 1;
        for f in (0..fluids).rev() {
            for s in self.of_fluid.of(f) {
                let end = &mut offsets[*s as usize + 1];
                *end -= 1;
                indices[*end as usize] = f as u32;
            }
        }
        // Each end now is its row's start: shift back.
        for s in 0..solids {
            offsets[s] = offsets[s + 1];
        }
        offsets[solids] = indices.len() as u32;
    }

    /// Indices of the solid's states within support of fluid state `f`, ascending.
    pub fn solid_neighbours(&self, f: usize) -> &[u32] {
        self.of_fluid.of(f)
    }

    /// Indices of the fluid's states within support of solid state `s`, ascending.
    pub fn fluid_neighbours(&self, s: usize) -> &[u32] {
        self.of_solid.of(s)
    }

    /// Solid state `s` as the fluid feels it.
    pub fn dummy(&self, s: usize) -> Dummy {
        self.dummies[s]
    }

    /// Force on state `k` of the side summed last \[N/m\].
    pub fn force(&self, k: usize) -> Vector {
        self.sums[k].force
    }

    /// Forces on the fluid's states; read them by [`Interface::force`].
    pub fn fluid_forces(&mut self, fluid: &InterfaceStates, solid: &InterfaceStates) -> InterfaceSums {
        let (law, domain, rows, dummies) = (&self.law, &self.domain, &self.of_fluid, &self.dummies);
        self.sums.clear();
        self.sums.resize(fluid.len(), ParticleSums::default());
        self.sums.par_iter_mut().with_min_len(64).enumerate().for_each(|(f, sums)| {
            for &s in rows.of(f) {
                let s = s as usize;
                let x_fs = domain.separation(&fluid.position[f], &solid.position[s]);
                let force = law.force_on_fluid(&x_fs, fluid, f, solid, s, &dummies[s]);
                sums.add(&x_fs, force);
            }
        });
        self.total(fluid)
    }

    /// Forces on the solid's states; read them by [`Interface::force`].
    pub fn solid_forces(&mut self, fluid: &InterfaceStates, solid: &InterfaceStates) -> InterfaceSums {
        let (law, domain, rows, dummies) = (&self.law, &self.domain, &self.of_solid, &self.dummies);
        self.sums.clear();
        self.sums.resize(solid.len(), ParticleSums::default());
        self.sums.par_iter_mut().with_min_len(64).enumerate().for_each(|(s, sums)| {
            for &f in rows.of(s) {
                let f = f as usize;
                let x_fs = domain.separation(&fluid.position[f], &solid.position[s]);
                let force = law.force_on_fluid(&x_fs, fluid, f, solid, s, &dummies[s]);
                sums.add(&-x_fs, -force);
            }
        });
        self.total(solid)
    }

    fn total(&self, states: &InterfaceStates) -> InterfaceSums {
        let origin = self.domain.torque_origin();
        ordered_sum(states.len(), |k| {
            let sums = &self.sums[k];
            let arm = states.position[k] - origin;
            InterfaceSums {
                force: sums.force,
                gross_force: sums.gross_force,
                torque: cross(&arm, &sums.force),
                gross_torque: arm.norm() * sums.gross_force,
                couple: sums.couple,
                power: sums.force.dot(&states.velocity[k]),
                pairs: sums.pairs,
            }
        })
    }
}

/// Sums of the `forces` \[N/m\] that act on `samples`: what a solid that is coupled by loads reports.
pub fn load_sums(domain: &Domain, samples: &InterfaceStates, forces: &[Vector]) -> InterfaceSums {
    let origin = domain.torque_origin();
    ordered_sum(forces.len(), |s| {
        let (force, arm) = (forces[s], samples.position[s] - origin);
        InterfaceSums {
            force,
            gross_force: force.norm(),
            torque: cross(&arm, &force),
            gross_torque: arm.norm() * force.norm(),
            // Only the fluid knows where its particles are.
            couple: 0.0,
            power: force.dot(&samples.velocity[s]),
            pairs: u64::from(force != Vector::zeros()),
        }
    })
}

impl ParticleSums {
    fn add(&mut self, separation: &Vector, force: Vector) {
        self.force += force;
        self.gross_force += force.norm();
        self.couple += 0.5 * cross(separation, &force);
        self.pairs += 1;
    }
}

impl PairLaw {
    /// Dummy state by Eq. (28), without the solid's acceleration, which would make light solids unstable.
    fn wall_dummy(
        &self,
        domain: &Domain,
        body_force: &Vector,
        fluid: &InterfaceStates,
        solid: &InterfaceStates,
        s: usize,
        row: &[u32],
    ) -> Dummy {
        let (mut weighted, mut weight) = (0.0, 0.0);
        for &f in row {
            let f = f as usize;
            let x_fs = domain.separation(&fluid.position[f], &solid.position[s]);
            let w = self.kernel.value(x_fs.norm());
            weighted += w * (fluid.pressure[f] - fluid.density[f] * body_force.dot(&x_fs));
            weight += w;
        }
        let pressure = if weight > 0.0 { weighted / weight } else { 0.0 };
        Dummy {
            pressure,
            density: self.equation_of_state.wall_density(pressure),
            // In this order: samples of a solid that is coupled by loads carry the volume alone.
            mass: self.rest_density * solid.volume(s),
        }
    }

    /// Force of solid state `s` on fluid state `f` \[N/m\], Eq. (22) with the fluid's h and c₀.
    #[inline]
    fn force_on_fluid(
        &self,
        x_fs: &Vector,
        fluid: &InterfaceStates,
        f: usize,
        solid: &InterfaceStates,
        s: usize,
        dummy: &Dummy,
    ) -> Vector {
        let distance = x_fs.norm();
        let gradient_factor = self.gradient_scale * self.kernel.gradient_factor(distance);
        let (rho_f, rho_s) = (fluid.density[f], dummy.density);
        let masses = fluid.mass[f] * dummy.mass;
        let v_fs = fluid.velocity[f] - solid.velocity[s];
        let approach = v_fs.dot(x_fs);
        let regular_square = distance * distance + self.lambda * self.kernel.smoothing_length().powi(2);
        let viscosity = self.artificial_viscosity(approach, regular_square, 0.5 * (rho_f + rho_s));
        let central = fluid.mass[f] * self.repulsion(distance, approach)
            - masses * ((fluid.pressure[f] + dummy.pressure) / (rho_f * rho_s) + viscosity) * gradient_factor;
        match self.law {
            InterfaceLaw::Wall => x_fs * central,
            InterfaceLaw::WallNoSlip => {
                // Morris, Fox & Zhu 1997: 2 μ (x·∇W)/(ρ_f ρ_s r²) v_fs.
                let friction = masses * 2.0 * self.dynamic_viscosity * distance * distance * gradient_factor
                    / (rho_f * rho_s * regular_square);
                x_fs * central + v_fs * friction
            }
            InterfaceLaw::PlainSum => {
                let stress = SymmetricTensor::isotropic(-fluid.pressure[f]).plus(&solid.stress[s]);
                let factor = masses * gradient_factor;
                stress.dot(x_fs) * (factor / (rho_f * rho_s)) - x_fs * (factor * viscosity)
            }
        }
    }

    /// Repulsion over distance and mass of the fluid particle \[1/s²\], for v_fs·x_fs.
    ///
    /// Pressure alone can not keep out a particle that has been squeezed between two of the solid's. Coincident
    /// particles have no direction in which to part.
    #[inline]
    fn repulsion(&self, distance: f64, approach: f64) -> f64 {
        if distance >= self.repulsion.distance() || distance == 0.0 {
            return 0.0;
        }
        self.repulsion.acceleration(distance, approach / distance) / distance
    }

    /// Π_ij of Eq. (23)-(24), zero for receding particles.
    #[inline]
    fn artificial_viscosity(&self, approach: f64, regular_square: f64, mean_density: f64) -> f64 {
        if approach >= 0.0 {
            return 0.0;
        }
        let theta = self.kernel.smoothing_length() * approach / regular_square;
        (self.viscosity_b * theta - self.viscosity_a * self.sound_speed) * theta / mean_density
    }
}

#[cfg(test)]
mod tests;
