//! How far from its own cells a part holds copies.

/// Which copies: those within so many cells of what a part owns, each wider than the reach of neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reach {
    /// That of neighbours of own particles.
    Neighbours = 1,
    /// That of neighbours of walls that own particles meet, and of what may approach these.
    Walls = 2,
    /// That of what spreads on nodes which own particles read: two supports, and lists last until they may have
    /// approached by a spacing.
    Nodes = 3,
}

impl Reach {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Neighbours, Self::Walls, Self::Nodes];
    /// That of all copies.
    pub const FARTHEST: Self = Self::Nodes;

    /// Number of cells.
    pub fn rings(self) -> usize {
        self as usize
    }
}
