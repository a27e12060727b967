//! Particles of a shape in layers along its faces.

use super::lattice::{Lattice, nudged};
use super::packing::{Interior, Packing, Sample};
use super::{Faces, Region, ShapedSpace, fill};
use crate::space::Space;
use crate::space::tensors::SpaceVector;
use crate::tasks;

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
pub fn fill_fitted<S: ShapedSpace, R: Region<S>>(shape: &R, spacing: f64, origin: S::Vector) -> Packing<S> {
    let boundary = shape.boundary();
    let depth = |x: &S::Vector| -boundary.surface(x).distance;
    let thickness = 2.0 * largest_depth::<S, R>(shape, spacing, origin, depth);
    let across = (thickness / spacing).round().max(1.0);
    let thick = across > 2.0 * S::LAYERS + CORE;
    let below = if thick { spacing } else { thickness / across };
    let per_layer = S::cell_volume(spacing) / below;
    let along = if S::DIMENSIONS == 2 { per_layer } else { per_layer.sqrt() };
    // Of a thin shape both faces; the deepest layer is in the middle.
    let layers = if thick { S::LAYERS } else { (0.5 * across).ceil() };
    // Whole and small.
    let mut position = boundary.layers_within(below, along, layers as u32);
    let mut free = vec![true; position.len()];
    if thick {
        let inside = fill(shape, spacing, origin);
        let rows: Vec<f64> = tasks::map(inside.len(), 64, |k| depth(&inside[k]) / spacing);
        for (x, rows) in inside.into_iter().zip(rows) {
            if rows > S::LAYERS + 0.3 {
                position.push(x);
                free.push(rows < S::LAYERS + BUFFER);
            }
        }
    }
    let samples = samples::<S, R>(shape, &boundary, spacing, origin);
    let interior = Interior { samples: &samples, width: spacing / S::SAMPLES, spacing };
    let mut packing = interior.pack(position, free);
    packing.match_moments(&boundary.moments());
    in_rows(packing, spacing)
}

/// Largest depth \[m\] below the surface.
fn largest_depth<S: Space, R: Region<S>>(
    shape: &R,
    spacing: f64,
    origin: S::Vector,
    depth: impl Fn(&S::Vector) -> f64 + Sync,
) -> f64 {
    let coarse = fill(shape, 0.5 * spacing, origin);
    let depths: Vec<f64> = tasks::map(coarse.len(), 64, |k| depth(&coarse[k]));
    let deepest = depths.into_iter().zip(coarse).max_by(|a, b| a.0.total_cmp(&b.0));
    let Some((mut largest, mut at)) = deepest else { return 0.0 };
    let mut step = 0.25 * spacing;
    let ways: Vec<S::Vector> = (0..S::DIMENSIONS)
        .map(|axis| S::vector(S::axes(|other| if other == axis { 1.0 } else { 0.0 })))
        .flat_map(|unit| [unit, -unit])
        .collect();
    for _ in 0..HALVINGS {
        let tried = ways.iter().map(|d| at + *d * step);
        match tried.map(|x| (depth(&x), x)).max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((deeper, x)) if deeper > largest => (largest, at) = (deeper, x),
            _ => step *= 0.5,
        }
    }
    largest
}

/// Samples of the inside of `shape` as far from the surface as particles move; at the surface by the share that is inside.
fn samples<S: ShapedSpace, R: Region<S>>(
    shape: &R,
    boundary: &R::Boundary,
    spacing: f64,
    origin: S::Vector,
) -> Vec<Sample<S>> {
    let width = spacing / S::SAMPLES;
    let deepest = (S::LAYERS + BUFFER + 2.0) * spacing;
    let (lower, upper) = shape.bounds();
    let margin = S::Vector::repeat(spacing);
    let around = (lower - margin, upper + margin);
    let cells = Lattice::<S>::around(around, spacing, origin)
        .filter_map(|middle| within::<S>(&middle, &around, spacing).then_some(middle));
    let of_cell = |middle: &S::Vector| {
        let distance = boundary.surface(middle).distance;
        if distance > spacing || -distance > deepest {
            return Vec::new();
        }
        let half = S::Vector::repeat(0.5 * spacing);
        let cell = (*middle - half, *middle + half);
        Lattice::<S>::around(cell, width, cell.0).filter_map(|position| {
            if !within::<S>(&position, &cell, width) {
                return None;
            }
            // Beyond half the diagonal of a cell and that of a sample no face passes.
            let share = if -distance > spacing {
                1.0
            } else {
                (0.5 - boundary.surface(&position).distance / width).clamp(0.0, 1.0)
            };
            (share > 0.0).then(|| Sample { position, volume: share * S::cell_volume(width) })
        })
    };
    tasks::flat_map(cells.len(), 8, |k| of_cell(&cells[k]))
}

/// Whether a point of the lattice of `spacing` lies in a box.
fn within<S: Space>(x: &S::Vector, (lower, upper): &(S::Vector, S::Vector), spacing: f64) -> bool {
    let x = nudged::<S>(x, spacing);
    (0..S::DIMENSIONS).all(|axis| lower[axis] <= x[axis] && x[axis] < upper[axis])
}

/// The particles in bands of a spacing upward, within a band along x: neighbours stay near in memory.
fn in_rows<S: Space>(packing: Packing<S>, spacing: f64) -> Packing<S> {
    let mut order: Vec<usize> = (0..packing.position.len()).collect();
    let row = |k: usize, axis: usize| (packing.position[k][axis] / spacing).floor();
    order.sort_by(|&a, &b| {
        let rows = (1..S::DIMENSIONS).rev().map(|axis| row(a, axis).total_cmp(&row(b, axis)));
        let rows = rows.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then);
        rows.then(packing.position[a][0].total_cmp(&packing.position[b][0]))
    });
    Packing {
        position: order.iter().map(|k| packing.position[*k]).collect(),
        volume: order.iter().map(|k| packing.volume[*k]).collect(),
    }
}

#[cfg(test)]
mod tests;
