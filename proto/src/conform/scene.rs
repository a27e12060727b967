//! Small set-ups that the checks open: a patch of water beside a block of a solid, without walls.

use sph::coupling::solver::Role;
use sph::setup::{
    BodyForce, BodySetup, BreachAction, ContactLaw, Coupling, CouplingKind, DensityDiffusion,
    ElasticParameters, FluidParameters, FluidParticles, FluidScheme, FluidSetup, Formulation,
    ImplicitCoupling, InterfaceLaw, LedgerPolicy, Outflow, OutputPlan, ParameterSet, ParticipantSetup,
    RepulsionParameters, RunSetup, SolidParticles, SolidSetup, SolidStepping, StepPolicy, Support, TimePlan,
    TotalLagrangian, WallParticles,
};
use sph::space::domain::Domain;
use sph::space::{SymmetricTensor, Vector};

/// Spacing of water and solid \[m\].
pub(super) const SPACING: f64 = 0.01;
/// Step of a scene \[s\]: two fifths of what the solid's waves allow.
pub(super) const TIME_STEP: f64 = 1e-4;
/// Density of the solid \[kg/m³\].
pub(super) const SOLID_DENSITY: f64 = 1200.0;
const REST_DENSITY: f64 = 1000.0;
/// Columns and rows of the water, and of the solid.
const WATER: (u32, u32) = (8, 6);
const BLOCK: (u32, u32) = (6, 12);
/// Rows of the solid that a clamp holds.
const CLAMPED_ROWS: u32 = 3;

/// What a scene is to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scene {
    pub(super) kind: CouplingKind,
    pub(super) coupled: bool,
    /// Whether the solid's lowest rows are held.
    pub(super) clamped: bool,
    /// Whether the solid is rigid.
    pub(super) rigid: bool,
    /// Spacings by which the water is higher than the middle of the solid.
    pub(super) rise: u32,
    /// Whether water and solid touch; otherwise they are far apart.
    pub(super) touching: bool,
    /// Velocity of everything \[m/s\].
    pub(super) velocity: Vector,
    /// Velocity of the water on top of that \[m/s\]: a partner that moves, so that old states are wrong ones.
    pub(super) stream: Vector,
    pub(super) gravity: Vector,
    /// Relative compression of the water at the start.
    pub(super) compression: f64,
    /// Whether everything is turned by a quarter about the centre of the domain.
    pub(super) turned: bool,
    pub(super) time_step: f64,
    pub(super) steps: u32,
    /// How half-steps are iterated.
    pub(super) implicit: Option<ImplicitCoupling>,
    /// Further particles of water, far from everything.
    pub(super) spare_water: u32,
}

impl Scene {
    /// A scene at rest without contact.
    pub(super) fn still(kind: CouplingKind) -> Self {
        Self {
            kind,
            coupled: true,
            clamped: false,
            rigid: false,
            rise: 0,
            touching: false,
            velocity: Vector::zeros(),
            stream: Vector::zeros(),
            gravity: Vector::zeros(),
            compression: 0.0,
            turned: false,
            time_step: TIME_STEP,
            steps: 20,
            implicit: None,
            spare_water: 0,
        }
    }

    /// Compressed water that moves against the solid.
    pub(super) fn pushing(kind: CouplingKind) -> Self {
        let stream = Vector::new(0.5, 0.1);
        Self { touching: true, compression: 0.01, stream, ..Self::still(kind) }
    }

    /// The set-up for `role`.
    pub(super) fn setup(&self, role: Role) -> ParticipantSetup {
        match role {
            Role::Fluid => ParticipantSetup::Fluid(self.fluid()),
            Role::Solid => ParticipantSetup::Solid(self.solid()),
        }
    }

    /// Time that the scene lasts \[s\].
    pub(super) fn duration(&self) -> f64 {
        f64::from(self.steps) * self.time_step
    }

    /// `vector` in the turned scene.
    pub(super) fn directed(&self, vector: Vector) -> Vector {
        if self.turned { Vector::new(-vector.y, vector.x) } else { vector }
    }

    fn placed(&self, position: Vector) -> Vector {
        let centre = Vector::new(0.5, 0.5);
        centre + self.directed(position - centre)
    }

    fn run(&self) -> RunSetup {
        RunSetup {
            run_id: "conform".into(),
            domain: Domain { lower: Vector::zeros(), upper: Vector::new(1.0, 1.0), periodic: [false; 2] },
            time: TimePlan {
                start_time: 0.0,
                end_time: self.duration(),
                step: StepPolicy::Fixed { time_step: self.time_step },
            },
            body_force: BodyForce { gravity: self.directed(self.gravity), expressions: None },
            outputs: OutputPlan { snapshot_interval: None, probe_interval: None },
            ledger: LedgerPolicy { action: BreachAction::Stop, ..LedgerPolicy::default() },
            coupling: self.coupled.then(|| Coupling {
                kind: self.kind,
                law: InterfaceLaw::Wall,
                fluid: fluid_parameters().of_pair_law(),
                solid_spacing: SPACING,
                repulsion: 0.0,
                margin: 2.0 * SPACING,
                implicit: self.implicit,
            }),
        }
    }

    fn fluid(&self) -> FluidSetup {
        let mut particles = FluidParticles::default();
        let left = if self.touching { 0.39 } else { 0.1 };
        let water = lattice(Vector::new(left, 0.47 + SPACING * f64::from(self.rise)), WATER);
        let spare = far_rows(self.spare_water);
        let density = REST_DENSITY * (1.0 + self.compression);
        for (id, position) in (0u32..).zip(water.chain(spare)) {
            particles.id.push(id);
            particles.region.push(0);
            particles.mass.push(density * SPACING * SPACING);
            particles.position.push(self.placed(position));
            particles.velocity.push(self.directed(self.velocity + self.stream));
            particles.density.push(density);
        }
        FluidSetup {
            run: self.run(),
            parameters: fluid_parameters(),
            damping: None,
            regions: vec!["water".into()],
            walls: Vec::new(),
            particles,
            wall_particles: WallParticles::default(),
            probes: Vec::new(),
            outflow: Outflow::default(),
        }
    }

    fn solid(&self) -> SolidSetup {
        let mut particles = SolidParticles::default();
        for (id, position) in (0u32..).zip(lattice(Vector::new(0.47, 0.44), BLOCK)) {
            let position = self.placed(position);
            particles.id.push(id);
            particles.body.push(0);
            particles.support.push(u32::from(self.clamped && id < CLAMPED_ROWS * BLOCK.0));
            particles.mass.push(SOLID_DENSITY * SPACING * SPACING);
            particles.reference_position.push(position);
            particles.position.push(position);
            particles.velocity.push(self.directed(self.velocity));
            particles.density.push(SOLID_DENSITY);
            particles.deviatoric_stress.push(SymmetricTensor::default());
        }
        let clamp = Support { name: "clamp".into(), held: [true; 2], motion: None, release_time: None };
        SolidSetup {
            run: self.run(),
            particle_spacing: SPACING,
            bodies: vec![BodySetup {
                name: "block".into(),
                material: ElasticParameters {
                    density: SOLID_DENSITY,
                    bulk_modulus: 2e6,
                    shear_modulus: 1e6,
                    plane: sph::setup::PlaneState::Strain,
                },
                formulation: if self.rigid { Formulation::Rigid } else { elastic() },
                supports: if self.clamped { vec![clamp] } else { Vec::new() },
                acceleration: None,
                loads: Vec::new(),
            }],
            particles,
            contact: ContactLaw::Repulsion(RepulsionParameters {
                self_contact: false,
                ..RepulsionParameters::default()
            }),
            walls: Vec::new(),
            wall_particles: WallParticles::default(),
            damping: None,
            stepping: SolidStepping::StageRule,
            probes: Vec::new(),
            lost_particle_limit: 0,
        }
    }
}

fn elastic() -> Formulation {
    Formulation::TotalLagrangian(TotalLagrangian::default())
}

/// Parameters of the water: no viscosity, so that forces are smooth.
fn fluid_parameters() -> FluidParameters {
    FluidParameters {
        rest_density: REST_DENSITY,
        particle_spacing: SPACING,
        viscosity_a: 0.0,
        density_diffusion: DensityDiffusion::None,
        wall_repulsion: 0.0,
        scheme: FluidScheme::PredictorCorrector,
        ..FluidParameters::PLAIN
    }
}

/// Name of the kernel that all constants belong to.
pub(super) const KERNEL: &str = sph::kernel::NAME;

/// Cell centres of `columns` by `rows` cells from `lower` \[m\] on, row by row.
fn lattice(lower: Vector, (columns, rows): (u32, u32)) -> impl Iterator<Item = Vector> {
    (0..rows).flat_map(move |row| {
        (0..columns)
            .map(move |column| lower + SPACING * Vector::new(f64::from(column) + 0.5, f64::from(row) + 0.5))
    })
}

/// `count` places below everything else, closer together than any kernel cares for.
fn far_rows(count: u32) -> impl Iterator<Item = Vector> {
    const PER_ROW: u32 = 1000;
    (0..count)
        .map(|k| Vector::new(0.05 + 0.9e-3 * f64::from(k % PER_ROW), 0.02 + 1e-3 * f64::from(k / PER_ROW)))
}
