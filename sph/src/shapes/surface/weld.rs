//! Corners that are the same vertex.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::Numbers;
use super::triangle::Triangle;

crate::constants! {
    /// A few times the round-off of the numbers of 32 bits that files hold.
    const CLOSE: f64 = 1e-6, "surface.weld",
        "distance of corners of facets that become one vertex, in diagonals of the box around all [-]";
}

/// The vertices of `corners`, and of each facet their numbers.
pub(super) fn welded(corners: &[Triangle]) -> (Vec<Vector3<f64>>, Vec<[u32; 3]>) {
    let mut numbers = Numbers::with_capacity(corners.len());
    let mut vertices: Vec<Vector3<f64>> = Vec::with_capacity(corners.len() / 2 + 2);
    let mut number = |x: &Vector3<f64>| {
        // Zero and minus zero are the same place.
        let key = [x.x, x.y, x.z].map(|coordinate| (coordinate + 0.0).to_bits());
        *numbers.entry(key).or_insert_with(|| {
            vertices.push(*x);
            // Surfaces of more than 2³² corners are refused before.
            (vertices.len() - 1) as u32
        })
    };
    let facets: Vec<[u32; 3]> =
        corners.iter().map(|t| [number(&t[0]), number(&t[1]), number(&t[2])]).collect();
    let merged = merged(&vertices);
    // Only those that are met, in their order.
    let mut kept = vec![u32::MAX; vertices.len()];
    let mut left = Vec::with_capacity(vertices.len());
    for (k, x) in vertices.iter().enumerate() {
        if merged[k] as usize == k {
            kept[k] = left.len() as u32;
            left.push(*x);
        }
    }
    let facets = facets.into_iter().map(|facet| facet.map(|k| kept[merged[k as usize] as usize])).collect();
    (left, facets)
}

/// For each vertex the first one that it is the same as.
fn merged(vertices: &[Vector3<f64>]) -> Vec<u32> {
    let (mut lower, mut upper) = (vertices[0], vertices[0]);
    for x in vertices {
        (lower, upper) = (lower.inf(x), upper.sup(x));
    }
    let close = CLOSE * (upper - lower).norm();
    // Cells that are much wider than what is close: nearly all vertices look into their own cell only.
    let width = 16.0 * close;
    let cell = |x: f64| if width > 0.0 { (x / width).floor() as i64 } else { 0 };
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(vertices.len());
    let mut merged = Vec::with_capacity(vertices.len());
    for (k, x) in (0_u32..).zip(vertices) {
        let from = (x - lower).map(|d| cell(d - close));
        let to = (x - lower).map(|d| cell(d + close));
        let mut same = None;
        for (i, j, l) in (from.x..=to.x)
            .flat_map(|i| (from.y..=to.y).flat_map(move |j| (from.z..=to.z).map(move |l| (i, j, l))))
        {
            let near = cells.get(&[i, j, l]).into_iter().flatten();
            let found = near.copied().find(|y| (x - vertices[*y as usize]).norm() <= close);
            same = same.into_iter().chain(found).min();
        }
        if same.is_none() {
            let own = (x - lower).map(cell);
            cells.entry([own.x, own.y, own.z]).or_default().push(k);
        }
        merged.push(same.unwrap_or(k));
    }
    merged
}
