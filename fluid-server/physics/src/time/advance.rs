//! Advances the state by the rates and closes the momentum budget of a stage.

use sph::coupling::ledger::{Account, Accounts, AngularBudget, StageBudget, axial, lifted};
use sph::coupling::stage::{Stage, StageTime};
use sph::space::Space;
use sph::space::tensors::SpaceVector;
use sph::sums::ExactSums;

use super::checks::ScanFindings;
use super::energy_budget;
use super::momentum_budget::{AngularBudgetSums, MomentumBudget};
use super::movement::{MotionSlices, Movement, StageSlices, Step};
use super::stage::Workspace;
use super::stage_relaxation::StageRelaxation;
use super::state_scan::StateScan;
use crate::rates::particle_rates::{ExternalForces, StagePart};
use crate::system::model::FluidModel;
use crate::system::packed_particle::FluidSpace;
use crate::system::state::FluidState;
use crate::system::tasks::Groups;

/// Moves the state by the rates in `workspace`, scans the new one, and returns the momentum budget.
///
/// As in the source paper:
/// ```text
/// φⁿ⁺¹ᐟ² = φⁿ + Δt/2 F(φⁿ)                                        Eq. (30)
/// φⁿ⁺¹   = φⁿ + Δt F(φⁿ⁺¹ᐟ²)                                      Eq. (31)
/// ```
/// Leapfrog, with R of Eq. (17) and D of Eq. (18); of second order too, and neutral in energy up to its limit of
/// stability:
/// ```text
/// xⁿ⁺¹ᐟ² = xⁿ + Δt/2 vⁿ
/// ρⁿ⁺¹ᐟ² = ρⁿ⁻¹ᐟ² + Δt Dⁿ⁻¹ᐟ² + Δt̄ R(xⁿ, vⁿ),  Δt̄ between the middles of the steps
/// vⁿ⁺¹   = vⁿ + Δt a(xⁿ⁺¹ᐟ², ρⁿ⁺¹ᐟ², vⁿ),  with physical viscosity vⁿ + Δt/2 aⁿ⁻¹ᐟ² in place of vⁿ
/// xⁿ⁺¹   = xⁿ + Δt/2 (vⁿ + vⁿ⁺¹) + Δt δu
/// ρⁿ⁺¹   = ρⁿ⁺¹ᐟ² + Δt/2 (Dⁿ⁺¹ᐟ² + R(xⁿ, vⁿ))
/// ```
/// q of the acoustic relaxation follows ρ, as [`StageRelaxation`] says. The last line serves outputs and the other sums at
/// the step boundary: the next step subtracts its part of R again and adds the other half of D. In water that D
/// compresses and R relieves, the density would be too large with all of D.
pub fn advance<S: FluidSpace>(
    model: &FluidModel<S>,
    state: &mut FluidState<S>,
    workspace: &mut Workspace<S>,
    time: &StageTime,
) -> StageBudget {
    let Workspace {
        base,
        lists,
        fluid,
        rates,
        continuity,
        interface,
        external,
        budget,
        sums,
        findings_by_task,
        findings,
        part,
        current,
        energies,
        interface_powers,
        predicted,
        ..
    } = workspace;
    let (n, groups) = (state.len(), lists.placement().groups());
    if *part == StagePart::Whole {
        base.resize(state);
    }
    let FluidState {
        position,
        velocity,
        density,
        density_rate,
        density_correction,
        acceleration,
        relaxation,
        mass,
        list_origin,
        ..
    } = state;
    let step = Step {
        part: *part,
        stage: time.at.stage,
        duration: time.duration(),
        half: 0.5 * time.time_step,
        density_age: state.density_age,
        extrapolates: model.extrapolates_velocities(),
        damping: model.damping_rate(time.state_time()),
        inverse_h: 1.0 / model.constants.smoothing_length(),
        gravity: model.falling,
        origin: (!model.domain.is_periodic()).then(|| model.domain.torque_origin()),
        equation_of_state: model.equation_of_state,
        relaxation: model
            .acoustic_relaxation
            .map(|law| StageRelaxation::new(law, *part, state.density_age, time)),
        rates,
        continuity,
        mass,
    };
    let slices = StageSlices {
        motion: MotionSlices { position, velocity, density, relaxation },
        density_rate,
        density_correction,
        acceleration,
        base: MotionSlices {
            position: &mut base.position,
            velocity: &mut base.velocity,
            density: &mut base.density,
            relaxation: &mut base.relaxation,
        },
        fluid: &mut fluid[..n],
        budget: groups.values(budget),
        findings: groups.values(findings_by_task),
    };
    let scan = StateScan::new(model, list_origin.as_ref());
    if step.relaxation.is_some() {
        move_particles::<S, true>(model, &step, &scan, groups, slices);
    } else {
        move_particles::<S, false>(model, &step, &scan, groups, slices);
    }
    *current = true;
    let (duration, half, origin) = (step.duration, step.half, step.origin);
    let largest = budget.iter().map(|budget| budget.largest_acceleration).fold(0.0, f64::max);
    let mut own = std::mem::take(sums);
    own.iter_mut().for_each(ExactSums::clear);
    budget.iter().for_each(|budget| own[0].add(*budget));
    if *part != StagePart::Density {
        // The density stage has no forces.
        external.iter().for_each(|external| own[1].add(*external));
    }
    let own = (ScanFindings::of_tasks(state, findings_by_task), largest, own);
    let (found, largest, all) = model.team.join(own, |(found, largest, sums), other| {
        found.add(other.0);
        *largest = largest.max(other.1);
        sums.iter_mut().zip(&other.2).for_each(|(sums, others)| sums.merge(others));
    });
    *findings = found;
    let total = all[0].total(MomentumBudget::<S>::default());
    let forces = all[1].total(ExternalForces::<S>::default());
    *sums = all;
    *energies = (time.at.stage == Stage::Corrector).then_some(total.energies);
    let interface = interface.as_ref().map(|interface| interface.sums()).unwrap_or_default();
    if *part == StagePart::Density {
        // The velocity of this stage is an extrapolation: no force has acted.
        *predicted = total.compression;
        return StageBudget { interface, ..StageBudget::default() };
    }
    state.largest_acceleration = largest;
    if *part == StagePart::Momentum {
        state.density_age = half;
    }
    if time.at.stage == Stage::Corrector {
        let mut compression = total.compression;
        if *part == StagePart::Momentum {
            compression += *predicted;
        }
        let flows = &mut state.energy.flows;
        forces.powers.enter(flows, duration);
        energy_budget::enter_compression(flows, &compression);
        energy_budget::enter_interface(flows, *interface_powers, duration);
    }
    let removed = state.removed_momentum;
    let mut accounts = Accounts::default();
    accounts.add_force(Account::BodyForce, lifted(&forces.body.force));
    accounts.add_force(Account::Walls, lifted(&forces.walls.force));
    accounts.add_force(Account::Damping, lifted(&total.damping));
    accounts.add_force(Account::Stabilisers, lifted(&forces.stabilisers.force));
    // Particles leave at step boundaries: the next step accounts for their momentum in both of its stages.
    accounts.add_force(Account::Removed, lifted(&(-removed / duration)));
    let removed_angular = state.removed_angular_momentum;
    let angular =
        origin.map(|_| angular_budget(&mut accounts, &total.angular, &forces, removed_angular, duration));
    StageBudget {
        interface,
        accounts,
        angular,
        duration,
        momentum_change: lifted(&(total.momentum - removed)),
        gross_momentum: total.gross_momentum + duration * total.gross + removed.norm(),
    }
}

/// Moves all particles.
fn move_particles<S: FluidSpace, const RELAXES: bool>(
    model: &FluidModel<S>,
    step: &Step<'_, S>,
    scan: &StateScan<'_, S>,
    groups: &Groups,
    slices: StageSlices<'_, S>,
) {
    groups.for_each(groups.all(), slices, &|particles, slices| {
        model.arithmetic.run(Movement::<S, RELAXES> { step, scan, first: particles.start, slices });
    });
}

/// Where particle `i` was at the start of the step whose corrector produced `state` \[m\].
///
/// With leapfrog it is found from the step itself, to round-off.
pub fn start_of_step<S: FluidSpace>(
    state: &FluidState<S>,
    workspace: &Workspace<S>,
    time_step: f64,
    i: usize,
) -> S::Vector {
    if workspace.part == StagePart::Whole {
        return workspace.base.position[i];
    }
    let (x, v, rates) = (state.position[i], state.velocity[i], &workspace.rates[i]);
    let mean_velocity = v - rates.acceleration * (0.5 * time_step);
    x - (mean_velocity + rates.shift) * time_step
}

/// Enters the torques in `accounts`; returns the change of the angular momentum, of which `removed` \[kg m²/s\] was removed.
fn angular_budget<S: Space>(
    accounts: &mut Accounts,
    budget: &AngularBudgetSums<S>,
    forces: &ExternalForces<S>,
    removed: S::Spin,
    duration: f64,
) -> AngularBudget {
    for (account, torque) in [
        (Account::BodyForce, forces.body.torque),
        (Account::Walls, forces.walls.torque),
        (Account::Damping, budget.damping),
        (Account::Stabilisers, forces.stabilisers.torque),
        (Account::OwnForces, forces.own_torque),
        (Account::Removed, -removed / duration),
        (Account::Shifting, budget.shifting / duration),
        (Account::TimeScheme, budget.scheme / duration),
    ] {
        accounts.add_torque(account, axial(torque));
    }
    AngularBudget {
        change: axial(budget.change - removed),
        gross: budget.gross_change + duration * budget.gross_torque + axial(removed).norm(),
    }
}
