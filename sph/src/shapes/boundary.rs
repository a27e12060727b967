//! Exact boundaries of shapes: straight and circular edges, clipped where shapes overlap.

use std::f64::consts::{PI, TAU};

use super::{Shape, edges_of};
use crate::space::{Vector, cross};

crate::constants! {
    /// A curve drawn with many short edges has normals everywhere; a bend of a right angle has none at its vertex.
    pub const CORNER_ANGLE: f64 = PI / 6.0, "fitted.corner_angle",
        "angle between the normals of two faces below which they meet smoothly, in radians";
}

/// Lengths below this fraction of the shape's diagonal are round-off.
const ROUND_OFF: f64 = 1e-9;

/// How far beside an edge its two sides are examined, as a fraction of the shape's diagonal.
const SIDE_OFFSET: f64 = 1e-7;

/// Where along an edge it is examined whether something covers it.
const COVER_SAMPLES: [f64; 9] = [0.02, 0.14, 0.26, 0.38, 0.5, 0.62, 0.74, 0.86, 0.98];

/// The nearest surface of a shape as seen from a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Distance to the surface \[m\], negative inside.
    pub distance: f64,
    /// Unit normal of the nearest face, out of the shape; at a vertex the mean of the faces that meet.
    pub normal: Vector,
    /// Whether the nearest feature is a corner: faces whose normals differ are equally near.
    pub at_vertex: bool,
}

/// The boundary of a shape as edges that bear its outward normal.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    shape: Shape,
    edges: Vec<Edge>,
    size: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Edge {
    Segment {
        start: Vector,
        end: Vector,
        normal: Vector,
    },
    Arc {
        centre: Vector,
        radius: f64,
        /// Angle at which the arc begins; it runs counter-clockwise.
        begin: f64,
        sweep: f64,
        /// 1 when the shape lies on the centre's side, −1 when it lies outside.
        outward: f64,
    },
}

impl Edge {
    fn segment(start: Vector, end: Vector) -> Self {
        let along = end - start;
        let normal = Vector::new(along.y, -along.x) / along.norm();
        Self::Segment { start, end, normal }
    }

    fn circle(centre: Vector, radius: f64, outward: f64) -> Self {
        Self::Arc { centre, radius, begin: 0.0, sweep: TAU, outward }
    }

    fn turned_round(self) -> Self {
        match self {
            Self::Segment { start, end, normal } => Self::Segment { start, end, normal: -normal },
            Self::Arc { centre, radius, begin, sweep, outward } => {
                Self::Arc { centre, radius, begin, sweep, outward: -outward }
            }
        }
    }

    /// Point at a fraction of the way along the edge, and the outward normal there.
    pub(super) fn at(&self, fraction: f64) -> (Vector, Vector) {
        match *self {
            Self::Segment { start, end, normal } => (start + (end - start) * fraction, normal),
            Self::Arc { centre, radius, begin, sweep, outward } => {
                let direction = direction_of(begin + fraction * sweep);
                (centre + direction * radius, direction * outward)
            }
        }
    }

    pub(super) fn length(&self) -> f64 {
        match *self {
            Self::Segment { start, end, .. } => (end - start).norm(),
            Self::Arc { radius, sweep, .. } => radius * sweep,
        }
    }

    /// The part between two fractions of the way along.
    fn part(&self, from: f64, to: f64) -> Self {
        match *self {
            Self::Segment { start, end, normal } => {
                let along = end - start;
                Self::Segment { start: start + along * from, end: start + along * to, normal }
            }
            Self::Arc { centre, radius, begin, sweep, outward } => {
                Self::Arc { centre, radius, begin: begin + from * sweep, sweep: (to - from) * sweep, outward }
            }
        }
    }

    /// Distance of `point` from its nearest point of the edge, and the outward normal there.
    ///
    /// From the centre of an arc no direction is nearer than another: the normal is zero.
    fn nearest(&self, point: &Vector) -> (f64, Vector) {
        match *self {
            Self::Segment { start, end, normal } => {
                let along = end - start;
                let fraction = ((point - start).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                ((point - (start + along * fraction)).norm(), normal)
            }
            Self::Arc { centre, radius, begin, sweep, outward } => {
                let from_centre = point - centre;
                let distance = from_centre.norm();
                if distance <= ROUND_OFF * radius {
                    return (radius, Vector::zeros());
                }
                let angle = (from_centre.y.atan2(from_centre.x) - begin).rem_euclid(TAU);
                if angle <= sweep {
                    return ((distance - radius).abs(), from_centre / distance * outward);
                }
                let fraction = if angle - sweep < TAU - angle { 1.0 } else { 0.0 };
                let (end, normal) = self.at(fraction);
                ((point - end).norm(), normal)
            }
        }
    }

    /// Fractions at which `other` crosses, touches or ends on this edge; `tolerance` \[m\] decides what touches.
    fn cuts(&self, other: &Self, tolerance: f64, cuts: &mut Vec<f64>) {
        for (end, _) in [other.at(0.0), other.at(1.0)] {
            self.cut_at(&end, tolerance, cuts);
        }
        match (*self, *other) {
            (Self::Segment { start, end, .. }, Self::Segment { start: a, end: b, .. }) => {
                let (along, across) = (end - start, b - a);
                let determinant = cross(&along, &across);
                // Parallel edges meet at their ends only, which are dealt with above.
                if determinant.abs() > f64::EPSILON * along.norm() * across.norm() {
                    let fraction = cross(&(a - start), &across) / determinant;
                    let beside = cross(&(a - start), &along) / determinant;
                    if (0.0..=1.0).contains(&beside) {
                        cuts.push(fraction);
                    }
                }
            }
            (Self::Segment { start, end, .. }, Self::Arc { centre, radius, .. })
            | (Self::Arc { centre, radius, .. }, Self::Segment { start, end, .. }) => {
                let along = (end - start).normalize();
                let middle = start + along * (centre - start).dot(&along);
                let off_centre = (centre - middle).norm();
                if off_centre <= radius + tolerance {
                    // Where line and circle only touch, both points are the middle.
                    let half = along * (radius * radius - off_centre * off_centre).max(0.0).sqrt();
                    for point in [middle - half, middle, middle + half] {
                        if other.nearest(&point).0 <= tolerance {
                            self.cut_at(&point, tolerance, cuts);
                        }
                    }
                }
            }
            (Self::Arc { centre: a, radius: r, .. }, Self::Arc { centre: b, radius: s, .. }) => {
                let between = b - a;
                let distance = between.norm();
                if distance > tolerance
                    && distance <= r + s + tolerance
                    && distance >= (r - s).abs() - tolerance
                {
                    let along = (distance * distance + r * r - s * s) / (2.0 * distance);
                    let half = (r * r - along * along).max(0.0).sqrt();
                    let unit = between / distance;
                    let beside = Vector::new(-unit.y, unit.x) * half;
                    for point in [a + unit * along - beside, a + unit * along, a + unit * along + beside] {
                        self.cut_at(&point, tolerance, cuts);
                    }
                }
            }
        }
    }

    /// Adds the fraction at which `point` lies when it lies on this edge.
    fn cut_at(&self, point: &Vector, tolerance: f64, cuts: &mut Vec<f64>) {
        if self.nearest(point).0 > tolerance {
            return;
        }
        match *self {
            Self::Segment { start, end, .. } => {
                let along = end - start;
                cuts.push((point - start).dot(&along) / along.norm_squared());
            }
            Self::Arc { centre, begin, sweep, .. } => {
                let from_centre = point - centre;
                let angle = (from_centre.y.atan2(from_centre.x) - begin).rem_euclid(TAU);
                cuts.push(angle / sweep);
            }
        }
    }

    /// Points from one end to the other with the shape on the left, arcs in chords of at most `chord` \[m\].
    pub(super) fn traced(&self, chord: f64) -> Vec<Vector> {
        let (pieces, shape_on_left) = match *self {
            Self::Segment { start, end, normal } => (1.0, cross(&normal, &(end - start)) > 0.0),
            // In fours: the chords of a circle are its own mirror images.
            Self::Arc { outward, .. } => {
                (4.0 * (0.25 * self.length() / chord).ceil().max(3.0), outward > 0.0)
            }
        };
        let fractions = std::iter::successors(Some(0.0), |k| Some(k + 1.0)).take_while(|k| *k <= pieces);
        let mut points: Vec<Vector> = fractions.map(|k| self.at(k / pieces).0).collect();
        if !shape_on_left {
            points.reverse();
        }
        points
    }

    /// Box around the edge or more.
    fn bounds(&self) -> (Vector, Vector) {
        match *self {
            Self::Segment { start, end, .. } => (start.inf(&end), start.sup(&end)),
            Self::Arc { centre, radius, .. } => {
                (centre - Vector::repeat(radius), centre + Vector::repeat(radius))
            }
        }
    }
}

fn direction_of(angle: f64) -> Vector {
    Vector::new(angle.cos(), angle.sin())
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
        let first = tied().next().unwrap_or_else(Vector::zeros);
        // Opposite faces, as of a thin plate, share the line of their normals: either serves.
        let opposite = |normal: &Vector| first.dot(normal) < -CORNER_ANGLE.cos();
        let smooth = |normal: &Vector| first.dot(normal) > CORNER_ANGLE.cos();
        let at_vertex = !tied().all(|normal| opposite(&normal) || smooth(&normal));
        let mean: Vector = tied().filter(|normal| at_vertex || smooth(normal)).sum();
        let normal = mean.try_normalize(ROUND_OFF).unwrap_or(first);
        let sign = if self.shape.contains(point) { -1.0 } else { 1.0 };
        SurfacePoint { distance: sign * distance, normal, at_vertex }
    }
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
