use std::f64::consts::{PI, SQRT_2};

use super::*;
use crate::space::domain::Domain;

fn at(x: f64, y: f64) -> Vector {
    Vector::new(x, y)
}

fn rectangle(x: f64, y: f64, width: f64, height: f64) -> Shape {
    Shape::Rectangle { lower: at(x, y), upper: at(x + width, y + height) }
}

fn circle(x: f64, y: f64, radius: f64) -> Shape {
    Shape::Circle { centre: at(x, y), radius }
}

fn minus(base: Shape, removed: Shape) -> Shape {
    Shape::Difference(Box::new(base), vec![removed])
}

fn area(shape: &Shape, spacing: f64) -> f64 {
    // The count of a test is far below 2^32.
    f64::from(u32::try_from(fill(shape, spacing, Vector::zeros()).len()).expect("small")) * spacing * spacing
}

fn sorted(mut points: Vec<Vector>) -> Vec<Vector> {
    points.sort_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
    points
}

#[test]
fn column_of_case_5_2_has_73_by_146_particles_in_rows() {
    let points = fill(&rectangle(0.0, 0.0, 0.146, 0.292), 0.002, Vector::zeros());
    assert_eq!(points.len(), 73 * 146);
    assert_eq!(points[0], at(0.001, 0.001));
    assert_eq!(points[1], at(0.003, 0.001));
    assert!((points[73] - at(0.001, 0.003)).norm() < 1e-15);
}

#[test]
fn aligned_rectangles_have_whole_counts_at_any_spacing_and_origin() {
    for spacing in [0.003, 0.002, 0.0007, 0.1, 1.0 / 3.0] {
        for (columns, rows, left, below) in
            [(167_u32, 3_u32, 0, 0), (1, 1, -7, 13), (18, 18, 117, 4), (6, 40, 199, -2)]
        {
            let origin = at(0.017, -0.31);
            let corner = origin + at(f64::from(left), f64::from(below)) * spacing;
            let shape =
                rectangle(corner.x, corner.y, f64::from(columns) * spacing, f64::from(rows) * spacing);
            let count = fill(&shape, spacing, origin).len();
            assert_eq!(
                count,
                usize::try_from(columns * rows).expect("small"),
                "{spacing}: {columns} x {rows}"
            );
        }
    }
}

#[test]
fn neighbouring_shapes_share_no_lattice_point_and_leave_none_out() {
    let spacing = 0.002;
    let whole = rectangle(0.0, 0.0, 0.1, 0.06);
    // Cuts through lattice points (odd multiples of half a spacing), between them, and off both.
    for cut in [0.011, 0.049, 0.02, 0.013_7, 0.047] {
        let left = Shape::Rectangle { lower: at(0.0, 0.0), upper: at(cut, 0.06) };
        let right = Shape::Rectangle { lower: at(cut, 0.0), upper: at(0.1, 0.06) };
        let mut both = fill(&left, spacing, Vector::zeros());
        both.extend(fill(&right, spacing, Vector::zeros()));
        assert_eq!(sorted(both), fill(&whole, spacing, Vector::zeros()), "cut at {cut}");
    }
    // A slanted cut along a lattice diagonal, and a hole with its plug.
    let below = Shape::Polygon { vertices: vec![at(0.0, 0.0), at(0.1, 0.0), at(0.1, 0.06), at(0.06, 0.06)] };
    let above = Shape::Polygon { vertices: vec![at(0.0, 0.0), at(0.06, 0.06), at(0.0, 0.06)] };
    let plug = circle(0.05, 0.03, 0.011);
    for (a, b) in [(below, above), (minus(whole.clone(), plug.clone()), plug)] {
        let mut both = fill(&a, spacing, Vector::zeros());
        both.extend(fill(&b, spacing, Vector::zeros()));
        assert_eq!(sorted(both), fill(&whole, spacing, Vector::zeros()));
    }
}

#[test]
fn polygon_equals_the_same_rectangle_in_either_sense() {
    let same = rectangle(0.1, -0.2, 0.3, 0.5);
    let mut vertices = vec![at(0.1, -0.2), at(0.4, -0.2), at(0.4, 0.3), at(0.1, 0.3)];
    for _ in 0..2 {
        let polygon = Shape::Polygon { vertices: vertices.clone() };
        assert_eq!(polygon.bounds(), (at(0.1, -0.2), at(0.4, 0.3)));
        for origin in [Vector::zeros(), at(0.005, 0.005)] {
            assert_eq!(fill(&polygon, 0.01, origin), fill(&same, 0.01, origin));
        }
        let (a, b) = (polygon.boundary(), same.boundary());
        for point in fill(&rectangle(0.0, -0.3, 0.5, 0.7), 0.023, Vector::zeros()) {
            let (p, r) = (a.surface(&point), b.surface(&point));
            // Lengths below 1, a few operations.
            assert!((p.distance - r.distance).abs() < 1e-15 && (p.normal - r.normal).norm() < 1e-12);
            assert_eq!(p.at_vertex, r.at_vertex);
        }
        vertices.reverse();
    }
}

#[test]
fn areas_of_curved_and_composed_shapes_converge_to_the_exact_ones() {
    let lens = |r: f64, d: f64| 2.0 * r * r * (d / (2.0 * r)).acos() - 0.5 * d * (4.0 * r * r - d * d).sqrt();
    let (a, b) = (circle(0.0, 0.0, 1.0), circle(1.0, 0.0, 1.0));
    for (shape, exact) in [
        (a.clone(), PI),
        (Shape::Ring { centre: at(0.3, 0.1), inner_radius: 0.5, outer_radius: 1.0 }, 0.75 * PI),
        (Shape::Union(vec![a.clone(), b.clone()]), 2.0 * PI - lens(1.0, 1.0)),
        (minus(a, b), PI - lens(1.0, 1.0)),
        (
            Shape::Polygon { vertices: vec![at(0.0, 0.0), at(1.0, 0.2), at(0.3, 1.1)] },
            0.5 * (1.1 - 0.3 * 0.2),
        ),
    ] {
        // Gauss' circle problem: the error of a lattice count is below the perimeter's cells, 10·0.01, far below in fact.
        assert!((area(&shape, 0.01) - exact).abs() < 0.01, "{} not {exact}", area(&shape, 0.01));
    }
}

#[test]
fn signed_distance_and_normal_of_primitives() {
    let square = rectangle(0.0, 0.0, 2.0, 2.0);
    let inside = square.surface(&at(1.0, 0.25));
    assert_eq!((inside.distance, inside.normal, inside.at_vertex), (-0.25, at(0.0, -1.0), false));
    let beside = square.surface(&at(2.5, 1.5));
    assert_eq!((beside.distance, beside.normal, beside.at_vertex), (0.5, at(1.0, 0.0), false));
    let off_corner = square.surface(&at(5.0, 6.0));
    assert!(off_corner.at_vertex);
    assert!((off_corner.distance - 5.0).abs() < 1e-15);
    assert!((off_corner.normal - at(1.0, 1.0) / SQRT_2).norm() < 1e-15);
    assert!(square.surface(&at(1.7, 1.7)).at_vertex, "equally near two faces");

    let disc = circle(1.0, 0.0, 2.0).surface(&at(1.0, 0.5));
    assert_eq!((disc.distance, disc.normal), (-1.5, at(0.0, 1.0)));
    let ring = Shape::Ring { centre: at(0.0, 0.0), inner_radius: 1.0, outer_radius: 3.0 };
    assert_eq!(ring.surface(&at(1.5, 0.0)).normal, at(-1.0, 0.0));
    assert_eq!(ring.surface(&at(0.0, 2.5)).normal, at(0.0, 1.0));
    assert_eq!(ring.surface(&at(0.5, 0.0)).distance, 0.5);
    assert!(circle(0.0, 0.0, 1.0).surface(&at(0.0, 0.0)).at_vertex, "no direction from the centre");
}

#[test]
fn boundaries_of_composed_shapes_drop_what_is_covered() {
    // Two halves are one square: the shared side is no surface.
    let halves = Shape::Union(vec![rectangle(0.0, 0.0, 1.0, 2.0), rectangle(1.0, 0.0, 1.0, 2.0)]);
    assert!((halves.boundary().length() - 8.0).abs() < 1e-6);
    let centre = halves.surface(&at(1.0, 0.5));
    assert_eq!((centre.distance, centre.normal), (-0.5, at(0.0, -1.0)));
    // An arch: half circle on a square.
    let arch = Shape::Union(vec![rectangle(-1.0, 0.0, 2.0, 1.0), circle(0.0, 1.0, 1.0)]);
    assert!((arch.boundary().length() - (1.0 + 2.0 + 1.0 + PI)).abs() < 1e-6);
    // A disc cut in two by a strip of half its width: each side loses a sixth of the circle and gains a chord.
    let parted = minus(circle(0.0, 0.0, 1.0), rectangle(-2.0, -0.5, 4.0, 1.0));
    assert!((parted.boundary().length() - (4.0 / 3.0 * PI + 2.0 * 3.0_f64.sqrt())).abs() < 1e-6);
    // One disc inside another that it touches, on the right where angles begin and on the left.
    for x in [0.5, -0.5] {
        let touching = minus(circle(0.0, 0.0, 1.0), circle(x, 0.0, 0.5));
        assert!((touching.boundary().length() - 3.0 * PI).abs() < 1e-6);
        let filled = Shape::Union(vec![circle(0.0, 0.0, 1.0), circle(x, 0.0, 0.5)]);
        assert!((filled.boundary().length() - 2.0 * PI).abs() < 1e-6);
    }
    // A notch through the upper side: three new sides for the one removed.
    let notched = minus(rectangle(0.0, 0.0, 3.0, 2.0), rectangle(1.0, 1.0, 1.0, 5.0));
    assert!((notched.boundary().length() - 12.0).abs() < 1e-6);
    // Two overlapping discs of equal radius, centres one radius apart: 2/3 of each circle is outside.
    let pair = Shape::Union(vec![circle(0.0, 0.0, 1.0), circle(1.0, 0.0, 1.0)]);
    assert!((pair.boundary().length() - 8.0 / 3.0 * PI).abs() < 1e-6);
    // The crescent: its outer arc 4/3 π and the inner one 2/3 π, normal toward the bite.
    let crescent = minus(circle(0.0, 0.0, 1.0), circle(1.0, 0.0, 1.0));
    assert!((crescent.boundary().length() - 2.0 * PI).abs() < 1e-6);
    assert!((crescent.surface(&at(-0.1, 0.0)).normal - at(1.0, 0.0)).norm() < 1e-12);
    assert!((crescent.surface(&at(0.2, 0.0)).distance - 0.2).abs() < 1e-12);
}

#[test]
fn tank_walls_have_the_closed_form_count_and_inward_normals() {
    let spacing = 0.002;
    let (columns, rows, layers) = (292_u32, 292_u32, 3_u32);
    let tank = rectangle(0.0, 0.0, 0.584, 0.584);
    let open = OpenSides { upper: [false, true], ..OpenSides::default() };
    let walls = layers_around(&tank, &tank.boundary(), spacing, layers, Vector::zeros(), open);
    // Behind each corner the cells whose centres lie within three spacings of it: all nine but the outermost.
    let corner = (0..9_u32)
        .filter(|cell| at(f64::from(cell % 3) + 0.5, f64::from(cell / 3) + 0.5).norm() < f64::from(layers))
        .count();
    assert_eq!(corner, 8);
    let straight = layers * (columns + 2 * rows);
    assert_eq!(walls.len(), usize::try_from(straight).expect("small") + 2 * corner);
    for LayerParticle { position, normal } in &walls {
        let expected = match (position.x < 0.0, position.x > 0.584, position.y < 0.0) {
            (true, _, false) => at(1.0, 0.0),
            (_, true, false) => at(-1.0, 0.0),
            (false, false, true) => at(0.0, 1.0),
            _ => at(0.0, 0.0),
        };
        assert_eq!(*normal, expected, "at {position}");
        assert!(position.y < 0.584, "the rim is open");
    }
    let rim = walls.iter().map(|wall| wall.position.y).fold(0.0, f64::max);
    assert!((rim - 0.583).abs() < 1e-12, "the side walls end at the rim, not below");
    let closed =
        layers_around(&tank, &tank.boundary(), spacing, layers, Vector::zeros(), OpenSides::default());
    assert_eq!(closed.len(), usize::try_from(layers * 2 * (columns + rows)).expect("small") + 4 * corner);
}

#[test]
fn walls_and_filling_of_a_container_do_not_meet() {
    let spacing = 0.01;
    for container in [
        circle(0.0, 0.0, 0.3),
        rectangle(0.003, 0.004, 0.301, 0.2),
        minus(rectangle(0.0, 0.0, 0.4, 0.3), rectangle(0.2, -0.1, 0.3, 0.2)),
        Shape::Polygon { vertices: vec![at(0.0, 0.0), at(0.4, 0.1), at(0.2, 0.35)] },
    ] {
        let inner = fill(&container, spacing, Vector::zeros());
        let walls = layers_around(
            &container,
            &container.boundary(),
            spacing,
            3,
            Vector::zeros(),
            OpenSides::default(),
        );
        let mut all: Vec<Vector> =
            inner.iter().copied().chain(walls.iter().map(|wall| wall.position)).collect();
        let count = all.len();
        all.sort_by(|a, b| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x)));
        all.dedup();
        assert_eq!(all.len(), count);
        // No hole: all lattice neighbours of a filling particle exist, up to two spacings away.
        for particle in &inner {
            for offset in
                [at(2.0, 0.0), at(0.0, 2.0), at(-2.0, 0.0), at(0.0, -2.0), at(1.0, 1.0), at(-1.0, 1.0)]
            {
                let wanted = particle + offset * spacing;
                assert!(all.iter().any(|point| (point - wanted).norm() < 1e-9), "nothing at {wanted}");
            }
        }
    }
}

#[test]
fn a_step_in_a_tank_has_its_own_normals() {
    // Floor at y = 0 left of x = 0.2; step of height 0.1 right of it.
    let tank = minus(rectangle(0.0, 0.0, 0.4, 0.3), rectangle(0.2, -0.1, 0.3, 0.2));
    let walls = layers_around(&tank, &tank.boundary(), 0.01, 3, Vector::zeros(), OpenSides::default());
    let normal_at = |x: f64, y: f64| {
        walls.iter().find(|wall| (wall.position - at(x, y)).norm() < 1e-9).expect("wall particle").normal
    };
    assert_eq!(normal_at(0.105, -0.005), at(0.0, 1.0));
    assert_eq!(normal_at(0.215, 0.055), at(-1.0, 0.0));
    assert_eq!(normal_at(0.305, 0.085), at(0.0, 1.0));
    // The tank's lower right corner behind floor and step, and the step's own edge seen along its diagonal.
    assert_eq!(normal_at(0.215, -0.005), at(0.0, 0.0));
    assert_eq!(normal_at(0.215, 0.085), at(0.0, 0.0));
}

#[test]
fn round_walls_have_radial_normals_also_when_drawn_with_many_edges() {
    let edges = 90;
    let vertices = (0..edges)
        .map(|k| {
            let angle = f64::from(k) / f64::from(edges) * 2.0 * PI;
            at(angle.cos(), angle.sin())
        })
        .collect();
    for (container, tolerance) in
        [(circle(0.0, 0.0, 1.0), 1e-12), (Shape::Polygon { vertices }, 2.0 * PI / 90.0)]
    {
        for wall in
            layers_around(&container, &container.boundary(), 0.05, 3, Vector::zeros(), OpenSides::default())
        {
            let inward = -wall.position.normalize();
            // Half the turn from edge to edge, twice that where the nearest edge changes.
            assert!((wall.normal - inward).norm() < tolerance, "{} at {}", wall.normal, wall.position);
        }
    }
}

#[test]
fn a_solid_wall_faces_outward_and_its_corner_diagonals_have_no_normal() {
    let walls = wall_fill(
        &rectangle(0.0, 0.0, 1.0, 0.4),
        &rectangle(0.0, 0.0, 1.0, 0.4).boundary(),
        0.1,
        Vector::zeros(),
    );
    assert_eq!(walls.len(), 40);
    let normal_at = |column: usize, row: usize| walls[10 * row + column].normal;
    assert_eq!(normal_at(0, 0), at(0.0, 0.0));
    assert_eq!(normal_at(1, 1), at(0.0, 0.0));
    assert_eq!(normal_at(9, 3), at(0.0, 0.0));
    assert_eq!(normal_at(0, 1), at(-1.0, 0.0));
    assert_eq!(normal_at(1, 0), at(0.0, -1.0));
    assert_eq!(normal_at(5, 3), at(0.0, 1.0));
    // Middle row of an odd number: both faces equally near, one line of normals.
    let plate = wall_fill(
        &rectangle(0.0, 0.0, 1.0, 0.3),
        &rectangle(0.0, 0.0, 1.0, 0.3).boundary(),
        0.1,
        Vector::zeros(),
    );
    assert_eq!(plate[15].normal.x, 0.0);
    assert_eq!(plate[15].normal.y.abs(), 1.0);
}

#[test]
fn translation_moves_the_filling() {
    let shape = minus(
        Shape::Union(vec![rectangle(0.0, 0.0, 1.0, 1.0), circle(1.0, 1.0, 0.4)]),
        circle(0.2, 0.2, 0.1),
    );
    let moved = shape.translated(&at(3.0, -2.0));
    let expected: Vec<Vector> =
        fill(&shape, 0.125, Vector::zeros()).iter().map(|x| x + at(3.0, -2.0)).collect();
    // Whole numbers of eighths: exact.
    assert_eq!(fill(&moved, 0.125, Vector::zeros()), expected);
}

#[test]
fn displacements_are_bounded_repeatable_and_fixed_for_ever() {
    let domain: Domain = Domain { lower: at(0.0, 0.0), upper: at(1.0, 1.0), periodic: [true, false] };
    let lattice = fill(&rectangle(0.0, 0.0, 1.0, 1.0), 0.02, Vector::zeros());
    let displaced = |seed| {
        let mut positions = lattice.clone();
        displace(&mut positions, 0.005, seed, &domain);
        positions
    };
    let positions = displaced(7);
    assert_eq!(positions, displaced(7));
    assert_ne!(positions, displaced(8));
    let mut square_sum = 0.0;
    for (now, then) in positions.iter().zip(&lattice) {
        let moved = domain.separation(now, then);
        assert!(moved.x.abs() <= 0.005 && moved.y.abs() <= 0.005);
        assert!((0.0..1.0).contains(&now.x));
        square_sum += moved.norm_squared();
    }
    // Variance a²/3 per component; 5,000 samples scatter it by about 1.3 %.
    assert!((square_sum / 2500.0 / (2.0 * 0.005_f64.powi(2) / 3.0) - 1.0).abs() < 0.06);
    // First output of SplitMix64 seeded with 0 is 0xe220a8397b1dcdaf, its second 0x6e789e6aa1b965f4.
    let mut origin = [Vector::zeros()];
    let open = Domain { periodic: [false; 2], ..domain };
    displace(&mut origin, 1.0, 0, &open);
    let fraction = |bits: u64| 2.0 * ((bits >> 11) as f64 / 2.0_f64.powi(53)) - 1.0;
    assert_eq!(origin[0], at(fraction(0xe220_a839_7b1d_cdaf), fraction(0x6e78_9e6a_a1b9_65f4)));
}

#[test]
fn wrong_shapes_are_told_with_their_values() {
    let polygon = |corners: &[(f64, f64)]| Shape::Polygon {
        vertices: corners.iter().map(|(x, y)| at(*x, *y)).collect(),
    };
    let mut nested = circle(0.0, 0.0, 1.0);
    for _ in 0..20 {
        nested = Shape::Union(vec![nested]);
    }
    for (shape, parts) in [
        (rectangle(0.0, 0.0, -1.0, 1.0), vec!["lower x = 0 m", "upper x = -1 m", "above"]),
        (rectangle(0.0, 0.0, 1.0, 0.0), vec!["lower y = 0 m", "upper y = 0 m"]),
        (rectangle(f64::NAN, 0.0, 1.0, 1.0), vec!["lower corner", "NaN", "finite"]),
        (circle(0.0, 0.0, 0.0), vec!["radius = 0 m", "positive"]),
        (circle(0.0, f64::INFINITY, 1.0), vec!["centre", "inf"]),
        (
            Shape::Ring { centre: at(0.0, 0.0), inner_radius: 2.0, outer_radius: 1.0 },
            vec!["inner radius = 2 m", "outer radius = 1 m"],
        ),
        (polygon(&[(0.0, 0.0), (1.0, 0.0)]), vec!["2 vertices", "3 to"]),
        (
            polygon(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]),
            vec!["vertices 1 (0, 0) and 3 (1, 0)", "cross"],
        ),
        (polygon(&[(0.0, 0.0), (1.0, 0.0), (1.0, 0.0), (0.0, 1.0)]), vec!["same point", "2 (1, 0)"]),
        (polygon(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]), vec!["straight back", "3 (2, 0)"]),
        (polygon(&[(0.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 1.0)]), vec!["straight back"]),
        (Shape::Union(vec![]), vec!["union has no parts"]),
        (
            minus(rectangle(0.0, 0.0, 1.0, 1.0), circle(0.0, 0.0, -1.0)),
            vec!["part 1 of difference", "radius = -1 m"],
        ),
        (nested, vec!["nested more than 16 deep"]),
    ] {
        let message = shape.validate().expect_err(&format!("{shape:?}"));
        for part in parts {
            assert!(message.contains(part), "`{message}` lacks `{part}`");
        }
    }
    assert_eq!(
        polygon(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 1.0)]).validate(),
        Ok(()),
        "flat vertices are fine"
    );
    assert_eq!(minus(rectangle(0.0, 0.0, 1.0, 1.0), circle(0.5, 0.5, 0.1)).validate(), Ok(()));
}

#[test]
fn a_spacing_far_too_small_is_seen_before_the_work() {
    let tank = rectangle(0.0, 0.0, 0.5, 0.3);
    let filled = fill(&tank, 0.01, Vector::zeros()).len();
    assert!(lattice_points(&tank, 0.01, 0.0) >= f64::from(u32::try_from(filled).expect("small")));
    assert!(lattice_points(&tank, 1e-9, 0.0) > 1e17);
}

#[test]
fn thickness_is_that_of_the_thinnest_part_and_corners_are_not_thin() {
    let spacing = 0.1;
    let thickness = |shape: &Shape| {
        let points = fill(shape, spacing, Vector::zeros());
        let mut found = local_thickness(shape, &points, spacing, 1.0);
        found.sort_by(f64::total_cmp);
        found
    };
    for rows in 1..=6 {
        let rows = f64::from(rows);
        let plate = thickness(&rectangle(0.0, 0.0, 3.0, rows * spacing));
        // Beside its four corners.
        assert!((plate[4] - rows * spacing).abs() < 1e-9, "{rows} rows: {plate:?}");
    }
    let square = thickness(&rectangle(0.0, 0.0, 2.0, 2.0));
    // Up to the limit of ten rows away from the corners.
    assert!(square[0] > 4.5 * spacing && square[20] > 9.9 * spacing, "{square:?}");
    // A fin of two rows on a thick foot.
    let finned = Shape::Union(vec![rectangle(0.0, 0.0, 2.0, 1.0), rectangle(0.9, 1.0, 0.2, 1.0)]);
    let finned = thickness(&finned);
    assert!((finned[0] - 0.2).abs() < 1e-9 && finned[30] > 0.4, "{finned:?}");
    let disc = thickness(&circle(0.0, 0.0, 0.35));
    assert!((disc[0] - 0.7).abs() < 0.1, "{disc:?}");
}
