//! Rates of change of every fluid particle, Eq. (17)-(19), (22)-(24).

use std::marker::PhantomData;
use std::ops::Range;

use sph::coupling::ledger::EnergyAccount;
use sph::lanes::{LanePass, Lanes, WIDTH};
use sph::prescribed::body_force::BodyForceAt;
use sph::space::Plane;
use sph::space::geometry::Geometry;
use sph::space::tensors::SpaceVector;

use super::energy::{EnergyInput, ForcePowers};
use super::gradients::Gradients;
use super::particle_rates::{ExternalForces, Rates, StagePart, Wrench};
use super::power_sums::{ActingForces, ActivePowers, BLOCK, MovingParticles, PowerSums};
use crate::boundary::repulsion::wall_repulsion;
use crate::equations::continuity::density_rate;
use crate::equations::pair::{CentreParticle, LawLanes, NeighbourData, PairSums, PairTotals, PairViscosity};
use crate::equations::stress::{mirrored_stress, momentum_tensor};
use crate::equations::terms::{ActiveTerms, Continuity, ForceTerms, PairTerms, TermsPass};
use crate::free_surface::shifting::{self, Regularisation};
use crate::neighbours::batch::{NeighbourBatch, gather};
use crate::neighbours::scene::Scene;
use crate::system::lane_arrays::{get, numbers, vectors, weight};
use crate::system::model::{FluidModel, Viscosity};
use crate::system::packed_particle::{FluidSpace, NeighbourFields, Packed};
use crate::system::state::FluidState;
use crate::system::tasks::{PerTask, for_each_task, per_task};
use crate::system::walls::WallField;

/// Input of the rates.
#[derive(Clone, Copy)]
pub struct StageFields<'a, G, S: FluidSpace = Plane> {
    /// Fluid and walls.
    pub scene: Scene<'a, G, S>,
    /// State.
    pub state: &'a FluidState<S>,
    /// Kinematics of the walls.
    pub field: &'a WallField<S>,
    /// Results of the gradient pass.
    pub gradients: &'a Gradients<S>,
    /// Time of the stage state \[s\].
    pub time: f64,
    /// Part of the rates.
    pub part: StagePart,
    /// What the energy budget needs, in a corrector.
    pub energy: Option<EnergyInput<'a, S>>,
}

impl<S: FluidSpace, G: Geometry<S>> StageFields<'_, G, S> {
    /// Rates by the fluid itself, walls, body force, damping and regularisation into `rates`; where a stage computes all
    /// rates, the part of the density rate by continuity, Eq. (17), into `by_continuity` \[kg/(m³ s)\]; `external` gets the
    /// sums of each task.
    pub fn rates(
        &self,
        rates: &mut Vec<Rates<S>>,
        by_continuity: &mut Vec<f64>,
        external: &mut Vec<ExternalForces<S>>,
    ) {
        let model = self.scene.model;
        rates.resize(self.scene.fluid.len(), Rates::default());
        by_continuity.resize(if self.part == StagePart::Whole { rates.len() } else { 0 }, 0.0);
        if self.part == StagePart::Density {
            // The gradient pass has computed them.
            return;
        }
        let forces = force_terms(model);
        let continuity = match (self.part, forces.tensor || model.corrects_continuity()) {
            (StagePart::Momentum, _) => Continuity::Absent,
            (_, true) => Continuity::Corrected,
            (_, false) => Continuity::Plain,
        };
        let terms = ActiveTerms { neighbour_fields: model.has_neighbour_fields(), continuity, forces };
        terms.call(RatePass { fields: self, rates, by_continuity, external });
    }

    #[inline(always)]
    pub fn own<L: Lanes, T: PairTerms>(&self, i: usize) -> CentreParticle<S, L> {
        let (fluid, gradients) = (&self.scene.fluid[i], self.gradients);
        let fields = if T::NEIGHBOUR_FIELDS { gradients.neighbour_fields[i] } else { S::Fields::default() };
        let corrected = T::CORRECTION && self.scene.model.corrects_continuity();
        let l = if corrected { gradients.correction[i] } else { S::identity() };
        CentreParticle {
            motion: fluid.splat_motion(),
            density: L::splat(fluid.density()),
            twice_density: L::splat(2.0 * fluid.density()),
            pressure: L::splat(fluid.pressure() + fields.damper()),
            density_gradient: S::splat_each(&fields.density_gradient()),
            tensor: if T::TENSOR { S::splat_matrix(&gradients.tensor[i]) } else { S::zero_matrix() },
            correction: S::splat_symmetric(&l),
        }
    }

    /// Sums of particle `i` over its fluid neighbours.
    #[inline(always)]
    fn fluid_sums<L: Lanes, T: PairTerms>(
        &self,
        law: &LawLanes<L>,
        i: usize,
        own: &CentreParticle<S, L>,
    ) -> PairSums<S, L> {
        let Scene { geometry, lists, fluid, .. } = self.scene;
        let gradients = self.gradients;
        // The same length, as one check of an index then serves both.
        let neighbour_fields =
            if T::NEIGHBOUR_FIELDS { &gradients.neighbour_fields[..fluid.len()] } else { &[] };
        let tensors = if T::TENSOR { &gradients.tensor[..fluid.len()] } else { &[] };
        let mut sums = PairSums::zero();
        for indices in lists.fluid.of(i) {
            let indices = *indices;
            let mut batch = NeighbourBatch::<S, L>::gather(geometry, &own.motion, fluid, indices);
            let mut data = NeighbourData::nothing();
            if T::NEIGHBOUR_FIELDS {
                let (damper, _, gradient) = S::Fields::lanes(indices.map(|j| &neighbour_fields[j as usize]));
                batch.pressure = batch.pressure + damper;
                data.density_gradient = gradient;
            }
            if T::TENSOR {
                data.tensor = S::tensor_lanes(indices.map(|j| &tensors[j as usize]));
            }
            if T::VISCOUS {
                let viscosity = L::splat(gradients.viscosity[i]) + gather(indices, &gradients.viscosity);
                data.viscosity = PairViscosity { viscosity, relative_velocity: batch.v };
            }
            sums.add::<T>(law, own, &batch, &data);
        }
        sums
    }

    /// Sums of particle `i` over the particles of `wall`, or of all walls.
    ///
    /// A wall takes ∇ρ, L and damper of the particle, and its viscous stress, mirrored where it slips.
    #[inline(always)]
    pub fn wall_sums<L: Lanes, T: PairTerms>(
        &self,
        law: &LawLanes<L>,
        i: usize,
        own: &CentreParticle<S, L>,
        wall: Option<u32>,
    ) -> PairSums<S, L> {
        let Scene { geometry, model, lists, walls, .. } = self.scene;
        let damper = L::splat(self.damper(i));
        let correction = if T::TENSOR { self.gradients.in_momentum(model, i) } else { S::identity() };
        let mut sums = PairSums::zero();
        for indices in lists.walls.of(i) {
            let indices = *indices;
            let mut batch = NeighbourBatch::<S, L>::gather(geometry, &own.motion, walls, indices);
            if let Some(wall) = wall {
                let included = |w: u32| f64::from(u8::from(model.walls.wall.get(w as usize) == Some(&wall)));
                batch.volume = batch.volume * L::from_array(indices.map(included));
            }
            batch.pressure = batch.pressure + damper;
            let mut data =
                NeighbourData { density_gradient: own.density_gradient, ..NeighbourData::nothing() };
            if T::TENSOR {
                let tensors = indices.map(|w| self.wall_tensor(i, w as usize, correction));
                data.tensor = S::tensor_lanes(tensors.each_ref());
            }
            if T::VISCOUS {
                let viscosity = L::splat(2.0 * self.gradients.viscosity[i]);
                data.viscosity =
                    PairViscosity { viscosity, relative_velocity: self.resisted(indices, &batch) };
            }
            sums.add::<T>(law, own, &batch, &data);
        }
        sums
    }

    /// q of the acoustic damper of particle `i` \[Pa\].
    pub fn damper(&self, i: usize) -> f64 {
        self.gradients.damper(i)
    }

    /// The part of the velocity relative to walls that viscosity resists: all of it, or where they slip that along
    /// their normal.
    #[inline(always)]
    fn resisted<L: Lanes>(&self, indices: [u32; WIDTH], batch: &NeighbourBatch<S, L>) -> S::Of<L> {
        let normals = indices.map(|w| self.mirror_normal(w as usize));
        let normal = S::lanes::<L>(normals.each_ref());
        let along = L::splat(1.0) - S::dot(normal, normal);
        S::plus_product(S::scaled(batch.v, along), S::dot(batch.v, normal), normal)
    }

    /// Adds the powers of the `acting` forces on `particles`.
    #[inline(always)]
    fn add_powers<L: Lanes, T: PairTerms>(
        &self,
        powers: &mut PowerSums<L>,
        energy: &EnergyInput<'_, S>,
        particles: Range<usize>,
        acting: &[ActingForces<S>; BLOCK],
        (damping, active): (f64, &ActivePowers),
    ) {
        let half = L::splat(energy.half);
        for (first, acting) in particles.clone().step_by(WIDTH).zip(acting.as_chunks::<WIDTH>().0) {
            let [a, b, c, d] = acting.each_ref().map(|acting| &acting.acceleration);
            let mut acceleration = S::lanes::<L>([a, b, c, d]);
            if !energy.by_solids.is_empty() {
                acceleration = S::plus(acceleration, vectors::<S, L>(energy.by_solids, first));
            }
            let start = vectors::<S, L>(energy.start_velocity, first);
            let velocity = if active.damping || active.scheme {
                let velocities = get(self.scene.fluid, first).map(|particle| particle.velocity());
                S::lanes(velocities.each_ref())
            } else {
                S::splat(L::zero())
            };
            let particles = MovingParticles {
                mass: numbers::<L>(&self.state.mass, first) * weight(first, particles.end),
                density: numbers(&self.state.density, first),
                mean_velocity: S::plus(start, S::scaled(acceleration, half)),
                velocity,
            };
            powers.add::<S, T>(acting, &particles, (damping, &energy.falling), active);
        }
    }

    /// Adds what acoustic damper and viscous stress lose at `particles`.
    ///
    /// ```text
    /// V q²/(ρ α c₀ h),   V τ:∇v
    /// ```
    fn add_losses(&self, powers: &mut ForcePowers, particles: Range<usize>) {
        let (model, fluid) = (&self.scene.model, &self.scene.fluid);
        if model.has_damper() {
            powers.damper += particles
                .clone()
                .map(|i| {
                    let q = self.damper(i);
                    fluid[i].volume() * q * q / (fluid[i].density() * model.acoustic_diffusivity)
                })
                .sum::<f64>();
        }
        if let Some(dissipation) = self.gradients.dissipation.get(particles.clone()) {
            powers.stress += fluid[particles]
                .iter()
                .zip(dissipation)
                .map(|(particle, lost)| particle.volume() * lost)
                .sum::<f64>();
        }
    }

    /// Moves to the account of walls what those near particle `i` that move do by their motion.
    fn credit_walls<L: Lanes, T: PairTerms>(
        &self,
        powers: &mut ForcePowers,
        energy: &EnergyInput<'_, S>,
        law: &LawLanes<L>,
        i: usize,
    ) {
        let Scene { model, lists, fluid, .. } = self.scene;
        let (own, particle, mass) = (self.own::<L, T>(i), &fluid[i], self.state.mass[i]);
        for (wall, motion) in (0..).zip(energy.motions) {
            let near = |w: usize| model.walls.wall[w] == wall;
            let Some(motion) = motion.as_ref().filter(|_| lists.walls.neighbours(i).any(near)) else {
                continue;
            };
            let sums = self.wall_sums::<L, T>(law, i, &own, Some(wall));
            let pairs = sums.total().stress_divergence / -particle.density();
            let repulsion = wall_repulsion(&self.scene, self.field, i, Some(wall));
            let velocity = motion.velocity_at(&particle.position());
            let extent = (mass, particle.volume());
            powers.credit_wall(extent, &velocity, &pairs, &sums.parts(law), &repulsion);
        }
    }

    /// Normal of the mirror of wall particle `w`; none for the one that does not act.
    fn mirror_normal(&self, w: usize) -> S::Vector {
        self.field.mirror_normal.get(w).copied().unwrap_or_default()
    }

    /// T of wall particle `w` in the pair with particle `i`, with L_i as in Eq. (22).
    fn wall_tensor(&self, i: usize, w: usize, correction: S::Symmetric<f64>) -> S::Matrix<f64> {
        let normal = S::components(&self.mirror_normal(w));
        let stress = self.gradients.viscous_stress.get(i);
        let stress = stress.map_or(S::zero_matrix(), |stress| mirrored_stress::<S>(*stress, normal));
        momentum_tensor::<S>(self.scene.walls[w].pressure() + self.damper(i), stress, correction)
    }
}

/// Terms of the momentum equation of `model`.
pub fn force_terms<S: FluidSpace>(model: &FluidModel<S>) -> ForceTerms {
    ForceTerms { tensor: model.has_tensors(), viscous: model.viscosity == Viscosity::Pairwise }
}

/// The pass over all particles.
struct RatePass<'a, G, S: FluidSpace> {
    fields: &'a StageFields<'a, G, S>,
    rates: &'a mut [Rates<S>],
    by_continuity: &'a mut [f64],
    external: &'a mut Vec<ExternalForces<S>>,
}

impl<S: FluidSpace, G: Geometry<S>> TermsPass for RatePass<'_, G, S> {
    type Output = ();

    fn call<T: PairTerms>(self) {
        let Self { fields, rates, by_continuity, external } = self;
        let Scene { model, fluid, .. } = fields.scene;
        let body_force = &model.body_force.at(fields.time);
        for_each_task(fluid.len(), ((rates, by_continuity), per_task(external, fluid.len())), &|particles,
                                                                                                (
            (rates, by_continuity),
            external,
        )| {
            let (terms, first, PerTask(external)) = (PhantomData::<T>, particles.start, external);
            let external = &mut external[0];
            model.arithmetic.run(Evaluate {
                fields,
                terms,
                body_force,
                first,
                rates,
                by_continuity,
                external,
            });
        });
    }
}

/// The rates of the particles of one task.
struct Evaluate<'a, G, S: FluidSpace, T> {
    fields: &'a StageFields<'a, G, S>,
    terms: PhantomData<T>,
    body_force: &'a BodyForceAt<'a, S>,
    first: usize,
    rates: &'a mut [Rates<S>],
    by_continuity: &'a mut [f64],
    external: &'a mut ExternalForces<S>,
}

impl<S: FluidSpace, G: Geometry<S>, T: PairTerms> LanePass for Evaluate<'_, G, S, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { fields, body_force, first, rates, by_continuity, external, .. } = self;
        let StageFields { scene, state, gradients, time, .. } = fields;
        let model = scene.model;
        let (damping, origin) = (model.damping_rate(*time), model.domain.torque_origin());
        let law = LawLanes::<L>::new(model);
        let (mut powers, mut lost) = (PowerSums::<L>::none(), ForcePowers::default());
        let active = ActivePowers {
            clumping: model.constants.artificial_pressure > 0.0,
            repulsion: model.energy_accounts.contains(&EnergyAccount::Repulsion),
            body_force: model.energy_accounts.contains(&EnergyAccount::BodyForce),
            damping: damping != 0.0,
            regularisation: T::NEIGHBOUR_FIELDS && model.regularisation.is_some(),
            scheme: fields.part == StagePart::Whole,
        };
        let count = rates.len();
        let mut acting = [ActingForces::<S>::default(); BLOCK];
        for start in (0..count).step_by(BLOCK) {
            let block = start..count.min(start + BLOCK);
            for (k, acting) in block.clone().zip(&mut acting) {
                let i = first + k;
                let own = fields.own::<L, T>(i);
                let pairs = fields.fluid_sums::<L, T>(&law, i, &own);
                let sums = pairs.total();
                let rho = scene.fluid[i].density();
                let by_fluid = sums.stress_divergence / -rho;
                // Most particles are far from walls.
                let (mut walls, mut by_walls) = (PairTotals::<S>::default(), S::Vector::zeros());
                let mut repulsion = S::Vector::zeros();
                let at_walls = (!scene.lists.walls.of(i).is_empty()).then(|| {
                    let pairs = fields.wall_sums::<L, T>(&law, i, &own, None);
                    (pairs, wall_repulsion(scene, fields.field, i, None))
                });
                if let Some((pairs, repels)) = &at_walls {
                    walls = pairs.total();
                    repulsion = *repels;
                    by_walls = walls.stress_divergence / -rho + repulsion;
                }
                let body = body_force.acceleration(&state.position[i]);
                let mut regularisation = Regularisation::<S>::default();
                if let (true, Some(order)) = (T::NEIGHBOUR_FIELDS, &model.regularisation) {
                    let (all, sums) = (&gradients.neighbour_fields, &gradients.regularisation[i]);
                    let near = gradients.is_near_surface(i);
                    let excess = state.volume_excess.get(i).copied().unwrap_or_default();
                    regularisation =
                        shifting::regularise::<S, L, G>(order, scene, i, all, near, sums, excess);
                }
                let continuity = density_rate(rho, -(sums.continuity + walls.continuity));
                let damped = scene.fluid[i].velocity() * damping;
                rates[k] = Rates {
                    acceleration: by_fluid + by_walls + body - damped + regularisation.acceleration,
                    shift: regularisation.shift,
                    density: continuity
                        + model.diffusion * (sums.diffusion + walls.diffusion)
                        + regularisation.density,
                    volume: regularisation.density,
                };
                if let Some(place) = by_continuity.get_mut(k) {
                    *place = continuity;
                }
                let (m, arm) = (state.mass[i], state.position[i] - origin);
                external.body += Wrench::at(&arm, body * m);
                external.walls += Wrench::at(&arm, by_walls * m);
                external.stabilisers += Wrench::at(&arm, regularisation.acceleration * m);
                external.own_torque += S::cross(&arm, &(by_fluid * m));
                if let Some(energy) = &fields.energy {
                    let mut parts = pairs.parts(&law);
                    if let Some((pairs, _)) = &at_walls {
                        parts += pairs.parts(&law);
                        if !energy.motions.is_empty() {
                            fields.credit_walls::<L, T>(&mut lost, energy, &law, i);
                        }
                    }
                    *acting = ActingForces {
                        acceleration: rates[k].acceleration,
                        forces: by_fluid + by_walls,
                        parts,
                        repulsion,
                        body,
                        regularisation: regularisation.acceleration,
                        advection: regularisation.advection,
                        shift: regularisation.shift,
                    };
                }
            }
            if let Some(energy) = &fields.energy {
                let particles = first + block.start..first + block.end;
                fields.add_powers::<L, T>(&mut powers, energy, particles, &acting, (damping, &active));
            }
        }
        if fields.energy.is_some() {
            fields.add_losses(&mut lost, first..first + count);
            external.powers = powers.total();
            external.powers += lost;
        }
    }
}
