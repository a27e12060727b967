//! The benchmark's water: a block between a floor and two walls, slightly stirred.

use sph::setup::{
    BodyForce, DensityDiffusion, FluidParameters, FluidParticles, FluidScheme, FluidSetup,
    GradientCorrection, LedgerPolicy, Outflow, OutputPlan, RunSetup, StepPolicy, TimePlan, ViscosityForm,
    WallCondition, WallParticles, WallSetup,
};
use sph::space::Space;
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;

/// Height of the block \[m\].
const HEIGHT: f64 = 0.3;
/// Speed of drifting blocks \[m/s\].
const DRIFT: f64 = 1.0;

/// What a benchmark's scene names.
#[derive(Clone, Copy)]
pub struct Settings {
    parameters: FluidParameters,
    walls: bool,
    periodic: bool,
}

const fn with(parameters: FluidParameters) -> Settings {
    Settings { parameters, walls: true, periodic: false }
}

/// The default settings without repulsion by walls.
const WATER: FluidParameters =
    FluidParameters { wall_repulsion: 0.0, acoustic_relaxation_time: Some(1e-3), ..FluidParameters::DEFAULT };

/// The recommended settings: 25 neighbours in the plane, 74 in space.
pub const DEFAULT: Settings = with(WATER);

/// The same at the kernel ratio of 20 neighbours in the plane.
pub const RECOMMENDED: Settings = with(FluidParameters { kernel_ratio: 1.2, ..WATER });

/// The recommended settings, and the same with one thing left out or added.
pub const FEATURES: [(&str, Settings); 14] = [
    ("all", with(WATER)),
    ("predictor-corrector", with(FluidParameters { scheme: FluidScheme::PredictorCorrector, ..WATER })),
    ("h/dx 1.2", RECOMMENDED),
    ("no L_i in (22)", with(FluidParameters { correction: GradientCorrection::Continuity, ..WATER })),
    ("no L_i", with(FluidParameters { correction: GradientCorrection::LatticeMoment, ..WATER })),
    ("plain diffusion", with(FluidParameters { density_diffusion: DensityDiffusion::Plain, ..WATER })),
    ("no shifting", with(FluidParameters { shifting: 0.0, ..WATER })),
    ("no relaxation", with(FluidParameters { acoustic_relaxation: 0.0, ..WATER })),
    ("no volume correction", with(FluidParameters { volume_correction: 0.0, ..WATER })),
    (
        "no order control",
        with(FluidParameters { shifting: 0.0, tensile_control: false, volume_correction: 0.0, ..WATER }),
    ),
    ("with acoustic damper", with(FluidParameters { acoustic_damping: 0.4, ..WATER })),
    (
        "plain artificial viscosity",
        with(FluidParameters { viscosity_a: 0.1, viscosity_form: ViscosityForm::Plain, ..WATER }),
    ),
    ("no artificial viscosity", with(FluidParameters { viscosity_a: 0.0, ..WATER })),
    ("with viscosity", with(FluidParameters { dynamic_viscosity: 1e-3, ..WATER })),
];

/// No pass before the rates.
pub const LEAN: Settings = with(FluidParameters {
    density_diffusion: DensityDiffusion::Plain,
    wall_repulsion: 0.0,
    ..FluidParameters::PLAIN
});

/// A free block that moves as one.
pub const DRIFTING: Settings = Settings { walls: false, ..LEAN };

/// The same in a periodic box.
pub const DRIFTING_PERIODIC: Settings = Settings { periodic: true, ..DRIFTING };

/// Step \[s\] in half of which a drifting block of `particles` moves farther than lists bear: by 0.6 spacings.
pub fn drift_step<S: Space>(particles: usize) -> f64 {
    1.2 * HEIGHT / (rows::<S>(particles) as f64 * DRIFT)
}

/// Rows of a block of about `particles` particles along each axis.
fn rows<S: Space>(particles: usize) -> usize {
    (particles as f64).powf(1.0 / S::DIMENSIONS as f64).round() as usize
}

/// Particles of a block of about `particles`.
pub fn particles<S: Space>(particles: usize) -> usize {
    rows::<S>(particles).pow(S::DIMENSIONS as u32)
}

/// Numbers between -0.5 and 0.5 that look random, the same in each run.
fn noise(k: usize) -> f64 {
    let mixed = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((mixed ^ (mixed >> 32)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

fn vector<S: Space>(component: impl FnMut(usize) -> f64) -> S::Vector {
    S::vector(S::axes(component))
}

/// A square or cubic block of about `particles` particles; up is along the last axis.
pub fn block<S: Space>(settings: Settings, particles: usize) -> FluidSetup<S> {
    let (rows, dimensions) = (rows::<S>(particles), S::DIMENSIONS);
    let (spacing, up) = (HEIGHT / rows as f64, dimensions - 1);
    let gravity = if settings.walls { 9.81 } else { 0.0 };
    let FluidParameters { rest_density, sound_speed, .. } = settings.parameters;
    let mut fluid = FluidParticles::<S>::default();
    for k in 0..rows.pow(dimensions as u32) {
        let noise = |axis: usize| noise(2 * dimensions * k + axis);
        let x = vector::<S>(|axis| {
            let place = (k / rows.pow(axis as u32)) % rows;
            (place as f64 + 0.5 + 0.1 * noise(axis)) * spacing
        });
        let own = vector::<S>(|axis| 0.01 * noise(dimensions + axis));
        fluid.id.push(u32::try_from(k).unwrap_or_else(|_| panic!("too many particles")));
        fluid.region.push(0);
        fluid.mass.push(rest_density * spacing.powi(dimensions as i32));
        fluid.velocity.push(if settings.walls { own } else { S::Vector::repeat(DRIFT) });
        let depth = HEIGHT - x[up];
        fluid.density.push(rest_density * (1.0 + gravity * depth / (sound_speed * sound_speed)));
        fluid.position.push(x);
    }
    let down = vector::<S>(|axis| if axis == up { -gravity } else { 0.0 });
    FluidSetup {
        run: RunSetup {
            run_id: "bench".into(),
            domain: Domain {
                lower: S::Vector::repeat(-0.1 * HEIGHT),
                // A free block may drift on for ever.
                upper: S::Vector::repeat(if settings.periodic { 1.1 } else { 1e6 } * HEIGHT),
                periodic: S::axes(|_| settings.periodic),
            },
            time: TimePlan { start_time: 0.0, end_time: 1.0, step: StepPolicy::Fixed { time_step: 1e-5 } },
            body_force: BodyForce { gravity: down, expressions: None },
            outputs: OutputPlan::default(),
            ledger: LedgerPolicy::default(),
            coupling: None,
        },
        parameters: FluidParameters { particle_spacing: spacing, ..settings.parameters },
        damping: None,
        regions: vec!["water".into()],
        walls: vec![WallSetup {
            name: "tank".into(),
            condition: WallCondition::Slip,
            motion: None,
            release_time: None,
        }],
        particles: fluid,
        wall_particles: if settings.walls { tank(rows, spacing) } else { WallParticles::default() },
        probes: Vec::new(),
        outflow: Outflow::default(),
    }
}

/// Three layers below and beside the block.
fn tank<S: Space>(rows: usize, spacing: f64) -> WallParticles<S> {
    let mut walls = WallParticles::<S>::default();
    let up = S::DIMENSIONS - 1;
    let faces = (0..S::DIMENSIONS).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]);
    for (across, inward) in faces.filter(|face| *face != (up, -1.0)) {
        let normal = vector::<S>(|axis| if axis == across { inward } else { 0.0 });
        let face = if inward > 0.0 { 0.0 } else { rows as f64 };
        for k in 0..3 * rows.pow(S::DIMENSIONS as u32 - 1) {
            let layer = (k % 3) as f64;
            let mut rest = k / 3;
            walls.wall.push(0);
            walls.normal.push(normal);
            walls.position.push(vector::<S>(|axis| {
                if axis == across {
                    return (face - inward * (layer + 0.5)) * spacing;
                }
                let place = rest % rows;
                rest /= rows;
                (place as f64 + 0.5) * spacing
            }));
        }
    }
    walls
}
