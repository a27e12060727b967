//! Walls that the solids are in contact with.

use sph::coupling::stage::StageTime;
use sph::prescribed::motion::RigidMotion;
use sph::setup::{SolidSetup, WallSetup};
use sph::space::tensors::SpaceVector;

use crate::boundary::supports::acts;
use crate::neighbours::lists::WallPlaces;
use crate::space::SolidSpace;

/// Constant facts of all walls.
pub struct Walls<S: SolidSpace> {
    /// Motion and release of each wall.
    pub walls: Vec<Wall<S>>,
    /// Index of the wall of each wall particle.
    pub wall_of: Vec<u32>,
    /// Positions at the start \[m\].
    pub start: Vec<S::Vector>,
    /// Indices of the particles of walls with a motion.
    moving: Vec<usize>,
}

/// Constant facts of one wall.
pub struct Wall<S: SolidSpace> {
    /// Prescribed motion; `None` for a wall at rest.
    pub motion: Option<RigidMotion<S>>,
    /// Time from which it no longer acts \[s\].
    pub release_time: f64,
    /// Indices of its particles.
    pub particles: Vec<usize>,
}

/// Wall particles at one stage.
#[derive(Debug, Default)]
pub struct WallState<S: SolidSpace> {
    /// Position \[m\].
    pub position: Vec<S::Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<S::Vector>,
    /// Acceleration \[m/s²\].
    pub acceleration: Vec<S::Vector>,
}

impl<S: SolidSpace> Walls<S> {
    /// The walls of `setup`; expressions that do not parse are added to `errors`.
    pub fn new(setup: &SolidSetup<S>, errors: &mut Vec<String>) -> Self {
        let wall_of = setup.wall_particles.wall.clone();
        let mut members = vec![Vec::new(); setup.walls.len()];
        for (w, wall) in wall_of.iter().enumerate() {
            members[*wall as usize].push(w);
        }
        let build = |(particles, wall): (Vec<usize>, &WallSetup<S>)| {
            let motion = wall.motion.as_ref().and_then(|motion| match RigidMotion::new(motion) {
                Ok(motion) => Some(motion),
                Err(error) => {
                    errors.push(format!("wall `{}`: {error}", wall.name));
                    None
                }
            });
            Wall { motion, release_time: wall.release_time.unwrap_or(f64::INFINITY), particles }
        };
        let walls: Vec<Wall<S>> = members.into_iter().zip(&setup.walls).map(build).collect();
        let moves = walls.iter().filter(|wall| wall.motion.is_some());
        let moving = moves.flat_map(|wall| wall.particles.iter().copied()).collect();
        Self { walls, wall_of, start: setup.wall_particles.position.clone(), moving }
    }

    /// Number of wall particles.
    pub fn len(&self) -> usize {
        self.start.len()
    }

    /// Whether wall particle `w` acts in the step of `time`.
    pub fn acts(&self, w: usize, time: &StageTime) -> bool {
        acts(self.walls[self.wall_of[w] as usize].release_time, time)
    }

    /// Number of walls released before the step of `time`.
    pub fn released(&self, time: &StageTime) -> usize {
        self.walls.iter().filter(|wall| !acts(wall.release_time, time)).count()
    }

    /// Wall particles at the start.
    pub fn at_start(&self) -> WallState<S> {
        let at_rest = vec![S::Vector::zeros(); self.len()];
        WallState { position: self.start.clone(), velocity: at_rest.clone(), acceleration: at_rest }
    }

    /// The wall particles of `state` as lists of contact need them.
    pub fn places<'a>(&'a self, state: &'a WallState<S>) -> WallPlaces<'a, S> {
        WallPlaces { position: &state.position, moving: &self.moving }
    }

    /// Moves the particles of moving walls to where they are at `time` \[s\].
    pub fn move_to(&self, time: f64, state: &mut WallState<S>) {
        for wall in &self.walls {
            let Some(motion) = wall.motion.as_ref().map(|motion| motion.at(time)) else {
                continue;
            };
            for &w in &wall.particles {
                state.position[w] = motion.position(&self.start[w]);
                state.velocity[w] = motion.velocity(&self.start[w]);
                state.acceleration[w] = motion.acceleration(&self.start[w]);
            }
        }
    }
}
