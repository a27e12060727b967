//! Stress, sums and forces of all bodies at one state.

use sph::coupling::stage::StageTime;
use sph::space::tensors::{SpaceTensor, SpaceVector};
use sph::tasks::for_each;

use crate::contact::repulsion::ContactStage;
use crate::contact::sums::SumStage;
use crate::neighbours::lists::{ContactFilter, Rows, TASK};
use crate::particles::fields::StressViewMut;
use crate::particles::forces::{ForceParts, ParticleForces, ParticleTorques};
use crate::space::SolidSpace;
use crate::system::model::{ContactModel, SolidModel};
use crate::system::workspace::Workspace;

/// Walls, stress and neighbour lists of the stage state at time `at` \[s\].
pub fn update_stage<S: SolidSpace>(
    model: &SolidModel<S>,
    workspace: &mut Workspace<S>,
    time: &StageTime,
    at: f64,
) {
    model.walls.move_to(at, &mut workspace.walls);
    update_stress(model, workspace);
    refresh_lists(model, workspace, time);
}

/// Pressure and stress of the stage state, and the variables derived from them.
fn update_stress<S: SolidSpace>(model: &SolidModel<S>, workspace: &mut Workspace<S>) {
    let Workspace { stage, stress, .. } = workspace;
    for body in &model.bodies {
        let range = &body.range;
        body.formulation.update_stress(&model.constants(body), &stage.view(range), stress.view_mut(range));
        body.formulation.derive(&stress.view(range), stage.view_mut(range));
    }
}

/// Rebuilds neighbour lists where particles have moved too far, for the step of `time`.
pub fn refresh_lists<S: SolidSpace>(model: &SolidModel<S>, workspace: &mut Workspace<S>, time: &StageTime) {
    let Workspace { stage, own_lists, contact_lists, walls, list_builds, .. } = workspace;
    let domain = &model.domain;
    for (body, lists) in model.bodies.iter().zip(own_lists) {
        if let Some(lists) = lists {
            *list_builds += u64::from(lists.refresh(domain, &stage.position[body.range.clone()]));
        }
    }
    let filter = ContactFilter {
        particles: model.has_contact().then_some(|i, j| model.may_be_in_contact(i, j)),
        walls: |i, w| model.wall_acts_on(i, w, time),
        released: model.released(time),
    };
    let walls = model.walls.places(walls);
    *list_builds += u64::from(contact_lists.refresh(domain, &stage.position, walls, &filter));
}

/// Sums over pairs of the solids among themselves and with walls, at the stage state of time `at` \[s\].
pub fn evaluate_pairs<S: SolidSpace>(model: &SolidModel<S>, workspace: &mut Workspace<S>, at: f64) {
    prescribe_loads(model, workspace, at);
    let Workspace { stage, stress, sums, own_lists, .. } = workspace;
    let none = Rows::default();
    for (body, lists) in model.bodies.iter().zip(own_lists) {
        let range = &body.range;
        body.formulation.evaluate(
            &model.constants(body),
            &stage.view(range),
            &stress.view(range),
            lists.as_ref().map_or(&none, |lists| &lists.rows),
            &mut sums[range.clone()],
        );
    }
    evaluate_contact(model, workspace, at);
}

/// Contact of bodies with each other and with walls.
fn evaluate_contact<S: SolidSpace>(model: &SolidModel<S>, workspace: &mut Workspace<S>, at: f64) {
    let Workspace {
        stage, stress, sums, contact_forces: contact, contact_lists, walls, wall_pressure, ..
    } = workspace;
    let (domain, constants, bodies) = (&model.domain, &model.particles, &model.bodies[..]);
    let lists = &contact_lists.near;
    match &model.contact {
        ContactModel::Repulsion(law) => {
            let at = ContactStage { domain, constants, bodies, at, stage, lists, walls };
            law.evaluate(&at, &mut workspace.springs, &mut workspace.contacts, contact);
        }
        ContactModel::Sums(law) => {
            let (spacing, body_force) = (model.spacing, &model.body_force);
            let at =
                SumStage { domain, spacing, constants, bodies, body_force, at, stage, stress, lists, walls };
            law.evaluate(&at, wall_pressure, sums, contact);
        }
    }
}

/// Loads that are prescribed to act on bodies, at the stage state of time `at` \[s\], and their share in its stress.
///
/// A surface load acts at the face, half a spacing outside the particle.
fn prescribe_loads<S: SolidSpace>(model: &SolidModel<S>, workspace: &mut Workspace<S>, at: f64) {
    let Workspace { stage, stress, loads, .. } = workspace;
    if loads.is_empty() {
        return;
    }
    loads.fill(S::Vector::zeros());
    for body in &model.bodies {
        let (position, forces) = (&stage.position[body.range.clone()], &mut loads[body.range.clone()]);
        if let Some(field) = &body.acceleration {
            let mass = &model.particles.mass[body.range.clone()];
            for (force, (x, m)) in forces.iter_mut().zip(position.iter().zip(mass)) {
                *force = field.acceleration(x, at) * *m;
            }
        }
        let StressViewMut { deformation, pair_tensor, .. } = stress.view_mut(&body.range);
        for load in &body.loads {
            load.forces(at, position, deformation, |i, force, to_face| {
                forces[i] += force;
                let of_load = body.formulation.load_pair_tensor(i, &S::Tensor::outer(&force, &to_face));
                pair_tensor[i] = S::matrix_plus(pair_tensor[i], of_load);
            });
        }
    }
}

/// Forces on all particles but those of the fluid, at the stage state of time `at` \[s\].
pub fn sum_forces<S: SolidSpace>(
    model: &SolidModel<S>,
    workspace: &mut Workspace<S>,
    time: &StageTime,
    at: f64,
) {
    let Workspace { stage, sums, contact_forces: contact, forces, loads, .. } = workspace;
    let damping_rate = model.damping_rate(time);
    let varies = !model.body_force.is_uniform() || !loads.is_empty() || damping_rate != 0.0;
    for_each(&mut forces[..], 8 * TASK, |i, forces| {
        let mass = model.particles.mass[i];
        let load = loads.get(i).copied().unwrap_or_default();
        let body_force = model.body_force.acceleration(&stage.position[i], at) * mass + load;
        // Damping acts on free particles; a support would only take it up again.
        let damping = if damping_rate == 0.0 || model.acting_support(i, time).is_some() {
            S::Vector::zeros()
        } else {
            stage.velocity[i] * (-damping_rate * mass)
        };
        let parts = [S::vector(sums[i].force), contact[i].bodies, contact[i].walls, body_force, damping];
        *forces = ParticleForces {
            body_force,
            damping,
            walls: contact[i].walls,
            own: S::vector(sums[i].force),
            total: parts.into_iter().sum(),
            gross: parts.iter().map(|force| force.norm()).sum(),
            contact: contact[i].bodies,
            film: [S::Vector::zeros(); 2],
            film_wall_power: 0.0,
            contact_gross: contact[i].bodies.norm() + contact[i].walls.norm(),
            contact_stiffness: contact[i].stiffness,
            contact_depth: contact[i].depth,
            parts: ForceParts {
                varies: varies || S::vector(sums[i].artificial) != S::Vector::zeros(),
                load,
                viscous: S::vector(sums[i].viscous),
                artificial: S::vector(sums[i].artificial),
                friction: contact[i].friction,
                wall_power: contact[i].wall_power,
                wall_friction_power: contact[i].wall_friction_power,
            },
        };
    });
}

/// Adds the forces of the water in gaps to those of contact: like the fluid's they are those of the stage throughout its
/// sub-steps.
pub fn add_film<S: SolidSpace>(workspace: &mut Workspace<S>) {
    let Workspace { film: Some(film), forces, .. } = workspace else { return };
    for (i, film) in film.forces_in_gaps() {
        let forces = &mut forces[i];
        forces.contact += film.bodies;
        forces.walls += film.walls;
        forces.total += film.bodies + film.walls;
        forces.gross += film.bodies.norm() + film.walls.norm();
        forces.film = [film.bodies, film.walls];
        forces.film_wall_power = film.wall_power;
    }
}

/// Adds the fluid's force to `forces`, the others' of each particle.
pub fn total_forces<S: SolidSpace>(
    forces: &[ParticleForces<S>],
    fluid: &[S::Vector],
    total: &mut [S::Vector],
) {
    for_each(total, 8 * TASK, |i, total| *total = forces[i].total + fluid[i]);
}

/// Adds `weight` times the torques of `forces` on particles at `position` \[m\] about `origin` \[m\].
pub fn add_torques<S: SolidSpace>(
    torques: &mut [ParticleTorques<S>],
    weight: f64,
    origin: S::Vector,
    position: &[S::Vector],
    forces: &[ParticleForces<S>],
) {
    for_each(torques, 8 * TASK, |i, torques| {
        torques.add(weight, &(position[i] - origin), &forces[i]);
    });
}
