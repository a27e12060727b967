//! Inside, nearest places, volumes, defects and repairs.

use std::sync::Arc;

use super::*;
use crate::shapes::{Faces, Region, SpatialShape, fill};

#[test]
fn a_cube_is_sound_and_filled_like_a_box() {
    let surface = Surface::new(&unit_cube()).expect("facets");
    let found = surface.report();
    assert_eq!(found.problems(), Vec::<String>::new());
    assert_eq!((found.facets, found.vertices, found.components), (12, 8, 1));
    assert!((found.volume - 1.0).abs() < 1e-15 && (found.area - 6.0).abs() < 1e-14);
    let moments = surface.moments();
    for (k, second) in moments.second.iter().enumerate() {
        let exact = if k % 4 == 0 { 1.0 / 12.0 } else { 0.0 };
        assert!((second - exact).abs() < 1e-15, "{second}");
    }
    let shape = SpatialShape::Surface(Arc::new(surface));
    let same = SpatialShape::Box { lower: Vector3::zeros(), upper: Vector3::repeat(1.0) };
    // Faces between lattice points and through them.
    for (spacing, count) in [(0.05, 8000), (0.1, 1000), (2.0 / 19.0, 1000)] {
        let points = fill(&shape, spacing, Vector3::zeros());
        assert_eq!(points, fill(&same, spacing, Vector3::zeros()), "{spacing}");
        assert!(spacing > 0.1 || points.len() == count);
    }
    let (a, b) = (shape.boundary(), same.boundary());
    let around = SpatialShape::Box { lower: Vector3::repeat(-0.5), upper: Vector3::repeat(1.5) };
    for x in fill(&around, 0.17, Vector3::zeros()) {
        let (a, b) = (a.surface(&x), b.surface(&x));
        // Round-off.
        assert!((a.distance - b.distance).abs() < 1e-12, "{x}: {} {}", a.distance, b.distance);
        assert_eq!(a.at_vertex, b.at_vertex, "{x}");
        assert!(a.at_vertex || (a.normal - b.normal).norm() < 1e-12, "{x}");
    }
}

#[test]
fn winding_numbers_and_distances_of_a_sphere_are_those_of_the_sum_over_all_facets() {
    let facets = sphere(24);
    let surface = Surface::new(&facets).expect("facets");
    assert!(surface.report().is_sound());
    for k in 0..200 {
        let t = f64::from(k);
        let x = at((1.3 * t).sin(), (2.1 * t).cos(), (0.7 * t).sin()) * (0.02 * t / 2.0);
        let angle: f64 = facets.iter().map(|t| triangle::solid_angle(t, &x)).sum();
        let exact = angle / (4.0 * PI);
        // Groups of facets are dipoles from three of their radii on.
        assert!((surface.winding_number(&x) - exact).abs() < 0.01, "{x}: {}", surface.winding_number(&x));
        let near =
            facets.iter().map(|t| (triangle::nearest(t, &x).0 - x).norm()).fold(f64::INFINITY, f64::min);
        let foot = surface.nearest(&x);
        assert!(((foot.point - x).norm() - near).abs() < 1e-15);
        // Facets bend by 5 degrees at most.
        assert!(foot.normal.dot(&foot.point.normalize()) > 0.995);
    }
}

#[test]
fn every_defect_is_counted_with_its_place() {
    let cube_facets = unit_cube();
    let open = report(&cube_facets[..10]);
    assert_eq!(open.open_edges.count, 4);
    let place = open.open_edges.place.expect("a place");
    assert!((place.x - 1.0).abs() < 1e-12, "{place}");
    assert!(open.problems()[0].starts_with("4 open edges, the first at (1, "), "{:?}", open.problems());
    assert_eq!(report(&cube_facets[1..]).open_edges.count, 3);

    let mut mixed = cube_facets.clone();
    for facet in &mut mixed[0..2] {
        facet.swap(1, 2);
    }
    assert_eq!(report(&mixed).turned_edges.count, 4);
    assert!((report(&mixed).volume - 1.0).abs() < 1e-12 || report(&mixed).volume < 1.0);

    let inverted = report(&reversed(&cube_facets));
    assert_eq!((inverted.inverted.count, inverted.nested.count), (1, 0));
    assert!((inverted.volume + 1.0).abs() < 1e-15);

    let mut spoilt = cube_facets.clone();
    spoilt.push(spoilt[3]);
    spoilt.push([spoilt[0][0], spoilt[0][0], spoilt[0][1]]);
    let found = report(&spoilt);
    assert_eq!((found.degenerate.count, found.duplicates.count, found.crowded_edges.count), (1, 1, 3));

    let mut two = cube_facets.clone();
    two.extend(cube(at(0.5, 0.25, 0.25), at(1.5, 0.75, 0.75)));
    let found = report(&two);
    assert_eq!(found.components, 2);
    assert!(found.intersections.count > 0 && !found.is_sound());
    let place = found.intersections.place.expect("a place");
    assert!((place.x - 1.0).abs() < 0.5 + 1e-9, "{place}");

    // A cavity is none; the same facing outward counts twice.
    let inner = cube(Vector3::repeat(0.3), Vector3::repeat(0.7));
    let hollow: Vec<_> = cube_facets.iter().copied().chain(reversed(&inner)).collect();
    assert!(report(&hollow).is_sound(), "{:?}", report(&hollow).problems());
    let nested: Vec<_> = cube_facets.iter().copied().chain(inner).collect();
    assert_eq!(report(&nested).nested.count, 1);
}

#[test]
fn repairs_make_a_sound_surface_of_what_leaves_no_doubt() {
    let mut spoilt = reversed(&unit_cube());
    spoilt[4].swap(0, 1);
    spoilt[9].swap(0, 1);
    spoilt.push(spoilt[3]);
    spoilt.push([spoilt[0][0], spoilt[0][0], spoilt[0][1]]);
    let surface = Surface::new(&spoilt).expect("facets");
    let (repaired, done) = surface.repaired();
    let expected = [Repair::Collapsed(1), Repair::Duplicates(1), Repair::Turned(2), Repair::Inverted(1)];
    assert_eq!(done, expected);
    assert!(repaired.report().is_sound(), "{:?}", repaired.report().problems());
    assert!((repaired.moments().volume - 1.0).abs() < 1e-15);
    assert_eq!(Surface::new(&unit_cube()).expect("facets").repaired().1, []);
}

#[test]
fn a_small_hole_does_not_let_the_outside_in() {
    let mut facets = sphere(24);
    facets.remove(1000);
    let surface = Surface::new(&facets).expect("facets");
    assert_eq!(surface.report().open_edges.count, 3);
    for k in 0..100 {
        let t = f64::from(k);
        let x = at((1.3 * t).sin(), (2.1 * t).cos(), (0.7 * t).sin()).normalize();
        assert!(surface.contains(&(x * 0.95)) && !surface.contains(&(x * 1.05)));
    }
}

#[test]
fn the_thinnest_part_is_that_between_opposite_faces() {
    let plate = report(&cube(Vector3::zeros(), at(1.0, 1.0, 0.002))).thinnest.expect("opposite faces");
    assert!((plate.thickness - 0.002).abs() < 1e-9, "{plate:?}");
    let ball = report(&sphere(12)).thinnest.expect("opposite faces");
    // Facets lie a little within the sphere.
    assert!(ball.thickness > 1.95 && ball.thickness < 2.0, "{ball:?}");
    // A wedge of 45°: as thick straight below the middle of a slanted facet as the facet's middle is off the tip.
    let [a, b, c, d, e, f] = [
        at(0.0, 0.0, 0.0),
        at(1.0, 0.0, 0.0),
        at(1.0, 0.0, 1.0),
        at(0.0, 1.0, 0.0),
        at(1.0, 1.0, 0.0),
        at(1.0, 1.0, 1.0),
    ];
    let wedge = [[a, c, b], [d, e, f], [a, b, e], [a, e, d], [b, c, f], [b, f, e], [a, d, f], [a, f, c]];
    let found = report(&wedge.map(|[a, b, c]| [a, c, b]));
    assert!(found.volume.abs() > 0.49);
    assert!(found.thinnest.is_some_and(|thinnest| thinnest.thickness < 0.7), "{found:?}");
}

#[test]
fn a_surface_may_be_cut_by_other_shapes() {
    let ball = SpatialShape::Surface(Arc::new(Surface::new(&sphere(4)).expect("facets")));
    let lid = SpatialShape::HalfSpace { point: Vector3::zeros(), normal: at(0.0, 0.0, 1.0) };
    let bowl = SpatialShape::Intersection(vec![ball.clone(), lid]);
    let boundary = bowl.boundary();
    let whole = ball.boundary().volume();
    // Measured by cubes of a 128th.
    assert!((boundary.volume() / whole - 0.5).abs() < 2e-4, "{}", boundary.volume() / whole);
    assert!((boundary.surface(&at(0.2, 0.1, 0.3)).distance - 0.3).abs() < 1e-12);
    assert!((boundary.surface(&at(0.2, 0.1, -0.3)).distance + 0.3).abs() < 1e-12);
    // Beyond the rim, which has facets of a quarter of a quarter circle.
    let rim = boundary.surface(&at(1.3, 0.0, 0.4));
    assert!((rim.distance - 0.5).abs() < 1e-9 && rim.at_vertex, "{rim:?}");
}
