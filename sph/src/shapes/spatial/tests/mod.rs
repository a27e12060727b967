use nalgebra::UnitQuaternion;

use super::*;
use crate::shapes::{Faces, LayerParticle, OpenSides, fill, layers_around, wall_fill};

fn at(x: f64, y: f64, z: f64) -> Vector3<f64> {
    Vector3::new(x, y, z)
}

#[test]
fn a_box_is_filled_in_layers_and_rows() {
    let tank = SpatialShape::Box { lower: at(0.0, 0.0, 0.0), upper: at(0.3, 0.2, 0.1) };
    let points = fill(&tank, 0.01, Vector3::zeros());
    assert_eq!(points.len(), 30 * 20 * 10);
    assert!((points[1] - at(0.015, 0.005, 0.005)).norm() < 1e-15);
    assert!((points[30] - at(0.005, 0.015, 0.005)).norm() < 1e-15);
    assert!((points[600] - at(0.005, 0.005, 0.015)).norm() < 1e-15);
}

#[test]
fn walls_of_an_open_box_have_whole_layers_and_normals() {
    let tank = SpatialShape::Box { lower: at(0.0, 0.0, 0.0), upper: at(0.3, 0.2, 0.1) };
    let open = OpenSides { upper: [false, false, true], ..OpenSides::default() };
    let wall = layers_around(&tank, &tank.boundary(), 0.01, 3, Vector3::zeros(), open);
    let inside_of_edges = 30 * 20 * 3 + 2 * (30 + 20) * 10 * 3;
    let faces = wall.iter().filter(|particle| particle.normal != Vector3::zeros()).count();
    assert_eq!(faces, inside_of_edges);
    for LayerParticle { position, normal } in &wall {
        let below = position.z < 0.0 && tank.contains(&at(position.x, position.y, 0.05));
        assert_eq!(below, (normal - Vector3::z()).norm() < 1e-12, "{position} {normal}");
        assert!(position.z < 0.1);
    }
}

#[test]
fn layers_of_a_sphere_point_out_of_it() {
    let ball = SpatialShape::Sphere { centre: at(0.1, 0.2, -0.1), radius: 0.1 };
    let boundary = ball.boundary();
    assert!((boundary.volume() - 4.188_790_204_786_391e-3).abs() < 1e-15);
    for LayerParticle { position, normal } in wall_fill(&ball, &boundary, 0.01, Vector3::zeros()) {
        let from_centre = position - at(0.1, 0.2, -0.1);
        let distance = boundary.surface(&position).distance;
        assert!((distance - (from_centre.norm() - 0.1)).abs() < 1e-15);
        if from_centre.norm() > 1e-9 {
            assert!((normal - from_centre.normalize()).norm() < 1e-12);
        }
    }
}

mod fitted;
mod nearest;
mod volumes;

fn circle(x: f64, y: f64, radius: f64) -> Shape {
    Shape::Circle { centre: Vector2::new(x, y), radius }
}

fn block(lower: [f64; 3], upper: [f64; 3]) -> SpatialShape {
    SpatialShape::Box { lower: lower.into(), upper: upper.into() }
}

fn ball(centre: [f64; 3], radius: f64) -> SpatialShape {
    SpatialShape::Sphere { centre: centre.into(), radius }
}

fn rod(from: [f64; 3], to: [f64; 3], radius: f64, inner_radius: f64) -> SpatialShape {
    SpatialShape::Cylinder { from: from.into(), to: to.into(), radius, inner_radius }
}

/// Shapes of every kind, about one in size.
fn all_shapes() -> Vec<(&'static str, SpatialShape)> {
    let l = [[0.0, 0.0], [0.8, 0.0], [0.8, 0.3], [0.3, 0.3], [0.3, 0.7], [0.0, 0.7]];
    let section = Shape::Polygon { vertices: l.map(Vector2::from).to_vec() };
    let tilted = Frame::new(at(0.1, -0.2, 0.0), &at(1.0, 0.4, -0.2), &at(0.0, 1.0, 0.5)).expect("axes");
    let upright = Frame::along(at(0.0, 0.1, 0.0), &at(0.0, 1.0, 0.0)).expect("axis");
    let bowl = Shape::Difference(Box::new(circle(0.5, 0.0, 0.4)), vec![circle(0.5, 0.25, 0.25)]);
    let cube = block([-0.5; 3], [0.5; 3]);
    let minus =
        |base: SpatialShape, parts: Vec<SpatialShape>| SpatialShape::Difference(Box::new(base), parts);
    vec![
        ("box", cube.clone()),
        ("sphere", ball([0.1, 0.2, 0.3], 0.5)),
        ("cylinder", rod([-0.3, 0.1, 0.0], [0.4, 0.3, 0.5], 0.3, 0.0)),
        ("tube", rod([0.0, 0.0, -0.4], [0.0, 0.0, 0.4], 0.4, 0.25)),
        ("cone", SpatialShape::Cone { from: at(0.0, 0.0, 0.0), to: at(0.0, 0.2, 0.8), radii: [0.4, 0.0] }),
        ("frustum", SpatialShape::Cone { from: at(0.0, 0.0, 0.0), to: at(0.8, 0.0, 0.0), radii: [0.2, 0.5] }),
        (
            "torus",
            SpatialShape::Torus {
                centre: at(0.0, 0.1, 0.0),
                axis: at(0.2, 0.3, 2.0),
                radius: 0.5,
                tube_radius: 0.2,
            },
        ),
        ("extrusion", SpatialShape::Extrusion { section: section.clone(), frame: tilted, height: 0.6 }),
        ("revolution", SpatialShape::Revolution { section, frame: upright }),
        ("bowl", SpatialShape::Revolution { section: bowl, frame: tilted }),
        ("boxes", SpatialShape::Union(vec![cube.clone(), block([0.2, 0.1, 0.0], [0.9, 0.7, 0.8])])),
        ("balls", SpatialShape::Union(vec![ball([0.0; 3], 0.5), ball([0.5, 0.2, 0.1], 0.4)])),
        ("drilled", minus(cube.clone(), vec![rod([-1.0, 0.1, 0.0], [1.0, 0.1, 0.05], 0.3, 0.0)])),
        (
            "bitten",
            minus(cube.clone(), vec![ball([0.5; 3], 0.45), block([-0.6, -0.6, -0.1], [0.0, 0.0, 0.6])]),
        ),
        (
            "dome",
            SpatialShape::Intersection(vec![
                ball([0.0; 3], 0.6),
                SpatialShape::HalfSpace { point: at(0.0, 0.0, 0.1), normal: at(0.3, 0.1, -1.0) },
            ]),
        ),
        ("lens", SpatialShape::Intersection(vec![ball([0.0; 3], 0.6), ball([0.0, 0.0, 0.7], 0.5)])),
        ("turned", minus(cube, vec![ball([0.5, 0.0, 0.0], 0.3)]).placed(tilted)),
    ]
}
