//! The energy budget of the solids: work of the forces wherever velocities change, and the report.
//!
//! A force f that acts for τ while the velocity goes from v₀ to v₁ does the work τ f·½(v₀ + v₁): summed over all forces
//! this is the change of kinetic energy, exactly. Of a rigid body both velocities are those of the material at the
//! particle while forces act.

use std::ops::AddAssign;

use sph::coupling::ledger::{EnergyAccount as A, EnergyReport, EnergyTally, EnergyValues};
use sph::coupling::stage::StageTime;
use sph::space::tensors::SpaceVector;
use sph::sums::ordered_sum;

use crate::formulations::formulation::StrainRule;
use crate::particles::forces::ParticleForces;
use crate::particles::variables::image_offset;
use crate::report::body_sums::body_sums;
use crate::space::SolidSpace;
use crate::system::model::SolidModel;
use crate::system::state::SolidState;
use crate::system::workspace::Workspace;

/// Work of the forces on particles in one change of their velocities \[J/m\].
#[derive(Clone, Copy, Default)]
struct ForceWork {
    gravity: f64,
    body_force: f64,
    loads: f64,
    damping: f64,
    viscosity: f64,
    artificial_stress: f64,
    stress: f64,
    contact: f64,
    friction: f64,
    film: f64,
    walls: f64,
    interface: f64,
}

impl AddAssign for ForceWork {
    fn add_assign(&mut self, other: Self) {
        self.gravity += other.gravity;
        self.body_force += other.body_force;
        self.loads += other.loads;
        self.damping += other.damping;
        self.viscosity += other.viscosity;
        self.artificial_stress += other.artificial_stress;
        self.stress += other.stress;
        self.contact += other.contact;
        self.friction += other.friction;
        self.film += other.film;
        self.walls += other.walls;
        self.interface += other.interface;
    }
}

impl ForceWork {
    /// Power of `forces` and of the `fluid`'s force \[N/m\] on a particle that moves with `velocity` \[m/s\], of `weight`
    /// \[N/m\].
    fn power<S: SolidSpace>(
        forces: &ParticleForces<S>,
        fluid: &S::Vector,
        velocity: &S::Vector,
        weight: &S::Vector,
    ) -> Self {
        let ParticleForces { parts, .. } = forces;
        let viscosity = parts.viscous.dot(velocity);
        let mut power = Self {
            gravity: weight.dot(velocity),
            viscosity,
            stress: forces.own.dot(velocity) - viscosity,
            interface: fluid.dot(velocity),
            ..Self::default()
        };
        if parts.varies {
            power.body_force = (forces.body_force - parts.load - *weight).dot(velocity);
            power.loads = parts.load.dot(velocity);
            power.damping = forces.damping.dot(velocity);
            power.artificial_stress = parts.artificial.dot(velocity);
            power.stress -= power.artificial_stress;
        }
        let [film_bodies, film_walls] = forces.film;
        let film = film_bodies + film_walls;
        if film != S::Vector::zeros() {
            // As the walls', what they do by their motion is theirs.
            power.film = film.dot(velocity) - forces.film_wall_power;
            power.walls = forces.film_wall_power;
        }
        if forces.contact_gross > 0.0 {
            let friction = parts.friction.dot(velocity);
            // What a moving wall does by its motion is no loss of the contact.
            power.contact = (forces.contact + forces.walls - film).dot(velocity)
                - friction
                - (parts.wall_power - parts.wall_friction_power);
            power.friction = friction - parts.wall_friction_power;
            power.walls += parts.wall_power;
        }
        power
    }

    /// Enters this power over `duration` \[s\] on a body whose strain follows `rule`.
    fn enter(&self, flows: &mut EnergyValues, duration: f64, rule: StrainRule) {
        let strain = match rule {
            StrainRule::OfPositions => A::TimeScheme,
            StrainRule::Evolves => A::CorrectedGradients,
        };
        for (account, power) in [
            (A::TimeScheme, -self.gravity),
            (A::BodyForce, self.body_force),
            (A::Loads, self.loads),
            (A::Damping, -self.damping),
            (A::ArtificialViscosity, -self.viscosity),
            (A::ArtificialPressure, -self.artificial_stress),
            (strain, -self.stress),
            (A::Contact, -self.contact),
            (A::Friction, -self.friction),
            (A::Film, self.film),
            (A::Walls, self.walls),
            (A::Interface, self.interface),
        ] {
            flows.add(account, duration * power);
        }
    }
}

/// Enters in `workspace.energy` the work of `workspace.forces`, of the fluid and of the supports of deformable bodies
/// while the velocities went from `workspace.kicked_from` to those of `workspace.next` in `duration` \[s\].
///
/// The supports of rigid bodies are in [`AngularImpulse`](crate::formulations::formulation::AngularImpulse).
pub fn enter_kick<S: SolidSpace>(
    model: &SolidModel<S>,
    workspace: &mut Workspace<S>,
    time: &StageTime,
    duration: f64,
) {
    let Workspace { next, kicked_from, forces, fluid_force, total_force, energy, .. } = workspace;
    let gravity = model.body_force.gravity();
    for body in &model.bodies {
        let first = body.range.start;
        let mean = |i: usize| (kicked_from[i] + next.velocity[i]) * 0.5;
        let work: ForceWork = ordered_sum(body.range.len(), |k| {
            let i = first + k;
            ForceWork::power::<S>(&forces[i], &fluid_force[i], &mean(i), &(gravity * model.particles.mass[i]))
        });
        work.enter(energy, duration, body.formulation.strain_rule());
        if body.formulation.is_rigid() {
            continue;
        }
        for support in body.supports.iter().filter(|support| support.acts(time)) {
            let work: f64 = ordered_sum(support.particles.len(), |k| {
                let i = first + support.particles[k].particle;
                let gained = (next.velocity[i] - kicked_from[i]) * model.particles.mass[i];
                let (missing, mean) = (gained - total_force[i] * duration, mean(i));
                (0..S::DIMENSIONS)
                    .filter(|axis| support.held[*axis])
                    .map(|axis| missing[axis] * mean[axis])
                    .sum::<f64>()
            });
            energy.add(A::Supports, work);
        }
    }
}

/// [`enter_kick`] for a stage of Eq. (30)-(31), in which the velocities go from those of `state` to those of
/// `workspace.next` under the forces of the stage state.
///
/// Forces on a rigid body act at the places of the stage state, so that the velocities are those of the material there.
pub fn enter_stage<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    workspace: &mut Workspace<S>,
    time: &StageTime,
) {
    let Workspace { stage, stage_rigid, next, next_rigid, kicked_from, .. } = workspace;
    kicked_from.clone_from(&state.particles.velocity);
    for (k, body) in model.bodies.iter().enumerate().filter(|(_, body)| body.formulation.is_rigid()) {
        let (start, end) = (&state.rigid[k], &next_rigid[k]);
        for i in body.range.clone() {
            let offset = image_offset(&model.domain, &state.image_counts[i]);
            let arm = stage.position[i] + offset - stage_rigid[k].centre;
            let both = start.velocity
                + end.velocity
                + S::spin_cross(start.angular_velocity + end.angular_velocity, &arm);
            // So that the mean with the new velocity of the particle is that at the arm of the stage.
            kicked_from[i] = both - next.velocity[i];
        }
    }
    enter_kick(model, workspace, time, time.duration());
}

/// Stores of `state`, and what conservative forces have stored by the rule of each account.
struct Stored {
    values: EnergyValues,
    /// Potential energy and strain whose forces derive from positions \[J/m\].
    of_positions: f64,
    /// Strain that evolves by itself \[J/m\].
    evolving: f64,
}

impl Stored {
    fn of<S: SolidSpace>(model: &SolidModel<S>, state: &SolidState<S>) -> Self {
        let mut stored = Self { values: EnergyValues::default(), of_positions: 0.0, evolving: 0.0 };
        for body in &model.bodies {
            let sums = body_sums(model, state, &body.range);
            stored.values.add(A::Kinetic, sums.kinetic);
            stored.values.add(A::Potential, sums.potential);
            stored.values.add(A::Strain, sums.strain);
            stored.of_positions += sums.potential;
            match body.formulation.strain_rule() {
                StrainRule::OfPositions => stored.of_positions += sums.strain,
                StrainRule::Evolves => stored.evolving += sums.strain,
            }
        }
        stored
    }
}

/// The tally of a run that starts in `state`.
///
/// The accounts that compare the work of conservative forces with what they store begin with what is stored.
pub fn start<S: SolidSpace>(model: &SolidModel<S>, state: &SolidState<S>) -> EnergyTally {
    let stored = Stored::of(model, state);
    let mut tally = EnergyTally { start: stored.values, ..EnergyTally::default() };
    tally.flows.add(A::TimeScheme, stored.of_positions);
    tally.flows.add(A::CorrectedGradients, stored.evolving);
    tally
}

/// The report at a boundary.
pub fn report<S: SolidSpace>(model: &SolidModel<S>, state: &SolidState<S>) -> EnergyReport {
    let stored = Stored::of(model, state);
    let mut flows = state.energy.flows;
    flows.add(A::TimeScheme, -stored.of_positions);
    flows.add(A::CorrectedGradients, -stored.evolving);
    EnergyReport::new(&model.energy_accounts, &state.energy.start, &stored.values, &flows)
}
