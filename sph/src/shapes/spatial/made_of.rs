//! The faces that shapes in space are made of.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use nalgebra::{Vector2, Vector3};

use super::SpatialShape;
use super::face::{Face, Form};
use super::frame::Frame;
use crate::shapes::Shape;
use crate::shapes::boundary::{Edge, ROUND_OFF};

impl SpatialShape {
    /// The section and frame of a shape of revolution.
    pub(super) fn revolved(&self) -> Option<(Shape, Frame)> {
        match self {
            Self::Cylinder { from, to, radius, inner_radius } => {
                let upper = Vector2::new(*radius, (to - from).norm());
                let section = Shape::Rectangle { lower: Vector2::new(*inner_radius, 0.0), upper };
                Some((section, Frame::along(*from, &(to - from))?))
            }
            Self::Cone { from, to, radii } => {
                let length = (to - from).norm();
                let mut vertices = vec![Vector2::zeros(), Vector2::new(0.0, length)];
                let ends = [Vector2::new(radii[1], length), Vector2::new(radii[0], 0.0)];
                vertices.extend(ends.into_iter().filter(|end| end.x > 0.0));
                Some((Shape::Polygon { vertices }, Frame::along(*from, &(to - from))?))
            }
            Self::Torus { centre, axis, radius, tube_radius } => {
                let section = Shape::Circle { centre: Vector2::new(*radius, 0.0), radius: *tube_radius };
                Some((section, Frame::along(*centre, axis)?))
            }
            Self::Revolution { section, frame } => Some((section.clone(), *frame)),
            _ => None,
        }
    }

    /// Whether it is made of other shapes that overlap or cut each other.
    pub(super) fn is_composed(&self) -> bool {
        match self {
            Self::Union(_) | Self::Intersection(_) | Self::Difference(..) => true,
            Self::Placed { shape, .. } => shape.is_composed(),
            _ => false,
        }
    }

    /// Adds the faces of all shapes it is made of, in coordinates of which it is given in those of `frame`.
    pub(super) fn faces(&self, frame: &Frame, faces: &mut Vec<Face>) {
        let moved = |by: &Vector3<f64>| frame.of(&Frame::default().translated(by));
        match self {
            Self::Box { lower, upper } => {
                let size = upper - lower;
                let section = Shape::Rectangle { lower: Vector2::zeros(), upper: size.xy() };
                extruded(&section, size.z, &moved(lower), faces);
            }
            Self::Sphere { centre, radius } => {
                let (radius, begin, sweep) = (*radius, -FRAC_PI_2, PI);
                let edge = Edge::Arc { centre: Vector2::zeros(), radius, begin, sweep, outward: 1.0 };
                faces.push(Face { frame: moved(centre), form: Form::Turned { edge } });
            }
            Self::Cylinder { .. } | Self::Cone { .. } | Self::Torus { .. } | Self::Revolution { .. } => {
                if let Some((section, own)) = self.revolved() {
                    revolved(&section, &frame.of(&own), faces);
                }
            }
            Self::Extrusion { section, frame: own, height } => {
                extruded(section, *height, &frame.of(own), faces);
            }
            Self::HalfSpace { point, normal } => {
                if let Some(own) = Frame::along(*point, normal) {
                    faces.push(Face { frame: frame.of(&own), form: Form::Plane });
                }
            }
            Self::Union(parts) | Self::Intersection(parts) => {
                parts.iter().for_each(|part| part.faces(frame, faces));
            }
            Self::Difference(base, removed) => {
                base.faces(frame, faces);
                removed.iter().for_each(|part| part.faces(frame, faces));
            }
            Self::Placed { shape, frame: own } => shape.faces(&frame.of(own), faces),
            Self::Surface(surface) => {
                faces.push(Face { frame: *frame, form: Form::Triangles(surface.clone()) });
            }
        }
    }
}

/// The faces of `section` of the plane z = 0 of `frame`, moved along z to `height`.
fn extruded(section: &Shape, height: f64, frame: &Frame, faces: &mut Vec<Face>) {
    let boundary = section.boundary();
    faces.extend(
        boundary.edges().iter().map(|edge| Face { frame: *frame, form: Form::Swept { edge: *edge, height } }),
    );
    let section = Arc::new((section.clone(), boundary));
    for (height, outward) in [(0.0, -1.0), (height, 1.0)] {
        faces.push(Face { frame: *frame, form: Form::Cap { section: section.clone(), height, outward } });
    }
}

/// The faces of `section`, turned about the z axis of `frame`; edges on the axis pass over nothing.
fn revolved(section: &Shape, frame: &Frame, faces: &mut Vec<Face>) {
    let (lower, upper) = section.bounds();
    let on_axis = |edge: &Edge| {
        [0.0, 0.5, 1.0].iter().all(|k| edge.at(*k).0.x.abs() <= ROUND_OFF * (upper - lower).norm())
    };
    let boundary = section.boundary();
    let passing = boundary.edges().iter().filter(|edge| !on_axis(edge));
    faces.extend(passing.map(|edge| Face { frame: *frame, form: Form::Turned { edge: *edge } }));
}
