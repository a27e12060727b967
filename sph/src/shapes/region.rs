//! What filling needs of a shape, in any space.

use std::fmt::Debug;

use super::boundary::SurfacePoint;
use super::packing::Moments;
use super::thresholds::Thresholds;
use crate::space::{Plane, Space};

/// Sides of a container that have no wall, by axis: the particles beyond are left out.
#[derive(Clone, Copy, Debug)]
pub struct OpenSides<S: Space = Plane> {
    /// Open toward lower coordinates.
    pub lower: S::Of<bool>,
    /// Open toward upper coordinates.
    pub upper: S::Of<bool>,
}

impl<S: Space> Default for OpenSides<S> {
    fn default() -> Self {
        Self { lower: S::splat(false), upper: S::splat(false) }
    }
}

impl<S: Space> PartialEq for OpenSides<S> {
    fn eq(&self, other: &Self) -> bool {
        (0..S::DIMENSIONS)
            .all(|axis| self.lower[axis] == other.lower[axis] && self.upper[axis] == other.upper[axis])
    }
}

impl<S: Space> Eq for OpenSides<S> {}

/// A wall particle with its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerParticle<S: Space = Plane> {
    /// Position \[m\].
    pub position: S::Vector,
    /// Unit normal out of the wall \[-\]; zero where faces meet, see [`crate::setup::WallParticles::normal`].
    pub normal: S::Vector,
}

/// On which side of the boundary the wall is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side<S: Space = Plane> {
    /// Around the shape, a container; these sides of the box around it stay open.
    Outside(OpenSides<S>),
    /// Inside the shape, a solid wall.
    Inside,
}

/// A region of space, lengths in \[m\].
///
/// Containment is half-open: of two regions that share a face, exactly one contains a point of that face.
pub trait Region<S: Space>: Clone + Debug + PartialEq + Send + Sync {
    /// Its faces, ready for any number of distance queries.
    type Boundary: Faces<S>;

    /// Whether `point` \[m\] lies inside.
    fn contains(&self, point: &S::Vector) -> bool;

    /// Lower and upper corner \[m\] of a box that holds the region; infinite where the region is unbounded.
    fn bounds(&self) -> (S::Vector, S::Vector);

    /// Its faces.
    fn boundary(&self) -> Self::Boundary;

    /// What [`super::layers_along`] gives.
    fn layers_along(
        &self,
        boundary: &Self::Boundary,
        spacing: f64,
        layers: u32,
        side: Side<S>,
    ) -> Vec<LayerParticle<S>>;

    /// The region moved by `by` \[m\].
    #[must_use]
    fn translated(&self, by: &S::Vector) -> Self;
}

/// The faces of a region.
pub trait Faces<S: Space>: Clone + Debug + Send + Sync {
    /// Nearest surface as seen from `point` \[m\].
    fn surface(&self, point: &S::Vector) -> SurfacePoint<S>;

    /// As [`Faces::surface`]; distances that differ by less than `tolerance` \[m\] count as equal.
    fn surface_within(&self, point: &S::Vector, tolerance: f64) -> SurfacePoint<S>;

    /// Points inside the region in even layers along its faces: `depth` \[m\] from layer to layer, the first half of it from the
    /// face, and `along` \[m\] apart in a layer.
    fn layers_within(&self, depth: f64, along: f64, layers: u32) -> Vec<S::Vector>;

    /// Volume (area in the plane) and moments of the region.
    fn moments(&self) -> Moments<S>;

    /// Volume \[m³\] (area in the plane \[m²\]) of the region.
    fn volume(&self) -> f64 {
        self.moments().volume
    }
}

/// A space with shapes to fill.
pub trait ShapedSpace: Thresholds {
    /// Its shapes.
    type Shape: Region<Self>;
}
