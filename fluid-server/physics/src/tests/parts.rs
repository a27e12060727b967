//! A fluid in parts has the bits of one fluid.

use std::ops::Range;

use nalgebra::Vector3;
use sph::coupling::exchange::StateColumns;
use sph::coupling::saved::SavedState;
use sph::coupling::solver::{Counts, Solver};
use sph::coupling::stage::Stage;
use sph::in_space;
use sph::setup::{
    AnyFluidSetup, DensityDiffusion, FluidParameters, FluidProbe, FluidProbeKind, FluidScheme, FluidSetup,
    GradientCorrection, InterfaceLaw,
};
use sph::space::{AnySpace, Plane, Spatial, Vector};

use super::coupling::{REACH, coupled, extent, solid};
use super::spatial::add_container;
use super::support::{add_lattice, disturb, empty_scene_in, solver, stage_time, try_step};
use crate::lead::in_threads;
use crate::system::packed_particle::FluidSpace;

/// Numbers of parts; with eight of them some have a few tasks, or none.
const PARTS: [usize; 4] = [2, 3, 5, 8];

/// Everything that a solver says of a run of `steps` steps of `time_step` \[s\] in which it meets `partner`, with its
/// states at the boundaries after the steps `saved`.
fn story(solver: &mut dyn Solver, steps: Range<u64>, time_step: f64, partner: &StateColumns) -> Vec<String> {
    let mut story = Vec::new();
    let mut tell = |what: String| story.push(what);
    let mut own = StateColumns::default();
    for step in steps.clone() {
        for stage in Stage::BOTH {
            let time = stage_time(step, stage, time_step);
            if let Err(divergence) = solver.begin_stage(&time) {
                tell(divergence.to_string());
                return story;
            }
            if !partner.is_empty() {
                let version = solver.interface(&extent(), REACH, &mut own);
                tell(format!(
                    "{version} {own:?} {:?} {:?}",
                    solver.covered_by(&extent(), REACH),
                    solver.extent()
                ));
            }
            solver.evaluate_own(&time);
            solver.evaluate_cross(&time, &own, partner);
            match solver.advance(&time) {
                Ok(budget) => tell(format!("{budget:?}")),
                Err(divergence) => tell(divergence.to_string()),
            }
        }
        let end = stage_time(step, Stage::Corrector, time_step);
        if let Err(divergence) = solver.end_step(&end) {
            tell(divergence.to_string());
            return story;
        }
        let counts = Counts { parts: None, ..solver.counts() };
        tell(format!("{:?} {counts:?} {:?}", solver.energies(), solver.time_step_limit()));
        if step % 5 == 4 || step + 1 == steps.end {
            let (mut values, mut saved) = (Vec::new(), SavedState::default());
            solver.probes(end.target_time(), &mut values);
            solver.save(&mut saved);
            tell(format!("{values:?} {:?}", solver.limiting_particle()));
            tell(format!("{:?}", solver.snapshot(step, end.target_time())));
            tell(format!("{saved:?}"));
        }
    }
    story
}

/// Compares two stories, and shows the first place at which they differ.
fn assert_equal(name: &str, found: &[String], expected: &[String]) {
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        if found != expected {
            let at = found.bytes().zip(expected.bytes()).position(|(a, b)| a != b).unwrap_or_default();
            let part = |text: &str| text.chars().skip(at.saturating_sub(200)).take(400).collect::<String>();
            panic!("{name}, entry {k}:\n{}\n{}", part(found), part(expected));
        }
    }
    assert_eq!(found.len(), expected.len(), "{name}");
}

/// Solvers of `setup` in one part.
fn alone(setup: &AnyFluidSetup) -> Box<dyn Solver> {
    in_space!(setup.clone(), setup => Box::new(solver(setup)))
}

/// Runs `setup` alone and in parts, and compares all that is said of it.
fn assert_same(name: &str, setup: AnyFluidSetup, steps: u64, time_step: f64, partner: &StateColumns) {
    let mut alone = alone(&setup);
    let expected = story(&mut *alone, 0..steps, time_step, partner);
    for parts in PARTS {
        let mut in_parts = in_threads(setup.clone(), parts).unwrap();
        let found = story(&mut *in_parts, 0..steps, time_step, partner);
        assert_equal(&format!("{name}, {parts} parts"), &found, &expected);
    }
}

/// Water in a corner of a tank, stirred.
fn tank<S: FluidSpace>(
    parameters: FluidParameters,
    lower: S::Vector,
    counts: S::Of<usize>,
    tank: S::Of<usize>,
    closed: S::Of<[bool; 2]>,
) -> FluidSetup<S> {
    let mut setup = empty_scene_in::<S>(parameters.particle_spacing);
    setup.parameters = parameters;
    setup.run.body_force.gravity[S::DIMENSIONS - 1] = -9.81;
    add_lattice(&mut setup, lower, counts);
    add_container(&mut setup, lower, tank, closed);
    disturb(&mut setup, 4);
    // Gently: of the noise of 1 m/s a tenth is left, and none of that of the masses.
    let mass = parameters.rest_density * S::cell_volume(parameters.particle_spacing);
    for i in 0..setup.particles.id.len() {
        setup.particles.velocity[i] = setup.particles.velocity[i] * 0.1;
        setup.particles.mass[i] = mass;
    }
    setup.probes.push(FluidProbe { name: "tank".into(), kind: FluidProbeKind::WallForce(0) });
    setup.probes.push(FluidProbe { name: "water".into(), kind: FluidProbeKind::Region(None) });
    setup
}

#[test]
fn a_dam_break_in_the_plane_has_the_same_bits_in_parts() {
    for (name, parameters) in [
        ("default", FluidParameters::DEFAULT),
        (
            "predictor-corrector",
            FluidParameters { scheme: FluidScheme::PredictorCorrector, ..FluidParameters::DEFAULT },
        ),
        ("viscous", FluidParameters { dynamic_viscosity: 1.0, ..FluidParameters::DEFAULT }),
        ("damper", FluidParameters { acoustic_damping: 0.4, ..FluidParameters::DEFAULT }),
        ("plain", FluidParameters::PLAIN),
    ] {
        let setup = plane_tank(parameters);
        assert_same(name, AnySpace::Plane(setup), 60, 2e-4, &StateColumns::default());
    }
}

/// A dam break in the plane.
fn plane_tank(parameters: FluidParameters) -> FluidSetup<Plane> {
    let closed = [[true, true], [true, false]];
    tank(settings(parameters), Vector::new(0.1, 0.1), [30, 36], [38, 40], closed)
}

/// The settings of the tests at a spacing of 0.02 m.
fn settings(parameters: FluidParameters) -> FluidParameters {
    FluidParameters { particle_spacing: 0.02, acoustic_relaxation_time: Some(1e-2), ..parameters }
}

#[test]
fn a_dam_break_in_space_has_the_same_bits_in_parts() {
    for (name, parameters) in [
        ("default", FluidParameters::DEFAULT),
        ("viscous", FluidParameters { dynamic_viscosity: 1.0, ..FluidParameters::DEFAULT }),
    ] {
        let (counts, closed) = ([16, 9, 14], [[true, true], [true, true], [true, false]]);
        let setup = tank::<Spatial>(settings(parameters), Vector3::repeat(0.1), counts, [20, 9, 16], closed);
        assert_same(name, AnySpace::Spatial(setup), 20, 2e-4, &StateColumns::default());
    }
}

#[test]
fn periodic_water_has_the_same_bits_in_parts() {
    let viscous = FluidParameters { dynamic_viscosity: 1.0, ..FluidParameters::DEFAULT };
    for periodic in [[true, true], [true, false], [false, true]] {
        let mut setup = empty_scene_in::<Plane>(0.02);
        setup.parameters = settings(viscous);
        setup.run.domain.periodic = periodic;
        add_lattice(&mut setup, Vector::zeros(), [50, 50]);
        disturb(&mut setup, 5);
        assert_same(&format!("{periodic:?}"), AnySpace::Plane(setup), 40, 1e-4, &StateColumns::default());
    }
    for periodic in [[true, false, true], [false, true, false]] {
        let mut setup = empty_scene_in::<Spatial>(0.02);
        setup.parameters = settings(viscous);
        setup.run.domain.periodic = periodic;
        setup.run.domain.upper = Vector3::repeat(0.24);
        add_lattice(&mut setup, Vector3::zeros(), [12, 12, 12]);
        disturb(&mut setup, 6);
        assert_same(&format!("{periodic:?}"), AnySpace::Spatial(setup), 12, 1e-4, &StateColumns::default());
    }
}

#[test]
fn water_with_a_partner_has_the_same_bits_in_parts() {
    for law in [InterfaceLaw::Wall, InterfaceLaw::PlainSum] {
        for parameters in [FluidParameters::DEFAULT, FluidParameters::PLAIN] {
            let mut setup = coupled(law, GradientCorrection::None, DensityDiffusion::None);
            setup.parameters = settings(parameters);
            if let Some(coupling) = &mut setup.run.coupling {
                coupling.fluid = setup.parameters;
            }
            // Around what meets the solid.
            add_lattice(&mut setup, Vector::new(0.2, 0.02), [12, 9]);
            add_lattice(&mut setup, Vector::new(0.2, 0.4), [12, 25]);
            add_lattice(&mut setup, Vector::new(0.02, 0.02), [9, 44]);
            setup.probes.push(FluidProbe { name: "inside".into(), kind: FluidProbeKind::Immersed });
            assert_same(&format!("{law:?}"), AnySpace::Plane(setup), 30, 1e-4, &StateColumns::from(&solid()));
        }
    }
}

#[test]
fn water_that_leaves_has_the_same_bits_in_parts() {
    for limit in [1_000_000, 40] {
        let mut setup = empty_scene_in::<Plane>(0.02);
        setup.parameters =
            settings(FluidParameters { lost_particle_limit: limit, ..FluidParameters::DEFAULT });
        add_lattice(&mut setup, Vector::new(0.0, 0.3), [50, 30]);
        // To the left over an open side, to the right and up through closed ones.
        setup.outflow.lower[0] = true;
        for i in 0..setup.particles.id.len() {
            let x = setup.particles.position[i] - Vector::repeat(0.5);
            setup.particles.velocity[i] = Vector::new(x.x, x.y.max(0.0)) * 12.0;
        }
        assert_same(&format!("at most {limit}"), AnySpace::Plane(setup), 60, 4e-4, &StateColumns::default());
    }
}

#[test]
fn a_saved_state_continues_in_any_number_of_parts() {
    let setup = plane_tank(FluidParameters::DEFAULT);
    let (setup, none) = (AnySpace::Plane(setup), StateColumns::default());
    let mut alone = alone(&setup);
    story(&mut *alone, 0..20, 2e-4, &none);
    let mut saved = SavedState::default();
    alone.save(&mut saved);
    let expected = story(&mut *alone, 20..40, 2e-4, &none);
    for parts in PARTS {
        let mut in_parts = in_threads(setup.clone(), parts).unwrap();
        story(&mut *in_parts, 0..7, 2e-4, &none);
        in_parts.restore(&saved).unwrap();
        assert_equal(&format!("{parts} parts"), &story(&mut *in_parts, 20..40, 2e-4, &none), &expected);
        assert!(in_parts.restore(&SavedState::default()).is_err());
        let mut again = SavedState::default();
        in_parts.restore(&saved).unwrap();
        in_parts.save(&mut again);
        assert_eq!(again, saved);
    }
}

#[test]
fn lists_that_are_given_back_are_made_again_with_the_same_bits() {
    let setup = plane_tank(FluidParameters::DEFAULT);
    let [mut kept, mut released] = [(); 2].map(|()| solver(setup.clone()));
    // Longer than the nodes of the volume keep their places.
    for step in 0..40 {
        released.workspace.release();
        try_step(&mut kept, step, 5e-5).unwrap();
        try_step(&mut released, step, 5e-5).unwrap();
        assert_eq!(released.state, kept.state, "step {step}");
    }
}

#[test]
fn parts_say_what_they_hold_and_what_they_have_done() {
    let setup = AnySpace::Plane(plane_tank(FluidParameters::DEFAULT));
    let total = alone(&setup).counts().particles;
    let mut in_parts = in_threads(setup, 3).unwrap();
    story(&mut *in_parts, 0..30, 2e-4, &StateColumns::default());
    let parts = in_parts.counts().parts.unwrap();
    assert_eq!(parts.each.iter().map(|part| part.particles).sum::<u64>(), total);
    for part in &parts.each {
        assert!(part.copies > 0 && part.computing_seconds > 0.0, "{part:?}");
        // At least the particles of a stage.
        assert!(part.copy_messages >= 60 && part.copy_bytes > part.copy_messages, "{part:?}");
    }
    // The one in the middle has copies of both others.
    let [first, middle, last] = parts.each[..] else { unreachable!("there are three") };
    assert!(middle.copies > first.copies.max(last.copies), "{parts:?}");
    assert!(middle.copy_messages > first.copy_messages.max(last.copy_messages), "{parts:?}");
    let (mean, largest) = (parts.mean_imbalance.unwrap(), parts.largest_imbalance.unwrap());
    assert!(0.0 <= mean && mean <= largest, "{mean} {largest}");
}
