//! Small set-ups that the checks open: a patch of water beside a block of a solid, without walls.
//!
//! Vectors have three components; in the plane the last one is zero.

use sph::coupling::ledger::LedgerVector;
use sph::coupling::solver::Role;
use sph::map_space;
use sph::setup::{
    BodyForce, BodySetup, BreachAction, ContactLaw, Coupling, CouplingKind, DensityDiffusion,
    ElasticParameters, FluidParameters, FluidParticles, FluidScheme, FluidSetup, Formulation,
    ImplicitCoupling, InterfaceLaw, LedgerPolicy, Outflow, OutputPlan, ParameterSet, ParticipantSetup,
    RepulsionParameters, RunSetup, SolidParticles, SolidSetup, SolidStepping, StepPolicy, Support, TimePlan,
    TotalLagrangian, WallParticles,
};
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::space::{SomeSpace, Space};

/// Spacing of water and solid \[m\].
pub(super) const SPACING: f64 = 0.01;
/// Step of a scene in the plane \[s\]: two fifths of what the solid's waves allow.
const TIME_STEP: f64 = 1e-4;
/// Step of a scene in space \[s\]. The stage rule amplifies the fastest waves of a body, at angular frequency ω, by (ω Δt)⁴/8 in
/// a step, and a lattice in space has faster ones: at 1e-4 s a block at rest diverged after 196 steps.
const SPATIAL_TIME_STEP: f64 = 5e-5;
/// Density of the solid \[kg/m³\].
pub(super) const SOLID_DENSITY: f64 = 1200.0;
const REST_DENSITY: f64 = 1000.0;
/// Columns and rows of the water, and of the solid.
const WATER: [u32; 2] = [8, 6];
const BLOCK: [u32; 2] = [6, 12];
/// Layers of both in space.
const LAYERS: u32 = 6;
/// Rows of the solid that a clamp holds.
const CLAMPED_ROWS: u32 = 3;

/// What a scene is to be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scene {
    pub(super) space: SomeSpace,
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
    pub(super) velocity: LedgerVector,
    /// Velocity of the water on top of that \[m/s\]: a partner that moves, so that old states are wrong ones.
    pub(super) stream: LedgerVector,
    pub(super) gravity: LedgerVector,
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
    pub(super) fn still(space: SomeSpace, kind: CouplingKind) -> Self {
        Self {
            space,
            kind,
            coupled: true,
            clamped: false,
            rigid: false,
            rise: 0,
            touching: false,
            velocity: LedgerVector::zeros(),
            stream: LedgerVector::zeros(),
            gravity: LedgerVector::zeros(),
            compression: 0.0,
            turned: false,
            time_step: if space.dimensions() == 3 { SPATIAL_TIME_STEP } else { TIME_STEP },
            steps: 20,
            implicit: None,
            spare_water: 0,
        }
    }

    /// Compressed water that moves against the solid.
    pub(super) fn pushing(space: SomeSpace, kind: CouplingKind) -> Self {
        let stream = in_dimensions(space, [0.5, 0.1, 0.07]);
        Self { touching: true, compression: 0.01, stream, ..Self::still(space, kind) }
    }

    /// The set-up for `role`.
    pub(super) fn setup(&self, role: Role) -> ParticipantSetup {
        match role {
            Role::Fluid => ParticipantSetup::Fluid(map_space!(self.space, space => self.fluid(space))),
            Role::Solid => ParticipantSetup::Solid(map_space!(self.space, space => self.solid(space))),
        }
    }

    /// Time that the scene lasts \[s\].
    pub(super) fn duration(&self) -> f64 {
        f64::from(self.steps) * self.time_step
    }

    /// `vector` in the turned scene.
    fn directed<S: Space>(&self, vector: LedgerVector) -> S::Vector {
        lowered::<S>(if self.turned { LedgerVector::new(-vector.y, vector.x, vector.z) } else { vector })
    }

    fn placed<S: Space>(&self, position: LedgerVector) -> S::Vector {
        let centre = LedgerVector::repeat(0.5);
        lowered::<S>(centre) + self.directed::<S>(position - centre)
    }

    fn run<S: Space>(&self) -> RunSetup<S> {
        RunSetup {
            run_id: "conform".into(),
            domain: Domain {
                lower: S::Vector::zeros(),
                upper: S::Vector::repeat(1.0),
                periodic: S::splat(false),
            },
            time: TimePlan {
                start_time: 0.0,
                end_time: self.duration(),
                step: StepPolicy::Fixed { time_step: self.time_step },
            },
            body_force: BodyForce { gravity: self.directed::<S>(self.gravity), expressions: None },
            outputs: OutputPlan::default(),
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

    /// Number of layers across the plane.
    fn layers(&self) -> u32 {
        if self.space.dimensions() == 3 { LAYERS } else { 1 }
    }

    fn fluid<S: Space>(&self, _: S) -> FluidSetup<S> {
        let mut particles = FluidParticles::default();
        let left = if self.touching { 0.39 } else { 0.1 };
        let lower = LedgerVector::new(left, 0.47 + SPACING * f64::from(self.rise), 0.47);
        let water = lattice(lower, WATER, self.layers()).map(|(_, position)| position);
        let spare = far_rows(self.spare_water);
        let density = REST_DENSITY * (1.0 + self.compression);
        for (id, position) in (0u32..).zip(water.chain(spare)) {
            particles.id.push(id);
            particles.region.push(0);
            particles.mass.push(density * S::cell_volume(SPACING));
            particles.position.push(self.placed::<S>(position));
            particles.velocity.push(self.directed::<S>(self.velocity + self.stream));
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

    fn solid<S: Space>(&self, _: S) -> SolidSetup<S> {
        let mut particles = SolidParticles::default();
        let block = lattice(LedgerVector::new(0.47, 0.44, 0.47), BLOCK, self.layers());
        for (id, (row, position)) in (0u32..).zip(block) {
            let position = self.placed::<S>(position);
            particles.id.push(id);
            particles.body.push(0);
            particles.support.push(u32::from(self.clamped && row < CLAMPED_ROWS));
            particles.mass.push(SOLID_DENSITY * S::cell_volume(SPACING));
            particles.reference_position.push(position);
            particles.position.push(position);
            particles.velocity.push(self.directed::<S>(self.velocity));
            particles.density.push(SOLID_DENSITY);
            particles.deviatoric_stress.push(S::SymmetricTensor::default());
        }
        let held = S::per_axis(|_| true);
        let clamp = Support { name: "clamp".into(), held, motion: None, pivot: None, release_time: None };
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

/// The vector of `components`, the last one for space alone.
pub(super) fn in_dimensions(space: SomeSpace, [x, y, z]: [f64; 3]) -> LedgerVector {
    LedgerVector::new(x, y, if space.dimensions() == 3 { z } else { 0.0 })
}

/// The components that `S` has.
fn lowered<S: Space>(vector: LedgerVector) -> S::Vector {
    S::vector(S::axes(|axis| vector[axis]))
}

/// Cell centres of `columns` by `rows` cells from `lower` \[m\] on in each of `layers`, row by row, with their rows.
fn lattice(
    lower: LedgerVector,
    [columns, rows]: [u32; 2],
    layers: u32,
) -> impl Iterator<Item = (u32, LedgerVector)> {
    let centre =
        move |cell: [u32; 3]| LedgerVector::from_fn(|k, _| lower[k] + SPACING * (f64::from(cell[k]) + 0.5));
    (0..layers).flat_map(move |layer| {
        (0..rows).flat_map(move |row| (0..columns).map(move |column| (row, centre([column, row, layer]))))
    })
}

/// `count` places below everything else, closer together than any kernel cares for.
fn far_rows(count: u32) -> impl Iterator<Item = LedgerVector> {
    const PER_ROW: u32 = 1000;
    (0..count).map(|k| {
        let [column, row] = [k % PER_ROW, k / PER_ROW].map(f64::from);
        LedgerVector::new(0.05 + 0.9e-3 * column, 0.02 + 1e-3 * row, 0.5)
    })
}
