//! The faces of a shape in space together.

pub(crate) mod box_rows;
mod curves;
pub(crate) mod layers;

use nalgebra::Vector3;

use super::SpatialShape;
use super::face::{Face, Near};
use super::frame::Frame;
use crate::shapes::boundary::{ROUND_OFF, SIDE_OFFSET, joined};
use crate::shapes::{Faces, Moments, Region, SurfacePoint};
use crate::space::Spatial;
use curves::Curves;
use layers::Layers;

/// The faces of a shape in space.
///
/// Distances of shapes that are not composed are exact. Of composed ones the nearest point is that of a face, where
/// nothing covers it, or of a curve in which two faces meet, or a corner of three. Curves and corners are sought by
/// sampling the faces: those that are smaller than a sixty-fourth of the face and of the whole shape may be missed. A part
/// that is a surface of triangles counts as one face: where its nearest point is covered, only curves and corners are
/// considered of it, no second nearest place.
#[derive(Clone, Debug)]
pub struct SpatialBoundary {
    shape: SpatialShape,
    faces: Vec<Face>,
    /// Whether each face is left out; empty where none is.
    covered: Vec<bool>,
    size: f64,
    curves: Curves,
}

/// Samples along the diagonal of the shape by which it is examined whether something covers a face.
const COVER_SAMPLES: f64 = 48.0;

/// A place where the boundary may be nearest.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    point: Vector3<f64>,
    distance: f64,
    normal: Vector3<f64>,
}

impl SpatialBoundary {
    /// The faces of `shape`.
    pub fn new(shape: &SpatialShape) -> Self {
        let (lower, upper) = shape.bounds();
        let mut faces = Vec::new();
        shape.faces(&Frame::default(), &mut faces);
        let size = (upper - lower).norm();
        let curves = Curves::default();
        let mut boundary = Self { shape: shape.clone(), faces, covered: Vec::new(), size, curves };
        if shape.is_composed() && size.is_finite() {
            boundary.curves = Curves::of(&boundary, &((lower + upper) * 0.5));
        }
        boundary
    }

    /// The boundary without the faces that are covered: at all of some points on them, `reach` \[m\] away on the side outside
    /// the shape (`outside`) or inside, `covered` holds.
    #[must_use]
    pub fn uncovered(mut self, outside: bool, reach: f64, covered: impl Fn(&Vector3<f64>) -> bool) -> Self {
        let (lower, upper) = self.bounds();
        let (middle, half) = ((lower + upper) * 0.5, 0.5 * self.size);
        let side = if outside { reach } else { -reach };
        let is_covered = |face: &Face| {
            let (points, _) = face.samples(self.size / COVER_SAMPLES, &middle, half);
            // What other parts of the shape cover is no place of its boundary.
            let mut normals = points.iter().filter_map(|x| {
                let normal = face.nearest(x).normal;
                Some((x, normal * self.outward(x, &normal)?))
            });
            let mut any = false;
            normals.all(|(x, normal)| {
                any = true;
                covered(&(x + normal * side))
            }) && any
        };
        self.covered = self.faces.iter().map(is_covered).collect();
        self
    }

    /// Whether face `k` counts.
    pub(super) fn is_left_out(&self, k: usize) -> bool {
        self.covered.get(k).copied().unwrap_or(false)
    }

    pub(super) fn shape(&self) -> &SpatialShape {
        &self.shape
    }

    pub(super) fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Diagonal of the box around the shape \[m\].
    pub(super) fn size(&self) -> f64 {
        self.size
    }

    /// The sign that turns `normal` of a face at its point `x` out of the shape; `None` where another part covers it.
    pub(super) fn outward(&self, x: &Vector3<f64>, normal: &Vector3<f64>) -> Option<f64> {
        let step = SIDE_OFFSET * self.size;
        // Beside the point too: on the edge of a face containment on its two sides may be the same by the half-open rule.
        let across = if normal.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
        let a = normal.cross(&across).normalize();
        let b = normal.cross(&a);
        let beside = [Vector3::zeros(), a + b, a - b, b - a, -a - b];
        beside.iter().find_map(|side| {
            let at = x + side * (2.0 * step);
            let [below, above] = [-step, step].map(|k| self.shape.contains(&(at + normal * k)));
            (below != above).then_some(if below { 1.0 } else { -1.0 })
        })
    }

    /// Lower and upper corner \[m\] of the box around the shape.
    pub(super) fn bounds(&self) -> (Vector3<f64>, Vector3<f64>) {
        self.shape.bounds()
    }

    /// Distance \[m\] from the surface, negative inside, and the direction in which it increases.
    pub(super) fn slope(&self, x: &Vector3<f64>) -> (f64, Vector3<f64>) {
        let near = self.candidates(x, 0.0);
        let Some(near) = near.iter().min_by(|a, b| a.distance.total_cmp(&b.distance)) else {
            return (f64::INFINITY, Vector3::zeros());
        };
        let sign = if self.shape.contains(x) { -1.0 } else { 1.0 };
        let up = (x - near.point).try_normalize(ROUND_OFF * self.size);
        (sign * near.distance, up.map_or(near.normal, |up| up * sign))
    }

    /// Places of the boundary that may be nearest to `point`, the nearest among them.
    fn candidates(&self, point: &Vector3<f64>, tolerance: f64) -> Vec<Candidate> {
        let far = |x: &Vector3<f64>| (x - point).norm();
        let near: Vec<(f64, Near)> = self
            .faces
            .iter()
            .map(|face| face.nearest_within(point, tolerance))
            .enumerate()
            .map(|(k, near)| (if self.is_left_out(k) { f64::INFINITY } else { far(&near.point) }, near))
            .collect();
        let mut found = Vec::new();
        let add = |distance: f64, near: &Near, sign: f64, found: &mut Vec<Candidate>| {
            if near.undecided {
                found.push(Candidate { point: near.point, distance, normal: Vector3::zeros() });
            } else {
                found.push(Candidate { point: near.point, distance, normal: near.normal * sign });
                found.push(Candidate { point: near.point, distance, normal: near.opposite * sign });
            }
        };
        if !self.shape.is_composed() {
            let counts = near.iter().filter(|(distance, _)| distance.is_finite());
            counts.for_each(|(distance, near)| add(*distance, near, 1.0, &mut found));
            return found;
        }
        let mut order: Vec<usize> = (0..near.len()).collect();
        order.sort_by(|&a, &b| near[a].0.total_cmp(&near[b].0));
        let mut nearest = f64::INFINITY;
        for (distance, near) in order.into_iter().map(|k| &near[k]) {
            if *distance > nearest + tolerance || !distance.is_finite() {
                break;
            }
            if let Some(sign) = self.outward(&near.point, &near.normal) {
                nearest = nearest.min(*distance);
                add(*distance, near, sign, &mut found);
            }
        }
        let distances: Vec<f64> = near.iter().map(|(distance, _)| *distance).collect();
        if let Some(place) = self.curves.nearest(self, point, &distances, nearest) {
            let distance = far(&place.point);
            found.extend(place.normals().map(|normal| Candidate { point: place.point, distance, normal }));
        }
        found
    }
}

impl Faces<Spatial> for SpatialBoundary {
    fn surface(&self, point: &Vector3<f64>) -> SurfacePoint<Spatial> {
        self.surface_within(point, ROUND_OFF * self.size)
    }

    fn surface_within(&self, point: &Vector3<f64>, tolerance: f64) -> SurfacePoint<Spatial> {
        let nearest = self.candidates(point, tolerance);
        let distance = nearest.iter().map(|near| near.distance).fold(f64::INFINITY, f64::min);
        let tied = || nearest.iter().filter(|near| near.distance <= distance + tolerance);
        let (normal, at_vertex) = joined::<Spatial, _>(|| tied().map(|near| near.normal));
        let sign = if self.shape.contains(point) { -1.0 } else { 1.0 };
        SurfacePoint { distance: sign * distance, normal, at_vertex }
    }

    fn layers_within(&self, depth: f64, along: f64, layers: u32) -> Vec<Vector3<f64>> {
        self.layers(Layers { side: -1.0, depth, along, count: layers }, &[], |_| true)
    }

    fn moments(&self) -> Moments<Spatial> {
        self.moments_of_shape()
    }
}
