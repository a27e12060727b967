//! How particles are laid out, as a case file writes it.

use crate::case::reader::{Choice, Table};
use crate::case::spec::{KeySpec, Kind, key};

/// Row of `layout`.
pub const LAYOUT: KeySpec = key(
    "layout",
    Kind::Word(&[
        (
            "auto",
            "on the lattice where all faces lie between two of its rows, else what suits the shape best, see \
             cases/FORMAT.md",
        ),
        ("fitted", "in layers along the faces"),
        ("lattice", "on the lattice: faces that do not run along it become staircases"),
    ]),
    "where the particles stand; the mass is that of the shape in every case",
)
.or_word("auto");

/// Row of `lattice_origin_m`.
pub const LATTICE_ORIGIN: KeySpec =
    key("lattice_origin_m", Kind::Vector, "a corner of a lattice of its own").or_else("the domain's lattice");

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
        table.choice_or_default(
            "layout",
            &[("auto", Self::Auto), ("fitted", Self::Fitted), ("lattice", Self::Lattice)],
        )
    }
}
