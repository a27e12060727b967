//! Faces of the shapes in space that others are made of, with their nearest points.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{Vector2, Vector3};

use super::frame::Frame;
use crate::shapes::boundary::CORNER_ANGLE;
use crate::shapes::boundary::Edge;
use crate::shapes::{Boundary, Shape, Surface};

/// Distances from an axis below this fraction of the size of a face are round-off.
const ON_AXIS: f64 = 1e-9;

/// Fewest and most samples of a face along one of its directions.
const FEWEST: f64 = 8.0;
const MOST: f64 = 64.0;

/// A face, with the normal out of the shape it was made for.
#[derive(Clone, Debug)]
pub(super) struct Face {
    pub frame: Frame,
    pub form: Form,
}

/// A face in its own coordinates.
#[derive(Clone, Debug)]
pub(super) enum Form {
    /// A region of the plane z = height; the normal is `outward` along z.
    Cap { section: Arc<(Shape, Boundary)>, height: f64, outward: f64 },
    /// What an edge passes over that moves along z from 0 to `height`.
    Swept { edge: Edge, height: f64 },
    /// What an edge of the half-plane of distances from the z axis and heights passes over that turns about this axis.
    Turned { edge: Edge },
    /// The plane z = 0 with the normal along z.
    Plane,
    /// A surface of triangles.
    Triangles(Arc<Surface>),
}

/// The nearest point of a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub point: Vector3<f64>,
    /// Outward unit normal there.
    pub normal: Vector3<f64>,
    /// At the tip of a cone the normal opposite, else the same.
    pub opposite: Vector3<f64>,
    /// Whether no direction is nearer than another, as from the axis of a cylinder.
    pub undecided: bool,
}

impl Near {
    fn smooth(point: Vector3<f64>, normal: Vector3<f64>) -> Self {
        Self { point, normal, opposite: normal, undecided: false }
    }
}

impl Face {
    /// The nearest point of the face as seen from `point`; of triangles, those that are at most `tolerance` \[m\] farther count as
    /// equally near.
    pub fn nearest_within(&self, point: &Vector3<f64>, tolerance: f64) -> Near {
        let near = self.form.nearest(&self.frame.local(point), tolerance);
        Near {
            point: self.frame.point(&near.point),
            normal: self.frame.vector(&near.normal),
            opposite: self.frame.vector(&near.opposite),
            undecided: near.undecided,
        }
    }

    /// As [`Face::nearest_within`], of one triangle.
    pub fn nearest(&self, point: &Vector3<f64>) -> Near {
        self.nearest_within(point, 0.0)
    }

    /// Points of the face about `step` apart, and the largest distance of neighbouring ones; those of a plane within
    /// `reach` of `middle`.
    pub fn samples(&self, step: f64, middle: &Vector3<f64>, reach: f64) -> (Vec<Vector3<f64>>, f64) {
        let (mut points, apart) = self.form.samples(step, &self.frame.local(middle), reach);
        points.iter_mut().for_each(|x| *x = self.frame.point(x));
        (points, apart)
    }
}

impl Form {
    fn nearest(&self, x: &Vector3<f64>, tolerance: f64) -> Near {
        let plane = x.xy();
        match self {
            Self::Cap { section, height, outward } => {
                let (shape, outline) = section.as_ref();
                let at = if shape.contains(&plane) { plane } else { outline.closest(&plane) };
                Near::smooth(at.push(*height), Vector3::z() * *outward)
            }
            Self::Swept { edge, height } => {
                let near = edge.closest(&plane);
                let undecided = near.1 == Vector2::zeros();
                let normal = if undecided { edge.at(0.5).1 } else { near.1 };
                let smooth = Near::smooth(near.0.push(x.z.clamp(0.0, *height)), normal.push(0.0));
                Near { undecided, ..smooth }
            }
            Self::Turned { edge } => turned(edge, x),
            Self::Plane => Near::smooth(plane.push(0.0), Vector3::z()),
            Self::Triangles(surface) => of_triangles(surface, x, tolerance),
        }
    }

    fn samples(&self, step: f64, middle: &Vector3<f64>, reach: f64) -> (Vec<Vector3<f64>>, f64) {
        let pieces = |length: f64| (length / step).ceil().clamp(FEWEST, MOST);
        let grid = |size: [f64; 2], at: &dyn Fn(f64, f64) -> Option<Vector3<f64>>| {
            let counts = size.map(pieces);
            let points =
                steps(counts[0]).flat_map(|u| steps(counts[1]).filter_map(move |v| at(u, v))).collect();
            (points, (size[0] / counts[0]).hypot(size[1] / counts[1]))
        };
        match self {
            Self::Cap { section, height, .. } => {
                let (lower, upper) = section.0.bounds();
                let size = upper - lower;
                grid([size.x, size.y], &|u, v| {
                    let x = lower + Vector2::new(u * size.x, v * size.y);
                    section.0.contains(&x).then(|| x.push(*height))
                })
            }
            Self::Swept { edge, height } => {
                grid([edge.length(), *height], &|u, v| Some(edge.at(u).0.push(v * height)))
            }
            Self::Turned { edge } => {
                let largest = steps(MOST).map(|u| edge.at(u).0.x).fold(0.0, f64::max);
                grid([edge.length(), TAU * largest], &|u, v| {
                    let (at, (sin, cos)) = (edge.at(u).0, (v * TAU).sin_cos());
                    Some(Vector3::new(cos * at.x, sin * at.x, at.y))
                })
            }
            Self::Plane => grid([2.0 * reach; 2], &|u, v| {
                Some((middle.xy() + Vector2::new(2.0 * u - 1.0, 2.0 * v - 1.0) * reach).push(0.0))
            }),
            Self::Triangles(surface) => (surface.samples(step), step),
        }
    }
}

/// 0 to 1 in `count` steps.
fn steps(count: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(0.0), |k| Some(k + 1.0))
        .take_while(move |k| *k <= count)
        .map(move |k| k / count)
}

/// The nearest point as seen from `x` of what `edge` passes over that turns about the z axis.
///
/// It lies in the half-plane of `x`: elsewhere on the same circle points are farther.
fn turned(edge: &Edge, x: &Vector3<f64>) -> Near {
    let plane = x.xy();
    let radius = plane.norm();
    let (at, mut normal) = edge.closest(&Vector2::new(radius, x.z));
    let mut undecided = normal == Vector2::zeros();
    if undecided {
        normal = edge.at(0.5).1;
    }
    let outward = if radius > 0.0 { plane / radius } else { Vector2::x() };
    let place = |r: f64, z: f64| Vector3::new(outward.x * r, outward.y * r, z);
    let on_axis = |r: f64| r <= ON_AXIS * (at.x.abs() + edge.length());
    let tip = on_axis(at.x);
    undecided |= !tip && on_axis(radius) && normal.x != 0.0;
    let point = place(at.x, at.y);
    let own = place(normal.x, normal.y);
    let opposite = if tip { place(-normal.x, normal.y) } else { own };
    Near { point, normal: own, opposite, undecided }
}

/// The nearest point of `surface` as seen from `x`; where facets meet at an edge that is no smooth bend, their normals.
fn of_triangles(surface: &Surface, x: &Vector3<f64>, tolerance: f64) -> Near {
    let foot = surface.nearest(x);
    let normals = surface.normals_within(x, (foot.point - x).norm(), tolerance);
    let bent = |normal: &&Vector3<f64>| normal.dot(&foot.normal) < (0.5 * CORNER_ANGLE).cos();
    // A facet far from the mean, and the one farthest from that.
    let Some(first) = normals.iter().find(bent) else { return Near::smooth(foot.point, foot.normal) };
    let farthest = normals.iter().min_by(|a, b| a.dot(first).total_cmp(&b.dot(first)));
    Near { point: foot.point, normal: *first, opposite: *farthest.unwrap_or(first), undecided: false }
}
