//! Exact boundaries of shapes: straight and circular edges, clipped where shapes overlap.

mod edge;

use std::f64::consts::PI;

pub(super) use edge::Edge;

use super::{Shape, edges_of};
use crate::space::tensors::SpaceVector;
use crate::space::{Plane, Space, Vector, cross};

crate::constants! {
    /// A curve drawn with many short edges has normals everywhere; a bend of a right angle has none at its vertex.
    pub const CORNER_ANGLE: f64 = PI / 6.0, "fitted.corner_angle",
        "angle between the normals of two faces below which they meet smoothly, in radians";
}

/// Lengths below this fraction of the shape's diagonal are round-off.
pub(super) const ROUND_OFF: f64 = 1e-9;

/// How far beside an edge its two sides are examined, as a fraction of the shape's diagonal.
pub(super) const SIDE_OFFSET: f64 = 1e-7;

/// Where along an edge it is examined whether something covers it.
const COVER_SAMPLES: [f64; 9] = [0.02, 0.14, 0.26, 0.38, 0.5, 0.62, 0.74, 0.86, 0.98];

/// The nearest surface of a shape as seen from a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint<S: Space = Plane> {
    /// Distance to the surface \[m\], negative inside.
    pub distance: f64,
    /// Unit normal of the nearest face, out of the shape; at a vertex the mean of the faces that meet.
    pub normal: S::Vector,
    /// Whether the nearest feature is a corner or, in space, an edge: faces whose normals differ are equally near.
    pub at_vertex: bool,
}

/// The boundary of a shape as edges that bear its outward normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    shape: Shape,
    edges: Vec<Edge>,
    size: f64,
}

/// Edges of the primitives in `shape`, one list per primitive.
fn primitives(shape: &Shape, lists: &mut Vec<Vec<Edge>>) {
    match shape {
        Shape::Rectangle { lower, upper } => {
            let corners = [*lower, Vector::new(upper.x, lower.y), *upper, Vector::new(lower.x, upper.y)];
            lists.push(edges_of(&corners).map(|(a, b)| Edge::segment(a, b)).collect());
        }
        Shape::Circle { centre, radius } => lists.push(vec![Edge::circle(*centre, *radius, 1.0)]),
        Shape::Ring { centre, inner_radius, outer_radius } => lists.push(vec![
            Edge::circle(*centre, *outer_radius, 1.0),
            Edge::circle(*centre, *inner_radius, -1.0),
        ]),
        Shape::Polygon { vertices } => {
            let doubled_area: f64 = edges_of(vertices).map(|(a, b)| cross(&a, &b)).sum();
            let edges = edges_of(vertices).map(|(a, b)| Edge::segment(a, b));
            lists.push(if doubled_area > 0.0 {
                edges.collect()
            } else {
                edges.map(Edge::turned_round).collect()
            });
        }
        Shape::Union(parts) => parts.iter().for_each(|part| primitives(part, lists)),
        Shape::Difference(base, removed) => {
            primitives(base, lists);
            removed.iter().for_each(|part| primitives(part, lists));
        }
    }
}

impl Boundary {
    /// The boundary of `shape`; overlapped parts of its primitives' edges do not belong to it.
    pub fn new(shape: &Shape) -> Self {
        let (lower, upper) = shape.bounds();
        let size = (upper - lower).norm();
        let mut lists = Vec::new();
        primitives(shape, &mut lists);
        let edges = match lists.as_mut_slice() {
            [one] => std::mem::take(one),
            _ => clipped(shape, &lists, size),
        };
        Self { shape: shape.clone(), edges, size }
    }

    /// The boundary without the edges that are covered: at all of some points along them, `reach` \[m\] away on the side
    /// outside the shape (`outside`) or inside, `covered` holds.
    #[must_use]
    pub fn uncovered(mut self, outside: bool, reach: f64, covered: impl Fn(&Vector) -> bool) -> Self {
        let side = if outside { reach } else { -reach };
        self.edges.retain(|edge| {
            COVER_SAMPLES.iter().any(|fraction| {
                let (point, normal) = edge.at(*fraction);
                !covered(&(point + normal * side))
            })
        });
        self
    }

    /// The edges, in no stated order.
    pub(super) fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The nearest point of the boundary as seen from `point` \[m\].
    pub(super) fn closest(&self, point: &Vector) -> Vector {
        let points = self.edges.iter().map(|edge| edge.closest(point).0);
        let nearer = |a: Vector, b: Vector| {
            if (b - point).norm_squared() < (a - point).norm_squared() { b } else { a }
        };
        points.reduce(nearer).unwrap_or(*point)
    }

    /// Length of the boundary \[m\].
    pub fn length(&self) -> f64 {
        self.edges.iter().map(Edge::length).sum()
    }

    /// Nearest surface as seen from `point` \[m\].
    pub fn surface(&self, point: &Vector) -> SurfacePoint {
        self.surface_within(point, ROUND_OFF * self.size)
    }

    /// As [`Boundary::surface`]; distances that differ by less than `tolerance` \[m\] count as equal.
    pub fn surface_within(&self, point: &Vector, tolerance: f64) -> SurfacePoint {
        let nearest: Vec<(f64, Vector)> = self.edges.iter().map(|edge| edge.nearest(point)).collect();
        let distance = nearest.iter().map(|(distance, _)| *distance).fold(f64::INFINITY, f64::min);
        let tied = || nearest.iter().filter(|(d, _)| *d <= distance + tolerance).map(|(_, normal)| *normal);
        let (normal, at_vertex) = joined::<Plane, _>(tied);
        let sign = if self.shape.contains(point) { -1.0 } else { 1.0 };
        SurfacePoint { distance: sign * distance, normal, at_vertex }
    }
}

/// The normal of equally near faces of the given normals, of which there may be none, and whether they meet at a corner.
pub(super) fn joined<S: Space, N: Iterator<Item = S::Vector>>(tied: impl Fn() -> N) -> (S::Vector, bool) {
    let first = tied().next().unwrap_or_else(S::Vector::zeros);
    // Opposite faces, as of a thin plate, share the line of their normals: either serves.
    let opposite = |normal: &S::Vector| first.dot(normal) < -CORNER_ANGLE.cos();
    let smooth = |normal: &S::Vector| first.dot(normal) > CORNER_ANGLE.cos();
    let at_vertex = !tied().all(|normal| opposite(&normal) || smooth(&normal));
    let mean: S::Vector = tied().filter(|normal| at_vertex || smooth(normal)).sum();
    (mean.try_normalize(ROUND_OFF).unwrap_or(first), at_vertex)
}

/// The parts of all edges that have the inside of `shape` on one side only, normals out of it.
fn clipped(shape: &Shape, lists: &[Vec<Edge>], size: f64) -> Vec<Edge> {
    let tolerance = ROUND_OFF * size;
    let boxes: Vec<Vec<(Vector, Vector)>> =
        lists.iter().map(|list| list.iter().map(Edge::bounds).collect()).collect();
    let mut kept = Vec::new();
    let mut cuts = Vec::new();
    for (own, list) in lists.iter().enumerate() {
        for (edge, (lower, upper)) in list.iter().zip(&boxes[own]) {
            cuts.clear();
            cuts.extend([0.0, 1.0]);
            for (other, others) in lists.iter().enumerate().filter(|(other, _)| *other != own) {
                for (candidate, (from, to)) in others.iter().zip(&boxes[other]) {
                    let near = (0..2).all(|axis| {
                        from[axis] <= upper[axis] + tolerance && lower[axis] <= to[axis] + tolerance
                    });
                    if near {
                        edge.cuts(candidate, tolerance, &mut cuts);
                    }
                }
            }
            cuts.retain(|cut| (0.0..=1.0).contains(cut));
            cuts.sort_by(f64::total_cmp);
            for pair in cuts.windows(2) {
                let part = edge.part(pair[0], pair[1]);
                if part.length() <= tolerance {
                    continue;
                }
                let (middle, normal) = part.at(0.5);
                let offset = normal * (SIDE_OFFSET * size).min(0.1 * part.length());
                match (shape.contains(&(middle - offset)), shape.contains(&(middle + offset))) {
                    (true, false) => kept.push(part),
                    (false, true) => kept.push(part.turned_round()),
                    _ => {}
                }
            }
        }
    }
    kept
}
