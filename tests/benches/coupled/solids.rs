//! Cost of the solids' stages on one thread.

use std::time::Instant;

use coordinator::study::cost;
use sph::coupling::exchange::StateColumns;
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::setup::{
    BodyForce, BodySetup, ContactLaw, ElasticParameters, Formulation, LedgerPolicy, OutputPlan,
    RepulsionParameters, RunSetup, SolidParticles, SolidSetup, SolidStepping, StepPolicy, SubstepCount,
    Support, TimePlan, TotalLagrangian, UpdatedLagrangian, WallParticles,
};
use sph::space::domain::Domain;
use sph::space::{SymmetricTensor, Vector};

/// Particles of the plates; the first is about that of the drifting-body case.
const SIZES: [u32; 3] = [600, 10_000, 100_000];
const SPACING: f64 = 0.002;
const RUBBER: ElasticParameters = ElasticParameters {
    density: 1100.0,
    bulk_modulus: 20e6,
    shear_modulus: 4.27e6,
    plane: sph::setup::PlaneState::Strain,
};
/// Sub-steps of a step.
const SUBSTEPS: u32 = 8;
/// Particles evaluated for a figure, at least.
const WORK: u32 = 4_000_000;

/// A square plate, held at its left side, moving.
fn plate(particles: u32, formulation: Formulation, stepping: SolidStepping) -> SolidSetup {
    let side = f64::from(particles).sqrt().ceil() as u32;
    let count = (side * side) as usize;
    let position: Vec<Vector> = (0..side * side)
        .map(|k| Vector::new(f64::from(k % side) + 0.5, f64::from(k / side) + 0.5) * SPACING)
        .collect();
    let particles = SolidParticles {
        id: (0..side * side).collect(),
        body: vec![0; count],
        support: (0..side * side).map(|k| u32::from(k % side < 2)).collect(),
        mass: vec![RUBBER.density * SPACING * SPACING; count],
        velocity: position.iter().map(|x| Vector::new(0.1 * x.x, -0.2 * x.x)).collect(),
        reference_position: position.clone(),
        position,
        density: vec![RUBBER.density; count],
        deviatoric_stress: vec![SymmetricTensor::default(); count],
    };
    let clamp =
        Support { name: "clamp".into(), held: [true, true], motion: None, pivot: None, release_time: None };
    SolidSetup {
        run: RunSetup {
            run_id: "benchmark".into(),
            domain: Domain { lower: Vector::repeat(-1.0), upper: Vector::repeat(2.0), periodic: [false; 2] },
            time: TimePlan { start_time: 0.0, end_time: 1.0, step: StepPolicy::Fixed { time_step: 1e-6 } },
            body_force: BodyForce { gravity: Vector::new(0.0, -9.81), expressions: None },
            outputs: OutputPlan::default(),
            ledger: LedgerPolicy::default(),
            coupling: None,
        },
        particle_spacing: SPACING,
        bodies: vec![BodySetup {
            name: "plate".into(),
            material: RUBBER,
            formulation,
            supports: vec![clamp],
            acceleration: None,
            loads: Vec::new(),
        }],
        particles,
        contact: ContactLaw::Repulsion(RepulsionParameters {
            stiffness: 0.5,
            self_contact: false,
            ..RepulsionParameters::default()
        }),
        walls: Vec::new(),
        wall_particles: WallParticles::default(),
        damping: None,
        stepping,
        probes: Vec::new(),
        lost_particle_limit: 0,
    }
}

/// Seconds per step: the least of some, of no more than a microsecond each.
fn seconds_per_step(setup: SolidSetup, steps: u32) -> f64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.unwrap_or_else(|error| panic!("{error}"));
    let none = StateColumns::default();
    let time_step = 1e-6;
    pool.install(|| {
        let mut solver = solid::plane_solver(setup).unwrap_or_else(|errors| panic!("{errors:?}")).solver;
        let mut step = |step: u32| {
            let started = Instant::now();
            for stage in Stage::BOTH {
                let at = StepStage { step: u64::from(step), stage };
                let time = StageTime { at, step_start: f64::from(step) * time_step, time_step };
                let fault = |divergence| panic!("{divergence}");
                solver.begin_stage(&time).unwrap_or_else(fault);
                solver.evaluate_own(&time);
                solver.evaluate_cross(&time, &none, &none);
                let _books = solver.advance(&time).unwrap_or_else(|divergence| panic!("{divergence}"));
            }
            started.elapsed().as_secs_f64()
        };
        (0..steps.max(5)).map(&mut step).fold(f64::INFINITY, f64::min)
    })
}

/// Nanoseconds per particle and sub-step, or stage.
pub fn print() {
    let total =
        Formulation::TotalLagrangian(TotalLagrangian { viscosity_a: 0.2, ..TotalLagrangian::default() });
    let updated = Formulation::UpdatedLagrangian(UpdatedLagrangian::default());
    let substeps = SolidStepping::Substeps(SubstepCount::Fixed(SUBSTEPS));
    let fixed = cost::fixed_kernel();
    terminal::say(format_args!(
        "{:44}{:>16}{:>16}{:>16}",
        "ns per particle (times the fixed kernel)", "600", "10k", "100k"
    ));
    for (name, formulation, stepping, evaluations) in [
        // The predictor takes half as many sub-steps, besides the forces at the start.
        ("total-Lagrangian, a sub-step", total, substeps, SUBSTEPS + SUBSTEPS / 2),
        ("source paper, a stage", updated, SolidStepping::StageRule, 2),
    ] {
        let mut row = format!("{name:44}");
        for particles in SIZES {
            let steps = WORK / (particles * evaluations);
            let time = seconds_per_step(plate(particles, formulation, stepping), steps);
            let side = f64::from(particles).sqrt().ceil();
            let each = time / (side * side * f64::from(evaluations));
            row += &format!("{:>16}", format!("{:.0} ({:.0})", 1e9 * each, each / fixed));
        }
        terminal::say(row);
    }
}
