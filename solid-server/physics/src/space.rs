//! What the solid needs of a space beyond `sph`.

mod plane;
mod spatial;

use sph::lanes::Real;
use sph::prescribed::motion::MotionState;
use sph::space::components::Components;
use sph::space::tensors::Linear;

pub use plane::nearest_branch;

use crate::thresholds::Thresholds;

sph::constants! {
    const SINGULAR: f64 = 1e-6, "solid.correction.singular",
        "ratio of an eigenvalue of a moment matrix to the largest below which no neighbours count as lying that way [-]";
    const SMALLEST_INERTIA: f64 = 1e-9, "solid.rigid.smallest_inertia",
        "share of sum m |r|^2 in the moment of inertia above which it is no round-off [-]";
    /// The rule converges by a factor of the angle of a step per round; at a tenth of a radian 16 rounds reach round-off.
    const COAST_ROUNDS: usize = 32, "solid.rigid.coast_rounds",
        "most rounds by which the mean spin of a freely turning body is found in space [-]";
}

/// The directions in which a particle has neighbours.
#[derive(Clone, Copy, Debug)]
pub enum Span<V> {
    /// All of them.
    All,
    /// A surface in space.
    Surface {
        /// Its unit normal.
        normal: V,
        /// Σ a |X|² \[m²\].
        moment: f64,
    },
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

    /// A displacement along a face: a number in the plane, a vector in space.
    type Slide: Linear + Components;

    /// Moment of inertia of a particle of `mass` at `arm` \[m\] from the centre.
    fn point_inertia(mass: f64, arm: &Self::Vector) -> Self::Inertia;

    /// Moment of inertia about its own centre of the cell of a particle.
    fn cell_inertia(mass: f64, density: f64) -> Self::Inertia;

    /// Moment of inertia about its centre of a body of `mass` and the second moments `moments` \[m²\] about it.
    fn body_inertia(mass: f64, moments: &Self::SymmetricTensor) -> Self::Inertia;

    /// Angular momentum at angular velocity `spin` of a body of `inertia` as it stands.
    fn angular_momentum(inertia: Self::Inertia, spin: Self::Spin) -> Self::Spin;

    /// Angular velocity of a body of this angular momentum.
    fn angular_velocity(inertia: Self::Inertia, angular_momentum: Self::Spin) -> Self::Spin;

    /// The smallest principal moment.
    fn smallest_inertia(inertia: Self::Inertia) -> f64;

    /// Angular velocity of particles of the angular momentum Σ m r × v and of `inertia`, without the part about axes about
    /// which that is round-off of `total`: a single particle has none.
    fn described_spin(
        inertia: Self::Inertia,
        total: Self::Inertia,
        angular_momentum: Self::Spin,
    ) -> Self::Spin;

    /// Angular velocity after `torque` for `duration` \[s\] of a body that turned from the first to the second of `rotations`,
    /// of `inertia` without rotation.
    ///
    /// ```text
    /// ω' = I'⁻¹ (I ω + τ Δt),  I = R I₀ Rᵀ
    /// ```
    fn spin_after(
        inertia: Self::Inertia,
        rotations: [Self::Rotation; 2],
        spin: Self::Spin,
        torque: Self::Spin,
        duration: f64,
    ) -> Self::Spin;

    /// Rotation and angular velocity after `duration` \[s\] without torque, of second order in time, and the same back in time.
    ///
    /// In space by the implicit midpoint rule, which keeps the angular momentum L:
    ///
    /// ```text
    /// R' = exp(ω̄ Δt) R,  ω̄ = Ī⁻¹ L,  Ī that of exp(½ ω̄ Δt) R
    /// ```
    fn coasted(
        inertia: Self::Inertia,
        rotation: Self::Rotation,
        spin: Self::Spin,
        duration: f64,
    ) -> (Self::Rotation, Self::Spin);

    /// Change of the angular momentum between two rotations and angular velocities of a body of `inertia` without rotation.
    fn angular_gain(
        inertia: Self::Inertia,
        from: (Self::Rotation, Self::Spin),
        to: (Self::Rotation, Self::Spin),
    ) -> Self::Spin;

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

    /// Area of the face of a cell over its side `spacing` \[m\]: 1 per depth in the plane.
    fn face_over_side(spacing: f64) -> f64;

    /// The face across `gradient`: a unit vector along it in the plane, its unit normal in space.
    fn face(gradient: &Self::Vector) -> Self::Vector;

    /// The part of `v` along `face`.
    fn along(face: &Self::Vector, v: &Self::Vector) -> Self::Slide;

    /// `slide` along a face that has turned into `face` since, of the same length.
    fn turned_slide(face: &Self::Vector, slide: Self::Slide) -> Self::Slide;

    /// `slide` with a length of at most `largest`.
    fn capped_slide(slide: Self::Slide, largest: f64) -> Self::Slide;

    /// `slide` along `face` as a vector.
    fn slide_vector(face: &Self::Vector, slide: Self::Slide) -> Self::Vector;

    /// a + m·b, column by column by [`Real::plus_product`].
    fn plus_matrix_times<R: Real>(a: Self::Of<R>, m: Self::Matrix<R>, b: Self::Of<R>) -> Self::Of<R>;

    /// F \[-\] of the deformation gradient `known` along the axes of `span`: along the others the material turns with the
    /// rest and is not strained.
    fn completed(known: Self::Tensor, span: &Span<Self::Vector>) -> Self::Tensor;

    /// The directions that a moment matrix Σ a X ⊗ X knows.
    fn span(moment: &Self::Tensor) -> Span<Self::Vector>;

    /// The spin terms s·ωᵀ + ω·s of Eq. (7) \[Pa/s\] of the deviatoric stress `s` \[Pa\] under `velocity_gradient` \[1/s\].
    fn corotation(velocity_gradient: &Self::Tensor, s: &Self::SymmetricTensor) -> Self::SymmetricTensor;

    /// s : s \[Pa²\] of a deviatoric stress, implied components included.
    fn squared_deviator(s: &Self::SymmetricTensor) -> f64;

    /// tr(FᵀF) − D − 2 ln J \[-\] of the deformation gradient `f` in D dimensions, without cancellation at small strains.
    fn shear_measure(f: &Self::Tensor) -> f64;

    /// Squares of the largest and the smallest principal stretch of the deformation gradient `f` \[-\].
    fn squared_stretches(f: &Self::Tensor) -> [f64; 2];
}
