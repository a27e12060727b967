//! Values whose number of dimensions is known only when a run is opened.

use super::Spatial;

/// A value of the plane or of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnySpace<P, S> {
    /// Of the plane.
    Plane(P),
    /// Of space.
    Spatial(S),
}

/// The expression for a value of either space, which it calls `$name`.
///
/// ```
/// use sph::in_space;
/// use sph::space::{AnySpace, Plane, Space, Spatial};
/// fn dimensions<S: Space>(_: S) -> usize {
///     S::DIMENSIONS
/// }
/// let space: AnySpace<Plane, Spatial> = AnySpace::Spatial(Spatial);
/// assert_eq!(in_space!(space, space => dimensions(space)), 3);
/// ```
#[macro_export]
macro_rules! in_space {
    ($value:expr, $name:pat => $expression:expr) => {
        match $value {
            $crate::space::AnySpace::Plane($name) => $expression,
            $crate::space::AnySpace::Spatial($name) => $expression,
        }
    };
}

/// The same with the result wrapped in the space of the value.
#[macro_export]
macro_rules! map_space {
    ($value:expr, $name:pat => $expression:expr) => {
        match $value {
            $crate::space::AnySpace::Plane($name) => $crate::space::AnySpace::Plane($expression),
            $crate::space::AnySpace::Spatial($name) => $crate::space::AnySpace::Spatial($expression),
        }
    };
}

/// The spaces themselves.
pub type SomeSpace = AnySpace<super::Plane, Spatial>;

impl SomeSpace {
    /// The space of `dimensions` dimensions, 2 or 3.
    pub fn of_dimensions(dimensions: usize) -> Option<Self> {
        match dimensions {
            2 => Some(Self::Plane(super::Plane)),
            3 => Some(Self::Spatial(Spatial)),
            _ => None,
        }
    }
}

impl<P, S> AnySpace<P, S> {
    /// Number of dimensions.
    pub fn dimensions(&self) -> usize {
        match self {
            Self::Plane(_) => 2,
            Self::Spatial(_) => 3,
        }
    }

    /// The value of the plane; `None` of one of space.
    pub fn plane(self) -> Option<P> {
        match self {
            Self::Plane(value) => Some(value),
            Self::Spatial(_) => None,
        }
    }

    /// The value of space; `None` of one of the plane.
    pub fn spatial(self) -> Option<S> {
        match self {
            Self::Plane(_) => None,
            Self::Spatial(value) => Some(value),
        }
    }

    /// References to the value.
    pub fn as_ref(&self) -> AnySpace<&P, &S> {
        map_space!(self, value => value)
    }
}
