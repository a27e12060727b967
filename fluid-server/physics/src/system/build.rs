//! Builds model and first state from a set-up.

use sph::coupling::ledger::{EnergyAccount, potential_gravity};
use sph::kernel::{CubicSpline, PairKernel};
use sph::lanes::Arithmetic;
use sph::laws::repulsion::Repulsion;
use sph::prescribed::body_force::BodyForceField;
use sph::setup::{FluidParticles, FluidProbe, FluidProbeKind, FluidSetup, GradientCorrection, ViscousForm};
use sph::space::Space;
use sph::space::tensors::SpaceVector;

use super::list_limits::skins;
use super::model::{FluidModel, PairLaw, Parallelogram, Probe, Segment, Viscosity};
use super::setup_errors::setup_errors;
use super::state::FluidState;
use super::thresholds::Thresholds;
use super::walls::WallModel;
use crate::team::Team;

/// Model and first state of `setup`, of which `team` computes a part here.
///
/// # Errors
/// Everything in the set-up that can not be run.
pub fn build<S: Thresholds>(
    setup: FluidSetup<S>,
    arithmetic: Arithmetic,
    team: Team,
) -> Result<(FluidModel<S>, FluidState<S>), Vec<String>> {
    let mut errors = setup_errors(&setup);
    if !errors.is_empty() {
        return Err(errors);
    }
    let energy_accounts = EnergyAccount::of_fluid(&setup);
    let FluidSetup { run, parameters: constants, particles, .. } = setup;
    let h = constants.smoothing_length();
    let kernel = CubicSpline::new(h);
    let lattice_scale = 1.0 / kernel.lattice_moment(constants.particle_spacing);
    let (gradient_scale, cross_gradient_scale) = match constants.correction {
        GradientCorrection::None => (1.0, 1.0),
        GradientCorrection::LatticeMoment | GradientCorrection::Continuity => (lattice_scale, lattice_scale),
        GradientCorrection::Renormalised => (1.0, lattice_scale),
    };
    let mass = constants.rest_density * S::cell_volume(constants.particle_spacing);
    let walls = WallModel::new(
        &setup.walls,
        &setup.wall_particles,
        mass,
        constants.particle_spacing,
        kernel.support_radius(),
        &run.domain,
    );
    let body_force = BodyForceField::new(&run.body_force).map_err(|e| vec![e.to_string()]);
    let (walls, body_force) = match (walls, body_force) {
        (Ok(walls), Ok(body_force)) => (walls, body_force),
        (walls, body_force) => {
            errors.extend(walls.err().unwrap_or_default());
            errors.extend(body_force.err().unwrap_or_default());
            return Err(errors);
        }
    };
    let model = FluidModel {
        team,
        domain: run.domain,
        constants,
        equation_of_state: constants.equation_of_state(),
        acoustic_relaxation: constants.acoustic_relaxation(),
        kernel,
        law: PairLaw {
            kernel: PairKernel::new(&kernel, gradient_scale),
            viscosity: constants.artificial_viscosity(),
        },
        gradient_scale,
        cross_gradient_scale,
        diffusion: constants.diffusivity(),
        acoustic_diffusivity: constants.acoustic_damping * h * constants.sound_speed,
        scheme: constants.scheme,
        arithmetic,
        diffusion_form: constants.density_diffusion,
        viscosity: match constants.viscous_form {
            _ if constants.dynamic_viscosity <= 0.0 => Viscosity::Inviscid,
            ViscousForm::Stress => Viscosity::Stress,
            ViscousForm::Pairwise => Viscosity::Pairwise,
        },
        falling: potential_gravity::<S>(body_force.gravity(), |axis| run.domain.periodic[axis]),
        energy_accounts,
        body_force,
        damping: setup.damping,
        regions: setup.regions,
        walls,
        probes: setup.probes.into_iter().map(prepared).collect(),
        outflow: setup.outflow,
        wall_repulsion: Repulsion::new(
            constants.wall_repulsion,
            constants.particle_spacing,
            constants.particle_spacing,
            constants.sound_speed,
        ),
        escaped_particle_limit: constants.lost_particle_limit,
        ordered_by_pressure: if constants.volume_correction > 0.0 {
            S::ORDERED_BY_PRESSURE_AT_VOLUME
        } else {
            S::ORDERED_BY_PRESSURE
        },
        regularisation: constants.order_control(),
        coupling: run.coupling,
        first_wall_id: particles.id.iter().max().map_or(0, |id| id.saturating_add(1)),
    };
    let state = first_state(&model, particles, run.time.start_time);
    Ok((model, state))
}

/// `probe` with the geometry that its evaluation needs.
fn prepared<S: Space>(probe: FluidProbe<S>) -> Probe<S> {
    match probe.kind {
        FluidProbeKind::Point(x) => Probe::Point(x),
        FluidProbeKind::FlowRate(from, to) => {
            let length = (to - from).norm();
            let along = (to - from) / length;
            let mut normal = S::Vector::zeros();
            (normal[0], normal[1]) = (along[1], -along[0]);
            Probe::FlowRate(Segment { middle: (from + to) * 0.5, along, normal, length })
        }
        FluidProbeKind::SurfaceFlux(corner, first, second) => {
            Probe::SurfaceFlux(parallelogram(corner, [first - corner, second - corner]))
        }
        kind => Probe::Plain(kind),
    }
}

/// The parallelogram of `edges` \[m\] from `corner`. With a space of two dimensions there is no normal: a set-up with the
/// probe has been refused.
fn parallelogram<S: Space>(corner: S::Vector, edges: [S::Vector; 2]) -> Parallelogram<S> {
    let [a, b] = edges;
    let (aa, bb, ab) = (a.norm_squared(), b.norm_squared(), a.dot(&b));
    let square = aa * bb - ab * ab;
    let gradients = [(a * bb - b * ab) / square, (b * aa - a * ab) / square];
    let mut normal = S::Vector::zeros();
    if S::DIMENSIONS == 3 {
        for axis in 0..3 {
            let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
            normal[axis] = (a[j] * b[k] - a[k] * b[j]) / square.sqrt();
        }
    }
    Parallelogram { corner, edges, gradients, normal, area: square.sqrt() }
}

/// The state at `time` \[s\], before any stage has been evaluated.
fn first_state<S: Space>(model: &FluidModel<S>, particles: FluidParticles<S>, time: f64) -> FluidState<S> {
    let FluidParticles { id, region, mass, position, velocity, density, mut relaxation } = particles;
    match model.acoustic_relaxation {
        Some(_) => relaxation.resize(id.len(), 0.0),
        None => relaxation.clear(),
    }
    let body_force = model.body_force.at(time);
    // No stage has been evaluated yet: the body force stands in for the acceleration.
    let largest_acceleration = position.iter().map(|x| body_force.acceleration(x).norm()).fold(0.0, f64::max);
    let kept = if model.is_leapfrog() { id.len() } else { 0 };
    FluidState {
        relaxation,
        volume_excess: vec![0.0; if model.corrects_volume() { id.len() } else { 0 }],
        density_rate: vec![0.0; kept],
        density_correction: vec![0.0; kept],
        acceleration: vec![S::Vector::zeros(); kept],
        id,
        region,
        mass,
        position,
        velocity,
        density,
        list_skin: skins::<S>(model.constants.particle_spacing).first,
        largest_acceleration,
        ..FluidState::default()
    }
}
