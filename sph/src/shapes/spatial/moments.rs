//! Volume and moments of shapes in space.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use super::SpatialShape;
use super::face::Form;
use super::faces::SpatialBoundary;
use super::frame::Frame;
use crate::shapes::{Faces, Moments, Region, Shape};
use crate::space::{Spatial, Vector};
use crate::tasks;

/// Cubes along the longest side of a composed shape that are measured at first, and halvings of those that its surface
/// crosses.
const COARSE: f64 = 16.0;
const HALVINGS: usize = 4;

/// The same of shapes with surfaces of triangles, whose distances take longer.
const HALVINGS_OF_TRIANGLES: usize = 3;

/// Volume and moments about the origin of the scene.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    volume: f64,
    first: Vector3<f64>,
    second: Matrix3<f64>,
}

impl Sums {
    fn plus(self, other: Self) -> Self {
        Self {
            volume: self.volume + other.volume,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }

    /// Of a cube of `width`, of which `share` counts.
    fn cube(middle: &Vector3<f64>, width: f64, share: f64) -> Self {
        let volume = share * width.powi(3);
        let own = Matrix3::identity() * (width * width / 12.0);
        Self { volume, first: middle * volume, second: (middle * middle.transpose() + own) * volume }
    }
}

/// Moments from ∫ x_a x_b dV about the centroid.
fn moments(volume: f64, centroid: Vector3<f64>, second: &Matrix3<f64>) -> Moments<Spatial> {
    Moments { volume, centroid, second: second.transpose().iter().copied().collect() }
}

/// The moments of a shape given in the coordinates of `frame`, in those of the scene.
fn placed(inner: &Moments<Spatial>, frame: &Frame) -> Moments<Spatial> {
    let turn =
        Matrix3::from_columns(&[Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| frame.vector(&axis)));
    let second = Matrix3::from_row_slice(&inner.second);
    moments(inner.volume, frame.point(&inner.centroid), &(turn * second * turn.transpose()))
}

/// Moments of a section moved along z.
fn extruded(section: &Shape, height: f64) -> Moments<Spatial> {
    let flat = section.boundary().moments();
    let [xx, xy, yy] = [flat.second[0], flat.second[1], flat.second[3]].map(|second| second * height);
    let zz = flat.volume * height.powi(3) / 12.0;
    let second = Matrix3::new(xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, zz);
    moments(flat.volume * height, flat.centroid.push(0.5 * height), &second)
}

/// Moments of a section turned about z, by the divergence theorem in its plane:
///
/// ```text
/// ∫ dV = π ∮ r² n_r ds,  ∫ z dV = π ∮ r² z n_r ds,  ∫ z² dV = π ∮ r² z² n_r ds,  ∫ x² dV = π/4 ∮ r⁴ n_r ds
/// ```
fn revolved(section: &Shape) -> Moments<Spatial> {
    let (lower, upper) = section.bounds();
    // About the middle: no cancellation far from the origin.
    let middle = 0.5 * (lower.y + upper.y);
    let (mut volume, mut first, mut along, mut across) = (0.0, 0.0, 0.0, 0.0);
    section.boundary().integrate(|x: Vector, n: Vector, ds: f64| {
        let (r, z) = (x.x, x.y - middle);
        let part = PI * r * r * n.x * ds;
        volume += part;
        first += part * z;
        along += part * z * z;
        across += part * r * r / 4.0;
    });
    let height = first / volume;
    let second = Matrix3::from_diagonal(&Vector3::new(across, across, along - volume * height * height));
    moments(volume, Vector3::new(0.0, 0.0, middle + height), &second)
}

impl SpatialBoundary {
    /// Exact but for composed shapes.
    ///
    /// These are measured by cubes, ever smaller ones along the surface, down to a 256th of the longest side (a 128th with surfaces of triangles); a cube that
    /// the surface crosses counts by its depth. Errors of volumes are below 1e-4 for parts that measure a quarter of the
    /// whole or more, far below where faces are plane and along the axes.
    pub(super) fn moments_of_shape(&self) -> Moments<Spatial> {
        self.shape_moments(self.shape())
    }

    fn shape_moments(&self, shape: &SpatialShape) -> Moments<Spatial> {
        match shape {
            SpatialShape::Box { lower, upper } => {
                let size = upper - lower;
                let second = Matrix3::from_diagonal(&size.component_mul(&size)) * (size.product() / 12.0);
                moments(size.product(), (lower + upper) * 0.5, &second)
            }
            SpatialShape::Sphere { centre, radius } => {
                let volume = 4.0 / 3.0 * PI * radius.powi(3);
                moments(volume, *centre, &(Matrix3::identity() * (volume * radius * radius / 5.0)))
            }
            SpatialShape::Extrusion { section, frame, height } => placed(&extruded(section, *height), frame),
            SpatialShape::Surface(surface) => surface.moments(),
            SpatialShape::HalfSpace { point, .. } => {
                moments(f64::INFINITY, *point, &Matrix3::repeat(f64::INFINITY))
            }
            SpatialShape::Placed { shape, frame } if !shape.is_composed() => {
                placed(&self.shape_moments(shape), frame)
            }
            _ => match shape.revolved() {
                Some((section, frame)) => placed(&revolved(&section), &frame),
                None => self.measured(),
            },
        }
    }

    fn measured(&self) -> Moments<Spatial> {
        let (lower, upper) = self.shape().bounds();
        let size = upper - lower;
        let width = size.max() / COARSE;
        let middle = (lower + upper) * 0.5;
        if !(width > 0.0 && width.is_finite()) {
            return moments(if width > 0.0 { width } else { 0.0 }, middle, &Matrix3::zeros());
        }
        let counts = size.map(|side| (side / width).ceil());
        let indices = |axis: usize| {
            std::iter::successors(Some(0.0), |k| Some(k + 1.0)).take_while(move |k| *k < counts[axis])
        };
        let cubes: Vec<Vector3<f64>> = indices(2)
            .flat_map(|z| indices(1).flat_map(move |y| indices(0).map(move |x| Vector3::new(x, y, z))))
            .map(|index| index.add_scalar(0.5) * width - counts * (0.5 * width))
            .collect();
        let has_triangles = self.faces().iter().any(|face| matches!(face.form, Form::Triangles(_)));
        let halvings = if has_triangles { HALVINGS_OF_TRIANGLES } else { HALVINGS };
        // Sums in the order of the cubes, whatever the threads.
        let parts: Vec<Sums> = tasks::map(cubes.len(), 1, |k| self.cube(&cubes[k], &middle, width, halvings));
        let sums = parts.into_iter().fold(Sums::default(), Sums::plus);
        if sums.volume <= 0.0 {
            return moments(0.0, middle, &Matrix3::zeros());
        }
        let centroid = sums.first / sums.volume;
        moments(
            sums.volume,
            middle + centroid,
            &(sums.second - centroid * centroid.transpose() * sums.volume),
        )
    }

    /// What lies in the cube around `x`, given from `origin`.
    fn cube(&self, x: &Vector3<f64>, origin: &Vector3<f64>, width: f64, halvings: usize) -> Sums {
        let distance = self.surface(&(origin + x)).distance;
        let half_diagonal = 0.5 * width * 3.0_f64.sqrt();
        if distance >= half_diagonal {
            return Sums::default();
        }
        if distance <= -half_diagonal || halvings == 0 {
            return Sums::cube(x, width, (0.5 - distance / width).clamp(0.0, 1.0));
        }
        let quarter = 0.25 * width;
        (0..8).fold(Sums::default(), |sums, k| {
            let by = Vector3::from_fn(|axis, _| if k >> axis & 1 == 0 { -quarter } else { quarter });
            sums.plus(self.cube(&(x + by), origin, 0.5 * width, halvings - 1))
        })
    }
}
