//! Set-ups of two rows of masses.

use sph::coupling::solver::Role;
use sph::setup::{
    BodyForce, BodySetup, BreachAction, ContactLaw, Coupling, CouplingKind, DensityDiffusion,
    ElasticParameters, FluidParameters, FluidParticles, FluidScheme, FluidSetup, Formulation,
    ImplicitCoupling, InterfaceLaw, LedgerPolicy, NonConvergence, Outflow, OutputPlan, ParameterSet,
    ParticipantSetup, Relaxation, RunSetup, SolidParticles, SolidSetup, SolidStepping, StepPolicy, TimePlan,
    WallParticles,
};
use sph::space::domain::Domain;
use sph::space::{SymmetricTensor, Vector};

/// Masses per side.
pub(crate) const MASSES: usize = 40;
/// Distance at which masses repel \[m\].
pub(super) const RANGE: f64 = 0.2;

/// A short coupled run. Some run ids make the fake solver misbehave: see `Row` and `RowFactory`.
pub(crate) fn run_setup(run_id: &str, steps: u32) -> RunSetup {
    let time_step = 1e-3;
    RunSetup {
        run_id: run_id.into(),
        domain: Domain { lower: Vector::new(-1.0, -1.0), upper: Vector::new(1.0, 1.0), periodic: [false; 2] },
        time: TimePlan {
            start_time: 0.0,
            end_time: f64::from(steps) * time_step,
            step: StepPolicy::Fixed { time_step },
        },
        body_force: BodyForce { gravity: Vector::zeros(), expressions: None },
        outputs: OutputPlan { snapshot_interval: Some(0.01), probe_interval: Some(0.005) },
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

/// Position and velocity of mass `k` of a row.
fn start(role: Role, k: usize) -> (Vector, Vector) {
    let side = if role == Role::Fluid { -1.0 } else { 1.0 };
    let y = 0.02 * (k as f64 - 0.5 * MASSES as f64) + 0.003 * side;
    // Irregular on purpose: equal terms would hide a wrong order of sums.
    let bend = 1e-3 * ((7 * k) % 5) as f64 / 3.0;
    (Vector::new(side * (0.11 + bend), y), Vector::new(-side * (0.5 + bend), 0.01 * bend))
}

pub(crate) fn fluid_setup(run: RunSetup) -> ParticipantSetup {
    let (position, velocity) = (0..MASSES).map(|k| start(Role::Fluid, k)).unzip();
    ParticipantSetup::Fluid(FluidSetup {
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
    })
}

pub(crate) fn solid_setup(run: RunSetup) -> ParticipantSetup {
    let (position, velocity): (Vec<_>, _) = (0..MASSES).map(|k| start(Role::Solid, k)).unzip();
    ParticipantSetup::Solid(SolidSetup {
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
            deviatoric_stress: vec![SymmetricTensor::default(); MASSES],
        },
        contact: ContactLaw::Sums,
        walls: Vec::new(),
        wall_particles: WallParticles::default(),
        damping: None,
        stepping: SolidStepping::StageRule,
        probes: Vec::new(),
        lost_particle_limit: 0,
    })
}

pub(crate) fn setup(role: Role, run_id: &str, steps: u32) -> ParticipantSetup {
    match role {
        Role::Fluid => fluid_setup(run_setup(run_id, steps)),
        Role::Solid => solid_setup(run_setup(run_id, steps)),
    }
}

/// The same set-up without a partner.
pub(crate) fn alone(role: Role, run_id: &str, steps: u32) -> ParticipantSetup {
    let run = RunSetup { coupling: None, ..run_setup(run_id, steps) };
    match role {
        Role::Fluid => fluid_setup(run),
        Role::Solid => solid_setup(run),
    }
}
