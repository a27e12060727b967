//! Particles of shapes on the square (cubic) lattice.

use super::region::{Faces, LayerParticle, OpenSides, Region};
use crate::random::SplitMix64;
use crate::space::Space;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::tasks;

/// Components of the shift of points on faces: their ratios are irrational so that no face of simple slope runs along it.
const SHIFT: [f64; 3] = [1.0, 0.618_033_988_749_895, 0.414_213_562_373_095];

/// Fewer lattice points than this are examined on one thread.
const FEW: f64 = 20_000.0;

/// Lattice points that lie on a face, by round-off on either side of it, count as shifted by this much.
pub(super) fn nudged<S: Space>(point: &S::Vector, spacing: f64) -> S::Vector {
    *point + S::vector(S::axes(|axis| SHIFT[axis])) * (1e-9 * spacing)
}

/// Number of lattice points in the box around `shape` grown by `margin` \[m\]: what a fill has to examine.
///
/// A check before a fill: a spacing that is far too small shows here without the work.
pub fn lattice_points<S: Space, R: Region<S>>(shape: &R, spacing: f64, margin: f64) -> f64 {
    let (lower, upper) = shape.bounds();
    let size = ((upper - lower) + S::Vector::repeat(2.0 * margin)) / spacing;
    (0..S::DIMENSIONS).map(|axis| (size[axis].ceil() + 1.0).max(0.0)).product()
}

/// The lattice points of a box.
pub(super) struct Lattice<S: Space> {
    origin: S::Vector,
    spacing: f64,
    first: S::Vector,
    /// Largest count along each axis, from zero: far from the origin k + 1 may be k.
    last: S::Vector,
}

impl<S: Space> Lattice<S> {
    /// Those of the box from `lower` to `upper` \[m\] and the next beyond.
    pub(super) fn around((lower, upper): (S::Vector, S::Vector), spacing: f64, origin: S::Vector) -> Self {
        let rows = |x: S::Vector, axis: usize| (x - origin)[axis] / spacing - 0.5;
        let first = S::vector(S::axes(|axis| rows(lower, axis).floor()));
        let last = S::vector(S::axes(|axis| rows(upper, axis).ceil()));
        Self { origin, spacing, first, last: last - first }
    }

    /// Points that `found` makes something of: layers and rows upward, within a row along x; none of an infinite box.
    pub(super) fn filter_map<T: Send>(&self, found: impl Fn(S::Vector) -> Option<T> + Sync) -> Vec<T> {
        let axes = 0..S::DIMENSIONS;
        // Whole numbers below 2^53 are exact as f64, so that the lattice needs no conversions.
        let counts = |axis: usize| {
            std::iter::successors(Some(0.0), |k| Some(k + 1.0)).take_while(move |k| *k <= self.last[axis])
        };
        if !axes.clone().all(|axis| self.last[axis].is_finite()) {
            return Vec::new();
        }
        let slice = |outer: f64| self.slice(outer, &found);
        if axes.map(|axis| self.last[axis] + 1.0).product::<f64>() < FEW {
            return counts(S::DIMENSIONS - 1).flat_map(slice).collect();
        }
        let slices: Vec<f64> = counts(S::DIMENSIONS - 1).collect();
        tasks::flat_map(slices.len(), 1, |k| slice(slices[k]))
    }

    /// The points with the count `outer` along the last axis.
    fn slice<'a, T>(
        &'a self,
        outer: f64,
        found: &'a impl Fn(S::Vector) -> Option<T>,
    ) -> impl Iterator<Item = T> + 'a {
        let inner = S::DIMENSIONS - 1;
        let mut next = S::Vector::zeros();
        next[inner] = outer;
        let mut more = (0..inner).all(|axis| self.last[axis] >= 0.0);
        std::iter::from_fn(move || {
            while more {
                let count = next;
                // Counts up like a number whose digits are the axes.
                more = (0..inner).any(|axis| {
                    next[axis] += 1.0;
                    let carried = next[axis] > self.last[axis];
                    if carried {
                        next[axis] = 0.0;
                    }
                    !carried
                });
                let place = S::vector(S::axes(|axis| self.first[axis] + count[axis] + 0.5));
                let found = found(self.origin + place * self.spacing);
                if found.is_some() {
                    return found;
                }
            }
            None
        })
    }
}

/// Positions \[m\] of the lattice points inside `shape`: layers and rows upward, within a row along x.
///
/// The lattice has points at `origin` + (k + 1/2)·`spacing` for whole k. A rectangle whose corner lies at the origin or
/// whole spacings away from it gets round(width/spacing) × round(height/spacing) points, a box likewise. An unbounded shape
/// gets none.
///
/// ```
/// use sph::shapes::{Shape, fill};
/// use sph::space::Vector;
/// let column = Shape::Rectangle { lower: Vector::zeros(), upper: Vector::new(0.146, 0.292) };
/// assert_eq!(fill(&column, 0.002, Vector::zeros()).len(), 73 * 146);
/// ```
pub fn fill<S: Space, R: Region<S>>(shape: &R, spacing: f64, origin: S::Vector) -> Vec<S::Vector> {
    Lattice::<S>::around(shape.bounds(), spacing, origin)
        .filter_map(|point| shape.contains(&nudged::<S>(&point, spacing)).then_some(point))
}

/// Wall particles around `container` of the given `boundary`: the lattice points outside that lie within `layers`·`spacing` of its surface.
///
/// Normals point into the container. Behind a convex corner of the container the layers end on a circle (sphere) about it,
/// and normals are zero; so they are behind an edge in space. Particles beyond the plane of an open side are left out; the
/// walls beside it reach up to it.
pub fn layers_around<S: Space, R: Region<S>>(
    container: &R,
    boundary: &R::Boundary,
    spacing: f64,
    layers: u32,
    origin: S::Vector,
    open: OpenSides<S>,
) -> Vec<LayerParticle<S>> {
    let thickness = f64::from(layers) * spacing;
    let (lower, upper) = container.bounds();
    let beyond_open_side = |point: &S::Vector| {
        (0..S::DIMENSIONS).any(|axis| {
            (open.lower[axis] && point[axis] < lower[axis])
                || (open.upper[axis] && point[axis] >= upper[axis])
        })
    };
    let margin = S::Vector::repeat(thickness);
    Lattice::<S>::around((lower - margin, upper + margin), spacing, origin).filter_map(|position| {
        let point = nudged::<S>(&position, spacing);
        if container.contains(&point) || beyond_open_side(&point) {
            return None;
        }
        let (distance, outward) = face_normal(boundary, &position, spacing);
        // A layer ends half a spacing short of its thickness; the slack only absorbs round-off.
        (distance < thickness + 1e-6 * spacing).then_some(LayerParticle { position, normal: -outward })
    })
}

/// Wall particles that fill `shape` of the given `boundary`, a solid wall; normals point out of its nearest face.
pub fn wall_fill<S: Space, R: Region<S>>(
    shape: &R,
    boundary: &R::Boundary,
    spacing: f64,
    origin: S::Vector,
) -> Vec<LayerParticle<S>> {
    Lattice::<S>::around(shape.bounds(), spacing, origin).filter_map(|position| {
        shape.contains(&nudged::<S>(&position, spacing)).then(|| {
            let (_, normal) = face_normal(boundary, &position, spacing);
            LayerParticle { position, normal }
        })
    })
}

/// Distance of `position` from the surface and outward normal of the nearest face, zero where faces meet.
pub(super) fn face_normal<S: Space>(
    boundary: &impl Faces<S>,
    position: &S::Vector,
    spacing: f64,
) -> (f64, S::Vector) {
    let nearest = boundary.surface_within(position, 1e-6 * spacing);
    let normal = if nearest.at_vertex { S::Vector::zeros() } else { nearest.normal };
    (nearest.distance.abs(), normal)
}

/// Moves every position by a random displacement, uniform in [−amplitude, amplitude] \[m\] along each axis.
///
/// The same `seed` gives the same displacements in every version: they come from SplitMix64 (Steele, Lea & Flood
/// 2014), axis by axis, position by position, the upper 53 bits of each output as a fraction. Positions are wrapped along
/// the domain's periodic directions.
pub fn displace<S: Space>(positions: &mut [S::Vector], amplitude: f64, seed: u64, domain: &Domain<S>) {
    let mut random = SplitMix64(seed);
    for position in positions {
        let by = S::vector(S::axes(|_| amplitude * random.symmetric()));
        *position = domain.wrapped(&(*position + by));
    }
}
