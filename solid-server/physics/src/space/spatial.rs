//! What the solid needs of space.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use sph::lanes::Real;
use sph::prescribed::motion::MotionState;
use sph::space::tensors::{SpaceSymmetric, SpaceTensor};
use sph::space::{Space, Spatial, SymmetricTensor3};
use sph::sums::ordered_sum;

use super::{COAST_ROUNDS, SINGULAR, SMALLEST_INERTIA, SolidSpace, Span};

/// The matrix of v ↦ a × v.
fn cross_matrix(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// `rotation` or its opposite quaternion, which is the same rotation, whichever is nearer to `near`.
fn nearest_sign(rotation: UnitQuaternion<f64>, near: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    if rotation.coords.dot(&near.coords) < 0.0 {
        UnitQuaternion::new_unchecked(-rotation.into_inner())
    } else {
        rotation
    }
}

/// The rotation of a matrix that is one to round-off.
fn rotation_of(matrix: Matrix3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
}

/// The least rotation from the direction of the unit vector `a` to that of `b`.
fn least_rotation(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    let (axis, cosine) = (a.cross(b), a.dot(b));
    if 1.0 + cosine > SINGULAR {
        let turn = cross_matrix(&axis);
        return Matrix3::identity() + turn + turn * turn / (1.0 + cosine);
    }
    // Half a turn about any axis across.
    let across = a.cross(&Vector3::ith(a.iamin(), 1.0)).normalize();
    across * across.transpose() * 2.0 - Matrix3::identity()
}

/// Inertia of a body turned by `rotation`.
fn turned(inertia: &Matrix3<f64>, rotation: UnitQuaternion<f64>) -> Matrix3<f64> {
    let r = Spatial::rotation_matrix(rotation);
    r * inertia * r.transpose()
}

/// I⁻¹ L.
fn solved(inertia: &Matrix3<f64>, angular_momentum: &Vector3<f64>) -> Vector3<f64> {
    SpaceTensor::cofactor(inertia) * angular_momentum / inertia.determinant()
}

impl SolidSpace for Spatial {
    /// \[kg m²\].
    type Inertia = Matrix3<f64>;

    type Slide = Vector3<f64>;

    #[inline]
    fn point_inertia(mass: f64, arm: &Vector3<f64>) -> Matrix3<f64> {
        (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * mass
    }

    /// m a²/6 I of a cube.
    #[inline]
    fn cell_inertia(mass: f64, density: f64) -> Matrix3<f64> {
        let side = (mass / density).cbrt();
        Matrix3::identity() * (mass * side * side / 6.0)
    }

    fn body_inertia(mass: f64, moments: &SymmetricTensor3) -> Matrix3<f64> {
        let trace = moments.xx + moments.yy + moments.zz;
        (Matrix3::identity() * trace - moments.full()) * mass
    }

    #[inline]
    fn angular_momentum(inertia: Matrix3<f64>, spin: Vector3<f64>) -> Vector3<f64> {
        inertia * spin
    }

    #[inline]
    fn angular_velocity(inertia: Matrix3<f64>, angular_momentum: Vector3<f64>) -> Vector3<f64> {
        solved(&inertia, &angular_momentum)
    }

    fn smallest_inertia(inertia: Matrix3<f64>) -> f64 {
        SymmetricTensor3::of(&inertia).extremes()[1]
    }

    fn described_spin(
        inertia: Matrix3<f64>,
        total: Matrix3<f64>,
        angular_momentum: Vector3<f64>,
    ) -> Vector3<f64> {
        let bound = SMALLEST_INERTIA * total.trace();
        let inverse = SymmetricTensor3::of(&inertia)
            .map_principal(|moment| if moment > bound { 1.0 / moment } else { 0.0 });
        inverse.dot(&angular_momentum)
    }

    fn spin_after(
        inertia: Matrix3<f64>,
        [from, to]: [UnitQuaternion<f64>; 2],
        spin: Vector3<f64>,
        torque: Vector3<f64>,
        duration: f64,
    ) -> Vector3<f64> {
        let angular_momentum = turned(&inertia, from) * spin + torque * duration;
        solved(&turned(&inertia, to), &angular_momentum)
    }

    fn coasted(
        inertia: Matrix3<f64>,
        rotation: UnitQuaternion<f64>,
        spin: Vector3<f64>,
        duration: f64,
    ) -> (UnitQuaternion<f64>, Vector3<f64>) {
        let angular_momentum = turned(&inertia, rotation) * spin;
        let at = |rotation| solved(&turned(&inertia, rotation), &angular_momentum);
        let mut mean = spin;
        for _ in 0..COAST_ROUNDS {
            let before = mean;
            mean = at(Self::rotated(rotation, mean, 0.5 * duration));
            if (mean - before).norm() <= f64::EPSILON * mean.norm() {
                break;
            }
        }
        let rotation = Self::rotated(rotation, mean, duration);
        (rotation, at(rotation))
    }

    fn angular_gain(
        inertia: Matrix3<f64>,
        (rotation_from, from): (UnitQuaternion<f64>, Vector3<f64>),
        (rotation_to, to): (UnitQuaternion<f64>, Vector3<f64>),
    ) -> Vector3<f64> {
        turned(&inertia, rotation_to) * to - turned(&inertia, rotation_from) * from
    }

    /// The face of a cube is as far from the middle as half its side.
    fn to_face(area: &Vector3<f64>) -> Vector3<f64> {
        let side = area.norm().sqrt();
        if side > 0.0 { area * (0.5 / side) } else { Vector3::zeros() }
    }

    /// By singular values; of particles on one line the turn about it is that of `near`.
    fn best_fit_rotation(
        count: usize,
        particle: impl Fn(usize) -> (f64, Vector3<f64>, Vector3<f64>) + Sync,
        near: UnitQuaternion<f64>,
    ) -> UnitQuaternion<f64> {
        let moment: Matrix3<f64> = ordered_sum(count, |k| {
            let (mass, before, after) = particle(k);
            after * before.transpose() * mass
        });
        let svd = moment.svd(true, true);
        let (Some(left), Some(right)) = (svd.u, svd.v_t) else { return near };
        let (values, mut weights) = (svd.singular_values, Vector3::repeat(1.0));
        let (largest, smallest) = (values.imax(), values.imin());
        let middle = 3 - largest - smallest;
        if values[largest] <= 0.0 || largest == smallest {
            return near;
        }
        if values[middle] <= SINGULAR * values[largest] {
            let before = Self::rotation_matrix(near) * right.row(largest).transpose();
            let turn = least_rotation(&before, &left.column(largest).into_owned());
            return nearest_sign(rotation_of(turn) * near, &near);
        }
        if (left * right).determinant() < 0.0 {
            weights[smallest] = -1.0;
        }
        nearest_sign(rotation_of(left * Matrix3::from_diagonal(&weights) * right), &near)
    }

    fn rotation_between(
        then: &MotionState<Self>,
        now: &MotionState<Self>,
        near: UnitQuaternion<f64>,
    ) -> UnitQuaternion<f64> {
        let axes = |motion: &MotionState<Self>| {
            Matrix3::from_columns(
                &[Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| motion.rotate(&axis)),
            )
        };
        nearest_sign(rotation_of(axes(now) * axes(then).transpose()), &near)
    }

    /// Half of Σ e × (ω × e) over three axes e.
    fn spin_of(motion: &MotionState<Self>, origin: &Vector3<f64>) -> Vector3<f64> {
        let of_axis = |axis: Vector3<f64>| {
            let tip = origin + axis;
            let arm = motion.position(&tip) - motion.position(origin);
            arm.cross(&(motion.velocity(&tip) - motion.velocity(origin)))
        };
        (of_axis(Vector3::x()) + of_axis(Vector3::y()) + of_axis(Vector3::z())) * 0.5
    }

    fn wendland_weight(spacing: f64, support: f64) -> f64 {
        (spacing / support).powi(3) * 21.0 / (2.0 * PI)
    }

    /// `phase` along both axes of the face.
    fn over_half_space(
        reach: f64,
        phase: f64,
        height: f64,
        spacing: f64,
        weight: impl Fn(f64) -> f64,
    ) -> f64 {
        let reach = reach.ceil();
        let steps = || (0..).map(|k| f64::from(k) - reach - 1.0).take_while(|k| *k <= reach + 1.0);
        let at = |column: f64, file: f64, row: f64| {
            let along = |step: f64| (phase - step) * spacing;
            weight(Vector3::new(along(column), height + row * spacing, along(file)).norm())
        };
        let of_column = |row, column| steps().map(|file| at(column, file, row)).sum::<f64>();
        let of_row = |row: f64| steps().map(|column| of_column(row, column)).sum::<f64>();
        steps().filter(|row| *row >= 0.0).map(of_row).sum()
    }

    #[inline]
    fn face_over_side(spacing: f64) -> f64 {
        spacing
    }

    #[inline]
    fn face(gradient: &Vector3<f64>) -> Vector3<f64> {
        gradient / gradient.norm()
    }

    #[inline]
    fn along(face: &Vector3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
        v - face * face.dot(v)
    }

    fn turned_slide(face: &Vector3<f64>, slide: Vector3<f64>) -> Vector3<f64> {
        let along = Self::along(face, &slide);
        let length = along.norm();
        if length > 0.0 { along * (slide.norm() / length) } else { Vector3::zeros() }
    }

    #[inline]
    fn capped_slide(slide: Vector3<f64>, largest: f64) -> Vector3<f64> {
        slide.cap_magnitude(largest)
    }

    #[inline]
    fn slide_vector(_face: &Vector3<f64>, slide: Vector3<f64>) -> Vector3<f64> {
        slide
    }

    #[inline(always)]
    fn plus_matrix_times<R: Real>([x, y, z]: [R; 3], m: [R; 9], [b_x, b_y, b_z]: [R; 3]) -> [R; 3] {
        [
            x.plus_product(m[0], b_x).plus_product(m[1], b_y).plus_product(m[2], b_z),
            y.plus_product(m[3], b_x).plus_product(m[4], b_y).plus_product(m[5], b_z),
            z.plus_product(m[6], b_x).plus_product(m[7], b_y).plus_product(m[8], b_z),
        ]
    }

    /// A surface keeps its thickness along its present normal, a line its section across its present direction.
    #[inline]
    fn completed(known: Matrix3<f64>, span: &Span<Vector3<f64>>) -> Matrix3<f64> {
        match span {
            Span::All => known,
            Span::None => Matrix3::identity(),
            Span::Surface { normal, .. } => {
                let present = SpaceTensor::cofactor(&known) * normal;
                known + present * normal.transpose() / present.norm()
            }
            Span::Line { direction: line, .. } => {
                let along = known * line;
                let turn = least_rotation(line, &(along / along.norm()));
                known + turn * (Matrix3::identity() - line * line.transpose())
            }
        }
    }

    fn span(moment: &Matrix3<f64>) -> Span<Vector3<f64>> {
        let principal = SymmetricTensor3::of(moment).principal();
        let [major, middle, minor] = principal.values;
        if major <= 0.0 {
            Span::None
        } else if minor > SINGULAR * major {
            Span::All
        } else if middle > SINGULAR * major {
            Span::Surface { normal: principal.directions[2], moment: major + middle }
        } else {
            Span::Line { direction: principal.directions[0], moment: major }
        }
    }

    #[inline]
    fn corotation(l: &Matrix3<f64>, s: &SymmetricTensor3) -> SymmetricTensor3 {
        let spin = (l - l.transpose()) * 0.5;
        let turning = spin * s.full();
        SymmetricTensor3::of(&(turning + turning.transpose()))
    }

    #[inline]
    fn squared_deviator(s: &SymmetricTensor3) -> f64 {
        s.xx * s.xx + s.yy * s.yy + s.zz * s.zz + 2.0 * (s.xy * s.xy + s.yz * s.yz + s.xz * s.xz)
    }

    fn shear_measure(f: &Matrix3<f64>) -> f64 {
        // tr B − ln det(I + B) of B = FᵀF − I, det(I + B) = 1 + g, g = tr B + ½(tr² B − B:B) + det B.
        let b = f.transpose() * f - Matrix3::identity();
        let trace = b.trace();
        let rest = 0.5 * (trace * trace - b.norm_squared()) + b.determinant();
        let growth = trace + rest;
        growth - growth.ln_1p() - rest
    }

    fn squared_stretches(f: &Matrix3<f64>) -> [f64; 2] {
        let [largest, middle, _] = SymmetricTensor3::of(&(f.transpose() * f)).principal_values();
        let jacobian = f.determinant();
        [largest, jacobian * jacobian / (largest * middle)]
    }
}

#[cfg(test)]
mod tests;
