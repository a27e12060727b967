//! Small scenes and a driver without a partner.

use nalgebra::Vector3;
use sph::coupling::exchange::StateColumns;
use sph::coupling::ledger::StageBudget;
use sph::coupling::solver::{Divergence, Solver};
use sph::coupling::stage::{Stage, StageTime, StepStage};
use sph::setup::{
    BodyForce, BodySetup, ContactLaw, ElasticParameters, Formulation, HyperelasticLaw, LedgerPolicy,
    OutputPlan, RepulsionParameters, RunSetup, SolidParticles, SolidProbe, SolidProbeKind, SolidSetup,
    SolidStepping, StepPolicy, SubstepCount, Support, TimePlan, TotalLagrangian, UpdatedLagrangian,
    WallCondition, WallParticles, WallSetup,
};
use sph::space::components::Components;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::space::{Plane, Space, Spatial, Vector};

use crate::SolidSolver;
use crate::report::fields::snapshot;
use crate::report::probes::probe_values;
use crate::space::SolidSpace;

/// The solid of the source paper.
pub const RUBBER: ElasticParameters = ElasticParameters {
    density: 1100.0,
    bulk_modulus: 20e6,
    shear_modulus: 4.27e6,
    plane: sph::setup::PlaneState::Strain,
};

/// The contact law of the scenes.
pub const REPULSION: ContactLaw = ContactLaw::Repulsion(RepulsionParameters {
    stiffness: 0.5,
    distance: 1.0,
    damping: 0.2,
    friction: 0.0,
    wet: true,
    self_contact: true,
});

/// The same with another coefficient of friction.
pub fn rough(coefficient: f64) -> ContactLaw {
    let mut law = REPULSION;
    if let ContactLaw::Repulsion(law) = &mut law {
        law.friction = coefficient;
    }
    law
}

/// A total-Lagrangian body with default parameters.
pub fn total_lagrangian(law: HyperelasticLaw) -> Formulation {
    Formulation::TotalLagrangian(TotalLagrangian { law, ..TotalLagrangian::default() })
}

/// Particles of a rectangle of `columns` × `rows` cells whose lower left corner is at `corner` \[m\].
pub fn block(corner: Vector, columns: u32, rows: u32, spacing: f64) -> Vec<Vector> {
    (0..columns * rows)
        .map(|k| corner + Vector::new(f64::from(k % columns) + 0.5, f64::from(k / columns) + 0.5) * spacing)
        .collect()
}

/// Particles of a box of `counts` cells along x, y and z whose lowest corner is at `corner` \[m\]; x runs fastest.
pub fn brick(corner: Vector3<f64>, counts: [u32; 3], spacing: f64) -> Vec<Vector3<f64>> {
    let [nx, ny, nz] = counts;
    let middle = |k: u32| f64::from(k) + 0.5;
    (0..nx * ny * nz)
        .map(|k| corner + Vector3::new(middle(k % nx), middle(k / nx % ny), middle(k / nx / ny)) * spacing)
        .collect()
}

/// An empty scene in a square of ±1 m.
pub fn scene(spacing: f64) -> SolidSetup {
    scene_in(spacing)
}

/// The same in a box of a space.
pub fn scene_in<S: Space>(spacing: f64) -> SolidSetup<S> {
    SolidSetup {
        run: RunSetup {
            run_id: "test".into(),
            domain: Domain {
                lower: S::Vector::repeat(-1.0),
                upper: S::Vector::repeat(1.0),
                periodic: S::splat(false),
            },
            time: TimePlan { start_time: 0.0, end_time: 1.0, step: StepPolicy::Fixed { time_step: 1e-5 } },
            body_force: BodyForce { gravity: S::Vector::zeros(), expressions: None },
            outputs: OutputPlan::default(),
            ledger: LedgerPolicy::default(),
            coupling: None,
        },
        particle_spacing: spacing,
        bodies: Vec::new(),
        particles: SolidParticles::default(),
        contact: REPULSION,
        walls: Vec::new(),
        wall_particles: WallParticles::default(),
        damping: None,
        stepping: SolidStepping::StageRule,
        probes: Vec::new(),
        lost_particle_limit: 0,
    }
}

/// Adds a body of rubber at rest; returns its index.
pub fn add_body<S: Space>(
    setup: &mut SolidSetup<S>,
    formulation: Formulation,
    positions: &[S::Vector],
) -> u32 {
    let body = setup.bodies.len() as u32;
    let spacing = setup.particle_spacing;
    setup.bodies.push(BodySetup {
        name: format!("body{body}"),
        material: RUBBER,
        formulation,
        supports: Vec::new(),
        acceleration: None,
        loads: Vec::new(),
    });
    let p = &mut setup.particles;
    for x in positions {
        p.id.push(p.id.len() as u32);
        p.body.push(body);
        p.support.push(0);
        p.mass.push((0..S::DIMENSIONS).fold(RUBBER.density, |mass, _| mass * spacing));
        p.reference_position.push(*x);
        p.position.push(*x);
        p.velocity.push(S::Vector::zeros());
        p.density.push(RUBBER.density);
        p.deviatoric_stress.push(S::SymmetricTensor::default());
    }
    body
}

/// Adds the elastic body of the source paper.
pub fn add_elastic<S: Space>(setup: &mut SolidSetup<S>, positions: &[S::Vector]) -> u32 {
    let formulation = Formulation::UpdatedLagrangian(UpdatedLagrangian::default());
    add_body(setup, formulation, positions)
}

/// Adds `support` to `body` for its particles that `holds` picks.
pub fn add_support<S: Space>(
    setup: &mut SolidSetup<S>,
    body: u32,
    support: Support<S>,
    holds: impl Fn(&S::Vector) -> bool,
) {
    setup.bodies[body as usize].supports.push(support);
    let index = setup.bodies[body as usize].supports.len() as u32;
    let p = &mut setup.particles;
    for i in 0..p.id.len() {
        if p.body[i] == body && holds(&p.position[i]) {
            p.support[i] = index;
        }
    }
}

/// A support that holds all components at rest.
pub fn clamp() -> Support {
    Support { name: "clamp".into(), held: [true, true], motion: None, pivot: None, release_time: None }
}

/// The same in space.
pub fn spatial_clamp() -> Support<Spatial> {
    Support { name: "clamp".into(), held: [true; 3], motion: None, pivot: None, release_time: None }
}

/// Adds a wall of the given particles.
pub fn add_wall<S: Space>(setup: &mut SolidSetup<S>, positions: &[S::Vector]) {
    let wall = setup.walls.len() as u32;
    setup.walls.push(WallSetup {
        name: format!("wall{wall}"),
        condition: WallCondition::Slip,
        motion: None,
        release_time: None,
    });
    for x in positions {
        setup.wall_particles.wall.push(wall);
        setup.wall_particles.position.push(*x);
        let mut normal = S::Vector::zeros();
        normal[1] = 1.0;
        setup.wall_particles.normal.push(normal);
    }
}

/// Adds a total-Lagrangian neo-Hookean body to a scene with `substeps` sub-steps per step.
pub fn add_total<S: Space>(setup: &mut SolidSetup<S>, substeps: u32, positions: &[S::Vector]) -> u32 {
    setup.stepping = SolidStepping::Substeps(SubstepCount::Fixed(substeps));
    let formulation = total_lagrangian(HyperelasticLaw::NeoHookean);
    add_body(setup, formulation, positions)
}

/// Gives all bodies `material`, at rest density.
pub fn set_material<S: Space>(setup: &mut SolidSetup<S>, material: ElasticParameters) {
    let cell = S::cell_volume(setup.particle_spacing);
    setup.bodies.iter_mut().for_each(|body| body.material = material);
    setup.particles.mass.fill(material.density * cell);
    setup.particles.density.fill(material.density);
}

/// Sets velocities from positions.
pub fn set_velocity<S: Space>(setup: &mut SolidSetup<S>, velocity: impl Fn(&S::Vector) -> S::Vector) {
    setup.particles.velocity = setup.particles.position.iter().map(velocity).collect();
}

/// Adds a probe.
pub fn add_probe<S: Space>(setup: &mut SolidSetup<S>, kind: SolidProbeKind<S>) {
    setup.probes.push(SolidProbe { name: format!("probe{}", setup.probes.len()), kind });
}

/// A solver stepped with a fixed time step.
pub struct Run<S: SolidSpace = Plane> {
    pub solver: SolidSolver<S>,
    pub time_step: f64,
    pub step: u64,
    start_time: f64,
    /// Largest residual of check (b) so far.
    pub largest_residual: f64,
}

impl<S: SolidSpace> Run<S> {
    /// A run of `setup`.
    pub fn new(setup: SolidSetup<S>, time_step: f64) -> Self {
        let start_time = setup.run.time.start_time;
        let solver = SolidSolver::new(setup).unwrap();
        Self { solver, time_step, step: 0, start_time, largest_residual: 0.0 }
    }

    /// Time reached \[s\].
    pub fn time(&self) -> f64 {
        self.start_time + self.step as f64 * self.time_step
    }

    /// One step; returns the budget of its stages.
    pub fn step(&mut self) -> Result<[StageBudget; 2], Box<Divergence>> {
        let mut budget = [StageBudget::default(); 2];
        let none = StateColumns::default();
        for (k, stage) in Stage::BOTH.into_iter().enumerate() {
            let time = self.stage_time(stage);
            self.solver.begin_stage(&time)?;
            self.solver.evaluate_own(&time);
            self.solver.evaluate_cross(&time, &none, &none);
            budget[k] = self.solver.advance(&time)?;
            self.largest_residual =
                self.largest_residual.max(budget[k].momentum_residual()).max(budget[k].angular_residual());
        }
        self.solver.end_step(&self.stage_time(Stage::Corrector))?;
        self.step += 1;
        Ok(budget)
    }

    /// Steps up to `time` \[s\].
    pub fn until(&mut self, time: f64) {
        while self.time() < time - 1e-9 * self.time_step {
            self.step().unwrap();
        }
    }

    /// Times of a stage of the step to come.
    pub fn stage_time(&self, stage: Stage) -> StageTime {
        StageTime {
            at: StepStage { step: self.step, stage },
            step_start: self.time(),
            time_step: self.time_step,
        }
    }

    /// A vector field of the particles.
    pub fn vectors(&self, name: &str) -> Vec<S::Vector> {
        let snapshot = snapshot(&self.solver.model, &self.solver.state, self.step, self.time());
        let field = snapshot.field(name).unwrap();
        field.values.chunks(S::DIMENSIONS).filter_map(S::Vector::of_row).collect()
    }

    /// A scalar field, or all components of another.
    pub fn values(&self, name: &str) -> Vec<f64> {
        snapshot(&self.solver.model, &self.solver.state, self.step, self.time())
            .field(name)
            .unwrap()
            .values
            .clone()
    }

    /// Values of all probes.
    pub fn probes(&self) -> Vec<f64> {
        let mut values = Vec::new();
        probe_values(&self.solver.model, &self.solver.state, self.time(), &mut values);
        values
    }

    /// Bits of all fields.
    pub fn bits(&self) -> Vec<u64> {
        let snapshot = snapshot(&self.solver.model, &self.solver.state, self.step, self.time());
        snapshot.fields.iter().flat_map(|f| f.values.iter().map(|v| v.to_bits())).collect()
    }
}
