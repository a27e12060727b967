use std::f64::consts::PI;

use super::*;

mod files;
mod queries;

fn at(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

/// The twelve facets of a box, facing outward.
fn cube(lower: Vector3<f64>, upper: Vector3<f64>) -> Vec<[Vector3<f64>; 3]> {
    let corner =
        |k: usize| Vector3::from_fn(|axis, _| if k >> axis & 1 == 0 { lower[axis] } else { upper[axis] });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    halves.map(|facet| facet.map(corner)).collect()
}

fn unit_cube() -> Vec<[Vector3<f64>; 3]> {
    cube(Vector3::zeros(), Vector3::repeat(1.0))
}

/// An octahedron on the unit sphere, each of its sides in `count`² facets.
fn sphere(count: u32) -> Vec<[Vector3<f64>; 3]> {
    let mut facets = Vec::new();
    for k in 0..8 {
        let sign = |axis: usize| if k >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let (a, b, c) = (Vector3::x() * sign(0), Vector3::y() * sign(1), Vector3::z() * sign(2));
        let (a, b) = if sign(0) * sign(1) * sign(2) > 0.0 { (a, b) } else { (b, a) };
        let point = |i: u32, j: u32| {
            let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(count));
            (a * (1.0 - u - v) + b * u + c * v).normalize()
        };
        for (i, j) in (0..count).flat_map(|i| (0..count - i).map(move |j| (i, j))) {
            facets.push([point(i, j), point(i + 1, j), point(i, j + 1)]);
            if i + j + 1 < count {
                facets.push([point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)]);
            }
        }
    }
    facets
}

fn reversed(facets: &[[Vector3<f64>; 3]]) -> Vec<[Vector3<f64>; 3]> {
    facets.iter().map(|[a, b, c]| [*a, *c, *b]).collect()
}

fn report(facets: &[[Vector3<f64>; 3]]) -> Report {
    Surface::new(facets).expect("facets").report()
}
