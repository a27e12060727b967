//! Divergence, lost particles and outflow.

use sph::coupling::exchange::StateColumns;
use sph::coupling::ledger::EnergyAccount;
use sph::coupling::ledger::{Account, LedgerVector, StageBudget};
use sph::coupling::solver::Solver;
use sph::coupling::stage::Stage;
use sph::setup::{FluidSetup, Motion, WallCondition};
use sph::space::Vector;

use super::support::{add_block, add_floor, add_particle, empty_scene, run, solver, stage_time, try_step};
use crate::report::probes;

/// A particle at rest, and one below it that falls at `speed` \[m/s\].
fn falling(speed: f64) -> FluidSetup {
    let mut setup = empty_scene(0.02);
    add_particle(&mut setup, Vector::new(0.5, 0.8), Vector::zeros());
    add_particle(&mut setup, Vector::new(0.5, 0.52), Vector::new(0.0, -speed));
    setup
}

#[test]
fn torn_water_ends_a_run_unless_it_cavitates() {
    let torn = |tension_limit: Option<f64>| {
        let mut setup = empty_scene(0.02);
        setup.parameters.tension_limit = tension_limit;
        add_block(&mut setup, Vector::new(0.4, 0.45), 10, 5);
        // The energy of the motion, 36 J/kg on average, is above what Eq. (3) takes up until 0.7 ρ₀, 16 J/kg.
        for (x, v) in setup.particles.position.iter().zip(&mut setup.particles.velocity) {
            v.y = 15.0 * (x.y - 0.5) / 0.05;
        }
        let mut solver = solver(setup);
        let broken = (0..80).find_map(|step| try_step(&mut solver, step, 1e-4).err());
        (broken, solver)
    };
    let (broken, _) = torn(None);
    let broken = broken.unwrap();
    assert_eq!(broken.quantity, "density [kg/m³]");
    assert!(broken.to_string().contains("tension_limit_pa"), "{broken}");
    let (broken, mut solver) = torn(Some(5e3));
    assert!(broken.is_none(), "{broken:?}");
    let fields = solver.snapshot(80, 8e-3);
    let lowest =
        |name: &str| fields.field(name).unwrap().values.iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(lowest("pressure"), -5e3);
    assert!(lowest("density") < 700.0, "{}", lowest("density"));
}

#[test]
fn a_particle_that_breaks_a_limit_is_named() {
    type Spoil = fn(&mut FluidSetup);
    let cases: [(&str, Spoil); 4] = [
        ("speed [m/s]", |s| s.particles.velocity[1].x = 25.0),
        ("density [kg/m³]", |s| s.particles.density[1] = 1600.0),
        ("density [kg/m³]", |s| s.particles.density[1] = 600.0),
        ("position [m]", |s| s.particles.position[1].y = f64::NAN),
    ];
    for (quantity, spoil) in cases {
        let mut solver = solver(falling(0.0));
        let mut spoiled = falling(0.0);
        spoil(&mut spoiled);
        solver.state.position = spoiled.particles.position;
        solver.state.velocity = spoiled.particles.velocity;
        solver.state.density = spoiled.particles.density;
        let divergence = try_step(&mut solver, 7, 1e-4).unwrap_err();
        assert_eq!(divergence.quantity, quantity);
        assert_eq!(divergence.particle, Some(1));
        assert_eq!(divergence.at.step, 7);
        assert!(divergence.position.is_some());
        assert!(divergence.to_string().contains("time step"), "{divergence}");
        // A diverged state can still be written.
        assert_eq!(solver.snapshot(7, 0.0).id.len(), 2);
    }
}

#[test]
fn a_set_up_that_can_not_run_is_refused_with_all_reasons() {
    let mut setup = falling(0.0);
    setup.parameters.sound_speed = 0.0;
    setup.particles.region[0] = 3;
    setup.particles.mass[1] = -1.0;
    setup.run.domain.periodic[0] = true;
    setup.run.domain.upper.x = 0.05;
    let errors = crate::FluidSolver::new(setup).unwrap_err();
    assert_eq!(errors.len(), 4, "{errors:#?}");
    let mut setup = falling(0.0);
    add_floor(&mut setup, 0.0, 0.3, 5, WallCondition::Slip);
    setup.walls[0].motion = Some(Motion {
        displacement: ["t +".into(), "0".into()],
        angle: "0".into(),
        axis: 1.0,
        pivot: Vector::zeros(),
    });
    setup.run.body_force.expressions = Some(["z".into(), "0".into()]);
    let errors = crate::FluidSolver::new(setup).unwrap_err();
    assert_eq!(errors.len(), 2, "{errors:#?}");
    assert!(errors[0].contains("floor"));
}

/// Runs `setup` until a particle has left; returns the budgets of the step after.
fn until_departure(setup: FluidSetup) -> (crate::FluidSolver, [StageBudget; 2]) {
    let mut solver = solver(setup);
    let mut step = 0;
    while solver.counts().particles == 2 {
        assert!(step < 2000, "nothing left");
        try_step(&mut solver, step, 1e-4).unwrap();
        step += 1;
    }
    let budgets = try_step(&mut solver, step, 1e-4).unwrap();
    (solver, budgets)
}

#[test]
fn energies_are_those_of_the_particles_that_are_left() {
    let mut setup = falling(10.0);
    setup.outflow.lower[1] = true;
    let mut solver = solver(setup);
    for step in 0..2000 {
        try_step(&mut solver, step, 1e-4).unwrap();
        let (found, summed) = (solver.energies(), probes::energies(&solver.model, &solver.state));
        for (found, summed) in [
            (found.value(EnergyAccount::Kinetic), summed.kinetic),
            (found.value(EnergyAccount::Potential), summed.potential),
            (found.value(EnergyAccount::Compression), summed.internal),
        ] {
            // Two terms at most, in either order.
            assert!((found - summed).abs() <= 1e-15 * summed.abs(), "step {step}: {found} {summed}");
        }
        if solver.counts().particles == 1 {
            return;
        }
    }
    panic!("nothing left");
}

#[test]
fn leaving_through_an_open_side_is_outflow_and_accounted_for_in_the_next_step() {
    let mut setup = falling(10.0);
    setup.outflow.lower[1] = true;
    let momentum = setup.particles.velocity[1] * setup.particles.mass[1];
    let (solver, budgets) = until_departure(setup);
    assert_eq!((solver.counts().outflow, solver.counts().escaped), (1, 0));
    assert_eq!(solver.state.id, [0]);
    for stage in &budgets {
        let accounted = stage.accounts.get(Account::Removed).force.xy() * stage.duration;
        assert!((accounted + momentum).norm() < 1e-14);
        assert!((stage.momentum_change.xy() + momentum).norm() < 1e-14);
        assert!(stage.momentum_residual().max(stage.angular_residual()) < 1e-12);
    }
    let mut solver = solver;
    let later = run(&mut solver, 1, 1e-4);
    assert_eq!(later[0].accounts.get(Account::Removed).force, LedgerVector::zeros());
}

#[test]
fn leaving_through_a_closed_side_is_a_loss() {
    let setup = falling(10.0);
    let mut solver = solver(setup.clone());
    let divergence = (0..2000).find_map(|step| try_step(&mut solver, step, 1e-4).err()).unwrap();
    assert_eq!(divergence.particle, Some(1));
    let y = divergence.position.unwrap()[1];
    assert!((-0.02..-0.01).contains(&y), "lost half a spacing outside, at {y}");
    assert!(divergence.quantity.contains("lost"));

    let mut tolerant = setup;
    tolerant.parameters.lost_particle_limit = 1;
    let (solver, budgets) = until_departure(tolerant);
    assert_eq!((solver.counts().outflow, solver.counts().escaped), (0, 1));
    assert!(
        budgets.iter().all(|budgets| budgets.momentum_residual().max(budgets.angular_residual()) < 1e-12)
    );
}

/// Lets particle 1 end a step of 1 ms at `end` instead of where it went; says whether it counts as lost.
fn lost_after(setup: FluidSetup, end: Vector) -> bool {
    let mut solver = solver(setup);
    let time = stage_time(0, Stage::Predictor, 1e-3);
    solver.begin_stage(&time).unwrap();
    let none = StateColumns::default();
    solver.evaluate_own(&time);
    solver.evaluate_cross(&time, &none, &none);
    solver.advance(&time).unwrap();
    let i = solver.state.id.iter().position(|id| *id == 1).unwrap();
    solver.state.position[i] = end;
    match solver.end_step(&stage_time(0, Stage::Corrector, 1e-3)) {
        Ok(()) => false,
        Err(divergence) => {
            assert_eq!(divergence.particle, Some(1));
            assert_eq!(divergence.position, Some(vec![end.x, end.y]));
            true
        }
    }
}

#[test]
fn a_particle_that_passes_the_first_layer_of_a_wall_is_lost() {
    // Floor at 0.4 m from x = 0.2 to 0.8 m: the first layer lies at 0.39 m.
    let mut setup = falling(0.0);
    add_floor(&mut setup, 0.2, 0.4, 30, WallCondition::Slip);
    setup.particles.position[1] = Vector::new(0.5, 0.392);
    assert!(!lost_after(setup.clone(), Vector::new(0.5, 0.3901)), "in the face, but not through the layer");
    assert!(lost_after(setup.clone(), Vector::new(0.5, 0.3899)), "between two wall particles");
    assert!(lost_after(setup.clone(), Vector::new(0.493, 0.389)));

    let mut beside = setup.clone();
    beside.particles.position[1].x = 0.805;
    assert!(!lost_after(beside, Vector::new(0.805, 0.388)), "past the end of the floor");

    let mut from_behind = setup.clone();
    from_behind.particles.position[1].y = 0.389;
    assert!(!lost_after(from_behind.clone(), Vector::new(0.5, 0.388)), "was behind the layer before");

    let mut released = setup.clone();
    released.walls[0].release_time = Some(0.0);
    assert!(!lost_after(released, Vector::new(0.5, 0.3899)));

    let mut corner = setup.clone();
    for w in 0..setup.wall_particles.wall.len() {
        if (setup.wall_particles.position[w].x - 0.49).abs() < 1e-9 {
            corner.wall_particles.normal[w] = Vector::zeros();
        }
    }
    assert!(
        lost_after(corner, Vector::new(0.493, 0.389)),
        "where no normal is given, that of the wall around"
    );

    // A floor that rises by 4 mm overtakes a particle at rest.
    let mut rising = setup;
    rising.walls[0].motion = Some(Motion {
        displacement: [String::new(), "4*t".into()],
        angle: String::new(),
        axis: 1.0,
        pivot: Vector::zeros(),
    });
    assert!(lost_after(rising, Vector::new(0.5, 0.392)));
}

#[test]
fn passing_above_a_rim_is_no_loss() {
    // A wall 0.1 m high with its front to the left; the particle flies over it.
    let mut setup = falling(0.0);
    setup.walls.push(sph::setup::WallSetup {
        name: "dyke".into(),
        condition: WallCondition::Slip,
        motion: None,
        release_time: None,
    });
    for row in 0..5 {
        for layer in 0..3 {
            setup.wall_particles.wall.push(0);
            setup
                .wall_particles
                .position
                .push(Vector::new(0.61 + 0.02 * f64::from(layer), 0.41 + 0.02 * f64::from(row)));
            setup.wall_particles.normal.push(Vector::new(-1.0, 0.0));
        }
    }
    setup.particles.position[1] = Vector::new(0.5, 0.515);
    setup.particles.velocity[1] = Vector::new(10.0, 0.0);
    let mut solver = solver(setup);
    run(&mut solver, 250, 1e-4);
    let i = solver.state.id.iter().position(|id| *id == 1).unwrap();
    assert!(solver.state.position[i].x > 0.7);
    assert_eq!(solver.counts().escaped, 0);
}
