//! Walls and open sides.

use crate::space::{Plane, Space};

/// One wall of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct WallSetup<S: Space = Plane> {
    /// Name.
    pub name: String,
    /// Condition along the wall.
    pub condition: WallCondition,
    /// Prescribed motion; `None` for a wall at rest.
    pub motion: Option<Motion<S>>,
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
pub struct Motion<S: Space = Plane> {
    /// Displacement components \[m\].
    pub displacement: S::PerAxis<String>,
    /// Rotation angle, counter-clockwise about the axis \[rad\].
    pub angle: String,
    /// Angular velocity of unit magnitude about the axis of rotation: a unit vector in space, 1 in the plane.
    pub axis: S::Spin,
    /// A point on the axis \[m\].
    pub pivot: S::Vector,
}

/// Wall particles, one entry per particle in each array.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WallParticles<S: Space = Plane> {
    /// Index of the wall.
    pub wall: Vec<u32>,
    /// Position at the start \[m\].
    pub position: Vec<S::Vector>,
    /// Unit normal into the fluid \[-\]; zero where faces meet, where Eq. (27) reverses both components.
    pub normal: Vec<S::Vector>,
}

/// Which sides of the domain are open.
#[derive(Clone, Copy, Debug)]
pub struct Outflow<S: Space = Plane> {
    /// Particles may leave through the lower side, by axis.
    pub lower: S::Of<bool>,
    /// Particles may leave through the upper side, by axis.
    pub upper: S::Of<bool>,
}

impl<S: Space> Outflow<S> {
    /// Whether any side is open.
    pub fn is_open(&self) -> bool {
        (0..S::DIMENSIONS).any(|axis| self.lower[axis] || self.upper[axis])
    }
}

impl<S: Space> Default for Outflow<S> {
    /// All sides closed.
    fn default() -> Self {
        Self { lower: S::splat(false), upper: S::splat(false) }
    }
}

impl<S: Space> PartialEq for Outflow<S> {
    fn eq(&self, other: &Self) -> bool {
        (0..S::DIMENSIONS)
            .all(|axis| self.lower[axis] == other.lower[axis] && self.upper[axis] == other.upper[axis])
    }
}
