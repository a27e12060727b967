//! Set-ups of two rows of masses.

use sph::coupling::solver::Role;
use sph::map_space;
use sph::setup::{
    BodyForce, BodySetup, BreachAction, ContactLaw, Coupling, CouplingKind, DensityDiffusion,
    ElasticParameters, FluidParameters, FluidParticles, FluidScheme, FluidSetup, Formulation,
    ImplicitCoupling, InterfaceLaw, LedgerPolicy, NonConvergence, Outflow, OutputPlan, ParameterSet,
    ParticipantSetup, Relaxation, RunSetup, SolidParticles, SolidSetup, SolidStepping, StepPolicy, TimePlan,
    WallParticles,
};
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::space::{Plane, SomeSpace, Space, Spatial};

/// The plane.
pub(crate) const PLANE: SomeSpace = SomeSpace::Plane(Plane);
/// Space.
pub(crate) const SPATIAL: SomeSpace = SomeSpace::Spatial(Spatial);

/// Masses per side.
pub(crate) const MASSES: usize = 40;
/// Distance at which masses repel \[m\].
pub(super) const RANGE: f64 = 0.2;

/// A short coupled run. Some run ids make the fake solver misbehave: see `Row` and `RowFactory`.
pub(crate) fn run_setup<S: Space>(run_id: &str, steps: u32) -> RunSetup<S> {
    let time_step = 1e-3;
    RunSetup {
        run_id: run_id.into(),
        domain: Domain {
            lower: S::Vector::repeat(-1.0),
            upper: S::Vector::repeat(1.0),
            periodic: S::splat(false),
        },
        time: TimePlan {
            start_time: 0.0,
            end_time: f64::from(steps) * time_step,
            step: StepPolicy::Fixed { time_step },
        },
        body_force: BodyForce { gravity: S::Vector::zeros(), expressions: None },
        outputs: OutputPlan {
            snapshot_interval: Some(0.01),
            probe_interval: Some(0.005),
            snapshot_times: vec![0.003],
        },
        // Sums over some hundred pairs round near 1e-15.
        ledger: LedgerPolicy { action: BreachAction::Stop, ..LedgerPolicy::default() },
        coupling: Some(Coupling {
            kind: CouplingKind::States,
            law: InterfaceLaw::Wall,
            fluid: water().of_pair_law(),
            solid_spacing: 0.01,
            repulsion: 0.5,
            margin: 0.05,
            implicit: None,
        }),
    }
}

/// Implicit coupling.
pub(crate) const IMPLICIT: ImplicitCoupling = ImplicitCoupling {
    relaxation: Relaxation::Fixed(0.1 + 0.2),
    tolerance: 1e-7 / 3.0,
    limit: 17,
    non_convergence: NonConvergence::Accept,
};

pub(crate) fn water() -> FluidParameters {
    FluidParameters {
        kernel_ratio: 2.0,
        particle_spacing: RANGE / 4.0,
        density_diffusion: DensityDiffusion::None,
        scheme: FluidScheme::PredictorCorrector,
        ..FluidParameters::PLAIN
    }
}

/// Position and velocity of mass `k` of a row, which lies along y.
fn start<S: Space>(role: Role, k: usize) -> (S::Vector, S::Vector) {
    let side = if role == Role::Fluid { -1.0 } else { 1.0 };
    let y = 0.02 * (k as f64 - 0.5 * MASSES as f64) + 0.003 * side;
    // Irregular on purpose: equal terms would hide a wrong order of sums.
    let bend = 1e-3 * ((7 * k) % 5) as f64 / 3.0;
    let position = [side * (0.11 + bend), y, 0.7 * bend];
    let velocity = [-side * (0.5 + bend), 0.01 * bend, side * 0.3 * bend];
    (S::vector(S::axes(|axis| position[axis])), S::vector(S::axes(|axis| velocity[axis])))
}

pub(crate) fn fluid_setup<S: Space>(run: RunSetup<S>) -> FluidSetup<S> {
    let (position, velocity) = (0..MASSES).map(|k| start::<S>(Role::Fluid, k)).unzip();
    FluidSetup {
        run,
        parameters: water(),
        damping: None,
        regions: vec!["row".into()],
        walls: Vec::new(),
        particles: FluidParticles {
            id: (0..MASSES as u32).map(|k| 3 * k).collect(),
            region: vec![0; MASSES],
            mass: vec![0.1; MASSES],
            position,
            velocity,
            density: vec![1000.0; MASSES],
            relaxation: Vec::new(),
        },
        wall_particles: WallParticles::default(),
        probes: Vec::new(),
        outflow: Outflow::default(),
    }
}

pub(crate) fn solid_setup<S: Space>(run: RunSetup<S>) -> SolidSetup<S> {
    let (position, velocity): (Vec<_>, _) = (0..MASSES).map(|k| start::<S>(Role::Solid, k)).unzip();
    SolidSetup {
        run,
        particle_spacing: 0.01,
        bodies: vec![BodySetup {
            name: "row".into(),
            material: ElasticParameters {
                density: 1100.0,
                bulk_modulus: 2e7,
                shear_modulus: 4e6,
                plane: sph::setup::PlaneState::Strain,
            },
            formulation: Formulation::Rigid,
            supports: Vec::new(),
            acceleration: None,
            loads: Vec::new(),
        }],
        particles: SolidParticles {
            id: (0..MASSES as u32).collect(),
            body: vec![0; MASSES],
            support: vec![0; MASSES],
            mass: vec![0.3; MASSES],
            reference_position: position.clone(),
            position,
            velocity,
            density: vec![1100.0; MASSES],
            deviatoric_stress: vec![S::SymmetricTensor::default(); MASSES],
        },
        contact: ContactLaw::Sums,
        walls: Vec::new(),
        wall_particles: WallParticles::default(),
        damping: None,
        stepping: SolidStepping::StageRule,
        probes: Vec::new(),
        lost_particle_limit: 0,
    }
}

fn of_role(space: SomeSpace, role: Role, run_id: &str, steps: u32, coupled: bool) -> ParticipantSetup {
    fn run<S: Space>(_: S, run_id: &str, steps: u32, coupled: bool) -> RunSetup<S> {
        let run = run_setup(run_id, steps);
        RunSetup { coupling: run.coupling.filter(|_| coupled), ..run }
    }
    let run = map_space!(space, space => run(space, run_id, steps, coupled));
    match role {
        Role::Fluid => ParticipantSetup::Fluid(map_space!(run, run => fluid_setup(run))),
        Role::Solid => ParticipantSetup::Solid(map_space!(run, run => solid_setup(run))),
    }
}

pub(crate) fn setup_in(space: SomeSpace, role: Role, run_id: &str, steps: u32) -> ParticipantSetup {
    of_role(space, role, run_id, steps, true)
}

pub(crate) fn setup(role: Role, run_id: &str, steps: u32) -> ParticipantSetup {
    setup_in(PLANE, role, run_id, steps)
}

/// The same set-up without a partner.
pub(crate) fn alone(role: Role, run_id: &str, steps: u32) -> ParticipantSetup {
    of_role(PLANE, role, run_id, steps, false)
}
