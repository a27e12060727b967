//! What the solid needs of the plane.

use std::f64::consts::PI;

use sph::lanes::Real;
use sph::prescribed::motion::MotionState;
use sph::space::tensors::SpaceSymmetric;
use sph::space::{Plane, Space};
use sph::sums::ordered_sum;

use super::{SINGULAR, SMALLEST_INERTIA, SolidSpace, Span};

/// `angle` plus whole turns, as near as possible to `near` \[rad\].
pub fn nearest_branch(angle: f64, near: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle + turn * ((near - angle) / turn).round()
}

impl SolidSpace for Plane {
    /// Per depth \[kg m\].
    type Inertia = f64;

    type Slide = f64;

    #[inline]
    fn point_inertia(mass: f64, arm: &Self::Vector) -> f64 {
        mass * arm.norm_squared()
    }

    /// m V/6 of a square: without it a block of 4 × 4 particles turns 6 % too easily.
    #[inline]
    fn cell_inertia(mass: f64, density: f64) -> f64 {
        mass * mass / (6.0 * density)
    }

    fn body_inertia(mass: f64, moments: &Self::SymmetricTensor) -> f64 {
        mass * (moments.xx + moments.yy)
    }

    #[inline]
    fn angular_momentum(inertia: f64, spin: f64) -> f64 {
        inertia * spin
    }

    #[inline]
    fn angular_velocity(inertia: f64, angular_momentum: f64) -> f64 {
        angular_momentum / inertia
    }

    #[inline]
    fn smallest_inertia(inertia: f64) -> f64 {
        inertia
    }

    fn described_spin(inertia: f64, total: f64, angular_momentum: f64) -> f64 {
        if inertia > SMALLEST_INERTIA * total { angular_momentum / inertia } else { 0.0 }
    }

    #[inline]
    fn spin_after(inertia: f64, _rotations: [f64; 2], spin: f64, torque: f64, duration: f64) -> f64 {
        spin + torque / inertia * duration
    }

    #[inline]
    fn coasted(_inertia: f64, rotation: f64, spin: f64, duration: f64) -> (f64, f64) {
        (Self::rotated(rotation, spin, duration), spin)
    }

    #[inline]
    fn angular_gain(inertia: f64, (_, from): (f64, f64), (_, to): (f64, f64)) -> f64 {
        inertia * (to - from)
    }

    /// The face of a square is as far from the middle as half its length.
    fn to_face(area: &Self::Vector) -> Self::Vector {
        area * 0.5
    }

    fn best_fit_rotation(
        count: usize,
        particle: impl Fn(usize) -> (f64, Self::Vector, Self::Vector) + Sync,
        near: f64,
    ) -> f64 {
        let sine: f64 = ordered_sum(count, |k| {
            let (mass, before, after) = particle(k);
            mass * Self::cross(&before, &after)
        });
        let cosine: f64 = ordered_sum(count, |k| {
            let (mass, before, after) = particle(k);
            mass * before.dot(&after)
        });
        nearest_branch(sine.atan2(cosine), near)
    }

    fn rotation_between(then: &MotionState<Self>, now: &MotionState<Self>, near: f64) -> f64 {
        let (then, now) = (then.rotate(&Self::Vector::x()), now.rotate(&Self::Vector::x()));
        nearest_branch(Self::cross(&then, &now).atan2(then.dot(&now)), near)
    }

    fn spin_of(motion: &MotionState<Self>, origin: &Self::Vector) -> f64 {
        let tip = origin + Self::Vector::x();
        let arm = motion.position(&tip) - motion.position(origin);
        Self::cross(&arm, &(motion.velocity(&tip) - motion.velocity(origin)))
    }

    fn wendland_weight(spacing: f64, support: f64) -> f64 {
        spacing * spacing * 7.0 / (PI * support * support)
    }

    fn over_half_space(
        reach: f64,
        phase: f64,
        height: f64,
        spacing: f64,
        weight: impl Fn(f64) -> f64,
    ) -> f64 {
        let reach = reach.ceil();
        let steps = || (0..).map(|k| f64::from(k) - reach - 1.0).take_while(|k| *k <= reach + 1.0);
        let at = |column: f64, row: f64| {
            weight(Self::Vector::new((phase - column) * spacing, height + row * spacing).norm())
        };
        let of_row = |row: f64| steps().map(|column| at(column, row)).sum::<f64>();
        steps().filter(|row| *row >= 0.0).map(of_row).sum()
    }

    #[inline]
    fn face_over_side(_spacing: f64) -> f64 {
        1.0
    }

    #[inline]
    fn face(gradient: &Self::Vector) -> Self::Vector {
        Self::spin_cross(1.0, gradient) / gradient.norm()
    }

    #[inline]
    fn along(face: &Self::Vector, v: &Self::Vector) -> f64 {
        face.dot(v)
    }

    #[inline]
    fn turned_slide(_face: &Self::Vector, slide: f64) -> f64 {
        slide
    }

    #[inline]
    fn capped_slide(slide: f64, largest: f64) -> f64 {
        slide.clamp(-largest, largest)
    }

    #[inline]
    fn slide_vector(face: &Self::Vector, slide: f64) -> Self::Vector {
        face * slide
    }

    #[inline(always)]
    fn plus_matrix_times<R: Real>([x, y]: [R; 2], m: [R; 4], [b_x, b_y]: [R; 2]) -> [R; 2] {
        [x.plus_product(m[0], b_x).plus_product(m[1], b_y), y.plus_product(m[2], b_x).plus_product(m[3], b_y)]
    }

    #[inline]
    fn completed(known: Self::Tensor, span: &Span<Self::Vector>) -> Self::Tensor {
        match span {
            Span::All => known,
            // No surface lies in the plane.
            Span::Surface { .. } | Span::None => Self::Tensor::identity(),
            Span::Line { direction: line, .. } => {
                let along = known * line;
                known + Self::spin_cross(1.0, &along) / along.norm() * Self::spin_cross(1.0, line).transpose()
            }
        }
    }

    fn span(moment: &Self::Tensor) -> Span<Self::Vector> {
        let symmetric = Self::SymmetricTensor { xx: moment[(0, 0)], yy: moment[(1, 1)], xy: moment[(0, 1)] };
        let [major, minor] = symmetric.extremes();
        if major <= 0.0 {
            Span::None
        } else if minor > SINGULAR * major {
            Span::All
        } else {
            Span::Line { direction: symmetric.major_direction(), moment: major }
        }
    }

    #[inline]
    fn corotation(l: &Self::Tensor, s: &Self::SymmetricTensor) -> Self::SymmetricTensor {
        let spin = 0.5 * (l[(0, 1)] - l[(1, 0)]);
        let turning = 2.0 * spin * s.xy;
        Self::SymmetricTensor { xx: turning, yy: -turning, xy: spin * (s.yy - s.xx) }
    }

    #[inline]
    fn squared_deviator(s: &Self::SymmetricTensor) -> f64 {
        let s_zz = -(s.xx + s.yy);
        s.xx * s.xx + s.yy * s.yy + s_zz * s_zz + 2.0 * s.xy * s.xy
    }

    fn shear_measure(f: &Self::Tensor) -> f64 {
        // tr(FᵀF) − 2J + 2(J − 1 − ln J).
        let (stretch, shear) = (f[(0, 0)] - f[(1, 1)], f[(0, 1)] + f[(1, 0)]);
        let growth = f.determinant() - 1.0;
        stretch * stretch + shear * shear + 2.0 * (growth - growth.ln_1p())
    }

    fn squared_stretches(f: &Self::Tensor) -> [f64; 2] {
        let (jacobian, sum) = (f.determinant(), f.norm_squared());
        let spread = (sum * sum - 4.0 * jacobian * jacobian).max(0.0).sqrt();
        let largest = 0.5 * (sum + spread);
        [largest, jacobian * jacobian / largest]
    }
}
