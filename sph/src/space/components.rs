//! Quantities as columns and saved states hold them: so many numbers each.

use nalgebra::Vector2;

use super::plane::SymmetricTensor;

/// A quantity of a fixed number of components.
pub trait Components: Copy {
    /// Number of components.
    const COUNT: usize;

    /// An array of the components.
    type Row: AsRef<[f64]>;

    /// The components: those of a symmetric tensor are xx, yy, xy in the plane.
    fn row(self) -> Self::Row;

    /// The quantity of the components `row`; `None` if there are more or fewer of them.
    fn of_row(row: &[f64]) -> Option<Self>;
}

impl<const N: usize> Components for [f64; N] {
    const COUNT: usize = N;

    type Row = Self;

    #[inline]
    fn row(self) -> Self {
        self
    }

    #[inline]
    fn of_row(row: &[f64]) -> Option<Self> {
        row.try_into().ok()
    }
}

/// Implements [`Components`] by conversions to and from an array.
macro_rules! components {
    ($type:ty, $count:literal, $row:expr, $of_row:expr) => {
        impl Components for $type {
            const COUNT: usize = $count;

            type Row = [f64; $count];

            #[inline]
            fn row(self) -> Self::Row {
                let row: fn(Self) -> Self::Row = $row;
                row(self)
            }

            #[inline]
            fn of_row(row: &[f64]) -> Option<Self> {
                let of_row: fn(Self::Row) -> Self = $of_row;
                row.try_into().ok().map(of_row)
            }
        }
    };
}

components!(f64, 1, |number| [number], |[number]| number);
components!(Vector2<f64>, 2, |vector| vector.into(), |row| row.into());
components!(SymmetricTensor, 3, |s| [s.xx, s.yy, s.xy], |[xx, yy, xy]| SymmetricTensor { xx, yy, xy });
