//! Probes, energies, snapshots and step limits.

use sph::coupling::driver::{Command, Event, Link};
use sph::coupling::ledger::EnergyAccount;
use sph::coupling::solver::Solver;
use sph::setup::{FluidProbe, FluidProbeKind, FluidScheme, StepPolicy, WallCondition};
use sph::space::Vector;

use super::support::{add_block, add_floor, add_particle, dam_break, empty_scene, run, solver};

fn probe(kind: FluidProbeKind) -> FluidProbe {
    FluidProbe { name: "probe".into(), kind }
}

#[test]
fn front_and_level_follow_the_connected_fluid_only() {
    let mut setup = empty_scene(0.02);
    add_block(&mut setup, Vector::new(0.1, 0.1), 20, 10);
    // A drop that flies ahead and above.
    add_particle(&mut setup, Vector::new(0.9, 0.8), Vector::zeros());
    add_particle(&mut setup, Vector::new(0.21, 0.8), Vector::zeros());
    setup.probes = vec![
        probe(FluidProbeKind::Front),
        probe(FluidProbeKind::WaterLevel(0.2)),
        probe(FluidProbeKind::WaterLevel(0.7)),
    ];
    let mut solver = solver(setup);
    let mut values = Vec::new();
    solver.probes(0.0, &mut values);
    // 199th of 200 particles by x: in the last column, half a spacing before 0.5 m.
    assert!((values[0] - 0.49).abs() < 1e-12);
    // The top row's centres are at 0.29 m.
    assert!((values[1] - 0.3).abs() < 1e-12);
    assert!(values[2].is_nan());
}

#[test]
fn a_point_probe_follows_the_body_force_to_faces_and_corners_and_is_zero_where_dry() {
    let mut setup = empty_scene(0.02);
    // Faces at 0.1 and 0.5 m, 0.1 and 0.3 m, on a floor.
    add_block(&mut setup, Vector::new(0.1, 0.1), 20, 10);
    add_floor(&mut setup, 0.04, 0.1, 26, WallCondition::Slip);
    setup.particles.velocity.fill(Vector::new(0.5, -0.25));
    setup.run.body_force.gravity = Vector::new(0.0, -10.0);
    setup.run.body_force.expressions = Some(["2*t".into(), "0".into()]);
    let time = 1.5;
    let force = Vector::new(3.0, -10.0);
    // Water so stiff that its density is that at rest within 1e-7; the mean takes it to be uniform.
    setup.parameters.sound_speed = 1e4;
    let places = [(0.3, 0.2), (0.3, 0.1), (0.1, 0.1), (0.1, 0.2)].map(|(x, y)| Vector::new(x, y));
    // Without water, and a spacing and a half beside it.
    let dry = [Vector::new(0.8, 0.8), Vector::new(0.07, 0.2)];
    setup.probes = places.iter().chain(&dry).map(|x| probe(FluidProbeKind::Point(*x))).collect();
    let pressure = |x: &Vector| 1000.0 * force.dot(&(x - Vector::new(0.1, 0.3)));
    let equation_of_state = solver(setup.clone()).model.equation_of_state;
    let particles = &mut setup.particles;
    particles.density = particles.position.iter().map(|x| equation_of_state.density(pressure(x))).collect();
    let mut values = Vec::new();
    solver(setup).probes(time, &mut values);
    for (place, row) in places.iter().zip(values.chunks_exact(3)) {
        assert!((row[0] / pressure(place) - 1.0).abs() < 1e-6, "{row:?}");
        // A uniform velocity is its own mean.
        assert!((Vector::new(row[1], row[2]) - Vector::new(0.5, -0.25)).norm() < 1e-12, "{row:?}");
    }
    assert_eq!(values[12..15], [0.0; 3]);
    let beside = values[15] / pressure(&dry[1]);
    assert!((0.0..0.05).contains(&beside), "{beside}");
}

#[test]
fn a_flow_rate_is_the_speed_times_the_wetted_length() {
    let mut setup = empty_scene(0.02);
    add_block(&mut setup, Vector::new(0.1, 0.1), 20, 20);
    setup.particles.velocity.fill(Vector::new(0.5, -0.25));
    let through =
        |x: [f64; 4]| probe(FluidProbeKind::FlowRate(Vector::new(x[0], x[1]), Vector::new(x[2], x[3])));
    setup.probes = vec![
        through([0.3, 0.2, 0.3, 0.4]),
        through([0.3, 0.4, 0.3, 0.2]),
        through([0.2, 0.3, 0.4, 0.3]),
        through([0.7, 0.2, 0.7, 0.4]),
        // From within, through the surface at 0.5 m, and as far out.
        through([0.3, 0.4, 0.3, 0.6]),
    ];
    let mut values = Vec::new();
    solver(setup).probes(0.0, &mut values);
    // U L with the sum of V W within 0.5 % of 1; to the right of the way is +x when going up, -y when going right.
    for (value, expected) in values.iter().zip([0.1, -0.1, 0.05, 0.0, 0.05]) {
        assert!((value - expected).abs() < 0.005 * 0.1, "{value}, not {expected}");
    }
    assert_eq!(values[3], 0.0);
}

#[test]
fn region_sums_of_a_spinning_block() {
    let mut setup = empty_scene(0.02);
    add_block(&mut setup, Vector::new(0.4, 0.4), 10, 10);
    setup.regions.push("other".into());
    add_particle(&mut setup, Vector::new(0.9, 0.9), Vector::new(1.0, 0.0));
    setup.particles.region[100] = 1;
    setup.run.body_force.gravity = Vector::new(0.0, -10.0);
    let omega = 2.0;
    for i in 0..100 {
        let x = setup.particles.position[i] - Vector::new(0.5, 0.5);
        setup.particles.velocity[i] = Vector::new(-omega * x.y, omega * x.x) + Vector::new(3.0, 0.0);
    }
    setup.probes = vec![
        probe(FluidProbeKind::Region(Some(0))),
        probe(FluidProbeKind::Region(Some(1))),
        probe(FluidProbeKind::Region(None)),
    ];
    let mut solver = solver(setup);
    let mut values = Vec::new();
    solver.probes(0.0, &mut values);
    let close = |found: f64, expected: f64| {
        assert!((found - expected).abs() < 1e-10 * expected.abs().max(1.0), "{found} against {expected}");
    };
    // A lattice square of edge 0.2 m, 10 across: Σ m d²/M = (L²/12)(1 − 1/n²) per axis.
    let spread = 0.04 / 12.0 * 0.99;
    let mass = 40.0;
    let expected = [
        mass,
        mass * 3.0,
        0.0,
        mass * omega * 2.0 * spread,
        0.5 * mass * (9.0 + omega * omega * 2.0 * spread),
        mass * 10.0 * 0.5,
        0.0,
        0.5,
        0.5,
        spread,
        spread,
        0.0,
    ];
    for (found, expected) in values.iter().zip(expected) {
        close(*found, expected);
    }
    close(values[12], 0.4);
    // One particle at (0.4, 0.4) from the centre of the domain with v = (1, 0): −0.4 m.
    close(values[15], -0.16);
    close(values[24], 40.4);
    let energies = solver.energies();
    close(energies.value(EnergyAccount::Kinetic), values[28]);
    close(energies.value(EnergyAccount::Potential), values[29]);
}

#[test]
fn energy_is_not_made() {
    let mut solver = solver(dam_break());
    let total = |solver: &crate::FluidSolver| {
        let e = solver.energies();
        e.value(EnergyAccount::Kinetic)
            + e.value(EnergyAccount::Potential)
            + e.value(EnergyAccount::Compression)
    };
    let start = total(&solver);
    let mut lowest = start;
    for step in 0..300 {
        super::support::try_step(&mut solver, step, 4e-4).unwrap();
        let now = total(&solver);
        // Round-off and the pressure-less start aside, the total may only fall.
        assert!(now < lowest + 2e-3 * start, "step {step}: {now} after {lowest}");
        lowest = lowest.min(now);
    }
    assert!(lowest < start && lowest > 0.7 * start, "{lowest} of {start}");
}

#[test]
fn outputs_that_are_asked_for_often_are_those_of_a_run_that_is_asked_once() {
    let outputs = |scheme: FluidScheme, each_boundary: bool| {
        let mut setup = dam_break();
        setup.parameters.scheme = scheme;
        setup.probes = vec![probe(FluidProbeKind::WallForce(0))];
        let mut solver = solver(setup);
        let mut values = Vec::new();
        // Long enough for new lists.
        for step in 0..60 {
            if each_boundary {
                let time = step as f64 * 4e-4;
                solver.probes(time, &mut values);
                drop(solver.snapshot(step, time));
            }
            super::support::try_step(&mut solver, step, 4e-4).unwrap();
        }
        values.clear();
        solver.probes(24e-3, &mut values);
        (solver.state.list_builds, values, solver.snapshot(60, 24e-3).fields)
    };
    for scheme in [FluidScheme::PredictorCorrector, FluidScheme::Leapfrog] {
        let (asked, once) = (outputs(scheme, true), outputs(scheme, false));
        assert!(once.0 > 2 && once.1[1] < -100.0, "the water weighs on the floor: {:?}", (once.0, once.1));
        assert_eq!(asked, once);
    }
}

#[test]
fn the_next_predictor_keeps_the_evaluation_of_an_output() {
    let change_of_density = |time: f64| {
        let mut setup = dam_break();
        setup.parameters.scheme = FluidScheme::Leapfrog;
        setup.probes = vec![probe(FluidProbeKind::WallForce(0))];
        let mut solver = solver(setup);
        run(&mut solver, 5, 4e-4);
        solver.probes(time, &mut Vec::new());
        // Behind the back of the solver: an evaluation would replace it.
        solver.workspace.rates.iter_mut().for_each(|rates| rates.density = 1e5);
        let before = solver.state.density.clone();
        super::support::try_step(&mut solver, 5, 4e-4).unwrap();
        let changes = solver.state.density.iter().zip(&before).map(|(after, before)| (after - before).abs());
        changes.fold(0.0, f64::max)
    };
    // 20 kg/m³ in half a step. Of another time the evaluation is not that of the step's start.
    assert!(change_of_density(2e-3) > 10.0);
    assert!(change_of_density(2.1e-3) < 5.0);
}

#[test]
fn outputs_of_one_boundary_share_one_evaluation() {
    let mut setup = dam_break();
    setup.probes = vec![probe(FluidProbeKind::WallForce(0))];
    let mut solver = solver(setup);
    run(&mut solver, 5, 4e-4);
    let load = |solver: &mut crate::FluidSolver, time: f64| {
        let mut values = Vec::new();
        solver.probes(time, &mut values);
        values[1]
    };
    let first = load(&mut solver, 2e-3);
    // Behind the back of the solver: an evaluation would see it.
    solver.state.density.iter_mut().for_each(|density| *density *= 1.01);
    let walls =
        |solver: &mut crate::FluidSolver| solver.snapshot(5, 2e-3).field("pressure").unwrap().values.clone();
    let shared = walls(&mut solver);
    assert_eq!(load(&mut solver, 2e-3), first);
    // Another time is evaluated for itself, and another state too.
    assert!(load(&mut solver, 3e-3) < 1.2 * first);
    let fluid = solver.state.len();
    assert_ne!(walls(&mut solver)[fluid..], shared[fluid..]);
    let before = load(&mut solver, 2e-3);
    super::support::try_step(&mut solver, 5, 4e-4).unwrap();
    assert_ne!(load(&mut solver, 2e-3), before);
}

#[test]
fn an_evaluation_apart_from_the_run_is_that_within_it() {
    let mut setup = dam_break();
    setup.probes = vec![probe(FluidProbeKind::WallForce(0))];
    let mut solver = solver(setup);
    run(&mut solver, 20, 4e-4);
    let mut within = Vec::new();
    solver.probes(8e-3, &mut within);
    // Without an origin the lists hold for no state.
    solver.state.list_origin = None;
    let mut apart = Vec::new();
    solver.probes(8.0000001e-3, &mut apart);
    assert!(within[1] < -100.0, "{within:?}");
    for (a, b) in within.iter().zip(&apart) {
        // Sums in another order.
        assert!((a - b).abs() < 1e-9 * within[1].abs(), "{within:?} against {apart:?}");
    }
}

#[test]
fn a_snapshot_lists_fluid_then_walls() {
    let mut solver = solver(dam_break());
    run(&mut solver, 20, 4e-4);
    let snapshot = solver.snapshot(20, 8e-3);
    let (fluid, walls) = (solver.state.len(), solver.model.walls.len());
    assert_eq!(snapshot.id.len(), fluid + walls);
    assert!(snapshot.id.is_sorted_by(|a, b| a < b), "ids ascend and walls come last");
    assert_eq!(snapshot.group_names, ["water", "floor"]);
    assert_eq!(snapshot.group[fluid - 1..=fluid], [0, 1]);
    for (name, components) in [("position", 2), ("velocity", 2), ("density", 1), ("pressure", 1), ("mass", 1)]
    {
        let field = snapshot.field(name).unwrap();
        assert_eq!((field.components, field.values.len()), (components, components * (fluid + walls)));
    }
    let pressure = &snapshot.field("pressure").unwrap().values;
    assert!(pressure[fluid..].iter().any(|p| *p > 100.0), "the floor below the column carries pressure");
    let i = solver.state.id.iter().position(|id| *id == 77).unwrap();
    let x = &snapshot.field("position").unwrap().values[154..156];
    assert_eq!(x, solver.state.position[i].as_slice());
}

#[test]
fn the_step_limit_is_the_smallest_of_three() {
    let mut setup = empty_scene(0.02);
    add_block(&mut setup, Vector::new(0.4, 0.4), 3, 3);
    setup.particles.velocity[4].x = 4.0;
    let h = 0.024;
    assert!((solver(setup.clone()).time_step_limit() - 0.6 * h / 24.0).abs() < 1e-15);
    let mut heavy = setup.clone();
    heavy.run.body_force.gravity.y = -1e5;
    assert!((solver(heavy).time_step_limit() - 0.25 * (h / 1e5f64).sqrt()).abs() < 1e-15);
    setup.parameters.dynamic_viscosity = 1000.0;
    assert!((solver(setup).time_step_limit() - 0.125 * h * h).abs() < 1e-15);
}

#[test]
fn the_driver_runs_a_fluid_without_partner() {
    let mut setup = dam_break();
    setup.run.time.end_time = 0.02;
    setup.run.time.step = StepPolicy::Adaptive { factor: 0.5, maximum: 1e-3, growth: 1.1, exact: None };
    setup.probes = vec![probe(FluidProbeKind::Front)];
    let run_setup = setup.run.clone();
    let mut solver = solver(setup);
    let link = Link {
        partner_extent: solver.extent().clone(),
        first_limit: solver.time_step_limit(),
        resume: None,
        partner_particles: None,
    };
    let (sender, commands) = std::sync::mpsc::channel();
    sender.send(Command::GrantThrough(1_000_000)).unwrap();
    let mut events = Vec::new();
    sph::coupling::driver::run(&mut solver, &run_setup.plan(), &link, None, &commands, &mut |event| {
        events.push(event)
    });
    let steps = events.iter().filter(|event| matches!(event, Event::Step(_))).count();
    // 0.5·h/c₀ = 0.6 ms: at least 33 steps.
    assert!((33..80).contains(&steps), "{steps}");
    let Some(Event::Finished(report)) = events.last() else { panic!("{:?}", events.last()) };
    assert!(report.reached_end && report.counts.particles == 200 && report.counts.escaped == 0);
}
