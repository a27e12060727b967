//! Layers along faces, and bodies filled by them.

use std::f64::consts::PI;

use super::*;
use crate::neighbours::CellGrid;
use crate::shapes::{LayerParticle, Side, fill_fitted, layers_along, local_thickness};
use crate::space::domain::Domain;

const SPACING: f64 = 0.1;

/// Neighbours within `reach` of each point.
fn near(x: &[Vector3<f64>], reach: f64) -> Vec<Vec<usize>> {
    let open = Domain::<Spatial> { lower: Vector3::zeros(), upper: Vector3::zeros(), periodic: [false; 3] };
    let list = CellGrid::new(&open, x, reach).list(&open, x, x, reach);
    (0..x.len()).map(|k| list.of(k).iter().map(|j| *j as usize).filter(|j| *j != k).collect()).collect()
}

fn smallest_distance(x: &[Vector3<f64>]) -> f64 {
    let near = near(x, 1.5 * SPACING);
    let pairs = near.iter().enumerate().flat_map(|(i, near)| near.iter().map(move |j| (i, *j)));
    pairs.map(|(i, j)| (x[i] - x[j]).norm()).fold(f64::INFINITY, f64::min)
}

#[test]
fn around_a_sphere_layers_are_even_spheres() {
    let round = ball([0.03, 0.02, 0.01], 0.8);
    let boundary = round.boundary();
    for (side, sign) in [(Side::Outside(OpenSides::default()), 1.0), (Side::Inside, -1.0)] {
        let particles = layers_along(&round, &boundary, SPACING, 3, side);
        for layer in [0.5, 1.5, 2.5] {
            let radius = 0.8 + sign * layer * SPACING;
            // At the centroids of cells between two spheres; the curvature is taken over a part of a spacing.
            let centroid = radius + SPACING * SPACING / (12.0 * radius);
            let of_layer: Vec<_> = particles
                .iter()
                .filter(|p| ((p.position - at(0.03, 0.02, 0.01)).norm() - centroid).abs() < 1e-3 * SPACING)
                .collect();
            let expected = 4.0 * PI * radius * radius / (SPACING * SPACING);
            // As many as the volume of the layer has room for, measured by points of a lattice.
            assert!((of_layer.len() as f64 / expected - 1.0).abs() < 0.03, "{} {expected}", of_layer.len());
            for p in of_layer {
                let outward = (p.position - at(0.03, 0.02, 0.01)).normalize();
                assert!((p.normal + outward * sign).norm() < 1e-12);
            }
        }
        let positions: Vec<_> = particles.iter().map(|p| p.position).collect();
        // Layers are a spacing apart; a hexagonal one of the same density has neighbours at 1.07.
        assert!(smallest_distance(&positions) > 0.74 * SPACING, "{}", smallest_distance(&positions));
    }
}

/// Largest distance of a place on layer `k` before or behind a face of `shape`, off its edges, from the nearest particle.
fn widest_gap(shape: &SpatialShape, frame: Frame, particles: &[LayerParticle<Spatial>], k: f64) -> f64 {
    let SpatialShape::Box { lower, upper } = shape else { unreachable!() };
    let mut widest = 0.0_f64;
    for axis in 0..3 {
        for level in [lower[axis] - (k + 0.5) * SPACING, upper[axis] + (k + 0.5) * SPACING] {
            let (mut from, mut to) = (*lower, *upper);
            (from[axis], to[axis]) = (level - 0.01 * SPACING, level + 0.01 * SPACING);
            let places = fill(&block(from.into(), to.into()), 0.02 * SPACING, from);
            for place in places.iter().step_by(1117) {
                let place = frame.point(place);
                let distances = particles.iter().map(|p| (p.position - place).norm());
                widest = widest.max(distances.fold(f64::INFINITY, f64::min));
            }
        }
    }
    widest
}

#[test]
fn layers_around_boxes_off_the_lattice_have_no_holes() {
    let turned = Frame::new(at(0.1, 0.0, 0.0), &at(1.0, 0.3, 0.1), &at(0.0, 1.0, 0.2)).expect("axes");
    let rows = block([0.0; 3], [1.53, 1.0, 0.97]);
    // No rows fit the third side; the first layer lies halfway between two rows of candidates.
    let spread = block([0.0; 3], [1.0, 1.0, 0.35]);
    for (shape, frame, widest) in [
        // Half the diagonal of a cell.
        (&rows, Frame::default(), 0.73),
        (&rows, turned, 0.73),
        (&spread, Frame::default(), 0.95),
        (&spread, turned, 0.95),
    ] {
        let placed = if frame == Frame::default() { shape.clone() } else { shape.clone().placed(frame) };
        let particles =
            layers_along(&placed, &placed.boundary(), SPACING, 3, Side::Outside(OpenSides::default()));
        for layer in [0.0, 1.0, 2.0] {
            let found = widest_gap(shape, frame, &particles, layer) / SPACING;
            assert!(found < widest, "{layer}: {found}");
        }
    }
}

#[test]
fn layers_of_a_box_are_rows_at_its_faces_with_normals_and_rounded_edges() {
    let tank = block([0.0; 3], [1.53, 1.0, 0.97]);
    let open = OpenSides { upper: [false, true, false], ..OpenSides::default() };
    let boundary = tank.boundary();
    let particles = layers_along(&tank, &boundary, SPACING, 2, Side::Outside(open));
    let first = |axis: usize| {
        let of_layer = |p: &&LayerParticle<Spatial>| {
            (p.position[axis] + 0.05).abs() < 1e-12 && (p.normal[axis] - 1.0).abs() < 1e-12
        };
        particles.iter().filter(of_layer).count()
    };
    assert_eq!([0, 1, 2].map(first), [10 * 10, 15 * 10, 15 * 10]);
    assert!(particles.iter().all(|p| p.position.y < 1.0 && !tank.contains(&p.position)));
    assert!(particles.iter().all(|p| boundary.surface(&p.position).distance < 0.2));
    // A solid wall of the same shape.
    let solid = layers_along(&tank, &boundary, SPACING, 2, Side::Inside);
    assert_eq!(solid.len(), 15 * 10 * 10 - 11 * 6 * 6);
    assert!(smallest_distance(&solid.iter().map(|p| p.position).collect::<Vec<_>>()) > 0.96 * SPACING);
}

#[test]
fn layers_of_an_open_cylinder_are_even_up_to_its_rim() {
    let tank = rod([0.0; 3], [0.0, 0.0, 1.0], 0.7, 0.0);
    let open = OpenSides { upper: [false, false, true], ..OpenSides::default() };
    let particles = layers_along(&tank, &tank.boundary(), SPACING, 2, Side::Outside(open));
    assert!(particles.iter().all(|p| !tank.contains(&p.position)));
    for radius in [0.75, 0.85] {
        let layer = |p: &&LayerParticle<Spatial>| {
            p.position.z > 0.0 && (p.position.xy().norm() - radius).abs() < 0.01 * SPACING
        };
        let heights: Vec<f64> = particles.iter().filter(layer).map(|p| p.position.z).collect();
        // From the rim down as much as in the middle; half a row more or less is 0.05 of the whole and 0.12 of a part.
        for (from, to, tolerance) in [(0.0, 1.0, 0.03), (0.6, 1.0, 0.06), (0.3, 0.7, 0.06)] {
            let count = heights.iter().filter(|z| (from..to).contains(*z)).count() as f64;
            let expected = 2.0 * PI * radius * (to - from) / (SPACING * SPACING);
            assert!((count / expected - 1.0).abs() < tolerance, "{radius} {from}: {count} {expected}");
        }
        assert!(heights.iter().all(|z| *z < 1.0 - 0.25 * SPACING));
    }
}

#[test]
fn bodies_are_filled_evenly_with_the_mass_and_moments_of_the_shape() {
    let turned = Frame::new(at(0.1, 0.0, 0.0), &at(1.0, 0.3, 0.1), &at(0.0, 1.0, 0.2)).expect("axes");
    for (name, shape) in [
        ("sphere", ball([0.03, 0.02, 0.01], 0.8)),
        (
            "torus",
            SpatialShape::Torus {
                centre: at(0.0, 0.0, 0.0),
                axis: at(0.1, 0.0, 1.0),
                radius: 0.7,
                tube_radius: 0.25,
            },
        ),
        ("plate", block([-0.5, -0.4, 0.0], [0.5, 0.4, 0.2]).placed(turned)),
    ] {
        let packing = fill_fitted(&shape, SPACING, Vector3::zeros());
        let (exact, cell) = (shape.boundary().moments(), SPACING.powi(3));
        let volume: f64 = packing.volume.iter().sum();
        assert!((volume / exact.volume - 1.0).abs() < 1e-12, "{name}: {volume}");
        let weighted = packing.position.iter().zip(&packing.volume).map(|(x, v)| x * *v);
        assert!((weighted.sum::<Vector3<f64>>() / volume - exact.centroid).norm() < 1e-9, "{name}");
        let count = packing.position.len() as f64 * cell / exact.volume;
        // Layers and the lattice further inside do not fit each other everywhere; edges of a plate two layers thick get more.
        assert!((count - 1.0).abs() < if name == "plate" { 0.22 } else { 0.06 }, "{name}: {count}");
        let nearest = smallest_distance(&packing.position) / SPACING;
        assert!(nearest > 0.6, "{name}: {nearest}");
        assert!(packing.position.iter().all(|x| shape.contains(x)), "{name}");
        let farthest = fill(&shape, 0.5 * SPACING, Vector3::zeros())
            .iter()
            .map(|y| packing.position.iter().map(|x| (x - y).norm()).fold(f64::INFINITY, f64::min))
            .fold(0.0, f64::max);
        // 0.87 in a cubic lattice.
        assert!(farthest < 1.1 * SPACING, "{name}: {farthest}");
    }
}

#[test]
fn thickness_is_that_of_the_thinnest_part_and_corners_are_not_thin() {
    let cross = SpatialShape::Union(vec![block([0.0; 3], [1.0; 3]), block([1.0, 0.3, 0.3], [1.6, 0.6, 0.5])]);
    let points = fill(&cross, SPACING, Vector3::zeros());
    for (x, thickness) in points.iter().zip(local_thickness(&cross, &points, SPACING, 0.6)) {
        if x.x > 1.2 {
            // Of the smaller side of the bar.
            assert!((thickness - 0.2).abs() < 1e-9, "{x}: {thickness}");
        } else if x.x < 0.9 {
            // Into the corner of a cube a ball reaches less far than a disc into that of a square.
            assert!(thickness > 0.29, "{x}: {thickness}");
            let at_corner = x.iter().filter(|k| **k < 0.2 || **k > 0.8).count() > 1;
            assert!(at_corner || thickness > 0.59, "{x}: {thickness}");
        }
    }
}

/// Weights of a cubic B-spline on the four nodes from one below that at `floor(x)`.
fn weights(x: f64) -> [f64; 4] {
    let f = x - x.floor();
    let g = 1.0 - f;
    [g.powi(3), 4.0 - 6.0 * f * f + 3.0 * f.powi(3), 4.0 - 6.0 * g * g + 3.0 * g.powi(3), f.powi(3)]
        .map(|w| w / 6.0)
}

/// Volume that particles of `shape` and of layers around it claim on a grid of 1.3 spacings more than there is, over that of
/// the shape, on nodes that the inner ones reach. Mean over places of the grid.
fn claimed_in_excess(shape: &SpatialShape) -> f64 {
    let inside = fill_fitted(shape, SPACING, Vector3::zeros());
    let around = layers_along(shape, &shape.boundary(), SPACING, 4, Side::Outside(OpenSides::default()));
    let (width, count, shifts) = (1.3 * SPACING, 40, 5);
    let (lower, cell) = (at(-2.6, -2.6, -2.6), width.powi(3));
    let mut sum = 0.0;
    for shift in 0..shifts {
        let shift = f64::from(shift) / f64::from(shifts);
        let mut nodes = vec![[0.0; 2]; count * count * count];
        let mut claim = |x: &Vector3<f64>, volume: f64, of: usize| {
            let place = (x - lower) / width + at(shift, shift, shift);
            let weights = [place.x, place.y, place.z].map(weights);
            let first = place.map(|at| at.floor() as usize - 1);
            for (k, wz) in weights[2].iter().enumerate() {
                for (j, wy) in weights[1].iter().enumerate() {
                    for (i, wx) in weights[0].iter().enumerate() {
                        let node = ((first.z + k) * count + first.y + j) * count + first.x + i;
                        nodes[node][of] += volume / cell * wx * wy * wz;
                    }
                }
            }
        };
        inside.position.iter().zip(&inside.volume).for_each(|(x, volume)| claim(x, *volume, 0));
        around.iter().for_each(|p| claim(&p.position, SPACING.powi(3), 1));
        let counts = |[fluid, wall]: &&[f64; 2]| *fluid > 0.02 * wall;
        sum += nodes.iter().filter(counts).map(|[fluid, wall]| (fluid + wall - 1.0) * cell).sum::<f64>();
    }
    sum / f64::from(shifts) / inside.volume.iter().sum::<f64>()
}

#[test]
fn layers_around_a_shape_claim_what_is_outside() {
    let shapes = [
        ball([0.03, 0.02, 0.01], 1.0),
        rod([-0.8, -0.3, -0.5], [0.8, 0.3, 0.5], 0.7, 0.0),
        SpatialShape::Cone { from: at(0.0, 0.0, -1.0), to: at(0.0, 0.0, 1.0), radii: [0.0, 1.0] },
    ];
    for shape in shapes {
        let excess = claimed_in_excess(&shape);
        // Layers at half spacings from the faces claim 0.3 to 0.5 % too much at ten spacings across the radius.
        assert!(excess.abs() < 1e-3, "{excess:e}");
    }
}

#[test]
fn layers_of_a_wall_are_as_dense_on_flat_faces_as_on_curved_ones() {
    let (radius, half) = (0.8, 1.0);
    let shape = rod([0.0, 0.0, -half], [0.0, 0.0, half], radius, 0.0);
    let particles = layers_along(&shape, &shape.boundary(), SPACING, 4, Side::Outside(OpenSides::default()));
    let count = |is_in: &dyn Fn(f64, f64) -> bool| {
        let places = particles.iter().map(|p| (p.position.xy().norm(), p.position.z.abs()));
        places.filter(|(from_axis, height)| is_in(*from_axis, *height)).count() as f64
    };
    for layer in 0..4 {
        let (from, to) = (f64::from(layer) * SPACING, f64::from(layer + 1) * SPACING);
        let beside = |from_axis: f64, height: f64| {
            (radius + from..radius + to).contains(&from_axis) && height < half - SPACING
        };
        let above = |from_axis: f64, height: f64| {
            (half + from..half + to).contains(&height) && from_axis < radius - SPACING
        };
        let area = 2.0 * PI * (radius + 0.5 * (from + to)) * 2.0 * (half - SPACING);
        let discs = 2.0 * PI * (radius - SPACING).powi(2);
        for (found, area) in [(count(&beside), area), (count(&above), discs)] {
            let expected = area / (SPACING * SPACING);
            // Three particles of 308 on the ends of the patch.
            assert!((found / expected - 1.0).abs() < 0.015, "{layer}: {found} {expected}");
        }
    }
}
