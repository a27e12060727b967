//! Particles of a shape in layers along its faces.

use super::fitted::layers_within;
use super::packing::{Interior, Packing, Sample};
use super::{Boundary, Shape, fill};
use crate::space::{Plane, Vector};

crate::constants! {
    /// Further inside, a lattice is as good.
    const LAYERS: f64 = 6.0, "packing.layers",
        "layers along the faces of a thick shape; the lattice fills the rest [-]";
    const SAMPLES: f64 = 8.0, "packing.samples",
        "samples along a spacing by which cells are measured [-]";
}

/// Thinner lattices than this inside the layers leave holes, in spacings.
const CORE: f64 = 6.0;

/// Spacings below the layers within which particles of the lattice still move.
const BUFFER: f64 = 3.0;

/// Times that the search for the deepest point halves its step.
const HALVINGS: usize = 24;

/// Steps of work for each particle of [`fill_fitted`], each about a nanosecond.
pub const FITTED_STEPS: f64 = 40_000.0;

/// Particles that fill `shape` in layers along its faces, about `spacing` \[m\] apart, with the volumes of their cells.
///
/// Particles start in layers, in a thin shape as many as fit best across its thickest part, in a thick one with the
/// lattice of [`fill`] further inside, and spread evenly ([`Interior::pack`]). Volume, centroid and second moments of
/// the shape are exact where it has particles enough ([`Packing::match_moments`]).
///
/// ```
/// use sph::shapes::{Shape, fill_fitted};
/// use sph::space::Vector;
/// let ring = Shape::Ring { centre: Vector::zeros(), inner_radius: 0.08, outer_radius: 0.12 };
/// let packing = fill_fitted(&ring, 0.01, Vector::zeros());
/// let area = std::f64::consts::PI * (0.12 * 0.12 - 0.08 * 0.08);
/// assert!((packing.volume.iter().sum::<f64>() / area - 1.0).abs() < 1e-12);
/// ```
pub fn fill_fitted(shape: &Shape, spacing: f64, origin: Vector) -> Packing<Plane> {
    let boundary = shape.boundary();
    let depth = |x: &Vector| -boundary.surface(x).distance;
    let thickness = 2.0 * largest_depth(shape, spacing, origin, depth);
    let across = (thickness / spacing).round().max(1.0);
    let thick = across > 2.0 * LAYERS + CORE;
    let below = if thick { spacing } else { thickness / across };
    let along = spacing * spacing / below;
    // Of a thin shape both faces; the deepest layer is in the middle.
    let layers = if thick { LAYERS } else { (0.5 * across).ceil() };
    // Whole and small.
    let mut position = layers_within(&boundary, below, along, layers as u32);
    let mut free = vec![true; position.len()];
    if thick {
        for x in fill(shape, spacing, origin) {
            let rows = depth(&x) / spacing;
            if rows > LAYERS + 0.3 {
                position.push(x);
                free.push(rows < LAYERS + BUFFER);
            }
        }
    }
    let samples = samples(shape, &boundary, spacing, origin);
    let interior = Interior { samples: &samples, width: spacing / SAMPLES, spacing };
    let mut packing = interior.pack(position, free);
    packing.match_moments(&boundary.moments());
    in_rows(packing, spacing)
}

/// Largest depth \[m\] below the surface.
fn largest_depth(shape: &Shape, spacing: f64, origin: Vector, depth: impl Fn(&Vector) -> f64) -> f64 {
    let coarse = fill(shape, 0.5 * spacing, origin);
    let deepest = coarse.iter().map(|x| (depth(x), *x)).max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((mut largest, mut at)) = deepest else { return 0.0 };
    let mut step = 0.25 * spacing;
    for _ in 0..HALVINGS {
        let tried = [Vector::x(), -Vector::x(), Vector::y(), -Vector::y()].map(|d| at + d * step);
        match tried.into_iter().map(|x| (depth(&x), x)).max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((deeper, x)) if deeper > largest => (largest, at) = (deeper, x),
            _ => step *= 0.5,
        }
    }
    largest
}

/// Samples of the inside of `shape` as far from the surface as particles move; at the surface by the share that is inside.
fn samples(shape: &Shape, boundary: &Boundary, spacing: f64, origin: Vector) -> Vec<Sample<Plane>> {
    let width = spacing / SAMPLES;
    let deepest = (LAYERS + BUFFER + 2.0) * spacing;
    let (lower, upper) = shape.bounds();
    let around = Shape::Rectangle { lower: lower.add_scalar(-spacing), upper: upper.add_scalar(spacing) };
    let mut samples = Vec::new();
    for middle in fill(&around, spacing, origin) {
        let distance = boundary.surface(&middle).distance;
        if distance > spacing || -distance > deepest {
            continue;
        }
        let cell = Shape::Rectangle {
            lower: middle.add_scalar(-0.5 * spacing),
            upper: middle.add_scalar(0.5 * spacing),
        };
        for position in fill(&cell, width, middle.add_scalar(-0.5 * spacing)) {
            // Beyond half the diagonal of a cell and that of a sample no face passes.
            let share = if -distance > spacing {
                1.0
            } else {
                (0.5 - boundary.surface(&position).distance / width).clamp(0.0, 1.0)
            };
            if share > 0.0 {
                samples.push(Sample { position, volume: share * width * width });
            }
        }
    }
    samples
}

/// The particles in bands of a spacing upward, within a band along x: neighbours stay near in memory.
fn in_rows(packing: Packing<Plane>, spacing: f64) -> Packing<Plane> {
    let mut order: Vec<usize> = (0..packing.position.len()).collect();
    let row = |k: usize| (packing.position[k].y / spacing).floor();
    order.sort_by(|&a, &b| {
        row(a).total_cmp(&row(b)).then(packing.position[a].x.total_cmp(&packing.position[b].x))
    });
    Packing {
        position: order.iter().map(|k| packing.position[*k]).collect(),
        volume: order.iter().map(|k| packing.volume[*k]).collect(),
    }
}

#[cfg(test)]
mod tests;
