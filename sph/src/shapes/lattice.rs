//! Particles of shapes on the square lattice.

use super::{Boundary, Shape};
use crate::space::domain::Domain;
use crate::space::{DIMENSIONS, Vector};

/// Sides of a container that have no wall, by axis: the particles beyond are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenSides {
    /// Open toward lower coordinates.
    pub lower: [bool; DIMENSIONS],
    /// Open toward upper coordinates.
    pub upper: [bool; DIMENSIONS],
}

/// A wall particle with its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayerParticle {
    /// Position \[m\].
    pub position: Vector,
    /// Unit normal out of the wall \[-\]; zero where faces meet, see [`crate::setup::WallParticles::normal`].
    pub normal: Vector,
}

/// Lattice points that lie on a face, by round-off on either side of it, count as shifted by this much.
///
/// The two components have an irrational ratio so that no face of simple slope runs along the shift.
fn nudged(point: &Vector, spacing: f64) -> Vector {
    point + Vector::new(1.0, 0.618_033_988_749_895) * (1e-9 * spacing)
}

/// Number of lattice points in the box around `shape` grown by `margin` \[m\]: what a fill has to examine.
///
/// A check before a fill: a spacing that is far too small shows here without the work.
pub fn lattice_points(shape: &Shape, spacing: f64, margin: f64) -> f64 {
    let (lower, upper) = shape.bounds();
    let size = (upper - lower).add_scalar(2.0 * margin) / spacing;
    (size.x.ceil() + 1.0).max(0.0) * (size.y.ceil() + 1.0).max(0.0)
}

/// Lattice points of the box around `shape` grown by `margin` \[m\]: rows upward, within a row along x.
fn lattice(shape: &Shape, spacing: f64, origin: Vector, margin: f64) -> impl Iterator<Item = Vector> {
    let (lower, upper) = shape.bounds();
    let first = (lower.add_scalar(-margin) - origin).map(|d| (d / spacing - 0.5).floor());
    let last = (upper.add_scalar(margin) - origin).map(|d| (d / spacing - 0.5).ceil());
    // Whole numbers below 2^53 are exact as f64, so that the lattice needs no conversions. The count runs from zero: far
    // from the origin k + 1 may be k.
    let count_up = |from: f64, to: f64| {
        std::iter::successors(Some(0.0), |k| Some(k + 1.0))
            .take_while(move |k| *k <= to - from)
            .map(move |k| from + k)
    };
    count_up(first.y, last.y).flat_map(move |row| {
        count_up(first.x, last.x).map(move |column| origin + Vector::new(column + 0.5, row + 0.5) * spacing)
    })
}

/// Positions \[m\] of the lattice points inside `shape`: rows upward, within a row along x.
///
/// The lattice has points at `origin` + (k + 1/2)·`spacing` for whole k. A rectangle whose corner lies at the origin or
/// whole spacings away from it gets round(width/spacing) × round(height/spacing) points.
///
/// ```
/// use sph::shapes::{Shape, fill};
/// use sph::space::Vector;
/// let column = Shape::Rectangle { lower: Vector::zeros(), upper: Vector::new(0.146, 0.292) };
/// assert_eq!(fill(&column, 0.002, Vector::zeros()).len(), 73 * 146);
/// ```
pub fn fill(shape: &Shape, spacing: f64, origin: Vector) -> Vec<Vector> {
    lattice(shape, spacing, origin, 0.0).filter(|point| shape.contains(&nudged(point, spacing))).collect()
}

/// Wall particles around `container` of the given `boundary`: the lattice points outside that lie within `layers`·`spacing` of its surface.
///
/// Normals point into the container. Behind a convex corner of the container the layers end on a circle about it, and
/// normals are zero. Particles beyond the plane of an open side are left out; the walls beside it reach up to it.
pub fn layers_around(
    container: &Shape,
    boundary: &Boundary,
    spacing: f64,
    layers: u32,
    origin: Vector,
    open: OpenSides,
) -> Vec<LayerParticle> {
    let thickness = f64::from(layers) * spacing;
    let (lower, upper) = container.bounds();
    let beyond_open_side = |point: &Vector| {
        (0..DIMENSIONS).any(|axis| {
            (open.lower[axis] && point[axis] < lower[axis])
                || (open.upper[axis] && point[axis] >= upper[axis])
        })
    };
    lattice(container, spacing, origin, thickness)
        .filter(|point| {
            let point = nudged(point, spacing);
            !container.contains(&point) && !beyond_open_side(&point)
        })
        .filter_map(|position| {
            let (distance, outward) = face_normal(boundary, &position, spacing);
            // A layer ends half a spacing short of its thickness; the slack only absorbs round-off.
            (distance < thickness + 1e-6 * spacing).then_some(LayerParticle { position, normal: -outward })
        })
        .collect()
}

/// Wall particles that fill `shape` of the given `boundary`, a solid wall; normals point out of its nearest face.
pub fn wall_fill(shape: &Shape, boundary: &Boundary, spacing: f64, origin: Vector) -> Vec<LayerParticle> {
    fill(shape, spacing, origin)
        .into_iter()
        .map(|position| {
            let (_, normal) = face_normal(boundary, &position, spacing);
            LayerParticle { position, normal }
        })
        .collect()
}

/// Distance of `position` from the surface and outward normal of the nearest face, zero where faces meet.
pub(super) fn face_normal(boundary: &Boundary, position: &Vector, spacing: f64) -> (f64, Vector) {
    let nearest = boundary.surface_within(position, 1e-6 * spacing);
    let normal = if nearest.at_vertex { Vector::zeros() } else { nearest.normal };
    (nearest.distance.abs(), normal)
}

/// Moves every position by a random displacement, uniform in [−amplitude, amplitude] \[m\] along each axis.
///
/// The same `seed` gives the same displacements in every version: they come from SplitMix64 (Steele, Lea & Flood
/// 2014), x before y, position by position, the upper 53 bits of each output as a fraction. Positions are wrapped along
/// the domain's periodic directions.
pub fn displace(positions: &mut [Vector], amplitude: f64, seed: u64, domain: &Domain) {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        // Exact: 53 bits fit the mantissa.
        let fraction = (bits >> 11) as f64 / (1_u64 << 53) as f64;
        amplitude * (2.0 * fraction - 1.0)
    };
    for position in positions {
        let x = next();
        let y = next();
        *position = domain.wrapped(&(*position + Vector::new(x, y)));
    }
}
