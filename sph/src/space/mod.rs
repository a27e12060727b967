//! Space: vectors and tensors, the domain and its periodic directions.
//!
//! Laws, neighbours, the interface and solvers are written over [`Space`]. The types without a parameter are those of the
//! plane, for code that is of the plane still: case files, set-ups, outputs.

pub mod algebra;
mod any;
pub mod components;
pub mod domain;
pub mod geometry;
pub mod plane;
pub mod spatial;
pub mod tensors;

use std::fmt::Debug;

use algebra::Algebra;
pub use any::{AnySpace, SomeSpace};
use components::Components;
pub use plane::{Plane, SymmetricTensor};
pub use spatial::{Spatial, SymmetricTensor3};
use tensors::{Linear, SpaceSymmetric, SpaceTensor, SpaceVector, Value};

use crate::lanes::{Lanes, WIDTH};

/// Number of dimensions of the plane.
pub const DIMENSIONS: usize = Plane::DIMENSIONS;

/// Names of the axes.
pub const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

/// A vector of the plane; component 0 is x, component 1 is y (up).
pub type Vector = nalgebra::Vector2<f64>;

/// A full second-order tensor of the plane, row = first index.
pub type Tensor = nalgebra::Matrix2<f64>;

mod sealed {
    pub trait Sealed {}

    impl Sealed for super::Plane {}

    impl Sealed for super::Spatial {}
}

/// A space that runs can be computed in.
pub trait Space:
    sealed::Sealed + Algebra + Copy + Default + Debug + PartialEq + Eq + Send + Sync + 'static
{
    /// Number of dimensions.
    const DIMENSIONS: usize;

    /// A vector.
    type Vector: SpaceVector;
    /// A second-order tensor, row = first index.
    type Tensor: SpaceTensor<Self::Vector>;
    /// A symmetric second-order tensor.
    type SymmetricTensor: SpaceSymmetric<Self::Vector, Self::Tensor>;
    /// One value for each axis, such as a text, that need not be copied.
    type PerAxis<T: Clone + Debug + PartialEq + Send + Sync + 'static>: Clone
        + Debug
        + PartialEq
        + AsRef<[T]>
        + Send
        + Sync;
    /// An angular velocity, a torque or an angular momentum.
    type Spin: Linear + Components;
    /// The orientation of a body.
    type Rotation: Value + Components;

    /// `value` of each axis.
    fn per_axis<T: Clone + Debug + PartialEq + Send + Sync + 'static>(
        value: impl FnMut(usize) -> T,
    ) -> Self::PerAxis<T>;

    /// `factor` over the integral of the unscaled kernel in units of h, see [`crate::kernel::shape::Spline`].
    fn kernel_normalised(factor: f64) -> f64;

    /// Volume of the cell of a particle in a lattice of `spacing` \[m\]: Δx² per depth in the plane.
    fn cell_volume(spacing: f64) -> f64;

    /// Moment of inertia of the cell of a particle of this mass and density about its own centre and any axis, m a²/6 \[kg m²\]:
    /// of a square of area a² = V in the plane, of a cube in space.
    fn cell_inertia(mass: f64, density: f64) -> f64;

    /// a × b.
    fn cross(a: &Self::Vector, b: &Self::Vector) -> Self::Spin;

    /// ω × r.
    fn spin_cross(spin: Self::Spin, arm: &Self::Vector) -> Self::Vector;

    /// ω × (ω × r).
    fn centripetal(spin: Self::Spin, arm: &Self::Vector) -> Self::Vector;

    /// `rotation` after `duration` \[s\] at angular velocity `spin`.
    fn rotated(rotation: Self::Rotation, spin: Self::Spin, duration: f64) -> Self::Rotation;

    /// R such that R·v is the vector `v` after the rotation.
    fn rotation_matrix(rotation: Self::Rotation) -> Self::Tensor;

    /// The vector of `components`.
    fn vector(components: Self::Of<f64>) -> Self::Vector;

    /// The components of `vector`.
    fn components(vector: &Self::Vector) -> Self::Of<f64>;

    /// The tensor of `components`.
    fn symmetric_tensor(components: Self::Symmetric<f64>) -> Self::SymmetricTensor;

    /// The components of `tensor`.
    fn symmetric_components(tensor: &Self::SymmetricTensor) -> Self::Symmetric<f64>;

    /// The tensor of `components`.
    fn tensor(components: Self::Matrix<f64>) -> Self::Tensor;

    /// The components of `tensor`.
    fn tensor_components(tensor: &Self::Tensor) -> Self::Matrix<f64>;

    /// `vector` in each lane.
    fn splat_vector<L: Lanes>(vector: &Self::Vector) -> Self::Of<L>;

    /// A vector for each lane.
    fn lanes<L: Lanes>(vectors: [&Self::Vector; WIDTH]) -> Self::Of<L>;

    /// A tensor for each lane.
    fn tensor_lanes<L: Lanes>(tensors: [&Self::Matrix<f64>; WIDTH]) -> Self::Matrix<L>;

    /// A symmetric tensor for each lane, of their components.
    fn symmetric_component_lanes<L: Lanes>(tensors: [&Self::Symmetric<f64>; WIDTH]) -> Self::Symmetric<L>;

    /// A symmetric tensor for each lane.
    fn symmetric_lanes<L: Lanes>(tensors: [&Self::SymmetricTensor; WIDTH]) -> Self::Symmetric<L>;

    /// Two vectors of each lane.
    fn vector_pairs<L: Lanes>(a: Self::Of<L>, b: Self::Of<L>) -> [[Self::Vector; 2]; WIDTH];

    /// Sum over the lanes of a spin.
    fn spin_sum<L: Lanes>(a: Self::SpinOf<L>) -> Self::Spin;

    /// Sums over the lanes of a vector and of two numbers.
    fn sums_with<L: Lanes>(a: Self::Of<L>, numbers: [L; 2]) -> (Self::Of<f64>, [f64; 2]);

    /// Sums over the lanes of two vectors.
    fn vector_sums<L: Lanes>(a: Self::Of<L>, b: Self::Of<L>) -> [Self::Of<f64>; 2];

    /// Sum over the lanes of a tensor.
    fn matrix_sums<L: Lanes>(m: Self::Matrix<L>) -> Self::Matrix<f64>;

    /// Sum over the lanes of a symmetric tensor.
    fn symmetric_sums<L: Lanes>(m: Self::Symmetric<L>) -> Self::Symmetric<f64>;
}

/// z component of `a × b`.
#[inline]
pub fn cross(a: &Vector, b: &Vector) -> f64 {
    Plane::cross(a, b)
}
