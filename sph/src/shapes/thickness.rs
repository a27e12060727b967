//! How thick a shape is around its points.

use super::{Boundary, Shape};
use crate::domain::Domain;
use crate::neighbours::CellGrid;
use crate::vector::Vector;

/// Local thickness \[m\] of `shape` at `points` that fill it `spacing` apart, up to `limit` \[m\].
///
/// That is the diameter of the largest disc within the shape that reaches the point's cell (Hildebrand & Rüegsegger 1997), so
/// that the corners of a square are as thick as a disc that reaches into them. Discs are tried around the points and half way
/// between them.
pub fn local_thickness(shape: &Shape, points: &[Vector], spacing: f64, limit: f64) -> Vec<f64> {
    let boundary = Boundary::new(shape);
    let half = 0.5 * spacing;
    let offsets = [[0.0, 0.0], [half, 0.0], [0.0, half], [half, half]].map(Vector::from);
    let discs: Vec<(Vector, f64)> = points
        .iter()
        .flat_map(|x| offsets.map(|offset| x + offset))
        .map(|centre| (centre, (-boundary.surface(&centre).distance).min(0.5 * limit)))
        .filter(|(_, radius)| *radius > 0.0)
        .collect();
    let centres: Vec<Vector> = discs.iter().map(|(centre, _)| *centre).collect();
    let reach = 0.5 * limit + half;
    let domain = Domain { lower: Vector::zeros(), upper: Vector::zeros(), periodic: [false; 2] };
    let near = CellGrid::new(&domain, &centres, reach).list(&domain, points, &centres, reach, false);
    let diameter = |(k, x): (usize, &Vector)| {
        let reaching = near.of(k).iter().map(|disc| discs[*disc as usize]);
        // The tolerance keeps discs that just reach a cell's centre.
        let reaching = reaching.filter(|(centre, radius)| (x - centre).norm() <= radius + 1.01 * half);
        reaching.map(|(_, radius)| 2.0 * radius).fold(0.0, f64::max)
    };
    points.iter().enumerate().map(diameter).collect()
}
