//! Properties of random shapes: containment agrees with distance, bounds hold, sets combine, and particles fill a shape
//! once wherever it lies.

use proptest::prelude::*;
use sph::shapes::{Shape, fill};
use sph::space::Vector;

/// Lengths of the shapes \[m\].
const SIZE: std::ops::Range<f64> = 0.1..1.0;

fn vectors() -> impl Strategy<Value = Vector> {
    (-1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y)| Vector::new(x, y))
}

fn simple_shapes() -> impl Strategy<Value = Shape> {
    prop_oneof![
        (vectors(), SIZE, SIZE).prop_map(|(lower, width, height)| Shape::Rectangle {
            lower,
            upper: lower + Vector::new(width, height)
        }),
        (vectors(), SIZE).prop_map(|(centre, radius)| Shape::Circle { centre, radius }),
        (vectors(), SIZE, 0.1..0.9f64).prop_map(|(centre, outer_radius, share)| Shape::Ring {
            centre,
            inner_radius: share * outer_radius,
            outer_radius
        }),
        // Corners in order of their angle about the centre: simple, but not convex.
        (vectors(), prop::collection::vec(SIZE, 3..9)).prop_map(|(centre, radii)| {
            let step = std::f64::consts::TAU / radii.len() as f64;
            let corner = |(k, radius): (usize, &f64)| {
                let angle = step * k as f64;
                centre + Vector::new(angle.cos(), angle.sin()) * *radius
            };
            Shape::Polygon { vertices: radii.iter().enumerate().map(corner).collect() }
        }),
    ]
}

fn shapes() -> impl Strategy<Value = Shape> {
    simple_shapes().prop_recursive(2, 6, 3, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 1..4).prop_map(Shape::Union),
            (inner.clone(), prop::collection::vec(inner, 1..3))
                .prop_map(|(base, removed)| Shape::Difference(Box::new(base), removed)),
        ]
    })
}

/// A grid over all that a shape can reach.
fn points() -> impl Iterator<Item = Vector> {
    (0..40).flat_map(|k| {
        (0..40).map(move |l| Vector::new(f64::from(k), f64::from(l)) * 0.1301 - Vector::repeat(2.5))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn what_a_shape_contains_lies_in_its_bounds(shape in shapes()) {
        let (lower, upper) = shape.bounds();
        for x in points().filter(|x| shape.contains(x)) {
            prop_assert!((0..2).all(|axis| lower[axis] <= x[axis] && x[axis] <= upper[axis]), "{x:?}");
        }
    }

    #[test]
    fn distance_is_negative_inside_alone_and_leads_to_the_surface(shape in simple_shapes()) {
        let boundary = shape.boundary();
        for x in points() {
            let surface = boundary.surface(&x);
            // On the surface round-off decides.
            if surface.distance.abs() > 1e-9 {
                prop_assert_eq!(surface.distance < 0.0, shape.contains(&x), "{:?}", x);
            }
            prop_assert!((surface.normal.norm() - 1.0).abs() < 1e-9, "{:?}", surface.normal);
            // Corners of a polygon that are nearly straight count as a smooth face.
            if !surface.at_vertex && !matches!(shape, Shape::Polygon { .. }) {
                let foot = x - surface.normal * surface.distance;
                // Rounded once for each step of the way there.
                prop_assert!(boundary.surface(&foot).distance.abs() < 1e-9, "{x:?} {foot:?}");
            }
        }
    }

    #[test]
    fn unions_and_differences_are_those_of_sets(a in shapes(), b in shapes()) {
        let union = Shape::Union(vec![a.clone(), b.clone()]);
        let difference = Shape::Difference(Box::new(a.clone()), vec![b.clone()]);
        for x in points() {
            prop_assert_eq!(union.contains(&x), a.contains(&x) || b.contains(&x));
            prop_assert_eq!(difference.contains(&x), a.contains(&x) && !b.contains(&x));
        }
    }

    #[test]
    fn particles_of_touching_rectangles_share_no_place_and_leave_no_gap(
        lower in vectors(), width in SIZE, height in SIZE, cut in 0.1..0.9f64, spacing in 0.03..0.2f64,
    ) {
        let upper = lower + Vector::new(width, height);
        let middle = lower.x + cut * width;
        let whole = fill(&Shape::Rectangle { lower, upper }, spacing, lower);
        let left = Shape::Rectangle { lower, upper: Vector::new(middle, upper.y) };
        let right = Shape::Rectangle { lower: Vector::new(middle, lower.y), upper };
        let mut parts = [fill(&left, spacing, lower), fill(&right, spacing, lower)].concat();
        let by_place = |a: &Vector, b: &Vector| (a.y, a.x).partial_cmp(&(b.y, b.x)).unwrap();
        parts.sort_by(by_place);
        prop_assert_eq!(parts, whole);
    }

    #[test]
    fn the_cells_of_a_fill_have_the_area_of_the_shape(centre in vectors(), radius in 0.3..1.0f64) {
        let spacing = 0.01;
        let count = fill(&Shape::Circle { centre, radius }, spacing, Vector::zeros()).len() as f64;
        let area = std::f64::consts::PI * radius * radius;
        // Cells that the edge cuts, 2πr/Δx of them, count or not by chance: a few times the root of their number.
        let cut = 2.0 * std::f64::consts::PI * radius / spacing;
        prop_assert!((count * spacing * spacing - area).abs() < 5.0 * cut.sqrt() * spacing * spacing);
    }
}
