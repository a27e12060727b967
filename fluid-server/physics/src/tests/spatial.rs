//! Laws of the fluid in space: the ladder of tests of the plane.

use nalgebra::{Matrix3, Vector3};
use sph::coupling::solver::Solver;
use sph::setup::{
    Damping, DensityDiffusion, FluidParameters, FluidProbe, FluidProbeKind, FluidScheme, FluidSetup,
    GradientCorrection, ViscousForm, WallCondition, WallSetup,
};
use sph::space::{Plane, Space, Spatial};

use super::support::{
    add_lattice, disturb, empty_scene_in, evaluate, largest_residual, run, solver, variants,
};
use crate::FluidSolver;
use crate::system::packed_particle::FluidSpace;

const SEEDS: [u64; 2] = [1, 2];

/// A cube of 7 × 7 × 7 particles, displaced by up to 0.2 spacings, with random velocity, density and mass.
fn random_patch(seed: u64) -> FluidSetup<Spatial> {
    let mut setup = empty_scene_in(0.02);
    add_lattice(&mut setup, Vector3::repeat(0.4), [7, 7, 7]);
    disturb(&mut setup, seed);
    setup
}

/// Adds slip walls of three layers around the box from `lower` on, of `counts` cells, on the sides below and above along
/// each axis that `closed` names.
pub(super) fn add_container<S: Space>(
    setup: &mut FluidSetup<S>,
    lower: S::Vector,
    counts: S::Of<usize>,
    closed: S::Of<[bool; 2]>,
) {
    const LAYERS: i64 = 3;
    let spacing = setup.parameters.particle_spacing;
    setup.walls.push(WallSetup {
        name: "tank".into(),
        condition: WallCondition::Slip,
        motion: None,
        release_time: None,
    });
    let layers = |axis: usize, side: usize| if closed[axis][side] { LAYERS } else { 0 };
    let width = |axis: usize| counts[axis] as i64 + layers(axis, 0) + layers(axis, 1);
    for cell in 0..(0..S::DIMENSIONS).map(width).product::<i64>() {
        let (mut position, mut normal, mut rest, mut outside) = (lower, lower * 0.0, cell, 0);
        for axis in 0..S::DIMENSIONS {
            let place = rest % width(axis) - layers(axis, 0);
            rest /= width(axis);
            position[axis] += (place as f64 + 0.5) * spacing;
            let side = i64::from(place < 0) - i64::from(place >= counts[axis] as i64);
            normal[axis] = side as f64;
            outside += side.abs();
        }
        if outside > 0 {
            setup.wall_particles.wall.push(0);
            setup.wall_particles.position.push(position);
            // Where faces meet there is no normal.
            setup.wall_particles.normal.push(if outside == 1 { normal } else { normal * 0.0 });
        }
    }
}

/// Σ m a, Σ x × m a, and Σ m |a| of the last evaluation.
fn force_sums(solver: &FluidSolver<Spatial>) -> (Vector3<f64>, Vector3<f64>, f64) {
    let (mut force, mut torque, mut gross) = (Vector3::zeros(), Vector3::zeros(), 0.0);
    for (i, rates) in solver.workspace.rates.iter().enumerate() {
        let f = rates.acceleration * solver.state.mass[i];
        force += f;
        torque += solver.state.position[i].cross(&f);
        gross += f.norm();
    }
    (force, torque, gross)
}

#[test]
fn internal_forces_cancel_for_every_variant() {
    for (correction, diffusion) in variants() {
        for (viscosity, form) in
            [(0.0, ViscousForm::Pairwise), (5.0, ViscousForm::Pairwise), (5.0, ViscousForm::Stress)]
        {
            for seed in SEEDS {
                let mut setup = random_patch(seed);
                setup.parameters.correction = correction;
                setup.parameters.dynamic_viscosity = viscosity;
                setup.parameters.viscous_form = form;
                setup.parameters.density_diffusion = diffusion;
                let mut solver = solver(setup);
                evaluate(&mut solver);
                let (force, torque, gross) = force_sums(&solver);
                assert!(gross > 0.1, "{gross}");
                // Round-off of some 25,000 pairs, each to 1e-15 of about the gross over the particles.
                assert!(force.norm() < 1e-13 * gross, "{correction:?} {diffusion:?}: {force} of {gross}");
                // Pair forces are central unless L_i or viscosity turns them.
                if correction != GradientCorrection::Renormalised && viscosity == 0.0 {
                    assert!(torque.norm() < 1e-13 * gross, "{correction:?}: {torque} of {gross}");
                }
            }
        }
    }
}

#[test]
fn diffusion_moves_density_without_making_any() {
    for diffusion in [DensityDiffusion::Plain, DensityDiffusion::Renormalised] {
        let rates = |diffusion| {
            let mut setup = random_patch(1);
            setup.parameters.density_diffusion = diffusion;
            let mut solver = solver(setup);
            evaluate(&mut solver);
            solver
        };
        let (with, without) = (rates(diffusion), rates(DensityDiffusion::None));
        let (mut net, mut gross) = (0.0, 0.0);
        for i in 0..with.state.len() {
            let volume = with.state.mass[i] / with.state.density[i];
            let change = volume * (with.workspace.rates[i].density - without.workspace.rates[i].density);
            net += change;
            gross += change.abs();
        }
        assert!(gross > 1e-5, "{gross}");
        // Round-off of the difference of two rates whose common part is some ten times larger.
        assert!(net.abs() < 1e-11 * gross, "{diffusion:?}: {net} of {gross}");
    }
}

#[test]
fn a_linear_velocity_field_has_its_divergence_up_to_the_faces() {
    // v = G x: dρ/dt = −ρ tr G.
    let gradient = Matrix3::new(3.0, -2.0, 0.7, 1.0, 1.5, -0.4, 0.3, 0.9, -1.0);
    let mut setup = empty_scene_in::<Spatial>(0.02);
    add_lattice(&mut setup, Vector3::repeat(0.4), [7, 7, 7]);
    setup.parameters.density_diffusion = DensityDiffusion::None;
    setup.parameters.correction = GradientCorrection::Renormalised;
    let p = &mut setup.particles;
    for i in 0..p.id.len() {
        p.velocity[i] = gradient * p.position[i];
    }
    let mut solver = solver(setup);
    evaluate(&mut solver);
    let mut exact = 0;
    for i in 0..solver.state.len() {
        let from_middle = (solver.state.position[i] - Vector3::repeat(0.47)).abs();
        // At edges and corners L_i gives way to the unit matrix.
        if (0..3).filter(|axis| from_middle[*axis] > 0.05).count() < 2 {
            // Exact up to round-off of sums of 100 terms.
            let rate = solver.workspace.rates[i].density;
            assert!((rate + 3.5 * 1000.0).abs() < 1e-8, "{rate} at {from_middle}");
            exact += 1;
        }
    }
    assert!(exact > 200, "{exact}");
}

#[test]
fn the_density_gradient_of_a_linear_field_is_exact_up_to_the_faces() {
    let mut setup = random_patch(7);
    for i in 0..setup.particles.id.len() {
        let x = setup.particles.position[i];
        setup.particles.density[i] = 1000.0 + 30.0 * x.x - 20.0 * x.y + 10.0 * x.z;
    }
    let mut solver = solver(setup);
    evaluate(&mut solver);
    for [x, y, z, ..] in &solver.workspace.gradients.neighbour_fields {
        let error = Vector3::new(*x, *y, *z) - Vector3::new(30.0, -20.0, 10.0);
        // Round-off of density differences of 1 kg/m³ in 1000 over 0.02 m.
        assert!(error.norm() < 1e-8, "{error}");
    }
}

#[test]
fn still_water_in_a_box_has_its_hydrostatic_pressure() {
    let (spacing, counts) = (0.005, [10, 20, 10]);
    let mut setup = empty_scene_in::<Spatial>(spacing);
    setup.parameters = FluidParameters {
        particle_spacing: spacing,
        // 20 √(gH)
        sound_speed: 20.0,
        acoustic_relaxation: 0.0,
        ..FluidParameters::DEFAULT
    };
    setup.run.body_force.gravity = Vector3::new(0.0, -9.81, 0.0);
    setup.damping = Some(Damping { rate: 100.0, until: 1.0 });
    let lower = Vector3::repeat(0.1);
    add_lattice(&mut setup, lower, counts);
    add_container(&mut setup, lower, [10, 30, 10], [[true, true], [true, false], [true, true]]);
    let mut solver = solver(setup);
    for i in 0..solver.state.len() {
        let at_rest = 1000.0 * 9.81 * (0.2 - solver.state.position[i].y);
        solver.state.density[i] = solver.model.equation_of_state.density(at_rest);
    }
    let budgets = run(&mut solver, 800, 1.2e-4);
    assert!(largest_residual(&budgets) < 1e-12);
    let state = &solver.state;
    let (mut error, mut count) = (0.0, 0);
    for i in 0..state.len() {
        // A pressure carries what stands above it, however the lattice is compressed.
        let rows_above = counts[1] as f64 - 0.5 - ((state.position[i].y - 0.1) / spacing).floor();
        if rows_above > 8.0 {
            let exact = 1000.0 * 9.81 * spacing * rows_above;
            error += solver.model.equation_of_state.pressure(state.density[i]) / exact - 1.0;
            count += 1;
        }
    }
    let error = error / f64::from(count);
    // The goal of still water in validation.
    assert!(error.abs() < 1e-3, "{error}");
}

/// A dam break in a corner with all stabilisers and leapfrog, `layers` deep along a periodic z in space.
fn dam_break<S: FluidSpace>(
    counts: S::Of<usize>,
    tank: S::Of<usize>,
    closed: S::Of<[bool; 2]>,
) -> FluidSetup<S> {
    let spacing = 0.02;
    let mut setup = empty_scene_in::<S>(spacing);
    setup.parameters = FluidParameters {
        particle_spacing: spacing,
        sound_speed: 30.0,
        scheme: FluidScheme::Leapfrog,
        acoustic_relaxation: 0.0,
        volume_correction: 0.0,
        ..FluidParameters::DEFAULT
    };
    setup.run.body_force.gravity[1] = -9.81;
    let mut lower = setup.run.domain.lower;
    (lower[0], lower[1]) = (0.1, 0.1);
    add_lattice(&mut setup, lower, counts);
    add_container(&mut setup, lower, tank, closed);
    setup
}

#[test]
fn a_slab_that_repeats_along_z_flows_as_the_plane_does() {
    // A support of 5.2 spacings with skin on either side of a pair must fit into the period.
    let layers = 12;
    let mut setup = dam_break::<Spatial>(
        [10, 20, layers],
        [40, 40, layers],
        [[true, true], [true, false], [false, false]],
    );
    setup.run.domain.upper.z = layers as f64 * 0.02;
    setup.run.domain.periodic = [false, false, true];
    setup.parameters.volume_correction = FluidParameters::DEFAULT.volume_correction;
    let mut space = solver(setup);
    let mut setup = dam_break::<Plane>([10, 20], [40, 40], [[true, true], [true, false]]);
    setup.parameters.volume_correction = FluidParameters::DEFAULT.volume_correction;
    let mut plane = solver(setup);
    let (steps, time_step) = (300, 4e-4);
    let budgets = run(&mut space, steps, time_step);
    assert!(largest_residual(&budgets) < 1e-12);
    run(&mut plane, steps, time_step);
    let fastest = space.state.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max);
    assert!(fastest > 0.5, "{fastest}");
    // Layers of a lattice stay alike; round-off grows over the steps.
    let across = space.state.velocity.iter().map(|v| v.z.abs()).fold(0.0, f64::max);
    assert!(across < 1e-9 * fastest, "{across} of {fastest}");
    let front = |x: f64, front: f64| front.max(x);
    let in_space = space.state.position.iter().map(|x| x.x).fold(0.0, front);
    let in_plane = plane.state.position.iter().map(|x| x.x).fold(0.0, front);
    // Of the way from the start at 0.3 m; sums over a lattice differ by a per cent between plane and space.
    let way = in_plane - 0.3;
    assert!(way > 0.05 && (in_space - in_plane).abs() < 0.05 * way, "{in_space} {in_plane}");
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let digest = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = solver(dam_break::<Spatial>(
                [8, 12, 8],
                [16, 20, 8],
                [[true, true], [true, false], [true, true]],
            ));
            run(&mut solver, 20, 4e-4);
            let mut saved = sph::coupling::saved::SavedState::default();
            solver.save(&mut saved);
            saved
        })
    };
    assert_eq!(digest(1), digest(3));
}

#[test]
fn gauges_and_fluxes_of_a_block_that_moves() {
    let mut setup = empty_scene_in::<Spatial>(0.02);
    add_lattice(&mut setup, Vector3::new(0.1, 0.1, 0.1), [12, 12, 10]);
    setup.particles.velocity.fill(Vector3::new(0.5, -0.25, 1.0));
    setup.run.body_force.gravity = Vector3::new(0.0, 0.0, -9.81);
    let gauge = |x: f64, axis: u32| FluidProbeKind::Gauge(Vector3::new(x, 0.2, 0.2), axis);
    let flux = |corner: [f64; 3], first: [f64; 3], second: [f64; 3]| {
        FluidProbeKind::SurfaceFlux(corner.into(), first.into(), second.into())
    };
    let kinds = [
        gauge(0.2, 2),
        gauge(0.2, 0),
        gauge(0.9, 2),
        // Within the block: 0.1 x 0.1 m across x, the other way round, and slanted with half the area in the air above.
        flux([0.2, 0.16, 0.15], [0.2, 0.26, 0.15], [0.2, 0.16, 0.25]),
        flux([0.2, 0.16, 0.15], [0.2, 0.16, 0.25], [0.2, 0.26, 0.15]),
        flux([0.2, 0.16, 0.2], [0.2, 0.26, 0.2], [0.2, 0.16, 0.4]),
        flux([0.16, 0.16, 0.2], [0.26, 0.16, 0.2], [0.21, 0.26, 0.2]),
        flux([0.8, 0.16, 0.2], [0.8, 0.26, 0.2], [0.8, 0.16, 0.4]),
    ];
    setup.probes = kinds.map(|kind| FluidProbe { name: "probe".into(), kind }).to_vec();
    let mut values = Vec::new();
    solver(setup.clone()).probes(0.0, &mut values);
    assert!((values[0] - 0.3).abs() < 1e-12 && (values[1] - 0.34).abs() < 1e-12 && values[2].is_nan());
    // The area times the speed, with the sum of V W within half a per cent of 1.
    for (value, expected) in values[3..].iter().zip([0.005, -0.005, 0.005, 0.01, 0.0]) {
        assert!((value - expected).abs() < 0.005 * 0.01, "{value}, not {expected}");
    }
    // Against gravity is down where that points up.
    setup.run.body_force.gravity.z = 9.81;
    values.clear();
    solver(setup.clone()).probes(0.0, &mut values);
    assert!((values[0] - 0.1).abs() < 1e-12);
    for kind in [
        flux([0.2; 3], [0.3; 3], [0.4; 3]),
        FluidProbeKind::WaterLevel(0.2),
        FluidProbeKind::Gauge(Vector3::zeros(), 3),
    ] {
        setup.probes = vec![FluidProbe { name: "wrong".into(), kind }];
        let errors = FluidSolver::<Spatial>::new(setup.clone()).err().unwrap();
        assert!(errors.len() == 1 && errors[0].contains("`wrong`"), "{errors:?}");
    }
}
