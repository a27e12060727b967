//! Walls and open sides.

use crate::space::{DIMENSIONS, Vector};

/// One wall of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct WallSetup {
    /// Name.
    pub name: String,
    /// Condition along the wall.
    pub condition: WallCondition,
    /// Prescribed motion; `None` for a wall at rest.
    pub motion: Option<Motion>,
    /// The wall ceases to act at this time \[s\].
    pub release_time: Option<f64>,
}

/// Condition along a wall, Eq. (27).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WallCondition {
    /// Normal component mirrored, tangential kept.
    Slip,
    /// Both components mirrored.
    NoSlip,
}

/// Prescribed rigid motion; expressions of `t` \[s\].
///
/// The position is `pivot + R(angle)·(X − pivot) + displacement`, X the position at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Displacement components \[m\].
    pub displacement: [String; DIMENSIONS],
    /// Rotation angle, counter-clockwise \[rad\].
    pub angle: String,
    /// Centre of the rotation \[m\].
    pub pivot: Vector,
}

/// Wall particles, one entry per particle in each array.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WallParticles {
    /// Index of the wall.
    pub wall: Vec<u32>,
    /// Position at the start \[m\].
    pub position: Vec<Vector>,
    /// Unit normal into the fluid \[-\]; zero where faces meet, where Eq. (27) reverses both components.
    pub normal: Vec<Vector>,
}

/// Which sides of the domain are open: x below, x above, y below, y above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outflow {
    /// Particles may leave through the lower side, by axis.
    pub lower: [bool; DIMENSIONS],
    /// Particles may leave through the upper side, by axis.
    pub upper: [bool; DIMENSIONS],
}
