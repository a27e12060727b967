//! Values of the probes at a step boundary.

use sph::neighbours::CellGrid;
use sph::setup::{SolidProbeKind, SolidSetup};
use sph::space::components::Components;
use sph::space::tensors::{SpaceSymmetric, SpaceVector};

use crate::formulations::body::Body;
use crate::materials::hooke::{deviatoric_stress, von_mises_stress};
use crate::neighbours::material_point::MaterialPoint;
use crate::particles::fields::StressFields;
use crate::report::body_sums::{
    BodySums, body_sums, material_position, particle_energy_density, second_moments,
};
use crate::report::fields::stress_of;
use crate::space::SolidSpace;
use crate::system::model::{Probe, SolidModel};
use crate::system::state::{BodyContact, SolidState};

/// The probes of `setup` on `bodies`; their errors are added to `errors`.
pub fn build_probes<S: SolidSpace>(
    setup: &SolidSetup<S>,
    bodies: &mut [Body<S>],
    errors: &mut Vec<String>,
) -> Vec<Probe<S>> {
    let mut probes = Vec::new();
    for probe in &setup.probes {
        let name = &probe.name;
        let body = match &probe.kind {
            SolidProbeKind::MaterialPoint(body, _) | SolidProbeKind::Reaction(body, _) => Some(*body),
            SolidProbeKind::Motion(body) | SolidProbeKind::BodyForce(body) => Some(*body),
            SolidProbeKind::Sums(body) | SolidProbeKind::Gap(body) | SolidProbeKind::Contact(body) => *body,
        };
        let count = bodies.len();
        let Some(body) = body.map(|body| bodies.get_mut(body as usize)) else {
            probes.push(Probe::Plain(probe.kind.clone()));
            continue;
        };
        let Some(body) = body else {
            errors.push(format!("probe `{name}`: its body does not exist; there are {count}"));
            continue;
        };
        match &probe.kind {
            SolidProbeKind::MaterialPoint(_, at) => {
                let place: Vec<String> = at.row().as_ref().iter().map(f64::to_string).collect();
                let reference = &setup.particles.reference_position[body.range.clone()];
                match MaterialPoint::new::<S>(at, body.range.start, reference, setup.particle_spacing) {
                    Ok(point) => probes.push(Probe::MaterialPoint(point)),
                    Err(distance) => errors.push(format!(
                        "probe `{name}`: ({}) m lies {distance:.3e} m from the nearest particle of body `{}`; it \
                         must lie in the undeformed body",
                        place.join(", "),
                        body.name
                    )),
                }
                continue;
            }
            SolidProbeKind::Motion(_) => body.tracks_rotation = true,
            SolidProbeKind::Reaction(_, support) if *support as usize >= body.supports.len() => {
                errors.push(format!("probe `{name}`: body `{}` has no support {support}", body.name));
            }
            _ => {}
        }
        probes.push(Probe::Plain(probe.kind.clone()));
    }
    probes
}

/// Appends the values of all probes, columns as `ProbeKind::columns` lists them.
///
/// Forces and reactions are those of the last corrector, that is half a step before the boundary; at the start of a run
/// they are zero. Angular momentum is taken about the centre of the domain.
pub fn probe_values<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    time: f64,
    values: &mut Vec<f64>,
) {
    let reads_stress = model.probes.iter().any(|probe| matches!(probe, Probe::MaterialPoint(_)));
    let stress = reads_stress.then(|| stress_of(model, state));
    for probe in &model.probes {
        match probe {
            Probe::MaterialPoint(point) => {
                if let Some(stress) = &stress {
                    material_point(model, state, stress, point, values);
                }
            }
            Probe::Plain(kind) => plain(model, state, time, kind, values),
        }
    }
}

fn material_point<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    stress: &StressFields<S>,
    point: &MaterialPoint,
    values: &mut Vec<f64>,
) {
    let displacement =
        point.mean(|i| material_position(model, state, i) - model.particles.reference_position[i]);
    let velocity = point.mean(|i| state.particles.velocity[i]);
    let cauchy = S::SymmetricTensor::of(&point.mean(|i| stress.cauchy[i].full()));
    let pressure = point.mean(|i| stress.pressure[i]);
    let energy = point.mean(|i| particle_energy_density(model, state, i));
    let deviator = deviatoric_stress::<S>(pressure, &cauchy);
    push(values, displacement);
    push(values, velocity);
    push(values, cauchy);
    values.push(von_mises_stress::<S>(&deviator));
    values.extend(cauchy.extremes());
    values.push(energy);
}

fn plain<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    time: f64,
    kind: &SolidProbeKind<S>,
    values: &mut Vec<f64>,
) {
    match kind {
        // Prepared as `Probe::MaterialPoint` when the model is built.
        SolidProbeKind::MaterialPoint(..) => {}
        SolidProbeKind::Motion(body) => motion(model, state, *body as usize, values),
        SolidProbeKind::BodyForce(body) => push(values, state.last.fluid_force[*body as usize]),
        SolidProbeKind::Reaction(body, support) => {
            push(values, state.last.reactions[*body as usize][*support as usize]);
        }
        SolidProbeKind::Gap(body) => values.extend(gaps(model, state, time, *body)),
        SolidProbeKind::Contact(body) => {
            let contacts = &state.last.contacts;
            let contact = body.map_or_else(|| BodyContact::all(contacts), |body| contacts[body as usize]);
            push(values, contact.bodies);
            push(values, contact.walls);
            values.extend([contact.deepest, contact.impulse]);
        }
        SolidProbeKind::Sums(body) => {
            let range = body.map_or(0..model.len(), |body| model.bodies[body as usize].range.clone());
            let sums = body_sums(model, state, &range);
            let moments = second_moments(model, state, &range, &sums);
            values.push(sums.mass);
            push(values, sums.momentum);
            push(values, sums.angular_momentum);
            values.extend([sums.kinetic, sums.potential, sums.strain]);
            push(values, sums.centre());
            push(values, moments);
        }
    }
}

sph::constants! {
    const GAP_REACH: f64 = 3.0, "probes.gap_reach",
        "largest gap that is reported, in spacings [-]";
}

/// Smallest distance \[m\] from a particle of `body`, or of any, to one of another body, and from a free one to a wall's.
///
/// Not a number where there is none within [`GAP_REACH`].
fn gaps<S: SolidSpace>(
    model: &SolidModel<S>,
    state: &SolidState<S>,
    time: f64,
    body: Option<u32>,
) -> [f64; 2] {
    let reach = GAP_REACH * model.spacing;
    let mut walls = model.walls.at_start();
    model.walls.move_to(time, &mut walls);
    let position = &state.particles.position;
    let range = body.map_or(0..model.len(), |body| model.bodies[body as usize].range.clone());
    let smallest = |others: &[S::Vector], counts: &dyn Fn(usize, usize) -> bool| {
        let own = &position[range.clone()];
        let list = CellGrid::new(&model.domain, others, reach).list(&model.domain, own, others, reach);
        let pairs =
            range.clone().enumerate().flat_map(|(k, i)| list.of(k).iter().map(move |j| (i, *j as usize)));
        let distance = |(i, j): (usize, usize)| model.domain.separation(&position[i], &others[j]).norm();
        pairs.filter(|(i, j)| counts(*i, *j)).map(distance).fold(f64::NAN, f64::min)
    };
    let other_body = |i: usize, j: usize| model.particles.body[i] != model.particles.body[j];
    let wall_acts_on = |i: usize, w: usize| {
        let wall = &model.walls.walls[model.walls.wall_of[w] as usize];
        model.particles.support[i] == 0 && time < wall.release_time
    };
    [smallest(position, &other_body), smallest(&walls.position, &wall_acts_on)]
}

fn push(values: &mut Vec<f64>, quantity: impl Components) {
    values.extend_from_slice(quantity.row().as_ref());
}

/// Centre, velocity, angle or quaternion, and angular velocity; the latter is angular momentum over moment of inertia.
fn motion<S: SolidSpace>(model: &SolidModel<S>, state: &SolidState<S>, body: usize, values: &mut Vec<f64>) {
    let range = &model.bodies[body].range;
    let sums: BodySums<S> = body_sums(model, state, range);
    let (centre, velocity) = (sums.centre(), sums.momentum / sums.mass);
    let moments = second_moments(model, state, range, &sums);
    let cells =
        model.bodies[body].formulation.inertia().map_or_else(S::Inertia::default, |inertia| inertia.cells);
    let inertia = S::body_inertia(sums.mass, &moments) + cells;
    let arm = centre - model.domain.torque_origin();
    let spin = sums.angular_momentum - S::cross(&arm, &sums.momentum);
    push(values, centre);
    push(values, velocity);
    push(values, state.rotations[body]);
    push(values, S::described_spin(inertia, inertia, spin));
}
