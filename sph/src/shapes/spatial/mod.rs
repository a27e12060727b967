//! Shapes in space.

mod face;
pub(crate) mod faces;
mod frame;
pub(crate) mod made_of;
mod moments;
mod pieces;
mod validate;

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};

pub use faces::SpatialBoundary;
pub use frame::Frame;

use super::region::{LayerParticle, Region, ShapedSpace, Side};
use super::{Shape, Surface};
use crate::space::Spatial;

/// A region of space, lengths in \[m\].
///
/// Containment is half-open: of two shapes that share a face, exactly one contains a point of that face.
#[derive(Clone, Debug, PartialEq)]
pub enum SpatialShape {
    /// Axis-aligned box.
    Box {
        /// Lower corner.
        lower: Vector3<f64>,
        /// Upper corner.
        upper: Vector3<f64>,
    },
    /// Ball.
    Sphere {
        /// Centre.
        centre: Vector3<f64>,
        /// Radius.
        radius: f64,
    },
    /// Round cylinder, or tube.
    Cylinder {
        /// Centre of one end.
        from: Vector3<f64>,
        /// Centre of the other end.
        to: Vector3<f64>,
        /// Radius.
        radius: f64,
        /// Radius of the bore; zero of a cylinder without.
        inner_radius: f64,
    },
    /// Right circular cone or frustum.
    Cone {
        /// Centre of one end.
        from: Vector3<f64>,
        /// Centre of the other end.
        to: Vector3<f64>,
        /// Radii of both ends; one of them may be zero.
        radii: [f64; 2],
    },
    /// Ring of round section.
    Torus {
        /// Centre.
        centre: Vector3<f64>,
        /// Direction of the axis, of any length.
        axis: Vector3<f64>,
        /// Distance of the middle of the section from the axis.
        radius: f64,
        /// Radius of the section, below `radius`.
        tube_radius: f64,
    },
    /// A shape of the plane moved along a line across it.
    Extrusion {
        /// The shape, in x and y of the frame.
        section: Shape,
        /// Where z = 0 is; the shape is moved along z.
        frame: Frame,
        /// Length along z.
        height: f64,
    },
    /// A shape of the plane turned about a line in it.
    Revolution {
        /// The shape: x is the distance from the z axis of the frame, nowhere negative, and y the height along it.
        section: Shape,
        /// The z axis is that of the revolution.
        frame: Frame,
    },
    /// What lies on one side of a plane; to be cut by or with another shape.
    HalfSpace {
        /// A point of the plane.
        point: Vector3<f64>,
        /// Normal of the plane out of the half-space, of any length.
        normal: Vector3<f64>,
    },
    /// What lies in any of the parts.
    Union(Vec<SpatialShape>),
    /// What lies in all of the parts.
    Intersection(Vec<SpatialShape>),
    /// What lies in the first shape and in none of the others.
    Difference(Box<SpatialShape>, Vec<SpatialShape>),
    /// A shape turned and moved.
    Placed {
        /// The shape in the coordinates of the frame.
        shape: Box<SpatialShape>,
        /// Where it is.
        frame: Frame,
    },
    /// What a surface of triangles encloses.
    Surface(Arc<Surface>),
}

impl SpatialShape {
    /// The shape turned and moved into `frame`.
    #[must_use]
    pub fn placed(self, frame: Frame) -> Self {
        Self::Placed { shape: Box::new(self), frame }
    }
}

/// Distance of `point` from the line from `from` along `axis`, and its coordinate along that line, zero at `from`; and
/// the length of `axis`.
fn about_axis(point: &Vector3<f64>, from: &Vector3<f64>, axis: &Vector3<f64>) -> (f64, f64, f64) {
    let length = axis.norm();
    let unit = axis / length;
    let d = point - from;
    let along = d.dot(&unit);
    ((d - unit * along).norm(), along, length)
}

impl ShapedSpace for Spatial {
    type Shape = SpatialShape;
}

impl Region<Spatial> for SpatialShape {
    type Boundary = SpatialBoundary;

    fn contains(&self, point: &Vector3<f64>) -> bool {
        match self {
            Self::Box { lower, upper } => {
                (0..3).all(|axis| lower[axis] <= point[axis] && point[axis] < upper[axis])
            }
            Self::Sphere { centre, radius } => (point - centre).norm_squared() < radius * radius,
            Self::Cylinder { from, to, radius, inner_radius } => {
                let (distance, along, length) = about_axis(point, from, &(to - from));
                (0.0..length).contains(&along) && (*inner_radius..*radius).contains(&distance)
            }
            Self::Cone { from, to, radii } => {
                let (distance, along, length) = about_axis(point, from, &(to - from));
                let radius = radii[0] + (radii[1] - radii[0]) * (along / length);
                (0.0..length).contains(&along) && distance < radius
            }
            Self::Torus { centre, axis, radius, tube_radius } => {
                let (distance, along, _) = about_axis(point, centre, axis);
                Vector2::new(distance - radius, along).norm_squared() < tube_radius * tube_radius
            }
            Self::Extrusion { section, frame, height } => {
                let x = frame.local(point);
                (0.0..*height).contains(&x.z) && section.contains(&x.xy())
            }
            Self::Revolution { section, frame } => {
                let x = frame.local(point);
                section.contains(&Vector2::new(x.xy().norm(), x.z))
            }
            Self::HalfSpace { point: on_plane, normal } => (point - on_plane).dot(normal) < 0.0,
            Self::Union(parts) => parts.iter().any(|part| part.contains(point)),
            Self::Intersection(parts) => parts.iter().all(|part| part.contains(point)),
            Self::Difference(base, removed) => {
                base.contains(point) && !removed.iter().any(|part| part.contains(point))
            }
            Self::Placed { shape, frame } => shape.contains(&frame.local(point)),
            Self::Surface(surface) => surface.contains(point),
        }
    }

    /// Lower and upper corner of a box that holds the shape: the smallest one of shapes that are not composed, turned or
    /// made of sections; for a difference, of its first shape. Infinite for a half-space.
    fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        let everywhere = Vector3::repeat(f64::INFINITY);
        match self {
            Self::Box { lower, upper } => (*lower, *upper),
            Self::Sphere { centre, radius } => around(centre, &Vector3::repeat(*radius)),
            Self::Cylinder { from, to, radius, .. } => {
                of_discs(&(to - from), [(from, *radius), (to, *radius)])
            }
            Self::Cone { from, to, radii } => of_discs(&(to - from), [(from, radii[0]), (to, radii[1])]),
            Self::Torus { centre, axis, radius, tube_radius } => {
                let half = disc(axis) * *radius + Vector3::repeat(*tube_radius);
                around(centre, &half)
            }
            Self::Extrusion { section, frame, height } => {
                let (lower, upper) = section.bounds();
                of_turned_box(frame, &lower.push(0.0), &upper.push(*height))
            }
            Self::Revolution { section, frame } => {
                let (lower, upper) = section.bounds();
                let ends = [lower.y, upper.y].map(|z| frame.point(&Vector3::new(0.0, 0.0, z)));
                of_discs(&frame.z(), [(&ends[0], upper.x), (&ends[1], upper.x)])
            }
            Self::HalfSpace { .. } => (-everywhere, everywhere),
            Self::Union(parts) => envelope(parts.iter().map(Self::bounds)),
            Self::Intersection(parts) => parts
                .iter()
                .map(Self::bounds)
                .fold((-everywhere, everywhere), |(lower, upper), (a, b)| (lower.sup(&a), upper.inf(&b))),
            Self::Difference(base, _) => base.bounds(),
            Self::Placed { shape, frame } => {
                let (lower, upper) = shape.bounds();
                of_turned_box(frame, &lower, &upper)
            }
            Self::Surface(surface) => surface.bounds(),
        }
    }

    fn boundary(&self) -> SpatialBoundary {
        SpatialBoundary::new(self)
    }

    fn layers_along(
        &self,
        boundary: &SpatialBoundary,
        spacing: f64,
        layers: u32,
        side: Side<Spatial>,
    ) -> Vec<LayerParticle<Spatial>> {
        faces::layers::along(self, boundary, spacing, layers, side)
    }

    fn translated(&self, by: &Vector3<f64>) -> Self {
        let each = |parts: &[Self]| parts.iter().map(|part| part.translated(by)).collect();
        let mut moved = self.clone();
        match &mut moved {
            Self::Box { lower, upper } => [lower, upper].into_iter().for_each(|corner| *corner += by),
            Self::Sphere { centre, .. } | Self::Torus { centre, .. } => *centre += by,
            Self::Cylinder { from, to, .. } | Self::Cone { from, to, .. } => {
                [from, to].into_iter().for_each(|end| *end += by);
            }
            Self::Extrusion { frame, .. } | Self::Revolution { frame, .. } | Self::Placed { frame, .. } => {
                *frame = frame.translated(by);
            }
            Self::HalfSpace { point, .. } => *point += by,
            Self::Union(parts) | Self::Intersection(parts) => *parts = each(parts),
            Self::Difference(base, removed) => {
                **base = base.translated(by);
                *removed = each(removed);
            }
            Self::Surface(_) => return moved.placed(Frame::default().translated(by)),
        }
        moved
    }
}

fn around(centre: &Vector3<f64>, half: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (centre - half, centre + half)
}

/// Half the extent along each axis of a disc of radius one across `axis`.
fn disc(axis: &Vector3<f64>) -> Vector3<f64> {
    let unit = axis.normalize();
    unit.map(|component| (1.0 - component * component).max(0.0).sqrt())
}

/// Box around discs across `axis` of the given centres and radii.
fn of_discs(axis: &Vector3<f64>, discs: [(&Vector3<f64>, f64); 2]) -> (Vector3<f64>, Vector3<f64>) {
    let half = disc(axis);
    envelope(discs.into_iter().map(|(centre, radius)| around(centre, &(half * radius))))
}

/// Box around a box of the coordinates of `frame`.
fn of_turned_box(frame: &Frame, lower: &Vector3<f64>, upper: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    if !(upper - lower).norm().is_finite() {
        let everywhere = Vector3::repeat(f64::INFINITY);
        return (-everywhere, everywhere);
    }
    let corner =
        |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 0 { lower[axis] } else { upper[axis] });
    envelope((0..8).map(|k| frame.point(&corner(k))).map(|x| (x, x)))
}

/// Smallest box around boxes; lower above upper when there are none.
fn envelope(boxes: impl Iterator<Item = (Vector3<f64>, Vector3<f64>)>) -> (Vector3<f64>, Vector3<f64>) {
    let none = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    boxes.fold(none, |(lower, upper), (a, b)| (lower.inf(&a), upper.sup(&b)))
}

#[cfg(test)]
mod tests;
