//! From set-up data to model, state and workspace.

use sph::coupling::ledger::{EnergyAccount, EnergyTally, EnergyValues, InterfaceSums};
use sph::coupling::stage::{StageTime, StepStage};
use sph::lanes::Arithmetic;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{SolidParticles, SolidSetup};
use sph::space::tensors::SpaceVector;

use crate::boundary::walls::Walls;
use crate::build::bodies::{build_bodies, build_contact, initial_image_counts};
use crate::build::validate::{check_arrays, check_periods, check_sums};
use crate::contact::film::Film;
use crate::contact::friction::TangentialSprings;
use crate::contact::repulsion::{Contacts, Repulsion};
use crate::contact::start::start_depths;
use crate::formulations::body::Body;
use crate::formulations::formulation::AngularImpulse;
use crate::formulations::pair_law::PairSums;
use crate::interface::solid_interface::SolidInterface;
use crate::neighbours::lists::{ContactLists, OWN_SKIN, OwnLists};
use crate::particles::constants::ParticleConstants;
use crate::particles::fields::{Rates, StressFields};
use crate::particles::forces::{ContactForces, ParticleForces, ParticleTorques};
use crate::particles::variables::{Particles, RigidState};
use crate::report::body_sums::best_fit_rotation;
use crate::report::probes::build_probes;
use crate::space::SolidSpace;
use crate::system::model::{ContactModel, SolidModel};
use crate::system::state::{BodyContact, LastStage, SolidState};
use crate::system::workspace::Workspace;
use crate::time::energy_budget;

mod bodies;
mod validate;

/// Model and initial state of `setup`, or all its errors.
pub fn build<S: SolidSpace>(
    setup: SolidSetup<S>,
    arithmetic: Arithmetic,
) -> Result<(SolidModel<S>, SolidState<S>), Vec<String>> {
    let ranges = check_arrays(&setup)?;
    let mut errors = Vec::new();
    let domain = setup.run.domain;
    let start_time = setup.run.time.start_time;
    let mut particles = Particles {
        position: setup.particles.position.iter().map(|x| domain.wrapped(x)).collect(),
        velocity: setup.particles.velocity.clone(),
        density: setup.particles.density.clone(),
        deviatoric_stress: setup.particles.deviatoric_stress.clone(),
    };
    let image_counts =
        initial_image_counts(&domain, &ranges, &setup.particles.reference_position, &particles.position);
    let walls = Walls::new(&setup, &mut errors);
    let contact = build_contact(&setup);
    let (mut bodies, rigid) = build_bodies(
        &setup,
        &ranges,
        arithmetic,
        (&walls, contact.clearance::<S>()),
        &image_counts,
        &mut particles,
        &mut errors,
    );
    let body_force = BodyForceField::new(&setup.run.body_force).unwrap_or_else(|error| {
        errors.push(error.to_string());
        BodyForceField::uniform(setup.run.body_force.gravity)
    });
    let probes = build_probes(&setup, &mut bodies, &mut errors);
    let energy_accounts = EnergyAccount::of_solid(&setup);
    let SolidParticles { id, body, support, mass, reference_position, .. } = setup.particles;
    let mut model = SolidModel {
        domain,
        spacing: setup.particle_spacing,
        bodies,
        particles: ParticleConstants { id, body, support, mass, reference_position },
        contact,
        walls,
        body_force,
        damping: setup.damping,
        stepping: setup.stepping,
        probes,
        lost_particle_limit: setup.lost_particle_limit,
        energy_accounts,
    };
    check_sums(&model, setup.run.coupling.as_ref().map(|coupling| coupling.law), &mut errors);
    check_periods(&model, &mut errors);
    if !errors.is_empty() {
        return Err(errors);
    }
    let start = StageTime { at: StepStage::FIRST, step_start: start_time, time_step: 0.0 };
    if let ContactModel::Repulsion(law) = &model.contact {
        let depths = start_depths(&model, law, &start);
        model.contact = ContactModel::Repulsion(Box::new(Repulsion { start: depths, ..(**law).clone() }));
    }
    let state = initial_state(&model, particles, rigid, image_counts, start_time);
    crate::time::checks::check(&model, &state.particles, start.at)
        .and_then(|()| crate::time::checks::check_domain(&model, &state.particles, &start))
        .map_err(|divergence| vec![format!("the initial state is not usable: {divergence}")])?;
    Ok((model, state))
}

/// Buffers for `model` in `state`.
pub fn build_workspace<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    coupling: Option<&sph::setup::Coupling>,
) -> Workspace<S> {
    let (n, walls) = (model.len(), model.walls.len());
    let own_list = |body: &Body<S>| {
        body.formulation.list_radius().map(|radius| OwnLists::new(radius, OWN_SKIN * model.spacing))
    };
    let film = match (&model.contact, coupling) {
        (ContactModel::Repulsion(law), Some(coupling)) if law.wet && coupling.has_wall_states() => {
            Some(Film::new(coupling, law.fields.wall_spacing, n))
        }
        _ => None,
    };
    let reach = film.as_ref().map_or(0.0, Film::reach);
    Workspace {
        stage: state.particles.clone(),
        stage_rigid: state.rigid.clone(),
        next: state.particles.clone(),
        next_rigid: state.rigid.clone(),
        stress: StressFields::new(n),
        sums: vec![PairSums::zero(); n],
        rates: Rates::new(n),
        contact_forces: vec![ContactForces::default(); n],
        contacts: Contacts::default(),
        film,
        springs: state.springs.clone(),
        start_springs: state.springs.clone(),
        loads: if model.bodies.iter().any(|body| body.acceleration.is_some() || !body.loads.is_empty()) {
            vec![S::Vector::zeros(); n]
        } else {
            Vec::new()
        },
        forces: vec![ParticleForces::default(); n],
        start_forces: vec![ParticleForces::default(); n],
        mean_forces: vec![ParticleForces::default(); n],
        mean_torques: vec![ParticleTorques::default(); n],
        angular_impulse: AngularImpulse::default(),
        kicked_from: vec![S::Vector::zeros(); n],
        energy: EnergyValues::default(),
        exchange_position: Vec::new(),
        fluid_force: vec![S::Vector::zeros(); n],
        total_force: vec![S::Vector::zeros(); n],
        velocity_gain: vec![S::Vector::zeros(); n],
        own_lists: model.bodies.iter().map(own_list).collect(),
        contact_lists: ContactLists::new(
            model.spacing,
            model.contact.radii(),
            model.contact.radii().at_least(reach),
            n,
            walls,
        ),
        walls: model.walls.at_start(),
        wall_pressure: vec![0.0; walls],
        reactions: state.last.reactions.clone(),
        fluid: coupling.map(|coupling| {
            SolidInterface::new(coupling, &model.domain, &model.body_force, &state.particles.position)
        }),
        interface_sums: InterfaceSums::default(),
        list_builds: 0,
        substeps: 0,
    }
}

fn initial_state<S: SolidSpace>(
    model: &SolidModel<S>,
    particles: Particles<S>,
    rigid: Vec<RigidState<S>>,
    image_counts: Vec<S::Of<i32>>,
    start_time: f64,
) -> SolidState<S> {
    let mut state = SolidState {
        particles,
        rigid,
        image_counts,
        rotations: vec![S::Rotation::default(); model.bodies.len()],
        springs: TangentialSprings { time: start_time, entries: Vec::new() },
        energy: EnergyTally::default(),
        last: LastStage {
            fluid_force: vec![S::Vector::zeros(); model.bodies.len()],
            reactions: model.bodies.iter().map(|b| vec![S::Vector::zeros(); b.supports.len()]).collect(),
            contacts: vec![BodyContact::default(); model.bodies.len()],
            ..LastStage::default()
        },
    };
    for (k, body) in model.bodies.iter().enumerate() {
        state.rotations[k] =
            best_fit_rotation(model, body, &state.particles, &state.image_counts, S::Rotation::default());
    }
    state.energy = energy_budget::start(model, &state);
    state.last.maxima.largest_acceleration = largest_body_force(model, &state.particles, start_time);
    state
}

/// Largest acceleration by body forces at the start \[m/s²\], which limits the first step.
fn largest_body_force<S: SolidSpace>(
    model: &SolidModel<S>,
    particles: &Particles<S>,
    start_time: f64,
) -> f64 {
    let of_particle = |i: usize| {
        let x = &particles.position[i];
        let of_body = model.body_of(i).acceleration.as_ref().map(|field| field.acceleration(x, start_time));
        (model.body_force.acceleration(x, start_time) + of_body.unwrap_or_default()).norm()
    };
    (0..model.len()).map(of_particle).fold(0.0, f64::max)
}
