//! A scene that is mirrored, or whose axes are exchanged, gives the same motion mirrored or exchanged.

use sph::setup::{FluidParameters, FluidScheme, FluidSetup, WallCondition};
use sph::space::domain::Domain;
use sph::space::tensors::SpaceVector;
use sph::space::{Plane, Space, Spatial};

use super::invariance::by_id;
use super::spatial::add_container;
use super::support::{Noise, add_lattice, empty_scene_in, run, solver};
use crate::system::packed_particle::FluidSpace;

const SPACING: f64 = 0.02;
const STEPS: u64 = 40;

/// A map of the unit box onto itself: axis k of the image is axis `from[k]`, backward where `mirrored[k]`.
#[derive(Clone, Copy, Debug)]
struct Turn<S: Space> {
    from: S::Of<usize>,
    mirrored: S::Of<bool>,
}

impl<S: Space> Turn<S> {
    /// The image of a direction.
    fn direction(&self, v: &S::Vector) -> S::Vector {
        let mut image = S::Vector::zeros();
        for axis in 0..S::DIMENSIONS {
            image[axis] = if self.mirrored[axis] { -v[self.from[axis]] } else { v[self.from[axis]] };
        }
        image
    }

    /// The image of a place.
    fn place(&self, x: &S::Vector) -> S::Vector {
        let middle = S::Vector::repeat(0.5);
        middle + self.direction(&(*x - middle))
    }

    /// The image of a scene in the unit box.
    fn scene(&self, setup: &FluidSetup<S>) -> FluidSetup<S> {
        let mut image = setup.clone();
        let Domain { periodic, .. } = setup.run.domain;
        image.run.domain.periodic = S::axes(|axis| periodic[self.from[axis]]);
        image.run.body_force.gravity = self.direction(&setup.run.body_force.gravity);
        for x in image.particles.position.iter_mut().chain(&mut image.wall_particles.position) {
            *x = self.place(x);
        }
        for v in image.particles.velocity.iter_mut().chain(&mut image.wall_particles.normal) {
            *v = self.direction(v);
        }
        image
    }
}

/// Disordered water that moves in the corner of a tank under gravity, which is along no axis; the tank is open on top and at one
/// side, where a gap is left to the wall.
fn splash<S: Space>(scheme: FluidScheme, condition: WallCondition) -> FluidSetup<S> {
    let mut setup = empty_scene_in::<S>(SPACING);
    setup.parameters = FluidParameters {
        particle_spacing: SPACING,
        scheme,
        sound_speed: 20.0,
        dynamic_viscosity: 0.5,
        // Its nodes stand where they are, so that what they read depends on where the water lies among them.
        volume_correction: 0.0,
        acoustic_relaxation_time: Some(0.01),
        ..FluidParameters::DEFAULT
    };
    let lower = S::Vector::repeat(0.3);
    let mut closed = S::splat([true; 2]);
    closed[0] = [true, false];
    closed[1] = [true, false];
    add_container(&mut setup, lower, S::splat(9), closed);
    setup.walls[0].condition = condition;
    let counts = S::axes(|axis| [7, 6, 9][axis]);
    add_lattice(&mut setup, lower, counts);
    let mut noise = Noise(7);
    for (x, v) in setup.particles.position.iter_mut().zip(&mut setup.particles.velocity) {
        *x += noise.vector_in::<S>() * (0.1 * SPACING);
        *v = noise.vector_in::<S>();
    }
    for (axis, gravity) in [-3.0, -9.0, 1.5].into_iter().enumerate().take(S::DIMENSIONS) {
        setup.run.body_force.gravity[axis] = gravity;
    }
    setup
}

/// Position, velocity and density of each particle by id.
fn after<S: FluidSpace>(setup: FluidSetup<S>) -> Vec<(S::Vector, S::Vector, f64)> {
    let mut solver = solver(setup);
    // 0.6 of the limit.
    run(&mut solver, STEPS, 5e-4);
    by_id(&solver)
}

fn motion_turns_with_the_scene<S: FluidSpace>(turns: &[Turn<S>]) {
    for scheme in [FluidScheme::Leapfrog, FluidScheme::PredictorCorrector] {
        for condition in [WallCondition::Slip, WallCondition::NoSlip] {
            let setup = splash::<S>(scheme, condition);
            let original = after(setup.clone());
            for turn in turns {
                let (mut moved, mut error) = (0.0_f64, 0.0_f64);
                for (k, (was, is)) in original.iter().zip(&after(turn.scene(&setup))).enumerate() {
                    moved = moved.max((was.0 - setup.particles.position[k]).norm() / SPACING);
                    error = error
                        .max((turn.place(&was.0) - is.0).norm() / SPACING)
                        .max((turn.direction(&was.1) - is.1).norm())
                        .max((was.2 / is.2 - 1.0).abs());
                }
                assert!(moved > 0.5, "{moved}");
                // Sums round in another order.
                assert!(error < 1e-9, "{scheme:?} {condition:?} {turn:?}: {error}");
            }
        }
    }
}

#[test]
fn motion_turns_with_the_scene_in_the_plane() {
    motion_turns_with_the_scene::<Plane>(&[
        Turn { from: [0, 1], mirrored: [true, false] },
        Turn { from: [0, 1], mirrored: [false, true] },
        Turn { from: [1, 0], mirrored: [false, false] },
    ]);
}

#[test]
fn motion_turns_with_the_scene_in_space() {
    motion_turns_with_the_scene::<Spatial>(&[
        Turn { from: [0, 1, 2], mirrored: [true, false, false] },
        Turn { from: [0, 1, 2], mirrored: [false, true, false] },
        Turn { from: [0, 1, 2], mirrored: [false, false, true] },
        Turn { from: [1, 2, 0], mirrored: [false, false, false] },
    ]);
}
