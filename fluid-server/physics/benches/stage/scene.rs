//! The benchmark's water: a block between a floor and two walls, slightly stirred.

use sph::setup::{
    BodyForce, DensityDiffusion, FluidParameters, FluidParticles, FluidScheme, FluidSetup,
    GradientCorrection, LedgerPolicy, Outflow, OutputPlan, RunSetup, StepPolicy, TimePlan, WallCondition,
    WallParticles, WallSetup,
};
use sph::space::Vector;
use sph::space::domain::Domain;

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

/// The same at the kernel ratio of 20 neighbours.
pub const RECOMMENDED: Settings = with(FluidParameters { kernel_ratio: 1.2, ..WATER });

/// The recommended settings, and the same with one thing left out or added.
pub const FEATURES: [(&str, Settings); 13] = [
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
pub fn drift_step(particles: usize) -> f64 {
    1.2 * spacing(particles) / DRIFT
}

fn spacing(particles: usize) -> f64 {
    HEIGHT / (particles as f64).sqrt()
}

/// Numbers between -0.5 and 0.5 that look random, the same in each run.
fn noise(k: usize) -> f64 {
    let mixed = (k as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((mixed ^ (mixed >> 32)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// A square block of about `particles` particles.
pub fn block(settings: Settings, particles: usize) -> FluidSetup {
    let spacing = spacing(particles);
    let rows = (HEIGHT / spacing).round() as usize;
    let gravity = Vector::new(0.0, if settings.walls { -9.81 } else { 0.0 });
    let FluidParameters { rest_density, sound_speed, .. } = settings.parameters;
    let mut fluid = FluidParticles::default();
    for k in 0..rows * rows {
        let (column, row) = (k % rows, k / rows);
        let stir = Vector::new(noise(4 * k), noise(4 * k + 1)) * (0.1 * spacing);
        let x = Vector::new(column as f64 + 0.5, row as f64 + 0.5) * spacing;
        let own = Vector::new(noise(4 * k + 2), noise(4 * k + 3)) * 0.01;
        fluid.id.push(u32::try_from(k).unwrap_or_else(|_| panic!("too many particles")));
        fluid.region.push(0);
        fluid.mass.push(rest_density * spacing * spacing);
        fluid.position.push(x + stir);
        fluid.velocity.push(if settings.walls { own } else { Vector::repeat(DRIFT) });
        let depth = HEIGHT - x.y;
        fluid.density.push(rest_density * (1.0 - gravity.y * depth / (sound_speed * sound_speed)));
    }
    FluidSetup {
        run: RunSetup {
            run_id: "bench".into(),
            domain: Domain {
                lower: Vector::repeat(-0.1 * HEIGHT),
                // A free block may drift on for ever.
                upper: Vector::repeat(if settings.periodic { 1.1 } else { 1e6 } * HEIGHT),
                periodic: [settings.periodic; 2],
            },
            time: TimePlan { start_time: 0.0, end_time: 1.0, step: StepPolicy::Fixed { time_step: 1e-5 } },
            body_force: BodyForce { gravity, expressions: None },
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
fn tank(rows: usize, spacing: f64) -> WallParticles {
    let mut walls = WallParticles::default();
    let mut add = |column: f64, row: f64, normal: Vector| {
        walls.wall.push(0);
        walls.position.push(Vector::new(column + 0.5, row + 0.5) * spacing);
        walls.normal.push(normal);
    };
    for layer in 1..=3 {
        let depth = f64::from(layer);
        for k in 0..rows {
            let along = k as f64;
            add(along, -depth, Vector::new(0.0, 1.0));
            add(-depth, along, Vector::new(1.0, 0.0));
            add(rows as f64 - 1.0 + depth, along, Vector::new(-1.0, 0.0));
        }
    }
    walls
}
