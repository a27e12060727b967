//! Walls, and the prescribed motion of walls and supports.

use sph::setup::{Motion, WallCondition, WallParticles, WallSetup};
use sph::space::Space;
use sph::space::components::Components;

use super::arrays::{index_count, pack, pack_indices, unpack, unpack_indices_below};
use super::run::{expressions_of, expressions_to_wire};
use super::{
    Choice, Convert, Path, WireError, choice, finite, name, numbers_from_wire, optional, text,
    vector_from_wire, vector_to_wire,
};
use crate::wire;

/// Largest difference of the length of an axis from 1: round-off of a direction that was normalised.
const UNIT_LENGTH: f64 = 1e-12;

choices!(WallCondition = wire::WallCondition { Slip, NoSlip });

impl<S: Space> Convert for Motion<S> {
    type Wire = wire::Motion;

    fn to_wire(&self) -> wire::Motion {
        wire::Motion {
            displacement_m: expressions_to_wire(self.displacement.as_ref()),
            angle_rad: self.angle.clone(),
            pivot_m: vector_to_wire(&self.pivot),
            axis: (<S::Spin as Components>::COUNT > 1).then(|| vector_to_wire(&self.axis)).flatten(),
        }
    }

    fn from_wire(wire: &wire::Motion, at: &Path<'_>) -> Result<Self, WireError> {
        let displacement = at.field("displacement_m");
        let texts = wire.displacement_m.as_ref().ok_or_else(|| displacement.error("is missing"))?;
        Ok(Self {
            displacement: expressions_of::<S>(texts, &displacement)?,
            angle: text(&wire.angle_rad, &at.field("angle_rad"))?,
            axis: axis_from_wire(&wire.axis, &at.field("axis"))?,
            pivot: vector_from_wire(&wire.pivot_m, &at.field("pivot_m"))?,
        })
    }
}

/// The axis of a rotation: in the plane it is that of z and travels not, in space it is a unit vector.
fn axis_from_wire<C: Components>(wire: &Option<wire::Vector>, at: &Path<'_>) -> Result<C, WireError> {
    if C::COUNT == 1 {
        if wire.is_some() {
            return Err(at.error("is given, must be absent in a run of 2 dimensions"));
        }
        return C::of_row(&[1.0]).ok_or_else(|| at.error("is missing"));
    }
    let numbers = numbers_from_wire(wire, C::COUNT, at)?;
    let length = numbers.iter().map(|x| x * x).sum::<f64>().sqrt();
    if (length - 1.0).abs() > UNIT_LENGTH {
        return Err(at.error(format!("is {numbers:?} of length {length:?}, must be a unit vector")));
    }
    C::of_row(&numbers).ok_or_else(|| at.error("has another number of components than the run"))
}

/// A time of release, which may be absent.
pub(super) fn release_time(wire: Option<f64>, at: &Path<'_>) -> Result<Option<f64>, WireError> {
    wire.map(|time| finite(time, &at.field("release_time_s"))).transpose()
}

impl<S: Space> Convert for WallSetup<S> {
    type Wire = wire::WallSetup;

    fn to_wire(&self) -> wire::WallSetup {
        wire::WallSetup {
            name: self.name.clone(),
            condition: self.condition.code(),
            motion: self.motion.as_ref().map(Convert::to_wire),
            release_time_s: self.release_time,
        }
    }

    fn from_wire(wire: &wire::WallSetup, at: &Path<'_>) -> Result<Self, WireError> {
        Ok(Self {
            name: name(&wire.name, &at.field("name"))?,
            condition: choice(wire.condition, &at.field("condition"))?,
            motion: optional(&wire.motion, &at.field("motion"))?,
            release_time: release_time(wire.release_time_s, at)?,
        })
    }
}

pub(super) fn wall_particles_to_wire<S: Space>(particles: &WallParticles<S>) -> wire::WallParticles {
    wire::WallParticles {
        walls: pack_indices(&particles.wall),
        positions_m: pack(&particles.position),
        normals: pack(&particles.normal),
    }
}

/// Wall particles of `walls` walls; an absent message has none.
pub(super) fn wall_particles_from_wire<S: Space>(
    wire: &Option<wire::WallParticles>,
    walls: usize,
    at: &Path<'_>,
) -> Result<WallParticles<S>, WireError> {
    let Some(wire) = wire else { return Ok(WallParticles::default()) };
    let count = index_count(&wire.walls, &at.field("walls"))?;
    Ok(WallParticles {
        wall: unpack_indices_below(&wire.walls, count, walls, "walls", &at.field("walls"))?,
        position: unpack(&wire.positions_m, count, &at.field("positions_m"))?,
        normal: unpack(&wire.normals, count, &at.field("normals"))?,
    })
}
