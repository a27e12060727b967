//! How thick a shape is around its points.

use super::{Faces, Region};
use crate::neighbours::CellGrid;
use crate::space::Space;
use crate::space::domain::Domain;
use crate::space::tensors::SpaceVector;
use crate::tasks;

/// Local thickness \[m\] of `shape` at `points` that fill it `spacing` apart, up to `limit` \[m\].
///
/// That is the diameter of the largest disc (ball in space) within the shape that reaches the point's cell (Hildebrand &
/// Rüegsegger 1997), so that the corners of a square are as thick as a disc that reaches into them; corners of a cube count
/// as three spacings thick. Discs are tried around the points and half way between them.
pub fn local_thickness<S: Space, R: Region<S>>(
    shape: &R,
    points: &[S::Vector],
    spacing: f64,
    limit: f64,
) -> Vec<f64> {
    let boundary = shape.boundary();
    let (half, largest) = (0.5 * spacing, 0.5 * limit);
    let radius = |x: &S::Vector| -boundary.surface(x).distance;
    let depth: Vec<f64> = tasks::map(points.len(), 64, |k| radius(&points[k]));
    // Most points of a large shape are too deep to matter, and so are discs around those.
    let near = |margin: f64| points.iter().zip(&depth).filter(move |(_, depth)| **depth < largest + margin);
    let offset = |k: usize| S::vector(S::axes(|axis| if k >> axis & 1 == 0 { 0.0 } else { half }));
    let centres: Vec<S::Vector> = near(spacing)
        .flat_map(|(x, _)| (0..1 << S::DIMENSIONS).map(move |k| *x + offset(k)))
        .filter(|x| shape.contains(x))
        .collect();
    let radii: Vec<f64> = tasks::map(centres.len(), 64, |k| radius(&centres[k]).min(largest));
    let targets: Vec<S::Vector> = near(0.0).map(|(x, _)| *x).collect();
    let reach = largest + half;
    let domain =
        Domain::<S> { lower: S::Vector::zeros(), upper: S::Vector::zeros(), periodic: S::splat(false) };
    let list = CellGrid::new(&domain, &centres, reach).list(&domain, &targets, &centres, reach);
    let mut of_targets = targets.iter().enumerate().map(|(k, x)| {
        let discs = list.of(k).iter().map(|disc| (centres[*disc as usize], radii[*disc as usize]));
        // The tolerance keeps discs that just reach a cell's centre.
        let reaching = discs.filter(|(centre, radius)| (*x - *centre).norm() <= radius + 1.01 * half);
        reaching.map(|(_, radius)| 2.0 * radius).fold(0.0, f64::max)
    });
    depth
        .iter()
        .map(|depth| if *depth < largest { of_targets.next().unwrap_or(0.0) } else { limit })
        .collect()
}
