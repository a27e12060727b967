//! Scenes for the tests.

use sph::coupling::exchange::StateColumns;
use sph::coupling::ledger::StageBudget;
use sph::coupling::solver::{Divergence, Solver};
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::setup::{
    BodyForce, DensityDiffusion, FluidParameters, FluidParticles, FluidScheme, FluidSetup,
    GradientCorrection, LedgerPolicy, Outflow, OutputPlan, RunSetup, StepPolicy, TimePlan, WallCondition,
    WallParticles, WallSetup,
};
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::space::{Plane, Space, Vector};

use crate::FluidSolver;
use crate::system::packed_particle::FluidSpace;

/// Every combination of gradient correction and density diffusion.
pub fn variants() -> Vec<(GradientCorrection, DensityDiffusion)> {
    let corrections = [
        GradientCorrection::None,
        GradientCorrection::LatticeMoment,
        GradientCorrection::Continuity,
        GradientCorrection::Renormalised,
    ];
    let diffusions = [DensityDiffusion::None, DensityDiffusion::Plain, DensityDiffusion::Renormalised];
    corrections.into_iter().flat_map(|c| diffusions.into_iter().map(move |d| (c, d))).collect()
}

/// Shifting and tensile control at once.
pub const ORDERED: (f64, bool) = (1.0, true);

/// Numbers between −1 and 1 that look random (splitmix64).
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn vector(&mut self) -> Vector {
        self.vector_in::<Plane>()
    }

    pub fn vector_in<S: Space>(&mut self) -> S::Vector {
        let mut vector = S::Vector::zeros();
        for axis in 0..S::DIMENSIONS {
            vector[axis] = self.next();
        }
        vector
    }
}

/// An empty scene in an open square of 1 m, weightless.
pub fn empty_scene(spacing: f64) -> FluidSetup {
    empty_scene_in::<Plane>(spacing)
}

/// An empty scene in an open square or cube of 1 m, weightless.
pub fn empty_scene_in<S: Space>(spacing: f64) -> FluidSetup<S> {
    FluidSetup {
        run: RunSetup {
            run_id: "test".into(),
            domain: Domain {
                lower: S::Vector::zeros(),
                upper: S::Vector::repeat(1.0),
                periodic: S::splat(false),
            },
            time: TimePlan { start_time: 0.0, end_time: 1.0, step: StepPolicy::Fixed { time_step: 1e-4 } },
            body_force: BodyForce { gravity: S::Vector::zeros(), expressions: None },
            outputs: OutputPlan::default(),
            ledger: LedgerPolicy::default(),
            coupling: None,
        },
        parameters: FluidParameters {
            particle_spacing: spacing,
            viscosity_b: 0.1,
            scheme: FluidScheme::PredictorCorrector,
            wall_repulsion: 0.0,
            ..FluidParameters::PLAIN
        },
        damping: None,
        regions: vec!["water".into()],
        walls: Vec::new(),
        particles: FluidParticles::default(),
        wall_particles: WallParticles::default(),
        probes: Vec::new(),
        outflow: Outflow::default(),
    }
}

/// Adds a fluid particle of one lattice cell at rest density.
pub fn add_particle<S: Space>(setup: &mut FluidSetup<S>, position: S::Vector, velocity: S::Vector) {
    let (rho, spacing) = (setup.parameters.rest_density, setup.parameters.particle_spacing);
    let p = &mut setup.particles;
    p.id.push(p.id.len() as u32);
    p.region.push(0);
    p.mass.push(rho * S::cell_volume(spacing));
    p.position.push(position);
    p.velocity.push(velocity);
    p.density.push(rho);
}

/// Adds a lattice block of `columns` × `rows` fluid particles from the `lower` corner on, at rest.
pub fn add_block(setup: &mut FluidSetup, lower: Vector, columns: usize, rows: usize) {
    add_lattice(setup, lower, [columns, rows]);
}

/// Adds a lattice block of `counts` fluid particles along the axes from the `lower` corner on, at rest.
pub fn add_lattice<S: Space>(setup: &mut FluidSetup<S>, lower: S::Vector, counts: S::Of<usize>) {
    let spacing = setup.parameters.particle_spacing;
    for cell in 0..(0..S::DIMENSIONS).map(|axis| counts[axis]).product() {
        // Digits of the cell's number, x counting fastest.
        let (mut offset, mut rest) = (S::Vector::zeros(), cell);
        for axis in 0..S::DIMENSIONS {
            offset[axis] = (rest % counts[axis]) as f64 + 0.5;
            rest /= counts[axis];
        }
        add_particle(setup, lower + offset * spacing, S::Vector::zeros());
    }
}

/// Adds a wall of three layers below `surface` y, from `left` on, with its normal up.
pub fn add_floor(setup: &mut FluidSetup, left: f64, surface: f64, columns: usize, condition: WallCondition) {
    let spacing = setup.parameters.particle_spacing;
    let wall = setup.walls.len() as u32;
    setup.walls.push(WallSetup { name: "floor".into(), condition, motion: None, release_time: None });
    for layer in 0..3 {
        for column in 0..columns {
            let x = left + (column as f64 + 0.5) * spacing;
            let y = surface - (f64::from(layer) + 0.5) * spacing;
            setup.wall_particles.wall.push(wall);
            setup.wall_particles.position.push(Vector::new(x, y));
            setup.wall_particles.normal.push(Vector::new(0.0, 1.0));
        }
    }
}

/// A patch of 9 × 9 particles, displaced by up to 0.2 spacings, with random velocity, density and mass.
pub fn random_patch(seed: u64) -> FluidSetup {
    let mut setup = empty_scene(0.02);
    add_block(&mut setup, Vector::new(0.4, 0.4), 9, 9);
    disturb(&mut setup, seed);
    setup
}

/// Displaces all particles by up to 0.2 spacings of 0.02 m, and gives them random velocities, densities and masses.
pub fn disturb<S: Space>(setup: &mut FluidSetup<S>, seed: u64) {
    let mut noise = Noise(seed);
    let p = &mut setup.particles;
    for i in 0..p.id.len() {
        p.position[i] += noise.vector_in::<S>() * 0.004;
        p.velocity[i] = noise.vector_in::<S>();
        p.density[i] *= 1.0 + 0.01 * noise.next();
        p.mass[i] *= 1.0 + 0.1 * noise.next();
    }
}

pub fn solver<S: FluidSpace>(setup: FluidSetup<S>) -> FluidSolver<S> {
    FluidSolver::new(setup).unwrap()
}

/// The half-step of `step` in a run of equal steps.
pub fn stage_time(step: u64, stage: Stage, time_step: f64) -> StageTime {
    StageTime { at: StepStage { step, stage }, step_start: step as f64 * time_step, time_step }
}

/// Rates of the present state, without moving it.
pub fn evaluate<S: FluidSpace>(solver: &mut FluidSolver<S>) {
    let time = stage_time(0, Stage::Predictor, 1e-5);
    solver.begin_stage(&time).unwrap();
    solver.evaluate_own(&time);
    let none = StateColumns::default();
    solver.evaluate_cross(&time, &none, &none);
}

/// One step without a partner.
pub fn try_step<S: FluidSpace>(
    solver: &mut FluidSolver<S>,
    step: u64,
    time_step: f64,
) -> Result<[StageBudget; 2], Box<Divergence>> {
    let mut budgets = [StageBudget::default(); 2];
    let none = StateColumns::default();
    for (k, stage) in Stage::BOTH.into_iter().enumerate() {
        let time = stage_time(step, stage, time_step);
        solver.begin_stage(&time)?;
        solver.evaluate_own(&time);
        solver.evaluate_cross(&time, &none, &none);
        budgets[k] = solver.advance(&time)?;
    }
    solver.end_step(&stage_time(step, Stage::Corrector, time_step))?;
    Ok(budgets)
}

/// `steps` steps without a partner; returns all budgets.
pub fn run<S: FluidSpace>(solver: &mut FluidSolver<S>, steps: u64, time_step: f64) -> Vec<StageBudget> {
    (0..steps).flat_map(|step| try_step(solver, step, time_step).unwrap()).collect()
}

/// Largest residual of check (b).
pub fn largest_residual(budgets: &[StageBudget]) -> f64 {
    let worst = |budgets: &StageBudget| budgets.momentum_residual().max(budgets.angular_residual());
    budgets.iter().map(worst).fold(0.0, f64::max)
}

/// A small dam break between walls: fluid in a corner of a box with slip walls left, right and below.
pub fn dam_break() -> FluidSetup {
    let mut setup = empty_scene(0.02);
    setup.run.body_force.gravity = Vector::new(0.0, -9.81);
    setup.parameters.viscosity_a = 1.0;
    let (spacing, columns) = (0.02, 40);
    add_block(&mut setup, Vector::new(0.1, 0.1), 10, 20);
    add_floor(&mut setup, 0.1 - 3.0 * spacing, 0.1, columns + 6, WallCondition::Slip);
    for (x, normal) in [(0.1 - 3.0 * spacing, 1.0), (0.1 + columns as f64 * spacing, -1.0)] {
        for row in 0..40 {
            for layer in 0..3 {
                let offset = Vector::new(f64::from(layer) + 0.5, f64::from(row) + 0.5) * spacing;
                setup.wall_particles.wall.push(0);
                setup.wall_particles.position.push(Vector::new(x, 0.1) + offset);
                setup.wall_particles.normal.push(Vector::new(normal, 0.0));
            }
        }
    }
    // The blocks of the floor beyond the side walls are where faces meet.
    for w in 0..setup.wall_particles.wall.len() {
        let x = setup.wall_particles.position[w];
        if x.y < 0.1 && !(0.1..0.9).contains(&x.x) {
            setup.wall_particles.normal[w] = Vector::zeros();
        }
    }
    setup
}
