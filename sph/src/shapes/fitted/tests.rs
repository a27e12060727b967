use std::f64::consts::PI;

use super::*;
use crate::shapes::{fill, layers_around, wall_fill};

fn at(x: f64, y: f64) -> Vector {
    Vector::new(x, y)
}

fn polygon(vertices: &[(f64, f64)]) -> Shape {
    Shape::Polygon { vertices: vertices.iter().map(|(x, y)| at(*x, *y)).collect() }
}

fn sorted(particles: &[LayerParticle]) -> Vec<LayerParticle> {
    let mut sorted = particles.to_vec();
    let key = |x: f64| (x * 1e6).round();
    sorted.sort_by(|a, b| {
        let (a, b) = (a.position, b.position);
        key(a.y).total_cmp(&key(b.y)).then(key(a.x).total_cmp(&key(b.x)))
    });
    sorted
}

fn assert_same(found: &[LayerParticle], expected: &[LayerParticle]) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in sorted(found).iter().zip(sorted(expected)) {
        // Round-off of positions of size 1.
        assert!((a.position - b.position).norm() < 1e-12, "{} {}", a.position, b.position);
        assert!((a.normal - b.normal).norm() < 1e-9, "{}: {} {}", a.position, a.normal, b.normal);
    }
}

fn smallest_distance(particles: &[LayerParticle]) -> f64 {
    let pairs =
        particles.iter().enumerate().flat_map(|(i, a)| particles[i + 1..].iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| (a.position - b.position).norm()).fold(f64::INFINITY, f64::min)
}

#[test]
fn along_the_lattice_layers_are_those_of_the_lattice() {
    let box_ = Shape::Rectangle { lower: at(0.0, 0.0), upper: at(1.0, 0.6) };
    let open_top = OpenSides { upper: [false, true], ..OpenSides::default() };
    for open in [OpenSides::default(), open_top] {
        let expected = layers_around(&box_, &box_.boundary(), 0.05, 3, Vector::zeros(), open);
        assert_same(&layers_along(&box_, &box_.boundary(), 0.05, 3, Side::Outside(open)), &expected);
    }
    // An L has a corner of each kind. As a solid wall 6 and more spacings thick, three layers leave its core out.
    let l = polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.4), (0.4, 0.4), (0.4, 1.0), (0.0, 1.0)]);
    let boundary = l.boundary();
    let mut expected = wall_fill(&l, &l.boundary(), 0.05, Vector::zeros());
    expected.retain(|particle| -boundary.surface(&particle.position).distance < 0.15);
    let mut found = layers_along(&l, &l.boundary(), 0.05, 3, Side::Inside);
    // Equally near two faces: the lattice gives no normal on the diagonal of a corner, nor do layers.
    found.sort_by(|a, b| a.position.x.total_cmp(&b.position.x));
    assert_same(&found, &expected);
    let on_lattice = |shape: &Shape| is_on_lattice(&shape.boundary(), 0.05, Vector::zeros(), |_| false);
    assert!(on_lattice(&l) && !on_lattice(&l.translated(&at(0.01, 0.0))));
}

#[test]
fn a_turned_shape_has_the_turned_layers() {
    let vertices = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.6), (0.0, 0.6)];
    let (sin, cos) = 0.3_f64.sin_cos();
    let turned = |x: &Vector| at(cos * x.x - sin * x.y, sin * x.x + cos * x.y);
    let turned_vertices = vertices.map(|(x, y)| turned(&at(x, y))).map(|v| (v.x, v.y));
    for side in [Side::Outside(OpenSides::default()), Side::Inside] {
        let straight: Vec<LayerParticle> =
            layers_along(&polygon(&vertices), &polygon(&vertices).boundary(), 0.05, 3, side)
                .iter()
                .map(|p| LayerParticle { position: turned(&p.position), normal: turned(&p.normal) })
                .collect();
        assert_same(
            &layers_along(&polygon(&turned_vertices), &polygon(&turned_vertices).boundary(), 0.05, 3, side),
            &straight,
        );
    }
    let on_lattice = |shape: &Shape| is_on_lattice(&shape.boundary(), 0.05, Vector::zeros(), |_| false);
    assert!(!on_lattice(&polygon(&turned_vertices)));
    assert!(!on_lattice(&Shape::Circle { centre: at(0.0, 0.0), radius: 1.0 }));
}

#[test]
fn around_a_circle_layers_are_rings_of_even_spacing() {
    let circle = Shape::Circle { centre: at(0.2, -0.1), radius: 0.5 };
    for (side, sign) in [(Side::Outside(OpenSides::default()), 1.0), (Side::Inside, -1.0)] {
        let particles = layers_along(&circle, &circle.boundary(), 0.02, 3, side);
        for (layer, from_face) in [0.01, 0.03, 0.05].into_iter().enumerate() {
            let radius = 0.5 + sign * from_face;
            let in_ring = |p: &&LayerParticle| {
                // Chords of a twentieth of the spacing bulge by far less than this.
                ((p.position - at(0.2, -0.1)).norm() - radius).abs() < 1e-4
            };
            let ring: Vec<_> = particles.iter().filter(in_ring).collect();
            let expected = 2.0 * (PI * radius / 0.02).round();
            assert_eq!(ring.len() as f64, expected, "layer {layer}");
            for p in ring {
                let outward = (p.position - at(0.2, -0.1)).normalize();
                assert!((p.normal + outward * sign).norm() < 1e-3);
            }
        }
        assert!(smallest_distance(&particles) > 0.8 * 0.02);
    }
}

#[test]
fn a_wedge_is_filled_to_its_tip_without_crowding() {
    let wedge = polygon(&[(0.28, 0.0), (0.37, 0.0), (0.33, 0.07)]);
    let spacing = 0.004;
    let particles = layers_along(&wedge, &wedge.boundary(), spacing, 4, Side::Inside);
    let boundary = wedge.boundary();
    assert!(smallest_distance(&particles) >= CLOSENESS * spacing);
    // Every place of the layers has a particle nearer than the half-diagonal of a cell and half of one more.
    for place in fill(&wedge, 0.2 * spacing, Vector::zeros()) {
        let depth = -boundary.surface(&place).distance;
        if (0.5 * spacing..3.0 * spacing).contains(&depth) {
            let nearest = particles.iter().map(|p| (p.position - place).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1.1 * spacing, "{place}: {nearest}");
        }
    }
    // The outer layer lies half a spacing under the faces; that under the tip lies deeper.
    let highest = particles.iter().map(|p| p.position.y).fold(0.0, f64::max);
    assert!(highest > 0.07 - 2.0 * spacing);
    for p in &particles {
        assert!(-boundary.surface(&p.position).distance > (0.5 - SLACK) * spacing);
    }
}

#[test]
fn a_plate_two_spacings_thick_has_two_rows() {
    let plate = Shape::Rectangle { lower: at(0.013, 0.0), upper: at(0.053, 0.4) };
    let particles = layers_along(&plate, &plate.boundary(), 0.02, 4, Side::Inside);
    assert_eq!(particles.len(), 2 * 20);
}

#[test]
fn overlapping_parts_of_a_union_make_one_boundary() {
    let union = Shape::Union(vec![
        Shape::Circle { centre: at(0.0, 0.0), radius: 0.3 },
        Shape::Rectangle { lower: at(0.0, -0.1), upper: at(0.8, 0.1) },
    ]);
    let particles = layers_along(&union, &union.boundary(), 0.02, 2, Side::Inside);
    let boundary = union.boundary();
    for p in &particles {
        let depth = -boundary.surface(&p.position).distance;
        assert!(depth > 0.35 * 0.02 && depth < 2.0 * 0.02, "{}: {depth}", p.position);
    }
    // Two layers hold about twice the length over the spacing.
    let expected = 2.0 * boundary.length() / 0.02;
    assert!((particles.len() as f64 / expected - 1.0).abs() < 0.1, "{} {expected}", particles.len());
}
