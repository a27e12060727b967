//! What wall particles show to the fluid, Eq. (27)-(28).

use sph::coupling::ledger::Account;
use sph::coupling::solver::Solver;
use sph::setup::{FluidProbe, FluidProbeKind, FluidSetup, Motion, WallCondition};
use sph::space::Vector;

use super::support::{add_block, add_floor, empty_scene, evaluate, run, solver, try_step};
use crate::FluidSolver;
use crate::boundary::wall_states::mirrored;
use crate::system::packed_particle::Packed;

/// Water of uniform velocity on a floor, wide enough that its middle feels no side.
fn moving_water(condition: WallCondition) -> FluidSetup {
    let mut setup = empty_scene(0.02);
    add_block(&mut setup, Vector::new(0.2, 0.5), 20, 8);
    add_floor(&mut setup, 0.1, 0.5, 30, condition);
    setup.particles.velocity.fill(Vector::new(0.3, -0.2));
    setup
}

/// The wall particle of the first layer in the middle.
fn middle(solver: &FluidSolver) -> usize {
    let x = Vector::new(0.41, 0.49);
    (0..solver.model.walls.len())
        .find(|w| (solver.workspace.walls.field.position[*w] - x).norm() < 1e-9)
        .unwrap()
}

#[test]
fn velocities_are_mirrored_along_the_normal_or_wholly() {
    let (fluid, wall) = (Vector::new(2.0, 3.0), Vector::new(0.5, 1.0));
    // Normal y: 3 − 2·(3 − 1) = −1.
    assert_eq!(mirrored::<sph::space::Plane>(&fluid, &wall, &Vector::new(0.0, 1.0)), Vector::new(2.0, -1.0));
    assert_eq!(mirrored::<sph::space::Plane>(&fluid, &wall, &Vector::zeros()), Vector::new(-1.0, -1.0));
    // 45°: v − v_wall = (1.5, 2) becomes its mirror image (−2, −1.5).
    let normal = Vector::repeat(std::f64::consts::FRAC_1_SQRT_2);
    let turned = mirrored::<sph::space::Plane>(&fluid, &wall, &normal) - wall;
    // Round-off of n² = 1/2.
    assert!((turned - Vector::new(-2.0, -1.5)).norm() < 1e-14, "{turned}");
}

#[test]
fn walls_show_the_mirrored_mean_velocity() {
    for (condition, expected) in
        [(WallCondition::Slip, Vector::new(0.3, 0.2)), (WallCondition::NoSlip, Vector::new(-0.3, 0.2))]
    {
        let mut solver = solver(moving_water(condition));
        evaluate(&mut solver);
        let record = solver.workspace.walls.particles[middle(&solver)];
        assert!((record.velocity() - expected).norm() < 1e-14, "{condition:?}");
    }
}

#[test]
fn corner_particles_reverse_both_components() {
    let mut setup = moving_water(WallCondition::Slip);
    setup.wall_particles.normal.fill(Vector::zeros());
    let mut solver = solver(setup);
    evaluate(&mut solver);
    let record = solver.workspace.walls.particles[middle(&solver)];
    assert!((record.velocity() - Vector::new(-0.3, 0.2)).norm() < 1e-14);
}

#[test]
fn wall_pressure_continues_a_hydrostatic_field_downward() {
    let mut setup = moving_water(WallCondition::Slip);
    setup.run.body_force.gravity = Vector::new(0.0, -9.81);
    // Uniform pressure p₀: Eq. (28) adds ρ g times the Shepard-mean height above the wall particle.
    let stiffness = 1000.0 * 400.0 / 7.0;
    let density = 1000.0 * (1.0f64 + 2000.0 / stiffness).powf(1.0 / 7.0);
    setup.particles.density.fill(density);
    let mut solver = solver(setup);
    evaluate(&mut solver);
    let w = middle(&solver);
    let (mut weight, mut height) = (0.0, 0.0);
    for x in &solver.state.position {
        let d = x - solver.workspace.walls.field.position[w];
        let kernel = solver.model.kernel.value(d.norm());
        weight += kernel;
        height += kernel * d.y;
    }
    let expected = 2000.0 + density * 9.81 * height / weight;
    let record = solver.workspace.walls.particles[w];
    assert!((record.pressure() - expected).abs() < 1e-8, "{} {expected}", record.pressure());
    assert!((solver.model.equation_of_state.pressure(record.density()) - expected).abs() < 1e-6);
    assert!((record.volume() - 1000.0 * 0.02 * 0.02 / record.density()).abs() < 1e-18);
}

#[test]
fn the_known_acceleration_of_a_wall_enters_its_pressure() {
    let pressure = |acceleration: &str, gravity: f64| {
        let mut setup = moving_water(WallCondition::Slip);
        setup.run.body_force.gravity = Vector::new(0.0, gravity);
        setup.walls[0].motion = Some(Motion {
            displacement: [String::new(), format!("0.5*({acceleration})*t^2")],
            angle: String::new(),
            axis: 1.0,
            pivot: Vector::zeros(),
        });
        let mut solver = solver(setup);
        evaluate(&mut solver);
        solver.workspace.walls.particles[middle(&solver)].pressure()
    };
    // A floor pushed upward by a feels as heavy as one at rest under gravity −a.
    let (pushed, heavy) = (pressure("4", 0.0), pressure("0", -4.0));
    assert!(heavy > 10.0);
    assert!((pushed - heavy).abs() < 1e-9 * heavy, "{pushed} {heavy}");
    // In free fall together there is none.
    assert!(pressure("-4", -4.0).abs() < 1e-9);
}

#[test]
fn a_moving_wall_carries_water_that_does_not_slip() {
    let mut setup = moving_water(WallCondition::NoSlip);
    setup.particles.velocity.fill(Vector::zeros());
    setup.walls[0].motion = Some(Motion {
        displacement: ["0.25*t".into(), String::new()],
        angle: String::new(),
        axis: 1.0,
        pivot: Vector::zeros(),
    });
    let mut solver = solver(setup);
    evaluate(&mut solver);
    let record = solver.workspace.walls.particles[middle(&solver)];
    assert!((record.velocity() - Vector::new(0.5, 0.0)).norm() < 1e-14);
}

#[test]
fn water_that_turns_with_a_wall_is_at_rest_beside_it() {
    let mut setup = moving_water(WallCondition::NoSlip);
    let (pivot, rate) = (Vector::new(0.1, 0.2), 3.0);
    let carried = |x: &Vector| Vector::new(-rate * (x.y - pivot.y), rate * (x.x - pivot.x));
    setup.particles.velocity = setup.particles.position.iter().map(carried).collect();
    setup.walls[0].motion =
        Some(Motion { displacement: [String::new(), String::new()], angle: "3*t".into(), axis: 1.0, pivot });
    let mut solver = solver(setup);
    evaluate(&mut solver);
    let w = middle(&solver);
    let (record, x) = (solver.workspace.walls.particles[w], solver.workspace.walls.field.position[w]);
    // Mirrored about the wall's own velocity it would differ by 0.1 m/s.
    assert!((record.velocity() - carried(&x)).norm() < 1e-13, "{} {}", record.velocity(), carried(&x));
}

#[test]
fn released_walls_and_walls_without_fluid_do_not_act() {
    let mut setup = moving_water(WallCondition::Slip);
    setup.walls[0].release_time = Some(1.5e-4);
    let mut solver = solver(setup);
    let budgets = run(&mut solver, 3, 1e-4);
    // Half-steps at 0, 0.05, 0.1, 0.15, ... ms: the wall acts in the first three.
    for (k, budgets) in budgets.iter().enumerate() {
        assert_eq!(budgets.accounts.get(Account::Walls).force.norm() > 0.0, k < 3, "half-step {k}");
    }
    let mut setup = moving_water(WallCondition::Slip);
    setup.particles.position.iter_mut().for_each(|x| x.y += 0.2);
    let mut solver = super::support::solver(setup);
    evaluate(&mut solver);
    assert!(solver.workspace.walls.particles.iter().all(|record| record.volume() == 0.0));
}

#[test]
fn slip_does_not_drag_and_no_slip_does() {
    let drag = |condition, viscosity: f64| {
        let mut setup = moving_water(condition);
        setup.particles.velocity.fill(Vector::new(0.3, 0.0));
        setup.parameters.viscosity_a = 1.0;
        setup.parameters.dynamic_viscosity = viscosity;
        let mut solver = solver(setup);
        let budgets = try_step(&mut solver, 0, 1e-4).unwrap();
        budgets[0].accounts.get(Account::Walls).force.x
    };
    for viscosity in [0.0, 10.0] {
        let (slip, no_slip) = (drag(WallCondition::Slip, viscosity), drag(WallCondition::NoSlip, viscosity));
        assert!(no_slip < -0.5, "{no_slip}");
        // The ends of the block see the floor on one side only: round-off of a symmetric sum remains.
        assert!(slip.abs() < 1e-9 * no_slip.abs(), "{slip} {no_slip}");
    }
}

#[test]
fn the_force_on_the_floor_is_the_reaction_to_the_walls_account() {
    for viscosity in [0.0, 2.0] {
        let mut setup = moving_water(WallCondition::NoSlip);
        setup.run.body_force.gravity = Vector::new(0.0, -9.81);
        setup.parameters.dynamic_viscosity = viscosity;
        setup.probes.push(FluidProbe { name: "floor".into(), kind: FluidProbeKind::WallForce(0) });
        let mut solver = solver(setup);
        run(&mut solver, 5, 1e-4);
        let mut values = Vec::new();
        solver.probes(5e-4, &mut values);
        let budgets = try_step(&mut solver, 5, 1e-4).unwrap();
        let account = budgets[0].accounts.get(Account::Walls).force.xy();
        assert!((Vector::new(values[0], values[1]) + account).norm() < 1e-12 * account.norm());
    }
}

#[test]
fn each_of_two_walls_has_its_own_force() {
    let mut setup = empty_scene(0.02);
    add_block(&mut setup, Vector::new(0.2, 0.5), 20, 8);
    // The particles in the middle are near both.
    add_floor(&mut setup, 0.1, 0.5, 12, WallCondition::Slip);
    add_floor(&mut setup, 0.34, 0.5, 18, WallCondition::NoSlip);
    setup.run.body_force.gravity = Vector::new(0.0, -9.81);
    for wall in [1, 0] {
        setup.probes.push(FluidProbe { name: "floor".into(), kind: FluidProbeKind::WallForce(wall) });
    }
    let mut solver = solver(setup);
    run(&mut solver, 5, 1e-4);
    let mut values = Vec::new();
    solver.probes(5e-4, &mut values);
    let [right, left] = [Vector::new(values[0], values[1]), Vector::new(values[2], values[3])];
    let budgets = try_step(&mut solver, 5, 1e-4).unwrap();
    let account = budgets[0].accounts.get(Account::Walls).force.xy();
    assert!((left + right + account).norm() < 1e-12 * account.norm());
    // 7 and 13 of 20 columns.
    assert!((left.y / right.y / (7.0 / 13.0) - 1.0).abs() < 0.1, "{left} {right}");
}

#[test]
fn repulsion_holds_a_particle_that_the_pair_forces_let_through() {
    // One particle over a floor, pressed in between two wall particles as by a jet: 5 km/s² for 4 ms.
    let depth_after = |repulsion: f64| {
        let mut setup = empty_scene(0.02);
        setup.parameters.wall_repulsion = repulsion;
        setup.parameters.lost_particle_limit = 1;
        add_floor(&mut setup, 0.1, 0.5, 30, WallCondition::Slip);
        super::support::add_particle(&mut setup, Vector::new(0.4, 0.505), Vector::zeros());
        setup.run.body_force.gravity = Vector::new(0.0, -5000.0);
        setup.parameters.density_diffusion = sph::setup::DensityDiffusion::None;
        let mut solver = solver(setup);
        let mut deepest = f64::INFINITY;
        for step in 0..400 {
            let budgets = try_step(&mut solver, step, 1e-5).unwrap();
            assert!(
                budgets
                    .iter()
                    .all(|budgets| budgets.momentum_residual().max(budgets.angular_residual()) < 1e-12)
            );
            deepest = solver.state.position.iter().map(|x| x.y).fold(deepest, f64::min);
        }
        (deepest - 0.5) / 0.02
    };
    let (without, with) = (depth_after(0.0), depth_after(1.0));
    assert!(with > -0.25, "held half-way to the first layer: {with} spacings");
    assert!(without < with, "{without} {with}");
}

#[test]
fn repulsion_leaves_water_at_rest_on_its_lattice_alone_and_is_accounted_for() {
    let account = |repulsion: f64, height: f64| {
        let mut setup = moving_water(WallCondition::Slip);
        setup.parameters.wall_repulsion = repulsion;
        setup.particles.velocity.fill(Vector::zeros());
        setup.particles.position.iter_mut().for_each(|x| x.y += height);
        setup.probes.push(FluidProbe { name: "floor".into(), kind: FluidProbeKind::WallForce(0) });
        let mut solver = solver(setup);
        let mut values = Vec::new();
        solver.probes(0.0, &mut values);
        let budgets = try_step(&mut solver, 0, 1e-5).unwrap();
        (budgets[0].accounts.get(Account::Walls).force.y, values[1])
    };
    assert_eq!(account(1.0, 0.0), (0.0, 0.0));
    // Half a spacing too low: z = 0.5 Δx, below 0.6 Δx: 20 particles of mass m feel k (c₀/Δx)² 0.1 Δx.
    let (force, reaction) = account(0.5, -0.01);
    let expected = 20.0 * 1000.0 * 4e-4 * 0.5 * (20.0f64 / 0.02).powi(2) * 0.1 * 0.02;
    assert!((force / expected - 1.0).abs() < 1e-9, "{force} {expected}");
    assert!((reaction / expected + 1.0).abs() < 1e-9);
}
