//! What the solid needs of a space beyond `sph`.

use std::f64::consts::PI;

use sph::lanes::Real;
use sph::prescribed::motion::MotionState;
use sph::space::tensors::{Linear, SpaceSymmetric};
use sph::space::{Plane, Space};
use sph::sums::ordered_sum;

use crate::thresholds::Thresholds;

sph::constants! {
    const SINGULAR: f64 = 1e-6, "solid.correction.singular",
        "ratio of the eigenvalues of a moment matrix below which all neighbours count as lying on one line [-]";
    const SMALLEST_INERTIA: f64 = 1e-9, "solid.rigid.smallest_inertia",
        "share of sum m |r|^2 in the moment of inertia above which it is no round-off [-]";
}

/// `angle` plus whole turns, as near as possible to `near` \[rad\].
pub fn nearest_branch(angle: f64, near: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle + turn * ((near - angle) / turn).round()
}

/// The directions in which a particle has neighbours.
#[derive(Clone, Copy, Debug)]
pub enum Span<V> {
    /// All of them.
    All,
    /// One line.
    Line {
        /// Unit vector along it.
        direction: V,
        /// Σ a X² along it \[m²\].
        moment: f64,
    },
    /// No neighbours.
    None,
}

/// A space in which solids are computed.
pub trait SolidSpace: Thresholds {
    /// Number of axes that the space leaves out: they are not strained, and their normal stress is implied \[-\].
    const IMPLIED_AXES: f64 = 3.0 - Self::DIMENSIONS as f64;

    /// Moment of inertia of a body about its centre of mass.
    type Inertia: Linear;

    /// Moment of inertia of a particle of `mass` at `arm` \[m\] from the centre.
    fn point_inertia(mass: f64, arm: &Self::Vector) -> Self::Inertia;

    /// Moment of inertia about its own centre of the cell of a particle.
    fn cell_inertia(mass: f64, density: f64) -> Self::Inertia;

    /// Moment of inertia about its centre of a body of `mass` and the second moments `moments` \[m²\] about it.
    fn body_inertia(mass: f64, moments: &Self::SymmetricTensor) -> Self::Inertia;

    /// Angular momentum of a body at angular velocity `spin`.
    fn angular_momentum(inertia: Self::Inertia, spin: Self::Spin) -> Self::Spin;

    /// Angular velocity of a body of this angular momentum.
    fn angular_velocity(inertia: Self::Inertia, angular_momentum: Self::Spin) -> Self::Spin;

    /// Whether `inertia` is no round-off of `total`: not that of the place of a single particle.
    fn is_extended(inertia: Self::Inertia, total: Self::Inertia) -> bool;

    /// From the middle of a cell to its face of the area vector `area`.
    fn to_face(area: &Self::Vector) -> Self::Vector;

    /// The rotation nearest to `near` that best fits `count` particles, each of the mass, the place before and the place
    /// after that `particle` gives, places about the centre of mass: the polar part of Σ m x_after ⊗ x_before.
    fn best_fit_rotation(
        count: usize,
        particle: impl Fn(usize) -> (f64, Self::Vector, Self::Vector) + Sync,
        near: Self::Rotation,
    ) -> Self::Rotation;

    /// Rotation from `then` to `now`, as near as possible to `near`.
    fn rotation_between(
        then: &MotionState<Self>,
        now: &MotionState<Self>,
        near: Self::Rotation,
    ) -> Self::Rotation;

    /// Angular velocity of a prescribed motion that carries the point `origin` \[m\].
    fn spin_of(motion: &MotionState<Self>, origin: &Self::Vector) -> Self::Spin;

    /// Volume of a lattice cell of `spacing` \[m\] over the integral of (1 − q)⁴ (1 + 4q), q = r/H, for the radius H
    /// `support` \[m\] (Wendland C²).
    fn wendland_weight(spacing: f64, support: f64) -> f64;

    /// Sum of `weight` of the distance \[m\] over the particles of a half-space of lattice `spacing` \[m\] within `reach`
    /// spacings, at `height` \[m\] over the outer row, `phase` spacings along it.
    fn over_half_space(reach: f64, phase: f64, height: f64, spacing: f64, weight: impl Fn(f64) -> f64)
    -> f64;

    /// Unit vector across `gradient` in which a contact sticks.
    fn tangent(gradient: &Self::Vector) -> Self::Vector;

    /// a + m·b, column by column by [`Real::plus_product`].
    fn plus_matrix_times<R: Real>(a: Self::Of<R>, m: Self::Matrix<R>, b: Self::Of<R>) -> Self::Of<R>;

    /// F \[-\] of the deformation gradient `known` along the axes of `span`: along the others the material turns with the
    /// rest and is not strained.
    fn completed(known: Self::Tensor, span: &Span<Self::Vector>) -> Self::Tensor;

    /// The directions that a moment matrix Σ a X ⊗ X knows.
    fn span(moment: &Self::Tensor) -> Span<Self::Vector>;

    /// Displacement of particle `i` of a lattice, in alternation: near the stiffest modes.
    fn checkerboard(i: usize) -> Self::Vector;

    /// The spin terms s·ωᵀ + ω·s of Eq. (7) \[Pa/s\] of the deviatoric stress `s` \[Pa\] under `velocity_gradient` \[1/s\].
    fn corotation(velocity_gradient: &Self::Tensor, s: &Self::SymmetricTensor) -> Self::SymmetricTensor;

    /// s : s \[Pa²\] of a deviatoric stress, implied components included.
    fn squared_deviator(s: &Self::SymmetricTensor) -> f64;

    /// tr(FᵀF) − D − 2 ln J \[-\] of the deformation gradient `f` in D dimensions, without cancellation at small strains.
    fn shear_measure(f: &Self::Tensor) -> f64;

    /// Squares of the largest and the smallest principal stretch of the deformation gradient `f` \[-\].
    fn squared_stretches(f: &Self::Tensor) -> [f64; 2];
}

impl SolidSpace for Plane {
    /// Per depth \[kg m\].
    type Inertia = f64;

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

    fn is_extended(inertia: f64, total: f64) -> bool {
        inertia > SMALLEST_INERTIA * total
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
    fn tangent(gradient: &Self::Vector) -> Self::Vector {
        Self::spin_cross(1.0, gradient) / gradient.norm()
    }

    #[inline(always)]
    fn plus_matrix_times<R: Real>([x, y]: [R; 2], m: [R; 4], [b_x, b_y]: [R; 2]) -> [R; 2] {
        [x.plus_product(m[0], b_x).plus_product(m[1], b_y), y.plus_product(m[2], b_x).plus_product(m[3], b_y)]
    }

    #[inline]
    fn completed(known: Self::Tensor, span: &Span<Self::Vector>) -> Self::Tensor {
        match span {
            Span::All => known,
            Span::None => Self::Tensor::identity(),
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

    fn checkerboard(i: usize) -> Self::Vector {
        let phase = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        Self::Vector::new(phase, 0.7 * phase + 0.01 * (i % 7) as f64)
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
