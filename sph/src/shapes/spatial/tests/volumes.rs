//! Volumes, moments, filling and checks of shapes in space.

use std::f64::consts::PI;

use super::*;
use crate::shapes::Moments;

/// Moments of the points of a fine lattice inside.
fn counted(shape: &SpatialShape, width: f64) -> Moments<Spatial> {
    let points = fill(shape, width, Vector3::zeros());
    let cell = width.powi(3);
    let volume = points.len() as f64 * cell;
    let centroid = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let second = points.iter().map(|x| (x - centroid) * (x - centroid).transpose() * cell);
    let second: nalgebra::Matrix3<f64> = second.sum();
    Moments { volume, centroid, second: second.iter().copied().collect() }
}

#[test]
fn volumes_centroids_and_second_moments_are_those_of_a_fine_lattice() {
    for (name, shape) in all_shapes() {
        let (found, counted) = (shape.boundary().moments(), counted(&shape, 0.01));
        // A lattice count of a round section of 40 cells across errs by as much.
        assert!(
            (found.volume / counted.volume - 1.0).abs() < 6e-3,
            "{name}: {} {}",
            found.volume,
            counted.volume
        );
        assert!((found.centroid - counted.centroid).norm() < 1e-3, "{name}: {}", found.centroid);
        let scale = counted.second[0] + counted.second[4] + counted.second[8];
        for (a, b) in found.second.iter().zip(&counted.second) {
            assert!((a - b).abs() < 6e-3 * scale, "{name}: {a} {b}");
        }
    }
}

#[test]
fn moments_of_shapes_are_those_of_the_text_books() {
    let (r, h) = (0.3, 0.8);
    let cone = SpatialShape::Cone { from: at(1.0, 2.0, 3.0), to: at(1.0, 2.0, 3.0 + h), radii: [r, 0.0] };
    let found = cone.boundary().moments();
    let volume = PI * r * r * h / 3.0;
    assert!((found.volume / volume - 1.0).abs() < 1e-13);
    assert!((found.centroid - at(1.0, 2.0, 3.0 + h / 4.0)).norm() < 1e-13);
    assert!((found.second[8] / (3.0 / 80.0 * volume * h * h) - 1.0).abs() < 1e-12);
    assert!((found.second[0] / (3.0 / 20.0 * volume * r * r) - 1.0).abs() < 1e-12);
    let ring = SpatialShape::Torus {
        centre: at(5.0, 0.0, 0.0),
        axis: at(0.0, 0.0, 1.0),
        radius: 0.5,
        tube_radius: 0.1,
    };
    let found = ring.boundary().moments();
    let volume = 2.0 * PI * PI * 0.5 * 0.01;
    assert!((found.volume / volume - 1.0).abs() < 1e-13);
    // About the axis m (R² + ¾ a²), about a diameter m (4R² + 5a²)/8: ∫ x² is half the first, ∫ z² the second less that.
    let about_axis = volume * (0.25 + 0.75 * 0.01);
    let about_diameter = volume * (4.0 * 0.25 + 5.0 * 0.01) / 8.0;
    assert!((found.second[0] / (0.5 * about_axis) - 1.0).abs() < 1e-12);
    assert!((found.second[8] / (about_diameter - 0.5 * about_axis) - 1.0).abs() < 1e-11);
}

#[test]
fn volumes_of_composed_shapes_are_near_the_exact_ones() {
    let lens = |r: f64, d: f64| PI * (4.0 * r + d) * (2.0 * r - d) * (2.0 * r - d) / 12.0;
    let (a, b) = (ball([0.0; 3], 0.5), ball([0.4, 0.0, 0.0], 0.5));
    let whole = 4.0 / 3.0 * PI * 0.125;
    let cubes = [block([0.0; 3], [1.0; 3]), block([0.5, 0.0, 0.0], [1.5, 1.0, 1.0])];
    for (shape, exact) in [
        (SpatialShape::Union(vec![a.clone(), b.clone()]), 2.0 * whole - lens(0.5, 0.4)),
        (SpatialShape::Intersection(vec![a.clone(), b.clone()]), lens(0.5, 0.4)),
        (SpatialShape::Difference(Box::new(a), vec![b]), whole - lens(0.5, 0.4)),
        (SpatialShape::Union(cubes.to_vec()), 1.5),
    ] {
        let found = shape.boundary().volume();
        assert!((found / exact - 1.0).abs() < 1e-4, "{found} {exact}");
    }
}

#[test]
fn neighbouring_shapes_share_no_lattice_point_and_leave_none_out() {
    let sorted = |mut points: Vec<Vector3<f64>>| {
        points.sort_by(|a, b| {
            let key = |x: &Vector3<f64>| [x.z, x.y, x.x];
            key(a).partial_cmp(&key(b)).expect("numbers")
        });
        points
    };
    let spacing = 0.02;
    let whole = block([0.0; 3], [0.2, 0.16, 0.12]);
    let expected = fill(&whole, spacing, Vector3::zeros());
    assert_eq!(expected.len(), 10 * 8 * 6);
    let slant = SpatialShape::HalfSpace { point: at(0.1, 0.08, 0.06), normal: at(1.0, 1.0, 0.0) };
    let plug = rod([0.1, 0.08, -1.0], [0.1, 0.08, 1.0], 0.05, 0.0);
    let mut pairs: Vec<(SpatialShape, SpatialShape)> = [slant, plug, ball([0.1, 0.08, 0.06], 0.05)]
        .into_iter()
        .map(|cut| {
            let rest = SpatialShape::Difference(Box::new(whole.clone()), vec![cut.clone()]);
            (SpatialShape::Intersection(vec![whole.clone(), cut]), rest)
        })
        .collect();
    // Cuts through lattice points, between them, and off both.
    for cut in [0.05, 0.08, 0.093] {
        pairs.push((block([0.0; 3], [cut, 0.16, 0.12]), block([cut, 0.0, 0.0], [0.2, 0.16, 0.12])));
        pairs.push((block([0.0; 3], [0.2, 0.16, cut]), block([0.0, 0.0, cut], [0.2, 0.16, 0.12])));
    }
    for (a, b) in pairs {
        let mut both = fill(&a, spacing, Vector3::zeros());
        both.extend(fill(&b, spacing, Vector3::zeros()));
        assert_eq!(sorted(both), expected, "{a:?}");
    }
}

#[test]
fn moved_and_turned_shapes_keep_their_size() {
    let quarter = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.5 * PI);
    for (name, shape) in all_shapes() {
        let by = at(0.3, -2.0, 1.1);
        let (then, now) = (shape.boundary(), shape.translated(&by).boundary());
        for x in fill(&ball([0.0; 3], 0.9), 0.37, Vector3::zeros()) {
            let (then, now) = (then.surface(&x), now.surface(&(x + by)));
            // Round-off, and of curves what their search leaves.
            assert!(
                (then.distance - now.distance).abs() < 1e-8,
                "{name} {x}: {} {}",
                then.distance,
                now.distance
            );
        }
        if !shape.is_composed() {
            let (then, now) = (then.moments(), now.moments());
            assert!((then.volume - now.volume).abs() < 1e-13, "{name}");
            assert!((then.centroid + by - now.centroid).norm() < 1e-13, "{name}");
        }
        let (lower, upper) = shape.bounds();
        let inside = fill(&block(lower.into(), upper.into()), 0.1, at(0.0031, 0.0017, 0.0023));
        let turned = shape.clone().placed(Frame::placed(&quarter, by));
        for x in inside {
            let moved = quarter * x + by;
            assert_eq!(shape.contains(&x), turned.contains(&moved), "{name}: {x}");
        }
    }
}

#[test]
fn wrong_shapes_are_refused_with_their_values() {
    let half = SpatialShape::HalfSpace { point: Vector3::zeros(), normal: Vector3::x() };
    let apart = SpatialShape::Intersection(vec![ball([0.0; 3], 0.1), ball([1.0, 0.0, 0.0], 0.1)]);
    let across = SpatialShape::Revolution { section: circle(0.1, 0.0, 0.2), frame: Frame::default() };
    for (shape, words) in [
        (block([0.0; 3], [1.0, 1.0, 0.0]), "upper must lie above lower"),
        (ball([0.0, f64::NAN, 0.0], 0.1), "all must be finite"),
        (rod([0.0; 3], [0.0; 3], 0.1, 0.0), "must be finite and not zero"),
        (rod([0.0; 3], [0.0, 0.0, 1.0], 0.1, 0.2), "inner radius = 0.2 m"),
        (half, "unbounded"),
        (apart, "no point in common"),
        (across, "x = -0.1 m"),
        (SpatialShape::Union(Vec::new()), "union has no parts"),
    ] {
        let error = shape.validate().expect_err(words);
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn pieces_of_the_faces_close_and_enclose_the_volume() {
    for (name, shape) in all_shapes() {
        let boundary = shape.boundary();
        let (lower, upper) = shape.bounds();
        let middle = (lower + upper) * 0.5;
        let pieces = boundary.pieces((upper - lower).norm() / 150.0);
        let area: f64 = pieces.iter().map(|(_, area)| area.norm()).sum();
        let sum: Vector3<f64> = pieces.iter().map(|(_, area)| area).sum();
        // ∮ n dA = 0, and by the divergence theorem ∮ x·n dA = 3 V; where faces cut each other pieces count whole or not at
        // all, which is right on average.
        assert!(sum.norm() < 0.01 * area, "{name}: {sum} of {area}");
        let volume = pieces.iter().map(|(x, area)| (x - middle).dot(area)).sum::<f64>() / 3.0;
        let exact = boundary.moments().volume;
        assert!((volume / exact - 1.0).abs() < 0.015, "{name}: {volume} {exact}");
        // Each piece lies on the surface, but for the chord of a curved one.
        let farthest = pieces.iter().map(|(x, _)| boundary.slope(x).0.abs()).fold(0.0, f64::max);
        assert!(farthest < 0.01 * (upper - lower).norm(), "{name}: {farthest}");
    }
}
