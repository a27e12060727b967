//! Shapes of a scene and the particles that fill or surround them.
//!
//! Regions, bodies and containers are [`Shape`]s in the plane and [`SpatialShape`]s in space; [`fill`] puts particles
//! into one, [`layers_around`] puts wall particles around one, [`wall_fill`] makes one a wall. These lie on one square
//! (cubic) lattice with points at origin + (k + 1/2)·spacing, so that shapes that share a side share no particle and
//! leave no gap. Walls with slanted or curved faces get [`layers_along`] their faces instead.

pub(crate) mod boundary;
mod crowd;
pub(crate) mod fill_fitted;
pub(crate) mod fitted;
mod lattice;
mod moments;
pub(crate) mod packing;
mod plane_region;
mod region;
pub(crate) mod spatial;
pub mod surface;
mod thickness;
pub(crate) mod thresholds;
mod validate;

pub use boundary::{Boundary, CORNER_ANGLE, SurfacePoint};
pub use fill_fitted::{FITTED_STEPS, fill_fitted};
pub use fitted::{is_on_lattice, layers_along};
pub use lattice::{displace, fill, lattice_points, layers_around, wall_fill};
pub use packing::{Interior, Moments, Packing, Sample};
pub use region::{Faces, LayerParticle, OpenSides, Region, ShapedSpace, Side};
pub use spatial::{Frame, SpatialBoundary, SpatialShape};
pub use surface::Surface;
pub use thickness::local_thickness;
pub use validate::{MAXIMUM_NESTING, MAXIMUM_VERTICES};

use crate::space::Vector;

/// A region of the plane, lengths in \[m\].
///
/// Containment is half-open: of two shapes that share a side, exactly one contains a point of that side.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Axis-aligned rectangle.
    Rectangle {
        /// Lower left corner.
        lower: Vector,
        /// Upper right corner.
        upper: Vector,
    },
    /// Disc.
    Circle {
        /// Centre.
        centre: Vector,
        /// Radius.
        radius: f64,
    },
    /// Disc with a concentric hole.
    Ring {
        /// Centre.
        centre: Vector,
        /// Radius of the hole.
        inner_radius: f64,
        /// Radius of the disc.
        outer_radius: f64,
    },
    /// Simple polygon, corners in either sense of rotation; the last is joined to the first.
    Polygon {
        /// Corners.
        vertices: Vec<Vector>,
    },
    /// What lies in any of the parts.
    Union(Vec<Shape>),
    /// What lies in the first shape and in none of the others.
    Difference(Box<Shape>, Vec<Shape>),
}

impl Shape {
    /// Whether `point` \[m\] lies inside.
    pub fn contains(&self, point: &Vector) -> bool {
        match self {
            Self::Rectangle { lower, upper } => {
                (0..2).all(|axis| lower[axis] <= point[axis] && point[axis] < upper[axis])
            }
            Self::Circle { centre, radius } => (point - centre).norm_squared() < radius * radius,
            Self::Ring { centre, inner_radius, outer_radius } => {
                let square = (point - centre).norm_squared();
                inner_radius * inner_radius <= square && square < outer_radius * outer_radius
            }
            Self::Polygon { vertices } => polygon_contains(vertices, point),
            Self::Union(parts) => parts.iter().any(|part| part.contains(point)),
            Self::Difference(base, removed) => {
                base.contains(point) && !removed.iter().any(|part| part.contains(point))
            }
        }
    }

    /// Lower left and upper right corner \[m\] of a box that holds the shape; for a difference, of its first shape.
    pub fn bounds(&self) -> (Vector, Vector) {
        match self {
            Self::Rectangle { lower, upper } => (*lower, *upper),
            Self::Circle { centre, radius: reach } | Self::Ring { centre, outer_radius: reach, .. } => {
                let half = Vector::repeat(*reach);
                (centre - half, centre + half)
            }
            Self::Polygon { vertices } => envelope(vertices.iter().map(|vertex| (*vertex, *vertex))),
            Self::Union(parts) => envelope(parts.iter().map(Self::bounds)),
            Self::Difference(base, _) => base.bounds(),
        }
    }

    /// The boundary, ready for any number of distance queries.
    pub fn boundary(&self) -> Boundary {
        Boundary::new(self)
    }

    /// Nearest surface as seen from `point` \[m\]; for many points make the [`Shape::boundary`] once.
    pub fn surface(&self, point: &Vector) -> SurfacePoint {
        self.boundary().surface(point)
    }

    /// The shape moved by `by` \[m\].
    pub fn translated(&self, by: &Vector) -> Self {
        match self {
            Self::Rectangle { lower, upper } => Self::Rectangle { lower: lower + by, upper: upper + by },
            Self::Circle { centre, radius } => Self::Circle { centre: centre + by, radius: *radius },
            Self::Ring { centre, inner_radius, outer_radius } => {
                Self::Ring { centre: centre + by, inner_radius: *inner_radius, outer_radius: *outer_radius }
            }
            Self::Polygon { vertices } => {
                Self::Polygon { vertices: vertices.iter().map(|vertex| vertex + by).collect() }
            }
            Self::Union(parts) => Self::Union(parts.iter().map(|part| part.translated(by)).collect()),
            Self::Difference(base, removed) => Self::Difference(
                Box::new(base.translated(by)),
                removed.iter().map(|part| part.translated(by)).collect(),
            ),
        }
    }
}

/// Smallest box around boxes; lower above upper when there are none.
fn envelope(boxes: impl Iterator<Item = (Vector, Vector)>) -> (Vector, Vector) {
    let none = (Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY));
    boxes.fold(none, |(lower, upper), (a, b)| (lower.inf(&a), upper.sup(&b)))
}

/// Even-odd rule with half-open edges: a rectangle drawn as a polygon contains what the rectangle contains.
fn polygon_contains(vertices: &[Vector], point: &Vector) -> bool {
    let mut inside = false;
    for (a, b) in edges_of(vertices) {
        if (a.y > point.y) != (b.y > point.y) {
            let crossing = a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x);
            if point.x < crossing {
                inside = !inside;
            }
        }
    }
    inside
}

/// Consecutive corners of a closed polygon.
fn edges_of(vertices: &[Vector]) -> impl Iterator<Item = (Vector, Vector)> + '_ {
    vertices.iter().zip(vertices.iter().cycle().skip(1)).map(|(a, b)| (*a, *b))
}

#[cfg(test)]
mod tests;
