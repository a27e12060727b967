//! Rates of change of every fluid particle, Eq. (17)-(19), (22)-(24).

use std::marker::PhantomData;

use sph::coupling::ledger::EnergyAccount;
use sph::lanes::{LanePass, Lanes};
use sph::prescribed::body_force::BodyForceAt;
use sph::space::geometry::Geometry;
use sph::space::tensors::SpaceVector;
use sph::tasks::PerTask;

use super::energy::ForcePowers;
use super::particle_rates::{ExternalForces, Rates, StagePart, Wrench};
use super::power_sums::{ActingForces, ActivePowers, AddPowers, BLOCK, PowerSums};
use super::stage_fields::StageFields;
use super::wall_pass::WallCredits;
use crate::boundary::repulsion::wall_repulsion;
use crate::equations::continuity::density_rate;
use crate::equations::pair::{LawLanes, PairTotals};
use crate::equations::terms::{ActiveTerms, ForceTerms, PairTerms, TermsPass};
use crate::equations::voids::Void;
use crate::free_surface::shifting::{self, Regularisation};
use crate::neighbours::placement::Needs;
use crate::system::model::{FluidModel, Viscosity};
use crate::system::packed_particle::{FluidSpace, Packed};

impl<S: FluidSpace, G: Geometry<S>> StageFields<'_, G, S> {
    /// Rates of own particles with such `needs`, those with [`Needs::Nothing`] first: by the fluid itself, walls, body force,
    /// damping and regularisation into `rates`; where a stage computes all rates, the part of the density rate by continuity,
    /// Eq. (17), into `by_continuity` \[kg/(m³ s)\]; `external` gets the sums of each group.
    pub fn rates(
        &self,
        needs: Needs,
        rates: &mut Vec<Rates<S>>,
        by_continuity: &mut Vec<f64>,
        external: &mut Vec<ExternalForces<S>>,
    ) {
        let model = self.scene.model;
        rates.resize(self.state.len(), Rates::default());
        by_continuity.resize(if self.part == StagePart::Whole { rates.len() } else { 0 }, 0.0);
        if self.part == StagePart::Density {
            // The gradient pass has computed them.
            return;
        }
        let terms = ActiveTerms {
            neighbour_fields: model.has_neighbour_fields(),
            continuity: self.part == StagePart::Whole,
            forces: force_terms(model),
        };
        let placement = self.scene.lists.placement();
        if needs == Needs::Nothing {
            placement.groups().values(external);
        }
        terms.call(RatePass {
            fields: self,
            groups: placement.groups_with(needs),
            rates,
            by_continuity,
            external,
        });
    }
}

/// Terms of the momentum equation of `model`.
pub fn force_terms<S: FluidSpace>(model: &FluidModel<S>) -> ForceTerms {
    match model.viscosity {
        _ if model.has_symmetric_tensors() => ForceTerms::SymmetricTensor,
        _ if !model.has_tensors() => ForceTerms::Pressure,
        Viscosity::Pairwise => ForceTerms::TensorAndDrag,
        Viscosity::Stress | Viscosity::Inviscid => ForceTerms::Tensor,
    }
}

/// The pass over the particles of `groups`; results are those of all.
struct RatePass<'a, G, S: FluidSpace> {
    fields: &'a StageFields<'a, G, S>,
    groups: &'a [u32],
    rates: &'a mut [Rates<S>],
    by_continuity: &'a mut [f64],
    external: &'a mut [ExternalForces<S>],
}

impl<S: FluidSpace, G: Geometry<S>> TermsPass for RatePass<'_, G, S> {
    type Output = ();

    fn call<T: PairTerms>(self) {
        let Self { fields, groups, rates, by_continuity, external } = self;
        let model = fields.scene.model;
        let body_force = &model.body_force.at(fields.time);
        let results = ((rates, by_continuity), PerTask(external));
        fields.scene.lists.placement().groups().for_each(groups, results, &|particles,
                                                                            (
            (rates, by_continuity),
            PerTask(external),
        )| {
            let (terms, first, external) = (PhantomData::<T>, particles.start, &mut external[0]);
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

/// The rates of the particles of one group.
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
        let (mut powers, mut lost) = (PowerSums::default(), ForcePowers::default());
        let active = ActivePowers {
            drag: T::VISCOUS,
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
                // Most particles are far from walls. A closure of so many lanes would become a function without them.
                let (mut walls, mut by_walls) = (PairTotals::<S>::default(), S::Vector::zeros());
                let mut repulsion = S::Vector::zeros();
                let at_walls = if scene.wall_row(i).is_empty() {
                    None
                } else {
                    let pairs = fields.wall_sums::<L, T>(&law, i, &own, None);
                    Some((pairs, wall_repulsion(scene, fields.field, i, None)))
                };
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
                    let strain = S::symmetric_tensor(gradients.strain_rate[i]);
                    regularisation =
                        shifting::regularise::<S, L, G>(order, scene, i, all, near, sums, excess)
                            .advected(sums, &strain);
                }
                let mut continuity = density_rate(rho, -(sums.continuity + walls.continuity));
                if let (true, Some(sums)) = (T::CONTINUITY, gradients.regularisation.get(i))
                    && let Some(void) = Void::shown_by(model, &sums.concentration)
                {
                    continuity = void.density_rate(scene, i, continuity);
                }
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
                if fields.energy.is_some() {
                    let mut parts = pairs.parts(&law);
                    if let Some((pairs, _)) = &at_walls {
                        parts += pairs.parts(&law);
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
                let acting = &acting;
                model.arithmetic.run(AddPowers {
                    sums: &mut powers,
                    fluid: &scene.fluid[scene.own()],
                    state,
                    energy,
                    particles,
                    acting,
                    damping,
                    active: &active,
                });
            }
        }
        if let Some(energy) = &fields.energy {
            let particles = first..first + count;
            if !energy.motions.is_empty() {
                force_terms(model).call(WallCredits {
                    fields,
                    motions: energy.motions,
                    particles: particles.clone(),
                    powers: &mut lost,
                });
            }
            fields.add_losses(&mut lost, first..first + count);
            external.powers = powers.total();
            external.powers += lost;
        }
    }
}
