use std::f64::consts::PI;

use super::*;
use crate::shapes::Shape;
use crate::space::{Plane, Vector};

const SPACING: f64 = 0.01;

fn shapes() -> Vec<(&'static str, Shape)> {
    let (sin, cos) = 0.3_f64.sin_cos();
    let turned = |x: f64, y: f64| Vector::new(0.4 + cos * x - sin * y, -0.2 + sin * x + cos * y);
    let slab = Shape::Polygon {
        vertices: vec![turned(0.0, 0.0), turned(0.3, 0.0), turned(0.3, 0.05), turned(0.0, 0.05)],
    };
    let circle = |radius| Shape::Circle { centre: Vector::new(0.113, 0.217), radius };
    let ring = |inner_radius, outer_radius| Shape::Ring {
        centre: Vector::new(0.003, 0.001),
        inner_radius,
        outer_radius,
    };
    let wedge =
        Shape::Polygon { vertices: [[0.0, 0.0], [0.2, 0.0], [0.15, 0.12]].map(Vector::from).to_vec() };
    let float = Shape::Union(vec![
        Shape::Rectangle { lower: Vector::new(0.0, 0.0), upper: Vector::new(0.2, 0.067) },
        circle(0.12),
    ]);
    let half = Shape::Difference(
        Box::new(circle(0.2)),
        vec![Shape::Rectangle { lower: Vector::new(-1.0, -1.0), upper: Vector::new(1.0, 0.2) }],
    );
    vec![
        ("slab", slab),
        ("circle", circle(0.18)),
        ("small circle", circle(0.025)),
        ("ring, 4 across", ring(0.1, 0.14)),
        ("ring, 4.5 across", ring(0.1, 0.145)),
        ("ring, 20 across", ring(0.1, 0.3)),
        ("wedge", wedge),
        ("float", float),
        ("half", half),
    ]
}

/// Distances of the nearest two particles, smallest volume and largest volume, in spacings.
fn quality(packing: &Packing<Plane>) -> (f64, f64, f64) {
    let x = &packing.position;
    let nearest = (0..x.len())
        .map(|i| (0..x.len()).filter(|j| *j != i).map(|j| (x[i] - x[j]).norm()).fold(f64::INFINITY, f64::min))
        .fold(f64::INFINITY, f64::min);
    let cell = SPACING * SPACING;
    let smallest = packing.volume.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = packing.volume.iter().copied().fold(0.0, f64::max);
    (nearest / SPACING, smallest / cell, largest / cell)
}

#[test]
fn particles_stand_evenly_without_clumps_or_holes() {
    for (name, shape) in shapes() {
        let packing = fill_fitted(&shape, SPACING, Vector::zeros());
        let (nearest, smallest, largest) = quality(&packing);
        // Hexagonal packing of the same density has neighbours at 1.07.
        assert!(nearest > 0.7, "{name}: {nearest}");
        // At the corners of the wedge no square fits.
        assert!(smallest > 0.5 && largest < 1.5, "{name}: {smallest} {largest}");
        let farthest = fill(&shape, 0.25 * SPACING, Vector::zeros())
            .iter()
            .map(|y| packing.position.iter().map(|x| (x - y).norm()).fold(f64::INFINITY, f64::min))
            .fold(0.0, f64::max);
        // 0.71 in a square lattice; tips are beyond their last particle.
        assert!(farthest < 1.05 * SPACING, "{name}: {farthest}");
    }
}

#[test]
fn mass_centre_and_moments_are_those_of_the_shape() {
    for (name, shape) in shapes() {
        let packing = fill_fitted(&shape, SPACING, Vector::zeros());
        let exact = shape.boundary().moments();
        let found = measured(&packing);
        // Round-off of sums over some thousand particles.
        assert!((found.volume / exact.volume - 1.0).abs() < 1e-11, "{name}");
        assert!((found.centroid - exact.centroid).norm() < 1e-11, "{name}");
        for (a, b) in found.second.iter().zip(&exact.second) {
            assert!((a - b).abs() < 1e-9 * (exact.second[0] + exact.second[3]), "{name}: {a} {b}");
        }
    }
}

/// Moments of particles with square cells.
fn measured(packing: &Packing<Plane>) -> crate::shapes::Moments<Plane> {
    let all = || packing.position.iter().zip(&packing.volume);
    let volume = all().map(|(_, v)| v).sum::<f64>();
    let centroid = all().map(|(x, v)| x * *v).sum::<Vector>() / volume;
    let mut second = vec![0.0; 4];
    for (x, v) in all() {
        let r = x - centroid;
        for (k, value) in
            [r.x * r.x + v / 12.0, r.x * r.y, r.x * r.y, r.y * r.y + v / 12.0].into_iter().enumerate()
        {
            second[k] += v * value;
        }
    }
    crate::shapes::Moments { volume, centroid, second }
}

#[test]
fn moments_of_shapes_are_those_of_the_text_books() {
    let ring = Shape::Ring { centre: Vector::new(3.0, -2.0), inner_radius: 0.3, outer_radius: 0.5 };
    let found = ring.boundary().moments();
    let second = PI / 4.0 * (0.5_f64.powi(4) - 0.3_f64.powi(4));
    assert!((found.volume - PI * 0.16).abs() < 1e-13);
    assert!((found.centroid - Vector::new(3.0, -2.0)).norm() < 1e-13);
    assert!((found.second[0] - second).abs() < 1e-12 && (found.second[3] - second).abs() < 1e-12);
    assert!(found.second[1].abs() < 1e-12);
    // A right triangle of legs a along x and b along y: A = ab/2, I_xx = a³b/36, I_xy = -a²b²/72.
    let (a, b) = (0.4, 0.3);
    let triangle =
        Shape::Polygon { vertices: [[1.0, 1.0], [1.0 + a, 1.0], [1.0, 1.0 + b]].map(Vector::from).to_vec() };
    let found = triangle.boundary().moments();
    assert!((found.volume - 0.5 * a * b).abs() < 1e-15);
    assert!((found.second[0] - a.powi(3) * b / 36.0).abs() < 1e-15);
    assert!((found.second[1] + (a * b).powi(2) / 72.0).abs() < 1e-15);
}

#[test]
fn layers_of_a_ring_follow_its_faces() {
    let ring = Shape::Ring { centre: Vector::zeros(), inner_radius: 0.1, outer_radius: 0.145 };
    let packing = fill_fitted(&ring, SPACING, Vector::zeros());
    // 4.5 across: five layers of 0.9 spacings.
    let layer = 0.009;
    let rows = packing.position.iter().map(|x| (x.norm() - 0.1) / layer - 0.5);
    let [mut inner, mut outer] = [0; 2];
    for row in rows {
        // Rows inside undulate where their numbers of particles differ; those along the faces stay apart from them.
        if row < 0.5 {
            assert!(row.abs() < 0.35, "{row}");
            inner += 1;
        } else if row > 3.5 {
            assert!((row - 4.0).abs() < 0.35, "{row}");
            outer += 1;
        }
    }
    // Faces are covered without gaps: 2π r over the spacing along the layer is 59 and 79.
    assert!(inner >= 57 && outer >= 77, "{inner} {outer}");
}

#[test]
fn a_turned_box_gets_the_turned_lattice() {
    let (sin, cos) = 0.3_f64.sin_cos();
    let turned = |x: f64, y: f64| Vector::new(cos * x - sin * y, sin * x + cos * y);
    let vertices = vec![turned(0.0, 0.0), turned(0.3, 0.0), turned(0.3, 0.06), turned(0.0, 0.06)];
    let packing = fill_fitted(&Shape::Polygon { vertices }, SPACING, Vector::zeros());
    assert_eq!(packing.position.len(), 180);
    for (x, v) in packing.position.iter().zip(&packing.volume) {
        let (along, across) = ((cos * x.x + sin * x.y) / SPACING, (cos * x.y - sin * x.x) / SPACING);
        let off = |rows: f64| (rows - rows.floor() - 0.5).abs();
        // Cells are measured by samples of an eighth of a spacing.
        assert!(off(along) < 0.03 && off(across) < 0.03, "{along} {across}");
        assert!((v / (SPACING * SPACING) - 1.0).abs() < 0.03, "{v}");
    }
}
