//! Quantities as columns and saved states hold them: so many numbers each.

/// A quantity of a fixed number of components.
pub trait Components: Copy {
    /// Number of components.
    const COUNT: usize;

    /// An array of the components.
    type Row: AsRef<[f64]> + AsMut<[f64]> + for<'a> TryFrom<&'a [f64]>;

    /// The components: those of a symmetric tensor are xx, yy, xy in the plane.
    fn row(self) -> Self::Row;

    /// The quantity of the components `row`.
    fn from_row(row: Self::Row) -> Self;

    /// The quantity of the components `row`; `None` if there are more or fewer of them.
    #[inline]
    fn of_row(row: &[f64]) -> Option<Self> {
        row.try_into().ok().map(Self::from_row)
    }
}

impl<const N: usize> Components for [f64; N] {
    const COUNT: usize = N;

    type Row = Self;

    #[inline]
    fn row(self) -> Self {
        self
    }

    #[inline]
    fn from_row(row: Self) -> Self {
        row
    }
}

impl Components for f64 {
    const COUNT: usize = 1;

    type Row = [f64; 1];

    #[inline]
    fn row(self) -> [f64; 1] {
        [self]
    }

    #[inline]
    fn from_row([number]: [f64; 1]) -> Self {
        number
    }
}
