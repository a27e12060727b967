//! How particles are laid out, as a case file writes it.

use crate::case::reader::{Choice, Table};

/// How the particles of a shape are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// On the lattice where all faces lie between two of its rows, else as the owner says.
    Auto,
    /// In layers along the faces.
    Fitted,
    /// On the lattice: faces that do not run along it become staircases.
    Lattice,
}

impl Layout {
    /// Reads `layout`.
    pub(super) fn read(table: &mut Table<'_>) -> Choice<Self> {
        table.choice_or_first(
            "layout",
            &[("auto", Self::Auto), ("fitted", Self::Fitted), ("lattice", Self::Lattice)],
        )
    }
}
