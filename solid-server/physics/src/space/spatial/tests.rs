use super::*;

type Rotation = UnitQuaternion<f64>;

fn turn(x: f64, y: f64, z: f64) -> Rotation {
    Rotation::from_scaled_axis(Vector3::new(x, y, z))
}

/// Places of unlike masses: a cloud squeezed by `squeeze` along the axes.
fn cloud(squeeze: Vector3<f64>) -> Vec<(f64, Vector3<f64>)> {
    (0..40)
        .map(|k| {
            let at = |factor: f64| (factor * f64::from(k)).sin();
            (1.0 + 0.5 * at(0.7), Vector3::new(at(1.3), at(2.1), at(3.7)).component_mul(&squeeze))
        })
        .collect()
}

fn fitted(places: &[(f64, Vector3<f64>)], turn: Rotation, near: Rotation) -> Rotation {
    Spatial::best_fit_rotation(places.len(), |k| (places[k].0, places[k].1, turn * places[k].1), near)
}

#[test]
fn the_best_fit_of_a_rotation_is_that_rotation() {
    let identity = Rotation::identity();
    for turn in [turn(0.1, 0.2, -0.3), turn(2.0, -1.5, 1.0), turn(0.0, 3.1, 0.0)] {
        // A body, a sheet, and one that the sheet's mirror image would fit as well.
        for squeeze in [Vector3::repeat(1.0), Vector3::new(1.0, 1.0, 0.0), Vector3::new(0.0, 1.0, 1e-9)] {
            let places = cloud(squeeze);
            let found = fitted(&places, turn, identity);
            // Round-off.
            if squeeze.z != 1e-9 {
                assert!(found.angle_to(&turn) < 1e-7, "{squeeze} {found} {turn}");
            }
            for (_, x) in &places {
                assert!((found * x - turn * x).norm() < 1e-8);
            }
            // Whichever of its two quaternions is nearer.
            assert!(found.coords.dot(&identity.coords) >= 0.0);
            assert!((Spatial::rotation_matrix(found).determinant() - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn a_row_keeps_its_turn_about_itself() {
    let places = cloud(Vector3::new(1.0, 0.0, 0.0));
    let (turn, near) = (turn(0.0, 0.3, -0.2), turn(0.4, 0.0, 0.0));
    let found = fitted(&places, turn * near, near);
    assert!((found * Vector3::x() - turn * Vector3::x()).norm() < 1e-12);
    // The least rotation from there.
    assert!((found * near.inverse() * Vector3::x() - turn * Vector3::x()).norm() < 1e-12);
    assert!(found.angle_to(&(turn * near)) < 0.05);
    assert_eq!(fitted(&cloud(Vector3::zeros()), turn, near), near);
}

#[test]
fn a_free_body_keeps_its_angular_momentum_and_turns_the_same_back() {
    let inertia = Matrix3::new(3.0, 0.2, 0.1, 0.2, 2.0, -0.3, 0.1, -0.3, 1.5);
    let (rotation, spin) = (turn(0.3, -0.7, 1.1), Vector3::new(1.0, -2.0, 0.5));
    let momentum = |rotation, spin| turned(&inertia, rotation) * spin;
    let (then, after) = Spatial::coasted(inertia, rotation, spin, 0.05);
    // Round-off.
    assert!((momentum(then, after) - momentum(rotation, spin)).norm() < 1e-14);
    let (back, before) = Spatial::coasted(inertia, then, after, -0.05);
    assert!(back.angle_to(&rotation) < 1e-7 && (before - spin).norm() < 1e-13);
    // A torque changes it by itself times the duration.
    let torque = Vector3::new(0.4, 0.1, -0.9);
    let spun = Spatial::spin_after(inertia, [rotation, then], spin, torque, 0.05);
    let gain = Spatial::angular_gain(inertia, (rotation, spin), (then, spun));
    assert!((gain - torque * 0.05).norm() < 1e-14);
}

#[test]
fn the_weights_of_a_lattice_sum_to_one() {
    let (spacing, support) = (0.01, 0.03);
    let scale = Spatial::wendland_weight(spacing, support);
    let weight = |r: f64| {
        let q = (r / support).min(1.0);
        scale * (1.0 - q).powi(4) * (1.0 + 4.0 * q)
    };
    // At the face, half a spacing over the outer row, two half-spaces are all of space; sums of 100 terms for an integral.
    let half = Spatial::over_half_space(3.0, 0.3, 0.5 * spacing, spacing, weight);
    assert!((half - 0.5).abs() < 0.005, "{half}");
}

#[test]
fn the_shear_measure_is_its_formula_and_sees_no_rotation() {
    let f: Matrix3<f64> = Matrix3::new(1.2, 0.3, -0.1, 0.05, 0.8, 0.2, -0.2, 0.1, 1.1);
    let plain = f.norm_squared() - 3.0 - 2.0 * f.determinant().ln();
    assert!((Spatial::shear_measure(&f) - plain).abs() < 1e-14);
    let rotation = Spatial::rotation_matrix(turn(1.0, 2.0, -0.5));
    assert!(Spatial::shear_measure(&rotation).abs() < 1e-15);
    // Small strains: 2 dev ε : dev ε + ⅔·… = 2 ε:ε to the third order.
    let strain = Matrix3::new(1.0, 0.5, 0.2, 0.5, -0.4, 0.1, 0.2, 0.1, 0.3) * 1e-7;
    let small = Spatial::shear_measure(&(rotation * (Matrix3::identity() + strain)));
    // Round-off of B, 1e-16 over 1e-7.
    assert!((small / (2.0 * strain.norm_squared()) - 1.0).abs() < 1e-6, "{small}");
}

#[test]
fn stretches_are_those_of_the_principal_axes() {
    let [a, b] = [turn(1.0, 2.0, -0.5), turn(-0.3, 0.9, 0.4)].map(Spatial::rotation_matrix);
    let f = a * Matrix3::from_diagonal(&Vector3::new(1.3, 0.6, 0.9)) * b;
    let [largest, smallest] = Spatial::squared_stretches(&f);
    assert!((largest - 1.69).abs() < 1e-13 && (smallest - 0.36).abs() < 1e-13);
}

#[test]
fn what_a_surface_or_a_row_does_not_know_turns_with_it() {
    let f: Matrix3<f64> = Matrix3::new(1.2, 0.3, -0.1, 0.05, 0.8, 0.2, -0.2, 0.1, 1.1);
    let normal = Vector3::new(2.0, -1.0, 2.0) / 3.0;
    let known = f * (Matrix3::identity() - normal * normal.transpose());
    let whole = Spatial::completed(known, &Span::Surface { normal, moment: 1.0 });
    let present = whole * normal;
    assert!((present.norm() - 1.0).abs() < 1e-14);
    for along in [Vector3::new(1.0, 2.0, 0.0), Vector3::new(0.0, 2.0, 1.0)] {
        assert!(along.dot(&normal).abs() < 1e-15);
        assert!((whole * along - f * along).norm() < 1e-14);
        assert!(present.dot(&(whole * along)).abs() < 1e-14);
    }
    assert!(whole.determinant() > 0.0);
    let line = Vector3::new(1.0, 2.0, -2.0) / 3.0;
    for row in [f, -Matrix3::identity()] {
        let known = row * line * line.transpose();
        let whole = Spatial::completed(known, &Span::Line { direction: line, moment: 1.0 });
        let stretch = (row * line).norm();
        assert!((whole * line - row * line).norm() < 1e-14);
        // A rotation but for the stretch along the row.
        let rotation = whole * (Matrix3::identity() + line * line.transpose() * (1.0 / stretch - 1.0));
        assert!((rotation.transpose() * rotation - Matrix3::identity()).norm() < 1e-13);
        assert!((rotation.determinant() - 1.0).abs() < 1e-13);
    }
}

#[test]
fn a_moment_knows_its_directions() {
    let r = Spatial::rotation_matrix(turn(1.0, 2.0, -0.5));
    let of = |values: [f64; 3]| Spatial::span(&(r * Matrix3::from_diagonal(&values.into()) * r.transpose()));
    assert!(matches!(of([1.0, 0.5, 0.1]), Span::All));
    assert!(matches!(of([0.0; 3]), Span::None));
    let Span::Surface { normal, moment } = of([1.0, 0.0, 0.5]) else { panic!("a surface") };
    assert!(normal.cross(&(r * Vector3::y())).norm() < 1e-12 && (moment - 1.5).abs() < 1e-12);
    let Span::Line { direction, moment } = of([0.0, 0.0, 0.5]) else { panic!("a line") };
    assert!(direction.cross(&(r * Vector3::z())).norm() < 1e-12 && (moment - 0.5).abs() < 1e-12);
}

#[test]
fn a_face_is_half_a_side_away() {
    assert!(
        (Spatial::to_face(&Vector3::new(0.0, -4e-4, 0.0)) - Vector3::new(0.0, -0.01, 0.0)).norm() < 1e-17
    );
    assert_eq!(Spatial::to_face(&Vector3::zeros()), Vector3::zeros());
}

#[test]
fn a_slide_turns_with_its_face_and_keeps_its_length() {
    let slide = Vector3::new(1e-5, 0.0, 2e-5);
    let face = Spatial::face(&Vector3::new(0.1, -3.0, 0.2));
    let turned = Spatial::turned_slide(&face, slide);
    assert!(turned.dot(&face).abs() < 1e-20 && (turned.norm() / slide.norm() - 1.0).abs() < 1e-14);
    assert!((turned - slide).norm() < 0.1 * slide.norm());
    assert_eq!(Spatial::turned_slide(&face, Vector3::zeros()), Vector3::zeros());
}
