//! Nearest surfaces against what containment says, which knows nothing of faces.

use super::*;
use crate::shapes::SurfacePoint;

/// Distance of the lines along which the surface is sampled.
const APART: f64 = 0.03;

/// Points of the surface: where lines along the axes enter or leave `shape`.
fn sampled(shape: &SpatialShape) -> Vec<Vector3<f64>> {
    let (lower, upper) = shape.bounds();
    let mut found = Vec::new();
    for axis in 0..3 {
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let counts = ((upper - lower) / APART).map(|count| count.ceil() as usize + 1);
        for (i, j) in (0..=counts[a]).flat_map(|i| (0..=counts[b]).map(move |j| (i, j))) {
            let mut x = lower;
            (x[a], x[b]) = (lower[a] + (i as f64 - 0.37) * APART, lower[b] + (j as f64 - 0.41) * APART);
            let on_line = |t: f64| {
                let mut x = x;
                x[axis] = t;
                x
            };
            for k in 0..=counts[axis] {
                let mut ends = [k as f64 - 1.0, k as f64].map(|k| lower[axis] + (k + 0.13) * APART);
                let inside = shape.contains(&on_line(ends[0]));
                if inside != shape.contains(&on_line(ends[1])) {
                    for _ in 0..40 {
                        let middle = 0.5 * (ends[0] + ends[1]);
                        let side = usize::from(shape.contains(&on_line(middle)) != inside);
                        ends[side] = middle;
                    }
                    found.push(on_line(ends[0]));
                }
            }
        }
    }
    found
}

fn queries(shape: &SpatialShape) -> Vec<Vector3<f64>> {
    let (lower, upper) = shape.bounds();
    let around = block((lower.add_scalar(-0.3)).into(), (upper.add_scalar(0.3)).into());
    fill(&around, 0.137, at(0.011, 0.017, 0.023))
}

#[test]
fn nearest_points_lie_on_the_surface_and_none_is_nearer() {
    for (name, shape) in all_shapes() {
        assert_eq!(shape.validate(), Ok(()), "{name}");
        let (surface, boundary) = (sampled(&shape), shape.boundary());
        let mut smooth = 0;
        let queries = queries(&shape);
        for x in &queries {
            let SurfacePoint { distance, normal, at_vertex } = boundary.surface(x);
            let least = surface.iter().map(|y| (x - y).norm()).fold(f64::INFINITY, f64::min);
            // Bisection ends at round-off of the lines' coordinates.
            assert!(distance.abs() < least + 1e-9, "{name} {x}: {distance} but a point is {least} away");
            // Every place of the surface has a sample within the diagonal of three lines.
            assert!(distance.abs() > least - 1.8 * APART, "{name} {x}: {distance} and {least}");
            assert_eq!(distance < 0.0, shape.contains(x), "{name}");
            if !at_vertex {
                smooth += 1;
                let foot = x - normal * distance;
                let sides = [-1e-6, 1e-6].map(|k| shape.contains(&(foot + normal * k)));
                assert_eq!(sides, [true, false], "{name} {x}: {distance} {normal}");
            }
        }
        assert!(5 * smooth > queries.len(), "{name}: {smooth} of {}", queries.len());
    }
}

#[test]
fn edges_and_corners_of_composed_shapes_are_exact() {
    // A quarter of a plate's corner is cut away: from above the notch the nearest point is on its rim.
    let plate = block([0.0; 3], [1.0, 1.0, 0.2]);
    let notched = SpatialShape::Difference(Box::new(plate), vec![block([0.5, 0.5, -1.0], [2.0, 2.0, 1.0])]);
    let boundary = notched.boundary();
    for (x, nearest) in [
        (at(0.8, 0.6, 0.4), at(0.8, 0.5, 0.2)),
        (at(0.7, 0.9, 0.3), at(0.5, 0.9, 0.2)),
        (at(1.2, 0.9, -0.3), at(1.0, 0.5, 0.0)),
        (at(0.9, 1.3, 0.1), at(0.5, 1.0, 0.1)),
    ] {
        let found = boundary.surface(&x);
        assert!((found.distance - (x - nearest).norm()).abs() < 1e-9, "{x}: {}", found.distance);
        assert!(found.at_vertex);
    }
    // The rim of a dome: a circle of radius 0.4 at height 0.3.
    let cap = SpatialShape::HalfSpace { point: at(0.0, 0.0, 0.3), normal: at(0.0, 0.0, 1.0) };
    let dome = SpatialShape::Intersection(vec![ball([0.0; 3], 0.5), cap]);
    let boundary = dome.boundary();
    for (radius, height, angle) in [(0.6_f64, 0.7_f64, 0.3_f64), (0.5, 0.4, 2.0), (0.41, 0.32, 4.0)] {
        let found = boundary.surface(&at(radius * angle.cos(), radius * angle.sin(), height));
        let exact = (radius - 0.4).hypot(height - 0.3);
        assert!((found.distance - exact).abs() < 1e-9, "{} {exact}", found.distance);
        assert!(found.at_vertex);
    }
}

#[test]
fn the_tip_of_a_cone_and_the_axis_of_a_cylinder_have_no_normal() {
    let cone = SpatialShape::Cone { from: at(0.0, 0.0, 0.0), to: at(0.0, 0.0, 1.0), radii: [1.0, 0.0] };
    let above = cone.boundary().surface(&at(0.0, 0.0, 1.5));
    assert!(above.at_vertex && (above.distance - 0.5).abs() < 1e-12);
    let beside = cone.boundary().surface(&at(1.0, 0.0, 1.0));
    assert!(!beside.at_vertex && (beside.normal - at(1.0, 0.0, 1.0).normalize()).norm() < 1e-12);
    let axis = rod([0.0; 3], [0.0, 0.0, 4.0], 0.5, 0.0).boundary().surface(&at(0.0, 0.0, 2.0));
    assert_eq!((axis.distance, axis.normal), (-0.5, Vector3::zeros()));
}
